// SPDX-License-Identifier: Apache-2.0
// The tables of docs/states.md row by row. They are written here as on that page, as lists of states, and not
// as in the code.
#include "fsw/framework/subsystem/state_machine.h"

#include "test/unit/fsw/framework/subsystem/machine_states.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

#define COLUMNS 5U
static const state_t requests[COLUMNS] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                                          STATE_OPERATIONAL, STATE_ERROR_OPERATIONAL};

// Row: present state; column: requested state. In row 7 the machine was going to state 3 when the request
// arrived; in rows 8 and 9 it was going to state 0, the only possible target there.
static const char* const request_rows[STATE_COUNT][COLUMNS] = {
    {"done", "1 2 3", "no", "no", "no"},    {"9 0", "busy", "no", "no", "9 0"},
    {"8 9 0", "busy", "no", "no", "8 9 0"}, {"7 8 9 0", "done", "4", "no", "6"},
    {"7 8 9 0", "7 3", "done", "5", "6"},   {"4 7 8 9 0", "4 7 3", "4", "done", "6"},
    {"7 8 9 0", "no", "no", "no", "done"},  {"8 9 0", "busy", "no", "no", "8 9 0"},
    {"9 0", "busy", "no", "no", "9 0"},     {"0", "busy", "no", "no", "0"},
};

static state_answer_t answer_of(const char* text)
{
    return (strcmp(text, "done") == 0)   ? ANSWER_DONE
           : (strcmp(text, "no") == 0)   ? ANSWER_NO
           : (strcmp(text, "busy") == 0) ? ANSWER_BUSY
                                         : ANSWER_STARTED;
}

static const char* cell_name(unsigned row, unsigned column)
{
    static char text[48];
    (void)snprintf(text, sizeof text, "row %u, column %u", row, column);
    return text;
}

static void every_request_has_the_documented_answer_in_every_state(void)
{
    for (unsigned row = 0U; row < STATE_COUNT; row++) {
        for (unsigned column = 0U; column < COLUMNS; column++) {
            const char* const expected   = request_rows[row][column];
            const char* const cell       = cell_name(row, column);
            state_machine_t machine      = machine_in((state_t)row);
            const state_machine_t before = machine;
            TEST_ASSERT_EQUAL_MESSAGE(answer_of(expected),
                                      subsystem_state_machine_verdict(&machine, requests[column]), cell);
            TEST_ASSERT_EQUAL_MESSAGE(answer_of(expected),
                                      subsystem_state_machine_request(&machine, requests[column], CAUSE_PLAN),
                                      cell);
            machine_check_transitions(&machine, before.state, before.phase);
            if (answer_of(expected) != ANSWER_STARTED) {
                TEST_ASSERT_EQUAL_MESSAGE(before.action, machine.action, cell);
                TEST_ASSERT_EQUAL_MESSAGE(before.target, machine.target, cell);
                continue;
            }
            char states_passed[STATES_TEXT];
            machine_finish(&machine, OUTCOME_DONE, states_passed);
            TEST_ASSERT_EQUAL_STRING_MESSAGE(expected, states_passed, cell);
            TEST_ASSERT_FALSE_MESSAGE(machine.has_failed, cell);
            TEST_ASSERT_EQUAL_MESSAGE(machine.state, machine.target, cell);
            TEST_ASSERT_EQUAL_MESSAGE(CAUSE_PLAN, machine.cause, cell);
        }
    }
}

static void no_other_target_can_be_requested(void)
{
    static const unsigned others[] = {1U, 2U, 7U, 8U, 9U, 10U, 11U, 255U};
    for (unsigned row = 0U; row < STATE_COUNT; row++) {
        for (unsigned i = 0U; i < (sizeof others / sizeof others[0]); i++) {
            state_machine_t machine = machine_in((state_t)row);
            TEST_ASSERT_EQUAL(ANSWER_NO,
                              subsystem_state_machine_request(&machine, (state_t)others[i], CAUSE_REQUEST));
            TEST_ASSERT_EQUAL(0U, machine.transition_count);
        }
    }
}

static void going_up_needs_a_configuration(void)
{
    state_machine_t machine = machine_unconfigured();
    TEST_ASSERT_EQUAL(PHASE_UNCONFIGURED, machine.phase);
    TEST_ASSERT_EQUAL(ANSWER_NO,
                      subsystem_state_machine_request(&machine, STATE_SAFE_OPERATIONAL, CAUSE_REQUEST));
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_configure(&machine));
    TEST_ASSERT_EQUAL(PHASE_CONFIGURING, machine.phase);
    TEST_ASSERT_EQUAL(ANSWER_BUSY,
                      subsystem_state_machine_request(&machine, STATE_SAFE_OPERATIONAL, CAUSE_REQUEST));
    subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
    TEST_ASSERT_EQUAL(PHASE_CONFIGURED, machine.phase);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_SAFE_OPERATIONAL, CAUSE_REQUEST));
}

static void configurations_are_selected_in_pre_operational_only(void)
{
    for (unsigned row = 0U; row < STATE_COUNT; row++) {
        state_machine_t machine = machine_in((state_t)row);
        TEST_ASSERT_EQUAL((row == STATE_PRE_OPERATIONAL) ? ANSWER_STARTED : ANSWER_NO,
                          subsystem_state_machine_configure(&machine));
    }
    state_machine_t machine = machine_running(ACTION_CONFIGURE);
    TEST_ASSERT_EQUAL(ANSWER_BUSY, subsystem_state_machine_configure(&machine));
    TEST_ASSERT_FALSE_MESSAGE(machine.is_configured, "the old configuration is revoked first");
}

static void with_a_refused_descriptor_the_machine_stays_offline(void)
{
    state_machine_t machine;
    subsystem_state_machine_init(&machine, false);
    TEST_ASSERT_EQUAL(PHASE_INVALID, machine.phase);
    for (unsigned target = 1U; target < STATE_COUNT; target++) {
        TEST_ASSERT_EQUAL(ANSWER_NO,
                          subsystem_state_machine_request(&machine, (state_t)target, CAUSE_REQUEST));
    }
    TEST_ASSERT_EQUAL(ANSWER_DONE, subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_REQUEST));
    for (unsigned event = 0U; event < STATE_EVENT_COUNT; event++) {
        TEST_ASSERT_FALSE(subsystem_state_machine_event(&machine, (state_event_t)event, CAUSE_NETWORK));
    }
    TEST_ASSERT_EQUAL(PHASE_INVALID, machine.phase);
}

// Row: event; column: present state. A list without a bar has the states that follow the event. A bar means
// that the event changes nothing: a transition in progress continues through the states after the bar.
static const char* const event_rows[STATE_EVENT_COUNT][STATE_COUNT] = {
    [EVENT_OWN_HIGH]        = {"|", "9 0", "8 9 0", "6", "6", "6", "|", "8 9 0", "|9 0", "|0"},
    [EVENT_NETWORK_FAILED]  = {"|", "9 0", "8 9 0", "6", "6", "6", "|", "8 9 0", "|9 0", "|0"},
    [EVENT_MEDIUM_ORDER]    = {"|", "|2 3", "|3", "|", "|", "4", "|", "|3", "|9 0", "|0"},
    [EVENT_SUPERVISOR_LOST] = {"|", "|2 3", "|3", "|", "|", "4", "|", "|3", "|9 0", "|0"},
    [EVENT_SHUTDOWN] = {"|", "9 0", "8 9 0", "7 8 9 0", "7 8 9 0", "4 7 8 9 0", "7 8 9 0", "8 9 0", "|9 0",
                        "|0"},
};

static void every_event_has_the_documented_effect_in_every_state(void)
{
    for (unsigned event = 0U; event < STATE_EVENT_COUNT; event++) {
        for (unsigned column = 0U; column < STATE_COUNT; column++) {
            const char* const expected   = event_rows[event][column];
            const char* const cell       = cell_name(event, column);
            const bool changes           = (expected[0] != '|');
            state_machine_t machine      = machine_in((state_t)column);
            const state_machine_t before = machine;
            TEST_ASSERT_EQUAL_MESSAGE(
                changes, subsystem_state_machine_event(&machine, (state_event_t)event, CAUSE_SUPERVISOR_LOST),
                cell);
            machine_check_transitions(&machine, before.state, before.phase);
            TEST_ASSERT_EQUAL_MESSAGE(changes ? CAUSE_SUPERVISOR_LOST : before.cause, machine.cause, cell);
            char states_passed[STATES_TEXT];
            machine_finish(&machine, OUTCOME_DONE, states_passed);
            TEST_ASSERT_EQUAL_STRING_MESSAGE(changes ? expected : &expected[1], states_passed, cell);
            TEST_ASSERT_FALSE_MESSAGE(machine.has_failed, cell);
        }
    }
}

static void an_error_leads_to_error_operational_before_its_action(void)
{
    static const state_action_t actions[] = {ACTION_CONFIGURE,    ACTION_START_CONTROL, ACTION_ENGAGE,
                                             ACTION_STOP_CONTROL, ACTION_DISENGAGE,     ACTION_SECURE};
    for (unsigned i = 0U; i < (sizeof actions / sizeof actions[0]); i++) {
        state_machine_t machine = machine_running(actions[i]);
        (void)subsystem_state_machine_event(&machine, EVENT_OWN_HIGH, CAUSE_OWN_ERROR);
        TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, machine.state);
        TEST_ASSERT_EQUAL(ACTION_SECURE, machine.action);
    }
}

// Columns "on DONE" and "on FAILED or TIMEOUT" of the table of states: all states passed and the rest state.
typedef struct {
    state_action_t action;
    const char* on_done;
    const char* on_failed; // List of states if all later actions succeed.
    state_phase_t rests_done;
    state_phase_t rests_failed;
    state_action_t next_failed; // Action that follows the failure.
} outcome_row_t;

static const outcome_row_t outcome_rows[] = {
    {ACTION_SOFTWARE_INIT, "2 3", "9 0", PHASE_UNCONFIGURED, PHASE_IDLE, ACTION_SOFTWARE_DEINIT},
    {ACTION_HARDWARE_INIT, "3", "8 9 0", PHASE_UNCONFIGURED, PHASE_IDLE, ACTION_HARDWARE_DEINIT},
    {ACTION_CONFIGURE, "", "", PHASE_CONFIGURED, PHASE_UNCONFIGURED, ACTION_NONE},
    {ACTION_START_CONTROL, "", "3", PHASE_IDLE, PHASE_CONFIGURED, ACTION_STOP_CONTROL},
    {ACTION_STOP_CONTROL, "7 3", "7 3", PHASE_UNCONFIGURED, PHASE_UNCONFIGURED, ACTION_POST},
    {ACTION_ENGAGE, "", "4", PHASE_IDLE, PHASE_IDLE, ACTION_DISENGAGE},
    {ACTION_DISENGAGE, "", "6", PHASE_IDLE, PHASE_SECURED, ACTION_SECURE},
    {ACTION_SECURE, "", "", PHASE_SECURED, PHASE_UNSECURED, ACTION_NONE},
    {ACTION_POST, "3", "8 9 0", PHASE_UNCONFIGURED, PHASE_IDLE, ACTION_HARDWARE_DEINIT},
    {ACTION_HARDWARE_DEINIT, "9 0", "9 0", PHASE_IDLE, PHASE_IDLE, ACTION_SOFTWARE_DEINIT},
    {ACTION_SOFTWARE_DEINIT, "0", "0", PHASE_IDLE, PHASE_IDLE, ACTION_NONE},
};

static void check_outcome(const outcome_row_t* row, state_outcome_t outcome)
{
    const bool is_done        = (outcome == OUTCOME_DONE);
    state_machine_t machine   = machine_running(row->action);
    const state_t state       = machine.state;
    const state_phase_t phase = machine.phase;
    const char* const name    = cell_name(row->action, outcome);
    subsystem_state_machine_outcome(&machine, outcome);
    machine_check_transitions(&machine, state, phase);
    TEST_ASSERT_EQUAL_MESSAGE(!is_done, machine.has_failed, name);
    if (!is_done) {
        TEST_ASSERT_EQUAL_MESSAGE(row->next_failed, machine.action, name);
        TEST_ASSERT_EQUAL_MESSAGE((outcome == OUTCOME_TIMEOUT) ? CAUSE_TIMEOUT : CAUSE_OWN_ERROR,
                                  machine.cause, name);
    }
    char states_passed[STATES_TEXT];
    machine_finish(&machine, OUTCOME_DONE, states_passed);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(is_done ? row->on_done : row->on_failed, states_passed, name);
    TEST_ASSERT_EQUAL_MESSAGE(is_done ? row->rests_done : row->rests_failed, machine.phase, name);
    TEST_ASSERT_EQUAL_MESSAGE(machine.state, machine.target, name);
}

static void every_outcome_of_every_action_has_the_documented_effect(void)
{
    TEST_ASSERT_EQUAL(ACTION_COUNT - 1, sizeof outcome_rows / sizeof outcome_rows[0]);
    for (unsigned i = 0U; i < (sizeof outcome_rows / sizeof outcome_rows[0]); i++) {
        check_outcome(&outcome_rows[i], OUTCOME_DONE);
        check_outcome(&outcome_rows[i], OUTCOME_FAILED);
        check_outcome(&outcome_rows[i], OUTCOME_TIMEOUT);
    }
}

static void a_failure_on_the_way_down_does_not_stop_the_transition(void)
{
    for (unsigned state = STATE_PRE_OPERATIONAL; state < STATE_COUNT; state++) {
        for (int outcome = OUTCOME_FAILED; outcome <= OUTCOME_TIMEOUT; outcome++) {
            state_machine_t machine = machine_in((state_t)state);
            (void)subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_SHUTDOWN);
            char states_passed[STATES_TEXT];
            machine_finish(&machine, (state_outcome_t)outcome, states_passed);
            // If the actuators cannot be switched off, the machine ends in state 6.
            TEST_ASSERT_EQUAL((state == STATE_OPERATIONAL) ? STATE_ERROR_OPERATIONAL : STATE_OFFLINE,
                              machine.state);
            TEST_ASSERT_TRUE(machine.has_failed);
        }
    }
}

/// The failure belongs to the earlier request: a later request that succeeds is not reported as failed.
static void the_next_request_clears_an_earlier_failure(void)
{
    for (unsigned i = 0U; i < (sizeof outcome_rows / sizeof outcome_rows[0]); i++) {
        state_machine_t machine = machine_running(outcome_rows[i].action);
        char states_passed[STATES_TEXT];
        subsystem_state_machine_outcome(&machine, OUTCOME_FAILED);
        machine_finish(&machine, OUTCOME_DONE, states_passed);
        TEST_ASSERT_TRUE_MESSAGE(machine.has_failed, cell_name(outcome_rows[i].action, 0U));
        const state_t next = (machine.state == STATE_OFFLINE) ? STATE_PRE_OPERATIONAL : STATE_OFFLINE;
        TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_request(&machine, next, CAUSE_REQUEST));
        TEST_ASSERT_FALSE_MESSAGE(machine.has_failed, cell_name(outcome_rows[i].action, 1U));
        machine_finish(&machine, OUTCOME_DONE, states_passed);
        TEST_ASSERT_EQUAL(next, machine.state);
        TEST_ASSERT_FALSE_MESSAGE(machine.has_failed, cell_name(outcome_rows[i].action, 2U));
    }
    state_machine_t machine = machine_running(ACTION_CONFIGURE); // A configuration is a request, too.
    subsystem_state_machine_outcome(&machine, OUTCOME_FAILED);
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_configure(&machine));
    subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
    TEST_ASSERT_FALSE(machine.has_failed);
}

static void requests_for_states_0_and_6_interrupt_an_action(void)
{
    static const char* const after[ACTION_COUNT][2] = {
        [ACTION_SOFTWARE_INIT] = {"9 0", "9 0"},  [ACTION_HARDWARE_INIT] = {"8 9 0", "8 9 0"},
        [ACTION_CONFIGURE] = {"7 8 9 0", "6"},    [ACTION_START_CONTROL] = {"7 8 9 0", "6"},
        [ACTION_STOP_CONTROL] = {"7 8 9 0", "6"}, [ACTION_ENGAGE] = {"4 7 8 9 0", "6"},
        [ACTION_DISENGAGE] = {"7 8 9 0", "6"},    [ACTION_SECURE] = {"7 8 9 0", NULL},
        [ACTION_POST] = {"8 9 0", "8 9 0"},       [ACTION_HARDWARE_DEINIT] = {"9 0", "9 0"},
        [ACTION_SOFTWARE_DEINIT] = {"0", "0"},
    };
    for (unsigned action = ACTION_NONE + 1U; action < ACTION_COUNT; action++) {
        for (unsigned i = 0U; i < 2U; i++) {
            state_machine_t machine = machine_running((state_action_t)action);
            const state_t target    = (i == 0U) ? STATE_OFFLINE : STATE_ERROR_OPERATIONAL;
            const char* const name  = cell_name(action, i);
            if (after[action][i] == NULL) {
                // The machine is already on the way there: no action starts and no request is superseded.
                TEST_ASSERT_EQUAL(ANSWER_DONE,
                                  subsystem_state_machine_request(&machine, target, CAUSE_REQUEST));
                TEST_ASSERT_FALSE(machine.is_superseded);
                continue;
            }
            TEST_ASSERT_EQUAL_MESSAGE(ANSWER_STARTED,
                                      subsystem_state_machine_request(&machine, target, CAUSE_REQUEST), name);
            TEST_ASSERT_TRUE_MESSAGE(machine.is_superseded, name);
            char states_passed[STATES_TEXT];
            machine_finish(&machine, OUTCOME_DONE, states_passed);
            TEST_ASSERT_EQUAL_STRING_MESSAGE(after[action][i], states_passed, name);
        }
    }
}

static void all_other_requests_during_an_action_are_refused(void)
{
    for (unsigned action = ACTION_NONE + 1U; action < ACTION_COUNT; action++) {
        for (unsigned column = 1U; column <= 3U; column++) {
            state_machine_t machine      = machine_running((state_action_t)action);
            const state_machine_t before = machine;
            const state_answer_t answer =
                subsystem_state_machine_request(&machine, requests[column], CAUSE_REQUEST);
            TEST_ASSERT_TRUE((answer == ANSWER_BUSY) || (answer == ANSWER_NO));
            TEST_ASSERT_EQUAL(before.action, machine.action);
            TEST_ASSERT_EQUAL(before.target, machine.target);
            TEST_ASSERT_EQUAL(0U, machine.transition_count);
        }
    }
}

static void a_request_at_rest_supersedes_nothing(void)
{
    static const state_t rests[] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                                    STATE_OPERATIONAL, STATE_ERROR_OPERATIONAL};
    for (unsigned i = 0U; i < COLUMNS; i++) {
        for (unsigned column = 0U; column < COLUMNS; column++) {
            state_machine_t machine = machine_in(rests[i]);
            (void)subsystem_state_machine_request(&machine, requests[column], CAUSE_REQUEST);
            TEST_ASSERT_FALSE(machine.is_superseded);
        }
    }
}

static void the_secure_action_is_never_interrupted(void)
{
    state_machine_t machine = machine_running(ACTION_SECURE);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_REQUEST));
    TEST_ASSERT_EQUAL(ACTION_SECURE, machine.action);
    TEST_ASSERT_TRUE(subsystem_state_machine_event(&machine, EVENT_SHUTDOWN, CAUSE_SHUTDOWN));
    TEST_ASSERT_EQUAL(ACTION_SECURE, machine.action);
    // The downward transition continues.
    subsystem_state_machine_outcome(&machine, OUTCOME_FAILED);
    TEST_ASSERT_EQUAL(ACTION_POST, machine.action);
    TEST_ASSERT_EQUAL(2U, machine.transition_count);
    TEST_ASSERT_EQUAL(PHASE_UNSECURED, machine.transitions[0].phase);

    machine = machine_running(ACTION_DISENGAGE);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_REQUEST));
    TEST_ASSERT_EQUAL(ACTION_DISENGAGE, machine.action);
    subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
    TEST_ASSERT_EQUAL(ACTION_STOP_CONTROL, machine.action);
}

static void a_transition_during_the_secure_action_may_be_superseded(void)
{
    state_machine_t machine = machine_running(ACTION_SECURE);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_REQUEST));
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_ERROR_OPERATIONAL, CAUSE_NETWORK));
    TEST_ASSERT_TRUE(machine.is_superseded);
    subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
    TEST_ASSERT_FALSE(machine.is_superseded); // The flag is valid for the last call only.
    TEST_ASSERT_EQUAL(PHASE_SECURED, machine.phase);
    TEST_ASSERT_EQUAL(ACTION_NONE, machine.action);
}

static void a_valid_descriptor_may_replace_the_refused_one(void)
{
    state_machine_t machine;
    subsystem_state_machine_init(&machine, false);
    subsystem_state_machine_validate(&machine);
    TEST_ASSERT_EQUAL(PHASE_IDLE, machine.phase);
    machine_check_transitions(&machine, STATE_OFFLINE, PHASE_INVALID);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_state_machine_request(&machine, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    machine                      = machine_running(ACTION_CONFIGURE);
    const state_machine_t before = machine;
    subsystem_state_machine_validate(&machine); // If the machine has a configuration, this changes nothing.
    TEST_ASSERT_EQUAL(before.phase, machine.phase);
    TEST_ASSERT_EQUAL(before.action, machine.action);
    TEST_ASSERT_EQUAL(0U, machine.transition_count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_request_has_the_documented_answer_in_every_state);
    RUN_TEST(no_other_target_can_be_requested);
    RUN_TEST(going_up_needs_a_configuration);
    RUN_TEST(configurations_are_selected_in_pre_operational_only);
    RUN_TEST(with_a_refused_descriptor_the_machine_stays_offline);
    RUN_TEST(every_event_has_the_documented_effect_in_every_state);
    RUN_TEST(an_error_leads_to_error_operational_before_its_action);
    RUN_TEST(every_outcome_of_every_action_has_the_documented_effect);
    RUN_TEST(a_failure_on_the_way_down_does_not_stop_the_transition);
    RUN_TEST(the_next_request_clears_an_earlier_failure);
    RUN_TEST(requests_for_states_0_and_6_interrupt_an_action);
    RUN_TEST(all_other_requests_during_an_action_are_refused);
    RUN_TEST(a_request_at_rest_supersedes_nothing);
    RUN_TEST(the_secure_action_is_never_interrupted);
    RUN_TEST(a_transition_during_the_secure_action_may_be_superseded);
    RUN_TEST(a_valid_descriptor_may_replace_the_refused_one);
    return UNITY_END();
}
