// SPDX-License-Identifier: Apache-2.0
// Attempts to open the object of a link, its loss, and the quota. The test decides whether the object can be
// opened.
#include "fsw/framework/dataflow/link.h"

#include "unity.h"

static struct {
    status_t result;
    bool lasts;
    unsigned opened;
    unsigned closed;
} object;

static flow_link_t link;
static quota_t quota;

static status_t open_object(void* const flow)
{
    TEST_ASSERT_EQUAL_PTR(&object, flow);
    object.opened++;
    link.is_pending = link.is_pending || object.lasts;
    return object.result;
}

static void close_object(void* const flow)
{
    TEST_ASSERT_EQUAL_PTR(&object, flow);
    object.closed++;
}

static const flow_link_actions_t actions = {open_object, close_object};

void setUp(void)
{
    object.result = STATUS_OK;
    object.lasts  = false;
    object.opened = 0U;
    object.closed = 0U;
    quota_init(&quota, 1U);
    flow_link_init(&link, &actions, &object, &quota, 10U, 40U);
}

void tearDown(void)
{
}

static void an_object_that_is_lost_is_opened_again_after_the_delay(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 1U));
    TEST_ASSERT_EQUAL_UINT(1U, object.opened);
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    flow_link_lose(&link, STATUS_IO);
    TEST_ASSERT_EQUAL(STATUS_IO, link.failure);
    TEST_ASSERT_EQUAL_UINT(1U, object.closed);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_link_step(&link, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 11U));
    TEST_ASSERT_EQUAL_UINT(2U, object.opened);
}

static void a_failed_attempt_is_closed_and_returns_its_quota(void)
{
    object.result = STATUS_BUSY; // Another program uses the object, so the attempt fails.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_link_step(&link, 0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, link.failure);
    TEST_ASSERT_EQUAL_UINT(1U, object.closed);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota)); // Another link has taken the last unit of the quota.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_link_step(&link, 10U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, link.failure);
    TEST_ASSERT_EQUAL_UINT(1U, object.opened);
    TEST_ASSERT_EQUAL_UINT(1U, object.closed);
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    TEST_ASSERT_EQUAL_UINT32(2U, link.reconnect.failed);
}

static void an_attempt_of_several_steps_takes_its_quota_once(void)
{
    object.lasts  = true;
    object.result = STATUS_BUSY;
    TEST_ASSERT_EQUAL(STATUS_BUSY, flow_link_step(&link, 0U));
    // Each step continues the attempt without a delay.
    TEST_ASSERT_EQUAL(STATUS_BUSY, flow_link_step(&link, 1U));
    TEST_ASSERT_EQUAL_UINT(2U, object.opened);
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    object.result = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 2U));
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
    TEST_ASSERT_FALSE(link.is_pending);
}

static void an_attempt_of_several_steps_can_fail(void)
{
    object.lasts  = true;
    object.result = STATUS_BUSY;
    TEST_ASSERT_EQUAL(STATUS_BUSY, flow_link_step(&link, 0U));
    object.result = STATUS_CLOSED;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_link_step(&link, 1U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, link.failure);
    TEST_ASSERT_EQUAL_UINT(1U, object.closed);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
}

static void closing_ends_an_attempt_of_several_steps_and_makes_the_next_one_due(void)
{
    flow_link_close(&link); // No object is open yet.
    TEST_ASSERT_EQUAL_UINT(0U, object.closed);
    object.lasts  = true;
    object.result = STATUS_BUSY;
    TEST_ASSERT_EQUAL(STATUS_BUSY, flow_link_step(&link, 5U));
    flow_link_close(&link);
    TEST_ASSERT_EQUAL_UINT(1U, object.closed);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    object.lasts  = false;
    object.result = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 5U));
    flow_link_close(&link);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_link_step(&link, 5U));
    TEST_ASSERT_EQUAL_UINT(3U, object.opened);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_object_that_is_lost_is_opened_again_after_the_delay);
    RUN_TEST(a_failed_attempt_is_closed_and_returns_its_quota);
    RUN_TEST(an_attempt_of_several_steps_takes_its_quota_once);
    RUN_TEST(an_attempt_of_several_steps_can_fail);
    RUN_TEST(closing_ends_an_attempt_of_several_steps_and_makes_the_next_one_due);
    return UNITY_END();
}
