// SPDX-License-Identifier: Apache-2.0
/// Carrier of message frames over TIPC: one datagram for each frame, one socket for each component. The
/// name {mission instance, component} addresses a component, independently of its on-board computer.
///
/// The kernel returns a frame that was not delivered: the frame is counted, and its receiver detects the loss
/// by the sequence numbers. The kernel's topology service reports names that disappear and appear: when the
/// name of a peer appears again, a SYNC is sent at once. These reports are hints only: decisions about a peer
/// depend on its own frames, on the life that they contain, and on heartbeats.
///
/// Ownership  The caller provides message_tipc_carrier_t; the program opens or adopts the sockets.
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
    uint32_t other_senders; ///< Datagrams from a socket that belongs to no peer, dropped.
    /// Frames that the kernel returned, because the receiver had no room or did not exist.
    uint32_t returned;
    uint32_t withdrawn; ///< Times that the name of a peer disappeared.
} message_tipc_carrier_t;

/// `type` is the service type of the mission instance. `watch` is a watch of that type
/// (osal_tipc_watch_open), or null: no hints.
void message_tipc_carrier_init(message_tipc_carrier_t* carrier, osal_socket_t* socket, osal_socket_t* watch,
                               uint32_t type, message_delivery_notice_t notice);
/// Add a peer; `identity` is that of its socket. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t message_tipc_carrier_add_peer(message_tipc_carrier_t* carrier, uint16_t component,
                                                uint64_t identity);
/// Returns the carrier for message_open.
message_carrier_t message_tipc_carrier_port(message_tipc_carrier_t* carrier);
/// Deliver one received datagram to the endpoint, whose inboxes have room for the full window of each peer.
/// STATUS_OK (delivered, or counted as malformed or overrun), STATUS_EMPTY, STATUS_NOT_OURS (dropped: not
/// from a peer, to another life, or too large), STATUS_IO.
MUST_USE status_t message_tipc_carrier_pump(message_tipc_carrier_t* carrier, message_endpoint_t* endpoint);
/// Process the reports of the topology service; send a SYNC to peers whose names appear again.
void message_tipc_carrier_take_hints(message_tipc_carrier_t* carrier, message_endpoint_t* endpoint);

#endif // FSW_FRAMEWORK_MESSAGE_TIPC_CARRIER_H
