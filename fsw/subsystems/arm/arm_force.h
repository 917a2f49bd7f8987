// SPDX-License-Identifier: Apache-2.0
/// Force of the environment on the tool, from the torque sensors of the joints and the model of the arm.
///
///     tau    = M(q) a - low-pass(sensor - zero - h(q, v))     torques that the environment gives the joints
///     J^T F  = tau in the least squares                       J: of the position of the tool
///
/// a is the acceleration of a tracker of the link angles with the bandwidth of the low-pass: both have the
/// same lag. h: gravity, centrifugal and Coriolis torques. The environment is assumed to act by a force at
/// the tool, without a moment. The least squares are damped: the estimate is half of the force in a direction
/// in which the joints together have a lever arm of 1 cm, and tends to 0 for shorter ones. While the
/// actuators are off, the zero of the sensors is learned, up to a limit: if the arm then touches an object,
/// only the part of the force beyond the limit is estimated.
///
/// Ownership  The caller provides arm_force_t.
/// Context    One task.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_FORCE_H
#define FSW_SUBSYSTEMS_ARM_ARM_FORCE_H

#include "fsw/subsystems/arm/arm_control.h"

#include <stdbool.h>

typedef struct { // Read-only outside.
    bool is_started;
    double zero_nm[ARM_JOINTS_MAX];
    control_tracker_t link[ARM_JOINTS_MAX];
    double first_nm[ARM_JOINTS_MAX]; ///< Low-pass of second order: first stage.
    double slow_nm[ARM_JOINTS_MAX];  ///< Second stage.
    arm_vector_t force_n;            ///< Force on the tool, in the axes of the base.
} arm_force_t;

void arm_force_init(arm_force_t* force);
/// Process the sensors of `control`. `is_at_rest`: the actuators are off, so the zero is learned.
void arm_force_sense(arm_force_t* force, const arm_setup_t* setup, const arm_control_t* control,
                     bool is_at_rest);

#endif // FSW_SUBSYSTEMS_ARM_ARM_FORCE_H
