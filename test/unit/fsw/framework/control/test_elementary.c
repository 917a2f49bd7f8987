// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/elementary.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define HALF_PI 1.57079632679489661923

void setUp(void)
{
}

void tearDown(void)
{
}

static double worst_sine_cosine(const double from, const double to, const double step)
{
    double worst = 0.0;
    for (double angle = from; angle <= to; angle += step) {
        const control_sine_cosine_t found = control_sine_cosine(angle);
        const double sine                 = fabs(found.sine - sin(angle));
        const double cosine               = fabs(found.cosine - cos(angle));
        worst                             = fmax(worst, fmax(sine, cosine));
    }
    return worst;
}

static void sine_and_cosine_agree_with_the_c_library(void)
{
    EXPECT_BELOW(5.0e-16, worst_sine_cosine(-7.0, 7.0, 1.0e-4));
    EXPECT_BELOW(1.0e-15, worst_sine_cosine(-1000.0, 1000.0, 7.3e-3));
    EXPECT_BELOW(1.0e-12, worst_sine_cosine(9.9e5, 1.0e6, 3.7));
}

static void quadrants_meet_without_a_gap(void)
{
    for (int quadrant = -40; quadrant <= 40; quadrant++) {
        const double border = ((double)quadrant + 0.5) * HALF_PI;
        EXPECT_BELOW(1.0e-15, worst_sine_cosine(border - 1.0e-9, border + 1.0e-9, 1.0e-10));
    }
}

static void sine_and_cosine_lie_on_the_circle_and_are_odd_and_even(void)
{
    for (double angle = 0.0; angle < 50.0; angle += 0.013) {
        const control_sine_cosine_t plus  = control_sine_cosine(angle);
        const control_sine_cosine_t minus = control_sine_cosine(-angle);
        EXPECT_WITHIN(1.0, 5.0e-16, (plus.sine * plus.sine) + (plus.cosine * plus.cosine));
        TEST_ASSERT_TRUE(plus.sine == -minus.sine);
        TEST_ASSERT_TRUE(plus.cosine == minus.cosine);
    }
    TEST_ASSERT_TRUE(control_sine_cosine(0.0).sine == 0.0);
    TEST_ASSERT_TRUE(control_sine_cosine(0.0).cosine == 1.0);
}

static void angles_that_are_huge_or_not_finite_count_as_zero(void)
{
    const double angles[] = {1.0e6 + 1.0,      -1.0e6 - 1.0,      1.0e300,
                             (double)INFINITY, -(double)INFINITY, (double)NAN};
    for (unsigned i = 0U; i < (sizeof angles / sizeof angles[0]); i++) {
        TEST_ASSERT_TRUE(control_sine_cosine(angles[i]).sine == 0.0);
        TEST_ASSERT_TRUE(control_sine_cosine(angles[i]).cosine == 1.0);
    }
}

static void tanh_agrees_with_the_c_library(void)
{
    double worst    = 0.0;
    double relative = 0.0;
    for (double x = -25.0; x <= 25.0; x += 1.0e-4) {
        worst = fmax(worst, fabs(control_tanh(x) - tanh(x)));
    }
    for (double x = 1.0e-12; x < 1.0; x *= 1.01) {
        relative = fmax(relative, fabs((control_tanh(x) / tanh(x)) - 1.0));
    }
    EXPECT_BELOW(2.0e-15, worst);
    EXPECT_BELOW(4.0e-15, relative);
    TEST_ASSERT_TRUE(control_tanh((double)INFINITY) == 1.0);
    TEST_ASSERT_TRUE(control_tanh(-(double)INFINITY) == -1.0);
}

static void clamp_keeps_values_within_bounds_and_turns_nan_into_the_lower_one(void)
{
    TEST_ASSERT_TRUE(control_clamp(0.5, -1.0, 1.0) == 0.5);
    TEST_ASSERT_TRUE(control_clamp(2.0, -1.0, 1.0) == 1.0);
    TEST_ASSERT_TRUE(control_clamp(-2.0, -1.0, 1.0) == -1.0);
    TEST_ASSERT_TRUE(control_clamp((double)NAN, -1.0, 1.0) == -1.0);
    TEST_ASSERT_TRUE(control_clamp((double)INFINITY, -1.0, 1.0) == 1.0);
    TEST_ASSERT_TRUE(control_absolute(-3.0) == 3.0);
}

static void a_value_settles_at_zero_from_both_sides(void)
{
    TEST_ASSERT_TRUE(control_settle(9.9e-31) == 0.0);
    TEST_ASSERT_TRUE(control_settle(-9.9e-31) == 0.0);
    TEST_ASSERT_TRUE(control_settle(1.0e-30) == 1.0e-30);
    TEST_ASSERT_TRUE(control_settle(-1.0e-30) == -1.0e-30);
    TEST_ASSERT_TRUE(isnan(control_settle((double)NAN)));
}

static void an_angle_is_that_of_the_c_library_in_all_directions(void)
{
    for (int i = -40000; i <= 40000; i++) {
        const double angle = 3.14159265358979 * (double)i / 40000.0;
        for (double radius = 1.0e-3; radius < 1.0e4; radius *= 100.0) {
            const double y = radius * sin(angle);
            const double x = radius * cos(angle);
            TEST_ASSERT_TRUE(fabs(control_angle(y, x) - atan2(y, x)) < 1.0e-15);
        }
    }
    TEST_ASSERT_TRUE(control_angle(0.0, 0.0) == 0.0);
    TEST_ASSERT_TRUE(control_angle((double)NAN, 1.0) == 0.0);
    TEST_ASSERT_TRUE(fabs(control_angle(0.0, -2.0) - acos(-1.0)) < 1.0e-15);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(sine_and_cosine_agree_with_the_c_library);
    RUN_TEST(quadrants_meet_without_a_gap);
    RUN_TEST(sine_and_cosine_lie_on_the_circle_and_are_odd_and_even);
    RUN_TEST(angles_that_are_huge_or_not_finite_count_as_zero);
    RUN_TEST(tanh_agrees_with_the_c_library);
    RUN_TEST(an_angle_is_that_of_the_c_library_in_all_directions);
    RUN_TEST(clamp_keeps_values_within_bounds_and_turns_nan_into_the_lower_one);
    RUN_TEST(a_value_settles_at_zero_from_both_sides);
    return UNITY_END();
}
