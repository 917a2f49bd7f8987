// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_stream.h"

#include "base/assertion.h"
#include "osal/include/osal/serial.h"

#include <string.h>

#define CHUNKS_PER_CALL 16U ///< Bound, so that a partner that sends without a pause cannot hold the cycle.

// ---- Connection ----

static osal_device_direction_t direction_of(const flow_format_t* const format)
{
    if (format->direction == FLOW_DIRECTION_READ) {
        return OSAL_DEVICE_READ;
    }
    return (format->direction == FLOW_DIRECTION_WRITE) ? OSAL_DEVICE_WRITE : OSAL_DEVICE_BOTH;
}

static status_t connect(flow_stream_t* const flow)
{
    if (flow->link.is_pending) {
        return osal_tcp_connect_result(&flow->socket);
    }
    osal_address_t to = {0U, 0U};
    status_t status =
        flow_endnode_resolve_socket(flow->resolver, ENDNODE_TCP, flow->setup.name, &to, &flow->counts);
    if (status == STATUS_OK) {
        status = osal_tcp_connect_begin(&flow->socket, to);
    }
    // In stepped time, wait for the result, so that it does not depend on wall-clock time.
    if ((status == STATUS_BUSY) && osal_hand_over_is_open(&flow->counts) &&
        (osal_socket_wait_writable(&flow->socket, OSAL_HAND_OVER_TIMEOUT_MS) == STATUS_OK)) {
        status = osal_tcp_connect_result(&flow->socket);
    }
    flow->link.is_pending = (status == STATUS_BUSY);
    return status;
}

static status_t open_device(flow_stream_t* const flow)
{
    flow_endnode_address_t address;
    status_t status = flow_endnode_resolve(flow->resolver, flow->setup.kind, flow->setup.name, &address);
    if (status == STATUS_OK) {
        status = flow_endnode_open_counts(&address, &flow->counts);
    }
    if (status != STATUS_OK) {
        return status;
    }
    return (flow->setup.kind == ENDNODE_SERIAL)
               ? osal_serial_open(&flow->device, address.address, flow->setup.format.baud)
               : osal_device_open(&flow->device, address.address, direction_of(&flow->setup.format));
}

static status_t open_endnode(void* const context)
{
    flow_stream_t* const flow = context;
    const status_t status     = (flow->setup.kind == ENDNODE_TCP) ? connect(flow) : open_device(flow);
    if (status == STATUS_OK) {
        osal_hand_over_begin(&flow->counts);
    }
    return status;
}

static void close_endnode(void* const context)
{
    flow_stream_t* const flow = context;
    osal_device_close(&flow->device);
    osal_socket_close(&flow->socket);
    osal_hand_over_close(&flow->counts);
    flow->counters.discarded += (uint32_t)flow->outbox_held;
    flow->outbox_held = 0U;
    flow->chunk_size  = 0U;
    flow->chunk_used  = 0U;
    flow_frame_assembler_reset(&flow->assembler);
}

void flow_stream_init(flow_stream_t* const flow, const flow_stream_setup_t* const setup,
                      const flow_resolver_t* const resolver)
{
    static const flow_link_actions_t actions = {open_endnode, close_endnode};
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (resolver != NULL) && (setup->name != NULL));
    FSW_ASSERT((setup->kind == ENDNODE_SERIAL) || (setup->kind == ENDNODE_TCP) ||
               (setup->kind == ENDNODE_FILE));
    FSW_ASSERT((setup->outbox != NULL) && (setup->outbox_octets > 0U));
    *flow = (flow_stream_t){
        .setup = *setup, .resolver = resolver, .device = OSAL_DEVICE_CLOSED, .socket = OSAL_SOCKET_CLOSED};
    flow_link_init(&flow->link, &actions, flow, setup->quota, setup->retry_first_ns, setup->retry_longest_ns);
    flow_frame_assembler_init(&flow->assembler, &setup->format, setup->frame, setup->frame_octets);
}

// ---- Octets ----

static status_t write_some(flow_stream_t* const flow, size_t* const out_sent)
{
    return (flow->setup.kind == ENDNODE_TCP)
               ? osal_stream_send(&flow->socket, flow->setup.outbox, flow->outbox_held, out_sent)
               : osal_device_write(&flow->device, flow->setup.outbox, flow->outbox_held, out_sent);
}

static status_t read_at_once(flow_stream_t* const flow, size_t* const out_size)
{
    return (flow->setup.kind == ENDNODE_TCP)
               ? osal_stream_receive(&flow->socket, flow->chunk, sizeof flow->chunk, out_size)
               : osal_device_read(&flow->device, flow->chunk, sizeof flow->chunk, out_size);
}

static status_t wait_readable(flow_stream_t* const flow)
{
    return (flow->setup.kind == ENDNODE_TCP)
               ? osal_socket_wait_readable(&flow->socket, OSAL_HAND_OVER_TIMEOUT_MS)
               : osal_device_wait_readable(&flow->device, OSAL_HAND_OVER_TIMEOUT_MS);
}

/// Read octets; in stepped time, wait for those that the device has announced.
static status_t read_some(flow_stream_t* const flow, size_t* const out_size)
{
    status_t status = read_at_once(flow, out_size);
    if ((status == STATUS_EMPTY) && (osal_hand_over_due(&flow->counts) > 0U)) {
        if (wait_readable(flow) == STATUS_OK) {
            status = read_at_once(flow, out_size);
        } else {
            osal_hand_over_give_up(&flow->counts);
        }
    }
    osal_hand_over_take(&flow->counts, (uint32_t)*out_size);
    return status;
}

/// End the link as soon as the counts of stepped time show that the device is gone, because the kernel may
/// report it later.
static void look_for_device(flow_stream_t* const flow)
{
    if (flow->link.is_open && !osal_hand_over_is_present(&flow->counts)) {
        flow_link_lose(&flow->link, STATUS_CLOSED);
    }
}

/// Pass as many octets of the outbox to the system as it accepts.
static void flush(flow_stream_t* const flow)
{
    while (flow->link.is_open && (flow->outbox_held > 0U)) {
        size_t sent           = 0U;
        const status_t status = write_some(flow, &sent);
        if (status == STATUS_FULL) {
            return;
        }
        if (status != STATUS_OK) {
            flow_link_lose(&flow->link, status);
            return;
        }
        osal_hand_over_announce(&flow->counts, (uint32_t)sent);
        flow->counters.octets_out += (uint32_t)sent;
        flow->outbox_held -= sent;
        (void)memmove(flow->setup.outbox, &flow->setup.outbox[sent], flow->outbox_held);
    }
}

status_t flow_stream_step(flow_stream_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    look_for_device(flow);
    const status_t status = flow_link_step(&flow->link, now_ns);
    if (status != STATUS_OK) {
        return status;
    }
    flush(flow);
    return flow->link.is_open ? STATUS_OK : STATUS_CLOSED;
}

status_t flow_stream_send(flow_stream_t* const flow, const uint8_t* const payload, const size_t size)
{
    FSW_ASSERT((flow != NULL) && ((payload != NULL) || (size == 0U)));
    status_t status = STATUS_CLOSED;
    size_t octets   = 0U;
    if (flow->link.is_open) {
        status = (flow->outbox_held < flow->setup.outbox_octets)
                     ? flow_frame_encode(&flow->setup.format, payload, size,
                                         &flow->setup.outbox[flow->outbox_held],
                                         flow->setup.outbox_octets - flow->outbox_held, &octets)
                     : STATUS_FULL;
    }
    if (status != STATUS_OK) {
        flow->counters.refused++;
        return status;
    }
    flow->outbox_held += octets;
    flow->counters.sent++;
    flush(flow);
    return STATUS_OK;
}

status_t flow_stream_receive(flow_stream_t* const flow, const uint8_t** const out_payload,
                             size_t* const out_size)
{
    FSW_ASSERT((flow != NULL) && (out_payload != NULL) && (out_size != NULL));
    *out_payload = flow->setup.frame;
    *out_size    = 0U;
    for (unsigned i = 0U; flow->link.is_open && (i < CHUNKS_PER_CALL); i++) {
        size_t taken = 0U;
        if (flow_frame_assembler_feed(&flow->assembler, &flow->chunk[flow->chunk_used],
                                      flow->chunk_size - flow->chunk_used, &taken, out_size) == STATUS_OK) {
            flow->chunk_used += taken;
            flow->counters.received++;
            return STATUS_OK;
        }
        flow->chunk_used      = 0U;
        flow->chunk_size      = 0U;
        const status_t status = read_some(flow, &flow->chunk_size);
        if (status == STATUS_EMPTY) {
            return STATUS_EMPTY;
        }
        if (status != STATUS_OK) {
            flow_link_lose(&flow->link, status);
            break;
        }
        flow->counters.octets_in += (uint32_t)flow->chunk_size;
    }
    return flow->link.is_open ? STATUS_EMPTY : STATUS_CLOSED;
}

status_t flow_stream_send_record(flow_stream_t* const flow, const flow_record_layout_t* const layout,
                                 const void* const record)
{
    FSW_ASSERT(flow != NULL);
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size = 0U;
    const status_t status =
        flow_record_encode(layout, flow->setup.format.order, record, octets, sizeof octets, &size);
    FSW_ASSERT(status == STATUS_OK);
    return flow_stream_send(flow, octets, size);
}

status_t flow_stream_receive_record(flow_stream_t* const flow, const flow_record_layout_t* const layout,
                                    void* const out_record)
{
    const uint8_t* payload = NULL;
    size_t size            = 0U;
    status_t status        = flow_stream_receive(flow, &payload, &size);
    if (status == STATUS_OK) {
        status = flow_record_decode(layout, flow->setup.format.order, payload, size, out_record);
        flow->counters.unfit += (status != STATUS_OK) ? 1U : 0U;
    }
    return status;
}

void flow_stream_give_up(flow_stream_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (flow->link.is_open) {
        flow_link_lose(&flow->link, STATUS_TIMEOUT);
    }
}

void flow_stream_close(flow_stream_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    flow_link_close(&flow->link);
}
