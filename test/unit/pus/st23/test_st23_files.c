// SPDX-License-Identifier: Apache-2.0
// Files, locks and directories of the file service. The numbers of requests and reports are subtypes;
// pus/catalogue/st23_files.txt has their names and fields.
#include "pus/st23/st23_files.h"

#include "test/support/disk.h"
#include "test/unit/pus/fixtures/st23_fixture.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    st23_fixture_start();
}

void tearDown(void)
{
    records_start();
}

// ---- Files ----

static void files_are_created_and_deleted(void)
{
    st23_fixture_create("/a", "new", 5000U, 0U);
    st23_fixture_expect_done();
    TEST_ASSERT_NOT_NULL(disk_find("a/new"));
    TEST_ASSERT_EQUAL_UINT64(5000U, disk.room);
    st23_fixture_create("a", "new", 0U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 3U);
    st23_fixture_create("", "top", SIZE_MAX_OF_FILE, 0U);
    st23_fixture_expect_done();
    st23_fixture_create("", "top2", SIZE_MAX_OF_FILE + 1U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 8U);
    st23_fixture_create("", "top2", 0U, 2U);
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 12U);
    st23_fixture_create("no", "x", 0U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 4U);
    st23_fixture_create("..", "x", 0U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    st23_fixture_create("a", "..", 0U, 0U);
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
    st23_fixture_request(2U, "/a", "new");
    st23_fixture_expect_done();
    TEST_ASSERT_NULL(disk_find("a/new"));
    st23_fixture_request(2U, "a", "new");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(2U, "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(2U, "a", "*");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
    TEST_ASSERT_EQUAL_UINT32(9U, st23_fixture.files.counters.refused);
}

static void failures_of_the_file_store_are_reported(void)
{
    static const status_t failures[] = {STATUS_IO, STATUS_FULL, STATUS_DENIED};
    for (size_t i = 0U; i < 3U; i++) {
        disk.failure   = failures[i];
        disk.fail_call = disk.calls + 1U;
        st23_fixture_create("a", "new", 1U, 0U);
        st23_fixture_expect_failed(PUS_FAILURE_IO, (uint32_t)failures[i]);
        TEST_ASSERT_NULL(disk_find("a/new"));
    }
    disk.failure   = STATUS_INVALID;
    disk.fail_call = disk.calls + 1U;
    st23_fixture_request(9U, "a", "x");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
}

static void attributes_are_reported(void)
{
    st23_fixture_request(3U, "/a/b", "two");
    EXPECT_MESSAGES(1, 1, 1, 3, 23, 4, 1, 7);
    octet_reader_t reader = bench_data(2U);
    st23_fixture_expect_text(&reader, "/a/b");
    st23_fixture_expect_text(&reader, "two");
    TEST_ASSERT_EQUAL_UINT32(20U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    (void)disk_file("large", 0x100000000ULL, 0U);
    st23_fixture_request(5U, "", "large");
    st23_fixture_request(3U, "", "large");
    reader = bench_data(2U);
    st23_fixture_expect_text(&reader, "/");
    st23_fixture_expect_text(&reader, "large");
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT8(1U, octet_read_u8(&reader));
    st23_fixture_request(3U, "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(3U, "a", "");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
}

// ---- Locks ----

static void a_locked_file_is_neither_changed_nor_deleted(void)
{
    st23_fixture_request(5U, "a", "one");
    st23_fixture_expect_done();
    st23_fixture_request(5U, "/a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 4U);
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_copy(15U, 1U, "a", "one", "", "moved");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 5U);
    st23_fixture_rename("", "a", "z");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 2U);
    st23_fixture_copy(14U, 1U, "a", "one", "", "copied"); // The file is only read.
    EXPECT_MESSAGES(1, 1, 1, 3);
    st23_fixture_step();
    EXPECT_MESSAGES(1, 5, 1, 5, 1, 5, 1, 7);
    st23_fixture_request(6U, "a", "one");
    st23_fixture_expect_done();
    st23_fixture_request(6U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_done();
    st23_fixture_request(6U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(5U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(5U, "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(5U, "a", ".");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
    st23_fixture_request(6U, "a", ".");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
}

static void a_lock_beyond_the_table_is_refused(void)
{
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_expect_done();
    st23_fixture_request(5U, "a", "one");
    st23_fixture_request(5U, "a/b", "two");
    st23_fixture_create("a", "y", 0U, 1U);
    st23_fixture_expect_refused(PUS_FAILURE_TABLE_FULL, LOCKS);
    TEST_ASSERT_NULL(disk_find("a/y"));
    (void)disk_file("a/y", 1U, 1U);
    st23_fixture_request(5U, "a", "y");
    st23_fixture_expect_refused(PUS_FAILURE_TABLE_FULL, LOCKS);
    st23_fixture_request(6U, "a", "one");
    st23_fixture_request(5U, "a", "y");
    st23_fixture_expect_done();
}

static void locks_outlast_a_power_cut(void)
{
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_request(5U, "a", "one");
    st23_fixture_request(5U, "a/b", "two");
    st23_fixture_request(6U, "a", "one");
    st23_fixture_power_cut();
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_done();
    st23_fixture_request(2U, "a", "x");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_request(2U, "a/b", "two");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 5U);
}

static void a_lock_that_cannot_be_kept_is_not_taken(void)
{
    records.put_status = STATUS_FULL;
    st23_fixture_request(5U, "a", "one");
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_FULL);
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_NULL(disk_find("a/x"));
    records.put_status = STATUS_OK;
    st23_fixture_request(5U, "a", "one");
    st23_fixture_expect_done();
    records.erase_status = STATUS_IO;
    st23_fixture_request(6U, "a", "one");
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
}

static void a_lock_without_its_file_ends_with_a_power_cut(void)
{
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_expect_done();
    disk_remove("a/x"); // As if the power had been cut between the lock and the file.
    st23_fixture_power_cut();
    st23_fixture_step();
    st23_fixture_create("a", "x", 0U, 0U);
    st23_fixture_expect_done();
    st23_fixture_request(2U, "a", "x");
    st23_fixture_expect_done();
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_power_cut();
    st23_fixture_request(5U, "a", "one"); // A lock taken after the restart, before the first step.
    st23_fixture_step();
    st23_fixture_request(2U, "a", "x");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_request(2U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
}

static void a_file_is_locked_before_it_is_made(void)
{
    st23_fixture_create("a", "one", 0U, 1U);
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 3U);
    st23_fixture_create("no", "x", 0U, 1U);
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 4U);
    records.commit_status = STATUS_IO;
    st23_fixture_create("a", "x", 0U, 1U);
    st23_fixture_expect_failed(PUS_FAILURE_IO, STATUS_IO);
    TEST_ASSERT_NULL(disk_find("a/x"));
    records.commit_status = STATUS_OK;
    st23_fixture_request(2U, "a", "one"); // None of these files is locked.
    st23_fixture_expect_done();
    st23_fixture_create("a", "x", 0U, 0U);
    st23_fixture_request(2U, "a", "x");
    st23_fixture_expect_done();
}

/// Keys of the records: locks from 0, copies from 0x10000, the interval of the status report 0x20000.
static void bad_records_are_refused(void)
{
    static const uint8_t path[PUS_FILE_PATH_SIZE] = {'a', 0, 'b'};
    static uint8_t longest[PUS_FILE_PATH_SIZE];
    memset(longest, 'a', sizeof longest);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_files_restore(&st23_fixture.files, LOCKS, path, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_files_restore(&st23_fixture.files, 0x10000U + COPIES, path, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_files_restore(&st23_fixture.files, 0x20001U, path, 4U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_files_restore(&st23_fixture.files, 0x20000U, path, 3U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_files_restore(&st23_fixture.files, 0U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_files_restore(&st23_fixture.files, 0U, path, 3U));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_files_restore(&st23_fixture.files, 0x10000U, longest, PUS_FILE_PATH_SIZE));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pus_files_restore(&st23_fixture.files, 0x10000U, longest, PUS_FILE_PATH_SIZE - 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_files_restore(&st23_fixture.files, LOCKS - 1U, path, 1U));
}

// ---- Directories ----

static void directories_are_created_renamed_and_deleted(void)
{
    st23_fixture_request(9U, "/a", "c");
    st23_fixture_expect_done();
    st23_fixture_request(9U, "a", "c");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 3U);
    st23_fixture_request(9U, "no", "c");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 4U);
    st23_fixture_request(9U, "a", "c/d");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
    st23_fixture_request(10U, "a", "b");
    st23_fixture_expect_refused(PUS_FAILURE_STATE, 3U);
    st23_fixture_request(10U, "a", "one");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_request(10U, "a", "");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
    st23_fixture_request(10U, "a", "c");
    st23_fixture_expect_done();
    st23_fixture_rename("a", "b", "z");
    st23_fixture_expect_done();
    TEST_ASSERT_NOT_NULL(disk_find("a/z/two"));
    st23_fixture_rename("a", "z", "one");
    st23_fixture_expect_refused(PUS_FAILURE_EXISTS, 6U);
    st23_fixture_rename("a", "b", "y");
    st23_fixture_expect_refused(PUS_FAILURE_UNKNOWN_ID, 3U);
    st23_fixture_rename("a", "z", "..");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 6U);
    st23_fixture_rename("a", "", "z");
    st23_fixture_expect_refused(PUS_FAILURE_OUT_OF_RANGE, 3U);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t two_texts[] = {0, 1, 'a', 0, 1, 'b'};
    static const uint8_t subtypes[]  = {2, 3, 5, 6, 7, 9, 10};
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        expect_strict_format(subtypes[i], two_texts, sizeof two_texts);
    }
    expect_strict_format(1U, (const uint8_t[]){0, 1, 'a', 0, 1, 'b', 0, 0, 0, 1, 0}, 11U);
    expect_strict_format(11U, (const uint8_t[]){0, 1, 'a', 0, 1, 'b', 0, 1, 'c'}, 9U);
    expect_strict_format(12U, (const uint8_t[]){0, 1, 'a'}, 3U);
    expect_strict_format(14U, (const uint8_t[]){0, 1, 0, 1, 'a', 0, 1, 'b', 0, 0, 0, 1, 'c'}, 13U);
    expect_strict_format(15U, (const uint8_t[]){0, 1, 0, 1, 'a', 0, 1, 'b', 0, 0, 0, 1, 'c'}, 13U);
    for (uint8_t subtype = 16U; subtype <= 18U; subtype++) {
        expect_strict_format(subtype, (const uint8_t[]){2, 0, 1, 0, 2}, 5U);
    }
    for (uint8_t subtype = 19U; subtype <= 21U; subtype++) {
        expect_strict_format(subtype, (const uint8_t[]){0, 1, 'a'}, 3U);
    }
    expect_strict_format(22U, (const uint8_t[]){0, 0, 0, 1}, 4U);
    expect_strict_format(24U, NULL, 0U);
    for (uint8_t subtype = 0U; subtype < 30U; subtype++) {
        const bool is_request = (subtype >= 1U) && (subtype <= 24U) && (subtype != 4U) && (subtype != 8U) &&
                                (subtype != 13U) && (subtype != 23U);
        st23_fixture_begin();
        octet_write_u8(&st23_fixture.writer, 0U);
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, st23_fixture.data, 1U));
        expect_failure(0U, 2U, is_request ? PUS_FAILURE_DATA : PUS_FAILURE_SUBTYPE, 0U,
                       is_request ? bench_report(0U).data[11] : ((23U << 8U) | subtype));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(files_are_created_and_deleted);
    RUN_TEST(failures_of_the_file_store_are_reported);
    RUN_TEST(attributes_are_reported);
    RUN_TEST(a_locked_file_is_neither_changed_nor_deleted);
    RUN_TEST(a_lock_beyond_the_table_is_refused);
    RUN_TEST(locks_outlast_a_power_cut);
    RUN_TEST(a_lock_that_cannot_be_kept_is_not_taken);
    RUN_TEST(a_lock_without_its_file_ends_with_a_power_cut);
    RUN_TEST(a_file_is_locked_before_it_is_made);
    RUN_TEST(bad_records_are_refused);
    RUN_TEST(directories_are_created_renamed_and_deleted);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
