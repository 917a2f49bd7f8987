// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/file_store.h"

#include "base/assertion.h"
#include "base/capacities.h"

#include <string.h>

static status_t describe(void* const context, const char* const path, pus_file_about_t* const out_about)
{
    osal_directory_about_t about;
    const status_t status = osal_directory_describe(context, path, &about);
    *out_about            = (pus_file_about_t){.is_directory = about.is_directory, .size = about.size};
    return status;
}

static status_t create_file(void* const context, const char* const path, const uint64_t room)
{
    return osal_directory_create_file(context, path, room);
}

static status_t remove_file(void* const context, const char* const path)
{
    return osal_directory_remove_file(context, path);
}

static status_t create_directory(void* const context, const char* const path)
{
    return osal_directory_create(context, path);
}

static status_t remove_directory(void* const context, const char* const path)
{
    return osal_directory_remove(context, path);
}

static status_t rename_entry(void* const context, const char* const path, const char* const new_path)
{
    return osal_directory_rename(context, path, new_path);
}

static status_t list(void* const context, const char* const path, const char* const after,
                     pus_file_entry_t* const entries, const size_t capacity, size_t* const out_count)
{
    osal_directory_entry_t batch[PUS_FILE_BATCH];
    FSW_ASSERT(capacity <= PUS_FILE_BATCH);
    const status_t status = osal_directory_list(context, path, after, batch, capacity, out_count);
    for (size_t i = 0U; i < *out_count; i++) {
        (void)memcpy(entries[i].name, batch[i].name, sizeof entries[i].name);
        entries[i].is_directory = batch[i].is_directory;
    }
    return status;
}

static status_t read_file(void* const context, const char* const path, const uint64_t offset,
                          uint8_t* const octets, const size_t size, size_t* const out_size)
{
    return osal_directory_read(context, path, offset, octets, size, out_size);
}

static status_t write_file(void* const context, const char* const path, const uint64_t offset,
                           const uint8_t* const octets, const size_t size)
{
    return osal_directory_write(context, path, offset, octets, size);
}

static status_t sync_file(void* const context, const char* const path)
{
    return osal_directory_sync(context, path);
}

CAPACITY_CHECK(names_have_the_size_of_the_service, OSAL_NAME_SIZE == (PUS_FILE_NAME_MAX + 1U));

pus_file_store_t file_store(osal_directory_t* const root)
{
    FSW_ASSERT(root != NULL);
    return (pus_file_store_t){.context          = root,
                              .describe         = describe,
                              .create_file      = create_file,
                              .remove_file      = remove_file,
                              .create_directory = create_directory,
                              .remove_directory = remove_directory,
                              .rename           = rename_entry,
                              .list             = list,
                              .read             = read_file,
                              .write            = write_file,
                              .sync             = sync_file};
}
