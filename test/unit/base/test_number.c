// SPDX-License-Identifier: Apache-2.0
#include "base/number.h"

#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

void setUp(void)
{
}

void tearDown(void)
{
}

typedef struct {
    const char* text;
    status_t status;
    uint64_t value;
} unsigned_case_t;

static void unsigned_numbers_are_read(void)
{
    static const unsigned_case_t cases[] = {
        {"0", STATUS_OK, 0U},
        {"18446744073709551615", STATUS_OK, UINT64_MAX},
        {"18446744073709551616", STATUS_OUT_OF_RANGE, 0U},
        {"99999999999999999999999999999", STATUS_OUT_OF_RANGE, 0U},
        {"0xFFFFFFFFFFFFFFFF", STATUS_OK, UINT64_MAX},
        {"0x10000000000000000", STATUS_OUT_OF_RANGE, 0U},
        {"0xaBc", STATUS_OK, 0xABCU},
        {"007", STATUS_OK, 7U},
        {"", STATUS_EMPTY, 0U},
        {"  ", STATUS_EMPTY, 0U},
        {"-1", STATUS_OUT_OF_RANGE, 0U},
        {"+1", STATUS_INVALID, 0U},
        {"1a", STATUS_INVALID, 0U},
        {"0x", STATUS_INVALID, 0U},
        {"0xG", STATUS_INVALID, 0U},
        {"0xg", STATUS_INVALID, 0U},
        {"0x@", STATUS_INVALID, 0U},
        {"1.0", STATUS_INVALID, 0U},
        {"--1", STATUS_INVALID, 0U},
        {"-", STATUS_INVALID, 0U},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        const char* at = cases[i].text;
        uint64_t value = 0U;
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].status, number_read_unsigned(&at, &value), cases[i].text);
        TEST_ASSERT_EQUAL_UINT64_MESSAGE(cases[i].value, value, cases[i].text);
        if (cases[i].status != STATUS_OK) {
            TEST_ASSERT_EQUAL_PTR(cases[i].text, at);
        }
    }
}

static void the_smallest_and_the_largest_number_of_each_integer_type_are_read(void)
{
    static const struct {
        value_type_t type;
        const char* least;
        const char* below;
        const char* most;
        const char* above;
    } cases[] = {
        {VALUE_UINT8, "0", "-1", "255", "256"},
        {VALUE_UINT16, "0", "-1", "65535", "65536"},
        {VALUE_UINT32, "0", "-1", "4294967295", "4294967296"},
        {VALUE_UINT64, "0", "-1", "18446744073709551615", "18446744073709551616"},
        {VALUE_INT8, "-128", "-129", "127", "128"},
        {VALUE_INT16, "-32768", "-32769", "32767", "32768"},
        {VALUE_INT32, "-2147483648", "-2147483649", "2147483647", "2147483648"},
        {VALUE_INT64, "-9223372036854775808", "-9223372036854775809", "9223372036854775807",
         "9223372036854775808"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        uint64_t memory = 0U;
        const char* at  = cases[i].least;
        TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, cases[i].type, &memory));
        TEST_ASSERT_EQUAL_DOUBLE(strtod(cases[i].least, NULL), value_as_double(cases[i].type, &memory));
        at = cases[i].most;
        TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, cases[i].type, &memory));
        TEST_ASSERT_EQUAL_DOUBLE(strtod(cases[i].most, NULL), value_as_double(cases[i].type, &memory));
        at = cases[i].below;
        TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, number_read_value(&at, cases[i].type, &memory));
        at = cases[i].above;
        TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, number_read_value(&at, cases[i].type, &memory));
    }
}

static void malformed_reals_and_reals_without_a_correct_rounding_are_refused(void)
{
    static const char* const too_long[] = {
        "1234567890123456", "1e23", "1e-23", "0.00000000000000000000001", "1.2345678901234567", "1e9999"};
    static const char* const malformed[] = {".5",  "5.",  "1e",  "1e+",     "1e12345", "e5",
                                            "nan", "inf", "0x1", "1,5",     "1.5x",    "1..2",
                                            "+1",  "--1", "-",   "1e123456"};
    double value                         = 0.0;
    for (size_t i = 0U; i < (sizeof too_long / sizeof too_long[0]); i++) {
        const char* at = too_long[i];
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OUT_OF_RANGE, number_read_real(&at, &value), too_long[i]);
    }
    for (size_t i = 0U; i < (sizeof malformed / sizeof malformed[0]); i++) {
        const char* at = malformed[i];
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, number_read_real(&at, &value), malformed[i]);
    }
}

/// Compare bit for bit with the C library, which rounds correctly.
static void reals_are_rounded_as_by_the_c_library(void)
{
    uint64_t random = 0x9E3779B97F4A7C15ULL;
    for (unsigned i = 0U; i < 200000U; i++) {
        random                = (random * 6364136223846793005ULL) + 1442695040888963407ULL;
        const uint64_t digits = (random >> 11U) % 1000000000000000ULL;
        const int power       = (int)((random >> 3U) % 29U) - 14;
        const unsigned places = (unsigned)((random >> 40U) % 8U);
        char text[64];
        if (places == 0U) {
            (void)snprintf(text, sizeof text, "%s%llue%d", ((i % 2U) == 0U) ? "-" : "",
                           (unsigned long long)digits, power);
        } else {
            (void)snprintf(text, sizeof text, "%llu.%0*llu", (unsigned long long)(digits / 100000000U),
                           (int)places, (unsigned long long)(digits % 10U));
        }
        const char* at = text;
        double value   = 0.0;
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, number_read_real(&at, &value), text);
        TEST_ASSERT_TRUE_MESSAGE(value == strtod(text, NULL), text);
        TEST_ASSERT_EQUAL('\0', *at);
    }
}

static void the_entries_of_a_list_are_read_in_order(void)
{
    const char* at = "0.5 -2e3  7";
    double value   = 0.0;
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_real(&at, &value));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, value);
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_real(&at, &value));
    TEST_ASSERT_EQUAL_DOUBLE(-2000.0, value);
    TEST_ASSERT_FALSE(number_is_end(at));
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_real(&at, &value));
    TEST_ASSERT_TRUE(number_is_end(at));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, number_read_real(&at, &value));
}

/// Zero has no digits that a power of ten could make too large, and 'E' is the same as 'e'.
static void zeros_and_both_letters_of_the_exponent_are_read(void)
{
    static const char* const zeros[] = {"0", "0.000", "0e9999", "0.0E-9999", "0e0"};
    double value                     = 1.0;
    for (size_t i = 0U; i < (sizeof zeros / sizeof zeros[0]); i++) {
        const char* at = zeros[i];
        value          = 1.0;
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, number_read_real(&at, &value), zeros[i]);
        TEST_ASSERT_TRUE_MESSAGE(value == 0.0, zeros[i]);
    }
    const char* at = "25E-2 1E+2";
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_DOUBLE, &value));
    TEST_ASSERT_TRUE(value == 0.25);
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_DOUBLE, &value));
    TEST_ASSERT_TRUE(value == 100.0);
}

/// A refused text changes neither the value nor the position in the text.
static void values_that_cannot_be_read_are_refused(void)
{
    static const struct {
        const char* text;
        value_type_t type;
        status_t status;
    } cases[] = {{"", VALUE_BOOL, STATUS_EMPTY},
                 {"  ", VALUE_BOOL, STATUS_EMPTY},
                 {"truer", VALUE_BOOL, STATUS_INVALID},
                 {"10", VALUE_BOOL, STATUS_INVALID},
                 {"", VALUE_INT8, STATUS_EMPTY},
                 {"1x", VALUE_INT8, STATUS_INVALID},
                 {"", VALUE_FLOAT, STATUS_EMPTY},
                 {"1.5x", VALUE_FLOAT, STATUS_INVALID},
                 {"3.5e38", VALUE_FLOAT, STATUS_OUT_OF_RANGE},
                 {"-3.5e38", VALUE_FLOAT, STATUS_OUT_OF_RANGE},
                 {"", VALUE_DOUBLE, STATUS_EMPTY}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        const char* at        = cases[i].text;
        const uint64_t before = 0x0123456789ABCDEFULL;
        uint64_t memory       = before;
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].status, number_read_value(&at, cases[i].type, &memory),
                                  cases[i].text);
        TEST_ASSERT_EQUAL_PTR(cases[i].text, at);
        TEST_ASSERT_EQUAL_HEX64(before, memory);
    }
}

static void words_for_bool_and_the_bounds_of_float_are_read(void)
{
    const char* at = "true false 1 0 yes";
    bool flag      = false;
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_BOOL, &flag));
    TEST_ASSERT_TRUE(flag);
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_BOOL, &flag));
    TEST_ASSERT_FALSE(flag);
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_BOOL, &flag));
    TEST_ASSERT_TRUE(flag);
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_BOOL, &flag));
    TEST_ASSERT_EQUAL(STATUS_INVALID, number_read_value(&at, VALUE_BOOL, &flag));
    float single = 0.0F;
    at           = "-999999999999999e22"; // The largest magnitude that is read.
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_FLOAT, &single));
    TEST_ASSERT_EQUAL_FLOAT(-1e37F, single);
    at = "1.5 ";
    TEST_ASSERT_EQUAL(STATUS_OK, number_read_value(&at, VALUE_FLOAT, &single));
    TEST_ASSERT_EQUAL_FLOAT(1.5F, single);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(unsigned_numbers_are_read);
    RUN_TEST(the_smallest_and_the_largest_number_of_each_integer_type_are_read);
    RUN_TEST(malformed_reals_and_reals_without_a_correct_rounding_are_refused);
    RUN_TEST(reals_are_rounded_as_by_the_c_library);
    RUN_TEST(the_entries_of_a_list_are_read_in_order);
    RUN_TEST(zeros_and_both_letters_of_the_exponent_are_read);
    RUN_TEST(values_that_cannot_be_read_are_refused);
    RUN_TEST(words_for_bool_and_the_bounds_of_float_are_read);
    return UNITY_END();
}
