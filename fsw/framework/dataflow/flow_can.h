// SPDX-License-Identifier: Apache-2.0
/// Data flow over one CAN controller: frames in both directions, and the condition of the bus.
///
/// Error frames are taken out of the stream: they change `health`, the caller of flow_can_receive sees data
/// frames only.
///
/// Ownership  The caller places flow_can_t; it must not be moved while open.
/// Context    One task. Never blocks. Time O(1).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "osal/include/osal/can.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum { // Error state of our controller, as its last error frame told.
    FLOW_CAN_ACTIVE,
    FLOW_CAN_WARNING, ///< An error counter has passed 96.
    FLOW_CAN_PASSIVE, ///< An error counter has passed 127.
    FLOW_CAN_BUS_OFF  ///< Off the bus; nothing is sent or received.
} flow_can_state_t;

typedef struct {
    flow_can_state_t state;
    bool is_unacknowledged; ///< Nobody acknowledges our frames; ends with the next frame received.
    uint8_t transmit_errors;
    uint8_t receive_errors;
} flow_can_health_t;

typedef struct { // [frames, wrap]
    uint32_t sent;
    uint32_t received;
    uint32_t errors;   ///< Error frames.
    uint32_t refused;  ///< Not sent: transmit queue full, closed, or a bad length.
    uint32_t overruns; ///< Received, but lost because the queue was full.
} flow_can_counters_t;

typedef struct { // Private, except health and counters: read-only.
    osal_can_t can;
    bool is_open;
    bool is_fd;
    flow_can_health_t health;
    flow_can_counters_t counters;
} flow_can_t;

/// Closed, counters zero. Once, before anything else.
void flow_can_init(flow_can_t* flow);
/// Open the bus of that name and throw away what stands in its receive queue. Health starts as ACTIVE.
/// STATUS_OK, STATUS_EXISTS (open already), STATUS_NOT_FOUND (resolver or bus), STATUS_INVALID (address),
/// STATUS_UNSUPPORTED, STATUS_DENIED, STATUS_IO.
MUST_USE status_t flow_can_open(flow_can_t* flow, const flow_resolver_t* resolver, const char* bus);
void flow_can_close(flow_can_t* flow);
bool flow_can_is_open(const flow_can_t* flow);

/// Queue a classic data frame, 0..8 octets, 11-bit identifier.
/// STATUS_OK, STATUS_FULL, STATUS_INVALID (length, identifier), STATUS_CLOSED.
status_t flow_can_send(flow_can_t* flow, uint16_t identifier, const uint8_t* octets, uint8_t length);
/// The same for process data: an FD frame with bit rate switch where the bus has it; 0..8, 12, 16, 20, 24,
/// 32, 48, 64 octets there, else 0..8. Statuses as flow_can_send.
status_t flow_can_send_process_data(flow_can_t* flow, uint16_t identifier, const uint8_t* octets,
                                    uint8_t length);

/// The oldest data or remote frame. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t flow_can_receive(flow_can_t* flow, osal_can_frame_t* out_frame);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_CAN_H
