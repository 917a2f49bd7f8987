// SPDX-License-Identifier: Apache-2.0
/// Storage of ST[23], and the port through which other services read and write its files.
#ifndef FSW_SUPERVISOR_SERVICES_FILES_H
#define FSW_SUPERVISOR_SERVICES_FILES_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "pus/core/file_port.h"
#include "pus/st23/st23_files.h"

#define SPACECRAFT_FILE_LOCKS DESCRIPTOR_FILE_LOCKS_MAX
#define SPACECRAFT_FILE_COPIES 8U
#define SPACECRAFT_FILE_SEARCHES 4U
/// Largest number of files that other services have open at the same time.
#define SPACECRAFT_FILES_OPEN 4U
#define SPACECRAFT_FILE_SIZE_MAX 67108864U ///< Largest size of a file [octets].
#define SPACECRAFT_FILE_SLICES 4U          ///< Largest number of slices that are copied in one step.

typedef struct { // Private to fsw/supervisor.
    pus_files_t service;
    pus_file_lock_t locks[SPACECRAFT_FILE_LOCKS];
    pus_file_copy_t copies[SPACECRAFT_FILE_COPIES];
    pus_file_search_t searches[SPACECRAFT_FILE_SEARCHES];
    pus_file_port_t port;
    struct {
        bool is_used;
        pus_file_path_t path;
    } open[SPACECRAFT_FILES_OPEN];
} spacecraft_files_t;

struct supervisor;
/// Returns the port; null if the supervisor has no file store.
const pus_file_port_t* spacecraft_file_port(struct supervisor* supervisor);

#endif // FSW_SUPERVISOR_SERVICES_FILES_H
