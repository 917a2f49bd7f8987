// SPDX-License-Identifier: Apache-2.0
// The subsystem arm with the descriptor of a six-joint arm: commissioning, motions, refusals, telemetry.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOTION_ENDED 3U // Event MOTION_ENDED of the descriptor.

void setUp(void)
{
    rig_set_up();
}

void tearDown(void)
{
    rig_tear_down();
}

static double target_rad(const unsigned joint)
{
    return 1.0e-6 * (double)rig_joints[joint]->target_position;
}

/// Returns the desired pose of the tool, shifted.
static rig_line_to_t line_by(const double x, const double y, const double z)
{
    static const arm_rotation_t none = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    arm_kinematics_t kinematics;
    arm_kinematics(&rig_arm.model, rig_arm.motion.position_rad, &kinematics);
    const arm_vector_t rotation = arm_rotation_between(&none, &kinematics.tool.rotation);
    const arm_vector_t goal     = arm_sum(kinematics.tool.position_m, (arm_vector_t){{x, y, z}});
    return (rig_line_to_t){.position = {goal.at[0], goal.at[1], goal.at[2]},
                           .rotation = {rotation.at[0], rotation.at[1], rotation.at[2]},
                           .share    = 1.0};
}

static void idle_until_a_result(const unsigned cycles)
{
    for (unsigned i = 0U; (i < cycles) && (rig_generic.result_count == 0U); i++) {
        (void)rig_cycle(NULL);
    }
}

static void engaging_makes_no_step(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    rig_idle(3U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        TEST_ASSERT_INT32_WITHIN(30, rig_joints[i]->position[0], rig_joints[i]->target_position);
        TEST_ASSERT_INT16_WITHIN(10, rig_joints[i]->torque[0], rig_joints[i]->torque_offset);
    }
}

static void in_torque_mode_the_arm_carries_its_weight(void)
{
    rig_bring(RIG_TORQUE, STATE_OPERATIONAL);
    rig_idle(2000U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        TEST_ASSERT_EQUAL_UINT(2U, rig_joints[i]->last_pdo);
        TEST_ASSERT_INT16_WITHIN(30, rig_joints[i]->torque[0], rig_joints[i]->target_torque[0]);
    }
    TEST_ASSERT_TRUE(abs(rig_joints[1]->torque[0]) > 500); // The torque carries a weight.
}

static void move_to_reaches_the_target_and_completes_its_command(void)
{
    const rig_move_to_t to = {.position = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.5};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_TO, &to, 9U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_MOVE_TO, &to, 10U));
    idle_until_a_result(4000U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_UINT32(9U, rig_generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    rig_idle(3000U); // The error from engaging decays.
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(to.position[i], 0.01, target_rad(i)); // The difference is the deflection of the gear.
        EXPECT_WITHIN(to.position[i], 1.0e-12, rig_arm.parameters.cur_values.desired_rad[i]);
    }
}

/// The last argument of both motions is their share of the limits.
static void the_duration_of_a_motion_follows_from_its_share_of_the_limits(void)
{
    const rig_move_to_t to      = {.position = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.37};
    double goal[ARM_JOINTS_MAX] = {0.0};
    arm_path_t path;
    memcpy(goal, to.position, sizeof to.position);
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    rig_line_to_t line   = line_by(0.05, 0.1, 0.05);
    line.share           = 0.37;
    const arm_pose_t end = {.rotation   = rig_arm.control.kinematics.tool.rotation,
                            .position_m = arm_vector(line.position)};
    arm_path_begin_line(&path, &rig_arm.model, &rig_arm.limits, &rig_arm.motion, &end, 0.37);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &line, 5U));
    EXPECT_WITHIN(arm_path_duration_s(&path), 1.0e-9, arm_path_duration_s(&rig_arm.line));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 6U));
    (void)arm_path_begin_joints(&path, &rig_arm.model, &rig_arm.limits, &rig_arm.motion, goal, 0.37);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_TO, &to, 7U));
    EXPECT_WITHIN(arm_path_duration_s(&path), 1.0e-9, arm_path_duration_s(&rig_arm.path));
}

static void a_value_outside_its_range_is_refused_with_its_joint(void)
{
    rig_move_to_t to = {.position = {0.3, -1.2, 7.0, -1.3, -1.4, 0.5}, .share = 0.5};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_MOVE_TO, &to, 9U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 1U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(3U, rig_generic.results[0].detail);
    to.position[2] = (double)NAN;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_MOVE_TO, &to, 10U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rig_perform(99U, &to, 11U));
}

static void a_line_that_is_too_fast_is_refused_with_the_joint(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    rig_arm.parameters.limits.speed[1] = 0.001;
    rig_generic.callbacks->parameter_set(&rig_arm, 0U);
    const rig_line_to_t to = line_by(0.0, 0.0, 0.05);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &to, 5U));
    idle_until_a_result(200U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 2U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(2U, rig_generic.results[0].detail);
}

static void out_of_operation_the_arm_does_not_move(void)
{
    const rig_move_to_t to = {.position = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.5};
    rig_bring(RIG_POSITION, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_MOVE_TO, &to, 9U));
}

/// With stiffness 0 the angles of motor and link are equal.
static void a_rigid_gear_does_not_deflect(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        rig_arm.parameters.drives.stiffness[i] = 0.0;
    }
    rig_idle(4000U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(rig_arm.motion.position_rad[i], 1.0e-6, target_rad(i));
    }
}

static void a_line_is_checked_then_followed(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    const rig_line_to_t to = line_by(0.05, 0.1, 0.05);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &to, 5U));
    const double before = rig_arm.motion.position_rad[0];
    rig_idle(20U);
    EXPECT_WITHIN(before, 1.0e-12, rig_arm.motion.position_rad[0]); // During the check the arm does not move.
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_LINE_TO, &to, 6U));
    idle_until_a_result(4000U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    arm_kinematics_t kinematics;
    arm_kinematics(&rig_arm.model, rig_arm.motion.position_rad, &kinematics);
    for (unsigned k = 0U; k < 3U; k++) {
        EXPECT_WITHIN(to.position[k], 1.0e-9, kinematics.tool.position_m.at[k]);
    }
}

/// The line has ended: limits that become narrower afterwards do not affect it.
static void an_arm_at_rest_after_a_line_is_not_checked(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    const rig_line_to_t to = line_by(0.02, 0.03, 0.02);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &to, 5U));
    idle_until_a_result(4000U);
    rig_arm.parameters.limits.upper[0] = rig_arm.motion.position_rad[0] - 0.001;
    rig_generic.callbacks->parameter_set(&rig_arm, 0U);
    rig_idle(10U);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&rig_generic, MOTION_ENDED));
}

static void a_line_out_of_reach_is_refused_without_motion(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    const double before    = rig_arm.motion.position_rad[1];
    const rig_line_to_t to = line_by(-2.0, 0.0, 0.0);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &to, 5U));
    idle_until_a_result(200U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 3U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_generic.results[0].detail);
    EXPECT_WITHIN(before, 1.0e-12, rig_arm.motion.position_rad[1]);
    const rig_line_to_t nearer = line_by(0.02, 0.0, 0.0);
    // The arm accepts the next command.
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &nearer, 6U));
}

/// The limits become narrower during the motion: the arm brakes, reports the reason, and accepts the next
/// command.
static void an_arm_that_must_leave_its_line_brakes_and_reports_the_reason(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    const rig_line_to_t to = line_by(0.1, 0.15, 0.1);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &to, 5U));
    rig_idle(500U);
    TEST_ASSERT_TRUE(fabs(rig_arm.motion.velocity_rad_s[0]) > 0.01);
    rig_arm.parameters.limits.upper[0] = rig_arm.motion.position_rad[0] + 0.001;
    rig_arm.parameters.limits.lower[0] = rig_arm.motion.position_rad[0] - 0.001;
    rig_generic.callbacks->parameter_set(&rig_arm, 0U);
    idle_until_a_result(2000U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MOTION_ENDED));
    const double_event_t* const event = double_last_event(&rig_generic, MOTION_ENDED);
    TEST_ASSERT_EQUAL_UINT8(ARM_REFUSAL_POSITION, event->octets[0]);
    TEST_ASSERT_EQUAL_UINT8(1U, event->octets[1]);
    EXPECT_WITHIN(0.0, 1.0e-9, rig_arm.motion.velocity_rad_s[0]);
}

static void stop_ends_a_motion_and_the_check_of_a_line(void)
{
    rig_bring(RIG_POSITION, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_STOP, NULL, 1U));
    rig_generic.state = STATE_OPERATIONAL;
    while (rig_cycle(rig_generic.callbacks->engage) == STATUS_BUSY) {
    }
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 1U)); // The arm is already at rest.
    const rig_line_to_t line = line_by(0.02, 0.0, 0.0);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_TO, &line, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 3U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_generic.result_count = 0U;
    const rig_move_to_t to   = {.position = {1.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.5};
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_TO, &to, 4U));
    rig_idle(400U);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 5U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 6U));
    idle_until_a_result(2000U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    TEST_ASSERT_TRUE(rig_arm.motion.position_rad[0] < 1.0);
    EXPECT_WITHIN(0.0, 1.0e-12, rig_arm.motion.velocity_rad_s[0]);
}

static void leaving_operation_aborts_a_motion(void)
{
    const rig_move_to_t to = {.position = {1.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.5};
    rig_bring(RIG_TORQUE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_TO, &to, 4U));
    rig_idle(100U);
    rig_arm.motion.position_rad[RIG_JOINTS] = 77.0; // The element after the last joint.
    rig_generic.state                       = STATE_SAFE_OPERATIONAL;
    (void)rig_cycle(rig_generic.callbacks->disengage);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_idle(10U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count); // The command is completed once.
    EXPECT_WITHIN(rig_pose_rad[0], 1.0e-4, rig_arm.motion.position_rad[0]);
    TEST_ASSERT_TRUE(rig_arm.motion.position_rad[RIG_JOINTS] == 77.0);
}

/// The tool is pushed 10 mm aside: the joint torques change by the transposed Jacobian times 10 N.
static void a_compliant_tool_pushes_back_like_a_spring(void)
{
    double pushed_rad[RIG_JOINTS];
    arm_jacobian_t jacobian;
    arm_kinematics_t before;
    int16_t weight[RIG_JOINTS];
    rig_bring(RIG_COMPLIANT, STATE_OPERATIONAL);
    rig_arm.parameters.control.torque_gain = 0.0;
    rig_idle(2000U);
    before = rig_arm.control.kinematics;
    arm_jacobian(&rig_arm.model, &before, &jacobian);
    memcpy(pushed_rad, rig_pose_rad, sizeof pushed_rad);
    pushed_rad[0] += 0.02; // Joint 1 has a vertical axis, so the torques of gravity do not change.
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        weight[i] = rig_joints[i]->target_torque[0];
    }
    rig_show(pushed_rad);
    rig_idle(2000U);
    const arm_vector_t shift =
        arm_difference(rig_arm.control.kinematics.tool.position_m, before.tool.position_m);
    double expected_nm = 0.0;
    for (unsigned k = 0U; k < 3U; k++) {
        expected_nm -= jacobian.at[k][0] * 1000.0 * shift.at[k];
    }
    expected_nm -= 60.0 * 0.02; // The torque of the rotational springs.
    EXPECT_WITHIN(expected_nm, 0.1, 0.01 * (double)(rig_joints[0]->target_torque[0] - weight[0]));
    EXPECT_WITHIN(arm_length(shift), 1.0e-6, rig_arm.parameters.cur_values.tool_error[0]);
    // The drives report the torques of the weight only; the torque control adds twice the missing torque.
    rig_arm.parameters.control.torque_gain = 2.0;
    rig_idle(10U);
    EXPECT_WITHIN(3.0 * expected_nm, 0.3, 0.01 * (double)(rig_joints[0]->target_torque[0] - weight[0]));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_cycle(rig_generic.callbacks->disengage);
    rig_idle(10U); // In the desired pose the springs give no torque.
    EXPECT_WITHIN(0.0, 0.0, rig_arm.parameters.cur_values.tool_error[0]);
}

/// The arm brakes a joint that is moved, by the dampers of its tool.
static void a_compliant_tool_brakes_like_a_damper(void)
{
    const double speed_rad_s          = 0.1;
    arm_control_values_t* const gains = &rig_arm.parameters.control;
    double pose_rad[RIG_JOINTS];
    arm_jacobian_t jacobian;
    double expected_nm = 0.0;
    rig_bring(RIG_COMPLIANT, STATE_OPERATIONAL);
    gains->torque_gain   = 0.0;
    gains->joint_damping = 0.0;
    for (unsigned k = 0U; k < 6U; k++) {
        gains->tool_stiffness[k] = 0.0;
        gains->tool_damping[k]   = 100.0;
    }
    rig_idle(4000U);
    const int16_t before = rig_joints[0]->target_torque[0];
    memcpy(pose_rad, rig_pose_rad, sizeof pose_rad);
    for (unsigned i = 0U; i < 400U; i++) {
        pose_rad[0] += speed_rad_s * 0.001;
        rig_show(pose_rad);
        rig_idle(1U);
    }
    arm_jacobian(&rig_arm.model, &rig_arm.control.kinematics, &jacobian);
    for (unsigned k = 0U; k < 6U; k++) {
        expected_nm -= gains->tool_damping[k] * jacobian.at[k][0] * jacobian.at[k][0] * speed_rad_s;
    }
    EXPECT_WITHIN(expected_nm, 0.1 * fabs(expected_nm), 0.01 * (rig_joints[0]->target_torque[0] - before));
}

/// Without springs, the joints carry the weight in the present pose, not in the desired one. Gravity is
/// horizontal here, so that it also acts on the first joint.
static void a_compliant_arm_carries_its_weight_in_every_position(void)
{
    arm_control_values_t* const gains = &rig_arm.parameters.control;
    double pushed_rad[RIG_JOINTS];
    rig_bring(RIG_COMPLIANT, STATE_OPERATIONAL);
    gains->torque_gain = 0.0;
    for (unsigned k = 0U; k < 6U; k++) {
        gains->tool_stiffness[k] = 0.0;
    }
    rig_arm.parameters.masses.gravity[0] = 9.81;
    rig_arm.parameters.masses.gravity[2] = 0.0;
    rig_arm.model.gravity_m_s2           = arm_vector(rig_arm.parameters.masses.gravity);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        pushed_rad[i] = rig_pose_rad[i] + 0.3;
    }
    rig_show(pushed_rad);
    rig_idle(4000U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        TEST_ASSERT_INT16_WITHIN(30, rig_joints[i]->torque[0], rig_joints[i]->target_torque[0]);
    }
    TEST_ASSERT_TRUE(abs(rig_joints[0]->torque[0]) > 100);
}

/// Without the setting COMPLIANT each joint has its own spring.
static void in_torque_mode_a_joint_that_is_pushed_is_pulled_back_by_its_gain(void)
{
    double pushed_rad[RIG_JOINTS];
    rig_bring(RIG_TORQUE, STATE_OPERATIONAL);
    rig_idle(4000U);
    const int16_t before = rig_joints[0]->target_torque[0];
    memcpy(pushed_rad, rig_pose_rad, sizeof pushed_rad);
    pushed_rad[0] +=
        5.0 /
        rig_arm.parameters.control.kp[0]; // The axis is vertical: the torque of the weight is unchanged.
    rig_show(pushed_rad);
    rig_idle(1000U);
    TEST_ASSERT_INT16_WITHIN(5, -500, rig_joints[0]->target_torque[0] - before);
}

/// A tool cannot yield to drives that follow positions: the setting has no effect there.
static void in_position_mode_a_compliant_arm_follows_its_motion(void)
{
    const rig_move_to_t to = {.position = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 1.0};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    rig_arm.parameters.control.is_compliant = true;
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_TO, &to, 9U));
    idle_until_a_result(4000U);
    rig_idle(10U);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(to.position[i], 0.02, target_rad(i));
    }
}

static void a_torque_beyond_its_limit_is_cut_and_counted(void)
{
    rig_bring(RIG_TORQUE, STATE_OPERATIONAL);
    rig_idle(10U);
    rig_arm.parameters.limits.torque[1] = 1.0;
    rig_idle(10U);
    TEST_ASSERT_EQUAL_INT16(-100, -abs(rig_joints[1]->target_torque[0]));
    TEST_ASSERT_TRUE(rig_arm.parameters.counters.command_limited > 0U);
}

static void show_hand(const double first_rad, const double second_rad)
{
    const double hand_rad[2]  = {first_rad, second_rad};
    double_port_t* const port = &rig_generic.ports[RIG_HAND_POSITION];
    port->read_status         = STATUS_OK;
    memcpy(port->sample, hand_rad, sizeof hand_rad);
}

static double desired_height_m(void)
{
    arm_kinematics_t kinematics;
    arm_kinematics(&rig_arm.model, rig_arm.motion.position_rad, &kinematics);
    return kinematics.tool.position_m.at[2];
}

static void the_hand_leads_the_tool_of_an_engaged_arm(void)
{
    rig_bring(RIG_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    const double before_m = desired_height_m();
    show_hand(0.1, 0.3);
    rig_idle(100U);
    show_hand(0.1, 0.1);
    rig_idle(100U);
    EXPECT_WITHIN(before_m, 1.0e-6, desired_height_m()); // The hand is not enabled.
    TEST_ASSERT_EQUAL_UINT8(ARM_HAND_MISSING, rig_arm.parameters.hand.state);
    rig_generic.state = STATE_OPERATIONAL;
    while (rig_cycle(rig_generic.callbacks->engage) == STATUS_BUSY) {
    }
    rig_idle(100U);
    EXPECT_WITHIN(before_m, 1.0e-6, desired_height_m());
    show_hand(0.1, 0.202); // 0.1 rad beyond the dead band, 0.2 m/rad.
    rig_idle(1500U);
    EXPECT_WITHIN(before_m + 0.02, 1.0e-5, desired_height_m());
    TEST_ASSERT_EQUAL_UINT8(ARM_HAND_LEADS, rig_arm.parameters.hand.state);
    EXPECT_WITHIN(0.202, 1.0e-12, rig_arm.parameters.hand.position_rad[1]);
    EXPECT_WITHIN(0.02, 1.0e-5, rig_arm.parameters.hand.offset_m[1]);
    rig_generic.ports[RIG_HAND_POSITION].read_status = STATUS_STALE;
    show_hand(0.1, -0.3);
    rig_generic.ports[RIG_HAND_POSITION].read_status = STATUS_STALE;
    rig_idle(1000U);
    EXPECT_WITHIN(before_m + 0.02, 1.0e-5, desired_height_m()); // The arm holds.
    TEST_ASSERT_EQUAL_UINT8(ARM_HAND_MISSING, rig_arm.parameters.hand.state);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, rig_generic.state);
}

static void in_telepresence_no_motion_can_be_commanded(void)
{
    const rig_move_to_t to = {.position = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5}, .share = 0.5};
    rig_bring(RIG_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_MOVE_TO, &to, 9U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_STOP, NULL, 9U));
}

/// 20 N upwards on the tool, as torques of the joints; ROBOT_STATE has them in the directions of the hand.
static void the_force_on_the_tool_is_sent_to_the_hand(void)
{
    double robot[4];
    arm_jacobian_t jacobian;
    rig_bring(RIG_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(1000U);
    arm_jacobian(&rig_arm.model, &rig_arm.control.kinematics, &jacobian);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        const double torque_nm   = -20.0 * jacobian.at[2][i];
        rig_joints[i]->torque[0] = (int16_t)(rig_joints[i]->torque[0] + (int16_t)lround(torque_nm / 0.01));
        rig_joints[i]->position[0] +=
            (int32_t)lround(1.0e6 * torque_nm / rig_arm.parameters.drives.stiffness[i]);
    }
    rig_idle(1000U);
    const double_port_t* const port = &rig_generic.ports[RIG_ROBOT_STATE];
    TEST_ASSERT_EQUAL_UINT(sizeof robot, port->written_size);
    memcpy(robot, port->written, sizeof robot);
    EXPECT_WITHIN(0.0, 0.3, robot[2]);
    EXPECT_WITHIN(20.0, 0.3, robot[3]);
    EXPECT_WITHIN(robot[3], 1.0e-9, rig_arm.parameters.cur_values.tool_force_n[2]);
    rig_arm.parameters.telepresence.force_scale = 0.5;
    rig_idle(1U);
    memcpy(robot, port->written, sizeof robot);
    EXPECT_WITHIN(10.0, 0.2, robot[3]);
}

static void new_settings_take_effect_from_the_present_pose(void)
{
    double robot[4];
    rig_bring(RIG_TELEPRESENCE, STATE_OPERATIONAL);
    show_hand(0.0, 0.0);
    rig_idle(10U);
    show_hand(0.0, 0.102);
    rig_idle(1500U);
    const double height_m = desired_height_m();
    memcpy(robot, rig_generic.ports[RIG_ROBOT_STATE].written, sizeof robot);
    EXPECT_WITHIN(0.1, 1.0e-4, robot[1]); // Converted to an angle of the hand.
    rig_arm.parameters.telepresence.position_scale = 0.0;
    rig_generic.callbacks->parameter_set(&rig_arm, descriptor_find_parameter(&rig_descriptor, "CONTROL")->id);
    rig_idle(10U);
    EXPECT_WITHIN(0.02, 1.0e-5, rig_arm.hand.offset_m[1]); // Another parameter.
    rig_generic.callbacks->parameter_set(&rig_arm,
                                         descriptor_find_parameter(&rig_descriptor, "TELEPRESENCE")->id);
    show_hand(0.0, 0.3);
    rig_idle(1000U);
    EXPECT_WITHIN(height_m, 1.0e-6, desired_height_m());
    memcpy(robot, rig_generic.ports[RIG_ROBOT_STATE].written, sizeof robot);
    EXPECT_WITHIN(0.0, 0.0, robot[1]);
}

static void telemetry_shows_pose_tool_and_counters(void)
{
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    rig_idle(50U);
    const arm_cur_values_t* const values = &rig_arm.parameters.cur_values;
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(rig_pose_rad[i], 2.0e-5, values->position_rad[i]);
        TEST_ASSERT_EQUAL_HEX16(0x27U, values->statusword[i] & 0x6FU);
    }
    EXPECT_WITHIN(rig_arm.control.kinematics.tool.position_m.at[2], 0.0, values->tool_position_m[2]);
    TEST_ASSERT_EQUAL_INT32(STATE_OPERATIONAL, values->state);
    TEST_ASSERT_TRUE(rig_arm.parameters.counters.frames_sent > 100U);
}

int main(void)
{
    UNITY_BEGIN();
    rig_load();
    RUN_TEST(engaging_makes_no_step);
    RUN_TEST(in_torque_mode_the_arm_carries_its_weight);
    RUN_TEST(move_to_reaches_the_target_and_completes_its_command);
    RUN_TEST(the_duration_of_a_motion_follows_from_its_share_of_the_limits);
    RUN_TEST(a_value_outside_its_range_is_refused_with_its_joint);
    RUN_TEST(a_line_that_is_too_fast_is_refused_with_the_joint);
    RUN_TEST(out_of_operation_the_arm_does_not_move);
    RUN_TEST(a_rigid_gear_does_not_deflect);
    RUN_TEST(a_line_is_checked_then_followed);
    RUN_TEST(an_arm_at_rest_after_a_line_is_not_checked);
    RUN_TEST(a_line_out_of_reach_is_refused_without_motion);
    RUN_TEST(an_arm_that_must_leave_its_line_brakes_and_reports_the_reason);
    RUN_TEST(stop_ends_a_motion_and_the_check_of_a_line);
    RUN_TEST(leaving_operation_aborts_a_motion);
    RUN_TEST(a_compliant_tool_pushes_back_like_a_spring);
    RUN_TEST(a_compliant_tool_brakes_like_a_damper);
    RUN_TEST(a_compliant_arm_carries_its_weight_in_every_position);
    RUN_TEST(in_torque_mode_a_joint_that_is_pushed_is_pulled_back_by_its_gain);
    RUN_TEST(in_position_mode_a_compliant_arm_follows_its_motion);
    RUN_TEST(a_torque_beyond_its_limit_is_cut_and_counted);
    RUN_TEST(the_hand_leads_the_tool_of_an_engaged_arm);
    RUN_TEST(in_telepresence_no_motion_can_be_commanded);
    RUN_TEST(the_force_on_the_tool_is_sent_to_the_hand);
    RUN_TEST(new_settings_take_effect_from_the_present_pose);
    RUN_TEST(telemetry_shows_pose_tool_and_counters);
    return UNITY_END();
}
