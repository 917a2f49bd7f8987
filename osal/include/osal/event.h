// SPDX-License-Identifier: Apache-2.0
/// Event: one task waits for it, and any task signals it; in shared memory, tasks of other processes, too. A
/// signal before the wait is kept; several count as one.
#ifndef OSAL_EVENT_H
#define OSAL_EVENT_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private; may lie in shared memory. Create it before its first use.
    uint32_t word;
    uintptr_t waiter; // The waiting task, if the system needs it for the wake-up.
} osal_event_t;

void osal_event_create(osal_event_t* event);
void osal_event_signal(osal_event_t* event);
/// Wait for a signal and clear it. timeout_ms UINT32_MAX: no time-out. STATUS_OK, STATUS_TIMEOUT.
MUST_USE status_t osal_event_wait(osal_event_t* event, uint32_t timeout_ms);

#endif // OSAL_EVENT_H
