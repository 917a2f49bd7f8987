// SPDX-License-Identifier: Apache-2.0
/// The manipulator with its real descriptor, scripted drives and a scripted joystick, to test its states.
#ifndef TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_RIG_H
#define TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_RIG_H

#include "fsw/subsystems/manipulator/manipulator.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include <stdbool.h>
#include <stdint.h>

#define HAND MANIPULATOR_PORT_HAND_POSITION
#define ROBOT MANIPULATOR_PORT_ROBOT_STATE
#define FAR_HAND MANIPULATOR_PORT_HAND_MOTION
#define FAR_ROBOT MANIPULATOR_PORT_ROBOT_CONTACT
#define GRAVITY1 5.9 ///< Torques that hold the arm in its home pose [Nm].
#define GRAVITY2 2.124

extern subsystem_descriptor_t rig_descriptor;
extern scripted_bus_t rig_bus;
extern scripted_node_t* rig_joints[2];
extern subsystem_t rig_generic;
extern manipulator_t rig_manipulator;
extern const subsystem_callbacks_t* rig_callbacks;

typedef status_t (*rig_action_t)(void* self);

/// Load the descriptor; called once. Returns false and prints a message if it cannot be loaded.
bool rig_load(void);
/// Called before and after each test: a bus with two drives, and the manipulator in OFFLINE.
void rig_set_up(void);
void rig_tear_down(void);
/// Let the drives report a motionless arm in its home pose with these joint torques.
void rig_show(double torque1_nm, double torque2_nm);
/// Run one cycle, with an entry action or null. Returns the status of the action.
status_t rig_cycle(rig_action_t action);
/// Run cycles until the action ends. Returns its status.
status_t rig_run_action(rig_action_t action);
void rig_idle(unsigned cycles);
/// Entry action: apply rig_generic.configuration.
status_t rig_configure(void* self);
/// Store a new sample of the joystick's link.
void rig_hand_at(double first_rad, double second_rad);
/// Go from OFFLINE up to a state in a configuration.
void rig_bring(uint16_t configuration, state_t state);
status_t rig_perform(uint16_t function, const void* arguments, uint32_t call_token);
const manipulator_cur_values_t* rig_values(void);

#endif // TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_RIG_H
