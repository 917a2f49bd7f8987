// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/joystick/stick_control.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void joystick_stick_control_init(joystick_stick_control_t* const control)
{
    FSW_ASSERT(control != NULL);
    *control = (joystick_stick_control_t){.is_started = false};
}

void joystick_stick_control_sense(joystick_stick_control_t* const control,
                                  const joystick_control_t* const gains, const double period_s,
                                  const double position_rad[STICK_AXES])
{
    FSW_ASSERT((control != NULL) && (gains != NULL));
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        control->position_rad[i] = position_rad[i];
        if (!control->is_started) {
            control_tracker_reset(&control->motion[i], position_rad[i]);
        }
        control_tracker_step(&control->motion[i], position_rad[i], gains->velocity_bandwidth, period_s);
    }
    control->is_started = true;
}

/// Command a torque minus the damping, limited to the ceiling, and count the limitation.
static void command_torque(joystick_stick_control_t* const control, const joystick_control_t* const gains,
                           const unsigned axis, const double torque_nm, const double damping_nms_rad)
{
    const double wanted       = torque_nm - (damping_nms_rad * control->motion[axis].velocity);
    control->command_nm[axis] = control_clamp(wanted, -gains->torque_ceiling, gains->torque_ceiling);
    control->limited += (control->command_nm[axis] != wanted) ? 1U : 0U;
}

void joystick_stick_control_reflect(joystick_stick_control_t* const control,
                                    const joystick_control_t* const gains, const double period_s,
                                    const double felt_nm[STICK_AXES], const double share)
{
    FSW_ASSERT((control != NULL) && (gains != NULL));
    double largest = 0.0;
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        const double size = control_absolute(felt_nm[i]);
        largest           = (size > largest) ? size : largest;
    }
    const double excess = largest - gains->contact_threshold;
    const double target = control_clamp(excess / gains->contact_range, 0.0, 1.0);
    const double rate   = (target > control->contact) ? gains->contact_attack : gains->contact_decay;
    const double gain   = control_clamp(rate * period_s, 0.0, 1.0);
    control->contact    = control_settle(control->contact + (gain * (target - control->contact)));
    const double damping =
        gains->damping_free + (gains->damping_contact * control->contact) + control->added_damping;
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        command_torque(control, gains, i, share * gains->force_scale * felt_nm[i], damping);
    }
}

void joystick_stick_control_display(joystick_stick_control_t* const control,
                                    const joystick_control_t* const gains, const double torque_nm[STICK_AXES])
{
    FSW_ASSERT((control != NULL) && (gains != NULL));
    control->contact = 0.0;
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        command_torque(control, gains, i, torque_nm[i], gains->damping_free);
    }
}
