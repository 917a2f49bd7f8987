// SPDX-License-Identifier: Apache-2.0
/// Builds the model of a mission descriptor while its elements are read, then resolves its names through the
/// descriptors of its subsystems. Internal to descriptor/.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H
#define FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H

#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/descriptor/source.h"

typedef struct {
    source_t source;
    mission_descriptor_t* mission;
    uint32_t seen;                                ///< Bit n: the element of kind n has been read.
    uint16_t power_seen;                          ///< Bit n: power of state n of the subsystem being read.
    const char* rule_words[MISSION_RULES_MAX];    ///< Function or configuration still to be found, or NULL.
    const char* link_words[MISSION_LINKS_MAX][2]; ///< Ports still to be found: producer, consumer.
    const char* plan_events[MISSION_PLANS_MAX];   ///< Event still to be found, or NULL.
} mission_builder_t;

enum { // Kinds of elements.
    MISSION_KIND_MISSION = 1,
    MISSION_KIND_SUBSYSTEMS,
    MISSION_KIND_LISTED,
    MISSION_KIND_POWER,
    MISSION_KIND_MODES,
    MISSION_KIND_MODE,
    MISSION_KIND_USERS,
    MISSION_KIND_USER,
    MISSION_KIND_PERMISSIONS,
    MISSION_KIND_ALLOW,
    MISSION_KIND_LINKS,
    MISSION_KIND_LINK,
    MISSION_KIND_PLANS,
    MISSION_KIND_PLAN,
    MISSION_KIND_ACTION,
    MISSION_KIND_PACKET_LOG,
    MISSION_KIND_BUSES,
    MISSION_KIND_BUS,
    MISSION_KIND_TRANSPORTS,
    MISSION_KIND_GROUND
};

/// Empty the model and begin. The builder outlives the document and its resolution.
void mission_builder_begin(mission_builder_t* builder, mission_descriptor_t* mission, const char* path,
                           text_t* error);

/// Take in the descriptor of subsystem `index`, read from `path`. STATUS_OK, or the error of the source.
MUST_USE status_t mission_builder_take(mission_builder_t* builder, uint16_t index, const char* path,
                                       const subsystem_descriptor_t* descriptor);
/// All descriptors are taken in: every name must have been found. Statuses as above.
MUST_USE status_t mission_builder_resolve(mission_builder_t* builder);

// Handlers of permissions, links and plans: mission_rules.c
void mission_rules_allow(source_t* source);
void mission_rules_link(source_t* source);
void mission_rules_plan(source_t* source);
void mission_rules_plan_end(source_t* source);
void mission_rules_action(source_t* source);

mission_builder_t* mission_builder_of(source_t* source);
/// Names that an attribute may give: modes or subsystems of the mission. Returns their number.
uint32_t mission_builder_mode_names(const mission_descriptor_t* mission, const char** out_names);
uint32_t mission_builder_subsystem_names(const mission_descriptor_t* mission, const char** out_names);
void mission_builder_taken(source_t* source, const char* attribute, uint32_t line);

#endif // FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H
