// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the joystick share.
#ifndef FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_INTERNAL_H
#define FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_INTERNAL_H

#include "fsw/subsystems/joystick/joystick.h"

/// joystick_cycle.c: the cyclic callbacks.
void joystick_sense(void* self);
void joystick_control(void* self);

/// joystick_functions.c: function commands.
status_t joystick_perform(void* self, const subsystem_function_t* function);
void joystick_parameter_set(void* self, uint32_t parameter_id);
/// Compute the next torque of the commanded display; complete its function command at the end.
void joystick_display_step(joystick_t* joystick, double period_s);
/// Abort all commanded displays: the callback `abandon` of drives.h.
void joystick_abandon(void* self);

#endif // FSW_SUBSYSTEMS_JOYSTICK_JOYSTICK_INTERNAL_H
