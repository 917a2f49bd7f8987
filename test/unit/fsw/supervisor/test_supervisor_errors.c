// SPDX-License-Identifier: Apache-2.0
// Reactions to events by severity, to processes that die and to silent subsystems.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void run_ms(unsigned ms)
{
    fixture_run(ms / 10U);
}

static mission_subsystem_t* mission_of(uint16_t apid)
{
    return (mission_subsystem_t*)supervisor_registry_find(&fixture.supervisor, apid)->mission;
}

static uint64_t timeout_of(uint16_t apid)
{
    return (uint64_t)mission_of(apid)->hang_after_us * 1000U;
}

// ---- Events of severity HIGH ----

static void a_high_error_shuts_the_network_down_in_the_same_step(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    // HAND gets an order; ARM goes down without one; LONE is not in the network. The events report that
    // network 16 was shut down because of 16, and that its plan has started.
    fixture_expect("G/16 5.4 0005\nG 5.1 000300100010\nG 5.1 000600100005\n17 TC 129.8 0602 from 8001\n");
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    run_ms(490);
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    fixture_forget();
    run_ms(30);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 0003 from 8001"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0003 from 8001"));
    TEST_ASSERT_FALSE(fixture_has("18 TC"));
    fixture_forget();
    run_ms(1000); // The reaction does not occur again.
    TEST_ASSERT_FALSE(fixture_has("16 TC 129"));
    TEST_ASSERT_FALSE(fixture_has("17 TC 129"));
}

/// If the report of an event is disabled by TC[5,6], the member sends a notice instead.
static void notice(unsigned member, uint8_t severity, uint16_t event)
{
    const pus_event_notice_t content = {.event = event, .severity = severity};
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pus_event_notice_report(&fixture.members[member].process, &content, fixture.now_ns));
}

static void an_event_about_a_message_has_the_time_of_the_step_that_reads_it(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.now_ns += FIXTURE_TICK_NS / 2U; // A message wakes the supervisor between two ticks.
    notice(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G 5.1 000600100005"));
    TEST_ASSERT_UINT64_WITHIN(1000U, fixture.now_ns, fixture.event_ns);
}

static void an_event_whose_report_is_disabled_has_the_same_reaction(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    notice(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    // The event is not reported to the ground.
    fixture_expect("G 5.1 000300100010\nG 5.1 000600100005\n17 TC 129.8 0602 from 8001\n");
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.plans_started);
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    run_ms(520);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 0003 from 8001"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0003 from 8001"));
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_forget();
    notice(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 0401 from 8001"));
    fixture_forget();
    notice(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE);
    notice(FIXTURE_ARM, 9U, GRIPLESS); // 9 is not a severity.
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
}

static void one_failure_has_one_plan(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    // HAND belongs to the plan run of the other failure.
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.plans_started);
    run_ms(700);
    // After the end of that run, the next failure has a run of its own.
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.counters.plans_started);
}

static void failures_of_separate_networks_have_separate_plans(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_LONE, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_event(FIXTURE_LONE, PUS_SEVERITY_HIGH, BROKEN);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.counters.plans_started);
    run_ms(600);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 00"));
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.8 00"));
}

static void a_partner_in_error_or_lost_receives_no_second_order(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("17 TC 129.8 06"));
    run_ms(700);
    tearDown();
    setUp();
    fixture_link_up(STATE_OPERATIONAL);
    fixture.start_result                     = STATUS_NOT_FOUND;
    fixture.members[FIXTURE_HAND].is_running = false;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    run_ms(700);
    TEST_ASSERT_EQUAL(PROCESS_LOST, fixture.supervisor.registry[1].process);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 00"));
}

static void a_plan_of_the_mission_replaces_the_built_in_one(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("G 131.2 010003")); // NOMINAL to SAFE, cause plan.
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    run_ms(170);
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    run_ms(40);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 00"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 00"));
}

static void a_plan_that_only_logs_has_no_other_effect(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, BROKEN);
    run_ms(1000);
    fixture_expect("G/16 5.4 0001\nG 5.1 000600100001\n");
}

static void a_subsystem_without_links_goes_down_alone(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_LONE, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_LONE, PUS_SEVERITY_HIGH, BROKEN);
    run_ms(700);
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.8 0003 from 8001"));
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    TEST_ASSERT_FALSE(fixture_has("G 5.1 0003"));
}

// ---- Events of lower severity ----

static void a_medium_error_takes_the_subsystem_to_safe_operational_in_the_same_step(void)
{
    static const uint16_t events[] = {STRAIN, TIRED}; // The first has a plan, the second has none.
    for (unsigned i = 0U; i < 2U; i++) {
        fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
        fixture_forget();
        fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, events[i]);
        fixture_step();
        // The cause is the plan or the error of the subsystem.
        TEST_ASSERT_TRUE(
            fixture_has((i == 0U) ? "16 TC 129.8 0403 from 8001" : "16 TC 129.8 0401 from 8001"));
        TEST_ASSERT_FALSE(fixture_has("17 TC"));
        fixture_run(2U);
        TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    }
}

static void a_medium_error_never_orders_a_higher_state(void)
{
    static const state_t states[]  = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                                      STATE_ERROR_OPERATIONAL};
    static const uint16_t events[] = {STRAIN, TIRED};
    for (unsigned i = 0U; i < 4U; i++) {
        for (unsigned k = 0U; k < 2U; k++) {
            fixture_put_in_state(FIXTURE_ARM, states[i]);
            fixture_forget();
            fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, events[k]);
            fixture_run(3U);
            TEST_ASSERT_FALSE_MESSAGE(fixture_has("16 TC"), "an order for a higher state");
        }
    }
}

/// The plan of LONE's STRAIN orders LONE to ERROR_OPERATIONAL, unless it is there or in OFFLINE.
static void a_plan_may_order_a_member_to_error_operational(void)
{
    static const state_t states[] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_OPERATIONAL,
                                     STATE_ERROR_OPERATIONAL};
    for (unsigned i = 0U; i < 4U; i++) {
        fixture_put_in_state(FIXTURE_LONE, states[i]);
        fixture_forget();
        fixture_event(FIXTURE_LONE, PUS_SEVERITY_MEDIUM, STRAIN);
        fixture_run(2U);
        TEST_ASSERT_EQUAL((i == 1U) || (i == 2U), fixture_has("18 TC 129.8 0603 from 8001"));
    }
}

static void low_and_informative_events_are_only_logged(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_INFORMATIVE, NOTE);
    run_ms(1000);
    fixture_expect("G/16 5.2 0004\nG/16 5.1 0004\n");
}

/// The supervisor reacts to a failure that it has detected itself when it detects it, not to its own report.
static void only_events_of_other_subsystems_of_the_mission_have_a_reaction(void)
{
    static const uint16_t others[] = {SUPERVISOR_APID, 99U};
    fixture_link_up(STATE_OPERATIONAL);
    for (size_t i = 0U; i < 2U; i++) {
        const pus_event_occurrence_t high = {.apid = others[i], .severity = 4U, .event = BROKEN};
        supervisor_error_event(&fixture.supervisor, &high);
        run_ms(100);
        fixture_expect("");
    }
}

static void an_event_without_a_number_is_ignored(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_EVENTS, 4U, "\1", 1U);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_EVENTS, 8U, "\0\0", 2U);
    run_ms(1000);
    fixture_expect("G/16 5.4 01\nG/16 5.8 0000\n");
}

// ---- Processes ----

static void a_process_that_dies_is_started_again(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_step();
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 5.4 00010010")); // PROCESS_LOST.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.restarts);
    TEST_ASSERT_TRUE(fixture.members[FIXTURE_ARM].is_running);
    run_ms(600); // The built-in plan runs, and not that of ARM's own event number 1.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 00"));
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 17.1"));
    TEST_ASSERT_EQUAL(MODE_NOMINAL, fixture.supervisor.mode);
}

/// The process is killed 20 ms after the promised step (hangAfter of the mission) and not earlier; its
/// restart takes the boot time.
static void a_process_that_hangs_is_killed_and_started_again(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.late_apid  = ARM;
    fixture.promise_ns = fixture.supervisor.now_ns;
    run_ms(20);
    TEST_ASSERT_EQUAL(0U, fixture.kills);
    fixture_tick();
    TEST_ASSERT_EQUAL(1U, fixture.kills);
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_EQUAL_UINT64(50000000U, fixture.boot_ns);
    TEST_ASSERT_EQUAL_UINT32(fixture.supervisor.link_epoch, fixture.link_floor);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 5.4 001E0010")); // PROCESS_HUNG; PROCESS_LOST is not raised in addition.
    TEST_ASSERT_FALSE(fixture_has("G 5.4 00010010"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
}

/// At its next check, the supervisor finds a process that is `by_ns` later than its mission allows.
static void see_late(uint16_t apid, uint64_t by_ns)
{
    fixture_tick();
    fixture.late_apid  = apid;
    fixture.promise_ns = fixture.now_ns - timeout_of(apid) - by_ns;
    fixture_step();
}

/// The supervisor does not react to a process that is repeatedly exactly as late as its mission allows.
static void a_process_that_is_slow_within_its_time_is_not_killed(void)
{
    const uint64_t timeout_ns = timeout_of(ARM);
    fixture_link_up(STATE_OPERATIONAL);
    fixture.late_apid = ARM;
    for (unsigned i = 0U; i < 50U; i++) {
        fixture.promise_ns = fixture.now_ns;
        // The process makes no step. The supervisor also checks it at the last permitted instant.
        fixture_run((unsigned)(timeout_ns / FIXTURE_TICK_NS));
        fixture_step();
        TEST_ASSERT_EQUAL_UINT64(timeout_ns, fixture.supervisor.now_ns - fixture.promise_ns);
    }
    TEST_ASSERT_EQUAL(0U, fixture.kills);
    TEST_ASSERT_EQUAL(0U, fixture.starts);
    TEST_ASSERT_EQUAL(0U, supervisor_registry_find(&fixture.supervisor, ARM)->deaths);
    TEST_ASSERT_FALSE(fixture_has("G 5.4 "));
    TEST_ASSERT_FALSE(fixture_has("TC 129.8"));
    see_late(ARM, 1U); // One nanosecond above the limit.
    TEST_ASSERT_EQUAL(1U, fixture.kills);
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 5.4 001E0010")); // PROCESS_HUNG.
}

/// The promise of the killed life is still stored while the next life waits for its start: there must be no
/// second reaction.
static void a_repeated_detection_of_a_hang_has_one_reaction(void)
{
    mission_of(LONE)->restart_budget = 2U;
    static const unsigned started[]  = {1U, 1U, 2U, 2U}; // Starts at once and after 100 ms, then none.
    for (unsigned hang = 1U; hang <= 3U; hang++) {
        see_late(LONE, 1U);
        TEST_ASSERT_EQUAL(hang, fixture.kills);
        TEST_ASSERT_EQUAL(started[hang - 1U], fixture.starts);
        for (unsigned i = 0U; i < 8U; i++) {
            fixture_tick();
            fixture_step(); // Two checks at one instant.
        }
        TEST_ASSERT_EQUAL(hang, fixture.kills);
        TEST_ASSERT_EQUAL(started[hang - 1U], fixture.starts);
        run_ms((hang < 3U) ? 200U : 2000U);
        TEST_ASSERT_EQUAL(hang, fixture.kills);
        TEST_ASSERT_EQUAL(started[hang], fixture.starts);
        const char* const text = fixture_look();
        TEST_ASSERT_EQUAL(1U, fixture_count(text, "G 5.4 001E0012")); // PROCESS_HUNG.
        TEST_ASSERT_EQUAL(0U, fixture_count(text, "G 5.4 00010012")); // PROCESS_LOST.
        TEST_ASSERT_EQUAL((hang < 3U) ? 0U : 1U, fixture_count(text, "G 131.2 01"));
        fixture_forget();
    }
    TEST_ASSERT_EQUAL(2U, supervisor_registry_find(&fixture.supervisor, LONE)->deaths);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
}

/// A request that is sent earlier could reach the former life and would then never be answered.
static void nothing_is_sent_to_a_restarted_process_before_it_is_heard(void)
{
    fixture.members[FIXTURE_LONE].is_silent  = true;
    fixture.members[FIXTURE_LONE].is_running = false;
    fixture_tick();
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    fixture.members[FIXTURE_LONE].heartbeats = 0U;
    fixture_forget();
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    run_ms(1500);
    TEST_ASSERT_TRUE(fixture_has("G 1.10 #0 0002"));
    TEST_ASSERT_EQUAL(0U, fixture.members[FIXTURE_LONE].heartbeats);
    fixture.members[FIXTURE_LONE].is_silent = false;
    fixture_put_in_state(FIXTURE_LONE, STATE_OFFLINE);
    fixture_run(2U);
    fixture_forget();
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    run_ms(1500);
    TEST_ASSERT_TRUE(fixture_has("18 TC 17.1"));
    TEST_ASSERT_TRUE(fixture.members[FIXTURE_LONE].heartbeats > 0U);
}

static void a_restart_budget_that_is_used_up_leads_to_mode_safe(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        fixture.members[FIXTURE_LONE].is_running = false; // LONE may be restarted once.
        run_ms(1000);
        TEST_ASSERT_EQUAL((i == 0U) ? MODE_NOMINAL : MODE_SAFE, fixture.supervisor.mode);
    }
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_TRUE(fixture_has("G 131.2 010001")); // Cause: error.
    fixture_forget();
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    run_ms(5000);
    TEST_ASSERT_TRUE(fixture_has("G 1.10 #0 0002 12"));
    TEST_ASSERT_FALSE(fixture_has("G 5.4")); // The silence is not reported repeatedly.
    TEST_ASSERT_EQUAL(1U, fixture.starts);
}

static void a_start_that_fails_leads_to_mode_safe(void)
{
    fixture.start_result                     = STATUS_NOT_FOUND;
    fixture.members[FIXTURE_LONE].is_running = false;
    run_ms(100);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
    TEST_ASSERT_EQUAL(PROCESS_LOST, fixture.supervisor.registry[2].process);
}

static void communication_is_started_again_without_a_command(void)
{
    fixture.members[FIXTURE_GROUND].is_running = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G/16 1.7"));
}

static void silence_is_an_error(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_silent = true;
    run_ms(2900);
    fixture_expect("");
    run_ms(400);
    TEST_ASSERT_TRUE(fixture_has("G 5.4 00020010")); // SUBSYSTEM_SILENT.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode); // The plan for the supervisor's own event.
    TEST_ASSERT_FALSE(fixture_has("17 TC 129.8 00"));
    fixture_forget();
    run_ms(2500);
    TEST_ASSERT_FALSE(fixture_has("G 5.4"));
    run_ms(1500); // The silence is reported again after the same time.
    TEST_ASSERT_TRUE(fixture_has("G 5.4 00020010"));
}

static void a_subsystem_that_reports_is_not_silent(void)
{
    run_ms(20000);
    fixture_expect("");
}

static void random_errors_leave_the_supervisor_consistent(void)
{
    uint32_t random = 3U;
    for (unsigned i = 0U; i < 3000U; i++) {
        random                = (random * 1664525U) + 1013904223U;
        const uint32_t chance = (random >> 10U) % 12U;
        const unsigned member = FIXTURE_ARM + ((random >> 16U) % 3U);
        if (!fixture.members[member].is_running) {
            // The process is dead: the supervisor decides whether to restart it.
        } else if (chance < 4U) {
            fixture_event(member, (uint8_t)(chance + 1U), (uint16_t)((random >> 20U) % 6U));
        } else if (chance == 5U) {
            fixture.members[member].is_running = ((random >> 24U) % 16U) != 0U;
        } else if (chance == 6U) {
            fixture_put_in_state(member, (state_t)((random >> 22U) % 7U));
        } else if (chance == 7U) {
            (void)fixture_request_link((uint16_t)(1U + ((random >> 22U) % 2U)));
        } else if (chance == 8U) {
            (void)fixture_open_link((uint16_t)(1U + ((random >> 22U) % 2U)));
        } else {
            (void)fixture_request_state(fixture.members[member].apid, (state_t)((random >> 22U) % 7U));
        }
        fixture_tick();
        fixture_forget();
    }
    run_ms(3000);
    for (unsigned i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        TEST_ASSERT_EQUAL(SESSION_FREE, fixture.supervisor.sessions[i].step);
    }
    for (unsigned i = 0U; i < PLAN_RUNS; i++) {
        TEST_ASSERT_EQUAL(0U, fixture.supervisor.plans.runs[i].member_count);
    }
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.pending.count);
}

/// The event reports that a network was shut down: for each new failure, and if an order was sent. A network
/// of one member is not reported.
static void a_shutdown_of_a_network_is_reported_once_for_each_failure_or_order(void)
{
    static const char shut_down[] = "G 5.1 000300100010";
    fixture_event(FIXTURE_LONE, PUS_SEVERITY_HIGH, BROKEN); // LONE has no links.
    fixture_step();
    TEST_ASSERT_FALSE(fixture_has("G 5.1 0003"));
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS); // A new failure; HAND needs no order.
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(shut_down));
    TEST_ASSERT_FALSE(fixture_has("17 TC 129.8"));
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS); // The same failure without an order.
    fixture_step();
    TEST_ASSERT_FALSE(fixture_has(shut_down));
    fixture_put_in_state(FIXTURE_HAND, STATE_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS); // The same failure with an order.
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(shut_down));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
}

/// An order without an answer stands for one second: until then, further events do not repeat it.
static void an_order_without_an_answer_is_repeated_after_a_second(void)
{
    const registry_entry_t* const arm = supervisor_registry_find(&fixture.supervisor, ARM);
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_passive = true;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 04"));
    fixture_forget();
    const uint64_t ordered_ns = arm->order.time_ns;
    fixture.now_ns            = ordered_ns + 999999999U;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_step();
    TEST_ASSERT_EQUAL_UINT64(ordered_ns + 999999999U, fixture.supervisor.now_ns);
    TEST_ASSERT_FALSE(fixture_has("16 TC 129.8"));
    fixture.now_ns = ordered_ns + 1000000000U;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 04"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_high_error_shuts_the_network_down_in_the_same_step);
    RUN_TEST(an_event_about_a_message_has_the_time_of_the_step_that_reads_it);
    RUN_TEST(an_event_whose_report_is_disabled_has_the_same_reaction);
    RUN_TEST(one_failure_has_one_plan);
    RUN_TEST(failures_of_separate_networks_have_separate_plans);
    RUN_TEST(a_partner_in_error_or_lost_receives_no_second_order);
    RUN_TEST(a_plan_of_the_mission_replaces_the_built_in_one);
    RUN_TEST(a_plan_that_only_logs_has_no_other_effect);
    RUN_TEST(a_subsystem_without_links_goes_down_alone);
    RUN_TEST(a_medium_error_takes_the_subsystem_to_safe_operational_in_the_same_step);
    RUN_TEST(a_medium_error_never_orders_a_higher_state);
    RUN_TEST(a_plan_may_order_a_member_to_error_operational);
    RUN_TEST(low_and_informative_events_are_only_logged);
    RUN_TEST(only_events_of_other_subsystems_of_the_mission_have_a_reaction);
    RUN_TEST(an_event_without_a_number_is_ignored);
    RUN_TEST(a_process_that_dies_is_started_again);
    RUN_TEST(a_process_that_hangs_is_killed_and_started_again);
    RUN_TEST(a_process_that_is_slow_within_its_time_is_not_killed);
    RUN_TEST(a_repeated_detection_of_a_hang_has_one_reaction);
    RUN_TEST(nothing_is_sent_to_a_restarted_process_before_it_is_heard);
    RUN_TEST(a_restart_budget_that_is_used_up_leads_to_mode_safe);
    RUN_TEST(a_start_that_fails_leads_to_mode_safe);
    RUN_TEST(communication_is_started_again_without_a_command);
    RUN_TEST(silence_is_an_error);
    RUN_TEST(a_subsystem_that_reports_is_not_silent);
    RUN_TEST(random_errors_leave_the_supervisor_consistent);
    RUN_TEST(an_order_without_an_answer_is_repeated_after_a_second);
    RUN_TEST(a_shutdown_of_a_network_is_reported_once_for_each_failure_or_order);
    return UNITY_END();
}
