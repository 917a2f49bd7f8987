// SPDX-License-Identifier: Apache-2.0
// Frames in a stream at the end of the device, compared with the octets of the flight software.
#include "sim/devices/stream_frame.h"

#include "unity.h"

#include <string.h>

#define HELD_MAX 512U

static uint8_t octets[HELD_MAX];
static size_t held;
static uint8_t message[STREAM_FRAME_MESSAGE_MAX];
static size_t size;

void setUp(void)
{
    held = 0U;
}

void tearDown(void)
{
}

static void put(const uint8_t* const more, const size_t count)
{
    memcpy(&octets[held], more, count);
    held += count;
}

static void frames_equal_those_of_the_flight_software(void)
{
    static const uint8_t payload[] = {1U, 0xC0U, 0xDBU};
    static const uint8_t big[]     = {0U, 3U, 1U, 0xC0U, 0xDBU};
    static const uint8_t little[]  = {3U, 0U, 1U, 0xC0U, 0xDBU};
    static const uint8_t slip[]    = {0xC0U, 1U, 0xDBU, 0xDCU, 0xDBU, 0xDDU, 0xC0U};
    static const struct {
        stream_framing_t framing;
        const uint8_t* frame;
        size_t size;
    } cases[] = {{{.is_slip = false, .is_little = false}, big, sizeof big},
                 {{.is_slip = false, .is_little = true}, little, sizeof little},
                 {{.is_slip = true, .is_little = false}, slip, sizeof slip}};
    for (size_t i = 0U; i < 3U; i++) {
        uint8_t frame[STREAM_FRAME_OCTETS(STREAM_FRAME_MESSAGE_MAX)];
        TEST_ASSERT_EQUAL_UINT64(cases[i].size,
                                 stream_frame_put(&cases[i].framing, payload, sizeof payload, frame));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].frame, frame, cases[i].size);
        for (size_t k = 0U; k < cases[i].size; k++) { // Octet by octet.
            TEST_ASSERT_FALSE(stream_frame_take(&cases[i].framing, octets, &held, message, &size));
            put(&frame[k], 1U);
        }
        TEST_ASSERT_TRUE(stream_frame_take(&cases[i].framing, octets, &held, message, &size));
        TEST_ASSERT_EQUAL_UINT64(sizeof payload, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(payload, message, sizeof payload);
        TEST_ASSERT_EQUAL_UINT64(0U, held);
    }
}

static void octets_that_are_not_a_frame_are_dropped(void)
{
    static const stream_framing_t length = {.is_slip = false, .is_little = false};
    static const stream_framing_t slip   = {.is_slip = true, .is_little = false};
    static const uint8_t monster[]       = {0xFFU, 0xFFU, 1U}; // Its length field is impossible.
    static const uint8_t good[]          = {0xC0U, 7U, 0xC0U};
    uint8_t noise[200];
    memset(noise, 0x55, sizeof noise);
    put(monster, sizeof monster);
    TEST_ASSERT_FALSE(stream_frame_take(&length, octets, &held, message, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, held);
    put(noise, sizeof noise);
    TEST_ASSERT_FALSE(stream_frame_take(&slip, octets, &held, message, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, held);
    put(good, sizeof good);
    TEST_ASSERT_TRUE(stream_frame_take(&slip, octets, &held, message, &size));
    TEST_ASSERT_EQUAL_UINT64(1U, size);
    put(noise, 100U);
    // The END before the frame ends the noise, which is truncated to the longest message.
    put(good, sizeof good);
    TEST_ASSERT_TRUE(stream_frame_take(&slip, octets, &held, message, &size));
    TEST_ASSERT_EQUAL_UINT64(STREAM_FRAME_MESSAGE_MAX, size);
    TEST_ASSERT_TRUE(stream_frame_take(&slip, octets, &held, message, &size));
    TEST_ASSERT_EQUAL_HEX8(7U, message[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(frames_equal_those_of_the_flight_software);
    RUN_TEST(octets_that_are_not_a_frame_are_dropped);
    return UNITY_END();
}
