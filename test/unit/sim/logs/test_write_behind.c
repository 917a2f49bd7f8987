// SPDX-License-Identifier: Apache-2.0
// Records reach the consumer completely, in order and once, by a task of the buffer, also if the task is
// slower than the caller; without a task the caller consumes.
#include "sim/logs/write_behind.h"

#include "osal/include/osal/task.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

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

// A test expects each call of the mocked functions. If its status is STATUS_OK, the real function is called.
status_t __real_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority);
status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority)
{
    const status_t status = mock_type(status_t);
    return (status == STATUS_OK) ? __real_osal_task_start(task, entry, context, priority) : status;
}

status_t __real_osal_event_wait(osal_event_t* event, uint32_t timeout_ms);
status_t __wrap_osal_event_wait(osal_event_t* event, uint32_t timeout_ms)
{
    if (timeout_ms != WRITE_BEHIND_TIMEOUT_MS) {
        return __real_osal_event_wait(event, timeout_ms); // The task of the buffer waits for work.
    }
    const status_t status = mock_type(status_t);
    return (status == STATUS_OK) ? __real_osal_event_wait(event, timeout_ms) : status;
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

static void a_slow_task_gets_every_record_in_order(void** state)
{
    (void)state;
    seen_t seen = {.pause_ns = 1000000L};
    will_return(__wrap_osal_task_start, STATUS_OK);
    add_all(&seen);
    write_behind_close(&buffer);
    assert_int_equal(RECORDS, seen.records);
    assert_int_equal(0U, seen.wrong);
    // Only the rest that was left at the end is consumed by the caller.
    assert_int_equal(HALVES, seen.by_others);
    assert_int_equal(seen.by_others + 1U, seen.calls);
}

static void a_flush_returns_when_all_records_are_consumed(void** state)
{
    (void)state;
    seen_t seen = {.pause_ns = 1000000L};
    will_return(__wrap_osal_task_start, STATUS_OK);
    add_all(&seen);
    will_return(__wrap_osal_event_wait, STATUS_OK);
    write_behind_flush(&buffer, true);
    assert_int_equal(RECORDS, seen.records);
    const uint32_t calls = seen.calls;
    write_behind_flush(&buffer, true); // There is nothing to consume.
    assert_int_equal(calls, seen.calls);
    add(RECORDS);
    write_behind_close(&buffer);
    assert_int_equal(RECORDS + 1U, seen.records);
    assert_int_equal(0U, seen.wrong);
}

static void a_flush_without_waiting_leaves_the_records_to_the_task(void** state)
{
    (void)state;
    seen_t seen = {.test = pthread_self()};
    will_return(__wrap_osal_task_start, STATUS_OK);
    write_behind_open(&buffer, take, &seen);
    write_behind_flush(&buffer, false); // There is nothing to pass.
    add(0U);
    write_behind_flush(&buffer, false);
    add(1U);
    write_behind_flush(&buffer, false);
    write_behind_close(&buffer);
    assert_int_equal(2U, seen.records);
    assert_int_equal(2U, seen.by_others);
    assert_int_equal(2U, seen.calls);
}

static void without_a_task_the_caller_consumes(void** state)
{
    (void)state;
    seen_t seen = {.records = 0U};
    will_return(__wrap_osal_task_start, STATUS_EXHAUSTED);
    add_all(&seen);
    write_behind_flush(&buffer, false);
    assert_int_equal(RECORDS, seen.records);
    assert_int_equal(0U, seen.wrong);
    assert_int_equal(0U, seen.by_others);
    write_behind_close(&buffer);
}

static void a_flush_ends_while_the_disk_hangs_and_its_records_are_written_later(void** state)
{
    (void)state;
    seen_t seen = {.test = pthread_self()};
    will_return(__wrap_osal_task_start, STATUS_OK);
    write_behind_open(&buffer, take, &seen);
    add(0U);
    write_behind_flush(&buffer, false);
    add(1U);
    will_return(__wrap_osal_event_wait, STATUS_TIMEOUT);
    write_behind_flush(&buffer, true);
    assert_int_equal(RECORD_OCTETS, buffer.used);
    add(2U);
    write_behind_close(&buffer);
    assert_int_equal(3U, seen.records);
    assert_int_equal(0U, seen.wrong);
    assert_int_equal(1U, seen.by_others);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slow_task_gets_every_record_in_order),
        cmocka_unit_test(a_flush_returns_when_all_records_are_consumed),
        cmocka_unit_test(a_flush_without_waiting_leaves_the_records_to_the_task),
        cmocka_unit_test(without_a_task_the_caller_consumes),
        cmocka_unit_test(a_flush_ends_while_the_disk_hangs_and_its_records_are_written_later),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
