// SPDX-License-Identifier: Apache-2.0
/// All CANopen devices of one bus under one master: commissioning, cycle, supervision, safe state.
///
/// A subsystem calls, by state: canopen_network_open and _boot (HARDWARE_INIT); _configure and _start
/// (PRE_OPERATIONAL); _set_goal (SAFE_OPERATIONAL, OPERATIONAL); _secure (ERROR_OPERATIONAL); _stop and
/// _close when it leaves these states. Each cycle begins with _sense and ends with _emit; _take_fault returns
/// faults.
///
/// With two channels (ECSS-E-ST-50-15C) the master sends only on the active one, which _select_channel
/// selects. The controller of the other channel is open and monitored; frames received there are counted and
/// dropped.
///
/// Ownership  The caller provides canopen_network_t and each device; they must not be moved.
/// Context    One task. Never blocks.
/// Time       The caller passes the time. O(devices + frames).
/// Errors     Each function lists its statuses. Those that take several cycles return STATUS_BUSY until done.
#ifndef FSW_CANOPEN_NETWORK_H
#define FSW_CANOPEN_NETWORK_H

#include "fsw/canopen/device.h"
#include "fsw/canopen/master.h"
#include "fsw/canopen/setting.h"
#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/flow_can.h"

#include <stdbool.h>
#include <stdint.h>

#define NETWORK_DEVICES_MAX MASTER_NODES_MAX
#define NETWORK_NO_DEVICE 0xFFU
#define NETWORK_SETTINGS_MAX 32U
/// Room for three faults of each device: lost, faulty, and an emergency.
#define NETWORK_FAULTS_MAX (3U * NETWORK_DEVICES_MAX)
#define NETWORK_CHANNELS 2U
#define NETWORK_CHANNEL_A 0U
#define NETWORK_CHANNEL_B 1U

typedef struct {
    canopen_master_config_t master;
    uint32_t lost_after_syncs; ///< A device that misses this many SYNCs in a row, >= 1, is lost.
    uint64_t selection_ns;     ///< With two channels: longest wait for devices to change to the active one.
    uint64_t boot_retry_ns;    ///< A node that has not booted after this time is reset again.
    /// Process data that have not arrived after this time are reported as missing.
    uint64_t silence_reported_ns;
    uint64_t quick_stop_limit_ns; ///< Longest time of braking before the voltage is switched off.
} canopen_network_config_t;

typedef enum {
    /// The device is silent, has rebooted, or cannot be reached: the controller is off the bus, or no node
    /// acknowledges. Reported once per device and commissioning.
    NETWORK_DEVICE_LOST,
    /// Fault, high-severity emergency, or the drive left operation by itself. Reported once, as above.
    NETWORK_DRIVE_FAULT,
    NETWORK_DRIVE_WARNING,  ///< Medium-severity emergency.
    NETWORK_BUS_WARNING,    ///< Low-severity emergency (node), or a condition of the bus (node 0).
    NETWORK_DEVICE_REFUSED, ///< The device cannot be commissioned: see refusal.
    /// Another node sends SYNC. Reported once, and again after 1 s without a foreign SYNC.
    NETWORK_SYNC_CONFLICT
} canopen_network_fault_kind_t;

/// Why a device is not commissioned; the numbers are those of the event DEVICE_REFUSED.
typedef enum {
    REFUSAL_NONE       = 0,
    REFUSAL_NOT_BOOTED = 1, ///< There is no boot-up message yet; the device is reset again.
    REFUSAL_TIMEOUT    = 2, ///< The device has not answered about `object`, or has booted again meanwhile.
    REFUSAL_ABORTED    = 3, ///< The device refuses access to `object`; detail: its abort code.
    REFUSAL_VALUE      = 4, ///< `object` has a value that is not the expected one; detail: the lower 32 bits.
    REFUSAL_FORMAT     = 5, ///< The answer about `object` has the wrong size, or is against the protocol.
    REFUSAL_REBOOTED   = 6, ///< The device has booted again during commissioning.
    REFUSAL_SILENT     = 7  ///< The device has sent no process data since the start.
} canopen_network_refusal_t;

/// Code of NETWORK_BUS_WARNING of node 0; + 0x100 for channel B.
typedef enum {
    NETWORK_BUS_ERROR_WARNING    = FLOW_CAN_WARNING,
    NETWORK_BUS_ERROR_PASSIVE    = FLOW_CAN_PASSIVE,
    NETWORK_BUS_OFF              = FLOW_CAN_BUS_OFF,
    NETWORK_BUS_OVERRUN          = 4, ///< Frames were received and lost.
    NETWORK_BUS_TRANSMIT_TIMEOUT = 5, ///< A frame could not be sent in time.
    NETWORK_BUS_RESTARTED        = 6, ///< The master's controller is active again after bus-off.
    NETWORK_BUS_MISSING          = 7  ///< The controller of the other channel could not be opened.
} canopen_network_bus_condition_t;
#define NETWORK_BUS_CHANNEL_B 0x100U

typedef struct {
    canopen_network_fault_kind_t kind;
    uint8_t node; ///< 0: the bus.
    /// Emergency code; statusword for a DRIVE_FAULT without emergency; bus condition for a BUS_WARNING of
    /// node 0; otherwise 0.
    uint16_t code;
    canopen_network_refusal_t refusal; ///< Reason of DEVICE_REFUSED; the next two fields belong to it.
    uint32_t object;                   ///< Index << 8 | subindex; 0: none.
    uint32_t detail;
} canopen_network_fault_t;

typedef struct { // device.axes may be used as axis.h says; all else is read-only outside.
    canopen_device_t device;
    bool is_lost;
    bool is_faulty;
    bool is_idle;             ///< The configuration does not use the device: its axes stay out of operation.
    bool is_refusal_reported; ///< NOT_BOOTED or SILENT was reported since the last boot or start.
    uint32_t missed;          ///< SYNCs that the device has not answered [wraps].
    canopen_setting_t settings[NETWORK_SETTINGS_MAX];
    uint16_t setting_count;
} canopen_network_device_t;

typedef struct {   // Sums over the channels [wraps]; flow_can.h explains the counters.
    uint32_t sent; ///< Frames; the next three count frames, too.
    uint32_t received;
    uint32_t refused; ///< Not sent, for any reason.
    uint32_t full;    ///< Refused because the transmit queue was full.
    uint32_t errors;  ///< Error frames.
    uint32_t overruns;
    uint32_t bus_offs;
    uint32_t restarts;
    uint32_t missing_acknowledges;
    uint32_t transmit_timeouts;
    uint32_t lost_arbitrations;
    uint32_t lost; ///< Times that an interface went down or was removed.
} canopen_network_bus_counters_t;

typedef struct { // Private: last checked state of a controller.
    flow_can_state_t state;
    uint32_t overruns;
    uint32_t transmit_timeouts;
    uint32_t bus_offs;
    uint32_t restarts;
    uint64_t overrun_ns; ///< Time of the last loss of frames: continuous loss is reported once.
} canopen_network_conditions_t;

typedef struct { // Private: SYNCs of other nodes at the last check.
    uint32_t count;
    uint64_t time_ns; ///< Time of the last such SYNC; 0: none.
} canopen_network_sync_conflict_t;

typedef enum { // Private.
    NETWORK_RESTING,
    NETWORK_SELECTING, // With two channels: wait until each device has changed to the active one.
    NETWORK_BOOTING,
    NETWORK_IDENTIFYING,
    NETWORK_CONFIGURING,
    NETWORK_STARTING
} canopen_network_phase_t;

typedef struct { // Read-only outside, except the axes of its devices.
    canopen_network_config_t config;
    flow_can_t flows[NETWORK_CHANNELS];
    uint8_t channel;     ///< Number of the active channel.
    flow_can_t* flow;    ///< Flow of the active channel.
    bool is_channel_new; ///< The nodes may not have heard the master on this channel since the last reset.
    canopen_master_t master;
    canopen_network_device_t* devices[NETWORK_DEVICES_MAX]; ///< Provided by the caller.
    uint8_t device_count;
    canopen_network_phase_t phase;
    bool is_standby_missing; ///< The other channel exists, but could not be opened.
    bool is_booted;
    bool is_running; ///< Process data are exchanged.
    bool is_securing;
    uint64_t phase_start_ns;
    uint64_t secure_start_ns;
    bool was_bus_off; ///< The controller of the active channel left the bus since the last cycle.
    canopen_network_sync_conflict_t sync_conflict;
    canopen_network_conditions_t reported[NETWORK_CHANNELS];
    canopen_network_fault_t faults[NETWORK_FAULTS_MAX];
    uint8_t fault_first;
    uint8_t fault_count;
    uint32_t faults_lost; ///< Faults not queued, because the queue was full [wraps].
} canopen_network_t;

/// Initialise as closed, without devices; all counters are zero.
void canopen_network_init(canopen_network_t* network, const canopen_network_config_t* config);
/// Remove all devices. Only while closed.
void canopen_network_clear(canopen_network_t* network);
/// Add a device of a class, in `entry`, which must not be moved until canopen_network_clear. STATUS_OK,
/// STATUS_NOT_FOUND (class), STATUS_EXHAUSTED, STATUS_EXISTS (node), STATUS_INVALID (node id).
MUST_USE status_t canopen_network_add(canopen_network_t* network, canopen_network_device_t* entry,
                                      const char* type, uint8_t node);
/// Returns the index of a node's device; NETWORK_NO_DEVICE if there is none.
uint8_t canopen_network_find(const canopen_network_t* network, uint8_t node);

/// Open both channels; `redundant_bus` is null without channel B. A channel that cannot be opened counts as
/// absent, unless it is the active one. Statuses of flow_can_open; STATUS_NOT_FOUND also: channel B is the
/// active one, and `redundant_bus` is null.
MUST_USE status_t canopen_network_open(canopen_network_t* network, const flow_resolver_t* resolver,
                                       const char* bus, const char* redundant_bus);
/// True if the network is closed, or has the channel: 0 or 1.
bool canopen_network_has_channel(const canopen_network_t* network, uint8_t channel);
/// Make a channel the active one. Open: process data stop, and every device has to be commissioned again.
/// Closed: the next canopen_network_open uses the channel. STATUS_OK; STATUS_OUT_OF_RANGE (no such channel);
/// STATUS_NOT_FOUND (open, but without that channel).
status_t canopen_network_select_channel(canopen_network_t* network, uint8_t channel);
/// A process before this one may have been the master on the other channel: the next reset of the nodes
/// follows a heartbeat on the active channel, as after canopen_network_select_channel.
void canopen_network_doubt_channel(canopen_network_t* network);
/// Add the counters of both channels to a sum.
void canopen_network_add_counters(const canopen_network_t* network, canopen_network_bus_counters_t* sum);
/// Reset all nodes, wait for the boot-up message of each, and identify it. With two channels, the master's
/// heartbeat first makes the devices change to the active one. STATUS_BUSY; STATUS_OK; STATUS_CLOSED (not
/// open, or a node has booted again meanwhile); statuses of canopen_device_identify_step. If a device causes
/// the failure of this function or of canopen_network_configure, or delays this function or
/// canopen_network_start, canopen_network_take_fault returns it and the reason as DEVICE_REFUSED.
status_t canopen_network_boot(canopen_network_t* network, uint64_t now_ns);

/// Set the number of consecutive SYNCs, >= 1, after which a device that has not answered is lost.
void canopen_network_set_lost_after(canopen_network_t* network, uint32_t syncs);
/// Remove the settings of all devices; call it before canopen_network_set. Each device is then idle until
/// canopen_network_include: it is supervised, but its axes stay out of operation, whatever the goal.
void canopen_network_clear_settings(canopen_network_t* network);
/// Let a device take part in the configuration.
void canopen_network_include(canopen_network_t* network, uint8_t index);
/// Append a setting for a device. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t canopen_network_set(canopen_network_t* network, uint8_t index,
                                      const canopen_setting_t* setting);
/// Stop process data, if they flow, and write the settings. STATUS_BUSY; STATUS_OK; STATUS_CLOSED (not
/// booted); statuses of canopen_setting_run_step.
status_t canopen_network_configure(canopen_network_t* network, uint64_t now_ns);
/// Start process data and SYNC with the goal DISABLED, and wait, however long, until each device answers.
/// STATUS_BUSY; STATUS_OK; STATUS_CLOSED (not booted); statuses of canopen_device_connect.
status_t canopen_network_start(canopen_network_t* network, uint64_t now_ns);
/// Abort the functions above, stop process data, and set the devices to PRE-OPERATIONAL.
void canopen_network_stop(canopen_network_t* network);
/// Stop as canopen_network_stop does, then reset all nodes. The frame needs a cycle on the bus before
/// canopen_network_close.
void canopen_network_reset_nodes(canopen_network_t* network);
/// Close both channels. Devices and counters remain; faults that were not taken are dropped.
void canopen_network_close(canopen_network_t* network);

/// Call at the start of a cycle: process received frames, monitor devices.
void canopen_network_sense(canopen_network_t* network, uint64_t now_ns);
/// Send the SYNC of this cycle before the process data (canopen_master_send_sync).
void canopen_network_send_sync(canopen_network_t* network);
/// Call at the end of a cycle: send process data, requests, and SYNC if it is not sent yet.
void canopen_network_emit(canopen_network_t* network, uint64_t now_ns);
/// Set the goal of all axes; axes of idle devices get the goal DISABLED.
void canopen_network_set_goal(canopen_network_t* network, canopen_cia402_goal_t goal, bool may_reset_faults);
/// True if every axis of every device that is not lost has reached its goal, and process data are exchanged.
bool canopen_network_is_at_goal(const canopen_network_t* network);
/// Set all outputs to 0, and take all axes that can be reached out of operation: quick stop, then voltage
/// off. A lost device does both by itself, and so does each device while no process data are exchanged:
/// STATUS_OK at once. STATUS_BUSY; STATUS_OK. Safe to call in any condition; call again each cycle until
/// STATUS_OK.
status_t canopen_network_secure(canopen_network_t* network, uint64_t now_ns);

/// Take the oldest fault. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t canopen_network_take_fault(canopen_network_t* network, canopen_network_fault_t* out_fault);

#endif // FSW_CANOPEN_NETWORK_H
