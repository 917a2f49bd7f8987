// SPDX-License-Identifier: Apache-2.0
#include "pus/st06/st06_operations.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

enum { // Reports.
    OBJECT_DATA   = 4,
    RAW_DATA      = 6,
    OBJECT_CHECKS = 8,
    RAW_CHECKS    = 10,
    OBJECT_CHECK  = 18
};

enum { // Phases of the load of an area from a file.
    PHASE_CHECK,
    PHASE_LOAD
};

#define AREA_SIZE 8U       // Address and length of an area in a request [octets].
#define FILE_AREA_SIZE 14U // Address, offset in the file, length and checksum [octets].

// ---- Operations ----

typedef struct {      // An area of an operation.
    uint32_t address; // Address in the request.
    uint32_t length;  // [octets].
    uint32_t offset;  // Offset in the file.
    uint16_t checksum;
} area_t;

static area_t area_of(const pus_memory_operation_t* const operation, const uint8_t index)
{
    const uint8_t* const entry = &operation->data[operation->list + ((size_t)index * operation->entry)];
    area_t area                = {.address = octets_u32_at(entry)};
    if (operation->kind == (uint8_t)MEMORY_LOAD_FILE) {
        area.offset   = octets_u32_at(&entry[4]);
        area.length   = octets_u32_at(&entry[8]);
        area.checksum = octets_u16_at(&entry[12]);
    } else {
        area.length = octets_u32_at(&entry[4]);
    }
    return area;
}

static const pus_memory_t* memory_of(const pus_memory_service_t* const service,
                                     const pus_memory_operation_t* const operation)
{
    return &service->config.memories[operation->memory];
}

static void finish(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                   const uint64_t now_ns, const pus_failure_t* const reason)
{
    pus_failure_t failure = *reason;
    if ((operation->kind == (uint8_t)MEMORY_LOAD_FILE) || (operation->kind == (uint8_t)MEMORY_DUMP_FILE)) {
        const pus_file_port_t* const files = service->config.files;
        const status_t status              = files->close(files->context, operation->file);
        if ((status != STATUS_OK) && (failure.code == PUS_FAILURE_NONE)) {
            failure = pus_failure(PUS_FAILURE_IO, (uint32_t)status);
        }
    }
    if ((failure.code == PUS_FAILURE_NONE) && (operation->refused > 0U)) {
        failure = pus_failure(PUS_FAILURE_SOME_FAILED, operation->refused);
    }
    operation->kind = 0U;
    service->running--;
    pus_verify_ended(service->config.process, &operation->token, failure, now_ns);
}

/// Continue with the next area.
static void next_area(pus_memory_operation_t* const operation)
{
    operation->done     = 0U;
    operation->phase    = PHASE_CHECK;
    operation->checksum = CRC16_START;
    operation->index++;
}

/// Record that the present area failed, and continue with the next area.
static void fail_area(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                      const pus_failure_t* const failure)
{
    operation->is_left_out[operation->index] = true;
    if (operation->failure.code == PUS_FAILURE_NONE) {
        operation->failure             = *failure;
        operation->failure.instruction = (uint16_t)(operation->index + 1U);
    }
    service->counters.refused++;
    next_area(operation);
}

static void fail_io(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                    const status_t status)
{
    const pus_failure_t failure = pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    fail_area(service, operation, &failure);
}

/// Skip the refused areas. False: no area is left.
static bool seek(pus_memory_operation_t* const operation)
{
    while ((operation->index < operation->count) && operation->is_left_out[operation->index]) {
        operation->index++;
    }
    return operation->index < operation->count;
}

static uint32_t smaller(const uint32_t a, const uint32_t b)
{
    return (a < b) ? a : b;
}

/// Begin a report of an operation with the memory id and, for an object, its base id.
static octet_writer_t begin_report(const pus_memory_service_t* const service,
                                   const pus_memory_operation_t* const operation, const uint8_t subtype,
                                   const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(service->config.process, PUS_SERVICE_MEMORY, subtype, operation->token.source, now_ns);
    octet_write_u8(&writer, memory_of(service, operation)->id);
    if (operation->is_object) {
        octet_write_u32(&writer, operation->base_id);
    }
    return writer;
}

/// Write the number of entries at `position`.
static void put_count(octet_writer_t* const writer, const size_t position, const uint16_t count)
{
    octets_put_u16(&writer->octets[position], count);
}

/// Send one report of a dump, with the next slice of its areas. False: the process cannot take the report
/// now.
static bool dump(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                 const uint64_t now_ns)
{
    const pus_memory_t* const memory = memory_of(service, operation);
    octet_writer_t writer =
        begin_report(service, operation, operation->is_object ? OBJECT_DATA : RAW_DATA, now_ns);
    const size_t position = writer.position;
    const uint8_t index   = operation->index;
    const uint32_t done   = operation->done;
    uint32_t room         = PUS_MEMORY_SLICE;
    uint32_t ended        = 0U;
    uint16_t entries      = 0U;
    (void)octet_write_space(&writer, sizeof entries);
    while ((room > 0U) && seek(operation)) {
        const area_t area     = area_of(operation, operation->index);
        const uint32_t piece  = smaller(room, area.length - operation->done);
        const uint32_t offset = area.address + operation->done;
        const status_t status =
            memory->read(memory->context, operation->origin + offset, service->octets, piece);
        if (status != STATUS_OK) {
            fail_io(service, operation, status);
            continue;
        }
        octet_write_u32(&writer, offset);
        octet_write_u16(&writer, (uint16_t)piece);
        octet_write_octets(&writer, service->octets, piece);
        octet_write_u16(&writer, crc16_ccitt(service->octets, piece));
        entries++;
        room -= piece;
        operation->done += piece;
        if (operation->done == area.length) {
            ended++;
            next_area(operation);
        }
    }
    if (entries == 0U) { // None of the remaining areas could be read: there is nothing to report.
        pus_tm_cancel(service->config.process);
        return true;
    }
    put_count(&writer, position, entries);
    if (pus_tm_send(service->config.process, &writer) != STATUS_OK) {
        operation->index = index; // A later step builds the report again, with the content at that time.
        operation->done  = done;
        return false;
    }
    service->counters.dumped += ended;
    return true;
}

/// Include the next slice of the present area in its checksum. *room: octets left in the slice of this step.
static void check_slice(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                        uint32_t* const room)
{
    const pus_memory_t* const memory = memory_of(service, operation);
    const area_t area                = area_of(operation, operation->index);
    const uint32_t piece             = smaller(*room, area.length - operation->done);
    const status_t status = memory->read(memory->context, operation->origin + area.address + operation->done,
                                         service->octets, piece);
    if (status != STATUS_OK) {
        fail_io(service, operation, status);
        return;
    }
    *room -= piece;
    operation->done += piece;
    operation->checksum = crc16_ccitt_more(operation->checksum, service->octets, piece);
    if (operation->done == area.length) {
        operation->checksums[operation->index] = operation->checksum;
        service->counters.checked++;
        next_area(operation);
    }
}

/// Report a check. False: the process cannot take the report now.
static bool report_checks(const pus_memory_service_t* const service,
                          const pus_memory_operation_t* const operation, const uint64_t now_ns)
{
    const bool is_whole   = (operation->kind == (uint8_t)MEMORY_CHECK_OBJECT);
    const uint8_t areas   = operation->is_object ? OBJECT_CHECKS : RAW_CHECKS;
    octet_writer_t writer = begin_report(service, operation, is_whole ? OBJECT_CHECK : areas, now_ns);
    const size_t position = writer.position;
    uint16_t entries      = 0U;
    if (!is_whole) {
        octet_write_u16(&writer, 0U);
    }
    for (uint8_t i = 0U; i < operation->count; i++) {
        if (!operation->is_left_out[i]) {
            const area_t area = area_of(operation, i);
            if (!is_whole) {
                octet_write_u32(&writer, area.address);
            }
            octet_write_u32(&writer, area.length);
            octet_write_u16(&writer, operation->checksums[i]);
            entries++;
        }
    }
    if (entries == 0U) {
        pus_tm_cancel(service->config.process);
        return true;
    }
    if (!is_whole) {
        put_count(&writer, position, entries);
    }
    return pus_tm_send(service->config.process, &writer) == STATUS_OK;
}

/// Read the next slice of a file. The first pass computes the checksum of the area, and checks that the
/// memory has each of its addresses. The second pass loads the area.
static void load_slice(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                       uint32_t* const room)
{
    const pus_memory_t* const memory   = memory_of(service, operation);
    const pus_file_port_t* const files = service->config.files;
    const area_t area                  = area_of(operation, operation->index);
    const uint32_t piece               = smaller(*room, area.length - operation->done);
    const uint32_t address             = operation->origin + area.address + operation->done;
    pus_failure_t failure              = pus_no_failure();
    status_t status =
        files->read(files->context, operation->file, area.offset + operation->done, service->octets, piece);
    if ((status == STATUS_OK) && (operation->phase == (uint8_t)PHASE_LOAD) &&
        service->config.states[operation->memory].is_protected) {
        failure = pus_failure(PUS_FAILURE_PROTECTED, memory->id); // Protected after the load began.
    } else if ((status == STATUS_OK) && (operation->phase == (uint8_t)PHASE_LOAD)) {
        status = memory->write(memory->context, address, service->octets, piece);
        failure =
            (status == STATUS_OK) ? memory_verify(service, memory, address, service->octets, piece) : failure;
    } else if (status == STATUS_OK) {
        operation->checksum = crc16_ccitt_more(operation->checksum, service->octets, piece);
        status              = memory->read(memory->context, address, service->echo, piece);
    } else {
        // The file cannot be read.
    }
    operation->done += piece;
    *room -= piece;
    const bool is_end = (operation->done == area.length);
    if (status != STATUS_OK) {
        fail_io(service, operation, status);
    } else if (failure.code != PUS_FAILURE_NONE) {
        fail_area(service, operation, &failure);
    } else if (is_end && (operation->phase == (uint8_t)PHASE_LOAD)) {
        service->counters.loaded++;
        next_area(operation);
    } else if (is_end && (operation->checksum != area.checksum)) {
        failure = pus_failure(PUS_FAILURE_VERIFY, operation->checksum);
        fail_area(service, operation, &failure);
    } else if (is_end) {
        operation->phase = PHASE_LOAD;
        operation->done  = 0U;
    } else {
        // The next step continues with this area.
    }
}

/// Append the next slice of the memory to the file.
static void dump_slice(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                       uint32_t* const room)
{
    const pus_memory_t* const memory   = memory_of(service, operation);
    const pus_file_port_t* const files = service->config.files;
    const area_t area                  = area_of(operation, operation->index);
    const uint32_t piece               = smaller(*room, area.length - operation->done);
    status_t status = memory->read(memory->context, operation->origin + area.address + operation->done,
                                   service->octets, piece);
    if (status == STATUS_OK) {
        status = files->write(files->context, operation->file, operation->written, service->octets, piece);
    }
    if (status != STATUS_OK) {
        fail_io(service, operation, status);
        // End the operation: further octets would be at wrong offsets in the file.
        operation->index = operation->count;
        return;
    }
    *room -= piece;
    operation->done += piece;
    operation->written += piece;
    if (operation->done == area.length) {
        service->counters.dumped++;
        next_area(operation);
    }
}

/// Advance an operation by one slice. Returns true if the operation has ended.
static bool advance(pus_memory_service_t* const service, pus_memory_operation_t* const operation,
                    const uint64_t now_ns)
{
    void (*slice)(pus_memory_service_t*, pus_memory_operation_t*, uint32_t*) = check_slice;
    uint32_t room                                                            = PUS_MEMORY_SLICE;
    if (operation->kind == (uint8_t)MEMORY_DUMP) {
        return dump(service, operation, now_ns) && !seek(operation);
    }
    if (operation->kind == (uint8_t)MEMORY_LOAD_FILE) {
        slice = load_slice;
    } else if (operation->kind == (uint8_t)MEMORY_DUMP_FILE) {
        slice = dump_slice;
    } else {
        // The operation is a check.
    }
    while ((room > 0U) && seek(operation)) {
        slice(service, operation, &room);
    }
    const bool is_check = (slice == check_slice);
    return !seek(operation) && (!is_check || report_checks(service, operation, now_ns));
}

static void scrub(pus_memory_service_t* const service)
{
    for (uint8_t i = 0U; i < service->config.memory_count; i++) {
        const pus_memory_t* const memory = &service->config.memories[i];
        pus_memory_state_t* const state  = &service->config.states[i];
        if (state->is_scrubbed) {
            const uint32_t piece = smaller(PUS_MEMORY_SLICE, memory->size - state->scrubbed);
            memory->scrub(memory->context, memory->base + state->scrubbed, piece);
            state->scrubbed += piece;
            if (state->scrubbed == memory->size) {
                state->scrubbed = 0U;
                service->counters.passes++;
            }
        }
    }
}

void pus_memory_step(pus_memory_service_t* const memory, const uint64_t now_ns)
{
    FSW_ASSERT(memory != NULL);
    uint8_t left = memory->running;
    for (pus_memory_operation_t* operation = memory->config.operations; left > 0U; operation++) {
        if (operation->kind != 0U) {
            left--;
            if (advance(memory, operation, now_ns)) {
                finish(memory, operation, now_ns, &operation->failure);
            }
        }
    }
    if (memory->scrubbed > 0U) {
        scrub(memory);
    }
}

void memory_abort_dumps(pus_memory_service_t* const service, const uint64_t now_ns)
{
    const pus_failure_t failure = pus_failure(PUS_FAILURE_ABORTED, 0U);
    for (uint8_t i = 0U; i < service->config.operation_count; i++) {
        pus_memory_operation_t* const operation = &service->config.operations[i];
        if ((operation->kind == (uint8_t)MEMORY_DUMP) || (operation->kind == (uint8_t)MEMORY_DUMP_FILE)) {
            finish(service, operation, now_ns, &failure);
        }
    }
}

// ---- Requests ----

static pus_memory_operation_t* free_operation(const pus_memory_service_t* const service)
{
    for (uint8_t i = 0U; i < service->config.operation_count; i++) {
        if (service->config.operations[i].kind == 0U) {
            return &service->config.operations[i];
        }
    }
    return NULL;
}

static pus_file_name_t read_name(octet_reader_t* const reader)
{
    pus_file_name_t name = {.path_size = octet_read_u16(reader)};
    name.path            = octet_read_octets(reader, name.path_size);
    name.name_size       = octet_read_u16(reader);
    name.name            = octet_read_octets(reader, name.name_size);
    return name;
}

/// Failure for the status of opening a file; `position`: octet offset of the file name in the request.
static pus_failure_t failure_of(const status_t status, const size_t position)
{
    switch (status) {
    case STATUS_OK:
        return pus_no_failure();
    case STATUS_NOT_FOUND:
    case STATUS_INVALID:
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, (uint32_t)position);
    case STATUS_EXISTS:
        return pus_failure(PUS_FAILURE_EXISTS, (uint32_t)position);
    case STATUS_FORBIDDEN:
        return pus_failure(PUS_FAILURE_STATE, (uint32_t)position);
    default:
        return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    }
}

/// Refuse the areas that may not be accessed. False: all were refused.
static bool check_areas(pus_memory_service_t* const service, pus_request_t* const request,
                        pus_memory_operation_t* const operation, const memory_target_t* const target,
                        const uint32_t file_size)
{
    const bool is_load = (operation->kind == (uint8_t)MEMORY_LOAD_FILE);
    for (uint8_t i = 0U; i < operation->count; i++) {
        const area_t area     = area_of(operation, i);
        const size_t position = operation->list + ((size_t)i * operation->entry);
        pus_failure_t failure =
            memory_check_access(service, target, area.address, area.length, is_load, position);
        const bool is_in_file = (area.offset <= file_size) && (area.length <= (file_size - area.offset));
        if ((failure.code == PUS_FAILURE_NONE) && is_load && !is_in_file) {
            failure = pus_failure(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)position);
        }
        operation->is_left_out[i] = (failure.code != PUS_FAILURE_NONE);
        if (operation->is_left_out[i]) {
            operation->refused++;
            service->counters.refused++;
            pus_request_refuse(request, (uint16_t)(i + 1U), failure.code, failure.detail);
        }
    }
    return operation->refused < operation->count;
}

/// Returns the number of areas of a request. MEMORY_CHECK_OBJECT has only one, the whole object.
static size_t areas_of(const pus_request_t* const request, const memory_kind_t kind)
{
    return (kind == MEMORY_CHECK_OBJECT) ? 1U : request->reader.octets[request->reader.position];
}

/// Set up an operation for a request, whose reader is at the list of areas.
static void take(pus_memory_operation_t* const operation, const pus_request_t* const request,
                 const memory_kind_t kind, const memory_target_t* const target)
{
    operation->kind      = (uint8_t)kind;
    operation->is_object = target->is_object;
    operation->memory    = target->index;
    operation->phase     = PHASE_CHECK;
    operation->count     = (uint8_t)areas_of(request, kind);
    operation->index     = 0U;
    operation->refused   = 0U;
    operation->checksum  = CRC16_START;
    operation->base_id   = target->base_id;
    operation->origin    = target->origin;
    operation->done      = 0U;
    operation->written   = 0U;
    operation->list      = 0U;
    operation->entry     = (kind == MEMORY_LOAD_FILE) ? FILE_AREA_SIZE : AREA_SIZE;
    operation->token     = request->token;
    operation->failure   = pus_no_failure();
    if (kind == MEMORY_CHECK_OBJECT) {
        octets_put_u32(operation->data, 0U);
        octets_put_u32(&operation->data[4], target->size);
    } else {
        operation->list = (uint16_t)(request->reader.position + 1U);
        (void)memcpy(operation->data, request->reader.octets, request->reader.size);
    }
}

/// Open or create the file of an operation and check its areas. PUS_FAILURE_NONE, or the failure. If all
/// areas are refused, the operation ends.
static pus_failure_t begin_areas(pus_memory_service_t* const service, pus_request_t* const request,
                                 pus_memory_operation_t* const operation, const memory_target_t* const target,
                                 const pus_file_name_t* const name, const size_t position)
{
    const pus_file_port_t* const files = service->config.files;
    const bool is_load                 = (operation->kind == (uint8_t)MEMORY_LOAD_FILE);
    uint32_t size                      = 0U;
    status_t status                    = STATUS_OK;
    if (is_load) {
        status = files->open(files->context, name, &operation->file, &size);
    }
    if ((status == STATUS_OK) && !check_areas(service, request, operation, target, size)) {
        operation->kind = 0U;
        if (is_load) {
            // The file was opened to be loaded; nothing was read from it.
            (void)files->close(files->context, operation->file);
        }
        return pus_no_failure();
    }
    if (operation->kind == (uint8_t)MEMORY_DUMP_FILE) {
        status = files->create(files->context, name, &operation->file);
    }
    return failure_of(status, position);
}

pus_reply_t memory_start(pus_memory_service_t* const service, pus_request_t* const request,
                         const memory_kind_t kind, const bool is_object)
{
    pus_memory_operation_t* const operation = free_operation(service);
    const bool has_file                     = (kind == MEMORY_LOAD_FILE) || (kind == MEMORY_DUMP_FILE);
    pus_file_name_t name                    = {0};
    memory_target_t target;
    pus_failure_t failure = memory_target(service, &request->reader, is_object, &target);
    const size_t position = request->reader.position;
    if (failure.code != PUS_FAILURE_NONE) {
        return pus_refused(failure.code, failure.detail);
    }
    if (operation == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, service->config.operation_count);
    }
    // A request that was transferred in parts (ST[13]) can be longer than a packet.
    if (request->reader.size > sizeof operation->data) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, sizeof operation->data);
    }
    if (has_file && (service->config.files == NULL)) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, (uint32_t)position);
    }
    if (has_file) {
        name = read_name(&request->reader);
    }
    if (areas_of(request, kind) > PUS_MEMORY_AREAS_MAX) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, PUS_MEMORY_AREAS_MAX);
    }
    take(operation, request, kind, &target);
    failure = begin_areas(service, request, operation, &target, &name, position);
    if (failure.code != PUS_FAILURE_NONE) {
        operation->kind = 0U;
        return pus_refused(failure.code, failure.detail);
    }
    if (operation->kind == 0U) {
        return pus_done(); // Each refused area has a report of its own.
    }
    service->running++;
    return pus_later();
}
