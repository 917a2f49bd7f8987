// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/resource/pool.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/resource/take_check.h"

#define NO_BLOCK 0xFFFFU

/// Index of the block that starts exactly at `block`, or NO_BLOCK.
static uint16_t index_of(const pool_t* const pool, const void* const block)
{
    // Comparing unrelated pointers with `<` is undefined (C99 6.5.8), so compare addresses as integers. An
    // address below the storage wraps to a huge offset and is refused.
    const uintptr_t offset = (uintptr_t)(const uint8_t*)block - (uintptr_t)pool->storage;
    const uintptr_t words  = offset / sizeof(uint64_t);
    if (((offset % sizeof(uint64_t)) != 0U) || (words >= pool->storage_words)) {
        return NO_BLOCK;
    }
    // A product in place of a division: exact for the start of a block, as 65534 blocks times the rounding
    // error, less than block_words <= 65536, stay below 2^32. All other addresses fail the test.
    const uintptr_t index = (uintptr_t)(((uint64_t)words * pool->words_inverse) >> 32U);
    return ((index * pool->block_words) == words) ? (uint16_t)index : NO_BLOCK;
}

static uint16_t index_of_taken(const pool_t* const pool, const void* const block)
{
    const uint16_t index = index_of(pool, block);
    return ((index != NO_BLOCK) && (pool->slots[index].references > 0U)) ? index : NO_BLOCK;
}

/// Blocks in use at which `percent` is reached, rounded up.
static uint16_t blocks_at(const pool_t* const pool, const uint8_t percent)
{
    return (uint16_t)((((uint32_t)pool->block_count * percent) + 99U) / 100U);
}

static void update_warning(pool_t* const pool)
{
    if (!pool->stats.warning && (pool->stats.taken >= pool->warn_blocks)) {
        pool->stats.warning = true;
        pool->stats.warnings++;
        pool->is_news = true;
    } else if (pool->stats.warning && (pool->stats.taken <= pool->clear_blocks)) {
        pool->stats.warning = false;
    }
}

void pool_init(pool_t* const pool, uint64_t* const storage, pool_slot_t* const slots,
               const pool_setup_t* const setup)
{
    FSW_ASSERT((pool != NULL) && (storage != NULL) && (slots != NULL) && (setup != NULL));
    FSW_ASSERT((setup->block_octets >= 1U) && (setup->block_octets <= POOL_BLOCK_OCTETS_MAX));
    FSW_ASSERT((setup->block_count >= 1U) && (setup->block_count < NO_BLOCK));
    FSW_ASSERT(setup->reserve < setup->block_count);
    // Chain in address order, so that a fresh pool hands out blocks predictably.
    for (uint16_t i = 0U; i < setup->block_count; i++) {
        slots[i].references = 0U;
        slots[i].next_free  = ((i + 1U) < setup->block_count) ? (uint16_t)(i + 1U) : NO_BLOCK;
    }
    *pool               = (pool_t){.storage      = storage,
                                   .slots        = slots,
                                   .block_words  = POOL_BLOCK_WORDS(setup->block_octets),
                                   .block_octets = setup->block_octets,
                                   .block_count  = setup->block_count,
                                   .reserve      = setup->reserve};
    pool->storage_words = pool->block_words * pool->block_count;
    pool->words_inverse = (((1ULL << 32U) - 1U) / pool->block_words) + 1U;
    take_check_mark(storage, pool->block_words * setup->block_count);
    pool_set_thresholds(pool, setup->warn_percent, setup->clear_percent);
}

void pool_set_thresholds(pool_t* const pool, const uint8_t warn_percent, const uint8_t clear_percent)
{
    FSW_ASSERT((pool != NULL) && (warn_percent >= 1U) && (warn_percent <= 100U));
    FSW_ASSERT(clear_percent < warn_percent);
    pool->warn_blocks  = blocks_at(pool, warn_percent);
    pool->clear_blocks = (uint16_t)(((uint32_t)pool->block_count * clear_percent) / 100U);
    update_warning(pool);
}

static status_t take(pool_t* const pool, const uint16_t kept_back, void** const out_block)
{
    FSW_ASSERT((pool != NULL) && (out_block != NULL));
    const uint16_t left = (uint16_t)(pool->block_count - pool->stats.taken);
    if ((left <= kept_back) || take_check_is_refused()) {
        pool->stats.refused++;
        *out_block = NULL;
        return STATUS_EXHAUSTED;
    }
    const uint16_t index = pool->first_free;
    FSW_ASSERT((index < pool->block_count) && (pool->slots[index].references == 0U));
    pool->first_free              = pool->slots[index].next_free;
    pool->slots[index].references = 1U;
    pool->stats.taken++;
    if (pool->stats.taken > pool->stats.peak) {
        pool->stats.peak = pool->stats.taken;
    }
    if (pool->stats.taken >= pool->warn_blocks) {
        update_warning(pool);
    }
    uint64_t* const block = &pool->storage[index * pool->block_words];
    FSW_ASSERT(
        take_check_is_marked(block, pool->block_words)); // Else somebody wrote to it after its release.
    *out_block = block;
    return STATUS_OK;
}

status_t pool_take(pool_t* const pool, void** const out_block)
{
    return take(pool, pool->reserve, out_block);
}

status_t pool_take_reserved(pool_t* const pool, void** const out_block)
{
    return take(pool, 0U, out_block);
}

status_t pool_retain(pool_t* const pool, void* const block)
{
    FSW_ASSERT((pool != NULL) && (block != NULL));
    const uint16_t index = index_of_taken(pool, block);
    if (index == NO_BLOCK) {
        pool->stats.rejected++;
        return STATUS_NOT_OURS;
    }
    if (pool->slots[index].references == UINT16_MAX) {
        pool->stats.rejected++;
        return STATUS_FULL;
    }
    pool->slots[index].references++;
    return STATUS_OK;
}

status_t pool_release(pool_t* const pool, void* const block)
{
    FSW_ASSERT((pool != NULL) && (block != NULL));
    const uint16_t index = index_of_taken(pool, block);
    if (index == NO_BLOCK) {
        pool->stats.rejected++;
        return STATUS_NOT_OURS;
    }
    pool->slots[index].references--;
    if (pool->slots[index].references == 0U) {
        take_check_mark(&pool->storage[index * pool->block_words], pool->block_words);
        pool->slots[index].next_free = pool->first_free;
        pool->first_free             = index;
        pool->stats.taken--;
        if (pool->stats.warning) {
            update_warning(pool);
        }
    }
    return STATUS_OK;
}

bool pool_poll_warning(pool_t* const pool)
{
    FSW_ASSERT(pool != NULL);
    const bool is_news = pool->is_news;
    pool->is_news      = false;
    return is_news;
}

bool pool_owns(const pool_t* const pool, const void* const block)
{
    FSW_ASSERT((pool != NULL) && (block != NULL));
    const uintptr_t offset = (uintptr_t)(const uint8_t*)block - (uintptr_t)pool->storage;
    return offset < (pool->block_words * sizeof(uint64_t) * pool->block_count);
}
