// SPDX-License-Identifier: Apache-2.0
// The life of two drives and of a joystick: commissioning, process data, other modes.
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

// ---- Commissioning ----

static void drives_come_up_run_and_go_down(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL_UINT(1U, joints[0]->boots);
    TEST_ASSERT_TRUE(network.devices[0].device.axes[0].scale.torque_nm == 0.01);
    TEST_ASSERT_TRUE(network.devices[1].device.axes[0].scale.torque_max_nm == 40.0);
    TEST_ASSERT_TRUE(now_ns < 50000000U); // Identification does not take long.
    set_torque_mode();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_UINT(4U, joints[1]->writes);
    TEST_ASSERT_EQUAL_UINT32(10U, scripted_object(joints[0], 0x6060U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT(0U, bus.syncs);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    TEST_ASSERT_EQUAL_HEX8(0x05U, joints[0]->nmt);
    TEST_ASSERT_EQUAL_UINT(0U,
                           joints[0]->pdos_received - 1U); // The first goes out with the cycle that starts.
    TEST_ASSERT_EQUAL_UINT(2U, joints[0]->last_pdo);
    idle(5U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[0]->status[0]);
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, joints[0]->status[0]);
    go(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, joints[1]->status[0]);
    idle(100U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_UINT32(0U, network.devices[0].missed);
    go(CIA402_GOAL_STANDBY);
    canopen_network_stop(&network);
    idle(2U);
    TEST_ASSERT_EQUAL_HEX8(0x7FU, joints[0]->nmt);
    canopen_network_reset_nodes(&network);
    idle(1U);
    TEST_ASSERT_EQUAL_UINT(2U, joints[0]->boots);
    expect_no_fault();
}

static void process_data_go_both_ways(void)
{
    run_to(CIA402_GOAL_ENABLED);
    canopen_cia402_axis_t* const axis = &network.devices[1].device.axes[0];
    joints[1]->position[0]            = -1234567;
    joints[1]->torque[0]              = -321;
    canopen_cia402_axis_command_position(axis, 0.25, -1.5);
    idle(2U);
    TEST_ASSERT_EQUAL_INT32(-1234567, axis->position);
    TEST_ASSERT_EQUAL_INT16(-321, axis->torque);
    TEST_ASSERT_EQUAL_INT32(250000, joints[1]->target_position);
    TEST_ASSERT_EQUAL_INT16(-150, joints[1]->torque_offset);
    const uint8_t slow[8] = {0x40U, 0x42U, 0x0FU, 0x00U, 0x10U, 0x00U, 0x2CU, 0x01U};
    scripted_bus_deliver(&bus, 0x292U, slow, 8U);
    idle(1U);
    TEST_ASSERT_EQUAL_INT32(1000000, axis->velocity);
    TEST_ASSERT_EQUAL_INT16(16, axis->current);
    TEST_ASSERT_EQUAL_INT16(300, network.devices[1].device.temperature);
}

static void a_joystick_has_two_axes_behind_one_node(void)
{
    canopen_network_close(&network);
    canopen_network_clear(&network);
    scripted_bus_close(&bus);
    scripted_bus_open(&bus, "test-network");
    scripted_node_t* const stick = scripted_bus_add(&bus, SCRIPTED_JOYSTICK, 0x21U);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_add(&network, "joystick", 0x21U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    run_to(CIA402_GOAL_ENABLED);
    canopen_device_t* const device = &network.devices[0].device;
    TEST_ASSERT_TRUE(device->axes[1].scale.torque_max_nm == 1.5);
    stick->position[0] = 1000;
    stick->position[1] = -2000;
    canopen_cia402_axis_command_torque(&device->axes[0], 0.1);
    canopen_cia402_axis_command_torque(&device->axes[1], -0.2);
    idle(2U);
    TEST_ASSERT_EQUAL_INT32(1000, device->axes[0].position);
    TEST_ASSERT_EQUAL_INT32(-2000, device->axes[1].position);
    TEST_ASSERT_EQUAL_INT16(1000, stick->target_torque[0]);
    TEST_ASSERT_EQUAL_INT16(-2000, stick->target_torque[1]);
    TEST_ASSERT_EQUAL_HEX32(0x00010000U, device->digital_inputs);
    stick->status[1] = 0x0218U; // One of the two axes is in fault.
    idle(2U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x21U, 0x0218U);
    expect_no_fault();
}

static void the_network_checks_each_added_node(void)
{
    uint8_t index = 0U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_add(&network, "toaster", 0x13U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_network_add(&network, "cia402-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_network_add(&network, "cia402-drive", 0x80U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_add(&network, "cia402-drive", 0x13U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_add(&network, "cia402-drive", 0x14U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, canopen_network_add(&network, "cia402-drive", 0x15U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_find(&network, 0x15U, &index));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_network_open(&network, &resolver, "robot", NULL));
    const canopen_setting_t setting = {.index = 0x6060U, .octets = 1U};
    for (unsigned i = 0U; i < NETWORK_SETTINGS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_set(&network, 0U, &setting));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, canopen_network_set(&network, 0U, &setting));
    canopen_network_clear_settings(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_set(&network, 0U, &setting));
}

static void functions_called_out_of_order_are_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_configure(&network, now_ns));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_start(&network, now_ns));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_secure(&network, now_ns));
    TEST_ASSERT_FALSE(canopen_network_is_at_goal(&network));
    canopen_network_close(&network);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_boot(&network, now_ns));
    canopen_network_sense(&network, now_ns);
    canopen_network_emit(&network, now_ns);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, canopen_network_open(&network, &resolver, "moon", NULL));
}

static void a_node_that_does_not_boot_is_reported_again(void)
{
    joints[1]->is_boot_mute = true;
    for (unsigned i = 0U; i < 500U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    expect_no_fault();
    for (unsigned i = 0U; i < 800U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    // Raised once, though the device reports it twice more.
    expect_refusal(0x12U, REFUSAL_NOT_BOOTED, 0U, 0U);
    joints[1]->is_boot_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_TRUE(now_ns < 1000000000U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_UINT(1U, joints[0]->boots); // A device that has booted gets no further reset.
}

static void a_device_of_another_type_is_refused(void)
{
    scripted_object(joints[1], 0x1000U, 0U)->value = 0x00010192U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_VALUE, 0x100000U, 0x00010192U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_configure(&network, now_ns));
}

/// Like the one with another type, it has the same profile: only its identity differs.
static void a_device_of_another_maker_or_kind_is_refused(void)
{
    scripted_object(joints[1], 0x1018U, 1U)->value = 0x0000029CU;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_VALUE, 0x101801U, 0x0000029CU);
    scripted_object(joints[1], 0x1018U, 1U)->value = 0U;
    scripted_object(joints[0], 0x1018U, 2U)->value = 0x2015U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x11U, REFUSAL_VALUE, 0x101802U, 0x2015U);
    expect_no_fault();
}

static void a_device_that_boots_again_meanwhile_is_refused(void)
{
    const uint8_t boot_up = 0U;
    for (unsigned i = 0U; i < 6U; i++) { // The master answers the first boot-up with requests.
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    scripted_bus_deliver(&bus, 0x712U, &boot_up, 1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_REBOOTED, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
}

static void a_device_that_maps_other_data_is_refused(void)
{
    scripted_object(joints[0], 0x1A00U, 2U)->value = 0x60640010U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x11U, REFUSAL_VALUE, 0x1A0002U, 0x60640010U);
}

static void a_device_without_a_rated_torque_is_refused(void)
{
    scripted_object(joints[0], 0x6076U, 0U)->value = 0U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x11U, REFUSAL_VALUE, 0x607600U, 0U);
}

static void an_abort_and_silence_end_commissioning(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    set(1U, 0x6060U, 0U, 1U, 77U);
    scripted_object(joints[1], 0x6060U, 0U)->abort_code = 0x06090030U;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, run_action(canopen_network_configure));
    expect_refusal(0x12U, REFUSAL_ABORTED, 0x606000U, 0x06090030U);
    scripted_object(joints[1], 0x6060U, 0U)->abort_code = 0U;
    joints[1]->is_sdo_mute                              = true;
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, run_action(canopen_network_configure));
    expect_refusal(0x12U, REFUSAL_TIMEOUT, 0x606000U, 0U);
    joints[1]->is_sdo_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure)); // The same once more.
}

static void starting_waits_without_endy_device(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    joints[1]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 20U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_start));
    }
    // The master sends commands when all devices can follow them.
    TEST_ASSERT_EQUAL_UINT(0U, joints[0]->pdos_received);
    expect_no_fault();
    for (unsigned i = 0U; i < 400U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_start));
    }
    expect_refusal(0x12U, REFUSAL_SILENT, 0U, 0U);
    joints[1]->is_pdo_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
}

static void it_can_be_configured_again_for_another_mode(void)
{
    run_to(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_UINT(1U, joints[0]->last_pdo);
    set_torque_mode();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_HEX8(0x7FU, joints[0]->nmt);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_UINT(2U, joints[0]->last_pdo);
    expect_no_fault();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(drives_come_up_run_and_go_down);
    RUN_TEST(process_data_go_both_ways);
    RUN_TEST(a_joystick_has_two_axes_behind_one_node);
    RUN_TEST(the_network_checks_each_added_node);
    RUN_TEST(functions_called_out_of_order_are_refused);
    RUN_TEST(a_node_that_does_not_boot_is_reported_again);
    RUN_TEST(a_device_of_another_type_is_refused);
    RUN_TEST(a_device_of_another_maker_or_kind_is_refused);
    RUN_TEST(a_device_that_boots_again_meanwhile_is_refused);
    RUN_TEST(a_device_that_maps_other_data_is_refused);
    RUN_TEST(a_device_without_a_rated_torque_is_refused);
    RUN_TEST(an_abort_and_silence_end_commissioning);
    RUN_TEST(starting_waits_without_endy_device);
    RUN_TEST(it_can_be_configured_again_for_another_mode);
    return UNITY_END();
}
