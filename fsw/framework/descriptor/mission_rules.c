// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

static const uint8_t rest_states[] = {0U, 3U, 4U, 5U, 6U};
#define REST_STATES 0x79U ///< The same states as a bit set.

// Telecommands whose rules may have a selector: service << 8 | subtype.
#define TC_FUNCTION 0x0801U
#define TC_STATE 0x8101U
#define TC_CONFIGURATION 0x8103U
#define SERVICE_LINKS 130U

/// Read a number of 1..255 at *text, and move *text past it. Returns 0 if there is none.
static uint8_t number_at(const char** const text)
{
    uint32_t number = 0U;
    uint32_t digits = 0U;
    for (; (**text >= '0') && (**text <= '9') && (digits < 4U); (*text)++) {
        number = (number * 10U) + (uint32_t)(**text - '0');
        digits++;
    }
    return ((digits <= 3U) && (number <= UINT8_MAX)) ? (uint8_t)number : 0U;
}

/// Read service and subtype of a telecommand: "8,1", or "11,*" for all subtypes of a service.
static void read_telecommand(source_t* const source, mission_rule_t* const rule)
{
    const char* words = descriptor_source_raw(source, "tc");
    rule->service     = number_at(&words);
    bool is_right     = (rule->service != 0U) && (words[0] == ',');
    if (is_right && (strcmp(words, ",*") != 0)) {
        words++;
        rule->subtype = number_at(&words);
        is_right      = (rule->subtype != 0U) && (words[0] == '\0');
    }
    if (!is_right) {
        descriptor_source_wrong(source, "tc", "service and subtype like 8,1, or 11,*");
    }
}

/// Returns the modes that a rule names, one bit for each.
static uint8_t modes_of(source_t* const source, const mission_descriptor_t* const mission)
{
    char words[MISSION_MODE_WORDS];
    text_t text = text_in(words, sizeof words);
    descriptor_source_names(source, &descriptor_mission_modes, &text);
    const uint16_t indices = descriptor_source_bits(source, "modes", words);
    uint32_t modes         = (indices == UINT16_MAX) ? UINT8_MAX : 0U;
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        modes |= (((uint32_t)indices >> i) & 1U) << mission->modes[i].id;
    }
    return (uint8_t)modes;
}

static uint8_t rest_state_of(source_t* const source, const char* const attribute)
{
    char words[DESCRIPTOR_STATE_WORDS];
    text_t text = text_in(words, sizeof words);
    descriptor_state_words(REST_STATES, &text);
    return rest_states[descriptor_source_word(source, attribute, words)];
}

/// Returns the APID of the subsystem that an attribute names. `others` lists further permitted words; for one
/// of them the result is its entry in `numbers`.
static uint16_t target_of(source_t* const source, const char* const attribute, const char* const others,
                          const uint16_t* const numbers)
{
    const mission_descriptor_t* const mission = descriptor_mission_builder_of(source)->mission;
    char words[MISSION_SUBSYSTEM_WORDS];
    text_t text = text_in(words, sizeof words);
    descriptor_source_names(source, &descriptor_mission_subsystems, &text);
    text_add(&text, others);
    const uint32_t index = descriptor_source_word(source, attribute, words);
    return (index < mission->subsystem_count) ? mission->subsystems[index].apid
                                              : numbers[index - mission->subsystem_count];
}

/// Read the selector of a rule; its kind depends on the telecommand.
static void read_select(source_t* const source, mission_rule_t* const rule, const char** const out_pending)
{
    const char* const select = descriptor_source_raw(source, "select");
    const uint32_t tc        = ((uint32_t)rule->service << 8U) | rule->subtype;
    rule->is_any             = (select == NULL) || (strcmp(select, "*") == 0);
    if (rule->is_any) {
        return;
    }
    rule->is_numbered = (tc != TC_FUNCTION);
    if (tc == TC_STATE) {
        rule->number = rest_state_of(source, "select");
        return;
    }
    if ((tc != TC_FUNCTION) && (tc != TC_CONFIGURATION) && (rule->service != SERVICE_LINKS)) {
        descriptor_source_wrong(source, "select", "* for this telecommand");
    } else if ((tc == TC_CONFIGURATION) && (rule->target == MISSION_ANY_TARGET)) {
        descriptor_source_wrong(source, "select",
                                "* if to is *, because each subsystem numbers its own configurations");
    }
    // The file defines the links after the permissions; therefore their names are resolved at the end.
    *out_pending =
        descriptor_source_text(source, "select", SOURCE_UPPER,
                               (tc == TC_FUNCTION) ? DESCRIPTOR_FUNCTION_NAME_MAX : DESCRIPTOR_NAME_MAX);
    if (tc == TC_FUNCTION) {
        rule->select = *out_pending;
    }
}

void descriptor_mission_rules_allow(source_t* const source)
{
    static const uint16_t numbers[]  = {MISSION_ANY_TARGET};
    mission_builder_t* const builder = source->builder;
    mission_rule_t* const rule       = source->item;
    read_telecommand(source, rule);
    rule->target = target_of(source, "to", " *", numbers);
    rule->modes  = modes_of(source, builder->mission);
    rule->states = descriptor_source_states(source, "states");
    read_select(source, rule, &builder->rule_words[source->order]);
}

void descriptor_mission_rules_plan(source_t* const source)
{
    mission_plan_t* const plan = source->item;
    plan->apid                 = MISSION_ANY_TARGET;
    if (descriptor_source_has(source, "subsystem")) {
        plan->apid = target_of(source, "subsystem", "", &plan->apid);
    }
    if (descriptor_source_has(source, "event")) {
        descriptor_mission_builder_of(source)->plan_events[source->order] =
            descriptor_source_text(source, "event", SOURCE_UPPER, DESCRIPTOR_NAME_MAX);
        if (!descriptor_source_has(source, "subsystem")) {
            descriptor_source_fail(source, source->line, "<Plan> with an event needs a subsystem");
        }
    }
}

static void check_action_attribute(source_t* const source, const char* const attribute, const bool is_needed)
{
    if (descriptor_source_has(source, attribute) != is_needed) {
        descriptor_source_refuse(source, source->line, "<Action do=\"%\"> % attribute ",
                                 descriptor_source_raw(source, "do"), is_needed ? "needs" : "cannot have",
                                 0U);
        descriptor_source_append(source, "%", attribute, NULL, 0U);
    }
}

void descriptor_mission_rules_action(source_t* const source)
{
    static const uint16_t numbers[]           = {MISSION_SELF, MISSION_NETWORK};
    const mission_descriptor_t* const mission = descriptor_mission_builder_of(source)->mission;
    mission_action_t* const action            = source->item;
    check_action_attribute(source, "target", action->kind == MISSION_ACTION_STATE);
    check_action_attribute(source, "state", action->kind == MISSION_ACTION_STATE);
    check_action_attribute(source, "mode", action->kind == MISSION_ACTION_MODE);
    if (source->status != STATUS_OK) {
        return;
    }
    if (action->kind == MISSION_ACTION_STATE) {
        action->target = target_of(source, "target", " SELF NETWORK", numbers);
        action->state  = rest_state_of(source, "state");
    } else if (action->kind == MISSION_ACTION_MODE) {
        char words[MISSION_MODE_WORDS];
        text_t text = text_in(words, sizeof words);
        descriptor_source_names(source, &descriptor_mission_modes, &text);
        action->mode = mission->modes[descriptor_source_word(source, "mode", words)].id;
    }
}
