// SPDX-License-Identifier: Apache-2.0
/// Fault confinement of one CAN controller: its error counters, its state, and its reports to software.
///
/// Counters change by the rules of ISO 11898-1: transmit error +8 (an error-passive transmitter that misses
/// an acknowledge keeps its counter, so a node alone on the bus becomes passive and never bus-off), receive
/// error +1, success -1 (127 for the receive counter of an error-passive node). State changes, the first
/// missing acknowledge and the end of bus-off are reported as SocketCAN error frames.
///
/// Ownership  The caller provides controller_t.
/// Time       O(1).
#ifndef SIM_BUS_CONTROLLER_H
#define SIM_BUS_CONTROLLER_H

#include "osal/include/osal/can.h"

#include <stdbool.h>
#include <stdint.h>

#define CONTROLLER_WARNING 96U         ///< Error count of the state error warning.
#define CONTROLLER_PASSIVE 128U        ///< Error count of the state error-passive.
#define CONTROLLER_BUS_OFF 256U        ///< Transmit error count of the state bus-off.
#define CONTROLLER_RECOVERY_BITS 1408U ///< Recessive bits that end bus-off: 128 times 11.

typedef enum {
    CONTROLLER_STATE_ACTIVE,
    CONTROLLER_STATE_WARNING,
    CONTROLLER_STATE_PASSIVE,
    CONTROLLER_STATE_BUS_OFF
} controller_state_t;

typedef struct {              // Read-only for others.
    uint32_t transmit_errors; ///< TEC, 0..256.
    uint32_t receive_errors;  ///< REC, 0..255.
    controller_state_t state;
    bool ack_reported; ///< A missing acknowledge has been reported since the last success.
} controller_t;

typedef enum {
    CONTROLLER_TRANSMITTED,    ///< Own frame transmitted successfully.
    CONTROLLER_RECEIVED,       ///< Frame of another node received.
    CONTROLLER_TRANSMIT_ERROR, ///< Bit, stuff, form or CRC error seen while transmitting.
    CONTROLLER_RECEIVE_ERROR,  ///< Error seen while receiving.
    CONTROLLER_NO_ACK,         ///< No node acknowledged.
    CONTROLLER_RECOVERED,      ///< Bus-off is over.
    CONTROLLER_EVENT_COUNT
} controller_event_t;

void controller_reset(controller_t* controller);

/// Account for one event. Returns true if the event is reported to software; *out_report is then the error
/// frame, complete except for its time.
bool controller_apply(controller_t* controller, controller_event_t event, osal_can_frame_t* out_report);

/// Returns an error frame of these classes with the present counters, without details and time.
osal_can_frame_t controller_report(const controller_t* controller, uint32_t classes);

#endif // SIM_BUS_CONTROLLER_H
