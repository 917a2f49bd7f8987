// SPDX-License-Identifier: Apache-2.0
// Files by semihosting: the files of the machine that runs the debugger or the emulator.
#include "osal/freertos/file_system.h"

#include "base/assertion.h"
#include "osal/freertos/semihosting.h"
#include "osal/freertos/wire.h"

#include <string.h>

#define PIECE_OCTETS 512U
#define NO_SUCH_FILE 2 // Error numbers that semihosting reports.
#define NO_PERMISSION 1
#define NO_ACCESS 13
#define NO_SPACE 28

typedef struct {
    bool is_replaced; ///< A shorter copy has replaced the file since the last sync.
    int handle;
    char path[FILE_SYSTEM_PATH_OCTETS];
} host_file_t;

static host_file_t files[FILE_SYSTEM_FILES];

static status_t status_of_error(void)
{
    switch (semihosting_error()) {
    case NO_SUCH_FILE:
        return STATUS_NOT_FOUND;
    case NO_PERMISSION:
    case NO_ACCESS:
        return STATUS_DENIED;
    default:
        return STATUS_IO;
    }
}

static status_t status_of_write(const bool is_good)
{
    if (is_good) {
        return STATUS_OK;
    }
    return (semihosting_error() == NO_SPACE) ? STATUS_FULL : STATUS_IO;
}

static status_t open_file(const unsigned file, const char* const path, const file_system_mode_t mode)
{
    static const semihosting_mode_t modes[] = {[FILE_SYSTEM_READ]   = SEMIHOSTING_READ,
                                               [FILE_SYSTEM_UPDATE] = SEMIHOSTING_UPDATE,
                                               [FILE_SYSTEM_CREATE] = SEMIHOSTING_WRITE};
    host_file_t* const entry                = &files[file];
    if (strlen(path) >= (FILE_SYSTEM_PATH_OCTETS - 4U)) { // Leaves room for the ending ".cut" of a copy.
        return STATUS_IO;
    }
    *entry = (host_file_t){.handle = semihosting_open(path, modes[mode])};
    (void)memcpy(entry->path, path, strlen(path) + 1U);
    if ((entry->handle < 0) && (mode == FILE_SYSTEM_UPDATE) && (status_of_error() == STATUS_NOT_FOUND)) {
        entry->handle = semihosting_open(path, SEMIHOSTING_REWRITE);
    }
    return (entry->handle >= 0) ? STATUS_OK : status_of_error();
}

static void close_file(const unsigned file)
{
    semihosting_close(files[file].handle);
}

/// Semihosting cannot sync. The process that serves the wire does it, on the machine that has the files.
/// Without a wire, other programs can read the written octets, but it is unknown whether they are on a disk.
/// `is_of_names`: the names in the directory of `path`; otherwise the content of the file.
static status_t force(const char* const path, const bool is_of_names)
{
    if (!wire_is_open()) {
        return STATUS_UNSUPPORTED;
    }
    return (wire_sync(path, is_of_names) == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

static status_t sync_names(const char* const path)
{
    char directory[FILE_SYSTEM_PATH_OCTETS] = {'.', '\0'};
    FSW_ASSERT(strlen(path) < FILE_SYSTEM_PATH_OCTETS);
    const char* const last = strrchr(path, '/');
    if (last != NULL) {
        const size_t length = (last == path) ? 1U : (size_t)(last - path);
        (void)memcpy(directory, path, length);
        directory[length] = '\0';
    }
    // A directory that does not exist is an error, also without a wire.
    const int handle = semihosting_open(directory, SEMIHOSTING_READ);
    if (handle >= 0) {
        semihosting_close(handle);
    }
    return (handle >= 0) ? force(path, true) : STATUS_IO;
}

static status_t sync_file(const unsigned file)
{
    host_file_t* const entry = &files[file];
    status_t status          = entry->is_replaced ? force(entry->path, true) : STATUS_OK;
    if (status == STATUS_OK) {
        status             = force(entry->path, false);
        entry->is_replaced = entry->is_replaced && (status != STATUS_OK);
    }
    return status;
}

static status_t write_file(const unsigned file, const uint32_t offset, const void* const octets,
                           const size_t size)
{
    const int handle = files[file].handle;
    return status_of_write(semihosting_seek(handle, offset) && semihosting_write(handle, octets, size));
}

static status_t read_file(const unsigned file, const uint32_t offset, void* const octets,
                          const size_t capacity, size_t* const out_size)
{
    const int handle = files[file].handle;
    const int count  = semihosting_seek(handle, offset) ? semihosting_read(handle, octets, capacity) : -1;
    *out_size        = (count > 0) ? (size_t)count : 0U;
    return (count >= 0) ? STATUS_OK : STATUS_IO;
}

static status_t size_of_file(const unsigned file, uint32_t* const out_size)
{
    const int32_t size = semihosting_size(files[file].handle);
    *out_size          = (size >= 0) ? (uint32_t)size : 0U;
    return (size >= 0) ? STATUS_OK : STATUS_IO;
}

/// Copy the first `size` octets to another handle.
static status_t copy_first(const unsigned file, const int copy, const uint32_t size)
{
    uint8_t piece[PIECE_OCTETS];
    status_t status = STATUS_OK;
    uint32_t done   = 0U;
    while ((done < size) && (status == STATUS_OK)) {
        const uint32_t rest = size - done;
        size_t count        = 0U;
        status = read_file(file, done, piece, (rest < sizeof piece) ? rest : sizeof piece, &count);
        if ((status == STATUS_OK) && (count == 0U)) {
            status = STATUS_TRUNCATED;
        }
        status = (status == STATUS_OK) ? status_of_write(semihosting_write(copy, piece, count)) : status;
        done += (uint32_t)count;
    }
    return status;
}

/// Semihosting cannot shorten a file: a copy of its first `size` octets replaces it.
static status_t cut(const unsigned file, const uint32_t size)
{
    host_file_t* const entry = &files[file];
    char path[FILE_SYSTEM_PATH_OCTETS];
    (void)memcpy(path, entry->path, strlen(entry->path) + 1U);
    (void)strcat(path, ".cut");
    const int copy = semihosting_open(path, SEMIHOSTING_REWRITE);
    if (copy < 0) {
        return STATUS_IO;
    }
    status_t status = copy_first(file, copy, size);
    if ((status == STATUS_OK) && !semihosting_rename(path, entry->path)) {
        status = STATUS_IO;
    }
    if (status == STATUS_OK) {
        semihosting_close(entry->handle);
        entry->handle      = copy;
        entry->is_replaced = true;
    } else {
        semihosting_close(copy);
        (void)semihosting_remove(path);
    }
    return status;
}

static status_t resize_file(const unsigned file, const uint32_t size)
{
    static const uint8_t zeros[PIECE_OCTETS];
    uint32_t present = 0U;
    status_t status  = size_of_file(file, &present);
    if ((status == STATUS_OK) && (size < present)) {
        return cut(file, size);
    }
    while ((status == STATUS_OK) && (present < size)) {
        const uint32_t rest  = size - present;
        const uint32_t count = (rest < sizeof zeros) ? rest : (uint32_t)sizeof zeros;
        status               = write_file(file, present, zeros, count);
        present += count;
    }
    return status;
}

static status_t remove_file(const char* const path)
{
    return semihosting_remove(path) ? STATUS_OK : status_of_error();
}

static status_t rename_file(const char* const path, const char* const new_path)
{
    if (!semihosting_rename(path, new_path)) {
        return status_of_error();
    }
    const status_t status = sync_names(new_path);
    return (status == STATUS_OK) ? sync_names(path) : status;
}

static bool file_exists(const char* const path)
{
    const int handle = semihosting_open(path, SEMIHOSTING_READ);
    if (handle >= 0) {
        semihosting_close(handle);
    }
    return handle >= 0;
}

const file_system_t host_files = {.open       = open_file,
                                  .close      = close_file,
                                  .read       = read_file,
                                  .write      = write_file,
                                  .size       = size_of_file,
                                  .resize     = resize_file,
                                  .sync       = sync_file,
                                  .sync_names = sync_names,
                                  .remove     = remove_file,
                                  .rename     = rename_file,
                                  .exists     = file_exists};
