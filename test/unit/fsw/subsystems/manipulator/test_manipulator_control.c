// SPDX-License-Identifier: Apache-2.0
// Observer, tare and joint control on a simulated arm.
#include "fsw/subsystems/manipulator/manipulator_control.h"
#include "fsw/subsystems/manipulator/manipulator_tare.h"
#include "test/support/bounds.h"

#include "test/unit/fsw/subsystems/manipulator/rigid_arm.h"
#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005
#define HALF_TURN 3.14159265358979

static rigid_arm_t arm;
static manipulator_arm_control_t control;
static manipulator_control_t gains;
static manipulator_model_t model;
static manipulator_arm_setup_t setup;
static const double home[2] = {1.0471975511966, -1.5707963267949};

void setUp(void)
{
    gains = rigid_arm_gains;
    model = rigid_arm_model;
    setup = (manipulator_arm_setup_t){.gains = &gains, .model = &model, .period_s = PERIOD_S};
    rigid_arm_init(&arm, &rigid_arm_model, home);
    manipulator_arm_control_init(&control);
}

void tearDown(void)
{
}

static void sense(void)
{
    double torque[2];
    rigid_arm_sensors(&arm, torque);
    manipulator_arm_control_sense(&control, &setup, arm.motor, torque);
}

/// Follow the hand for one period, with the torque loop closed.
static void follow(const double* const hand)
{
    sense();
    const manipulator_arm_motion_t desired = manipulator_arm_control_follow(&control, &setup, hand);
    manipulator_arm_control_step(&control, &setup, &desired);
    rigid_arm_run(&arm, control.command_nm);
}

static void hold(const double* const hand)
{
    sense();
    manipulator_arm_control_hold(&control, &setup, hand);
    arm.is_braked = true;
    rigid_arm_run(&arm, control.command_nm);
    arm.is_braked = false;
}

// ---- Observer ----

static void no_torque_is_displayed_in_free_motion(void)
{
    double hand[2] = {0.0, 0.0};
    double worst   = 0.0;
    hold(hand);
    for (unsigned i = 0U; i < 12000U; i++) {
        const double t = PERIOD_S * (double)i;
        hand[0]        = 0.05 * sin(HALF_TURN * t) * fmin(1.0, t);
        hand[1]        = 0.05 * (1.0 - cos(HALF_TURN * t));
        follow(hand);
        worst =
            fmax(worst, fmax(fabs(control.observer.external_nm[0]), fabs(control.observer.external_nm[1])));
    }
    EXPECT_BELOW(0.1, worst);
}

static void an_external_torque_is_displayed_unchanged(void)
{
    const double hand[2] = {0.0, 0.0};
    hold(hand);
    arm.external_nm[0] = -8.0;
    arm.external_nm[1] = 3.0;
    double rise_s      = 0.0;
    for (unsigned i = 0U; i < 4000U; i++) {
        follow(hand);
        if ((rise_s == 0.0) && (control.observer.external_nm[1] > (3.0 * 0.9))) {
            rise_s = PERIOD_S * (double)i;
        }
    }
    EXPECT_WITHIN(-8.0, 0.001, control.observer.external_nm[0]);
    EXPECT_WITHIN(3.0, 0.001, control.observer.external_nm[1]);
    EXPECT_BELOW(0.02, rise_s);
}

static void the_zero_removes_an_offset_of_the_sensor(void)
{
    const double hand[2] = {0.0, 0.0};
    double torque[2];
    control.zero_nm[0] = 0.2;
    control.zero_nm[1] = -0.1;
    for (unsigned i = 0U; i < 2000U; i++) {
        rigid_arm_sensors(&arm, torque);
        torque[0] += 0.2;
        torque[1] -= 0.1;
        manipulator_arm_control_sense(&control, &setup, arm.motor, torque);
        manipulator_arm_control_hold(&control, &setup, hand);
    }
    EXPECT_WITHIN(0.0, 0.001,
                  control.observer.external_nm[0]); // The offset also bends the link angle a little.
    EXPECT_WITHIN(0.0, 0.001, control.observer.external_nm[1]);
    EXPECT_WITHIN(0.0, 0.01, control.bias_nm[0]);
}

// ---- Tare ----

static void a_tare_is_the_mean_at_rest(void)
{
    manipulator_arm_tare_t tare;
    manipulator_arm_tare_init(&tare);
    const manipulator_arm_tare_sample_t high = {{0.3, -0.1}, {0.0, 0.0}};
    const manipulator_arm_tare_sample_t low  = {{0.1, -0.3}, {0.0, 0.0}};
    TEST_ASSERT_EQUAL(STATUS_EMPTY, manipulator_arm_tare_step(&tare, &high, 4U, 1.0));
    manipulator_arm_tare_begin(&tare);
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &high, 4U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &low, 4U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &high, 4U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &low, 4U, 1.0));
    EXPECT_WITHIN(0.2, 1.0e-15, tare.offset_nm[0]);
    EXPECT_WITHIN(-0.2, 1.0e-15, tare.offset_nm[1]);
    // After its end the tare takes no more samples.
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &high, 4U, 1.0));
}

static void motion_restarts_a_tare(void)
{
    manipulator_arm_tare_t tare;
    manipulator_arm_tare_init(&tare);
    manipulator_arm_tare_begin(&tare);
    const manipulator_arm_tare_sample_t rest   = {{0.1, 0.1}, {0.001, -0.001}};
    const manipulator_arm_tare_sample_t motion = {{9.0, 9.0}, {0.0, -0.05}};
    for (unsigned i = 0U; i < 3U; i++) {
        (void)manipulator_arm_tare_step(&tare, &rest, 4U, 1.0);
    }
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &motion, 4U, 1.0));
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &rest, 4U, 1.0));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &rest, 4U, 1.0));
    EXPECT_WITHIN(0.1, 1.0e-15, tare.offset_nm[0]);
}

static void a_contact_force_is_not_taken_for_a_sensor_offset(void)
{
    manipulator_arm_tare_t tare;
    manipulator_arm_tare_init(&tare);
    manipulator_arm_tare_begin(&tare);
    const manipulator_arm_tare_sample_t free_arm = {{0.2, 0.1}, {0.0, 0.0}};
    const manipulator_arm_tare_sample_t contact  = {{0.2, -1.1}, {0.0, 0.0}};
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &free_arm, 1U, 1.0));
    manipulator_arm_tare_begin(&tare);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, manipulator_arm_tare_step(&tare, &contact, 1U, 1.0));
    EXPECT_WITHIN(0.2, 1.0e-15, tare.offset_nm[0]); // The old zero is kept.
    const manipulator_arm_tare_sample_t broken = {{(double)NAN, 0.0}, {0.0, 0.0}};
    manipulator_arm_tare_begin(&tare);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, manipulator_arm_tare_step(&tare, &broken, 1U, 1.0));
}

// ---- Control ----

/// Engage the arm. Returns the largest motion of the links and the largest step of the command after that.
static void engage(const double* const hand, double* const out_motion, double* const out_step)
{
    for (unsigned i = 0U; i < 1000U; i++) {
        hold(hand);
    }
    const double pose[2] = {arm.link[0], arm.link[1]};
    double before[2]     = {control.command_nm[0], control.command_nm[1]};
    *out_motion          = 0.0;
    *out_step            = 0.0;
    for (unsigned i = 0U; i < 2000U; i++) {
        follow(hand);
        for (unsigned k = 0U; k < 2U; k++) {
            *out_motion = fmax(*out_motion, fabs(arm.link[k] - pose[k]));
            *out_step   = fmax(*out_step, fabs(control.command_nm[k] - before[k]));
            before[k]   = control.command_nm[k];
        }
    }
}

static void engaging_is_without_a_step_wherever_hand_and_arm_are(void)
{
    const double hands[3][2] = {{0.0, 0.0}, {0.3, -0.2}, {-0.35, 0.35}};
    const double poses[3][2] = {{1.0471975511966, -1.5707963267949}, {0.4, -1.0}, {1.6, -2.2}};
    for (unsigned i = 0U; i < 9U; i++) {
        double motion = 0.0;
        double step   = 0.0;
        rigid_arm_init(&arm, &rigid_arm_model, poses[i % 3U]);
        manipulator_arm_control_init(&control);
        engage(hands[i / 3U], &motion, &step);
        EXPECT_BELOW(0.0001, motion);
        EXPECT_BELOW(0.05, step);
    }
}

static void engaging_under_load_lets_the_arm_settle_slowly(void)
{
    const double hand[2] = {0.1, 0.1};
    double motion        = 0.0;
    double step          = 0.0;
    arm.external_nm[0]   = -11.0; // The spring pulls.
    arm.external_nm[1]   = -8.0;
    engage(hand, &motion, &step);
    EXPECT_BELOW(0.1, step); // The torque has no step.
    // The arm moves only by the elastic deflection of control loop and gear.
    EXPECT_BELOW((11.0 / 4000.0) + (11.0 / 8000.0) + 0.0003, motion);
}

static void the_motor_target_begins_where_the_motor_is(void)
{
    hold(NULL);
    for (unsigned i = 0U; i < 2U; i++) {
        EXPECT_WITHIN(arm.motor[i], 1.0e-12, control.motor_target_rad[i]);
    }
    const double motor[2] = {arm.motor[0], arm.motor[1]};
    follow(NULL);
    for (unsigned i = 0U; i < 2U; i++) {
        EXPECT_WITHIN(motor[i], 1.0e-6, control.motor_target_rad[i]);
    }
}

static void the_arm_follows_the_hand(void)
{
    double hand[2]  = {0.1, -0.05};
    double squares  = 0.0;
    double wanted   = 0.0;
    const double at = hand[0];
    hold(hand);
    for (unsigned i = 0U; i < 12000U; i++) {
        const double t = PERIOD_S * (double)i;
        hand[0]        = at + (0.08 * sin(HALF_TURN * t) * fmin(1.0, 0.5 * t));
        follow(hand);
        if (i > 4000U) {
            const double error = arm.link[0] - (home[0] + (2.0 * (hand[0] - at)));
            squares += error * error;
            wanted += 4.0 * (hand[0] - at) * (hand[0] - at);
        }
    }
    EXPECT_BELOW(0.01, sqrt(squares / wanted));
}

static void a_hand_beyond_the_range_moves_the_goal_at_the_speed_limit_to_the_end_of_the_range(void)
{
    double hand[2] = {0.0, 0.0};
    double before  = home[0];
    hold(hand);
    hand[0] = 5.0; // The hand jumps by 5 rad, which the position scale doubles.
    for (unsigned i = 0U; i < 8000U; i++) {
        follow(hand);
        EXPECT_BELOW((gains.speed_limit * PERIOD_S) + 1.0e-12, fabs(control.goal_rad[0] - before));
        EXPECT_BELOW(gains.home[0] + gains.range[0] + 1.0e-12, control.goal_rad[0]);
        before = control.goal_rad[0];
    }
    EXPECT_WITHIN(gains.home[0] + gains.range[0], 1.0e-9, control.goal_rad[0]);
    EXPECT_WITHIN(gains.home[0] + gains.range[0], 0.01, arm.link[0]);
}

static void a_hand_position_that_is_not_a_number_is_ignored(void)
{
    double hand[2] = {0.0, 0.0};
    hold(hand);
    hand[0] = (double)NAN;
    hand[1] = (double)NAN;
    for (unsigned i = 0U; i < 2000U; i++) {
        follow(hand);
    }
    EXPECT_WITHIN(home[0], 0.0001, arm.link[0]);
    EXPECT_WITHIN(home[1], 0.0001, arm.link[1]);
}

static void the_torque_is_limited_by_its_ceiling(void)
{
    const double hand[2]    = {0.0, 0.0};
    gains.torque_ceiling[0] = 7.0;
    hold(hand);
    arm.external_nm[0] = -30.0;
    unsigned limited   = 0U;
    for (unsigned i = 0U; i < 1000U; i++) {
        follow(hand);
        TEST_ASSERT_TRUE(fabs(control.command_nm[0]) <= 7.0);
        for (unsigned k = 0U; k < 2U; k++) {
            limited += (fabs(control.command_nm[k]) == gains.torque_ceiling[k]) ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL_UINT(limited, control.limited);
    }
    TEST_ASSERT_TRUE(limited > 100U);
}

/// Follow the hand for one period. Returns how far the first joint yields.
static double yielded(void)
{
    const double hand[2] = {0.0, 0.0};
    sense();
    const manipulator_arm_motion_t desired = manipulator_arm_control_follow(&control, &setup, hand);
    manipulator_arm_control_step(&control, &setup, &desired);
    rigid_arm_run(&arm, control.command_nm);
    return desired.position_rad[0] - control.reference[0].position;
}

static void a_following_arm_yields_to_fast_torques_and_stays_stiff(void)
{
    const double hand[2] = {0.0, 0.0};
    double peak          = 0.0;
    hold(hand);
    for (unsigned i = 0U; i < 4000U; i++) {
        (void)yielded();
    }
    arm.external_nm[0] = -5.0;
    for (unsigned i = 0U; i < 4000U; i++) {
        peak = fmin(peak, yielded());
    }
    // After a step the estimate (400 rad/s) exceeds its slow part (50 rad/s) by at most 0.74 of the step.
    EXPECT_BELOW(-0.7 * 0.001 * 5.0, peak);
    EXPECT_ABOVE(-0.001 * 5.0, peak);
    EXPECT_WITHIN(0.0, 1.0e-6, yielded());
}

static void an_arm_just_engaged_does_not_yield(void)
{
    const double hand[2] = {0.0, 0.0};
    double peak          = 0.0;
    hold(hand);
    arm.external_nm[0] = -5.0;
    for (unsigned i = 0U; i < 20U; i++) { // 10 ms of a fade time of 250 ms.
        peak = fmin(peak, yielded());
    }
    EXPECT_ABOVE(-0.04 * 0.001 * 5.0, peak);
    hold(hand); // The torque that the arm carries when it is engaged does not count as a change.
    EXPECT_WITHIN(0.0, 1.0e-12, control.slow_nm[0] - control.observer.external_nm[0]);
}

static void without_a_hand_the_arm_is_held(void)
{
    double hand[2] = {0.0, 0.0};
    hold(hand);
    for (unsigned i = 0U; i < 2000U; i++) {
        hand[0] = 0.00002 * (double)i;
        follow(hand);
    }
    const double held = control.goal_rad[0];
    for (unsigned i = 0U; i < 4000U; i++) {
        follow(NULL);
    }
    EXPECT_WITHIN(held, 0.0005, arm.link[0]);
    EXPECT_WITHIN(0.0, 1.0e-4, arm.link_speed[0]);
    for (unsigned i = 0U; i < 400U; i++) { // The hand continues from its last position.
        follow(hand);
    }
    EXPECT_WITHIN(held, 0.001, arm.link[0]);
}

static void a_joystick_that_connects_late_takes_over_at_the_position_of_the_arm(void)
{
    const double hand[2] = {0.3, 0.3};
    hold(NULL);
    for (unsigned i = 0U; i < 100U; i++) {
        follow(NULL);
    }
    for (unsigned i = 0U; i < 1000U; i++) {
        follow(hand);
    }
    EXPECT_WITHIN(home[0], 0.0005, arm.link[0]);
    EXPECT_WITHIN(home[1], 0.0005, arm.link[1]);
    const double moved[2] = {hand[0] + 0.05, hand[1] - 0.05}; // From then on the arm follows the hand.
    for (unsigned i = 0U; i < 4000U; i++) {
        follow(moved);
    }
    EXPECT_WITHIN(home[0] + (0.05 * gains.position_scale), 0.0005, arm.link[0]);
    EXPECT_WITHIN(home[1] - (0.05 * gains.position_scale), 0.0005, arm.link[1]);
}

// ---- The law of manipulator_control.h ----

static void the_command_has_every_term_of_the_law(void)
{
    const manipulator_arm_motion_t desired = {{0.4, -0.9}, {0.3, -0.015}, {2.0, -3.0}};
    double inertial[2];
    double coriolis[2];
    model.coulomb[0]        = 2.0;
    model.coulomb[1]        = 3.0;
    model.viscous[1]        = 0.5;
    model.rotor_inertia[1]  = 0.125;
    model.stiffness[1]      = 4000.0;
    gains.kd[1]             = 50.0;
    gains.torque_ceiling[0] = 1.0e6;
    gains.torque_ceiling[1] = 1.0e6;
    sense();
    for (unsigned i = 0U; i < 2U; i++) {
        control.motor_rad[i]      = 0.2 * (double)(i + 1U);
        control.motor[i].velocity = 0.1 - (0.3 * (double)i);
        control.offset_rad[i]     = 0.01 - (0.03 * (double)i);
        control.bias_nm[i]        = 1.5 - (4.0 * (double)i);
    }
    manipulator_arm_control_step(&control, &setup, &desired);
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&model, desired.position_rad);
    manipulator_arm_inertia_times(&terms, desired.acceleration_rad_s2, inertial);
    manipulator_arm_coriolis(&terms, desired.velocity_rad_s, coriolis);
    for (unsigned i = 0U; i < 2U; i++) {
        const double kept     = 1.0 - (PERIOD_S / 0.25); // Share of offset and bias that is kept.
        const double speed    = desired.velocity_rad_s[i];
        const double rigid    = inertial[i] + coriolis[i] + terms.gravity_nm[i];
        const double friction = (0.8 * model.coulomb[i] * tanh(speed / 0.02)) + (model.viscous[i] * speed);
        const double target =
            desired.position_rad[i] + (rigid / model.stiffness[i]) + (kept * (0.01 - (0.03 * (double)i)));
        const double forward = rigid + (model.rotor_inertia[i] * desired.acceleration_rad_s2[i]) + friction +
                               (kept * (1.5 - (4.0 * (double)i)));
        EXPECT_WITHIN(target, 1.0e-9, control.motor_target_rad[i]);
        EXPECT_WITHIN(forward, 1.0e-6, control.feed_forward_nm[i]);
        EXPECT_WITHIN(forward + (gains.kp[i] * (target - (0.2 * (double)(i + 1U)))) +
                          (gains.kd[i] * (speed - (0.1 - (0.3 * (double)i)))),
                      1.0e-5, control.command_nm[i]);
    }
    gains.fade_time = 0.5 * PERIOD_S; // A fade time below one period ends at once and does not overshoot.
    manipulator_arm_control_step(&control, &setup, &desired);
    EXPECT_WITHIN(0.0, 0.0, control.offset_rad[0]);
    EXPECT_WITHIN(0.0, 0.0, control.bias_nm[1]);
}

/// 0.02 rad/s counts as rest, a torque equal to the ceiling as free of contact, and a tare uses no samples
/// from before its beginning.
static void each_tare_has_its_own_samples_and_exact_bounds(void)
{
    manipulator_arm_tare_t tare;
    manipulator_arm_tare_init(&tare);
    manipulator_arm_tare_begin(&tare);
    const manipulator_arm_tare_sample_t before  = {{0.5, -0.5}, {0.0, 0.0}};
    const manipulator_arm_tare_sample_t motion  = {{0.5, -0.5}, {0.0201, 0.0}};
    const manipulator_arm_tare_sample_t ceiling = {{1.0, -1.0}, {0.02, -0.02}};
    const manipulator_arm_tare_sample_t after   = {{0.25, -0.125}, {0.0, 0.0}};
    (void)manipulator_arm_tare_step(&tare, &before, 2U, 1.0);
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &motion, 2U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &ceiling, 2U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &ceiling, 2U, 1.0));
    EXPECT_WITHIN(1.0, 0.0, tare.offset_nm[0]);
    EXPECT_WITHIN(-1.0, 0.0, tare.offset_nm[1]);
    manipulator_arm_tare_begin(&tare);
    TEST_ASSERT_EQUAL(STATUS_BUSY, manipulator_arm_tare_step(&tare, &after, 2U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_OK, manipulator_arm_tare_step(&tare, &after, 2U, 1.0));
    EXPECT_WITHIN(0.25, 0.0, tare.offset_nm[0]);
    EXPECT_WITHIN(-0.125, 0.0, tare.offset_nm[1]);
}

/// While the arm is held, it takes each position of the hand as zero: afterwards it follows only changes.
static void holding_couples_the_hand_where_it_is(void)
{
    const double first[2]  = {0.4, -0.2};
    const double second[2] = {-0.3, 0.1};
    hold(first);
    TEST_ASSERT_TRUE(control.is_coupled);
    hold(second);
    for (unsigned i = 0U; i < 500U; i++) {
        follow(second);
    }
    EXPECT_WITHIN(home[0], 0.001, control.goal_rad[0]);
    EXPECT_WITHIN(home[1], 0.001, control.goal_rad[1]);
    hold(NULL);
    TEST_ASSERT_FALSE(control.is_coupled);
    follow(NULL);
    TEST_ASSERT_FALSE(control.is_coupled);
    follow(first);
    TEST_ASSERT_TRUE(control.is_coupled);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_torque_is_displayed_in_free_motion);
    RUN_TEST(an_external_torque_is_displayed_unchanged);
    RUN_TEST(the_zero_removes_an_offset_of_the_sensor);
    RUN_TEST(a_tare_is_the_mean_at_rest);
    RUN_TEST(motion_restarts_a_tare);
    RUN_TEST(a_contact_force_is_not_taken_for_a_sensor_offset);
    RUN_TEST(engaging_is_without_a_step_wherever_hand_and_arm_are);
    RUN_TEST(engaging_under_load_lets_the_arm_settle_slowly);
    RUN_TEST(the_motor_target_begins_where_the_motor_is);
    RUN_TEST(the_arm_follows_the_hand);
    RUN_TEST(a_hand_beyond_the_range_moves_the_goal_at_the_speed_limit_to_the_end_of_the_range);
    RUN_TEST(a_hand_position_that_is_not_a_number_is_ignored);
    RUN_TEST(the_torque_is_limited_by_its_ceiling);
    RUN_TEST(a_following_arm_yields_to_fast_torques_and_stays_stiff);
    RUN_TEST(an_arm_just_engaged_does_not_yield);
    RUN_TEST(without_a_hand_the_arm_is_held);
    RUN_TEST(a_joystick_that_connects_late_takes_over_at_the_position_of_the_arm);
    RUN_TEST(the_command_has_every_term_of_the_law);
    RUN_TEST(each_tare_has_its_own_samples_and_exact_bounds);
    RUN_TEST(holding_couples_the_hand_where_it_is);
    return UNITY_END();
}
