// SPDX-License-Identifier: Apache-2.0
// Limits on the number of system objects in use, and their warning.
#include "base/quota.h"

#include "test/support/assertion.h"
#include "unity.h"

static quota_t quota;

void setUp(void)
{
}

void tearDown(void)
{
}

static void a_quota_grants_no_more_than_its_limit(void)
{
    for (uint16_t limit = 1U; limit <= 20U; limit++) {
        quota_init(&quota, limit);
        for (uint16_t i = 0U; i < limit; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota));
        }
        TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, quota_take(&quota));
        TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, quota_take(&quota));
        TEST_ASSERT_EQUAL_UINT16(limit, quota.stats.used);
        TEST_ASSERT_EQUAL_UINT32(2U, quota.stats.refused);
        quota_give(&quota);
        TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota));
        for (uint16_t i = 0U; i < limit; i++) {
            quota_give(&quota);
        }
        TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
        TEST_ASSERT_EQUAL_UINT16(limit, quota.stats.peak);
        TEST_ASSERT_FALSE(quota.stats.warning);
    }
}

static void the_warning_rises_at_75_percent_and_falls_at_65_percent(void)
{
    quota_init(&quota, 8U);
    for (unsigned i = 1U; i <= 8U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota));
        TEST_ASSERT_EQUAL(i >= 6U, quota.stats.warning);
        TEST_ASSERT_EQUAL(i == 6U, quota_poll_warning(&quota));
    }
    for (unsigned i = 7U; i > 0U; i--) {
        quota_give(&quota);
        TEST_ASSERT_EQUAL(i > 5U, quota.stats.warning);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, quota.stats.warnings);
    TEST_ASSERT_FALSE(quota_poll_warning(&quota));
}

static void without_a_quota_nothing_is_refused(void)
{
    for (unsigned i = 0U; i < 10U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, quota_take(NULL));
    }
    quota_give(NULL);
}

static void give_too_much(void)
{
    quota_init(&quota, 1U);
    quota_give(&quota);
}

static void no_limit(void)
{
    quota_init(&quota, 0U);
}

static void coding_errors_are_assertions(void)
{
    TEST_ASSERT_TRUE(assertion_fails(give_too_much));
    TEST_ASSERT_TRUE(assertion_fails(no_limit));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_quota_grants_no_more_than_its_limit);
    RUN_TEST(without_a_quota_nothing_is_refused);
    RUN_TEST(the_warning_rises_at_75_percent_and_falls_at_65_percent);
    RUN_TEST(coding_errors_are_assertions);
    return UNITY_END();
}
