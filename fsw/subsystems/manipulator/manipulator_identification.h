// SPDX-License-Identifier: Apache-2.0
/// Masses of the links and offsets of the torque sensors from motion in free space, where the external torque
/// is zero: a Kalman filter without process noise. Equations: docs/control.md.
///
/// The momentum observer is linear in the masses, so its estimate is a sum of residuals: of the torque alone,
/// and of each link with unit mass. No acceleration is needed.
///
/// Ownership  The caller places manipulator_arm_identification_t. Assumptions: the parameter IDENTIFICATION;
///            with MASS_SHARE 0 nothing is identified.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H

#include "fsw/subsystems/manipulator/manipulator_model.h"
#include "fsw/subsystems/manipulator/manipulator_observer.h"

#include <stdbool.h>
#include <stdint.h>

#define ARM_UNKNOWNS (2U * ARM_JOINTS) // Masses, then offsets.
#define ARM_PARTS (1U + ARM_JOINTS)    // Torque alone, then each link.
#define ARM_LAGS 2U                    // Poles of the tracker that gives the velocity.

typedef struct {
    double unknown[ARM_UNKNOWNS]; ///< [kg], [Nm]
    double covariance[ARM_UNKNOWNS][ARM_UNKNOWNS];
} manipulator_arm_estimate_t;

typedef struct { // Read-only outside.
    bool is_started;
    double late_rad[ARM_LAGS][ARM_JOINTS]; ///< Angle and torque, as old as the velocity.
    double late_nm[ARM_LAGS][ARM_JOINTS];
    double momentum[ARM_PARTS][ARM_JOINTS];
    double residual_nm[ARM_PARTS][ARM_JOINTS]; ///< Residuals of the torque [Nm] and of unit masses [Nm/kg].
    manipulator_arm_estimate_t now;
    manipulator_arm_estimate_t kept[2]; ///< Estimates from 1 to 2 s ago, and from less than 1 s ago.
    uint32_t age;                       ///< Cycles since the younger was kept.
    uint32_t quiet;                     ///< Cycles since the last contact, up to a limit.
    uint32_t cycle;                     ///< Since the last update.
    uint32_t updates;                   ///< [updates, wraps]
} manipulator_arm_identification_t;

/// Begin anew with the masses of the model, offsets zero.
void manipulator_arm_identification_init(manipulator_arm_identification_t* identification,
                                         const manipulator_identification_t* assumed,
                                         const manipulator_model_t* model);
/// One cycle of the residuals: angle and speed of the links, torque as the sensors show it.
void manipulator_arm_identification_step(manipulator_arm_identification_t* identification,
                                         const manipulator_model_t* model,
                                         const manipulator_arm_observer_gains_t* gains,
                                         const double link_rad[ARM_JOINTS],
                                         const double velocity_rad_s[ARM_JOINTS],
                                         const double torque_nm[ARM_JOINTS]);
/// Take in a tare: the mean of torque minus gravity of the model in force, at rest in the present pose. Older
/// offsets are forgotten, because the sensors drift.
void manipulator_arm_identification_tare(manipulator_arm_identification_t* identification,
                                         const manipulator_identification_t* assumed,
                                         const manipulator_model_t* model,
                                         const double offset_nm[ARM_JOINTS]);
/// One cycle in operation: take in the residuals if no joint feels a contact. At a contact the estimate of
/// 1 to 2 s ago is put back: the beginning of the contact was too weak to be told from a mass. True when the
/// unknowns changed.
bool manipulator_arm_identification_learn(manipulator_arm_identification_t* identification,
                                          const manipulator_identification_t* assumed,
                                          const manipulator_model_t* model);
/// The model with the identified masses; moments of inertia in proportion.
manipulator_model_t manipulator_arm_identified(const manipulator_arm_identification_t* identification,
                                               const manipulator_model_t* model);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H
