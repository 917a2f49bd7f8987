// SPDX-License-Identifier: Apache-2.0
#include "pus/st01/st01_verification.h"
#include "pus/st23/st23_internal.h"

#include <string.h>

enum {
    FOUND   = 8,
    SUMMARY = 13
};

enum { // Object types in the summary.
    DIRECTORY = 0,
    FILE_TYPE = 1
};

#define TEXT_SIZE_FIELD 2U // Size of the length field before a text [octets].

static pus_reply_t begin_search(pus_files_t* const files, pus_request_t* const request,
                                const pus_file_path_t* const root, const char* const pattern)
{
    pus_file_about_t about;
    const status_t status = st23_look(files, root, true, &about);
    if (status != STATUS_OK) {
        return st23_reply_of(files, status, 0U);
    }
    for (size_t i = 0U; i < files->config.search_count; i++) {
        pus_file_search_t* const search = &files->config.searches[i];
        if (!search->is_used) {
            (void)memset(search, 0, sizeof *search);
            search->is_used    = true;
            search->is_summary = (pattern == NULL);
            search->token      = request->token;
            search->root       = *root;
            search->directory  = *root;
            if (pattern != NULL) {
                (void)memcpy(search->pattern, pattern, sizeof search->pattern);
            }
            return pus_later();
        }
    }
    return st23_refuse(files, PUS_FAILURE_TABLE_FULL, (uint32_t)files->config.search_count);
}

pus_reply_t st23_find(void* const self, pus_request_t* const request)
{
    pus_files_t* const files             = self;
    char pattern[PUS_FILE_NAME_MAX + 1U] = {0};
    pus_file_path_t root;
    if (!pus_file_path_read(&request->reader, &root)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    const uint32_t offset = (uint32_t)request->reader.position;
    if (!pus_file_pattern_read(&request->reader, pattern)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    return begin_search(files, request, &root, pattern);
}

pus_reply_t st23_summarise(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    pus_file_path_t root;
    if (!pus_file_path_read(&request->reader, &root)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    return begin_search(files, request, &root, NULL);
}

/// Report the paths that were found. False: the process cannot take the report now.
static bool send(const pus_files_t* const files, pus_file_search_t* const search, const uint64_t now_ns)
{
    octet_writer_t writer = pus_tm_begin(files->config.process, PUS_SERVICE_FILES,
                                         search->is_summary ? SUMMARY : FOUND, search->token.source, now_ns);
    pus_file_path_write(&writer, &search->root);
    if (!search->is_summary) {
        pus_file_name_write(&writer, search->pattern);
    }
    octet_write_u16(&writer, search->count);
    octet_write_octets(&writer, search->data, search->size);
    if (pus_tm_send(files->config.process, &writer) != STATUS_OK) {
        return false;
    }
    search->count = 0U;
    search->size  = 0U;
    return true;
}

/// Returns the number of octets in a report for entries, that is, without path, pattern and count.
static size_t room_of(const pus_file_search_t* const search)
{
    const size_t pattern = search->is_summary ? 0U : (TEXT_SIZE_FIELD + strlen(search->pattern));
    return PUS_TM_DATA_MAX - (TEXT_SIZE_FIELD + 1U + strlen(search->root.text)) - pattern - sizeof(uint16_t);
}

/// Add an entry; send the earlier entries first if it does not fit. False: the process cannot take the report
/// now.
static bool add(const pus_files_t* const files, pus_file_search_t* const search,
                const pus_file_entry_t* const entry, const pus_file_path_t* const path, const uint64_t now_ns)
{
    const size_t room   = room_of(search);
    const size_t needed = search->is_summary ? (1U + TEXT_SIZE_FIELD + strlen(entry->name))
                                             : (TEXT_SIZE_FIELD + 1U + strlen(path->text));
    if (((search->size + needed) > room) && !send(files, search, now_ns)) {
        return false;
    }
    octet_writer_t writer = octet_writer(&search->data[search->size], needed);
    if (search->is_summary) {
        octet_write_u8(&writer, entry->is_directory ? DIRECTORY : FILE_TYPE);
        pus_file_name_write(&writer, entry->name);
    } else {
        pus_file_path_write(&writer, path);
    }
    search->size += needed;
    search->count++;
    return true;
}

/// Entry at which the search continues after an entry.
typedef enum {
    PASSED,  ///< The next entry.
    ENTERED, ///< The first entry in this entry, which is a directory.
    WAITING  ///< The same entry, in a later step: the process cannot take the report now.
} passage_t;

static passage_t pass(pus_files_t* const files, pus_file_search_t* const search,
                      const pus_file_entry_t* const entry, const uint64_t now_ns)
{
    pus_file_path_t path = search->directory;
    const bool is_good   = pus_file_name_is_good(entry->name) && pus_file_path_enter(&path, entry->name);
    const bool is_wanted = search->is_summary ||
                           (!entry->is_directory && pus_file_pattern_matches(search->pattern, entry->name));
    if (!is_good) {
        files->counters.skipped++;
    } else if (is_wanted && !add(files, search, entry, &path, now_ns)) {
        return WAITING;
    } else if (!search->is_summary && entry->is_directory) {
        search->directory = path;
        search->after[0]  = '\0';
        return ENTERED;
    } else {
        // The entry does not match, or it has been added.
    }
    (void)memcpy(search->after, entry->name, sizeof search->after);
    return PASSED;
}

/// Continue in the parent directory of a directory that was searched. False: the directory is the root of the
/// search.
static bool leave(pus_file_search_t* const search)
{
    if (pus_file_path_is_same(&search->directory, &search->root)) {
        return false;
    }
    const char* const name = pus_file_path_name(&search->directory);
    (void)memcpy(search->after, name, strlen(name) + 1U);
    pus_file_path_leave(&search->directory);
    return true;
}

/// Send the last report and end the request; if the process cannot take the report, the next step tries
/// again.
static void finish(const pus_files_t* const files, pus_file_search_t* const search, const uint64_t now_ns)
{
    if (send(files, search, now_ns)) {
        search->is_used = false;
        pus_verify_completed(files->config.process, &search->token, now_ns);
    }
}

/// Read one batch of entries of a directory.
static void step_search(pus_files_t* const files, pus_file_search_t* const search, const uint64_t now_ns)
{
    const pus_file_store_t* const store = &files->config.store;
    pus_file_entry_t entries[PUS_FILE_BATCH];
    size_t count = 0U;
    status_t status =
        store->list(store->context, search->directory.text, search->after, entries, PUS_FILE_BATCH, &count);
    const bool is_below = !pus_file_path_is_same(&search->directory, &search->root);
    // Another request or program has removed the directory meanwhile.
    if ((status == STATUS_NOT_FOUND) && is_below) {
        status = STATUS_OK;
        count  = 0U;
    }
    if (status != STATUS_OK) {
        files->counters.failed++;
        search->is_used             = false;
        const pus_failure_t failure = pus_failure(PUS_FAILURE_IO, (uint32_t)status);
        pus_verify_failed(files->config.process, &search->token, &failure, now_ns);
        return;
    }
    passage_t passage = PASSED;
    for (size_t i = 0U; (passage == PASSED) && (i < count); i++) {
        passage = pass(files, search, &entries[i], now_ns);
    }
    if ((passage == PASSED) && (count < PUS_FILE_BATCH) && !leave(search)) {
        finish(files, search, now_ns);
    }
}

void st23_step_searches(pus_files_t* const files, const uint64_t now_ns)
{
    for (size_t i = 0U; i < files->config.search_count; i++) {
        const size_t index              = files->next_search;
        pus_file_search_t* const search = &files->config.searches[index];
        files->next_search              = (index + 1U) % files->config.search_count;
        if (search->is_used) {
            step_search(files, search, now_ns);
            return;
        }
    }
}

bool st23_has_searches(const pus_files_t* const files)
{
    for (size_t i = 0U; i < files->config.search_count; i++) {
        if (files->config.searches[i].is_used) {
            return true;
        }
    }
    return false;
}
