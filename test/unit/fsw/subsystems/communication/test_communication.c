// SPDX-License-Identifier: Apache-2.0
// Communication over real loopback connections: framing of requests, distribution of reports, and hostile
// clients.
#include "fsw/subsystems/communication/communication.h"

#include "test/unit/fsw/subsystems/communication/communication_fixture.h"
#include "unity.h"

#include <string.h>

#define HK_SERVICE 3U
#define HK_SUBTYPE 25U
#define EVENT_SERVICE 5U

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

// ---- Requests from the ground ----

static void a_request_is_received_wherever_the_stream_is_divided(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    unsigned count = 0U;
    fixture_connect(0U);
    const size_t size = fixture_request(packet, 1U, 7U, 5U);
    for (size_t cut = 1U; cut < size; cut++) {
        fixture_write(0U, packet, cut);
        fixture_run(2U);
        TEST_ASSERT_EQUAL(count, fixture.request_count);
        fixture_write(0U, &packet[cut], size - cut);
        count++;
        fixture_run_until_requests(count);
        TEST_ASSERT_EQUAL(size, fixture.requests[count - 1U].size);
        TEST_ASSERT_EQUAL(7U, fixture.requests[count - 1U].sequence);
    }
    for (size_t i = 0U; i < size; i++) { // Octet by octet.
        fixture_write(0U, &packet[i], 1U);
        fixture_run(2U);
    }
    fixture_run_until_requests(count + 1U);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
}

static void many_requests_in_one_segment_keep_their_order(void)
{
    static uint8_t stream[60000];
    size_t used = 0U;
    fixture_connect(0U);
    for (uint16_t i = 0U; i < 200U; i++) {
        static uint8_t packet[PUS_PACKET_MAX];
        const size_t size = fixture_request(packet, 1U, i, i);
        (void)memcpy(&stream[used], packet, size);
        used += size;
    }
    fixture_write(0U, stream, used);
    fixture_run_until_requests(200U);
    for (uint16_t i = 0U; i < 200U; i++) {
        TEST_ASSERT_EQUAL(i, fixture.requests[i].sequence);
        TEST_ASSERT_EQUAL(13U + i, fixture.requests[i].size); // 13: headers and checksum, without data.
    }
    TEST_ASSERT_EQUAL(200U, fixture.communication.parameters.counters.tc_received);
    TEST_ASSERT_EQUAL(used, fixture.communication.parameters.counters.octets_received);
}

static void the_largest_request_is_received(void)
{
    fixture_connect(0U);
    fixture_write_request(0U, 1U, 1U, PUS_TC_DATA_MAX);
    fixture_write_request(0U, 1U, 2U, PUS_TC_DATA_MAX);
    fixture_run_until_requests(2U);
    TEST_ASSERT_EQUAL(PUS_PACKET_MAX, fixture.requests[0].size);
    TEST_ASSERT_EQUAL(2U, fixture.requests[1].sequence);
}

static void invalid_octets_end_only_their_own_connection(void)
{
    uint8_t garbage[64];
    (void)memset(garbage, 0xFF, sizeof garbage);
    fixture_connect(0U);
    fixture_connect(1U);
    fixture_write(0U, garbage, sizeof garbage);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_is_ended(0U));
    fixture_write_request(1U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    TEST_ASSERT_FALSE(fixture_is_ended(1U));
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_LOST]);
    fixture_connect(2U); // The slot is free again.
    fixture_write_request(2U, 1U, 2U, 0U);
    fixture_run_until_requests(2U);
}

static void communication_forwards_every_framed_telecommand_unchecked(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    fixture_connect(0U);
    size_t size = fixture_request(packet, 1U, 1U, 0U);
    packet[size - 1U] ^= 0xFFU; // A wrong checksum: the supervisor detects it.
    fixture_write(0U, packet, size);
    fixture_run_until_requests(1U);
    packet[0] = 0x08U; // The ground may not send reports.
    fixture_write(0U, packet, size);
    fixture_write_request(0U, 1U, 2U, 0U);
    fixture_run_until_requests(2U);
    TEST_ASSERT_EQUAL(2U, fixture.requests[1].sequence);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.counters.tc_refused);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
}

static void random_octets_cause_no_failure(void)
{
    uint32_t random = 17U;
    for (unsigned round = 0U; round < 100U; round++) {
        uint8_t octets[256];
        for (size_t i = 0U; i < sizeof octets; i++) {
            random    = (random * 1664525U) + 1013904223U;
            octets[i] = (uint8_t)(random >> 24U);
        }
        octets[0] = (uint8_t)((octets[0] & 0x07U) | 0x18U);
        octets[4] &= 0x0FU; // A plausible length, sometimes.
        fixture_connect(0U);
        fixture_write(0U, octets, sizeof octets);
        fixture_run(3U);
        fixture_disconnect(0U);
        fixture_run(2U);
    }
    fixture_connect(0U);
    const unsigned before = fixture.request_count;
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run_until_requests(before + 1U);
}

static void requests_wait_while_the_inbox_of_the_supervisor_is_full(void)
{
    fixture_connect(0U);
    fixture_connect(1U);
    fixture.is_uplink_full = true;
    for (uint16_t i = 0U; i < 2000U; i++) { // More than the buffer of a client can hold.
        fixture_write_request(0U, 1U, i, 0U);
        if ((i % 100U) == 0U) {
            fixture_step();
        }
    }
    fixture_run(20U);
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
    fixture.is_uplink_full = false;
    // The supervisor accepts one window at a time.
    for (unsigned room = 32U; fixture.request_count < 2000U; room += 32U) {
        fixture.uplink_room = room;
        fixture_step();
        TEST_ASSERT_TRUE(room < 6400U);
    }
    for (uint16_t i = 0U; i < 2000U; i++) {
        TEST_ASSERT_EQUAL(i, fixture.requests[i].sequence);
    }
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
}

// ---- Reports to the ground ----

static void reports_go_to_the_connections_of_their_user(void)
{
    fixture_connect(0U);
    fixture_connect(1U);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_write_request(1U, 3U, 1U, 0U);
    fixture_run_until_requests(2U);
    fixture_report(1U, 1U, 7U, 100U, 0U);
    fixture_report(3U, 1U, 7U, 300U, 0U);
    fixture_report(0U, EVENT_SERVICE, 2U, 500U, 0U); // An event is sent to all users.
    fixture_report(2U, 1U, 7U, 200U, 0U);            // This user has never sent a request.
    fixture_step();
    TEST_ASSERT_EQUAL(100U, fixture_next_report(0U));
    TEST_ASSERT_EQUAL(500U, fixture_next_report(0U));
    TEST_ASSERT_EQUAL(300U, fixture_next_report(1U));
    TEST_ASSERT_EQUAL(500U, fixture_next_report(1U));
    fixture_write_request(1U, 1U, 2U, 0U); // A second connection of user 1.
    fixture_run_until_requests(3U);
    fixture_report(1U, HK_SERVICE, HK_SUBTYPE, 101U, 0U);
    fixture_step();
    TEST_ASSERT_EQUAL(101U, fixture_next_report(0U));
    TEST_ASSERT_EQUAL(101U, fixture_next_report(1U));
}

/// Time packets have no secondary header and therefore no destination; at its offset is a part of the time.
static void time_packets_are_sent_to_all_connections(void)
{
    static const uint8_t packet[18] = {0x00, 0x00, 0xC0, 0x3F, 0x00, 0x0B, 0x00, 0x1F, 0x80,
                                       0xAF, 0xD3, 0x07, 0x00, 0x00, 0x00, 0x00, 0x12, 0x34};
    fixture_connect(0U);
    fixture_connect(1U);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_write_request(1U, 3U, 1U, 0U);
    fixture_run_until_requests(2U);
    subsystem_accept(&fixture.component, packet, sizeof packet, fixture.now_ns);
    fixture_step();
    for (unsigned client = 0U; client < 2U; client++) {
        uint8_t octets[sizeof packet] = {0};
        size_t held                   = 0U;
        for (unsigned tries = 0U; (tries < 4U) && (held < sizeof packet); tries++) {
            held += fixture_read(client, &octets[held], sizeof packet - held);
        }
        TEST_ASSERT_EQUAL_UINT64(sizeof packet, held);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, octets, sizeof packet);
    }
}

static void a_user_is_removed_with_its_connection(void)
{
    fixture_connect(0U);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    fixture_report(1U, 1U, 7U, 1U, 0U);
    fixture_disconnect(0U);
    fixture_run(3U);
    fixture_connect(1U); // The client gets the same slot.
    fixture_report(1U, 1U, 7U, 100U, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL_MESSAGE(UINT32_MAX, fixture_next_report(1U), "a report for another client");
    TEST_ASSERT_EQUAL(2U, fixture.events[COMMUNICATION_EVENT_GROUND_CONNECTED]);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_LOST]);
}

static void users_beyond_the_table_share_its_last_entry(void)
{
    fixture_connect(0U);
    fixture_connect(1U);
    for (uint16_t user = 1U; user <= (GROUND_USERS + 2U); user++) {
        fixture_write_request(user % 2U, user, user, 0U);
        fixture_run_until_requests(user);
    }
    for (uint16_t user = 1U; user <= (GROUND_USERS + 2U); user++) {
        fixture_report(user, 1U, 7U, user, 0U);
        fixture_step();
        const bool is_kept = (user < GROUND_USERS) || (user == (GROUND_USERS + 2U));
        TEST_ASSERT_EQUAL(is_kept ? user : UINT32_MAX, fixture_next_report(user % 2U));
    }
}

static void reports_to_users_on_board_are_not_sent_to_the_ground(void)
{
    fixture_connect(0U);
    fixture_report(0x8010U, 1U, 7U, 1U, 0U);
    fixture_report(0x8001U, 1U, 7U, 1U, 0U);
    fixture_step();
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(0U));
    uint8_t cut[12] = {0x08U, 0x10U}; // Too short for a destination.
    subsystem_accept(&fixture.component, cut, sizeof cut, fixture.now_ns);
    fixture_step();
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(0U));
}

static void every_sent_octet_is_counted(void)
{
    fixture_connect(0U);
    fixture_connect(1U);
    uint32_t expected = 0U;
    for (uint32_t i = 0U; i < 50U; i++) {
        fixture_report(0U, EVENT_SERVICE, 1U, i, i * 10U);
        expected += 27U + (i * 10U); // 27: headers, checksum and the number.
        fixture_step();
    }
    TEST_ASSERT_EQUAL(expected, fixture.sent[0]);
    TEST_ASSERT_EQUAL(expected, fixture.sent[1]);
    TEST_ASSERT_EQUAL(2U * expected, fixture.communication.parameters.counters.octets_sent);
    TEST_ASSERT_EQUAL(100U, fixture.communication.parameters.counters.tm_sent);
    for (uint32_t i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(i, fixture_next_report(0U));
        TEST_ASSERT_EQUAL(i, fixture_next_report(1U));
    }
}

// ---- Slow readers ----

static void a_slow_reader_loses_housekeeping_only(void)
{
    uint32_t number = 0U;
    uint32_t events = 0U;
    fixture_connect(0U);
    fixture_connect(1U);
    for (; fixture.communication.parameters.counters.tm_dropped < 200U; number++) {
        const bool is_event = (number % 50U) == 0U;
        fixture_report(0U, is_event ? EVENT_SERVICE : HK_SERVICE, is_event ? 2U : HK_SUBTYPE, number, 3000U);
        events += is_event ? 1U : 0U;
        if ((number % 8U) == 0U) {
            fixture_step();
        }
        if ((number % 4U) == 0U) { // The other client reads all the time.
            uint8_t octets[65536];
            while (fixture_read(1U, octets, sizeof octets) == sizeof octets) {
            }
        }
        TEST_ASSERT_TRUE(number < 20000U);
    }
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_TM_DROPPED]); // Reported once.
    TEST_ASSERT_TRUE(flow_tcp_is_connected(&fixture.communication.flow, 0U));
    TEST_ASSERT_EQUAL(0U, fixture_next_report(0U)); // The first report, and then all kept ones, in order.
    uint32_t last     = 0U;
    uint32_t received = 1U;
    uint32_t seen     = 1U;
    while (received < (number - fixture.communication.parameters.counters.tm_dropped)) {
        const uint32_t found = fixture_next_report(0U);
        TEST_ASSERT_TRUE((found > last) && (found < number));
        last = found;
        received++;
        seen += ((found % 50U) == 0U) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(0U));
    TEST_ASSERT_EQUAL(events, seen);
}

static void a_client_that_never_reads_is_disconnected(void)
{
    fixture_connect(0U);
    for (uint32_t i = 0U; (i < 20000U) && flow_tcp_is_connected(&fixture.communication.flow, 0U); i++) {
        fixture_report(0U, EVENT_SERVICE, 2U, i, 3000U);
        if ((i % 16U) == 0U) {
            fixture_step();
        }
    }
    TEST_ASSERT_FALSE(flow_tcp_is_connected(&fixture.communication.flow, 0U));
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_LOST]);
    fixture_connect(1U);
    fixture_report(0U, EVENT_SERVICE, 2U, 77U, 0U);
    fixture_step();
    TEST_ASSERT_EQUAL(77U, fixture_next_report(1U)); // The slot has no report for its earlier client.
}

// ---- Clients ----

static void clients_beyond_the_limit_are_disconnected(void)
{
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
    }
    fixture_connect(COMMUNICATION_CLIENTS);
    TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS));
    TEST_ASSERT_EQUAL(COMMUNICATION_CLIENTS, fixture.communication.parameters.counters.connected);
    fixture_disconnect(2U);
    fixture_run(3U);
    fixture_connect(COMMUNICATION_CLIENTS + 1U);
    fixture_write_request(COMMUNICATION_CLIENTS + 1U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    TEST_ASSERT_EQUAL(COMMUNICATION_CLIENTS, fixture.communication.parameters.status.connections);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.counters.disconnected);
}

static void requests_are_read_when_the_port_is_configured(void)
{
    fixture_close();
    fixture_open();
    fixture_connect(0U); // The launcher's socket accepts the connection; nothing serves it yet.
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_request(&fixture.component, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    fixture_run(5U);
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_select(&fixture.component, COMMUNICATION_CONFIGURATION_FLIGHT));
    fixture_run_until_requests(1U);
}

static void an_invalid_port_is_an_error(void)
{
    fixture_close();
    fixture_open();
    fixture.communication.listener = 9999;
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_request(&fixture.component, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    fixture_run(5U);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_select(&fixture.component, COMMUNICATION_CONFIGURATION_FLIGHT));
    fixture_run(5U);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_PORT_FAILED]);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, subsystem_state(&fixture.component));
}

// ---- The participant of the scheduler ----

/// Each request has 13 octets. communication_take_in returns true while something is missing.
static void exactly_the_announced_octets_of_the_participant_are_taken(void)
{
    fixture_connect(0U);
    fixture.participant   = fixture.ports[0];
    const unsigned before = fixture.intrusions;
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_write_request(0U, 1U, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    bool is_missing = communication_take_in(&fixture.communication, 13U);
    TEST_ASSERT_FALSE(is_missing);
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
    // Only a part of the announced octets has arrived.
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 5U));
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 8U));
    TEST_ASSERT_EQUAL(2U, fixture.request_count);
    // The announced octets are in transit.
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 13U));
    fixture_write_request(0U, 1U, 3U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(3U, fixture.request_count);
    // One octet is in transit.
    fixture_write_request(0U, 1U, 4U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 14U));
    TEST_ASSERT_EQUAL(4U, fixture.request_count);
    fixture_write_request(0U, 1U, 5U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 12U));
    TEST_ASSERT_EQUAL(5U, fixture.request_count);
    TEST_ASSERT_EQUAL(before, fixture.intrusions);
    fixture_connect(1U); // Another client may connect at any time.
    TEST_ASSERT_EQUAL(before + 1U, fixture.intrusions);
    fixture_write_request(1U, 3U, 1U, 0U); // That client may send anything.
    fixture_run_until_requests(6U);
    TEST_ASSERT_EQUAL(before + 2U, fixture.intrusions);
}

static void a_participant_waits_for_room_without_a_timeout(void)
{
    fixture_connect(0U);
    fixture.participant    = fixture.ports[0];
    fixture.is_uplink_full = true;
    for (uint16_t i = 0U; i < 1000U; i++) {
        fixture_write_request(0U, 1U, i, 0U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    // These octets are not missing: they were refused above.
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 13000U));
    fixture.is_uplink_full = false;
    fixture_run_until_requests(1000U);
    TEST_ASSERT_EQUAL(0U, fixture.communication.outstanding);
}

static void no_reply_is_awaited_from_a_disconnected_participant(void)
{
    fixture_connect(0U);
    fixture.participant = fixture.ports[0];
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 13U));
    fixture_disconnect(0U);
    for (unsigned i = 0U; (i < 100U) && flow_tcp_is_connected(&fixture.communication.flow, 0U); i++) {
        fixture_step();
    }
    TEST_ASSERT_EQUAL(0U, fixture.communication.outstanding);
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
}

static void no_octet_is_awaited_from_a_participant_that_left_before_its_connection_was_reported(void)
{
    fixture_connect(0U);
    fixture.participant = fixture.ports[0];
    fixture_disconnect(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    (void)communication_take_in(&fixture.communication, 20U);
    TEST_ASSERT_FALSE(flow_tcp_is_connected(&fixture.communication.flow, 0U));
    TEST_ASSERT_EQUAL(0U, fixture.served);
    TEST_ASSERT_EQUAL(0U, fixture.communication.outstanding);
}

/// The participant closes its connection within its last grant; the report about this belongs to the next
/// grant of communication.
static void the_end_of_a_participant_that_left_is_awaited(void)
{
    fixture_connect(0U);
    fixture_connect(1U); // This client stays, and communication does not wait for it.
    fixture.participant = fixture.ports[0];
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    fixture.participant = 0U; // The participant has left the scheduler.
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 0U));
    fixture_disconnect(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(0U, fixture.communication.participant);
    fixture_connect(0U); // The next client is not the participant.
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
}

static void a_participant_that_left_is_no_longer_awaited_after_stop_waiting(void)
{
    fixture_connect(1U);
    fixture_connect(0U);
    fixture.participant = fixture.ports[0];
    (void)communication_take_in(&fixture.communication, 0U);
    fixture.participant = 0U;
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 0U));
    communication_stop_waiting(&fixture.communication);
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
}

/// The scheduler reports the participant's port before the kernel reports its connection.
static void the_connection_of_a_participant_is_awaited_and_reported(void)
{
    fixture.participant = 1U; // No client connects from this port.
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 13U));
    TEST_ASSERT_EQUAL(0U, fixture.served);
    // There is no connection; the callback is informed of this.
    communication_stop_waiting(&fixture.communication);
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(1U, fixture.cut);
    TEST_ASSERT_EQUAL(0U, fixture.communication.outstanding);
    fixture_connect(0U);
    fixture.participant = fixture.ports[0];
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(1U, fixture.served); // The callback is called once.
}

static void a_participant_whose_connection_is_ended_is_reported(void)
{
    static const uint8_t garbage[6] = {0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU};
    fixture_connect(0U);
    fixture.participant = fixture.ports[0];
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    fixture_write(0U, garbage, sizeof garbage);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    (void)communication_take_in(&fixture.communication, 20U);
    TEST_ASSERT_EQUAL(1U, fixture.cut);
    TEST_ASSERT_EQUAL(0U, fixture.communication.outstanding);
    fixture_connect(1U); // The participant connects again.
    fixture.participant = fixture.ports[1];
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 0U));
    TEST_ASSERT_EQUAL(2U, fixture.served);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_is_received_wherever_the_stream_is_divided);
    RUN_TEST(many_requests_in_one_segment_keep_their_order);
    RUN_TEST(the_largest_request_is_received);
    RUN_TEST(invalid_octets_end_only_their_own_connection);
    RUN_TEST(communication_forwards_every_framed_telecommand_unchecked);
    RUN_TEST(random_octets_cause_no_failure);
    RUN_TEST(requests_wait_while_the_inbox_of_the_supervisor_is_full);
    RUN_TEST(reports_go_to_the_connections_of_their_user);
    RUN_TEST(time_packets_are_sent_to_all_connections);
    RUN_TEST(a_user_is_removed_with_its_connection);
    RUN_TEST(users_beyond_the_table_share_its_last_entry);
    RUN_TEST(reports_to_users_on_board_are_not_sent_to_the_ground);
    RUN_TEST(every_sent_octet_is_counted);
    RUN_TEST(a_slow_reader_loses_housekeeping_only);
    RUN_TEST(a_client_that_never_reads_is_disconnected);
    RUN_TEST(clients_beyond_the_limit_are_disconnected);
    RUN_TEST(requests_are_read_when_the_port_is_configured);
    RUN_TEST(an_invalid_port_is_an_error);
    RUN_TEST(exactly_the_announced_octets_of_the_participant_are_taken);
    RUN_TEST(a_participant_waits_for_room_without_a_timeout);
    RUN_TEST(no_reply_is_awaited_from_a_disconnected_participant);
    RUN_TEST(no_octet_is_awaited_from_a_participant_that_left_before_its_connection_was_reported);
    RUN_TEST(the_end_of_a_participant_that_left_is_awaited);
    RUN_TEST(a_participant_that_left_is_no_longer_awaited_after_stop_waiting);
    RUN_TEST(the_connection_of_a_participant_is_awaited_and_reported);
    RUN_TEST(a_participant_whose_connection_is_ended_is_reported);
    return UNITY_END();
}
