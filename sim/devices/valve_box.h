// SPDX-License-Identifier: Apache-2.0
/// Valve box (valve-box.eds): a CiA 401 module with an output for each of 16 valves and an input for the
/// pressure switch behind it, which is on while the valve is open.
///
/// Outputs are 0x6200:01 and :02. If 0x2100 is not 0, all valves close 0x2100 x 10 ms after the last command.
/// In valve-timer.eds, 0x2100 is a REAL32.
/// If the master is lost (RPDO deadline, heartbeat) or the node leaves OPERATIONAL, each output whose bit in
/// 0x6206 is set gets its bit of 0x6207: by default all valves close. A valve that has opened stays open for
/// at least its shortest pulse; without power it closes at once.
///
/// Ownership  valve_box_create allocates, valve_box_destroy frees.
#ifndef SIM_DEVICES_VALVE_BOX_H
#define SIM_DEVICES_VALVE_BOX_H

#include "base/status.h"
#include "sim/devices/node.h"

#include <stdbool.h>
#include <stdint.h>

#define VALVE_BOX_OUTPUTS 16U

typedef struct {
    uint64_t shortest_ns[VALVE_BOX_OUTPUTS]; ///< Shortest pulse of each valve.
    /// Called for every change of a valve, at its time. May be null.
    void (*changed)(void* context, unsigned output, bool is_open, uint64_t now_ns);
    void* context;
} valve_box_config_t;

typedef struct valve_box valve_box_t;

/// Create a valve box. Statuses of node_create.
MUST_USE status_t valve_box_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                                   const valve_box_config_t* config, valve_box_t** out_box,
                                   char error[EDS_ERROR_MAX]);
/// Null is allowed.
void valve_box_destroy(valve_box_t* box);
node_t* valve_box_node(valve_box_t* box);

/// `output` is 0 to VALVE_BOX_OUTPUTS - 1.
bool valve_box_is_open(const valve_box_t* box, unsigned output);
/// Called after a step of the plant that ended at `now_ns`: close the valves whose time is over.
void valve_box_end_step(valve_box_t* box, uint64_t now_ns);

#endif // SIM_DEVICES_VALVE_BOX_H
