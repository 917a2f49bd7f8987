// SPDX-License-Identifier: Apache-2.0
/// Mutual exclusion with priority inheritance. Not recursive. Critical sections are short and never wait. It
/// is robust on systems where a task can die alone: if the holder dies, the next lock succeeds with
/// STATUS_CLOSED, once, and its caller must repair the data.
/// Errors   Coding errors (FSW_ASSERT): locking a mutex that was never created, and unlocking
///          a mutex that the caller does not hold.
#ifndef OSAL_MUTEX_H
#define OSAL_MUTEX_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

#define OSAL_MUTEX_WORDS 12U ///< Room for the mutex of any port, and for a mark that it was created.

typedef struct { // Private; may lie in shared memory.
    uint64_t storage[OSAL_MUTEX_WORDS];
} osal_mutex_t;

/// Create a mutex. `is_shared`: for tasks of several processes, in shared memory. STATUS_OK,
/// STATUS_UNSUPPORTED.
MUST_USE status_t osal_mutex_create(osal_mutex_t* mutex, bool is_shared);
/// Lock the mutex. STATUS_OK; STATUS_CLOSED: locked, but the last holder died while it held the lock.
status_t osal_mutex_lock(osal_mutex_t* mutex);
/// Like osal_mutex_lock, but wait (wall-clock) for `wait_ns` at most; STATUS_TIMEOUT: not locked.
MUST_USE status_t osal_mutex_lock_within(osal_mutex_t* mutex, uint64_t wait_ns);
/// Returns the number that the system gives the task that holds the mutex now; 0: none.
int32_t osal_mutex_holder(const osal_mutex_t* mutex);
void osal_mutex_unlock(osal_mutex_t* mutex);

#endif // OSAL_MUTEX_H
