// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/subsystem_builder.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc.h"
#include "fsw/framework/base/number.h"

#include <float.h>
#include <string.h>

#define SAMPLING_US 10000U
#define TIMEOUT_US 1000000U
#define WARN_PERCENT 75U
#define CLEAR_PERCENT 65U
#define AUXILIARY_OCTETS_MAX 1024U

subsystem_builder_t* subsystem_builder_of(source_t* const source)
{
    return source->builder;
}

void subsystem_builder_taken(source_t* const source, const char* const attribute, const char* const value,
                             const uint32_t line)
{
    if (source_fail(source, source->line, STATUS_INVALID, attribute)) {
        text_add(source->error, " ");
        text_add(source->error, value);
        text_add(source->error, " is taken in line ");
        text_add_unsigned(source->error, line);
    }
}

void subsystem_builder_once(source_t* const source, const uint8_t kind)
{
    subsystem_builder_t* const builder = source->builder;
    if (((builder->seen >> kind) & 1U) != 0U) {
        if (source_fail(source, source->line, STATUS_INVALID, "a second <")) {
            text_add(source->error, source->open[source->depth - 1U]->name);
            text_add(source->error, ">");
        }
    }
    builder->seen |= (uint32_t)1U << kind;
}

static void start_subsystem(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    descriptor->name                         = source_identifier(source, "name", DESCRIPTOR_NAME_MAX);
    descriptor->apid                         = (uint16_t)source_unsigned(source, "id", 1U, 2046U, 0U);
    descriptor->sampling_us = source_time_us(source, "samplingTime", 100U, 10000000U, SAMPLING_US);
}

static void start_resources(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    subsystem_builder_once(source, KIND_RESOURCES);
    descriptor->pool_warn_percent  = (uint8_t)source_unsigned(source, "poolWarning", 1U, 100U, WARN_PERCENT);
    descriptor->pool_clear_percent = (uint8_t)source_unsigned(source, "poolClear", 0U, 99U, CLEAR_PERCENT);
    if (descriptor->pool_clear_percent >= descriptor->pool_warn_percent) {
        (void)source_fail(source, source->line, STATUS_INVALID, "poolClear is not below poolWarning");
    }
}

static void start_states(source_t* const source)
{
    subsystem_builder_once(source, KIND_STATES);
}

static void start_state(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    uint8_t state                            = 0U;
    if (descriptor_state_of(source_raw(source, "name"), &state) != STATUS_OK) {
        source_wrong(source, "name", "the name of a state");
        return;
    }
    if (descriptor->timeout_us[state] != 0U) {
        (void)source_fail(source, source->line, STATUS_INVALID, "this state has a time-out already");
    }
    descriptor->timeout_us[state] = source_time_us(source, "timeout", 1000U, 600000000U, TIMEOUT_US);
}

static void check_bounds(source_t* const source, descriptor_field_t* const field)
{
    field->min = -DBL_MAX;
    field->max = DBL_MAX;
    if (source_has(source, "min")) {
        (void)source_number(source, "min", field->type, &field->min);
    }
    if (source_has(source, "max")) {
        (void)source_number(source, "max", field->type, &field->max);
    }
    if (field->min > field->max) {
        source_wrong(source, "min", "at most max");
    }
}

void subsystem_builder_check_values(source_t* const source, const char* const attribute,
                                    const descriptor_field_t* const field)
{
    const char* at = source_raw(source, attribute);
    bool is_right  = (at != NULL) && source_is_spaced(at);
    bool is_within = true;
    for (uint16_t i = 0U; is_right && (i < field->count); i++) {
        uint64_t scalar    = 0U;
        is_right           = (number_read_value(&at, field->type, &scalar) == STATUS_OK);
        const double value = is_right ? value_as_double(field->type, &scalar) : field->min;
        is_within          = is_within && (value >= field->min) && (value <= field->max);
    }
    if (!is_right || !number_is_end(at)) {
        char expected[96];
        text_t text = text_in(expected, sizeof expected);
        text_add_unsigned(&text, field->count);
        text_add(&text, " number(s) of type ");
        text_add(&text, value_type_name(field->type));
        text_add(&text, ", one space between");
        source_wrong(source, attribute, expected);
    } else if (!is_within) {
        source_wrong(source, attribute, "numbers within min and max");
    }
}

descriptor_field_t* subsystem_builder_field(source_t* const source, const uint16_t index)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    if (!source_has_room(source, descriptor->field_count, DESCRIPTOR_FIELDS_MAX,
                         "fields in one descriptor")) {
        return NULL;
    }
    descriptor_field_t* const field = &descriptor->fields[descriptor->field_count];
    *field = (descriptor_field_t){.name  = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                  .type  = source_value_type(source, "type"),
                                  .id    = index,
                                  .count = (uint16_t)source_unsigned(source, "count", 1U, 256U, 1U),
                                  .unit  = source_text(source, "unit", 16U),
                                  .line  = source->line};
    check_bounds(source, field);
    if ((source->status == STATUS_OK) && source_has(source, "init")) {
        subsystem_builder_check_values(source, "init", field);
        field->init = source_text(source, "init", UINT32_MAX);
    }
    if (source->status != STATUS_OK) {
        return NULL;
    }
    descriptor->field_count++;
    return field;
}

uint32_t subsystem_builder_octets(const subsystem_descriptor_t* const descriptor, const uint16_t first,
                                  const uint16_t count)
{
    uint32_t octets = 0U;
    for (uint16_t i = first; i < (first + count); i++) {
        octets += (uint32_t)(value_size(descriptor->fields[i].type) * descriptor->fields[i].count);
    }
    return octets;
}

void subsystem_builder_check_field_name(source_t* const source, const uint16_t first)
{
    const subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    const descriptor_field_t* const newest         = &descriptor->fields[descriptor->field_count - 1U];
    for (const descriptor_field_t* field = &descriptor->fields[first]; field < newest; field++) {
        if (strcmp(field->name, newest->name) == 0) {
            subsystem_builder_taken(source, "name", newest->name, field->line);
        }
    }
}

void subsystem_builder_refer(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    const descriptor_parameter_t* const parameter =
        descriptor_find_parameter(descriptor, source_raw(source, "name"));
    if (parameter == NULL) {
        source_wrong(source, "name", "the name of a parameter of this subsystem");
    } else if (source_has_room(source, descriptor->reference_count, DESCRIPTOR_REFERENCES_MAX,
                               "references to parameters")) {
        descriptor->references[descriptor->reference_count] = (uint16_t)(parameter - descriptor->parameters);
        descriptor->reference_count++;
    }
}

static void start_events(source_t* const source)
{
    subsystem_builder_once(source, KIND_EVENTS);
}

static void start_event(source_t* const source)
{
    static const char* const words[]         = {"INFORMATIVE", "LOW", "MEDIUM", "HIGH"};
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    if (!source_has_room(source, descriptor->event_count, DESCRIPTOR_EVENTS_MAX, "events")) {
        return;
    }
    descriptor_event_t* const event = &descriptor->events[descriptor->event_count];
    *event          = (descriptor_event_t){.name            = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                           .id              = (uint16_t)source_unsigned(source, "id", 1U, 65535U, 0U),
                                           .first_field     = descriptor->field_count,
                                           .first_reference = descriptor->reference_count,
                                           .line            = source->line};
    event->severity = (descriptor_severity_t)(source_word(source, "severity", words, 4U, 0U) + 1U);
    for (uint16_t i = 0U; i < descriptor->event_count; i++) {
        if (strcmp(descriptor->events[i].name, event->name) == 0) {
            subsystem_builder_taken(source, "name", event->name, descriptor->events[i].line);
        } else if (descriptor->events[i].id == event->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"), descriptor->events[i].line);
        }
    }
    descriptor->event_count++;
}

static void start_event_value(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    descriptor_event_t* const event          = &descriptor->events[descriptor->event_count - 1U];
    const bool has_type                      = source_has(source, "type");
    if ((has_type && (event->reference_count > 0U)) || (!has_type && (event->field_count > 0U))) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          "either all <ParamRef> of an <Event> have a type, or none has");
    } else if (has_type) {
        if (subsystem_builder_field(source, event->field_count) != NULL) {
            event->field_count++;
            subsystem_builder_check_field_name(source, event->first_field);
        }
    } else if (source_has(source, "count") || source_has(source, "unit")) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          "<ParamRef> without type has no count and no unit");
    } else {
        subsystem_builder_refer(source);
        event->reference_count = (uint16_t)(descriptor->reference_count - event->first_reference);
        for (uint16_t i = event->first_reference; (i + 1U) < descriptor->reference_count; i++) {
            if (descriptor->references[i] == descriptor->references[descriptor->reference_count - 1U]) {
                source_wrong(source, "name", "each parameter once");
            }
        }
    }
}

static void end_event(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    descriptor_event_t* const event          = &descriptor->events[descriptor->event_count - 1U];
    event->octets = subsystem_builder_octets(descriptor, event->first_field, event->field_count);
    for (uint16_t i = 0U; i < event->reference_count; i++) {
        event->octets += descriptor->parameters[descriptor->references[event->first_reference + i]].wire_size;
    }
    if (event->octets > AUXILIARY_OCTETS_MAX) {
        (void)source_fail(source, event->line, STATUS_INVALID, "more than 1024 octets of auxiliary data");
    }
}

static void start_functions(source_t* const source)
{
    subsystem_builder_once(source, KIND_FUNCTIONS);
}

/// Bits of the states in an attribute; "*" is all.
static uint16_t states_of(source_t* const source)
{
    const char* names[DESCRIPTOR_STATES];
    uint8_t indices[DESCRIPTOR_STATES];
    if (strcmp(source_raw(source, "states"), "*") == 0) {
        return (uint16_t)((1U << DESCRIPTOR_STATES) - 1U);
    }
    for (uint8_t i = 0U; i < DESCRIPTOR_STATES; i++) {
        names[i] = descriptor_state_name(i);
    }
    const uint32_t count = source_words(source, "states", names, DESCRIPTOR_STATES, indices);
    uint16_t states      = 0U;
    for (uint32_t i = 0U; i < count; i++) {
        states = (uint16_t)(states | (1U << indices[i]));
    }
    return states;
}

static void start_function(source_t* const source)
{
    subsystem_builder_t* const builder       = source->builder;
    subsystem_descriptor_t* const descriptor = builder->descriptor;
    if (!source_has_room(source, descriptor->function_count, DESCRIPTOR_FUNCTIONS_MAX, "functions")) {
        return;
    }
    descriptor_function_t* const function = &descriptor->functions[descriptor->function_count];
    *function =
        (descriptor_function_t){.name = source_identifier(source, "name", DESCRIPTOR_FUNCTION_NAME_MAX),
                                .id   = (uint16_t)source_unsigned(source, "id", 1U, 65535U, 0U),
                                .first_argument = descriptor->field_count,
                                .states         = states_of(source),
                                .line           = source->line};
    builder->function_configurations[descriptor->function_count] =
        source_has(source, "configurations") ? source_text(source, "configurations", UINT32_MAX) : "*";
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        if (strcmp(descriptor->functions[i].name, function->name) == 0) {
            subsystem_builder_taken(source, "name", function->name, descriptor->functions[i].line);
        } else if (descriptor->functions[i].id == function->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"), descriptor->functions[i].line);
        }
    }
    descriptor->function_count++;
}

static void start_argument(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    descriptor_function_t* const function    = &descriptor->functions[descriptor->function_count - 1U];
    descriptor_field_t* const field          = subsystem_builder_field(source, function->argument_count);
    if (field == NULL) {
        return;
    }
    field->id = (uint16_t)source_unsigned(source, "id", 0U, 65535U, 0U);
    function->argument_count++;
    subsystem_builder_check_field_name(source, function->first_argument);
    for (uint16_t i = function->first_argument; (i + 1U) < descriptor->field_count; i++) {
        if (descriptor->fields[i].id == field->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"), descriptor->fields[i].line);
        }
    }
}

static void end_function(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    descriptor_function_t* const function    = &descriptor->functions[descriptor->function_count - 1U];
    if (function->argument_count > 0U) {
        function->memory_size =
            subsystem_builder_lay_out(descriptor, function->first_argument, function->argument_count);
    }
    if ((subsystem_builder_octets(descriptor, function->first_argument, function->argument_count) +
         (2U * function->argument_count)) > AUXILIARY_OCTETS_MAX) {
        (void)source_fail(source, function->line, STATUS_INVALID, "more than 1024 octets of arguments");
    }
}

static void end_subsystem(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = subsystem_builder_of(source)->descriptor;
    for (uint32_t i = 0U; i < DESCRIPTOR_STATES; i++) {
        descriptor->timeout_us[i] =
            (descriptor->timeout_us[i] == 0U) ? TIMEOUT_US : descriptor->timeout_us[i];
    }
    configuration_builder_resolve(source);
    descriptor->configuration_hash = source->hash;
}

#define FIELD_ATTRIBUTES "name! id type! count unit init min max"

static const source_row_t rows[] = {
    {SOURCE_ROOT, "Subsystem", KIND_SUBSYSTEM, "name! id! samplingTime", start_subsystem, end_subsystem},
    {KIND_SUBSYSTEM, "Resources", KIND_RESOURCES, "poolWarning poolClear", start_resources, NULL},
    {KIND_SUBSYSTEM, "States", KIND_STATES, "", start_states, NULL},
    {KIND_STATES, "State", KIND_STATE, "name! timeout!", start_state, NULL},
    {KIND_SUBSYSTEM, "Parameters", KIND_PARAMETERS, "", parameter_builder_start, NULL},
    {KIND_PARAMETERS, "StructRef", KIND_STRUCT, "name! id! type! settable", parameter_builder_struct,
     parameter_builder_struct_end},
    {KIND_STRUCT, "ParamRef", KIND_MEMBER, FIELD_ATTRIBUTES, parameter_builder_member, NULL},
    {KIND_STRUCT, "StructRef", KIND_GROUP, "name! id type!", parameter_builder_group,
     parameter_builder_group_end},
    {KIND_GROUP, "ParamRef", KIND_MEMBER, FIELD_ATTRIBUTES, parameter_builder_member, NULL},
    {KIND_GROUP, "StructRef", KIND_GROUP, "name! id type!", parameter_builder_group,
     parameter_builder_group_end},
    {KIND_PARAMETERS, "ParamRef", KIND_PARAMETER, "name! id! type! count unit init min max settable",
     parameter_builder_scalars, NULL},
    {KIND_SUBSYSTEM, "Events", KIND_EVENTS, "", start_events, NULL},
    {KIND_EVENTS, "Event", KIND_EVENT, "name! id! severity!", start_event, end_event},
    {KIND_EVENT, "ParamRef", KIND_EVENT_VALUE, "name! type count unit", start_event_value, NULL},
    {KIND_SUBSYSTEM, "Functions", KIND_FUNCTIONS, "", start_functions, NULL},
    {KIND_FUNCTIONS, "Function", KIND_FUNCTION, "name! id! states! configurations", start_function,
     end_function},
    {KIND_FUNCTION, "Argument", KIND_ARGUMENT, "name! id! type! count unit min max", start_argument, NULL},
    {KIND_SUBSYSTEM, "Configuration", KIND_CONFIGURATION, "name! id! priority! samplingTime!",
     configuration_builder_start, NULL},
    {KIND_CONFIGURATION, "Initial", KIND_INITIAL, "parameter! field value!", configuration_builder_initial,
     NULL},
    {KIND_CONFIGURATION, "Loop", KIND_LOOP, "name! samplingTime! priority!", configuration_builder_loop,
     NULL},
    {KIND_CONFIGURATION, "HKService", KIND_STRUCTURE, "id! interval! enabled loop",
     configuration_builder_structure, configuration_builder_structure_end},
    {KIND_STRUCTURE, "SampledOnce", KIND_ONCE, "", configuration_builder_once, NULL},
    {KIND_ONCE, "ParamRef", KIND_ONCE_REFERENCE, "name!", configuration_builder_once_reference, NULL},
    {KIND_STRUCTURE, "SampledNREPTimes", KIND_SAMPLED, "nrep!", configuration_builder_sampled, NULL},
    {KIND_SAMPLED, "ParamRef", KIND_SAMPLED_REFERENCE, "name!", configuration_builder_sampled_reference,
     NULL},
    {KIND_CONFIGURATION, "RTLinkService", KIND_LINKS, "", configuration_builder_links, NULL},
    {KIND_LINKS, "Provides", KIND_PROVIDES, "name! id! methods!", configuration_builder_provides,
     configuration_builder_port_end},
    {KIND_LINKS, "Requires", KIND_REQUIRES, "name! id! methods! required staleAfter severity",
     configuration_builder_requires, configuration_builder_port_end},
    {KIND_PROVIDES, "ParamRef", KIND_ELEMENT, "name! type! count unit", configuration_builder_element, NULL},
    {KIND_REQUIRES, "ParamRef", KIND_ELEMENT, "name! type! count unit", configuration_builder_element, NULL},
    {KIND_CONFIGURATION, "Devices", KIND_DEVICES, "", configuration_builder_devices, NULL},
    {KIND_DEVICES, "Device", KIND_DEVICE, "name! type!", configuration_builder_device, NULL},
    {KIND_DEVICE, "Setting", KIND_SETTING, "object! type! value!", configuration_builder_setting, NULL},
    {KIND_DEVICE, "Endnode", KIND_ENDNODE, "type! bus node name address port framing order direction baud",
     endnode_builder_start, NULL},
};

void subsystem_builder_begin(subsystem_builder_t* const builder, subsystem_descriptor_t* const descriptor,
                             const char* const path, text_t* const error)
{
    FSW_ASSERT((builder != NULL) && (descriptor != NULL) && (path != NULL) && (error != NULL));
    (void)memset(descriptor, 0, sizeof *descriptor);
    descriptor->name               = "";
    descriptor->pool_warn_percent  = WARN_PERCENT;
    descriptor->pool_clear_percent = CLEAR_PERCENT;
    *builder                       = (subsystem_builder_t){.descriptor = descriptor};
    builder->source                = (source_t){.path          = path,
                                                .error         = error,
                                                .status        = STATUS_OK,
                                                .rows          = rows,
                                                .row_count     = sizeof rows / sizeof rows[0],
                                                .hash          = FNV64_START,
                                                .text          = descriptor->text,
                                                .text_capacity = DESCRIPTOR_TEXT_OCTETS,
                                                .text_used     = &descriptor->text_used,
                                                .builder       = builder};
}
