// SPDX-License-Identifier: Apache-2.0
/// ST[23] file management: files, folders and copies below the root of a store. Requests: 1 create, 2 delete,
/// 3 report the attributes of a file (TM 4), 5 lock, 6 unlock; 7 find files (TM 8); 9 create, 10 delete, 11
/// rename, 12 summary-report a directory (TM 13); 14 copy, 15 move a file; 16, 17, 18 suspend, resume, abort
/// copies by id, 19, 20, 21 those that involve a repository path; 22 enable, 24 disable the periodic status
/// report of copies (TM 23).
///
/// Paths are those of pus/core/file_path.h. Refused with TM[1,4]:
///
///     PUS_FAILURE_OUT_OF_RANGE   no path, name, pattern or flag, size beyond size_max, interval 0    offset
///     PUS_FAILURE_UNKNOWN_ID     no such file or directory: offset; no such operation: its id
///     PUS_FAILURE_EXISTS         the new name is taken: offset; the operation runs: its id
///     PUS_FAILURE_STATE          file locked (or not), directory not empty, in use by a copy: offset;
///                                operation suspended (or not): its id
///     PUS_FAILURE_TABLE_FULL     no lock, operation or search left: how many there are
///
/// Offsets are those of the field in the application data. What the store cannot do for other reasons ends
/// with TM[1,8] PUS_FAILURE_IO (status).
///
/// Files are created empty, with room set aside for their maximum size (0: none). A locked file can be read,
/// searched and copied, but neither deleted nor moved, nor can a directory it lies in be renamed. A move is a
/// renaming, at once, in which nothing is replaced.
///
/// A copy is made under a name that no request can have, synced, and renamed in the end, so that the target
/// is whole or not there. Copies take turns, one slice each; `slices` per step. Progress is reported with
/// TM[1,5] at 25, 50 and 75 % (step id); one that fails is told by TM[1,6] with the step it was in (25 to
/// 100) before its TM[1,8]. An aborted one ends with TM[1,8] PUS_FAILURE_ABORTED and leaves nothing. The
/// status report names all copies (0 pending, 1 in progress, 2 on hold), also if there are none.
///
/// A search looks at the directory and all below it, one reading of a directory per step; the paths come in
/// order. Its answers, and those to TC 12, are as many reports as it takes, each whole in itself.
///
/// Lasting records: locks, the interval of the status report, and copies under way, of which a power cut
/// leaves nothing: their requests end unanswered, and the first step removes what they had written. The lock
/// of a file that is created locked lasts before the file is made, which is never there without it; the first
/// step drops locks whose files were not made.
///
/// Ownership  The caller places the lists of the configuration, which outlive the service.
/// Context    One loop.
/// Time       A request O(locks + copies) and some calls of the store; a step one reading of a directory and
///            `slices` slices at most, nothing of the store if there is nothing to do.
#ifndef PUS_ST23_ST23_FILES_H
#define PUS_ST23_ST23_FILES_H

#include "pus/core/file_store.h"
#include "pus/core/service.h"

#define PUS_FILE_SLICE 4096U ///< Of a copy [octets].

typedef struct { // Private.
    bool is_used;
    bool is_restored; // Its file may never have been made.
    pus_file_path_t path;
} pus_file_lock_t;

typedef enum {
    PUS_FILE_COPY_PENDING,
    PUS_FILE_COPY_RUNNING,
    PUS_FILE_COPY_ON_HOLD,
    PUS_FILE_COPY_FREE, ///< No copy.
    PUS_FILE_COPY_LEFT  ///< What an earlier life has left of one.
} pus_file_copy_status_t;

typedef struct { // Private.
    pus_file_copy_status_t status;
    uint16_t id;
    bool is_begun;    // `part` may be there.
    uint8_t quarters; // Reported.
    pus_token_t token;
    uint64_t size;
    uint64_t done;
    pus_file_path_t source;
    pus_file_path_t target;
    pus_file_path_t part; // The target's name until it is whole.
} pus_file_copy_t;

typedef struct { // Private.
    bool is_used;
    bool is_summary; // TC 12 instead of TC 7.
    pus_token_t token;
    pus_file_path_t root;
    pus_file_path_t folder;             // Where it is,
    char after[PUS_FILE_NAME_MAX + 1U]; // behind which name.
    char pattern[PUS_FILE_NAME_MAX + 1U];
    uint16_t count; // Of entries in `data`.
    size_t size;
    uint8_t data[PUS_TM_DATA_MAX];
} pus_file_search_t;

typedef struct {
    pus_file_store_t store;
    pus_process_t* process; ///< Sends what steps report.
    pus_file_lock_t* locks;
    size_t lock_count;
    pus_file_copy_t* copies;
    size_t copy_count; ///< 1..255.
    pus_file_search_t* searches;
    size_t search_count;
    uint32_t size_max;                    ///< Largest maximum size of a file [octets].
    uint16_t slices;                      ///< Per step, 1 at least.
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
} pus_files_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_files_config_t config;
    size_t next_copy; // Whose turn it is.
    size_t next_search;
    uint32_t interval; // Of the status report [cycles]; 0: none.
    uint32_t reported_cycle;
    bool is_interval_new;
    bool is_restored; // Locks were.
    uint8_t slice[PUS_FILE_SLICE];
    struct {
        uint32_t refused; ///< Requests and instructions refused.
        uint32_t copied;  ///< Copies completed.
        uint32_t aborted; ///< Copies aborted by request.
        uint32_t failed;  ///< Copies and searches that the store has failed.
        uint32_t removed; ///< Parts of an earlier life that were removed.
        uint32_t skipped; ///< Files and directories whose path no request could have.
    } counters;
} pus_files_t;

/// Nothing is locked, nothing runs.
void pus_files_init(pus_files_t* files, const pus_files_config_t* config);
/// Take a lasting record back. STATUS_OK; STATUS_NOT_FOUND (no such key), STATUS_INVALID (malformed).
MUST_USE status_t pus_files_restore(pus_files_t* files, uint32_t key, const uint8_t* octets, size_t size);
/// Copy, search, report; call once per cycle. `cycle` counts minimum sampling intervals and may jump forward.
void pus_files_step(pus_files_t* files, uint64_t now_ns, uint32_t cycle);
/// True if the next step has something to do but the status report.
bool pus_files_is_busy(const pus_files_t* files);
/// The service's entry for a dispatcher.
pus_service_t pus_files_service(pus_files_t* files);

#endif // PUS_ST23_ST23_FILES_H
