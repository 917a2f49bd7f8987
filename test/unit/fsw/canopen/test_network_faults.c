// SPDX-License-Identifier: Apache-2.0
// Faults that a network of two drives reports, and the safe state.
#include "test/unit/fsw/canopen/two_drives.h"

#include "unity.h"

void setUp(void)
{
    two_drives_open();
}

void tearDown(void)
{
    two_drives_close();
}

// ---- Faults ----

static void a_device_is_lost_after_three_missing_answers(void)
{
    run_to(CIA402_GOAL_ENABLED);
    joints[1]->is_pdo_mute = true;
    idle(3U);
    expect_no_fault();
    idle(1U);
    expect_fault(NETWORK_DEVICE_LOST, 0x12U, 0U);
    idle(50U);
    expect_no_fault();                                      // The fault is raised once.
    TEST_ASSERT_TRUE(canopen_network_is_at_goal(&network)); // A lost device is not required for the goal.
}

static void two_missing_answers_are_tolerated(void)
{
    run_to(CIA402_GOAL_ENABLED);
    for (unsigned i = 0U; i < 20U; i++) {
        joints[1]->is_pdo_mute = true;
        idle(2U);
        joints[1]->is_pdo_mute = false;
        idle(1U);
    }
    idle(1U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_UINT32(40U, network.devices[1]->missed);
}

static void process_data_of_a_wrong_length_count_as_missing(void)
{
    run_to(CIA402_GOAL_ENABLED);
    const uint8_t octets[8] = {0x37U, 0x02U};
    joints[0]->is_pdo_mute  = true;
    for (unsigned i = 0U; i < 4U; i++) {
        scripted_bus_deliver(&bus, 0x191U, octets, (uint8_t)(i + 4U));
        idle(1U);
    }
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
    TEST_ASSERT_EQUAL_UINT32(4U, network.devices[0]->device.malformed);
}

static void bus_off_makes_every_device_lost_in_the_same_cycle(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_BUS_OFF, 0U);
    idle(1U);
    expect_fault(NETWORK_BUS_WARNING, 0U, FLOW_CAN_BUS_OFF);
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
    expect_fault(NETWORK_DEVICE_LOST, 0x12U, 0U);
    expect_no_fault();
}

static void devices_that_acknowledge_no_frame_are_lost_and_securing_ends(void)
{
    run_to(CIA402_GOAL_ENABLED);
    joints[0]->is_plugged = false;
    joints[1]->is_plugged = false;
    idle(2U);
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
    expect_fault(NETWORK_DEVICE_LOST, 0x12U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
}

static void each_entry_into_an_error_state_of_the_bus_is_reported_once(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x08U);
    idle(3U);
    expect_fault(NETWORK_BUS_WARNING, 0U, FLOW_CAN_WARNING);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x20U);
    idle(3U);
    expect_fault(NETWORK_BUS_WARNING, 0U, FLOW_CAN_PASSIVE);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x40U);
    idle(3U);
    expect_no_fault();
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x08U);
    idle(3U);
    expect_fault(NETWORK_BUS_WARNING, 0U, FLOW_CAN_WARNING);
}

static void a_node_that_boots_again_is_lost(void)
{
    const uint8_t zero = 0U;
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_deliver(&bus, 0x711U, &zero, 1U);
    idle(1U);
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
}

static void a_missing_heartbeat_makes_a_device_lost_without_process_data(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    idle(300U);
    expect_no_fault();
    joints[1]->is_plugged = false;
    idle(161U);
    expect_fault(NETWORK_DEVICE_LOST, 0x12U, 0U);
}

static void a_fault_is_reported_once_with_its_code(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_emergency(&bus, 0x12U, 0x2310U);
    joints[1]->status[0] = 0x0218U;
    idle(10U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x12U, 0x2310U);
    expect_no_fault();
}

/// The last statusword of a lost device does not report a fault.
static void only_a_device_that_is_present_can_be_faulty(void)
{
    canopen_cia402_axis_t* const axis = &network.devices[0]->device.axes[0];
    run_to(CIA402_GOAL_ENABLED);
    joints[0]->is_plugged = false;
    idle(5U);
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
    axis->statusword = 0x0218U;
    idle(5U);
    expect_no_fault();
}

static void only_a_device_with_process_data_can_be_faulty(void)
{
    canopen_cia402_axis_t* const axis = &network.devices[0]->device.axes[0];
    run_to(CIA402_GOAL_ENABLED);
    canopen_network_stop(&network);
    idle(5U);
    expect_no_fault();
    axis->statusword = 0x0218U;
    idle(5U);
    expect_no_fault();
}

static void a_drive_that_leaves_operation_without_a_command_is_faulty(void)
{
    run_to(CIA402_GOAL_ENABLED);
    joints[0]->status[0] = 0x0250U;
    idle(2U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x11U, 0x0250U);
    idle(20U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[0]->status[0]); // The master does not switch the drive on again.
}

static void an_emergency_is_reported_by_the_class_of_its_code(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_emergency(&bus, 0x11U, 0x4310U);
    scripted_bus_emergency(&bus, 0x11U, 0x8120U);
    scripted_bus_emergency(&bus, 0x11U, 0x0000U);
    scripted_bus_emergency(&bus, 0x13U, 0x2310U); // This node does not belong to the network.
    idle(1U);
    expect_fault(NETWORK_DRIVE_WARNING, 0x11U, 0x4310U);
    expect_fault(NETWORK_BUS_WARNING, 0x11U, 0x8120U);
    expect_no_fault();
}

static void an_emergency_before_the_reset_is_not_a_fault(void)
{
    scripted_bus_emergency(&bus, 0x11U, 0x8130U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    expect_no_fault();
    idle(10U);
    expect_no_fault();
}

/// The drive reports its fault while it still reacts to it.
static void a_reaction_to_a_fault_is_a_fault(void)
{
    run_to(CIA402_GOAL_DISABLED);
    joints[0]->status[0] = 0x021FU; // FAULT REACTION ACTIVE
    idle(2U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x11U, 0x021FU);
}

/// The master takes emergencies only of its nodes, which are the devices; the test puts one into its queue.
static void an_emergency_of_a_node_that_is_no_device_is_ignored(void)
{
    run_to(CIA402_GOAL_ENABLED);
    network.master.emergencies[network.master.emergency_first] =
        (canopen_emergency_t){.node = 0x13U, .code = 0x8130U};
    network.master.emergency_count = 1U;
    idle(1U);
    TEST_ASSERT_EQUAL_UINT8(0U, network.master.emergency_count);
    expect_no_fault();
}

static void a_fault_is_reset_only_for_the_goal_standby(void)
{
    run_to(CIA402_GOAL_DISABLED);
    joints[0]->status[0] = 0x0218U;
    idle(2U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x11U, 0x0218U);
    canopen_network_set_goal(&network, CIA402_GOAL_ENABLED, false);
    idle(20U);
    TEST_ASSERT_EQUAL_HEX16(0x0218U, joints[0]->status[0]);
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, joints[0]->status[0]);
}

/// Deliver emergencies of medium severity with codes from `first` on; in each cycle as many as the master can
/// store.
static void deliver_warnings(const unsigned count, const uint16_t first)
{
    for (unsigned i = 0U; i < count; i++) {
        scripted_bus_emergency(&bus, 0x11U, (uint16_t)(first + i)); // Unknown codes are of medium severity.
        if (((i + 1U) % MASTER_EMERGENCIES_MAX) == 0U) {
            idle(1U);
        }
    }
    idle(1U);
}

static void faults_that_find_the_queue_full_are_counted(void)
{
    run_to(CIA402_GOAL_DISABLED);
    deliver_warnings(NETWORK_FAULTS_MAX + 8U, 0x4310U);
    TEST_ASSERT_EQUAL_UINT32(8U, network.faults_lost);
}

// ---- Safe state ----

static void securing_sends_quick_stop_and_then_disable_voltage(void)
{
    run_to(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0002U, joints[0]->control[0]); // Quick stop is sent in the same cycle.
    TEST_ASSERT_EQUAL_HEX16(0x0217U, joints[0]->status[0]);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    joints[0]->status[0] = 0x0250U; // The drives have come to rest.
    joints[1]->status[0] = 0x0250U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    idle(10U);
    TEST_ASSERT_EQUAL_HEX16(0x0000U, joints[0]->control[0]);
    expect_no_fault();
}

static void braking_ends_after_200_ms(void)
{
    run_to(CIA402_GOAL_ENABLED);
    for (unsigned i = 0U; i < 400U; i++) { // The drives stay in QUICK STOP ACTIVE until another command.
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
        TEST_ASSERT_EQUAL_HEX16(0x0002U, joints[0]->control[0]);
    }
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure)); // 200 ms have passed.
    TEST_ASSERT_EQUAL_HEX16(0x0000U, joints[0]->control[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[1]->status[0]);
}

static void securing_works_with_one_drive_unplugged(void)
{
    run_to(CIA402_GOAL_ENABLED);
    joints[0]->is_plugged = false;
    idle(4U);
    expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0217U, joints[1]->status[0]);
    joints[1]->status[0] = 0x0250U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
}

static void securing_works_from_disabled_and_standby_and_keeps_a_fault(void)
{
    run_to(CIA402_GOAL_DISABLED);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[0]->status[0]);
    joints[0]->status[0] = 0x0218U;
    idle(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    // A drive in state FAULT is safe; securing does not reset the fault, so that it can be reported.
    TEST_ASSERT_EQUAL_HEX16(0x0218U, joints[0]->status[0]);
}

/// A controller repeats a frame that is not acknowledged. After a reconnection, the nodes would receive an
/// old command.
static void no_command_is_queued_without_an_acknowledging_node(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_NO_ACK, 0U);
    idle(1U);
    TEST_ASSERT_TRUE(network.flow->health.is_unacknowledged);
    scripted_bus_run(&bus);
    canopen_network_stop(&network);
    canopen_network_reset_nodes(&network);
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL_UINT(0U, bus.seen_count);
}

/// A command on a closed bus would count as refused by the bus.
static void no_command_is_sent_on_a_closed_bus(void)
{
    run_to(CIA402_GOAL_ENABLED);
    flow_can_close(network.flow);
    const uint32_t refused = network.master.counters.refused;
    canopen_network_stop(&network);
    canopen_network_reset_nodes(&network);
    TEST_ASSERT_FALSE(network.is_booted);
    TEST_ASSERT_EQUAL_UINT32(refused, network.master.counters.refused);
}

static void unplugged_devices_work_again_after_commissioning(void)
{
    run_to(CIA402_GOAL_ENABLED);
    joints[0]->is_plugged = false;
    joints[1]->is_plugged = false;
    idle(10U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    canopen_network_reset_nodes(&network);
    idle(1U);
    canopen_network_close(&network);
    joints[0]->is_plugged = true;
    joints[1]->is_plugged = true;
    canopen_network_clear(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", 0x12U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    expect_no_fault(); // Faults from before canopen_network_close are not reported.
    run_to(CIA402_GOAL_ENABLED);
    idle(10U);
    expect_no_fault();
}

static void a_sync_of_another_node_is_reported_once_while_it_continues(void)
{
    scripted_bus_deliver(&bus, 0x080U, NULL, 0U);
    idle(2U);
    run_to(CIA402_GOAL_ENABLED);
    expect_no_fault(); // Faults from before the commissioning are not reported.
    for (unsigned i = 0U; i < 400U; i++) {
        scripted_bus_deliver(&bus, 0x080U, NULL, 0U);
        idle(1U);
    }
    expect_fault(NETWORK_SYNC_CONFLICT, 0U, 0U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_UINT32(401U, network.master.counters.conflicting_syncs);
    idle(1998U); // Cycles of 0.5 ms: the next SYNC comes less than one second later.
    scripted_bus_deliver(&bus, 0x080U, NULL, 0U);
    idle(1U);
    expect_no_fault();
    idle(1999U); // The next cycle completes exactly one second.
    scripted_bus_deliver(&bus, 0x080U, NULL, 0U);
    idle(1U);
    expect_fault(NETWORK_SYNC_CONFLICT, 0U, 0U);
}

static void faults_keep_their_order_beyond_the_end_of_the_queue(void)
{
    uint16_t taken = 0x4300U;
    run_to(CIA402_GOAL_DISABLED);
    for (unsigned round = 0U; round < 5U; round++) {
        deliver_warnings(NETWORK_FAULTS_MAX - 3U, taken);
        for (unsigned i = 0U; i < (NETWORK_FAULTS_MAX - 3U); i++) {
            expect_fault(NETWORK_DRIVE_WARNING, 0x11U, taken++);
        }
        expect_no_fault();
    }
    TEST_ASSERT_EQUAL_UINT32(0U, network.faults_lost);
    deliver_warnings(NETWORK_FAULTS_MAX, 0x4300U);
    TEST_ASSERT_EQUAL_UINT32(0U, network.faults_lost); // The queue is exactly full, and no fault is lost.
}

/// A loss and a fault are reported once per device and commissioning, and again after the next commissioning.
static void a_commissioned_device_can_be_lost_and_faulty_again(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        run_to(CIA402_GOAL_ENABLED);
        expect_no_fault();
        scripted_bus_emergency(&bus, 0x12U, 0x2310U);
        idle(1U);
        expect_fault(NETWORK_DRIVE_FAULT, 0x12U, 0x2310U);
        joints[0]->is_pdo_mute = true;
        idle(4U);
        expect_fault(NETWORK_DEVICE_LOST, 0x11U, 0U);
        joints[0]->is_pdo_mute = false;
        canopen_network_stop(&network);
    }
}

static void lost_frames_are_reported_again_after_a_second_without_loss(void)
{
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x01U);
    idle(1U);
    run_to(CIA402_GOAL_ENABLED);
    expect_no_fault(); // A loss before the commissioning of the devices is not reported.
    idle(2000U);
    for (unsigned i = 0U; i < 20U; i++) {
        scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x01U);
        idle(100U);
    }
    expect_fault(NETWORK_BUS_WARNING, 0U, NETWORK_BUS_OVERRUN);
    expect_no_fault();
    idle(1899U); // Together with the 100 cycles of the loop these are 1999 cycles of 0.5 ms.
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x01U);
    idle(1U);
    expect_no_fault();
    idle(1999U);
    scripted_bus_error(&bus, OSAL_CAN_ERROR_CONTROLLER, 0x01U);
    idle(1U);
    expect_fault(NETWORK_BUS_WARNING, 0U, NETWORK_BUS_OVERRUN);
}

/// canopen_network_stop also ends securing: the next securing begins with the quick stop.
static void securing_starts_again_after_a_stop(void)
{
    run_to(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    canopen_network_stop(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    go(CIA402_GOAL_STANDBY);
    go(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0002U, joints[1]->control[0]);
}

static void a_device_is_lost_after_the_missing_answers_that_the_mission_sets(void)
{
    for (uint32_t syncs = 1U; syncs <= 5U; syncs += 2U) {
        run_to(CIA402_GOAL_DISABLED);
        canopen_network_set_lost_after(&network, syncs);
        joints[1]->is_pdo_mute = true;
        idle(syncs);
        expect_no_fault();
        idle(1U);
        expect_fault(NETWORK_DEVICE_LOST, 0x12U, 0U);
        joints[1]->is_pdo_mute = false;
        canopen_network_stop(&network);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_device_is_lost_after_three_missing_answers);
    RUN_TEST(two_missing_answers_are_tolerated);
    RUN_TEST(process_data_of_a_wrong_length_count_as_missing);
    RUN_TEST(bus_off_makes_every_device_lost_in_the_same_cycle);
    RUN_TEST(devices_that_acknowledge_no_frame_are_lost_and_securing_ends);
    RUN_TEST(each_entry_into_an_error_state_of_the_bus_is_reported_once);
    RUN_TEST(a_node_that_boots_again_is_lost);
    RUN_TEST(a_missing_heartbeat_makes_a_device_lost_without_process_data);
    RUN_TEST(a_fault_is_reported_once_with_its_code);
    RUN_TEST(only_a_device_that_is_present_can_be_faulty);
    RUN_TEST(only_a_device_with_process_data_can_be_faulty);
    RUN_TEST(a_drive_that_leaves_operation_without_a_command_is_faulty);
    RUN_TEST(an_emergency_is_reported_by_the_class_of_its_code);
    RUN_TEST(an_emergency_before_the_reset_is_not_a_fault);
    RUN_TEST(a_reaction_to_a_fault_is_a_fault);
    RUN_TEST(an_emergency_of_a_node_that_is_no_device_is_ignored);
    RUN_TEST(a_fault_is_reset_only_for_the_goal_standby);
    RUN_TEST(faults_that_find_the_queue_full_are_counted);
    RUN_TEST(securing_sends_quick_stop_and_then_disable_voltage);
    RUN_TEST(braking_ends_after_200_ms);
    RUN_TEST(securing_works_with_one_drive_unplugged);
    RUN_TEST(securing_works_from_disabled_and_standby_and_keeps_a_fault);
    RUN_TEST(no_command_is_queued_without_an_acknowledging_node);
    RUN_TEST(no_command_is_sent_on_a_closed_bus);
    RUN_TEST(unplugged_devices_work_again_after_commissioning);
    RUN_TEST(a_sync_of_another_node_is_reported_once_while_it_continues);
    RUN_TEST(faults_keep_their_order_beyond_the_end_of_the_queue);
    RUN_TEST(a_commissioned_device_can_be_lost_and_faulty_again);
    RUN_TEST(lost_frames_are_reported_again_after_a_second_without_loss);
    RUN_TEST(securing_starts_again_after_a_stop);
    RUN_TEST(a_device_is_lost_after_the_missing_answers_that_the_mission_sets);
    return UNITY_END();
}
