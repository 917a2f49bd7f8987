// SPDX-License-Identifier: Apache-2.0
// The scene that the operator's hand derives from a world; unsuitable worlds are refused with file and line.
#include "sim/operator/scene.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define WORLD "descriptors/worlds/rokviss.xml"
#define ROBOT "descriptors/worlds/rokviss.urdf"

static world_t world;
static scene_t scene;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
}

void tearDown(void)
{
    temporary_files_remove();
}

static status_t take(const char* path)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    return scene_of(&world, &scene, error);
}

static void expect_refusal(const char* path, const char* at, const char* words)
{
    char location[64];
    (void)snprintf(location, sizeof location, "w.xml:%u: found '", line_of(path, at));
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_INVALID, take(path), words);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

/// Expect that the world with one text replaced is refused at a line.
static void expect_world_refused(const char* old, const char* new_text, const char* at, const char* words)
{
    (void)temporary_copy("rokviss.urdf", ROBOT);
    expect_refusal(temporary_variant("w.xml", WORLD, old, new_text), at, words);
}

/// Expect that the robot with one text replaced is refused at its line in the world.
static void expect_robot_refused(const char* old, const char* new_text, const char* words)
{
    (void)temporary_variant("rokviss.urdf", ROBOT, old, new_text);
    expect_refusal(temporary_variant("w.xml", WORLD, "World", "World"), "<Robot", words);
}

static void the_scene_has_exactly_the_values_of_the_mission(void)
{
    // Values of the mission rokviss.
    const double degree = 3.14159265358979323846 / 180.0;
    const scene_t* p    = &rokviss()->scene;
    EXPECT_WITHIN(60.0 * degree, 0.0, p->home_rad[0]);
    EXPECT_WITHIN(-90.0 * degree, 0.0, p->home_rad[1]);
    EXPECT_WITHIN(0.22, 0.0, p->link_length_m[0]);
    EXPECT_WITHIN(0.25, 0.0, p->link_length_m[1]);
    EXPECT_WITHIN(-0.042, 0.0, p->contour_top_m);
    EXPECT_WITHIN(-0.042 + 0.007, 0.0, p->contour_top_m + p->bump_height_m);
    EXPECT_WITHIN(-0.042 + 0.007 - 0.10, 0.0, p->contour_top_m + p->bump_height_m - p->bump_radius_m);
    EXPECT_WITHIN(0.012, 0.0, p->tip_radius_m);
    EXPECT_WITHIN(0.155, 0.0, p->hook_m[1]);
}

static void robots_of_another_kind_are_refused(void)
{
    expect_robot_refused("type=\"revolute\"", "type=\"prismatic\"",
                         "'joint1', expected revolute joints about -y");
    expect_robot_refused("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 1 0\"/>",
                         "'joint1', expected revolute joints about -y");
    expect_robot_refused("<origin xyz=\"0.22 0 0\"/>", "<origin xyz=\"0.22 0 0.1\"/>",
                         "'joint2', expected revolute");
    expect_robot_refused("<origin xyz=\"0.22 0 0\"/>", "<origin xyz=\"0.22 0 0\" rpy=\"0 0.1 0\"/>",
                         "'joint2'");
    expect_robot_refused("<parent link=\"base\"/>", "<origin xyz=\"0.1 0 0\"/><parent link=\"base\"/>",
                         "'joint1'");
    // A finger on a moving joint is a third joint.
    const char* path = temporary_variant("rokviss.urdf", ROBOT, "<joint name=\"tip\" type=\"fixed\">",
                                         "<joint name=\"tip\" type=\"continuous\">");
    (void)temporary_variant(
        "rokviss.urdf", path, "<link name=\"finger\">",
        "<link name=\"finger\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" "
        "iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>");
    expect_refusal(temporary_variant("w.xml", WORLD, "World", "World"), "<Robot",
                   "'arm', expected a fixed robot of two joints at the origin");
}

static void worlds_of_another_kind_are_refused(void)
{
    expect_world_refused("base=\"fixed\"", "base=\"free\"", "<Robot",
                         "'arm', expected a fixed robot of two joints at the origin");
    expect_world_refused("<Start joint1", "<State at=\"0 0 0.1\"/><Start joint1", "<Robot",
                         "'arm', expected a fixed robot of two joints at the origin");
}

static void surroundings_of_another_kind_are_refused(void)
{
    expect_world_refused("a=\"arm.finger\"", "a=\"arm.lower\"", "<Contact",
                         "'arm.lower', expected a sphere at the end");
    expect_world_refused("<Box size=\"0.25 0.2 0.1\"", "<Box size=\"0.25 0.3 0.1\"", "<Fixture",
                         "'contour', expected a Box and");
    expect_world_refused("rpy=\"1.5707963267948966 0 0\"", "rpy=\"0 0 0\"", "<Fixture", "'contour'");
    expect_world_refused("at=\"0 0 -0.05\"/>", "at=\"0 0 -0.05\" rpy=\"0 0.1 0\"/>", "<Fixture", "'contour'");
    expect_world_refused("at=\"0.325 0 -0.042\"", "at=\"0.325 0.1 -0.042\"", "<Fixture", "'contour'");
    expect_world_refused("<CableSpring on=\"arm.finger\" hook=\"0.327 0 0.155\"",
                         "<CableSpring on=\"arm.finger\" hook=\"0.327 0.1 0.155\"", "<CableSpring",
                         "a cable in the plane");
    expect_world_refused("<CableSpring on=\"arm.finger\"", "<CableSpring on=\"arm.lower\"", "<CableSpring",
                         "'arm.lower', expected a cable");
    expect_world_refused("<Contact a=\"arm.finger\" b=\"contour\" stiffness=\"5000\" damping=\"100\" "
                         "friction=\"0.3\" shear=\"4000\" shearDamping=\"80\"/>",
                         "", "<Robot", "a contact of the robot with a fixture");
}

static void an_empty_world_is_refused(void)
{
    expect_refusal(temporary_file("w.xml", "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\"/>\n"), "<World",
                   "expected a robot that the hand leads");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_scene_has_exactly_the_values_of_the_mission);
    RUN_TEST(robots_of_another_kind_are_refused);
    RUN_TEST(worlds_of_another_kind_are_refused);
    RUN_TEST(surroundings_of_another_kind_are_refused);
    RUN_TEST(an_empty_world_is_refused);
    return UNITY_END();
}
