// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/tracker.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define PERIOD_S 0.0005

static control_tracker_t tracker;

void setUp(void)
{
    control_tracker_reset(&tracker, 0.0);
}

void tearDown(void)
{
}

static void a_constant_is_not_changed(void)
{
    control_tracker_reset(&tracker, 0.7);
    for (unsigned i = 0U; i < 1000U; i++) {
        control_tracker_step(&tracker, 0.7, 1250.0, PERIOD_S);
    }
    TEST_ASSERT_TRUE(tracker.position == 0.7);
    TEST_ASSERT_TRUE(tracker.velocity == 0.0);
    TEST_ASSERT_TRUE(tracker.acceleration == 0.0);
}

static void a_ramp_is_tracked_without_lag(void)
{
    const double speed = 0.8;
    double target      = 0.0;
    for (unsigned i = 0U; i < 4000U; i++) {
        target = speed * PERIOD_S * (double)i;
        control_tracker_step(&tracker, target, 125.0, PERIOD_S);
    }
    // The state is predicted for the next sample.
    EXPECT_WITHIN(target + (speed * PERIOD_S), 1.0e-9, tracker.position);
    EXPECT_WITHIN(speed, 1.0e-9, tracker.velocity);
    EXPECT_WITHIN(0.0, 1.0e-6, tracker.acceleration);
}

static void a_step_response_settles_without_oscillation(void)
{
    // Critically damped with a zero: one overshoot (exp(-2) of the step in continuous time), no second one.
    double highest = 0.0;
    double lowest  = 1.0;
    for (unsigned i = 0U; i < 2000U; i++) {
        control_tracker_step(&tracker, 1.0, 125.0, PERIOD_S);
        highest = fmax(highest, tracker.position);
        if (i > 40U) {
            lowest = fmin(lowest, tracker.position);
        }
    }
    EXPECT_BELOW(1.16, highest);
    EXPECT_ABOVE(0.999999, lowest);
    EXPECT_WITHIN(1.0, 1.0e-9, tracker.position);
}

static void the_filter_has_its_stated_bandwidth(void)
{
    // Gain of the position, (2 w s + w^2) / (s + w)^2, at s = j w: sqrt(5) / 2.
    const double omega = 125.0;
    double largest     = 0.0;
    for (unsigned i = 0U; i < 20000U; i++) {
        control_tracker_step(&tracker, sin(omega * PERIOD_S * (double)i), omega, PERIOD_S);
        if (i > 10000U) {
            largest = fmax(largest, fabs(tracker.position));
        }
    }
    EXPECT_WITHIN(sqrt(5.0) / 2.0, 0.03, largest);
}

/// At zero, rounding does not end the decay.
static void a_velocity_that_decays_to_zero_does_not_become_subnormal(void)
{
    control_tracker_reset(&tracker, 0.1);
    for (unsigned i = 0U; i < 20000U; i++) {
        control_tracker_step(&tracker, 0.0, 300.0, PERIOD_S);
        TEST_ASSERT_FALSE(fpclassify(tracker.position) == FP_SUBNORMAL);
        TEST_ASSERT_FALSE(fpclassify(tracker.velocity) == FP_SUBNORMAL);
        TEST_ASSERT_FALSE(fpclassify(tracker.acceleration) == FP_SUBNORMAL);
    }
    TEST_ASSERT_TRUE((tracker.position == 0.0) && (fabs(tracker.velocity) < 1.0e-25));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_constant_is_not_changed);
    RUN_TEST(a_ramp_is_tracked_without_lag);
    RUN_TEST(a_step_response_settles_without_oscillation);
    RUN_TEST(the_filter_has_its_stated_bandwidth);
    RUN_TEST(a_velocity_that_decays_to_zero_does_not_become_subnormal);
    return UNITY_END();
}
