// SPDX-License-Identifier: Apache-2.0
// The motor of a reaction wheel: torque and speed modes, limits, reaction to missing commands, errors.
#include "sim/devices/wheel.h"
#include "test/support/bounds.h"
#include "test/unit/sim/devices/master.h"
#include "test/unit/sim/devices/statuswords.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define ID 0x31U
#define SHEET "descriptors/devices/wheel.eds"
#define STEP_NS 500000U
#define UNIT_NM 2.2e-4
#define MOMENTUM_NMS 12.0
#define FULL_RAD_S (6000.0 * 2.0 * 3.14159265358979323846 / 60.0)

static master_t master;
static wheel_t* wheel;
static wheel_truth_t rotor;
static char error[EDS_ERROR_MAX];
static unsigned changes;

static void read_truth(void* context, wheel_truth_t* out_truth)
{
    (void)context;
    *out_truth = rotor;
}

static void on_change(void* context, uint8_t node, unsigned axis, uint16_t statusword, bool brake,
                      uint64_t now_ns)
{
    (void)context;
    (void)node;
    (void)axis;
    (void)statusword;
    (void)brake;
    (void)now_ns;
    changes++;
}

void setUp(void)
{
    const wheel_config_t config = {
        .momentum_nms = MOMENTUM_NMS, .read_truth = read_truth, .observer = on_change};
    memset(&rotor, 0, sizeof rotor);
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, wheel_create(master.bus, SHEET, ID, &config, &wheel, error),
                                  error);
    node_power_on(wheel_node(wheel));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
}

void tearDown(void)
{
    wheel_destroy(wheel);
    master_close(&master);
}

/// One cycle; the rotor accepts the torque while its momentum is below the limit.
static void cycle(uint16_t controlword, double torque_nm)
{
    const int16_t torque  = (int16_t)lround(torque_nm / UNIT_NM);
    const uint8_t data[4] = {(uint8_t)controlword, (uint8_t)(controlword >> 8), (uint8_t)torque,
                             (uint8_t)((uint16_t)torque >> 8)};
    master_send(&master, 0x200U + ID, data, 4U);
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, STEP_NS);
    const double before = rotor.momentum_nms;
    rotor.momentum_nms  = fmin(MOMENTUM_NMS, before + wheel_torque(wheel) * STEP_NS * 1e-9);
    rotor.torque_nm     = (rotor.momentum_nms - before) / (STEP_NS * 1e-9);
    wheel_end_step(wheel, bus_now_ns(master.bus));
}

static const uint8_t* answer(void)
{
    return master_last(&master, 0x180U + ID)->data;
}

static void enable(void)
{
    cycle(0x06U, 0.0);
    cycle(0x07U, 0.0);
    cycle(0x0FU, 0.0);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, octets_u16(answer()) & STATE_BITS);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, wheel_statusword(wheel) & STATE_BITS);
}

static void an_enabled_wheel_has_the_commanded_torque(void)
{
    cycle(0x06U, 0.1);
    EXPECT_WITHIN(0.0, 0.0, wheel_torque(wheel));
    enable();
    cycle(0x0FU, 0.11);
    EXPECT_WITHIN(0.11, 1e-9, wheel_torque(wheel));
    cycle(0x0FU, 0.11);
    TEST_ASSERT_EQUAL_INT16(500, (int16_t)octets_u16(&answer()[6]));
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(answer()) & AXIS_STATUS_INTERNAL_LIMIT);
    TEST_ASSERT_GREATER_THAN_UINT(2U, changes);
}

static void the_reported_speed_is_relative_to_the_housing(void)
{
    rotor.momentum_nms  = 6.0;
    rotor.housing_rad_s = 0.5;
    enable();
    TEST_ASSERT_EQUAL_INT32(lround((FULL_RAD_S / 2.0 - 0.5) * 1e6), (int32_t)octets_u32(&answer()[2]));
}

/// The sum of 0.5 and the largest number below 0.5 is 1: a value is not rounded by adding 0.5.
static void a_torque_of_less_than_half_a_unit_is_reported_as_zero(void)
{
    enable();
    for (unsigned i = 0U; i < 2U; i++) {
        rotor.torque_nm = ((i == 0U) ? 1.0 : -1.0) * nextafter(0.5, 0.0) * UNIT_NM;
        master_send(&master, 0x080U, NULL, 0U);
        master_wait(&master, STEP_NS);
        TEST_ASSERT_EQUAL_INT16(0, (int16_t)octets_u16(&answer()[6]));
    }
    rotor.torque_nm = 0.5 * UNIT_NM;
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT16(1, (int16_t)octets_u16(&answer()[6]));
}

static void limits_are_kept_and_reported_in_the_statusword(void)
{
    enable();
    cycle(0x0FU, 0.5);
    EXPECT_WITHIN(0.22, 1e-9, wheel_torque(wheel));
    cycle(0x0FU, 0.5);
    TEST_ASSERT_NOT_EQUAL(0U, octets_u16(answer()) & AXIS_STATUS_INTERNAL_LIMIT);
    cycle(0x0FU, 0.1);
    cycle(0x0FU, 0.1);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(answer()) & AXIS_STATUS_INTERNAL_LIMIT);
    rotor.momentum_nms = MOMENTUM_NMS; // The wheel is at its largest speed.
    cycle(0x0FU, 0.1);
    cycle(0x0FU, 0.1);
    TEST_ASSERT_NOT_EQUAL(0U, octets_u16(answer()) & AXIS_STATUS_INTERNAL_LIMIT);
    TEST_ASSERT_EQUAL_INT16(0, (int16_t)octets_u16(&answer()[6]));
}

static void the_speed_mode_reaches_the_commanded_speed(void)
{
    rotor.momentum_nms = 0.05;
    TEST_ASSERT_EQUAL_HEX32(0U, master_write(&master, ID, 0x6060U, 0U, 9U, 1U));
    TEST_ASSERT_NOT_EQUAL(0U, master_write(&master, ID, 0x6060U, 0U, 8U, 1U));
    TEST_ASSERT_EQUAL_HEX32(0U, master_write(&master, ID, 0x60FFU, 0U, 1000000U, 4U));
    enable();
    for (unsigned i = 0U; i < 4000U; i++) {
        cycle(0x0FU, 0.0);
        TEST_ASSERT_TRUE(fabs(wheel_torque(wheel)) <= 0.22 + 1e-9);
    }
    TEST_ASSERT_INT32_WITHIN(1000, 1000000, (int32_t)octets_u32(&answer()[2]));
}

static void without_commands_the_motor_gives_no_torque(void)
{
    enable();
    cycle(0x0FU, 0.2);
    TEST_ASSERT_TRUE(wheel_torque(wheel) > 0.19);
    cycle(0x02U, 0.2); // Quick stop.
    EXPECT_WITHIN(0.0, 0.0, wheel_torque(wheel));
    for (unsigned i = 0U; i < 4U; i++) {
        cycle(0x02U, 0.2);
    }
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, wheel_statusword(wheel) & STATE_BITS_WITHOUT_5);
    enable();
    cycle(0x0FU, 0.2);
    for (unsigned i = 0U; i < 120U; i++) { // No RPDO arrives until its deadline has passed.
        master_wait(&master, STEP_NS);
        wheel_end_step(wheel, bus_now_ns(master.bus));
    }
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, wheel_statusword(wheel) & STATE_BITS_WITHOUT_5);
    EXPECT_WITHIN(0.0, 0.0, wheel_torque(wheel));
    TEST_ASSERT_NOT_NULL(master_last(&master, 0x080U + ID));
}

static void a_warning_keeps_the_torque_and_an_error_ends_it(void)
{
    enable();
    wheel_set_error(wheel, EMERGENCY_DRIVE_TEMPERATURE, true, bus_now_ns(master.bus));
    TEST_ASSERT_NOT_EQUAL(0U, wheel_statusword(wheel) & AXIS_STATUS_WARNING);
    cycle(0x0FU, 0.1);
    EXPECT_WITHIN(0.1, 1e-3, wheel_torque(wheel));
    wheel_set_error(wheel, EMERGENCY_OVER_CURRENT, true, bus_now_ns(master.bus));
    for (unsigned i = 0U; i < 4U; i++) {
        cycle(0x0FU, 0.1);
    }
    TEST_ASSERT_EQUAL_HEX16(FAULT, wheel_statusword(wheel) & STATE_BITS_WITHOUT_5);
    EXPECT_WITHIN(0.0, 0.0, wheel_torque(wheel));
}

static void a_data_sheet_of_another_device_is_refused(void)
{
    wheel_t* none               = wheel;
    const wheel_config_t config = {.momentum_nms = 1.0, .read_truth = read_truth};
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, wheel_create(master.bus, "descriptors/devices/joystick.eds", 0x33U,
                                                       &config, &none, error));
    TEST_ASSERT_NULL(none);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "a reaction wheel needs"), error);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_enabled_wheel_has_the_commanded_torque);
    RUN_TEST(the_reported_speed_is_relative_to_the_housing);
    RUN_TEST(a_torque_of_less_than_half_a_unit_is_reported_as_zero);
    RUN_TEST(limits_are_kept_and_reported_in_the_statusword);
    RUN_TEST(the_speed_mode_reaches_the_commanded_speed);
    RUN_TEST(without_commands_the_motor_gives_no_torque);
    RUN_TEST(a_warning_keeps_the_torque_and_an_error_ends_it);
    RUN_TEST(a_data_sheet_of_another_device_is_refused);
    return UNITY_END();
}
