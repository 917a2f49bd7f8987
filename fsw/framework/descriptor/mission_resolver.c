// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/base/crc.h"
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

#define SERVICE_FUNCTIONS 8U
#define SERVICE_LINKS 130U

// What a subsystem may have, its entry in a mission can hold.
typedef char configurations_fit[(MISSION_CONFIGURATIONS_MAX >= DESCRIPTOR_CONFIGURATIONS_MAX) ? 1 : -1];
typedef char ports_fit[(MISSION_PORTS_MAX >= DESCRIPTOR_PORTS_MAX) ? 1 : -1];

/// The words of an attribute name nothing of the kind expected; `expected` begins with the element's name.
static void refuse_name(source_t* const source, const uint32_t line, const char* const attribute,
                        const char* const words, const char* const expected)
{
    source_refuse(source, line, "%=\"%\" of <", attribute, words, 0U);
    source_say(source, "%", expected, NULL, 0U);
}

static uint8_t methods_of(const descriptor_port_t* const port)
{
    uint32_t methods = 0U;
    for (uint8_t m = 0U; m < port->method_count; m++) {
        methods |= (uint32_t)1U << port->methods[m];
    }
    return (uint8_t)methods;
}

static void copy_configurations(source_t* const source, mission_subsystem_t* const subsystem,
                                const subsystem_descriptor_t* const descriptor)
{
    for (; subsystem->configuration_count < descriptor->configuration_count;
         subsystem->configuration_count++) {
        const descriptor_configuration_t* const configuration =
            &descriptor->configurations[subsystem->configuration_count];
        mission_configuration_t* const copy = &subsystem->configurations[subsystem->configuration_count];
        copy->name                          = source_keep(source, configuration->name);
        copy->id                            = configuration->id;
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            mission_port_t* const port_copy     = &subsystem->ports[subsystem->port_count];
            port_copy->name                     = source_keep(source, port->name);
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

/// Function or configuration of this subsystem that a rule names: then nothing is left to be found.
static const char* find_rule_name(mission_rule_t* const rule, const char* const words,
                                  const subsystem_descriptor_t* const descriptor)
{
    if (rule->service == SERVICE_FUNCTIONS) {
        return (descriptor_named(descriptor->functions, descriptor->function_count,
                                 sizeof descriptor->functions[0], words) == NULL)
                   ? words
                   : NULL;
    }
    const descriptor_configuration_t* const configuration =
        descriptor_named(descriptor->configurations, descriptor->configuration_count,
                         sizeof descriptor->configurations[0], words);
    if (configuration == NULL) {
        return words;
    }
    rule->number = configuration->id;
    return NULL;
}

/// Functions and configurations of this subsystem that rules name.
static void find_rule_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t i = 0U; i < builder->mission->rule_count; i++) {
        mission_rule_t* const rule = &builder->mission->rules[i];
        const bool is_meant = (rule->target == MISSION_ANY_TARGET) || (rule->target == subsystem->apid);
        if ((builder->rule_words[i] != NULL) && is_meant && (rule->service != SERVICE_LINKS)) {
            builder->rule_words[i] = find_rule_name(rule, builder->rule_words[i], descriptor);
        }
    }
}

/// Events of this subsystem that plans name.
static void find_plan_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t i = 0U; i < builder->mission->plan_count; i++) {
        mission_plan_t* const plan = &builder->mission->plans[i];
        if ((builder->plan_events[i] == NULL) || (plan->apid != subsystem->apid)) {
            continue;
        }
        const descriptor_event_t* const event =
            descriptor_find_event_name(descriptor, builder->plan_events[i]);
        if ((event != NULL) && (event->severity == plan->severity)) {
            plan->event_id          = event->id;
            builder->plan_events[i] = NULL;
        }
    }
}

static const mission_bus_t* find_bus(const mission_descriptor_t* const mission, const char* const name)
{
    return descriptor_named(mission->buses, mission->bus_count, sizeof mission->buses[0], name);
}

/// Each redundant bus is the one redundant bus of another.
void mission_builder_buses_end(source_t* const source)
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
            refuse_name(source, bus->line, "redundantTo", bus->redundant_to,
                        "Bus>: expected a bus of the mission that is not redundant itself and has one "
                        "redundant bus");
        }
    }
}

/// Every bus that an endnode names is a bus of the mission, and its redundant bus is channel B of that.
static void check_buses(mission_builder_t* const builder, const char* const path,
                        const subsystem_descriptor_t* const descriptor)
{
    source_t* const source = &builder->source;
    for (uint16_t i = 0U; i < descriptor->endnode_count; i++) {
        const descriptor_endnode_t* const endnode = &descriptor->endnodes[i];
        if (endnode->type != DESCRIPTOR_ENDNODE_CAN) {
            continue;
        }
        if (find_bus(builder->mission, endnode->bus) == NULL) {
            source->path = path;
            refuse_name(source, endnode->line, "bus", endnode->bus,
                        "Endnode>: expected a bus of the mission");
        }
        const mission_bus_t* const redundant = find_bus(builder->mission, endnode->redundant_bus);
        const bool is_channel = (redundant != NULL) && (strcmp(redundant->redundant_to, endnode->bus) == 0);
        if ((endnode->redundant_bus[0] != '\0') && !is_channel) {
            source->path = path;
            refuse_name(source, endnode->line, "redundantBus", endnode->redundant_bus,
                        "Endnode>: expected a bus of the mission that is redundantTo its bus");
        }
    }
}

status_t mission_builder_take(mission_builder_t* const builder, const uint16_t index, const char* const path,
                              const subsystem_descriptor_t* const descriptor)
{
    mission_subsystem_t* const subsystem = &builder->mission->subsystems[index];
    source_t* const source               = &builder->source;
    source->line                         = subsystem->line;
    if ((strcmp(subsystem->name, descriptor->name) != 0) || (subsystem->apid != descriptor->apid)) {
        source_refuse(source, subsystem->line, "% #: its descriptor says % ", subsystem->name,
                      descriptor->name, subsystem->apid);
        source_say(source, "#", NULL, NULL, descriptor->apid);
    }
    subsystem->interface_hash     = descriptor->interface_hash;
    subsystem->configuration_hash = descriptor->configuration_hash;
    copy_configurations(source, subsystem, descriptor);
    find_rule_names(builder, subsystem, descriptor);
    find_plan_names(builder, subsystem, descriptor);
    check_buses(builder, path, descriptor);
    return source->status;
}

void mission_builder_narrow(mission_builder_t* const builder, const uint16_t apid)
{
    mission_descriptor_t* const mission = builder->mission;
    builder->only                       = apid;
    mission->rule_count                 = 0U;
    mission->plan_count                 = 0U;
    mission->action_count               = 0U;
    mission->configuration_hash         = 0U;
}

/// Port of a subsystem that is not taken in.
static const mission_port_t unknown_port = {.name = ""};

/// Port of SUBSYSTEM.PORT on the side wanted, or NULL after an error.
static const mission_port_t* resolve_end(mission_builder_t* const builder, const mission_link_t* const link,
                                         const char* const words, const bool is_provided,
                                         uint16_t* const out_apid)
{
    const mission_descriptor_t* const mission = builder->mission;
    const size_t length                       = strcspn(words, ".");
    for (uint16_t s = 0U; (words[length] == '.') && (s < mission->subsystem_count); s++) {
        const mission_subsystem_t* const subsystem = &mission->subsystems[s];
        if ((strncmp(subsystem->name, words, length) != 0) || (subsystem->name[length] != '\0')) {
            continue;
        }
        if ((builder->only != 0U) && (builder->only != subsystem->apid)) {
            *out_apid = subsystem->apid;
            return &unknown_port;
        }
        const mission_port_t* const port = descriptor_named(subsystem->ports, subsystem->port_count,
                                                            sizeof subsystem->ports[0], &words[length + 1U]);
        if ((port != NULL) && (port->is_provided == is_provided)) { // So in all configurations.
            *out_apid = subsystem->apid;
            return port;
        }
    }
    refuse_name(&builder->source, link->line, is_provided ? "from" : "to", words,
                is_provided ? "Link>: expected SUBSYSTEM.PORT that it provides"
                            : "Link>: expected SUBSYSTEM.PORT that it requires");
    return NULL;
}

static void resolve_link(mission_builder_t* const builder, const uint16_t index)
{
    source_t* const source               = &builder->source;
    mission_link_t* const link           = &builder->mission->links[index];
    const char* const* const words       = builder->link_words[index];
    const mission_port_t* const producer = resolve_end(builder, link, words[0], true, &link->producer_apid);
    const mission_port_t* const consumer = resolve_end(builder, link, words[1], false, &link->consumer_apid);
    if ((producer == NULL) || (consumer == NULL)) {
        return;
    }
    link->producer_port = producer->id;
    link->consumer_port = consumer->id;
    link->is_required   = consumer->is_required;
    if ((producer == &unknown_port) || (consumer == &unknown_port)) {
        return; // Nothing to compare.
    }
    if (producer->layout_hash != consumer->layout_hash) {
        source_fail(source, link->line, "the layouts of the two ports differ");
    } else if ((producer->methods & consumer->methods) == 0U) {
        source_fail(source, link->line, "the two ports share no transfer method");
    }
}

static void resolve_rule(mission_builder_t* const builder, const uint16_t index)
{
    const mission_descriptor_t* const mission = builder->mission;
    mission_rule_t* const rule                = &builder->mission->rules[index];
    const char* const words                   = builder->rule_words[index];
    if (words == NULL) {
        return;
    }
    const mission_link_t* const link =
        descriptor_named(mission->links, mission->link_count, sizeof mission->links[0], words);
    if ((rule->service == SERVICE_LINKS) && (link != NULL)) {
        rule->number = link->number;
        return;
    }
    refuse_name(&builder->source, rule->line, "select", words,
                (rule->service == SERVICE_LINKS)       ? "Allow>: expected a link of the mission"
                : (rule->service == SERVICE_FUNCTIONS) ? "Allow>: expected a function of its target"
                                                       : "Allow>: expected a configuration of its target");
}

/// Continue a hash with the lines "NAME hash\n" of all subsystems.
static uint64_t hash_subsystems(uint64_t hash, const mission_descriptor_t* const mission,
                                const bool is_interface)
{
    for (uint16_t i = 0U; i < mission->subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &mission->subsystems[i];
        char line[96];
        uint8_t octets[8];
        text_t text = text_in(line, sizeof line);
        octets_put_u64(octets, is_interface ? subsystem->interface_hash : subsystem->configuration_hash);
        text_add(&text, subsystem->name);
        text_add(&text, " ");
        text_add_octets(&text, octets, sizeof octets);
        text_add(&text, "\n");
        hash = fnv64(hash, (const uint8_t*)line, text.length);
    }
    return hash;
}

status_t mission_builder_resolve(mission_builder_t* const builder)
{
    mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        resolve_link(builder, i);
    }
    for (uint16_t i = 0U; i < mission->rule_count; i++) {
        resolve_rule(builder, i);
    }
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        if (builder->plan_events[i] != NULL) {
            refuse_name(&builder->source, mission->plans[i].line, "event", builder->plan_events[i],
                        "Plan>: expected an event of that severity of that subsystem");
        }
    }
    if (builder->only == 0U) {
        mission->interface_hash     = hash_subsystems(FNV64_START, mission, true);
        mission->configuration_hash = hash_subsystems(mission->configuration_hash, mission, false);
    }
    return builder->source.status;
}
