// SPDX-License-Identifier: Apache-2.0
// How often a supervisor that has died is started again, and after which delay.
#include "launcher/return_budget.h"

#include "unity.h"

#define SECOND_NS 1000000000ULL

void setUp(void)
{
}

void tearDown(void)
{
}

static void three_returns_a_minute_are_granted_after_rising_delays(void)
{
    return_budget_t budget = {{0U}, 0U};
    uint64_t delay_ns      = 0U;
    TEST_ASSERT_TRUE(return_budget_take(&budget, 10U * SECOND_NS, &delay_ns));
    TEST_ASSERT_EQUAL_UINT64(0U, delay_ns);
    TEST_ASSERT_TRUE(return_budget_take(&budget, 20U * SECOND_NS, &delay_ns));
    TEST_ASSERT_EQUAL_UINT64(SECOND_NS / 10U, delay_ns);
    TEST_ASSERT_TRUE(return_budget_take(&budget, 30U * SECOND_NS, &delay_ns));
    TEST_ASSERT_EQUAL_UINT64(SECOND_NS, delay_ns);
    TEST_ASSERT_FALSE(return_budget_take(&budget, 40U * SECOND_NS, &delay_ns));
    TEST_ASSERT_FALSE(return_budget_take(&budget, (70U * SECOND_NS) - 1U, &delay_ns));
}

static void deaths_are_forgotten_after_a_minute(void)
{
    return_budget_t budget = {{0U}, 0U};
    uint64_t delay_ns      = 0U;
    for (uint64_t i = 0U; i < 20U; i++) {
        TEST_ASSERT_TRUE(return_budget_take(&budget, i * 20U * SECOND_NS, &delay_ns));
        TEST_ASSERT_EQUAL_UINT64((i < 2U) ? (i * SECOND_NS / 10U) : SECOND_NS, delay_ns);
    }
    TEST_ASSERT_TRUE(return_budget_take(&budget, 1000U * SECOND_NS, &delay_ns));
    TEST_ASSERT_EQUAL_UINT64(0U, delay_ns);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(three_returns_a_minute_are_granted_after_rising_delays);
    RUN_TEST(deaths_are_forgotten_after_a_minute);
    return UNITY_END();
}
