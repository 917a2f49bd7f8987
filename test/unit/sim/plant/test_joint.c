// SPDX-License-Identifier: Apache-2.0
// The ripple of motor and gear in one step of a rotor, and over a whole turn of the motor.
#include "sim/plant/parameters.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "unity.h"

#include <math.h>

#define RATIO 100.0
#define INERTIA 0.5
#define RIPPLE 1.5
#define PERIODS 12.0
#define STEP_S 125e-6

static world_drive_type_t type;

void setUp(void)
{
    type = (world_drive_type_t){.ratio          = RATIO,
                                .rotor_inertia  = INERTIA,
                                .stribeck       = 1.0,
                                .ripple         = RIPPLE,
                                .ripple_periods = PERIODS};
}

void tearDown(void)
{
}

/// Speed of a rotor after one step from rest.
static double speed_from(const double position_rad, const double torque_nm)
{
    const plant_drive_t drive = plant_drive_of(&type, -1.0, 1.0);
    plant_rotor_t rotor       = {.position_rad = position_rad};
    (void)joint_rotor_step(&drive, &rotor, false, torque_nm, 0.0, STEP_S);
    return rotor.velocity_rad_s;
}

static void the_ripple_is_a_sine_of_the_angle_of_the_motor(void)
{
    const double turn_rad = 2.0 * M_PI / RATIO; // One turn of the motor.
    double sum            = 0.0;
    for (unsigned i = 0U; i < 240U; i++) {
        const double position = 0.3 + (turn_rad * i / 240.0);
        const double torque   = 2.0 + RIPPLE * sin(PERIODS * RATIO * position);
        EXPECT_WITHIN(STEP_S * torque / INERTIA, 1e-12, speed_from(position, 2.0));
        sum += speed_from(position, 0.0);
    }
    EXPECT_WITHIN(0.0, 1e-12, sum); // The mean of the ripple is zero.
}

static void two_periods_a_turn_are_the_default(void)
{
    type.ripple_periods = 0.0;
    EXPECT_WITHIN(STEP_S * RIPPLE / INERTIA, 1e-12, speed_from(M_PI / (4.0 * RATIO), 0.0));
    EXPECT_WITHIN(-STEP_S * RIPPLE / INERTIA, 1e-12, speed_from(3.0 * M_PI / (4.0 * RATIO), 0.0));
}

/// A turning motor: over one period the ripple accelerates and brakes by the same amount, and friction acts
/// as without a ripple.
static void the_ripple_does_no_work_over_its_period(void)
{
    type.ripple_periods       = 2.0;
    const plant_drive_t drive = plant_drive_of(&type, -10.0, 10.0);
    const double period_rad   = 2.0 * M_PI / (2.0 * RATIO);
    plant_rotor_t rotor       = {.velocity_rad_s = 1.0};
    double lowest             = 1.0;
    double highest            = 1.0;
    while (rotor.position_rad < (20.0 * period_rad)) {
        (void)joint_rotor_step(&drive, &rotor, false, 0.0, 0.0, STEP_S);
        lowest  = fmin(lowest, rotor.velocity_rad_s);
        highest = fmax(highest, rotor.velocity_rad_s);
    }
    // v^2 - 1 = 2 A (1 - cos) / (2 N J), at most 4 A / (2 N J).
    EXPECT_WITHIN(sqrt(1.0 + 2.0 * RIPPLE / (RATIO * INERTIA)), 1e-3, highest);
    EXPECT_WITHIN(1.0, 1e-3, lowest);
}

static void without_a_ripple_nothing_changes(void)
{
    type.ripple = 0.0;
    TEST_ASSERT_TRUE(speed_from(0.123, 2.0) == (STEP_S * 2.0 / INERTIA));
    TEST_ASSERT_TRUE(speed_from(0.123, 0.0) == 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_ripple_is_a_sine_of_the_angle_of_the_motor);
    RUN_TEST(two_periods_a_turn_are_the_default);
    RUN_TEST(the_ripple_does_no_work_over_its_period);
    RUN_TEST(without_a_ripple_nothing_changes);
    return UNITY_END();
}
