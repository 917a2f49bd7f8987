// SPDX-License-Identifier: Apache-2.0
// Compares the agreement, for a third of the pairs of offers from small sets of terms, with an independent
// formulation of the rules in the header.
#include "fsw/framework/rtlink/agreement.h"

#include "unity.h"

#include <stdbool.h>
#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static const rtlink_terms_t plain = {.layout_hash   = 0x12345678U,
                                     .layout_octets = 32U,
                                     .order         = RTLINK_LITTLE_ENDIAN,
                                     .period_us     = 500U,
                                     .methods       = 0x5U,
                                     .decimation    = 1U,
                                     .max_age_us    = 2000U};

#define HASHES 2U
#define SIZES 5U
#define ORDERS 3U
#define PERIODS 6U
#define METHODS 16U
#define OFFERS (HASHES * SIZES * ORDERS * PERIODS * METHODS)

/// Offer number n of all combinations of terms.
static rtlink_terms_t offer(uint32_t n)
{
    static const uint32_t sizes[SIZES]     = {0U, 1U, 32U, 1024U, 1025U};
    static const uint32_t periods[PERIODS] = {0U, 1U, 500U, 1000U, 1250U, 2000U};
    rtlink_terms_t terms                   = {0};
    terms.layout_hash                      = n % HASHES;
    n /= HASHES;
    terms.layout_octets = sizes[n % SIZES];
    n /= SIZES;
    terms.order = (uint8_t)(n % ORDERS);
    n /= ORDERS;
    terms.period_us = periods[n % PERIODS];
    n /= PERIODS;
    terms.methods    = (uint8_t)(n % METHODS);
    terms.max_age_us = 1000U + terms.period_us;
    terms.decimation = 77U; // The decimation has no meaning in an offer.
    return terms;
}

// Row and column are the two periods; 1 if the column's period is a multiple of the row's.
static const uint8_t is_multiple[PERIODS][PERIODS] = {
    {0U, 0U, 0U, 0U, 0U, 0U}, {0U, 1U, 1U, 1U, 1U, 1U}, {0U, 0U, 1U, 1U, 0U, 1U},
    {0U, 0U, 0U, 1U, 0U, 1U}, {0U, 0U, 0U, 0U, 1U, 0U}, {0U, 0U, 0U, 0U, 0U, 1U},
};

static uint32_t period_index(uint32_t n)
{
    return (n / (HASHES * SIZES * ORDERS)) % PERIODS;
}

static rtlink_verdict_t expected_verdict(uint32_t producer_number, uint32_t consumer_number)
{
    const rtlink_terms_t producer = offer(producer_number);
    const rtlink_terms_t consumer = offer(consumer_number);
    if ((producer.layout_hash != consumer.layout_hash) ||
        (producer.layout_octets != consumer.layout_octets) || (producer.layout_octets < 1U) ||
        (producer.layout_octets > 1024U)) {
        return RTLINK_REFUSED_LAYOUT;
    }
    if ((producer.order != 0U) && (producer.order != 1U)) {
        return RTLINK_REFUSED_ORDER;
    }
    if ((is_multiple[period_index(producer_number)][period_index(consumer_number)] == 0U) &&
        (is_multiple[period_index(consumer_number)][period_index(producer_number)] == 0U)) {
        return RTLINK_REFUSED_PERIOD;
    }
    return ((producer.methods & consumer.methods & 0x7U) == 0U) ? RTLINK_REFUSED_METHOD : RTLINK_ACCEPTED;
}

static void check_agreed(const rtlink_terms_t* producer, const rtlink_terms_t* consumer,
                         const rtlink_terms_t* agreed)
{
    TEST_ASSERT_EQUAL(producer->layout_hash, agreed->layout_hash);
    TEST_ASSERT_EQUAL(producer->layout_octets, agreed->layout_octets);
    TEST_ASSERT_EQUAL(producer->order, agreed->order);
    TEST_ASSERT_EQUAL(producer->period_us, agreed->period_us);
    TEST_ASSERT_EQUAL(consumer->max_age_us, agreed->max_age_us);
}

static void pairs_of_offers_are_accepted_or_refused_by_the_rules(void)
{
    static rtlink_terms_t offers[OFFERS];
    unsigned seen[RTLINK_REFUSED_PORT + 1U] = {0U};
    for (uint32_t i = 0U; i < OFFERS; i++) {
        offers[i] = offer(i);
    }
    for (uint32_t i = 0U; i < OFFERS; i++) {
        // One third of the pairs, with all rows and columns.
        for (uint32_t k = (i * 7U) % 3U; k < OFFERS; k += 3U) {
            rtlink_terms_t agreed          = {0};
            const rtlink_verdict_t verdict = rtlink_negotiate(&offers[i], &offers[k], &agreed);
            seen[verdict]++;
            const rtlink_verdict_t expected = expected_verdict(i, k);
            if (verdict != expected) {
                TEST_ASSERT_EQUAL(expected, verdict);
            }
            if (verdict == RTLINK_ACCEPTED) {
                check_agreed(&offers[i], &offers[k], &agreed);
                const unsigned common = offers[i].methods & offers[k].methods & 0x7U;
                TEST_ASSERT_TRUE((agreed.methods == 1U) || (agreed.methods == 2U) || (agreed.methods == 4U));
                TEST_ASSERT_TRUE((agreed.methods & common) != 0U);
                TEST_ASSERT_EQUAL(0U, common & (agreed.methods - 1U));
                const bool is_slower = (offers[k].period_us > offers[i].period_us);
                TEST_ASSERT_EQUAL(is_slower ? (offers[k].period_us / offers[i].period_us) : 1U,
                                  agreed.decimation);
            }
        }
    }
    for (unsigned verdict = RTLINK_ACCEPTED; verdict <= RTLINK_REFUSED_METHOD; verdict++) {
        TEST_ASSERT_TRUE(seen[verdict] > 0U);
    }
}

static void a_refusal_names_the_acceptable_value(void)
{
    rtlink_terms_t wanted   = plain;
    rtlink_terms_t reported = {0};
    wanted.layout_hash++;
    wanted.methods    = 0x2U;
    wanted.period_us  = 700U;
    wanted.max_age_us = 9U;
    TEST_ASSERT_EQUAL(RTLINK_REFUSED_LAYOUT, rtlink_negotiate(&plain, &wanted, &reported));
    TEST_ASSERT_EQUAL(plain.layout_hash, reported.layout_hash);
    TEST_ASSERT_EQUAL(plain.period_us, reported.period_us);
    TEST_ASSERT_EQUAL(plain.methods, reported.methods);
    wanted.layout_hash = plain.layout_hash;
    TEST_ASSERT_EQUAL(RTLINK_REFUSED_PERIOD, rtlink_negotiate(&plain, &wanted, &reported));
    wanted.period_us = reported.period_us;
    TEST_ASSERT_EQUAL(RTLINK_REFUSED_METHOD, rtlink_negotiate(&plain, &wanted, &reported));
    wanted.methods = reported.methods;
    TEST_ASSERT_EQUAL(RTLINK_ACCEPTED, rtlink_negotiate(&plain, &wanted, &reported));
}

static void the_native_byte_order_is_that_of_the_machine(void)
{
    const uint32_t number = 0x01020304U;
    uint8_t octets[4];
    (void)memcpy(octets, &number, sizeof octets);
    TEST_ASSERT_EQUAL((octets[0] == 4U) ? RTLINK_LITTLE_ENDIAN : RTLINK_BIG_ENDIAN, rtlink_native_order());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(pairs_of_offers_are_accepted_or_refused_by_the_rules);
    RUN_TEST(a_refusal_names_the_acceptable_value);
    RUN_TEST(the_native_byte_order_is_that_of_the_machine);
    return UNITY_END();
}
