// SPDX-License-Identifier: Apache-2.0
#include "sim/app/segment.h"

#include <stdio.h>

#define REOPEN_NS 10000000U ///< Simulated time between attempts to open the controller.
// Time after which the driver of the flight software's controller reports that a frame cannot be sent.
#define TRANSMIT_TIMEOUT_NS 100000000U

static void pass_to_flight(void* const context, const osal_can_frame_t* const frame)
{
    segment_t* segment = context;
    if (segment->is_lost) {
        return;
    }
    // The wire end counts a full ring as an overrun of the flight software's controller.
    if (osal_can_send(&segment->can, frame) == STATUS_CLOSED) {
        osal_can_close(&segment->can);
        segment->is_lost = true;
    }
}

static void publish_frame(void* const context, const uint32_t senders, const osal_can_frame_t* const frame)
{
    segment_t* segment = context;
    if (segment->log != NULL) {
        frame_log_write(segment->log, frame);
    }
    if (segment->gateway != NULL) {
        gateway_publish(segment->gateway, senders, frame);
    }
    if (segment->live != NULL) {
        live_frame(segment->live, segment->name, frame);
    }
    if ((segment->listen != NULL) && (senders != 0U)) {
        segment->listen(segment->listener, frame);
    }
}

/// Pass an error frame of a tool to the flight software, as if its controller had detected the error.
static void report_of_tool(void* const context, const osal_can_frame_t* const frame)
{
    segment_t* segment = context;
    if (segment->has_flight) {
        pass_to_flight(segment, frame);
    }
    if (segment->log != NULL) {
        frame_log_write(segment->log, frame);
    }
}

static status_t open_controller(segment_t* const segment, const char* const address,
                                char error[SIMULATOR_ERROR_MAX])
{
    const bus_callbacks_t to_flight = {
        .on_frame = pass_to_flight, .on_error = pass_to_flight, .context = segment};
    status_t status = osal_can_open(&segment->can, address, OSAL_CAN_WIRE);
    if (status == STATUS_OK) {
        segment->has_flight = true;
        status              = bus_add_node(segment->bus, &to_flight, &segment->flight_node);
    }
    if (status == STATUS_OK) {
        bus_set_transmit_timeout(segment->bus, segment->flight_node, TRANSMIT_TIMEOUT_NS);
    }
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: bus %s: no controller at '%s' (%s); the launcher makes it before it "
                       "starts the simulator",
                       segment->name, address, status_text(status));
    }
    return status;
}

static status_t open_log(segment_t* const segment, const char* const directory,
                         char error[SIMULATOR_ERROR_MAX])
{
    const status_t status = frame_log_open(directory, segment->name, &segment->log);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot write can-%s.log and .pcap in '%s'; does the directory exist?",
                       segment->name, directory);
        return status;
    }
    return STATUS_OK;
}

static status_t open_gateway(segment_t* const segment, const char* const address,
                             char error[SIMULATOR_ERROR_MAX])
{
    const status_t status = gateway_open(address, segment->bus, report_of_tool, segment, &segment->gateway);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: bus %s: cannot publish it on '%s' (%s); is the interface there and up?",
                       segment->name, address, status_text(status));
    }
    return status;
}

static bool is_given(const char* const address)
{
    return (address != NULL) && (address[0] != '\0');
}

status_t segment_open(segment_t* const segment, const segment_config_t* const config,
                      char error[SIMULATOR_ERROR_MAX])
{
    const bus_config_t bus = {
        .nominal_bit_rate = config->bit_rate, .data_bit_rate = config->data_bit_rate, .seed = config->seed};
    *segment = (segment_t){.name        = config->name,
                           .address     = config->address,
                           .flight_node = BUS_NODES_MAX,
                           .can         = {.descriptor = -1},
                           .bus         = bus_create(&bus)};
    if (segment->bus == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: bus %s: bit rates %u and %u: expected divisors of 10^9, e.g. 500000, or "
                       "no memory is left",
                       segment->name, config->bit_rate, config->data_bit_rate);
        return STATUS_INVALID;
    }
    status_t status =
        is_given(config->address) ? open_controller(segment, config->address, error) : STATUS_OK;
    if ((status == STATUS_OK) && (config->output_path != NULL)) {
        status = open_log(segment, config->output_path, error);
    }
    if ((status == STATUS_OK) && is_given(config->published)) {
        status = open_gateway(segment, config->published, error);
    }
    bus_set_tap(segment->bus, publish_frame, segment, segment->flight_node);
    return status;
}

status_t segment_close(segment_t* const segment)
{
    const status_t status = frame_log_close(segment->log);
    gateway_close(segment->gateway);
    bus_destroy(segment->bus);
    if (segment->has_flight) {
        osal_can_close(&segment->can);
    }
    return status;
}

static void reopen(segment_t* const segment, const uint64_t now_ns)
{
    if (now_ns >= segment->retry_ns) {
        segment->retry_ns = now_ns + REOPEN_NS;
        segment->is_lost  = osal_can_open(&segment->can, segment->address, OSAL_CAN_WIRE) != STATUS_OK;
    }
}

static void take_from_flight(segment_t* const segment, const uint64_t now_ns)
{
    osal_can_frame_t frame;
    while (!segment->is_lost && (bus_queued(segment->bus, segment->flight_node) < BUS_QUEUE_FRAMES)) {
        const status_t status = osal_can_receive(&segment->can, &frame);
        if (status == STATUS_CLOSED) {
            osal_can_close(&segment->can);
            segment->is_lost = true;
        }
        if (status != STATUS_OK) {
            break;
        }
        // Error frames are reports of the controller of this end, not frames of the flight software.
        const bool is_report = ((frame.id & OSAL_CAN_ERROR) != 0U);
        if (is_report || (bus_submit(segment->bus, segment->flight_node, &frame, now_ns) != STATUS_OK)) {
            segment->refused++;
        }
    }
}

void segment_take(segment_t* const segment, const uint64_t now_ns)
{
    if (segment->has_flight && segment->is_lost) {
        reopen(segment, now_ns);
    }
    if (segment->has_flight) {
        take_from_flight(segment, now_ns);
    }
    if (segment->gateway != NULL) {
        const uint64_t before = gateway_counters(segment->gateway)->from_tools;
        gateway_take(segment->gateway, now_ns);
        osal_can_add_external(&segment->can,
                              (uint32_t)(gateway_counters(segment->gateway)->from_tools - before));
    }
}
