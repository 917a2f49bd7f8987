// SPDX-License-Identifier: Apache-2.0
/// The port by which the file service reaches files. Paths are those of pus/core/file_path.h as texts, below
/// a root that no path can leave. Successful creations, removals and renamings survive a power cut; written
/// data survive it after `sync`.
#ifndef PUS_CORE_FILE_STORE_H
#define PUS_CORE_FILE_STORE_H

#include "base/status.h"
#include "pus/core/file_path.h"

#define PUS_FILE_BATCH 16U ///< Maximum number of entries that one call lists.

typedef struct {
    bool is_directory;
    uint64_t size; ///< Size of a file [octets].
} pus_file_about_t;

typedef struct {
    char name[PUS_FILE_NAME_MAX + 1U];
    bool is_directory;
} pus_file_entry_t;

/// Each function returns STATUS_OK, STATUS_NOT_FOUND (the file or directory, or its parent directory),
/// STATUS_DENIED, STATUS_IO, or one of the statuses that its comment lists.
typedef struct {
    void* context;
    status_t (*describe)(void* context, const char* path, pus_file_about_t* out_about);
    /// Create an empty file and reserve `room` octets for it. STATUS_EXISTS, STATUS_FULL.
    status_t (*create_file)(void* context, const char* path, uint64_t room);
    status_t (*remove_file)(void* context, const char* path);
    /// Create an empty directory. STATUS_EXISTS, STATUS_FULL.
    status_t (*create_directory)(void* context, const char* path);
    /// Remove a directory. STATUS_FORBIDDEN: it is not empty.
    status_t (*remove_directory)(void* context, const char* path);
    /// Rename in one operation; an existing file is never replaced. STATUS_EXISTS, STATUS_INVALID (a
    /// directory would be moved into itself).
    status_t (*rename)(void* context, const char* path, const char* new_path);
    /// List the entries whose names come next after `after`, in the order of their octets. The listing is
    /// complete if it has fewer than `capacity` entries. capacity 1..PUS_FILE_BATCH.
    status_t (*list)(void* context, const char* path, const char* after, pus_file_entry_t* entries,
                     size_t capacity, size_t* out_count);
    /// Read up to `size` octets; fewer only at the end of the file.
    status_t (*read)(void* context, const char* path, uint64_t offset, uint8_t* octets, size_t size,
                     size_t* out_size);
    /// Write octets into an existing file. STATUS_FULL.
    status_t (*write)(void* context, const char* path, uint64_t offset, const uint8_t* octets, size_t size);
    /// Force the written data of a file to the medium.
    status_t (*sync)(void* context, const char* path);
} pus_file_store_t;

#endif // PUS_CORE_FILE_STORE_H
