// SPDX-License-Identifier: Apache-2.0
// A network on a bus with two channels: the master sends on the active channel only, searches for the devices
// there, and changes the channel only on command.
#include "fsw/canopen/network.h"
#include "test/support/scripted_bus.h"

#include "unity.h"

#include <string.h>

#define CYCLE_NS 500000U
#define CYCLES_MAX 4000U
#define A NETWORK_CHANNEL_A
#define B NETWORK_CHANNEL_B
#define MASTER_HEARTBEAT 0x701U

static scripted_bus_t bus[NETWORK_CHANNELS];
static scripted_node_t* nodes[NETWORK_CHANNELS][2];
static canopen_network_t network;
static canopen_network_device_t slots[2];
static uint64_t now_ns;
static bool is_a_missing;
static bool is_b_missing;
static unsigned frames_sent[NETWORK_CHANNELS]; // Frames that the master has sent.

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    const bool is_b = (strcmp(name, "robot-b") == 0);
    if (is_b ? is_b_missing : is_a_missing) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, bus[is_b ? B : A].address);
    return STATUS_OK;
}

static const flow_resolver_t resolver        = {NULL, resolve};
static const canopen_network_config_t config = {.master              = {.node_id              = 1U,
                                                                        .heartbeat_ns         = 20000000U,
                                                                        .heartbeat_timeout_ns = 60000000U,
                                                                        .sdo_timeout_ns       = 50000000U},
                                                .lost_after_syncs    = 3U,
                                                .selection_ns        = 160000000U,
                                                .boot_retry_ns       = 300000000U,
                                                .silence_reported_ns = 300000000U,
                                                .quick_stop_limit_ns = 200000000U};

/// Plug both devices into one channel, or into no channel.
static void devices_on(const unsigned channel)
{
    for (unsigned i = 0U; i < 2U; i++) {
        nodes[A][i]->is_plugged = (channel == A);
        nodes[B][i]->is_plugged = (channel == B);
    }
}

static void open_network(void)
{
    canopen_network_clear(&network);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      canopen_network_add(&network, &slots[network.device_count], "joint-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      canopen_network_add(&network, &slots[network.device_count], "joint-drive", 0x12U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", "robot-b"));
}

/// Returns the sum of the counters of both channels.
static canopen_network_bus_counters_t counters_now(void)
{
    canopen_network_bus_counters_t sum = {.sent = 0U};
    canopen_network_add_counters(&network, &sum);
    return sum;
}

void setUp(void)
{
    static const char* const names[] = {"test-channel-a", "test-channel-b"};
    is_a_missing                     = false;
    is_b_missing                     = false;
    now_ns                           = 0U;
    memset(frames_sent, 0, sizeof frames_sent);
    for (unsigned i = 0U; i < NETWORK_CHANNELS; i++) {
        scripted_bus_open(&bus[i], names[i]);
        nodes[i][0] = scripted_bus_add(&bus[i], SCRIPTED_DRIVE, 0x11U);
        nodes[i][1] = scripted_bus_add(&bus[i], SCRIPTED_DRIVE, 0x12U);
    }
    devices_on(A);
    canopen_network_init(&network, &config);
}

void tearDown(void)
{
    canopen_network_close(&network);
    for (unsigned i = 0U; i < NETWORK_CHANNELS; i++) {
        scripted_bus_close(&bus[i]);
    }
}

typedef status_t (*action_t)(canopen_network_t* network, uint64_t now_ns);

static status_t cycle(const action_t action)
{
    canopen_network_sense(&network, now_ns);
    const status_t status = (action != NULL) ? action(&network, now_ns) : STATUS_OK;
    canopen_network_emit(&network, now_ns);
    now_ns += CYCLE_NS;
    for (unsigned i = 0U; i < NETWORK_CHANNELS; i++) {
        scripted_bus_run(&bus[i]);
        frames_sent[i] += bus[i].seen_count;
        if ((now_ns % 20000000U) == 0U) {
            scripted_bus_heartbeat(&bus[i]);
        }
    }
    return status;
}

static status_t run_action(const action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < CYCLES_MAX); i++) {
        status = cycle(action);
    }
    return status;
}

static void idle(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)cycle(NULL);
    }
}

static void run(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
}

static unsigned faults_of(const canopen_network_fault_kind_t kind, const uint16_t code)
{
    canopen_network_fault_t fault;
    unsigned count = 0U;
    while (canopen_network_take_fault(&network, &fault) == STATUS_OK) {
        count += ((fault.kind == kind) && (fault.code == code)) ? 1U : 0U;
    }
    return count;
}

static void the_master_sends_on_the_active_channel_only(void)
{
    open_network();
    run();
    idle(200U);
    TEST_ASSERT_EQUAL_UINT(0U, frames_sent[B]);
    TEST_ASSERT_TRUE(frames_sent[A] > 600U);
    TEST_ASSERT_EQUAL_UINT(0U, faults_of(NETWORK_DEVICE_LOST, 0U));
}

static void the_master_sends_only_heartbeats_until_the_devices_change_channel(void)
{
    devices_on(B);
    open_network();
    unsigned resets = 0U;
    for (unsigned i = 0U; i < 200U; i++) { // In 100 ms the master sends heartbeats only.
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        resets += scripted_bus_count(&bus[A], 0U);
        TEST_ASSERT_EQUAL_UINT(bus[A].seen_count, scripted_bus_count(&bus[A], MASTER_HEARTBEAT));
    }
    TEST_ASSERT_EQUAL_UINT(0U, resets);
    devices_on(A);
    run();
    TEST_ASSERT_EQUAL_UINT(0U, frames_sent[B]);
}

static void booting_starts_although_devices_do_not_answer(void)
{
    devices_on(NETWORK_CHANNELS);
    nodes[A][0]->is_plugged   = true;
    nodes[A][1]->is_plugged   = true;
    nodes[A][1]->is_boot_mute = true; // This device was never heard: it sends nothing.
    open_network();
    unsigned resets = 0U;
    for (unsigned i = 0U; i < 340U; i++) {
        (void)cycle(canopen_network_boot);
        resets += scripted_bus_count(&bus[A], 0U);
    }
    TEST_ASSERT_TRUE(resets >= 1U);
}

static void a_cut_channel_counts_as_unplugged_and_a_command_recovers_the_devices(void)
{
    open_network();
    run();
    devices_on(NETWORK_CHANNELS);
    idle(4U);
    TEST_ASSERT_EQUAL_UINT(2U, faults_of(NETWORK_DEVICE_LOST, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    idle(2000U);
    TEST_ASSERT_EQUAL_UINT8(A, network.channel); // The master does not change the channel without a command.
    TEST_ASSERT_EQUAL_UINT(0U, frames_sent[B]);
    const unsigned before = frames_sent[A];
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    devices_on(B);
    run();
    idle(100U);
    TEST_ASSERT_EQUAL_UINT(0U, faults_of(NETWORK_DEVICE_LOST, 0U));
    TEST_ASSERT_EQUAL_UINT(before, frames_sent[A]);
    TEST_ASSERT_TRUE(frames_sent[B] > 300U);
}

static void a_selection_while_closed_applies_to_the_next_opening(void)
{
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, canopen_network_select_channel(&network, NETWORK_CHANNELS));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    devices_on(B);
    open_network();
    run();
    TEST_ASSERT_EQUAL_UINT(0U, frames_sent[A]);
    canopen_network_reset_nodes(&network);
    idle(1U);
    canopen_network_close(&network);
    // Selecting the same channel again has no effect.
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    open_network();
    run();
    TEST_ASSERT_EQUAL_UINT(0U, frames_sent[A]);
}

static void a_change_of_channel_first_stops_process_data(void)
{
    open_network();
    run();
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    TEST_ASSERT_FALSE(network.is_running);
    TEST_ASSERT_FALSE(network.is_booted);
    idle(1U);
    // NMT PRE-OPERATIONAL is the last frame on the old channel.
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus[A], 0U));
    TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus[B], MASTER_HEARTBEAT));
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus[B], 0x080U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    // All devices must be commissioned again.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_configure(&network, now_ns));
    devices_on(B);
    run();
}

static void frames_of_a_node_on_the_wrong_channel_are_dropped(void)
{
    const uint8_t stray[8] = {0x37U, 0x02U};
    open_network();
    run();
    const uint32_t boots                        = network.master.nodes[0].boots;
    const canopen_network_bus_counters_t before = counters_now();
    scripted_bus_deliver(&bus[B], 0x711U, stray, 1U);
    scripted_bus_deliver(&bus[B], 0x191U, stray, 8U);
    scripted_bus_emergency(&bus[B], 0x11U, 0x7305U);
    scripted_bus_error(&bus[B], OSAL_CAN_ERROR_BUS_OFF, 0U);
    idle(5U);
    const canopen_network_bus_counters_t after = counters_now();
    TEST_ASSERT_EQUAL_UINT32(boots, network.master.nodes[0].boots);
    TEST_ASSERT_TRUE(after.received >= (before.received + 3U));
    TEST_ASSERT_EQUAL_UINT32(before.bus_offs + 1U, after.bus_offs);
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_OFF + NETWORK_BUS_CHANNEL_B));
    TEST_ASSERT_EQUAL_UINT32(0U, network.devices[0]->is_lost ? 1U : 0U);
}

static void a_missing_channel_b_is_reported_and_cannot_be_selected(void)
{
    is_b_missing = true;
    open_network();
    run();
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_MISSING + NETWORK_BUS_CHANNEL_B));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_select_channel(&network, B));
    idle(50U);
    TEST_ASSERT_EQUAL_UINT(0U, faults_of(NETWORK_DEVICE_LOST, 0U)); // The network continues.
    canopen_network_close(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_open(&network, &resolver, "robot", "robot-b"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_open(&network, &resolver, "robot", NULL));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, A));
    open_network();
}

static void conditions_of_a_controller_are_reported_and_counted(void)
{
    open_network();
    run();
    scripted_bus_error(&bus[A], OSAL_CAN_ERROR_CONTROLLER, 0x01U);
    idle(1U);
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_OVERRUN));
    scripted_bus_error(&bus[A], OSAL_CAN_ERROR_TX_TIMEOUT, 0U);
    idle(1U);
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_TRANSMIT_TIMEOUT));
    scripted_bus_error(&bus[A], OSAL_CAN_ERROR_LOST_ARBITRATION, 0U);
    idle(1U);
    // In normal operation the warning is only counted.
    TEST_ASSERT_EQUAL_UINT(0U, faults_of(NETWORK_BUS_WARNING, 0U));
    scripted_bus_error(&bus[A], OSAL_CAN_ERROR_BUS_OFF, 0U);
    scripted_bus_error(&bus[A], OSAL_CAN_ERROR_RESTARTED, 0U);
    idle(1U);
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_RESTARTED));
    TEST_ASSERT_TRUE(network.devices[0]->is_lost && network.devices[1]->is_lost); // Even a short loss counts.
    const canopen_network_bus_counters_t counters = counters_now();
    TEST_ASSERT_EQUAL_UINT32(1U, counters.overruns);
    TEST_ASSERT_EQUAL_UINT32(1U, counters.transmit_timeouts);
    TEST_ASSERT_EQUAL_UINT32(1U, counters.lost_arbitrations);
    TEST_ASSERT_EQUAL_UINT32(1U, counters.bus_offs);
    TEST_ASSERT_EQUAL_UINT32(1U, counters.restarts);
    TEST_ASSERT_EQUAL_UINT32(5U, counters.errors);
}

static void unsent_frames_are_counted_with_the_reason(void)
{
    static const uint8_t octets[8] = {0U};
    is_b_missing                   = true;
    open_network();
    run();
    const canopen_network_bus_counters_t before = counters_now();
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_can_send(&network.flows[B], 0x7F0U, octets, 8U));
    canopen_network_bus_counters_t after = counters_now();
    TEST_ASSERT_EQUAL_UINT32(before.refused + 1U, after.refused);
    TEST_ASSERT_EQUAL_UINT32(before.full, after.full);
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i <= OSAL_CAN_RING_FRAMES) && (status == STATUS_OK); i++) {
        status = flow_can_send(&network.flows[A], 0x7F0U, octets, 8U); // No node acknowledges the frames.
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    after = counters_now();
    TEST_ASSERT_EQUAL_UINT32(before.refused + 2U, after.refused);
    TEST_ASSERT_EQUAL_UINT32(before.full + 1U, after.full);
}

/// Each controller has counters of its own.
static void the_counters_of_both_channels_are_summed(void)
{
    for (unsigned i = 0U; i < NETWORK_CHANNELS; i++) {
        const uint32_t unit                          = (i == A) ? 1U : 100U;
        network.flows[i].counters.sent               = 1U * unit;
        network.flows[i].counters.received           = 2U * unit;
        network.flows[i].counters.refused            = 3U * unit;
        network.flows[i].counters.full               = 4U * unit;
        network.flows[i].counters.errors             = 5U * unit;
        network.flows[i].counters.overruns           = 6U * unit;
        network.flows[i].counters.lost               = 7U * unit;
        network.flows[i].errors.bus_offs             = 8U * unit;
        network.flows[i].errors.restarts             = 9U * unit;
        network.flows[i].errors.missing_acknowledges = 10U * unit;
        network.flows[i].errors.transmit_timeouts    = 11U * unit;
        network.flows[i].errors.lost_arbitrations    = 12U * unit;
    }
    const canopen_network_bus_counters_t sum = counters_now();
    TEST_ASSERT_EQUAL_UINT32(101U, sum.sent);
    TEST_ASSERT_EQUAL_UINT32(202U, sum.received);
    TEST_ASSERT_EQUAL_UINT32(303U, sum.refused);
    TEST_ASSERT_EQUAL_UINT32(404U, sum.full);
    TEST_ASSERT_EQUAL_UINT32(505U, sum.errors);
    TEST_ASSERT_EQUAL_UINT32(606U, sum.overruns);
    TEST_ASSERT_EQUAL_UINT32(707U, sum.lost);
    TEST_ASSERT_EQUAL_UINT32(808U, sum.bus_offs);
    TEST_ASSERT_EQUAL_UINT32(909U, sum.restarts);
    TEST_ASSERT_EQUAL_UINT32(1010U, sum.missing_acknowledges);
    TEST_ASSERT_EQUAL_UINT32(1111U, sum.transmit_timeouts);
    TEST_ASSERT_EQUAL_UINT32(1212U, sum.lost_arbitrations);
}

static unsigned cycles_to_reset(const unsigned channel)
{
    unsigned cycles = 0U;
    do {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        cycles++;
        TEST_ASSERT_TRUE(cycles < 1000U);
    } while (scripted_bus_count(&bus[channel], 0U) == 0U);
    return cycles;
}

/// A heartbeat from before NETWORK_SELECTING does not show on which channel the node is now.
static void booting_starts_when_every_node_is_heard_or_after_160_ms(void)
{
    static const uint8_t alive = 0x7FU;
    open_network();
    scripted_bus_deliver(&bus[A], 0x711U, &alive, 1U);
    scripted_bus_deliver(&bus[A], 0x712U, &alive, 1U);
    // Heartbeats of the cycle in which NETWORK_SELECTING begins do not count.
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    scripted_bus_deliver(&bus[A], 0x711U, &alive, 1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus[A], 0U));
    scripted_bus_deliver(&bus[A], 0x712U, &alive, 1U);
    TEST_ASSERT_EQUAL_UINT(1U, cycles_to_reset(A));
    canopen_network_close(&network);
    devices_on(NETWORK_CHANNELS); // No device answers.
    open_network();
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    TEST_ASSERT_EQUAL_UINT(320U, cycles_to_reset(A));
}

/// A node that is reset returns to the channel on which it last heard the master.
static void nodes_on_a_new_channel_hear_a_heartbeat_of_the_master_before_their_reset(void)
{
    static const uint8_t alive = 0x7FU;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    devices_on(NETWORK_CHANNELS);
    for (unsigned opening = 0U; opening < 3U; opening++) {
        open_network();
        if (opening == 2U) { // As in a process that was started again.
            canopen_network_doubt_channel(&network);
        }
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        scripted_bus_deliver(&bus[B], 0x711U, &alive, 1U);
        scripted_bus_deliver(&bus[B], 0x712U, &alive, 1U);
        if (opening != 1U) { // At the second opening the nodes have heard the master on this channel.
            TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
            TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus[B], 0U));
            TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus[B], MASTER_HEARTBEAT));
        }
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&bus[B], 0U));
        canopen_network_close(&network);
    }
}

static void frames_of_the_other_channel_are_read_in_the_cycle_they_arrive(void)
{
    static const uint8_t stray[8] = {0U};
    open_network();
    run();
    for (unsigned i = 0U; i < 10U; i++) {
        scripted_bus_deliver(&bus[B], 0x191U, stray, 8U);
    }
    idle(1U);
    TEST_ASSERT_EQUAL_UINT32(10U, network.flows[B].counters.received);
}

static void a_missing_channel_a_is_reported_without_the_offset_of_b(void)
{
    is_a_missing = true;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_select_channel(&network, B));
    devices_on(B);
    open_network();
    run();
    TEST_ASSERT_EQUAL_UINT(1U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_MISSING));
}

static void a_channel_that_does_not_exist_is_not_missing(void)
{
    canopen_network_clear(&network);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      canopen_network_add(&network, &slots[network.device_count], "joint-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    run();
    TEST_ASSERT_EQUAL_UINT(0U, faults_of(NETWORK_BUS_WARNING, NETWORK_BUS_MISSING + NETWORK_BUS_CHANNEL_B));
}

/// A continuous loss is reported once; losses before the opening of the bus do not count.
static void lost_frames_are_reported_after_each_opening_on_both_channels(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        open_network();
        run();
        scripted_bus_error(&bus[A], OSAL_CAN_ERROR_CONTROLLER, 0x01U);
        scripted_bus_error(&bus[B], OSAL_CAN_ERROR_CONTROLLER, 0x01U);
        idle(1U);
        canopen_network_fault_t fault;
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_take_fault(&network, &fault));
        TEST_ASSERT_EQUAL_HEX16(NETWORK_BUS_OVERRUN, fault.code);
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_take_fault(&network, &fault));
        TEST_ASSERT_EQUAL_HEX16(NETWORK_BUS_OVERRUN + NETWORK_BUS_CHANNEL_B, fault.code);
        canopen_network_close(&network);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_master_sends_on_the_active_channel_only);
    RUN_TEST(the_master_sends_only_heartbeats_until_the_devices_change_channel);
    RUN_TEST(booting_starts_although_devices_do_not_answer);
    RUN_TEST(a_cut_channel_counts_as_unplugged_and_a_command_recovers_the_devices);
    RUN_TEST(a_selection_while_closed_applies_to_the_next_opening);
    RUN_TEST(a_change_of_channel_first_stops_process_data);
    RUN_TEST(frames_of_a_node_on_the_wrong_channel_are_dropped);
    RUN_TEST(a_missing_channel_b_is_reported_and_cannot_be_selected);
    RUN_TEST(conditions_of_a_controller_are_reported_and_counted);
    RUN_TEST(unsent_frames_are_counted_with_the_reason);
    RUN_TEST(the_counters_of_both_channels_are_summed);
    RUN_TEST(booting_starts_when_every_node_is_heard_or_after_160_ms);
    RUN_TEST(nodes_on_a_new_channel_hear_a_heartbeat_of_the_master_before_their_reset);
    RUN_TEST(frames_of_the_other_channel_are_read_in_the_cycle_they_arrive);
    RUN_TEST(a_missing_channel_a_is_reported_without_the_offset_of_b);
    RUN_TEST(a_channel_that_does_not_exist_is_not_missing);
    RUN_TEST(lost_frames_are_reported_after_each_opening_on_both_channels);
    return UNITY_END();
}
