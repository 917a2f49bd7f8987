// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/hand_over.h"

#include "osal/include/osal/process.h"
#include "osal/include/osal/shm.h"
#include "unity.h"

#include <stdio.h>

static char name[64];
static osal_hand_over_t device;
static osal_hand_over_t flight;

void setUp(void)
{
    (void)snprintf(name, sizeof name, "/test-hand-over-%d", (int)osal_process_own_id());
    const status_t status = osal_hand_over_create(&device, name);
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has no named memory");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_hand_over_open(&flight, name));
}

void tearDown(void)
{
    osal_hand_over_close(&flight);
    osal_hand_over_close(&device);
    (void)osal_shm_remove(name);
}

static void each_end_counts_what_the_other_has_announced(void)
{
    osal_hand_over_announce(&device, 5U);
    osal_hand_over_announce(&flight, 2U);
    TEST_ASSERT_EQUAL_UINT32(5U, osal_hand_over_due(&flight));
    TEST_ASSERT_EQUAL_UINT32(2U, osal_hand_over_due(&device));
    osal_hand_over_take(&flight, 3U);
    TEST_ASSERT_EQUAL_UINT32(2U, osal_hand_over_due(&flight));
    // More octets than were announced: the rest is from an earlier connection.
    osal_hand_over_take(&flight, 9U);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_due(&flight));
    TEST_ASSERT_EQUAL_UINT32(2U, osal_hand_over_due(&device));
}

static void a_connection_begins_with_nothing_on_the_way(void)
{
    osal_hand_over_announce(&device, 5U);
    osal_hand_over_announce(&flight, 2U);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_connection(&device));
    TEST_ASSERT_FALSE(osal_hand_over_is_connected(&device));
    osal_hand_over_begin(&flight);
    TEST_ASSERT_TRUE(osal_hand_over_is_connected(&device));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_due(&flight));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_due(&device));
    TEST_ASSERT_EQUAL_UINT32(1U, osal_hand_over_connection(&device));
    osal_hand_over_close(&flight);
    TEST_ASSERT_FALSE(osal_hand_over_is_connected(&device));
}

static void octets_that_are_given_up_are_counted(void)
{
    osal_hand_over_give_up(&flight);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_lost(&flight));
    osal_hand_over_announce(&device, 5U);
    osal_hand_over_give_up(&flight);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_due(&flight));
    TEST_ASSERT_EQUAL_UINT32(5U, osal_hand_over_lost(&device));
}

static void an_absent_device_cannot_be_opened(void)
{
    osal_hand_over_t other;
    TEST_ASSERT_TRUE(osal_hand_over_is_present(&flight));
    osal_hand_over_set_present(&device, false);
    TEST_ASSERT_FALSE(osal_hand_over_is_present(&flight));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_hand_over_open(&other, name));
    TEST_ASSERT_FALSE(osal_hand_over_is_open(&other));
    osal_hand_over_set_present(&device, true);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_hand_over_open(&other, name));
    TEST_ASSERT_TRUE(osal_hand_over_is_open(&other));
    osal_hand_over_close(&other);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_hand_over_open(&other, "/test-hand-over-none"));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_hand_over_create(&other, name));
}

static void a_closed_hand_over_counts_nothing(void)
{
    osal_hand_over_t closed = OSAL_HAND_OVER_CLOSED;
    osal_hand_over_begin(&closed);
    osal_hand_over_announce(&closed, 3U);
    osal_hand_over_take(&closed, 3U);
    osal_hand_over_give_up(&closed);
    osal_hand_over_set_present(&closed, false);
    TEST_ASSERT_TRUE(osal_hand_over_is_present(&closed));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_due(&closed));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_lost(&closed));
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_connection(&closed));
    TEST_ASSERT_FALSE(osal_hand_over_is_connected(&closed));
    osal_hand_over_close(&closed);
}

static void shared_memory_of_another_kind_cannot_be_opened(void)
{
    osal_shm_t shm;
    osal_hand_over_t other;
    static const char* const strange = "/test-hand-over-strange";
    (void)osal_shm_remove(strange);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, strange, 4096U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_hand_over_open(&other, strange));
    osal_shm_close(&shm);
    (void)osal_shm_remove(strange);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_end_counts_what_the_other_has_announced);
    RUN_TEST(a_connection_begins_with_nothing_on_the_way);
    RUN_TEST(octets_that_are_given_up_are_counted);
    RUN_TEST(an_absent_device_cannot_be_opened);
    RUN_TEST(a_closed_hand_over_counts_nothing);
    RUN_TEST(shared_memory_of_another_kind_cannot_be_opened);
    return UNITY_END();
}
