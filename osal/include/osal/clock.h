// SPDX-License-Identifier: Apache-2.0
/// The clock of a program. The main loop of a program waits only here, and passes the time to its component.
///
/// Real: monotonic time from a common origin; a wait ends at an absolute time, or earlier if a socket has
/// data. Stepped: simulated time from the scheduler. Granted: simulated time for a program that cannot reach
/// the memory of the scheduler, because its byte order differs; its caller supplies the grants and collects
/// its deliveries.
///
/// In stepped time only osal_clock_wait waits for simulated time. Other calls of this layer that may wait
/// keep the grant: simulated time does not advance, and their time-outs are wall-clock time. These are
/// osal_event_wait, osal_mutex_lock, osal_task_join, osal_socket_wait_*, osal_device_wait_readable,
/// osal_process_start, osal_process_wait_any, and calls for files, directories, console, network namespaces,
/// CAN interfaces and a counted CAN bus. Such a wait for a participant that needs a grant is a deadlock.
///
/// Ownership  The caller provides osal_clock_t.
/// Context    The one task that runs the program's loop.
#ifndef OSAL_CLOCK_H
#define OSAL_CLOCK_H

#include "base/status.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_CLOCK_NEVER UINT64_MAX
#define OSAL_CLOCK_SOCKETS_MAX 24U ///< Sockets that one wait can poll.

typedef enum {
    OSAL_CLOCK_REAL,
    OSAL_CLOCK_STEPPED
} osal_clock_mode_t;

typedef struct { ///< Deliveries announced during a grant, by their receiver. Counts saturate.
    uint32_t lives[OSAL_LOCKSTEP_PARTICIPANTS_MAX]; ///< Life of each receiver that they are meant for.
    uint32_t messages[OSAL_LOCKSTEP_PARTICIPANTS_MAX];
    uint32_t octets[OSAL_LOCKSTEP_PARTICIPANTS_MAX];
} osal_deliveries_t;

typedef struct { // All fields are private, except `is_memory_locked`: read-only.
    osal_clock_mode_t mode;
    osal_lockstep_t* scheduler;
    osal_deliveries_t* deliveries; // Deliveries of a granted clock.
    unsigned participant;
    uint32_t life;
    uint64_t origin_ns;
    osal_grant_t grant;
    bool is_memory_locked; ///< Of a real clock: no page of the program can be swapped out.
} osal_clock_t;

/// Open a real clock; time 0 is `origin_ns` of osal_clock_monotonic_ns. Sets the timer slack to 1 ns and
/// requests locked memory; `is_memory_locked` shows whether the system permitted it.
void osal_clock_open_real(osal_clock_t* clock, uint64_t origin_ns);
/// Open a stepped clock for life `life` of `participant` of the scheduler.
void osal_clock_open_stepped(osal_clock_t* clock, osal_lockstep_t* scheduler, unsigned participant,
                             uint32_t life);

/// Open a granted clock at stepped time 0. It notes deliveries in `deliveries`, which is cleared and must
/// exist as long as the clock is in use.
void osal_clock_open_granted(osal_clock_t* clock, osal_deliveries_t* deliveries);
/// Granted clocks only: set the next grant and clear the noted deliveries.
void osal_clock_take_grant(osal_clock_t* clock, const osal_grant_t* grant);

/// Monotonic time of the machine [ns]; for origins and measurements, but not for decisions of flight
/// software.
uint64_t osal_clock_monotonic_ns(void);
/// Returns the time of the run [ns]: real time since the origin (0 before it), or the time of the present
/// grant.
uint64_t osal_clock_now_ns(const osal_clock_t* clock);

/// Wait until the time of the run is `wake_ns`. Real: or until one of `sockets` (0..OSAL_CLOCK_SOCKETS_MAX,
/// all open) has something to read, or a caught stop signal (osal_process_catch_stop); if the wake time has
/// passed, the sockets are still polled. Stepped: or until a delivery; the sockets are not used, and the
/// present grant ends. A granted clock cannot wait: that is a coding error. Returns STATUS_OK, STATUS_CLOSED
/// (stepped: the run or the life of the caller has ended), STATUS_UNSUPPORTED at once (real: there are
/// sockets, and this system's sockets cannot end a wait).
MUST_USE status_t osal_clock_wait(osal_clock_t* clock, uint64_t wake_ns, osal_socket_t* const* sockets,
                                  size_t socket_count);

/// Announce deliveries to life `life` of another participant to the scheduler. Real clock: no effect.
void osal_clock_deliver(osal_clock_t* clock, unsigned receiver, uint32_t life, uint32_t messages,
                        uint32_t octets);
/// Deliveries announced with the present grant; 0 for a real clock.
uint32_t osal_clock_messages_due(const osal_clock_t* clock);
uint32_t osal_clock_octets_due(const osal_clock_t* clock);

#endif // OSAL_CLOCK_H
