// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

static const uint8_t rest_states[] = {0U, 3U, 4U, 5U, 6U};
#define REST_STATES (sizeof rest_states / sizeof rest_states[0])

static uint32_t rest_state_names(const char** const out_names)
{
    for (size_t i = 0U; i < REST_STATES; i++) {
        out_names[i] = descriptor_state_name(rest_states[i]);
    }
    return REST_STATES;
}

/// Service and subtype of a telecommand like 8,1.
static void read_telecommand(source_t* const source, mission_rule_t* const rule)
{
    const char* const words = source_raw(source, "tc");
    uint32_t numbers[2]     = {0U, 0U};
    uint32_t digits[2]      = {0U, 0U};
    uint32_t part           = 0U;
    bool is_right           = true;
    for (size_t i = 0U; is_right && (words[i] != '\0'); i++) {
        if ((words[i] == ',') && (part == 0U)) {
            part = 1U;
        } else if ((words[i] >= '0') && (words[i] <= '9')) {
            numbers[part] = (numbers[part] * 10U) + (uint32_t)(words[i] - '0');
            digits[part]++;
            is_right = (digits[part] <= 3U);
        } else {
            is_right = false;
        }
    }
    for (uint32_t i = 0U; i < 2U; i++) {
        is_right = is_right && (numbers[i] >= 1U) && (numbers[i] <= 255U);
    }
    if (!is_right) {
        source_wrong(source, "tc", "service and subtype like 8,1");
    }
    rule->service = (uint8_t)numbers[0];
    rule->subtype = (uint8_t)numbers[1];
}

/// Bits of the words of an attribute among names; "*" is all sixteen.
static uint16_t bits_of(source_t* const source, const char* const attribute, const char* const* const names,
                        const uint32_t count, const uint8_t* const numbers)
{
    uint8_t indices[16];
    if (strcmp(source_raw(source, attribute), "*") == 0) {
        return UINT16_MAX;
    }
    const uint32_t found = source_words(source, attribute, names, count, indices);
    uint16_t bits        = 0U;
    for (uint32_t i = 0U; i < found; i++) {
        bits = (uint16_t)(bits | (1U << ((numbers != NULL) ? numbers[indices[i]] : indices[i])));
    }
    return bits;
}

static uint8_t modes_of(source_t* const source)
{
    const mission_descriptor_t* const mission = mission_builder_of(source)->mission;
    const char* names[MISSION_MODES_MAX];
    uint8_t ids[MISSION_MODES_MAX];
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        ids[i] = mission->modes[i].id;
    }
    const uint32_t count = mission_builder_mode_names(mission, names);
    return (uint8_t)bits_of(source, "modes", names, count, ids);
}

static uint16_t states_of(source_t* const source)
{
    const char* names[DESCRIPTOR_STATES];
    for (uint8_t i = 0U; i < DESCRIPTOR_STATES; i++) {
        names[i] = descriptor_state_name(i);
    }
    return bits_of(source, "states", names, DESCRIPTOR_STATES, NULL);
}

/// APID of a subsystem of the mission, or one of the words behind them.
static uint16_t target_of(source_t* const source, const char* const attribute, const char* const* const words,
                          const uint16_t* const numbers, const uint32_t word_count)
{
    const mission_descriptor_t* const mission = mission_builder_of(source)->mission;
    const char* names[MISSION_SUBSYSTEMS_MAX + 2U];
    const uint32_t count = mission_builder_subsystem_names(mission, names);
    for (uint32_t i = 0U; i < word_count; i++) {
        names[count + i] = words[i];
    }
    const uint32_t index = source_word(source, attribute, names, count + word_count, 0U);
    return (index < count) ? mission->subsystems[index].apid : numbers[index - count];
}

/// Selector of a rule: which kind it is depends on the telecommand.
static void read_select(source_t* const source, mission_rule_t* const rule, const char** const out_pending)
{
    const char* const select = source_raw(source, "select");
    const char* names[MISSION_LINKS_MAX];
    rule->is_any = (select == NULL) || (strcmp(select, "*") == 0);
    if (rule->is_any) {
        return;
    }
    if ((rule->service == 8U) && (rule->subtype == 1U)) {
        rule->select = source_identifier(source, "select", DESCRIPTOR_FUNCTION_NAME_MAX);
        *out_pending = rule->select;
    } else if ((rule->service == 129U) && (rule->subtype == 1U)) {
        rule->is_numbered = true;
        rule->number      = rest_states[source_word(source, "select", names, rest_state_names(names), 0U)];
    } else if ((rule->service == 129U) && (rule->subtype == 3U)) {
        rule->is_numbered = true;
        *out_pending      = source_identifier(source, "select", DESCRIPTOR_NAME_MAX);
        if (rule->target == MISSION_ANY_TARGET) {
            source_wrong(source, "select",
                         "* where to is *, because each subsystem numbers its configurations");
        }
    } else if (rule->service == 130U) {
        // Links stand behind the permissions in the file; their names are resolved with all others.
        rule->is_numbered = true;
        *out_pending      = source_identifier(source, "select", DESCRIPTOR_NAME_MAX);
    } else {
        source_wrong(source, "select", "* for this telecommand");
    }
}

void mission_rules_allow(source_t* const source)
{
    static const char* const words[]    = {"*"};
    static const uint16_t numbers[]     = {MISSION_ANY_TARGET};
    mission_builder_t* const builder    = source->builder;
    mission_descriptor_t* const mission = builder->mission;
    if (!source_has_room(source, mission->rule_count, MISSION_RULES_MAX, "<Allow>")) {
        return;
    }
    mission_rule_t* const rule = &mission->rules[mission->rule_count];
    *rule                      = (mission_rule_t){.line = source->line};
    read_telecommand(source, rule);
    rule->target = target_of(source, "to", words, numbers, 1U);
    rule->modes  = modes_of(source);
    rule->states = states_of(source);
    read_select(source, rule, &builder->rule_words[mission->rule_count]);
    mission->rule_count++;
}

void mission_rules_link(source_t* const source)
{
    mission_builder_t* const builder    = source->builder;
    mission_descriptor_t* const mission = builder->mission;
    if (!source_has_room(source, mission->link_count, MISSION_LINKS_MAX, "links")) {
        return;
    }
    mission_link_t* const link = &mission->links[mission->link_count];
    *link = (mission_link_t){.name   = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                             .number = (uint16_t)(mission->link_count + 1U),
                             .line   = source->line};
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        if (strcmp(mission->links[i].name, link->name) == 0) {
            mission_builder_taken(source, "name", mission->links[i].line);
        }
    }
    builder->link_words[mission->link_count][0] = source_text(source, "from", 2U * DESCRIPTOR_NAME_MAX);
    builder->link_words[mission->link_count][1] = source_text(source, "to", 2U * DESCRIPTOR_NAME_MAX);
    mission->link_count++;
}

void mission_rules_plan(source_t* const source)
{
    static const uint16_t nobody[]        = {MISSION_ANY_TARGET};
    static const char* const severities[] = {"INFORMATIVE", "LOW", "MEDIUM", "HIGH"};
    mission_builder_t* const builder      = source->builder;
    mission_descriptor_t* const mission   = builder->mission;
    if (!source_has_room(source, mission->plan_count, MISSION_PLANS_MAX, "plans")) {
        return;
    }
    mission_plan_t* const plan = &mission->plans[mission->plan_count];
    *plan          = (mission_plan_t){.name         = source_identifier(source, "name", DESCRIPTOR_NAME_MAX),
                                      .apid         = MISSION_ANY_TARGET,
                                      .first_action = mission->action_count,
                                      .line         = source->line};
    plan->severity = (descriptor_severity_t)(source_word(source, "severity", severities, 4U, 0U) + 1U);
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        if (strcmp(mission->plans[i].name, plan->name) == 0) {
            mission_builder_taken(source, "name", mission->plans[i].line);
        }
    }
    if (source_has(source, "subsystem")) {
        plan->apid = target_of(source, "subsystem", NULL, nobody, 0U);
    }
    if (source_has(source, "event")) {
        builder->plan_events[mission->plan_count] = source_identifier(source, "event", DESCRIPTOR_NAME_MAX);
        if (!source_has(source, "subsystem")) {
            (void)source_fail(source, source->line, STATUS_INVALID, "<Plan> with an event needs a subsystem");
        }
    }
    mission->plan_count++;
}

void mission_rules_plan_end(source_t* const source)
{
    const mission_descriptor_t* const mission = mission_builder_of(source)->mission;
    const mission_plan_t* const plan          = &mission->plans[mission->plan_count - 1U];
    if (plan->action_count == 0U) {
        (void)source_fail(source, plan->line, STATUS_INVALID, "<Plan> has no <Action>");
    }
}

static void check_action_attribute(source_t* const source, const char* const attribute, const bool is_needed)
{
    if ((source_has(source, attribute) != is_needed) &&
        source_fail(source, source->line, STATUS_INVALID, "<Action do=\"")) {
        text_add(source->error, source_raw(source, "do"));
        text_add(source->error, is_needed ? "\"> needs attribute " : "\"> has no attribute ");
        text_add(source->error, attribute);
    }
}

void mission_rules_action(source_t* const source)
{
    static const char* const kinds[]    = {"STATE", "MODE", "LOG"};
    static const char* const words[]    = {"SELF", "NETWORK"};
    static const uint16_t numbers[]     = {MISSION_SELF, MISSION_NETWORK};
    mission_descriptor_t* const mission = mission_builder_of(source)->mission;
    const char* names[MISSION_MODES_MAX];
    if (!source_has_room(source, mission->action_count, MISSION_ACTIONS_MAX, "actions")) {
        return;
    }
    mission_action_t* const action = &mission->actions[mission->action_count];
    *action                        = (mission_action_t){.line = source->line};
    action->kind                   = (mission_action_kind_t)source_word(source, "do", kinds, 3U, 2U);
    check_action_attribute(source, "target", action->kind == MISSION_ACTION_STATE);
    check_action_attribute(source, "state", action->kind == MISSION_ACTION_STATE);
    check_action_attribute(source, "mode", action->kind == MISSION_ACTION_MODE);
    if (source->status == STATUS_OK) {
        if (action->kind == MISSION_ACTION_STATE) {
            action->target = target_of(source, "target", words, numbers, 2U);
            action->state  = rest_states[source_word(source, "state", names, rest_state_names(names), 0U)];
        } else if (action->kind == MISSION_ACTION_MODE) {
            const uint32_t count = mission_builder_mode_names(mission, names);
            action->mode         = mission->modes[source_word(source, "mode", names, count, 0U)].id;
        }
        action->after_us = source_time_us(source, "after", 0U, 600000000U, 0U);
    }
    mission->action_count++;
    mission->plans[mission->plan_count - 1U].action_count++;
}
