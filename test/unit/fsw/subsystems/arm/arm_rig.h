// SPDX-License-Identifier: Apache-2.0
/// The subsystem arm with the descriptor of the six-joint arm ur5e, on two scripted buses, with a test double
/// of the generic subsystem.
#ifndef TEST_UNIT_FSW_SUBSYSTEMS_ARM_ARM_RIG_H
#define TEST_UNIT_FSW_SUBSYSTEMS_ARM_ARM_RIG_H

#include "fsw/subsystems/arm/arm.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#define RIG_JOINTS 6U

enum {
    RIG_POSITION     = 1,
    RIG_TORQUE       = 2,
    RIG_COMPLIANT    = 3,
    RIG_TELEPRESENCE = 4
}; // Configurations.
enum {
    RIG_ROBOT_STATE   = 1,
    RIG_HAND_POSITION = 2
}; // Ports.
enum {
    RIG_MOVE_TO  = 1,
    RIG_LINE_TO  = 2,
    RIG_STOP     = 3,
    RIG_ADD_VIA  = 4,
    RIG_CLR_VIA  = 5,
    RIG_MOVE_VIA = 6,
    RIG_ADD_POSE = 7,
    RIG_LINE_VIA = 8
}; // Functions.

typedef status_t (*rig_action_t)(void* self);

typedef struct {
    double position[RIG_JOINTS];
    double share;
} rig_move_to_t;

typedef struct {
    double position[3];
    double rotation[3];
    double share;
} rig_line_to_t;

typedef struct {
    double share;
    double blend;
} rig_move_through_t;

typedef struct {
    double position[3];
    double rotation[3];
} rig_pose_t;

extern subsystem_descriptor_t rig_descriptor;
extern scripted_node_t* rig_joints[RIG_JOINTS];
extern subsystem_t rig_generic;
extern arm_t rig_arm;
extern const double rig_pose_rad[RIG_JOINTS]; ///< A bent arm, far from singular poses.

/// Load the descriptor; called once before the tests.
void rig_load(void);
void rig_set_up(void);
void rig_tear_down(void);
/// Let the drives report an arm at rest in this pose, with the torques of its weight.
void rig_show(const double pose_rad[RIG_JOINTS]);
/// Run one cycle, with an entry action or null. Returns the status of the action.
status_t rig_cycle(rig_action_t action);
void rig_idle(unsigned cycles);
/// Perform the entry actions up to a state in a configuration.
void rig_bring(uint16_t configuration, state_t state);
status_t rig_perform(uint16_t function, const void* arguments, uint32_t call_token);
/// The model and limits of the descriptor, without devices.
void rig_model(arm_model_t* out_model, arm_limits_t* out_limits);

#endif // TEST_UNIT_FSW_SUBSYSTEMS_ARM_ARM_RIG_H
