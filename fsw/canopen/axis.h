// SPDX-License-Identifier: Apache-2.0
/// One CiA 402 axis: raw words of its process data, their physical values, and the controlwords that lead it
/// to a power state.
///
/// An axis that leaves OPERATION ENABLED without a command is not switched on again: its goal becomes
/// DISABLED and `has_dropped` stays set until the next canopen_cia402_axis_set_goal.
///
/// Ownership  The caller provides canopen_cia402_axis_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_CANOPEN_AXIS_H
#define FSW_CANOPEN_AXIS_H

#include "fsw/canopen/cia402.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double position_rad;   ///< Size of one unit of the position words [rad].
    double velocity_rad_s; ///< Size of one unit of the velocity words [rad/s].
    double torque_nm;      ///< Size of one unit of the torque words [Nm].
    double torque_max_nm;  ///< Commands are limited to +- this torque [Nm].
    /// Limits of commanded positions; not limited if `low_rad` is not below `high_rad`.
    double low_rad;
    double high_rad;
    double speed_rad_s; ///< Largest commanded speed; 0: not limited.
} canopen_cia402_scale_t;

/// Objects are those of the first axis of a device; those of the next axes are at + 0x800 each.
typedef struct {             // Process data write the raw words; all else is read-only outside.
    uint16_t statusword;     ///< 0x6041.
    uint16_t controlword;    ///< 0x6040.
    int32_t position;        ///< 0x6064.
    int32_t velocity;        ///< 0x606C.
    int16_t torque;          ///< 0x6077.
    int16_t current;         ///< 0x6078.
    int32_t target_position; ///< 0x607A.
    int16_t torque_offset;   ///< 0x60B2.
    int16_t target_torque;   ///< 0x6071.
    int32_t target_velocity; ///< 0x60FF.
    /// Values of commands that were NaN, or were cut at a limit of the axis or at the range of their word
    /// [values, wraps].
    uint32_t limited;
    canopen_cia402_scale_t scale;
    canopen_cia402_goal_t goal;
    /// A fault may be reset on the way to the goal.
    bool may_reset_fault;
    bool was_enabled; ///< OPERATION ENABLED was reached with this goal.
    /// The axis has left OPERATION ENABLED without a command.
    bool has_dropped;
    /// Search for the reference: 0: none, 1: the start bit is not sent yet, 2: it was sent in one cycle,
    /// 3: in more. The first statusword after the start bit may be older than the bit.
    uint8_t homing;
} canopen_cia402_axis_t;

/// Initialise the axis with the goal DISABLED; all words are 0.
void canopen_cia402_axis_init(canopen_cia402_axis_t* axis, canopen_cia402_scale_t scale);
canopen_cia402_state_t canopen_cia402_axis_state(const canopen_cia402_axis_t* axis);
/// Set a new goal. A fault on the way to it is reset only if `may_reset_fault` is set.
void canopen_cia402_axis_set_goal(canopen_cia402_axis_t* axis, canopen_cia402_goal_t goal,
                                  bool may_reset_fault);
/// Update the state of the axis. Call it once per cycle, after the process data were received.
void canopen_cia402_axis_observe(canopen_cia402_axis_t* axis);
/// Choose the next controlword. Call it once per cycle, before the process data are sent.
void canopen_cia402_axis_step(canopen_cia402_axis_t* axis);
/// True if the state is that of the goal (canopen_cia402_is_at_goal), and `has_dropped` is not set.
bool canopen_cia402_axis_is_at_goal(const canopen_cia402_axis_t* axis);

double canopen_cia402_axis_position_rad(const canopen_cia402_axis_t* axis);
double canopen_cia402_axis_torque_nm(const canopen_cia402_axis_t* axis);

/// Command a position (CSP) with a torque offset. All commands are cut at the limits (counted) and rounded
/// to the nearest unit, halves away from zero. A position NaN leaves the target unchanged; a torque NaN is 0.
void canopen_cia402_axis_command_position(canopen_cia402_axis_t* axis, double position_rad,
                                          double torque_offset_nm);
/// Command a velocity (CSV) with a torque offset; NaN counts as 0.
void canopen_cia402_axis_command_velocity(canopen_cia402_axis_t* axis, double velocity_rad_s,
                                          double torque_offset_nm);
/// Start or end the search for the reference, in mode homing (0x6060 = 6) and in operation. A goal other
/// than ENABLED also ends it. After a result, end the search before the next start.
void canopen_cia402_axis_home(canopen_cia402_axis_t* axis, bool is_wanted);
/// Returns the result of homing: STATUS_BUSY; STATUS_OK (reference found); STATUS_INVALID (error of the
/// drive); STATUS_EMPTY (not started, or not in operation).
MUST_USE status_t canopen_cia402_axis_homing(const canopen_cia402_axis_t* axis);
/// Command a torque (CST). NaN: torque 0.
void canopen_cia402_axis_command_torque(canopen_cia402_axis_t* axis, double torque_nm);

#endif // FSW_CANOPEN_AXIS_H
