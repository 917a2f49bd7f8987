// SPDX-License-Identifier: Apache-2.0
/// ST[21] request sequencing, all messages: requests that are released one after the other, each followed by
/// its delay. Loading, execution and refusals: docs/services/st21.md.
///
/// Delays are measured in `uptime_ns`, the number of cycles converted to a time, so they do not depend on
/// corrections of mission time. While the port refuses a request, the sequence waits; the next delay starts
/// when the port takes the request. Loaded sequences survive a power cut, but their execution ends.
///
/// Ownership  The caller provides all arrays.
/// Context    One loop.
/// Time       A step in which no request is due is O(1), for any number of sequences; a step releases at most
///            PUS_SEQUENCE_RELEASES requests. Loading is O(octets of the sequence) and reads a file in one
///            step.
#ifndef PUS_ST21_ST21_SEQUENCES_H
#define PUS_ST21_ST21_SEQUENCES_H

#include "pus/core/block_chain.h"
#include "pus/core/file_port.h"
#include "pus/core/long_report.h"
#include "pus/core/sorted_index.h"
#include "pus/core/service.h"

/// Largest request, so that TM[21,12] can report it with its delay in one packet [octets].
#define PUS_SEQUENCE_REQUEST_MAX (PUS_TM_DATA_MAX - 17U)
#define PUS_SEQUENCE_RELEASES 256U ///< Largest number of requests that one step releases.
#define PUS_SEQUENCE_COUNT_MAX 255U
#define PUS_SEQUENCE_RECORD_HEAD 12U ///< Octets before the content in a record.
#define PUS_SEQUENCE_PIECE 4096U     ///< Part of the content in a record or in one read of a file [octets].

typedef struct { // Private.
    uint64_t id; // Identifier, with the octets of the wire as a number.
    pus_block_chain_t content;
    uint32_t expected; // Size of the content when all its records have been restored [octets].
    bool in_use;
    bool is_active;
    bool is_late; // The next delay runs from the time at which the port takes the request.
    uint8_t left; // Number of requests that have not been released yet.
    pus_block_chain_reader_t next;
} pus_sequence_t;

typedef struct {
    pus_app_process_t* process; ///< Sends the reports that a step continues.
    /// Port that takes the requests.
    pus_port_t release;
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    const pus_file_port_t* files;         ///< Null: sequences cannot be loaded by reference.
    pus_sequence_t* sequences;
    pus_sorted_index_node_t* nodes; ///< One entry for each sequence.
    uint16_t sequence_count;        ///< 1..PUS_SEQUENCE_COUNT_MAX.
    uint32_t octets_max;            ///< Largest size of the content of a sequence [octets].
    pus_block_chains_t* chains;     ///< Blocks for the contents; services of one loop may share them.
} pus_sequences_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_sequences_config_t config;
    pus_sorted_index_t due; // Active sequences by uptime.
    uint64_t uptime_ns;
    uint64_t serial;
    uint16_t reported; // Sequence whose content is reported.
    pus_long_report_t report;
    uint8_t octets[PUS_SEQUENCE_RECORD_HEAD + PUS_PACKET_MAX];
    struct {
        uint32_t loaded;
        uint32_t activated;
        uint32_t completed;
        uint32_t aborted;
        uint32_t released; ///< Requests released.
        uint32_t deferred; ///< Number of times that the port refused a request.
        uint32_t refused;  ///< Requests to this service that were refused, and loads that failed.
    } counters;
} pus_sequences_t;

void pus_sequences_init(pus_sequences_t* self, const pus_sequences_config_t* config);
/// Entry of the service for a dispatcher, without a step.
pus_service_t pus_sequences_service(pus_sequences_t* self);
/// Restore a persistent record, before the first request. STATUS_OK, STATUS_INVALID (malformed, or not the
/// next part of its sequence), STATUS_EXISTS (there is such a sequence), STATUS_EXHAUSTED (no room).
MUST_USE status_t pus_sequences_restore(pus_sequences_t* self, uint32_t key, const uint8_t* octets,
                                        size_t size);
/// Release due requests, and continue a report. uptime_ns: number of cycles since the start, converted to a
/// time; it never decreases. now_ns: time of the reports.
void pus_sequences_step(pus_sequences_t* self, uint64_t now_ns, uint64_t uptime_ns);
/// Uptime at which the next request is due; UINT64_MAX if no sequence is under execution.
uint64_t pus_sequences_next_ns(const pus_sequences_t* self);
/// True if the next step has work, independent of its time, because a report continues.
bool pus_sequences_is_waiting(const pus_sequences_t* self);

#endif // PUS_ST21_ST21_SEQUENCES_H
