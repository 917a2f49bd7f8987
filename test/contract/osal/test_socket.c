// SPDX-License-Identifier: Apache-2.0
// Sockets, for each port: one with a network carries octets, one without refuses each kind of socket.
// posix/test_socket.c tests limits, unit/osal/freertos/test_wire.c the sockets that a wire serves.
#include "osal/include/osal/socket.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <string.h>

#define LONG_MS 20000U
#define UNKNOWN 7777 // Descriptor before a call that opens a socket; the call must replace it.

static const osal_address_t any_port = {OSAL_IPV4_LOOPBACK, 0U};
static const uint8_t words[]         = "words";
static osal_socket_t one             = OSAL_SOCKET_CLOSED;
static osal_socket_t other           = OSAL_SOCKET_CLOSED;
static osal_socket_t listener        = OSAL_SOCKET_CLOSED;
static osal_address_t from;
static uint8_t octets[16];
static size_t size;

void setUp(void)
{
}

void tearDown(void)
{
    osal_socket_close(&one);
    osal_socket_close(&other);
    osal_socket_close(&listener);
}

static void a_closed_socket_has_no_descriptor(void)
{
    osal_socket_close(&one); // No effect.
    TEST_ASSERT_FALSE(osal_socket_is_open(&one));
    TEST_ASSERT_EQUAL(-1, osal_socket_descriptor(&one));
}

static void a_closed_socket_carries_nothing(void)
{
    TEST_ASSERT_EQUAL(STATUS_IO, osal_udp_send(&one, any_port, words, sizeof words));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_udp_receive(&one, &from, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_stream_send(&one, words, sizeof words, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_stream_receive(&one, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
}

static void a_number_that_is_no_socket_is_not_adopted(void)
{
    static const int numbers[] = {-1, 12345};
    for (size_t i = 0U; i < (sizeof numbers / sizeof numbers[0]); i++) {
        one.descriptor = UNKNOWN;
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_socket_adopt(&one, numbers[i]));
        TEST_ASSERT_FALSE(osal_socket_is_open(&one));
    }
}

static void datagrams_pass_between_two_ports(void)
{
    one.descriptor        = UNKNOWN;
    other.descriptor      = UNKNOWN;
    const status_t status = osal_udp_open(&one, any_port, 0U);
    TEST_ASSERT_EQUAL(status, osal_udp_open(&other, any_port, 0U));
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&one));
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&other));
    if (status == STATUS_UNSUPPORTED) {
        return;
    }
    osal_address_t to;
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&other, &from, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&other, &to));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&one, to, words, sizeof words));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&other, LONG_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&other, &from, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(sizeof words, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(words, octets, size);
}

static void octets_pass_on(osal_socket_t* const sender, osal_socket_t* const receiver)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(sender, words, sizeof words, &size));
    TEST_ASSERT_EQUAL_UINT64(sizeof words, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(receiver, LONG_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(sizeof words, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(words, octets, size);
}

static void a_connection_carries_octets_both_ways(void)
{
    osal_address_t to     = any_port;
    listener.descriptor   = UNKNOWN;
    const status_t status = osal_tcp_listen(&listener, any_port);
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&listener));
    if (status == STATUS_UNSUPPORTED) {
        one.descriptor   = UNKNOWN;
        other.descriptor = UNKNOWN;
        TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_tcp_connect_begin(&one, any_port));
        TEST_ASSERT_FALSE(osal_socket_is_open(&one));
        TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_tcp_accept(&listener, &other, &from));
        TEST_ASSERT_FALSE(osal_socket_is_open(&other));
        return;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&listener, &to));
    const status_t begun = osal_tcp_connect_begin(&one, to);
    TEST_ASSERT_TRUE((begun == STATUS_OK) || (begun == STATUS_BUSY));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&listener, LONG_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&listener, &other, &from));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_writable(&one, LONG_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_connect_result(&one));
    octets_pass_on(&one, &other);
    octets_pass_on(&other, &one);
}

static void a_local_pair_carries_octets_both_ways(void)
{
    one.descriptor        = UNKNOWN;
    other.descriptor      = UNKNOWN;
    const status_t status = osal_local_pair(&one, &other);
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&one));
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&other));
    if (status != STATUS_UNSUPPORTED) {
        TEST_ASSERT_EQUAL(STATUS_OK, status);
        octets_pass_on(&one, &other);
        octets_pass_on(&other, &one);
    }
}

static void a_local_name_that_is_too_long_is_refused(void)
{
    char path[200];
    (void)memset(path, 'n', sizeof path);
    path[sizeof path - 1U] = '\0';
    listener.descriptor    = UNKNOWN;
    const status_t status  = osal_local_listen(&listener, path);
    TEST_ASSERT_TRUE((status == STATUS_INVALID) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_FALSE(osal_socket_is_open(&listener));
}

static void open_nothing(void)
{
    const status_t status = osal_udp_open(NULL, any_port, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, status); // Is not reached.
}

static void close_nothing(void)
{
    osal_socket_close(NULL);
}

static void a_null_argument_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(open_nothing));
    TEST_ASSERT_TRUE(assertion_fails(close_nothing));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_closed_socket_has_no_descriptor);
    RUN_TEST(a_closed_socket_carries_nothing);
    RUN_TEST(a_number_that_is_no_socket_is_not_adopted);
    RUN_TEST(datagrams_pass_between_two_ports);
    RUN_TEST(a_connection_carries_octets_both_ways);
    RUN_TEST(a_local_pair_carries_octets_both_ways);
    RUN_TEST(a_local_name_that_is_too_long_is_refused);
    RUN_TEST(a_null_argument_is_a_coding_error);
    return UNITY_END();
}
