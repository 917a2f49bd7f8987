// SPDX-License-Identifier: Apache-2.0
/// What the hand feels of a robot behind a link with delay: a local model of the contact that the robot
/// reports, and damping if the port to the hand gives away more energy than it may.
///
///     felt = r + J^T k J s_p (x_e - x)      r: external torque of the robot; x_e: angle of the joystick that
///                                           the robot acted on when it felt r; x: angle now
///
/// A hand at rest feels r exactly; a moving hand feels the model, and only the difference between its
/// stiffness and the true one goes round the delayed loop. At the tip the force along the normal is >= 0, and
/// the tangential force is a limited share of it. The torque fades in with the reported push: in free space r
/// is the error of its estimate, and the hand feels nothing of it.
///
/// Ownership  The caller places joystick_remote_contact_t. Settings are the parameter REMOTE.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_JOYSTICK_REMOTE_CONTACT_H
#define FSW_SUBSYSTEMS_JOYSTICK_REMOTE_CONTACT_H

#include "fsw/framework/control/planar.h"
#include "fsw/framework/control/port_energy.h"
#include "fsw/subsystems/joystick/stick_control.h"

#include "generated/joystick_descriptor.h"

#include <stdbool.h>

typedef struct {               // Read-only outside.
    control_reserve_t reserve; ///< What the port to the hand may give away.
    double taken_j;            ///< Net energy that the hand has put in, as of the last cycle.
} joystick_remote_contact_t;

/// At engagement: no reserve.
void joystick_remote_contact_reset(joystick_remote_contact_t* contact);
/// Torque at the joints of the robot that the hand at position_rad shall feel.
void joystick_remote_contact_feel(const joystick_remote_t* gains,
                                  const joystick_robot_contact_payload_t* robot,
                                  const double position_rad[STICK_AXES], double out_felt_nm[STICK_AXES]);
/// One cycle of the passivity controller, with the net energy that the hand has put in since engagement; the
/// caller gives the sum that the robot tells to `reserve` before. Returns the damping to be added [Nms/rad].
double joystick_remote_contact_damp(joystick_remote_contact_t* contact, const joystick_remote_t* gains,
                                    double period_s, double taken_j, const double velocity_rad_s[STICK_AXES]);

#endif // FSW_SUBSYSTEMS_JOYSTICK_REMOTE_CONTACT_H
