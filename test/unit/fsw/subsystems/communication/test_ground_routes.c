// SPDX-License-Identifier: Apache-2.0
// Connections to which a report is sent: by user, by request, and with full tables.
#include "fsw/subsystems/communication/ground_routes.h"

#include "unity.h"

#include <string.h>

#define COMPLETION PUS_ACK_COMPLETION

static communication_ground_routes_t routes;

void setUp(void)
{
    communication_ground_routes_init(&routes);
}

void tearDown(void)
{
}

static void note(const unsigned client, const uint16_t user, const uint16_t apid, const uint16_t sequence,
                 const uint8_t ack)
{
    const uint8_t packet[PUS_TC_HEADER_SIZE] = {(uint8_t)(0x18U | (apid >> 8U)),
                                                (uint8_t)apid,
                                                (uint8_t)(0xC0U | (sequence >> 8U)),
                                                (uint8_t)sequence,
                                                0U,
                                                6U,
                                                (uint8_t)(0x20U | ack),
                                                17U,
                                                1U,
                                                (uint8_t)(user >> 8U),
                                                (uint8_t)user};
    communication_ground_routes_note(&routes, client, packet);
}

/// Returns the clients, one bit each, that receive a verification report of a request.
static uint32_t clients_of(const uint16_t user, const uint16_t apid, const uint16_t sequence,
                           const uint8_t subtype)
{
    uint8_t packet[PUS_TM_HEADER_SIZE + 4U + PUS_CRC_SIZE] = {0x08U, 0x01U};
    packet[7]                                              = PUS_SERVICE_VERIFICATION;
    packet[8]                                              = subtype;
    packet[PUS_TM_HEADER_SIZE]                             = (uint8_t)(0x18U | (apid >> 8U));
    packet[PUS_TM_HEADER_SIZE + 1U]                        = (uint8_t)apid;
    packet[PUS_TM_HEADER_SIZE + 2U]                        = (uint8_t)(0xC0U | (sequence >> 8U));
    packet[PUS_TM_HEADER_SIZE + 3U]                        = (uint8_t)sequence;
    return communication_ground_routes_of(&routes, user, packet, sizeof packet);
}

static void a_request_is_known_by_user_apid_and_count(void)
{
    note(0U, 1U, 16U, 0x2001U, COMPLETION);
    note(1U, 1U, 0x410U, 0x2001U, COMPLETION);
    note(2U, 1U, 16U, 1U, COMPLETION);
    note(3U, 3U, 16U, 0x2001U, COMPLETION);
    TEST_ASSERT_EQUAL_HEX32(1U << 0U, clients_of(1U, 16U, 0x2001U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U << 1U, clients_of(1U, 0x410U, 0x2001U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U << 2U, clients_of(1U, 16U, 1U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U << 3U, clients_of(3U, 16U, 0x2001U, 1U));
    TEST_ASSERT_EQUAL_HEX32(0x7U, clients_of(1U, 17U, 1U, 1U)); // An unknown request of a known user.
    TEST_ASSERT_EQUAL_HEX32(0U, clients_of(2U, 16U, 1U, 1U));
}

/// After the last report of a request, its number belongs to the next request.
static void a_request_is_known_until_its_end(void)
{
    static const uint8_t ends[] = {2U, 7U, 8U, 10U};
    for (size_t i = 0U; i < sizeof ends; i++) {
        setUp();
        note(0U, 1U, 16U, 1U, COMPLETION);
        note(1U, 1U, 16U, 2U, COMPLETION);
        TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 1U));
        TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 3U));
        TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 5U));
        TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 6U));
        TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, ends[i]));
        note(1U, 1U, 16U, 1U, COMPLETION);
        TEST_ASSERT_EQUAL_HEX32(2U, clients_of(1U, 16U, 1U, 1U));
    }
}

/// A request of several instructions: one is refused, the report about the others follows.
static void a_refused_start_is_not_the_end(void)
{
    note(0U, 1U, 16U, 1U, COMPLETION);
    note(1U, 1U, 16U, 2U, COMPLETION);
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 4U));
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 7U));
}

static void two_connections_with_the_same_count_are_both_informed(void)
{
    note(0U, 1U, 16U, 1U, COMPLETION);
    note(1U, 1U, 16U, 1U, COMPLETION);
    TEST_ASSERT_EQUAL_HEX32(3U, clients_of(1U, 16U, 1U, 7U));
    TEST_ASSERT_EQUAL_HEX32(3U, clients_of(1U, 16U, 1U, 7U));
}

static void other_reports_go_to_each_connection_of_the_user(void)
{
    uint8_t packet[PUS_TM_HEADER_SIZE + 4U] = {[7] = PUS_SERVICE_HOUSEKEEPING, [8] = 25U};
    note(0U, 1U, 16U, 1U, COMPLETION);
    note(31U, 1U, 16U, 2U, 0U);
    note(2U, 3U, 16U, 3U, COMPLETION);
    TEST_ASSERT_EQUAL_HEX32(0x80000001U, communication_ground_routes_of(&routes, 1U, packet, sizeof packet));
    TEST_ASSERT_EQUAL_HEX32(4U, communication_ground_routes_of(&routes, 3U, packet, sizeof packet));
    packet[7] = PUS_SERVICE_VERIFICATION; // The report ends before its request id.
    packet[8] = 7U;
    TEST_ASSERT_EQUAL_HEX32(4U, communication_ground_routes_of(&routes, 3U, packet, sizeof packet - 1U));
}

static void a_connection_that_has_ended_gets_nothing(void)
{
    note(0U, 1U, 16U, 1U, COMPLETION);
    note(1U, 1U, 16U, 2U, COMPLETION);
    communication_ground_routes_left(&routes, 0U);
    TEST_ASSERT_EQUAL_HEX32(2U, clients_of(1U, 16U, 1U, 7U)); // The other connection of this user.
    TEST_ASSERT_EQUAL_HEX32(2U, clients_of(1U, 16U, 2U, 7U));
    communication_ground_routes_left(&routes, 1U);
    TEST_ASSERT_EQUAL_HEX32(0U, clients_of(1U, 16U, 1U, 7U));
}

/// A full table removes first a request without a report about its end, otherwise the oldest one; only the
/// latter is counted.
static void a_full_table_removes_the_least_needed_request(void)
{
    note(0U, 1U, 16U, 0U, COMPLETION);
    note(0U, 1U, 16U, 1U, 0U);
    for (uint16_t i = 2U; i < GROUND_REQUESTS; i++) {
        note(0U, 1U, 16U, i, COMPLETION);
    }
    note(1U, 1U, 16U, 1000U, COMPLETION); // Replaces 1.
    TEST_ASSERT_EQUAL_UINT32(0U, routes.forgotten);
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 0U, 1U));
    TEST_ASSERT_EQUAL_HEX32(3U, clients_of(1U, 16U, 1U, 1U));
    note(1U, 1U, 16U, 1001U, COMPLETION); // Replaces 0.
    TEST_ASSERT_EQUAL_UINT32(1U, routes.forgotten);
    TEST_ASSERT_EQUAL_HEX32(3U, clients_of(1U, 16U, 0U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 2U, 7U)); // The request has been removed.
    note(1U, 1U, 16U, 1002U, COMPLETION);
    TEST_ASSERT_EQUAL_UINT32(1U, routes.forgotten);
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 3U, 1U));
    TEST_ASSERT_EQUAL_HEX32(2U, clients_of(1U, 16U, 1002U, 1U));
}

static void the_order_of_arrival_may_wrap(void)
{
    routes.order = UINT32_MAX - 4U;
    for (uint16_t i = 0U; i < GROUND_REQUESTS; i++) {
        note(0U, 1U, 16U, i, COMPLETION);
    }
    note(1U, 1U, 16U, 1000U, COMPLETION);
    TEST_ASSERT_EQUAL_HEX32(3U, clients_of(1U, 16U, 0U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(1U, 16U, 1U, 1U));
}

static void users_beyond_the_table_are_counted(void)
{
    for (uint16_t user = 1U; user <= GROUND_USERS; user++) {
        note(0U, user, 16U, user, COMPLETION);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, routes.forgotten);
    note(1U, 100U, 16U, 1U, COMPLETION);
    TEST_ASSERT_EQUAL_UINT32(1U, routes.forgotten);
    TEST_ASSERT_EQUAL_HEX32(2U, clients_of(100U, 17U, 1U, 1U));
    TEST_ASSERT_EQUAL_HEX32(0U, clients_of(GROUND_USERS, 17U, 1U, 1U));
    TEST_ASSERT_EQUAL_HEX32(1U, clients_of(GROUND_USERS - 1U, 17U, 1U, 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_is_known_by_user_apid_and_count);
    RUN_TEST(a_request_is_known_until_its_end);
    RUN_TEST(a_refused_start_is_not_the_end);
    RUN_TEST(two_connections_with_the_same_count_are_both_informed);
    RUN_TEST(other_reports_go_to_each_connection_of_the_user);
    RUN_TEST(a_connection_that_has_ended_gets_nothing);
    RUN_TEST(a_full_table_removes_the_least_needed_request);
    RUN_TEST(the_order_of_arrival_may_wrap);
    RUN_TEST(users_beyond_the_table_are_counted);
    return UNITY_END();
}
