// SPDX-License-Identifier: Apache-2.0
/// Carrier of message frames over UDP: one datagram for each frame, one socket for each component.
///
/// Ownership  The caller provides message_udp_carrier_t; the program opens or adopts the socket.
/// Context    One task.
#ifndef FSW_FRAMEWORK_MESSAGE_UDP_CARRIER_H
#define FSW_FRAMEWORK_MESSAGE_UDP_CARRIER_H

#include "base/status.h"
#include "fsw/framework/message/message.h"
#include "osal/include/osal/socket.h"

#include <stddef.h>
#include <stdint.h>

/// Callback after each frame that was sent to a component; the program announces the frame to the scheduler.
typedef struct {
    void* context;
    void (*delivered)(void* context, uint16_t to);
} message_delivery_notice_t;

typedef struct { // Private, except the counters.
    osal_socket_t* socket;
    struct {
        uint16_t component;
        osal_address_t address;
    } peers[MESSAGE_PEERS_MAX];
    size_t peer_count;
    message_delivery_notice_t notice;
    uint32_t other_senders; ///< Datagrams from an address that belongs to no peer, dropped.
} message_udp_carrier_t;

void message_udp_carrier_init(message_udp_carrier_t* carrier, osal_socket_t* socket,
                              message_delivery_notice_t notice);
/// Add a peer with its address. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t message_udp_carrier_add_peer(message_udp_carrier_t* carrier, uint16_t component,
                                               osal_address_t address);
/// Returns the carrier for message_open.
message_carrier_t message_udp_carrier_port(message_udp_carrier_t* carrier);
/// Deliver one received datagram to the endpoint, whose inboxes have room for the full window of each peer.
/// STATUS_OK (delivered, or counted as malformed or overrun), STATUS_EMPTY, STATUS_NOT_OURS (dropped: not
/// from a peer, to another life, or too large), STATUS_IO.
MUST_USE status_t message_udp_carrier_pump(message_udp_carrier_t* carrier, message_endpoint_t* endpoint);

#endif // FSW_FRAMEWORK_MESSAGE_UDP_CARRIER_H
