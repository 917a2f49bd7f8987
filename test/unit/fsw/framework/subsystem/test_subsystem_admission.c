// SPDX-License-Identifier: Apache-2.0
// While the port refuses reports, requests are accepted as long as all their reports have room, and no report
// is lost. Of the reports about many refused instructions of one request only the first ones may be kept.
#include "pus/core/tailoring.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

void setUp(void)
{
    fixture_open(NULL);
    fixture_forget();
}

void tearDown(void)
{
    fixture_close();
}

static uint32_t reports_lost(void)
{
    subsystem_health_t health;
    subsystem_health(&fixture.subsystem, &health);
    return health.reports_lost;
}

/// Send requests of one kind until the component accepts no more. Returns their number.
static unsigned fill(const uint8_t service, const uint8_t subtype, const void* const data, const size_t size)
{
    unsigned taken = 0U;
    while (subsystem_may_accept(&fixture.subsystem) && (taken < 1000U)) {
        (void)fixture_command(service, subtype, data, size);
        taken++;
    }
    return taken;
}

static void an_accepted_request_receives_all_its_answers(void)
{
    for (unsigned round = 0U; round < 3U; round++) { // After each round the room is free again.
        fixture.is_port_closed = true;
        const unsigned taken   = fill(PUS_SERVICE_TEST, 1U, NULL, 0U);
        TEST_ASSERT_TRUE((taken >= 8U) && (taken < 1000U));
        fixture.is_port_closed = false;
        TEST_ASSERT_TRUE(subsystem_may_accept(&fixture.subsystem));
        const char* const lines = fixture_look();
        TEST_ASSERT_EQUAL(taken, fixture_count(lines, "1.1 #"));
        TEST_ASSERT_EQUAL(taken, fixture_count(lines, "1.3 #"));
        TEST_ASSERT_EQUAL(taken, fixture_count(lines, "17.2"));
        TEST_ASSERT_EQUAL(taken, fixture_count(lines, "1.7 #"));
    }
    TEST_ASSERT_EQUAL(0U, reports_lost());
}

static void a_high_event_leaves_room_for_the_report_of_its_transition(void)
{
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(40U);
    fixture_forget();
    fixture.is_port_closed = true;
    for (unsigned i = 0U; i < 10000U; i++) {
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U);
    }
    (void)fill(PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\0\7", 2U);
    fixture.is_port_closed = false;
    fixture_run(1U);
    const char* const lines = fixture_look();
    TEST_ASSERT_NOT_NULL(strstr(lines, "5.4 event 1 aux 0007"));
    TEST_ASSERT_NOT_NULL(strstr(lines, "129.2 "));
    TEST_ASSERT_TRUE(strstr(lines, "5.4 event 1") < strstr(lines, "5.2 event 3"));
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.process.counters.lost_firm);
}

static void no_request_is_read_while_an_answer_is_unfinished(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.is_port_closed = true;
    // TC[3,9] names a set of structures.
    const uint16_t list = fixture_command(PUS_SERVICE_HOUSEKEEPING, 9U, "\1\0\x64", 3U);
    TEST_ASSERT_TRUE(pus_dispatcher_is_answering(&fixture.subsystem.dispatcher));
    TEST_ASSERT_FALSE(subsystem_may_accept(&fixture.subsystem));
    const uint64_t wake_ns = subsystem_step(&fixture.subsystem, fixture.now_ns);
    // The component tries to send the answer again in the next cycle.
    TEST_ASSERT_TRUE(wake_ns <= (fixture.now_ns + subsystem_period_ns(&fixture.subsystem)));
    fixture.is_port_closed = false;
    fixture_run(1U);
    TEST_ASSERT_TRUE(subsystem_may_accept(&fixture.subsystem));
    char line[32];
    (void)snprintf(line, sizeof line, "1.1 #%u\n", list);
    TEST_ASSERT_EQUAL(1U, fixture_count(fixture_look(), line));
    TEST_ASSERT_EQUAL(0U, reports_lost());
}

static void waiting_events_do_not_prevent_requests(void)
{
    fixture.is_port_closed = true;
    for (unsigned i = 0U; i < 10000U; i++) {
        (void)subsystem_raise(&fixture.subsystem, FIXTURE_NOTE, NULL, 0U);
    }
    TEST_ASSERT_TRUE(subsystem_may_accept(&fixture.subsystem));
}

static void the_first_of_many_refused_instructions_and_their_number_are_reported(void)
{
    uint8_t ids[1U + (2U * PUS_COUNT_MAX)] = {PUS_COUNT_MAX};
    ids[2]                                 = FIXTURE_NOTE; // Only the first id is that of an event.
    for (unsigned i = 1U; i < PUS_COUNT_MAX; i++) {
        ids[1U + (2U * i)] = 0x7FU;
    }
    fixture.is_port_closed = true;
    const unsigned taken   = fill(PUS_SERVICE_EVENTS, 6U, ids, sizeof ids);
    TEST_ASSERT_TRUE(taken >= 1U);
    fixture.is_port_closed = false;
    fixture_run(1U);
    const char* const lines = fixture_look();
    TEST_ASSERT_EQUAL(taken, fixture_count(lines, "1.8 #"));
    // PUS_FAILURE_SOME_FAILED, with the number of instructions that failed: 254.
    TEST_ASSERT_EQUAL(taken, fixture_count(lines, " 0407 FE\n"));
    const unsigned reported = fixture_count(lines, "1.4 #");
    TEST_ASSERT_TRUE((reported >= taken) && (reported < 254U));
    TEST_ASSERT_EQUAL((254U * taken) - reported, reports_lost());
    fixture_forget();
    // The same request with the port open: all its reports are sent.
    (void)fixture_command(PUS_SERVICE_EVENTS, 6U, ids, sizeof ids);
    TEST_ASSERT_EQUAL(254U, fixture_count(fixture_look(), "1.4 #"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_accepted_request_receives_all_its_answers);
    RUN_TEST(a_high_event_leaves_room_for_the_report_of_its_transition);
    RUN_TEST(no_request_is_read_while_an_answer_is_unfinished);
    RUN_TEST(waiting_events_do_not_prevent_requests);
    RUN_TEST(the_first_of_many_refused_instructions_and_their_number_are_reported);
    return UNITY_END();
}
