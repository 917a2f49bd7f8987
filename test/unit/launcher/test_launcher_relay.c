// SPDX-License-Identifier: Apache-2.0
// The relay as a participant: which sockets it takes over, when it passes a frame on, to whom, and what it
// counts. Sockets and scheduler are mocked; a second relay_t with the same seed says which frames are lost
// and when the others are due.
#include "launcher/launcher_relay.h"

#include "base/octets.h"
#include "fsw/framework/rtlink/link_frame.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define DELAY_US 10000U
#define SEED 7U
#define FIRST_DESCRIPTOR 40 ///< Descriptor of the link with index 0.
#define SENDER_DESCRIPTOR 90
#define LINK_IN_USE 2U ///< Links with the index 0 and 2 have a relay.
#define QUEUE_MAX 5000U
#define CONSUMER 3U ///< Component that reads link 0; the next one reads link 2.
#define LIFE 5U
#define FLOOR 9U ///< Floor of the epochs at the consumers.
#define IPV4 0x7F000001U
#define COMPONENTS 6U

typedef struct {
    uint8_t octets[LINK_FRAME_MAX];
    size_t size;
} datagram_t;

static launcher_relay_t relay;
static relay_t reference;
static run_state_t run;
static osal_lockstep_t* const scheduler = (osal_lockstep_t*)&run; // Never read: its functions are mocked.
static datagram_t queue[RUN_LINKS_MAX][8]; // Datagrams that a producer has sent, by link.
static size_t queued[RUN_LINKS_MAX];
static datagram_t passed[QUEUE_MAX]; // Datagrams passed on, in their order.
static uint16_t ports[QUEUE_MAX];
static size_t passed_count;
static status_t send_status;
static unsigned delivered; // Announcements to consumers.
static unsigned waits;
static uint32_t waited_ms;
static unsigned late_at; // Wait at which a late frame of link 0 arrives; 0: none does.
static unsigned closed;

static void put(unsigned link, uint32_t number, uint32_t epoch, size_t size);

status_t __wrap_osal_socket_adopt(osal_socket_t* socket, int descriptor)
{
    check_expected(descriptor);
    socket->descriptor = descriptor;
    return mock_type(status_t);
}

status_t __wrap_osal_udp_open(osal_socket_t* socket, osal_address_t local, size_t receive_bytes)
{
    assert_int_equal(IPV4, local.ipv4);
    assert_int_equal(0U, receive_bytes);
    socket->descriptor = SENDER_DESCRIPTOR;
    return mock_type(status_t);
}

void __wrap_osal_socket_close(osal_socket_t* socket)
{
    closed += (socket->descriptor >= 0) ? 1U : 0U;
    socket->descriptor = -1;
}

status_t __wrap_osal_udp_receive(osal_socket_t* socket, osal_address_t* out_from, uint8_t* octets,
                                 size_t capacity, size_t* out_size)
{
    const unsigned link = (unsigned)(socket->descriptor - FIRST_DESCRIPTOR);
    (void)out_from;
    assert_true(link < RUN_LINKS_MAX);
    assert_int_equal(LINK_FRAME_MAX, capacity);
    if (queued[link] == 0U) {
        return STATUS_EMPTY;
    }
    (void)memcpy(octets, queue[link][0].octets, queue[link][0].size);
    *out_size = queue[link][0].size;
    queued[link]--;
    (void)memmove(&queue[link][0], &queue[link][1], queued[link] * sizeof queue[link][0]);
    return STATUS_OK;
}

status_t __wrap_osal_socket_wait_readable(osal_socket_t* socket, uint32_t timeout_ms)
{
    waits++;
    waited_ms += timeout_ms;
    if ((waits == late_at) && (socket->descriptor == FIRST_DESCRIPTOR)) {
        put(0U, 1U, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS);
        return STATUS_OK;
    }
    return STATUS_TIMEOUT;
}

status_t __wrap_osal_udp_send(osal_socket_t* socket, osal_address_t to, const uint8_t* octets, size_t size)
{
    assert_int_equal(SENDER_DESCRIPTOR, socket->descriptor);
    assert_int_equal(IPV4, to.ipv4);
    assert_true(passed_count < QUEUE_MAX);
    if (send_status == STATUS_OK) {
        (void)memcpy(passed[passed_count].octets, octets, size);
        passed[passed_count].size = size;
        ports[passed_count]       = to.port;
        passed_count++;
    }
    return send_status;
}

void __wrap_osal_lockstep_deliver(osal_lockstep_t* to, unsigned sender, unsigned receiver, uint32_t life,
                                  uint32_t messages, uint32_t octets)
{
    const unsigned component = (ports[passed_count - 1U] == 1000U) ? CONSUMER : (CONSUMER + 1U);
    assert_ptr_equal(scheduler, to);
    assert_int_equal(run_relay(&run), sender);
    assert_int_equal(run_participant(component), receiver);
    assert_int_equal(LIFE, life);
    assert_int_equal(1U, messages);
    assert_int_equal(0U, octets);
    delivered++;
}

/// A producer has sent a frame.
static void put(unsigned link, uint32_t number, uint32_t epoch, size_t size)
{
    datagram_t* const one = &queue[link][queued[link]];
    assert_true(queued[link] < (sizeof queue[0] / sizeof queue[0][0]));
    (void)memset(one, 0, sizeof *one);
    one->size = size;
    octets_put_u32(&one->octets[0], number);
    octets_put_u32(&one->octets[8], epoch);
    one->octets[size - 1U] ^= 0xA5U;
    queued[link]++;
}

static void begin(void)
{
    const relay_law_t law = {DELAY_US * 1000ULL, LAUNCHER_RELAY_JITTER, LAUNCHER_RELAY_LOSS};
    relay_init(&reference, SEED, &law);
    expect_value(__wrap_osal_socket_adopt, descriptor, FIRST_DESCRIPTOR);
    will_return(__wrap_osal_socket_adopt, STATUS_OK);
    expect_value(__wrap_osal_socket_adopt, descriptor, FIRST_DESCRIPTOR + (int)LINK_IN_USE);
    will_return(__wrap_osal_socket_adopt, STATUS_OK);
    will_return(__wrap_osal_udp_open, STATUS_OK);
    assert_null(launcher_relay_open(&relay, &run, scheduler));
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&run, 0, sizeof run);
    run.computer_ipv4[0] = IPV4;
    run.component_count  = COMPONENTS;
    run.relay.delay_us   = DELAY_US;
    run.relay.seed       = SEED;
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        const bool is_used       = (i == 0U) || (i == LINK_IN_USE);
        run.relay.descriptors[i] = is_used ? (FIRST_DESCRIPTOR + (int)i) : -1;
        run.link_ports[i]        = (uint16_t)(1000U + i);
        queued[i]                = 0U;
    }
    run.relay.consumers[0]           = CONSUMER;
    run.relay.consumers[LINK_IN_USE] = CONSUMER + 1U;
    for (unsigned i = CONSUMER; i <= (CONSUMER + 1U); i++) {
        run.components[i].life       = LIFE;
        run.components[i].link_floor = FLOOR;
    }
    passed_count = 0U;
    delivered    = 0U;
    waits        = 0U;
    waited_ms    = 0U;
    late_at      = 0U;
    closed       = 0U;
    send_status  = STATUS_OK;
    return 0;
}

static uint64_t step(const uint64_t now_ns, const uint32_t announced)
{
    const osal_grant_t grant = {.now_ns = now_ns, .messages = announced};
    return launcher_relay_step(&relay, &grant);
}

// ---- Sockets ----

static void without_a_delay_no_socket_is_taken_over(void** state)
{
    (void)state;
    run.relay.delay_us = 0U;
    assert_null(launcher_relay_open(&relay, &run, scheduler));
    launcher_relay_close(&relay);
    assert_int_equal(0U, closed);
}

static void sockets_that_cannot_be_opened_are_reported(void** state)
{
    (void)state;
    expect_value(__wrap_osal_socket_adopt, descriptor, FIRST_DESCRIPTOR);
    will_return(__wrap_osal_socket_adopt, STATUS_INVALID);
    assert_string_equal("the relay cannot take over its sockets; start the mission again",
                        launcher_relay_open(&relay, &run, scheduler));
    expect_value(__wrap_osal_socket_adopt, descriptor, FIRST_DESCRIPTOR);
    will_return(__wrap_osal_socket_adopt, STATUS_OK);
    expect_value(__wrap_osal_socket_adopt, descriptor, FIRST_DESCRIPTOR + (int)LINK_IN_USE);
    will_return(__wrap_osal_socket_adopt, STATUS_OK);
    will_return(__wrap_osal_udp_open, STATUS_EXHAUSTED);
    assert_string_equal("the relay cannot open a socket to send; raise `ulimit -n`",
                        launcher_relay_open(&relay, &run, scheduler));
}

static void closing_closes_every_socket_once(void** state)
{
    (void)state;
    begin();
    launcher_relay_close(&relay);
    assert_int_equal(3U, closed);
    launcher_relay_close(&relay);
    assert_int_equal(3U, closed);
}

// ---- Frames ----

/// The consumer runs in the next time step: a frame is passed on in the last turn before it is due.
static void a_frame_is_passed_on_in_the_turn_before_it_is_due(void** state)
{
    (void)state;
    begin();
    assert_true(step(0U, 0U) == OSAL_LOCKSTEP_NEVER);
    put(LINK_IN_USE, 1U, FLOOR + 1U, LINK_FRAME_MAX);
    const datagram_t sent = queue[LINK_IN_USE][0];
    relay_take(&reference, LINK_IN_USE, sent.octets, sent.size, RUN_STEP_NS);
    const uint64_t due_ns = relay_next_ns(&reference);
    assert_true(due_ns != RELAY_NEVER);
    assert_true(step(RUN_STEP_NS, 1U) == (due_ns - RUN_STEP_NS));
    assert_true(step(due_ns - RUN_STEP_NS - 1U, 0U) == (due_ns - RUN_STEP_NS));
    assert_int_equal(0U, passed_count);
    assert_true(step(due_ns - RUN_STEP_NS, 0U) == OSAL_LOCKSTEP_NEVER);
    assert_int_equal(1U, passed_count);
    assert_int_equal(1000U + LINK_IN_USE, ports[0]);
    assert_int_equal(sent.size, passed[0].size);
    assert_memory_equal(sent.octets, passed[0].octets, sent.size);
    assert_int_equal(1U, delivered);
    assert_int_equal(1U, run.relay.delayed);
    assert_int_equal(0U, run.relay.lost + run.relay.reordered);
    assert_int_equal(0U, waits);
}

/// The frames of both links are passed on in the order of their due times; the losses and counts are those of
/// the second relay_t.
static void frames_of_all_links_are_delayed_and_lost_as_by_the_second_relay(void** state)
{
    size_t expected = 0U;
    (void)state;
    begin();
    for (uint32_t i = 0U; i < 1000U; i++) {
        const uint64_t now_ns = (uint64_t)i * RUN_STEP_NS;
        if (i < 900U) {
            put(0U, (2U * i) + 1U, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS);
            put(LINK_IN_USE, (2U * i) + 2U, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS + 8U);
            relay_take(&reference, 0U, queue[0][0].octets, queue[0][0].size, now_ns);
            relay_take(&reference, LINK_IN_USE, queue[LINK_IN_USE][0].octets, queue[LINK_IN_USE][0].size,
                       now_ns);
        }
        (void)step(now_ns, (i < 900U) ? 2U : 0U);
        for (const relay_frame_t* frame = relay_give(&reference, now_ns + RUN_STEP_NS); frame != NULL;
             frame                      = relay_give(&reference, now_ns + RUN_STEP_NS)) {
            assert_true(expected < passed_count);
            assert_int_equal(1000U + frame->link, ports[expected]);
            assert_int_equal(frame->size, passed[expected].size);
            assert_memory_equal(frame->octets, passed[expected].octets, frame->size);
            expected++;
        }
        assert_int_equal(expected, passed_count);
    }
    assert_int_equal(reference.counters.delayed, run.relay.delayed);
    assert_int_equal(reference.counters.lost, run.relay.lost);
    assert_int_equal(reference.counters.reordered, run.relay.reordered);
    assert_true((run.relay.lost > 0U) && (run.relay.reordered > 0U));
    assert_int_equal(1800U, run.relay.delayed + run.relay.lost);
    assert_int_equal(passed_count, delivered);
}

static void frames_above_the_capacity_are_lost_and_counted(void** state)
{
    (void)state;
    begin();
    for (uint32_t i = 0U; i < (RELAY_FRAMES_MAX + 1000U); i++) {
        put(0U, i, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS);
        relay_take(&reference, 0U, queue[0][0].octets, queue[0][0].size, 0U);
        (void)step(0U, 1U);
    }
    assert_int_equal(RELAY_FRAMES_MAX, relay.relay.count);
    assert_int_equal(1000U, run.relay.lost);
    assert_int_equal(reference.counters.lost, run.relay.lost);
    (void)step(10U * DELAY_US * 1000ULL, 0U);
    assert_int_equal(RELAY_FRAMES_MAX, passed_count);
    assert_int_equal(RELAY_FRAMES_MAX, run.relay.delayed);
}

// ---- Lives of consumers ----

static void frames_of_an_earlier_life_are_not_passed_on(void** state)
{
    (void)state;
    begin();
    put(0U, 1U, FLOOR, LINK_FRAME_HEADER_OCTETS);
    put(0U, 2U, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS);
    put(0U, 3U, FLOOR + 1U, 4U); // Too short for a frame: it has no epoch.
    (void)step(0U, 3U);
    (void)step(10U * DELAY_US * 1000ULL, 0U);
    assert_int_equal(3U, run.relay.delayed);
    assert_int_equal(1U, passed_count);
    assert_int_equal(2U, octets_u32_at(passed[0].octets));
    assert_int_equal(1U, delivered);
}

static void a_frame_that_cannot_be_sent_is_not_announced(void** state)
{
    (void)state;
    begin();
    put(0U, 1U, FLOOR + 1U, LINK_FRAME_HEADER_OCTETS);
    (void)step(0U, 1U);
    send_status = STATUS_FULL;
    (void)step(10U * DELAY_US * 1000ULL, 0U);
    assert_int_equal(0U, delivered);
}

// ---- Announced frames ----

static void an_announced_frame_is_waited_for(void** state)
{
    (void)state;
    begin();
    late_at = 7U;
    (void)step(0U, 1U);
    assert_int_equal(7U, waits);
    assert_int_equal(1U, relay.relay.count);
    assert_int_equal(0U, run.is_lossy);
}

/// Each of the 50 waits takes 100 ms, independent of the number of links.
static void an_announced_frame_that_does_not_arrive_is_noted(void** state)
{
    (void)state;
    begin();
    (void)step(0U, 1U);
    assert_int_equal(50U * 2U, waits);
    assert_int_equal(50U * 100U, waited_ms);
    assert_int_equal(1U, run.is_lossy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(without_a_delay_no_socket_is_taken_over, set_up),
        cmocka_unit_test_setup(sockets_that_cannot_be_opened_are_reported, set_up),
        cmocka_unit_test_setup(closing_closes_every_socket_once, set_up),
        cmocka_unit_test_setup(a_frame_is_passed_on_in_the_turn_before_it_is_due, set_up),
        cmocka_unit_test_setup(frames_of_all_links_are_delayed_and_lost_as_by_the_second_relay, set_up),
        cmocka_unit_test_setup(frames_above_the_capacity_are_lost_and_counted, set_up),
        cmocka_unit_test_setup(frames_of_an_earlier_life_are_not_passed_on, set_up),
        cmocka_unit_test_setup(a_frame_that_cannot_be_sent_is_not_announced, set_up),
        cmocka_unit_test_setup(an_announced_frame_is_waited_for, set_up),
        cmocka_unit_test_setup(an_announced_frame_that_does_not_arrive_is_noted, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
