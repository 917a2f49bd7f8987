// SPDX-License-Identifier: Apache-2.0
/// ST[14] real-time forwarding control: selects the reports that go to ground at once. TC[14,1] adds and
/// TC[14,2] deletes report types; TC[14,5] and 6 do so with housekeeping structures, TC[14,9] and 10 with
/// diagnostic structures. TC[14,13] deletes and TC[14,14] adds blocked events. TC[14,3], 7, 11 and 15 request
/// the content of these four lists; TM[14,4], 8, 12 and 16 report it.
///
/// Selection and refusals: docs/services/st14.md. Verification reports are selected by their type, too: if
/// ground deletes TM[1,x] of a process, it gets none for its requests to that process. Initially all reports
/// of the controlled processes are forwarded. Time packets (APID 0) always are forwarded.
///
/// The configuration is one persistent record, key 0. A content report that is longer than a packet is split
/// into several reports, each complete in itself.
///
/// Ownership  The caller provides entries and process list, which outlive the service.
/// Context    One loop.
/// Time       A decision is O(log entries), a request O(entries x instructions).
#ifndef PUS_ST14_ST14_FORWARDING_H
#define PUS_ST14_ST14_FORWARDING_H

#include "pus/core/report_selection.h"

typedef struct {
    const uint16_t* apids; ///< Controlled processes, each once, 1..2046.
    uint16_t apid_count;
    pus_selection_entry_t* entries; ///< `capacity` entries.
    /// `capacity` entries, for the copy in which a request first makes its changes.
    pus_selection_entry_t* candidate;
    uint16_t capacity;                    ///< 3 x apid_count..PUS_SELECTION_ENTRIES_MAX.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_forwarding_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_selection_t selection;
    pus_selection_editor_t editor;
    struct {
        uint32_t forwarded; ///< Reports that were forwarded.
        uint32_t held;      ///< Reports that were not forwarded.
    } counters;
} pus_forwarding_t;

/// Initially all reports of the controlled processes are forwarded.
void pus_forwarding_init(pus_forwarding_t* forwarding, const pus_forwarding_config_t* config);
/// Restore the persistent record. STATUS_OK; STATUS_NOT_FOUND (key other than 0), STATUS_INVALID (malformed),
/// STATUS_EXHAUSTED (more entries than the capacity): nothing changed.
MUST_USE status_t pus_forwarding_restore(pus_forwarding_t* forwarding, uint32_t key, const uint8_t* octets,
                                         size_t size);
/// Decide about one report, and count it. True: the report is forwarded to ground.
bool pus_forwarding_allows(pus_forwarding_t* forwarding, const pus_tm_t* tm);
/// Entry of the service for a dispatcher.
pus_service_t pus_forwarding_service(pus_forwarding_t* forwarding);

#endif // PUS_ST14_ST14_FORWARDING_H
