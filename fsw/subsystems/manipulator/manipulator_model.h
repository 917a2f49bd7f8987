// SPDX-License-Identifier: Apache-2.0
/// Rigid-body model of the two-joint arm in its vertical plane, which the controller uses.
///
/// Angles are geometric: tip = (l1 cos q1 + l2 cos(q1 + q2), l1 sin q1 + l2 sin(q1 + q2)), x forward, z up.
/// Link n has the length ln (LINK_LENGTH) and the mass mn (LINK_MASS); its centre of mass is cn (LINK_CENTRE)
/// from its joint. The values are those of the parameter MODEL, with the masses and moments of inertia that
/// were identified (manipulator_identification.h). Pure functions of their arguments.
///
/// Context    Any.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_MODEL_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_MODEL_H

#include "fsw/framework/control/elementary.h"
#include "fsw/framework/control/planar.h"

#include "generated/manipulator_descriptor.h"

#define ARM_JOINTS 2U

typedef struct { // Sines and cosines of the angles of one pose.
    control_sine_cosine_t shoulder;
    control_sine_cosine_t elbow;
    control_sine_cosine_t forearm; ///< Of the sum of both angles.
} manipulator_arm_directions_t;

typedef struct { // Terms of the equations of motion in one pose.
    double m11;  ///< Mass matrix (link side, without rotors) [kgm2].
    double m12;
    double m22;
    double h;                      ///< Coupling of the velocities, m2 l1 c2 sin q2 [kgm2].
    double gravity_nm[ARM_JOINTS]; ///< Torque that holds the arm still.
} manipulator_arm_terms_t;

manipulator_arm_directions_t manipulator_arm_directions(const double angle_rad[ARM_JOINTS]);
/// Terms in a pose whose directions are known: several models in one pose then need them only once.
manipulator_arm_terms_t manipulator_arm_terms_at(const manipulator_model_t* model,
                                                 const manipulator_arm_directions_t* at);
manipulator_arm_terms_t manipulator_arm_terms(const manipulator_model_t* model,
                                              const double angle_rad[ARM_JOINTS]);

/// Multiply the mass matrix by a vector.
void manipulator_arm_inertia_times(const manipulator_arm_terms_t* terms, const double vector[ARM_JOINTS],
                                   double out[ARM_JOINTS]);
/// Compute C(q, v) v, the centrifugal and Coriolis torque [Nm].
void manipulator_arm_coriolis(const manipulator_arm_terms_t* terms, const double velocity_rad_s[ARM_JOINTS],
                              double out_nm[ARM_JOINTS]);
/// Compute C(q, v)^T v, which the momentum observer needs [Nm].
void manipulator_arm_coriolis_transposed(const manipulator_arm_terms_t* terms,
                                         const double velocity_rad_s[ARM_JOINTS], double out_nm[ARM_JOINTS]);
/// Compute the Jacobian of the tip, in the form of fsw/framework/control/planar.h.
void manipulator_arm_jacobian(const manipulator_model_t* model, const double angle_rad[ARM_JOINTS],
                              double out[CONTROL_PLANAR_ENTRIES]);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_MODEL_H
