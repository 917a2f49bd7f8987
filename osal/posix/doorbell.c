// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/doorbell.h"

#include "base/assertion.h"
#include "osal/include/osal/clock.h"

#include <limits.h>
#include <linux/futex.h>
#include <sched.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_MS 1000000ULL
#define NS_PER_S 1000000000ULL

void osal_doorbell_create(osal_doorbell_t* const bell)
{
    FSW_ASSERT(bell != NULL);
    *bell = (osal_doorbell_t){0U, 0U, 0U};
}

/// Processor that the caller runs on, from 1; 0 if unknown.
static uint32_t processor(void)
{
    const int number = sched_getcpu();
    return (number < 0) ? 0U : ((uint32_t)number + 1U);
}

void osal_doorbell_ring(osal_doorbell_t* const bell)
{
    FSW_ASSERT(bell != NULL);
    // Sequentially consistent on both sides: either the ringer sees the waiter, or the waiter sees the ring.
    (void)__atomic_add_fetch(&bell->rings, 1U, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(&bell->waiters, __ATOMIC_SEQ_CST) > 0U) {
        __atomic_store_n(&bell->ringer, processor(), __ATOMIC_RELAXED);
        (void)syscall(SYS_futex, &bell->rings, FUTEX_WAKE, INT_MAX, NULL, NULL, 0);
    }
}

uint32_t osal_doorbell_rings(const osal_doorbell_t* const bell)
{
    FSW_ASSERT(bell != NULL);
    return __atomic_load_n(&bell->rings, __ATOMIC_ACQUIRE);
}

/// Sleep until a ring, at most for the rest of the time-out. False when the time is up.
static bool sleep_for_ring(osal_doorbell_t* const bell, const uint32_t seen, const uint64_t* const until_ns)
{
    struct timespec limit = {0, 0};
    if (until_ns != NULL) {
        const uint64_t now_ns = osal_clock_monotonic_ns();
        if (now_ns >= *until_ns) {
            return false;
        }
        limit.tv_sec  = (time_t)((*until_ns - now_ns) / NS_PER_S);
        limit.tv_nsec = (long)((*until_ns - now_ns) % NS_PER_S);
    }
    (void)syscall(SYS_futex, &bell->rings, FUTEX_WAIT, seen, (until_ns != NULL) ? &limit : NULL, NULL, 0);
    return true;
}

/// Look for a ring while the ringer, on another processor, may be about to ring. True if it rang.
static bool look_for_ring(const osal_doorbell_t* const bell, const uint32_t seen)
{
    const uint32_t ringer = __atomic_load_n(&bell->ringer, __ATOMIC_RELAXED);
    bool has_rung         = (__atomic_load_n(&bell->rings, __ATOMIC_ACQUIRE) != seen);
    if ((ringer == 0U) || (ringer == processor())) {
        return has_rung;
    }
    const uint64_t until_ns = osal_clock_monotonic_ns() + OSAL_DOORBELL_LOOK_NS;
    while (!has_rung && (osal_clock_monotonic_ns() < until_ns)) {
        has_rung = (__atomic_load_n(&bell->rings, __ATOMIC_ACQUIRE) != seen);
    }
    return has_rung;
}

status_t osal_doorbell_wait(osal_doorbell_t* const bell, const uint32_t seen, const uint32_t timeout_ms)
{
    FSW_ASSERT(bell != NULL);
    if ((timeout_ms > 0U) && look_for_ring(bell, seen)) {
        return STATUS_OK;
    }
    const bool is_limited   = (timeout_ms != UINT32_MAX);
    const uint64_t until_ns = is_limited ? (osal_clock_monotonic_ns() + (timeout_ms * NS_PER_MS)) : 0U;
    bool has_time           = true;
    (void)__atomic_add_fetch(&bell->waiters, 1U, __ATOMIC_SEQ_CST);
    while (has_time && (__atomic_load_n(&bell->rings, __ATOMIC_SEQ_CST) == seen)) {
        has_time = sleep_for_ring(bell, seen, is_limited ? &until_ns : NULL);
    }
    (void)__atomic_sub_fetch(&bell->waiters, 1U, __ATOMIC_SEQ_CST);
    return has_time ? STATUS_OK : STATUS_TIMEOUT;
}
