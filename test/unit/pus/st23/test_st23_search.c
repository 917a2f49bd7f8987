// SPDX-License-Identifier: Apache-2.0
// Searches of the file service: TC[23,7] and TC[23,12], whose answers take several steps and reports; their
// fields are in pus/catalogue/st23_files.txt.
#include "pus/st23/st23_files.h"

#include "test/support/disk.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define SEARCHES 2U
#define STEPS_MAX 2000U

static pus_files_t files;
static pus_file_lock_t locks[1];
static pus_file_copy_t copies[1];
static pus_file_search_t searches[SEARCHES];
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

void setUp(void)
{
    bench_start();
    disk_start();
    memset(&files, 0xA5, sizeof files);
    pus_files_init(&files, &(pus_files_config_t){.store        = disk_store(),
                                                 .process      = &bench.process,
                                                 .locks        = locks,
                                                 .lock_count   = 1U,
                                                 .copies       = copies,
                                                 .copy_count   = 1U,
                                                 .searches     = searches,
                                                 .search_count = SEARCHES,
                                                 .slices       = 1U});
    bench_serve(pus_files_service(&files));
}

void tearDown(void)
{
}

static void add_text(const char* const text)
{
    octet_write_u16(&writer, (uint16_t)strlen(text));
    octet_write_octets(&writer, (const uint8_t*)text, strlen(text));
}

static void find(const char* const path, const char* const pattern)
{
    writer = octet_writer(data, sizeof data);
    add_text(path);
    add_text(pattern);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, data, writer.position));
}

static void summarise(const char* const path)
{
    writer = octet_writer(data, sizeof data);
    add_text(path);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(12U, data, writer.position));
}

static void step(void)
{
    bench_step(TEST_NOW_NS, 1U);
}

/// Step until the service has no work any more. Returns the number of steps.
static unsigned run(void)
{
    unsigned steps = 0U;
    while (pus_files_is_busy(&files)) {
        TEST_ASSERT_TRUE(steps < STEPS_MAX);
        step();
        steps++;
    }
    return steps;
}

static void expect_text(octet_reader_t* const reader, const char* const expected)
{
    const uint16_t size        = octet_read_u16(reader);
    const uint8_t* const found = octet_read_octets(reader, size);
    TEST_ASSERT_NOT_NULL(found);
    TEST_ASSERT_EQUAL_UINT16(strlen(expected), size);
    TEST_ASSERT_EQUAL_MEMORY(expected, found, size);
}

/// Expect that report `index` is an answer about `path`. Returns a reader at its first entry.
static octet_reader_t answer(const size_t index, const char* const path, const char* const pattern,
                             uint16_t* const out_count)
{
    octet_reader_t reader = bench_data(index);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(index).destination);
    expect_text(&reader, path);
    if (pattern != NULL) {
        expect_text(&reader, pattern);
    }
    *out_count = octet_read_u16(&reader);
    return reader;
}

static void expect_found(const char* const path, const char* const pattern, const char* const* const expected)
{
    uint16_t count = 0U;
    find(path, pattern);
    EXPECT_MESSAGES(1, 1, 1, 3);
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 8, 1, 7);
    octet_reader_t reader = answer(0U, path, pattern, &count);
    for (uint16_t i = 0U; i < count; i++) {
        TEST_ASSERT_NOT_NULL(expected[i]);
        expect_text(&reader, expected[i]);
    }
    TEST_ASSERT_NULL(expected[count]);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void create_files(void)
{
    static const char* const directories[] = {"a", "a/b", "a/b/c", "a/empty", "d"};
    static const char* const names[]       = {"x.txt",       "a/a.txt", "a/b/b.txt", "a/b/c/c.txt",
                                              "a/b/c/c.bin", "a/z.txt", "d/ab",      "y"};
    for (size_t i = 0U; i < 5U; i++) {
        disk_directory(directories[i]);
    }
    for (size_t i = 0U; i < 8U; i++) {
        (void)disk_file(names[i], 0U, 0U);
    }
}

static void files_are_found_below_a_directory(void)
{
    create_files();
    expect_found("/", "*.txt",
                 (const char* const[]){"/a/a.txt", "/a/b/b.txt", "/a/b/c/c.txt", "/a/z.txt", "/x.txt", NULL});
    expect_found("/a/b", "c.*", (const char* const[]){"/a/b/c/c.bin", "/a/b/c/c.txt", NULL});
    expect_found("/a", "b", (const char* const[]){NULL}); // It is a directory.
    expect_found("/a/empty", "*", (const char* const[]){NULL});
    expect_found("/", "??", (const char* const[]){"/d/ab", NULL});
    expect_found("/", "y", (const char* const[]){"/y", NULL});
    // The search passes a.txt before it enters the directory b. There it must begin with the first name: "0"
    // sorts before "a.txt".
    (void)disk_file("a/b/0", 0U, 0U);
    expect_found("/a", "0", (const char* const[]){"/a/b/0", NULL});
    // Without a search the service does not access the disk.
    const unsigned calls = disk.calls;
    step();
    TEST_ASSERT_EQUAL_UINT32(calls, disk.calls);
}

static void an_invalid_search_is_refused(void)
{
    create_files();
    find("/a/no", "*");
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 0U);
    find("/y", "*");
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 0U);
    find("/a/..", "*");
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    find("/a", "");
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 4U);
    find("/a", "b/*");
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 4U);
    summarise("/y");
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 0U);
    summarise("a//b");
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    disk.fail_call = disk.calls + 1U;
    summarise("/a");
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    summarise("/a");
    find("/a", "*");
    EXPECT_MESSAGES(1, 1, 1, 3);
    find("/a", "*");
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, SEARCHES);
    TEST_ASSERT_EQUAL_UINT32(8U, files.counters.refused);
}

static void a_directory_is_summarised(void)
{
    uint16_t count = 0U;
    create_files();
    summarise("a");
    bench_clear();
    TEST_ASSERT_EQUAL_UINT32(1U, run());
    EXPECT_MESSAGES(23, 13, 1, 7);
    octet_reader_t reader = answer(0U, "/a", NULL, &count);
    TEST_ASSERT_EQUAL_UINT16(4U, count);
    static const char* const names[] = {"a.txt", "b", "empty", "z.txt"};
    static const uint8_t types[]     = {1, 0, 0, 1};
    for (size_t i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL_UINT8(types[i], octet_read_u8(&reader));
        expect_text(&reader, names[i]);
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

/// 600 files in one directory with names of 11 characters: the answer has several reports, and each file
/// occurs once. One step lists at most PUS_FILE_BATCH (16) entries; a few more steps send the reports.
static void long_answers_become_several_reports(void)
{
    char name[32];
    disk_directory("long");
    for (unsigned i = 0U; i < 600U; i++) {
        (void)snprintf(name, sizeof name, "long/file%03u.dat", (i * 7U) % 600U);
        (void)disk_file(name, 0U, 0U);
    }
    for (unsigned k = 0U; k < 2U; k++) {
        const bool is_find = (k == 0U);
        unsigned all       = 0U;
        if (is_find) {
            find("/long", "f*");
        } else {
            summarise("/long");
        }
        bench_clear();
        const unsigned steps = run();
        TEST_ASSERT_TRUE((steps >= (600U / PUS_FILE_BATCH)) && (steps < 50U));
        TEST_ASSERT_EQUAL_UINT64(4U, bench.count);
        for (size_t i = 0U; (i + 1U) < bench.count; i++) {
            uint16_t count        = 0U;
            octet_reader_t reader = answer(i, "/long", is_find ? "f*" : NULL, &count);
            for (uint16_t n = 0U; n < count; n++) {
                (void)snprintf(name, sizeof name, "%sfile%03u.dat", is_find ? "/long/" : "", all);
                TEST_ASSERT_TRUE(is_find || (octet_read_u8(&reader) == 1U));
                expect_text(&reader, name);
                all++;
            }
            TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
        }
        TEST_ASSERT_EQUAL_UINT32(600U, all);
    }
}

/// Reports that the port refuses are sent in a later step; the search waits for them.
static void a_port_that_refuses_reports_delays_the_search(void)
{
    char name[32];
    unsigned all = 0U;
    for (unsigned i = 0U; i < 300U; i++) {
        (void)snprintf(name, sizeof name, "file-of-some-length-%03u", i);
        (void)disk_file(name, 0U, 0U);
    }
    find("/", "*");
    bench_clear();
    bench.refusals = 1000U;
    for (unsigned i = 0U; i < 60U; i++) {
        step();
    }
    TEST_ASSERT_TRUE(pus_files_is_busy(&files));
    TEST_ASSERT_EQUAL_UINT32(0U, bench.process.counters.lost);
    bench.refusals = 0U;
    for (unsigned i = 0U; pus_files_is_busy(&files); i++) {
        TEST_ASSERT_TRUE(i < STEPS_MAX);
        bench.refusals = ((i % 3U) == 0U) ? 0U : 100U;
        step();
    }
    bench.refusals = 0U;
    step();
    EXPECT_MESSAGES(23, 8, 23, 8, 1, 7);
    for (size_t i = 0U; i < 2U; i++) {
        uint16_t count        = 0U;
        octet_reader_t reader = answer(i, "/", "*", &count);
        for (uint16_t n = 0U; n < count; n++) {
            (void)snprintf(name, sizeof name, "/file-of-some-length-%03u", all);
            expect_text(&reader, name);
            all++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(300U, all);
}

static void the_last_report_is_tried_again(void)
{
    create_files();
    summarise("/a");
    bench_clear();
    bench.refusals = 1U;
    step();
    EXPECT_MESSAGES(0);
    step();
    EXPECT_MESSAGES(23, 13, 1, 7);
}

/// Exactly as many entries as fit are sent in one report.
static void no_empty_report_follows_a_full_one(void)
{
    char name[PUS_FILE_NAME_MAX + 1U];
    const size_t room = PUS_TM_DATA_MAX - 5U; // Path "/" and the count.
    size_t used       = 0U;
    for (unsigned i = 0U; used < room; i++) {
        const size_t left   = room - used - 3U; // Type and length of the name.
        const size_t length = (left > 123U) ? 60U : ((left > 63U) ? (left - 63U) : left);
        (void)snprintf(name, sizeof name, "%03u", i);
        memset(&name[3], 'x', length - 3U);
        name[length] = '\0';
        (void)disk_file(name, 0U, 0U);
        used += 3U + length;
    }
    TEST_ASSERT_EQUAL_UINT64(room, used);
    summarise("/");
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 13, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(0U).size);
    (void)disk_file("zzz", 0U, 0U);
    summarise("/");
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 13, 23, 13, 1, 7);
}

static void names_that_no_request_can_have_are_skipped(void)
{
    char deep[PUS_FILE_PATH_SIZE];
    memset(deep, 'a', sizeof deep);
    deep[63] = '\0';
    disk_directory(deep);
    deep[63]  = '/';
    deep[127] = '\0';
    disk_directory(deep);
    deep[127] = '/';
    deep[190] = '\0';
    disk_directory(deep); // A path of 190 characters.
    deep[190] = '/';
    deep[191] = 'b';
    deep[192] = '\0';
    (void)disk_file(deep, 0U, 0U);
    deep[192] = 'b';
    deep[193] = '\0';
    (void)disk_file(deep, 0U, 0U); // This name is one character too long.
    (void)disk_file("good", 0U, 0U);
    (void)disk_file("star*", 0U, 0U);
    (void)disk_file("control\x01", 0U, 0U);
    find("/", "*");
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 8, 1, 7);
    uint16_t count = 0U;
    (void)answer(0U, "/", "*", &count);
    TEST_ASSERT_EQUAL_UINT16(2U, count);
    TEST_ASSERT_EQUAL_UINT32(3U, files.counters.skipped);
}

static void a_directory_that_disappears_is_skipped(void)
{
    create_files();
    find("/", "*.txt");
    step(); // The search is in /a.
    step(); // The search is in /a/b.
    disk_remove("a/b/c/c.txt");
    disk_remove("a/b/c/c.bin");
    disk_remove("a/b/c");
    disk_remove("a/b/b.txt");
    disk_remove("a/b");
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 8, 1, 7);
    uint16_t count        = 0U;
    octet_reader_t reader = answer(0U, "/", "*.txt", &count);
    TEST_ASSERT_EQUAL_UINT16(3U, count);
    expect_text(&reader, "/a/a.txt");
    expect_text(&reader, "/a/z.txt");
    find("/a", "*");
    disk_remove("a");
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(1, 8);
    expect_failure(0U, 8U, PUS_FAILURE_IO, 0U, STATUS_NOT_FOUND);
}

static void a_search_that_fails_is_reported(void)
{
    create_files();
    find("/", "*");
    step();
    disk.fail_call = disk.calls + 1U;
    bench_clear();
    step();
    EXPECT_MESSAGES(1, 8);
    expect_failure(0U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_FALSE(pus_files_is_busy(&files));
    TEST_ASSERT_EQUAL_UINT32(1U, files.counters.failed);
}

static void searches_take_turns(void)
{
    create_files();
    find("/", "*.txt");
    summarise("/d");
    bench_clear();
    step();
    EXPECT_MESSAGES(0);
    step();
    EXPECT_MESSAGES(23, 13, 1, 7);
    bench_clear();
    (void)run();
    EXPECT_MESSAGES(23, 8, 1, 7);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(files_are_found_below_a_directory);
    RUN_TEST(an_invalid_search_is_refused);
    RUN_TEST(a_directory_is_summarised);
    RUN_TEST(long_answers_become_several_reports);
    RUN_TEST(a_port_that_refuses_reports_delays_the_search);
    RUN_TEST(the_last_report_is_tried_again);
    RUN_TEST(no_empty_report_follows_a_full_one);
    RUN_TEST(names_that_no_request_can_have_are_skipped);
    RUN_TEST(a_directory_that_disappears_is_skipped);
    RUN_TEST(a_search_that_fails_is_reported);
    RUN_TEST(searches_take_turns);
    return UNITY_END();
}
