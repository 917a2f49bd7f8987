// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/motion.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005

static motion_t motion;

void setUp(void)
{
    motion_rest(&motion, 0.3);
}

void tearDown(void)
{
}

static void at_rest_it_stays(void)
{
    TEST_ASSERT_TRUE(motion_is_done(&motion));
    for (unsigned i = 0U; i < 10U; i++) {
        const motion_point_t point = motion_step(&motion, PERIOD_S);
        TEST_ASSERT_TRUE((point.position == 0.3) && (point.velocity == 0.0) && (point.acceleration == 0.0));
    }
}

static void it_goes_from_rest_to_rest_in_time(void)
{
    motion_begin(&motion, 0.3, -0.9, 1.5);
    unsigned steps       = 0U;
    motion_point_t point = {.position = 0.3};
    double largest_speed = 0.0;
    double largest_jump  = 0.0;
    while (!motion_is_done(&motion)) {
        const motion_point_t before = point;
        point                       = motion_step(&motion, PERIOD_S);
        largest_speed               = fmax(largest_speed, fabs(point.velocity));
        largest_jump                = fmax(largest_jump, fabs(point.acceleration - before.acceleration));
        // The derivatives are those of the position.
        EXPECT_WITHIN(0.5 * (point.velocity + before.velocity), 1.0e-6,
                      (point.position - before.position) / PERIOD_S);
        steps++;
    }
    TEST_ASSERT_EQUAL_UINT(3000U, steps);
    EXPECT_WITHIN(-0.9, 1.0e-15, point.position);
    TEST_ASSERT_TRUE(point.velocity == 0.0);
    EXPECT_WITHIN(motion_peak_speed(-1.2, 1.5), 1.0e-6, largest_speed);
    EXPECT_BELOW(0.02, largest_jump); // Jerk is bounded: 60 d / t^3 x period.
}

static void it_stops_out_of_the_middle(void)
{
    motion_begin(&motion, 0.0, 1.0, 2.0);
    motion_point_t point = {.position = 0.0};
    for (unsigned i = 0U; i < 1500U; i++) {
        point = motion_step(&motion, PERIOD_S);
    }
    const motion_point_t from = point;
    motion_brake(&motion, &from, 4.0);
    double before = from.position;
    while (!motion_is_done(&motion)) {
        point = motion_step(&motion, PERIOD_S);
        TEST_ASSERT_TRUE(point.position >= before);
        EXPECT_BELOW((from.velocity * PERIOD_S) + 1.0e-12, point.position - before);
        before = point.position;
    }
    EXPECT_WITHIN(from.position + (from.velocity * from.velocity / 8.0), 1.0e-9, point.position);
    TEST_ASSERT_TRUE(point.velocity == 0.0);
}

static void it_stops_backwards_and_from_rest(void)
{
    motion_brake(&motion, &(motion_point_t){.position = 0.3, .velocity = -0.4}, 4.0);
    motion_point_t point = {.position = 0.0};
    while (!motion_is_done(&motion)) {
        point = motion_step(&motion, PERIOD_S);
    }
    EXPECT_WITHIN(0.3 - 0.02, 1.0e-12, point.position);
    motion_brake(&motion, &(motion_point_t){.position = 0.5}, 4.0);
    TEST_ASSERT_TRUE(motion_is_done(&motion));
    TEST_ASSERT_TRUE(motion_step(&motion, PERIOD_S).position == 0.5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(at_rest_it_stays);
    RUN_TEST(it_goes_from_rest_to_rest_in_time);
    RUN_TEST(it_stops_out_of_the_middle);
    RUN_TEST(it_stops_backwards_and_from_rest);
    return UNITY_END();
}
