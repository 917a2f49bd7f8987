// SPDX-License-Identifier: Apache-2.0
#include "sim/app/gateway.h"

#include <stdio.h>
#include <stdlib.h>

#define REOPEN_NS 100000000U ///< Simulated time between attempts to open the interface.
#define ADDRESS_OCTETS 64U

struct gateway {
    char address[ADDRESS_OCTETS];
    osal_can_t can;
    bool is_lost;
    uint64_t retry_ns;
    bus_t* bus;
    unsigned node; // Node of the tools; BUS_NODES_MAX before the first frame.
    gateway_report_t report;
    void* context;
    gateway_counters_t counters;
};

status_t gateway_open(const char* const address, bus_t* const bus, const gateway_report_t report,
                      void* const context, gateway_t** const out_gateway)
{
    *out_gateway       = NULL;
    gateway_t* gateway = calloc(1U, sizeof *gateway);
    if (gateway == NULL) {
        return STATUS_EXHAUSTED;
    }
    gateway->bus     = bus;
    gateway->node    = BUS_NODES_MAX;
    gateway->report  = report;
    gateway->context = context;
    (void)snprintf(gateway->address, sizeof gateway->address, "%s", address);
    const status_t status = osal_can_open(&gateway->can, gateway->address, OSAL_CAN_NODE);
    if (status != STATUS_OK) {
        free(gateway);
        return status;
    }
    *out_gateway = gateway;
    return STATUS_OK;
}

void gateway_close(gateway_t* const gateway)
{
    if (gateway != NULL) {
        osal_can_close(&gateway->can);
        free(gateway);
    }
}

static void close_lost(gateway_t* const gateway)
{
    osal_can_close(&gateway->can);
    gateway->is_lost = true;
}

void gateway_publish(gateway_t* const gateway, const uint32_t senders, const osal_can_frame_t* const frame)
{
    if ((gateway->node != BUS_NODES_MAX) && (senders == ((uint32_t)1U << gateway->node))) {
        return;
    }
    const status_t status = gateway->is_lost ? STATUS_CLOSED : osal_can_send(&gateway->can, frame);
    if (status == STATUS_OK) {
        gateway->counters.published++;
        return;
    }
    gateway->counters.unpublished++;
    if (!gateway->is_lost && (status == STATUS_CLOSED)) {
        close_lost(gateway);
    }
}

static void reopen(gateway_t* const gateway, const uint64_t now_ns)
{
    if (now_ns < gateway->retry_ns) {
        return;
    }
    gateway->retry_ns = now_ns + REOPEN_NS;
    gateway->is_lost  = osal_can_open(&gateway->can, gateway->address, OSAL_CAN_NODE) != STATUS_OK;
}

static void submit(gateway_t* const gateway, const osal_can_frame_t* const frame, const uint64_t now_ns)
{
    const bus_callbacks_t no_callbacks = {.on_frame = NULL}; // Tools receive frames on the interface.
    status_t status                    = STATUS_OK;
    gateway->counters.from_tools++;
    if ((frame->id & OSAL_CAN_ERROR) != 0U) {
        gateway->report(gateway->context, frame);
        return;
    }
    if (gateway->node == BUS_NODES_MAX) {
        status = bus_add_node(gateway->bus, &no_callbacks, &gateway->node);
    }
    if (status == STATUS_OK) {
        status = bus_submit(gateway->bus, gateway->node, frame, now_ns);
    }
    gateway->counters.refused += (status != STATUS_OK) ? 1U : 0U;
}

void gateway_take(gateway_t* const gateway, const uint64_t now_ns)
{
    osal_can_frame_t frame;
    if (gateway->is_lost) {
        reopen(gateway, now_ns);
    }
    while (!gateway->is_lost && ((gateway->node == BUS_NODES_MAX) ||
                                 (bus_queued(gateway->bus, gateway->node) < BUS_QUEUE_FRAMES))) {
        const status_t status = osal_can_receive(&gateway->can, &frame);
        if (status == STATUS_CLOSED) {
            close_lost(gateway);
        }
        if (status != STATUS_OK) {
            break;
        }
        frame.time_ns = now_ns;
        submit(gateway, &frame, now_ns);
    }
}

const gateway_counters_t* gateway_counters(const gateway_t* const gateway)
{
    return &gateway->counters;
}
