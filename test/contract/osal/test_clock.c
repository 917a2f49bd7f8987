// SPDX-License-Identifier: Apache-2.0
// A wait may be late on a machine with other load, but never early: no test requires one wait to be punctual.
#include "osal/include/osal/clock.h"

#include "osal/include/osal/task.h"
#include "unity.h"

#include <stdbool.h>

#define MS 1000000ULL
#define STEP_NS 500000U

static osal_clock_t wall;

void setUp(void)
{
    osal_clock_open_real(&wall, osal_clock_monotonic_ns());
}

void tearDown(void)
{
}

static void real_time_counts_from_its_origin(void)
{
    const uint64_t before_ns = osal_clock_monotonic_ns();
    TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) <= osal_clock_monotonic_ns() - wall.origin_ns);
    TEST_ASSERT_TRUE(osal_clock_monotonic_ns() >= before_ns);
    osal_clock_open_real(&wall, before_ns + 3600000U * MS);
    TEST_ASSERT_EQUAL_UINT64(0U, osal_clock_now_ns(&wall)); // The origin is in the future, so the time is 0.
    TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_messages_due(&wall));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_octets_due(&wall));
    osal_clock_deliver(&wall, 3U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 1U); // The call has no effect.
}

/// The origin is long ago, so the times since then are large.
static void a_wait_ends_with_an_early_origin(void)
{
    osal_clock_open_real(&wall, 1U);
    const uint64_t wake_ns = osal_clock_now_ns(&wall) + MS;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, NULL, 0U));
    TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) >= wake_ns);
}

/// Each cycle works for half its period. Absolute sleep compensates for that, and for any delay of the
/// machine; relative sleep would be 100 periods late at the end. Therefore at least one of the last 100
/// wake-ups must be less than 50 periods late.
static void absolute_sleep_does_not_drift(void)
{
    const uint64_t period_ns = MS;
    const uint64_t begin_ns  = osal_clock_now_ns(&wall);
    uint64_t least_late_ns   = UINT64_MAX;
    for (uint64_t i = 1U; i <= 200U; i++) {
        const uint64_t wake_ns = begin_ns + (i * period_ns);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, NULL, 0U));
        const uint64_t late_ns = osal_clock_now_ns(&wall) - wake_ns;
        TEST_ASSERT_TRUE(late_ns < UINT64_MAX / 2U); // Never early.
        least_late_ns = ((i > 100U) && (late_ns < least_late_ns)) ? late_ns : least_late_ns;
        while (osal_clock_now_ns(&wall) < (wake_ns + (period_ns / 2U))) {
        }
    }
    TEST_ASSERT_TRUE(least_late_ns < (50U * period_ns));
}

static void a_wait_is_never_early(void)
{
    for (uint64_t i = 1U; i <= 40U; i++) {
        const uint64_t wake_ns = osal_clock_now_ns(&wall) + (i * MS / 10U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, NULL, 0U));
        TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) >= wake_ns);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, 0U, NULL, 0U)); // The wake time has passed.
}

static void the_monotonic_clock_never_goes_back(void)
{
    uint64_t before_ns      = osal_clock_monotonic_ns();
    const uint64_t begin_ns = before_ns;
    for (uint32_t i = 0U; (i < 20000U) || (before_ns == begin_ns); i++) { // The time also advances.
        const uint64_t now_ns = osal_clock_monotonic_ns();
        TEST_ASSERT_TRUE(now_ns >= before_ns);
        before_ns = now_ns;
    }
}

static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
static uint64_t messages_seen;

static void partner(void* context)
{
    osal_lockstep_t* const scheduler = context;
    osal_clock_t clock;
    osal_clock_open_stepped(&clock, scheduler, 2U, OSAL_LOCKSTEP_ANY_LIFE);
    while (osal_clock_wait(&clock, OSAL_CLOCK_NEVER, NULL, 0U) == STATUS_OK) {
        messages_seen += osal_clock_messages_due(&clock);
        osal_clock_deliver(&clock, 1U, OSAL_LOCKSTEP_ANY_LIFE, 0U, 10U * osal_clock_octets_due(&clock));
    }
}

static void stepped_time_is_that_of_the_grant(void)
{
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    if (scheduler == NULL) {
        TEST_IGNORE_MESSAGE("this port has no scheduler");
    }
    osal_task_t task;
    osal_clock_t clock;
    osal_clock_open_stepped(&clock, scheduler, 1U, OSAL_LOCKSTEP_ANY_LIFE);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_expect(scheduler, 2U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, partner, scheduler, 0));
    TEST_ASSERT_EQUAL_UINT64(0U, osal_clock_now_ns(&clock));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock, 0U, NULL, 0U));
    for (uint32_t i = 1U; i <= 100U; i++) {
        osal_clock_deliver(&clock, 2U, OSAL_LOCKSTEP_ANY_LIFE, 1U, i);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock, OSAL_CLOCK_NEVER, NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)i * STEP_NS, osal_clock_now_ns(&clock));
        TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_messages_due(&clock));
        TEST_ASSERT_EQUAL_UINT32(10U * i, osal_clock_octets_due(&clock));
    }
    osal_lockstep_close(scheduler);
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT64(100U, messages_seen);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_clock_wait(&clock, 0U, NULL, 0U));
}

static void the_clock_returns_the_granted_time(void)
{
    const osal_grant_t first   = {STEP_NS, 2U, 3U};
    const osal_grant_t second  = {2U * STEP_NS, 0U, 0U};
    osal_deliveries_t reported = {.messages = {7U}};
    osal_clock_t clock;
    osal_clock_open_granted(&clock, &reported);
    TEST_ASSERT_EQUAL(OSAL_CLOCK_STEPPED, clock.mode);
    TEST_ASSERT_EQUAL_UINT64(0U, osal_clock_now_ns(&clock));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_messages_due(&clock));
    TEST_ASSERT_EQUAL_UINT32(0U, reported.messages[0]);
    osal_clock_take_grant(&clock, &first);
    TEST_ASSERT_EQUAL_UINT64(STEP_NS, osal_clock_now_ns(&clock));
    TEST_ASSERT_EQUAL_UINT32(2U, osal_clock_messages_due(&clock));
    TEST_ASSERT_EQUAL_UINT32(3U, osal_clock_octets_due(&clock));
    osal_clock_deliver(&clock, 1U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    osal_clock_deliver(&clock, 1U, 3U, 1U, 20U);
    TEST_ASSERT_EQUAL_UINT32(3U, reported.lives[1]); // The life of the last delivery.
    osal_clock_deliver(&clock, OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U, OSAL_LOCKSTEP_ANY_LIFE, UINT32_MAX, 5U);
    osal_clock_deliver(&clock, OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, reported.messages[0]);
    TEST_ASSERT_EQUAL_UINT32(2U, reported.messages[1]);
    TEST_ASSERT_EQUAL_UINT32(20U, reported.octets[1]);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, reported.messages[OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U]);
    TEST_ASSERT_EQUAL_UINT32(5U, reported.octets[OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U]);
    osal_clock_take_grant(&clock, &second);
    TEST_ASSERT_EQUAL_UINT32(0U, reported.messages[1]);
    TEST_ASSERT_EQUAL_UINT32(0U, reported.octets[OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U]);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_octets_due(&clock));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(real_time_counts_from_its_origin);
    RUN_TEST(a_wait_ends_with_an_early_origin);
    RUN_TEST(absolute_sleep_does_not_drift);
    RUN_TEST(a_wait_is_never_early);
    RUN_TEST(the_monotonic_clock_never_goes_back);
    RUN_TEST(stepped_time_is_that_of_the_grant);
    RUN_TEST(the_clock_returns_the_granted_time);
    return UNITY_END();
}
