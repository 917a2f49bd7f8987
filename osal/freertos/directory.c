// SPDX-License-Identifier: Apache-2.0
// Semihosting has no directories: it opens, removes and renames files by their paths only.
#include "osal/include/osal/directory.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_directory_open(osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    root->descriptor = -1;
    return STATUS_UNSUPPORTED;
}

void osal_directory_close(osal_directory_t* const root)
{
    FSW_ASSERT(root != NULL);
    root->descriptor = -1;
}

status_t osal_directory_describe(const osal_directory_t* const root, const char* const path,
                                 osal_directory_about_t* const out_about)
{
    FSW_ASSERT((root != NULL) && (path != NULL) && (out_about != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_create(const osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_remove(const osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_create_file(const osal_directory_t* const root, const char* const path,
                                    const uint64_t room)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    (void)room;
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_remove_file(const osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_rename(const osal_directory_t* const root, const char* const path,
                               const char* const new_path)
{
    FSW_ASSERT((root != NULL) && (path != NULL) && (new_path != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_list(const osal_directory_t* const root, const char* const path,
                             const char* const after, osal_directory_entry_t* const entries,
                             const size_t capacity, size_t* const out_count)
{
    FSW_ASSERT((root != NULL) && (path != NULL) && (after != NULL) && (entries != NULL) &&
               (out_count != NULL));
    (void)capacity;
    *out_count = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_read(const osal_directory_t* const root, const char* const path,
                             const uint64_t offset, uint8_t* const octets, const size_t size,
                             size_t* const out_size)
{
    FSW_ASSERT((root != NULL) && (path != NULL) && (octets != NULL) && (out_size != NULL));
    (void)offset;
    (void)size;
    *out_size = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_write(const osal_directory_t* const root, const char* const path,
                              const uint64_t offset, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((root != NULL) && (path != NULL) && (octets != NULL));
    (void)offset;
    (void)size;
    return STATUS_UNSUPPORTED;
}

status_t osal_directory_sync(const osal_directory_t* const root, const char* const path)
{
    FSW_ASSERT((root != NULL) && (path != NULL));
    return STATUS_UNSUPPORTED;
}
