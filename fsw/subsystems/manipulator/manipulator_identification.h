// SPDX-License-Identifier: Apache-2.0
/// Identification of the masses of the links and the offsets of the torque sensors from motion in free
/// space, where the external torque is zero: a Kalman filter without process noise. Equations:
/// docs/control.md.
///
/// The momentum observer is linear in the masses, so its estimate is a sum of residuals: that of the torque
/// alone, and that of each link with unit mass. The acceleration is not needed.
///
/// Ownership  The caller provides manipulator_arm_identification_t. Assumptions: the parameter
///            IDENTIFICATION; with MASS_SHARE 0 nothing is identified.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H

#include "fsw/subsystems/manipulator/manipulator_model.h"
#include "fsw/subsystems/manipulator/manipulator_observer.h"

#include <stdbool.h>
#include <stdint.h>

#define ARM_UNKNOWNS (2U * ARM_JOINTS) // Number of unknowns: first masses, then offsets.
// Number of residuals: first that of the torque alone, then that of each link.
#define ARM_PARTS (1U + ARM_JOINTS)
#define ARM_LAGS 2U // Number of poles of the tracker that estimates the velocity.

typedef struct {
    double unknown[ARM_UNKNOWNS]; ///< Masses [kg], then offsets [Nm].
    double covariance[ARM_UNKNOWNS][ARM_UNKNOWNS];
} manipulator_arm_estimate_t;

typedef struct { // Read-only outside.
    bool is_started;
    double late_rad[ARM_LAGS][ARM_JOINTS]; ///< Angle and torque, delayed like the velocity.
    double late_nm[ARM_LAGS][ARM_JOINTS];
    double momentum[ARM_PARTS][ARM_JOINTS];
    double residual_nm[ARM_PARTS][ARM_JOINTS]; ///< Residuals of the torque [Nm] and of unit masses [Nm/kg].
    manipulator_arm_estimate_t now;
    manipulator_arm_estimate_t kept[2]; ///< Estimates from 1 to 2 s ago, and from less than 1 s ago.
    uint32_t age;                       ///< Cycles since the newer one was stored.
    uint32_t quiet;                     ///< Cycles since the last contact, up to a limit.
    uint32_t cycle;                     ///< Cycles since the last update.
    uint32_t updates;                   ///< Number of updates [wraps].
} manipulator_arm_identification_t;

/// Begin the identification again, with the masses of the model, and offsets zero.
void manipulator_arm_identification_init(manipulator_arm_identification_t* identification,
                                         const manipulator_identification_t* assumed,
                                         const manipulator_model_t* model);
/// Update the residuals, once per cycle, from angle and speed of the links and the torque without correction
/// of the sensors.
void manipulator_arm_identification_step(manipulator_arm_identification_t* identification,
                                         const manipulator_model_t* model,
                                         const manipulator_arm_observer_gains_t* gains,
                                         const double link_rad[ARM_JOINTS],
                                         const double velocity_rad_s[ARM_JOINTS],
                                         const double torque_nm[ARM_JOINTS]);
/// Process the result of a tare: the mean of torque minus gravity torque of the model in use, at rest in the
/// present pose. Older offsets are dropped, because the sensors drift.
void manipulator_arm_identification_tare(manipulator_arm_identification_t* identification,
                                         const manipulator_identification_t* assumed,
                                         const manipulator_model_t* model,
                                         const double offset_nm[ARM_JOINTS]);
/// Call once per cycle in operation: use the residuals for an update if no joint has a contact. At a
/// contact, the estimate of 1 to 2 s ago is restored, because the weak beginning of the contact could not be
/// distinguished from a mass. True if the unknowns have changed.
bool manipulator_arm_identification_learn(manipulator_arm_identification_t* identification,
                                          const manipulator_identification_t* assumed,
                                          const manipulator_model_t* model);
/// Returns the model with the identified masses; the moments of inertia change in proportion.
manipulator_model_t manipulator_arm_identified(const manipulator_arm_identification_t* identification,
                                               const manipulator_model_t* model);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_IDENTIFICATION_H
