// SPDX-License-Identifier: Apache-2.0
// The permitted contents of a mission descriptor, and the members of the model that store them.
#include "fsw/framework/descriptor/mission_builder.h"

#include "osal/include/osal/can_interface.h"

#include <string.h>

#define RING_RECORDS 4096U
#define MISSION_TIME_CUC 2U // Number of the first word of the attribute timeReports.

// ---- Lists ----

#define LIST(plural, counter, most, type)                                                                    \
    .items = offsetof(mission_descriptor_t, storage.plural),                                                 \
    .count = offsetof(mission_descriptor_t, counter), .capacity = CAPACITY_OF_STORAGE(most),                 \
    .size = sizeof(type), .line = offsetof(type, line)

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

static const source_attribute_t mission_attributes[] = {
    SOURCE_STRING("name", SOURCE_LOWER | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, mission_descriptor_t, name),
    SOURCE_REQUIRED("epoch"),
    SOURCE_WITHIN("power", SOURCE_UNSIGNED | SOURCE_NEEDED, 0U, 1000000U, 0U, mission_descriptor_t,
                  power_available_w),
    SOURCE_CHOICE("timeReports", SOURCE_WORD, "CUC CDS", MISSION_TIME_CUC, MISSION_TIME_CUC,
                  mission_descriptor_t, time_reports),
};
static const source_attribute_t listed_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, mission_subsystem_t),
    SOURCE_NUMBERED(1U, 2046U, mission_subsystem_t, apid),
    SOURCE_STRING("executable", SOURCE_LOWER | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, mission_subsystem_t,
                  executable),
    SOURCE_STRING("descriptor", SOURCE_TEXT | SOURCE_NEEDED, 127U, mission_subsystem_t, descriptor),
    SOURCE_SWITCH("autostart", 0U, mission_subsystem_t, is_autostart),
    SOURCE_WITHIN("memoryKiB", SOURCE_UNSIGNED, 0U, (uint32_t)1U << 24U, 0U, mission_subsystem_t, memory_kib),
    SOURCE_WITHIN("restarts", SOURCE_UNSIGNED, 0U, 100U, 0U, mission_subsystem_t, restart_budget),
    SOURCE_WITHIN("bootTime", SOURCE_TIME, 500U, 60000000U, 50000U, mission_subsystem_t, boot_time_us),
    SOURCE_WITHIN("restartPeriod", SOURCE_TIME, 1000U, 3600000000U, 0U, mission_subsystem_t,
                  restart_period_us),
    SOURCE_SWITCH("recommission", 0U, mission_subsystem_t, is_recommissioned),
    SOURCE_WITHIN("deviceDeadline", SOURCE_TIME, 1000U, 1000000U, 0U, mission_subsystem_t,
                  device_deadline_us),
    SOURCE_WITHIN("hangAfter", SOURCE_TIME, 1000U, 60000000U, 20000U, mission_subsystem_t, hang_after_us),
    SOURCE_WITHIN("supervisorTimeout", SOURCE_TIME, 100000U, 3600000000U, 3000000U, mission_subsystem_t,
                  supervisor_timeout_us),
    SOURCE_WITHIN("node", SOURCE_UNSIGNED, 1U, MISSION_COMPUTERS_MAX, 1U, mission_subsystem_t, computer),
};
static const source_attribute_t power_attributes[] = {
    SOURCE_REQUIRED("state"),
    {.name = "watts", .form = SOURCE_UNSIGNED | SOURCE_NEEDED, .high = 100000U},
};
static const source_attribute_t mode_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, mission_mode_t),
    SOURCE_NUMBERED(0U, 7U, mission_mode_t, id),
    SOURCE_SWITCH("initial", 0U, mission_mode_t, is_initial),
    SOURCE_SWITCH("fallback", 0U, mission_mode_t, is_fallback),
};
static const source_attribute_t user_attributes[]  = {SOURCE_NAMED(SOURCE_UPPER, mission_user_t),
                                                      SOURCE_NUMBERED(1U, 0x7FFFU, mission_user_t, id)};
static const source_attribute_t allow_attributes[] = {SOURCE_REQUIRED("tc"), SOURCE_OPTION("select"),
                                                      SOURCE_REQUIRED("to"), SOURCE_REQUIRED("modes"),
                                                      SOURCE_REQUIRED("states")};
static const source_attribute_t link_attributes[]  = {SOURCE_NAMED(SOURCE_UPPER, mission_link_t),
                                                      SOURCE_REQUIRED("from"), SOURCE_REQUIRED("to")};
static const source_attribute_t plan_attributes[]  = {
     SOURCE_NAMED(SOURCE_UPPER, mission_plan_t),
     SOURCE_CHOICE("severity", SOURCE_WORD | SOURCE_NEEDED, DESCRIPTOR_SEVERITY_WORDS, DESCRIPTOR_INFORMATIVE,
                   0U, mission_plan_t, severity),
     SOURCE_OPTION("subsystem"),
     SOURCE_OPTION("event"),
};
static const source_attribute_t action_attributes[] = {
    SOURCE_CHOICE("do", SOURCE_WORD | SOURCE_NEEDED, "STATE MODE LOG", 0U, 0U, mission_action_t, kind),
    SOURCE_OPTION("target"),
    SOURCE_OPTION("state"),
    SOURCE_OPTION("mode"),
    SOURCE_WITHIN("after", SOURCE_TIME, 0U, 600000000U, 0U, mission_action_t, after_us),
};
static const source_attribute_t packet_log_attributes[] = {
    SOURCE_CHOICE("strategy", SOURCE_WORD, "ASCII SQLITE POSTGRESQL RING", 0U, 0U, mission_descriptor_t,
                  log_strategy),
    SOURCE_WITHIN("ringRecords", SOURCE_UNSIGNED, 16U, CAPACITY_RING_RECORDS, RING_RECORDS,
                  mission_descriptor_t, log_ring_records),
};
static const source_attribute_t bus_attributes[] = {
    SOURCE_STRING("name", SOURCE_LOWER | SOURCE_NEEDED | SOURCE_UNIQUE, OSAL_CAN_INTERFACE_NAME_MAX,
                  mission_bus_t, name),
    SOURCE_STRING("redundantTo", SOURCE_LOWER, OSAL_CAN_INTERFACE_NAME_MAX, mission_bus_t, redundant_to),
    SOURCE_WITHIN("bitRate", SOURCE_UNSIGNED | SOURCE_NEEDED, 10000U, 1000000U, 0U, mission_bus_t, bit_rate),
    SOURCE_WITHIN("dataBitRate", SOURCE_UNSIGNED, 10000U, 8000000U, 0U, mission_bus_t, data_bit_rate),
};
static const source_attribute_t transports_attributes[] = {
    SOURCE_CHOICE("messages", SOURCE_WORD, DESCRIPTOR_METHOD_WORDS, 0U, DESCRIPTOR_UDP, mission_descriptor_t,
                  message_method),
    SOURCE_CHOICE("links", SOURCE_WORD, DESCRIPTOR_METHOD_WORDS, 0U, DESCRIPTOR_SHARED_MEMORY,
                  mission_descriptor_t, link_method),
};
static const source_attribute_t ground_attributes[] = {
    {.name  = "address", // The port accepts connections from this machine only, or on every interface.
     .form  = SOURCE_WORD | SOURCE_NEEDED,
     .words = "127.0.0.1 0.0.0.0",
     SOURCE_TO(mission_descriptor_t, is_ground_open)},
    SOURCE_WITHIN("port", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 65535U, 0U, mission_descriptor_t, ground_port),
    SOURCE_STRING("key", SOURCE_TEXT, 127U, mission_descriptor_t, ground_key),
};

// ---- Elements ----

#define WITH(name, attributes) SOURCE_COUNT(attributes), (name), (attributes)
#define PLAIN(name) 0U, (name), NULL

// Parent, kind, number of occurrences, name with attributes, list, start handler, end handler.
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
    descriptor_mission_clear(mission);
    (void)memset(builder, 0, sizeof *builder);
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
    builder->source.text          = mission->storage.text;
    builder->source.text_capacity = sizeof mission->storage.text;
    builder->source.text_used     = &mission->text_used;
    builder->source.builder       = builder;
}
