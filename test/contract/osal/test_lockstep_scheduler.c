// SPDX-License-Identifier: Apache-2.0
// The rules of the scheduler one by one; one process acts for all participants.
// posix/test_lockstep_scheduler.c tests it with several processes.
#include "osal/include/osal/lockstep_scheduler.h"

#include "unity.h"

#define STEP_NS 500U

static uint64_t table_storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));

void setUp(void)
{
    if (osal_lockstep_create(table_storage, STEP_NS, false) == NULL) {
        TEST_IGNORE_MESSAGE("this port has no scheduler");
    }
}

void tearDown(void)
{
}

static osal_lockstep_t* table(unsigned participants)
{
    osal_lockstep_t* const scheduler = osal_lockstep_create(table_storage, STEP_NS, false);
    for (unsigned i = 0U; i < participants; i++) {
        osal_lockstep_done(scheduler, i, 0U);
    }
    return scheduler;
}

static osal_grant_t next_is(osal_lockstep_t* scheduler, unsigned expected, uint64_t now_ns)
{
    unsigned participant = UINT32_MAX;
    osal_grant_t grant   = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(expected, participant);
    TEST_ASSERT_EQUAL_UINT64(now_ns, grant.now_ns);
    TEST_ASSERT_EQUAL_UINT64(now_ns, osal_lockstep_now_ns(scheduler));
    return grant;
}

static void without_a_wake_time_next_is_empty(void)
{
    unsigned participant = 0U;
    osal_grant_t grant;
    osal_lockstep_t* const scheduler = table(0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_done(scheduler, 3U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_TRUE(osal_lockstep_is_present(scheduler, 3U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_close(scheduler);
    TEST_ASSERT_TRUE(osal_lockstep_is_closed(scheduler));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_lockstep_next(scheduler, &participant, &grant));
}

static void delivery_wakes_later_participants_now_and_earlier_ones_in_the_next_time_step(void)
{
    osal_lockstep_t* const scheduler = table(3U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 0U);
    osal_lockstep_deliver(scheduler, 1U, 2U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 7U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 5U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_grant_t grant = next_is(scheduler, 2U, 0U);
    TEST_ASSERT_EQUAL_UINT32(1U, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(7U, grant.octets);
    osal_lockstep_deliver(
        scheduler, 2U, 2U, OSAL_LOCKSTEP_ANY_LIFE, 1U,
        0U); // The delivery to itself wakes it in the next time step, before its requested wake time.
    osal_lockstep_done(scheduler, 2U, 10U * STEP_NS);
    grant = next_is(scheduler, 0U, STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(3U, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(5U, grant.octets);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    grant = next_is(scheduler, 2U, STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(1U, grant.messages);
    osal_lockstep_done(scheduler, 2U, 10U * STEP_NS);
    grant = next_is(scheduler, 2U, 10U * STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(0U, grant.messages);
}

static void next_time_step_is_on_the_grid_when_now_is_not(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 2U * STEP_NS + 123U);
    (void)next_is(scheduler, 1U, 2U * STEP_NS + 123U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 1U); // The wake time passed long ago.
    (void)next_is(scheduler, 0U, 3U * STEP_NS);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 3U * STEP_NS);
}

static void expected_participant_holds_time_until_it_joins_or_ends(void)
{
    unsigned participant = 0U;
    osal_grant_t grant;
    osal_lockstep_t* const scheduler = table(2U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U); // The participant is present, so the call has no effect.
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_expect(scheduler, 5U, 1U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 5U, OSAL_LOCKSTEP_ANY_LIFE, 4U, 0U);
    osal_lockstep_done(scheduler, 0U, STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_FALSE(osal_lockstep_is_present(scheduler, 5U));
    osal_lockstep_done(scheduler, 5U, 7U * STEP_NS);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_EQUAL_UINT32(4U, next_is(scheduler, 5U, 0U).messages);
    osal_lockstep_expect(scheduler, 6U, 1U, 0U);
    osal_lockstep_done(scheduler, 5U, 7U * STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_end(scheduler, 6U, OSAL_LOCKSTEP_ANY_LIFE);
    (void)next_is(scheduler, 0U, STEP_NS);
}

static void deliveries_to_absent_or_ended_participants_are_dropped(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 9U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 1U);
    osal_lockstep_set_stream_port(scheduler, 1U, 4711U);
    TEST_ASSERT_EQUAL_UINT16(4711U, osal_lockstep_stream_port(scheduler, 1U));
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 3U, 3U);
    osal_lockstep_end(scheduler, 1U, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_FALSE(osal_lockstep_is_present(scheduler, 1U));
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_stream_port(scheduler, 1U));
    osal_lockstep_done(scheduler, 1U, 0U); // The participant joins again.
    osal_lockstep_done(scheduler, 9U, 0U);
    // The participant ends while it holds the grant.
    osal_lockstep_end(scheduler, 0U, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(scheduler, 1U, 0U).messages);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(scheduler, 9U, 0U).messages);
}

static void late_joiner_of_a_lower_order_waits_for_the_next_time_step(void)
{
    osal_lockstep_t* const scheduler = table(0U);
    osal_lockstep_done(scheduler, 4U, 0U);
    (void)next_is(scheduler, 4U, 0U);
    osal_lockstep_done(scheduler, 2U, 0U);
    osal_lockstep_done(scheduler, 7U, 0U);
    osal_lockstep_done(scheduler, 4U, STEP_NS);
    (void)next_is(scheduler, 7U, 0U);
    osal_lockstep_done(scheduler, 7U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 2U, STEP_NS);
}

static void counts_saturate(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, UINT32_MAX, UINT32_MAX - 1U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 1U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    const osal_grant_t grant = next_is(scheduler, 1U, 0U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, grant.octets);
}

static void end_of_time_is_not_passed(void)
{
    osal_lockstep_t* const scheduler = table(1U);
    unsigned participant             = 0U;
    osal_grant_t grant;
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER - 1U);
    (void)next_is(scheduler, 0U, OSAL_LOCKSTEP_NEVER - 1U);
    osal_lockstep_done(scheduler, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
}

static void a_hold_is_seen_by_all_and_ended_by_anyone(void)
{
    static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 1U, true);
    osal_lockstep_t* const other     = osal_lockstep_attach(storage);
    TEST_ASSERT_FALSE(osal_lockstep_is_held(scheduler));
    osal_lockstep_hold(scheduler, true);
    TEST_ASSERT_TRUE(osal_lockstep_is_held(other));
    osal_lockstep_hold(other, false);
    TEST_ASSERT_FALSE(osal_lockstep_is_held(scheduler));
}

static void attach_needs_a_scheduler(void)
{
    static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
    TEST_ASSERT_NULL(osal_lockstep_attach(storage));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 1U, true);
    TEST_ASSERT_NOT_NULL(scheduler);
    TEST_ASSERT_EQUAL_PTR(scheduler, osal_lockstep_attach(storage));
}

// Deliveries not reported to the ended life go to the next one; no participant is granted in between, and
// time waits for it.
static void a_succession_is_one_operation(void)
{
    unsigned participant             = UINT32_MAX;
    uint32_t life                    = 0U;
    osal_grant_t grant               = {0U, 0U, 0U};
    osal_lockstep_t* const scheduler = table(1U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 0U);
    osal_lockstep_set_succession(scheduler, 1U, 10U * STEP_NS);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, STEP_NS);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 0U, STEP_NS);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 0U);
    osal_lockstep_kill(scheduler, 1U, 1U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, osal_lockstep_presence(scheduler, 1U, &life));
    TEST_ASSERT_EQUAL_UINT32(2U, life);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 3U, 0U);
    osal_lockstep_end(scheduler, 1U, 1U); // The end of this process was already known.
    osal_lockstep_done(scheduler, 0U, 20U * STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(1U, participant);
    osal_lockstep_done(scheduler, 1U, 0U);
    grant = next_is(scheduler, 1U, 11U * STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(5U, grant.messages);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_lockstep_set_succession(scheduler, 1U, 0U); // From here on, no life follows an end.
    (void)next_is(scheduler, 0U, 20U * STEP_NS);
    osal_lockstep_kill(scheduler, 1U, 2U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, osal_lockstep_presence(scheduler, 1U, &life));
}

static void a_participant_whose_next_life_was_cancelled_becomes_absent(void)
{
    uint32_t life                    = 0U;
    osal_lockstep_t* const scheduler = table(1U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_lockstep_set_succession(scheduler, 1U, 10U * STEP_NS);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_kill(scheduler, 1U, 1U);
    osal_lockstep_set_succession(scheduler, 1U, 0U);
    osal_lockstep_end(scheduler, 1U, 2U);
    osal_lockstep_done(scheduler, 0U, 20U * STEP_NS);
    (void)next_is(scheduler, 0U, 20U * STEP_NS);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, osal_lockstep_presence(scheduler, 1U, &life));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(without_a_wake_time_next_is_empty);
    RUN_TEST(delivery_wakes_later_participants_now_and_earlier_ones_in_the_next_time_step);
    RUN_TEST(next_time_step_is_on_the_grid_when_now_is_not);
    RUN_TEST(expected_participant_holds_time_until_it_joins_or_ends);
    RUN_TEST(deliveries_to_absent_or_ended_participants_are_dropped);
    RUN_TEST(late_joiner_of_a_lower_order_waits_for_the_next_time_step);
    RUN_TEST(counts_saturate);
    RUN_TEST(end_of_time_is_not_passed);
    RUN_TEST(a_hold_is_seen_by_all_and_ended_by_anyone);
    RUN_TEST(attach_needs_a_scheduler);
    RUN_TEST(a_succession_is_one_operation);
    RUN_TEST(a_participant_whose_next_life_was_cancelled_becomes_absent);
    return UNITY_END();
}
