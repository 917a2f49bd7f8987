// SPDX-License-Identifier: Apache-2.0
/// Private to this port: the file systems below osal/file.h. file.c chooses one by the path of a file and
/// keeps position, mode and lock of each open file.
#ifndef OSAL_FREERTOS_FILE_SYSTEM_H
#define OSAL_FREERTOS_FILE_SYSTEM_H

#include "base/status.h"
#include "osal/include/osal/target_eeprom.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FILE_SYSTEM_FILES 16U        ///< Files that can be open at the same time, of all file systems.
#define FILE_SYSTEM_PATH_OCTETS 288U ///< Longest path, with its NUL.

typedef enum {
    FILE_SYSTEM_READ,   ///< STATUS_NOT_FOUND if there is no such file.
    FILE_SYSTEM_UPDATE, ///< A missing file is created.
    FILE_SYSTEM_CREATE  ///< A missing file is created, an existing one emptied.
} file_system_mode_t;

/// The functions return the statuses of osal/file.h. `file` < FILE_SYSTEM_FILES is a number that file.c has
/// chosen for an open file; offsets and sizes are at most INT32_MAX.
typedef struct {
    status_t (*open)(unsigned file, const char* path, file_system_mode_t mode);
    void (*close)(unsigned file);
    /// Read up to `capacity` octets; *out_size is 0 at the end of the file and after an error.
    status_t (*read)(unsigned file, uint32_t offset, void* octets, size_t capacity, size_t* out_size);
    status_t (*write)(unsigned file, uint32_t offset, const void* octets, size_t size);
    status_t (*size)(unsigned file, uint32_t* out_size);
    status_t (*resize)(unsigned file, uint32_t size);
    status_t (*sync)(unsigned file);
    status_t (*sync_names)(const char* path);
    status_t (*remove)(const char* path);
    status_t (*rename)(const char* path, const char* new_path);
    bool (*exists)(const char* path);
} file_system_t;

/// host_files.c: the files of the machine that runs the debugger or the emulator, by semihosting.
extern const file_system_t host_files;
/// stored_files.c: the files on the EEPROM of the board. Their paths begin with STORED_FILES.
extern const file_system_t stored_files;
#define STORED_FILES TARGET_EEPROM_DIRECTORY "/"
/// Forget what is known of the EEPROM, as after a reset. No file may be open. For tests.
void stored_files_restart(void);

#endif // OSAL_FREERTOS_FILE_SYSTEM_H
