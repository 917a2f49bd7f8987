// SPDX-License-Identifier: Apache-2.0
/// Internal data of a node, shared by node.c (power, NMT, SDO, heartbeat), node_process.c (SYNC and PDOs) and
/// node_channel.c (redundancy).
#ifndef SIM_DEVICES_NODE_INTERNAL_H
#define SIM_DEVICES_NODE_INTERNAL_H

#include "sim/devices/node.h"

typedef struct {
    object_t* entry;      ///< 0x1016:k, node id << 16 | time [ms].
    uint64_t deadline_ns; ///< BUS_NEVER: no heartbeat was received yet.
} heartbeat_consumer_t;

typedef struct {
    bus_t* bus; ///< Null: the node has no such channel.
    unsigned index;
    bool is_cut;
} node_channel_t;

struct node {
    bus_t* bus; ///< Bus of the active channel.
    unsigned bus_index;
    node_channel_t channel[NODE_CHANNELS];
    unsigned active;
    /// 0x2000:01 Bdefault; the next three are :02 Ttoggle, :03 Ntoggle, :04 Ctoggle. Each may be null.
    object_t* default_channel;
    object_t* toggle_factor;
    object_t* toggle_limit;
    object_t* toggle_count;
    uint64_t toggle_ns; ///< Next change of channel; BUS_NEVER: no search.
    uint8_t id;
    bool is_plugged;
    bool is_powered;
    node_application_t application;
    dictionary_t dictionary;
    emergencies_t emergencies;
    node_state_t state;
    uint64_t boot_ns;
    uint64_t wake_ns; ///< Value passed to bus_set_wake.

    uint32_t syncs; ///< Received since the node became operational.
    uint64_t last_sync_ns;
    object_t* sync_cob;
    object_t* sync_counter; ///< 0x1019
    uint32_t sync_id;       ///< Copy of the identifier in 0x1005.
    unsigned receive_count;
    unsigned transmit_count;
    pdo_t receive[NODE_PDOS_MAX];
    pdo_t transmit[NODE_PDOS_MAX];

    object_t* emergency_cob;
    object_t* producer_time; ///< 0x1017
    object_t* error_behaviour;
    uint64_t heartbeat_ns; ///< Time at which the next heartbeat is sent.
    heartbeat_consumer_t consumer[NODE_CONSUMERS_MAX];

    sdo_server_t sdo;
    bool has_answer;
    uint64_t answer_ns;
    uint8_t answer[SDO_OCTETS];
    uint64_t request_ns; ///< Time of the SDO request being served.
};

/// node.c:
void node_send(node_t* node, uint32_t id, const uint8_t* data, uint8_t length, uint64_t time_ns);
/// Make sure that the bus wakes the node at `time_ns` at the latest.
void node_wake_by(node_t* node, uint64_t time_ns);

/// node_channel.c
void node_find_channels(node_t* node);
status_t node_connect_redundant(node_t* node, bus_t* bus, const bus_callbacks_t* callbacks);
/// Plug in or unplug the connector of both channels.
void node_connect(node_t* node, bool is_plugged);
/// Power both channels on or off.
void node_supply(node_t* node, bool is_powered);
/// Change to the channel of Bdefault, and begin to search for the master.
void node_select_default_channel(node_t* node, uint64_t now_ns);
/// Stop the search: the heartbeat of the master was received.
void node_master_heard(node_t* node);
/// Begin the search: the heartbeat time of the master has expired.
void node_master_lost(node_t* node, uint64_t now_ns);
/// Change the channel if the change is due. Returns the time of the next change.
uint64_t node_run_search(node_t* node, uint64_t now_ns);

/// node_process.c
bool node_find_pdos(node_t* node);
/// Read the changed PDO parameters from the objects, and discard received RPDOs.
void node_configure_pdos(node_t* node);
/// Start the PDOs (OPERATIONAL entered), or stop them.
void node_start_pdos(node_t* node, uint64_t now_ns);
void node_stop_pdos(node_t* node);
void node_take_sync(node_t* node, const osal_can_frame_t* frame);
/// True if the identifier is that of an RPDO of this node.
bool node_take_pdo(node_t* node, const osal_can_frame_t* frame);
/// Run deadlines and event timers. Returns the time at which the next one expires.
uint64_t node_run_pdo_timers(node_t* node, uint64_t now_ns);

#endif // SIM_DEVICES_NODE_INTERNAL_H
