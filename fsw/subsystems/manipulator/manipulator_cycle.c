// SPDX-License-Identifier: Apache-2.0
// The cycle of the manipulator: sensors, estimates, commands, links and telemetry.
#include "fsw/subsystems/manipulator/manipulator_internal.h"

#include "fsw/canopen/axis.h"
#include "fsw/drives/drives_counters.h"
#include "base/octets.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define LIMIT_HYSTERESIS 0.95 // An excess is over when the torque has fallen to this share of the limit.

static canopen_cia402_axis_t* joint_axis(manipulator_t* const manipulator, const unsigned joint)
{
    canopen_device_t* const device = drives_device(&manipulator->drives, (uint16_t)joint);
    return (device != NULL) ? &device->axes[0] : NULL;
}

// ---- Sense ----

static void watch_torque(manipulator_t* const manipulator)
{
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double limit  = manipulator->parameters.torque_limit[i];
        const double torque = control_absolute(manipulator->control.torque_nm[i]);
        if (torque <= (limit * LIMIT_HYSTERESIS)) {
            manipulator->is_beyond_limit[i] = false;
        }
        const bool is_new = (torque > limit) && !manipulator->is_beyond_limit[i];
        if (is_new && (subsystem_state(manipulator->generic) == STATE_OPERATIONAL)) {
            manipulator->is_beyond_limit[i] = true;
            uint8_t octets[MANIPULATOR_EVENT_TORQUE_LIMIT_OCTETS];
            octet_writer_t writer = octet_writer(octets, sizeof octets);
            octet_write_u8(&writer, (uint8_t)(i + 1U));
            octet_write_f64(&writer, manipulator->control.torque_nm[i]);
            octet_write_f64(&writer, limit);
            (void)subsystem_raise(manipulator->generic, MANIPULATOR_EVENT_TORQUE_LIMIT, octets,
                                  writer.position);
        }
    }
}

static void step_tare(manipulator_t* const manipulator, const manipulator_arm_setup_t* const setup)
{
    if (manipulator->tare.result != STATUS_BUSY) {
        return;
    }
    const manipulator_arm_control_t* const control = &manipulator->control;
    const manipulator_arm_terms_t terms            = manipulator_arm_terms(setup->model, control->link_rad);
    manipulator_arm_tare_sample_t sample;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        sample.difference_nm[i]  = control->torque_nm[i] - terms.gravity_nm[i];
        sample.velocity_rad_s[i] = control->observer.link[i].velocity;
    }
    const uint32_t samples = (uint32_t)((setup->gains->tare_time / setup->period_s) + 0.5);
    if (manipulator_arm_tare_step(&manipulator->tare, &sample, samples, setup->gains->tare_ceiling) !=
        STATUS_BUSY) {
        manipulator->control.zero_nm[0] = manipulator->tare.offset_nm[0];
        manipulator->control.zero_nm[1] = manipulator->tare.offset_nm[1];
        manipulator_tare_ended(manipulator);
    }
}

void manipulator_sense(void* const self)
{
    manipulator_t* const manipulator = self;
    drives_sense(&manipulator->drives);
    canopen_cia402_axis_t* const axes[ARM_JOINTS] = {joint_axis(manipulator, 0U),
                                                     joint_axis(manipulator, 1U)};
    if (!drives_are_running(&manipulator->drives) || (axes[0] == NULL) || (axes[1] == NULL)) {
        return;
    }
    const manipulator_arm_setup_t setup = manipulator_setup(manipulator);
    const double motor[ARM_JOINTS]      = {canopen_cia402_axis_position_rad(axes[0]),
                                           canopen_cia402_axis_position_rad(axes[1])};
    const double torque[ARM_JOINTS]     = {canopen_cia402_axis_torque_nm(axes[0]),
                                           canopen_cia402_axis_torque_nm(axes[1])};
    manipulator_arm_control_sense(&manipulator->control, &setup, motor, torque);
    manipulator->has_hand = subsystem_link_read(manipulator->generic, MANIPULATOR_PORT_HAND_POSITION,
                                                &manipulator->hand, sizeof manipulator->hand) == STATUS_OK;
    if (manipulator->drives.activity == DRIVES_PREPARED) {
        step_tare(manipulator, &setup);
    } else if (manipulator->drives.activity == DRIVES_ENGAGED) {
        watch_torque(manipulator);
    } else {
        // Nothing is watched while the controllers are off.
    }
}

// ---- Control ----

static void command(manipulator_t* const manipulator, const manipulator_arm_setup_t* const setup)
{
    manipulator_arm_control_t* const control = &manipulator->control;
    const double* const hand                 = manipulator->has_hand ? manipulator->hand.position : NULL;
    if (manipulator->drives.activity != DRIVES_ENGAGED) {
        manipulator_arm_control_hold(control, setup, hand);
    } else {
        const manipulator_arm_motion_t desired = manipulator->is_torque_mode
                                                     ? manipulator_arm_control_follow(control, setup, hand)
                                                     : manipulator_motion_step(manipulator);
        manipulator_arm_control_step(control, setup, &desired);
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        canopen_cia402_axis_t* const axis = joint_axis(manipulator, i);
        if (axis == NULL) {
            continue;
        }
        if (manipulator->is_torque_mode) {
            canopen_cia402_axis_command_torque(axis, control->command_nm[i]);
        } else {
            canopen_cia402_axis_command_position(axis, control->motor_target_rad[i],
                                                 control->feed_forward_nm[i]);
        }
    }
}

static void write_link(manipulator_t* const manipulator)
{
    const manipulator_arm_control_t* const control  = &manipulator->control;
    const manipulator_robot_state_payload_t payload = {
        .position        = {control->link_rad[0], control->link_rad[1]},
        .external_torque = {control->observer.external_nm[0], control->observer.external_nm[1]}};
    (void)subsystem_link_write(manipulator->generic, MANIPULATOR_PORT_ROBOT_STATE, &payload, sizeof payload);
}

static void publish(manipulator_t* const manipulator)
{
    const manipulator_arm_control_t* const control = &manipulator->control;
    manipulator_parameters_t* const parameters     = &manipulator->parameters;
    parameter_dictionary_t* const dictionary       = subsystem_dictionary(manipulator->generic);
    parameter_lock(dictionary);
    parameters->cur_values.state = (int32_t)subsystem_state(manipulator->generic);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const canopen_cia402_axis_t* const axis   = joint_axis(manipulator, i);
        parameters->cur_values.position[i]        = control->link_rad[i];
        parameters->cur_values.velocity[i]        = control->observer.link[i].velocity;
        parameters->cur_values.torque[i]          = control->torque_nm[i];
        parameters->cur_values.external_torque[i] = control->observer.external_nm[i];
        parameters->cur_values.command[i] =
            manipulator->is_torque_mode ? control->command_nm[i] : control->motor_target_rad[i];
        parameters->cur_values.statusword[i] = (axis != NULL) ? axis->statusword : 0U;
        parameters->des_position[i]          = control->reference[i].position;
        parameters->torque_offset[i]         = control->zero_nm[i];
    }
    drives_counters_publish(&manipulator->drives, control->limited);
    parameters->link_age = subsystem_link_age_us(manipulator->generic, MANIPULATOR_PORT_HAND_POSITION);
    parameter_unlock(dictionary);
}

void manipulator_control(void* const self)
{
    manipulator_t* const manipulator = self;
    if (drives_are_running(&manipulator->drives) && manipulator->control.is_started) {
        const manipulator_arm_setup_t setup = manipulator_setup(manipulator);
        command(manipulator, &setup);
    }
    write_link(manipulator);
    publish(manipulator);
}
