// SPDX-License-Identifier: Apache-2.0
// Telepresence of the tool: the motion that the hand commands, the parts of the pose that are kept, and what
// limits the speed.
#include "fsw/framework/control/elementary.h"
#include "fsw/subsystems/arm/arm_hand.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_S 0.001
#define SCALE_M_RAD 0.2
#define SPEED_M_S 0.2

static arm_model_t model;
static arm_limits_t limits;
static arm_motion_t motion;
static arm_pose_t start;
static arm_hand_t hand;
static arm_hand_setup_t setup;

static arm_pose_t tool(void)
{
    arm_kinematics_t kinematics;
    arm_kinematics(&model, motion.position_rad, &kinematics);
    return kinematics.tool;
}

static void begin(const double pose_rad[RIG_JOINTS])
{
    motion = (arm_motion_t){.position_rad = {0.0}};
    memcpy(motion.position_rad, pose_rad, RIG_JOINTS * sizeof pose_rad[0]);
    start = tool();
    arm_hand_begin(&hand, &model, &motion);
}

void setUp(void)
{
    static const double directions[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    rig_model(&model, &limits);
    setup =
        (arm_hand_setup_t){.model    = &model,
                           .limits   = &limits,
                           .settings = {.scale_m_rad = SCALE_M_RAD, .range_m = 0.2, .bandwidth_rad_s = 40.0},
                           .period_s = PERIOD_S};
    limits.tool_speed_m_s = SPEED_M_S;
    arm_hand_directions(directions, setup.settings.direction);
    begin(rig_pose_rad);
}

void tearDown(void)
{
}

typedef struct { // Largest values of one call of lead().
    double tool_speed_m_s;
    double speed_rad_s[RIG_JOINTS];
    double acceleration_rad_s2[RIG_JOINTS];
} extremes_t;

static extremes_t extremes;

/// Step the motion with constant angles of the hand, or without a sample (null). Check that velocities are
/// the differences of positions.
static void lead(const double* const hand_rad, const unsigned steps)
{
    extremes = (extremes_t){.tool_speed_m_s = 0.0};
    for (unsigned step = 0U; step < steps; step++) {
        const arm_motion_t before = motion;
        const arm_vector_t from   = tool().position_m;
        arm_hand_step(&hand, &setup, hand_rad, &motion);
        const double speed      = arm_length(arm_difference(tool().position_m, from)) / PERIOD_S;
        extremes.tool_speed_m_s = fmax(extremes.tool_speed_m_s, speed);
        for (unsigned i = 0U; i < model.joint_count; i++) {
            const double change = motion.position_rad[i] - before.position_rad[i];
            EXPECT_WITHIN(change / PERIOD_S, 1.0e-9, motion.velocity_rad_s[i]);
            EXPECT_WITHIN((motion.velocity_rad_s[i] - before.velocity_rad_s[i]) / PERIOD_S, 1.0e-6,
                          motion.acceleration_rad_s2[i]);
            extremes.speed_rad_s[i] = fmax(extremes.speed_rad_s[i], fabs(motion.velocity_rad_s[i]));
            extremes.acceleration_rad_s2[i] =
                fmax(extremes.acceleration_rad_s2[i], fabs(motion.acceleration_rad_s2[i]));
        }
    }
}

static void expect_offset(const double x, const double y, const double z, const double tolerance)
{
    const arm_vector_t moved = arm_difference(tool().position_m, start.position_m);
    EXPECT_WITHIN(x, tolerance, moved.at[0]);
    EXPECT_WITHIN(y, tolerance, moved.at[1]);
    EXPECT_WITHIN(z, tolerance, moved.at[2]);
}

static void coupling_the_hand_does_not_move_the_tool(void)
{
    const double at[2] = {0.3, -0.2};
    lead(at, 500U);
    expect_offset(0.0, 0.0, 0.0, 1.0e-12);
    TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
}

static void the_tool_moves_by_the_scale_and_keeps_the_rest_of_its_pose(void)
{
    const double first[2] = {0.3, -0.2};
    const double then[2]  = {0.5, -0.6};
    lead(first, 1U);
    lead(then, 2000U);
    expect_offset(0.04, 0.0, -0.08, 1.0e-6);
    const arm_rotation_t now = tool().rotation;
    EXPECT_BELOW(1.0e-6, arm_length(arm_rotation_between(&start.rotation, &now)));
    EXPECT_WITHIN(0.04, 1.0e-6, hand.offset_m[0]);
    EXPECT_WITHIN(-0.08, 1.0e-6, hand.offset_m[1]);
    EXPECT_BELOW(SPEED_M_S * sqrt(2.0) * 1.001, extremes.tool_speed_m_s);
    EXPECT_ABOVE(SPEED_M_S, extremes.tool_speed_m_s); // Each direction reaches its speed limit.
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_BELOW(limits.acceleration_rad_s2[i] * 1.0001, extremes.acceleration_rad_s2[i]);
    }
}

static void within_the_dead_band_the_tool_rests_and_beyond_it_moves_without_a_step(void)
{
    const double first[2]        = {0.1, 0.1};
    const double inside[2]       = {0.109, 0.091};
    const double beyond[2]       = {0.16, 0.1};
    setup.settings.dead_band_rad = 0.01;
    lead(first, 1U);
    lead(inside, 1000U);
    expect_offset(0.0, 0.0, 0.0, 1.0e-12);
    lead(beyond, 2000U);
    expect_offset(0.05 * SCALE_M_RAD, 0.0, 0.0, 1.0e-6);
}

static void the_range_of_the_hand_ends_the_motion(void)
{
    const double first[2]  = {0.0, 0.0};
    const double far[2]    = {3.0, 0.0};
    setup.settings.range_m = 0.03;
    lead(first, 1U);
    lead(far, 2000U);
    expect_offset(0.03, 0.0, 0.0, 1.0e-6);
}

static void without_the_hand_the_tool_comes_to_rest_and_waits(void)
{
    const double first[2] = {0.0, 0.0};
    const double then[2]  = {0.4, 0.0};
    const double other[2] = {-0.3, 0.3};
    lead(first, 1U);
    lead(then, 200U); // The tool moves at its full speed.
    const double before_m = hand.offset_m[0];
    lead(NULL, 1000U);
    TEST_ASSERT_EQUAL(ARM_HAND_MISSING, hand.state);
    EXPECT_WITHIN(before_m, SPEED_M_S * SPEED_M_S / (2.0 * limits.tool_acceleration_m_s2), hand.offset_m[0]);
    EXPECT_BELOW(1.0e-9, fabs(motion.velocity_rad_s[1]));
    const arm_vector_t rest = tool().position_m;
    lead(other, 1000U); // The hand continues from here.
    EXPECT_BELOW(1.0e-6, arm_length(arm_difference(tool().position_m, rest)));
    TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
}

static void an_angle_that_is_not_a_number_counts_as_no_hand(void)
{
    const double first[2]    = {0.0, 0.0};
    const double nan_[2]     = {0.0, (double)NAN};
    const double infinite[2] = {(double)INFINITY, 0.0};
    lead(first, 1U);
    lead(nan_, 10U);
    TEST_ASSERT_EQUAL(ARM_HAND_MISSING, hand.state);
    lead(infinite, 10U);
    TEST_ASSERT_EQUAL(ARM_HAND_MISSING, hand.state);
    expect_offset(0.0, 0.0, 0.0, 1.0e-12);
}

/// Test each joint at each end of its range.
static void a_joint_stops_before_the_end_of_its_range_and_goes_back(void)
{
    const double first[2] = {0.0, 0.0};
    const double there[2] = {-0.8, -0.8};
    const double back[2]  = {0.0, 0.0};
    lead(first, 1U);
    lead(there, 3000U);
    const arm_motion_t free = motion;
    unsigned limited        = 0U;
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        const double way = free.position_rad[i] - rig_pose_rad[i];
        if (fabs(way) < 0.05) {
            continue;
        }
        double* const end  = (way > 0.0) ? &limits.upper_rad[i] : &limits.lower_rad[i];
        const double whole = *end;
        *end               = rig_pose_rad[i] + (0.5 * way);
        begin(rig_pose_rad);
        lead(first, 1U);
        lead(there, 3000U);
        TEST_ASSERT_EQUAL(ARM_HAND_POSITION, hand.state);
        TEST_ASSERT_TRUE((motion.position_rad[i] <= limits.upper_rad[i]) &&
                         (motion.position_rad[i] >= limits.lower_rad[i]));
        EXPECT_WITHIN(*end, 0.02, motion.position_rad[i]);
        EXPECT_BELOW(limits.acceleration_rad_s2[i] * 1.0001, extremes.acceleration_rad_s2[i]);
        lead(back, 3000U);
        TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
        expect_offset(0.0, 0.0, 0.0, 1.0e-5);
        *end = whole;
        limited++;
    }
    TEST_ASSERT_TRUE(limited >= 2U);
}

static void a_joint_beyond_its_range_only_goes_back(void)
{
    const double first[2] = {0.0, 0.0};
    const double out[2]   = {0.0, -0.4};
    const double in[2]    = {0.0, 0.4};
    limits.upper_rad[2]   = rig_pose_rad[2] - 0.02; // The angle increases when the tool moves down.
    lead(first, 1U);
    lead(out, 1000U);
    TEST_ASSERT_EQUAL(ARM_HAND_POSITION, hand.state);
    expect_offset(0.0, 0.0, 0.0, 1.0e-6);
    lead(in, 1000U);
    EXPECT_ABOVE(0.03, tool().position_m.at[2] - start.position_m.at[2]);
}

static void a_joint_at_its_speed_slows_the_tool_down(void)
{
    const double first[2] = {0.0, 0.0};
    const double there[2] = {0.0, 0.6};
    limits.speed_rad_s[1] = 0.05;
    lead(first, 1U);
    lead(there, 400U);
    TEST_ASSERT_EQUAL(ARM_HAND_SPEED, hand.state);
    EXPECT_BELOW(0.05 * 1.0001, extremes.speed_rad_s[1]);
    lead(there, 8000U);
    expect_offset(0.0, 0.0, 0.12, 1.0e-5);
    TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
}

/// The hand leads the tool out of reach: the arm stretches, stays near the edge of its reach with slow
/// joints, and comes back.
static void at_the_edge_of_its_reach_the_tool_waits_for_the_hand(void)
{
    const double first[2]  = {0.0, 0.0};
    const double far[2]    = {-10.0, 0.0};
    setup.settings.range_m = 2.0;
    lead(first, 1U);
    lead(far, 10000U);
    TEST_ASSERT_EQUAL(ARM_HAND_SINGULAR, hand.state);
    EXPECT_ABOVE(0.1, start.position_m.at[0] - tool().position_m.at[0]);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_BELOW(limits.speed_rad_s[i] * 1.0001, extremes.speed_rad_s[i]);
        EXPECT_BELOW(1.0e-3, fabs(motion.velocity_rad_s[i]));
    }
    const arm_vector_t moved = arm_difference(tool().position_m, start.position_m);
    EXPECT_BELOW(3.0 * limits.tolerance, fabs(moved.at[1]));
    EXPECT_BELOW(3.0 * limits.tolerance, fabs(moved.at[2]));
    // The elbow has not passed through the straight pose.
    TEST_ASSERT_EQUAL(motion.position_rad[2] > 0.0, rig_pose_rad[2] > 0.0);
    lead(first, 20000U);
    expect_offset(0.0, 0.0, 0.0, 1.0e-4);
    TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
}

/// Three joints move the position; the orientation is not controlled.
static void with_three_joints_only_the_position_follows_the_hand(void)
{
    const double first[2] = {0.0, 0.0};
    const double then[2]  = {0.2, -0.2};
    model.joint_count     = 3U;
    model.tool.position_m = (arm_vector_t){{-0.39, 0.0, 0.1}};
    begin(rig_pose_rad);
    lead(first, 1U);
    lead(then, 2000U);
    expect_offset(0.04, 0.0, -0.04, 1.0e-5);
    TEST_ASSERT_EQUAL(ARM_HAND_LEADS, hand.state);
}

static const arm_rotation_t unrotated = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};

/// A bent arm of two joints with parallel axes along y, whose tool moves in a plane.
static void begin_in_a_plane(void)
{
    const double bent[RIG_JOINTS] = {0.3, 0.8, 0.0, 0.0, 0.0, 0.0};
    const arm_pose_t outer        = {.rotation = unrotated, .position_m = {{0.5, 0.0, 0.0}}};
    model                         = (arm_model_t){.joint_count = 2U, .tool = outer};
    model.link[0] = (arm_link_t){.origin = {.rotation = unrotated}, .axis = {{0.0, 1.0, 0.0}}};
    model.link[1] = (arm_link_t){.origin = outer, .axis = {{0.0, 1.0, 0.0}}};
    begin(bent);
}

static void a_direction_that_the_joints_do_not_have_is_ignored(void)
{
    const double first[2] = {0.0, 0.0};
    const double then[2]  = {0.2, 0.2};
    const double aside[6] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    arm_hand_directions(aside, setup.settings.direction);
    begin_in_a_plane();
    lead(first, 1U);
    lead(then, 2000U);
    expect_offset(0.04, 0.0, 0.0, 1.0e-5);
}

/// The joints can perform only a part of the motion, and this part would move the tool off its line.
static void a_direction_that_the_joints_have_in_part_only_is_not_followed(void)
{
    const double first[2] = {0.0, 0.0};
    const double then[2]  = {0.4, 0.0};
    const double skew[6]  = {1.0, 1.0, 0.0, 0.0, 0.0, 0.0};
    arm_hand_directions(skew, setup.settings.direction);
    begin_in_a_plane();
    lead(first, 1U);
    lead(then, 2000U);
    EXPECT_BELOW(limits.tolerance, arm_length(arm_difference(tool().position_m, start.position_m)));
}

static void directions_become_perpendicular_and_of_length_1(void)
{
    const double skew[6] = {3.0, 0.0, 0.0, 1.0, 2.0, 0.0};
    const double none[6] = {0.0, 0.0, 0.0, 0.0, 5.0, 0.0};
    const double at[2]   = {0.0, 0.0};
    const double then[2] = {0.4, 0.2};
    arm_hand_directions(skew, setup.settings.direction);
    EXPECT_WITHIN(1.0, 1.0e-12, setup.settings.direction[0].at[0]);
    EXPECT_WITHIN(0.0, 1.0e-12, setup.settings.direction[1].at[0]);
    EXPECT_WITHIN(1.0, 1.0e-12, setup.settings.direction[1].at[1]);
    arm_hand_directions(none, setup.settings.direction);
    lead(at, 1U);
    lead(then, 2000U); // The first axis of the hand has no effect.
    expect_offset(0.0, 0.04, 0.0, 1.0e-6);
}

int main(void)
{
    UNITY_BEGIN();
    rig_load();
    RUN_TEST(coupling_the_hand_does_not_move_the_tool);
    RUN_TEST(the_tool_moves_by_the_scale_and_keeps_the_rest_of_its_pose);
    RUN_TEST(within_the_dead_band_the_tool_rests_and_beyond_it_moves_without_a_step);
    RUN_TEST(the_range_of_the_hand_ends_the_motion);
    RUN_TEST(without_the_hand_the_tool_comes_to_rest_and_waits);
    RUN_TEST(an_angle_that_is_not_a_number_counts_as_no_hand);
    RUN_TEST(a_joint_stops_before_the_end_of_its_range_and_goes_back);
    RUN_TEST(a_joint_beyond_its_range_only_goes_back);
    RUN_TEST(a_joint_at_its_speed_slows_the_tool_down);
    RUN_TEST(at_the_edge_of_its_reach_the_tool_waits_for_the_hand);
    RUN_TEST(with_three_joints_only_the_position_follows_the_hand);
    RUN_TEST(a_direction_that_the_joints_do_not_have_is_ignored);
    RUN_TEST(a_direction_that_the_joints_have_in_part_only_is_not_followed);
    RUN_TEST(directions_become_perpendicular_and_of_length_1);
    return UNITY_END();
}
