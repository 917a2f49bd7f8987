// SPDX-License-Identifier: Apache-2.0
// Lives that the run announces, and channels whose ends have different counts: whatever was lost, forged or
// damaged, data passes again after one exchange of SYNC.
#include "fsw/framework/message/message_positions.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/message/party.h"
#include "unity.h"

#include <string.h>

#define AT_KIND 3U
#define AT_FROM_LIFE 8U
#define AT_TO_LIFE 12U
#define AT_SEQUENCE 16U
#define AT_TAKEN 20U
#define HEAL_MAX 12U ///< Frames that may be lost before a forged channel carries data again.

static party_t party;
static uint8_t taken[MESSAGE_PAYLOAD_MAX];
static uint32_t random_state = 17U;

void setUp(void)
{
}

void tearDown(void)
{
    party.outcome = NULL;
}

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static message_endpoint_t* end(unsigned index)
{
    return &party.members[index].endpoint;
}

static status_t send_number(unsigned from, unsigned to, uint32_t number)
{
    return party_send(&party, from, to, &number, sizeof number);
}

/// Returns the next number that arrives; UINT32_MAX if there is none.
static uint32_t next_number(unsigned index)
{
    unsigned from  = 0U;
    size_t size    = 0U;
    uint32_t found = UINT32_MAX;
    if (party_receive(&party, index, &from, taken, sizeof taken, &size) == STATUS_OK) {
        TEST_ASSERT_EQUAL(sizeof found, size);
        (void)memcpy(&found, taken, sizeof found);
    }
    return found;
}

static void exchange(uint32_t first, uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, first + i));
        TEST_ASSERT_EQUAL(first + i, next_number(1U));
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, first + i));
        TEST_ASSERT_EQUAL(first + i, next_number(0U));
    }
}

static void take_all(unsigned index)
{
    while (next_number(index) != UINT32_MAX) {
    }
}

/// Make a frame as member `from` sends it to `to`, for the test to change.
static void forge(uint8_t frame[MESSAGE_HEADER_OCTETS + 4U], unsigned from, unsigned to)
{
    const message_endpoint_t* const sender = end(from);
    (void)memset(frame, 0, MESSAGE_HEADER_OCTETS + 4U);
    octets_put_u16(&frame[0], 0x484DU);
    frame[2] = 1U;
    octets_put_u16(&frame[4], party_id(from));
    octets_put_u16(&frame[6], party_id(to));
    octets_put_u32(&frame[AT_FROM_LIFE], sender->life);
    octets_put_u32(&frame[AT_TO_LIFE], end(to)->life);
}

static void inject(const uint8_t* frame, unsigned from, unsigned to)
{
    party_inject(&party, from, to, frame, MESSAGE_HEADER_OCTETS + 4U);
}

// ---- Lives given by the run ----

static void announce_the_lives_before_the_first_frame(void)
{
    message_set_life(end(0U), party_id(1U), 1U);
    message_set_life(end(1U), party_id(0U), 1U);
    message_set_life(end(0U), 99U, 4U); // This member does not exist.
    exchange(0U, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 50U)); // In transit when the receiver dies.
    party_restart(&party, 1U, 2U);
    message_set_life(end(0U), party_id(1U), 2U);
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(0U), party_id(1U)));
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.abandoned);
    message_set_life(end(1U), party_id(0U), 1U);
    // The new life has not sent a frame, but the first frame to it arrives.
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 60U));
    TEST_ASSERT_EQUAL(60U, next_number(1U));
    TEST_ASSERT_EQUAL((party.form == PARTY_RING) ? 0U : 1U, end(1U)->counters.stale);
    exchange(100U, 100U);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(1U)->counters.lost);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.syncs + end(1U)->counters.syncs);
}

static void a_life_given_by_the_run_needs_no_frame_first(void)
{
    party_in_each_form(&party, announce_the_lives_before_the_first_frame);
}

static void receive_frames_of_other_lives(void)
{
    uint8_t frame[MESSAGE_HEADER_OCTETS + 4U];
    message_set_life(end(1U), party_id(0U), 5U);
    party_restart(&party, 0U, 5U);
    message_set_life(end(0U), party_id(1U), 1U);
    exchange(0U, 3U);
    static const uint32_t others[] = {4U, 6U, UINT32_MAX};
    for (unsigned i = 0U; i < 300U; i++) {
        forge(frame, 0U, 1U);
        frame[AT_KIND] = (uint8_t)(i % 4U);
        octets_put_u32(&frame[AT_FROM_LIFE], others[i % 3U]);
        inject(frame, 0U, 1U);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(i + 1U, end(1U)->counters.stale);
    }
    TEST_ASSERT_EQUAL(3U, party.frames[1][0]); // Frames of other lives are not answered.
    exchange(10U, 3U);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void messages_of_other_lives_change_nothing(void)
{
    party_in_each_form(&party, receive_frames_of_other_lives);
}

/// If the run announces no lives, the first frame to a life that was never heard cannot be classified.
static void send_to_a_life_that_was_never_heard(void)
{
    party_restart(&party, 1U, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 1U));
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U)); // The receiver answers the stale frame at once by SYNC.
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.stale);
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.syncs);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U));
    TEST_ASSERT_EQUAL(1U, end(0U)->counters.abandoned);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, 2U));
    TEST_ASSERT_EQUAL(2U, next_number(1U));
    exchange(10U, 40U);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void a_lost_first_frame_is_reported(void)
{
    party_in_each_form(&party, send_to_a_life_that_was_never_heard);
}

/// The supervisor has commanded a start and dies: the position that it has kept belongs to the previous life
/// of the peer.
static void resume_after_a_start(void)
{
    message_position_t position;
    uint8_t kept[64];
    exchange(0U, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(1U, 0U, 50U)); // The block is not read yet when both die.
    party_take_in(&party, 0U);
    message_take_control(end(0U));
    TEST_ASSERT_TRUE(message_position(end(0U), 0U, &position));
    const size_t size = message_ring_copy(message_waiting(end(0U), 0U), kept, sizeof kept);
    party_restart(&party, 1U, 2U);
    party_restart(&party, 0U, 1U);
    message_set_life(end(1U), party_id(0U), 1U);
    message_set_life(end(0U), party_id(1U), 2U);
    message_ring_refill(message_waiting(end(0U), 0U), kept, size);
    message_resume(end(0U), &position);
    TEST_ASSERT_EQUAL(50U, next_number(0U));
    TEST_ASSERT_TRUE(message_is_of_past(end(0U)));
    exchange(100U, 100U);
    TEST_ASSERT_FALSE(message_is_of_past(end(0U)));
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.stale + end(1U)->counters.stale);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(1U)->counters.lost);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.syncs + end(1U)->counters.syncs);
}

static void a_position_of_an_earlier_life_is_not_resumed(void)
{
    party_in_each_form(&party, resume_after_a_start);
}

// ---- Loss ----

static unsigned losses_left;

static status_t lose_some(party_t* cut, unsigned from, unsigned to, const uint8_t* frame, size_t size)
{
    (void)cut;
    (void)from;
    (void)to;
    (void)frame;
    (void)size;
    if (losses_left == 0U) {
        return STATUS_OK;
    }
    losses_left--;
    return STATUS_EMPTY;
}

static void expect_all_counted(unsigned from, uint32_t sent)
{
    const message_counters_t* const counters = &end(1U - from)->counters;
    TEST_ASSERT_EQUAL(sent, counters->received + counters->lost);
    TEST_ASSERT_EQUAL(sent, end(from)->counters.sent);
}

static void lose_at_random(void)
{
    for (unsigned round = 0U; round < 400U; round++) {
        party.outcome = lose_some;
        losses_left   = draw(201U);
        for (unsigned i = 0U; (losses_left > 0U) && (i < 2000U); i++) {
            const unsigned who = draw(2U);
            (void)send_number(who, 1U - who, i);
            if (draw(4U) == 0U) {
                (void)next_number(draw(2U));
            }
        }
        party.outcome = NULL;
        take_all(0U);
        take_all(1U);
        for (unsigned who = 0U; who < 2U; who++) { // SYNC in both directions.
            message_probe(end(who), party_id(1U - who));
            take_all(1U - who);
            take_all(who);
        }
        for (unsigned who = 0U; who < 2U; who++) {
            TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(who), party_id(1U - who)));
            TEST_ASSERT_EQUAL(STATUS_OK, send_number(who, 1U - who, 5U));
            TEST_ASSERT_EQUAL(5U, next_number(1U - who));
            expect_all_counted(who, end(who)->counters.sent);
        }
    }
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.stale + end(1U)->counters.stale);
}

static void after_one_exchange_all_losses_are_counted_and_data_passes(void)
{
    party_in_each_form(&party, lose_at_random);
}

static void send_far_ahead(void)
{
    exchange(0U, 3U);
    // As after a forged credit, or in an endpoint that was copied.
    end(0U)->slots[0].channel.position.sent += 100U;
    end(0U)->slots[0].channel.position.credited += 100U;
    unsigned passed = 0U;
    for (uint32_t i = 0U; i < 200U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(0U, 1U, i));
        passed += (next_number(1U) != UINT32_MAX) ? 1U : 0U;
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U));
        (void)next_number(1U);
    }
    TEST_ASSERT_EQUAL(197U, passed); // The third failure in a row causes a SYNC.
    TEST_ASSERT_EQUAL(103U, end(1U)->counters.lost);
}

static void a_receiver_detects_a_sequence_number_far_ahead(void)
{
    party_in_each_form(&party, send_far_ahead);
}

// ---- Forged and damaged frames ----

/// Expect that after the injected frames data passes again within HEAL_MAX frames in each direction.
static void expect_healing(void)
{
    unsigned good = 0U;
    for (uint32_t i = 0U; i < HEAL_MAX; i++) {
        const bool is_sent = (send_number(0U, 1U, i) == STATUS_OK);
        const bool is_back = (send_number(1U, 0U, i) == STATUS_OK);
        const bool is_one  = (next_number(1U) == i);
        const bool is_two  = (next_number(0U) == i);
        good               = (is_sent && is_back && is_one && is_two) ? (good + 1U) : 0U;
        take_all(1U);
        take_all(0U);
    }
    TEST_ASSERT_TRUE(good >= 2U);
}

static void forge_each_field(void)
{
    static const uint32_t values[] = {0U, 1U, 2U, 20U, 33U, 1000U, 0x7FFFFFFFU, 0x80000000U, UINT32_MAX};
    static const size_t fields[]   = {AT_FROM_LIFE, AT_TO_LIFE, AT_SEQUENCE, AT_TAKEN};
    for (uint8_t kind = 0U; kind < 4U; kind++) {
        for (unsigned i = 0U; i < (4U * 9U * 3U); i++) {
            uint8_t frame[MESSAGE_HEADER_OCTETS + 4U];
            exchange(0U, 3U);
            forge(frame, 0U, 1U);
            frame[AT_KIND] = kind;
            octets_put_u32(&frame[AT_SEQUENCE], end(0U)->slots[0].channel.position.sent);
            octets_put_u32(&frame[AT_TAKEN], end(0U)->slots[0].channel.position.taken);
            octets_put_u32(&frame[fields[i % 4U]], values[(i / 4U) % 9U]);
            for (unsigned k = 0U; k <= (i / 36U); k++) {
                inject(frame, 0U, 1U);
            }
            take_all(1U);
            take_all(0U);
            take_all(1U);
            expect_healing();
            exchange(0U, 40U);
        }
    }
}

static void no_forged_frame_stops_a_channel_permanently(void)
{
    party_in_each_form(&party, forge_each_field);
}

static void without_lives_from_the_run_a_forged_life_is_corrected(void)
{
    uint8_t frame[MESSAGE_HEADER_OCTETS + 4U];
    party_open(&party, PARTY_RING);
    exchange(0U, 40U);
    forge(frame, 0U, 1U);
    octets_put_u32(&frame[AT_FROM_LIFE], UINT32_MAX);
    inject(frame, 0U, 1U);
    (void)next_number(1U);
    expect_healing();
    exchange(0U, 40U);
    party_close(&party);
}

/// Correct frames of both sides with octets changed at random, with and without lives from the run.
static void damage_at_random(void)
{
    for (unsigned round = 0U; round < 3000U; round++) {
        uint8_t frame[MESSAGE_HEADER_OCTETS + 4U];
        const unsigned from = draw(2U);
        if (round == 1500U) {
            message_set_life(end(0U), party_id(1U), 1U);
            message_set_life(end(1U), party_id(0U), 1U);
        }
        for (unsigned i = draw(20U); i > 0U; i--) {
            forge(frame, from, 1U - from);
            frame[AT_KIND] = (uint8_t)draw(4U);
            octets_put_u32(&frame[AT_SEQUENCE], end(from)->slots[0].channel.position.sent + draw(3U));
            octets_put_u32(&frame[AT_TAKEN], end(from)->slots[0].channel.position.taken + draw(3U));
            frame[AT_FROM_LIFE + draw(16U)] ^= (uint8_t)(1U << draw(8U));
            inject(frame, from, 1U - from);
            (void)next_number(1U - from);
        }
        take_all(0U);
        take_all(1U);
        take_all(0U);
        expect_healing();
    }
}

static void damaged_frames_stop_no_channel_permanently(void)
{
    party_in_each_form(&party, damage_at_random);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_life_given_by_the_run_needs_no_frame_first);
    RUN_TEST(messages_of_other_lives_change_nothing);
    RUN_TEST(a_lost_first_frame_is_reported);
    RUN_TEST(a_position_of_an_earlier_life_is_not_resumed);
    RUN_TEST(after_one_exchange_all_losses_are_counted_and_data_passes);
    RUN_TEST(a_receiver_detects_a_sequence_number_far_ahead);
    RUN_TEST(no_forged_frame_stops_a_channel_permanently);
    RUN_TEST(without_lives_from_the_run_a_forged_life_is_corrected);
    RUN_TEST(damaged_frames_stop_no_channel_permanently);
    return UNITY_END();
}
