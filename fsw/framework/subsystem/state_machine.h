// SPDX-License-Identifier: Apache-2.0
/// The state machine of every subsystem, with ten states and its rules in tables (docs/states.md).
///
/// It uses no time, no messages and no devices. The generic subsystem passes requests, events and the
/// outcomes of entry actions to the machine, and performs the action that the machine requests. The machine
/// always reports its actual state.
///
/// Ownership  The caller provides state_machine_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_SUBSYSTEM_STATE_MACHINE_H
#define FSW_FRAMEWORK_SUBSYSTEM_STATE_MACHINE_H

#include <stdbool.h>
#include <stdint.h>

typedef enum { // The numbers are used on the wire.
    STATE_OFFLINE           = 0,
    STATE_SOFTWARE_INIT     = 1,
    STATE_HARDWARE_INIT     = 2,
    STATE_PRE_OPERATIONAL   = 3,
    STATE_SAFE_OPERATIONAL  = 4,
    STATE_OPERATIONAL       = 5,
    STATE_ERROR_OPERATIONAL = 6,
    STATE_POST_OPERATIONAL  = 7,
    STATE_HARDWARE_DEINIT   = 8,
    STATE_SOFTWARE_DEINIT   = 9,
    STATE_COUNT             = 10
} state_t;

typedef enum {              // Sub-division of a state, on the wire in TM[129,2] and TM[129,5].
    PHASE_IDLE         = 0, ///< At rest.
    PHASE_ENTERING     = 1, ///< The entry action is running.
    PHASE_INVALID      = 2, ///< OFFLINE: the descriptor was refused.
    PHASE_UNCONFIGURED = 3, ///< PRE_OPERATIONAL without a configuration.
    PHASE_CONFIGURING  = 4, ///< PRE_OPERATIONAL: a configuration is being applied.
    PHASE_CONFIGURED   = 5, ///< PRE_OPERATIONAL with a configuration.
    /// Controllers or actuators are being stopped, because the machine goes to a lower state.
    PHASE_LEAVING   = 6,
    PHASE_SECURED   = 7, ///< ERROR_OPERATIONAL: devices are in their safe state.
    PHASE_UNSECURED = 8  ///< ERROR_OPERATIONAL: the safe state could not be reached.
} state_phase_t;

typedef enum { // Why a transition happened, on the wire in TM[129,2].
    CAUSE_REQUEST         = 0,
    CAUSE_OWN_ERROR       = 1,
    CAUSE_NETWORK         = 2,
    CAUSE_PLAN            = 3,
    CAUSE_SHUTDOWN        = 4,
    CAUSE_TIMEOUT         = 5,
    CAUSE_SUPERVISOR_LOST = 6
} state_cause_t;

typedef enum { // Next action of the generic subsystem.
    ACTION_NONE = 0,
    ACTION_SOFTWARE_INIT,   ///< Publish parameters, set initial values.
    ACTION_HARDWARE_INIT,   ///< Switch power on, wait for the boot-up of devices, initialise them.
    ACTION_CONFIGURE,       ///< Revoke the old configuration, apply the selected one, connect devices.
    ACTION_START_CONTROL,   ///< Switch controllers on; actuators stay off.
    ACTION_STOP_CONTROL,    ///< Switch controllers off.
    ACTION_ENGAGE,          ///< Switch actuators on, without a jump of the motion.
    ACTION_DISENGAGE,       ///< Switch actuators off; controllers continue.
    ACTION_SECURE,          ///< Bring devices to their safe state; switch controllers off.
    ACTION_POST,            ///< Close links, stop HK, disconnect devices, revoke the configuration.
    ACTION_HARDWARE_DEINIT, ///< Switch devices and power off.
    ACTION_SOFTWARE_DEINIT, ///< Withdraw parameters, release resources.
    ACTION_COUNT
} state_action_t;

typedef enum {
    EVENT_OWN_HIGH = 0,   ///< The subsystem has raised a high-severity event.
    EVENT_NETWORK_FAILED, ///< A member of the subsystem's real-time network failed.
    /// After a medium-severity event, the supervisor has not commanded a reaction within 4 cycles.
    EVENT_MEDIUM_ORDER,
    /// No message of the supervisor has arrived for too long.
    EVENT_SUPERVISOR_LOST,
    EVENT_SHUTDOWN, ///< Request for OFFLINE that overrides a network member in OPERATIONAL.
    STATE_EVENT_COUNT
} state_event_t;

typedef enum {
    ANSWER_DONE,    ///< The machine is already in the requested state.
    ANSWER_STARTED, ///< The transition has begun; it ends as reached, failed or superseded.
    ANSWER_BUSY,    ///< The running action may not be pre-empted by this request.
    ANSWER_NO       ///< The present state does not allow the request.
} state_answer_t;

typedef enum {
    OUTCOME_DONE,
    OUTCOME_FAILED, ///< The action was refused or has failed.
    OUTCOME_TIMEOUT
} state_outcome_t;

typedef struct {      // One reported transition.
    uint8_t previous; ///< state_t.
    uint8_t state;    ///< state_t.
    uint8_t phase;    ///< state_phase_t.
    uint8_t cause;    ///< state_cause_t.
} state_transition_t;

#define STATE_TRANSITIONS_MAX 8U ///< Largest number of transitions in one call.

typedef struct { // Read-only outside; changed by the functions below.
    state_t state;
    state_phase_t phase;
    state_t target;        ///< State in which the transitions end; equal to `state` at rest.
    state_action_t action; ///< Action to be performed now; ACTION_NONE at rest.
    state_cause_t cause;
    bool is_configured;
    bool has_failed;     ///< A transition towards the requested state failed.
    bool is_superseded;  ///< The last call pre-empted an earlier request.
    bool is_backing_out; ///< START_CONTROL failed: stop the controllers and stay configured.
    state_transition_t transitions[STATE_TRANSITIONS_MAX]; ///< Transitions of the last call, in order.
    uint8_t transition_count;
} state_machine_t;

/// Begin in OFFLINE, at rest; or in OFFLINE / PHASE_INVALID if the descriptor was refused (only requests
/// for state 0 are then accepted).
void subsystem_state_machine_init(state_machine_t* machine, bool is_descriptor_valid);
/// A valid descriptor replaces the refused one: OFFLINE / PHASE_INVALID becomes OFFLINE at rest.
void subsystem_state_machine_validate(state_machine_t* machine);
/// Request a rest state (0, 3, 4, 5, 6) with a cause. Other targets return ANSWER_NO.
state_answer_t subsystem_state_machine_request(state_machine_t* machine, state_t target, state_cause_t cause);
/// Returns the answer to a request without performing it.
state_answer_t subsystem_state_machine_verdict(const state_machine_t* machine, state_t target);
/// Request a configuration in PRE_OPERATIONAL, also a repeated one. ANSWER_STARTED, ANSWER_BUSY, ANSWER_NO.
state_answer_t subsystem_state_machine_configure(state_machine_t* machine);
/// Process an event of the table "Events" (docs/states.md). Returns true if it changed anything.
bool subsystem_state_machine_event(state_machine_t* machine, state_event_t event, state_cause_t cause);
/// Report that the running action has ended. machine->action is then the next action, or ACTION_NONE.
void subsystem_state_machine_outcome(state_machine_t* machine, state_outcome_t outcome);

#endif // FSW_FRAMEWORK_SUBSYSTEM_STATE_MACHINE_H
