// SPDX-License-Identifier: Apache-2.0
// The relay, which delays frames and loses some of them as the seed determines.
#include "sim/relay/relay.h"

#include <string.h>

#include "unity.h"

#define MS 1000000ULL
#define PERIOD_NS 500000ULL

static relay_t relay;
static relay_t other;

void setUp(void)
{
}

void tearDown(void)
{
}

static void begin(relay_t* one, uint64_t seed, uint64_t delay_ns, double jitter, double loss)
{
    const relay_law_t law = {delay_ns, jitter, loss};
    relay_init(one, seed, &law);
}

static void put_number(relay_t* one, unsigned link, uint32_t number, uint64_t now_ns)
{
    relay_take(one, link, (const uint8_t*)&number, sizeof number, now_ns);
}

static uint32_t number_in(const relay_frame_t* frame)
{
    uint32_t number = 0U;
    TEST_ASSERT_EQUAL_UINT(sizeof number, frame->size);
    (void)memcpy(&number, frame->octets, sizeof number);
    return number;
}

static void a_frame_is_delivered_after_the_delay_and_not_before(void)
{
    begin(&relay, 1U, 10U * MS, 0.0, 0.0);
    TEST_ASSERT_EQUAL_UINT64(RELAY_NEVER, relay_next_ns(&relay));
    TEST_ASSERT_NULL(relay_give(&relay, UINT64_MAX - 1U));
    put_number(&relay, 3U, 7U, 5U * MS);
    TEST_ASSERT_EQUAL_UINT64(15U * MS, relay_next_ns(&relay));
    TEST_ASSERT_NULL(relay_give(&relay, (15U * MS) - 1U));
    const relay_frame_t* frame = relay_give(&relay, 15U * MS);
    TEST_ASSERT_NOT_NULL(frame);
    TEST_ASSERT_EQUAL_UINT(3U, frame->link);
    TEST_ASSERT_EQUAL_UINT32(7U, number_in(frame));
    TEST_ASSERT_NULL(relay_give(&relay, UINT64_MAX - 1U));
    TEST_ASSERT_EQUAL_UINT64(1U, relay.counters.delayed);
    TEST_ASSERT_EQUAL_UINT64(0U, relay.counters.lost + relay.counters.reordered);
}

static void frames_due_at_one_instant_keep_their_order(void)
{
    begin(&relay, 1U, 10U * MS, 0.0, 0.0);
    for (uint32_t i = 0U; i < 6U; i++) {
        put_number(&relay, i % 2U, i, 0U);
    }
    for (uint32_t i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL_UINT32(i, number_in(relay_give(&relay, 10U * MS)));
    }
    TEST_ASSERT_EQUAL_UINT64(0U, relay.counters.reordered);
}

/// 100000 frames: each delay is within the bounds; mean delay and share of losses have the configured values.
static void delay_jitter_and_loss_have_the_configured_values(void)
{
    const uint64_t frames = 100000U;
    uint64_t least        = UINT64_MAX;
    uint64_t most         = 0U;
    uint64_t sum          = 0U;
    uint64_t overtaken    = 0U;
    uint32_t latest       = 0U;
    begin(&relay, 2U, 50U * MS, 0.1, 0.05);
    for (uint64_t i = 0U; i <= frames; i++) {
        const uint64_t now_ns = i * PERIOD_NS;
        for (const relay_frame_t* frame = relay_give(&relay, now_ns); frame != NULL;
             frame                      = relay_give(&relay, now_ns)) {
            const uint32_t number   = number_in(frame);
            const uint64_t delay_ns = frame->due_ns - (number * PERIOD_NS);
            least                   = (delay_ns < least) ? delay_ns : least;
            most                    = (delay_ns > most) ? delay_ns : most;
            sum += delay_ns;
            overtaken += (number < latest) ? 1U : 0U;
            latest = (number > latest) ? number : latest;
        }
        // In the last rounds no frame is put in; the relay delivers those that it holds.
        if (i < (frames - 200U)) {
            put_number(&relay, 0U, (uint32_t)i, now_ns);
        }
    }
    TEST_ASSERT_EQUAL_UINT64(frames - 200U, relay.counters.delayed + relay.counters.lost);
    TEST_ASSERT_TRUE((least >= (45U * MS)) && (least < (45010U * 1000U)));
    TEST_ASSERT_TRUE((most <= (55U * MS)) && (most > (54990U * 1000U)));
    TEST_ASSERT_UINT64_WITHIN(30000U, 50U * MS, sum / relay.counters.delayed);
    TEST_ASSERT_UINT64_WITHIN(250U, 4990U, relay.counters.lost);
    TEST_ASSERT_EQUAL_UINT64(overtaken, relay.counters.reordered);
    TEST_ASSERT_GREATER_THAN_UINT64(frames / 2U, relay.counters.reordered);
}

static void delay_and_loss_of_a_frame_depend_on_seed_link_and_number_only(void)
{
    begin(&relay, 3U, 10U * MS, 0.5, 0.3);
    begin(&other, 3U, 10U * MS, 0.5, 0.3);
    for (uint32_t i = 0U; i < 500U; i++) {
        put_number(&relay, 1U, i, i * MS);
        put_number(&other, 1U, i, i * MS);
        put_number(&other, 0U, i, i * MS); // The traffic of another link has no effect.
    }
    const relay_frame_t* theirs = relay_give(&other, 1000U * MS);
    unsigned compared           = 0U;
    for (const relay_frame_t* ours = relay_give(&relay, 1000U * MS); ours != NULL;
         ours                      = relay_give(&relay, 1000U * MS)) {
        while (theirs->link == 0U) {
            theirs = relay_give(&other, 1000U * MS);
            TEST_ASSERT_NOT_NULL(theirs);
        }
        TEST_ASSERT_EQUAL_UINT64(ours->due_ns, theirs->due_ns);
        TEST_ASSERT_EQUAL_UINT32(number_in(ours), number_in(theirs));
        theirs = relay_give(&other, 1000U * MS);
        compared++;
    }
    TEST_ASSERT_EQUAL_UINT64(relay.counters.delayed, compared);
    TEST_ASSERT_TRUE((compared > 300U) && (compared < 400U));
    begin(&relay, 4U, 10U * MS, 0.5, 0.0);
    put_number(&relay, 0U, 0U, 0U);
    put_number(&relay, 1U, 0U, 0U);
    const uint64_t first_ns = relay_give(&relay, 15U * MS)->due_ns;
    TEST_ASSERT_TRUE(first_ns != relay_give(&relay, 15U * MS)->due_ns);
}

static void records_that_do_not_fit_are_lost_and_counted(void)
{
    static uint8_t octets[RELAY_FRAME_MAX + 1U];
    begin(&relay, 1U, 10U * MS, 0.0, 0.0);
    relay_take(&relay, 0U, octets, RELAY_FRAME_MAX + 1U, 0U);
    TEST_ASSERT_EQUAL_UINT64(1U, relay.counters.lost);
    for (uint32_t round = 0U; round < 3U; round++) { // Use each slot of the relay several times.
        for (uint32_t i = 0U; i < RELAY_FRAMES_MAX; i++) {
            relay_take(&relay, 0U, octets, RELAY_FRAME_MAX, round * 20U * MS);
        }
        TEST_ASSERT_EQUAL_UINT64(1U + round, relay.counters.lost);
        relay_take(&relay, 0U, octets, 1U, round * 20U * MS);
        TEST_ASSERT_EQUAL_UINT64(2U + round, relay.counters.lost);
        for (uint32_t i = 0U; i < RELAY_FRAMES_MAX; i++) {
            TEST_ASSERT_EQUAL_UINT(RELAY_FRAME_MAX,
                                   relay_give(&relay, (round * 20U * MS) + (10U * MS))->size);
        }
    }
    TEST_ASSERT_NULL(relay_give(&relay, UINT64_MAX - 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_frame_is_delivered_after_the_delay_and_not_before);
    RUN_TEST(frames_due_at_one_instant_keep_their_order);
    RUN_TEST(delay_jitter_and_loss_have_the_configured_values);
    RUN_TEST(delay_and_loss_of_a_frame_depend_on_seed_link_and_number_only);
    RUN_TEST(records_that_do_not_fit_are_lost_and_counted);
    return UNITY_END();
}
