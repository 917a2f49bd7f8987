// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_force.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define TARE_RAD_S 10.0 // Corner frequency of the low-pass that learns the zero.
#define LEVER_M 0.01    // Lever arm with which the estimate is half of the force (arm_force.h).

void arm_force_init(arm_force_t* const force)
{
    FSW_ASSERT(force != NULL);
    *force = (arm_force_t){.force_n = {{0.0}}};
}

/// Solve (J J^T + lever^2) F = J tau; all vectors have three components.
static arm_vector_t force_of(const arm_jacobian_t* const jacobian, const unsigned joint_count,
                             const double torque_nm[ARM_JOINTS_MAX])
{
    arm_vector_t row[3];
    arm_vector_t right = {{0.0}};
    for (unsigned k = 0U; k < 3U; k++) {
        for (unsigned m = 0U; m < 3U; m++) {
            row[k].at[m] = (k == m) ? (LEVER_M * LEVER_M) : 0.0;
            for (unsigned i = 0U; i < joint_count; i++) {
                row[k].at[m] += jacobian->at[k][i] * jacobian->at[m][i];
            }
        }
        for (unsigned i = 0U; i < joint_count; i++) {
            right.at[k] += jacobian->at[k][i] * torque_nm[i];
        }
    }
    const arm_vector_t normal = arm_cross(row[1], row[2]); // Cramer's rule; the matrix is positive definite.
    const double determinant  = arm_dot(row[0], normal);
    return (arm_vector_t){{arm_dot(right, normal) / determinant,
                           arm_dot(row[0], arm_cross(right, row[2])) / determinant,
                           arm_dot(row[0], arm_cross(row[1], right)) / determinant}};
}

/// Update the zero of a joint. It is limited to a share of the torque limit, because a larger torque means a
/// contact.
static void learn_zero(arm_force_t* const force, const arm_setup_t* const setup, const unsigned joint,
                       const double difference_nm)
{
    const double gain = control_clamp(TARE_RAD_S * setup->period_s, 0.0, 1.0);
    const double limit_nm =
        setup->parameters->telepresence.tare_limit * setup->parameters->limits.torque[joint];
    const double offset_nm = control_clamp(difference_nm, -limit_nm, limit_nm);
    force->zero_nm[joint] =
        control_settle(force->zero_nm[joint] + (gain * (offset_nm - force->zero_nm[joint])));
}

/// Update the trackers; returns the tracked angles, velocities and accelerations of the links.
static arm_motion_t track(arm_force_t* const force, const arm_setup_t* const setup,
                          const arm_control_t* const control)
{
    arm_motion_t motion = {.position_rad = {0.0}};
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        if (!force->is_started) {
            control_tracker_reset(&force->link[i], control->link_rad[i]);
        }
        control_tracker_step(&force->link[i], control->link_rad[i],
                             setup->parameters->telepresence.force_bandwidth, setup->period_s);
        motion.position_rad[i]        = control->link_rad[i];
        motion.velocity_rad_s[i]      = force->link[i].velocity;
        motion.acceleration_rad_s2[i] = force->link[i].acceleration;
    }
    return motion;
}

/// Perform one step of a low-pass of second order, which has the same lag as the acceleration of the
/// trackers.
static void low_pass(arm_force_t* const force, const unsigned joint, const double gain,
                     const double sample_nm)
{
    double* const first  = &force->first_nm[joint];
    double* const second = &force->slow_nm[joint];
    *first  = force->is_started ? control_settle(*first + (gain * (sample_nm - *first))) : sample_nm;
    *second = force->is_started ? control_settle(*second + (gain * (*first - *second))) : sample_nm;
}

void arm_force_sense(arm_force_t* const force, const arm_setup_t* const setup,
                     const arm_control_t* const control, const bool is_at_rest)
{
    FSW_ASSERT((force != NULL) && (setup != NULL) && (control != NULL));
    const unsigned joint_count = setup->model->joint_count;
    const double gain =
        control_clamp(setup->parameters->telepresence.force_bandwidth * setup->period_s, 0.0, 1.0);
    arm_motion_t motion = track(force, setup, control);
    double moving_nm[ARM_JOINTS_MAX];
    double steady_nm[ARM_JOINTS_MAX];
    double external_nm[ARM_JOINTS_MAX];
    arm_inverse_dynamics(setup->model, &motion, moving_nm);
    for (unsigned i = 0U; i < joint_count; i++) {
        motion.acceleration_rad_s2[i] = 0.0;
    }
    arm_inverse_dynamics(setup->model, &motion, steady_nm);
    for (unsigned i = 0U; i < joint_count; i++) {
        const double difference_nm = control->torque_nm[i] - steady_nm[i];
        if (is_at_rest) {
            learn_zero(force, setup, i, difference_nm);
        }
        low_pass(force, i, gain, difference_nm - force->zero_nm[i]);
        external_nm[i] = (moving_nm[i] - steady_nm[i]) - force->slow_nm[i];
    }
    force->is_started = true;
    arm_jacobian_t jacobian;
    arm_jacobian(setup->model, &control->kinematics, &jacobian);
    force->force_n = force_of(&jacobian, joint_count, external_nm);
}
