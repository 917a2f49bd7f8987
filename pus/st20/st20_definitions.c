// SPDX-License-Identifier: Apache-2.0
#include "pus/st20/st20_definitions.h"

#include "base/assertion.h"
#include "base/value.h"
#include "pus/core/packet.h"
#include "pus/st06/st06_areas.h"

#include <string.h>

#define HANDLE 0x8000U // This bit is set in the handles of definitions, but not in those of the dictionary.
#define APID_SHIFT 21U
#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define RECORD_SIZE 6U // Memory id (1), address (4), type (1) [octets].

void pus_parameter_definitions_init(pus_parameter_definitions_t* const definitions,
                                    const pus_parameter_definitions_config_t* const config)
{
    FSW_ASSERT((definitions != NULL) && (config != NULL) && (config->port.find != NULL) &&
               (config->memories != NULL) && (config->states != NULL) && (config->table != NULL));
    definitions->config = *config;
    for (uint16_t i = 0U; i < config->capacity; i++) {
        config->table[i].in_use = false;
    }
}

static pus_parameter_definition_t* definition_of(const pus_parameter_definitions_t* const definitions,
                                                 const uint32_t id)
{
    for (uint16_t i = 0U; i < definitions->config.capacity; i++) {
        if (definitions->config.table[i].in_use && (definitions->config.table[i].id == id)) {
            return &definitions->config.table[i];
        }
    }
    return NULL;
}

static pus_parameter_definition_t* free_entry(const pus_parameter_definitions_t* const definitions)
{
    for (uint16_t i = 0U; i < definitions->config.capacity; i++) {
        if (!definitions->config.table[i].in_use) {
            return &definitions->config.table[i];
        }
    }
    return NULL;
}

// ---- The port ----

static status_t find(void* const context, const uint32_t parameter_id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    const pus_parameter_definitions_t* const definitions = context;
    const pus_parameter_port_t* const port               = &definitions->config.port;
    const pus_parameter_definition_t* const definition   = definition_of(definitions, parameter_id);
    if (definition == NULL) {
        return port->find(port->context, parameter_id, out_handle, out_size);
    }
    *out_handle = (uint16_t)(HANDLE | (unsigned)(definition - definitions->config.table));
    *out_size   = (uint16_t)value_size((value_type_t)definition->type);
    return STATUS_OK;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    const pus_parameter_definitions_t* const definitions = context;
    const pus_parameter_port_t* const port               = &definitions->config.port;
    if ((handle & HANDLE) == 0U) {
        port->read(port->context, handle, writer);
        return;
    }
    const pus_parameter_definition_t* const definition = &definitions->config.table[handle & (HANDLE - 1U)];
    const pus_memory_t* const memory                   = &definitions->config.memories[definition->memory];
    uint64_t value = 0U; // Aligned for every type; 0 if the memory cannot be read.
    uint8_t octets[sizeof value];
    const size_t size = value_size((value_type_t)definition->type);
    if (memory->read(memory->context, definition->address, octets, size) == STATUS_OK) {
        (void)memcpy(&value, octets, size);
    }
    value_encode(writer, (value_type_t)definition->type, &value);
}

static status_t write(void* const context, const uint16_t handle, const uint8_t* const octets,
                      const size_t size)
{
    const pus_parameter_definitions_t* const definitions = context;
    const pus_parameter_port_t* const port               = &definitions->config.port;
    if ((handle & HANDLE) == 0U) {
        return (port->write != NULL) ? port->write(port->context, handle, octets, size) : STATUS_READ_ONLY;
    }
    const pus_parameter_definition_t* const definition = &definitions->config.table[handle & (HANDLE - 1U)];
    const pus_memory_t* const memory                   = &definitions->config.memories[definition->memory];
    octet_reader_t reader                              = octet_reader(octets, size);
    uint64_t value                                     = 0U;
    uint8_t own[sizeof value];
    if ((memory->write == NULL) || definitions->config.states[definition->memory].is_protected) {
        return STATUS_READ_ONLY;
    }
    if (value_decode(&reader, (value_type_t)definition->type, &value) != STATUS_OK) {
        return STATUS_INVALID;
    }
    (void)memcpy(own, &value, size);
    return (memory->write(memory->context, definition->address, own, size) == STATUS_OK) ? STATUS_OK
                                                                                         : STATUS_BUSY;
}

// ---- Definitions ----

/// Change an entry while the mutex is locked, so that no other loop reads the entry meanwhile.
static void put(const pus_parameter_definitions_t* const definitions,
                pus_parameter_definition_t* const definition, const pus_parameter_definition_t* const wanted)
{
    osal_mutex_t* const mutex = definitions->config.mutex;
    if (mutex != NULL) {
        // This cannot fail: a task that dies ends the process, so no other task is left to lock the mutex.
        (void)osal_mutex_lock(mutex);
    }
    *definition = *wanted;
    if (mutex != NULL) {
        osal_mutex_unlock(mutex);
    }
}

/// Store the record of a definition; if this succeeds, apply the definition.
static pus_failure_t store_definition(const pus_parameter_definitions_t* const definitions,
                                      pus_parameter_definition_t* const definition,
                                      const pus_parameter_definition_t* const wanted)
{
    const pus_persistence_t* const persistence = definitions->config.persistence;
    uint8_t record[RECORD_SIZE];
    record[0] = definitions->config.memories[wanted->memory].id;
    octets_put_u32(&record[1], wanted->address);
    record[RECORD_SIZE - 1U] = wanted->type;
    const status_t status    = (persistence == NULL)
                                   ? STATUS_OK
                                   : persistence->put(persistence->context, PUS_SERVICE_PARAMETERS, wanted->id,
                                                      record, sizeof record);
    if (status != STATUS_OK) {
        return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    }
    put(definitions, definition, wanted);
    return pus_no_failure();
}

/// Check id, PTC and PFC of a definition; `offset`: octet offset of the definition. Returns PUS_FAILURE_NONE,
/// or the failure.
static pus_failure_t check_id(const pus_parameter_definitions_t* const definitions, const uint32_t id,
                              const uint8_t ptc, const uint16_t pfc, const size_t offset)
{
    const pus_parameter_port_t* const port = &definitions->config.port;
    const uint32_t layout                  = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    uint16_t handle                        = 0U;
    uint16_t size                          = 0U;
    if (port->find(port->context, id, &handle, &size) != STATUS_NOT_FOUND) {
        return pus_failure(PUS_FAILURE_ACCESS, id);
    }
    if ((id >> APID_SHIFT) != definitions->config.apid) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    const pus_parameter_code_t code = pus_parameter_code_of(id);
    const bool is_type = (layout < (uint32_t)VALUE_SCALARS) && (code.ptc == ptc) && (code.pfc == pfc);
    return is_type ? pus_no_failure() : pus_failure(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)offset);
}

static pus_failure_t define(void* const context, octet_reader_t* const reader, const bool is_object)
{
    const pus_parameter_definitions_t* const definitions = context;
    const size_t begin                                   = reader->position;
    const uint32_t id                                    = octet_read_u32(reader);
    octet_reader_t memory_reader                         = *reader;
    memory_target_t target                               = {0};
    pus_parameter_definition_t* definition               = definition_of(definitions, id);
    (void)octet_read_octets(reader, is_object ? 5U : 1U); // Memory id, and base id of an object.
    const uint32_t address = octet_read_u32(reader);
    const uint8_t ptc      = octet_read_u8(reader);
    const uint16_t pfc     = octet_read_u16(reader);
    pus_failure_t failure  = check_id(definitions, id, ptc, pfc, begin);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = memory_find(definitions->config.memories, definitions->config.memory_count, &memory_reader,
                              is_object, &target);
    }
    if (failure.code != PUS_FAILURE_NONE) {
        return failure;
    }
    const uint32_t type = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    if (!memory_is_inside(&target, address, (uint32_t)value_size((value_type_t)type))) {
        return pus_failure(PUS_FAILURE_ADDRESS, address);
    }
    definition = (definition == NULL) ? free_entry(definitions) : definition;
    if (definition == NULL) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, definitions->config.capacity);
    }
    const pus_parameter_definition_t wanted = {.in_use  = true,
                                               .memory  = target.index,
                                               .type    = (uint8_t)type,
                                               .id      = id,
                                               .address = target.origin + address};
    return store_definition(definitions, definition, &wanted);
}

static void locate(const void* const context, const uint32_t id, uint8_t* const out_memory_id,
                   uint32_t* const out_address)
{
    const pus_parameter_definitions_t* const definitions = context;
    const pus_parameter_definition_t* const definition   = definition_of(definitions, id);
    if (definition != NULL) {
        *out_memory_id = definitions->config.memories[definition->memory].id;
        *out_address   = definition->address;
    }
}

static status_t restore(void* const context, const uint32_t key, const uint8_t* const octets,
                        const size_t size)
{
    const pus_parameter_definitions_t* const definitions = context;
    if ((size != RECORD_SIZE) || (octets[RECORD_SIZE - 1U] != ((key >> LAYOUT_SHIFT) & LAYOUT_MASK)) ||
        (octets[RECORD_SIZE - 1U] >= (uint8_t)VALUE_SCALARS)) {
        return STATUS_INVALID;
    }
    octet_reader_t reader                  = octet_reader(octets, size);
    memory_target_t target                 = {0};
    pus_parameter_definition_t* definition = definition_of(definitions, key);
    definition                             = (definition == NULL) ? free_entry(definitions) : definition;
    const pus_failure_t failure =
        memory_find(definitions->config.memories, definitions->config.memory_count, &reader, false, &target);
    const uint32_t address  = octet_read_u32(&reader);
    const value_type_t type = (value_type_t)octets[RECORD_SIZE - 1U];
    if ((failure.code != PUS_FAILURE_NONE) ||
        !memory_is_inside(&target, address, (uint32_t)value_size(type))) {
        return STATUS_NOT_FOUND;
    }
    if (definition == NULL) {
        return STATUS_EXHAUSTED;
    }
    const pus_parameter_definition_t kept = {
        .in_use = true, .memory = target.index, .type = (uint8_t)type, .id = key, .address = address};
    put(definitions, definition, &kept);
    return STATUS_OK;
}

pus_parameter_definer_t pus_parameter_definitions_definer(pus_parameter_definitions_t* const definitions)
{
    FSW_ASSERT(definitions != NULL);
    return (pus_parameter_definer_t){
        .port    = {.context = definitions, .find = find, .read = read, .write = write},
        .define  = define,
        .locate  = locate,
        .restore = restore};
}
