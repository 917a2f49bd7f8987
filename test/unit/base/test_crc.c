// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <string.h>

#define CHECK_TEXT ((const uint8_t*)"123456789")
#define CHECK_SIZE 9U

void setUp(void)
{
}

void tearDown(void)
{
}

/// Compute the CRC bit by bit from its definition: polynomial division as in the standards, without a table.
static uint16_t reference_crc16(const uint8_t* octets, size_t size)
{
    uint32_t crc = 0xFFFFU;
    for (size_t i = 0U; i < size; i++) {
        for (unsigned bit = 0U; bit < 8U; bit++) {
            const uint32_t in  = ((uint32_t)octets[i] >> (7U - bit)) & 1U;
            const uint32_t out = (crc >> 15U) & 1U;
            crc                = (crc << 1U) & 0xFFFFU;
            if ((in ^ out) != 0U) {
                crc ^= 0x1021U;
            }
        }
    }
    return (uint16_t)crc;
}

static uint32_t reference_crc32(const uint8_t* octets, size_t size)
{
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0U; i < size; i++) {
        for (unsigned bit = 0U; bit < 8U; bit++) {
            const uint32_t in  = ((uint32_t)octets[i] >> bit) & 1U;
            const uint32_t out = crc & 1U;
            crc >>= 1U;
            if ((in ^ out) != 0U) {
                crc ^= 0xEDB88320U;
            }
        }
    }
    return ~crc;
}

/// A fixed sequence of pseudo-random octets (linear congruential generator).
static void fill(uint8_t* octets, size_t size, uint32_t seed)
{
    uint32_t state = seed;
    for (size_t i = 0U; i < size; i++) {
        state     = (state * 1664525U) + 1013904223U;
        octets[i] = (uint8_t)(state >> 24U);
    }
}

static void the_published_check_values_are_computed(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x29B1U, crc16_ccitt(CHECK_TEXT, CHECK_SIZE));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, crc32_iso(CHECK_TEXT, CHECK_SIZE));
}

static void the_verification_patterns_of_the_packet_standard_are_computed(void)
{
    // The verification patterns that ECSS-E-ST-70-41C gives for packet error control.
    static const struct {
        uint8_t octets[6];
        size_t size;
        uint16_t crc;
    } patterns[] = {
        {{0x00U, 0x00U}, 2U, 0x1D0FU},
        {{0x00U, 0x00U, 0x00U}, 3U, 0xCC9CU},
        {{0xABU, 0xCDU, 0xEFU, 0x01U}, 4U, 0x04A2U},
        {{0x14U, 0x56U, 0xF8U, 0x9AU, 0x00U, 0x01U}, 6U, 0x7FD5U},
    };
    for (size_t i = 0U; i < (sizeof patterns / sizeof patterns[0]); i++) {
        TEST_ASSERT_EQUAL_HEX16(patterns[i].crc, crc16_ccitt(patterns[i].octets, patterns[i].size));
    }
}

static void empty_input_gives_the_start_values(void)
{
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, crc16_ccitt(NULL, 0U));
    TEST_ASSERT_EQUAL_HEX32(0x00000000U, crc32_iso(NULL, 0U));
    TEST_ASSERT_EQUAL_HEX64(FNV64_START, fnv64(FNV64_START, NULL, 0U));
}

static void every_octet_and_every_pair_equals_the_reference(void)
{
    for (uint32_t value = 0U; value < 65536U; value++) {
        const uint8_t octets[2] = {(uint8_t)(value >> 8U), (uint8_t)(value & 0xFFU)};
        TEST_ASSERT_EQUAL_HEX16(reference_crc16(octets, 2U), crc16_ccitt(octets, 2U));
        TEST_ASSERT_EQUAL_HEX32(reference_crc32(octets, 2U), crc32_iso(octets, 2U));
        TEST_ASSERT_EQUAL_HEX16(reference_crc16(octets, 1U), crc16_ccitt(octets, 1U));
        TEST_ASSERT_EQUAL_HEX32(reference_crc32(octets, 1U), crc32_iso(octets, 1U));
    }
}

static void long_texts_equal_the_reference(void)
{
    uint8_t octets[4096];
    fill(octets, sizeof octets, 1U);
    for (size_t size = 0U; size <= sizeof octets; size += 61U) {
        TEST_ASSERT_EQUAL_HEX16(reference_crc16(octets, size), crc16_ccitt(octets, size));
        TEST_ASSERT_EQUAL_HEX32(reference_crc32(octets, size), crc32_iso(octets, size));
    }
}

static void a_packet_with_its_own_crc_gives_zero(void)
{
    uint8_t packet[66];
    for (uint32_t seed = 0U; seed < 100U; seed++) {
        fill(packet, 64U, seed);
        const uint16_t crc = crc16_ccitt(packet, 64U);
        packet[64]         = (uint8_t)(crc >> 8U);
        packet[65]         = (uint8_t)(crc & 0xFFU);
        TEST_ASSERT_EQUAL_HEX16(0U, crc16_ccitt(packet, sizeof packet));
    }
}

static void one_and_two_wrong_bits_are_always_detected(void)
{
    uint8_t packet[32];
    fill(packet, sizeof packet, 7U);
    const uint16_t crc16 = crc16_ccitt(packet, sizeof packet);
    const uint32_t crc32 = crc32_iso(packet, sizeof packet);
    for (size_t first = 0U; first < (8U * sizeof packet); first++) {
        for (size_t second = first; second < (8U * sizeof packet); second++) {
            packet[first / 8U] ^= (uint8_t)(1U << (first % 8U));
            if (second != first) {
                packet[second / 8U] ^= (uint8_t)(1U << (second % 8U));
            }
            TEST_ASSERT_TRUE(crc16 != crc16_ccitt(packet, sizeof packet));
            TEST_ASSERT_TRUE(crc32 != crc32_iso(packet, sizeof packet));
            packet[first / 8U] ^= (uint8_t)(1U << (first % 8U));
            if (second != first) {
                packet[second / 8U] ^= (uint8_t)(1U << (second % 8U));
            }
        }
    }
}

static void fnv_is_computed_for_published_texts_and_in_parts(void)
{
    TEST_ASSERT_EQUAL_HEX64(0xAF63DC4C8601EC8CULL, fnv64(FNV64_START, (const uint8_t*)"a", 1U));
    TEST_ASSERT_EQUAL_HEX64(0x85944171F73967E8ULL, fnv64(FNV64_START, (const uint8_t*)"foobar", 6U));
    const uint64_t part = fnv64(FNV64_START, CHECK_TEXT, 4U);
    TEST_ASSERT_EQUAL_HEX64(fnv64(FNV64_START, CHECK_TEXT, CHECK_SIZE), fnv64(part, &CHECK_TEXT[4], 5U));
}

static void crc16_of_null(void)
{
    (void)crc16_ccitt(NULL, 1U);
}

static void crc32_of_null(void)
{
    (void)crc32_iso(NULL, 1U);
}

static void fnv_of_null(void)
{
    (void)fnv64(FNV64_START, NULL, 1U);
}

static void null_with_a_size_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(crc16_of_null));
    TEST_ASSERT_TRUE(assertion_fails(crc32_of_null));
    TEST_ASSERT_TRUE(assertion_fails(fnv_of_null));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_published_check_values_are_computed);
    RUN_TEST(the_verification_patterns_of_the_packet_standard_are_computed);
    RUN_TEST(empty_input_gives_the_start_values);
    RUN_TEST(every_octet_and_every_pair_equals_the_reference);
    RUN_TEST(long_texts_equal_the_reference);
    RUN_TEST(a_packet_with_its_own_crc_gives_zero);
    RUN_TEST(one_and_two_wrong_bits_are_always_detected);
    RUN_TEST(fnv_is_computed_for_published_texts_and_in_parts);
    RUN_TEST(null_with_a_size_is_a_coding_error);
    return UNITY_END();
}
