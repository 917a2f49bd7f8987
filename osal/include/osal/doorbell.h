// SPDX-License-Identifier: Apache-2.0
/// Doorbell: any number of tasks, of any process if it lies in shared memory, wait for the next ring. Rings
/// are counted, and a waiter waits for a count other than the one it has seen. A task that reads the count,
/// then checks for work, and waits only if there was none, misses no ring:
///
///     const uint32_t seen = osal_doorbell_rings(bell);
///     if (!look()) { status = osal_doorbell_wait(bell, seen, timeout_ms); }
///
/// A waiter whose ringer last ran on another processor polls for OSAL_DOORBELL_LOOK_NS before it sleeps:
/// waking a sleeping processor takes as long, and a ring meanwhile enters the kernel on neither side.
///
/// Context    Any task. Ringing never blocks, and enters the kernel only if a task waits; a waiter that died
///            costs only such calls. Waiting is for the executive of a program with a real clock, never for a
///            component: in stepped time the scheduler does not know of it.
/// Errors     A null argument is a coding error (FSW_ASSERT).
#ifndef OSAL_DOORBELL_H
#define OSAL_DOORBELL_H

#include "base/status.h"

#include <stdint.h>

#define OSAL_DOORBELL_LOOK_NS 20000U

typedef struct { // Private; may lie in shared memory. All zeros is a valid doorbell that never rang.
    uint32_t rings;
    uint32_t waiters;
    uint32_t ringer; // Processor of the last ring that woke a waiter, from 1; 0 unknown.
} osal_doorbell_t;

void osal_doorbell_create(osal_doorbell_t* bell);
/// A task that sees the ring also sees everything written before it.
void osal_doorbell_ring(osal_doorbell_t* bell);
/// Rings so far; wraps.
uint32_t osal_doorbell_rings(const osal_doorbell_t* bell);
/// Wait until the number of rings differs from `seen`. timeout_ms UINT32_MAX: no time-out. STATUS_OK,
/// STATUS_TIMEOUT.
MUST_USE status_t osal_doorbell_wait(osal_doorbell_t* bell, uint32_t seen, uint32_t timeout_ms);

#endif // OSAL_DOORBELL_H
