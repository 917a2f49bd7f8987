// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/record.h"

#include "unity.h"

#include <stdbool.h>
#include <string.h>

typedef struct {
    uint8_t octet;
    uint32_t words[2];
    int16_t half;
    bool flag;
    double real;
    float single;
    int64_t large;
} sample_t;

static const flow_record_field_t fields[] = {
    RECORD_FIELD(sample_t, octet, VALUE_UINT8, 1U), RECORD_FIELD(sample_t, words, VALUE_UINT32, 2U),
    RECORD_FIELD(sample_t, half, VALUE_INT16, 1U),  RECORD_FIELD(sample_t, flag, VALUE_BOOL, 1U),
    RECORD_FIELD(sample_t, real, VALUE_DOUBLE, 1U), RECORD_FIELD(sample_t, single, VALUE_FLOAT, 1U),
    RECORD_FIELD(sample_t, large, VALUE_INT64, 1U),
};
static const flow_record_layout_t layout = {fields, sizeof fields / sizeof fields[0]};
static const sample_t sample             = {0x12U, {0x01020304U, 0xFFFEFDFCU}, -2, true, 1.0, -2.0F, -3};

// The expected octets, derived by hand.
static const uint8_t big[]    = {0x12, 1,    2,    3,    4,    0xFF, 0xFE, 0xFD, 0xFC, 0xFF, 0xFE,
                                 1,    0x3F, 0xF0, 0,    0,    0,    0,    0,    0,    0xC0, 0,
                                 0,    0,    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFD};
static const uint8_t little[] = {0x12, 4,    3,    2,    1,    0xFC, 0xFD, 0xFE, 0xFF, 0xFE, 0xFF,
                                 1,    0,    0,    0,    0,    0,    0,    0xF0, 0x3F, 0,    0,
                                 0,    0xC0, 0xFD, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

void setUp(void)
{
}

void tearDown(void)
{
}

static void expect_same(const sample_t* const seen)
{
    TEST_ASSERT_EQUAL_HEX8(sample.octet, seen->octet);
    TEST_ASSERT_EQUAL_HEX32_ARRAY(sample.words, seen->words, 2U);
    TEST_ASSERT_EQUAL_INT16(sample.half, seen->half);
    TEST_ASSERT_TRUE(seen->flag);
    TEST_ASSERT_TRUE(seen->real == sample.real);
    TEST_ASSERT_TRUE(seen->single == sample.single);
    TEST_ASSERT_TRUE(seen->large == sample.large);
}

static void records_have_the_documented_octets_in_both_byte_orders(void)
{
    const struct {
        flow_order_t order;
        const uint8_t* octets;
    } cases[] = {{FLOW_ORDER_BIG, big}, {FLOW_ORDER_LITTLE, little}};
    TEST_ASSERT_EQUAL_UINT64(sizeof big, flow_record_octets(&layout));
    for (size_t i = 0U; i < 2U; i++) {
        uint8_t octets[64];
        size_t size   = 0U;
        sample_t seen = {0};
        TEST_ASSERT_EQUAL(STATUS_OK,
                          flow_record_encode(&layout, cases[i].order, &sample, octets, sizeof octets, &size));
        TEST_ASSERT_EQUAL_UINT64(sizeof big, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].octets, octets, sizeof big);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_record_decode(&layout, cases[i].order, octets, size, &seen));
        expect_same(&seen);
    }
}

static void a_record_is_written_only_if_it_fits(void)
{
    uint8_t octets[sizeof big];
    size_t size = 1U;
    memset(octets, 0xEE, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_FULL,
                      flow_record_encode(&layout, FLOW_ORDER_BIG, &sample, octets, sizeof big - 1U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EACH_EQUAL_HEX8(0xEE, octets, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      flow_record_encode(&layout, FLOW_ORDER_BIG, &sample, octets, sizeof big, &size));
}

static void invalid_octets_change_no_value(void)
{
    uint8_t octets[sizeof big + 1U];
    sample_t seen = sample;
    memcpy(octets, big, sizeof big);
    octets[0] = 0x77U; // A changed value would be detected.
    for (size_t size = 0U; size < sizeof big; size++) {
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, flow_record_decode(&layout, FLOW_ORDER_BIG, octets, size, &seen));
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE,
                      flow_record_decode(&layout, FLOW_ORDER_BIG, octets, sizeof octets, &seen));
    octets[11] = 2U; // The BOOL.
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_record_decode(&layout, FLOW_ORDER_BIG, octets, sizeof big, &seen));
    expect_same(&seen);
}

static void a_layout_without_fields_has_no_octets(void)
{
    const flow_record_layout_t nothing = {NULL, 0U};
    uint8_t octet                      = 0U;
    size_t size                        = 1U;
    TEST_ASSERT_EQUAL_UINT64(0U, flow_record_octets(&nothing));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_record_encode(&nothing, FLOW_ORDER_BIG, &sample, &octet, 0U, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_record_decode(&nothing, FLOW_ORDER_BIG, &octet, 0U, &octet));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(records_have_the_documented_octets_in_both_byte_orders);
    RUN_TEST(a_record_is_written_only_if_it_fits);
    RUN_TEST(invalid_octets_change_no_value);
    RUN_TEST(a_layout_without_fields_has_no_octets);
    return UNITY_END();
}
