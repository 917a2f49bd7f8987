// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the arm share.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_INTERNAL_H
#define FSW_SUBSYSTEMS_ARM_ARM_INTERNAL_H

#include "fsw/subsystems/arm/arm.h"

/// arm_cycle.c: the cyclic callbacks.
void arm_sense(void* self);
void arm_cycle(void* self);

/// arm_functions.c: function commands, and the motions that they start.
status_t arm_perform(void* self, const subsystem_function_t* function);
/// Compute the next point of the desired motion; complete its function command at the last point.
void arm_motion_step(arm_t* arm, double period_s);
/// Abort all commanded motions: the callback `abandon` of drives.h.
void arm_abandon(void* self);

#endif // FSW_SUBSYSTEMS_ARM_ARM_INTERNAL_H
