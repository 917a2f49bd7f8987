// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_mqueue.h"

#include "base/assertion.h"

#include <string.h>

static status_t open_queue(void* const context)
{
    flow_mqueue_t* const flow = context;
    flow_endnode_address_t address;
    status_t status = flow_endnode_resolve(flow->resolver, ENDNODE_MQUEUE, flow->setup.name, &address);
    if (status != STATUS_OK) {
        return status;
    }
    (void)memcpy(flow->address, address.address, sizeof flow->address);
    if (flow->setup.is_receiver) {
        // Remove a queue that a predecessor has left; usually there is none.
        (void)osal_mqueue_remove(flow->address);
        return osal_mqueue_create(&flow->queue, flow->address, flow->setup.depth, flow->setup.message_octets);
    }
    status = osal_mqueue_open(&flow->queue, flow->address);
    if ((status == STATUS_OK) && (osal_mqueue_message_octets(&flow->queue) < flow->setup.message_octets)) {
        return STATUS_INVALID;
    }
    return status;
}

static void close_queue(void* const context)
{
    osal_mqueue_close(&((flow_mqueue_t*)context)->queue);
}

void flow_mqueue_init(flow_mqueue_t* const flow, const flow_mqueue_setup_t* const setup,
                      const flow_resolver_t* const resolver)
{
    static const flow_link_actions_t actions = {open_queue, close_queue};
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (resolver != NULL) && (setup->name != NULL));
    FSW_ASSERT((setup->message_octets >= 1U) && (!setup->is_receiver || (setup->depth >= 1U)));
    *flow = (flow_mqueue_t){.setup = *setup, .resolver = resolver};
    flow_link_init(&flow->link, &actions, flow, setup->quota, setup->retry_first_ns, setup->retry_longest_ns);
}

status_t flow_mqueue_step(flow_mqueue_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    return flow_link_step(&flow->link, now_ns);
}

status_t flow_mqueue_send(flow_mqueue_t* const flow, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((flow != NULL) && ((octets != NULL) || (size == 0U)));
    status_t status = STATUS_CLOSED;
    if (flow_mqueue_is_open(flow)) {
        status = (size <= flow->setup.message_octets) ? osal_mqueue_send(&flow->queue, octets, size)
                                                      : STATUS_TOO_LARGE;
        if ((status == STATUS_CLOSED) || (status == STATUS_IO)) {
            flow_link_lose(&flow->link, status);
            status = STATUS_CLOSED;
        }
    }
    if (status == STATUS_OK) {
        flow->counters.sent++;
    } else {
        flow->counters.refused++;
    }
    return status;
}

status_t flow_mqueue_receive(flow_mqueue_t* const flow, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (capacity >= flow->setup.message_octets) &&
               (out_size != NULL));
    *out_size = 0U;
    if (!flow_mqueue_is_open(flow)) {
        return STATUS_CLOSED;
    }
    const status_t status = osal_mqueue_receive(&flow->queue, octets, capacity, out_size);
    if (status == STATUS_OK) {
        flow->counters.received++;
        return STATUS_OK;
    }
    if (status == STATUS_EMPTY) {
        return STATUS_EMPTY;
    }
    flow_link_lose(&flow->link, status);
    return STATUS_CLOSED;
}

status_t flow_mqueue_send_record(flow_mqueue_t* const flow, const flow_record_layout_t* const layout,
                                 const void* const record)
{
    FSW_ASSERT(flow != NULL);
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size = 0U;
    const status_t status =
        flow_record_encode(layout, flow->setup.order, record, octets, sizeof octets, &size);
    FSW_ASSERT(status == STATUS_OK);
    return flow_mqueue_send(flow, octets, size);
}

status_t flow_mqueue_receive_record(flow_mqueue_t* const flow, const flow_record_layout_t* const layout,
                                    void* const out_record)
{
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size     = 0U;
    status_t status = flow_mqueue_receive(flow, octets, sizeof octets, &size);
    if (status == STATUS_OK) {
        status = flow_record_decode(layout, flow->setup.order, octets, size, out_record);
        flow->counters.unfit += (status != STATUS_OK) ? 1U : 0U;
    }
    return status;
}

bool flow_mqueue_is_open(const flow_mqueue_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    return flow->link.is_open;
}

void flow_mqueue_close(flow_mqueue_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    const bool was_open = flow_mqueue_is_open(flow);
    flow_link_close(&flow->link);
    if (was_open && flow->setup.is_receiver) {
        (void)osal_mqueue_remove(flow->address); // Fails if another receiver has removed it already.
    }
}
