// SPDX-License-Identifier: Apache-2.0
/// Limits of the motions of an arm.
///
/// Ownership  The caller provides the structure.
/// Context    Any, no state.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_LIMITS_H
#define FSW_SUBSYSTEMS_ARM_ARM_LIMITS_H

#include "fsw/subsystems/arm/arm_inverse.h"
#include "fsw/subsystems/arm/arm_model.h"

typedef struct {
    double lower_rad[ARM_JOINTS_MAX];
    double upper_rad[ARM_JOINTS_MAX];
    double speed_rad_s[ARM_JOINTS_MAX];
    double acceleration_rad_s2[ARM_JOINTS_MAX];
    double tool_speed_m_s;
    double tool_acceleration_m_s2;
    double tool_rate_rad_s;
    double tool_angular_acceleration_rad_s2;
    double tolerance; ///< Largest distance of the tool from its line [m], and error of its orientation [rad].
    /// Settings of the inverse kinematics.
    arm_inverse_t inverse;
} arm_limits_t;

#endif // FSW_SUBSYSTEMS_ARM_ARM_LIMITS_H
