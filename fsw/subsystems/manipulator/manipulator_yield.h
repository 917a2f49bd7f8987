// SPDX-License-Identifier: Apache-2.0
/// The angle of the hand as the arm acts on it when the link to the hand has delay. The hand then answers a
/// contact too late, so the arm itself limits the force and the energy that it gives to the environment:
///
///     force limit  ds/dt = G (F - F_limit), s >= 0: the arm gives way by s along the normal of the contact
///     passivity    a step that would give away more energy than the hand has put in is shortened along the
///                  torque
///
/// The part of a step that was cut off is led in later, a little in each cycle. All energy is in units of the
/// joystick: torque times the force scale, angles of the joystick.
///
/// Ownership  The caller places manipulator_arm_yield_t. Settings are the parameter REMOTE.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_YIELD_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_YIELD_H

#include "fsw/framework/control/planar.h"
#include "fsw/framework/control/port_energy.h"
#include "fsw/subsystems/manipulator/manipulator_model.h"

#include <stdbool.h>

typedef struct { // Read-only outside.
    bool is_started;
    double slow_n[ARM_JOINTS]; ///< Slow part of the force at the tip.
    bool is_touching;          ///< slow_n is above TOUCH, and `normal` follows it.
    double push_n;             ///< Part of slow_n along the normal; 0 without a touch.
    double normal
        [ARM_JOINTS];   ///< Normal of the contact, outwards, of length 1; all zero before the first contact.
    double given_way_m; ///< s
    double hand_rad[ARM_JOINTS];  ///< Latest angle of the hand.
    double asked_rad[ARM_JOINTS]; ///< The same, with what the arm gives way.
    double acted_rad[ARM_JOINTS]; ///< What the arm follows.
    control_reserve_t reserve;    ///< Energy that the hand has put in and the arm has not given away.
    double taken_j;               ///< Energy taken from the environment; never decreases.
} manipulator_arm_yield_t;

typedef struct {
    const manipulator_remote_t* gains;
    double position_scale; ///< Joint angle per angle of the joystick.
    double period_s;
} manipulator_arm_yield_setup_t;

typedef struct {               // Inputs of one cycle.
    const double* jacobian;    ///< Jacobian of the tip, 4 entries as in planar.h.
    const double* external_nm; ///< Torques of the environment on the joints.
    const double* hand_rad;    ///< Latest angle of the hand; null: none, the last one stays.
    double paid_j; ///< Latest sum of the energy that the hand has put in; not read without a hand.
} manipulator_arm_yield_sample_t;

/// Couple to the hand: the arm acts on its present angle, without a reserve of energy. Without a hand (null)
/// the first cycle with one couples. A hand whose angle is not finite is none.
void manipulator_arm_yield_reset(manipulator_arm_yield_t* yield,
                                 const manipulator_arm_yield_sample_t* sample);
/// One cycle. Returns the angle to follow, null as long as there has been no hand.
const double* manipulator_arm_yield_step(manipulator_arm_yield_t* yield,
                                         const manipulator_arm_yield_setup_t* setup,
                                         const manipulator_arm_yield_sample_t* sample);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_YIELD_H
