// SPDX-License-Identifier: Apache-2.0
/// Momentum observer: estimates the external torque on the arm from the joint torque sensors.
///
/// The sensors are on the output side of the gears, so motor friction and rotor inertia have no influence.
/// The model removes gravity, inertia and coupling of the links without a second derivative of the angle.
///
/// Ownership  The caller provides manipulator_arm_observer_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_OBSERVER_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_OBSERVER_H

#include "fsw/framework/control/tracker.h"
#include "fsw/subsystems/manipulator/manipulator_model.h"

#include <stdbool.h>

typedef struct {                        // Read-only outside.
    control_tracker_t link[ARM_JOINTS]; ///< Follows the link angle.
    double momentum[ARM_JOINTS];        ///< Momentum, integrated from the known torques [Nms].
    double external_nm[ARM_JOINTS];     ///< Estimated external torque.
    bool is_started;
} manipulator_arm_observer_t;

typedef struct {
    double bandwidth_rad_s; ///< Bandwidth of the tracker of the velocity.
    double gain_1_s;        ///< Gain of the estimate.
    double period_s;
} manipulator_arm_observer_gains_t;

/// Returns the gains of the parameter CONTROL.
manipulator_arm_observer_gains_t manipulator_arm_observer_gains(const manipulator_control_t* gains,
                                                                double period_s);
/// Process one cycle: link angle, and joint torque without the sensor's offset. The observer must be zero
/// before the first cycle.
void manipulator_arm_observer_step(manipulator_arm_observer_t* observer, const manipulator_model_t* model,
                                   const manipulator_arm_observer_gains_t* gains,
                                   const double link_rad[ARM_JOINTS], const double torque_nm[ARM_JOINTS]);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_OBSERVER_H
