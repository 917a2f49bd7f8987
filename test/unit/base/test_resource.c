// SPDX-License-Identifier: Apache-2.0
// An arena that is divided into pools of blocks of different sizes.
#include "base/resource.h"
#include "test/support/consistent_pool.h"

#include "unity.h"

#include <string.h>

static uint64_t
    arena[RESOURCE_ARENA_WORDS(32U, 8U) + RESOURCE_ARENA_WORDS(256U, 4U) + RESOURCE_ARENA_WORDS(4096U, 2U)];
#define ARENA_WORDS (sizeof arena / sizeof arena[0])

// Octets of a block, number of blocks, blocks reserved.
static const resource_size_t sizes[] = {{32U, 8U, 1U}, {256U, 4U, 0U}, {4096U, 2U, 1U}};
static resource_t memory;

void setUp(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, resource_init(&memory, arena, ARENA_WORDS, sizes, 3U));
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(resource_is_consistent(&memory));
}

static void* take(const size_t octets)
{
    void* block = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, resource_take_reserved(&memory, octets, &block));
    memset(block, 0x5A, octets);
    return block;
}

static void the_smallest_block_that_fits_is_given(void)
{
    (void)take(0U);
    (void)take(32U);
    TEST_ASSERT_EQUAL_UINT16(2U, memory.pools[0].stats.taken);
    (void)take(33U);
    (void)take(256U);
    TEST_ASSERT_EQUAL_UINT16(2U, memory.pools[1].stats.taken);
    (void)take(4096U);
    TEST_ASSERT_EQUAL_UINT16(1U, memory.pools[2].stats.taken);
    void* block = &memory;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, resource_take_reserved(&memory, 4097U, &block));
    TEST_ASSERT_NULL(block);
    TEST_ASSERT_EQUAL_UINT32(1U, memory.oversized);
}

static void many_small_blocks_do_not_use_up_the_large_ones(void)
{
    void* block = NULL;
    for (unsigned i = 0U; i < 8U; i++) {
        (void)take(1U);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, resource_take_reserved(&memory, 1U, &block));
    TEST_ASSERT_EQUAL_UINT16(0U, memory.pools[1].stats.taken);
    (void)take(200U);
}

static void a_block_returns_to_its_pool(void)
{
    uint64_t stranger = 0U;
    void* const small = take(5U);
    void* const large = take(3000U);
    TEST_ASSERT_FALSE(resource_is_returned(&memory));
    TEST_ASSERT_EQUAL(STATUS_OK, resource_retain(&memory, large));
    TEST_ASSERT_EQUAL(STATUS_OK, resource_release(&memory, large));
    TEST_ASSERT_EQUAL(STATUS_OK, resource_release(&memory, large));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, resource_release(&memory, large));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, resource_release(&memory, &stranger));
    TEST_ASSERT_EQUAL(STATUS_OK, resource_release(&memory, small));
    TEST_ASSERT_TRUE(resource_is_returned(&memory));
}

static void an_arena_of_any_size_that_is_too_small_is_refused(void)
{
    for (size_t words = 0U; words < ARENA_WORDS; words++) {
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, resource_init(&memory, arena, words, sizes, 3U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, resource_init(&memory, arena, ARENA_WORDS, sizes, 3U));
}

static void impossible_sizes_are_refused(void)
{
    const resource_size_t not_rising[]   = {{64U, 2U, 0U}, {64U, 2U, 0U}};
    const resource_size_t no_blocks[]    = {{64U, 0U, 0U}};
    const resource_size_t all_reserved[] = {{64U, 2U, 2U}};
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, not_rising, 2U));
    const resource_size_t empty[]    = {{0U, 2U, 0U}};
    const resource_size_t smallest[] = {{1U, 2U, 0U}};
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, empty, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, resource_init(&memory, arena, ARENA_WORDS, smallest, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, no_blocks, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, all_reserved, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, sizes, 0U));
    const resource_size_t too_many_blocks[] = {{64U, UINT16_MAX, 0U}};
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, too_many_blocks, 1U));
    const resource_size_t too_many_sizes[] = {{8U, 1U, 0U},  {16U, 1U, 0U}, {24U, 1U, 0U}, {32U, 1U, 0U},
                                              {40U, 1U, 0U}, {48U, 1U, 0U}, {56U, 1U, 0U}};
    TEST_ASSERT_EQUAL(STATUS_INVALID, resource_init(&memory, arena, ARENA_WORDS, too_many_sizes, 7U));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      resource_init(&memory, arena, ARENA_WORDS, too_many_sizes, RESOURCE_SIZES_MAX));
}

/// Even with as many pools as possible, octets after the last pool are not taken for another pool.
static void a_block_larger_than_those_of_the_last_pool_is_refused(void)
{
    static const resource_size_t all[RESOURCE_SIZES_MAX] = {{8U, 1U, 0U},  {16U, 1U, 0U}, {24U, 1U, 0U},
                                                            {32U, 1U, 0U}, {40U, 1U, 0U}, {48U, 1U, 0U}};
    static struct {
        resource_t full;
        uint8_t after[sizeof(pool_t)];
    } storage;
    static uint64_t own_arena[64];
    void* block = &storage;
    (void)memset(&storage, 0xFF, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_OK, resource_init(&storage.full, own_arena, 64U, all, RESOURCE_SIZES_MAX));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, resource_take_reserved(&storage.full, 49U, &block));
    TEST_ASSERT_NULL(block);
    TEST_ASSERT_EQUAL_UINT32(1U, storage.full.oversized);
}

static void damage_in_any_pool_is_found(void)
{
    for (size_t i = 0U; i < 3U; i++) {
        const pool_t whole          = memory.pools[i];
        memory.pools[i].stats.taken = 1U;
        TEST_ASSERT_FALSE(resource_is_consistent(&memory));
        memory.pools[i] = whole;
        TEST_ASSERT_TRUE(resource_is_consistent(&memory));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_smallest_block_that_fits_is_given);
    RUN_TEST(many_small_blocks_do_not_use_up_the_large_ones);
    RUN_TEST(a_block_returns_to_its_pool);
    RUN_TEST(an_arena_of_any_size_that_is_too_small_is_refused);
    RUN_TEST(impossible_sizes_are_refused);
    RUN_TEST(a_block_larger_than_those_of_the_last_pool_is_refused);
    RUN_TEST(damage_in_any_pool_is_found);
    return UNITY_END();
}
