// SPDX-License-Identifier: Apache-2.0
// The TIPC carrier with a mocked kernel: destinations of frames, returned messages, unknown senders, and
// hints.
#include "fsw/framework/message/tipc_carrier.h"

#include "base/octets.h"
#include "fsw/framework/message/message_frame.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define TYPE 0x48000007U
#define SELF 1U
#define PEER 16U
#define OTHER 17U
#define PEER_SOCKET 0x100000016ULL
#define OTHER_SOCKET 0x100000017ULL
#define PEERS 2U

// ---- The fixture ----

static osal_socket_t plug  = {.descriptor = 7};
static osal_socket_t watch = {.descriptor = 8};
static message_tipc_carrier_t carrier;
static message_endpoint_t endpoint;
static message_slot_t inbox[PEERS];
static const uint8_t octets[3] = {1U, 2U, 3U};

// ---- The mocked kernel ----

static uint8_t sent[MESSAGE_FRAME_MAX];     // Last frame.
static uint8_t received[MESSAGE_FRAME_MAX]; // Frame that the mocked kernel returns next.

status_t __wrap_osal_tipc_send(osal_socket_t* sock, osal_tipc_name_t to, const uint8_t* frame, size_t size)
{
    const uint32_t instance = to.instance;
    assert_ptr_equal(&plug, sock);
    assert_int_equal(TYPE, to.type);
    check_expected(instance);
    check_expected(size);
    (void)memcpy(sent, frame, size);
    return mock_type(status_t);
}

status_t __wrap_osal_tipc_receive(osal_socket_t* sock, uint64_t* out_from, uint8_t* frame, size_t capacity,
                                  size_t* out_size)
{
    assert_ptr_equal(&plug, sock);
    const status_t status = mock_type(status_t);
    *out_size             = 0U;
    if (status == STATUS_OK) {
        *out_from = mock_type(uint64_t);
        *out_size = mock_type(size_t);
        assert_in_range(*out_size, 0U, capacity);
        (void)memcpy(frame, received, *out_size);
    }
    return status;
}

status_t __wrap_osal_tipc_watch_next(osal_socket_t* sock, osal_tipc_event_t* out_event)
{
    assert_ptr_equal(&watch, sock);
    const status_t status = mock_type(status_t);
    if (status == STATUS_OK) {
        out_event->is_published = mock_type(bool);
        out_event->instance     = mock_type(uint32_t);
    }
    return status;
}

static void will_send(const uint32_t to, const size_t size, const status_t status)
{
    expect_value(__wrap_osal_tipc_send, instance, to);
    expect_value(__wrap_osal_tipc_send, size, size);
    will_return(__wrap_osal_tipc_send, status);
}

static void will_receive(const uint64_t from, const size_t size)
{
    will_return(__wrap_osal_tipc_receive, STATUS_OK);
    will_return(__wrap_osal_tipc_receive, from);
    will_return(__wrap_osal_tipc_receive, size);
}

static void will_report(const bool is_published, const uint32_t instance)
{
    will_return(__wrap_osal_tipc_watch_next, STATUS_OK);
    will_return(__wrap_osal_tipc_watch_next, is_published);
    will_return(__wrap_osal_tipc_watch_next, instance);
}

static void take_hints(void)
{
    will_return(__wrap_osal_tipc_watch_next, STATUS_EMPTY);
    message_tipc_carrier_take_hints(&carrier, &endpoint);
}

static void delivered(void* context, uint16_t to)
{
    (void)context;
    check_expected(to);
}

static int set_up(void** state)
{
    (void)state;
    message_tipc_carrier_init(&carrier, &plug, &watch, TYPE, (message_delivery_notice_t){NULL, delivered});
    message_open(&endpoint, SELF, 1U, message_tipc_carrier_port(&carrier), inbox, PEERS);
    return ((message_add_peer(&endpoint, PEER) == STATUS_OK) &&
            (message_add_peer(&endpoint, OTHER) == STATUS_OK) &&
            (message_tipc_carrier_add_peer(&carrier, PEER, PEER_SOCKET) == STATUS_OK) &&
            (message_tipc_carrier_add_peer(&carrier, OTHER, OTHER_SOCKET) == STATUS_OK))
               ? 0
               : -1;
}

/// Send a message of three octets to the peer; the kernel accepts it.
static void send_to_peer(void)
{
    will_send(PEER, MESSAGE_HEADER_OCTETS + sizeof octets, STATUS_OK);
    expect_value(delivered, to, PEER);
    assert_int_equal(STATUS_OK, message_send(&endpoint, PEER, octets, sizeof octets));
}

// ---- Sending ----

static void a_frame_goes_to_the_name_of_its_component(void** state)
{
    (void)state;
    send_to_peer();
    assert_memory_equal(octets, &sent[MESSAGE_HEADER_OCTETS], sizeof octets);
}

static void a_message_that_the_kernel_refuses_is_reported_and_not_announced(void** state)
{
    (void)state;
    will_send(PEER, MESSAGE_HEADER_OCTETS + sizeof octets, STATUS_FULL);
    assert_int_equal(STATUS_FULL, message_send(&endpoint, PEER, octets, sizeof octets));
    assert_int_equal(0U, endpoint.counters.unreachable);
    will_send(PEER, MESSAGE_HEADER_OCTETS + sizeof octets, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, message_send(&endpoint, PEER, octets, sizeof octets));
    assert_int_equal(1U, endpoint.counters.unreachable);
    assert_int_equal(MESSAGE_WINDOW, message_credit(&endpoint, PEER));
}

static void peers_beyond_the_capacity_are_refused(void** state)
{
    (void)state;
    for (unsigned i = 2U; i < MESSAGE_PEERS_MAX; i++) {
        assert_int_equal(STATUS_OK, message_tipc_carrier_add_peer(&carrier, (uint16_t)(100U + i), i));
    }
    assert_int_equal(STATUS_EXHAUSTED, message_tipc_carrier_add_peer(&carrier, 99U, 99U));
}

// ---- Receiving ----

static void returned_messages_are_counted_and_not_delivered(void** state)
{
    (void)state;
    will_return_count(__wrap_osal_tipc_receive, STATUS_FORBIDDEN, 2);
    will_receive(PEER_SOCKET, MESSAGE_HEADER_OCTETS);
    assert_int_equal(STATUS_OK, message_tipc_carrier_pump(&carrier, &endpoint));
    assert_int_equal(2U, carrier.returned);
    assert_int_equal(0U, carrier.other_senders);
    will_return(__wrap_osal_tipc_receive, STATUS_FORBIDDEN);
    will_return(__wrap_osal_tipc_receive, STATUS_EMPTY);
    assert_int_equal(STATUS_EMPTY, message_tipc_carrier_pump(&carrier, &endpoint));
    assert_int_equal(3U, carrier.returned);
}

static void messages_of_unknown_senders_are_dropped(void** state)
{
    (void)state;
    will_receive(0x200000016ULL, MESSAGE_HEADER_OCTETS); // The number of the peer, but on another node.
    assert_int_equal(STATUS_NOT_OURS, message_tipc_carrier_pump(&carrier, &endpoint));
    assert_int_equal(1U, carrier.other_senders);
}

static void a_message_that_is_too_large_is_malformed_and_errors_are_passed_on(void** state)
{
    (void)state;
    will_return(__wrap_osal_tipc_receive, STATUS_TOO_LARGE);
    assert_int_equal(STATUS_NOT_OURS, message_tipc_carrier_pump(&carrier, &endpoint));
    assert_int_equal(1U, endpoint.counters.malformed);
    will_return(__wrap_osal_tipc_receive, STATUS_IO);
    assert_int_equal(STATUS_IO, message_tipc_carrier_pump(&carrier, &endpoint));
}

static void a_message_beyond_the_window_is_dropped_and_counted(void** state)
{
    (void)state;
    (void)memset(received, 0, sizeof received);
    octets_put_u16(&received[0], 0x484DU);
    received[2] = 1U;
    octets_put_u16(&received[4], PEER);
    octets_put_u16(&received[6], SELF);
    octets_put_u32(&received[8], 1U);
    unsigned kept = 0U;
    while (message_deliver(&endpoint, received, MESSAGE_FRAME_MAX) == STATUS_OK) {
        kept++;
    }
    assert_int_equal(MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX, kept);
    will_receive(PEER_SOCKET, MESSAGE_FRAME_MAX);
    assert_int_equal(STATUS_OK, message_tipc_carrier_pump(&carrier, &endpoint));
    assert_int_equal(2U, endpoint.counters.overruns); // The last frame of the loop, and this one.
}

// ---- Hints ----

static void names_that_exist_at_the_beginning_withdraw_nothing(void** state)
{
    (void)state;
    send_to_peer();
    will_report(true, PEER);
    will_report(true, OTHER);
    will_report(true, 99U);
    take_hints();
    assert_int_equal(0U, carrier.withdrawn);
}

static void a_peer_that_is_back_gets_a_sync(void** state)
{
    (void)state;
    send_to_peer();
    will_report(false, PEER);
    will_report(false, PEER);
    take_hints();
    assert_int_equal(1U, carrier.withdrawn);
    will_report(true, PEER);
    will_send(PEER, MESSAGE_HEADER_OCTETS, STATUS_OK);
    expect_value(delivered, to, PEER);
    take_hints();
    assert_int_equal(MESSAGE_SYNC, sent[3]); // The kind of the frame.
    assert_int_equal(1U, endpoint.counters.syncs);
}

/// The removal of a name does not forbid sending: only the peer reports its state.
static void a_removed_name_does_not_stop_sending(void** state)
{
    (void)state;
    will_report(false, PEER);
    take_hints();
    send_to_peer();
}

static void without_a_watch_there_are_no_hints(void** state)
{
    osal_socket_t closed = {.descriptor = -1};
    (void)state;
    message_tipc_carrier_init(&carrier, &plug, NULL, TYPE, (message_delivery_notice_t){NULL, delivered});
    message_tipc_carrier_take_hints(&carrier, &endpoint); // No SYNC is sent.
    message_tipc_carrier_init(&carrier, &plug, &closed, TYPE, (message_delivery_notice_t){NULL, delivered});
    message_tipc_carrier_take_hints(&carrier, &endpoint);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_frame_goes_to_the_name_of_its_component, set_up),
        cmocka_unit_test_setup(a_message_that_the_kernel_refuses_is_reported_and_not_announced, set_up),
        cmocka_unit_test_setup(peers_beyond_the_capacity_are_refused, set_up),
        cmocka_unit_test_setup(returned_messages_are_counted_and_not_delivered, set_up),
        cmocka_unit_test_setup(messages_of_unknown_senders_are_dropped, set_up),
        cmocka_unit_test_setup(a_message_that_is_too_large_is_malformed_and_errors_are_passed_on, set_up),
        cmocka_unit_test_setup(a_message_beyond_the_window_is_dropped_and_counted, set_up),
        cmocka_unit_test_setup(names_that_exist_at_the_beginning_withdraw_nothing, set_up),
        cmocka_unit_test_setup(a_peer_that_is_back_gets_a_sync, set_up),
        cmocka_unit_test_setup(a_removed_name_does_not_stop_sending, set_up),
        cmocka_unit_test_setup(without_a_watch_there_are_no_hints, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
