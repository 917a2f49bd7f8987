// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_can.h"
#include "test/support/scripted_bus.h"

#include "unity.h"

#include <string.h>

static scripted_bus_t bus;
static flow_can_t flow;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)kind;
    if (strcmp(name, "robot") != 0) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, bus.address);
    out_address->is_fd = *(const bool*)context;
    return STATUS_OK;
}

static bool is_fd;
static const flow_resolver_t resolver = {&is_fd, resolve};

void setUp(void)
{
    scripted_bus_open(&bus, "test-flow-can");
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    is_fd = true;
    flow_can_init(&flow);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
}

void tearDown(void)
{
    flow_can_close(&flow);
    scripted_bus_close(&bus);
}

static void a_bus_is_opened_by_name_and_only_once(void)
{
    TEST_ASSERT_TRUE(flow_can_is_open(&flow));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_can_open(&flow, &resolver, "robot"));
    flow_can_close(&flow);
    flow_can_close(&flow);
    TEST_ASSERT_FALSE(flow_can_is_open(&flow));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_can_open(&flow, &resolver, "moon"));
    scripted_bus_close(&bus);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_can_open(&flow, &resolver, "robot"));
    TEST_ASSERT_EQUAL_UINT32(2U, flow.counters.failed);
    scripted_bus_open(&bus, "test-flow-can");
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
}

static void frames_have_the_format_of_the_bus(void)
{
    const uint8_t octets[8] = {1U, 2U, 3U};
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send(&flow, 0x080U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send_process_data(&flow, 0x211U, octets, 8U));
    flow_can_close(&flow);
    is_fd = false;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send_process_data(&flow, 0x7FFU, octets, 3U));
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL_UINT(3U, bus.seen_count);
    TEST_ASSERT_EQUAL_HEX8(0U, bus.seen[0].flags);
    TEST_ASSERT_EQUAL_HEX8(OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, bus.seen[1].flags);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, bus.seen[1].data, 8U);
    TEST_ASSERT_EQUAL_HEX8(0U, bus.seen[2].flags);
    TEST_ASSERT_EQUAL_HEX32(0x7FFU, bus.seen[2].id);
    TEST_ASSERT_EQUAL_UINT8(3U, bus.seen[2].length);
    TEST_ASSERT_EQUAL_UINT32(3U, flow.counters.sent);
}

static void each_refusal_is_counted(void)
{
    const uint8_t octets[64] = {0U};
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_can_send(&flow, 0x100U, octets, 9U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_can_send(&flow, 0x800U, octets, 8U));
    // 9 octets are not a length of FD frames.
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_can_send_process_data(&flow, 0x100U, octets, 9U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_can_send_process_data(&flow, 0x100U, octets, 65U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send_process_data(&flow, 0x100U, octets, 64U));
    TEST_ASSERT_EQUAL_UINT32(4U, flow.counters.refused);
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i <= OSAL_CAN_RING_FRAMES) && (status == STATUS_OK); i++) {
        status = flow_can_send(&flow, 0x100U, octets, 8U);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_EQUAL_UINT32(5U, flow.counters.refused);
    flow_can_close(&flow);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_can_send(&flow, 0x100U, octets, 8U));
    osal_can_frame_t frame;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_can_receive(&flow, &frame));
    TEST_ASSERT_EQUAL_UINT32(6U, flow.counters.refused);
}

static void error_frames_determine_the_health_of_the_bus(void)
{
    const struct {
        uint32_t class;
        uint8_t detail;
        flow_can_state_t state;
    } steps[] = {{OSAL_CAN_ERROR_CONTROLLER, 0x08U, FLOW_CAN_WARNING},
                 {OSAL_CAN_ERROR_CONTROLLER, 0x04U, FLOW_CAN_WARNING},
                 {OSAL_CAN_ERROR_CONTROLLER, 0x20U, FLOW_CAN_PASSIVE},
                 {OSAL_CAN_ERROR_BUS_OFF, 0x00U, FLOW_CAN_BUS_OFF},
                 {OSAL_CAN_ERROR_BUS, 0x00U, FLOW_CAN_BUS_OFF},
                 {OSAL_CAN_ERROR_RESTARTED, 0x00U, FLOW_CAN_ACTIVE},
                 {OSAL_CAN_ERROR_CONTROLLER, 0x10U, FLOW_CAN_PASSIVE},
                 {OSAL_CAN_ERROR_CONTROLLER, 0x40U, FLOW_CAN_ACTIVE}};
    osal_can_frame_t frame;
    for (unsigned i = 0U; i < (sizeof steps / sizeof steps[0]); i++) {
        scripted_bus_error(&bus, steps[i].class, steps[i].detail);
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
        TEST_ASSERT_EQUAL(steps[i].state, flow.health.state);
        TEST_ASSERT_EQUAL_UINT8(96U, flow.health.transmit_errors);
    }
    TEST_ASSERT_EQUAL_UINT32(8U, flow.counters.errors);
    TEST_ASSERT_EQUAL_UINT32(0U, flow.counters.received);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x01U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.overruns);
}

static void error_frames_are_counted_by_class(void)
{
    osal_can_frame_t frame;
    static const uint32_t classes[] = {OSAL_CAN_ERROR_TX_TIMEOUT,  OSAL_CAN_ERROR_LOST_ARBITRATION,
                                       OSAL_CAN_ERROR_CONTROLLER,  OSAL_CAN_ERROR_PROTOCOL,
                                       OSAL_CAN_ERROR_TRANSCEIVER, OSAL_CAN_ERROR_NO_ACK,
                                       OSAL_CAN_ERROR_BUS_OFF,     OSAL_CAN_ERROR_BUS,
                                       OSAL_CAN_ERROR_RESTARTED};
    const uint32_t* const counted   = &flow.errors.transmit_timeouts;
    for (unsigned i = 0U; i < 9U; i++) {
        for (unsigned k = 0U; k <= i; k++) {
            scripted_bus_error(&bus, classes[i], 0U);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    for (unsigned i = 0U; i < 9U; i++) {
        TEST_ASSERT_EQUAL_UINT32(i + 1U, counted[i]);
    }
    TEST_ASSERT_EQUAL_UINT32(45U, flow.counters.errors);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_BUS | OSAL_CAN_ERROR_PROTOCOL, 0U); // One frame, two classes.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    TEST_ASSERT_EQUAL_UINT32(5U, flow.errors.protocol_violations);
    TEST_ASSERT_EQUAL_UINT32(9U, flow.errors.bus_errors);
}

static void a_missing_acknowledge_lasts_until_another_node_is_heard(void)
{
    osal_can_frame_t frame;
    scripted_bus_error(&bus, OSAL_CAN_ERROR_NO_ACK, 0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    TEST_ASSERT_TRUE(flow.health.is_unacknowledged);
    scripted_bus_heartbeat(&bus);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_receive(&flow, &frame));
    TEST_ASSERT_FALSE(flow.health.is_unacknowledged);
    TEST_ASSERT_EQUAL_HEX32(0x711U, frame.id);
}

static void frames_received_before_opening_are_discarded(void)
{
    osal_can_frame_t frame;
    flow_can_close(&flow);
    for (unsigned i = 0U; i < 20U; i++) {
        scripted_bus_heartbeat(&bus);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    scripted_bus_heartbeat(&bus);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_receive(&flow, &frame));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_bus_is_opened_by_name_and_only_once);
    RUN_TEST(frames_have_the_format_of_the_bus);
    RUN_TEST(each_refusal_is_counted);
    RUN_TEST(error_frames_determine_the_health_of_the_bus);
    RUN_TEST(error_frames_are_counted_by_class);
    RUN_TEST(a_missing_acknowledge_lasts_until_another_node_is_heard);
    RUN_TEST(frames_received_before_opening_are_discarded);
    return UNITY_END();
}
