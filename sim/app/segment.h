// SPDX-License-Identifier: Apache-2.0
/// A bus of the simulator with the controller of the flight software ("flight"), its log, and its publication
/// to tools.
///
/// Ownership  The caller provides segment_t; it must not be moved. segment_close frees what segment_open
///            made.
/// Context    One task.
#ifndef SIM_APP_SEGMENT_H
#define SIM_APP_SEGMENT_H

#include "osal/include/osal/can.h"
#include "sim/app/gateway.h"
#include "sim/app/live.h"
#include "sim/app/simulator.h"
#include "sim/bus/bus.h"
#include "sim/logs/frame_log.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private, except name, bus, flight_node, listen and listener.
    const char* name;
    bus_t* bus;
    unsigned flight_node; ///< BUS_NODES_MAX: flight software has no controller on this bus.
    osal_can_t can;       // Wire end of the flight software's controller.
    bool has_flight;
    const char* address; // Address of the wire end.
    bool is_lost;        // The interface to flight software is removed or down.
    uint64_t retry_ns;
    /// Frames of the flight software that the bus did not accept (node bus-off or unplugged, frame not
    /// valid), and error reports of the controller of the wire end.
    uint64_t refused;
    frame_log_t* log;
    gateway_t* gateway;
    /// Called for every frame on the wire, without being a node of the bus; may be null.
    void (*listen)(void* context, const osal_can_frame_t* frame);
    /// Context of `listen`.
    void* listener;
    live_t* live; // Null: there is no live port.
} segment_t;

typedef struct {
    const char* name; ///< Outlives the segment.
    /// Address of the flight software's controller, outlives the segment; null or "": none.
    const char* address;
    const char* published;   ///< Interface on which tools see the bus; null or "": none.
    const char* output_path; ///< Directory of the log; null: none is written.
    unsigned bit_rate;
    unsigned data_bit_rate; ///< 0: classic bus.
    uint64_t seed;
} segment_config_t;

/// Open a segment; segment_close must be called in any case. STATUS_OK; else `error` is filled:
/// STATUS_INVALID (a bit rate, or no memory for the bus), STATUS_EXHAUSTED (memory, nodes of the bus),
/// statuses of osal_can_open (controller, interface of tools) and of frame_log_open.
MUST_USE status_t segment_open(segment_t* segment, const segment_config_t* config,
                               char error[SIMULATOR_ERROR_MAX]);
/// Returns STATUS_OK, or STATUS_IO: the log is not complete.
status_t segment_close(segment_t* segment);
/// Move the frames that flight software and tools have sent to the controllers' transmit queues.
void segment_take(segment_t* segment, uint64_t now_ns);

#endif // SIM_APP_SEGMENT_H
