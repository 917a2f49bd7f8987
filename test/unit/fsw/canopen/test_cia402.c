// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/axis.h"
#include "fsw/canopen/cia402.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

static const canopen_cia402_scale_t scale = {
    .position_rad = 1.0e-6, .velocity_rad_s = 1.0e-6, .torque_nm = 0.01, .torque_max_nm = 40.0};
static canopen_cia402_axis_t axis;

void setUp(void)
{
    canopen_cia402_axis_init(&axis, scale);
}

void tearDown(void)
{
}

// Bits of the statusword that define each state of CiA 402.
static const uint16_t status_bits[] = {
    [CIA402_NOT_READY]          = 0x00U,
    [CIA402_SWITCH_ON_DISABLED] = 0x40U,
    [CIA402_READY]              = 0x21U,
    [CIA402_SWITCHED_ON]        = 0x23U,
    [CIA402_OPERATION_ENABLED]  = 0x27U,
    [CIA402_QUICK_STOP_ACTIVE]  = 0x07U,
    [CIA402_FAULT_REACTION]     = 0x0FU,
    [CIA402_FAULT]              = 0x08U,
};

static void every_statusword_is_decoded_by_the_masks_of_the_standard(void)
{
    unsigned counts[CIA402_UNKNOWN + 1] = {0U};
    for (uint32_t word = 0U; word <= 0xFFFFU; word++) {
        const canopen_cia402_state_t state = canopen_cia402_state((uint16_t)word);
        canopen_cia402_state_t expected    = CIA402_UNKNOWN;
        if ((word & 0x4FU) == 0x00U) {
            expected = CIA402_NOT_READY;
        } else if ((word & 0x4FU) == 0x40U) {
            expected = CIA402_SWITCH_ON_DISABLED;
        } else if ((word & 0x6FU) == 0x21U) {
            expected = CIA402_READY;
        } else if ((word & 0x6FU) == 0x23U) {
            expected = CIA402_SWITCHED_ON;
        } else if ((word & 0x6FU) == 0x27U) {
            expected = CIA402_OPERATION_ENABLED;
        } else if ((word & 0x6FU) == 0x07U) {
            expected = CIA402_QUICK_STOP_ACTIVE;
        } else if ((word & 0x4FU) == 0x0FU) {
            expected = CIA402_FAULT_REACTION;
        } else if ((word & 0x4FU) == 0x08U) {
            expected = CIA402_FAULT;
        } else {
            expected = CIA402_UNKNOWN;
        }
        TEST_ASSERT_EQUAL(expected, state);
        counts[state]++;
    }
    for (unsigned i = 0U; i < CIA402_UNKNOWN; i++) {
        TEST_ASSERT_GREATER_THAN_UINT(0U, counts[i]);
    }
}

// A drive that follows the standard. FAULT_REACTION lasts one step.
static canopen_cia402_state_t obey(const canopen_cia402_state_t state, const uint16_t word,
                                   const uint16_t before)
{
    const bool is_reset      = ((word & 0x80U) != 0U) && ((before & 0x80U) == 0U);
    const unsigned command   = word & 0x0FU;
    const bool is_no_voltage = (command & 0x2U) == 0U;
    const bool is_quick_stop = (command & 0x6U) == 0x2U;
    switch (state) {
    case CIA402_NOT_READY:
        return CIA402_SWITCH_ON_DISABLED;
    case CIA402_FAULT_REACTION:
        return CIA402_FAULT;
    case CIA402_FAULT:
        return is_reset ? CIA402_SWITCH_ON_DISABLED : CIA402_FAULT;
    case CIA402_SWITCH_ON_DISABLED:
        return ((command & 0x7U) == 0x6U) ? CIA402_READY : state;
    case CIA402_QUICK_STOP_ACTIVE:
        return CIA402_SWITCH_ON_DISABLED; // The drive has come to rest.
    default:
        break;
    }
    if (is_no_voltage) {
        return CIA402_SWITCH_ON_DISABLED;
    }
    if (is_quick_stop) {
        return (state == CIA402_OPERATION_ENABLED) ? CIA402_QUICK_STOP_ACTIVE : CIA402_SWITCH_ON_DISABLED;
    }
    if ((command & 0x7U) == 0x6U) {
        return CIA402_READY;
    }
    if (state == CIA402_READY) {
        return CIA402_SWITCHED_ON;
    }
    return ((command & 0x8U) != 0U) ? CIA402_OPERATION_ENABLED : CIA402_SWITCHED_ON;
}

/// Exception: without permission to reset a fault, STANDBY and ENABLED are not reached from a fault.
static void every_goal_is_reached_from_every_state(void)
{
    for (int start = CIA402_NOT_READY; start <= CIA402_FAULT; start++) {
        for (int goal = CIA402_GOAL_DISABLED; goal <= CIA402_GOAL_QUICK_STOP; goal++) {
            for (unsigned may_reset = 0U; may_reset <= 1U; may_reset++) {
                canopen_cia402_state_t state = (canopen_cia402_state_t)start;
                uint16_t word                = 0U;
                unsigned steps               = 0U;
                while (!canopen_cia402_is_at_goal(state, (canopen_cia402_goal_t)goal) && (steps < 10U)) {
                    const uint16_t before = word;
                    word  = canopen_cia402_controlword(state, (canopen_cia402_goal_t)goal, may_reset == 1U,
                                                       before);
                    state = obey(state, word, before);
                    steps++;
                }
                const bool is_up     = (goal == CIA402_GOAL_STANDBY) || (goal == CIA402_GOAL_ENABLED);
                const bool is_barred = is_up && (may_reset == 0U) &&
                                       ((start == CIA402_FAULT) || (start == CIA402_FAULT_REACTION));
                TEST_ASSERT_EQUAL(!is_barred, canopen_cia402_is_at_goal(state, (canopen_cia402_goal_t)goal));
                TEST_ASSERT_TRUE(is_barred || (steps <= 6U));
            }
        }
    }
}

static void a_drive_is_enabled_only_for_the_goal_enabled(void)
{
    const canopen_cia402_goal_t goals[] = {CIA402_GOAL_DISABLED, CIA402_GOAL_STANDBY, CIA402_GOAL_QUICK_STOP};
    for (unsigned g = 0U; g < 3U; g++) {
        for (int state = CIA402_NOT_READY; state <= CIA402_UNKNOWN; state++) {
            const uint16_t word =
                canopen_cia402_controlword((canopen_cia402_state_t)state, goals[g], true, 0U);
            TEST_ASSERT_NOT_EQUAL(CIA402_CONTROL_ENABLE, word & 0x8FU);
        }
    }
    TEST_ASSERT_EQUAL_HEX16(
        CIA402_CONTROL_QUICK_STOP,
        canopen_cia402_controlword(CIA402_OPERATION_ENABLED, CIA402_GOAL_QUICK_STOP, false, 0x0FU));
    TEST_ASSERT_EQUAL_HEX16(
        CIA402_CONTROL_SWITCH_ON,
        canopen_cia402_controlword(CIA402_OPERATION_ENABLED, CIA402_GOAL_STANDBY, false, 0x0FU));
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_DISABLE_VOLTAGE,
                            canopen_cia402_controlword(CIA402_UNKNOWN, CIA402_GOAL_ENABLED, true, 0x0FU));
}

/// One cycle in which the drive reports a state, with the bits VOLTAGE_ENABLED and REMOTE set.
static void cycle(const canopen_cia402_state_t state)
{
    axis.statusword = (uint16_t)(status_bits[state] | 0x0210U);
    canopen_cia402_axis_observe(&axis);
    canopen_cia402_axis_step(&axis);
}

/// A drive resets its fault at the rising edge of the bit, so the bit must fall before it is set again.
static void a_fault_is_reset_by_a_rising_edge(void)
{
    const uint16_t first = canopen_cia402_controlword(CIA402_FAULT, CIA402_GOAL_ENABLED, true, 0U);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_FAULT_RESET, first);
    const uint16_t second = canopen_cia402_controlword(CIA402_FAULT, CIA402_GOAL_ENABLED, true, first);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_DISABLE_VOLTAGE, second);
    TEST_ASSERT_EQUAL_HEX16(first,
                            canopen_cia402_controlword(CIA402_FAULT, CIA402_GOAL_ENABLED, true, second));
}

static void an_axis_that_leaves_operation_is_not_enabled_again(void)
{
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_ENABLED, false);
    cycle(CIA402_SWITCHED_ON);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_ENABLE, axis.controlword);
    TEST_ASSERT_FALSE(canopen_cia402_axis_is_at_goal(&axis));
    cycle(CIA402_OPERATION_ENABLED);
    TEST_ASSERT_TRUE(canopen_cia402_axis_is_at_goal(&axis));
    cycle(CIA402_SWITCH_ON_DISABLED);
    TEST_ASSERT_TRUE(axis.has_dropped);
    TEST_ASSERT_FALSE(canopen_cia402_axis_is_at_goal(&axis));
    for (unsigned i = 0U; i < 10U; i++) {
        cycle(CIA402_SWITCH_ON_DISABLED);
        TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_DISABLE_VOLTAGE, axis.controlword);
    }
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_STANDBY, true);
    TEST_ASSERT_FALSE(axis.has_dropped);
    cycle(CIA402_SWITCH_ON_DISABLED);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_SHUTDOWN, axis.controlword);
}

static void leaving_operation_on_command_is_not_a_fault(void)
{
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_ENABLED, false);
    cycle(CIA402_OPERATION_ENABLED);
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_STANDBY, false);
    cycle(CIA402_OPERATION_ENABLED);
    cycle(CIA402_SWITCHED_ON);
    TEST_ASSERT_FALSE(axis.has_dropped);
    TEST_ASSERT_TRUE(canopen_cia402_axis_is_at_goal(&axis));
}

static void values_are_scaled_and_rounded(void)
{
    axis.position = -1570796;
    axis.torque   = -1234;
    EXPECT_WITHIN(-1.570796, 1.0e-12, canopen_cia402_axis_position_rad(&axis));
    EXPECT_WITHIN(-12.34, 1.0e-12, canopen_cia402_axis_torque_nm(&axis));
    canopen_cia402_axis_command_position(&axis, 1.2345674, -5.678);
    TEST_ASSERT_EQUAL_INT32(1234567, axis.target_position);
    TEST_ASSERT_EQUAL_INT16(-568, axis.torque_offset);
    canopen_cia402_axis_command_torque(&axis, 0.004);
    TEST_ASSERT_EQUAL_INT16(0, axis.target_torque);
    canopen_cia402_axis_command_torque(&axis, -0.006);
    TEST_ASSERT_EQUAL_INT16(-1, axis.target_torque);
    TEST_ASSERT_EQUAL_UINT32(0U, axis.limited);
}

static void commands_never_exceed_the_limits(void)
{
    const double wild[] = {40.001, 1.0e9, 1.0e300, (double)INFINITY};
    for (unsigned i = 0U; i < 4U; i++) {
        canopen_cia402_axis_command_torque(&axis, wild[i]);
        TEST_ASSERT_EQUAL_INT16(4000, axis.target_torque);
        canopen_cia402_axis_command_torque(&axis, -wild[i]);
        TEST_ASSERT_EQUAL_INT16(-4000, axis.target_torque);
    }
    TEST_ASSERT_EQUAL_UINT32(8U, axis.limited);
    canopen_cia402_axis_command_torque(&axis, 40.0); // The maximum itself is allowed.
    TEST_ASSERT_EQUAL_INT16(4000, axis.target_torque);
    canopen_cia402_axis_command_torque(&axis, -40.0);
    TEST_ASSERT_EQUAL_INT16(-4000, axis.target_torque);
    TEST_ASSERT_EQUAL_UINT32(8U, axis.limited);
    canopen_cia402_axis_command_torque(&axis, (double)NAN);
    TEST_ASSERT_EQUAL_UINT32(9U, axis.limited);
    TEST_ASSERT_EQUAL_INT16(0, axis.target_torque);
    canopen_cia402_axis_command_position(&axis, 0.5, 0.0);
    canopen_cia402_axis_command_position(&axis, (double)NAN, (double)NAN);
    TEST_ASSERT_EQUAL_INT32(500000, axis.target_position);
    TEST_ASSERT_EQUAL_INT16(0, axis.torque_offset);
    canopen_cia402_axis_command_position(&axis, 1.0e9, 0.0);
    TEST_ASSERT_EQUAL_INT32(2147483647, axis.target_position);
    canopen_cia402_axis_command_position(&axis, -(double)INFINITY, 0.0);
    TEST_ASSERT_EQUAL_INT32(-2147483647, axis.target_position);
    // A torque limit beyond the range of an INTEGER16 is replaced by that range.
    axis.scale.torque_max_nm = 1000.0;
    canopen_cia402_axis_command_torque(&axis, 999.0);
    TEST_ASSERT_EQUAL_INT16(32767, axis.target_torque);
    // No torque is commanded before the device has reported its units.
    axis.scale.torque_max_nm = 0.0;
    canopen_cia402_axis_command_torque(&axis, 1.0);
    TEST_ASSERT_EQUAL_INT16(0, axis.target_torque);
}

/// The sum of this number and one half is rounded to 1, but its nearest whole number is 0.
#define BELOW_HALF 0.49999999999999994

static void halves_are_rounded_away_from_zero(void)
{
    static const struct {
        double units;
        int32_t nearest;
        int16_t torque;
        unsigned limited; // Number of the clipped values: position, velocity and torque.
    } cases[]                 = {{BELOW_HALF, 0, 0, 0U},
                                 {-BELOW_HALF, 0, 0, 0U},
                                 {0.5, 1, 1, 0U},
                                 {-0.5, -1, -1, 0U},
                                 {2.5, 3, 3, 0U},
                                 {-2.5, -3, -3, 0U},
                                 {32766.5, 32767, 32767, 0U},
                                 {32767.5, 32768, 32767, 1U},
                                 {-32767.5, -32768, -32767, 1U},
                                 {2147483646.5, 2147483647, 32767, 1U},
                                 {2147483647.5, 2147483647, 32767, 3U},
                                 {-2147483646.5, -2147483647, -32767, 1U},
                                 {-2147483647.5, -2147483647, -32767, 3U}};
    axis.scale.position_rad   = 1.0;
    axis.scale.velocity_rad_s = 1.0;
    axis.scale.torque_nm      = 1.0;
    axis.scale.torque_max_nm  = 1e6;
    for (unsigned i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        axis.limited = 0U;
        canopen_cia402_axis_command_position(&axis, cases[i].units, 0.0);
        canopen_cia402_axis_command_velocity(&axis, cases[i].units, 0.0);
        canopen_cia402_axis_command_torque(&axis, cases[i].units);
        TEST_ASSERT_EQUAL_INT32(cases[i].nearest, axis.target_position);
        TEST_ASSERT_EQUAL_INT32(cases[i].nearest, axis.target_velocity);
        TEST_ASSERT_EQUAL_INT16(cases[i].torque, axis.target_torque);
        TEST_ASSERT_EQUAL_UINT32(cases[i].limited, axis.limited);
    }
}

static void a_velocity_is_commanded_with_a_torque_offset(void)
{
    canopen_cia402_axis_command_velocity(&axis, -0.25, 1.5);
    TEST_ASSERT_EQUAL_INT32(-250000, axis.target_velocity);
    TEST_ASSERT_EQUAL_INT16(150, axis.torque_offset);
    canopen_cia402_axis_command_velocity(&axis, 1.0e9, 0.0);
    TEST_ASSERT_EQUAL_INT32(2147483647, axis.target_velocity);
    TEST_ASSERT_EQUAL_UINT32(1U, axis.limited);
    canopen_cia402_axis_command_velocity(&axis, (double)NAN, 0.0);
    TEST_ASSERT_EQUAL_INT32(0, axis.target_velocity);
    TEST_ASSERT_EQUAL_UINT32(2U, axis.limited);
}

static void commands_stay_within_the_limits_of_the_axis(void)
{
    axis.scale.low_rad     = -0.5;
    axis.scale.high_rad    = 1.5;
    axis.scale.speed_rad_s = 2.0;
    canopen_cia402_axis_command_position(&axis, 1.75, 0.0);
    TEST_ASSERT_EQUAL_INT32(1500000, axis.target_position);
    canopen_cia402_axis_command_position(&axis, -0.75, 0.0);
    TEST_ASSERT_EQUAL_INT32(-500000, axis.target_position);
    canopen_cia402_axis_command_velocity(&axis, -2.5, 0.0);
    TEST_ASSERT_EQUAL_INT32(-2000000, axis.target_velocity);
    TEST_ASSERT_EQUAL_UINT32(3U, axis.limited);
    canopen_cia402_axis_command_velocity(&axis, 2.0, 0.0);
    canopen_cia402_axis_command_position(&axis, 1.5, 0.0);
    TEST_ASSERT_EQUAL_INT32(2000000, axis.target_velocity);
    TEST_ASSERT_EQUAL_INT32(1500000, axis.target_position);
    TEST_ASSERT_EQUAL_UINT32(3U, axis.limited);
}

/// The start bit is set in operation only, and a reference that was found before does not count.
static void homing_is_started_in_operation_and_ended_by_the_drive(void)
{
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_ENABLED, false);
    canopen_cia402_axis_home(&axis, true);
    cycle(CIA402_SWITCHED_ON);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_ENABLE, axis.controlword);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_cia402_axis_homing(&axis));
    axis.statusword = 0x1627U; // In operation; the bits still show the result of an earlier search.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    cycle(CIA402_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(0x001FU, axis.controlword);
    axis.statusword = 0x1627U; // Sampled before the drive received the start bit: still the earlier search.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    axis.statusword = 0x2227U; // The same with an error of the earlier search.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    cycle(CIA402_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(0x001FU, axis.controlword);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    canopen_cia402_axis_home(&axis, true); // Repeating the request does not start the search again.
    axis.statusword = 0x0627U;             // The axis rests and has no reference.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    axis.statusword = 0x1227U; // The reference is found, but the axis still moves.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    axis.statusword = 0x1627U;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_cia402_axis_homing(&axis));
    axis.statusword = 0x2227U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_cia402_axis_homing(&axis));
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_QUICK_STOP, false);
    cycle(CIA402_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_QUICK_STOP, axis.controlword);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_cia402_axis_homing(&axis));
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_ENABLED, false); // The other goal has ended the search.
    cycle(CIA402_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL_HEX16(CIA402_CONTROL_ENABLE, axis.controlword);
    canopen_cia402_axis_home(&axis, true);
    axis.statusword = 0x2627U; // The error of the last search does not end the next one.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_cia402_axis_homing(&axis));
    cycle(CIA402_OPERATION_ENABLED);
    cycle(CIA402_OPERATION_ENABLED);
    axis.statusword = 0x2627U; // An error of the present search ends it.
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_cia402_axis_homing(&axis));
    canopen_cia402_axis_set_goal(&axis, CIA402_GOAL_ENABLED, false); // The same goal does not end the search.
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_cia402_axis_homing(&axis));
    canopen_cia402_axis_home(&axis, false);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_cia402_axis_homing(&axis));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_statusword_is_decoded_by_the_masks_of_the_standard);
    RUN_TEST(every_goal_is_reached_from_every_state);
    RUN_TEST(a_drive_is_enabled_only_for_the_goal_enabled);
    RUN_TEST(a_fault_is_reset_by_a_rising_edge);
    RUN_TEST(an_axis_that_leaves_operation_is_not_enabled_again);
    RUN_TEST(commands_stay_within_the_limits_of_the_axis);
    RUN_TEST(leaving_operation_on_command_is_not_a_fault);
    RUN_TEST(values_are_scaled_and_rounded);
    RUN_TEST(commands_never_exceed_the_limits);
    RUN_TEST(halves_are_rounded_away_from_zero);
    RUN_TEST(a_velocity_is_commanded_with_a_torque_offset);
    RUN_TEST(homing_is_started_in_operation_and_ended_by_the_drive);
    return UNITY_END();
}
