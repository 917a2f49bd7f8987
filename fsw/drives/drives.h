// SPDX-License-Identifier: Apache-2.0
/// The part that every subsystem with drives on a CAN bus has in common: commissioning from the descriptor,
/// the cycle, supervision by events, counters, and the safe state. Functions with the parameter `self` are
/// callbacks for subsystem_callbacks_t: a subsystem names them in its table, or calls them from its own.
/// drives_t is the first member of the subsystem's structure, so that `self` is both.
///
/// Devices, settings and end nodes come from the descriptor: HARDWARE_INIT brings up the devices of all
/// configurations, PRE_OPERATIONAL writes the settings of one. The subsystem's callback `fits` must have
/// accepted the descriptor by drives_fit (drives_fitting.h). Faults become the events DEVICE_LOST,
/// DRIVE_FAULT {node u8, code u16}, DRIVE_WARNING, BUS_WARNING {node u8, code u16}, DEVICE_REFUSED {node u8,
/// reason u8 as canopen_network_refusal_t, object u32, detail u32}, FOREIGN_SYNC and CHANNEL_SELECTED
/// {channel u8}, if the descriptor has them.
///
/// Ownership  The caller places drives_t; it must not be moved. Subsystem and resolver outlive it.
/// Context    The subsystem's task and time. Never blocks.
/// Errors     Each function lists its statuses; STATUS_BUSY: call again in the next cycle.
#ifndef FSW_DRIVES_DRIVES_H
#define FSW_DRIVES_DRIVES_H

#include "fsw/canopen/network.h"
#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

#define DRIVES_ACCESS_SLOTS 16U ///< Transfers of drives_access.h at most.
#define DRIVES_COUNTERS 27U     ///< Number of counters of drives_counters.h, without PDO_MISSED.

typedef enum {
    DRIVES_RESTING,  ///< Controllers off.
    DRIVES_PREPARED, ///< Controllers on, actuators off.
    DRIVES_ENGAGED   ///< Actuators on.
} drives_activity_t;

typedef struct {    // Private: one transfer.
    uint8_t device; // In the network.
    uint8_t length; // Expected [octets]; 0: any.
    bool is_read;
    bool is_register;
    bool is_pulse;                         // A pulse without transfer, already sent.
    const descriptor_quantity_t* quantity; // Null: the value is not converted.
} drives_transfer_t;

typedef struct { // Private, except network (as network.h says) and activity (read-only).
    subsystem_t* generic;
    void (*abandon)(void* self);
    drives_activity_t activity;
    const flow_resolver_t* resolver;
    canopen_network_t network;
    canopen_cia402_goal_t goal;
    const descriptor_configuration_t* configuration; ///< Being applied, or applied.
    uint64_t called_ns;                              ///< Last call of drives_configure.
    bool is_written;                                 ///< The settings are in the devices.
    bool is_closing;
    bool is_borrowed; ///< The bus is open out of order.
    struct {          // Used by drives_access.c.
        drives_transfer_t slots[DRIVES_ACCESS_SLOTS];
        uint8_t owners[NETWORK_DEVICES_MAX]; // Slot + 1 of the transfer to a device; 0 none.
        uint64_t pulse_end_ns;               // Pulses have left by then.
    } access;
    struct { // Used by drives_counters.c: places of the counters; null: not in the descriptor.
        uint8_t* places[DRIVES_COUNTERS];
        uint8_t* missed;
        uint16_t missed_count;
    } counters;
} drives_t;

/// `abandon` ends the commanded activity; called when the activity changes. May be null.
void drives_init(drives_t* drives, subsystem_t* generic, const flow_resolver_t* resolver,
                 void (*abandon)(void* self));

/// Open the bus, boot and identify the devices. STATUS_BUSY; STATUS_OK; STATUS_NOT_FOUND (no device, its
/// class, or bus); statuses of canopen_network_add, canopen_network_open and canopen_network_boot.
status_t drives_hardware_init(void* self);
/// Open the bus for frames outside of the cycle, in any state; devices do not change. Statuses of
/// drives_hardware_init but STATUS_BUSY.
status_t drives_borrow(drives_t* drives);
/// Close the bus if it was borrowed and HARDWARE_INIT was not entered meanwhile.
void drives_give_back(drives_t* drives);
/// Settings into the devices, process data on; the axes stay without voltage. STATUS_BUSY; STATUS_OK;
/// STATUS_NOT_FOUND (device not brought up); STATUS_EXHAUSTED (settings); statuses of
/// canopen_network_configure and _start.
status_t drives_configure(void* self, const descriptor_configuration_t* configuration);
/// All axes to standby, and then PREPARED. STATUS_BUSY; STATUS_OK.
status_t drives_start_control(void* self);
/// RESTING, and all axes without voltage. STATUS_BUSY; STATUS_OK.
status_t drives_stop_control(void* self);
/// All axes into operation, and then ENGAGED. STATUS_BUSY; STATUS_OK.
status_t drives_engage(void* self);
/// PREPARED, and all axes to standby. STATUS_BUSY; STATUS_OK.
status_t drives_disengage(void* self);
/// RESTING, and the safe state, from any condition. STATUS_BUSY; STATUS_OK.
status_t drives_secure(void* self);
/// RESTING, and process data off. STATUS_OK.
status_t drives_post(void* self);
/// Nodes reset, bus closed. STATUS_BUSY; STATUS_OK.
status_t drives_hardware_deinit(void* self);
/// The program ends, in any state: close the buses and leave the devices as they are.
void drives_release(void* self);

/// Make channel 0 (A) or 1 (B) of the bus the active one, at once or for the next HARDWARE_INIT. It must be
/// called only where all axes are out of operation. STATUS_OK; STATUS_OUT_OF_RANGE (no such channel, or a bus
/// without channel B); STATUS_NOT_FOUND (the controller of that channel could not be opened).
status_t drives_select_channel(drives_t* drives, uint8_t channel);

/// Start of a cycle: process received frames and raise an event for each fault.
void drives_sense(void* self);
/// End of a cycle: process data, requests, SYNC.
void drives_emit(void* self);

/// Device number `position` (0..) of the applied configuration, or null.
canopen_device_t* drives_device(drives_t* drives, uint16_t position);
/// True if process data flow.
bool drives_are_running(const drives_t* drives);
/// SYNCs that a device of the applied configuration has not answered [wraps].
uint32_t drives_missed(const drives_t* drives, uint16_t position);
/// Commands of all axes that were cut at their limits [wraps].
uint32_t drives_limited(const drives_t* drives);

/// Integer mode of operation (object 0x6060) that the configuration sets for the device; 0 if it sets none.
int drives_mode(const subsystem_descriptor_t* descriptor, const descriptor_device_t* device);

#endif // FSW_DRIVES_DRIVES_H
