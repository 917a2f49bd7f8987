// SPDX-License-Identifier: Apache-2.0
// Routing in both directions, refusals and their codes, permission, and the conditions for higher states.
#include "fsw/supervisor/supervisor.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

// ---- Routing ----

static void requests_reach_subsystems_and_reports_reach_the_ground(void)
{
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_expect("16 TC 17.1 from 1\nG/16 1.1 #0\nG/16 1.3 #0\nG/16 1.7 #0\n");
    fixture_report(FIXTURE_HAND, PUS_SERVICE_HOUSEKEEPING, 26U, "abc", 3U);
    fixture_run(1U);
    fixture_expect("G/17 3.26 616263\n");
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    fixture_expect("G 1.1 #1\nG 1.3 #1\nG 17.2 \nG 1.7 #1\n");
}

static void every_packet_is_logged_in_both_directions(void)
{
    const uint64_t before = fixture.supervisor.log.next_number;
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(before + 4U, fixture.supervisor.log.next_number);
    const char* const text = fixture_log_file("packets.ascii");
    TEST_ASSERT_NOT_NULL(strstr(text, " TC 1810c000"));
    TEST_ASSERT_EQUAL(0, strncmp(text, "1 0.000000000 TM 0801c000", 25U)); // The supervisor's first report.
}

static void a_refused_request_is_logged_too(void)
{
    const uint64_t before = fixture.supervisor.log.next_number;
    (void)fixture_tc(99U, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(before + 2U, fixture.supervisor.log.next_number);
}

// ---- Malformed requests ----

/// Returns a correct TC[17,1] to ARM of user 1 with number 0x155, to be changed.
static size_t good_request(uint8_t packet[64])
{
    size_t size       = 0U;
    const pus_tc_t tc = {
        .apid = ARM, .sequence = 0x155U, .ack = 15U, .service = 17U, .subtype = 1U, .source = 1U};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, 64U, &size));
    return size;
}

/// Compute the CRC-16 of the standard bit by bit.
static void checksum(uint8_t* packet, size_t size)
{
    uint16_t crc = 0xFFFFU;
    for (size_t i = 0U; i < (size - 2U); i++) {
        crc ^= (uint16_t)(packet[i] << 8U);
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = (uint16_t)((uint32_t)(crc << 1U) ^ (((crc & 0x8000U) != 0U) ? 0x1021U : 0U));
        }
    }
    packet[size - 2U] = (uint8_t)(crc >> 8U);
    packet[size - 1U] = (uint8_t)crc;
}

static void spoil_and_expect(size_t octet, uint8_t value, const char* lines)
{
    uint8_t packet[64];
    const size_t size = good_request(packet);
    packet[octet]     = value;
    checksum(packet, size);
    fixture_send(FIXTURE_GROUND, packet, size);
    fixture_run(2U);
    fixture_expect(lines);
}

static void each_malformed_packet_is_refused_with_its_code(void)
{
    uint8_t packet[64];
    const size_t size = good_request(packet);
    packet[12] ^= 1U; // The checksum is wrong.
    fixture_send(FIXTURE_GROUND, packet, size);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #341 0102"));
    fixture_forget();
    spoil_and_expect(5U, 7U, "G 1.2 #341 0101 D\n");    // Length field.
    spoil_and_expect(0U, 0x38U, "G 1.2 #341 010A 1\n"); // Packet version.
    spoil_and_expect(0U, 0x10U, "G 1.2 #341 010C 0\n"); // Secondary header.
    spoil_and_expect(2U, 0x41U, "G 1.2 #341 010D 1\n"); // Sequence flags.
    spoil_and_expect(6U, 0x1FU, "G 1.2 #341 0103 1\n"); // PUS version.
    spoil_and_expect(10U, 2U, "G 1.2 #341 0107 2\n");   // This user does not exist in the mission.
    spoil_and_expect(10U, 0U, "G 1.2 #341 0107 0\n");   // 0 means all users and cannot be a source.
    TEST_ASSERT_EQUAL(6U, fixture.supervisor.counters.tc_malformed);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.counters.tc_forbidden);
}

static void a_truncated_request_is_reported_if_it_contains_its_number(void)
{
    uint8_t packet[64];
    for (size_t cut = good_request(packet) - 1U; cut > 0U; cut--) {
        fixture_send(FIXTURE_GROUND, packet, cut);
        fixture_run(1U);
        TEST_ASSERT_EQUAL(cut >= 6U, fixture_has("G 1.2 #341 0101"));
        TEST_ASSERT_FALSE(fixture_has("16 TC"));
        fixture_forget();
    }
    packet[5] = 4U; // A whole request of 11 octets: the checksum is in the place of the source.
    checksum(packet, 11U);
    fixture_send(FIXTURE_GROUND, packet, 11U);
    fixture_run(1U);
    fixture_expect("G 1.2 #341 0101 B\n");
}

static void the_source_of_another_user_is_refused(void)
{
    fixture.source = PUS_USER_ONBOARD | ARM; // The ground uses the source of ARM.
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture.source = PUS_USER_ONBOARD | COMMUNICATION_APID; // Communication may not send requests.
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    TEST_ASSERT_EQUAL_UINT32(2U, fixture.supervisor.counters.tc_forbidden);
    uint8_t packet[64];
    const size_t size = good_request(packet); // A member sends a packet with the ground as source.
    fixture_send(FIXTURE_HAND, packet, size);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #341 0107 1"));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    packet[9]  = 0x80U; // Now the member uses its own source.
    packet[10] = HAND;
    checksum(packet, size);
    fixture_forget();
    fixture_send(FIXTURE_HAND, packet, size);
    fixture_run(1U);
    fixture_expect("16 TC 17.1 from 8011\n");
}

static void reports_with_the_apid_of_another_subsystem_are_dropped(void)
{
    uint8_t packet[64];
    size_t size       = 0U;
    const pus_tm_t tm = {
        .apid = ARM, .service = 5U, .subtype = 4U, .data = (const uint8_t*)"\0\1", .size = 2U};
    const uint32_t malformed = fixture.supervisor.counters.tm_malformed;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, packet, sizeof packet, &size));
    fixture_send(FIXTURE_HAND, packet, size); // HAND sends an event with the APID of ARM.
    packet[8] ^= 1U;
    fixture_send(FIXTURE_ARM, packet, size);
    for (size_t cut = 0U; cut < size; cut++) {
        packet[0] = 0x08U;
        fixture_send(FIXTURE_ARM, packet, cut);
        fixture_run(1U);
    }
    fixture_expect("");
    TEST_ASSERT_EQUAL(malformed + 2U + size, fixture.supervisor.counters.tm_malformed);
}

static void a_request_to_an_unknown_addressee_is_reported_as_unrouted(void)
{
    (void)fixture_tc(99U, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    fixture_expect("G 1.10 #0 0001 63\n");
    (void)fixture_tc(2046U, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    fixture_expect("G 1.10 #1 0001 7FE\n");
}

#define PLAIN_WINDOW (MESSAGE_WINDOW - MESSAGE_RESERVE) // The rest of a window is for orders.
#define TIMEOUT_TICKS 10U

/// The next request of the ground waits while its addressee has no room, and so do all requests after it.
static void a_request_waits_for_room_at_its_addressee(void)
{
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    for (unsigned i = 0U; i < (PLAIN_WINDOW + 2U); i++) {
        (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_step();
    }
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(TIMEOUT_TICKS - 1U);
    fixture_expect("");
    fixture.members[FIXTURE_ARM].takes_nothing = false; // The time-out has not passed.
    fixture.members[FIXTURE_ARM].is_passive    = true;
    fixture_run(3U);
    const char* text = fixture_look();
    for (unsigned i = 0U; i < (PLAIN_WINDOW + 2U); i++) {
        text = strstr(text, "16 TC 17.1 from 1\n");
        TEST_ASSERT_NOT_NULL(text);
        text++;
    }
    TEST_ASSERT_NOT_NULL(strstr(text, "17 TC 17.1 from 1\n"));
    TEST_ASSERT_NULL(strstr(text, "G 1.10"));
}

/// Other requests are delayed once and for a limited time; reports and orders are never delayed.
static void a_subsystem_with_a_full_inbox_delays_other_requests_once(void)
{
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    for (unsigned i = 0U; i < PLAIN_WINDOW; i++) {
        (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_step();
    }
    const uint16_t first  = fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    const uint16_t second = fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_event(FIXTURE_LONE, PUS_SEVERITY_INFORMATIVE, 77U);
    fixture_step();
    fixture_expect("G/18 5.1 004D\n");
    fixture_run(TIMEOUT_TICKS);
    char expected[128];
    (void)snprintf(expected, sizeof expected, "G 1.10 #%u 0109 10\nG 1.10 #%u 0109 10\n", first, second);
    TEST_ASSERT_TRUE(fixture_has(expected));
    TEST_ASSERT_TRUE(fixture_has("17 TC 17.1 from 1"));
    fixture_forget();
    const uint16_t third = fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U); // ARM is known to be full.
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    (void)snprintf(expected, sizeof expected, "G 1.10 #%u 0109 10\n", third);
    TEST_ASSERT_TRUE(fixture_has(expected) && fixture_has("17 TC 17.1 from 1"));
    fixture.members[FIXTURE_ARM].takes_nothing = false; // Requests to this subsystem may wait again.
    fixture_run(2U);
    fixture_forget();
    for (unsigned i = 0U; i < (2U * PLAIN_WINDOW); i++) {
        (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_run(1U);
    }
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("G 1.10"));
}

/// Requests to a process that has ended do not wait.
static void a_request_to_an_ended_process_does_not_wait(void)
{
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    for (unsigned i = 0U; i < (PLAIN_WINDOW + 1U); i++) {
        (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_step();
    }
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("G 1.10 #24 0002 10"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 17.1 from 1"));
}

static void reports_wait_for_the_ground_in_order(void)
{
    char expected[4096]                           = "";
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 100U; i++) {
        const uint8_t data[1] = {(uint8_t)i};
        fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 26U, data, 1U);
        (void)snprintf(&expected[strlen(expected)], 32U, "G/16 3.26 %02X\n", i);
        fixture_step();
    }
    fixture_expect("");
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    for (unsigned i = 0U; i < 10U; i++) {
        fixture_step();
    }
    fixture_expect(expected);
}

// ---- Permission ----

static void a_request_that_no_rule_allows_is_denied(void)
{
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "MOVE\0\0\0\0\0", 9U);
    fixture_run(1U);
    fixture_expect("G 1.2 #0 0110 100\n"); // Mode 1, state 0.
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "REST\0\0\0\0\0", 9U);
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "MOVE\0\0\0X\0", 9U);
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "MOV", 3U);
    (void)fixture_tc(ARM, PUS_SERVICE_PARAMETERS, 3U, "\0", 1U);
    (void)fixture_tc(HAND, PUS_SERVICE_PARAMETERS, 3U, "\0", 1U);
    (void)fixture_tc(ARM, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_RELOAD, NULL, 0U);
    (void)fixture_tc(ARM, 200U, 1U, NULL, 0U);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #1 0110 105"));
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #3 0110 105"));
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #4 0110 105"));
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #5 0110 100"));
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #6 0110 105"));
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #7 0110 105"));
    TEST_ASSERT_FALSE(fixture_has("16 TC 20"));
    TEST_ASSERT_FALSE(fixture_has("16 TC 8.1 524553"));
}

static void a_rule_allows_a_request_in_its_mode_and_state(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "MOVE\0\0\0\0\0", 9U);
    fixture_run(1U);
    fixture_expect("16 TC 8.1 4D4F56450000000000 from 1\n");
    const uint8_t mode[1] = {MODE_SAFE};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SET_MODE, mode, 1U);
    fixture_run(2U);
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_FUNCTIONS, 1U, "MOVE\0\0\0\0\0", 9U);
    fixture_run(1U);
    fixture_expect("G 1.2 #2 0110 5\n"); // Mode 0, state 5.
}

static void connection_tests_reads_and_status_are_always_allowed(void)
{
    const uint8_t mode[1] = {MODE_SAFE};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SET_MODE, mode, 1U);
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    fixture_forget();
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(ARM, PUS_SERVICE_PARAMETERS, 1U, "\1\0\0\0\0", 5U);
    (void)fixture_tc(ARM, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REPORT_STATUS, NULL, 0U);
    (void)fixture_tc(ARM, PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\0", 1U);
    (void)fixture_request_state(ARM, STATE_SAFE_OPERATIONAL); // Downwards.
    (void)fixture_request_state(ARM, STATE_ERROR_OPERATIONAL);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 17.1"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 20.1"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.4"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.8"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 04"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 06"));
}

// ---- Conditions for higher states ----

static void a_request_that_needs_more_than_the_available_power_is_refused(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL); // 20 W of 100.
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL); // 41 W.
    fixture_close_link(LINK_HAND_POS);
    fixture.members[FIXTURE_ARM].configuration = 1U; // Configuration 1 has no links.
    fixture_run(60U);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_OPERATIONAL); // 60 W in place of 20 W would be 101 W in total.
    fixture_run(2U);
    fixture_expect("G 5.2 00070010\nG 1.2 #1 0112 1\n"); // RESOURCE_REFUSED; 1 W is missing.
    (void)fixture_request_state(LONE, STATE_OFFLINE);
    fixture_run(3U);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    fixture_expect("16 TC 129.1 05 from 1\n");
}

static void links_are_needed_for_higher_states(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_SAFE_OPERATIONAL);
    fixture_run(1U);
    fixture_expect("G 1.2 #0 0111 100002\n"); // Consumer 16, port 2.
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture_forget();
    (void)fixture_request_state(HAND, STATE_SAFE_OPERATIONAL);
    fixture_run(1U);
    fixture_expect("G 1.2 #1 0111 110002\n");
    fixture_link_up(STATE_PRE_OPERATIONAL);
    (void)fixture_request_state(ARM, STATE_SAFE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 04"));
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
}

static void a_stale_link_counts_as_missing(void)
{
    fixture_link_up(STATE_SAFE_OPERATIONAL);
    fixture_link_changed(FIXTURE_ARM, LINK_HAND_POS, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_STALE);
    fixture_run(1U);
    fixture_forget();
    const uint16_t barred = fixture_request_state(ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    char expected[64];
    (void)snprintf(expected, sizeof expected, "G 1.2 #%u 0111 100002\n", barred);
    fixture_expect(expected);
    fixture_link_changed(FIXTURE_ARM, LINK_HAND_POS, PUS_LINK_STATE_STALE, PUS_LINK_STATE_OPEN);
    fixture_run(1U);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    fixture_expect("16 TC 129.1 05 from 1\n");
}

static void no_member_goes_up_while_a_partner_is_in_error(void)
{
    fixture_link_up(STATE_SAFE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    const uint16_t barred = fixture_request_state(ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    char expected[64];
    (void)snprintf(expected, sizeof expected, "G 1.2 #%u 0113 11\n", barred);
    fixture_expect(expected);
}

static void no_member_leaves_safe_operational_while_a_partner_operates(void)
{
    static const state_t downwards[] = {STATE_OFFLINE, STATE_PRE_OPERATIONAL};
    fixture_link_up(STATE_OPERATIONAL);
    for (unsigned i = 0U; i < 2U; i++) {
        char expected[64];
        const uint16_t barred = fixture_request_state(ARM, downwards[i]);
        fixture_run(1U);
        (void)snprintf(expected, sizeof expected, "G 1.2 #%u 0113 11\n", barred);
        fixture_expect(expected);
    }
    (void)fixture_request_state(ARM, STATE_SAFE_OPERATIONAL); // This transition is permitted.
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 04"));
    (void)fixture_request_state(HAND, STATE_SAFE_OPERATIONAL);
    fixture_run(3U);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 03"));
}

static void an_upward_request_may_go_up_by_one_state_only(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_OPERATIONAL);
    fixture_run(1U);
    fixture_expect("G 1.2 #0 0110 103\n");
    static const uint8_t others[] = {1U, 2U, 7U, 8U, 9U, 10U, 255U};
    for (unsigned i = 0U; i < sizeof others; i++) {
        (void)fixture_request_state(ARM, (state_t)others[i]);
        fixture_run(1U);
        TEST_ASSERT_FALSE(fixture_has("16 TC"));
        fixture_forget();
    }
}

// ---- Requests that stay open ----

static void pending_requests_end_with_their_subsystem(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_verify(FIXTURE_ARM, 7U, 0U);
    fixture_verify(FIXTURE_ARM, 1U, 1U);
    fixture_run(1U);
    fixture_forget();
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(1U);
    TEST_ASSERT_FALSE(fixture_has("G 1.8 #0"));
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0408 10"));
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #2 0408 10"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.pending.count);
}

/// The subsystem continues to report its status, but never answers a request.
static void a_request_that_is_not_accepted_ends(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture.ack = PUS_ACK_COMPLETION; // No report is required before completion.
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_verify(FIXTURE_ARM, 1U, 1U);
    fixture_run(1U);
    fixture_forget();
    fixture_run(990U);
    fixture_expect("");
    fixture_run(20U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0406 2710"));
    TEST_ASSERT_FALSE(fixture_has("G 1.8 #1"));
    TEST_ASSERT_FALSE(fixture_has("G 1.8 #2"));
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.pending.count);
}

/// The inbox is full when the subsystem must become safe: the order is sent as soon as it has room.
static void an_order_without_room_stays_pending(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture_fill(FIXTURE_HAND);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, TIRED);
    fixture_run(1U);
    fixture_forget();
    fixture.members[FIXTURE_HAND].takes_nothing = false;
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0602 from 8001"));
}

/// The ground has filled the inbox with requests, but an order of the supervisor still has room.
static void an_order_has_room_in_an_inbox_full_of_requests(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].takes_nothing = true;
    fixture.ack                                 = 0U;
    for (unsigned i = 0U; i < 40U; i++) {
        (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_step();
    }
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, TIRED);
    fixture_step();
    TEST_ASSERT_FALSE(supervisor_registry_find(&fixture.supervisor, HAND)->is_order_pending);
    TEST_ASSERT_TRUE(message_credit(&fixture.endpoint, HAND) < MESSAGE_RESERVE);
}

static void a_full_backlog_drops_bulk_reports_and_raises_one_event(void)
{
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 1000U; i++) { // Verification reports of a subsystem are FIRM.
        const uint8_t data[6] = {0x18U, 16U, 0xC0U, 0U, 0U, 0U};
        fixture_report(FIXTURE_ARM, PUS_SERVICE_VERIFICATION, 7U, data, 4U);
        fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 25U, data, 6U);
        fixture_step();
    }
    TEST_ASSERT_TRUE(fixture.supervisor.ground.dropped_bulk > 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.counters.tc_unroutable); // Counts requests only.
    TEST_ASSERT_FALSE(supervisor_ground_accepts(&fixture.supervisor, PUS_CLASS_BULK, 40U));
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    fixture_run(100U);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_is_empty(&fixture.supervisor.ground_backlog));
    TEST_ASSERT_EQUAL(1U, fixture_count(fixture_look(), "G 5.2 0028")); // GROUND_BEHIND is raised once.
    TEST_ASSERT_TRUE(supervisor_ground_takes_requests(&fixture.supervisor));
}

static void requests_wait_while_their_answers_have_no_room(void)
{
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    const uint8_t data[4]                         = {0x18U, 16U, 0xC0U, 0U};
    for (unsigned i = 0U; i < 450U; i++) {
        fixture_report(FIXTURE_ARM, PUS_SERVICE_VERIFICATION, 7U, data, 4U);
        fixture_step();
    }
    TEST_ASSERT_FALSE(supervisor_ground_takes_requests(&fixture.supervisor));
    const uint32_t routed = fixture.supervisor.counters.tc_routed;
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(5U);
    TEST_ASSERT_EQUAL_UINT32(routed, fixture.supervisor.counters.tc_routed);
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    fixture_run(30U);
    TEST_ASSERT_EQUAL_UINT32(routed + 1U, fixture.supervisor.counters.tc_routed);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.ground.dropped_firm);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(requests_reach_subsystems_and_reports_reach_the_ground);
    RUN_TEST(every_packet_is_logged_in_both_directions);
    RUN_TEST(a_refused_request_is_logged_too);
    RUN_TEST(each_malformed_packet_is_refused_with_its_code);
    RUN_TEST(a_truncated_request_is_reported_if_it_contains_its_number);
    RUN_TEST(the_source_of_another_user_is_refused);
    RUN_TEST(reports_with_the_apid_of_another_subsystem_are_dropped);
    RUN_TEST(a_request_to_an_unknown_addressee_is_reported_as_unrouted);
    RUN_TEST(a_request_waits_for_room_at_its_addressee);
    RUN_TEST(a_subsystem_with_a_full_inbox_delays_other_requests_once);
    RUN_TEST(a_request_to_an_ended_process_does_not_wait);
    RUN_TEST(reports_wait_for_the_ground_in_order);
    RUN_TEST(a_request_that_no_rule_allows_is_denied);
    RUN_TEST(a_rule_allows_a_request_in_its_mode_and_state);
    RUN_TEST(connection_tests_reads_and_status_are_always_allowed);
    RUN_TEST(a_request_that_needs_more_than_the_available_power_is_refused);
    RUN_TEST(links_are_needed_for_higher_states);
    RUN_TEST(a_stale_link_counts_as_missing);
    RUN_TEST(no_member_goes_up_while_a_partner_is_in_error);
    RUN_TEST(no_member_leaves_safe_operational_while_a_partner_operates);
    RUN_TEST(an_upward_request_may_go_up_by_one_state_only);
    RUN_TEST(pending_requests_end_with_their_subsystem);
    RUN_TEST(a_request_that_is_not_accepted_ends);
    RUN_TEST(an_order_without_room_stays_pending);
    RUN_TEST(an_order_has_room_in_an_inbox_full_of_requests);
    RUN_TEST(a_full_backlog_drops_bulk_reports_and_raises_one_event);
    RUN_TEST(requests_wait_while_their_answers_have_no_room);
    return UNITY_END();
}
