// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/watchdog.h"

#include "osal/include/osal/clock.h"
#include "unity.h"

#define PERIOD_MS 50U

static bool has_watchdog;

void setUp(void)
{
    has_watchdog = (osal_watchdog_start(PERIOD_MS) == STATUS_OK);
}

void tearDown(void)
{
    osal_watchdog_stop();
}

static void pause_ms(const uint32_t ms)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + (ms * 1000000ULL);
    while (osal_clock_monotonic_ns() < until_ns) {
    }
}

static void a_wrong_period_or_a_missing_watchdog_is_refused(void)
{
    const status_t started = osal_watchdog_start(PERIOD_MS);
    TEST_ASSERT_TRUE((started == STATUS_OK) || (started == STATUS_UNSUPPORTED));
    const status_t refused = has_watchdog ? STATUS_INVALID : STATUS_UNSUPPORTED;
    TEST_ASSERT_EQUAL(refused, osal_watchdog_start(0U));
    TEST_ASSERT_EQUAL(refused, osal_watchdog_start(UINT32_MAX));
    TEST_ASSERT_FALSE(osal_watchdog_has_reset());
}

static void a_loop_that_feeds_the_watchdog_is_not_reset(void)
{
    if (!has_watchdog) {
        TEST_IGNORE_MESSAGE("this port has no watchdog");
    }
    for (unsigned i = 0U; i < 20U; i++) {
        pause_ms(PERIOD_MS / 5U);
        osal_watchdog_feed();
    }
    TEST_ASSERT_FALSE(osal_watchdog_has_reset());
}

static void the_watchdog_may_be_fed_near_the_end_of_its_period(void)
{
    if (!has_watchdog) {
        TEST_IGNORE_MESSAGE("this port has no watchdog");
    }
    for (unsigned i = 0U; i < 4U; i++) {
        pause_ms((PERIOD_MS * 9U) / 10U);
        osal_watchdog_feed();
    }
    TEST_ASSERT_FALSE(osal_watchdog_has_reset());
}

static void a_stopped_watchdog_does_nothing(void)
{
    osal_watchdog_stop();
    osal_watchdog_feed(); // The call does not start the watchdog.
    pause_ms(3U * PERIOD_MS);
    osal_watchdog_stop();
    TEST_ASSERT_FALSE(osal_watchdog_has_reset());
}

/// After a reset the program begins again; in this second start it must end here, otherwise the board would
/// be reset again and again.
static void the_watchdog_has_not_reset_the_board(void)
{
    TEST_ASSERT_FALSE_MESSAGE(osal_watchdog_has_reset(), "the watchdog reset the board in an earlier test");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_watchdog_has_not_reset_the_board);
    if (osal_watchdog_has_reset()) {
        return UNITY_END();
    }
    RUN_TEST(a_wrong_period_or_a_missing_watchdog_is_refused);
    RUN_TEST(a_loop_that_feeds_the_watchdog_is_not_reset);
    RUN_TEST(the_watchdog_may_be_fed_near_the_end_of_its_period);
    RUN_TEST(a_stopped_watchdog_does_nothing);
    return UNITY_END();
}
