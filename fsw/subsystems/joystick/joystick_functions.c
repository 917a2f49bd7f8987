// SPDX-License-Identifier: Apache-2.0
// Function commands of the joystick.
#include "fsw/subsystems/joystick/joystick_internal.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"
#include "pus/core/tailoring.h"

#include <stddef.h>

static void end_force(joystick_t* const joystick, const uint16_t failure_code)
{
    subsystem_function_done(joystick->generic, joystick->force_call_token, failure_code, 0U);
    joystick->force_call_token = 0U;
}

void joystick_abandon(void* const self)
{
    FSW_ASSERT(self != NULL);
    joystick_t* const joystick = self;
    joystick_force_display_clear(&joystick->display);
    end_force(joystick, PUS_FAILURE_ABORTED);
}

void joystick_display_step(joystick_t* const joystick, const double period_s)
{
    FSW_ASSERT(joystick != NULL);
    const joystick_control_t* const gains = &joystick->parameters.control;
    if (!joystick->display.is_active) {
        return;
    }
    // If the ceiling is zero, the torque is zero, but the display still ends after its duration: any positive
    // rate is suitable.
    const double rate = gains->torque_ceiling / gains->ramp_time;
    joystick_force_display_step(&joystick->display, period_s, (rate > 0.0) ? rate : 1.0);
    if (!joystick->display.is_active) {
        end_force(joystick, PUS_FAILURE_NONE);
    }
}

static bool may_display(const joystick_t* const joystick)
{
    return (joystick->drives.activity == DRIVES_ENGAGED) && !joystick->is_reflecting;
}

static bool is_in_range(const joystick_t* const joystick, const double torque_nm[STICK_AXES])
{
    const double ceiling = joystick->parameters.control.torque_ceiling;
    return (control_absolute(torque_nm[0]) <= ceiling) && (control_absolute(torque_nm[1]) <= ceiling);
}

static status_t force(joystick_t* const joystick, const joystick_force_arguments_t* const arguments,
                      const uint32_t call_token)
{
    if (!may_display(joystick) || (joystick->force_call_token != 0U)) {
        return STATUS_FORBIDDEN;
    }
    if (!is_in_range(joystick, arguments->torque) || !(arguments->duration > 0.0)) {
        return STATUS_OUT_OF_RANGE;
    }
    joystick_force_display_begin(&joystick->display, arguments->torque, arguments->duration);
    joystick->force_call_token = call_token;
    return STATUS_BUSY;
}

static status_t stop(joystick_t* const joystick)
{
    if (!may_display(joystick)) {
        return STATUS_FORBIDDEN;
    }
    joystick_force_display_stop(&joystick->display);
    end_force(joystick, PUS_FAILURE_ABORTED);
    return STATUS_OK;
}

status_t joystick_perform(void* const self, const subsystem_function_t* const function)
{
    joystick_t* const joystick = self;
    switch (function->function_id) {
    case JOYSTICK_FUNCTION_FORCE:
        return force(joystick, function->arguments, function->call_token);
    case JOYSTICK_FUNCTION_RAISE:
        return subsystem_raise_by_command(joystick->generic,
                                          ((const joystick_raise_arguments_t*)function->arguments)->event);
    case JOYSTICK_FUNCTION_STOP:
        return stop(joystick);
    case JOYSTICK_FUNCTION_CHANNEL:
        return drives_select_channel(&joystick->drives,
                                     ((const joystick_channel_arguments_t*)function->arguments)->channel);
    default:
        return STATUS_NOT_FOUND;
    }
}

/// React to a parameter that a telecommand has set: DES_TORQUE is displayed until STOP, if the state permits
/// it.
void joystick_parameter_set(void* const self, const uint32_t parameter_id)
{
    joystick_t* const joystick = self;
    const double* const torque = joystick->parameters.des_torque;
    if ((parameter_id == JOYSTICK_PARAMETER_DES_TORQUE) && may_display(joystick) &&
        (joystick->force_call_token == 0U) && is_in_range(joystick, torque)) {
        joystick_force_display_begin(&joystick->display, torque, 0.0);
    }
}
