// SPDX-License-Identifier: Apache-2.0
/// Packet log: every packet that passes the supervisor becomes one numbered record, which the selected
/// strategy stores. The strategy can be changed at any record. The numbers continue, so that the parts can
/// be merged into one log at the end of a run, and missing or repeated records are detected. File formats:
/// docs/packet-log.md.
///
///     ASCII       packets.ascii: lines of text
///     SQLite      packets.spool: binary records, which a separate process copies to packets.db
///     ring        the last records in memory; packets.ring (as ASCII) when the log is closed
///     PostgreSQL  refused in this build
///
/// Ownership  The caller provides packet_log_t.
/// Context    The supervisor's loop. Without a writer supervisor_packet_log_step waits for the disk. With a
///            writer, a task of its own, only supervisor_packet_log_select (which opens a file) and
///            supervisor_packet_log_close wait for the disk.
#ifndef FSW_SUPERVISOR_PACKET_LOG_H
#define FSW_SUPERVISOR_PACKET_LOG_H

#include "base/status.h"
#include "fsw/framework/message/message_ring.h"
#include "osal/include/osal/event.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/task.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PACKET_LOG_PIECE 65536U ///< Largest number of octets in one write.
#define PACKET_LOG_RING_OCTETS 524288U
#define PACKET_LOG_PATH 256U

typedef enum { // The numbers are used on the wire.
    PACKET_LOG_ASCII      = 0,
    PACKET_LOG_SQLITE     = 1,
    PACKET_LOG_POSTGRESQL = 2,
    PACKET_LOG_RING       = 3,
    PACKET_LOG_STRATEGIES = 4
} packet_log_strategy_t;

typedef enum { // Job for the file.
    PACKET_LOG_NO_JOB = 0,
    PACKET_LOG_OPEN,
    PACKET_LOG_WRITE,
    PACKET_LOG_LOOK ///< Check that the file still has its name.
} packet_log_job_kind_t;

typedef struct { // Private: one job for the file. While busy, the writer owns it, the file and the piece.
    packet_log_job_kind_t kind;
    packet_log_strategy_t strategy;
    uint64_t since_ns;
    uint64_t first_number; // First and last record of the piece.
    uint64_t last_number;
    size_t octets;
    bool is_rest;  // The piece held all waiting records when it was made.
    uint64_t size; // Size of the complete records in the file, before and after the job.
    // Before the job: the file may end with a part of a record, which must be cut off first. After the job:
    // that part could not be cut off.
    bool is_cut;
    status_t status;  // Result of the job.
    uint64_t took_ns; // Result of the job: wall-clock time.
} packet_log_job_t;

typedef struct {                    // All fields are private, except the first seven: read-only.
    packet_log_strategy_t strategy; ///< Strategy in use.
    /// Selected strategy; `strategy` is the ring while the file of the selected one cannot be written.
    packet_log_strategy_t wanted;
    uint64_t next_number;    ///< Number of the next record, from 1.
    uint64_t first_number;   ///< First record of the strategy in use.
    uint64_t written_number; ///< Last record that was passed to the operating system.
    uint32_t failures;       ///< Number of records that no strategy could store.
    uint64_t slowest_ns;     ///< Longest write [ns of wall-clock time]; never in a packet.
    char directory[PACKET_LOG_PATH];
    uint32_t ring_records; // Largest number of records while the ring is in use.
    osal_file_t file;
    bool is_open;  // True also while the ring is in use and its records are written to the file.
    uint64_t size; // Size of the complete records in the file.
    uint64_t whole[PACKET_LOG_STRATEGIES]; // Size of the complete records in each strategy's file.
    bool is_cut[PACKET_LOG_STRATEGIES];
    uint64_t now_ns;
    uint64_t file_first; // First record of the ring that must be written to the file.
    uint64_t retry_ns;
    uint64_t pause_ns;  // Pause before the next retry.
    uint64_t looked_ns; // Last check that the file still has its name.
    uint64_t resumed_ns;
    message_ring_t ring; // Records that are in no file yet, in the format of the spool.
    packet_log_job_t job;
    bool has_writer;
    osal_task_t writer;
    osal_event_t ordered;
    osal_event_t done;
    bool is_busy; // The writer is performing the job.
    bool is_over; // The writer must end.
    // The members below are written before they are read, so supervisor_packet_log_open does not clear them.
    char piece[PACKET_LOG_PIECE]; // Records in the format of the file.
    uint8_t ring_storage[PACKET_LOG_RING_OCTETS];
} packet_log_t;

typedef struct {                           // State of the log of a program that died, from its last commit.
    uint64_t next_number;                  ///< Number of the next record; 1: a new log.
    uint64_t written_number;               ///< Last record that is in a file; less than `next_number`.
    uint64_t sizes[PACKET_LOG_STRATEGIES]; ///< Sizes of the files (`whole`); later octets are cut off.
    /// Copy of its ring, made by message_ring_copy; null: there was no log.
    const uint8_t* ring;
    size_t ring_octets;
} packet_log_past_t;

/// Open a log in a directory with a strategy; it continues the log `past` with the records of its ring. The
/// ring stores at most `ring_records`. STATUS_OK (also if the file cannot be opened and the ring replaces
/// it), STATUS_NOT_FOUND (the directory's name is too long), STATUS_UNSUPPORTED.
MUST_USE status_t supervisor_packet_log_open(packet_log_t* log, const char* directory,
                                             packet_log_strategy_t strategy, const packet_log_past_t* past,
                                             uint32_t ring_records);
/// Start a task that performs all operations that wait for the disk until the log is closed. It is needed in
/// runs in which time advances while a program waits. STATUS_OK; STATUS_EXHAUSTED, STATUS_IO (there is no
/// task).
MUST_USE status_t supervisor_packet_log_start_writer(packet_log_t* log);
/// Close the file without writing, as the end of the program would. The log must not have a writer.
void supervisor_packet_log_abandon(packet_log_t* log);
/// Append a packet of at most PUS_PACKET_MAX octets to the log.
void supervisor_packet_log_append(packet_log_t* log, uint64_t time_ns, bool is_tc, const uint8_t* packet,
                                  size_t size);
/// Change the strategy from the next record on; with a writer, from the first record that is in no file yet.
/// STATUS_OK; STATUS_UNSUPPORTED (this build does not have the strategy); STATUS_DENIED, STATUS_IO,
/// STATUS_NOT_FOUND (its file cannot be opened), STATUS_BUSY (the writer waits for the disk; the ring can
/// still be selected): the old strategy stays in use.
MUST_USE status_t supervisor_packet_log_select(packet_log_t* log, packet_log_strategy_t strategy);
/// Pass the waiting records to the operating system or to the writer; try again if an earlier write failed.
/// Call it in each step.
void supervisor_packet_log_step(packet_log_t* log, uint64_t now_ns);
/// Write all records and close the log. Records that cannot be written to the selected file are written to
/// packets.ring.
void supervisor_packet_log_close(packet_log_t* log);

#endif // FSW_SUPERVISOR_PACKET_LOG_H
