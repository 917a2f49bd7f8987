// SPDX-License-Identifier: Apache-2.0
// The permitted contents of a mission descriptor, and their places in the model.
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

#define RING_RECORDS 4096U
#define MISSION_TIME_CUC 2U // The first word.

// ---- Lists ----

#define LIST(plural, counter, most, type)                                                                    \
    .items = offsetof(mission_descriptor_t, plural), .count = offsetof(mission_descriptor_t, counter),       \
    .capacity = (most), .size = sizeof(type), .line = offsetof(type, line)

const source_list_t descriptor_mission_subsystems = {
    .what = "subsystems", LIST(subsystems, subsystem_count, MISSION_SUBSYSTEMS_MAX, mission_subsystem_t)};
const source_list_t descriptor_mission_modes = {.what = "modes",
                                                LIST(modes, mode_count, MISSION_MODES_MAX, mission_mode_t)};
static const source_list_t users             = {.what = "users",
                                                LIST(users, user_count, MISSION_USERS_MAX, mission_user_t)};
static const source_list_t rules             = {.what = "<Allow>",
                                                LIST(rules, rule_count, MISSION_RULES_MAX, mission_rule_t)};
static const source_list_t links             = {.what = "links",
                                                LIST(links, link_count, MISSION_LINKS_MAX, mission_link_t)};
static const source_list_t plans             = {.what = "plans",
                                                LIST(plans, plan_count, MISSION_PLANS_MAX, mission_plan_t)};
static const source_list_t actions           = {.what = "actions",
                                                LIST(actions, action_count, MISSION_ACTIONS_MAX, mission_action_t),
                                                .first  = offsetof(mission_plan_t, first_action),
                                                .number = offsetof(mission_plan_t, action_count)};
static const source_list_t buses             = {.what = "buses",
                                                LIST(buses, bus_count, MISSION_BUSES_MAX, mission_bus_t)};

// ---- Attributes ----

#define NAMED_AS(case, type)                                                                                 \
    {                                                                                                        \
        .name = "name", .form = (case) | SOURCE_NEEDED | SOURCE_UNIQUE, .high = DESCRIPTOR_NAME_MAX,         \
        SOURCE_TO(type, name)                                                                                \
    }
#define NUMBERED(from, to, type, place)                                                                      \
    {                                                                                                        \
        .name = "id", .form = SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, .low = (from), .high = (to),  \
        SOURCE_TO(type, place)                                                                               \
    }
#define FREE(id)                                                                                             \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE                                                                    \
    }
#define FREE_NEEDED(id)                                                                                      \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE | SOURCE_NEEDED                                                    \
    }

static const source_attribute_t mission_attributes[] = {
    {.name = "name",
     .form = SOURCE_LOWER | SOURCE_NEEDED,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(mission_descriptor_t, name)},
    FREE_NEEDED("epoch"),
    {.name = "power",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .high = 1000000U,
     SOURCE_TO(mission_descriptor_t, power_available_w)},
    {.name      = "timeReports",
     .form      = SOURCE_WORD,
     .words     = "CUC CDS",
     .low       = MISSION_TIME_CUC,
     .otherwise = MISSION_TIME_CUC,
     SOURCE_TO(mission_descriptor_t, time_reports)},
};
static const source_attribute_t listed_attributes[] = {
    NAMED_AS(SOURCE_UPPER, mission_subsystem_t),
    NUMBERED(1U, 2046U, mission_subsystem_t, apid),
    {.name = "executable",
     .form = SOURCE_LOWER | SOURCE_NEEDED,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(mission_subsystem_t, executable)},
    {.name = "descriptor",
     .form = SOURCE_TEXT | SOURCE_NEEDED,
     .high = 127U,
     SOURCE_TO(mission_subsystem_t, descriptor)},
    {.name = "autostart", .form = SOURCE_FLAG, SOURCE_TO(mission_subsystem_t, is_autostart)},
    {.name = "memoryKiB",
     .form = SOURCE_UNSIGNED,
     .high = (uint32_t)1U << 24U,
     SOURCE_TO(mission_subsystem_t, memory_kib)},
    {.name = "restarts",
     .form = SOURCE_UNSIGNED,
     .high = 100U,
     SOURCE_TO(mission_subsystem_t, restart_budget)},
    {.name      = "bootTime",
     .form      = SOURCE_TIME,
     .low       = 500U,
     .high      = 60000000U,
     .otherwise = 50000U,
     SOURCE_TO(mission_subsystem_t, boot_time_us)},
    {.name = "restartPeriod",
     .form = SOURCE_TIME,
     .low  = 1000U,
     .high = 3600000000U,
     SOURCE_TO(mission_subsystem_t, restart_period_us)},
    {.name = "recommission", .form = SOURCE_FLAG, SOURCE_TO(mission_subsystem_t, is_recommissioned)},
    {.name = "deviceDeadline",
     .form = SOURCE_TIME,
     .low  = 1000U,
     .high = 1000000U,
     SOURCE_TO(mission_subsystem_t, device_deadline_us)},
    {.name      = "hangAfter",
     .form      = SOURCE_TIME,
     .low       = 1000U,
     .high      = 60000000U,
     .otherwise = 20000U,
     SOURCE_TO(mission_subsystem_t, hang_after_us)},
    {.name      = "supervisorPatience",
     .form      = SOURCE_TIME,
     .low       = 100000U,
     .high      = 3600000000U,
     .otherwise = 3000000U,
     SOURCE_TO(mission_subsystem_t, supervisor_patience_us)},
    {.name      = "node",
     .form      = SOURCE_UNSIGNED,
     .low       = 1U,
     .high      = MISSION_NODES_MAX,
     .otherwise = 1U,
     SOURCE_TO(mission_subsystem_t, node)},
};
static const source_attribute_t power_attributes[] = {
    FREE_NEEDED("state"),
    {.name = "watts", .form = SOURCE_UNSIGNED | SOURCE_NEEDED, .high = 100000U},
};
static const source_attribute_t mode_attributes[] = {
    NAMED_AS(SOURCE_UPPER, mission_mode_t),
    NUMBERED(0U, 7U, mission_mode_t, id),
    {.name = "initial", .form = SOURCE_FLAG, SOURCE_TO(mission_mode_t, is_initial)},
    {.name = "fallback", .form = SOURCE_FLAG, SOURCE_TO(mission_mode_t, is_fallback)},
};
static const source_attribute_t user_attributes[]  = {NAMED_AS(SOURCE_UPPER, mission_user_t),
                                                      NUMBERED(1U, 0x7FFFU, mission_user_t, id)};
static const source_attribute_t allow_attributes[] = {FREE_NEEDED("tc"), FREE("select"), FREE_NEEDED("to"),
                                                      FREE_NEEDED("modes"), FREE_NEEDED("states")};
static const source_attribute_t link_attributes[]  = {NAMED_AS(SOURCE_UPPER, mission_link_t),
                                                      FREE_NEEDED("from"), FREE_NEEDED("to")};
static const source_attribute_t plan_attributes[]  = {
     NAMED_AS(SOURCE_UPPER, mission_plan_t),
     {.name  = "severity",
      .form  = SOURCE_WORD | SOURCE_NEEDED,
      .words = DESCRIPTOR_SEVERITY_WORDS,
      .low   = DESCRIPTOR_INFORMATIVE,
      SOURCE_TO(mission_plan_t, severity)},
     FREE("subsystem"),
     FREE("event"),
};
static const source_attribute_t action_attributes[] = {
    {.name  = "do",
     .form  = SOURCE_WORD | SOURCE_NEEDED,
     .words = "STATE MODE LOG",
     SOURCE_TO(mission_action_t, kind)},
    FREE("target"),
    FREE("state"),
    FREE("mode"),
    {.name = "after", .form = SOURCE_TIME, .high = 600000000U, SOURCE_TO(mission_action_t, after_us)},
};
static const source_attribute_t packet_log_attributes[] = {
    {.name  = "strategy",
     .form  = SOURCE_WORD,
     .words = "ASCII SQLITE POSTGRESQL RING",
     SOURCE_TO(mission_descriptor_t, log_strategy)},
    {.name      = "ringRecords",
     .form      = SOURCE_UNSIGNED,
     .low       = 16U,
     .high      = CAPACITY_RING_RECORDS,
     .otherwise = RING_RECORDS,
     SOURCE_TO(mission_descriptor_t, log_ring_records)},
};
static const source_attribute_t bus_attributes[] = {
    NAMED_AS(SOURCE_LOWER, mission_bus_t),
    {.name = "redundantTo",
     .form = SOURCE_LOWER,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(mission_bus_t, redundant_to)},
    {.name = "bitRate",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 10000U,
     .high = 1000000U,
     SOURCE_TO(mission_bus_t, bit_rate)},
    {.name = "dataBitRate",
     .form = SOURCE_UNSIGNED,
     .low  = 10000U,
     .high = 8000000U,
     SOURCE_TO(mission_bus_t, data_bit_rate)},
};
static const source_attribute_t transports_attributes[] = {
    {.name      = "messages",
     .form      = SOURCE_WORD,
     .words     = DESCRIPTOR_METHOD_WORDS,
     .otherwise = DESCRIPTOR_UDP,
     SOURCE_TO(mission_descriptor_t, message_method)},
    {.name      = "links",
     .form      = SOURCE_WORD,
     .words     = DESCRIPTOR_METHOD_WORDS,
     .otherwise = DESCRIPTOR_SHARED_MEMORY,
     SOURCE_TO(mission_descriptor_t, link_method)},
};
static const source_attribute_t ground_attributes[] = {
    {.name  = "address", // This machine only, or every interface.
     .form  = SOURCE_WORD | SOURCE_NEEDED,
     .words = "127.0.0.1 0.0.0.0",
     SOURCE_TO(mission_descriptor_t, is_ground_open)},
    {.name = "port",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = 65535U,
     SOURCE_TO(mission_descriptor_t, ground_port)},
    {.name = "key", .form = SOURCE_TEXT, .high = 127U, SOURCE_TO(mission_descriptor_t, ground_key)},
};

// ---- Elements ----

#define WITH(name, attributes) SOURCE_COUNT(attributes), (name), (attributes)
#define PLAIN(name) 0U, (name), NULL

// Parent, kind, how often, name with attributes, list, start, end.
static const source_row_t rows[] = {
    {SOURCE_ROOT, MISSION_KIND_MISSION, SOURCE_ANY, WITH("Mission", mission_attributes), NULL,
     descriptor_mission_builder_mission, descriptor_mission_builder_end},
    {MISSION_KIND_MISSION, MISSION_KIND_SUBSYSTEMS, SOURCE_EXACTLY, PLAIN("Subsystems"), NULL, NULL, NULL},
    {MISSION_KIND_SUBSYSTEMS, MISSION_KIND_LISTED, SOURCE_ANY, WITH("Subsystem", listed_attributes),
     &descriptor_mission_subsystems, descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_LISTED, MISSION_KIND_POWER, SOURCE_ANY, WITH("Power", power_attributes), NULL,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_MODES, SOURCE_EXACTLY, PLAIN("Modes"), NULL, NULL,
     descriptor_mission_builder_whole},
    {MISSION_KIND_MODES, MISSION_KIND_MODE, SOURCE_ANY, WITH("Mode", mode_attributes),
     &descriptor_mission_modes, NULL, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_USERS, SOURCE_ONCE, PLAIN("Users"), NULL, NULL, NULL},
    {MISSION_KIND_USERS, MISSION_KIND_USER, SOURCE_ANY, WITH("User", user_attributes), &users, NULL, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_PERMISSIONS, SOURCE_EXACTLY, PLAIN("Permissions"), NULL,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_PERMISSIONS, MISSION_KIND_ALLOW, SOURCE_ANY, WITH("Allow", allow_attributes), &rules,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_LINKS, SOURCE_ONCE, PLAIN("Links"), NULL, NULL, NULL},
    {MISSION_KIND_LINKS, MISSION_KIND_LINK, SOURCE_ANY, WITH("Link", link_attributes), &links,
     descriptor_mission_builder_link, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_PLANS, SOURCE_ONCE, PLAIN("RecoveryPlans"), NULL,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_PLANS, MISSION_KIND_PLAN, SOURCE_ANY, WITH("Plan", plan_attributes), &plans,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_PLAN, MISSION_KIND_ACTION, SOURCE_SOME, WITH("Action", action_attributes), &actions,
     descriptor_mission_builder_whole, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_PACKET_LOG, SOURCE_ONCE, WITH("PacketLog", packet_log_attributes),
     NULL, NULL, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_BUSES, SOURCE_ONCE, PLAIN("Buses"), NULL, NULL,
     descriptor_mission_builder_whole},
    {MISSION_KIND_BUSES, MISSION_KIND_BUS, SOURCE_ANY, WITH("Bus", bus_attributes), &buses, NULL, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_TRANSPORTS, SOURCE_ONCE, WITH("Transports", transports_attributes),
     NULL, NULL, NULL},
    {MISSION_KIND_MISSION, MISSION_KIND_GROUND, SOURCE_EXACTLY, WITH("Ground", ground_attributes), NULL,
     descriptor_mission_builder_whole, NULL},
};

void descriptor_mission_builder_begin(mission_builder_t* const builder, mission_descriptor_t* const mission,
                                      const char* const path, const uint16_t apid,
                                      const mission_scope_t* const scope, text_t* const error)
{
    (void)memset(mission, 0, sizeof *mission);
    (void)memset(builder, 0, sizeof *builder);
    mission->name                 = "";
    mission->log_ring_records     = RING_RECORDS;
    mission->message_method       = DESCRIPTOR_UDP;
    mission->link_method          = DESCRIPTOR_SHARED_MEMORY;
    builder->mission              = mission;
    builder->scope                = scope;
    builder->only                 = apid;
    builder->source.path          = path;
    builder->source.error         = error;
    builder->source.rows          = rows;
    builder->source.row_count     = SOURCE_COUNT(rows);
    builder->source.items[0]      = mission;
    builder->source.text          = mission->text;
    builder->source.text_capacity = MISSION_TEXT_OCTETS;
    builder->source.text_used     = &mission->text_used;
    builder->source.builder       = builder;
}
