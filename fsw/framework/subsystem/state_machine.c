// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/state_machine.h"

#include "base/assertion.h"

#include <stddef.h>

// Rest states that can be requested, in the order of the tables' columns.
enum {
    TARGET_0,
    TARGET_3,
    TARGET_4,
    TARGET_5,
    TARGET_6,
    TARGET_COUNT
};
#define TARGET_NONE TARGET_COUNT

typedef enum {
    // The request is refused.
    NO,
    // The request is refused, because a transition is running.
    BUSY,
    DONE,          ///< The machine is already in that state.
    GO,            ///< Go towards the state, one transition after the other.
    GO_CONFIGURED, ///< GO if a configuration is applied, otherwise NO.
    UNDO,          ///< Turn back through the de-init states to OFFLINE.
    RETARGET       ///< The machine is already on the way down: end in OFFLINE.
} verdict_t;

// Table "Requests" of docs/states.md: row = present state, column = requested rest state.
static const uint8_t request_table[STATE_COUNT][TARGET_COUNT] = {
    [STATE_OFFLINE]           = {DONE, GO, NO, NO, NO},
    [STATE_SOFTWARE_INIT]     = {UNDO, BUSY, NO, NO, UNDO},
    [STATE_HARDWARE_INIT]     = {UNDO, BUSY, NO, NO, UNDO},
    [STATE_PRE_OPERATIONAL]   = {GO, DONE, GO_CONFIGURED, NO, GO},
    [STATE_SAFE_OPERATIONAL]  = {GO, GO, DONE, GO, GO},
    [STATE_OPERATIONAL]       = {GO, GO, GO, DONE, GO},
    [STATE_ERROR_OPERATIONAL] = {GO, NO, NO, NO, DONE},
    [STATE_POST_OPERATIONAL]  = {RETARGET, BUSY, NO, NO, RETARGET},
    [STATE_HARDWARE_DEINIT]   = {RETARGET, BUSY, NO, NO, RETARGET},
    [STATE_SOFTWARE_DEINIT]   = {RETARGET, BUSY, NO, NO, RETARGET},
};

typedef enum {
    STEP_NONE,
    STEP_SOFTWARE_INIT,
    STEP_HARDWARE_INIT,
    STEP_CONFIGURE,
    STEP_START,
    STEP_STOP,
    STEP_ENGAGE,
    STEP_DISENGAGE,
    STEP_SECURE,
    STEP_POST,
    STEP_HARDWARE_DEINIT,
    STEP_SOFTWARE_DEINIT,
    STEP_COUNT
} step_t;

// State, phase and action that a transition enters.
static const uint8_t steps[STEP_COUNT][3] = {
    [STEP_SOFTWARE_INIT]   = {STATE_SOFTWARE_INIT, PHASE_ENTERING, ACTION_SOFTWARE_INIT},
    [STEP_HARDWARE_INIT]   = {STATE_HARDWARE_INIT, PHASE_ENTERING, ACTION_HARDWARE_INIT},
    [STEP_CONFIGURE]       = {STATE_PRE_OPERATIONAL, PHASE_CONFIGURING, ACTION_CONFIGURE},
    [STEP_START]           = {STATE_SAFE_OPERATIONAL, PHASE_ENTERING, ACTION_START_CONTROL},
    [STEP_STOP]            = {STATE_SAFE_OPERATIONAL, PHASE_LEAVING, ACTION_STOP_CONTROL},
    [STEP_ENGAGE]          = {STATE_OPERATIONAL, PHASE_ENTERING, ACTION_ENGAGE},
    [STEP_DISENGAGE]       = {STATE_SAFE_OPERATIONAL, PHASE_ENTERING, ACTION_DISENGAGE},
    [STEP_SECURE]          = {STATE_ERROR_OPERATIONAL, PHASE_ENTERING, ACTION_SECURE},
    [STEP_POST]            = {STATE_POST_OPERATIONAL, PHASE_ENTERING, ACTION_POST},
    [STEP_HARDWARE_DEINIT] = {STATE_HARDWARE_DEINIT, PHASE_ENTERING, ACTION_HARDWARE_DEINIT},
    [STEP_SOFTWARE_DEINIT] = {STATE_SOFTWARE_DEINIT, PHASE_ENTERING, ACTION_SOFTWARE_DEINIT}};

// The next transition from a rest state towards a target. In other states, the outcome of the entry action
// determines the next transition.
static const uint8_t step_table[STATE_COUNT][TARGET_COUNT] = {
    [STATE_OFFLINE]           = {STEP_NONE, STEP_SOFTWARE_INIT, STEP_NONE, STEP_NONE, STEP_NONE},
    [STATE_PRE_OPERATIONAL]   = {STEP_POST, STEP_NONE, STEP_START, STEP_NONE, STEP_SECURE},
    [STATE_SAFE_OPERATIONAL]  = {STEP_STOP, STEP_STOP, STEP_NONE, STEP_ENGAGE, STEP_SECURE},
    [STATE_OPERATIONAL]       = {STEP_DISENGAGE, STEP_DISENGAGE, STEP_DISENGAGE, STEP_NONE, STEP_SECURE},
    [STATE_ERROR_OPERATIONAL] = {STEP_POST, STEP_NONE, STEP_NONE, STEP_NONE, STEP_NONE}};

typedef enum {
    STAY,
    TURN_BACK,  ///< Undo the initialisation, down to OFFLINE.
    TO_ERROR,   ///< Go to ERROR_OPERATIONAL immediately.
    TO_SAFE,    ///< Go to SAFE_OPERATIONAL.
    TO_OFFLINE, ///< React as to a request for OFFLINE.
    END_OFFLINE ///< The machine is already on the way down: end in OFFLINE.
} reaction_t;

static const uint8_t reaction_targets[] = {[TURN_BACK]   = STATE_OFFLINE,
                                           [TO_ERROR]    = STATE_ERROR_OPERATIONAL,
                                           [TO_SAFE]     = STATE_SAFE_OPERATIONAL,
                                           [TO_OFFLINE]  = STATE_OFFLINE,
                                           [END_OFFLINE] = STATE_OFFLINE};

// Table "Events" of docs/states.md: row = event, column = present state.
static const uint8_t event_table[STATE_EVENT_COUNT][STATE_COUNT] = {
    [EVENT_OWN_HIGH]        = {STAY, TURN_BACK, TURN_BACK, TO_ERROR, TO_ERROR, TO_ERROR, STAY, END_OFFLINE,
                               END_OFFLINE, END_OFFLINE},
    [EVENT_NETWORK_FAILED]  = {STAY, TURN_BACK, TURN_BACK, TO_ERROR, TO_ERROR, TO_ERROR, STAY, END_OFFLINE,
                               END_OFFLINE, END_OFFLINE},
    [EVENT_MEDIUM_ORDER]    = {STAY, STAY, STAY, STAY, STAY, TO_SAFE, STAY, STAY, STAY, STAY},
    [EVENT_SUPERVISOR_LOST] = {STAY, STAY, STAY, STAY, STAY, TO_SAFE, STAY, STAY, STAY, STAY},
    [EVENT_SHUTDOWN]        = {STAY, TURN_BACK, TURN_BACK, TO_OFFLINE, TO_OFFLINE, TO_OFFLINE, TO_OFFLINE,
                               END_OFFLINE, END_OFFLINE, END_OFFLINE},
};

static unsigned column_of(const state_t target)
{
    static const unsigned char columns[STATE_COUNT] = {TARGET_0,    TARGET_NONE, TARGET_NONE, TARGET_3,
                                                       TARGET_4,    TARGET_5,    TARGET_6,    TARGET_NONE,
                                                       TARGET_NONE, TARGET_NONE};
    return ((unsigned)target < (unsigned)STATE_COUNT) ? columns[target] : (unsigned)TARGET_NONE;
}

/// Enter a state and phase, and record the transition if one of them is new.
static void enter(state_machine_t* const machine, const state_t state, const state_phase_t phase,
                  const state_action_t action)
{
    const bool is_new = (machine->state != state) || (machine->phase != phase);
    if (is_new) {
        FSW_ASSERT(machine->transition_count < STATE_TRANSITIONS_MAX);
        machine->transitions[machine->transition_count] =
            (state_transition_t){.previous = (uint8_t)machine->state,
                                 .state    = (uint8_t)state,
                                 .phase    = (uint8_t)phase,
                                 .cause    = (uint8_t)machine->cause};
        machine->transition_count++;
    }
    machine->state  = state;
    machine->phase  = phase;
    machine->action = action;
}

static void take_step(state_machine_t* const machine, const step_t step)
{
    FSW_ASSERT(step != STEP_NONE);
    enter(machine, (state_t)steps[step][0], (state_phase_t)steps[step][1], (state_action_t)steps[step][2]);
}

static void rest(state_machine_t* const machine, const state_t state, const state_phase_t phase)
{
    enter(machine, state, phase, ACTION_NONE);
}

static void rest_in_pre_operational(state_machine_t* const machine)
{
    rest(machine, STATE_PRE_OPERATIONAL, machine->is_configured ? PHASE_CONFIGURED : PHASE_UNCONFIGURED);
}

/// Start the next transition towards the target, or rest if the target is reached.
static void advance(state_machine_t* const machine)
{
    const unsigned column = column_of(machine->target);
    FSW_ASSERT(column != (unsigned)TARGET_NONE);
    if (machine->state != machine->target) {
        take_step(machine, (step_t)step_table[machine->state][column]);
    }
}

/// Abort the present transition and start towards another target.
static void set_off(state_machine_t* const machine, const state_t target, const state_cause_t cause)
{
    machine->is_superseded  = (machine->action != ACTION_NONE); // At rest there is no request to supersede.
    machine->target         = target;
    machine->cause          = cause;
    machine->has_failed     = false;
    machine->is_backing_out = false;
}

static void turn_back(state_machine_t* const machine)
{
    take_step(machine, (machine->state == STATE_SOFTWARE_INIT) ? STEP_SOFTWARE_DEINIT : STEP_HARDWARE_DEINIT);
}

void subsystem_state_machine_init(state_machine_t* const machine, const bool is_descriptor_valid)
{
    FSW_ASSERT(machine != NULL);
    *machine = (state_machine_t){.state  = STATE_OFFLINE,
                                 .phase  = is_descriptor_valid ? PHASE_IDLE : PHASE_INVALID,
                                 .target = STATE_OFFLINE,
                                 .action = ACTION_NONE};
}

void subsystem_state_machine_validate(state_machine_t* const machine)
{
    FSW_ASSERT(machine != NULL);
    machine->transition_count = 0U;
    machine->is_superseded    = false;
    if (machine->phase == PHASE_INVALID) {
        machine->cause = CAUSE_REQUEST;
        rest(machine, STATE_OFFLINE, PHASE_IDLE);
    }
}

/// True if the running action makes the devices safe: a transition further down must wait until it ends.
static bool must_finish(const state_machine_t* const machine, const state_t target)
{
    return (machine->action == ACTION_SECURE) ||
           ((machine->action == ACTION_DISENGAGE) && (target != STATE_ERROR_OPERATIONAL));
}

static bool is_preempting(const state_t target)
{
    return (target == STATE_OFFLINE) || (target == STATE_ERROR_OPERATIONAL);
}

state_answer_t subsystem_state_machine_verdict(const state_machine_t* const machine, const state_t target)
{
    FSW_ASSERT(machine != NULL);
    const unsigned column = column_of(target);
    if (column == (unsigned)TARGET_NONE) {
        return ANSWER_NO;
    }
    const verdict_t verdict = (verdict_t)request_table[machine->state][column];
    const bool is_at_rest   = (machine->action == ACTION_NONE);
    if ((verdict == NO) || ((machine->phase == PHASE_INVALID) && (target != STATE_OFFLINE)) ||
        ((verdict == GO_CONFIGURED) && is_at_rest && !machine->is_configured)) {
        return ANSWER_NO;
    }
    if ((verdict == BUSY) || (!is_at_rest && !is_preempting(target))) {
        return ANSWER_BUSY;
    }
    const bool is_on_the_way = !is_at_rest && (machine->target == target);
    return ((verdict == DONE) && (is_at_rest || is_on_the_way)) ? ANSWER_DONE : ANSWER_STARTED;
}

state_answer_t subsystem_state_machine_request(state_machine_t* const machine, const state_t target,
                                               const state_cause_t cause)
{
    const state_answer_t answer = subsystem_state_machine_verdict(machine, target);
    machine->transition_count   = 0U;
    machine->is_superseded      = false;
    if (answer != ANSWER_STARTED) {
        return answer;
    }
    const verdict_t verdict = (verdict_t)request_table[machine->state][column_of(target)];
    set_off(machine, ((verdict == UNDO) || (verdict == RETARGET)) ? STATE_OFFLINE : target, cause);
    if (verdict == UNDO) {
        turn_back(machine);
    } else if ((verdict != RETARGET) && !must_finish(machine, target)) {
        advance(machine);
    }
    return ANSWER_STARTED;
}

state_answer_t subsystem_state_machine_configure(state_machine_t* const machine)
{
    FSW_ASSERT(machine != NULL);
    machine->transition_count = 0U;
    machine->is_superseded    = false;
    if (machine->state != STATE_PRE_OPERATIONAL) {
        return ANSWER_NO;
    }
    if (machine->action != ACTION_NONE) {
        return ANSWER_BUSY;
    }
    set_off(machine, STATE_PRE_OPERATIONAL, CAUSE_REQUEST);
    machine->is_configured = false;
    take_step(machine, STEP_CONFIGURE);
    return ANSWER_STARTED;
}

bool subsystem_state_machine_event(state_machine_t* const machine, const state_event_t event,
                                   const state_cause_t cause)
{
    FSW_ASSERT((machine != NULL) && ((unsigned)event < (unsigned)STATE_EVENT_COUNT));
    machine->transition_count = 0U;
    machine->is_superseded    = false;
    const reaction_t reaction = (reaction_t)event_table[event][machine->state];
    if ((reaction == STAY) || ((reaction == END_OFFLINE) && (machine->target == STATE_OFFLINE))) {
        return false;
    }
    set_off(machine, (state_t)reaction_targets[reaction], cause);
    if (reaction == TURN_BACK) {
        turn_back(machine);
    } else if (reaction == TO_ERROR) {
        take_step(machine, STEP_SECURE);
    } else if ((reaction != END_OFFLINE) && !must_finish(machine, machine->target)) {
        advance(machine);
    } else {
        // The running action ends first.
    }
    return true;
}

/// Continue after an entry action that succeeded.
static void follow_done(state_machine_t* const machine)
{
    switch (machine->action) {
    case ACTION_SOFTWARE_INIT:
        take_step(machine, STEP_HARDWARE_INIT);
        break;
    case ACTION_HARDWARE_INIT:
        rest_in_pre_operational(machine);
        break;
    case ACTION_CONFIGURE:
        machine->is_configured = true;
        rest_in_pre_operational(machine);
        break;
    case ACTION_STOP_CONTROL:
        if (machine->is_backing_out) {
            machine->is_backing_out = false;
            rest_in_pre_operational(machine);
        } else {
            take_step(machine, STEP_POST);
        }
        break;
    case ACTION_SECURE:
        rest(machine, STATE_ERROR_OPERATIONAL, PHASE_SECURED);
        advance(machine);
        break;
    case ACTION_POST:
        machine->is_configured = false;
        if (machine->target == STATE_PRE_OPERATIONAL) {
            rest_in_pre_operational(machine);
        } else {
            take_step(machine, STEP_HARDWARE_DEINIT);
        }
        break;
    case ACTION_HARDWARE_DEINIT:
        take_step(machine, STEP_SOFTWARE_DEINIT);
        break;
    case ACTION_SOFTWARE_DEINIT:
        rest(machine, STATE_OFFLINE, PHASE_IDLE);
        break;
    default: // START_CONTROL, ENGAGE, DISENGAGE: the state is reached.
        rest(machine, machine->state, PHASE_IDLE);
        advance(machine);
        break;
    }
}

/// Continue after an entry action that failed; the request then has failed, too.
static void follow_failed(state_machine_t* const machine)
{
    machine->has_failed = true;
    switch (machine->action) {
    case ACTION_SOFTWARE_INIT:
    case ACTION_HARDWARE_INIT:
        machine->target = STATE_OFFLINE;
        turn_back(machine);
        break;
    case ACTION_CONFIGURE:
        machine->is_configured = false;
        rest_in_pre_operational(machine);
        break;
    case ACTION_START_CONTROL:
        machine->target         = STATE_PRE_OPERATIONAL;
        machine->is_backing_out = true;
        take_step(machine, STEP_STOP);
        break;
    case ACTION_ENGAGE:
        machine->target = STATE_SAFE_OPERATIONAL;
        take_step(machine, STEP_DISENGAGE);
        break;
    case ACTION_DISENGAGE:
        machine->target = STATE_ERROR_OPERATIONAL;
        take_step(machine, STEP_SECURE);
        break;
    case ACTION_SECURE:
        rest(machine, STATE_ERROR_OPERATIONAL, PHASE_UNSECURED);
        advance(machine);
        break;
    case ACTION_POST:
        machine->target        = STATE_OFFLINE;
        machine->is_configured = false;
        take_step(machine, STEP_HARDWARE_DEINIT);
        break;
    default: // STOP_CONTROL and the de-init actions: the transition continues downwards.
        follow_done(machine);
        break;
    }
}

void subsystem_state_machine_outcome(state_machine_t* const machine, const state_outcome_t outcome)
{
    FSW_ASSERT((machine != NULL) && (machine->action != ACTION_NONE));
    machine->transition_count = 0U;
    machine->is_superseded    = false;
    if (outcome == OUTCOME_DONE) {
        follow_done(machine);
    } else {
        machine->cause = (outcome == OUTCOME_TIMEOUT) ? CAUSE_TIMEOUT : CAUSE_OWN_ERROR;
        follow_failed(machine);
    }
}
