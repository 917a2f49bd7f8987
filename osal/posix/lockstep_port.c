// SPDX-License-Identifier: Apache-2.0
// Lock, wait and wake of the scheduler for processes: a robust mutex, and a futex for each participant.
#define _GNU_SOURCE
#include "osal/common/lockstep_core.h"

#include "osal/posix/process_state.h"

#include <limits.h>
#include <linux/futex.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

bool lockstep_port_prepare(osal_lockstep_t* const scheduler)
{
    return osal_mutex_create(&scheduler->mutex, true) == STATUS_OK;
}

/// True if the process has joined with a life of its own that has not ended.
static bool has_life(const osal_lockstep_t* const scheduler, const int32_t process)
{
    bool is_found = false;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        is_found = is_found || (scheduler->participants[i].process == process);
    }
    return is_found && (process != 0);
}

/// Returns the holder of the lock if a signal has stopped it and it may be killed; else 0.
static int32_t stopped_inside(const osal_lockstep_t* const scheduler)
{
    const int32_t process = osal_mutex_holder(&scheduler->mutex);
    return (has_life(scheduler, process) && (osal_process_state(process) == 'T')) ? process : 0;
}

/// Take the lock. If its holder died, the caller continues from the state of that holder (see the top of
/// lockstep_scheduler.c). A holder that a signal has stopped is killed only if two checks find it stopped.
/// The reason is a terminal that stops and continues the whole run: it may continue the holder a moment after
/// the caller.
void lockstep_port_lock(osal_lockstep_t* const scheduler)
{
    int32_t seen = 0;
    while (osal_mutex_lock_within(&scheduler->mutex, scheduler->timeout_ns / 2U) == STATUS_TIMEOUT) {
        const int32_t stopped = stopped_inside(scheduler);
        if ((stopped != 0) && (stopped == seen)) {
            (void)kill((pid_t)stopped, SIGKILL);
        }
        seen = stopped;
    }
}

void lockstep_port_unlock(osal_lockstep_t* const scheduler)
{
    osal_mutex_unlock(&scheduler->mutex);
}

/// FUTEX_WAIT returns at once if `word` is not `seen` any more.
void lockstep_port_wait(uint32_t* const word, const uint32_t seen)
{
    (void)syscall(SYS_futex, word, FUTEX_WAIT, seen, NULL);
}

void lockstep_port_wake(uint32_t* const word)
{
    (void)syscall(SYS_futex, word, FUTEX_WAKE, INT_MAX);
}

int32_t lockstep_port_process(void)
{
    return (int32_t)getpid();
}

void lockstep_port_end(void)
{
    (void)raise(SIGKILL);
}
