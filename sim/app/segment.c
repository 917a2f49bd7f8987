// SPDX-License-Identifier: Apache-2.0
#include "sim/app/segment.h"

#include <stdio.h>

#define NOMINAL_BIT_RATE 1000000U
#define DATA_BIT_RATE 5000000U

static void pass_to_flight(void* context, const osal_can_frame_t* frame)
{
    segment_t* segment    = context;
    const status_t status = osal_can_send(&segment->can, frame);
    (void)status; // A full ring is counted by the wire end as an overrun of flight's controller.
}

static void tap(void* context, const osal_can_frame_t* frame)
{
    frame_log_write(context, frame);
}

static status_t open_controller(segment_t* segment, const char* address, char error[SIMULATOR_ERROR_MAX])
{
    const bus_callbacks_t to_flight = {
        .on_frame = pass_to_flight, .on_error = pass_to_flight, .context = segment};
    status_t status = osal_can_open(&segment->can, address, OSAL_CAN_WIRE);
    if (status == STATUS_OK) {
        segment->has_flight = true;
        status              = bus_add_node(segment->bus, &to_flight, &segment->flight_node);
    }
    if (status != STATUS_OK) {
        (void)snprintf(
            error, SIMULATOR_ERROR_MAX,
            "simulator: bus %s: no controller at '%s' (%s); the launcher makes it before it starts us",
            segment->name, address, status_text(status));
    }
    return status;
}

static status_t open_log(segment_t* segment, const char* folder, char error[SIMULATOR_ERROR_MAX])
{
    const status_t status = frame_log_open(folder, segment->name, &segment->log);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot write can-%s.log and .pcap in '%s'; does the folder exist?",
                       segment->name, folder);
        return status;
    }
    bus_set_tap(segment->bus, tap, segment->log, segment->flight_node);
    return STATUS_OK;
}

status_t segment_open(segment_t* segment, const segment_config_t* config, char error[SIMULATOR_ERROR_MAX])
{
    const bus_config_t bus = {.nominal_bit_rate = NOMINAL_BIT_RATE,
                              .data_bit_rate    = config->is_classic ? 0U : DATA_BIT_RATE,
                              .seed             = config->seed};
    *segment = (segment_t){.name = config->name, .flight_node = BUS_NODES_MAX, .bus = bus_create(&bus)};
    if (segment->bus == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    status_t status =
        (config->address != NULL) ? open_controller(segment, config->address, error) : STATUS_OK;
    if ((status == STATUS_OK) && (config->output_path != NULL)) {
        status = open_log(segment, config->output_path, error);
    }
    return status;
}

status_t segment_close(segment_t* segment)
{
    const status_t status = frame_log_close(segment->log);
    bus_destroy(segment->bus);
    if (segment->has_flight) {
        osal_can_close(&segment->can);
    }
    return status;
}

void segment_take_from_flight(segment_t* segment, uint64_t now_ns)
{
    osal_can_frame_t frame;
    while (segment->has_flight && (bus_queued(segment->bus, segment->flight_node) < BUS_QUEUE_FRAMES) &&
           (osal_can_receive(&segment->can, &frame) == STATUS_OK)) {
        if (bus_submit(segment->bus, segment->flight_node, &frame, now_ns) != STATUS_OK) {
            segment->refused++;
        }
    }
}
