// SPDX-License-Identifier: Apache-2.0
// The stand-alone manipulator: commanded motions.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/manipulator/manipulator_rig.h"

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

static void move_to_reaches_the_target_in_the_given_time(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL_UINT(1U, rig_joints[0]->last_pdo); // Position mode.
    const manipulator_move_to_arguments_t to = {{0.9, -1.3}, 0.8};
    int32_t before                           = rig_joints[0]->target_position;
    TEST_ASSERT_INT32_WITHIN(50, rig_joints[0]->position[0], before);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 77U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 78U));
    const uint64_t begun_ns = rig_generic.now_ns;
    while ((rig_generic.result_count == 0U) && ((rig_generic.now_ns - begun_ns) < 2000000000U)) {
        (void)rig_cycle(NULL);
        TEST_ASSERT_INT32_WITHIN(500, before, rig_joints[0]->target_position); // 1 rad/s at most.
        before = rig_joints[0]->target_position;
    }
    TEST_ASSERT_UINT64_WITHIN(1000000U, 800000000U, rig_generic.now_ns - begun_ns);
    TEST_ASSERT_EQUAL_UINT32(77U, rig_generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_generic.results[0].detail);
    rig_idle(3000U);
    // The positions of drive and link differ by the deflection of the gear.
    EXPECT_WITHIN(0.9, 0.001, 1.0e-6 * (double)rig_joints[0]->target_position);
    EXPECT_WITHIN(-1.3, 0.001, 1.0e-6 * (double)rig_joints[1]->target_position);
    EXPECT_WITHIN(0.9, 1.0e-12, rig_manipulator.parameters.des_position[0]);
}

static void move_to_refuses_an_impermissible_motion(void)
{
    const struct {
        manipulator_move_to_arguments_t to;
        status_t status;
    } cases[] = {
        // Beyond the range around the home pose.
        {{{1.0471975511966 + 1.6, -1.57}, 100.0}, STATUS_OUT_OF_RANGE},
        {{{1.0, -1.5707963267949 - 1.6}, 100.0}, STATUS_OUT_OF_RANGE},
        {{{0.5, -1.57}, 0.9}, STATUS_OUT_OF_RANGE}, // Faster than the speed limit.
        {{{1.0, -1.57}, 0.0}, STATUS_OUT_OF_RANGE},
        {{{1.0, -1.57}, -1.0}, STATUS_OUT_OF_RANGE},
        {{{(double)NAN, -1.57}, 1.0}, STATUS_OUT_OF_RANGE},
        {{{1.0, -1.57}, (double)NAN}, STATUS_OUT_OF_RANGE},
        {{{(double)INFINITY, -1.57}, 1.0}, STATUS_OUT_OF_RANGE},
    };
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    const manipulator_move_to_arguments_t good = {{1.0, -1.5}, 1.0};
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &good, 1U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(MANIPULATOR_FUNCTION_STOP, NULL, 1U));
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    const int32_t target = rig_joints[0]->target_position;
    for (unsigned i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(cases[i].status, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &cases[i].to, 1U));
        rig_idle(3U);
        TEST_ASSERT_INT32_WITHIN(20, target, rig_joints[0]->target_position);
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rig_perform(99U, NULL, 1U));
}

static void stop_ends_a_motion_smoothly(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    const manipulator_move_to_arguments_t to = {{0.5, -1.5}, 1.5};
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 4U));
    rig_idle(1500U);
    const int32_t before = rig_joints[0]->target_position;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_STOP, NULL, 5U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_idle(1000U);
    const int32_t after = rig_joints[0]->target_position;
    TEST_ASSERT_TRUE((after < before) && (after > (before - 80000))); // v^2 / 2a = 0.6^2 / 8 = 0.05 rad.
    rig_idle(100U);
    TEST_ASSERT_INT32_WITHIN(20, after, rig_joints[0]->target_position);
    // The next motion is accepted.
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 6U));
}

static void leaving_operation_aborts_a_motion(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    const manipulator_move_to_arguments_t to = {{0.5, -1.5}, 1.5};
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 4U));
    rig_idle(500U);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->disengage);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_idle(10U); // The arm is held in its pose.
    TEST_ASSERT_INT32_WITHIN(20, rig_joints[0]->position[0], rig_joints[0]->target_position);
}

static void setting_the_desired_position_moves_the_arm(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    rig_manipulator.parameters.des_position[0] = 0.95;
    rig_manipulator.parameters.des_position[1] = -1.45;
    rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_DES_POSITION);
    rig_idle(4000U);
    EXPECT_WITHIN(0.95, 1.0e-12, rig_manipulator.parameters.des_position[0]);
    EXPECT_WITHIN(-1.45, 0.001, 1.0e-6 * (double)rig_joints[1]->target_position);
    // A value out of range is replaced by the position of the arm.
    rig_manipulator.parameters.des_position[0] = 2.75;
    rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_DES_POSITION);
    rig_idle(10U);
    EXPECT_WITHIN(0.95, 1.0e-12, rig_manipulator.parameters.des_position[0]);
    // Setting another parameter starts no motion.
    rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_CONTROL);
    TEST_ASSERT_FALSE(rig_manipulator.is_moving);
}

static void position_mode_engages_in_contact(void)
{
    rig_show(GRAVITY1 + 11.0, GRAVITY2 + 8.0);
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    EXPECT_WITHIN(11.0 + GRAVITY1, 0.3,
                  0.01 * (double)rig_joints[0]->torque_offset); // The arm keeps the torque that it carries.
    rig_idle(4000U);
    // Then it reduces the torque slowly.
    EXPECT_WITHIN(GRAVITY1, 0.1, 0.01 * (double)rig_joints[0]->torque_offset);
}

/// A motion starts at the present pose, also if it is commanded in the cycle in which the arm is engaged.
static void a_motion_begins_at_the_present_pose(void)
{
    const manipulator_move_to_arguments_t to = {{0.9, -1.3}, 1.0};
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_cycle(rig_callbacks->engage));
    rig_joints[0]->position[0] += 30000; // The arm was moved by hand while the brakes were released.
    rig_idle(3U);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_callbacks->engage(&rig_manipulator));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 1U));
    rig_idle(1U);
    TEST_ASSERT_INT32_WITHIN(500, rig_joints[0]->position[0], rig_joints[0]->target_position);
}

static void a_motion_ends_once(void)
{
    const manipulator_move_to_arguments_t to = {{1.0, -1.5}, 0.5};
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 4U));
    rig_idle(1200U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_STOP, NULL, 5U));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->disengage);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
}

/// The ends of the range and the shortest duration are accepted.
static void a_motion_may_use_the_whole_range_and_the_shortest_time(void)
{
    manipulator_control_t* const gains = &rig_manipulator.parameters.control;
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    for (unsigned i = 0U; i < 2U; i++) {
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            manipulator_move_to_arguments_t to = {{gains->home[0], gains->home[1]}, 100.0};
            to.position[i]                     = gains->home[i] + (sign * gains->range[i] * 0.999999);
            TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &to, 1U));
            TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_STOP, NULL, 2U));
        }
    }
    manipulator_move_to_arguments_t here = {
        {rig_manipulator.point[0].position, rig_manipulator.point[1].position}, 0.1};
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &here, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_STOP, NULL, 2U));
    here.duration = 0.0999;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &here, 1U));
    gains->home[0]                            = 0.0; // So that the ends of the range have no rounding error.
    gains->home[1]                            = 0.0;
    const manipulator_move_to_arguments_t end = {{gains->range[0], -gains->range[1]}, 100.0};
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_MOVE_TO, &end, 1U));
}

/// The motion uses half of the speed limit for the joint with the longer way.
static void setting_the_desired_position_takes_the_time_of_the_longer_way(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    const double speed = 0.5 * rig_manipulator.parameters.control.speed_limit;
    const double way   = 0.3;
    for (unsigned joint = 0U; joint < 2U; joint++) {
        double fastest  = 0.0;
        unsigned cycles = 0U;
        rig_manipulator.parameters.des_position[joint] += way;
        rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_DES_POSITION);
        while (rig_manipulator.is_moving && (cycles < 20000U)) {
            rig_idle(1U);
            fastest = fmax(fastest, fabs(rig_manipulator.point[joint].velocity));
            cycles++;
        }
        EXPECT_WITHIN(speed, 0.001 * speed, fastest);
        // The peak speed of the motion is 1.875 times its mean speed.
        EXPECT_WITHIN(1.875 * way / speed, 0.002, 0.0005 * (double)cycles);
    }
    TEST_ASSERT_EQUAL_UINT(0U, rig_generic.result_count);
}

int main(void)
{
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(move_to_reaches_the_target_in_the_given_time);
    RUN_TEST(move_to_refuses_an_impermissible_motion);
    RUN_TEST(stop_ends_a_motion_smoothly);
    RUN_TEST(leaving_operation_aborts_a_motion);
    RUN_TEST(setting_the_desired_position_moves_the_arm);
    RUN_TEST(position_mode_engages_in_contact);
    RUN_TEST(a_motion_begins_at_the_present_pose);
    RUN_TEST(a_motion_ends_once);
    RUN_TEST(a_motion_may_use_the_whole_range_and_the_shortest_time);
    RUN_TEST(setting_the_desired_position_takes_the_time_of_the_longer_way);
    return UNITY_END();
}
