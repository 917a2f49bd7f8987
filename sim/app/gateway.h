// SPDX-License-Identifier: Apache-2.0
/// A bus of the simulator published on a SocketCAN interface, where candump, cansniffer, canplayer or
/// Wireshark attach: every frame in the order of arbitration, and error reports of flight's controller.
/// Frames that such tools send go onto the bus from a separate controller, which is created when the first
/// such frame arrives; an error frame of a tool is passed to flight as a report of its controller.
///
/// If the interface goes down or disappears, frames are counted as unshown, and it is opened again.
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
    uint64_t shown;
    uint64_t unshown;    ///< The interface did not take them.
    uint64_t from_tools; ///< Sent by tools.
    /// Of these, refused by the bus: its queue was full, or the frame does not exist on it.
    uint64_t refused;
} gateway_counters_t;

/// Returns STATUS_OK; else *out_gateway is null: STATUS_EXHAUSTED (memory), or as osal_can_open.
MUST_USE status_t gateway_open(const char* address, bus_t* bus, gateway_report_t report, void* context,
                               gateway_t** out_gateway);
/// Null is allowed.
void gateway_close(gateway_t* gateway);
/// Publish a frame that was on the bus (bus_tap_t). Frames received from the interface are not sent there
/// again: its users have seen them, and a controller does not receive its own frames.
void gateway_show(gateway_t* gateway, uint32_t senders, const osal_can_frame_t* frame);
/// Send the frames on the bus that tools have sent since the last call.
void gateway_take(gateway_t* gateway, uint64_t now_ns);
const gateway_counters_t* gateway_counters(const gateway_t* gateway);

#endif // SIM_APP_GATEWAY_H
