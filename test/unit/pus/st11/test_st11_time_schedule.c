// SPDX-License-Identifier: Apache-2.0
// Insertion and release of activities, limits of the schedule, and jumps of time. The numbers of requests and
// reports are subtypes; pus/catalogue/st11_time_schedule.txt has their names and fields.
#include "pus/st11/st11_time_schedule.h"

#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "test/unit/pus/fixtures/st11_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    st11_fixture_set_up();
}

void tearDown(void)
{
    records_start();
}

static void an_activity_is_released_at_its_time(void)
{
    st11_fixture_enable_all();
    st11_fixture_insert(SS, G, (2U * S) + (3U * MS), 1U);
    st11_fixture_insert(SS, G, (2U * S) + (2U * MS), 2U);
    st11_fixture_insert(SS, G, (2U * S) + (2U * MS), 3U);
    TEST_ASSERT_TRUE(pus_time_schedule_next_ns(&st11_fixture.schedule) >= ((2U * S) + (2U * MS) - 60U));
    TEST_ASSERT_TRUE(pus_time_schedule_next_ns(&st11_fixture.schedule) <= ((2U * S) + (2U * MS)));
    pus_time_schedule_step(&st11_fixture.schedule, (2U * S) + (1U * MS));
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    pus_time_schedule_step(&st11_fixture.schedule, (2U * S) + (2U * MS));
    EXPECT_RELEASED(2, 3);
    pus_time_schedule_step(&st11_fixture.schedule, pus_time_schedule_next_ns(&st11_fixture.schedule) - 1U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    pus_time_schedule_step(&st11_fixture.schedule, pus_time_schedule_next_ns(&st11_fixture.schedule));
    EXPECT_RELEASED(1);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_time_schedule_next_ns(&st11_fixture.schedule));
    TEST_ASSERT_EQUAL_UINT32(3U, st11_fixture.schedule.schedule.counters.released);
    TEST_ASSERT_EQUAL_UINT32(0U, st11_fixture.schedule.schedule.count);
}

static void activities_due_while_disabled_are_deleted_and_counted(void)
{
    static const uint8_t ss[] = {SS};
    static const uint8_t g[]  = {G};
    st11_fixture_enable_all();
    st11_fixture_insert(SS, G, 3U * S, 1U);
    st11_fixture_insert(SS, G, 4U * S, 2U);
    st11_fixture_insert(SS, G, 5U * S, 3U);
    st11_fixture_insert(SS, G, 6U * S, 4U);
    st11_fixture_command(2U);
    pus_time_schedule_step(&st11_fixture.schedule, 3U * S);
    st11_fixture_command(1U);
    st11_fixture_command_ids(21U, 1U, ss);
    pus_time_schedule_step(&st11_fixture.schedule, 4U * S);
    st11_fixture_command_ids(20U, 1U, ss);
    st11_fixture_command_ids(25U, 1U, g);
    pus_time_schedule_step(&st11_fixture.schedule, 5U * S);
    st11_fixture_command_ids(24U, 1U, g);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    TEST_ASSERT_EQUAL_UINT32(3U, st11_fixture.schedule.schedule.counters.dropped);
    pus_time_schedule_step(&st11_fixture.schedule, 6U * S);
    EXPECT_RELEASED(4);
    st11_fixture_expect_empty();
}

static void a_sub_schedule_begins_disabled_with_its_first_activity(void)
{
    static const uint8_t expected[] = {0, 2, 3, 0, SS, 0};
    st11_fixture_command(1U);
    st11_fixture_create_group(G, 1U);
    st11_fixture_insert(SS, G, 2U * S, 1U);
    st11_fixture_insert(3U, G, 2U * S, 2U);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(18U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 19, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    TEST_ASSERT_EQUAL_UINT32(2U, st11_fixture.schedule.schedule.counters.dropped);
}

static void jumps_of_time_release_each_activity_once(void)
{
    st11_fixture_enable_all();
    for (uint16_t i = 0U; i < 300U; i++) { // More activities than a step may release.
        st11_fixture_insert(SS, G, (2U * S) + ((300U - i) * S), i);
    }
    pus_time_schedule_step(&st11_fixture.schedule, (2U * S) + (100U * S));
    TEST_ASSERT_EQUAL_UINT64(100U, released.count);
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S); // The clock goes back: nothing is released again.
    TEST_ASSERT_EQUAL_UINT64(100U, released.count);
    pus_time_schedule_step(&st11_fixture.schedule, 102U * S);
    TEST_ASSERT_EQUAL_UINT64(100U, released.count);
    // The clock goes forward: all remaining activities are released once, in order.
    pus_time_schedule_step(&st11_fixture.schedule, 100000U * S);
    TEST_ASSERT_EQUAL_UINT64(300U, released.count);
    for (uint16_t i = 0U; i < 300U; i++) {
        TEST_ASSERT_EQUAL_UINT16(299U - i, released.ids[i].sequence);
    }
    pus_time_schedule_step(&st11_fixture.schedule, 200000U * S);
    TEST_ASSERT_EQUAL_UINT64(300U, released.count);
}

static void a_step_releases_a_batch_at_most(void)
{
    st11_fixture_enable_all();
    for (uint16_t i = 0U; i <= PUS_SCHEDULE_BATCH; i++) {
        st11_fixture_insert(SS, G, 2U * S, i);
    }
    pus_time_schedule_step(&st11_fixture.schedule, 3U * S);
    TEST_ASSERT_EQUAL_UINT64(PUS_SCHEDULE_BATCH, released.count);
    TEST_ASSERT_TRUE(pus_time_schedule_next_ns(&st11_fixture.schedule) < (3U * S));
    pus_time_schedule_step(&st11_fixture.schedule, 3U * S);
    TEST_ASSERT_EQUAL_UINT64(PUS_SCHEDULE_BATCH + 1U, released.count);
}

static void requests_that_the_port_refuses_are_released_later_in_order(void)
{
    st11_fixture_enable_all();
    for (uint16_t i = 0U; i < 4U; i++) {
        st11_fixture_insert(SS, G, 2U * S, i);
    }
    released.accepts  = 2U;
    released.refusals = 2U;
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    TEST_ASSERT_EQUAL_UINT64(2U, released.count);
    TEST_ASSERT_TRUE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
    st11_fixture_insert(SS, G, (2U * S) + MS, 4U);
    pus_time_schedule_step(&st11_fixture.schedule, (2U * S) + MS);
    TEST_ASSERT_EQUAL_UINT64(2U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, st11_fixture.schedule.schedule.counters.deferred);
    pus_time_schedule_step(&st11_fixture.schedule, (2U * S) + MS);
    EXPECT_RELEASED(0, 1, 2, 3, 4);
    TEST_ASSERT_FALSE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
}

static void each_instruction_of_an_insertion_is_refused_alone(void)
{
    st11_fixture_enable_all();
    st11_fixture_begin_insert(SS, 9U);
    st11_fixture_add(G, 2U * S, 1U, 10U);
    st11_fixture_add(G + 1U, 2U * S, 2U, 10U);         // The group is unknown.
    st11_fixture_add(G, TEST_NOW_NS - 1000U, 3U, 10U); // The time is in the past.
    const size_t time = st11_fixture.writer.position + 1U;
    st11_fixture_add(G, 2U * S, 4U, 10U); // The P-field is wrong.
    st11_fixture.data[time] = 0x2EU;
    const size_t checksum   = st11_fixture.writer.position + 9U;
    st11_fixture_add(G, 2U * S, 5U, 10U); // The checksum is wrong.
    st11_fixture.data[checksum + 12U] ^= 1U;
    const size_t report = st11_fixture.writer.position + 9U;
    st11_fixture_add(G, 2U * S, 6U, 10U); // A report, not a request.
    st11_fixture.data[report] &= 0xEFU;
    const size_t forged = st11_fixture.writer.position + 9U;
    st11_fixture_add(G, 2U * S, 9U, 10U); // The source is the supervisor.
    request_forge(&st11_fixture.data[forged]);
    st11_fixture_add(G, TEST_NOW_NS, 7U, 10U);
    st11_fixture_add(G, 1000000U * S, 8U, 10U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 4, 1, 4, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, G + 1U);
    expect_failure(3U, 4U, PUS_FAILURE_PAST, 3U, 0U);
    expect_failure(4U, 4U, PUS_FAILURE_OUT_OF_RANGE, 4U, (uint32_t)time);
    expect_failure(5U, 4U, PUS_FAILURE_EMBEDDED, 5U, (uint32_t)checksum);
    expect_failure(6U, 4U, PUS_FAILURE_EMBEDDED, 6U, (uint32_t)report);
    expect_failure(7U, 4U, PUS_FAILURE_EMBEDDED, 7U, (uint32_t)forged);
    expect_failure(8U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 6U);
    EXPECT_SCHEDULE(7, 1, 8);
    TEST_ASSERT_EQUAL_UINT32(6U, st11_fixture.schedule.schedule.counters.refused);
    // The activity of enable_all counts, too.
    TEST_ASSERT_EQUAL_UINT32(4U, st11_fixture.schedule.schedule.counters.inserted);
}

static void a_refused_insertion_creates_no_sub_schedule(void)
{
    st11_fixture_begin_insert(SS, 1U);
    st11_fixture_add(G, 2U * S, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, G);
    TEST_ASSERT_EQUAL_UINT16(0U, st11_fixture.schedule.schedule.sub_schedules.count);
}

static void a_tag_must_be_later_than_now_by_the_margin(void)
{
    st11_fixture.config.margin = PUS_TIME_TICKS_PER_S;
    st11_fixture_start();
    st11_fixture_create_group(G, 1U);
    st11_fixture_begin_insert(SS, 2U);
    st11_fixture_add(G, (TEST_NOW_NS + S) - MS, 1U, 0U);
    st11_fixture_add(G, TEST_NOW_NS + S, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    expect_failure(1U, 4U, PUS_FAILURE_PAST, 1U, 0U);
    EXPECT_SCHEDULE(2);
}

static void a_request_too_long_for_a_detail_report_is_refused(void)
{
    st11_fixture_create_group(G, 1U);
    st11_fixture_begin_insert(SS, 1U);
    st11_fixture_add(G, 2U * S, 1U, PUS_SCHEDULE_REQUEST_MAX - PUS_TC_MIN);
    st11_fixture_expect_done(4U);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(16U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 10, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(2U).size);
    st11_fixture_begin_insert(SS, 1U);
    st11_fixture_add(G, 2U * S, 2U, (PUS_SCHEDULE_REQUEST_MAX + 1U) - PUS_TC_MIN);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 1U, 11U);
}

static void activities_beyond_the_table_or_the_blocks_are_refused(void)
{
    st11_fixture.config = schedule_config(3U, 4U);
    st11_fixture_start();
    st11_fixture_create_group(G, 1U);
    st11_fixture_begin_insert(SS, 4U);
    for (uint16_t i = 0U; i < 4U; i++) {
        st11_fixture_add(G, 2U * S, i, 0U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 4U, 3U);
    st11_fixture_begin_ids(1U);
    st11_fixture_write_id(1U);
    st11_fixture_expect_done(5U);
    st11_fixture_begin_insert(SS, 3U); // Two blocks are free.
    st11_fixture_add(G, 2U * S, 10U, (3U * PUS_BLOCK_CHAIN_BLOCK) - PUS_TC_MIN);
    st11_fixture_add(G, 2U * S, 11U, (2U * PUS_BLOCK_CHAIN_BLOCK) - PUS_TC_MIN);
    st11_fixture_add(G, 2U * S, 12U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 4, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 1U, 4U);
    expect_failure(3U, 4U, PUS_FAILURE_TABLE_FULL, 3U, 3U);
    EXPECT_SCHEDULE(0, 2, 11);
}

static void a_fifth_sub_schedule_is_refused(void)
{
    st11_fixture_create_group(G, 1U);
    for (uint8_t i = 0U; i < 4U; i++) {
        st11_fixture_insert(i, G, 2U * S, i);
    }
    st11_fixture_begin_insert(4U, 1U);
    st11_fixture_add(G, 2U * S, 4U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 4U);
    st11_fixture_insert(3U, G, 2U * S, 5U);
}

static void a_request_inserts_up_to_255(void)
{
    st11_fixture_create_group(G, 1U);
    st11_fixture_begin_insert(SS, 255U);
    size_t last = 0U;
    for (uint16_t i = 0U; (i < 255U) && (st11_fixture.writer.position < (PUS_TC_DATA_MAX - 30U)); i++) {
        st11_fixture_add(G, 2U * S, i, 0U);
        last++;
    }
    st11_fixture.data[1] = (uint8_t)last;
    st11_fixture_expect_done(4U);
    TEST_ASSERT_EQUAL_UINT16(last, st11_fixture.schedule.schedule.count);
    st11_fixture.data[1] = 0U; // A count of zero.
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(4U, st11_fixture.data, 2U));
}

static void ten_thousand_activities_find_room(void)
{
    st11_fixture.config = schedule_config(ACTIVITIES, ACTIVITIES);
    st11_fixture_start();
    st11_fixture_enable_all();
    bench.ack = 0U;
    for (uint16_t i = 0U; i < ACTIVITIES; i += 100U) {
        st11_fixture_begin_insert(SS, 100U);
        for (uint16_t k = 0U; k < 100U; k++) {
            st11_fixture_add(G, (10U * S) + (((i + k) * 7919U) % ACTIVITIES) * MS, (uint16_t)(i + k), 0U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
        TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    }
    st11_fixture_begin_insert(SS, 1U);
    st11_fixture_add(G, 2U * S, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    expect_failure(0U, 4U, PUS_FAILURE_TABLE_FULL, 1U, ACTIVITIES);
    // One activity in each millisecond, released in that millisecond.
    for (uint64_t ms = 0U; ms < ACTIVITIES; ms++) {
        TEST_ASSERT_EQUAL_UINT64(ms, released.count);
        pus_time_schedule_step(&st11_fixture.schedule, (10U * S) + (ms * MS));
    }
    TEST_ASSERT_EQUAL_UINT64(ACTIVITIES, released.count);
}

static void every_request_has_a_strict_format(void)
{
    uint8_t octets[PUS_TC_DATA_MAX];
    static const uint8_t empty[] = {1, 2, 3, 16, 17, 18, 26};
    for (size_t i = 0U; i < sizeof empty; i++) {
        expect_strict_format(empty[i], octets, 0U);
    }
    st11_fixture_begin_insert(SS, 2U);
    st11_fixture_add(G, 2U * S, 1U, 0U);
    st11_fixture_add(G, 2U * S, 2U, 3U);
    memcpy(octets, st11_fixture.data, st11_fixture.writer.position);
    expect_strict_format(4U, octets, st11_fixture.writer.position);
    static const uint8_t ids[] = {1, 0, 9, 0, 17, 0, 1};
    expect_strict_format(5U, ids, sizeof ids);
    expect_strict_format(9U, ids, sizeof ids);
    expect_strict_format(12U, ids, sizeof ids);
    static const uint8_t shift[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 0, 17, 0, 1};
    expect_strict_format(7U, shift, sizeof shift);
    expect_strict_format(15U, shift, 7U);
    st11_fixture_begin();
    st11_fixture_write_window(1U, 2U * S, 3U * S);
    octet_write_u32(&st11_fixture.writer, 0x01050128U);
    memcpy(octets, st11_fixture.data, st11_fixture.writer.position);
    expect_strict_format(6U, octets, st11_fixture.writer.position);
    expect_strict_format(11U, octets, st11_fixture.writer.position);
    expect_strict_format(14U, octets, st11_fixture.writer.position);
    memmove(&octets[7], octets, st11_fixture.writer.position);
    expect_strict_format(8U, octets, st11_fixture.writer.position + 7U);
    for (uint8_t subtype = 20U; subtype <= 25U; subtype++) {
        if (subtype != 22U) {
            expect_strict_format(subtype, ids, 2U);
        }
    }
    expect_strict_format(22U, ids, 3U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_activity_is_released_at_its_time);
    RUN_TEST(activities_due_while_disabled_are_deleted_and_counted);
    RUN_TEST(a_sub_schedule_begins_disabled_with_its_first_activity);
    RUN_TEST(jumps_of_time_release_each_activity_once);
    RUN_TEST(a_step_releases_a_batch_at_most);
    RUN_TEST(requests_that_the_port_refuses_are_released_later_in_order);
    RUN_TEST(each_instruction_of_an_insertion_is_refused_alone);
    RUN_TEST(a_refused_insertion_creates_no_sub_schedule);
    RUN_TEST(a_tag_must_be_later_than_now_by_the_margin);
    RUN_TEST(a_request_too_long_for_a_detail_report_is_refused);
    RUN_TEST(activities_beyond_the_table_or_the_blocks_are_refused);
    RUN_TEST(a_fifth_sub_schedule_is_refused);
    RUN_TEST(a_request_inserts_up_to_255);
    RUN_TEST(ten_thousand_activities_find_room);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
