// SPDX-License-Identifier: Apache-2.0
// Compares kinematics and dynamics with closed formulas and difference quotients. test_arm_against_mujoco.py
// compares them with MuJoCo.
#include "fsw/subsystems/arm/arm_model.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

static arm_model_t model;
static arm_limits_t limits;

void setUp(void)
{
    rig_model(&model, &limits);
}

void tearDown(void)
{
}

/// Returns two rods of 1 kg and 1 m about y in a vertical plane: the textbook's double pendulum, hanging
/// along x.
static arm_model_t double_pendulum(void)
{
    arm_model_t pendulum = {.joint_count = 2U, .gravity_m_s2 = {{0.0, 0.0, -9.81}}};
    for (unsigned i = 0U; i < 2U; i++) {
        pendulum.link[i] =
            (arm_link_t){.origin       = {.rotation   = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}},
                                          .position_m = {{(i == 0U) ? 0.0 : 1.0, 0.0, 0.0}}},
                         .axis         = {{0.0, -1.0, 0.0}},
                         .mass_kg      = 1.0,
                         .centre_m     = {{0.5, 0.0, 0.0}},
                         .inertia_kgm2 = {{{0.0, 0.0, 0.0}, {0.0, 1.0 / 12.0, 0.0}, {0.0, 0.0, 1.0 / 12.0}}}};
    }
    pendulum.tool = pendulum.link[1].origin;
    return pendulum;
}

static void a_double_pendulum_needs_the_torques_of_the_textbook(void)
{
    const arm_model_t pendulum = double_pendulum();
    const arm_motion_t motion  = {
         .position_rad = {0.4, 0.7}, .velocity_rad_s = {1.1, -0.6}, .acceleration_rad_s2 = {2.0, 3.0}};
    double torque[ARM_JOINTS_MAX];
    arm_inverse_dynamics(&pendulum, &motion, torque);
    const double g   = 9.81;
    const double m11 = (1.0 / 3.0) + 1.0 + (1.0 / 3.0) + cos(0.7);
    const double m12 = (1.0 / 3.0) + (0.5 * cos(0.7));
    const double m22 = 1.0 / 3.0;
    const double h   = 0.5 * sin(0.7);
    const double c1  = -h * ((2.0 * 1.1 * -0.6) + (0.6 * 0.6));
    const double c2  = h * 1.1 * 1.1;
    const double g2  = 0.5 * g * cos(1.1);
    const double g1  = (1.5 * g * cos(0.4)) + g2;
    EXPECT_WITHIN((m11 * 2.0) + (m12 * 3.0) + c1 + g1, 1.0e-13, torque[0]);
    EXPECT_WITHIN((m12 * 2.0) + (m22 * 3.0) + c2 + g2, 1.0e-13, torque[1]);
}

/// A mass of 2 kg on a linear axis, which turns in a plane in which gravity acts. The formulas are those of
/// polar coordinates.
static void a_linear_axis_that_turns_needs_the_forces_of_the_textbook(void)
{
    arm_model_t polar          = double_pendulum();
    polar.link[0].mass_kg      = 0.0;
    polar.link[0].inertia_kgm2 = (arm_rotation_t){{{0.0}}};
    polar.link[1] = (arm_link_t){.origin = {.rotation = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}},
                                            .position_m = {{0.3, 0.0, 0.0}}},
                                 .axis   = {{1.0, 0.0, 0.0}},
                                 .mass_kg      = 2.0,
                                 .is_prismatic = true};
    const arm_motion_t motion = {
        .position_rad = {0.4, 0.2}, .velocity_rad_s = {1.1, -0.6}, .acceleration_rad_s2 = {2.0, 3.0}};
    double effort[ARM_JOINTS_MAX];
    arm_inverse_dynamics(&polar, &motion, effort);
    const double radius = 0.3 + 0.2;
    EXPECT_WITHIN(2.0 * ((radius * radius * 2.0) + (2.0 * radius * 1.1 * -0.6) + (9.81 * radius * cos(0.4))),
                  1.0e-13, effort[0]);
    EXPECT_WITHIN(2.0 * ((3.0 - (radius * 1.1 * 1.1)) + (9.81 * sin(0.4))), 1.0e-13, effort[1]);
}

/// According to the data sheet, the flange of the arm in its zero pose is at (-0.8172, -0.2329, 0.0628).
static void the_tool_of_the_six_joint_arm_has_the_position_of_the_data_sheet(void)
{
    const double zero[ARM_JOINTS_MAX] = {0.0};
    arm_kinematics_t kinematics;
    arm_kinematics(&model, zero, &kinematics);
    EXPECT_WITHIN(-0.8172, 1.0e-9, kinematics.tool.position_m.at[0]);
    EXPECT_WITHIN(-0.2329 - 0.12, 1.0e-9, kinematics.tool.position_m.at[1]); // The tool is the gripper.
    EXPECT_WITHIN(0.0628, 1.0e-9, kinematics.tool.position_m.at[2]);
}

static void expect_jacobian(const bool is_third_prismatic)
{
    const double h = 1.0e-6;
    arm_kinematics_t here;
    arm_jacobian_t jacobian;
    double pose[ARM_JOINTS_MAX] = {0.0};
    memcpy(pose, rig_pose_rad, sizeof rig_pose_rad);
    model.link[2].is_prismatic = is_third_prismatic;
    arm_kinematics(&model, pose, &here);
    arm_jacobian(&model, &here, &jacobian);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        arm_kinematics_t there;
        pose[i] += h;
        arm_kinematics(&model, pose, &there);
        pose[i] -= h;
        const arm_vector_t turn = arm_rotation_between(&here.tool.rotation, &there.tool.rotation);
        for (unsigned k = 0U; k < 3U; k++) {
            EXPECT_WITHIN((there.tool.position_m.at[k] - here.tool.position_m.at[k]) / h, 1.0e-6,
                          jacobian.at[k][i]);
            EXPECT_WITHIN(turn.at[k] / h, 1.0e-6, jacobian.at[k + 3U][i]);
        }
    }
}

static void the_jacobian_is_the_difference_quotient_of_the_pose(void)
{
    expect_jacobian(false);
    expect_jacobian(true);
}

int main(void)
{
    UNITY_BEGIN();
    rig_load();
    RUN_TEST(a_double_pendulum_needs_the_torques_of_the_textbook);
    RUN_TEST(a_linear_axis_that_turns_needs_the_forces_of_the_textbook);
    RUN_TEST(the_tool_of_the_six_joint_arm_has_the_position_of_the_data_sheet);
    RUN_TEST(the_jacobian_is_the_difference_quotient_of_the_pose);
    return UNITY_END();
}
