// SPDX-License-Identifier: Apache-2.0
// A subsystem that runs with another descriptor than the one the supervisor has read: reported once for each
// change. If the interface differs, only transitions towards OFFLINE are permitted.
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

#define TICKS_OF_A_STATUS 130U ///< More than two intervals between status reports (50 ticks).
#define OTHER_HASH 0x1122334455667788ULL

void setUp(void)
{
    fixture_open_up();
    fixture_forget();
}

void tearDown(void)
{
    fixture_close();
}

/// Expect the event with a member's two hashes in the lines to the ground.
static void expect_reported(const char* text, uint16_t event, uint64_t expected, uint64_t offset)
{
    char line[96];
    (void)snprintf(line, sizeof line, "G 5.2 %04X%04X%016llX%016llX", (unsigned)event, LONE,
                   (unsigned long long)expected, (unsigned long long)(expected + offset));
    TEST_ASSERT_EQUAL_MESSAGE(1U, fixture_count(text, line), text);
}

static const mission_subsystem_t* lone(void)
{
    return descriptor_mission_find_subsystem(fixture.supervisor.mission, LONE);
}

static void equal_descriptors_are_not_reported(void)
{
    fixture_run(TICKS_OF_A_STATUS);
    TEST_ASSERT_EQUAL(0U, fixture_count(fixture_look(), "G 5."));
    TEST_ASSERT_TRUE(lone()->interface_hash != lone()->configuration_hash);
}

static void another_interface_is_reported_once_and_refused(void)
{
    fixture.members[FIXTURE_LONE].interface_offset = OTHER_HASH;
    fixture_run(3U * TICKS_OF_A_STATUS);
    expect_reported(fixture_look(), SUPERVISOR_EVENT_INTERFACE_DIFFERS, lone()->interface_hash, OTHER_HASH);
    fixture_forget();
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #0 0114 12"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_LONE].state);
}

static void with_another_interface_a_subsystem_may_go_down_and_answer(void)
{
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_LONE].interface_offset = OTHER_HASH;
    fixture_run(TICKS_OF_A_STATUS);
    fixture_forget();
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(0U, fixture_count(fixture_look(), " 0114"));
    (void)fixture_request_state(LONE, STATE_OFFLINE);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(0U, fixture_count(fixture_look(), " 0114"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_LONE].state);
}

static void with_the_correct_interface_again_requests_are_permitted(void)
{
    fixture.members[FIXTURE_LONE].interface_offset = OTHER_HASH;
    fixture_run(TICKS_OF_A_STATUS);
    fixture.members[FIXTURE_LONE].interface_offset = 0U;
    fixture_run(TICKS_OF_A_STATUS);
    fixture_forget();
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_LONE].state);
    // After an equal descriptor, the same difference is reported again.
    fixture.members[FIXTURE_LONE].interface_offset = OTHER_HASH;
    fixture_run(TICKS_OF_A_STATUS);
    expect_reported(fixture_look(), SUPERVISOR_EVENT_INTERFACE_DIFFERS, lone()->interface_hash, OTHER_HASH);
}

static void another_configuration_is_reported_once_for_each_and_not_refused(void)
{
    fixture.members[FIXTURE_LONE].configuration_offset = 1U;
    fixture_run(3U * TICKS_OF_A_STATUS);
    fixture.members[FIXTURE_LONE].configuration_offset = 2U; // The subsystem has read another file.
    fixture_run(3U * TICKS_OF_A_STATUS);
    const char* const text = fixture_look();
    expect_reported(text, SUPERVISOR_EVENT_CONFIGURATION_DIFFERS, lone()->configuration_hash, 1U);
    expect_reported(text, SUPERVISOR_EVENT_CONFIGURATION_DIFFERS, lone()->configuration_hash, 2U);
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, fixture.members[FIXTURE_LONE].state);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(equal_descriptors_are_not_reported);
    RUN_TEST(another_interface_is_reported_once_and_refused);
    RUN_TEST(with_another_interface_a_subsystem_may_go_down_and_answer);
    RUN_TEST(with_the_correct_interface_again_requests_are_permitted);
    RUN_TEST(another_configuration_is_reported_once_for_each_and_not_refused);
    return UNITY_END();
}
