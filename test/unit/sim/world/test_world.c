// SPDX-License-Identifier: Apache-2.0
// Worlds: values that are read, and every refusal with file and line.
#include "sim/world/world.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define ROKVISS "descriptors/worlds/rokviss.xml"
#define STICK                                                                                                \
    "<Joystick name=\"S\" bus=\"b\" node=\"9\" eds=\"joystick.eds\" axes=\"2\" inertia=\"1\" "               \
    "friction=\"0\" "                                                                                        \
    "range=\"1\" stopStiffness=\"1\" stopDamping=\"0\" encoderCounts=\"9\"/>\n"
#define WORLD(body) "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n" body "</World>\n"
#define ROBOT "<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\"/>\n"
#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"1\" rotorInertia=\"1\" stiffness=\"1\" damping=\"1\" coulomb=\"1\" "      \
    "stiction=\"1\" "                                                                                        \
    "stribeck=\"1\" viscous=\"1\" brake=\"1\" stopStiffness=\"1\" stopDamping=\"1\" encoderCounts=\"1\">"    \
    "<TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" range=\"1\"/></DriveType>\n"
#define DRIVE(name, joint, bus, node)                                                                        \
    "<Drive name=\"" name "\" joint=\"" joint "\" type=\"t\" bus=\"" bus "\" node=\"" node "\" "             \
    "eds=\"e\"/>\n"
#define WALL "<Fixture name=\"wall\" at=\"0 0 0\"><Sphere radius=\"1\" at=\"0 0 0\"/></Fixture>\n"
#define BENCH(name, bus, node)                                                                               \
    "<Bench name=\"" name "\" type=\"t\" bus=\"" bus "\" node=\"" node                                       \
    "\" eds=\"e\" contact=\"0\" stiffness=\"0\" range=\"1\"/>\n"

static world_t world;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    (void)temporary_file(
        "one.urdf",
        "<robot name=\"one\"><link name=\"foot\"/><link name=\"lever\"><inertial><mass value=\"1\"/>"
        "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        "<joint name=\"axle\" type=\"revolute\"><parent link=\"foot\"/><child link=\"lever\"/>"
        "<limit lower=\"-1\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint></robot>");
}

void tearDown(void)
{
    temporary_files_remove();
}

static void expect_world(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
}

static void expect_refusal(const char* text, unsigned line, const char* words)
{
    char location[40];
    (void)snprintf(location, sizeof location, "w.xml:%u: found '", line);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_INVALID, world_read(temporary_file("w.xml", text), &world, error),
                                  words);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void the_world_of_the_mission_is_read_completely(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(ROKVISS, &world, error), error);
    TEST_ASSERT_EQUAL_STRING("rokviss", world.name);
    EXPECT_WITHIN(500000.0, 0.0, world.step_ns);
    EXPECT_WITHIN(-9.81, 0.0, world.gravity[2]);
    TEST_ASSERT_EQUAL_UINT(2U, world.bus_count);
    TEST_ASSERT_EQUAL_STRING("robot", world.bus[0]);
    TEST_ASSERT_EQUAL_STRING("joystick", world.bus[1]);
    TEST_ASSERT_EQUAL_UINT(2U, world.drive_count);
    TEST_ASSERT_EQUAL_UINT(0x12U, world.drive[1].device.node);
    TEST_ASSERT_EQUAL_UINT(1U, world.drive[1].joint);
    TEST_ASSERT_EQUAL_STRING("joint-drive.eds", world.drive[1].device.eds);
    TEST_ASSERT_EQUAL_UINT(line_of(ROKVISS, "<Drive name=\"JOINT2\""), world.drive[1].device.line);
    EXPECT_WITHIN(60.0, 0.0, world.drive_type[0].torque_range);
    EXPECT_WITHIN(-1.5707963267948966, 0.0, world.robot[0].start[1]);
    TEST_ASSERT_EQUAL_UINT(2U, world.fixture[0].shape_count);
    EXPECT_WITHIN(-0.093, 0.0, world.fixture[0].shape[1].pose.position_m[2]);
    TEST_ASSERT_EQUAL_STRING("finger", world.robot[0].model.frame[world.contact[0].side[0].frame].name);
    EXPECT_WITHIN(0.002, 0.0, world.spring[0].travel);
    TEST_ASSERT_EQUAL_UINT(1U, world.joystick[0].device.bus);
    EXPECT_WITHIN(2667.0, 0.0, world.hand[0].joint_stiffness);
    TEST_ASSERT_EQUAL_UINT(2U, world.power_unit[0].supply_count);
    TEST_ASSERT_EQUAL_STRING("JOINT2", world.power_unit[0].supply[1]);
}

static void several_robots_buses_and_benches_are_read(void)
{
    expect_world(WORLD(
        ROBOT
        "<Robot name=\"arm-2\" urdf=\"one.urdf\" base=\"fixed\"><Start axle=\"1.5\"/></Robot>\n" TYPE DRIVE(
            "A", "arm.axle", "one", "5") DRIVE("B", "arm-2.axle", "two", "5") BENCH("C", "one", "0x7F")));
    EXPECT_WITHIN(0.0, 0.0, world.robot[0].start[0]);
    EXPECT_WITHIN(1.5, 0.0, world.robot[1].start[0]);
    TEST_ASSERT_EQUAL_UINT(1U, world.drive[1].robot);
    TEST_ASSERT_EQUAL_UINT(1U, world.drive[1].device.bus);
    TEST_ASSERT_EQUAL_UINT(0U, world.bench[0].device.bus);
    TEST_ASSERT_EQUAL_UINT(127U, world.bench[0].device.node);
    EXPECT_WITHIN(1e6, 0.0, world.step_ns);
}

static void robots_have_a_pose_and_free_robots_also_a_velocity(void)
{
    (void)temporary_file(
        "body.urdf",
        "<robot name=\"one\"><link name=\"foot\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
        "ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link></robot>");
    expect_world(WORLD("<Robot name=\"r\" urdf=\"body.urdf\" base=\"free\"><State at=\"1 2 3\" rpy=\"0 0 "
                       "1.5707963267948966\" "
                       "velocity=\"4 5 6\" rate=\"7 8 9\"/></Robot>\n"
                       "<Robot name=\"s\" urdf=\"one.urdf\" base=\"fixed\"/>\n"));
    EXPECT_WITHIN(2.0, 0.0, world.robot[0].pose.position_m[1]);
    EXPECT_WITHIN(1.0, 1e-15, world.robot[0].pose.rotation.at[1][0]);
    EXPECT_WITHIN(5.0, 0.0, world.robot[0].velocity_m_s[1]);
    EXPECT_WITHIN(9.0, 0.0, world.robot[0].rate_rad_s[2]);
    EXPECT_WITHIN(1.0, 0.0, world.robot[1].pose.rotation.at[2][2]);
}

static void a_contact_names_a_fixture_or_a_link(void)
{
    expect_world(WORLD(
        ROBOT "<Fixture name=\"ball\" at=\"0 0 0\"><Sphere radius=\"0.5\" at=\"0 0 1\"/></Fixture>\n"
              "<Contact a=\"arm.lever\" b=\"ball\" stiffness=\"1\" damping=\"1\" friction=\"1\" shear=\"2\" "
              "shearDamping=\"3\"/>\n"
              "<Contact a=\"arm.lever\" b=\"arm.foot\" stiffness=\"1\" damping=\"1\" friction=\"1\"/>\n"));
    TEST_ASSERT_TRUE(world.contact[0].side[1].is_fixture);
    TEST_ASSERT_EQUAL_INT(SHAPE_SPHERE, world.fixture[0].shape[0].kind);
    EXPECT_WITHIN(0.5, 0.0, world.fixture[0].shape[0].radius_m);
    EXPECT_WITHIN(2.0, 0.0, world.contact[0].shear);
    EXPECT_WITHIN(0.0, 0.0, world.contact[1].shear_damping);
    TEST_ASSERT_FALSE(world.contact[1].side[1].is_fixture);
    TEST_ASSERT_EQUAL_STRING("foot", world.robot[0].model.frame[world.contact[1].side[1].frame].name);
}

static void unknown_elements_and_attributes_are_refused(void)
{
    expect_refusal("<Mission/>", 1U, "'Mission', expected World");
    expect_refusal(WORLD("<Gripper/>\n"), 2U, "'Gripper', expected an attribute name");
    expect_refusal(WORLD("\n<Propeller on=\"x\"/>\n"), 3U, "'Propeller'");
    expect_refusal(WORLD("<Fixture name=\"f\" at=\"0 0 0\">\n<Mesh file=\"1\"/></Fixture>\n"), 3U,
                   "'Mesh', expected Box Sphere Cylinder");
    expect_refusal(
        WORLD("<Robot name=\"r\" urdf=\"one.urdf\" base=\"fixed\">\n<State rate=\"0 0 1\"/></Robot>\n"), 3U,
        "'r', expected a robot with a free base");
    expect_refusal(
        WORLD("<Fixture name=\"f\" at=\"0 0 0\"><Box size=\"1 1 1\" at=\"0 0 0\"><Box/></Box></Fixture>\n"),
        2U, "'Box', expected no element inside of this one");
    expect_refusal(WORLD("<Start/>\n"), 2U, "'Start', expected Robot");
    expect_refusal("<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\" wind=\"1\"/>", 1U,
                   "wind=\"1\"', expected name step gravity");
    expect_refusal(WORLD("words\n"), 2U, "'w', expected no text");
}

static void malformed_values_are_refused(void)
{
    expect_refusal("<World name=\"w\" step=\"1\" gravity=\"0 0 0\"/>", 1U,
                   "step=\"1\"', expected a time in us, ms or s");
    expect_refusal("<World name=\"w\" step=\"ms\" gravity=\"0 0 0\"/>", 1U, "step=\"ms\"'");
    expect_refusal("<World name=\"w\" step=\"99us\" gravity=\"0 0 0\"/>", 1U, "from 100 to 10000 us");
    expect_refusal("<World name=\"w\" step=\"1s\" gravity=\"0 0 0\"/>", 1U, "from 100 to 10000 us");
    expect_refusal("<World name=\"w\" step=\"1ms\" gravity=\"0 0\"/>", 1U,
                   "gravity=\"0 0\"', expected three numbers");
    expect_refusal("<World name=\"w\" step=\"1ms\" gravity=\"0 0 inf\"/>", 1U, "expected three numbers");
    expect_refusal("<World name=\"w\" step=\"1ms\" gravity=\"0 0 0x9\"/>", 1U, "expected three numbers");
    expect_refusal("<World name=\"1w\" step=\"1ms\" gravity=\"0 0 0\"/>", 1U,
                   "name=\"1w\"', expected a name");
    expect_refusal("<World name=\"\" step=\"1ms\" gravity=\"0 0 0\"/>", 1U, "expected a name");
    expect_refusal("<World step=\"1ms\" gravity=\"0 0 0\"/>", 1U, "'World', expected an attribute name");
    expect_refusal(
        "<World name=\"a234567890123456789012345678901234567890123456789012345678901234\" step=\"1ms\" "
        "gravity=\"0 0 0\"/>",
        1U, "at most 62");
    expect_refusal(WORLD(TYPE BENCH("C", "one", "1")), 3U,
                   "node=\"1\"', expected a whole number from 2 to 127");
    expect_refusal(WORLD(TYPE BENCH("C", "one", "128")), 3U, "node=\"128\"'");
    expect_refusal(WORLD(TYPE BENCH("C", "one", "-5")), 3U, "node=\"-5\"'");
    expect_refusal(WORLD(TYPE BENCH("C", "one", "0x1g")), 3U, "node=\"0x1g\"'");
}

static void names_that_are_not_defined_above_are_refused(void)
{
    expect_refusal(WORLD(ROBOT TYPE DRIVE("A", "leg.axle", "b", "5")), 4U,
                   "'leg.axle', expected robot.joint of a robot above");
    expect_refusal(WORLD(ROBOT TYPE DRIVE("A", "arm.elbow", "b", "5")), 4U,
                   "'arm.elbow', expected robot.joint");
    expect_refusal(WORLD(ROBOT TYPE DRIVE("A", "axle", "b", "5")), 4U, "'axle', expected robot.joint");
    expect_refusal(WORLD(ROBOT DRIVE("A", "arm.axle", "b", "5") TYPE), 3U, "'t', expected a DriveType above");
    expect_refusal(
        WORLD("<Contact a=\"arm.lever\" b=\"wall\" stiffness=\"1\" damping=\"1\" friction=\"1\"/>\n"), 2U,
        "'wall', expected a Fixture, or robot.link");
    expect_refusal(WORLD(ROBOT "<CableSpring on=\"arm.hand\" hook=\"0 0 0\" catch=\"1\" length=\"1\" "
                               "stiffness=\"1\" preload=\"1\" "
                               "travel=\"1\" limit=\"1\"/>\n"),
                   3U, "'arm.hand', expected robot.link of a robot above");
    expect_refusal(
        WORLD("<Hand joystick=\"STICK\" stiffness=\"1\" damping=\"1\" positionScale=\"1\" forceScale=\"1\" "
              "jointStiffness=\"1\"/>\n"),
        2U, "'STICK', expected a Joystick above");
    expect_refusal(WORLD(STICK "<Hand joystick=\"S\" stiffness=\"1\" damping=\"1\" positionScale=\"1\" "
                               "forceScale=\"1\"/>\n"),
                   3U, "expected all of positionScale, forceScale and jointStiffness, or none");
    expect_refusal(WORLD(STICK "<Hand joystick=\"S\" stiffness=\"1\" damping=\"1\" forceScale=\"1\"/>\n"), 3U,
                   "expected all of positionScale, forceScale and jointStiffness, or none");
    expect_refusal(WORLD("<PowerUnit name=\"P\" bus=\"b\" node=\"9\"><Supply device=\"A\"/></PowerUnit>\n"),
                   2U, "'A', expected a device above");
    // A power unit cannot supply itself.
    expect_refusal(WORLD("<PowerUnit name=\"P\" bus=\"b\" node=\"9\"><Supply device=\"P\"/></PowerUnit>\n"),
                   2U, "'P', expected a device above");
}

static void repeated_names_are_refused(void)
{
    expect_refusal(WORLD(ROBOT ROBOT), 3U, "'arm', expected a name that no robot above has");
    expect_refusal(WORLD(TYPE TYPE), 3U, "'t', expected a name that no DriveType above has");
    expect_refusal(WORLD(TYPE BENCH("C", "b", "5") BENCH("C", "b", "6")), 4U,
                   "'C', expected a name that no device above has");
    expect_refusal(WORLD(TYPE BENCH("C", "b", "5") BENCH("D", "b", "0x05")), 4U,
                   "'0x05', expected a node id that no device above");
    expect_world(WORLD(TYPE BENCH("C", "b", "5") BENCH("D", "c", "5")));
    expect_world(WORLD(TYPE BENCH("C", "fifteen-letters", "5")));
    expect_refusal(WORLD(TYPE BENCH("C", "sixteen-letters-", "5")), 3U,
                   "'sixteen-letters-', expected a lower-case name of a bus with at most 15 characters");
    expect_refusal(WORLD(ROBOT TYPE DRIVE("A", "arm.axle", "b", "5") DRIVE("B", "arm.axle", "b", "6")), 5U,
                   "'arm.axle', expected a joint that no drive above moves");
    expect_refusal(WORLD(WALL WALL), 3U, "'wall', expected a name that no Fixture above has");
    expect_refusal(WORLD(TYPE BENCH("C", "b", "5") "<PowerUnit name=\"P\" bus=\"b\" node=\"5\"/>\n"), 4U,
                   "'5', expected a node id");
}

#define WHEEL(more)                                                                                          \
    "<Wheel name=\"W\" bus=\"b\" node=\"7\" eds=\"e\" torque=\"0.2\" momentum=\"12\" " more "/>\n"

static void wheels_are_read_and_bad_ones_refused(void)
{
    expect_world(WORLD(ROBOT WHEEL("on=\"arm.lever\" axis=\"0 3 4\" start=\"-5\"")));
    TEST_ASSERT_EQUAL_UINT(1U, world.wheel_count);
    EXPECT_WITHIN(0.8, 1e-15, world.wheel[0].axis[2]);
    EXPECT_WITHIN(-5.0, 0.0, world.wheel[0].start);
    TEST_ASSERT_EQUAL_STRING("b", world.bus[world.wheel[0].device.bus]);
    expect_refusal(WORLD(ROBOT WHEEL("on=\"arm.rim\" axis=\"0 0 1\"")), 3U,
                   "'arm.rim', expected robot.link of a robot above");
    expect_refusal(WORLD(ROBOT WHEEL("on=\"arm.lever\" axis=\"0 0 0\"")), 3U,
                   "'0 0 0', expected a vector of length 0.001 or more");
    expect_refusal(WORLD(ROBOT WHEEL("on=\"arm.lever\" axis=\"0 0 1\" start=\"13\"")), 3U,
                   "'13', expected a start from -momentum to momentum");
    expect_refusal(WORLD(ROBOT WHEEL("on=\"arm.lever\"")), 3U, "'Wheel', expected an attribute axis");
    expect_refusal(WORLD(ROBOT TYPE BENCH("C", "b", "7") WHEEL("on=\"arm.lever\" axis=\"0 0 1\"")), 5U,
                   "'7', expected a node id that no device above");
}

#define FREE(name, more) "<Robot name=\"" name "\" urdf=\"body.urdf\" base=\"free\">" more "</Robot>\n"

static void a_state_is_relative_to_a_link_and_valid_at_a_time(void)
{
    (void)temporary_file(
        "body.urdf", "<robot name=\"b\"><link name=\"base\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
                     "ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link></robot>");
    expect_world(WORLD(
        "<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\"><State at=\"1 2 3\" rpy=\"0 0 "
        "1.5707963267948966\"/><Start axle=\"1.5707963267948966\"/></Robot>\n" FREE(
            "r",
            "<State at=\"0 1 0\" velocity=\"0 0.5 0\" rate=\"0 0 1\" relativeTo=\"arm.lever\" valid=\"75s\"/>"
            "<Spread mass=\"0.02\" com=\"0.001\" at=\"0.05\" rpy=\"0.1\" velocity=\"0.005\" "
            "rate=\"0.02\"/>")));
    const world_robot_t* robot = &world.robot[1];
    const double expected[3]   = {1.0, 2.0, 4.0}; // The lever along y of the link is along z of the world.
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(expected[i], 1e-12, robot->pose.position_m[i]);
    }
    EXPECT_WITHIN(0.5, 1e-12, robot->velocity_m_s[2]);
    EXPECT_WITHIN(1.0, 1e-12, robot->rate_rad_s[0]);
    EXPECT_WITHIN(75e9, 0.0, robot->valid_ns);
    EXPECT_WITHIN(0.02, 0.0, robot->spread_mass);
    EXPECT_WITHIN(0.0, 0.0, robot->spread_inertia);
    EXPECT_WITHIN(0.05, 0.0, robot->spread_start.at);
    EXPECT_WITHIN(0.1, 0.0, robot->spread_start.rpy);
    EXPECT_WITHIN(0.005, 0.0, robot->spread_start.velocity);
    EXPECT_WITHIN(0.02, 0.0, robot->spread_start.rate);
    expect_refusal(
        WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n<Spread rate=\"1\"/></Robot>\n"), 3U,
        "'arm', expected a robot with a free base");
    expect_refusal(WORLD(FREE("r", "\n<State relativeTo=\"r.base\"/>")), 3U,
                   "'r.base', expected robot.link of another");
    expect_refusal(WORLD(FREE("r", "\n<State relativeTo=\"q.base\"/>")), 3U,
                   "'q.base', expected robot.link of another");
    expect_refusal(WORLD(FREE("r", "<State valid=\"1s\"/>") FREE("q", "<State relativeTo=\"r.base\"/>")), 3U,
                   "'r.base', expected robot.link of another robot above, whose State");
    expect_refusal(
        WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n<State valid=\"1s\"/></Robot>\n"), 3U,
        "'1s', expected no time in a robot");
    expect_refusal(WORLD(FREE("r", "\n<State valid=\"-1s\"/>")), 3U, "valid=\"-1s\"'");
    expect_refusal(WORLD(FREE("r", "\n<Spread mass=\"0.6\"/>")), 3U,
                   "mass=\"0.6\"', expected a number from 0 to 0.5");
    expect_refusal(WORLD(FREE("r", "\n<Spread size=\"0.1\"/>")), 3U,
                   "size=\"0.1\"', expected mass inertia com");
}

static void a_relative_state_follows_a_prismatic_joint(void)
{
    (void)temporary_file(
        "slide.urdf",
        "<robot name=\"s\"><link name=\"foot\"/><link name=\"rod\"><inertial><mass value=\"1\"/>"
        "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        "<joint name=\"axle\" type=\"prismatic\"><parent link=\"foot\"/><child link=\"rod\"/><axis xyz=\"0 0 "
        "1\"/>"
        "<limit lower=\"-1\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint></robot>");
    expect_world(WORLD("<Robot name=\"s\" urdf=\"slide.urdf\" base=\"fixed\"><Start axle=\"0.5\"/></Robot>\n"
                       "<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\"><State at=\"0 0 1\" "
                       "relativeTo=\"s.rod\"/></Robot>\n"));
    EXPECT_WITHIN(1.5, 1e-12, world.robot[1].pose.position_m[2]);
}

#define SENSOR(kind, more) "<" kind " name=\"S\" bus=\"b\" node=\"7\" eds=\"e\" on=\"arm.lever\" " more "/>\n"
#define CAMERA(delay)                                                                                        \
    SENSOR("PoseCamera", "sees=\"arm.foot\" rate=\"20\" delay=\"" delay                                      \
                         "\" noise=\"1 2 3\" angleNoise=\"4 5 6\" loss=\"0.5\" at=\"7 8 9\"")

static void sensors_are_read_and_bad_ones_refused(void)
{
    expect_world(WORLD(ROBOT SENSOR("Gyro", "noise=\"1e-5\" bias=\"2e-6\"")));
    TEST_ASSERT_EQUAL_INT(SENSOR_GYRO, world.sensor[0].kind);
    EXPECT_WITHIN(0.0, 0.0, world.sensor[0].rate_hz);
    EXPECT_WITHIN(2e-6, 0.0, world.sensor[0].bias);
    expect_world(WORLD(ROBOT SENSOR("StarTracker", "rate=\"5\" noise=\"1 2 3\"")));
    TEST_ASSERT_EQUAL_INT(SENSOR_STAR_TRACKER, world.sensor[0].kind);
    EXPECT_WITHIN(3.0, 0.0, world.sensor[0].noise[2]);
    expect_world(WORLD(ROBOT CAMERA("80ms")));
    TEST_ASSERT_EQUAL_INT(SENSOR_POSE_CAMERA, world.sensor[0].kind);
    EXPECT_WITHIN(80e6, 0.0, world.sensor[0].delay_ns);
    EXPECT_WITHIN(6.0, 0.0, world.sensor[0].angle_noise[2]);
    EXPECT_WITHIN(9.0, 0.0, world.sensor[0].at[2]);
    TEST_ASSERT_EQUAL_UINT(0U, world.sensor[0].seen_frame);
    expect_refusal(WORLD(ROBOT CAMERA("500ms")), 3U,
                   "'500ms', expected a delay of at most 8 periods of rate");
    expect_refusal(
        WORLD(ROBOT SENSOR("PoseCamera", "sees=\"arm.hand\" rate=\"20\" delay=\"1ms\" noise=\"0 0 0\" "
                                         "angleNoise=\"0 0 0\" loss=\"0\"")),
        3U, "'arm.hand', expected robot.link");
    expect_refusal(WORLD(ROBOT SENSOR("Gyro", "noise=\"-1\" bias=\"0\"")), 3U,
                   "noise=\"-1\"', expected a number from 0");
    expect_refusal(WORLD(ROBOT SENSOR("StarTracker", "noise=\"0 0 0\"")), 3U, "expected an attribute rate");
    expect_refusal(WORLD(ROBOT SENSOR("StarTracker", "rate=\"0\" noise=\"0 0 0\"")), 3U, "rate=\"0\"'");
    expect_refusal(WORLD(SENSOR("Gyro", "noise=\"1\" bias=\"0\"") ROBOT), 2U,
                   "'arm.lever', expected robot.link");
}

static void impossible_robots_are_refused(void)
{
    expect_refusal(WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"loose\"/>\n"), 2U,
                   "'loose', expected base fixed or free");
    expect_refusal(WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"free\"/>\n"), 2U,
                   "'arm', expected a free base that has a mass");
    expect_refusal(
        WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n<Start elbow=\"1\"/></Robot>\n"), 3U,
        "'elbow', expected a joint of this robot");
    expect_refusal(
        WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n<Start axle=\"2.01\"/></Robot>\n"), 3U,
        "'2.01', expected a number inside of the limits");
    expect_refusal(
        WORLD("<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n<Start axle=\"up\"/></Robot>\n"), 3U,
        "'up'");
    expect_refusal(WORLD("\n<Robot name=\"a\" urdf=\"none.urdf\" base=\"fixed\"/>\n"), 3U,
                   "'none.urdf', expected a URDF file in the directory of the world");
    // An error in the file of a robot is reported with the line in that file.
    (void)temporary_file("bad.urdf", "<robot name=\"bad\">\n\n<gazebo/></robot>");
    TEST_ASSERT_EQUAL_INT(
        STATUS_INVALID,
        world_read(temporary_file("w.xml", WORLD("<Robot name=\"a\" urdf=\"bad.urdf\" base=\"fixed\"/>\n")),
                   &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "/bad.urdf:3: found 'gazebo'"), error);
}

static void impossible_drive_types_are_refused(void)
{
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant("w.xml", ROKVISS, "stiction=\"2.4\"", "stiction=\"1.9\"");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "'1.9', expected a stiction of at least coulomb"), error);
    path = temporary_variant("w.xml", ROKVISS, "type=\"light\"", "type=\"heavy\"");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "'heavy', expected a DriveType above"), error);
    path =
        temporary_variant("w.xml", ROKVISS, "range=\"60\"/>",
                          "range=\"60\"/><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" range=\"1\"/>");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "'TorqueSensor', expected only one of these in its parent"),
                                 error);
}

static void a_drive_type_may_have_ripples_or_no_torque_sensor(void)
{
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant("w.xml", ROKVISS, "range=\"60\"/>",
                                         "range=\"60\" ripple=\"0.3\" ripplePeriods=\"4\"/>");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    EXPECT_WITHIN(0.3, 0.0, world.drive_type[0].torque_ripple);
    EXPECT_WITHIN(4.0, 0.0, world.drive_type[0].torque_periods);
    EXPECT_WITHIN(0.0, 0.0, world.drive_type[0].ripple);
    path = temporary_variant("w.xml", ROKVISS, "stiction=\"2.4\"",
                             "stiction=\"2.4\" ripple=\"0.2\" ripplePeriods=\"6\"");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    EXPECT_WITHIN(0.2, 0.0, world.drive_type[0].ripple);
    EXPECT_WITHIN(6.0, 0.0, world.drive_type[0].ripple_periods);
    path = temporary_variant("w.xml", ROKVISS, "stiction=\"2.4\"", "stiction=\"2.4\" ripple=\"-0.2\"");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "ripple=\"-0.2\""), error);
    path = temporary_variant("w.xml", ROKVISS,
                             "<TorqueSensor noise=\"0.02\" offset=\"0.2\" drift=\"2e-4\" range=\"60\"/>", "");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    TEST_ASSERT_FALSE(world.drive_type[0].has_torque_sensor);
    EXPECT_WITHIN(0.0, 0.0, world.drive_type[0].torque_range);
}

static void drives_wheels_and_cameras_have_a_spread(void)
{
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant("w.xml", ROKVISS, "stiction=\"2.4\"",
                                         "stiction=\"2.4\" frictionSpread=\"0.2\" stiffnessSpread=\"0.1\"");
    path             = temporary_variant(
                    "x.xml", path, "</World>",
                    "<Wheel name=\"W\" on=\"arm.finger\" axis=\"0 0 1\" momentum=\"1\" torque=\"1\" gainSpread=\"0.02\" "
                                "bus=\"b\" node=\"2\" eds=\"e\"/><PoseCamera name=\"C\" on=\"arm.finger\" atSpread=\"0.001\" "
                                "rpySpread=\"0.002\" sees=\"arm.finger\" rate=\"20\" delay=\"10ms\" noise=\"0 0 0\" "
                                "angleNoise=\"0 0 0\" loss=\"0\" bus=\"b\" node=\"3\" eds=\"e\"/></World>");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    EXPECT_WITHIN(0.2, 0.0, world.drive_type[0].friction_spread);
    EXPECT_WITHIN(0.1, 0.0, world.drive_type[0].stiffness_spread);
    EXPECT_WITHIN(0.02, 0.0, world.wheel[0].gain_spread);
    EXPECT_WITHIN(0.001, 0.0, world.sensor[0].at_spread);
    EXPECT_WITHIN(0.002, 0.0, world.sensor[0].rpy_spread);
    path = temporary_variant("w.xml", ROKVISS, "stiction=\"2.4\"", "stiction=\"2.4\" frictionSpread=\"0.6\"");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "frictionSpread=\"0.6\""), error);
}

static void joints_have_rates_at_the_start(void)
{
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path =
        temporary_variant("w.xml", ROKVISS, "</Robot>", "<StartRate joint2=\"-0.4\"/></Robot>");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    EXPECT_WITHIN(0.0, 0.0, world.robot[0].rate[0]);
    EXPECT_WITHIN(-0.4, 0.0, world.robot[0].rate[1]);
    static const char* const bad[][2] = {
        {"<StartRate joint3=\"1\"/></Robot>", "'joint3', expected a joint of this robot that moves"},
        {"<StartRate joint1=\"1001\"/></Robot>", "'1001', expected a number from -1000 to 1000"}};
    for (unsigned i = 0U; i < 2U; i++) {
        path = temporary_variant("w.xml", ROKVISS, "</Robot>", bad[i][0]);
        TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(path, &world, error));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, bad[i][1]), error);
    }
}

static void more_elements_than_the_world_can_hold_are_refused(void)
{
    static char text[32768];
    size_t used =
        (size_t)snprintf(text, sizeof text, "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n" TYPE);
    for (unsigned i = 0U; i < 65U; i++) {
        used +=
            (size_t)snprintf(&text[used], sizeof text - used,
                             "<Bench name=\"B%u\" type=\"t\" bus=\"b\" node=\"%u\" eds=\"e\" contact=\"0\" "
                             "stiffness=\"0\" range=\"1\"/>\n",
                             i, i + 2U);
    }
    expect_refusal(text, 67U, "'Bench', expected at most 64 of them");
    used = (size_t)snprintf(text, sizeof text, "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n" TYPE);
    for (unsigned i = 0U; i < 9U; i++) {
        used +=
            (size_t)snprintf(&text[used], sizeof text - used,
                             "<Bench name=\"B%u\" type=\"t\" bus=\"b%u\" node=\"9\" eds=\"e\" contact=\"0\" "
                             "stiffness=\"0\" range=\"1\"/>\n",
                             i, i);
    }
    expect_refusal(text, 11U, "'b8', expected at most 8 buses");
    used = (size_t)snprintf(
        text, sizeof text,
        "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n<Fixture name=\"f\" at=\"0 0 0\">\n");
    for (unsigned i = 0U; i < 9U; i++) {
        used += (size_t)snprintf(&text[used], sizeof text - used, "<Box size=\"1 1 1\" at=\"0 0 0\"/>\n");
    }
    expect_refusal(text, 11U, "'one more shape', expected at most 8");
    used = (size_t)snprintf(text, sizeof text, "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n" TYPE);
    for (unsigned i = 0U; i < 5U; i++) {
        used +=
            (size_t)snprintf(&text[used], sizeof text - used,
                             "<Bench name=\"B%u\" type=\"t\" bus=\"b\" node=\"%u\" eds=\"e\" contact=\"0\" "
                             "stiffness=\"0\" range=\"1\"/>\n",
                             i, i + 2U);
    }
    used +=
        (size_t)snprintf(&text[used], sizeof text - used, "<PowerUnit name=\"P\" bus=\"b\" node=\"99\">\n");
    for (unsigned i = 0U; i < 5U; i++) {
        used += (size_t)snprintf(&text[used], sizeof text - used, "<Supply device=\"B%u\"/>\n", i);
    }
    expect_refusal(text, 13U, "'B4', expected at most 4 devices");
}

#define INSTRUMENT(more)                                                                                     \
    "<Instrument name=\"I\" type=\"UDP\" channel=\"h:1\" period=\"5ms\" value=\"INT16\" speed=\"1\"" more    \
    "/>\n"

static void instruments_are_read_with_all_attributes(void)
{
    expect_world(WORLD(INSTRUMENT(
        "") "<Instrument name=\"J\" type=\"SERIAL\" channel=\"/dev/x\" framing=\"SLIP\" order=\"LITTLE\" "
            "checksum=\"true\" period=\"1s\" value=\"DOUBLE\" scale=\"-2\" offset=\"3\" speed=\"4\"/>\n"));
    TEST_ASSERT_EQUAL_UINT64(2U, world.instrument_count);
    const world_instrument_t* plain = &world.instrument[0];
    const world_instrument_t* other = &world.instrument[1];
    TEST_ASSERT_EQUAL_UINT(2U, plain->type);
    TEST_ASSERT_EQUAL_UINT(0U, plain->value);
    TEST_ASSERT_FALSE(plain->is_slip || plain->is_little || plain->has_checksum);
    TEST_ASSERT_TRUE((plain->scale == 1.0) && (plain->offset == 0.0) && (plain->period_ns == 5e6));
    TEST_ASSERT_EQUAL_UINT(4U, other->type);
    TEST_ASSERT_EQUAL_UINT(3U, other->value);
    TEST_ASSERT_TRUE(other->is_slip && other->is_little && other->has_checksum);
    TEST_ASSERT_TRUE((other->scale == -2.0) && (other->offset == 3.0) && (other->speed == 4.0));
}

static void bad_attributes_of_an_instrument_are_refused(void)
{
    expect_refusal(WORLD(INSTRUMENT(" framing=\"RAW\"")), 2U, "'RAW', expected LENGTH or SLIP");
    expect_refusal(WORLD(INSTRUMENT(" order=\"MIDDLE\"")), 2U, "'MIDDLE', expected BIG or LITTLE");
    expect_refusal(WORLD(INSTRUMENT(" checksum=\"yes\"")), 2U, "'yes', expected true or false");
    expect_refusal(WORLD(INSTRUMENT(" scale=\"0\"")), 2U, "expected a scale other than 0");
    expect_refusal(
        WORLD(
            "<Instrument name=\"I\" type=\"CAN\" channel=\"x\" period=\"5ms\" value=\"INT16\" speed=\"1\"/>"),
        2U, "'CAN', expected SHM MQUEUE UDP TCP SERIAL or FILE");
    expect_refusal(
        WORLD(
            "<Instrument name=\"I\" type=\"UDP\" channel=\"x\" period=\"5ms\" value=\"INT64\" speed=\"1\"/>"),
        2U, "'INT64', expected INT16 INT32 FLOAT or DOUBLE");
    expect_refusal(WORLD(INSTRUMENT("") INSTRUMENT("")), 3U, "a name that no Instrument above has");
}

static void broken_files_are_refused(void)
{
    char path[300];
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, world_read("/nowhere.xml", &world, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere.xml: "));
    expect_refusal("<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n", 2U, "expected well-formed XML");
    expect_refusal("<!DOCTYPE World>\n<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\"/>", 1U,
                   "no document type declaration");
    memset(path, 'x', sizeof path);
    path[sizeof path - 1U] = '\0';
    TEST_ASSERT_EQUAL_INT(STATUS_TOO_LARGE, world_read(path, &world, error));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_world_of_the_mission_is_read_completely);
    RUN_TEST(several_robots_buses_and_benches_are_read);
    RUN_TEST(robots_have_a_pose_and_free_robots_also_a_velocity);
    RUN_TEST(a_contact_names_a_fixture_or_a_link);
    RUN_TEST(unknown_elements_and_attributes_are_refused);
    RUN_TEST(malformed_values_are_refused);
    RUN_TEST(names_that_are_not_defined_above_are_refused);
    RUN_TEST(repeated_names_are_refused);
    RUN_TEST(wheels_are_read_and_bad_ones_refused);
    RUN_TEST(a_state_is_relative_to_a_link_and_valid_at_a_time);
    RUN_TEST(a_relative_state_follows_a_prismatic_joint);
    RUN_TEST(sensors_are_read_and_bad_ones_refused);
    RUN_TEST(impossible_robots_are_refused);
    RUN_TEST(impossible_drive_types_are_refused);
    RUN_TEST(a_drive_type_may_have_ripples_or_no_torque_sensor);
    RUN_TEST(drives_wheels_and_cameras_have_a_spread);
    RUN_TEST(joints_have_rates_at_the_start);
    RUN_TEST(more_elements_than_the_world_can_hold_are_refused);
    RUN_TEST(instruments_are_read_with_all_attributes);
    RUN_TEST(bad_attributes_of_an_instrument_are_refused);
    RUN_TEST(broken_files_are_refused);
    return UNITY_END();
}
