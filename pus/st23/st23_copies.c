// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"
#include "pus/st01/st01_verification.h"
#include "pus/st23/st23_internal.h"

#include <string.h>

enum {
    SUSPEND         = 16, // The same request for a repository path has the subtype + OF_PATH.
    RESUME          = 17,
    ABORT           = 18,
    OF_PATH         = 3,
    STATUS_REPORT   = 23,
    INTERVAL_RECORD = 4 // Size of the record of the reporting interval [octets].
};

#define QUARTERS 4U
#define PERCENT 100U

/// True if a request of this life has started the copy, so that other requests can name it.
static bool is_active(const pus_file_copy_t* const copy)
{
    return copy->status < PUS_FILE_COPY_FREE;
}

bool st23_is_in_use(const pus_files_t* const files, const pus_file_path_t* const path)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        const pus_file_copy_t* const copy = &files->config.copies[i];
        if (is_active(copy) &&
            (pus_file_path_is_within(&copy->source, path) || pus_file_path_is_within(&copy->target, path))) {
            return true;
        }
    }
    return false;
}

bool st23_is_claimed(const pus_files_t* const files, const pus_file_path_t* const path)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        const pus_file_copy_t* const copy = &files->config.copies[i];
        if (is_active(copy) && pus_file_path_is_same(&copy->target, path)) {
            return true;
        }
    }
    return false;
}

static pus_file_copy_t* find_copy(const pus_files_t* const files, const uint16_t id)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        pus_file_copy_t* const copy = &files->config.copies[i];
        if (is_active(copy) && (copy->id == id)) {
            return copy;
        }
    }
    return NULL;
}

static pus_file_copy_t* free_copy(const pus_files_t* const files)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        if (files->config.copies[i].status == PUS_FILE_COPY_FREE) {
            return &files->config.copies[i];
        }
    }
    return NULL;
}

static uint32_t key_of(const pus_files_t* const files, const pus_file_copy_t* const copy)
{
    return ST23_KEY_COPY + (uint32_t)(copy - files->config.copies);
}

// ---- Beginning ----

/// Content of TC[23,14] or TC[23,15].
typedef struct {
    uint16_t id;
    st23_request_path_t source;
    st23_request_path_t target;
    pus_file_about_t about; ///< Attributes of the source.
} copy_request_t;

/// Read the paths of a request and check that its source exists and its target does not. A reply other than
/// PUS_DONE ends the request with this reply.
static pus_reply_t read_copy_request(pus_files_t* const files, pus_request_t* const request,
                                     copy_request_t* const out_wanted)
{
    pus_file_about_t about;
    out_wanted->id = octet_read_u16(&request->reader);
    if (!st23_read_path(request, &out_wanted->source)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, out_wanted->source.bad_offset);
    }
    if (!st23_read_path(request, &out_wanted->target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, out_wanted->target.bad_offset);
    }
    if (find_copy(files, out_wanted->id) != NULL) {
        return st23_refuse(files, PUS_FAILURE_EXISTS, out_wanted->id);
    }
    status_t status = st23_look(files, &out_wanted->source.path, false, &out_wanted->about);
    if (status != STATUS_OK) {
        return st23_reply_of(files, status, out_wanted->source.name_offset);
    }
    pus_file_path_t parent = out_wanted->target.path;
    pus_file_path_leave(&parent);
    status = st23_look(files, &parent, true, &about);
    if (status != STATUS_OK) {
        return st23_reply_of(files, status, out_wanted->target.directory_offset);
    }
    const pus_file_store_t* const store = &files->config.store;
    status = store->describe(store->context, out_wanted->target.path.text, &about);
    if ((status == STATUS_OK) || st23_is_claimed(files, &out_wanted->target.path)) {
        status = STATUS_EXISTS;
    } else if (status == STATUS_NOT_FOUND) {
        status = STATUS_OK;
    } else {
        // Keep the status of the store.
    }
    return st23_reply_of(files, status, out_wanted->target.name_offset);
}

/// Compose the temporary name of a target. No request can name this file, because its name begins with a dot.
static void name_part(pus_file_copy_t* const copy)
{
    copy->part = copy->target;
    pus_file_path_leave(&copy->part);
    const size_t length = strlen(copy->part.text);
    text_t text         = text_in(&copy->part.text[length], sizeof copy->part.text - length);
    text_add(&text, (length > 0U) ? "/.copy-" : ".copy-");
    text_add_unsigned(&text, copy->id);
}

/// Free the entry of a copy, and delete its temporary file if there is one.
static void forget(pus_files_t* const files, pus_file_copy_t* const copy, const bool has_part)
{
    const pus_file_store_t* const store = &files->config.store;
    if (has_part) {
        (void)store->remove_file(store->context, copy->part.text);
    }
    // Without the erasure, the next life would look for a temporary file that does not exist.
    (void)st23_forget(files, key_of(files, copy));
    copy->status = PUS_FILE_COPY_FREE;
}

static void remove_leftover(pus_files_t* const files, pus_file_copy_t* const copy)
{
    forget(files, copy, true);
    (void)st23_commit(files); // If the commit fails, the next life tries again.
    files->counters.removed++;
}

/// Remove the file that an earlier life has left under the temporary name of a new copy. Otherwise a later
/// step would take the temporary file of the new copy for it, and remove it.
static void remove_leftover_of(pus_files_t* const files, const pus_file_copy_t* const copy)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        pus_file_copy_t* const other = &files->config.copies[i];
        if ((other->status == PUS_FILE_COPY_LEFT) && pus_file_path_is_same(&other->part, &copy->part)) {
            remove_leftover(files, other);
        }
    }
}

pus_reply_t st23_copy(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    copy_request_t wanted;
    const pus_reply_t reply = read_copy_request(files, request, &wanted);
    if (reply.kind != PUS_DONE) {
        return reply;
    }
    pus_file_copy_t* const copy = free_copy(files);
    if (copy == NULL) {
        return st23_refuse(files, PUS_FAILURE_TABLE_FULL, (uint32_t)files->config.copy_count);
    }
    *copy = (pus_file_copy_t){.status = PUS_FILE_COPY_PENDING,
                              .id     = wanted.id,
                              .token  = request->token,
                              .size   = wanted.about.size,
                              .source = wanted.source.path,
                              .target = wanted.target.path};
    name_part(copy);
    remove_leftover_of(files, copy);
    const status_t status =
        st23_keep(files, key_of(files, copy), (const uint8_t*)copy->part.text, strlen(copy->part.text));
    if (status != STATUS_OK) {
        copy->status = PUS_FILE_COPY_FREE;
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    return pus_later();
}

pus_reply_t st23_move(void* const self, pus_request_t* const request)
{
    pus_files_t* const files            = self;
    const pus_file_store_t* const store = &files->config.store;
    copy_request_t wanted;
    const pus_reply_t reply = read_copy_request(files, request, &wanted);
    if (reply.kind != PUS_DONE) {
        return reply;
    }
    if (st23_is_locked(files, &wanted.source.path) || st23_is_in_use(files, &wanted.source.path)) {
        return st23_refuse(files, PUS_FAILURE_STATE, wanted.source.name_offset);
    }
    const status_t status = store->rename(store->context, wanted.source.path.text, wanted.target.path.text);
    return st23_reply_of(files, status, wanted.target.name_offset);
}

// ---- Changing ----

/// Remove the temporary file of a failed or aborted copy, and end its request.
static void end_copy(pus_files_t* const files, pus_file_copy_t* const copy, const pus_failure_t failure,
                     pus_app_process_t* const process, const uint64_t now_ns)
{
    forget(files, copy, copy->is_begun);
    pus_verify_ended(process, &copy->token, failure, now_ns);
}

static bool may_change(const pus_file_copy_t* const copy, const uint8_t change)
{
    const bool is_on_hold = (copy->status == PUS_FILE_COPY_ON_HOLD);
    return (change == ABORT) || (is_on_hold == (change == RESUME));
}

static void change_copy(pus_files_t* const files, pus_file_copy_t* const copy, const uint8_t change,
                        const pus_request_t* const request)
{
    if (change == ABORT) {
        files->counters.aborted++;
        end_copy(files, copy, pus_failure(PUS_FAILURE_ABORTED, 0U), request->process, request->now_ns);
    } else if (change == SUSPEND) {
        copy->status = PUS_FILE_COPY_ON_HOLD;
    } else {
        copy->status = copy->is_begun ? PUS_FILE_COPY_RUNNING : PUS_FILE_COPY_PENDING;
    }
}

pus_reply_t st23_change_copies(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    const uint8_t count      = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint16_t id           = octet_read_u16(&request->reader);
        pus_file_copy_t* const copy = find_copy(files, id);
        if ((copy != NULL) && may_change(copy, request->token.subtype)) {
            pus_request_perform(request);
            change_copy(files, copy, request->token.subtype, request);
        } else {
            files->counters.refused++;
            pus_request_refuse(request, i, (copy == NULL) ? PUS_FAILURE_UNKNOWN_ID : PUS_FAILURE_STATE, id);
        }
    }
    return pus_done();
}

pus_reply_t st23_change_copies_of_path(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    const uint8_t change     = (uint8_t)(request->token.subtype - OF_PATH);
    pus_file_about_t about;
    pus_file_path_t path;
    if (!pus_file_path_read(&request->reader, &path)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    const status_t status = st23_look(files, &path, true, &about);
    if (status != STATUS_OK) {
        return st23_reply_of(files, status, 0U);
    }
    pus_request_perform(request);
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        pus_file_copy_t* const copy = &files->config.copies[i];
        const bool is_involved      = is_active(copy) && (pus_file_path_is_within(&copy->source, &path) ||
                                                     pus_file_path_is_within(&copy->target, &path));
        if (is_involved && may_change(copy, change)) {
            change_copy(files, copy, change, request);
        }
    }
    return pus_done();
}

// ---- Status report ----

pus_reply_t st23_enable_status_report(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    uint8_t record[INTERVAL_RECORD];
    const uint32_t interval = octet_read_u32(&request->reader);
    if (interval == 0U) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    octets_put_u32(record, interval);
    const status_t status = st23_keep(files, ST23_KEY_REPORTING, record, sizeof record);
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    files->interval        = interval;
    files->is_interval_new = true;
    return pus_done();
}

pus_reply_t st23_disable_status_report(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    (void)request;
    if ((files->interval != 0U) && (st23_forget(files, ST23_KEY_REPORTING) != STATUS_OK)) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)STATUS_IO);
    }
    files->interval = 0U;
    return pus_done();
}

static void report_status(pus_files_t* const files, const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(files->config.process, PUS_SERVICE_FILES, STATUS_REPORT, PUS_USER_GROUND, now_ns);
    uint16_t count = 0U;
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        if (is_active(&files->config.copies[i])) {
            count++;
        }
    }
    octet_write_u16(&writer, count);
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        const pus_file_copy_t* const copy = &files->config.copies[i];
        if (is_active(copy)) {
            octet_write_u16(&writer, copy->id);
            octet_write_u8(&writer, (uint8_t)copy->status);
            const uint64_t percent = (copy->size > 0U) ? ((copy->done * PERCENT) / copy->size) : 0U;
            octet_write_u8(&writer, (uint8_t)percent);
        }
    }
    (void)pus_tm_post(files->config.process, &writer); // The process counts lost reports.
}

/// Send the status report if it is due. The first one is sent one interval after the first step in which
/// reports are enabled.
static void report_if_due(pus_files_t* const files, const uint64_t now_ns, const uint32_t cycle)
{
    if (files->interval == 0U) {
        return;
    }
    if (files->is_interval_new) {
        files->is_interval_new = false;
        files->reported_cycle  = cycle;
    }
    const uint32_t passed = cycle - files->reported_cycle;
    if (passed >= files->interval) {
        files->reported_cycle += passed - (passed % files->interval);
        report_status(files, now_ns);
    }
}

// ---- Copying ----

/// Create the temporary file. STATUS_OK, or the status of the store.
static status_t begin_copy(const pus_files_t* const files, pus_file_copy_t* const copy)
{
    const pus_file_store_t* const store = &files->config.store;
    status_t status                     = store->create_file(store->context, copy->part.text, copy->size);
    if (status == STATUS_EXISTS) { // A copy of an earlier life has left the file.
        (void)store->remove_file(store->context, copy->part.text);
        status = store->create_file(store->context, copy->part.text, copy->size);
    }
    copy->is_begun = (status == STATUS_OK);
    copy->status   = PUS_FILE_COPY_RUNNING;
    return status;
}

/// Copy one slice. STATUS_OK; STATUS_TRUNCATED (the source has become shorter since the request), or the
/// status of the store.
static status_t copy_slice(pus_files_t* const files, pus_file_copy_t* const copy)
{
    const pus_file_store_t* const store = &files->config.store;
    const uint64_t left                 = copy->size - copy->done;
    const size_t wanted                 = (left < PUS_FILE_SLICE) ? (size_t)left : PUS_FILE_SLICE;
    size_t size                         = 0U;
    status_t status = store->read(store->context, copy->source.text, copy->done, files->slice, wanted, &size);
    if ((status == STATUS_OK) && (size < wanted)) {
        status = STATUS_TRUNCATED;
    }
    if (status == STATUS_OK) {
        status = store->write(store->context, copy->part.text, copy->done, files->slice, size);
    }
    copy->done += (status == STATUS_OK) ? size : 0U;
    return status;
}

/// Rename the complete file to its target. STATUS_OK, or the status of the store.
static status_t finish_copy(const pus_files_t* const files, const pus_file_copy_t* const copy)
{
    const pus_file_store_t* const store = &files->config.store;
    const status_t status               = store->sync(store->context, copy->part.text);
    return (status == STATUS_OK) ? store->rename(store->context, copy->part.text, copy->target.text) : status;
}

static void report_progress(pus_files_t* const files, pus_file_copy_t* const copy, const uint64_t now_ns)
{
    while (((copy->quarters + 1U) < QUARTERS) &&
           ((copy->done * QUARTERS) >= (copy->size * (copy->quarters + 1ULL)))) {
        copy->quarters++;
        pus_verify_progress(files->config.process, &copy->token,
                            (uint16_t)(copy->quarters * (PERCENT / QUARTERS)), now_ns);
    }
}

/// Report that a copy has failed in its present step, and end it.
static void fail_copy(pus_files_t* const files, pus_file_copy_t* const copy, const status_t status,
                      const uint64_t now_ns)
{
    const pus_failure_t failure = pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    files->counters.failed++;
    pus_verify_progress_failed(files->config.process, &copy->token,
                               (uint16_t)((copy->quarters + 1U) * (PERCENT / QUARTERS)), &failure, now_ns);
    end_copy(files, copy, failure, files->config.process, now_ns);
}

static void step_copy(pus_files_t* const files, pus_file_copy_t* const copy, const uint64_t now_ns)
{
    status_t status = copy->is_begun ? STATUS_OK : begin_copy(files, copy);
    if ((status == STATUS_OK) && (copy->done < copy->size)) {
        status = copy_slice(files, copy);
        if (status == STATUS_OK) {
            report_progress(files, copy, now_ns);
        }
    }
    const bool is_whole = (status == STATUS_OK) && (copy->done == copy->size);
    if (is_whole) {
        status = finish_copy(files, copy);
    }
    if (status != STATUS_OK) {
        fail_copy(files, copy, status, now_ns);
        // If the commit fails, the record stays and the next life removes the temporary file, if there is
        // one.
        (void)st23_commit(files);
    } else if (is_whole) {
        files->counters.copied++;
        copy->is_begun = false; // The temporary file has become the target.
        end_copy(files, copy, pus_no_failure(), files->config.process, now_ns);
        (void)st23_commit(files); // If it fails, the record has no effect: there is no temporary file.
    } else {
        // Later steps continue the copy.
    }
}

static bool has_work(const pus_file_copy_t* const copy)
{
    return (copy->status == PUS_FILE_COPY_PENDING) || (copy->status == PUS_FILE_COPY_RUNNING) ||
           (copy->status == PUS_FILE_COPY_LEFT);
}

/// Returns the next copy in turn that has work; null if there is none.
static pus_file_copy_t* next_copy(pus_files_t* const files)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        const size_t index          = files->next_copy;
        pus_file_copy_t* const copy = &files->config.copies[index];
        files->next_copy            = (index + 1U) % files->config.copy_count;
        if (has_work(copy)) {
            return copy;
        }
    }
    return NULL;
}

void st23_step_copies(pus_files_t* const files, const uint64_t now_ns, const uint32_t cycle)
{
    bool has_more = true;
    for (uint16_t i = 0U; has_more && (i < files->config.slices); i++) {
        pus_file_copy_t* const copy = next_copy(files);
        has_more                    = (copy != NULL);
        if (has_more && (copy->status == PUS_FILE_COPY_LEFT)) {
            remove_leftover(files, copy);
        } else if (has_more) {
            step_copy(files, copy, now_ns);
        } else {
            // No copy has work.
        }
    }
    report_if_due(files, now_ns, cycle);
}

bool st23_has_copies(const pus_files_t* const files)
{
    for (size_t i = 0U; i < files->config.copy_count; i++) {
        if (has_work(&files->config.copies[i])) {
            return true;
        }
    }
    return false;
}
