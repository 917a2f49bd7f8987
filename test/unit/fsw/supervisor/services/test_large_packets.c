// SPDX-License-Identifier: Apache-2.0
// A request that came in parts is routed like a request that came in one packet; a report longer than a
// packet is sent in parts.
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include "base/crc.h"

#include <string.h>

#define PART 400U
// The first parameter of the supervisor, a structure.
#define SUPERVISOR_STATUS ((1UL << 21U) | (24UL << 16U))
#define VALUES_ASKED 255U
#define REPORT_PARTS 12U // Parts of a report of 255 values of 24 octets.

static uint8_t whole[PUS_LARGE_MAX];
static size_t whole_size;

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

/// Make a request with number 99 and `size` octets of data: `data`, then zeros.
static void make_request(const uint16_t apid, const uint8_t service, const uint8_t subtype,
                         const uint16_t source, const void* const data, const size_t begin, const size_t size)
{
    memset(whole, 0, sizeof whole);
    whole_size = PUS_TC_MIN + size;
    octets_put_u16(whole, (uint16_t)(0x1800U | apid));
    octets_put_u16(&whole[2], 0xC000U | 99U); // Not segmented; sequence count 99.
    octets_put_u16(&whole[4], (uint16_t)(whole_size - 7U));
    whole[6] = 0x2FU; // PUS version 2; acknowledge all stages.
    whole[7] = service;
    whole[8] = subtype;
    octets_put_u16(&whole[9], source);
    memcpy(&whole[11], data, begin);
    octets_put_u16(&whole[whole_size - 2U], crc16_ccitt(whole, whole_size - 2U));
}

static void send_part(const uint16_t number, const size_t sent, const size_t size, const bool is_last)
{
    uint8_t data[4U + PART] = {0U, 7U, (uint8_t)(number >> 8U), (uint8_t)number};
    const uint8_t between   = (number == 1U) ? 9U : 10U;
    memcpy(&data[4], &whole[sent], size);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_LARGE_PACKETS, is_last ? 11U : between, data, 4U + size);
    fixture_run(1U);
}

/// Send the request in at least two parts, without requesting reports about the parts.
static void send_request(void)
{
    uint16_t number = 1U;
    size_t sent     = 0U;
    fixture.ack     = 0U;
    for (size_t part = (whole_size > PART) ? PART : 8U; sent < whole_size; number++) {
        const size_t left = whole_size - sent;
        send_part(number, sent, (left < part) ? left : part, left <= part);
        sent += (left < part) ? left : part;
    }
    fixture.ack = PUS_ACK_ALL;
}

static void request_values(void)
{
    static uint8_t data[1U + (4U * VALUES_ASKED)] = {VALUES_ASKED};
    for (size_t i = 0U; i < VALUES_ASKED; i++) {
        octets_put_u32(&data[1U + (4U * i)], SUPERVISOR_STATUS);
    }
    make_request(SUPERVISOR_APID, PUS_SERVICE_PARAMETERS, 1U, FIXTURE_USER, data, sizeof data, sizeof data);
    send_request();
}

static void a_request_in_parts_is_routed(void)
{
    const uint8_t target = (uint8_t)STATE_PRE_OPERATIONAL;
    make_request(ARM, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REQUEST_STATE, FIXTURE_USER, &target, 1U, 1U);
    send_request();
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 03 from 1"));
    TEST_ASSERT_TRUE(fixture_has("G/16 1.7 #99"));
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.supervisor.spacecraft.large_packets.service.counters.requests);
}

static void requests_in_parts_need_the_same_permission(void)
{
    make_request(ARM, PUS_SERVICE_FUNCTIONS, 1U, FIXTURE_USER, "MOVE\0\0\0", 8U, 8U);
    send_request();
    fixture_run(1U);
    fixture_expect("G 1.2 #99 0110 100\n");
    make_request(99U, PUS_SERVICE_TEST, 1U, FIXTURE_USER, "", 0U, 0U);
    send_request();
    fixture_run(1U);
    fixture_expect("G 1.10 #99 0001 63\n");
    const uint8_t none = 0U; // TC[17,1] has no application data.
    make_request(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, FIXTURE_USER, &none, 1U, 60000U);
    send_request();
    fixture_run(1U);
    fixture_expect("G 1.2 #99 0108 0\n");
}

static void a_request_to_another_subsystem_must_fit_a_packet(void)
{
    make_request(ARM, PUS_SERVICE_TEST, 1U, FIXTURE_USER, "", 0U, PUS_TC_DATA_MAX + 1U);
    fixture.ack = 0U;
    send_part(1U, 0U, PART, false);
    TEST_ASSERT_TRUE(fixture_has("G 13.16 000703"));
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #0 0205 1000"));
}

/// ARM's inbox is full, so the request waits until it has room.
static void a_request_waits_for_room(void)
{
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    fixture.ack                                = 0U;
    for (unsigned i = 0U; i < MESSAGE_WINDOW; i++) {
        (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, "", 0U);
        fixture_step();
    }
    make_request(ARM, PUS_SERVICE_TEST, 1U, FIXTURE_USER, "", 0U, 0U);
    send_request();
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.spacecraft.large_packets.service.counters.requests);
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    fixture_run(3U);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.supervisor.spacecraft.large_packets.service.counters.requests);
    TEST_ASSERT_TRUE(fixture_has("G/16 1.1 #99"));
}

/// Parts from a user on board become a request of this user.
static void a_user_on_board_may_send_parts(void)
{
    uint8_t packet[PUS_TC_MIN + 4U + 32U];
    make_request(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, PUS_USER_ONBOARD | ARM, "", 0U, 0U);
    for (uint8_t i = 0U; i < 2U; i++) {
        const size_t first   = (i == 0U) ? 0U : 8U;
        const size_t size    = (i == 0U) ? 8U : (whole_size - 8U);
        uint8_t data[4U + 8] = {0U, 7U, 0U, (uint8_t)(i + 1U)};
        size_t packet_size   = 0U;
        const pus_tc_t tc    = {.apid    = SUPERVISOR_APID,
                                .service = PUS_SERVICE_LARGE_PACKETS,
                                .subtype = (uint8_t)(9U + (2U * i)),
                                .source  = PUS_USER_ONBOARD | ARM,
                                .data    = data,
                                .size    = 4U + size};
        memcpy(&data[4], &whole[first], size);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &packet_size));
        fixture_send(FIXTURE_ARM, packet, packet_size);
        fixture_run(1U);
    }
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.supervisor.spacecraft.large_packets.service.counters.requests);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.counters.tc_forbidden);
}

static void a_report_longer_than_a_packet_is_sent_in_parts(void)
{
    request_values();
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #99"));
    TEST_ASSERT_TRUE(fixture_has("G 13.1 00000001"));
    TEST_ASSERT_TRUE(fixture_has("G 13.2 00000002"));
    TEST_ASSERT_TRUE(fixture_has("G 13.3 0000000C"));
    TEST_ASSERT_EQUAL_UINT32(REPORT_PARTS,
                             fixture.supervisor.spacecraft.large_packets.service.counters.parts);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.spacecraft.large_packets.service.counters.aborted);
}

/// Parts leave the credit that other reports need, and no part is lost.
static void parts_wait_for_credit_of_the_ground(void)
{
    const pus_large_t* const service              = &fixture.supervisor.spacecraft.large_packets.service;
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 8U; i++) {
        request_values();
        fixture_run(2U);
    }
    TEST_ASSERT_TRUE(service->counters.reports < 8U);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_room(&fixture.supervisor.ground_backlog, PUS_CLASS_FIRM) >
                     16384U);
    // Reports without a free buffer were refused.
    const uint32_t lost                           = service->counters.refused;
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    fixture_run(100U);
    TEST_ASSERT_EQUAL_UINT32(8U - lost, service->counters.reports);
    TEST_ASSERT_EQUAL_UINT32((8U - lost) * REPORT_PARTS, service->counters.parts);
    TEST_ASSERT_EQUAL_UINT32(0U,
                             fixture.supervisor.ground.dropped_bulk + fixture.supervisor.ground.dropped_firm);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_in_parts_is_routed);
    RUN_TEST(requests_in_parts_need_the_same_permission);
    RUN_TEST(a_request_to_another_subsystem_must_fit_a_packet);
    RUN_TEST(a_request_waits_for_room);
    RUN_TEST(a_user_on_board_may_send_parts);
    RUN_TEST(a_report_longer_than_a_packet_is_sent_in_parts);
    RUN_TEST(parts_wait_for_credit_of_the_ground);
    return UNITY_END();
}
