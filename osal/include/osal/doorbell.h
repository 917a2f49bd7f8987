// SPDX-License-Identifier: Apache-2.0
/// Doorbell: any number of tasks, of any process if it lies in shared memory, wait for the next ring.
///
/// Unlike an event it is not cleared by who sees it: rings are counted, and a waiter waits for a count other
/// than the one it has seen. Who reads the count, then looks at what a ring announces, and waits only if
/// there was nothing, misses no ring:
///
///     const uint32_t seen = osal_doorbell_rings(bell);
///     if (!look()) { status = osal_doorbell_wait(bell, seen, timeout_ms); }
///
/// A waiter whose ringer was last seen on another processor looks for OSAL_DOORBELL_LOOK_NS before it sleeps:
/// to wake a sleeping processor takes as long, and a ring that comes meanwhile enters the kernel on neither
/// side.
///
/// Context    Any task. Ringing never blocks, and enters the kernel only if somebody waits; a waiter that
///            died leaves nothing behind but such calls. Waiting is for the executive of a program with a
///            real clock, never for a component; it escapes the calendar.
/// Errors     A null argument is a coding error (FSW_ASSERT).
#ifndef OSAL_DOORBELL_H
#define OSAL_DOORBELL_H

#include "base/status.h"

#include <stdint.h>

#define OSAL_DOORBELL_LOOK_NS 20000U

typedef struct { // Private; may lie in shared memory. All zeros is a valid doorbell that never rang.
    uint32_t rings;
    uint32_t waiters;
    uint32_t ringer; // Processor that last woke somebody, from 1; 0 unknown.
} osal_doorbell_t;

void osal_doorbell_create(osal_doorbell_t* bell);
/// Everything written before the ring is seen by who sees the ring.
void osal_doorbell_ring(osal_doorbell_t* bell);
/// Rings so far; wraps.
uint32_t osal_doorbell_rings(const osal_doorbell_t* bell);
/// Wait until the rings so far are other than `seen`. timeout_ms UINT32_MAX waits for ever. STATUS_OK,
/// STATUS_TIMEOUT.
MUST_USE status_t osal_doorbell_wait(osal_doorbell_t* bell, uint32_t seen, uint32_t timeout_ms);

#endif // OSAL_DOORBELL_H
