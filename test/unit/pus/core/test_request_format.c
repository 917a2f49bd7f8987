// SPDX-License-Identifier: Apache-2.0
// The interpreter of request formats, with the generated formats of requests. The suffix of a format is the
// service and the subtype of its request.
#include "pus/core/request_format.h"

#include "generated/pus/st11_request_formats.h"
#include "generated/pus/st12_request_formats.h"
#include "generated/pus/st14_request_formats.h"
#include "generated/pus/st18_request_formats.h"
#include "generated/pus/st23_request_formats.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static bool has_format(const uint8_t* const program, const uint8_t* const octets, const size_t size)
{
    octet_reader_t reader = octet_reader(octets, size);
    return pus_request_format_check(program, &reader) && octet_reader_is_done(&reader);
}

/// The complete request is accepted; a truncated request and one with an additional octet are refused.
static void expect_exact(const uint8_t* const program, const uint8_t* const octets, const size_t size)
{
    uint8_t longer[256] = {0};
    TEST_ASSERT_TRUE(size < sizeof longer);
    memcpy(longer, octets, size);
    TEST_ASSERT_TRUE(has_format(program, longer, size));
    TEST_ASSERT_FALSE(has_format(program, longer, size + 1U));
    for (size_t i = 0U; i < size; i++) {
        TEST_ASSERT_FALSE_MESSAGE(has_format(program, octets, i), "an incomplete request was accepted");
    }
}
#define EXPECT_EXACT(program, ...)                                                                           \
    expect_exact(program, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))
#define EXPECT_WRONG(program, ...)                                                                           \
    TEST_ASSERT_FALSE(                                                                                       \
        has_format(program, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__})))

static void a_format_without_fields_accepts_no_octets(void)
{
    TEST_ASSERT_TRUE(has_format(PUS_REQUEST_FORMAT_11_1, NULL, 0U));
    EXPECT_WRONG(PUS_REQUEST_FORMAT_11_1, 0U);
}

static void counts_repeat_their_groups(void)
{
    EXPECT_EXACT(PUS_REQUEST_FORMAT_12_1, 1U, 0U, 7U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_12_1, 3U, 0U, 7U, 0U, 8U, 0U, 9U);
    EXPECT_WRONG(PUS_REQUEST_FORMAT_12_1, 0U); // The count must be at least one.
    EXPECT_WRONG(PUS_REQUEST_FORMAT_12_1, 0U, 0U, 7U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_12_8, 0U); // A count of zero selects all.
    EXPECT_EXACT(PUS_REQUEST_FORMAT_12_8, 2U, 0U, 1U, 0U, 2U);
}

static void counts_may_be_nested(void)
{
    EXPECT_EXACT(PUS_REQUEST_FORMAT_14_1, 1U, 0U, 16U, 0U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_14_1, 2U, 0U, 16U, 2U, 3U, 2U, 25U, 26U, 5U, 0U, 0U, 17U, 1U, 1U, 1U, 7U);
    EXPECT_WRONG(PUS_REQUEST_FORMAT_14_1, 0U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_14_2, 0U);
}

static void selectors_choose_the_fields_that_follow(void)
{
    EXPECT_EXACT(PUS_REQUEST_FORMAT_11_11, 0U, 0U, 0U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_11_11, 2U, 0x1FU, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 1U, 9U, 0U);
    EXPECT_EXACT(PUS_REQUEST_FORMAT_11_11, 1U, 0x1FU, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 0x1FU, 1U, 2U, 3U, 4U, 5U,
                 6U, 7U, 0U, 2U, 1U, 2U);
    EXPECT_WRONG(PUS_REQUEST_FORMAT_11_11, 4U, 0U, 0U);
}

/// Check that reading stops at octet `at` of the request.
static void expect_stop(const uint8_t* const program, const uint8_t* const octets, const size_t size,
                        const size_t at)
{
    octet_reader_t reader = octet_reader(octets, size);
    TEST_ASSERT_FALSE(pus_request_format_check(program, &reader));
    TEST_ASSERT_EQUAL_UINT64(at, reader.position);
}

static void reading_stops_at_the_wrong_or_missing_octet(void)
{
    static const uint8_t parts[]    = {1U, 0U, 16U, 1U, 3U, 0U}; // One application process, service, subtype.
    static const uint8_t selector[] = {4U, 0U, 0U};
    static const uint8_t layout[]   = {'A', 'B', 0U, 0U, 0U, 0U, 0U, 0U, 1U, 11U, 0U, 5U};
    static const uint8_t list[]     = {0U};
    uint8_t nested[64]              = {1U, 1U, 0U, 0x1FU};
    expect_stop(PUS_REQUEST_FORMAT_12_1, list, sizeof list, 0U); // The count must be at least one.
    expect_stop(PUS_REQUEST_FORMAT_12_1, list, 0U, 0U);
    expect_stop(PUS_REQUEST_FORMAT_14_1, parts, sizeof parts - 1U, sizeof parts - 1U); // The inner count.
    expect_stop(PUS_REQUEST_FORMAT_11_11, selector, sizeof selector, 0U);
    expect_stop(PUS_REQUEST_FORMAT_11_11, selector, 0U, 0U);
    expect_stop(PUS_REQUEST_FORMAT_18_7, layout, sizeof layout, 10U);
    expect_stop(PUS_REQUEST_FORMAT_11_4, nested, sizeof nested, 11U); // A length shorter than any request.
    expect_stop(PUS_REQUEST_FORMAT_11_4, nested, 15U, 11U);           // Less than any request.
}

static void the_id_determines_the_layout_of_a_value(void)
{
    // One definition: UINT16 validity, DOUBLE monitored, each check type in turn.
    const uint8_t head[] = {1U,    0U,    1U, 2U, 9U, 0U, 3U, 2U, 1U, 0U, 2U,
                            0xFFU, 0xFFU, 0U, 1U, 0U, 0U, 0U, 1U, 0U, 1U};
    for (uint8_t type = 0U; type <= 2U; type++) {
        uint8_t octets[64] = {0};
        memcpy(octets, head, sizeof head);
        octets[sizeof head] = type;
        const size_t size   = sizeof head + 1U + ((type == 0U) ? 18U : ((type == 1U) ? 20U : 22U));
        expect_exact(PUS_REQUEST_FORMAT_12_5, octets, size);
    }
    EXPECT_WRONG(PUS_REQUEST_FORMAT_12_5, 1U, 0U, 1U, 2U, 9U, 0U, 3U, 2U, 24U, 0U, 2U, 0U, 0U, 0U, 0U,
                 0U); // Structures have no scalar value.
    EXPECT_EXACT(PUS_REQUEST_FORMAT_18_7, 'A', 'B', 0U, 0U, 0U, 0U, 0U, 0U, 2U, 1U, 0U, 5U, 10U, 1U);
    EXPECT_WRONG(PUS_REQUEST_FORMAT_18_7, 'A', 'B', 0U, 0U, 0U, 0U, 0U, 0U, 1U, 11U, 0U, 5U);
}

static void texts_begin_with_their_length(void)
{
    EXPECT_EXACT(PUS_REQUEST_FORMAT_23_2, 0U, 1U, '/', 0U, 2U, 'a', 'b');
    EXPECT_EXACT(PUS_REQUEST_FORMAT_23_2, 0U, 0U, 0U, 0U);
}

static void nested_requests_begin_with_their_length(void)
{
    const uint8_t request[] = {0x18U, 16U, 0xC0U, 0U, 0U, 6U, 0x2FU, 17U, 1U, 0U, 1U, 0xAAU, 0xBBU};
    uint8_t octets[64]      = {1U, 1U, 0U, 0x1FU};
    memcpy(&octets[11], request, sizeof request);
    expect_exact(PUS_REQUEST_FORMAT_11_4, octets, 11U + sizeof request);
    octets[11 + 5] = 5U; // A length shorter than any request.
    TEST_ASSERT_FALSE(has_format(PUS_REQUEST_FORMAT_11_4, octets, 11U + sizeof request));
    octets[11 + 4] = 0xFFU; // A length longer than any request.
    TEST_ASSERT_FALSE(has_format(PUS_REQUEST_FORMAT_11_4, octets, sizeof octets));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_format_without_fields_accepts_no_octets);
    RUN_TEST(counts_repeat_their_groups);
    RUN_TEST(counts_may_be_nested);
    RUN_TEST(selectors_choose_the_fields_that_follow);
    RUN_TEST(reading_stops_at_the_wrong_or_missing_octet);
    RUN_TEST(the_id_determines_the_layout_of_a_value);
    RUN_TEST(texts_begin_with_their_length);
    RUN_TEST(nested_requests_begin_with_their_length);
    return UNITY_END();
}
