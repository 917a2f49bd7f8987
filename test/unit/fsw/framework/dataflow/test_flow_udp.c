// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_udp.h"

#include "base/text.h"

#include "test/support/assertion.h"
#include "test/unit/fsw/framework/dataflow/sample_record.h"
#include "unity.h"

#include <string.h>
#include <unistd.h>

static flow_udp_t left;
static flow_udp_t right;
static quota_t quota;
static osal_socket_t stranger;
static osal_address_t addresses[3]; // Addresses of left, of right, and of no socket.

/// The names "0", "1", "2" have the addresses; the address of "text" has no port.
static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if ((kind != ENDNODE_UDP) || (strcmp(name, "moon") == 0)) {
        return STATUS_NOT_FOUND;
    }
    text_t text = text_in(out_address->address, sizeof out_address->address);
    text_add(&text, "127.0.0.1:");
    if (strcmp(name, "text") != 0) {
        text_add_unsigned(&text, addresses[name[0] - '0'].port);
    }
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

/// Find ports that are free.
static void find_ports(void)
{
    osal_socket_t sockets[3];
    const osal_address_t any = {OSAL_IPV4_LOOPBACK, 0U};
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&sockets[i], any, 0U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&sockets[i], &addresses[i]));
    }
    for (unsigned i = 0U; i < 3U; i++) {
        osal_socket_close(&sockets[i]);
    }
}

static void begin(flow_udp_t* const flow, const char* const local, const char* const peer)
{
    const flow_udp_setup_t setup = {
        .local = local, .peer = peer, .retry_first_ns = 10U, .retry_longest_ns = 40U, .quota = &quota};
    flow_udp_init(flow, &setup, &resolver);
}

void setUp(void)
{
    find_ports();
    quota_init(&quota, 4U);
    begin(&left, "0", "1");
    begin(&right, "1", "0");
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&left, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&right, 0U));
    TEST_ASSERT_EQUAL_UINT16(2U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&stranger, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
}

void tearDown(void)
{
    flow_udp_close(&left);
    flow_udp_close(&right);
    osal_socket_close(&stranger);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
}

static status_t receive(flow_udp_t* const flow, uint8_t* const octets, size_t* const size)
{
    const status_t status = osal_socket_wait_readable(&flow->socket, 200U);
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    return flow_udp_receive(flow, octets, 16U, size);
}

static void datagrams_pass_unchanged_in_both_directions(void)
{
    const uint8_t hello[5] = {'h', 'e', 'l', 'l', 'o'};
    uint8_t octets[16];
    size_t size = 99U;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_udp_receive(&right, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, hello, 5U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, hello, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
    TEST_ASSERT_EQUAL_UINT64(5U, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(hello, octets, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
    TEST_ASSERT_EQUAL_UINT64(2U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&right, hello, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, receive(&left, octets, &size));
    TEST_ASSERT_EQUAL_UINT32(2U, left.counters.sent);
    TEST_ASSERT_EQUAL_UINT32(1U, left.counters.received);
    TEST_ASSERT_EQUAL_UINT32(2U, right.counters.received);
}

static void datagrams_of_unknown_peers_and_too_long_ones_are_skipped(void)
{
    const uint8_t big[40] = {0U};
    uint8_t octets[16];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&stranger, addresses[1], big, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, big, 40U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, big, 7U));
    TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
    TEST_ASSERT_EQUAL_UINT64(7U, size);
    TEST_ASSERT_EQUAL_UINT32(1U, right.counters.other_senders);
    TEST_ASSERT_EQUAL_UINT32(1U, right.counters.oversize);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_udp_receive(&right, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
}

/// A sender that never pauses does not delay the cycle.
static void one_call_skips_a_limited_number_of_datagrams_of_other_senders(void)
{
    uint8_t octets[16] = {0U};
    size_t size        = 9U;
    for (unsigned i = 0U; i < 100U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&stranger, addresses[1], octets, 4U));
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, receive(&right, octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL_UINT32(64U, right.counters.other_senders);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&right, 1U)); // The flow stays open.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_udp_receive(&right, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT32(100U, right.counters.other_senders);
}

static void records_have_the_byte_order_of_the_flow(void)
{
    uint8_t octets[16];
    size_t size = 0U;
    for (unsigned order = 0U; order < (unsigned)FLOW_ORDERS; order++) {
        sample_t seen     = {.number = 9U};
        left.setup.order  = (flow_order_t)order;
        right.setup.order = (flow_order_t)order;
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_udp_receive_record(&right, &sample_layout, &seen));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send_record(&left, &sample_layout, &sample));
        TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
        TEST_ASSERT_EQUAL_UINT64(SAMPLE_OCTETS, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(sample_wire[order], octets, size);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, octets, size - 1U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&right.socket, 5000U));
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, flow_udp_receive_record(&right, &sample_layout, &seen));
        TEST_ASSERT_EQUAL_UINT32(order + 1U, right.counters.unfit);
        TEST_ASSERT_EQUAL_UINT16(9U, seen.number);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, octets, size));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&right.socket, 5000U));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_receive_record(&right, &sample_layout, &seen));
        TEST_ASSERT_TRUE(is_sample(&seen));
    }
    TEST_ASSERT_EQUAL_UINT32(2U, right.counters.unfit);
}

static void send_a_giant(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send_record(&left, &giant_layout, giant_record));
}

static void a_record_that_is_too_long_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(send_a_giant));
}

static void expect_refusal(flow_udp_t* const flow, const status_t why)
{
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_step(flow, 0U));
    TEST_ASSERT_EQUAL(why, flow->link.failure);
    TEST_ASSERT_EQUAL_UINT32(1U, flow->link.reconnect.failed);
    TEST_ASSERT_FALSE(flow_udp_is_open(flow));
}

static void a_refused_opening_is_counted_with_its_reason(void)
{
    flow_udp_t third;
    begin(&third, "moon", "1");
    expect_refusal(&third, STATUS_NOT_FOUND);
    begin(&third, "2", "moon");
    expect_refusal(&third, STATUS_NOT_FOUND);
    begin(&third, "text", "1");
    expect_refusal(&third, STATUS_INVALID);
    begin(&third, "2", "1");
    third.setup.receive_octets = 65536U;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&third, 0U));
    flow_udp_close(&third);
    flow_udp_close(&third);
    quota_init(&quota, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota)); // Takes the units of left and right.
    TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota));
    begin(&third, "2", "1");
    expect_refusal(&third, STATUS_EXHAUSTED);
}

static void a_port_in_use_is_tried_again_with_back_off(void)
{
    const uint8_t octets[2] = {1U, 2U};
    flow_udp_t third;
    begin(&third, "0", "1");
    expect_refusal(&third, STATUS_EXISTS);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_send(&third, octets, 2U));
    flow_udp_close(&left);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_step(&third, 9U)); // No attempt is made yet.
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&third, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&third, octets, 2U));
    TEST_ASSERT_EQUAL_UINT32(1U, third.link.reconnect.connected);
    TEST_ASSERT_EQUAL_UINT32(1U, third.counters.refused);
    flow_udp_close(&third);
}

/// The test closes the system's socket under the flow.
static void a_socket_that_fails_is_opened_again(void)
{
    const uint8_t hello[2] = {'h', 'i'};
    uint8_t octets[16];
    size_t size = 9U;
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(0, close(left.socket.descriptor));
        if (i == 0U) {
            TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_send(&left, hello, 2U));
        } else {
            TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_receive(&left, octets, sizeof octets, &size));
            TEST_ASSERT_EQUAL_UINT64(0U, size);
        }
        TEST_ASSERT_EQUAL(STATUS_IO, left.link.failure);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, left.link.reconnect.lost);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_step(&left, 100U * (i + 1U)));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, hello, 2U));
        TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, left.counters.refused);
}

static void a_refused_message_is_reported_with_its_reason(void)
{
    static const uint8_t giant[70000] = {0U};
    uint8_t octets[4];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, flow_udp_send(&left, giant, sizeof giant));
    flow_udp_close(&left);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_send(&left, giant, 1U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_udp_receive(&left, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT32(2U, left.counters.refused);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(datagrams_pass_unchanged_in_both_directions);
    RUN_TEST(datagrams_of_unknown_peers_and_too_long_ones_are_skipped);
    RUN_TEST(records_have_the_byte_order_of_the_flow);
    RUN_TEST(a_record_that_is_too_long_is_a_coding_error);
    RUN_TEST(one_call_skips_a_limited_number_of_datagrams_of_other_senders);
    RUN_TEST(a_refused_opening_is_counted_with_its_reason);
    RUN_TEST(a_port_in_use_is_tried_again_with_back_off);
    RUN_TEST(a_socket_that_fails_is_opened_again);
    RUN_TEST(a_refused_message_is_reported_with_its_reason);
    return UNITY_END();
}
