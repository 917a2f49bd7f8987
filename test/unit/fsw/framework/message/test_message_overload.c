// SPDX-License-Identifier: Apache-2.0
// A receiver that is too slow, and interrupted connections: every loss is counted, and data passes again
// afterwards.
#include "test/unit/fsw/framework/message/party.h"

#include "unity.h"

#include <string.h>

#define PACKETS 60000U
#define OCTETS 1000U
#define STALL_MAX 400U ///< Largest number of packets sent while the receiver does not read.
#define ATTEMPTS 64U   ///< Attempts to send within which a restored connection is detected.
/// The same after a long interruption: more than the largest number of refusals between two SYNCs, 1024.
#define LONG_ATTEMPTS 1100U

static party_t party;
static uint8_t packet[OCTETS];
static uint8_t taken[MESSAGE_PAYLOAD_MAX];
static uint32_t random_state;

void setUp(void)
{
    random_state = 0x9E3779B9U;
}

void tearDown(void)
{
}

static uint32_t random_below(uint32_t limit)
{
    random_state ^= random_state << 13U;
    random_state ^= random_state >> 17U;
    random_state ^= random_state << 5U;
    return random_state % limit;
}

static message_counters_t* counters(unsigned index)
{
    return &party.members[index].endpoint.counters;
}

static status_t send_numbered(unsigned from, unsigned to, uint32_t number)
{
    for (unsigned i = 0U; i < OCTETS; i++) {
        packet[i] = (uint8_t)(number + i);
    }
    (void)memcpy(packet, &number, sizeof number);
    return party_send(&party, from, to, packet, sizeof packet);
}

/// Receive the next packet of a member, complete and unchanged. Returns its number; UINT32_MAX if there is no
/// packet.
static uint32_t take_numbered(unsigned index)
{
    uint32_t number       = 0U;
    unsigned from         = 0U;
    size_t size           = 0U;
    const status_t status = party_receive(&party, index, &from, taken, sizeof taken, &size);
    if (status == STATUS_EMPTY) {
        return UINT32_MAX;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(OCTETS, size);
    (void)memcpy(&number, taken, sizeof number);
    for (unsigned i = sizeof number; i < OCTETS; i++) {
        TEST_ASSERT_EQUAL_HEX8((uint8_t)(number + i), taken[i]);
    }
    return number;
}

// ---- A slow receiver ----

static uint8_t accepted[PACKETS];
static uint32_t next_expected;
static uint32_t delivered;

/// Receive up to `limit` packets; each must be the next accepted one.
static void take_some(uint32_t limit)
{
    for (uint32_t i = 0U; i < limit; i++) {
        const uint32_t number = take_numbered(1U);
        if (number == UINT32_MAX) {
            return;
        }
        while ((next_expected < PACKETS) && (accepted[next_expected] == 0U)) {
            next_expected++;
        }
        TEST_ASSERT_EQUAL(next_expected, number);
        next_expected++;
        delivered++;
    }
}

static void send_to_a_slow_receiver(void)
{
    uint32_t refused = 0U;
    uint32_t stall   = 0U;
    (void)memset(accepted, 0, sizeof accepted);
    next_expected = 0U;
    delivered     = 0U;
    for (uint32_t number = 0U; number < PACKETS; number++) {
        const status_t status = send_numbered(0U, 1U, number);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_FULL));
        accepted[number] = (status == STATUS_OK) ? 1U : 0U;
        refused += (status == STATUS_OK) ? 0U : 1U;
        if (stall > 0U) {
            stall--;
        } else if (random_below(100U) == 0U) {
            stall = random_below(STALL_MAX);
        } else {
            take_some(random_below(3U));
        }
        (void)take_numbered(0U); // The sender receives the frames that return credit.
    }
    take_some(UINT32_MAX);
    TEST_ASSERT_EQUAL(PACKETS, delivered + refused);
    TEST_ASSERT_EQUAL(refused, counters(0U)->no_credit);
    TEST_ASSERT_EQUAL(delivered, counters(1U)->received);
    TEST_ASSERT_EQUAL(0U, counters(1U)->lost);
    TEST_ASSERT_EQUAL(0U, counters(1U)->stale);
    TEST_ASSERT_TRUE(delivered > (PACKETS / 10U));
    TEST_ASSERT_TRUE(refused > (PACKETS / 10U));
}

static void every_block_to_a_slow_receiver_is_refused_or_delivered(void)
{
    party_in_each_form(&party, send_to_a_slow_receiver);
}

// ---- Connections that are cut ----

/// Lose a frame without notice to the sender.
static status_t lose(party_t* cut, unsigned from, unsigned to, const uint8_t* frame, size_t size)
{
    (void)cut;
    (void)from;
    (void)to;
    (void)frame;
    (void)size;
    return STATUS_EMPTY;
}

static void exchange(unsigned rounds)
{
    for (uint32_t i = 0U; i < rounds; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(0U, 1U, i));
        TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(1U, 0U, i));
        TEST_ASSERT_EQUAL(i, take_numbered(1U));
        TEST_ASSERT_EQUAL(i, take_numbered(0U));
    }
}

/// Both ends send into the interrupted connection until they are refused. Returns the packets that each end
/// has lost.
static uint32_t lose_both_windows(void)
{
    uint32_t lost = 0U;
    party.outcome = lose;
    while (message_credit(&party.members[0].endpoint, party_id(1U)) > 0U) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(0U, 1U, lost));
        TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(1U, 0U, lost));
        lost++;
    }
    for (unsigned i = 0U; i < 20U; i++) {
        TEST_ASSERT_EQUAL(STATUS_FULL, send_numbered(0U, 1U, 0U));
        TEST_ASSERT_EQUAL(STATUS_FULL, send_numbered(1U, 0U, 0U));
    }
    party.outcome = NULL;
    return lost;
}

static void lose_both_directions_and_continue(void)
{
    exchange(3U);
    const uint32_t lost = lose_both_windows();
    unsigned attempts   = 0U;
    while ((send_numbered(0U, 1U, 77U) != STATUS_OK) && (attempts < ATTEMPTS)) {
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(1U));
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(0U));
        attempts++;
    }
    TEST_ASSERT_TRUE(attempts < ATTEMPTS);
    TEST_ASSERT_EQUAL(77U, take_numbered(1U));
    TEST_ASSERT_EQUAL(lost, counters(1U)->lost);
    while ((send_numbered(1U, 0U, 78U) != STATUS_OK) && (attempts < (2U * ATTEMPTS))) {
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(0U));
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(1U));
        attempts++;
    }
    TEST_ASSERT_EQUAL(78U, take_numbered(0U));
    TEST_ASSERT_EQUAL(lost, counters(0U)->lost);
    exchange(100U);
}

static void the_loss_of_both_windows_is_counted_and_their_blocks_are_freed(void)
{
    party_in_each_form(&party, lose_both_directions_and_continue);
}

static void probe_after_an_interruption(void)
{
    exchange(1U);
    TEST_ASSERT_TRUE(lose_both_windows() > 0U);
    message_probe(&party.members[0].endpoint, party_id(1U));
    // No frame was sent to this peer, so no SYNC is sent.
    message_probe(&party.members[0].endpoint, party_id(2U));
    message_probe(&party.members[0].endpoint, 99U); // This peer does not exist.
    TEST_ASSERT_EQUAL(0U, party.frames[0][2]);
    TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(1U));
    TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(0U, 1U, 5U));
    TEST_ASSERT_EQUAL(5U, take_numbered(1U));
}

static void a_probe_sends_a_sync_at_once(void)
{
    party_in_each_form(&party, probe_after_an_interruption);
}

/// Lose only the frames from member 1, which return credit to member 0.
static status_t lose_answers(party_t* cut, unsigned from, unsigned to, const uint8_t* frame, size_t size)
{
    (void)cut;
    (void)to;
    (void)frame;
    (void)size;
    return (from == 1U) ? STATUS_EMPTY : STATUS_OK;
}

static void offer_the_same_credit_again(void)
{
    party.outcome = lose_answers;
    for (uint32_t i = 0U; message_credit(&party.members[0].endpoint, party_id(1U)) > 0U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_numbered(0U, 1U, i));
        TEST_ASSERT_EQUAL(i, take_numbered(1U));
    }
    party.outcome     = NULL;
    unsigned attempts = 0U;
    while ((send_numbered(0U, 1U, 9U) != STATUS_OK) && (attempts < ATTEMPTS)) {
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(1U));
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(0U));
        attempts++;
    }
    TEST_ASSERT_EQUAL(9U, take_numbered(1U));
    TEST_ASSERT_EQUAL(0U, counters(1U)->lost);
}

static void credit_that_was_lost_is_reported_again(void)
{
    party_in_each_form(&party, offer_the_same_credit_again);
}

static void flood_a_receiver_that_does_not_read(void)
{
    for (uint32_t i = 0U; i < 1000000U; i++) {
        TEST_ASSERT_EQUAL((i < MESSAGE_WINDOW) ? STATUS_OK : STATUS_FULL,
                          party_send(&party, 0U, 1U, packet, 1U));
    }
    // At most one SYNC is sent in 1024 refusals, and 8 before that: at 4, 8, 16 .. 512.
    TEST_ASSERT_TRUE(counters(0U)->syncs <= 1000U);
    TEST_ASSERT_EQUAL(1000000U - MESSAGE_WINDOW, counters(0U)->no_credit);
}

static void repeated_syncs_do_not_fill_the_carrier(void)
{
    party_in_each_form(&party, flood_a_receiver_that_does_not_read);
}

/// The sender detects the end of a long interruption within LONG_ATTEMPTS attempts.
static void interrupt_for_a_long_time(void)
{
    exchange(3U);
    const uint32_t lost = lose_both_windows();
    party.outcome       = lose;
    for (unsigned i = 0U; i < 100000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_FULL, send_numbered(0U, 1U, 0U));
        TEST_ASSERT_EQUAL(STATUS_FULL, send_numbered(1U, 0U, 0U));
    }
    party.outcome     = NULL;
    unsigned attempts = 0U;
    while ((send_numbered(0U, 1U, 77U) != STATUS_OK) && (attempts < LONG_ATTEMPTS)) {
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(1U));
        TEST_ASSERT_EQUAL(UINT32_MAX, take_numbered(0U));
        attempts++;
    }
    TEST_ASSERT_TRUE(attempts < LONG_ATTEMPTS);
    TEST_ASSERT_EQUAL(77U, take_numbered(1U));
    TEST_ASSERT_EQUAL(lost, counters(1U)->lost);
}

static void the_end_of_a_long_interruption_is_detected(void)
{
    party_in_each_form(&party, interrupt_for_a_long_time);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_block_to_a_slow_receiver_is_refused_or_delivered);
    RUN_TEST(the_loss_of_both_windows_is_counted_and_their_blocks_are_freed);
    RUN_TEST(a_probe_sends_a_sync_at_once);
    RUN_TEST(credit_that_was_lost_is_reported_again);
    RUN_TEST(repeated_syncs_do_not_fill_the_carrier);
    RUN_TEST(the_end_of_a_long_interruption_is_detected);
    return UNITY_END();
}
