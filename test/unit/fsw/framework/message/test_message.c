// SPDX-License-Identifier: Apache-2.0
// Order, credits and losses of blocks, over each carrier.
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/message_positions.h"

#include "test/unit/fsw/framework/message/party.h"
#include "unity.h"

#include <string.h>

static party_t party;
static uint8_t block[MESSAGE_PAYLOAD_MAX + 1U];
static uint8_t taken[MESSAGE_PAYLOAD_MAX];

#define LARGEST_BLOCKS (MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX) ///< Largest blocks in a window.

void setUp(void)
{
}

void tearDown(void)
{
}

static uint32_t random_state = 7U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
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

// ---- Octets ----

static void send_each_size(void)
{
    static const size_t sizes[] = {0U, 1U, 2U, 23U, 24U, 25U, 255U, 256U, 4095U, 4096U};
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        unsigned from = 99U;
        size_t size   = 0U;
        for (size_t k = 0U; k < sizes[i]; k++) {
            block[k] = (uint8_t)draw(256U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, block, sizes[i]));
        TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &from, taken, sizeof taken, &size));
        TEST_ASSERT_EQUAL(0U, from);
        TEST_ASSERT_EQUAL(sizes[i], size);
        TEST_ASSERT_EQUAL(0, memcmp(block, taken, size));
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, party_send(&party, 0U, 1U, block, 4097U));
    expect_nothing(1U);
}

static void octets_arrive_unchanged(void)
{
    party_in_each_form(&party, send_each_size);
}

static void send_to_unknown_peers(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, message_send(end(0U), 99U, block, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, message_send(end(0U), party_id(0U), block, 1U));
    TEST_ASSERT_EQUAL(0U, message_credit(end(0U), 99U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, message_add_peer(end(0U), party_id(1U)));
}

static void no_more_peers_are_added_than_there_are_slots(void)
{
    static message_slot_t slots[MESSAGE_PEERS_MAX];
    static message_endpoint_t alone;
    party_open(&party, PARTY_RING);
    message_open(&alone, 1U, 1U, message_ring_carrier_port(&party.hub), slots, MESSAGE_PEERS_MAX);
    for (uint16_t i = 0U; i < MESSAGE_PEERS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&alone, (uint16_t)(100U + i)));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, message_add_peer(&alone, 200U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      message_send(&alone, 100U, block, 1U)); // The carrier has no address of this peer.
    TEST_ASSERT_EQUAL(1U, alone.counters.unreachable);
    message_open(&alone, 1U, 1U, message_ring_carrier_port(&party.hub), slots, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&alone, 100U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, message_add_peer(&alone, 101U));
    party_close(&party);
}

static void ignore_delivery(void* const context, const uint16_t to)
{
    (void)context;
    (void)to;
}

static void an_endpoint_takes_one_slot_of_the_ring_carrier_in_all_its_lives(void)
{
    static message_endpoint_t endpoints[MESSAGE_PEERS_MAX + 1U];
    static message_ring_carrier_t carrier;
    message_ring_carrier_init(&carrier, (message_delivery_notice_t){NULL, ignore_delivery});
    for (size_t i = 0U; i < MESSAGE_PEERS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&carrier, &endpoints[i]));
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&carrier, &endpoints[i]));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, message_ring_carrier_attach(&carrier, &endpoints[MESSAGE_PEERS_MAX]));
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&carrier, &endpoints[0]));
}

static void addresses_that_are_no_peer_are_refused(void)
{
    for (unsigned form = PARTY_RING; form < party_forms(); form++) {
        party_open(&party, (party_form_t)form);
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
        party_close(&party);
    }
    party_open(&party, PARTY_RING);
    send_to_unknown_peers();
    party_close(&party);
}

static void read_with_too_little_room(void)
{
    unsigned from = 0U;
    size_t size   = 0U;
    for (unsigned i = 0U; i < (2U * MESSAGE_WINDOW); i++) { // The credit of a dropped block is returned, too.
        TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, block, 10U));
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, party_receive(&party, 1U, &from, taken, 9U, &size));
        TEST_ASSERT_EQUAL(0U, size);
        expect_nothing(0U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 5U));
    expect_number(1U, 0U, 5U);
}

static void a_block_too_large_for_the_reader_is_dropped_alone(void)
{
    party_in_each_form(&party, read_with_too_little_room);
}

// ---- Credits ----

static void fill_the_window(void)
{
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW - i, credit(0U, 1U));
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    TEST_ASSERT_EQUAL(0U, credit(0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 1U, 99U));
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.no_credit);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 2U, 7U)); // Each channel has credit of its own.
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, 8U)); // Each direction has credit of its own.
    for (uint32_t i = 0U; i < (MESSAGE_WINDOW / 2U); i++) {
        expect_number(1U, 0U, i);
    }
    expect_number(0U, 1U, 8U);
    expect_nothing(0U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW / 2U, credit(0U, 1U));
    for (uint32_t i = MESSAGE_WINDOW / 2U; i < MESSAGE_WINDOW; i++) {
        expect_number(1U, 0U, i);
    }
    expect_nothing(1U); // The refused block was not sent.
    expect_nothing(0U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void no_more_messages_than_a_window_are_unacknowledged(void)
{
    party_in_each_form(&party, fill_the_window);
}

static void return_a_block_for_each(void)
{
    for (uint32_t i = 0U; i < 200U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
        expect_number(1U, 0U, i);
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, i));
        expect_number(0U, 1U, i);
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
    }
    TEST_ASSERT_EQUAL(200U, party.frames[0][1]); // No separate frame of credit was sent.
    TEST_ASSERT_EQUAL(200U, party.frames[1][0]);
}

/// Blocks of the largest size reach the limit of octets of a window before the limit of blocks. When the
/// receiver reads them, it returns credit.
static void fill_the_octets_of_the_window(void)
{
    size_t size = 0U;
    for (uint32_t i = 0U; i < LARGEST_BLOCKS; i++) {
        TEST_ASSERT_TRUE(credit(0U, 1U) > 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, block, MESSAGE_PAYLOAD_MAX));
    }
    TEST_ASSERT_EQUAL(0U, credit(0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_FULL, party_send(&party, 0U, 1U, block, 1U));
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.no_credit);
    for (uint32_t i = 0U; i < LARGEST_BLOCKS; i++) {
        unsigned member = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &member, taken, sizeof taken, &size));
        TEST_ASSERT_EQUAL(MESSAGE_PAYLOAD_MAX, size);
    }
    expect_nothing(0U); // A frame with credit arrives, but no block.
    TEST_ASSERT_TRUE(credit(0U, 1U) >= (LARGEST_BLOCKS / 2U));
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.overruns);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void no_more_octets_than_a_window_are_unacknowledged(void)
{
    party_in_each_form(&party, fill_the_octets_of_the_window);
}

/// Every block in the opposite direction also carries credit, so no separate frame of credit is sent.
static void answer_large_blocks(void)
{
    unsigned member = 0U;
    size_t size     = 0U;
    for (uint32_t i = 0U; i < (4U * LARGEST_BLOCKS); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, block, MESSAGE_PAYLOAD_MAX));
        TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &member, taken, sizeof taken, &size));
        TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 1U, 0U, block, 1U));
        TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 0U, &member, taken, sizeof taken, &size));
        TEST_ASSERT_EQUAL(i + 1U, party.frames[1][0]);
    }
}

static void a_block_in_return_carries_the_credit_of_octets(void)
{
    party_in_each_form(&party, answer_large_blocks);
}

static void frames_of_data_also_carry_credit(void)
{
    party_in_each_form(&party, return_a_block_for_each);
}

static void send_and_receive_in_random_order(void)
{
    uint32_t sent[2] = {0U, 0U};
    uint32_t seen[2] = {0U, 0U};
    for (unsigned step = 0U; step < 20000U; step++) {
        const unsigned from = draw(2U);
        const unsigned to   = 1U - from;
        if (draw(3U) > 0U) {
            const uint32_t allowed = credit(from, to);
            const status_t status  = send_number(from, to, sent[from]);
            TEST_ASSERT_EQUAL((allowed > 0U) ? STATUS_OK : STATUS_FULL, status);
            sent[from] += (status == STATUS_OK) ? 1U : 0U;
        } else if (seen[from] < sent[from]) {
            expect_number(to, from, seen[from]);
            seen[from]++;
        } else {
            expect_nothing(to);
        }
        TEST_ASSERT_TRUE((sent[from] - seen[from]) <= MESSAGE_WINDOW);
        TEST_ASSERT_TRUE(credit(from, to) <= (MESSAGE_WINDOW - (sent[from] - seen[from])));
    }
    for (unsigned from = 0U; from < 2U; from++) { // Receive the remaining blocks.
        while (seen[from] < sent[from]) {
            expect_number(1U - from, from, seen[from]);
            seen[from]++;
        }
        TEST_ASSERT_EQUAL(0U, end(from)->counters.lost + end(from)->counters.stale +
                                  end(from)->counters.malformed + end(from)->counters.unreachable);
        TEST_ASSERT_EQUAL(sent[from], end(from)->counters.sent);
        TEST_ASSERT_EQUAL(sent[from], end(1U - from)->counters.received);
    }
}

static void accepted_blocks_arrive_in_order(void)
{
    party_in_each_form(&party, send_and_receive_in_random_order);
}

// ---- Carriers that refuse or lose ----

static unsigned frames_seen;
static unsigned refused_from; // For frames [refused_from, refused_to) the carrier returns `refusal`.
static unsigned refused_to;
static unsigned refused_sender;
static status_t refusal;

static status_t refuse_some(party_t* self, unsigned from, unsigned to, const uint8_t* frame, size_t size)
{
    (void)self;
    (void)to;
    (void)frame;
    (void)size;
    if (from != refused_sender) {
        return STATUS_OK;
    }
    const unsigned number = frames_seen++;
    return ((number >= refused_from) && (number < refused_to)) ? refusal : STATUS_OK;
}

static void set_outcome(unsigned sender, unsigned from, unsigned to, status_t status)
{
    frames_seen    = 0U;
    refused_sender = sender;
    refused_from   = from;
    refused_to     = to;
    refusal        = status;
    party.outcome  = refuse_some;
}

static void meet_a_full_carrier(void)
{
    set_outcome(0U, 1U, 4U, STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 0U));
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 1U, 1U));
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW - 1U, credit(0U, 1U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 1U));
    expect_number(1U, 0U, 0U);
    expect_number(1U, 0U, 1U);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.unreachable);
}

static void a_block_refused_by_a_full_carrier_can_be_sent_again(void)
{
    party_in_each_form(&party, meet_a_full_carrier);
}

static void send_to_an_unreachable_receiver(void)
{
    set_outcome(0U, 0U, 2U, STATUS_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, send_number(0U, 1U, 0U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, send_number(0U, 1U, 0U));
    TEST_ASSERT_EQUAL(2U, end(0U)->counters.unreachable);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 1U));
    expect_number(1U, 0U, 1U);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void an_unreachable_peer_is_reported_and_counted(void)
{
    party_in_each_form(&party, send_to_an_unreachable_receiver);
}

static void lose_some(void)
{
    set_outcome(0U, 3U, 8U, STATUS_EMPTY);
    for (uint32_t i = 0U; i < 20U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    for (uint32_t i = 0U; i < 20U; i++) {
        if ((i < 3U) || (i >= 8U)) {
            expect_number(1U, 0U, i);
        }
    }
    TEST_ASSERT_EQUAL(5U, end(1U)->counters.lost);
    TEST_ASSERT_EQUAL(15U, end(1U)->counters.received);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, 0U));
    expect_number(0U, 1U, 0U);
    TEST_ASSERT_EQUAL_MESSAGE(MESSAGE_WINDOW, credit(0U, 1U), "expected the credit of the lost blocks back");
}

static void lost_blocks_are_counted_and_give_their_credit_back(void)
{
    party_in_each_form(&party, lose_some);
}

static void lose_all_but_the_last(void)
{
    set_outcome(0U, 0U, MESSAGE_WINDOW - 1U, STATUS_EMPTY);
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    expect_number(1U, 0U, MESSAGE_WINDOW - 1U); // This is the greatest number that the credit allows.
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW - 1U, end(1U)->counters.lost);
    expect_nothing(0U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
}

static void the_last_block_of_a_window_is_received_if_all_others_are_lost(void)
{
    party_in_each_form(&party, lose_all_but_the_last);
}

static void lose_a_whole_window(void)
{
    set_outcome(0U, 0U, MESSAGE_WINDOW, STATUS_EMPTY);
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 1U, 99U));
    // Member 1 has not detected the loss. When member 0 returns credit for the blocks of member 1, the
    // sequence number of that frame shows member 1 how many blocks it has missed.
    for (uint32_t i = 0U; i < (MESSAGE_WINDOW / 2U); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, i));
        expect_number(0U, 1U, i);
    }
    expect_nothing(1U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, end(1U)->counters.lost);
    expect_nothing(0U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 100U));
    expect_number(1U, 0U, 100U);
}

static void the_sender_continues_after_the_loss_of_a_window(void)
{
    party_in_each_form(&party, lose_a_whole_window);
}

static void refuse_all_credit(void)
{
    set_outcome(1U, 0U, UINT32_MAX, STATUS_FULL);
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(2U, 1U, i));
    }
    for (uint32_t i = 0U; i < MESSAGE_WINDOW; i++) {
        expect_number(1U, 2U, i);
    }
    expect_nothing(2U);
    TEST_ASSERT_EQUAL(STATUS_FULL, send_number(2U, 1U, 99U));
    TEST_ASSERT_EQUAL(0U, credit(2U, 1U));
    set_outcome(1U, 0U, 0U, STATUS_OK); // The carrier has room again: credit is sent without new data.
    expect_nothing(1U);
    expect_nothing(2U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, credit(2U, 1U));
}

static void credit_that_the_carrier_refused_is_sent_again(void)
{
    party_in_each_form(&party, refuse_all_credit);
}

static uint8_t diverted[MESSAGE_FRAME_MAX];
static size_t diverted_size;
static unsigned arrivals;

static status_t divert(void* context, uint16_t to, const uint8_t* frame, size_t size)
{
    (void)context;
    (void)to;
    (void)memcpy(diverted, frame, size);
    diverted_size = size;
    return STATUS_OK;
}

static void count_arrival(void* context, const uint8_t* frame, size_t size)
{
    (void)context;
    TEST_ASSERT_EQUAL(diverted_size, size);
    TEST_ASSERT_EQUAL_MEMORY(diverted, frame, size);
    arrivals++;
}

static void diverted_frames_arrive_when_they_are_forwarded(void)
{
    unsigned from = 99U;
    size_t size   = 0U;
    party_open(&party, PARTY_RING);
    arrivals = 0U;
    message_divert(end(0U), (message_carrier_t){NULL, divert});
    message_watch(end(1U), (message_arrival_t){NULL, count_arrival});
    TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, (const uint8_t*)"a", 1U));
    expect_nothing(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, message_forward(end(0U), party_id(1U), diverted, diverted_size));
    TEST_ASSERT_EQUAL(STATUS_OK, message_forward(end(0U), party_id(1U), diverted, diverted_size));
    TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &from, taken, sizeof taken, &size));
    TEST_ASSERT_EQUAL(1U, size);
    expect_nothing(1U); // The second copy is dropped.
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.stale);
    TEST_ASSERT_EQUAL(2U, arrivals);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, message_forward(end(0U), 99U, diverted, diverted_size));
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.unreachable);
    party_close(&party);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(octets_arrive_unchanged);
    RUN_TEST(an_endpoint_takes_one_slot_of_the_ring_carrier_in_all_its_lives);
    RUN_TEST(addresses_that_are_no_peer_are_refused);
    RUN_TEST(no_more_peers_are_added_than_there_are_slots);
    RUN_TEST(a_block_too_large_for_the_reader_is_dropped_alone);
    RUN_TEST(no_more_messages_than_a_window_are_unacknowledged);
    RUN_TEST(no_more_octets_than_a_window_are_unacknowledged);
    RUN_TEST(a_block_in_return_carries_the_credit_of_octets);
    RUN_TEST(frames_of_data_also_carry_credit);
    RUN_TEST(accepted_blocks_arrive_in_order);
    RUN_TEST(a_block_refused_by_a_full_carrier_can_be_sent_again);
    RUN_TEST(an_unreachable_peer_is_reported_and_counted);
    RUN_TEST(lost_blocks_are_counted_and_give_their_credit_back);
    RUN_TEST(the_last_block_of_a_window_is_received_if_all_others_are_lost);
    RUN_TEST(the_sender_continues_after_the_loss_of_a_window);
    RUN_TEST(credit_that_the_carrier_refused_is_sent_again);
    RUN_TEST(diverted_frames_arrive_when_they_are_forwarded);
    return UNITY_END();
}
