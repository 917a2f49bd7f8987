// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/subsystem_builder.h"

#include "fsw/framework/base/crc.h"
#include "fsw/framework/base/number.h"

#include <string.h>

#define REPORT_OCTETS_MAX 4000U
#define STALE_PERIODS 4U ///< Age of a stale sample where the descriptor gives none [sampling times].

static const char* const method_names[DESCRIPTOR_METHODS] = {"SHARED_MEMORY", "TIPC", "UDP", "STREAM",
                                                             "MESSAGE_QUEUE"};
static const char* const severity_names[]                 = {"INFORMATIVE", "LOW", "MEDIUM", "HIGH"};

static subsystem_descriptor_t* model(source_t* const source)
{
    return subsystem_builder_of(source)->descriptor;
}

static descriptor_configuration_t* newest_configuration(source_t* const source)
{
    return &model(source)->configurations[model(source)->configuration_count - 1U];
}

void configuration_builder_start(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    if (!source_has_room(source, descriptor->configuration_count, DESCRIPTOR_CONFIGURATIONS_MAX,
                         "configurations")) {
        return;
    }
    descriptor_configuration_t* const configuration =
        &descriptor->configurations[descriptor->configuration_count];
    *configuration = (descriptor_configuration_t){
        .name            = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
        .id              = (uint16_t)source_unsigned(source, "id", 1U, 65535U, 0U),
        .priority        = (uint8_t)source_unsigned(source, "priority", 1U, 99U, 0U),
        .sampling_us     = source_time_us(source, "samplingTime", 100U, 10000000U, 0U),
        .first_initial   = descriptor->initial_count,
        .first_loop      = descriptor->loop_count,
        .first_structure = descriptor->structure_count,
        .first_port      = descriptor->port_count,
        .first_device    = descriptor->device_count,
        .line            = source->line};
    for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
        if (strcmp(descriptor->configurations[i].name, configuration->name) == 0) {
            subsystem_builder_taken(source, "name", configuration->name, descriptor->configurations[i].line);
        } else if (descriptor->configurations[i].id == configuration->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"),
                                    descriptor->configurations[i].line);
        }
    }
    descriptor->configuration_count++;
    subsystem_builder_of(source)->seen &= ~(((uint32_t)1U << KIND_LINKS) | ((uint32_t)1U << KIND_DEVICES));
}

/// Index in `fields` of what an <Initial> names, or -1 after an error.
static int32_t initial_field(source_t* const source, const descriptor_parameter_t* const parameter)
{
    const subsystem_descriptor_t* const descriptor = model(source);
    if (parameter->is_struct != source_has(source, "field")) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          parameter->is_struct ? "the parameter is a structure: name its field"
                                               : "the parameter is no structure and has no field");
        return -1;
    }
    const char* const wanted = parameter->is_struct ? source_raw(source, "field") : parameter->name;
    for (uint16_t i = 0U; i < parameter->field_count; i++) {
        if (strcmp(descriptor->fields[parameter->first_field + i].name, wanted) == 0) {
            return parameter->first_field + i;
        }
    }
    source_wrong(source, "field", "the name of a field of that parameter");
    return -1;
}

void configuration_builder_initial(source_t* const source)
{
    subsystem_descriptor_t* const descriptor        = model(source);
    descriptor_configuration_t* const configuration = newest_configuration(source);
    const descriptor_parameter_t* const parameter =
        descriptor_find_parameter(descriptor, source_raw(source, "parameter"));
    if (parameter == NULL) {
        source_wrong(source, "parameter", "the name of a parameter of this subsystem");
        return;
    }
    const int32_t field = initial_field(source, parameter);
    if ((field < 0) ||
        !source_has_room(source, descriptor->initial_count, DESCRIPTOR_INITIALS_MAX, "<Initial>")) {
        return;
    }
    subsystem_builder_check_values(source, "value", &descriptor->fields[field]);
    for (uint16_t i = configuration->first_initial; i < descriptor->initial_count; i++) {
        if (descriptor->initials[i].field == field) {
            subsystem_builder_taken(source, "field", descriptor->fields[field].name,
                                    descriptor->initials[i].line);
        }
    }
    descriptor->initials[descriptor->initial_count] =
        (descriptor_initial_t){.parameter = (uint16_t)(parameter - descriptor->parameters),
                               .field     = (uint16_t)field,
                               .text      = source_text(source, "value", UINT32_MAX),
                               .line      = source->line};
    descriptor->initial_count++;
    configuration->initial_count++;
}

void configuration_builder_loop(source_t* const source)
{
    subsystem_descriptor_t* const descriptor        = model(source);
    descriptor_configuration_t* const configuration = newest_configuration(source);
    if (!source_has_room(source, configuration->loop_count, DESCRIPTOR_CONFIGURATION_LOOPS_MAX,
                         "<Loop> in one configuration") ||
        !source_has_room(source, descriptor->loop_count, DESCRIPTOR_LOOPS_MAX, "<Loop>")) {
        return;
    }
    descriptor_loop_t* const loop = &descriptor->loops[descriptor->loop_count];
    *loop = (descriptor_loop_t){.name        = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                .sampling_us = source_time_us(source, "samplingTime", 100U, 10000000U, 0U),
                                .priority    = (uint8_t)source_unsigned(source, "priority", 1U, 99U, 0U),
                                .line        = source->line};
    for (uint16_t i = configuration->first_loop; i < descriptor->loop_count; i++) {
        if (strcmp(descriptor->loops[i].name, loop->name) == 0) {
            subsystem_builder_taken(source, "name", loop->name, descriptor->loops[i].line);
        }
    }
    descriptor->loop_count++;
    configuration->loop_count++;
}

/// Number within the configuration of the loop that an element names; 0 is the configuration's own.
static uint8_t loop_of(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor        = model(source);
    const descriptor_configuration_t* const configuration = newest_configuration(source);
    const char* const wanted                              = source_raw(source, "loop");
    if (wanted == NULL) {
        return 0U;
    }
    for (uint16_t i = 0U; i < configuration->loop_count; i++) {
        if (strcmp(descriptor->loops[configuration->first_loop + i].name, wanted) == 0) {
            return (uint8_t)(i + 1U);
        }
    }
    source_wrong(source, "loop", "the name of a <Loop> above in this configuration");
    return 0U;
}

static descriptor_structure_t* newest_structure(source_t* const source)
{
    return &model(source)->structures[model(source)->structure_count - 1U];
}

void configuration_builder_structure(source_t* const source)
{
    subsystem_descriptor_t* const descriptor        = model(source);
    descriptor_configuration_t* const configuration = newest_configuration(source);
    if (!source_has_room(source, descriptor->structure_count, DESCRIPTOR_STRUCTURES_MAX, "<HKService>")) {
        return;
    }
    descriptor_structure_t* const structure = &descriptor->structures[descriptor->structure_count];
    *structure =
        (descriptor_structure_t){.id              = (uint16_t)source_unsigned(source, "id", 1U, 65535U, 0U),
                                 .loop            = loop_of(source),
                                 .interval_cycles = source_unsigned(source, "interval", 1U, UINT32_MAX, 1U),
                                 .is_enabled      = source_flag(source, "enabled", true),
                                 .first_reference = descriptor->reference_count,
                                 .first_sampled   = descriptor->sampled_count,
                                 .line            = source->line};
    for (uint16_t i = configuration->first_structure; i < descriptor->structure_count; i++) {
        if (descriptor->structures[i].id == structure->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"), descriptor->structures[i].line);
        }
    }
    descriptor->structure_count++;
    configuration->structure_count++;
    subsystem_builder_of(source)->first_reference = descriptor->reference_count;
    subsystem_builder_of(source)->seen &= ~((uint32_t)1U << KIND_ONCE);
}

/// Refer to a parameter that this structure does not hold yet.
static void refer_in_structure(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = model(source);
    const uint16_t before                          = descriptor->reference_count;
    const uint16_t first                           = subsystem_builder_of(source)->first_reference;
    subsystem_builder_refer(source);
    for (uint16_t i = first; (source->status == STATUS_OK) && (i < before); i++) {
        if (descriptor->references[i] == descriptor->references[before]) {
            source_wrong(source, "name", "each parameter once in a report");
        }
    }
}

void configuration_builder_once(source_t* const source)
{
    subsystem_builder_once(source, KIND_ONCE);
    newest_structure(source)->first_reference = model(source)->reference_count;
}

void configuration_builder_once_reference(source_t* const source)
{
    refer_in_structure(source);
    newest_structure(source)->reference_count++;
}

void configuration_builder_sampled(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    descriptor_structure_t* const structure  = newest_structure(source);
    const uint32_t nrep                      = source_unsigned(source, "nrep", 2U, 1000U, 1U);
    if (!source_has_room(source, descriptor->sampled_count, DESCRIPTOR_SAMPLED_MAX, "<SampledNREPTimes>")) {
        return;
    }
    if ((structure->interval_cycles % nrep) != 0U) {
        char expected[64];
        text_t text = text_in(expected, sizeof expected);
        text_add(&text, "a divisor of the interval ");
        text_add_unsigned(&text, structure->interval_cycles);
        source_wrong(source, "nrep", expected);
    }
    descriptor->sampled[descriptor->sampled_count] =
        (descriptor_sampled_t){.nrep = (uint16_t)nrep, .first_reference = descriptor->reference_count};
    descriptor->sampled_count++;
    structure->sampled_count++;
}

void configuration_builder_sampled_reference(source_t* const source)
{
    refer_in_structure(source);
    model(source)->sampled[model(source)->sampled_count - 1U].reference_count++;
}

/// Octets of a range of referenced parameters.
static uint32_t referenced_octets(const subsystem_descriptor_t* const descriptor, const uint16_t first,
                                  const uint16_t count)
{
    uint32_t octets = 0U;
    for (uint16_t i = first; i < (first + count); i++) {
        octets += descriptor->parameters[descriptor->references[i]].wire_size;
    }
    return octets;
}

void configuration_builder_structure_end(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = model(source);
    descriptor_structure_t* const structure        = newest_structure(source);
    structure->octets = referenced_octets(descriptor, structure->first_reference, structure->reference_count);
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        const descriptor_sampled_t* const sampled = &descriptor->sampled[structure->first_sampled + i];
        structure->octets +=
            sampled->nrep * referenced_octets(descriptor, sampled->first_reference, sampled->reference_count);
    }
    if (structure->octets == 0U) {
        (void)source_fail(source, structure->line, STATUS_INVALID, "<HKService> has no <ParamRef>");
    } else if ((structure->octets > REPORT_OCTETS_MAX) &&
               source_fail(source, structure->line, STATUS_INVALID, "")) {
        text_add_unsigned(source->error, structure->octets);
        text_add(source->error, " octets in one report, at most ");
        text_add_unsigned(source->error, REPORT_OCTETS_MAX);
    }
}

void configuration_builder_links(source_t* const source)
{
    subsystem_builder_once(source, KIND_LINKS);
}

static descriptor_port_t* newest_port(source_t* const source)
{
    return &model(source)->ports[model(source)->port_count - 1U];
}

static descriptor_port_t* add_port(source_t* const source, const bool is_provided)
{
    subsystem_descriptor_t* const descriptor        = model(source);
    descriptor_configuration_t* const configuration = newest_configuration(source);
    if (!source_has_room(source, descriptor->port_count, DESCRIPTOR_PORTS_MAX, "ports")) {
        return NULL;
    }
    descriptor_port_t* const port = &descriptor->ports[descriptor->port_count];
    *port = (descriptor_port_t){.name           = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                .id             = (uint16_t)source_unsigned(source, "id", 1U, 65535U, 0U),
                                .is_provided    = is_provided,
                                .first_field    = descriptor->field_count,
                                .period_us      = configuration->sampling_us,
                                .stale_severity = DESCRIPTOR_HIGH,
                                .line           = source->line};
    port->method_count =
        (uint8_t)source_words(source, "methods", method_names, DESCRIPTOR_METHODS, port->methods);
    for (uint16_t i = configuration->first_port; i < descriptor->port_count; i++) {
        if (strcmp(descriptor->ports[i].name, port->name) == 0) {
            subsystem_builder_taken(source, "name", port->name, descriptor->ports[i].line);
        } else if (descriptor->ports[i].id == port->id) {
            subsystem_builder_taken(source, "id", source_raw(source, "id"), descriptor->ports[i].line);
        }
    }
    descriptor->port_count++;
    configuration->port_count++;
    return port;
}

void configuration_builder_provides(source_t* const source)
{
    (void)add_port(source, true);
}

void configuration_builder_requires(source_t* const source)
{
    descriptor_port_t* const port = add_port(source, false);
    if (port != NULL) {
        port->is_required = source_flag(source, "required", true);
        port->stale_us =
            source_time_us(source, "staleAfter", 100U, 60000000U, STALE_PERIODS * port->period_us);
        port->stale_severity =
            (descriptor_severity_t)(source_word(source, "severity", severity_names, 4U, 3U) + 1U);
    }
}

void configuration_builder_element(source_t* const source)
{
    descriptor_port_t* const port = newest_port(source);
    if (subsystem_builder_field(source, port->field_count) != NULL) {
        port->field_count++;
        subsystem_builder_check_field_name(source, port->first_field);
    }
}

/// CRC-32 over the lines name:type:count of a layout.
static uint32_t layout_hash(const subsystem_descriptor_t* const descriptor,
                            const descriptor_port_t* const port, bool* const out_is_cut)
{
    char lines[2048];
    text_t text = text_in(lines, sizeof lines);
    for (uint16_t i = 0U; i < port->field_count; i++) {
        const descriptor_field_t* const field = &descriptor->fields[port->first_field + i];
        text_add(&text, field->name);
        text_add(&text, ":");
        text_add(&text, value_type_name(field->type));
        text_add(&text, ":");
        text_add_unsigned(&text, field->count);
        text_add(&text, "\n");
    }
    *out_is_cut = text.cut;
    return crc32_iso((const uint8_t*)lines, text.length);
}

void configuration_builder_port_end(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    descriptor_port_t* const port            = newest_port(source);
    bool is_cut                              = false;
    port->octets      = subsystem_builder_octets(descriptor, port->first_field, port->field_count);
    port->memory_size = subsystem_builder_lay_out(descriptor, port->first_field, port->field_count);
    port->layout_hash = layout_hash(descriptor, port, &is_cut);
    if (port->field_count == 0U) {
        (void)source_fail(source, port->line, STATUS_INVALID, "the port has no <ParamRef>");
    } else if (is_cut || (port->octets > DESCRIPTOR_PORT_OCTETS_MAX)) {
        if (source_fail(source, port->line, STATUS_INVALID, "")) {
            text_add_unsigned(source->error, port->octets);
            text_add(source->error, " octets in one sample, at most ");
            text_add_unsigned(source->error, DESCRIPTOR_PORT_OCTETS_MAX);
        }
    }
}

void configuration_builder_devices(source_t* const source)
{
    subsystem_builder_once(source, KIND_DEVICES);
}

void configuration_builder_device(source_t* const source)
{
    subsystem_descriptor_t* const descriptor        = model(source);
    descriptor_configuration_t* const configuration = newest_configuration(source);
    if (!source_has_room(source, descriptor->device_count, DESCRIPTOR_DEVICES_MAX, "devices")) {
        return;
    }
    descriptor_device_t* const device = &descriptor->devices[descriptor->device_count];
    *device = (descriptor_device_t){.name          = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                    .type          = source_lower_identifier(source, "type"),
                                    .first_setting = descriptor->setting_count,
                                    .first_endnode = descriptor->endnode_count,
                                    .line          = source->line};
    for (uint16_t i = configuration->first_device; i < descriptor->device_count; i++) {
        if (strcmp(descriptor->devices[i].name, device->name) == 0) {
            subsystem_builder_taken(source, "name", device->name, descriptor->devices[i].line);
        }
    }
    descriptor->device_count++;
    configuration->device_count++;
}

/// Index and subindex of an object like 0x6060:00. False if it is none.
static bool read_object(const char* const words, uint16_t* const out_index, uint8_t* const out_subindex)
{
    char copy[10];
    if ((strlen(words) != 9U) || (words[0] != '0') || (words[1] != 'x') || (words[6] != ':')) {
        return false;
    }
    (void)memcpy(copy, words, sizeof copy);
    copy[6]               = '\0';
    char subindex_text[5] = {'0', 'x', words[7], words[8], '\0'};
    const char* at        = copy;
    const char* sub_at    = subindex_text;
    uint64_t index        = 0U;
    uint64_t subindex     = 0U;
    const bool is_right   = (number_read_unsigned(&at, &index) == STATUS_OK) && (*at == '\0') &&
                          (number_read_unsigned(&sub_at, &subindex) == STATUS_OK) && (*sub_at == '\0');
    *out_index    = (uint16_t)index;
    *out_subindex = (uint8_t)subindex;
    return is_right && (strchr(words, ' ') == NULL);
}

void configuration_builder_setting(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    if (!source_has_room(source, descriptor->setting_count, DESCRIPTOR_SETTINGS_MAX, "<Setting>")) {
        return;
    }
    descriptor_setting_t* const setting = &descriptor->settings[descriptor->setting_count];
    *setting                            = (descriptor_setting_t){.line = source->line};
    double real                         = 0.0;
    if (!read_object(source_raw(source, "object"), &setting->index, &setting->subindex)) {
        source_wrong(source, "object", "an object like 0x6060:00");
    }
    setting->type = source_value_type(source, "type");
    if ((setting->type == VALUE_DOUBLE) || (setting->type == VALUE_BOOL)) {
        source_wrong(source, "type", "an integer type or FLOAT");
    }
    setting->bits = source_number(source, "value", setting->type, &real);
    descriptor->setting_count++;
    descriptor->devices[descriptor->device_count - 1U].setting_count++;
}

/// Bits of the configurations that a function names.
static void resolve_function(source_t* const source, const uint16_t index)
{
    subsystem_descriptor_t* const descriptor = model(source);
    descriptor_function_t* const function    = &descriptor->functions[index];
    const char* at                           = subsystem_builder_of(source)->function_configurations[index];
    if (strcmp(at, "*") == 0) {
        function->configurations = (uint16_t)((1U << descriptor->configuration_count) - 1U);
        return;
    }
    bool is_right = source_is_spaced(at);
    while (is_right && (*at != '\0')) {
        const size_t length = strcspn(at, " ");
        uint16_t bit        = 0U;
        for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
            const char* const name = descriptor->configurations[i].name;
            if ((strncmp(at, name, length) == 0) && (name[length] == '\0')) {
                bit = (uint16_t)(1U << i);
            }
        }
        is_right                 = (bit != 0U) && ((function->configurations & bit) == 0U);
        function->configurations = (uint16_t)(function->configurations | bit);
        at += length + ((at[length] == ' ') ? 1U : 0U);
    }
    if (!is_right) {
        (void)source_fail(
            source, function->line, STATUS_INVALID,
            "configurations of <Function>: expected configurations of this subsystem, each once, or *");
    }
}

/// A port that several configurations have is the same port.
static void check_same_ports(source_t* const source)
{
    const subsystem_descriptor_t* const descriptor = model(source);
    for (uint16_t i = 0U; i < descriptor->port_count; i++) {
        const descriptor_port_t* const port = &descriptor->ports[i];
        for (const descriptor_port_t* other = descriptor->ports; other < port; other++) {
            const bool has_name = (strcmp(port->name, other->name) == 0);
            const bool is_same =
                (port->is_provided == other->is_provided) && (port->layout_hash == other->layout_hash);
            if (((has_name != (port->id == other->id)) || (has_name && !is_same)) &&
                source_fail(source, port->line, STATUS_INVALID, "port ")) {
                text_add(source->error, port->name);
                text_add(source->error, " differs from port ");
                text_add(source->error, other->name);
                text_add(source->error, " in line ");
                text_add_unsigned(source->error, other->line);
            }
        }
    }
}

void configuration_builder_resolve(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        resolve_function(source, i);
    }
    check_same_ports(source);
    descriptor->interface_hash = subsystem_interface_hash(descriptor);
}
