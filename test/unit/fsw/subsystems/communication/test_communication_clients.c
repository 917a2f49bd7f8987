// SPDX-License-Identifier: Apache-2.0
// Clients that are idle, slow or hostile: the operator gets a place, and is told.
#include "fsw/subsystems/communication/communication.h"

#include "test/unit/fsw/subsystems/communication/bed.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    bed_open_up();
}

void tearDown(void)
{
    bed_close();
}

/// Four idle connections, one of which says half a header: the operator, who comes fifth, gets a place.
static void idle_clients_give_their_place_up(void)
{
    static const uint8_t half[3] = {0x18U, 0x01U, 0xC0U};
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        bed_connect(i);
        bed_run(10U);
    }
    bed_write(1U, half, sizeof half);
    bed_write_request(0U, 1U, 1U, 0U);
    bed_run_until_requests(1U);
    bed_connect(COMMUNICATION_CLIENTS); // Too soon: nobody is idle yet.
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_is_ended(COMMUNICATION_CLIENTS));
    bed_run(100U);
    TEST_ASSERT_EQUAL(1U, bed.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
    bed_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U));
    bed_write_request(0U, 1U, 2U, 0U);
    bed_run_until_requests(2U);
    bed_disconnect(COMMUNICATION_CLIENTS);
    bed_connect(COMMUNICATION_CLIENTS);
    bed_write_request(COMMUNICATION_CLIENTS, 3U, 1U, 0U);
    bed_run_until_requests(3U);
    TEST_ASSERT_TRUE(bed_is_ended(1U)); // The longest silent one: client 0 has spoken.
    TEST_ASSERT_FALSE(bed_is_ended(0U));
    TEST_ASSERT_FALSE(bed_is_ended(2U));
    bed_run(200U);
    TEST_ASSERT_EQUAL(1U, bed.communication.misuse.evicted);
    TEST_ASSERT_EQUAL(1U, bed.communication.misuse.refused);
    TEST_ASSERT_EQUAL(2U, bed.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
}

static void what_is_no_valid_request_keeps_no_place(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        bed_connect(i);
    }
    bed_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U));
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        const size_t size = bed_request(packet, 1U, (uint16_t)i, 0U);
        packet[size - 1U] ^= (i == 2U) ? 0xFFU : 0U;
        bed_write(i, packet, size);
    }
    bed_run_until_requests(COMMUNICATION_CLIENTS);
    bed_connect(COMMUNICATION_CLIENTS);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_is_ended(2U));
    TEST_ASSERT_FALSE(bed_is_ended(COMMUNICATION_CLIENTS));
}

static void a_participant_keeps_its_place(void)
{
    for (unsigned i = 0U; i < COMMUNICATION_CLIENTS; i++) {
        bed_connect(i);
    }
    bed.participant = bed.ports[0];
    bed_run((unsigned)(COMMUNICATION_IDLE_NS / 10000000U) + 2U);
    bed_connect(COMMUNICATION_CLIENTS);
    bed_run(2U);
    TEST_ASSERT_FALSE(bed_is_ended(0U));
    TEST_ASSERT_TRUE(bed_is_ended(1U));
}

static void misuse_is_counted_and_told_once_a_second(void)
{
    uint8_t garbage[64];
    uint8_t packet[PUS_PACKET_MAX];
    (void)memset(garbage, 0xFF, sizeof garbage);
    bed_run(100U);
    for (unsigned i = 0U; i < 20U; i++) {
        bed_connect(0U);
        const size_t size = bed_request(packet, 1U, 1U, 0U);
        packet[0]         = 0x08U; // A report.
        bed_write(0U, packet, size);
        bed_write(0U, garbage, sizeof garbage);
        bed_run(5U);
        TEST_ASSERT_TRUE(bed_is_ended(0U));
        bed_disconnect(0U);
    }
    bed_run(100U);
    TEST_ASSERT_EQUAL(20U, bed.communication.misuse.malformed);
    TEST_ASSERT_EQUAL(20U, bed.communication.misuse.no_telecommand);
    TEST_ASSERT_TRUE(bed.events[COMMUNICATION_EVENT_GROUND_MISUSED] >= 1U);
    TEST_ASSERT_TRUE(bed.events[COMMUNICATION_EVENT_GROUND_MISUSED] <= 4U);
}

/// The supervisor refuses it; what it says of that goes to the user on board.
static void who_poses_as_a_user_on_board_is_counted_and_told(void)
{
    bed_run(100U);
    bed_connect(0U);
    bed_write_request(0U, (uint16_t)(PUS_USER_ONBOARD | 2U), 1U, 0U);
    bed_run_until_requests(1U);
    bed_write_request(0U, 2U, 2U, 0U);
    bed_run_until_requests(2U);
    bed_run(100U);
    TEST_ASSERT_EQUAL(1U, bed.communication.misuse.no_telecommand);
    TEST_ASSERT_EQUAL(1U, bed.events[COMMUNICATION_EVENT_GROUND_MISUSED]);
}

/// Who asks and does not read is asked to wait; its connection stays.
static void who_does_not_read_sends_no_more(void)
{
    bed_connect(0U);
    bed_write_request(0U, 1U, 1U, 0U);
    bed_run_until_requests(1U);
    while (ground_queue_room(&bed.communication.queues[0]) >= 32768U) {
        bed_report(1U, 1U, 7U, 1U, 1000U);
    }
    bed_write_request(0U, 1U, 2U, 0U);
    (void)communication_take_in(&bed.communication, 0U); // Nothing is sent here, so nothing is read.
    TEST_ASSERT_EQUAL(1U, bed.request_count);
    bed_run_until_requests(2U);
    TEST_ASSERT_FALSE(bed_is_ended(0U));
}

/// As when its process ends: every connection is closed, nobody on board hears of it, and the port, which is
/// the launcher's, goes on.
static void released_it_has_ended_every_connection(void)
{
    const subsystem_callbacks_t* const callbacks = communication_callbacks();
    bed_connect(0U);
    bed_connect(1U);
    bed_write_request(1U, 1U, 1U, 0U);
    bed_run_until_requests(1U);
    const uint32_t held = bed.communication.sockets.stats.used;
    for (unsigned i = 0U; i < 2U; i++) { // The second time there is nothing to end.
        callbacks->release(&bed.communication);
        TEST_ASSERT_FALSE(flow_tcp_is_connected(&bed.communication.flow, 0U));
        TEST_ASSERT_FALSE(flow_tcp_is_connected(&bed.communication.flow, 1U));
        TEST_ASSERT_EQUAL(held - 2U, bed.communication.sockets.stats.used);
        TEST_ASSERT_EQUAL(2U, bed.communication.flow.counters.ended);
    }
    TEST_ASSERT_TRUE(bed_is_ended(0U));
    TEST_ASSERT_TRUE(bed_is_ended(1U));
    TEST_ASSERT_EQUAL(1U, bed.request_count);
    TEST_ASSERT_TRUE(osal_socket_is_open(&bed.communication.flow.listener));
    bed_disconnect(0U);
    bed_connect(0U);
    bed_write_request(0U, 1U, 2U, 0U);
    bed_run_until_requests(2U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(idle_clients_give_their_place_up);
    RUN_TEST(what_is_no_valid_request_keeps_no_place);
    RUN_TEST(a_participant_keeps_its_place);
    RUN_TEST(misuse_is_counted_and_told_once_a_second);
    RUN_TEST(who_poses_as_a_user_on_board_is_counted_and_told);
    RUN_TEST(who_does_not_read_sends_no_more);
    RUN_TEST(released_it_has_ended_every_connection);
    return UNITY_END();
}
