// SPDX-License-Identifier: Apache-2.0
// A loop of services that has a lower priority than the program's own loop hangs: the watchdog resets the
// board. The program runs twice: in its first life the loop works and then hangs; its second life checks that
// the reset did not come before the hang.
#include "fsw/programs/loop_tasks.h"

#include "osal/include/osal/file.h"
#include "osal/include/osal/watchdog.h"
#include "unity.h"

#define WATCHDOG_MS 300U
#define MS 1000000ULL
#define WORKS_NS (2000U * MS)     ///< Time from the start at which the loop begins to hang.
#define HANGS_NS (5000U * MS)     ///< Time from the start before which the watchdog must reset the board.
#define NOTE "loop-watchdog.note" ///< File that is created before the loop hangs.

static subsystem_t component;
static loop_tasks_t tasks;
static bool hangs;

uint8_t __wrap_subsystem_loop_priority(subsystem_t* subsystem, uint8_t loop);
uint64_t __wrap_subsystem_loop_step(subsystem_t* subsystem, uint8_t loop, uint64_t now_ns);

uint8_t __wrap_subsystem_loop_priority(subsystem_t* const subsystem, const uint8_t loop)
{
    (void)subsystem;
    (void)loop;
    return 0U;
}

uint64_t __wrap_subsystem_loop_step(subsystem_t* const subsystem, const uint8_t loop, const uint64_t now_ns)
{
    (void)subsystem;
    while ((loop == 0U) && __atomic_load_n(&hangs, __ATOMIC_RELAXED)) {
    }
    return now_ns + (5U * MS);
}

void setUp(void)
{
}

void tearDown(void)
{
}

static void run_until(osal_clock_t* const clock, const uint64_t end_ns)
{
    for (uint64_t now_ns = 0U; now_ns < end_ns; now_ns = osal_clock_now_ns(clock)) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(clock, now_ns + MS, NULL, 0U));
        if (loop_tasks_are_alive(&tasks, osal_clock_now_ns(clock))) {
            osal_watchdog_feed();
        }
    }
}

/// First life of the program; a reset ends it.
static void a_hanging_loop_of_low_priority_resets_the_board(void)
{
    osal_clock_t clock;
    osal_file_t note;
    const uint64_t origin_ns = osal_clock_monotonic_ns();
    if (osal_watchdog_start(WATCHDOG_MS) == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has no watchdog");
    }
    osal_clock_open_real(&clock, origin_ns);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_set_priority(50)); // Above the tasks of the loops.
    TEST_ASSERT_EQUAL(STATUS_OK, loop_tasks_start(&tasks, &component, origin_ns));
    run_until(&clock, WORKS_NS);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&note, NOTE));
    osal_file_close(&note);
    __atomic_store_n(&hangs, true, __ATOMIC_RELAXED);
    run_until(&clock, HANGS_NS);
    TEST_FAIL_MESSAGE("the watchdog did not detect the hang");
}

static void the_reset_came_while_the_loop_hung(void)
{
    TEST_ASSERT_TRUE(osal_watchdog_has_reset());
    TEST_ASSERT_TRUE_MESSAGE(osal_file_exists(NOTE), "the board was reset while the loop still worked");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(NOTE));
}

int main(void)
{
    UNITY_BEGIN();
    if (osal_watchdog_has_reset()) {
        RUN_TEST(the_reset_came_while_the_loop_hung);
    } else {
        RUN_TEST(a_hanging_loop_of_low_priority_resets_the_board);
    }
    return UNITY_END();
}
