// SPDX-License-Identifier: Apache-2.0
// UDP, TCP and local sockets of this machine.
#define _GNU_SOURCE
#include "osal/include/osal/socket.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "test/support/clients.h"
#include "unity.h"

static const osal_address_t any_port = {OSAL_IPV4_LOOPBACK, 0U};
static osal_socket_t a               = OSAL_SOCKET_CLOSED;
static osal_socket_t b               = OSAL_SOCKET_CLOSED;
static osal_socket_t c               = OSAL_SOCKET_CLOSED;
static char path[64];

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/osal-socket-test-%d", (int)getpid());
}

void tearDown(void)
{
    osal_socket_close(&a);
    osal_socket_close(&b);
    osal_socket_close(&c);
    (void)unlink(path);
}

static osal_address_t address_of(const osal_socket_t* sock)
{
    osal_address_t address;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(sock, &address));
    return address;
}

// ---- UDP ----

static void udp_carries_whole_datagrams_in_order(void)
{
    uint8_t in[2048];
    uint8_t out[2048];
    osal_address_t from;
    size_t size = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 1000000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&b, any_port, 0U));
    TEST_ASSERT_TRUE(address_of(&a).port != 0U);
    TEST_ASSERT_EQUAL_HEX32(OSAL_IPV4_LOOPBACK, address_of(&a).ipv4);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(0U, size);
    for (size_t length = 0U; length <= 1000U; length += 100U) {
        memset(out, (int)length, sizeof out);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&b, address_of(&a), out, length));
    }
    for (size_t length = 0U; length <= 1000U; length += 100U) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
        TEST_ASSERT_EQUAL(length, size);
        TEST_ASSERT_EQUAL_UINT16(address_of(&b).port, from.port);
        TEST_ASSERT_EQUAL_HEX32(OSAL_IPV4_LOOPBACK, from.ipv4);
        if (size > 0U) {
            TEST_ASSERT_EACH_EQUAL_HEX8(length & 0xFFU, in, size);
        }
    }
}

static void a_udp_datagram_that_is_too_large_is_refused_or_dropped_and_the_next_one_arrives(void)
{
    static uint8_t huge[70000];
    uint8_t in[10];
    osal_address_t from;
    size_t size = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 0U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_udp_open(&b, address_of(&a), 0U));
    TEST_ASSERT_FALSE(osal_socket_is_open(&b));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&b, any_port, 0U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_udp_send(&b, address_of(&a), huge, sizeof huge));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&b, address_of(&a), huge, 11U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&b, address_of(&a), huge, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
    // The datagram after the dropped one arrives whole.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(10U, size);
}

static void udp_sends_continue_when_a_peer_is_gone(void)
{
    uint8_t in[10];
    osal_address_t from;
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&b, any_port, 0U));
    const osal_address_t gone = address_of(&b);
    osal_socket_close(&b);
    for (int i = 0; i < 10; i++) {
        const status_t status = osal_udp_send(&a, gone, (const uint8_t*)"x", 1U);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_CLOSED));
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&a, &from, in, sizeof in, &size));
    }
}

static void udp_datagram_stays_until_the_next_receive(void)
{
    uint8_t in[10];
    osal_address_t from;
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&b, any_port, 0U));
    osal_socket_defer(&a);
    for (uint8_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&b, address_of(&a), &i, (i == 0U) ? 0U : 1U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(1U, in[0]);
    a.is_kept = false; // As if the process had died, and its successor had the socket.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(1U, in[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(2U, in[0]);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&a, &from, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&a, &from, in, sizeof in, &size));
}

// ---- TCP ----

static void connect_pair(void)
{
    osal_address_t peer;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&a, any_port));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tcp_accept(&a, &c, &peer));
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&b, address_of(&a)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&a, &c, &peer));
    TEST_ASSERT_EQUAL_UINT16(address_of(&b).port, peer.port);
}

static void tcp_fills_up_without_blocking_and_delivers_every_octet(void)
{
    static uint8_t block[65536];
    size_t sent_total = 0U;
    size_t part       = 0U;
    status_t status   = STATUS_OK;
    connect_pair();
    while (status == STATUS_OK) {
        for (size_t i = 0U; i < sizeof block; i++) {
            block[i] = (uint8_t)((sent_total + i) % 251U);
        }
        status = osal_stream_send(&b, block, sizeof block, &part);
        TEST_ASSERT_EQUAL(status == STATUS_OK, part > 0U);
        sent_total += part;
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    for (size_t taken = 0U; taken < sent_total; taken += part) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&c, 5000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(&c, block, sizeof block, &part));
        for (size_t i = 0U; i < part; i++) {
            TEST_ASSERT_EQUAL_HEX8((taken + i) % 251U, block[i]);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_stream_receive(&c, block, sizeof block, &part));
}

static void tcp_peer_that_ends_is_reported_after_its_last_octet(void)
{
    uint8_t in[10];
    size_t size = 0U;
    connect_pair();
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&b, (const uint8_t*)"last", 4U, &size));
    osal_socket_close(&b);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&c, 5000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(&c, in, sizeof in, &size));
    TEST_ASSERT_EQUAL_MEMORY("last", in, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&c, 5000U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_stream_receive(&c, in, sizeof in, &size));
    TEST_ASSERT_EQUAL(0U, size);
    // A send to a closed connection returns a status and causes no signal.
    status_t status = STATUS_OK;
    for (int i = 0; (i < 1000) && (status == STATUS_OK); i++) {
        status = osal_stream_send(&c, (const uint8_t*)"x", 1U, &size);
        (void)usleep(1000U);
    }
    TEST_ASSERT_EQUAL(STATUS_CLOSED, status);
}

static void a_tcp_port_can_be_used_again_at_once(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&a, any_port));
    const osal_address_t local = address_of(&a);
    TEST_ASSERT_EQUAL_HEX32(OSAL_IPV4_LOOPBACK, local.ipv4);
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_tcp_listen(&b, local));
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, connect_tcp(&b, local));
    TEST_ASSERT_FALSE(osal_socket_is_open(&b));
    // The port is available at once, although a connection through it was just closed.
    connect_pair();
    const osal_address_t used = address_of(&a);
    osal_socket_close(&c);
    osal_socket_close(&b);
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&a, used));
}

static void exhausted_descriptors_are_reported_as_a_status(void)
{
    osal_address_t peer;
    struct rlimit kept;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&a, any_port));
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&b, address_of(&a)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 5000U));
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_NOFILE, &kept));
    const struct rlimit none = {(rlim_t)osal_socket_descriptor(&b), kept.rlim_max};
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_NOFILE, &none));
    const status_t status = osal_tcp_accept(&a, &c, &peer);
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_NOFILE, &kept));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&a, &c, &peer));
}

static void a_connection_may_be_begun_without_waiting(void)
{
    osal_socket_t begun;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&a, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}));
    const osal_address_t there = address_of(&a);
    status_t status            = osal_tcp_connect_begin(&begun, there);
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_BUSY));
    while (status == STATUS_BUSY) {
        status = osal_tcp_connect_result(&begun);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    osal_socket_close(&begun);
    osal_socket_close(&a);
    status = osal_tcp_connect_begin(&begun, there);
    while (status == STATUS_BUSY) {
        status = osal_tcp_connect_result(&begun);
    }
    TEST_ASSERT_EQUAL(STATUS_CLOSED, status);
    TEST_ASSERT_FALSE(osal_socket_is_open(&begun));
}

// ---- Local streams and inheritance ----

static void local_streams_have_names(void)
{
    char long_path[128];
    osal_address_t peer = {1U, 1U};
    uint8_t in[8];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, connect_local(&b, path)); // No socket listens on the path.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_listen(&a, path));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_local_listen(&b, path));
    TEST_ASSERT_EQUAL(STATUS_OK, connect_local(&b, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&a, &c, &peer));
    TEST_ASSERT_EQUAL_UINT16(0U, peer.port);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&b, (const uint8_t*)"hello", 5U, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(&c, in, sizeof in, &size));
    TEST_ASSERT_EQUAL_MEMORY("hello", in, 5U);
    osal_socket_close(&a);
    osal_socket_close(&b);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_stream_receive(&c, in, sizeof in, &size));
    // The path still exists, but no socket listens.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, connect_local(&b, path));
    memset(long_path, 'x', sizeof long_path);
    (void)memcpy(long_path, "/tmp/", 5U);
    long_path[100] = '\0'; // The longest path that is accepted.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_listen(&a, long_path));
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(0, unlink(long_path));
    long_path[100]            = 'x';
    long_path[101]            = '\0';
    const char* const wrong[] = {long_path, ""};
    for (unsigned i = 0U; i < 2U; i++) { // After the error the socket is closed, whatever it contained.
        b = (osal_socket_t){.descriptor = 4711};
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_local_listen(&b, wrong[i]));
        TEST_ASSERT_EQUAL(-1, b.descriptor);
    }
}

static void adopted_sockets_do_not_block_and_close_on_exec(void)
{
    uint8_t in[4];
    osal_address_t from;
    size_t size = 0U;
    int ends[2];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 0U));
    const int copy = dup(osal_socket_descriptor(&a));
    TEST_ASSERT_EQUAL(0, fcntl(copy, F_SETFL, 0)); // The socket blocks, as a parent may leave it.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_adopt(&b, copy));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&b, &from, in, sizeof in, &size));
    TEST_ASSERT_TRUE((fcntl(copy, F_GETFD) & FD_CLOEXEC) != 0);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_socket_adopt(&c, 9999));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_socket_adopt(&c, -1));
    TEST_ASSERT_EQUAL(0, pipe(ends));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_socket_adopt(&c, ends[0])); // The descriptor is not a socket.
    TEST_ASSERT_FALSE(osal_socket_is_open(&c));
    (void)close(ends[0]);
    (void)close(ends[1]);
    const int other = socket(AF_NETLINK, SOCK_RAW, 0); // A family that no function of osal/socket.h opens.
    TEST_ASSERT_TRUE(other >= 0);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_socket_adopt(&c, other));
    TEST_ASSERT_FALSE(osal_socket_is_open(&c));
    (void)close(other);
}

static void every_socket_closes_on_exec(void)
{
    osal_socket_t pair = OSAL_SOCKET_CLOSED;
    connect_pair();
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&a), F_GETFD) & FD_CLOEXEC) != 0);
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&b), F_GETFD) & FD_CLOEXEC) != 0);
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&c), F_GETFD) & FD_CLOEXEC) != 0);
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&a, any_port, 0U));
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&a), F_GETFD) & FD_CLOEXEC) != 0);
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_listen(&a, path));
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&a), F_GETFD) & FD_CLOEXEC) != 0);
    osal_socket_close(&a);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&a, &pair));
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&a), F_GETFD) & FD_CLOEXEC) != 0);
    TEST_ASSERT_TRUE((fcntl(osal_socket_descriptor(&pair), F_GETFD) & FD_CLOEXEC) != 0);
    osal_socket_close(&pair);
    TEST_ASSERT_EQUAL(-1, osal_socket_descriptor(&pair));
}

// ---- Waiting ----

static void ignore_it(int number)
{
    (void)number;
}

static void wait_times_out_though_signals_interrupt_it(void)
{
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&a, &b));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_socket_wait_readable(&a, 0U));
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_socket_wait_readable(&a, 30U));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
    osal_socket_close(&b);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&a, 30U)); // The end of the stream is readable.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(udp_carries_whole_datagrams_in_order);
    RUN_TEST(a_udp_datagram_that_is_too_large_is_refused_or_dropped_and_the_next_one_arrives);
    RUN_TEST(udp_sends_continue_when_a_peer_is_gone);
    RUN_TEST(udp_datagram_stays_until_the_next_receive);
    RUN_TEST(tcp_fills_up_without_blocking_and_delivers_every_octet);
    RUN_TEST(tcp_peer_that_ends_is_reported_after_its_last_octet);
    RUN_TEST(a_tcp_port_can_be_used_again_at_once);
    RUN_TEST(exhausted_descriptors_are_reported_as_a_status);
    RUN_TEST(a_connection_may_be_begun_without_waiting);
    RUN_TEST(local_streams_have_names);
    RUN_TEST(adopted_sockets_do_not_block_and_close_on_exec);
    RUN_TEST(every_socket_closes_on_exec);
    RUN_TEST(wait_times_out_though_signals_interrupt_it);
    return UNITY_END();
}
