// SPDX-License-Identifier: Apache-2.0
/// Carrier of message frames inside one program: a frame is copied into the inbox of the addressed endpoint.
///
/// Ownership  The caller provides the carrier; endpoints outlive it.
/// Context    One task runs all components.
#ifndef FSW_FRAMEWORK_MESSAGE_RING_CARRIER_H
#define FSW_FRAMEWORK_MESSAGE_RING_CARRIER_H

#include "base/status.h"
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/udp_carrier.h"

#include <stddef.h>
#include <stdint.h>

typedef struct { // Private.
    message_endpoint_t* endpoints[MESSAGE_PEERS_MAX];
    size_t endpoint_count;
    message_delivery_notice_t notice;
} message_ring_carrier_t;

void message_ring_carrier_init(message_ring_carrier_t* carrier, message_delivery_notice_t notice);
/// Make an opened endpoint reachable. STATUS_OK (also if it was attached before), STATUS_EXHAUSTED.
MUST_USE status_t message_ring_carrier_attach(message_ring_carrier_t* carrier, message_endpoint_t* endpoint);
/// Returns the carrier for message_open.
message_carrier_t message_ring_carrier_port(message_ring_carrier_t* carrier);

#endif // FSW_FRAMEWORK_MESSAGE_RING_CARRIER_H
