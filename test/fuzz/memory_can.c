// SPDX-License-Identifier: Apache-2.0
// osal/can.h in memory for one bus; it replaces the port in the fuzz targets. The flight software must send
// only frames that a bus can carry.
#include "osal/include/osal/can.h"
#include "test/fuzz/fuzz.h"

#define NODE_FRAMES 64U // Transmit queue of the node; small, so that it fills.

typedef struct {
    osal_can_frame_t frames[OSAL_CAN_RING_FRAMES];
    unsigned first;
    unsigned held;
} queue_t;

static struct {
    queue_t to_wire;
    queue_t to_node;
    uint32_t overruns;
} bus;

static bool put(queue_t* const queue, const unsigned limit, const osal_can_frame_t* const frame)
{
    if (queue->held >= limit) {
        return false;
    }
    queue->frames[(queue->first + queue->held) % OSAL_CAN_RING_FRAMES] = *frame;
    queue->held++;
    return true;
}

status_t osal_can_create(const char* const address)
{
    (void)address;
    bus.to_wire.held = 0U;
    bus.to_node.held = 0U;
    bus.overruns     = 0U;
    return STATUS_OK;
}

status_t osal_can_destroy(const char* const address)
{
    (void)address;
    return STATUS_OK;
}

status_t osal_can_open(osal_can_t* const can, const char* const address, const osal_can_end_t end)
{
    (void)address;
    *can = (osal_can_t){.shared = &bus, .descriptor = -1, .end = end};
    if (end == OSAL_CAN_NODE) {
        bus.to_node.held = 0U;
    }
    return STATUS_OK;
}

void osal_can_close(osal_can_t* const can)
{
    can->shared = NULL;
}

status_t osal_can_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    if (can->shared == NULL) {
        return STATUS_CLOSED;
    }
    if (can->end == OSAL_CAN_WIRE) {
        bus.overruns += put(&bus.to_node, OSAL_CAN_RING_FRAMES, frame) ? 0U : 1U;
        return STATUS_OK;
    }
    FUZZ_CHECK((frame->id <= 0x7FFU) && (frame->length <= 8U));
    if (!put(&bus.to_wire, NODE_FRAMES, frame)) {
        can->refused++;
        return STATUS_FULL;
    }
    return STATUS_OK;
}

status_t osal_can_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    queue_t* const queue = (can->end == OSAL_CAN_WIRE) ? &bus.to_wire : &bus.to_node;
    if (can->shared == NULL) {
        return STATUS_CLOSED;
    }
    can->overruns = bus.overruns;
    if (queue->held == 0U) {
        return STATUS_EMPTY;
    }
    *out_frame   = queue->frames[queue->first];
    queue->first = (queue->first + 1U) % OSAL_CAN_RING_FRAMES;
    queue->held--;
    return STATUS_OK;
}

status_t osal_can_filter(osal_can_t* const can, const osal_can_filter_t* const filters, const size_t count)
{
    (void)can;
    (void)filters;
    (void)count;
    return STATUS_OK;
}
