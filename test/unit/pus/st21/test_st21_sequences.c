// SPDX-License-Identifier: Apache-2.0
#include "pus/st21/st21_sequences.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "test/unit/pus/fixtures/sequenced.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    sequenced_set_up();
}

void tearDown(void)
{
    records_start();
    TEST_ASSERT_EQUAL_UINT(0U, sequenced.file.open);
}

static void delays_separate_the_requests(void)
{
    sequenced_load('a', 1U, 3U);
    sequenced_step(5U * MS);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_sequences_next_ns(&sequenced.service));
    sequenced_command(4U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    sequenced_step(7U * MS); // The first at once.
    EXPECT_RELEASED(1);
    TEST_ASSERT_TRUE(pus_sequences_next_ns(&sequenced.service) <= (17U * MS));
    sequenced_step((17U * MS) - 1000U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    sequenced_step(18U * MS);
    EXPECT_RELEASED(2);
    sequenced_step(27U * MS); // From when it was due, not from when the step came.
    EXPECT_RELEASED(3);
    sequenced_command(4U, 'a'); // The last delay is part of it.
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    sequenced_step(37U * MS);
    TEST_ASSERT_EQUAL_UINT32(1U, sequenced.service.counters.completed);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_sequences_next_ns(&sequenced.service));
    sequenced_command(4U, 'a');
    sequenced_step(40U * MS);
    EXPECT_RELEASED(1);
    sequenced_step(1000U * MS); // A long pause: all that is left, in order.
    EXPECT_RELEASED(2, 3);
}

static void sequences_run_side_by_side(void)
{
    sequenced_load('a', 10U, 2U);
    sequenced_load('b', 20U, 2U);
    sequenced_command(4U, 'b');
    sequenced_command(4U, 'a');
    sequenced_step(MS);
    EXPECT_RELEASED(20, 10);
    sequenced_step(11U * MS);
    EXPECT_RELEASED(20 + 1, 10 + 1);
}

static void a_delay_may_be_nothing_or_long(void)
{
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 3U);
    sequenced_add(1U, 0U, 0);
    sequenced_add(2U, 0U, 0);
    sequenced_add(3U, 0U, (1LL << 55) - 1);
    sequenced_expect_done(1U);
    sequenced_command(4U, 'a');
    sequenced_step(MS);
    EXPECT_RELEASED(1, 2, 3);
    TEST_ASSERT_TRUE(pus_sequences_next_ns(&sequenced.service) > (2147483647ULL * 1000U * MS));
}

static void a_step_releases_so_many_at_most(void)
{
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 200U);
    for (uint16_t i = 0U; i < 200U; i++) {
        sequenced_add(i, 0U, 0);
    }
    sequenced_expect_done(1U);
    sequenced.data[0] = 'b';
    sequenced_expect_done(1U);
    sequenced_command(4U, 'a');
    sequenced_command(4U, 'b');
    sequenced_step(MS);
    TEST_ASSERT_EQUAL_UINT64(PUS_SEQUENCE_RELEASES, released.count);
    sequenced_step(MS);
    TEST_ASSERT_EQUAL_UINT64(400U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, sequenced.service.counters.completed);
}

static void what_the_port_refuses_waits_and_its_delay_too(void)
{
    sequenced_load('a', 1U, 2U);
    sequenced_command(4U, 'a');
    released.accepts  = 0U;
    released.refusals = 2U;
    sequenced_step(10U * MS);
    sequenced_step(20U * MS);
    TEST_ASSERT_EQUAL_UINT32(2U, sequenced.service.counters.deferred);
    sequenced_step(30U * MS);
    EXPECT_RELEASED(1);
    sequenced_step(39U * MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    sequenced_step(40U * MS);
    EXPECT_RELEASED(2);
}

static void a_sequence_is_loaded_whole_or_not_at_all(void)
{
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 2U);
    sequenced_add(1U, 0U, TICKS);
    const uint32_t second = (uint32_t)sequenced.writer.position;
    sequenced_add(2U, 0U, TICKS);
    sequenced.data[second + 12U] ^= 1U;
    sequenced_request(1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, second);
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 1U);
    sequenced_add(1U, 0U, -1);
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 9U + PUS_TC_MIN);
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 1U);
    sequenced_add(1U, (PUS_SEQUENCE_REQUEST_MAX + 1U) - PUS_TC_MIN, TICKS);
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, 9U);
    TEST_ASSERT_EQUAL_UINT16(0U, sequenced.chains.pool.stats.taken);
    sequenced_load('a', 1U, 1U);
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 1U);
    sequenced_add(1U, 0U, TICKS);
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, DETAIL('a'));
    TEST_ASSERT_EQUAL_UINT32(4U, sequenced.service.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(1U, sequenced.service.counters.loaded);
}

static void a_name_is_printable_and_padded(void)
{
    static const char names[][9] = {"", "a\x1f", "a\x7f", "\0b", "a\0b", "\xe4hnlich"};
    for (size_t i = 0U; i < (sizeof(names) / sizeof(names[0])); i++) {
        sequenced_begin('a');
        octet_write_u8(&sequenced.writer, 1U);
        sequenced_add(1U, 0U, TICKS);
        memcpy(sequenced.data, names[i], 8U);
        sequenced_request(1U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    }
    memcpy(sequenced.data, " ~345678", 8U);
    sequenced_expect_done(1U);
}

static void the_room_is_limited(void)
{
    sequenced_start(1U, 2U);
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 1U);
    sequenced_add(1U, 120U, TICKS);
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 2U);
    sequenced_load('a', 1U, 1U);
    sequenced_begin('b');
    octet_write_u8(&sequenced.writer, 1U);
    sequenced_add(1U, 0U, TICKS);
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 1U);
    sequenced_start(SEQUENCES, BLOCKS_HERE);
    sequenced.service.config.octets_max = 20U; // Of N, a request of 13 octets and its delay there are 21.
    sequenced_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 20U);
    sequenced.service.config.octets_max = 21U;
    sequenced_expect_done(1U);
}

static void what_may_not_be_done_is_refused(void)
{
    static const uint8_t by_name[] = {3, 4, 5, 9, 11};
    sequenced_load('a', 1U, 2U);
    for (size_t i = 0U; i < sizeof(by_name); i++) {
        sequenced_command(by_name[i], 'z');
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, DETAIL('z'));
    }
    sequenced_command(5U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    sequenced_command(4U, 'a');
    sequenced_command(3U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    sequenced_command(5U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    sequenced_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    sequenced_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(0U, sequenced.chains.pool.stats.taken);
    sequenced_command(4U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, DETAIL('a'));
}

static void status_and_aborted_are_reported(void)
{
    static const uint8_t statuses[] = {0, 3, 'a', 'q', 0, 0,   0,   0, 0, 0, 1, 'b', 'q', 0, 0,
                                       0, 0, 0,   0,   0, 'c', 'q', 0, 0, 0, 0, 0,   0,   1};
    static const uint8_t aborted[]  = {0, 2, 'a', 'q', 0, 0, 0, 0, 0, 0, 'c', 'q', 0, 0, 0, 0, 0, 0};
    sequenced_load('a', 1U, 2U);
    sequenced_load('b', 1U, 2U);
    sequenced_load('c', 1U, 2U);
    sequenced_command(4U, 'a');
    sequenced_command(4U, 'c');
    sequenced.writer = octet_writer(sequenced.data, sizeof(sequenced.data));
    sequenced_request(6U);
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 7, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof(statuses), bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(statuses, bench_report(2U).data, sizeof(statuses));
    sequenced_request(13U);
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 14, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof(aborted), bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(aborted, bench_report(2U).data, sizeof(aborted));
    sequenced_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, sequenced.service.counters.aborted);
}

static void the_checksum_is_that_of_the_content(void)
{
    for (uint8_t size = 0U; size < 30U; size += 29U) { // Of one piece, and of several.
        sequenced_begin((char)('a' + size));
        octet_write_u8(&sequenced.writer, (uint8_t)(1U + (size / 10U)));
        for (uint16_t i = 0U; i <= (size / 10U); i++) {
            sequenced_add(i, size * 40U, TICKS);
        }
        const uint16_t expected = crc16_ccitt(&sequenced.data[8], sequenced.writer.position - 8U);
        sequenced_expect_done(1U);
        sequenced_command(9U, (char)('a' + size));
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
    sequenced_make_long_file();
    sequenced_reference('a', 2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    sequenced_command(11U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 21, 12, 21, 12, 21, 12, 21, 12);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(2U).size);
    TEST_ASSERT_TRUE(pus_sequences_is_waiting(&sequenced.service));
    sequenced_command(11U, 'a'); // No second one meanwhile, nor an end of the sequence.
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    sequenced_command(3U, 'a');
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, DETAIL('a'));
    sequenced_load('b', 9U, 1U);
    sequenced_command(3U, 'b');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    sequenced_step(MS);
    EXPECT_MESSAGES(21, 12, 1, 7);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL_HEX8('a', octet_read_u8(&reader));
    (void)octet_read_octets(&reader, 7U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    const size_t left = octet_reader_left(&reader);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&sequenced.file.octets[sequenced.file.size - left],
                                 octet_read_octets(&reader, left), left);
    TEST_ASSERT_FALSE(pus_sequences_is_waiting(&sequenced.service));
    sequenced_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void every_request_has_a_strict_shape(void)
{
    static const uint8_t by_name[] = {3, 4, 5, 9, 11};
    uint8_t octets[100];
    sequenced_begin('a');
    octet_write_u8(&sequenced.writer, 2U);
    sequenced_add(1U, 0U, TICKS);
    sequenced_add(2U, 5U, TICKS);
    memcpy(octets, sequenced.data, sequenced.writer.position);
    expect_strict_shape(1U, octets, sequenced.writer.position);
    sequenced.data[8] = 0U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, sequenced.data, 9U));
    static const uint8_t named[] = {'a', 0, 0, 0, 0, 0, 0, 0, 0, 2, '/', 'x', 0, 1, 'y'};
    expect_strict_shape(2U, named, sizeof(named));
    expect_strict_shape(8U, named, sizeof(named));
    for (size_t i = 0U; i < sizeof(by_name); i++) {
        expect_strict_shape(by_name[i], named, 8U);
    }
    expect_strict_shape(6U, named, 0U);
    expect_strict_shape(13U, named, 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(delays_separate_the_requests);
    RUN_TEST(sequences_run_side_by_side);
    RUN_TEST(a_delay_may_be_nothing_or_long);
    RUN_TEST(a_step_releases_so_many_at_most);
    RUN_TEST(what_the_port_refuses_waits_and_its_delay_too);
    RUN_TEST(a_sequence_is_loaded_whole_or_not_at_all);
    RUN_TEST(a_name_is_printable_and_padded);
    RUN_TEST(the_room_is_limited);
    RUN_TEST(what_may_not_be_done_is_refused);
    RUN_TEST(status_and_aborted_are_reported);
    RUN_TEST(the_checksum_is_that_of_the_content);
    RUN_TEST(the_content_is_reported_in_as_many_packets_as_it_needs);
    RUN_TEST(every_request_has_a_strict_shape);
    return UNITY_END();
}
