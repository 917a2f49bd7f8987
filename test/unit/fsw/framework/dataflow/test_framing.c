// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/framing.h"

#include "unity.h"

#include <string.h>

#define CAPACITY 8U
#define STREAM 256U

typedef struct {
    uint8_t octets[STREAM];
    size_t size;
} octets_t;

static const flow_format_t formats[] = {
    {.framing = FLOW_FRAMING_LENGTH, .order = FLOW_ORDER_BIG},
    {.framing = FLOW_FRAMING_LENGTH, .order = FLOW_ORDER_LITTLE},
    {.framing = FLOW_FRAMING_SLIP},
    {.framing = FLOW_FRAMING_LINE},
};
#define FORMATS (sizeof formats / sizeof formats[0])

static flow_frame_assembler_t assembler;
static uint8_t buffer[CAPACITY];
static octets_t seen; ///< Each frame as its size followed by its octets.

void setUp(void)
{
}

void tearDown(void)
{
}

static void add(octets_t* const all, const void* const octets, const size_t size)
{
    TEST_ASSERT_TRUE((all->size + size) <= STREAM);
    memcpy(&all->octets[all->size], octets, size);
    all->size += size;
}

static void add_frame(octets_t* const all, const void* const payload, const size_t size)
{
    const uint8_t length = (uint8_t)size;
    add(all, &length, 1U);
    add(all, payload, size);
}

/// Feed octets to the assembler; `seen` gets the frames.
static void feed(const uint8_t* const octets, const size_t size)
{
    size_t used = 0U;
    for (;;) {
        size_t taken   = 0U;
        size_t payload = 0U;
        const status_t status =
            flow_frame_assembler_feed(&assembler, &octets[used], size - used, &taken, &payload);
        used += taken;
        if (status == STATUS_EMPTY) {
            TEST_ASSERT_EQUAL_UINT64(size, used);
            return;
        }
        TEST_ASSERT_EQUAL(STATUS_OK, status);
        add_frame(&seen, buffer, payload);
    }
}

static void begin(const flow_format_t* const format)
{
    seen.size = 0U;
    flow_frame_assembler_init(&assembler, format, buffer, CAPACITY);
}

static void put(octets_t* const stream, const flow_format_t* const format, const void* const payload,
                const size_t size)
{
    size_t octets = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_frame_encode(format, payload, size, &stream->octets[stream->size],
                                                   STREAM - stream->size, &octets));
    stream->size += octets;
}

static void frames_have_the_documented_octets(void)
{
    static const struct {
        flow_format_t format;
        const char* octets;
        size_t size;
    } cases[] = {
        {{.framing = FLOW_FRAMING_RAW}, "a\300\333", 3U},
        {{.framing = FLOW_FRAMING_LENGTH, .order = FLOW_ORDER_BIG}, "\000\003a\300\333", 5U},
        {{.framing = FLOW_FRAMING_LENGTH, .order = FLOW_ORDER_LITTLE}, "\003\000a\300\333", 5U},
        {{.framing = FLOW_FRAMING_SLIP}, "\300a\333\334\333\335\300", 7U},
        {{.framing = FLOW_FRAMING_LINE}, "a\300\333\n", 4U},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        octets_t stream = {.size = 0U};
        put(&stream, &cases[i].format, "a\300\333", 3U);
        TEST_ASSERT_EQUAL_UINT64(cases[i].size, stream.size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].octets, stream.octets, stream.size);
        for (size_t capacity = 0U; capacity < cases[i].size; capacity++) {
            size_t size = 1U;
            TEST_ASSERT_EQUAL(STATUS_FULL, flow_frame_encode(&cases[i].format, (const uint8_t*)"a\300\333",
                                                             3U, stream.octets, capacity, &size));
            TEST_ASSERT_EQUAL_UINT64(0U, size);
        }
    }
}

/// The stream is divided at every pair of positions, and into single octets.
static void frames_are_found_wherever_the_stream_is_divided(void)
{
    for (size_t f = 0U; f < FORMATS; f++) {
        octets_t stream   = {.size = 0U};
        octets_t expected = {.size = 0U};
        static const struct {
            const char* payload;
            size_t size;
        } payloads[] = {{"one", 3U}, {"x", 1U}, {"\300\333\334\335", 4U}, {"12345678", 8U}};
        for (size_t i = 0U; i < 4U; i++) {
            put(&stream, &formats[f], payloads[i].payload, payloads[i].size);
            add_frame(&expected, payloads[i].payload, payloads[i].size);
        }
        for (size_t first = 0U; first <= stream.size; first++) {
            for (size_t second = first; second <= stream.size; second++) {
                begin(&formats[f]);
                feed(stream.octets, first);
                feed(&stream.octets[first], second - first);
                feed(&stream.octets[second], stream.size - second);
                TEST_ASSERT_EQUAL_UINT64(expected.size, seen.size);
                TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, seen.size);
                TEST_ASSERT_EQUAL_UINT32(4U, assembler.counters.complete);
            }
        }
        begin(&formats[f]);
        for (size_t i = 0U; i < stream.size; i++) {
            feed(&stream.octets[i], 1U);
        }
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, expected.size);
    }
}

static void frames_that_are_too_long_are_skipped(void)
{
    for (size_t f = 0U; f < FORMATS; f++) {
        octets_t stream   = {.size = 0U};
        octets_t expected = {.size = 0U};
        put(&stream, &formats[f], "first", 5U);
        put(&stream, &formats[f], "123456789", CAPACITY + 1U);
        put(&stream, &formats[f], "a very long one that does not fit at all", 40U);
        put(&stream, &formats[f], "last", 4U);
        add_frame(&expected, "first", 5U);
        add_frame(&expected, "last", 4U);
        for (size_t piece = 1U; piece <= stream.size; piece++) {
            begin(&formats[f]);
            for (size_t i = 0U; i < stream.size; i += piece) {
                feed(&stream.octets[i], ((stream.size - i) < piece) ? (stream.size - i) : piece);
            }
            TEST_ASSERT_EQUAL_UINT64(expected.size, seen.size);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, seen.size);
            TEST_ASSERT_EQUAL_UINT32(2U, assembler.counters.oversize);
        }
    }
}

static void slip_recovers_from_invalid_octets(void)
{
    octets_t expected = {.size = 0U};
    begin(&formats[2]);
    // "noise" counts as a frame: a reader that starts within a stream cannot distinguish it from one.
    feed((const uint8_t*)"noise\300\300\300", 8U);
    feed((const uint8_t*)"a\333xb\300good\300", 10U); // A wrong escape sequence.
    feed((const uint8_t*)"a\333\300good\300", 8U);    // An end octet after the escape octet.
    // A frame that is too long and has a wrong escape sequence is counted once.
    feed((const uint8_t*)"123456789\333x\300ok\300", 15U);
    add_frame(&expected, "noise", 5U);
    add_frame(&expected, "good", 4U);
    add_frame(&expected, "good", 4U);
    add_frame(&expected, "ok", 2U);
    TEST_ASSERT_EQUAL_UINT64(expected.size, seen.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, seen.size);
    TEST_ASSERT_EQUAL_UINT32(2U, assembler.counters.malformed);
    TEST_ASSERT_EQUAL_UINT32(1U, assembler.counters.oversize);
}

static void lines_end_with_lf_or_cr_lf(void)
{
    octets_t expected = {.size = 0U};
    size_t size       = 0U;
    uint8_t octets[8];
    begin(&formats[3]);
    feed((const uint8_t*)"one\ntwo\r\n\n\r\na\rb\r\r\n", 18U);
    add_frame(&expected, "one", 3U);
    add_frame(&expected, "two", 3U);
    add_frame(&expected, "", 0U);
    add_frame(&expected, "", 0U);
    add_frame(&expected, "a\rb\r", 4U);
    TEST_ASSERT_EQUAL_UINT64(expected.size, seen.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, seen.size);
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_frame_encode(&formats[3], (const uint8_t*)"a\nb", 3U, octets,
                                                        sizeof octets, &size));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_frame_encode(&formats[3], (const uint8_t*)"a\r", 2U, octets,
                                                        sizeof octets, &size));
}

static void lengths_from_zero_to_the_maximum_are_accepted(void)
{
    static uint8_t payload[FRAMING_LENGTH_MAX + 1U];
    static uint8_t octets[FRAMING_LENGTH_MAX + 8U];
    static uint8_t large[FRAMING_LENGTH_MAX];
    for (size_t f = 0U; f < 2U; f++) {
        size_t size = 0U;
        size_t held = 0U;
        begin(&formats[f]);
        feed((const uint8_t*)"\000\000", 2U);
        TEST_ASSERT_EQUAL_UINT64(1U, seen.size); // A frame without octets.
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, flow_frame_encode(&formats[f], payload, FRAMING_LENGTH_MAX + 1U,
                                                              octets, sizeof octets, &size));
        memset(payload, 0x5A, sizeof payload);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_frame_encode(&formats[f], payload, FRAMING_LENGTH_MAX, octets,
                                                       sizeof octets, &size));
        flow_frame_assembler_init(&assembler, &formats[f], large, sizeof large);
        size_t taken = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, flow_frame_assembler_feed(&assembler, octets, size, &taken, &held));
        TEST_ASSERT_EQUAL_UINT64(size, taken);
        TEST_ASSERT_EQUAL_UINT64(FRAMING_LENGTH_MAX, held);
        TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, large, held);
    }
}

static void raw_octets_are_passed_on_unchanged(void)
{
    static const flow_format_t raw = {.framing = FLOW_FRAMING_RAW};
    octets_t expected              = {.size = 0U};
    uint8_t octets[4];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_FULL, flow_frame_encode(&raw, (const uint8_t*)"01234", 5U, octets, 4U, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_frame_encode(&raw, (const uint8_t*)"0123", 4U, octets, 4U, &size));
    TEST_ASSERT_EQUAL_UINT64(4U, size);
    begin(&raw);
    feed((const uint8_t*)"0123456789", 10U);
    feed(NULL, 0U);
    add_frame(&expected, "01234567", 8U);
    add_frame(&expected, "89", 2U);
    TEST_ASSERT_EQUAL_UINT32(2U, assembler.counters.complete);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, expected.size);
}

static void the_end_of_a_stream_discards_its_incomplete_frame(void)
{
    for (size_t f = 0U; f < FORMATS; f++) {
        octets_t stream   = {.size = 0U};
        octets_t expected = {.size = 0U};
        put(&stream, &formats[f], "abc\333", 4U);
        add_frame(&expected, "abc\333", 4U);
        const size_t before = (stream.octets[0] == 0300U) ? 1U : 0U; // An end octet does not begin a frame.
        for (size_t cut = 0U; cut < stream.size; cut++) {
            begin(&formats[f]);
            feed(stream.octets, cut);
            flow_frame_assembler_reset(&assembler);
            feed(stream.octets, stream.size);
            TEST_ASSERT_EQUAL_UINT64(expected.size, seen.size);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(expected.octets, seen.octets, seen.size);
            TEST_ASSERT_EQUAL_UINT32((cut > before) ? 1U : 0U, assembler.counters.cut);
        }
        TEST_ASSERT_EQUAL_UINT32(1U, assembler.counters.cut);
        flow_frame_assembler_reset(&assembler); // After a complete frame no octet is discarded.
        TEST_ASSERT_EQUAL_UINT32(1U, assembler.counters.cut);
    }
}

/// For any input, a frame never has more octets than fit, and the next frame after an end octet is found.
static void the_next_frame_after_random_octets_is_found(void)
{
    uint32_t random = 12345U;
    begin(&formats[2]);
    for (unsigned round = 0U; round < 20000U; round++) {
        uint8_t noise[16];
        for (size_t i = 0U; i < sizeof noise; i++) {
            random = (random * 1664525U) + 1013904223U;
            // A quarter of the octets are from 0xC0 to 0xDF, so that END, ESC and wrong escapes are frequent.
            noise[i] = ((random >> 28U) < 4U) ? (uint8_t)(0xC0U + ((random >> 24U) % 0x20U))
                                              : (uint8_t)(random >> 16U);
        }
        seen.size = 0U;
        feed(noise, sizeof noise);
    }
    feed((const uint8_t*)"\300", 1U);
    seen.size = 0U;
    feed((const uint8_t*)"ok\300", 3U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\002ok", seen.octets, 3U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(frames_have_the_documented_octets);
    RUN_TEST(frames_are_found_wherever_the_stream_is_divided);
    RUN_TEST(frames_that_are_too_long_are_skipped);
    RUN_TEST(slip_recovers_from_invalid_octets);
    RUN_TEST(lines_end_with_lf_or_cr_lf);
    RUN_TEST(lengths_from_zero_to_the_maximum_are_accepted);
    RUN_TEST(raw_octets_are_passed_on_unchanged);
    RUN_TEST(the_end_of_a_stream_discards_its_incomplete_frame);
    RUN_TEST(the_next_frame_after_random_octets_is_found);
    return UNITY_END();
}
