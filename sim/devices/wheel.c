// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/wheel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MNM 1e-3
#define PER_MILLE 1000.0
#define RAD_S_PER_RPM (2.0 * 3.14159265358979323846 / 60.0)
#define SPEED_LOOP_S 0.1 // CSV: time constant of the speed, if the torque is sufficient.
#define STOP_NS 1000000U // Time in quick stop or fault reaction; the torque is off at once.

struct wheel {
    node_t* node;
    axis_t axis;
    wheel_config_t config;
    object_t* target_torque;
    object_t* torque_offset;
    object_t* max_torque;
    object_t* rated_torque;
    object_t* torque;
    object_t* torque_demand;
    object_t* target_velocity;
    object_t* velocity;
    object_t* max_speed;
    double velocity_unit; // [rad/s]
    double torque_unit_nm;
    double inertia_kgm2;
    double commanded_nm; // Torque of the last step, before the limits.
    bool is_stopping;
    uint64_t stop_ns; // End of the quick stop.
};

static int64_t clamped(const double value, const double limit)
{
    return (int64_t)llround(fmax(-limit, fmin(limit, value)));
}

/// Speed of the rotor relative to its housing.
static double speed(const wheel_t* const wheel, wheel_truth_t* const out_truth)
{
    wheel->config.read_truth(wheel->config.truth_context, out_truth);
    return out_truth->momentum_nms / wheel->inertia_kgm2 - out_truth->housing_rad_s;
}

/// Returns the torque for the present mode, before the limits.
static double wanted_torque(const wheel_t* const wheel)
{
    wheel_truth_t truth;
    const double offset = (double)object_signed(wheel->torque_offset) * wheel->torque_unit_nm;
    if (axis_mode(&wheel->axis) == AXIS_MODE_CSV) {
        const double wanted = (double)object_signed(wheel->target_velocity) * wheel->velocity_unit;
        return offset + (wanted - speed(wheel, &truth)) * wheel->inertia_kgm2 / SPEED_LOOP_S;
    }
    return offset + (double)object_signed(wheel->target_torque) * wheel->torque_unit_nm;
}

double wheel_torque(wheel_t* const wheel)
{
    const double limit  = (double)wheel->max_torque->value * wheel->torque_unit_nm;
    wheel->commanded_nm = (wheel->axis.state == AXIS_ENABLED) ? wanted_torque(wheel) : 0.0;
    return fmax(-limit, fmin(limit, wheel->commanded_nm));
}

static void on_sample(void* const context, const uint64_t now_ns)
{
    wheel_t* wheel = context;
    wheel_truth_t truth;
    (void)now_ns;
    object_set(wheel->velocity, clamped(speed(wheel, &truth) / wheel->velocity_unit, INT32_MAX));
    object_set(wheel->torque, clamped(truth.torque_nm / wheel->torque_unit_nm, INT16_MAX));
    object_set(wheel->torque_demand, clamped(wheel->commanded_nm / wheel->torque_unit_nm, INT16_MAX));
}

static void on_written(void* const context, const object_t* const object, const uint64_t now_ns)
{
    wheel_t* wheel = context;
    if (object == wheel->axis.controlword) {
        if (axis_command(&wheel->axis, now_ns) && (wheel->axis.state == AXIS_ENABLED)) {
            axis_flag(&wheel->axis, AXIS_STATUS_FOLLOWS, true);
        }
    } else if (object == wheel->axis.mode) {
        (void)axis_select_mode(&wheel->axis);
    } else {
        // The next step reads targets and limits from their objects.
    }
}

static uint32_t on_check(void* const context, const object_t* const object, const int64_t value)
{
    const wheel_t* wheel = context;
    return (object == wheel->axis.mode) ? axis_check_mode(&wheel->axis, value) : 0U;
}

static void on_connection_lost(void* const context, const uint64_t now_ns)
{
    wheel_t* wheel = context;
    axis_connection_lost(&wheel->axis, now_ns);
}

static void on_reset(void* const context, const uint64_t now_ns)
{
    wheel_t* wheel      = context;
    wheel->is_stopping  = false;
    wheel->commanded_nm = 0.0;
    axis_reset(&wheel->axis, now_ns);
}

// ---- Plant side ----

void wheel_end_step(wheel_t* const wheel, const uint64_t now_ns)
{
    const bool is_stopping =
        axis_function_is_enabled(wheel->axis.state) && (wheel->axis.state != AXIS_ENABLED);
    wheel_truth_t truth;
    if (is_stopping && !wheel->is_stopping) {
        wheel->stop_ns = now_ns + STOP_NS;
    } else if (is_stopping && (now_ns >= wheel->stop_ns)) {
        axis_ramp_done(&wheel->axis, now_ns);
    } else if (wheel->axis.state == AXIS_ENABLED) {
        wheel->config.read_truth(wheel->config.truth_context, &truth);
        axis_flag(&wheel->axis, AXIS_STATUS_INTERNAL_LIMIT,
                  fabs(wheel->commanded_nm - truth.torque_nm) > (0.5 * wheel->torque_unit_nm));
    } else {
        // The wheel produces no torque: no limit is active.
    }
    wheel->is_stopping = is_stopping;
}

uint16_t wheel_statusword(const wheel_t* const wheel)
{
    return (uint16_t)wheel->axis.statusword->value;
}

void wheel_set_error(wheel_t* const wheel, const uint16_t code, const bool is_present, const uint64_t now_ns)
{
    axis_set_error(&wheel->axis, code, is_present, now_ns);
}

// ---- Creation ----

static bool find_objects(void* const context)
{
    wheel_t* wheel = context;
    const struct {
        object_t** object;
        uint16_t index;
    } wanted[] = {
        {&wheel->target_torque, 0x6071U},   {&wheel->torque_offset, 0x60B2U},
        {&wheel->max_torque, 0x6072U},      {&wheel->rated_torque, 0x6076U},
        {&wheel->torque, 0x6077U},          {&wheel->torque_demand, 0x6074U},
        {&wheel->target_velocity, 0x60FFU}, {&wheel->velocity, 0x606CU},
        {&wheel->max_speed, 0x6080U},
    };
    double position_unit = 0.0;
    for (size_t i = 0U; i < (sizeof wanted / sizeof wanted[0]); i++) {
        *wanted[i].object = node_object(wheel->node, wanted[i].index, 0U);
        if (*wanted[i].object == NULL) {
            return false;
        }
    }
    wheel->torque_unit_nm = (double)wheel->rated_torque->value * MNM / PER_MILLE;
    wheel->inertia_kgm2   = wheel->config.momentum_nms / ((double)wheel->max_speed->value * RAD_S_PER_RPM);
    return (wheel->rated_torque->value != 0U) && (wheel->max_speed->value != 0U) &&
           axis_units(wheel->node, 0U, &position_unit, &wheel->velocity_unit) &&
           axis_init(&wheel->axis, wheel->node, 0U);
}

status_t wheel_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                      const wheel_config_t* const config, wheel_t** const out_wheel,
                      char error[EDS_ERROR_MAX])
{
    *out_wheel     = NULL;
    wheel_t* wheel = calloc(1U, sizeof *wheel);
    if (wheel == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    const node_application_t application = {.name            = "a reaction wheel",
                                            .find            = find_objects,
                                            .sample          = on_sample,
                                            .written         = on_written,
                                            .check           = on_check,
                                            .connection_lost = on_connection_lost,
                                            .reset           = on_reset,
                                            .context         = wheel};
    wheel->config                        = *config;
    const status_t status                = node_create(bus, eds_path, id, &application, &wheel->node, error);
    if (status != STATUS_OK) {
        free(wheel);
        return status;
    }
    axis_observe(&wheel->axis, config->observer, config->observer_context);
    *out_wheel = wheel;
    return STATUS_OK;
}

void wheel_destroy(wheel_t* const wheel)
{
    if (wheel != NULL) {
        node_destroy(wheel->node);
        free(wheel);
    }
}

node_t* wheel_node(wheel_t* const wheel)
{
    return wheel->node;
}
