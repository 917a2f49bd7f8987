// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_path.h"
#include "test/support/assertion.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_S 0.001
#define STEPS_MAX 60000U

static arm_model_t model;
static arm_limits_t limits;
static arm_motion_t start;
static arm_path_t path;

void setUp(void)
{
    rig_model(&model, &limits);
    start = (arm_motion_t){.position_rad = {0.0}};
    memcpy(start.position_rad, rig_pose_rad, sizeof rig_pose_rad);
}

void tearDown(void)
{
}

typedef struct { // Largest values of a motion along a path, and its duration.
    double speed[RIG_JOINTS];
    double acceleration[RIG_JOINTS];
    double tool_speed;
    double off_line_m; // Distance of the tool from the line.
    double seconds;
} extremes_t;

static double larger(const double a, const double b)
{
    return (a > b) ? a : b;
}

/// Distance of a point from the line through two others.
static double distance_from(const arm_vector_t from, const arm_vector_t to, const arm_vector_t point)
{
    const arm_vector_t along =
        arm_times(arm_difference(to, from), 1.0 / arm_length(arm_difference(to, from)));
    return arm_length(arm_cross(along, arm_difference(point, from)));
}

/// Follow the path to its end or to a refusal, which is returned. Collect the extremes, and check that the
/// velocities are the differences of the positions.
static arm_refusal_t fly(arm_motion_t* const motion, const arm_pose_t* const from, const arm_pose_t* const to,
                         extremes_t* const extremes)
{
    arm_refusal_t refusal   = {ARM_REFUSAL_NONE, 0U};
    arm_kinematics_t before = {.tool = *from};
    *extremes               = (extremes_t){.seconds = 0.0};
    for (unsigned step = 0U; (step < STEPS_MAX) && !arm_path_is_done(&path); step++) {
        const arm_motion_t last = *motion;
        arm_kinematics_t kinematics;
        refusal = arm_path_step(&path, &model, &limits, PERIOD_S, motion);
        if (refusal.reason != ARM_REFUSAL_NONE) {
            return refusal;
        }
        arm_kinematics(&model, motion->position_rad, &kinematics);
        for (unsigned i = 0U; i < RIG_JOINTS; i++) {
            const double mean = (motion->position_rad[i] - last.position_rad[i]) / PERIOD_S;
            EXPECT_WITHIN(0.5 * (motion->velocity_rad_s[i] + last.velocity_rad_s[i]), 2.0e-3, mean);
            extremes->speed[i] = larger(extremes->speed[i], fabs(motion->velocity_rad_s[i]));
            extremes->acceleration[i] =
                larger(extremes->acceleration[i], fabs(motion->acceleration_rad_s2[i]));
        }
        const arm_vector_t shift = arm_difference(kinematics.tool.position_m, before.tool.position_m);
        extremes->tool_speed     = larger(extremes->tool_speed, arm_length(shift) / PERIOD_S);
        extremes->off_line_m = larger(extremes->off_line_m, distance_from(from->position_m, to->position_m,
                                                                          kinematics.tool.position_m));
        extremes->seconds += PERIOD_S;
        before = kinematics;
    }
    return refusal;
}

#define MARK 77.0

/// Mark the values after the last joint, which no path may change.
static void leave_mark(arm_motion_t* const motion)
{
    motion->position_rad[RIG_JOINTS]        = MARK;
    motion->velocity_rad_s[RIG_JOINTS]      = MARK;
    motion->acceleration_rad_s2[RIG_JOINTS] = MARK;
}

static void expect_mark(const arm_motion_t* const motion)
{
    TEST_ASSERT_TRUE(motion->position_rad[RIG_JOINTS] == MARK);
    TEST_ASSERT_TRUE(motion->velocity_rad_s[RIG_JOINTS] == MARK);
    TEST_ASSERT_TRUE(motion->acceleration_rad_s2[RIG_JOINTS] == MARK);
}

static arm_pose_t tool_at(const arm_motion_t* const motion)
{
    arm_kinematics_t kinematics;
    arm_kinematics(&model, motion->position_rad, &kinematics);
    return kinematics.tool;
}

static void joints_arrive_together_and_the_slowest_uses_its_whole_limit(void)
{
    double goal[ARM_JOINTS_MAX] = {0.5, -1.0, 1.0, -1.2, -1.5, 2.2};
    arm_motion_t motion         = start;
    extremes_t extremes;
    const arm_pose_t from = tool_at(&start);
    arm_pose_t anywhere   = from;
    anywhere.position_m.at[0] += 1.0;
    // The path is no line of the tool; `fly` only needs a second point that differs from the first.
    limits.acceleration_rad_s2[5] = 100.0; // The speed limit of this joint is decisive.
    leave_mark(&motion);
    const arm_refusal_t refusal = arm_path_begin_joints(&path, &model, &limits, &start, goal, 1.0);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, refusal.reason);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, fly(&motion, &from, &anywhere, &extremes).reason);
    EXPECT_WITHIN(limits.speed_rad_s[5], 1.0e-3, extremes.speed[5]);
    EXPECT_WITHIN(arm_path_duration_s(&path), 2.0e-3, extremes.seconds);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(goal[i], 1.0e-12, motion.position_rad[i]);
        EXPECT_WITHIN(0.0, 1.0e-12, motion.velocity_rad_s[i]);
        TEST_ASSERT_TRUE(extremes.speed[i] <= (limits.speed_rad_s[i] * 1.0001));
        TEST_ASSERT_TRUE(extremes.acceleration[i] <= (limits.acceleration_rad_s2[i] * 1.0001));
    }
    expect_mark(&motion);
}

static void a_short_motion_is_bounded_by_acceleration_and_a_share_slows_it(void)
{
    double goal[ARM_JOINTS_MAX];
    arm_motion_t motion = start;
    extremes_t extremes;
    arm_pose_t anywhere   = tool_at(&start);
    const arm_pose_t from = anywhere;
    anywhere.position_m.at[0] += 1.0;
    memcpy(goal, start.position_rad, sizeof goal);
    goal[1] += 0.2;
    (void)arm_path_begin_joints(&path, &model, &limits, &start, goal, 0.25);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, fly(&motion, &from, &anywhere, &extremes).reason);
    EXPECT_WITHIN(0.25 * limits.acceleration_rad_s2[1], 1.0e-3, extremes.acceleration[1]);
    TEST_ASSERT_TRUE(extremes.speed[1] <= (0.25 * limits.speed_rad_s[1]));
}

static void a_goal_outside_the_range_names_the_joint(void)
{
    double goal[ARM_JOINTS_MAX] = {0.0};
    memcpy(goal, start.position_rad, sizeof goal);
    goal[3]                     = limits.upper_rad[3] + 1.0e-6;
    const arm_refusal_t refusal = arm_path_begin_joints(&path, &model, &limits, &start, goal, 1.0);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_POSITION, refusal.reason);
    TEST_ASSERT_EQUAL_UINT(3U, refusal.joint);
    goal[3] = (double)NAN;
    TEST_ASSERT_EQUAL(ARM_REFUSAL_POSITION,
                      arm_path_begin_joints(&path, &model, &limits, &start, goal, 1.0).reason);
    goal[3] = limits.lower_rad[3] - 1.0e-6;
    TEST_ASSERT_EQUAL(ARM_REFUSAL_POSITION,
                      arm_path_begin_joints(&path, &model, &limits, &start, goal, 1.0).reason);
}

/// Returns a pose that is 0.2 m and 0.99 rad (57 degrees) away.
static arm_pose_t near_goal(void)
{
    arm_pose_t goal = tool_at(&start);
    goal.position_m = arm_sum(goal.position_m, (arm_vector_t){{0.1, 0.1, 0.14}});
    goal.rotation   = arm_rotation_turned_by(&goal.rotation, (arm_vector_t){{0.3, -0.5, 0.8}});
    return goal;
}

static status_t check_line(arm_refusal_t* const out_refusal)
{
    arm_line_check_t check;
    status_t status = STATUS_BUSY;
    arm_line_check_begin(&check, &path, &start);
    for (unsigned cycle = 0U; (cycle < 100U) && (status == STATUS_BUSY); cycle++) {
        status = arm_line_check_step(&check, &model, &limits, out_refusal);
    }
    return status;
}

static void the_tool_stays_on_its_line_and_within_its_limits(void)
{
    const arm_pose_t from = tool_at(&start);
    const arm_pose_t goal = near_goal();
    arm_motion_t motion   = start;
    extremes_t extremes;
    arm_refusal_t refusal;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OK, check_line(&refusal));
    leave_mark(&motion);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, fly(&motion, &from, &goal, &extremes).reason);
    expect_mark(&motion);
    const arm_pose_t reached = tool_at(&motion);
    EXPECT_WITHIN(0.0, 1.0e-9, arm_length(arm_difference(reached.position_m, goal.position_m)));
    EXPECT_WITHIN(0.0, 1.0e-9, arm_length(arm_rotation_between(&reached.rotation, &goal.rotation)));
    EXPECT_WITHIN(0.0, 1.0e-6, extremes.off_line_m);
    TEST_ASSERT_TRUE(extremes.tool_speed <= (limits.tool_speed_m_s * 1.0001));
}

/// The velocities belong to the positions of the same step: the resulting velocity of the tool keeps the
/// direction of the line and the axis of the rotation.
static void the_joints_move_the_tool_along_the_line_at_every_step(void)
{
    const arm_pose_t from    = tool_at(&start);
    const arm_pose_t goal    = near_goal();
    const arm_vector_t shift = arm_difference(goal.position_m, from.position_m);
    const arm_vector_t turn  = arm_rotation_between(&from.rotation, &goal.rotation);
    arm_motion_t motion      = start;
    double fastest           = 0.0;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    while (!arm_path_is_done(&path)) {
        arm_kinematics_t kinematics;
        arm_jacobian_t jacobian;
        double twist[6] = {0.0};
        TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, arm_path_step(&path, &model, &limits, PERIOD_S, &motion).reason);
        arm_kinematics(&model, motion.position_rad, &kinematics);
        arm_jacobian(&model, &kinematics, &jacobian);
        for (unsigned k = 0U; k < 6U; k++) {
            for (unsigned i = 0U; i < RIG_JOINTS; i++) {
                twist[k] += jacobian.at[k][i] * motion.velocity_rad_s[i];
            }
        }
        EXPECT_WITHIN(0.0, 1.0e-9, arm_length(arm_cross(shift, arm_vector(&twist[0]))));
        EXPECT_WITHIN(0.0, 1.0e-9, arm_length(arm_cross(turn, arm_vector(&twist[3]))));
        fastest = larger(fastest, arm_length(arm_vector(&twist[0])));
    }
    TEST_ASSERT_TRUE(fastest > 0.05);
}

/// The line ends where it starts: speeds and errors are zero, and so are their limits.
static void values_at_the_limits_of_speed_and_tolerance_are_accepted(void)
{
    const arm_pose_t goal = tool_at(&start);
    arm_refusal_t refusal;
    limits.tolerance = 0.0;
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        limits.speed_rad_s[i] = 0.0;
    }
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OK, check_line(&refusal));
}

/// The check has 400 steps, ten of them in each cycle.
static void the_check_of_a_line_ends_within_forty_cycles(void)
{
    const arm_pose_t goal = near_goal();
    arm_line_check_t check;
    arm_refusal_t refusal;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    arm_line_check_begin(&check, &path, &start);
    for (unsigned cycle = 1U; cycle < 40U; cycle++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, arm_line_check_step(&check, &model, &limits, &refusal));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, arm_line_check_step(&check, &model, &limits, &refusal));
}

static void move_with_no_share(void)
{
    (void)arm_path_begin_joints(&path, &model, &limits, &start, start.position_rad, 0.0);
}

static void plan_a_line_with_no_share(void)
{
    const arm_pose_t goal = near_goal();
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 0.0);
}

static void a_motion_with_no_share_of_the_limits_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(move_with_no_share));
    TEST_ASSERT_TRUE(assertion_fails(plan_a_line_with_no_share));
}

static void a_line_out_of_reach_is_refused_before_it_begins(void)
{
    arm_pose_t goal = tool_at(&start);
    arm_refusal_t refusal;
    goal.position_m.at[0] -= 2.0;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check_line(&refusal));
    TEST_ASSERT_EQUAL(ARM_REFUSAL_LINE, refusal.reason);
}

static void a_line_through_a_singular_pose_is_refused_with_a_reason(void)
{
    arm_motion_t straight = start;
    arm_refusal_t refusal;
    straight.position_rad[4] = 0.02; // Nearly straight wrist: a turn across it needs too high rates.
    start                    = straight;
    arm_pose_t goal          = tool_at(&start);
    goal.rotation            = arm_rotation_turned_by(&goal.rotation, (arm_vector_t){{0.0, 0.0, 0.8}});
    goal.position_m.at[0] += 0.1;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check_line(&refusal));
    TEST_ASSERT_TRUE((refusal.reason == ARM_REFUSAL_LINE) || (refusal.reason == ARM_REFUSAL_SPEED));
}

static void a_line_on_which_a_joint_leaves_its_range_or_speed_names_it(void)
{
    const arm_pose_t goal = near_goal();
    arm_refusal_t refusal;
    limits.upper_rad[0] = start.position_rad[0] + 0.01;
    limits.lower_rad[0] = start.position_rad[0] - 0.01;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check_line(&refusal));
    TEST_ASSERT_EQUAL(ARM_REFUSAL_POSITION, refusal.reason);
    TEST_ASSERT_EQUAL_UINT(0U, refusal.joint);
    rig_model(&model, &limits);
    limits.speed_rad_s[5] = 0.01;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check_line(&refusal));
    TEST_ASSERT_EQUAL(ARM_REFUSAL_SPEED, refusal.reason);
    TEST_ASSERT_EQUAL_UINT(5U, refusal.joint);
}

static void a_stop_ends_on_the_line_within_the_accelerations(void)
{
    const arm_pose_t from = tool_at(&start);
    const arm_pose_t goal = near_goal();
    arm_motion_t motion   = start;
    extremes_t extremes;
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    // The stop comes at the beginning: there is no speed to reduce.
    arm_path_stop(&path, &model, &limits, &motion);
    TEST_ASSERT_TRUE(arm_path_is_done(&path));
    arm_path_begin_line(&path, &model, &limits, &start, &goal, 1.0);
    for (unsigned step = 0U; step < 500U; step++) {
        (void)arm_path_step(&path, &model, &limits, PERIOD_S, &motion);
    }
    arm_path_stop(&path, &model, &limits, &motion);
    TEST_ASSERT_EQUAL(ARM_REFUSAL_NONE, fly(&motion, &from, &goal, &extremes).reason);
    EXPECT_WITHIN(0.0, 1.0e-6, extremes.off_line_m);
    EXPECT_WITHIN(0.0, 1.0e-9, motion.velocity_rad_s[1]);
    TEST_ASSERT_TRUE(arm_length(arm_difference(tool_at(&motion).position_m, goal.position_m)) > 0.01);
}

static void braking_takes_each_joint_to_rest_from_its_own_speed(void)
{
    arm_motion_t motion = start;
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        motion.velocity_rad_s[i] = (i % 2U == 0U) ? 1.0 : -0.5;
    }
    const arm_motion_t before = motion;
    arm_path_brake(&path, &model, &limits, &motion);
    for (unsigned step = 0U; (step < 2000U) && !arm_path_is_done(&path); step++) {
        (void)arm_path_step(&path, &model, &limits, PERIOD_S, &motion);
        for (unsigned i = 0U; i < RIG_JOINTS; i++) {
            TEST_ASSERT_TRUE(fabs(motion.acceleration_rad_s2[i]) <= (limits.acceleration_rad_s2[i] * 1.0001));
        }
    }
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        const double moved = motion.position_rad[i] - before.position_rad[i];
        EXPECT_WITHIN(0.0, 1.0e-12, motion.velocity_rad_s[i]);
        TEST_ASSERT_TRUE((moved * before.velocity_rad_s[i]) > 0.0);
    }
}

int main(void)
{
    UNITY_BEGIN();
    rig_load();
    RUN_TEST(joints_arrive_together_and_the_slowest_uses_its_whole_limit);
    RUN_TEST(a_short_motion_is_bounded_by_acceleration_and_a_share_slows_it);
    RUN_TEST(a_goal_outside_the_range_names_the_joint);
    RUN_TEST(the_tool_stays_on_its_line_and_within_its_limits);
    RUN_TEST(the_joints_move_the_tool_along_the_line_at_every_step);
    RUN_TEST(values_at_the_limits_of_speed_and_tolerance_are_accepted);
    RUN_TEST(the_check_of_a_line_ends_within_forty_cycles);
    RUN_TEST(a_motion_with_no_share_of_the_limits_is_a_coding_error);
    RUN_TEST(a_line_out_of_reach_is_refused_before_it_begins);
    RUN_TEST(a_line_through_a_singular_pose_is_refused_with_a_reason);
    RUN_TEST(a_line_on_which_a_joint_leaves_its_range_or_speed_names_it);
    RUN_TEST(a_stop_ends_on_the_line_within_the_accelerations);
    RUN_TEST(braking_takes_each_joint_to_rest_from_its_own_speed);
    return UNITY_END();
}
