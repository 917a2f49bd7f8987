// SPDX-License-Identifier: Apache-2.0
/// A program's side of remote_endian_wire.h: the program takes part in a run whose shared memory it cannot
/// read. Its CAN controllers are connected to rings of its own, and this module serves the other ends of
/// these rings.
///
/// Ownership  The caller provides remote_endian_t (static).
/// Context    One task.
#ifndef FSW_PROGRAMS_REMOTE_ENDIAN_H
#define FSW_PROGRAMS_REMOTE_ENDIAN_H

#include "fsw/programs/remote_endian_wire.h"
#include "fsw/programs/component_runtime.h"

typedef struct { // Private, except `run` and `component`: read-only.
    remote_endian_wire_t wire;
    remote_endian_buses_t buses; // Wire ends of this program's own rings.
    run_state_t run;
    unsigned component;
    component_runtime_t* runtime;
    flow_resolver_t inner;
} remote_endian_t;

/// Receive the data of the run from the proxy, whose stream is the inherited file descriptor. STATUS_OK,
/// STATUS_INVALID (no such file descriptor, or another record), STATUS_CLOSED (the proxy ended), STATUS_IO
/// (the stream failed).
MUST_USE status_t remote_endian_join(remote_endian_t* remote, int descriptor);
/// Serve the buses that the component opens from now on. Call it after component_runtime_take and before the
/// program is opened.
void remote_endian_serve(remote_endian_t* remote, component_runtime_t* runtime);
/// Like osal_clock_wait, for the clock of the runtime. STATUS_OK, STATUS_CLOSED (the proxy ended),
/// STATUS_INVALID (malformed or another record), STATUS_TOO_LARGE (a record did not fit), STATUS_IO (the
/// stream failed).
MUST_USE status_t remote_endian_wait(remote_endian_t* remote, uint64_t wake_ns);
/// Remove the names of the program's rings.
void remote_endian_leave(remote_endian_t* remote);

#endif // FSW_PROGRAMS_REMOTE_ENDIAN_H
