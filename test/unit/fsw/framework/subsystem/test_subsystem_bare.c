// SPDX-License-Identifier: Apache-2.0
// Components without optional parts: callbacks, a supervisor, events, published parameters, a loader.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "test/support/consistent_pool.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static const subsystem_callbacks_t nothing;
static subsystem_callbacks_t some;

void setUp(void)
{
    fixture_open(NULL);
    some = *fixture.subsystem.config.callbacks;
}

void tearDown(void)
{
    fixture_close();
}

static void a_subsystem_without_callbacks_reaches_all_states(void)
{
    fixture.subsystem.config.callbacks = &nothing;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(6U);
    // The housekeeping structure has parameters that the program has not published.
    (void)fixture_select(FIXTURE_ALONE);
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "1.8 #1"));
    fixture_forget();
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U));
    // Parameters that are not published are reported as zeros.
    TEST_ASSERT_TRUE(fixture_has("5.2 event 3 aux 0000000000000000"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U);
    const subsystem_callbacks_t publishes = {.software_init = some.software_init};
    fixture.subsystem.config.callbacks    = &publishes;
    fixture_forget();
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_function("WAIT", NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #0 0204"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(30U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
}

static void a_parameter_is_set_without_a_callback_for_it(void)
{
    // One parameter, LIMIT (APID 16, DOUBLE, number 1), with the value 2.
    static const uint8_t limit[]       = {1U, 0x02U, 0x09U, 0U, 1U, 0x40U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};
    some.parameter_set                 = NULL;
    fixture.subsystem.config.callbacks = &some;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_command(20U, 3U, limit, sizeof limit);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, fixture.limit);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.set_id);
}

static void without_a_supervisor_errors_are_reported_and_change_nothing(void)
{
    fixture.subsystem.config.supervisor_timeout_ns = 0U;
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    fixture_heartbeat();
    TEST_ASSERT_EQUAL(STATUS_OK,
                      subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\0\1", 2U));
    fixture_expect("5.4 event 1 aux 0001\n");
    fixture_run(5000U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static size_t carried;

static void carry(void* self, const uint8_t* packet, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&fixture, self);
    TEST_ASSERT_NOT_NULL(packet);
    carried = size;
}

static void reports_of_other_processes_go_to_their_carrier(void)
{
    some.report                        = carry;
    fixture.subsystem.config.callbacks = &some;
    fixture_heartbeat(); // TM[129,5] without data.
    TEST_ASSERT_EQUAL(PUS_TM_MIN, carried);
    fixture_expect("");
}

static void a_subsystem_does_not_time_out_before_its_first_message_of_the_supervisor(void)
{
    TEST_ASSERT_EQUAL(ANSWER_NO, subsystem_request(&fixture.subsystem, STATE_OPERATIONAL, CAUSE_REQUEST));
    TEST_ASSERT_EQUAL(ANSWER_NO, subsystem_select(&fixture.subsystem, FIXTURE_ALONE));
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_request(&fixture.subsystem, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    fixture_run(5U);
    TEST_ASSERT_EQUAL(ANSWER_NO, subsystem_select(&fixture.subsystem, 99U));
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_select(&fixture.subsystem, FIXTURE_ALONE));
    fixture_run(5U);
    for (unsigned i = 0U; (i < 2U) && (subsystem_state(&fixture.subsystem) < STATE_OPERATIONAL); i++) {
        const state_t next = (state_t)(subsystem_state(&fixture.subsystem) + 1);
        TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_request(&fixture.subsystem, next, CAUSE_REQUEST));
        fixture_run(5U);
    }
    fixture_run(5000U); // Longer than the time-out for the supervisor.
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void an_event_that_the_descriptor_does_not_define_is_not_raised(void)
{
    fixture_open_with("STATE_TIMEOUT", "OTHER_TIMEOUT");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.results[ACTION_POST] = STATUS_IO;
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_FALSE(fixture_has("5."));
}

static status_t go_on(const subsystem_function_t* function)
{
    (void)function;
    return STATUS_BUSY;
}

static void the_mission_sets_the_deadline_of_devices(void)
{
    subsystem_config_t config = fixture.subsystem.config;
    // The mission has no deadline.
    TEST_ASSERT_EQUAL_UINT64(0U, subsystem_device_deadline_ns(&fixture.subsystem));
    config.device_deadline_ns = 2500000U;
    fixture_begin(&config);
    TEST_ASSERT_EQUAL_UINT64(2500000U, subsystem_device_deadline_ns(&fixture.subsystem));
}

/// The time is rounded up, so that the rate is never exceeded. HIGH events have no limit.
static void the_time_between_events_follows_from_their_rate(void)
{
    static const struct {
        const char* rate;
        uint16_t interval_ms;
    } rates[] = {{"1/s", 1000U}, {"3/s", 334U}, {"8/s", 125U}, {"999/s", 2U}, {"1000/s", 1U}};
    const subsystem_t* const subsystem = &fixture.subsystem;
    for (size_t i = 0U; i < (sizeof rates / sizeof rates[0]); i++) {
        char event[128];
        (void)snprintf(event, sizeof event, "<Event name='INFO' id='4' severity='INFORMATIVE' rate='%s'/>",
                       rates[i].rate);
        fixture_close();
        fixture_open_with("<Event name='INFO' id='4' severity='INFORMATIVE'/>", event);
        for (uint16_t k = 0U; k < subsystem->descriptor->event_count; k++) {
            const pus_event_definition_t* const definition = &subsystem->event_definitions[k];
            if (definition->id == FIXTURE_INFO) {
                TEST_ASSERT_EQUAL_UINT16(rates[i].interval_ms, definition->interval_ms);
            } else {
                TEST_ASSERT_EQUAL(definition->severity == PUS_SEVERITY_HIGH, definition->interval_ms == 0U);
            }
        }
    }
}

/// Raise one event many times; the descriptor has an event of this layout that reports suppressed events.
static void suppress(const char* const reporter)
{
    static char events[512];
    (void)snprintf(events, sizeof events,
                   "<Event name='INFO' id='4' severity='INFORMATIVE'/>"
                   "<Event name='EVENTS_SUPPRESSED' id='20' severity='LOW'>%s</Event>",
                   reporter);
    fixture_open_with("<Event name='INFO' id='4' severity='INFORMATIVE'/>", events);
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    for (unsigned i = 0U; i < 100U; i++) {
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_INFO, NULL, 0U);
    }
    fixture_run(500U);
}

static void suppressed_events_are_reported_by_an_event_with_fitting_fields(void)
{
    suppress("<ParamRef name='EVENT' type='UINT16'/><ParamRef name='COUNT' type='UINT32'/>");
    TEST_ASSERT_TRUE(fixture_has("5.2 event 20 aux 000400000050\n"));
    TEST_ASSERT_EQUAL_UINT16(20U, fixture.subsystem.events.reporter_id);
    fixture_close();
    suppress("<ParamRef name='EVENT' type='UINT16'/>"); // The event has no field for the number.
    TEST_ASSERT_FALSE(fixture_has("5.2 event 20"));
    TEST_ASSERT_EQUAL_UINT16(0U, fixture.subsystem.events.reporter_id);
}

static void a_pool_warns_only_where_there_is_an_event_for_it(void)
{
    fixture_open_with("POOL_WARNING", "POOL_OTHER");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.in_perform = go_on;
    for (unsigned i = 0U; i < SUBSYSTEM_CALL_TOKENS; i++) {
        (void)fixture_function("WAIT", NULL, 0U);
    }
    fixture_run(3U);
    TEST_ASSERT_FALSE(fixture_has("5."));
    TEST_ASSERT_TRUE(fixture.subsystem.call_tokens.stats.taken > (SUBSYSTEM_CALL_TOKENS / 2U));
}

static status_t end_itself(const subsystem_function_t* function)
{
    subsystem_function_done(&fixture.subsystem, function->call_token, 0U, 0U);
    return STATUS_OK;
}

static void a_function_that_ends_at_once_releases_its_token(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.in_perform = end_itself;
    fixture_forget();
    (void)fixture_function("WAIT", NULL, 0U);
    const char* const text = fixture_look();
    const char* const end  = strstr(text, "1.7 #");
    TEST_ASSERT_NOT_NULL(end);
    TEST_ASSERT_NULL(strstr(&end[1], "1.7 #")); // The request ends once.
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
    TEST_ASSERT_TRUE(pool_is_consistent(&fixture.subsystem.call_tokens));
}

static void a_name_of_eight_characters_is_accepted(void)
{
    fixture_open_with("name='WAIT'", "name='WAIT4YOU'");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_function("WAIT4YOU", NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #0"));
}

// ---- Differences between the program's parameters and the descriptor ----

static void a_field_that_the_program_does_not_publish_is_accepted(void)
{
    fixture_open_with("<ParamRef name='STATE' type='INT32'/>",
                      "<ParamRef name='STATE' type='INT32'/><ParamRef name='MORE' type='INT32' init='3'/>");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    TEST_ASSERT_EQUAL_DOUBLE(7.0, fixture.limit);
}

static void an_initial_value_that_does_not_fit_ends_the_initialisation(void)
{
    fixture_open_with("<ParamRef name='STATE' type='INT32'/>",
                      "<ParamRef name='STATE' type='INT64' init='5000000000'/>");
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(20U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "1.8 #0"));
}

static void expect_refused_configuration(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    (void)fixture_select(FIXTURE_ALONE);
    fixture_run(3U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "1.8 #0"));
    TEST_ASSERT_EQUAL(PHASE_UNCONFIGURED, fixture.subsystem.machine.phase);
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.loop_count);
}

/// The reader of descriptors cannot detect this difference: the program has published a narrower field.
static void an_initial_value_that_does_not_fit_refuses_the_configuration(void)
{
    static subsystem_descriptor_t wide;
    wide = fixture.descriptor;
    descriptor_subsystem_use_storage(&wide);
    wide.storage.initials[0].parameter = 0U;
    wide.storage.initials[0].field     = wide.storage.parameters[0].first_field;
    wide.storage.initials[0].text      = "5000000000";
    fixture.subsystem.descriptor       = &wide;
    expect_refused_configuration();
}

/// Each set of a structure has its own parameters.
static void a_structure_may_have_several_sets(void)
{
    static char xml[8192];
    const char* const whole = fixture_descriptor();
    const char* const last  = strstr(whole, "</HKService>");
    (void)snprintf(xml, sizeof xml,
                   "%.*s<SampledNREPTimes nrep='2'><ParamRef name='LIMIT'/></SampledNREPTimes>%s",
                   (int)(last - whole), whole, last);
    fixture_close();
    fixture_open(xml);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.shows_status = true;
    fixture.count        = 0xABCDU;
    fixture_run(20U);
    fixture_forget();
    fixture_run(10U); // LIMIT is 7; the five others are samples of COUNT.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "ABCDABCDABCDABCDABCD401C000000000000401C000000000000\n"));
}

static void more_sets_than_a_report_can_have_refuse_the_configuration(void)
{
    static const char more[] =
        "<ParamRef name='P1' id='11' type='UINT8'/><ParamRef name='P2' id='12' type='UINT8'/>"
        "<ParamRef name='P3' id='13' type='UINT8'/><ParamRef name='P4' id='14' type='UINT8'/>"
        "<ParamRef name='P5' id='15' type='UINT8'/><ParamRef name='P6' id='16' type='UINT8'/>"
        "<ParamRef name='P7' id='17' type='UINT8'/><ParamRef name='P8' id='18' type='UINT8'/>"
        "</Parameters>";
    static char xml[16384];
    const char* const whole = fixture_descriptor();
    const char* const first = strstr(whole, "</Parameters>");
    const char* const last  = strstr(whole, "</HKService>");
    char* at                = xml;
    (void)memcpy(at, whole, (size_t)(first - whole));
    at += first - whole;
    at += strlen(strcpy(at, more));
    (void)memcpy(at, first + strlen("</Parameters>"), (size_t)(last - first) - strlen("</Parameters>"));
    at += (size_t)(last - first) - strlen("</Parameters>");
    for (char digit = '1'; digit <= '8'; digit++) {
        at += strlen(strcpy(at, "<SampledNREPTimes nrep='5'><ParamRef name='P"));
        *at++ = digit;
        at += strlen(strcpy(at, "'/></SampledNREPTimes>"));
    }
    (void)strcpy(at, last);
    fixture_close();
    fixture_open(xml);
    expect_refused_configuration();
}

// ---- Reloading, and services of the program ----

static void without_a_loader_a_request_to_reload_fails_at_its_start(void)
{
    fixture.subsystem.config.reload = NULL;
    (void)fixture_command(129U, 6U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #0 "));
}

static void a_descriptor_that_is_refused_later_ends_its_request(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_command(129U, 6U, NULL, 0U);
    TEST_ASSERT_FALSE(fixture_has("1.8"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "1.8 #0 "));
}

static void a_program_may_bring_services_of_its_own(void)
{
    static const pus_service_t links = {.type = PUS_SERVICE_RTLINK};
    static const pus_service_t other = {.type = 200U};
    static const pus_service_t test  = {.type = PUS_SERVICE_TEST};
    subsystem_config_t config        = fixture.subsystem.config;
    config.services                  = &links;
    config.service_count             = 1U;
    subsystem_init(&fixture.subsystem, &config);
    fixture.next_sequence = 0U;
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_TRUE(fixture_has("1.2 #0 ")); // The service has no such subtype.
    fixture_close();
    config.services = &other;
    subsystem_init(&fixture.subsystem, &config);
    fixture.next_sequence = 0U;
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_TRUE(fixture_has("130.2") || fixture_has("1.7 #1"));
    fixture_close();
    config.services = &test;
    subsystem_init(&fixture.subsystem, &config);
    fixture.next_sequence = 0U;
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_TEST, 1U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.2 #2 ")); // This service has no such subtype either.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_subsystem_without_callbacks_reaches_all_states);
    RUN_TEST(a_parameter_is_set_without_a_callback_for_it);
    RUN_TEST(without_a_supervisor_errors_are_reported_and_change_nothing);
    RUN_TEST(reports_of_other_processes_go_to_their_carrier);
    RUN_TEST(a_subsystem_does_not_time_out_before_its_first_message_of_the_supervisor);
    RUN_TEST(an_event_that_the_descriptor_does_not_define_is_not_raised);
    RUN_TEST(the_mission_sets_the_deadline_of_devices);
    RUN_TEST(the_time_between_events_follows_from_their_rate);
    RUN_TEST(suppressed_events_are_reported_by_an_event_with_fitting_fields);
    RUN_TEST(a_pool_warns_only_where_there_is_an_event_for_it);
    RUN_TEST(a_function_that_ends_at_once_releases_its_token);
    RUN_TEST(a_name_of_eight_characters_is_accepted);
    RUN_TEST(a_field_that_the_program_does_not_publish_is_accepted);
    RUN_TEST(an_initial_value_that_does_not_fit_ends_the_initialisation);
    RUN_TEST(an_initial_value_that_does_not_fit_refuses_the_configuration);
    RUN_TEST(a_structure_may_have_several_sets);
    RUN_TEST(more_sets_than_a_report_can_have_refuse_the_configuration);
    RUN_TEST(without_a_loader_a_request_to_reload_fails_at_its_start);
    RUN_TEST(a_descriptor_that_is_refused_later_ends_its_request);
    RUN_TEST(a_program_may_bring_services_of_its_own);
    return UNITY_END();
}
