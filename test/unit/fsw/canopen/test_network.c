// SPDX-License-Identifier: Apache-2.0
// The operation of two drives and of a joystick: commissioning, process data, other modes.
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

static void drives_are_commissioned_operated_and_stopped(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL_UINT(1U, joints[0]->boots);
    TEST_ASSERT_TRUE(network.devices[0]->device.axes[0].scale.torque_nm == 0.01);
    TEST_ASSERT_TRUE(network.devices[1]->device.axes[0].scale.torque_max_nm == 40.0);
    TEST_ASSERT_TRUE(now_ns < 50000000U); // Identification does not take long.
    set_torque_mode();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_UINT(4U, joints[1]->writes);
    TEST_ASSERT_EQUAL_UINT32(10U, scripted_object(joints[0], 0x6060U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT(0U, bus.syncs);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    TEST_ASSERT_EQUAL_HEX8(0x05U, joints[0]->nmt);
    // The first frame is sent in the cycle of the start.
    TEST_ASSERT_EQUAL_UINT(1U, joints[0]->pdos_received);
    TEST_ASSERT_EQUAL_UINT(2U, joints[0]->last_pdo);
    idle(5U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[0]->status[0]);
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, joints[0]->status[0]);
    go(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, joints[1]->status[0]);
    idle(100U);
    expect_no_fault();
    TEST_ASSERT_EQUAL_UINT32(0U, network.devices[0]->missed);
    go(CIA402_GOAL_STANDBY);
    canopen_network_stop(&network);
    idle(2U);
    TEST_ASSERT_EQUAL_HEX8(0x7FU, joints[0]->nmt);
    canopen_network_reset_nodes(&network);
    idle(1U);
    TEST_ASSERT_EQUAL_UINT(2U, joints[0]->boots);
    expect_no_fault();
}

static void process_data_pass_in_both_directions(void)
{
    run_to(CIA402_GOAL_ENABLED);
    canopen_cia402_axis_t* const axis = &network.devices[1]->device.axes[0];
    joints[1]->position[0]            = -1234567;
    joints[1]->torque[0]              = -321;
    canopen_cia402_axis_command_position(axis, 0.25, -1.5);
    idle(2U);
    TEST_ASSERT_EQUAL_INT32(-1234567, axis->position);
    TEST_ASSERT_EQUAL_INT16(-321, axis->torque);
    TEST_ASSERT_EQUAL_INT32(250000, joints[1]->target_position);
    TEST_ASSERT_EQUAL_INT16(-150, joints[1]->torque_offset);
    // Velocity 1000000, current 16, temperature 300.
    const uint8_t slow[8] = {0x40U, 0x42U, 0x0FU, 0x00U, 0x10U, 0x00U, 0x2CU, 0x01U};
    scripted_bus_deliver(&bus, 0x292U, slow, 8U);
    idle(1U);
    TEST_ASSERT_EQUAL_INT32(1000000, axis->velocity);
    TEST_ASSERT_EQUAL_INT16(16, axis->current);
    TEST_ASSERT_TRUE(canopen_device_value(&network.devices[1]->device, 0U) == 300.0);
}

static void a_joystick_is_one_node_with_two_axes(void)
{
    canopen_network_close(&network);
    canopen_network_clear(&network);
    scripted_bus_close(&bus);
    scripted_bus_open(&bus, "test-network");
    scripted_node_t* const stick = scripted_bus_add(&bus, SCRIPTED_JOYSTICK, 0x21U);
    TEST_ASSERT_EQUAL(STATUS_OK, add_device("joystick", 0x21U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    run_to(CIA402_GOAL_ENABLED);
    canopen_device_t* const device = &network.devices[0]->device;
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
    TEST_ASSERT_EQUAL_UINT8(0U, canopen_device_profile_value(device->profile, 0x60FDU, 0U));
    TEST_ASSERT_TRUE(canopen_device_value(device, 0U) == 65536.0);
    stick->status[1] = 0x0218U; // One of the two axes is in fault.
    idle(2U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x21U, 0x0218U);
    expect_no_fault();
}

/// A device whose only mapping is that of its data sheet is identified.
static void only_the_mappings_of_its_profile_are_read(void)
{
    scripted_object(joints[0], 0x1602U, 0U)->abort_code = 0x06020000U;
    scripted_object(joints[0], 0x1A02U, 0U)->abort_code = 0x06020000U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    expect_no_fault();
}

static void the_network_checks_each_added_node(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, add_device("toaster", 0x13U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, add_device("joint-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, add_device("joint-drive", 0x80U));
    for (uint8_t node = 0x13U; node < (0x11U + NETWORK_DEVICES_MAX); node++) {
        TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", node));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, add_device("joint-drive", 0x21U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_NO_DEVICE, canopen_network_find(&network, 0x21U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_network_open(&network, &resolver, "robot", NULL));
    const canopen_setting_t setting = {.index = 0x6060U, .octets = 1U};
    for (unsigned i = 0U; i < NETWORK_SETTINGS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_set(&network, 0U, &setting));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, canopen_network_set(&network, 0U, &setting));
    canopen_network_clear_settings(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_set(&network, 0U, &setting));
}

/// A network with the maximum number of devices is in operation within 50 ms, as a network of two devices is.
static void a_full_network_is_commissioned_and_secured(void)
{
    for (uint8_t i = 2U; i < NETWORK_DEVICES_MAX; i++) {
        canopen_network_close(&network);
        (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, (uint8_t)(0x11U + i));
        TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", (uint8_t)(0x11U + i)));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    run_to(CIA402_GOAL_ENABLED);
    TEST_ASSERT_TRUE(now_ns < 50000000U);
    TEST_ASSERT_EQUAL_UINT8(MASTER_ROUTES_MAX, network.master.route_count);
    for (uint8_t i = 0U; i < NETWORK_DEVICES_MAX; i++) {
        bus.nodes[i].position[0] = 1000 + i;
        canopen_cia402_axis_command_torque(&network.devices[i]->device.axes[0], -0.5);
        canopen_cia402_axis_command_position(&network.devices[i]->device.axes[0], 0.001 * (double)i, 0.0);
    }
    idle(2U);
    for (uint8_t i = 0U; i < NETWORK_DEVICES_MAX; i++) {
        TEST_ASSERT_EQUAL_INT32(1000 + i, network.devices[i]->device.axes[0].position);
        TEST_ASSERT_EQUAL_INT32(1000 * i, bus.nodes[i].target_position);
    }
    bus.nodes[15].is_plugged = false;
    idle(5U);
    expect_fault(NETWORK_DEVICE_LOST, 0x20U, 0U);
    expect_no_fault();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    for (uint8_t i = 0U; i < (NETWORK_DEVICES_MAX - 1U); i++) {
        TEST_ASSERT_EQUAL_HEX16(0x0240U, bus.nodes[i].status[0] & 0x026FU);
    }
    expect_no_fault();
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

static void a_node_that_does_not_boot_is_reported_once_and_reset_again(void)
{
    joints[1]->is_boot_mute = true;
    for (unsigned i = 0U; i < 500U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    expect_no_fault();
    for (unsigned i = 0U; i < 800U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    // The refusal is raised at 300 ms only, although the reset is repeated at 600 ms without success.
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

/// The device has the profile of the class; only its identity differs.
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
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure)); // A second attempt succeeds.
}

static void starting_waits_for_the_process_data_of_each_device(void)
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

static void a_network_can_be_configured_again_for_another_mode(void)
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

/// RPDO1 carries position and torque offset, RPDO2 torque and velocity. If the offset kept its old value, the
/// drive would add it to the torque.
static void nothing_commanded_in_one_configuration_acts_in_the_next(void)
{
    canopen_cia402_axis_t* const axis = &network.devices[0]->device.axes[0];
    run_to(CIA402_GOAL_ENABLED);
    canopen_cia402_axis_command_position(axis, 0.5, -3.0);
    idle(2U);
    TEST_ASSERT_EQUAL_HEX32((uint16_t)-300, scripted_object(joints[0], 0x60B2U, 0U)->value);
    go(CIA402_GOAL_DISABLED);
    set_torque_mode();
    scripted_object(joints[0], 0x60B2U, 0U)->abort_code = 0x08000022U;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, run_action(canopen_network_configure));
    expect_refusal(0x11U, REFUSAL_ABORTED, 0x60B200U, 0x08000022U);
    scripted_object(joints[0], 0x60B2U, 0U)->abort_code = 0U;
    unsigned writes                                     = joints[0]->writes;
    // One more write access than settings: it sets the torque offset to zero.
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_UINT(writes + 4U + 1U, joints[0]->writes);
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(joints[0], 0x60B2U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT8(2U, scripted_object(joints[0], 0x60B2U, 0U)->octets);
    writes = joints[0]->writes;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure)); // The offset is already zero.
    TEST_ASSERT_EQUAL_UINT(writes + 4U, joints[0]->writes);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    go(CIA402_GOAL_STANDBY);
    go(CIA402_GOAL_ENABLED);
    canopen_cia402_axis_command_torque(axis, 2.0);
    canopen_cia402_axis_command_velocity(axis, 0.25, 0.0);
    idle(2U);
    canopen_network_clear_settings(&network);
    set(0U, 0x1401U, 1U, 4U, 0x80000311U);
    set(0U, 0x1400U, 1U, 4U, 0x00000211U);
    writes = joints[0]->writes;
    // Targets act only in their own mode, so they need not be set to zero.
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_UINT(writes + 2U, joints[0]->writes);
    expect_no_fault();
}

static void an_idle_device_is_not_enabled(void)
{
    run_to(CIA402_GOAL_DISABLED);
    canopen_network_clear_settings(&network);
    canopen_network_include(&network, 0U);
    go(CIA402_GOAL_STANDBY);
    go(CIA402_GOAL_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, joints[0]->status[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, joints[1]->status[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_secure));
    canopen_network_include(&network, 1U);
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, joints[1]->status[0]);
    expect_no_fault();
}

/// Run cycles until the first fault, which must be this refusal. Returns the number of cycles.
static unsigned cycles_to_refusal(const action_t action, const uint8_t node,
                                  const canopen_network_refusal_t refusal)
{
    canopen_network_fault_t fault;
    unsigned cycles = 0U;
    do {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(action));
        cycles++;
        TEST_ASSERT_TRUE(cycles < 2000U);
    } while (canopen_network_take_fault(&network, &fault) != STATUS_OK);
    TEST_ASSERT_EQUAL(NETWORK_DEVICE_REFUSED, fault.kind);
    TEST_ASSERT_EQUAL(refusal, fault.refusal);
    TEST_ASSERT_EQUAL_HEX8(node, fault.node);
    return cycles;
}

static void a_boot_is_repeated_every_300_ms_at_the_missing_node_only(void)
{
    unsigned resets[2]      = {0U, 0U};
    joints[1]->is_boot_mute = true;
    // The first cycle sends the reset; 600 cycles (300 ms) later it is repeated.
    (void)cycle(canopen_network_boot);
    TEST_ASSERT_EQUAL_UINT(601U, cycles_to_refusal(canopen_network_boot, 0x12U, REFUSAL_NOT_BOOTED) + 1U);
    for (unsigned i = 0U; i < 1800U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        for (unsigned k = 0U; k < bus.seen_count; k++) {
            const bool is_reset = (bus.seen[k].id == 0U) && (bus.seen[k].data[0] == 0x81U);
            resets[0] += (is_reset && (bus.seen[k].data[1] != 0x12U)) ? 1U : 0U;
            resets[1] += (is_reset && (bus.seen[k].data[1] == 0x12U)) ? 1U : 0U;
        }
    }
    TEST_ASSERT_EQUAL_UINT(0U, resets[0]);
    TEST_ASSERT_EQUAL_UINT(3U, resets[1]);
    expect_no_fault(); // The refusal is reported once for each boot.
    canopen_network_stop(&network);
    (void)cycle(canopen_network_boot);
    // The next boot reports the refusal again.
    (void)cycles_to_refusal(canopen_network_boot, 0x12U, REFUSAL_NOT_BOOTED);
}

static void no_reset_is_repeated_while_no_node_acknowledges(void)
{
    joints[0]->is_plugged = false;
    joints[1]->is_plugged = false;
    for (unsigned i = 0U; i < 5U; i++) {
        (void)cycle(canopen_network_boot);
    }
    for (unsigned i = 0U; i < 1500U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
        TEST_ASSERT_EQUAL_UINT(0U, scripted_bus_count(&bus, 0U));
    }
}

static void a_silent_device_is_reported_after_100_ms_of_each_start(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    joints[1]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_UINT(201U, cycles_to_refusal(canopen_network_start, 0x12U, REFUSAL_SILENT));
        for (unsigned k = 0U; k < 500U; k++) {
            TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_start));
        }
        expect_no_fault();
        canopen_network_stop(&network);
    }
}

static void a_value_of_another_size_is_a_refusal_for_its_format(void)
{
    scripted_object(joints[1], 0x1000U, 0U)->octets = 2U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_FORMAT, 0x100000U, 0U);
}

/// A drive has one axis; the other positions of axes in its object are not used.
static void axes_that_a_device_does_not_have_take_no_part(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    canopen_cia402_axis_t* const other = &network.devices[0]->device.axes[1];
    canopen_cia402_axis_set_goal(other, CIA402_GOAL_STANDBY, false);
    other->statusword      = 0x0218U; // Fault, not standby.
    const double torque_nm = other->scale.torque_max_nm;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    canopen_cia402_axis_set_goal(other, CIA402_GOAL_QUICK_STOP, false);
    other->statusword = 0x0237U;
    go(CIA402_GOAL_STANDBY);
    TEST_ASSERT_EQUAL(CIA402_GOAL_QUICK_STOP, other->goal);
    TEST_ASSERT_EQUAL_HEX16(0U, other->controlword);
    other->statusword = 0x0218U;
    idle(5U);
    expect_no_fault();
    TEST_ASSERT_TRUE(torque_nm == 0.0);
}

/// Settings of PDOs that the class does not have, and of other entries, do not change the PDOs.
static void only_identifiers_of_its_own_pdos_change_a_device(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
    } others[]                           = {{0x13FFU, 1U}, {0x1402U, 1U}, {0x1400U, 0U}, {0x1401U, 2U},
                                            {0x17FFU, 1U}, {0x1802U, 1U}, {0x1800U, 0U}, {0x1801U, 2U}};
    const canopen_device_t* const device = &network.devices[0]->device;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    for (size_t i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        set(0U, others[i].index, others[i].subindex, 4U, 0x80000155U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    const uint16_t transmit[2] = {0x191U, 0x291U};
    const uint16_t receive[2]  = {0x211U, 0x311U};
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_HEX16(transmit[i], device->transmit[i].cob);
        TEST_ASSERT_EQUAL_HEX16(receive[i], device->receive[i].cob);
        TEST_ASSERT_TRUE(device->transmit[i].is_valid);
    }
    TEST_ASSERT_TRUE(device->receive[0].is_valid);
    TEST_ASSERT_FALSE(device->receive[1].is_valid);
}

static void two_devices_cannot_send_under_one_identifier(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    set(1U, 0x1801U, 1U, 4U, 0x191U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, cycle(canopen_network_start));
    TEST_ASSERT_FALSE(network.is_running);
    TEST_ASSERT_EQUAL(0U, network.master.route_count); // The start has left no route.
    idle(2U);
    TEST_ASSERT_EQUAL_UINT(0U, bus.syncs);
    // A device that could not be connected does not remove the route of the other device.
    canopen_device_t* const devices[2] = {&network.devices[0]->device, &network.devices[1]->device};
    devices[1]->transmit[1].is_valid   = true;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_connect(devices[0]));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, canopen_device_connect(devices[1]));
    canopen_device_disconnect(devices[1]);
    const uint8_t octets[8] = {0x50U, 0x02U};
    scripted_bus_deliver(&bus, 0x191U, octets, 8U);
    idle(1U);
    TEST_ASSERT_TRUE(devices[0]->transmit[0].is_heard);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, devices[0]->axes[0].statusword);
}

static void a_closed_network_starts_from_the_beginning(void)
{
    canopen_network_fault_t fault;
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_emergency(&bus, 0x11U, 0x4310U);
    idle(1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    canopen_network_close(&network);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_network_take_fault(&network, &fault));
    TEST_ASSERT_FALSE(network.is_running);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, canopen_network_start(&network, now_ns)); // The network has not booted.
    network.master.route_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    go(CIA402_GOAL_STANDBY);
    go(CIA402_GOAL_ENABLED);
    // Securing starts again with the quick stop.
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_secure));
    TEST_ASSERT_EQUAL_HEX16(0x0002U, joints[0]->control[0]);
}

static void a_boot_that_was_interrupted_by_closing_begins_with_the_reset(void)
{
    for (unsigned i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(canopen_network_boot));
    }
    canopen_network_close(&network);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
    const unsigned boots = joints[0]->boots;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL_UINT(boots + 1U, joints[0]->boots);
}

static void settings_belong_to_their_device_until_they_are_cleared(void)
{
    TEST_ASSERT_EQUAL_UINT8(1U, canopen_network_find(&network, 0x12U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    set(0U, 0x6065U, 0U, 4U, 1U);
    set(1U, 0x6065U, 0U, 4U, 2U);
    canopen_network_clear_settings(&network);
    set(1U, 0x6066U, 0U, 2U, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_UINT(0U, joints[0]->writes);
    TEST_ASSERT_EQUAL_UINT(1U, joints[1]->writes);
    TEST_ASSERT_EQUAL_UINT32(3U, scripted_object(joints[1], 0x6066U, 0U)->value);
}

/// A shorter list of settings replaces a longer one completely.
static void settings_of_an_earlier_configuration_do_not_change_pdos(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    set(0U, 0x6065U, 0U, 4U, 1U);
    set(0U, 0x1400U, 1U, 4U, 0x80000211U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_FALSE(network.devices[0]->device.receive[0].is_valid);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_TRUE(network.devices[0]->device.receive[0].is_valid);
    canopen_network_clear_settings(&network);
    set(0U, 0x6065U, 0U, 4U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_TRUE(network.devices[0]->device.receive[0].is_valid);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(drives_are_commissioned_operated_and_stopped);
    RUN_TEST(process_data_pass_in_both_directions);
    RUN_TEST(a_joystick_is_one_node_with_two_axes);
    RUN_TEST(only_the_mappings_of_its_profile_are_read);
    RUN_TEST(the_network_checks_each_added_node);
    RUN_TEST(a_full_network_is_commissioned_and_secured);
    RUN_TEST(functions_called_out_of_order_are_refused);
    RUN_TEST(a_node_that_does_not_boot_is_reported_once_and_reset_again);
    RUN_TEST(a_device_of_another_type_is_refused);
    RUN_TEST(a_device_of_another_maker_or_kind_is_refused);
    RUN_TEST(a_device_that_boots_again_meanwhile_is_refused);
    RUN_TEST(a_device_that_maps_other_data_is_refused);
    RUN_TEST(a_device_without_a_rated_torque_is_refused);
    RUN_TEST(an_abort_and_silence_end_commissioning);
    RUN_TEST(starting_waits_for_the_process_data_of_each_device);
    RUN_TEST(a_network_can_be_configured_again_for_another_mode);
    RUN_TEST(nothing_commanded_in_one_configuration_acts_in_the_next);
    RUN_TEST(an_idle_device_is_not_enabled);
    RUN_TEST(a_boot_is_repeated_every_300_ms_at_the_missing_node_only);
    RUN_TEST(no_reset_is_repeated_while_no_node_acknowledges);
    RUN_TEST(a_silent_device_is_reported_after_100_ms_of_each_start);
    RUN_TEST(a_value_of_another_size_is_a_refusal_for_its_format);
    RUN_TEST(axes_that_a_device_does_not_have_take_no_part);
    RUN_TEST(only_identifiers_of_its_own_pdos_change_a_device);
    RUN_TEST(two_devices_cannot_send_under_one_identifier);
    RUN_TEST(a_closed_network_starts_from_the_beginning);
    RUN_TEST(a_boot_that_was_interrupted_by_closing_begins_with_the_reset);
    RUN_TEST(settings_belong_to_their_device_until_they_are_cleared);
    RUN_TEST(settings_of_an_earlier_configuration_do_not_change_pdos);
    return UNITY_END();
}
