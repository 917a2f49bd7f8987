// SPDX-License-Identifier: Apache-2.0
#include "fsw/app/record_store.h"

#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CAPACITY 4U

static char folder[64];
static seat_t seat;
static run_block_t run;
static record_store_t store;
static record_store_t other;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static journal_slot_t other_slots[JOURNAL_SLOTS(CAPACITY)];
static unsigned found;

void setUp(void)
{
    (void)strcpy(folder, "/tmp/record_store.XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    seat = (seat_t){.run = &run};
    (void)strcpy(run.storage, folder);
    (void)strcpy(run.components[0].name, "ARM");
    found = 0U;
}

void tearDown(void)
{
    char path[128];
    for (unsigned i = 0U; i < 2U; i++) {
        (void)snprintf(path, sizeof path, "%s/ARM.journal.%u", folder, i);
        (void)unlink(path);
    }
    (void)rmdir(folder);
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
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &seat, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 11U, 7U, (const uint8_t*)"abc", 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &seat, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&store.journal, take, NULL));
    TEST_ASSERT_EQUAL(1U, found);
    record_store_close(&store);
}

static void two_flights_do_not_share_it(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&store, &seat, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(STATUS_BUSY, record_store_open(&other, &seat, other_slots, CAPACITY, true));
    TEST_ASSERT_NOT_NULL(strstr(seat.error, "ARM.journal.0: another flight uses this storage"));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, record_store_open(&other, &seat, other_slots, CAPACITY, true));
    record_store_close(&other);
}

static void what_cannot_be_kept_is_told(void)
{
    (void)strcpy(run.storage, "/nowhere");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, record_store_open(&store, &seat, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL_STRING("cannot keep records in /nowhere/ARM.journal.0: not found", seat.error);
    (void)memset(run.storage, 'x', sizeof run.storage - 1U);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, record_store_open(&store, &seat, slots, CAPACITY, true));
    (void)strcpy(run.storage, folder);
    char path[128];
    (void)snprintf(path, sizeof path, "%s/ARM.journal.1", folder);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(path));
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, record_store_open(&store, &seat, slots, CAPACITY, true));
    TEST_ASSERT_EQUAL(0, rmdir(path));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      record_store_open(&store, &seat, slots, CAPACITY, true)); // The first is free again.
    for (uint32_t key = 0U; key < CAPACITY; key++) {
        TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&store.journal, 1U, key, (const uint8_t*)"abc", 3U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&store.journal));
    record_store_close(&store);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, record_store_open(&store, &seat, slots, CAPACITY - 1U, false));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(records_outlive_the_program);
    RUN_TEST(two_flights_do_not_share_it);
    RUN_TEST(what_cannot_be_kept_is_told);
    return UNITY_END();
}
