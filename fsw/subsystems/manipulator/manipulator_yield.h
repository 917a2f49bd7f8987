// SPDX-License-Identifier: Apache-2.0
/// Computes the angle that the arm follows if the link to the hand has a delay. The hand then reacts to a
/// contact too late, so the arm itself limits the force and the energy that it gives to the environment:
///
///     force limit  ds/dt = G (F - F_limit), s >= 0: the arm yields by s along the normal of the contact;
///                  F: force along the normal
///     passivity    a step that would give away more energy than came from the hand is shortened along the
///                  torque
///
/// The part of a step that was cut off is added later, a small part in each cycle. All energy is in units of
/// the joystick: torque times the force scale, angles of the joystick.
///
/// Ownership  The caller provides manipulator_arm_yield_t. Settings are the parameter REMOTE.
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
    bool is_touching;          ///< slow_n exceeds TOUCH, and `normal` follows its direction.
    double push_n;             ///< Part of slow_n along the normal; 0 without a touch.
    /// Normal of the contact, outwards, of length 1; all zero before the first contact.
    double normal[ARM_JOINTS];
    double given_way_m;           ///< Distance s by which the arm yields.
    double hand_rad[ARM_JOINTS];  ///< Latest angle of the hand.
    double asked_rad[ARM_JOINTS]; ///< Angle of the hand, changed by the distance by which the arm yields.
    double acted_rad[ARM_JOINTS]; ///< Angle that the arm follows.
    control_reserve_t reserve;    ///< Energy that came from the hand and that the arm has not given away.
    double taken_j;               ///< Energy taken from the environment; never decreases.
} manipulator_arm_yield_t;

typedef struct {
    const manipulator_remote_t* gains;
    double position_scale; ///< Ratio of joint angle to joystick angle.
    double period_s;
} manipulator_arm_yield_setup_t;

typedef struct {               // Inputs of one cycle.
    const double* jacobian;    ///< Jacobian of the tip, 4 entries as in planar.h.
    const double* external_nm; ///< Torques of the environment on the joints.
    const double* hand_rad;    ///< Latest angle of the hand; null: there is no sample, the last one is used.
    double paid_j; ///< Latest sum of the energy from the hand; not used without a sample of the hand.
} manipulator_arm_yield_sample_t;

/// Couple the arm to the hand at the hand's present angle, without a reserve of energy. If there is no
/// sample of the hand, the first later one couples. An angle that is not finite is not a sample.
void manipulator_arm_yield_reset(manipulator_arm_yield_t* yield,
                                 const manipulator_arm_yield_sample_t* sample);
/// Process one cycle. Returns the angle to follow; null if there was no sample of the hand yet.
const double* manipulator_arm_yield_step(manipulator_arm_yield_t* yield,
                                         const manipulator_arm_yield_setup_t* setup,
                                         const manipulator_arm_yield_sample_t* sample);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_YIELD_H
