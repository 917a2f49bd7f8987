// SPDX-License-Identifier: Apache-2.0
// The client reads and writes objects of a segmenting server, which was written for this test after CiA 301,
// and of faulty servers.
//
// First octet of a request: 0x40 upload; 0x2F, 0x2B, 0x27, 0x23 download of 1 to 4 octets. Of an answer:
// 0x4F, 0x4B, 0x47, 0x43 upload of 1 to 4 octets; 0x41, 0x40 upload in segments with and without the size;
// 0x60 downloaded; 0x80 abort.
#include "fsw/canopen/sdo_client.h"

#include "unity.h"

#include <string.h>

#define TIMEOUT_NS 50000000U

static canopen_sdo_client_t client;
static uint8_t request[SDO_FRAME_OCTETS];
static uint64_t now_ns;

void setUp(void)
{
    canopen_sdo_client_init(&client, TIMEOUT_NS);
    now_ns = 1000000U;
    memset(request, 0, sizeof request);
}

void tearDown(void)
{
}

static bool next(void)
{
    now_ns += 500000U;
    return canopen_sdo_client_request(&client, now_ns, request);
}

static void answer(const uint8_t a, const uint8_t b, const uint8_t c, const uint8_t d, const uint8_t e,
                   const uint8_t f, const uint8_t g, const uint8_t h)
{
    const uint8_t octets[8] = {a, b, c, d, e, f, g, h};
    canopen_sdo_client_answer(&client, octets, 8U);
}

static void expect_request(const uint8_t a, const uint8_t b, const uint8_t c, const uint8_t d,
                           const uint8_t e, const uint8_t f, const uint8_t g, const uint8_t h)
{
    const uint8_t octets[8] = {a, b, c, d, e, f, g, h};
    TEST_ASSERT_TRUE(next());
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, request, 8U);
}

static status_t result(void)
{
    return canopen_sdo_client_result(&client, NULL);
}

static void the_client_sends_nothing_without_a_request(void)
{
    TEST_ASSERT_EQUAL(STATUS_EMPTY, result());
    TEST_ASSERT_FALSE(next());
}

static void values_of_1_to_4_octets_are_written_at_once(void)
{
    const uint8_t octets[4]  = {0x11U, 0x22U, 0x33U, 0x44U};
    const uint8_t commands[] = {0x2FU, 0x2BU, 0x27U, 0x23U};
    for (uint8_t size = 1U; size <= 4U; size++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_download(&client, 0x6060U, 0x05U, octets, size));
        expect_request(commands[size - 1U], 0x60U, 0x60U, 0x05U, 0x11U, (size > 1U) ? 0x22U : 0U,
                       (size > 2U) ? 0x33U : 0U, (size > 3U) ? 0x44U : 0U);
        TEST_ASSERT_EQUAL(STATUS_BUSY, result());
        TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_sdo_client_download(&client, 0x6060U, 0x05U, octets, size));
        TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_sdo_client_upload(&client, 0x6060U, 0x05U));
        answer(0x60U, 0x60U, 0x60U, 0x05U, 0U, 0U, 0U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, result());
        TEST_ASSERT_FALSE(next());
    }
    TEST_ASSERT_EQUAL_UINT32(4U, client.counters.transfers);
}

static void expedited_values_of_every_size_are_read(void)
{
    const uint8_t commands[] = {0x4FU, 0x4BU, 0x47U, 0x43U, 0x42U};
    const size_t sizes[]     = {1U, 2U, 3U, 4U, 4U};
    for (unsigned i = 0U; i < 5U; i++) {
        size_t size = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&client, 0x1018U, 1U));
        expect_request(0x40U, 0x18U, 0x10U, 1U, 0U, 0U, 0U, 0U);
        answer(commands[i], 0x18U, 0x10U, 1U, 0xDEU, 0xADU, 0xBEU, 0xEFU);
        TEST_ASSERT_EQUAL(STATUS_OK, result());
        const uint8_t expected[4] = {0xDEU, 0xADU, 0xBEU, 0xEFU};
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, canopen_sdo_client_value(&client, &size), sizes[i]);
        TEST_ASSERT_EQUAL_UINT64(sizes[i], size);
    }
}

/// Act as the server of a segmented download.
static void serve_download(uint8_t* const taken, size_t* const count)
{
    bool toggle = false;
    bool last   = false;
    *count      = 0U;
    while (!last) {
        TEST_ASSERT_TRUE(next());
        TEST_ASSERT_EQUAL_HEX8(0U, request[0] >> 5);
        TEST_ASSERT_EQUAL(toggle, (request[0] & 0x10U) != 0U);
        const size_t part = 7U - ((request[0] >> 1) & 7U);
        for (size_t i = part + 1U; i < 8U; i++) {
            TEST_ASSERT_EQUAL_HEX8(0U, request[i]); // CiA 301: octets without data are 0.
        }
        memcpy(&taken[*count], &request[1], part);
        *count += part;
        last = (request[0] & 1U) != 0U;
        answer(toggle ? 0x30U : 0x20U, 0U, 0U, 0U, 0U, 0U, 0U, 0U);
        toggle = !toggle;
    }
}

static void long_values_are_written_in_segments(void)
{
    uint8_t octets[SDO_OCTETS_MAX];
    for (uint8_t i = 0U; i < SDO_OCTETS_MAX; i++) {
        octets[i] = (uint8_t)(i * 7U);
    }
    for (uint8_t size = 5U; size <= SDO_OCTETS_MAX; size++) {
        uint8_t taken[SDO_OCTETS_MAX + 7U];
        size_t count = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_download(&client, 0x2000U, 2U, octets, size));
        expect_request(0x21U, 0x00U, 0x20U, 2U, size, 0U, 0U, 0U);
        answer(0x60U, 0x00U, 0x20U, 2U, 0U, 0U, 0U, 0U);
        serve_download(taken, &count);
        TEST_ASSERT_EQUAL(STATUS_OK, result());
        TEST_ASSERT_EQUAL_UINT64(size, count);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, taken, size);
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE,
                      canopen_sdo_client_download(&client, 0x2000U, 2U, octets, SDO_OCTETS_MAX + 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_sdo_client_download(&client, 0x2000U, 2U, octets, 0U));
}

/// Act as the server of a segmented upload of `size` octets 0, 1, 2...
static void serve_upload(const size_t size, const bool is_announced)
{
    answer(is_announced ? 0x41U : 0x40U, 0x08U, 0x10U, 0U, is_announced ? (uint8_t)size : 0U, 0U, 0U, 0U);
    bool toggle  = false;
    size_t moved = 0U;
    do {
        TEST_ASSERT_TRUE(next());
        TEST_ASSERT_EQUAL_HEX8(toggle ? 0x70U : 0x60U, request[0]);
        const size_t left = size - moved;
        const size_t part = (left < 7U) ? left : 7U;
        uint8_t octets[8] = {0U};
        octets[0] = (uint8_t)((toggle ? 0x10U : 0U) | ((7U - part) << 1) | ((part == left) ? 1U : 0U));
        for (size_t i = 0U; i < part; i++) {
            octets[1U + i] = (uint8_t)(moved + i);
        }
        moved += part;
        canopen_sdo_client_answer(&client, octets, 8U);
        toggle = !toggle;
    } while (moved < size);
}

static void long_values_are_read_in_segments(void)
{
    for (size_t size = 1U; size <= SDO_OCTETS_MAX; size++) {
        for (unsigned announced = 0U; announced <= 1U; announced++) {
            size_t count = 0U;
            TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&client, 0x1008U, 0U));
            TEST_ASSERT_TRUE(next());
            serve_upload(size, announced == 1U);
            TEST_ASSERT_EQUAL(STATUS_OK, result());
            const uint8_t* const value = canopen_sdo_client_value(&client, &count);
            TEST_ASSERT_EQUAL_UINT64(size, count);
            for (size_t i = 0U; i < size; i++) {
                TEST_ASSERT_EQUAL_HEX8(i, value[i]);
            }
        }
    }
}

static void expect_abort(const uint32_t code)
{
    TEST_ASSERT_TRUE(next());
    TEST_ASSERT_EQUAL_HEX8(0x80U, request[0]);
    TEST_ASSERT_EQUAL_HEX32(code, (uint32_t)request[4] | ((uint32_t)request[5] << 8) |
                                      ((uint32_t)request[6] << 16) | ((uint32_t)request[7] << 24));
    TEST_ASSERT_FALSE(next());
}

static void begin_upload(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&client, 0x1008U, 0U));
    TEST_ASSERT_TRUE(next());
}

static void an_abort_of_the_server_ends_every_phase(void)
{
    uint32_t code           = 0U;
    const uint8_t octets[9] = {0U};
    begin_upload();
    answer(0x80U, 0x08U, 0x10U, 0U, 0x00U, 0x00U, 0x02U, 0x06U);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, canopen_sdo_client_result(&client, &code));
    TEST_ASSERT_EQUAL_HEX32(0x06020000U, code);

    begin_upload();
    answer(0x41U, 0x08U, 0x10U, 0U, 20U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x80U, 0x08U, 0x10U, 0U, 0x00U, 0x00U, 0x00U, 0x08U);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, canopen_sdo_client_result(&client, &code));
    TEST_ASSERT_EQUAL_HEX32(0x08000000U, code);

    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_download(&client, 0x1008U, 0U, octets, 9U));
    TEST_ASSERT_TRUE(next());
    answer(0x60U, 0x08U, 0x10U, 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x80U, 0x08U, 0x10U, 0U, 0x21U, 0x00U, 0x00U, 0x08U);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, canopen_sdo_client_result(&client, &code));
    TEST_ASSERT_EQUAL_HEX32(0x08000021U, code);
    TEST_ASSERT_FALSE(next());
    TEST_ASSERT_EQUAL_UINT32(3U, client.counters.aborted);
}

static void silence_ends_in_a_timeout_and_an_abort(void)
{
    uint32_t code = 0U;
    begin_upload();
    const uint64_t sent_ns = now_ns;
    while (now_ns < (sent_ns + TIMEOUT_NS - 500000U)) {
        TEST_ASSERT_FALSE(next());
        TEST_ASSERT_EQUAL(STATUS_BUSY, result());
    }
    expect_abort(SDO_ABORT_TIMEOUT);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, canopen_sdo_client_result(&client, &code));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_TIMEOUT, code);
    TEST_ASSERT_EQUAL_UINT32(1U, client.counters.timeouts);
    // A late answer has no effect.
    answer(0x4BU, 0x08U, 0x10U, 0U, 1U, 2U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, result());
    TEST_ASSERT_EQUAL_UINT32(1U, client.counters.unasked);
}

static void each_segment_has_its_own_time_out(void)
{
    begin_upload();
    answer(0x41U, 0x08U, 0x10U, 0U, 20U, 0U, 0U, 0U);
    now_ns += TIMEOUT_NS; // The request for the segment has not been fetched yet: its time-out has not begun.
    TEST_ASSERT_TRUE(next());
    TEST_ASSERT_EQUAL(STATUS_BUSY, result());
    now_ns += TIMEOUT_NS;
    expect_abort(SDO_ABORT_TIMEOUT);
}

static void a_wrong_toggle_bit_is_refused_in_uploads_and_downloads(void)
{
    const uint8_t octets[9] = {0U};
    begin_upload();
    answer(0x41U, 0x08U, 0x10U, 0U, 20U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x10U, 1U, 2U, 3U, 4U, 5U, 6U, 7U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, result());
    expect_abort(SDO_ABORT_TOGGLE);

    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_download(&client, 0x1008U, 0U, octets, 9U));
    TEST_ASSERT_TRUE(next());
    answer(0x60U, 0x08U, 0x10U, 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x30U, 0U, 0U, 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, result());
    expect_abort(SDO_ABORT_TOGGLE);
    TEST_ASSERT_EQUAL_UINT32(2U, client.counters.violations);
}

static void an_upload_answer_with_another_command_specifier_is_refused(void)
{
    for (unsigned specifier = 0U; specifier < 8U; specifier++) {
        setUp();
        begin_upload();
        answer((uint8_t)((specifier << 5) | 0x03U), 0x08U, 0x10U, 0U, 0U, 0U, 0U, 0U);
        if (specifier == 2U) {
            TEST_ASSERT_EQUAL(STATUS_OK, result());
        } else if (specifier == 4U) {
            TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, result());
        } else {
            TEST_ASSERT_EQUAL(STATUS_INVALID, result());
            expect_abort(SDO_ABORT_COMMAND);
        }
    }
}

static void a_value_that_is_too_long_is_refused(void)
{
    begin_upload();
    answer(0x41U, 0x08U, 0x10U, 0U, SDO_OCTETS_MAX + 1U, 0U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, result());
    expect_abort(SDO_ABORT_MEMORY);

    begin_upload(); // Without an announced size the capacity of the client's buffer is the limit.
    answer(0x40U, 0x08U, 0x10U, 0U, 0U, 0U, 0U, 0U);
    bool toggle = false;
    while (result() == STATUS_BUSY) {
        TEST_ASSERT_TRUE(next());
        answer(toggle ? 0x10U : 0x00U, 1U, 2U, 3U, 4U, 5U, 6U, 7U);
        toggle = !toggle;
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, result());
    expect_abort(SDO_ABORT_MEMORY);
}

static void a_size_that_disagrees_with_the_content_is_refused(void)
{
    begin_upload(); // The transfer ends early.
    answer(0x41U, 0x08U, 0x10U, 0U, 20U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x01U, 1U, 2U, 3U, 4U, 5U, 6U, 7U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, result());
    expect_abort(SDO_ABORT_LENGTH);

    begin_upload(); // The transfer does not end.
    answer(0x41U, 0x08U, 0x10U, 0U, 7U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x00U, 1U, 2U, 3U, 4U, 5U, 6U, 7U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, result());
    expect_abort(SDO_ABORT_LENGTH);

    begin_upload(); // The transfer makes no progress.
    answer(0x40U, 0x08U, 0x10U, 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_TRUE(next());
    answer(0x0EU, 0U, 0U, 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, result());
    expect_abort(SDO_ABORT_LENGTH);
}

static void answers_without_a_request_and_short_answers_are_counted_and_dropped(void)
{
    answer(0x4BU, 0x08U, 0x10U, 0U, 1U, 2U, 0U, 0U); // A response without a request.
    begin_upload();
    answer(0x4BU, 0x09U, 0x10U, 0U, 1U, 2U, 0U, 0U); // A response about another object.
    answer(0x4BU, 0x08U, 0x10U, 1U, 1U, 2U, 0U, 0U); // A response about another sub-index.
    answer(0x80U, 0x09U, 0x10U, 0U, 0U, 0U, 2U, 6U); // An abort of another access.
    TEST_ASSERT_EQUAL(STATUS_BUSY, result());
    TEST_ASSERT_EQUAL_UINT32(4U, client.counters.unasked);
    for (uint8_t length = 0U; length < 8U; length++) {
        const uint8_t octets[8] = {0x4BU, 0x08U, 0x10U, 0U, 1U, 2U, 0U, 0U};
        canopen_sdo_client_answer(&client, octets, length);
    }
    TEST_ASSERT_EQUAL_UINT32(8U, client.counters.malformed);
    TEST_ASSERT_EQUAL(STATUS_BUSY, result());
    answer(0x4BU, 0x08U, 0x10U, 0U, 1U, 2U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, result());
}

static void random_answers_of_a_server_cause_no_failure(void)
{
    uint32_t seed = 12345U;
    for (unsigned i = 0U; i < 200000U; i++) {
        uint8_t octets[8];
        for (unsigned k = 0U; k < 8U; k++) {
            seed      = (seed * 1664525U) + 1013904223U;
            octets[k] = (uint8_t)(seed >> 24);
        }
        if ((seed & 0x300U) != 0U) { // Most frames are about the requested object.
            octets[1] = 0x08U;
            octets[2] = 0x10U;
            octets[3] = 0U;
        }
        if (result() != STATUS_BUSY) {
            const uint8_t value[SDO_OCTETS_MAX] = {0U};
            const status_t begun =
                ((seed & 0x80U) != 0U)
                    ? canopen_sdo_client_upload(&client, 0x1008U, 0U)
                    : canopen_sdo_client_download(&client, 0x1008U, 0U, value, (seed % 64U) + 1U);
            TEST_ASSERT_EQUAL(STATUS_OK, begun);
        }
        (void)next();
        canopen_sdo_client_answer(&client, octets, (uint8_t)(((seed & 0x1FU) == 0U) ? (seed >> 8) % 9U : 8U));
        size_t size = 0U;
        (void)canopen_sdo_client_value(&client, &size);
        TEST_ASSERT_TRUE(size <= SDO_OCTETS_MAX);
    }
    TEST_ASSERT_TRUE(client.counters.transfers > 100U);
    TEST_ASSERT_TRUE(client.counters.violations > 100U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_client_sends_nothing_without_a_request);
    RUN_TEST(values_of_1_to_4_octets_are_written_at_once);
    RUN_TEST(expedited_values_of_every_size_are_read);
    RUN_TEST(long_values_are_written_in_segments);
    RUN_TEST(long_values_are_read_in_segments);
    RUN_TEST(an_abort_of_the_server_ends_every_phase);
    RUN_TEST(silence_ends_in_a_timeout_and_an_abort);
    RUN_TEST(each_segment_has_its_own_time_out);
    RUN_TEST(a_wrong_toggle_bit_is_refused_in_uploads_and_downloads);
    RUN_TEST(an_upload_answer_with_another_command_specifier_is_refused);
    RUN_TEST(a_value_that_is_too_long_is_refused);
    RUN_TEST(a_size_that_disagrees_with_the_content_is_refused);
    RUN_TEST(answers_without_a_request_and_short_answers_are_counted_and_dropped);
    RUN_TEST(random_answers_of_a_server_cause_no_failure);
    return UNITY_END();
}
