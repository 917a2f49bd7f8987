// SPDX-License-Identifier: Apache-2.0
/// Force-reflecting joystick (joystick.eds): two torque axes at one node, encoders on the axes, buttons.
///
/// An enabled axis produces the commanded torque; in every other state the torque is zero. Quick stop sets
/// the torque to zero and ends after 1 ms.
#ifndef SIM_DEVICES_JOYSTICK_H
#define SIM_DEVICES_JOYSTICK_H

#include "base/status.h"
#include "sim/devices/axis.h"
#include "sim/devices/node.h"
#include "sim/plant/sensor.h"

#include <stdbool.h>
#include <stdint.h>

#define JOYSTICK_AXES 2U

typedef struct {
    double position_rad[JOYSTICK_AXES];
    double velocity_rad_s[JOYSTICK_AXES];
    uint32_t buttons; ///< Bit 0 is the first button, bit 1 the second.
} joystick_truth_t;

typedef struct {
    encoder_parameters_t encoder;
    void (*read_truth)(void* context, joystick_truth_t* out_truth);
    void* truth_context;
    axis_observer_t observer; ///< May be null.
    void* observer_context;
} joystick_config_t;

typedef struct joystick joystick_t;

/// Create a joystick. Statuses of node_create.
MUST_USE status_t joystick_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                                  const joystick_config_t* config, joystick_t** out_joystick,
                                  char error[EDS_ERROR_MAX]);
void joystick_destroy(joystick_t* joystick);
node_t* joystick_node(joystick_t* joystick);

/// Present motor torque of each axis.
void joystick_torque(const joystick_t* joystick, double out_torque_nm[JOYSTICK_AXES]);
/// Called after a plant step that ended at `now_ns`: completes quick stops.
void joystick_end_step(joystick_t* joystick, uint64_t now_ns);
uint16_t joystick_statusword(const joystick_t* joystick, unsigned axis);

/// Set by a scenario: an error of the table in README.md appears or disappears, on both axes.
void joystick_set_error(joystick_t* joystick, uint16_t code, bool is_present, uint64_t now_ns);

#endif // SIM_DEVICES_JOYSTICK_H
