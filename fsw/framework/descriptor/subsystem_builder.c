// SPDX-License-Identifier: Apache-2.0
// Parts of a subsystem descriptor outside of its configurations.
#include "fsw/framework/descriptor/subsystem_builder.h"

#include "base/capacities.h"
#include "base/number.h"

#include <float.h>
#include <string.h>

#define ARGUMENT_OCTETS_MAX 1024U
#define NUMBERS_CHARACTERS 512U // Largest text of numbers that replaces a list of names [characters].
#define RATE_DIGITS_MAX 4U
#define RATE_MAX 1000U   // Maximum rate of an event [1/s].
#define RATE_DEFAULT 10U // [1/s]

void descriptor_subsystem_builder_resources(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = source->item;
    if (descriptor->pool_clear_percent >= descriptor->pool_warn_percent) {
        descriptor_source_fail(source, source->line, "expected poolClear < poolWarning");
    }
}

void descriptor_subsystem_builder_state(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = source->item;
    uint8_t state                            = 0U;
    if (descriptor_state_of(descriptor_source_raw(source, "name"), &state) != STATUS_OK) {
        descriptor_source_wrong(source, "name", "the name of a state");
    } else if (descriptor->timeout_us[state] != 0U) {
        descriptor_source_fail(source, source->line, "this state has a time-out already");
    } else {
        descriptor->timeout_us[state] = descriptor_source_value(source, 1U);
    }
}

// ---- Fields ----

static void read_bound(source_t* const source, const char* const attribute, const value_type_t type,
                       const double otherwise, double* const out_bound)
{
    *out_bound = otherwise;
    if (descriptor_source_has(source, attribute)) {
        (void)descriptor_source_number(source, attribute, type, out_bound);
    }
}

/// Convert the names in `names` to their numbers in the enumeration, as text.
static const char* numbers_of(source_t* const source, const char* const attribute,
                              const descriptor_field_t* const field, const char* const names)
{
    char characters[NUMBERS_CHARACTERS];
    text_t text     = text_in(characters, sizeof characters);
    const char* at  = names;
    char end        = '\0'; // The character after the last name.
    uint32_t index  = 0U;
    uint16_t number = 0U;
    do {
        const size_t length = strcspn(at, " ");
        end                 = at[length];
        index               = descriptor_source_index(at, length, field->enumeration->values);
        text_add_unsigned(&text, (uint64_t)field->enumeration->first + index);
        text_add_character(&text, end);
        at += length + 1U;
        number++;
    } while ((index != UINT32_MAX) && (end != '\0') && (number < field->count));
    if ((index == UINT32_MAX) || (end != '\0') || (number < field->count)) {
        descriptor_source_wrong(source, attribute, "");
        descriptor_source_append(source, "# of: %", field->enumeration->values, NULL, field->count);
    }
    return descriptor_source_keep(source, characters);
}

const char* descriptor_subsystem_builder_values(source_t* const source, const char* const attribute,
                                                const descriptor_field_t* const field)
{
    const char* const values = descriptor_source_raw(source, attribute);
    if (field->enumeration != NULL) {
        return numbers_of(source, attribute, field, values);
    }
    const char* at = values;
    bool is_right  = descriptor_source_is_spaced(at);
    bool is_within = true;
    for (uint16_t i = 0U; is_right && (i < field->count); i++) {
        uint64_t scalar    = 0U;
        is_right           = (number_read_value(&at, field->type, &scalar) == STATUS_OK);
        const double value = is_right ? value_as_double(field->type, &scalar) : field->min;
        is_within          = is_within && (value >= field->min) && (value <= field->max);
    }
    if (!is_right || !number_is_end(at)) {
        descriptor_source_wrong(source, attribute, "");
        descriptor_source_append(source, "# number(s) of type %, one space between",
                                 value_type_name(field->type), NULL, field->count);
    } else if (!is_within) {
        descriptor_source_wrong(source, attribute, "numbers within min and max");
    } else {
        // The numbers are valid.
    }
    return descriptor_source_keep(source, values);
}

/// Find the enumeration of a field and use its first and last number as bounds. False if it is missing, if
/// the field has bounds too, or if a number does not fit the type.
static bool enumerate(source_t* const source, descriptor_field_t* const field)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    field->enumeration =
        descriptor_named(descriptor->enumerations, descriptor->enumeration_count,
                         sizeof descriptor->enumerations[0], descriptor_source_raw(source, "enumeration"));
    if ((field->enumeration == NULL) || (field->type > VALUE_INT64) || (field->min > -DBL_MAX) ||
        (field->max < DBL_MAX)) {
        return false;
    }
    uint64_t last = field->enumeration->first;
    for (const char* at = field->enumeration->values; *at != '\0'; at++) {
        last += (*at == ' ') ? 1U : 0U;
    }
    field->min = field->enumeration->first;
    field->max = (double)last;
    // Two shifts, because a shift by all 64 bits is undefined in C.
    const size_t bits = (8U * value_size(field->type)) - ((field->type >= VALUE_INT8) ? 1U : 0U);
    return ((last >> (bits - 1U)) >> 1U) == 0U;
}

void descriptor_subsystem_builder_complete(source_t* const source, descriptor_field_t* const field)
{
    read_bound(source, "min", field->type, -DBL_MAX, &field->min);
    read_bound(source, "max", field->type, DBL_MAX, &field->max);
    if (field->min > field->max) {
        descriptor_source_wrong(source, "min", "at most max");
    }
    if (descriptor_source_has(source, "enumeration") && !enumerate(source, field)) {
        descriptor_source_wrong(
            source, "enumeration",
            "an <Enumeration> defined above whose numbers fit the type, and neither min nor max");
    }
    if (descriptor_source_has(source, "init")) {
        field->init = descriptor_subsystem_builder_values(source, "init", field);
    }
}

void descriptor_subsystem_builder_field(source_t* const source)
{
    descriptor_field_t* const field = source->item;
    field->id                       = source->order;
    descriptor_subsystem_builder_complete(source, field);
}

uint32_t descriptor_subsystem_builder_octets(const subsystem_descriptor_t* const descriptor,
                                             const uint16_t first, const uint16_t count)
{
    uint32_t octets = 0U;
    for (uint16_t i = first; i < (first + count); i++) {
        octets += (uint32_t)(value_size(descriptor->fields[i].type) * descriptor->fields[i].count);
    }
    return octets;
}

// ---- References to parameters ----

const descriptor_parameter_t* descriptor_subsystem_builder_parameter(source_t* const source,
                                                                     const char* const attribute)
{
    const descriptor_parameter_t* const parameter = descriptor_find_parameter(
        descriptor_subsystem_builder_model(source), descriptor_source_raw(source, attribute));
    if (parameter == NULL) {
        descriptor_source_wrong(source, attribute, "the name of a parameter of this subsystem");
    }
    return parameter;
}

void descriptor_subsystem_builder_refer(source_t* const source, const source_list_t* const list)
{
    subsystem_descriptor_t* const descriptor      = descriptor_subsystem_builder_model(source);
    const descriptor_parameter_t* const parameter = descriptor_subsystem_builder_parameter(source, "name");
    uint16_t* const reference =
        (parameter != NULL) ? descriptor_source_add(source, list, source->item) : NULL;
    if (reference == NULL) {
        return;
    }
    *reference            = (uint16_t)(parameter - descriptor->parameters);
    const uint16_t* other = &descriptor->references[descriptor_subsystem_builder_of(source)->first_reference];
    for (; other < reference; other++) {
        if (*other == *reference) {
            descriptor_source_wrong(source, "name", "each parameter once in a report");
        }
    }
}

uint32_t descriptor_subsystem_builder_referred(const subsystem_descriptor_t* const descriptor,
                                               const uint16_t first, const uint16_t count)
{
    uint32_t octets = 0U;
    for (uint16_t i = first; i < (first + count); i++) {
        octets += descriptor->parameters[descriptor->references[i]].wire_size;
    }
    return octets;
}

// ---- Events ----

/// Read "<number>/s". Returns the number, or 0 if it is not from 1 to 1000.
static uint16_t rate_of(const char* const words)
{
    uint16_t rate = 0U;
    size_t at     = 0U;
    while ((words[at] >= '0') && (words[at] <= '9') && (at < RATE_DIGITS_MAX)) {
        rate = (uint16_t)((rate * 10U) + (uint16_t)(words[at] - '0'));
        at++;
    }
    return ((words[0] != '0') && (rate <= RATE_MAX) && (strcmp(&words[at], "/s") == 0)) ? rate : 0U;
}

void descriptor_subsystem_builder_event(source_t* const source)
{
    descriptor_event_t* const event = source->item;
    const char* const rate          = descriptor_source_raw(source, "rate");
    const bool is_high              = (event->severity == DESCRIPTOR_HIGH);
    descriptor_subsystem_builder_of(source)->first_reference =
        descriptor_subsystem_builder_model(source)->reference_count;
    event->per_second = is_high ? 0U : RATE_DEFAULT;
    if (is_high && ((rate != NULL) || descriptor_source_has(source, "burst"))) {
        descriptor_source_fail(source, source->line, "an <Event> of severity HIGH cannot have rate or burst");
    } else if (rate != NULL) {
        event->per_second = rate_of(rate);
        if (event->per_second == 0U) {
            descriptor_source_wrong(source, "rate", "a rate like 10/s, from 1/s to 1000/s");
        }
    } else {
        // Without the attribute, the default of the severity applies.
    }
}

/// Returns the octets of one report of each HIGH event read so far; the queue of reports reserves this room.
static uint32_t high_octets(const subsystem_descriptor_t* const descriptor)
{
    uint32_t octets = 0U;
    for (uint16_t i = 0U; i < descriptor->event_count; i++) {
        if (descriptor->events[i].severity == DESCRIPTOR_HIGH) {
            octets += CAPACITY_HIGH_EVENT_HEAD + descriptor->events[i].octets;
        }
    }
    return octets;
}

void descriptor_subsystem_builder_event_value(source_t* const source)
{
    const descriptor_event_t* const event = source->item;
    const bool has_type                   = descriptor_source_has(source, "type");
    if ((has_type ? event->reference_count : event->field_count) > 0U) {
        descriptor_source_fail(source, source->line,
                               "either all <ParamRef> of an <Event> have a type, or none has");
    } else if (has_type) {
        source->item =
            descriptor_source_item(source, &descriptor_subsystem_event_fields, source->item,
                                   descriptor_subsystem_field_attributes, SUBSYSTEM_FIELD_ATTRIBUTES);
        if (source->item != NULL) {
            descriptor_subsystem_builder_field(source);
        }
    } else if (descriptor_source_has(source, "count") || descriptor_source_has(source, "unit") ||
               descriptor_source_has(source, "enumeration")) {
        descriptor_source_fail(source, source->line,
                               "<ParamRef> without type cannot have count, unit or enumeration");
    } else {
        descriptor_subsystem_builder_refer(source, &descriptor_subsystem_event_references);
    }
}

void descriptor_subsystem_builder_event_end(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    descriptor_event_t* const event                = source->item;
    event->octets =
        descriptor_subsystem_builder_octets(descriptor, event->first_field, event->field_count) +
        descriptor_subsystem_builder_referred(descriptor, event->first_reference, event->reference_count);
    descriptor_source_limit(source, event->octets, DESCRIPTOR_AUXILIARY_MAX, " octets of auxiliary data");
    descriptor_source_limit(source, high_octets(descriptor), CAPACITY_HIGH_EVENTS,
                            " octets of reports of HIGH events");
}

// ---- Functions ----

void descriptor_subsystem_builder_function(source_t* const source)
{
    descriptor_function_t* const function = source->item;
    function->states =
        (uint16_t)(descriptor_source_states(source, "states") & ((1U << DESCRIPTOR_STATES) - 1U));
    descriptor_subsystem_builder_of(source)->function_configurations[source->order] =
        descriptor_source_has(source, "configurations")
            ? descriptor_source_text(source, "configurations", SOURCE_TEXT, UINT32_MAX)
            : "*";
}

void descriptor_subsystem_builder_argument(source_t* const source)
{
    descriptor_subsystem_builder_complete(source, source->item);
}

void descriptor_subsystem_builder_function_end(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    descriptor_function_t* const function    = source->item;
    const uint16_t count                     = function->argument_count;
    if (count > 0U) {
        function->memory_size =
            descriptor_subsystem_builder_lay_out(descriptor, function->first_argument, count);
    }
    descriptor_source_limit(source,
                            descriptor_subsystem_builder_octets(descriptor, function->first_argument, count) +
                                (2U * count),
                            ARGUMENT_OCTETS_MAX, " octets of arguments");
}

// ---- Services ----

typedef struct { // Capacities of a service; gse/generator/services.py has the same values.
    uint8_t type;
    uint16_t capacity_max;
    uint16_t capacity; // Default.
    uint16_t functional_max;
    uint16_t functional;
    // True: the supervisor always offers the service, in its own storage, even if the descriptor does not
    // list it.
    bool is_of_spacecraft;
} offer_t;

#define OFFERED "2 4 6 12 11 15 18 19 21 22 23"
#define OF_SPACECRAFT(type, most)                                                                            \
    {                                                                                                        \
        (type), (most), (most), 0U, 0U, true                                                                 \
    }

/// Read a capacity from 1 to `most`; returns `otherwise` if the attribute is absent.
static uint16_t capacity_of(source_t* const source, const char* const attribute, const uint16_t most,
                            const uint16_t otherwise)
{
    const source_attribute_t form = {.name      = attribute,
                                     .form      = SOURCE_UNSIGNED,
                                     .low       = 1U,
                                     .high      = most,
                                     .otherwise = otherwise,
                                     .width     = sizeof(uint16_t)};
    uint16_t capacity             = 0U;
    if ((most == 0U) && descriptor_source_has(source, attribute)) {
        descriptor_source_refuse(source, source->line, "service % cannot have attribute %",
                                 descriptor_source_raw(source, "type"), attribute, 0U);
    } else if (most > 0U) {
        descriptor_source_read(source, &capacity, &form, 1U);
    } else {
        // The attribute is absent, as required.
    }
    return capacity;
}

void descriptor_subsystem_builder_service(source_t* const source)
{
    static const offer_t offers[]       = {{2U, 16U, 4U, 0U, 0U, false}, // In the order of OFFERED.
                                           {4U, 256U, 16U, 0U, 0U, false},
                                           {6U, 16U, 4U, 0U, 0U, false},
                                           {12U, 2000U, 32U, 200U, 4U, false},
                                           OF_SPACECRAFT(11U, DESCRIPTOR_TIME_ACTIVITIES_MAX),
                                           OF_SPACECRAFT(15U, DESCRIPTOR_PACKET_STORES_MAX),
                                           OF_SPACECRAFT(18U, DESCRIPTOR_PROCEDURES_MAX),
                                           OF_SPACECRAFT(19U, DESCRIPTOR_EVENT_ACTIONS_MAX),
                                           OF_SPACECRAFT(21U, DESCRIPTOR_SEQUENCES_MAX),
                                           OF_SPACECRAFT(22U, DESCRIPTOR_POSITION_ACTIVITIES_MAX),
                                           OF_SPACECRAFT(23U, DESCRIPTOR_FILE_LOCKS_MAX)};
    descriptor_service_t* const service = source->item;
    const uint32_t index                = descriptor_source_word(source, "type", OFFERED);
    if (source->status != STATUS_OK) {
        return;
    }
    const offer_t* const offer = &offers[index];
    if (offer->is_of_spacecraft && (descriptor_subsystem_builder_model(source)->apid != SUPERVISOR_APID)) {
        descriptor_source_refuse(source, source->line, "only the supervisor (id 1) can have service %",
                                 descriptor_source_raw(source, "type"), "", 0U);
        return;
    }
    service->type             = offer->type;
    service->is_of_spacecraft = offer->is_of_spacecraft;
    service->capacity         = capacity_of(source, "capacity", offer->capacity_max, offer->capacity);
    service->functional       = capacity_of(source, "functional", offer->functional_max, offer->functional);
    for (const descriptor_service_t* other = service - source->order; other < service; other++) {
        if (other->type == service->type) {
            descriptor_source_taken(source, "type", descriptor_source_raw(source, "type"), other->line);
        }
    }
}

void descriptor_subsystem_builder_end(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = source->item;
    for (uint32_t i = 0U; i < DESCRIPTOR_STATES; i++) {
        if (descriptor->timeout_us[i] == 0U) {
            descriptor->timeout_us[i] = SUBSYSTEM_TIMEOUT_US;
        }
    }
    descriptor_configuration_builder_resolve(source);
    descriptor->configuration_hash = source->hash;
}
