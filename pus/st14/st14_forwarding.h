// SPDX-License-Identifier: Apache-2.0
/// ST[14] real-time forwarding control: which reports go to ground at once. All requests of the service: TC 1
/// and 2 report types, 5 and 6 housekeeping structures, 9 and 10 diagnostic structures, 13 and 14 blocked
/// events, each added, deleted; 3, 7, 11 and 15 report the content as TM 4, 8, 12 and 16.
///
/// Selection and refusals: docs/services/st14.md. There is no exception: verification reports are selected by
/// their type like any other; ground that deletes TM[1,x] of a process no longer gets the verification of its
/// requests. Without a request everything of the controlled processes is forwarded. The service does not
/// control spacecraft time packets (APID 0).
///
/// The configuration is one lasting record, key 0. A content report that is longer than a packet is split
/// into several complete ones.
///
/// Ownership  The caller places entries and process list, which outlive the service.
/// Context    One loop.
/// Time       A decision is O(log entries), a request O(entries x instructions).
#ifndef PUS_ST14_ST14_FORWARDING_H
#define PUS_ST14_ST14_FORWARDING_H

#include "pus/core/report_selection.h"

typedef struct {
    const uint16_t* apids; ///< Controlled processes, each once, 1..2046.
    uint16_t apid_count;
    pus_selection_entry_t* entries;       ///< `capacity` of them.
    pus_selection_entry_t* candidate;     ///< The same, for changes.
    uint16_t capacity;                    ///< 3 x apid_count..PUS_SELECTION_ENTRIES_MAX.
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
} pus_forwarding_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_selection_t selection;
    pus_selection_editor_t editor;
    struct {
        uint32_t forwarded; ///< Reports that were forwarded.
        uint32_t held;      ///< Reports that were not forwarded.
    } counters;
} pus_forwarding_t;

/// Forward everything of the controlled processes.
void pus_forwarding_init(pus_forwarding_t* forwarding, const pus_forwarding_config_t* config);
/// Restore the lasting record. STATUS_OK; STATUS_NOT_FOUND (key other than 0), STATUS_INVALID (malformed),
/// STATUS_EXHAUSTED (more entries than there is room for): the configuration stays.
MUST_USE status_t pus_forwarding_restore(pus_forwarding_t* forwarding, uint32_t key, const uint8_t* octets,
                                         size_t size);
/// Decide about one report, and count it. True: it goes to ground now.
bool pus_forwarding_allows(pus_forwarding_t* forwarding, const pus_tm_t* tm);
/// The service's entry for a dispatcher.
pus_service_t pus_forwarding_service(pus_forwarding_t* forwarding);

#endif // PUS_ST14_ST14_FORWARDING_H
