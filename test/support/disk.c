// SPDX-License-Identifier: Apache-2.0
#include "test/support/disk.h"

#include "unity.h"

#include <string.h>

disk_t disk;

/// True if this call must fail.
static bool fails(void)
{
    disk.calls++;
    return disk.calls == disk.fail_call;
}

disk_file_t* disk_find(const char* const path)
{
    for (size_t i = 0U; i < DISK_FILES_MAX; i++) {
        if (disk.files[i].is_used && (strcmp(disk.files[i].path, path) == 0)) {
            return &disk.files[i];
        }
    }
    return NULL;
}

static disk_file_t* add(const char* const path, const bool is_directory)
{
    for (size_t i = 0U; i < DISK_FILES_MAX; i++) {
        disk_file_t* const file = &disk.files[i];
        if (!file->is_used) {
            *file = (disk_file_t){.is_used = true, .is_directory = is_directory};
            strcpy(file->path, path);
            return file;
        }
    }
    TEST_FAIL_MESSAGE("no free file");
    return NULL;
}

void disk_directory(const char* const path)
{
    (void)add(path, true);
}

static void give_octets(disk_file_t* const file)
{
    TEST_ASSERT_TRUE(disk.contents < DISK_CONTENTS);
    file->octets = disk.octets[disk.contents];
    disk.contents++;
}

disk_file_t* disk_file(const char* const path, const uint64_t size, const uint8_t first)
{
    disk_file_t* const file = add(path, false);
    file->size              = size;
    if ((size > 0U) && (size <= DISK_FILE_SIZE)) {
        give_octets(file);
        for (size_t i = 0U; i < size; i++) {
            file->octets[i] = (uint8_t)(first + (i / 251U) + i);
        }
    }
    return file;
}

void disk_remove(const char* const path)
{
    disk_find(path)->is_used = false;
}

/// True if the directory of a path exists.
static bool has_directory(const char* const path)
{
    pus_file_path_t directory;
    strcpy(directory.text, path);
    pus_file_path_leave(&directory);
    const disk_file_t* const file = disk_find(directory.text);
    return (file != NULL) && file->is_directory;
}

static status_t describe(void* const context, const char* const path, pus_file_about_t* const out_about)
{
    (void)context;
    const disk_file_t* const file = disk_find(path);
    if (fails()) {
        return disk.failure;
    }
    if (file == NULL) {
        return STATUS_NOT_FOUND;
    }
    *out_about = (pus_file_about_t){.is_directory = file->is_directory, .size = file->size};
    return STATUS_OK;
}

static status_t make(const char* const path, const bool is_directory)
{
    if (fails()) {
        return disk.failure;
    }
    if (disk_find(path) != NULL) {
        return STATUS_EXISTS;
    }
    if (!has_directory(path)) {
        return STATUS_NOT_FOUND;
    }
    (void)add(path, is_directory);
    return STATUS_OK;
}

static status_t create_file(void* const context, const char* const path, const uint64_t room)
{
    (void)context;
    disk.room = room;
    return make(path, false);
}

static status_t create_directory(void* const context, const char* const path)
{
    (void)context;
    return make(path, true);
}

static status_t remove_it(const char* const path, const bool is_directory)
{
    disk_file_t* const file = disk_find(path);
    if (fails()) {
        return disk.failure;
    }
    if ((file == NULL) || (file->is_directory != is_directory)) {
        return STATUS_NOT_FOUND;
    }
    for (size_t i = 0U; i < DISK_FILES_MAX; i++) {
        const disk_file_t* const other = &disk.files[i];
        if (is_directory && other->is_used && (other != file) &&
            (strncmp(other->path, path, strlen(path)) == 0) && (other->path[strlen(path)] == '/')) {
            return STATUS_FORBIDDEN;
        }
    }
    file->is_used = false;
    return STATUS_OK;
}

static status_t remove_file(void* const context, const char* const path)
{
    (void)context;
    return remove_it(path, false);
}

static status_t remove_directory(void* const context, const char* const path)
{
    (void)context;
    return remove_it(path, true);
}

static status_t rename_entry(void* const context, const char* const path, const char* const new_path)
{
    (void)context;
    if (fails()) {
        return disk.failure;
    }
    if ((disk_find(path) == NULL) || !has_directory(new_path)) {
        return STATUS_NOT_FOUND;
    }
    if (disk_find(new_path) != NULL) {
        return STATUS_EXISTS;
    }
    const size_t length = strlen(path);
    for (size_t i = 0U; i < DISK_FILES_MAX; i++) {
        disk_file_t* const file = &disk.files[i];
        const bool is_in        = file->is_used && (strncmp(file->path, path, length) == 0) &&
                           ((file->path[length] == '\0') || (file->path[length] == '/'));
        if (is_in) {
            char changed[2U * PUS_FILE_PATH_SIZE];
            strcpy(changed, new_path);
            strcat(changed, &file->path[length]);
            TEST_ASSERT_TRUE(strlen(changed) < sizeof file->path);
            strcpy(file->path, changed);
        }
    }
    return STATUS_OK;
}

/// Returns the name of a file within a directory; null if the file is not in the directory.
static const char* name_in(const disk_file_t* const file, const char* const path)
{
    pus_file_path_t whole;
    strcpy(whole.text, file->path);
    pus_file_path_leave(&whole);
    const bool is_in        = file->is_used && (file->path[0] != '\0') && (strcmp(whole.text, path) == 0);
    const char* const slash = strrchr(file->path, '/');
    return !is_in ? NULL : ((slash != NULL) ? &slash[1] : file->path);
}

static status_t list(void* const context, const char* const path, const char* const after,
                     pus_file_entry_t* const entries, const size_t capacity, size_t* const out_count)
{
    (void)context;
    const char* last = after;
    *out_count       = 0U;
    if (fails()) {
        return disk.failure;
    }
    const disk_file_t* const directory = disk_find(path);
    if ((directory == NULL) || !directory->is_directory) {
        return STATUS_NOT_FOUND;
    }
    for (const disk_file_t* next = directory; (next != NULL) && (*out_count < capacity);) {
        const char* first = NULL;
        next              = NULL;
        for (size_t i = 0U; i < DISK_FILES_MAX; i++) {
            const char* const name = name_in(&disk.files[i], path);
            if ((name != NULL) && (strcmp(name, last) > 0) &&
                ((first == NULL) || (strcmp(name, first) < 0))) {
                first = name;
                next  = &disk.files[i];
            }
        }
        if (next != NULL) {
            strcpy(entries[*out_count].name, first);
            entries[*out_count].is_directory = next->is_directory;
            last                             = first;
            (*out_count)++;
        }
    }
    return STATUS_OK;
}

static status_t read_octets(void* const context, const char* const path, const uint64_t offset,
                            uint8_t* const octets, const size_t size, size_t* const out_size)
{
    (void)context;
    const disk_file_t* const file = disk_find(path);
    *out_size                     = 0U;
    if (fails()) {
        return disk.failure;
    }
    if ((file == NULL) || file->is_directory) {
        return STATUS_NOT_FOUND;
    }
    const uint64_t left = (offset < file->size) ? (file->size - offset) : 0U;
    *out_size           = (left < size) ? (size_t)left : size;
    if (*out_size > 0U) {
        memcpy(octets, &file->octets[offset], *out_size);
    }
    return STATUS_OK;
}

static status_t write_octets(void* const context, const char* const path, const uint64_t offset,
                             const uint8_t* const octets, const size_t size)
{
    (void)context;
    disk_file_t* const file = disk_find(path);
    if (fails()) {
        return disk.failure;
    }
    if ((file == NULL) || file->is_directory) {
        return STATUS_NOT_FOUND;
    }
    if (file->octets == NULL) {
        give_octets(file);
    }
    TEST_ASSERT_TRUE((offset + size) <= DISK_FILE_SIZE);
    memcpy(&file->octets[offset], octets, size);
    file->size = ((offset + size) > file->size) ? (offset + size) : file->size;
    return STATUS_OK;
}

static status_t sync_file(void* const context, const char* const path)
{
    (void)context;
    if (fails()) {
        return disk.failure;
    }
    TEST_ASSERT_NOT_NULL(disk_find(path));
    disk.syncs++;
    return STATUS_OK;
}

void disk_start(void)
{
    memset(&disk, 0, sizeof disk);
    disk.failure = STATUS_IO;
    disk_directory("");
}

pus_file_store_t disk_store(void)
{
    return (pus_file_store_t){.describe         = describe,
                              .create_file      = create_file,
                              .remove_file      = remove_file,
                              .create_directory = create_directory,
                              .remove_directory = remove_directory,
                              .rename           = rename_entry,
                              .list             = list,
                              .read             = read_octets,
                              .write            = write_octets,
                              .sync             = sync_file};
}
