// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/task.h"

#include "osal/include/osal/event.h"
#include "unity.h"

#define TASKS 4U
#define LONG_MS 20000U

typedef struct {
    osal_event_t go;
    osal_event_t done;
    uint32_t runs;
} seen_t;

static seen_t seen[TASKS];
static osal_task_t tasks[TASKS];

void setUp(void)
{
    for (size_t i = 0U; i < TASKS; i++) {
        osal_event_create(&seen[i].go);
        osal_event_create(&seen[i].done);
        seen[i].runs = 0U;
    }
}

void tearDown(void)
{
}

static void count(void* context)
{
    ((seen_t*)context)->runs++;
}

static void a_task_runs_once_with_its_context_and_joins(void)
{
    for (uint32_t i = 1U; i <= 50U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[0], count, &seen[0], 0));
        osal_task_join(&tasks[0]);
        osal_task_join(&tasks[0]); // There is nothing to wait for.
        TEST_ASSERT_EQUAL_UINT32(i, seen[0].runs);
    }
}

static void count_after_go(void* context)
{
    seen_t* const own = context;
    if (osal_event_wait(&own->go, LONG_MS) == STATUS_OK) {
        own->runs++;
    }
    osal_event_signal(&own->done);
}

/// Each task waits for a signal to continue, so no task ends before all have begun.
static void several_tasks_run_at_the_same_time_each_with_its_own_context(void)
{
    for (size_t i = 0U; i < TASKS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[i], count_after_go, &seen[i], 0));
    }
    for (size_t i = TASKS; i > 0U; i--) {
        TEST_ASSERT_EQUAL_UINT32(0U, seen[i - 1U].runs);
        osal_event_signal(&seen[i - 1U].go);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&seen[i - 1U].done, LONG_MS));
        TEST_ASSERT_EQUAL_UINT32(1U, seen[i - 1U].runs);
    }
    for (size_t i = 0U; i < TASKS; i++) {
        osal_task_join(&tasks[i]);
    }
}

/// The task starts with and without the permission for its priority.
static void a_task_starts_with_every_priority(void)
{
    for (int priority = 0; priority <= 99; priority += 33) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[0], count, &seen[0], priority));
        osal_task_join(&tasks[0]);
    }
    TEST_ASSERT_EQUAL_UINT32(4U, seen[0].runs);
}

static void own_priority_is_set_or_denied(void)
{
    const status_t status = osal_task_set_priority(43);
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_DENIED));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_set_priority(0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_task_runs_once_with_its_context_and_joins);
    RUN_TEST(several_tasks_run_at_the_same_time_each_with_its_own_context);
    RUN_TEST(a_task_starts_with_every_priority);
    RUN_TEST(own_priority_is_set_or_denied);
    return UNITY_END();
}
