// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_control.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

// Speed below which the compensation of Coulomb friction is proportional to the speed.
#define FRICTION_SPEED_RAD_S 0.02

void arm_control_init(arm_control_t* const control)
{
    FSW_ASSERT(control != NULL);
    *control = (arm_control_t){.is_started = false};
}

/// Returns the deflection of a gear under a torque.
static double deflection_of(const arm_setup_t* const setup, const unsigned joint, const double torque_nm)
{
    const double stiffness = setup->parameters->drives.stiffness[joint];
    return (stiffness > 0.0) ? (torque_nm / stiffness) : 0.0;
}

void arm_control_sense(arm_control_t* const control, const arm_setup_t* const setup,
                       const double motor_rad[ARM_JOINTS_MAX], const double torque_nm[ARM_JOINTS_MAX])
{
    FSW_ASSERT((control != NULL) && (setup != NULL));
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        control->motor_rad[i] = motor_rad[i];
        control->torque_nm[i] = torque_nm[i];
        control->link_rad[i]  = motor_rad[i] - deflection_of(setup, i, torque_nm[i]);
        if (!control->is_started) {
            control_tracker_reset(&control->motor[i], motor_rad[i]);
        }
        control_tracker_step(&control->motor[i], motor_rad[i], setup->parameters->control.velocity_bandwidth,
                             setup->period_s);
    }
    control->is_started = true;
    arm_kinematics(setup->model, control->link_rad, &control->kinematics);
}

/// Limit a torque to the range of its joint, and count the limitation.
static double limited(arm_control_t* const control, const arm_setup_t* const setup, const unsigned joint,
                      const double wanted_nm)
{
    const double limit_nm   = setup->parameters->limits.torque[joint];
    const double command_nm = control_clamp(wanted_nm, -limit_nm, limit_nm);
    control->limited += (command_nm != wanted_nm) ? 1U : 0U;
    return command_nm;
}

void arm_control_hold(arm_control_t* const control, const arm_setup_t* const setup)
{
    FSW_ASSERT((control != NULL) && (setup != NULL));
    arm_motion_t still = {.position_rad = {0.0}};
    double gravity_nm[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        still.position_rad[i] = control->link_rad[i];
    }
    arm_inverse_dynamics(setup->model, &still, gravity_nm);
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double target_rad      = control->link_rad[i] + deflection_of(setup, i, gravity_nm[i]);
        control->offset_rad[i]       = control->motor_rad[i] - target_rad;
        control->bias_nm[i]          = control->torque_nm[i] - gravity_nm[i];
        control->motor_target_rad[i] = control->motor_rad[i];
        control->feed_forward_nm[i]  = control->torque_nm[i];
        control->command_nm[i]       = limited(control, setup, i, control->torque_nm[i]);
    }
    control->tool_error = (arm_twist_t){.linear_m_s = {{0.0}}};
}

/// Returns the torque of a motor that compensates the friction in the gear at a desired speed.
static double friction_of(const arm_setup_t* const setup, const unsigned joint, const double speed_rad_s)
{
    const arm_drive_values_t* const drives = &setup->parameters->drives;
    return (setup->parameters->control.friction_share * drives->coulomb[joint] *
            control_tanh(speed_rad_s / FRICTION_SPEED_RAD_S)) +
           (drives->viscous[joint] * speed_rad_s);
}

/// Let the differences at engagement decay.
static void fade(arm_control_t* const control, const arm_setup_t* const setup)
{
    const double share =
        1.0 - control_clamp(setup->period_s / setup->parameters->control.fade_time, 0.0, 1.0);
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        control->offset_rad[i] = control_settle(control->offset_rad[i] * share);
        control->bias_nm[i]    = control_settle(control->bias_nm[i] * share);
    }
}

/// Compute the displacement [m, rad] from the measured pose of the tool to the desired one. A twist contains
/// it, because it has the same six coordinates as a velocity.
static void compare_tool(arm_control_t* const control, const arm_setup_t* const setup,
                         const arm_motion_t* const desired)
{
    arm_kinematics_t kinematics;
    arm_kinematics(setup->model, desired->position_rad, &kinematics);
    const arm_pose_t* const tool = &control->kinematics.tool;
    control->tool_error =
        (arm_twist_t){.linear_m_s    = arm_difference(kinematics.tool.position_m, tool->position_m),
                      .angular_rad_s = arm_rotation_between(&tool->rotation, &kinematics.tool.rotation)};
}

void arm_control_step(arm_control_t* const control, const arm_setup_t* const setup,
                      const arm_motion_t* const desired)
{
    FSW_ASSERT((control != NULL) && (setup != NULL) && (desired != NULL));
    const arm_control_values_t* const gains = &setup->parameters->control;
    double rigid_nm[ARM_JOINTS_MAX];
    fade(control, setup);
    compare_tool(control, setup, desired);
    arm_inverse_dynamics(setup->model, desired, rigid_nm);
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double speed = desired->velocity_rad_s[i];
        control->motor_target_rad[i] =
            desired->position_rad[i] + deflection_of(setup, i, rigid_nm[i]) + control->offset_rad[i];
        control->feed_forward_nm[i] =
            rigid_nm[i] + (setup->parameters->drives.rotor_inertia[i] * desired->acceleration_rad_s2[i]) +
            friction_of(setup, i, speed) + control->bias_nm[i];
        const double wanted_nm = control->feed_forward_nm[i] +
                                 (gains->kp[i] * (control->motor_target_rad[i] - control->motor_rad[i])) +
                                 (gains->kd[i] * (speed - control->motor[i].velocity));
        control->command_nm[i] = limited(control, setup, i, wanted_nm);
    }
}

/// Compute force and moment of the virtual springs and dampers of the tool.
static void tool_wrench(const arm_control_t* const control, const arm_setup_t* const setup,
                        const arm_jacobian_t* const jacobian, const arm_motion_t* const desired,
                        double out_wrench[6])
{
    const arm_control_values_t* const gains = &setup->parameters->control;
    for (unsigned k = 0U; k < 6U; k++) {
        double rate = 0.0;
        for (unsigned i = 0U; i < setup->model->joint_count; i++) {
            rate += jacobian->at[k][i] * (desired->velocity_rad_s[i] - control->motor[i].velocity);
        }
        const double error =
            (k < 3U) ? control->tool_error.linear_m_s.at[k] : control->tool_error.angular_rad_s.at[k - 3U];
        out_wrench[k] = (gains->tool_stiffness[k] * error) + (gains->tool_damping[k] * rate);
    }
}

void arm_control_comply(arm_control_t* const control, const arm_setup_t* const setup,
                        const arm_motion_t* const desired)
{
    FSW_ASSERT((control != NULL) && (setup != NULL) && (desired != NULL));
    const unsigned joint_count = setup->model->joint_count;
    // Use the desired velocities and accelerations at the measured positions, because a force may have moved
    // the tool away from its path.
    arm_motion_t motion = *desired;
    for (unsigned i = 0U; i < joint_count; i++) {
        motion.position_rad[i] = control->link_rad[i];
    }
    arm_jacobian_t jacobian;
    double rigid_nm[ARM_JOINTS_MAX];
    double wrench[6];
    fade(control, setup);
    compare_tool(control, setup, desired);
    arm_jacobian(setup->model, &control->kinematics, &jacobian);
    arm_inverse_dynamics(setup->model, &motion, rigid_nm);
    tool_wrench(control, setup, &jacobian, desired, wrench);
    for (unsigned i = 0U; i < joint_count; i++) {
        double joint_nm = rigid_nm[i] + control->bias_nm[i] -
                          (setup->parameters->control.joint_damping * control->motor[i].velocity);
        for (unsigned k = 0U; k < 6U; k++) {
            joint_nm += jacobian.at[k][i] * wrench[k];
        }
        const double motor_nm =
            (setup->parameters->drives.rotor_inertia[i] * desired->acceleration_rad_s2[i]) +
            friction_of(setup, i, desired->velocity_rad_s[i]) +
            (setup->parameters->control.torque_gain * (joint_nm - control->torque_nm[i]));
        control->command_nm[i] = limited(control, setup, i, joint_nm + motor_nm);
    }
}
