// SPDX-License-Identifier: Apache-2.0
/// ST[21] request sequencing, all messages: requests that are released one after the other, each followed by
/// its delay. Loading, execution and refusals: docs/services/st21.md.
///
/// Delays run on `uptime_ns`, the number of cycles as a time, which is independent of corrections of mission
/// time. While the port does not take a request, the sequence waits; the next delay starts when the request
/// is taken. Loaded sequences survive a power cut; no sequence is under execution after it.
///
/// Ownership  The caller places all arrays.
/// Context    One loop.
/// Time       A step with nothing due is O(1), whatever is loaded and under execution; it releases
///            PUS_SEQUENCE_RELEASES at most. Loading is O(octets of the sequence), and reads a file at once.
#ifndef PUS_ST21_ST21_SEQUENCES_H
#define PUS_ST21_ST21_SEQUENCES_H

#include "pus/core/block_chain.h"
#include "pus/core/file_port.h"
#include "pus/core/long_report.h"
#include "pus/core/sorted_index.h"
#include "pus/core/service.h"

/// Largest request, so that TM[21,12] can report it with its delay in one packet [octets].
#define PUS_SEQUENCE_REQUEST_MAX (PUS_TM_DATA_MAX - 17U)
#define PUS_SEQUENCE_RELEASES 256U ///< In a step, at most.
#define PUS_SEQUENCE_COUNT_MAX 255U
#define PUS_SEQUENCE_RECORD_HEAD 12U ///< Before the content in a record [octets].
#define PUS_SEQUENCE_PIECE 4096U     ///< Part of the content in a record or in one read of a file [octets].

typedef struct { // Private.
    uint64_t id; // Value on the wire.
    pus_block_chain_t content;
    uint32_t expected; // Octets of the content once all of its records are back.
    bool in_use;
    bool is_active;
    bool is_late; // The next delay runs from the time at which the port takes the request.
    uint8_t left; // Requests not released yet.
    pus_block_chain_reader_t next;
} pus_sequence_t;

typedef struct {
    pus_app_process_t* process; ///< For reports that continue in a step.
    pus_port_t release;
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
    const pus_file_port_t* files;         ///< Null: there are none.
    pus_sequence_t* sequences;
    pus_sorted_index_node_t* nodes; ///< One for each sequence.
    uint16_t sequence_count;        ///< 1..PUS_SEQUENCE_COUNT_MAX.
    uint32_t octets_max;            ///< Maximum size of the content of a sequence.
    pus_block_chains_t* chains;     ///< Room for the contents; may be shared with others of the same loop.
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
        uint32_t released; ///< Requests.
        uint32_t deferred; ///< Times the port did not take a request.
        uint32_t refused;  ///< Requests to the service.
    } counters;
} pus_sequences_t;

void pus_sequences_init(pus_sequences_t* self, const pus_sequences_config_t* config);
/// The service's entry for a dispatcher, without a step.
pus_service_t pus_sequences_service(pus_sequences_t* self);
/// Restore a persistent record; call it before the first request. STATUS_OK, STATUS_INVALID (malformed, or
/// not the next of its sequence), STATUS_EXISTS (there is such a sequence), STATUS_EXHAUSTED (no room for
/// it).
MUST_USE status_t pus_sequences_restore(pus_sequences_t* self, uint32_t key, const uint8_t* octets,
                                        size_t size);
/// Release due requests, and continue a report. uptime_ns: number of cycles since the start, as a time; never
/// decreases. now_ns stamps reports.
void pus_sequences_step(pus_sequences_t* self, uint64_t now_ns, uint64_t uptime_ns);
/// Uptime at which the next step has something to release; UINT64_MAX if nothing is under execution.
uint64_t pus_sequences_next_ns(const pus_sequences_t* self);
/// True if the next step has something to do whatever the time: a report continues.
bool pus_sequences_is_waiting(const pus_sequences_t* self);

#endif // PUS_ST21_ST21_SEQUENCES_H
