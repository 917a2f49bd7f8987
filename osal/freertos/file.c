// SPDX-License-Identifier: Apache-2.0
// Files: those whose paths begin with STORED_FILES are on the EEPROM of the board, all others on the machine
// that runs the debugger or the emulator.
#include "osal/include/osal/file.h"

#include "base/assertion.h"
#include "osal/freertos/file_system.h"

#include <FreeRTOS.h>
#include <string.h>
#include <task.h>

typedef struct {
    const file_system_t* system; ///< Null: the entry is free.
    bool is_locked;
    bool is_writable;
    bool appends;
    uint32_t position; ///< Offset of the next sequential read or write.
    char path[FILE_SYSTEM_PATH_OCTETS];
} open_file_t;

static open_file_t files[FILE_SYSTEM_FILES];

static const file_system_t* system_of(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return (strncmp(path, STORED_FILES, strlen(STORED_FILES)) == 0) ? &stored_files : &host_files;
}

/// Entry of an open file; null for a closed one.
static open_file_t* entry_of(const osal_file_t* const file)
{
    FSW_ASSERT((file != NULL) && (file->descriptor < (int)FILE_SYSTEM_FILES));
    return (file->descriptor >= 0) ? &files[file->descriptor] : NULL;
}

static unsigned number_of(const osal_file_t* const file)
{
    return (unsigned)file->descriptor;
}

/// Take a free entry for the file. STATUS_OK; STATUS_IO: too many files are open, or the path is too long.
static status_t take_entry(osal_file_t* const file, const char* const path)
{
    FSW_ASSERT((file != NULL) && (path != NULL));
    file->descriptor = -1;
    if (strlen(path) >= FILE_SYSTEM_PATH_OCTETS) {
        return STATUS_IO;
    }
    taskENTER_CRITICAL();
    for (unsigned i = 0U; (i < FILE_SYSTEM_FILES) && (file->descriptor < 0); i++) {
        if (files[i].system == NULL) {
            files[i]         = (open_file_t){.system = system_of(path)};
            file->descriptor = (int)i;
        }
    }
    taskEXIT_CRITICAL();
    if (file->descriptor < 0) {
        return STATUS_IO;
    }
    (void)memcpy(entry_of(file)->path, path, strlen(path) + 1U);
    return STATUS_OK;
}

static status_t open_file(osal_file_t* const file, const char* const path, const file_system_mode_t mode)
{
    status_t status = take_entry(file, path);
    if (status != STATUS_OK) {
        return status;
    }
    open_file_t* const entry = entry_of(file);
    entry->is_writable       = (mode != FILE_SYSTEM_READ);
    status                   = entry->system->open(number_of(file), path, mode);
    if (status != STATUS_OK) {
        entry->system    = NULL;
        file->descriptor = -1;
    }
    return status;
}

status_t osal_file_open_read(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, FILE_SYSTEM_READ);
}

status_t osal_file_create(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, FILE_SYSTEM_CREATE);
}

status_t osal_file_update(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, FILE_SYSTEM_UPDATE);
}

status_t osal_file_append(osal_file_t* const file, const char* const path)
{
    const status_t status = osal_file_update(file, path);
    if (status == STATUS_OK) {
        entry_of(file)->appends = true;
    }
    return status;
}

status_t osal_file_sync_names(const char* const path)
{
    return system_of(path)->sync_names(path);
}

status_t osal_file_sync(osal_file_t* const file)
{
    const open_file_t* const entry = entry_of(file);
    return (entry != NULL) ? entry->system->sync(number_of(file)) : STATUS_IO;
}

status_t osal_file_write_at(osal_file_t* const file, const uint64_t offset, const void* const octets,
                            const size_t size)
{
    const open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) || (size == 0U));
    if ((entry == NULL) || !entry->is_writable) {
        return STATUS_IO;
    }
    if ((offset > (uint64_t)INT32_MAX) || (size > ((uint64_t)INT32_MAX - offset))) {
        return STATUS_FULL;
    }
    return (size > 0U) ? entry->system->write(number_of(file), (uint32_t)offset, octets, size) : STATUS_OK;
}

status_t osal_file_write(osal_file_t* const file, const void* const octets, const size_t size)
{
    open_file_t* const entry = entry_of(file);
    status_t status          = STATUS_OK;
    if ((entry != NULL) && entry->appends) {
        // Each append begins at the present end, because another handle may have extended the file.
        status = entry->system->size(number_of(file), &entry->position);
    }
    if (status == STATUS_OK) {
        status = osal_file_write_at(file, (entry != NULL) ? entry->position : 0U, octets, size);
    }
    if ((entry != NULL) && (status == STATUS_OK)) {
        entry->position += (uint32_t)size;
    }
    return status;
}

status_t osal_file_read(osal_file_t* const file, void* const octets, const size_t capacity,
                        size_t* const out_size)
{
    open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (entry == NULL) {
        return STATUS_IO;
    }
    const status_t status = entry->system->read(number_of(file), entry->position, octets, capacity, out_size);
    entry->position += (uint32_t)*out_size;
    return status;
}

status_t osal_file_read_at(osal_file_t* const file, const uint64_t offset, void* const octets,
                           const size_t size)
{
    const open_file_t* const entry = entry_of(file);
    status_t status                = (entry != NULL) ? STATUS_OK : STATUS_IO;
    size_t done                    = 0U;
    FSW_ASSERT((octets != NULL) || (size == 0U));
    if ((status == STATUS_OK) &&
        ((offset > (uint64_t)INT32_MAX) || (size > ((uint64_t)INT32_MAX - offset)))) {
        status = STATUS_TRUNCATED; // No file has so many octets.
    }
    while ((status == STATUS_OK) && (done < size)) {
        size_t count = 0U;
        status       = entry->system->read(number_of(file), (uint32_t)offset + (uint32_t)done,
                                           (uint8_t*)octets + done, size - done, &count);
        if ((status == STATUS_OK) && (count == 0U)) {
            status = STATUS_TRUNCATED;
        }
        done += count;
    }
    return status;
}

status_t osal_file_size(osal_file_t* const file, uint64_t* const out_size)
{
    const open_file_t* const entry = entry_of(file);
    uint32_t size                  = 0U;
    FSW_ASSERT(out_size != NULL);
    const status_t status = (entry != NULL) ? entry->system->size(number_of(file), &size) : STATUS_IO;
    *out_size             = (status == STATUS_OK) ? size : 0U;
    return status;
}

status_t osal_file_resize(osal_file_t* const file, const uint64_t size)
{
    const open_file_t* const entry = entry_of(file);
    if ((entry == NULL) || !entry->is_writable) {
        return STATUS_IO;
    }
    return (size <= (uint64_t)INT32_MAX) ? entry->system->resize(number_of(file), (uint32_t)size)
                                         : STATUS_FULL;
}

status_t osal_file_reserve(osal_file_t* const file, const uint64_t size)
{
    (void)entry_of(file);
    (void)size;
    return STATUS_UNSUPPORTED;
}

bool osal_file_is_named(const osal_file_t* const file)
{
    const open_file_t* const entry = entry_of(file);
    return (entry != NULL) && osal_file_exists(entry->path);
}

status_t osal_file_load(const char* const path, void* const octets, const size_t capacity,
                        size_t* const out_size)
{
    osal_file_t file;
    uint64_t size = 0U;
    FSW_ASSERT((octets != NULL) && (out_size != NULL));
    *out_size       = 0U;
    status_t status = osal_file_open_read(&file, path);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_file_size(&file, &size);
    if ((status == STATUS_OK) && (size > capacity)) {
        status = STATUS_TOO_LARGE;
    }
    if (status == STATUS_OK) {
        status    = (osal_file_read_at(&file, 0U, octets, (size_t)size) == STATUS_OK) ? STATUS_OK : STATUS_IO;
        *out_size = (status == STATUS_OK) ? (size_t)size : 0U;
    }
    osal_file_close(&file);
    return status;
}

/// Neither file system has permissions, so the function cannot check that only the owner can read a secret.
status_t osal_file_load_secret(const char* const path, void* const octets, const size_t capacity,
                               size_t* const out_size)
{
    FSW_ASSERT((path != NULL) && (octets != NULL) && (out_size != NULL));
    (void)capacity;
    *out_size = 0U;
    return STATUS_UNSUPPORTED;
}

/// The lock excludes only other tasks of this program: other programs do not notice it.
status_t osal_file_lock(osal_file_t* const file)
{
    open_file_t* const entry = entry_of(file);
    bool is_free             = true;
    if (entry == NULL) {
        return STATUS_IO;
    }
    taskENTER_CRITICAL();
    for (unsigned i = 0U; i < FILE_SYSTEM_FILES; i++) {
        const bool is_same =
            (files[i].system != NULL) && (&files[i] != entry) && (strcmp(files[i].path, entry->path) == 0);
        is_free = is_free && !(is_same && files[i].is_locked);
    }
    entry->is_locked = entry->is_locked || is_free;
    taskEXIT_CRITICAL();
    return is_free ? STATUS_OK : STATUS_BUSY;
}

int osal_file_descriptor(const osal_file_t* const file)
{
    return (entry_of(file) != NULL) ? file->descriptor : -1;
}

void osal_file_close(osal_file_t* const file)
{
    open_file_t* const entry = entry_of(file);
    if (entry != NULL) {
        entry->system->close(number_of(file));
        entry->system = NULL;
    }
    file->descriptor = -1;
}

status_t osal_file_create_directory(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_file_remove(const char* const path)
{
    return system_of(path)->remove(path);
}

status_t osal_file_rename(const char* const path, const char* const new_path)
{
    const file_system_t* const system = system_of(path);
    return (system == system_of(new_path)) ? system->rename(path, new_path) : STATUS_IO;
}

status_t osal_file_link(const char* const target, const char* const path)
{
    FSW_ASSERT((target != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}

bool osal_file_exists(const char* const path)
{
    return system_of(path)->exists(path);
}
