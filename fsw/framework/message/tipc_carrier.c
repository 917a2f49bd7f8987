// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/tipc_carrier.h"

#include "base/assertion.h"

void message_tipc_carrier_init(message_tipc_carrier_t* const carrier, osal_socket_t* const socket,
                               osal_socket_t* const watch, const uint32_t type,
                               const message_delivery_notice_t notice)
{
    FSW_ASSERT((carrier != NULL) && (socket != NULL) && (notice.delivered != NULL));
    *carrier = (message_tipc_carrier_t){.socket = socket, .watch = watch, .type = type, .notice = notice};
}

status_t message_tipc_carrier_add_peer(message_tipc_carrier_t* const carrier, const uint16_t component,
                                       const uint64_t identity)
{
    FSW_ASSERT(carrier != NULL);
    if (carrier->peer_count == MESSAGE_PEERS_MAX) {
        return STATUS_EXHAUSTED;
    }
    carrier->peers[carrier->peer_count].component    = component;
    carrier->peers[carrier->peer_count].is_withdrawn = false;
    carrier->peers[carrier->peer_count].identity     = identity;
    carrier->peer_count++;
    return STATUS_OK;
}

static status_t send_datagram(void* const context, const uint16_t to, const uint8_t* const frame,
                              const size_t size)
{
    message_tipc_carrier_t* const carrier = (message_tipc_carrier_t*)context;
    const osal_tipc_name_t name           = {carrier->type, to};
    const status_t status                 = osal_tipc_send(carrier->socket, name, frame, size);
    if (status == STATUS_OK) {
        carrier->notice.delivered(carrier->notice.context, to);
    }
    return status;
}

message_carrier_t message_tipc_carrier_port(message_tipc_carrier_t* const carrier)
{
    FSW_ASSERT(carrier != NULL);
    return (message_carrier_t){.context = carrier, .send = send_datagram};
}

static bool is_peer(const message_tipc_carrier_t* const carrier, const uint64_t identity)
{
    for (size_t i = 0U; i < carrier->peer_count; i++) {
        if (carrier->peers[i].identity == identity) {
            return true;
        }
    }
    return false;
}

status_t message_tipc_carrier_pump(message_tipc_carrier_t* const carrier, message_endpoint_t* const endpoint)
{
    FSW_ASSERT((carrier != NULL) && (endpoint != NULL));
    uint64_t from   = 0U;
    size_t size     = 0U;
    status_t status = STATUS_FORBIDDEN;
    // The socket also receives frames of this component that the kernel could not deliver. They were not
    // announced to this component, so they must not count as the datagram of this call: skip them.
    while (status == STATUS_FORBIDDEN) {
        status = osal_tipc_receive(carrier->socket, &from, endpoint->frame, sizeof endpoint->frame, &size);
        carrier->returned += (status == STATUS_FORBIDDEN) ? 1U : 0U;
    }
    if (status != STATUS_OK) {
        return message_accept(endpoint, status, 0U);
    }
    if (!is_peer(carrier, from)) {
        carrier->other_senders++;
        return STATUS_NOT_OURS;
    }
    return message_accept(endpoint, STATUS_OK, size);
}

void message_tipc_carrier_take_hints(message_tipc_carrier_t* const carrier,
                                     message_endpoint_t* const endpoint)
{
    FSW_ASSERT((carrier != NULL) && (endpoint != NULL));
    osal_tipc_event_t event = {false, 0U};
    while ((carrier->watch != NULL) && osal_socket_is_open(carrier->watch) &&
           (osal_tipc_watch_next(carrier->watch, &event) == STATUS_OK)) {
        for (size_t i = 0U; i < carrier->peer_count; i++) {
            if (carrier->peers[i].component != event.instance) {
                continue;
            }
            // While the name was withdrawn, frames to the peer may have been lost.
            if (event.is_published && carrier->peers[i].is_withdrawn) {
                message_probe(endpoint, carrier->peers[i].component);
            }
            carrier->withdrawn += (!event.is_published && !carrier->peers[i].is_withdrawn) ? 1U : 0U;
            carrier->peers[i].is_withdrawn = !event.is_published;
        }
    }
}
