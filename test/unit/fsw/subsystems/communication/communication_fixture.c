// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/subsystems/communication/communication_fixture.h"
#include "test/support/clients.h"

#include "unity.h"

#include <poll.h>
#include <string.h>

#define PERIOD_NS 10000000ULL
#define ARRIVAL_MS 20
#define MAX_ATTEMPTS 500U ///< Steps, or attempts to read or write, before a test fails.

fixture_t fixture;

static descriptor_loader_t loader;

// ---- Hooks and port ----

static status_t send_up(void* context, const uint8_t* packet, size_t size)
{
    (void)context;
    pus_tc_t tc;
    pus_tm_t tm;
    pus_failure_t failure;
    if (!pus_packet_is_tc(packet, size)) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
        if ((tm.service == PUS_SERVICE_EVENTS) && (tm.size >= 2U) && (tm.data[1] < 32U)) {
            fixture.events[tm.data[1]]++;
        }
        return STATUS_OK;
    }
    if (fixture.is_uplink_full ||
        ((fixture.uplink_room > 0U) && (fixture.request_count >= fixture.uplink_room))) {
        return STATUS_FULL;
    }
    const status_t decoded = pus_tc_decode(packet, size, &tc, &failure);
    (void)decoded; // The supervisor decides whether to accept the request.
    TEST_ASSERT_TRUE(fixture.request_count < FIXTURE_PACKETS);
    fixture.requests[fixture.request_count++] = (fixture_request_t){tc.source, tc.sequence, size};
    return STATUS_OK;
}

static void sent(void* context, uint16_t peer_port, uint32_t octets)
{
    (void)context;
    for (unsigned i = 0U; i < FIXTURE_CLIENTS; i++) {
        fixture.sent[i] += (fixture.ports[i] == peer_port) ? octets : 0U;
    }
}

static uint16_t participant_port(void* context)
{
    (void)context;
    return fixture.participant;
}

static void served(void* context, uint16_t port)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT16(fixture.participant, port);
    fixture.served++;
}

static void cut(void* context, uint16_t port)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT16(fixture.participant, port);
    fixture.participant = 0U;
    fixture.cut++;
}

static void intruded(void* context)
{
    (void)context;
    fixture.intrusions++;
}

// ---- Life ----

void fixture_open(void)
{
    static const communication_hooks_t hooks = {NULL, sent, participant_port, served, cut, intruded};
    const pus_port_t port                    = {NULL, send_up};
    (void)memset(&fixture, 0, sizeof fixture);
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL(
        STATUS_OK,
        descriptor_load_subsystem(&loader, "descriptors/subsystems/communication.xml", &fixture.descriptor));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      osal_tcp_listen(&fixture.listener, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&fixture.listener, &fixture.address));
    for (unsigned i = 0U; i < FIXTURE_CLIENTS; i++) {
        fixture.clients[i].descriptor = -1;
    }
    communication_init(&fixture.communication, &fixture.component, &port, &hooks,
                       osal_socket_descriptor(&fixture.listener));
    const subsystem_config_t config = {.descriptor            = &fixture.descriptor,
                                       .is_descriptor_valid   = true,
                                       .callbacks             = communication_callbacks(),
                                       .self                  = &fixture.communication,
                                       .start_count           = 1U,
                                       .port                  = port,
                                       .supervisor_timeout_ns = 3000000000U,
                                       .status_interval_ns    = SUBSYSTEM_STATUS_INTERVAL_NS};
    subsystem_init(&fixture.component, &config);
}

void fixture_open_up(void)
{
    fixture_open();
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_request(&fixture.component, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    fixture_run(5U);
    TEST_ASSERT_EQUAL(ANSWER_STARTED,
                      subsystem_select(&fixture.component, COMMUNICATION_CONFIGURATION_FLIGHT));
    fixture_run(2U);
    TEST_ASSERT_EQUAL(PHASE_CONFIGURED, fixture.component.machine.phase);
}

void fixture_close(void)
{
    for (unsigned i = 0U; i < FIXTURE_CLIENTS; i++) {
        fixture_disconnect(i);
    }
    const flow_tcp_user_t nobody = {0};
    flow_tcp_end_all(&fixture.communication.flow, &nobody);
    osal_socket_close(&fixture.listener);
}

void fixture_step(void)
{
    (void)communication_take_in(&fixture.communication, 0U);
    (void)subsystem_step(&fixture.component, fixture.now_ns);
    communication_send_out(&fixture.communication);
    fixture.now_ns += PERIOD_NS;
}

void fixture_run(unsigned steps)
{
    for (unsigned i = 0U; i < steps; i++) {
        fixture_step();
    }
}

void fixture_run_until_requests(unsigned count)
{
    for (unsigned i = 0U; (i < MAX_ATTEMPTS) && (fixture.request_count < count); i++) {
        fixture_step();
        (void)poll(NULL, 0U, (fixture.request_count < count) ? 1 : 0);
    }
    TEST_ASSERT_EQUAL(count, fixture.request_count);
}

// ---- Clients ----

void fixture_connect(unsigned client)
{
    osal_address_t own = {0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&fixture.clients[client], fixture.address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&fixture.clients[client], &own));
    fixture.ports[client] = own.port;
    fixture.sent[client]  = 0U;
    fixture_run(2U);
}

void fixture_disconnect(unsigned client)
{
    if (osal_socket_is_open(&fixture.clients[client])) {
        osal_socket_close(&fixture.clients[client]);
    }
}

void fixture_write(unsigned client, const uint8_t* octets, size_t size)
{
    size_t position = 0U;
    for (unsigned i = 0U; (position < size) && (i < MAX_ATTEMPTS); i++) {
        size_t taken = 0U;
        const status_t status =
            osal_stream_send(&fixture.clients[client], &octets[position], size - position, &taken);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_FULL));
        position += taken;
    }
    TEST_ASSERT_EQUAL(size, position);
}

size_t fixture_request(uint8_t packet[PUS_PACKET_MAX], uint16_t user, uint16_t sequence, size_t data)
{
    static const uint8_t filling[PUS_TC_DATA_MAX];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid     = 16U,
                         .sequence = sequence,
                         .ack      = 15U,
                         .service  = 17U,
                         .subtype  = 1U,
                         .source   = user,
                         .data     = filling,
                         .size     = data};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, PUS_PACKET_MAX, &size));
    return size;
}

void fixture_write_request(unsigned client, uint16_t user, uint16_t sequence, size_t data)
{
    static uint8_t packet[PUS_PACKET_MAX];
    const size_t size = fixture_request(packet, user, sequence, data);
    fixture_write(client, packet, size);
}

size_t fixture_read(unsigned client, uint8_t* octets, size_t capacity)
{
    size_t size             = 0U;
    const bool has_come     = (osal_socket_wait_readable(&fixture.clients[client], ARRIVAL_MS) == STATUS_OK);
    const status_t received = osal_stream_receive(&fixture.clients[client], octets, capacity, &size);
    return (has_come && (received == STATUS_OK)) ? size : 0U;
}

bool fixture_is_ended(unsigned client)
{
    uint8_t octets[1];
    size_t size         = 0U;
    const bool has_news = (osal_socket_wait_readable(&fixture.clients[client], ARRIVAL_MS) == STATUS_OK);
    return has_news &&
           (osal_stream_receive(&fixture.clients[client], octets, sizeof octets, &size) == STATUS_CLOSED);
}

// ---- Reports ----

void fixture_report(uint16_t destination, uint8_t service, uint8_t subtype, uint32_t number, size_t data)
{
    static uint8_t packet[PUS_PACKET_MAX];
    static uint8_t content[PUS_TM_DATA_MAX];
    size_t size = 0U;
    (void)memcpy(content, &number, sizeof number);
    const pus_tm_t tm = {.apid        = 16U,
                         .service     = service,
                         .subtype     = subtype,
                         .destination = destination,
                         .data        = content,
                         .size        = sizeof number + data};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, packet, sizeof packet, &size));
    subsystem_accept(&fixture.component, packet, size, fixture.now_ns);
}

uint32_t fixture_next_report(unsigned client)
{
    static uint8_t packet[PUS_PACKET_MAX];
    size_t held    = 0U;
    size_t wanted  = PUS_PRIMARY_HEADER_SIZE;
    unsigned tries = 0U;
    while (held < wanted) {
        const size_t size = fixture_read(client, &packet[held], wanted - held);
        if (size == 0U) { // The kernel accepts the rest when it has room again.
            tries++;
            if ((tries > 3U) && (held == 0U)) {
                return UINT32_MAX;
            }
            TEST_ASSERT_TRUE_MESSAGE(tries < MAX_ATTEMPTS, "a report was cut");
            communication_send_out(&fixture.communication);
        }
        held += size;
        if ((size > 0U) && (held == PUS_PRIMARY_HEADER_SIZE)) {
            wanted = 7U + (((size_t)packet[4] << 8U) | packet[5]);
        }
    }
    pus_tm_t tm;
    pus_failure_t failure;
    uint32_t number = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, held, &tm, &failure));
    (void)memcpy(&number, tm.data, sizeof number);
    return number;
}
