// SPDX-License-Identifier: Apache-2.0
// A motor on a bench turns freely, presses on an elastic object, and is held by its brake.
#include "sim/plant/motor_bench.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define STEP_S 0.000125

static motor_bench_t bench;

void setUp(void)
{
}

void tearDown(void)
{
}

static void push(double torque_nm, bool brake, double time_s)
{
    for (double at = 0.0; at < time_s; at += STEP_S) {
        motor_bench_step(&bench, brake, torque_nm, STEP_S);
    }
}

static void a_torque_below_friction_moves_nothing(void)
{
    motor_bench_init(&bench, &rokviss()->drive, 0.5, 400.0);
    push(0.5 * rokviss()->drive.coulomb_nm, false, 1.0);
    EXPECT_WITHIN(0.0, 0.0, bench.rotor.position_rad);
    EXPECT_WITHIN(0.0, 0.0, bench.output_torque_nm);
}

static void a_free_rotor_accelerates_by_torque_over_inertia(void)
{
    motor_bench_init(&bench, &rokviss()->drive, 0.5, 400.0);
    push(10.0, false, 0.1);
    // The speed is between the result without friction and the result with permanent static friction.
    const double most  = 10.0 * 0.1 / rokviss()->drive.rotor_inertia_kgm2;
    const double least = (10.0 - rokviss()->drive.stiction_nm - rokviss()->drive.viscous_nms_rad * most) *
                         0.1 / rokviss()->drive.rotor_inertia_kgm2;
    TEST_ASSERT_TRUE(bench.rotor.velocity_rad_s < most);
    TEST_ASSERT_TRUE(bench.rotor.velocity_rad_s > least);
}

static void a_motor_rests_in_balance_with_an_elastic_object(void)
{
    motor_bench_init(&bench, &rokviss()->drive, 0.5, 400.0);
    push(8.0, false, 20.0);
    EXPECT_WITHIN(0.0, 1e-9, bench.rotor.velocity_rad_s);
    TEST_ASSERT_TRUE(bench.rotor.position_rad > 0.5);
    // Motor torque and output torque differ at most by the static friction.
    EXPECT_WITHIN(8.0, rokviss()->drive.stiction_nm + 1e-9, bench.output_torque_nm);
    EXPECT_WITHIN(400.0 * (bench.rotor.position_rad - 0.5), 1e-9, bench.output_torque_nm);
}

static void without_stiffness_there_is_no_contact_force(void)
{
    motor_bench_init(&bench, &rokviss()->drive, 0.5, 0.0);
    push(8.0, false, 5.0);
    // The motor reaches the end stop.
    TEST_ASSERT_TRUE(bench.rotor.position_rad > rokviss()->drive.upper_rad);
    EXPECT_WITHIN(0.0, 0.0, bench.output_torque_nm);
}

static void the_brake_holds_a_squeezed_load(void)
{
    motor_bench_init(&bench, &rokviss()->drive, 0.5, 400.0);
    push(8.0, false, 20.0);
    const double squeezed = bench.rotor.position_rad;
    push(0.0, true, 5.0);
    EXPECT_WITHIN(squeezed, 0.0, bench.rotor.position_rad);
    push(0.0, false, 5.0);
    // When the brake is released, the motor moves back.
    TEST_ASSERT_TRUE(bench.rotor.position_rad < squeezed);
}

static void the_same_forces_give_the_same_octets(void)
{
    double position[2];
    for (unsigned i = 0U; i < 2U; i++) {
        motor_bench_init(&bench, &rokviss()->drive, 0.1, 300.0);
        push(9.0, false, 0.7);
        push(-7.0, false, 0.7);
        position[i] = bench.rotor.position_rad;
    }
    TEST_ASSERT_EQUAL_MEMORY(&position[0], &position[1], sizeof position[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_torque_below_friction_moves_nothing);
    RUN_TEST(a_free_rotor_accelerates_by_torque_over_inertia);
    RUN_TEST(a_motor_rests_in_balance_with_an_elastic_object);
    RUN_TEST(without_stiffness_there_is_no_contact_force);
    RUN_TEST(the_brake_holds_a_squeezed_load);
    RUN_TEST(the_same_forces_give_the_same_octets);
    return UNITY_END();
}
