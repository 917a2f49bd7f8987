// SPDX-License-Identifier: Apache-2.0
/// Motor of a reaction wheel (wheel.eds): CiA 402 with CST and CSV, a tachometer, no brake.
///
/// An enabled wheel produces the commanded torque. In every other state the torque is zero and the wheel
/// keeps its momentum, also after a quick stop, which ends after 1 ms: braking would turn the spacecraft. The
/// momentum is largest at the largest motor speed, 0x6080 [1/min]. Bit 11 of the statusword is set while
/// torque or momentum is at its limit.
///
/// Ownership  wheel_create allocates, wheel_destroy frees.
#ifndef SIM_DEVICES_WHEEL_H
#define SIM_DEVICES_WHEEL_H

#include "base/status.h"
#include "sim/devices/axis.h"
#include "sim/devices/node.h"

#include <stdint.h>

typedef struct {
    double momentum_nms;
    double torque_nm;     ///< Torque on the rotor in the last step.
    double housing_rad_s; ///< Rate of the housing about the axis of the wheel.
} wheel_truth_t;

typedef struct {
    double momentum_nms; ///< Momentum at the largest speed.
    void (*read_truth)(void* context, wheel_truth_t* out_truth);
    void* truth_context;
    axis_observer_t observer; ///< May be null.
    void* observer_context;
} wheel_config_t;

typedef struct wheel wheel_t;

/// Create a wheel. Statuses of node_create.
MUST_USE status_t wheel_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                               const wheel_config_t* config, wheel_t** out_wheel, char error[EDS_ERROR_MAX]);
void wheel_destroy(wheel_t* wheel);
node_t* wheel_node(wheel_t* wheel);

/// Returns the torque of the motor on the rotor for one step of the plant.
double wheel_torque(wheel_t* wheel);
/// Called after a step of the plant that ended at `now_ns`.
void wheel_end_step(wheel_t* wheel, uint64_t now_ns);
uint16_t wheel_statusword(const wheel_t* wheel);
/// Set by a scenario: an error appears or disappears, as in axis_set_error.
void wheel_set_error(wheel_t* wheel, uint16_t code, bool is_present, uint64_t now_ns);

#endif // SIM_DEVICES_WHEEL_H
