// SPDX-License-Identifier: Apache-2.0
/// Torque that the hand feels if the link to the robot has a delay: a local model of the contact that the
/// robot reports, and damping if the port to the hand gives away more energy than permitted.
///
///     felt = r + J^T k J s_p (x_e - x)      x: angle of the joystick; x_e: x that belongs to r
///
/// r: external torque of the robot; J: its Jacobian; k: stiffness of the model; s_p: position scale. The
/// robot reports r, J and x_e, the joystick angle that it followed when it measured r. A hand at rest feels
/// exactly r; a moving hand feels the model, and only the difference between the model's stiffness and the
/// true one passes through the delayed loop. At the tip the force along the normal is >= 0, and the
/// tangential force is limited to a share of it. The torque is scaled by a factor that rises from 0 to 1
/// with the reported push, from FADE_FROM to FADE_TO: in free space r is only an error of the estimate.
///
/// Ownership  The caller provides joystick_remote_contact_t. Settings are the parameter REMOTE.
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
    control_reserve_t reserve; ///< Energy that the port to the hand may give away.
    double taken_j;            ///< Net energy from the hand, up to the last cycle.
} joystick_remote_contact_t;

/// Set the reserve to zero. Call it at engagement.
void joystick_remote_contact_reset(joystick_remote_contact_t* contact);
/// Compute the torque at the joints of the robot that a hand at position_rad must feel. If J is singular, r
/// takes the place of the sum.
void joystick_remote_contact_feel(const joystick_remote_t* gains,
                                  const joystick_robot_contact_payload_t* robot,
                                  const double position_rad[STICK_AXES], double out_felt_nm[STICK_AXES]);
/// Perform one cycle of the passivity controller; `taken_j` is the net energy from the hand since
/// engagement. Before this call, the caller must pass the robot's sum of energy to `reserve`. Returns the
/// damping to be added [Nms/rad].
double joystick_remote_contact_damp(joystick_remote_contact_t* contact, const joystick_remote_t* gains,
                                    double period_s, double taken_j, const double velocity_rad_s[STICK_AXES]);

#endif // FSW_SUBSYSTEMS_JOYSTICK_REMOTE_CONTACT_H
