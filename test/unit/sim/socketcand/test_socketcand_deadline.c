// SPDX-License-Identifier: Apache-2.0
// The longest wait for tools in lock-step. The wall clock is replaced: it moves only by waiting.
#include "osal/include/osal/clock.h"
#include "osal/include/osal/socket.h"
#include "sim/socketcand/socketcand.h"
#include "test/support/clients.h"
#include "unity.h"

#include <string.h>

#define NS_PER_MS 1000000U
#define TIMEOUT_MS 20000U

static bus_t* bus;
static socketcand_t* server;
static uint64_t wall_ns;

uint64_t __wrap_osal_clock_monotonic_ns(void);
status_t __wrap_osal_socket_wait_readable(osal_socket_t* socket, uint32_t timeout_ms);

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return wall_ns;
}

status_t __wrap_osal_socket_wait_readable(osal_socket_t* const socket, const uint32_t timeout_ms)
{
    (void)socket;
    wall_ns += (uint64_t)timeout_ms * NS_PER_MS;
    return STATUS_TIMEOUT;
}

void setUp(void)
{
    const bus_config_t config = {.nominal_bit_rate = 1000000U, .seed = 1U};
    bus                       = bus_create(&config);
    TEST_ASSERT_NOT_NULL(bus);
    const socketcand_bus_t buses[] = {{"robot", bus}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, socketcand_open(0U, buses, 1U, &server));
    wall_ns = 0U;
}

void tearDown(void)
{
    socketcand_close(server);
    bus_destroy(bus);
}

static void say(osal_socket_t* const client, const char* const text)
{
    size_t sent = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_stream_send(client, (const uint8_t*)text, strlen(text), &sent));
    TEST_ASSERT_EQUAL_UINT(strlen(text), sent);
}

/// A client in lock-step from now on.
static osal_socket_t join(void)
{
    osal_socket_t client    = OSAL_SOCKET_CLOSED;
    const osal_address_t to = {.ipv4 = OSAL_IPV4_LOOPBACK, .port = socketcand_port(server)};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, connect_tcp(&client, to));
    say(&client, "< open robot >< rawmode >< step 1 >");
    for (unsigned i = 0U; i < 140U; i++) { // The server checks for clients only once in several calls.
        (void)socketcand_receive(server);
    }
    return client;
}

static void silent_clients_are_waited_for_at_the_same_time(void)
{
    osal_socket_t clients[3];
    for (unsigned i = 0U; i < 3U; i++) {
        clients[i] = join();
    }
    TEST_ASSERT_EQUAL_UINT(3U, socketcand_end_step(server, 500U * 1000U, TIMEOUT_MS));
    TEST_ASSERT_TRUE(wall_ns >= ((uint64_t)TIMEOUT_MS * NS_PER_MS));
    TEST_ASSERT_TRUE(wall_ns <= ((TIMEOUT_MS + 1ULL) * NS_PER_MS));
    for (unsigned i = 0U; i < 3U; i++) {
        osal_socket_close(&clients[i]);
    }
}

static void a_client_that_has_answered_stays_although_an_earlier_one_is_silent(void)
{
    osal_socket_t silent = join();
    osal_socket_t fast   = join();
    say(&fast, "< step 1 >");
    TEST_ASSERT_EQUAL_UINT(1U, socketcand_end_step(server, 500U * 1000U, TIMEOUT_MS));
    say(&fast, "< step 1 >");
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 1000U * 1000U, TIMEOUT_MS));
    osal_socket_close(&silent);
    osal_socket_close(&fast);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(silent_clients_are_waited_for_at_the_same_time);
    RUN_TEST(a_client_that_has_answered_stays_although_an_earlier_one_is_silent);
    return UNITY_END();
}
