// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/axis.h"

#include <stddef.h>

#define PI 3.14159265358979323846

#define BIT_SWITCH_ON 0x01U
#define BIT_ENABLE_VOLTAGE 0x02U
#define BIT_QUICK_STOP 0x04U // Active low: 0 commands the quick stop.
#define BIT_ENABLE_OPERATION 0x08U
#define BIT_FAULT_RESET 0x80U

#define STATUS_VOLTAGE 0x0010U
#define STATUS_REMOTE 0x0200U

// Abort connection option code (0x6007).
#define OPTION_NOTHING 0
#define OPTION_FAULT 1
#define OPTION_DISABLE_VOLTAGE 2

typedef enum {
    COMMAND_DISABLE_VOLTAGE,
    COMMAND_QUICK_STOP,
    COMMAND_SHUTDOWN,
    COMMAND_SWITCH_ON,
    COMMAND_ENABLE
} command_t;

static command_t command_of(const uint16_t controlword)
{
    if ((controlword & BIT_ENABLE_VOLTAGE) == 0U) {
        return COMMAND_DISABLE_VOLTAGE;
    }
    if ((controlword & BIT_QUICK_STOP) == 0U) {
        return COMMAND_QUICK_STOP;
    }
    if ((controlword & BIT_SWITCH_ON) == 0U) {
        return COMMAND_SHUTDOWN;
    }
    return ((controlword & BIT_ENABLE_OPERATION) != 0U) ? COMMAND_ENABLE : COMMAND_SWITCH_ON;
}

axis_state_t axis_next(const axis_state_t state, const uint16_t controlword, const uint16_t before)
{
    static const axis_state_t next[AXIS_STATE_COUNT][5] = {
        // disable voltage, quick stop, shutdown, switch on, enable
        [AXIS_NOT_READY] = {AXIS_NOT_READY, AXIS_NOT_READY, AXIS_NOT_READY, AXIS_NOT_READY, AXIS_NOT_READY},
        [AXIS_SWITCH_ON_DISABLED] = {AXIS_SWITCH_ON_DISABLED, AXIS_SWITCH_ON_DISABLED, AXIS_READY,
                                     AXIS_SWITCH_ON_DISABLED, AXIS_SWITCH_ON_DISABLED},
        [AXIS_READY]       = {AXIS_SWITCH_ON_DISABLED, AXIS_SWITCH_ON_DISABLED, AXIS_READY, AXIS_SWITCHED_ON,
                              AXIS_ENABLED},
        [AXIS_SWITCHED_ON] = {AXIS_SWITCH_ON_DISABLED, AXIS_SWITCH_ON_DISABLED, AXIS_READY, AXIS_SWITCHED_ON,
                              AXIS_ENABLED},
        [AXIS_ENABLED]     = {AXIS_SWITCH_ON_DISABLED, AXIS_QUICK_STOP, AXIS_READY, AXIS_SWITCHED_ON,
                              AXIS_ENABLED},
        [AXIS_QUICK_STOP]  = {AXIS_SWITCH_ON_DISABLED, AXIS_QUICK_STOP, AXIS_QUICK_STOP, AXIS_QUICK_STOP,
                              AXIS_QUICK_STOP},
        [AXIS_FAULT_REACTION] = {AXIS_FAULT_REACTION, AXIS_FAULT_REACTION, AXIS_FAULT_REACTION,
                                 AXIS_FAULT_REACTION, AXIS_FAULT_REACTION},
        [AXIS_FAULT]          = {AXIS_FAULT, AXIS_FAULT, AXIS_FAULT, AXIS_FAULT, AXIS_FAULT},
    };
    if (state == AXIS_FAULT) {
        const uint32_t risen = controlword & ~(uint32_t)before & BIT_FAULT_RESET;
        return (risen != 0U) ? AXIS_SWITCH_ON_DISABLED : AXIS_FAULT;
    }
    return next[state][command_of(controlword)];
}

uint16_t axis_state_bits(const axis_state_t state)
{
    static const uint16_t bits[AXIS_STATE_COUNT] = {
        [AXIS_NOT_READY] = 0x00U,      [AXIS_SWITCH_ON_DISABLED] = 0x40U,
        [AXIS_READY] = 0x21U,          [AXIS_SWITCHED_ON] = 0x23U,
        [AXIS_ENABLED] = 0x27U,        [AXIS_QUICK_STOP] = 0x07U,
        [AXIS_FAULT_REACTION] = 0x0FU, [AXIS_FAULT] = 0x08U};
    return (uint16_t)(bits[state] | STATUS_VOLTAGE | STATUS_REMOTE);
}

bool axis_function_is_enabled(const axis_state_t state)
{
    return (state == AXIS_ENABLED) || (state == AXIS_QUICK_STOP) || (state == AXIS_FAULT_REACTION);
}

// ---- Units ----

/// Returns the value of an object; 0 if the node has no such object.
static uint64_t number_of(node_t* const node, const unsigned index, const uint8_t subindex)
{
    const object_t* const object = node_object(node, (uint16_t)index, subindex);
    return (object != NULL) ? object->value : 0U;
}

/// Returns the factor of a unit object (CiA 303-2) to rad or rad/s; 0 for other units. Numerator 0x10: rad,
/// 0x41: degree, 0xB4: revolution; denominator 0x03: second, 0x47: minute.
static double factor_of(const uint64_t code, const bool is_velocity)
{
    const int8_t exponent     = (int8_t)(uint8_t)(code >> 24);
    const uint8_t numerator   = (uint8_t)(code >> 16);
    const uint8_t denominator = (uint8_t)(code >> 8);
    const bool is_by_second   = is_velocity && (denominator == 0x03U);
    const bool is_by_minute   = is_velocity && (denominator == 0x47U);
    double factor             = (numerator == 0x10U)
                                    ? 1.0
                                    : ((numerator == 0x41U) ? (PI / 180.0) : ((numerator == 0xB4U) ? (2.0 * PI) : 0.0));
    double power              = 1.0;
    for (int i = (exponent < 0) ? -exponent : exponent; i > 0; i--) {
        power *= 10.0;
    }
    factor = (exponent < 0) ? (factor / power) : (factor * power);
    if (is_by_minute) {
        factor /= 60.0;
    }
    return (is_by_second || is_by_minute || (!is_velocity && (denominator == 0U))) ? factor : 0.0;
}

bool axis_units(node_t* const node, const uint8_t number, double* const out_position_rad,
                double* const out_velocity_rad_s)
{
    const unsigned offset   = number * AXIS_STRIDE;
    const uint64_t position = number_of(node, 0x60A8U + offset, 0U);
    const uint64_t velocity = number_of(node, 0x60A9U + offset, 0U);
    const double counts =
        (double)number_of(node, 0x608FU + offset, 1U) * (double)number_of(node, 0x6091U + offset, 1U);
    const double turns =
        (double)number_of(node, 0x608FU + offset, 2U) * (double)number_of(node, 0x6091U + offset, 2U);
    const double increment = (counts > 0.0) ? (2.0 * PI * turns / counts) : 0.0;
    *out_position_rad      = (position != 0U) ? factor_of(position, false) : increment;
    *out_velocity_rad_s    = (velocity != 0U) ? factor_of(velocity, true) : *out_position_rad;
    return (*out_position_rad > 0.0) && (*out_velocity_rad_s > 0.0);
}

bool axis_init(axis_t* const axis, node_t* const node, const uint8_t number)
{
    const uint16_t offset = (uint16_t)(number * AXIS_STRIDE);
    *axis                 = (axis_t){.node = node, .number = number, .state = AXIS_NOT_READY};
    axis->abort_option    = node_object(node, (uint16_t)(0x6007U + offset), 0U);
    axis->error_code      = node_object(node, (uint16_t)(0x603FU + offset), 0U);
    axis->controlword     = node_object(node, (uint16_t)(0x6040U + offset), 0U);
    axis->statusword      = node_object(node, (uint16_t)(0x6041U + offset), 0U);
    axis->mode            = node_object(node, (uint16_t)(0x6060U + offset), 0U);
    axis->mode_display    = node_object(node, (uint16_t)(0x6061U + offset), 0U);
    axis->modes_supported = node_object(node, (uint16_t)(0x6502U + offset), 0U);
    return (axis->abort_option != NULL) && (axis->error_code != NULL) && (axis->controlword != NULL) &&
           (axis->statusword != NULL) && (axis->mode != NULL) && (axis->mode_display != NULL) &&
           (axis->modes_supported != NULL);
}

void axis_observe(axis_t* const axis, const axis_observer_t observer, void* const context)
{
    axis->observer         = observer;
    axis->observer_context = context;
}

static void update_statusword(axis_t* const axis)
{
    axis->statusword->value = (uint64_t)axis_state_bits(axis->state) | axis->flags;
}

static void enter(axis_t* const axis, const axis_state_t state, const uint64_t now_ns)
{
    axis->state = state;
    if (state != AXIS_ENABLED) {
        axis->flags &= AXIS_STATUS_WARNING; // The other flags describe a motion.
    }
    update_statusword(axis);
    if (axis->observer != NULL) {
        axis->observer(axis->observer_context, node_id(axis->node), axis->number,
                       (uint16_t)axis->statusword->value, !axis_function_is_enabled(state), now_ns);
    }
    node_event(axis->node, now_ns);
}

void axis_reset(axis_t* const axis, const uint64_t now_ns)
{
    axis->flags            = 0U;
    axis->has_fault        = false;
    axis->last_controlword = 0U;
    (void)axis_select_mode(axis);
    enter(axis, AXIS_SWITCH_ON_DISABLED, now_ns);
}

bool axis_command(axis_t* const axis, const uint64_t now_ns)
{
    const uint16_t controlword = (uint16_t)axis->controlword->value;
    const uint16_t before      = axis->last_controlword;
    axis->last_controlword     = controlword;
    axis_state_t next          = axis_next(axis->state, controlword, before);
    if ((next == AXIS_ENABLED) && (axis->state != AXIS_ENABLED) && (axis_mode(axis) == 0)) {
        next = AXIS_SWITCHED_ON; // Without a mode of operation the axis is not enabled.
    }
    if ((axis->state == AXIS_FAULT) && axis->has_fault) {
        next = AXIS_FAULT;
    }
    if (next == axis->state) {
        return false;
    }
    if (axis->state == AXIS_FAULT) {
        object_set(axis->error_code, 0);
    }
    enter(axis, next, now_ns);
    return true;
}

bool axis_select_mode(axis_t* const axis)
{
    if (axis->mode_display->value == axis->mode->value) {
        return false;
    }
    axis->mode_display->value = axis->mode->value;
    return true;
}

uint32_t axis_check_mode(const axis_t* const axis, const int64_t mode)
{
    const bool is_known = (mode == 0) || ((mode > 0) && (mode <= 32) &&
                                          (((axis->modes_supported->value >> (mode - 1)) & 1U) != 0U));
    return is_known ? 0U : SDO_ABORT_VALUE;
}

int axis_mode(const axis_t* const axis)
{
    return (int)object_signed(axis->mode_display);
}

void axis_connection_lost(axis_t* const axis, const uint64_t now_ns)
{
    if (axis->state != AXIS_ENABLED) {
        return;
    }
    switch (object_signed(axis->abort_option)) {
    case OPTION_NOTHING:
        break;
    case OPTION_FAULT:
        axis_fault(axis, EMERGENCY_HEARTBEAT, now_ns);
        break;
    case OPTION_DISABLE_VOLTAGE:
        enter(axis, AXIS_SWITCH_ON_DISABLED, now_ns);
        break;
    default:
        enter(axis, AXIS_QUICK_STOP, now_ns);
        break;
    }
}

void axis_fault(axis_t* const axis, const uint16_t code, const uint64_t now_ns)
{
    object_set(axis->error_code, code);
    if ((axis->state == AXIS_FAULT) || (axis->state == AXIS_FAULT_REACTION)) {
        return;
    }
    enter(axis, axis_function_is_enabled(axis->state) ? AXIS_FAULT_REACTION : AXIS_FAULT, now_ns);
}

void axis_ramp_done(axis_t* const axis, const uint64_t now_ns)
{
    if (axis->state == AXIS_QUICK_STOP) {
        enter(axis, AXIS_SWITCH_ON_DISABLED, now_ns);
    } else if (axis->state == AXIS_FAULT_REACTION) {
        enter(axis, AXIS_FAULT, now_ns);
    }
}

void axis_flag(axis_t* const axis, const uint16_t flag, const bool on)
{
    axis->flags = (uint16_t)(on ? (axis->flags | flag) : (axis->flags & (uint16_t)~flag));
    update_statusword(axis);
}

void axis_set_error(axis_t* const axis, const uint16_t code, const bool is_present, const uint64_t now_ns)
{
    static const uint16_t faults[]   = {EMERGENCY_OVER_CURRENT, EMERGENCY_UNDER_VOLTAGE,
                                        EMERGENCY_POSITION_SENSOR, EMERGENCY_TORQUE_SENSOR};
    static const uint16_t warnings[] = {EMERGENCY_EXCESS_TORQUE, EMERGENCY_DEVICE_TEMPERATURE,
                                        EMERGENCY_DRIVE_TEMPERATURE};
    bool is_fault                    = false;
    bool has_warning                 = false;
    if (is_present) {
        node_raise(axis->node, code, 0U, 0, now_ns);
    } else {
        node_clear(axis->node, code, 0U, now_ns);
    }
    axis->has_fault = false;
    for (unsigned i = 0U; i < (sizeof faults / sizeof faults[0]); i++) {
        axis->has_fault = axis->has_fault || node_has_error(axis->node, faults[i], 0U);
        is_fault        = is_fault || (code == faults[i]);
    }
    for (unsigned i = 0U; i < (sizeof warnings / sizeof warnings[0]); i++) {
        has_warning = has_warning || node_has_error(axis->node, warnings[i], 0U);
    }
    axis_flag(axis, AXIS_STATUS_WARNING, has_warning);
    if (is_present && is_fault) {
        axis_fault(axis, code, now_ns);
    }
}
