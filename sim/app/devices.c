// SPDX-License-Identifier: Apache-2.0
#include "sim/app/devices.h"

#include "sim/app/channels.h"
#include "sim/app/sensors.h"
#include "sim/devices/valve_box.h"
#include "sim/plant/parameters.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH_OCTETS 4096U
#define NS_PER_S 1.0e9

typedef struct device device_t;

/// Functions of a kind of device; each may be null.
typedef struct {
    void (*report)(const device_t* device, uint64_t now_ns);       // Report the state for the truth log.
    void (*act)(const device_t* device, plant_input_t* out_input); // Set inputs of the plant before its step.
    void (*end_step)(device_t* device, uint64_t now_ns, uint64_t end_ns); // Called after the plant's step.
} device_kind_t;

struct device {
    devices_t* devices;
    const world_device_t* entry;
    const device_kind_t* kind;
    device_model_t model; // The function that creates the device sets it.
    drive_t* drive;       // Null: the device is not a drive.
    joystick_t* joystick; // Null: the device is not a joystick.
    bool is_bench;
    double torque_limit_nm; // Largest torque of the motor of a drive; 0: the EDS defines it.
    unsigned joint; // Index of the joint, joystick or wheel in the plant, or of the valve box in the world.
    motor_bench_t bench;
    plant_drive_t bench_drive;
    sensor_t sensor;
};

struct devices {
    devices_config_t config;
    device_t device[DEVICES_MAX];
    size_t count;
};

// ---- Inputs and outputs of devices ----

static void read_drive_truth(void* const context, drive_truth_t* const out_truth)
{
    const device_t* device          = context;
    const plant_truth_t* truth      = device->devices->config.truth;
    const bool is_bench             = device->is_bench;
    const plant_rotor_t* rotor      = is_bench ? &device->bench.rotor : &truth->motor[device->joint];
    out_truth->motor_position_rad   = rotor->position_rad;
    out_truth->motor_velocity_rad_s = rotor->velocity_rad_s;
    out_truth->joint_torque_nm =
        is_bench ? device->bench.output_torque_nm : truth->joint_torque_nm[device->joint];
}

static void read_stick_truth(void* const context, joystick_truth_t* const out_truth)
{
    const device_t* device     = context;
    const plant_stick_t* stick = &device->devices->config.truth->stick[device->joint];
    out_truth->buttons         = 0U;
    memcpy(out_truth->position_rad, stick->position_rad, sizeof out_truth->position_rad);
    memcpy(out_truth->velocity_rad_s, stick->velocity_rad_s, sizeof out_truth->velocity_rad_s);
}

static void report(const device_t* const device, const uint64_t now_ns, const unsigned axis,
                   const uint16_t statusword, const bool brake)
{
    const devices_config_t* config = &device->devices->config;
    const truth_drive_t event      = {.bus           = config->world->bus[device->entry->bus],
                                      .node          = (uint8_t)device->entry->node,
                                      .axis          = (uint8_t)axis,
                                      .statusword    = statusword,
                                      .plugged       = node_is_plugged(device->model.node),
                                      .brake_engaged = brake};
    config->changed(config->context, now_ns, &event);
}

/// Report the state of a device that has no statusword.
static void report_without_statusword(const device_t* const device, const uint64_t now_ns)
{
    report(device, now_ns, 0U, 0U, false);
}

static void on_axis(void* const context, const uint8_t node, const unsigned axis, const uint16_t statusword,
                    const bool brake, const uint64_t now_ns)
{
    (void)node;
    report(context, now_ns, axis, statusword, brake);
}

// ---- Drives ----

static void destroy_drive(void* const model)
{
    drive_destroy(model);
}

static void set_drive_error(void* const model, const uint16_t code, const bool is_present,
                            const uint64_t now_ns)
{
    drive_set_error(model, code, is_present, now_ns);
}

static status_t create_drive(device_t* const device, const void* const kind, const char* const path,
                             char reason[EDS_ERROR_MAX])
{
    const world_drive_type_t* type = kind;
    const devices_config_t* config = &device->devices->config;
    const uint64_t step_ns         = (uint64_t)config->world->step_ns;
    const drive_config_t wanted    = {.seed             = config->seed,
                                      .sensor_device    = (device->entry->bus << 8) | device->entry->node,
                                      .step_ns          = step_ns,
                                      .substep_ns       = step_ns / PLANT_SUBSTEPS,
                                      .torque_limit_nm  = device->torque_limit_nm,
                                      .torque_sensor    = torque_sensor_of(type),
                                      .encoder          = encoder_of(type),
                                      .read_truth       = read_drive_truth,
                                      .truth_context    = device,
                                      .observer         = on_axis,
                                      .observer_context = device};
    const status_t status          = drive_create(config->segments[device->entry->bus].bus, path,
                                                  (uint8_t)device->entry->node, &wanted, &device->drive, reason);
    if (status == STATUS_OK) {
        device->model =
            (device_model_t){device->drive, drive_node(device->drive), destroy_drive, set_drive_error};
    }
    return status;
}

static void report_drive(const device_t* const device, const uint64_t now_ns)
{
    report(device, now_ns, 0U, drive_statusword(device->drive), drive_brake_is_engaged(device->drive));
}

static void act_drive(const device_t* const device, plant_input_t* const out_input)
{
    out_input->brake_engaged[device->joint] = drive_brake_is_engaged(device->drive);
}

static void end_drive(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    (void)now_ns;
    drive_end_step(device->drive, end_ns);
}

static const device_kind_t drives = {.report = report_drive, .act = act_drive, .end_step = end_drive};

static void end_bench(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    const double h_s = (double)(end_ns - now_ns) * 1.0e-9 / (double)PLANT_SUBSTEPS;
    const bool brake = drive_brake_is_engaged(device->drive);
    for (unsigned k = 0U; k < PLANT_SUBSTEPS; k++) {
        const plant_rotor_t* rotor = &device->bench.rotor;
        const double torque_nm = drive_regulate(device->drive, rotor->position_rad, rotor->velocity_rad_s);
        motor_bench_step(&device->bench, brake, torque_nm, h_s);
    }
    drive_end_step(device->drive, end_ns);
}

static const device_kind_t benches = {.report = report_drive, .end_step = end_bench};

// ---- Joysticks ----

static void destroy_joystick(void* const model)
{
    joystick_destroy(model);
}

static void set_joystick_error(void* const model, const uint16_t code, const bool is_present,
                               const uint64_t now_ns)
{
    joystick_set_error(model, code, is_present, now_ns);
}

static status_t create_joystick(device_t* const device, const void* const kind, const char* const path,
                                char reason[EDS_ERROR_MAX])
{
    const world_joystick_t* joystick = kind;
    const joystick_config_t wanted   = {.encoder          = stick_encoder_of(joystick),
                                        .read_truth       = read_stick_truth,
                                        .truth_context    = device,
                                        .observer         = on_axis,
                                        .observer_context = device};
    const status_t status = joystick_create(device->devices->config.segments[device->entry->bus].bus, path,
                                            (uint8_t)device->entry->node, &wanted, &device->joystick, reason);
    if (status == STATUS_OK) {
        device->model = (device_model_t){device->joystick, joystick_node(device->joystick), destroy_joystick,
                                         set_joystick_error};
    }
    return status;
}

static void report_joystick(const device_t* const device, const uint64_t now_ns)
{
    for (unsigned axis = 0U; axis < JOYSTICK_AXES; axis++) {
        report(device, now_ns, axis, joystick_statusword(device->joystick, axis), false);
    }
}

static void act_joystick(const device_t* const device, plant_input_t* const out_input)
{
    joystick_torque(device->joystick, out_input->stick_torque_nm[device->joint]);
}

static void end_joystick(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    (void)now_ns;
    joystick_end_step(device->joystick, end_ns);
}

static const device_kind_t joysticks = {
    .report = report_joystick, .act = act_joystick, .end_step = end_joystick};

// ---- Reaction wheels ----

static void read_wheel_truth(void* const context, wheel_truth_t* const out_truth)
{
    const device_t* device     = context;
    const plant_wheel_t* wheel = &device->devices->config.truth->wheel[device->joint];
    *out_truth                 = (wheel_truth_t){wheel->momentum_nms, wheel->torque_nm, wheel->housing_rad_s};
}

/// Report a change of state of a wheel, which has no brake.
static void on_wheel(void* const context, const uint8_t node, const unsigned axis, const uint16_t statusword,
                     const bool brake, const uint64_t now_ns)
{
    (void)node;
    (void)brake;
    report(context, now_ns, axis, statusword, false);
}

static void destroy_wheel(void* const model)
{
    wheel_destroy(model);
}

static void set_wheel_error(void* const model, const uint16_t code, const bool is_present,
                            const uint64_t now_ns)
{
    wheel_set_error(model, code, is_present, now_ns);
}

static status_t create_wheel(device_t* const device, const void* const kind, const char* const path,
                             char reason[EDS_ERROR_MAX])
{
    const world_wheel_t* wanted_wheel = kind;
    wheel_t* wheel                    = NULL;
    const wheel_config_t wanted       = {.momentum_nms     = wanted_wheel->momentum,
                                         .read_truth       = read_wheel_truth,
                                         .truth_context    = device,
                                         .observer         = on_wheel,
                                         .observer_context = device};
    const status_t status = wheel_create(device->devices->config.segments[device->entry->bus].bus, path,
                                         (uint8_t)device->entry->node, &wanted, &wheel, reason);
    if (status == STATUS_OK) {
        device->model = (device_model_t){wheel, wheel_node(wheel), destroy_wheel, set_wheel_error};
    }
    return status;
}

static void report_wheel(const device_t* const device, const uint64_t now_ns)
{
    report(device, now_ns, 0U, wheel_statusword(device->model.model), false);
}

static void act_wheel(const device_t* const device, plant_input_t* const out_input)
{
    out_input->wheel_torque_nm[device->joint] = wheel_torque(device->model.model);
}

static void end_wheel(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    (void)now_ns;
    wheel_end_step(device->model.model, end_ns);
}

static const device_kind_t wheels = {.report = report_wheel, .act = act_wheel, .end_step = end_wheel};

// ---- Valve boxes ----

/// Returns the index of the valve at an output of a box; the number of all valves if the output has no valve.
static unsigned valve_at(const device_t* const device, const unsigned output)
{
    const world_t* world = device->devices->config.world;
    unsigned valve       = 0U;
    while ((valve < world->valve_count) &&
           ((world->valve[valve].box != device->joint) || (world->valve[valve].output != (output + 1U)))) {
        valve++;
    }
    return valve;
}

static void on_valve(void* const context, const unsigned output, const bool is_open, const uint64_t now_ns)
{
    const device_t* device         = context;
    const devices_config_t* config = &device->devices->config;
    const unsigned valve           = valve_at(device, output);
    if (valve < config->world->valve_count) {
        const truth_valve_t event = {.name = config->world->valve[valve].name, .is_open = is_open};
        config->valve_changed(config->context, now_ns, &event);
    }
}

static void destroy_box(void* const model)
{
    valve_box_destroy(model);
}

static void set_box_error(void* const model, const uint16_t code, const bool is_present,
                          const uint64_t now_ns)
{
    if (is_present) {
        node_raise(valve_box_node(model), code, 0U, 0, now_ns);
    } else {
        node_clear(valve_box_node(model), code, 0U, now_ns);
    }
}

static status_t create_box(device_t* const device, const void* const kind, const char* const path,
                           char reason[EDS_ERROR_MAX])
{
    const world_t* world      = kind;
    valve_box_t* box          = NULL;
    valve_box_config_t wanted = {.changed = on_valve, .context = device};
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        const unsigned valve  = valve_at(device, i);
        wanted.shortest_ns[i] = (valve < world->valve_count) ? (uint64_t)world->valve[valve].shortest_ns : 0U;
    }
    const status_t status = valve_box_create(device->devices->config.segments[device->entry->bus].bus, path,
                                             (uint8_t)device->entry->node, &wanted, &box, reason);
    if (status == STATUS_OK) {
        device->model = (device_model_t){box, valve_box_node(box), destroy_box, set_box_error};
    }
    return status;
}

static void act_box(const device_t* const device, plant_input_t* const out_input)
{
    const world_t* world = device->devices->config.world;
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        const unsigned valve = valve_at(device, i);
        if (valve < world->valve_count) {
            out_input->valve_open[valve] = valve_box_is_open(device->model.model, i);
        }
    }
    for (size_t i = 0U; i < world->latch_count; i++) {
        const world_latch_t* latch = &world->latch[i];
        if ((latch->trigger == WORLD_LATCH_WIRED) && (latch->box == device->joint)) {
            out_input->latch_on[i] = valve_box_is_open(device->model.model, latch->output - 1U);
        }
    }
}

static void end_box(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    (void)now_ns;
    valve_box_end_step(device->model.model, end_ns);
}

static const device_kind_t valve_boxes = {
    .report = report_without_statusword, .act = act_box, .end_step = end_box};

// ---- Sensors ----

static void destroy_sensor(void* const model)
{
    measuring_device_destroy(model);
}

static void set_sensor_error(void* const model, const uint16_t code, const bool is_present,
                             const uint64_t now_ns)
{
    measuring_device_set_error(model, code, is_present, now_ns);
}

static status_t create_sensor(device_t* const device, const void* const kind, const char* const path,
                              char reason[EDS_ERROR_MAX])
{
    const world_sensor_t* element   = kind;
    const devices_config_t* config  = &device->devices->config;
    measuring_device_t* model       = NULL;
    const measuring_config_t wanted = {
        .value_count = sensor_values(element->kind),
        .period_ns   = (element->rate_hz > 0.0) ? (uint64_t)(NS_PER_S / element->rate_hz) : 0U,
        .delay_ns    = (uint64_t)element->delay_ns,
        .step_ns     = (uint64_t)config->world->step_ns,
        .measure     = sensor_measure,
        .context     = &device->sensor};
    device->sensor        = (sensor_t){.plant   = config->plant,
                                       .element = element,
                                       .seed    = config->seed,
                                       .device  = (device->entry->bus << 8) | device->entry->node};
    const status_t status = measuring_device_create(config->segments[device->entry->bus].bus, path,
                                                    (uint8_t)device->entry->node, &wanted, &model, reason);
    if (status == STATUS_OK) {
        device->model =
            (device_model_t){model, measuring_device_node(model), destroy_sensor, set_sensor_error};
    }
    return status;
}

static void end_sensor(device_t* const device, const uint64_t now_ns, const uint64_t end_ns)
{
    (void)now_ns;
    measuring_device_end_step(device->model.model, end_ns);
}

static const device_kind_t sensors = {.report = report_without_statusword, .end_step = end_sensor};

// ---- Opening and closing ----

/// Creates the model of a device from its EDS at `path`; `kind` is its element of the world.
typedef status_t (*create_fn)(device_t* device, const void* kind, const char* path, char reason[]);

static status_t add(devices_t* const devices, const device_t* const wanted, const create_fn create,
                    const void* const kind, char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    char reason[EDS_ERROR_MAX];
    device_t* device       = &devices->device[devices->count];
    *device                = *wanted;
    device->devices        = devices;
    const unsigned bus     = device->entry->bus;
    bus_t* const channel_b = devices->config.channel_b[bus];
    (void)snprintf(path, sizeof path, "%s/%s", devices->config.directory, device->entry->eds);
    const status_t status = create(device, kind, path, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %.150s:%u: %s", devices->config.world->path,
                       device->entry->line, reason);
        return status;
    }
    devices->count++;
    return channels_connect(device->model.node, channel_b, devices->config.world->bus[bus], error);
}

static status_t add_bench(devices_t* const devices, const world_bench_t* const bench,
                          char error[SIMULATOR_ERROR_MAX])
{
    const world_drive_type_t* type = &devices->config.world->drive_type[bench->type];
    const device_t wanted          = {.entry       = &bench->device,
                                      .kind        = &benches,
                                      .is_bench    = true,
                                      .bench_drive = plant_drive_of(type, -bench->range, bench->range)};
    device_t* device               = &devices->device[devices->count];
    const status_t status          = add(devices, &wanted, create_drive, type, error);
    plant_drive_vary(&device->bench_drive, &bench->difference);
    motor_bench_init(&device->bench, &device->bench_drive, bench->contact, bench->stiffness);
    return status;
}

static status_t add_all(devices_t* const devices, char error[SIMULATOR_ERROR_MAX])
{
    const world_t* world = devices->config.world;
    status_t status      = STATUS_OK;
    for (size_t i = 0U; (i < world->drive_count) && (status == STATUS_OK); i++) {
        const world_drive_t* drive = &world->drive[i];
        const device_t wanted      = {.entry           = &drive->device,
                                      .kind            = &drives,
                                      .torque_limit_nm = drive->force,
                                      .joint           = plant_joint(world, drive->robot, drive->joint)};
        status = add(devices, &wanted, create_drive, &world->drive_type[drive->type], error);
    }
    for (size_t i = 0U; (i < world->joystick_count) && (status == STATUS_OK); i++) {
        const device_t wanted = {
            .entry = &world->joystick[i].device, .kind = &joysticks, .joint = (unsigned)i};
        status = add(devices, &wanted, create_joystick, &world->joystick[i], error);
    }
    for (size_t i = 0U; (i < world->bench_count) && (status == STATUS_OK); i++) {
        status = add_bench(devices, &world->bench[i], error);
    }
    for (size_t i = 0U; (i < world->wheel_count) && (status == STATUS_OK); i++) {
        const device_t wanted = {.entry = &world->wheel[i].device, .kind = &wheels, .joint = (unsigned)i};
        status                = add(devices, &wanted, create_wheel, &world->wheel[i], error);
    }
    for (size_t i = 0U; (i < world->valve_box_count) && (status == STATUS_OK); i++) {
        const device_t wanted = {
            .entry = &world->valve_box[i].device, .kind = &valve_boxes, .joint = (unsigned)i};
        status = add(devices, &wanted, create_box, world, error);
    }
    for (size_t i = 0U; (i < world->sensor_count) && (status == STATUS_OK); i++) {
        const device_t wanted = {.entry = &world->sensor[i].device, .kind = &sensors};
        status                = add(devices, &wanted, create_sensor, &world->sensor[i], error);
    }
    return status;
}

status_t devices_open(const devices_config_t* const config, devices_t** const out_devices,
                      char error[SIMULATOR_ERROR_MAX])
{
    *out_devices       = NULL;
    devices_t* devices = calloc(1U, sizeof *devices);
    if (devices == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    devices->config       = *config;
    const status_t status = add_all(devices, error);
    if (status != STATUS_OK) {
        devices_close(devices);
        return status;
    }
    *out_devices = devices;
    return STATUS_OK;
}

void devices_close(devices_t* const devices)
{
    for (size_t i = 0U; (devices != NULL) && (i < devices->count); i++) {
        const device_model_t* model = &devices->device[i].model;
        model->destroy(model->model);
    }
    free(devices);
}

size_t devices_count(const devices_t* const devices)
{
    return devices->count;
}

const world_device_t* device_entry(const devices_t* const devices, const size_t index)
{
    return devices->device[index].entry;
}

drive_t* device_drive(const devices_t* const devices, const size_t index)
{
    return devices->device[index].drive;
}

const motor_bench_t* device_bench(const devices_t* const devices, const size_t index)
{
    const device_t* device = &devices->device[index];
    return device->is_bench ? &device->bench : NULL;
}

const device_model_t* device_model(const devices_t* const devices, const size_t index)
{
    return &devices->device[index].model;
}

// ---- One step ----

void devices_power_on(devices_t* const devices)
{
    for (size_t i = 0U; i < devices->count; i++) {
        node_power_on(devices->device[i].model.node);
    }
}

void devices_report(devices_t* const devices, const uint64_t now_ns)
{
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if (device->kind->report != NULL) {
            device->kind->report(device, now_ns);
        }
    }
}

void devices_act(const devices_t* const devices, plant_input_t* const out_input)
{
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if (device->kind->act != NULL) {
            device->kind->act(device, out_input);
        }
    }
}

void devices_regulate(void* const context, const unsigned substep, const plant_rotor_t* const motor,
                      double* const out_torque_nm)
{
    const devices_t* devices = context;
    (void)substep;
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if ((device->drive != NULL) && !device->is_bench) {
            const plant_rotor_t* rotor = &motor[device->joint];
            out_torque_nm[device->joint] =
                drive_regulate(device->drive, rotor->position_rad, rotor->velocity_rad_s);
        }
    }
}

void devices_end_step(devices_t* const devices, const uint64_t now_ns, const uint64_t end_ns)
{
    for (size_t i = 0U; i < devices->count; i++) {
        device_t* device = &devices->device[i];
        if (device->kind->end_step != NULL) {
            device->kind->end_step(device, now_ns, end_ns);
        }
    }
}
