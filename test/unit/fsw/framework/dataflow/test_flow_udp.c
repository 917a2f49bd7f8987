// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_udp.h"

#include "fsw/framework/base/text.h"

#include "unity.h"

#include <string.h>

static flow_udp_t left;
static flow_udp_t right;
static osal_socket_t stranger;
static osal_address_t addresses[3]; // Of left, right, and one without a socket.

/// Names "0", "1", "2" are the addresses; "text" is no address.
static status_t resolve(void* const context, const endnode_kind_t kind, const char* const name,
                        endnode_address_t* const out_address)
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

/// Ports that are free now.
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

void setUp(void)
{
    find_ports();
    flow_udp_init(&left);
    flow_udp_init(&right);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_open(&left, &resolver, "0", "1", 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_open(&right, &resolver, "1", "0", 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&stranger, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
}

void tearDown(void)
{
    flow_udp_close(&left);
    flow_udp_close(&right);
    osal_socket_close(&stranger);
}

static status_t receive(flow_udp_t* const flow, uint8_t* const octets, size_t* const size)
{
    const status_t status = osal_socket_wait_readable(&flow->socket, 200U);
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    return flow_udp_receive(flow, octets, 16U, size);
}

static void datagrams_go_both_ways_whole(void)
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

static void strangers_and_giants_are_passed_over(void)
{
    const uint8_t big[40] = {0U};
    uint8_t octets[16];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&stranger, addresses[1], big, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, big, 40U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_send(&left, big, 7U));
    TEST_ASSERT_EQUAL(STATUS_OK, receive(&right, octets, &size));
    TEST_ASSERT_EQUAL_UINT64(7U, size);
    TEST_ASSERT_EQUAL_UINT32(1U, right.counters.foreign);
    TEST_ASSERT_EQUAL_UINT32(1U, right.counters.oversize);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_udp_receive(&right, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
}

static void opening_is_refused_for_a_reason(void)
{
    flow_udp_t third;
    flow_udp_init(&third);
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_udp_open(&left, &resolver, "0", "1", 0U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_udp_open(&third, &resolver, "0", "1", 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_udp_open(&third, &resolver, "moon", "1", 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_udp_open(&third, &resolver, "2", "moon", 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_udp_open(&third, &resolver, "text", "1", 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_udp_open(&third, &resolver, "2", "1", 65536U));
    flow_udp_close(&third);
    flow_udp_close(&third);
}

static void sending_is_refused_for_a_reason(void)
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
    RUN_TEST(datagrams_go_both_ways_whole);
    RUN_TEST(strangers_and_giants_are_passed_over);
    RUN_TEST(opening_is_refused_for_a_reason);
    RUN_TEST(sending_is_refused_for_a_reason);
    return UNITY_END();
}
