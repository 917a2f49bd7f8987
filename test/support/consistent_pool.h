// SPDX-License-Identifier: Apache-2.0
/// Whether the pools and the resources made of them agree with themselves, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_POOL_H
#define TEST_SUPPORT_CONSISTENT_POOL_H

#include "fsw/framework/resource/pool.h"
#include "fsw/framework/resource/resource.h"

/// Free list, references and counters agree.
static inline bool pool_is_consistent(const pool_t* pool)
{
    uint16_t free_count = 0U;
    uint16_t index      = pool->first_free;
    // Counting up to block_count ends the walk even if corruption has turned the list into a loop.
    while ((index < pool->block_count) && (free_count < pool->block_count) &&
           (pool->slots[index].references == 0U)) {
        free_count++;
        index = pool->slots[index].next_free;
    }
    uint16_t held = 0U;
    for (uint16_t i = 0U; i < pool->block_count; i++) {
        held = (uint16_t)(held + ((pool->slots[i].references > 0U) ? 1U : 0U));
    }
    return (index == UINT16_MAX) && (held == pool->stats.taken) &&
           ((pool->stats.taken + free_count) == pool->block_count) && (pool->stats.taken <= pool->stats.peak);
}

static inline bool resource_is_consistent(const resource_t* resource)
{
    bool is_consistent = true;
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        is_consistent = is_consistent && pool_is_consistent(&resource->pools[i]);
    }
    return is_consistent;
}

/// True if no block is out: what SOFTWARE_DEINIT must leave behind.
static inline bool resource_is_returned(const resource_t* resource)
{
    uint32_t taken = 0U;
    for (uint16_t i = 0U; i < resource->pool_count; i++) {
        taken += resource->pools[i].stats.taken;
    }
    return taken == 0U;
}

#endif // TEST_SUPPORT_CONSISTENT_POOL_H
