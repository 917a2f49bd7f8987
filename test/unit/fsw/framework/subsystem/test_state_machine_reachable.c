// SPDX-License-Identifier: Apache-2.0
// Visits every condition of the machine (state, phase, pending action, flags) that any sequence of requests,
// events and outcomes can cause. Checks the invariants of each condition and of each step between two.
#include "fsw/framework/subsystem/state_machine.h"

#include "test/unit/fsw/framework/subsystem/machine_states.h"
#include "unity.h"

#include <string.h>

#define VISITED_MAX 4096U
#define TARGETS 12U // States 0..9 and two numbers beyond.
#define STEP_CONFIGURE TARGETS
#define STEP_EVENT (STEP_CONFIGURE + 1U)
#define STEP_OUTCOME (STEP_EVENT + (unsigned)STATE_EVENT_COUNT)
#define STEPS (STEP_OUTCOME + 3U)

void setUp(void)
{
}

void tearDown(void)
{
}

static state_machine_t visited[VISITED_MAX];
static unsigned visited_count;

/// True if both machines are equal except for the cause and the transitions of the last call, which are only
/// reported and do not influence later steps.
static bool is_same(const state_machine_t* a, const state_machine_t* b)
{
    return (a->state == b->state) && (a->phase == b->phase) && (a->target == b->target) &&
           (a->action == b->action) && (a->is_configured == b->is_configured) &&
           (a->has_failed == b->has_failed) && (a->is_superseded == b->is_superseded) &&
           (a->is_backing_out == b->is_backing_out);
}

static void visit(const state_machine_t* machine)
{
    for (unsigned i = 0U; i < visited_count; i++) {
        if (is_same(&visited[i], machine)) {
            return;
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(visited_count < VISITED_MAX, "more conditions than VISITED_MAX");
    visited[visited_count++] = *machine;
}

/// Make one step of the environment. Returns false if this step cannot occur here.
static bool take_step(state_machine_t* machine, unsigned step)
{
    if (step < TARGETS) {
        (void)subsystem_state_machine_request(machine, (state_t)step, CAUSE_REQUEST);
    } else if (step == STEP_CONFIGURE) {
        (void)subsystem_state_machine_configure(machine);
    } else if (step < STEP_OUTCOME) {
        (void)subsystem_state_machine_event(machine, (state_event_t)(step - STEP_EVENT), CAUSE_OWN_ERROR);
    } else if (machine->action != ACTION_NONE) {
        subsystem_state_machine_outcome(machine, (state_outcome_t)(step - STEP_OUTCOME));
    } else {
        return false;
    }
    return true;
}

// Digits of the states that may follow each state, from the table in docs/states.md; the index is the state.
static const char* const followers[STATE_COUNT] = {"1", "29", "38", "467", "3567", "46", "7", "38", "9", "0"};

static void check_transition(const state_transition_t* made)
{
    if (made->state != made->previous) {
        TEST_ASSERT_NOT_NULL_MESSAGE(strchr(followers[made->previous], '0' + (char)made->state),
                                     "a transition that docs/states.md does not allow");
    }
}

/// Invariants of each condition.
static void check_standing(const state_machine_t* machine)
{
    static const char* const actions_of[STATE_COUNT] = {
        // Indices of state_action_t as letters: a = SOFTWARE_INIT ... k = SOFTWARE_DEINIT, - = none.
        "-", "a", "b", "-c", "-deg", "-f", "-h", "i", "j", "k"};
    const char letter = (machine->action == ACTION_NONE) ? '-' : (char)('a' + (char)machine->action - 1);
    TEST_ASSERT_NOT_NULL_MESSAGE(strchr(actions_of[machine->state], letter), "action and state disagree");
    if (machine->action == ACTION_NONE) {
        TEST_ASSERT_EQUAL_MESSAGE(machine->state, machine->target, "no action is pending before the target");
    }
    if ((machine->state == STATE_SAFE_OPERATIONAL) || (machine->state == STATE_OPERATIONAL)) {
        TEST_ASSERT_TRUE_MESSAGE(machine->is_configured, "in state 4 or 5 without a configuration");
    }
    if ((machine->state <= STATE_HARDWARE_INIT) || (machine->state >= STATE_HARDWARE_DEINIT)) {
        TEST_ASSERT_FALSE_MESSAGE(machine->is_configured, "configured in a state that has no configuration");
    }
    if ((machine->state == STATE_PRE_OPERATIONAL) && (machine->action == ACTION_NONE)) {
        TEST_ASSERT_EQUAL(machine->is_configured ? PHASE_CONFIGURED : PHASE_UNCONFIGURED, machine->phase);
    }
}

/// Invariants of each step.
static void check_step(const state_machine_t* before, const state_machine_t* after, unsigned step)
{
    machine_check_transitions(after, before->state, before->phase);
    for (uint8_t i = 0U; i < after->transition_count; i++) {
        check_transition(&after->transitions[i]);
    }
    if ((after->state == STATE_OPERATIONAL) && (before->state != STATE_OPERATIONAL)) {
        TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, before->state);
        TEST_ASSERT_EQUAL_MESSAGE(STATE_OPERATIONAL, step, "entered OPERATIONAL without a request for it");
    }
    if ((after->state == STATE_SAFE_OPERATIONAL) && (before->state == STATE_PRE_OPERATIONAL)) {
        TEST_ASSERT_EQUAL_MESSAGE(STATE_SAFE_OPERATIONAL, step,
                                  "left state 3 upwards without a request for 4");
    }
    if (step < STEP_OUTCOME) { // Only the outcome of the action that secures the devices ends this action.
        if (before->action == ACTION_SECURE) {
            TEST_ASSERT_EQUAL(ACTION_SECURE, after->action);
        }
        if (before->action == ACTION_DISENGAGE) {
            TEST_ASSERT_TRUE((after->action == ACTION_DISENGAGE) || (after->action == ACTION_SECURE));
        }
        TEST_ASSERT_TRUE(!after->is_superseded || (before->action != ACTION_NONE));
    }
}

static void check_answers(const state_machine_t* machine)
{
    for (unsigned target = 0U; target < TARGETS; target++) {
        state_machine_t trial        = *machine;
        const state_answer_t verdict = subsystem_state_machine_verdict(&trial, (state_t)target);
        TEST_ASSERT_EQUAL(verdict, subsystem_state_machine_request(&trial, (state_t)target, CAUSE_REQUEST));
        if (verdict != ANSWER_STARTED) {
            TEST_ASSERT_EQUAL(machine->action, trial.action);
            TEST_ASSERT_EQUAL(machine->target, trial.target);
        }
        if (target == STATE_OFFLINE) { // OFFLINE can be requested in every condition.
            TEST_ASSERT_TRUE((verdict == ANSWER_DONE) || (verdict == ANSWER_STARTED));
            TEST_ASSERT_EQUAL((verdict == ANSWER_DONE) ? machine->target : STATE_OFFLINE, trial.target);
        }
        if (target == STATE_ERROR_OPERATIONAL) {
            TEST_ASSERT_EQUAL(machine->state == STATE_OFFLINE, verdict == ANSWER_NO);
            TEST_ASSERT_TRUE(verdict != ANSWER_BUSY);
        }
    }
}

static void explore(void)
{
    visited_count = 0U;
    for (unsigned valid = 0U; valid < 2U; valid++) {
        state_machine_t start;
        subsystem_state_machine_init(&start, valid != 0U);
        visit(&start);
    }
    for (unsigned next = 0U; next < visited_count; next++) {
        check_standing(&visited[next]);
        check_answers(&visited[next]);
        for (unsigned step = 0U; step < STEPS; step++) {
            state_machine_t machine = visited[next];
            if (take_step(&machine, step)) {
                check_step(&visited[next], &machine, step);
                visit(&machine);
            }
        }
    }
}

static void every_reachable_condition_satisfies_the_invariants(void)
{
    explore();
    TEST_ASSERT_TRUE_MESSAGE(visited_count > 50U, "visited at most 50 conditions");
    for (unsigned state = 0U; state < STATE_COUNT; state++) { // All states of the table are reached.
        bool is_reached = false;
        for (unsigned i = 0U; i < visited_count; i++) {
            is_reached = is_reached || (visited[i].state == (state_t)state);
        }
        TEST_ASSERT_TRUE(is_reached);
    }
}

/// Returns the length of the longest chain of outcomes; fails the test if a chain does not end.
static unsigned longest_sequence(const state_machine_t* machine, unsigned depth)
{
    TEST_ASSERT_TRUE_MESSAGE(depth < 16U, "a chain of 16 outcomes does not end");
    if (machine->action == ACTION_NONE) {
        return depth;
    }
    unsigned longest = depth;
    for (unsigned outcome = 0U; outcome < 3U; outcome++) {
        state_machine_t next = *machine;
        subsystem_state_machine_outcome(&next, (state_outcome_t)outcome);
        const unsigned length = longest_sequence(&next, depth + 1U);
        longest               = (length > longest) ? length : longest;
    }
    return longest;
}

static void every_sequence_of_transitions_ends_whichever_actions_fail(void)
{
    explore();
    for (unsigned i = 0U; i < visited_count; i++) {
        TEST_ASSERT_TRUE(longest_sequence(&visited[i], 0U) <= 6U);
    }
}

static void every_sequence_of_transitions_reaches_its_target_if_nothing_fails(void)
{
    explore();
    for (unsigned i = 0U; i < visited_count; i++) {
        state_machine_t machine = visited[i];
        const state_t target    = machine.target;
        const bool had_failed   = machine.has_failed;
        while (machine.action != ACTION_NONE) {
            subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
            TEST_ASSERT_EQUAL_MESSAGE(target, machine.target, "the target changed although nothing failed");
        }
        TEST_ASSERT_EQUAL(target, machine.state);
        TEST_ASSERT_EQUAL(had_failed, machine.has_failed);
    }
}

static void offline_can_be_reached_from_everywhere(void)
{
    explore();
    for (unsigned i = 0U; i < visited_count; i++) {
        state_machine_t machine = visited[i];
        (void)subsystem_state_machine_request(&machine, STATE_OFFLINE, CAUSE_SHUTDOWN);
        while (machine.action != ACTION_NONE) {
            subsystem_state_machine_outcome(&machine, OUTCOME_DONE);
        }
        TEST_ASSERT_EQUAL(STATE_OFFLINE, machine.state);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_reachable_condition_satisfies_the_invariants);
    RUN_TEST(every_sequence_of_transitions_ends_whichever_actions_fail);
    RUN_TEST(every_sequence_of_transitions_reaches_its_target_if_nothing_fails);
    RUN_TEST(offline_can_be_reached_from_everywhere);
    return UNITY_END();
}
