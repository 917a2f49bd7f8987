// SPDX-License-Identifier: Apache-2.0
// The manipulator in TELEPRESENCE_REMOTE, with a scripted joystick at the other end of a link with delay.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/manipulator/manipulator_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

void setUp(void)
{
    rig_set_up();
}

void tearDown(void)
{
    rig_tear_down();
}

static void far_hand_at(const double first_rad, const double second_rad, const double energy_j)
{
    const manipulator_hand_motion_payload_t hand = {.position = {first_rad, second_rad}, .energy = energy_j};
    memcpy(rig_generic.ports[FAR_HAND].sample, &hand, sizeof hand);
    rig_generic.ports[FAR_HAND].read_status = STATUS_OK;
    rig_generic.ports[FAR_HAND].age_us      = 20000U;
}

static manipulator_robot_contact_payload_t sent(void)
{
    manipulator_robot_contact_payload_t robot;
    TEST_ASSERT_EQUAL_UINT64(sizeof robot, rig_generic.ports[FAR_ROBOT].written_size);
    memcpy(&robot, rig_generic.ports[FAR_ROBOT].written, sizeof robot);
    return robot;
}

static void the_arm_follows_a_remote_hand_and_reports_the_command_it_acts_on(void)
{
    far_hand_at(0.21, -0.17, 3.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE_REMOTE, STATE_OPERATIONAL);
    rig_idle(10U);
    EXPECT_WITHIN(0.21, 1.0e-9, sent().echo[0]);
    // The arm is still in its home pose, with the second joint at -90 degrees: it follows only movements.
    EXPECT_WITHIN(0.5, 0.01, -rig_manipulator.control.reference[1].position / 3.1416);
    far_hand_at(0.21 + 0.001, -0.17, 3.0);
    rig_idle(400U);
    EXPECT_WITHIN(0.211, 1.0e-5, sent().echo[0]);
    EXPECT_WITHIN(-0.17, 1.0e-5, sent().echo[1]);
    // The scale of positions is 2.
    EXPECT_ABOVE(0.0015,
                 rig_manipulator.control.reference[0].position - rig_manipulator.control.link_zero_rad[0]);
    TEST_ASSERT_EQUAL_UINT32(20000U, rig_manipulator.parameters.link_age);
    TEST_ASSERT_EQUAL_UINT64(0U, rig_generic.ports[ROBOT].written_size);
    double jacobian[4];
    manipulator_arm_jacobian(&rig_manipulator.model, rig_manipulator.control.link_rad, jacobian);
    for (unsigned i = 0U; i < 4U; i++) {
        EXPECT_WITHIN(jacobian[i], 1.0e-3, sent().jacobian[i]);
    }
    rig_generic.ports[FAR_HAND].read_status = STATUS_STALE;
    rig_idle(400U); // The arm holds its pose.
    EXPECT_WITHIN(0.211, 1.0e-5, sent().echo[0]);
}

/// The torques are less than gravity: a force pushes the arm up. The arm presses down only with energy that
/// the hand has put in, and yields to a force above the limit.
static void the_arm_yields_to_a_force_and_presses_only_with_received_energy(void)
{
    far_hand_at(0.0, 0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE_REMOTE, STATE_OPERATIONAL);
    rig_show(GRAVITY1 - 3.0, GRAVITY2 - 2.0);
    rig_idle(400U);
    const manipulator_robot_contact_payload_t touch = sent();
    EXPECT_ABOVE(2.0, touch.external_torque[0]);
    EXPECT_ABOVE(5.0, touch.push);
    EXPECT_ABOVE(0.5, touch.normal[1]);
    for (unsigned i = 1U; i <= 100U; i++) {
        far_hand_at(-0.9e-4 * (double)i, -0.6e-4 * (double)i, 0.0);
        rig_idle(1U);
    }
    EXPECT_BELOW(0.5e-3, fabs(sent().echo[0]));
    for (unsigned i = 0U; i < 2000U; i++) {
        far_hand_at(-0.9e-2, -0.6e-2, 1.0e-5 * (double)i);
        rig_idle(1U);
    }
    EXPECT_WITHIN(-0.9e-2, 1.0e-4, sent().echo[0]);
    rig_show(GRAVITY1 - 12.0, GRAVITY2 - 8.0);
    rig_idle(1000U);
    EXPECT_ABOVE(5.0e-3, rig_manipulator.yield.given_way_m);
    EXPECT_ABOVE(-0.5e-2, sent().echo[0]);
    EXPECT_ABOVE(0.0, sent().energy);
}

int main(void)
{
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(the_arm_follows_a_remote_hand_and_reports_the_command_it_acts_on);
    RUN_TEST(the_arm_yields_to_a_force_and_presses_only_with_received_energy);
    return UNITY_END();
}
