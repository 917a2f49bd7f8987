// SPDX-License-Identifier: Apache-2.0
// Files by semihosting: the files of the machine that runs the debugger or the emulator.
#include "osal/include/osal/file.h"

#include "base/assertion.h"
#include "osal/freertos/semihosting.h"
#include "osal/freertos/wire.h"

#include <FreeRTOS.h>
#include <string.h>
#include <task.h>

#define FILES_MAX 16
#define PATH_OCTETS 288U
#define PIECE_OCTETS 512U
#define NO_SUCH_FILE 2 // Error numbers that semihosting reports.
#define NO_PERMISSION 1
#define NO_ACCESS 13
#define NO_SPACE 28

typedef struct {
    bool is_taken;
    bool is_locked;
    bool appends;
    bool is_replaced; ///< A copy has taken its name since the last sync.
    int handle;
    uint32_t position; ///< Offset of the next sequential read or write.
    char path[PATH_OCTETS];
} open_file_t;

static open_file_t files[FILES_MAX];

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

/// Entry of an open file. For a closed file: an entry whose handle semihosting refuses.
static open_file_t* entry_of(const osal_file_t* const file)
{
    static open_file_t closed = {.handle = -1};
    FSW_ASSERT((file != NULL) && (file->descriptor < FILES_MAX));
    return (file->descriptor >= 0) ? &files[file->descriptor] : &closed;
}

/// Take a free entry for the file. STATUS_OK; STATUS_IO: too many files are open, or the path is too long.
static status_t take_entry(osal_file_t* const file, const char* const path)
{
    FSW_ASSERT((file != NULL) && (path != NULL));
    file->descriptor = -1;
    if (strlen(path) >= (PATH_OCTETS - 4U)) { // Leaves room for the ending ".cut" of a copy.
        return STATUS_IO;
    }
    taskENTER_CRITICAL();
    for (int i = 0; (i < FILES_MAX) && (file->descriptor < 0); i++) {
        if (!files[i].is_taken) {
            files[i]         = (open_file_t){.is_taken = true, .handle = -1};
            file->descriptor = i;
        }
    }
    taskEXIT_CRITICAL();
    if (file->descriptor < 0) {
        return STATUS_IO;
    }
    (void)memcpy(entry_of(file)->path, path, strlen(path) + 1U);
    return STATUS_OK;
}

static status_t open_file(osal_file_t* const file, const char* const path, const semihosting_mode_t mode)
{
    status_t status = take_entry(file, path);
    if (status != STATUS_OK) {
        return status;
    }
    open_file_t* const entry = entry_of(file);
    entry->handle            = semihosting_open(path, mode);
    if (entry->handle < 0) {
        status           = status_of_error();
        entry->is_taken  = false;
        file->descriptor = -1;
    }
    return status;
}

status_t osal_file_open_read(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, SEMIHOSTING_READ);
}

status_t osal_file_create(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, SEMIHOSTING_WRITE);
}

status_t osal_file_update(osal_file_t* const file, const char* const path)
{
    const status_t status = open_file(file, path, SEMIHOSTING_UPDATE);
    return (status == STATUS_NOT_FOUND) ? open_file(file, path, SEMIHOSTING_REWRITE) : status;
}

status_t osal_file_append(osal_file_t* const file, const char* const path)
{
    const status_t status = osal_file_update(file, path);
    if (status == STATUS_OK) {
        entry_of(file)->appends = true;
    }
    return status;
}

/// Semihosting cannot sync. The process that serves the wire does it: it runs where the files are. Without
/// a wire, what was written is there for other programs, but nothing says whether it is on a disk.
static status_t force(const char* const path, const bool is_of_names)
{
    if (!wire_is_open()) {
        return STATUS_UNSUPPORTED;
    }
    return (wire_sync(path, is_of_names) == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

status_t osal_file_sync_names(const char* const path)
{
    char folder[PATH_OCTETS] = {'.', '\0'};
    FSW_ASSERT((path != NULL) && (strlen(path) < PATH_OCTETS));
    const char* const last = strrchr(path, '/');
    if (last != NULL) {
        const size_t length = (last == path) ? 1U : (size_t)(last - path);
        (void)memcpy(folder, path, length);
        folder[length] = '\0';
    }
    const int handle = semihosting_open(folder, SEMIHOSTING_READ);
    if (handle >= 0) {
        semihosting_close(handle);
    }
    return (handle >= 0) ? force(path, true) : STATUS_IO;
}

status_t osal_file_sync(osal_file_t* const file)
{
    open_file_t* const entry = entry_of(file);
    if (entry->handle < 0) {
        return STATUS_IO;
    }
    status_t status = entry->is_replaced ? force(entry->path, true) : STATUS_OK;
    if (status == STATUS_OK) {
        status             = force(entry->path, false);
        entry->is_replaced = entry->is_replaced && (status != STATUS_OK);
    }
    return status;
}

status_t osal_file_write(osal_file_t* const file, const void* const octets, const size_t size)
{
    open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) || (size == 0U));
    // Each append begins at the present end, because another handle may have extended the file.
    const int32_t end = entry->appends ? semihosting_size(entry->handle) : 0;
    if (entry->appends && (end >= 0)) {
        entry->position = (uint32_t)end;
    }
    const bool is_good = (end >= 0) && semihosting_seek(entry->handle, entry->position) &&
                         semihosting_write(entry->handle, octets, size);
    entry->position += is_good ? (uint32_t)size : 0U;
    return status_of_write(is_good);
}

status_t osal_file_read(osal_file_t* const file, void* const octets, const size_t capacity,
                        size_t* const out_size)
{
    open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) && (out_size != NULL));
    const int count = semihosting_seek(entry->handle, entry->position)
                          ? semihosting_read(entry->handle, octets, capacity)
                          : -1;
    *out_size       = (count > 0) ? (size_t)count : 0U;
    entry->position += (uint32_t)*out_size;
    return (count >= 0) ? STATUS_OK : STATUS_IO;
}

status_t osal_file_read_at(osal_file_t* const file, const uint64_t offset, void* const octets,
                           const size_t size)
{
    open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) || (size == 0U));
    if (offset > (uint64_t)INT32_MAX) { // Semihosting reports sizes of at most 31 bits.
        return STATUS_TRUNCATED;
    }
    size_t done = 0U;
    if (!semihosting_seek(entry->handle, (uint32_t)offset)) {
        return STATUS_IO;
    }
    while (done < size) {
        const int count = semihosting_read(entry->handle, (uint8_t*)octets + done, size - done);
        if (count <= 0) {
            return (count == 0) ? STATUS_TRUNCATED : STATUS_IO;
        }
        done += (size_t)count;
    }
    return STATUS_OK;
}

status_t osal_file_write_at(osal_file_t* const file, const uint64_t offset, const void* const octets,
                            const size_t size)
{
    open_file_t* const entry = entry_of(file);
    FSW_ASSERT((octets != NULL) || (size == 0U));
    if ((offset > (uint64_t)INT32_MAX) || (size > ((uint64_t)INT32_MAX - offset))) {
        return STATUS_FULL;
    }
    return status_of_write(semihosting_seek(entry->handle, (uint32_t)offset) &&
                           semihosting_write(entry->handle, octets, size));
}

status_t osal_file_size(osal_file_t* const file, uint64_t* const out_size)
{
    FSW_ASSERT(out_size != NULL);
    const int32_t size = semihosting_size(entry_of(file)->handle);
    *out_size          = (size >= 0) ? (uint64_t)size : 0U;
    return (size >= 0) ? STATUS_OK : STATUS_IO;
}

/// Copy the first `size` octets to another handle.
static status_t copy_first(osal_file_t* const file, const int copy, const uint64_t size)
{
    uint8_t piece[PIECE_OCTETS];
    status_t status = STATUS_OK;
    for (uint64_t done = 0U; (done < size) && (status == STATUS_OK); done += sizeof piece) {
        const uint64_t rest = size - done;
        const size_t count  = (rest < sizeof piece) ? (size_t)rest : sizeof piece;
        status              = osal_file_read_at(file, done, piece, count);
        status = (status == STATUS_OK) ? status_of_write(semihosting_write(copy, piece, count)) : status;
    }
    return status;
}

/// Semihosting cannot shorten a file: a copy of its first `size` octets replaces it.
static status_t cut(osal_file_t* const file, const uint64_t size)
{
    open_file_t* const entry = entry_of(file);
    char path[PATH_OCTETS];
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

status_t osal_file_resize(osal_file_t* const file, const uint64_t size)
{
    static const uint8_t zeros[PIECE_OCTETS];
    uint64_t present = 0U;
    status_t status  = osal_file_size(file, &present);
    if ((status == STATUS_OK) && (size < present)) {
        return cut(file, size);
    }
    if ((status == STATUS_OK) && (size > (uint64_t)INT32_MAX)) {
        status = STATUS_FULL;
    }
    while ((status == STATUS_OK) && (present < size)) {
        const uint64_t rest = size - present;
        const size_t count  = (rest < sizeof zeros) ? (size_t)rest : sizeof zeros;
        status              = osal_file_write_at(file, present, zeros, count);
        present += count;
    }
    return status;
}

status_t osal_file_reserve(osal_file_t* const file, const uint64_t size)
{
    (void)entry_of(file);
    (void)size;
    return STATUS_UNSUPPORTED;
}

bool osal_file_is_named(const osal_file_t* const file)
{
    return osal_file_exists(entry_of(file)->path);
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

/// Semihosting does not report permissions, so it cannot be checked that only the owner can read a secret.
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
    if (entry->handle < 0) {
        return STATUS_IO;
    }
    taskENTER_CRITICAL();
    for (int i = 0; i < FILES_MAX; i++) {
        const bool is_same =
            files[i].is_taken && (&files[i] != entry) && (strcmp(files[i].path, entry->path) == 0);
        is_free = is_free && !(is_same && files[i].is_locked);
    }
    entry->is_locked = entry->is_locked || is_free;
    taskEXIT_CRITICAL();
    return is_free ? STATUS_OK : STATUS_BUSY;
}

void osal_file_close(osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    if (file->descriptor >= 0) {
        semihosting_close(entry_of(file)->handle);
        entry_of(file)->is_taken = false;
    }
    file->descriptor = -1;
}

status_t osal_directory_create(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_file_remove(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return semihosting_remove(path) ? STATUS_OK : status_of_error();
}

status_t osal_file_rename(const char* const path, const char* const new_path)
{
    FSW_ASSERT((path != NULL) && (new_path != NULL));
    if (!semihosting_rename(path, new_path)) {
        return status_of_error();
    }
    const status_t status = osal_file_sync_names(new_path);
    return (status == STATUS_OK) ? osal_file_sync_names(path) : status;
}

status_t osal_file_link(const char* const target, const char* const path)
{
    FSW_ASSERT((target != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}

bool osal_file_exists(const char* const path)
{
    FSW_ASSERT(path != NULL);
    const int handle = semihosting_open(path, SEMIHOSTING_READ);
    if (handle >= 0) {
        semihosting_close(handle);
    }
    return handle >= 0;
}
