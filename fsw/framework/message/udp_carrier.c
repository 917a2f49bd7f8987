// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/udp_carrier.h"

#include "base/assertion.h"

void message_udp_carrier_init(message_udp_carrier_t* const carrier, osal_socket_t* const socket,
                              const message_delivery_notice_t notice)
{
    FSW_ASSERT((carrier != NULL) && (socket != NULL) && (notice.delivered != NULL));
    *carrier = (message_udp_carrier_t){.socket = socket, .notice = notice};
}

status_t message_udp_carrier_add_peer(message_udp_carrier_t* const carrier, const uint16_t component,
                                      const osal_address_t address)
{
    FSW_ASSERT(carrier != NULL);
    if (carrier->peer_count == MESSAGE_PEERS_MAX) {
        return STATUS_EXHAUSTED;
    }
    carrier->peers[carrier->peer_count].component = component;
    carrier->peers[carrier->peer_count].address   = address;
    carrier->peer_count++;
    return STATUS_OK;
}

static status_t send_datagram(void* const context, const uint16_t to, const uint8_t* const frame,
                              const size_t size)
{
    message_udp_carrier_t* const carrier = (message_udp_carrier_t*)context;
    for (size_t i = 0U; i < carrier->peer_count; i++) {
        if (carrier->peers[i].component == to) {
            const status_t status = osal_udp_send(carrier->socket, carrier->peers[i].address, frame, size);
            if (status == STATUS_OK) {
                carrier->notice.delivered(carrier->notice.context, to);
            }
            return status;
        }
    }
    return STATUS_NOT_FOUND;
}

message_carrier_t message_udp_carrier_port(message_udp_carrier_t* const carrier)
{
    FSW_ASSERT(carrier != NULL);
    return (message_carrier_t){.context = carrier, .send = send_datagram};
}

static bool is_peer(const message_udp_carrier_t* const carrier, const osal_address_t from)
{
    for (size_t i = 0U; i < carrier->peer_count; i++) {
        const osal_address_t peer = carrier->peers[i].address;
        if ((peer.ipv4 == from.ipv4) && (peer.port == from.port)) {
            return true;
        }
    }
    return false;
}

status_t message_udp_carrier_pump(message_udp_carrier_t* const carrier, message_endpoint_t* const endpoint)
{
    FSW_ASSERT((carrier != NULL) && (endpoint != NULL));
    osal_address_t from = {0U, 0U};
    size_t size         = 0U;
    const status_t status =
        osal_udp_receive(carrier->socket, &from, endpoint->frame, sizeof endpoint->frame, &size);
    if (status != STATUS_OK) {
        return message_accept(endpoint, status, 0U);
    }
    if (!is_peer(carrier, from)) {
        carrier->other_senders++;
        return STATUS_NOT_OURS;
    }
    return message_accept(endpoint, STATUS_OK, size);
}
