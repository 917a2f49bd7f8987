// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/homing.h"

#include <math.h>
#include <stddef.h>

#define METHOD_NEGATIVE_STOP (-1)
#define METHOD_POSITIVE_STOP (-2)
#define METHOD_HERE 37     // The present position is the home position.
#define METHOD_HERE_OLD 35 // Older number of the same method.

#define BIT_START 0x0010U
#define BIT_HALT 0x0100U

bool homing_init(homing_t* const homing, const axis_t* const axis, const double position_unit,
                 const double velocity_unit)
{
    node_t* node           = axis->node;
    const bool is_required = ((axis->modes_supported->value >> (AXIS_MODE_HOMING - 1)) & 1U) != 0U;
    *homing                = (homing_t){.position_unit = position_unit,
                                        .velocity_unit = velocity_unit,
                                        .method        = node_object(node, 0x6098U, 0U),
                                        .speed         = node_object(node, 0x6099U, 1U),
                                        .acceleration  = node_object(node, 0x609AU, 0U),
                                        .offset        = node_object(node, 0x607CU, 0U),
                                        .low_position  = node_object(node, 0x607DU, 1U),
                                        .high_position = node_object(node, 0x607DU, 2U)};
    const bool has_all     = (homing->method != NULL) && (homing->speed != NULL) &&
                         (homing->acceleration != NULL) && (homing->offset != NULL) &&
                         (homing->low_position != NULL) && (homing->high_position != NULL);
    return has_all || !is_required;
}

void homing_reset(homing_t* const homing)
{
    homing->state           = HOMING_IDLE;
    homing->is_asked        = false;
    homing->is_halted       = false;
    homing->reference_rad_s = 0.0;
}

static void begin(homing_t* const homing)
{
    homing->state         = HOMING_SEARCHING;
    homing->travelled_rad = 0.0;
    homing->stalled_ns    = 0U;
}

void homing_command(homing_t* const homing, const uint16_t controlword)
{
    const bool is_asked = (controlword & BIT_START) != 0U;
    homing->is_halted   = (controlword & BIT_HALT) != 0U;
    if (is_asked && !homing->is_asked) {
        begin(homing);
    } else if (!is_asked && (homing->state == HOMING_SEARCHING)) {
        homing->state = HOMING_IDLE;
    } else {
        // The search continues, or its result is kept.
    }
    homing->is_asked = is_asked;
}

static bool takes_present_position(const int64_t method)
{
    return (method == METHOD_HERE) || (method == METHOD_HERE_OLD);
}

static bool searches_end_stop(const int64_t method)
{
    return (method == METHOD_NEGATIVE_STOP) || (method == METHOD_POSITIVE_STOP);
}

/// True while the axis is to move towards the end stop.
static bool is_running(const homing_t* const homing)
{
    return (homing->state == HOMING_SEARCHING) && !homing->is_halted &&
           searches_end_stop(object_signed(homing->method));
}

double homing_advance(homing_t* const homing, const double dt_s)
{
    const double direction = (object_signed(homing->method) == METHOD_NEGATIVE_STOP) ? -1.0 : 1.0;
    const double speed     = (double)homing->speed->value * homing->velocity_unit;
    const double wanted    = is_running(homing) ? (direction * speed) : 0.0;
    const double step      = (double)homing->acceleration->value * homing->velocity_unit * dt_s;
    const double change    = wanted - homing->reference_rad_s;
    homing->reference_rad_s += (change > step) ? step : ((change < -step) ? -step : change);
    homing->travelled_rad += fabs(homing->reference_rad_s) * dt_s;
    return homing->reference_rad_s;
}

bool homing_end_step(homing_t* const homing, const bool is_limited, const uint64_t step_ns)
{
    const int64_t method = object_signed(homing->method);
    const double range =
        (double)(object_signed(homing->high_position) - object_signed(homing->low_position)) *
        homing->position_unit;
    if ((homing->state != HOMING_SEARCHING) || homing->is_halted) {
        homing->stalled_ns = 0U;
        return false;
    }
    homing->stalled_ns = is_limited ? (homing->stalled_ns + step_ns) : 0U;
    const bool is_found =
        takes_present_position(method) || (is_running(homing) && (homing->stalled_ns >= HOMING_STALL_NS));
    if (is_found) {
        homing->state           = HOMING_ATTAINED;
        homing->reference_rad_s = 0.0;
    } else if (!searches_end_stop(method) || (homing->travelled_rad > range)) {
        homing->state = HOMING_FAILED;
    } else {
        // The search continues.
    }
    return is_found;
}

double homing_position_rad(const homing_t* const homing)
{
    return -(double)object_signed(homing->offset) * homing->position_unit;
}

static uint16_t flags_of(const homing_t* const homing)
{
    const bool is_at_rest = homing->reference_rad_s == 0.0;
    switch (homing->state) {
    case HOMING_ATTAINED:
        return AXIS_STATUS_HOMING_ATTAINED | AXIS_STATUS_TARGET_REACHED;
    case HOMING_FAILED:
        return (uint16_t)(AXIS_STATUS_HOMING_ERROR | (is_at_rest ? AXIS_STATUS_TARGET_REACHED : 0U));
    case HOMING_SEARCHING:
        return (homing->is_halted && is_at_rest) ? AXIS_STATUS_TARGET_REACHED : 0U;
    case HOMING_IDLE:
    default:
        return is_at_rest ? AXIS_STATUS_TARGET_REACHED : 0U;
    }
}

void homing_update_statusword(const homing_t* const homing, axis_t* const axis)
{
    const uint16_t bits = AXIS_STATUS_TARGET_REACHED | AXIS_STATUS_HOMING_ATTAINED | AXIS_STATUS_HOMING_ERROR;
    axis_flag(axis, bits, false);
    axis_flag(axis, flags_of(homing), true);
}
