// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/joystick/remote_contact.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define PERIOD_S 0.0005

static joystick_remote_t gains;
static joystick_robot_contact_payload_t robot;
static joystick_remote_contact_t contact;
static uint32_t state;

void setUp(void)
{
    gains = (joystick_remote_t){.position_scale = 2.0,
                                .stiffness      = 7000.0,
                                .fade_from      = 1.0,
                                .fade_to        = 4.0,
                                .tangential     = 0.5,
                                .reserve        = 2.0e-3,
                                .damping_max    = 0.8};
    robot = (joystick_robot_contact_payload_t){.echo     = {0.05, -0.02},
                                               .jacobian = {-0.0655, 0.125, 0.3265, 0.2165},
                                               .normal   = {0.0, 1.0},
                                               .push     = 15.0};
    state = 4711U;
    joystick_remote_contact_reset(&contact);
}

void tearDown(void)
{
}

static double draw(void)
{
    state = (state * 1664525U) + 1013904223U;
    return ((double)(state >> 8U) / 8388608.0) - 1.0;
}

static void report(const double x_n, const double z_n)
{
    const double force[2] = {x_n, z_n};
    control_planar_torque(robot.jacobian, force, robot.external_torque);
}

/// Displayed force at the tip for a position of the hand.
static void feel(const double first_rad, const double second_rad, double out_n[2])
{
    const double position[2] = {first_rad, second_rad};
    double felt[2];
    joystick_remote_contact_feel(&gains, &robot, position, felt);
    control_planar_force(robot.jacobian, felt, out_n);
}

static void a_hand_at_rest_feels_the_reported_force(void)
{
    double force[2];
    report(4.0, 15.0);
    feel(0.05, -0.02, force);
    EXPECT_WITHIN(4.0, 1.0e-12, force[0]);
    EXPECT_WITHIN(15.0, 1.0e-12, force[1]);
}

/// If the hand moves the tip by 1 mm against the contact, it feels 7 N more at once.
static void a_moving_hand_feels_the_model(void)
{
    const double down[2] = {0.0, -0.5e-3}; // The robot moves by twice the distance.
    double angle[2];
    double force[2];
    control_planar_angles(robot.jacobian, down, angle);
    report(0.0, 15.0);
    feel(0.05 + angle[0], -0.02 + angle[1], force);
    EXPECT_WITHIN(22.0, 1.0e-9, force[1]);
    feel(0.05 - (3.0 * angle[0]), -0.02 - (3.0 * angle[1]), force); // 3 mm away the contact has ended.
    EXPECT_WITHIN(0.0, 1.0e-12, force[0]);
    EXPECT_WITHIN(0.0, 1.0e-12, force[1]);
}

/// If the stiffness of the model is correct, the hand feels the wall at its present position, whatever the
/// age of the report.
static void the_age_of_a_report_does_not_matter_if_the_stiffness_is_right(void)
{
    const double touch[2] = {0.06, -0.01};
    for (unsigned i = 0U; i < 200U; i++) {
        double force[2];
        double then[2];
        double now[2];
        double depth[2];
        for (unsigned axis = 0U; axis < 2U; axis++) {
            robot.echo[axis] = touch[axis] - (1.0e-3 * (2.0 + draw()));
            then[axis]       = 2.0 * (touch[axis] - robot.echo[axis]);
            now[axis]        = touch[axis] - (1.0e-3 * (2.0 + draw()));
            depth[axis]      = 2.0 * (touch[axis] - now[axis]);
        }
        double at_robot[2];
        double at_hand[2];
        gains.tangential = 100.0; // This test does not need the bounds.
        control_planar_move(robot.jacobian, then, at_robot);
        control_planar_move(robot.jacobian, depth, at_hand);
        report(7000.0 * at_robot[0], 7000.0 * at_robot[1]);
        feel(now[0], now[1], force);
        EXPECT_WITHIN(7000.0 * at_hand[0], 1.0e-9, force[0]);
        EXPECT_WITHIN(7000.0 * at_hand[1], 1.0e-9, force[1]);
    }
}

static void a_contact_does_not_pull_and_its_friction_is_bounded(void)
{
    const double direction = 0.3;
    robot.normal[0]        = -sin(direction);
    robot.normal[1]        = cos(direction);
    unsigned bounded       = 0U;
    unsigned left          = 0U;
    for (unsigned i = 0U; i < 5000U; i++) {
        double force[2];
        report(20.0 * draw(), 20.0 * draw());
        feel(0.05 + (5.0e-3 * draw()), -0.02 + (5.0e-3 * draw()), force);
        const double along  = (force[0] * robot.normal[0]) + (force[1] * robot.normal[1]);
        const double across = fabs((force[1] * robot.normal[0]) - (force[0] * robot.normal[1]));
        TEST_ASSERT_TRUE(along >= -1.0e-9);
        TEST_ASSERT_TRUE(across <= ((0.5 * along) + 1.0e-9));
        bounded += (across > ((0.5 * along) - 1.0e-9)) ? 1U : 0U;
        left += (along < 1.0e-9) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE((bounded > left) && (left > 100U));
}

/// In free space, the reported force is only the error of the estimate.
static void the_displayed_force_fades_in_with_the_measured_one(void)
{
    double force[2];
    report(1.0, 10.0);
    for (unsigned i = 0U; i <= 10U; i++) {
        robot.push         = 0.5 * (double)i;
        const double share = fmin(fmax((robot.push - 1.0) / 3.0, 0.0), 1.0);
        feel(0.05, -0.02, force);
        EXPECT_WITHIN(share * 1.0, 1.0e-12, force[0]);
        EXPECT_WITHIN(share * 10.0, 1.0e-12, force[1]);
    }
}

static void for_a_stretched_robot_the_contact_model_is_not_used(void)
{
    const double stretched[4] = {0.0, 0.0, 0.47, 0.25};
    const double position[2]  = {0.2, 0.1};
    double felt[2];
    for (unsigned i = 0U; i < 4U; i++) {
        robot.jacobian[i] = stretched[i];
    }
    robot.external_torque[0] = 3.0;
    robot.external_torque[1] = -2.0;
    joystick_remote_contact_feel(&gains, &robot, position, felt);
    TEST_ASSERT_TRUE((felt[0] == 3.0) && (felt[1] == -2.0));
}

static double damp(const double taken_j, const double first_rad_s, const double second_rad_s)
{
    const double velocity[2] = {first_rad_s, second_rad_s};
    return joystick_remote_contact_damp(&contact, &gains, PERIOD_S, taken_j, velocity);
}

static void a_port_that_gave_no_energy_away_is_not_damped(void)
{
    TEST_ASSERT_TRUE(damp(0.0, 0.3, 0.4) == 0.0);
    TEST_ASSERT_TRUE(damp(1.5e-3, 0.3, 0.4) == 0.0);
    TEST_ASSERT_TRUE(damp(0.0, 0.3, 0.4) == 0.0); // The port gives back only energy that it has received.
    control_reserve_take_sum(&contact.reserve, 1.0);
    control_reserve_take_sum(&contact.reserve, 1.0 + 1.0e-3); // The environment has added energy.
    TEST_ASSERT_TRUE(damp(-0.9e-3, 0.3, 0.4) == 0.0);
}

/// The damping removes the debt within one cycle, but it is limited, and it needs motion of the hand.
static void a_debt_of_energy_is_removed_by_damping(void)
{
    const double alpha = damp(-1.0e-5, 0.3, 0.4);
    EXPECT_WITHIN(1.0e-5, 1.0e-18, alpha * 0.25 * PERIOD_S);
    TEST_ASSERT_TRUE(damp(-1.0e-5 + (alpha * 0.25 * PERIOD_S), 0.3, 0.4) < 1.0e-9);
    TEST_ASSERT_TRUE(damp(-1.0, 0.3, 0.4) == 0.8);
    TEST_ASSERT_TRUE(damp(-1.0, 0.0, 0.0) == 0.0);
}

static void an_old_reserve_is_limited_to_its_cap(void)
{
    TEST_ASSERT_TRUE(damp(10.0, 0.3, 0.4) == 0.0);
    TEST_ASSERT_TRUE(damp(10.0 - 1.9e-3, 0.3, 0.4) == 0.0);
    EXPECT_ABOVE(0.0, damp(10.0 - 2.1e-3, 0.3, 0.4));
    joystick_remote_contact_reset(&contact);
    TEST_ASSERT_TRUE(damp(0.0, 0.3, 0.4) == 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_hand_at_rest_feels_the_reported_force);
    RUN_TEST(a_moving_hand_feels_the_model);
    RUN_TEST(the_age_of_a_report_does_not_matter_if_the_stiffness_is_right);
    RUN_TEST(a_contact_does_not_pull_and_its_friction_is_bounded);
    RUN_TEST(the_displayed_force_fades_in_with_the_measured_one);
    RUN_TEST(for_a_stretched_robot_the_contact_model_is_not_used);
    RUN_TEST(a_port_that_gave_no_energy_away_is_not_damped);
    RUN_TEST(a_debt_of_energy_is_removed_by_damping);
    RUN_TEST(an_old_reserve_is_limited_to_its_cap);
    return UNITY_END();
}
