// SPDX-License-Identifier: Apache-2.0
/// Packet log: every packet that passes the supervisor becomes one numbered record, kept by the strategy that
/// is selected at the moment. A strategy can be changed at any record; the numbers run on, so that the parts
/// merge to one log at the end of a run and a missing or doubled record shows.
///
///     ASCII       packets.ascii: lines "<number> <seconds, 9 decimals> TC|TM <hex>"
///     SQLite      packets.spool: binary records, which the writer process of its own takes into packets.db;
///                 the file is the queue between the two, so neither ever waits for the other
///     ring        the last records in memory; packets.ring (as ASCII) when it is left
///     PostgreSQL  refused in this build: no server is part of it
///
/// Spool record: length u32 of what follows | number u64 | time u64 [ns] | direction u8 (0 TC, 1 TM) |
/// packet.
///
/// Ownership  The caller places packet_log_t. Context: the supervisor's loop. Appending copies into a buffer;
///            packet_log_flush writes it (one system call); nothing waits.
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

typedef struct { // All fields are private, except `next_number`, `strategy` and `failures`.
    char folder[PACKET_LOG_PATH];
    packet_log_strategy_t strategy;
    uint64_t next_number; ///< Number of the next record, from 1.
    osal_file_t file;
    bool is_open;
    uint32_t failures;                  ///< Records a strategy could not keep.
    bool is_cut[PACKET_LOG_STRATEGIES]; // A write into this one's file has failed: it may end anywhere.
    uint32_t buffered;                  // Records in the buffer.
    size_t used;
    octet_ring_t ring;
    // From here on nothing is read that was not written before, so that packet_log_open leaves it alone.
    uint8_t buffer[PACKET_LOG_BUFFER];
    uint8_t ring_storage[PACKET_LOG_RING_OCTETS];
} packet_log_t;

/// Open in a folder with a strategy; continues the numbers of an earlier log if `next_number` is not 1.
/// Statuses of packet_log_select.
MUST_USE status_t packet_log_open(packet_log_t* log, const char* folder, packet_log_strategy_t strategy,
                                  uint64_t next_number);
/// Keep a packet. STATUS_OK; STATUS_FULL or STATUS_IO: this or earlier records are lost, and counted.
status_t packet_log_append(packet_log_t* log, uint64_t time_ns, bool is_tc, const uint8_t* packet,
                           size_t size);
/// Change the strategy from the next record on. STATUS_OK; STATUS_UNSUPPORTED (strategy of no build or
/// unknown); STATUS_DENIED, STATUS_IO, STATUS_NOT_FOUND (its file; a spool that was cut by a failed write
/// is not written to again): the old one stays in force.
MUST_USE status_t packet_log_select(packet_log_t* log, packet_log_strategy_t strategy);
/// Hand what is buffered to the operating system. STATUS_OK; STATUS_FULL, STATUS_IO: it is lost, and counted.
status_t packet_log_flush(packet_log_t* log);
/// Flush, write out the ring if it is selected, close.
void packet_log_close(packet_log_t* log);

#endif // FSW_SUPERVISOR_PACKET_LOG_H
