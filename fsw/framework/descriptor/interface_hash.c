// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/base/crc.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

#include <string.h>

static void add(uint64_t* const hash, const char* const words)
{
    *hash = fnv64(*hash, (const uint8_t*)words, strlen(words));
}

/// "<before><name> <number><behind>".
static void add_entry(uint64_t* const hash, const char* const before, const char* const name,
                      const uint32_t number, const char* const behind)
{
    char digits[12];
    text_t text = text_in(digits, sizeof digits);
    text_add(&text, " ");
    text_add_unsigned(&text, number);
    add(hash, before);
    add(hash, name);
    add(hash, digits);
    add(hash, behind);
}

static void hash_fields(uint64_t* const hash, const subsystem_descriptor_t* const descriptor,
                        const uint16_t first, const uint16_t count, const bool is_argument)
{
    for (uint16_t i = first; i < (first + count); i++) {
        const descriptor_field_t* const field = &descriptor->fields[i];
        if (is_argument) {
            add_entry(hash, "argument ", field->name, field->id, "");
        } else {
            add(hash, "field ");
            add(hash, field->name);
        }
        add_entry(hash, " ", value_type_name(field->type), field->count, "\n");
    }
}

static void hash_events(uint64_t* const hash, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t e = 0U; e < descriptor->event_count; e++) {
        const descriptor_event_t* const event = &descriptor->events[e];
        add_entry(hash, "event ", event->name, event->id, "\n");
        hash_fields(hash, descriptor, event->first_field, event->field_count, false);
        for (uint16_t i = 0U; i < event->reference_count; i++) {
            add(hash, "sample ");
            add(hash, descriptor->parameters[descriptor->references[event->first_reference + i]].name);
            add(hash, "\n");
        }
    }
}

static void hash_configurations(uint64_t* const hash, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t c = 0U; c < descriptor->configuration_count; c++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[c];
        add_entry(hash, "configuration ", configuration->name, configuration->id, "\n");
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            add_entry(hash, "port ", port->name, port->id, port->is_provided ? " provides\n" : " requires\n");
            hash_fields(hash, descriptor, port->first_field, port->field_count, false);
        }
    }
}

uint64_t subsystem_interface_hash(const subsystem_descriptor_t* const descriptor)
{
    uint64_t hash = FNV64_START;
    add_entry(&hash, "subsystem ", descriptor->name, descriptor->apid, "\n");
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        add_entry(&hash, "parameter ", parameter->name, parameter->number, "");
        add_entry(&hash, "", "", (parameter->id >> 16U) & 0x1FU, "\n");
        hash_fields(&hash, descriptor, parameter->first_field, parameter->field_count, false);
    }
    hash_events(&hash, descriptor);
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        add_entry(&hash, "function ", function->name, function->id, "\n");
        hash_fields(&hash, descriptor, function->first_argument, function->argument_count, true);
    }
    hash_configurations(&hash, descriptor);
    return hash;
}
