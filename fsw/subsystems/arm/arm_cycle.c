// SPDX-License-Identifier: Apache-2.0
// The cycle of the arm: sensors, desired motion, commands and telemetry.
#include "fsw/subsystems/arm/arm_internal.h"

#include "fsw/canopen/axis.h"
#include "fsw/drives/drives_counters.h"

#include <stddef.h>

typedef struct { // Payload of ROBOT_STATE.
    double position_rad[ARM_HAND_AXES];
    double external_torque_nm[ARM_HAND_AXES];
} robot_state_t;

static canopen_cia402_axis_t* joint_axis(arm_t* const arm, const unsigned joint)
{
    canopen_device_t* const device = drives_device(&arm->drives, (uint16_t)joint);
    return (device != NULL) ? &device->axes[0] : NULL;
}

static arm_setup_t setup_of(const arm_t* const arm)
{
    return (arm_setup_t){.model      = &arm->model,
                         .parameters = &arm->parameters,
                         .period_s   = (double)subsystem_period_ns(arm->generic) * 1.0e-9};
}

void arm_sense(void* const self)
{
    arm_t* const arm = self;
    drives_sense(&arm->drives);
    if (!drives_are_running(&arm->drives)) {
        return;
    }
    double motor_rad[ARM_JOINTS_MAX];
    double torque_nm[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < arm->model.joint_count; i++) {
        const canopen_cia402_axis_t* const axis = joint_axis(arm, i);
        motor_rad[i] = (axis != NULL) ? canopen_cia402_axis_position_rad(axis) : 0.0;
        torque_nm[i] = (axis != NULL) ? canopen_cia402_axis_torque_nm(axis) : 0.0;
    }
    const arm_setup_t setup = setup_of(arm);
    arm_control_sense(&arm->control, &setup, motor_rad, torque_nm);
    arm_force_sense(&arm->force, &setup, &arm->control, arm->drives.activity != DRIVES_ENGAGED);
    arm->has_hand = arm->is_telepresence && (subsystem_link_read(arm->generic, arm->hand_port, arm->hand_rad,
                                                                 sizeof arm->hand_rad) == STATUS_OK);
}

/// Compute the commands of this cycle: for the desired motion, or for the present pose while the actuators
/// are off.
static void compute(arm_t* const arm, const arm_setup_t* const setup)
{
    if (arm->drives.activity != DRIVES_ENGAGED) {
        arm_abandon(arm);
        arm_hand_begin(&arm->hand, &arm->model, &arm->motion);
        arm_control_hold(&arm->control, setup);
        return;
    }
    if (arm->is_telepresence) {
        const arm_hand_setup_t lead = {.model    = &arm->model,
                                       .limits   = &arm->limits,
                                       .settings = arm->hand_settings,
                                       .period_s = setup->period_s};
        arm_hand_step(&arm->hand, &lead, arm->has_hand ? arm->hand_rad : NULL, &arm->motion);
    } else {
        arm_motion_step(arm, setup->period_s);
    }
    if (arm->is_torque_mode && arm->parameters.control.is_compliant) {
        arm_control_comply(&arm->control, setup, &arm->motion);
    } else {
        arm_control_step(&arm->control, setup, &arm->motion);
    }
}

static void command(arm_t* const arm)
{
    for (unsigned i = 0U; i < arm->model.joint_count; i++) {
        canopen_cia402_axis_t* const axis = joint_axis(arm, i);
        if (axis == NULL) {
            continue;
        }
        if (arm->is_torque_mode) {
            canopen_cia402_axis_command_torque(axis, arm->control.command_nm[i]);
        } else {
            canopen_cia402_axis_command_position(axis, arm->control.motor_target_rad[i],
                                                 arm->control.feed_forward_nm[i]);
        }
    }
}

static void write_link(arm_t* const arm)
{
    const arm_hand_settings_t* const settings = &arm->hand_settings;
    robot_state_t state;
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        state.position_rad[i] =
            (settings->scale_m_rad > 0.0) ? (arm->hand.offset_m[i] / settings->scale_m_rad) : 0.0;
        state.external_torque_nm[i] =
            arm->parameters.telepresence.force_scale * arm_dot(settings->direction[i], arm->force.force_n);
    }
    (void)subsystem_link_write(arm->generic, arm->robot_port, &state, sizeof state);
}

static void publish_hand(const arm_t* const arm, arm_hand_values_t* const values)
{
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        values->position_rad[i] = arm->hand.hand_rad[i];
        values->offset_m[i]     = arm->hand.offset_m[i];
    }
    values->state = (uint8_t)arm->hand.state;
}

static void publish_tool(arm_t* const arm, arm_cur_values_t* const values)
{
    static const arm_rotation_t none = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    const arm_pose_t* const tool     = &arm->control.kinematics.tool;
    const arm_vector_t rotation      = arm_rotation_between(&none, &tool->rotation);
    for (unsigned k = 0U; k < 3U; k++) {
        values->tool_position_m[k]   = tool->position_m.at[k];
        values->tool_rotation_rad[k] = rotation.at[k];
        values->tool_force_n[k]      = arm->force.force_n.at[k];
    }
    values->tool_error[0] = arm_length(arm->control.tool_error.linear_m_s);
    values->tool_error[1] = arm_length(arm->control.tool_error.angular_rad_s);
}

static void publish(arm_t* const arm)
{
    arm_cur_values_t* const values           = &arm->parameters.cur_values;
    parameter_dictionary_t* const dictionary = subsystem_dictionary(arm->generic);
    parameter_lock(dictionary);
    values->state = (int32_t)subsystem_state(arm->generic);
    for (unsigned i = 0U; i < arm->model.joint_count; i++) {
        const canopen_cia402_axis_t* const axis = joint_axis(arm, i);
        values->position_rad[i]                 = arm->control.link_rad[i];
        values->velocity_rad_s[i]               = arm->control.motor[i].velocity;
        values->torque_nm[i]                    = arm->control.torque_nm[i];
        values->command[i] =
            arm->is_torque_mode ? arm->control.command_nm[i] : arm->control.motor_target_rad[i];
        values->desired_rad[i] = arm->motion.position_rad[i];
        values->statusword[i]  = (axis != NULL) ? axis->statusword : 0U;
    }
    publish_tool(arm, values);
    publish_hand(arm, &arm->parameters.hand);
    drives_counters_publish(&arm->drives, arm->control.limited);
    parameter_unlock(dictionary);
}

void arm_cycle(void* const self)
{
    arm_t* const arm = self;
    if (drives_are_running(&arm->drives) && arm->control.is_started) {
        const arm_setup_t setup = setup_of(arm);
        compute(arm, &setup);
        command(arm);
    }
    if (arm->is_telepresence) {
        write_link(arm);
    }
    publish(arm);
}
