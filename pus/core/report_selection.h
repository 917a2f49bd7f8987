// SPDX-License-Identifier: Apache-2.0
/// Selection of the reports that ST[14] forwards to ground, or that a packet store of ST[15] stores: report
/// types by application process, service and subtype; housekeeping and diagnostic structures, each with a
/// subsampling rate; and blocked events. Rules and refusals: docs/services/st14.md.
///
/// Ownership  The caller provides the entries.
/// Context    One loop.
/// Time       A decision is O(log entries).
#ifndef PUS_CORE_REPORT_SELECTION_H
#define PUS_CORE_REPORT_SELECTION_H

#include "pus/core/packet.h"
#include "pus/core/persistence.h"
#include "pus/core/service.h"

/// Largest number of entries of all lists, so that they fit into a persistent record.
#define PUS_SELECTION_ENTRIES_MAX 1300U

typedef enum {
    PUS_SELECTED_TYPES = 0,
    PUS_SELECTED_HOUSEKEEPING,
    PUS_SELECTED_DIAGNOSTIC,
    PUS_BLOCKED_EVENTS,
    PUS_SELECTION_LISTS ///< Number of lists.
} pus_selection_list_t;

typedef struct { // Private.
    uint32_t key;
    uint16_t rate;
    uint16_t phase; // Number of reports since the last selected one.
} pus_selection_entry_t;

typedef struct {                    // Private.
    pus_selection_entry_t* entries; // Ascending by key.
    uint16_t count;
    uint16_t capacity;
} pus_selection_t;

/// Begin with an empty selection. capacity 1..PUS_SELECTION_ENTRIES_MAX.
void pus_selection_init(pus_selection_t* selection, pus_selection_entry_t* entries, uint16_t capacity);
/// Select all report types and structures of a process; its blocked events do not change. STATUS_OK;
/// STATUS_EXHAUSTED (fewer than three entries are free): the selection has not changed.
MUST_USE status_t pus_selection_add_process(pus_selection_t* selection, uint16_t apid);
/// True if a report is selected; counts the report if its structure is subsampled.
bool pus_selection_takes(pus_selection_t* selection, const pus_tm_t* tm);

/// Context for changes of selections. A change is first made in `candidate`, a copy that all selections
/// share, and then stored.
typedef struct {
    const uint16_t* apids; ///< Processes whose reports can be selected.
    uint16_t apid_count;
    pus_selection_entry_t* candidate;     ///< As many entries as the largest selection has.
    const pus_persistence_t* persistence; ///< Null: changes are not persistent.
    uint8_t table;                        ///< Table of the persistent records.
} pus_selection_editor_t;

/// Perform the instructions of a request to add or delete entries. Its reader is at the count of processes.
/// Then store the whole selection as record `key`. PUS_DONE; PUS_FAILED (PUS_FAILURE_IO, status): the
/// selection has not changed.
pus_reply_t pus_selection_add(const pus_selection_editor_t* editor, pus_selection_t* selection,
                              pus_selection_list_t list, uint32_t key, pus_request_t* request);
pus_reply_t pus_selection_delete(const pus_selection_editor_t* editor, pus_selection_t* selection,
                                 pus_selection_list_t list, uint32_t key, pus_request_t* request);
/// Store a selection as record `key`. Statuses of pus_persistence_t.put; STATUS_OK without persistence.
MUST_USE status_t pus_selection_put(const pus_selection_editor_t* editor, const pus_selection_t* selection,
                                    uint32_t key);
/// Restore a selection from a record. STATUS_OK; STATUS_INVALID (malformed) or STATUS_EXHAUSTED (more entries
/// than the capacity): the selection has not changed.
MUST_USE status_t pus_selection_restore(pus_selection_t* selection, const uint8_t* octets, size_t size);
/// Answer with the content of a list, in as many reports as necessary. Each report can be decoded alone and
/// begins with `name` (PUS_NAME_SIZE octets), unless `name` is null.
void pus_selection_report(const pus_selection_t* selection, pus_selection_list_t list, pus_request_t* request,
                          uint8_t subtype, const uint8_t* name);

#endif // PUS_CORE_REPORT_SELECTION_H
