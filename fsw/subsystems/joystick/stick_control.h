// SPDX-License-Identifier: Apache-2.0
/// Torque of the force-reflecting joystick: the external torque of the robot, and damping that grows in
/// contact.
///
///     u = s_f r - (b0 + b1 s) v        r: torque of the robot; s_f: force scale; v: velocity; b0, b1:
///                                      damping in free space, and its increase in contact;
///                                      s: 0 in free space .. 1 in contact; rises fast, falls slowly
///
/// The damping keeps the control loop through the robot stable; it can be small in free space, but must be
/// larger in contact. The larger torque determines s for both axes, because the external torque of a joint
/// that friction holds does not show a contact.
///
/// Ownership  The caller provides joystick_stick_control_t. Gains are the parameter CONTROL.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_JOYSTICK_STICK_CONTROL_H
#define FSW_SUBSYSTEMS_JOYSTICK_STICK_CONTROL_H

#include "fsw/framework/control/tracker.h"

#include "generated/joystick_descriptor.h"

#include <stdbool.h>

#define STICK_AXES 2U

typedef struct { // Read-only outside.
    bool is_started;
    double position_rad[STICK_AXES];
    control_tracker_t motion[STICK_AXES];
    double contact;       ///< Degree of contact, s.
    double added_damping; ///< Additional damping of the reflection, set by the caller [Nms/rad].
    double command_nm[STICK_AXES];
    unsigned limited; ///< Commands cut at the ceiling [commands, wraps].
} joystick_stick_control_t;

void joystick_stick_control_init(joystick_stick_control_t* control);
/// Process the measured position, and compute the velocity from it.
void joystick_stick_control_sense(joystick_stick_control_t* control, const joystick_control_t* gains,
                                  double period_s, const double position_rad[STICK_AXES]);
/// Compute the command that reflects a torque that the robot feels. `share`, 0..1, scales the reflection,
/// but not the damping.
void joystick_stick_control_reflect(joystick_stick_control_t* control, const joystick_control_t* gains,
                                    double period_s, const double felt_nm[STICK_AXES], double share);
/// Compute the command that displays a torque, with the damping of free space.
void joystick_stick_control_display(joystick_stick_control_t* control, const joystick_control_t* gains,
                                    const double torque_nm[STICK_AXES]);

#endif // FSW_SUBSYSTEMS_JOYSTICK_STICK_CONTROL_H
