// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/record_store.h"

#include "fsw/programs/file_medium.h"
#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/console.h"

#define PIECE 4096U ///< Octets copied at a time.

static status_t report_error(component_runtime_t* const runtime, const char* const path,
                             const status_t status)
{
    text_t text = text_in(runtime->error, sizeof runtime->error);
    text_add(&text, "cannot keep records in ");
    text_add(&text, path);
    text_add(&text, ": ");
    text_add(&text, (status == STATUS_BUSY) ? "another flight uses this storage" : status_text(status));
    text_add(&text, "; choose another directory with --storage");
    return status;
}

/// Replace the sync of a medium if the program must not wait for the disk: the system writes later.
static status_t leave_to_system(void* const context)
{
    (void)context;
    return STATUS_OK;
}

static medium_t medium_of(record_store_t* const store, const unsigned index, const bool waits)
{
    medium_t medium = file_medium(&store->files[index]);
    if (!waits) {
        medium.sync = leave_to_system;
    }
    return (store->wrapper.open != NULL) ? store->wrapper.open(store->wrapper.context, index, medium)
                                         : medium;
}

static void close_files(record_store_t* const store, const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        osal_file_close(&store->files[i]);
    }
}

/// Write the path `<storage>/<component>.<kind>`; the caller may append to it.
static text_t name_of(const component_runtime_t* const runtime, const char* const kind, char* const path)
{
    text_t text = text_in(path, RUN_PATH_MAX);
    text_add(&text, runtime->run->storage);
    text_add(&text, "/");
    text_add(&text, runtime->run->components[runtime->component].name);
    text_add(&text, ".");
    text_add(&text, kind);
    return text;
}

static bool name_file(const component_runtime_t* const runtime, const unsigned index, char* const path)
{
    text_t text = name_of(runtime, "journal.", path);
    text_add_unsigned(&text, index);
    return !text.cut;
}

/// Create the file of the next copy of `path`; if all copies exist, replace the last one.
static status_t open_copy(osal_file_t* const copy, const char* const path, char* const out_path)
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < RECORD_STORE_COPIES) && (status == STATUS_OK); i++) {
        text_t text = text_in(out_path, RUN_PATH_MAX);
        text_add(&text, path);
        text_add(&text, ".damaged.");
        text_add_unsigned(&text, i);
        if (text.cut) {
            return STATUS_TOO_LARGE;
        }
        osal_file_t present;
        status = osal_file_open_read(&present, out_path);
        if (status == STATUS_OK) {
            osal_file_close(&present);
        }
    }
    return osal_file_create(copy, out_path);
}

static status_t copy_file(osal_file_t* const from, osal_file_t* const to)
{
    uint8_t octets[PIECE];
    uint64_t size   = 0U;
    status_t status = osal_file_size(from, &size);
    for (uint64_t offset = 0U; (status == STATUS_OK) && (offset < size); offset += PIECE) {
        const uint64_t left = size - offset;
        const size_t piece  = (left < PIECE) ? (size_t)left : PIECE;
        status              = osal_file_read_at(from, offset, octets, piece);
        if (status == STATUS_OK) {
            status = osal_file_write(to, octets, piece);
        }
    }
    return status;
}

typedef struct { // Source of the copy: a file; if it is null, octets in memory.
    osal_file_t* file;
    const uint8_t* octets;
    size_t size;
} original_t;

/// Copy the damaged data, remove an incomplete copy, and report the result on the console.
static status_t keep_copy(const char* const path, const original_t* const original)
{
    char copy_path[RUN_PATH_MAX] = {'\0'};
    osal_file_t copy;
    status_t status = open_copy(&copy, path, copy_path);
    if (status == STATUS_OK) {
        status = (original->file != NULL) ? copy_file(original->file, &copy)
                                          : osal_file_write(&copy, original->octets, original->size);
        status = (status == STATUS_OK) ? osal_file_sync(&copy) : status;
        osal_file_close(&copy);
        if (status != STATUS_OK) {
            (void)osal_file_remove(copy_path);
        }
    }
    char line[(2U * RUN_PATH_MAX) + 64U];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "damaged: ");
    text_add(&text, path);
    if (status == STATUS_OK) {
        text_add(&text, "; a copy is ");
        text_add(&text, copy_path);
    } else {
        text_add(&text, "; no copy: ");
        text_add(&text, status_text(status));
    }
    osal_console_print_error(line);
    return status;
}

bool record_store_keep(const component_runtime_t* const runtime, const char* const kind,
                       const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((runtime != NULL) && (kind != NULL) && (octets != NULL));
    char path[RUN_PATH_MAX];
    const original_t original = {.octets = octets, .size = size};
    return !name_of(runtime, kind, path).cut && (keep_copy(path, &original) == STATUS_OK);
}

static status_t keep_file(record_store_t* const store, const unsigned index)
{
    char path[RUN_PATH_MAX];
    const original_t original = {.file = &store->files[index]};
    return name_file(store->runtime, index, path) ? keep_copy(path, &original) : STATUS_TOO_LARGE;
}

static bool keep_media(void* const context)
{
    record_store_t* const store = (record_store_t*)context;
    const status_t first        = keep_file(store, 0U);
    const status_t second       = keep_file(store, 1U);
    return (first == STATUS_OK) && (second == STATUS_OK);
}

status_t record_store_open(record_store_t* const store, component_runtime_t* const runtime,
                           journal_slot_t* const slots, const size_t capacity, const bool waits)
{
    FSW_ASSERT((store != NULL) && (runtime != NULL) && (slots != NULL));
    char path[RUN_PATH_MAX];
    store->runtime = runtime;
    for (unsigned i = 0U; i < 2U; i++) {
        status_t status =
            name_file(runtime, i, path) ? osal_file_update(&store->files[i], path) : STATUS_TOO_LARGE;
        const bool is_open = (status == STATUS_OK);
        if (is_open) {
            status = osal_file_lock(&store->files[i]);
        }
        if (status != STATUS_OK) {
            close_files(store, is_open ? (i + 1U) : i);
            return report_error(runtime, path, status);
        }
    }
    const status_t named = osal_file_sync_names(path); // Both files are in one directory.
    if (named != STATUS_OK) {
        close_files(store, 2U);
        return report_error(runtime, runtime->run->storage, named);
    }
    const journal_configuration_t configuration = {
        .media        = {medium_of(store, 0U, waits), medium_of(store, 1U, waits)},
        .limit        = RECORD_STORE_LIMIT,
        .slack        = RECORD_STORE_SLACK,
        .moves        = RECORD_STORE_MOVES,
        .slots        = slots,
        .capacity     = capacity,
        .keep         = keep_media,
        .keep_context = store};
    const status_t status = journal_open(&store->journal, &configuration);
    if (status != STATUS_OK) {
        record_store_close(store);
        (void)name_of(runtime, "journal.0 or .1", path); // The journal does not tell which file failed.
        return report_error(runtime, path, status);
    }
    return STATUS_OK;
}

void record_store_close(record_store_t* const store)
{
    FSW_ASSERT(store != NULL);
    close_files(store, 2U);
}
