// SPDX-License-Identifier: Apache-2.0
/// Protocol between a stand-in and the foreign program that it stands for. A foreign program is a component's
/// program of another byte order or word size: it cannot read run block, calendar and CAN rings, which are
/// structures in shared memory. A native stand-in (stand_in_main.c) has its place in the calendar and its end
/// of the buses, and passes data on by a local stream:
///
///     stand-in: run    once: the fields of the run block that a component needs
///     foreign:  done   frames sent on its buses, deliveries by receiver, its next wake time
///     stand-in: grant  time, deliveries to it, frames received on its buses
///
/// done and grant alternate until either end closes. A message is its size in octets (u32), its kind (u8) and
/// its content; numbers are big-endian. Messages of the mission and link frames use inherited sockets
/// instead.
///
/// Ownership  The caller places foreign_wire_t.
/// Context    One task.
#ifndef FSW_PROGRAMS_FOREIGN_WIRE_H
#define FSW_PROGRAMS_FOREIGN_WIRE_H

#include "fsw/programs/run_block.h"
#include "base/octets.h"
#include "osal/include/osal/can.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/socket.h"

#define FOREIGN_FRAME_OCTETS (15U + OSAL_CAN_DATA_MAX)
#define FOREIGN_ROOM 4096U ///< For everything except frames.
#define FOREIGN_MESSAGE_MAX (FOREIGN_ROOM + (MISSION_BUSES_MAX * OSAL_CAN_RING_FRAMES * FOREIGN_FRAME_OCTETS))

typedef enum {
    FOREIGN_RUN   = 1,
    FOREIGN_DONE  = 2,
    FOREIGN_GRANT = 3
} foreign_kind_t;

typedef struct { // Private, except `socket`: the end of the stream, to be opened and closed by the owner.
    osal_socket_t socket;
    size_t received;
    uint8_t octets[FOREIGN_MESSAGE_MAX];
} foreign_wire_t;

typedef struct { ///< Ends of CAN buses; those not open carry nothing.
    osal_can_t ends[MISSION_BUSES_MAX];
    uint32_t open;    ///< Bit set of the buses whose end is open.
    uint32_t refused; ///< Frames that an end did not take.
} foreign_buses_t;

typedef struct {
    uint64_t wake_ns; ///< As for osal_calendar_wait.
    uint32_t opened;  ///< Bit set of buses that the program has opened so far.
    bool is_lossy;    ///< It has missed a datagram that was announced.
    osal_deliveries_t deliveries;
} foreign_done_t;

/// Begin a message; what the caller writes is its content.
octet_writer_t foreign_begin(foreign_wire_t* wire, foreign_kind_t kind);
/// Send it. STATUS_OK, STATUS_TOO_LARGE (it did not fit), STATUS_CLOSED, STATUS_IO.
MUST_USE status_t foreign_send(foreign_wire_t* wire, const octet_writer_t* writer);
/// Wait for a message of that kind, at most patience_ms; the reader is valid until the next call. STATUS_OK,
/// STATUS_TIMEOUT (call again), STATUS_CLOSED, STATUS_INVALID (of another kind or size), STATUS_IO.
MUST_USE status_t foreign_receive(foreign_wire_t* wire, foreign_kind_t kind, uint32_t patience_ms,
                                  octet_reader_t* out_reader);

/// Contents. The readers return false if the octets are malformed; their output is then invalid.
void foreign_write_run(octet_writer_t* writer, const run_block_t* run, unsigned component);
bool foreign_read_run(octet_reader_t* reader, run_block_t* out_run, unsigned* out_component);
void foreign_write_done(octet_writer_t* writer, const foreign_done_t* done);
bool foreign_read_done(octet_reader_t* reader, foreign_done_t* out_done);
/// A grant, with the lives of all components from the run block.
void foreign_write_grant(octet_writer_t* writer, const osal_grant_t* grant, const run_block_t* run);
bool foreign_read_grant(octet_reader_t* reader, osal_grant_t* out_grant, run_block_t* run);
/// All frames that have come on the ends, as the last of a message.
void foreign_write_frames(octet_writer_t* writer, foreign_buses_t* buses);
/// Send them on the ends of the same numbers.
bool foreign_read_frames(octet_reader_t* reader, foreign_buses_t* buses);

#endif // FSW_PROGRAMS_FOREIGN_WIRE_H
