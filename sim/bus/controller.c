// SPDX-License-Identifier: Apache-2.0
#include "sim/bus/controller.h"

#include <stddef.h>

#define TRANSMIT_STEP 8U   // Increase of the transmit error counter for an error.
#define RECEIVE_LIMIT 255U // Maximum of the receive error counter.
#define AFTER_PASSIVE 127U // Count of an error-passive receiver after a success.

// data[1] of a SocketCAN controller report.
#define REPORT_RX_WARNING 0x04U
#define REPORT_TX_WARNING 0x08U
#define REPORT_RX_PASSIVE 0x10U
#define REPORT_TX_PASSIVE 0x20U
#define REPORT_ACTIVE 0x40U

void controller_reset(controller_t* const controller)
{
    *controller = (controller_t){.state = CONTROLLER_STATE_ACTIVE};
}

static controller_state_t state_of(const uint32_t errors)
{
    if (errors >= CONTROLLER_BUS_OFF) {
        return CONTROLLER_STATE_BUS_OFF;
    }
    if (errors >= CONTROLLER_PASSIVE) {
        return CONTROLLER_STATE_PASSIVE;
    }
    return (errors >= CONTROLLER_WARNING) ? CONTROLLER_STATE_WARNING : CONTROLLER_STATE_ACTIVE;
}

static void add_transmit_errors(controller_t* const controller)
{
    const uint32_t sum          = controller->transmit_errors + TRANSMIT_STEP;
    controller->transmit_errors = (sum < CONTROLLER_BUS_OFF) ? sum : CONTROLLER_BUS_OFF;
}

static void count(controller_t* const controller, const controller_event_t event)
{
    switch (event) {
    case CONTROLLER_TRANSMITTED:
        controller->transmit_errors -= (controller->transmit_errors > 0U) ? 1U : 0U;
        controller->ack_reported = false;
        break;
    case CONTROLLER_RECEIVED:
        if (controller->receive_errors >= CONTROLLER_PASSIVE) {
            controller->receive_errors = AFTER_PASSIVE;
        } else {
            controller->receive_errors -= (controller->receive_errors > 0U) ? 1U : 0U;
        }
        break;
    case CONTROLLER_TRANSMIT_ERROR:
        add_transmit_errors(controller);
        break;
    case CONTROLLER_RECEIVE_ERROR:
        controller->receive_errors += (controller->receive_errors < RECEIVE_LIMIT) ? 1U : 0U;
        break;
    // Exception of ISO 11898-1: an error-passive controller does not count a missing acknowledgement, so a
    // controller that is alone on a bus does not go to bus-off.
    case CONTROLLER_NO_ACK:
        if (controller->transmit_errors < CONTROLLER_PASSIVE) {
            add_transmit_errors(controller);
        }
        break;
    case CONTROLLER_RECOVERED:
    case CONTROLLER_EVENT_COUNT:
        controller_reset(controller);
        break;
    }
}

static uint8_t state_report(const controller_t* const controller)
{
    const controller_state_t transmit = state_of(controller->transmit_errors);
    const controller_state_t receive  = state_of(controller->receive_errors);
    uint32_t bits                     = 0U;
    switch (controller->state) {
    case CONTROLLER_STATE_ACTIVE:
        bits = REPORT_ACTIVE;
        break;
    case CONTROLLER_STATE_WARNING:
        bits = ((transmit == CONTROLLER_STATE_WARNING) ? REPORT_TX_WARNING : 0U) |
               ((receive == CONTROLLER_STATE_WARNING) ? REPORT_RX_WARNING : 0U);
        break;
    case CONTROLLER_STATE_PASSIVE:
        bits = ((transmit == CONTROLLER_STATE_PASSIVE) ? REPORT_TX_PASSIVE : 0U) |
               ((receive == CONTROLLER_STATE_PASSIVE) ? REPORT_RX_PASSIVE : 0U);
        break;
    case CONTROLLER_STATE_BUS_OFF:
        break;
    }
    return (uint8_t)bits;
}

static controller_state_t present_state(const controller_t* const controller)
{
    const controller_state_t transmit = state_of(controller->transmit_errors);
    const controller_state_t receive  = state_of(controller->receive_errors);
    return (transmit > receive) ? transmit : receive;
}

osal_can_frame_t controller_report(const controller_t* const controller, const uint32_t classes)
{
    const uint32_t limited = (controller->transmit_errors < 255U) ? controller->transmit_errors : 255U;
    return (osal_can_frame_t){.id     = OSAL_CAN_ERROR | classes,
                              .length = 8U,
                              .data   = {[6] = (uint8_t)limited, [7] = (uint8_t)controller->receive_errors}};
}

bool controller_apply(controller_t* const controller, const controller_event_t event,
                      osal_can_frame_t* const out_report)
{
    const controller_state_t before = controller->state;
    if ((before == CONTROLLER_STATE_BUS_OFF) && (event != CONTROLLER_RECOVERED)) {
        return false; // A controller that is bus-off neither sends nor receives.
    }
    if (((event == CONTROLLER_TRANSMITTED) && (controller->transmit_errors == 0U) &&
         !controller->ack_reported) ||
        ((event == CONTROLLER_RECEIVED) && (controller->receive_errors == 0U))) {
        return false; // Most frequent case: no counter changes.
    }
    count(controller, event);
    controller->state = present_state(controller);

    uint32_t classes = 0U;
    uint8_t detail   = 0U;
    if ((event == CONTROLLER_NO_ACK) && !controller->ack_reported) {
        controller->ack_reported = true;
        classes |= OSAL_CAN_ERROR_NO_ACK;
    }
    if (event == CONTROLLER_RECOVERED) {
        classes |= OSAL_CAN_ERROR_RESTARTED;
    }
    if (controller->state != before) {
        detail = state_report(controller);
        classes |= (controller->state == CONTROLLER_STATE_BUS_OFF) ? OSAL_CAN_ERROR_BUS_OFF
                                                                   : OSAL_CAN_ERROR_CONTROLLER;
    }
    if (classes == 0U) {
        return false;
    }
    *out_report         = controller_report(controller, classes);
    out_report->data[1] = detail;
    return true;
}
