// SPDX-License-Identifier: Apache-2.0
// Latches of a world: values that are read, and every refusal with file and line.
#include "sim/world/world.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define LINK(name)                                                                                           \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" " \
    "iyz=\"0\" izz=\"1\"/></inertial></link>"
#define ROBOT                                                                                                \
    "<robot name=\"r\">" LINK("base") LINK("rod") "<link name=\"tip\"/>"                                     \
                                                  "<joint name=\"turn\" type=\"continuous\"><parent "        \
                                                  "link=\"base\"/><child link=\"rod\"/></joint>"             \
                                                  "<joint name=\"weld\" type=\"fixed\"><parent "             \
                                                  "link=\"rod\"/><child link=\"tip\"/></joint></robot>"
#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.5\" stiffness=\"1e5\" damping=\"100\" "            \
    "coulomb=\"0.5\" stiction=\"0.5\" stribeck=\"0.001\" viscous=\"2\" brake=\"100\" stopStiffness=\"2e4\" " \
    "stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" "        \
    "range=\"90\"/></DriveType>"
#define HEAD                                                                                                 \
    "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\"><Robot name=\"f\" urdf=\"r.urdf\" "                  \
    "base=\"fixed\"/><Robot name=\"g\" urdf=\"r.urdf\" base=\"fixed\"/><Robot name=\"s\" urdf=\"r.urdf\" "   \
    "base=\"free\"/>" TYPE "<Drive name=\"D1\" joint=\"f.turn\" type=\"t\" bus=\"b\" node=\"10\" "           \
    "eds=\"e\"/><Drive name=\"D2\" joint=\"s.turn\" type=\"t\" bus=\"b\" node=\"11\" eds=\"e\"/>"            \
    "<ValveBox name=\"V\" bus=\"b\" node=\"12\" eds=\"e\"/><ValveBox name=\"W\" bus=\"b\" node=\"13\" "      \
    "eds=\"e\"><Valve name=\"A\" on=\"s.rod\" at=\"0 0 0\" direction=\"1 0 0\" force=\"1\" output=\"7\"/>"   \
    "</ValveBox>\n"
#define LATCH(name, a, b, more)                                                                              \
    "<Latch name=\"" name "\" a=\"" a "\" b=\"" b "\" distance=\"0.01\" angle=\"0.05\" speed=\"0.02\" " more \
    "/>\n"
#define END "</World>\n"

static world_t world;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    (void)temporary_file("r.urdf", ROBOT);
}

void tearDown(void)
{
    temporary_files_remove();
}

static void latches_are_read_with_their_conditions(void)
{
    const char* path = temporary_file(
        "w.xml", HEAD LATCH("L1", "s.base", "f.base", "")
                     LATCH("L2", "s.tip", "f.rod", "when=\"D2\" force=\"15\" stall=\"300ms\" release=\"0.2\"")
                         LATCH("L3", "s.tip", "s.base", "when=\"W\" output=\"0x8\"") END);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    TEST_ASSERT_EQUAL_UINT(3U, world.latch_count);
    TEST_ASSERT_EQUAL_INT(WORLD_LATCH_TOUCHED, world.latch[0].trigger);
    EXPECT_WITHIN(0.01, 0.0, world.latch[0].distance);
    EXPECT_WITHIN(0.05, 0.0, world.latch[0].angle);
    EXPECT_WITHIN(0.02, 0.0, world.latch[0].speed);
    TEST_ASSERT_EQUAL_UINT(2U, world.latch[0].side[0].robot);
    TEST_ASSERT_EQUAL_UINT(0U, world.latch[0].side[1].robot);
    TEST_ASSERT_EQUAL_INT(WORLD_LATCH_PRESSED, world.latch[1].trigger);
    TEST_ASSERT_EQUAL_UINT(1U, world.latch[1].drive);
    EXPECT_WITHIN(15.0, 0.0, world.latch[1].force);
    EXPECT_WITHIN(3e8, 0.0, world.latch[1].stall_ns);
    EXPECT_WITHIN(0.2, 0.0, world.latch[1].release);
    TEST_ASSERT_EQUAL_INT(WORLD_LATCH_WIRED, world.latch[2].trigger);
    TEST_ASSERT_EQUAL_UINT(1U, world.latch[2].box);
    TEST_ASSERT_EQUAL_UINT(8U, world.latch[2].output);
}

static void bad_latches_are_refused(void)
{
    static const struct {
        const char* text;
        unsigned line;
        const char* words;
    } bad[] = {
        {LATCH("L", "s.hull", "f.base", ""), 2U, "found 's.hull', expected robot.link"},
        {LATCH("L", "s.base", "V", ""), 2U, "found 'V', expected robot.link"},
        {LATCH("L", "s.rod", "s.tip", ""), 2U, "found 's.tip', expected a link that moves relative"},
        {LATCH("L", "f.base", "g.base", ""), 2U, "found 'g.base', expected a link that moves relative"},
        {LATCH("L", "s.rod", "f.rod", "") LATCH("L", "s.rod", "f.rod", ""), 3U, "a name that no Latch above"},
        {LATCH("L", "s.rod", "f.rod", "when=\"X\""), 2U, "found 'X', expected a Gripper, Drive or ValveBox"},
        {LATCH("L", "s.rod", "f.rod", "when=\"D1\" force=\"1\""), 2U, "expected force and stall"},
        {LATCH("L", "s.rod", "f.rod", "when=\"D1\" stall=\"1s\""), 2U, "expected force and stall"},
        {LATCH("L", "s.rod", "f.rod", "force=\"1\" stall=\"1s\""), 2U, "expected force and stall"},
        {LATCH("L", "s.rod", "f.rod", "when=\"V\" output=\"1\" release=\"1\""), 2U,
         "expected force and stall"},
        {LATCH("L", "s.rod", "f.rod", "when=\"V\""), 2U, "expected output"},
        {LATCH("L", "s.rod", "f.rod", "output=\"1\""), 2U, "expected output"},
        {LATCH("L", "s.rod", "f.rod", "when=\"V\" output=\"17\""), 2U, "found 'output=\"17\"'"},
        {LATCH("L", "s.rod", "f.rod", "when=\"W\" output=\"7\""), 2U, "expected an output without a Valve"},
        {"<Latch name=\"L\" a=\"s.rod\" b=\"f.rod\" distance=\"0\" angle=\"1\" speed=\"1\"/>\n", 2U,
         "found 'distance=\"0\"'"},
        {LATCH("L1", "s.rod", "f.rod", "") LATCH("L2", "f.rod", "s.rod", ""), 3U,
         "found 'L2', expected links that no Latch above connects by the same `when` and output"},
        {LATCH("L1", "s.rod", "f.rod", "when=\"V\" output=\"1\"")
             LATCH("L2", "s.rod", "f.rod", "when=\"V\" output=\"1\""),
         3U, "found 'L2', expected links that no Latch above connects"},
        {LATCH("L1", "s.rod", "f.rod", "") LATCH("L2", "s.rod", "f.rod", "when=\"V\" output=\"1\"")
             LATCH("L3", "s.rod", "f.rod", "when=\"V\" output=\"2\"") LATCH("L4", "s.tip", "f.rod", "")
                 LATCH("L5", "s.rod", "g.rod", ""),
         6U, "expected at most 4"}};
    for (size_t i = 0U; i < sizeof bad / sizeof bad[0]; i++) {
        char whole[8192];
        char location[40];
        (void)snprintf(whole, sizeof whole, "%s%s%s", HEAD, bad[i].text, END);
        (void)snprintf(location, sizeof location, "w.xml:%u: found '", bad[i].line);
        TEST_ASSERT_EQUAL_INT_MESSAGE(
            STATUS_INVALID, world_read(temporary_file("w.xml", whole), &world, error), bad[i].words);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, bad[i].words), error);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(latches_are_read_with_their_conditions);
    RUN_TEST(bad_latches_are_refused);
    return UNITY_END();
}
