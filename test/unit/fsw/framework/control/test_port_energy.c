// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/port_energy.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define PERIOD_S 0.001

static control_port_energy_t energy;
static control_port_watch_t watch;
static unsigned alarms;
static double reported_j;

void setUp(void)
{
    watch =
        (control_port_watch_t){.limit_j = 2.0e-3, .time_s = 5.0, .rest_rad = 1.0e-3, .period_s = PERIOD_S};
    control_port_energy_reset(&energy);
    alarms     = 0U;
    reported_j = 0.0;
}

void tearDown(void)
{
}

static void step(const double torque, const double position)
{
    const double torques[2]   = {0.0, torque};
    const double positions[2] = {0.3, position};
    const double given        = control_port_energy_step(&energy, &watch, torques, positions);
    alarms += (given > 0.0) ? 1U : 0U;
    reported_j = (given > 0.0) ? given : reported_j;
}

/// A port that damps (sign 1) or drives (-1) an oscillation of 0.5 mrad at 20 Hz about a drifting position.
static void swing(const double seconds, const double sign, const double drift_rad_s)
{
    const unsigned cycles = (unsigned)(seconds / PERIOD_S);
    for (unsigned i = 0U; i < cycles; i++) {
        const double t = PERIOD_S * (double)i;
        step(sign * 0.05 * cos(125.66 * (t - (0.5 * PERIOD_S))),
             (0.5e-3 * sin(125.66 * t)) + (drift_rad_s * t));
    }
}

// Mean power 0.5 x 0.05 Nm x 0.5e-3 rad x 125.66 rad/s = 1.57 mW: 7.85 mJ in 5 s.
static void an_oscillation_at_rest_is_reported_once_in_each_window(void)
{
    swing(5.01, -1.0, 0.0);
    TEST_ASSERT_EQUAL_UINT(1U, alarms);
    EXPECT_WITHIN(7.85e-3, 0.1e-3, reported_j);
    EXPECT_WITHIN(-7.85e-3, 0.1e-3, energy.taken_j);
    EXPECT_ABOVE(7.8e-3, energy.given_j);
    swing(10.0, -1.0, 0.0);
    TEST_ASSERT_EQUAL_UINT(3U, alarms);
}

static void a_port_that_damps_is_passive(void)
{
    swing(20.0, 1.0, 0.0);
    TEST_ASSERT_EQUAL_UINT(0U, alarms);
    EXPECT_ABOVE(0.0, energy.taken_j);
    EXPECT_BELOW(1.0e-3, energy.given_j);
}

/// A moving port may give away the energy that it has stored, so it is not checked.
static void a_moving_port_is_not_checked(void)
{
    swing(20.0, -1.0, 0.5e-3);
    TEST_ASSERT_EQUAL_UINT(0U, alarms);
    EXPECT_BELOW(-10.0e-3, energy.taken_j);
}

static void energy_below_the_limit_raises_no_alarm(void)
{
    watch.limit_j = 8.0e-3;
    swing(20.0, -1.0, 0.0);
    TEST_ASSERT_EQUAL_UINT(0U, alarms);
}

static void the_first_position_transfers_no_energy(void)
{
    step(1.0, 5.0);
    TEST_ASSERT_TRUE((energy.taken_j == 0.0) && (energy.given_j == 0.0));
    step(1.0, 5.1);
    EXPECT_WITHIN(0.1, 1.0e-12, energy.taken_j);
    control_port_energy_reset(&energy);
    step(-1.0, 7.0);
    TEST_ASSERT_TRUE((energy.taken_j == 0.0) && (energy.given_j == 0.0));
    step(-1.0, 7.1);
    EXPECT_WITHIN(0.1, 1.0e-12, energy.given_j);
}

/// The received energy never decreases, even if the port gives energy away.
static void the_received_energy_does_not_decrease(void)
{
    double before = 0.0;
    for (unsigned i = 0U; i < 20000U; i++) {
        const double t = PERIOD_S * (double)i;
        step(0.05 * cos(31.0 * t), 0.5e-3 * sin((17.0 * t) + (0.3 * t * t)));
        TEST_ASSERT_TRUE(energy.received_j >= before);
        before = energy.received_j;
    }
    EXPECT_WITHIN(energy.taken_j + energy.given_j, 1.0e-12, before);
    EXPECT_ABOVE(1.0e-3, before);
}

/// A reserve with every sum and a reserve that misses most sums reach the same value.
static void lost_sums_only_delay_a_reserve(void)
{
    control_reserve_t all  = {0};
    control_reserve_t some = {0};
    for (unsigned i = 0U; i <= 1000U; i++) {
        const double sum = 1.0 + (0.5 * (double)i);
        control_reserve_take_sum(&all, sum);
        control_reserve_take_sum(&all, sum); // The newest sum is read again until the next one comes.
        if (((i * 7U) % 10U) == 0U) {
            control_reserve_take_sum(&some, sum);
        }
        TEST_ASSERT_TRUE(some.reserve_j <= all.reserve_j);
    }
    TEST_ASSERT_TRUE((all.reserve_j == 500.0) && (some.reserve_j == 500.0));
}

/// Whichever side starts first or starts again, energy from before is not added.
static void the_first_sum_and_a_sum_after_a_reset_add_nothing(void)
{
    control_reserve_t reserve = {0};
    control_reserve_take_sum(&reserve, 7.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == 0.0);
    control_reserve_take_sum(&reserve, 7.5);
    control_reserve_take_sum(&reserve, (double)NAN);
    control_reserve_take_sum(&reserve, 0.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == 0.5);
    control_reserve_take_sum(&reserve, 0.25);
    TEST_ASSERT_TRUE(reserve.reserve_j == 0.75);
}

static void a_reserve_has_an_upper_limit_and_may_be_negative(void)
{
    control_reserve_t reserve = {0};
    control_reserve_add(&reserve, 5.0, 2.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == 2.0);
    control_reserve_add(&reserve, -0.5, 2.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == 1.5);
    control_reserve_add(&reserve, -3.0, 2.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == -1.5);
    control_reserve_take_sum(&reserve, 0.0);
    control_reserve_take_sum(&reserve, 100.0);
    control_reserve_add(&reserve, 0.0, 2.0);
    TEST_ASSERT_TRUE(reserve.reserve_j == 2.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_oscillation_at_rest_is_reported_once_in_each_window);
    RUN_TEST(a_port_that_damps_is_passive);
    RUN_TEST(a_moving_port_is_not_checked);
    RUN_TEST(energy_below_the_limit_raises_no_alarm);
    RUN_TEST(the_first_position_transfers_no_energy);
    RUN_TEST(the_received_energy_does_not_decrease);
    RUN_TEST(lost_sums_only_delay_a_reserve);
    RUN_TEST(the_first_sum_and_a_sum_after_a_reset_add_nothing);
    RUN_TEST(a_reserve_has_an_upper_limit_and_may_be_negative);
    return UNITY_END();
}
