// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/master.h"
#include "test/support/scripted_bus.h"

#include "unity.h"

#include <string.h>

#define CYCLE_NS 500000U

static scripted_bus_t bus;
static flow_can_t flow;
static canopen_master_t master;
static uint64_t now_ns;
static unsigned taken;
static uint8_t last_octets[8];

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, bus.address);
    out_address->is_fd = true;
    return STATUS_OK;
}

static const flow_resolver_t resolver       = {NULL, resolve};
static const canopen_master_config_t config = {
    .node_id = 1U, .heartbeat_ns = 20000000U, .heartbeat_timeout_ns = 60000000U, .sdo_timeout_ns = 50000000U};

void setUp(void)
{
    uint8_t index = 0U;
    scripted_bus_open(&bus, "test-master");
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    flow_can_init(&flow);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    canopen_master_init(&master, &config, &flow);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 0x11U, &index));
    TEST_ASSERT_EQUAL_UINT8(0U, index);
    now_ns = 0U;
    taken  = 0U;
}

void tearDown(void)
{
    flow_can_close(&flow);
    scripted_bus_close(&bus);
}

static void take(void* const context, const uint16_t cob, const uint8_t* const octets, const uint8_t length)
{
    TEST_ASSERT_EQUAL_PTR(&master, context);
    TEST_ASSERT_EQUAL_HEX16(0x191U, cob);
    memcpy(last_octets, octets, (length <= 8U) ? length : 8U);
    taken++;
}

static void cycle(void)
{
    canopen_master_receive(&master, now_ns);
    canopen_master_emit(&master, now_ns);
    scripted_bus_run(&bus);
    now_ns += CYCLE_NS;
}

static void a_node_or_route_that_is_invalid_or_repeated_or_beyond_the_capacity_is_refused(void)
{
    uint8_t index = 0U;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_master_add_node(&master, 0x11U, &index));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_master_add_node(&master, 0U, &index));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_master_add_node(&master, 128U, &index));
    // The node id of the master itself.
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_master_add_node(&master, 1U, &index));
    for (uint8_t id = 2U; id < (1U + MASTER_NODES_MAX); id++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, id, &index));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, canopen_master_add_node(&master, 100U, &index));
    for (uint16_t cob = 0x180U; cob < (0x180U + MASTER_ROUTES_MAX); cob++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, cob, take, &master));
    }
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_master_route(&master, 0x180U, take, &master));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, canopen_master_route(&master, 0x300U, take, &master));
    canopen_master_unroute(&master, 0x181U);
    canopen_master_unroute(&master, 0x7FFU);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x300U, take, &master));
}

static void sync_is_the_last_frame_of_a_cycle(void)
{
    const uint8_t pdo[8] = {1U};
    canopen_master_set_sync(&master, true);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_send_process_data(&master, 0x211U, pdo, 8U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&master.nodes[0].sdo, 0x1000U, 0U));
    cycle();
    TEST_ASSERT_EQUAL_UINT(4U, bus.seen_count);
    TEST_ASSERT_EQUAL_HEX32(0x211U, bus.seen[0].id);
    TEST_ASSERT_EQUAL_HEX8(OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, bus.seen[0].flags);
    TEST_ASSERT_EQUAL_HEX32(0x611U, bus.seen[1].id);
    TEST_ASSERT_EQUAL_HEX8(0U, bus.seen[1].flags); // Only process data are sent in FD frames.
    TEST_ASSERT_EQUAL_HEX32(0x701U, bus.seen[2].id);
    TEST_ASSERT_EQUAL_HEX32(0x080U, bus.seen[3].id);
    TEST_ASSERT_EQUAL_UINT8(0U, bus.seen[3].length);
    TEST_ASSERT_EQUAL_UINT32(1U, master.sync_count);
    canopen_master_set_sync(&master, false);
    cycle();
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus, 0x080U));
}

static void the_heartbeat_has_a_period_of_20_ms(void)
{
    for (unsigned i = 0U; i < 400U; i++) {
        cycle();
        TEST_ASSERT_EQUAL_UINT(((i % 40U) == 0U) ? 1U : 0U, scripted_bus_count(&bus, 0x701U));
    }
}

static void a_master_on_a_new_channel_sends_its_heartbeat_at_once(void)
{
    cycle();
    now_ns = 0U;
    canopen_master_clear(&master);
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x701U));
    cycle();
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus, 0x701U));
    now_ns = 0U;
    canopen_master_use_flow(&master, &flow); // The other channel of the bus.
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x701U));
}

/// After the reset of a node, its heartbeat is not monitored and its transfers end; other nodes are not
/// affected.
static void a_reset_affects_only_the_nodes_that_it_reaches(void)
{
    uint8_t index = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 0x12U, &index));
    canopen_master_node_t* const nodes = master.nodes;
    for (unsigned i = 0U; i < 4U; i++) {
        static const struct {
            uint8_t id;
            canopen_nmt_command_t command;
            bool is_reset[2];
        } commands[] = {{0x12U, NMT_RESET_NODE, {false, true}},
                        {0x11U, NMT_RESET_NODE, {true, false}},
                        {0U, NMT_RESET_NODE, {true, true}},
                        {0U, NMT_START, {false, false}}};
        for (unsigned k = 0U; k < 2U; k++) {
            nodes[k].has_heartbeat = true;
            canopen_sdo_client_reset(&nodes[k].sdo);
            TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&nodes[k].sdo, 0x1000U, 0U));
        }
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_command(&master, commands[i].id, commands[i].command));
        scripted_bus_run(&bus);
        TEST_ASSERT_EQUAL_UINT8(2U, bus.seen[0].length);
        TEST_ASSERT_EQUAL_HEX8(commands[i].command, bus.seen[0].data[0]);
        TEST_ASSERT_EQUAL_HEX8(commands[i].id, bus.seen[0].data[1]);
        for (unsigned k = 0U; k < 2U; k++) {
            const bool is_reset = commands[i].is_reset[k];
            TEST_ASSERT_EQUAL(!is_reset, nodes[k].has_heartbeat);
            TEST_ASSERT_EQUAL(is_reset ? STATUS_OK : STATUS_BUSY,
                              canopen_sdo_client_upload(&nodes[k].sdo, 0x1000U, 0U));
        }
    }
    flow_can_close(&flow); // A command that cannot be sent has no effect.
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, canopen_master_command(&master, 0U, NMT_RESET_NODE));
    TEST_ASSERT_TRUE(nodes[0].has_heartbeat);
    TEST_ASSERT_TRUE(nodes[1].has_heartbeat);
}

static void a_boot_up_or_any_heartbeat_starts_the_monitoring_of_a_node(void)
{
    static const uint8_t states[] = {0x00U, 0x04U, 0x05U, 0x7FU};
    for (unsigned i = 0U; i < (sizeof states / sizeof states[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_command(&master, 0x11U, NMT_RESET_NODE));
        TEST_ASSERT_FALSE(master.nodes[0].has_heartbeat);
        scripted_bus_deliver(&bus, 0x711U, &states[i], 1U);
        canopen_master_receive(&master, now_ns);
        TEST_ASSERT_TRUE(master.nodes[0].has_heartbeat);
        TEST_ASSERT_EQUAL_UINT64(now_ns, master.nodes[0].heard_ns);
        TEST_ASSERT_EQUAL_UINT32(1U, master.nodes[0].boots); // Only 0x00 is a boot-up.
    }
}

static void a_heartbeat_is_missed_after_60_ms_and_not_before_the_first(void)
{
    for (unsigned i = 0U; i < 300U; i++) {
        cycle();
        TEST_ASSERT_FALSE(master.nodes[0].is_heartbeat_lost);
    }
    scripted_bus_heartbeat(&bus);
    const uint64_t heard_ns = now_ns;
    do {
        cycle();
        TEST_ASSERT_EQUAL((now_ns - CYCLE_NS - heard_ns) > 60000000U, master.nodes[0].is_heartbeat_lost);
    } while ((now_ns - heard_ns) < 70000000U);
    scripted_bus_heartbeat(&bus);
    cycle();
    TEST_ASSERT_FALSE(master.nodes[0].is_heartbeat_lost);
}

static void process_data_reach_their_receiver(void)
{
    const uint8_t octets[8] = {9U, 8U, 7U};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x191U, take, &master));
    scripted_bus_deliver(&bus, 0x191U, octets, 8U);
    scripted_bus_deliver(&bus, 0x192U, octets, 8U);
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, taken);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, last_octets, 8U);
    TEST_ASSERT_EQUAL_UINT32(1U, master.counters.unknown);
    canopen_master_unroute(&master, 0x191U);
    scripted_bus_deliver(&bus, 0x191U, octets, 8U);
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, taken);
    TEST_ASSERT_EQUAL_UINT32(2U, master.counters.unknown);
}

static void emergencies_are_queued_and_counted_when_they_do_not_fit(void)
{
    canopen_emergency_t emergency;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_master_take_emergency(&master, &emergency));
    for (uint16_t i = 0U; i < (MASTER_EMERGENCIES_MAX + 3U); i++) {
        scripted_bus_emergency(&bus, 0x11U, (uint16_t)(0x1000U + i));
    }
    cycle();
    TEST_ASSERT_EQUAL_UINT32(MASTER_EMERGENCIES_MAX, master.counters.emergencies);
    TEST_ASSERT_EQUAL_UINT32(3U, master.counters.emergencies_lost);
    for (uint16_t i = 0U; i < MASTER_EMERGENCIES_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_take_emergency(&master, &emergency));
        TEST_ASSERT_EQUAL_HEX16(0x1000U + i, emergency.code);
        TEST_ASSERT_EQUAL_HEX8(0x11U, emergency.node);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_master_take_emergency(&master, &emergency));
}

static void frames_of_the_wrong_kind_are_counted_and_dropped(void)
{
    const uint8_t octets[8] = {0x05U, 0x02U};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x191U, take, &master));
    scripted_bus_deliver(&bus, 0x191U | OSAL_CAN_REMOTE, NULL, 0U);
    scripted_bus_deliver(&bus, 0x191U | OSAL_CAN_EXTENDED, octets, 8U);
    scripted_bus_deliver(&bus, 0x712U, octets, 1U);     // Heartbeat of an unknown node.
    scripted_bus_deliver(&bus, 0x711U, octets, 2U);     // Heartbeat that is too long.
    scripted_bus_deliver(&bus, 0x711U, NULL, 0U);       // Heartbeat that is too short.
    scripted_bus_deliver(&bus, 0x711U, &octets[1], 1U); // Heartbeat with a state that does not exist.
    scripted_bus_deliver(&bus, 0x091U, octets, 7U);     // Emergency that is too short.
    scripted_bus_deliver(&bus, 0x080U, octets, 0U);     // SYNC of another node.
    scripted_bus_deliver(&bus, 0x611U, octets, 8U);     // A second SDO client.
    scripted_bus_deliver(&bus, 0x000U, octets, 2U);     // A second NMT master.
    scripted_bus_deliver(&bus, 0x591U, octets, 8U);     // An SDO answer without a request.
    cycle();
    TEST_ASSERT_EQUAL_UINT(0U, taken);
    TEST_ASSERT_EQUAL_UINT32(1U, master.counters.remote);
    TEST_ASSERT_EQUAL_UINT32(4U, master.counters.malformed);
    TEST_ASSERT_EQUAL_UINT32(3U, master.counters.unknown);
    TEST_ASSERT_EQUAL_UINT32(1U, master.counters.conflicting_syncs);
    TEST_ASSERT_EQUAL_UINT32(1U, master.flow->can.filtered); // The extended one.
    TEST_ASSERT_EQUAL_UINT32(1U, master.nodes[0].sdo.counters.unasked);
    TEST_ASSERT_FALSE(master.nodes[0].has_heartbeat);
}

static void sync_can_be_the_first_frame_of_a_cycle(void)
{
    const uint8_t pdo[8] = {1U};
    canopen_master_set_sync(&master, true);
    for (unsigned i = 1U; i <= 3U; i++) {
        canopen_master_receive(&master, now_ns);
        if (i != 2U) { // The order may change from cycle to cycle.
            canopen_master_send_sync(&master);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_send_process_data(&master, 0x211U, pdo, 8U));
        canopen_master_emit(&master, now_ns);
        now_ns += CYCLE_NS;
        scripted_bus_run(&bus);
        TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x080U));
        TEST_ASSERT_EQUAL_HEX32((i == 2U) ? 0x211U : 0x080U, bus.seen[0].id);
        TEST_ASSERT_EQUAL_UINT32(i, master.sync_count);
    }
    canopen_master_set_sync(&master, false);
    canopen_master_send_sync(&master);
    cycle();
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus, 0x080U));
    TEST_ASSERT_EQUAL_UINT32(3U, master.sync_count);
}

static void nothing_is_queued_without_acknowledge(void)
{
    const uint8_t pdo[8] = {1U};
    canopen_master_set_sync(&master, true);
    cycle();
    scripted_bus_error(&bus, OSAL_CAN_ERROR_NO_ACK, 0U);
    for (unsigned i = 0U; i < 1000U; i++) {
        canopen_master_receive(&master, now_ns);
        canopen_master_send_sync(&master);
        TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_master_send_process_data(&master, 0x211U, pdo, 8U));
        canopen_master_emit(&master, now_ns);
        now_ns += CYCLE_NS;
        scripted_bus_run(&bus);
        TEST_ASSERT_EQUAL_UINT(0U, bus.seen_count);
    }
    scripted_bus_heartbeat(&bus);
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x080U));
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x701U));
}

static void a_sync_that_the_full_queue_refuses_is_counted_as_refused(void)
{
    const uint8_t pdo[8] = {1U};
    while (canopen_master_send_process_data(&master, 0x211U, pdo, 8U) == STATUS_OK) {
        TEST_ASSERT_TRUE(flow.counters.sent <= OSAL_CAN_RING_FRAMES);
    }
    canopen_master_set_sync(&master, true);
    canopen_master_emit(&master, now_ns);
    TEST_ASSERT_EQUAL_UINT32(0U, master.sync_count);
    TEST_ASSERT_EQUAL_UINT32(3U, master.counters.refused);
    TEST_ASSERT_EQUAL(STATUS_FULL, canopen_master_command(&master, 0x11U, NMT_START));
}

static void a_full_receive_queue_is_read_in_one_cycle(void)
{
    const uint8_t octets[8] = {0U};
    for (unsigned i = 0U; i < (OSAL_CAN_RING_FRAMES - 1U); i++) {
        scripted_bus_deliver(&bus, 0x000U, octets, 8U);
    }
    cycle();
    TEST_ASSERT_EQUAL_UINT32(OSAL_CAN_RING_FRAMES - 1U, master.counters.unknown);
}

/// Responses from before the boot-up of a node do not belong to a transfer that starts after it.
static void a_boot_up_ends_the_transfer_with_the_node(void)
{
    static const uint8_t operational = 0x05U;
    static const uint8_t boot_up     = 0x00U;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&master.nodes[0].sdo, 0x1000U, 0U));
    scripted_bus_deliver(&bus, 0x711U, &operational, 1U);
    canopen_master_receive(&master, now_ns);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_sdo_client_result(&master.nodes[0].sdo, NULL));
    scripted_bus_deliver(&bus, 0x711U, &boot_up, 1U);
    canopen_master_receive(&master, now_ns);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_sdo_client_result(&master.nodes[0].sdo, NULL));
    TEST_ASSERT_EQUAL_UINT32(1U, master.nodes[0].boots);
}

/// Requests to the devices of a full bus: the next one is sent when one has been answered or has timed out.
static void the_number_of_requests_that_wait_for_an_answer_is_limited(void)
{
    uint8_t index = 0U;
    for (uint8_t i = 1U; i < MASTER_NODES_MAX; i++) { // Only node 0x11 is on the bus and answers.
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, (uint8_t)(0x11U + i), &index));
    }
    for (uint8_t i = 0U; i < MASTER_NODES_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&master.nodes[i].sdo, 0x1000U, 0U));
    }
    now_ns = 1U;
    canopen_master_emit(&master, now_ns);
    for (uint8_t i = 0U; i < MASTER_NODES_MAX; i++) {
        TEST_ASSERT_EQUAL(i < MASTER_REQUESTS_MAX, canopen_sdo_client_is_waiting(&master.nodes[i].sdo));
    }
    static const uint8_t answer[SDO_FRAME_OCTETS] = {0x43U, 0x00U, 0x10U, 0U, 0x92U, 0x01U, 0x02U, 0U};
    canopen_sdo_client_answer(&master.nodes[3].sdo, answer, SDO_FRAME_OCTETS);
    canopen_master_emit(&master, now_ns);
    TEST_ASSERT_TRUE(canopen_sdo_client_is_waiting(&master.nodes[MASTER_REQUESTS_MAX].sdo));
    TEST_ASSERT_FALSE(canopen_sdo_client_is_waiting(&master.nodes[MASTER_REQUESTS_MAX + 1U].sdo));
    // A request that was not sent has no time-out.
    now_ns += config.sdo_timeout_ns;
    canopen_master_emit(&master, now_ns);
    canopen_master_emit(&master, now_ns);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, canopen_sdo_client_result(&master.nodes[0].sdo, NULL));
    for (uint8_t i = MASTER_REQUESTS_MAX + 1U; i < MASTER_NODES_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_sdo_client_result(&master.nodes[i].sdo, NULL));
        TEST_ASSERT_TRUE(canopen_sdo_client_is_waiting(&master.nodes[i].sdo));
    }
}

static void clearing_a_master_removes_nodes_routes_emergencies_and_sync(void)
{
    uint8_t index = 9U;
    canopen_emergency_t emergency;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x191U, take, &master));
    scripted_bus_emergency(&bus, 0x11U, 0x1000U);
    canopen_master_set_sync(&master, true);
    cycle();
    canopen_master_clear(&master);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_master_take_emergency(&master, &emergency));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x191U, take, &master));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 0x11U, &index));
    TEST_ASSERT_EQUAL_UINT8(0U, index);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 0x12U, &index));
    TEST_ASSERT_EQUAL_UINT8(1U, index);
    cycle();
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus, 0x080U));
    TEST_ASSERT_EQUAL_UINT32(1U, master.counters.emergencies); // Counters stay.
}

static void the_first_and_the_last_node_id_are_valid(void)
{
    uint8_t index                   = 0U;
    canopen_master_config_t highest = config;
    highest.node_id                 = 127U;
    canopen_master_init(&master, &highest, &flow);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 1U, &index));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_master_add_node(&master, 127U, &index));
    cycle();
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus, 0x77FU));
    canopen_master_init(&master, &config, &flow);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_add_node(&master, 127U, &index));
}

static void emergencies_keep_their_order_beyond_the_end_of_the_queue(void)
{
    canopen_emergency_t emergency;
    uint16_t sent       = 0x1000U;
    uint16_t taken_code = 0x1000U;
    for (unsigned round = 0U; round < 5U; round++) {
        for (unsigned i = 0U; i < (MASTER_EMERGENCIES_MAX - 5U); i++) {
            scripted_bus_emergency(&bus, 0x11U, sent++);
        }
        cycle();
        while (canopen_master_take_emergency(&master, &emergency) == STATUS_OK) {
            TEST_ASSERT_EQUAL_HEX16(taken_code++, emergency.code);
        }
        TEST_ASSERT_EQUAL_HEX16(sent, taken_code);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, master.counters.emergencies_lost);
}

static void repeat(void* const context, const uint16_t cob, const uint8_t* const octets, const uint8_t length)
{
    (void)context;
    taken++;
    scripted_bus_deliver(&bus, cob, octets, length);
}

static void a_node_that_never_stops_sending_does_not_hold_the_cycle(void)
{
    const uint8_t octets[8] = {0U};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_master_route(&master, 0x191U, repeat, NULL));
    scripted_bus_deliver(&bus, 0x191U, octets, 8U);
    canopen_master_receive(&master, now_ns);
    TEST_ASSERT_EQUAL_UINT(MASTER_FRAMES_PER_CYCLE, taken);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_node_or_route_that_is_invalid_or_repeated_or_beyond_the_capacity_is_refused);
    RUN_TEST(sync_is_the_last_frame_of_a_cycle);
    RUN_TEST(sync_can_be_the_first_frame_of_a_cycle);
    RUN_TEST(the_heartbeat_has_a_period_of_20_ms);
    RUN_TEST(a_master_on_a_new_channel_sends_its_heartbeat_at_once);
    RUN_TEST(a_reset_affects_only_the_nodes_that_it_reaches);
    RUN_TEST(a_boot_up_or_any_heartbeat_starts_the_monitoring_of_a_node);
    RUN_TEST(a_heartbeat_is_missed_after_60_ms_and_not_before_the_first);
    RUN_TEST(process_data_reach_their_receiver);
    RUN_TEST(emergencies_are_queued_and_counted_when_they_do_not_fit);
    RUN_TEST(frames_of_the_wrong_kind_are_counted_and_dropped);
    RUN_TEST(nothing_is_queued_without_acknowledge);
    RUN_TEST(a_sync_that_the_full_queue_refuses_is_counted_as_refused);
    RUN_TEST(a_full_receive_queue_is_read_in_one_cycle);
    RUN_TEST(a_boot_up_ends_the_transfer_with_the_node);
    RUN_TEST(the_number_of_requests_that_wait_for_an_answer_is_limited);
    RUN_TEST(clearing_a_master_removes_nodes_routes_emergencies_and_sync);
    RUN_TEST(the_first_and_the_last_node_id_are_valid);
    RUN_TEST(emergencies_keep_their_order_beyond_the_end_of_the_queue);
    RUN_TEST(a_node_that_never_stops_sending_does_not_hold_the_cycle);
    return UNITY_END();
}
