// SPDX-License-Identifier: Apache-2.0
// Services that the generic part of a subsystem provides from the descriptor: functions, parameters,
// housekeeping, events, and the change of the descriptor.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "test/support/consistent_pool.h"
#include "unity.h"

#include <math.h>
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

// ---- Functions ----

static void move(double first, double second, uint16_t speed)
{
    uint8_t octets[32];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, 2U);
    octet_write_u16(&writer, 1U);
    octet_write_f64(&writer, first);
    octet_write_f64(&writer, second);
    octet_write_u16(&writer, 2U);
    octet_write_u16(&writer, speed);
    (void)fixture_function("MOVE", octets, writer.position);
}

static status_t next_status;

static status_t answer(const subsystem_function_t* function)
{
    (void)function;
    return next_status;
}

static void arguments_arrive_as_the_generated_structure(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    move(-1.0, 0.25, 100U);
    fixture_expect("1.1 #0\n1.3 #0\n1.7 #0\n");
    TEST_ASSERT_EQUAL_DOUBLE(-1.0, fixture.moved.target[0]);
    TEST_ASSERT_EQUAL_DOUBLE(0.25, fixture.moved.target[1]);
    TEST_ASSERT_EQUAL(100U, fixture.moved.speed);
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
}

static void arguments_outside_their_bounds_are_refused(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    move(1.0001, 0.0, 1U);
    fixture_expect("1.1 #0\n1.4 #0 0203 0 in 1\n"); // The number of the argument.
    move(0.0, -1.0001, 1U);                         // The bounds hold for every element.
    move(0.0, 0.0, 101U);
    move((double)NAN, 0.0, 1U);
    move(0.0, (double)INFINITY, 1U);
    move(-(double)INFINITY, 0.0, 1U);
    fixture_expect("1.1 #1\n1.4 #1 0203 0 in 1\n1.1 #2\n1.4 #2 0203 0 in 2\n"
                   "1.1 #3\n1.4 #3 0203 B in 1\n1.1 #4\n1.4 #4 0203 B in 1\n"
                   "1.1 #5\n1.4 #5 0203 B in 1\n"); // The type of the value that is not finite.
    TEST_ASSERT_EQUAL(0U, fixture.moved.speed);     // No function was performed.
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
}

static void functions_are_refused_outside_their_states_and_configurations(void)
{
    fixture_bring(STATE_SAFE_OPERATIONAL, FIXTURE_ALONE);
    move(0.0, 0.0, 1U);
    fixture_expect("1.1 #0\n1.4 #0 0204 1\n");
    fixture_close();
    fixture_open(NULL);
    (void)fixture_function("WAIT", NULL, 0U);
    fixture_expect("1.1 #0\n1.4 #0 0204 2\n");
    fixture_bring(STATE_PRE_OPERATIONAL, 0U); // WAIT needs no configuration.
    (void)fixture_function("WAIT", NULL, 0U);
    fixture_expect("1.1 #0\n1.3 #0\n1.7 #0\n");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    // MOVE does not belong to the configuration LINKED. Without its link, LINKED does not reach OPERATIONAL,
    // so the test sets the state directly.
    fixture.subsystem.machine.state = STATE_OPERATIONAL;
    move(0.0, 0.0, 1U);
    fixture_expect("1.1 #0\n1.4 #0 0204 1\n");
    fixture.subsystem.machine.state = STATE_PRE_OPERATIONAL;
}

static void unknown_functions_and_malformed_arguments_are_refused(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_function("MOVED", NULL, 0U);
    fixture_expect("1.1 #0\n1.4 #0 0201 4D4F5645\n");
    (void)fixture_function("MOVE", NULL, 0U); // Arguments are missing.
    TEST_ASSERT_TRUE(fixture_has("1.2 #1 0108"));
    fixture_forget();
    (void)fixture_function("WAIT", "\x00\x00", 2U);
    TEST_ASSERT_TRUE(fixture_has("1.2 #2 0108"));
    fixture_forget();
    (void)fixture_function("MOVE", "\x02\x00\x09", 3U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #3 0201 9"));
}

static void a_function_ends_with_the_outcome_that_it_returns(void)
{
    static const struct {
        status_t status;
        const char* lines;
    } rows[] = {
        {STATUS_OK, "1.1 #0\n1.3 #0\n1.7 #0\n"},
        {STATUS_FORBIDDEN, "1.1 #0\n1.4 #0 0204 2\n"},
        {STATUS_OUT_OF_RANGE, "1.1 #0\n1.4 #0 0203 0\n"},
        {STATUS_IO, "1.1 #0\n1.3 #0\n1.8 #0 0403 14\n"},
    };
    for (unsigned i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        fixture_close();
        fixture_open(NULL);
        fixture_bring(STATE_PRE_OPERATIONAL, 0U);
        fixture.in_perform = answer;
        next_status        = rows[i].status;
        (void)fixture_function("WAIT", NULL, 0U);
        fixture_expect(rows[i].lines);
        TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
    }
}

static void a_function_may_end_later(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    fixture.in_perform = answer;
    next_status        = STATUS_BUSY;
    (void)fixture_function("WAIT", NULL, 0U);
    const uint32_t first = fixture.last_call_token;
    (void)fixture_function("WAIT", NULL, 0U);
    const uint32_t second = fixture.last_call_token;
    fixture_run(3U);
    fixture_expect("1.1 #0\n1.3 #0\n1.1 #1\n1.3 #1\n");
    TEST_ASSERT_TRUE(first != second);
    subsystem_function_done(&fixture.subsystem, second, 0U, 0U);
    subsystem_function_done(&fixture.subsystem, first, PUS_FAILURE_NO_ANSWER, 17U);
    fixture_expect("1.7 #1\n1.8 #0 0402 11\n");
    subsystem_function_done(&fixture.subsystem, first, 0U, 0U); // The function has already ended.
    subsystem_function_done(&fixture.subsystem, 0U, 0U, 0U);
    subsystem_function_done(&fixture.subsystem, 99U, 0U, 0U);
    subsystem_function_done(&fixture.subsystem, UINT32_MAX, 0U, 0U);
    fixture_expect("");
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
}

static void too_many_functions_at_once_are_refused_after_a_warning(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    fixture.in_perform = answer;
    next_status        = STATUS_BUSY;
    for (unsigned i = 0U; i < 5U; i++) {
        (void)fixture_function("WAIT", NULL, 0U);
    }
    fixture_run(1U);
    TEST_ASSERT_FALSE(fixture_has("5.2"));
    fixture_forget();
    (void)fixture_function("WAIT", NULL, 0U); // Six tokens of eight are 75 %.
    fixture_run(2U);
    fixture_expect("1.1 #5\n1.3 #5\n5.2 event 5 aux \n");
    (void)fixture_function("WAIT", NULL, 0U);
    (void)fixture_function("WAIT", NULL, 0U);
    (void)fixture_function("WAIT", NULL, 0U);
    fixture_run(2U);
    fixture_expect("1.1 #6\n1.3 #6\n1.1 #7\n1.3 #7\n1.1 #8\n1.4 #8 0205 8\n");
    for (uint32_t call_token = 1U; call_token <= SUBSYSTEM_CALL_TOKENS; call_token++) {
        subsystem_function_done(&fixture.subsystem, call_token, 0U, 0U);
    }
    fixture_forget();
    for (unsigned i = 0U; i < 6U; i++) { // The limit is reached again: another warning.
        (void)fixture_function("WAIT", NULL, 0U);
    }
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.2 event 5"));
}

static void the_last_call_token_is_reserved_for_the_ground(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    fixture.in_perform = answer;
    next_status        = STATUS_BUSY;
    fixture.source     = PUS_USER_ONBOARD | 1U;
    for (unsigned i = 0U; i < 7U; i++) {
        (void)fixture_function("WAIT", NULL, 0U);
    }
    fixture_run(1U);
    fixture_forget();
    (void)fixture_function("WAIT", NULL, 0U); // A request from on board is refused.
    fixture_expect("1.1 #7\n1.4 #7 0205 8\n");
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.subsystem.call_tokens.stats.refused);
    fixture.source = FIXTURE_USER;
    (void)fixture_function("WAIT", NULL, 0U); // A request of the ground is performed.
    fixture_expect("1.1 #8\n1.3 #8\n");
    TEST_ASSERT_EQUAL_UINT16(SUBSYSTEM_CALL_TOKENS, fixture.subsystem.call_tokens.stats.taken);
}

static void running_functions_fail_when_error_or_offline_is_requested(void)
{
    fixture.in_perform = answer;
    next_status        = STATUS_BUSY;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_function("WAIT", NULL, 0U);
    (void)fixture_function("WAIT", NULL, 0U);
    (void)fixture_state(STATE_ERROR_OPERATIONAL);
    TEST_ASSERT_TRUE(fixture_has("1.8 #0 0405 0"));
    TEST_ASSERT_TRUE(fixture_has("1.8 #1 0405 0"));
    fixture_run(2U);
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL(2U, fixture_count_lines(fixture_look(), "1.8 "));
    fixture.delays[ACTION_HARDWARE_INIT] = 3U; // Time for OFFLINE before PRE_OPERATIONAL is reached.
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    (void)fixture_function("WAIT", NULL, 0U);
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(
        2U, fixture_count_lines(fixture_look(), "1.8 ")); // The request for PRE_OPERATIONAL and the function.
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
    TEST_ASSERT_TRUE(pool_is_consistent(&fixture.subsystem.call_tokens));
}

static status_t break_inside(const subsystem_function_t* function)
{
    (void)function;
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
    return next_status;
}

static void a_function_that_causes_an_error_ends_once(void)
{
    static const status_t ends[]     = {STATUS_OK, STATUS_IO, STATUS_BUSY};
    static const char* const lines[] = {"1.7 #0\n", "1.8 #0 0403 14\n", "1.8 #0 0405 0\n"};
    for (unsigned i = 0U; i < 3U; i++) {
        char expected[256];
        fixture_close();
        fixture_open(NULL);
        fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
        fixture.in_perform = break_inside;
        next_status        = ends[i];
        (void)fixture_function("WAIT", NULL, 0U);
        (void)snprintf(expected, sizeof expected,
                       "1.1 #0\n129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n5.4 event 1 aux 0007\n1.3 #0\n%s",
                       lines[i]);
        fixture_expect(expected);
        TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
    }
}

// ---- Parameters ----

static void set_limit(double value)
{
    uint8_t octets[16];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, fixture_limit_id);
    octet_write_f64(&writer, value);
    (void)fixture_command(PUS_SERVICE_PARAMETERS, 3U, octets, writer.position);
}

static void report_parameter(uint32_t id)
{
    uint8_t octets[8];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, id);
    (void)fixture_command(PUS_SERVICE_PARAMETERS, 1U, octets, writer.position);
}

static void parameters_are_set_within_their_bounds(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    set_limit(10.0);
    fixture_expect("1.1 #0\n1.3 #0\n1.7 #0\n");
    TEST_ASSERT_EQUAL_DOUBLE(10.0, fixture.limit);
    TEST_ASSERT_EQUAL_HEX32(fixture_limit_id, fixture.set_id);
    fixture.set_id = 0U;
    set_limit(10.001);
    set_limit(-0.001);
    set_limit((double)NAN);
    TEST_ASSERT_EQUAL(3U, fixture_count_lines(fixture_look(), "1.4 #"));
    TEST_ASSERT_EQUAL_DOUBLE(10.0, fixture.limit);
    TEST_ASSERT_EQUAL(0U, fixture.set_id);
}

static void parameters_are_unknown_while_the_subsystem_is_offline(void)
{
    report_parameter(fixture_values_id);
    fixture_expect("1.1 #0\n1.4 #0 0201 2180000 in 1\n");
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    report_parameter(fixture_values_id);
    fixture_expect("1.1 #0\n1.3 #0\n20.2 000102180000000000003FF00000000000004000000000000000\n1.7 #0\n");
    set_limit(9.0);
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(6U);
    fixture_forget();
    report_parameter(fixture_values_id);
    TEST_ASSERT_TRUE(fixture_has("1.4 #3 0201 2180000"));
    // After the next start from OFFLINE the parameter has its initial value.
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, fixture.limit);
}

// ---- Housekeeping ----

static void count_cycles(void)
{
    fixture.count = (uint16_t)subsystem_cycle(&fixture.subsystem);
}

/// Run until the next report. Check that its five samples are two cycles apart and the last one is of this
/// cycle. Returns the cycle.
static uint32_t next_report(void)
{
    char expected[128];
    for (unsigned i = 0U; !fixture_has("3.25") && (i < 20U); i++) {
        fixture_run(1U);
    }
    const unsigned cycle = (unsigned)subsystem_cycle(&fixture.subsystem);
    (void)snprintf(expected, sizeof expected,
                   "3.25 0064000000033FF00000000000004000000000000000%04X%04X%04X%04X%04X\n", cycle - 8U,
                   cycle - 6U, cycle - 4U, cycle - 2U, cycle);
    fixture_expect(expected);
    return cycle;
}

static void housekeeping_is_sampled_as_the_descriptor_defines(void)
{
    fixture.in_control = count_cycles;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.shows_status = true;
    fixture.values.state = 3;
    const uint32_t first = next_report();
    TEST_ASSERT_TRUE(first <= 10U); // In the first interval after the configuration was applied.
    TEST_ASSERT_EQUAL(first + 10U, next_report());
    fixture_run(100U);
    // The configuration is applied again: cycles and reports start again.
    (void)fixture_select(FIXTURE_ALONE);
    fixture_run(2U);
    fixture_forget();
    TEST_ASSERT_EQUAL(first, next_report());
    TEST_ASSERT_EQUAL(first + 10U, next_report());
    // Periodic reports continue in each state, at the same cycles.
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_run(40U);
    TEST_ASSERT_EQUAL(4U, fixture_count_lines(fixture_look(), "3.25"));
    (void)fixture_state(STATE_ERROR_OPERATIONAL);
    fixture_run(40U);
    TEST_ASSERT_EQUAL(4U, fixture_count_lines(fixture_look(), "3.25"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(40U);
    TEST_ASSERT_TRUE(fixture_count_lines(fixture_look(), "3.25") <= 1U);
}

static void create_structure(uint32_t parameter)
{
    uint8_t octets[32];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, 7U);
    octet_write_u32(&writer, 10U);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, parameter);
    octet_write_u8(&writer, 0U);
    (void)fixture_command(PUS_SERVICE_HOUSEKEEPING, 1U, octets, writer.position);
}

static void structures_are_deleted_with_their_parameters(void)
{
    fixture.delays[ACTION_HARDWARE_INIT] = 3U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    create_structure(fixture_values_id);
    TEST_ASSERT_TRUE(fixture_has("1.7 #1"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_HOUSEKEEPING, 27U, "\x01\x00\x07", 3U);
    fixture_expect("1.1 #3\n1.4 #3 0201 7 in 1\n");
}

// ---- Events ----

static void a_disabled_event_still_causes_the_error_state(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_command(PUS_SERVICE_EVENTS, 6U, "\x01\x00\x01", 3U);
    fixture_forget();
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
    fixture_run(1U);
    fixture_expect("129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n129.2 6>6 SECURED cause 1 code 0000 cfg 1\n");
}

// ---- Changing the descriptor ----

static subsystem_descriptor_t changed;

static void change(const char* from, const char* to)
{
    static char xml[8192];
    (void)snprintf(xml, sizeof xml, "%s", fixture_descriptor());
    char* const found = strstr(xml, from);
    TEST_ASSERT_NOT_NULL(found);
    TEST_ASSERT_EQUAL(strlen(from), strlen(to));
    (void)memcpy(found, to, strlen(to));
    TEST_ASSERT_TRUE(fixture_parse(xml, &changed));
    fixture.next_descriptor = &changed;
}

static void reload(void)
{
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_RELOAD, NULL, 0U);
}

static void a_new_descriptor_applies_at_once_if_nothing_is_controlled(void)
{
    change("init='5' min='0' max='10'", "init='2' min='0' max='20'");
    reload();
    fixture_expect("1.1 #0\n1.3 #0\n1.7 #0\n");
    TEST_ASSERT_TRUE(subsystem_descriptor(&fixture.subsystem) == &changed);
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, fixture.limit);
    set_limit(19.0);
    TEST_ASSERT_EQUAL_DOUBLE(19.0, fixture.limit);
    change("samplingTime='10ms'", "samplingTime='20ms'");
    reload();
    TEST_ASSERT_TRUE(fixture_has("1.7 #1"));
    TEST_ASSERT_EQUAL(20000000U, subsystem_period_ns(&fixture.subsystem));
}

static void a_refused_descriptor_leaves_the_old_one(void)
{
    reload();
    fixture_expect("1.1 #0\n1.3 #0\n1.8 #0 0404 6\n");
    TEST_ASSERT_TRUE(subsystem_descriptor(&fixture.subsystem) == &fixture.descriptor);
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
}

static void a_new_descriptor_waits_until_nothing_is_controlled(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    change("init='5' min='0' max='10'", "init='2' min='0' max='20'");
    reload();
    fixture_run(10U);
    fixture_expect("1.1 #0\n1.3 #0\n");
    reload();
    fixture_expect("1.1 #1\n1.4 #1 0204 5\n");
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(6U);
    TEST_ASSERT_TRUE(fixture_has("129.2 7>3 UNCONFIGURED"));
    TEST_ASSERT_TRUE(fixture_has("1.7 #0"));
    TEST_ASSERT_TRUE(subsystem_descriptor(&fixture.subsystem) == &changed);
}

static void a_component_without_a_descriptor_accepts_one(void)
{
    fixture_close();
    fixture_open_invalid();
    change("init='5' min='0' max='10'", "init='2' min='0' max='20'");
    reload();
    fixture_expect("1.1 #0\n129.2 0>0 IDLE cause 0 code 0000 cfg 0\n1.3 #0\n1.7 #0\n");
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    move(0.5, 0.5, 5U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #0"));
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U));
    TEST_ASSERT_TRUE(fixture_has("5.2 event 3"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(arguments_arrive_as_the_generated_structure);
    RUN_TEST(arguments_outside_their_bounds_are_refused);
    RUN_TEST(functions_are_refused_outside_their_states_and_configurations);
    RUN_TEST(unknown_functions_and_malformed_arguments_are_refused);
    RUN_TEST(a_function_ends_with_the_outcome_that_it_returns);
    RUN_TEST(a_function_may_end_later);
    RUN_TEST(too_many_functions_at_once_are_refused_after_a_warning);
    RUN_TEST(the_last_call_token_is_reserved_for_the_ground);
    RUN_TEST(running_functions_fail_when_error_or_offline_is_requested);
    RUN_TEST(a_function_that_causes_an_error_ends_once);
    RUN_TEST(parameters_are_set_within_their_bounds);
    RUN_TEST(parameters_are_unknown_while_the_subsystem_is_offline);
    RUN_TEST(housekeeping_is_sampled_as_the_descriptor_defines);
    RUN_TEST(structures_are_deleted_with_their_parameters);
    RUN_TEST(a_disabled_event_still_causes_the_error_state);
    RUN_TEST(a_new_descriptor_applies_at_once_if_nothing_is_controlled);
    RUN_TEST(a_refused_descriptor_leaves_the_old_one);
    RUN_TEST(a_new_descriptor_waits_until_nothing_is_controlled);
    RUN_TEST(a_component_without_a_descriptor_accepts_one);
    return UNITY_END();
}
