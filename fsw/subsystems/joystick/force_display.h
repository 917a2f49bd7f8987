// SPDX-License-Identifier: Apache-2.0
/// Display of a commanded torque: the torque rises at a limited rate, is held, and is zero again when its
/// duration ends.
///
/// Ownership  The caller provides joystick_force_display_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_JOYSTICK_FORCE_DISPLAY_H
#define FSW_SUBSYSTEMS_JOYSTICK_FORCE_DISPLAY_H

#include "fsw/subsystems/joystick/stick_control.h"

#include <stdbool.h>

typedef struct { // Read-only outside.
    double goal_nm[STICK_AXES];
    double torque_nm[STICK_AXES]; ///< Torque to be displayed now.
    double left_s;                ///< Time until the torque must be zero again.
    bool is_lasting;              ///< The torque is displayed until it is stopped.
    bool is_active;
} joystick_force_display_t;

/// Set the torque to zero immediately.
void joystick_force_display_clear(joystick_force_display_t* display);
/// Display a torque for a duration, or until it is stopped (duration_s <= 0). It begins at the present
/// torque.
void joystick_force_display_begin(joystick_force_display_t* display, const double torque_nm[STICK_AXES],
                                  double duration_s);
/// Let the torque fall to zero from now on.
void joystick_force_display_stop(joystick_force_display_t* display);
/// Advance by one period with a rate of change > 0.
void joystick_force_display_step(joystick_force_display_t* display, double period_s, double rate_nm_s);

#endif // FSW_SUBSYSTEMS_JOYSTICK_FORCE_DISPLAY_H
