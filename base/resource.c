// SPDX-License-Identifier: Apache-2.0
#include "base/resource.h"

#include "base/assertion.h"

static bool are_sizes_valid(const resource_size_t* const sizes, const uint16_t size_count)
{
    size_t before = 0U;
    for (uint16_t i = 0U; i < size_count; i++) {
        if ((sizes[i].block_octets <= before) || (sizes[i].block_count == 0U) ||
            (sizes[i].block_count == UINT16_MAX) || (sizes[i].reserve >= sizes[i].block_count)) {
            return false;
        }
        before = sizes[i].block_octets;
    }
    return (size_count >= 1U) && (size_count <= RESOURCE_SIZES_MAX);
}

status_t resource_init(resource_t* const resource, uint64_t* const arena, const size_t arena_words,
                       const resource_size_t* const sizes, const uint16_t size_count)
{
    FSW_ASSERT((resource != NULL) && (arena != NULL) && (sizes != NULL));
    *resource = (resource_t){.pool_count = 0U};
    if (!are_sizes_valid(sizes, size_count)) {
        return STATUS_INVALID;
    }
    size_t used = 0U;
    for (uint16_t i = 0U; i < size_count; i++) {
        const size_t slot_words  = RESOURCE_SLOT_WORDS(sizes[i].block_count);
        const size_t block_words = POOL_BLOCK_WORDS(sizes[i].block_octets);
        if (((arena_words - used) < slot_words) ||
            (((arena_words - used - slot_words) / sizes[i].block_count) < block_words)) {
            resource->pool_count = 0U;
            return STATUS_TOO_LARGE;
        }
        const pool_setup_t setup = {.block_octets  = sizes[i].block_octets,
                                    .block_count   = sizes[i].block_count,
                                    .reserve       = sizes[i].reserve,
                                    .warn_percent  = POOL_WARN_PERCENT,
                                    .clear_percent = POOL_CLEAR_PERCENT};
        pool_slot_t* const slots = (pool_slot_t*)(void*)&arena[used];
        uint64_t* const storage  = &arena[used + slot_words];
        pool_init(&resource->pools[i], storage, slots, &setup);
        used += slot_words + (block_words * sizes[i].block_count);
        resource->pool_count++;
    }
    return STATUS_OK;
}

/// Returns the pool of the smallest blocks that have `octets`; null if there is none.
static pool_t* fitting(resource_t* const resource, const size_t octets)
{
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        if (octets <= resource->pools[i].block_octets) {
            return &resource->pools[i];
        }
    }
    resource->oversized++;
    return NULL;
}

status_t resource_take_reserved(resource_t* const resource, const size_t octets, void** const out_block)
{
    FSW_ASSERT((resource != NULL) && (out_block != NULL));
    pool_t* const pool = fitting(resource, octets);
    *out_block         = (pool == NULL) ? NULL : pool_take_reserved(pool);
    if (*out_block != NULL) {
        return STATUS_OK;
    }
    return (pool == NULL) ? STATUS_TOO_LARGE : STATUS_EXHAUSTED;
}

/// Returns the pool whose storage contains the block. If no pool contains it, returns the first pool, which
/// counts the error.
static pool_t* home_of(resource_t* const resource, const void* const block)
{
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        if (pool_owns(&resource->pools[i], block)) {
            return &resource->pools[i];
        }
    }
    return &resource->pools[0];
}

status_t resource_retain(resource_t* const resource, void* const block)
{
    FSW_ASSERT((resource != NULL) && (resource->pool_count > 0U) && (block != NULL));
    return pool_retain(home_of(resource, block), block);
}

status_t resource_release(resource_t* const resource, void* const block)
{
    FSW_ASSERT((resource != NULL) && (resource->pool_count > 0U) && (block != NULL));
    return pool_release(home_of(resource, block), block);
}
