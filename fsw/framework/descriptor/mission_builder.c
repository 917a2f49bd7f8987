// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc.h"

#include <string.h>

#define EPOCH_FIRST_YEAR 1958U
#define EPOCH_LAST_YEAR 2093U

static const char* const method_names[DESCRIPTOR_METHODS] = {"SHARED_MEMORY", "TIPC", "UDP", "STREAM",
                                                             "MESSAGE_QUEUE"};

mission_builder_t* mission_builder_of(source_t* const source)
{
    return source->builder;
}

static mission_descriptor_t* model(source_t* const source)
{
    return mission_builder_of(source)->mission;
}

void mission_builder_taken(source_t* const source, const char* const attribute, const uint32_t line)
{
    if (source_fail(source, source->line, STATUS_INVALID, attribute)) {
        text_add(source->error, " ");
        text_add(source->error, source_raw(source, attribute));
        text_add(source->error, " is taken in line ");
        text_add_unsigned(source->error, line);
    }
}

uint32_t mission_builder_mode_names(const mission_descriptor_t* const mission, const char** const out_names)
{
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        out_names[i] = mission->modes[i].name;
    }
    return mission->mode_count;
}

uint32_t mission_builder_subsystem_names(const mission_descriptor_t* const mission,
                                         const char** const out_names)
{
    for (uint16_t i = 0U; i < mission->subsystem_count; i++) {
        out_names[i] = mission->subsystems[i].name;
    }
    return mission->subsystem_count;
}

/// Refuse a second element of a kind.
static void once(source_t* const source)
{
    mission_builder_t* const builder = source->builder;
    const source_row_t* const row    = source->open[source->depth - 1U];
    if ((((builder->seen >> row->kind) & 1U) != 0U) &&
        source_fail(source, source->line, STATUS_INVALID, "a second <")) {
        text_add(source->error, row->name);
        text_add(source->error, ">");
    }
    builder->seen |= (uint32_t)1U << row->kind;
}

/// Number of `count` digits, or UINT32_MAX.
static uint32_t digits(const char* const words, const uint32_t count)
{
    uint32_t number = 0U;
    for (uint32_t i = 0U; i < count; i++) {
        if ((words[i] < '0') || (words[i] > '9')) {
            return UINT32_MAX;
        }
        number = (number * 10U) + (uint32_t)(words[i] - '0');
    }
    return number;
}

static bool is_leap(const uint32_t year)
{
    return ((year % 4U) == 0U) && (((year % 100U) != 0U) || ((year % 400U) == 0U));
}

/// Days from 1958-01-01, or UINT32_MAX if there is no such day.
static uint32_t days_of(const uint32_t year, const uint32_t month, const uint32_t day)
{
    static const uint8_t lengths[] = {31U, 28U, 31U, 30U, 31U, 30U, 31U, 31U, 30U, 31U, 30U, 31U};
    if ((year < EPOCH_FIRST_YEAR) || (year > EPOCH_LAST_YEAR) || (month < 1U) || (month > 12U) ||
        (day < 1U) || (day > (lengths[month - 1U] + (((month == 2U) && is_leap(year)) ? 1U : 0U)))) {
        return UINT32_MAX;
    }
    uint32_t days = day - 1U;
    for (uint32_t y = EPOCH_FIRST_YEAR; y < year; y++) {
        days += is_leap(y) ? 366U : 365U;
    }
    for (uint32_t m = 1U; m < month; m++) {
        days += lengths[m - 1U] + (((m == 2U) && is_leap(year)) ? 1U : 0U);
    }
    return days;
}

/// TAI seconds since 1958-01-01 of a time like 2026-06-01T12:00:00.
static uint32_t read_epoch(source_t* const source)
{
    static const char shape[] = "0000-00-00T00:00:00";
    const char* const words   = source_raw(source, "epoch");
    bool is_right             = (strlen(words) == (sizeof shape - 1U));
    for (size_t i = 0U; is_right && (i < (sizeof shape - 1U)); i++) {
        is_right = (shape[i] == '0') || (shape[i] == words[i]);
    }
    if (is_right) {
        const uint32_t days   = days_of(digits(words, 4U), digits(&words[5], 2U), digits(&words[8], 2U));
        const uint32_t hour   = digits(&words[11], 2U);
        const uint32_t minute = digits(&words[14], 2U);
        const uint32_t second = digits(&words[17], 2U);
        if ((days != UINT32_MAX) && (hour < 24U) && (minute < 60U) && (second < 60U)) {
            return (((((days * 24U) + hour) * 60U) + minute) * 60U) + second;
        }
    }
    source_wrong(source, "epoch", "a TAI time like 2026-06-01T12:00:00, years 1958 to 2093");
    return 0U;
}

static void start_mission(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    mission->name                       = source_lower_identifier(source, "name");
    mission->epoch_s                    = read_epoch(source);
    mission->power_available_w          = source_unsigned(source, "power", 0U, 1000000U, 0U);
}

static void start_listed(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    if (!source_has_room(source, mission->subsystem_count, MISSION_SUBSYSTEMS_MAX, "subsystems")) {
        return;
    }
    mission_subsystem_t* const subsystem = &mission->subsystems[mission->subsystem_count];
    *subsystem =
        (mission_subsystem_t){.name           = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                              .apid           = (uint16_t)source_unsigned(source, "id", 1U, 2046U, 0U),
                              .executable     = source_lower_identifier(source, "executable"),
                              .descriptor     = source_text(source, "descriptor", 127U),
                              .is_autostart   = source_flag(source, "autostart", false),
                              .memory_kib     = source_unsigned(source, "memoryKiB", 0U, 1U << 24U, 0U),
                              .restart_budget = (uint8_t)source_unsigned(source, "restarts", 0U, 100U, 0U),
                              .node = (uint8_t)source_unsigned(source, "node", 1U, MISSION_NODES_MAX, 1U),
                              .line = source->line};
    for (uint16_t i = 0U; i < mission->subsystem_count; i++) {
        if (strcmp(mission->subsystems[i].name, subsystem->name) == 0) {
            mission_builder_taken(source, "name", mission->subsystems[i].line);
        } else if (mission->subsystems[i].apid == subsystem->apid) {
            mission_builder_taken(source, "id", mission->subsystems[i].line);
        }
    }
    mission->subsystem_count++;
    mission_builder_of(source)->power_seen = 0U;
}

static void start_power(source_t* const source)
{
    mission_builder_t* const builder = source->builder;
    mission_subsystem_t* const subsystem =
        &builder->mission->subsystems[builder->mission->subsystem_count - 1U];
    uint8_t state = 0U;
    if (descriptor_state_of(source_raw(source, "state"), &state) != STATUS_OK) {
        source_wrong(source, "state", "the name of a state");
        return;
    }
    if ((((uint32_t)builder->power_seen >> state) & 1U) != 0U) {
        source_wrong(source, "state", "each state once");
    }
    builder->power_seen       = (uint16_t)(builder->power_seen | (1U << state));
    subsystem->power_w[state] = source_unsigned(source, "watts", 0U, 100000U, 0U);
}

static void start_mode(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    if (!source_has_room(source, mission->mode_count, MISSION_MODES_MAX, "modes")) {
        return;
    }
    mission_mode_t* const mode = &mission->modes[mission->mode_count];
    *mode = (mission_mode_t){.name       = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                             .id         = (uint8_t)source_unsigned(source, "id", 0U, 7U, 0U),
                             .is_initial = source_flag(source, "initial", false),
                             .line       = source->line};
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        if (strcmp(mission->modes[i].name, mode->name) == 0) {
            mission_builder_taken(source, "name", mission->modes[i].line);
        } else if (mission->modes[i].id == mode->id) {
            mission_builder_taken(source, "id", mission->modes[i].line);
        }
    }
    mission->mode_count++;
}

static void end_modes(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    uint32_t initial                    = 0U;
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        if (mission->modes[i].is_initial) {
            mission->initial_mode = mission->modes[i].id;
            initial++;
        }
    }
    if (initial != 1U) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          "exactly one <Mode> must have initial=\"true\"");
    }
}

static void start_user(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    if (!source_has_room(source, mission->user_count, MISSION_USERS_MAX, "users")) {
        return;
    }
    mission_user_t* const user = &mission->users[mission->user_count];
    user->name                 = source_identifier(source, "name", DESCRIPTOR_NAME_MAX);
    user->id                   = (uint16_t)source_unsigned(source, "id", 1U, 0x7FFFU, 0U);
    for (uint16_t i = 0U; i < mission->user_count; i++) {
        if ((strcmp(mission->users[i].name, user->name) == 0) || (mission->users[i].id == user->id)) {
            source_wrong(source, "name", "each name and id of a user once");
        }
    }
    mission->user_count++;
}

static void start_packet_log(source_t* const source)
{
    static const char* const strategies[] = {"ASCII", "SQLITE", "POSTGRESQL", "RING"};
    mission_descriptor_t* const mission   = model(source);
    once(source);
    mission->log_strategy = (mission_log_t)source_word(source, "strategy", strategies, 4U, 0U);
    mission->log_ring_records =
        source_unsigned(source, "ringRecords", 16U, 1000000U, mission->log_ring_records);
}

static void start_bus(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    if (!source_has_room(source, mission->bus_count, MISSION_BUSES_MAX, "buses")) {
        return;
    }
    mission_bus_t* const bus = &mission->buses[mission->bus_count];
    *bus                     = (mission_bus_t){.name          = source_lower_identifier(source, "name"),
                                               .bit_rate      = source_unsigned(source, "bitRate", 10000U, 1000000U, 0U),
                                               .data_bit_rate = source_unsigned(source, "dataBitRate", 10000U, 8000000U, 0U),
                                               .line          = source->line};
    for (uint16_t i = 0U; i < mission->bus_count; i++) {
        if (strcmp(mission->buses[i].name, bus->name) == 0) {
            mission_builder_taken(source, "name", mission->buses[i].line);
        }
    }
    mission->bus_count++;
}

static void start_transports(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    once(source);
    mission->message_method =
        (uint8_t)source_word(source, "messages", method_names, DESCRIPTOR_METHODS, mission->message_method);
    mission->link_method =
        (uint8_t)source_word(source, "links", method_names, DESCRIPTOR_METHODS, mission->link_method);
}

static void start_ground(source_t* const source)
{
    mission_descriptor_t* const mission = model(source);
    once(source);
    mission->ground_address = source_text(source, "address", 63U);
    mission->ground_port    = (uint16_t)source_unsigned(source, "port", 1U, 65535U, 0U);
}

/// What stands further up in the file is used further down, so its list must be there.
static void start_permissions(source_t* const source)
{
    const mission_descriptor_t* const mission = model(source);
    once(source);
    if ((mission->subsystem_count == 0U) || (mission->mode_count == 0U)) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          "expected <Subsystems> and <Modes>, not empty, before <Permissions>");
    }
}

static void start_plans(source_t* const source)
{
    const mission_descriptor_t* const mission = model(source);
    once(source);
    if ((mission->subsystem_count == 0U) || (mission->mode_count == 0U)) {
        (void)source_fail(source, source->line, STATUS_INVALID,
                          "expected <Subsystems> and <Modes>, not empty, before <RecoveryPlans>");
    }
}

static void end_mission(source_t* const source)
{
    static const uint8_t needed[]    = {MISSION_KIND_SUBSYSTEMS, MISSION_KIND_MODES, MISSION_KIND_PERMISSIONS,
                                        MISSION_KIND_GROUND};
    static const char* const names[] = {"Subsystems", "Modes", "Permissions", "Ground"};
    mission_builder_t* const builder = source->builder;
    for (size_t i = 0U; i < sizeof needed; i++) {
        if ((((builder->seen >> needed[i]) & 1U) == 0U) &&
            source_fail(source, source->line, STATUS_INVALID, "<Mission> has no <")) {
            text_add(source->error, names[i]);
            text_add(source->error, ">");
        }
    }
    builder->mission->configuration_hash = source->hash;
}

static const source_row_t rows[] = {
    {SOURCE_ROOT, "Mission", MISSION_KIND_MISSION, "name! epoch! power!", start_mission, end_mission},
    {MISSION_KIND_MISSION, "Subsystems", MISSION_KIND_SUBSYSTEMS, "", once, NULL},
    {MISSION_KIND_SUBSYSTEMS, "Subsystem", MISSION_KIND_LISTED,
     "name! id! executable! descriptor! autostart memoryKiB restarts node", start_listed, NULL},
    {MISSION_KIND_LISTED, "Power", MISSION_KIND_POWER, "state! watts!", start_power, NULL},
    {MISSION_KIND_MISSION, "Modes", MISSION_KIND_MODES, "", once, end_modes},
    {MISSION_KIND_MODES, "Mode", MISSION_KIND_MODE, "name! id! initial", start_mode, NULL},
    {MISSION_KIND_MISSION, "Users", MISSION_KIND_USERS, "", once, NULL},
    {MISSION_KIND_USERS, "User", MISSION_KIND_USER, "name! id!", start_user, NULL},
    {MISSION_KIND_MISSION, "Permissions", MISSION_KIND_PERMISSIONS, "", start_permissions, NULL},
    {MISSION_KIND_PERMISSIONS, "Allow", MISSION_KIND_ALLOW, "tc! select to! modes! states!",
     mission_rules_allow, NULL},
    {MISSION_KIND_MISSION, "Links", MISSION_KIND_LINKS, "", once, NULL},
    {MISSION_KIND_LINKS, "Link", MISSION_KIND_LINK, "name! from! to!", mission_rules_link, NULL},
    {MISSION_KIND_MISSION, "RecoveryPlans", MISSION_KIND_PLANS, "", start_plans, NULL},
    {MISSION_KIND_PLANS, "Plan", MISSION_KIND_PLAN, "name! severity! subsystem event", mission_rules_plan,
     mission_rules_plan_end},
    {MISSION_KIND_PLAN, "Action", MISSION_KIND_ACTION, "do! target state mode after", mission_rules_action,
     NULL},
    {MISSION_KIND_MISSION, "PacketLog", MISSION_KIND_PACKET_LOG, "strategy ringRecords", start_packet_log,
     NULL},
    {MISSION_KIND_MISSION, "Buses", MISSION_KIND_BUSES, "", once, NULL},
    {MISSION_KIND_BUSES, "Bus", MISSION_KIND_BUS, "name! bitRate! dataBitRate", start_bus, NULL},
    {MISSION_KIND_MISSION, "Transports", MISSION_KIND_TRANSPORTS, "messages links", start_transports, NULL},
    {MISSION_KIND_MISSION, "Ground", MISSION_KIND_GROUND, "address! port!", start_ground, NULL},
};

void mission_builder_begin(mission_builder_t* const builder, mission_descriptor_t* const mission,
                           const char* const path, text_t* const error)
{
    FSW_ASSERT((builder != NULL) && (mission != NULL) && (path != NULL) && (error != NULL));
    (void)memset(mission, 0, sizeof *mission);
    mission->name             = "";
    mission->log_ring_records = 4096U;
    mission->message_method   = DESCRIPTOR_UDP;
    mission->link_method      = DESCRIPTOR_SHARED_MEMORY;
    mission->ground_address   = "";
    *builder                  = (mission_builder_t){.mission = mission};
    builder->source           = (source_t){.path          = path,
                                           .error         = error,
                                           .status        = STATUS_OK,
                                           .rows          = rows,
                                           .row_count     = sizeof rows / sizeof rows[0],
                                           .hash          = FNV64_START,
                                           .text          = mission->text,
                                           .text_capacity = MISSION_TEXT_OCTETS,
                                           .text_used     = &mission->text_used,
                                           .builder       = builder};
}
