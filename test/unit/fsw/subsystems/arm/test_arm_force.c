// SPDX-License-Identifier: Apache-2.0
// The force on the tool, estimated from the torques of the joints, with torques of a known force.
#include "fsw/subsystems/arm/arm_force.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_S 0.001
#define RATE_RAD_S 3.0
#define AMPLITUDE_RAD 0.1

static arm_model_t model;
static arm_limits_t limits;
static arm_control_t control;
static arm_force_t force;
static arm_setup_t setup;

void setUp(void)
{
    rig_model(&model, &limits);
    setup   = (arm_setup_t){.model = &model, .parameters = &rig_arm.parameters, .period_s = PERIOD_S};
    control = (arm_control_t){.is_started = true};
    arm_force_init(&force);
}

void tearDown(void)
{
}

/// The values that the sensors have while the arm moves and a force acts on its tool.
static void show(const arm_motion_t* const motion, const arm_vector_t force_n, const double* const offset_nm)
{
    arm_jacobian_t jacobian;
    arm_inverse_dynamics(&model, motion, control.torque_nm);
    arm_kinematics(&model, motion->position_rad, &control.kinematics);
    arm_jacobian(&model, &control.kinematics, &jacobian);
    for (unsigned i = 0U; i < model.joint_count; i++) {
        control.link_rad[i] = motion->position_rad[i];
        control.torque_nm[i] += (offset_nm != NULL) ? offset_nm[i] : 0.0;
        for (unsigned k = 0U; k < 3U; k++) {
            control.torque_nm[i] -= jacobian.at[k][i] * force_n.at[k];
        }
    }
}

static void sense_at_rest(const arm_vector_t force_n, const double* const offset_nm, const bool is_at_rest,
                          const unsigned steps)
{
    arm_motion_t motion = {.position_rad = {0.0}};
    memcpy(motion.position_rad, rig_pose_rad, sizeof rig_pose_rad);
    show(&motion, force_n, offset_nm);
    for (unsigned i = 0U; i < steps; i++) {
        arm_force_sense(&force, &setup, &control, is_at_rest);
    }
}

static void expect_force(const arm_vector_t expected_n, const double tolerance_n)
{
    for (unsigned k = 0U; k < 3U; k++) {
        EXPECT_WITHIN(expected_n.at[k], tolerance_n, force.force_n.at[k]);
    }
}

static void a_force_on_the_tool_is_measured(void)
{
    const arm_vector_t pushed_n = {{3.0, -5.0, 20.0}};
    sense_at_rest(pushed_n, NULL, false, 1U); // The filter starts with the first sample.
    expect_force(pushed_n, 0.2);              // The damping makes the estimate up to 1 % smaller.
    const arm_vector_t none_n = {{0.0}};
    sense_at_rest(none_n, NULL, false, 17U); // One time constant of the low-pass.
    EXPECT_ABOVE(10.0, force.force_n.at[2]);
    sense_at_rest(none_n, NULL, false, 500U);
    expect_force(none_n, 1.0e-6);
}

/// The torque that accelerates the arm is not reported as an external force.
static void an_arm_that_moves_in_free_space_measures_no_force(void)
{
    const arm_vector_t none_n = {{0.0}};
    double largest_n          = 0.0;
    double largest_nm         = 0.0;
    for (unsigned step = 0U; step < 4000U; step++) {
        const double phase  = RATE_RAD_S * PERIOD_S * (double)step;
        arm_motion_t motion = {.position_rad = {0.0}};
        arm_motion_t still  = {.position_rad = {0.0}};
        double weight_nm[ARM_JOINTS_MAX];
        for (unsigned i = 0U; i < RIG_JOINTS; i++) {
            motion.position_rad[i]        = rig_pose_rad[i] + (AMPLITUDE_RAD * sin(phase));
            motion.velocity_rad_s[i]      = AMPLITUDE_RAD * RATE_RAD_S * cos(phase);
            motion.acceleration_rad_s2[i] = -AMPLITUDE_RAD * RATE_RAD_S * RATE_RAD_S * sin(phase);
            still.position_rad[i]         = motion.position_rad[i];
        }
        show(&motion, none_n, NULL);
        arm_inverse_dynamics(&model, &still, weight_nm);
        arm_force_sense(&force, &setup, &control, false);
        if (step > 1000U) {
            largest_n  = fmax(largest_n, arm_length(force.force_n));
            largest_nm = fmax(largest_nm, fabs(control.torque_nm[1] - weight_nm[1]));
        }
    }
    EXPECT_ABOVE(1.0, largest_nm); // The torque of the motion is large enough for a test.
    EXPECT_BELOW(0.1, largest_n);
}

static void offsets_of_the_sensors_are_learned_at_rest(void)
{
    static const double offset_nm[RIG_JOINTS] = {0.7, -0.7, 0.5, 0.1, -0.1, 0.1};
    const arm_vector_t none_n                 = {{0.0}};
    const arm_vector_t pushed_n               = {{0.0, 0.0, 10.0}};
    sense_at_rest(none_n, offset_nm, false, 10U);
    EXPECT_ABOVE(0.5, arm_length(force.force_n));
    sense_at_rest(none_n, offset_nm, true, 2000U);
    expect_force(none_n, 1.0e-3);
    EXPECT_WITHIN(-0.7, 1.0e-3, force.zero_nm[1]);
    sense_at_rest(pushed_n, offset_nm, false, 1000U);
    expect_force(pushed_n, 0.1);
}

/// TARE_LIMIT is 2 % of the torque limit: 3 Nm for joints 1 to 3, 0.56 Nm for joints 4 to 6.
static void a_contact_is_not_taken_for_an_offset(void)
{
    const arm_vector_t pushed_n = {{0.0, 0.0, 60.0}};
    sense_at_rest(pushed_n, NULL, true, 2000U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_BELOW((0.02 * rig_arm.parameters.limits.torque[i]) + 1.0e-9, fabs(force.zero_nm[i]));
    }
    EXPECT_ABOVE(40.0, force.force_n.at[2]);
}

/// Two joints with axes that intersect: only some directions have a lever.
static void directions_without_a_lever_stay_finite(void)
{
    const arm_vector_t pushed_n = {{5.0, 5.0, 5.0}};
    model.joint_count           = 2U;
    sense_at_rest(pushed_n, NULL, false, 1U);
    EXPECT_BELOW(10.0, arm_length(force.force_n));
    EXPECT_ABOVE(1.0, arm_length(force.force_n));
}

int main(void)
{
    UNITY_BEGIN();
    rig_load();
    RUN_TEST(a_force_on_the_tool_is_measured);
    RUN_TEST(an_arm_that_moves_in_free_space_measures_no_force);
    RUN_TEST(offsets_of_the_sensors_are_learned_at_rest);
    RUN_TEST(a_contact_is_not_taken_for_an_offset);
    RUN_TEST(directions_without_a_lever_stay_finite);
    return UNITY_END();
}
