// SPDX-License-Identifier: Apache-2.0
// A subsystem descriptor is either refused with its line and leaves an empty model, or gives a model in which
// every index, range and text is consistent. Reading twice gives the same hashes.
#include "base/number.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "test/fuzz/fuzz.h"

#include <float.h>
#include <string.h>

#define NAME "descriptor.xml"

static descriptor_loader_t loader;
static subsystem_descriptor_t model;

static bool is_range(const uint32_t first, const uint32_t count, const uint32_t all)
{
    return (first <= all) && (count <= (all - first));
}

static void check_text(const char* const text)
{
    FUZZ_CHECK((text >= model.storage.text) && (text < &model.storage.text[model.text_used]));
    FUZZ_CHECK(memchr(text, '\0', (size_t)(&model.storage.text[model.text_used] - text)) != NULL);
}

static void check_fields(void)
{
    for (uint16_t i = 0U; i < model.field_count; i++) {
        const descriptor_field_t* const field = &model.fields[i];
        check_text(field->name);
        FUZZ_CHECK((field->type < VALUE_SCALARS) && (field->count >= 1U) && (field->min <= field->max));
        const char* rest = field->init;
        for (uint16_t k = 0U; (rest != NULL) && (k < field->count); k++) {
            uint64_t value = 0U;
            FUZZ_CHECK(number_read_value(&rest, field->type, &value) == STATUS_OK);
        }
        FUZZ_CHECK((rest == NULL) || number_is_end(rest));
    }
}

static void check_interface(void)
{
    for (uint16_t i = 0U; i < model.parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &model.parameters[i];
        check_text(parameter->name);
        FUZZ_CHECK(is_range(parameter->first_field, parameter->field_count, model.field_count));
        FUZZ_CHECK((parameter->field_count >= 1U) && ((parameter->id >> 21U) == model.apid));
        FUZZ_CHECK(descriptor_find_parameter(&model, parameter->name) == parameter);
    }
    for (uint16_t i = 0U; i < model.event_count; i++) {
        const descriptor_event_t* const event = &model.events[i];
        check_text(event->name);
        FUZZ_CHECK(is_range(event->first_field, event->field_count, model.field_count));
        FUZZ_CHECK(is_range(event->first_reference, event->reference_count, model.reference_count));
        FUZZ_CHECK((event->severity >= DESCRIPTOR_INFORMATIVE) && (event->severity <= DESCRIPTOR_HIGH));
        FUZZ_CHECK(descriptor_find_event(&model, event->id) == event);
    }
    for (uint16_t i = 0U; i < model.function_count; i++) {
        const descriptor_function_t* const function = &model.functions[i];
        check_text(function->name);
        FUZZ_CHECK(strlen(function->name) <= DESCRIPTOR_FUNCTION_NAME_MAX);
        FUZZ_CHECK(is_range(function->first_argument, function->argument_count, model.field_count));
    }
}

static void check_ports(const descriptor_configuration_t* const configuration)
{
    for (uint16_t i = 0U; i < configuration->port_count; i++) {
        const descriptor_port_t* const port = &model.ports[configuration->first_port + i];
        FUZZ_CHECK(is_range(port->first_field, port->field_count, model.field_count));
        FUZZ_CHECK((port->octets >= 1U) && (port->octets <= DESCRIPTOR_PORT_OCTETS_MAX));
        FUZZ_CHECK((port->period_us >= 1U) && (port->method_count <= DESCRIPTOR_METHODS));
    }
}

static void check_housekeeping(const descriptor_configuration_t* const configuration)
{
    for (uint16_t i = 0U; i < configuration->structure_count; i++) {
        const descriptor_structure_t* const report = &model.structures[configuration->first_structure + i];
        FUZZ_CHECK(is_range(report->first_reference, report->reference_count, model.reference_count));
        FUZZ_CHECK(is_range(report->first_sampled, report->sampled_count, model.sampled_count));
        for (uint16_t k = 0U; k < report->sampled_count; k++) {
            const descriptor_sampled_t* const set = &model.sampled[report->first_sampled + k];
            FUZZ_CHECK(is_range(set->first_reference, set->reference_count, model.reference_count));
            FUZZ_CHECK((set->nrep >= 1U) && ((report->interval_cycles % set->nrep) == 0U));
        }
    }
}

static void check_configurations(void)
{
    for (uint16_t i = 0U; i < model.configuration_count; i++) {
        const descriptor_configuration_t* const configuration = &model.configurations[i];
        check_text(configuration->name);
        FUZZ_CHECK((configuration->id >= 1U) && (configuration->sampling_us >= 1U));
        FUZZ_CHECK(is_range(configuration->first_initial, configuration->initial_count, model.initial_count));
        FUZZ_CHECK(is_range(configuration->first_port, configuration->port_count, model.port_count));
        FUZZ_CHECK(is_range(configuration->first_device, configuration->device_count, model.device_count));
        FUZZ_CHECK(
            is_range(configuration->first_structure, configuration->structure_count, model.structure_count));
        check_ports(configuration);
        check_housekeeping(configuration);
    }
    for (uint16_t i = 0U; i < model.reference_count; i++) {
        FUZZ_CHECK(model.references[i] < model.parameter_count);
    }
    for (uint16_t i = 0U; i < model.initial_count; i++) {
        FUZZ_CHECK(model.initials[i].parameter < model.parameter_count);
        FUZZ_CHECK(model.initials[i].field < model.field_count);
    }
    for (uint16_t i = 0U; i < model.device_count; i++) {
        const descriptor_device_t* const device = &model.devices[i];
        FUZZ_CHECK(is_range(device->first_setting, device->setting_count, model.setting_count));
        FUZZ_CHECK(is_range(device->first_endnode, device->endnode_count, model.endnode_count));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    descriptor_loader_init(&loader);
    const status_t status = descriptor_parse_subsystem(&loader, NAME, data, size, &model);
    if (status != STATUS_OK) {
        FUZZ_CHECK((status == STATUS_INVALID) || (status == STATUS_TRUNCATED) ||
                   (status == STATUS_TOO_LARGE) || (status == STATUS_EXHAUSTED));
        FUZZ_CHECK(strncmp(descriptor_error(&loader), NAME ":", sizeof NAME) == 0);
        FUZZ_CHECK((model.parameter_count == 0U) && (model.name[0] == '\0'));
        return 0;
    }
    FUZZ_CHECK(descriptor_error(&loader)[0] == '\0');
    FUZZ_CHECK((model.apid >= 1U) && (model.apid <= 2046U));
    FUZZ_CHECK(model.text_used <= DESCRIPTOR_TEXT_OCTETS);
    check_fields();
    check_interface();
    check_configurations();
    const uint64_t interface     = model.interface_hash;
    const uint64_t configuration = model.configuration_hash;
    FUZZ_CHECK(descriptor_parse_subsystem(&loader, NAME, data, size, &model) == STATUS_OK);
    FUZZ_CHECK((model.interface_hash == interface) && (model.configuration_hash == configuration));
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_document(data, size, max_size, seed);
}
