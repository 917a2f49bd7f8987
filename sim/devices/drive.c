// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/drive.h"

#include "sim/devices/homing.h"
#include "sim/devices/rounding.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define POSITION_GAIN 4000.0 // Gains of a drive whose data sheet gives none [Nm/rad], [Nms/rad].
#define VELOCITY_GAIN 60.0
#define MNM 1e-3
#define PER_MILLE 1000.0
#define STANDSTILL_RAD_S 0.02    // Below this speed of the motor a ramp has ended.
#define RAMP_LIMIT_NS 200000000U // After this time the brake is applied even if the motor still moves.
#define HOT_CELSIUS 80.0         // From this temperature EMCY 0x4310 is present.
#define COOL_CELSIUS 75.0        // Below this temperature the error has ended.
#define TENTH 0.1                // Unit of temperature objects [degC].

typedef struct {
    object_t* target_position;
    object_t* target_torque;
    object_t* target_velocity;
    object_t* velocity_offset;
    object_t* torque_offset;
    object_t* max_torque;
    object_t* positive_limit;
    object_t* negative_limit;
    object_t* low_position;
    object_t* high_position;
    object_t* position_gain;
    object_t* velocity_gain;
    object_t* stop_deceleration;
    object_t* period_value;
    object_t* period_exponent;
    object_t* window;
    object_t* window_time;
    object_t* position;
    object_t* velocity;
    object_t* torque;
    object_t* current;
    object_t* position_demand;
    object_t* velocity_demand;
    object_t* torque_demand;
    object_t* following_error;
    object_t* temperature;
    object_t* brake;
    object_t* rated_torque;
} drive_objects_t;

/// Values of the objects in SI units. They are updated when an object is written, so that the regulator only
/// multiplies and adds.
typedef struct {
    double torque_unit_nm;
    double target_nm;
    double offset_nm;
    double target_rad_s;
    double position_gain;
    double velocity_gain;
    double upper_nm;
    double lower_nm;
    double low_rad;
    double high_rad;
    double deceleration_rad_s2;
    uint32_t period_substeps;
} drive_settings_t;

struct drive {
    node_t* node;
    axis_t axis;
    drive_config_t config;
    torque_sensor_t sensor;
    double extra_offset_nm;
    drive_objects_t objects;
    double position_unit; // One unit of its position objects [rad].
    double velocity_unit; // [rad/s]
    drive_settings_t settings;
    homing_t homing;
    double zero_rad; // Position of the motor at which the drive reports zero.

    // Regulator.
    double position_rad; // Last reading of the position of the motor, from its zero.
    double velocity_rad_s;
    double torque_nm; // Last commanded torque.
    double from_rad;  // Interpolation between two targets.
    double to_rad;
    uint32_t substep;
    double reference_rad;
    double reference_rad_s;
    double ramp_start_nm; // Torque at the beginning of a ramp.
    bool is_ramping;
    bool is_at_rest;
    bool is_limited;
    bool is_clamped; // Target outside the software limits.
    uint64_t ramp_ns;
    // Time since which the following error is outside its window; UINT64_MAX: inside.
    uint64_t error_since_ns;
};

static int64_t clamped(const double value, const double limit)
{
    return rounded((value > limit) ? limit : ((value < -limit) ? -limit : value));
}

static void refresh_velocity(drive_t* const drive)
{
    const int64_t wanted =
        object_signed(drive->objects.target_velocity) + object_signed(drive->objects.velocity_offset);
    drive->settings.target_rad_s = (double)wanted * drive->velocity_unit;
}

static void refresh_settings(drive_t* const drive)
{
    const drive_objects_t* objects = &drive->objects;
    drive_settings_t* settings     = &drive->settings;
    const double unit              = (double)objects->rated_torque->value * MNM / PER_MILLE;
    const double maximum           = (double)objects->max_torque->value;
    const double positive          = (double)objects->positive_limit->value;
    const double negative          = (double)objects->negative_limit->value;
    settings->torque_unit_nm       = unit;
    settings->target_nm            = (double)object_signed(objects->target_torque) * unit;
    settings->offset_nm            = (double)object_signed(objects->torque_offset) * unit;
    const bool has_gains           = (objects->position_gain != NULL) && (objects->velocity_gain != NULL);
    settings->position_gain        = has_gains ? (double)objects->position_gain->value : POSITION_GAIN;
    settings->velocity_gain = has_gains ? ((double)objects->velocity_gain->value * MNM) : VELOCITY_GAIN;
    const double most =
        (drive->config.torque_limit_nm > 0.0) ? drive->config.torque_limit_nm : (unit * maximum);
    settings->upper_nm            = fmin(unit * ((positive < maximum) ? positive : maximum), most);
    settings->lower_nm            = -fmin(unit * ((negative < maximum) ? negative : maximum), most);
    settings->low_rad             = (double)object_signed(objects->low_position) * drive->position_unit;
    settings->high_rad            = (double)object_signed(objects->high_position) * drive->position_unit;
    settings->deceleration_rad_s2 = (double)objects->stop_deceleration->value * drive->velocity_unit;

    refresh_velocity(drive);

    double period_ns = (double)objects->period_value->value * 1e9;
    for (int64_t i = object_signed(objects->period_exponent); i < 0; i++) {
        period_ns /= 10.0;
    }
    const int64_t substeps    = rounded(period_ns / (double)drive->config.substep_ns);
    settings->period_substeps = (substeps > 1) ? (uint32_t)substeps : 1U;
}

static void read_truth(drive_t* const drive, drive_truth_t* const out_truth)
{
    drive->config.read_truth(drive->config.truth_context, out_truth);
    out_truth->motor_position_rad -= drive->zero_rad;
    drive->position_rad   = out_truth->motor_position_rad;
    drive->velocity_rad_s = out_truth->motor_velocity_rad_s;
}

/// Make the present position of the motor the reference, until a command arrives.
static void hold_here(drive_t* const drive)
{
    drive->from_rad        = drive->position_rad;
    drive->to_rad          = drive->position_rad;
    drive->reference_rad   = drive->position_rad;
    drive->reference_rad_s = 0.0;
    drive->substep         = drive->settings.period_substeps;
    drive->error_since_ns  = UINT64_MAX;
    drive->is_clamped      = false;
}

static void take_target(drive_t* const drive)
{
    const drive_settings_t* settings = &drive->settings;
    double target_rad = (double)object_signed(drive->objects.target_position) * drive->position_unit;
    drive->is_clamped = (target_rad < settings->low_rad) || (target_rad > settings->high_rad);
    if (drive->is_clamped) {
        target_rad = (target_rad < settings->low_rad) ? settings->low_rad : settings->high_rad;
    }
    drive->from_rad = drive->reference_rad;
    drive->to_rad   = target_rad;
    drive->substep  = 0U;
}

static bool is_homing(const drive_t* const drive)
{
    return (drive->axis.state == AXIS_ENABLED) && (axis_mode(&drive->axis) == AXIS_MODE_HOMING);
}

static void change_state(drive_t* const drive, const uint64_t now_ns)
{
    const axis_state_t before = drive->axis.state;
    if (!axis_command(&drive->axis, now_ns)) {
        return;
    }
    homing_reset(&drive->homing);
    if (drive->axis.state == AXIS_ENABLED) {
        drive_truth_t truth;
        read_truth(drive, &truth);
        hold_here(drive);
        axis_flag(&drive->axis, AXIS_STATUS_FOLLOWS, !is_homing(drive));
    }
    if (before == AXIS_FAULT) {
        node_clear(drive->node, EMERGENCY_FOLLOWING_ERROR, 0U, now_ns);
    }
}

static void execute_controlword(drive_t* const drive, const uint64_t now_ns)
{
    change_state(drive, now_ns);
    if (is_homing(drive)) {
        homing_command(&drive->homing, (uint16_t)drive->axis.controlword->value);
        homing_update_statusword(&drive->homing, &drive->axis);
    }
}

/// Start another mode at the present position of the axis.
static void select_mode(drive_t* const drive)
{
    if (!axis_select_mode(&drive->axis)) {
        return;
    }
    hold_here(drive);
    homing_reset(&drive->homing);
    if (drive->axis.state == AXIS_ENABLED) {
        axis_flag(&drive->axis, AXIS_STATUS_TARGET_REACHED | AXIS_STATUS_HOMING_ERROR, false);
        axis_flag(&drive->axis, AXIS_STATUS_FOLLOWS, !is_homing(drive));
    }
}

static void on_written(void* const context, const object_t* const object, const uint64_t now_ns)
{
    drive_t* drive = context;
    if (object == drive->axis.controlword) {
        execute_controlword(drive, now_ns);
    } else if (object == drive->objects.target_position) {
        if ((drive->axis.state == AXIS_ENABLED) && (axis_mode(&drive->axis) == AXIS_MODE_CSP)) {
            take_target(drive);
        }
    } else if (object == drive->objects.torque_offset) {
        drive->settings.offset_nm = (double)object_signed(object) * drive->settings.torque_unit_nm;
    } else if (object == drive->objects.target_torque) {
        drive->settings.target_nm = (double)object_signed(object) * drive->settings.torque_unit_nm;
    } else if (object == drive->objects.target_velocity) {
        refresh_velocity(drive);
    } else if (object == drive->axis.mode) {
        select_mode(drive);
    } else {
        refresh_settings(drive);
    }
}

static bool has_torque_sensor(const drive_t* const drive)
{
    return drive->config.torque_sensor.range_nm > 0.0;
}

/// Reading of the torque sensor. Without a sensor: the torque of the motor, which the drive measures by its
/// current.
static double measured_nm(const drive_t* const drive, const drive_truth_t* const truth, const uint64_t now_ns)
{
    const double position_rad = truth->motor_position_rad + drive->zero_rad;
    const double torque_nm    = has_torque_sensor(drive)
                                    ? torque_sensor_read(&drive->sensor, now_ns / drive->config.step_ns, now_ns,
                                                         truth->joint_torque_nm, position_rad)
                                    : drive->torque_nm;
    return torque_nm + drive->extra_offset_nm;
}

static void on_sample(void* const context, const uint64_t now_ns)
{
    drive_t* drive                 = context;
    const drive_objects_t* objects = &drive->objects;
    const double unit              = drive->settings.torque_unit_nm;
    drive_truth_t truth;
    read_truth(drive, &truth);
    if (!axis_function_is_enabled(drive->axis.state)) {
        hold_here(drive); // While the motor is not controlled, the target follows the actual position.
    }
    if (objects->torque != NULL) {
        object_set(objects->torque, clamped(measured_nm(drive, &truth, now_ns) / unit, INT16_MAX));
    }
    const double measured_rad = encoder_read(&drive->config.encoder, truth.motor_position_rad);
    object_set(objects->position, rounded(measured_rad / drive->position_unit));
    object_set(objects->velocity, clamped(truth.motor_velocity_rad_s / drive->velocity_unit, INT32_MAX));
    object_set(objects->current, clamped(drive->torque_nm / unit, INT16_MAX));
    object_set(objects->torque_demand, clamped(drive->torque_nm / unit, INT16_MAX));
    object_set(objects->position_demand, rounded(drive->reference_rad / drive->position_unit));
    object_set(objects->velocity_demand, rounded(drive->reference_rad_s / drive->velocity_unit));
    object_set(objects->following_error,
               rounded((drive->reference_rad - measured_rad) / drive->position_unit));
    if (objects->brake != NULL) {
        objects->brake->value = axis_function_is_enabled(drive->axis.state) ? 0U : 1U;
    }
}

static uint32_t on_check(void* const context, const object_t* const object, const int64_t value)
{
    const drive_t* drive = context;
    return (object == drive->axis.mode) ? axis_check_mode(&drive->axis, value) : 0U;
}

static void on_connection_lost(void* const context, const uint64_t now_ns)
{
    drive_t* drive = context;
    axis_connection_lost(&drive->axis, now_ns);
}

static void on_reset(void* const context, const uint64_t now_ns)
{
    drive_t* drive    = context;
    drive->torque_nm  = 0.0;
    drive->is_ramping = false;
    drive->zero_rad   = 0.0; // The encoder is absolute: its zero is known.
    homing_reset(&drive->homing);
    refresh_settings(drive);
    hold_here(drive);
    axis_reset(&drive->axis, now_ns);
}

// ---- Plant side ----

/// Update the reference of a stop: the speed decreases to zero, and the position is its integral.
static void run_ramp(drive_t* const drive)
{
    const double dt_s      = (double)drive->config.substep_ns * 1e-9;
    const double step      = drive->settings.deceleration_rad_s2 * dt_s;
    double speed           = drive->reference_rad_s;
    speed                  = (speed > step) ? (speed - step) : ((speed < -step) ? (speed + step) : 0.0);
    drive->reference_rad_s = speed;
    drive->reference_rad += speed * dt_s;
    drive->ramp_ns += drive->config.substep_ns;
    drive->is_at_rest = ((speed == 0.0) && (fabs(drive->velocity_rad_s) < STANDSTILL_RAD_S)) ||
                        (drive->ramp_ns >= RAMP_LIMIT_NS);
}

static void begin_ramp(drive_t* const drive)
{
    drive->is_ramping      = true;
    drive->is_at_rest      = false;
    drive->ramp_ns         = 0U;
    drive->ramp_start_nm   = drive->torque_nm;
    drive->reference_rad   = drive->position_rad;
    drive->reference_rad_s = drive->velocity_rad_s;
}

static void interpolate(drive_t* const drive)
{
    const uint32_t count = drive->settings.period_substeps;
    if (drive->substep >= count) {
        drive->reference_rad   = drive->to_rad;
        drive->reference_rad_s = 0.0;
        return;
    }
    drive->substep++;
    const double distance_rad = drive->to_rad - drive->from_rad;
    drive->reference_rad      = drive->from_rad + (distance_rad * ((double)drive->substep / (double)count));
    drive->reference_rad_s    = distance_rad / ((double)count * (double)drive->config.substep_ns * 1e-9);
}

static double position_loop(const drive_t* const drive, const double forward_nm)
{
    return forward_nm + (drive->settings.position_gain * (drive->reference_rad - drive->position_rad)) +
           (drive->settings.velocity_gain * (drive->reference_rad_s - drive->velocity_rad_s));
}

static double wanted_torque(drive_t* const drive)
{
    const drive_settings_t* settings = &drive->settings;
    if (drive->axis.state != AXIS_ENABLED) {
        if (!drive->is_ramping) {
            begin_ramp(drive);
        }
        run_ramp(drive);
        return position_loop(drive, drive->ramp_start_nm);
    }
    drive->is_ramping = false;
    switch (axis_mode(&drive->axis)) {
    case AXIS_MODE_CSP:
        interpolate(drive);
        return position_loop(drive, settings->offset_nm);
    case AXIS_MODE_HOMING:
        drive->reference_rad_s = homing_advance(&drive->homing, (double)drive->config.substep_ns * 1e-9);
        drive->reference_rad += drive->reference_rad_s * (double)drive->config.substep_ns * 1e-9;
        return position_loop(drive, settings->offset_nm);
    case AXIS_MODE_CSV:
        drive->reference_rad   = drive->position_rad;
        drive->reference_rad_s = settings->target_rad_s;
        return settings->offset_nm +
               (settings->velocity_gain * (settings->target_rad_s - drive->velocity_rad_s));
    case AXIS_MODE_CST:
        drive->reference_rad   = drive->position_rad;
        drive->reference_rad_s = drive->velocity_rad_s;
        return settings->target_nm + settings->offset_nm;
    default:
        return 0.0;
    }
}

double drive_regulate(drive_t* const drive, const double position_rad, const double velocity_rad_s)
{
    drive->position_rad   = position_rad - drive->zero_rad;
    drive->velocity_rad_s = velocity_rad_s;
    if (!axis_function_is_enabled(drive->axis.state)) {
        drive->is_ramping = false;
        drive->torque_nm  = 0.0;
        return 0.0;
    }
    double torque_nm = wanted_torque(drive);
    if (torque_nm > drive->settings.upper_nm) {
        torque_nm         = drive->settings.upper_nm;
        drive->is_limited = true;
    } else if (torque_nm < drive->settings.lower_nm) {
        torque_nm         = drive->settings.lower_nm;
        drive->is_limited = true;
    }
    drive->torque_nm = torque_nm;
    return torque_nm;
}

static void watch_following_error(drive_t* const drive, const uint64_t now_ns)
{
    const double error_rad = fabs(drive->reference_rad - drive->position_rad);
    const bool is_outside  = (axis_mode(&drive->axis) == AXIS_MODE_CSP) &&
                            (error_rad > ((double)drive->objects.window->value * drive->position_unit));
    if (!is_outside) {
        drive->error_since_ns = UINT64_MAX;
    } else if (drive->error_since_ns == UINT64_MAX) {
        drive->error_since_ns = now_ns;
    }
    axis_flag(&drive->axis, AXIS_STATUS_FOLLOWING_ERROR, is_outside);
    const uint64_t allowed_ns = drive->objects.window_time->value * 1000000U;
    if (is_outside && ((now_ns - drive->error_since_ns) >= allowed_ns)) {
        node_raise(drive->node, EMERGENCY_FOLLOWING_ERROR, 0U,
                   (int32_t)rounded(error_rad / drive->position_unit), now_ns);
        axis_fault(&drive->axis, EMERGENCY_FOLLOWING_ERROR, now_ns);
    }
}

/// When homing has found the reference, set the zero of the axis and hold the present position.
static void end_homing_step(drive_t* const drive)
{
    if (homing_end_step(&drive->homing, drive->is_limited, drive->config.step_ns)) {
        drive_truth_t truth;
        drive->zero_rad += drive->position_rad - homing_position_rad(&drive->homing);
        read_truth(drive, &truth);
        hold_here(drive);
    }
    homing_update_statusword(&drive->homing, &drive->axis);
}

void drive_end_step(drive_t* const drive, const uint64_t now_ns)
{
    if (is_homing(drive)) {
        end_homing_step(drive);
    }
    if (drive->axis.state == AXIS_ENABLED) {
        axis_flag(&drive->axis, AXIS_STATUS_INTERNAL_LIMIT, drive->is_limited || drive->is_clamped);
        watch_following_error(drive, now_ns);
    } else if (drive->is_ramping && drive->is_at_rest) {
        drive->is_ramping = false;
        axis_ramp_done(&drive->axis, now_ns);
    }
    drive->is_limited = false;
}

bool drive_brake_is_engaged(const drive_t* const drive)
{
    return !axis_function_is_enabled(drive->axis.state);
}

uint16_t drive_statusword(const drive_t* const drive)
{
    return (uint16_t)drive->axis.statusword->value;
}

// ---- Faults set by a scenario ----

void drive_set_torque_offset(drive_t* const drive, const double offset_nm)
{
    drive->extra_offset_nm = offset_nm;
}

void drive_set_error(drive_t* const drive, const uint16_t code, const bool is_present, const uint64_t now_ns)
{
    axis_set_error(&drive->axis, code, is_present, now_ns);
}

void drive_set_temperature(drive_t* const drive, const double celsius, const uint64_t now_ns)
{
    if (drive->objects.temperature != NULL) {
        object_set(drive->objects.temperature, clamped(celsius / TENTH, INT16_MAX));
    }
    if (celsius >= HOT_CELSIUS) {
        drive_set_error(drive, EMERGENCY_DRIVE_TEMPERATURE, true, now_ns);
    } else if (celsius < COOL_CELSIUS) {
        drive_set_error(drive, EMERGENCY_DRIVE_TEMPERATURE, false, now_ns);
    }
}

// ---- Creation ----

static bool find_objects(void* const context)
{
    drive_t* drive           = context;
    drive_objects_t* objects = &drive->objects;
    const struct {
        object_t** object;
        uint16_t index;
        uint8_t subindex;
    } wanted[] = {
        {&objects->target_position, 0x607AU, 0U},   {&objects->target_torque, 0x6071U, 0U},
        {&objects->target_velocity, 0x60FFU, 0U},   {&objects->velocity_offset, 0x60B1U, 0U},
        {&objects->torque_offset, 0x60B2U, 0U},     {&objects->max_torque, 0x6072U, 0U},
        {&objects->positive_limit, 0x60E0U, 0U},    {&objects->negative_limit, 0x60E1U, 0U},
        {&objects->low_position, 0x607DU, 1U},      {&objects->high_position, 0x607DU, 2U},
        {&objects->stop_deceleration, 0x6085U, 0U}, {&objects->period_value, 0x60C2U, 1U},
        {&objects->period_exponent, 0x60C2U, 2U},   {&objects->window, 0x6065U, 0U},
        {&objects->window_time, 0x6066U, 0U},       {&objects->position, 0x6064U, 0U},
        {&objects->velocity, 0x606CU, 0U},          {&objects->torque, 0x6077U, 0U},
        {&objects->current, 0x6078U, 0U},           {&objects->position_demand, 0x6062U, 0U},
        {&objects->velocity_demand, 0x606BU, 0U},   {&objects->torque_demand, 0x6074U, 0U},
        {&objects->following_error, 0x60F4U, 0U},   {&objects->rated_torque, 0x6076U, 0U},
    };
    for (size_t i = 0U; i < (sizeof wanted / sizeof wanted[0]); i++) {
        *wanted[i].object = node_object(drive->node, wanted[i].index, wanted[i].subindex);
        // A drive without a torque sensor need not have the object of the torque.
        const bool is_optional = (wanted[i].object == &objects->torque) && !has_torque_sensor(drive);
        if ((*wanted[i].object == NULL) && !is_optional) {
            return false;
        }
    }
    // Drives of other manufacturers need not have these objects.
    objects->position_gain = node_object_named(drive->node, "Regulator gains", 1U);
    objects->velocity_gain = node_object_named(drive->node, "Regulator gains", 2U);
    objects->temperature   = node_object_named(drive->node, "Drive temperature", 0U);
    objects->brake         = node_object_named(drive->node, "Holding brake state", 0U);
    return axis_units(drive->node, 0U, &drive->position_unit, &drive->velocity_unit) &&
           axis_init(&drive->axis, drive->node, 0U) &&
           homing_init(&drive->homing, &drive->axis, drive->position_unit, drive->velocity_unit);
}

status_t drive_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                      const drive_config_t* const config, drive_t** const out_drive,
                      char error[EDS_ERROR_MAX])
{
    *out_drive     = NULL;
    drive_t* drive = calloc(1U, sizeof *drive);
    if (drive == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    const node_application_t application = {.name            = "a joint drive",
                                            .find            = find_objects,
                                            .sample          = on_sample,
                                            .written         = on_written,
                                            .check           = on_check,
                                            .connection_lost = on_connection_lost,
                                            .reset           = on_reset,
                                            .context         = drive};
    drive->config                        = *config;
    const status_t status                = node_create(bus, eds_path, id, &application, &drive->node, error);
    if (status != STATUS_OK) {
        free(drive);
        return status;
    }
    torque_sensor_init(&drive->sensor, &config->torque_sensor, config->seed, config->sensor_device);
    axis_observe(&drive->axis, config->observer, config->observer_context);
    refresh_settings(drive);
    *out_drive = drive;
    return STATUS_OK;
}

void drive_destroy(drive_t* const drive)
{
    if (drive != NULL) {
        node_destroy(drive->node);
        free(drive);
    }
}

node_t* drive_node(drive_t* const drive)
{
    return drive->node;
}
