// SPDX-License-Identifier: Apache-2.0
// The loop of 2 kHz on the timers of the board; the tick of the kernel is only 1 kHz. Times are counts of the
// free-running timer (40 ns), read from its register. On the emulated board they depend only on the number of
// instructions, so these bounds do not depend on the load of the machine.
#include "osal/include/osal/clock.h"

#include "osal/freertos/board.h"
#include "osal/include/osal/socket.h"
#include "osal/include/osal/task.h"
#include "unity.h"

#define PERIOD_NS 500000U
#define PERIOD_COUNTS (PERIOD_NS / BOARD_CLOCK_NS)
#define CYCLES 1000U
#define LATE_COUNTS 1250U ///< 50 us, for the wake-up and the interrupts before it.

static osal_clock_t wall;
static uint32_t is_over;
static uint32_t disturber_waits;

void setUp(void)
{
    is_over         = 0U;
    disturber_waits = 0U;
    osal_clock_open_real(&wall, 0U);
}

void tearDown(void)
{
}

/// The timer counts down from its largest value.
static uint32_t counts(void)
{
    return UINT32_MAX - *(volatile const uint32_t*)(BOARD_FREE_TIMER + 4U);
}

static void work_until(const uint64_t end_ns)
{
    while (osal_clock_now_ns(&wall) < end_ns) {
    }
}

/// Run the loop for CYCLES periods, and work during a part of each.
static void loop(const uint64_t worked_ns)
{
    const uint64_t begin_ns   = ((osal_clock_now_ns(&wall) / PERIOD_NS) + 2U) * PERIOD_NS;
    const uint32_t begin      = (uint32_t)(begin_ns / BOARD_CLOCK_NS);
    uint32_t longest_counts   = 0U;
    uint32_t latest_of_second = 0U;
    for (uint32_t i = 0U; i < CYCLES; i++) {
        const uint64_t wake_ns = begin_ns + ((uint64_t)i * PERIOD_NS);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, NULL, 0U));
        const int32_t late = (int32_t)(counts() - begin - (i * PERIOD_COUNTS));
        TEST_ASSERT_TRUE_MESSAGE(late >= 0, "a wait was early");
        longest_counts   = ((uint32_t)late > longest_counts) ? (uint32_t)late : longest_counts;
        latest_of_second = (i >= (CYCLES / 2U)) ? (uint32_t)late : latest_of_second;
        work_until(wake_ns + worked_ns);
    }
    TEST_ASSERT_TRUE_MESSAGE(longest_counts <= LATE_COUNTS, "a wait was late");
    TEST_ASSERT_TRUE(latest_of_second <= LATE_COUNTS); // The loop has not drifted.
}

static void an_idle_loop_keeps_its_period_in_counts_of_the_timer(void)
{
    loop(0U);
}

static void a_loop_that_works_for_most_of_its_period_keeps_its_period(void)
{
    loop((PERIOD_NS * 9U) / 10U);
}

/// A task with a lower priority than the loop: it sleeps 130 us and works 70 us, again and again.
static void disturb(void* const context)
{
    osal_clock_t clock;
    (void)context;
    osal_clock_open_real(&clock, 0U);
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        const uint64_t wake_ns = osal_clock_now_ns(&clock) + 130000U;
        if ((osal_clock_wait(&clock, wake_ns, NULL, 0U) != STATUS_OK) ||
            (osal_clock_now_ns(&clock) < wake_ns)) {
            return;
        }
        (void)__atomic_add_fetch(&disturber_waits, 1U, __ATOMIC_RELEASE);
        const uint64_t end_ns = osal_clock_now_ns(&clock) + 70000U;
        while (osal_clock_now_ns(&clock) < end_ns) {
        }
    }
}

static void a_loop_keeps_its_period_beside_tasks_with_other_waits(void)
{
    osal_task_t tasks[3];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_set_priority(60));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[i], disturb, NULL, 10 + i));
    }
    loop(PERIOD_NS / 5U);
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    for (int i = 0; i < 3; i++) {
        osal_task_join(&tasks[i]);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_set_priority(0));
    TEST_ASSERT_TRUE(disturber_waits > 1000U);
}

/// A wait for a time that has passed returns at once; the wait after it ends on the grid of periods again.
static void a_late_cycle_does_not_move_the_grid(void)
{
    const uint64_t begin_ns = ((osal_clock_now_ns(&wall) / PERIOD_NS) + 2U) * PERIOD_NS;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, begin_ns, NULL, 0U));
    work_until(begin_ns + PERIOD_NS + (PERIOD_NS / 2U));
    const uint32_t before = counts();
    // The time has passed, so the call returns at once.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, begin_ns + PERIOD_NS, NULL, 0U));
    TEST_ASSERT_TRUE((counts() - before) < LATE_COUNTS);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, begin_ns + (2U * PERIOD_NS), NULL, 0U));
    const uint32_t late = counts() - (uint32_t)((begin_ns + (2U * PERIOD_NS)) / BOARD_CLOCK_NS);
    TEST_ASSERT_TRUE(late <= LATE_COUNTS);
}

/// On a board no socket can end a sleep, so a wait for sockets is refused at once; otherwise it would react
/// too late to what arrives.
static void a_wait_for_sockets_is_refused_at_once(void)
{
    osal_socket_t socket           = OSAL_SOCKET_CLOSED;
    osal_socket_t* const sockets[] = {&socket};
    const uint64_t begin_ns        = osal_clock_now_ns(&wall);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_clock_wait(&wall, begin_ns + (100U * PERIOD_NS), sockets, 1U));
    TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) < (begin_ns + PERIOD_NS));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_idle_loop_keeps_its_period_in_counts_of_the_timer);
    RUN_TEST(a_loop_that_works_for_most_of_its_period_keeps_its_period);
    RUN_TEST(a_loop_keeps_its_period_beside_tasks_with_other_waits);
    RUN_TEST(a_late_cycle_does_not_move_the_grid);
    RUN_TEST(a_wait_for_sockets_is_refused_at_once);
    return UNITY_END();
}
