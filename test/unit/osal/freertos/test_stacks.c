// SPDX-License-Identifier: Apache-2.0
// Use of the stacks: those of all tasks that can run at the same time are listed, and none is left out.
#include "osal/freertos/port.h"
#include "osal/include/osal/task.h"
#include "test/support/assertion.h"
#include "unity.h"

#include <FreeRTOS.h>
#include <task.h>

#include <string.h>

static osal_task_t tasks[PORT_STARTED_MAX];
static volatile bool may_end;
static port_stack_t stacks[PORT_STACKS_MAX];

void setUp(void)
{
    may_end = false;
}

void tearDown(void)
{
}

static void run(void* const context)
{
    (void)context;
    while (!may_end) {
        vTaskDelay(1U);
    }
}

static void list(void)
{
    (void)port_stacks(stacks);
}

static size_t count_of(const size_t count, const char* const name)
{
    size_t found = 0U;
    for (size_t i = 0U; i < count; i++) {
        found += (strcmp(stacks[i].name, name) == 0) ? 1U : 0U;
        TEST_ASSERT_TRUE((stacks[i].used > 0U) && (stacks[i].used <= stacks[i].size));
    }
    return found;
}

static void the_stacks_of_all_tasks_are_listed(void)
{
    osal_task_t more;
    TEST_ASSERT_EQUAL(3U, port_stacks(stacks));
    for (unsigned i = 0U; i < PORT_STARTED_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[i], run, NULL, 10));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, osal_task_start(&more, run, NULL, 10));
    vTaskDelay(2U); // Each task has used its stack by then.
    const size_t count = port_stacks(stacks);
    TEST_ASSERT_EQUAL(PORT_STACKS_MAX, count);
    TEST_ASSERT_EQUAL(PORT_STARTED_MAX, count_of(count, "task"));
    TEST_ASSERT_EQUAL(1U, count_of(count, "main"));
    TEST_ASSERT_EQUAL(1U, count_of(count, "IDLE"));
    TEST_ASSERT_EQUAL(1U, count_of(count, "interrupts"));
}

static void a_task_without_room_in_the_list_is_an_error(void)
{
    static StaticTask_t block;
    static StackType_t stack[256];
    const TaskHandle_t made =
        xTaskCreateStatic(run, "other", sizeof stack / sizeof stack[0], NULL, 1U, stack, &block);
    for (unsigned i = 0U; i < PORT_STARTED_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[i], run, NULL, 10));
    }
    TEST_ASSERT_TRUE(assertion_fails(list));
    vTaskDelete(made);
    TEST_ASSERT_FALSE(assertion_fails(list));
}

static void end_all(void)
{
    may_end = true;
    for (unsigned i = 0U; i < PORT_STARTED_MAX; i++) {
        osal_task_join(&tasks[i]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_stacks_of_all_tasks_are_listed);
    end_all();
    RUN_TEST(a_task_without_room_in_the_list_is_an_error);
    end_all();
    return UNITY_END();
}
