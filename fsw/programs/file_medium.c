// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/file_medium.h"

#include "base/assertion.h"

static status_t read_file(void* const context, const uint64_t offset, uint8_t* const octets,
                          const size_t size)
{
    return osal_file_read_at(context, offset, octets, size);
}

static status_t write_file(void* const context, const uint64_t offset, const uint8_t* const octets,
                           const size_t size)
{
    return osal_file_write_at(context, offset, octets, size);
}

static status_t sync_file(void* const context)
{
    return (osal_file_sync(context) == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

static status_t size_of_file(void* const context, uint64_t* const out_size)
{
    return osal_file_size(context, out_size);
}

static status_t resize_file(void* const context, const uint64_t size)
{
    return osal_file_resize(context, size);
}

medium_t file_medium(osal_file_t* const file)
{
    FSW_ASSERT(file != NULL);
    return (medium_t){.context = file,
                      .read    = read_file,
                      .write   = write_file,
                      .sync    = sync_file,
                      .size    = size_of_file,
                      .resize  = resize_file};
}
