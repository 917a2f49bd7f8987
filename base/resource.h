// SPDX-License-Identifier: Apache-2.0
/// The memory of one component: several pools, each with its block size, in one static arena that is divided
/// at start. A request gets a block of the smallest size that fits. If no such block is free, the request is
/// refused, so that many small requests cannot use up the large blocks.
///
/// Ownership  The caller provides the arena, which must exist as long as the resource.
/// Context    One loop, as for pools.
/// Time       O(number of sizes).
///
///     static uint64_t arena[RESOURCE_ARENA_WORDS(128U, 64U) + RESOURCE_ARENA_WORDS(4096U, 8U)];
///     const resource_size_t sizes[] = {{128U, 64U, 2U}, {4096U, 8U, 1U}};
///     status = resource_init(&memory, arena, sizeof arena / sizeof arena[0], sizes, 2U);
#ifndef BASE_RESOURCE_H
#define BASE_RESOURCE_H

#include "base/status.h"
#include "base/pool.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RESOURCE_SIZES_MAX 6U

/// Size of the arena for `count` blocks of `octets`, bookkeeping included [64-bit words].
#define RESOURCE_SLOT_WORDS(count) (((count) * sizeof(pool_slot_t) + 7U) / 8U)
#define RESOURCE_ARENA_WORDS(octets, count) (POOL_STORAGE_WORDS(octets, count) + RESOURCE_SLOT_WORDS(count))

typedef struct {
    size_t block_octets;  ///< [octets], 1..POOL_BLOCK_OCTETS_MAX, strictly ascending in a list of sizes.
    uint16_t block_count; ///< 1..65534.
    uint16_t reserve;     ///< See pool_setup_t.reserve; < block_count.
} resource_size_t;

typedef struct { // Private, except that `pools[i].stats` may be read.
    pool_t pools[RESOURCE_SIZES_MAX];
    uint16_t pool_count;
    uint32_t oversized; ///< Requests larger than the largest block [calls, wraps]; read-only.
} resource_t;

/// Divide the arena into pools. STATUS_OK; STATUS_INVALID (sizes not ascending, or a wrong count or reserve);
/// STATUS_TOO_LARGE (the arena is too small for them). Only after STATUS_OK may the other functions be
/// called.
MUST_USE status_t resource_init(resource_t* resource, uint64_t* arena, size_t arena_words,
                                const resource_size_t* sizes, uint16_t size_count);

/// Take one block of at least `octets`; the block may be one of the reserve. STATUS_OK; STATUS_EXHAUSTED;
/// STATUS_TOO_LARGE (no pool has blocks of that size). *out_block is null unless STATUS_OK.
MUST_USE status_t resource_take_reserved(resource_t* resource, size_t octets, void** out_block);
/// Add a reference to a block. STATUS_OK, STATUS_NOT_OURS, STATUS_FULL; see pool_retain.
MUST_USE status_t resource_retain(resource_t* resource, void* block);
/// Remove a reference to a block. STATUS_OK, STATUS_NOT_OURS; see pool_release.
MUST_USE status_t resource_release(resource_t* resource, void* block);

#endif // BASE_RESOURCE_H
