// SPDX-License-Identifier: Apache-2.0
/// A file store in memory for services under test.
#ifndef TEST_SUPPORT_DISK_H
#define TEST_SUPPORT_DISK_H

#include "pus/core/file_store.h"

#define DISK_FILES_MAX 700U
#define DISK_FILE_SIZE 40000U ///< Largest file with content [octets].
#define DISK_CONTENTS 6U      ///< Files with content.

typedef struct { // Private.
    bool is_used;
    bool is_directory;
    char path[PUS_FILE_PATH_SIZE];
    uint64_t size;
    uint8_t* octets; // Null: the file has no content.
} disk_file_t;

typedef struct {
    unsigned calls;     ///< Number of calls of the store.
    unsigned fail_call; ///< Number of the call that returns `failure`; 0: no call fails.
    status_t failure;
    uint64_t room; ///< Size requested by the last file made [octets].
    unsigned syncs;
    disk_file_t files[DISK_FILES_MAX];
    size_t contents; // Private.
    uint8_t octets[DISK_CONTENTS][DISK_FILE_SIZE];
} disk_t;

extern disk_t disk;

/// Remove everything except the root.
void disk_start(void);
pus_file_store_t disk_store(void);
/// Add a directory, or a file of `size` octets with values that increase from `first` on.
void disk_directory(const char* path);
disk_file_t* disk_file(const char* path, uint64_t size, uint8_t first);
/// Returns null if there is no such file.
disk_file_t* disk_find(const char* path);
void disk_remove(const char* path);

#endif // TEST_SUPPORT_DISK_H
