// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_can.h"

#include "fsw/framework/base/assertion.h"

#include <stddef.h>
#include <string.h>

#define CONTROLLER_OVERFLOW 0x01U // data[1] of a controller error frame
#define CONTROLLER_WARNING 0x0CU
#define CONTROLLER_PASSIVE 0x30U
#define CONTROLLER_ACTIVE 0x40U
#define STANDARD_ID_MAX 0x7FFU

void flow_can_init(flow_can_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    *flow = (flow_can_t){.is_open = false};
}

bool flow_can_is_open(const flow_can_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    return flow->is_open;
}

static void discard_received(flow_can_t* const flow)
{
    osal_can_frame_t frame;
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) { // A sender that never pauses cannot hold us here.
        if (osal_can_receive(&flow->can, &frame) != STATUS_OK) {
            break;
        }
    }
}

status_t flow_can_open(flow_can_t* const flow, const flow_resolver_t* const resolver, const char* const bus)
{
    FSW_ASSERT((flow != NULL) && (resolver != NULL) && (bus != NULL));
    if (flow->is_open) {
        return STATUS_EXISTS;
    }
    endnode_address_t address;
    status_t status = endnode_resolve(resolver, ENDNODE_CAN, bus, &address);
    if (status == STATUS_OK) {
        status = osal_can_open(&flow->can, address.address, OSAL_CAN_NODE);
    }
    if (status == STATUS_OK) {
        flow->is_open = true;
        flow->is_fd   = address.is_fd;
        flow->health  = (flow_can_health_t){.state = FLOW_CAN_ACTIVE};
        discard_received(flow);
    }
    return status;
}

void flow_can_close(flow_can_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (flow->is_open) {
        osal_can_close(&flow->can);
        flow->is_open = false;
    }
}

static status_t queue(flow_can_t* const flow, const uint16_t identifier, const uint8_t* const octets,
                      const uint8_t length, const uint8_t flags)
{
    FSW_ASSERT((flow != NULL) && ((octets != NULL) || (length == 0U)));
    status_t status          = STATUS_OK;
    const uint8_t length_max = ((flags & OSAL_CAN_FLAG_FD) != 0U) ? OSAL_CAN_DATA_MAX : 8U;
    if (!flow->is_open) {
        status = STATUS_CLOSED;
    } else if ((length > length_max) || (identifier > STANDARD_ID_MAX)) {
        status = STATUS_INVALID;
    } else {
        osal_can_frame_t frame = {.id = identifier, .length = length, .flags = flags};
        if (length > 0U) {
            (void)memcpy(frame.data, octets, length);
        }
        status = osal_can_send(&flow->can, &frame);
    }
    if (status == STATUS_OK) {
        flow->counters.sent++;
    } else {
        flow->counters.refused++;
    }
    return status;
}

status_t flow_can_send(flow_can_t* const flow, const uint16_t identifier, const uint8_t* const octets,
                       const uint8_t length)
{
    return queue(flow, identifier, octets, length, 0U);
}

status_t flow_can_send_process_data(flow_can_t* const flow, const uint16_t identifier,
                                    const uint8_t* const octets, const uint8_t length)
{
    FSW_ASSERT(flow != NULL);
    const uint8_t flags = flow->is_fd ? (uint8_t)(OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS) : 0U;
    return queue(flow, identifier, octets, length, flags);
}

static void take_error_frame(flow_can_t* const flow, const osal_can_frame_t* const frame)
{
    flow_can_health_t* const health = &flow->health;
    flow->counters.errors++;
    if ((frame->id & OSAL_CAN_ERROR_CONTROLLER) != 0U) {
        const uint8_t detail = frame->data[1];
        if ((detail & CONTROLLER_OVERFLOW) != 0U) {
            flow->counters.overruns++;
        }
        if ((detail & CONTROLLER_PASSIVE) != 0U) {
            health->state = FLOW_CAN_PASSIVE;
        } else if ((detail & CONTROLLER_WARNING) != 0U) {
            health->state = FLOW_CAN_WARNING;
        } else if ((detail & CONTROLLER_ACTIVE) != 0U) {
            health->state = FLOW_CAN_ACTIVE;
        }
    }
    if ((frame->id & OSAL_CAN_ERROR_NO_ACK) != 0U) {
        health->is_unacknowledged = true;
    }
    if ((frame->id & OSAL_CAN_ERROR_RESTARTED) != 0U) {
        health->state = FLOW_CAN_ACTIVE;
    }
    if ((frame->id & OSAL_CAN_ERROR_BUS_OFF) != 0U) {
        health->state = FLOW_CAN_BUS_OFF;
    }
    health->transmit_errors = frame->data[6];
    health->receive_errors  = frame->data[7];
}

status_t flow_can_receive(flow_can_t* const flow, osal_can_frame_t* const out_frame)
{
    FSW_ASSERT((flow != NULL) && (out_frame != NULL));
    if (!flow->is_open) {
        return STATUS_CLOSED;
    }
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        const status_t status = osal_can_receive(&flow->can, out_frame);
        if (status != STATUS_OK) {
            return status;
        }
        if ((out_frame->id & OSAL_CAN_ERROR) == 0U) {
            flow->counters.received++;
            flow->health.is_unacknowledged = false;
            return STATUS_OK;
        }
        take_error_frame(flow, out_frame);
    }
    return STATUS_EMPTY; // Nothing but error frames: the rest waits for the next cycle.
}
