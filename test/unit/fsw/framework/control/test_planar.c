// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/planar.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stddef.h>

static const double poses[][4] = {
    {-0.066, 0.125, 0.327, 0.2165}, {0.3, -0.1, 0.05, 0.25}, {0.0, 1.0, -1.0, 0.0}, {2.0, 0.0, 0.0, -3.0}};

void setUp(void)
{
}

void tearDown(void)
{
}

static void the_mappings_of_force_and_torque_are_inverse(void)
{
    for (size_t i = 0U; i < (sizeof poses / sizeof poses[0]); i++) {
        const double torque[2] = {1.7, -0.6};
        double force[2];
        double back[2];
        control_planar_force(poses[i], torque, force);
        control_planar_torque(poses[i], force, back);
        EXPECT_WITHIN(torque[0], 1.0e-14, back[0]);
        EXPECT_WITHIN(torque[1], 1.0e-14, back[1]);
    }
}

static void the_mappings_of_motion_between_tip_and_axes_are_inverse(void)
{
    for (size_t i = 0U; i < (sizeof poses / sizeof poses[0]); i++) {
        const double angle[2] = {0.02, -0.07};
        double move[2];
        double back[2];
        control_planar_move(poses[i], angle, move);
        EXPECT_WITHIN((poses[i][0] * 0.02) - (poses[i][1] * 0.07), 1.0e-15, move[0]);
        EXPECT_WITHIN((poses[i][2] * 0.02) - (poses[i][3] * 0.07), 1.0e-15, move[1]);
        control_planar_angles(poses[i], move, back);
        EXPECT_WITHIN(angle[0], 1.0e-14, back[0]);
        EXPECT_WITHIN(angle[1], 1.0e-14, back[1]);
    }
}

/// Power is equal at the tip and at the axes.
static void the_mapping_conserves_power(void)
{
    for (size_t i = 0U; i < (sizeof poses / sizeof poses[0]); i++) {
        const double force[2] = {3.0, -11.0};
        const double angle[2] = {0.02, 0.05};
        double torque[2];
        double move[2];
        control_planar_torque(poses[i], force, torque);
        control_planar_move(poses[i], angle, move);
        EXPECT_WITHIN((force[0] * move[0]) + (force[1] * move[1]), 1.0e-14,
                      (torque[0] * angle[0]) + (torque[1] * angle[1]));
    }
}

static void a_stretched_mechanism_is_singular(void)
{
    const double stretched[4] = {0.0, 0.0, 0.47, 0.25};
    const double least[4]     = {1.0e-3, 0.0, 0.0, -1.0};
    const double below[4]     = {0.999e-3, 0.0, 0.0, -1.0};
    TEST_ASSERT_TRUE(control_planar_is_regular(poses[0]));
    TEST_ASSERT_FALSE(control_planar_is_regular(stretched));
    TEST_ASSERT_TRUE(control_planar_is_regular(least));
    TEST_ASSERT_FALSE(control_planar_is_regular(below));
}

static void the_length_of_a_vector_is_exact_at_every_angle(void)
{
    const double three_four[2] = {3.0, -4.0};
    const double none[2]       = {0.0, 0.0};
    EXPECT_WITHIN(5.0, 1.0e-15, control_planar_length(three_four));
    for (double angle = 0.0; angle < 6.3; angle += 0.01) {
        const double vector[2] = {2.0e-7 * cos(angle), 2.0e-7 * sin(angle)};
        EXPECT_WITHIN(2.0e-7, 1.0e-15 * 2.0e-7, control_planar_length(vector));
    }
    TEST_ASSERT_TRUE(control_planar_length(none) == 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_mappings_of_force_and_torque_are_inverse);
    RUN_TEST(the_mappings_of_motion_between_tip_and_axes_are_inverse);
    RUN_TEST(the_mapping_conserves_power);
    RUN_TEST(a_stretched_mechanism_is_singular);
    RUN_TEST(the_length_of_a_vector_is_exact_at_every_angle);
    return UNITY_END();
}
