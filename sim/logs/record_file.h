// SPDX-License-Identifier: Apache-2.0
/// File of whole records (lines, events), written through a large buffer. After a failure, for example on a
/// full disk, the file ends with a whole record and no more records are written, because a reader could not
/// detect a gap.
///
/// Ownership  The caller has the storage; record_file_open opens the file, record_file_close closes it.
/// Context    One task; record_file_flush may also be called from the signal handler of a program that
///            crashes.
#ifndef SIM_LOGS_RECORD_FILE_H
#define SIM_LOGS_RECORD_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RECORD_FILE_BUFFER 131072U ///< Large, because few large writes take less time than many small ones.

typedef struct {
    int descriptor; ///< -1: not open.
    bool is_broken; ///< A write has failed.
    uint64_t size;  ///< Size of the file: whole records.
    size_t used;    ///< Octets in the buffer.
    uint8_t octets[RECORD_FILE_BUFFER];
} record_file_t;

/// Create or overwrite the file. False: it cannot be created; record_file_close may still be called.
bool record_file_open(record_file_t* file, const char* path);
/// Returns the address for one record of up to `octets` octets, at most RECORD_FILE_BUFFER. The caller writes
/// the record there and calls record_file_add.
uint8_t* record_file_room(record_file_t* file, size_t octets);
/// Add the record that the caller has written to the address that record_file_room returned; `octets` is its
/// size.
void record_file_add(record_file_t* file, size_t octets);
/// Pass buffered records to the operating system.
void record_file_flush(record_file_t* file);
/// Write the rest and close the file. True if all records were written, or if the file was never open.
bool record_file_close(record_file_t* file);

#endif // SIM_LOGS_RECORD_FILE_H
