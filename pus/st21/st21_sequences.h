// SPDX-License-Identifier: Apache-2.0
/// ST[21] request sequencing, all of it: requests that are released one after the other, each followed by its
/// delay.
///
/// A sequence is loaded by request or from a file, whose content is what TC[21,1] has behind the identifier:
/// N (u8, at least 1), N x {request, delay}. It is loaded whole or not at all. When it is activated its first
/// request is released with the next step; each delay separates a request from the next one, and the sequence
/// ends after the last delay. Delays run on `uptime_ns`, the count of cycles as a time, which no correction
/// of mission time touches. Where the port does not take a request, the sequence waits and its delays run
/// from when it was taken.
///
/// Refused: a name that is not 1..8 printable characters padded with NUL (OUT_OF_RANGE, 0);
/// loading what is loaded (EXISTS); an embedded request malformed or longer than
/// PUS_SEQUENCE_REQUEST_MAX (EMBEDDED, offset); a negative delay, a count of 0, octets missing or left over
/// in a file (OUT_OF_RANGE, offset); no room (TABLE_FULL: sequences, octets of one, or blocks); a file that
/// is not there (UNKNOWN_ID, 0), locked (STATE, 0), of a path or name that is none (OUT_OF_RANGE, 0), or one
/// more than can be open (TABLE_FULL, 0); unloading or activating what is under execution, aborting what is
/// not (STATE), a second report of content meanwhile (STATE); what is not loaded (UNKNOWN_ID). Files that
/// cannot be read and records that cannot be kept end as PUS_FAILURE_IO with the status. Offsets count from
/// the begin of the application data, or of the file; the identifier in a failure is the first four octets of
/// its name.
///
/// Loaded sequences outlive a power cut; none is under execution after it.
///
/// Ownership  The caller places all arrays.
/// Context    One loop.
/// Time       A step with nothing due O(1), whatever is loaded and under execution; PUS_SEQUENCE_RELEASES at
///            most. Loading is O(octets of the sequence), and reads a file at once.
#ifndef PUS_ST21_ST21_SEQUENCES_H
#define PUS_ST21_ST21_SEQUENCES_H

#include "pus/core/chains.h"
#include "pus/core/file_port.h"
#include "pus/core/long_report.h"
#include "pus/core/order.h"
#include "pus/core/service.h"

/// Largest request, so that TM[21,12] can report it with its delay in one packet [octets].
#define PUS_SEQUENCE_REQUEST_MAX (PUS_TM_DATA_MAX - 17U)
#define PUS_SEQUENCE_RELEASES 256U ///< In a step, at most.
#define PUS_SEQUENCE_COUNT_MAX 255U
#define PUS_SEQUENCE_RECORD_HEAD 12U ///< Before the content in a record [octets].
#define PUS_SEQUENCE_PIECE 4096U     ///< Of the content, in a record or read from a file at once [octets].

typedef struct { // Private.
    uint64_t id; // As on the wire.
    pus_chain_t content;
    uint32_t expected; // Octets of the content once all of its records are back.
    bool in_use;
    bool is_active;
    bool is_late; // The next delay runs from when the request is taken.
    uint8_t left; // Requests not released yet.
    pus_chain_reader_t next;
} pus_sequence_t;

typedef struct {
    pus_process_t* process; ///< For reports that go on in a step.
    pus_port_t release;
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
    const pus_file_port_t* files;         ///< Null: there are none.
    pus_sequence_t* sequences;
    pus_order_node_t* nodes; ///< One for each sequence.
    uint16_t sequence_count; ///< 1..PUS_SEQUENCE_COUNT_MAX.
    uint32_t octets_max;     ///< Of the content of a sequence.
    pus_chains_t* chains;    ///< Room for the contents; may be shared with others of the same loop.
} pus_sequences_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_sequences_config_t config;
    pus_order_t due; // Active sequences by uptime.
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
/// Take a lasting record back; before the first request. STATUS_OK, STATUS_INVALID (malformed, or not the
/// next of its sequence), STATUS_EXISTS (such a sequence is there), STATUS_EXHAUSTED (no room for it).
MUST_USE status_t pus_sequences_restore(pus_sequences_t* self, uint32_t key, const uint8_t* octets,
                                        size_t size);
/// Release what is due, and go on with a report. uptime_ns: counts of cycles since the start, as a time;
/// never goes back. now_ns stamps reports.
void pus_sequences_step(pus_sequences_t* self, uint64_t now_ns, uint64_t uptime_ns);
/// Uptime at which the next step has something to release; UINT64_MAX if nothing is under execution.
uint64_t pus_sequences_next_ns(const pus_sequences_t* self);
/// True if the next step has something to do whatever the time: a report goes on.
bool pus_sequences_is_waiting(const pus_sequences_t* self);

#endif // PUS_ST21_ST21_SEQUENCES_H
