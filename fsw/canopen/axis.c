// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/axis.h"

#include "base/assertion.h"

#include <math.h>
#include <stddef.h>

#define HOMING_OFF 0U
#define HOMING_WANTED 1U
#define HOMING_STARTED 2U
#define HOMING_REPORTED 3U // The statusword reports this search.

void canopen_cia402_axis_init(canopen_cia402_axis_t* const axis, const canopen_cia402_scale_t scale)
{
    FSW_ASSERT((axis != NULL) && (scale.position_rad > 0.0) && (scale.torque_nm > 0.0));
    *axis = (canopen_cia402_axis_t){.scale = scale, .goal = CIA402_GOAL_DISABLED};
}

canopen_cia402_state_t canopen_cia402_axis_state(const canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    return canopen_cia402_state(axis->statusword);
}

void canopen_cia402_axis_set_goal(canopen_cia402_axis_t* const axis, const canopen_cia402_goal_t goal,
                                  const bool may_reset_fault)
{
    FSW_ASSERT(axis != NULL);
    if (goal != axis->goal) {
        axis->was_enabled = false;
    }
    axis->homing          = (goal == CIA402_GOAL_ENABLED) ? axis->homing : HOMING_OFF;
    axis->goal            = goal;
    axis->may_reset_fault = may_reset_fault;
    axis->has_dropped     = false;
}

void canopen_cia402_axis_observe(canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    // An axis that has left operation by itself is not switched on again.
    if (axis->goal == CIA402_GOAL_ENABLED) {
        if (canopen_cia402_axis_state(axis) == CIA402_OPERATION_ENABLED) {
            axis->was_enabled = true;
        } else if (axis->was_enabled) {
            canopen_cia402_axis_set_goal(axis, CIA402_GOAL_DISABLED, false);
            axis->has_dropped = true;
        }
    }
}

void canopen_cia402_axis_step(canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    axis->controlword = canopen_cia402_controlword(canopen_cia402_axis_state(axis), axis->goal,
                                                   axis->may_reset_fault, axis->controlword);
    if (axis->homing == HOMING_OFF) {
        return;
    }
    // Set bit 4 only in operation: the drive starts the search at its rising edge.
    if ((axis->controlword == CIA402_CONTROL_ENABLE) &&
        (canopen_cia402_axis_state(axis) == CIA402_OPERATION_ENABLED)) {
        axis->controlword |= CIA402_CONTROL_HOMING_START;
        axis->homing = (axis->homing == HOMING_WANTED) ? HOMING_STARTED : HOMING_REPORTED;
    } else {
        axis->homing = HOMING_WANTED;
    }
}

bool canopen_cia402_axis_is_at_goal(const canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    return !axis->has_dropped && canopen_cia402_is_at_goal(canopen_cia402_axis_state(axis), axis->goal);
}

double canopen_cia402_axis_position_rad(const canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    return (double)axis->position * axis->scale.position_rad;
}

double canopen_cia402_axis_torque_nm(const canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    return (double)axis->torque * axis->scale.torque_nm;
}

/// Convert a value to the nearest number of units within +-limit, halves away from zero, and count clipped
/// values.
static double to_units(canopen_cia402_axis_t* const axis, const double value, const double unit,
                       const double limit)
{
    const double units = value / unit;
    if (units > limit) {
        axis->limited++;
        return limit;
    }
    if (units < -limit) {
        axis->limited++;
        return -limit;
    }
    return round(units);
}

/// Limit a value to the range from `low` to `high`, and count clipped values.
static double within(canopen_cia402_axis_t* const axis, const double value, const double low,
                     const double high)
{
    const double limited = (value < low) ? low : ((value > high) ? high : value);
    axis->limited += (limited != value) ? 1U : 0U;
    return limited;
}

static int16_t torque_units(canopen_cia402_axis_t* const axis, const double torque_nm)
{
    if (torque_nm != torque_nm) { // NaN.
        axis->limited++;
        return 0;
    }
    const double by_axis = axis->scale.torque_max_nm / axis->scale.torque_nm;
    const double limit   = (by_axis < (double)INT16_MAX) ? by_axis : (double)INT16_MAX;
    return (int16_t)to_units(axis, torque_nm, axis->scale.torque_nm, limit);
}

void canopen_cia402_axis_command_position(canopen_cia402_axis_t* const axis, const double position_rad,
                                          const double torque_offset_nm)
{
    FSW_ASSERT(axis != NULL);
    const canopen_cia402_scale_t* const scale = &axis->scale;
    if (position_rad == position_rad) { // False for NaN.
        const double limited_rad = (scale->low_rad < scale->high_rad)
                                       ? within(axis, position_rad, scale->low_rad, scale->high_rad)
                                       : position_rad;
        axis->target_position = (int32_t)to_units(axis, limited_rad, scale->position_rad, (double)INT32_MAX);
    } else {
        axis->limited++;
    }
    axis->torque_offset = torque_units(axis, torque_offset_nm);
}

void canopen_cia402_axis_command_velocity(canopen_cia402_axis_t* const axis, const double velocity_rad_s,
                                          const double torque_offset_nm)
{
    FSW_ASSERT(axis != NULL);
    const canopen_cia402_scale_t* const scale = &axis->scale;
    if (velocity_rad_s == velocity_rad_s) { // False for NaN.
        const double limited_rad_s =
            (scale->speed_rad_s > 0.0) ? within(axis, velocity_rad_s, -scale->speed_rad_s, scale->speed_rad_s)
                                       : velocity_rad_s;
        axis->target_velocity =
            (int32_t)to_units(axis, limited_rad_s, scale->velocity_rad_s, (double)INT32_MAX);
    } else {
        axis->target_velocity = 0;
        axis->limited++;
    }
    axis->torque_offset = torque_units(axis, torque_offset_nm);
}

void canopen_cia402_axis_home(canopen_cia402_axis_t* const axis, const bool is_wanted)
{
    FSW_ASSERT(axis != NULL);
    if (!is_wanted) {
        axis->homing = HOMING_OFF;
    } else if (axis->homing == HOMING_OFF) {
        axis->homing = HOMING_WANTED;
    } else {
        // The search continues.
    }
}

status_t canopen_cia402_axis_homing(const canopen_cia402_axis_t* const axis)
{
    FSW_ASSERT(axis != NULL);
    if ((axis->homing == HOMING_OFF) || (canopen_cia402_axis_state(axis) != CIA402_OPERATION_ENABLED)) {
        return STATUS_EMPTY;
    }
    if (axis->homing != HOMING_REPORTED) {
        return STATUS_BUSY;
    }
    if ((axis->statusword & CIA402_STATUS_HOMING_ERROR) != 0U) {
        return STATUS_INVALID;
    }
    const uint16_t done = CIA402_STATUS_TARGET_REACHED | CIA402_STATUS_HOMING_ATTAINED;
    return ((axis->statusword & done) == done) ? STATUS_OK : STATUS_BUSY;
}

void canopen_cia402_axis_command_torque(canopen_cia402_axis_t* const axis, const double torque_nm)
{
    FSW_ASSERT(axis != NULL);
    axis->target_torque = torque_units(axis, torque_nm);
}
