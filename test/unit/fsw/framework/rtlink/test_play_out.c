// SPDX-License-Identifier: Apache-2.0
// The play-out buffer of a link whose frames have different delays, as its reader uses it.
#include "fsw/framework/rtlink/link_channel.h"

#include "test/unit/fsw/framework/rtlink/links.h"
#include "unity.h"

#include <string.h>

#define LINK 1U
#define OCTETS 20U
#define EPOCH 5U
#define US 1000ULL
#define MS 1000000ULL
#define DELAY_US 10000U
#define BUDGET_US 1000U
#define PLAY_NS (11U * MS)
#define PERIOD_NS (500U * US)

static rtlink_consumer_t consumer;
static rtlink_play_out_t buffer;
static status_t buffer_status;
static bool has_buffer;

static status_t find_buffer(void* context, uint16_t link, rtlink_play_out_t** out_buffer)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT(LINK, link);
    if (has_buffer && (buffer_status == STATUS_OK)) {
        *out_buffer = &buffer;
    }
    return buffer_status;
}

static void open_with(uint32_t octets, uint32_t epoch)
{
    rtlink_resolver_t resolver = links;
    resolver.play_out          = find_buffer;
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_UDP, octets);
    TEST_ASSERT_EQUAL(buffer_status, rtlink_consumer_open(&consumer, &resolver, LINK, &terms, epoch));
}

void setUp(void)
{
    buffer_status    = STATUS_OK;
    has_buffer       = true;
    buffer.delay_us  = DELAY_US;
    buffer.budget_us = BUDGET_US;
    open_with(OCTETS, EPOCH);
}

void tearDown(void)
{
    rtlink_consumer_close(&consumer);
}

static status_t arrive_in(uint32_t epoch, uint32_t sequence, uint64_t time_ns)
{
    uint8_t payload[RTLINK_PAYLOAD_MAX];
    uint8_t frame[LINK_FRAME_MAX];
    const rtlink_frame_header_t header = {.producer_state = (uint8_t)(sequence % 10U),
                                          .link           = LINK,
                                          .epoch          = epoch,
                                          .sequence       = sequence,
                                          .time_ns        = time_ns};
    (void)memset(payload, (int)(sequence & 0xFFU), sizeof payload);
    const size_t size = rtlink_frame_encode(&header, payload, consumer.terms.layout_octets, true, frame);
    return rtlink_consumer_deliver(&consumer, frame, size);
}

/// A sample arrives; samples are sent once in each period, from time 0.
static void arrive(uint32_t sequence)
{
    TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH, sequence, sequence * PERIOD_NS));
}

static void expect(uint32_t sequence, uint64_t now_ns)
{
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(&consumer, now_ns));
    for (size_t i = 0U; i < consumer.terms.layout_octets; i++) {
        TEST_ASSERT_EQUAL_HEX8(sequence & 0xFFU, consumer.payload[i]);
    }
    TEST_ASSERT_EQUAL_UINT32(sequence, consumer.sequence);
    TEST_ASSERT_EQUAL(sequence % 10U, consumer.peer_state);
}

static void a_sample_is_read_at_its_play_out_time_and_not_before(void)
{
    arrive(0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, PLAY_NS - 1U));
    TEST_ASSERT_FALSE(consumer.has_sample);
    expect(0U, PLAY_NS);
    arrive(1U);
    expect(0U, PLAY_NS + PERIOD_NS - 1U);
    expect(1U, PLAY_NS + PERIOD_NS);
    TEST_ASSERT_EQUAL_UINT32(2U, consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
}

static void a_sample_from_the_far_future_is_not_read(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH, 0U, UINT64_MAX - MS));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, 0U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, UINT64_MAX));
}

static void reordered_and_duplicated_samples_are_read_once_in_their_order(void)
{
    static const uint32_t arrivals[] = {2U, 0U, 2U, 3U, 1U, 0U, 4U, 3U};
    for (size_t i = 0U; i < (sizeof arrivals / sizeof arrivals[0]); i++) {
        arrive(arrivals[i]);
    }
    for (uint32_t sequence = 0U; sequence < 5U; sequence++) {
        expect(sequence, PLAY_NS + (sequence * PERIOD_NS));
    }
    TEST_ASSERT_EQUAL_UINT32(5U, consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost + consumer.counters.refused);
}

/// Put a sample of time 0 into the buffer.
static void put(uint32_t sequence)
{
    static const uint8_t payload[OCTETS] = {0U};
    const rtlink_frame_header_t header   = {.sequence = sequence};
    rtlink_play_out_put(&buffer, &header, payload);
}

/// Returns the sequence number of the next sample that is due.
static uint32_t next_due(void)
{
    rtlink_frame_header_t header = {.sequence = 0U};
    const uint8_t* payload       = NULL;
    TEST_ASSERT_TRUE(rtlink_play_out_take(&buffer, PLAY_NS, &header, &payload));
    return header.sequence;
}

static void expect_nothing_due(void)
{
    rtlink_frame_header_t header;
    const uint8_t* payload = NULL;
    TEST_ASSERT_FALSE(rtlink_play_out_take(&buffer, PLAY_NS, &header, &payload));
}

/// The buffer keeps one copy of each sample.
static void a_duplicated_sample_takes_no_slot(void)
{
    for (uint32_t round = 0U; round < 2U; round++) {
        for (uint32_t sequence = 0U; sequence < 3U; sequence++) {
            put(sequence);
        }
    }
    for (uint32_t sequence = 0U; sequence < 3U; sequence++) {
        TEST_ASSERT_EQUAL_UINT32(sequence, next_due());
    }
    expect_nothing_due();
}

/// Half of the sequence numbers are ahead of any number, the other half behind it.
static void samples_that_lie_far_apart_are_in_order(void)
{
    static const uint32_t distances[] = {1U, 0x60000000U, 0x7FFFFFFFU};
    for (size_t i = 0U; i < (sizeof distances / sizeof distances[0]); i++) {
        put(5U);
        put(5U + distances[i]);
        TEST_ASSERT_EQUAL_UINT32(5U, next_due());
        TEST_ASSERT_EQUAL_UINT32(5U + distances[i], next_due());
        put(5U + distances[i]);
        put(5U);
        TEST_ASSERT_EQUAL_UINT32(5U, next_due());
        TEST_ASSERT_EQUAL_UINT32(5U + distances[i], next_due());
    }
    put(5U);
    put(5U + 0x80000001U);
    TEST_ASSERT_EQUAL_UINT32(5U + 0x80000001U, next_due());
}

static void without_delay_and_budget_a_sample_is_due_at_its_time(void)
{
    buffer.delay_us  = 0U;
    buffer.budget_us = 0U;
    arrive(3U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, (3U * PERIOD_NS) - 1U));
    expect(3U, 3U * PERIOD_NS);
}

static void the_newest_of_several_due_samples_is_read_and_all_are_counted(void)
{
    arrive(3U);
    arrive(0U);
    arrive(1U);
    expect(3U, PLAY_NS + (5U * PERIOD_NS));
    TEST_ASSERT_EQUAL_UINT32(3U, consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(1U, consumer.counters.lost);
}

static void a_lost_sample_is_counted_when_the_next_is_due_and_the_last_is_held(void)
{
    arrive(0U);
    arrive(3U);
    expect(0U, PLAY_NS);
    expect(0U, PLAY_NS + (3U * PERIOD_NS) - 1U);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
    expect(3U, PLAY_NS + (3U * PERIOD_NS));
    TEST_ASSERT_EQUAL_UINT32(2U, consumer.counters.lost);
    arrive(2U); // This sample is late: it was counted as lost and is older than the sample read.
    expect(3U, PLAY_NS + (4U * PERIOD_NS));
    TEST_ASSERT_EQUAL_UINT32(2U, consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(2U, consumer.counters.lost);
}

static void a_late_sample_that_is_the_newest_is_read_at_once(void)
{
    arrive(0U);
    expect(0U, PLAY_NS);
    arrive(1U); // 0.2 ms after its play-out time.
    expect(1U, PLAY_NS + PERIOD_NS + (200U * US));
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
}

/// 3 budgets of 1 ms are more than the agreed 2 ms.
static void a_sample_is_stale_three_budgets_after_its_play_out_time(void)
{
    TEST_ASSERT_EQUAL_UINT64(DELAY_US + (4U * BUDGET_US), rtlink_consumer_max_age_us(&consumer));
    arrive(0U);
    expect(0U, PLAY_NS);
    expect(0U, PLAY_NS + (3U * MS));
    TEST_ASSERT_EQUAL(STATUS_STALE, rtlink_consumer_read(&consumer, PLAY_NS + (3U * MS) + 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, consumer.counters.late);
    arrive(8U);
    expect(8U, PLAY_NS + (8U * PERIOD_NS));
}

/// With a budget of 0.1 ms, the agreed 2 ms are more than three budgets.
static void with_a_small_budget_the_agreed_age_applies(void)
{
    buffer.budget_us = 100U;
    TEST_ASSERT_EQUAL_UINT64(DELAY_US + 100U + 2000U, rtlink_consumer_max_age_us(&consumer));
    arrive(0U);
    expect(0U, (12100U * US));
    TEST_ASSERT_EQUAL(STATUS_STALE, rtlink_consumer_read(&consumer, (12100U * US) + 1U));
}

static void a_link_that_is_opened_again_has_no_earlier_samples(void)
{
    arrive(7U);
    arrive(8U);
    expect(7U, PLAY_NS + (7U * PERIOD_NS));
    rtlink_consumer_close(&consumer);
    open_with(OCTETS, EPOCH + 1U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, 100U * MS));
    // A frame of the earlier epoch was still in transit.
    TEST_ASSERT_EQUAL(STATUS_INVALID, arrive_in(EPOCH, 9U, 9U * PERIOD_NS));
    TEST_ASSERT_EQUAL_UINT32(1U, consumer.counters.refused);
    TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH + 1U, 0U, 100U * MS));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rtlink_consumer_read(&consumer, (100U * MS) + PLAY_NS - 1U));
    expect(0U, (100U * MS) + PLAY_NS);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
}

static void sequence_numbers_wrap_in_the_buffer(void)
{
    static const uint32_t arrivals[] = {1U, UINT32_MAX, 0U, UINT32_MAX - 1U};
    for (size_t i = 0U; i < 4U; i++) {
        const uint32_t periods = arrivals[i] + 2U; // From UINT32_MAX - 1 on: 0, 1, 2, 3.
        TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH, arrivals[i], periods * PERIOD_NS));
    }
    for (uint32_t i = 0U; i < 4U; i++) {
        expect(UINT32_MAX - 1U + i, PLAY_NS + (i * PERIOD_NS));
    }
    TEST_ASSERT_EQUAL_UINT32(4U, consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
}

/// If a producer's times do not increase with the sequence numbers, the reader does not return to an older
/// sample.
static void a_sample_that_was_overtaken_in_the_buffer_is_dropped(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH, 4U, 50U * MS));
    TEST_ASSERT_EQUAL(STATUS_OK, arrive_in(EPOCH, 5U, 0U));
    expect(5U, PLAY_NS);
    (void)rtlink_consumer_read(&consumer, (50U * MS) + PLAY_NS);
    TEST_ASSERT_EQUAL_UINT32(5U, consumer.sequence);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
}

/// Short samples are limited by their number, long ones by their octets; a sample beyond the limit is lost.
static void the_buffer_is_limited_in_samples_and_octets(void)
{
    static const struct {
        uint32_t octets;
        uint32_t room;
    } cases[] = {{1U, 1152U}, {96U, 1152U}, {97U, 1140U}, {RTLINK_PAYLOAD_MAX, 108U}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        rtlink_consumer_close(&consumer);
        open_with(cases[i].octets, EPOCH);
        for (uint32_t sequence = 0U; sequence < (cases[i].room + 3U); sequence++) {
            arrive(sequence);
        }
        for (uint32_t sequence = 0U; sequence < cases[i].room; sequence++) {
            expect(sequence, PLAY_NS + (sequence * PERIOD_NS));
        }
        arrive(cases[i].room + 3U);
        expect(cases[i].room + 3U, PLAY_NS + ((cases[i].room + 3U) * PERIOD_NS));
        TEST_ASSERT_EQUAL_UINT32(3U, consumer.counters.lost);
        TEST_ASSERT_EQUAL_UINT32(cases[i].room + 1U, consumer.counters.frames);
    }
}

/// If simulated time is slower than the network, a sample arrives before its delay has passed. With a full
/// buffer the link would lose all samples of some ten milliseconds, and be stale.
static void samples_that_arrive_before_the_delay_are_held_until_they_are_played(void)
{
    static const struct {
        uint32_t delay_us; // half of --delay 20, 100, 300 and 1000
        uint32_t budget_us;
    } cases[] = {{10000U, 1000U}, {50000U, 5000U}, {150000U, 15000U}, {500000U, 50000U}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        const uint64_t play_ns = (cases[i].delay_us + cases[i].budget_us) * US;
        const uint32_t held    = (uint32_t)(play_ns / PERIOD_NS);
        rtlink_consumer_close(&consumer);
        buffer.delay_us  = cases[i].delay_us;
        buffer.budget_us = cases[i].budget_us;
        open_with(96U, EPOCH); // ROBOT_CONTACT of the mission rokviss
        for (uint32_t sequence = 0U; sequence < (3U * held); sequence++) {
            arrive(sequence);
            if (sequence >= held) {
                expect(sequence - held, sequence * PERIOD_NS);
            }
        }
        TEST_ASSERT_EQUAL_UINT32(0U, consumer.counters.lost);
    }
}

static void a_link_without_buffer_is_read_as_its_samples_arrive(void)
{
    rtlink_consumer_close(&consumer);
    has_buffer = false;
    open_with(OCTETS, EPOCH);
    TEST_ASSERT_EQUAL_UINT64(2000U, rtlink_consumer_max_age_us(&consumer));
    arrive(0U);
    expect(0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_STALE, rtlink_consumer_read(&consumer, (2U * MS) + 1U));
}

static void a_link_whose_buffer_is_missing_is_not_opened(void)
{
    rtlink_consumer_close(&consumer);
    buffer_status = STATUS_EXHAUSTED;
    open_with(OCTETS, EPOCH);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_read(&consumer, 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_sample_is_read_at_its_play_out_time_and_not_before);
    RUN_TEST(a_sample_from_the_far_future_is_not_read);
    RUN_TEST(reordered_and_duplicated_samples_are_read_once_in_their_order);
    RUN_TEST(a_duplicated_sample_takes_no_slot);
    RUN_TEST(samples_that_lie_far_apart_are_in_order);
    RUN_TEST(without_delay_and_budget_a_sample_is_due_at_its_time);
    RUN_TEST(the_newest_of_several_due_samples_is_read_and_all_are_counted);
    RUN_TEST(a_lost_sample_is_counted_when_the_next_is_due_and_the_last_is_held);
    RUN_TEST(a_late_sample_that_is_the_newest_is_read_at_once);
    RUN_TEST(a_sample_is_stale_three_budgets_after_its_play_out_time);
    RUN_TEST(with_a_small_budget_the_agreed_age_applies);
    RUN_TEST(a_link_that_is_opened_again_has_no_earlier_samples);
    RUN_TEST(sequence_numbers_wrap_in_the_buffer);
    RUN_TEST(a_sample_that_was_overtaken_in_the_buffer_is_dropped);
    RUN_TEST(the_buffer_is_limited_in_samples_and_octets);
    RUN_TEST(samples_that_arrive_before_the_delay_are_held_until_they_are_played);
    RUN_TEST(a_link_without_buffer_is_read_as_its_samples_arrive);
    RUN_TEST(a_link_whose_buffer_is_missing_is_not_opened);
    return UNITY_END();
}
