// SPDX-License-Identifier: Apache-2.0
/// Builds the model of a mission descriptor while its elements are read, then resolves its names through the
/// descriptors of its subsystems. Internal to descriptor/.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H
#define FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H

#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/descriptor/source.h"

typedef struct mission_builder mission_builder_t;

struct mission_scope { // Functions that only a reader of the whole mission needs.
    /// Handler of the elements that only such a reader processes: subsystems, power, modes, permissions,
    /// plans, buses, ground.
    void (*element)(source_t* source);
    /// Called when a descriptor, read from `path`, was added to the model.
    void (*take)(mission_builder_t* builder, mission_subsystem_t* subsystem, const char* path,
                 const subsystem_descriptor_t* descriptor);
    void (*resolve)(mission_builder_t* builder); ///< Called when all descriptors were added.
};

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

struct mission_builder {
    source_t source;
    mission_descriptor_t* mission;
    const mission_scope_t* scope; ///< NULL: only subsystem `only` is read.
    uint16_t only;                ///< APID of that subsystem.
    /// Bit n: the power of state n is defined for the subsystem that is being read.
    uint16_t power_seen;
    /// Function or configuration whose number is not known yet, or NULL.
    const char* rule_words[MISSION_RULES_MAX];
    const mission_subsystem_t* bus_owners[MISSION_BUSES_MAX]; ///< Subsystem with the devices of each bus.
    /// Ports whose numbers are not known yet: producer, consumer.
    const char* link_words[MISSION_LINKS_MAX][2];
    const char* plan_events[MISSION_PLANS_MAX]; ///< Event whose number is not known yet, or NULL.
};

/// Clear the model and begin to read a document. The builder must outlive the document and its resolution.
/// Without a scope only subsystem `apid` will be read, and elements that need other subsystems are dropped.
void descriptor_mission_builder_begin(mission_builder_t* builder, mission_descriptor_t* mission,
                                      const char* path, uint16_t apid, const mission_scope_t* scope,
                                      text_t* error);
/// Add the descriptor of subsystem `index`, read from `path`. STATUS_OK, or the error of the source.
MUST_USE status_t descriptor_mission_builder_take(mission_builder_t* builder, uint16_t index,
                                                  const char* path, const subsystem_descriptor_t* descriptor);
/// Call when all descriptors were read: resolve every name. Statuses of descriptor_mission_builder_take.
MUST_USE status_t descriptor_mission_builder_resolve(mission_builder_t* builder);

// Lists of names that attributes use: mission_elements.c
extern const source_list_t descriptor_mission_subsystems;
extern const source_list_t descriptor_mission_modes;
#define MISSION_SUBSYSTEM_WORDS                                                                              \
    ((MISSION_SUBSYSTEMS_MAX + 1U) * (DESCRIPTOR_NAME_MAX + 1U)) ///< Includes room for " SELF NETWORK".
#define MISSION_MODE_WORDS (MISSION_MODES_MAX * (DESCRIPTOR_NAME_MAX + 1U))

static inline mission_builder_t* descriptor_mission_builder_of(const source_t* const source)
{
    return source->builder;
}

// Handlers: mission_builder.c
void descriptor_mission_builder_mission(source_t* source);
void descriptor_mission_builder_whole(source_t* source); ///< Call `element` of the scope, if any.
void descriptor_mission_builder_end(source_t* source);
void descriptor_mission_builder_link(source_t* source); // mission_resolver.c
/// Report that the words of an attribute do not name an item of the expected kind; `expected` begins with
/// the element's name.
void descriptor_mission_builder_refuse(source_t* source, uint32_t line, const char* attribute,
                                       const char* words, const char* expected);
// Checks of the whole mission: mission_checks.c
void descriptor_mission_check_element(source_t* source);
void descriptor_mission_copy_ports(source_t* source, mission_subsystem_t* subsystem,
                                   const subsystem_descriptor_t* descriptor);
/// Check that every bus that an end node names is a bus of the mission, and that the redundant bus of the end
/// node is channel B of that bus.
void descriptor_mission_check_buses(mission_builder_t* builder, const mission_subsystem_t* subsystem,
                                    const char* path, const subsystem_descriptor_t* descriptor);
/// Check that both ends of a link are ports that fit each other. The links before this one have been checked.
void descriptor_mission_check_link(mission_builder_t* builder, uint16_t index);
// Handlers of permissions and plans: mission_rules.c
void descriptor_mission_rules_allow(source_t* source);
void descriptor_mission_rules_plan(source_t* source);
void descriptor_mission_rules_action(source_t* source);

#endif // FSW_FRAMEWORK_DESCRIPTOR_MISSION_BUILDER_H
