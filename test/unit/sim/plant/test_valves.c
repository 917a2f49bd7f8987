// SPDX-License-Identifier: Apache-2.0
// Thrust of valves: momentum of a free body and of a robot with joints, the load on the joints, and bodies
// that cannot be pushed.
#include "sim/plant/plant.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <string.h>

#define STEP_NS 500000U
#define BODY                                                                                                 \
    "<robot name=\"sat\"><link name=\"body\"><inertial><mass value=\"20\"/><inertia ixx=\"2\" ixy=\"0\" "    \
    "ixz=\"0\" iyy=\"3\" iyz=\"0\" izz=\"4\"/></inertial></link>"                                            \
    "<link name=\"nozzle\"/><joint name=\"weld\" type=\"fixed\"><origin xyz=\"0.5 0.2 0\" rpy=\"0 0 "        \
    "1.5707963267948966\"/><parent link=\"body\"/><child link=\"nozzle\"/></joint>"                          \
    "<link name=\"boom\"><inertial><origin xyz=\"0.5 0 0\"/><mass value=\"2\"/><inertia ixx=\"0.1\" "        \
    "ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial></link>"                              \
    "<joint name=\"hinge\" type=\"revolute\"><origin xyz=\"0 0 1\"/><parent link=\"body\"/><child "          \
    "link=\"boom\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"      \
    "</joint></robot>"
#define WORLD(base, valves)                                                                                  \
    "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\">\n<Robot name=\"sat\" urdf=\"sat.urdf\" "            \
    "base=\"" base "\"/>\n<ValveBox name=\"BOX\" bus=\"b\" node=\"9\" eds=\"e\">" valves                     \
    "</ValveBox></World>\n"
#define VALVE(name, on, at, direction, force, output)                                                        \
    "<Valve name=\"" name "\" on=\"" on "\" at=\"" at "\" direction=\"" direction "\" force=\"" force        \
    "\" output=\"" output "\"/>"

static world_t world;
static plant_t* plant;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    memset(&input, 0, sizeof input);
    (void)temporary_file("sat.urdf", BODY);
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static const plant_truth_t* open_world(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    return plant_truth(plant);
}

static void run(const unsigned steps)
{
    for (unsigned i = 0U; i < steps; i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

/// A single body of 300 kg and 60 kgm2 about z: its momentum is force and torque multiplied by time.
static void thrust_changes_momentum_by_force_and_torque_times_time(void)
{
    (void)temporary_copy("satellite.urdf", "descriptors/worlds/satellite.urdf");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read("descriptors/worlds/actuators.xml", &world, error),
                                  error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    const plant_base_t* base = &plant_truth(plant)->base[0];
    input.valve_open[2]      = true; // Two forces of 1 N with levers of 0.5 m: a couple about z.
    input.valve_open[3]      = true;
    run(2000U);
    TEST_ASSERT_TRUE(plant_truth(plant)->valve_open[2] && !plant_truth(plant)->valve_open[0]);
    EXPECT_WITHIN(1.0 / 60.0, 1e-9, base->rate_rad_s[2]);
    EXPECT_WITHIN(0.0, 1e-9, base->velocity_m_s[0]);
    // Angle after 1 s: half the angular acceleration, which is the torque over the inertia, 1/60 rad/s2.
    EXPECT_WITHIN(0.5 / 60.0, 1e-5, 2.0 * base->rotation[3]);
    input.valve_open[2] = false;
    input.valve_open[3] = false;
    input.valve_open[0] = true; // Both valves push along x of the body, which has turned.
    input.valve_open[1] = true;
    const double turn   = 2.0 * base->rotation[3];
    run(200U);
    EXPECT_WITHIN(2.0 * 0.1 / 300.0, 5e-8, base->velocity_m_s[0]);
    EXPECT_WITHIN(2.0 * 0.1 / 300.0 * (turn + (0.05 / 60.0)), 1e-7, base->velocity_m_s[1]);
    EXPECT_WITHIN(1.0 / 60.0, 1e-9, base->rate_rad_s[2]);
}

/// The nozzle is fixed to the link with its x along y of the body; the direction need not have length 1.
static void a_push_on_a_welded_link_has_its_position_and_direction(void)
{
    const plant_truth_t* truth =
        open_world(WORLD("free", VALVE("A", "sat.nozzle", "0 0 0", "7 0 0", "2", "1")));
    input.valve_open[0] = true;
    run(1U);
    const plant_base_t* base = &truth->base[0];
    TEST_ASSERT_TRUE(base->velocity_m_s[1] > 0.0);
    TEST_ASSERT_TRUE(base->rate_rad_s[2] > 0.0);
    EXPECT_WITHIN(0.0, 1e-6, base->velocity_m_s[0]);
    // The boom stays behind: 2 N at 0.5 m beside a hinge that transmits no torque about z.
    EXPECT_WITHIN(2.0 * 0.5 * 0.0005 / 4.0, 1e-5, base->rate_rad_s[2]);
}

/// 1 N at 0.8 m from the hinge, first across it, then along it; the truth has the torque of the joint.
static void a_push_on_a_link_loads_its_joint(void)
{
    const plant_truth_t* truth =
        open_world(WORLD("fixed", VALVE("A", "sat.boom", "0.8 0 0", "0 1 0", "1", "1")
                                      VALVE("B", "sat.boom", "0.8 0 0", "1 0 0", "1", "2")
                                          VALVE("C", "sat.body", "0.8 0 0", "0 1 0", "1000", "3")));
    run(1U);
    EXPECT_WITHIN(0.0, 0.0, truth->external_torque_nm[0]);
    input.valve_open[0] = true;
    run(1U);
    EXPECT_WITHIN(0.8, 1e-9, truth->external_torque_nm[0]);
    // Inertia about the hinge: 0.1 + 2 * 0.25.
    EXPECT_WITHIN(0.8 / 0.6 * 0.0005, 1e-7, truth->link_velocity_rad_s[0]);
    input.valve_open[0] = false;
    input.valve_open[1] = true;
    input.valve_open[2] = true; // The valve is on a link that is fixed to the world.
    const double speed  = truth->link_velocity_rad_s[0];
    run(1U);
    EXPECT_WITHIN(0.0, 1e-6, truth->external_torque_nm[0]);
    EXPECT_WITHIN(speed, 1e-6, truth->link_velocity_rad_s[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(thrust_changes_momentum_by_force_and_torque_times_time);
    RUN_TEST(a_push_on_a_welded_link_has_its_position_and_direction);
    RUN_TEST(a_push_on_a_link_loads_its_joint);
    return UNITY_END();
}
