// SPDX-License-Identifier: Apache-2.0
// Failures: actions that fail or hang, events of each severity, a lost supervisor, a port that refuses
// reports.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

void setUp(void)
{
    fixture_open(NULL);
}

void tearDown(void)
{
    fixture_close();
}

/// Make an action exceed its time-out, or fail at once.
static void spoil(state_action_t action, bool hangs)
{
    fixture.delays[action]  = hangs ? 1000U : 0U;
    fixture.results[action] = STATUS_IO;
}

// ---- Actions ----

static void failing_actions_are_reported(void)
{
    spoil(ACTION_HARDWARE_INIT, false);
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    fixture_run(4U);
    fixture_expect("129.2 8>9 ENTERING cause 1 code 0000 cfg 0\n1.5 #0 step 9\n"
                   "129.2 9>0 IDLE cause 1 code 0000 cfg 0\n1.5 #0 step 0\n1.8 #0 0301 0\n");
    fixture.results[ACTION_HARDWARE_INIT] = STATUS_OK; // The transition can be requested again.
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
}

static void a_failing_action_reverses_the_transition(void)
{
    spoil(ACTION_SOFTWARE_INIT, false);
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_forget();
    fixture_run(2U);
    fixture_expect("129.2 1>9 ENTERING cause 1 code 0301 cfg 0\n1.5 #0 step 9\n"
                   "129.2 9>0 IDLE cause 1 code 0000 cfg 0\n1.5 #0 step 0\n1.8 #0 0301 0\n");
}

static void a_hanging_action_is_ended(void)
{
    spoil(ACTION_HARDWARE_INIT, true);
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    fixture_run(3U); // The time-out of 50 ms is five cycles, two of which have passed.
    fixture_expect("");
    fixture_run(1U);
    fixture_expect("129.2 2>8 ENTERING cause 5 code 0406 cfg 0\n1.5 #0 step 8\n");
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("129.2 8>9"));
    TEST_ASSERT_TRUE(fixture_has("1.8 #0 0301 0"));
}

static void check_way_up(state_action_t action, bool hangs, state_t from, state_t target, const char* lines)
{
    fixture_close();
    fixture_open(NULL);
    fixture_bring(from, FIXTURE_ALONE);
    spoil(action, hangs);
    (void)fixture_state(target);
    fixture_run(1U);
    fixture_forget();
    fixture_run(12U);
    fixture_expect(lines);
}

static void controllers_that_do_not_start_are_stopped(void)
{
    check_way_up(ACTION_START_CONTROL, true, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                 "129.2 4>4 LEAVING cause 5 code 0406 cfg 1\n"
                 "129.2 4>3 CONFIGURED cause 5 code 0000 cfg 1\n1.5 #0 step 3\n1.8 #0 0301 3\n");
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_NOT_NULL(subsystem_configuration(&fixture.subsystem));
}

static void actuators_that_do_not_engage_are_switched_off(void)
{
    check_way_up(ACTION_ENGAGE, true, STATE_SAFE_OPERATIONAL, STATE_OPERATIONAL,
                 "129.2 5>4 ENTERING cause 5 code 0406 cfg 1\n1.5 #0 step 4\n"
                 "129.2 4>4 IDLE cause 5 code 0000 cfg 1\n1.8 #0 0301 4\n");
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void actuators_that_do_not_disengage_are_secured(void)
{
    check_way_up(ACTION_DISENGAGE, true, STATE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                 "129.2 4>6 ENTERING cause 5 code 0406 cfg 1\n1.5 #0 step 6\n"
                 "129.2 6>6 SECURED cause 5 code 0000 cfg 1\n1.8 #0 0301 6\n");
}

static void a_configuration_that_fails_is_revoked(void)
{
    for (unsigned hangs = 0U; hangs < 2U; hangs++) {
        fixture_close();
        fixture_open(NULL);
        fixture_bring(STATE_PRE_OPERATIONAL, 0U);
        spoil(ACTION_CONFIGURE, hangs != 0U);
        (void)fixture_select(FIXTURE_ALONE);
        fixture_forget();
        fixture_run(60U);
        fixture_expect((hangs == 0U) ? "129.2 3>3 UNCONFIGURED cause 1 code 0301 cfg 0\n1.8 #0 0301 3\n"
                                     : "129.2 3>3 UNCONFIGURED cause 5 code 0406 cfg 0\n1.8 #0 0301 3\n");
        TEST_ASSERT_NULL(subsystem_configuration(&fixture.subsystem));
        TEST_ASSERT_EQUAL(10000000U, subsystem_period_ns(&fixture.subsystem));
    }
}

static void devices_that_cannot_be_secured_raise_an_event(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    spoil(ACTION_SECURE, true);
    (void)fixture_state(STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_run(20U);
    // The failure is reported once.
    fixture_expect("129.2 6>6 UNSECURED cause 5 code 0406 cfg 1\n1.8 #0 0301 6\n5.4 event 10 aux \n");
    fixture_close();
    fixture_open(NULL);
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    spoil(ACTION_SECURE, false);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x01", 2U);
    fixture_forget();
    fixture_run(20U);
    fixture_expect("129.2 6>6 UNSECURED cause 1 code 0301 cfg 1\n5.4 event 10 aux \n");
}

static void failures_of_downward_transitions_are_reported_and_do_not_stop_them(void)
{
    for (unsigned hangs = 0U; hangs < 2U; hangs++) {
        static const state_action_t actions[] = {ACTION_POST, ACTION_HARDWARE_DEINIT, ACTION_SOFTWARE_DEINIT};
        static const char* const leavings[]   = {"129.2 7>8", "129.2 8>9", "129.2 9>0"};
        for (unsigned i = 0U; i < 3U; i++) {
            fixture_close();
            fixture_open(NULL);
            fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
            spoil(actions[i], hangs != 0U);
            (void)fixture_state(STATE_OFFLINE);
            fixture_run(200U);
            TEST_ASSERT_TRUE(fixture_has(leavings[i]));
            TEST_ASSERT_TRUE(fixture_has("5.4 event 10"));
            TEST_ASSERT_TRUE(fixture_has("1.8 #0 0301 0"));
            TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
        }
    }
}

/// Expect that each reported transition begins in the state in which the last one ended.
static void check_chain(void)
{
    unsigned state = 0U;
    for (const char* line = fixture_look(); line[0] != '\0'; line = strchr(line, '\n') + 1) {
        unsigned previous = 99U;
        unsigned next     = 99U;
        if (sscanf(line, "129.2 %u>%u", &previous, &next) == 2) {
            TEST_ASSERT_EQUAL(state, previous);
            state = next;
        }
    }
    TEST_ASSERT_EQUAL(state, subsystem_state(&fixture.subsystem));
}

static uint32_t random_state = 5U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static void command_at_random(void)
{
    static const status_t ends[] = {STATUS_OK, STATUS_OK, STATUS_OK, STATUS_IO};
    const state_action_t action  = (state_action_t)draw(ACTION_COUNT);
    fixture.delays[action]       = draw(12U) * draw(2U);
    fixture.results[action]      = ends[draw(4U)];
    switch (draw(8U)) {
    case 0U:
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_STRAINED, NULL, 0U);
        break;
    case 1U:
        if (draw(4U) == 0U) {
            (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
        }
        break;
    case 2U:
        (void)fixture_select((uint16_t)draw(3U));
        break;
    case 3U:
        (void)fixture_function("WAIT", NULL, 0U);
        break;
    default:
        (void)fixture_state((state_t)draw(7U));
        break;
    }
}

/// Returns the number of lines since the last call that report the end of a request.
static unsigned count_ends(void)
{
    const char* const text = fixture_look();
    return fixture_count_lines(text, "1.2 ") + fixture_count_lines(text, "1.4 ") +
           fixture_count_lines(text, "1.7 ") + fixture_count_lines(text, "1.8 ");
}

static void random_histories_report_consecutive_states(void)
{
    for (unsigned history = 0U; history < 60U; history++) {
        fixture_close();
        fixture_open(NULL);
        for (unsigned i = 0U; i < 150U; i++) {
            command_at_random();
            fixture_run(draw(8U));
        }
        check_chain();
    }
}

static void every_request_ends_exactly_once(void)
{
    for (unsigned history = 0U; history < 60U; history++) {
        fixture_close();
        fixture_open(NULL);
        unsigned requests = 0U;
        fixture.source    = FIXTURE_USER;
        for (unsigned i = 0U; i < 150U; i++) {
            const uint32_t before = fixture.subsystem.dispatcher.counters.accepted;
            command_at_random();
            requests += fixture.subsystem.dispatcher.counters.accepted - before;
            fixture_run(draw(8U));
        }
        (void)memset(fixture.delays, 0, sizeof fixture.delays);
        fixture_run(60U);
        TEST_ASSERT_EQUAL(requests, count_ends());
    }
}

// ---- Events ----

static unsigned raise_left;
static uint16_t raise_id;

static void raise_now(void)
{
    if (raise_left > 0U) {
        raise_left--;
        const uint8_t code[2] = {0x00U, 0x07U};
        (void)subsystem_raise(&fixture.subsystem, raise_id, code, (raise_id == FIXTURE_BROKEN) ? 2U : 0U);
    }
}

static void raise_in_action(state_action_t action)
{
    if (action == ACTION_ENGAGE) {
        raise_now();
    }
}

static void arm(uint16_t event)
{
    raise_left            = 1U;
    raise_id              = event;
    fixture.shows_actions = true;
    fixture.shows_cycle   = true;
}

static void an_error_secures_the_devices_before_commands_are_emitted(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    arm(FIXTURE_BROKEN);
    fixture.in_control = raise_now;
    fixture_run(1U);
    fixture_expect("* sense\n* control\n129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n5.4 event 1 aux 0007\n"
                   "* secure\n129.2 6>6 SECURED cause 1 code 0000 cfg 1\n* emit\n");
    fixture_close();
    fixture_open(NULL);
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    arm(FIXTURE_BROKEN);
    fixture.in_sense = raise_now;
    fixture_run(1U);
    fixture_expect("* sense\n129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n5.4 event 1 aux 0007\n"
                   "* secure\n129.2 6>6 SECURED cause 1 code 0000 cfg 1\n* control\n* emit\n");
}

static void an_error_during_an_action_ends_the_action(void)
{
    fixture_bring(STATE_SAFE_OPERATIONAL, FIXTURE_ALONE);
    arm(FIXTURE_BROKEN);
    fixture.in_action = raise_in_action;
    (void)fixture_state(STATE_OPERATIONAL);
    fixture_forget();
    fixture_run(1U);
    fixture_expect(
        "* sense\n* engage\n129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n1.8 #0 0405 0\n"
        "5.4 event 1 aux 0007\n* control\n* secure\n129.2 6>6 SECURED cause 1 code 0000 cfg 1\n* emit\n");
}

static void an_error_during_initialisation_leads_back_to_offline(void)
{
    fixture.delays[ACTION_HARDWARE_INIT] = 4U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
    fixture_run(3U);
    fixture_expect("129.2 2>8 ENTERING cause 1 code 0001 cfg 0\n1.8 #0 0405 0\n5.4 event 1 aux 0007\n"
                   "129.2 8>9 ENTERING cause 1 code 0000 cfg 0\n129.2 9>0 IDLE cause 1 code 0000 cfg 0\n");
}

static void an_error_in_error_operational_is_only_reported(void)
{
    fixture_bring(STATE_ERROR_OPERATIONAL, FIXTURE_ALONE);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
    fixture_run(3U);
    fixture_expect("5.4 event 1 aux 0007\n");
}

static void events_without_their_data_sample_parameters(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U));
    fixture_expect("5.2 event 3 aux 401C000000000000\n"); // LIMIT is 7.
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, NULL, 0U));
    TEST_ASSERT_TRUE(fixture_has("129.2 3>6"));
    TEST_ASSERT_TRUE(fixture_has("5.4 event 1 aux 0000"));
    fixture_forget();
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, subsystem_raise(&fixture.subsystem, 99U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_INFO, NULL, 0U));
    fixture_expect("5.1 event 4 aux \n");
}

static void an_event_with_the_most_data_is_raised_without_them(void)
{
    fixture_open_with("<Event name='NOTE' id='3' severity='LOW'><ParamRef name='LIMIT'/></Event>",
                      "<Event name='NOTE' id='3' severity='LOW'>"
                      "<ParamRef name='ANGLES' type='DOUBLE' count='128'/></Event>");
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U));
    subsystem_health_t health;
    subsystem_health(&fixture.subsystem, &health);
    TEST_ASSERT_EQUAL(0U, health.events_refused);
    TEST_ASSERT_EQUAL(1U, fixture.subsystem.events.counters.reported);
}

static void only_events_of_low_severity_are_raised_by_command(void)
{
    fixture_bring(STATE_SAFE_OPERATIONAL, FIXTURE_ALONE);
    fixture_forget();
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, subsystem_raise_by_command(&fixture.subsystem, 1U)); // HIGH.
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, subsystem_raise_by_command(&fixture.subsystem, 2U)); // MEDIUM.
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE,
                      subsystem_raise_by_command(&fixture.subsystem, 4U)); // INFORMATIVE.
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, subsystem_raise_by_command(&fixture.subsystem, 99U));
    fixture_run(2U);
    fixture_expect("");
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise_by_command(&fixture.subsystem, 3U));
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.2 event 3"));
}

static void publishing_several_parameters_ends_at_the_first_refused_one(void)
{
    static const parameter_field_t field               = {"X", VALUE_UINT32, 1U, 0U};
    static const size_t offsets[]                      = {4U, 0U, 8U};
    static const parameter_definition_t definitions[3] = {
        {"ONE", PARAMETER_ID(FIXTURE_APID, VALUE_UINT32, 11U), &field, 1U, 4U, 4U},
        {"ONE", PARAMETER_ID(FIXTURE_APID, VALUE_UINT32, 12U), &field, 1U, 4U, 4U}, // A name that is taken.
        {"TWO", PARAMETER_ID(FIXTURE_APID, VALUE_UINT32, 13U), &field, 1U, 4U, 4U}};
    uint32_t storage[3]                      = {1U, 2U, 3U};
    parameter_dictionary_t* const dictionary = subsystem_dictionary(&fixture.subsystem);
    const parameter_entry_t* entry           = NULL;
    TEST_ASSERT_EQUAL(STATUS_EXISTS,
                      subsystem_publish_all(&fixture.subsystem, definitions, offsets, 3U, storage));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(dictionary, definitions[0].id, &entry));
    TEST_ASSERT_EQUAL_PTR(&storage[1], entry->storage);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_find(dictionary, definitions[2].id, &entry));
}

static void a_medium_error_waits_four_cycles_for_a_command_of_the_supervisor(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    raise_left         = 1U;
    raise_id           = FIXTURE_STRAINED;
    fixture.in_control = raise_now;
    fixture_run(1U);
    fixture_expect("5.3 event 2 aux \n");
    fixture_run(3U);
    fixture_expect("");
    fixture_run(1U);
    fixture_expect("129.2 5>4 ENTERING cause 1 code 0002 cfg 1\n129.2 4>4 IDLE cause 1 code 0000 cfg 1\n");
    fixture_run(20U);
    fixture_expect("");
}

static void an_order_within_the_four_cycles_replaces_the_own_reaction(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_STRAINED, NULL, 0U);
    fixture_run(2U);
    fixture_forget();
    fixture.source = FIXTURE_SUPERVISOR;
    fixture.ack    = PUS_ACK_COMPLETION;
    (void)fixture_order(STATE_SAFE_OPERATIONAL, CAUSE_OWN_ERROR);
    fixture_run(20U);
    fixture_expect(
        "129.2 5>4 ENTERING cause 1 code 0000 cfg 1\n129.2 4>4 IDLE cause 1 code 0000 cfg 1\n1.7 #0\n");
    (void)fixture_state(STATE_OPERATIONAL); // The event has no further effect.
    fixture_run(20U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void a_medium_error_below_operational_is_logged_only(void)
{
    static const state_t states[] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL,
                                     STATE_ERROR_OPERATIONAL};
    for (unsigned i = 0U; i < 4U; i++) {
        fixture_close();
        fixture_open(NULL);
        if (states[i] != STATE_OFFLINE) {
            fixture_bring(states[i], FIXTURE_ALONE);
        }
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_STRAINED, NULL, 0U);
        fixture_run(20U);
        fixture_expect("5.3 event 2 aux \n");
    }
}

// ---- Supervisor and port ----

static void expect_to_leave_operational_after(uint64_t timeout_ns)
{
    fixture.subsystem.config.supervisor_timeout_ns = timeout_ns;
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    fixture_heartbeat();
    const uint64_t heard_ns = fixture.now_ns;
    while ((fixture.now_ns - heard_ns) <= timeout_ns) {
        fixture_run(1U);
    }
    fixture_expect("");
    fixture_run(2U);
    fixture_expect("129.2 5>4 ENTERING cause 6 code 0000 cfg 1\n129.2 4>4 IDLE cause 6 code 0000 cfg 1\n");
    for (unsigned i = 0U; i < 4000U; i++) { // The loss is reported once; a state below OPERATIONAL is kept.
        fixture_run(1U);
    }
    fixture_expect("");
    fixture_heartbeat();
    (void)fixture_state(STATE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

/// The subsystem waits for the supervisor as long as its mission allows.
static void without_a_supervisor_no_subsystem_stays_operational(void)
{
    static const uint64_t timeouts_ns[] = {3000000000U, 1000000000U, 10000000000U};
    for (unsigned i = 0U; i < 3U; i++) {
        fixture_close();
        fixture_open(NULL);
        expect_to_leave_operational_after(timeouts_ns[i]);
    }
}

static void heartbeats_keep_the_subsystem_operational(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    fixture_run_until(fixture.now_ns + 10000000000ULL);
    fixture_expect("");
}

static void reports_that_the_port_refuses_are_sent_later_in_order(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.is_port_closed = true;
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_run(2U);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U);
    fixture_run(5U);
    fixture_expect("");
    TEST_ASSERT_TRUE(subsystem_step(&fixture.subsystem, fixture.now_ns) <=
                     (fixture.now_ns + FIXTURE_PERIOD_NS));
    fixture.is_port_closed = false;
    fixture.now_ns += FIXTURE_PERIOD_NS;
    fixture_run(1U);
    fixture_expect("1.1 #0\n1.3 #0\n129.2 3>4 ENTERING cause 0 code 0000 cfg 1\n1.5 #0 step 4\n"
                   "129.2 4>4 IDLE cause 0 code 0000 cfg 1\n1.7 #0\n5.2 event 3 aux 401C000000000000\n");
    TEST_ASSERT_EQUAL(0U, subsystem_process(&fixture.subsystem)->counters.lost);
}

static void a_port_that_refuses_for_long_delays_no_cycle(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    fixture.is_port_closed = true;
    const uint32_t before  = subsystem_cycle(&fixture.subsystem);
    for (unsigned i = 0U; i < 2000U; i++) {
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U);
        fixture_run(1U);
    }
    TEST_ASSERT_EQUAL(before + 2000U, subsystem_cycle(&fixture.subsystem));
    subsystem_health_t health; // The limiter passes 20 events at once and ten a second.
    subsystem_health(&fixture.subsystem, &health);
    TEST_ASSERT_EQUAL(2000U - 20U - 19U, health.events_suppressed);
    TEST_ASSERT_EQUAL(0U, health.reports_lost);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(failing_actions_are_reported);
    RUN_TEST(a_failing_action_reverses_the_transition);
    RUN_TEST(a_hanging_action_is_ended);
    RUN_TEST(controllers_that_do_not_start_are_stopped);
    RUN_TEST(actuators_that_do_not_engage_are_switched_off);
    RUN_TEST(actuators_that_do_not_disengage_are_secured);
    RUN_TEST(a_configuration_that_fails_is_revoked);
    RUN_TEST(devices_that_cannot_be_secured_raise_an_event);
    RUN_TEST(failures_of_downward_transitions_are_reported_and_do_not_stop_them);
    RUN_TEST(random_histories_report_consecutive_states);
    RUN_TEST(every_request_ends_exactly_once);
    RUN_TEST(an_error_secures_the_devices_before_commands_are_emitted);
    RUN_TEST(an_error_during_an_action_ends_the_action);
    RUN_TEST(an_error_during_initialisation_leads_back_to_offline);
    RUN_TEST(an_error_in_error_operational_is_only_reported);
    RUN_TEST(events_without_their_data_sample_parameters);
    RUN_TEST(an_event_with_the_most_data_is_raised_without_them);
    RUN_TEST(only_events_of_low_severity_are_raised_by_command);
    RUN_TEST(publishing_several_parameters_ends_at_the_first_refused_one);
    RUN_TEST(a_medium_error_waits_four_cycles_for_a_command_of_the_supervisor);
    RUN_TEST(an_order_within_the_four_cycles_replaces_the_own_reaction);
    RUN_TEST(a_medium_error_below_operational_is_logged_only);
    RUN_TEST(without_a_supervisor_no_subsystem_stays_operational);
    RUN_TEST(heartbeats_keep_the_subsystem_operational);
    RUN_TEST(reports_that_the_port_refuses_are_sent_later_in_order);
    RUN_TEST(a_port_that_refuses_for_long_delays_no_cycle);
    return UNITY_END();
}
