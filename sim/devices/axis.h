// SPDX-License-Identifier: Apache-2.0
/// State machine of a CiA 402 power drive system, one per axis, and its objects controlword, statusword,
/// mode.
///
/// axis_next is the transition table of the standard, a pure function. axis_t applies it to the objects of a
/// node (the indices of axis 2 are 0x800 higher). The device reads the state, and calls axis_ramp_done at the
/// end of a ramp.
#ifndef SIM_DEVICES_AXIS_H
#define SIM_DEVICES_AXIS_H

#include "sim/devices/node.h"

#include <stdbool.h>
#include <stdint.h>

#define AXIS_STRIDE 0x800U ///< Distance of the objects of two axes.

#define AXIS_MODE_HOMING 6
#define AXIS_MODE_CSP 8
#define AXIS_MODE_CSV 9
#define AXIS_MODE_CST 10

typedef enum {
    AXIS_NOT_READY,
    AXIS_SWITCH_ON_DISABLED,
    AXIS_READY,
    AXIS_SWITCHED_ON,
    AXIS_ENABLED,
    AXIS_QUICK_STOP,
    AXIS_FAULT_REACTION,
    AXIS_FAULT,
    AXIS_STATE_COUNT
} axis_state_t;

/// Statusword bits in addition to the state.
#define AXIS_STATUS_WARNING 0x0080U
#define AXIS_STATUS_TARGET_REACHED 0x0400U ///< In mode homing.
#define AXIS_STATUS_INTERNAL_LIMIT 0x0800U ///< A target, the torque or the momentum is at its limit.
#define AXIS_STATUS_FOLLOWS 0x1000U ///< In modes CSP, CSV and CST: the drive follows the command value.
#define AXIS_STATUS_HOMING_ATTAINED 0x1000U ///< In mode homing.
#define AXIS_STATUS_FOLLOWING_ERROR 0x2000U ///< In mode CSP.
#define AXIS_STATUS_HOMING_ERROR 0x2000U    ///< In mode homing.

/// Returns the state after a controlword. `before` is the previous controlword, because fault reset acts on a
/// rising edge.
axis_state_t axis_next(axis_state_t state, uint16_t controlword, uint16_t before);
/// Returns bits 0..6 and 9 of the statusword in a state, voltage present.
uint16_t axis_state_bits(axis_state_t state);
/// True in the states in which the drive function of CiA 402 is enabled; then a holding brake is released.
bool axis_function_is_enabled(axis_state_t state);

/// Called for every change of state (brake included) at its time.
typedef void (*axis_observer_t)(void* context, uint8_t node, unsigned axis, uint16_t statusword, bool brake,
                                uint64_t now_ns);

typedef struct { // Read-only for others.
    node_t* node;
    uint8_t number; ///< 0 or 1.
    axis_state_t state;
    uint16_t last_controlword;
    uint16_t flags; ///< AXIS_STATUS_*.
    bool has_fault; ///< A cause of fault is still present: fault reset has no effect.
    object_t* controlword;
    object_t* statusword;
    object_t* error_code;
    object_t* mode;
    object_t* mode_display;
    object_t* modes_supported;
    object_t* abort_option;
    axis_observer_t observer;
    void* observer_context;
} axis_t;

/// Units of position [rad] and velocity [rad/s] of an axis: those of 0x60A8 and 0x60A9, or increments of the
/// encoder 0x608F on the motor side of the gear 0x6091. Returns false if the objects define neither.
bool axis_units(node_t* node, uint8_t number, double* out_position_rad, double* out_velocity_rad_s);
/// Find the objects. Returns false if one is missing.
bool axis_init(axis_t* axis, node_t* node, uint8_t number);
void axis_observe(axis_t* axis, axis_observer_t observer, void* context);
/// Set the state after power-on: switch on disabled, brake engaged.
void axis_reset(axis_t* axis, uint64_t now_ns);

/// Execute the command in the controlword object. Returns true if the state has changed.
bool axis_command(axis_t* axis, uint64_t now_ns);
/// Copy the mode of operation to its display object. Returns true if the mode has changed.
bool axis_select_mode(axis_t* axis);
/// Returns the SDO abort code for a mode of operation; 0 if the device supports the mode.
uint32_t axis_check_mode(const axis_t* axis, int64_t mode);
int axis_mode(const axis_t* axis);

/// Execute the abort-connection option 0x6007 if the axis is enabled: quick stop, disable voltage or fault.
void axis_connection_lost(axis_t* axis, uint64_t now_ns);
/// Enter a fault with its code: fault reaction active if the axis is enabled, else fault.
void axis_fault(axis_t* axis, uint16_t code, uint64_t now_ns);
/// Report that the ramp of quick stop or fault reaction has ended.
void axis_ramp_done(axis_t* axis, uint64_t now_ns);
/// Set by a scenario: an error of the table in README.md appears or disappears. Faults stop the axis; other
/// errors only set the warning flag. Only for nodes with one axis.
void axis_set_error(axis_t* axis, uint16_t code, bool is_present, uint64_t now_ns);
/// Set or clear a flag of the statusword.
void axis_flag(axis_t* axis, uint16_t flag, bool on);

#endif // SIM_DEVICES_AXIS_H
