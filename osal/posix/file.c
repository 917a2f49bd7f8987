// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/file.h"

#include "base/assertion.h"
#include "osal/posix/file_status.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h> // rename
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static status_t open_file(osal_file_t* const file, const char* const path, const int flags)
{
    FSW_ASSERT((file != NULL) && (path != NULL));
    do {
        file->descriptor = open(path, flags | O_CLOEXEC, 0644);
    } while ((file->descriptor < 0) && (errno == EINTR));
    return (file->descriptor >= 0) ? STATUS_OK : file_status_of(errno);
}

status_t osal_file_open_read(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, O_RDONLY);
}

status_t osal_file_create(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, O_WRONLY | O_CREAT | O_TRUNC);
}

status_t osal_file_append(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, O_WRONLY | O_CREAT | O_APPEND);
}

status_t osal_file_sync_names(const char* const path)
{
    FSW_ASSERT(path != NULL);
    char directory[PATH_MAX] = {'.', '\0'};
    const char* const slash  = strrchr(path, '/');
    if (slash != NULL) {
        const size_t length = (slash == path) ? 1U : (size_t)(slash - path);
        if (length >= sizeof directory) {
            return STATUS_IO;
        }
        (void)memcpy(directory, path, length);
        directory[length] = '\0';
    }
    osal_file_t file;
    status_t status = open_file(&file, directory, O_RDONLY | O_DIRECTORY);
    if (status == STATUS_OK) {
        status = osal_file_sync(&file);
        osal_file_close(&file);
    }
    return (status == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

status_t osal_file_update(osal_file_t* const file, const char* const path)
{
    return open_file(file, path, O_RDWR | O_CREAT);
}

status_t osal_file_write(osal_file_t* const file, const void* const octets, const size_t size)
{
    FSW_ASSERT((file != NULL) && ((octets != NULL) || (size == 0U)));
    const char* from = octets;
    size_t rest      = size;
    while (rest > 0U) {
        const ssize_t written = write(file->descriptor, from, rest);
        if (written > 0) {
            from += written;
            rest -= (size_t)written;
        } else if ((written < 0) && (errno == EINTR)) {
            continue;
        } else {
            return (written < 0) ? file_status_of_write(errno) : STATUS_IO;
        }
    }
    return STATUS_OK;
}

status_t osal_file_write_at(osal_file_t* const file, const uint64_t offset, const void* const octets,
                            const size_t size)
{
    FSW_ASSERT((file != NULL) && ((octets != NULL) || (size == 0U)));
    const char* from = octets;
    size_t done      = 0U;
    while (done < size) {
        const ssize_t written = pwrite(file->descriptor, &from[done], size - done, (off_t)(offset + done));
        if (written > 0) {
            done += (size_t)written;
        } else if ((written == 0) || (errno != EINTR)) {
            return (written < 0) ? file_status_of_write(errno) : STATUS_IO;
        }
    }
    return STATUS_OK;
}

status_t osal_file_read_at(osal_file_t* const file, const uint64_t offset, void* const octets,
                           const size_t size)
{
    FSW_ASSERT((file != NULL) && ((octets != NULL) || (size == 0U)));
    char* to    = octets;
    size_t done = 0U;
    while (done < size) {
        const ssize_t got = pread(file->descriptor, &to[done], size - done, (off_t)(offset + done));
        if (got > 0) {
            done += (size_t)got;
        } else if (got == 0) {
            return STATUS_TRUNCATED;
        } else if (errno != EINTR) {
            return STATUS_IO;
        }
    }
    return STATUS_OK;
}

status_t osal_file_size(osal_file_t* const file, uint64_t* const out_size)
{
    FSW_ASSERT((file != NULL) && (out_size != NULL));
    struct stat about;
    const bool is_known = fstat(file->descriptor, &about) == 0;
    *out_size           = is_known ? (uint64_t)about.st_size : 0U;
    return is_known ? STATUS_OK : STATUS_IO;
}

status_t osal_file_resize(osal_file_t* const file, const uint64_t size)
{
    FSW_ASSERT(file != NULL);
    if (size > (uint64_t)INT64_MAX) {
        return STATUS_FULL;
    }
    int result = 0;
    do {
        result = ftruncate(file->descriptor, (off_t)size);
    } while ((result < 0) && (errno == EINTR));
    return (result == 0) ? STATUS_OK : file_status_of_write(errno);
}

status_t osal_file_reserve(osal_file_t* const file, const uint64_t size)
{
    FSW_ASSERT(file != NULL);
    if (size > (uint64_t)INT64_MAX) {
        return STATUS_FULL;
    }
    int error = 0;
    do {
        error = posix_fallocate(file->descriptor, 0, (off_t)size);
    } while (error == EINTR);
    if ((error == EOPNOTSUPP) || (error == EINVAL)) {
        return STATUS_UNSUPPORTED;
    }
    return (error == 0) ? STATUS_OK : file_status_of_write(error);
}

bool osal_file_is_named(const osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    struct stat about;
    return (fstat(file->descriptor, &about) == 0) && (about.st_nlink > 0U);
}

status_t osal_file_read(osal_file_t* const file, void* const octets, const size_t capacity,
                        size_t* const out_size)
{
    FSW_ASSERT((file != NULL) && ((octets != NULL) || (capacity == 0U)) && (out_size != NULL));
    ssize_t size = 0;
    do {
        size = read(file->descriptor, octets, capacity);
    } while ((size < 0) && (errno == EINTR));
    *out_size = (size > 0) ? (size_t)size : 0U;
    return (size >= 0) ? STATUS_OK : STATUS_IO;
}

/// Read the file to its end. STATUS_TOO_LARGE: the file has more octets than the buffer.
static status_t read_whole(osal_file_t* const file, char* const octets, const size_t capacity,
                           size_t* const out_size)
{
    char beyond = '\0';
    for (;;) {
        const bool is_full    = (*out_size == capacity);
        size_t size           = 0U;
        const status_t status = osal_file_read(file, is_full ? &beyond : &octets[*out_size],
                                               is_full ? 1U : (capacity - *out_size), &size);
        if ((status != STATUS_OK) || (size == 0U)) {
            return status;
        }
        if (is_full) {
            return STATUS_TOO_LARGE;
        }
        *out_size += size;
    }
}

/// Check the permissions of a secret file. STATUS_OK, STATUS_FORBIDDEN (not only the owner may use the file),
/// STATUS_IO.
static status_t is_secret(const osal_file_t* const file)
{
    struct stat facts;
    if (fstat(file->descriptor, &facts) != 0) {
        return STATUS_IO;
    }
    return ((facts.st_mode & (S_IRWXG | S_IRWXO)) == 0) ? STATUS_OK : STATUS_FORBIDDEN;
}

static status_t load(const char* const path, const bool must_be_secret, void* const octets,
                     const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((octets != NULL) && (out_size != NULL));
    osal_file_t file;
    *out_size       = 0U;
    status_t status = osal_file_open_read(&file, path);
    if (status == STATUS_OK) {
        status = must_be_secret ? is_secret(&file) : STATUS_OK;
        if (status == STATUS_OK) {
            status = read_whole(&file, octets, capacity, out_size);
        }
        osal_file_close(&file);
    }
    if (status != STATUS_OK) {
        *out_size = 0U;
    }
    return status;
}

status_t osal_file_load(const char* const path, void* const octets, const size_t capacity,
                        size_t* const out_size)
{
    return load(path, false, octets, capacity, out_size);
}

status_t osal_file_load_secret(const char* const path, void* const octets, const size_t capacity,
                               size_t* const out_size)
{
    return load(path, true, octets, capacity, out_size);
}

status_t osal_file_lock(osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    if (flock(file->descriptor, LOCK_EX | LOCK_NB) == 0) {
        return STATUS_OK;
    }
    return (errno == EWOULDBLOCK) ? STATUS_BUSY : STATUS_IO;
}

status_t osal_file_sync(osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    return (fsync(file->descriptor) == 0) ? STATUS_OK : STATUS_IO;
}

int osal_file_descriptor(const osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    return file->descriptor;
}

void osal_file_close(osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    if (file->descriptor >= 0) {
        (void)close(file->descriptor);
    }
    file->descriptor = -1;
}

/// Create one directory, unless it exists.
static status_t create_directory(const char* const path)
{
    struct stat about;
    if (mkdir(path, 0755) == 0) {
        return STATUS_OK;
    }
    const int error = errno;
    if ((stat(path, &about) == 0) && S_ISDIR(about.st_mode)) {
        return STATUS_OK;
    }
    return ((error == EACCES) || (error == EPERM) || (error == EROFS)) ? STATUS_DENIED : STATUS_IO;
}

status_t osal_file_create_directory(const char* const path)
{
    FSW_ASSERT(path != NULL);
    char part[PATH_MAX];
    const size_t length = strlen(path);
    if (length >= sizeof part) {
        return STATUS_IO;
    }
    for (size_t i = 0U; i <= length; i++) {
        const bool is_end_of_part = (path[i] == '\0') || ((path[i] == '/') && (i > 0U));
        if (is_end_of_part) {
            part[i]               = '\0';
            const status_t status = create_directory(part);
            if (status != STATUS_OK) {
                return status;
            }
        }
        part[i] = path[i];
    }
    return STATUS_OK;
}

status_t osal_file_remove(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return (unlink(path) == 0) ? STATUS_OK : file_status_of(errno);
}

status_t osal_file_rename(const char* const path, const char* const new_path)
{
    FSW_ASSERT((path != NULL) && (new_path != NULL));
    if (rename(path, new_path) != 0) {
        return file_status_of(errno);
    }
    const status_t status = osal_file_sync_names(new_path);
    return (status == STATUS_OK) ? osal_file_sync_names(path) : status;
}

status_t osal_file_link(const char* const target, const char* const path)
{
    FSW_ASSERT((target != NULL) && (path != NULL));
    struct stat found;
    if (lstat(path, &found) == 0) {
        if (!S_ISLNK(found.st_mode)) {
            return STATUS_EXISTS;
        }
        (void)unlink(path);
    }
    if (symlink(target, path) == 0) {
        return STATUS_OK;
    }
    return ((errno == EACCES) || (errno == EPERM)) ? STATUS_DENIED : STATUS_IO;
}

bool osal_file_exists(const char* const path)
{
    FSW_ASSERT(path != NULL);
    struct stat found;
    return stat(path, &found) == 0;
}
