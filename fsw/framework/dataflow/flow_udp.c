// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_udp.h"

#include "fsw/framework/base/assertion.h"

#define DATAGRAMS_PER_CALL 64U // Passed over at most before the caller gets its turn back.

void flow_udp_init(flow_udp_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    *flow = (flow_udp_t){.socket = OSAL_SOCKET_CLOSED};
}

status_t flow_udp_open(flow_udp_t* const flow, const flow_resolver_t* const resolver, const char* const local,
                       const char* const peer, const size_t receive_octets)
{
    FSW_ASSERT((flow != NULL) && (resolver != NULL) && (local != NULL) && (peer != NULL));
    if (osal_socket_is_open(&flow->socket)) {
        return STATUS_EXISTS;
    }
    osal_address_t address;
    status_t status = endnode_resolve_socket(resolver, ENDNODE_UDP, local, &address);
    if (status == STATUS_OK) {
        status = endnode_resolve_socket(resolver, ENDNODE_UDP, peer, &flow->peer);
    }
    return (status == STATUS_OK) ? osal_udp_open(&flow->socket, address, receive_octets) : status;
}

void flow_udp_close(flow_udp_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (osal_socket_is_open(&flow->socket)) {
        osal_socket_close(&flow->socket);
    }
}

status_t flow_udp_send(flow_udp_t* const flow, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL));
    const status_t status = osal_socket_is_open(&flow->socket)
                                ? osal_udp_send(&flow->socket, flow->peer, octets, size)
                                : STATUS_CLOSED;
    if (status == STATUS_OK) {
        flow->counters.sent++;
    } else {
        flow->counters.refused++;
    }
    return status;
}

status_t flow_udp_receive(flow_udp_t* const flow, uint8_t* const octets, const size_t capacity,
                          size_t* const out_size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (!osal_socket_is_open(&flow->socket)) {
        return STATUS_CLOSED;
    }
    for (unsigned i = 0U; i < DATAGRAMS_PER_CALL; i++) {
        osal_address_t from   = {0};
        const status_t status = osal_udp_receive(&flow->socket, &from, octets, capacity, out_size);
        if (status == STATUS_TOO_LARGE) {
            flow->counters.oversize++;
        } else if (status != STATUS_OK) {
            *out_size = 0U;
            return status;
        } else if ((from.ipv4 != flow->peer.ipv4) || (from.port != flow->peer.port)) {
            flow->counters.foreign++;
        } else {
            flow->counters.received++;
            return STATUS_OK;
        }
    }
    *out_size = 0U;
    return STATUS_EMPTY;
}
