// SPDX-License-Identifier: Apache-2.0
// An inbox for each peer, and the part of a window that is reserved for urgent requests.
#include "fsw/framework/message/message.h"

#include "test/unit/fsw/framework/message/party.h"
#include "unity.h"

#include <string.h>

static party_t party;
static uint8_t block[MESSAGE_PAYLOAD_MAX + 1U];
static uint8_t taken[MESSAGE_PAYLOAD_MAX];

/// Blocks of the largest size in a window.
#define LARGEST_BLOCKS (MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX)

void setUp(void)
{
}

void tearDown(void)
{
}

static message_endpoint_t* end(unsigned index)
{
    return &party.members[index].endpoint;
}

static uint32_t credit(unsigned from, unsigned to)
{
    return message_credit(end(from), party_id(to));
}

static status_t send_number(unsigned from, unsigned to, uint32_t number)
{
    return party_send(&party, from, to, &number, sizeof number);
}

static void expect_number(unsigned index, unsigned from, uint32_t number)
{
    unsigned sender = 99U;
    size_t size     = 0U;
    uint32_t found  = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, index, &sender, taken, sizeof taken, &size));
    TEST_ASSERT_EQUAL(from, sender);
    TEST_ASSERT_EQUAL(sizeof found, size);
    (void)memcpy(&found, taken, sizeof found);
    TEST_ASSERT_EQUAL(number, found);
}

static void expect_nothing(unsigned index)
{
    unsigned sender = 0U;
    size_t size     = 99U;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, party_receive(&party, index, &sender, taken, sizeof taken, &size));
    TEST_ASSERT_EQUAL(0U, size);
}

// ---- The reserve ----

static void fill_up_to_the_reserve(void)
{
    const message_endpoint_t* const sender = end(0U);
    for (uint32_t i = 0U; i < (MESSAGE_WINDOW - MESSAGE_RESERVE); i++) {
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW - MESSAGE_RESERVE - i, message_credit_plain(sender, party_id(1U)));
        TEST_ASSERT_EQUAL(STATUS_OK, message_send_plain(end(0U), party_id(1U), block, 4U));
    }
    TEST_ASSERT_EQUAL(0U, message_credit_plain(sender, party_id(1U)));
    TEST_ASSERT_EQUAL(STATUS_FULL, message_send_plain(end(0U), party_id(1U), block, 4U));
    TEST_ASSERT_EQUAL(MESSAGE_RESERVE, credit(0U, 1U));
    for (uint32_t i = 0U; i < MESSAGE_RESERVE; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 1U, 99U));
    TEST_ASSERT_EQUAL(0U, message_credit_plain(sender, 99U));
}

static void the_last_blocks_of_a_window_are_reserved(void)
{
    party_in_each_form(&party, fill_up_to_the_reserve);
}

static void fill_the_octets_up_to_the_reserve(void)
{
    uint32_t plain = 0U;
    while (message_send_plain(end(0U), party_id(1U), block, MESSAGE_PAYLOAD_MAX) == STATUS_OK) {
        plain++;
    }
    TEST_ASSERT_EQUAL(
        (MESSAGE_WINDOW_OCTETS - MESSAGE_RESERVE_OCTETS(MESSAGE_WINDOW_OCTETS)) / MESSAGE_FRAME_MAX, plain);
    uint32_t firm = 0U;
    while (party_send(&party, 0U, 1U, block, MESSAGE_PAYLOAD_MAX) == STATUS_OK) {
        firm++;
    }
    TEST_ASSERT_EQUAL(LARGEST_BLOCKS - plain, firm);
    TEST_ASSERT_TRUE(firm > 0U);
}

static void the_last_octets_of_a_window_are_reserved(void)
{
    party_in_each_form(&party, fill_the_octets_up_to_the_reserve);
}

// ---- One inbox for each peer ----

static bool admits_member_2(void* const context, const uint16_t peer)
{
    (void)context;
    return peer == party_id(2U);
}

static status_t receive_of_member_2(unsigned index, size_t* const out_size)
{
    const message_filter_t filter = {NULL, admits_member_2};
    uint16_t from                 = 0U;
    party_take_in(&party, index);
    return message_receive_if(end(index), &filter, &from, taken, sizeof taken, out_size);
}

/// Member 0 receives no data from member 1 any more, but its own channel to member 1 stays open.
static void refuse_one_peer(void)
{
    size_t size = 0U;
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, i));
    }
    for (uint32_t i = 0U; i < 1000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
        expect_number(1U, 0U, i);
        TEST_ASSERT_EQUAL(STATUS_FULL, send_number(1U, 0U, 99U)); // No credit is returned.
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(2U, 0U, i));
        TEST_ASSERT_EQUAL(STATUS_OK, receive_of_member_2(0U, &size));
        TEST_ASSERT_EQUAL(STATUS_EMPTY, receive_of_member_2(0U, &size));
        expect_nothing(2U);
    }
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        expect_number(0U, 1U, i);
    }
    expect_nothing(1U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(1U, 0U));
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(1U)->counters.lost);
}

static void a_receiver_that_accepts_no_data_still_accepts_credit(void)
{
    party_in_each_form(&party, refuse_one_peer);
}

static void take_control_alone(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, 7U));
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
        expect_number(1U, 0U, i);
    }
    TEST_ASSERT_EQUAL(0U, credit(0U, 1U));
    party_take_in(&party, 0U);
    message_take_control(end(0U));
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
    expect_number(0U, 1U, 7U);
}

static void credit_is_received_without_a_block(void)
{
    party_in_each_form(&party, take_control_alone);
}

/// The answer to a SYNC reports that no block was taken; the credit after it reports how many were. The order
/// must be kept.
static void answer_then_give_credit(void)
{
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 1U, 99U)); // Requests credit.
    }
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        expect_number(1U, 0U, i);
    }
    expect_nothing(1U);
    expect_nothing(0U);
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.syncs);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
}

static void an_older_answer_about_credit_is_handled_before_newer_credit(void)
{
    party_in_each_form(&party, answer_then_give_credit);
}

static void blocks_are_taken_in_order_of_arrival(void)
{
    party_open(&party, PARTY_RING);
    for (uint32_t i = 0U; i < 1000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, i));
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(2U, 0U, i));
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, 5000U + i));
        expect_number(0U, 1U, i);
        expect_number(0U, 2U, i);
        expect_number(0U, 1U, 5000U + i);
        expect_nothing(1U);
        expect_nothing(2U);
    }
    party_close(&party);
}

/// Only an attacker sends more than a window.
static void flood_beyond_the_window(void)
{
    // Magic, version 1, data, from member 0 (16) to member 1 (17), life 1 of the sender; the rest is 0.
    static uint8_t frame[MESSAGE_FRAME_MAX] = {0x48U, 0x4DU, 1U, 0U, 0U, 16U, 0U, 17U, 0U, 0U, 0U, 1U};
    unsigned from                           = 0U;
    size_t size                             = 0U;
    for (unsigned i = 0U; i < 20U; i++) {
        TEST_ASSERT_EQUAL((i < LARGEST_BLOCKS) ? STATUS_OK : STATUS_FULL,
                          message_deliver(end(1U), frame, sizeof frame));
    }
    TEST_ASSERT_TRUE(end(1U)->counters.overruns > 10U);
    while (party_receive(&party, 1U, &from, taken, sizeof taken, &size) != STATUS_EMPTY) {
    }
    while (party_receive(&party, 0U, &from, taken, sizeof taken, &size) != STATUS_EMPTY) {
    }
    for (uint32_t i = 0U; i < 8U; i++) {
        (void)send_number(0U, 1U, i);
        while (party_receive(&party, 1U, &from, taken, sizeof taken, &size) != STATUS_EMPTY) {
        }
        while (party_receive(&party, 0U, &from, taken, sizeof taken, &size) != STATUS_EMPTY) {
        }
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 9U));
    expect_number(1U, 0U, 9U);
}

static void frames_beyond_a_window_are_dropped_and_counted(void)
{
    party_in_each_form(&party, flood_beyond_the_window);
}

// ---- Windows smaller than the largest ----

#define SMALL MESSAGE_SMALL_WINDOW_OCTETS

static void shrink_the_window_to_member_1(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(end(0U), party_id(1U), SMALL));
    TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(end(1U), party_id(1U), SMALL));
}

static uint32_t send_all(status_t (*send)(message_endpoint_t*, uint16_t, const uint8_t*, size_t),
                         const size_t size)
{
    uint32_t sent = 0U;
    while (send(end(0U), party_id(1U), block, size) == STATUS_OK) {
        sent++;
    }
    return sent;
}

static void fill_a_small_window(void)
{
    const uint32_t frame = (uint32_t)MESSAGE_HEADER_OCTETS + 500U;
    // A sender has credit as long as a block of the largest size would fit.
    const uint32_t most  = SMALL - MESSAGE_FRAME_MAX;
    const uint32_t plain = ((most - MESSAGE_RESERVE_OCTETS(SMALL)) / frame) + 1U;
    shrink_the_window_to_member_1();
    TEST_ASSERT_EQUAL(plain, send_all(message_send_plain, 500U));
    TEST_ASSERT_EQUAL(0U, message_credit_plain(end(0U), party_id(1U)));
    TEST_ASSERT_EQUAL(((most / frame) + 1U) - plain, send_all(message_send, 500U));
    TEST_ASSERT_EQUAL(0U, credit(0U, 1U));
    party_take_in(&party, 1U);
    // The inbox stores the blocks with a length field of 4 octets each.
    TEST_ASSERT_TRUE(end(1U)->slots[0].channel.inbox.blocks.peak <= (SMALL + (MESSAGE_WINDOW * 4U)));
    uint32_t blocks = 0U; // The other direction keeps the largest window.
    while (party_send(&party, 1U, 0U, block, MESSAGE_PAYLOAD_MAX) == STATUS_OK) {
        blocks++;
    }
    TEST_ASSERT_EQUAL(LARGEST_BLOCKS, blocks);
}

static void a_small_window_limits_one_direction(void)
{
    party_in_each_form(&party, fill_a_small_window);
}

/// Blocks of every seventh size pass, each before one of the largest size. If the receiver returned credit
/// only after half of the small window, the largest block would not fit after blocks of some sizes, and the
/// sender would wait for a SYNC.
static void pass_blocks_of_many_sizes(void)
{
    unsigned from = 0U;
    size_t size   = 0U;
    shrink_the_window_to_member_1();
    for (size_t i = 0U; i <= MESSAGE_PAYLOAD_MAX; i += 7U) {
        for (unsigned k = 0U; k < 2U; k++) {
            const size_t octets = (k == 0U) ? i : MESSAGE_PAYLOAD_MAX;
            TEST_ASSERT_EQUAL(STATUS_OK, message_send_plain(end(0U), party_id(1U), block, octets));
            TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &from, taken, sizeof taken, &size));
            TEST_ASSERT_EQUAL(octets, size);
            expect_nothing(0U); // Credit arrives.
        }
    }
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.no_credit + end(0U)->counters.syncs + end(1U)->counters.overruns);
}

static void a_receiver_with_a_small_window_returns_credit_in_time(void)
{
    party_in_each_form(&party, pass_blocks_of_many_sizes);
}

static void impossible_windows_are_refused(void)
{
    party_open(&party, PARTY_RING);
    for (unsigned i = 0U; i < 2U; i++) {
        const uint16_t component = party_id(i);
        TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, message_set_window(end(0U), component, SMALL - 1U));
        TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE,
                          message_set_window(end(0U), component, MESSAGE_WINDOW_OCTETS + 1U));
        TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(end(0U), component, MESSAGE_WINDOW_OCTETS));
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, message_set_window(end(0U), 99U, SMALL));
    party_close(&party);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_small_window_limits_one_direction);
    RUN_TEST(a_receiver_with_a_small_window_returns_credit_in_time);
    RUN_TEST(impossible_windows_are_refused);
    RUN_TEST(the_last_blocks_of_a_window_are_reserved);
    RUN_TEST(the_last_octets_of_a_window_are_reserved);
    RUN_TEST(a_receiver_that_accepts_no_data_still_accepts_credit);
    RUN_TEST(credit_is_received_without_a_block);
    RUN_TEST(an_older_answer_about_credit_is_handled_before_newer_credit);
    RUN_TEST(blocks_are_taken_in_order_of_arrival);
    RUN_TEST(frames_beyond_a_window_are_dropped_and_counted);
    return UNITY_END();
}
