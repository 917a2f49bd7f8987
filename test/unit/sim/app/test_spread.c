// SPDX-License-Identifier: Apache-2.0
// The true parameters of robots: drawn by the seed within their bounds, and only where the world allows it.
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

static void a_robot_without_spread_keeps_its_bits(void)
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

static void a_seed_gives_the_same_again_and_another_seed_does_not(void)
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_robot_without_spread_keeps_its_bits);
    RUN_TEST(each_body_differs_within_the_bounds);
    RUN_TEST(a_seed_gives_the_same_again_and_another_seed_does_not);
    return UNITY_END();
}
