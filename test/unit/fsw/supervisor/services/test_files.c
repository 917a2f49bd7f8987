// SPDX-License-Identifier: Apache-2.0
// ST[23] of the supervisor, and files that its other services read and write.
#include "fsw/supervisor/services/files.h"

#include "base/octets.h"
#include "test/support/disk.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

#define NAME(path, name)                                                                                     \
    &(const pus_file_name_t)                                                                                 \
    {                                                                                                        \
        (const uint8_t*)(path), (const uint8_t*)(name), sizeof(path) - 1U, sizeof(name) - 1U                 \
    }

static const pus_file_port_t* files;
static uint32_t file;
static uint32_t file_size;

static void give_disk(supervisor_config_t* const config)
{
    config->files = disk_store();
}

void setUp(void)
{
    disk_start();
    disk_directory("a");
    (void)disk_file("a/one", 10U, 'A');
    fixture_configure = give_disk;
    fixture_open_up();
    files = spacecraft_file_port(&fixture.supervisor);
    TEST_ASSERT_NOT_NULL(files);
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

static status_t open_one(void)
{
    return files->open(files->context, NAME("a", "one"), &file, &file_size);
}

static status_t create(const pus_file_name_t* const name)
{
    return files->create(files->context, name, &file);
}

static void fail_next_call(const status_t status)
{
    disk.failure   = status;
    disk.fail_call = disk.calls + 1U;
}

static void a_file_is_read_in_pieces(void)
{
    uint8_t octets[10];
    TEST_ASSERT_EQUAL(STATUS_OK, open_one());
    TEST_ASSERT_EQUAL_UINT32(10U, file_size);
    TEST_ASSERT_EQUAL(STATUS_OK, files->read(files->context, file, 0U, octets, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, files->read(files->context, file, 4U, &octets[4], 6U));
    TEST_ASSERT_EQUAL_MEMORY("ABCDEFGHIJ", octets, 10U);
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, files->read(files->context, file, 8U, octets, 3U));
    fail_next_call(STATUS_DENIED);
    TEST_ASSERT_EQUAL(STATUS_IO, files->read(files->context, file, 0U, octets, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, files->close(files->context, file));
}

static void a_written_file_is_complete_on_the_disk(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, create(NAME("a", "new")));
    TEST_ASSERT_EQUAL(STATUS_OK, files->write(files->context, file, 0U, (const uint8_t*)"abc", 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, files->write(files->context, file, 3U, (const uint8_t*)"de", 2U));
    fail_next_call(STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_FULL, files->write(files->context, file, 5U, (const uint8_t*)"f", 1U));
    fail_next_call(STATUS_DENIED);
    TEST_ASSERT_EQUAL(STATUS_IO, files->write(files->context, file, 5U, (const uint8_t*)"f", 1U));
    TEST_ASSERT_EQUAL_UINT(0U, disk.syncs);
    TEST_ASSERT_EQUAL(STATUS_OK, files->close(files->context, file));
    TEST_ASSERT_EQUAL_UINT(1U, disk.syncs);
    const disk_file_t* const made = disk_find("a/new");
    TEST_ASSERT_EQUAL_UINT64(5U, made->size);
    TEST_ASSERT_EQUAL_MEMORY("abcde", made->octets, 5U);
}

static void each_failure_to_open_a_file_has_its_reason(void)
{
    (void)disk_file("a/huge", (uint64_t)UINT32_MAX + 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, files->open(files->context, NAME("a", "two"), &file, &file_size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, files->open(files->context, NAME("", "a"), &file, &file_size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, files->open(files->context, NAME("a", "huge"), &file, &file_size));
    fail_next_call(STATUS_DENIED);
    TEST_ASSERT_EQUAL(STATUS_IO, open_one());
    TEST_ASSERT_EQUAL(STATUS_EXISTS, create(NAME("a", "one")));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, create(NAME("b", "one")));
    fail_next_call(STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_IO, create(NAME("a", "new")));
}

static void paths_and_names_follow_the_rules_of_st23(void)
{
    static const uint8_t filler[2U * PUS_FILE_PATH_SIZE] = {'x'};
    const pus_file_name_t bad[]                          = {
                                 {(const uint8_t*)"..", (const uint8_t*)"one", 2U, 3U},
                                 {(const uint8_t*)"a", (const uint8_t*)"../one", 1U, 6U},
                                 {(const uint8_t*)"a", (const uint8_t*)"", 1U, 0U},
                                 {filler, (const uint8_t*)"one", sizeof filler, 3U},
                                 {filler, filler, sizeof filler, sizeof filler},
    };
    const unsigned before = disk.calls;
    for (unsigned i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, files->open(files->context, &bad[i], &file, &file_size));
        TEST_ASSERT_EQUAL(STATUS_INVALID, create(&bad[i]));
    }
    TEST_ASSERT_EQUAL_UINT(before, disk.calls);
}

static void the_number_of_open_files_is_bounded(void)
{
    for (uint32_t i = 0U; i < SPACECRAFT_FILES_OPEN; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, open_one());
        TEST_ASSERT_EQUAL_UINT32(i, file);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, open_one());
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, create(NAME("a", "new")));
    TEST_ASSERT_NULL(disk_find("a/new"));
    fail_next_call(STATUS_IO); // The file is closed although the call fails.
    TEST_ASSERT_EQUAL(STATUS_IO, files->close(files->context, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, create(NAME("a", "new")));
    TEST_ASSERT_EQUAL_UINT32(1U, file);
}

static void without_a_store_there_is_no_port(void)
{
    fixture_close();
    fixture_configure = NULL;
    fixture_open_up();
    TEST_ASSERT_NULL(spacecraft_file_port(&fixture.supervisor));
}

// ---- ST[23] ----

static void copies_continue_while_no_other_event_wakes_the_supervisor(void)
{
    static const uint8_t copy[]     = "\0\1\0\1a\0\4long\0\1a\0\3two"; // Operation 1.
    const disk_file_t* const copied = disk_file("a/long", DISK_FILE_SIZE, 'B');
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_FILES, 14U, copy, sizeof copy - 1U);
    const uint64_t wake_ns = supervisor_step(&fixture.supervisor, fixture.now_ns);
    TEST_ASSERT_TRUE((wake_ns - fixture.now_ns) <= SPACECRAFT_RETRY_NS);
    fixture_run(20U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #0"));
    const disk_file_t* const made = disk_find("a/two");
    TEST_ASSERT_NOT_NULL(made);
    TEST_ASSERT_EQUAL_MEMORY(copied->octets, made->octets, DISK_FILE_SIZE);
    TEST_ASSERT_TRUE((supervisor_step(&fixture.supervisor, fixture.now_ns) - fixture.now_ns) >
                     SPACECRAFT_RETRY_NS);
}

/// A file with the content of TC[21,1] after the identifier: one request without a delay.
static void a_sequence_is_loaded_from_a_file(void)
{
    uint8_t content[64];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid = LONE, .service = PUS_SERVICE_TEST, .subtype = 1U, .source = FIXTURE_USER};
    content[0]        = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, &content[1], sizeof content - 1U, &size));
    (void)memset(&content[1U + size], 0, 7U);
    disk_file_t* const made = disk_file("a/seq", 1U + size + 7U, 0U);
    (void)memcpy(made->octets, content, 1U + size + 7U);
    static const uint8_t request[] = "SEQ\0\0\0\0\0\0\1a\0\3seq"; // The sequence SEQ in the file a/seq.
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_SEQUENCES, 8U, request, sizeof request - 1U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("18 TC 17.1 from 1"));
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #0"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_file_is_read_in_pieces);
    RUN_TEST(a_written_file_is_complete_on_the_disk);
    RUN_TEST(each_failure_to_open_a_file_has_its_reason);
    RUN_TEST(paths_and_names_follow_the_rules_of_st23);
    RUN_TEST(the_number_of_open_files_is_bounded);
    RUN_TEST(without_a_store_there_is_no_port);
    RUN_TEST(copies_continue_while_no_other_event_wakes_the_supervisor);
    RUN_TEST(a_sequence_is_loaded_from_a_file);
    return UNITY_END();
}
