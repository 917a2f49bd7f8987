// SPDX-License-Identifier: Apache-2.0
// A program that hangs is reset by the watchdog of the board. The program runs twice: in its first life a
// task hangs, in its second life it checks what happened.
#include "osal/include/osal/watchdog.h"

#include "osal/freertos/board.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/task.h"
#include "unity.h"

#define PERIOD_MS 40U
#define NS_PER_MS 1000000ULL

/// Memory that a reset does not change: the watchdog writes a note here before it resets the board.
extern volatile uint32_t port_reset_note[2];

static volatile uint32_t initialised = 7U; ///< A reset initialises it again.
static volatile uint32_t zero;

void setUp(void)
{
}

void tearDown(void)
{
}

static void hang(void* const context)
{
    (void)context;
    for (;;) {
    }
}

/// Start the watchdog and hang. Does not return, because the watchdog resets the board.
static void hang_until_reset(void)
{
    osal_task_t task;
    initialised = 8U;
    zero        = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_watchdog_start(PERIOD_MS));
    // The task that hangs has a higher priority than this task, which feeds the watchdog.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, hang, NULL, 50));
    for (;;) {
        osal_watchdog_feed();
    }
}

static void the_watchdog_has_reset_the_board(void)
{
    TEST_ASSERT_TRUE(osal_watchdog_has_reset());
    // The start has cleared the note, so that a later start does not report this reset.
    TEST_ASSERT_EQUAL_UINT32(0U, port_reset_note[0]);
}

static void the_program_is_initialised_again(void)
{
    TEST_ASSERT_EQUAL_UINT32(7U, initialised);
    TEST_ASSERT_EQUAL_UINT32(0U, zero);
    // The clock has counted since the reset.
    TEST_ASSERT_TRUE(osal_clock_monotonic_ns() < (PERIOD_MS * NS_PER_MS));
}

static void the_watchdog_does_not_run_before_it_is_started(void)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + (3U * PERIOD_MS * NS_PER_MS);
    while (osal_clock_monotonic_ns() < until_ns) {
    }
    // If the watchdog ran, it would reset the board again and again in this loop, and the test would not end.
    TEST_ASSERT_TRUE(osal_watchdog_has_reset());
}

int main(void)
{
    if (!osal_watchdog_has_reset()) {
        hang_until_reset();
    }
    UNITY_BEGIN();
    RUN_TEST(the_watchdog_has_reset_the_board);
    RUN_TEST(the_program_is_initialised_again);
    RUN_TEST(the_watchdog_does_not_run_before_it_is_started);
    return UNITY_END();
}
