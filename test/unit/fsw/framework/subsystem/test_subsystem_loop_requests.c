// SPDX-License-Identifier: Apache-2.0
// Requests that are performed in a loop of their own: when, with which reports, and that none stays open.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define SLOW 0U ///< Index of the loop in configuration ALONE.
#define SLOW_NS 4000000ULL
#define UNKNOWN 0x0201FFFFU ///< Id of a parameter that does not exist.

static void open_with(const char* services)
{
    static char xml[8192];
    const char* const whole = fixture_descriptor();
    const char* const at    = strstr(whole, "<HKService id='100'");
    TEST_ASSERT_NOT_NULL(at);
    (void)snprintf(xml, sizeof xml,
                   "%.*s<Loop name='SLOW' samplingTime='4ms' priority='5' services='%s'/>"
                   "<HKService id='101' interval='1' loop='SLOW' enabled='false'>"
                   "<SampledOnce><ParamRef name='COUNT'/></SampledOnce></HKService>%s",
                   (int)(at - whole), whole, services, at);
    fixture_open(xml);
}

static void count_time(void)
{
    fixture.count = (uint16_t)(fixture.now_ns / FIXTURE_PERIOD_NS);
}

void setUp(void)
{
    open_with("17 20");
    fixture.in_sense = count_time;
}

void tearDown(void)
{
    fixture_close();
}

/// Bring the component to the middle between two cycles of the loop.
static void begin(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture_run_until(((fixture.now_ns / SLOW_NS) * SLOW_NS) + (5U * SLOW_NS) + (SLOW_NS / 2U));
    fixture_forget();
}

static void values(unsigned count, const uint32_t* ids)
{
    uint8_t data[1024];
    octet_writer_t writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, (uint8_t)count);
    for (unsigned i = 0U; i < count; i++) {
        octet_write_u32(&writer, ids[i]);
    }
    TEST_ASSERT_FALSE(writer.failed);
    (void)fixture_command(20U, 1U, data, writer.position);
}

static void only_requests_to_services_of_a_loop_wait_for_it(void)
{
    // One parameter, LIMIT (APID 16, DOUBLE, number 1), with the value 2.
    static const uint8_t limit[] = {1U, 0x02U, 0x09U, 0U, 1U, 0x40U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};
    begin();
    const uint64_t next_ns = ((fixture.now_ns / SLOW_NS) + 1U) * SLOW_NS;
    values(1U, &fixture_count_id);
    (void)fixture_command(17U, 1U, NULL, 0U);
    fixture_expect("1.1 #0\n1.1 #1\n");
    // TC[20,3] affects the control, so the loop of the component performs it at once.
    (void)fixture_command(20U, 3U, limit, sizeof limit);
    fixture_expect("1.1 #2\n1.3 #2\n1.7 #2\n");
    fixture_run_until(next_ns - 1U);
    fixture_expect("");
    fixture_run_until(next_ns);
    char expected[128];
    (void)snprintf(
        expected, sizeof expected, "1.3 #0\n20.2 0001%08X%04X\n1.7 #0\n1.3 #1\n17.2 \n1.7 #1\n",
        (unsigned)fixture_count_id,
        (unsigned)((next_ns - FIXTURE_PERIOD_NS) / FIXTURE_PERIOD_NS)); // The value after the last cycle.
    fixture_expect(expected);
}

static void a_service_that_no_loop_names_is_performed_at_once(void)
{
    fixture_close();
    open_with("20");
    begin();
    (void)fixture_command(17U, 1U, NULL, 0U);
    fixture_expect("1.1 #0\n1.3 #0\n17.2 \n1.7 #0\n");
    fixture_close();
    open_with("17");
    begin();
    values(1U, &fixture_count_id);
    TEST_ASSERT_TRUE(fixture_has("1.7 #0"));
}

static void without_a_configuration_requests_are_performed_at_once(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    values(1U, &fixture_count_id);
    (void)fixture_command(17U, 1U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #0") && fixture_has("1.7 #1"));
    (void)fixture_select(FIXTURE_LINKED);
    fixture_run(3U);
    fixture_forget();
    (void)fixture_command(17U, 1U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #3"));
}

static void a_request_performed_in_the_loop_is_refused_like_any_other(void)
{
    const uint32_t ids[] = {UNKNOWN, fixture_limit_id};
    begin();
    values(2U, ids);
    values(1U, ids);
    (void)fixture_command(20U, 1U, "\2\0", 2U); // The format is wrong: the request is not accepted.
    fixture_expect("1.1 #0\n1.1 #1\n1.2 #2 0108 1\n");
    fixture_run(8U);
    const char* const lines = fixture_look();
    TEST_ASSERT_EQUAL(2U, fixture_count(lines, "1.4 #"));
    TEST_ASSERT_NOT_NULL(strstr(lines, "20.2 0001020900014"));
    TEST_ASSERT_NOT_NULL(strstr(lines, "1.8 #0 "));
    TEST_ASSERT_EQUAL(0U, fixture_count(lines, "1.7") + fixture_count(lines, "1.8 #1"));
}

static void a_full_inbox_refuses_with_the_number_of_waiting_requests(void)
{
    static const unsigned sent = 300U;
    begin();
    for (unsigned i = 0U; i < sent; i++) {
        (void)fixture_command(17U, 1U, NULL, 0U);
    }
    const char* const lines = fixture_look();
    const unsigned refused  = fixture_count(lines, "1.4 #");
    const unsigned waiting  = sent - refused;
    char expected[32];
    TEST_ASSERT_TRUE((refused > 0U) && (waiting > 100U));
    (void)snprintf(expected, sizeof expected, "1.4 #299 0205 %X\n", waiting);
    TEST_ASSERT_NOT_NULL(strstr(lines, expected));
    unsigned answered = 0U;
    for (unsigned i = 0U; i < ((waiting / SUBSYSTEM_LOOP_REQUESTS) + 2U); i++) {
        fixture_run_until(fixture.now_ns + SLOW_NS);
        const unsigned now = fixture_count(fixture_look(), "17.2");
        TEST_ASSERT_TRUE(now <= SUBSYSTEM_LOOP_REQUESTS); // At most this many in one cycle.
        answered += now;
    }
    TEST_ASSERT_EQUAL(waiting, answered);
}

static void no_report_of_the_longest_request_is_lost(void)
{
    uint32_t ids[255];
    begin();
    for (unsigned i = 0U; i < 255U; i++) {
        ids[i] = (i < 254U) ? UNKNOWN : fixture_count_id;
    }
    values(255U, ids);
    values(255U, ids);
    values(255U, ids);
    unsigned refusals = 0U;
    unsigned ends     = 0U;
    for (unsigned i = 0U; i < 200U; i++) {
        fixture_run_until(fixture.now_ns + FIXTURE_PERIOD_NS);
        const char* const lines = fixture_look();
        refusals += fixture_count(lines, "1.4 #");
        ends += fixture_count(lines, "1.8 #");
    }
    subsystem_health_t health;
    subsystem_health(&fixture.subsystem, &health);
    TEST_ASSERT_EQUAL(3U, ends);
    TEST_ASSERT_EQUAL(3U * 254U, refusals);
    TEST_ASSERT_EQUAL(0U, health.reports_lost);
}

static void queued_requests_are_performed_before_the_configuration_ends(void)
{
    begin();
    (void)fixture_command(3U, 5U, "\1\0\145", 3U); // Structure 101.
    for (unsigned i = 0U; i < 20U; i++) {
        values(1U, &fixture_count_id);
    }
    fixture_forget();
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(2U); // POST_OPERATIONAL: before the loop's next cycle.
    const char* const lines = fixture_look();
    TEST_ASSERT_EQUAL(20U, fixture_count(lines, "20.2 0001"));
    TEST_ASSERT_EQUAL(20U, fixture_count(lines, "\n1.3 #") - fixture_count(lines, "\n1.3 #21"));
    fixture_run(30U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    fixture_forget();
    (void)fixture_command(17U, 1U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.7 "));
}

static void another_configuration_may_be_selected_with_requests_waiting(void)
{
    begin();
    values(1U, &fixture_count_id);
    (void)fixture_select(FIXTURE_LINKED);
    fixture_run(2U);
    const char* const lines = fixture_look();
    TEST_ASSERT_NOT_NULL(strstr(lines, "1.7 #0"));
    TEST_ASSERT_NOT_NULL(strstr(lines, "1.7 #1"));
}

static void answers_wait_while_the_port_is_closed(void)
{
    fixture.subsystem.config.has_loop_tasks = true;
    begin();
    const uint64_t at_ns = ((fixture.now_ns / SLOW_NS) + 1U) * SLOW_NS;
    values(1U, &fixture_count_id);
    TEST_ASSERT_EQUAL_UINT64(at_ns + SLOW_NS, subsystem_loop_step(&fixture.subsystem, SLOW, at_ns));
    fixture_expect("1.1 #0\n"); // The loop itself sends nothing.
    fixture.is_port_closed = true;
    fixture_run(3U);
    fixture.is_port_closed = false;
    fixture_run(1U);
    const char* const lines = fixture_look();
    TEST_ASSERT_EQUAL(1U, fixture_count(lines, "1.3 #0\n20.2 0001"));
    TEST_ASSERT_EQUAL(1U, fixture_count(lines, "1.7 #0"));
}

static void a_mailbox_without_room_keeps_requests_waiting(void)
{
    uint32_t ids[255];
    fixture.subsystem.config.has_loop_tasks = true;
    begin();
    for (unsigned i = 0U; i < 255U; i++) {
        ids[i] = UNKNOWN;
    }
    for (unsigned i = 0U; i < 3U; i++) {
        values(255U, ids);
    }
    uint64_t at_ns = (fixture.now_ns / SLOW_NS) * SLOW_NS;
    for (unsigned i = 0U; i < 50U; i++) { // The mailbox is not emptied.
        at_ns += SLOW_NS;
        (void)subsystem_loop_step(&fixture.subsystem, SLOW, at_ns);
    }
    TEST_ASSERT_EQUAL(2U, fixture.subsystem.loops[SLOW].inbox.blocks);
    fixture_forget();
    unsigned refusals = 0U;
    for (unsigned i = 0U; i < 100U; i++) {
        at_ns += SLOW_NS;
        (void)subsystem_loop_step(&fixture.subsystem, SLOW, at_ns);
        fixture_run(1U);
        refusals += fixture_count(fixture_look(), "1.4 #");
    }
    TEST_ASSERT_EQUAL(3U * 255U, refusals);
}

/// The mailbox reserves room for the longest request, so a loss needs a defect; it is still counted.
static void reports_that_a_loop_lost_are_counted_in_the_health(void)
{
    subsystem_health_t health;
    begin();
    subsystem_health(&fixture.subsystem, &health);
    const uint32_t before = health.reports_lost;
    for (unsigned i = 1U; i <= 2U; i++) {
        fixture.subsystem.loops[SLOW].reports_lost = 3U;
        fixture_run(2U);
        subsystem_health(&fixture.subsystem, &health);
        TEST_ASSERT_EQUAL_UINT32(before + (3U * i), health.reports_lost);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_requests_to_services_of_a_loop_wait_for_it);
    RUN_TEST(a_service_that_no_loop_names_is_performed_at_once);
    RUN_TEST(without_a_configuration_requests_are_performed_at_once);
    RUN_TEST(a_request_performed_in_the_loop_is_refused_like_any_other);
    RUN_TEST(a_full_inbox_refuses_with_the_number_of_waiting_requests);
    RUN_TEST(no_report_of_the_longest_request_is_lost);
    RUN_TEST(queued_requests_are_performed_before_the_configuration_ends);
    RUN_TEST(another_configuration_may_be_selected_with_requests_waiting);
    RUN_TEST(answers_wait_while_the_port_is_closed);
    RUN_TEST(a_mailbox_without_room_keeps_requests_waiting);
    RUN_TEST(reports_that_a_loop_lost_are_counted_in_the_health);
    return UNITY_END();
}
