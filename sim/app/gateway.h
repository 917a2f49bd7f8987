// SPDX-License-Identifier: Apache-2.0
/// Publishes a bus of the simulator on a SocketCAN interface for tools (candump, cansniffer, canplayer,
/// Wireshark): every frame in the order of arbitration, and the error reports of the controller of the flight
/// software. A separate controller, created when the first tool sends a frame, sends the frames of tools on
/// the bus. An error frame from a tool reaches the flight software as an error report of its own controller.
///
/// If the interface goes down or disappears, frames are counted as unpublished until it can be opened again.
///
/// Ownership  gateway_open allocates, gateway_close frees.
/// Context    One task.
#ifndef SIM_APP_GATEWAY_H
#define SIM_APP_GATEWAY_H

#include "base/status.h"
#include "osal/include/osal/can.h"
#include "sim/bus/bus.h"

#include <stdint.h>

typedef struct gateway gateway_t;

/// Called for an error frame that a tool has sent.
typedef void (*gateway_report_t)(void* context, const osal_can_frame_t* frame);

typedef struct { // Read-only for others [frames].
    uint64_t published;
    uint64_t unpublished; ///< Frames that the interface did not accept.
    uint64_t from_tools;  ///< Sent by tools, error frames included.
    /// Frames from tools that the bus refused: it has no room for a further controller (BUS_NODES_MAX), the
    /// tools' controller is bus-off, or the frame is not valid on this bus.
    uint64_t refused;
} gateway_counters_t;

/// Returns STATUS_OK; else *out_gateway is null: STATUS_EXHAUSTED (memory), or as osal_can_open.
MUST_USE status_t gateway_open(const char* address, bus_t* bus, gateway_report_t report, void* context,
                               gateway_t** out_gateway);
/// Null is allowed.
void gateway_close(gateway_t* gateway);
/// Publish a frame that was on the bus (bus_tap_t). A frame that only tools have sent is not published: all
/// tools on the interface have received it already.
void gateway_publish(gateway_t* gateway, uint32_t senders, const osal_can_frame_t* frame);
/// Receive the frames that tools have sent to the interface, and submit them to the bus.
void gateway_take(gateway_t* gateway, uint64_t now_ns);
const gateway_counters_t* gateway_counters(const gateway_t* gateway);

#endif // SIM_APP_GATEWAY_H
