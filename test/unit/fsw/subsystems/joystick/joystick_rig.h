// SPDX-License-Identifier: Apache-2.0
/// The joystick with its real descriptor and a scripted device, to test its states.
#ifndef TEST_UNIT_FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_RIG_H
#define TEST_UNIT_FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_RIG_H

#include "fsw/subsystems/joystick/joystick.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include <stdbool.h>
#include <stdint.h>

#define HAND JOYSTICK_PORT_HAND_POSITION
#define ROBOT JOYSTICK_PORT_ROBOT_STATE
#define FAR_HAND JOYSTICK_PORT_HAND_MOTION
#define FAR_ROBOT JOYSTICK_PORT_ROBOT_CONTACT

extern subsystem_descriptor_t rig_descriptor;
extern scripted_bus_t rig_bus;
extern scripted_node_t* rig_stick;
extern subsystem_t rig_generic;
extern joystick_t rig_joystick;
extern const subsystem_callbacks_t* rig_callbacks;

typedef status_t (*rig_action_t)(void* self);

/// Load the descriptor; called once. Returns false and prints a message if it cannot be loaded.
bool rig_load(void);
/// Called before and after each test: a bus with the device, and the joystick in OFFLINE.
void rig_set_up(void);
void rig_tear_down(void);
/// Run one cycle, with an entry action or null. Returns the status of the action.
status_t rig_cycle(rig_action_t action);
/// Run cycles until the action ends. Returns its status.
status_t rig_run_action(rig_action_t action);
void rig_idle(unsigned cycles);
/// Entry action: apply rig_generic.configuration.
status_t rig_configure(void* self);
/// Go from OFFLINE up to a state in a configuration.
void rig_bring(uint16_t configuration, state_t state);
status_t rig_perform(uint16_t function, const void* arguments, uint32_t call_token);
/// Returns the torque of the last command to the device [Nm].
double rig_torque(unsigned axis);

#endif // TEST_UNIT_FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_RIG_H
