// SPDX-License-Identifier: Apache-2.0
// The plan run to which a subsystem belongs when failures of all severities follow each other in any order,
// and the times at which the actions of a run are due.
#include "fsw/supervisor/plan_runner.h"

#include "unity.h"

#include <string.h>

static plan_runner_t runner;
static mission_descriptor_t mission;

void setUp(void)
{
    (void)memset(&runner, 0, sizeof runner);
    descriptor_mission_clear(&mission);
    mission.storage.plans[0]   = (mission_plan_t){.first_action = 0U, .action_count = 2U};
    mission.storage.plans[1]   = (mission_plan_t){.first_action = 2U, .action_count = 0U};
    mission.plan_count         = 2U;
    mission.storage.actions[0] = (mission_action_t){.kind = MISSION_ACTION_LOG, .after_us = 0U};
    mission.storage.actions[1] = (mission_action_t){.kind = MISSION_ACTION_LOG, .after_us = 3000U};
}

void tearDown(void)
{
}

/// Returns a failure of `apid` in the network of the members from `first` to `last`.
static plan_run_t failure(descriptor_severity_t severity, uint16_t apid, uint16_t first, uint16_t last)
{
    plan_run_t run   = {.severity = severity, .plan = PLAN_BUILT_IN, .apid = apid, .event_id = apid};
    run.members[0]   = apid;
    run.member_count = 1U;
    for (uint16_t member = first; member <= last; member++) {
        if (member != apid) {
            run.members[run.member_count] = member;
            run.member_count++;
        }
    }
    return run;
}

/// Report a failure. Returns the number of runs that it has ended.
static unsigned fail(const plan_run_t* run, plan_verdict_t expected)
{
    unsigned ended = 0U;
    plan_run_t other;
    while (supervisor_plan_runner_overrule(&runner, run, &other)) {
        ended++;
        TEST_ASSERT_TRUE(other.severity < run->severity);
    }
    TEST_ASSERT_EQUAL(expected, supervisor_plan_runner_start(&runner, run));
    return ended;
}

static unsigned runs_under_way(void)
{
    unsigned count = 0U;
    for (unsigned i = 0U; i < PLAN_RUNS; i++) {
        count += (runner.runs[i].member_count > 0U) ? 1U : 0U;
    }
    return count;
}

static void check_one_run_each(void)
{
    unsigned memberships[65] = {0U};
    for (unsigned i = 0U; i < PLAN_RUNS; i++) {
        for (unsigned k = 0U; k < runner.runs[i].member_count; k++) {
            memberships[runner.runs[i].members[k]]++;
        }
    }
    for (unsigned i = 0U; i < 65U; i++) {
        TEST_ASSERT_TRUE(memberships[i] <= 1U);
    }
}

static void a_higher_severity_takes_all_members_and_ends_runs_of_lower_severity(void)
{
    const plan_run_t one = failure(DESCRIPTOR_MEDIUM, 1U, 1U, 2U);
    const plan_run_t two = failure(DESCRIPTOR_LOW, 3U, 3U, 4U);
    const plan_run_t far = failure(DESCRIPTOR_MEDIUM, 9U, 9U, 9U);
    const plan_run_t all = failure(DESCRIPTOR_HIGH, 2U, 1U, 4U);
    TEST_ASSERT_EQUAL(0U, fail(&one, PLAN_STARTED));
    TEST_ASSERT_EQUAL(0U, fail(&two, PLAN_STARTED));
    TEST_ASSERT_EQUAL(0U, fail(&far, PLAN_STARTED));
    TEST_ASSERT_EQUAL(2U, fail(&all, PLAN_STARTED));
    TEST_ASSERT_EQUAL(2U, runs_under_way());
    for (uint16_t member = 1U; member <= 4U; member++) {
        TEST_ASSERT_EQUAL(2U, supervisor_plan_runner_of(&runner, member)->apid);
    }
    TEST_ASSERT_EQUAL(9U, supervisor_plan_runner_of(&runner, 9U)->apid);
    TEST_ASSERT_NULL(supervisor_plan_runner_of(&runner, 5U));
}

static void a_lower_severity_starts_no_run_for_a_member_of_a_higher_one(void)
{
    const plan_run_t high   = failure(DESCRIPTOR_HIGH, 1U, 1U, 2U);
    const plan_run_t medium = failure(DESCRIPTOR_MEDIUM, 2U, 1U, 3U);
    const plan_run_t beside = failure(DESCRIPTOR_MEDIUM, 3U, 1U, 3U);
    (void)fail(&high, PLAN_STARTED);
    TEST_ASSERT_EQUAL(0U, fail(&medium, PLAN_OUTRANKED));
    TEST_ASSERT_EQUAL(0U, fail(&beside, PLAN_STARTED)); // 3 joined the network later, so only 3 is new.
    TEST_ASSERT_EQUAL(1U, supervisor_plan_runner_of(&runner, 3U)->member_count);
    TEST_ASSERT_EQUAL(1U, supervisor_plan_runner_of(&runner, 2U)->apid);
}

static void a_failure_of_the_same_severity_joins_the_run_with_its_members(void)
{
    const plan_run_t first  = failure(DESCRIPTOR_HIGH, 1U, 1U, 2U);
    const plan_run_t second = failure(DESCRIPTOR_HIGH, 2U, 1U, 3U);
    const plan_run_t lesser = failure(DESCRIPTOR_MEDIUM, 3U, 3U, 3U);
    (void)fail(&first, PLAN_STARTED);
    (void)fail(&lesser, PLAN_STARTED);
    TEST_ASSERT_EQUAL(1U, fail(&second, PLAN_JOINED)); // The run of 3 ends.
    TEST_ASSERT_EQUAL(1U, runs_under_way());
    TEST_ASSERT_EQUAL(3U, supervisor_plan_runner_of(&runner, 3U)->member_count);
    TEST_ASSERT_EQUAL(1U, supervisor_plan_runner_of(&runner, 3U)->event_id);
}

static void every_subsystem_of_the_largest_mission_has_room_for_its_run(void)
{
    for (unsigned turn = 0U; turn < 3U; turn++) {
        for (uint16_t apid = 1U; apid <= MISSION_SUBSYSTEMS_MAX; apid++) {
            const plan_run_t run = failure(DESCRIPTOR_MEDIUM, apid, apid, apid);
            (void)fail(&run, (turn == 0U) ? PLAN_STARTED : PLAN_JOINED);
        }
        TEST_ASSERT_EQUAL(PLAN_RUNS, runs_under_way());
    }
    const plan_run_t all = failure(DESCRIPTOR_HIGH, 7U, 1U, MISSION_SUBSYSTEMS_MAX);
    TEST_ASSERT_EQUAL(MISSION_SUBSYSTEMS_MAX, fail(&all, PLAN_STARTED));
    TEST_ASSERT_EQUAL(1U, runs_under_way());
}

static void no_sequence_of_failures_puts_a_subsystem_into_two_plan_runs(void)
{
    uint32_t random = 5U;
    for (unsigned i = 0U; i < 20000U; i++) {
        random               = (random * 1664525U) + 1013904223U;
        const uint16_t first = (uint16_t)(1U + ((random >> 8U) % MISSION_SUBSYSTEMS_MAX));
        const uint16_t last  = (uint16_t)(first + ((random >> 13U) % (MISSION_SUBSYSTEMS_MAX + 1U - first)));
        const uint16_t apid  = (uint16_t)(first + ((random >> 18U) % (last + 1U - first)));
        const plan_run_t run =
            failure((descriptor_severity_t)(1U + ((random >> 24U) % 4U)), apid, first, last);
        plan_run_t ended;
        while (supervisor_plan_runner_overrule(&runner, &run, &ended)) {
        }
        (void)supervisor_plan_runner_start(&runner, &run);
        check_one_run_each();
        TEST_ASSERT_TRUE(supervisor_plan_runner_of(&runner, apid)->severity >= run.severity);
        if ((random >> 30U) == 0U) {
            (void)supervisor_plan_runner_next(&runner.runs[i % PLAN_RUNS], &mission, 10000000000U);
            (void)supervisor_plan_runner_next(&runner.runs[i % PLAN_RUNS], &mission, 10000000000U);
        }
    }
}

static void actions_are_due_at_their_times_and_the_run_ends(void)
{
    plan_run_t run   = failure(DESCRIPTOR_HIGH, 1U, 1U, 1U);
    run.plan         = 0U;
    run.start_ns     = 1000000U;
    run.member_count = 0U; // There is no run.
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 1000000U));
    run.member_count = 1U;
    TEST_ASSERT_EQUAL_PTR(&mission.actions[0], supervisor_plan_runner_next(&run, &mission, 1000000U));
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 3999999U));
    TEST_ASSERT_EQUAL(1U, run.member_count);
    TEST_ASSERT_EQUAL_PTR(&mission.actions[1], supervisor_plan_runner_next(&run, &mission, 4000000U));
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 4000000U));
    TEST_ASSERT_EQUAL(0U, run.member_count);
    run.member_count = 1U;
    run.plan         = 1U; // A plan without actions.
    run.next_action  = 0U;
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 4000000U));
    TEST_ASSERT_EQUAL(0U, run.member_count);
}

static void the_built_in_plan_takes_the_network_offline(void)
{
    plan_run_t run = failure(DESCRIPTOR_HIGH, 1U, 1U, 1U);
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 499999999U));
    const mission_action_t* const action = supervisor_plan_runner_next(&run, &mission, 500000000U);
    TEST_ASSERT_EQUAL(MISSION_NETWORK, action->target);
    TEST_ASSERT_EQUAL(0U, action->state);
    TEST_ASSERT_NULL(supervisor_plan_runner_next(&run, &mission, 500000000U));
    TEST_ASSERT_EQUAL(0U, run.member_count);
}

static void a_plan_run_ignores_a_subsystem_whose_process_died(void)
{
    const plan_run_t run = failure(DESCRIPTOR_HIGH, 1U, 1U, 3U);
    (void)fail(&run, PLAN_STARTED);
    supervisor_plan_runner_mark_lost(&runner, 2U);
    supervisor_plan_runner_mark_lost(&runner, 9U); // The subsystem is in no run.
    const plan_run_t* const present = supervisor_plan_runner_of(&runner, 2U);
    TEST_ASSERT_TRUE(supervisor_plan_runner_concerns(present, 1U));
    TEST_ASSERT_FALSE(supervisor_plan_runner_concerns(present, 2U));
    TEST_ASSERT_TRUE(supervisor_plan_runner_concerns(present, 9U)); // The plan names it.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_higher_severity_takes_all_members_and_ends_runs_of_lower_severity);
    RUN_TEST(a_lower_severity_starts_no_run_for_a_member_of_a_higher_one);
    RUN_TEST(a_failure_of_the_same_severity_joins_the_run_with_its_members);
    RUN_TEST(every_subsystem_of_the_largest_mission_has_room_for_its_run);
    RUN_TEST(no_sequence_of_failures_puts_a_subsystem_into_two_plan_runs);
    RUN_TEST(actions_are_due_at_their_times_and_the_run_ends);
    RUN_TEST(the_built_in_plan_takes_the_network_offline);
    RUN_TEST(a_plan_run_ignores_a_subsystem_whose_process_died);
    return UNITY_END();
}
