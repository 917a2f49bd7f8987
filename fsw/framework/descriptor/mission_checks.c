// SPDX-License-Identifier: Apache-2.0
// Conditions between the parts of a mission and the descriptors of its subsystems. Launcher and supervisor
// check them before any subsystem starts; the program of a subsystem does not check them again.
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

// The entry of a subsystem in the mission must have room for the largest descriptor.
typedef char configurations_fit[(MISSION_CONFIGURATIONS_MAX >= DESCRIPTOR_CONFIGURATIONS_MAX) ? 1 : -1];
typedef char ports_fit[(MISSION_PORTS_MAX >= DESCRIPTOR_PORTS_MAX) ? 1 : -1];

// ---- Elements ----

/// Begin a subsystem of the mission: no power of a state has been read yet.
static void begin_listed(source_t* const source)
{
    descriptor_mission_builder_of(source)->power_seen = 0U;
}

/// Read the power of a subsystem in a state.
static void take_power(source_t* const source)
{
    mission_builder_t* const builder     = source->builder;
    mission_subsystem_t* const subsystem = source->item;
    uint8_t state                        = 0U;
    if (descriptor_state_of(descriptor_source_raw(source, "state"), &state) != STATUS_OK) {
        descriptor_source_wrong(source, "state", "the name of a state");
    } else if ((((uint32_t)builder->power_seen >> state) & 1U) != 0U) {
        descriptor_source_wrong(source, "state", "each state once");
    } else {
        builder->power_seen       = (uint16_t)(builder->power_seen | (1U << state));
        subsystem->power_w[state] = descriptor_source_value(source, 1U);
    }
}

/// Check that one mode is the initial one, and that the fallback mode exists.
static void end_modes(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    uint32_t initial                    = 0U;
    uint32_t fallback                   = 0U;
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        const mission_mode_t* const mode = &mission->modes[i];
        if (mode->is_initial) {
            mission->initial_mode = mode->id;
            initial++;
        }
        if (mode->is_fallback) {
            mission->fallback_mode = mode->id;
            fallback++;
        }
    }
    if (initial != 1U) {
        descriptor_source_fail(source, source->line, "exactly one <Mode> must have initial=\"true\"");
    } else if ((fallback > 1U) || (descriptor_mission_find_mode(mission, mission->fallback_mode) == NULL)) {
        descriptor_source_fail(source, source->line, "one <Mode> must have fallback=\"true\" or id 0");
    } else {
        // The modes have one initial and one fallback mode.
    }
}

/// Check that the lists of subsystems and modes precede the elements that refer to them.
static void check_lists(source_t* const source)
{
    const mission_descriptor_t* const mission = source->item;
    if ((mission->subsystem_count == 0U) || (mission->mode_count == 0U)) {
        descriptor_source_refuse(source, source->line,
                                 "expected <Subsystems> and <Modes>, not empty, before <%>",
                                 source->open[source->depth - 1U]->name, NULL, 0U);
    }
}

/// Check that the mission has a key if other machines may send telecommands.
static void check_ground(source_t* const source)
{
    const mission_descriptor_t* const mission = source->item;
    const bool has_key                        = descriptor_source_has(source, "key");
    if (has_key && (mission->ground_key[0] == '\0')) {
        descriptor_source_wrong(source, "key", "the path of a file, or no such attribute");
    } else if ((mission->is_ground_open != 0U) && !has_key) {
        descriptor_source_fail(source, source->line,
                               "<Ground address=\"0.0.0.0\"> needs a key; only 127.0.0.1 needs none");
    } else {
        // Address and key are consistent.
    }
}

// ---- Buses ----

static const mission_bus_t* find_bus(const mission_descriptor_t* const mission, const char* const name)
{
    return descriptor_named(mission->buses, mission->bus_count, sizeof mission->buses[0], name);
}

/// Check that each redundant bus names another bus, and that this bus has no second one.
static void end_buses(source_t* const source)
{
    const mission_descriptor_t* const mission = source->item;
    for (uint16_t i = 0U; i < mission->bus_count; i++) {
        const mission_bus_t* const bus = &mission->buses[i];
        if (bus->redundant_to[0] == '\0') {
            continue;
        }
        const mission_bus_t* const other = find_bus(mission, bus->redundant_to);
        bool is_good                     = (other != NULL) && (other->redundant_to[0] == '\0');
        for (uint16_t k = 0U; k < i; k++) {
            is_good = is_good && (strcmp(mission->buses[k].redundant_to, bus->redundant_to) != 0);
        }
        if (!is_good) {
            descriptor_mission_builder_refuse(
                source, bus->line, "redundantTo", bus->redundant_to,
                "Bus>: expected a bus of the mission that is not redundant itself and has one "
                "redundant bus");
        }
    }
}

/// Give a bus to a subsystem. A bus has one master only, because SYNC and network management act on all
/// devices of the bus.
static void take_bus(mission_builder_t* const builder, const mission_bus_t* const bus,
                     const mission_subsystem_t* const subsystem, const char* const path, const uint32_t line,
                     const char* const attribute)
{
    source_t* const source                  = &builder->source;
    const mission_subsystem_t** const owner = &builder->bus_owners[bus - builder->mission->buses];
    if ((*owner != NULL) && (*owner != subsystem)) {
        source->path = path;
        descriptor_source_refuse(source, line, "%=\"%\" of <Endnode>: expected a bus of its own, ", attribute,
                                 bus->name, 0U);
        descriptor_source_append(source, "not that of %", (*owner)->name, NULL, 0U);
    }
    *owner = subsystem;
}

void descriptor_mission_check_buses(mission_builder_t* const builder,
                                    const mission_subsystem_t* const subsystem, const char* const path,
                                    const subsystem_descriptor_t* const descriptor)
{
    source_t* const source = &builder->source;
    for (uint16_t i = 0U; i < descriptor->endnode_count; i++) {
        const descriptor_endnode_t* const endnode = &descriptor->endnodes[i];
        if (endnode->type != DESCRIPTOR_ENDNODE_CAN) {
            continue;
        }
        const mission_bus_t* const bus = find_bus(builder->mission, endnode->bus);
        if (bus == NULL) {
            source->path = path;
            descriptor_mission_builder_refuse(source, endnode->line, "bus", endnode->bus,
                                              "Endnode>: expected a bus of the mission");
        } else {
            take_bus(builder, bus, subsystem, path, endnode->line, "bus");
        }
        const mission_bus_t* const redundant = find_bus(builder->mission, endnode->redundant_bus);
        const bool is_channel = (redundant != NULL) && (strcmp(redundant->redundant_to, endnode->bus) == 0);
        if ((endnode->redundant_bus[0] != '\0') && !is_channel) {
            source->path = path;
            descriptor_mission_builder_refuse(
                source, endnode->line, "redundantBus", endnode->redundant_bus,
                "Endnode>: expected a bus of the mission that is redundantTo its bus");
        } else if (redundant != NULL) {
            take_bus(builder, redundant, subsystem, path, endnode->line, "redundantBus");
        } else {
            // The bus has one channel.
        }
    }
}

// ---- Ports and links ----

static uint8_t methods_of(const descriptor_port_t* const port)
{
    uint32_t methods = 0U;
    for (uint8_t m = 0U; m < port->method_count; m++) {
        methods |= (uint32_t)1U << port->methods[m];
    }
    return (uint8_t)methods;
}

void descriptor_mission_copy_ports(source_t* const source, mission_subsystem_t* const subsystem,
                                   const subsystem_descriptor_t* const descriptor)
{
    for (; subsystem->configuration_count < descriptor->configuration_count;
         subsystem->configuration_count++) {
        const descriptor_configuration_t* const configuration =
            &descriptor->configurations[subsystem->configuration_count];
        mission_configuration_t* const copy = &subsystem->configurations[subsystem->configuration_count];
        copy->name                          = descriptor_source_keep(source, configuration->name);
        copy->id                            = configuration->id;
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            mission_port_t* const port_copy     = &subsystem->ports[subsystem->port_count];
            port_copy->name                     = descriptor_source_keep(source, port->name);
            port_copy->id                       = port->id;
            port_copy->configuration            = configuration->id;
            port_copy->is_provided              = port->is_provided;
            port_copy->is_required              = port->is_required;
            port_copy->layout_hash              = port->layout_hash;
            port_copy->methods                  = methods_of(port);
            subsystem->port_count++;
        }
    }
}

/// Returns the port that the words SUBSYSTEM.PORT name, if it is of the expected side; NULL after an error.
static const mission_port_t* resolve_end(mission_builder_t* const builder, const mission_link_t* const link,
                                         const char* const words, const bool is_provided)
{
    const uint16_t apid                        = is_provided ? link->producer_apid : link->consumer_apid;
    const mission_subsystem_t* const subsystem = descriptor_mission_find_subsystem(builder->mission, apid);
    const mission_port_t* const port =
        (subsystem != NULL) ? descriptor_named(subsystem->ports, subsystem->port_count,
                                               sizeof subsystem->ports[0], &words[strcspn(words, ".") + 1U])
                            : NULL;
    if ((port != NULL) && (port->is_provided == is_provided)) { // The port is the same in all configurations.
        return port;
    }
    descriptor_mission_builder_refuse(&builder->source, link->line, is_provided ? "from" : "to", words,
                                      is_provided ? "Link>: expected SUBSYSTEM.PORT, a provided port"
                                                  : "Link>: expected SUBSYSTEM.PORT, a required port");
    return NULL;
}

/// Returns the number of links, among the first `count`, whose end names the same port.
static uint16_t links_of_port(const mission_builder_t* const builder, const uint16_t count,
                              const unsigned end, const char* const words)
{
    uint16_t found = 0U;
    for (uint16_t i = 0U; i < count; i++) {
        found = (uint16_t)(found + ((strcmp(builder->link_words[i][end], words) == 0) ? 1U : 0U));
    }
    return found;
}

/// Check that the ports are of different subsystems, that no earlier link leads to the consumer's port, and
/// that the producer's port has room for one more link.
static void check_room(mission_builder_t* const builder, const uint16_t index)
{
    source_t* const source           = &builder->source;
    const mission_link_t* const link = &builder->mission->links[index];
    const char* const* const words   = builder->link_words[index];
    if (link->producer_apid == link->consumer_apid) {
        descriptor_mission_builder_refuse(source, link->line, "to", words[1],
                                          "Link>: expected a port of another subsystem");
    }
    if (links_of_port(builder, index, 1U, words[1]) > 0U) {
        descriptor_mission_builder_refuse(source, link->line, "to", words[1],
                                          "Link>: expected a port that no other link leads to");
    }
    if (links_of_port(builder, index, 0U, words[0]) >= MISSION_PORT_LINKS_MAX) {
        descriptor_mission_builder_refuse(source, link->line, "from", words[0], "Link>: expected a port");
        descriptor_source_append(source, " with at most # links", NULL, NULL, MISSION_PORT_LINKS_MAX);
    }
}

void descriptor_mission_check_link(mission_builder_t* const builder, const uint16_t index)
{
    source_t* const source               = &builder->source;
    mission_link_t* const link           = &builder->mission->storage.links[index];
    const char* const* const words       = builder->link_words[index];
    const mission_port_t* const producer = resolve_end(builder, link, words[0], true);
    const mission_port_t* const consumer = resolve_end(builder, link, words[1], false);
    if ((producer == NULL) || (consumer == NULL)) {
        return;
    }
    link->is_required = consumer->is_required;
    if (producer->layout_hash != consumer->layout_hash) {
        descriptor_source_fail(source, link->line, "<Link>: expected two ports with the same layout");
    } else if ((producer->methods & consumer->methods) == 0U) {
        descriptor_source_fail(source, link->line, "<Link>: expected two ports that share a transfer method");
    } else {
        check_room(builder, index);
    }
}

void descriptor_mission_check_element(source_t* const source)
{
    static void (*const handlers[])(source_t*) = {[MISSION_KIND_LISTED]      = begin_listed,
                                                  [MISSION_KIND_POWER]       = take_power,
                                                  [MISSION_KIND_MODES]       = end_modes,
                                                  [MISSION_KIND_PERMISSIONS] = check_lists,
                                                  [MISSION_KIND_ALLOW]       = descriptor_mission_rules_allow,
                                                  [MISSION_KIND_PLANS]       = check_lists,
                                                  [MISSION_KIND_PLAN]        = descriptor_mission_rules_plan,
                                                  [MISSION_KIND_ACTION] = descriptor_mission_rules_action,
                                                  [MISSION_KIND_BUSES]  = end_buses,
                                                  [MISSION_KIND_GROUND] = check_ground};
    handlers[source->open[source->depth - 1U]->kind](source);
}
