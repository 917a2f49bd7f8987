// SPDX-License-Identifier: Apache-2.0
// flow_can over SocketCAN, on a virtual interface that the test makes. On a kernel without SocketCAN the
// program only tests that opening is refused; test/hil runs it again on a kernel with SocketCAN.
#define _GNU_SOURCE
#include "fsw/framework/dataflow/flow_can.h"

#include "osal/include/osal/can_interface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "unity.h"

#define LABEL "flow test"
#define MS 1000000ULL

static char interface[16];
static char controllers[2][16]; // Two controllers on one bus, if the machine has them.
static bool is_fd;
static flow_can_t flow;
static osal_can_t peer;

static status_t resolve(void* context, flow_endnode_kind_t kind, const char* name,
                        flow_endnode_address_t* out_address)
{
    (void)context;
    (void)kind;
    (void)snprintf(out_address->address, sizeof out_address->address, "can:%s", name);
    out_address->is_fd = is_fd;
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    is_fd = true;
    flow_can_init(&flow);
}

void tearDown(void)
{
    flow_can_close(&flow);
    osal_can_close(&peer);
    (void)osal_can_interface_remove(interface);
}

static void a_missing_interface_is_refused(void)
{
    const status_t status = flow_can_open(&flow, &resolver, interface);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_FALSE(flow_can_is_open(&flow));
}

static void process_data_in_fd_frames_need_an_fd_interface(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(interface, false, LABEL));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, flow_can_open(&flow, &resolver, interface));
    is_fd = false;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, interface));
    const uint8_t octets[8] = {1U};
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send_process_data(&flow, 0x201U, octets, 8U));
}

static void a_lost_interface_is_bus_off_and_opened_again_when_it_is_back(void)
{
    osal_can_frame_t frame;
    uint64_t now_ns = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(interface, true, LABEL));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, interface));
    flow_can_attend(&flow, now_ns);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send(&flow, 0x080U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(interface));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_can_send(&flow, 0x080U, NULL, 0U));
    TEST_ASSERT_EQUAL(FLOW_CAN_BUS_OFF, flow.health.state);
    TEST_ASSERT_TRUE(flow_can_is_open(&flow));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_can_receive(&flow, &frame));
    for (unsigned i = 0U; i < 1000U; i++) { // Half a second at 2 kHz needs a few attempts, not a thousand.
        now_ns += MS / 2U;
        flow_can_attend(&flow, now_ns);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(0U, flow.counters.reopened);
    TEST_ASSERT_TRUE((flow.reconnect.failed >= 3U) && (flow.reconnect.failed <= 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(interface, true, LABEL));
    for (unsigned i = 0U; (i < 4000U) && (flow.counters.reopened == 0U); i++) {
        now_ns += MS / 2U;
        flow_can_attend(&flow, now_ns);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.reopened);
    TEST_ASSERT_EQUAL(FLOW_CAN_ACTIVE, flow.health.state);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_send(&flow, 0x080U, NULL, 0U));
}

static void error_frames_of_other_programs_are_received(void)
{
    osal_can_frame_t frame;
    char address[24];
    const osal_can_frame_t report = {.id = OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF, .length = 8U};
    const osal_can_frame_t beat   = {.id = 0x711U, .length = 1U, .data = {5U}};
    (void)snprintf(address, sizeof address, "can:%s", interface);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(interface, true, LABEL));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, interface));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&peer, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&peer, &report));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&peer, &beat));
    status_t status = STATUS_EMPTY;
    for (unsigned i = 0U; (i < 20000U) && (status == STATUS_EMPTY); i++) {
        status = flow_can_receive(&flow, &frame);
        (void)usleep(1000U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL_HEX32(0x711U, frame.id);
    TEST_ASSERT_EQUAL(FLOW_CAN_BUS_OFF, flow.health.state);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.errors.bus_offs);
}

static uint32_t arrived;
static uint32_t reports;

/// Read what the peer has received until no frame comes for a while. Returns true if the last one has
/// arrived.
static bool drain(void)
{
    osal_can_frame_t frame = {.id = 0U};
    for (unsigned idle = 0U; (idle < 50U) && (frame.id != 0x7FFU); idle++) {
        while ((frame.id != 0x7FFU) && (osal_can_receive(&peer, &frame) == STATUS_OK)) {
            const bool is_report = ((frame.id & OSAL_CAN_ERROR) != 0U);
            reports += is_report ? 1U : 0U;
            arrived += is_report ? 0U : 1U;
            idle = 0U;
        }
        (void)usleep(1000U);
    }
    return frame.id == 0x7FFU;
}

/// Two controllers on one bus: frames beyond the transmit queue are refused and counted, the accepted ones
/// arrive, and frames after the burst pass.
static void a_burst_on_a_controller_is_refused_and_counted(void)
{
    char address[24];
    const uint8_t octets[8] = {1U, 2U, 3U};
    (void)snprintf(address, sizeof address, "can:%s", controllers[1]);
    is_fd = false;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, controllers[0]));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&peer, address, OSAL_CAN_WIRE));
    for (unsigned i = 0U; (i < 200000U) && (flow.counters.full == 0U); i++) {
        (void)flow_can_send(&flow, 0x201U, octets, 8U);
    }
    TEST_ASSERT_TRUE(flow.counters.full > 0U);
    TEST_ASSERT_EQUAL_UINT32(flow.counters.full, flow.counters.refused);
    TEST_ASSERT_EQUAL(FLOW_CAN_ACTIVE, flow.health.state);
    // Now the queue has room for the last frame, which carries the count of dropped frames.
    TEST_ASSERT_FALSE(drain());
    status_t status = STATUS_FULL;
    for (unsigned i = 0U; (i < 20000U) && (status == STATUS_FULL); i++) {
        status = flow_can_send(&flow, 0x7FFU, octets, 8U);
        (void)usleep(1000U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    bool has_come = false;
    for (unsigned i = 0U; (i < 20000U) && !has_come; i++) {
        has_come = drain();
        (void)usleep(1000U);
    }
    TEST_ASSERT_TRUE(has_come);
    TEST_ASSERT_TRUE(arrived > 0U);
    // Each frame that the kernel drops is counted; the controller reports those that it drops.
    TEST_ASSERT_TRUE((arrived + peer.overruns) <= flow.counters.sent);
    TEST_ASSERT_TRUE(((arrived + peer.overruns) == flow.counters.sent) || (reports > 0U));
}

static bool can_make_vcan(void)
{
    const bool can = (osal_can_interface_create(interface, true, LABEL) == STATUS_OK);
    (void)osal_can_interface_remove(interface);
    return can;
}

int main(void)
{
    (void)snprintf(interface, sizeof interface, "vcf-%u", (unsigned)getpid() % 1000000U);
    peer.descriptor = -1;
    UNITY_BEGIN();
    RUN_TEST(a_missing_interface_is_refused);
    if (can_make_vcan()) {
        RUN_TEST(process_data_in_fd_frames_need_an_fd_interface);
        RUN_TEST(a_lost_interface_is_bus_off_and_opened_again_when_it_is_back);
        RUN_TEST(error_frames_of_other_programs_are_received);
    }
    const char* const both = getenv("CAN_CONTROLLERS"); // "can0 can1": both interfaces are up, 1 Mbit/s.
    if ((both != NULL) && (sscanf(both, "%15s %15s", controllers[0], controllers[1]) == 2)) {
        RUN_TEST(a_burst_on_a_controller_is_refused_and_counted);
    }
    return UNITY_END();
}
