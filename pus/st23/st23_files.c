// SPDX-License-Identifier: Apache-2.0
#include "pus/st23/st23_files.h"

#include "base/assertion.h"
#include "generated/pus/st23_request_formats.h"
#include "pus/st23/st23_internal.h"

#include <string.h>

enum {
    ATTRIBUTES = 4
};

#define COPIES_MAX 255U
#define INTERVAL_SIZE 4U // Size of the record of the reporting interval [octets].

void pus_files_init(pus_files_t* const files, const pus_files_config_t* const config)
{
    FSW_ASSERT((files != NULL) && (config != NULL) && (config->process != NULL) && (config->slices >= 1U));
    FSW_ASSERT((config->copies != NULL) && (config->copy_count >= 1U) && (config->copy_count <= COPIES_MAX));
    FSW_ASSERT((config->locks != NULL) && (config->lock_count >= 1U) && (config->lock_count <= UINT16_MAX));
    FSW_ASSERT((config->searches != NULL) && (config->search_count >= 1U));
    (void)memset(files, 0, sizeof *files);
    files->config = *config;
    (void)memset(config->locks, 0, config->lock_count * sizeof config->locks[0]);
    (void)memset(config->searches, 0, config->search_count * sizeof config->searches[0]);
    for (size_t i = 0U; i < config->copy_count; i++) {
        config->copies[i] = (pus_file_copy_t){.status = PUS_FILE_COPY_FREE};
    }
}

pus_reply_t st23_refuse(pus_files_t* const files, const uint16_t code, const uint32_t detail)
{
    files->counters.refused++;
    return pus_refused(code, detail);
}

pus_reply_t st23_reply_of(pus_files_t* const files, const status_t status, const uint32_t offset)
{
    switch (status) {
    case STATUS_OK:
        return pus_done();
    case STATUS_NOT_FOUND:
        return st23_refuse(files, PUS_FAILURE_UNKNOWN_ID, offset);
    case STATUS_EXISTS:
        return st23_refuse(files, PUS_FAILURE_EXISTS, offset);
    case STATUS_FORBIDDEN:
        return st23_refuse(files, PUS_FAILURE_STATE, offset);
    case STATUS_INVALID:
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, offset);
    default:
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
}

status_t st23_keep(const pus_files_t* const files, const uint32_t key, const uint8_t* const octets,
                   const size_t size)
{
    const pus_persistence_t* const port = files->config.persistence;
    return (port != NULL) ? port->put(port->context, PUS_SERVICE_FILES, key, octets, size) : STATUS_OK;
}

status_t st23_forget(const pus_files_t* const files, const uint32_t key)
{
    const pus_persistence_t* const port = files->config.persistence;
    return (port != NULL) ? port->erase(port->context, PUS_SERVICE_FILES, key) : STATUS_OK;
}

status_t st23_commit(const pus_files_t* const files)
{
    const pus_persistence_t* const port = files->config.persistence;
    return (port != NULL) ? port->commit(port->context) : STATUS_OK;
}

bool st23_read_path(pus_request_t* const request, st23_request_path_t* const out_path)
{
    octet_reader_t* const reader = &request->reader;
    out_path->directory_offset   = (uint32_t)reader->position;
    out_path->bad_offset         = out_path->directory_offset;
    if (!pus_file_path_read(reader, &out_path->path)) {
        return false;
    }
    out_path->name_offset = (uint32_t)reader->position;
    out_path->bad_offset  = out_path->name_offset;
    return pus_file_path_read_name(reader, &out_path->path);
}

status_t st23_look(const pus_files_t* const files, const pus_file_path_t* const path, const bool is_directory,
                   pus_file_about_t* const out_about)
{
    const pus_file_store_t* const store = &files->config.store;
    *out_about                          = (pus_file_about_t){0};
    const status_t status               = store->describe(store->context, path->text, out_about);
    const bool is_other_kind            = (status == STATUS_OK) && (out_about->is_directory != is_directory);
    return is_other_kind ? STATUS_NOT_FOUND : status;
}

// ---- Locks ----

bool st23_is_locked(const pus_files_t* const files, const pus_file_path_t* const path)
{
    for (size_t i = 0U; i < files->config.lock_count; i++) {
        const pus_file_lock_t* const lock = &files->config.locks[i];
        if (lock->is_used && pus_file_path_is_within(&lock->path, path)) {
            return true;
        }
    }
    return false;
}

/// Returns the lock of a path or, if `path` is null, a free lock; null if there is none.
static pus_file_lock_t* find_lock(const pus_files_t* const files, const pus_file_path_t* const path)
{
    for (size_t i = 0U; i < files->config.lock_count; i++) {
        pus_file_lock_t* const lock = &files->config.locks[i];
        const bool is_it =
            (path == NULL) ? !lock->is_used : (lock->is_used && pus_file_path_is_same(&lock->path, path));
        if (is_it) {
            return lock;
        }
    }
    return NULL;
}

static uint32_t key_of(const pus_files_t* const files, const pus_file_lock_t* const lock)
{
    return ST23_KEY_LOCK + (uint32_t)(lock - files->config.locks);
}

/// Take a free lock for a path, and store its record. Statuses of `put`.
static status_t take_lock(const pus_files_t* const files, pus_file_lock_t* const lock,
                          const pus_file_path_t* const path)
{
    const status_t status =
        st23_keep(files, key_of(files, lock), (const uint8_t*)path->text, strlen(path->text));
    lock->is_used     = (status == STATUS_OK);
    lock->is_restored = false;
    lock->path        = *path;
    return status;
}

/// Release a lock. STATUS_OK; STATUS_IO: it is still taken.
static status_t release_lock(const pus_files_t* const files, pus_file_lock_t* const lock)
{
    lock->is_used = st23_forget(files, key_of(files, lock)) != STATUS_OK;
    return lock->is_used ? STATUS_IO : STATUS_OK;
}

/// Called in the first step: delete each restored lock whose file does not exist, because a power cut
/// prevented the creation of the file.
static void drop_unused_locks(const pus_files_t* const files)
{
    for (size_t i = 0U; i < files->config.lock_count; i++) {
        pus_file_lock_t* const lock = &files->config.locks[i];
        pus_file_about_t about;
        const bool is_unsure = lock->is_used && lock->is_restored;
        lock->is_restored    = false;
        if (is_unsure && (st23_look(files, &lock->path, false, &about) == STATUS_NOT_FOUND)) {
            (void)release_lock(files, lock);
            (void)st23_commit(files); // If the commit fails, the next life deletes the lock.
        }
    }
}

static pus_reply_t refuse_locks_full(pus_files_t* const files)
{
    return st23_refuse(files, PUS_FAILURE_TABLE_FULL, (uint32_t)files->config.lock_count);
}

static pus_reply_t lock_file(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    pus_file_about_t about;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    status_t status             = st23_look(files, &target.path, false, &about);
    pus_file_lock_t* const lock = find_lock(files, NULL);
    if ((status == STATUS_OK) && st23_is_locked(files, &target.path)) {
        status = STATUS_FORBIDDEN;
    } else if ((status == STATUS_OK) && (lock == NULL)) {
        return refuse_locks_full(files);
    } else if (status == STATUS_OK) {
        status = take_lock(files, lock, &target.path);
    } else {
        // Keep the status of the store.
    }
    return st23_reply_of(files, status, target.name_offset);
}

static pus_reply_t unlock_file(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    pus_file_about_t about;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    pus_file_lock_t* const lock = find_lock(files, &target.path);
    status_t status             = STATUS_OK;
    if (lock == NULL) {
        status = st23_look(files, &target.path, false, &about);
        status = (status == STATUS_OK) ? STATUS_FORBIDDEN : status;
    } else {
        status = release_lock(files, lock);
    }
    return st23_reply_of(files, status, target.name_offset);
}

// ---- Files ----

/// Create a locked file. The lock is stored first: after a power cut there are both, neither, or a lock
/// without a file, but never a file without its lock. STATUS_OK, or the status of the store or of the
/// records.
static status_t make_locked_file(const pus_files_t* const files, const pus_file_path_t* const path,
                                 const uint32_t room, pus_file_lock_t* const lock)
{
    const pus_file_store_t* const store = &files->config.store;
    pus_file_about_t about;
    if (store->describe(store->context, path->text, &about) == STATUS_OK) {
        return STATUS_EXISTS; // An existing file must not be locked, not even for a short time.
    }
    status_t status = take_lock(files, lock, path);
    if (status == STATUS_OK) {
        status = st23_commit(files);
        status = (status == STATUS_OK) ? store->create_file(store->context, path->text, room) : status;
        if (status != STATUS_OK) {
            (void)release_lock(files, lock);
        }
    }
    return status;
}

static pus_reply_t create_file(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const uint32_t room_offset = (uint32_t)request->reader.position;
    const uint32_t room        = octet_read_u32(&request->reader);
    const uint32_t flag_offset = (uint32_t)request->reader.position;
    const uint8_t flag         = octet_read_u8(&request->reader);
    if (room > files->config.size_max) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, room_offset);
    }
    if (flag > 1U) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, flag_offset);
    }
    if (st23_is_claimed(files, &target.path)) {
        return st23_refuse(files, PUS_FAILURE_EXISTS, target.name_offset);
    }
    pus_file_lock_t* const lock = (flag == 1U) ? find_lock(files, NULL) : NULL;
    if ((flag == 1U) && (lock == NULL)) {
        return refuse_locks_full(files);
    }
    const pus_file_store_t* const store = &files->config.store;
    const status_t status               = (lock != NULL) ? make_locked_file(files, &target.path, room, lock)
                                                         : store->create_file(store->context, target.path.text, room);
    return st23_reply_of(files, status, target.name_offset);
}

static pus_reply_t delete_file(void* const self, pus_request_t* const request)
{
    pus_files_t* const files            = self;
    const pus_file_store_t* const store = &files->config.store;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const bool is_kept    = st23_is_locked(files, &target.path) || st23_is_in_use(files, &target.path);
    const status_t status = is_kept ? STATUS_FORBIDDEN : store->remove_file(store->context, target.path.text);
    return st23_reply_of(files, status, target.name_offset);
}

static pus_reply_t report_attributes(void* const self, pus_request_t* const request)
{
    pus_files_t* const files = self;
    pus_file_about_t about;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const status_t status = st23_look(files, &target.path, false, &about);
    if (status == STATUS_OK) {
        pus_file_path_t parent = target.path;
        pus_request_perform(request);
        octet_writer_t writer = pus_answer_begin(request, ATTRIBUTES);
        pus_file_path_leave(&parent);
        pus_file_path_write(&writer, &parent);
        pus_file_name_write(&writer, pus_file_path_name(&target.path));
        octet_write_u32(&writer, (about.size < UINT32_MAX) ? (uint32_t)about.size : UINT32_MAX);
        octet_write_u8(&writer, st23_is_locked(files, &target.path) ? 1U : 0U);
        (void)pus_tm_post(request->process, &writer); // The process counts lost reports.
    }
    return st23_reply_of(files, status, target.name_offset);
}

// ---- Directories ----

static pus_reply_t create_directory(void* const self, pus_request_t* const request)
{
    pus_files_t* const files            = self;
    const pus_file_store_t* const store = &files->config.store;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const status_t status = st23_is_claimed(files, &target.path)
                                ? STATUS_EXISTS
                                : store->create_directory(store->context, target.path.text);
    return st23_reply_of(files, status, target.name_offset);
}

static pus_reply_t delete_directory(void* const self, pus_request_t* const request)
{
    pus_files_t* const files            = self;
    const pus_file_store_t* const store = &files->config.store;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const status_t status = st23_is_in_use(files, &target.path)
                                ? STATUS_FORBIDDEN
                                : store->remove_directory(store->context, target.path.text);
    return st23_reply_of(files, status, target.name_offset);
}

static pus_reply_t rename_directory(void* const self, pus_request_t* const request)
{
    pus_files_t* const files            = self;
    const pus_file_store_t* const store = &files->config.store;
    pus_file_about_t about;
    st23_request_path_t target;
    if (!st23_read_path(request, &target)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, target.bad_offset);
    }
    const uint32_t new_offset = (uint32_t)request->reader.position;
    pus_file_path_t new_path  = target.path;
    pus_file_path_leave(&new_path);
    if (!pus_file_path_read_name(&request->reader, &new_path)) {
        return st23_refuse(files, PUS_FAILURE_OUT_OF_RANGE, new_offset);
    }
    status_t status = st23_look(files, &target.path, true, &about);
    if ((status == STATUS_OK) &&
        (st23_is_locked(files, &target.path) || st23_is_in_use(files, &target.path))) {
        status = STATUS_FORBIDDEN;
    }
    if (status != STATUS_OK) {
        return st23_reply_of(files, status, target.name_offset);
    }
    status = st23_is_claimed(files, &new_path)
                 ? STATUS_EXISTS
                 : store->rename(store->context, target.path.text, new_path.text);
    return st23_reply_of(files, status, new_offset);
}

// ---- The service ----

/// Restore a path from a record. False: malformed.
static bool restore_path(const uint8_t* const octets, const size_t size, pus_file_path_t* const out_path)
{
    if ((size < 1U) || (size >= PUS_FILE_PATH_SIZE)) {
        return false;
    }
    (void)memcpy(out_path->text, octets, size);
    out_path->text[size] = '\0';
    return strlen(out_path->text) == size;
}

status_t pus_files_restore(pus_files_t* const files, const uint32_t key, const uint8_t* const octets,
                           const size_t size)
{
    FSW_ASSERT((files != NULL) && ((octets != NULL) || (size == 0U)));
    pus_file_path_t path;
    if (key == ST23_KEY_REPORTING) {
        if (size != INTERVAL_SIZE) {
            return STATUS_INVALID;
        }
        files->interval        = octets_u32_at(octets);
        files->is_interval_new = true;
        return STATUS_OK;
    }
    const bool is_lock = key < files->config.lock_count;
    const bool is_copy = (key >= ST23_KEY_COPY) && ((key - ST23_KEY_COPY) < files->config.copy_count);
    if (!is_lock && !is_copy) {
        return STATUS_NOT_FOUND;
    }
    if (!restore_path(octets, size, &path)) {
        return STATUS_INVALID;
    }
    if (is_lock) {
        files->config.locks[key] = (pus_file_lock_t){.is_used = true, .is_restored = true, .path = path};
        files->is_restored       = true;
    } else {
        pus_file_copy_t* const copy = &files->config.copies[key - ST23_KEY_COPY];
        *copy                       = (pus_file_copy_t){.status = PUS_FILE_COPY_LEFT, .part = path};
    }
    return STATUS_OK;
}

void pus_files_step(pus_files_t* const files, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(files != NULL);
    if (files->is_restored) {
        files->is_restored = false;
        drop_unused_locks(files);
    }
    st23_step_copies(files, now_ns, cycle);
    st23_step_searches(files, now_ns);
}

bool pus_files_is_busy(const pus_files_t* const files)
{
    FSW_ASSERT(files != NULL);
    return st23_has_copies(files) || st23_has_searches(files);
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_files_step(self, now_ns, cycle);
}

pus_service_t pus_files_service(pus_files_t* const files)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(23, 1, create_file),
        PUS_REQUEST(23, 2, delete_file),
        PUS_REQUEST(23, 3, report_attributes),
        PUS_REQUEST(23, 5, lock_file),
        PUS_REQUEST(23, 6, unlock_file),
        PUS_REQUEST(23, 7, st23_find),
        PUS_REQUEST(23, 9, create_directory),
        PUS_REQUEST(23, 10, delete_directory),
        PUS_REQUEST(23, 11, rename_directory),
        PUS_REQUEST(23, 12, st23_summarise),
        PUS_REQUEST(23, 14, st23_copy),
        PUS_REQUEST(23, 15, st23_move),
        PUS_REQUEST(23, 16, st23_change_copies),
        PUS_REQUEST(23, 17, st23_change_copies),
        PUS_REQUEST(23, 18, st23_change_copies),
        PUS_REQUEST(23, 19, st23_change_copies_of_path),
        PUS_REQUEST(23, 20, st23_change_copies_of_path),
        PUS_REQUEST(23, 21, st23_change_copies_of_path),
        PUS_REQUEST(23, 22, st23_enable_status_report),
        PUS_REQUEST(23, 24, st23_disable_status_report),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_FILES, subtypes, sizeof subtypes / sizeof subtypes[0], files);
    service.step = step;
    return service;
}
