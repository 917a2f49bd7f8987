// SPDX-License-Identifier: Apache-2.0
/// For the tests of the table of states: machines in each state of docs/states.md, and transitions that are
/// followed to their end.
#ifndef TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_MACHINE_STATES_H
#define TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_MACHINE_STATES_H

#include "fsw/framework/subsystem/state_machine.h"

#include <stddef.h>

#define STATES_TEXT 32U ///< Longest list of states [characters].

/// Returns a machine in this state: a rest state at rest (3, 4, 5 and 6 with a configuration), any other
/// state with its action running: 1 and 2 on the way to 3, 7 on the way to 3, 8 and 9 on the way to 0.
state_machine_t machine_in(state_t state);
/// Returns a machine in PRE_OPERATIONAL without a configuration.
state_machine_t machine_unconfigured(void);
/// Returns a machine whose `action` is running; in states that can be left upwards and downwards, it is on
/// the way down.
state_machine_t machine_running(state_action_t action);

/// Answer every action with an outcome until the machine rests; adds the states to `states_passed`,
/// which begin with those of the last call: "7 8 9 0". Fails the test if it does not end.
void machine_finish(state_machine_t* machine, state_outcome_t outcome, char states_passed[STATES_TEXT]);
/// Check that the transitions of the last call lead from a state to the present one without a gap.
void machine_check_transitions(const state_machine_t* machine, state_t before, state_phase_t phase_before);

#endif // TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_MACHINE_STATES_H
