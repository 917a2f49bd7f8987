// SPDX-License-Identifier: Apache-2.0
// A loop of services that hangs below the loop of its program: the watchdog resets the board. The program
// runs twice: in its first life the loop works, then hangs; in its second it looks what happened.
#include "fsw/programs/loop_tasks.h"

#include "osal/include/osal/file.h"
#include "osal/include/osal/watchdog.h"
#include "unity.h"

#define WATCHDOG_MS 300U
#define MS 1000000ULL
#define WORKS_NS (2000U * MS)
#define HANGS_NS (5000U * MS)
#define NOTE "loop-watchdog.note" ///< Made when the loop begins to hang.

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
static void a_loop_below_hangs(void)
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
    TEST_FAIL_MESSAGE("the watchdog did not see the hang");
}

static void the_watchdog_has_reset_the_board(void)
{
    TEST_ASSERT_TRUE(osal_watchdog_has_reset());
    TEST_ASSERT_TRUE_MESSAGE(osal_file_exists(NOTE), "it was reset while the loop worked");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(NOTE));
}

int main(void)
{
    UNITY_BEGIN();
    if (osal_watchdog_has_reset()) {
        RUN_TEST(the_watchdog_has_reset_the_board);
    } else {
        RUN_TEST(a_loop_below_hangs);
    }
    return UNITY_END();
}
