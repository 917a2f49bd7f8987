// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_mqueue.h"

#include "base/assertion.h"

#include <string.h>

void flow_mqueue_init(flow_mqueue_t* const flow, const flow_mqueue_setup_t* const setup,
                      const flow_resolver_t* const resolver)
{
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (resolver != NULL) && (setup->name != NULL));
    FSW_ASSERT((setup->message_octets >= 1U) && (!setup->is_receiver || (setup->depth >= 1U)));
    *flow = (flow_mqueue_t){.setup = *setup, .resolver = resolver};
    flow_reconnect_init(&flow->reconnect, setup->retry_first_ns, setup->retry_longest_ns);
}

static void release(flow_mqueue_t* const flow)
{
    osal_mqueue_close(&flow->queue);
    quota_give(flow->setup.quota);
}

static status_t open_queue(flow_mqueue_t* const flow)
{
    flow_endnode_address_t address;
    status_t status = flow_endnode_resolve(flow->resolver, ENDNODE_MQUEUE, flow->setup.name, &address);
    if (status != STATUS_OK) {
        return status;
    }
    (void)memcpy(flow->address, address.address, sizeof flow->address);
    if (flow->setup.is_receiver) {
        (void)osal_mqueue_remove(flow->address); // Left by a predecessor; usually absent.
        return osal_mqueue_create(&flow->queue, flow->address, flow->setup.depth, flow->setup.message_octets);
    }
    status = osal_mqueue_open(&flow->queue, flow->address);
    if ((status == STATUS_OK) && (osal_mqueue_message_octets(&flow->queue) < flow->setup.message_octets)) {
        return STATUS_INVALID;
    }
    return status;
}

static void begin(flow_mqueue_t* const flow)
{
    status_t status = quota_take(flow->setup.quota);
    if (status == STATUS_OK) {
        status = open_queue(flow);
        if (status != STATUS_OK) {
            release(flow);
        }
    }
    if (status == STATUS_OK) {
        flow_reconnect_succeeded(&flow->reconnect, flow->now_ns);
    } else {
        flow->failure = status;
        flow_reconnect_failed(&flow->reconnect, flow->now_ns);
    }
}

static void lose(flow_mqueue_t* const flow, const status_t why)
{
    release(flow);
    flow->failure = why;
    flow_reconnect_lost(&flow->reconnect, flow->now_ns);
}

status_t flow_mqueue_step(flow_mqueue_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    flow->now_ns = now_ns;
    if (!flow_mqueue_is_open(flow) && flow_reconnect_is_due(&flow->reconnect, now_ns)) {
        begin(flow);
    }
    return flow_mqueue_is_open(flow) ? STATUS_OK : STATUS_CLOSED;
}

status_t flow_mqueue_send(flow_mqueue_t* const flow, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((flow != NULL) && ((octets != NULL) || (size == 0U)));
    status_t status = STATUS_CLOSED;
    if (flow_mqueue_is_open(flow)) {
        status = (size <= flow->setup.message_octets) ? osal_mqueue_send(&flow->queue, octets, size)
                                                      : STATUS_TOO_LARGE;
        if ((status == STATUS_CLOSED) || (status == STATUS_IO)) {
            lose(flow, status);
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
    lose(flow, status);
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
    return osal_mqueue_is_open(&flow->queue);
}

void flow_mqueue_close(flow_mqueue_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (flow_mqueue_is_open(flow)) {
        lose(flow, STATUS_CLOSED);
        if (flow->setup.is_receiver) {
            (void)osal_mqueue_remove(flow->address); // Another receiver may have been faster.
        }
    }
    flow_reconnect_init(&flow->reconnect, flow->setup.retry_first_ns, flow->setup.retry_longest_ns);
}
