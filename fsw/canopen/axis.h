// SPDX-License-Identifier: Apache-2.0
/// One CiA 402 axis: raw words of its process data, their physical values, and its way to a power state.
///
/// An axis that leaves OPERATION ENABLED without a command is not switched on again: its goal becomes
/// DISABLED and `has_dropped` stays set until the next cia402_axis_set_goal.
///
/// Ownership  The caller places cia402_axis_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_CANOPEN_AXIS_H
#define FSW_CANOPEN_AXIS_H

#include "fsw/canopen/cia402.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double position_rad;   ///< One position unit [rad].
    double velocity_rad_s; ///< One velocity unit [rad/s].
    double torque_nm;      ///< One torque unit [Nm].
    double torque_max_nm;  ///< The axis accepts +- this [Nm].
} cia402_scale_t;

typedef struct { // Raw words are written by the process data; the rest is read-only outside.
    uint16_t statusword;
    int32_t position;
    int32_t velocity;
    int16_t torque;
    int16_t current;
    uint16_t controlword;
    int32_t target_position;
    int16_t torque_offset;
    int16_t target_torque;
    int32_t target_velocity;
    cia402_scale_t scale;
    cia402_goal_t goal;
    bool may_reset_fault;
    bool was_enabled; ///< OPERATION ENABLED was reached with this goal.
    bool has_dropped;
    uint32_t limited; ///< Commands cut at torque_max_nm or at the range of their word [commands, wraps].
} cia402_axis_t;

/// Goal DISABLED, all words zero.
void cia402_axis_init(cia402_axis_t* axis, cia402_scale_t scale);
cia402_state_t cia402_axis_state(const cia402_axis_t* axis);
/// New goal. A fault is reset on the way only with `may_reset_fault`.
void cia402_axis_set_goal(cia402_axis_t* axis, cia402_goal_t goal, bool may_reset_fault);
/// Once per cycle, after the process data were received: update the state of the axis.
void cia402_axis_observe(cia402_axis_t* axis);
/// Once per cycle, before the process data go out: choose the next controlword.
void cia402_axis_step(cia402_axis_t* axis);
bool cia402_axis_is_at_goal(const cia402_axis_t* axis);

double cia402_axis_position_rad(const cia402_axis_t* axis);
double cia402_axis_torque_nm(const cia402_axis_t* axis);

/// Commands; cut at the limits (counted), rounded to the nearest unit. Not a number: torque 0, position as
/// before.
void cia402_axis_command_position(cia402_axis_t* axis, double position_rad, double torque_offset_nm);
void cia402_axis_command_torque(cia402_axis_t* axis, double torque_nm);

#endif // FSW_CANOPEN_AXIS_H
