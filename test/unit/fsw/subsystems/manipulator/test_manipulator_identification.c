// SPDX-License-Identifier: Apache-2.0
// Masses and sensor offsets from motion in free space, on a simulated arm.
#include "fsw/subsystems/manipulator/manipulator_control.h"
#include "fsw/subsystems/manipulator/manipulator_identification.h"
#include "test/support/bounds.h"

#include "test/unit/fsw/subsystems/manipulator/rigid_arm.h"
#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005
#define HALF_TURN 3.14159265358979

static const double home[2]       = {1.0471975511966, -1.5707963267949};
static const double offset_nm[2]  = {0.15, -0.1};
static const double gravity_m_s2  = 9.81;
static const double true_share[2] = {1.05, 0.96};

static rigid_arm_t arm;
static manipulator_arm_control_t control;
static manipulator_arm_identification_t identification;
static manipulator_identification_t assumed;
static manipulator_model_t model;   // The model of the parameters.
static manipulator_model_t applied; // The model that control uses: with the identified masses.
static manipulator_arm_setup_t setup;
static manipulator_arm_observer_gains_t gains;
static unsigned learned;
static double radius_rad; // Radius of the joystick's circle.
static double noise_nm;   // Amplitude of the uniform noise of the torque sensors.
static uint32_t chance;

void setUp(void)
{
    manipulator_model_t real = rigid_arm_model;
    for (unsigned i = 0U; i < 2U; i++) {
        real.link_mass[i] *= true_share[i];
        real.link_inertia[i] *= true_share[i];
    }
    model   = rigid_arm_model;
    applied = model;
    assumed = (manipulator_identification_t){.mass_share = 0.05, .offset = 0.2, .noise = 0.1, .ceiling = 0.5};
    setup   = (manipulator_arm_setup_t){.gains = &rigid_arm_gains, .model = &applied, .period_s = PERIOD_S};
    gains   = manipulator_arm_observer_gains(&rigid_arm_gains, PERIOD_S);
    rigid_arm_init(&arm, &real, home);
    manipulator_arm_control_init(&control);
    manipulator_arm_identification_init(&identification, &assumed, &model);
    learned    = 0U;
    radius_rad = 0.095;
    noise_nm   = 0.0;
    chance     = 1U;
}

void tearDown(void)
{
}

static void apply(void)
{
    applied = manipulator_arm_identified(&identification, &model);
    for (unsigned i = 0U; i < 2U; i++) {
        control.zero_nm[i] = identification.now.unknown[2U + i];
    }
}

static void sense(void)
{
    double torque[2];
    rigid_arm_sensors(&arm, torque);
    for (unsigned i = 0U; i < 2U; i++) {
        chance = (chance * 1664525U) + 1013904223U;
        torque[i] += offset_nm[i] + (noise_nm * (((double)chance / 2147483648.0) - 1.0));
    }
    manipulator_arm_control_sense(&control, &setup, arm.motor, torque);
    const double velocity[2] = {control.observer.link[0].velocity, control.observer.link[1].velocity};
    manipulator_arm_identification_step(&identification, &model, &gains, control.link_rad, velocity, torque);
}

/// Let the arm rest on its brakes, then tare it.
static void tare(void)
{
    const double hand[2] = {0.0, 0.0};
    arm.is_braked        = true;
    for (unsigned i = 0U; i < 1000U; i++) {
        sense();
        manipulator_arm_control_hold(&control, &setup, hand);
        rigid_arm_run(&arm, control.command_nm);
    }
    arm.is_braked                       = false;
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&applied, control.link_rad);
    const double mean[2]                = {control.torque_nm[0] - terms.gravity_nm[0],
                                           control.torque_nm[1] - terms.gravity_nm[1]};
    manipulator_arm_identification_tare(&identification, &assumed, &applied, mean);
    apply();
}

/// Follow the circle of the mission in free space, or with an external torque.
static void circle(const double seconds, const double push_nm)
{
    const unsigned cycles = (unsigned)(seconds / PERIOD_S);
    for (unsigned i = 0U; i < cycles; i++) {
        const double t       = PERIOD_S * (double)i;
        const double radius  = radius_rad * fmin(1.0, 0.5 * t);
        const double hand[2] = {radius * sin(HALF_TURN * t), radius * cos(HALF_TURN * t)};
        arm.external_nm[0]   = push_nm;
        sense();
        const manipulator_arm_motion_t desired = manipulator_arm_control_follow(&control, &setup, hand);
        manipulator_arm_control_step(&control, &setup, &desired);
        rigid_arm_run(&arm, control.command_nm);
        if (manipulator_arm_identification_learn(&identification, &assumed, &model)) {
            learned++;
            apply();
        }
    }
}

static double gravity_error_nm(const unsigned joint, const double pose[2])
{
    const manipulator_arm_terms_t believed = manipulator_arm_terms(&applied, pose);
    const manipulator_arm_terms_t real     = manipulator_arm_terms(&arm.model, pose);
    return (believed.gravity_nm[joint] + control.zero_nm[joint]) -
           (real.gravity_nm[joint] + offset_nm[joint]);
}

static void after_a_tare_no_torque_is_measured_in_the_pose_of_the_tare(void)
{
    tare();
    for (unsigned i = 0U; i < 400U; i++) {
        sense();
    }
    EXPECT_WITHIN(0.0, 0.01, control.observer.external_nm[0]);
    EXPECT_WITHIN(0.0, 0.01, control.observer.external_nm[1]);
}

static void a_circle_in_free_space_finds_the_masses(void)
{
    // In the pose of the contact the model alone has an error of -0.07 Nm in the first joint, 0.17 Nm in the
    // second.
    const double contact[2] = {0.35, -1.15};
    EXPECT_WITHIN(-0.07, 0.01, gravity_error_nm(0U, contact));
    EXPECT_WITHIN(0.17, 0.01, gravity_error_nm(1U, contact));
    tare();
    circle(12.0, 0.0);
    EXPECT_WITHIN(3.0 * true_share[0], 0.06, identification.now.unknown[0]);
    EXPECT_WITHIN(2.0 * true_share[1], 0.03, identification.now.unknown[1]);
    EXPECT_WITHIN(offset_nm[0], 0.15, identification.now.unknown[2]);
    EXPECT_WITHIN(offset_nm[1], 0.05, identification.now.unknown[3]);
    // The result must also be correct in this pose, which is not that of the tare.
    EXPECT_WITHIN(0.0, 0.03, gravity_error_nm(0U, contact));
    EXPECT_WITHIN(0.0, 0.03, gravity_error_nm(1U, contact));
    TEST_ASSERT_TRUE(identification.updates > 2000U);
    EXPECT_WITHIN(model.link_inertia[0] * identification.now.unknown[0] / 3.0, 1.0e-12,
                  applied.link_inertia[0]);
    TEST_ASSERT_TRUE(identification.now.covariance[0][0] < (0.15 * 0.15 / 4.0));
    TEST_ASSERT_TRUE(applied.gravity == gravity_m_s2);
}

/// The angles of the links are computed from the measured torques. So the residual of the torque and those of
/// the unit masses contain the same noise and are correlated.
static void noise_at_rest_is_not_taken_for_mass(void)
{
    tare();
    const double before[2] = {identification.now.unknown[0], identification.now.unknown[1]};
    radius_rad             = 0.0;
    noise_nm               = 0.06;
    circle(5.0, 0.0);
    TEST_ASSERT_TRUE(learned > 900U);
    EXPECT_WITHIN(before[0], 0.01, identification.now.unknown[0]);
    EXPECT_WITHIN(before[1], 0.01, identification.now.unknown[1]);
}

/// The torque of the contact is still in the residuals.
static void nothing_is_learned_in_the_half_second_after_a_contact(void)
{
    tare();
    circle(0.5, -3.0);
    const unsigned updates = learned;
    const double before[2] = {identification.now.unknown[0], identification.now.unknown[1]};
    circle(0.5, 0.0);
    TEST_ASSERT_EQUAL_UINT(updates, learned);
    TEST_ASSERT_TRUE((identification.now.unknown[0] == before[0]) &&
                     (identification.now.unknown[1] == before[1]));
    circle(0.5, 0.0);
    TEST_ASSERT_TRUE(learned > updates);
}

static void a_contact_is_not_taken_for_mass(void)
{
    tare();
    const double before[2] = {identification.now.unknown[0], identification.now.unknown[1]};
    circle(1.0, -3.0);
    TEST_ASSERT_TRUE(learned <= 2U); // One while the residuals rise, one that removes its samples.
    TEST_ASSERT_TRUE((identification.now.unknown[0] == before[0]) &&
                     (identification.now.unknown[1] == before[1]));
}

/// Until its torque exceeds the ceiling, a contact looks like an additional mass.
static void samples_from_the_beginning_of_a_contact_are_removed(void)
{
    tare();
    circle(3.0, 0.0);
    const double before[2] = {identification.now.unknown[0], identification.now.unknown[1]};
    const unsigned updates = learned;
    circle(0.3, -0.3); // Below the ceiling of 0.5 Nm.
    TEST_ASSERT_TRUE(learned > (updates + 20U));
    TEST_ASSERT_TRUE(fabs(identification.now.unknown[0] - before[0]) > 0.005);
    circle(0.05, -3.0);
    EXPECT_WITHIN(before[0], 0.08, identification.now.unknown[0]);
    EXPECT_WITHIN(before[1], 0.04, identification.now.unknown[1]);
    TEST_ASSERT_TRUE(identification.now.unknown[0] == identification.kept[0].unknown[0]);
}

/// The estimate to which a contact returns is one to two seconds old.
static void what_was_learned_long_before_a_contact_is_kept(void)
{
    tare();
    const double tared_kg = identification.now.unknown[0];
    circle(3.0, 0.0);
    const double learned_kg = identification.now.unknown[0];
    circle(0.05, -3.0);
    TEST_ASSERT_TRUE(fabs(identification.now.unknown[0] - learned_kg) <
                     fabs(identification.now.unknown[0] - tared_kg));
}

static void masses_stay_within_four_standard_deviations(void)
{
    const double still[2] = {0.0, 0.0};
    const double wild[2]  = {100.0, -100.0};
    assumed.ceiling       = 1000.0;
    for (unsigned i = 0U; i < 200U; i++) {
        manipulator_arm_identification_step(&identification, &model, &gains, home, still, wild);
        (void)manipulator_arm_identification_learn(&identification, &assumed, &model);
    }
    TEST_ASSERT_EQUAL_UINT32(20U, identification.updates);
    EXPECT_WITHIN(3.0 * 1.2, 1.0e-12, identification.now.unknown[0]);
    EXPECT_WITHIN(2.0, (2.0 * 0.2) + 1.0e-12, identification.now.unknown[1]);
}

static void a_nan_torque_does_not_change_the_estimates(void)
{
    const double still[2]  = {0.0, 0.0};
    const double broken[2] = {(double)NAN, 0.0};
    manipulator_arm_identification_step(&identification, &model, &gains, home, still, broken);
    for (unsigned i = 0U; i < 20U; i++) {
        TEST_ASSERT_FALSE(manipulator_arm_identification_learn(&identification, &assumed, &model));
    }
    TEST_ASSERT_TRUE((identification.now.unknown[0] == 3.0) && (identification.now.unknown[1] == 2.0));
}

static void a_new_tare_discards_the_offsets_and_keeps_the_masses(void)
{
    tare();
    circle(12.0, 0.0);
    const double mass[2] = {identification.now.unknown[0], identification.now.unknown[1]};
    rigid_arm_init(&arm, &arm.model, home);
    manipulator_arm_control_init(&control);
    apply();
    tare();
    EXPECT_WITHIN(mass[0], 0.05, identification.now.unknown[0]);
    EXPECT_WITHIN(mass[1], 0.05, identification.now.unknown[1]);
    for (unsigned i = 0U; i < 2U; i++) {
        for (unsigned k = 0U; k < 4U; k++) { // A covariance is symmetrical.
            EXPECT_WITHIN(identification.now.covariance[i][k], 1.0e-12, identification.now.covariance[k][i]);
        }
    }
}

/// A tare sets the offsets; it also clears their correlations with the masses.
static void a_tare_removes_correlations_of_the_offsets(void)
{
    const double mean[2] = {0.1, -0.2};
    tare();
    circle(4.0, 0.0);
    manipulator_arm_identification_t other = identification;
    TEST_ASSERT_TRUE((other.now.covariance[2][0] != 0.0) && (other.now.covariance[3][0] != 0.0));
    for (unsigned i = 2U; i < ARM_UNKNOWNS; i++) {
        for (unsigned k = 0U; k < ARM_UNKNOWNS; k++) {
            other.now.covariance[i][k] = 0.0;
            other.now.covariance[k][i] = 0.0;
        }
    }
    manipulator_arm_identification_tare(&identification, &assumed, &model, mean);
    manipulator_arm_identification_tare(&other, &assumed, &model, mean);
    for (unsigned i = 0U; i < ARM_UNKNOWNS; i++) {
        EXPECT_WITHIN(other.now.unknown[i], 0.0, identification.now.unknown[i]);
        for (unsigned k = 0U; k < ARM_UNKNOWNS; k++) {
            EXPECT_WITHIN(other.now.covariance[i][k], 0.0, identification.now.covariance[i][k]);
        }
    }
}

/// With a ceiling of zero every torque counts as a contact, even a torque of zero.
static void a_ceiling_of_zero_keeps_the_model_unchanged(void)
{
    assumed.ceiling = 0.0;
    for (unsigned i = 0U; i < 1000U; i++) {
        TEST_ASSERT_FALSE(manipulator_arm_identification_learn(&identification, &assumed, &model));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, identification.updates);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_tare_removes_correlations_of_the_offsets);
    RUN_TEST(a_ceiling_of_zero_keeps_the_model_unchanged);
    RUN_TEST(after_a_tare_no_torque_is_measured_in_the_pose_of_the_tare);
    RUN_TEST(a_circle_in_free_space_finds_the_masses);
    RUN_TEST(noise_at_rest_is_not_taken_for_mass);
    RUN_TEST(nothing_is_learned_in_the_half_second_after_a_contact);
    RUN_TEST(a_contact_is_not_taken_for_mass);
    RUN_TEST(samples_from_the_beginning_of_a_contact_are_removed);
    RUN_TEST(what_was_learned_long_before_a_contact_is_kept);
    RUN_TEST(masses_stay_within_four_standard_deviations);
    RUN_TEST(a_nan_torque_does_not_change_the_estimates);
    RUN_TEST(a_new_tare_discards_the_offsets_and_keeps_the_masses);
    return UNITY_END();
}
