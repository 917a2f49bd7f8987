// SPDX-License-Identifier: Apache-2.0
// A journal on real files through the file medium.
#define _POSIX_C_SOURCE 200809L
#include "fsw/programs/file_medium.h"

#include "fsw/framework/journal/journal.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define RECORDS 500U

static char paths[2][64];
static osal_file_t files[2];
static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(RECORDS)];
static uint32_t seen;

static void open_journal(void)
{
    for (size_t i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&files[i], paths[i]));
    }
    const journal_configuration_t configuration = {.media = {file_medium(&files[0]), file_medium(&files[1])},
                                                   .limit = 1000000U,
                                                   .slack = 1000U,
                                                   .slots = slots,
                                                   .capacity = RECORDS};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
}

static void close_files(void)
{
    osal_file_close(&files[0]);
    osal_file_close(&files[1]);
}

void setUp(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        (void)snprintf(paths[i], sizeof paths[i], "/tmp/file-medium-test-%d.%u", (int)getpid(), i);
    }
    open_journal();
}

void tearDown(void)
{
    close_files();
    (void)unlink(paths[0]);
    (void)unlink(paths[1]);
}

static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                 const size_t size)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT8(7U, table);
    TEST_ASSERT_EQUAL_UINT32(seen, key);
    TEST_ASSERT_EQUAL_UINT64(300U, size);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(key + 2U), octets[299]);
    seen++;
}

static void a_journal_on_files_keeps_its_records(void)
{
    uint8_t octets[300];
    for (uint32_t round = 0U; round < 3U; round++) {
        // In each round the new records replace all octets of the round before.
        for (uint32_t i = 0U; i < RECORDS; i++) {
            memset(octets, (int)((i + round) & 0xFFU), sizeof octets);
            TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 7U, i, octets, sizeof octets));
        }
        TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.compactions);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 7U, 9U, octets, 1U)); // This put is not committed.
    close_files();
    open_journal();
    TEST_ASSERT_EQUAL_UINT32(RECORDS, journal.stats.records);
    TEST_ASSERT_EQUAL_UINT64(JOURNAL_RECORD_SIZE(1U), journal.stats.discarded);
    seen = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, NULL));
    TEST_ASSERT_EQUAL_UINT32(RECORDS, seen);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_journal_on_files_keeps_its_records);
    return UNITY_END();
}
