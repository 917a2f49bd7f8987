// SPDX-License-Identifier: Apache-2.0
// The TIPC carrier against a kernel that is played: what it sends where, what comes back, strangers, and
// hints.
#include "fsw/framework/message/tipc_carrier.h"

#include "base/octets.h"
#include "unity.h"

#include <string.h>

#define TYPE 0x48000007U
#define SELF 1U
#define PEER 16U
#define OTHER 17U
#define PEER_SOCKET 0x100000016ULL
#define OTHER_SOCKET 0x100000017ULL
#define EVENTS 8U
#define PEERS 2U

// ---- The played kernel ----

static struct {
    status_t send;
    osal_tipc_name_t to;
    uint8_t frame[MESSAGE_FRAME_MAX];
    size_t size;
    unsigned sent;
    status_t receive[EVENTS]; // One after the other, then STATUS_EMPTY.
    unsigned received;
    uint64_t from;
    osal_tipc_event_t events[EVENTS];
    unsigned event_count;
    unsigned event_next;
} kernel;

status_t osal_tipc_open(osal_socket_t* sock, osal_tipc_kind_t kind, const osal_tipc_name_t* name,
                        osal_tipc_scope_t scope)
{
    (void)kind;
    (void)name;
    (void)scope;
    sock->descriptor = -1;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_send(osal_socket_t* sock, osal_tipc_name_t to, const uint8_t* octets, size_t size)
{
    (void)sock;
    if (kernel.send == STATUS_OK) {
        kernel.to   = to;
        kernel.size = size;
        kernel.sent++;
        (void)memcpy(kernel.frame, octets, size);
    }
    return kernel.send;
}

status_t osal_tipc_receive(osal_socket_t* sock, uint64_t* out_from, uint8_t* octets, size_t capacity,
                           size_t* out_size)
{
    (void)sock;
    const status_t status = (kernel.received < EVENTS) ? kernel.receive[kernel.received] : STATUS_EMPTY;
    kernel.received++;
    *out_from = kernel.from;
    *out_size = 0U;
    if (status == STATUS_OK) {
        TEST_ASSERT_TRUE(kernel.size <= capacity);
        (void)memcpy(octets, kernel.frame, kernel.size);
        *out_size = kernel.size;
    }
    return status;
}

status_t osal_tipc_identity(const osal_socket_t* sock, uint64_t* out_identity)
{
    (void)sock;
    *out_identity = 0U;
    return STATUS_IO;
}

status_t osal_tipc_watch_open(osal_socket_t* sock, uint32_t type)
{
    (void)type;
    sock->descriptor = -1;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_watch_next(osal_socket_t* sock, osal_tipc_event_t* out_event)
{
    (void)sock;
    if (kernel.event_next == kernel.event_count) {
        return STATUS_EMPTY;
    }
    *out_event = kernel.events[kernel.event_next];
    kernel.event_next++;
    return STATUS_OK;
}

// ---- The bed ----

static osal_socket_t plug  = {.descriptor = 7};
static osal_socket_t watch = {.descriptor = 8};
static tipc_carrier_t carrier;
static message_endpoint_t endpoint;
static message_place_t inbox[PEERS];
static unsigned notices;
static uint16_t noticed;

static void delivered(void* context, uint16_t to)
{
    (void)context;
    notices++;
    noticed = to;
}

void setUp(void)
{
    (void)memset(&kernel, 0, sizeof kernel);
    for (unsigned i = 0U; i < EVENTS; i++) {
        kernel.receive[i] = STATUS_EMPTY;
    }
    notices = 0U;
    tipc_carrier_init(&carrier, &plug, &watch, TYPE, (delivery_notice_t){NULL, delivered});
    message_open(&endpoint, SELF, 1U, tipc_carrier_port(&carrier), inbox, PEERS);
    TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&endpoint, PEER));
    TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&endpoint, OTHER));
    TEST_ASSERT_EQUAL(STATUS_OK, tipc_carrier_add_peer(&carrier, PEER, PEER_SOCKET));
    TEST_ASSERT_EQUAL(STATUS_OK, tipc_carrier_add_peer(&carrier, OTHER, OTHER_SOCKET));
}

void tearDown(void)
{
}

static void tell(bool is_published, uint32_t instance)
{
    kernel.events[kernel.event_count] = (osal_tipc_event_t){is_published, instance};
    kernel.event_count++;
}

static const uint8_t octets[3] = {1U, 2U, 3U};

// ---- Sending ----

static void a_frame_goes_to_the_name_of_its_component(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, message_send(&endpoint, PEER, octets, sizeof octets));
    TEST_ASSERT_EQUAL_HEX32(TYPE, kernel.to.type);
    TEST_ASSERT_EQUAL(PEER, kernel.to.instance);
    TEST_ASSERT_EQUAL(MESSAGE_HEADER_OCTETS + sizeof octets, kernel.size);
    TEST_ASSERT_EQUAL(1U, notices);
    TEST_ASSERT_EQUAL(PEER, noticed);
}

static void what_the_kernel_refuses_is_told_and_not_announced(void)
{
    kernel.send = STATUS_FULL;
    TEST_ASSERT_EQUAL(STATUS_FULL, message_send(&endpoint, PEER, octets, sizeof octets));
    TEST_ASSERT_EQUAL(0U, endpoint.counters.unreachable);
    kernel.send = STATUS_CLOSED;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, message_send(&endpoint, PEER, octets, sizeof octets));
    TEST_ASSERT_EQUAL(1U, endpoint.counters.unreachable);
    TEST_ASSERT_EQUAL(0U, notices);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(&endpoint, PEER));
}

static void no_more_peers_than_there_is_room_for(void)
{
    for (unsigned i = 2U; i < MESSAGE_PEERS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, tipc_carrier_add_peer(&carrier, (uint16_t)(100U + i), i));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, tipc_carrier_add_peer(&carrier, 99U, 99U));
}

// ---- Receiving ----

static void what_comes_back_is_counted_and_is_no_message(void)
{
    kernel.receive[0] = STATUS_FORBIDDEN;
    kernel.receive[1] = STATUS_FORBIDDEN;
    kernel.receive[2] = STATUS_OK;
    kernel.from       = PEER_SOCKET;
    kernel.size       = MESSAGE_HEADER_OCTETS;
    TEST_ASSERT_EQUAL(STATUS_OK, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(2U, carrier.returned);
    kernel.receive[4] = STATUS_FORBIDDEN;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(3U, carrier.returned);
}

static void a_stranger_is_not_heard(void)
{
    kernel.receive[0] = STATUS_OK;
    kernel.from       = 0x200000016ULL; // The peer's number on another node.
    kernel.size       = MESSAGE_HEADER_OCTETS;
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(1U, carrier.foreign);
}

static void errors_are_passed_on(void)
{
    kernel.receive[0] = STATUS_TOO_LARGE;
    kernel.receive[1] = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(1U, endpoint.counters.malformed);
    TEST_ASSERT_EQUAL(STATUS_IO, tipc_carrier_pump(&carrier, &endpoint));
}

static void a_message_beyond_the_window_is_dropped_and_counted(void)
{
    uint8_t* const frame = kernel.frame;
    kernel.from          = PEER_SOCKET;
    kernel.size          = MESSAGE_FRAME_MAX;
    octets_put_u16(&frame[0], 0x484DU);
    frame[2] = 1U;
    octets_put_u16(&frame[4], PEER);
    octets_put_u16(&frame[6], SELF);
    octets_put_u32(&frame[8], 1U);
    unsigned kept = 0U;
    while (message_deliver(&endpoint, frame, MESSAGE_FRAME_MAX) == STATUS_OK) {
        kept++;
    }
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX, kept);
    kernel.receive[0] = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, tipc_carrier_pump(&carrier, &endpoint));
    TEST_ASSERT_EQUAL(2U, endpoint.counters.overruns);
}

// ---- Hints ----

static void the_names_at_the_beginning_are_no_news(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, message_send(&endpoint, PEER, octets, sizeof octets));
    tell(true, PEER);
    tell(true, OTHER);
    tell(true, 99U);
    tipc_carrier_take_hints(&carrier, &endpoint);
    TEST_ASSERT_EQUAL(1U, kernel.sent);
    TEST_ASSERT_EQUAL(0U, carrier.withdrawn);
}

static void a_peer_that_is_there_again_is_asked(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, message_send(&endpoint, PEER, octets, sizeof octets));
    tell(false, PEER);
    tell(false, PEER);
    tipc_carrier_take_hints(&carrier, &endpoint);
    TEST_ASSERT_EQUAL(1U, carrier.withdrawn);
    TEST_ASSERT_EQUAL(1U, kernel.sent);
    tell(true, PEER);
    tipc_carrier_take_hints(&carrier, &endpoint);
    TEST_ASSERT_EQUAL(2U, kernel.sent);
    TEST_ASSERT_EQUAL(2U, kernel.frame[3]); // A probe.
    TEST_ASSERT_EQUAL(1U, endpoint.counters.syncs);
}

/// A name that is gone is no reason not to send: what is true the peer says itself.
static void a_hint_forbids_nothing(void)
{
    tell(false, PEER);
    tipc_carrier_take_hints(&carrier, &endpoint);
    TEST_ASSERT_EQUAL(STATUS_OK, message_send(&endpoint, PEER, octets, sizeof octets));
}

static void without_a_watch_there_are_no_hints(void)
{
    tipc_carrier_init(&carrier, &plug, NULL, TYPE, (delivery_notice_t){NULL, delivered});
    tell(false, PEER);
    tipc_carrier_take_hints(&carrier, &endpoint);
    TEST_ASSERT_EQUAL(0U, kernel.event_next);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_frame_goes_to_the_name_of_its_component);
    RUN_TEST(what_the_kernel_refuses_is_told_and_not_announced);
    RUN_TEST(no_more_peers_than_there_is_room_for);
    RUN_TEST(what_comes_back_is_counted_and_is_no_message);
    RUN_TEST(a_stranger_is_not_heard);
    RUN_TEST(errors_are_passed_on);
    RUN_TEST(a_message_beyond_the_window_is_dropped_and_counted);
    RUN_TEST(the_names_at_the_beginning_are_no_news);
    RUN_TEST(a_peer_that_is_there_again_is_asked);
    RUN_TEST(a_hint_forbids_nothing);
    RUN_TEST(without_a_watch_there_are_no_hints);
    return UNITY_END();
}
