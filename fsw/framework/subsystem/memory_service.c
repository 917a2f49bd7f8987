// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/memory_service.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/optional_services.h"

#include <string.h>

#define PARAMETER_ALIGNMENT 8U

// ---- Parameters ----

/// Returns the octets that a parameter occupies in MEMORY_PARAMETERS: each one begins at a multiple of 8.
static uint32_t occupied(const parameter_entry_t* const entry)
{
    const uint32_t size = entry->definition->memory_size;
    return ((size + PARAMETER_ALIGNMENT - 1U) / PARAMETER_ALIGNMENT) * PARAMETER_ALIGNMENT;
}

/// Find the parameter octets at `address`. Returns their address in the storage and the number of contiguous
/// octets, at most `size`; null if there are none.
static uint8_t* parameter_at(const subsystem_t* const subsystem, const uint32_t address, const size_t size,
                             size_t* const out_size)
{
    uint32_t begin = 0U;
    for (uint16_t i = 0U; i < subsystem->dictionary.count; i++) {
        const parameter_entry_t* const entry = &subsystem->entries[i];
        const uint32_t octets                = entry->definition->memory_size;
        if ((address - begin) < octets) { // If the address is lower, the difference wraps to a large number.
            const size_t rest = octets - (address - begin);
            *out_size         = (rest < size) ? rest : size;
            return (uint8_t*)entry->storage + (address - begin);
        }
        begin += occupied(entry);
    }
    return NULL;
}

/// True if each octet of an area belongs to a parameter, and none to the padding between two parameters.
static bool is_published(const subsystem_t* const subsystem, const uint32_t address, const size_t size)
{
    size_t piece = 0U;
    size_t done  = 0U;
    while ((done < size) &&
           (parameter_at(subsystem, address + (uint32_t)done, size - done, &piece) != NULL)) {
        done += piece;
    }
    return done == size;
}

/// Copy from parameters to `into`, or, if `from` is not null, from there into parameters. STATUS_OK;
/// STATUS_NOT_FOUND: an octet belongs to no parameter, and nothing is copied.
static status_t copy_parameters(subsystem_t* const subsystem, const uint32_t address,
                                const uint8_t* const from, uint8_t* const into, const size_t size)
{
    size_t done = 0U;
    FSW_ASSERT((from != NULL) || (into != NULL));
    parameter_lock(&subsystem->dictionary);
    const bool is_whole = is_published(subsystem, address, size);
    while (is_whole && (done < size)) {
        size_t piece          = 0U;
        uint8_t* const stored = parameter_at(subsystem, address + (uint32_t)done, size - done, &piece);
        FSW_ASSERT(stored != NULL);
        if (from != NULL) {
            (void)memcpy(stored, &from[done], piece);
        } else {
            (void)memcpy(&into[done], stored, piece);
        }
        done += piece;
    }
    parameter_unlock(&subsystem->dictionary);
    return is_whole ? STATUS_OK : STATUS_NOT_FOUND;
}

static status_t read_parameters(void* const context, const uint32_t address, uint8_t* const octets,
                                const size_t size)
{
    return copy_parameters(context, address, NULL, octets, size);
}

static status_t write_parameters(void* const context, const uint32_t address, const uint8_t* const octets,
                                 const size_t size)
{
    return copy_parameters(context, address, octets, NULL, size);
}

static status_t find_parameter_object(void* const context, const uint32_t base_id,
                                      uint32_t* const out_address, uint32_t* const out_size)
{
    const subsystem_t* const subsystem = context;
    uint32_t begin                     = 0U;
    for (uint16_t i = 0U; i < subsystem->dictionary.count; i++) {
        const parameter_entry_t* const entry = &subsystem->entries[i];
        if (entry->definition->id == base_id) {
            *out_address = begin;
            *out_size    = entry->definition->memory_size;
            return STATUS_OK;
        }
        begin += occupied(entry);
    }
    return STATUS_NOT_FOUND;
}

// ---- Component ----

static status_t read_component(void* const context, const uint32_t address, uint8_t* const octets,
                               const size_t size)
{
    (void)memcpy(octets, (const uint8_t*)context + address, size);
    return STATUS_OK;
}

static status_t find_component_object(void* const context, const uint32_t base_id,
                                      uint32_t* const out_address, uint32_t* const out_size)
{
    const subsystem_t* const subsystem = context;
    if (base_id == MEMORY_OBJECT_CALL_TOKENS) {
        *out_address = (uint32_t)offsetof(subsystem_t, call_token_storage);
        *out_size    = (uint32_t)sizeof subsystem->call_token_storage;
        return STATUS_OK;
    }
    if (base_id == MEMORY_OBJECT_SAMPLES) {
        *out_address = (uint32_t)offsetof(subsystem_t, samples);
        *out_size    = (uint32_t)sizeof subsystem->samples;
        return STATUS_OK;
    }
    return STATUS_NOT_FOUND;
}

/// Scrub octets: a read makes the hardware correct an error, so the values are not used.
static void scrub_component(void* const context, const uint32_t address, const size_t size)
{
    const volatile uint8_t* const octets = (const uint8_t*)context + address;
    for (size_t i = 0U; i < size; i++) {
        (void)octets[i];
    }
}

/// Describe the memories that every subsystem has.
static void describe_memories(subsystem_t* const subsystem, pus_memory_t* const memories)
{
    memories[0] = (pus_memory_t){.id      = MEMORY_PARAMETERS,
                                 .access  = 1U,
                                 .size    = MEMORY_PARAMETERS_OCTETS,
                                 .context = subsystem,
                                 .read    = read_parameters,
                                 .write   = write_parameters,
                                 .object  = find_parameter_object};
    memories[1] = (pus_memory_t){.id      = MEMORY_COMPONENT,
                                 .access  = 1U,
                                 .size    = (uint32_t)sizeof *subsystem,
                                 .context = subsystem,
                                 .read    = read_component,
                                 .scrub   = scrub_component,
                                 .object  = find_component_object};
}

/// Let ST[20] define parameters by their addresses in these memories.
static void define_parameters(subsystem_t* const subsystem, memory_service_t* const service,
                              const uint8_t memory_count)
{
    const pus_parameter_definitions_config_t definitions = {.apid     = subsystem_process(subsystem)->apid,
                                                            .port     = subsystem_parameter_port(subsystem),
                                                            .memories = service->memories,
                                                            .states   = service->states,
                                                            .memory_count = memory_count,
                                                            .table        = service->definition_table,
                                                            .capacity     = MEMORY_DEFINITIONS,
                                                            .persistence  = subsystem_persistence(subsystem),
                                                            .mutex        = &subsystem->loop_mutex};
    pus_parameter_definitions_init(&service->definitions, &definitions);
    const pus_parameter_definer_t definer = pus_parameter_definitions_definer(&service->definitions);
    pus_parameters_define(&subsystem->parameters, &definer);
}

void subsystem_memory_service_add(subsystem_t* const subsystem, memory_service_t* const service,
                                  pus_memory_operation_t* const operations, const uint8_t count)
{
    FSW_ASSERT((subsystem != NULL) && (service != NULL) && (operations != NULL));
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    subsystem_memories_t further                 = {NULL, 0U, NULL};
    if (callbacks->memories != NULL) {
        further = callbacks->memories(subsystem->config.self);
    }
    FSW_ASSERT(further.count <= MEMORY_FURTHER);
    describe_memories(subsystem, service->memories);
    for (uint8_t i = 0U; i < further.count; i++) {
        service->memories[MEMORY_COUNT + i] = further.memories[i];
    }
    const uint8_t memory_count       = (uint8_t)(MEMORY_COUNT + further.count);
    const pus_memory_config_t config = {.process         = subsystem_process(subsystem),
                                        .memories        = service->memories,
                                        .states          = service->states,
                                        .memory_count    = memory_count,
                                        .operations      = operations,
                                        .operation_count = count,
                                        .files           = further.files,
                                        .persistence     = subsystem_persistence(subsystem)};
    pus_memory_init(&service->memory, &config);
    const pus_service_t entry = pus_memory_service(&service->memory);
    subsystem_add_service(subsystem, &entry, pus_memory_restore);
    define_parameters(subsystem, service, memory_count);
}
