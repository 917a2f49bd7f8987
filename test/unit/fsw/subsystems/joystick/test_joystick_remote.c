// SPDX-License-Identifier: Apache-2.0
// The joystick in TELEPRESENCE_REMOTE, with a scripted robot at the other end of a link with delay.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/joystick/joystick_rig.h"

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

/// The robot measures 15 N upwards. The sample contains the angle of the stick to which it has reacted, and
/// its energy.
static void robot_touches(const double first_rad, const double second_rad, const double energy_j)
{
    const double force[2]                  = {0.0, 15.0};
    joystick_robot_contact_payload_t robot = {.echo     = {first_rad, second_rad},
                                              .jacobian = {-0.0655, 0.125, 0.3265, 0.2165},
                                              .normal   = {0.0, 1.0},
                                              .push     = 15.0,
                                              .energy   = energy_j};
    control_planar_torque(robot.jacobian, force, robot.external_torque);
    memcpy(rig_generic.ports[FAR_ROBOT].sample, &robot, sizeof robot);
    rig_generic.ports[FAR_ROBOT].read_status = STATUS_OK;
    rig_generic.ports[FAR_ROBOT].age_us      = 20000U;
}

static joystick_hand_motion_payload_t sent(void)
{
    joystick_hand_motion_payload_t hand;
    TEST_ASSERT_EQUAL_UINT64(sizeof hand, rig_generic.ports[FAR_HAND].written_size);
    memcpy(&hand, rig_generic.ports[FAR_HAND].written, sizeof hand);
    return hand;
}

static void a_hand_at_rest_feels_the_far_robot_and_a_moving_hand_the_model(void)
{
    robot_touches(0.05, -0.02, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE_REMOTE, STATE_OPERATIONAL);
    rig_idle(8000U);
    // The torque is FORCE_SCALE (0.03) times the force times the Jacobian.
    EXPECT_WITHIN(0.03 * 15.0 * 0.3265, 2.0e-4, rig_torque(0U));
    EXPECT_WITHIN(0.03 * 15.0 * 0.2165, 2.0e-4, rig_torque(1U));
    TEST_ASSERT_EQUAL_UINT32(20000U, rig_joystick.parameters.link_age);
    TEST_ASSERT_EQUAL_UINT64(0U, rig_generic.ports[HAND].written_size);
    EXPECT_WITHIN(0.05, 1.0e-9, sent().position[0]);
    EXPECT_WITHIN(-0.02, 1.0e-9, sent().position[1]);
    rig_stick->position[0] -= 500; // The stick moves 0.5 mrad down after the last report of the robot.
    rig_idle(4000U);
    // The model adds STIFFNESS (7000 N/m) times POSITION_SCALE (2) times this motion.
    const double model = 7000.0 * 2.0 * 0.5e-3 * ((0.3265 * 0.3265) + (0.0655 * 0.0655));
    EXPECT_WITHIN(0.03 * ((15.0 * 0.3265) + model), 5.0e-3, rig_torque(0U));
    rig_generic.ports[FAR_ROBOT].read_status = STATUS_STALE;
    rig_idle(41U); // Less than 2 % of the torque are left after 20.5 ms without samples.
    EXPECT_WITHIN(0.0, 0.01, rig_torque(0U));
}

/// The hand pushes the stick for 0.1 s; then the torque moves the stick and gives away more energy than the
/// hand has put in. Returns the largest damping [Nms/rad]. `paid_j`: energy [J] that the robot adds to its
/// sum in each cycle.
static double damping_of_a_driven_hand(const double paid_j)
{
    robot_touches(0.05, -0.02, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE_REMOTE, STATE_OPERATIONAL);
    rig_idle(500U);
    double largest = 0.0;
    double last_j  = sent().energy;
    for (unsigned i = 0U; i < 2000U; i++) {
        rig_stick->position[0] += (i < 200U) ? -10 : 10;
        robot_touches(1.0e-6 * (double)rig_stick->position[0], -0.02, paid_j * (double)i);
        rig_idle(1U);
        largest = fmax(largest, rig_joystick.control.added_damping);
        TEST_ASSERT_TRUE(sent().energy >= last_j);
        last_j = sent().energy;
    }
    EXPECT_ABOVE(1.0e-4, last_j);
    EXPECT_ABOVE(1.0e-3, rig_joystick.energy.given_j);
    return largest;
}

static void a_port_that_gives_away_too_much_energy_is_damped(void)
{
    EXPECT_WITHIN(0.8, 1.0e-12, damping_of_a_driven_hand(0.0)); // DAMPING_MAX of the descriptor.
}

static void energy_of_the_environment_may_be_given_to_the_hand(void)
{
    EXPECT_WITHIN(0.0, 0.0, damping_of_a_driven_hand(1.0e-3));
}

int main(void)
{
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(a_hand_at_rest_feels_the_far_robot_and_a_moving_hand_the_model);
    RUN_TEST(a_port_that_gives_away_too_much_energy_is_damped);
    RUN_TEST(energy_of_the_environment_may_be_given_to_the_hand);
    return UNITY_END();
}
