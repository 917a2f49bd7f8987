// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/shm.h"

#include "base/assertion.h"
#include "osal/posix/object_name.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static status_t status_of(const int error)
{
    switch (error) {
    case EEXIST:
        return STATUS_EXISTS;
    case ENOENT:
        return STATUS_NOT_FOUND;
    case EACCES:
    case EPERM:
        return STATUS_DENIED;
    case ENOMEM:
    case ENOSPC:
    case EFBIG:
    case EMFILE:
    case ENFILE:
        return STATUS_EXHAUSTED;
    default:
        return STATUS_IO;
    }
}

static status_t map(osal_shm_t* const shm, const int descriptor, const size_t size)
{
    void* const address = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (address == MAP_FAILED) {
        return status_of(errno);
    }
    shm->address = address;
    shm->size    = size;
    return STATUS_OK;
}

/// Allocate the memory of the object now. Otherwise, if the file system is full, a later access would end the
/// program by SIGBUS.
static int reserve(const int descriptor, const size_t size)
{
    int result = 0;
    do {
        result = posix_fallocate(descriptor, 0, (off_t)size);
    } while (result == EINTR);
    return result;
}

status_t osal_shm_create(osal_shm_t* const shm, const char* const name, const size_t size)
{
    FSW_ASSERT((shm != NULL) && (name != NULL));
    *shm = (osal_shm_t){NULL, 0U};
    if (!object_name_is_valid(name) || (size == 0U)) {
        return STATUS_INVALID;
    }
    if (size > (SIZE_MAX / 2U)) {
        return STATUS_EXHAUSTED; // Larger than off_t.
    }
    const int descriptor = shm_open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (descriptor < 0) {
        return status_of(errno);
    }
    const int error       = reserve(descriptor, size);
    const status_t status = (error == 0) ? map(shm, descriptor, size) : status_of(error);
    (void)close(descriptor);
    if (status != STATUS_OK) {
        (void)shm_unlink(name);
    }
    return status;
}

status_t osal_shm_open(osal_shm_t* const shm, const char* const name)
{
    FSW_ASSERT((shm != NULL) && (name != NULL));
    *shm = (osal_shm_t){NULL, 0U};
    if (!object_name_is_valid(name)) {
        return STATUS_INVALID;
    }
    const int descriptor = shm_open(name, O_RDWR | O_CLOEXEC, 0);
    if (descriptor < 0) {
        const status_t refused = status_of(errno);
        return (refused == STATUS_EXHAUSTED) ? STATUS_IO : refused;
    }
    struct stat about;
    status_t status = STATUS_NOT_FOUND; // Also if the size is 0, because the creator has not set it yet.
    if (fstat(descriptor, &about) != 0) {
        status = STATUS_IO;
    } else if (about.st_size > 0) {
        status = map(shm, descriptor, (size_t)about.st_size);
        status = (status == STATUS_EXHAUSTED) ? STATUS_IO : status;
    } else {
        // The size is 0.
    }
    (void)close(descriptor);
    return status;
}

void* osal_shm_address(const osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    return shm->address;
}

size_t osal_shm_size(const osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    return shm->size;
}

void osal_shm_close(osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    if (shm->address != NULL) {
        (void)munmap(shm->address, shm->size);
    }
    *shm = (osal_shm_t){NULL, 0U};
}

status_t osal_shm_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    if (!object_name_is_valid(name)) {
        return STATUS_INVALID;
    }
    if (shm_unlink(name) != 0) {
        return (errno == ENOENT) ? STATUS_NOT_FOUND : STATUS_DENIED;
    }
    return STATUS_OK;
}

status_t osal_shm_each(const char* const prefix, void (*visit)(void* context, const char* name),
                       void* const context)
{
    FSW_ASSERT((prefix != NULL) && (prefix[0] == '/') && (visit != NULL));
    DIR* const directory = opendir("/dev/shm"); // Linux shows the objects of shm_open here.
    if (directory == NULL) {
        return STATUS_UNSUPPORTED;
    }
    const struct dirent* entry = readdir(directory);
    while (entry != NULL) {
        char name[NAME_MAX + 2] = "/";
        (void)memcpy(&name[1], entry->d_name, strlen(entry->d_name) + 1U);
        if (strncmp(name, prefix, strlen(prefix)) == 0) {
            visit(context, name);
        }
        entry = readdir(directory);
    }
    (void)closedir(directory);
    return STATUS_OK;
}
