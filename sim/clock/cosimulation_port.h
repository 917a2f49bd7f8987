// SPDX-License-Identifier: Apache-2.0
/// The scheduler's co-simulation port: a participant that cannot share memory (a script, a program of another
/// byte order) takes part in stepped time by a local stream socket at a path, with lines of text:
///
///     client: join <participant> <local TCP port of its stream, or 0>
///     port:   grant <time_ns> <messages> <octets> <port of its stream if it is served, or 0>
///     client: done <wake_ns, or never> <octets sent to its stream> <local TCP port of its stream, or 0>
///     client: leave                               (instead of done)
///
/// The client receives exactly the messages and octets of its grant before it runs, and sends only while its
/// stream is served. A stream that is no longer served has ended, and the client closes its socket. A client
/// that disconnects, sends another line, or is silent for longer than `timeout_ms` is removed from the
/// scheduler; this is counted, and the run continues.
///
/// Ownership  The caller provides cosimulation_port_t. The arguments of _open exist as long as it is open.
/// Context    One task (processes: a task that runs _serve) or the loop of the image program.
#ifndef SIM_CLOCK_COSIMULATION_PORT_H
#define SIM_CLOCK_COSIMULATION_PORT_H

#include "base/status.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/socket.h"

#include <stddef.h>
#include <stdint.h>

#define COSIMULATION_PORT_LINE_OCTETS 128U

typedef struct { // All fields are private, except stream_port and count: read-only.
    osal_socket_t listener;
    osal_socket_t client;
    const osal_lockstep_t* scheduler;
    const char* path;
    const char* participant;
    uint32_t timeout_ms;
    char line[COSIMULATION_PORT_LINE_OCTETS]; ///< Octets received and not yet used.
    size_t line_size;
    uint64_t connected_ns; ///< Time at which the client connected (wall-clock).
    uint16_t stream_port;  ///< Port of the client that takes part; 0: it has no stream.
    struct {
        uint32_t joined;
        uint32_t left;      ///< Clients that sent `leave`.
        uint32_t vanished;  ///< Clients that disconnected without `leave`.
        uint32_t malformed; ///< Clients that sent another line than expected.
        uint32_t silent;    ///< Clients that were silent for longer than `timeout_ms`.
    } count;
} cosimulation_port_t;

/// Listen at `path`. A client must name itself `participant`. `timeout_ms`: longest silence of a client
/// (wall-clock). Waits end at the end of the run, when `scheduler` is closed. STATUS_OK, STATUS_EXISTS,
/// STATUS_INVALID (path), STATUS_DENIED, STATUS_IO.
MUST_USE status_t cosimulation_port_open(cosimulation_port_t* cosimulation, const char* path,
                                         const char* participant, const osal_lockstep_t* scheduler,
                                         uint32_t timeout_ms);
/// Disconnect the client, stop listening, remove the path.
void cosimulation_port_close(cosimulation_port_t* cosimulation);

/// Wait (wall-clock) for a client that joins, at most timeout_ms. Only one client may take part. If a client
/// has connected and not joined yet, the next call continues to wait for it, for the `timeout_ms` of
/// cosimulation_port_open after its connection. STATUS_OK, STATUS_TIMEOUT, STATUS_CLOSED (the run ended),
/// STATUS_IO.
MUST_USE status_t cosimulation_port_accept(cosimulation_port_t* cosimulation, uint32_t timeout_ms);
/// Send the grant to the client and wait for its answer; `served_port` is the result of
/// osal_lockstep_served_port. STATUS_OK, STATUS_CLOSED (the client has left or was removed, or the run
/// ended).
MUST_USE status_t cosimulation_port_exchange(cosimulation_port_t* cosimulation, const osal_grant_t* grant,
                                             uint16_t served_port, uint64_t* out_wake_ns,
                                             uint32_t* out_octets_sent);
/// Run the turn of the client, which is participant `order` of the scheduler and has its grant: call
/// cosimulation_port_exchange and deliver the messages that the client reports as sent to `receiver`. If the
/// client has disconnected, its life in the scheduler is ended. STATUS_OK, STATUS_NOT_FOUND (the client has
/// disconnected), STATUS_CLOSED (the run ended).
MUST_USE status_t cosimulation_port_turn(cosimulation_port_t* cosimulation, osal_lockstep_t* scheduler,
                                         unsigned order, unsigned receiver, const osal_grant_t* grant,
                                         uint64_t* out_wake_ns);

/// Process form: wait for a client, then take its turns (cosimulation_port_turn). STATUS_OK (the client has
/// disconnected; may be called again), STATUS_CLOSED (the run ended), STATUS_IO.
MUST_USE status_t cosimulation_port_serve(cosimulation_port_t* cosimulation, osal_lockstep_t* scheduler,
                                          unsigned order, unsigned receiver);

#endif // SIM_CLOCK_COSIMULATION_PORT_H
