// SPDX-License-Identifier: Apache-2.0
/// Checks whether the pools and their resources are consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_POOL_H
#define TEST_SUPPORT_CONSISTENT_POOL_H

#include "base/pool.h"
#include "base/resource.h"

#include <string.h>

/// True if the free list contains as many blocks as are free, none of them twice, and no held block.
static inline bool pool_list_is_consistent(const pool_t* pool)
{
    const uint16_t free_count = (uint16_t)(pool->block_count - pool->stats.taken);
    static bool is_listed[UINT16_MAX]; // Static, because it is too large for the stack of a board.
    (void)memset(is_listed, 0, pool->block_count);
    uint16_t index = pool->free_index;
    if ((free_count > 0U) && (index < pool->block_count) &&
        (pool->free_block != &pool->storage[pool->slots[index].start])) {
        return false;
    }
    for (uint16_t i = 0U; i < free_count; i++) {
        if ((index >= pool->block_count) || is_listed[index] || (pool->slots[index].references > 0U)) {
            return false;
        }
        is_listed[index] = true;
        index            = pool->slots[index].next;
    }
    return true;
}

/// True if free list, references and counters agree.
static inline bool pool_is_consistent(const pool_t* pool)
{
    uint16_t held = 0U;
    for (uint16_t i = 0U; i < pool->block_count; i++) {
        held = (uint16_t)(held + ((pool->slots[i].references > 0U) ? 1U : 0U));
    }
    return (held == pool->stats.taken) && (pool->stats.taken <= pool->stats.peak) &&
           pool_list_is_consistent(pool);
}

static inline bool resource_is_consistent(const resource_t* resource)
{
    bool is_consistent = true;
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        is_consistent = is_consistent && pool_is_consistent(&resource->pools[i]);
    }
    return is_consistent;
}

/// True if no block is taken; SOFTWARE_DEINIT must leave a pool in this state.
static inline bool resource_is_returned(const resource_t* resource)
{
    uint32_t taken = 0U;
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        taken += resource->pools[i].stats.taken;
    }
    return taken == 0U;
}

#endif // TEST_SUPPORT_CONSISTENT_POOL_H
