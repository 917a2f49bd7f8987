// SPDX-License-Identifier: Apache-2.0
// Frames of this test: one octet with the length, then this number of octets; length 0xFF is malformed.
#include "fsw/framework/dataflow/flow_tcp.h"

#include "test/support/clients.h"
#include "unity.h"

#include <string.h>

#define CLIENTS 2U
#define BUFFER 32U

static flow_tcp_t flow;
static flow_tcp_client_t clients[CLIENTS];
static uint8_t buffers[CLIENTS][BUFFER];
static osal_address_t address;
static osal_socket_t peers[4];

static struct {
    unsigned connected;
    unsigned disconnected;
    unsigned frames[CLIENTS + 1];
    uint8_t served[8]; ///< Clients, in the order of their frames.
    unsigned served_count;
    uint8_t last[BUFFER];
    bool ends_inside; ///< The framer ends the connection.
} seen;

static void on_connected(void* const context, const unsigned client)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_TRUE(client <= CLIENTS);
    seen.connected++;
}

static void on_disconnected(void* const context, const unsigned client)
{
    (void)context;
    TEST_ASSERT_FALSE(flow_tcp_is_connected(&flow, client));
    seen.disconnected++;
}

static size_t on_frame(void* const context, const unsigned client, const uint8_t* const octets,
                       const size_t size);
static const flow_tcp_user_t user = {&seen, on_connected, on_disconnected, on_frame, NULL, NULL};

static size_t on_frame(void* const context, const unsigned client, const uint8_t* const octets,
                       const size_t size)
{
    (void)context;
    if (octets[0] == 0xFFU) {
        return FLOW_TCP_MALFORMED;
    }
    const size_t frame = (size_t)octets[0] + 1U;
    if (size < frame) {
        return 0U;
    }
    seen.frames[client]++;
    if (seen.served_count < (sizeof seen.served)) {
        seen.served[seen.served_count] = (uint8_t)client;
        seen.served_count++;
    }
    memcpy(seen.last, octets, frame);
    if (seen.ends_inside) {
        flow_tcp_end(&flow, &user, client);
    }
    return frame;
}

/// Listen at a port that the kernel chooses, as a program does with an inherited descriptor.
static status_t listen_with(flow_tcp_t* const listening)
{
    osal_socket_t inherited = OSAL_SOCKET_CLOSED;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&inherited, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&inherited, &address));
    const status_t status = flow_tcp_adopt(listening, osal_socket_descriptor(&inherited));
    if (status != STATUS_OK) {
        osal_socket_close(&inherited);
    }
    return status;
}

void setUp(void)
{
    memset(&seen, 0, sizeof seen);
    flow_tcp_init(&flow, clients, CLIENTS, &buffers[0][0], BUFFER);
    TEST_ASSERT_EQUAL(STATUS_OK, listen_with(&flow));
    for (unsigned i = 0U; i < 4U; i++) {
        peers[i].descriptor = -1;
    }
}

/// End the connections, and close the listening socket, which belongs to the parent.
static void close_flow(void)
{
    flow_tcp_end_all(&flow, &user);
    osal_socket_close(&flow.listener);
}

void tearDown(void)
{
    for (unsigned i = 0U; i < 4U; i++) {
        if (osal_socket_is_open(&peers[i])) {
            osal_socket_close(&peers[i]);
        }
    }
    close_flow();
}

/// Wait until the kernel has delivered the octets.
static void wait(osal_socket_t* const socket)
{
    const status_t status = osal_socket_wait_readable(socket, 50U);
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_TIMEOUT));
}

/// Step when octets have arrived, or after a short wait. Returns the octets received.
static size_t step(const size_t limit)
{
    size_t octets = 0U;
    for (unsigned i = 0U; i < CLIENTS; i++) {
        if (flow_tcp_is_connected(&flow, i)) {
            wait(&clients[i].socket);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &user, limit, &octets));
    return octets;
}

static void join(const unsigned peer)
{
    size_t octets = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&peers[peer], address));
    wait(&flow.listener);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &user, FLOW_TCP_UNLIMITED, &octets));
}

static void say(const unsigned peer, const void* const octets, const size_t size)
{
    size_t sent = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&peers[peer], octets, size, &sent));
    TEST_ASSERT_EQUAL_UINT64(size, sent);
}

static void frames_are_found_however_they_are_divided(void)
{
    join(0U);
    TEST_ASSERT_EQUAL_UINT(1U, seen.connected);
    say(0U, "\003abc\002de\004fg", 10U);
    TEST_ASSERT_EQUAL_UINT64(10U, step(FLOW_TCP_UNLIMITED));
    TEST_ASSERT_EQUAL_UINT(2U, seen.frames[0]);
    say(0U, "h", 1U);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(2U, seen.frames[0]);
    say(0U, "i", 1U);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(3U, seen.frames[0]);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\004fghi", seen.last, 5U);
    TEST_ASSERT_EQUAL_UINT32(12U, flow.counters.octets_in);
}

static void a_step_reads_no_more_octets_than_its_limit(void)
{
    join(0U);
    say(0U, "\003abc\003abc", 8U);
    TEST_ASSERT_EQUAL_UINT64(5U, step(5U));
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT64(0U, step(0U));
    TEST_ASSERT_EQUAL_UINT64(3U, step(FLOW_TCP_UNLIMITED));
    TEST_ASSERT_EQUAL_UINT(2U, seen.frames[0]);
}

/// The limit is also kept if it ends in the middle of a second read.
static void two_reads_share_one_limit(void)
{
    char octets[28 + 42];
    octets[0] = 29; // A frame of 30 octets; two of them come later.
    (void)memset(&octets[1], 'a', 29U);
    for (size_t i = 30U; i < sizeof octets; i += 2U) {
        octets[i]      = 1;
        octets[i + 1U] = 'b';
    }
    join(0U);
    say(0U, octets, 28U);
    TEST_ASSERT_EQUAL_UINT64(28U, step(FLOW_TCP_UNLIMITED));
    say(0U, &octets[28], sizeof octets - 28U);
    // First the four octets for which the buffer has room after the 28; then 26, the rest of the limit.
    TEST_ASSERT_EQUAL_UINT64(30U, step(30U));
    TEST_ASSERT_EQUAL_UINT(1U + 14U, seen.frames[0]);
}

static size_t allow(void* const context, const unsigned client)
{
    (void)context;
    return (client == 0U) ? 2U : FLOW_TCP_UNLIMITED;
}

static void each_client_has_its_own_limit(void)
{
    const flow_tcp_user_t strict = {&seen, on_connected, on_disconnected, on_frame, allow, NULL};
    size_t octets                = 0U;
    osal_address_t peer          = {0U, 0U};
    join(0U);
    join(1U);
    say(0U, "\001a\001a", 4U);
    say(1U, "\001b\001b", 4U);
    wait(&clients[0].socket);
    wait(&clients[1].socket);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &strict, FLOW_TCP_UNLIMITED, &octets));
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT(2U, seen.frames[1]);
    TEST_ASSERT_EQUAL_UINT32(2U, flow_tcp_octets_in(&flow, 0U));
    TEST_ASSERT_EQUAL_UINT32(4U, flow_tcp_octets_in(&flow, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, flow_tcp_octets_in(&flow, 7U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_peer(&flow, 0U, &peer));
    TEST_ASSERT_EQUAL_HEX32(OSAL_IPV4_LOOPBACK, peer.ipv4);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_tcp_peer(&flow, 7U, &peer));
}

static void clients_beyond_the_number_of_slots_are_turned_away(void)
{
    osal_socket_t* sockets[8];
    TEST_ASSERT_EQUAL_UINT64(1U, flow_tcp_sockets(&flow, sockets, 8U));
    join(0U);
    join(1U);
    join(2U);
    TEST_ASSERT_EQUAL_UINT32(2U, flow.counters.accepted);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.turned_away);
    TEST_ASSERT_EQUAL_UINT64(3U, flow_tcp_sockets(&flow, sockets, 8U));
    TEST_ASSERT_EQUAL_UINT64(2U, flow_tcp_sockets(&flow, sockets, 2U));
    say(0U, "\001a", 2U);
    say(1U, "\001b", 2U);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[1]);
    osal_socket_close(&peers[0]);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(1U, seen.disconnected);
    TEST_ASSERT_FALSE(flow_tcp_is_connected(&flow, 0U));
    join(3U); // The slot is free again.
    TEST_ASSERT_EQUAL_UINT32(3U, flow.counters.accepted);
    TEST_ASSERT_EQUAL_UINT32(2U, clients[0].epoch);
}

/// Three clients have sent more than one step reads: each step begins after the client that was served last.
static void clients_are_served_in_turn(void)
{
    enum {
        THREE = 3
    };
    static flow_tcp_client_t three[THREE];
    static uint8_t room[THREE][BUFFER];
    static const uint8_t round[] = {0U, 1U, 2U, 0U, 1U, 2U};
    size_t octets                = 0U;
    close_flow();
    flow_tcp_init(&flow, three, THREE, &room[0][0], BUFFER);
    TEST_ASSERT_EQUAL(STATUS_OK, listen_with(&flow));
    for (unsigned i = 0U; i < THREE; i++) {
        join(i);
    }
    for (unsigned i = 0U; i < THREE; i++) {
        say(i, "\001a\001b", 4U);
        wait(&three[i].socket);
    }
    for (unsigned i = 0U; i < sizeof round; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &user, 2U, &octets));
        TEST_ASSERT_EQUAL_UINT64(2U, octets);
    }
    TEST_ASSERT_EQUAL_UINT(sizeof round, seen.served_count);
    TEST_ASSERT_EQUAL_UINT8_ARRAY(round, seen.served, sizeof round);
}

static unsigned victim;

static unsigned give_up(void* const context)
{
    (void)context;
    return victim;
}

static void a_client_may_be_disconnected_to_make_room_for_a_new_one(void)
{
    const flow_tcp_user_t generous = {&seen, on_connected, on_disconnected, on_frame, NULL, give_up};
    size_t taken                   = 0U;
    join(0U);
    join(1U);
    victim = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&peers[2], address));
    wait(&flow.listener);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &generous, FLOW_TCP_UNLIMITED, &taken));
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.evicted);
    TEST_ASSERT_EQUAL_UINT32(3U, flow.counters.accepted);
    TEST_ASSERT_EQUAL_UINT(1U, seen.disconnected);
    TEST_ASSERT_TRUE(flow_tcp_is_connected(&flow, 1U));
    victim = CLIENTS; // The user lets no client be disconnected.
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&peers[3], address));
    wait(&flow.listener);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &generous, FLOW_TCP_UNLIMITED, &taken));
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.turned_away);
}

static void malformed_and_endless_frames_end_the_connection(void)
{
    uint8_t endless[BUFFER];
    join(0U);
    say(0U, "\001a\377zzz", 6U);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT(1U, seen.disconnected);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.malformed);
    memset(endless, 0xFE, sizeof endless); // A frame of 255 octets does not fit the buffer.
    join(1U);
    say(1U, endless, sizeof endless);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(2U, seen.disconnected);
    TEST_ASSERT_EQUAL_UINT32(2U, flow.counters.malformed);
}

static void a_frame_as_long_as_the_buffer_still_fits(void)
{
    uint8_t frame[BUFFER] = {BUFFER - 1U};
    join(0U);
    for (unsigned i = 0U; i < 5U; i++) {
        say(0U, frame, sizeof frame);
        (void)step(FLOW_TCP_UNLIMITED);
    }
    TEST_ASSERT_EQUAL_UINT(5U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT(0U, seen.disconnected);
}

static void the_callback_for_frames_may_end_the_connection(void)
{
    join(0U);
    seen.ends_inside = true;
    say(0U, "\001a\001b", 4U);
    (void)step(FLOW_TCP_UNLIMITED);
    TEST_ASSERT_EQUAL_UINT(1U, seen.frames[0]);
    TEST_ASSERT_EQUAL_UINT(1U, seen.disconnected);
    TEST_ASSERT_EQUAL_UINT32(0U, flow.counters.malformed);
}

static void sending_accepts_what_the_kernel_accepts(void)
{
    static const uint8_t octets[65536] = {0U};
    size_t sent                        = 0U;
    uint8_t taken[4];
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_tcp_send(&flow, 0U, octets, 1U, &sent));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_tcp_send(&flow, 7U, octets, 1U, &sent));
    join(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_send(&flow, 0U, octets, 4U, &sent));
    TEST_ASSERT_EQUAL_UINT64(4U, sent);
    wait(&peers[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(&peers[0], taken, sizeof taken, &sent));
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < 1000U) && (status == STATUS_OK); i++) { // The client does not read.
        status = flow_tcp_send(&flow, 0U, octets, sizeof octets, &sent);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_TRUE(flow_tcp_is_connected(&flow, 0U));
}

static void sockets_are_counted_where_a_quota_is_given(void)
{
    quota_t quota;
    size_t octets = 0U;
    quota_init(&quota, 2U);
    close_flow();
    flow_tcp_set_quota(&flow, &quota);
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_tcp_adopt(&flow, 9999));
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_OK, listen_with(&flow));
    flow_tcp_t second;
    flow_tcp_client_t slots[1];
    uint8_t room[BUFFER];
    join(0U);
    TEST_ASSERT_EQUAL_UINT16(2U, quota.stats.used);
    join(1U); // A slot is free, but the quota has no further socket.
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.turned_away);
    TEST_ASSERT_EQUAL_UINT32(1U, quota.stats.refused);
    flow_tcp_init(&second, slots, 1U, room, BUFFER);
    flow_tcp_set_quota(&second, &quota);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, flow_tcp_adopt(&second, 0));
    TEST_ASSERT_EQUAL_UINT32(1U, second.counters.failed);
    osal_socket_close(&peers[0]);
    wait(&clients[0].socket);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &user, FLOW_TCP_UNLIMITED, &octets));
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    flow_tcp_end_all(&flow, &user);
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    TEST_ASSERT_EQUAL_UINT16(2U, quota.stats.peak);
}

static void ending_all_connections_reports_each_client_once(void)
{
    size_t octets = 0U;
    join(0U);
    join(1U);
    flow_tcp_end_all(&flow, &user);
    TEST_ASSERT_EQUAL_UINT(2U, seen.disconnected);
    TEST_ASSERT_FALSE(flow_tcp_is_connected(&flow, 0U) || flow_tcp_is_connected(&flow, 1U));
    // The flow still listens.
    TEST_ASSERT_EQUAL(STATUS_OK, flow_tcp_step(&flow, &user, FLOW_TCP_UNLIMITED, &octets));
    flow_tcp_end_all(&flow, &user);
    TEST_ASSERT_EQUAL_UINT(2U, seen.disconnected);
}

static void a_refused_opening_reports_the_reason(void)
{
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_tcp_adopt(&flow, 0));
    close_flow();
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_tcp_adopt(&flow, 9999));
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.failed);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(frames_are_found_however_they_are_divided);
    RUN_TEST(a_step_reads_no_more_octets_than_its_limit);
    RUN_TEST(two_reads_share_one_limit);
    RUN_TEST(each_client_has_its_own_limit);
    RUN_TEST(clients_beyond_the_number_of_slots_are_turned_away);
    RUN_TEST(clients_are_served_in_turn);
    RUN_TEST(a_client_may_be_disconnected_to_make_room_for_a_new_one);
    RUN_TEST(malformed_and_endless_frames_end_the_connection);
    RUN_TEST(a_frame_as_long_as_the_buffer_still_fits);
    RUN_TEST(the_callback_for_frames_may_end_the_connection);
    RUN_TEST(sending_accepts_what_the_kernel_accepts);
    RUN_TEST(sockets_are_counted_where_a_quota_is_given);
    RUN_TEST(ending_all_connections_reports_each_client_once);
    RUN_TEST(a_refused_opening_reports_the_reason);
    return UNITY_END();
}
