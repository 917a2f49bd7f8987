// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/store_files.h"

#include "fsw/programs/file_medium.h"
#include "base/assertion.h"
#include "base/text.h"

static bool name_file(const component_runtime_t* const runtime, const unsigned index, char* const path)
{
    text_t text = text_in(path, RUN_PATH_MAX);
    text_add(&text, runtime->run->storage);
    text_add(&text, "/");
    text_add(&text, runtime->run->components[runtime->component].name);
    text_add(&text, ".store.");
    text_add_unsigned(&text, index);
    return !text.cut;
}

/// Open all files and write their directory entries to the disk. `path` becomes the path of the last file,
/// for the error text.
static status_t open_all(store_files_t* const stores, const component_runtime_t* const runtime,
                         const unsigned count, char* const path)
{
    status_t status = STATUS_OK;
    for (stores->count = 0U; (stores->count < count) && (status == STATUS_OK);) {
        osal_file_t* const file = &stores->files[stores->count];
        status = name_file(runtime, stores->count, path) ? osal_file_update(file, path) : STATUS_TOO_LARGE;
        if (status == STATUS_OK) {
            stores->media[stores->count] = file_medium(file);
            stores->count++;
        }
    }
    return (status == STATUS_OK) ? osal_file_sync_names(path) : status;
}

status_t store_files_open(store_files_t* const stores, component_runtime_t* const runtime,
                          const unsigned count)
{
    FSW_ASSERT((stores != NULL) && (runtime != NULL) && (count > 0U) && (count <= STORE_FILES_MAX));
    char path[RUN_PATH_MAX];
    const status_t status = open_all(stores, runtime, count, path);
    if (status != STATUS_OK) {
        text_t text = text_in(runtime->error, sizeof runtime->error);
        text_add(&text, "cannot keep packets in ");
        text_add(&text, path);
        text_add(&text, ": ");
        text_add(&text, status_text(status));
        text_add(&text, "; choose another directory with --storage");
        store_files_close(stores);
    }
    return status;
}

void store_files_close(store_files_t* const stores)
{
    FSW_ASSERT(stores != NULL);
    for (unsigned i = 0U; i < stores->count; i++) {
        osal_file_close(&stores->files[i]);
    }
    stores->count = 0U;
}
