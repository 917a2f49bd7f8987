// SPDX-License-Identifier: Apache-2.0
// Pools of blocks: references, reserve, warning thresholds, and the self-test.
#include "base/pool.h"
#include "test/support/assertion.h"
#include "test/support/consistent_pool.h"

#include "unity.h"

#include <string.h>

#define BLOCKS 20U
#define OCTETS 30U

static uint64_t storage[POOL_STORAGE_WORDS(OCTETS, BLOCKS)];
static pool_slot_t slots[BLOCKS];
static pool_t pool;

static void make(const uint16_t reserve)
{
    pool_init(&pool, storage, slots,
              &(pool_setup_t){.block_octets  = OCTETS,
                              .block_count   = BLOCKS,
                              .reserve       = reserve,
                              .warn_percent  = POOL_WARN_PERCENT,
                              .clear_percent = POOL_CLEAR_PERCENT});
}

void setUp(void)
{
    make(0U);
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(pool_is_consistent(&pool));
}

static void* take(void)
{
    void* const block = pool_take(&pool);
    TEST_ASSERT_NOT_NULL(block);
    return block;
}

static void a_pool_gives_every_block_once_then_refuses(void)
{
    void* blocks[BLOCKS];
    for (unsigned i = 0U; i < BLOCKS; i++) {
        blocks[i] = take();
        TEST_ASSERT_EQUAL_UINT64(0U, (uintptr_t)blocks[i] % sizeof(uint64_t));
        for (unsigned j = 0U; j < i; j++) {
            TEST_ASSERT_NOT_EQUAL(blocks[j], blocks[i]);
        }
        memset(blocks[i], 0xA5, OCTETS);
    }
    TEST_ASSERT_NULL(pool_take(&pool));
    TEST_ASSERT_EQUAL_UINT32(1U, pool.stats.refused);
    TEST_ASSERT_EQUAL_UINT16(BLOCKS, pool.stats.peak);
    for (unsigned i = 0U; i < BLOCKS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, blocks[i]));
    }
    TEST_ASSERT_EQUAL_UINT16(0U, pool.stats.taken);
    TEST_ASSERT_EQUAL_UINT16(BLOCKS, pool.stats.peak);
}

static void a_block_is_held_until_its_last_reference_is_released(void)
{
    void* const block = take();
    TEST_ASSERT_EQUAL(STATUS_OK, pool_retain(&pool, block));
    TEST_ASSERT_EQUAL(STATUS_OK, pool_retain(&pool, block));
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    TEST_ASSERT_EQUAL_UINT16(1U, pool.stats.taken);
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    TEST_ASSERT_EQUAL_UINT16(0U, pool.stats.taken);
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, block));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_retain(&pool, block));
    TEST_ASSERT_EQUAL_UINT32(2U, pool.stats.rejected);
}

static void references_are_counted_up_to_their_limit(void)
{
    void* const block = take();
    for (unsigned i = 1U; i < UINT16_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pool_retain(&pool, block));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, pool_retain(&pool, block));
    TEST_ASSERT_EQUAL_UINT32(1U, pool.stats.rejected);
    for (unsigned i = 0U; i < UINT16_MAX; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    }
    TEST_ASSERT_EQUAL_UINT16(0U, pool.stats.taken);
}

static void pointers_that_are_not_blocks_of_the_pool_are_refused(void)
{
    uint64_t stranger   = 0U;
    uint8_t* const mine = take();
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, &stranger));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, mine + 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, mine + sizeof(uint64_t)));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, (uint8_t*)storage + sizeof storage));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, &slots[0]));
    TEST_ASSERT_EQUAL_UINT32(5U, pool.stats.rejected);
    TEST_ASSERT_EQUAL_UINT16(1U, pool.stats.taken);
    TEST_ASSERT_TRUE(pool_owns(&pool, mine));
    TEST_ASSERT_TRUE(pool_owns(&pool, mine + 1U));
    TEST_ASSERT_FALSE(pool_owns(&pool, (uint8_t*)storage + sizeof storage));
    TEST_ASSERT_FALSE(pool_owns(&pool, &stranger));
}

/// The index of a block is computed by a multiplication, whose rounding must be correct up to the last of
/// very many blocks.
static void each_of_very_many_blocks_is_found(void)
{
    enum {
        MANY  = 65534,
        WORDS = 3
    };
    static uint64_t many_words[POOL_STORAGE_WORDS(8U * WORDS, MANY)];
    static pool_slot_t many_slots[MANY];
    pool_init(&pool, many_words, many_slots, &(pool_setup_t){8U * WORDS, MANY, 0U, 75U, 65U});
    for (unsigned i = 0U; i < MANY; i++) {
        (void)take();
    }
    for (unsigned i = 0U; i < MANY; i++) {
        TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, &many_words[(WORDS * i) + 1U]));
        TEST_ASSERT_EQUAL(STATUS_NOT_OURS, pool_release(&pool, &many_words[(WORDS * i) + 2U]));
        TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, &many_words[WORDS * i]));
    }
}

static void the_reserve_is_kept_for_commanding(void)
{
    make(2U);
    for (unsigned i = 0U; i < (BLOCKS - 2U); i++) {
        (void)take();
    }
    TEST_ASSERT_NULL(pool_take(&pool));
    TEST_ASSERT_NOT_NULL(pool_take_reserved(&pool));
    TEST_ASSERT_NULL(pool_take(&pool));
    TEST_ASSERT_NOT_NULL(pool_take_reserved(&pool));
    TEST_ASSERT_NULL(pool_take_reserved(&pool));
    TEST_ASSERT_EQUAL_UINT32(3U, pool.stats.refused);
}

static void a_pool_warns_at_75_percent_and_clears_the_warning_at_65(void)
{
    void* blocks[BLOCKS];
    for (unsigned i = 0U; i < 14U; i++) {
        blocks[i] = take();
    }
    TEST_ASSERT_FALSE(pool.stats.warning);
    TEST_ASSERT_FALSE(pool_poll_warning(&pool));
    blocks[14] = take(); // 15 of 20 blocks are taken.
    TEST_ASSERT_TRUE(pool.stats.warning);
    TEST_ASSERT_TRUE(pool_poll_warning(&pool));
    TEST_ASSERT_FALSE(pool_poll_warning(&pool));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      pool_release(&pool, blocks[14])); // 14 of 20 blocks are taken: within the hysteresis.
    TEST_ASSERT_TRUE(pool.stats.warning);
    blocks[14] = take();
    TEST_ASSERT_FALSE(pool_poll_warning(&pool));
    TEST_ASSERT_EQUAL_UINT32(1U, pool.stats.warnings);
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, blocks[14]));
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, blocks[13])); // 13 blocks are 65 %.
    TEST_ASSERT_FALSE(pool.stats.warning);
    blocks[13] = take();
    blocks[14] = take();
    TEST_ASSERT_TRUE(pool_poll_warning(&pool));
    TEST_ASSERT_EQUAL_UINT32(2U, pool.stats.warnings);
}

static void thresholds_may_be_set_when_a_descriptor_is_applied_later(void)
{
    for (unsigned i = 0U; i < 10U; i++) {
        (void)take();
    }
    pool_set_thresholds(&pool, 50U, 40U);
    TEST_ASSERT_TRUE(pool_poll_warning(&pool));
    pool_set_thresholds(&pool, 100U, 99U);
    TEST_ASSERT_FALSE(pool.stats.warning);
}

/// In the smallest pool one block is 100 %: taking it raises the warning, and releasing it clears the
/// warning.
static void a_pool_of_one_block_warns_when_the_block_is_taken(void)
{
    pool_init(&pool, storage, slots, &(pool_setup_t){1U, 1U, 0U, 75U, 65U});
    void* const block = take();
    TEST_ASSERT_TRUE(pool.stats.warning);
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, block));
    TEST_ASSERT_FALSE(pool.stats.warning);
}

static uint32_t next_random(uint32_t* const state)
{
    *state ^= *state << 13U;
    *state ^= *state >> 17U;
    *state ^= *state << 5U;
    return *state;
}

/// Compare with a model that counts how often each block is held.
static void a_pool_agrees_with_a_model_over_many_random_steps(void)
{
    make(3U);
    void* held[BLOCKS]          = {0};
    unsigned references[BLOCKS] = {0};
    unsigned taken              = 0U;
    uint32_t random             = 0x12345678U;
    for (unsigned step = 0U; step < 200000U; step++) {
        const unsigned index   = next_random(&random) % BLOCKS;
        const unsigned action  = next_random(&random) % 4U;
        const bool is_reserved = (action == 3U);
        if ((references[index] == 0U) && ((action == 0U) || is_reserved)) {
            const unsigned limit = BLOCKS - (is_reserved ? 0U : 3U);
            held[index]          = is_reserved ? pool_take_reserved(&pool) : pool_take(&pool);
            TEST_ASSERT_EQUAL(taken < limit, held[index] != NULL);
            references[index] += (held[index] != NULL) ? 1U : 0U;
            taken += (held[index] != NULL) ? 1U : 0U;
        } else if ((references[index] > 0U) && (action == 1U)) {
            TEST_ASSERT_EQUAL(STATUS_OK, pool_retain(&pool, held[index]));
            references[index]++;
        } else if ((references[index] > 0U) && (action == 2U)) {
            TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, held[index]));
            references[index]--;
            taken -= (references[index] == 0U) ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL_UINT16(taken, pool.stats.taken);
        if ((step % 100U) == 0U) {
            TEST_ASSERT_TRUE(pool_is_consistent(&pool));
        }
    }
}

static void the_self_test_finds_a_damaged_list(void)
{
    void* const first = take();
    (void)take();
    TEST_ASSERT_EQUAL(STATUS_OK, pool_release(&pool, first));
    const pool_slot_t kept = slots[0];
    slots[0].next          = 0U; // The free list is a loop.
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    slots[0].next = BLOCKS; // An index beyond the last block.
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    slots[0]            = kept;
    slots[7].references = 1U; // A free block that has a reference.
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    slots[7].references = 0U;
    const pool_t whole  = pool;
    pool.free_block     = storage + 1; // The pointer and the index refer to different blocks.
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    pool = whole;
    pool.stats.taken++;
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    pool            = whole;
    pool.stats.peak = 0U;
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    pool                  = whole;
    const pool_slot_t cut = slots[BLOCKS - 2U];
    slots[BLOCKS - 2U]    = slots[0]; // The last block is missing in the list.
    TEST_ASSERT_FALSE(pool_is_consistent(&pool));
    slots[BLOCKS - 2U] = cut;
}

static void with_clear_at_warn(void)
{
    pool_set_thresholds(&pool, 50U, 50U);
}

static void with_no_blocks(void)
{
    pool_init(&pool, storage, slots, &(pool_setup_t){8U, 0U, 0U, 75U, 65U});
}

static void with_all_blocks_reserved(void)
{
    pool_init(&pool, storage, slots, &(pool_setup_t){8U, 4U, 4U, 75U, 65U});
}

static void coding_errors_are_assertions(void)
{
    TEST_ASSERT_TRUE(assertion_fails(with_clear_at_warn));
    TEST_ASSERT_TRUE(assertion_fails(with_no_blocks));
    TEST_ASSERT_TRUE(assertion_fails(with_all_blocks_reserved));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_pool_gives_every_block_once_then_refuses);
    RUN_TEST(a_block_is_held_until_its_last_reference_is_released);
    RUN_TEST(references_are_counted_up_to_their_limit);
    RUN_TEST(pointers_that_are_not_blocks_of_the_pool_are_refused);
    RUN_TEST(each_of_very_many_blocks_is_found);
    RUN_TEST(the_reserve_is_kept_for_commanding);
    RUN_TEST(a_pool_warns_at_75_percent_and_clears_the_warning_at_65);
    RUN_TEST(thresholds_may_be_set_when_a_descriptor_is_applied_later);
    RUN_TEST(a_pool_of_one_block_warns_when_the_block_is_taken);
    RUN_TEST(a_pool_agrees_with_a_model_over_many_random_steps);
    RUN_TEST(the_self_test_finds_a_damaged_list);
    RUN_TEST(coding_errors_are_assertions);
    return UNITY_END();
}
