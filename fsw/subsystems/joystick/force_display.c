// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/joystick/force_display.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void joystick_force_display_clear(joystick_force_display_t* const display)
{
    FSW_ASSERT(display != NULL);
    *display = (joystick_force_display_t){.is_active = false};
}

void joystick_force_display_begin(joystick_force_display_t* const display, const double torque_nm[STICK_AXES],
                                  const double duration_s)
{
    FSW_ASSERT(display != NULL);
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        display->goal_nm[i] = torque_nm[i];
    }
    display->is_lasting = !(duration_s > 0.0);
    display->left_s     = display->is_lasting ? 0.0 : duration_s;
    display->is_active  = true;
}

void joystick_force_display_stop(joystick_force_display_t* const display)
{
    FSW_ASSERT(display != NULL);
    display->left_s     = 0.0;
    display->is_lasting = false;
}

void joystick_force_display_step(joystick_force_display_t* const display, const double period_s,
                                 const double rate_nm_s)
{
    FSW_ASSERT((display != NULL) && (rate_nm_s > 0.0));
    double largest = 0.0;
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        const double size = control_absolute(display->torque_nm[i]);
        largest           = (size > largest) ? size : largest;
    }
    // Begin to ramp down so early that the torque is zero when the duration ends.
    const bool is_held =
        display->is_active && (display->is_lasting || (display->left_s > (largest / rate_nm_s)));
    bool is_zero = true;
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        const double target = is_held ? display->goal_nm[i] : 0.0;
        const double step   = rate_nm_s * period_s;
        display->torque_nm[i] += control_clamp(target - display->torque_nm[i], -step, step);
        is_zero = is_zero && (display->torque_nm[i] == 0.0);
    }
    display->left_s    = (display->left_s > period_s) ? (display->left_s - period_s) : 0.0;
    display->is_active = display->is_lasting || (display->left_s > 0.0) || !is_zero;
}
