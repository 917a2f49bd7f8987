// SPDX-License-Identifier: Apache-2.0
// A subsystem that runs with another descriptor than the supervisor has read: told once for each change, and
// with another interface led nowhere but down.
#include "test/unit/fsw/supervisor/bed.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define TICKS_OF_A_STATUS 130U ///< It comes once a second.
#define FOREIGN 0x1122334455667788ULL

void setUp(void)
{
    bed_open_up();
    bed_forget();
}

void tearDown(void)
{
    bed_close();
}

static unsigned count(const char* text, const char* part)
{
    unsigned found = 0U;
    for (const char* at = strstr(text, part); at != NULL; at = strstr(at + 1, part)) {
        found++;
    }
    return found;
}

/// How the event that names a member's two hashes looks in the lines to the ground.
static void expect_told(const char* text, uint16_t event, uint64_t expected, uint64_t offset)
{
    char line[96];
    (void)snprintf(line, sizeof line, "G 5.2 %04X%04X%016llX%016llX", (unsigned)event, LONE,
                   (unsigned long long)expected, (unsigned long long)(expected + offset));
    TEST_ASSERT_EQUAL_MESSAGE(1U, count(text, line), text);
}

static const mission_subsystem_t* lone(void)
{
    return mission_find_subsystem(bed.supervisor.mission, LONE);
}

static void equal_descriptors_are_no_news(void)
{
    bed_run(TICKS_OF_A_STATUS);
    TEST_ASSERT_EQUAL(0U, count(bed_look(), "G 5."));
    TEST_ASSERT_TRUE(lone()->interface_hash != lone()->configuration_hash);
}

static void another_interface_is_told_once_and_refused(void)
{
    bed.members[BED_LONE].interface_offset = FOREIGN;
    bed_run(3U * TICKS_OF_A_STATUS);
    expect_told(bed_look(), 9U, lone()->interface_hash, FOREIGN);
    bed_forget();
    (void)bed_request_state(LONE, STATE_PRE_OPERATIONAL);
    bed_run(3U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #0 0114 12"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, bed.members[BED_LONE].state);
}

static void downwards_it_may_go_and_answer(void)
{
    bed_place(BED_LONE, STATE_PRE_OPERATIONAL);
    bed.members[BED_LONE].interface_offset = FOREIGN;
    bed_run(TICKS_OF_A_STATUS);
    bed_forget();
    (void)bed_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    bed_run(3U);
    TEST_ASSERT_EQUAL(0U, count(bed_look(), " 0114"));
    (void)bed_request_state(LONE, STATE_OFFLINE);
    bed_run(3U);
    TEST_ASSERT_EQUAL(0U, count(bed_look(), " 0114"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, bed.members[BED_LONE].state);
}

static void with_the_right_interface_again_it_is_led_on(void)
{
    bed.members[BED_LONE].interface_offset = FOREIGN;
    bed_run(TICKS_OF_A_STATUS);
    bed.members[BED_LONE].interface_offset = 0U;
    bed_run(TICKS_OF_A_STATUS);
    bed_forget();
    (void)bed_request_state(LONE, STATE_PRE_OPERATIONAL);
    bed_run(3U);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, bed.members[BED_LONE].state);
    bed.members[BED_LONE].interface_offset = FOREIGN; // The same again is news again.
    bed_run(TICKS_OF_A_STATUS);
    expect_told(bed_look(), 9U, lone()->interface_hash, FOREIGN);
}

static void another_configuration_is_told_once_for_each_and_not_refused(void)
{
    bed.members[BED_LONE].configuration_offset = 1U;
    bed_run(3U * TICKS_OF_A_STATUS);
    bed.members[BED_LONE].configuration_offset = 2U; // Read anew, with another file.
    bed_run(3U * TICKS_OF_A_STATUS);
    const char* const text = bed_look();
    expect_told(text, 10U, lone()->configuration_hash, 1U);
    expect_told(text, 10U, lone()->configuration_hash, 2U);
    (void)bed_request_state(LONE, STATE_PRE_OPERATIONAL);
    bed_run(3U);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, bed.members[BED_LONE].state);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(equal_descriptors_are_no_news);
    RUN_TEST(another_interface_is_told_once_and_refused);
    RUN_TEST(downwards_it_may_go_and_answer);
    RUN_TEST(with_the_right_interface_again_it_is_led_on);
    RUN_TEST(another_configuration_is_told_once_for_each_and_not_refused);
    return UNITY_END();
}
