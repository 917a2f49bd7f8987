// SPDX-License-Identifier: Apache-2.0
// Copies of the file service: TC[23,14] to [23,24]; pus/catalogue/st23_files.txt has their names and fields.
#include "pus/st23/st23_files.h"

#include "test/support/disk.h"
#include "test/unit/pus/fixtures/st23_fixture.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define SLICE PUS_FILE_SLICE

void setUp(void)
{
    st23_fixture_start();
}

void tearDown(void)
{
    records_start();
}

// ---- Copies ----

static void expect_copied(const char* const from, const char* const to)
{
    const disk_file_t* const source = disk_find(from);
    const disk_file_t* const target = disk_find(to);
    TEST_ASSERT_NOT_NULL(target);
    TEST_ASSERT_EQUAL_UINT64(source->size, target->size);
    if (source->size > 0U) {
        TEST_ASSERT_EQUAL_MEMORY(source->octets, target->octets, source->size);
    }
}

static void a_file_is_copied_slice_by_slice(void)
{
    (void)disk_file("a/large", (SLICE * 4U) + 1U, 7U);
    st23_fixture_copy(14U, 5U, "/a", "large", "/a/b", "copy");
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_TRUE(pus_files_is_busy(&st23_fixture.files));
    st23_fixture_step();
    EXPECT_MESSAGES(0);
    TEST_ASSERT_NULL(disk_find("a/b/copy"));
    TEST_ASSERT_NOT_NULL(disk_find("a/b/.copy-5"));
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5);
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5);
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5);
    octet_reader_t reader = bench_data(0U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_UINT16(75U, octet_read_u16(&reader)); // The step number is the progress in percent.
    st23_fixture_step();
    EXPECT_MESSAGES(1, 7);
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
    expect_copied("a/large", "a/b/copy");
    TEST_ASSERT_NULL(disk_find("a/b/.copy-5"));
    TEST_ASSERT_EQUAL_UINT64((SLICE * 4U) + 1U, disk.room);
    TEST_ASSERT_EQUAL_UINT32(1U, disk.syncs);
    TEST_ASSERT_EQUAL_UINT32(1U, st23_fixture.files.counters.copied);
    TEST_ASSERT_EQUAL_UINT32(1U, records.erasures);
    const unsigned calls = disk.calls;
    st23_fixture_step();
    TEST_ASSERT_EQUAL_UINT32(calls, disk.calls); // A step without work makes no call.
}

static void copies_are_continued_in_turn(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    st23_fixture.slices = 3U;
    st23_fixture_restart();
    st23_fixture_copy(14U, 1U, "", "large", "", "x");
    st23_fixture_copy(14U, 2U, "a", "one", "", "y");
    st23_fixture_step(); // The step copies a slice of large, of one, and of large.
    EXPECT_MESSAGES(1, 5, 1, 5, 1, 5, 1, 5, 1, 7, 1, 5);
    expect_copied("a/one", "y");
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5, 1, 7);
    expect_copied("large", "x");
}

static void an_empty_file_is_copied(void)
{
    (void)disk_file("empty", 0U, 0U);
    st23_fixture_copy(14U, 1U, "", "empty", "", "x");
    st23_fixture_step();
    EXPECT_MESSAGES(1, 7);
    expect_copied("empty", "x");
}

static void an_invalid_copy_is_refused(void)
{
    st23_fixture_copy(14U, 1U, "a", "no", "", "x");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    st23_fixture_copy(14U, 1U, "a", "b", "", "x");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    st23_fixture_copy(14U, 1U, "a", "one", "no", "x");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 10U);
    st23_fixture_copy(14U, 1U, "a", "one", "a/one", "x");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 10U);
    st23_fixture_copy(14U, 1U, "a", "one", "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 13U);
    st23_fixture_copy(14U, 1U, "a", "one", "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 13U);
    st23_fixture_copy(14U, 1U, "a/", "one", "a", "x");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 2U);
    st23_fixture_copy(14U, 1U, "a", "one", "a", "x?");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 13U);
    st23_fixture_copy(14U, 1U, "a", "one", "a", "x");
    EXPECT_MESSAGES(1, 1, 1, 3);
    st23_fixture_copy(14U, 1U, "a", "one", "a", "y");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 1U);
    st23_fixture_copy(14U, 2U, "a", "one", "a", "x");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 13U);
    st23_fixture_copy(14U, 2U, "a", "one", "a", "y");
    st23_fixture_copy(14U, 3U, "a", "one", "a", "z");
    EXPECT_MESSAGES(1, 1, 1, 3);
    st23_fixture_copy(14U, 4U, "a", "one", "a", "w");
    st23_fixture_expect_refused(PUS_FAILURE_TABLE_FULL, COPIES);
    disk.fail_call = disk.calls + 3U; // The query of the target.
    st23_fixture_copy(14U, 4U, "a", "one", "a", "w");
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
}

static void a_file_being_copied_cannot_be_changed(void)
{
    st23_fixture_copy(14U, 1U, "a", "one", "a/b", "x");
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_request(10U, "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_copy(15U, 2U, "a", "one", "", "y");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 5U);
    st23_fixture_create("a/b", "x", 0U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 5U);
    st23_fixture_request(9U, "a/b", "x");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 5U);
    st23_fixture_rename("a", "b", "z");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    disk_directory("c");
    st23_fixture_copy(14U, 2U, "a", "one", "", "d");
    st23_fixture_rename("", "c", "d");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 5U);
}

static void a_file_is_moved_at_once(void)
{
    st23_fixture_copy(15U, 1U, "a", "one", "a/b", "moved");
    st23_fixture_expect_done();
    TEST_ASSERT_NULL(disk_find("a/one"));
    TEST_ASSERT_EQUAL_UINT64(10U, disk_find("a/b/moved")->size);
    st23_fixture_copy(15U, 1U, "a", "one", "a/b", "x");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    disk.fail_call = disk.calls + 4U; // The call that renames.
    st23_fixture_copy(15U, 1U, "a/b", "moved", "a", "one");
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
}

/// A call of the file store fails: the copy ends with a failure, and no part of it remains.
static void a_failed_copy_leaves_no_file(void)
{
    // The calls are make, read and write in the first step; read, write, sync and rename in the second. All
    // except the second read (call 4) fail in turn.
    for (unsigned i = 1U; i <= 6U; i++) {
        memset(disk.files, 0, sizeof disk.files);
        disk.contents = 0U;
        disk_directory("");
        (void)disk_file("large", SLICE + 1U, 7U);
        st23_fixture_copy(14U, 1U, "", "large", "", "x");
        disk.fail_call = disk.calls + ((i < 4U) ? i : (i + 1U));
        st23_fixture_step();
        if (i >= 4U) {
            st23_fixture_step();
        }
        expect_failure(bench.count - 1U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
        TEST_ASSERT_EQUAL_UINT32(i, st23_fixture.files.counters.failed);
        TEST_ASSERT_NULL(disk_find("x"));
        TEST_ASSERT_NULL(disk_find(".copy-1"));
        TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
    }
}

static void a_source_that_becomes_shorter_fails_the_copy(void)
{
    disk_file_t* const source = disk_file("large", SLICE * 2U, 7U);
    st23_fixture_copy(14U, 1U, "", "large", "", "x");
    st23_fixture_step();
    source->size = SLICE;
    st23_fixture_step();
    EXPECT_MESSAGES(1, 6, 1, 8);
    expect_failure(1U, 8U, PUS_FAILURE_IO, 0U, STATUS_TRUNCATED);
}

static void a_part_file_that_was_left_over_is_replaced(void)
{
    (void)disk_file(".copy-1", 100U, 7U);
    st23_fixture_copy(14U, 1U, "a", "one", "", "x");
    st23_fixture_step();
    expect_copied("a/one", "x");
    TEST_ASSERT_NULL(disk_find(".copy-1"));
}

static void copies_are_suspended_resumed_and_aborted(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    st23_fixture_copy(14U, 1U, "", "large", "", "x");
    st23_fixture_change(17U, 1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, 1U);
    st23_fixture_change(16U, 1U);
    st23_fixture_expect_done();
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
    st23_fixture_step();
    TEST_ASSERT_NULL(disk_find(".copy-1"));
    st23_fixture_change(16U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, 1U);
    st23_fixture_change(17U, 1U);
    st23_fixture_expect_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, st23_fixture.copies[0].status);
    st23_fixture_step();
    st23_fixture_change(16U, 1U);
    st23_fixture_step();
    EXPECT_MESSAGES(0);
    st23_fixture_change(17U, 1U);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_RUNNING, st23_fixture.copies[0].status);
    st23_fixture_begin();
    octet_write_u8(&st23_fixture.writer, 3U);
    octet_write_u16(&st23_fixture.writer, 9U);
    octet_write_u16(&st23_fixture.writer, 1U);
    octet_write_u16(&st23_fixture.writer, 1U);
    st23_fixture_send(18U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8, 1, 4, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 9U);
    expect_failure(4U, 4U, PUS_FAILURE_UNKNOWN_ID, 3U, 1U);
    expect_failure(5U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    const pus_tm_t aborted = bench_report(3U);
    octet_reader_t reader  = octet_reader(aborted.data, aborted.size);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, octet_read_u16(&reader));
    TEST_ASSERT_NULL(disk_find(".copy-1"));
    TEST_ASSERT_NULL(disk_find("x"));
    TEST_ASSERT_EQUAL_UINT32(1U, st23_fixture.files.counters.aborted);
}

static void copies_of_a_path_are_changed(void)
{
    disk_directory("ab");
    st23_fixture_copy(14U, 1U, "a", "one", "", "x");
    st23_fixture_copy(14U, 2U, "a/b", "two", "ab", "x");
    (void)disk_file("top", 1U, 1U);
    st23_fixture_copy(14U, 3U, "", "top", "ab", "y");
    st23_fixture_change_path(19U, "/a");
    st23_fixture_expect_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, st23_fixture.copies[0].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, st23_fixture.copies[1].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, st23_fixture.copies[2].status);
    st23_fixture_change_path(19U, "/");
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, st23_fixture.copies[2].status);
    st23_fixture_change_path(20U, "a/b");
    st23_fixture_expect_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, st23_fixture.copies[0].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, st23_fixture.copies[1].status);
    st23_fixture_change_path(21U, "ab");
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8, 1, 8, 1, 7);
    st23_fixture_change_path(21U, "ab");
    st23_fixture_expect_done();
    st23_fixture_change_path(21U, "no");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 0U);
    st23_fixture_change_path(20U, "a/one");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 0U);
    st23_fixture_change_path(19U, "a/../b");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    TEST_ASSERT_EQUAL_UINT32(2U, st23_fixture.files.counters.aborted);
}

static void after_a_power_cut_nothing_of_an_incomplete_copy_remains(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    st23_fixture_copy(14U, 1U, "", "large", "a", "x");
    st23_fixture_copy(14U, 2U, "", "large", "a/b", "x");
    st23_fixture_step();
    st23_fixture_step();
    TEST_ASSERT_NOT_NULL(disk_find("a/.copy-1"));
    st23_fixture_power_cut();
    TEST_ASSERT_TRUE(pus_files_is_busy(&st23_fixture.files));
    st23_fixture_copy(14U, 3U, "a", "one", "", "x");
    st23_fixture_copy(14U, 4U, "a", "one", "", "y"); // Copies 1 and 2 still have their entries in the table.
    st23_fixture_expect_refused(PUS_FAILURE_TABLE_FULL, COPIES);
    st23_fixture_change(18U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 1U);
    st23_fixture_step();
    st23_fixture_step();
    TEST_ASSERT_NULL(disk_find("a/.copy-1"));
    TEST_ASSERT_NULL(disk_find("a/b/.copy-2"));
    TEST_ASSERT_EQUAL_UINT32(2U, st23_fixture.files.counters.removed);
    st23_fixture_step();
    expect_copied("a/one", "x");
    st23_fixture_power_cut();
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
}

/// After a power cut the ground sends its requests again before the first step, with the same numbers.
static void a_copy_that_is_repeated_after_a_power_cut_keeps_its_own_part_file(void)
{
    (void)disk_file("empty", 0U, 0U);
    (void)disk_file("large", SLICE * 4U, 7U);
    st23_fixture_copy(14U, 1U, "", "empty", "", "z");
    st23_fixture_copy(14U, 2U, "", "large", "a/b", "x");
    st23_fixture_copy(14U, 3U, "", "large", "a", "x");
    for (unsigned i = 0U; i < 3U; i++) {
        st23_fixture_step(); // Copy 1 ends, the others begin.
    }
    st23_fixture_power_cut();
    st23_fixture_copy(14U, 3U, "", "large", "a", "x"); // Takes the entry before those that are left.
    EXPECT_MESSAGES(1, 1, 1, 3);
    for (unsigned i = 0U; i < 7U; i++) {
        st23_fixture_step();
    }
    expect_copied("large", "a/x");
    TEST_ASSERT_NULL(disk_find("a/.copy-3"));
    TEST_ASSERT_NULL(disk_find("a/b/.copy-2"));
    TEST_ASSERT_EQUAL_UINT32(0U, st23_fixture.files.counters.failed);
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
    st23_fixture_power_cut();
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files)); // No record is left.
}

static void a_repeated_copy_removes_what_it_left_in_the_first_entry_before_its_first_step(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    st23_fixture_copy(14U, 1U, "", "large", "a", "x");
    st23_fixture_step();
    st23_fixture_power_cut();
    TEST_ASSERT_NOT_NULL(disk_find("a/.copy-1"));
    st23_fixture_copy(14U, 1U, "", "large", "a", "x");
    TEST_ASSERT_NULL(disk_find("a/.copy-1"));
    TEST_ASSERT_EQUAL_UINT32(1U, st23_fixture.files.counters.removed);
}

static void a_copy_that_cannot_be_recorded_is_not_started(void)
{
    records.put_status = STATUS_FULL;
    st23_fixture_copy(14U, 1U, "a", "one", "", "x");
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_FALSE(pus_files_is_busy(&st23_fixture.files));
}

static void without_records_requests_are_performed_and_nothing_is_kept(void)
{
    st23_fixture.persistence = NULL;
    st23_fixture_restart();
    bench.dispatcher.persistence = NULL;
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_expect_done();
    st23_fixture_request(6U, "a", "x");
    st23_fixture_expect_done();
    st23_fixture_copy(14U, 1U, "a", "one", "", "x");
    st23_fixture_step();
    expect_copied("a/one", "x");
    TEST_ASSERT_EQUAL_UINT32(0U, records.puts);
}

// ---- Status report ----

static void report_every(const uint32_t interval)
{
    st23_fixture_begin();
    octet_write_u32(&st23_fixture.writer, interval);
    st23_fixture_send(22U);
}

static void copies_are_reported_at_an_interval(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    report_every(0U);
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    report_every(3U);
    st23_fixture_expect_done();
    st23_fixture_copy(14U, 1U, "", "large", "a", "x");
    st23_fixture_copy(14U, 2U, "", "large", "a/b", "x");
    st23_fixture_change(16U, 2U);
    (void)disk_file("empty", 0U, 0U);
    st23_fixture_step();
    st23_fixture_step();
    st23_fixture_copy(14U, 3U, "", "empty", "a", "y");
    st23_fixture_change(16U, 3U);
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5);
    st23_fixture_step();
    EXPECT_MESSAGES(1, 7, 23, 23);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(1U).destination);
    // Two copies, each with its id (u16), status 2 (on hold) and progress in percent.
    static const uint8_t expected[] = {0, 2, 0, 2, 2, 0, 0, 3, 2, 0};
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(1U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(1U).data, sizeof expected);
    st23_fixture_change(17U, 2U);
    st23_fixture_step();
    st23_fixture_change(16U, 2U);
    // Time jumps: one report replaces all that were due, and the next one comes at its time.
    st23_fixture.cycle += 11U;
    st23_fixture_step();
    EXPECT_MESSAGES(23, 23);
    static const uint8_t quarter[] = {0, 2, 0, 2, 2, 25, 0, 3, 2, 0};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(quarter, bench_report(0U).data, sizeof quarter);
    st23_fixture_step();
    EXPECT_MESSAGES(0);
    st23_fixture_step();
    EXPECT_MESSAGES(23, 23);
    st23_fixture_power_cut();
    for (unsigned i = 0U; i < 3U; i++) { // The interval begins in the first of these steps.
        st23_fixture_step();
        EXPECT_MESSAGES(0);
    }
    st23_fixture_step();
    EXPECT_MESSAGES(23, 23);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(0U).size); // No copies.
    st23_fixture_begin();
    st23_fixture_send(24U);
    st23_fixture_expect_done();
    st23_fixture_send(24U);
    st23_fixture_expect_done();
    for (unsigned i = 0U; i < 10U; i++) {
        st23_fixture_step();
        EXPECT_MESSAGES(0);
    }
}

static void an_interval_that_cannot_be_kept_does_not_count(void)
{
    records.put_status = STATUS_IO;
    report_every(1U);
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
    st23_fixture_step();
    st23_fixture_step();
    EXPECT_MESSAGES(0);
    records.put_status = STATUS_OK;
    report_every(1U);
    records.erase_status = STATUS_IO;
    st23_fixture_begin();
    st23_fixture_send(24U);
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
    st23_fixture_step();
    st23_fixture_step();
    EXPECT_MESSAGES(23, 23);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_file_is_copied_slice_by_slice);
    RUN_TEST(copies_are_continued_in_turn);
    RUN_TEST(an_empty_file_is_copied);
    RUN_TEST(an_invalid_copy_is_refused);
    RUN_TEST(a_file_being_copied_cannot_be_changed);
    RUN_TEST(a_file_is_moved_at_once);
    RUN_TEST(a_failed_copy_leaves_no_file);
    RUN_TEST(a_source_that_becomes_shorter_fails_the_copy);
    RUN_TEST(a_part_file_that_was_left_over_is_replaced);
    RUN_TEST(copies_are_suspended_resumed_and_aborted);
    RUN_TEST(copies_of_a_path_are_changed);
    RUN_TEST(after_a_power_cut_nothing_of_an_incomplete_copy_remains);
    RUN_TEST(a_copy_that_is_repeated_after_a_power_cut_keeps_its_own_part_file);
    RUN_TEST(a_repeated_copy_removes_what_it_left_in_the_first_entry_before_its_first_step);
    RUN_TEST(a_copy_that_cannot_be_recorded_is_not_started);
    RUN_TEST(without_records_requests_are_performed_and_nothing_is_kept);
    RUN_TEST(copies_are_reported_at_an_interval);
    RUN_TEST(an_interval_that_cannot_be_kept_does_not_count);
    return UNITY_END();
}
