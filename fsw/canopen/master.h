// SPDX-License-Identifier: Apache-2.0
/// CiA 301 master of one bus: NMT, SYNC, heartbeats in both directions, boot-up, SDO clients, emergencies,
/// and the distribution of process data.
///
/// Once per cycle: canopen_master_receive processes received frames; the owner computes and sends its process
/// data; canopen_master_emit sends SDO requests and the heartbeat, and SYNC as the last frame. If
/// canopen_master_send_sync was called before in this cycle, SYNC is the first frame instead. The bus is not
/// trusted: every unexpected or malformed frame is counted and dropped.
///
/// Ownership  The caller provides canopen_master_t; the flow is borrowed.
/// Context    One task. Never blocks.
/// Time       The caller passes the time. O(frames received + nodes).
/// Errors     Each function lists its statuses.
#ifndef FSW_CANOPEN_MASTER_H
#define FSW_CANOPEN_MASTER_H

#include "fsw/canopen/cob.h"
#include "fsw/canopen/emergency.h"
#include "fsw/canopen/sdo_client.h"
#include "base/status.h"
#include "fsw/framework/dataflow/flow_can.h"

#include <stdbool.h>
#include <stdint.h>

#define MASTER_NODES_MAX 16U
#define MASTER_REQUESTS_MAX 8U                    ///< SDO requests of one bus that may wait for answers.
#define MASTER_ROUTES_MAX (2U * MASTER_NODES_MAX) ///< Transmit PDOs of all nodes.
#define MASTER_EMERGENCIES_MAX MASTER_NODES_MAX
#define MASTER_FRAMES_PER_CYCLE 512U ///< Further frames wait for the next cycle.

typedef struct {
    uint8_t node_id;               ///< Id of the master, 1..127.
    uint64_t heartbeat_ns;         ///< Period of the master's heartbeat.
    uint64_t heartbeat_timeout_ns; ///< Longest time between two heartbeats of a node.
    uint64_t sdo_timeout_ns;
} canopen_master_config_t;

/// Function that receives one frame of process data.
typedef void (*canopen_master_taker_t)(void* context, uint16_t cob, const uint8_t* octets, uint8_t length);

typedef struct { // Read-only outside.
    uint8_t id;
    /// A heartbeat or boot-up message was received since the node was added, or was reset by the master.
    bool has_heartbeat;
    bool is_heartbeat_lost;
    uint32_t boots;    ///< Boot-up messages since the node was added.
    uint64_t heard_ns; ///< Time of its last heartbeat or boot-up message.
    canopen_sdo_client_t sdo;
} canopen_master_node_t;

typedef struct { // Private.
    uint16_t cob;
    canopen_master_taker_t take;
    void* context;
} canopen_master_route_t;

typedef struct {                // All counters wrap.
    uint32_t unknown;           ///< Data frames that no receiver expects.
    uint32_t malformed;         ///< Heartbeats and emergencies of a wrong length, unknown NMT states.
    uint32_t remote;            ///< Remote frames.
    uint32_t conflicting_syncs; ///< SYNCs of other nodes: this master is the only producer.
    uint32_t refused;           ///< Frames to be sent that the flow refused.
    uint32_t emergencies;       ///< Emergencies stored for canopen_master_take_emergency.
    uint32_t emergencies_lost;  ///< Emergencies not stored, because the queue was full.
} canopen_master_counters_t;

typedef struct { // Private, except nodes, sync_count and counters: read-only.
    canopen_master_config_t config;
    flow_can_t* flow;
    canopen_master_node_t nodes[MASTER_NODES_MAX];
    uint8_t node_count;
    canopen_master_route_t routes[MASTER_ROUTES_MAX];
    uint8_t route_count;
    canopen_emergency_t emergencies[MASTER_EMERGENCIES_MAX];
    uint8_t emergency_first;
    uint8_t emergency_count;
    bool is_sync_on;
    bool is_sync_sent;   ///< SYNC of this cycle was sent before the process data.
    uint32_t sync_count; ///< SYNCs sent [wraps].
    uint64_t next_heartbeat_ns;
    canopen_master_counters_t counters;
} canopen_master_t;

/// Start without nodes and routes, and without SYNC. The counters are zero.
void canopen_master_init(canopen_master_t* master, const canopen_master_config_t* config, flow_can_t* flow);
/// Remove nodes, routes and emergencies, and stop SYNC; the heartbeat is due at once. The counters keep their
/// values.
void canopen_master_clear(canopen_master_t* master);

/// Send and receive on another channel from now on; the heartbeat is due at once.
void canopen_master_use_flow(canopen_master_t* master, flow_can_t* flow);

/// Monitor a node. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED, STATUS_INVALID (no node id, or the master's).
MUST_USE status_t canopen_master_add_node(canopen_master_t* master, uint8_t id, uint8_t* out_index);
/// Let canopen_master_receive pass each frame with the identifier `cob` to `take`. STATUS_OK, STATUS_EXISTS,
/// STATUS_EXHAUSTED.
MUST_USE status_t canopen_master_route(canopen_master_t* master, uint16_t cob, canopen_master_taker_t take,
                                       void* context);
/// Remove the route of an identifier, if there is one.
void canopen_master_unroute(canopen_master_t* master, uint16_t cob);

/// Process all received frames, and monitor heartbeats.
void canopen_master_receive(canopen_master_t* master, uint64_t now_ns);
/// Send an NMT command to node `id`, or to all nodes (0). NMT_RESET_NODE also ends the SDO transfer of the
/// node and the monitoring of its heartbeat. STATUS_OK, STATUS_FULL, STATUS_CLOSED.
status_t canopen_master_command(canopen_master_t* master, uint8_t id, canopen_nmt_command_t command);
/// Send one frame of process data. STATUS_OK, STATUS_FULL, STATUS_CLOSED (also while no node acknowledges).
status_t canopen_master_send_process_data(canopen_master_t* master, uint16_t cob, const uint8_t* octets,
                                          uint8_t length);
void canopen_master_set_sync(canopen_master_t* master, bool is_on);
/// Send the SYNC of this cycle now, before the process data; canopen_master_emit then sends none.
void canopen_master_send_sync(canopen_master_t* master);
/// End of the cycle: send SDO requests, the heartbeat if it is due, and SYNC. While no node acknowledges, the
/// controller repeats one frame, and nothing else is sent: a device that is connected later must not receive
/// old commands. Sending continues after a frame of any node was received.
void canopen_master_emit(canopen_master_t* master, uint64_t now_ns);

/// Take the oldest stored emergency. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t canopen_master_take_emergency(canopen_master_t* master, canopen_emergency_t* out_emergency);

#endif // FSW_CANOPEN_MASTER_H
