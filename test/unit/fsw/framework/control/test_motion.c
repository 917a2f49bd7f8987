// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/motion.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005

static control_motion_t motion;

void setUp(void)
{
    control_motion_rest(&motion, 0.3);
}

void tearDown(void)
{
}

static void a_motion_at_rest_does_not_move(void)
{
    TEST_ASSERT_TRUE(control_motion_is_done(&motion));
    for (unsigned i = 0U; i < 10U; i++) {
        const control_motion_point_t point = control_motion_step(&motion, PERIOD_S);
        TEST_ASSERT_TRUE((point.position == 0.3) && (point.velocity == 0.0) && (point.acceleration == 0.0));
    }
}

static void a_motion_goes_from_rest_to_rest_in_its_time(void)
{
    control_motion_begin(&motion, 0.3, -0.9, 1.5);
    unsigned steps               = 0U;
    control_motion_point_t point = {.position = 0.3};
    double largest_speed         = 0.0;
    double largest_jump          = 0.0;
    while (!control_motion_is_done(&motion)) {
        const control_motion_point_t before = point;
        point                               = control_motion_step(&motion, PERIOD_S);
        largest_speed                       = fmax(largest_speed, fabs(point.velocity));
        largest_jump = fmax(largest_jump, fabs(point.acceleration - before.acceleration));
        // Velocity is the derivative of the position.
        EXPECT_WITHIN(0.5 * (point.velocity + before.velocity), 1.0e-6,
                      (point.position - before.position) / PERIOD_S);
        steps++;
    }
    TEST_ASSERT_EQUAL_UINT(3000U, steps);
    EXPECT_WITHIN(-0.9, 1.0e-15, point.position);
    TEST_ASSERT_TRUE(point.velocity == 0.0);
    EXPECT_WITHIN(control_motion_peak_speed(-1.2, 1.5), 1.0e-6, largest_speed);
    EXPECT_BELOW(0.02, largest_jump); // The jerk is at most 60 distance / duration^3.
}

/// The durations are exact as double. Half a period before the end is not yet the end.
static void a_motion_ends_less_than_half_a_period_before_its_time(void)
{
    static const double durations_s[] = {1.5, 1.625, 1.75};
    static const unsigned expected[]  = {3U, 3U, 4U};
    for (unsigned i = 0U; i < 3U; i++) {
        unsigned steps = 0U;
        control_motion_begin(&motion, 0.0, 1.0, durations_s[i]);
        while (!control_motion_is_done(&motion)) {
            (void)control_motion_step(&motion, 0.5);
            steps++;
        }
        TEST_ASSERT_EQUAL_UINT(expected[i], steps);
    }
}

static void a_motion_stops_from_full_speed(void)
{
    control_motion_begin(&motion, 0.0, 1.0, 2.0);
    control_motion_point_t point = {.position = 0.0};
    for (unsigned i = 0U; i < 1500U; i++) {
        point = control_motion_step(&motion, PERIOD_S);
    }
    const control_motion_point_t from = point;
    control_motion_brake(&motion, &from, 4.0);
    double before = from.position;
    double speed  = from.velocity;
    while (!control_motion_is_done(&motion)) {
        point = control_motion_step(&motion, PERIOD_S);
        TEST_ASSERT_TRUE(point.position >= before);
        EXPECT_BELOW((from.velocity * PERIOD_S) + 1.0e-12, point.position - before);
        // The stop may end within the last period, in which the acceleration is then not constant.
        if (!control_motion_is_done(&motion)) {
            EXPECT_WITHIN(0.5 * (point.velocity + speed), 1.0e-9, (point.position - before) / PERIOD_S);
            EXPECT_WITHIN(-4.0, 1.0e-9, point.acceleration);
        }
        before = point.position;
        speed  = point.velocity;
    }
    EXPECT_WITHIN(from.position + (from.velocity * from.velocity / 8.0), 1.0e-9, point.position);
    TEST_ASSERT_TRUE(point.velocity == 0.0);
}

static void a_motion_stops_from_backward_speed_and_from_rest(void)
{
    control_motion_brake(&motion, &(control_motion_point_t){.position = 0.3, .velocity = -0.4}, 4.0);
    control_motion_point_t point = {.position = 0.0};
    unsigned steps               = 0U;
    while (!control_motion_is_done(&motion)) {
        point = control_motion_step(&motion, PERIOD_S);
        steps++;
        if (!control_motion_is_done(&motion)) {
            const double t = (double)steps * PERIOD_S;
            EXPECT_WITHIN(0.3 - (0.4 * t) + (2.0 * t * t), 1.0e-12, point.position);
            EXPECT_WITHIN(-0.4 + (4.0 * t), 1.0e-12, point.velocity);
            EXPECT_WITHIN(4.0, 1.0e-12, point.acceleration);
        }
    }
    TEST_ASSERT_EQUAL_UINT(200U, steps);
    EXPECT_WITHIN(0.3 - 0.02, 1.0e-12, point.position);
    control_motion_brake(&motion, &(control_motion_point_t){.position = 0.5}, 4.0);
    TEST_ASSERT_TRUE(control_motion_is_done(&motion));
    TEST_ASSERT_TRUE(control_motion_step(&motion, PERIOD_S).position == 0.5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_motion_at_rest_does_not_move);
    RUN_TEST(a_motion_goes_from_rest_to_rest_in_its_time);
    RUN_TEST(a_motion_ends_less_than_half_a_period_before_its_time);
    RUN_TEST(a_motion_stops_from_full_speed);
    RUN_TEST(a_motion_stops_from_backward_speed_and_from_rest);
    return UNITY_END();
}
