// SPDX-License-Identifier: Apache-2.0
// Worlds whose elements contradict each other are refused with file and line; test/conformance/test_worlds.py
// compares these refusals with the schema.
#include "sim/world/world.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define WORLD(body) "<World name=\"w\" step=\"1ms\" gravity=\"0 0 0\">\n" body "</World>\n"
#define ROBOT "<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\"/>\n"
#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"1\" rotorInertia=\"1\" stiffness=\"1\" damping=\"1\" coulomb=\"1\" "      \
    "stiction=\"1\" "                                                                                        \
    "stribeck=\"1\" viscous=\"1\" brake=\"1\" stopStiffness=\"1\" stopDamping=\"1\" encoderCounts=\"1\">"    \
    "<TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" range=\"1\"/></DriveType>\n"
#define WALL "<Fixture name=\"wall\" at=\"0 0 0\"><Sphere radius=\"1\" at=\"0 0 0\"/></Fixture>\n"
#define BENCH(name, bus, node)                                                                               \
    "<Bench name=\"" name "\" type=\"t\" bus=\"" bus "\" node=\"" node                                       \
    "\" eds=\"e\" contact=\"0\" stiffness=\"0\" range=\"1\"/>\n"

#define TOUCH(a, b, more)                                                                                    \
    "<Contact a=\"" a "\" b=\"" b "\" stiffness=\"1\" damping=\"1\" friction=\"1\"" more "/>\n"
#define CABLE(hook, preload)                                                                                 \
    "<CableSpring on=\"arm.lever\" hook=\"" hook                                                             \
    "\" catch=\"1\" length=\"1\" stiffness=\"1\" preload=\"" preload "\" travel=\"1\" limit=\"9\"/>\n"
#define INSTRUMENT(name, type, channel)                                                                      \
    "<Instrument name=\"" name "\" type=\"" type "\" channel=\"" channel                                     \
    "\" period=\"1ms\" value=\"INT16\" speed=\"1\"/>\n"
#define ARM(more) "<Robot name=\"arm\" urdf=\"one.urdf\" base=\"fixed\">\n" more "</Robot>\n"
#define UNIT(more) "<PowerUnit name=\"P\" bus=\"b\" node=\"9\">\n" more "</PowerUnit>\n"
#define SUPPLY "<Supply device=\"C\"/>\n"

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

/// Of two such elements one would have no effect, or both would act where the world means one.
static void elements_that_contradict_each_other_are_refused(void)
{
    static const struct {
        const char* text;
        unsigned line;
        const char* words;
    } bad[] = {
        {WORLD(ARM("<Start axle=\"1\"/>\n<Start axle=\"1\"/>\n")), 4U, "'Start', expected only one of these"},
        {WORLD(ARM("<StartRate/>\n<Start/>\n<StartRate/>\n")), 5U, "'StartRate', expected only one of these"},
        {WORLD(ARM("<State/>\n<State/>\n")), 4U, "'State', expected only one of these"},
        {WORLD(ARM("<Spread/>\n<Spread/>\n")), 4U, "'Spread', expected only one of these"},
        {WORLD(ROBOT WALL TOUCH("arm.lever", "wall", "") TOUCH("arm.lever", "wall", "")), 5U,
         "'wall', expected a pair that no Contact above has"},
        {WORLD(ROBOT TOUCH("arm.lever", "arm.foot", "") TOUCH("arm.foot", "arm.lever", "")), 4U,
         "'arm.lever', expected a pair that no Contact above has"},
        {WORLD(ROBOT WALL TOUCH("arm.lever", "wall", " shearDamping=\"3\"")), 4U,
         "'3', expected no shearDamping in a contact without shear"},
        {WORLD(ROBOT CABLE("0 0 1", "1") CABLE("0 0 1.0", "2")), 4U,
         "'0 0 1.0', expected a hook that no CableSpring above has on this link"},
        {WORLD(ROBOT CABLE("0 0 1", "9.1")), 3U, "'9', expected a limit of at least the preload"},
        {WORLD(TYPE BENCH("C", "b", "5") UNIT(SUPPLY SUPPLY)), 6U,
         "'C', expected a device that no Supply above has"},
        {WORLD(TYPE BENCH("C", "b", "5") UNIT("")), 4U, "'P', expected a Supply inside of the PowerUnit"},
        {WORLD("<Fixture name=\"f\" at=\"0 0 0\"/>\n"), 2U, "'f', expected a Box, Sphere or Cylinder inside"},
        {WORLD(TYPE BENCH("FLIGHT", "b", "5")), 3U, "'FLIGHT', expected another name"},
        {WORLD(INSTRUMENT("I", "UDP", "h:1") INSTRUMENT("K", "UDP", "h:1")), 3U,
         "'h:1', expected a channel that no Instrument of this type above has"},
        {WORLD(INSTRUMENT("b", "SHM", "x") TYPE BENCH("C", "b", "5")), 4U,
         "'b', expected a name of a bus that no Instrument above has"},
        {WORLD(TYPE BENCH("C", "b", "5") INSTRUMENT("b", "SHM", "x")), 4U,
         "'b', expected a name that no bus has"},
        {WORLD(TYPE BENCH("C", "B", "5")), 3U, "'B', expected a lower-case name of a bus"},
        {WORLD(TYPE BENCH("C", "b", "010")), 3U, "node=\"010\"', expected a whole number from 2 to 127"},
        {"<World name=\"W\" step=\"1ms\" gravity=\"0 0 0\"/>", 1U,
         "'W', expected a lower-case name of at most 32"},
        {"<World name=\"w\" step=\"0000000001ms\" gravity=\"0 0 0\"/>", 1U, "step=\"0000000001ms\"'"}};
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        expect_refusal(bad[i].text, bad[i].line, bad[i].words);
    }
    expect_world(WORLD(
        ARM("<StartRate/>\n<Start/>\n") "<Robot name=\"arm-2\" urdf=\"one.urdf\" base=\"fixed\">"
                                        "<Start/></Robot>\n" CABLE("0 0 1", "9") CABLE("0 1 1", "9")
                                            INSTRUMENT("I", "UDP", "h:1") INSTRUMENT("K", "TCP", "h:1")));
    TEST_ASSERT_EQUAL_UINT(2U, world.spring_count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(elements_that_contradict_each_other_are_refused);
    return UNITY_END();
}
