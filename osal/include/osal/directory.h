// SPDX-License-Identifier: Apache-2.0
/// A tree of directories and files below a root that cannot be left, for names that come from outside.
///
/// A path consists of names with `/` between them, starting at the root; the root itself is "". A name has 1
/// to OSAL_NAME_SIZE - 1 octets other than `/` and is neither "." nor "..". Each name is looked up in the
/// directory before it, and symbolic links are not followed, so no path leaves the tree, whatever other
/// programs do to it meanwhile. Links, devices, pipes and sockets are treated as absent, but a call cannot
/// create an entry with the name of one. A file in place of a directory, or the reverse, is STATUS_NOT_FOUND.
///
/// When a call that changes names returns STATUS_OK, the change is on the disk; with STATUS_IO it may be
/// made. STATUS_INVALID: the argument is not such a path, or is the root where an entry of it is needed.
///
/// Ownership  The caller provides the handle.
/// Context    Any.
/// Time       A few calls of the system per name in the path; list reads the whole directory.
#ifndef OSAL_DIRECTORY_H
#define OSAL_DIRECTORY_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_NAME_SIZE 64U ///< Size of a name, with its NUL [octets].

typedef struct { // Private; -1 when closed.
    int descriptor;
} osal_directory_t;

typedef struct {
    bool is_directory;
    uint64_t size; ///< Size of a file [octets], else 0.
} osal_directory_about_t;

/// One entry of a listing.
typedef struct {
    char name[OSAL_NAME_SIZE];
    bool is_directory;
} osal_directory_entry_t;

/// Open the root, an existing directory. STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_open(osal_directory_t* root, const char* path);
void osal_directory_close(osal_directory_t* root);

/// Type and size of a directory or file. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_DENIED,
/// STATUS_IO.
MUST_USE status_t osal_directory_describe(const osal_directory_t* root, const char* path,
                                          osal_directory_about_t* out_about);
/// Create a directory in an existing one. STATUS_OK, STATUS_EXISTS, STATUS_NOT_FOUND, STATUS_INVALID,
/// STATUS_FULL, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_create(const osal_directory_t* root, const char* path);
/// Remove an empty directory. STATUS_OK, STATUS_NOT_FOUND, STATUS_FORBIDDEN (it is not empty),
/// STATUS_INVALID, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_remove(const osal_directory_t* root, const char* path);
/// Create an empty file and reserve `room` octets for it; on a disk that cannot reserve, only check that they
/// are free now. STATUS_OK, STATUS_EXISTS, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_FULL (no file is
/// created), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_create_file(const osal_directory_t* root, const char* path, uint64_t room);
/// Remove a file. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_remove_file(const osal_directory_t* root, const char* path);
/// Give a file or directory another path; at any moment it has exactly one of the two paths. STATUS_OK,
/// STATUS_NOT_FOUND (the file or directory, or the directory of the new path), STATUS_EXISTS, STATUS_INVALID
/// (also: a directory would be moved into itself), STATUS_FULL, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_rename(const osal_directory_t* root, const char* path, const char* new_path);
/// List the files and directories of a directory whose names come next after `after` ("": from the
/// beginning), in the order of their octets. Names that begin with a dot or are too long are left out.
/// *out_count < capacity: the listing is complete. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID,
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_list(const osal_directory_t* root, const char* path, const char* after,
                                      osal_directory_entry_t* entries, size_t capacity, size_t* out_count);

/// Read `size` octets of a file from `offset` on, or fewer if the file ends. STATUS_OK, STATUS_NOT_FOUND,
/// STATUS_INVALID, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_read(const osal_directory_t* root, const char* path, uint64_t offset,
                                      uint8_t* octets, size_t size, size_t* out_size);
/// Write octets into an existing file. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_FULL,
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_write(const osal_directory_t* root, const char* path, uint64_t offset,
                                       const uint8_t* octets, size_t size);
/// Force a file to the disk. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_directory_sync(const osal_directory_t* root, const char* path);

#endif // OSAL_DIRECTORY_H
