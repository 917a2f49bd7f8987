// SPDX-License-Identifier: Apache-2.0
// The cycle of the manipulator: sensors, estimates, commands, links and telemetry.
#include "fsw/subsystems/manipulator/manipulator_internal.h"

#include "fsw/canopen/axis.h"
#include "fsw/drives/drives_counters.h"
#include "base/octets.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

// An excess of torque ends when the torque has fallen to this share of the limit.
#define LIMIT_HYSTERESIS 0.95

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

static void watch_energy(manipulator_t* const manipulator, const manipulator_arm_setup_t* const setup)
{
    const manipulator_passivity_t* const passivity = &manipulator->parameters.passivity;
    const control_port_watch_t watch               = {.limit_j  = passivity->limit,
                                                      .time_s   = passivity->time,
                                                      .rest_rad = passivity->rest,
                                                      .period_s = setup->period_s};
    const double given =
        control_port_energy_step(&manipulator->energy, &watch, manipulator->control.observer.external_nm,
                                 manipulator->control.link_rad);
    if (given > 0.0) {
        uint8_t octets[MANIPULATOR_EVENT_PASSIVITY_OCTETS];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_f64(&writer, given);
        (void)subsystem_raise(manipulator->generic, MANIPULATOR_EVENT_PASSIVITY, octets, writer.position);
    }
}

// ---- Identification ----

static bool is_identifying(const manipulator_t* const manipulator)
{
    return manipulator->parameters.identification.mass_share > 0.0;
}

static void step_identification(manipulator_t* const manipulator)
{
    const manipulator_arm_observer_t* const observer = &manipulator->control.observer;
    const manipulator_arm_observer_gains_t gains     = manipulator_arm_observer_gains(
            &manipulator->parameters.control, manipulator_setup(manipulator).period_s);
    const double velocity[ARM_JOINTS] = {observer->link[0].velocity, observer->link[1].velocity};
    manipulator_arm_identification_step(&manipulator->identification, &manipulator->parameters.model, &gains,
                                        manipulator->control.link_rad, velocity,
                                        manipulator->control.torque_nm);
}

/// Use the identified masses and offsets. Both change together, because the measurements determine only
/// their sum.
static void apply_identified(manipulator_t* const manipulator)
{
    manipulator->model =
        manipulator_arm_identified(&manipulator->identification, &manipulator->parameters.model);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        manipulator->control.zero_nm[i] = manipulator->identification.now.unknown[ARM_JOINTS + i];
    }
}

static void learn(manipulator_t* const manipulator)
{
    if (is_identifying(manipulator) && manipulator->is_torque_mode &&
        manipulator_arm_identification_learn(&manipulator->identification,
                                             &manipulator->parameters.identification,
                                             &manipulator->parameters.model)) {
        apply_identified(manipulator);
    }
}

// ---- Tare ----

/// Continue a running tare. At its end, use the new zero, also for the identification.
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
        if (is_identifying(manipulator) && (manipulator->tare.result == STATUS_OK)) {
            manipulator_arm_identification_tare(&manipulator->identification,
                                                &manipulator->parameters.identification, &manipulator->model,
                                                manipulator->tare.offset_nm);
            apply_identified(manipulator);
        }
        manipulator_tare_ended(manipulator);
    }
}

static void read_hand(manipulator_t* const manipulator)
{
    subsystem_t* const generic = manipulator->generic;
    manipulator_hand_position_payload_t near;
    manipulator_hand_motion_payload_t far;
    if (manipulator->is_remote) {
        manipulator->has_hand =
            subsystem_link_read(generic, MANIPULATOR_PORT_HAND_MOTION, &far, sizeof far) == STATUS_OK;
        if (manipulator->has_hand) {
            manipulator->hand_rad[0] = far.position[0];
            manipulator->hand_rad[1] = far.position[1];
            manipulator->paid_j      = far.energy;
        }
    } else {
        manipulator->has_hand =
            subsystem_link_read(generic, MANIPULATOR_PORT_HAND_POSITION, &near, sizeof near) == STATUS_OK;
        if (manipulator->has_hand) {
            manipulator->hand_rad[0] = near.position[0];
            manipulator->hand_rad[1] = near.position[1];
        }
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
    step_identification(manipulator);
    read_hand(manipulator);
    if (manipulator->drives.activity == DRIVES_PREPARED) {
        step_tare(manipulator, &setup);
    } else if (manipulator->drives.activity == DRIVES_ENGAGED) {
        watch_torque(manipulator);
        watch_energy(manipulator, &setup);
        learn(manipulator);
    } else {
        // While the controllers are off, no limit is monitored.
    }
}

// ---- Control ----

/// Returns the angles that the arm follows: those of the hand, modified by manipulator_yield if the link has
/// a delay; null if there is no hand.
static const double* angles_to_follow(manipulator_t* const manipulator,
                                      const manipulator_arm_setup_t* const setup)
{
    const manipulator_arm_control_t* const control = &manipulator->control;
    const double* const hand                       = manipulator->has_hand ? manipulator->hand_rad : NULL;
    if (!manipulator->is_remote) {
        return hand;
    }
    double jacobian[CONTROL_PLANAR_ENTRIES];
    manipulator_arm_jacobian(setup->model, control->link_rad, jacobian);
    const manipulator_arm_yield_setup_t yield_setup = {.gains          = &manipulator->parameters.remote,
                                                       .position_scale = setup->gains->position_scale,
                                                       .period_s       = setup->period_s};
    const manipulator_arm_yield_sample_t sample     = {.jacobian    = jacobian,
                                                       .external_nm = control->observer.external_nm,
                                                       .hand_rad    = hand,
                                                       .paid_j      = manipulator->paid_j};
    // The arm does not follow yet: begin again from the present sample.
    if (manipulator->drives.activity != DRIVES_ENGAGED) {
        manipulator_arm_yield_reset(&manipulator->yield, &sample);
        return hand;
    }
    return manipulator_arm_yield_step(&manipulator->yield, &yield_setup, &sample);
}

/// Compute the commands of this cycle and pass them to the drives.
static void command(manipulator_t* const manipulator, const manipulator_arm_setup_t* const setup)
{
    manipulator_arm_control_t* const control = &manipulator->control;
    const double* const hand                 = angles_to_follow(manipulator, setup);
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
    const manipulator_arm_control_t* const control = &manipulator->control;
    const double* const external                   = control->observer.external_nm;
    if (manipulator->is_remote) {
        const manipulator_arm_yield_t* const yield  = &manipulator->yield;
        manipulator_robot_contact_payload_t payload = {.external_torque = {external[0], external[1]},
                                                       .echo   = {yield->acted_rad[0], yield->acted_rad[1]},
                                                       .normal = {yield->normal[0], yield->normal[1]},
                                                       .push   = yield->push_n,
                                                       .energy = yield->taken_j};
        manipulator_arm_jacobian(&manipulator->model, control->link_rad, payload.jacobian);
        (void)subsystem_link_write(manipulator->generic, MANIPULATOR_PORT_ROBOT_CONTACT, &payload,
                                   sizeof payload);
    } else {
        const manipulator_robot_state_payload_t payload = {
            .position        = {control->link_rad[0], control->link_rad[1]},
            .external_torque = {external[0], external[1]}};
        (void)subsystem_link_write(manipulator->generic, MANIPULATOR_PORT_ROBOT_STATE, &payload,
                                   sizeof payload);
    }
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
        parameters->identified.link_mass[i]  = manipulator->model.link_mass[i];
    }
    parameters->energy.taken       = manipulator->energy.taken_j;
    parameters->energy.given       = manipulator->energy.given_j;
    parameters->identified.updates = manipulator->identification.updates;
    drives_counters_publish(&manipulator->drives, control->limited);
    parameters->link_age =
        subsystem_link_age_us(manipulator->generic, manipulator->is_remote ? MANIPULATOR_PORT_HAND_MOTION
                                                                           : MANIPULATOR_PORT_HAND_POSITION);
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
