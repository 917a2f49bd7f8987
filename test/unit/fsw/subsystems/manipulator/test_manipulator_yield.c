// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_yield.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define PERIOD_S 0.0005
#define SCALE 2.0

// The arm in its home pose, {60, -90} degrees with links of 0.22 and 0.25 m.
static const double home[4] = {-0.0655255888, 0.125, 0.3265063509, 0.2165063509};

static manipulator_remote_t gains;
static manipulator_arm_yield_t yield;
static manipulator_arm_yield_setup_t setup;
static uint32_t state;

void setUp(void)
{
    gains = (manipulator_remote_t){.force_limit    = 20.0,
                                   .give_way       = 8.0e-3,
                                   .give_way_max   = 0.1,
                                   .touch          = 1.0,
                                   .contact_corner = 30.0,
                                   .normal_corner  = 5.0,
                                   .force_scale    = 0.03,
                                   .reserve        = 2.0e-3,
                                   .tolerance      = 1.0e-5};
    setup = (manipulator_arm_yield_setup_t){.gains = &gains, .position_scale = SCALE, .period_s = PERIOD_S};
    state = 12345U;
    const manipulator_arm_yield_sample_t none = {.jacobian = home};
    manipulator_arm_yield_reset(&yield, &none);
}

void tearDown(void)
{
}

/// Returns a pseudo-random number between -1 and 1.
static double draw(void)
{
    state = (state * 1664525U) + 1013904223U;
    return ((double)(state >> 8U) / 8388608.0) - 1.0;
}

static const double* run(const double* const hand_rad, const double* const external_nm, const double paid_j)
{
    const manipulator_arm_yield_sample_t sample = {
        .jacobian = home, .external_nm = external_nm, .hand_rad = hand_rad, .paid_j = paid_j};
    return manipulator_arm_yield_step(&yield, &setup, &sample);
}

/// Joint torques of a force at the tip.
static void torques(const double x_n, const double z_n, double out[2])
{
    const double force[2] = {x_n, z_n};
    control_planar_torque(home, force, out);
}

static void push(const double x_n, const double z_n, const unsigned cycles)
{
    double torque[2];
    torques(x_n, z_n, torque);
    for (unsigned i = 0U; i < cycles; i++) {
        (void)run(NULL, torque, 0.0);
    }
}

static void couple(void)
{
    const double hand[2] = {0.1, -0.2};
    const double free[2] = {0.0, 0.0};
    TEST_ASSERT_NOT_NULL(run(hand, free, 5.0));
}

static void the_first_valid_sample_couples_the_hand_and_free_space_changes_nothing(void)
{
    const double free[2]   = {0.0, 0.0};
    const double broken[2] = {0.1, (double)NAN};
    const double beyond[2] = {(double)INFINITY, 0.0};
    TEST_ASSERT_NULL(run(NULL, free, 0.0));
    TEST_ASSERT_NULL(run(broken, free, 0.0));
    TEST_ASSERT_NULL(run(beyond, free, 0.0));
    double hand[2]            = {0.1, -0.2};
    const double* const acted = run(hand, free, 0.0);
    TEST_ASSERT_TRUE((acted[0] == 0.1) && (acted[1] == -0.2));
    for (unsigned i = 0U; i < 2000U; i++) {
        hand[0] += 1.0e-3 * draw();
        hand[1] += 1.0e-3 * draw();
        const bool is_lost = (draw() < -0.9);
        (void)run(is_lost ? NULL : hand, free, 0.0);
        if (!is_lost) {
            EXPECT_WITHIN(hand[0], 1.0e-12, yield.acted_rad[0]);
            EXPECT_WITHIN(hand[1], 1.0e-12, yield.acted_rad[1]);
        }
    }
    const double stays[2] = {yield.acted_rad[0], yield.acted_rad[1]};
    (void)run(broken, free, 0.0);
    (void)run(beyond, free, 0.0);
    TEST_ASSERT_TRUE((yield.acted_rad[0] == stays[0]) && (yield.acted_rad[1] == stays[1]));
    TEST_ASSERT_TRUE((yield.taken_j == 0.0) && (yield.given_way_m == 0.0) && !yield.is_touching);
}

/// 10 N above the limit the arm yields with 80 mm/s along the normal. Below the limit it comes back, but not
/// beyond the hand.
static void the_arm_yields_above_the_force_limit(void)
{
    couple();
    push(0.0, 20.0, 4000U);
    EXPECT_WITHIN(0.0, 1.0e-12, yield.given_way_m); // The force equals the limit.
    push(0.0, 30.0, 1000U);
    EXPECT_WITHIN(0.04, 1.0e-9, yield.given_way_m);
    const double moved[2] = {SCALE * (yield.acted_rad[0] - 0.1), SCALE * (yield.acted_rad[1] + 0.2)};
    double tip[2];
    control_planar_move(home, moved, tip);
    EXPECT_WITHIN(0.0, 1.0e-6, tip[0]);
    EXPECT_WITHIN(0.04, 1.0e-6, tip[1]);
    push(0.0, 30.0, 10000U);
    EXPECT_WITHIN(0.1, 1.0e-12, yield.given_way_m);
    push(0.0, 10.0, 1000U);
    EXPECT_WITHIN(0.06, 1.0e-9, yield.given_way_m);
    push(0.0, 0.0, 20000U);
    EXPECT_WITHIN(0.0, 0.0, yield.given_way_m);
    EXPECT_WITHIN(0.1, 1.0e-9, yield.acted_rad[0]);
    EXPECT_WITHIN(-0.2, 1.0e-9, yield.acted_rad[1]);
}

/// The force contains friction: at the touch its direction is the normal; later only its slow part is used.
static void the_normal_is_that_of_the_touch_and_then_changes_slowly(void)
{
    couple();
    push(0.0, 0.9, 4000U);
    TEST_ASSERT_FALSE(yield.is_touching);
    push(0.0, 0.0, 2000U);
    push(4.5, 15.0, 200U);
    TEST_ASSERT_TRUE(yield.is_touching);
    EXPECT_ABOVE(0.2, yield.normal[0]);
    EXPECT_WITHIN(1.0, 1.0e-12, control_planar_length(yield.normal));
    const double at_touch = yield.normal[0];
    push(-4.5, 15.0, 100U); // For 50 ms the tip slides back.
    EXPECT_ABOVE(0.5 * at_touch, yield.normal[0]);
    push(-4.5, 15.0, 8000U);
    EXPECT_WITHIN(-0.2873, 1.0e-3, yield.normal[0]);
    EXPECT_WITHIN(15.66, 0.01, yield.push_n);
    push(0.0, 0.0, 2000U);
    TEST_ASSERT_FALSE(yield.is_touching);
    EXPECT_WITHIN(0.0, 0.0, yield.push_n);
    push(0.0, -15.0, 200U); // A touch from the opposite side.
    EXPECT_WITHIN(-1.0, 1.0e-6, yield.normal[1]);
    EXPECT_ABOVE(0.0, yield.push_n);
}

/// The motion of the arm disturbs the estimate of the torque at 25 Hz; this must not count as a touch.
static void a_fast_oscillation_does_not_count_as_a_touch(void)
{
    couple();
    for (unsigned i = 0U; i < 4000U; i++) {
        double torque[2];
        torques(0.0, 2.5 * sin(157.0 * PERIOD_S * (double)i), torque);
        (void)run(NULL, torque, 0.0);
        TEST_ASSERT_FALSE(yield.is_touching);
    }
}

/// The mean of two opposite forces is zero and has no direction.
static void forces_that_cancel_keep_the_last_normal(void)
{
    gains.contact_corner = 1.0 / PERIOD_S;
    gains.normal_corner  = 0.5 / PERIOD_S;
    couple();
    push(0.0, 5.0, 1U);
    push(0.0, -5.0, 1U); // Half of each force: they cancel, so the last direction is kept.
    EXPECT_WITHIN(1.0, 0.0, yield.normal[1]);
}

/// The hand moves, the environment pushes, and energy arrives late and with losses. In no cycle does the arm
/// give away more than the received energy plus the tolerance.
static void the_arm_never_gives_away_more_energy_than_it_received(void)
{
    const double tolerance = gains.tolerance + 1.0e-12;
    couple();
    double hand[2]       = {0.1, -0.2};
    double torque[2]     = {0.0, 0.0};
    double paid          = 5.0;
    double received_paid = 5.0; // Value of `paid` in the last sample that was not lost.
    double given         = 0.0;
    double received      = 0.0;
    unsigned held        = 0U;
    for (unsigned i = 0U; i < 200000U; i++) {
        const double before[2] = {yield.acted_rad[0], yield.acted_rad[1]};
        for (unsigned axis = 0U; axis < 2U; axis++) {
            hand[axis] += 2.0e-4 * draw();
            torque[axis] = (0.99 * torque[axis]) + (1.5 * draw());
        }
        paid += (draw() > 0.95) ? 1.0e-5 : 0.0;
        const bool is_lost = draw() < -0.9;
        received_paid      = is_lost ? received_paid : paid;
        (void)run(is_lost ? NULL : hand, torque, paid);
        const double step = -0.03 * ((torque[0] * (yield.acted_rad[0] - before[0])) +
                                     (torque[1] * (yield.acted_rad[1] - before[1])));
        given += step;
        TEST_ASSERT_TRUE(given <= ((received_paid - 5.0) + tolerance));
        TEST_ASSERT_TRUE(yield.reserve.reserve_j >= -tolerance);
        TEST_ASSERT_TRUE(yield.reserve.reserve_j <= gains.reserve);
        TEST_ASSERT_TRUE(yield.taken_j >= received);
        received = yield.taken_j;
        held += ((fabs(yield.asked_rad[0] - yield.acted_rad[0]) > 1.0e-6) ? 1U : 0U);
    }
    TEST_ASSERT_TRUE(held > 1000U); // The controller had to intervene.
}

/// Without energy of the hand the arm does not press further. Later it follows the hand without a step.
static void a_press_without_energy_waits_and_continues_slowly(void)
{
    couple();
    double torque[2];
    double hand[2] = {0.1, -0.2};
    torques(0.0, 10.0, torque);
    for (unsigned i = 0U; i < 1000U; i++) {
        hand[0] -= 5.0e-5; // 50 mrad downwards.
        (void)run(hand, torque, 5.0);
    }
    const double pressed =
        -0.03 * ((torque[0] * (yield.acted_rad[0] - 0.1)) + (torque[1] * (yield.acted_rad[1] + 0.2)));
    EXPECT_BELOW(gains.tolerance + 1.0e-9, pressed);
    EXPECT_ABOVE(0.02, yield.acted_rad[0] - hand[0]);
    const double free[2] = {0.0, 0.0};
    for (unsigned i = 0U; i < 2000U; i++) {
        const double before = yield.acted_rad[0];
        (void)run(hand, free, 5.0);
        EXPECT_BELOW(2.0e-4 + 1.0e-12, before - yield.acted_rad[0]);
    }
    EXPECT_WITHIN(hand[0], 1.0e-6, yield.acted_rad[0]);
}

/// The reserve at a contact is never larger than the cap, however long the hand has worked before.
static void an_old_reserve_is_limited_to_its_cap(void)
{
    couple();
    double torque[2];
    double hand[2]       = {0.1, -0.2};
    const double free[2] = {0.0, 0.0};
    (void)run(hand, free, 105.0);
    torques(0.0, 10.0, torque);
    for (unsigned i = 0U; i < 2000U; i++) {
        hand[0] -= 5.0e-5;
        (void)run(hand, torque, 105.0);
    }
    const double pressed =
        -0.03 * ((torque[0] * (yield.acted_rad[0] - 0.1)) + (torque[1] * (yield.acted_rad[1] + 0.2)));
    EXPECT_WITHIN(gains.reserve + gains.tolerance, 1.0e-9, pressed);
}

/// In a pose in which the torques do not determine the force, the arm follows the hand.
static void a_stretched_arm_follows_the_hand(void)
{
    const double stretched[4] = {0.0, 0.0, 0.47, 0.25};
    const double torque[2]    = {20.0, 12.0};
    double hand[2]            = {0.1, -0.2};
    couple();
    for (unsigned pass = 0U; pass < 2U; pass++) {
        setup.position_scale = (pass == 0U) ? SCALE : 0.0;
        hand[0] += 0.01; // The motion has the direction of the torque: no energy is given away.
        const manipulator_arm_yield_sample_t sample = {.jacobian    = (pass == 0U) ? stretched : home,
                                                       .external_nm = torque,
                                                       .hand_rad    = hand,
                                                       .paid_j      = 5.0};
        const double* const acted                   = manipulator_arm_yield_step(&yield, &setup, &sample);
        EXPECT_WITHIN(hand[0], 1.0e-12, acted[0]);
        TEST_ASSERT_FALSE(yield.is_touching);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_first_valid_sample_couples_the_hand_and_free_space_changes_nothing);
    RUN_TEST(the_arm_yields_above_the_force_limit);
    RUN_TEST(the_normal_is_that_of_the_touch_and_then_changes_slowly);
    RUN_TEST(a_fast_oscillation_does_not_count_as_a_touch);
    RUN_TEST(forces_that_cancel_keep_the_last_normal);
    RUN_TEST(the_arm_never_gives_away_more_energy_than_it_received);
    RUN_TEST(a_press_without_energy_waits_and_continues_slowly);
    RUN_TEST(an_old_reserve_is_limited_to_its_cap);
    RUN_TEST(a_stretched_arm_follows_the_hand);
    return UNITY_END();
}
