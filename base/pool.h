// SPDX-License-Identifier: Apache-2.0
/// Pool of equal blocks with reference counts: take, retain and release in constant time, without a heap.
/// Bookkeeping is outside the blocks, so that a write past the end of a block cannot damage the list of free
/// blocks. When the number of taken blocks reaches the warning threshold, before any take is refused,
/// `warning` becomes true (with hysteresis).
///
/// Ownership  The caller provides `storage` and `slots`, which must exist as long as the pool.
/// Context    One loop. Not thread-safe: blocks are never passed to another component.
/// Time       O(1), never blocks; except pool_init: O(block_count).
/// Errors     Each function lists its statuses. A null argument or a wrong size is a coding error
///            (FSW_ASSERT); but a null block that is retained or released is STATUS_NOT_OURS.
///
///     static uint64_t    storage[POOL_STORAGE_WORDS(256U, 32U)];
///     static pool_slot_t slots[32];
///     const pool_setup_t setup = {256U, 32U, .reserve = 2U, .warn_percent = 75U, .clear_percent = 65U};
///     pool_init(&pool, storage, slots, &setup);
#ifndef BASE_POOL_H
#define BASE_POOL_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Size of one block, and of the storage array [64-bit words]. Blocks are rounded up to whole words.
#define POOL_BLOCK_WORDS(octets) (((octets) + 7U) / 8U)
#define POOL_STORAGE_WORDS(octets, count) (POOL_BLOCK_WORDS(octets) * (count))

/// Thresholds of the warning if a descriptor has none [percent of all blocks].
#define POOL_WARN_PERCENT 75U
#define POOL_CLEAR_PERCENT 65U

#define POOL_BLOCK_OCTETS_MAX 65536U

typedef struct {
    size_t block_octets;   ///< Usable size of a block [octets], 1..POOL_BLOCK_OCTETS_MAX.
    uint16_t block_count;  ///< 1..65534.
    uint16_t reserve;      ///< Number of last blocks that only pool_take_reserved takes, < block_count.
    uint8_t warn_percent;  ///< Taken blocks at which `warning` becomes true [%], 1..100.
    uint8_t clear_percent; ///< Taken blocks at which `warning` becomes false again [%], < warn_percent.
} pool_setup_t;

typedef struct {         // One per block, placed by the owner. All fields are private.
    uint32_t start;      // Start of the block [octets] in the storage: constant.
    uint16_t next;       // Index of the next free block; undefined in the last free block.
    uint16_t references; // 0: free.
} pool_slot_t;

typedef struct { // All fields are private, except `stats`: read-only, for housekeeping telemetry.
    uint8_t* storage;
    pool_slot_t* slots;
    size_t block_words;
    size_t block_octets;
    uint64_t inverse; // 2^32 / size of a block in whole words [octets], rounded up.
    void* free_block; // First free block, if there is one; free_index is its index.
    uint16_t free_index;
    uint16_t block_count;
    uint16_t unreserved; // Number of blocks without the reserve.
    uint16_t quiet;      // With fewer taken blocks, a take causes no refusal, no new peak and no warning.
    uint16_t warn_blocks;
    uint16_t clear_blocks;
    bool is_unpolled; // `warning` has become true since the last poll.
    struct {
        uint16_t taken;    ///< Blocks taken now [blocks, 0..block_count].
        uint16_t peak;     ///< Largest `taken` since pool_init [blocks].
        bool warning;      ///< `taken` is at or above the threshold (with hysteresis).
        uint32_t warnings; ///< Number of times that `warning` became true [wraps].
        uint32_t refused;  ///< Takes refused because no block was free for the caller [calls, wraps].
        uint32_t rejected; ///< Retains and releases that did not return STATUS_OK [calls, wraps].
    } stats;
} pool_t;

/// Make all blocks free and clear the counters.
void pool_init(pool_t* pool, uint64_t* storage, pool_slot_t* slots, const pool_setup_t* setup);

/// Change the thresholds (the descriptor defines them, and may be loaded after the pool was made). 1 <=
/// clear_percent < warn_percent <= 100. The warning is evaluated again.
void pool_set_thresholds(pool_t* pool, uint8_t warn_percent, uint8_t clear_percent);

/// Take one block, with one reference. Its content is undefined, its alignment that of uint64_t. The reserve
/// is not used. Returns null if no block is left: then only `refused` changes.
MUST_USE void* pool_take(pool_t* pool);

/// Like pool_take, but may use the reserve: for functions that must work when the pool is full (commanding).
MUST_USE void* pool_take_reserved(pool_t* pool);

/// Add a reference to a taken block. STATUS_OK; STATUS_NOT_OURS (counted in `rejected`) if `block` is not a
/// taken block of this pool; STATUS_FULL (counted there, too) if it has 65535 references.
MUST_USE status_t pool_retain(pool_t* pool, void* block);

/// Remove a reference; without references the block is free, and the pointer must not be used again.
/// STATUS_OK, or STATUS_NOT_OURS if `block` is not a taken block of this pool; then only `rejected` changes.
MUST_USE status_t pool_release(pool_t* pool, void* block);

/// True if `warning` has become true since the last call: the owner then raises its LOW event.
bool pool_poll_warning(pool_t* pool);

/// True if `block` lies in this pool's storage (taken or not).
bool pool_owns(const pool_t* pool, const void* block);

#endif // BASE_POOL_H
