// SPDX-License-Identifier: Apache-2.0
#include "base/pool.h"

#include "base/assertion.h"
#include "base/take_check.h"

#define INVERSE_BITS 32U

/// True if a taken block starts exactly at `block`; *out_index is its index.
static inline bool is_taken(const pool_t* const pool, const void* const block, uint16_t* const out_index)
{
    // Comparing unrelated pointers with `<` is undefined (C99 6.5.8), so compare addresses as integers. An
    // address below the storage wraps to a huge offset and is refused.
    const uint64_t offset = (uintptr_t)(const uint8_t*)block - (uintptr_t)pool->storage;
    // A multiplication replaces the slower division. It is exact for the start of a block: the rounding of
    // the inverse adds less than the offset to the product, and the offset is less than 2^32. For any other
    // offset the start of the resulting block differs from the offset.
    const uint64_t index = (offset * pool->inverse) >> INVERSE_BITS;
    *out_index           = (uint16_t)index;
    return (index < pool->block_count) && (pool->slots[index].start == offset) &&
           (pool->slots[index].references > 0U);
}

/// Returns the number of taken blocks at which `percent` is reached, rounded up.
static uint16_t blocks_at(const pool_t* const pool, const uint8_t percent)
{
    return (uint16_t)((((uint32_t)pool->block_count * percent) + 99U) / 100U);
}

static void update_warning(pool_t* const pool, const uint16_t taken)
{
    if (!pool->stats.warning && (taken >= pool->warn_blocks)) {
        pool->stats.warning = true;
        pool->stats.warnings++;
        pool->is_unpolled = true;
    } else if (pool->stats.warning && (taken <= pool->clear_blocks)) {
        pool->stats.warning = false;
    }
}

static uint16_t smaller(const uint16_t a, const uint16_t b)
{
    return (a < b) ? a : b;
}

static void update_quiet(pool_t* const pool)
{
    const uint16_t below_warning = (uint16_t)(pool->warn_blocks - 1U);
    pool->quiet =
        TAKES_ARE_CHECKED ? 0U : smaller(smaller(pool->stats.peak, pool->unreserved), below_warning);
}

void pool_init(pool_t* const pool, uint64_t* const storage, pool_slot_t* const slots,
               const pool_setup_t* const setup)
{
    FSW_ASSERT((pool != NULL) && (storage != NULL) && (slots != NULL) && (setup != NULL));
    FSW_ASSERT((setup->block_octets >= 1U) && (setup->block_octets <= POOL_BLOCK_OCTETS_MAX));
    FSW_ASSERT((setup->block_count >= 1U) && (setup->block_count < UINT16_MAX));
    FSW_ASSERT(setup->reserve < setup->block_count);
    // The list is in the order of addresses, so that a new pool gives its blocks in a defined order.
    const uint32_t words = (uint32_t)POOL_BLOCK_WORDS(setup->block_octets);
    for (uint16_t i = 0U; i < setup->block_count; i++) {
        const uint16_t next = (uint16_t)((i + 1U) % setup->block_count);
        slots[i] =
            (pool_slot_t){.start = i * words * (uint32_t)sizeof(uint64_t), .next = next, .references = 0U};
    }
    *pool = (pool_t){.storage      = (uint8_t*)storage,
                     .slots        = slots,
                     .block_words  = words,
                     .block_octets = setup->block_octets,
                     .inverse      = (((1ULL << INVERSE_BITS) - 1U) / (words * sizeof(uint64_t))) + 1U,
                     .free_block   = storage,
                     .block_count  = setup->block_count,
                     .unreserved   = (uint16_t)(setup->block_count - setup->reserve)};
    take_check_mark(storage, pool->block_words * setup->block_count);
    pool_set_thresholds(pool, setup->warn_percent, setup->clear_percent);
}

void pool_set_thresholds(pool_t* const pool, const uint8_t warn_percent, const uint8_t clear_percent)
{
    FSW_ASSERT((pool != NULL) && (warn_percent >= 1U) && (warn_percent <= 100U));
    FSW_ASSERT(clear_percent < warn_percent);
    pool->warn_blocks  = blocks_at(pool, warn_percent);
    pool->clear_blocks = (uint16_t)(((uint32_t)pool->block_count * clear_percent) / 100U);
    update_warning(pool, pool->stats.taken);
    update_quiet(pool);
}

/// Take the first free block. The caller has checked that there is one.
static inline void* take(pool_t* const pool)
{
    void* const block       = pool->free_block;
    pool_slot_t* const slot = &pool->slots[pool->free_index];
    FSW_ASSERT(slot->references == 0U);
    FSW_ASSERT(take_check_is_marked(block, pool->block_words)); // No write to the block after its release.
    pool->free_index = slot->next;
    pool->free_block = &pool->storage[pool->slots[slot->next].start];
    slot->references = 1U;
    pool->stats.taken++;
    return block;
}

/// Take a block in the cases that pool_take does not handle: refusal, new peak, warning.
static __attribute__((noinline)) void* take_noted(pool_t* const pool, const uint16_t limit)
{
    const uint16_t taken = pool->stats.taken;
    if ((taken >= limit) || take_check_is_refused(pool)) {
        pool->stats.refused++;
        return NULL;
    }
    if (taken >= pool->stats.peak) {
        pool->stats.peak = (uint16_t)(taken + 1U);
    }
    update_warning(pool, (uint16_t)(taken + 1U));
    update_quiet(pool);
    return take(pool);
}

void* pool_take(pool_t* const pool)
{
    FSW_ASSERT(pool != NULL);
    return (pool->stats.taken < pool->quiet) ? take(pool) : take_noted(pool, pool->unreserved);
}

void* pool_take_reserved(pool_t* const pool)
{
    FSW_ASSERT(pool != NULL);
    return take_noted(pool, pool->block_count);
}

status_t pool_retain(pool_t* const pool, void* const block)
{
    FSW_ASSERT(pool != NULL);
    uint16_t index = 0U;
    if (!is_taken(pool, block, &index)) {
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
    FSW_ASSERT(pool != NULL);
    uint16_t index = 0U;
    if (!is_taken(pool, block, &index)) {
        pool->stats.rejected++;
        return STATUS_NOT_OURS;
    }
    pool_slot_t* const slot = &pool->slots[index];
    if (slot->references == 1U) {
        slot->next       = pool->free_index;
        pool->free_index = index;
        pool->free_block = block;
        pool->stats.taken--;
        take_check_mark(block, pool->block_words);
        if (pool->stats.warning) {
            update_warning(pool, pool->stats.taken);
        }
    }
    slot->references--;
    return STATUS_OK;
}

bool pool_poll_warning(pool_t* const pool)
{
    FSW_ASSERT(pool != NULL);
    const bool is_unpolled = pool->is_unpolled;
    pool->is_unpolled      = false;
    return is_unpolled;
}

bool pool_owns(const pool_t* const pool, const void* const block)
{
    FSW_ASSERT((pool != NULL) && (block != NULL));
    const uintptr_t offset = (uintptr_t)(const uint8_t*)block - (uintptr_t)pool->storage;
    return offset < (pool->block_words * sizeof(uint64_t) * pool->block_count);
}
