// SPDX-License-Identifier: Apache-2.0
#include "sim/app/devices.h"

#include "sim/app/channels.h"
#include "sim/plant/motor_bench.h"
#include "sim/plant/parameters.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH_OCTETS 4096U

typedef struct {
    devices_t* devices;
    const world_device_t* place;
    drive_t* drive;       // Null: a joystick.
    joystick_t* joystick; // Null: a drive.
    unsigned joint;       // PLANT_JOINTS: none, the drive is on its bench.
    motor_bench_t bench;
    plant_drive_t bench_drive;
} device_t;

struct devices {
    devices_config_t config;
    device_t device[DEVICES_MAX];
    size_t count;
};

// ---- Inputs and outputs of devices ----

static void look_at_drive(void* const context, drive_truth_t* const out_truth)
{
    const device_t* device          = context;
    const plant_truth_t* truth      = device->devices->config.truth;
    const bool is_bench             = device->joint == PLANT_JOINTS;
    const plant_rotor_t* rotor      = is_bench ? &device->bench.rotor : &truth->motor[device->joint];
    out_truth->motor_position_rad   = rotor->position_rad;
    out_truth->motor_velocity_rad_s = rotor->velocity_rad_s;
    out_truth->joint_torque_nm =
        is_bench ? device->bench.output_torque_nm : truth->joint_torque_nm[device->joint];
}

static void look_at_stick(void* const context, joystick_truth_t* const out_truth)
{
    const device_t* device     = context;
    const plant_truth_t* truth = device->devices->config.truth;
    out_truth->buttons         = 0U;
    memcpy(out_truth->position_rad, truth->stick_position_rad, sizeof out_truth->position_rad);
    memcpy(out_truth->velocity_rad_s, truth->stick_velocity_rad_s, sizeof out_truth->velocity_rad_s);
}

static node_t* node_of(const device_t* const device)
{
    return (device->drive != NULL) ? drive_node(device->drive) : joystick_node(device->joystick);
}

static void report(const device_t* const device, const uint64_t now_ns, const unsigned axis,
                   const uint16_t statusword, const bool brake)
{
    const devices_config_t* config = &device->devices->config;
    const truth_drive_t event      = {.bus           = config->world->bus[device->place->bus],
                                      .node          = (uint8_t)device->place->node,
                                      .axis          = (uint8_t)axis,
                                      .statusword    = statusword,
                                      .plugged       = node_is_plugged(node_of(device)),
                                      .brake_engaged = brake};
    config->changed(config->context, now_ns, &event);
}

static void on_axis(void* const context, const uint8_t node, const unsigned axis, const uint16_t statusword,
                    const bool brake, const uint64_t now_ns)
{
    (void)node;
    report(context, now_ns, axis, statusword, brake);
}

// ---- Opening and closing ----

static status_t create_drive(device_t* const device, const world_drive_type_t* const type,
                             const char* const path, char reason[EDS_ERROR_MAX])
{
    const devices_config_t* config = &device->devices->config;
    const uint64_t step_ns         = (uint64_t)config->world->step_ns;
    const drive_config_t wanted    = {.seed             = config->seed,
                                      .sensor_device    = (device->place->bus << 8) | device->place->node,
                                      .step_ns          = step_ns,
                                      .substep_ns       = step_ns / PLANT_SUBSTEPS,
                                      .torque_sensor    = torque_sensor_of(type),
                                      .encoder          = encoder_of(type),
                                      .look             = look_at_drive,
                                      .look_context     = device,
                                      .observer         = on_axis,
                                      .observer_context = device};
    return drive_create(config->segments[device->place->bus].bus, path, (uint8_t)device->place->node, &wanted,
                        &device->drive, reason);
}

static status_t create_joystick(device_t* const device, const world_joystick_t* const joystick,
                                const char* const path, char reason[EDS_ERROR_MAX])
{
    const joystick_config_t wanted = {.encoder          = stick_encoder_of(joystick),
                                      .look             = look_at_stick,
                                      .look_context     = device,
                                      .observer         = on_axis,
                                      .observer_context = device};
    return joystick_create(device->devices->config.segments[device->place->bus].bus, path,
                           (uint8_t)device->place->node, &wanted, &device->joystick, reason);
}

/// The next device: a drive of a type, or a joystick if that is null.
static status_t add(devices_t* const devices, const device_t* const wanted,
                    const world_drive_type_t* const type, const world_joystick_t* const joystick,
                    char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    char reason[EDS_ERROR_MAX];
    device_t* device       = &devices->device[devices->count];
    *device                = *wanted;
    device->devices        = devices;
    const unsigned bus     = device->place->bus;
    bus_t* const channel_b = devices->config.channel_b[bus];
    (void)snprintf(path, sizeof path, "%s/%s", devices->config.folder, device->place->eds);
    const status_t status = (type != NULL) ? create_drive(device, type, path, reason)
                                           : create_joystick(device, joystick, path, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    devices->count++;
    return channels_connect(node_of(device), channel_b, devices->config.world->bus[bus], error);
}

static status_t add_bench(devices_t* const devices, const world_bench_t* const bench,
                          char error[SIMULATOR_ERROR_MAX])
{
    const world_drive_type_t* type = &devices->config.world->drive_type[bench->type];
    const device_t wanted          = {.place       = &bench->device,
                                      .joint       = PLANT_JOINTS,
                                      .bench_drive = plant_drive_of(type, -bench->range, bench->range)};
    device_t* device               = &devices->device[devices->count];
    const status_t status          = add(devices, &wanted, type, NULL, error);
    motor_bench_init(&device->bench, &device->bench_drive, bench->contact, bench->stiffness);
    return status;
}

static status_t add_all(devices_t* const devices, char error[SIMULATOR_ERROR_MAX])
{
    const world_t* world = devices->config.world;
    status_t status      = STATUS_OK;
    for (size_t i = 0U; (i < world->drive_count) && (status == STATUS_OK); i++) {
        const world_drive_t* drive = &world->drive[i];
        const device_t wanted      = {.place = &drive->device, .joint = drive->joint};
        status                     = add(devices, &wanted, &world->drive_type[drive->type], NULL, error);
    }
    for (size_t i = 0U; (i < world->joystick_count) && (status == STATUS_OK); i++) {
        const device_t wanted = {.place = &world->joystick[i].device, .joint = PLANT_JOINTS};
        status                = add(devices, &wanted, NULL, &world->joystick[i], error);
    }
    for (size_t i = 0U; (i < world->bench_count) && (status == STATUS_OK); i++) {
        status = add_bench(devices, &world->bench[i], error);
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
        drive_destroy(devices->device[i].drive);
        joystick_destroy(devices->device[i].joystick);
    }
    free(devices);
}

size_t devices_count(const devices_t* const devices)
{
    return devices->count;
}

const world_device_t* device_place(const devices_t* const devices, const size_t index)
{
    return devices->device[index].place;
}

drive_t* device_drive(const devices_t* const devices, const size_t index)
{
    return devices->device[index].drive;
}

joystick_t* device_joystick(const devices_t* const devices, const size_t index)
{
    return devices->device[index].joystick;
}

node_t* device_node(const devices_t* const devices, const size_t index)
{
    return node_of(&devices->device[index]);
}

// ---- One step ----

void devices_power_on(devices_t* const devices)
{
    for (size_t i = 0U; i < devices->count; i++) {
        node_power_on(node_of(&devices->device[i]));
    }
}

void devices_report(devices_t* const devices, const uint64_t now_ns)
{
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if (device->drive != NULL) {
            report(device, now_ns, 0U, drive_statusword(device->drive),
                   drive_brake_is_engaged(device->drive));
        }
        for (unsigned axis = 0U; (device->joystick != NULL) && (axis < JOYSTICK_AXES); axis++) {
            report(device, now_ns, axis, joystick_statusword(device->joystick, axis), false);
        }
    }
}

void devices_act(const devices_t* const devices, plant_input_t* const out_input)
{
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if (device->joystick != NULL) {
            joystick_torque(device->joystick, out_input->stick_torque_nm);
        } else if (device->joint < PLANT_JOINTS) {
            out_input->brake_engaged[device->joint] = drive_brake_is_engaged(device->drive);
        } else {
            // The plant does not know benches.
        }
    }
}

void devices_regulate(void* const context, const unsigned substep, const plant_rotor_t motor[PLANT_JOINTS],
                      double out_torque_nm[PLANT_JOINTS])
{
    const devices_t* devices = context;
    (void)substep;
    for (size_t i = 0U; i < devices->count; i++) {
        const device_t* device = &devices->device[i];
        if (device->joint < PLANT_JOINTS) {
            const plant_rotor_t* rotor = &motor[device->joint];
            out_torque_nm[device->joint] =
                drive_regulate(device->drive, rotor->position_rad, rotor->velocity_rad_s);
        }
    }
}

static void move_bench(device_t* const device, const double h_s)
{
    const bool brake = drive_brake_is_engaged(device->drive);
    for (unsigned k = 0U; k < PLANT_SUBSTEPS; k++) {
        const plant_rotor_t* rotor = &device->bench.rotor;
        const double torque_nm = drive_regulate(device->drive, rotor->position_rad, rotor->velocity_rad_s);
        motor_bench_step(&device->bench, brake, torque_nm, h_s);
    }
}

void devices_end_step(devices_t* const devices, const uint64_t now_ns, const uint64_t end_ns)
{
    const double h_s = (double)(end_ns - now_ns) * 1.0e-9 / (double)PLANT_SUBSTEPS;
    for (size_t i = 0U; i < devices->count; i++) {
        device_t* device = &devices->device[i];
        if (device->joystick != NULL) {
            joystick_end_step(device->joystick, end_ns);
            continue;
        }
        if (device->joint == PLANT_JOINTS) {
            move_bench(device, h_s);
        }
        drive_end_step(device->drive, end_ns);
    }
}
