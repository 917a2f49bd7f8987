// SPDX-License-Identifier: Apache-2.0
// Clients that are idle, slow or hostile: the operator nevertheless gets a slot, and an event reports these
// clients.
#include "fsw/subsystems/communication/communication.h"

#include "test/unit/fsw/subsystems/communication/communication_fixture.h"
#include "test/support/clients.h"
#include "unity.h"

#include <poll.h>
#include <string.h>

#define KINDS 5U // Kinds of misuse.

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

/// All slots are taken: client 0 sends requests, client 1 has sent half a header, the others nothing. The
/// operator connects as a further client and gets a slot once one of them has been silent for 10 s.
static void idle_clients_are_disconnected_to_make_room(void)
{
    static const uint8_t half[3] = {0x18U, 0x01U, 0xC0U};
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
        fixture_run(10U);
    }
    fixture_write(1U, half, sizeof half);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    fixture_connect(COMMUNICATION_CLIENTS); // Too soon: no client is idle yet.
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS));
    fixture_run(100U);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
    fixture_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U));
    fixture_write_request(0U, 1U, 2U, 0U);
    fixture_run_until_requests(2U);
    fixture_disconnect(COMMUNICATION_CLIENTS);
    fixture_connect(COMMUNICATION_CLIENTS);
    fixture_write_request(COMMUNICATION_CLIENTS, 3U, 1U, 0U);
    fixture_run_until_requests(3U);
    // Of the clients without a valid request, client 1 has been connected for the longest time: half a header
    // is no request. Client 0 has sent two.
    TEST_ASSERT_TRUE(fixture_is_ended(1U));
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
    TEST_ASSERT_FALSE(fixture_is_ended(2U));
    fixture_run(200U);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.clients.evicted);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.clients.refused);
    TEST_ASSERT_EQUAL(2U, fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
}

/// Let time pass; these clients send a valid request every 5 s.
static void keep_busy(const unsigned first, const unsigned clients, const uint64_t time_ns)
{
    for (uint64_t passed_ns = 0U; passed_ns < time_ns; passed_ns += COMMUNICATION_IDLE_NS / 2U) {
        for (unsigned i = first; i < (first + clients); i++) {
            fixture_write_request(i, 1U, 1U, 0U);
        }
        fixture_run_until_requests(fixture.request_count + clients);
        fixture_run((unsigned)(COMMUNICATION_IDLE_NS / 20000000U));
    }
}

/// Clients that send valid requests all the time occupy all slots. The operator connects last, gets the slot
/// of a client that has had it for COMMUNICATION_HOLD_NS, and keeps it for 25 s of this time, whichever
/// clients connect then.
static void busy_clients_are_served_in_turn(void)
{
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
        fixture_run(10U);
    }
    keep_busy(0U, COMMUNICATION_CLIENTS, COMMUNICATION_HOLD_NS - COMMUNICATION_IDLE_NS);
    fixture_connect(COMMUNICATION_CLIENTS);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS)); // No client has had its slot for long enough.
    fixture_disconnect(COMMUNICATION_CLIENTS);
    keep_busy(0U, COMMUNICATION_CLIENTS, COMMUNICATION_IDLE_NS);
    fixture_connect(COMMUNICATION_CLIENTS);
    fixture_write_request(COMMUNICATION_CLIENTS, 3U, 1U, 0U);
    fixture_run_until_requests(fixture.request_count + 1U);
    TEST_ASSERT_TRUE(fixture_is_ended(0U)); // The client with the longest connection.
    TEST_ASSERT_EQUAL(1U, fixture.communication.flow.counters.evicted);
    // Each client that is disconnected connects again at once.
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_disconnect(i);
        fixture_connect(i);
        fixture_run(2U);
    }
    TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
    TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS - 1U));
    for (uint16_t i = 0U; i < 5U; i++) {
        keep_busy(0U, COMMUNICATION_CLIENTS - 1U, COMMUNICATION_IDLE_NS / 2U);
        fixture_write_request(COMMUNICATION_CLIENTS, 3U, 2U + i, 0U);
        fixture_run_until_requests(fixture.request_count + 1U);
        fixture_disconnect(COMMUNICATION_CLIENTS - 1U);
        fixture_connect(COMMUNICATION_CLIENTS - 1U);
        fixture_run(2U);
        TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS - 1U));
        TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
    }
    fixture_run(200U);
    TEST_ASSERT_EQUAL(COMMUNICATION_CLIENTS, fixture.communication.parameters.clients.evicted);
    TEST_ASSERT_EQUAL(7U, fixture.communication.parameters.clients.refused);
    TEST_ASSERT_TRUE(fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED] >= 2U);
}

static void a_client_without_a_valid_request_loses_its_slot(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
    }
    fixture_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U));
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        const size_t size = fixture_request(packet, 1U, (uint16_t)i, 0U);
        packet[size - 1U] ^= (i == 2U) ? 0xFFU : 0U;
        fixture_write(i, packet, size);
    }
    fixture_run_until_requests(COMMUNICATION_CLIENTS);
    fixture_connect(COMMUNICATION_CLIENTS);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_is_ended(2U));
    TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
}

static void a_participant_keeps_its_slot(void)
{
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
    }
    fixture.participant = fixture.ports[0];
    fixture_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U) + 2U);
    fixture_connect(COMMUNICATION_CLIENTS);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
    TEST_ASSERT_TRUE(fixture_is_ended(1U));
}

/// While a participant waits for a slot, simulated time does not pass, so no limit in simulated time applies.
static void a_new_participant_gets_a_slot_at_once(void)
{
    osal_address_t own = {0U, 0U};
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
    }
    osal_socket_t* const last = &fixture.clients[COMMUNICATION_CLIENTS];
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(last, fixture.address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(last, &own));
    fixture.ports[COMMUNICATION_CLIENTS] = own.port;
    fixture.participant                  = own.port;
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
    TEST_ASSERT_TRUE(fixture_is_ended(0U)); // This client had the longest connection.
    TEST_ASSERT_FALSE(fixture_is_ended(1U));
    fixture_disconnect(0U);
    fixture_connect(0U); // Another client has to wait as before.
    TEST_ASSERT_TRUE(fixture_is_ended(0U));
}

static void misuse_is_counted_and_reported_once_a_second(void)
{
    uint8_t garbage[64];
    uint8_t packet[PUS_PACKET_MAX];
    (void)memset(garbage, 0xFF, sizeof garbage);
    fixture_run(100U);
    for (unsigned i = 0U; i < 20U; i++) {
        fixture_connect(0U);
        const size_t size = fixture_request(packet, 1U, 1U, 0U);
        packet[0]         = 0x08U; // A report.
        fixture_write(0U, packet, size);
        fixture_write(0U, garbage, sizeof garbage);
        fixture_run(5U);
        TEST_ASSERT_TRUE(fixture_is_ended(0U));
        fixture_disconnect(0U);
    }
    fixture_run(100U);
    TEST_ASSERT_EQUAL(20U, fixture.communication.parameters.clients.malformed);
    TEST_ASSERT_EQUAL(20U, fixture.communication.parameters.clients.no_telecommand);
    TEST_ASSERT_TRUE(fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED] >= 1U);
    TEST_ASSERT_TRUE(fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED] <= 4U);
}

/// The supervisor refuses the request; its report about this goes to the user on board.
static void a_client_with_the_source_of_a_user_on_board_is_counted_and_reported(void)
{
    fixture_run(100U);
    fixture_connect(0U);
    fixture_write_request(0U, (uint16_t)(PUS_USER_ONBOARD | 2U), 1U, 0U);
    fixture_run_until_requests(1U);
    fixture_write_request(0U, 2U, 2U, 0U);
    fixture_run_until_requests(2U);
    // This request has no source: its last two octets are a checksum.
    static const uint8_t without_source[] = {0x18U, 0x10U, 0xC0U, 0U, 0U, 4U, 0x2FU, 17U, 1U, 0x80U, 2U};
    fixture_write(0U, without_source, sizeof without_source);
    fixture_run_until_requests(3U);
    fixture_run(100U);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.clients.no_telecommand);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
}

/// Communication no longer reads a client that sends requests and does not read; the connection stays.
static void a_client_that_does_not_read_is_no_longer_read(void)
{
    fixture_connect(0U);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    while (communication_ground_queue_room(&fixture.communication.queues[0]) >= 32768U) { // ANSWERS_ROOM.
        fixture_report(1U, 1U, 7U, 1U, 1000U);
    }
    fixture_write_request(0U, 1U, 2U, 0U);
    (void)communication_take_in(&fixture.communication, 0U); // No report is sent here, so no request is read.
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
    fixture_run_until_requests(2U);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
}

/// At the end of the process every connection is closed without a notice to a component; the port belongs to
/// the launcher and stays open.
static void a_release_ends_every_connection(void)
{
    const subsystem_callbacks_t* const callbacks = communication_callbacks();
    fixture_connect(0U);
    fixture_connect(1U);
    fixture_write_request(1U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    const uint32_t held = fixture.communication.sockets.stats.used;
    for (unsigned i = 0U; i < 2U; i++) { // The second call has no effect.
        callbacks->release(&fixture.communication);
        TEST_ASSERT_FALSE(flow_tcp_is_connected(&fixture.communication.flow, 0U));
        TEST_ASSERT_FALSE(flow_tcp_is_connected(&fixture.communication.flow, 1U));
        TEST_ASSERT_EQUAL(held - 2U, fixture.communication.sockets.stats.used);
        TEST_ASSERT_EQUAL(2U, fixture.communication.flow.counters.ended);
    }
    TEST_ASSERT_TRUE(fixture_is_ended(0U));
    TEST_ASSERT_TRUE(fixture_is_ended(1U));
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
    TEST_ASSERT_TRUE(osal_socket_is_open(&fixture.communication.flow.listener));
    fixture_disconnect(0U);
    fixture_connect(0U);
    fixture_write_request(0U, 1U, 2U, 0U);
    fixture_run_until_requests(2U);
}

static unsigned misuses_after(const unsigned steps)
{
    const unsigned before = fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED];
    fixture_run(steps);
    return fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED] - before;
}

/// Each counter of misuse, and any two of them, raise one event, at the earliest 1 s after the last event.
static void each_kind_of_misuse_is_reported_alone_and_with_any_other(void)
{
    flow_tcp_counters_t* const counters = &fixture.communication.flow.counters;
    uint32_t* const kinds[KINDS]        = {&counters->turned_away, &counters->evicted, &counters->malformed,
                                           &fixture.communication.not_requests,
                                           &fixture.communication.routes.forgotten};
    TEST_ASSERT_EQUAL(0U, misuses_after(200U));
    for (unsigned i = 0U; i < KINDS; i++) {
        for (unsigned k = 0U; k < KINDS; k++) {
            *kinds[i] += 1U;
            *kinds[k] += 1U;
            TEST_ASSERT_EQUAL(1U, misuses_after(100U));
        }
    }
    (*kinds[0])++;
    TEST_ASSERT_EQUAL(1U, misuses_after(1U));
    (*kinds[0])++;
    TEST_ASSERT_EQUAL(0U, misuses_after(99U)); // 990 ms after the event.
    TEST_ASSERT_EQUAL(1U, misuses_after(1U));
}

/// After exactly 10 s without a valid telecommand a client loses its slot, one period earlier it does not.
static void a_client_loses_its_slot_after_10_s_of_silence(void)
{
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        fixture_connect(i);
    }
    communication_t* const communication = &fixture.communication;
    const uint64_t heard_ns              = communication->heard_ns[0];
    while ((subsystem_now_ns(&fixture.component) + 10000000U) < (heard_ns + COMMUNICATION_IDLE_NS)) {
        fixture_step();
    }
    osal_socket_t* const last = &fixture.clients[COMMUNICATION_CLIENTS];
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(last, fixture.address));
    (void)communication_take_in(communication, 0U);
    TEST_ASSERT_TRUE(fixture_is_ended(COMMUNICATION_CLIENTS)); // After 9.99 s.
    osal_socket_close(last);
    fixture_step();
    TEST_ASSERT_EQUAL_UINT64(heard_ns + COMMUNICATION_IDLE_NS, subsystem_now_ns(&fixture.component));
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(last, fixture.address));
    (void)communication_take_in(communication, 0U);
    TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
    TEST_ASSERT_TRUE(fixture_is_ended(0U));
}

/// The other clients may have connected at the same instant.
static void a_participant_gets_the_slot_of_a_client_that_came_with_it(void)
{
    osal_address_t own = {0U, 0U};
    for (unsigned i = 0U; i <= COMMUNICATION_CLIENTS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&fixture.clients[i], fixture.address));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&fixture.clients[COMMUNICATION_CLIENTS], &own));
    fixture.participant = own.port;
    for (unsigned i = 0U; (i < 100U) && (fixture.served == 0U); i++) {
        (void)communication_take_in(&fixture.communication, 0U); // No time passes here.
    }
    TEST_ASSERT_EQUAL(1U, fixture.served);
    TEST_ASSERT_FALSE(fixture_is_ended(COMMUNICATION_CLIENTS));
}

/// The octets of the participant are announced before the kernel reports its connection.
static void octets_announced_before_the_connection_are_taken_after_it(void)
{
    osal_address_t own  = {0U, 0U};
    fixture.participant = 1U; // The participant has not connected yet.
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 13U));
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&fixture.clients[0], fixture.address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&fixture.clients[0], &own));
    fixture.participant = own.port;
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_write_request(0U, 1U, 2U, 0U);
    for (unsigned i = 0U; (i < 1000U) && communication_take_in(&fixture.communication, 0U); i++) {
        (void)poll(NULL, 0U, 1);
    }
    TEST_ASSERT_EQUAL(1U, fixture.request_count); // 13 octets, one request.
}

/// When the supervisor has room again, communication waits for missing octets again.
static void a_participant_is_awaited_again_when_the_supervisor_has_room(void)
{
    fixture_connect(0U);
    fixture.participant    = fixture.ports[0];
    fixture.is_uplink_full = true;
    fixture_write_request(0U, 1U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&fixture.communication.clients[0].socket, 1000U));
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 26U));
    fixture.is_uplink_full = false;
    TEST_ASSERT_TRUE(communication_take_in(&fixture.communication, 0U)); // The second request is in transit.
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
}

static void no_participant_is_awaited_before_the_port_is_open(void)
{
    fixture_close();
    fixture_open();
    TEST_ASSERT_FALSE(communication_take_in(&fixture.communication, 13U));
}

/// The rest of a report may be a single octet; it is counted as well.
static void a_single_octet_that_is_sent_is_counted(void)
{
    fixture_connect(0U);
    fixture_report(0U, 5U, 1U, 7U, 0U);
    communication_ground_queue_t* const queue = &fixture.communication.queues[0];
    size_t size                               = 0U;
    communication_send_out(&fixture.communication);
    fixture_report(0U, 5U, 1U, 8U, 0U);
    (void)communication_ground_queue_next(queue, &size);
    communication_ground_queue_sent(queue, size - 1U);
    const uint32_t before = fixture.sent[0];
    communication_send_out(&fixture.communication);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, fixture.sent[0]);
}

/// The shortest report with a destination, and a report shorter by one octet.
static void a_report_that_ends_before_its_destination_goes_to_no_client(void)
{
    const subsystem_callbacks_t* const callbacks = communication_callbacks();
    const uint8_t octets[13]                     = {[0] = 0x08U, [7] = 5U, [8] = 1U};
    communication_ground_queue_t* const queue    = &fixture.communication.queues[0];
    fixture_connect(0U);
    const uint32_t before = communication_ground_queue_count(queue);
    callbacks->report(&fixture.communication, octets, sizeof octets - 1U);
    TEST_ASSERT_EQUAL_UINT32(before, communication_ground_queue_count(queue));
    callbacks->report(&fixture.communication, octets, sizeof octets);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, communication_ground_queue_count(queue));
}

/// A packet that is one octet too short for source and checksum names no user; the shortest packet with both
/// names the user of its client.
static void a_packet_that_ends_before_its_source_names_no_user(void)
{
    uint8_t octets[13] = {0x18U, 0x10U, 0xC0U, 0x00U, 0x00U, 0x05U, 0x2FU, 17U, 1U, 0x00U, 0x07U};
    fixture_connect(0U);
    fixture_write(0U, octets, sizeof octets - 1U);
    fixture_run_until_requests(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.communication.routes.users[0].clients);
    octets[5] = 0x06U;
    fixture_write(0U, octets, sizeof octets);
    fixture_run_until_requests(2U);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.communication.routes.users[0].clients);
    TEST_ASSERT_EQUAL_UINT16(7U, fixture.communication.routes.users[0].user);
}

static void waiting_reports_and_sockets_are_published(void)
{
    const communication_parameters_t* const shown = &fixture.communication.parameters;
    fixture_connect(0U);
    fixture_connect(1U);
    TEST_ASSERT_EQUAL_UINT32(fixture.communication.sockets.stats.peak, shown->counters.socket_peak);
    TEST_ASSERT_TRUE(shown->counters.socket_peak >= 2U);
    fixture.communication.sockets.stats.refused = 7U;
    fixture_report(0U, 5U, 1U, 1U, 0U);
    fixture_report(0U, 5U, 1U, 2U, 0U);
    (void)subsystem_step(&fixture.component, fixture.now_ns); // No report is sent in this step.
    TEST_ASSERT_EQUAL_UINT16(2U, shown->status.connections);
    TEST_ASSERT_EQUAL_UINT16(communication_ground_queue_count(&fixture.communication.queues[0]) +
                                 communication_ground_queue_count(&fixture.communication.queues[1]),
                             shown->status.queued);
    TEST_ASSERT_TRUE(shown->status.queued >= 4U);
    TEST_ASSERT_EQUAL_UINT32(7U, shown->counters.socket_refused);
}

/// Request id of a request of the fixture, as fixture_report writes a number.
static uint32_t id_of(const uint16_t sequence)
{
    const uint8_t octets[4] = {0x18U, 0x10U, (uint8_t)(0xC0U | (sequence >> 8U)), (uint8_t)sequence};
    uint32_t number         = 0U;
    (void)memcpy(&number, octets, sizeof number);
    return number;
}

/// Two stations of one user have requests in progress at the same time.
static void each_connection_of_a_user_gets_its_own_verifications(void)
{
    fixture_connect(0U);
    fixture_connect(1U);
    for (uint16_t i = 0U; i < 10U; i++) {
        fixture_write_request(0U, 1U, 100U + i, 0U);
        fixture_write_request(1U, 1U, 200U + i, 0U);
        fixture_run_until_requests((2U * i) + 2U);
    }
    for (uint8_t subtype = 1U; subtype <= 7U; subtype += 2U) {
        for (uint16_t i = 0U; i < 10U; i++) {
            fixture_report(1U, 1U, subtype, id_of(109U - i), 0U);
            fixture_report(1U, 1U, subtype, id_of(200U + i), 0U);
        }
        fixture_step();
        for (uint16_t i = 0U; i < 10U; i++) {
            TEST_ASSERT_EQUAL_HEX32(id_of(109U - i), fixture_next_report(0U));
            TEST_ASSERT_EQUAL_HEX32(id_of(200U + i), fixture_next_report(1U));
        }
    }
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(0U));
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(1U));
    TEST_ASSERT_EQUAL(0U, fixture.communication.routes.forgotten);
}

/// Reports about forgotten requests still reach the connection that has sent them, and an event reports this.
static void a_request_beyond_the_table_is_counted_and_loses_no_verification(void)
{
    fixture_run(100U);
    fixture_connect(0U);
    fixture_connect(1U);
    fixture_write_request(0U, 1U, 1U, 0U);
    fixture_run_until_requests(1U);
    for (uint16_t i = 0U; i < GROUND_REQUESTS; i++) {
        fixture_write_request(1U, 1U, 1000U + i, 0U);
    }
    fixture_run_until_requests(GROUND_REQUESTS + 1U);
    fixture_run(100U);
    TEST_ASSERT_EQUAL(1U, fixture.communication.parameters.clients.forgotten);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
    fixture_report(1U, 1U, 7U, id_of(1U), 0U);
    fixture_report(1U, 1U, 7U, id_of(1000U), 0U);
    fixture_step();
    TEST_ASSERT_EQUAL_HEX32(id_of(1U), fixture_next_report(0U));
    TEST_ASSERT_EQUAL(UINT32_MAX, fixture_next_report(0U));
    TEST_ASSERT_EQUAL_HEX32(id_of(1U), fixture_next_report(1U)); // This connection may have sent the request.
    TEST_ASSERT_EQUAL_HEX32(id_of(1000U), fixture_next_report(1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(idle_clients_are_disconnected_to_make_room);
    RUN_TEST(busy_clients_are_served_in_turn);
    RUN_TEST(a_client_without_a_valid_request_loses_its_slot);
    RUN_TEST(a_participant_keeps_its_slot);
    RUN_TEST(a_new_participant_gets_a_slot_at_once);
    RUN_TEST(misuse_is_counted_and_reported_once_a_second);
    RUN_TEST(a_client_with_the_source_of_a_user_on_board_is_counted_and_reported);
    RUN_TEST(a_client_that_does_not_read_is_no_longer_read);
    RUN_TEST(a_release_ends_every_connection);
    RUN_TEST(each_kind_of_misuse_is_reported_alone_and_with_any_other);
    RUN_TEST(a_client_loses_its_slot_after_10_s_of_silence);
    RUN_TEST(a_participant_gets_the_slot_of_a_client_that_came_with_it);
    RUN_TEST(octets_announced_before_the_connection_are_taken_after_it);
    RUN_TEST(a_participant_is_awaited_again_when_the_supervisor_has_room);
    RUN_TEST(no_participant_is_awaited_before_the_port_is_open);
    RUN_TEST(a_single_octet_that_is_sent_is_counted);
    RUN_TEST(a_report_that_ends_before_its_destination_goes_to_no_client);
    RUN_TEST(a_packet_that_ends_before_its_source_names_no_user);
    RUN_TEST(waiting_reports_and_sockets_are_published);
    RUN_TEST(each_connection_of_a_user_gets_its_own_verifications);
    RUN_TEST(a_request_beyond_the_table_is_counted_and_loses_no_verification);
    return UNITY_END();
}
