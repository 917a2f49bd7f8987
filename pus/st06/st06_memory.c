// SPDX-License-Identifier: Apache-2.0
#include "pus/st06/st06_memory.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "generated/pus/st06_request_formats.h"
#include "pus/st06/st06_operations.h"

#include <string.h>

#define FLAG_PROTECTED 0x01U // Flags in a record.
#define FLAG_SCRUBBED 0x02U
#define RECORD_SIZE 1U

void pus_memory_init(pus_memory_service_t* const memory, const pus_memory_config_t* const config)
{
    FSW_ASSERT((memory != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->memories != NULL) && (config->states != NULL) && (config->operations != NULL));
    (void)memset(memory, 0, sizeof *memory);
    memory->config = *config;
    for (uint8_t i = 0U; i < config->memory_count; i++) {
        const pus_memory_t* const one = &config->memories[i];
        FSW_ASSERT((one->read != NULL) && (one->size >= 1U) && (one->access >= 1U) && (one->access <= 8U) &&
                   ((one->base % one->access) == 0U) && ((one->size % one->access) == 0U) &&
                   ((one->size - 1U) <= (UINT32_MAX - one->base)));
        config->states[i] = (pus_memory_state_t){0};
    }
    for (uint8_t i = 0U; i < config->operation_count; i++) {
        config->operations[i].kind = 0U;
    }
}

// ---- Loads with data ----

/// Write an area, and read it back to verify it.
static pus_failure_t store(pus_memory_service_t* const service, const pus_memory_t* const memory,
                           const uint32_t address, const uint8_t* const octets, const size_t size)
{
    const status_t status = memory->write(memory->context, address, octets, size);
    if (status != STATUS_OK) {
        return memory_fail(service, PUS_FAILURE_IO, (uint32_t)status);
    }
    const pus_failure_t failure = memory_verify(service, memory, address, octets, size);
    service->counters.loaded += (failure.code == PUS_FAILURE_NONE) ? 1U : 0U;
    return failure;
}

static pus_reply_t load(void* const self, pus_request_t* const request, const bool is_object)
{
    pus_memory_service_t* const service = self;
    octet_reader_t* const reader        = &request->reader;
    pus_failure_t first                 = pus_no_failure();
    memory_target_t target;
    pus_failure_t failure = memory_target(service, reader, is_object, &target);
    if (failure.code != PUS_FAILURE_NONE) {
        return pus_refused(failure.code, failure.detail);
    }
    const uint8_t count = octet_read_u8(reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const size_t position       = reader->position;
        const uint32_t address      = octet_read_u32(reader);
        const uint16_t size         = octet_read_u16(reader);
        const uint8_t* const octets = octet_read_octets(reader, size);
        const uint16_t checksum     = octet_read_u16(reader);
        const uint16_t computed     = crc16_ccitt(octets, size);
        failure                     = memory_check_access(service, &target, address, size, true, position);
        if ((failure.code == PUS_FAILURE_NONE) && (computed != checksum)) {
            failure = memory_fail(service, PUS_FAILURE_DATA_CHECKSUM, computed);
        }
        if (failure.code != PUS_FAILURE_NONE) {
            pus_request_refuse(request, i, failure.code, failure.detail);
            continue;
        }
        pus_request_perform(request);
        failure             = store(service, target.memory, target.origin + address, octets, size);
        failure.instruction = i;
        if (first.code == PUS_FAILURE_NONE) {
            first = failure;
        }
    }
    return (first.code == PUS_FAILURE_NONE) ? pus_done() : (pus_reply_t){PUS_FAILED, first};
}

static pus_reply_t load_object(void* const self, pus_request_t* const request)
{
    return load(self, request, true);
}

static pus_reply_t load_raw(void* const self, pus_request_t* const request)
{
    return load(self, request, false);
}

/// Load only the bits that a mask selects, in one write.
static pus_reply_t load_atomic(void* const self, pus_request_t* const request)
{
    pus_memory_service_t* const service = self;
    octet_reader_t* const reader        = &request->reader;
    uint8_t octets[PUS_MEMORY_ATOMIC];
    memory_target_t target;
    pus_failure_t failure = memory_target(service, reader, false, &target);
    if (failure.code != PUS_FAILURE_NONE) {
        return pus_refused(failure.code, failure.detail);
    }
    const size_t position     = reader->position;
    const uint32_t address    = octet_read_u32(reader);
    const uint8_t* const mask = octet_read_octets(reader, PUS_MEMORY_ATOMIC);
    const uint8_t* const data = octet_read_octets(reader, PUS_MEMORY_ATOMIC);
    failure = memory_check_access(service, &target, address, PUS_MEMORY_ATOMIC, true, position);
    if ((failure.code == PUS_FAILURE_NONE) && ((address % PUS_MEMORY_ATOMIC) != 0U)) {
        failure = memory_fail(service, PUS_FAILURE_ADDRESS, address);
    }
    if (failure.code != PUS_FAILURE_NONE) {
        return pus_refused(failure.code, failure.detail);
    }
    const status_t status = target.memory->read(target.memory->context, address, octets, sizeof octets);
    if (status != STATUS_OK) {
        failure = memory_fail(service, PUS_FAILURE_IO, (uint32_t)status);
        return pus_failed(failure.code, failure.detail);
    }
    for (size_t i = 0U; i < PUS_MEMORY_ATOMIC; i++) {
        octets[i] = (uint8_t)((octets[i] & (uint8_t)~mask[i]) | (data[i] & mask[i]));
    }
    failure = store(service, target.memory, address, octets, sizeof octets);
    return (failure.code == PUS_FAILURE_NONE) ? pus_done() : pus_failed(failure.code, failure.detail);
}

// ---- Dumps, checks and loads by reference ----

static pus_reply_t dump_object(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_DUMP, true);
}

static pus_reply_t dump_raw(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_DUMP, false);
}

static pus_reply_t check_object_areas(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_CHECK, true);
}

static pus_reply_t check_raw(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_CHECK, false);
}

static pus_reply_t load_raw_file(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_LOAD_FILE, false);
}

static pus_reply_t load_object_file(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_LOAD_FILE, true);
}

static pus_reply_t dump_raw_file(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_DUMP_FILE, false);
}

static pus_reply_t dump_object_file(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_DUMP_FILE, true);
}

static pus_reply_t check_object(void* const self, pus_request_t* const request)
{
    return memory_start(self, request, MEMORY_CHECK_OBJECT, true);
}

static pus_reply_t abort_dumps(void* const self, pus_request_t* const request)
{
    memory_abort_dumps(self, request->now_ns);
    return pus_done();
}

// ---- Write protection and scrubbing ----

static void apply(pus_memory_service_t* const service, const uint8_t index, const unsigned flags)
{
    pus_memory_state_t* const state = &service->config.states[index];
    const bool is_scrubbed          = (flags & FLAG_SCRUBBED) != 0U;
    state->is_protected             = (flags & FLAG_PROTECTED) != 0U;
    if (is_scrubbed != state->is_scrubbed) {
        state->is_scrubbed = is_scrubbed;
        state->scrubbed    = 0U;
        service->scrubbed  = (uint8_t)(is_scrubbed ? (service->scrubbed + 1U) : (service->scrubbed - 1U));
    }
}

static pus_reply_t set_flag(pus_memory_service_t* const service, pus_request_t* const request,
                            const unsigned flag, const bool is_set)
{
    const pus_persistence_t* const persistence = service->config.persistence;
    memory_target_t target;
    const pus_failure_t failure = memory_target(service, &request->reader, false, &target);
    if (failure.code != PUS_FAILURE_NONE) {
        return pus_refused(failure.code, failure.detail);
    }
    const uint8_t id = target.memory->id;
    if ((flag == FLAG_SCRUBBED) && (target.memory->scrub == NULL)) {
        return pus_refused(PUS_FAILURE_STATE, id);
    }
    const pus_memory_state_t* const state = &service->config.states[target.index];
    unsigned flags = (state->is_protected ? FLAG_PROTECTED : 0U) | (state->is_scrubbed ? FLAG_SCRUBBED : 0U);
    flags          = is_set ? (flags | flag) : (flags & ~flag);
    const uint8_t record  = (uint8_t)flags;
    const status_t status = (persistence == NULL) ? STATUS_OK
                                                  : persistence->put(persistence->context, PUS_SERVICE_MEMORY,
                                                                     id, &record, RECORD_SIZE);
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    apply(service, target.index, flags);
    return pus_done();
}

static pus_reply_t enable_scrubbing(void* const self, pus_request_t* const request)
{
    return set_flag(self, request, FLAG_SCRUBBED, true);
}

static pus_reply_t disable_scrubbing(void* const self, pus_request_t* const request)
{
    return set_flag(self, request, FLAG_SCRUBBED, false);
}

static pus_reply_t protect(void* const self, pus_request_t* const request)
{
    return set_flag(self, request, FLAG_PROTECTED, true);
}

static pus_reply_t unprotect(void* const self, pus_request_t* const request)
{
    return set_flag(self, request, FLAG_PROTECTED, false);
}

status_t pus_memory_restore(void* const self, const uint32_t key, const uint8_t* const octets,
                            const size_t size)
{
    pus_memory_service_t* const service = self;
    FSW_ASSERT((service != NULL) && (octets != NULL));
    uint8_t index = 0U;
    if ((size != RECORD_SIZE) || ((octets[0] & (uint8_t) ~(FLAG_PROTECTED | FLAG_SCRUBBED)) != 0U)) {
        return STATUS_INVALID;
    }
    while ((index < service->config.memory_count) && (service->config.memories[index].id != key)) {
        index++;
    }
    if (index >= service->config.memory_count) {
        return STATUS_NOT_FOUND;
    }
    if (((octets[0] & FLAG_SCRUBBED) != 0U) && (service->config.memories[index].scrub == NULL)) {
        return STATUS_UNSUPPORTED;
    }
    apply(service, index, octets[0]);
    return STATUS_OK;
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    (void)cycle;
    pus_memory_step(self, now_ns);
}

pus_service_t pus_memory_service(pus_memory_service_t* const memory)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(6, 1, load_object),        PUS_REQUEST(6, 2, load_raw),
        PUS_REQUEST(6, 3, dump_object),        PUS_REQUEST(6, 5, dump_raw),
        PUS_REQUEST(6, 7, check_object_areas), PUS_REQUEST(6, 9, check_raw),
        PUS_REQUEST(6, 11, load_atomic),       PUS_REQUEST(6, 12, abort_dumps),
        PUS_REQUEST(6, 13, enable_scrubbing),  PUS_REQUEST(6, 14, disable_scrubbing),
        PUS_REQUEST(6, 15, protect),           PUS_REQUEST(6, 16, unprotect),
        PUS_REQUEST(6, 17, check_object),      PUS_REQUEST(6, 19, load_raw_file),
        PUS_REQUEST(6, 20, dump_raw_file),     PUS_REQUEST(6, 21, load_object_file),
        PUS_REQUEST(6, 22, dump_object_file),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_MEMORY, subtypes, sizeof subtypes / sizeof subtypes[0], memory);
    service.step = step;
    return service;
}
