// SPDX-License-Identifier: Apache-2.0
/// Carrier of message frames over TIPC: one datagram a frame, one socket a component, each addressed by the
/// name {mission instance, component}, independent of its on-board computer.
///
/// A returned frame was never taken: it is counted, and the sequence numbers show its receiver the loss. The
/// kernel's topology service reports names that disappear and appear: when the name of a peer appears again,
/// a SYNC is sent at once. Decisions about a peer use only its own reports: its epoch, its heartbeat.
///
/// Ownership  The caller places it; the sockets are opened or adopted by the program.
/// Context    One task.
#ifndef FSW_FRAMEWORK_MESSAGE_TIPC_CARRIER_H
#define FSW_FRAMEWORK_MESSAGE_TIPC_CARRIER_H

#include "base/status.h"
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/udp_carrier.h"
#include "osal/include/osal/socket.h"
#include "osal/include/osal/tipc.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct { // Private, except the counters.
    osal_socket_t* socket;
    osal_socket_t* watch;
    uint32_t type;
    struct {
        uint16_t component;
        bool is_withdrawn;
        uint64_t identity;
    } peers[MESSAGE_PEERS_MAX];
    size_t peer_count;
    message_delivery_notice_t notice;
    uint32_t other_senders; ///< Datagrams of a socket that is no peer's, dropped.
    uint32_t returned;      ///< Returned frames: no room at the receiver, or no receiver.
    uint32_t withdrawn;     ///< Times that the name of a peer disappeared.
} message_tipc_carrier_t;

/// `type`: service type of the mission instance. `watch` of that type (osal_tipc_watch_open), or null: no
/// hints.
void message_tipc_carrier_init(message_tipc_carrier_t* carrier, osal_socket_t* socket, osal_socket_t* watch,
                               uint32_t type, message_delivery_notice_t notice);
/// `identity` of the peer's socket. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t message_tipc_carrier_add_peer(message_tipc_carrier_t* carrier, uint16_t component,
                                                uint64_t identity);
/// The carrier in the form an endpoint takes.
message_carrier_t message_tipc_carrier_port(message_tipc_carrier_t* carrier);
/// Deliver one received datagram to the endpoint, whose inboxes hold the full windows of its real peers.
/// STATUS_OK, STATUS_EMPTY, STATUS_NOT_OURS (dropped: not from a peer, or to another life), STATUS_IO.
MUST_USE status_t message_tipc_carrier_pump(message_tipc_carrier_t* carrier, message_endpoint_t* endpoint);
/// Process the notices of the topology service; send a SYNC to peers that appear again.
void message_tipc_carrier_take_hints(message_tipc_carrier_t* carrier, message_endpoint_t* endpoint);

#endif // FSW_FRAMEWORK_MESSAGE_TIPC_CARRIER_H
