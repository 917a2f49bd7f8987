// SPDX-License-Identifier: Apache-2.0
// A port with two readers: one network of three members, and each link with its own session, epoch and end.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

/// Open the link to the second reader, which is the third member of the network.
static void bring_second_reader(void)
{
    (void)fixture_request_link(LINK_LONE_STATE);
    fixture_run(5U);
    (void)fixture_open_link(LINK_LONE_STATE);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(3U, fixture.supervisor.graph.count);
}

void setUp(void)
{
    fixture_open_up();
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture_link_up(STATE_PRE_OPERATIONAL);
    bring_second_reader();
}

void tearDown(void)
{
    fixture_close();
}

static void a_second_reader_does_not_affect_the_first(void)
{
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.6 000300000003")); // The second link has an epoch of its own.
    TEST_ASSERT_TRUE(fixture_has("18 TC 130.6 000300000003"));
    TEST_ASSERT_FALSE(fixture_has("17 TC 130."));
    TEST_ASSERT_FALSE(fixture_has("130.7"));
}

static void the_network_has_all_readers(void)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_REPORT_NETWORKS, NULL, 0U);
    fixture_run(2U);
    // One network, number 16, of 16, 17 and 18, links 1, 2 and 3.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "G 131.11 0001001000030010001100120003000100020003"));
}

/// The data of TC[130,7] are the link and the reason; 0A is PUS_LINK_REASON_PEER.
static void a_reader_that_closes_closes_only_its_own_link(void)
{
    fixture_forget();
    fixture_link_changed(FIXTURE_LONE, LINK_LONE_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_CLOSED);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 00030A"));
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
    fixture_forget();
    bring_second_reader();
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.6 000300000004")); // Another epoch.
    TEST_ASSERT_FALSE(fixture_has("17 TC 130."));
}

static void the_second_reader_stays_when_the_first_closes(void)
{
    fixture_forget();
    (void)fixture_close_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 0001"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));
    TEST_ASSERT_FALSE(fixture_has("130.7 0003"));
    TEST_ASSERT_NOT_NULL(supervisor_link_graph_find(&fixture.supervisor.graph, LINK_LONE_STATE));
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
}

static void a_reader_that_dies_fails_its_network_and_loses_only_its_own_link(void)
{
    fixture_forget();
    fixture.members[FIXTURE_LONE].is_running = false;
    fixture_run(3U);
    // Both other members get the order for ERROR_OPERATIONAL (6), because the writer connects them.
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.7 00030A"));
    TEST_ASSERT_FALSE(fixture_has("17 TC 130.7"));
    TEST_ASSERT_FALSE(fixture_has("16 TC 130.7 0001"));
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
}

static void a_writer_that_dies_closes_every_reader(void)
{
    fixture_forget();
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.8 06"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 00010A"));
    TEST_ASSERT_TRUE(fixture_has("18 TC 130.7 00030A"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_second_reader_does_not_affect_the_first);
    RUN_TEST(the_network_has_all_readers);
    RUN_TEST(a_reader_that_closes_closes_only_its_own_link);
    RUN_TEST(the_second_reader_stays_when_the_first_closes);
    RUN_TEST(a_reader_that_dies_fails_its_network_and_loses_only_its_own_link);
    RUN_TEST(a_writer_that_dies_closes_every_reader);
    return UNITY_END();
}
