// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_inverse.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stdlib.h>

#define DIRECTIONS 6U

static const arm_inverse_t settings      = {.limit = 0.02, .damping = 0.02};
static const arm_inverse_t position_only = {.limit = 0.02, .damping = 0.02, .is_position_only = true};

void setUp(void)
{
    srand(3U);
}

void tearDown(void)
{
}

static double draw(void)
{
    return ((2.0 * (double)rand()) / (double)RAND_MAX) - 1.0;
}

static arm_twist_t draw_twist(void)
{
    return (arm_twist_t){.linear_m_s    = {{draw(), draw(), draw()}},
                         .angular_rad_s = {{draw(), draw(), draw()}}};
}

static void draw_jacobian(arm_jacobian_t* const jacobian, const unsigned joints)
{
    for (unsigned i = 0U; i < DIRECTIONS; i++) {
        for (unsigned k = 0U; k < joints; k++) {
            jacobian->at[i][k] = draw();
        }
    }
}

#define UNTOUCHED 77.0

/// Fill the rates with a mark, so that a test detects which of them were written.
static void fill(double rates[ARM_JOINTS_MAX])
{
    for (unsigned i = 0U; i < ARM_JOINTS_MAX; i++) {
        rates[i] = UNTOUCHED;
    }
}

static void expect_untouched_from(const unsigned first, const double rates[ARM_JOINTS_MAX])
{
    for (unsigned i = first; i < ARM_JOINTS_MAX; i++) {
        TEST_ASSERT_TRUE(rates[i] == UNTOUCHED);
    }
}

static double component(const arm_twist_t* const twist, const unsigned i)
{
    return (i < 3U) ? twist->linear_m_s.at[i] : twist->angular_rad_s.at[i - 3U];
}

/// Residual of one row.
static double residual(const arm_jacobian_t* const jacobian, const unsigned joints, const double* const rates,
                       const arm_twist_t* const twist, const unsigned row)
{
    double sum = -component(twist, row);
    for (unsigned k = 0U; k < joints; k++) {
        sum += jacobian->at[row][k] * rates[k];
    }
    return sum;
}

static void six_and_more_joints_produce_the_velocity_of_the_tool(void)
{
    for (unsigned joints = DIRECTIONS; joints <= ARM_JOINTS_MAX; joints++) {
        for (unsigned round = 0U; round < 50U; round++) {
            arm_jacobian_t jacobian;
            double rates[ARM_JOINTS_MAX];
            const arm_twist_t twist = draw_twist();
            draw_jacobian(&jacobian, joints);
            fill(rates);
            const double smallest = arm_inverse(&settings, &jacobian, joints, &twist, rates);
            expect_untouched_from(joints, rates);
            if (smallest < settings.limit) {
                continue; // Damping acts here.
            }
            for (unsigned row = 0U; row < DIRECTIONS; row++) {
                EXPECT_WITHIN(0.0, 1.0e-9, residual(&jacobian, joints, rates, &twist, row));
            }
        }
    }
}

/// The remaining error of velocity is perpendicular to every velocity that the joints can produce.
static void fewer_joints_minimise_the_residual(void)
{
    for (unsigned joints = 1U; joints < DIRECTIONS; joints++) {
        arm_jacobian_t jacobian;
        double rates[ARM_JOINTS_MAX];
        const arm_twist_t twist = draw_twist();
        draw_jacobian(&jacobian, joints);
        fill(rates);
        TEST_ASSERT_TRUE(arm_inverse(&settings, &jacobian, joints, &twist, rates) > settings.limit);
        expect_untouched_from(joints, rates);
        for (unsigned k = 0U; k < joints; k++) {
            double along = 0.0;
            for (unsigned row = 0U; row < DIRECTIONS; row++) {
                along += jacobian.at[row][k] * residual(&jacobian, joints, rates, &twist, row);
            }
            EXPECT_WITHIN(0.0, 1.0e-10, along);
        }
    }
}

/// A diagonal Jacobian with one small singular value s: without damping the rate is 1 / s. With a damping d
/// (1 - s / d) for s below d, the gain s / (s^2 + (d - s)^2) is largest at s = d / sqrt 2: 1.21 / d.
static void near_a_singular_pose_the_rates_stay_bounded(void)
{
    const arm_twist_t twist = {.linear_m_s = {{1.0, 0.5, 0.0}}, .angular_rad_s = {{0.0, 0.0, 0.0}}};
    for (double small = 0.1; small > 1.0e-9; small *= 0.5) {
        arm_jacobian_t jacobian = {{{0.0}}};
        double rates[ARM_JOINTS_MAX];
        for (unsigned i = 0U; i < DIRECTIONS; i++) {
            jacobian.at[i][i] = (i == 0U) ? small : 1.0;
        }
        const double smallest = arm_inverse(&settings, &jacobian, DIRECTIONS, &twist, rates);
        EXPECT_WITHIN(small, 1.0e-6, smallest);
        if (small >= settings.limit) {
            EXPECT_WITHIN(1.0 / small, 1.0e-9, rates[0]);
        } else {
            const double damping = settings.damping * (1.0 - (small / settings.limit));
            const double damped  = small / ((small * small) + (damping * damping));
            EXPECT_WITHIN(damped, 1.0e-3 * damped, rates[0]);
            TEST_ASSERT_TRUE(rates[0] <= (1.21 / settings.limit));
        }
        EXPECT_WITHIN(0.5, 1.0e-3, rates[1]); // The damping hardly changes the other directions.
    }
}

/// Four joints are more than the three directions of a position need, two are fewer.
static void the_orientation_may_be_free(void)
{
    for (unsigned joints = 2U; joints <= 7U; joints++) {
        arm_jacobian_t jacobian;
        double rates[ARM_JOINTS_MAX];
        const arm_twist_t twist = draw_twist();
        draw_jacobian(&jacobian, joints);
        EXPECT_ABOVE(0.02, arm_inverse(&position_only, &jacobian, joints, &twist, rates));
        for (unsigned row = 0U; row < 3U; row++) {
            const double left = fabs(residual(&jacobian, joints, rates, &twist, row));
            EXPECT_BELOW((joints < 3U) ? 2.0 : 1.0e-9, left);
        }
    }
}

/// The next singular value is only twice the smallest one.
static void the_smallest_singular_value_is_found_to_six_digits(void)
{
    const arm_twist_t twist = {.linear_m_s = {{0.0, 0.0, 0.0}}};
    arm_jacobian_t jacobian = {{{0.0}}};
    double rates[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < DIRECTIONS; i++) {
        jacobian.at[i][i] = (i == 2U) ? 0.5 : 1.0;
    }
    EXPECT_WITHIN(0.5, 1.0e-6, arm_inverse(&settings, &jacobian, DIRECTIONS, &twist, rates));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(six_and_more_joints_produce_the_velocity_of_the_tool);
    RUN_TEST(fewer_joints_minimise_the_residual);
    RUN_TEST(near_a_singular_pose_the_rates_stay_bounded);
    RUN_TEST(the_orientation_may_be_free);
    RUN_TEST(the_smallest_singular_value_is_found_to_six_digits);
    return UNITY_END();
}
