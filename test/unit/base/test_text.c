// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static char buffer[128];

static text_t new_text(void)
{
    (void)memset(buffer, 'x', sizeof buffer);
    return text_in(buffer, sizeof buffer);
}

static const uint64_t numbers[] = {0U,
                                   1U,
                                   9U,
                                   10U,
                                   99U,
                                   100U,
                                   4294967295U,
                                   4294967296U,
                                   999999999U,
                                   1000000000U,
                                   INT64_MAX,
                                   1ULL << 63U,
                                   UINT64_MAX,
                                   UINT64_MAX / 10U,
                                   12345678901234567890ULL};
#define NUMBERS (sizeof numbers / sizeof numbers[0])

/// printf of the C library is the independent reference of all number formats.
static void unsigned_numbers_are_written_as_by_printf(void)
{
    for (size_t i = 0U; i < NUMBERS; i++) {
        char expected[32];
        (void)snprintf(expected, sizeof expected, "%" PRIu64, numbers[i]);
        text_t text = new_text();
        text_add_unsigned(&text, numbers[i]);
        TEST_ASSERT_EQUAL_STRING(expected, text.characters);
        TEST_ASSERT_EQUAL_UINT64(strlen(expected), text.length);
        TEST_ASSERT_FALSE(text.cut);
    }
}

static void signed_numbers_are_written_as_by_printf(void)
{
    static const int64_t values[] = {0, 1, -1, 42, -42, INT32_MIN, INT64_MAX, INT64_MIN, INT64_MIN + 1};
    for (size_t i = 0U; i < (sizeof values / sizeof values[0]); i++) {
        char expected[32];
        (void)snprintf(expected, sizeof expected, "%" PRId64, values[i]);
        text_t text = new_text();
        text_add_signed(&text, values[i]);
        TEST_ASSERT_EQUAL_STRING(expected, text.characters);
    }
}

static void a_fixed_number_of_digits_is_padded_with_zeros_or_truncated_to_the_lowest(void)
{
    text_t text = new_text();
    text_add_digits(&text, 42U, 5U);
    TEST_ASSERT_EQUAL_STRING("00042", text.characters);
    text = new_text();
    text_add_digits(&text, 123456U, 3U);
    TEST_ASSERT_EQUAL_STRING("456", text.characters);
    text = new_text();
    text_add_digits(&text, 7U, 0U);
    TEST_ASSERT_EQUAL_STRING("", text.characters);
    text = new_text();
    text_add_digits(&text, UINT64_MAX, 20U);
    TEST_ASSERT_EQUAL_STRING("18446744073709551615", text.characters);
}

static void hexadecimal_numbers_are_written_as_by_printf(void)
{
    for (size_t i = 0U; i < NUMBERS; i++) {
        char expected[32];
        (void)snprintf(expected, sizeof expected, "0x%016" PRIX64, numbers[i]);
        text_t text = new_text();
        text_add_hex(&text, numbers[i], 16U);
        TEST_ASSERT_EQUAL_STRING(expected, text.characters);
    }
    text_t text = new_text();
    text_add_hex(&text, 0xABCDEFU, 4U);
    TEST_ASSERT_EQUAL_STRING("0xCDEF", text.characters);
}

static void every_octet_has_two_lower_case_digits(void)
{
    for (unsigned value = 0U; value < 256U; value++) {
        const uint8_t octet = (uint8_t)value;
        char expected[3];
        (void)snprintf(expected, sizeof expected, "%02x", value);
        text_t text = new_text();
        text_add_octets(&text, &octet, 1U);
        TEST_ASSERT_EQUAL_STRING(expected, text.characters);
    }
}

static void seconds_have_nine_decimals(void)
{
    static const struct {
        uint64_t time_ns;
        const char* expected;
    } rows[] = {{0U, "0.000000000"},          {1U, "0.000000001"},
                {999999999U, "0.999999999"},  {1000000000U, "1.000000000"},
                {1500000000U, "1.500000000"}, {UINT64_MAX, "18446744073.709551615"}};
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        text_t text = new_text();
        text_add_seconds(&text, rows[i].time_ns);
        TEST_ASSERT_EQUAL_STRING(rows[i].expected, text.characters);
    }
}

static void parts_are_appended_in_order(void)
{
    static const uint8_t octets[2] = {0xBEU, 0xEFU};
    text_t text                    = new_text();
    text_add(&text, "a ");
    text_add_character(&text, 'b');
    text_add_signed(&text, -7);
    text_add_octets(&text, octets, sizeof octets);
    text_add_octets(&text, NULL, 0U);
    text_add(&text, "");
    TEST_ASSERT_EQUAL_STRING("a b-7beef", text.characters);
}

static void text_that_does_not_fit_is_cut_and_reported(void)
{
    static const char words[] = "0123456789";
    for (size_t capacity = 1U; capacity <= 16U; capacity++) {
        (void)memset(buffer, 'x', sizeof buffer);
        text_t text = text_in(buffer, capacity);
        text_add(&text, words);
        const size_t fits = (capacity - 1U < strlen(words)) ? capacity - 1U : strlen(words);
        TEST_ASSERT_EQUAL_UINT64(fits, text.length);
        TEST_ASSERT_EQUAL_UINT64(fits, strlen(buffer));
        TEST_ASSERT_EQUAL_INT(0, memcmp(words, buffer, fits));
        TEST_ASSERT_EQUAL_INT(fits < strlen(words), text.cut);
        TEST_ASSERT_EQUAL_INT('x', buffer[capacity]);
    }
}

static void a_text_that_was_truncated_remains_marked(void)
{
    text_t text = text_in(buffer, 3U);
    text_add(&text, "abc");
    TEST_ASSERT_TRUE(text.cut);
    text_add(&text, "");
    TEST_ASSERT_TRUE(text.cut);
    TEST_ASSERT_EQUAL_STRING("ab", buffer);
}

static void text_without_room(void)
{
    (void)text_in(buffer, 0U);
}

static void text_of_null(void)
{
    (void)text_in(NULL, 8U);
}

static void more_digits_than_a_number_has(void)
{
    text_t text = new_text();
    text_add_digits(&text, 0U, 21U);
}

static void no_hexadecimal_digit(void)
{
    text_t text = new_text();
    text_add_hex(&text, 0U, 0U);
}

static void too_many_hexadecimal_digits(void)
{
    text_t text = new_text();
    text_add_hex(&text, 0U, 17U);
}

static void coding_errors_are_caught(void)
{
    TEST_ASSERT_TRUE(assertion_fails(text_without_room));
    TEST_ASSERT_TRUE(assertion_fails(text_of_null));
    TEST_ASSERT_TRUE(assertion_fails(more_digits_than_a_number_has));
    TEST_ASSERT_TRUE(assertion_fails(no_hexadecimal_digit));
    TEST_ASSERT_TRUE(assertion_fails(too_many_hexadecimal_digits));
}

static void words_are_joined_in_order_and_cut_at_the_end_of_the_buffer(void)
{
    char small[6];
    TEST_ASSERT_TRUE(text_join(small, sizeof small, (const char* const[]){"ab", "", "cde", NULL}));
    TEST_ASSERT_EQUAL_STRING("abcde", small);
    TEST_ASSERT_FALSE(text_join(small, sizeof small, (const char* const[]){"abc", "def", NULL}));
    TEST_ASSERT_EQUAL_STRING("abcde", small);
    TEST_ASSERT_TRUE(text_join(small, sizeof small, (const char* const[]){NULL}));
    TEST_ASSERT_EQUAL_STRING("", small);
    text_t text = text_in(small, sizeof small);
    text_add(&text, "x");
    text_add_words(&text, (const char* const[]){"1", "2", NULL});
    TEST_ASSERT_EQUAL_STRING("x12", small);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(unsigned_numbers_are_written_as_by_printf);
    RUN_TEST(signed_numbers_are_written_as_by_printf);
    RUN_TEST(a_fixed_number_of_digits_is_padded_with_zeros_or_truncated_to_the_lowest);
    RUN_TEST(hexadecimal_numbers_are_written_as_by_printf);
    RUN_TEST(every_octet_has_two_lower_case_digits);
    RUN_TEST(seconds_have_nine_decimals);
    RUN_TEST(parts_are_appended_in_order);
    RUN_TEST(text_that_does_not_fit_is_cut_and_reported);
    RUN_TEST(a_text_that_was_truncated_remains_marked);
    RUN_TEST(coding_errors_are_caught);
    RUN_TEST(words_are_joined_in_order_and_cut_at_the_end_of_the_buffer);
    return UNITY_END();
}
