// SPDX-License-Identifier: Apache-2.0
/// A CANopen node (CiA 301 slave): NMT, boot-up, heartbeat both ways, SYNC, PDOs, SDO server, emergencies.
/// The application (a drive, a joystick) implements the effect of the objects.
///
/// The node runs in the callbacks of a simulated bus. At SYNC it applies the received RPDOs, then calls
/// `sample` of the application, then queues TPDOs.
///
/// A node may have a second channel (cold redundant): it uses one at a time and follows the heartbeat of the
/// master (0x1016:01) by the rules of object 0x2000. From power-on, from a reset, and from the loss of that
/// heartbeat it changes channel every Ttoggle consumer heartbeat times, at most Ntoggle times; then it stays
/// on its channel. After each change it sends its own heartbeat at once. Bdefault is set to the channel on
/// which the heartbeat was received; an NMT reset keeps it, power-on sets it to the value of the EDS.
///
/// Ownership  node_create allocates, node_destroy frees. The buses outlive the node.
#ifndef SIM_DEVICES_NODE_H
#define SIM_DEVICES_NODE_H

#include "base/status.h"
#include "sim/bus/bus.h"
#include "sim/devices/dictionary.h"
#include "sim/devices/eds.h"
#include "sim/devices/emergency.h"
#include "sim/devices/pdo.h"
#include "sim/devices/sdo.h"

#include <stdbool.h>
#include <stdint.h>

#define NODE_PDOS_MAX 4U
#define NODE_CONSUMERS_MAX 2U
#define NODE_CHANNELS 2U
#define NODE_CHANNEL_A 0U
#define NODE_CHANNEL_B 1U

#define NODE_BOOT_NS 1000000U     ///< From an NMT reset to boot-up; from power-on 10 us x node id longer.
#define NODE_ANSWER_NS 200000U    ///< SDO server's time to answer.
#define NODE_PROCESSING_NS 10000U ///< Time from SYNC until the TPDO is ready.

/// NMT states by their numbers in a heartbeat.
typedef enum {
    NODE_INITIALISING    = 0,
    NODE_STOPPED         = 4,
    NODE_OPERATIONAL     = 5,
    NODE_PRE_OPERATIONAL = 127
} node_state_t;

/// The callbacks of the device. Only `check` and `find` may be null.
typedef struct {
    const char* name; ///< Kind of the device in error messages ("a joint drive"); used only with `find`.
    /// Find the objects that the device needs; node_create has set *out_node before. False: an object is
    /// missing, or the device cannot use its value.
    bool (*find)(void* context);
    /// Update the process values in the objects.
    void (*sample)(void* context, uint64_t now_ns);
    /// An object was written by RPDO or SDO.
    void (*written)(void* context, const object_t* object, uint64_t now_ns);
    /// Returns the abort code for an SDO write, or 0 if it is allowed. May be null.
    uint32_t (*check)(void* context, const object_t* object, int64_t value);
    /// A monitored heartbeat or an RPDO with a deadline is late, the own controller is bus-off, the node
    /// leaves OPERATIONAL, or the master resets its communication; two of these at once give two calls.
    void (*connection_lost)(void* context, uint64_t now_ns);
    /// Set the power-on state; objects have their initial values again.
    void (*reset)(void* context, uint64_t now_ns);
    void* context;
} node_application_t;

typedef struct node node_t;

/// Create a node from its EDS file and connect it to the bus, without power. Returns STATUS_OK; else
/// *out_node is null and `error` is filled: statuses of eds_load, STATUS_EXHAUSTED (memory, nodes of the
/// bus), STATUS_INVALID (an object is missing that every device, or a device of this kind, needs; or a PDO
/// maps an object that a device cannot transfer).
MUST_USE status_t node_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                              const node_application_t* application, node_t** out_node,
                              char error[EDS_ERROR_MAX]);
void node_destroy(node_t* node);

/// Add a channel B to the node, before power-on. Returns STATUS_OK, STATUS_EXHAUSTED (nodes of the bus).
MUST_USE status_t node_add_channel(node_t* node, bus_t* bus);

/// Power on at the present time of the bus: objects to their initial values, boot-up after NODE_BOOT_NS.
void node_power_on(node_t* node);
/// Power off: the node neither sends nor receives from now on; the device is as after a reset until
/// node_power_on. node_unplug, node_plug and node_cut may be called in the meantime.
void node_power_off(node_t* node);
bool node_is_powered(const node_t* node);
/// Disconnect the node from both channels of its bus; it keeps its power, and its deadlines expire.
void node_unplug(node_t* node);
/// Connect the node again, after a power cycle. If it has no power, it stays off.
void node_plug(node_t* node);
bool node_is_plugged(const node_t* node);
/// Disconnect one channel only, or connect it again.
void node_cut(node_t* node, unsigned channel, bool is_cut);

object_t* node_object(const node_t* node, uint16_t index, uint8_t subindex);
/// Member `subindex` of the manufacturer-specific object with this ParameterName in the EDS; 0 for a
/// variable.
object_t* node_object_named(const node_t* node, const char* name, uint8_t subindex);
uint8_t node_id(const node_t* node);
/// Returns the SYNCs received since the node became operational. *out_last_ns is the time of the last one, or
/// the time at which the node became operational if none was received.
uint32_t node_syncs(const node_t* node, uint64_t* out_last_ns);
/// Returns the index of the node on the bus of a channel; BUS_NODES_MAX: it has no such channel.
unsigned node_bus_index(const node_t* node, unsigned channel);

/// An error of the device appears or disappears; the node sends an EMCY if this is a change. `raw`: see
/// emergency_raise.
void node_raise(node_t* node, uint16_t code, uint8_t axis, int32_t raw, uint64_t now_ns);
void node_clear(node_t* node, uint16_t code, uint8_t axis, uint64_t now_ns);
bool node_has_error(const node_t* node, uint16_t code, uint8_t axis);
/// Send the asynchronous TPDOs (types 254, 255) whose values have changed.
void node_event(node_t* node, uint64_t now_ns);

#endif // SIM_DEVICES_NODE_H
