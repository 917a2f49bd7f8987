// SPDX-License-Identifier: Apache-2.0
// Lives of participants: start, stop, death and suspension at a defined simulated time. One process
// acts for all participants.
#include "osal/include/osal/lockstep_scheduler.h"

#include "test/support/assertion.h"
#include "unity.h"

#define STEP_NS 500U
#define FIRST 0U
#define SECOND 1U
#define THIRD 2U

static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
static osal_lockstep_t* scheduler;

void setUp(void)
{
    scheduler = osal_lockstep_create(storage, STEP_NS, false);
    if (scheduler == NULL) {
        TEST_IGNORE_MESSAGE("this port has no scheduler");
    }
    osal_lockstep_done(scheduler, FIRST, 0U);
}

void tearDown(void)
{
}

static osal_grant_t next_is(unsigned expected, uint64_t now_ns)
{
    unsigned participant = UINT32_MAX;
    osal_grant_t grant   = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(expected, participant);
    TEST_ASSERT_EQUAL_UINT64(now_ns, grant.now_ns);
    return grant;
}

static void awaited_is(unsigned expected)
{
    unsigned participant = UINT32_MAX;
    osal_grant_t grant   = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(expected, participant);
}

static osal_lockstep_presence_t presence(unsigned participant, uint32_t expected_life)
{
    uint32_t life                        = 0U;
    const osal_lockstep_presence_t found = osal_lockstep_presence(scheduler, participant, &life);
    TEST_ASSERT_EQUAL_UINT32(expected_life, life);
    return found;
}

static void a_life_begins_at_its_instant_and_not_before(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_expect(scheduler, SECOND, 3U, 2000U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 3U));
    osal_lockstep_done(scheduler, FIRST, 1500U);
    (void)next_is(FIRST, 1500U); // Time continues until the instant at which the life begins.
    osal_lockstep_deliver(scheduler, FIRST, SECOND, 3U, 2U, 5U);
    osal_lockstep_done(scheduler, FIRST, 2000U);
    awaited_is(SECOND); // The first participant does not run at that instant either.
    osal_lockstep_done(scheduler, SECOND, 0U);
    (void)next_is(FIRST, 2000U);
    osal_lockstep_done(scheduler, FIRST, 5000U);
    const osal_grant_t grant = next_is(SECOND, 2000U);
    TEST_ASSERT_EQUAL_UINT32(2U, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(5U, grant.octets);
}

static void a_participant_that_joins_early_is_granted_no_earlier(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_expect(scheduler, SECOND, 1U, 2000U);
    osal_lockstep_done(scheduler, SECOND, 0U); // The process joins before its life begins.
    osal_lockstep_deliver(scheduler, FIRST, SECOND, 1U, 1U, 0U);
    osal_lockstep_done(scheduler, FIRST, 1000U);
    (void)next_is(FIRST, 1000U);
    osal_lockstep_done(scheduler, FIRST, 3000U);
    TEST_ASSERT_EQUAL_UINT32(1U, next_is(SECOND, 2000U).messages);
}

static void deliveries_and_ends_of_another_life_have_no_effect(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_expect(scheduler, SECOND, 1U, 0U);
    osal_lockstep_done(scheduler, SECOND, 0U);
    osal_lockstep_dismiss(scheduler, SECOND, 1U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(SECOND, 1U));
    osal_lockstep_expect(scheduler, SECOND, 2U, 1000U);
    osal_lockstep_deliver(scheduler, FIRST, SECOND, 1U, 7U, 7U); // Delivered to the first life.
    osal_lockstep_end(scheduler, SECOND, 1U); // The launcher detects the death of its process only now.
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 2U));
    osal_lockstep_dismiss(scheduler, SECOND, 1U);
    osal_lockstep_kill(scheduler, SECOND, 1U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 2U));
    // A participant can have only one life at a time, so the call has no effect.
    osal_lockstep_expect(scheduler, SECOND, 3U, 0U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 2U));
    osal_lockstep_done(scheduler, FIRST, 4000U);
    awaited_is(SECOND);
    osal_lockstep_done(scheduler, SECOND, 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(SECOND, 1000U).messages);
}

static void a_start_that_fails_is_reported_at_its_instant(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_expect(scheduler, SECOND, 2U, 2000U);
    osal_lockstep_expect(scheduler, THIRD, 2U, 2000U);
    osal_lockstep_done(scheduler, THIRD, 0U); // THIRD joins, and dies before its first grant.
    osal_lockstep_end(scheduler, SECOND, 2U);
    osal_lockstep_end(scheduler, THIRD, 2U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 2U));
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_JOINED, presence(THIRD, 2U));
    osal_lockstep_done(scheduler, FIRST, 1500U);
    (void)next_is(FIRST, 1500U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(SECOND, 2U));
    osal_lockstep_done(scheduler, FIRST, 2500U);
    (void)next_is(FIRST, 2500U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(SECOND, 2U));
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(THIRD, 2U));
}

static void a_start_that_was_cancelled_is_absent_at_once(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_expect(scheduler, SECOND, 2U, 2000U);
    osal_lockstep_dismiss(scheduler, SECOND, 2U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(SECOND, 2U));
    osal_lockstep_done(scheduler, FIRST, 3000U);
    (void)next_is(FIRST, 3000U);
}

static void grants_that_fall_due_during_a_suspension_are_given_after_it(void)
{
    osal_lockstep_done(scheduler, SECOND, 500U);
    (void)next_is(FIRST, 0U);
    osal_lockstep_suspend(scheduler, SECOND);
    osal_lockstep_suspend(scheduler, THIRD); // THIRD is absent, so the call has no effect.
    osal_lockstep_deliver(scheduler, FIRST, SECOND, OSAL_LOCKSTEP_ANY_LIFE, 3U, 0U);
    osal_lockstep_done(scheduler, FIRST, 1000U);
    (void)next_is(FIRST, 1000U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_JOINED, presence(SECOND, 0U));
    osal_lockstep_resume(scheduler, SECOND);
    osal_lockstep_resume(scheduler, THIRD);
    osal_lockstep_done(scheduler, FIRST, 9000U);
    TEST_ASSERT_EQUAL_UINT32(3U,
                             next_is(SECOND, 1000U).messages); // SECOND had not had its turn in this instant.
    osal_lockstep_suspend(scheduler, FIRST);
    osal_lockstep_done(scheduler, SECOND, 10000U);
    (void)next_is(SECOND, 10000U); // The requested wake time of FIRST has passed.
    osal_lockstep_resume(scheduler, FIRST);
    osal_lockstep_done(scheduler, SECOND, 20000U);
    // The turn of FIRST in that instant has passed: it wakes in the next time step.
    (void)next_is(FIRST, 10500U);
}

static void a_suspended_participant_ends_as_any_other(void)
{
    osal_lockstep_done(scheduler, SECOND, 500U);
    (void)next_is(FIRST, 0U);
    osal_lockstep_suspend(scheduler, SECOND);
    osal_lockstep_kill(scheduler, SECOND, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(SECOND, 0U));
    osal_lockstep_expect(scheduler, SECOND, 1U, 1000U);
    osal_lockstep_done(scheduler, FIRST, 3000U);
    awaited_is(SECOND);
    osal_lockstep_done(scheduler, SECOND, 0U);
    (void)next_is(SECOND, 1000U); // SECOND is no longer suspended.
}

static void a_participant_can_be_suspended_only_after_its_life_has_begun(void)
{
    (void)next_is(FIRST, 0U);
    TEST_ASSERT_EQUAL_UINT64(OSAL_LOCKSTEP_NEVER, osal_lockstep_begin_ns(scheduler, SECOND));
    osal_lockstep_expect(scheduler, SECOND, 1U, 1000U);
    TEST_ASSERT_EQUAL_UINT64(OSAL_LOCKSTEP_NEVER, osal_lockstep_begin_ns(scheduler, SECOND));
    osal_lockstep_done(scheduler, SECOND, 0U); // SECOND has joined before its life begins.
    TEST_ASSERT_EQUAL_UINT64(1000U, osal_lockstep_begin_ns(scheduler, SECOND));
    osal_lockstep_suspend(scheduler, SECOND); // No effect, as if SECOND had not joined.
    osal_lockstep_done(scheduler, FIRST, 1000U);
    (void)next_is(FIRST, 1000U);
    osal_lockstep_done(scheduler, FIRST, 2000U);
    (void)next_is(SECOND, 1000U);
    osal_lockstep_kill(scheduler, SECOND, OSAL_LOCKSTEP_ANY_LIFE);
    osal_lockstep_expect(scheduler, SECOND, 2U, 2000U);
    osal_lockstep_done(scheduler, SECOND, 0U);
    (void)next_is(FIRST, 2000U);
    osal_lockstep_suspend(scheduler, SECOND);
    osal_lockstep_done(scheduler, FIRST, 3000U);
    (void)next_is(FIRST, 3000U); // SECOND is suspended, although it has had no grant yet.
    TEST_ASSERT_EQUAL_UINT64(2000U, osal_lockstep_begin_ns(scheduler, SECOND));
}

static void the_holder_is_reported(void)
{
    uint32_t before = 0U;
    uint32_t after  = 0U;
    TEST_ASSERT_EQUAL_UINT(OSAL_LOCKSTEP_PARTICIPANTS_MAX, osal_lockstep_holder(scheduler, &before));
    (void)next_is(FIRST, 0U);
    TEST_ASSERT_EQUAL_UINT(FIRST, osal_lockstep_holder(scheduler, &after));
    TEST_ASSERT_EQUAL_UINT32(1U, after - before);
}

// ---- All slots taken ----

#define SLOTS OSAL_LOCKSTEP_PARTICIPANTS_MAX

/// Each slot has a life that joined at time 0 and wakes in each time step: life 1, except the first slot,
/// which was not expected.
static void take_all_slots(void)
{
    for (unsigned i = 0U; i < SLOTS; i++) {
        osal_lockstep_expect(scheduler, i, 1U, 0U);
    }
    for (unsigned i = 1U; i < SLOTS; i++) {
        osal_lockstep_done(scheduler, i, 0U);
    }
}

/// Run one time step, in which all slots except one (SLOTS: none) have their turn once, in order.
static void run_time_step(uint64_t now_ns, unsigned without)
{
    for (unsigned i = 0U; i < SLOTS; i++) {
        if (i != without) {
            (void)next_is(i, now_ns);
            osal_lockstep_done(scheduler, i, now_ns + STEP_NS);
        }
    }
}

/// A slot that is taken is not given again: the life in it continues unaffected.
static void an_expected_life_does_not_replace_a_present_one(void)
{
    take_all_slots();
    run_time_step(0U, SLOTS);
    for (unsigned i = 0U; i < SLOTS; i++) {
        (void)next_is(i, STEP_NS);
        for (unsigned k = 0U; k < SLOTS; k++) { // In the middle of the time step, too.
            osal_lockstep_expect(scheduler, k, 2U, STEP_NS);
            TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_JOINED, presence(k, (k == FIRST) ? 0U : 1U));
        }
        osal_lockstep_done(scheduler, i, 2U * STEP_NS);
    }
    run_time_step(2U * STEP_NS, SLOTS);
    TEST_ASSERT_EQUAL(SLOTS, osal_lockstep_awaited(scheduler)); // No participant holds time.
}

static void expect_one_too_many(void)
{
    osal_lockstep_expect(scheduler, SLOTS, 1U, 0U);
}

static void deliver_to_one_too_many(void)
{
    osal_lockstep_deliver(scheduler, FIRST, SLOTS, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
}

/// There is no further slot: a request for one is a coding error.
static void one_slot_too_many_is_a_coding_error(void)
{
    take_all_slots();
    TEST_ASSERT_TRUE(assertion_fails(expect_one_too_many));
    TEST_ASSERT_TRUE(assertion_fails(deliver_to_one_too_many));
    run_time_step(0U, SLOTS);
}

/// Restart one slot after the other: the others keep order and time, and the next life gets no deliveries of
/// the ended one.
static void a_slot_that_was_freed_is_taken_again(void)
{
    take_all_slots();
    uint64_t now_ns = 0U;
    for (unsigned i = 0U; i < SLOTS; i++) {
        run_time_step(now_ns, SLOTS);
        osal_lockstep_deliver(scheduler, (i + 1U) % SLOTS, i, OSAL_LOCKSTEP_ANY_LIFE, 5U, 7U);
        osal_lockstep_end(scheduler, i, OSAL_LOCKSTEP_ANY_LIFE);
        now_ns += STEP_NS;
        run_time_step(now_ns, i);
        now_ns += STEP_NS;
        osal_lockstep_expect(scheduler, i, 9U, now_ns);
        awaited_is(i);
        osal_lockstep_done(scheduler, i, now_ns);
        for (unsigned k = 0U; k < SLOTS; k++) {
            const osal_grant_t grant = next_is(k, now_ns);
            TEST_ASSERT_EQUAL_UINT32(0U, grant.messages + grant.octets);
            osal_lockstep_done(scheduler, k, now_ns + STEP_NS);
        }
        TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_JOINED, presence(i, 9U));
        now_ns += STEP_NS;
    }
    run_time_step(now_ns, SLOTS);
}

/// All slots except one are expected at one instant and fail before it: each life ends at that instant, and
/// the one slot continues.
static void all_slots_may_fail_to_begin_at_once(void)
{
    for (uint32_t life = 1U; life <= 3U; life++) {
        const uint64_t begin_ns = 10U * life * STEP_NS;
        (void)next_is(FIRST, begin_ns - (10U * STEP_NS));
        for (unsigned i = 1U; i < SLOTS; i++) {
            osal_lockstep_expect(scheduler, i, life, begin_ns);
            osal_lockstep_end(scheduler, i, life);
            TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, presence(i, life));
        }
        osal_lockstep_done(scheduler, FIRST, begin_ns);
    }
    (void)next_is(FIRST, 30U * STEP_NS);
    for (unsigned i = 1U; i < SLOTS; i++) {
        TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, presence(i, 3U));
    }
    osal_lockstep_done(scheduler, FIRST, OSAL_LOCKSTEP_NEVER);
    unsigned participant = 0U;
    osal_grant_t grant   = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
}

// ---- Streams ----

/// THIRD has a stream that SECOND serves; both wait.
static void open_stream(void)
{
    (void)next_is(FIRST, 0U);
    osal_lockstep_done(scheduler, SECOND, 0U);
    osal_lockstep_set_stream_port(scheduler, THIRD, 4711U);
    osal_lockstep_done(scheduler, THIRD, 0U);
    osal_lockstep_done(scheduler, FIRST, 2000U);
    (void)next_is(SECOND, 0U);
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_served_port(scheduler, THIRD));
    // The stream has another port, so the call has no effect.
    osal_lockstep_serve_stream(scheduler, THIRD, 4712U, SECOND);
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_serve_stream(scheduler, THIRD, 4711U, SECOND);
    TEST_ASSERT_EQUAL_UINT16(4711U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_done(scheduler, SECOND, 2000U);
    (void)next_is(THIRD, 0U);
    osal_lockstep_done(scheduler, THIRD, OSAL_LOCKSTEP_NEVER);
}

static void a_stream_ends_with_the_life_of_its_server(void)
{
    open_stream();
    (void)next_is(FIRST, 2000U);
    osal_lockstep_deliver(scheduler, FIRST, THIRD, OSAL_LOCKSTEP_ANY_LIFE, 1U, 7U);
    osal_lockstep_kill(scheduler, SECOND, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_stream_port(scheduler, THIRD));
    osal_lockstep_done(scheduler, FIRST, 5000U);
    const osal_grant_t grant = next_is(THIRD, 2000U); // In the same instant: its turn was still to come.
    TEST_ASSERT_EQUAL_UINT32(0U, grant.octets);       // Deliveries that were not yet reported are lost.
    TEST_ASSERT_EQUAL_UINT32(1U, grant.messages);
    osal_lockstep_set_stream_port(scheduler, THIRD, 4712U);
    osal_lockstep_done(scheduler, THIRD, OSAL_LOCKSTEP_NEVER);
    (void)next_is(FIRST, 5000U);
    osal_lockstep_expect(scheduler, SECOND, 2U, 5000U);
    osal_lockstep_end(scheduler, SECOND, 2U); // A life that serves no stream ends without effect on others.
    TEST_ASSERT_EQUAL_UINT16(4712U, osal_lockstep_stream_port(scheduler, THIRD));
}

static void a_server_that_cuts_a_stream_wakes_its_participant(void)
{
    open_stream();
    (void)next_is(FIRST, 2000U);
    osal_lockstep_done(scheduler, FIRST, 5000U);
    (void)next_is(SECOND, 2000U);
    osal_lockstep_cut_stream(scheduler, THIRD, 0U);
    osal_lockstep_cut_stream(scheduler, THIRD, 4712U); // There is no such stream, so the call has no effect.
    TEST_ASSERT_EQUAL_UINT16(4711U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_deliver(scheduler, SECOND, THIRD, OSAL_LOCKSTEP_ANY_LIFE, 0U, 7U);
    osal_lockstep_cut_stream(scheduler, THIRD, 4711U);
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_done(scheduler, SECOND, 4000U);
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(THIRD, 2000U).octets);
    osal_lockstep_set_stream_port(scheduler, THIRD, 4712U);
    osal_lockstep_done(scheduler, THIRD, OSAL_LOCKSTEP_NEVER);
    (void)next_is(SECOND, 4000U);
    osal_lockstep_serve_stream(scheduler, THIRD, 4712U, SECOND);
    osal_lockstep_set_stream_port(scheduler, THIRD, 4712U); // The same port: the stream continues.
    TEST_ASSERT_EQUAL_UINT16(4712U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_set_stream_port(scheduler, THIRD, 4713U);
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_served_port(scheduler, THIRD));
    osal_lockstep_done(scheduler, SECOND, 9000U);
    (void)next_is(THIRD, 4000U); // The new stream is served: its client is woken in the same instant.
}

/// Neither the end of its server nor that of another process discards what was delivered after the cut.
static void a_stream_that_was_cut_is_not_cut_again(void)
{
    open_stream();
    (void)next_is(FIRST, 2000U);
    osal_lockstep_done(scheduler, FIRST, 5000U);
    (void)next_is(SECOND, 2000U);
    osal_lockstep_cut_stream(scheduler, THIRD, 4711U);
    osal_lockstep_done(scheduler, SECOND, 9000U);
    (void)next_is(THIRD, 2000U);
    osal_lockstep_done(scheduler, THIRD, OSAL_LOCKSTEP_NEVER);
    (void)next_is(FIRST, 5000U);
    osal_lockstep_deliver(scheduler, FIRST, THIRD, OSAL_LOCKSTEP_ANY_LIFE, 0U, 7U);
    osal_lockstep_kill(scheduler, SECOND, OSAL_LOCKSTEP_ANY_LIFE);
    osal_lockstep_kill(scheduler, FIRST, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_EQUAL_UINT32(7U, next_is(THIRD, 5000U).octets);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_life_begins_at_its_instant_and_not_before);
    RUN_TEST(a_participant_that_joins_early_is_granted_no_earlier);
    RUN_TEST(deliveries_and_ends_of_another_life_have_no_effect);
    RUN_TEST(a_start_that_fails_is_reported_at_its_instant);
    RUN_TEST(a_start_that_was_cancelled_is_absent_at_once);
    RUN_TEST(grants_that_fall_due_during_a_suspension_are_given_after_it);
    RUN_TEST(a_suspended_participant_ends_as_any_other);
    RUN_TEST(a_participant_can_be_suspended_only_after_its_life_has_begun);
    RUN_TEST(the_holder_is_reported);
    RUN_TEST(an_expected_life_does_not_replace_a_present_one);
    RUN_TEST(one_slot_too_many_is_a_coding_error);
    RUN_TEST(a_slot_that_was_freed_is_taken_again);
    RUN_TEST(all_slots_may_fail_to_begin_at_once);
    RUN_TEST(a_stream_ends_with_the_life_of_its_server);
    RUN_TEST(a_server_that_cuts_a_stream_wakes_its_participant);
    RUN_TEST(a_stream_that_was_cut_is_not_cut_again);
    return UNITY_END();
}
