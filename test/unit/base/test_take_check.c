// SPDX-License-Identifier: Apache-2.0
// Tests of the checks in builds with SANITIZE=1; other builds have no such checks.
#include "base/pool.h"
#include "base/quota.h"
#include "base/take_check.h"

#include "test/support/assertion.h"
#include "test/support/consistent_pool.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

#ifdef RESOURCE_CHECKS

#define OCTETS 24U
#define BLOCKS 4U

static pool_t pool;
static uint64_t storage[POOL_STORAGE_WORDS(OCTETS, BLOCKS)];
static pool_slot_t slots[BLOCKS];

static void make_pool(void)
{
    const pool_setup_t setup = {
        .block_octets = OCTETS, .block_count = BLOCKS, .warn_percent = 75U, .clear_percent = 65U};
    pool_init(&pool, storage, slots, &setup);
    take_check_refuse(0U);
}

static void write_after_release(void)
{
    make_pool();
    uint8_t* const octets = pool_take(&pool);
    TEST_ASSERT_NOT_NULL(octets);
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, octets));
    octets[OCTETS - 1U] = 0U;
    TEST_ASSERT_NOT_NULL(pool_take(&pool));
}

static void a_write_after_the_release_is_found(void)
{
    TEST_ASSERT_TRUE(assertion_fails(write_after_release));
}

static void blocks_in_use_may_be_written(void)
{
    make_pool();
    for (unsigned i = 0U; i < (3U * BLOCKS); i++) {
        uint8_t* const block = pool_take(&pool);
        TEST_ASSERT_NOT_NULL(block);
        for (unsigned k = 0U; k < OCTETS; k++) {
            block[k] = (uint8_t)k;
        }
        TEST_ASSERT_EQUAL(STATUS_OK, pool_retain(&pool, block));
        TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
        TEST_ASSERT_EQUAL_HEX8(5U, block[5]); // One reference remains.
        TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    }
}

static void the_take_with_the_given_number_is_refused_and_counted(void)
{
    quota_t quota;
    make_pool();
    quota_init(&quota, 4U);
    for (uint32_t number = 1U; number <= 4U; number++) {
        take_check_refuse(number);
        void* const block     = pool_take(&pool);
        const status_t second = quota_take(&quota);
        const status_t third  = quota_take(&quota);
        TEST_ASSERT_EQUAL(number == 1U, block == NULL);
        TEST_ASSERT_EQUAL((number == 2U) ? STATUS_EXHAUSTED : STATUS_OK, second);
        TEST_ASSERT_EQUAL((number == 3U) ? STATUS_EXHAUSTED : STATUS_OK, third);
        TEST_ASSERT_EQUAL_UINT32(3U, take_check_count());
        while (quota.stats.used > 0U) {
            quota_give(&quota);
        }
        if (block != NULL) {
            TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(1U, pool.stats.refused);
    TEST_ASSERT_EQUAL_UINT32(2U, quota.stats.refused);
    TEST_ASSERT_TRUE(pool_is_consistent(&pool));
}

static void the_first_takes_of_each_object_have_numbers(void)
{
    quota_t many;
    quota_t few;
    quota_init(&many, 20U);
    quota_init(&few, 20U);
    take_check_refuse(9U);
    for (unsigned i = 0U; i < 20U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&many));
    }
    TEST_ASSERT_EQUAL_UINT32(8U, take_check_count());
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, quota_take(&few)); // The ninth numbered take is refused.
    TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&few));
    TEST_ASSERT_EQUAL_UINT32(10U, take_check_count());
}

static void takes_of_more_objects_than_the_table_holds_have_numbers(void)
{
    static const uint8_t objects[200];
    take_check_refuse(0U);
    for (unsigned i = 0U; i < sizeof objects; i++) {
        TEST_ASSERT_FALSE(take_check_is_refused(&objects[i]));
    }
    TEST_ASSERT_EQUAL_UINT32(sizeof objects, take_check_count());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_write_after_the_release_is_found);
    RUN_TEST(blocks_in_use_may_be_written);
    RUN_TEST(the_take_with_the_given_number_is_refused_and_counted);
    RUN_TEST(the_first_takes_of_each_object_have_numbers);
    RUN_TEST(takes_of_more_objects_than_the_table_holds_have_numbers);
    return UNITY_END();
}

#else

static void builds_for_flight_have_no_checks(void)
{
    TEST_ASSERT_FALSE(take_check_is_refused(NULL));
    TEST_ASSERT_TRUE(take_check_is_marked(NULL, 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(builds_for_flight_have_no_checks);
    return UNITY_END();
}

#endif
