// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/clock.h"

#include "base/assertion.h"
#include "osal/include/osal/process.h"

#include <errno.h>
#include <poll.h>
#include <stdbool.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_S 1000000000ULL
#define SOCKETS_MAX OSAL_CLOCK_SOCKETS_MAX

static struct timespec timespec_of(const uint64_t time_ns)
{
    return (struct timespec){.tv_sec = (time_t)(time_ns / NS_PER_S), .tv_nsec = (long)(time_ns % NS_PER_S)};
}

/// Lock the pages of the program in memory. Pages mapped later are locked only if no limit applies: beyond
/// the limit, the kernel would refuse to map them.
static bool lock_memory(void)
{
    struct rlimit limit = {0, 0};
    const bool is_free =
        (geteuid() == 0U) || ((getrlimit(RLIMIT_MEMLOCK, &limit) == 0) && (limit.rlim_cur == RLIM_INFINITY));
    return (mlockall(is_free ? (MCL_CURRENT | MCL_FUTURE) : MCL_CURRENT) == 0);
}

void osal_clock_open_real(osal_clock_t* const clock, const uint64_t origin_ns)
{
    FSW_ASSERT(clock != NULL);
    *clock                  = (osal_clock_t){.mode = OSAL_CLOCK_REAL, .origin_ns = origin_ns};
    clock->is_memory_locked = lock_memory();
    (void)prctl(PR_SET_TIMERSLACK, 1UL); // Linux permits it to each thread.
}

uint64_t osal_clock_monotonic_ns(void)
{
    struct timespec now = {0, 0};
    const int result    = clock_gettime(CLOCK_MONOTONIC, &now);
    FSW_ASSERT(result == 0);
    return ((uint64_t)now.tv_sec * NS_PER_S) + (uint64_t)now.tv_nsec;
}

/// Sleep until a socket is readable, a stop signal arrives, or the absolute monotonic time is reached
/// (OSAL_CLOCK_NEVER: no limit).
static void poll_until(const uint64_t until_ns, osal_socket_t* const* const sockets,
                       const size_t socket_count)
{
    struct pollfd watched[SOCKETS_MAX + 1U];
    for (size_t i = 0U; i < socket_count; i++) {
        watched[i] = (struct pollfd){.fd = sockets[i]->descriptor, .events = POLLIN};
    }
    watched[socket_count] = (struct pollfd){.fd = osal_process_stop_descriptor(), .events = POLLIN};
    int ready             = 0;
    do {
        const uint64_t now_ns      = osal_clock_monotonic_ns();
        const struct timespec rest = timespec_of((until_ns > now_ns) ? (until_ns - now_ns) : 0U);
        ready =
            ppoll(watched, (nfds_t)(socket_count + 1U), (until_ns == OSAL_CLOCK_NEVER) ? NULL : &rest, NULL);
    } while ((ready < 0) && (errno == EINTR));
    if ((ready > 0) && (watched[socket_count].revents != 0)) {
        osal_process_take_stop();
    }
}

static void wait_real(const osal_clock_t* const clock, const uint64_t wake_ns,
                      osal_socket_t* const* const sockets, const size_t socket_count)
{
    const bool is_limited   = (wake_ns < (OSAL_CLOCK_NEVER - clock->origin_ns));
    const uint64_t until_ns = is_limited ? (clock->origin_ns + wake_ns) : OSAL_CLOCK_NEVER;
    if ((socket_count > 0U) || !is_limited || (osal_process_stop_descriptor() >= 0)) {
        poll_until(until_ns, sockets, socket_count);
        return;
    }
    const struct timespec until = timespec_of(until_ns);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) == EINTR) {
        // A signal interrupted the sleep: sleep again until the same absolute time.
    }
}

status_t osal_clock_wait(osal_clock_t* const clock, const uint64_t wake_ns,
                         osal_socket_t* const* const sockets, const size_t socket_count)
{
    FSW_ASSERT((clock != NULL) && (socket_count <= SOCKETS_MAX) &&
               ((sockets != NULL) || (socket_count == 0U)));
    if (clock->mode == OSAL_CLOCK_STEPPED) {
        FSW_ASSERT(clock->scheduler != NULL);
        return osal_lockstep_wait(clock->scheduler, clock->participant, clock->life, wake_ns, &clock->grant);
    }
    wait_real(clock, wake_ns, sockets, socket_count);
    return STATUS_OK;
}
