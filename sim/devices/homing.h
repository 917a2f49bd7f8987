// SPDX-License-Identifier: Apache-2.0
/// Homing of a CiA 402 drive (mode of operation 6): a search for the reference of its position. Bit 4 of the
/// controlword starts it and, when cleared, ends it; bit 8 (halt) pauses it; bits 10, 12 and 13 of the
/// statusword report it.
///
/// Methods (0x6098): 35 and 37 take the present position; -1 and -2 are manufacturer-specific and run with
/// 0x6099:01 against the negative or positive end stop, until the torque has been at its limit for
/// HOMING_STALL_NS. The search fails if the commanded travel exceeds the range 0x607D. Any other method fails
/// at once. 0x609A limits the acceleration. At the reference the position becomes -0x607C: the zero of the
/// axis is the home position plus the home offset.
///
/// Ownership  The caller provides homing_t; node and axis outlive it.
#ifndef SIM_DEVICES_HOMING_H
#define SIM_DEVICES_HOMING_H

#include "sim/devices/axis.h"

#include <stdbool.h>
#include <stdint.h>

#define HOMING_STALL_NS 20000000U ///< Time at the torque limit that counts as an end stop.

typedef enum {
    HOMING_IDLE,      ///< Not started, or ended before its result.
    HOMING_SEARCHING, ///< Also while it is halted.
    HOMING_ATTAINED,
    HOMING_FAILED
} homing_state_t;

typedef struct { // Private, except state: read-only.
    homing_state_t state;
    // 0x6098; the next five are 0x6099:01, 0x609A, 0x607C, 0x607D:01 and :02. Null: the drive has no homing.
    object_t* method;
    object_t* speed;
    object_t* acceleration;
    object_t* offset;
    object_t* low_position;
    object_t* high_position;
    double position_unit;
    double velocity_unit;
    bool is_asked; // Bit 4 of the last controlword: start of homing.
    bool is_halted;
    double reference_rad_s; // Speed of the reference.
    double travelled_rad;
    uint64_t stalled_ns;
} homing_t;

/// Find the objects of axis 0 of a node. False: the mode is supported (0x6502), but an object is missing.
bool homing_init(homing_t* homing, const axis_t* axis, double position_unit, double velocity_unit);
/// End the search: the axis is no longer in operation in this mode.
void homing_reset(homing_t* homing);
/// Process a controlword that was received in OPERATION ENABLED.
void homing_command(homing_t* homing, uint16_t controlword);
/// Returns the speed of the reference for the next dt_s [rad/s].
double homing_advance(homing_t* homing, double dt_s);
/// Called after a step of step_ns; `is_limited`: the torque was at its limit. True if the reference is found:
/// the present position is then homing_position_rad.
bool homing_end_step(homing_t* homing, bool is_limited, uint64_t step_ns);
double homing_position_rad(const homing_t* homing);
/// Set bits 10, 12 and 13 of the statusword. The axis counts as at rest while its reference is at rest.
void homing_update_statusword(const homing_t* homing, axis_t* axis);

#endif // SIM_DEVICES_HOMING_H
