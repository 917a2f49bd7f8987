// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/telemetry_directory.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "base/text.h"

#include <string.h>

#define HOUSEKEEPING_REPORT 25U
#define INDEX_MAX 65535U

void supervisor_telemetry_directory_init(telemetry_directory_t* const directory)
{
    FSW_ASSERT(directory != NULL);
    (void)memset(directory, 0, sizeof *directory);
}

// ---- Names ----

static uint64_t hash_of(const char* const name, const size_t size)
{
    return fnv64(FNV64_START, (const uint8_t*)name, size);
}

static void learn_field(telemetry_directory_t* const directory, const char* const name, const uint32_t id,
                        const descriptor_field_t* const field, const uint32_t offset)
{
    if (directory->field_count >= TELEMETRY_FIELDS) {
        directory->full++;
        return;
    }
    directory->fields[directory->field_count] =
        (telemetry_field_t){.name  = hash_of(name, strlen(name)),
                            .first = {.parameter_id = id, .offset = offset, .type = field->type},
                            .count = field->count};
    directory->field_count++;
}

static void learn_parameter(telemetry_directory_t* const directory,
                            const subsystem_descriptor_t* const descriptor,
                            const descriptor_parameter_t* const parameter)
{
    char name[TELEMETRY_NAME_MAX];
    uint32_t offset = 0U;
    if ((directory->parameter_count >= TELEMETRY_PARAMETERS) || (parameter->wire_size > UINT16_MAX)) {
        directory->full++;
        return;
    }
    directory->parameters[directory->parameter_count] =
        (telemetry_parameter_t){.id = parameter->id, .size = (uint16_t)parameter->wire_size};
    directory->parameter_count++;
    for (uint16_t i = 0U; i < parameter->field_count; i++) {
        const descriptor_field_t* const field = &descriptor->fields[parameter->first_field + i];
        text_t text                           = text_in(name, sizeof name);
        text_add(&text, descriptor->name);
        text_add(&text, ".");
        text_add(&text, parameter->name);
        if (parameter->is_struct) {
            text_add(&text, ".");
            text_add(&text, field->name);
        }
        learn_field(directory, name, parameter->id, field, offset);
        offset += (uint32_t)(field->count * value_size(field->type));
    }
}

/// Split the index in brackets off the end of a name. Without brackets the index is 0. False if the brackets
/// do not contain a number.
static bool split_index(const char* const name, size_t* const out_size, uint32_t* const out_index)
{
    const size_t size = strcspn(name, "[");
    *out_size         = size;
    *out_index        = 0U;
    if (name[size] == '\0') {
        return true;
    }
    size_t position = size + 1U;
    while ((name[position] >= '0') && (name[position] <= '9') && (*out_index <= INDEX_MAX)) {
        *out_index = (*out_index * 10U) + (uint32_t)(name[position] - '0');
        position++;
    }
    return (position > (size + 1U)) && (name[position] == ']') && (name[position + 1U] == '\0');
}

status_t supervisor_telemetry_directory_find(const telemetry_directory_t* const directory,
                                             const char* const name, telemetry_scalar_t* const out_scalar)
{
    FSW_ASSERT((directory != NULL) && (name != NULL) && (out_scalar != NULL));
    size_t size    = 0U;
    uint32_t index = 0U;
    if (!split_index(name, &size, &index)) {
        return STATUS_NOT_FOUND;
    }
    const bool has_index = name[size] != '\0';
    const uint64_t hash  = hash_of(name, size);
    for (uint16_t i = 0U; i < directory->field_count; i++) {
        const telemetry_field_t* const field = &directory->fields[i];
        if ((field->name == hash) && (index < field->count) && (has_index == (field->count > 1U))) {
            *out_scalar = field->first;
            out_scalar->offset += index * (uint32_t)value_size(field->first.type);
            return STATUS_OK;
        }
    }
    return STATUS_NOT_FOUND;
}

// ---- Sizes ----

static status_t size_of(void* const context, const uint32_t parameter_id, uint16_t* const out_size)
{
    const telemetry_directory_t* const directory = context;
    for (uint16_t i = 0U; i < directory->parameter_count; i++) {
        if (directory->parameters[i].id == parameter_id) {
            *out_size = directory->parameters[i].size;
            return STATUS_OK;
        }
    }
    return STATUS_NOT_FOUND;
}

telemetry_cache_sizes_t supervisor_telemetry_directory_sizes(telemetry_directory_t* const directory)
{
    return (telemetry_cache_sizes_t){.context = directory, .size_of = size_of};
}

// ---- Structures ----

static void write_parameters(octet_writer_t* const writer, const subsystem_descriptor_t* const descriptor,
                             const uint16_t first, const uint16_t count)
{
    octet_write_u16(writer, count);
    for (uint16_t i = 0U; i < count; i++) {
        octet_write_u32(writer, descriptor->parameters[descriptor->references[first + i]].id);
    }
}

/// Store the definition of a structure in the form that supervisor_telemetry_cache_define reads.
static void learn_structure(telemetry_directory_t* const directory,
                            const subsystem_descriptor_t* const descriptor, const uint16_t configuration,
                            const descriptor_structure_t* const structure)
{
    octet_writer_t writer = octet_writer(&directory->content[directory->content_used],
                                         (size_t)TELEMETRY_CONTENT - directory->content_used);
    write_parameters(&writer, descriptor, structure->first_reference, structure->reference_count);
    octet_write_u16(&writer, structure->sampled_count);
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        const descriptor_sampled_t* const sampled = &descriptor->sampled[structure->first_sampled + i];
        octet_write_u16(&writer, sampled->nrep);
        write_parameters(&writer, descriptor, sampled->first_reference, sampled->reference_count);
    }
    if (writer.failed || (directory->structure_count >= TELEMETRY_STRUCTURES)) {
        directory->full++;
        return;
    }
    directory->structures[directory->structure_count] =
        (telemetry_structure_t){.apid          = descriptor->apid,
                                .configuration = configuration,
                                .id            = structure->id,
                                .offset        = directory->content_used,
                                .size          = (uint16_t)writer.position};
    directory->structure_count++;
    directory->content_used = (uint16_t)(directory->content_used + writer.position);
}

void supervisor_telemetry_directory_learn(telemetry_directory_t* const directory,
                                          const subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT((directory != NULL) && (descriptor != NULL));
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        learn_parameter(directory, descriptor, &descriptor->parameters[i]);
    }
    for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[i];
        for (uint16_t k = 0U; k < configuration->structure_count; k++) {
            learn_structure(directory, descriptor, configuration->id,
                            &descriptor->structures[configuration->first_structure + k]);
        }
    }
}

void supervisor_telemetry_directory_define(const telemetry_directory_t* const directory,
                                           telemetry_cache_t* const cache, const uint16_t apid,
                                           const uint16_t configuration)
{
    FSW_ASSERT((directory != NULL) && (cache != NULL));
    for (uint16_t i = 0U; i < directory->structure_count; i++) {
        const telemetry_structure_t* const structure = &directory->structures[i];
        octet_reader_t content = octet_reader(&directory->content[structure->offset], structure->size);
        if ((structure->apid == apid) && (structure->configuration == configuration)) {
            // The cache counts definitions for which it has no room.
            (void)supervisor_telemetry_cache_define(cache, apid, HOUSEKEEPING_REPORT, structure->id,
                                                    &content);
        }
    }
}
