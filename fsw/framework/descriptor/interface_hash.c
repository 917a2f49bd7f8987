// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

#include <string.h>

/// The pattern, with `name` in place of % and `number` in place of #.
static void add(uint64_t* const hash, const char* const pattern, const char* const name,
                const uint32_t number)
{
    char digits[12];
    text_t text = text_in(digits, sizeof digits);
    text_add_unsigned(&text, number);
    for (const char* at = pattern; *at != '\0'; at++) {
        const char* const piece = (*at == '%') ? name : ((*at == '#') ? digits : at);
        *hash                   = fnv64(*hash, (const uint8_t*)piece, (piece == at) ? 1U : strlen(piece));
    }
}

static void hash_fields(uint64_t* const hash, const subsystem_descriptor_t* const descriptor,
                        const uint16_t first, const uint16_t count, const bool is_argument)
{
    const descriptor_field_t* field = &descriptor->fields[first];
    for (uint32_t left = count; left > 0U; left--) {
        add(hash, is_argument ? "argument % #" : "field %", field->name, field->id);
        add(hash, " % #\n", value_type_name(field->type), field->count);
        field++;
    }
}

static void hash_events(uint64_t* const hash, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t e = 0U; e < descriptor->event_count; e++) {
        const descriptor_event_t* const event = &descriptor->events[e];
        add(hash, "event % #\n", event->name, event->id);
        hash_fields(hash, descriptor, event->first_field, event->field_count, false);
        for (uint16_t i = 0U; i < event->reference_count; i++) {
            add(hash, "sample %\n",
                descriptor->parameters[descriptor->references[event->first_reference + i]].name, 0U);
        }
    }
}

static void hash_configurations(uint64_t* const hash, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t c = 0U; c < descriptor->configuration_count; c++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[c];
        add(hash, "configuration % #\n", configuration->name, configuration->id);
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            add(hash, port->is_provided ? "port % # provides\n" : "port % # requires\n", port->name,
                port->id);
            hash_fields(hash, descriptor, port->first_field, port->field_count, false);
        }
    }
}

uint64_t descriptor_subsystem_interface_hash(const subsystem_descriptor_t* const descriptor)
{
    uint64_t hash = FNV64_START;
    add(&hash, "subsystem % #\n", descriptor->name, descriptor->apid);
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        add(&hash, "parameter % #", parameter->name, parameter->number);
        add(&hash, " #\n", "", (parameter->id >> 16U) & 0x1FU);
        hash_fields(&hash, descriptor, parameter->first_field, parameter->field_count, false);
    }
    hash_events(&hash, descriptor);
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        add(&hash, "function % #\n", function->name, function->id);
        hash_fields(&hash, descriptor, function->first_argument, function->argument_count, true);
    }
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        const descriptor_service_t* const service = &descriptor->services[i];
        if (service->is_of_spacecraft) {
            continue; // Its storage does not depend on the descriptor.
        }
        add(&hash, "service #", "", service->type);
        add(&hash, " #", "", service->capacity);
        add(&hash, " #\n", "", service->functional);
    }
    hash_configurations(&hash, descriptor);
    return hash;
}
