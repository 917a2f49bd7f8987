// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_can.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define CONTROLLER_OVERFLOW 0x01U // data[1] of a controller error frame
#define CONTROLLER_WARNING 0x0CU
#define CONTROLLER_PASSIVE 0x30U
#define CONTROLLER_ACTIVE 0x40U
// Classes whose frames contain the error counters in all kernels; drivers of newer kernels set them in other
// classes too.
#define HAS_COUNTERS                                                                                         \
    (OSAL_CAN_ERROR_COUNTERS | OSAL_CAN_ERROR_CONTROLLER | OSAL_CAN_ERROR_NO_ACK | OSAL_CAN_ERROR_BUS_OFF |  \
     OSAL_CAN_ERROR_BUS | OSAL_CAN_ERROR_RESTARTED)
#define STANDARD_ID_MAX 0x7FFU
#define REOPEN_FIRST_NS 10000000ULL     ///< First delay before the bus is opened again.
#define REOPEN_LONGEST_NS 1000000000ULL ///< Longest delay.

// A master of an 11-bit protocol uses only standard frames. Remote requests pass, too: the master counts
// them.
static const osal_can_filter_t standard_frames = {.id = 0U, .mask = OSAL_CAN_EXTENDED};

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
    // The limit ends the loop even if a sender never pauses.
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        if (osal_can_receive(&flow->can, &frame) != STATUS_OK) {
            break;
        }
    }
}

static status_t open_bus(flow_can_t* const flow)
{
    status_t status = osal_can_open(&flow->can, flow->address.address, OSAL_CAN_NODE);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_can_filter(&flow->can, &standard_frames, 1U);
    if ((status == STATUS_OK) && flow->is_fd && !flow->can.carries_fd) {
        status = STATUS_UNSUPPORTED;
    }
    if (status != STATUS_OK) {
        osal_can_close(&flow->can);
        return status;
    }
    flow->queue_overruns = flow->can.overruns;
    flow->health         = (flow_can_health_t){.state = FLOW_CAN_ACTIVE};
    discard_received(flow);
    return STATUS_OK;
}

status_t flow_can_open(flow_can_t* const flow, const flow_resolver_t* const resolver, const char* const bus)
{
    FSW_ASSERT((flow != NULL) && (resolver != NULL) && (bus != NULL));
    if (flow->is_open) {
        return STATUS_EXISTS;
    }
    status_t status = flow_endnode_resolve(resolver, ENDNODE_CAN, bus, &flow->address);
    if (status == STATUS_OK) {
        flow->is_fd = flow->address.is_fd;
        status      = open_bus(flow);
    }
    if (status == STATUS_OK) {
        flow->is_open = true;
        flow->is_lost = false;
        flow_reconnect_init(&flow->reconnect, REOPEN_FIRST_NS, REOPEN_LONGEST_NS);
        flow_reconnect_succeeded(&flow->reconnect, 0U);
    } else {
        flow->counters.failed++;
    }
    return status;
}

/// Treat an interface that was removed or is down as bus-off.
static void lose_bus(flow_can_t* const flow)
{
    osal_can_close(&flow->can);
    flow->is_lost      = true;
    flow->health.state = FLOW_CAN_BUS_OFF;
    flow->counters.lost++;
}

void flow_can_attend(flow_can_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    if (!flow->is_open || !flow->is_lost) {
        return;
    }
    flow_reconnect_lost(&flow->reconnect, now_ns);
    if (!flow_reconnect_is_due(&flow->reconnect, now_ns)) {
        return;
    }
    if (open_bus(flow) == STATUS_OK) {
        flow_reconnect_succeeded(&flow->reconnect, now_ns);
        flow->is_lost = false;
        flow->counters.reopened++;
    } else {
        flow_reconnect_failed(&flow->reconnect, now_ns);
        flow->counters.failed++;
    }
}

void flow_can_close(flow_can_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (flow->is_open) {
        osal_can_close(&flow->can);
        flow->is_open = false;
        flow->is_lost = false;
    }
}

/// Queue a frame for transmission, and count it as sent or refused.
static status_t queue(flow_can_t* const flow, const uint16_t identifier, const uint8_t* const octets,
                      const uint8_t length, const uint8_t flags)
{
    FSW_ASSERT((flow != NULL) && ((octets != NULL) || (length == 0U)));
    status_t status          = STATUS_OK;
    const uint8_t length_max = ((flags & OSAL_CAN_FLAG_FD) != 0U) ? OSAL_CAN_DATA_MAX : 8U;
    if (!flow->is_open || flow->is_lost) {
        status = STATUS_CLOSED;
    } else if ((length > length_max) || (identifier > STANDARD_ID_MAX)) {
        status = STATUS_INVALID;
    } else {
        osal_can_frame_t frame = {.id = identifier, .length = length, .flags = flags};
        if (length > 0U) {
            (void)memcpy(frame.data, octets, length);
        }
        status = osal_can_send(&flow->can, &frame);
        if (status == STATUS_CLOSED) {
            lose_bus(flow);
        }
    }
    if (status == STATUS_OK) {
        flow->counters.sent++;
    } else {
        flow->counters.refused++;
        flow->counters.full += (status == STATUS_FULL) ? 1U : 0U;
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

static void count_classes(flow_can_errors_t* const errors, const uint32_t classes)
{
    errors->transmit_timeouts += ((classes & OSAL_CAN_ERROR_TX_TIMEOUT) != 0U) ? 1U : 0U;
    errors->lost_arbitrations += ((classes & OSAL_CAN_ERROR_LOST_ARBITRATION) != 0U) ? 1U : 0U;
    errors->controller_problems += ((classes & OSAL_CAN_ERROR_CONTROLLER) != 0U) ? 1U : 0U;
    errors->protocol_violations += ((classes & OSAL_CAN_ERROR_PROTOCOL) != 0U) ? 1U : 0U;
    errors->transceiver_faults += ((classes & OSAL_CAN_ERROR_TRANSCEIVER) != 0U) ? 1U : 0U;
    errors->missing_acknowledges += ((classes & OSAL_CAN_ERROR_NO_ACK) != 0U) ? 1U : 0U;
    errors->bus_offs += ((classes & OSAL_CAN_ERROR_BUS_OFF) != 0U) ? 1U : 0U;
    errors->bus_errors += ((classes & OSAL_CAN_ERROR_BUS) != 0U) ? 1U : 0U;
    errors->restarts += ((classes & OSAL_CAN_ERROR_RESTARTED) != 0U) ? 1U : 0U;
}

static void take_controller_report(flow_can_t* const flow, const uint8_t detail)
{
    flow_can_health_t* const health = &flow->health;
    if ((detail & CONTROLLER_OVERFLOW) != 0U) {
        flow->counters.overruns++;
    }
    if ((detail & CONTROLLER_PASSIVE) != 0U) {
        health->state = FLOW_CAN_PASSIVE;
    } else if ((detail & CONTROLLER_WARNING) != 0U) {
        health->state = FLOW_CAN_WARNING;
    } else if ((detail & CONTROLLER_ACTIVE) != 0U) {
        health->state = FLOW_CAN_ACTIVE;
    } else {
        // The frame reports only an overflow; the error state does not change.
    }
}

static void take_error_frame(flow_can_t* const flow, const osal_can_frame_t* const frame)
{
    flow_can_health_t* const health = &flow->health;
    flow->counters.errors++;
    count_classes(&flow->errors, frame->id);
    if ((frame->id & OSAL_CAN_ERROR_CONTROLLER) != 0U) {
        take_controller_report(flow, frame->data[1]);
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
    if ((frame->id & HAS_COUNTERS) != 0U) {
        health->transmit_errors = frame->data[6];
        health->receive_errors  = frame->data[7];
    }
}

/// Count the frames that the receive queue has dropped since the last call.
static void count_overruns(flow_can_t* const flow)
{
    flow->counters.overruns += flow->can.overruns - flow->queue_overruns;
    flow->queue_overruns = flow->can.overruns;
}

status_t flow_can_receive(flow_can_t* const flow, osal_can_frame_t* const out_frame)
{
    FSW_ASSERT((flow != NULL) && (out_frame != NULL));
    if (!flow->is_open || flow->is_lost) {
        return STATUS_CLOSED;
    }
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        const status_t status = osal_can_receive(&flow->can, out_frame);
        count_overruns(flow);
        if (status == STATUS_CLOSED) {
            lose_bus(flow);
        }
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
    return STATUS_EMPTY; // All these frames were error frames; further frames wait for the next cycle.
}
