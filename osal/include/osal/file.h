// SPDX-License-Identifier: Apache-2.0
/// Files: sequential reading, appending, random access, directories. This layer has no buffers; if the system
/// writes only a part, the functions write the rest.
#ifndef OSAL_FILE_H
#define OSAL_FILE_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct { // Private; the descriptor is -1 when closed.
    int descriptor;
} osal_file_t;

/// Open for reading. STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_file_open_read(osal_file_t* file, const char* path);
/// Create or empty a file for writing (mode 0644). STATUS_OK, STATUS_NOT_FOUND (directory), STATUS_DENIED,
/// STATUS_IO.
MUST_USE status_t osal_file_create(osal_file_t* file, const char* path);
/// Open for appending; a missing file is created. Same statuses as osal_file_create.
MUST_USE status_t osal_file_append(osal_file_t* file, const char* path);
/// Write all octets at the present position. STATUS_OK, STATUS_FULL (no space), STATUS_IO.
MUST_USE status_t osal_file_write(osal_file_t* file, const void* octets, size_t size);
/// Read up to `capacity` octets; *out_size is 0 at the end of the file. STATUS_OK, STATUS_IO.
MUST_USE status_t osal_file_read(osal_file_t* file, void* octets, size_t capacity, size_t* out_size);
/// Read the whole file into the buffer. STATUS_OK, STATUS_NOT_FOUND, STATUS_TOO_LARGE, STATUS_DENIED,
/// STATUS_IO.
MUST_USE status_t osal_file_load(const char* path, void* octets, size_t capacity, size_t* out_size);
/// Like osal_file_load, but for a secret: also STATUS_FORBIDDEN if group or others have any permission for
/// the file.
MUST_USE status_t osal_file_load_secret(const char* path, void* octets, size_t capacity, size_t* out_size);
/// Open for reading and writing at any offset; a missing file is created. Same statuses as osal_file_create.
MUST_USE status_t osal_file_update(osal_file_t* file, const char* path);
/// Force the names of all files in the directory of `path` to the disk: a file created before this call
/// exists after a power cut, but may be empty. STATUS_OK, STATUS_IO, STATUS_UNSUPPORTED (the system cannot
/// force it).
MUST_USE status_t osal_file_sync_names(const char* path);
/// Read exactly `size` octets from `offset` on. STATUS_OK, STATUS_TRUNCATED (they go beyond the end),
/// STATUS_IO.
MUST_USE status_t osal_file_read_at(osal_file_t* file, uint64_t offset, void* octets, size_t size);
/// Write all octets from `offset` on; a gap after the end is filled with zeros. STATUS_OK, STATUS_FULL (no
/// space), STATUS_IO.
MUST_USE status_t osal_file_write_at(osal_file_t* file, uint64_t offset, const void* octets, size_t size);
/// Present size [octets]. STATUS_OK, STATUS_IO.
MUST_USE status_t osal_file_size(osal_file_t* file, uint64_t* out_size);
/// Cut the file to `size`, or extend it with zeros. STATUS_OK, STATUS_FULL (no space, or beyond what a file
/// can have), STATUS_IO.
MUST_USE status_t osal_file_resize(osal_file_t* file, uint64_t size);
/// Reserve disk space for the first `size` octets (>= 1), so that a write to this part cannot fail for lack
/// of space. The file grows to `size`. STATUS_OK, STATUS_FULL (no space, or beyond what a file can have),
/// STATUS_UNSUPPORTED (this file system cannot reserve space), STATUS_IO.
MUST_USE status_t osal_file_reserve(osal_file_t* file, uint64_t size);
/// True while the file has a name in the file system. If it was removed, its content is lost on close.
bool osal_file_is_named(const osal_file_t* file);
/// Lock the file until it is closed, against other programs that lock it. STATUS_OK, STATUS_BUSY (another
/// program has the lock), STATUS_IO.
MUST_USE status_t osal_file_lock(osal_file_t* file);
/// Force the content of the file to the disk. STATUS_OK, STATUS_IO, STATUS_UNSUPPORTED (the system cannot
/// force it).
status_t osal_file_sync(osal_file_t* file);
void osal_file_close(osal_file_t* file);
/// Returns the descriptor number, for osal_process_start_t.descriptors; -1: closed. A lock ends when each
/// process that has inherited the file has closed it.
int osal_file_descriptor(const osal_file_t* file);
/// Create a directory and its parents. STATUS_OK, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_file_create_directory(const char* path);
/// Remove a file. STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
status_t osal_file_remove(const char* path);
/// Rename a file on the same disk, replacing a file of that name: at any moment the name refers to one of the
/// two complete files. STATUS_OK (the change is on the disk), STATUS_NOT_FOUND (the file, or the directory of
/// the new name), STATUS_DENIED, STATUS_IO (also: renamed, but perhaps not on the disk), STATUS_UNSUPPORTED
/// (renamed, but the system cannot force it to the disk).
MUST_USE status_t osal_file_rename(const char* path, const char* new_path);

/// Make `path` a symbolic link to `target`, replacing an existing link. STATUS_OK, STATUS_EXISTS (not a
/// link), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_file_link(const char* target, const char* path);
/// True if there is a file or directory of that name.
bool osal_file_exists(const char* path);

#endif // OSAL_FILE_H
