// SPDX-License-Identifier: Apache-2.0
/// Packet log: every packet that passes the supervisor becomes one numbered record, kept by the strategy that
/// is selected at the moment. A strategy can be changed at any record; the numbers run on, so that the parts
/// merge to one log at the end of a run and a missing or doubled record shows.
///
///     ASCII       packets.ascii: lines "<number> <seconds, 9 decimals> TC|TM <hex>"
///     SQLite      packets.spool: binary records, which the writer process of its own takes into packets.db;
///                 the file is the queue between the two, so neither ever waits for the other
///     ring        the last records in memory; packets.ring (as ASCII) when the log is closed
///     PostgreSQL  refused in this build: no server is part of it
///
/// Spool record: length u32 of what follows | number u64 | time u64 [ns] | direction u8 (0 TC, 1 TM) |
/// packet. Direction 2 is a gap: records from the first to the second number were kept nowhere. As a line:
/// "<first> <last> GAP".
///
/// A disk that is full, read-only or gone loses no record at once: the ring is in force (`strategy`) in place
/// of what is `wanted`, a file that was cut is shortened to its last whole record, and the log tries again
/// after 1 s, then 2 s, up to 32 s. When the disk takes records again, those of the ring come first, and
/// before them a gap where the ring has lost some (docs/decisions/0031).
///
/// Ownership  The caller places packet_log_t. Context: the supervisor's loop. Appending copies into a buffer;
///            packet_log_step writes it (one system call); nothing waits but for the operating system.
#ifndef FSW_SUPERVISOR_PACKET_LOG_H
#define FSW_SUPERVISOR_PACKET_LOG_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/message/octet_ring.h"
#include "osal/include/osal/file.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PACKET_LOG_BUFFER 65536U
#define PACKET_LOG_RING_OCTETS 524288U
#define PACKET_LOG_PATH 256U

typedef enum { // Numbers are those on the wire.
    PACKET_LOG_ASCII      = 0,
    PACKET_LOG_SQLITE     = 1,
    PACKET_LOG_POSTGRESQL = 2,
    PACKET_LOG_RING       = 3,
    PACKET_LOG_STRATEGIES = 4
} packet_log_strategy_t;

typedef struct {                    // All fields are private, except the first seven: read-only.
    packet_log_strategy_t strategy; ///< In force.
    packet_log_strategy_t wanted;   ///< Selected; `strategy` differs while its file takes nothing.
    uint64_t next_number;           ///< Number of the next record, from 1.
    uint64_t first_number;          ///< First record that the strategy in force has.
    uint64_t written_number;        ///< Last record that was handed to the operating system.
    uint32_t failures;              ///< Records that no strategy could keep.
    uint64_t slowest_ns;            ///< Longest write [ns of the wall]; for people, never in a packet.
    char folder[PACKET_LOG_PATH];
    uint32_t ring_records; // At most.
    osal_file_t file;
    bool is_open;                          // Also while the ring is in force and goes into the file again.
    uint64_t size;                         // Of the file: whole records.
    uint64_t whole[PACKET_LOG_STRATEGIES]; // Size of this one's file when it was left with a cut record.
    bool is_cut[PACKET_LOG_STRATEGIES];
    uint64_t now_ns;
    uint64_t file_first; // First record of the ring that goes into the file.
    uint64_t retry_ns;
    uint64_t pause_ns;  // Until the next try.
    uint64_t looked_ns; // At the name of the file.
    uint64_t resumed_ns;
    size_t used;
    octet_ring_t ring;
    // From here on nothing is read that was not written before, so that packet_log_open leaves it alone.
    uint8_t buffer[PACKET_LOG_BUFFER]; // Records as in the spool.
    char lines[PACKET_LOG_BUFFER];
    uint8_t ring_storage[PACKET_LOG_RING_OCTETS];
} packet_log_t;

/// Open in a folder with a strategy; continues the numbers of an earlier log if `next_number` is not 1. The
/// ring keeps `ring_records` at most. STATUS_OK (also where the ring stands in for a file that cannot be
/// opened), STATUS_NOT_FOUND (the folder's name is too long), STATUS_UNSUPPORTED.
MUST_USE status_t packet_log_open(packet_log_t* log, const char* folder, packet_log_strategy_t strategy,
                                  uint64_t next_number, uint32_t ring_records);
typedef struct { // Of a log whose program died, as it was told or copied before.
    uint64_t next_number;
    uint64_t written_number;
    uint64_t size;       ///< Of the file of its strategy; what is behind that is cut off.
    const uint8_t* ring; ///< Its ring, by octet_ring_copy.
    size_t ring_octets;
} packet_log_past_t;

/// The same, to go on where the other has ended: what waited in its ring is there again.
MUST_USE status_t packet_log_open_after(packet_log_t* log, const char* folder, packet_log_strategy_t strategy,
                                        const packet_log_past_t* past, uint32_t ring_records);
/// Let go of the file, as the end of the program does.
void packet_log_abandon(packet_log_t* log);
/// Keep a packet.
void packet_log_append(packet_log_t* log, uint64_t time_ns, bool is_tc, const uint8_t* packet, size_t size);
/// Change the strategy from the next record on. STATUS_OK; STATUS_UNSUPPORTED (strategy of no build or
/// unknown); STATUS_DENIED, STATUS_IO, STATUS_NOT_FOUND (its file cannot be opened): the old one stays in
/// force.
MUST_USE status_t packet_log_select(packet_log_t* log, packet_log_strategy_t strategy);
/// Hand what is buffered to the operating system, and try again where it did not take it. Each step.
void packet_log_step(packet_log_t* log, uint64_t now_ns);
/// Hand over all that there is, and close. What the selected file does not take goes to packets.ring.
void packet_log_close(packet_log_t* log);

#endif // FSW_SUPERVISOR_PACKET_LOG_H
