// SPDX-License-Identifier: Apache-2.0
// Proves: every call in every sound state leaves a sound state, and the initial state is sound, so every
//     reachable state is sound. OPERATIONAL is entered only from SAFE_OPERATIONAL; controllers start and
//     actuators engage only with a configuration; an error of high severity, of the subsystem or of its
//     network, enters ERROR_OPERATIONAL in the same call; after an event (all are errors or a shutdown) the
//     state is never OPERATIONAL; a refused request changes nothing; each call records exactly its changes of
//     state and phase; no assertion of the state machine fails.
// Bounds: every machine that is_sound accepts, one call with any arguments; by induction any number of calls.
// Replaced: nothing.
// Sources: fsw/framework/subsystem/state_machine.c
// Options: --unwind 9
// Quick: yes
// Fault: fsw/framework/subsystem/state_machine.c
//   - [STATE_PRE_OPERATIONAL]   = {STEP_POST, STEP_NONE, STEP_START, STEP_NONE, STEP_SECURE},
//   + [STATE_PRE_OPERATIONAL]   = {STEP_POST, STEP_NONE, STEP_ENGAGE, STEP_NONE, STEP_SECURE},
// Fault: fsw/framework/subsystem/state_machine.c
//   - [EVENT_MEDIUM_ORDER]    = {STAY, STAY, STAY, STAY, STAY, TO_SAFE,
//   + [EVENT_MEDIUM_ORDER]    = {STAY, STAY, STAY, STAY, STAY, STAY,
// Fault: fsw/framework/subsystem/state_machine.c
//   - [EVENT_OWN_HIGH]        = {STAY, TURN_BACK, TURN_BACK, TO_ERROR, TO_ERROR,
//   + [EVENT_OWN_HIGH]        = {STAY, TURN_BACK, TURN_BACK, TO_ERROR, STAY,
// Fault: fsw/framework/subsystem/state_machine.c
//   - ((verdict == GO_CONFIGURED) && is_at_rest && !machine->is_configured)) {
//   + ((verdict == GO_CONFIGURED) && is_at_rest && machine->has_failed && !machine->is_configured)) {
// Fault: fsw/framework/subsystem/state_machine.c
//   - const bool is_new = (machine->state != state) || (machine->phase != phase);
//   + const bool is_new = (machine->state != state);
#include "fsw/framework/subsystem/state_machine.h"
#include "test/proof/proof.h"

typedef struct {
    state_t state;
    state_phase_t phase;
} stage_t;

/// State and phase while an action runs.
static const stage_t stages[ACTION_COUNT] = {
    [ACTION_SOFTWARE_INIT]   = {STATE_SOFTWARE_INIT, PHASE_ENTERING},
    [ACTION_HARDWARE_INIT]   = {STATE_HARDWARE_INIT, PHASE_ENTERING},
    [ACTION_CONFIGURE]       = {STATE_PRE_OPERATIONAL, PHASE_CONFIGURING},
    [ACTION_START_CONTROL]   = {STATE_SAFE_OPERATIONAL, PHASE_ENTERING},
    [ACTION_STOP_CONTROL]    = {STATE_SAFE_OPERATIONAL, PHASE_LEAVING},
    [ACTION_ENGAGE]          = {STATE_OPERATIONAL, PHASE_ENTERING},
    [ACTION_DISENGAGE]       = {STATE_SAFE_OPERATIONAL, PHASE_ENTERING},
    [ACTION_SECURE]          = {STATE_ERROR_OPERATIONAL, PHASE_ENTERING},
    [ACTION_POST]            = {STATE_POST_OPERATIONAL, PHASE_ENTERING},
    [ACTION_HARDWARE_DEINIT] = {STATE_HARDWARE_DEINIT, PHASE_ENTERING},
    [ACTION_SOFTWARE_DEINIT] = {STATE_SOFTWARE_DEINIT, PHASE_ENTERING},
};

#define BIT(state) (1U << (unsigned)(state))

/// Targets of an action, as bits.
static const uint16_t targets[ACTION_COUNT] = {
    [ACTION_SOFTWARE_INIT]   = BIT(STATE_PRE_OPERATIONAL),
    [ACTION_HARDWARE_INIT]   = BIT(STATE_PRE_OPERATIONAL),
    [ACTION_CONFIGURE]       = BIT(STATE_PRE_OPERATIONAL),
    [ACTION_START_CONTROL]   = BIT(STATE_SAFE_OPERATIONAL),
    [ACTION_STOP_CONTROL]    = BIT(STATE_OFFLINE) | BIT(STATE_PRE_OPERATIONAL),
    [ACTION_ENGAGE]          = BIT(STATE_OPERATIONAL),
    [ACTION_DISENGAGE]       = BIT(STATE_OFFLINE) | BIT(STATE_PRE_OPERATIONAL) | BIT(STATE_SAFE_OPERATIONAL),
    [ACTION_SECURE]          = BIT(STATE_OFFLINE) | BIT(STATE_ERROR_OPERATIONAL),
    [ACTION_POST]            = BIT(STATE_OFFLINE) | BIT(STATE_PRE_OPERATIONAL),
    [ACTION_HARDWARE_DEINIT] = BIT(STATE_OFFLINE),
    [ACTION_SOFTWARE_DEINIT] = BIT(STATE_OFFLINE),
};

static bool is_rest_stage(const state_machine_t* const machine)
{
    switch (machine->state) {
    case STATE_OFFLINE:
        return (machine->phase == PHASE_IDLE) || (machine->phase == PHASE_INVALID);
    case STATE_PRE_OPERATIONAL:
        return machine->phase == (machine->is_configured ? PHASE_CONFIGURED : PHASE_UNCONFIGURED);
    case STATE_SAFE_OPERATIONAL:
    case STATE_OPERATIONAL:
        return machine->phase == PHASE_IDLE;
    case STATE_ERROR_OPERATIONAL:
        return (machine->phase == PHASE_SECURED) || (machine->phase == PHASE_UNSECURED);
    default:
        return false;
    }
}

static bool is_sound(const state_machine_t* const machine)
{
    if (((unsigned)machine->action >= (unsigned)ACTION_COUNT) ||
        ((unsigned)machine->state >= (unsigned)STATE_COUNT) ||
        ((unsigned)machine->target >= (unsigned)STATE_COUNT)) {
        return false;
    }
    const bool is_active =
        (machine->state == STATE_SAFE_OPERATIONAL) || (machine->state == STATE_OPERATIONAL);
    const bool may_have_configuration = is_active || (machine->state == STATE_PRE_OPERATIONAL) ||
                                        (machine->state == STATE_ERROR_OPERATIONAL) ||
                                        (machine->state == STATE_POST_OPERATIONAL);
    if ((is_active && !machine->is_configured) || (machine->is_configured && !may_have_configuration) ||
        (machine->is_backing_out &&
         ((machine->action != ACTION_STOP_CONTROL) || (machine->target != STATE_PRE_OPERATIONAL)))) {
        return false;
    }
    if (machine->action == ACTION_NONE) {
        return is_rest_stage(machine) && (machine->target == machine->state);
    }
    return (machine->state == stages[machine->action].state) &&
           (machine->phase == stages[machine->action].phase) &&
           ((targets[machine->action] & BIT(machine->target)) != 0U) &&
           !((machine->action == ACTION_CONFIGURE) && machine->is_configured);
}

static state_machine_t any_sound_machine(void)
{
    state_machine_t machine;
    machine.is_configured    = nondet_bool();
    machine.has_failed       = nondet_bool();
    machine.is_superseded    = nondet_bool();
    machine.is_backing_out   = nondet_bool();
    machine.transition_count = nondet_u8();
    ASSUME(machine.transition_count <= STATE_TRANSITIONS_MAX);
    ASSUME(is_sound(&machine));
    return machine;
}

/// Compare all fields but is_superseded and the transitions: they describe the last call, so each call, also
/// a refused one, clears them.
static bool is_same(const state_machine_t* const one, const state_machine_t* const other)
{
    return (one->state == other->state) && (one->phase == other->phase) && (one->target == other->target) &&
           (one->action == other->action) && (one->cause == other->cause) &&
           (one->is_configured == other->is_configured) && (one->has_failed == other->has_failed) &&
           (one->is_backing_out == other->is_backing_out);
}

static void prove_event(const state_machine_t* const before, const state_machine_t* const after,
                        const unsigned event)
{
    const bool is_high = (event == (unsigned)EVENT_OWN_HIGH) || (event == (unsigned)EVENT_NETWORK_FAILED);
    const bool is_up = (before->state >= STATE_PRE_OPERATIONAL) && (before->state <= STATE_ERROR_OPERATIONAL);
    PROVE(IMPLIES(is_high && is_up, after->state == STATE_ERROR_OPERATIONAL),
          "an error enters ERROR_OPERATIONAL in the same call");
    PROVE(IMPLIES(is_high && is_up && (before->state != STATE_ERROR_OPERATIONAL),
                  after->action == ACTION_SECURE),
          "an error secures the devices");
    PROVE(IMPLIES(is_high && !is_up, after->target == STATE_OFFLINE),
          "an error in any other state leads to OFFLINE");
    PROVE(after->state != STATE_OPERATIONAL, "no event leaves the machine in OPERATIONAL");
}

/// True if the recorded transitions lead from the state before the call to the present state and phase.
static bool is_recorded(const state_machine_t* const before, const state_machine_t* const after)
{
    state_t state       = before->state;
    state_phase_t phase = before->phase;
    bool is_chain       = after->transition_count <= STATE_TRANSITIONS_MAX;
    for (unsigned i = 0U; i < STATE_TRANSITIONS_MAX; i++) {
        if (i < after->transition_count) {
            const state_transition_t* const one = &after->transitions[i];
            is_chain                            = is_chain && (one->previous == (uint8_t)state) &&
                       ((one->state != (uint8_t)state) || (one->phase != (uint8_t)phase));
            state = (state_t)one->state;
            phase = (state_phase_t)one->phase;
        }
    }
    return is_chain && (state == after->state) && (phase == after->phase);
}

/// Make one call with any arguments.
static void call(state_machine_t* const machine)
{
    const state_machine_t before = *machine;
    const uint8_t choice         = nondet_u8();
    const unsigned argument      = nondet_u8();
    if (choice == 0U) {
        const state_answer_t verdict = subsystem_state_machine_verdict(machine, (state_t)argument);
        const state_answer_t answer = subsystem_state_machine_request(machine, (state_t)argument, CAUSE_PLAN);
        PROVE(verdict == answer, "the verdict is the answer");
        PROVE(IMPLIES(answer != ANSWER_STARTED, is_same(machine, &before)),
              "what is refused changes nothing");
    } else if (choice == 1U) {
        const state_answer_t answer = subsystem_state_machine_configure(machine);
        PROVE(IMPLIES(answer != ANSWER_STARTED, is_same(machine, &before)),
              "what is refused changes nothing");
    } else if (choice == 2U) {
        ASSUME(argument < (unsigned)STATE_EVENT_COUNT);
        (void)subsystem_state_machine_event(machine, (state_event_t)argument, CAUSE_NETWORK);
        prove_event(&before, machine, argument);
    } else if (choice == 3U) {
        subsystem_state_machine_validate(machine);
    } else {
        ASSUME((machine->action != ACTION_NONE) && (argument <= (unsigned)OUTCOME_TIMEOUT));
        subsystem_state_machine_outcome(machine, (state_outcome_t)argument);
    }
    PROVE(IMPLIES((machine->state == STATE_OPERATIONAL) && (before.state != STATE_OPERATIONAL),
                  (before.state == STATE_SAFE_OPERATIONAL)),
          "OPERATIONAL is entered only from SAFE_OPERATIONAL");
    PROVE(IMPLIES((machine->action == ACTION_START_CONTROL) || (machine->action == ACTION_ENGAGE),
                  machine->is_configured),
          "controllers start and actuators engage only with a configuration");
    PROVE(is_recorded(&before, machine), "each change of state and phase is recorded");
    for (unsigned i = 0U; i < STATE_TRANSITIONS_MAX; i++) {
        PROVE(IMPLIES((i < machine->transition_count) &&
                          (machine->transitions[i].state == (uint8_t)STATE_OPERATIONAL),
                      (machine->transitions[i].previous == (uint8_t)STATE_SAFE_OPERATIONAL) ||
                          (machine->transitions[i].previous == (uint8_t)STATE_OPERATIONAL)),
              "no recorded transition enters OPERATIONAL from another state");
    }
}

void proof(void)
{
    state_machine_t machine;
    subsystem_state_machine_init(&machine, nondet_bool());
    PROVE(is_sound(&machine), "the machine begins sound");
    machine = any_sound_machine();
    call(&machine);
    PROVE(is_sound(&machine), "the machine stays sound");
}
