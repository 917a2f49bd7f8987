// SPDX-License-Identifier: Apache-2.0
#include "base/octets.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void values_of_each_width_are_big_endian(void)
{
    static const uint8_t expected[15] = {0x01U, 0x02U, 0x03U, 0x04U, 0x05U, 0x06U, 0x07U, 0x08U,
                                         0x09U, 0x0AU, 0x0BU, 0x0CU, 0x0DU, 0x0EU, 0x0FU};
    uint8_t octets[15];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, 0x01U);
    octet_write_u16(&writer, 0x0203U);
    octet_write_u32(&writer, 0x04050607U);
    octet_write_u64(&writer, 0x08090A0B0C0D0E0FULL);
    TEST_ASSERT_FALSE(writer.failed);
    TEST_ASSERT_EQUAL_UINT64(sizeof octets, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, sizeof octets);

    octet_reader_t reader = octet_reader(octets, sizeof octets);
    TEST_ASSERT_EQUAL_HEX8(0x01U, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_HEX16(0x0203U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(0x04050607U, octet_read_u32(&reader));
    TEST_ASSERT_FALSE(octet_reader_is_done(&reader));
    TEST_ASSERT_EQUAL_UINT64(8U, octet_reader_left(&reader));
    TEST_ASSERT_EQUAL_HEX64(0x08090A0B0C0D0E0FULL, octet_read_u64(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void every_16_bit_value_is_read_as_it_was_written(void)
{
    for (uint32_t value = 0U; value <= 0xFFFFU; value++) {
        uint8_t octets[2];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_u16(&writer, (uint16_t)value);
        TEST_ASSERT_EQUAL_HEX8(value >> 8U, octets[0]);
        TEST_ASSERT_EQUAL_HEX8(value & 0xFFU, octets[1]);
        octet_reader_t reader = octet_reader(octets, sizeof octets);
        TEST_ASSERT_EQUAL_HEX16(value, octet_read_u16(&reader));
    }
}

static void reals_are_ieee_754(void)
{
    static const uint8_t expected[8] = {0xC0U, 0x09U, 0x21U, 0xFBU, 0x54U, 0x44U, 0x2DU, 0x18U}; // -pi
    uint8_t octets[8];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_f64(&writer, -3.14159265358979311600);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, sizeof octets);
    octet_reader_t reader = octet_reader(octets, sizeof octets);
    TEST_ASSERT_TRUE(octet_read_f64(&reader) == -3.14159265358979311600);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void bits_of_special_reals_are_kept(void)
{
    // Negative zero, infinities, smallest and largest numbers, and NaN.
    static const uint64_t patterns[] = {0x8000000000000000ULL, 0x7FF0000000000000ULL, 0xFFF0000000000000ULL,
                                        0x0000000000000001ULL, 0x7FEFFFFFFFFFFFFFULL, 0x7FF8000000000001ULL};
    for (size_t i = 0U; i < (sizeof patterns / sizeof patterns[0]); i++) {
        double value = 0.0;
        (void)memcpy(&value, &patterns[i], sizeof value);
        uint8_t octets[8];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_f64(&writer, value);
        octet_reader_t reader = octet_reader(octets, sizeof octets);
        const double back     = octet_read_f64(&reader);
        TEST_ASSERT_EQUAL_MEMORY(&value, &back, sizeof value);
    }
}

/// Read one item of each width from a reader of `size` octets; 0..4 select the width.
static size_t read_width(octet_reader_t* reader, unsigned which)
{
    switch (which) {
    case 0U:
        TEST_ASSERT_TRUE((octet_read_u8(reader) == 0U) || !reader->failed);
        return 1U;
    case 1U:
        TEST_ASSERT_TRUE((octet_read_u16(reader) == 0U) || !reader->failed);
        return 2U;
    case 2U:
        TEST_ASSERT_TRUE((octet_read_u32(reader) == 0U) || !reader->failed);
        return 4U;
    case 3U:
        TEST_ASSERT_TRUE((octet_read_u64(reader) == 0U) || !reader->failed);
        return 8U;
    default:
        TEST_ASSERT_TRUE((octet_read_f64(reader) == 0.0) || !reader->failed);
        return 8U;
    }
}

static void after_a_read_past_the_end_the_reader_stays_failed(void)
{
    uint8_t octets[16];
    // Interpreted as a real number, these octets are not zero either.
    (void)memset(octets, 0x40, sizeof octets);
    for (unsigned which = 0U; which <= 4U; which++) {
        for (size_t size = 0U; size <= 9U; size++) {
            octet_reader_t reader = octet_reader(octets, size);
            const size_t width    = read_width(&reader, which);
            TEST_ASSERT_EQUAL_INT(width > size, reader.failed);
            if (!reader.failed) {
                TEST_ASSERT_EQUAL_UINT64(size - width, octet_reader_left(&reader));
                continue;
            }
            TEST_ASSERT_EQUAL_UINT64(0U, reader.position);
            TEST_ASSERT_EQUAL_UINT64(0U, octet_reader_left(&reader));
            TEST_ASSERT_FALSE(octet_reader_is_done(&reader));
            // Later reads are refused even if the octets are there.
            TEST_ASSERT_NULL(octet_read_octets(&reader, 0U));
            TEST_ASSERT_EQUAL_HEX8(0U, octet_read_u8(&reader));
        }
    }
}

static void a_reader_returns_octets_without_a_copy(void)
{
    static const uint8_t octets[4] = {1U, 2U, 3U, 4U};
    octet_reader_t reader          = octet_reader(octets, sizeof octets);
    TEST_ASSERT_EQUAL_PTR(&octets[0], octet_read_octets(&reader, 3U));
    TEST_ASSERT_EQUAL_PTR(&octets[3], octet_read_octets(&reader, 1U));
    TEST_ASSERT_NOT_NULL(octet_read_octets(&reader, 0U));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    TEST_ASSERT_NULL(octet_read_octets(&reader, 1U));
}

static void sizes_near_the_limit_of_size_t_do_not_wrap(void)
{
    static const uint8_t octets[4] = {1U, 2U, 3U, 4U};
    octet_reader_t reader          = octet_reader(octets, sizeof octets);
    (void)octet_read_u8(&reader);
    TEST_ASSERT_NULL(octet_read_octets(&reader, SIZE_MAX));
    TEST_ASSERT_TRUE(reader.failed);

    uint8_t room[4]       = {0U};
    octet_writer_t writer = octet_writer(room, sizeof room);
    octet_write_u8(&writer, 1U);
    octet_write_octets(&writer, octets, SIZE_MAX);
    TEST_ASSERT_TRUE(writer.failed);
    TEST_ASSERT_EQUAL_UINT64(1U, writer.position);
}

static void a_write_that_does_not_fit_and_all_later_ones_change_nothing(void)
{
    static const uint8_t more[8] = {9U, 9U, 9U, 9U, 9U, 9U, 9U, 9U};
    for (size_t capacity = 0U; capacity < 8U; capacity++) {
        uint8_t octets[9];
        (void)memset(octets, 0x55, sizeof octets);
        octet_writer_t writer = octet_writer(octets, capacity);
        octet_write_octets(&writer, more, capacity + 1U);
        octet_write_u64(&writer, 0U);
        octet_write_f64(&writer, 0.0);
        octet_write_u32(&writer, 0U);
        octet_write_u16(&writer, 0U);
        octet_write_u8(&writer, 0U);
        TEST_ASSERT_TRUE(writer.failed);
        TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
        TEST_ASSERT_EACH_EQUAL_HEX8(0x55, octets, sizeof octets);
    }
}

static void a_writer_that_is_exactly_full_has_not_failed(void)
{
    uint8_t octets[4];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u32(&writer, 1U);
    octet_write_octets(&writer, NULL, 0U);
    TEST_ASSERT_FALSE(writer.failed);
    octet_reader_t empty = octet_reader(NULL, 0U);
    TEST_ASSERT_TRUE(octet_reader_is_done(&empty));
}

static void reader_of_null(void)
{
    (void)octet_reader(NULL, 1U);
}

static void writer_of_null(void)
{
    (void)octet_writer(NULL, 1U);
}

static void write_of_null(void)
{
    uint8_t octets[4];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_octets(&writer, NULL, 1U);
}

static void null_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(reader_of_null));
    TEST_ASSERT_TRUE(assertion_fails(writer_of_null));
    TEST_ASSERT_TRUE(assertion_fails(write_of_null));
}

/// A writer that has failed stays failed: it refuses octets that would fit, and also zero octets.
static void blocks_of_octets_are_written_completely_or_not_at_all(void)
{
    static const uint8_t source[5] = {1U, 2U, 3U, 4U, 5U};
    uint8_t octets[4]              = {0xEEU, 0xEEU, 0xEEU, 0xEEU};
    octet_writer_t writer          = octet_writer(octets, sizeof octets);
    octet_write_octets(&writer, NULL, 0U);
    TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
    octet_write_octets(&writer, source, 3U);
    octet_write_octets(&writer, NULL, 0U);
    TEST_ASSERT_FALSE(writer.failed);
    octet_write_octets(&writer, source, 2U);
    TEST_ASSERT_TRUE(writer.failed);
    octet_write_octets(&writer, source, 1U);
    octet_write_octets(&writer, NULL, 0U);
    TEST_ASSERT_TRUE(writer.failed);
    TEST_ASSERT_EQUAL_UINT64(3U, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[4]){1U, 2U, 3U, 0xEEU}), octets, sizeof octets);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_of_each_width_are_big_endian);
    RUN_TEST(every_16_bit_value_is_read_as_it_was_written);
    RUN_TEST(reals_are_ieee_754);
    RUN_TEST(bits_of_special_reals_are_kept);
    RUN_TEST(after_a_read_past_the_end_the_reader_stays_failed);
    RUN_TEST(a_reader_returns_octets_without_a_copy);
    RUN_TEST(sizes_near_the_limit_of_size_t_do_not_wrap);
    RUN_TEST(a_write_that_does_not_fit_and_all_later_ones_change_nothing);
    RUN_TEST(a_writer_that_is_exactly_full_has_not_failed);
    RUN_TEST(blocks_of_octets_are_written_completely_or_not_at_all);
    RUN_TEST(null_is_a_coding_error);
    return UNITY_END();
}
