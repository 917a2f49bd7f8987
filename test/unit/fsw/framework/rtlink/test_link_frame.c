// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/link_frame.h"

#include "base/crc.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static const rtlink_frame_header_t header = {.producer_state = 5U,
                                             .link           = 0x0102U,
                                             .epoch          = 0x03040506U,
                                             .sequence       = 0x0708090AU,
                                             .time_ns        = 0x0B0C0D0E0F101112ULL};

static uint32_t random_state = 3U;

static uint8_t draw(void)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (uint8_t)(random_state >> 24U);
}

static void the_frame_has_the_layout_of_its_header_file(void)
{
    static const uint8_t expected[27] = {0x52U, 0x54U, 0x01U, 0x05U, 0x01U, 0x02U, 0x00U, 0x00U, 0x03U,
                                         0x04U, 0x05U, 0x06U, 0x07U, 0x08U, 0x09U, 0x0AU, 0x0BU, 0x0CU,
                                         0x0DU, 0x0EU, 0x0FU, 0x10U, 0x11U, 0x12U, 0xAAU, 0xBBU, 0xCCU};
    const uint8_t payload[3]          = {0xAAU, 0xBBU, 0xCCU};
    uint8_t frame[LINK_FRAME_MAX];
    TEST_ASSERT_EQUAL(27U, rtlink_frame_encode(&header, payload, sizeof payload, false, frame));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, frame, sizeof expected);
    TEST_ASSERT_EQUAL(31U, rtlink_frame_encode(&header, payload, sizeof payload, true, frame));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, frame, sizeof expected);
    const uint32_t crc = crc32_iso(expected, sizeof expected);
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL_HEX8(crc >> (24U - (8U * i)), frame[27U + i]);
    }
}

static void every_size_of_record_is_read_back(void)
{
    for (size_t size = 1U; size <= RTLINK_PAYLOAD_MAX; size++) {
        for (unsigned with_crc = 0U; with_crc < 2U; with_crc++) {
            uint8_t payload[RTLINK_PAYLOAD_MAX];
            uint8_t frame[LINK_FRAME_MAX];
            for (size_t i = 0U; i < size; i++) {
                payload[i] = draw();
            }
            rtlink_frame_header_t found = {0};
            const uint8_t* octets       = NULL;
            const size_t whole          = rtlink_frame_encode(&header, payload, size, with_crc != 0U, frame);
            TEST_ASSERT_EQUAL(24U + size + (4U * with_crc), whole);
            TEST_ASSERT_EQUAL(STATUS_OK,
                              rtlink_frame_decode(frame, whole, size, with_crc != 0U, &found, &octets));
            TEST_ASSERT_EQUAL(header.producer_state, found.producer_state);
            TEST_ASSERT_EQUAL(header.link, found.link);
            TEST_ASSERT_EQUAL_HEX32(header.epoch, found.epoch);
            TEST_ASSERT_EQUAL_HEX32(header.sequence, found.sequence);
            TEST_ASSERT_EQUAL_HEX64(header.time_ns, found.time_ns);
            TEST_ASSERT_EQUAL(0, memcmp(payload, octets, size));
        }
    }
}

/// Decode a copy of exactly this size, so that a sanitizer detects a read beyond its end.
static status_t decode(const uint8_t* frame, size_t size, size_t payload_size, bool with_crc)
{
    uint8_t copy[2U * LINK_FRAME_MAX];
    rtlink_frame_header_t found = {0};
    const uint8_t* octets       = NULL;
    uint8_t* const last         = &copy[sizeof copy - size];
    (void)memcpy(last, frame, size);
    return rtlink_frame_decode(last, size, payload_size, with_crc, &found, &octets);
}

static void every_wrong_length_is_refused(void)
{
    uint8_t payload[RTLINK_PAYLOAD_MAX] = {0};
    uint8_t frame[LINK_FRAME_MAX]       = {0};
    static const size_t sizes[]         = {1U, 8U, 255U, 1024U};
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        for (unsigned with_crc = 0U; with_crc < 2U; with_crc++) {
            const size_t whole = rtlink_frame_encode(&header, payload, sizes[i], with_crc != 0U, frame);
            for (size_t size = 0U; size <= LINK_FRAME_MAX; size++) {
                TEST_ASSERT_EQUAL((size == whole) ? STATUS_OK : STATUS_TRUNCATED,
                                  decode(frame, size, sizes[i], with_crc != 0U));
            }
        }
    }
}

static void every_flipped_bit_is_detected(void)
{
    uint8_t payload[32];
    uint8_t frame[LINK_FRAME_MAX];
    for (size_t i = 0U; i < sizeof payload; i++) {
        payload[i] = draw();
    }
    const size_t whole = rtlink_frame_encode(&header, payload, sizeof payload, true, frame);
    for (size_t first = 0U; first < (8U * whole); first++) {
        frame[first / 8U] ^= (uint8_t)(1U << (first % 8U));
        const status_t one = decode(frame, whole, sizeof payload, true);
        TEST_ASSERT_TRUE((one == STATUS_CHECKSUM) || (one == STATUS_INVALID));
        for (size_t second = 0U; second < first; second++) {
            frame[second / 8U] ^= (uint8_t)(1U << (second % 8U));
            TEST_ASSERT_TRUE(decode(frame, whole, sizeof payload, true) != STATUS_OK);
            frame[second / 8U] ^= (uint8_t)(1U << (second % 8U));
        }
        frame[first / 8U] ^= (uint8_t)(1U << (first % 8U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, decode(frame, whole, sizeof payload, true));
}

static void without_a_checksum_a_changed_bit_is_refused_in_the_fixed_fields_only(void)
{
    const uint8_t payload[4] = {1U, 2U, 3U, 4U};
    uint8_t frame[LINK_FRAME_MAX];
    const size_t whole = rtlink_frame_encode(&header, payload, sizeof payload, false, frame);
    for (size_t bit = 0U; bit < (8U * whole); bit++) {
        const size_t octet  = bit / 8U;
        const bool is_fixed = (octet <= 2U) || (octet == 6U) || (octet == 7U); // Magic, version, flags.
        frame[octet] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_EQUAL(is_fixed ? STATUS_INVALID : STATUS_OK, decode(frame, whole, sizeof payload, false));
        frame[octet] ^= (uint8_t)(1U << (bit % 8U));
    }
}

static void the_epoch_is_read_without_decoding_the_frame(void)
{
    const uint8_t payload[1] = {9U};
    uint8_t frame[LINK_FRAME_MAX];
    const size_t whole = rtlink_frame_encode(&header, payload, sizeof payload, true, frame);
    TEST_ASSERT_EQUAL_HEX32(header.epoch, rtlink_frame_epoch(frame, whole));
    TEST_ASSERT_EQUAL_HEX32(header.epoch, rtlink_frame_epoch(frame, LINK_FRAME_HEADER_OCTETS));
    for (size_t size = 0U; size < LINK_FRAME_HEADER_OCTETS; size++) { // Too short for an epoch.
        TEST_ASSERT_EQUAL_HEX32(0U, rtlink_frame_epoch(frame, size));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_frame_has_the_layout_of_its_header_file);
    RUN_TEST(every_size_of_record_is_read_back);
    RUN_TEST(every_wrong_length_is_refused);
    RUN_TEST(every_flipped_bit_is_detected);
    RUN_TEST(without_a_checksum_a_changed_bit_is_refused_in_the_fixed_fields_only);
    RUN_TEST(the_epoch_is_read_without_decoding_the_frame);
    return UNITY_END();
}
