// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/record_store.h"

#include "unity.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define CAPACITY 4U

static char directory[64];
static component_runtime_t runtime;
static run_state_t run;
static record_store_t store;
static record_store_t other;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static journal_slot_t other_slots[JOURNAL_SLOTS(CAPACITY)];
static unsigned found;

void setUp(void)
{
    (void)strcpy(directory, "/tmp/record_store.XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    runtime       = (component_runtime_t){.run = &run};
    store.wrapper = (record_store_wrapper_t){NULL, NULL};
    (void)strcpy(run.storage, directory);
    (void)strcpy(run.components[0].name, "ARM");
    found = 0U;
}

void tearDown(void)
{
    char path[128];
    for (unsigned i = 0U; i < 2U; i++) {
        (void)snprintf(path, sizeof path, "%s/ARM.journal.%u", directory, i);
        (void)unlink(path);
        for (unsigned k = 0U; k <= RECORD_STORE_COPIES; k++) {
            (void)snprintf(path, sizeof path, "%s/ARM.journal.%u.damaged.%u", directory, i, k);
            (void)unlink(path);
        }
    }
    (void)snprintf(path, sizeof path, "%s/ARM.checkpoint.damaged.0", directory);
    (void)unlink(path);
    (void)rmdir(directory);
}

static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                 const size_t size)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT8(11U, table);
    TEST_ASSERT_EQUAL_UINT32(7U, key);
    TEST_ASSERT_EQUAL(3U, size);
    TEST_ASSERT_EQUAL_MEMORY("abc", octets, 3U);
    found++;
}

static void records_outlive_the_program(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 11U, 7U, (const uint8_t*)"abc", 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&store.journal, take, NULL));
    TEST_ASSERT_EQUAL(1U, found);
    record_store_close(&store);
}

static void two_flights_cannot_open_the_same_store(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_BUSY, record_store_open(&other, &runtime, other_slots, CAPACITY, true));
    TEST_ASSERT_NOT_NULL(strstr(runtime.error,
                                "ARM.journal.0: another flight uses this storage; choose another "
                                "directory with --storage"));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&other, &runtime, other_slots, CAPACITY, true));
    record_store_close(&other);
}

/// Another flight uses the second file, so the first file is released.
static void if_the_second_file_is_in_use_the_first_is_released(void)
{
    char path[128];
    osal_file_t second;
    (void)snprintf(path, sizeof path, "%s/ARM.journal.1", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&second, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_lock(&second));
    TEST_ASSERT_EQUAL(STATUS_BUSY, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_NOT_NULL(strstr(runtime.error,
                                "ARM.journal.1: another flight uses this storage; choose another "
                                "directory with --storage"));
    osal_file_close(&second);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&other, &runtime, other_slots, CAPACITY, true));
    record_store_close(&other);
}

/// No descriptor is free for syncing the directory: both files are released.
static void if_the_directory_cannot_be_synced_both_files_are_released(void)
{
    struct rlimit before;
    const int lowest = dup(STDOUT_FILENO);
    TEST_ASSERT_TRUE(lowest >= 0);
    (void)close(lowest);
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_NOFILE, &before));
    const struct rlimit limit = {(rlim_t)lowest + 2U, before.rlim_max};
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_NOFILE, &limit));
    const status_t status = record_store_open(&store, &runtime, slots, CAPACITY, true);
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_NOFILE, &before));
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, status);
    char expected[128];
    (void)snprintf(expected, sizeof expected, "cannot keep records in %s: ", directory);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(runtime.error, expected), runtime.error);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&other, &runtime, other_slots, CAPACITY, true));
    record_store_close(&other);
}

static medium_t wrapped[2]; // The media that the store has passed to its wrapper.

static medium_t keep_medium(void* const context, const unsigned index, const medium_t medium)
{
    TEST_ASSERT_EQUAL_PTR(&found, context);
    TEST_ASSERT_TRUE(index < 2U);
    wrapped[index] = medium;
    return medium;
}

/// The store has closed its files. sync of a store that waits for the disk therefore fails; sync of a store
/// that does not wait makes no call, and succeeds.
static void only_a_store_that_waits_syncs_its_files(void)
{
    store.wrapper = (record_store_wrapper_t){&found, keep_medium};
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    record_store_close(&store);
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, wrapped[0].sync(wrapped[0].context));
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, wrapped[1].sync(wrapped[1].context));
    TEST_ASSERT_TRUE(wrapped[0].context != wrapped[1].context);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, false));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, wrapped[0].sync(wrapped[0].context));
    TEST_ASSERT_EQUAL(STATUS_OK, wrapped[1].sync(wrapped[1].context));
}

static void a_record_store_that_cannot_be_opened_is_reported(void)
{
    (void)strcpy(run.storage, "/nowhere");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL_STRING(
        "cannot keep records in /nowhere/ARM.journal.0: not found; choose another directory with --storage",
        runtime.error);
    (void)memset(run.storage, 'x', sizeof run.storage - 1U);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, record_store_open(&store, &runtime, slots, CAPACITY, true));
    (void)strcpy(run.storage, directory);
    char path[128];
    (void)snprintf(path, sizeof path, "%s/ARM.journal.1", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(path));
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(0, rmdir(path));
    // The first file is free again.
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    for (uint32_t key = 0U; key < CAPACITY; key++) {
        TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 1U, key, (const uint8_t*)"abc", 3U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, record_store_open(&store, &runtime, slots, CAPACITY - 1U, false));
    char expected[256];
    (void)snprintf(
        expected, sizeof expected,
        "cannot keep records in %s/ARM.journal.0 or .1: %s; choose another directory with --storage",
        directory, status_text(STATUS_EXHAUSTED));
    TEST_ASSERT_EQUAL_STRING(expected, runtime.error);
}

/// Change the octet at `offset` of a file in the storage. Returns the size of the file.
static size_t damage(const char* const name, const long offset)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE* const file = fopen(path, "r+b");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL(0, fseek(file, offset, SEEK_SET));
    const int octet = fgetc(file);
    TEST_ASSERT_EQUAL(0, fseek(file, offset, SEEK_SET));
    (void)fputc(octet ^ 1, file);
    TEST_ASSERT_EQUAL(0, fseek(file, 0, SEEK_END));
    const size_t size = (size_t)ftell(file);
    (void)fclose(file);
    return size;
}

/// Returns the octet at `offset` of a file; 0 if there is no file.
static int octet_of(const char* const name, const long offset)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE* const file = fopen(path, "rb");
    if (file == NULL) {
        return 0;
    }
    (void)fseek(file, offset, SEEK_SET);
    const int octet = fgetc(file);
    (void)fclose(file);
    return octet;
}

static void put(const uint32_t key, const char* const octets)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      journal_put(&store.journal, 11U, key, (const uint8_t*)octets, strlen(octets)));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
}

/// Damaged media are copied unchanged. The first three copies are permanent; a later one replaces the fourth.
static void damaged_media_are_kept(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_FALSE(store.journal.damage.is_damaged);
    for (int i = 0; i < 6; i++) {
        char first[2] = {(char)('0' + i), '\0'};
        put(7U, first); // Its octet follows the head of the medium and that of the record, 16 octets each.
        put(8U, "second");
        record_store_close(&store);
        (void)damage("ARM.journal.0", 33); // The checksum of the record.
        TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
        TEST_ASSERT_TRUE(store.journal.damage.is_damaged && store.journal.damage.is_kept);
        TEST_ASSERT_EQUAL_UINT32(0U, store.journal.stats.records);
    }
    TEST_ASSERT_EQUAL('0', octet_of("ARM.journal.0.damaged.0", 32));
    TEST_ASSERT_EQUAL('1', octet_of("ARM.journal.0.damaged.1", 32));
    TEST_ASSERT_EQUAL('2', octet_of("ARM.journal.0.damaged.2", 32));
    TEST_ASSERT_EQUAL('5', octet_of("ARM.journal.0.damaged.3", 32));
    TEST_ASSERT_EQUAL(0, octet_of("ARM.journal.0.damaged.4", 32));
    TEST_ASSERT_EQUAL('H', octet_of("ARM.journal.1.damaged.0", 0)); // The head begins with "HJRN".
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_FALSE(store.journal.damage.is_damaged); // The damage was reported.
    record_store_close(&store);
}

static void media_larger_than_a_piece_are_copied_completely(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    static uint8_t octets[JOURNAL_RECORD_MAX];
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 11U, 1U, octets, sizeof octets));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    put(2U, "end");
    record_store_close(&store);
    const size_t size = damage("ARM.journal.0", 5000);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(1, octet_of("ARM.journal.0.damaged.0", 5000));
    // An octet of the last commit.
    TEST_ASSERT_EQUAL('C', octet_of("ARM.journal.0.damaged.0", (long)size - 20));
    TEST_ASSERT_EQUAL(EOF, octet_of("ARM.journal.0.damaged.0", (long)size));
    record_store_close(&store);
}

/// The journal continues without a copy.
static void media_that_cannot_be_kept_are_reported(void)
{
    char path[128];
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    put(7U, "abc");
    record_store_close(&store);
    (void)damage("ARM.journal.0", 33);
    for (unsigned i = 0U; i < RECORD_STORE_COPIES; i++) {
        (void)snprintf(path, sizeof path, "%s/ARM.journal.0.damaged.%u", directory, i);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(path));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_TRUE(store.journal.damage.is_damaged && !store.journal.damage.is_kept);
    put(7U, "abc");
    record_store_close(&store);
    for (unsigned i = 0U; i < RECORD_STORE_COPIES; i++) {
        (void)snprintf(path, sizeof path, "%s/ARM.journal.0.damaged.%u", directory, i);
        TEST_ASSERT_EQUAL(0, rmdir(path));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&store.journal, take, NULL));
    TEST_ASSERT_EQUAL(1U, found);
    record_store_close(&store);
}

static int console = -1;
static char said[1024];

/// Redirect lines for the console to a file.
static void redirect_console(void)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/console", directory);
    console        = dup(STDERR_FILENO);
    FILE* const to = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(to);
    TEST_ASSERT_TRUE((console >= 0) && (dup2(fileno(to), STDERR_FILENO) >= 0));
    (void)fclose(to);
}

/// End the redirection; `said` gets the redirected lines.
static void restore_console(void)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/console", directory);
    (void)dup2(console, STDERR_FILENO);
    (void)close(console);
    FILE* const from  = fopen(path, "r");
    const size_t size = fread(said, 1U, sizeof said - 1U, from);
    said[size]        = '\0';
    (void)fclose(from);
    (void)unlink(path);
}

static void the_console_names_the_damaged_file_and_its_copy(void)
{
    char expected[512];
    redirect_console();
    const bool is_kept = record_store_keep(&runtime, "checkpoint", (const uint8_t*)"xyz", 3U);
    restore_console();
    TEST_ASSERT_TRUE(is_kept);
    (void)snprintf(expected, sizeof expected,
                   "damaged: %s/ARM.checkpoint; a copy is %s/ARM.checkpoint.damaged.0\n", directory,
                   directory);
    TEST_ASSERT_EQUAL_STRING(expected, said);
    (void)strcpy(run.storage, "/nowhere");
    redirect_console();
    const bool is_kept_nowhere = record_store_keep(&runtime, "checkpoint", (const uint8_t*)"xyz", 3U);
    restore_console();
    TEST_ASSERT_FALSE(is_kept_nowhere);
    TEST_ASSERT_EQUAL_STRING("damaged: /nowhere/ARM.checkpoint; no copy: not found\n", said);
}

/// The disk becomes full before the copy is complete: no part of the copy remains.
static void an_incomplete_copy_is_removed(void)
{
    static uint8_t octets[JOURNAL_RECORD_MAX];
    struct rlimit before;
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &runtime, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 11U, 1U, octets, sizeof octets));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    put(2U, "end");
    record_store_close(&store);
    (void)damage("ARM.journal.0", 50);
    (void)signal(SIGXFSZ, SIG_IGN);
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_FSIZE, &before));
    const struct rlimit limit = {4096U, before.rlim_max}; // The size of one piece.
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_FSIZE, &limit));
    const status_t status = record_store_open(&store, &runtime, slots, CAPACITY, true);
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_FSIZE, &before));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_TRUE(store.journal.damage.is_damaged && !store.journal.damage.is_kept);
    TEST_ASSERT_EQUAL(0, octet_of("ARM.journal.0.damaged.0", 0));
    // The copy of the short medium is complete.
    TEST_ASSERT_EQUAL('H', octet_of("ARM.journal.1.damaged.0", 0));
    record_store_close(&store);
}

static void other_damaged_data_are_kept(void)
{
    TEST_ASSERT_TRUE(record_store_keep(&runtime, "checkpoint", (const uint8_t*)"xyz", 3U));
    TEST_ASSERT_EQUAL('x', octet_of("ARM.checkpoint.damaged.0", 0));
    TEST_ASSERT_EQUAL('z', octet_of("ARM.checkpoint.damaged.0", 2));
    TEST_ASSERT_EQUAL(EOF, octet_of("ARM.checkpoint.damaged.0", 3));
    (void)strcpy(run.storage, "/nowhere");
    TEST_ASSERT_FALSE(record_store_keep(&runtime, "checkpoint", (const uint8_t*)"xyz", 3U));
    (void)memset(run.storage, 'x', sizeof run.storage - 1U);
    TEST_ASSERT_FALSE(record_store_keep(&runtime, "checkpoint", (const uint8_t*)"xyz", 3U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(if_the_second_file_is_in_use_the_first_is_released);
    RUN_TEST(if_the_directory_cannot_be_synced_both_files_are_released);
    RUN_TEST(only_a_store_that_waits_syncs_its_files);
    RUN_TEST(an_incomplete_copy_is_removed);
    RUN_TEST(other_damaged_data_are_kept);
    RUN_TEST(the_console_names_the_damaged_file_and_its_copy);
    RUN_TEST(records_outlive_the_program);
    RUN_TEST(two_flights_cannot_open_the_same_store);
    RUN_TEST(a_record_store_that_cannot_be_opened_is_reported);
    RUN_TEST(damaged_media_are_kept);
    RUN_TEST(media_larger_than_a_piece_are_copied_completely);
    RUN_TEST(media_that_cannot_be_kept_are_reported);
    return UNITY_END();
}
