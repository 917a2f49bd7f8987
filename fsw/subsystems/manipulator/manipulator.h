// SPDX-License-Identifier: Apache-2.0
/// The subsystem MANIPULATOR: a two-joint torque-sensed arm.
///
/// STAND_ALONE (drives close the position loop) executes MOVE_TO; TELEPRESENCE (this subsystem closes the
/// torque loop) follows the joystick and sends it the external torque at the joints; TELEPRESENCE_REMOTE
/// does the same through a link with delay. A configuration follows the joystick if the mode of operation of
/// its devices is CST; the link has a delay if the configuration has the port HAND_MOTION. All tunable
/// values are in the parameters CONTROL, MODEL, REMOTE and TORQUE_LIMIT.
///
/// Ownership  The program provides manipulator_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks never block.
///
///     static manipulator_t manipulator;
///     manipulator_init(&manipulator, &subsystem, &resolver);
///     config.callbacks = manipulator_callbacks();
///     config.self      = &manipulator;
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_H

#include "base/capacities.h"
#include "fsw/drives/drives.h"
#include "fsw/framework/control/motion.h"
#include "fsw/framework/control/port_energy.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "fsw/subsystems/manipulator/manipulator_control.h"
#include "fsw/subsystems/manipulator/manipulator_identification.h"
#include "fsw/subsystems/manipulator/manipulator_tare.h"
#include "fsw/subsystems/manipulator/manipulator_yield.h"

#include "generated/manipulator_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {     // All fields are private.
    drives_t drives; ///< First member, because the callbacks of drives.h get the same context.
    subsystem_t* generic;
    manipulator_parameters_t parameters;
    bool is_torque_mode;
    bool is_remote; ///< The link to the joystick has a delay.
    manipulator_arm_control_t control;
    control_port_energy_t energy; ///< Energy at the port to the environment.
    manipulator_arm_tare_t tare;
    manipulator_arm_identification_t identification;
    manipulator_model_t model; ///< Model in use: that of the parameters, with the identified masses.
    bool has_zero;             ///< A tare has succeeded since HARDWARE_INIT.
    uint32_t tare_token;       ///< Token of the running function TARE; 0: none.
    bool has_hand;             ///< The joystick's angle is known in this cycle.
    double hand_rad[ARM_JOINTS];
    double paid_j; ///< Sum of energy that a joystick behind a link with delay has reported.
    manipulator_arm_yield_t yield;
    control_motion_t motion[ARM_JOINTS];
    control_motion_point_t point[ARM_JOINTS];
    bool is_moving;
    uint32_t move_token; ///< Token of the running function MOVE_TO; 0: none.
    bool is_beyond_limit[ARM_JOINTS];
} manipulator_t;
CAPACITY_CHECK(manipulator_begins_with_drives, offsetof(manipulator_t, drives) == 0U);

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void manipulator_init(manipulator_t* manipulator, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns the callbacks for the generic subsystem; their context is the manipulator_t.
const subsystem_callbacks_t* manipulator_callbacks(void);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_H
