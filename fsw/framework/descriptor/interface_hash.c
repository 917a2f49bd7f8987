// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

typedef struct {
    const subsystem_descriptor_t* descriptor;
    uint64_t hash;
} hasher_t;

/// Add the pattern to the hash, with `name` in place of % and `number` in place of #.
static void add(hasher_t* const self, const char* const pattern, const char* const name,
                const uint32_t number)
{
    char characters[DESCRIPTOR_TEXT_OCTETS];
    text_t text = text_in(characters, sizeof characters);
    text_add_pattern(&text, pattern, name, NULL, number);
    self->hash = fnv64(self->hash, (const uint8_t*)characters, text.length);
}

static void add_fields(hasher_t* const self, const char* const pattern, const uint16_t first,
                       const uint16_t count)
{
    const descriptor_field_t* field = &self->descriptor->fields[first];
    for (uint32_t left = count; left > 0U; left--) {
        add(self, pattern, field->name, field->id);
        add(self, " % #\n", value_type_name(field->type), field->count);
        field++;
    }
}

static void add_event(hasher_t* const self, const descriptor_event_t* const event)
{
    const subsystem_descriptor_t* const descriptor = self->descriptor;
    add(self, "event % #\n", event->name, event->id);
    add_fields(self, "field %", event->first_field, event->field_count);
    for (uint16_t i = 0U; i < event->reference_count; i++) {
        add(self, "sample %\n",
            descriptor->parameters[descriptor->references[event->first_reference + i]].name, 0U);
    }
}

static void add_configuration(hasher_t* const self, const descriptor_configuration_t* const configuration)
{
    add(self, "configuration % #\n", configuration->name, configuration->id);
    for (uint16_t i = 0U; i < configuration->port_count; i++) {
        const descriptor_port_t* const port = &self->descriptor->ports[configuration->first_port + i];
        add(self, port->is_provided ? "port % # provides\n" : "port % # requires\n", port->name, port->id);
        add_fields(self, "field %", port->first_field, port->field_count);
    }
}

static void add_service(hasher_t* const self, const descriptor_service_t* const service)
{
    // The storage of a service of the spacecraft does not depend on the descriptor.
    if (!service->is_of_spacecraft) {
        add(self, "service #", NULL, service->type);
        add(self, " #", NULL, service->capacity);
        add(self, " #\n", NULL, service->functional);
    }
}

uint64_t descriptor_subsystem_interface_hash(const subsystem_descriptor_t* const descriptor)
{
    hasher_t self = {descriptor, FNV64_START};
    add(&self, "subsystem % #\n", descriptor->name, descriptor->apid);
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        add(&self, "parameter % #", parameter->name, parameter->number);
        add(&self, " #\n", NULL, (parameter->id >> 16U) & 0x1FU);
        add_fields(&self, "field %", parameter->first_field, parameter->field_count);
    }
    for (uint16_t i = 0U; i < descriptor->event_count; i++) {
        add_event(&self, &descriptor->events[i]);
    }
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        add(&self, "function % #\n", function->name, function->id);
        add_fields(&self, "argument % #", function->first_argument, function->argument_count);
    }
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        add_service(&self, &descriptor->services[i]);
    }
    for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
        add_configuration(&self, &descriptor->configurations[i]);
    }
    for (uint16_t i = 0U; i < descriptor->enumeration_count; i++) {
        const descriptor_enumeration_t* const enumeration = &descriptor->enumerations[i];
        add(&self, "enumeration % #", enumeration->name, enumeration->first);
        add(&self, " %\n", enumeration->values, 0U);
    }
    for (uint16_t i = 0U; i < descriptor->failure_count; i++) {
        add(&self, "failure % #\n", descriptor->failures[i].name, descriptor->failures[i].id);
    }
    return self.hash;
}
