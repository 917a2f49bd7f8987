// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/joystick.h"

#include "sim/devices/rounding.h"

#include <stdio.h>
#include <stdlib.h>

#define MNM 1e-3
#define PER_MILLE 1000.0
#define STOP_NS 1000000U // In quick stop the torque is off at once; the state changes after this time.
#define BUTTON_SHIFT 16U
#define BUTTON_MASK 3U

typedef struct {
    axis_t machine;
    object_t* target_torque;
    object_t* torque_offset;
    object_t* max_torque;
    object_t* positive_limit;
    object_t* negative_limit;
    object_t* rated_torque;
    object_t* position;
    object_t* velocity;
    object_t* torque;
    object_t* torque_demand;
    object_t* current;
    double position_unit; // [rad]
    double velocity_unit; // [rad/s]
    double torque_unit_nm;
    double torque_nm; // Commanded torque, within the limits.
    bool is_limited;
    bool is_stopping;
    uint64_t stop_ns; // End of the quick stop.
} stick_axis_t;

struct joystick {
    node_t* node;
    joystick_config_t config;
    object_t* inputs;
    stick_axis_t axis[JOYSTICK_AXES];
};

static void refresh_torque(stick_axis_t* const axis)
{
    const int64_t maximum  = (int64_t)axis->max_torque->value;
    const int64_t positive = (int64_t)axis->positive_limit->value;
    const int64_t negative = (int64_t)axis->negative_limit->value;
    const int64_t upper    = (positive < maximum) ? positive : maximum;
    const int64_t lower    = -((negative < maximum) ? negative : maximum);
    int64_t wanted         = object_signed(axis->target_torque) + object_signed(axis->torque_offset);
    axis->is_limited       = (wanted > upper) || (wanted < lower);
    if (axis->is_limited) {
        wanted = (wanted > upper) ? upper : lower;
    }
    axis->torque_unit_nm = (double)axis->rated_torque->value * MNM / PER_MILLE;
    axis->torque_nm      = (double)wanted * axis->torque_unit_nm;
    if (axis->machine.state == AXIS_ENABLED) {
        axis_flag(&axis->machine, AXIS_STATUS_INTERNAL_LIMIT, axis->is_limited);
    }
}

static void on_written(void* const context, const object_t* const object, const uint64_t now_ns)
{
    joystick_t* joystick = context;
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        stick_axis_t* axis = &joystick->axis[i];
        if (object == axis->machine.controlword) {
            if (axis_command(&axis->machine, now_ns) && (axis->machine.state == AXIS_ENABLED)) {
                axis_flag(&axis->machine, AXIS_STATUS_FOLLOWS, true);
            }
        } else if (object == axis->machine.mode) {
            (void)axis_select_mode(&axis->machine);
        } else if ((object == axis->target_torque) || (object == axis->torque_offset) ||
                   (object == axis->max_torque) || (object == axis->positive_limit) ||
                   (object == axis->negative_limit)) {
            refresh_torque(axis);
        }
    }
}

static double motor_torque(const stick_axis_t* const axis)
{
    return (axis->machine.state == AXIS_ENABLED) ? axis->torque_nm : 0.0;
}

static void on_sample(void* const context, const uint64_t now_ns)
{
    joystick_t* joystick = context;
    joystick_truth_t truth;
    (void)now_ns;
    joystick->config.read_truth(joystick->config.truth_context, &truth);
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        stick_axis_t* axis    = &joystick->axis[i];
        const double measured = encoder_read(&joystick->config.encoder, truth.position_rad[i]);
        const int64_t torque  = rounded(motor_torque(axis) / axis->torque_unit_nm);
        object_set(axis->position, rounded(measured / axis->position_unit));
        object_set(axis->velocity, rounded(truth.velocity_rad_s[i] / axis->velocity_unit));
        object_set(axis->torque, torque);
        object_set(axis->torque_demand, torque);
        object_set(axis->current, torque);
    }
    joystick->inputs->value = (uint64_t)(truth.buttons & BUTTON_MASK) << BUTTON_SHIFT;
}

static uint32_t on_check(void* const context, const object_t* const object, const int64_t value)
{
    const joystick_t* joystick = context;
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        if (object == joystick->axis[i].machine.mode) {
            return axis_check_mode(&joystick->axis[i].machine, value);
        }
    }
    return 0U;
}

static void on_connection_lost(void* const context, const uint64_t now_ns)
{
    joystick_t* joystick = context;
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        axis_connection_lost(&joystick->axis[i].machine, now_ns);
    }
}

static void on_reset(void* const context, const uint64_t now_ns)
{
    joystick_t* joystick = context;
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        refresh_torque(&joystick->axis[i]);
        joystick->axis[i].is_stopping = false;
        axis_reset(&joystick->axis[i].machine, now_ns);
    }
}

// ---- Plant side ----

void joystick_torque(const joystick_t* const joystick, double out_torque_nm[JOYSTICK_AXES])
{
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        out_torque_nm[i] = motor_torque(&joystick->axis[i]);
    }
}

void joystick_end_step(joystick_t* const joystick, const uint64_t now_ns)
{
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        stick_axis_t* axis = &joystick->axis[i];
        const bool is_stopping =
            axis_function_is_enabled(axis->machine.state) && (axis->machine.state != AXIS_ENABLED);
        if (is_stopping && !axis->is_stopping) {
            axis->stop_ns = now_ns + STOP_NS;
        } else if (is_stopping && (now_ns >= axis->stop_ns)) {
            axis_ramp_done(&axis->machine, now_ns);
        }
        axis->is_stopping = is_stopping;
    }
}

uint16_t joystick_statusword(const joystick_t* const joystick, const unsigned axis)
{
    return (uint16_t)joystick->axis[axis].machine.statusword->value;
}

static bool is_warning(const uint16_t code)
{
    return (code == EMERGENCY_EXCESS_TORQUE) || (code == EMERGENCY_DEVICE_TEMPERATURE) ||
           (code == EMERGENCY_DRIVE_TEMPERATURE);
}

static bool is_fault(const uint16_t code)
{
    return (code == EMERGENCY_OVER_CURRENT) || (code == EMERGENCY_UNDER_VOLTAGE) ||
           (code == EMERGENCY_POSITION_SENSOR) || (code == EMERGENCY_TORQUE_SENSOR);
}

void joystick_set_error(joystick_t* const joystick, const uint16_t code, const bool is_present,
                        const uint64_t now_ns)
{
    if (is_present) {
        node_raise(joystick->node, code, 0U, 0, now_ns);
    } else {
        node_clear(joystick->node, code, 0U, now_ns);
    }
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        axis_t* machine = &joystick->axis[i].machine;
        if (is_warning(code)) {
            axis_flag(machine, AXIS_STATUS_WARNING, is_present);
        }
        if (is_fault(code)) {
            machine->has_fault = is_present;
            if (is_present) {
                axis_fault(machine, code, now_ns);
            }
        }
    }
}

// ---- Creation ----

static bool find_axis(joystick_t* const joystick, const unsigned number)
{
    stick_axis_t* axis    = &joystick->axis[number];
    const uint16_t offset = (uint16_t)(number * AXIS_STRIDE);
    const struct {
        object_t** object;
        uint16_t index;
    } wanted[] = {
        {&axis->target_torque, 0x6071U},  {&axis->torque_offset, 0x60B2U},  {&axis->max_torque, 0x6072U},
        {&axis->positive_limit, 0x60E0U}, {&axis->negative_limit, 0x60E1U}, {&axis->rated_torque, 0x6076U},
        {&axis->position, 0x6064U},       {&axis->velocity, 0x606CU},       {&axis->torque, 0x6077U},
        {&axis->torque_demand, 0x6074U},  {&axis->current, 0x6078U},
    };
    for (size_t i = 0U; i < (sizeof wanted / sizeof wanted[0]); i++) {
        *wanted[i].object = node_object(joystick->node, (uint16_t)(wanted[i].index + offset), 0U);
        if (*wanted[i].object == NULL) {
            return false;
        }
    }
    return axis_units(joystick->node, (uint8_t)number, &axis->position_unit, &axis->velocity_unit) &&
           axis_init(&axis->machine, joystick->node, (uint8_t)number);
}

static bool find_objects(void* const context)
{
    joystick_t* joystick = context;
    joystick->inputs     = node_object(joystick->node, 0x60FDU, 0U);
    return (joystick->inputs != NULL) && find_axis(joystick, 0U) && find_axis(joystick, 1U);
}

status_t joystick_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                         const joystick_config_t* const config, joystick_t** const out_joystick,
                         char error[EDS_ERROR_MAX])
{
    *out_joystick        = NULL;
    joystick_t* joystick = calloc(1U, sizeof *joystick);
    if (joystick == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    const node_application_t application = {.name            = "a two-axis joystick",
                                            .find            = find_objects,
                                            .sample          = on_sample,
                                            .written         = on_written,
                                            .check           = on_check,
                                            .connection_lost = on_connection_lost,
                                            .reset           = on_reset,
                                            .context         = joystick};
    joystick->config                     = *config;
    const status_t status = node_create(bus, eds_path, id, &application, &joystick->node, error);
    if (status != STATUS_OK) {
        free(joystick);
        return status;
    }
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        axis_observe(&joystick->axis[i].machine, config->observer, config->observer_context);
        refresh_torque(&joystick->axis[i]);
    }
    *out_joystick = joystick;
    return STATUS_OK;
}

void joystick_destroy(joystick_t* const joystick)
{
    if (joystick != NULL) {
        node_destroy(joystick->node);
        free(joystick);
    }
}

node_t* joystick_node(joystick_t* const joystick)
{
    return joystick->node;
}
