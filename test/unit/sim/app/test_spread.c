// SPDX-License-Identifier: Apache-2.0
// The true parameters of robots: the seed draws them within their bounds, and only where the world allows a
// spread.
#include "sim/app/spread.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SEEDS 400U

static world_t world;

void setUp(void)
{
    world = rokviss()->world;
}

void tearDown(void)
{
}

static void a_robot_without_spread_has_exactly_the_values_of_its_file(void)
{
    spread_apply(&world, 7U);
    TEST_ASSERT_EQUAL_MEMORY(&rokviss()->world, &world, sizeof world);
}

static void each_body_differs_within_the_bounds(void)
{
    const robot_model_t* nominal = &rokviss()->world.robot[0].model;
    double least                 = 1.0;
    double most                  = 1.0;
    for (uint64_t seed = 1U; seed <= SEEDS; seed++) {
        world                         = rokviss()->world;
        world.robot[0].spread_mass    = 0.02;
        world.robot[0].spread_inertia = 0.05;
        world.robot[0].spread_com     = 0.003;
        spread_apply(&world, seed);
        for (unsigned b = 1U; b <= nominal->joint_count; b++) {
            const robot_mass_t* found  = &world.robot[0].model.body[b];
            const robot_mass_t* wanted = &nominal->body[b];
            const double share         = found->mass_kg / wanted->mass_kg;
            const double wider         = found->inertia_kgm2.at[1][1] / wanted->inertia_kgm2.at[1][1] / share;
            EXPECT_WITHIN(1.0, 0.02, share);
            EXPECT_WITHIN(1.0, 0.05, wider);
            EXPECT_WITHIN(wanted->com_m[2], 0.003, found->com_m[2]);
            least = fmin(least, share);
            most  = fmax(most, share);
        }
    }
    EXPECT_BELOW(0.981, least);
    EXPECT_ABOVE(1.019, most);
}

static void equal_seeds_give_equal_robots_and_unequal_seeds_do_not(void)
{
    world_t again;
    world.robot[0].spread_mass = 0.02;
    again                      = world;
    const world_t nominal      = world;
    spread_apply(&world, 1U);
    spread_apply(&again, 1U);
    TEST_ASSERT_EQUAL_MEMORY(&world, &again, sizeof world);
    again = nominal;
    spread_apply(&again, 2U);
    TEST_ASSERT_TRUE(world.robot[0].model.body[1].mass_kg != again.robot[0].model.body[1].mass_kg);
    TEST_ASSERT_TRUE(world.robot[0].model.body[1].mass_kg / nominal.robot[0].model.body[1].mass_kg !=
                     world.robot[0].model.body[2].mass_kg / nominal.robot[0].model.body[2].mass_kg);
}

/// Range of a true value over many seeds.
typedef struct {
    double least;
    double most;
} range_t;

static void add(range_t* range, const double value)
{
    range->least = fmin(range->least, value);
    range->most  = fmax(range->most, value);
}

/// The range is within +- `most`, and covers nearly all of this interval.
static void expect_range(const range_t* range, const double most)
{
    EXPECT_WITHIN(most, 0.05 * most, range->most);
    EXPECT_WITHIN(-most, 0.05 * most, range->least);
    EXPECT_BELOW(most * (1.0 + 1e-9), fmax(range->most, -range->least));
}

static void drives_wheels_and_cameras_differ_within_their_bounds(void)
{
    range_t friction = {0.0, 0.0};
    range_t bench    = {0.0, 0.0};
    range_t stiff    = {0.0, 0.0};
    range_t gain     = {0.0, 0.0};
    range_t at       = {0.0, 0.0};
    range_t turn     = {0.0, 0.0};
    for (uint64_t seed = 1U; seed <= SEEDS; seed++) {
        world                                = rokviss()->world;
        world.drive_type[0].friction_spread  = 0.2;
        world.drive_type[0].stiffness_spread = 0.1;
        world.bench_count                    = 1U;
        world.wheel_count                    = 2U;
        world.wheel[1].gain_spread           = 0.02;
        world.sensor_count                   = 1U;
        world.sensor[0].at_spread            = 0.001;
        world.sensor[0].rpy_spread           = 0.002;
        world.sensor[0].at[2]                = 0.5;
        spread_apply(&world, seed);
        add(&friction, world.drive[1].difference.friction);
        add(&bench, world.bench[0].difference.friction);
        add(&stiff, world.drive[1].difference.stiffness);
        add(&gain, world.wheel[1].gain_difference);
        add(&at, world.sensor[0].at[2] - 0.5);
        add(&turn, world.sensor[0].rpy[0]);
        TEST_ASSERT_TRUE(world.drive[0].difference.friction != world.drive[1].difference.friction);
        EXPECT_WITHIN(0.0, 0.0, world.wheel[0].gain_difference);
    }
    expect_range(&friction, 0.2);
    expect_range(&bench, 0.2);
    expect_range(&stiff, 0.1);
    expect_range(&gain, 0.02);
    expect_range(&at, 0.001);
    expect_range(&turn, 0.002);
}

static void the_start_of_a_robot_differs_within_its_bounds(void)
{
    const pose_t nominal = pose_of((const double[3]){1.0, 2.0, 3.0}, (const double[3]){0.3, -0.2, 0.1});
    range_t at           = {0.0, 0.0};
    range_t turn         = {0.0, 0.0};
    range_t velocity     = {0.0, 0.0};
    range_t rate         = {0.0, 0.0};
    for (uint64_t seed = 1U; seed <= SEEDS; seed++) {
        world_robot_t* robot   = &world.robot[0];
        world                  = rokviss()->world;
        robot->pose            = nominal;
        robot->velocity_m_s[0] = 0.1;
        robot->spread_start    = (world_start_spread_t){0.05, 0.01, 0.005, 0.02};
        spread_apply(&world, seed);
        double cosine = 0.0; // Cosine of the angle between the x axes.
        for (unsigned k = 0U; k < 3U; k++) {
            cosine += robot->pose.rotation.at[k][0] * nominal.rotation.at[k][0];
        }
        EXPECT_ABOVE(cos(0.0145), cosine); // The deviation has components about two axes.
        add(&turn, acos(fmin(1.0, cosine)));
        add(&at, robot->pose.position_m[1] - 2.0);
        add(&velocity, robot->velocity_m_s[0] - 0.1);
        add(&rate, robot->rate_rad_s[2]);
    }
    expect_range(&at, 0.05);
    expect_range(&velocity, 0.005);
    expect_range(&rate, 0.02);
    EXPECT_ABOVE(0.012, turn.most);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_robot_without_spread_has_exactly_the_values_of_its_file);
    RUN_TEST(each_body_differs_within_the_bounds);
    RUN_TEST(equal_seeds_give_equal_robots_and_unequal_seeds_do_not);
    RUN_TEST(drives_wheels_and_cameras_differ_within_their_bounds);
    RUN_TEST(the_start_of_a_robot_differs_within_its_bounds);
    return UNITY_END();
}
