// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/reconnect.h"

#include "test/support/assertion.h"
#include "unity.h"

static flow_reconnect_t reconnect;

void setUp(void)
{
    flow_reconnect_init(&reconnect, 10U, 100U);
}

void tearDown(void)
{
}

static void the_delay_doubles_up_to_its_maximum(void)
{
    static const uint64_t delays[] = {10U, 20U, 40U, 80U, 100U, 100U, 100U};
    uint64_t now                   = 5U;
    TEST_ASSERT_TRUE(flow_reconnect_is_due(&reconnect, 0U));
    for (size_t i = 0U; i < (sizeof delays / sizeof delays[0]); i++) {
        flow_reconnect_failed(&reconnect, now);
        TEST_ASSERT_FALSE(flow_reconnect_is_due(&reconnect, now + delays[i] - 1U));
        TEST_ASSERT_TRUE(flow_reconnect_is_due(&reconnect, now + delays[i]));
        now += delays[i] + 3U;
    }
    TEST_ASSERT_EQUAL_UINT32(7U, reconnect.failed);
}

static void a_connection_as_long_as_the_delay_resets_the_delay(void)
{
    flow_reconnect_failed(&reconnect, 0U);
    flow_reconnect_failed(&reconnect, 10U);
    flow_reconnect_succeeded(&reconnect, 30U);
    TEST_ASSERT_FALSE(flow_reconnect_is_due(&reconnect, UINT64_MAX));
    flow_reconnect_lost(&reconnect, 70U); // The connection lasted as long as the next delay, 40.
    TEST_ASSERT_FALSE(flow_reconnect_is_due(&reconnect, 79U));
    TEST_ASSERT_TRUE(flow_reconnect_is_due(&reconnect, 80U));
    TEST_ASSERT_EQUAL_UINT32(1U, reconnect.connected);
    TEST_ASSERT_EQUAL_UINT32(1U, reconnect.lost);
}

static void a_connection_that_is_lost_at_once_counts_as_a_failure(void)
{
    uint64_t now = 0U;
    for (unsigned i = 0U; i < 6U; i++) {
        flow_reconnect_succeeded(&reconnect, now);
        flow_reconnect_lost(&reconnect, now);
        now = reconnect.due_ns;
    }
    TEST_ASSERT_EQUAL_UINT64(10U + 20U + 40U + 80U + 100U + 100U, now);
    flow_reconnect_lost(&reconnect, now); // There is no connection: no effect.
    TEST_ASSERT_EQUAL_UINT32(6U, reconnect.lost);
}

static void time_and_delay_do_not_wrap(void)
{
    flow_reconnect_init(&reconnect, UINT64_MAX - 1U, UINT64_MAX);
    flow_reconnect_failed(&reconnect, 5U);
    TEST_ASSERT_FALSE(flow_reconnect_is_due(&reconnect, UINT64_MAX - 1U));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, reconnect.delay_ns);
}

static void begin_with_nothing(void)
{
    flow_reconnect_init(&reconnect, 0U, 1U);
}

static void begin_beyond_the_maximum(void)
{
    flow_reconnect_init(&reconnect, 2U, 1U);
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
    RUN_TEST(a_connection_as_long_as_the_delay_resets_the_delay);
    RUN_TEST(a_connection_that_is_lost_at_once_counts_as_a_failure);
    RUN_TEST(time_and_delay_do_not_wrap);
    RUN_TEST(coding_errors_are_assertions);
    return UNITY_END();
}
