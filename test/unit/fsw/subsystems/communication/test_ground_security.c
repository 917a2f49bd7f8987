// SPDX-License-Identifier: Apache-2.0
// Communication with a key: accepted requests, refused ones and their events, and disconnected clients.
#include "test/support/recorded_media.h"
#include "test/support/sealer.h"
#include "test/unit/fsw/subsystems/communication/communication_fixture.h"
#include "unity.h"

#include <string.h>

#define PART 988U

static const image_t empty[2];
static sdls_receiver_t receiver;
static uint32_t session;
static uint32_t count;

void setUp(void)
{
    recorded_clear(empty);
    recorded.fail_from    = 0U;
    const medium_t medium = recorded_medium(0U);
    sealer_make_mark(&medium, sealer_key, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_open(&receiver, sealer_key, &medium));
    session = 0U;
    fixture_open_up();
    communication_secure(&fixture.communication, &receiver);
}

void tearDown(void)
{
    fixture_close();
}

static void connect(const unsigned client)
{
    fixture_connect(client);
    session++;
    count = 0U;
}

static void make(sealed_t* const frame, const uint8_t flags, const uint8_t* const octets, const size_t size)
{
    *frame = (sealed_t){.session = session, .count = count, .spi = SDLS_SPI, .part = flags};
    seal(frame, sealer_key, octets, size);
}

static void send(const unsigned client, const uint8_t flags, const uint8_t* const octets, const size_t size)
{
    sealed_t frame;
    make(&frame, flags, octets, size);
    fixture_write(client, frame.octets, frame.size);
    count++;
}

static void send_request(const unsigned client, const uint16_t sequence, const size_t data)
{
    uint8_t packet[PUS_PACKET_MAX];
    const size_t size = fixture_request(packet, 1U, sequence, data);
    for (size_t at = 0U; at < size; at += PART) {
        const bool is_last  = ((size - at) <= PART);
        const uint8_t flags = (uint8_t)(((at == 0U) ? SEALER_FIRST : 0U) | (is_last ? SEALER_LAST : 0U));
        send(client, flags, &packet[at], is_last ? (size - at) : PART);
    }
}

static bool ends(const unsigned client)
{
    for (unsigned i = 0U; i < 200U; i++) {
        fixture_run(1U);
        if (fixture_is_ended(client)) {
            return true;
        }
    }
    return false;
}

static void run_until_refused(const uint32_t* const counter, const uint32_t times)
{
    for (unsigned i = 0U; (i < 2000U) && (*counter < times); i++) {
        fixture_run(1U);
    }
    TEST_ASSERT_EQUAL_UINT32(times, *counter);
}

static void authentic_requests_are_forwarded(void)
{
    connect(0U);
    send_request(0U, 1U, 0U);
    send_request(0U, 2U, PUS_TC_DATA_MAX); // In five frames.
    send_request(0U, 3U, 10U);
    fixture_run_until_requests(3U);
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT16(i + 1U, fixture.requests[i].sequence);
    }
    TEST_ASSERT_EQUAL(PUS_PACKET_MAX, fixture.requests[1].size);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT8(1U, fixture.communication.parameters.security.is_on);
    TEST_ASSERT_EQUAL_UINT32(7U, fixture.communication.parameters.security.accepted);
    fixture_report(1U, 17U, 2U, 5U, 0U); // A report reaches the client of its user.
    TEST_ASSERT_EQUAL_UINT32(5U, fixture_next_report(0U));
}

static void requests_wait_until_the_supervisor_has_room(void)
{
    connect(0U);
    fixture.uplink_room = 1U;
    send_request(0U, 1U, 0U);
    send_request(0U, 2U, PUS_TC_DATA_MAX);
    fixture_run_until_requests(1U);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
    fixture.uplink_room = 0U;
    fixture_run_until_requests(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, fixture.requests[1].sequence);
    TEST_ASSERT_EQUAL_UINT32(6U, receiver.accepted);
    TEST_ASSERT_EQUAL_UINT32(0U, receiver.refused[SDLS_REFUSED_REPLAYED]);
}

static void packets_without_protection_end_their_connection(void)
{
    connect(0U);
    fixture_write_request(0U, 1U, 1U, 0U);
    TEST_ASSERT_TRUE(ends(0U));
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    TEST_ASSERT_EQUAL_UINT32(1U, receiver.refused[SDLS_REFUSED_FRAME]);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.communication.parameters.security.no_frame);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_TC_NOT_AUTHENTIC]);
}

static void the_third_refusal_ends_a_connection(void)
{
    sealed_t frame;
    uint8_t packet[PUS_PACKET_MAX];
    const size_t size = fixture_request(packet, 1U, 1U, 0U);
    connect(0U);
    make(&frame, SEALER_WHOLE, packet, size);
    frame.octets[frame.size - 1U] ^= 1U;
    fixture_write(0U, frame.octets, frame.size);
    fixture_write(0U, frame.octets, frame.size);
    run_until_refused(&receiver.refused[SDLS_REFUSED_FORGED], 2U);
    send(0U, SEALER_WHOLE, packet, size); // A frame of the operator is accepted between the refused ones.
    fixture_run_until_requests(1U);
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
    fixture_write(0U, frame.octets, frame.size);
    TEST_ASSERT_TRUE(ends(0U));
    connect(1U); // Other connections are not affected.
    send_request(1U, 2U, 0U);
    fixture_run_until_requests(2U);
}

static void a_recorded_connection_cannot_be_replayed(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    sealed_t frame;
    const size_t size = fixture_request(packet, 1U, 1U, 0U);
    connect(0U);
    make(&frame, SEALER_WHOLE, packet, size);
    fixture_write(0U, frame.octets, frame.size);
    fixture_run_until_requests(1U);
    fixture_connect(1U);
    fixture_write(1U, frame.octets, frame.size);
    run_until_refused(&receiver.refused[SDLS_REFUSED_REPLAYED], 1U);
    fixture_disconnect(0U);
    fixture_run(5U);
    fixture_connect(2U);
    fixture_write(2U, frame.octets, frame.size);
    run_until_refused(&receiver.refused[SDLS_REFUSED_REPLAYED], 2U);
    TEST_ASSERT_EQUAL(1U, fixture.request_count);
}

static void an_authentic_frame_must_contain_exactly_one_request(void)
{
    uint8_t packet[2U * PUS_PACKET_MAX];
    const size_t size = fixture_request(packet, 1U, 1U, 0U);
    connect(0U);
    send(0U, SEALER_WHOLE, packet, size - 1U);
    memcpy(&packet[size], packet, size);
    send(0U, SEALER_WHOLE, packet, 2U * size);
    run_until_refused(&receiver.refused[SDLS_REFUSED_PARTS], 2U);
    packet[0] &= 0xEFU; // A report.
    send(0U, SEALER_WHOLE, packet, size);
    send_request(0U, 7U, 0U);
    fixture_run_until_requests(1U);
    TEST_ASSERT_EQUAL_UINT16(7U, fixture.requests[0].sequence);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.communication.parameters.counters.tc_refused);
    TEST_ASSERT_EQUAL_UINT32(2U, fixture.communication.parameters.security.bad_parts);
}

static void many_refusals_are_reported_by_few_events(void)
{
    for (unsigned i = 0U; i < 40U; i++) {
        connect(0U);
        fixture_write_request(0U, 1U, 1U, 0U);
        TEST_ASSERT_TRUE(ends(0U));
        fixture_disconnect(0U);
    }
    fixture_run(GROUND_EVENT_CYCLES);
    TEST_ASSERT_EQUAL_UINT32(40U, fixture.communication.parameters.security.no_frame);
    const unsigned reported = fixture.events[COMMUNICATION_EVENT_TC_NOT_AUTHENTIC];
    // The first event comes at once, the last one when all refusals are counted.
    TEST_ASSERT_TRUE((reported >= 2U) && (reported <= 4U));
    fixture_run(2U * GROUND_EVENT_CYCLES);
    TEST_ASSERT_EQUAL(reported, fixture.events[COMMUNICATION_EVENT_TC_NOT_AUTHENTIC]);
}

static void a_counter_that_cannot_be_stored_is_reported(void)
{
    connect(0U);
    recorded.calls      = 0U;
    recorded.fail_from  = 1U;
    recorded.fail_count = 1000U;
    recorded.failure    = STATUS_IO;
    send_request(0U, 1U, 0U);
    run_until_refused(&receiver.refused[SDLS_REFUSED_NOT_KEPT], 1U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(0U, fixture.request_count);
    TEST_ASSERT_EQUAL(1U, fixture.events[COMMUNICATION_EVENT_TC_NOT_KEPT]);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.communication.parameters.security.not_kept);
    recorded.fail_from = 0U;
    connect(1U);
    send_request(1U, 2U, 0U);
    fixture_run_until_requests(1U);
}

static void clients_without_authentication_make_room_for_others(void)
{
    for (unsigned i = 0U; i < GROUND_CLIENTS; i++) {
        connect(i);
    }
    const uint32_t sessions = session;
    session                 = 1U; // One client proves that it has the key.
    send_request(2U, 1U, 0U);
    session = sessions;
    fixture_run_until_requests(1U);
    connect(GROUND_CLIENTS);
    send_request(GROUND_CLIENTS, 2U, 0U);
    fixture_run_until_requests(2U);
    TEST_ASSERT_TRUE(ends(0U)); // The client that had connected first.
    connect(GROUND_CLIENTS + 1U);
    TEST_ASSERT_TRUE(ends(1U));
    connect(GROUND_CLIENTS + 2U);
    TEST_ASSERT_TRUE(ends(3U));
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_is_ended(2U) || fixture_is_ended(GROUND_CLIENTS) ||
                      fixture_is_ended(GROUND_CLIENTS + 1U) || fixture_is_ended(GROUND_CLIENTS + 2U));
    // The participant stays although it has not yet proved that it has the key.
    fixture.participant = fixture.ports[4];
    connect(GROUND_CLIENTS + 3U);
    TEST_ASSERT_TRUE(ends(5U));
    TEST_ASSERT_FALSE(fixture_is_ended(4U) || fixture_is_ended(GROUND_CLIENTS + 3U));
}

/// The key identifies the operator: a client that has proved to have it and continues to send keeps its slot.
static void busy_clients_with_the_key_keep_their_slots(void)
{
    for (unsigned i = 0U; i < GROUND_CLIENTS; i++) {
        connect(i);
    }
    uint32_t requests = 0U;
    for (unsigned round = 0U; round < ((COMMUNICATION_HOLD_NS / COMMUNICATION_IDLE_NS) * 2U) + 1U; round++) {
        for (unsigned i = 0U; i < GROUND_CLIENTS; i++) {
            session = i + 1U;
            count   = round;
            send_request(i, 1U, 0U);
            requests++;
            fixture_run_until_requests(requests);
        }
        fixture_run((unsigned)(COMMUNICATION_IDLE_NS / 20000000U));
    }
    connect(GROUND_CLIENTS);
    TEST_ASSERT_TRUE(ends(GROUND_CLIENTS));
    for (unsigned i = 0U; i < GROUND_CLIENTS; i++) {
        TEST_ASSERT_FALSE(fixture_is_ended(i));
    }
}

static void without_a_key_every_client_counts_as_authenticated(void)
{
    communication_ground_security_init(&fixture.communication.security, NULL);
    for (unsigned i = 0U; i <= GROUND_CLIENTS; i++) {
        connect(i);
    }
    TEST_ASSERT_TRUE(ends(GROUND_CLIENTS));
    TEST_ASSERT_FALSE(fixture_is_ended(0U));
}

static void each_refusal_is_published_under_its_name(void)
{
    const communication_security_t* const shown = &fixture.communication.parameters.security;
    for (unsigned i = 0U; i < (unsigned)SDLS_REFUSALS; i++) {
        receiver.refused[i] = i + 1U;
    }
    receiver.accepted = 9U;
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, shown->no_frame);
    TEST_ASSERT_EQUAL_UINT32(2U, shown->unknown_spi);
    TEST_ASSERT_EQUAL_UINT32(3U, shown->forged);
    TEST_ASSERT_EQUAL_UINT32(4U, shown->replayed);
    TEST_ASSERT_EQUAL_UINT32(5U, shown->bad_parts);
    TEST_ASSERT_EQUAL_UINT32(6U, shown->not_kept);
    TEST_ASSERT_EQUAL_UINT32(9U, shown->accepted);
}

/// Every GROUND_EVENT_CYCLES at most one event reports the refusals since the last one: TC_NOT_KEPT if a
/// mark could not be stored, otherwise TC_NOT_AUTHENTIC.
static void refusals_of_each_kind_are_reported_at_exact_intervals(void)
{
    const unsigned* const forged = &fixture.events[COMMUNICATION_EVENT_TC_NOT_AUTHENTIC];
    const unsigned* const lost   = &fixture.events[COMMUNICATION_EVENT_TC_NOT_KEPT];
    receiver.refused[SDLS_REFUSED_FORGED]++;
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT(1U, *forged);
    receiver.refused[SDLS_REFUSED_NOT_KEPT]++;
    fixture_run(GROUND_EVENT_CYCLES - 1U);
    TEST_ASSERT_EQUAL_UINT(0U, *lost);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT(1U, *lost);
    receiver.refused[SDLS_REFUSED_REPLAYED]++;
    fixture_run(GROUND_EVENT_CYCLES);
    TEST_ASSERT_EQUAL_UINT(2U, *forged); // No mark failed since the last event.
    TEST_ASSERT_EQUAL_UINT(1U, *lost);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(authentic_requests_are_forwarded);
    RUN_TEST(requests_wait_until_the_supervisor_has_room);
    RUN_TEST(packets_without_protection_end_their_connection);
    RUN_TEST(the_third_refusal_ends_a_connection);
    RUN_TEST(a_recorded_connection_cannot_be_replayed);
    RUN_TEST(an_authentic_frame_must_contain_exactly_one_request);
    RUN_TEST(many_refusals_are_reported_by_few_events);
    RUN_TEST(a_counter_that_cannot_be_stored_is_reported);
    RUN_TEST(clients_without_authentication_make_room_for_others);
    RUN_TEST(busy_clients_with_the_key_keep_their_slots);
    RUN_TEST(without_a_key_every_client_counts_as_authenticated);
    RUN_TEST(each_refusal_is_published_under_its_name);
    RUN_TEST(refusals_of_each_kind_are_reported_at_exact_intervals);
    return UNITY_END();
}
