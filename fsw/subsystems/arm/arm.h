// SPDX-License-Identifier: Apache-2.0
/// The subsystem of any arm: a chain of 1 to 12 joints, each with a drive. Its descriptor contains the model
/// of the arm, its limits and its gains (docs/arm.md); the program contains no data of a particular robot.
///
/// MOVE_TO moves all joints at the same time, LINE_TO the tool along a straight line, MOVE_VIA all joints
/// through the points that ADD_VIA has collected, LINE_VIA the tool through the poses of ADD_POSE; CLR_VIA
/// drops these points and poses, and STOP ends a motion. The drives close the control loop of the joints
/// (mode of operation CSP), or the subsystem closes it (CST); in CST the tool can also be compliant. A motion
/// that is not possible is refused with a reason (arm_refusal_reason_t).
///
/// A configuration with the port HAND_POSITION is for telepresence: an operator's hand moves the tool
/// (arm_hand.h), and the port ROBOT_STATE returns the force on the tool.
///
/// Ownership  The program provides arm_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks never block.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_H
#define FSW_SUBSYSTEMS_ARM_ARM_H

#include "base/capacities.h"
#include "fsw/drives/drives.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "fsw/subsystems/arm/arm_control.h"
#include "fsw/subsystems/arm/arm_force.h"
#include "fsw/subsystems/arm/arm_hand.h"
#include "fsw/subsystems/arm/arm_parameters.h"
#include "fsw/subsystems/arm/arm_path.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Storage of the program for optional services: the largest capacities that a descriptor may list.
#define ARM_DEVICE_REQUESTS 2U
#define ARM_STATISTICS 64U
#define ARM_MEMORY_OPERATIONS 2U
#define ARM_MONITORS 64U
#define ARM_FUNCTIONAL_MONITORS 16U

typedef struct {     // All fields are private.
    drives_t drives; ///< First member, because the callbacks of drives.h get the same context.
    subsystem_t* generic;
    arm_definitions_t definitions;
    arm_parameters_t parameters;
    arm_model_t model;
    arm_limits_t limits;
    arm_control_t control;
    bool is_torque_mode;
    uint16_t hand_port; ///< Ports of the configuration, if is_telepresence.
    uint16_t robot_port;
    bool is_telepresence; ///< The configuration is for telepresence.
    arm_hand_settings_t hand_settings;
    arm_hand_t hand;
    bool has_hand; ///< hand_rad contains a fresh sample.
    double hand_rad[ARM_HAND_AXES];
    arm_force_t force;
    arm_motion_t motion; ///< Desired motion.
    arm_path_t path;
    arm_path_t line; ///< Line or trajectory of the tool that is being checked.
    arm_line_check_t check;
    arm_trajectory_t points;     ///< Points that ADD_VIA has collected.
    arm_trajectory_t poses;      ///< Poses that ADD_POSE has collected.
    arm_trajectory_t trajectory; ///< Trajectory that is being planned or performed.
    bool is_planning;
    bool is_checking;
    bool is_moving;
    bool is_stopping;    ///< The present motion ends before its goal.
    uint32_t move_token; ///< Token of the running function; 0: none.
} arm_t;
CAPACITY_CHECK(arm_begins_with_drives, offsetof(arm_t, drives) == 0U);

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void arm_init(arm_t* arm, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns the callbacks for the generic subsystem; their context is the arm_t.
const subsystem_callbacks_t* arm_callbacks(void);

#endif // FSW_SUBSYSTEMS_ARM_ARM_H
