// SPDX-License-Identifier: Apache-2.0
#include "base/value.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static const struct {
    const char* name;
    size_t size;
} expected_types[VALUE_SCALARS] = {{"UINT8", 1U}, {"UINT16", 2U}, {"UINT32", 4U}, {"UINT64", 8U},
                                   {"INT8", 1U},  {"INT16", 2U},  {"INT32", 4U},  {"INT64", 8U},
                                   {"FLOAT", 4U}, {"DOUBLE", 8U}, {"BOOL", 1U}};

static void each_scalar_type_has_its_code_name_and_size(void)
{
    for (unsigned i = 0U; i < (unsigned)VALUE_SCALARS; i++) {
        value_type_t type = VALUE_SCALARS;
        TEST_ASSERT_EQUAL_STRING(expected_types[i].name, value_type_name((value_type_t)i));
        TEST_ASSERT_EQUAL_UINT64(expected_types[i].size, value_size((value_type_t)i));
        TEST_ASSERT_EQUAL_INT(STATUS_OK, value_type_of(expected_types[i].name, &type));
        TEST_ASSERT_EQUAL_INT(i, type);
    }
    TEST_ASSERT_EQUAL_INT(24, VALUE_STRUCT);
    TEST_ASSERT_EQUAL_INT(25, VALUE_ARRAY);
    TEST_ASSERT_EQUAL_UINT64(1U, sizeof(bool));
}

static void other_words_are_refused_as_scalar_types(void)
{
    static const char* const words[] = {"",       "double", "DOUBLE ", " DOUBLE", "DOUBL", "DOUBLES",
                                        "STRUCT", "ARRAY",  "UINT",    "INT128",  "CHAR"};
    for (size_t i = 0U; i < (sizeof words / sizeof words[0]); i++) {
        value_type_t type = VALUE_INT16;
        TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, value_type_of(words[i], &type));
        TEST_ASSERT_EQUAL_INT(VALUE_INT16, type);
    }
}

/// Encode the scalar and compare it with the expected octets; decode them and compare with the scalar.
static void expect_round_trip(value_type_t type, const void* memory, const uint8_t* wire)
{
    const size_t size = value_size(type);
    uint8_t octets[8];
    octet_writer_t writer = octet_writer(octets, size);
    value_encode(&writer, type, memory);
    TEST_ASSERT_FALSE(writer.failed);
    TEST_ASSERT_EQUAL_UINT64(size, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(wire, octets, size);

    uint64_t back         = 0U; // Aligned for every scalar type.
    octet_reader_t reader = octet_reader(octets, size);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, value_decode(&reader, type, &back));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    TEST_ASSERT_EQUAL_MEMORY(memory, &back, size);
}

static void scalars_are_encoded_and_decoded_again(void)
{
    const uint8_t u8   = 0xA5U;
    const uint16_t u16 = 0x0102U;
    const uint32_t u32 = 0x01020304U;
    const uint64_t u64 = 0x0102030405060708ULL;
    const int8_t i8    = -2;
    const int16_t i16  = -2;
    const int32_t i32  = -2;
    const int64_t i64  = -2;
    const float f32    = 1.0F;
    const double f64   = 1.0;
    const bool yes     = true;
    const bool no      = false;
    expect_round_trip(VALUE_UINT8, &u8, (const uint8_t*)"\xA5");
    expect_round_trip(VALUE_UINT16, &u16, (const uint8_t*)"\x01\x02");
    expect_round_trip(VALUE_UINT32, &u32, (const uint8_t*)"\x01\x02\x03\x04");
    expect_round_trip(VALUE_UINT64, &u64, (const uint8_t*)"\x01\x02\x03\x04\x05\x06\x07\x08");
    expect_round_trip(VALUE_INT8, &i8, (const uint8_t*)"\xFE");
    expect_round_trip(VALUE_INT16, &i16, (const uint8_t*)"\xFF\xFE");
    expect_round_trip(VALUE_INT32, &i32, (const uint8_t*)"\xFF\xFF\xFF\xFE");
    expect_round_trip(VALUE_INT64, &i64, (const uint8_t*)"\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFE");
    expect_round_trip(VALUE_FLOAT, &f32, (const uint8_t*)"\x3F\x80\x00\x00");
    expect_round_trip(VALUE_DOUBLE, &f64, (const uint8_t*)"\x3F\xF0\x00\x00\x00\x00\x00\x00");
    expect_round_trip(VALUE_BOOL, &yes, (const uint8_t*)"\x01");
    expect_round_trip(VALUE_BOOL, &no, (const uint8_t*)"\x00");
}

static void every_16_bit_pattern_is_encoded_and_decoded_again(void)
{
    for (uint32_t pattern = 0U; pattern <= 0xFFFFU; pattern++) {
        const uint16_t bits   = (uint16_t)pattern;
        const uint8_t wire[2] = {(uint8_t)(pattern >> 8U), (uint8_t)(pattern & 0xFFU)};
        int16_t number        = 0;
        (void)memcpy(&number, &bits, sizeof number);
        expect_round_trip(VALUE_UINT16, &bits, wire);
        expect_round_trip(VALUE_INT16, &number, wire);
    }
}

static void decoding_too_few_octets_fails_and_changes_nothing(void)
{
    static const uint8_t octets[8] = {0U};
    for (unsigned type = 0U; type < (unsigned)VALUE_SCALARS; type++) {
        for (size_t size = 0U; size < value_size((value_type_t)type); size++) {
            uint64_t memory       = 0x5555555555555555ULL;
            octet_reader_t reader = octet_reader(octets, size);
            TEST_ASSERT_EQUAL_INT(STATUS_TRUNCATED, value_decode(&reader, (value_type_t)type, &memory));
            TEST_ASSERT_EQUAL_HEX64(0x5555555555555555ULL, memory);
        }
    }
}

static void decoding_a_bool_other_than_0_and_1_fails(void)
{
    for (unsigned value = 0U; value < 256U; value++) {
        const uint8_t octet   = (uint8_t)value;
        bool memory           = (value == 0U);
        octet_reader_t reader = octet_reader(&octet, 1U);
        const status_t status = value_decode(&reader, VALUE_BOOL, &memory);
        TEST_ASSERT_EQUAL_INT((value <= 1U) ? STATUS_OK : STATUS_INVALID, status);
        TEST_ASSERT_EQUAL_INT(value == 1U, memory);
    }
}

static void a_writer_without_room_gets_no_octet(void)
{
    for (unsigned type = 0U; type < (unsigned)VALUE_SCALARS; type++) {
        const uint64_t memory = 1U;
        uint8_t octets[8]     = {0U};
        octet_writer_t writer = octet_writer(octets, value_size((value_type_t)type) - 1U);
        value_encode(&writer, (value_type_t)type, &memory);
        TEST_ASSERT_TRUE(writer.failed);
        TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
    }
}

static void every_8_and_16_bit_number_is_exact_as_double(void)
{
    for (int32_t number = -32768; number <= 65535; number++) {
        for (unsigned type = 0U; type <= (unsigned)VALUE_INT64; type++) {
            const bool is_signed = (type >= (unsigned)VALUE_INT8);
            const size_t size    = value_size((value_type_t)type);
            const int64_t half   = (size == 1U) ? 128 : ((size == 2U) ? 32768 : 1000000);
            const bool fits =
                is_signed ? ((number >= -half) && (number < half)) : ((number >= 0) && (number < (2 * half)));
            uint64_t memory = 0U;
            if (fits) {
                value_store((value_type_t)type, (uint64_t)(int64_t)number, &memory);
                TEST_ASSERT_TRUE(value_as_double((value_type_t)type, &memory) == (double)number);
            }
        }
    }
}

static void limits_of_wide_integers_are_stored_and_converted(void)
{
    static const struct {
        value_type_t type;
        double number;
        uint64_t bits; // Bits of the value in the width of the type; the higher bits are 0.
    } rows[] = {
        {VALUE_UINT32, 4294967295.0, 0xFFFFFFFFULL},
        {VALUE_INT32, 2147483647.0, 0x7FFFFFFFULL},
        {VALUE_INT32, -2147483648.0, 0x80000000ULL},
        {VALUE_INT64, -9223372036854775808.0, 0x8000000000000000ULL},
        {VALUE_INT64, 9223372036854774784.0, 0x7FFFFFFFFFFFFC00ULL},
        {VALUE_UINT64, 18446744073709549568.0, 0xFFFFFFFFFFFFF800ULL},
        {VALUE_UINT64, 0.0, 0U},
        {VALUE_BOOL, 1.0, 1U},
    };
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        uint64_t memory = 0U;
        value_store(rows[i].type, rows[i].bits, &memory);
        TEST_ASSERT_EQUAL_HEX64(rows[i].bits, value_bits(rows[i].type, &memory));
        TEST_ASSERT_TRUE(value_as_double(rows[i].type, &memory) == rows[i].number);
    }
}

static void storing_a_value_changes_only_the_octets_of_its_type(void)
{
    for (unsigned type = 0U; type < (unsigned)VALUE_SCALARS; type++) {
        const size_t size = value_size((value_type_t)type);
        uint64_t memory   = UINT64_MAX;
        value_store((value_type_t)type, 0U, &memory);
        for (size_t i = 0U; i < sizeof memory; i++) {
            TEST_ASSERT_EQUAL_HEX8((i < size) ? 0U : 0xFFU, ((const uint8_t*)&memory)[i]);
        }
    }
}

static void reals_keep_their_precision(void)
{
    static const double numbers[] = {0.1, -1.57, 3.14159265358979311600, DBL_MAX, -DBL_MAX, DBL_MIN, 0.0};
    for (size_t i = 0U; i < (sizeof numbers / sizeof numbers[0]); i++) {
        uint64_t bits = 0U;
        double memory = 1.0;
        (void)memcpy(&bits, &numbers[i], sizeof bits);
        value_store(VALUE_DOUBLE, bits, &memory);
        TEST_ASSERT_TRUE(value_as_double(VALUE_DOUBLE, &memory) == numbers[i]);
    }
    const float single = 0.1F;
    TEST_ASSERT_TRUE(value_as_double(VALUE_FLOAT, &single) == (double)0.1F);
}

static void size_of_a_struct(void)
{
    (void)value_size(VALUE_STRUCT);
}

static void name_of_no_type(void)
{
    (void)value_type_name(VALUE_SCALARS);
}

static void double_of_an_array(void)
{
    const double number = 0.0;
    (void)value_as_double(VALUE_ARRAY, &number);
}

static void a_layout_that_is_not_scalar_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(size_of_a_struct));
    TEST_ASSERT_TRUE(assertion_fails(name_of_no_type));
    TEST_ASSERT_TRUE(assertion_fails(double_of_an_array));
}

static void an_array_is_encoded_scalar_by_scalar(void)
{
    static const uint8_t octets8[]    = {1U, 2U, 3U};
    static const uint16_t halves[]    = {0x0102U, 0x0304U, 0x0506U};
    static const uint32_t words[]     = {0x01020304U, 0x05060708U, 0x090A0B0CU};
    static const uint64_t doubles[]   = {0x0102030405060708U, 0x090A0B0C0D0E0F10U, 0x1112131415161718U};
    static const value_type_t types[] = {VALUE_UINT8, VALUE_UINT16, VALUE_UINT32, VALUE_UINT64};
    const void* const arrays[]        = {octets8, halves, words, doubles};
    for (size_t i = 0U; i < 4U; i++) {
        uint8_t out[25];
        const size_t size = 3U * value_size(types[i]);
        (void)memset(out, 0xEE, sizeof out);
        TEST_ASSERT_EQUAL_UINT64(size, value_put(out, types[i], arrays[i], 3U));
        for (size_t k = 0U; k < size; k++) {
            TEST_ASSERT_EQUAL_HEX8(k + 1U, out[k]);
        }
        TEST_ASSERT_EQUAL_HEX8(0xEE, out[size]);
        TEST_ASSERT_EQUAL_UINT64(0U, value_put(out, types[i], arrays[i], 0U));
        TEST_ASSERT_EQUAL_HEX8(1U, out[0]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_scalar_type_has_its_code_name_and_size);
    RUN_TEST(other_words_are_refused_as_scalar_types);
    RUN_TEST(scalars_are_encoded_and_decoded_again);
    RUN_TEST(every_16_bit_pattern_is_encoded_and_decoded_again);
    RUN_TEST(decoding_too_few_octets_fails_and_changes_nothing);
    RUN_TEST(decoding_a_bool_other_than_0_and_1_fails);
    RUN_TEST(a_writer_without_room_gets_no_octet);
    RUN_TEST(every_8_and_16_bit_number_is_exact_as_double);
    RUN_TEST(limits_of_wide_integers_are_stored_and_converted);
    RUN_TEST(storing_a_value_changes_only_the_octets_of_its_type);
    RUN_TEST(reals_keep_their_precision);
    RUN_TEST(a_layout_that_is_not_scalar_is_a_coding_error);
    RUN_TEST(an_array_is_encoded_scalar_by_scalar);
    return UNITY_END();
}
