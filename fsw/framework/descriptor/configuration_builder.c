// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "base/number.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

#include <string.h>

// Largest size of the values of one housekeeping report [octets].
#define REPORT_OCTETS_MAX 4000U
/// Age from which a sample is stale, if the descriptor does not define it [sampling times].
#define STALE_PERIODS 4U

/// Returns the configuration that contains the element being read.
static const descriptor_configuration_t* configuration_of(const source_t* const source)
{
    return source->items[source->depth - 1U];
}

// ---- Initial values ----

/// Returns the field that an <Initial> names; NULL after an error.
static const descriptor_field_t* initial_field(source_t* const source,
                                               const descriptor_parameter_t* const parameter)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    if (parameter->is_struct != descriptor_source_has(source, "field")) {
        descriptor_source_fail(source, source->line,
                               parameter->is_struct ? "the parameter is a structure: name its field"
                                                    : "the parameter is no structure and has no field");
        return NULL;
    }
    const char* const wanted =
        parameter->is_struct ? descriptor_source_raw(source, "field") : parameter->name;
    const descriptor_field_t* const field =
        descriptor_named(&descriptor->fields[parameter->first_field], parameter->field_count,
                         sizeof descriptor->fields[0], wanted);
    if (field == NULL) {
        descriptor_source_wrong(source, "field", "the name of a field of that parameter");
    }
    return field;
}

void descriptor_configuration_builder_initial(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    descriptor_initial_t* const initial            = source->item;
    const descriptor_parameter_t* const parameter =
        descriptor_subsystem_builder_parameter(source, "parameter");
    const descriptor_field_t* const field = (parameter != NULL) ? initial_field(source, parameter) : NULL;
    if (field == NULL) {
        return;
    }
    initial->text                     = descriptor_subsystem_builder_values(source, "value", field);
    initial->parameter                = (uint16_t)(parameter - descriptor->parameters);
    initial->field                    = (uint16_t)(field - descriptor->fields);
    const descriptor_initial_t* other = initial - source->order;
    for (; other < initial; other++) {
        if (other->field == initial->field) {
            descriptor_source_taken(source, "field", field->name, other->line);
        }
    }
}

// ---- Loops and housekeeping ----

/// Report a service that must stay in the main loop, and why.
static void refuse_bound_services(source_t* const source, const char* const services)
{
    static const char* const bound[][2] = {
        {"1", "the loop that performs a request verifies it"},
        {"3", "each <HKService> names its loop"},
        {"5", "an event is reported in the cycle that raises it"},
        {"8", "functions act on devices"},
        {"129", "the state machine starts and stops the control"},
        {"130", "links are opened, read and written in the cycle of the control"}};
    for (size_t i = 0U; i < SOURCE_COUNT(bound); i++) {
        if (descriptor_source_index(bound[i][0], strlen(bound[i][0]), services) != UINT32_MAX) {
            descriptor_source_refuse(source, source->line, "service % cannot have a <Loop> of its own: %",
                                     bound[i][0], bound[i][1], 0U);
        }
    }
}

/// Read the services that a <Loop> runs. Each service runs in at most one loop of its configuration.
void descriptor_configuration_builder_loop(source_t* const source)
{
    descriptor_loop_t* const loop = source->item;
    const char* const services    = descriptor_source_raw(source, "services");
    uint8_t indices[2]            = {0U, 0U};
    (void)descriptor_source_has_room(source, source->order, DESCRIPTOR_CONFIGURATION_LOOPS_MAX,
                                     "<Loop> in one configuration");
    if (services == NULL) {
        return;
    }
    refuse_bound_services(source, services);
    // The words are in the order of the bits of `services`.
    const uint32_t count = descriptor_source_words(source, "services", "17 20", indices);
    for (uint32_t i = 0U; i < count; i++) {
        loop->services = (uint8_t)(loop->services | (1U << indices[i]));
    }
    for (const descriptor_loop_t* other = loop - source->order; other < loop; other++) {
        if ((other->services & loop->services) != 0U) {
            descriptor_source_taken(source, "services", services, other->line);
        }
    }
}

/// Returns the number, within the configuration, of the loop that an element names; 0 is the main loop.
static uint8_t loop_of(source_t* const source)
{
    const descriptor_configuration_t* const configuration = configuration_of(source);
    const descriptor_loop_t* const loops =
        &descriptor_subsystem_builder_model(source)->loops[configuration->first_loop];
    const char* const wanted = descriptor_source_raw(source, "loop");
    if (wanted == NULL) {
        return 0U;
    }
    const descriptor_loop_t* const loop =
        descriptor_named(loops, configuration->loop_count, sizeof loops[0], wanted);
    if (loop == NULL) {
        descriptor_source_wrong(source, "loop", "the name of a <Loop> above in this configuration");
        return 0U;
    }
    return (uint8_t)((loop - loops) + 1);
}

void descriptor_configuration_builder_structure(source_t* const source)
{
    descriptor_structure_t* const structure = source->item;
    structure->loop                         = loop_of(source);
    descriptor_subsystem_builder_of(source)->first_reference =
        descriptor_subsystem_builder_model(source)->reference_count;
}

void descriptor_configuration_builder_once_reference(source_t* const source)
{
    descriptor_subsystem_builder_refer(source, &descriptor_subsystem_structure_references);
}

void descriptor_configuration_builder_sampled(source_t* const source)
{
    const descriptor_structure_t* const structure = source->items[source->depth - 1U];
    const descriptor_sampled_t* const sampled     = source->item;
    if ((structure->interval_cycles % sampled->nrep) != 0U) {
        descriptor_source_wrong(source, "nrep", "a divisor of the interval ");
        descriptor_source_append(source, "#", NULL, NULL, structure->interval_cycles);
    }
}

void descriptor_configuration_builder_sampled_reference(source_t* const source)
{
    descriptor_subsystem_builder_refer(source, &descriptor_subsystem_sampled_references);
}

void descriptor_configuration_builder_structure_end(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    descriptor_structure_t* const structure        = source->item;
    const descriptor_sampled_t* const sampled      = &descriptor->sampled[structure->first_sampled];
    structure->octets = descriptor_subsystem_builder_referred(descriptor, structure->first_reference,
                                                              structure->reference_count);
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        structure->octets +=
            sampled[i].nrep * descriptor_subsystem_builder_referred(descriptor, sampled[i].first_reference,
                                                                    sampled[i].reference_count);
    }
    if (structure->octets == 0U) {
        descriptor_source_fail(source, source->line, "<HKService> has no <ParamRef>");
    }
    descriptor_source_limit(source, structure->octets, REPORT_OCTETS_MAX, " octets in one report");
}

// ---- Ports ----

static void read_port(source_t* const source, descriptor_port_t* const port)
{
    port->period_us = configuration_of(source)->sampling_us;
    port->method_count =
        (uint8_t)descriptor_source_words(source, "methods", DESCRIPTOR_METHOD_WORDS, port->methods);
}

void descriptor_configuration_builder_provides(source_t* const source)
{
    descriptor_port_t* const port = source->item;
    read_port(source, port);
    port->is_provided = true;
}

void descriptor_configuration_builder_requires(source_t* const source)
{
    descriptor_port_t* const port = source->item;
    read_port(source, port);
    if (port->stale_us == 0U) {
        port->stale_us = STALE_PERIODS * port->period_us;
    }
}

/// Returns the CRC-32 of the lines "name:type:count" of a layout.
static uint32_t layout_hash(const subsystem_descriptor_t* const descriptor,
                            const descriptor_port_t* const port, bool* const out_is_cut)
{
    char lines[2048];
    text_t text = text_in(lines, sizeof lines);
    for (uint16_t i = 0U; i < port->field_count; i++) {
        const descriptor_field_t* const field = &descriptor->fields[port->first_field + i];
        text_add_pattern(&text, "%:%:#\n", field->name, value_type_name(field->type), field->count);
    }
    *out_is_cut = text.cut;
    return crc32_iso((const uint8_t*)lines, text.length);
}

void descriptor_configuration_builder_port_end(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    descriptor_port_t* const port            = source->item;
    bool is_cut                              = false;
    port->octets = descriptor_subsystem_builder_octets(descriptor, port->first_field, port->field_count);
    port->memory_size =
        descriptor_subsystem_builder_lay_out(descriptor, port->first_field, port->field_count);
    port->layout_hash = layout_hash(descriptor, port, &is_cut);
    descriptor_source_limit(source, port->octets, DESCRIPTOR_PORT_OCTETS_MAX, " octets in one sample");
    if (is_cut) {
        descriptor_source_fail(source, source->line,
                               "the names of the port's elements are too long together");
    }
}

// ---- Devices ----

/// Read index and subindex of an object like 0x6060:00. Returns false if the text does not have this form.
static bool read_object(const char* const words, uint16_t* const out_index, uint8_t* const out_subindex)
{
    char number[9]; // Index and subindex as one number with its NUL: 0x606000.
    const char* at  = number;
    uint64_t object = 0U;
    if ((strlen(words) != 9U) || (strncmp(words, "0x", 2U) != 0) || (words[6] != ':')) {
        return false;
    }
    (void)memcpy(number, words, 6U);
    (void)memcpy(&number[6], &words[7], 3U);
    const bool is_right = (strchr(number, ' ') == NULL) && (number_read_unsigned(&at, &object) == STATUS_OK);
    *out_index          = (uint16_t)(object >> 8U);
    *out_subindex       = (uint8_t)object;
    return is_right;
}

static void take_object(source_t* const source, const value_type_t type, uint16_t* const out_index,
                        uint8_t* const out_subindex)
{
    if (!read_object(descriptor_source_raw(source, "object"), out_index, out_subindex)) {
        descriptor_source_wrong(source, "object", "an object like 0x6060:00");
    }
    if (type == VALUE_BOOL) {
        descriptor_source_wrong(source, "type", "a type other than BOOL");
    }
}

void descriptor_configuration_builder_setting(source_t* const source)
{
    descriptor_setting_t* const setting = source->item;
    double real                         = 0.0;
    take_object(source, setting->type, &setting->index, &setting->subindex);
    setting->bits = descriptor_source_number(source, "value", setting->type, &real);
}

void descriptor_configuration_builder_quantity(source_t* const source)
{
    descriptor_quantity_t* const quantity = source->item;
    take_object(source, quantity->type, &quantity->index, &quantity->subindex);
    (void)descriptor_source_number(source, "scale", VALUE_DOUBLE, &quantity->scale);
    if (quantity->scale == 0.0) {
        descriptor_source_wrong(source, "scale", "a number other than 0");
    }
}

void descriptor_configuration_builder_supply(source_t* const source)
{
    const descriptor_supply_t* const supply = source->item;
    if (supply->on == supply->off) {
        descriptor_source_wrong(source, "off", "a line other than that of on");
    }
}

// ---- End of the document ----

/// Returns the configurations that a function names, one bit for each.
static uint16_t configurations_of(source_t* const source, const char* const chosen, const uint32_t line)
{
    uint8_t indices[DESCRIPTOR_CONFIGURATIONS_MAX];
    char words[DESCRIPTOR_CONFIGURATIONS_MAX * (DESCRIPTOR_NAME_MAX + 1U)];
    text_t text   = text_in(words, sizeof words);
    uint32_t bits = 0U;
    if (strcmp(chosen, "*") == 0) {
        return (uint16_t)((1U << descriptor_subsystem_builder_model(source)->configuration_count) - 1U);
    }
    descriptor_source_names(source, &descriptor_subsystem_configurations, &text);
    for (uint32_t i = descriptor_source_indices(chosen, words, indices); i > 0U; i--) {
        bits |= (uint32_t)1U << indices[i - 1U];
    }
    if (bits == 0U) {
        descriptor_source_fail(
            source, line,
            "configurations of <Function>: expected configurations of this subsystem, each once, or *");
    }
    return (uint16_t)bits;
}

/// Check that ports of the same name have the same id, direction and layout in all configurations, and that
/// ports of different names have different ids.
static void check_same_ports(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    for (uint16_t i = 0U; i < descriptor->port_count; i++) {
        const descriptor_port_t* const port = &descriptor->ports[i];
        for (const descriptor_port_t* other = descriptor->ports; other < port; other++) {
            const bool has_name = (strcmp(port->name, other->name) == 0);
            const bool is_same =
                (port->is_provided == other->is_provided) && (port->layout_hash == other->layout_hash);
            if ((has_name != (port->id == other->id)) || (has_name && !is_same)) {
                descriptor_source_refuse(
                    source, port->line,
                    "port % differs from port % in line #: expected one id, direction and layout for a name",
                    port->name, other->name, other->line);
            }
        }
    }
}

void descriptor_configuration_builder_resolve(source_t* const source)
{
    const char* const* const chosen = descriptor_subsystem_builder_of(source)->function_configurations;
    subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        descriptor->storage.functions[i].configurations =
            configurations_of(source, chosen[i], descriptor->functions[i].line);
    }
    check_same_ports(source);
    descriptor->interface_hash = descriptor_subsystem_interface_hash(descriptor);
}
