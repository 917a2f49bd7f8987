// SPDX-License-Identifier: Apache-2.0
// The control law computes values of the joints of the arm and no others; test_arm.c and test_arm_force.c
// test the values themselves.
#include "test/unit/fsw/subsystems/arm/arm_rig.h"
#include "unity.h"

#include <string.h>

#define PERIOD_S 0.001
#define KEPT 123.0 ///< A value that no computation gives.

static arm_model_t model;
static arm_limits_t limits;
static arm_control_t control;
static arm_setup_t setup;

void setUp(void)
{
    rig_model(&model, &limits);
    setup = (arm_setup_t){.model = &model, .parameters = &rig_arm.parameters, .period_s = PERIOD_S};
    arm_control_init(&control);
}

void tearDown(void)
{
}

/// Get the addresses after the last joint in the arrays of the control law.
static void values_after(double* out_values[], const unsigned joint)
{
    double* const values[] = {
        &control.motor_rad[joint],        &control.torque_nm[joint],       &control.link_rad[joint],
        &control.motor[joint].velocity,   &control.offset_rad[joint],      &control.bias_nm[joint],
        &control.motor_target_rad[joint], &control.feed_forward_nm[joint], &control.command_nm[joint]};
    (void)memcpy(out_values, values, sizeof values);
}

/// Messages for values_after, in the same order.
static const char* const after_names[9] = {
    "motor_rad after the last joint was changed",        "torque_nm after the last joint was changed",
    "link_rad after the last joint was changed",         "motor.velocity after the last joint was changed",
    "offset_rad after the last joint was changed",       "bias_nm after the last joint was changed",
    "motor_target_rad after the last joint was changed", "feed_forward_nm after the last joint was changed",
    "command_nm after the last joint was changed"};

static void values_after_the_last_joint_are_unchanged(void)
{
    double* after[9];
    arm_motion_t motion                    = {.position_rad = {0.0}};
    const double motor_rad[ARM_JOINTS_MAX] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
    const double torque_nm[ARM_JOINTS_MAX] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
    values_after(after, RIG_JOINTS);
    for (unsigned i = 0U; i < 9U; i++) {
        *after[i] = KEPT;
    }
    (void)memcpy(motion.position_rad, rig_pose_rad, sizeof rig_pose_rad);
    arm_control_sense(&control, &setup, motor_rad, torque_nm);
    arm_control_hold(&control, &setup);
    arm_control_step(&control, &setup, &motion);
    arm_control_comply(&control, &setup, &motion);
    arm_control_sense(&control, &setup, motor_rad, torque_nm);
    for (unsigned i = 0U; i < 9U; i++) {
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(KEPT, *after[i], after_names[i]);
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.6, control.motor_rad[RIG_JOINTS - 1U]);
    TEST_ASSERT_TRUE(control.command_nm[RIG_JOINTS - 1U] != 0.0);
}

int main(void)
{
    rig_load();
    UNITY_BEGIN();
    RUN_TEST(values_after_the_last_joint_are_unchanged);
    return UNITY_END();
}
