// SPDX-License-Identifier: Apache-2.0
#include "launcher/descriptor_capacities.h"

#include "base/assertion.h"
#include "fsw/canopen/device_profile.h"

#include <string.h>

#define WORD_OCTETS 8U
#define SPARE_STRUCTURES 2U      // Housekeeping structures that ground may define in addition.
#define SPARE_SAMPLE_OCTETS 256U // Smallest size of a sample [octets], so that these structures have room.
#define SPARE_RECORDS 16U        // Records of services without entries in a descriptor.
#define NODES 128U

typedef enum {
    BUSES,
    DEVICES,
    MAPPINGS,
    PARAMETERS,
    BOUNDS,
    EVENTS,
    FUNCTIONS,
    ARGUMENTS,
    ARGUMENT_WORDS,
    STRUCTURES,
    SAMPLE_OCTETS,
    LOOPS,
    LINKS,
    RECORDS,
    COUNT
} capacity_t;

CAPACITY_CHECK(each_capacity_has_a_value, (unsigned)COUNT == DESCRIPTOR_CAPACITIES);

static const char* const names[COUNT] = {
    "DRIVES_BUSES_MAX",         "DRIVES_DEVICES_MAX",    "DRIVES_MAPPINGS_MAX",     "SUBSYSTEM_PARAMETERS",
    "SUBSYSTEM_BOUNDS",         "SUBSYSTEM_EVENTS",      "SUBSYSTEM_FUNCTIONS",     "SUBSYSTEM_ARGUMENTS",
    "SUBSYSTEM_ARGUMENT_WORDS", "SUBSYSTEM_STRUCTURES",  "SUBSYSTEM_SAMPLE_OCTETS", "SUBSYSTEM_LOOPS",
    "SUBSYSTEM_LINKS",          "SUBSYSTEM_HOST_RECORDS"};

static void raise_to(descriptor_capacities_t* const capacities, const capacity_t which, const uint32_t value)
{
    uint32_t* const known = &capacities->values[which];
    *known                = (value > *known) ? value : *known;
}

/// True if a configuration changes the mapping of PDOs of this device.
static bool is_mapped(const subsystem_descriptor_t* const subsystem, const descriptor_device_t* const device)
{
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        if (canopen_device_profile_is_mapping(subsystem->settings[device->first_setting + i].index)) {
            return true;
        }
    }
    return false;
}

/// Count the nodes on CAN of all configurations, each once, the nodes with another mapping, and their buses.
static void add_devices(descriptor_capacities_t* const capacities,
                        const subsystem_descriptor_t* const subsystem)
{
    const char* buses[NODES];
    bool is_known[NODES]    = {false};
    bool has_mapping[NODES] = {false};
    uint32_t bus_count      = 0U;
    uint32_t node_count     = 0U;
    uint32_t mapping_count  = 0U;
    for (uint16_t i = 0U; i < subsystem->device_count; i++) {
        const descriptor_device_t* const device   = &subsystem->devices[i];
        const descriptor_endnode_t* const endnode = &subsystem->endnodes[device->first_endnode];
        if ((device->endnode_count == 0U) || (endnode->type != DESCRIPTOR_ENDNODE_CAN)) {
            continue;
        }
        uint32_t bus = 0U;
        while ((bus < bus_count) && (strcmp(buses[bus], endnode->bus) != 0)) {
            bus++;
        }
        if ((bus == bus_count) && (bus_count < NODES)) {
            buses[bus_count] = endnode->bus;
            bus_count++;
        }
        const uint8_t node     = endnode->node % NODES;
        const bool is_remapped = is_mapped(subsystem, device);
        node_count += is_known[node] ? 0U : 1U;
        mapping_count += (is_remapped && !has_mapping[node]) ? 1U : 0U;
        is_known[node]    = true;
        has_mapping[node] = has_mapping[node] || is_remapped;
    }
    raise_to(capacities, BUSES, bus_count);
    raise_to(capacities, DEVICES, node_count);
    raise_to(capacities, MAPPINGS, mapping_count);
}

static void add_functions(descriptor_capacities_t* const capacities,
                          const subsystem_descriptor_t* const subsystem)
{
    uint32_t arguments = 0U;
    uint32_t octets    = 0U;
    for (uint16_t i = 0U; i < subsystem->function_count; i++) {
        const descriptor_function_t* const function = &subsystem->functions[i];
        arguments += function->argument_count;
        octets = (function->memory_size > octets) ? function->memory_size : octets;
    }
    raise_to(capacities, FUNCTIONS, subsystem->function_count);
    raise_to(capacities, ARGUMENTS, arguments);
    raise_to(capacities, ARGUMENT_WORDS, (octets + WORD_OCTETS - 1U) / WORD_OCTETS);
}

static void add_configurations(descriptor_capacities_t* const capacities,
                               const subsystem_descriptor_t* const subsystem)
{
    for (uint16_t i = 0U; i < subsystem->configuration_count; i++) {
        const descriptor_configuration_t* const configuration = &subsystem->configurations[i];
        raise_to(capacities, STRUCTURES, configuration->structure_count + SPARE_STRUCTURES);
        raise_to(capacities, LOOPS, configuration->loop_count);
    }
    raise_to(capacities, SAMPLE_OCTETS, SPARE_SAMPLE_OCTETS);
    for (uint16_t i = 0U; i < subsystem->structure_count; i++) {
        raise_to(capacities, SAMPLE_OCTETS, subsystem->structures[i].octets);
    }
}

/// Count what services keep over a restart: definitions, and one record for each parameter and event.
static void add_records(descriptor_capacities_t* const capacities,
                        const subsystem_descriptor_t* const subsystem)
{
    uint32_t records = SPARE_RECORDS + (2U * capacities->values[STRUCTURES]) + subsystem->event_count +
                       subsystem->parameter_count;
    for (uint16_t i = 0U; i < subsystem->service_count; i++) {
        records += (uint32_t)subsystem->services[i].capacity + subsystem->services[i].functional;
    }
    raise_to(capacities, RECORDS, records);
}

void descriptor_capacities_add(descriptor_capacities_t* const capacities,
                               const subsystem_descriptor_t* const subsystem,
                               const mission_descriptor_t* const mission)
{
    FSW_ASSERT((capacities != NULL) && (subsystem != NULL) && (mission != NULL));
    uint32_t bounds = 0U;
    uint32_t links  = 0U;
    for (uint16_t i = 0U; i < subsystem->parameter_count; i++) {
        bounds += subsystem->parameters[i].field_count;
    }
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        const mission_link_t* const link = &mission->links[i];
        const bool is_own =
            (link->producer_apid == subsystem->apid) || (link->consumer_apid == subsystem->apid);
        links += is_own ? 1U : 0U;
    }
    add_devices(capacities, subsystem);
    raise_to(capacities, PARAMETERS, subsystem->parameter_count);
    raise_to(capacities, BOUNDS, bounds);
    raise_to(capacities, EVENTS, subsystem->event_count);
    add_functions(capacities, subsystem);
    add_configurations(capacities, subsystem);
    raise_to(capacities, LINKS, links);
    add_records(capacities, subsystem);
}

void descriptor_capacities_write(const descriptor_capacities_t* const capacities, text_t* const text)
{
    FSW_ASSERT((capacities != NULL) && (text != NULL));
    text_add(text, "/* Made by descriptor-compiler: sizes of the storage of one program. */\n");
    for (unsigned i = 0U; i < (unsigned)COUNT; i++) {
        const uint32_t value = capacities->values[i]; // An array has at least one item.
        text_add(text, "#define ");
        text_add_pattern(text, "% #U\n", names[i], NULL, (value > 0U) ? value : 1U);
    }
}
