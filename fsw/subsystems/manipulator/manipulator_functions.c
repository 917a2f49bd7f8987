// SPDX-License-Identifier: Apache-2.0
// Function commands of the manipulator, and the motion of the stand-alone configuration.
#include "fsw/subsystems/manipulator/manipulator_internal.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "fsw/framework/control/elementary.h"
#include "pus/core/tailoring.h"

#include <stddef.h>

#define STOP_RAD_S2 4.0 // Deceleration of STOP.
// The peak speed of a motion that DES_POSITION starts is this share of the speed limit.
#define PARAMETER_SHARE 0.5
#define PEAK_SPEED 1.875 // Peak speed of a minimum-jerk motion over distance 1 in time 1.
#define DURATION_MIN_S 0.1

// ---- Motion ----

static void end_move(manipulator_t* const manipulator, const uint16_t failure_code)
{
    manipulator->is_moving = false;
    subsystem_function_done(manipulator->generic, manipulator->move_token, failure_code, 0U);
    manipulator->move_token = 0U;
}

manipulator_arm_motion_t manipulator_motion_step(manipulator_t* const manipulator)
{
    FSW_ASSERT(manipulator != NULL);
    const manipulator_arm_setup_t setup = manipulator_setup(manipulator);
    bool is_done                        = true;
    manipulator_arm_motion_t desired;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const control_motion_point_t point = control_motion_step(&manipulator->motion[i], setup.period_s);
        manipulator->point[i]              = point;
        desired.position_rad[i]            = point.position;
        desired.velocity_rad_s[i]          = point.velocity;
        desired.acceleration_rad_s2[i]     = point.acceleration;
        manipulator->control.reference[i]  = (control_tracker_t){
             .position = point.position, .velocity = point.velocity, .acceleration = point.acceleration};
        is_done = is_done && control_motion_is_done(&manipulator->motion[i]);
    }
    if (manipulator->is_moving && is_done) {
        end_move(manipulator, PUS_FAILURE_NONE);
    }
    return desired;
}

static bool is_in_range(const manipulator_t* const manipulator, const double position_rad[ARM_JOINTS])
{
    const manipulator_control_t* const gains = &manipulator->parameters.control;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        if (!(control_absolute(position_rad[i] - gains->home[i]) <= gains->range[i])) {
            return false;
        }
    }
    return true;
}

static bool may_move(const manipulator_t* const manipulator)
{
    return (manipulator->drives.activity == DRIVES_ENGAGED) && !manipulator->is_torque_mode &&
           !manipulator->is_moving;
}

static void begin_move(manipulator_t* const manipulator, const double goal_rad[ARM_JOINTS],
                       const double duration_s)
{
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        control_motion_begin(&manipulator->motion[i], manipulator->point[i].position, goal_rad[i],
                             duration_s);
    }
    manipulator->is_moving = true;
}

static status_t move_to(manipulator_t* const manipulator,
                        const manipulator_move_to_arguments_t* const arguments, const uint32_t call_token)
{
    if (!may_move(manipulator)) {
        return STATUS_FORBIDDEN;
    }
    if (!is_in_range(manipulator, arguments->position) || !(arguments->duration >= DURATION_MIN_S)) {
        return STATUS_OUT_OF_RANGE;
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double distance = arguments->position[i] - manipulator->point[i].position;
        if (!(control_motion_peak_speed(distance, arguments->duration) <=
              manipulator->parameters.control.speed_limit)) {
            return STATUS_OUT_OF_RANGE;
        }
    }
    begin_move(manipulator, arguments->position, arguments->duration);
    manipulator->move_token = call_token;
    return STATUS_BUSY;
}

static status_t stop(manipulator_t* const manipulator)
{
    if ((manipulator->drives.activity != DRIVES_ENGAGED) || manipulator->is_torque_mode) {
        return STATUS_FORBIDDEN;
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        control_motion_brake(&manipulator->motion[i], &manipulator->point[i], STOP_RAD_S2);
    }
    end_move(manipulator, PUS_FAILURE_ABORTED);
    return STATUS_OK;
}

/// Move to DES_POSITION, which a telecommand has set, if that is permitted; otherwise the next cycle sets
/// the parameter to the present position again.
static void go_to_parameter(manipulator_t* const manipulator)
{
    const double* const goal = manipulator->parameters.des_position;
    if (!may_move(manipulator) || !is_in_range(manipulator, goal)) {
        return;
    }
    double duration_s = DURATION_MIN_S;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double distance = control_absolute(goal[i] - manipulator->point[i].position);
        const double needed =
            PEAK_SPEED * distance / (PARAMETER_SHARE * manipulator->parameters.control.speed_limit);
        duration_s = (needed > duration_s) ? needed : duration_s;
    }
    begin_move(manipulator, goal, duration_s);
}

void manipulator_parameter_set(void* const self, const uint32_t parameter_id)
{
    manipulator_t* const manipulator = self;
    if (parameter_id == MANIPULATOR_PARAMETER_DES_POSITION) {
        go_to_parameter(manipulator);
    }
    // The identification begins again with the new model or the new assumptions.
    if ((parameter_id == MANIPULATOR_PARAMETER_MODEL) ||
        (parameter_id == MANIPULATOR_PARAMETER_IDENTIFICATION)) {
        manipulator_take_model(manipulator);
    }
}

static void end_tare(manipulator_t* const manipulator, const uint16_t failure_code, const uint32_t detail)
{
    subsystem_function_done(manipulator->generic, manipulator->tare_token, failure_code, detail);
    manipulator->tare_token = 0U;
}

void manipulator_abandon(void* const self)
{
    FSW_ASSERT(self != NULL);
    manipulator_t* const manipulator = self;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) { // The desired motion becomes rest at the present position.
        manipulator->point[i] = (control_motion_point_t){.position = manipulator->control.link_rad[i]};
        control_motion_rest(&manipulator->motion[i], manipulator->control.link_rad[i]);
    }
    end_move(manipulator, PUS_FAILURE_ABORTED);
    if (manipulator->tare.result == STATUS_BUSY) { // The old zero stays in force.
        manipulator->tare.result = STATUS_EMPTY;
    }
    end_tare(manipulator, PUS_FAILURE_ABORTED, 0U);
}

// ---- Functions ----

/// Begin a tare, or take over a running tare that was started automatically.
static status_t tare(manipulator_t* const manipulator, const uint32_t call_token)
{
    if ((manipulator->drives.activity != DRIVES_PREPARED) || (manipulator->tare_token != 0U)) {
        return STATUS_FORBIDDEN;
    }
    if (manipulator->tare.result != STATUS_BUSY) {
        manipulator_arm_tare_begin(&manipulator->tare);
    }
    manipulator->tare_token = call_token;
    return STATUS_BUSY;
}

void manipulator_tare_ended(manipulator_t* const manipulator)
{
    FSW_ASSERT(manipulator != NULL);
    const bool is_done    = (manipulator->tare.result == STATUS_OK);
    manipulator->has_zero = manipulator->has_zero || is_done;
    if (is_done) {
        uint8_t octets[MANIPULATOR_EVENT_TARE_DONE_OCTETS];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_f64(&writer, manipulator->tare.offset_nm[0]);
        octet_write_f64(&writer, manipulator->tare.offset_nm[1]);
        (void)subsystem_raise(manipulator->generic, MANIPULATOR_EVENT_TARE_DONE, octets, writer.position);
    }
    end_tare(manipulator, is_done ? PUS_FAILURE_NONE : PUS_FAILURE_DEVICE,
             (uint32_t)manipulator->tare.result);
}

status_t manipulator_perform(void* const self, const subsystem_function_t* const function)
{
    manipulator_t* const manipulator = self;
    switch (function->function_id) {
    case MANIPULATOR_FUNCTION_MOVE_TO:
        return move_to(manipulator, function->arguments, function->call_token);
    case MANIPULATOR_FUNCTION_TARE:
        return tare(manipulator, function->call_token);
    case MANIPULATOR_FUNCTION_RAISE:
        return subsystem_raise_by_command(manipulator->generic,
                                          ((const manipulator_raise_arguments_t*)function->arguments)->event);
    case MANIPULATOR_FUNCTION_STOP:
        return stop(manipulator);
    case MANIPULATOR_FUNCTION_CHANNEL:
        return drives_select_channel(&manipulator->drives,
                                     ((const manipulator_channel_arguments_t*)function->arguments)->channel);
    default:
        return STATUS_NOT_FOUND;
    }
}
