// SPDX-License-Identifier: Apache-2.0
// Conditions of permission, recovery and the handshake of links that never change in the missions of the
// other tests. Here each of them alone decides the result (make mcdc).
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define UNKNOWN 99U
#define STATUS_ROW 52U // Octets of one link in TM[130,9].
#define ANSWER_TICKS 5U
#define SESSION_TICKS 205U

static mission_descriptor_t* mission(void)
{
    return (mission_descriptor_t*)(uintptr_t)fixture.supervisor.mission; // Static storage of the fixture.
}

static registry_entry_t* entry_of(const uint16_t apid)
{
    registry_entry_t* const entry = supervisor_registry_find(&fixture.supervisor, apid);
    TEST_ASSERT_NOT_NULL(entry);
    return entry;
}

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close(); // The next setUp loads the mission again.
}

// ---- Permission ----

static uint16_t refusal_of(const uint16_t apid, const uint8_t state)
{
    const pus_tc_t tc = {.apid    = apid,
                         .service = PUS_SERVICE_MANAGEMENT,
                         .subtype = PUS_MANAGEMENT_REQUEST_STATE,
                         .data    = &state,
                         .size    = 1U};
    return supervisor_permission_of(&fixture.supervisor, &tc).code;
}

static void a_doubtful_state_matters_only_if_it_forbids_the_transition(void)
{
    fixture_link_up(STATE_SAFE_OPERATIONAL);
    entry_of(HAND)->doubt = DOUBT_SILENT;
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, STATE_OFFLINE));
    entry_of(HAND)->state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(PUS_FAILURE_STATE_IN_DOUBT, refusal_of(ARM, STATE_OFFLINE));
    entry_of(HAND)->doubt = DOUBT_NONE;
    TEST_ASSERT_EQUAL(PUS_FAILURE_MEMBER_ACTIVE, refusal_of(ARM, STATE_OFFLINE));
}

static void any_doubt_about_a_member_forbids_the_transition_to_operational(void)
{
    fixture_link_up(STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, STATE_OPERATIONAL));
    entry_of(HAND)->doubt = DOUBT_SILENT;
    TEST_ASSERT_EQUAL(PUS_FAILURE_STATE_IN_DOUBT, refusal_of(ARM, STATE_OPERATIONAL));
}

static void without_a_power_limit_no_request_is_refused_for_power(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_OFFLINE);
    mission()->power_available_w = 1U;
    TEST_ASSERT_EQUAL(PUS_FAILURE_RESOURCES, refusal_of(ARM, STATE_PRE_OPERATIONAL));
    mission()->power_available_w = 0U;
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, STATE_PRE_OPERATIONAL));
}

/// A mission may permit any state: the target itself refuses those that cannot be requested.
static void requests_for_impossible_states_are_passed_to_the_target(void)
{
    mission()->storage.rules[0].is_any = true;
    mission()->storage.rules[0].modes  = UINT8_MAX;
    mission()->storage.rules[0].states = UINT16_MAX;
    fixture_put_in_state(FIXTURE_ARM, STATE_OFFLINE);
    mission()->power_available_w = 1U;
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, 77U));
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, STATE_ERROR_OPERATIONAL));
    TEST_ASSERT_EQUAL(PUS_FAILURE_RESOURCES, refusal_of(ARM, STATE_PRE_OPERATIONAL));
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    entry_of(ARM)->doubt = DOUBT_SILENT; // A request for a higher state would be refused.
    TEST_ASSERT_EQUAL(PUS_FAILURE_NONE, refusal_of(ARM, STATE_POST_OPERATIONAL));
    entry_of(ARM)->state = STATE_OFFLINE;
    TEST_ASSERT_EQUAL(PUS_FAILURE_STATE_IN_DOUBT, refusal_of(ARM, STATE_POST_OPERATIONAL));
}

// ---- Registry ----

static void a_report_that_is_too_short_changes_no_state(void)
{
    static const uint8_t pre_operational[] = {STATE_PRE_OPERATIONAL};
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_TRANSITION, pre_operational, 1U);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_STATUS, pre_operational, 1U);
    fixture_step();
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, entry_of(ARM)->state);
}

// ---- Recovery ----

static void occur_event(const uint16_t apid, const uint8_t severity, const uint16_t event)
{
    const pus_event_occurrence_t occurrence = {.apid = apid, .event = event, .severity = severity};
    supervisor_error_event(&fixture.supervisor, &occurrence);
}

/// Returns the state to which ARM is ordered after the reaction to `event`, if the order `open` was waiting
/// to be sent.
static state_t ordered_state_after(const state_t open, const uint16_t event)
{
    registry_entry_t* const arm = entry_of(ARM);
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    arm->is_order_pending = true;
    arm->ordered          = open;
    occur_event(ARM, PUS_SEVERITY_MEDIUM, event);
    return arm->ordered;
}

static void a_waiting_order_for_a_lower_state_is_not_replaced(void)
{
    TEST_ASSERT_EQUAL(STATE_OFFLINE, ordered_state_after(STATE_OFFLINE, TIRED));
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, ordered_state_after(STATE_PRE_OPERATIONAL, TIRED));
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, ordered_state_after(STATE_SAFE_OPERATIONAL, TIRED));
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, ordered_state_after(STATE_ERROR_OPERATIONAL, TIRED));
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, ordered_state_after(STATE_OPERATIONAL, TIRED));
    const mission_plan_t* const plan =
        descriptor_mission_find_plan(mission(), DESCRIPTOR_MEDIUM, ARM, STRAIN);
    TEST_ASSERT_NOT_NULL(plan);
    mission()->storage.actions[plan->first_action].state = STATE_PRE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATE_OFFLINE, ordered_state_after(STATE_OFFLINE, STRAIN));
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, ordered_state_after(STATE_PRE_OPERATIONAL, STRAIN));
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, ordered_state_after(STATE_SAFE_OPERATIONAL, STRAIN));
}

static void the_loss_of_a_process_outside_of_the_mission_orders_nothing(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_forget();
    supervisor_error_member_lost(&fixture.supervisor, UNKNOWN, SUPERVISOR_EVENT_PROCESS_LOST);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("TC 129.8"));
    supervisor_error_member_lost(&fixture.supervisor, ARM, SUPERVISOR_EVENT_PROCESS_LOST);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8"));
}

static unsigned plans_started_by(const uint16_t event, const uint16_t subject)
{
    const unsigned before              = fixture.supervisor.counters.plans_started;
    fixture.supervisor.own_events[0]   = (own_event_t){event, PUS_SEVERITY_HIGH, subject};
    fixture.supervisor.own_event_count = 1U;
    fixture.supervisor.plans           = (plan_runner_t){0};
    supervisor_error_own_events(&fixture.supervisor);
    return fixture.supervisor.counters.plans_started - before;
}

static void a_high_failure_of_the_supervisor_itself_needs_a_plan_of_its_own(void)
{
    TEST_ASSERT_EQUAL_UINT(0U, plans_started_by(SUPERVISOR_EVENT_CHECKPOINT_DAMAGED, SUPERVISOR_APID));
    TEST_ASSERT_EQUAL_UINT(1U, plans_started_by(SUPERVISOR_EVENT_LOG_FAILED, SUPERVISOR_APID));
    TEST_ASSERT_EQUAL_UINT(1U, plans_started_by(SUPERVISOR_EVENT_CHECKPOINT_DAMAGED, ARM));
    fixture.supervisor.shutdown_step = 1U;
    TEST_ASSERT_EQUAL_UINT(0U, plans_started_by(SUPERVISOR_EVENT_LOG_FAILED, SUPERVISOR_APID));
    fixture.supervisor.shutdown_step = 0U;
}

static uint16_t event_of_loss(const uint16_t event)
{
    fixture.supervisor.plans = (plan_runner_t){0};
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    supervisor_error_member_lost(&fixture.supervisor, ARM, event);
    const plan_run_t* const run = supervisor_plan_runner_of(&fixture.supervisor.plans, ARM);
    TEST_ASSERT_NOT_NULL(run);
    return run->event_id;
}

/// A plan for any subsystem does not apply to events of the supervisor itself.
static void the_own_event_of_a_loss_is_used_only_with_a_plan_of_the_supervisor(void)
{
    TEST_ASSERT_EQUAL_UINT16(SUPERVISOR_EVENT_SUBSYSTEM_SILENT,
                             event_of_loss(SUPERVISOR_EVENT_SUBSYSTEM_SILENT));
    TEST_ASSERT_EQUAL_UINT16(SUPERVISOR_EVENT_PROCESS_LOST, event_of_loss(SUPERVISOR_EVENT_PROCESS_HUNG));
    mission()->storage.plans[0].apid = MISSION_ANY_TARGET;
    TEST_ASSERT_EQUAL_UINT16(SUPERVISOR_EVENT_PROCESS_LOST, event_of_loss(SUPERVISOR_EVENT_SUBSYSTEM_SILENT));
    const plan_run_t* const run = supervisor_plan_runner_of(&fixture.supervisor.plans, ARM);
    TEST_ASSERT_EQUAL_UINT16(0U, run->plan); // Plan 0 is the plan for a HIGH event of this subsystem.
}

/// Note an event of the supervisor about `apid`. Returns the number of noted events.
static uint16_t noted_after(const uint16_t event, const uint16_t apid)
{
    const uint8_t data[4] = {(uint8_t)(event >> 8U), (uint8_t)event, (uint8_t)(apid >> 8U), (uint8_t)apid};
    const pus_tm_t tm     = {
            .apid = SUPERVISOR_APID, .service = PUS_SERVICE_EVENTS, .data = data, .size = sizeof data};
    const pus_event_occurrence_t occurrence = {
        .apid = SUPERVISOR_APID, .event = event, .severity = PUS_SEVERITY_HIGH};
    supervisor_error_own_event(&fixture.supervisor, &tm, &occurrence);
    return fixture.supervisor.own_event_count;
}

static void an_own_event_is_about_the_subsystem_that_its_first_field_names(void)
{
    subsystem_descriptor_t* const own =
        (subsystem_descriptor_t*)(uintptr_t)fixture.supervisor.config.descriptor;
    TEST_ASSERT_EQUAL_UINT16(0U, noted_after(999U, ARM)); // No such event.
    TEST_ASSERT_EQUAL_UINT16(1U, noted_after(SUPERVISOR_EVENT_INTERFACE_DIFFERS, ARM));
    TEST_ASSERT_EQUAL_UINT16(1U, noted_after(SUPERVISOR_EVENT_INTERFACE_DIFFERS, ARM));
    TEST_ASSERT_EQUAL_UINT16(2U, noted_after(SUPERVISOR_EVENT_INTERFACE_DIFFERS, HAND));
    TEST_ASSERT_EQUAL_UINT16(3U, noted_after(SUPERVISOR_EVENT_CONFIGURATION_DIFFERS, HAND));
    const descriptor_event_t* const event = descriptor_find_event(own, SUPERVISOR_EVENT_RESOURCE_REFUSED);
    TEST_ASSERT_NOT_NULL(event);
    own->storage.fields[event->first_field].type = VALUE_UINT8;
    TEST_ASSERT_EQUAL_UINT16(3U, noted_after(SUPERVISOR_EVENT_RESOURCE_REFUSED, ARM));
    own->storage.fields[event->first_field].type = VALUE_UINT16;
    TEST_ASSERT_EQUAL_UINT16(4U, noted_after(SUPERVISOR_EVENT_RESOURCE_REFUSED, ARM));
}

// ---- Handshake of links ----

static void members_are_ready(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture_forget();
}

static link_session_t* first_session(void)
{
    return &fixture.supervisor.sessions[0];
}

static void agree(void)
{
    members_are_ready();
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_EQUAL(LINK_ARM_STATE, fixture.supervisor.accepted[0].link);
    fixture_forget();
}

static void a_new_negotiation_that_fails_ends_the_former_agreement(void)
{
    members_are_ready();
    fixture.members[FIXTURE_ARM].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(SESSION_TICKS);
    TEST_ASSERT_FALSE(fixture_has("17 TC 130.7")); // Neither end has agreed yet.
    fixture.members[FIXTURE_ARM].ignores_links = false;
    agree();
    fixture.members[FIXTURE_ARM].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(SESSION_TICKS);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.accepted[0].link);
}

static void a_refused_negotiation_ends_an_agreement_that_is_not_open(void)
{
    members_are_ready();
    agree();
    fixture.members[FIXTURE_ARM].refuses_links = PUS_LINK_REASON_LAYOUT;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.accepted[0].link);
}

/// The producer has kept its end of the open link, and the consumer got no request.
static void an_open_link_stays_open_if_the_producer_refuses_to_negotiate_it_again(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].refuses_links = PUS_LINK_REASON_LAYOUT;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 000000070104"));
    TEST_ASSERT_FALSE(fixture_has("TC 130.7"));
    TEST_ASSERT_NOT_NULL(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE));
    fixture.members[FIXTURE_ARM].refuses_links = 0U;
    fixture_forget();
    (void)fixture_request_link(LINK_ARM_STATE); // The session has ended.
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_TRUE(fixture_has("G 130.4 "));
}

/// Close the link, and return true if its renewal asks the producer for these properties: layout, byte order
/// and period.
static bool is_renewed_with(const char* const properties)
{
    char request[64];
    (void)fixture_close_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.accepted[0].link);
    fixture_forget();
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(&fixture.supervisor, LINK_ARM_STATE));
    (void)snprintf(request, sizeof request, "%08X00010010000100110002%s",
                   (unsigned)fixture.supervisor.link_transaction, properties);
    fixture_run(ANSWER_TICKS);
    const char* const line = strstr(fixture_look(), "16 TC 130.3 ");
    TEST_ASSERT_NOT_NULL(line);
    return strncmp(line + strlen("16 TC 130.3 "), request, strlen(request)) == 0;
}

static void a_renewal_asks_for_the_properties_on_which_both_ends_agreed_last(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.link_period_us                     = 2000U;
    fixture.members[FIXTURE_ARM].refuses_links = PUS_LINK_REASON_PERIOD;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    fixture.members[FIXTURE_ARM].refuses_links = 0U;
    TEST_ASSERT_TRUE(is_renewed_with("000000000000000800000003E8")); // 1 ms.
    fixture.members[FIXTURE_HAND].refuses_links = PUS_LINK_REASON_PERIOD;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    fixture.members[FIXTURE_HAND].refuses_links = 0U;
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(&fixture.supervisor, LINK_ARM_STATE));
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_TRUE(is_renewed_with("000000000000000800000003E8"));
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(ANSWER_TICKS);
    TEST_ASSERT_TRUE(is_renewed_with("000000000000000800000007D0"));
}

static void a_link_is_renewed_only_if_it_can_be_negotiated_again(void)
{
    supervisor_t* const supervisor = &fixture.supervisor;
    members_are_ready();
    // The link was never requested.
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    supervisor->wanted[0].layout_size         = 8U;
    mission()->storage.links[0].producer_apid = UNKNOWN;
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    mission()->storage.links[0].producer_apid = ARM;
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE)); // The link has a session.
    first_session()->step = SESSION_FREE;
    fixture_fill(FIXTURE_ARM); // The producer takes no request.
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    TEST_ASSERT_EQUAL(SESSION_FREE, first_session()->step);
}

static void an_agreed_link_is_opened_again_only_with_a_session_and_a_producer(void)
{
    supervisor_t* const supervisor = &fixture.supervisor;
    agree();
    for (unsigned i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        supervisor->sessions[i] =
            (link_session_t){.step = SESSION_CLOSING, .link = 20U, .deadline_ns = UINT64_MAX};
    }
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    (void)memset(supervisor->sessions, 0, sizeof supervisor->sessions);
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    TEST_ASSERT_EQUAL(SESSION_OPEN_PRODUCER, first_session()->step);
    first_session()->step = SESSION_FREE;
    fixture_fill(FIXTURE_ARM);
    TEST_ASSERT_FALSE(supervisor_link_manager_renew(supervisor, LINK_ARM_STATE));
    TEST_ASSERT_EQUAL(SESSION_FREE, first_session()->step);
}

static void end_reports(const unsigned member, const uint8_t state)
{
    fixture_link_changed(member, LINK_ARM_STATE, PUS_LINK_STATE_ACCEPTED, state);
    fixture_run(1U);
}

static void a_report_of_a_subsystem_has_an_effect_only_in_the_step_that_waits_for_it(void)
{
    agree();
    fixture.members[FIXTURE_ARM].ignores_links  = true;
    fixture.members[FIXTURE_HAND].ignores_links = true;
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(SESSION_OPEN_PRODUCER, first_session()->step);
    end_reports(FIXTURE_HAND, PUS_LINK_STATE_OPEN); // The consumer has no order yet.
    TEST_ASSERT_EQUAL(SESSION_OPEN_PRODUCER, first_session()->step);
    end_reports(FIXTURE_HAND, PUS_LINK_STATE_CLOSED); // The consumer was not open: the session continues.
    TEST_ASSERT_EQUAL(SESSION_OPEN_PRODUCER, first_session()->step);
    end_reports(FIXTURE_ARM, PUS_LINK_STATE_OPEN);
    TEST_ASSERT_EQUAL(SESSION_OPEN_CONSUMER, first_session()->step);
    end_reports(FIXTURE_ARM, PUS_LINK_STATE_OPEN); // A second report of the producer has no effect.
    TEST_ASSERT_EQUAL(SESSION_OPEN_CONSUMER, first_session()->step);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
    end_reports(FIXTURE_HAND, PUS_LINK_STATE_OPEN);
    TEST_ASSERT_EQUAL(SESSION_FREE, first_session()->step);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.graph.count);
}

/// Report the state of one link as a subsystem does after a takeover. Returns true if the manager read the
/// report.
static bool reports_link(const uint16_t apid, const uint16_t destination, const uint16_t link,
                         const uint8_t state, const size_t size)
{
    uint8_t data[2U + STATUS_ROW] = {0U, 1U, (uint8_t)(link >> 8U), (uint8_t)link, state};
    const pus_tm_t tm             = {.apid        = apid,
                                     .service     = PUS_SERVICE_RTLINK,
                                     .subtype     = PUS_LINK_STATUS,
                                     .destination = destination,
                                     .data        = data,
                                     .size        = size};
    fixture_forget();
    entry_of(ARM)->are_links_adopted = true;
    supervisor_link_manager_report(&fixture.supervisor, &tm);
    fixture_run(1U);
    const bool is_read               = !entry_of(ARM)->are_links_adopted;
    entry_of(ARM)->are_links_adopted = false;
    return is_read;
}

static void only_a_whole_report_to_the_supervisor_settles_the_links(void)
{
    const uint16_t own = PUS_USER_SUPERVISOR;
    members_are_ready();
    TEST_ASSERT_TRUE(reports_link(ARM, own, LINK_ARM_STATE, PUS_LINK_STATE_CLOSED, 2U + STATUS_ROW));
    TEST_ASSERT_FALSE(reports_link(UNKNOWN, own, LINK_ARM_STATE, PUS_LINK_STATE_CLOSED, 2U + STATUS_ROW));
    TEST_ASSERT_FALSE(
        reports_link(ARM, FIXTURE_USER, LINK_ARM_STATE, PUS_LINK_STATE_CLOSED, 2U + STATUS_ROW));
    TEST_ASSERT_FALSE(reports_link(ARM, own, LINK_ARM_STATE, PUS_LINK_STATE_CLOSED, 1U + STATUS_ROW));
}

static void only_an_open_link_of_the_mission_is_closed_after_a_takeover(void)
{
    static const struct {
        uint16_t link;
        uint8_t state;
        bool is_closed;
    } cases[] = {
        {LINK_ARM_STATE, PUS_LINK_STATE_CLOSED, false},       {LINK_ARM_STATE, PUS_LINK_STATE_OPEN, true},
        {LINK_ARM_STATE, PUS_LINK_STATE_STALE, true},         {0U, PUS_LINK_STATE_OPEN, false},
        {MISSION_LINKS_MAX + 1U, PUS_LINK_STATE_OPEN, false},
    };
    members_are_ready();
    for (unsigned i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_TRUE(
            reports_link(ARM, PUS_USER_SUPERVISOR, cases[i].link, cases[i].state, 2U + STATUS_ROW));
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].is_closed, fixture_has("16 TC 130.7"), "state of the link");
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_doubtful_state_matters_only_if_it_forbids_the_transition);
    RUN_TEST(any_doubt_about_a_member_forbids_the_transition_to_operational);
    RUN_TEST(without_a_power_limit_no_request_is_refused_for_power);
    RUN_TEST(requests_for_impossible_states_are_passed_to_the_target);
    RUN_TEST(a_report_that_is_too_short_changes_no_state);
    RUN_TEST(a_waiting_order_for_a_lower_state_is_not_replaced);
    RUN_TEST(the_loss_of_a_process_outside_of_the_mission_orders_nothing);
    RUN_TEST(a_high_failure_of_the_supervisor_itself_needs_a_plan_of_its_own);
    RUN_TEST(the_own_event_of_a_loss_is_used_only_with_a_plan_of_the_supervisor);
    RUN_TEST(an_own_event_is_about_the_subsystem_that_its_first_field_names);
    RUN_TEST(a_new_negotiation_that_fails_ends_the_former_agreement);
    RUN_TEST(a_refused_negotiation_ends_an_agreement_that_is_not_open);
    RUN_TEST(an_open_link_stays_open_if_the_producer_refuses_to_negotiate_it_again);
    RUN_TEST(a_renewal_asks_for_the_properties_on_which_both_ends_agreed_last);
    RUN_TEST(a_link_is_renewed_only_if_it_can_be_negotiated_again);
    RUN_TEST(an_agreed_link_is_opened_again_only_with_a_session_and_a_producer);
    RUN_TEST(a_report_of_a_subsystem_has_an_effect_only_in_the_step_that_waits_for_it);
    RUN_TEST(only_a_whole_report_to_the_supervisor_settles_the_links);
    RUN_TEST(only_an_open_link_of_the_mission_is_closed_after_a_takeover);
    return UNITY_END();
}
