// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/fitting.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/subsystem_core.h"

#include <stddef.h>

#define SERVICE_DEVICE_ACCESS 2U

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const reason)
{
    *misfit = (subsystem_misfit_t){line, reason, 0U};
    return false;
}

/// Refuse items that exceed a capacity.
static bool refuse_above(subsystem_misfit_t* const misfit, const uint32_t line, const char* const items,
                         const size_t most)
{
    *misfit = (subsystem_misfit_t){line, items, (uint32_t)most};
    return false;
}

/// Check the lists that have an entry for each item of the descriptor.
static bool lists_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    if (descriptor->parameter_count > SUBSYSTEM_PARAMETERS) {
        return refuse_above(out_misfit, descriptor->parameters[SUBSYSTEM_PARAMETERS].line,
                            "<ParamRef> in this program", SUBSYSTEM_PARAMETERS);
    }
    uint32_t bounds = 0U;
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        bounds += descriptor->parameters[i].field_count;
        if (bounds > SUBSYSTEM_BOUNDS) {
            return refuse_above(out_misfit, descriptor->parameters[i].line,
                                "fields of all <ParamRef> in this program", SUBSYSTEM_BOUNDS);
        }
    }
    if (descriptor->event_count > SUBSYSTEM_EVENTS) {
        return refuse_above(out_misfit, descriptor->events[SUBSYSTEM_EVENTS].line, "<Event> in this program",
                            SUBSYSTEM_EVENTS);
    }
    if (descriptor->function_count > SUBSYSTEM_FUNCTIONS) {
        return refuse_above(out_misfit, descriptor->functions[SUBSYSTEM_FUNCTIONS].line,
                            "<Function> in this program", SUBSYSTEM_FUNCTIONS);
    }
    return true;
}

static bool services_fit(const subsystem_descriptor_t* const descriptor,
                         const subsystem_callbacks_t* const callbacks, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        const descriptor_service_t* const service = &descriptor->services[i];
        if ((service->type == SERVICE_DEVICE_ACCESS) && (callbacks->device_port == NULL)) {
            return refuse(out_misfit, service->line,
                          "type=\"2\" of <Service>: expected a subsystem with the callback device_port");
        }
    }
    return true;
}

static bool functions_fit(const subsystem_descriptor_t* const descriptor,
                          subsystem_misfit_t* const out_misfit)
{
    uint32_t count = 0U;
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        count += function->argument_count;
        if (count > SUBSYSTEM_ARGUMENTS) {
            return refuse_above(out_misfit, function->line, "<Argument> in one descriptor",
                                SUBSYSTEM_ARGUMENTS);
        }
        if (function->memory_size > (SUBSYSTEM_ARGUMENT_WORDS * sizeof(uint64_t))) {
            return refuse_above(out_misfit, function->line, "octets of arguments in memory",
                                SUBSYSTEM_ARGUMENT_WORDS * sizeof(uint64_t));
        }
    }
    return true;
}

static bool structure_fits(const descriptor_structure_t* const structure,
                           subsystem_misfit_t* const out_misfit)
{
    if (structure->sampled_count > PUS_HK_SETS_MAX) {
        return refuse_above(out_misfit, structure->line, "<SampledNREPTimes> in one <HKService>",
                            PUS_HK_SETS_MAX);
    }
    if (structure->octets > SUBSYSTEM_SAMPLE_OCTETS) {
        return refuse_above(out_misfit, structure->line, "octets in one <HKService>",
                            SUBSYSTEM_SAMPLE_OCTETS);
    }
    return true;
}

static bool housekeeping_fits(const subsystem_descriptor_t* const descriptor,
                              subsystem_misfit_t* const out_misfit)
{
    bool fits = true;
    for (uint16_t c = 0U; fits && (c < descriptor->configuration_count); c++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[c];
        if (configuration->structure_count > SUBSYSTEM_STRUCTURES) {
            return refuse_above(out_misfit, configuration->line, "<HKService> in one <Configuration>",
                                SUBSYSTEM_STRUCTURES);
        }
        if (configuration->loop_count > SUBSYSTEM_LOOPS) {
            return refuse_above(out_misfit, configuration->line, "<Loop> in one <Configuration>",
                                SUBSYSTEM_LOOPS);
        }
        for (uint16_t i = 0U; fits && (i < configuration->structure_count); i++) {
            fits = structure_fits(&descriptor->structures[configuration->first_structure + i], out_misfit);
        }
    }
    return fits;
}

/// Check the devices of a subsystem without the callback `fits`: true if the subsystem has no devices, or
/// only devices on CAN.
static bool devices_fit(const subsystem_descriptor_t* const descriptor,
                        const subsystem_callbacks_t* const callbacks, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        if (callbacks->sense == NULL) {
            return refuse(out_misfit, device->line, "<Device>: expected none, this subsystem has no devices");
        }
        if (device->endnode_count == 0U) {
            return refuse(out_misfit, device->line, "<Device> has no <Endnode type=\"CAN\">");
        }
        const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
        if (endnode->type != DESCRIPTOR_ENDNODE_CAN) {
            return refuse(out_misfit, endnode->line, "type of <Endnode>: expected CAN");
        }
    }
    return true;
}

bool subsystem_fits(const subsystem_descriptor_t* const descriptor,
                    const subsystem_callbacks_t* const callbacks, subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (callbacks != NULL) && (out_misfit != NULL));
    return services_fit(descriptor, callbacks, out_misfit) && lists_fit(descriptor, out_misfit) &&
           functions_fit(descriptor, out_misfit) && housekeeping_fits(descriptor, out_misfit) &&
           ((callbacks->fits == NULL) ? devices_fit(descriptor, callbacks, out_misfit)
                                      : callbacks->fits(descriptor, out_misfit));
}
