// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the manipulator share.
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_INTERNAL_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_INTERNAL_H

#include "fsw/subsystems/manipulator/manipulator.h"

/// Returns gains, model and period of this cycle.
manipulator_arm_setup_t manipulator_setup(const manipulator_t* manipulator);
/// Begin the identification again, with the model of the parameters.
void manipulator_take_model(manipulator_t* manipulator);

/// manipulator_cycle.c: the cyclic callbacks.
void manipulator_sense(void* self);
void manipulator_control(void* self);

/// manipulator_functions.c: function commands, and the motions that they start.
status_t manipulator_perform(void* self, const subsystem_function_t* function);
void manipulator_parameter_set(void* self, uint32_t parameter_id);
/// Compute the next point of the commanded motion; complete its function command at the last point.
manipulator_arm_motion_t manipulator_motion_step(manipulator_t* manipulator);
/// Abort all commanded motions: the callback `abandon` of drives.h.
void manipulator_abandon(void* self);
/// Complete a running function TARE with the result of the tare.
void manipulator_tare_ended(manipulator_t* manipulator);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_INTERNAL_H
