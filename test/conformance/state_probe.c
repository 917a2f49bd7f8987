// SPDX-License-Identifier: Apache-2.0
// Takes the state machine through all transitions and prints them, for test_states.py: each request and event
// in each state, each failure of an action, and all changes of state that follow.
#include "base/assertion.h"
#include "fsw/framework/subsystem/state_machine.h"

#include <stdio.h>
#include <stdlib.h>

#define TARGETS 5U

void fsw_assertion_failed(const char* const file, const int line)
{
    fprintf(stderr, "%s:%d: assertion failed\n", file, line);
    abort();
}

static const state_t targets[TARGETS] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                                         STATE_OPERATIONAL, STATE_ERROR_OPERATIONAL};

/// Print the changes of state that the last call made.
static void print_changes(const state_machine_t* const machine)
{
    for (unsigned i = 0U; i < machine->transition_count; i++) {
        const state_transition_t* const change = &machine->transitions[i];
        if (change->previous != change->state) {
            printf("change %d %d\n", change->previous, change->state);
        }
    }
}

/// End the running action, and those that follow, successfully until the state is reached or the machine
/// rests.
static void go_to(state_machine_t* const machine, const state_t state)
{
    while ((machine->action != ACTION_NONE) && (machine->state != state)) {
        subsystem_state_machine_outcome(machine, OUTCOME_DONE);
    }
}

static void go(state_machine_t* const machine, const state_t target)
{
    (void)subsystem_state_machine_request(machine, target, CAUSE_REQUEST);
    go_to(machine, STATE_COUNT);
}

static state_machine_t configured(void)
{
    state_machine_t machine;
    subsystem_state_machine_init(&machine, true);
    go(&machine, STATE_PRE_OPERATIONAL);
    (void)subsystem_state_machine_configure(&machine);
    go_to(&machine, STATE_COUNT);
    return machine;
}

/// Returns a machine in a state: at rest in a state of `targets`, with the action of the state running in the
/// others.
static state_machine_t machine_in(const state_t state)
{
    state_machine_t machine = configured();
    switch (state) {
    case STATE_OFFLINE:
    case STATE_SOFTWARE_INIT:
    case STATE_HARDWARE_INIT:
        subsystem_state_machine_init(&machine, true);
        if (state != STATE_OFFLINE) {
            (void)subsystem_state_machine_request(&machine, STATE_PRE_OPERATIONAL, CAUSE_REQUEST);
            go_to(&machine, state);
        }
        break;
    case STATE_PRE_OPERATIONAL:
        break;
    case STATE_POST_OPERATIONAL: // Passed on the way to PRE_OPERATIONAL.
        go(&machine, STATE_SAFE_OPERATIONAL);
        (void)subsystem_state_machine_request(&machine, STATE_PRE_OPERATIONAL, CAUSE_REQUEST);
        go_to(&machine, state);
        break;
    case STATE_HARDWARE_DEINIT:
    case STATE_SOFTWARE_DEINIT:
        (void)subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_REQUEST);
        go_to(&machine, state);
        break;
    default:
        go(&machine, STATE_SAFE_OPERATIONAL);
        go(&machine, (state == STATE_ERROR_OPERATIONAL) ? state : STATE_SAFE_OPERATIONAL);
        if (state == STATE_OPERATIONAL) {
            go(&machine, state);
        }
        break;
    }
    if (machine.state != state) {
        fprintf(stderr, "state %d is not reached\n", (int)state);
        exit(1);
    }
    return machine;
}

/// Print the changes of state of the last call and of all actions after it, which succeed.
static void print_transitions(state_machine_t* const machine)
{
    print_changes(machine);
    while (machine->action != ACTION_NONE) {
        subsystem_state_machine_outcome(machine, OUTCOME_DONE);
        print_changes(machine);
    }
}

static void print_requests(const state_t state)
{
    static const char* const answers[] = {
        [ANSWER_DONE] = "done", [ANSWER_STARTED] = "started", [ANSWER_BUSY] = "busy", [ANSWER_NO] = "no"};
    for (unsigned i = 0U; i < TARGETS; i++) {
        state_machine_t machine     = machine_in(state);
        const state_answer_t answer = subsystem_state_machine_request(&machine, targets[i], CAUSE_REQUEST);
        printf("request %d %d %s\n", (int)state, (int)targets[i], answers[answer]);
        if (answer == ANSWER_STARTED) {
            print_transitions(&machine);
        }
    }
}

static void print_events(const state_t state)
{
    for (unsigned event = 0U; event < (unsigned)STATE_EVENT_COUNT; event++) {
        state_machine_t machine = machine_in(state);
        const bool has_changed =
            subsystem_state_machine_event(&machine, (state_event_t)event, CAUSE_OWN_ERROR);
        printf("event %u %d %s\n", event, (int)state, has_changed ? "started" : "stays");
        if (has_changed) {
            print_transitions(&machine);
        }
    }
}

/// Returns a machine that runs an action, found by requests for each state from each state.
static state_machine_t machine_running(const state_action_t action)
{
    for (unsigned state = 0U; state < (unsigned)STATE_COUNT; state++) {
        for (unsigned i = 0U; i <= TARGETS; i++) {
            state_machine_t machine = machine_in((state_t)state);
            if (i < TARGETS) {
                (void)subsystem_state_machine_request(&machine, targets[i], CAUSE_REQUEST);
            } else {
                (void)subsystem_state_machine_configure(&machine);
            }
            while ((machine.action != ACTION_NONE) && (machine.action != action)) {
                subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
            }
            if (machine.action == action) {
                return machine;
            }
        }
    }
    fprintf(stderr, "action %d is not reached\n", (int)action);
    exit(1);
}

static void print_failure(const state_action_t action)
{
    state_machine_t machine = machine_running(action);
    printf("failure %d %d\n", (int)action, (int)machine.state);
    subsystem_state_machine_outcome(&machine, OUTCOME_FAILED);
    print_transitions(&machine);
    printf("rests %d %d\n", (int)machine.state, (int)machine.phase);
}

int main(void)
{
    for (unsigned state = 0U; state < (unsigned)STATE_COUNT; state++) {
        print_requests((state_t)state);
        print_events((state_t)state);
    }
    for (unsigned action = (unsigned)ACTION_NONE + 1U; action < (unsigned)ACTION_COUNT; action++) {
        print_failure((state_action_t)action);
    }
    return 0;
}
