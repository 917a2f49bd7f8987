// SPDX-License-Identifier: Apache-2.0
/// The subsystem JOYSTICK: a force-reflecting joystick of two axes.
///
/// TELEPRESENCE sends the hand's position to the robot and reflects the robot's external torque to the hand;
/// TELEPRESENCE_REMOTE does the same through a link with delay, with a local model of the contact;
/// STAND_ALONE displays a commanded torque (FORCE, or DES_TORQUE by telecommand). A configuration with the
/// required port ROBOT_STATE or ROBOT_CONTACT reflects the torque of a robot; a configuration without these
/// ports displays torques. All tunable values are in the parameters CONTROL and REMOTE.
///
/// Ownership  The program provides joystick_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks never block.
///
///     static joystick_t joystick;
///     joystick_init(&joystick, &subsystem, &resolver);
///     config.callbacks = joystick_callbacks();
///     config.self      = &joystick;
#ifndef FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_H
#define FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_H

#include "base/capacities.h"
#include "fsw/drives/drives.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "fsw/subsystems/joystick/force_display.h"
#include "fsw/framework/control/port_energy.h"
#include "fsw/subsystems/joystick/remote_contact.h"
#include "fsw/subsystems/joystick/stick_control.h"

#include "generated/joystick_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {     // All fields are private.
    drives_t drives; ///< First member, because the callbacks of drives.h get the same context.
    subsystem_t* generic;
    joystick_parameters_t parameters;
    bool is_reflecting; ///< The configuration reflects the torque of a robot.
    bool is_remote;     ///< The link to that robot has a delay.
    uint16_t robot_port;
    joystick_stick_control_t control;
    double felt_nm[STICK_AXES];   ///< External torque of the robot; falls to zero without fresh samples.
    control_port_energy_t energy; ///< Energy at the port to the hand.
    joystick_remote_contact_t contact;
    double share; ///< Share of the reflection, 0..1; grows while both sides are operational.
    joystick_force_display_t display;
    uint32_t force_call_token; ///< Token of the running function FORCE; 0: none.
} joystick_t;
CAPACITY_CHECK(joystick_begins_with_drives, offsetof(joystick_t, drives) == 0U);

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void joystick_init(joystick_t* joystick, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns the callbacks for the generic subsystem; their context is the joystick_t.
const subsystem_callbacks_t* joystick_callbacks(void);

#endif // FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_H
