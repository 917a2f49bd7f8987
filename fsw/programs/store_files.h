// SPDX-License-Identifier: Apache-2.0
/// Media of packet stores: files `<storage>/<component>.store.<n>` in the run's storage directory, which a
/// later flight with the same storage uses again. The lock of the component's journal
/// (fsw/programs/record_store.h) protects these files, too.
///
/// Ownership  The program provides store_files_t in static storage.
/// Context    The component's loop.
#ifndef FSW_PROGRAMS_STORE_FILES_H
#define FSW_PROGRAMS_STORE_FILES_H

#include "fsw/programs/component_runtime.h"
#include "base/medium.h"
#include "osal/include/osal/file.h"

#define STORE_FILES_MAX 8U

typedef struct { // Private, except `media`.
    unsigned count;
    osal_file_t files[STORE_FILES_MAX];
    medium_t media[STORE_FILES_MAX];
} store_files_t;

/// Open `count` files, 1..STORE_FILES_MAX, and create missing ones. STATUS_OK; for other statuses the
/// runtime's `error` contains the reason, and no file stays open: STATUS_NOT_FOUND, STATUS_DENIED,
/// STATUS_FULL, STATUS_IO, STATUS_TOO_LARGE (path), STATUS_UNSUPPORTED (the system cannot force the names of
/// files to the disk).
MUST_USE status_t store_files_open(store_files_t* stores, component_runtime_t* runtime, unsigned count);
void store_files_close(store_files_t* stores);

#endif // FSW_PROGRAMS_STORE_FILES_H
