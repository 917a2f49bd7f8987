// SPDX-License-Identifier: Apache-2.0
// Requests to start and stop processes, and for states, at times at which they would do harm.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static uint16_t process_tc(uint8_t subtype, uint16_t apid)
{
    const uint8_t data[2] = {(uint8_t)(apid >> 8U), (uint8_t)apid};
    return fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, subtype, data, sizeof data);
}

/// Another user commands a subsystem while the mission shuts down. If the supervisor passed the request on,
/// the subsystem would not be OFFLINE at the end.
static void no_subsystem_goes_up_and_no_process_starts_during_the_shutdown(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    fixture_run(2U);
    fixture.members[FIXTURE_HAND].is_passive = true; // The shutdown waits for this member.
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(310U); // All subsystems have been ordered to OFFLINE.
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_ARM].state);
    fixture_forget();
    fixture.source    = 3U;
    const uint16_t up = fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    (void)process_tc(PUS_MISSION_START_PROCESS, LONE);
    fixture_run(5U);
    char expected[64];
    (void)snprintf(expected, sizeof expected, "G 1.2 #%u 0204 10\n", up);
    TEST_ASSERT_TRUE(fixture_has(expected));
    (void)snprintf(expected, sizeof expected, "G 1.4 #%u 0204 12\n", up + 1U);
    TEST_ASSERT_TRUE(fixture_has(expected));
    TEST_ASSERT_FALSE(fixture_has("16 TC"));
    TEST_ASSERT_EQUAL(0U, fixture.starts);
}

/// A subsystem is being recommissioned and takes no packets when the shutdown begins.
static void an_order_that_waits_takes_no_subsystem_up_during_the_shutdown(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].is_passive = true; // The shutdown waits for this member.
    fixture_fill(FIXTURE_LONE);
    (void)supervisor_order_state(&fixture.supervisor, LONE, STATE_PRE_OPERATIONAL, PUS_CAUSE_REQUEST);
    TEST_ASSERT_TRUE(supervisor_registry_find(&fixture.supervisor, LONE)->is_order_pending);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(310U); // All subsystems have been ordered to OFFLINE.
    fixture.members[FIXTURE_LONE].takes_nothing = false;
    fixture_run(20U);
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.8 00"));
    TEST_ASSERT_FALSE(fixture_has("18 TC 129.8 03"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_LONE].state);
}

static void an_order_that_waits_ends_with_its_process(void)
{
    registry_entry_t* const entry = supervisor_registry_find(&fixture.supervisor, LONE);
    fixture_fill(FIXTURE_LONE);
    while (message_credit(&fixture.endpoint, LONE) > 0U) { // Orders may also use the reserve.
        (void)supervisor_order_state(&fixture.supervisor, LONE, STATE_OFFLINE, PUS_CAUSE_REQUEST);
    }
    (void)supervisor_order_state(&fixture.supervisor, LONE, STATE_PRE_OPERATIONAL, PUS_CAUSE_REQUEST);
    TEST_ASSERT_TRUE(entry->is_order_pending);
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(PROCESS_STOPPED, entry->process);
    fixture.members[FIXTURE_LONE].takes_nothing = false;
    (void)process_tc(PUS_MISSION_START_PROCESS, LONE);
    fixture_run(100U);
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_LONE].state); // The new life got no old order.
}

/// LONE takes a request that was sent before the shutdown, when all others have been ordered to OFFLINE.
static void a_subsystem_that_leaves_offline_during_the_shutdown_is_ordered_back_once(void)
{
    fixture.members[FIXTURE_LONE].takes_nothing = true;
    fixture.members[FIXTURE_GROUND].is_passive  = true; // The shutdown waits for communication.
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(10U);
    TEST_ASSERT_TRUE(fixture_has("2 TC 129.8 00"));
    fixture_forget();
    fixture.members[FIXTURE_LONE].takes_nothing = false;
    fixture_run(100U); // Status reports come every half second.
    const char* const text = fixture_look();
    TEST_ASSERT_EQUAL_UINT(1U, fixture_count(text, "18 TC 129.1 03"));
    TEST_ASSERT_EQUAL_UINT(1U, fixture_count(text, "18 TC 129.8 0004 from 8001"));
    TEST_ASSERT_EQUAL_UINT(2U, fixture_count(text, "18 TC"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_LONE].state);
    TEST_ASSERT_FALSE(fixture.is_finished);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_subsystem_goes_up_and_no_process_starts_during_the_shutdown);
    RUN_TEST(an_order_that_waits_takes_no_subsystem_up_during_the_shutdown);
    RUN_TEST(an_order_that_waits_ends_with_its_process);
    RUN_TEST(a_subsystem_that_leaves_offline_during_the_shutdown_is_ordered_back_once);
    return UNITY_END();
}
