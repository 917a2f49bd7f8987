// SPDX-License-Identifier: Apache-2.0
/// Torque of the force-reflecting joystick: the external torque of the robot, and damping that grows in
/// contact.
///
///     u = s_f r - (b0 + b1 s) v        s: 0 in free space .. 1 in contact; rises fast, falls slowly
///
/// The damping keeps the loop over the robot stable; free space needs little, contact more. The larger torque
/// gives s for both axes: while friction holds a joint of the robot, its external torque shows no contact.
///
/// Ownership  The caller places joystick_stick_control_t. Gains are the parameter CONTROL.
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
    double contact;       ///< s
    double added_damping; ///< In the reflection, set by the caller [Nms/rad].
    double command_nm[STICK_AXES];
    unsigned limited; ///< Commands cut at the ceiling [commands, wraps].
} joystick_stick_control_t;

void joystick_stick_control_init(joystick_stick_control_t* control);
/// Take in the position, and compute the velocity from it.
void joystick_stick_control_sense(joystick_stick_control_t* control, const joystick_control_t* gains,
                                  double period_s, const double position_rad[STICK_AXES]);
/// Command that reflects a torque felt by the robot. `share` 0..1 fades the reflection in; damping is never
/// reduced.
void joystick_stick_control_reflect(joystick_stick_control_t* control, const joystick_control_t* gains,
                                    double period_s, const double felt_nm[STICK_AXES], double share);
/// Command that displays a torque, with the damping of free space.
void joystick_stick_control_display(joystick_stick_control_t* control, const joystick_control_t* gains,
                                    const double torque_nm[STICK_AXES]);

#endif // FSW_SUBSYSTEMS_JOYSTICK_STICK_CONTROL_H
