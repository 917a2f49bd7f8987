// SPDX-License-Identifier: Apache-2.0
// The window of a channel: its exact bounds, numbers that pass 2^32, hostile frames, lost frames, and deaths
// of both ends. The endpoints have the small inboxes of a board: this file compiles them with that capacity.
#define MESSAGE_ROOM_OCTETS 8192U
#include "fsw/framework/message/message.c"
#include "fsw/framework/message/message_positions.c"
#include "fsw/framework/message/message_window.c"

#include "fsw/framework/message/ring_carrier.h"
#include "test/support/consistent_message.h"
#include "unity.h"

#define SMALL MESSAGE_SMALL_WINDOW_OCTETS
#define FRAMES_KEPT 64U
#define NO_NUMBER UINT32_MAX
/// Octets of the smaller blocks of an exactly full window, which ends with a block of the largest size.
#define BEFORE_LARGEST (SMALL - MESSAGE_FRAME_MAX)

typedef struct {
    uint8_t octets[MESSAGE_FRAME_MAX];
    size_t size;
} kept_t;

static message_ring_carrier_t hub;
static message_endpoint_t ends[2];
static message_slot_t slots[2];
static uint8_t block[MESSAGE_PAYLOAD_MAX];
static uint8_t heard[MESSAGE_PAYLOAD_MAX];
static bool is_losing_data; // Frames with data are lost.
static uint32_t lost_data;
static bool is_keeping; // Frames are kept; their receiver does not get them.
static kept_t kept[FRAMES_KEPT];
static size_t kept_count;
static uint32_t random_state;

static uint16_t id(const unsigned index)
{
    return (uint16_t)(16U + index);
}

static message_channel_t* channel(const unsigned index)
{
    return &slots[index].channel;
}

static uint32_t draw(const uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static void ignore(void* const context, const uint16_t to)
{
    (void)context;
    (void)to;
}

static status_t pass(void* const context, const uint16_t to, const uint8_t* const frame, const size_t size)
{
    (void)context;
    if (is_keeping) {
        TEST_ASSERT_TRUE(kept_count < FRAMES_KEPT);
        (void)memcpy(kept[kept_count].octets, frame, size);
        kept[kept_count].size = size;
        kept_count++;
        return STATUS_OK;
    }
    if (is_losing_data && (frame[MESSAGE_AT_KIND] == MESSAGE_DATA)) {
        lost_data++;
        return STATUS_OK;
    }
    const message_carrier_t carrier = message_ring_carrier_port(&hub);
    return carrier.send(carrier.context, to, frame, size);
}

/// Open an end with empty inbox and small windows in both directions, as a process that starts.
static void start(const unsigned index, const uint32_t life)
{
    const message_carrier_t carrier = {NULL, pass};
    message_open(&ends[index], id(index), life, carrier, &slots[index], 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&ends[index], id(1U - index)));
    TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(&ends[index], id(index), SMALL));
    TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(&ends[index], id(1U - index), SMALL));
}

void setUp(void)
{
    random_state   = 5U;
    is_losing_data = false;
    is_keeping     = false;
    lost_data      = 0U;
    kept_count     = 0U;
    message_ring_carrier_init(&hub, (message_delivery_notice_t){NULL, ignore});
    for (unsigned i = 0U; i < 2U; i++) {
        start(i, 1U);
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&hub, &ends[i]));
    }
}

void tearDown(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_TRUE(message_is_consistent(&ends[i]));
        TEST_ASSERT_TRUE(message_position_is_sound(&channel(i)->position));
    }
}

static status_t send_number(const unsigned from, const uint32_t number, const size_t size)
{
    octets_put_u32(block, number);
    return message_send(&ends[from], id(1U - from), block, size);
}

/// Returns the number of the next block that an end receives; NO_NUMBER if there is none.
static uint32_t take_number(const unsigned index)
{
    uint16_t from = 0U;
    size_t size   = 0U;
    if (message_receive(&ends[index], &from, heard, sizeof heard, &size) != STATUS_OK) {
        return NO_NUMBER;
    }
    TEST_ASSERT_EQUAL_UINT16(id(1U - index), from);
    return octets_u32_at(heard);
}

static uint32_t take_all(const unsigned index)
{
    uint32_t taken = 0U;
    while (take_number(index) != NO_NUMBER) {
        taken++;
    }
    return taken;
}

/// Send the blocks of an exactly full window: MESSAGE_WINDOW blocks with SMALL octets.
static void fill_exactly(const unsigned from)
{
    uint32_t left = BEFORE_LARGEST;
    for (uint32_t i = 1U; i < MESSAGE_WINDOW; i++) {
        const uint32_t frame = left / (MESSAGE_WINDOW - i);
        TEST_ASSERT_EQUAL(STATUS_OK, send_number(from, i - 1U, frame - MESSAGE_HEADER_OCTETS));
        left -= frame;
    }
    TEST_ASSERT_EQUAL(0U, left);
    TEST_ASSERT_EQUAL(1U, message_credit(&ends[from], id(1U - from)));
    TEST_ASSERT_EQUAL(STATUS_OK, send_number(from, MESSAGE_WINDOW - 1U, MESSAGE_PAYLOAD_MAX));
    TEST_ASSERT_EQUAL(SMALL, channel(from)->position.under_way);
    TEST_ASSERT_EQUAL(0U, message_credit(&ends[from], id(1U - from)));
}

static void expect_numbers(const unsigned index, const uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT32(i, take_number(index));
    }
    TEST_ASSERT_EQUAL_UINT32(NO_NUMBER, take_number(index));
}

// ---- Bounds ----

static void credit_ends_at_the_exact_octet(void)
{
    for (uint32_t window = SMALL; window <= MESSAGE_WINDOW_OCTETS; window++) {
        message_channel_t one   = {.window = window};
        const uint32_t reserved = MESSAGE_RESERVE_OCTETS(window);
        one.position.under_way  = window - MESSAGE_FRAME_MAX;
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, message_window_credit(&one, false));
        TEST_ASSERT_EQUAL_UINT32(0U, message_window_credit(&one, true));
        one.position.under_way++;
        TEST_ASSERT_EQUAL_UINT32(0U, message_window_credit(&one, false));
        one.position.under_way = window - MESSAGE_FRAME_MAX - reserved;
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW - MESSAGE_RESERVE, message_window_credit(&one, true));
        one.position.under_way++;
        TEST_ASSERT_EQUAL_UINT32(0U, message_window_credit(&one, true));
    }
}

static void credit_ends_at_the_exact_block_for_all_numbers(void)
{
    static const uint32_t numbers[] = {0U, 1U, 0x7FFFFFF0U, UINT32_MAX - 31U, UINT32_MAX - 5U, UINT32_MAX};
    for (size_t i = 0U; i < (sizeof numbers / sizeof numbers[0]); i++) {
        for (uint32_t blocks = 0U; blocks <= MESSAGE_WINDOW; blocks++) {
            const message_channel_t one = {
                .window = SMALL, .position.credited = numbers[i], .position.sent = numbers[i] + blocks};
            const uint32_t left = MESSAGE_WINDOW - blocks;
            TEST_ASSERT_EQUAL_UINT32(left, message_window_credit(&one, false));
            TEST_ASSERT_EQUAL_UINT32((left > MESSAGE_RESERVE) ? (left - MESSAGE_RESERVE) : 0U,
                                     message_window_credit(&one, true));
        }
    }
}

/// Otherwise sender and receiver could wait for each other.
static void a_sender_that_waits_for_less_than_the_interval_can_send(void)
{
    for (uint32_t window = SMALL; window <= MESSAGE_WINDOW_OCTETS; window++) {
        const uint32_t interval = message_window_interval(window);
        TEST_ASSERT_TRUE((interval > 0U) && (interval <= (window / 2U)));
        const message_channel_t one = {.window = window, .position.under_way = interval - 1U};
        TEST_ASSERT_TRUE(message_window_credit(&one, true) > 0U);
    }
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW_OCTETS / 2U, message_window_interval(MESSAGE_WINDOW_OCTETS));
}

static void an_end_grants_no_more_than_its_inbox_holds(void)
{
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, message_set_window(&ends[1], id(1U), SMALL - 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, message_set_window(&ends[1], id(1U), MESSAGE_ROOM_OCTETS + 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, message_set_window(&ends[1], id(1U), 0U)); // The largest window.
    TEST_ASSERT_EQUAL_UINT32(SMALL, ends[1].window);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, message_set_window(&ends[1], id(0U), UINT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(SMALL, channel(1U)->window);
    TEST_ASSERT_EQUAL(STATUS_OK, message_set_window(&ends[1], id(0U), 0U));
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW_OCTETS, channel(1U)->window);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, message_set_window(&ends[1], 99U, SMALL));
}

static void an_exactly_full_window_fits_the_inbox_of_a_board(void)
{
    for (unsigned i = 0U; i < 3U; i++) {
        fill_exactly(0U);
        TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 99U, sizeof(uint32_t)));
        TEST_ASSERT_EQUAL(sizeof slots[1].octets, channel(1U)->inbox.blocks.used);
        expect_numbers(1U, MESSAGE_WINDOW);
        message_take_control(&ends[0]);
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, message_credit(&ends[0], id(1U)));
        TEST_ASSERT_EQUAL_UINT32(0U, channel(0U)->position.under_way);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, ends[1].counters.overruns + ends[1].counters.lost + ends[0].counters.syncs);
    TEST_ASSERT_EQUAL_UINT32(3U, ends[0].counters.no_credit);
}

// ---- Numbers beyond 2^32 ----

static void resume_both_at(const uint32_t number)
{
    for (unsigned i = 0U; i < 2U; i++) {
        const message_position_t position = {.peer_life    = 1U,
                                             .sent         = number,
                                             .credited     = number,
                                             .expected     = number,
                                             .taken        = number,
                                             .acknowledged = number,
                                             .peer         = id(1U - i)};
        message_resume(&ends[i], &position);
    }
}

/// Blocks of random sizes in both directions, taken at random times: each arrives once, and none of the
/// inboxes overflows.
static void exchange_at_random(const uint32_t steps)
{
    uint32_t sent[2] = {0U, 0U};
    uint32_t next[2] = {0U, 0U};
    for (uint32_t step = 0U; step < steps; step++) {
        const unsigned who = draw(2U);
        const size_t size  = (draw(3U) == 0U) ? MESSAGE_PAYLOAD_MAX : (sizeof(uint32_t) + draw(300U));
        if (draw(5U) < 3U) {
            sent[who] += (send_number(who, sent[who], size) == STATUS_OK) ? 1U : 0U;
        } else {
            const uint32_t number = take_number(who);
            if (number != NO_NUMBER) {
                TEST_ASSERT_EQUAL_UINT32(next[who], number);
                next[who]++;
            }
        }
        TEST_ASSERT_TRUE(channel(who)->position.under_way <= SMALL);
        TEST_ASSERT_TRUE(message_position_is_sound(&channel(who)->position));
    }
    for (unsigned i = 0U; i < 2U; i++) {
        next[i] += take_all(i);
    }
    TEST_ASSERT_EQUAL_UINT32(sent[0], next[1]);
    TEST_ASSERT_EQUAL_UINT32(sent[1], next[0]);
    TEST_ASSERT_TRUE((sent[0] > 100U) && (sent[1] > 100U));
}

static void numbers_wrap_without_a_loss(void)
{
    resume_both_at(UINT32_MAX - 60U);
    exchange_at_random(3000U);
    TEST_ASSERT_TRUE((channel(0U)->position.sent < 10000U) && (channel(1U)->position.sent < 10000U));
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_UINT32(0U,
                                 ends[i].counters.lost + ends[i].counters.overruns + ends[i].counters.stale);
        TEST_ASSERT_EQUAL_UINT32(ends[1U - i].counters.sent, ends[i].counters.received);
    }
}

static void a_full_window_across_the_wrap_is_credited(void)
{
    for (uint32_t before = 0U; before <= MESSAGE_WINDOW; before++) {
        resume_both_at(UINT32_MAX - before + 1U);
        fill_exactly(0U);
        expect_numbers(1U, MESSAGE_WINDOW);
        message_take_control(&ends[0]);
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, message_credit(&ends[0], id(1U)));
    }
}

// ---- Hostile frames ----

static void forge(const unsigned from, const uint8_t kind, const uint32_t sequence, const uint32_t taken)
{
    uint8_t frame[MESSAGE_HEADER_OCTETS];
    const message_frame_t header = {.kind      = kind,
                                    .from      = id(from),
                                    .to        = id(1U - from),
                                    .from_life = 1U,
                                    .to_life   = 1U,
                                    .sequence  = sequence,
                                    .taken     = taken};
    message_frame_write(&header, frame);
    TEST_ASSERT_EQUAL(STATUS_OK, message_deliver(&ends[1U - from], frame, sizeof frame));
    message_take_control(&ends[1U - from]);
}

/// Credit for blocks that were never sent, or were credited before, opens no window.
static void impossible_credit_does_not_open_a_full_window(void)
{
    static const uint32_t claims[] = {MESSAGE_WINDOW + 1U, MESSAGE_WINDOW + 2U, 2U * MESSAGE_WINDOW,
                                      0x7FFFFFFFU,         0x80000000U,         UINT32_MAX - MESSAGE_WINDOW,
                                      UINT32_MAX};
    fill_exactly(0U);
    for (size_t i = 0U; i < (sizeof claims / sizeof claims[0]); i++) {
        forge(1U, MESSAGE_CREDIT, 0U, claims[i]);
        TEST_ASSERT_EQUAL_UINT32(SMALL, channel(0U)->position.under_way);
        TEST_ASSERT_EQUAL(STATUS_FULL, send_number(0U, 99U, sizeof(uint32_t)));
    }
    expect_numbers(1U, MESSAGE_WINDOW);
    message_take_control(&ends[0]);
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, message_credit(&ends[0], id(1U)));
    TEST_ASSERT_EQUAL_UINT32(0U, ends[1].counters.lost + ends[1].counters.overruns);
}

/// Any numbers in a frame of any kind: the sender never has more blocks on their way than a window, and
/// recovers by itself when the honest peer answers.
static void forged_numbers_close_a_window_for_a_short_time_at_most(void)
{
    for (unsigned round = 0U; round < 300U; round++) {
        const uint32_t sent = channel(0U)->position.sent;
        const uint8_t kind  = (uint8_t)(MESSAGE_CREDIT + draw(3U));
        const uint32_t taken =
            (draw(2U) == 0U) ? (sent - draw(2U * MESSAGE_WINDOW)) : (draw(0x10000U) * draw(0x10000U));
        (void)send_number(0U, round, 500U);
        forge(1U, kind, (draw(2U) == 0U) ? channel(0U)->position.expected : draw(0x1000000U), taken);
        TEST_ASSERT_TRUE((channel(0U)->position.sent - channel(0U)->position.credited) <= MESSAGE_WINDOW);
        unsigned attempts = 0U; // The sender sends a SYNC at refusals 4, 8, 16 and so on.
        do {
            (void)take_all(1U);
            (void)take_all(0U);
            attempts++;
        } while ((send_number(0U, round, sizeof(uint32_t)) != STATUS_OK) && (attempts < 64U));
        TEST_ASSERT_TRUE(attempts < 64U);
        TEST_ASSERT_TRUE(message_is_consistent(&ends[0]) && message_is_consistent(&ends[1]));
    }
}

static void frames_of_impossible_sizes_are_counted_and_use_no_room(void)
{
    static uint8_t frame[MESSAGE_FRAME_MAX + 1U];
    const message_frame_t header = {
        .kind = MESSAGE_DATA, .from = id(0U), .to = id(1U), .from_life = 1U, .to_life = 1U};
    message_frame_write(&header, frame);
    for (size_t size = 0U; size < MESSAGE_HEADER_OCTETS; size++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_deliver(&ends[1], frame, size));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, message_deliver(&ends[1], frame, sizeof frame));
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_HEADER_OCTETS + 1U, ends[1].counters.malformed);
    TEST_ASSERT_EQUAL(0U, channel(1U)->inbox.blocks.used);
    TEST_ASSERT_EQUAL_UINT32(NO_NUMBER, take_number(1U));
    fill_exactly(0U);
    expect_numbers(1U, MESSAGE_WINDOW);
}

/// A sender that ignores its window fills only its own inbox, and each frame that has no room is counted.
static void frames_beyond_the_window_are_counted(void)
{
    static uint8_t frame[MESSAGE_FRAME_MAX];
    fill_exactly(0U);
    const message_frame_t header = {.kind      = MESSAGE_DATA,
                                    .from      = id(0U),
                                    .to        = id(1U),
                                    .from_life = 1U,
                                    .to_life   = 1U,
                                    .sequence  = MESSAGE_WINDOW};
    message_frame_write(&header, frame);
    for (uint32_t i = 1U; i <= 50U; i++) {
        const size_t size = MESSAGE_HEADER_OCTETS + draw(MESSAGE_PAYLOAD_MAX);
        TEST_ASSERT_EQUAL(STATUS_FULL, message_deliver(&ends[1], frame, size));
        TEST_ASSERT_EQUAL_UINT32(i, ends[1].counters.overruns);
    }
    expect_numbers(1U, MESSAGE_WINDOW);
    message_take_control(&ends[0]);
    fill_exactly(0U);
    expect_numbers(1U, MESSAGE_WINDOW);
}

// ---- Losses ----

/// Frames are lost in both directions at random: what was sent was received, or is counted as lost.
static void every_lost_block_is_counted_once(void)
{
    for (unsigned round = 0U; round < 400U; round++) {
        is_losing_data = (draw(3U) == 0U);
        for (unsigned i = 0U; i < draw(40U); i++) {
            (void)send_number(draw(2U), i, sizeof(uint32_t) + draw(MESSAGE_PAYLOAD_MAX - sizeof(uint32_t)));
        }
        is_losing_data = false;
        (void)take_all(draw(2U));
    }
    for (unsigned i = 0U; i < 2U; i++) {
        message_probe(&ends[i], id(1U - i));
        (void)take_all(1U - i);
        (void)take_all(i);
    }
    TEST_ASSERT_TRUE(lost_data > 100U);
    TEST_ASSERT_EQUAL_UINT32(lost_data, ends[0].counters.lost + ends[1].counters.lost);
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_UINT32(ends[1U - i].counters.sent,
                                 ends[i].counters.received + ends[i].counters.lost);
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, message_credit(&ends[i], id(1U - i)));
        TEST_ASSERT_EQUAL_UINT32(0U, ends[i].counters.overruns + ends[i].counters.malformed);
    }
}

// ---- Deaths ----

static void a_new_life_of_the_receiver_has_an_empty_window_of_the_same_size(void)
{
    fill_exactly(0U);
    start(1U, 2U);
    message_set_life(&ends[0], id(1U), 2U);
    message_set_life(&ends[1], id(0U), 1U);
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, ends[0].counters.abandoned);
    TEST_ASSERT_EQUAL_UINT32(SMALL, channel(0U)->window);
    fill_exactly(0U);
    expect_numbers(1U, MESSAGE_WINDOW);
    TEST_ASSERT_EQUAL_UINT32(0U, ends[1].counters.lost + ends[1].counters.overruns + ends[1].counters.stale);
}

/// The window that the dead sender had filled waits in the inbox: the frames of the next life replace it.
static void a_full_window_of_a_dead_sender_makes_room(void)
{
    fill_exactly(0U);
    start(0U, 2U);
    fill_exactly(0U);
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, ends[1].counters.stale);
    expect_numbers(1U, MESSAGE_WINDOW);
    TEST_ASSERT_EQUAL_UINT32(0U, ends[1].counters.lost + ends[1].counters.overruns);
}

/// Both die with full windows; all frames of the earlier lives come late, when the next lives have begun.
static void late_frames_of_ended_lives_use_no_window_of_the_next_lives(void)
{
    is_keeping = true;
    fill_exactly(0U);
    fill_exactly(1U);
    TEST_ASSERT_EQUAL(2U * MESSAGE_WINDOW, kept_count);
    is_keeping = false;
    for (unsigned i = 0U; i < 2U; i++) {
        start(i, 2U + i);
        message_set_life(&ends[i], id(1U - i), 3U - i);
    }
    for (size_t i = 0U; i < kept_count; i++) {
        const unsigned to = (i < MESSAGE_WINDOW) ? 1U : 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, message_deliver(&ends[to], kept[i].octets, kept[i].size));
        if ((i % MESSAGE_WINDOW) == 0U) {
            TEST_ASSERT_EQUAL_UINT32(NO_NUMBER, take_number(to));
        }
    }
    for (unsigned i = 0U; i < 2U; i++) {
        fill_exactly(i);
        expect_numbers(1U - i, MESSAGE_WINDOW);
        TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW, ends[1U - i].counters.stale);
        TEST_ASSERT_EQUAL_UINT32(0U, ends[1U - i].counters.lost + ends[1U - i].counters.overruns);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(credit_ends_at_the_exact_octet);
    RUN_TEST(credit_ends_at_the_exact_block_for_all_numbers);
    RUN_TEST(a_sender_that_waits_for_less_than_the_interval_can_send);
    RUN_TEST(an_end_grants_no_more_than_its_inbox_holds);
    RUN_TEST(an_exactly_full_window_fits_the_inbox_of_a_board);
    RUN_TEST(numbers_wrap_without_a_loss);
    RUN_TEST(a_full_window_across_the_wrap_is_credited);
    RUN_TEST(impossible_credit_does_not_open_a_full_window);
    RUN_TEST(forged_numbers_close_a_window_for_a_short_time_at_most);
    RUN_TEST(frames_of_impossible_sizes_are_counted_and_use_no_room);
    RUN_TEST(frames_beyond_the_window_are_counted);
    RUN_TEST(every_lost_block_is_counted_once);
    RUN_TEST(a_new_life_of_the_receiver_has_an_empty_window_of_the_same_size);
    RUN_TEST(a_full_window_of_a_dead_sender_makes_room);
    RUN_TEST(late_frames_of_ended_lives_use_no_window_of_the_next_lives);
    return UNITY_END();
}
