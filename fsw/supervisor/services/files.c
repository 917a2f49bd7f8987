// SPDX-License-Identifier: Apache-2.0
// Connects ST[23] to the supervisor, and provides files to other services by path and name.
#include "fsw/supervisor/services/files.h"

#include "base/assertion.h"
#include "fsw/supervisor/supervisor_internal.h"

#define CYCLE_NS 10000000ULL ///< Cycle of the service, independent of the supervisor's wake times.

static const pus_file_store_t* store_of(const supervisor_t* const supervisor)
{
    return &supervisor->config.files;
}

// ---- Whole files, for other services ----

/// Build the path of a file from the names in a request. False if they are malformed.
static bool path_of(const pus_file_name_t* const name, pus_file_path_t* const out_path)
{
    uint8_t octets[2U * (sizeof(uint16_t) + PUS_FILE_PATH_SIZE)];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, name->path_size);
    octet_write_octets(&writer, name->path, name->path_size);
    octet_write_u16(&writer, name->name_size);
    octet_write_octets(&writer, name->name, name->name_size);
    octet_reader_t reader = octet_reader(octets, writer.position);
    return !writer.failed && pus_file_path_read(&reader, out_path) &&
           pus_file_path_read_name(&reader, out_path);
}

/// Returns the index of a free entry; SPACECRAFT_FILES_OPEN if there is none.
static uint32_t free_index(const spacecraft_files_t* const files)
{
    uint32_t index = 0U;
    while ((index < SPACECRAFT_FILES_OPEN) && files->open[index].is_used) {
        index++;
    }
    return index;
}

static status_t open_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file,
                          uint32_t* const out_size)
{
    supervisor_t* const supervisor  = context;
    spacecraft_files_t* const files = &supervisor->spacecraft.files;
    const uint32_t index            = free_index(files);
    pus_file_path_t path;
    pus_file_about_t about = {0};
    if (!path_of(name, &path)) {
        return STATUS_INVALID;
    }
    if (index == SPACECRAFT_FILES_OPEN) {
        return STATUS_EXHAUSTED;
    }
    const status_t status = store_of(supervisor)->describe(store_of(supervisor)->context, path.text, &about);
    if ((status != STATUS_OK) || about.is_directory || (about.size > UINT32_MAX)) {
        return ((status == STATUS_OK) || (status == STATUS_NOT_FOUND)) ? STATUS_NOT_FOUND : STATUS_IO;
    }
    files->open[index].is_used = true;
    files->open[index].path    = path;
    *out_file                  = index;
    *out_size                  = (uint32_t)about.size;
    return STATUS_OK;
}

static status_t create_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file)
{
    supervisor_t* const supervisor  = context;
    spacecraft_files_t* const files = &supervisor->spacecraft.files;
    const uint32_t index            = free_index(files);
    pus_file_path_t path;
    if (!path_of(name, &path)) {
        return STATUS_INVALID;
    }
    if (index == SPACECRAFT_FILES_OPEN) {
        return STATUS_EXHAUSTED;
    }
    const status_t status = store_of(supervisor)->create_file(store_of(supervisor)->context, path.text, 0U);
    if (status != STATUS_OK) {
        return ((status == STATUS_EXISTS) || (status == STATUS_NOT_FOUND)) ? status : STATUS_IO;
    }
    files->open[index].is_used = true;
    files->open[index].path    = path;
    *out_file                  = index;
    return STATUS_OK;
}

static const char* text_of(const supervisor_t* const supervisor, const uint32_t file)
{
    FSW_ASSERT((file < SPACECRAFT_FILES_OPEN) && supervisor->spacecraft.files.open[file].is_used);
    return supervisor->spacecraft.files.open[file].path.text;
}

static status_t read_file(void* const context, const uint32_t file, const uint32_t offset,
                          uint8_t* const octets, const size_t size)
{
    const supervisor_t* const supervisor = context;
    size_t count                         = 0U;
    const status_t status =
        store_of(supervisor)
            ->read(store_of(supervisor)->context, text_of(supervisor, file), offset, octets, size, &count);
    if (status != STATUS_OK) {
        return STATUS_IO;
    }
    return (count == size) ? STATUS_OK : STATUS_TRUNCATED;
}

static status_t write_file(void* const context, const uint32_t file, const uint32_t offset,
                           const uint8_t* const octets, const size_t size)
{
    const supervisor_t* const supervisor = context;
    const status_t status =
        store_of(supervisor)
            ->write(store_of(supervisor)->context, text_of(supervisor, file), offset, octets, size);
    return ((status == STATUS_OK) || (status == STATUS_FULL)) ? status : STATUS_IO;
}

static status_t close_file(void* const context, const uint32_t file)
{
    supervisor_t* const supervisor = context;
    const status_t status =
        store_of(supervisor)->sync(store_of(supervisor)->context, text_of(supervisor, file));
    supervisor->spacecraft.files.open[file].is_used = false;
    return (status == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

const pus_file_port_t* spacecraft_file_port(supervisor_t* const supervisor)
{
    spacecraft_files_t* const files = &supervisor->spacecraft.files;
    files->port = (pus_file_port_t){supervisor, open_file, create_file, read_file, write_file, close_file};
    return (store_of(supervisor)->read != NULL) ? &files->port : NULL;
}

// ---- ST[23] ----

static pus_service_t open_files(supervisor_t* const supervisor)
{
    spacecraft_files_t* const files = &supervisor->spacecraft.files;
    const pus_files_config_t config = {
        .store        = supervisor->config.files,
        .process      = subsystem_process(&supervisor->subsystem),
        .locks        = files->locks,
        .lock_count   = spacecraft_capacity(supervisor, PUS_SERVICE_FILES, SPACECRAFT_FILE_LOCKS),
        .copies       = files->copies,
        .copy_count   = SPACECRAFT_FILE_COPIES,
        .searches     = files->searches,
        .search_count = SPACECRAFT_FILE_SEARCHES,
        .size_max     = SPACECRAFT_FILE_SIZE_MAX,
        .slices       = SPACECRAFT_FILE_SLICES,
        .persistence  = spacecraft_persistence(supervisor)};
    pus_files_init(&files->service, &config);
    pus_service_t service = pus_files_service(&files->service);
    service.step          = NULL; // The binding calls the step.
    return service;
}

static status_t restore_files(supervisor_t* const supervisor, const uint32_t key, const uint8_t* const octets,
                              const size_t size)
{
    return pus_files_restore(&supervisor->spacecraft.files.service, key, octets, size);
}

static uint64_t step_files(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_files_t* const service = &supervisor->spacecraft.files.service;
    pus_files_step(service, now_ns, (uint32_t)(now_ns / CYCLE_NS));
    return pus_files_is_busy(service) ? (now_ns + SPACECRAFT_RETRY_NS) : SPACECRAFT_NEVER;
}

const spacecraft_binding_t spacecraft_files = {
    .type = PUS_SERVICE_FILES, .open = open_files, .restore = restore_files, .step = step_files};
