// SPDX-License-Identifier: Apache-2.0
// Links whose ends have no room for a request of the manager, or are asked twice.
#include "test/unit/fsw/supervisor/bed.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    bed_open_up();
    bed_place(BED_ARM, STATE_PRE_OPERATIONAL);
    bed_place(BED_HAND, STATE_PRE_OPERATIONAL);
    bed_forget();
}

void tearDown(void)
{
    bed_close();
}

static void expect_no_session(void)
{
    for (unsigned i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        TEST_ASSERT_EQUAL(SESSION_FREE, bed.supervisor.sessions[i].step);
    }
    TEST_ASSERT_EQUAL(0U, bed.supervisor.graph.count);
}

static void a_producer_without_room_is_no_producer(void)
{
    bed_fill(BED_ARM);
    (void)bed_request_link(LINK_ARM_STATE);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 130.5 0000000705")); // Resources.
    TEST_ASSERT_FALSE(bed_has("17 TC"));
    expect_no_session();
}

static void a_consumer_without_room_ends_the_negotiation(void)
{
    bed_fill(BED_HAND);
    (void)bed_request_link(LINK_ARM_STATE);
    bed_run(4U);
    TEST_ASSERT_TRUE(bed_has("16 TC 130.3"));
    TEST_ASSERT_TRUE(bed_has("16 TC 130.7 0001")); // It accepted for nothing.
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), " 0402 11\n"));
    expect_no_session();
}

static void an_end_without_room_is_not_opened(void)
{
    (void)bed_request_link(LINK_ARM_STATE);
    bed_run(5U);
    bed_fill(BED_ARM);
    (void)bed_open_link(LINK_ARM_STATE);
    bed_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), " 0402 10\n"));
    expect_no_session();
    bed.members[BED_ARM].is_deaf = false;
    bed_run(3U);
    bed_fill(BED_HAND);
    (void)bed_open_link(LINK_ARM_STATE);
    bed_run(4U);
    TEST_ASSERT_TRUE(bed_has("16 TC 130.6 0001"));
    TEST_ASSERT_TRUE(bed_has("16 TC 130.7 0001")); // Not alone.
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), " 0402 11\n"));
    expect_no_session();
}

static void a_link_that_is_being_opened_is_neither_closed_nor_opened_again(void)
{
    (void)bed_request_link(LINK_ARM_STATE);
    bed_run(5U);
    bed.members[BED_ARM].ignores_links = true;
    (void)bed_open_link(LINK_ARM_STATE);
    bed_run(2U);
    bed_forget();
    const uint16_t closing = bed_close_link(LINK_ARM_STATE);
    bed_run(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, closing);
    TEST_ASSERT_TRUE(bed_has("G 1.4 #2 0204 1"));
    (void)bed_open_link(LINK_ARM_STATE);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 1.4 #3 0205 8"));
}

static void a_stale_link_is_reported_as_such(void)
{
    bed_link_up(STATE_PRE_OPERATIONAL);
    bed_link_changed(BED_HAND, LINK_ARM_STATE, PUS_LINK_STATE_OPEN, PUS_LINK_STATE_STALE);
    bed_run(1U);
    bed_forget();
    (void)bed_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\1\0\1", 3U);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 130.9 00010001040010000100110002")); // State 4.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_producer_without_room_is_no_producer);
    RUN_TEST(a_consumer_without_room_ends_the_negotiation);
    RUN_TEST(an_end_without_room_is_not_opened);
    RUN_TEST(a_link_that_is_being_opened_is_neither_closed_nor_opened_again);
    RUN_TEST(a_stale_link_is_reported_as_such);
    return UNITY_END();
}
