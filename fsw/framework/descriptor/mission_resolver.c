// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc.h"
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

static void copy_configurations(source_t* const source, mission_subsystem_t* const subsystem,
                                const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t c = 0U; c < descriptor->configuration_count; c++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[c];
        if (!source_has_room(source, subsystem->configuration_count, MISSION_CONFIGURATIONS_MAX,
                             "configurations")) {
            return;
        }
        subsystem->configurations[subsystem->configuration_count] = (mission_configuration_t){
            .name = source_keep(source, configuration->name), .id = configuration->id};
        subsystem->configuration_count++;
        for (uint16_t i = 0U; i < configuration->port_count; i++) {
            const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
            uint8_t methods                     = 0U;
            for (uint8_t m = 0U; m < port->method_count; m++) {
                methods = (uint8_t)(methods | (1U << port->methods[m]));
            }
            if (!source_has_room(source, subsystem->port_count, MISSION_PORTS_MAX, "ports")) {
                return;
            }
            subsystem->ports[subsystem->port_count] =
                (mission_port_t){.name          = source_keep(source, port->name),
                                 .id            = port->id,
                                 .configuration = configuration->id,
                                 .is_provided   = port->is_provided,
                                 .is_required   = port->is_required,
                                 .layout_hash   = port->layout_hash,
                                 .methods       = methods};
            subsystem->port_count++;
        }
    }
}

/// Functions and configurations of this subsystem that rules name.
static void find_rule_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->rule_count; i++) {
        mission_rule_t* const rule = &mission->rules[i];
        const char* const words    = builder->rule_words[i];
        const bool is_meant = (rule->target == MISSION_ANY_TARGET) || (rule->target == subsystem->apid);
        if ((words == NULL) || !is_meant || (rule->service == 130U)) {
            continue;
        }
        for (uint16_t f = 0U; (rule->service == 8U) && (f < descriptor->function_count); f++) {
            builder->rule_words[i] =
                (strcmp(descriptor->functions[f].name, words) == 0) ? NULL : builder->rule_words[i];
        }
        for (uint16_t c = 0U; (rule->service == 129U) && (c < descriptor->configuration_count); c++) {
            if (strcmp(descriptor->configurations[c].name, words) == 0) {
                rule->number           = descriptor->configurations[c].id;
                builder->rule_words[i] = NULL;
            }
        }
    }
}

/// Events of this subsystem that plans name.
static void find_plan_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        const descriptor_event_t* const event =
            ((builder->plan_events[i] != NULL) && (mission->plans[i].apid == subsystem->apid))
                ? descriptor_find_event_name(descriptor, builder->plan_events[i])
                : NULL;
        if ((event != NULL) && (event->severity == mission->plans[i].severity)) {
            mission->plans[i].event_id = event->id;
            builder->plan_events[i]    = NULL;
        }
    }
}

static const mission_bus_t* find_bus(const mission_descriptor_t* const mission, const char* const name)
{
    for (uint16_t i = 0U; i < mission->bus_count; i++) {
        if (strcmp(mission->buses[i].name, name) == 0) {
            return &mission->buses[i];
        }
    }
    return NULL;
}

static void refuse_bus(source_t* const source, const uint32_t line, const char* const attribute,
                       const char* const found, const char* const expected)
{
    if (source_fail(source, line, attribute)) {
        text_add(source->error, "=\"");
        text_add(source->error, found);
        text_add(source->error, "\" of ");
        text_add(source->error, expected);
    }
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
            refuse_bus(source, bus->line, "redundantTo", bus->redundant_to,
                       "<Bus>: expected a bus of the mission that is not redundant itself and has one "
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
            refuse_bus(source, endnode->line, "bus", endnode->bus,
                       "<Endnode>: expected a bus of the mission");
        }
        const mission_bus_t* const redundant = find_bus(builder->mission, endnode->redundant_bus);
        const bool is_channel = (redundant != NULL) && (strcmp(redundant->redundant_to, endnode->bus) == 0);
        if ((endnode->redundant_bus[0] != '\0') && !is_channel) {
            source->path = path;
            refuse_bus(source, endnode->line, "redundantBus", endnode->redundant_bus,
                       "<Endnode>: expected a bus of the mission that is redundantTo its bus");
        }
    }
}

status_t mission_builder_take(mission_builder_t* const builder, const uint16_t index, const char* const path,
                              const subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT((builder != NULL) && (index < builder->mission->subsystem_count) && (descriptor != NULL));
    mission_subsystem_t* const subsystem = &builder->mission->subsystems[index];
    source_t* const source               = &builder->source;
    source->line                         = subsystem->line;
    if ((strcmp(subsystem->name, descriptor->name) != 0) || (subsystem->apid != descriptor->apid)) {
        if (source_fail(source, subsystem->line, subsystem->name)) {
            text_add(source->error, " ");
            text_add_unsigned(source->error, subsystem->apid);
            text_add(source->error, ": its descriptor says ");
            text_add(source->error, descriptor->name);
            text_add(source->error, " ");
            text_add_unsigned(source->error, descriptor->apid);
        }
        return source->status;
    }
    subsystem->interface_hash     = descriptor->interface_hash;
    subsystem->configuration_hash = descriptor->configuration_hash;
    copy_configurations(source, subsystem, descriptor);
    find_rule_names(builder, subsystem, descriptor);
    find_plan_names(builder, subsystem, descriptor);
    check_buses(builder, path, descriptor);
    return source->status;
}

/// Port of SUBSYSTEM.PORT on the side wanted, or NULL after an error.
static const mission_port_t* resolve_end(source_t* const source, const mission_descriptor_t* const mission,
                                         const mission_link_t* const link, const char* const words,
                                         const bool is_provided, uint16_t* const out_apid)
{
    const size_t length = strcspn(words, ".");
    for (uint16_t s = 0U; s < mission->subsystem_count; s++) {
        const mission_subsystem_t* const subsystem = &mission->subsystems[s];
        if ((strncmp(subsystem->name, words, length) != 0) || (subsystem->name[length] != '\0') ||
            (words[length] != '.')) {
            continue;
        }
        for (uint16_t p = 0U; p < subsystem->port_count; p++) {
            if ((strcmp(subsystem->ports[p].name, &words[length + 1U]) == 0) &&
                (subsystem->ports[p].is_provided == is_provided)) {
                *out_apid = subsystem->apid;
                return &subsystem->ports[p];
            }
        }
    }
    if (source_fail(source, link->line, is_provided ? "from=\"" : "to=\"")) {
        text_add(source->error, words);
        text_add(source->error, is_provided ? "\" of <Link>: expected SUBSYSTEM.PORT that it provides"
                                            : "\" of <Link>: expected SUBSYSTEM.PORT that it requires");
    }
    return NULL;
}

static void resolve_link(mission_builder_t* const builder, const uint16_t index)
{
    source_t* const source         = &builder->source;
    mission_link_t* const link     = &builder->mission->links[index];
    const char* const* const words = builder->link_words[index];
    const mission_port_t* const producer =
        resolve_end(source, builder->mission, link, words[0], true, &link->producer_apid);
    const mission_port_t* const consumer =
        resolve_end(source, builder->mission, link, words[1], false, &link->consumer_apid);
    if ((producer == NULL) || (consumer == NULL)) {
        return;
    }
    link->producer_port = producer->id;
    link->consumer_port = consumer->id;
    link->is_required   = consumer->is_required;
    if (producer->layout_hash != consumer->layout_hash) {
        (void)source_fail(source, link->line, "the layouts of the two ports differ");
    } else if ((producer->methods & consumer->methods) == 0U) {
        (void)source_fail(source, link->line, "the two ports share no transfer method");
    }
}

static void resolve_rule(mission_builder_t* const builder, const uint16_t index)
{
    mission_rule_t* const rule = &builder->mission->rules[index];
    for (uint16_t i = 0U; (rule->service == 130U) && (builder->rule_words[index] != NULL) &&
                          (i < builder->mission->link_count);
         i++) {
        if (strcmp(builder->mission->links[i].name, builder->rule_words[index]) == 0) {
            rule->number               = builder->mission->links[i].number;
            builder->rule_words[index] = NULL;
        }
    }
    if ((builder->rule_words[index] != NULL) && source_fail(&builder->source, rule->line, "select=\"")) {
        text_add(builder->source.error, builder->rule_words[index]);
        text_add(builder->source.error,
                 (rule->service == 130U) ? "\" of <Allow>: expected a link of the mission"
                 : (rule->service == 8U) ? "\" of <Allow>: expected a function of its target"
                                         : "\" of <Allow>: expected a configuration of its target");
    }
}

/// Continue a hash with the lines "NAME hash\n" of all subsystems.
static uint64_t hash_subsystems(uint64_t hash, const mission_descriptor_t* const mission,
                                const bool is_interface)
{
    for (uint16_t i = 0U; i < mission->subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &mission->subsystems[i];
        const uint64_t own = is_interface ? subsystem->interface_hash : subsystem->configuration_hash;
        char line[96];
        uint8_t octets[8];
        text_t text           = text_in(line, sizeof line);
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_u64(&writer, own);
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
    FSW_ASSERT(builder != NULL);
    mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        resolve_link(builder, i);
    }
    for (uint16_t i = 0U; i < mission->rule_count; i++) {
        resolve_rule(builder, i);
    }
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        if ((builder->plan_events[i] != NULL) &&
            source_fail(&builder->source, mission->plans[i].line, "event=\"")) {
            text_add(builder->source.error, builder->plan_events[i]);
            text_add(builder->source.error,
                     "\" of <Plan>: expected an event of that severity of that subsystem");
        }
    }
    mission->interface_hash     = hash_subsystems(FNV64_START, mission, true);
    mission->configuration_hash = hash_subsystems(mission->configuration_hash, mission, false);
    return builder->source.status;
}
