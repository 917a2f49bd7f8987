// SPDX-License-Identifier: Apache-2.0
// The cycle of the joystick: position, torque, links and telemetry.
#include "fsw/subsystems/joystick/joystick_internal.h"

#include "fsw/canopen/axis.h"
#include "fsw/drives/drives_counters.h"
#include "base/octets.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

/// Decay rate [1/s] of the torque while samples are missing: 2 % is left after 20 ms. Also the rate at which
/// the reflection fades out.
#define FORGET_1_S 200.0

static double period_s(const joystick_t* const joystick)
{
    return (double)subsystem_period_ns(joystick->generic) * 1.0e-9;
}

/// Read the torque that the robot feels. False if there is no fresh sample.
static bool read_robot(joystick_t* const joystick)
{
    subsystem_t* const generic = joystick->generic;
    joystick_robot_state_payload_t near;
    joystick_robot_contact_payload_t far;
    bool is_fresh = false;
    if (joystick->is_remote) {
        is_fresh = subsystem_link_read(generic, JOYSTICK_PORT_ROBOT_CONTACT, &far, sizeof far) == STATUS_OK;
        if (is_fresh) {
            joystick_remote_contact_feel(&joystick->parameters.remote, &far, joystick->control.position_rad,
                                         joystick->felt_nm);
            control_reserve_take_sum(&joystick->contact.reserve, far.energy);
        }
    } else {
        is_fresh = subsystem_link_read(generic, JOYSTICK_PORT_ROBOT_STATE, &near, sizeof near) == STATUS_OK;
        if (is_fresh) {
            joystick->felt_nm[0] = near.external_torque[0];
            joystick->felt_nm[1] = near.external_torque[1];
        }
    }
    return is_fresh;
}

/// Take the torque of a fresh sample; while samples are missing, the torque decays.
static void take_felt_torque(joystick_t* const joystick)
{
    if (!read_robot(joystick)) {
        const double kept = 1.0 - control_clamp(FORGET_1_S * period_s(joystick), 0.0, 1.0);
        for (unsigned i = 0U; i < STICK_AXES; i++) {
            joystick->felt_nm[i] = control_settle(kept * joystick->felt_nm[i]);
        }
    }
}

/// Update the energy at the port to the hand with the command of the last cycle, which acted until now.
static void watch_energy(joystick_t* const joystick)
{
    const joystick_passivity_t* const passivity = &joystick->parameters.passivity;
    const control_port_watch_t watch            = {.limit_j  = passivity->limit,
                                                   .time_s   = passivity->time,
                                                   .rest_rad = passivity->rest,
                                                   .period_s = period_s(joystick)};
    // The command is the torque of the motor on the stick; the hand drives the stick against it.
    const double driven[STICK_AXES] = {-joystick->control.command_nm[0], -joystick->control.command_nm[1]};
    const double given =
        control_port_energy_step(&joystick->energy, &watch, driven, joystick->control.position_rad);
    if (given > 0.0) {
        uint8_t octets[JOYSTICK_EVENT_PASSIVITY_OCTETS];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_f64(&writer, given);
        (void)subsystem_raise(joystick->generic, JOYSTICK_EVENT_PASSIVITY, octets, writer.position);
    }
}

void joystick_sense(void* const self)
{
    joystick_t* const joystick = self;
    drives_sense(&joystick->drives);
    const canopen_device_t* const device = drives_device(&joystick->drives, 0U);
    if (!drives_are_running(&joystick->drives) || (device == NULL)) {
        return;
    }
    const double position[STICK_AXES] = {canopen_cia402_axis_position_rad(&device->axes[0]),
                                         canopen_cia402_axis_position_rad(&device->axes[1])};
    joystick_stick_control_sense(&joystick->control, &joystick->parameters.control, period_s(joystick),
                                 position);
    if (joystick->drives.activity == DRIVES_ENGAGED) {
        watch_energy(joystick);
    }
    if (joystick->is_reflecting) {
        take_felt_torque(joystick);
    }
}

/// Returns the share of the torque that is reflected. It rises smoothly from 0 to 1 when both sides are
/// OPERATIONAL, and falls to 0 when the robot's brakes engage; otherwise a robot that starts under load would
/// pull the hand away.
static double fade(joystick_t* const joystick, const double period)
{
    const double fade_time = joystick->parameters.control.fade_time;
    const bool is_coupled =
        (subsystem_link_peer_state(joystick->generic, joystick->robot_port) == STATE_OPERATIONAL);
    const double rate = is_coupled ? (1.0 / fade_time) : -FORGET_1_S;
    joystick->share   = control_clamp(joystick->share + (rate * period), 0.0, 1.0);
    return joystick->share * joystick->share * (3.0 - (2.0 * joystick->share));
}

/// Returns the damping that the passivity controller adds. The energy is computed from torques that have
/// already acted, so that the damping removes exactly the energy that was given away.
static double damping(joystick_t* const joystick, const double period)
{
    const joystick_stick_control_t* const control = &joystick->control;
    const double velocity[STICK_AXES] = {control->motion[0].velocity, control->motion[1].velocity};
    return joystick_remote_contact_damp(&joystick->contact, &joystick->parameters.remote, period,
                                        joystick->energy.taken_j, velocity);
}

static void command(joystick_t* const joystick, canopen_device_t* const device)
{
    const joystick_control_t* const gains = &joystick->parameters.control;
    const double period                   = period_s(joystick);
    joystick->control.added_damping       = joystick->is_remote ? damping(joystick, period) : 0.0;
    if (joystick->is_reflecting) {
        joystick_stick_control_reflect(&joystick->control, gains, period, joystick->felt_nm,
                                       fade(joystick, period));
    } else {
        joystick_display_step(joystick, period);
        joystick_stick_control_display(&joystick->control, gains, joystick->display.torque_nm);
    }
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        canopen_cia402_axis_command_torque(&device->axes[i], joystick->control.command_nm[i]);
    }
}

static void publish(joystick_t* const joystick, const canopen_device_t* const device)
{
    const joystick_stick_control_t* const control = &joystick->control;
    joystick_parameters_t* const parameters       = &joystick->parameters;
    parameter_dictionary_t* const dictionary      = subsystem_dictionary(joystick->generic);
    parameter_lock(dictionary);
    parameters->cur_values.state = (int32_t)subsystem_state(joystick->generic);
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        parameters->cur_values.position[i] = control->position_rad[i];
        parameters->cur_values.velocity[i] = control->motion[i].velocity;
        // FELT_TORQUE is what the hand feels; joystick->felt_nm is what the robot feels.
        parameters->cur_values.felt_torque[i] = control->command_nm[i];
        parameters->cur_values.statusword[i]  = (device != NULL) ? device->axes[i].statusword : 0U;
        parameters->des_torque[i] = joystick->is_reflecting ? 0.0 : joystick->display.torque_nm[i];
    }
    parameters->energy.taken = joystick->energy.taken_j;
    parameters->energy.given = joystick->energy.given_j;
    drives_counters_publish(&joystick->drives, control->limited);
    parameters->link_age = subsystem_link_age_us(joystick->generic, joystick->robot_port);
    parameter_unlock(dictionary);
}

static void write_link(joystick_t* const joystick)
{
    const double* const position = joystick->control.position_rad;
    if (joystick->is_remote) {
        const joystick_hand_motion_payload_t motion = {.position = {position[0], position[1]},
                                                       .energy   = joystick->energy.received_j};
        (void)subsystem_link_write(joystick->generic, JOYSTICK_PORT_HAND_MOTION, &motion, sizeof motion);
    } else {
        const joystick_hand_position_payload_t payload = {.position = {position[0], position[1]}};
        (void)subsystem_link_write(joystick->generic, JOYSTICK_PORT_HAND_POSITION, &payload, sizeof payload);
    }
}

void joystick_control(void* const self)
{
    joystick_t* const joystick     = self;
    canopen_device_t* const device = drives_device(&joystick->drives, 0U);
    if (drives_are_running(&joystick->drives) && (device != NULL) && joystick->control.is_started) {
        command(joystick, device);
    }
    write_link(joystick);
    publish(joystick, device);
}
