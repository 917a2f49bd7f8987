// SPDX-License-Identifier: Apache-2.0
/// The calendar's door: a participant that cannot share memory (a script, a program of another byte order)
/// takes part in stepped time by a local stream socket at a path, with lines of text:
///
///     client: join <participant> <local TCP port of its stream, or 0>
///     door:   grant <time_ns> <messages> <octets> <port of its stream if it is served, or 0>
///     client: done <wake_ns, or never> <octets sent to its stream> <local TCP port of its stream, or 0>
///     client: leave                               (instead of done)
///
/// The client takes in exactly the messages and octets of its grant before it runs, and sends only while its
/// stream is served. When a stream is no longer served, it has ended, whatever the socket says: the client
/// closes it. A client that vanishes, sends another line, or is silent for longer than the patience loses its
/// place; that is counted and never stops or fails the run.
///
/// Ownership  The caller places door_t; it borrows the calendar and the texts given to door_open.
/// Context    One task (processes: a task that runs door_serve) or the loop of the image program.
#ifndef SIM_CLOCK_DOOR_H
#define SIM_CLOCK_DOOR_H

#include "base/status.h"
#include "osal/include/osal/calendar.h"
#include "osal/include/osal/socket.h"

#include <stddef.h>
#include <stdint.h>

#define DOOR_LINE_BYTES 128U

typedef struct { // All fields are private, except stream_port and count: read-only.
    osal_socket_t listener;
    osal_socket_t client;
    const osal_calendar_t* calendar;
    const char* path;
    const char* participant;
    uint32_t patience_ms;
    char line[DOOR_LINE_BYTES]; ///< Received and not yet used.
    size_t line_size;
    uint64_t came_ns;     ///< When the client stood before the door (wall-clock).
    uint16_t stream_port; ///< Of the client inside; 0: it has no stream.
    struct {
        uint32_t joined;
        uint32_t left;      ///< Said leave.
        uint32_t vanished;  ///< Closed its end without `leave`.
        uint32_t malformed; ///< Sent another line than expected.
        uint32_t silent;    ///< Ran out of the door's patience.
    } count;
} door_t;

/// Listen at `path`. A client must name itself `participant`. Waits of the door end with the run: when
/// `calendar` is closed. STATUS_OK, STATUS_EXISTS, STATUS_INVALID (path), STATUS_DENIED, STATUS_IO.
MUST_USE status_t door_open(door_t* door, const char* path, const char* participant,
                            const osal_calendar_t* calendar, uint32_t patience_ms);
/// Let the client go, stop listening, remove the path.
void door_close(door_t* door);

/// Wait (wall-clock) for a client that joins in due form, at most timeout_ms. None may be inside; one that
/// has come and not joined yet is waited for by the next call, as long as the door has patience. STATUS_OK,
/// STATUS_TIMEOUT, STATUS_CLOSED (the run ended), STATUS_IO.
MUST_USE status_t door_accept(door_t* door, uint32_t timeout_ms);
/// Send the grant to the client and wait for its answer; `served_port`: of osal_calendar_served_port.
/// STATUS_OK, STATUS_CLOSED (it left, was removed, or the run ended; it no longer takes part).
MUST_USE status_t door_exchange(door_t* door, const osal_grant_t* grant, uint16_t served_port,
                                uint64_t* out_wake_ns, uint32_t* out_octets_sent);
/// The turn of the client, which is `order` of the calendar and has been granted: door_exchange, and what the
/// client says it sent is delivered to `receiver`. If the client is gone, its place in the calendar is ended.
/// STATUS_OK, STATUS_NOT_FOUND (the client is gone), STATUS_CLOSED (the run ended).
MUST_USE status_t door_turn(door_t* door, osal_calendar_t* calendar, unsigned order, unsigned receiver,
                            const osal_grant_t* grant, uint64_t* out_wake_ns);

/// Process form: wait for a client, then take its turns (door_turn). STATUS_OK (the client is gone; may be
/// called again), STATUS_CLOSED (the run ended), STATUS_IO.
MUST_USE status_t door_serve(door_t* door, osal_calendar_t* calendar, unsigned order, unsigned receiver);

#endif // SIM_CLOCK_DOOR_H
