// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_udp.h"

#include "base/assertion.h"

#define DATAGRAMS_PER_CALL 64U // Most datagrams that one call skips.

static status_t open_socket(void* const context)
{
    flow_udp_t* const flow = context;
    osal_address_t local   = {0U, 0U};
    status_t status =
        flow_endnode_resolve_socket(flow->resolver, ENDNODE_UDP, flow->setup.local, &local, &flow->counts);
    if (status == STATUS_OK) {
        status = flow_endnode_resolve_socket(flow->resolver, ENDNODE_UDP, flow->setup.peer, &flow->peer,
                                             &flow->counts);
    }
    if (status == STATUS_OK) {
        status = osal_udp_open(&flow->socket, local, flow->setup.receive_octets);
    }
    if (status == STATUS_OK) {
        osal_hand_over_begin(&flow->counts);
    }
    return status;
}

static void close_socket(void* const context)
{
    flow_udp_t* const flow = context;
    osal_socket_close(&flow->socket);
    osal_hand_over_close(&flow->counts);
}

void flow_udp_init(flow_udp_t* const flow, const flow_udp_setup_t* const setup,
                   const flow_resolver_t* const resolver)
{
    static const flow_link_actions_t actions = {open_socket, close_socket};
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (resolver != NULL));
    FSW_ASSERT((setup->local != NULL) && (setup->peer != NULL));
    *flow = (flow_udp_t){.setup = *setup, .resolver = resolver, .socket = OSAL_SOCKET_CLOSED};
    flow_link_init(&flow->link, &actions, flow, setup->quota, setup->retry_first_ns, setup->retry_longest_ns);
}

status_t flow_udp_step(flow_udp_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    return flow_link_step(&flow->link, now_ns);
}

bool flow_udp_is_open(const flow_udp_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    return flow->link.is_open;
}

void flow_udp_close(flow_udp_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    flow_link_close(&flow->link);
}

status_t flow_udp_send(flow_udp_t* const flow, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL));
    status_t status =
        flow_udp_is_open(flow) ? osal_udp_send(&flow->socket, flow->peer, octets, size) : STATUS_CLOSED;
    if (status == STATUS_IO) {
        flow_link_lose(&flow->link, status);
        status = STATUS_CLOSED;
    }
    if (status == STATUS_OK) {
        osal_hand_over_announce(&flow->counts, 1U);
        flow->counters.sent++;
    } else {
        flow->counters.refused++;
    }
    return status;
}

/// Receive the next datagram; in stepped time, wait for one that the sender has announced.
static status_t take_datagram(flow_udp_t* const flow, osal_address_t* const out_from, uint8_t* const octets,
                              const size_t capacity, size_t* const out_size)
{
    status_t status = osal_udp_receive(&flow->socket, out_from, octets, capacity, out_size);
    if ((status == STATUS_EMPTY) && (osal_hand_over_due(&flow->counts) > 0U)) {
        if (osal_socket_wait_readable(&flow->socket, OSAL_HAND_OVER_TIMEOUT_MS) == STATUS_OK) {
            status = osal_udp_receive(&flow->socket, out_from, octets, capacity, out_size);
        } else {
            osal_hand_over_give_up(&flow->counts);
        }
    }
    return status;
}

status_t flow_udp_receive(flow_udp_t* const flow, uint8_t* const octets, const size_t capacity,
                          size_t* const out_size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    for (unsigned i = 0U; flow_udp_is_open(flow) && (i < DATAGRAMS_PER_CALL); i++) {
        osal_address_t from   = {0};
        const status_t status = take_datagram(flow, &from, octets, capacity, out_size);
        if (status == STATUS_TOO_LARGE) {
            osal_hand_over_take(&flow->counts, 1U);
            flow->counters.oversize++;
        } else if (status == STATUS_IO) {
            flow_link_lose(&flow->link, status);
        } else if (status != STATUS_OK) {
            *out_size = 0U;
            return status;
        } else if ((from.ipv4 != flow->peer.ipv4) || (from.port != flow->peer.port)) {
            flow->counters.other_senders++;
        } else {
            osal_hand_over_take(&flow->counts, 1U);
            flow->counters.received++;
            return STATUS_OK;
        }
    }
    *out_size = 0U;
    return flow_udp_is_open(flow) ? STATUS_EMPTY : STATUS_CLOSED;
}

status_t flow_udp_send_record(flow_udp_t* const flow, const flow_record_layout_t* const layout,
                              const void* const record)
{
    FSW_ASSERT(flow != NULL);
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size = 0U;
    const status_t status =
        flow_record_encode(layout, flow->setup.order, record, octets, sizeof octets, &size);
    FSW_ASSERT(status == STATUS_OK);
    return flow_udp_send(flow, octets, size);
}

status_t flow_udp_receive_record(flow_udp_t* const flow, const flow_record_layout_t* const layout,
                                 void* const out_record)
{
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size     = 0U;
    status_t status = flow_udp_receive(flow, octets, sizeof octets, &size);
    if (status == STATUS_OK) {
        status = flow_record_decode(layout, flow->setup.order, octets, size, out_record);
        flow->counters.unfit += (status != STATUS_OK) ? 1U : 0U;
    }
    return status;
}
