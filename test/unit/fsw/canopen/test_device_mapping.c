// SPDX-License-Identifier: Apache-2.0
// Settings that change the mapping of PDOs, on a bus with two drives.
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

static void map_without_torque_offset(void)
{
    static const struct {
        uint16_t object;
        uint8_t subindex;
        uint8_t octets;
        uint32_t value;
    } settings[] = {{0x1400U, 1U, 4U, 0x80000211U}, {0x1600U, 0U, 1U, 0U}, {0x1600U, 1U, 4U, 0x60400010U},
                    {0x1600U, 2U, 4U, 0x607A0020U}, {0x1600U, 0U, 1U, 2U}, {0x1400U, 1U, 4U, 0x00000211U}};
    for (unsigned i = 0U; i < (sizeof settings / sizeof settings[0]); i++) {
        set(0U, settings[i].object, settings[i].subindex, settings[i].octets, settings[i].value);
    }
}

/// The settings remove the torque offset from RPDO1, and the device sets it to 0. After a boot the mapping of
/// the device class is in force again.
static void settings_change_the_mapping_of_a_device_that_has_a_mapping_of_its_own(void)
{
    static canopen_mapping_t mapping;
    canopen_device_t* const device          = &network.devices[0]->device;
    const canopen_device_profile_t* profile = device->profile;
    const uint8_t octets                    = canopen_device_profile_pdo_octets(&profile->receive[0]);
    canopen_device_follow_mapping(device, &mapping);
    run_to(CIA402_GOAL_ENABLED);
    canopen_cia402_axis_command_position(&device->axes[0], 0.5, -3.0);
    idle(2U);
    TEST_ASSERT_EQUAL_HEX32((uint16_t)-300, scripted_object(joints[0], 0x60B2U, 0U)->value);
    go(CIA402_GOAL_DISABLED);
    canopen_network_clear_settings(&network);
    map_without_torque_offset();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(joints[0], 0x60B2U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT8(6U, canopen_device_profile_pdo_octets(&device->profile->receive[0]));
    TEST_ASSERT_EQUAL_UINT8(octets, canopen_device_profile_pdo_octets(&profile->receive[0]));
    canopen_device_reset(device);
    TEST_ASSERT_EQUAL_UINT8(octets, canopen_device_profile_pdo_octets(&device->profile->receive[0]));
    expect_no_fault();
}

/// Without a mapping of its own, the device object only sends the settings. drives_fit gives a mapping to
/// each device whose settings need one.
static void a_device_without_a_mapping_of_its_own_keeps_that_of_its_class(void)
{
    run_to(CIA402_GOAL_DISABLED);
    const canopen_device_profile_t* const profile = network.devices[0]->device.profile;
    canopen_network_clear_settings(&network);
    map_without_torque_offset();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL_PTR(profile, network.devices[0]->device.profile);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(settings_change_the_mapping_of_a_device_that_has_a_mapping_of_its_own);
    RUN_TEST(a_device_without_a_mapping_of_its_own_keeps_that_of_its_class);
    return UNITY_END();
}
