// SPDX-License-Identifier: Apache-2.0
/// ST[23] file management: files, directories and copies below the root of a store. All 21 messages.
/// Requests, copies, persistent records and refusals: docs/services/st23.md. Paths are those of
/// pus/core/file_path.h.
///
/// A step copies `slices` slices; the copies in progress take turns. A copy is written under a name that no
/// request can have, synced, and renamed at the end, so that the target is either complete or absent. A
/// search reads one directory per step.
///
/// Ownership  The caller provides the lists of the configuration, which must exist as long as the service.
/// Context    One loop.
/// Time       A request is O(locks + copies) and some calls of the store. A step reads one directory and
///            copies at most `slices` slices; without work it does not access the store.
#ifndef PUS_ST23_ST23_FILES_H
#define PUS_ST23_ST23_FILES_H

#include "pus/core/file_store.h"
#include "pus/core/service.h"

#define PUS_FILE_SLICE 4096U ///< Slice of a copy [octets].

typedef struct { // Private.
    bool is_used;
    bool is_restored; // The lock was restored from a record: its file may not exist.
    pus_file_path_t path;
} pus_file_lock_t;

typedef enum {
    PUS_FILE_COPY_PENDING,
    PUS_FILE_COPY_RUNNING,
    PUS_FILE_COPY_ON_HOLD,
    PUS_FILE_COPY_FREE, ///< There is no copy in this entry.
    PUS_FILE_COPY_LEFT  ///< A temporary file of an earlier life must be removed.
} pus_file_copy_status_t;

typedef struct { // Private.
    pus_file_copy_status_t status;
    uint16_t id;
    bool is_begun;    // The file `part` may exist.
    uint8_t quarters; // Number of quarters of the copy whose end was reported.
    pus_token_t token;
    uint64_t size;
    uint64_t done;
    pus_file_path_t source;
    pus_file_path_t target;
    pus_file_path_t part; // Temporary name of the target until the copy is complete.
} pus_file_copy_t;

typedef struct { // Private.
    bool is_used;
    bool is_summary; // The request is TC[23,12], not TC[23,7].
    pus_token_t token;
    pus_file_path_t root;
    pus_file_path_t directory;          // Directory of the search.
    char after[PUS_FILE_NAME_MAX + 1U]; // The search continues after this name.
    char pattern[PUS_FILE_NAME_MAX + 1U];
    uint16_t count; // Number of entries in `data`.
    size_t size;
    uint8_t data[PUS_TM_DATA_MAX];
} pus_file_search_t;

typedef struct {
    pus_file_store_t store;
    pus_app_process_t* process; ///< Process that sends the reports of steps.
    pus_file_lock_t* locks;
    size_t lock_count;
    pus_file_copy_t* copies;
    size_t copy_count; ///< 1..255.
    pus_file_search_t* searches;
    size_t search_count;
    uint32_t size_max;                    ///< Largest maximum size of a file [octets].
    uint16_t slices;                      ///< Slices copied in a step, >= 1.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_files_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_files_config_t config;
    size_t next_copy; // Index of the copy whose turn is next.
    size_t next_search;
    uint32_t interval; // Interval of the status report [cycles]; 0: none.
    uint32_t reported_cycle;
    bool is_interval_new;
    bool is_restored; // Some locks were restored.
    uint8_t slice[PUS_FILE_SLICE];
    struct {
        uint32_t refused; ///< Requests and instructions refused.
        uint32_t copied;  ///< Copies completed.
        uint32_t aborted; ///< Copies aborted by request.
        uint32_t failed;  ///< Copies and searches that failed, because the store failed.
        uint32_t removed; ///< Temporary files of an earlier life that were removed.
        /// Files and directories that searches left out, because their path is not a PUS path.
        uint32_t skipped;
    } counters;
} pus_files_t;

/// Initially no file is locked and no copy runs.
void pus_files_init(pus_files_t* files, const pus_files_config_t* config);
/// Restore a persistent record. STATUS_OK; STATUS_NOT_FOUND (no such key), STATUS_INVALID (malformed).
MUST_USE status_t pus_files_restore(pus_files_t* files, uint32_t key, const uint8_t* octets, size_t size);
/// Copy, search and report; to be called once per cycle. `cycle` counts minimum sampling intervals and may
/// jump.
void pus_files_step(pus_files_t* files, uint64_t now_ns, uint32_t cycle);
/// True if the next step has work other than the status report.
bool pus_files_is_busy(const pus_files_t* files);
/// Entry of the service for a dispatcher.
pus_service_t pus_files_service(pus_files_t* files);

#endif // PUS_ST23_ST23_FILES_H
