// SPDX-License-Identifier: Apache-2.0
// Selection of scheduled activities by identifier or filter, to delete or to shift them; groups. The numbers
// of requests and reports are subtypes; pus/catalogue/st11_time_schedule.txt has their names and fields.
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

static void activities_are_deleted_by_identifier(void)
{
    st11_fixture_create_group(G, 1U);
    for (uint16_t i = 0U; i < 5U; i++) {
        st11_fixture_insert(SS, G, (2U + i) * S, i);
    }
    st11_fixture_insert(SS, G, 9U * S, 3U); // Two activities have the same identifier.
    st11_fixture_begin_ids(3U);
    st11_fixture_write_id(1U);
    st11_fixture_write_id(77U);
    st11_fixture_write_id(3U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, (RELEASE_APID << 16U) | 77U);
    EXPECT_SCHEDULE(0, 2, 4);
    st11_fixture_begin_ids(3U); // Each part of an identifier is compared.
    octet_write_u16(&st11_fixture.writer, RELEASE_SOURCE + 1U);
    octet_write_u16(&st11_fixture.writer, RELEASE_APID);
    octet_write_u16(&st11_fixture.writer, 0U);
    octet_write_u16(&st11_fixture.writer, RELEASE_SOURCE);
    octet_write_u16(&st11_fixture.writer, RELEASE_APID + 1U);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_write_id(16383U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(5U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4);
}

static void identifiers_with_the_same_hash_bucket_are_distinguished(void)
{
    st11_fixture.config.bucket_count = 1U;
    st11_fixture_start();
    st11_fixture_create_group(G, 1U);
    for (uint16_t i = 0U; i < 4U; i++) {
        st11_fixture_insert(SS, G, 2U * S, i);
    }
    st11_fixture_begin_insert(SS, 2U);
    const size_t at = st11_fixture.writer.position + 9U;
    st11_fixture_add(G, 2U * S, 0U, 0U);
    uint8_t other[32]; // Equal sequence counts from another source and for another process.
    size_t size = 0U;
    pus_tc_t tc = {.apid = RELEASE_APID, .sequence = 0U, .service = 17U, .subtype = 1U, .source = 10U};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, other, sizeof other, &size));
    memcpy(&st11_fixture.data[at], other, size);
    tc.apid   = RELEASE_APID + 1U;
    tc.source = RELEASE_SOURCE;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, other, sizeof other, &size));
    octet_write_u8(&st11_fixture.writer, G);
    st11_fixture_write_time(2U * S);
    octet_write_octets(&st11_fixture.writer, other, size);
    st11_fixture_expect_done(4U);
    st11_fixture_begin_ids(2U);
    st11_fixture_write_id(0U);
    st11_fixture_write_id(2U);
    st11_fixture_expect_done(5U);
    EXPECT_SCHEDULE(1, 3, 0, 0);
}

static void a_filter_has_a_window_and_lists(void)
{
    st11_fixture_insert_ten();
    // The window from 3 s to 6 s selects 1, 2, 3 and 4; of these, sub-schedule 0 selects 2 and 4; of these,
    // group G or G + 2 selects 2.
    st11_fixture_begin();
    st11_fixture_write_window(1U, 3U * S, 6U * S);
    octet_write_u8(&st11_fixture.writer, 1U);
    octet_write_u8(&st11_fixture.writer, 0U);
    octet_write_u8(&st11_fixture.writer, 2U);
    octet_write_u8(&st11_fixture.writer, G);
    octet_write_u8(&st11_fixture.writer, G + 2U);
    st11_fixture_expect_done(6U);
    EXPECT_SCHEDULE(0, 1, 3, 4, 5, 6, 7, 8, 9);
    st11_fixture_begin(); // A window from 10 s on.
    st11_fixture_write_window(2U, 10U * S, 0U);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_expect_done(6U);
    EXPECT_SCHEDULE(0, 1, 3, 4, 5, 6, 7);
    st11_fixture_begin(); // A window up to 3 s.
    st11_fixture_write_window(3U, 0U, 3U * S);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_expect_done(6U);
    EXPECT_SCHEDULE(3, 4, 5, 6, 7);
    st11_fixture_begin(); // A window without activities.
    st11_fixture_write_window(3U, 0U, 3U * S);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_expect_done(6U);
    st11_fixture_begin(); // All activities.
    st11_fixture_write_filter_all();
    st11_fixture_expect_done(6U);
    st11_fixture_expect_empty();
}

static void a_faulty_filter_is_refused(void)
{
    st11_fixture_insert_ten();
    for (uint8_t subtype = 6U; subtype <= 14U; subtype++) {
        if ((subtype != 6U) && (subtype != 8U) && (subtype != 11U) && (subtype != 14U)) {
            continue;
        }
        const uint32_t before = (subtype == 8U) ? 7U : 0U;
        // Kinds: window that ends before it begins, wrong P-field of either time, unknown sub-schedule,
        // unknown group.
        for (unsigned kind = 0U; kind < 5U; kind++) {
            st11_fixture_begin();
            if (subtype == 8U) {
                st11_fixture_write_offset(1000);
            }
            const size_t window = st11_fixture.writer.position;
            st11_fixture_write_window(1U, (kind == 0U) ? (9U * S) : (3U * S), 6U * S);
            octet_write_u8(&st11_fixture.writer, 1U);
            octet_write_u8(&st11_fixture.writer, (kind == 3U) ? 9U : 0U);
            octet_write_u8(&st11_fixture.writer, 1U);
            octet_write_u8(&st11_fixture.writer, (kind == 4U) ? 9U : G);
            if ((kind == 1U) || (kind == 2U)) {
                st11_fixture.data[window + ((kind == 1U) ? 1U : 9U)] = 0U;
            }
            TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(subtype));
            EXPECT_MESSAGES(1, 1, 1, 4);
            if (kind <= 2U) {
                expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, before + 1U);
            } else {
                expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 9U);
            }
        }
        st11_fixture_begin();
        if (subtype == 8U) {
            st11_fixture_write_offset(1000);
        }
        octet_write_u8(&st11_fixture.writer, 4U);
        octet_write_u16(&st11_fixture.writer, 0U);
        TEST_ASSERT_EQUAL(STATUS_INVALID, st11_fixture_request(subtype));
    }
    EXPECT_SCHEDULE(0, 1, 2, 3, 4, 5, 6, 7, 8, 9);
}

static void activities_are_shifted_by_identifier(void)
{
    st11_fixture_insert_ten();
    st11_fixture_insert(0U, G, 20U * S, 4U);
    st11_fixture_begin();
    st11_fixture_write_offset(-1500);
    octet_write_u8(&st11_fixture.writer, 4U);
    st11_fixture_write_id(4U);  // 6 s and 20 s: to 4.5 s and 18.5 s.
    st11_fixture_write_id(1U);  // 3 s to 1.5 s, which is now and still allowed.
    st11_fixture_write_id(0U);  // 2 s to 0.5 s, which is in the past.
    st11_fixture_write_id(88U); // The identifier is unknown.
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_PAST, 3U, 0U);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 4U, (RELEASE_APID << 16U) | 88U);
    EXPECT_SCHEDULE(1, 0, 2, 4, 3, 5, 6, 7, 8, 9, 4);
}

static void a_shift_keeps_the_distance_exactly(void)
{
    st11_fixture_create_group(G, 1U);
    st11_fixture_insert(SS, G, (2U * S) + 123456789U, 1U);
    const uint64_t before = pus_schedule_next(&st11_fixture.schedule.schedule);
    st11_fixture_begin();
    st11_fixture_write_offset(12345);
    st11_fixture_expect_done(15U);
    st11_fixture_begin();
    st11_fixture_write_offset(-12345);
    st11_fixture_expect_done(15U);
    TEST_ASSERT_EQUAL_UINT64(before, pus_schedule_next(&st11_fixture.schedule.schedule));
}

static void a_shift_by_filter_is_complete_or_refused(void)
{
    st11_fixture_insert_ten();
    st11_fixture_begin();
    st11_fixture_write_offset(-1000); // Activity 0 would be moved to 1 s, which is in the past.
    st11_fixture_write_window(3U, 0U, 5U * S);
    octet_write_u16(&st11_fixture.writer, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(8U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_PAST, 0U, 0U);
    EXPECT_SCHEDULE(0, 1, 2, 3, 4, 5, 6, 7, 8, 9);
    st11_fixture_begin();
    st11_fixture_write_offset(5500);
    st11_fixture_write_window(3U, 0U, 5U * S);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_expect_done(8U);
    EXPECT_SCHEDULE(4, 5, 0, 6, 1, 7, 2, 8, 3, 9);
    st11_fixture_begin(); // No activity is selected, so there is nothing to refuse.
    st11_fixture_write_offset(-100000);
    st11_fixture_write_window(3U, 0U, 2U * S);
    octet_write_u16(&st11_fixture.writer, 0U);
    st11_fixture_expect_done(8U);
}

static void a_shift_of_all_activities_is_complete_or_refused(void)
{
    static const uint8_t largest[]  = {0x7FU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU};
    static const uint8_t smallest[] = {0x80U, 0U, 0U, 0U, 0U, 0U, 0U};
    st11_fixture_insert_ten();
    st11_fixture_begin();
    st11_fixture_write_offset(-500);
    st11_fixture_expect_done(15U); // The first activity is moved to the present time.
    st11_fixture_begin();
    st11_fixture_write_offset(-1);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(15U));
    expect_failure(1U, 4U, PUS_FAILURE_PAST, 0U, 0U);
    st11_fixture_begin();
    octet_write_octets(&st11_fixture.writer, smallest, sizeof smallest);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(15U));
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    // An offset of 68 years from 2021 is within the range of times; twice this offset is not.
    st11_fixture_begin();
    octet_write_octets(&st11_fixture.writer, largest, sizeof largest);
    st11_fixture_expect_done(15U);
    st11_fixture_begin();
    octet_write_octets(&st11_fixture.writer, largest, sizeof largest);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(15U));
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    EXPECT_SCHEDULE(0, 1, 2, 3, 4, 5, 6, 7, 8, 9);
}

static void a_reset_forgets_all_but_the_groups(void)
{
    static const uint8_t g[]        = {G};
    static const uint8_t expected[] = {0, 2, 7, 1, G, 1};
    st11_fixture_enable_all();
    st11_fixture_create_group(7U, 0U);
    st11_fixture_command_ids(25U, 1U, g);
    st11_fixture_insert(SS, G, 2U * S, 1U);
    st11_fixture_insert(SS, G, 3U * S, 2U);
    st11_fixture_insert(SS, G, 4U * S, 3U);
    st11_fixture_command_ids(24U, 1U, g);
    released.accepts  = 0U;
    released.refusals = 1U;
    // Activity 1 is being released when the reset comes.
    pus_time_schedule_step(&st11_fixture.schedule, 2U * S);
    st11_fixture_command(3U);
    st11_fixture_expect_empty();
    TEST_ASSERT_FALSE(st11_fixture.schedule.schedule.is_enabled);
    TEST_ASSERT_FALSE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
    pus_time_schedule_step(&st11_fixture.schedule, 9U * S);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(18U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(26U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 27, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    TEST_ASSERT_EQUAL_UINT16(0U, st11_fixture.config.chains->pool.stats.taken);
}

static void groups_are_created_and_deleted(void)
{
    static const uint8_t ids[] = {1, 2, 3};
    // Six pairs of group and status.
    static const uint8_t faulty[] = {6, 10, 1, 10, 0, 11, 2, 11, 0, 12, 1, 13, 1};
    st11_fixture_begin();
    octet_write_octets(&st11_fixture.writer, faulty, sizeof faulty);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(22U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_EXISTS, 2U, 10U);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 6U);
    expect_failure(4U, 4U, PUS_FAILURE_TABLE_FULL, 6U, 3U);
    st11_fixture_insert(SS, 11U, 2U * S, 1U);
    static const uint8_t deleted[] = {10, 11, 99};
    st11_fixture_command_ids(23U, 3U, deleted);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_STATE, 2U, 11U);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 3U, 99U);
    st11_fixture_command_ids(23U, 0U, ids); // All groups that have no activity.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, st11_fixture.schedule.schedule.groups.count);
    st11_fixture_command_ids(24U, 3U, ids);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4);
    st11_fixture_command_ids(25U, 0U, ids); // All groups.
    TEST_ASSERT_EQUAL_UINT8(1U, st11_fixture.schedule.schedule.groups.flags[11]);
    st11_fixture_command_ids(24U, 0U, ids);
    TEST_ASSERT_EQUAL_UINT8(3U, st11_fixture.schedule.schedule.groups.flags[11]);
    st11_fixture_command_ids(20U, 0U, ids);
    TEST_ASSERT_EQUAL_UINT8(3U, st11_fixture.schedule.schedule.sub_schedules.flags[SS]);
    st11_fixture_command_ids(21U, 0U, ids);
    TEST_ASSERT_EQUAL_UINT8(1U, st11_fixture.schedule.schedule.sub_schedules.flags[SS]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(activities_are_deleted_by_identifier);
    RUN_TEST(identifiers_with_the_same_hash_bucket_are_distinguished);
    RUN_TEST(a_filter_has_a_window_and_lists);
    RUN_TEST(a_faulty_filter_is_refused);
    RUN_TEST(activities_are_shifted_by_identifier);
    RUN_TEST(a_shift_keeps_the_distance_exactly);
    RUN_TEST(a_shift_by_filter_is_complete_or_refused);
    RUN_TEST(a_shift_of_all_activities_is_complete_or_refused);
    RUN_TEST(a_reset_forgets_all_but_the_groups);
    RUN_TEST(groups_are_created_and_deleted);
    return UNITY_END();
}
