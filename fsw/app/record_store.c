// SPDX-License-Identifier: Apache-2.0
#include "fsw/app/record_store.h"

#include "fsw/app/file_medium.h"
#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/text.h"

#define JOURNAL_LIMIT (64U * 1024U * 1024U) ///< Of each file [octets].
#define JOURNAL_SLACK (1024U * 1024U)       ///< Dead octets before a compaction.

static status_t complain(seat_t* const seat, const char* const path, const status_t status)
{
    text_t text = text_in(seat->error, sizeof seat->error);
    text_add(&text, "cannot keep records in ");
    text_add(&text, path);
    text_add(&text, ": ");
    text_add(&text, (status == STATUS_BUSY) ? "another flight uses this storage" : status_text(status));
    return status;
}

static status_t leave_to_system(void* const context)
{
    (void)context;
    return STATUS_OK;
}

static medium_t medium_of(osal_file_t* const file, const bool waits)
{
    medium_t medium = file_medium(file);
    if (!waits) {
        medium.sync = leave_to_system;
    }
    return medium;
}

static void close_files(record_store_t* const store, const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        osal_file_close(&store->files[i]);
    }
}

static bool name_file(const seat_t* const seat, const unsigned index, char* const path)
{
    text_t text = text_in(path, RUN_PATH_MAX);
    text_add(&text, seat->run->storage);
    text_add(&text, "/");
    text_add(&text, seat->run->components[seat->component].name);
    text_add(&text, ".journal.");
    text_add_unsigned(&text, index);
    return !text.cut;
}

status_t record_store_open(record_store_t* const store, seat_t* const seat, journal_slot_t* const slots,
                           const size_t capacity, const bool waits)
{
    FSW_ASSERT((store != NULL) && (seat != NULL) && (slots != NULL));
    char path[RUN_PATH_MAX];
    for (unsigned i = 0U; i < 2U; i++) {
        status_t status =
            name_file(seat, i, path) ? osal_file_update(&store->files[i], path) : STATUS_TOO_LARGE;
        const bool is_open = (status == STATUS_OK);
        if (is_open) {
            status = osal_file_lock(&store->files[i]);
        }
        if (status != STATUS_OK) {
            close_files(store, is_open ? (i + 1U) : i);
            return complain(seat, path, status);
        }
    }
    const status_t named = osal_file_sync_names(path);
    if (named != STATUS_OK) {
        close_files(store, 2U);
        return complain(seat, path, named);
    }
    const journal_configuration_t configuration = {
        .media    = {medium_of(&store->files[0], waits), medium_of(&store->files[1], waits)},
        .limit    = JOURNAL_LIMIT,
        .slack    = JOURNAL_SLACK,
        .slots    = slots,
        .capacity = capacity};
    const status_t status = journal_open(&store->journal, &configuration);
    if (status != STATUS_OK) {
        record_store_close(store);
        return complain(seat, path, status);
    }
    return STATUS_OK;
}

void record_store_close(record_store_t* const store)
{
    FSW_ASSERT(store != NULL);
    close_files(store, 2U);
}
