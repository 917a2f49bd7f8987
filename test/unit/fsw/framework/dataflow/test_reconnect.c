// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/reconnect.h"

#include "test/support/assertion.h"
#include "unity.h"

static reconnect_t reconnect;

void setUp(void)
{
    reconnect_init(&reconnect, 10U, 100U);
}

void tearDown(void)
{
}

static void the_delay_doubles_up_to_its_maximum(void)
{
    static const uint64_t delays[] = {10U, 20U, 40U, 80U, 100U, 100U, 100U};
    uint64_t now                   = 5U;
    TEST_ASSERT_TRUE(reconnect_is_due(&reconnect, 0U));
    for (size_t i = 0U; i < (sizeof delays / sizeof delays[0]); i++) {
        reconnect_failed(&reconnect, now);
        TEST_ASSERT_FALSE(reconnect_is_due(&reconnect, now + delays[i] - 1U));
        TEST_ASSERT_TRUE(reconnect_is_due(&reconnect, now + delays[i]));
        now += delays[i] + 3U;
    }
    TEST_ASSERT_EQUAL_UINT32(7U, reconnect.failed);
}

static void a_connection_that_stood_begins_anew(void)
{
    reconnect_failed(&reconnect, 0U);
    reconnect_failed(&reconnect, 10U);
    reconnect_succeeded(&reconnect, 30U);
    TEST_ASSERT_FALSE(reconnect_is_due(&reconnect, UINT64_MAX));
    reconnect_lost(&reconnect, 70U); // As long as the next delay of 40.
    TEST_ASSERT_FALSE(reconnect_is_due(&reconnect, 79U));
    TEST_ASSERT_TRUE(reconnect_is_due(&reconnect, 80U));
    TEST_ASSERT_EQUAL_UINT32(1U, reconnect.connected);
    TEST_ASSERT_EQUAL_UINT32(1U, reconnect.lost);
}

static void one_that_falls_at_once_counts_as_a_failure(void)
{
    uint64_t now = 0U;
    for (unsigned i = 0U; i < 6U; i++) {
        reconnect_succeeded(&reconnect, now);
        reconnect_lost(&reconnect, now);
        now = reconnect.due_ns;
    }
    TEST_ASSERT_EQUAL_UINT64(10U + 20U + 40U + 80U + 100U + 100U, now);
    reconnect_lost(&reconnect, now); // Not connected: no effect.
    TEST_ASSERT_EQUAL_UINT32(6U, reconnect.lost);
}

static void time_and_delay_do_not_wrap(void)
{
    reconnect_init(&reconnect, UINT64_MAX - 1U, UINT64_MAX);
    reconnect_failed(&reconnect, 5U);
    TEST_ASSERT_FALSE(reconnect_is_due(&reconnect, UINT64_MAX - 1U));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, reconnect.delay_ns);
}

static void begin_with_nothing(void)
{
    reconnect_init(&reconnect, 0U, 1U);
}

static void begin_beyond_the_maximum(void)
{
    reconnect_init(&reconnect, 2U, 1U);
}

static void coding_errors_are_assertions(void)
{
    TEST_ASSERT_TRUE(assertion_fails(begin_with_nothing));
    TEST_ASSERT_TRUE(assertion_fails(begin_beyond_the_maximum));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_delay_doubles_up_to_its_maximum);
    RUN_TEST(a_connection_that_stood_begins_anew);
    RUN_TEST(one_that_falls_at_once_counts_as_a_failure);
    RUN_TEST(time_and_delay_do_not_wrap);
    RUN_TEST(coding_errors_are_assertions);
    return UNITY_END();
}
