// SPDX-License-Identifier: Apache-2.0
/// Devices of a mission beside the arm and the joystick, from a text file: one line per device, `<bus> <node>
/// joint-drive <contact rad> <stiffness Nm/rad>`, `#` starts a comment. The device is made from its EDS; its
/// motor is on a bench (sim/plant/bench.h) and touches an elastic object at the contact angle; stiffness 0:
/// none.
///
/// Ownership  equipment_open allocates, equipment_close frees. Buses outlive the equipment.
/// Context    One task.
#ifndef SIM_APP_EQUIPMENT_H
#define SIM_APP_EQUIPMENT_H

#include "sim/app/segment.h"
#include "sim/truth/truth.h"

#include <stddef.h>
#include <stdint.h>

#define EQUIPMENT_MAX 16U

typedef struct equipment equipment_t;

typedef struct {
    const char* path;         ///< The file.
    const char* devices_path; ///< Folder of the EDS files.
    segment_t* segments;
    size_t segment_count;
    bus_t* const* channel_b; ///< Redundant channel of each segment, or null; null: none has one.
    uint64_t seed;
    /// Called for every change of state of a device.
    void (*changed)(void* context, uint64_t now_ns, const truth_drive_t* drive);
    void* context;
} equipment_config_t;

/// Returns STATUS_OK; else *out_equipment is null and `error` is filled, with file and line: STATUS_NOT_FOUND
/// (file), STATUS_INVALID (content), STATUS_EXHAUSTED (memory, devices), statuses of drive_create.
MUST_USE status_t equipment_open(const equipment_config_t* config, equipment_t** out_equipment,
                                 char error[SIMULATOR_ERROR_MAX]);
/// Null is allowed.
void equipment_close(equipment_t* equipment);
/// Power to all devices. Null is allowed, as below.
void equipment_power_on(equipment_t* equipment);
/// Tell of every device as it is.
void equipment_tell(equipment_t* equipment, uint64_t now_ns);
/// Advance all benches from `now_ns` to `end_ns`.
void equipment_move(equipment_t* equipment, uint64_t now_ns, uint64_t end_ns);

#endif // SIM_APP_EQUIPMENT_H
