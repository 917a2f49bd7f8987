// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/subsystem/machine_states.h"

#include "unity.h"

#include <stdbool.h>

#define MOST_ACTIONS 16U // More actions than any sequence of transitions needs.

static void done(state_machine_t* machine)
{
    subsystem_state_machine_outcome(machine, OUTCOME_DONE);
}

static void go(state_machine_t* machine, state_t target)
{
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_request(machine, target, CAUSE_REQUEST));
}

static void go_all_the_way(state_machine_t* machine, state_t target)
{
    go(machine, target);
    while (machine->action != ACTION_NONE) {
        done(machine);
    }
    TEST_ASSERT_EQUAL(target, machine->state);
}

state_machine_t machine_unconfigured(void)
{
    state_machine_t machine;
    subsystem_state_machine_init(&machine, true);
    go_all_the_way(&machine, STATE_PRE_OPERATIONAL);
    return machine;
}

static state_machine_t machine_configured(void)
{
    state_machine_t machine = machine_unconfigured();
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_configure(&machine));
    done(&machine);
    return machine;
}

/// Returns a machine in state 1, 2, 7, 8 or 9 whose action is running.
static state_machine_t machine_passing(state_t state)
{
    state_machine_t machine = machine_configured();
    if (state <= STATE_HARDWARE_INIT) {
        subsystem_state_machine_init(&machine, true);
        go(&machine, STATE_PRE_OPERATIONAL);
    } else if (state == STATE_POST_OPERATIONAL) {
        go_all_the_way(&machine, STATE_SAFE_OPERATIONAL);
        go(&machine, STATE_PRE_OPERATIONAL);
    } else {
        go(&machine, STATE_OFFLINE);
    }
    while (machine.state != state) {
        done(&machine);
    }
    return machine;
}

state_machine_t machine_in(state_t state)
{
    state_machine_t machine;
    switch (state) {
    case STATE_OFFLINE:
        subsystem_state_machine_init(&machine, true);
        return machine;
    case STATE_PRE_OPERATIONAL:
        return machine_configured();
    case STATE_SAFE_OPERATIONAL:
    case STATE_OPERATIONAL:
        machine = machine_configured();
        go_all_the_way(&machine, STATE_SAFE_OPERATIONAL);
        if (state == STATE_OPERATIONAL) {
            go_all_the_way(&machine, STATE_OPERATIONAL);
        }
        return machine;
    case STATE_ERROR_OPERATIONAL:
        machine = machine_configured();
        go_all_the_way(&machine, STATE_ERROR_OPERATIONAL);
        return machine;
    default:
        return machine_passing(state);
    }
}

state_machine_t machine_running(state_action_t action)
{
    state_machine_t machine = machine_in(STATE_PRE_OPERATIONAL);
    switch (action) {
    case ACTION_SOFTWARE_INIT:
        return machine_in(STATE_SOFTWARE_INIT);
    case ACTION_HARDWARE_INIT:
        return machine_in(STATE_HARDWARE_INIT);
    case ACTION_CONFIGURE:
        TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_state_machine_configure(&machine));
        break;
    case ACTION_START_CONTROL:
        go(&machine, STATE_SAFE_OPERATIONAL);
        break;
    case ACTION_STOP_CONTROL:
        machine = machine_in(STATE_SAFE_OPERATIONAL);
        go(&machine, STATE_PRE_OPERATIONAL);
        break;
    case ACTION_ENGAGE:
        machine = machine_in(STATE_SAFE_OPERATIONAL);
        go(&machine, STATE_OPERATIONAL);
        break;
    case ACTION_DISENGAGE:
        machine = machine_in(STATE_OPERATIONAL);
        go(&machine, STATE_SAFE_OPERATIONAL);
        break;
    case ACTION_SECURE:
        go(&machine, STATE_ERROR_OPERATIONAL);
        break;
    case ACTION_POST:
        return machine_in(STATE_POST_OPERATIONAL);
    case ACTION_HARDWARE_DEINIT:
        return machine_in(STATE_HARDWARE_DEINIT);
    default:
        TEST_ASSERT_EQUAL(ACTION_SOFTWARE_DEINIT, action);
        return machine_in(STATE_SOFTWARE_DEINIT);
    }
    TEST_ASSERT_EQUAL(action, machine.action);
    return machine;
}

void machine_check_transitions(const state_machine_t* machine, state_t before, state_phase_t phase_before)
{
    state_t state       = before;
    state_phase_t phase = phase_before;
    for (uint8_t i = 0U; i < machine->transition_count; i++) {
        const state_transition_t* const made = &machine->transitions[i];
        TEST_ASSERT_EQUAL(state, made->previous);
        TEST_ASSERT_TRUE((made->state != state) || (made->phase != phase));
        state = made->state;
        phase = made->phase;
    }
    TEST_ASSERT_EQUAL(machine->state, state);
    TEST_ASSERT_EQUAL(machine->phase, phase);
}

/// Append the states that the last call entered.
static size_t note_states(const state_machine_t* machine, char* states_passed, size_t length)
{
    for (uint8_t i = 0U; i < machine->transition_count; i++) {
        const state_transition_t* const made = &machine->transitions[i];
        if (made->state != made->previous) {
            TEST_ASSERT_TRUE((length + 3U) < STATES_TEXT);
            if (length > 0U) {
                states_passed[length++] = ' ';
            }
            states_passed[length++] = (char)('0' + (char)made->state);
        }
    }
    states_passed[length] = '\0';
    return length;
}

void machine_finish(state_machine_t* machine, state_outcome_t outcome, char states_passed[STATES_TEXT])
{
    size_t length = note_states(machine, states_passed, 0U);
    for (unsigned i = 0U; machine->action != ACTION_NONE; i++) {
        TEST_ASSERT_TRUE_MESSAGE(i < MOST_ACTIONS, "the transitions do not end");
        const state_t state       = machine->state;
        const state_phase_t phase = machine->phase;
        subsystem_state_machine_outcome(machine, outcome);
        machine_check_transitions(machine, state, phase);
        length = note_states(machine, states_passed, length);
    }
}
