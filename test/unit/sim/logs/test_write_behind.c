// SPDX-License-Identifier: Apache-2.0
// Records reach the consumer completely, in order and once, by a task of the buffer, also if the task is
// slower than the caller; without a task the caller consumes.
#include "sim/logs/write_behind.h"

#include "osal/include/osal/task.h"

#include <pthread.h>
#include <string.h>
#include <time.h>

#include "unity.h"

#define RECORD_OCTETS 7U
#define ROOM_OCTETS 10U // A record may be shorter than the room that was asked for.
#define RECORDS_OF_A_HALF (((WRITE_BEHIND_HALF - ROOM_OCTETS) / RECORD_OCTETS) + 1U)
#define HALVES 10U
#define RECORDS ((HALVES * RECORDS_OF_A_HALF) + 1U)

/// What the consumer has seen.
typedef struct {
    uint32_t records;
    uint32_t wrong; ///< Records that were not the next one.
    uint32_t calls;
    uint32_t by_others; ///< Calls in another task than that of the test.
    pthread_t test;
    long pause_ns;
} seen_t;

static write_behind_t buffer;
static bool has_no_room_for_a_task;

status_t __real_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority);
status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority);

status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority)
{
    return has_no_room_for_a_task ? STATUS_EXHAUSTED : __real_osal_task_start(task, entry, context, priority);
}

static bool is_disk_hung; // The task does not finish while a flush waits for it.

status_t __real_osal_event_wait(osal_event_t* event, uint32_t timeout_ms);
status_t __wrap_osal_event_wait(osal_event_t* event, uint32_t timeout_ms);

status_t __wrap_osal_event_wait(osal_event_t* event, uint32_t timeout_ms)
{
    return ((timeout_ms == WRITE_BEHIND_PATIENCE_MS) && is_disk_hung)
               ? STATUS_TIMEOUT
               : __real_osal_event_wait(event, timeout_ms);
}

void setUp(void)
{
    has_no_room_for_a_task = false;
    is_disk_hung           = false;
}

void tearDown(void)
{
}

static void take(void* context, const uint8_t* octets, size_t size)
{
    seen_t* const seen = context;
    for (size_t at = 0U; at < size; at += RECORD_OCTETS) {
        uint32_t number = 0U;
        memcpy(&number, &octets[at], sizeof number);
        seen->wrong += (number != seen->records) ? 1U : 0U;
        seen->records++;
    }
    seen->calls++;
    seen->by_others += (pthread_equal(pthread_self(), seen->test) == 0) ? 1U : 0U;
    (void)nanosleep(&(const struct timespec){.tv_nsec = seen->pause_ns}, NULL);
}

static void add(uint32_t number)
{
    uint8_t* const record = write_behind_room(&buffer, ROOM_OCTETS);
    memcpy(record, &number, sizeof number);
    write_behind_add(&buffer, RECORD_OCTETS);
}

static void add_all(seen_t* seen)
{
    seen->test = pthread_self();
    write_behind_open(&buffer, take, seen);
    for (uint32_t i = 0U; i < RECORDS; i++) {
        add(i);
    }
}

static void a_slow_task_gets_every_record_in_order(void)
{
    seen_t seen = {.pause_ns = 1000000L};
    add_all(&seen);
    write_behind_close(&buffer);
    TEST_ASSERT_EQUAL_UINT32(RECORDS, seen.records);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.wrong);
    // Only the rest that was left at the end is consumed by the caller.
    TEST_ASSERT_EQUAL_UINT32(HALVES, seen.by_others);
    TEST_ASSERT_EQUAL_UINT32(seen.by_others + 1U, seen.calls);
}

static void a_flush_returns_when_all_records_are_consumed(void)
{
    seen_t seen = {.pause_ns = 1000000L};
    add_all(&seen);
    write_behind_flush(&buffer, true);
    TEST_ASSERT_EQUAL_UINT32(RECORDS, seen.records);
    const uint32_t calls = seen.calls;
    write_behind_flush(&buffer, true); // There is nothing to consume.
    TEST_ASSERT_EQUAL_UINT32(calls, seen.calls);
    add(RECORDS);
    write_behind_close(&buffer);
    TEST_ASSERT_EQUAL_UINT32(RECORDS + 1U, seen.records);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.wrong);
}

static void a_flush_without_waiting_leaves_the_records_to_the_task(void)
{
    seen_t seen = {.test = pthread_self()};
    write_behind_open(&buffer, take, &seen);
    write_behind_flush(&buffer, false); // There is nothing to pass.
    add(0U);
    write_behind_flush(&buffer, false);
    add(1U);
    write_behind_flush(&buffer, false);
    write_behind_close(&buffer);
    TEST_ASSERT_EQUAL_UINT32(2U, seen.records);
    TEST_ASSERT_EQUAL_UINT32(2U, seen.by_others);
    TEST_ASSERT_EQUAL_UINT32(2U, seen.calls);
}

static void without_a_task_the_caller_consumes(void)
{
    seen_t seen            = {.records = 0U};
    has_no_room_for_a_task = true;
    add_all(&seen);
    write_behind_flush(&buffer, false);
    TEST_ASSERT_EQUAL_UINT32(RECORDS, seen.records);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.wrong);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.by_others);
    write_behind_close(&buffer);
}

static void a_flush_ends_while_the_disk_hangs_and_its_records_are_written_later(void)
{
    seen_t seen = {.test = pthread_self()};
    write_behind_open(&buffer, take, &seen);
    add(0U);
    write_behind_flush(&buffer, false);
    add(1U);
    is_disk_hung = true;
    write_behind_flush(&buffer, true);
    TEST_ASSERT_EQUAL_UINT32(RECORD_OCTETS, buffer.used);
    is_disk_hung = false;
    add(2U);
    write_behind_close(&buffer);
    TEST_ASSERT_EQUAL_UINT32(3U, seen.records);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.wrong);
    TEST_ASSERT_EQUAL_UINT32(1U, seen.by_others);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_slow_task_gets_every_record_in_order);
    RUN_TEST(a_flush_returns_when_all_records_are_consumed);
    RUN_TEST(a_flush_without_waiting_leaves_the_records_to_the_task);
    RUN_TEST(without_a_task_the_caller_consumes);
    RUN_TEST(a_flush_ends_while_the_disk_hangs_and_its_records_are_written_later);
    return UNITY_END();
}
