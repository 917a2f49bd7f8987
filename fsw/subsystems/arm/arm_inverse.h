// SPDX-License-Identifier: Apache-2.0
/// Differential inverse kinematics: joint velocities for a velocity of the tool, by damped least squares.
///
/// Away from singular poses the solution is exact. Near a singular pose the joints can hardly move the tool
/// in one direction: damping then limits the joint velocities, and the tool lags. If the arm has fewer joints
/// than the tool has directions (six, or three), the error of the tool's velocity is minimal; if it has more
/// joints, the joint velocities are the smallest possible ones.
///
/// Context    Any, no state.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H
#define FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H

#include "fsw/subsystems/arm/arm_model.h"

#include <stdbool.h>

typedef struct {
    /// Damping acts while the smallest singular value of the Jacobian is below this limit [m and 1 mixed].
    double limit;
    double damping;        ///< Damping at singular value 0.
    bool is_position_only; ///< The orientation of the tool is not controlled.
} arm_inverse_t;

typedef struct { // Velocity of the tool, in the axes of the base; also a small displacement [m, rad].
    arm_vector_t linear_m_s;
    arm_vector_t angular_rad_s;
} arm_twist_t;

/// Compute joint velocities. Returns an estimate of the smallest singular value, which is not below the true
/// value.
double arm_inverse(const arm_inverse_t* settings, const arm_jacobian_t* jacobian, unsigned joint_count,
                   const arm_twist_t* twist, double out_rate_rad_s[ARM_JOINTS_MAX]);

#endif // FSW_SUBSYSTEMS_ARM_ARM_INVERSE_H
