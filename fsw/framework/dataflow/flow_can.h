// SPDX-License-Identifier: Apache-2.0
/// Data flow over one CAN controller: frames in both directions, and the condition of the bus.
///
/// Error frames change `health` and `errors` and are removed from the stream: flow_can_receive returns data
/// and remote frames only.
///
/// An interface that goes down or is removed while the flow is open is handled as bus-off: health is BUS_OFF,
/// sending and receiving return STATUS_CLOSED, and flow_can_attend opens the bus again once it is back.
///
/// Ownership  The caller provides flow_can_t; it must not be moved while open.
/// Context    One task. Never blocks, except in the counted hand-over of stepped time (osal/can.h).
/// Time       O(1).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/reconnect.h"
#include "osal/include/osal/can.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum { // Error state of the controller, from its last error frame.
    FLOW_CAN_ACTIVE,
    FLOW_CAN_WARNING, ///< An error counter has reached 96.
    FLOW_CAN_PASSIVE, ///< An error counter has reached 128.
    /// The controller has left the bus, or its interface is missing; no frame is sent or received.
    FLOW_CAN_BUS_OFF
} flow_can_state_t;

typedef struct {
    flow_can_state_t state;
    bool is_unacknowledged; ///< No node acknowledges sent frames. Cleared by the next frame received.
    uint8_t transmit_errors;
    uint8_t receive_errors;
} flow_can_health_t;

typedef struct { // Numbers of frames and attempts; each counter [wraps].
    uint32_t sent;
    uint32_t received;
    uint32_t errors;   ///< Error frames.
    uint32_t refused;  ///< Not sent: transmit queue full, closed, or a bad length or identifier.
    uint32_t full;     ///< Refused because the transmit queue was full.
    uint32_t overruns; ///< Received, but lost because the controller's or the kernel's queue was full.
    uint32_t lost;     ///< Times that the interface went down or was removed.
    uint32_t failed;   ///< Failed attempts to open the interface.
    uint32_t reopened; ///< Times that the interface was opened again.
} flow_can_counters_t;

typedef struct { // Error frames by class; one frame may belong to several classes. Each counter [wraps].
    uint32_t transmit_timeouts;
    uint32_t lost_arbitrations;
    uint32_t controller_problems; ///< Overflow, or a change to warning, passive or active.
    uint32_t protocol_violations;
    uint32_t transceiver_faults;
    uint32_t missing_acknowledges;
    uint32_t bus_offs;
    uint32_t bus_errors;
    uint32_t restarts;
} flow_can_errors_t;

typedef struct { // Private, except health, counters and errors: read-only.
    osal_can_t can;
    flow_endnode_address_t address;
    bool is_open;
    bool is_lost; // The interface is removed or down.
    bool is_fd;
    flow_reconnect_t reconnect;
    uint32_t queue_overruns; // Frames dropped by the receive queue, at the last check.
    flow_can_health_t health;
    flow_can_counters_t counters;
    flow_can_errors_t errors;
} flow_can_t;

/// Initialise as closed, with counters zero. Call it once, before any other function.
void flow_can_init(flow_can_t* flow);
/// Open the bus of that name and discard the frames in its receive queue. Health starts as ACTIVE. STATUS_OK,
/// STATUS_EXISTS (open already), STATUS_NOT_FOUND (resolver or bus), STATUS_INVALID (address), STATUS_CLOSED
/// (the interface is down), STATUS_UNSUPPORTED (this port has no such kind of bus, or the bus needs FD frames
/// and the interface carries classic ones only), STATUS_DENIED, STATUS_IO.
MUST_USE status_t flow_can_open(flow_can_t* flow, const flow_resolver_t* resolver, const char* bus);
void flow_can_close(flow_can_t* flow);
/// True from flow_can_open to flow_can_close, also while the interface is missing.
bool flow_can_is_open(const flow_can_t* flow);
/// Call in each cycle before receiving: opens the bus again after a loss, with a back-off of 10 ms to 1 s.
/// Frames on the bus in the meantime are lost; health starts as ACTIVE.
void flow_can_attend(flow_can_t* flow, uint64_t now_ns);

/// Queue a classic data frame, 0..8 octets, 11-bit identifier.
/// STATUS_OK, STATUS_FULL, STATUS_INVALID (length, identifier), STATUS_CLOSED.
status_t flow_can_send(flow_can_t* flow, uint16_t identifier, const uint8_t* octets, uint8_t length);
/// Queue process data: as an FD frame with bit rate switch if the bus carries FD (0..8, 12, 16, 20, 24, 32,
/// 48, 64 octets), otherwise as a classic frame (0..8 octets). Statuses of flow_can_send.
status_t flow_can_send_process_data(flow_can_t* flow, uint16_t identifier, const uint8_t* octets,
                                    uint8_t length);

/// Take the oldest data or remote frame. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t flow_can_receive(flow_can_t* flow, osal_can_frame_t* out_frame);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H
