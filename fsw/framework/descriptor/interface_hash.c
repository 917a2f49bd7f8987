// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/base/crc.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

typedef struct { // One line of the interface text, hashed when it is complete.
    uint64_t hash;
    char words[192];
    text_t text;
} line_t;

static void begin_line(line_t* const line, const char* const kind, const char* const name)
{
    line->text = text_in(line->words, sizeof line->words);
    text_add(&line->text, kind);
    text_add(&line->text, " ");
    text_add(&line->text, name);
}

static void add_number(line_t* const line, const uint32_t number)
{
    text_add(&line->text, " ");
    text_add_unsigned(&line->text, number);
}

static void end_line(line_t* const line)
{
    text_add(&line->text, "\n");
    line->hash = fnv64(line->hash, (const uint8_t*)line->words, line->text.length);
}

static void hash_fields(line_t* const line, const subsystem_descriptor_t* const descriptor,
                        const uint16_t first, const uint16_t count, const bool is_argument)
{
    for (uint16_t i = first; i < (first + count); i++) {
        const descriptor_field_t* const field = &descriptor->fields[i];
        begin_line(line, is_argument ? "argument" : "field", field->name);
        if (is_argument) {
            add_number(line, field->id);
        }
        text_add(&line->text, " ");
        text_add(&line->text, value_type_name(field->type));
        add_number(line, field->count);
        end_line(line);
    }
}

static void hash_events(line_t* const line, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t e = 0U; e < descriptor->event_count; e++) {
        const descriptor_event_t* const event = &descriptor->events[e];
        begin_line(line, "event", event->name);
        add_number(line, event->id);
        end_line(line);
        hash_fields(line, descriptor, event->first_field, event->field_count, false);
        for (uint16_t i = 0U; i < event->reference_count; i++) {
            begin_line(line, "sample",
                       descriptor->parameters[descriptor->references[event->first_reference + i]].name);
            end_line(line);
        }
    }
}

static void hash_configurations(line_t* const line, const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t c = 0U; c < descriptor->configuration_count; c++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[c];
        begin_line(line, "configuration", configuration->name);
        add_number(line, configuration->id);
        end_line(line);
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            begin_line(line, "port", port->name);
            add_number(line, port->id);
            text_add(&line->text, port->is_provided ? " provides" : " requires");
            end_line(line);
            hash_fields(line, descriptor, port->first_field, port->field_count, false);
        }
    }
}

uint64_t subsystem_interface_hash(const subsystem_descriptor_t* const descriptor)
{
    line_t line = {.hash = FNV64_START};
    begin_line(&line, "subsystem", descriptor->name);
    add_number(&line, descriptor->apid);
    end_line(&line);
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        begin_line(&line, "parameter", parameter->name);
        add_number(&line, parameter->number);
        add_number(&line, (parameter->id >> 16U) & 0x1FU);
        end_line(&line);
        hash_fields(&line, descriptor, parameter->first_field, parameter->field_count, false);
    }
    hash_events(&line, descriptor);
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        begin_line(&line, "function", function->name);
        add_number(&line, function->id);
        end_line(&line);
        hash_fields(&line, descriptor, function->first_argument, function->argument_count, true);
    }
    hash_configurations(&line, descriptor);
    return line.hash;
}
