// SPDX-License-Identifier: Apache-2.0
// Work that only a reader of the whole mission does: it resolves the names in permissions and plans by the
// descriptors of all subsystems, and computes the mission's hashes.
#include "base/crc.h"
#include "fsw/framework/descriptor/mission_builder.h"

#define SERVICE_FUNCTIONS 8U
#define SERVICE_LINKS 130U

/// Resolve the name in a rule if it is a function or configuration of this subsystem.
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

/// Resolve all names in rules that are functions and configurations of this subsystem.
static void find_rule_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t i = 0U; i < builder->mission->rule_count; i++) {
        mission_rule_t* const rule = &builder->mission->storage.rules[i];
        const bool is_meant = (rule->target == MISSION_ANY_TARGET) || (rule->target == subsystem->apid);
        if ((builder->rule_words[i] != NULL) && is_meant && (rule->service != SERVICE_LINKS)) {
            builder->rule_words[i] = find_rule_name(rule, builder->rule_words[i], descriptor);
        }
    }
}

/// Resolve all names in plans that are events of this subsystem.
static void find_plan_names(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                            const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t i = 0U; i < builder->mission->plan_count; i++) {
        mission_plan_t* const plan = &builder->mission->storage.plans[i];
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

static void take(mission_builder_t* const builder, mission_subsystem_t* const subsystem,
                 const char* const path, const subsystem_descriptor_t* const descriptor)
{
    subsystem->interface_hash     = descriptor->interface_hash;
    subsystem->configuration_hash = descriptor->configuration_hash;
    descriptor_mission_copy_ports(&builder->source, subsystem, descriptor);
    descriptor_mission_check_buses(builder, subsystem, path, descriptor);
    find_rule_names(builder, subsystem, descriptor);
    find_plan_names(builder, subsystem, descriptor);
}

static void resolve_rule(mission_builder_t* const builder, const uint16_t index)
{
    const mission_descriptor_t* const mission = builder->mission;
    mission_rule_t* const rule                = &builder->mission->storage.rules[index];
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
    descriptor_mission_builder_refuse(
        &builder->source, rule->line, "select", words,
        (rule->service == SERVICE_LINKS)       ? "Allow>: expected a link of the mission"
        : (rule->service == SERVICE_FUNCTIONS) ? "Allow>: expected a function of its target"
                                               : "Allow>: expected a configuration of its target");
}

/// Check that a subsystem has a channel for each of its links, up to link number `link`.
static void check_room(mission_builder_t* const builder, const uint16_t link, const uint16_t apid)
{
    const mission_descriptor_t* const mission = builder->mission;
    uint32_t count                            = 0U;
    for (uint16_t i = 0U; i <= link; i++) {
        const bool is_of_subsystem =
            (mission->links[i].producer_apid == apid) || (mission->links[i].consumer_apid == apid);
        count += is_of_subsystem ? 1U : 0U;
    }
    if (count > CAPACITY_SUBSYSTEM_LINKS) {
        descriptor_source_refuse(
            &builder->source, mission->links[link].line, "too many links of %, at most #",
            descriptor_mission_find_subsystem(mission, apid)->name, NULL, CAPACITY_SUBSYSTEM_LINKS);
    }
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

static void resolve(mission_builder_t* const builder)
{
    mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        descriptor_mission_check_link(builder, i);
    }
    for (uint16_t i = 0U; (i < mission->link_count) && (builder->source.status == STATUS_OK); i++) {
        check_room(builder, i, mission->links[i].producer_apid);
        check_room(builder, i, mission->links[i].consumer_apid);
    }
    for (uint16_t i = 0U; i < mission->rule_count; i++) {
        resolve_rule(builder, i);
    }
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        if (builder->plan_events[i] != NULL) {
            descriptor_mission_builder_refuse(&builder->source, mission->plans[i].line, "event",
                                              builder->plan_events[i],
                                              "Plan>: expected an event of that severity of that subsystem");
        }
    }
    mission->interface_hash     = hash_subsystems(FNV64_START, mission, true);
    mission->configuration_hash = hash_subsystems(mission->configuration_hash, mission, false);
}

const mission_scope_t descriptor_mission_whole = {
    .element = descriptor_mission_check_element, .take = take, .resolve = resolve};
