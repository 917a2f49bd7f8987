// SPDX-License-Identifier: Apache-2.0
/// Private to ST[23]: functions for files and directories, copies and searches. A function with the parameter
/// `request` performs a request, whose format the dispatcher has checked.
#ifndef PUS_ST23_ST23_INTERNAL_H
#define PUS_ST23_ST23_INTERNAL_H

#include "pus/st23/st23_files.h"

/// Keys of persistent records.
#define ST23_KEY_LOCK 0U ///< Key of a lock: this + index of the lock. Record: path of the file.
/// Key of a copy: this + index of the copy. Record: the path of its temporary file.
#define ST23_KEY_COPY 0x10000U
#define ST23_KEY_REPORTING 0x20000U ///< Key of the reporting interval. Record: interval u32.

/// Refuse a request as a whole, and count it.
pus_reply_t st23_refuse(pus_files_t* files, uint16_t code, uint32_t detail);
/// Returns the reply for a status of the store: done, refused or failed. `offset`: octet offset of the field
/// that the status concerns.
pus_reply_t st23_reply_of(pus_files_t* files, status_t status, uint32_t offset);
/// Store a record if the service has a persistence port. Statuses of `put`.
status_t st23_keep(const pus_files_t* files, uint32_t key, const uint8_t* octets, size_t size);
/// Erase a record. Statuses of `erase`.
status_t st23_forget(const pus_files_t* files, uint32_t key);

/// A file named by a repository path and a name, and their offsets in the application data.
typedef struct {
    pus_file_path_t path;
    uint32_t directory_offset;
    uint32_t name_offset;
    uint32_t bad_offset; ///< Offset of the field that is malformed.
} st23_request_path_t;

/// Read a repository path and a name. False: one of the fields is malformed.
bool st23_read_path(pus_request_t* request, st23_request_path_t* out_path);
/// Describe a file, or a directory if `is_directory`. Statuses of `describe` of the store; STATUS_NOT_FOUND
/// also if the path is that of the other kind.
status_t st23_look(const pus_files_t* files, const pus_file_path_t* path, bool is_directory,
                   pus_file_about_t* out_about);

/// Commit the changed records. STATUS_OK, STATUS_IO.
status_t st23_commit(const pus_files_t* files);
/// True if the file, or any file within the directory, is locked.
bool st23_is_locked(const pus_files_t* files, const pus_file_path_t* path);
/// True if a copy reads or writes the file, or any file within the directory.
bool st23_is_in_use(const pus_files_t* files, const pus_file_path_t* path);
/// True if this file is the target of a copy.
bool st23_is_claimed(const pus_files_t* files, const pus_file_path_t* path);

pus_reply_t st23_copy(void* self, pus_request_t* request);
pus_reply_t st23_move(void* self, pus_request_t* request);
/// TC[23,16] to [23,18], and TC[23,19] to [23,21].
pus_reply_t st23_change_copies(void* self, pus_request_t* request);
pus_reply_t st23_change_copies_of_path(void* self, pus_request_t* request);
pus_reply_t st23_enable_status_report(void* self, pus_request_t* request);
pus_reply_t st23_disable_status_report(void* self, pus_request_t* request);
/// Copy the slices of one step, and send the status report if it is due.
void st23_step_copies(pus_files_t* files, uint64_t now_ns, uint32_t cycle);
/// True if a copy has work in the next step.
bool st23_has_copies(const pus_files_t* files);

pus_reply_t st23_find(void* self, pus_request_t* request);
pus_reply_t st23_summarise(void* self, pus_request_t* request);
/// Continue the searches.
void st23_step_searches(pus_files_t* files, uint64_t now_ns);
bool st23_has_searches(const pus_files_t* files);

#endif // PUS_ST23_ST23_INTERNAL_H
