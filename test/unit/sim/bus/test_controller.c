// SPDX-License-Identifier: Apache-2.0
// Fault confinement: counters, thresholds and reports of one controller.
#include "sim/bus/controller.h"
#include "unity.h"

// data[1] of an error frame with the class OSAL_CAN_ERROR_CONTROLLER; data[6] and data[7] are the transmit
// and the receive error counter.
#define RX_WARNING 0x04U
#define TX_WARNING 0x08U
#define RX_PASSIVE 0x10U
#define TX_PASSIVE 0x20U
#define ACTIVE_AGAIN 0x40U

static controller_t controller;
static osal_can_frame_t report;

void setUp(void)
{
    controller_reset(&controller);
}

void tearDown(void)
{
}

static unsigned apply(controller_event_t event, unsigned times)
{
    unsigned reports = 0U;
    for (unsigned i = 0U; i < times; i++) {
        reports += controller_apply(&controller, event, &report) ? 1U : 0U;
    }
    return reports;
}

static void transmit_errors_lead_to_bus_off_in_32_steps(void)
{
    // Each error adds 8: warning at 96 (12 errors), error passive at 128 (16), bus-off at 256 (32).
    TEST_ASSERT_EQUAL_UINT(0U, apply(CONTROLLER_TRANSMIT_ERROR, 11U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, controller.state);
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_TRANSMIT_ERROR, 1U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_WARNING, controller.state);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_CONTROLLER, report.id);
    TEST_ASSERT_EQUAL_HEX8(TX_WARNING, report.data[1]);
    TEST_ASSERT_EQUAL_UINT8(96U, report.data[6]);
    TEST_ASSERT_EQUAL_UINT8(0U, report.data[7]);
    TEST_ASSERT_EQUAL_UINT(0U, apply(CONTROLLER_TRANSMIT_ERROR, 3U));
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_TRANSMIT_ERROR, 1U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, controller.state);
    TEST_ASSERT_EQUAL_HEX8(TX_PASSIVE, report.data[1]);
    TEST_ASSERT_EQUAL_UINT(0U, apply(CONTROLLER_TRANSMIT_ERROR, 15U));
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_TRANSMIT_ERROR, 1U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_BUS_OFF, controller.state);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF, report.id);
    TEST_ASSERT_EQUAL_UINT8(255U, report.data[6]);
}

static void only_a_recovery_ends_bus_off(void)
{
    (void)apply(CONTROLLER_TRANSMIT_ERROR, 32U);
    for (unsigned event = 0U; event < CONTROLLER_RECOVERED; event++) {
        TEST_ASSERT_EQUAL_UINT(0U, apply((controller_event_t)event, 3U));
        TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_BUS_OFF, controller.state);
    }
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_RECOVERED, 1U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, controller.state);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_RESTARTED | OSAL_CAN_ERROR_CONTROLLER, report.id);
    TEST_ASSERT_EQUAL_HEX8(ACTIVE_AGAIN, report.data[1]);
}

static void missing_acknowledgements_lead_to_error_passive_and_no_further(void)
{
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_NO_ACK, 1U));
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_NO_ACK, report.id);
    // Reports of warning and error passive, and no further report.
    TEST_ASSERT_EQUAL_UINT(2U, apply(CONTROLLER_NO_ACK, 1000U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, controller.state);
    TEST_ASSERT_EQUAL_UINT32(128U, controller.transmit_errors);
    // A success counts down by one and allows the next report.
    (void)apply(CONTROLLER_TRANSMITTED, 1U);
    TEST_ASSERT_EQUAL_UINT32(127U, controller.transmit_errors);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_WARNING, controller.state);
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_NO_ACK, 1U));
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_NO_ACK | OSAL_CAN_ERROR_CONTROLLER, report.id);
}

static void successful_frames_lead_back_to_error_active(void)
{
    (void)apply(CONTROLLER_TRANSMIT_ERROR, 16U);
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_TRANSMITTED, 1U)); // 127: warning
    TEST_ASSERT_EQUAL_HEX8(TX_WARNING, report.data[1]);
    TEST_ASSERT_EQUAL_UINT(0U, apply(CONTROLLER_TRANSMITTED, 31U));
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_TRANSMITTED, 1U)); // 95
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, controller.state);
    TEST_ASSERT_EQUAL_HEX8(ACTIVE_AGAIN, report.data[1]);
    TEST_ASSERT_EQUAL_UINT(0U, apply(CONTROLLER_TRANSMITTED, 200U));
    TEST_ASSERT_EQUAL_UINT32(0U, controller.transmit_errors);
}

static void receive_errors_lead_to_error_passive_but_never_to_bus_off(void)
{
    TEST_ASSERT_EQUAL_UINT(2U, apply(CONTROLLER_RECEIVE_ERROR, 1000U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, controller.state);
    TEST_ASSERT_EQUAL_HEX8(RX_PASSIVE, report.data[1]);
    TEST_ASSERT_EQUAL_UINT32(255U, controller.receive_errors);
    // One good frame lowers the counter of a passive receiver below the limit.
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_RECEIVED, 1U));
    TEST_ASSERT_EQUAL_UINT32(127U, controller.receive_errors);
    TEST_ASSERT_EQUAL_HEX8(RX_WARNING, report.data[1]);
}

static void the_higher_counter_decides_the_state(void)
{
    (void)apply(CONTROLLER_TRANSMIT_ERROR, 12U);
    TEST_ASSERT_EQUAL_UINT(1U, apply(CONTROLLER_RECEIVE_ERROR, 128U));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, controller.state);
    TEST_ASSERT_EQUAL_HEX8(RX_PASSIVE, report.data[1]); // Only the receive counter is at error passive.
    (void)apply(CONTROLLER_RECEIVED, 1U);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_WARNING, controller.state);
    TEST_ASSERT_EQUAL_HEX8(RX_WARNING | TX_WARNING,
                           report.data[1]); // Both counters are at the warning limit.
}

static void states_follow_the_counters_in_any_sequence(void)
{
    uint32_t random = 1U;
    for (unsigned i = 0U; i < 200000U; i++) {
        random                            = (random * 1664525U) + 1013904223U;
        const controller_state_t before   = controller.state;
        const controller_event_t event    = (controller_event_t)((random >> 16) % CONTROLLER_EVENT_COUNT);
        const bool is_reported            = controller_apply(&controller, event, &report);
        const uint32_t worse              = (controller.transmit_errors > controller.receive_errors)
                                                ? controller.transmit_errors
                                                : controller.receive_errors;
        const controller_state_t expected = (controller.transmit_errors >= 256U) ? CONTROLLER_STATE_BUS_OFF
                                            : (worse >= 128U)                    ? CONTROLLER_STATE_PASSIVE
                                            : (worse >= 96U)                     ? CONTROLLER_STATE_WARNING
                                                                                 : CONTROLLER_STATE_ACTIVE;
        TEST_ASSERT_EQUAL_INT(expected, controller.state);
        TEST_ASSERT_TRUE(is_reported || (before == controller.state));
        TEST_ASSERT_TRUE(controller.receive_errors <= 255U);
        TEST_ASSERT_TRUE(controller.transmit_errors <= 256U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(transmit_errors_lead_to_bus_off_in_32_steps);
    RUN_TEST(only_a_recovery_ends_bus_off);
    RUN_TEST(missing_acknowledgements_lead_to_error_passive_and_no_further);
    RUN_TEST(successful_frames_lead_back_to_error_active);
    RUN_TEST(receive_errors_lead_to_error_passive_but_never_to_bus_off);
    RUN_TEST(the_higher_counter_decides_the_state);
    RUN_TEST(states_follow_the_counters_in_any_sequence);
    return UNITY_END();
}
