// SPDX-License-Identifier: Apache-2.0
// Function commands of the subsystem arm for trajectories through points.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <math.h>

void setUp(void)
{
    rig_set_up();
}

void tearDown(void)
{
    rig_tear_down();
}

static void idle_until_a_result(const unsigned cycles)
{
    for (unsigned i = 0U; (i < cycles) && (rig_generic.result_count == 0U); i++) {
        (void)rig_cycle(NULL);
    }
}

static const rig_move_through_t through = {.share = 1.0, .blend = 0.05};

static void points_are_passed_without_a_stop(void)
{
    const double first[RIG_JOINTS] = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5};
    const double last[RIG_JOINTS]  = {0.6, -1.0, 1.4, -1.3, -1.4, 0.8};
    unsigned cycles                = 0U;
    double slowest_rad_s           = HUGE_VAL;
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, first, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, last, 2U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_VIA, &through, 3U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_MOVE_VIA, &through, 4U));
    for (; (cycles < 4000U) && (rig_generic.result_count == 0U); cycles++) {
        rig_idle(1U);
        // The first joint moves during the whole trajectory.
        const double* const at = rig_arm.motion.position_rad;
        if ((at[0] > 0.1) && (at[0] < 0.5)) {
            slowest_rad_s = fmin(slowest_rad_s, rig_arm.motion.velocity_rad_s[0]);
        }
        if (cycles == 200U) { // A point for the next trajectory, while the present one runs.
            TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, first, 5U));
        }
    }
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(3U, rig_generic.results[0].call_token);
    TEST_ASSERT_TRUE(slowest_rad_s > 0.2);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        EXPECT_WITHIN(last[i], 1.0e-12, rig_arm.motion.position_rad[i]);
    }
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_VIA, &through, 6U));
    idle_until_a_result(4000U);
    EXPECT_WITHIN(first[0], 1.0e-12, rig_arm.motion.position_rad[0]);
}

static void expect_no_points(const uint32_t call_token)
{
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_MOVE_VIA, &through, call_token));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 4U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_generic.results[0].detail);
}

static void points_that_are_missing_too_many_or_out_of_range_are_refused(void)
{
    double point[RIG_JOINTS]      = {0.3, -1.2, 1.2, -1.3, -1.4, 0.5};
    const rig_move_through_t none = {.share = 1.0, .blend = (double)NAN};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    expect_no_points(1U);
    for (unsigned i = 0U; i < ARM_POINTS_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, point, 2U));
    }
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_ADD_VIA, point, 3U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 4U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_MOVE_VIA, &none, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_CLR_VIA, NULL, 5U));
    expect_no_points(6U);
    point[4]                 = 7.0;
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(RIG_ADD_VIA, point, 7U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 1U, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(5U, rig_generic.results[0].detail);
    expect_no_points(8U);
}

/// STOP works while the trajectory is planned and while it runs. When the actuators are disengaged, motion
/// and points are discarded.
static void stop_and_disengaging_end_a_trajectory(void)
{
    const double point[RIG_JOINTS] = {0.6, -1.2, 1.2, -1.3, -1.4, 0.5};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, rig_pose_rad, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, point, 1U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_VIA, &through, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 3U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_idle(100U);
    EXPECT_WITHIN(rig_pose_rad[0], 0.001, rig_arm.motion.position_rad[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, point, 4U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_VIA, &through, 5U));
    rig_idle(300U);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, point, 6U));
    rig_generic.result_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_STOP, NULL, 7U));
    idle_until_a_result(1000U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    TEST_ASSERT_TRUE(fabs(rig_arm.motion.position_rad[0] - point[0]) > 0.01);
    (void)rig_cycle(rig_generic.callbacks->disengage);
    rig_idle(10U);
    TEST_ASSERT_EQUAL_UINT(0U, rig_arm.points.point_count);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(RIG_ADD_VIA, point, 8U));
}

/// Durations that are not numbers never fulfil the limits: the command fails and the arm does not move.
static void a_plan_without_an_end_is_refused(void)
{
    const double point[RIG_JOINTS] = {0.6, -1.2, 1.2, -1.3, -1.4, 0.5};
    rig_bring(RIG_POSITION, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(RIG_ADD_VIA, point, 1U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(RIG_MOVE_VIA, &through, 2U));
    rig_arm.trajectory.line_s[0] = (double)NAN;
    const double before          = rig_arm.motion.position_rad[0];
    idle_until_a_result(ARM_PLAN_ROUNDS + 1U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OWN + 4U, rig_generic.results[0].code);
    EXPECT_WITHIN(before, 1.0e-12, rig_arm.motion.position_rad[0]);
}

int main(void)
{
    rig_load();
    UNITY_BEGIN();
    RUN_TEST(points_are_passed_without_a_stop);
    RUN_TEST(points_that_are_missing_too_many_or_out_of_range_are_refused);
    RUN_TEST(a_plan_without_an_end_is_refused);
    RUN_TEST(stop_and_disengaging_end_a_trajectory);
    return UNITY_END();
}
