// SPDX-License-Identifier: Apache-2.0
/// Differential inverse kinematics: joint velocities for a velocity of the tool, by damped least squares.
///
/// Away from singular poses the solution is exact; where the tool has a direction in which the joints
/// hardly move it, damping bounds the joint velocities and the tool lags. With fewer joints than
/// directions, six or three, the velocity of the tool is met as well as possible, with more the joint
/// velocities are the smallest that meet it.
///
/// Context    Any, no state.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H
#define FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H

#include "fsw/subsystems/arm/arm_model.h"

#include <stdbool.h>

typedef struct {
    double limit;   ///< Smallest singular value of the Jacobian below which damping acts [m and 1 mixed].
    double damping; ///< At singular value 0.
    bool is_position_only; ///< The orientation of the tool is left to itself.
} arm_inverse_t;

typedef struct { // Velocity of the tool, in the axes of the base; also a small displacement [m, rad].
    arm_vector_t linear_m_s;
    arm_vector_t angular_rad_s;
} arm_twist_t;

/// Joint velocities. Returns the estimate of the smallest singular value, which is not below the true one.
double arm_inverse(const arm_inverse_t* settings, const arm_jacobian_t* jacobian, unsigned joint_count,
                   const arm_twist_t* twist, double out_rate_rad_s[ARM_JOINTS_MAX]);

#endif // FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H
