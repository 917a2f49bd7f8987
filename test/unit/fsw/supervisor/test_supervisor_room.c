// SPDX-License-Identifier: Apache-2.0
// The link manager handles an end that has no room for its request, a request for a link that is just being
// opened, and a stale link. Frames that a carrier cannot take now are sent later, in their order.
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    fixture_open_up();
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture_forget();
}

void tearDown(void)
{
    fixture_close();
}

static void expect_no_session(void)
{
    for (unsigned i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        TEST_ASSERT_EQUAL(SESSION_FREE, fixture.supervisor.sessions[i].step);
    }
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
}

static void a_link_is_refused_if_its_producer_has_no_room(void)
{
    fixture_fill(FIXTURE_ARM);
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 0000000705")); // PUS_LINK_REASON_RESOURCE.
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    expect_no_session();
}

static void a_consumer_without_room_ends_the_negotiation(void)
{
    fixture_fill(FIXTURE_HAND);
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.3"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001")); // The manager closes the end that has accepted.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0402 11\n")); // PUS_FAILURE_NO_ANSWER: HAND.
    expect_no_session();
}

static void a_link_is_not_opened_if_an_end_has_no_room(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture_fill(FIXTURE_ARM);
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0402 10\n")); // PUS_FAILURE_NO_ANSWER: ARM.
    expect_no_session();
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    fixture_run(3U);
    fixture_fill(FIXTURE_HAND);
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.6 0001"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));          // The manager closes the end that is open.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0402 11\n")); // PUS_FAILURE_NO_ANSWER: HAND.
    expect_no_session();
}

static void a_link_that_is_being_opened_is_neither_closed_nor_opened_again(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    fixture_forget();
    const uint16_t closing = fixture_close_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, closing);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #2 0204 1")); // PUS_FAILURE_STATE.
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #3 0204 1"));
}

static void a_stale_link_is_reported_as_stale(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_STALE);
    fixture_run(1U);
    fixture_forget();
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\1\0\1", 3U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 130.9 00010001040010000100110002")); // PUS_LINK_STATE_STALE.
}

static message_carrier_t inner;
static unsigned refusals; // Frames to `communication` that the carrier still refuses.

static status_t send_if_room(void* context, uint16_t to, const uint8_t* frame, size_t size)
{
    if ((to == COMMUNICATION_APID) && (refusals > 0U)) {
        refusals--;
        return STATUS_FULL;
    }
    return inner.send(context, to, frame, size);
}

static void a_failed_start_does_not_change_the_order_of_frames_that_wait(void)
{
    static const uint8_t lone[2] = {0U, LONE};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_STOP_PROCESS, lone, sizeof lone);
    fixture_run(2U);
    fixture_forget();
    fixture.start_result          = STATUS_NOT_FOUND;
    inner                         = fixture.endpoint.carrier;
    fixture.endpoint.carrier.send = send_if_room;
    refusals                      = 1U; // TM[1,1] waits. The start fails before TM[1,7] is sent.
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_START_PROCESS, lone, sizeof lone);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(0U, refusals);
    fixture_expect("G 1.1 #1\nG 1.3 #1\nG 1.7 #1\nG 131.2 010001\nG 5.1 00040100\n");
    TEST_ASSERT_EQUAL(0U, fixture.members[FIXTURE_GROUND].endpoint.counters.lost);
    TEST_ASSERT_EQUAL(PROCESS_LOST, fixture.supervisor.registry[2].process);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_link_is_refused_if_its_producer_has_no_room);
    RUN_TEST(a_consumer_without_room_ends_the_negotiation);
    RUN_TEST(a_link_is_not_opened_if_an_end_has_no_room);
    RUN_TEST(a_link_that_is_being_opened_is_neither_closed_nor_opened_again);
    RUN_TEST(a_stale_link_is_reported_as_stale);
    RUN_TEST(a_failed_start_does_not_change_the_order_of_frames_that_wait);
    return UNITY_END();
}
