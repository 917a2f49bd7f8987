// SPDX-License-Identifier: Apache-2.0
// Reactions of the supervisor to two failures, one after the other, in each order: a running plan does not
// suppress the built-in reaction. Also failures during the shutdown, and events of the supervisor itself.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

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

typedef struct {
    const char* name;
    unsigned member;
    uint8_t severity;
    uint16_t event;
} failure_t;

static const failure_t failures[] = {
    {"TIRED, MEDIUM, no plan", FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED},
    {"STRAIN, MEDIUM, a plan of one action", FIXTURE_ARM, PUS_SEVERITY_MEDIUM, STRAIN},
    {"TORQUE, MEDIUM, a plan of 20 s", FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TORQUE},
    {"HAND's STRAIN, MEDIUM, no plan", FIXTURE_HAND, PUS_SEVERITY_MEDIUM, STRAIN},
    {"WORN, LOW, a plan of 0.1 s", FIXTURE_ARM, PUS_SEVERITY_LOW, WORN},
    {"GRIPLESS, HIGH, no plan", FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS},
    {"BROKEN, HIGH, a plan that logs", FIXTURE_ARM, PUS_SEVERITY_HIGH, BROKEN},
    {"JAMMED, HIGH, a plan of 30 s", FIXTURE_ARM, PUS_SEVERITY_HIGH, JAMMED},
    {"HAND's BROKEN, HIGH, a plan of 0.2 s", FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN},
};

#define FAILURES (sizeof failures / sizeof failures[0])

/// Act as a failed subsystem: after a HIGH event it is in ERROR_OPERATIONAL before it reports the event.
static void fail(const failure_t* failure)
{
    if (failure->severity == PUS_SEVERITY_HIGH) {
        fixture_put_in_state(failure->member, STATE_ERROR_OPERATIONAL);
    }
    fixture_event(failure->member, failure->severity, failure->event);
    fixture_step();
    fixture_step(); // The members answer.
}

/// Put both members into OPERATIONAL again, as after commands of the operator.
static void bring_back_up(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_OPERATIONAL);
    fixture_forget();
}

static void check(const failure_t* failure, const char* text)
{
    const unsigned other = (failure->member == FIXTURE_ARM) ? FIXTURE_HAND : FIXTURE_ARM;
    if (failure->severity == PUS_SEVERITY_HIGH) {
        TEST_ASSERT_EQUAL_MESSAGE(STATE_ERROR_OPERATIONAL, fixture.members[other].state, text);
    } else if (failure->severity == PUS_SEVERITY_MEDIUM) {
        TEST_ASSERT_EQUAL_MESSAGE(STATE_SAFE_OPERATIONAL, fixture.members[failure->member].state, text);
    } else {
        // The built-in reaction does not apply.
    }
}

static void a_running_plan_does_not_suppress_a_reaction(void)
{
    static const unsigned phases_ms[] = {0U, 50U, 300U, 1000U, 19900U};
    for (unsigned i = 0U; i < (FAILURES * FAILURES * 5U); i++) {
        const failure_t* const first  = &failures[i % FAILURES];
        const failure_t* const second = &failures[(i / FAILURES) % FAILURES];
        const unsigned phase_ms       = phases_ms[i / (FAILURES * FAILURES)];
        char text[160];
        (void)snprintf(text, sizeof text, "%s, %u ms later %s", first->name, phase_ms, second->name);
        tearDown();
        setUp();
        fixture_link_up(STATE_OPERATIONAL);
        fail(first);
        check(first, text);
        run_ms(phase_ms);
        bring_back_up();
        fail(second);
        check(second, text);
        if (second->severity == PUS_SEVERITY_HIGH) {
            run_ms(2100U);
            const bool is_log_only = (second->event == BROKEN) && (second->member == FIXTURE_ARM);
            // The plan of a HIGH event takes both members to OFFLINE, except the plan that only logs. If the
            // first failure was HIGH, too, its plan may still run, and the second failure joins this plan.
            if (!is_log_only && (first->severity < PUS_SEVERITY_HIGH)) {
                TEST_ASSERT_EQUAL_MESSAGE(STATE_OFFLINE, fixture.members[FIXTURE_ARM].state, text);
                TEST_ASSERT_EQUAL_MESSAGE(STATE_OFFLINE, fixture.members[FIXTURE_HAND].state, text);
            }
        }
    }
}

static void a_high_error_ends_a_medium_plan(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TORQUE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 0403 from 8001"));
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    // Events of the supervisor: NETWORK_SHUT_DOWN (network 16, by ARM), PLAN_OVERRULED (TORQUE by GRIPLESS),
    // PLAN_STARTED (GRIPLESS). HAND is ordered to ERROR_OPERATIONAL.
    fixture_expect("G/16 5.4 0005\nG 5.1 000300100010\nG 5.1 00130010000600100005\nG 5.1 000600100005\n"
                   "17 TC 129.8 0602 from 8001\n");
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.reactions.overruled);
    run_ms(600);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0003 from 8001"));
    fixture_forget();
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    run_ms(25000); // The plan of 20 s has no effect any more.
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
}

static void a_medium_error_during_a_high_plan_starts_no_plan(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, JAMMED);
    fixture_run(2U);
    fixture_put_in_state(FIXTURE_HAND, STATE_OPERATIONAL);
    fixture_forget();
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_MEDIUM, STRAIN);
    fixture_run(2U);
    // No plan applies: only the built-in reaction follows, the order to enter SAFE_OPERATIONAL.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0401 from 8001"));
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TORQUE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 5.1 00130010000600100007")); // PLAN_OVERRULED.
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.plans_started);
}

static void a_failure_of_the_same_severity_joins_the_plan(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, JAMMED);
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.plans_started);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.reactions.joined);
}

static void an_order_is_repeated_only_if_it_was_not_answered_for_a_second(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_passive = true;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 04"));
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    run_ms(500);
    TEST_ASSERT_FALSE(fixture_has("16 TC 129.8 04"));
    run_ms(600); // An order without an answer for more than a second may have been lost.
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 04"));
    fixture_forget();
    // An order to a safer state is sent at once, and makes the first order unnecessary.
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 06"));
    TEST_ASSERT_FALSE(fixture_has("16 TC 129.8 04"));
}

static void a_pending_order_is_not_replaced_by_one_of_lower_severity(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_fill(FIXTURE_ARM);
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_HIGH, BROKEN);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture.supervisor.registry[0].is_order_pending);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, fixture.supervisor.registry[0].ordered);
}

static void an_error_during_the_shutdown_still_secures_the_network(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].is_passive = true;
    fixture.members[FIXTURE_ARM].is_passive  = true;
    fixture.is_stop_requested                = true;
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 04"));
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TORQUE);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, WORN);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.counters.plans_started);
    run_ms(3100); // Then all members are ordered to OFFLINE, and nothing interrupts this.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 00"));
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, TIRED);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
}

// ---- Events of the supervisor itself ----

static void break_the_log(void)
{
    static const uint8_t sqlite[1] = {PACKET_LOG_SQLITE};
    char path[160];
    (void)snprintf(path, sizeof path, "%s/packets.spool", fixture_directory());
    TEST_ASSERT_EQUAL(0, symlink("/dev/full", path));
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SELECT_LOG, sqlite, 1U);
    fixture_run(100U);
}

static void the_supervisors_own_errors_have_plans(void)
{
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture_forget();
    break_the_log();
    run_ms(300);
    TEST_ASSERT_TRUE(fixture_has("G 5.4 000801"));       // LOG_FAILED.
    TEST_ASSERT_TRUE(fixture_has("G 5.1 000600010008")); // PLAN_STARTED: only the supervisor takes part.
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.8 0003 from 8001"));
    // LOG_FAILED names no subsystem, so the action of its plan on SELF has no effect.
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    TEST_ASSERT_FALSE(fixture_has("G 5.1 0003"));
}

static void a_disabled_report_does_not_disable_the_recovery_plan(void)
{
    static const uint8_t log_failed[3] = {1U, 0U, 8U};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_EVENTS, 6U, log_failed, sizeof log_failed);
    fixture_run(2U);
    break_the_log();
    run_ms(300);
    TEST_ASSERT_FALSE(fixture_has("G 5.4"));
    TEST_ASSERT_TRUE(fixture_has("G 5.1 000600010008"));
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
}

/// Give an event of the supervisor the severity HIGH.
static void set_severity_high(uint16_t event)
{
    subsystem_t* const subsystem = &fixture.supervisor.subsystem;
    for (uint16_t i = 0U; i < subsystem->descriptor->event_count; i++) {
        if (subsystem->event_definitions[i].id == event) {
            subsystem->event_definitions[i].severity = PUS_SEVERITY_HIGH;
        }
    }
}

static void an_event_of_the_supervisor_concerns_the_subsystem_named_in_its_descriptor(void)
{
    static const uint8_t of_hand[2] = {0U, HAND};
    static const uint8_t unknown[2] = {0U, 99U};
    fixture_link_up(STATE_OPERATIONAL);
    set_severity_high(SUPERVISOR_EVENT_RESOURCE_REFUSED); // {APID}
    // {PREVIOUS, MODE}: neither value is an APID, although the number could be one.
    set_severity_high(SUPERVISOR_EVENT_MODE_CHANGED);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_RESOURCE_REFUSED, unknown, 2U);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_MODE_CHANGED, of_hand, 2U);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("17 TC 129.8"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.counters.plans_started);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_RESOURCE_REFUSED, of_hand, 2U);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_RESOURCE_REFUSED, of_hand, 2U);
    fixture_run(2U);
    // This subsystem has not failed, so it is secured by an order, too.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 06"));
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.counters.plans_started);
}

/// An event of the supervisor is recorded once in a step; an event without a slot is counted.
static void an_own_event_is_recorded_once_and_counted_as_missed_if_no_slot_is_free(void)
{
    supervisor_t* const supervisor          = &fixture.supervisor;
    const uint8_t octets[3]                 = {0U, (uint8_t)SUPERVISOR_EVENT_LOG_FAILED, 0U};
    const pus_tm_t tm                       = {.apid    = SUPERVISOR_APID,
                                               .service = PUS_SERVICE_EVENTS,
                                               .subtype = 4U,
                                               .data    = octets,
                                               .size    = sizeof octets};
    const pus_event_occurrence_t occurrence = {
        .apid = SUPERVISOR_APID, .event = SUPERVISOR_EVENT_LOG_FAILED, .severity = PUS_SEVERITY_HIGH};
    TEST_ASSERT_EQUAL(0U, supervisor->own_event_count);
    supervisor_error_own_event(supervisor, &tm, &occurrence);
    supervisor_error_own_event(supervisor, &tm, &occurrence);
    TEST_ASSERT_EQUAL(1U, supervisor->own_event_count);
    TEST_ASSERT_EQUAL_UINT32(0U, supervisor->reactions.missed);
    for (uint16_t k = 0U; k < SUPERVISOR_OWN_EVENTS; k++) {
        supervisor->own_events[k].event_id = (uint16_t)(1000U + k);
    }
    supervisor->own_event_count = SUPERVISOR_OWN_EVENTS - 1U;
    supervisor_error_own_event(supervisor, &tm, &occurrence); // The last slot.
    TEST_ASSERT_EQUAL(SUPERVISOR_OWN_EVENTS, supervisor->own_event_count);
    supervisor->own_events[SUPERVISOR_OWN_EVENTS - 1U].event_id = 2000U;
    supervisor_error_own_event(supervisor, &tm, &occurrence);
    TEST_ASSERT_EQUAL(SUPERVISOR_OWN_EVENTS, supervisor->own_event_count);
    TEST_ASSERT_EQUAL_UINT32(1U, supervisor->reactions.missed);
    supervisor->own_event_count = 0U;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_running_plan_does_not_suppress_a_reaction);
    RUN_TEST(a_high_error_ends_a_medium_plan);
    RUN_TEST(a_medium_error_during_a_high_plan_starts_no_plan);
    RUN_TEST(a_failure_of_the_same_severity_joins_the_plan);
    RUN_TEST(an_order_is_repeated_only_if_it_was_not_answered_for_a_second);
    RUN_TEST(a_pending_order_is_not_replaced_by_one_of_lower_severity);
    RUN_TEST(an_error_during_the_shutdown_still_secures_the_network);
    RUN_TEST(the_supervisors_own_errors_have_plans);
    RUN_TEST(a_disabled_report_does_not_disable_the_recovery_plan);
    RUN_TEST(an_event_of_the_supervisor_concerns_the_subsystem_named_in_its_descriptor);
    RUN_TEST(an_own_event_is_recorded_once_and_counted_as_missed_if_no_slot_is_free);
    return UNITY_END();
}
