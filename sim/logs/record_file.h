// SPDX-License-Identifier: Apache-2.0
/// File of whole records (lines, events), written through a large buffer. After a failure, as on a full
/// disk, it ends with a whole record and nothing more is written: a reader could not detect a gap.
///
/// Ownership  The caller has the storage; record_file_open opens the file, record_file_close closes it.
/// Context    One task; record_file_flush may also be called from the signal handler of a program that
///            crashes.
#ifndef SIM_LOGS_RECORD_FILE_H
#define SIM_LOGS_RECORD_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RECORD_FILE_BUFFER 131072U ///< Large, because the operating system takes few large writes fastest.

typedef struct {
    int descriptor; ///< -1: not open.
    bool is_broken; ///< A write has failed.
    uint64_t size;  ///< Size of the file: whole records.
    size_t used;
    uint8_t octets[RECORD_FILE_BUFFER];
} record_file_t;

/// Create or overwrite the file. False: it cannot be created; record_file_close is allowed then.
bool record_file_open(record_file_t* file, const char* path);
/// Return room for one record of up to `octets`, at most RECORD_FILE_BUFFER; the caller then calls
/// record_file_add.
uint8_t* record_file_room(record_file_t* file, size_t octets);
/// Add the record that the caller wrote into the room; it has this many octets.
void record_file_add(record_file_t* file, size_t octets);
/// Pass buffered records to the operating system.
void record_file_flush(record_file_t* file);
/// Write the rest and close the file. Returns whether all records were written; true if the file was never
/// open.
bool record_file_close(record_file_t* file);

#endif // SIM_LOGS_RECORD_FILE_H
