// SPDX-License-Identifier: Apache-2.0
// Services in loops of their own: rate, order, mailbox, and what happens when their configuration ends.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define SLOW 0U ///< Indices of the loops in configuration ALONE.
#define FAST 1U
#define SLOW_NS 4000000ULL
#define FAST_NS 500000ULL
#define SLOW_REPORT 101U ///< LIMIT once, COUNT three times, every 3 cycles of SLOW.
#define FAST_REPORT 102U ///< COUNT every 5 cycles of FAST; initially disabled.

/// The fixture's descriptor with two loops in configuration ALONE.
static void open_with_loops(void)
{
    static const char loops[] = "<Loop name='SLOW' samplingTime='4ms' priority='5'/>"
                                "<Loop name='FAST' samplingTime='500us' priority='20'/>"
                                "<HKService id='101' interval='3' loop='SLOW'>"
                                "<SampledOnce><ParamRef name='LIMIT'/></SampledOnce>"
                                "<SampledNREPTimes nrep='3'><ParamRef name='COUNT'/></SampledNREPTimes>"
                                "</HKService>"
                                "<HKService id='102' interval='5' loop='FAST' enabled='false'>"
                                "<SampledOnce><ParamRef name='COUNT'/></SampledOnce></HKService>";
    static char xml[8192];
    const char* const whole = fixture_descriptor();
    const char* const at    = strstr(whole, "<HKService id='100'");
    TEST_ASSERT_NOT_NULL(at);
    (void)snprintf(xml, sizeof xml, "%.*s%s%s", (int)(at - whole), whole, loops, at);
    fixture_open(xml);
}

/// The values are the time in half milliseconds.
static void count_time(void)
{
    fixture.count = (uint16_t)(fixture.now_ns / FAST_NS);
}

void setUp(void)
{
    open_with_loops();
    fixture.in_sense = count_time;
}

void tearDown(void)
{
    fixture_close();
}

static uint16_t hk_request(uint8_t subtype, uint16_t structure)
{
    const uint8_t data[3] = {1U, (uint8_t)(structure >> 8U), (uint8_t)structure};
    return fixture_command(3U, subtype, data, sizeof data);
}

static void begin(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)hk_request(6U, 100U); // The structure of the component's own loop is disabled.
    fixture_forget();
    fixture.shows_status = true;
}

/// Expect the values that structure 101 reports at a time: those of the cycles before the cycle of the loop.
static void expect_slow_report(uint64_t at_ns)
{
    char expected[96];
    uint64_t times[3] = {at_ns - (2U * SLOW_NS), at_ns - SLOW_NS, at_ns};
    unsigned counts[3];
    for (unsigned i = 0U; i < 3U; i++) {
        counts[i] = (unsigned)((times[i] - FIXTURE_PERIOD_NS) / FAST_NS);
    }
    (void)snprintf(expected, sizeof expected, "3.25 0065401C000000000000%04X%04X%04X\n", counts[0], counts[1],
                   counts[2]);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(fixture_look(), expected), expected);
}

static void a_structure_keeps_the_rate_of_its_loop(void)
{
    begin();
    const uint64_t first_ns = (((fixture.now_ns - 1U) / SLOW_NS) + 1U) * SLOW_NS;
    uint64_t report_ns      = 0U;
    for (unsigned i = 0U; (i < 60U) && (report_ns == 0U); i++) {
        report_ns = fixture_has("3.25 0065") ? fixture.now_ns : 0U;
        fixture_run_until(fixture.now_ns + ((report_ns == 0U) ? FIXTURE_PERIOD_NS : 0U));
    }
    TEST_ASSERT_EQUAL_UINT64(0U, report_ns % SLOW_NS);
    TEST_ASSERT_TRUE(report_ns >= first_ns);
    expect_slow_report(report_ns);
    fixture_run_until(report_ns + (3U * SLOW_NS) - 1U);
    TEST_ASSERT_FALSE(fixture_has("3.25 0065"));
    fixture_run_until(report_ns + (3U * SLOW_NS));
    expect_slow_report(report_ns + (3U * SLOW_NS));
}

/// fixture_run_until steps exactly at the wakes that subsystem_step returns.
static void the_component_wakes_for_the_fastest_loop(void)
{
    begin();
    (void)hk_request(5U, FAST_REPORT);
    const uint64_t start_ns = fixture.now_ns;
    fixture_run_until(start_ns + (20U * FAST_NS));
    unsigned reports = 0U;
    for (const char* at = strstr(fixture_look(), "3.25 0066"); at != NULL; at = strstr(&at[1], "3.25 0066")) {
        reports++;
    }
    // A report every 2.5 ms, although the cycle of the component is one millisecond.
    TEST_ASSERT_EQUAL(4U, reports);
}

static void without_a_configuration_the_highest_priority_applies(void)
{
    TEST_ASSERT_EQUAL(10U, subsystem_component_priority(&fixture.subsystem));
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    TEST_ASSERT_EQUAL(7U, subsystem_component_priority(&fixture.subsystem));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U);
    TEST_ASSERT_EQUAL(10U, subsystem_component_priority(&fixture.subsystem));
}

static void without_its_configuration_a_loop_does_not_run(void)
{
    TEST_ASSERT_TRUE(subsystem_loop_step(&fixture.subsystem, SLOW, 1000U * SLOW_NS) == SUBSYSTEM_NEVER);
    TEST_ASSERT_EQUAL(0U, subsystem_loop_priority(&fixture.subsystem, SLOW));
    begin();
    TEST_ASSERT_EQUAL(5U, subsystem_loop_priority(&fixture.subsystem, SLOW));
    TEST_ASSERT_EQUAL(20U, subsystem_loop_priority(&fixture.subsystem, FAST));
    (void)fixture_select(FIXTURE_LINKED); // This configuration has no loops.
    fixture_run(3U);
    TEST_ASSERT_EQUAL(0U, subsystem_loop_priority(&fixture.subsystem, SLOW));
    TEST_ASSERT_TRUE(subsystem_loop_step(&fixture.subsystem, FAST, fixture.now_ns) == SUBSYSTEM_NEVER);
    (void)fixture_select(FIXTURE_ALONE);
    fixture_run(3U);
    fixture_forget();
    fixture_run(30U);
    TEST_ASSERT_TRUE(fixture_has("3.25 0065"));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U);
    TEST_ASSERT_EQUAL(0U, subsystem_loop_priority(&fixture.subsystem, FAST));
}

static void requests_reach_structures_of_every_loop(void)
{
    static const uint8_t interval[] = {1U, 0U, 101U, 0U, 0U, 0U, 4U};
    begin();
    (void)hk_request(6U, SLOW_REPORT);
    (void)fixture_look();
    fixture_run(40U);
    TEST_ASSERT_FALSE(fixture_has("3.25"));
    (void)hk_request(27U, SLOW_REPORT); // One report, which the component's own loop samples.
    TEST_ASSERT_TRUE(fixture_has("3.25 0065401C000000000000"));
    (void)fixture_look();
    (void)fixture_command(3U, 31U, interval, sizeof interval);
    (void)hk_request(5U, SLOW_REPORT);
    fixture_run(13U);
    TEST_ASSERT_FALSE(fixture_has("3.25")); // Four cycles of 4 ms have not passed yet.
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("3.25 0065"));
    (void)hk_request(6U, SLOW_REPORT);
    (void)hk_request(3U, SLOW_REPORT);
    (void)fixture_look();
    (void)hk_request(5U, SLOW_REPORT);
    // The structure does not exist any more.
    TEST_ASSERT_TRUE(fixture_has("1.1") && (strstr(fixture_look(), " 0201 ") != NULL));
}

// ---- Loops with tasks of their own: stepped here by hand ----

static void begin_with_tasks(void)
{
    fixture.subsystem.config.has_loop_tasks = true;
    begin();
    (void)hk_request(5U, FAST_REPORT);
    fixture_forget();
    fixture.shows_status = true;
}

/// Step a loop this number of its cycles without the component. Returns the time of the last cycle.
static uint64_t step_loop(uint8_t loop, uint64_t period_ns, unsigned cycles)
{
    uint64_t at_ns = (fixture.now_ns / period_ns) * period_ns;
    for (unsigned i = 0U; i < cycles; i++) {
        at_ns += period_ns;
        fixture.count = (uint16_t)(at_ns / FAST_NS);
        TEST_ASSERT_EQUAL_UINT64(at_ns + period_ns, subsystem_loop_step(&fixture.subsystem, loop, at_ns));
    }
    return at_ns;
}

static void the_component_does_not_step_loops_that_have_tasks(void)
{
    begin_with_tasks();
    fixture_run(60U);
    TEST_ASSERT_FALSE(fixture_has("3.25"));
    const uint64_t at_ns = step_loop(FAST, FAST_NS, 5U);
    TEST_ASSERT_FALSE(fixture_has("3.25")); // The loop does not number and send its reports.
    fixture_run(1U);
    char expected[32];
    (void)snprintf(expected, sizeof expected, "3.25 0066%04X\n", (unsigned)(at_ns / FAST_NS));
    fixture_expect(expected);
}

static void a_loop_runs_each_of_its_cycles_once_and_keeps_its_period_when_late(void)
{
    begin_with_tasks();
    const uint64_t at_ns = step_loop(FAST, FAST_NS, 4U);
    for (unsigned i = 0U; i < 10U; i++) { // Woken more often than necessary.
        TEST_ASSERT_EQUAL_UINT64(at_ns + FAST_NS, subsystem_loop_step(&fixture.subsystem, FAST, at_ns + i));
    }
    fixture_run(1U);
    TEST_ASSERT_FALSE(fixture_has("3.25"));
    // Cycles 5, 6 and 7 are performed, two of them late. Cycle 5 completes the first report.
    (void)subsystem_loop_step(&fixture.subsystem, FAST, at_ns + (3U * FAST_NS));
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("3.25 0066"));
    (void)fixture_look();
    for (unsigned i = 4U; i <= 6U; i++) {
        (void)subsystem_loop_step(&fixture.subsystem, FAST, at_ns + (i * FAST_NS));
        fixture_run(1U);
        TEST_ASSERT_EQUAL(i == 6U, fixture_has("3.25 0066")); // Cycle 10.
    }
}

static void a_full_mailbox_refuses_and_counts(void)
{
    static const unsigned fit   = SUBSYSTEM_MAILBOX_OCTETS / (4U + SUBSYSTEM_LOOP_HEADER + 2U);
    static const unsigned cases = 1000U;
    begin_with_tasks();
    const uint32_t before = fixture.subsystem.housekeeping.counters.dropped;
    (void)step_loop(FAST, FAST_NS, 5U * cases);
    for (unsigned i = 0U; i < ((fit / SUBSYSTEM_LOOP_REPORTS) + 2U); i++) {
        fixture_run(1U);
        unsigned reports = 0U;
        for (const char* at = strstr(fixture_look(), "3.25 0066"); at != NULL;
             at             = strstr(&at[1], "3.25 0066")) {
            reports++;
        }
        TEST_ASSERT_TRUE(reports <= SUBSYSTEM_LOOP_REPORTS); // At most this many in one cycle.
    }
    TEST_ASSERT_EQUAL_UINT32(before + cases - fit, fixture.subsystem.housekeeping.counters.dropped);
    fixture_run(1U);
    TEST_ASSERT_FALSE(fixture_has("3.25"));
    (void)step_loop(FAST, FAST_NS, 5U); // The loop continues.
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("3.25 0066"));
}

static void queued_samples_are_dropped_and_counted_when_the_configuration_ends(void)
{
    begin_with_tasks();
    const uint32_t before = fixture.subsystem.housekeeping.counters.dropped;
    (void)step_loop(FAST, FAST_NS, 15U);
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(20U); // The first cycle revokes the configuration.
    TEST_ASSERT_FALSE(fixture_has("3.25 0066"));
    TEST_ASSERT_EQUAL_UINT32(before + 3U, fixture.subsystem.housekeeping.counters.dropped);
}

static void refused_reports_of_a_loop_are_counted(void)
{
    begin_with_tasks();
    const uint32_t before = fixture.subsystem.housekeeping.counters.dropped;
    (void)step_loop(FAST, FAST_NS, 10U);
    fixture.is_port_closed = true;
    fixture_run(1U);
    fixture.is_port_closed = false;
    TEST_ASSERT_EQUAL_UINT32(before + 2U, fixture.subsystem.housekeeping.counters.dropped);
}

/// In a new process, locking a mutex before it is created fails an assertion on every operating system
/// (test/contract/osal/test_mutex.c).
static void mutexes_are_created_before_a_service_locks_them(void)
{
    const subsystem_config_t config = fixture.subsystem.config;
    (void)memset(&fixture.subsystem, 0, sizeof fixture.subsystem);
    fixture_begin(&config);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(mutexes_are_created_before_a_service_locks_them);
    RUN_TEST(a_structure_keeps_the_rate_of_its_loop);
    RUN_TEST(the_component_wakes_for_the_fastest_loop);
    RUN_TEST(without_a_configuration_the_highest_priority_applies);
    RUN_TEST(without_its_configuration_a_loop_does_not_run);
    RUN_TEST(requests_reach_structures_of_every_loop);
    RUN_TEST(the_component_does_not_step_loops_that_have_tasks);
    RUN_TEST(a_loop_runs_each_of_its_cycles_once_and_keeps_its_period_when_late);
    RUN_TEST(a_full_mailbox_refuses_and_counts);
    RUN_TEST(queued_samples_are_dropped_and_counted_when_the_configuration_ends);
    RUN_TEST(refused_reports_of_a_loop_are_counted);
    return UNITY_END();
}
