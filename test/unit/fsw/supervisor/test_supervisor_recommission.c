// SPDX-License-Identifier: Apache-2.0
// A subsystem that has died is started again within its restart budget and, if the mission requires it,
// recommissioned with its network; and all causes that can stop recommissioning.
#include "fsw/supervisor/recommission.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

#define SECOND 100U ///< Ticks.
// Reports of events, up to the event number; APID and further fields follow.
#define RETURNED "G 5.1 001F" ///< RECOMMISSIONED.
#define STOPPED "G 5.2 0020"  ///< RECOMMISSION_STOPPED.
#define HUNG "G 5.4 001E"     ///< PROCESS_HUNG.

static mission_subsystem_t* mission_of(uint16_t apid)
{
    return (mission_subsystem_t*)supervisor_registry_find(&fixture.supervisor, apid)->mission;
}

/// Link ARM and HAND and bring them to a state; the mission requires recommissioning for both.
static void link_up(state_t state)
{
    fixture_open_up();
    mission_of(ARM)->is_recommissioned  = true;
    mission_of(HAND)->is_recommissioned = true;
    fixture_link_up(state);
}

static void die(unsigned member)
{
    fixture.members[member].is_running = false;
    fixture_run(1U);
}

static void expect_line(const char* format, unsigned first, unsigned second)
{
    char expected[64];
    (void)snprintf(expected, sizeof expected, format, first, second);
    TEST_ASSERT_TRUE_MESSAGE(fixture_has(expected), expected);
}

static void expect_back(uint16_t apid, state_t state)
{
    expect_line(RETURNED "%04X%04X", apid, (unsigned)state);
}

static bool is_under_way(uint16_t apid)
{
    return supervisor_registry_find(&fixture.supervisor, apid)->recommission.is_active;
}

/// Expect that recommissioning has ended, with an event that contains the state and the failure code.
static void expect_stopped(uint16_t apid, state_t state, unsigned code)
{
    char expected[64];
    (void)snprintf(expected, sizeof expected, STOPPED "%04X%04X%04X", apid, (unsigned)state, code);
    TEST_ASSERT_TRUE_MESSAGE(fixture_has(expected), expected);
    TEST_ASSERT_FALSE(is_under_way(apid));
}

void setUp(void)
{
}

void tearDown(void)
{
    fixture_close();
}

// ---- Return to the earlier state ----

static void a_network_is_recommissioned_with_its_links(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    TEST_ASSERT_TRUE(is_under_way(ARM));
    TEST_ASSERT_TRUE(is_under_way(HAND));
    fixture_run(2U * SECOND);
    expect_back(ARM, STATE_OPERATIONAL);
    expect_back(HAND, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    TEST_ASSERT_EQUAL(2U, fixture.members[FIXTURE_ARM].configuration);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_HAND].state);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.6 000100000003")); // Other epochs.
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.6 000200000004"));
    TEST_ASSERT_FALSE(fixture_has("G 130.4")); // No user has requested this.
    TEST_ASSERT_FALSE(fixture_has("G 1."));
    fixture_forget();
    fixture_run(SECOND);
    TEST_ASSERT_FALSE(fixture_has("TC 129."));
}

static void recommissioning_ends_in_the_state_before_the_death(void)
{
    static const state_t states[] = {STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL};
    for (unsigned i = 0U; i < 2U; i++) {
        link_up(states[i]);
        die(FIXTURE_ARM);
        fixture_run(3U * SECOND);
        expect_back(ARM, states[i]);
        expect_back(HAND, states[i]);
        TEST_ASSERT_EQUAL(states[i], fixture.members[FIXTURE_ARM].state);
        TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
        if (i == 0U) {
            fixture_close();
        }
    }
}

static void a_subsystem_that_was_not_up_stays_down(void)
{
    fixture_open_up();
    mission_of(ARM)->is_recommissioned = true;
    die(FIXTURE_ARM);
    TEST_ASSERT_FALSE(is_under_way(ARM));
    fixture_run(SECOND);
    TEST_ASSERT_FALSE(fixture_has("16 TC 129."));
}

static void no_subsystem_is_recommissioned_unless_the_mission_requires_that(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(ARM)->is_recommissioned = false;
    die(FIXTURE_ARM);
    fixture_run(3U * SECOND);
    TEST_ASSERT_FALSE(fixture_has(RETURNED));
    TEST_ASSERT_FALSE(fixture_has(STOPPED));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_ARM].state);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_HAND].state);
}

static void a_subsystem_without_configuration_returns_to_its_earlier_state(void)
{
    fixture_open_up();
    mission_of(LONE)->is_recommissioned = true;
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(3U);
    die(FIXTURE_LONE);
    fixture_run(2U * SECOND);
    expect_back(LONE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_EQUAL(PHASE_UNCONFIGURED, fixture.members[FIXTURE_LONE].phase);
}

// ---- Causes that stop recommissioning ----

static void a_mode_that_forbids_recommissioning_stops_the_running_one(void)
{
    const uint8_t safe[1] = {MODE_SAFE};
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SET_MODE, safe, 1U);
    fixture_run(2U * SECOND);
    expect_stopped(ARM, STATE_PRE_OPERATIONAL, PUS_FAILURE_PERMISSION);
    expect_stopped(HAND, STATE_PRE_OPERATIONAL, PUS_FAILURE_PERMISSION);
}

/// The mission permits configuration 2. A configuration whose number differs in the first octet is not
/// permitted.
static void a_configuration_that_is_not_permitted_stops_recommissioning(void)
{
    link_up(STATE_OPERATIONAL);
    supervisor_registry_find(&fixture.supervisor, ARM)->rested_with = 0x0102U;
    die(FIXTURE_ARM);
    fixture_run(2U * SECOND);
    expect_stopped(ARM, STATE_PRE_OPERATIONAL, PUS_FAILURE_PERMISSION);
    TEST_ASSERT_FALSE(fixture_has("16 TC 129.3"));
}

/// The member stays in OFFLINE: it gets one order and has five seconds.
static void a_member_that_does_not_follow_an_order_stops_recommissioning(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(HAND)->is_recommissioned = false;
    die(FIXTURE_ARM);
    fixture.members[FIXTURE_ARM].is_passive = true;
    fixture_run(5U * SECOND);
    TEST_ASSERT_TRUE(is_under_way(ARM));
    fixture_run(2U * SECOND);
    expect_stopped(ARM, STATE_OFFLINE, PUS_FAILURE_TIMEOUT);
    TEST_ASSERT_EQUAL(1U, fixture_count(fixture_look(), "16 TC 129.8 03"));
}

/// A configuration that is applied late, but in time, is progress: another five seconds begin.
static void a_new_phase_is_progress(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(HAND)->is_recommissioned = false;
    die(FIXTURE_ARM);
    for (unsigned i = 0U;
         (i < (2U * SECOND)) && (fixture.members[FIXTURE_ARM].state != STATE_PRE_OPERATIONAL); i++) {
        fixture_run(1U);
    }
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    fixture.members[FIXTURE_ARM].is_passive = true;
    fixture_run(4U * SECOND);
    TEST_ASSERT_EQUAL(PHASE_UNCONFIGURED, fixture.members[FIXTURE_ARM].phase);
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL); // Now the member is configured.
    TEST_ASSERT_EQUAL(PHASE_CONFIGURED, fixture.members[FIXTURE_ARM].phase);
    fixture_run(4U * SECOND);
    TEST_ASSERT_TRUE(is_under_way(ARM));
    fixture_run(2U * SECOND);
    expect_stopped(ARM, STATE_PRE_OPERATIONAL, PUS_FAILURE_TIMEOUT);
}

static void recommissioning_stops_in_time_when_a_partner_does_not_arrive(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(HAND)->is_recommissioned = false;
    die(FIXTURE_ARM);
    fixture_run(4U * SECOND);
    TEST_ASSERT_FALSE(fixture_has(STOPPED));
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    fixture_run(4U * SECOND);
    expect_stopped(ARM, STATE_PRE_OPERATIONAL, PUS_FAILURE_TIMEOUT);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
}

static void a_refused_link_is_requested_three_times(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture.members[FIXTURE_HAND].refuses_links = PUS_LINK_REASON_PERIOD;
    fixture_run(8U * SECOND);
    // Two links are renewed.
    TEST_ASSERT_EQUAL(2U * RECOMMISSION_RENEWALS, fixture_count(fixture_look(), "17 TC 130.3"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
}

static void a_member_that_fails_again_is_not_recommissioned(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    fixture_run(SECOND + (SECOND / 2U));
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    fixture_run(2U);
    expect_stopped(ARM, STATE_ERROR_OPERATIONAL, PUS_FAILURE_STATE);
}

static void a_member_commanded_down_by_a_user_is_not_recommissioned(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    fixture_run(SECOND + (SECOND / 2U));
    (void)fixture_request_state(ARM, STATE_OFFLINE);
    fixture_run(4U);
    expect_stopped(ARM, STATE_OFFLINE, PUS_FAILURE_STATE);
    fixture_run(SECOND);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_ARM].state);
}

static void a_member_that_had_failed_before_is_not_recommissioned(void)
{
    link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    fixture_run(SECOND / 5U);
    die(FIXTURE_ARM);
    TEST_ASSERT_TRUE(is_under_way(ARM));
    TEST_ASSERT_FALSE(is_under_way(HAND));
}

/// A partner detects the silence of the dead subsystem before the supervisor does.
static void a_member_that_failed_by_the_same_death_is_recommissioned(void)
{
    link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture_run(1U);
    TEST_ASSERT_TRUE(is_under_way(HAND));
    fixture_run(2U * SECOND);
    expect_back(HAND, STATE_OPERATIONAL);
}

static void no_subsystem_is_recommissioned_at_the_end_of_the_mission(void)
{
    link_up(STATE_OPERATIONAL);
    fixture.is_stop_requested = true;
    fixture_run(1U);
    die(FIXTURE_ARM);
    fixture_run(1U);
    TEST_ASSERT_FALSE(is_under_way(ARM));
}

/// The second failure has no plan of its own: the built-in plan for HIGH events starts.
static void a_recovery_plan_for_a_recommissioned_subsystem_stops_recommissioning(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    fixture_run(SECOND + (SECOND / 2U));
    TEST_ASSERT_TRUE(is_under_way(ARM));
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    TEST_ASSERT_FALSE(is_under_way(ARM));
    TEST_ASSERT_TRUE(fixture_has(STOPPED "0010"));
}

static void the_shutdown_ends_recommissioning(void)
{
    link_up(STATE_OPERATIONAL);
    die(FIXTURE_ARM);
    fixture.is_stop_requested = true;
    fixture_run(2U * SECOND);
    TEST_ASSERT_TRUE(fixture.is_finished);
    TEST_ASSERT_FALSE(fixture_has(STOPPED));
    TEST_ASSERT_FALSE(is_under_way(ARM));
}

// ---- A hang during recommissioning ----

/// The member makes no step, and neither receives nor sends, until it is killed for this.
static void hang(unsigned member)
{
    fixture_member_t* const one = &fixture.members[member];
    const unsigned kills        = fixture.kills;
    fixture.late_apid           = one->apid;
    fixture.promise_ns          = fixture.now_ns;
    one->takes_nothing          = true;
    one->is_silent              = true;
    fixture_run(3U);
    TEST_ASSERT_EQUAL(kills, fixture.kills); // The member has the time that its mission allows.
    fixture_run(1U);
    TEST_ASSERT_EQUAL(kills + 1U, fixture.kills);
    one->takes_nothing = false;
    one->is_silent     = false;
}

static unsigned deaths_of(uint16_t apid)
{
    return supervisor_registry_find(&fixture.supervisor, apid)->deaths;
}

/// At each instant of its recommissioning, also while a link is being opened, the member hangs. It is killed,
/// which uses its restart budget; then it and its partner start again and return to their states.
static void a_member_that_hangs_during_recommissioning_starts_again(void)
{
    unsigned on_the_way = 0U;
    for (unsigned ticks = 0U; ticks <= 60U; ticks++) {
        char where[32];
        (void)snprintf(where, sizeof where, "after %u ticks", ticks);
        link_up(STATE_OPERATIONAL);
        die(FIXTURE_ARM);
        fixture_run(ticks);
        on_the_way += is_under_way(ARM) ? 1U : 0U;
        hang(FIXTURE_ARM);
        TEST_ASSERT_TRUE_MESSAGE(is_under_way(ARM), where); // A completed recommissioning has started again.
        TEST_ASSERT_EQUAL_MESSAGE(1U, fixture_count(fixture_look(), HUNG "0010"), where);
        fixture_run(5U * SECOND);
        const char* const text = fixture_look();
        TEST_ASSERT_EQUAL_MESSAGE(1U, fixture.kills, where);
        TEST_ASSERT_EQUAL_MESSAGE(2U, fixture.starts, where);
        TEST_ASSERT_EQUAL_MESSAGE(2U, deaths_of(ARM), where);
        TEST_ASSERT_EQUAL_MESSAGE(0U, fixture_count(text, "G 5.4"), where);
        TEST_ASSERT_EQUAL_MESSAGE(1U, fixture_count(text, RETURNED "00100005"), where);
        TEST_ASSERT_EQUAL_MESSAGE(0U, fixture_count(text, STOPPED), where);
        TEST_ASSERT_FALSE_MESSAGE(is_under_way(ARM) || is_under_way(HAND), where);
        TEST_ASSERT_EQUAL_MESSAGE(STATE_OPERATIONAL, fixture.members[FIXTURE_ARM].state, where);
        TEST_ASSERT_EQUAL_MESSAGE(STATE_OPERATIONAL, fixture.members[FIXTURE_HAND].state, where);
        TEST_ASSERT_EQUAL_MESSAGE(2U, fixture.supervisor.graph.count, where);
        TEST_ASSERT_EQUAL_MESSAGE(MODE_NOMINAL, fixture.supervisor.mode, where);
        fixture_close();
    }
    // At the last instants the recommissioning was complete.
    TEST_ASSERT_TRUE((on_the_way > 50U) && (on_the_way <= 60U));
    fixture_open();
}

/// The plan of the partner changes the mission to a mode that forbids the further states: each
/// recommissioning ends and is reported.
static void the_recovery_plan_of_a_hanging_partner_ends_recommissioning(void)
{
    for (unsigned ticks = 0U; ticks <= 52U; ticks += 4U) {
        char where[32];
        (void)snprintf(where, sizeof where, "after %u ticks", ticks);
        link_up(STATE_OPERATIONAL);
        die(FIXTURE_ARM);
        fixture_run(ticks);
        hang(FIXTURE_HAND);
        fixture_run(12U * SECOND);
        const char* const text = fixture_look();
        TEST_ASSERT_EQUAL_MESSAGE(1U, fixture.kills, where);
        TEST_ASSERT_EQUAL_MESSAGE(2U, fixture.starts, where);
        TEST_ASSERT_EQUAL_MESSAGE(1U, deaths_of(HAND), where);
        TEST_ASSERT_EQUAL_MESSAGE(1U, fixture_count(text, HUNG "0011"), where);
        TEST_ASSERT_FALSE_MESSAGE(is_under_way(ARM) || is_under_way(HAND), where);
        TEST_ASSERT_EQUAL_MESSAGE(
            1U, fixture_count(text, RETURNED "0010") + fixture_count(text, STOPPED "0010"), where);
        TEST_ASSERT_EQUAL_MESSAGE(
            1U, fixture_count(text, RETURNED "0011") + fixture_count(text, STOPPED "0011"), where);
        fixture_close();
    }
    fixture_open();
}

/// Each life hangs during its recommissioning: the pauses grow, and the last life of the budget ends in the
/// fallback mode, which is reported once.
static void hangs_during_recommissioning_use_up_the_restart_budget(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(ARM)->restart_budget = 3U;
    die(FIXTURE_ARM);
    static const unsigned pauses[] = {12U, 102U}; // Ticks until the next start.
    for (unsigned i = 0U; i < 2U; i++) {
        fixture_run(30U);
        TEST_ASSERT_TRUE(is_under_way(ARM));
        hang(FIXTURE_ARM);
        TEST_ASSERT_TRUE(is_under_way(ARM)); // The earlier state is still known.
        TEST_ASSERT_EQUAL(i + 1U, fixture.starts);
        fixture_run(pauses[i]);
        TEST_ASSERT_EQUAL(i + 2U, fixture.starts);
    }
    TEST_ASSERT_EQUAL(3U, deaths_of(ARM));
    TEST_ASSERT_EQUAL(MODE_NOMINAL, fixture.supervisor.mode);
    fixture_forget();
    fixture_run(30U);
    hang(FIXTURE_ARM);
    fixture_run(12U * SECOND);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
    TEST_ASSERT_EQUAL(3U, fixture.kills);
    TEST_ASSERT_EQUAL(3U, fixture.starts);
    TEST_ASSERT_FALSE(is_under_way(ARM) || is_under_way(HAND));
    const char* const text = fixture_look();
    TEST_ASSERT_EQUAL(1U, fixture_count(text, HUNG "0010"));
    TEST_ASSERT_EQUAL(1U, fixture_count(text, STOPPED "001000000408")); // PUS_FAILURE_LOST, in OFFLINE.
    TEST_ASSERT_EQUAL(0U, fixture_count(text, RETURNED "0010"));
}

// ---- Budget ----

static void repeated_deaths_delay_each_restart_and_then_change_the_mode(void)
{
    link_up(STATE_OPERATIONAL);
    mission_of(ARM)->restart_budget = 3U;
    die(FIXTURE_ARM);
    TEST_ASSERT_EQUAL(1U, fixture.starts); // At once.
    fixture_run(SECOND / 10U);
    die(FIXTURE_ARM);
    fixture_run(8U);
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    fixture_run(4U);
    TEST_ASSERT_EQUAL(2U, fixture.starts); // After 100 ms.
    die(FIXTURE_ARM);
    fixture_run(95U);
    TEST_ASSERT_EQUAL(2U, fixture.starts);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(3U, fixture.starts); // After 1 s.
    TEST_ASSERT_EQUAL(MODE_NOMINAL, fixture.supervisor.mode);
    TEST_ASSERT_TRUE(is_under_way(ARM)); // The earlier state is still known.
    die(FIXTURE_ARM);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
    expect_stopped(ARM, STATE_OFFLINE, PUS_FAILURE_LOST);
    fixture_run(2U * SECOND);
    TEST_ASSERT_EQUAL(3U, fixture.starts);
}

static void after_a_long_life_earlier_deaths_do_not_count(void)
{
    fixture_open_up();
    mission_of(LONE)->restart_budget    = 1U;
    mission_of(LONE)->restart_period_us = 2000000U;
    for (unsigned i = 1U; i <= 3U; i++) {
        die(FIXTURE_LONE);
        fixture_run(2U);
        TEST_ASSERT_EQUAL(i, fixture.starts);
        fixture_run((2U * SECOND) + 1U);
    }
    die(FIXTURE_LONE);
    fixture_run(SECOND);
    die(FIXTURE_LONE); // The life was too short.
    fixture_run(2U * SECOND);
    TEST_ASSERT_EQUAL(4U, fixture.starts);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
}

static void a_process_started_by_a_user_in_the_pause_is_not_started_twice(void)
{
    const uint8_t apid[2] = {0U, LONE};
    fixture_open_up();
    mission_of(LONE)->restart_budget = 3U;
    die(FIXTURE_LONE);
    fixture_run(2U);
    die(FIXTURE_LONE);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_START_PROCESS, apid, sizeof apid);
    fixture_run(2U * SECOND);
    TEST_ASSERT_EQUAL(2U, fixture.starts);
}

static void a_start_by_a_user_in_the_pause_does_not_forget_earlier_deaths(void)
{
    const uint8_t apid[2] = {0U, LONE};
    fixture_open_up();
    mission_of(LONE)->restart_budget    = 3U;
    mission_of(LONE)->restart_period_us = 60000000U;
    for (unsigned i = 0U; i < 2U; i++) {
        die(FIXTURE_LONE);
        fixture_run(2U);
    }
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_START_PROCESS, apid, sizeof apid);
    fixture_run(2U);
    die(FIXTURE_LONE); // Before the time at which the start was due.
    fixture_run(2U);
    TEST_ASSERT_EQUAL(3U, supervisor_registry_find(&fixture.supervisor, LONE)->deaths);
    TEST_ASSERT_EQUAL(2U, fixture.starts);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_network_is_recommissioned_with_its_links);
    RUN_TEST(recommissioning_ends_in_the_state_before_the_death);
    RUN_TEST(a_subsystem_that_was_not_up_stays_down);
    RUN_TEST(no_subsystem_is_recommissioned_unless_the_mission_requires_that);
    RUN_TEST(a_subsystem_without_configuration_returns_to_its_earlier_state);
    RUN_TEST(a_mode_that_forbids_recommissioning_stops_the_running_one);
    RUN_TEST(a_configuration_that_is_not_permitted_stops_recommissioning);
    RUN_TEST(a_member_that_does_not_follow_an_order_stops_recommissioning);
    RUN_TEST(a_new_phase_is_progress);
    RUN_TEST(recommissioning_stops_in_time_when_a_partner_does_not_arrive);
    RUN_TEST(a_refused_link_is_requested_three_times);
    RUN_TEST(a_member_that_fails_again_is_not_recommissioned);
    RUN_TEST(a_member_commanded_down_by_a_user_is_not_recommissioned);
    RUN_TEST(a_member_that_had_failed_before_is_not_recommissioned);
    RUN_TEST(a_member_that_failed_by_the_same_death_is_recommissioned);
    RUN_TEST(no_subsystem_is_recommissioned_at_the_end_of_the_mission);
    RUN_TEST(a_recovery_plan_for_a_recommissioned_subsystem_stops_recommissioning);
    RUN_TEST(the_shutdown_ends_recommissioning);
    RUN_TEST(a_member_that_hangs_during_recommissioning_starts_again);
    RUN_TEST(the_recovery_plan_of_a_hanging_partner_ends_recommissioning);
    RUN_TEST(hangs_during_recommissioning_use_up_the_restart_budget);
    RUN_TEST(repeated_deaths_delay_each_restart_and_then_change_the_mode);
    RUN_TEST(after_a_long_life_earlier_deaths_do_not_count);
    RUN_TEST(a_process_started_by_a_user_in_the_pause_is_not_started_twice);
    RUN_TEST(a_start_by_a_user_in_the_pause_does_not_forget_earlier_deaths);
    return UNITY_END();
}
