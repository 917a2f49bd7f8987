// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/event.h"

#include "base/assertion.h"
#include "osal/include/osal/clock.h"

#include <linux/futex.h>
#include <stddef.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_MS 1000000ULL
#define NS_PER_S 1000000000ULL

void osal_event_create(osal_event_t* const event)
{
    FSW_ASSERT(event != NULL);
    event->word = 0U;
}

void osal_event_signal(osal_event_t* const event)
{
    FSW_ASSERT(event != NULL);
    __atomic_store_n(&event->word, 1U, __ATOMIC_RELEASE);
    (void)syscall(SYS_futex, &event->word, FUTEX_WAKE, 1);
}

status_t osal_event_wait(osal_event_t* const event, const uint32_t timeout_ms)
{
    FSW_ASSERT(event != NULL);
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    while (__atomic_exchange_n(&event->word, 0U, __ATOMIC_ACQ_REL) == 0U) {
        struct timespec limit          = {0, 0};
        const struct timespec* allowed = NULL;
        if (timeout_ms != UINT32_MAX) {
            const uint64_t now_ns = osal_clock_monotonic_ns();
            if (now_ns >= until_ns) {
                return STATUS_TIMEOUT;
            }
            limit.tv_sec  = (time_t)((until_ns - now_ns) / NS_PER_S);
            limit.tv_nsec = (long)((until_ns - now_ns) % NS_PER_S);
            allowed       = &limit;
        }
        // The kernel sleeps only while the word is 0: a signal after the exchange is not lost.
        (void)syscall(SYS_futex, &event->word, FUTEX_WAIT, 0U, allowed);
    }
    return STATUS_OK;
}
