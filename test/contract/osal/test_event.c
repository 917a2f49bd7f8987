// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/event.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/task.h"
#include "unity.h"

#include <string.h>

#define ROUNDS 5000U
#define LONG_MS 20000U

static struct {
    osal_event_t there;
    osal_event_t back;
    uint32_t value;
    uint32_t missed;
} shared;

void setUp(void)
{
    memset(&shared, 0, sizeof shared);
    osal_event_create(&shared.there);
    osal_event_create(&shared.back);
}

void tearDown(void)
{
}

static void a_signal_before_the_wait_is_kept_and_two_signals_count_as_one(void)
{
    osal_event_t event;
    memset(&event, 0xFF, sizeof event);
    osal_event_create(&event);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&event, 0U));
    osal_event_signal(&event);
    osal_event_signal(&event);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&event, 0U));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&event, 1U));
}

static void a_wait_is_never_early(void)
{
    const uint64_t begin_ns = osal_clock_monotonic_ns();
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&shared.there, 30U));
    TEST_ASSERT_TRUE(osal_clock_monotonic_ns() - begin_ns >= 30000000U);
}

static void answer(void* context)
{
    (void)context;
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        if (osal_event_wait(&shared.there, LONG_MS) != STATUS_OK) {
            shared.missed++;
        }
        shared.value++;
        osal_event_signal(&shared.back);
    }
}

static void two_tasks_take_turns_without_losing_a_signal(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, answer, NULL, 0));
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        osal_event_signal(&shared.there);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&shared.back, LONG_MS));
        TEST_ASSERT_EQUAL_UINT32(i + 1U, shared.value);
    }
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT32(0U, shared.missed);
}

/// The waiter sleeps without a time-out when the signal comes, or is just about to.
static void a_wait_without_a_time_out_ends_with_the_signal(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, answer, NULL, 0));
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        osal_event_signal(&shared.there);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&shared.back, UINT32_MAX));
    }
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT32(ROUNDS, shared.value);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_signal_before_the_wait_is_kept_and_two_signals_count_as_one);
    RUN_TEST(a_wait_is_never_early);
    RUN_TEST(two_tasks_take_turns_without_losing_a_signal);
    RUN_TEST(a_wait_without_a_time_out_ends_with_the_signal);
    return UNITY_END();
}
