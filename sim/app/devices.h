// SPDX-License-Identifier: Apache-2.0
/// The devices of a world on the buses of a run, each made from its EDS: drives of the robots' joints,
/// joysticks, drives on benches (sim/plant/motor_bench.h), reaction wheels, valve boxes, and sensors, in this
/// order.
///
/// Ownership  devices_open allocates, devices_close frees. World, plant and buses outlive the devices.
/// Context    One task.
#ifndef SIM_APP_DEVICES_H
#define SIM_APP_DEVICES_H

#include "sim/app/segment.h"
#include "sim/devices/drive.h"
#include "sim/devices/joystick.h"
#include "sim/devices/measuring_device.h"
#include "sim/devices/wheel.h"
#include "sim/plant/motor_bench.h"
#include "sim/plant/plant.h"
#include "sim/truth/truth.h"
#include "sim/world/world.h"

#include <stddef.h>
#include <stdint.h>

#define DEVICES_MAX                                                                                          \
    (WORLD_DRIVES_MAX + WORLD_JOYSTICKS_MAX + WORLD_BENCHES_MAX + WORLD_WHEELS_MAX + WORLD_VALVE_BOXES_MAX + \
     WORLD_SENSORS_MAX)

typedef struct devices devices_t;

/// A device of any kind: its model and its node.
typedef struct {
    void* model;
    node_t* node;
    void (*destroy)(void* model);
    /// Set by a scenario: an error of the device appears or disappears.
    void (*set_error)(void* model, uint16_t code, bool is_present, uint64_t now_ns);
} device_model_t;

typedef struct {
    const world_t* world;
    const char* directory; ///< Directory of the EDS files.
    const plant_truth_t* truth;
    const plant_t* plant;    ///< The plant that the sensors measure.
    segment_t* segments;     ///< The first are the buses of the world, in its order.
    bus_t* const* channel_b; ///< Redundant channel of each segment, or null.
    uint64_t seed;
    /// Called for every change of state of a device.
    void (*changed)(void* context, uint64_t now_ns, const truth_drive_t* drive);
    void (*valve_changed)(void* context, uint64_t now_ns, const truth_valve_t* valve);
    void* context;
} devices_config_t;

/// Make the devices of a world, without power. STATUS_OK; else *out_devices is null and `error` is filled:
/// STATUS_EXHAUSTED (memory, nodes of a bus), STATUS_INVALID (a joystick that does not have two axes),
/// statuses of node_create.
MUST_USE status_t devices_open(const devices_config_t* config, devices_t** out_devices,
                               char error[SIMULATOR_ERROR_MAX]);
/// Null is allowed.
void devices_close(devices_t* devices);

size_t devices_count(const devices_t* devices);
/// Returns the entry of the device in the world.
const world_device_t* device_entry(const devices_t* devices, size_t index);
/// Returns the drive at an index; null if the device is not a drive.
drive_t* device_drive(const devices_t* devices, size_t index);
/// Returns the test bench of the drive at an index; null if the device is not on a bench.
const motor_bench_t* device_bench(const devices_t* devices, size_t index);
const device_model_t* device_model(const devices_t* devices, size_t index);

void devices_power_on(devices_t* devices);
/// Report the state of every device to the listener.
void devices_report(devices_t* devices, uint64_t now_ns);

/// Set the plant inputs that the devices determine for the whole next step: brakes, valves, latches, and the
/// torques of joysticks and wheels.
void devices_act(const devices_t* devices, plant_input_t* out_input);
/// Callback plant_input_t.drive: compute the torque of a motor. `context` is the devices_t.
void devices_regulate(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm);
/// Update the devices after a step of the plant from `now_ns` to `end_ns`; this also moves the benches.
void devices_end_step(devices_t* devices, uint64_t now_ns, uint64_t end_ns);

#endif // SIM_APP_DEVICES_H
