// SPDX-License-Identifier: Apache-2.0
// Valves of a world: values that are read, and every refusal with file and line.
#include "sim/world/world.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define WORLD "descriptors/worlds/actuators.xml"
#define VALVE(name, on, direction, output)                                                                   \
    "<Valve name=\"" name "\" on=\"" on "\" at=\"0 0 0\" direction=\"" direction                             \
    "\" force=\"1\" output=\"" output "\"/>\n"
#define BOX(name, node) "<ValveBox name=\"" name "\" bus=\"b\" node=\"" node "\" eds=\"e\">\n"

static world_t world;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    (void)temporary_copy("satellite.urdf", "descriptors/worlds/satellite.urdf");
}

void tearDown(void)
{
    temporary_files_remove();
}

static void valves_are_read_with_their_box_link_and_output(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(WORLD, &world, error), error);
    TEST_ASSERT_EQUAL_UINT(1U, world.valve_box_count);
    TEST_ASSERT_EQUAL_STRING("VALVES", world.valve_box[0].device.name);
    TEST_ASSERT_EQUAL_UINT(0x3AU, world.valve_box[0].device.node);
    TEST_ASSERT_EQUAL_UINT(4U, world.valve_count);
    const world_valve_t* valve = &world.valve[3];
    TEST_ASSERT_EQUAL_STRING("TURN2", valve->name);
    TEST_ASSERT_EQUAL_UINT(0U, valve->box);
    TEST_ASSERT_EQUAL_UINT(10U, valve->output);
    EXPECT_WITHIN(20e6, 0.0, valve->shortest_ns);
    EXPECT_WITHIN(-0.5, 0.0, valve->at[1]);
    EXPECT_WITHIN(1.0, 0.0, valve->direction[0]);
}

/// Expect that the world with `text` before its end is refused; the first line of `text` has number 1.
static void expect_refusal(const char* text, const unsigned line, const char* words)
{
    char location[40];
    char whole[8192];
    const unsigned end = line_of(WORLD, "</World>");
    (void)snprintf(whole, sizeof whole, "%s</World>", text);
    const char* path = temporary_variant("w.xml", WORLD, "</World>", whole);
    (void)snprintf(location, sizeof location, "w.xml:%u: found '", end + line - 1U);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_INVALID, world_read(path, &world, error), words);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void bad_boxes_and_valves_are_refused(void)
{
    static const struct {
        const char* text;
        unsigned line;
        const char* words;
    } cases[] = {
        {BOX("BOX", "0x3B") VALVE("A", "satellite.hull", "1 0 0", "1") "</ValveBox>\n", 2U,
         "found 'satellite.hull', expected robot.link of a robot above"},
        {BOX("BOX", "0x3B") VALVE("A", "satellite.body", "0 0 0", "1") "</ValveBox>\n", 2U,
         "found '0 0 0', expected a direction other than 0 0 0"},
        {BOX("BOX", "0x3B") VALVE("A", "satellite.body", "1 0 0", "17") "</ValveBox>\n", 2U,
         "found 'output=\"17\"', expected a whole number from 1 to 16"},
        {BOX("BOX", "0x3B") VALVE("A", "satellite.body", "1 0 0", "0") "</ValveBox>\n", 2U,
         "found 'output=\"0\"'"},
        {BOX("BOX", "0x3B") VALVE("PUSH1", "satellite.body", "1 0 0", "1") "</ValveBox>\n", 2U,
         "a name that no Valve above has"},
        {BOX("BOX", "0x3B") VALVE("A", "satellite.body", "1 0 0", "0x3")
             VALVE("B", "satellite.body", "1 0 0", "3") "</ValveBox>\n",
         3U, "found '3', expected an output that no Valve above has in this ValveBox"},
        {"<ValveBox name=\"BOX\" bus=\"platform\" node=\"0x25\" eds=\"e\"/>\n", 1U,
         "a node id that no device above has on this bus"},
        {VALVE("A", "satellite.body", "1 0 0", "3"), 1U, "found 'Valve'"},
        {BOX("VALVES", "0x3B") "</ValveBox>\n", 1U, "a name that no device above has"},
        {"<ValveBox name=\"BOX\" bus=\"b\" node=\"1\" eds=\"e\"/>\n", 1U, "found 'node=\"1\"'"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        expect_refusal(cases[i].text, cases[i].line, cases[i].words);
    }
}

static void more_valves_than_the_world_can_hold_are_refused(void)
{
    char text[6000]   = "";
    const char* boxes = BOX("B1", "2") "</ValveBox>\n" BOX("B2", "3") "</ValveBox>\n" BOX(
        "B3", "4") "</ValveBox>\n" BOX("B4", "5") "</ValveBox>\n";
    expect_refusal(boxes, 7U, "at most 4 of them");
    size_t used = (size_t)snprintf(text, sizeof text, "%s", BOX("B1", "2"));
    for (unsigned i = 0U; i < 29U; i++) {
        used += (size_t)snprintf(&text[used], sizeof text - used,
                                 "%s<Valve name=\"V%u\" on=\"satellite.body\" at=\"0 0 0\" direction=\"0 0 "
                                 "1\" force=\"1\" output=\"%u\"/>\n",
                                 (i == 16U) ? "</ValveBox>\n" BOX("B2", "3") : "", i, (i % 16U) + 1U);
    }
    (void)snprintf(&text[used], sizeof text - used, "</ValveBox>\n");
    expect_refusal(text, 32U, "at most 32 valves");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(valves_are_read_with_their_box_link_and_output);
    RUN_TEST(bad_boxes_and_valves_are_refused);
    RUN_TEST(more_valves_than_the_world_can_hold_are_refused);
    return UNITY_END();
}
