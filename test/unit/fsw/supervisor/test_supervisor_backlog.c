// SPDX-License-Identifier: Apache-2.0
// Communication dies and is started again: reports wait in order meanwhile, and reports without room are
// counted.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static mission_subsystem_t* ground(void)
{
    return (mission_subsystem_t*)supervisor_registry_find(&fixture.supervisor, COMMUNICATION_APID)->mission;
}

static void kill_communication(void)
{
    fixture.members[FIXTURE_GROUND].is_running = false;
    fixture_run(1U);
}

/// Kill communication twice: after the second death, the supervisor does not restart it before 100 ms have
/// passed.
static void leave_communication_dead(void)
{
    ground()->restart_budget = 3U;
    kill_communication();
    fixture_run(100U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_is_empty(&fixture.supervisor.ground_backlog));
    kill_communication();
    TEST_ASSERT_EQUAL(PROCESS_LOST,
                      supervisor_registry_find(&fixture.supervisor, COMMUNICATION_APID)->process);
    fixture_forget();
}

static void expect_communication_restarted(void)
{
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    fixture_run(100U);
    TEST_ASSERT_EQUAL(2U, fixture.starts);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_is_empty(&fixture.supervisor.ground_backlog));
}

static void report_firm(uint16_t number)
{
    const uint8_t data[4] = {0x18U, ARM, (uint8_t)(0xC0U | (number >> 8U)), (uint8_t)number};
    fixture_report(FIXTURE_ARM, PUS_SERVICE_VERIFICATION, 7U, data, sizeof data);
}

static void report_number(uint8_t service, uint8_t subtype, uint16_t number)
{
    const uint8_t data[2] = {(uint8_t)(number >> 8U), (uint8_t)number};
    fixture_report(FIXTURE_ARM, service, subtype, data, sizeof data);
}

typedef struct {
    const char* start;  // Beginning of the lines.
    const char* format; // Format of the number after it.
    unsigned count;
    unsigned last;
} arrivals_t;

/// Find the lines of one kind; each must have a higher number than the line before.
static arrivals_t arrivals_of(const char* text, const char* start, const char* format)
{
    arrivals_t found = {start, format, 0U, 0U};
    for (const char* at = strstr(text, start); at != NULL; at = strstr(at + 1U, start)) {
        unsigned number = 0U;
        TEST_ASSERT_EQUAL(1, sscanf(at + strlen(start), format, &number));
        TEST_ASSERT_TRUE_MESSAGE((found.count == 0U) || (number > found.last), start);
        found.last = number;
        found.count++;
    }
    return found;
}

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void reports_wait_in_order_while_communication_is_down(void)
{
    char expected[2048] = "";
    leave_communication_dead();
    for (uint16_t i = 0U; i < 20U; i++) { // Fewer than a window.
        report_number(PUS_SERVICE_EVENTS, PUS_SEVERITY_INFORMATIVE, (uint16_t)(1000U + i));
        report_firm(i);
        report_number(PUS_SERVICE_HOUSEKEEPING, 26U, i);
        fixture_step();
        (void)snprintf(&expected[strlen(expected)], 80U, "G/16 5.1 %04X\nG/16 1.7 #%u\nG/16 3.26 %04X\n",
                       1000U + i, i, i);
    }
    fixture_expect("");
    expect_communication_restarted();
    char found[2048] = "";
    for (const char* at = strstr(fixture_look(), "G/16"); at != NULL; at = strstr(at + 1U, "G/16")) {
        (void)strncat(found, at, strcspn(at, "\n") + 1U);
    }
    TEST_ASSERT_EQUAL_STRING(expected, found);
}

static void dropped_reports_are_counted_and_no_firm_report_is_lost(void)
{
    leave_communication_dead();
    const supervisor_ground_t before = fixture.supervisor.ground;
    for (uint16_t i = 0U; i < 240U; i++) {
        report_number(PUS_SERVICE_EVENTS, PUS_SEVERITY_INFORMATIVE, (uint16_t)(1000U + i));
        report_firm(i);
        report_number(PUS_SERVICE_HOUSEKEEPING, 26U, i);
        fixture_step();
    }
    const supervisor_ground_t now = fixture.supervisor.ground;
    expect_communication_restarted();
    const char* const text = fixture_look();
    const arrivals_t firm  = arrivals_of(text, "G/16 1.7 #", "%u");
    const arrivals_t plain = arrivals_of(text, "G/16 5.1 ", "%4X");
    const arrivals_t bulk  = arrivals_of(text, "G/16 3.26 ", "%4X");
    // GROUND_BEHIND is itself a PLAIN report.
    const arrivals_t behind = arrivals_of(text, "G 5.2 0028", "%c");
    TEST_ASSERT_EQUAL(240U, firm.count);
    TEST_ASSERT_EQUAL_UINT32(before.dropped_firm, fixture.supervisor.ground.dropped_firm);
    TEST_ASSERT_EQUAL_UINT32(241U, plain.count + behind.count + (now.dropped_plain - before.dropped_plain));
    TEST_ASSERT_EQUAL_UINT32(240U, bulk.count + (now.dropped_bulk - before.dropped_bulk));
    // Of the 768 smallest blocks, 256 are reserved for FIRM reports.
    TEST_ASSERT_TRUE((plain.count + bulk.count) <= 512U);
    TEST_ASSERT_TRUE((plain.count >= 200U) && (bulk.count >= 60U));
    fixture_forget();
    report_firm(7U); // The supervisor works as before.
    fixture_run(1U);
    fixture_expect("G/16 1.7 #7\n");
}

/// More FIRM reports than have room: the first ones arrive, the others are counted.
static void the_first_of_too_many_firm_reports_are_kept(void)
{
    leave_communication_dead();
    for (uint16_t i = 0U; i < 600U; i++) {
        report_firm(i);
        fixture_step();
    }
    TEST_ASSERT_FALSE(supervisor_ground_takes_requests(&fixture.supervisor));
    expect_communication_restarted();
    const arrivals_t firm = arrivals_of(fixture_look(), "G/16 1.7 #", "%u");
    TEST_ASSERT_TRUE((firm.count > 500U) && (firm.count <= GROUND_FIRM_REPORTS));
    TEST_ASSERT_EQUAL(firm.count - 1U, firm.last);
    TEST_ASSERT_EQUAL_UINT32(600U, firm.count + fixture.supervisor.ground.dropped_firm);
    TEST_ASSERT_TRUE(supervisor_ground_takes_requests(&fixture.supervisor));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reports_wait_in_order_while_communication_is_down);
    RUN_TEST(dropped_reports_are_counted_and_no_firm_report_is_lost);
    RUN_TEST(the_first_of_too_many_firm_reports_are_kept);
    return UNITY_END();
}
