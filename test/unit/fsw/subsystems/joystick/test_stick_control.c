// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/joystick/force_display.h"
#include "fsw/subsystems/joystick/stick_control.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005
#define INERTIA 0.002 // Inertia of the stick [kgm2].

static joystick_stick_control_t control;
static joystick_control_t gains;
static joystick_force_display_t display;

void setUp(void)
{
    gains = (joystick_control_t){.force_scale        = 0.03,
                                 .damping_free       = 0.05,
                                 .damping_contact    = 0.85,
                                 .contact_threshold  = 0.3,
                                 .contact_range      = 1.0,
                                 .contact_attack     = 1600.0,
                                 .contact_decay      = 15.0,
                                 .velocity_bandwidth = 1500.0,
                                 .torque_ceiling     = 1.5,
                                 .ramp_time          = 0.2};
    joystick_stick_control_init(&control);
    joystick_force_display_clear(&display);
}

void tearDown(void)
{
}

static void still(void)
{
    const double position[2] = {0.1, -0.1};
    joystick_stick_control_sense(&control, &gains, PERIOD_S, position);
}

static void reflect(const double first_nm, const double second_nm)
{
    const double felt[2] = {first_nm, second_nm};
    joystick_stick_control_reflect(&control, &gains, PERIOD_S, felt, 1.0);
}

static void a_motionless_stick_feels_the_scaled_torque(void)
{
    still();
    reflect(-11.0, 8.0);
    EXPECT_WITHIN(-0.33, 1.0e-12, control.command_nm[0]);
    EXPECT_WITHIN(0.24, 1.0e-12, control.command_nm[1]);
    const double felt[2] = {-11.0, 8.0};
    joystick_stick_control_reflect(&control, &gains, PERIOD_S, felt, 0.5);
    EXPECT_WITHIN(-0.165, 1.0e-12, control.command_nm[0]);
}

/// Returns the torque command at a steady speed after a while.
static double at_speed(const double speed_rad_s, const double felt_nm)
{
    setUp();
    for (unsigned i = 0U; i < 2000U; i++) {
        const double position[2] = {speed_rad_s * PERIOD_S * (double)i, 0.0};
        joystick_stick_control_sense(&control, &gains, PERIOD_S, position);
        reflect(felt_nm, 0.0);
    }
    return control.command_nm[0];
}

static void free_space_is_damped_little_and_contact_more(void)
{
    EXPECT_WITHIN(-0.05 * 0.5, 1.0e-9, at_speed(0.5, 0.0));
    // Below the threshold of contact.
    EXPECT_WITHIN((0.03 * 0.2) - (0.05 * 0.5), 1.0e-9, at_speed(0.5, 0.2));
    // Half way between free space and contact.
    EXPECT_WITHIN((0.03 * 0.8) - (0.475 * 0.5), 1.0e-6, at_speed(0.5, 0.8));
    EXPECT_WITHIN((0.03 * 9.0) - (0.9 * 0.5), 1.0e-6, at_speed(0.5, 9.0));
    EXPECT_WITHIN((-0.03 * 9.0) + (0.9 * 0.5), 1.0e-6, at_speed(-0.5, -9.0)); // Negative speed and torque.
}

static void contact_rises_fast_and_falls_slowly(void)
{
    still();
    reflect(9.0, 0.0);
    EXPECT_WITHIN(0.8, 1.0e-12, control.contact);
    reflect(9.0, 0.0);
    EXPECT_ABOVE(0.95, control.contact);
    for (unsigned i = 0U; i < 133U; i++) { // 67 ms = one time constant.
        reflect(0.0, 0.0);
    }
    EXPECT_WITHIN(exp(-1.0), 0.02, control.contact);
    gains.contact_attack = 1.0e9; // The degree of contact stays within 0..1 for any rate.
    for (unsigned i = 0U; i < 50U; i++) {
        reflect(1.0e9, -1.0e9);
        TEST_ASSERT_TRUE((control.contact >= 0.0) && (control.contact <= 1.0));
    }
}

static void contact_ends_without_subnormal_numbers(void)
{
    still();
    reflect(9.0, 0.0);
    for (unsigned i = 0U; i < 200000U; i++) { // 100 s of free space.
        reflect(0.0, 0.0);
        TEST_ASSERT_FALSE(fpclassify(control.contact) == FP_SUBNORMAL);
    }
    TEST_ASSERT_TRUE(control.contact == 0.0);
}

/// If friction holds the tip of the arm on a wall, only one joint shows the contact; the damping must act on
/// the axis of the other joint, too.
static void both_axes_are_damped_if_one_is_in_contact(void)
{
    for (unsigned i = 0U; i < 2000U; i++) {
        const double position[2] = {0.0, 0.5 * PERIOD_S * (double)i};
        joystick_stick_control_sense(&control, &gains, PERIOD_S, position);
        reflect(-9.0, 0.0);
    }
    EXPECT_WITHIN(-0.9 * 0.5, 1.0e-6, control.command_nm[1]);
    EXPECT_WITHIN(-0.03 * 9.0, 1.0e-6, control.command_nm[0]);
}

static void no_torque_exceeds_the_ceiling(void)
{
    const double wild[] = {100.0, 1.0e300, (double)INFINITY, -(double)INFINITY, (double)NAN};
    still();
    for (unsigned i = 0U; i < 5U; i++) {
        reflect(wild[i], -wild[i]);
        TEST_ASSERT_TRUE(fabs(control.command_nm[0]) <= 1.5);
        TEST_ASSERT_TRUE(fabs(control.command_nm[1]) <= 1.5);
    }
    TEST_ASSERT_EQUAL_UINT(10U, control.limited);
    reflect(1.0, 1.0);
    // The state contains no NaN, which would not be equal to itself.
    TEST_ASSERT_TRUE(control.contact == control.contact);
}

static void damping_takes_energy_from_a_swinging_stick(void)
{
    double position[2] = {0.2, 0.0};
    double speed       = 0.0;
    for (unsigned i = 0U; i < 4000U; i++) { // The hand acts like a spring of 3 Nm/rad.
        joystick_stick_control_sense(&control, &gains, PERIOD_S, position);
        reflect(0.0, 0.0);
        speed += PERIOD_S * (control.command_nm[0] - (3.0 * position[0])) / INERTIA;
        position[0] += PERIOD_S * speed;
        TEST_ASSERT_TRUE(fabs(position[0]) <= 0.2 + 1.0e-9);
    }
    EXPECT_WITHIN(0.0, 1.0e-5, position[0]);
}

// ---- Display ----

static void a_displayed_torque_has_its_damping(void)
{
    const double torque[2] = {0.3, -0.2};
    still();
    joystick_stick_control_display(&control, &gains, torque);
    EXPECT_WITHIN(0.3, 1.0e-12, control.command_nm[0]);
    EXPECT_WITHIN(-0.2, 1.0e-12, control.command_nm[1]);
}

static void a_force_rises_holds_and_ends_within_its_time(void)
{
    const double goal[2] = {0.3, -0.6};
    const double rate    = 7.5; // 1.5 Nm in 0.2 s.
    double before[2]     = {0.0, 0.0};
    unsigned held        = 0U;
    unsigned steps       = 0U;
    joystick_force_display_begin(&display, goal, 0.5);
    while (display.is_active && (steps < 2000U)) {
        joystick_force_display_step(&display, PERIOD_S, rate);
        for (unsigned i = 0U; i < 2U; i++) {
            EXPECT_BELOW((rate * PERIOD_S) + 1.0e-12, fabs(display.torque_nm[i] - before[i]));
            before[i] = display.torque_nm[i];
        }
        held += ((display.torque_nm[0] == 0.3) && (display.torque_nm[1] == -0.6)) ? 1U : 0U;
        steps++;
    }
    TEST_ASSERT_UINT_WITHIN(2U, 1000U, steps);
    TEST_ASSERT_UINT_WITHIN(4U, 1000U - 320U, held); // 0.6 / 7.5 s = 160 steps up and as many down.
    TEST_ASSERT_TRUE((display.torque_nm[0] == 0.0) && (display.torque_nm[1] == 0.0));
}

static void a_short_force_never_exceeds_its_duration(void)
{
    const double goal[2] = {1.5, 0.0};
    unsigned steps       = 0U;
    double largest       = 0.0;
    joystick_force_display_begin(&display, goal, 0.1);
    while (display.is_active && (steps < 2000U)) {
        joystick_force_display_step(&display, PERIOD_S, 7.5);
        largest = fmax(largest, display.torque_nm[0]);
        steps++;
    }
    TEST_ASSERT_UINT_WITHIN(4U, 200U, steps);
    EXPECT_WITHIN(0.375, 0.01, largest);
}

static void stop_or_another_function_ends_a_force_without_duration(void)
{
    const double goal[2]  = {0.3, 0.3};
    const double other[2] = {-0.3, 0.3};
    joystick_force_display_begin(&display, goal, 0.0);
    for (unsigned i = 0U; i < 10000U; i++) {
        joystick_force_display_step(&display, PERIOD_S, 7.5);
    }
    TEST_ASSERT_TRUE(display.is_active && (display.torque_nm[0] == 0.3));
    joystick_force_display_begin(&display, other, 0.0);
    joystick_force_display_step(&display, PERIOD_S, 7.5);
    EXPECT_WITHIN(0.3 - (7.5 * PERIOD_S), 1.0e-12, display.torque_nm[0]);
    for (unsigned i = 0U; i < 1000U; i++) {
        joystick_force_display_step(&display, PERIOD_S, 7.5);
    }
    joystick_force_display_stop(&display);
    unsigned steps = 0U;
    while (display.is_active && (steps < 2000U)) {
        joystick_force_display_step(&display, PERIOD_S, 7.5);
        steps++;
    }
    TEST_ASSERT_UINT_WITHIN(2U, 80U, steps);
    joystick_force_display_stop(&display);
    joystick_force_display_step(&display, PERIOD_S, 7.5);
    TEST_ASSERT_FALSE(display.is_active);
}

/// The numbers are powers of two, so that the ramp down must begin exactly at a cycle.
static void a_force_is_zero_at_the_instant_its_duration_ends(void)
{
    const double goal[2] = {1.0, -0.5};
    joystick_force_display_begin(&display, goal, 0.5);
    for (unsigned i = 0U; i < 512U; i++) {
        TEST_ASSERT_TRUE(display.is_active);
        joystick_force_display_step(&display, 1.0 / 1024.0, 8.0);
        TEST_ASSERT_TRUE((i != 384U) || (display.torque_nm[0] < 1.0)); // Here the ramp down begins.
        TEST_ASSERT_TRUE((i != 383U) || (display.torque_nm[0] == 1.0));
    }
    TEST_ASSERT_TRUE(display.torque_nm[0] == 0.0);
    TEST_ASSERT_TRUE(display.torque_nm[1] == 0.0);
    TEST_ASSERT_FALSE(display.is_active);
}

static void a_command_at_the_ceiling_is_not_counted_as_limited(void)
{
    const double most[2] = {1.5, -1.5};
    const double more[2] = {1.5, -1.6};
    still();
    joystick_stick_control_display(&control, &gains, most);
    TEST_ASSERT_EQUAL_UINT(0U, control.limited);
    joystick_stick_control_display(&control, &gains, more);
    TEST_ASSERT_EQUAL_UINT(1U, control.limited);
}

static void contact_ends_when_a_torque_is_displayed(void)
{
    const double torque[2] = {0.0, 0.0};
    still();
    reflect(9.0, -9.0);
    joystick_stick_control_display(&control, &gains, torque);
    TEST_ASSERT_TRUE(control.contact == 0.0);
}

static void a_cleared_force_is_zero_at_once(void)
{
    const double goal[2] = {0.3, 0.3};
    joystick_force_display_begin(&display, goal, 0.0);
    joystick_force_display_step(&display, PERIOD_S, 7.5);
    joystick_force_display_clear(&display);
    TEST_ASSERT_FALSE(display.is_active);
    TEST_ASSERT_TRUE((display.torque_nm[0] == 0.0) && (display.torque_nm[1] == 0.0));
    // The next force ends, although the last one had no end.
    joystick_force_display_begin(&display, goal, 1.0);
    TEST_ASSERT_FALSE(display.is_lasting);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_motionless_stick_feels_the_scaled_torque);
    RUN_TEST(free_space_is_damped_little_and_contact_more);
    RUN_TEST(contact_rises_fast_and_falls_slowly);
    RUN_TEST(contact_ends_without_subnormal_numbers);
    RUN_TEST(both_axes_are_damped_if_one_is_in_contact);
    RUN_TEST(no_torque_exceeds_the_ceiling);
    RUN_TEST(damping_takes_energy_from_a_swinging_stick);
    RUN_TEST(a_displayed_torque_has_its_damping);
    RUN_TEST(a_force_rises_holds_and_ends_within_its_time);
    RUN_TEST(a_short_force_never_exceeds_its_duration);
    RUN_TEST(stop_or_another_function_ends_a_force_without_duration);
    RUN_TEST(a_force_is_zero_at_the_instant_its_duration_ends);
    RUN_TEST(a_command_at_the_ceiling_is_not_counted_as_limited);
    RUN_TEST(contact_ends_when_a_torque_is_displayed);
    RUN_TEST(a_cleared_force_is_zero_at_once);
    return UNITY_END();
}
