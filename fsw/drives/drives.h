// SPDX-License-Identifier: Apache-2.0
/// The part that every subsystem with drives on CAN buses has in common: commissioning from the descriptor,
/// the cycle, supervision by events (docs/can-faults.md), counters, and the safe state. Functions with the
/// parameter `self` are callbacks for subsystem_callbacks_t. drives_t is the first member of the subsystem's
/// structure, so that `self` points to both.
///
/// HARDWARE_INIT brings up the devices of all configurations, PRE_OPERATIONAL writes the settings of one. The
/// subsystem's callback `fits` must have accepted the descriptor by drives_fit (drives_fitting.h). Devices
/// may be on several buses, each with its own master; a node id occurs on one of them only. All devices are
/// secured at once. Each master queues SYNC in the same cycle, after the commands of its own bus, so a bus
/// with fewer commands sends it earlier. With sync="BEFORE_COMMANDS" in the descriptor, all masters queue
/// SYNC before the commands of any bus (docs/decisions/0059).
///
/// Ownership  The caller provides drives_t; it must not be moved. Subsystem and resolver outlive it.
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

// A build whose descriptors are compiled in defines all three with the numbers that its descriptors need.
#ifndef DRIVES_BUSES_MAX
#define DRIVES_BUSES_MAX 4U
#define DRIVES_DEVICES_MAX 32U ///< On all buses; NETWORK_DEVICES_MAX on each.
#define DRIVES_MAPPINGS_MAX 8U ///< Devices whose settings change the mapping of their PDOs.
#endif
/// The number of the bus times this value is added to the code of a bus condition (node 0).
#define DRIVES_BUS_CODE 0x1000U
#define DRIVES_ACCESS_SLOTS 16U ///< Largest number of transfers of drives_access.h.
#define DRIVES_COUNTERS 27U     ///< Number of counters of drives_counters.h, without PDO_MISSED.

typedef enum {
    DRIVES_RESTING,  ///< Controllers off.
    DRIVES_PREPARED, ///< Controllers on, actuators off.
    DRIVES_ENGAGED   ///< Actuators on.
} drives_activity_t;

typedef struct {    // Private: one transfer.
    uint8_t device; // Index in drives_t.devices.
    uint8_t length; // Expected [octets]; 0: any.
    bool is_read;
    bool is_register;
    bool is_pulse;                         // A pulse without transfer, already sent.
    const descriptor_quantity_t* quantity; // Null: the value is not converted.
} drives_transfer_t;

typedef enum { // Private: commissioning steps and securing, which each bus ends at its own time.
    DRIVES_STEP_NONE,
    DRIVES_STEP_BOOT,
    DRIVES_STEP_CONFIGURE,
    DRIVES_STEP_START,
    DRIVES_STEP_SECURE
} drives_step_t;

typedef struct { // Private.
    canopen_network_t network;
    const descriptor_endnode_t* endnode; // First end node on this bus.
    bool is_done;                        // The bus has completed the step in progress.
} drives_bus_t;

typedef struct { // Private, except activity (read-only) and the axes of the devices.
    subsystem_t* generic;
    void (*abandon)(void* self);
    drives_activity_t activity;
    const flow_resolver_t* resolver;
    drives_bus_t buses[DRIVES_BUSES_MAX];
    uint8_t bus_count;
    drives_step_t step; ///< Step in progress.
    canopen_network_device_t devices[DRIVES_DEVICES_MAX];
    uint8_t device_count;
    canopen_mapping_t mappings[DRIVES_MAPPINGS_MAX];
    uint8_t mapping_count;
    canopen_cia402_goal_t goal;
    /// Configuration that is being applied, or is applied; null: none.
    const descriptor_configuration_t* configuration;
    uint8_t indices[DESCRIPTOR_DEVICES_MAX]; ///< Indices in `devices` of its devices on CAN, in order.
    uint16_t index_count;
    uint64_t called_ns; ///< Last call of drives_configure.
    bool is_written;    ///< The settings are in the devices.
    bool is_closing;
    bool is_borrowed; ///< drives_borrow has opened the buses.
    struct {          // Used by drives_access.c.
        drives_transfer_t slots[DRIVES_ACCESS_SLOTS];
        uint8_t owners[DRIVES_DEVICES_MAX]; // Slot + 1 of the transfer to a device; 0 none.
        uint64_t pulse_end_ns;              // Time at which all pulses have been sent.
    } access;
    struct { // Used by drives_counters.c: addresses of the counters; null: not in the descriptor.
        uint8_t* values[DRIVES_COUNTERS];
        uint8_t* missed;
        uint16_t missed_count;
    } counters;
} drives_t;

/// `abandon` aborts all commanded motions; it is called when the activity changes, and may be null.
void drives_init(drives_t* drives, subsystem_t* generic, const flow_resolver_t* resolver,
                 void (*abandon)(void* self));

/// Open the buses, boot and identify the devices. STATUS_BUSY; STATUS_OK; STATUS_NOT_FOUND (no device, its
/// class, or bus); statuses of canopen_network_add, canopen_network_open and canopen_network_boot.
status_t drives_hardware_init(void* self);
/// Open the buses in order to send frames in a state in which they are closed; the devices keep their NMT
/// states. Statuses of drives_hardware_init, except STATUS_BUSY.
status_t drives_borrow(drives_t* drives);
/// Close the buses if they were borrowed and HARDWARE_INIT was not entered meanwhile.
void drives_give_back(drives_t* drives);
/// Write the settings to the devices and start process data; the axes stay without voltage. Commands of an
/// earlier configuration are cleared; devices that only the earlier one has stay out of operation. Call it in
/// each cycle until it is done: 20 ms without a call end the commissioning, and the next call begins anew.
/// STATUS_BUSY; STATUS_OK; STATUS_NOT_FOUND (device not brought up); STATUS_EXHAUSTED (settings); statuses of
/// canopen_network_configure and _start.
status_t drives_configure(void* self, const descriptor_configuration_t* configuration);
/// Set all axes to standby, resetting their faults, then the activity to PREPARED. STATUS_BUSY; STATUS_OK.
status_t drives_start_control(void* self);
/// Set the activity to RESTING, then switch off the voltage of all axes. STATUS_BUSY; STATUS_OK.
status_t drives_stop_control(void* self);
/// Set all axes into operation, then the activity to ENGAGED. STATUS_BUSY; STATUS_OK.
status_t drives_engage(void* self);
/// Set the activity to PREPARED, then all axes to standby. STATUS_BUSY; STATUS_OK.
status_t drives_disengage(void* self);
/// Set the activity to RESTING, and bring all devices to the safe state, from any condition. STATUS_BUSY;
/// STATUS_OK.
status_t drives_secure(void* self);
/// Set the activity to RESTING, and stop process data. STATUS_OK.
status_t drives_post(void* self);
/// Reset the nodes and close the buses. STATUS_BUSY; STATUS_OK.
status_t drives_hardware_deinit(void* self);
/// Call when the program ends, in any state: close the buses and leave the devices as they are.
void drives_release(void* self);

/// Make channel 0 (A) or 1 (B) of every bus the active one, at once or for the next HARDWARE_INIT, and raise
/// the event CHANNEL_SELECTED. It must be called only where all axes are out of operation. STATUS_OK;
/// STATUS_OUT_OF_RANGE (no such channel, no bus, or a bus without channel B); STATUS_NOT_FOUND (a controller
/// of that channel could not be opened).
status_t drives_select_channel(drives_t* drives, uint8_t channel);

/// Call at the start of a cycle: process received frames and raise an event for each fault.
void drives_sense(void* self);
/// Call at the end of a cycle: send process data, requests and SYNC.
void drives_emit(void* self);

/// Returns device number `position` (0..) of the applied configuration, or null. Stream devices are not
/// counted.
canopen_device_t* drives_device(drives_t* drives, uint16_t position);
/// Note the devices of a configuration for drives_device and drives_missed. Call when it becomes the applied
/// one.
void drives_note_devices(drives_t* drives, const descriptor_configuration_t* configuration);
/// Returns the index in drives->devices of the device with this node id, on any bus; NETWORK_NO_DEVICE if
/// there is none.
uint8_t drives_find(const drives_t* drives, uint32_t node);
/// Returns the network of an end node of the descriptor, while the buses are open.
canopen_network_t* drives_network(drives_t* drives, const descriptor_endnode_t* endnode);
/// True if process data flow on every bus.
bool drives_are_running(const drives_t* drives);
/// Returns the SYNCs that a device of the applied configuration has not answered [wraps]; 0 if there is no
/// such device.
uint32_t drives_missed(const drives_t* drives, uint16_t position);
/// Returns the sum of `limited` (axis.h) of all axes [wraps].
uint32_t drives_limited(const drives_t* drives);

#endif // FSW_DRIVES_DRIVES_H
