// SPDX-License-Identifier: Apache-2.0
// The manager of real-time links: sessions with two members, the end of sessions, and the graph of open
// links.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
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

static unsigned edges(void)
{
    return fixture.supervisor.graph.count;
}

static unsigned sessions(void)
{
    unsigned count = 0U;
    for (unsigned i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        count += (fixture.supervisor.sessions[i].step != SESSION_FREE) ? 1U : 0U;
    }
    return count;
}

/// The line of TC[130,3] to a member without transaction and properties: link, producer, port, consumer,
/// port.
static bool was_asked(const char* text, unsigned apid, const char* link_and_ends)
{
    char start[32];
    (void)snprintf(start, sizeof start, "%u TC 130.3 ", apid);
    for (const char* line = strstr(text, start); line != NULL; line = strstr(line + 1, start)) {
        if (strncmp(line + strlen(start) + 8U, link_and_ends, strlen(link_and_ends)) == 0) {
            return true;
        }
    }
    return false;
}

// ---- Negotiation and opening ----

static void both_ends_agree_then_open_with_one_epoch(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    const char* text = fixture_look();
    TEST_ASSERT_TRUE(was_asked(text, ARM, "00010010000100110002"));
    TEST_ASSERT_TRUE(was_asked(text, HAND, "00010010000100110002"));
    // The producer is requested first.
    TEST_ASSERT_TRUE(strstr(text, "16 TC 130.3") < strstr(text, "17 TC 130.3"));
    // The last agreed record, with the transaction number of the requester: link 1, depth increased by each
    // member.
    TEST_ASSERT_NOT_NULL(strstr(text, "G 130.4 000000070001000000000000000800000003E800000003"));
    TEST_ASSERT_NOT_NULL(strstr(text, "G 1.7 #0"));
    TEST_ASSERT_EQUAL(0U, edges());
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    text = fixture_look();
    // Link and epoch.
    const char* const first  = strstr(text, "16 TC 130.6 000100000001 ");
    const char* const second = strstr(text, "17 TC 130.6 000100000001 ");
    TEST_ASSERT_TRUE((first != NULL) && (second != NULL) && (first < second));
    TEST_ASSERT_NOT_NULL(strstr(text, "G 1.7 #1"));
    TEST_ASSERT_EQUAL(1U, edges());
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void each_opening_has_an_epoch_of_its_own(void)
{
    for (unsigned i = 1U; i <= 3U; i++) {
        char expected[64];
        (void)fixture_request_link(LINK_ARM_STATE);
        fixture_run(5U);
        (void)fixture_open_link(LINK_ARM_STATE);
        fixture_run(5U);
        (void)snprintf(expected, sizeof expected, "16 TC 130.6 0001%08X", i);
        TEST_ASSERT_TRUE(fixture_has(expected));
        fixture_forget();
    }
}

static void two_links_are_negotiated_at_once(void)
{
    (void)fixture_request_link(LINK_ARM_STATE); // The ground uses the same transaction number for both.
    (void)fixture_request_link(LINK_HAND_POS);
    fixture_run(6U);
    const char* const text = fixture_look(); // Each request is answered with its own link.
    TEST_ASSERT_NOT_NULL(strstr(text, "G 130.4 000000070001000000000000000800000003E80000000300000000"
                                      "0000\nG 1.7 #0\n"));
    TEST_ASSERT_NOT_NULL(strstr(text, "G 130.4 000000070002000000000000000800000003E80000000300000000"
                                      "0000\nG 1.7 #1\n"));
    (void)fixture_open_link(LINK_HAND_POS);
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(6U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #2"));
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #3"));
    TEST_ASSERT_EQUAL(2U, edges());
    TEST_ASSERT_EQUAL(
        ARM, supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE)->ends.producer_apid);
    TEST_ASSERT_EQUAL(
        HAND, supervisor_link_graph_find(&fixture.supervisor.graph, LINK_HAND_POS)->ends.producer_apid);
}

// ---- Refusals ----

static void impossible_requests_are_refused(void)
{
    fixture_put_in_state(FIXTURE_HAND, STATE_SAFE_OPERATIONAL);
    fixture_forget();
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 000000070600")); // Reason: state.
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0409 600"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE); // This link was not negotiated.
    (void)fixture_open_link(0U);
    (void)fixture_open_link(99U);
    (void)fixture_close_link(LINK_ARM_STATE);
    (void)fixture_close_link(0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #1 0201 1"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #2 0201 0"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #3 0201 63"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #4 0201 1"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #5 0201 0"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
}

static void links_outside_the_mission_are_denied(void)
{
    uint8_t data[64];
    octet_writer_t writer            = octet_writer(data, sizeof data);
    const pus_link_request_t request = {.transaction = 7U, .ends = {ARM, 1U, LONE, 2U}};
    pus_link_request_write(&writer, &request);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_REQUEST, data, writer.position);
    fixture_run(2U);
    fixture_expect("G 1.2 #0 0110 105\n");
}

static void a_member_s_refusal_is_passed_on(void)
{
    fixture.members[FIXTURE_HAND].refuses_links = PUS_LINK_REASON_PERIOD;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 000000070304"));
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0409 304"));
    // The manager releases the producer, which had accepted.
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(0U, sessions());
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE); // This link was not agreed.
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #1 0201 1"));
    fixture.members[FIXTURE_HAND].refuses_links = 0U;
    fixture.members[FIXTURE_ARM].refuses_links  = PUS_LINK_REASON_LAYOUT;
    fixture_forget();
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 000000070104"));
    TEST_ASSERT_FALSE(fixture_has("17 TC")); // The consumer got no request.
}

static void one_link_has_one_session(void)
{
    fixture.members[FIXTURE_ARM].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(2U);
    fixture_forget();
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 130.5 000000070500")); // Reason: resource.
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0409 500"));
    TEST_ASSERT_EQUAL(1U, sessions());
}

/// The members would refuse to open the link again, and the session would close it at its time-out.
static void an_open_link_is_not_opened_again(void)
{
    char expected[64];
    fixture_link_up(STATE_OPERATIONAL);
    const uint16_t number = fixture_open_link(LINK_ARM_STATE);
    fixture_run(250U);
    (void)snprintf(expected, sizeof expected, "G 1.4 #%u 0204 1\n", number);
    TEST_ASSERT_TRUE(fixture_has(expected));
    TEST_ASSERT_FALSE(fixture_has("TC 130."));
    TEST_ASSERT_EQUAL(2U, edges());
    TEST_ASSERT_EQUAL(0U, sessions());
}

/// Two users open the same link at once.
static void a_link_that_is_being_opened_is_not_opened_twice(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture.source = 3U;
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #1\n"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #2 0204 1\n"));
    TEST_ASSERT_EQUAL(1U, edges());
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void without_a_free_session_a_link_is_neither_opened_nor_closed(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture_forget();
    for (uint16_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        fixture.supervisor.sessions[i] =
            (link_session_t){.step = SESSION_CLOSING, .link = (uint16_t)(20U + i), .deadline_ns = UINT64_MAX};
    }
    (void)fixture_open_link(LINK_ARM_STATE);
    (void)fixture_close_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #1 0205 8\n"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #2 0205 8\n"));
    TEST_ASSERT_FALSE(fixture_has("TC 130."));
    fixture.supervisor.sessions[SUPERVISOR_LINK_SESSIONS - 1U].step = SESSION_FREE;
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #3\n"));
}

// ---- Members that do not answer ----

static void a_silent_member_ends_the_session_in_time(void)
{
    static const unsigned silent[] = {FIXTURE_ARM, FIXTURE_HAND};
    for (unsigned i = 0U; i < 2U; i++) {
        char expected[64];
        fixture.members[silent[i]].ignores_links = true;
        const uint16_t number                    = fixture_request_link(LINK_ARM_STATE);
        fixture_run(199U);
        (void)snprintf(expected, sizeof expected, "G 1.8 #%u 0406 7D0", number);
        TEST_ASSERT_FALSE(fixture_has(expected));
        fixture_run(6U);
        TEST_ASSERT_TRUE(fixture_has(expected));
        TEST_ASSERT_EQUAL(0U, sessions());
        fixture.members[silent[i]].ignores_links = false;
        fixture_forget();
    }
}

static void every_session_ends_in_time(void)
{
    fixture.members[FIXTURE_ARM].ignores_links  = true;
    fixture.members[FIXTURE_HAND].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    (void)fixture_request_link(LINK_HAND_POS);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(2U, sessions());
    fixture_run(205U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0406"));
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0406"));
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void a_member_that_dies_ends_its_sessions_at_once(void)
{
    fixture.members[FIXTURE_HAND].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(4U);
    TEST_ASSERT_EQUAL(1U, sessions());
    fixture.members[FIXTURE_LONE].is_running = false; // LONE is not a member of the link.
    fixture_run(3U);
    TEST_ASSERT_EQUAL(1U, sessions());
    fixture_forget();
    fixture.members[FIXTURE_HAND].is_running = false;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0408 11"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void an_end_that_does_not_open_leaves_the_other_closed(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture.members[FIXTURE_HAND].ignores_links = true;
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(210U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0406 7D0"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001")); // The producer must not stay open without a reader.
    TEST_ASSERT_EQUAL(0U, edges());
    fixture.members[FIXTURE_HAND].ignores_links = false;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture.members[FIXTURE_HAND].fails_to_open = true;
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #3 0404 11"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(0U, edges());
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void a_producer_that_fails_to_open_ends_the_session(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture.members[FIXTURE_ARM].fails_to_open = true;
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0404 10"));
    TEST_ASSERT_FALSE(fixture_has("17 TC 130.6"));
    TEST_ASSERT_EQUAL(0U, edges());
}

// ---- Closing ----

static void closing_a_link_closes_both_ends(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    const uint16_t number = fixture_close_link(LINK_ARM_STATE);
    fixture_run(5U);
    char expected[64];
    (void)snprintf(expected, sizeof expected, "G 1.7 #%u", number);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 000100"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 000100"));
    TEST_ASSERT_TRUE(fixture_has(expected));
    TEST_ASSERT_EQUAL(1U, edges());
    TEST_ASSERT_EQUAL(0U, sessions());
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE); // The link has to be negotiated again.
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0201 1\n"));
}

static void closing_ends_although_no_member_answers(void)
{
    char expected[64];
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    const uint16_t number                      = fixture_close_link(LINK_ARM_STATE);
    fixture_run(210U);
    (void)snprintf(expected, sizeof expected, "G 1.8 #%u 0406 7D0", number);
    TEST_ASSERT_TRUE(fixture_has(expected));
    TEST_ASSERT_EQUAL(1U, edges());
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0201 1\n"));
}

static void a_negotiated_link_can_be_closed_before_it_is_opened(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture_forget();
    (void)fixture_close_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #1"));
    TEST_ASSERT_EQUAL(0U, sessions());
}

static void closing_one_end_closes_the_other(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_ARM, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00010A")); // Reason: peer.
    TEST_ASSERT_FALSE(fixture_has("16 TC 130.7"));
    TEST_ASSERT_EQUAL(1U, edges());
    TEST_ASSERT_NULL(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE));
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE); // The session no longer exists.
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0201 1\n"));
}

static void an_end_that_closes_by_itself_receives_no_request_to_close(void)
{
    static const state_t downwards[] = {STATE_OFFLINE, STATE_POST_OPERATIONAL};
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_ARM, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_run(10U);
    TEST_ASSERT_FALSE(fixture_has("16 TC 130.7"));
    TEST_ASSERT_FALSE(fixture_has("17 TC 130.7"));
    for (unsigned i = 0U; i < 2U; i++) { // In this state the member closes all its links.
        tearDown();
        setUp();
        fixture_link_up(STATE_PRE_OPERATIONAL);
        fixture_put_in_state(FIXTURE_HAND, downwards[i]);
        fixture_link_changed(FIXTURE_ARM, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
        fixture_run(10U);
        TEST_ASSERT_FALSE(fixture_has("17 TC 130.7"));
    }
}

static void a_close_that_waits_comes_before_a_new_agreement(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_ARM, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00010A"));
    fixture_run(4U);
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(2U, edges());
}

static void an_expired_agreement_is_removed(void)
{
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(5U);
    fixture_forget();
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_ACCEPTED, PUS_LINK_STATE_CLOSED);
    fixture_run(3U);
    // The other end does not have to wait for its own deadline.
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #1 0201 1"));
}

static void a_lost_member_closes_its_links(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00010A"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00020A"));
    TEST_ASSERT_EQUAL(0U, edges());
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE); // The agreement with the dead process is no longer valid.
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0201 1\n"));
}

static void staleness_is_kept_in_the_graph(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_STALE);
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_ACCEPTED, PUS_LINK_STATE_OPEN);
    fixture_run(1U);
    TEST_ASSERT_TRUE(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE)->is_stale);
    fixture_link_changed(FIXTURE_HAND, LINK_ARM_STATE, PUS_LINK_STATE_STALE, PUS_LINK_STATE_OPEN);
    fixture_run(1U);
    TEST_ASSERT_FALSE(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE)->is_stale);
}

// ---- Invalid reports of members ----

static void answers_of_uninvolved_subsystems_are_ignored(void)
{
    pus_link_accept_t accepted                 = {.transaction = 1U, .link = LINK_ARM_STATE};
    fixture.members[FIXTURE_ARM].ignores_links = true;
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_run(2U);
    fixture_forget();
    for (uint32_t transaction = 0U; transaction < 20U; transaction++) {
        accepted.transaction = transaction;
        (void)pus_link_accept_report(&fixture.members[FIXTURE_LONE].process, 0x8001U, &accepted,
                                     fixture.now_ns);
        (void)pus_link_accept_report(&fixture.members[FIXTURE_HAND].process, 0x8001U, &accepted,
                                     fixture.now_ns);
    }
    fixture_link_changed(FIXTURE_LONE, LINK_ARM_STATE, PUS_LINK_STATE_ACCEPTED, PUS_LINK_STATE_OPEN);
    fixture_link_changed(FIXTURE_ARM, 99U, PUS_LINK_STATE_ACCEPTED, PUS_LINK_STATE_OPEN);
    fixture_link_changed(FIXTURE_ARM, 0U, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_link_changed(FIXTURE_ARM, 0xFFFFU, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, sessions());
    TEST_ASSERT_EQUAL(0U, edges());
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
}

static void a_subsystem_outside_a_link_cannot_close_it(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture_link_changed(FIXTURE_LONE, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_link_changed(FIXTURE_LONE, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_STALE);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(2U, edges());
    TEST_ASSERT_FALSE(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_ARM_STATE)->is_stale);
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
}

static void the_manager_reports_its_links(void)
{
    fixture_link_up(STATE_PRE_OPERATIONAL);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\1\0\2", 3U);
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "G 130.9 00010002030011000100100002"));
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_REPORT_NETWORKS, NULL, 0U);
    fixture_run(2U);
    // One network, number 16, of 16 and 17, links 1 and 2.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "G 131.11 00010010000200100011000200010002"));
}

/// Only a request for a higher state requires open links.
static void a_request_for_the_present_state_needs_no_link(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_SAFE_OPERATIONAL);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 04 from 1"));
    TEST_ASSERT_FALSE(fixture_has("G 1.2"));
}

/// In a mission with the maximum number of links, the last one is negotiated, opened and closed as any other.
static void the_last_link_of_a_mission_is_negotiated_opened_and_closed(void)
{
    static const uint16_t last          = MISSION_LINKS_MAX;
    supervisor_t* const supervisor      = &fixture.supervisor;
    mission_descriptor_t* const mission = (mission_descriptor_t*)supervisor->mission;
    const uint16_t link_count           = mission->link_count;
    for (uint16_t i = link_count; i < last; i++) {
        mission->storage.links[i] = (mission_link_t){.number        = (uint16_t)(i + 1U),
                                                     .producer_apid = ARM,
                                                     .producer_port = 1U,
                                                     .consumer_apid = HAND,
                                                     .consumer_port = (uint16_t)(100U + i)};
    }
    mission->link_count                       = last;
    supervisor->wanted[last - 1U].layout_size = 8U;
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(supervisor, last)); // First, the link is negotiated.
    fixture_run(5U);
    TEST_ASSERT_EQUAL(last, supervisor->accepted[last - 1U].link);
    TEST_ASSERT_EQUAL(0U, sessions());
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(supervisor, last)); // Then it is opened.
    fixture_run(5U);
    TEST_ASSERT_NOT_NULL(supervisor_link_graph_find(&supervisor->graph, last));
    fixture_forget();
    fixture_link_changed(FIXTURE_ARM, last, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00200A"));
    TEST_ASSERT_EQUAL(0U, edges());
    TEST_ASSERT_EQUAL(0U, supervisor->accepted[last - 1U].link);
    TEST_ASSERT_TRUE(supervisor_link_manager_renew(supervisor, last));
    fixture_run(5U);
    fixture_forget();
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00200A"));
    TEST_ASSERT_EQUAL(0U, supervisor->accepted[last - 1U].link);
    mission->link_count = link_count;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_for_the_present_state_needs_no_link);
    RUN_TEST(the_last_link_of_a_mission_is_negotiated_opened_and_closed);
    RUN_TEST(both_ends_agree_then_open_with_one_epoch);
    RUN_TEST(each_opening_has_an_epoch_of_its_own);
    RUN_TEST(two_links_are_negotiated_at_once);
    RUN_TEST(impossible_requests_are_refused);
    RUN_TEST(links_outside_the_mission_are_denied);
    RUN_TEST(a_member_s_refusal_is_passed_on);
    RUN_TEST(one_link_has_one_session);
    RUN_TEST(an_open_link_is_not_opened_again);
    RUN_TEST(a_link_that_is_being_opened_is_not_opened_twice);
    RUN_TEST(without_a_free_session_a_link_is_neither_opened_nor_closed);
    RUN_TEST(a_silent_member_ends_the_session_in_time);
    RUN_TEST(every_session_ends_in_time);
    RUN_TEST(a_member_that_dies_ends_its_sessions_at_once);
    RUN_TEST(an_end_that_does_not_open_leaves_the_other_closed);
    RUN_TEST(a_producer_that_fails_to_open_ends_the_session);
    RUN_TEST(closing_a_link_closes_both_ends);
    RUN_TEST(closing_ends_although_no_member_answers);
    RUN_TEST(a_negotiated_link_can_be_closed_before_it_is_opened);
    RUN_TEST(closing_one_end_closes_the_other);
    RUN_TEST(an_end_that_closes_by_itself_receives_no_request_to_close);
    RUN_TEST(a_close_that_waits_comes_before_a_new_agreement);
    RUN_TEST(an_expired_agreement_is_removed);
    RUN_TEST(a_lost_member_closes_its_links);
    RUN_TEST(staleness_is_kept_in_the_graph);
    RUN_TEST(answers_of_uninvolved_subsystems_are_ignored);
    RUN_TEST(a_subsystem_outside_a_link_cannot_close_it);
    RUN_TEST(the_manager_reports_its_links);
    return UNITY_END();
}
