// SPDX-License-Identifier: Apache-2.0
// Trajectories through via points: limits, smoothness, distance from the points, and stopping.
#include "fsw/subsystems/arm/arm_path.h"
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_S 0.001
#define STEPS_MAX 200000U
#define CASES 200U
#define ROUNDING 1.0e-9

static arm_model_t model;
static arm_limits_t limits;
static arm_motion_t start;
static arm_trajectory_t trajectory;
static uint32_t seed;

void setUp(void)
{
    rig_model(&model, &limits);
    start = (arm_motion_t){.position_rad = {0.0}};
    memcpy(start.position_rad, rig_pose_rad, sizeof rig_pose_rad);
    arm_trajectory_clear(&trajectory);
    seed = 1U;
}

void tearDown(void)
{
}

/// Returns a pseudo-random number from 0 to 1; the same sequence in each run.
static double drawn(void)
{
    seed = (seed * 1664525U) + 1013904223U;
    return (double)(seed >> 8) / 16777216.0;
}

static void plan(const double share, const double blend)
{
    status_t status = STATUS_BUSY;
    arm_trajectory_begin(&trajectory, &limits, &start, share, blend);
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < ARM_PLAN_ROUNDS); i++) {
        status = arm_trajectory_plan(&trajectory, &limits);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
}

static void add(const double point_rad[ARM_JOINTS_MAX])
{
    TEST_ASSERT_EQUAL(STATUS_OK, arm_trajectory_add(&trajectory, &model, point_rad));
}

/// Expect that velocities are the differences of positions, accelerations those of velocities, and that none
/// exceeds its limit.
static void expect_smooth(const arm_motion_t* const last, const arm_motion_t* const motion,
                          const double share)
{
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        const double speed  = (motion->position_rad[i] - last->position_rad[i]) / PERIOD_S;
        const double change = (motion->velocity_rad_s[i] - last->velocity_rad_s[i]) / PERIOD_S;
        const double most   = share * limits.acceleration_rad_s2[i];
        EXPECT_WITHIN(0.5 * (motion->velocity_rad_s[i] + last->velocity_rad_s[i]), 1.0e-3, speed);
        // The acceleration has no step: a blend takes at least 50 ms, and its jerk is limited.
        EXPECT_WITHIN(last->acceleration_rad_s2[i], most * 4.0 * PERIOD_S / 0.05,
                      motion->acceleration_rad_s2[i]);
        EXPECT_WITHIN(0.5 * (motion->acceleration_rad_s2[i] + last->acceleration_rad_s2[i]), 1.0e-2 * most,
                      change);
        TEST_ASSERT_TRUE(fabs(motion->velocity_rad_s[i]) <= (share * limits.speed_rad_s[i]) + ROUNDING);
        TEST_ASSERT_TRUE(fabs(motion->acceleration_rad_s2[i]) <= most + ROUNDING);
    }
}

/// Returns the largest distance between two poses in any joint.
static double distance(const double a[ARM_JOINTS_MAX], const double b[ARM_JOINTS_MAX])
{
    double largest = 0.0;
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

/// Run the trajectory. `out_nearest` is the smallest distance of the joints from each point, in the order of
/// the points.
static void fly(const double share, double out_nearest[ARM_POINTS_MAX])
{
    const double duration_s = arm_trajectory_duration_s(&trajectory);
    unsigned next           = 1U;
    arm_motion_t motion;
    arm_motion_t last = start;
    arm_trajectory_at(&trajectory, 0.0, &motion);
    TEST_ASSERT_EQUAL_MEMORY(start.position_rad, motion.position_rad, sizeof rig_pose_rad);
    for (unsigned i = 0U; i < ARM_POINTS_MAX; i++) {
        out_nearest[i] = HUGE_VAL;
    }
    for (unsigned step = 1U; step < STEPS_MAX; step++) {
        motion = start;
        arm_trajectory_at(&trajectory, step * PERIOD_S, &motion);
        expect_smooth(&last, &motion, share);
        const double here = distance(motion.position_rad, trajectory.point[next]);
        if (here < out_nearest[next - 1U]) {
            out_nearest[next - 1U] = here;
        }
        if ((next < trajectory.point_count) && (out_nearest[next - 1U] <= trajectory.blend)) {
            const double further = distance(motion.position_rad, trajectory.point[next + 1U]);
            out_nearest[next]    = further;
            next++;
        }
        last = motion;
        if ((step * PERIOD_S) > (duration_s + PERIOD_S)) {
            break;
        }
    }
    TEST_ASSERT_EQUAL_UINT(trajectory.point_count, next);
    TEST_ASSERT_EQUAL_MEMORY(trajectory.point[trajectory.point_count], motion.position_rad,
                             sizeof rig_pose_rad);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        TEST_ASSERT_TRUE((motion.velocity_rad_s[i] == 0.0) && (motion.acceleration_rad_s2[i] == 0.0));
    }
}

static void random_points_are_passed_in_order_within_the_limits(void)
{
    for (unsigned k = 0U; k < CASES; k++) {
        const unsigned count = 1U + (unsigned)(drawn() * (ARM_POINTS_MAX - 1U));
        const double share   = 0.1 + (0.9 * drawn());
        const double blend   = 0.002 + (0.3 * drawn());
        const double wide    = (k % 4U == 0U) ? 0.01 : 2.0;
        double nearest[ARM_POINTS_MAX];
        arm_trajectory_clear(&trajectory);
        for (unsigned n = 0U; n < count; n++) {
            double point[ARM_JOINTS_MAX] = {0.0};
            for (unsigned i = 0U; i < RIG_JOINTS; i++) {
                point[i] = rig_pose_rad[i] + (wide * (drawn() - 0.5));
            }
            add(point);
        }
        plan(share, blend);
        fly(share, nearest);
        for (unsigned n = 0U; (n + 1U) < count; n++) {
            TEST_ASSERT_TRUE(nearest[n] <= blend + ROUNDING);
        }
    }
}

/// Two points on one line: the joint passes the first at full speed.
static void a_point_on_the_line_is_passed_at_full_speed(void)
{
    double point[ARM_JOINTS_MAX];
    memcpy(point, start.position_rad, sizeof point);
    point[0] += 1.5;
    add(point);
    point[0] += 1.5;
    add(point);
    plan(1.0, 0.01);
    arm_motion_t motion = start;
    arm_trajectory_at(&trajectory, 0.5 * arm_trajectory_duration_s(&trajectory), &motion);
    EXPECT_WITHIN(start.position_rad[0] + 1.5, 1.0e-9, motion.position_rad[0]);
    EXPECT_WITHIN(limits.speed_rad_s[0], 1.0e-9, motion.velocity_rad_s[0]);
    // From rest to rest: 3 rad at the limit, and half a blend of 1.5 v / a at each end.
    const double blend_s = 1.5 * limits.speed_rad_s[0] / limits.acceleration_rad_s2[0];
    EXPECT_WITHIN((3.0 / limits.speed_rad_s[0]) + blend_s, 1.0e-9, arm_trajectory_duration_s(&trajectory));
}

/// At a point where a joint reverses, a smaller blend needs a lower speed.
static void a_smaller_blend_takes_longer(void)
{
    double point[ARM_JOINTS_MAX];
    double nearest[ARM_POINTS_MAX];
    double last_s = 0.0;
    for (double blend = 0.2; blend > 0.0002; blend *= 0.2) {
        memcpy(point, start.position_rad, sizeof point);
        arm_trajectory_clear(&trajectory);
        point[0] += 1.0;
        add(point);
        point[0] -= 1.0;
        add(point);
        plan(1.0, blend);
        fly(1.0, nearest);
        TEST_ASSERT_TRUE(nearest[0] <= blend);
        TEST_ASSERT_TRUE(nearest[0] >= 0.7 * blend); // The speed is not lower than necessary.
        TEST_ASSERT_TRUE(arm_trajectory_duration_s(&trajectory) > last_s);
        last_s = arm_trajectory_duration_s(&trajectory);
    }
}

static void equal_points_cause_no_motion(void)
{
    double nearest[ARM_POINTS_MAX];
    add(start.position_rad);
    add(start.position_rad);
    plan(1.0, 0.01);
    fly(1.0, nearest);
    TEST_ASSERT_TRUE(arm_trajectory_duration_s(&trajectory) < 0.5);
    for (double time_s = 0.0; time_s < 0.5; time_s += PERIOD_S) {
        arm_motion_t motion = start;
        arm_trajectory_at(&trajectory, time_s, &motion);
        TEST_ASSERT_TRUE(distance(start.position_rad, motion.position_rad) == 0.0);
    }
}

static void a_trajectory_has_at_most_sixteen_points(void)
{
    TEST_ASSERT_EQUAL(16U, ARM_POINTS_MAX); // As docs/arm.md says.
    for (unsigned i = 0U; i < ARM_POINTS_MAX; i++) {
        add(start.position_rad);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, arm_trajectory_add(&trajectory, &model, start.position_rad));
}

/// Planning ends after ARM_PLAN_ROUNDS even if the duration of a line is not a number, which no comparison
/// accepts.
static void planning_always_ends(void)
{
    double point[ARM_JOINTS_MAX];
    status_t status = STATUS_BUSY;
    memcpy(point, start.position_rad, sizeof point);
    point[0] += 1.0;
    add(point);
    arm_trajectory_begin(&trajectory, &limits, &start, 1.0, 0.1);
    trajectory.line_s[0] = (double)NAN;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < ARM_PLAN_ROUNDS); i++) {
        status = arm_trajectory_plan(&trajectory, &limits);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, status);
}

/// A stop keeps the joints on their path: it slows them down along it.
static void a_stop_brakes_along_the_path(void)
{
    arm_path_t path;
    double point[ARM_JOINTS_MAX];
    memcpy(point, start.position_rad, sizeof point);
    point[0] += 0.5;
    point[1] += 0.3;
    add(point);
    point[1] -= 0.6;
    point[4] -= 0.2;
    add(point);
    plan(1.0, 0.1);
    for (double after_s = 0.05; after_s < arm_trajectory_duration_s(&trajectory); after_s += 0.05) {
        arm_motion_t motion = start;
        arm_motion_t last   = start;
        double time_s       = 0.0;
        arm_path_begin_trajectory(&path, &trajectory);
        for (unsigned step = 1U; !arm_path_is_done(&path); step++) {
            (void)arm_path_step(&path, &model, &limits, PERIOD_S, &motion);
            if ((step * PERIOD_S >= after_s) && !path.is_slowing) {
                arm_path_stop(&path, &model, &limits, &motion);
            }
            time_s = path.is_slowing ? time_s : step * PERIOD_S;
            for (unsigned i = 0U; i < RIG_JOINTS; i++) {
                // The accelerations of the stop add to those of the blends (arm_path_stop).
                TEST_ASSERT_TRUE(fabs(motion.acceleration_rad_s2[i]) <=
                                 (2.0 * limits.acceleration_rad_s2[i]) + ROUNDING);
                EXPECT_WITHIN(last.position_rad[i], (limits.speed_rad_s[i] * PERIOD_S) + ROUNDING,
                              motion.position_rad[i]);
            }
            last = motion;
        }
        // Find a point of the trajectory after the beginning of the stop.
        double nearest = HUGE_VAL;
        for (double t = time_s; t <= arm_trajectory_duration_s(&trajectory) + PERIOD_S; t += PERIOD_S) {
            arm_motion_t there = start;
            arm_trajectory_at(&trajectory, t, &there);
            nearest = fmin(nearest, distance(there.position_rad, motion.position_rad));
        }
        TEST_ASSERT_TRUE(nearest < 0.002);
        for (unsigned i = 0U; i < RIG_JOINTS; i++) {
            TEST_ASSERT_TRUE(motion.velocity_rad_s[i] == 0.0);
        }
    }
}

int main(void)
{
    rig_load();
    UNITY_BEGIN();
    RUN_TEST(random_points_are_passed_in_order_within_the_limits);
    RUN_TEST(a_point_on_the_line_is_passed_at_full_speed);
    RUN_TEST(a_smaller_blend_takes_longer);
    RUN_TEST(equal_points_cause_no_motion);
    RUN_TEST(a_trajectory_has_at_most_sixteen_points);
    RUN_TEST(planning_always_ends);
    RUN_TEST(a_stop_brakes_along_the_path);
    return UNITY_END();
}
