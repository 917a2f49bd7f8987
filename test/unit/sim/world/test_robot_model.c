// SPDX-License-Identifier: Apache-2.0
// Robots of URDF files: values that are read, links that are merged into one body, and every refusal with its
// line.
#include "sim/world/robot_model.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define MASS(m, i)                                                                                           \
    "<inertial><mass value=\"" m "\"/><inertia ixx=\"" i "\" ixy=\"0\" ixz=\"0\" iyy=\"" i                   \
    "\" iyz=\"0\" izz=\"" i "\"/></inertial>"
#define LINK(name) "<link name=\"" name "\">" MASS("1", "0.1") "</link>\n"
#define JOINT(name, type, parent, child, more)                                                               \
    "<joint name=\"" name "\" type=\"" type "\"><parent link=\"" parent "\"/><child link=\"" child           \
    "\"/>" more "</joint>\n"
#define LIMIT "<limit lower=\"-1\" upper=\"2\" effort=\"1\" velocity=\"1\"/>"

static robot_model_t model;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
}

void tearDown(void)
{
    temporary_files_remove();
}

static status_t load(const char* body)
{
    static char text[40000];
    (void)snprintf(text, sizeof text, "<robot name=\"r\">\n%s</robot>\n", body);
    return robot_model_read(temporary_file("robot.urdf", text), &model, error);
}

static void expect_robot(const char* body)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, load(body), error);
}

static void expect_refusal(const char* body, unsigned line, const char* words)
{
    char location[40];
    (void)snprintf(location, sizeof location, "robot.urdf:%u: found '", line);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_INVALID, load(body), words);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void the_arm_of_the_mission_has_the_numbers_of_its_file(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK,
                                  robot_model_read("descriptors/worlds/rokviss.urdf", &model, error), error);
    TEST_ASSERT_EQUAL_UINT(2U, model.joint_count);
    TEST_ASSERT_EQUAL_UINT(4U, model.frame_count);
    TEST_ASSERT_EQUAL_UINT(1U, model.shape_count);
    TEST_ASSERT_EQUAL_UINT(1U, robot_model_joint(&model, "joint2"));
    // The joint of the tip is fixed, so it is not a joint of the model.
    TEST_ASSERT_EQUAL_UINT(2U, robot_model_joint(&model, "tip"));
    const robot_frame_t* finger = &model.frame[robot_model_frame(&model, "finger")];
    TEST_ASSERT_EQUAL_UINT(2U, finger->body);
    // Values equal to the last bit: the octets of a flight depend on them.
    EXPECT_WITHIN(0.25, 0.0, finger->pose.position_m[0]);
    EXPECT_WITHIN(0.22, 0.0, model.joint[1].origin.position_m[0]);
    EXPECT_WITHIN(0.125, 0.0, model.body[2].com_m[0]);
    EXPECT_WITHIN(0.010416666667, 0.0, model.body[2].inertia_kgm2.at[1][1]);
    EXPECT_WITHIN(-1.0, 0.0, model.joint[1].axis[1]);
    TEST_ASSERT_EQUAL_INT(SHAPE_SPHERE, model.shape[0].kind);
    TEST_ASSERT_EQUAL_STRING("finger", model.frame[model.shape[0].frame].name);
}

static void fixed_links_become_one_body(void)
{
    // Two balls of 1 kg, 2 m apart and rigidly connected: one body with its centre of mass between them; the
    // second ball is turned.
    expect_robot("<link name=\"a\">" MASS(
        "1", "0.1") "</link>\n"
                    "<link name=\"b\"><inertial><origin xyz=\"0 1 0\"/><mass value=\"1\"/>"
                    "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.2\" iyz=\"0\" "
                    "izz=\"0.25\"/></inertial></link>\n"
                    "<link name=\"empty\"/>\n" JOINT(
                        "hold", "fixed", "a", "b", "<origin xyz=\"1 0 0\" rpy=\"0 0 -1.5707963267948966\"/>")
                        JOINT("mark", "fixed", "b", "empty", "<origin xyz=\"0 0 3\"/>"));
    TEST_ASSERT_EQUAL_UINT(0U, model.joint_count);
    EXPECT_WITHIN(2.0, 1e-12, model.body[0].mass_kg);
    EXPECT_WITHIN(1.0, 1e-12, model.body[0].com_m[0]);
    EXPECT_WITHIN(0.0, 1e-12, model.body[0].com_m[1]);
    // The second ball is turned by 90 degrees about z: its y moment is now about x. Both are 1 m from the
    // common centre.
    EXPECT_WITHIN(0.1 + 0.2, 1e-12, model.body[0].inertia_kgm2.at[0][0]);
    EXPECT_WITHIN(0.1 + 0.1 + 2.0, 1e-12, model.body[0].inertia_kgm2.at[1][1]);
    EXPECT_WITHIN(0.1 + 0.25 + 2.0, 1e-12, model.body[0].inertia_kgm2.at[2][2]);
    const robot_frame_t* mark = &model.frame[robot_model_frame(&model, "empty")];
    EXPECT_WITHIN(1.0, 1e-12, mark->pose.position_m[0]);
    EXPECT_WITHIN(3.0, 1e-12, mark->pose.position_m[2]);
}

static void a_tree_has_its_bodies_parents_first(void)
{
    // The file names the outer joint first.
    expect_robot(LINK("tip") LINK("root") LINK("mid")
                     JOINT("outer", "prismatic", "mid", "tip", LIMIT "<axis xyz=\"0 3 4\"/>")
                         JOINT("inner", "continuous", "root", "mid",
                               "<origin xyz=\"0 0 2\" rpy=\"0 1.5707963267948966 0\"/><dynamics "
                               "damping=\"0\" friction=\"0.0\"/>"));
    TEST_ASSERT_EQUAL_UINT(2U, model.joint_count);
    TEST_ASSERT_EQUAL_STRING("inner", model.joint[0].name);
    TEST_ASSERT_EQUAL_UINT(0U, model.joint[0].parent);
    TEST_ASSERT_EQUAL_UINT(1U, model.joint[1].parent);
    TEST_ASSERT_EQUAL_INT(ROBOT_JOINT_PRISMATIC, model.joint[1].kind);
    EXPECT_WITHIN(0.8, 1e-15, model.joint[1].axis[2]);
    EXPECT_WITHIN(1.0, 0.0, model.joint[0].axis[0]);                    // The default axis.
    EXPECT_WITHIN(1.0, 1e-15, model.joint[0].origin.rotation.at[0][2]); // Pitch takes z to x.
    EXPECT_WITHIN(-1.0, 0.0, model.joint[1].lower);
}

static void visual_elements_and_transmissions_are_skipped(void)
{
    expect_robot("<material name=\"grey\"><color rgba=\"1 1 1 1\"/></material>\n"
                 "<link name=\"a\"><visual><geometry><mesh filename=\"x.stl\"/></geometry>text</visual>"
                 "<collision name=\"c\"><origin xyz=\"1 2 3\"/><geometry><cylinder radius=\"0.5\" "
                 "length=\"2\"/></geometry>"
                 "</collision></link>\n"
                 "<transmission name=\"t\"><type>anything</type></transmission>\n");
    TEST_ASSERT_EQUAL_INT(SHAPE_CYLINDER, model.shape[0].kind);
    EXPECT_WITHIN(2.0, 0.0, model.shape[0].length_m);
    EXPECT_WITHIN(3.0, 0.0, model.shape[0].pose.position_m[2]);
}

static void the_name_space_of_xacro_may_remain(void)
{
    const char* robot =
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name=\"r\">" LINK("a") "</robot>";
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK, robot_model_read(temporary_file("robot.urdf", robot), &model, error), error);
}

static void elements_with_unknown_physics_are_refused(void)
{
    expect_refusal("<gazebo/>\n", 2U, "'gazebo', expected link, joint, material or transmission");
    expect_refusal("<link name=\"a\"><sensor/></link>\n", 2U,
                   "'sensor', expected inertial, collision or visual");
    expect_refusal(
        "<link name=\"a\"><collision><geometry><mesh filename=\"x.stl\"/></geometry></collision></link>\n",
        2U, "'mesh', expected one box, sphere or cylinder");
    expect_refusal("\n\n<link name=\"a\"><collision><contact/></collision></link>\n", 4U,
                   "expected origin or geometry");
    expect_refusal(LINK("a") LINK("b") "<joint name=\"j\" type=\"revolute\"><calibration/></joint>\n", 4U,
                   "'calibration', expected origin, parent, child, axis, limit, mimic or zero dynamics");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "floating", "a", "b", ""), 4U,
                   "'floating', expected revolute, continuous, prismatic or fixed");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "<dynamics damping=\"0.1\"/>"), 4U,
                   "damping=\"0.1\"', expected a number from 0 to 0");
    expect_refusal("<link name=\"a\"><inertial><density/></inertial></link>\n", 2U,
                   "expected origin, mass or inertia");
    expect_refusal("<link name=\"a\" weight=\"3\"/>\n", 2U, "weight=\"3\"', expected name");
    expect_refusal("<link name=\"a\"><inertial><mass value=\"1\"><part/></mass></inertial></link>\n", 2U,
                   "'part', expected no element inside");
    expect_refusal("<link name=\"a\"/>words\n", 2U, "'w', expected no text");
}

/// Of two such elements the simulator would take the last one, and other readers the first one.
static void an_element_that_occurs_twice_is_refused(void)
{
    static const char* const once[] = {
        "<origin/>", "<mass value=\"1\"/>",
        "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"};
    static const char* const of_joint[] = {"<origin/>",
                                           "<parent link=\"a\"/>",
                                           "<child link=\"b\"/>",
                                           "<axis xyz=\"0 0 1\"/>",
                                           "<limit effort=\"1\" velocity=\"1\"/>",
                                           "<dynamics/>",
                                           "<mimic joint=\"k\"/>"};
    char body[1024];
    for (size_t i = 0U; i < (sizeof once / sizeof once[0]); i++) {
        (void)snprintf(body, sizeof body, "<link name=\"a\"><inertial>%s\n%s</inertial></link>\n", once[i],
                       once[i]);
        expect_refusal(body, 3U, "expected only one of these in its parent");
    }
    for (size_t i = 0U; i < (sizeof of_joint / sizeof of_joint[0]); i++) {
        (void)snprintf(body, sizeof body,
                       "<joint name=\"i\" type=\"fixed\">%s</joint>\n"
                       "<joint name=\"j\" type=\"fixed\">%s\n%s</joint>\n",
                       of_joint[i], of_joint[i], of_joint[i]);
        expect_refusal(body, 4U, "expected only one of these in its parent");
    }
    expect_refusal("<link name=\"a\"><collision><origin/>\n<origin/></collision></link>\n", 3U,
                   "'origin', expected only one of these in its parent");
}

static void impossible_masses_are_refused(void)
{
    static const struct {
        const char* inertial;
        const char* words;
    } bad[] = {
        {MASS("0", "1"), "value=\"0\"', expected a number from 1e-09"},
        {MASS("-1", "1"), "value=\"-1\"'"},
        {MASS("nan", "1"), "value=\"nan\"'"},
        {MASS("1", "0"), "positive about every axis"},
        {MASS("1", "-1"), "positive about every axis"},
        {"<inertial><mass value=\"1\"/></inertial>", "a mass and an inertia"},
        {"<inertial/>", "a mass and an inertia"},
        {"<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
         "izz=\"2.1\"/></inertial>",
         "none is more than the sum of the others"},
        // The principal moments are 1.5, 0.5 and 2.1.
        {"<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0.5\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
         "izz=\"2.1\"/></inertial>",
         "none is more than the sum of the others"},
        // All moments on the diagonal are positive, but one principal moment is not.
        {"<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"1.1\" iyy=\"1\" iyz=\"0\" "
         "izz=\"1\"/></inertial>",
         "positive about every axis"},
        {MASS("1", "1") MASS("1", "1"), "one inertial in each link"},
        {"<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>",
         "an attribute ixy"},
    };
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        char body[600];
        (void)snprintf(body, sizeof body, "\n<link name=\"a\">%s</link>\n", bad[i].inertial);
        expect_refusal(body, 3U, bad[i].words);
    }
    // A thin rod is accepted: two equal moments and a small third one.
    expect_robot(
        "<link name=\"rod\"><inertial><mass value=\"1\"/>"
        "<inertia ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\n");
}

static void robots_that_are_not_a_tree_are_refused(void)
{
    expect_refusal("", 1U, "'no root', expected a link that is no joint's child");
    expect_refusal(LINK("a") LINK("a"), 3U, "'a', expected a name that no earlier link has");
    expect_refusal(LINK("a") LINK("b"), 3U, "'b', expected one root");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "fixed", "a", "c", ""), 4U,
                   "'c', expected a child that is a link");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "fixed", "d", "b", ""), 4U,
                   "'d', expected a parent that is a link");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "fixed", "a", "b", "") JOINT("j", "fixed", "b", "a", ""),
                   5U, "'j', expected a name that no earlier joint has");
    expect_refusal(LINK("a") LINK("b") LINK("c") JOINT("j", "fixed", "a", "c", "")
                       JOINT("k", "fixed", "b", "c", ""),
                   6U, "'c', expected a child that no earlier joint has");
    expect_refusal(LINK("a") LINK("b") LINK("c") JOINT("j", "fixed", "b", "c", "")
                       JOINT("k", "fixed", "c", "b", ""),
                   3U, "'b', expected a link that joints connect with the root");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "fixed", "a", "b", "") JOINT("k", "fixed", "b", "a", ""),
                   1U, "'no root'");
}

static void joints_that_cannot_move_are_refused(void)
{
    expect_refusal(LINK("a") LINK("b") JOINT("j", "revolute", "a", "b", ""), 4U,
                   "'j', expected a limit with lower < upper");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "prismatic", "a", "b",
                                             "<limit lower=\"1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"),
                   4U, "lower < upper");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "<axis xyz=\"0 0 0\"/>"), 4U,
                   "'j', expected a joint whose axis has a direction");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "<axis xyz=\"0 1\"/>"), 4U,
                   "xyz=\"0 1\"', expected three numbers");
    expect_refusal(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "<axis xyz=\"0 1 0 0\"/>"), 4U,
                   "expected three numbers");
    expect_refusal(LINK("a") "<link name=\"b\"/>\n" JOINT("j", "continuous", "a", "b", ""), 4U,
                   "'j', expected a joint that moves a mass");
    expect_refusal("<link name=\"a\"><collision/></link>\n", 2U, "'collision', expected a geometry in it");
}

static void a_joint_follows_another(void)
{
    // The file names the mimic joint first.
    expect_robot(LINK("a") LINK("b") LINK("c") JOINT(
        "k", "prismatic", "a", "c", LIMIT "<mimic joint=\"j\" multiplier=\"-0.5\" offset=\"0.1\"/>")
                     JOINT("j", "continuous", "a", "b", ""));
    TEST_ASSERT_TRUE(model.joint[0].is_mimic);
    TEST_ASSERT_EQUAL_UINT(1U, model.joint[0].leader);
    EXPECT_WITHIN(-0.5, 0.0, model.joint[0].multiplier);
    EXPECT_WITHIN(0.1, 0.0, model.joint[0].offset);
    TEST_ASSERT_FALSE(model.joint[1].is_mimic);
    expect_robot(LINK("a") LINK("b") LINK("c") JOINT("j", "continuous", "a", "b", "")
                     JOINT("k", "continuous", "b", "c", "<mimic joint=\"j\"/>"));
    EXPECT_WITHIN(1.0, 0.0, model.joint[1].multiplier);
    EXPECT_WITHIN(0.0, 0.0, model.joint[1].offset);
}

static void a_mimic_that_cannot_follow_is_refused(void)
{
#define PAIR(first, second)                                                                                  \
    LINK("a")                                                                                                \
    LINK("b") LINK("c") JOINT("j", "continuous", "a", "b", first) JOINT("k", "continuous", "b", "c", second)
    expect_refusal(PAIR("", "\n\n<mimic joint=\"m\"/>"), 8U, "'m', expected a joint of the file that moves");
    expect_refusal(PAIR("", "<mimic joint=\"k\"/>"), 6U, "'k', expected a joint that is not itself a mimic");
    expect_refusal(PAIR("<mimic joint=\"k\"/>", "<mimic joint=\"j\"/>"), 5U,
                   "'k', expected a joint that is not itself a mimic");
    expect_refusal(PAIR("", "<mimic joint=\"j\"/>") LINK("d")
                       JOINT("l", "continuous", "c", "d", "<mimic joint=\"k\" multiplier=\"2\"/>"),
                   8U, "'k', expected a joint that is not itself a mimic");
    expect_refusal(PAIR("", "") LINK("d") JOINT("l", "fixed", "c", "d", "<mimic joint=\"k\"/>"), 8U,
                   "'mimic', expected no mimic in a fixed joint");
    expect_refusal(PAIR("", "") LINK("d") JOINT("m", "fixed", "c", "d", "") LINK("e")
                       JOINT("n", "continuous", "d", "e", "<mimic joint=\"m\"/>"),
                   10U, "'m', expected a joint of the file that moves");
    expect_refusal(PAIR("", "<mimic multiplier=\"1\"/>"), 6U, "'mimic', expected an attribute joint");
    expect_refusal(PAIR("", "<mimic joint=\"j\" multiplier=\"nan\"/>"), 6U, "multiplier=\"nan\"'");
}

static void more_elements_than_the_model_can_hold_are_refused(void)
{
    static char body[32000];
    size_t used = 0U;
    for (unsigned i = 0U; i < 33U; i++) {
        used += (size_t)snprintf(&body[used], sizeof body - used, "<link name=\"l%u\"/>\n", i);
    }
    expect_refusal(body, 34U, "'one more link', expected at most 32");
    used = 0U;
    for (unsigned i = 0U; i < 14U; i++) {
        used += (size_t)snprintf(&body[used], sizeof body - used,
                                 "<link name=\"l%u\">" MASS("1", "1") "</link>\n", i);
    }
    for (unsigned i = 0U; i < 13U; i++) {
        used += (size_t)snprintf(
            &body[used], sizeof body - used,
            "<joint name=\"j%u\" type=\"continuous\"><parent link=\"l%u\"/><child link=\"l%u\"/></joint>\n",
            i, i, i + 1U);
    }
    expect_refusal(body, 28U, "'j12', expected at most 12 joints that move");
    used = (size_t)snprintf(body, sizeof body, "<link name=\"a\">\n");
    for (unsigned i = 0U; i < 33U; i++) {
        used += (size_t)snprintf(&body[used], sizeof body - used,
                                 "<collision><geometry><sphere radius=\"1\"/></geometry></collision>\n");
    }
    (void)snprintf(&body[used], sizeof body - used, "</link>\n");
    expect_refusal(body, 35U, "'one more shape', expected at most 32");
}

static void broken_files_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, robot_model_read("/nowhere.urdf", &model, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere.urdf: "));
    expect_refusal("<link name=\"a\">\n", 3U, "well-formed XML");
    TEST_ASSERT_EQUAL_INT(
        STATUS_INVALID,
        robot_model_read(temporary_file("x.urdf", "<!DOCTYPE robot [<!ENTITY a \"b\">]>\n<robot/>"), &model,
                         error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "x.urdf:1: found 'robot', expected no document type"), error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID,
                          robot_model_read(temporary_file("x.urdf", "<mujoco/>"), &model, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "found 'mujoco', expected robot"), error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, robot_model_read(temporary_file("x.urdf", ""), &model, error));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_arm_of_the_mission_has_the_numbers_of_its_file);
    RUN_TEST(fixed_links_become_one_body);
    RUN_TEST(a_tree_has_its_bodies_parents_first);
    RUN_TEST(visual_elements_and_transmissions_are_skipped);
    RUN_TEST(the_name_space_of_xacro_may_remain);
    RUN_TEST(elements_with_unknown_physics_are_refused);
    RUN_TEST(an_element_that_occurs_twice_is_refused);
    RUN_TEST(impossible_masses_are_refused);
    RUN_TEST(robots_that_are_not_a_tree_are_refused);
    RUN_TEST(joints_that_cannot_move_are_refused);
    RUN_TEST(a_joint_follows_another);
    RUN_TEST(a_mimic_that_cannot_follow_is_refused);
    RUN_TEST(more_elements_than_the_model_can_hold_are_refused);
    RUN_TEST(broken_files_are_refused);
    return UNITY_END();
}
