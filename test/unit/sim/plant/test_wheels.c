// SPDX-License-Identifier: Apache-2.0
// Reaction wheels: momentum and torque with their limits, reaction on their link, and total momentum.
// test_plant_reference.py compares their motion with MuJoCo.
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "test/unit/sim/plant/plant_state.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define STEP_NS 500000U
#define LINK(name, xyz, mass, inertia)                                                                       \
    "<link name=\"" name "\"><inertial><origin xyz=\"" xyz "\"/><mass value=\"" mass "\"/><inertia " inertia \
    "/></inertial></link>\n"
#define BODY "ixx=\"75\" ixy=\"1.5\" ixz=\"-2\" iyy=\"88\" iyz=\"1\" izz=\"82\""
#define ROUND "ixx=\"10\" ixy=\"0\" ixz=\"0\" iyy=\"10\" iyz=\"0\" izz=\"10\""
#define ARM "ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.8\" iyz=\"0\" izz=\"0.8\""
#define HINGE                                                                                                \
    "<joint name=\"hinge\" type=\"continuous\"><origin xyz=\"0.6 0 0\"/><parent link=\"base\"/>"             \
    "<child link=\"arm\"/><axis xyz=\"0 1 0\"/></joint>\n"
#define IN_WORLD(text) "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\">\n" text "</World>\n"
#define WHEEL(name, on, axis, node, more)                                                                    \
    "<Wheel name=\"" name "\" on=\"" on "\" axis=\"" axis                                                    \
    "\" momentum=\"12\" torque=\"0.22\" bus=\"b\" node=\"" node "\" eds=\"wheel.eds\" " more "/>\n"

static world_t world;
static plant_t* plant;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    input = (plant_input_t){0};
    (void)temporary_file("body.urdf", "<robot name=\"b\">\n" LINK("base", "0.02 -0.01 0.03", "350", BODY)
                                          LINK("arm", "0.5 0 0", "17", ARM) HINGE "</robot>\n");
    (void)temporary_file("round.urdf",
                         "<robot name=\"r\">\n" LINK("base", "0 0 0", "100", ROUND) "</robot>\n");
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static const plant_truth_t* begin(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    return plant_truth(plant);
}

static void run(unsigned steps)
{
    for (unsigned i = 0U; i < steps; i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

static void a_wheel_turns_its_link_the_other_way(void)
{
    const plant_truth_t* truth = begin(IN_WORLD(
        "<Robot name=\"s\" urdf=\"round.urdf\" base=\"free\"/>\n" WHEEL("W", "s.base", "0 0 5", "11", "")));
    input.wheel_torque_nm[0]   = 0.1;
    run(2000U);
    EXPECT_WITHIN(0.1, 1e-12, truth->wheel[0].momentum_nms);
    EXPECT_WITHIN(0.1, 1e-12, truth->wheel[0].torque_nm);
    EXPECT_WITHIN(-0.01, 1e-12, truth->base[0].rate_rad_s[2]);
    EXPECT_WITHIN(-0.01, 1e-12, truth->wheel[0].housing_rad_s);
    input.wheel_torque_nm[0] = -0.1;
    run(2000U);
    EXPECT_WITHIN(0.0, 1e-12, truth->base[0].rate_rad_s[2]);
}

static void the_gain_of_a_wheel_may_differ(void)
{
    const plant_truth_t* truth     = begin(IN_WORLD(
            "<Robot name=\"s\" urdf=\"round.urdf\" base=\"free\"/>\n" WHEEL("W", "s.base", "0 0 5", "11", "")));
    world.wheel[0].gain_difference = -0.02;
    input.wheel_torque_nm[0]       = 0.1;
    run(1U);
    EXPECT_WITHIN(0.098, 1e-12, truth->wheel[0].torque_nm);
    input.wheel_torque_nm[0]       = 5.0;
    world.wheel[0].gain_difference = 0.02;
    run(1U);
    // The limit of the torque does not change with the gain.
    EXPECT_WITHIN(0.22, 1e-12, truth->wheel[0].torque_nm);
}

static void a_wheel_stays_at_its_limits_of_torque_and_momentum(void)
{
    const plant_truth_t* truth =
        begin(IN_WORLD("<Robot name=\"s\" urdf=\"round.urdf\" base=\"free\"/>\n" WHEEL(
            "W", "s.base", "0 0 1", "11", "start=\"11.9\"")));
    EXPECT_WITHIN(11.9, 0.0, truth->wheel[0].momentum_nms);
    input.wheel_torque_nm[0] = 5.0;
    run(1U);
    EXPECT_WITHIN(0.22, 1e-9, truth->wheel[0].torque_nm);
    run(2000U);
    EXPECT_WITHIN(12.0, 0.0, truth->wheel[0].momentum_nms);
    EXPECT_WITHIN(0.0, 0.0, truth->wheel[0].torque_nm);
    EXPECT_WITHIN(-0.01, 1e-12, truth->base[0].rate_rad_s[2]);
    input.wheel_torque_nm[0] = -5.0;
    run(1U);
    EXPECT_WITHIN(-0.22, 1e-9, truth->wheel[0].torque_nm);
    EXPECT_WITHIN(12.0 - 0.22 * 5e-4, 1e-12, truth->wheel[0].momentum_nms);
}

/// A body of equal moments I has a wheel of momentum h along z, and a rate across it: its angular momentum L
/// is constant in the world, and z turns about it with |L| / I.
static void a_spinning_wheel_makes_its_link_precess(void)
{
    const plant_truth_t* truth = begin(IN_WORLD(
        "<Robot name=\"s\" urdf=\"round.urdf\" base=\"free\"><State rate=\"0.05 0 0\"/></Robot>\n" WHEEL(
            "W", "s.base", "0 0 1", "11", "start=\"2\"")));
    const double momentum[3]   = {0.5, 0.0, 2.0};
    const double length        = sqrt(0.25 + 4.0);
    run(20000U);
    double axis[3];
    wheel_axis(plant, 0U, axis);
    // The axis of the wheel, (0, 0, 1), turned about the momentum by the angle |L| t / I; t = 10 s, I = 10
    // kgm2.
    const double angle     = length * 10.0 / 10.0;
    const double n[3]      = {momentum[0] / length, 0.0, momentum[2] / length};
    const double cosine    = cos(angle);
    const double wanted[3] = {n[2] * n[0] * (1.0 - cosine), -n[0] * sin(angle),
                              cosine + n[2] * n[2] * (1.0 - cosine)};
    for (unsigned k = 0U; k < 3U; k++) {
        EXPECT_WITHIN(wanted[k], 2e-4, axis[k]);
    }
    EXPECT_WITHIN(2.0, 0.0, truth->wheel[0].momentum_nms);
    EXPECT_WITHIN(0.05, 1e-5,
                  sqrt(pow(truth->base[0].rate_rad_s[0], 2) + pow(truth->base[0].rate_rad_s[1], 2) +
                       pow(truth->base[0].rate_rad_s[2], 2)));
}

static void swing(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    const double time_s = ((double)plant_truth(plant)->time_ns + substep * STEP_NS / 4.0) * 1e-9;
    out_torque_nm[0] =
        5.0 * (0.5 * (1.0 - cos(0.7 * time_s)) - motor[0].position_rad) - 10.0 * motor[0].velocity_rad_s;
}

/// Expect that linear and angular momentum are constant for 60 s. The wheels accelerate and brake; one of
/// them reaches its limit.
static void expect_momentum_conserved(const char* text)
{
    double p0[3];
    double l0[3];
    double worst_p             = 0.0;
    double worst_l             = 0.0;
    const plant_truth_t* truth = begin(text);
    double most_rate           = 0.0;
    double most_h              = 0.0;
    plant_momentum(plant, p0, l0);
    input.drive = swing;
    for (unsigned step = 0U; step < 120000U; step++) {
        double p[3];
        double l[3];
        const double time_s = (double)truth->time_ns * 1e-9;
        for (unsigned i = 0U; i < 3U; i++) {
            input.wheel_torque_nm[i] = 0.2 * sin((0.2 + 0.1 * i) * time_s + i);
        }
        input.wheel_torque_nm[3] = 1.0;
        plant_step(plant, &input, STEP_NS);
        plant_momentum(plant, p, l);
        for (unsigned i = 0U; i < 3U; i++) {
            worst_p = fmax(worst_p, fabs(p[i] - p0[i]));
            worst_l = fmax(worst_l, fabs(l[i] - l0[i]));
        }
        for (unsigned i = 0U; i < 3U; i++) {
            most_rate = fmax(most_rate, fabs(truth->base[0].rate_rad_s[i]));
        }
        most_h = fmax(most_h, fabs(truth->wheel[3].momentum_nms));
    }
    printf("60 s: %.1e Ns, %.1e Nms, up to %.2f rad/s\n", worst_p, worst_l, most_rate);
    EXPECT_WITHIN(12.0, 0.0, most_h);
    EXPECT_ABOVE(0.05, most_rate);
    EXPECT_BELOW(1e-12, worst_p);
    EXPECT_BELOW(1e-6, worst_l);
}

static void momentum_is_conserved_while_wheels_spin(void)
{
    expect_momentum_conserved(IN_WORLD(
        "<Robot name=\"s\" urdf=\"body.urdf\" base=\"free\"><State rate=\"0.02 -0.01 "
        "0.03\"/></Robot>\n" WHEEL("A", "s.base", "1 1 1", "11", "start=\"3\"")
            WHEEL("B", "s.base", "-1 1 1", "12", "start=\"-5\"") WHEEL("C", "s.base", "-1 -1 1", "13", "")
                WHEEL("D", "s.base", "1 -1 1", "14", "start=\"8\"")));
}

static void momentum_is_conserved_with_a_wheel_on_an_arm(void)
{
    expect_momentum_conserved(
        IN_WORLD("<Robot name=\"s\" urdf=\"body.urdf\" base=\"free\"><State rate=\"0.02 -0.01 "
                 "0.05\"/></Robot>\n" WHEEL("A", "s.base", "1 0 0", "11", "start=\"3\"")
                     WHEEL("B", "s.arm", "0 0 1", "12", "start=\"-5\"") WHEEL("C", "s.arm", "1 0 0", "13", "")
                         WHEEL("D", "s.base", "0 1 0", "14", "start=\"8\"")));
}

static void a_wheel_on_a_fixed_link_only_spins(void)
{
    const plant_truth_t* truth =
        begin(IN_WORLD("<Robot name=\"s\" urdf=\"body.urdf\" base=\"fixed\"><State rpy=\"0 0 "
                       "1.5707963267948966\"/></Robot>\n" WHEEL("W", "s.base", "1 0 0", "11", "")));
    double axis[3];
    input.wheel_torque_nm[0] = 0.1;
    run(2000U);
    wheel_axis(plant, 0U, axis);
    EXPECT_WITHIN(1.0, 1e-12, axis[1]);
    EXPECT_WITHIN(0.1, 1e-12, truth->wheel[0].momentum_nms);
    EXPECT_WITHIN(0.0, 0.0, truth->link_position_rad[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_wheel_turns_its_link_the_other_way);
    RUN_TEST(the_gain_of_a_wheel_may_differ);
    RUN_TEST(a_wheel_stays_at_its_limits_of_torque_and_momentum);
    RUN_TEST(a_spinning_wheel_makes_its_link_precess);
    RUN_TEST(momentum_is_conserved_while_wheels_spin);
    RUN_TEST(momentum_is_conserved_with_a_wheel_on_an_arm);
    RUN_TEST(a_wheel_on_a_fixed_link_only_spins);
    return UNITY_END();
}
