// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/directory.h"

#include "base/assertion.h"
#include "osal/include/osal/file.h"
#include "osal/posix/file_status.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h> // renameat2
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define LISTING_SIZE 4096U // Size of the buffer for entries read by one system call [octets].

/// An open directory and a name in this directory.
typedef struct {
    int directory;
    char name[OSAL_NAME_SIZE];
} directory_entry_t;

/// Copy the first name of a path; *out_name is "" if the name is invalid. Returns the path after this name
/// and its slash, or null if the path has no further name.
static const char* next_name(const char* const path, char* const out_name)
{
    const char* const slash = strchr(path, '/');
    const size_t length     = (slash != NULL) ? (size_t)(slash - path) : strlen(path);
    const bool is_dots      = ((length == 1U) || (length == 2U)) && (strncmp(path, "..", length) == 0);
    const bool is_name      = (length < OSAL_NAME_SIZE) && !is_dots;
    if (is_name) {
        (void)memcpy(out_name, path, length);
    }
    out_name[is_name ? length : 0U] = '\0';
    return (slash != NULL) ? &slash[1] : NULL;
}

/// Status for the errno of a call that creates a file or directory.
static status_t status_of_creation(const int error)
{
    if (error == EEXIST) {
        return STATUS_EXISTS;
    }
    const status_t status = file_status_of(error);
    return (status == STATUS_IO) ? file_status_of_write(error) : status;
}

/// Open or create an entry of a directory. A symbolic link is treated as absent.
static status_t open_in(const int directory, const char* const name, const int flags, const mode_t mode,
                        int* const out_descriptor)
{
    do {
        *out_descriptor = openat(directory, name, flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, mode);
    } while ((*out_descriptor < 0) && (errno == EINTR));
    if (*out_descriptor >= 0) {
        return STATUS_OK;
    }
    return ((errno == ELOOP) || (errno == ENXIO)) ? STATUS_NOT_FOUND : status_of_creation(errno);
}

static status_t open_directory(const int directory, const char* const name, int* const out_descriptor)
{
    return open_in(directory, name, O_RDONLY | O_DIRECTORY, 0U, out_descriptor);
}

static void close_directory_of(const directory_entry_t* const entry)
{
    (void)close(entry->directory);
}

/// Open the parent directory of a path; the caller closes it. STATUS_OK, STATUS_INVALID (the root has
/// none), STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
static status_t open_parent(const osal_directory_t* const root, const char* const path,
                            directory_entry_t* const out_entry)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    const char* rest = next_name(path, out_entry->name);
    status_t status  = open_directory(root->descriptor, ".", &out_entry->directory);
    while ((status == STATUS_OK) && (rest != NULL) && (out_entry->name[0] != '\0')) {
        const int above = out_entry->directory;
        status          = open_directory(above, out_entry->name, &out_entry->directory);
        (void)close(above);
        rest = next_name(rest, out_entry->name);
    }
    if ((status == STATUS_OK) && (out_entry->name[0] == '\0')) {
        close_directory_of(out_entry);
        status = STATUS_INVALID;
    }
    return status;
}

/// Open the directory that a path names. Statuses of open_parent.
static status_t open_directory_of_path(const osal_directory_t* const root, const char* const path,
                                       int* const out_directory)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    if (path[0] == '\0') {
        return open_directory(root->descriptor, ".", out_directory);
    }
    directory_entry_t entry;
    status_t status = open_parent(root, path, &entry);
    if (status == STATUS_OK) {
        status = open_directory(entry.directory, entry.name, out_directory);
        close_directory_of(&entry);
    }
    return status;
}

/// Describe an entry of a directory. STATUS_OK, STATUS_NOT_FOUND (also: neither directory nor file),
/// STATUS_DENIED, STATUS_IO.
static status_t describe_entry(const int directory, const char* const name,
                               osal_directory_about_t* const out_about)
{
    struct stat about;
    if (fstatat(directory, name, &about, AT_SYMLINK_NOFOLLOW) != 0) {
        return file_status_of(errno);
    }
    if (!S_ISDIR(about.st_mode) && !S_ISREG(about.st_mode)) {
        return STATUS_NOT_FOUND;
    }
    out_about->is_directory = S_ISDIR(about.st_mode);
    out_about->size         = out_about->is_directory ? 0U : (uint64_t)about.st_size;
    return STATUS_OK;
}

/// Open a regular file. Its type is checked before it is opened, since opening a device may have effects, and
/// again afterwards, since another program may have replaced it in between.
static status_t open_file(const osal_directory_t* const root, const char* const path, const int flags,
                          osal_file_t* const out_file)
{
    osal_directory_about_t about;
    directory_entry_t entry;
    status_t status = open_parent(root, path, &entry);
    if (status != STATUS_OK) {
        return status;
    }
    status = describe_entry(entry.directory, entry.name, &about);
    if ((status == STATUS_OK) && about.is_directory) {
        status = STATUS_NOT_FOUND;
    }
    if (status == STATUS_OK) {
        status = open_in(entry.directory, entry.name, flags, 0U, &out_file->descriptor);
    }
    close_directory_of(&entry);
    struct stat opened;
    if ((status == STATUS_OK) && ((fstat(out_file->descriptor, &opened) != 0) || !S_ISREG(opened.st_mode))) {
        osal_file_close(out_file);
        status = STATUS_NOT_FOUND;
    }
    return status;
}

/// End a change of names in a directory: if `status` is STATUS_OK, force the change to the disk. Close the
/// directory.
static status_t sync_and_close(const directory_entry_t* const entry, const status_t status)
{
    const bool is_synced = (status != STATUS_OK) || (fsync(entry->directory) == 0);
    close_directory_of(entry);
    return is_synced ? status : STATUS_IO;
}

status_t osal_directory_open(osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    root->descriptor = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    return (root->descriptor >= 0) ? STATUS_OK : file_status_of(errno);
}

void osal_directory_close(osal_directory_t* const root)
{
    FSW_ASSERT(root != NULL);
    if (root->descriptor >= 0) {
        (void)close(root->descriptor);
    }
    root->descriptor = -1;
}

status_t osal_directory_describe(const osal_directory_t* const root, const char* const path,
                                 osal_directory_about_t* const out_about)
{
    FSW_ASSERT((path != NULL) && (out_about != NULL));
    *out_about = (osal_directory_about_t){.is_directory = (path[0] == '\0')};
    if (out_about->is_directory) {
        return STATUS_OK;
    }
    directory_entry_t entry;
    status_t status = open_parent(root, path, &entry);
    if (status == STATUS_OK) {
        status = describe_entry(entry.directory, entry.name, out_about);
        close_directory_of(&entry);
    }
    return status;
}

status_t osal_directory_create(const osal_directory_t* const root, const char* const path)
{
    directory_entry_t entry;
    const status_t status = open_parent(root, path, &entry);
    if (status != STATUS_OK) {
        return status;
    }
    const bool is_made = mkdirat(entry.directory, entry.name, 0755U) == 0;
    return sync_and_close(&entry, is_made ? STATUS_OK : status_of_creation(errno));
}

/// Remove a name. `flags` are those of unlinkat.
static status_t remove_name(const osal_directory_t* const root, const char* const path, const int flags)
{
    osal_directory_about_t about;
    directory_entry_t entry;
    status_t status = open_parent(root, path, &entry);
    if (status != STATUS_OK) {
        return status;
    }
    status = describe_entry(entry.directory, entry.name, &about);
    if ((status == STATUS_OK) && (about.is_directory != (flags == AT_REMOVEDIR))) {
        status = STATUS_NOT_FOUND;
    }
    if ((status == STATUS_OK) && (unlinkat(entry.directory, entry.name, flags) != 0)) {
        status = ((errno == ENOTEMPTY) || (errno == EEXIST)) ? STATUS_FORBIDDEN : file_status_of(errno);
    }
    return sync_and_close(&entry, status);
}

status_t osal_directory_remove(const osal_directory_t* const root, const char* const path)
{
    return remove_name(root, path, AT_REMOVEDIR);
}

status_t osal_directory_remove_file(const osal_directory_t* const root, const char* const path)
{
    return remove_name(root, path, 0);
}

/// Reserve disk space for a new file. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t reserve_space(const int descriptor, const uint64_t room)
{
    struct statvfs disk;
    if (room == 0U) {
        return STATUS_OK;
    }
    if (room > (uint64_t)INT64_MAX) {
        return STATUS_FULL;
    }
    if (fallocate(descriptor, FALLOC_FL_KEEP_SIZE, 0, (off_t)room) == 0) {
        return STATUS_OK;
    }
    if (errno != EOPNOTSUPP) {
        return file_status_of_write(errno);
    }
    if (fstatvfs(descriptor, &disk) != 0) {
        return STATUS_IO;
    }
    return ((uint64_t)disk.f_bavail >= (room / disk.f_frsize)) ? STATUS_OK : STATUS_FULL;
}

status_t osal_directory_create_file(const osal_directory_t* const root, const char* const path,
                                    const uint64_t room)
{
    int descriptor = -1;
    directory_entry_t entry;
    status_t status = open_parent(root, path, &entry);
    if (status != STATUS_OK) {
        return status;
    }
    status = open_in(entry.directory, entry.name, O_WRONLY | O_CREAT | O_EXCL, 0644U, &descriptor);
    if (status == STATUS_OK) {
        status = reserve_space(descriptor, room);
        if ((status == STATUS_OK) && (fsync(descriptor) != 0)) {
            status = STATUS_IO;
        }
        (void)close(descriptor);
        if (status != STATUS_OK) {
            (void)unlinkat(entry.directory, entry.name, 0);
        }
    }
    return sync_and_close(&entry, status);
}

/// Rename without replacing an existing file.
static status_t rename_in(const directory_entry_t* const from, const directory_entry_t* const to)
{
    int result = renameat2(from->directory, from->name, to->directory, to->name, RENAME_NOREPLACE);
    if ((result != 0) && ((errno == EINVAL) || (errno == ENOSYS))) {
        // The file system may not support RENAME_NOREPLACE: then check first that the name is free. EINVAL
        // can also mean that a directory would be moved into itself; renameat reports this error again.
        struct stat about;
        if (fstatat(to->directory, to->name, &about, AT_SYMLINK_NOFOLLOW) == 0) {
            return STATUS_EXISTS;
        }
        result = renameat(from->directory, from->name, to->directory, to->name);
    }
    if (result == 0) {
        return STATUS_OK;
    }
    return (errno == EINVAL) ? STATUS_INVALID : status_of_creation(errno);
}

status_t osal_directory_rename(const osal_directory_t* const root, const char* const path,
                               const char* const new_path)
{
    osal_directory_about_t about;
    directory_entry_t from;
    directory_entry_t to;
    status_t status = open_parent(root, path, &from);
    if (status != STATUS_OK) {
        return status;
    }
    status = describe_entry(from.directory, from.name, &about);
    if (status == STATUS_OK) {
        status = open_parent(root, new_path, &to);
    }
    if (status == STATUS_OK) {
        status = sync_and_close(&to, rename_in(&from, &to));
    }
    return sync_and_close(&from, status);
}

/// Names collected for a listing: the first names after `after`, in ascending order.
typedef struct {
    const char* after;
    osal_directory_entry_t* entries;
    size_t capacity;
    size_t count;
} listing_t;

/// True if a name belongs to the listing: there is room, or the name comes before the last collected one.
static bool is_wanted(const listing_t* const listing, const char* const name)
{
    const bool is_name = (name[0] != '.') && (strlen(name) < OSAL_NAME_SIZE);
    return is_name && (strcmp(name, listing->after) > 0) &&
           ((listing->count < listing->capacity) ||
            (strcmp(name, listing->entries[listing->capacity - 1U].name) < 0));
}

/// Insert a name in order; if there is no room, the last name is dropped.
static void insert_name(listing_t* const listing, const char* const name, const bool is_directory)
{
    size_t position = (listing->count < listing->capacity) ? listing->count : (listing->capacity - 1U);
    listing->count += (listing->count < listing->capacity) ? 1U : 0U;
    for (; (position > 0U) && (strcmp(name, listing->entries[position - 1U].name) < 0); position--) {
        listing->entries[position] = listing->entries[position - 1U];
    }
    osal_directory_entry_t* const entry = &listing->entries[position];
    (void)memset(entry, 0, sizeof *entry);
    (void)memcpy(entry->name, name, strlen(name));
    entry->is_directory = is_directory;
}

status_t osal_directory_list(const osal_directory_t* const root, const char* const path,
                             const char* const after, osal_directory_entry_t* const entries,
                             const size_t capacity, size_t* const out_count)
{
    FSW_ASSERT((after != NULL) && (entries != NULL) && (capacity >= 1U) && (out_count != NULL));
    union {
        struct dirent64 first; // Gives the buffer the alignment of an entry.
        char octets[LISTING_SIZE];
    } block;
    listing_t listing = {.after = after, .entries = entries, .capacity = capacity};
    int directory     = -1;
    *out_count        = 0U;
    status_t status   = open_directory_of_path(root, path, &directory);
    if (status != STATUS_OK) {
        return status;
    }
    ssize_t size = getdents64(directory, block.octets, sizeof block.octets);
    while (size > 0) {
        for (ssize_t at = 0; at < size;) {
            const struct dirent64* const entry = (const struct dirent64*)(const void*)&block.octets[at];
            osal_directory_about_t about;
            if (is_wanted(&listing, entry->d_name) &&
                (describe_entry(directory, entry->d_name, &about) == STATUS_OK)) {
                insert_name(&listing, entry->d_name, about.is_directory);
            }
            at += entry->d_reclen;
        }
        size = getdents64(directory, block.octets, sizeof block.octets);
    }
    (void)close(directory);
    *out_count = listing.count;
    return (size == 0) ? STATUS_OK : STATUS_IO;
}

status_t osal_directory_read(const osal_directory_t* const root, const char* const path,
                             const uint64_t offset, uint8_t* const octets, const size_t size,
                             size_t* const out_size)
{
    FSW_ASSERT(((octets != NULL) || (size == 0U)) && (out_size != NULL));
    osal_file_t file;
    uint64_t end    = 0U;
    *out_size       = 0U;
    status_t status = open_file(root, path, O_RDONLY, &file);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_file_size(&file, &end);
    if ((status == STATUS_OK) && (offset < end)) {
        const size_t part = ((end - offset) < size) ? (size_t)(end - offset) : size;
        status            = osal_file_read_at(&file, offset, octets, part);
        *out_size         = (status == STATUS_OK) ? part : 0U;
    }
    osal_file_close(&file);
    return (status == STATUS_OK) ? STATUS_OK : STATUS_IO; // Another program may have cut the file meanwhile.
}

status_t osal_directory_write(const osal_directory_t* const root, const char* const path,
                              const uint64_t offset, const uint8_t* const octets, const size_t size)
{
    osal_file_t file;
    status_t status = open_file(root, path, O_WRONLY, &file);
    if (status == STATUS_OK) {
        status = osal_file_write_at(&file, offset, octets, size);
        osal_file_close(&file);
    }
    return status;
}

status_t osal_directory_sync(const osal_directory_t* const root, const char* const path)
{
    osal_file_t file;
    status_t status = open_file(root, path, O_WRONLY, &file);
    if (status == STATUS_OK) {
        status = osal_file_sync(&file);
        osal_file_close(&file);
    }
    return status;
}
