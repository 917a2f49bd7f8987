// SPDX-License-Identifier: Apache-2.0
/// Devices of a mission in addition to the arm and the joystick, from a text file: one line per device,
/// `<bus> <node> joint-drive <contact rad> <stiffness Nm/rad>`, `#` starts a comment. The device is made from
/// its EDS; its motor is on a bench (sim/plant/motor_bench.h) and touches an elastic object at the contact
/// angle; stiffness 0: none.
///
/// Ownership  bench_devices_open allocates, bench_devices_close frees. Buses outlive the bench devices.
/// Context    One task.
#ifndef SIM_APP_BENCH_DEVICES_H
#define SIM_APP_BENCH_DEVICES_H

#include "sim/app/segment.h"
#include "sim/truth/truth.h"

#include <stddef.h>
#include <stdint.h>

#define BENCH_DEVICES_MAX 16U

typedef struct bench_devices bench_devices_t;

typedef struct {
    const char* path;         ///< The file.
    const char* devices_path; ///< Folder of the EDS files.
    segment_t* segments;
    unsigned segment_count;
    bus_t* const* channel_b; ///< Redundant channel of each segment, or null; null: none has one.
    uint64_t seed;
    /// Called for every change of state of a device.
    void (*changed)(void* context, uint64_t now_ns, const truth_drive_t* drive);
    void* context;
} bench_devices_config_t;

/// Returns STATUS_OK; else *out_bench_devices is null and `error` is filled, with file and line:
/// STATUS_NOT_FOUND (file), STATUS_INVALID (content), STATUS_EXHAUSTED (memory, devices), statuses of
/// drive_create.
MUST_USE status_t bench_devices_open(const bench_devices_config_t* config,
                                     bench_devices_t** out_bench_devices, char error[SIMULATOR_ERROR_MAX]);
/// Null is allowed.
void bench_devices_close(bench_devices_t* bench_devices);
/// Power on all devices. Null is allowed, as below.
void bench_devices_power_on(bench_devices_t* bench_devices);
/// Report the state of every device to the listener.
void bench_devices_report(bench_devices_t* bench_devices, uint64_t now_ns);
/// Advance all benches from `now_ns` to `end_ns`.
void bench_devices_move(bench_devices_t* bench_devices, uint64_t now_ns, uint64_t end_ns);

#endif // SIM_APP_BENCH_DEVICES_H
