// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_geometry.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
#define CASES 2000U

static const arm_rotation_t unrotated = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};

void setUp(void)
{
    srand(7U);
}

void tearDown(void)
{
}

static double draw(const double limit)
{
    return limit * (((2.0 * (double)rand()) / (double)RAND_MAX) - 1.0);
}

static arm_vector_t draw_direction(void)
{
    const arm_vector_t vector = {{draw(1.0), draw(1.0), draw(1.0)}};
    return arm_times(vector, 1.0 / arm_length(vector));
}

static void a_rotation_vector_is_recovered_up_to_half_a_turn(void)
{
    const double angles[] = {1.0e-9, 1.0e-4, 0.5, 1.5, 3.0, PI - 1.0e-7};
    for (unsigned i = 0U; i < CASES; i++) {
        const double angle        = angles[i % (sizeof angles / sizeof angles[0])];
        const arm_vector_t wanted = arm_times(draw_direction(), angle);
        const double rpy[3]       = {draw(3.0), draw(3.0), draw(3.0)};
        const arm_rotation_t from = arm_rotation_of_rpy(rpy);
        const arm_rotation_t to   = arm_rotation_turned_by(&from, wanted);
        const arm_vector_t found  = arm_rotation_between(&from, &to);
        EXPECT_WITHIN(0.0, 2.0e-14, arm_length(arm_difference(wanted, found)));
    }
}

/// For a turn by 180 degrees two opposite axes are correct; the angle must be 180 degrees.
static void half_a_turn_about_each_axis_has_its_angle(void)
{
    for (unsigned k = 0U; k < 3U; k++) {
        arm_vector_t vector     = {{0.0, 0.0, 0.0}};
        vector.at[k]            = PI;
        const arm_rotation_t to = arm_rotation_turned_by(&unrotated, vector);
        const arm_vector_t back = arm_rotation_between(&unrotated, &to);
        EXPECT_WITHIN(PI, 1.0e-15, arm_length(back));
        EXPECT_WITHIN(PI, 1.0e-15, fabs(back.at[k]));
    }
    // Between equal orientations the rotation vector is zero, and a turn by zero changes nothing.
    const arm_vector_t zero = arm_rotation_between(&unrotated, &unrotated);
    EXPECT_WITHIN(0.0, 0.0, arm_length(zero));
    const arm_rotation_t same = arm_rotation_turned_by(&unrotated, zero);
    EXPECT_WITHIN(1.0, 0.0, same.at[2][2]);
}

/// Yaw acts last: a pitch of 90 degrees turns x downwards, and yaw about the vertical does not change it any
/// more. With this pitch, roll turns y about the vertical too, against yaw, so y points to yaw - roll.
static void roll_pitch_and_yaw_turn_about_fixed_axes_in_that_order(void)
{
    const double rpy[3]       = {0.3, PI / 2.0, 1.1};
    const arm_rotation_t turn = arm_rotation_of_rpy(rpy);
    const arm_vector_t x      = arm_rotated(&turn, (arm_vector_t){{1.0, 0.0, 0.0}});
    EXPECT_WITHIN(-1.0, 1.0e-15, x.at[2]);
    const arm_vector_t y = arm_rotated(&turn, (arm_vector_t){{0.0, 1.0, 0.0}});
    EXPECT_WITHIN(-sin(1.1 - 0.3), 1.0e-15, y.at[0]);
    EXPECT_WITHIN(cos(1.1 - 0.3), 1.0e-15, y.at[1]);
    const arm_vector_t back = arm_rotated_back(&turn, x);
    EXPECT_WITHIN(1.0, 1.0e-15, back.at[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_rotation_vector_is_recovered_up_to_half_a_turn);
    RUN_TEST(half_a_turn_about_each_axis_has_its_angle);
    RUN_TEST(roll_pitch_and_yaw_turn_about_fixed_axes_in_that_order);
    return UNITY_END();
}
