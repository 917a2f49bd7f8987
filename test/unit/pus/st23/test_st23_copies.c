// SPDX-License-Identifier: Apache-2.0
// Copies of the file service: TC[23,14] to [23,24].
#include "pus/st23/st23_files.h"

#include "test/support/disk.h"
#include "test/unit/pus/fixtures/filing.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define SLICE PUS_FILE_SLICE

void setUp(void)
{
    filing_start();
}

void tearDown(void)
{
    records_start();
}

// --- copies ------------------------------------------------------------------------------------------------

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
    filing_order(14U, 5U, "/a", "large", "/a/b", "copy");
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_TRUE(pus_files_is_busy(&filing.files));
    filing_step();
    EXPECT_MESSAGES(0);
    TEST_ASSERT_NULL(disk_find("a/b/copy"));
    TEST_ASSERT_NOT_NULL(disk_find("a/b/.copy-5"));
    filing_step();
    EXPECT_MESSAGES(1, 5);
    filing_step();
    EXPECT_MESSAGES(1, 5);
    filing_step();
    EXPECT_MESSAGES(1, 5);
    octet_reader_t reader = bench_data(0U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_UINT16(75U, octet_read_u16(&reader));
    filing_step();
    EXPECT_MESSAGES(1, 7);
    TEST_ASSERT_FALSE(pus_files_is_busy(&filing.files));
    expect_copied("a/large", "a/b/copy");
    TEST_ASSERT_NULL(disk_find("a/b/.copy-5"));
    TEST_ASSERT_EQUAL_UINT64((SLICE * 4U) + 1U, disk.room);
    TEST_ASSERT_EQUAL_UINT32(1U, disk.syncs);
    TEST_ASSERT_EQUAL_UINT32(1U, filing.files.counters.copied);
    TEST_ASSERT_EQUAL_UINT32(1U, records.erasures);
    const unsigned calls = disk.calls;
    filing_step();
    TEST_ASSERT_EQUAL_UINT32(calls, disk.calls); // Nothing to do costs nothing.
}

static void copies_take_turns(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    filing.slices = 3U;
    filing_restart();
    filing_order(14U, 1U, "", "large", "", "x");
    filing_order(14U, 2U, "a", "one", "", "y");
    filing_step(); // large, one, large
    EXPECT_MESSAGES(1, 5, 1, 5, 1, 5, 1, 5, 1, 7, 1, 5);
    expect_copied("a/one", "y");
    filing_step();
    EXPECT_MESSAGES(1, 5, 1, 7);
    expect_copied("large", "x");
}

static void an_empty_file_is_copied(void)
{
    (void)disk_file("empty", 0U, 0U);
    filing_order(14U, 1U, "", "empty", "", "x");
    filing_step();
    EXPECT_MESSAGES(1, 7);
    expect_copied("empty", "x");
}

static void what_cannot_be_copied_is_refused(void)
{
    filing_order(14U, 1U, "a", "no", "", "x");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    filing_order(14U, 1U, "a", "b", "", "x");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    filing_order(14U, 1U, "a", "one", "no", "x");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 10U);
    filing_order(14U, 1U, "a", "one", "a/one", "x");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 10U);
    filing_order(14U, 1U, "a", "one", "a", "one");
    filing_refused(PUS_FAILURE_EXISTS, 13U);
    filing_order(14U, 1U, "a", "one", "a", "b");
    filing_refused(PUS_FAILURE_EXISTS, 13U);
    filing_order(14U, 1U, "a/", "one", "a", "x");
    filing_refused(PUS_FAILURE_OUT_OF_RANGE, 2U);
    filing_order(14U, 1U, "a", "one", "a", "x?");
    filing_refused(PUS_FAILURE_OUT_OF_RANGE, 13U);
    filing_order(14U, 1U, "a", "one", "a", "x");
    EXPECT_MESSAGES(1, 1, 1, 3);
    filing_order(14U, 1U, "a", "one", "a", "y");
    filing_refused(PUS_FAILURE_EXISTS, 1U);
    filing_order(14U, 2U, "a", "one", "a", "x");
    filing_refused(PUS_FAILURE_EXISTS, 13U);
    filing_order(14U, 2U, "a", "one", "a", "y");
    filing_order(14U, 3U, "a", "one", "a", "z");
    EXPECT_MESSAGES(1, 1, 1, 3);
    filing_order(14U, 4U, "a", "one", "a", "w");
    filing_refused(PUS_FAILURE_TABLE_FULL, COPIES);
    disk.fail_call = disk.calls + 3U; // The look at the target.
    filing_order(14U, 4U, "a", "one", "a", "w");
    filing_failed(PUS_FAILURE_IO, STATUS_IO);
}

static void what_is_being_copied_stays_as_it_is(void)
{
    filing_order(14U, 1U, "a", "one", "a/b", "x");
    filing_request(2U, "a", "one");
    filing_refused(PUS_FAILURE_STATE, 3U);
    filing_request(10U, "a", "b");
    filing_refused(PUS_FAILURE_STATE, 3U);
    filing_order(15U, 2U, "a", "one", "", "y");
    filing_refused(PUS_FAILURE_STATE, 5U);
    filing_create("a/b", "x", 0U, 0U);
    filing_refused(PUS_FAILURE_EXISTS, 5U);
    filing_request(9U, "a/b", "x");
    filing_refused(PUS_FAILURE_EXISTS, 5U);
    filing_rename("a", "b", "z");
    filing_refused(PUS_FAILURE_STATE, 3U);
    disk_directory("c");
    filing_order(14U, 2U, "a", "one", "", "d");
    filing_rename("", "c", "d");
    filing_refused(PUS_FAILURE_EXISTS, 5U);
}

static void a_file_is_moved_at_once(void)
{
    filing_order(15U, 1U, "a", "one", "a/b", "moved");
    filing_done();
    TEST_ASSERT_NULL(disk_find("a/one"));
    TEST_ASSERT_EQUAL_UINT64(10U, disk_find("a/b/moved")->size);
    filing_order(15U, 1U, "a", "one", "a/b", "x");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 5U);
    disk.fail_call = disk.calls + 4U; // The renaming.
    filing_order(15U, 1U, "a/b", "moved", "a", "one");
    filing_failed(PUS_FAILURE_IO, STATUS_IO);
}

/// Each call of the store fails once: the copy ends with a failure, and nothing is left.
static void a_copy_that_fails_leaves_nothing(void)
{
    for (unsigned i = 1U; i <= 6U; i++) { // Make, read, write, read, sync and rename.
        memset(disk.files, 0, sizeof(disk.files));
        disk.contents = 0U;
        disk_directory("");
        (void)disk_file("large", SLICE + 1U, 7U);
        filing_order(14U, 1U, "", "large", "", "x");
        disk.fail_call = disk.calls + ((i < 4U) ? i : (i + 1U));
        filing_step();
        if (i >= 4U) {
            filing_step();
        }
        expect_failure(bench.count - 1U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
        TEST_ASSERT_EQUAL_UINT32(i, filing.files.counters.failed);
        TEST_ASSERT_NULL(disk_find("x"));
        TEST_ASSERT_NULL(disk_find(".copy-1"));
        TEST_ASSERT_FALSE(pus_files_is_busy(&filing.files));
    }
}

static void a_source_that_becomes_shorter_fails_the_copy(void)
{
    disk_file_t* const source = disk_file("large", SLICE * 2U, 7U);
    filing_order(14U, 1U, "", "large", "", "x");
    filing_step();
    source->size = SLICE;
    filing_step();
    EXPECT_MESSAGES(1, 6, 1, 8);
    expect_failure(1U, 8U, PUS_FAILURE_IO, 0U, STATUS_TRUNCATED);
}

static void a_part_of_somebody_else_is_replaced(void)
{
    (void)disk_file(".copy-1", 100U, 7U);
    filing_order(14U, 1U, "a", "one", "", "x");
    filing_step();
    expect_copied("a/one", "x");
    TEST_ASSERT_NULL(disk_find(".copy-1"));
}

static void copies_are_suspended_resumed_and_aborted(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    filing_order(14U, 1U, "", "large", "", "x");
    filing_change(17U, 1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, 1U);
    filing_change(16U, 1U);
    filing_done();
    TEST_ASSERT_FALSE(pus_files_is_busy(&filing.files));
    filing_step();
    TEST_ASSERT_NULL(disk_find(".copy-1"));
    filing_change(16U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, 1U);
    filing_change(17U, 1U);
    filing_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, filing.copies[0].status);
    filing_step();
    filing_change(16U, 1U);
    filing_step();
    EXPECT_MESSAGES(0);
    filing_change(17U, 1U);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_RUNNING, filing.copies[0].status);
    filing_begin();
    octet_write_u8(&filing.writer, 3U);
    octet_write_u16(&filing.writer, 9U);
    octet_write_u16(&filing.writer, 1U);
    octet_write_u16(&filing.writer, 1U);
    filing_send(18U);
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
    TEST_ASSERT_EQUAL_UINT32(1U, filing.files.counters.aborted);
}

static void copies_of_a_path_are_changed(void)
{
    disk_directory("ab");
    filing_order(14U, 1U, "a", "one", "", "x");
    filing_order(14U, 2U, "a/b", "two", "ab", "x");
    (void)disk_file("top", 1U, 1U);
    filing_order(14U, 3U, "", "top", "ab", "y");
    filing_change_path(19U, "/a");
    filing_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, filing.copies[0].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, filing.copies[1].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, filing.copies[2].status);
    filing_change_path(19U, "/");
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, filing.copies[2].status);
    filing_change_path(20U, "a/b");
    filing_done();
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_ON_HOLD, filing.copies[0].status);
    TEST_ASSERT_EQUAL(PUS_FILE_COPY_PENDING, filing.copies[1].status);
    filing_change_path(21U, "ab");
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8, 1, 8, 1, 7);
    filing_change_path(21U, "ab");
    filing_done();
    filing_change_path(21U, "no");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 0U);
    filing_change_path(20U, "a/one");
    filing_refused(PUS_FAILURE_UNKNOWN_ID, 0U);
    filing_change_path(19U, "a/../b");
    filing_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    TEST_ASSERT_EQUAL_UINT32(2U, filing.files.counters.aborted);
}

static void a_power_cut_leaves_nothing_of_a_copy(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    filing_order(14U, 1U, "", "large", "a", "x");
    filing_order(14U, 2U, "", "large", "a/b", "x");
    filing_step();
    filing_step();
    TEST_ASSERT_NOT_NULL(disk_find("a/.copy-1"));
    filing_power_cut();
    TEST_ASSERT_TRUE(pus_files_is_busy(&filing.files));
    filing_order(14U, 3U, "a", "one", "", "x");
    filing_order(14U, 4U, "a", "one", "", "y"); // Two of three are still taken.
    filing_refused(PUS_FAILURE_TABLE_FULL, COPIES);
    filing_change(18U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 1U);
    filing_step();
    filing_step();
    TEST_ASSERT_NULL(disk_find("a/.copy-1"));
    TEST_ASSERT_NULL(disk_find("a/b/.copy-2"));
    TEST_ASSERT_EQUAL_UINT32(2U, filing.files.counters.removed);
    filing_step();
    expect_copied("a/one", "x");
    filing_power_cut();
    TEST_ASSERT_FALSE(pus_files_is_busy(&filing.files));
}

static void a_copy_that_cannot_be_noted_is_not_begun(void)
{
    records.put_status = STATUS_FULL;
    filing_order(14U, 1U, "a", "one", "", "x");
    filing_failed(PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_FALSE(pus_files_is_busy(&filing.files));
}

static void without_records_all_works_but_nothing_is_kept(void)
{
    filing.persistence = NULL;
    filing_restart();
    bench.dispatcher.persistence = NULL;
    filing_create("a", "x", 0U, 1U);
    filing_done();
    filing_request(6U, "a", "x");
    filing_done();
    filing_order(14U, 1U, "a", "one", "", "x");
    filing_step();
    expect_copied("a/one", "x");
    TEST_ASSERT_EQUAL_UINT32(0U, records.puts);
}

// --- status report -----------------------------------------------------------------------------------------

static void report_every(const uint32_t interval)
{
    filing_begin();
    octet_write_u32(&filing.writer, interval);
    filing_send(22U);
}

static void copies_are_reported_at_an_interval(void)
{
    (void)disk_file("large", SLICE * 4U, 7U);
    report_every(0U);
    filing_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    report_every(3U);
    filing_done();
    filing_order(14U, 1U, "", "large", "a", "x");
    filing_order(14U, 2U, "", "large", "a/b", "x");
    filing_change(16U, 2U);
    (void)disk_file("empty", 0U, 0U);
    filing_step();
    filing_step();
    filing_order(14U, 3U, "", "empty", "a", "y");
    filing_change(16U, 3U);
    filing_step();
    EXPECT_MESSAGES(1, 5);
    filing_step();
    EXPECT_MESSAGES(1, 7, 23, 23);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(1U).destination);
    static const uint8_t expected[] = {0, 2, 0, 2, 2, 0, 0, 3, 2, 0};
    TEST_ASSERT_EQUAL_UINT64(sizeof(expected), bench_report(1U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(1U).data, sizeof(expected));
    filing_change(17U, 2U);
    filing_step();
    filing_change(16U, 2U);
    filing.cycle += 11U; // Time may jump: one report for all that were due, the next one at its time.
    filing_step();
    EXPECT_MESSAGES(23, 23);
    static const uint8_t quarter[] = {0, 2, 0, 2, 2, 25, 0, 3, 2, 0};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(quarter, bench_report(0U).data, sizeof(quarter));
    filing_step();
    EXPECT_MESSAGES(0);
    filing_step();
    EXPECT_MESSAGES(23, 23);
    filing_power_cut();
    filing_step(); // Known from here on; and what is left of copies is removed.
    filing_step();
    filing_step();
    EXPECT_MESSAGES(0);
    filing_step();
    EXPECT_MESSAGES(23, 23);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(0U).size); // No copies.
    filing_begin();
    filing_send(24U);
    filing_done();
    filing_send(24U);
    filing_done();
    for (unsigned i = 0U; i < 10U; i++) {
        filing_step();
        EXPECT_MESSAGES(0);
    }
}

static void an_interval_that_cannot_be_kept_does_not_count(void)
{
    records.put_status = STATUS_IO;
    report_every(1U);
    filing_failed(PUS_FAILURE_IO, STATUS_IO);
    filing_step();
    filing_step();
    EXPECT_MESSAGES(0);
    records.put_status = STATUS_OK;
    report_every(1U);
    records.erase_status = STATUS_IO;
    filing_begin();
    filing_send(24U);
    filing_failed(PUS_FAILURE_IO, STATUS_IO);
    filing_step();
    filing_step();
    EXPECT_MESSAGES(23, 23);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_file_is_copied_slice_by_slice);
    RUN_TEST(copies_take_turns);
    RUN_TEST(an_empty_file_is_copied);
    RUN_TEST(what_cannot_be_copied_is_refused);
    RUN_TEST(what_is_being_copied_stays_as_it_is);
    RUN_TEST(a_file_is_moved_at_once);
    RUN_TEST(a_copy_that_fails_leaves_nothing);
    RUN_TEST(a_source_that_becomes_shorter_fails_the_copy);
    RUN_TEST(a_part_of_somebody_else_is_replaced);
    RUN_TEST(copies_are_suspended_resumed_and_aborted);
    RUN_TEST(copies_of_a_path_are_changed);
    RUN_TEST(a_power_cut_leaves_nothing_of_a_copy);
    RUN_TEST(a_copy_that_cannot_be_noted_is_not_begun);
    RUN_TEST(without_records_all_works_but_nothing_is_kept);
    RUN_TEST(copies_are_reported_at_an_interval);
    RUN_TEST(an_interval_that_cannot_be_kept_does_not_count);
    return UNITY_END();
}
