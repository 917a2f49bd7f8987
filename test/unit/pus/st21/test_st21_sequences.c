// SPDX-License-Identifier: Apache-2.0
// Loading, execution and reports of request sequences. The numbers of requests and reports are subtypes;
// pus/catalogue/st21_sequences.txt has their names and fields.
#include "pus/st21/st21_sequences.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "test/unit/pus/fixtures/st21_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    st21_fixture_set_up();
}

void tearDown(void)
{
    records_start();
    TEST_ASSERT_EQUAL_UINT(0U, st21_fixture.file.open);
}

static void delays_separate_the_requests(void)
{
    st21_fixture_load('a', 1U, 3U);
    st21_fixture_step(5U * MS);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_sequences_next_ns(&st21_fixture.service));
    st21_fixture_command(4U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    st21_fixture_step(7U * MS); // The first request is released at once.
    EXPECT_RELEASED(1);
    TEST_ASSERT_TRUE(pus_sequences_next_ns(&st21_fixture.service) <= (17U * MS));
    st21_fixture_step((17U * MS) - 1000U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_step(18U * MS);
    EXPECT_RELEASED(2);
    st21_fixture_step(27U * MS); // The delay is counted from the due time, not from the step.
    EXPECT_RELEASED(3);
    st21_fixture_command(4U, 'a'); // During the last delay the sequence is still executing.
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    st21_fixture_step(37U * MS);
    TEST_ASSERT_EQUAL_UINT32(1U, st21_fixture.service.counters.completed);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_sequences_next_ns(&st21_fixture.service));
    st21_fixture_command(4U, 'a');
    st21_fixture_step(40U * MS);
    EXPECT_RELEASED(1);
    st21_fixture_step(1000U * MS); // After a long pause all remaining requests are released in order.
    EXPECT_RELEASED(2, 3);
}

static void sequences_run_concurrently(void)
{
    st21_fixture_load('a', 10U, 2U);
    st21_fixture_load('b', 20U, 2U);
    st21_fixture_command(4U, 'b');
    st21_fixture_command(4U, 'a');
    st21_fixture_step(MS);
    EXPECT_RELEASED(20, 10);
    st21_fixture_step(11U * MS);
    EXPECT_RELEASED(20 + 1, 10 + 1);
}

static void a_delay_may_be_zero_or_long(void)
{
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 3U);
    st21_fixture_add(1U, 0U, 0);
    st21_fixture_add(2U, 0U, 0);
    st21_fixture_add(3U, 0U, (1LL << 55) - 1);
    st21_fixture_expect_done(1U);
    st21_fixture_command(4U, 'a');
    st21_fixture_step(MS);
    EXPECT_RELEASED(1, 2, 3);
    TEST_ASSERT_TRUE(pus_sequences_next_ns(&st21_fixture.service) > (2147483647ULL * 1000U * MS));
}

static void a_step_releases_a_limited_number_of_requests(void)
{
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 200U);
    for (uint16_t i = 0U; i < 200U; i++) {
        st21_fixture_add(i, 0U, 0);
    }
    st21_fixture_expect_done(1U);
    st21_fixture.data[0] = 'b';
    st21_fixture_expect_done(1U);
    st21_fixture_command(4U, 'a');
    st21_fixture_command(4U, 'b');
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(PUS_SEQUENCE_RELEASES, released.count);
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(400U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, st21_fixture.service.counters.completed);
}

static void a_request_that_the_port_refuses_waits_and_its_delay_begins_later(void)
{
    st21_fixture_load('a', 1U, 2U);
    st21_fixture_command(4U, 'a');
    released.accepts  = 0U;
    released.refusals = 2U;
    st21_fixture_step(10U * MS);
    st21_fixture_step(20U * MS);
    TEST_ASSERT_EQUAL_UINT32(2U, st21_fixture.service.counters.deferred);
    st21_fixture_step(30U * MS);
    EXPECT_RELEASED(1);
    st21_fixture_step(39U * MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_step(40U * MS);
    EXPECT_RELEASED(2);
}

/// After a request that the port refused, the delay counts from its release, not from its due time.
static void a_later_request_that_waits_delays_the_next_one(void)
{
    st21_fixture_load('a', 1U, 3U);
    st21_fixture_command(4U, 'a');
    released.accepts  = 1U;
    released.refusals = 2U;
    st21_fixture_step(10U * MS);
    EXPECT_RELEASED(1);
    st21_fixture_step(20U * MS);
    st21_fixture_step(25U * MS);
    TEST_ASSERT_EQUAL_UINT32(2U, st21_fixture.service.counters.deferred);
    st21_fixture_step(30U * MS);
    EXPECT_RELEASED(2);
    st21_fixture_step(39U * MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_step(40U * MS);
    EXPECT_RELEASED(3);
}

static void a_sequence_is_loaded_completely_or_refused(void)
{
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 2U);
    st21_fixture_add(1U, 0U, TICKS);
    const uint32_t second = (uint32_t)st21_fixture.writer.position;
    st21_fixture_add(2U, 0U, TICKS);
    st21_fixture.data[second + 12U] ^= 1U;
    st21_fixture_request(1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, second);
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 0U, TICKS);
    request_forge(&st21_fixture.data[9]);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, 9U);
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 0U, -1);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 9U + PUS_TC_MIN);
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, (PUS_SEQUENCE_REQUEST_MAX + 1U) - PUS_TC_MIN, TICKS);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, 9U);
    TEST_ASSERT_EQUAL_UINT16(0U, st21_fixture.chains.pool.stats.taken);
    st21_fixture_load('a', 1U, 1U);
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 0U, TICKS);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, DETAIL('a'));
    TEST_ASSERT_EQUAL_UINT32(5U, st21_fixture.service.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(1U, st21_fixture.service.counters.loaded);
}

static void a_name_is_printable_and_padded(void)
{
    static const char names[][9] = {"", "a\x1f", "a\x7f", "\0b", "a\0b", "\xe4hnlich"};
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        st21_fixture_begin('a');
        octet_write_u8(&st21_fixture.writer, 1U);
        st21_fixture_add(1U, 0U, TICKS);
        memcpy(st21_fixture.data, names[i], 8U);
        st21_fixture_request(1U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    }
    memcpy(st21_fixture.data, " ~345678", 8U);
    st21_fixture_expect_done(1U);
}

static void sequences_beyond_the_table_or_the_blocks_are_refused(void)
{
    st21_fixture_start(1U, 2U);
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 120U, TICKS);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 2U);
    st21_fixture_load('a', 1U, 1U);
    st21_fixture_begin('b');
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 0U, TICKS);
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 1U);
    st21_fixture_start(SEQUENCES, SEQUENCE_BLOCKS);
    st21_fixture.service.config.octets_max = 20U; // The content has 21: N, a request (13), a delay (7).
    st21_fixture_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 20U);
    st21_fixture.service.config.octets_max = 21U;
    st21_fixture_expect_done(1U);
}

static void requests_in_a_wrong_state_or_for_an_unknown_sequence_are_refused(void)
{
    static const uint8_t by_name[] = {3, 4, 5, 9, 11};
    st21_fixture_load('a', 1U, 2U);
    for (size_t i = 0U; i < sizeof by_name; i++) {
        st21_fixture_command(by_name[i], 'z');
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, DETAIL('z'));
    }
    st21_fixture_command(5U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    st21_fixture_command(4U, 'a');
    st21_fixture_command(3U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    st21_fixture_command(5U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(0U, st21_fixture.chains.pool.stats.taken);
    st21_fixture_command(4U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, DETAIL('a'));
}

static void the_status_and_the_aborted_sequences_are_reported(void)
{
    // Names of 8 octets; status 1: under execution.
    static const uint8_t statuses[] = {0, 3, 'a', 'q', 0, 0,   0,   0, 0, 0, 1, 'b', 'q', 0, 0,
                                       0, 0, 0,   0,   0, 'c', 'q', 0, 0, 0, 0, 0,   0,   1};
    static const uint8_t aborted[]  = {0, 2, 'a', 'q', 0, 0, 0, 0, 0, 0, 'c', 'q', 0, 0, 0, 0, 0, 0};
    st21_fixture_load('a', 1U, 2U);
    st21_fixture_load('b', 1U, 2U);
    st21_fixture_load('c', 1U, 2U);
    st21_fixture_command(4U, 'a');
    st21_fixture_command(4U, 'c');
    st21_fixture.writer = octet_writer(st21_fixture.data, sizeof st21_fixture.data);
    st21_fixture_request(6U);
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 7, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof statuses, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(statuses, bench_report(2U).data, sizeof statuses);
    st21_fixture_request(13U);
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 14, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof aborted, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(aborted, bench_report(2U).data, sizeof aborted);
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, st21_fixture.service.counters.aborted);
}

static void the_checksum_is_that_of_the_content(void)
{
    for (uint8_t size = 0U; size < 30U; size += 29U) { // A sequence of one part, then of several.
        st21_fixture_begin((char)('a' + size));
        octet_write_u8(&st21_fixture.writer, (uint8_t)(1U + (size / 10U)));
        for (uint16_t i = 0U; i <= (size / 10U); i++) {
            st21_fixture_add(i, size * 40U, TICKS);
        }
        const uint16_t expected = crc16_ccitt(&st21_fixture.data[8], st21_fixture.writer.position - 8U);
        st21_fixture_expect_done(1U);
        st21_fixture_command(9U, (char)('a' + size));
        EXPECT_MESSAGES(1, 1, 1, 3, 21, 10, 1, 7);
        octet_reader_t reader = bench_data(2U);
        TEST_ASSERT_EQUAL_HEX8('a' + size, octet_read_u8(&reader));
        (void)octet_read_octets(&reader, 7U);
        TEST_ASSERT_EQUAL_HEX16(expected, octet_read_u16(&reader));
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
}

static void the_content_is_reported_in_as_many_packets_as_it_needs(void)
{
    st21_fixture_make_long_file();
    st21_fixture_reference('a', 2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    st21_fixture_command(11U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 12, 21, 12, 21, 12, 21, 12);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(2U).size);
    TEST_ASSERT_TRUE(pus_sequences_is_waiting(&st21_fixture.service));
    // During the report no second one is accepted, and the sequence cannot be unloaded.
    st21_fixture_command(11U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    st21_fixture_command(3U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    st21_fixture_load('b', 9U, 1U);
    st21_fixture_command(3U, 'b');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    st21_fixture_step(MS);
    EXPECT_MESSAGES(21, 12, 1, 7);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL_HEX8('a', octet_read_u8(&reader));
    (void)octet_read_octets(&reader, 7U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    const size_t left = octet_reader_left(&reader);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&st21_fixture.file.octets[st21_fixture.file.size - left],
                                 octet_read_octets(&reader, left), left);
    TEST_ASSERT_FALSE(pus_sequences_is_waiting(&st21_fixture.service));
    st21_fixture_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t by_name[] = {3, 4, 5, 9, 11};
    uint8_t octets[100];
    st21_fixture_begin('a');
    octet_write_u8(&st21_fixture.writer, 2U);
    st21_fixture_add(1U, 0U, TICKS);
    st21_fixture_add(2U, 5U, TICKS);
    memcpy(octets, st21_fixture.data, st21_fixture.writer.position);
    expect_strict_format(1U, octets, st21_fixture.writer.position);
    st21_fixture.data[8] = 0U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, st21_fixture.data, 9U));
    static const uint8_t named[] = {'a', 0, 0, 0, 0, 0, 0, 0, 0, 2, '/', 'x', 0, 1, 'y'};
    expect_strict_format(2U, named, sizeof named);
    expect_strict_format(8U, named, sizeof named);
    for (size_t i = 0U; i < sizeof by_name; i++) {
        expect_strict_format(by_name[i], named, 8U);
    }
    expect_strict_format(6U, named, 0U);
    expect_strict_format(13U, named, 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(delays_separate_the_requests);
    RUN_TEST(sequences_run_concurrently);
    RUN_TEST(a_delay_may_be_zero_or_long);
    RUN_TEST(a_step_releases_a_limited_number_of_requests);
    RUN_TEST(a_request_that_the_port_refuses_waits_and_its_delay_begins_later);
    RUN_TEST(a_later_request_that_waits_delays_the_next_one);
    RUN_TEST(a_sequence_is_loaded_completely_or_refused);
    RUN_TEST(a_name_is_printable_and_padded);
    RUN_TEST(sequences_beyond_the_table_or_the_blocks_are_refused);
    RUN_TEST(requests_in_a_wrong_state_or_for_an_unknown_sequence_are_refused);
    RUN_TEST(the_status_and_the_aborted_sequences_are_reported);
    RUN_TEST(the_checksum_is_that_of_the_content);
    RUN_TEST(the_content_is_reported_in_as_many_packets_as_it_needs);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
