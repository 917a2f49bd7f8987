// SPDX-License-Identifier: Apache-2.0
/// Protocol between a proxy and its remote-endian program. A remote-endian program is the program of a
/// component that has another byte order or word size than the run: it cannot read run state, scheduler and
/// CAN rings, which are structures in shared memory. A native proxy (proxy_main.c) takes its place in the
/// scheduler and on the buses, and exchanges the data with it over a local stream:
///
///     proxy: run    once: the fields of the run state that a component needs
///     program:  done   frames sent on its buses, deliveries by receiver, its next wake time
///     proxy: grant  time, deliveries to it, frames received on its buses
///
/// done and grant alternate until one end closes the stream. Frames that do not fit into a record follow in
/// further records of its kind. A record consists of its size in octets (u32), its kind (u8) and its
/// content; numbers are big-endian. Messages of the mission and link frames use inherited sockets instead.
///
/// Ownership  The caller provides remote_endian_wire_t.
/// Context    One task.
#ifndef FSW_PROGRAMS_REMOTE_ENDIAN_WIRE_H
#define FSW_PROGRAMS_REMOTE_ENDIAN_WIRE_H

#include "fsw/programs/run_state.h"
#include "base/octets.h"
#include "osal/include/osal/can.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/socket.h"

#define REMOTE_ENDIAN_FRAME_OCTETS (15U + OSAL_CAN_DATA_MAX)
#define REMOTE_ENDIAN_RECORD_MAX 4096U ///< Largest record, with its size and its kind [octets].

typedef enum {
    REMOTE_ENDIAN_RUN   = 1,
    REMOTE_ENDIAN_DONE  = 2,
    REMOTE_ENDIAN_GRANT = 3
} remote_endian_kind_t;

typedef struct {   ///< Another carrier of the stream than a socket. Statuses as those of osal/socket.h.
    void* context; ///< Null: the stream is `socket`.
    status_t (*send)(void* context, const uint8_t* octets, size_t size, size_t* out_sent);
    status_t (*receive)(void* context, uint8_t* octets, size_t capacity, size_t* out_size);
    status_t (*wait_readable)(void* context, uint32_t timeout_ms);
} remote_endian_carrier_t;

typedef struct { // Private, except `socket` or `carrier`: this end, to be opened and closed by the owner.
    osal_socket_t socket;
    remote_endian_carrier_t carrier;
    size_t received;
    uint8_t octets[REMOTE_ENDIAN_RECORD_MAX];
} remote_endian_wire_t;

typedef struct { ///< Ends of CAN buses; ends that are not open are skipped.
    osal_can_t ends[MISSION_BUSES_MAX];
    uint32_t open;    ///< Bit set of the buses whose end is open.
    uint32_t refused; ///< Frames that an end did not accept.
} remote_endian_buses_t;

typedef struct {
    uint64_t wake_ns; ///< Wake time, as for osal_lockstep_wait.
    uint32_t opened;  ///< Bit set of the buses that the program has opened so far.
    bool is_lossy;    ///< The program has missed an announced datagram.
    osal_deliveries_t deliveries;
} remote_endian_done_t;

/// Begin a record; the caller writes its content.
octet_writer_t remote_endian_begin(remote_endian_wire_t* wire, remote_endian_kind_t kind);
/// Send the record. STATUS_OK, STATUS_TOO_LARGE (the content did not fit), STATUS_CLOSED, STATUS_IO.
MUST_USE status_t remote_endian_send(remote_endian_wire_t* wire, const octet_writer_t* writer);
/// Wait for a record of that kind, at most timeout_ms; the reader is valid until the next call. STATUS_OK,
/// STATUS_TIMEOUT (call again), STATUS_CLOSED, STATUS_INVALID (of another kind or size), STATUS_IO.
MUST_USE status_t remote_endian_receive(remote_endian_wire_t* wire, remote_endian_kind_t kind,
                                        uint32_t timeout_ms, octet_reader_t* out_reader);

/// Write and read the contents of records. The readers return false if the octets are malformed; their
/// output is then invalid. `storage` is the name of the storage directory for this program.
void remote_endian_write_run(octet_writer_t* writer, const run_state_t* run, unsigned component,
                             const char* storage);
bool remote_endian_read_run(octet_reader_t* reader, run_state_t* out_run, unsigned* out_component);
void remote_endian_write_done(octet_writer_t* writer, const remote_endian_done_t* done);
bool remote_endian_read_done(octet_reader_t* reader, remote_endian_done_t* out_done);
/// Write and read a grant with the lives of all components from the run state.
void remote_endian_write_grant(octet_writer_t* writer, const osal_grant_t* grant, const run_state_t* run);
bool remote_endian_read_grant(octet_reader_t* reader, osal_grant_t* out_grant, run_state_t* run);
/// Send the record with all frames received at the ends as its last part, and as many further records of
/// its kind as these frames need. Statuses of remote_endian_send.
MUST_USE status_t remote_endian_send_frames(remote_endian_wire_t* wire, octet_writer_t* writer,
                                            remote_endian_buses_t* buses);
/// Send the frames of a record on the ends with the same numbers. *out_more: a further record of this kind
/// follows, which contains only frames. False if the octets are malformed, or a frame is for an end that is
/// not open.
bool remote_endian_read_frames(octet_reader_t* reader, remote_endian_buses_t* buses, bool* out_more);

#endif // FSW_PROGRAMS_REMOTE_ENDIAN_WIRE_H
