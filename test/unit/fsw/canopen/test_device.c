// SPDX-License-Identifier: Apache-2.0
// What a device takes from its data sheet: units, limits and emergency codes. The bus has two drives.
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

static void a_device_that_uses_another_unit_is_refused(void)
{
    scripted_object(joints[1], 0x60A8U, 0U)->value = 0xFD410000U; // Millidegrees.
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_VALUE, 0x60A800U, 0xFD410000U);
}

/// The units of each axis are one step of the identification (canopen_device_identify). If the sheet states
/// no units, this step reads no object, but the steps after it still check the mapping.
static void devices_without_units_are_identified_to_the_end(void)
{
    static canopen_device_profile_t profile;
    profile                    = *network.devices[0]->device.profile;
    profile.axes[0].unit_count = 0U;
    for (unsigned i = 0U; i < 2U; i++) {
        network.devices[i]->device.profile = &profile;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    scripted_object(joints[1], 0x1600U, 0U)->value = 7U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(canopen_network_boot));
    expect_refusal(0x12U, REFUSAL_VALUE, 0x160000U, 7U);
}

/// Limits come from the data sheet until a setting changes them; a boot-up restores the limits of the data
/// sheet.
static void limits_follow_sheet_and_settings(void)
{
    canopen_cia402_axis_t* const axis = &network.devices[1]->device.axes[0];
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    canopen_cia402_axis_command_position(axis, 3.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(2800000, axis->target_position);
    set(1U, 0x607DU, 1U, 4U, (uint32_t)-250000);
    set(1U, 0x607DU, 2U, 4U, 750000U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    canopen_cia402_axis_command_position(axis, 3.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(750000, axis->target_position);
    canopen_cia402_axis_command_position(axis, -3.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(-250000, axis->target_position);
    canopen_device_reset(&network.devices[1]->device);
    canopen_cia402_axis_command_position(axis, -3.0, 0.0);
    TEST_ASSERT_EQUAL_INT32(-2800000, axis->target_position);
}

/// The data sheet defines the code 0xFF01, but not 0xFF02.
static void a_manufacturer_code_has_the_severity_of_the_data_sheet(void)
{
    run_to(CIA402_GOAL_ENABLED);
    scripted_bus_emergency(&bus, 0x12U, 0xFF02U);
    idle(1U);
    expect_fault(NETWORK_DRIVE_WARNING, 0x12U, 0xFF02U);
    scripted_bus_emergency(&bus, 0x11U, 0xFF01U);
    idle(1U);
    expect_fault(NETWORK_DRIVE_FAULT, 0x11U, 0xFF01U);
    expect_no_fault();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_device_that_uses_another_unit_is_refused);
    RUN_TEST(devices_without_units_are_identified_to_the_end);
    RUN_TEST(limits_follow_sheet_and_settings);
    RUN_TEST(a_manufacturer_code_has_the_severity_of_the_data_sheet);
    return UNITY_END();
}
