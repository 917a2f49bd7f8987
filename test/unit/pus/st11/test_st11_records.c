// SPDX-License-Identifier: Apache-2.0
// The records of a time schedule: which changes survive a power cut, and records that are refused. The
// numbers of requests and reports are subtypes; pus/catalogue/st11_time_schedule.txt has their names and
// fields.
#include "pus/core/schedule_internal.h"
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

static void acknowledged_changes_survive_a_power_cut(void)
{
    static const uint8_t ss[] = {SS};
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    st11_fixture_create_group(7U, 0U);
    st11_fixture_insert(SS, G, 4U * S, 1U);
    st11_fixture_insert(SS, G, 3U * S, 2U);
    st11_fixture_insert(9U, G, 3U * S, 3U);
    st11_fixture_begin();
    st11_fixture_write_offset(2000);
    octet_write_u8(&st11_fixture.writer, 1U);
    st11_fixture_write_id(2U);
    st11_fixture_expect_done(7U); // Activity 2 is moved to 5 s.
    st11_fixture_begin_ids(1U);
    st11_fixture_write_id(3U);
    st11_fixture_expect_done(5U);
    st11_fixture_restart();
    // Flags of sub-schedules and groups: 1 exists, 2 enabled.
    EXPECT_SCHEDULE(1, 2);
    TEST_ASSERT_TRUE(st11_fixture.schedule.schedule.is_enabled);
    TEST_ASSERT_EQUAL_UINT16(2U, st11_fixture.schedule.schedule.sub_schedules.count);
    TEST_ASSERT_EQUAL_UINT8(3U, st11_fixture.schedule.schedule.sub_schedules.flags[SS]);
    TEST_ASSERT_EQUAL_UINT8(1U, st11_fixture.schedule.schedule.sub_schedules.flags[9]);
    TEST_ASSERT_EQUAL_UINT8(1U, st11_fixture.schedule.schedule.groups.flags[7]);
    st11_fixture_insert(SS, G, 5U * S, 4U); // Inserted after activity 2, which has the same time tag.
    st11_fixture_restart();
    EXPECT_SCHEDULE(1, 2, 4);
    st11_fixture_command_ids(21U, 1U, ss);
    st11_fixture_restart();
    TEST_ASSERT_EQUAL_UINT8(1U, st11_fixture.schedule.schedule.sub_schedules.flags[SS]);
    st11_fixture_command_ids(20U, 1U, ss);
    pus_time_schedule_step(&st11_fixture.schedule, 4U * S);
    EXPECT_RELEASED(1);
    st11_fixture_restart();
    EXPECT_SCHEDULE(2, 4);
    st11_fixture_command(3U);
    st11_fixture_restart();
    st11_fixture_expect_empty();
    TEST_ASSERT_FALSE(st11_fixture.schedule.schedule.is_enabled);
    TEST_ASSERT_EQUAL_UINT16(2U, st11_fixture.schedule.schedule.groups.count);
    TEST_ASSERT_EQUAL_UINT64(0U, released.lost_count);
}

/// Identifiers of sub-schedules and groups are octets: all of 0 to 255 are kept.
static void the_first_and_the_last_sub_schedule_and_group_are_kept(void)
{
    static const uint8_t ids[] = {0U, 255U};
    st11_fixture_start_with_records();
    for (unsigned i = 0U; i < 2U; i++) {
        st11_fixture_create_group(ids[i], 0U);
        st11_fixture_insert(ids[i], ids[i], 9U * S, (uint16_t)i);
    }
    st11_fixture_command_ids(20U, 2U, ids);
    st11_fixture_restart();
    const pus_schedule_t* const schedule = &st11_fixture.schedule.schedule;
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_UINT8(3U, schedule->sub_schedules.flags[ids[i]]);
        TEST_ASSERT_EQUAL_UINT8(1U, schedule->groups.flags[ids[i]]);
    }
    EXPECT_SCHEDULE(0, 1);
}

/// After a power cut the remaining records are in any slots of the table; the other slots are free.
static void after_a_power_cut_the_whole_table_has_room(void)
{
    for (uint16_t kept = 1U; kept <= 4U; kept++) {
        st11_fixture.config = schedule_config(4U, 8U);
        st11_fixture_start_with_records();
        st11_fixture_create_group(G, 1U);
        for (uint16_t i = 1U; i <= 4U; i++) {
            st11_fixture_insert(SS, G, 2U * S, i);
        }
        for (uint16_t i = 1U; i <= 4U; i++) {
            if (i != kept) {
                st11_fixture_begin_ids(1U);
                st11_fixture_write_id(i);
                st11_fixture_expect_done(5U);
            }
        }
        st11_fixture_restart();
        for (uint16_t i = 11U; i <= 13U; i++) {
            st11_fixture_insert(SS, G, 3U * S, i);
        }
        EXPECT_SCHEDULE(kept, 11, 12, 13);
        records_start();
    }
}

static void an_activity_under_release_at_a_restart_is_reported_and_not_released_again(void)
{
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    for (uint16_t i = 0U; i < 4U; i++) {
        st11_fixture_insert(SS, G, (i < 3U) ? (2U * S) : (3U * S), i);
    }
    released.accepts  = 1U;
    released.refusals = 1U;
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    EXPECT_RELEASED(0);
    st11_fixture_restart();
    EXPECT_SCHEDULE(3);
    TEST_ASSERT_TRUE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    TEST_ASSERT_EQUAL_UINT64(3U, released.lost_count);
    for (uint16_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT16(i, released.lost[i].sequence);
        TEST_ASSERT_EQUAL_UINT16(RELEASE_APID, released.lost[i].apid);
    }
    TEST_ASSERT_EQUAL_UINT32(3U, st11_fixture.schedule.schedule.counters.lost);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st11_fixture_restart(); // The loss is reported once.
    st11_fixture.config.lost = NULL;
    pus_time_schedule_step(&st11_fixture.schedule, 3U * S);
    EXPECT_RELEASED(3);
    TEST_ASSERT_EQUAL_UINT64(3U, released.lost_count);
}

static void a_loss_without_a_callback_is_counted(void)
{
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    st11_fixture_insert(SS, G, 2U * S, 1U);
    released.accepts  = 0U;
    released.refusals = 1U;
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    st11_fixture_restart();
    st11_fixture.schedule.schedule.config.lost = NULL;
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    TEST_ASSERT_EQUAL_UINT32(1U, st11_fixture.schedule.schedule.counters.lost);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
}

static void a_step_commits_once_before_and_once_after_it_releases(void)
{
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    for (uint16_t i = 0U; i < 5U; i++) {
        st11_fixture_insert(SS, G, 2U * S, i);
    }
    const unsigned before = records.commits;
    pus_time_schedule_step(&st11_fixture.schedule, 1900U * MS);
    TEST_ASSERT_EQUAL_UINT(before, records.commits);
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    TEST_ASSERT_EQUAL_UINT(before + 2U, records.commits);
    pus_time_schedule_step(&st11_fixture.schedule, 3U * S);
    TEST_ASSERT_EQUAL_UINT(before + 2U, records.commits);
    TEST_ASSERT_EQUAL_UINT32(0U, st11_fixture.schedule.schedule.counters.unsaved);
}

/// Expect that the only sub-schedule is SS and the only group G, both enabled.
static void expect_sets(void)
{
    static const uint8_t subtypes[]    = {18U, 26U};
    static const uint8_t expected[][4] = {{0, 1, SS, 1}, {0, 1, G, 1}};
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        st11_fixture_begin();
        TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(subtypes[i]));
        TEST_ASSERT_EQUAL_UINT64(sizeof expected[i], bench_report(2U).size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected[i], bench_report(2U).data, sizeof expected[i]);
    }
}

static void a_change_that_cannot_be_stored_is_not_acknowledged(void)
{
    static const uint8_t g[] = {G};
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    st11_fixture_insert(SS, G, 2U * S, 1U);
    records.put_status = STATUS_FULL;
    st11_fixture_begin_insert(SS, 1U);
    st11_fixture_add(G, 2U * S, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(4U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    EXPECT_SCHEDULE(1);
    st11_fixture_begin();
    st11_fixture_write_offset(1000);
    octet_write_u8(&st11_fixture.writer, 1U);
    st11_fixture_write_id(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(7U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    st11_fixture_begin();
    st11_fixture_write_offset(1000);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(15U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(2U));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_TRUE(st11_fixture.schedule.schedule.is_enabled);
    st11_fixture_command_ids(25U, 1U, g);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    st11_fixture_command_ids(21U, 0U, g);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    st11_fixture_begin();
    octet_write_octets(&st11_fixture.writer, (const uint8_t[]){1U, G + 1U, 1U}, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(22U));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    expect_sets();
    records.put_status   = STATUS_OK;
    records.erase_status = STATUS_IO;
    st11_fixture_begin_ids(1U);
    st11_fixture_write_id(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(5U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    st11_fixture_begin();
    st11_fixture_write_filter_all();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(6U));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(3U));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    EXPECT_SCHEDULE(1);
}

static void a_group_whose_deletion_cannot_be_stored_stays(void)
{
    static const uint8_t g[] = {G};
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    records.put_status = STATUS_FULL;
    for (unsigned count = 0U; count <= 1U; count++) {
        st11_fixture_command_ids(23U, count, g);
        expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
        expect_sets();
    }
}

static void due_activities_are_released_though_their_records_cannot_be_stored(void)
{
    st11_fixture_start_with_records();
    st11_fixture_enable_all();
    st11_fixture_insert(SS, G, 2U * S, 1U);
    records.put_status    = STATUS_IO;
    records.erase_status  = STATUS_IO;
    records.commit_status = STATUS_IO;
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    EXPECT_RELEASED(1);
    // Failed: put of the release, its commit, erasure of the activity, erasure of the release, their commit.
    TEST_ASSERT_EQUAL_UINT32(5U, st11_fixture.schedule.schedule.counters.unsaved);
}

static void an_impossible_activity_record_is_refused(void)
{
    // A record consists of the release time (u64), the serial number (u64), sub-schedule, group and request.
    uint8_t octets[2000] = {0};
    uint8_t packet[PUS_PACKET_MAX];
    const size_t size     = request_make(1U, 0U, packet);
    octet_writer_t record = octet_writer(octets, sizeof octets);
    octet_write_u64(&record, 5U);
    octet_write_u64(&record, 7U);
    octet_write_u16(&record, (SS << 8U) | G);
    octet_write_octets(&record, packet, size);
    const uint32_t key = 0x01000000U;
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_time_schedule_restore(&st11_fixture.schedule, 0x01010000U, octets, 31U));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_time_schedule_restore(&st11_fixture.schedule, PUS_SCHEDULE_KEY_OWN, octets, 31U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      pus_time_schedule_restore(&st11_fixture.schedule, key | 600U, octets, 31U));
    for (size_t cut = 0U; cut < record.position; cut++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID,
                          pus_time_schedule_restore(&st11_fixture.schedule, key, octets, cut));
    }
    octets[0] = 1U; // The tag is out of range.
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_time_schedule_restore(&st11_fixture.schedule, key, octets, record.position));
    octets[0] = 0U;
    request_forge(&octets[record.position - size]); // The source is the supervisor.
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_time_schedule_restore(&st11_fixture.schedule, key, octets, record.position));
    (void)memcpy(&octets[record.position - size], packet, size);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pus_time_schedule_restore(&st11_fixture.schedule, key | 599U, octets, record.position));
    TEST_ASSERT_EQUAL(STATUS_EXISTS,
                      pus_time_schedule_restore(&st11_fixture.schedule, key | 599U, octets, record.position));
    TEST_ASSERT_EQUAL_UINT64(8U, st11_fixture.schedule.schedule.serial);
    octets[15] = 3U; // A serial number below the largest one.
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pus_time_schedule_restore(&st11_fixture.schedule, key, octets, record.position));
    TEST_ASSERT_EQUAL_UINT64(8U, st11_fixture.schedule.schedule.serial);
    // The activity was due long before the epoch.
    TEST_ASSERT_EQUAL_UINT64(0U, pus_time_schedule_next_ns(&st11_fixture.schedule));
    schedule_drop(&st11_fixture.schedule.schedule, 599U); // A free slot accepts a record again.
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pus_time_schedule_restore(&st11_fixture.schedule, key | 599U, octets, record.position));
    st11_fixture.config = schedule_config(1U, 1U);
    st11_fixture_start();
    // The request needs more blocks than this configuration has.
    const size_t longer = request_make(1U, 100U, &octets[PUS_SCHEDULE_RECORD_HEAD]);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_time_schedule_restore(&st11_fixture.schedule, key, octets,
                                                                  PUS_SCHEDULE_RECORD_HEAD + longer));
}

/// The record is a flag (1: the schedule is enabled), the number of sub-schedules (u16) with id and flags of
/// each, and the same for groups. Flags: 1 exists, 2 enabled.
static void an_impossible_state_is_refused(void)
{
    static const struct {
        status_t status;
        size_t size;
        uint8_t octets[16];
    } cases[] = {{STATUS_OK, 9U, {1, 0, 1, SS, 3, 0, 1, G, 1}},
                 {STATUS_INVALID, 8U, {1, 0, 1, SS, 3, 0, 1, G}},
                 {STATUS_INVALID, 10U, {1, 0, 1, SS, 3, 0, 1, G, 1, 0}},
                 {STATUS_INVALID, 0U, {0}},
                 {STATUS_EXHAUSTED, 9U, {1, 0, 5, SS, 3, 0, 1, G, 1}},
                 {STATUS_EXHAUSTED, 9U, {1, 0, 1, SS, 3, 0, 4, G, 1}},
                 {STATUS_INVALID, 9U, {1, 0, 1, SS, 2, 0, 1, G, 1}},
                 {STATUS_INVALID, 11U, {1, 0, 2, SS, 1, SS, 1, 0, 1, G, 1}}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        st11_fixture_start();
        TEST_ASSERT_EQUAL(cases[i].status, pus_time_schedule_restore(&st11_fixture.schedule, 0U,
                                                                     cases[i].octets, cases[i].size));
        TEST_ASSERT_EQUAL(cases[i].status == STATUS_OK, st11_fixture.schedule.schedule.is_enabled);
    }
    static const uint8_t ids[(PUS_SCHEDULE_BATCH + 1U) * 6U] = {0};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_time_schedule_restore(&st11_fixture.schedule, 1U, ids, 7U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_time_schedule_restore(&st11_fixture.schedule, 1U, ids, sizeof ids));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_time_schedule_restore(&st11_fixture.schedule, 1U, ids, sizeof ids - 6U));
    pus_time_schedule_step(&st11_fixture.schedule, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(PUS_SCHEDULE_BATCH, released.lost_count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(acknowledged_changes_survive_a_power_cut);
    RUN_TEST(the_first_and_the_last_sub_schedule_and_group_are_kept);
    RUN_TEST(after_a_power_cut_the_whole_table_has_room);
    RUN_TEST(an_activity_under_release_at_a_restart_is_reported_and_not_released_again);
    RUN_TEST(a_loss_without_a_callback_is_counted);
    RUN_TEST(a_step_commits_once_before_and_once_after_it_releases);
    RUN_TEST(a_change_that_cannot_be_stored_is_not_acknowledged);
    RUN_TEST(a_group_whose_deletion_cannot_be_stored_stays);
    RUN_TEST(due_activities_are_released_though_their_records_cannot_be_stored);
    RUN_TEST(an_impossible_activity_record_is_refused);
    RUN_TEST(an_impossible_state_is_refused);
    return UNITY_END();
}
