// SPDX-License-Identifier: Apache-2.0
/// A program's side of foreign_wire.h: it takes part in a run whose shared memory it cannot read. Its CAN
/// controllers are rings of its own, whose other ends are served here.
///
/// Ownership  The caller places foreign_t (static).
/// Context    One task.
#ifndef FSW_PROGRAMS_FOREIGN_H
#define FSW_PROGRAMS_FOREIGN_H

#include "fsw/programs/foreign_wire.h"
#include "fsw/programs/seat.h"

typedef struct { // Private, except `run` and `component`: read-only.
    foreign_wire_t wire;
    foreign_buses_t buses; // Wire ends of this program's own rings.
    run_block_t run;
    unsigned component;
    seat_t* seat;
    flow_resolver_t inner;
} foreign_t;

/// Receive the data of the run from the stand-in, whose stream is the inherited descriptor. STATUS_OK,
/// STATUS_INVALID (no such descriptor, or another message), STATUS_CLOSED, STATUS_IO.
MUST_USE status_t foreign_join(foreign_t* foreign, int descriptor);
/// From here on buses that the component opens are served. After seat_take, before the program is opened.
void foreign_serve(foreign_t* foreign, seat_t* seat);
/// As osal_clock_wait for the clock of the seat. STATUS_OK, STATUS_CLOSED (the run ended), STATUS_INVALID,
/// STATUS_TOO_LARGE, STATUS_IO.
MUST_USE status_t foreign_wait(foreign_t* foreign, uint64_t wake_ns);
/// Remove the names of its rings.
void foreign_leave(foreign_t* foreign);

#endif // FSW_PROGRAMS_FOREIGN_H
