// SPDX-License-Identifier: Apache-2.0
// Trajectories of the tool through via poses: limits of the tool, distance from the poses, rest at both ends;
// and the functions ADD_POSE and LINE_VIA of an arm.
#include "pus/core/tailoring.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_S 0.001
#define CASES 60U
#define HALF_PI 1.5707963267948966
#define ROUNDING 1.0e-9
#define STEPS_MAX 200000U

static const arm_rotation_t unrotated = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
static arm_trajectory_t trajectory;
static arm_limits_t limits;
static arm_pose_t start;
static uint32_t seed;

void setUp(void)
{
    arm_model_t model;
    arm_kinematics_t kinematics;
    rig_set_up();
    rig_model(&model, &limits);
    double pose_rad[ARM_JOINTS_MAX] = {0.0};
    memcpy(pose_rad, rig_pose_rad, sizeof rig_pose_rad);
    arm_kinematics(&model, pose_rad, &kinematics);
    start = kinematics.tool;
    arm_trajectory_clear(&trajectory);
    seed = 1U;
}

void tearDown(void)
{
    rig_tear_down();
}

/// Returns a pseudo-random number from -0.5 to 0.5; the same sequence in each run.
static double drawn(void)
{
    seed = (seed * 1664525U) + 1013904223U;
    return ((double)(seed >> 8) / 16777216.0) - 0.5;
}

static arm_vector_t vector(const double wide)
{
    const double x = wide * drawn();
    const double y = wide * drawn();
    return (arm_vector_t){{x, y, wide * drawn()}};
}

/// Add a pose by its displacement and rotation from the start.
static arm_pose_t add(const arm_vector_t shift_m, const arm_vector_t turn_rad)
{
    const arm_pose_t pose     = {.rotation   = arm_rotation_turned_by(&start.rotation, turn_rad),
                                 .position_m = arm_sum(start.position_m, shift_m)};
    const arm_vector_t vector = arm_rotation_between(&unrotated, &pose.rotation);
    TEST_ASSERT_EQUAL(STATUS_OK, arm_trajectory_add_pose(&trajectory, pose.position_m.at, vector.at));
    return pose;
}

static void plan(const double share, const double blend)
{
    status_t status = STATUS_BUSY;
    arm_trajectory_begin_tool(&trajectory, &limits, &start, share, blend);
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < ARM_PLAN_ROUNDS); i++) {
        status = arm_trajectory_plan(&trajectory, &limits);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
}

static double distance_m(const arm_pose_t* const a, const arm_pose_t* const b)
{
    return arm_length(arm_difference(a->position_m, b->position_m));
}

static double angle_rad(const arm_pose_t* const a, const arm_pose_t* const b)
{
    return arm_length(arm_rotation_between(&a->rotation, &b->rotation));
}

/// Expect that the velocities are the differences of poses, and that tool and rotation stay within their
/// limits.
static void expect_within_limits(const arm_pose_t* const last, const arm_twist_t* const last_twist,
                                 const arm_pose_t* const pose, const arm_twist_t* const twist,
                                 const double share)
{
    const arm_vector_t moved  = arm_difference(pose->position_m, last->position_m);
    const arm_vector_t turned = arm_rotation_between(&last->rotation, &pose->rotation);
    const arm_vector_t change = arm_difference(twist->linear_m_s, last_twist->linear_m_s);
    const arm_vector_t spin   = arm_difference(twist->angular_rad_s, last_twist->angular_rad_s);
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(0.5 * (twist->linear_m_s.at[i] + last_twist->linear_m_s.at[i]), 1.0e-3,
                      moved.at[i] / PERIOD_S);
        EXPECT_WITHIN(0.5 * (twist->angular_rad_s.at[i] + last_twist->angular_rad_s.at[i]), 1.0e-3,
                      turned.at[i] / PERIOD_S);
    }
    TEST_ASSERT_TRUE(arm_length(twist->linear_m_s) <= (share * limits.tool_speed_m_s) + ROUNDING);
    TEST_ASSERT_TRUE(arm_length(twist->angular_rad_s) <= (share * limits.tool_rate_rad_s) + ROUNDING);
    TEST_ASSERT_TRUE(arm_length(change) <= (share * limits.tool_acceleration_m_s2 * PERIOD_S) + ROUNDING);
    TEST_ASSERT_TRUE(arm_length(spin) <=
                     (share * limits.tool_angular_acceleration_rad_s2 * PERIOD_S) + ROUNDING);
}

/// Run the trajectory through these poses, from rest to rest.
static void fly(const arm_pose_t* const poses, const double share, const double blend)
{
    const double duration_s = arm_trajectory_duration_s(&trajectory);
    const unsigned count    = trajectory.point_count;
    double nearest[ARM_POINTS_MAX];
    arm_pose_t last = start;
    arm_pose_t pose;
    arm_twist_t last_twist = {{{0.0, 0.0, 0.0}}, {{0.0, 0.0, 0.0}}};
    arm_twist_t twist;
    for (unsigned n = 0U; n < count; n++) {
        nearest[n] = HUGE_VAL;
    }
    for (unsigned step = 1U; ((step * PERIOD_S) <= (duration_s + PERIOD_S)) && (step < STEPS_MAX); step++) {
        arm_trajectory_tool_at(&trajectory, step * PERIOD_S, 1.0, &pose, &twist);
        expect_within_limits(&last, &last_twist, &pose, &twist, share);
        for (unsigned n = 0U; n < count; n++) {
            // `blend` limits the difference of two rotation vectors, which is at least as long as the angle
            // between the two orientations.
            nearest[n] = fmin(nearest[n], fmax(distance_m(&pose, &poses[n]), angle_rad(&pose, &poses[n])));
        }
        last       = pose;
        last_twist = twist;
    }
    for (unsigned n = 0U; n < count; n++) { // Between two steps the tool moves on.
        TEST_ASSERT_TRUE(nearest[n] <=
                         blend + (PERIOD_S * fmax(limits.tool_speed_m_s, limits.tool_rate_rad_s)));
    }
    TEST_ASSERT_TRUE(distance_m(&pose, &poses[count - 1U]) < ROUNDING);
    TEST_ASSERT_TRUE(angle_rad(&pose, &poses[count - 1U]) < 1.0e-7);
    TEST_ASSERT_TRUE((arm_length(twist.linear_m_s) == 0.0) && (arm_length(twist.angular_rad_s) == 0.0));
}

static void random_poses_are_passed_within_the_limits_of_the_tool(void)
{
    for (unsigned k = 0U; k < CASES; k++) {
        arm_pose_t poses[ARM_POINTS_MAX];
        const unsigned count = 1U + (k % 6U);
        const double share   = 0.55 + (0.9 * drawn());
        const double blend   = 0.051 + (0.1 * drawn());
        arm_trajectory_clear(&trajectory);
        for (unsigned n = 0U; n < count; n++) {
            const arm_vector_t shift = vector(0.5);
            poses[n]                 = add(shift, vector((k % 3U == 0U) ? 0.0 : 2.0));
        }
        plan(share, blend);
        fly(poses, share, blend);
    }
}

/// A tool that turns fast has an angular acceleration even while its rotation vector changes at a constant
/// rate; plans allow for it.
static void a_fast_turn_stays_within_the_angular_acceleration(void)
{
    limits.tool_rate_rad_s                  = 3.0;
    limits.tool_angular_acceleration_rad_s2 = 1.0;
    for (unsigned k = 0U; k < 24U; k++) {
        arm_pose_t poses[3];
        arm_trajectory_clear(&trajectory);
        for (unsigned n = 0U; n < 3U; n++) {
            poses[n] = add((arm_vector_t){{0.0, 0.0, 0.0}}, vector(6.0));
        }
        plan(1.0, 3.0);
        fly(poses, 1.0, 3.0);
    }
}

/// On a diagonal the length of the velocity, not each coordinate, reaches the limit.
static void a_diagonal_line_is_followed_at_full_speed(void)
{
    arm_pose_t pose;
    arm_twist_t twist;
    (void)add((arm_vector_t){{0.3, 0.3, 0.3}}, (arm_vector_t){{0.0, 0.0, 0.0}});
    plan(1.0, 0.01);
    arm_trajectory_tool_at(&trajectory, 0.5 * arm_trajectory_duration_s(&trajectory), 1.0, &pose, &twist);
    EXPECT_WITHIN(limits.tool_speed_m_s, 1.0e-9, arm_length(twist.linear_m_s));
    arm_trajectory_tool_at(&trajectory, 0.5 * arm_trajectory_duration_s(&trajectory), 0.25, &pose, &twist);
    EXPECT_WITHIN(0.25 * limits.tool_speed_m_s, 1.0e-9, arm_length(twist.linear_m_s));
}

/// Orientations on both sides of half a turn: the tool turns 0.5 rad further, not almost a whole turn back.
static void the_tool_keeps_turning_beyond_half_a_turn(void)
{
    arm_pose_t poses[2];
    poses[0] = add((arm_vector_t){{0.0, 0.0, 0.0}}, (arm_vector_t){{0.0, 0.0, 3.0}});
    poses[1] = add((arm_vector_t){{0.0, 0.0, 0.0}}, (arm_vector_t){{0.0, 0.0, 3.5}});
    plan(1.0, 0.05);
    fly(poses, 1.0, 0.05);
    EXPECT_WITHIN(3.5, 1.0e-6, trajectory.point[2][5]);
}

/// A rotation by half a turn has two possible axes, and one by a whole turn any axis. The tool nevertheless
/// keeps turning about its axis.
static void the_tool_keeps_turning_through_half_and_whole_turns(void)
{
    arm_pose_t poses[6];
    for (unsigned n = 0U; n < 6U; n++) {
        poses[n] = add((arm_vector_t){{0.0, 0.0, 0.0}}, (arm_vector_t){{0.0, 0.0, (n + 1U) * HALF_PI}});
    }
    plan(1.0, 0.05);
    fly(poses, 1.0, 0.05);
    for (unsigned n = 1U; n <= 6U; n++) {
        EXPECT_WITHIN(n * HALF_PI, 1.0e-6, trajectory.point[n][5]);
    }
}

static void a_trajectory_has_at_most_sixteen_poses(void)
{
    for (unsigned i = 0U; i < ARM_POINTS_MAX; i++) {
        (void)add((arm_vector_t){{0.0, 0.0, 0.0}}, (arm_vector_t){{0.0, 0.0, 0.0}});
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      arm_trajectory_add_pose(&trajectory, start.position_m.at, start.position_m.at));
}

// ---- The functions ----

static const rig_move_through_t through = {.share = 0.8, .blend = 0.01};

static rig_pose_t pose_by(const double x, const double y, const double z, const double turn)
{
    rig_pose_t pose;
    const arm_rotation_t turned = arm_rotation_turned_by(&start.rotation, (arm_vector_t){{0.0, 0.0, turn}});
    const arm_vector_t rotation = arm_rotation_between(&unrotated, &turned);
    const double shift[3]       = {x, y, z};
    for (unsigned i = 0U; i < 3U; i++) {
        pose.position[i] = start.position_m.at[i] + shift[i];
        pose.rotation[i] = rotation.at[i];
    }
    return pose;
}

static arm_pose_t tool(void)
{
    arm_kinematics_t kinematics;
    arm_kinematics(&rig_arm.model, rig_arm.motion.position_rad, &kinematics);
    return kinematics.tool;
}

static void idle_until_a_result(const unsigned cycles)
{
    for (unsigned i = 0U; (i < cycles) && (rig_generic.result_count == 0U); i++) {
        rig_idle(1U);
    }
}

static void the_arm_moves_its_tool_through_the_poses_without_a_stop(void)
{
    const rig_pose_t poses[] = {pose_by(0.06, 0.0, 0.0, 0.1), pose_by(0.06, 0.06, 0.0, 0.2),
                                pose_by(0.0, 0.06, -0.03, 0.0)};
    double nearest_m[3]      = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double slowest_m_s       = HUGE_VAL;
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    for (unsigned n = 0U; n < 3U; n++) {
        TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &poses[n], n));
    }
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_VIA, &through, 5U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_LINE_VIA, &through, 6U));
    arm_pose_t last = tool();
    for (unsigned i = 0U; (i < 20000U) && (rig_generic.result_count == 0U); i++) {
        rig_idle(1U);
        const arm_pose_t here = tool();
        const double speed    = arm_length(arm_difference(here.position_m, last.position_m)) / PERIOD_S;
        TEST_ASSERT_TRUE(speed <= (through.share * limits.tool_speed_m_s * 1.01) + 1.0e-6);
        for (unsigned n = 0U; n < 3U; n++) {
            nearest_m[n] = fmin(nearest_m[n],
                                arm_length(arm_difference(here.position_m, arm_vector(poses[n].position))));
        }
        const bool is_between = (nearest_m[0] < 0.05) && (nearest_m[2] > 0.02);
        slowest_m_s           = is_between ? fmin(slowest_m_s, speed) : slowest_m_s;
        last                  = here;
    }
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(5U, rig_generic.results[0].call_token);
    TEST_ASSERT_TRUE((nearest_m[0] < 0.0105) && (nearest_m[1] < 0.0105) && (nearest_m[2] < 1.0e-6));
    TEST_ASSERT_TRUE(slowest_m_s > 0.01);
    TEST_ASSERT_EQUAL_UINT(0U, rig_arm.poses.point_count);
}

static void poses_that_are_impossible_are_refused_before_the_motion(void)
{
    const rig_pose_t near = pose_by(0.02, 0.0, 0.0, 0.0);
    const rig_pose_t far  = pose_by(3.0, 0.0, 0.0, 0.0);
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_LINE_VIA, &through, 1U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 4U, rig_generic.results[0].code);
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &near, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &far, 3U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_VIA, &through, 4U));
    const arm_pose_t before = tool();
    idle_until_a_result(4000U);
    // Out of reach; on the way there, a joint would exceed its speed near the stretched pose.
    TEST_ASSERT_TRUE((rig_generic.results[0].code == (PUS_FAILURE_OWN + 2U)) ||
                     (rig_generic.results[0].code == (PUS_FAILURE_OWN + 3U)));
    const arm_pose_t after = tool();
    TEST_ASSERT_TRUE(distance_m(&before, &after) < 1.0e-9);
    for (unsigned i = 0U; i < ARM_POINTS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &near, 5U));
    }
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_ADD_POSE, &near, 6U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_CLR_VIA, NULL, 7U));
    TEST_ASSERT_EQUAL_UINT(0U, rig_arm.poses.point_count);
}

/// STOP brakes along the path: the tool comes to rest on the line that it followed.
static void a_stop_keeps_the_tool_on_its_path(void)
{
    const rig_pose_t poses[] = {pose_by(0.06, 0.0, 0.0, 0.0), pose_by(0.12, 0.0, 0.0, 0.0)};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &poses[0], 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_POSE, &poses[1], 2U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_LINE_VIA, &through, 3U));
    for (unsigned i = 0U; (i < 4000U) && (tool().position_m.at[0] < (start.position_m.at[0] + 0.05)); i++) {
        rig_idle(1U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 4U));
    idle_until_a_result(2000U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    const arm_pose_t here = tool();
    EXPECT_WITHIN(start.position_m.at[1], 1.0e-6, here.position_m.at[1]);
    EXPECT_WITHIN(start.position_m.at[2], 1.0e-6, here.position_m.at[2]);
    TEST_ASSERT_TRUE(here.position_m.at[0] < (start.position_m.at[0] + 0.119));
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        TEST_ASSERT_TRUE(fabs(rig_arm.motion.velocity_rad_s[i]) < 1.0e-9);
    }
}

int main(void)
{
    rig_load();
    UNITY_BEGIN();
    RUN_TEST(random_poses_are_passed_within_the_limits_of_the_tool);
    RUN_TEST(a_fast_turn_stays_within_the_angular_acceleration);
    RUN_TEST(a_diagonal_line_is_followed_at_full_speed);
    RUN_TEST(the_tool_keeps_turning_beyond_half_a_turn);
    RUN_TEST(the_tool_keeps_turning_through_half_and_whole_turns);
    RUN_TEST(a_trajectory_has_at_most_sixteen_poses);
    RUN_TEST(the_arm_moves_its_tool_through_the_poses_without_a_stop);
    RUN_TEST(poses_that_are_impossible_are_refused_before_the_motion);
    RUN_TEST(a_stop_keeps_the_tool_on_its_path);
    return UNITY_END();
}
