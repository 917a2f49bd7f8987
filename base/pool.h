// SPDX-License-Identifier: Apache-2.0
/// Pool of equal blocks with reference counts: take, retain and release in constant time, without a heap.
/// Bookkeeping lies outside the blocks, so writing past the end of one cannot damage the list of free blocks.
/// When use reaches the warning threshold, `warning` rises (once, with hysteresis) before anything fails.
///
/// Ownership  The pool borrows `storage` and `slots`; both outlive it. It never allocates.
/// Context    One loop. Not thread-safe: blocks never cross a component border.
/// Time       O(1), never blocks; except pool_init: O(block_count).
/// Errors     Each function lists every status it can return. A null argument or a wrong size is a coding
///            error and fails FSW_ASSERT; but a null block that is retained or released is STATUS_NOT_OURS.
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

/// Size of one block, and of the storage array [64-bit words]. Blocks round up to whole words.
#define POOL_BLOCK_WORDS(octets) (((octets) + 7U) / 8U)
#define POOL_STORAGE_WORDS(octets, count) (POOL_BLOCK_WORDS(octets) * (count))

/// Default thresholds of the paper's warning, if a descriptor has none [percent of all blocks].
#define POOL_WARN_PERCENT 75U
#define POOL_CLEAR_PERCENT 65U

#define POOL_BLOCK_OCTETS_MAX 65536U

typedef struct {
    size_t block_octets;   ///< Usable size of a block [octets], 1..POOL_BLOCK_OCTETS_MAX.
    uint16_t block_count;  ///< 1..65534.
    uint16_t reserve;      ///< Last blocks, given only by pool_take_reserved; < block_count.
    uint8_t warn_percent;  ///< Use at which the warning rises, 1..100.
    uint8_t clear_percent; ///< Use at which it falls again, < warn_percent.
} pool_setup_t;

typedef struct {      // One per block, placed by the owner. All fields are private.
    uint32_t start;   // Start of the block [octets] in the storage: constant.
    uint16_t next;    // Index of the next free block; without meaning in the last one.
    uint16_t holders; // 0 = free.
} pool_slot_t;

typedef struct { // All fields are private, except `stats`: read-only, for housekeeping telemetry.
    uint8_t* storage;
    pool_slot_t* slots;
    size_t block_words;
    size_t block_octets;
    uint64_t inverse; // 2^32 / octets of whole words of a block, rounded up.
    void* free_block; // First of the list of free blocks, and its index, as long as there is one.
    uint16_t free_index;
    uint16_t block_count;
    uint16_t unreserved; // Blocks before the reserve begins.
    uint16_t quiet;      // Below this use a take is neither refused, nor a new peak, nor a reason to warn.
    uint16_t warn_blocks;
    uint16_t clear_blocks;
    bool is_unpolled; // Warning has risen and was not polled yet.
    struct {
        uint16_t taken;    ///< Blocks out now [blocks, 0..block_count].
        uint16_t peak;     ///< Largest `taken` since pool_init [blocks].
        bool warning;      ///< Use is at or above the threshold (with hysteresis).
        uint32_t warnings; ///< Times the warning has risen [wraps].
        uint32_t refused;  ///< Takes refused because no block was free for the caller [calls, wraps].
        uint32_t rejected; ///< Retains and releases refused because the pointer was wrong [calls, wraps].
    } stats;
} pool_t;

/// Make all blocks free and clear the counters.
void pool_init(pool_t* pool, uint64_t* storage, pool_slot_t* slots, const pool_setup_t* setup);

/// Change the thresholds (they come from the descriptor, which may be loaded after the pool was made). 1 <=
/// clear_percent < warn_percent <= 100. The warning is evaluated again.
void pool_set_thresholds(pool_t* pool, uint8_t warn_percent, uint8_t clear_percent);

/// Take one block with one reference: aligned as uint64_t, contents undefined. Leaves the reserve alone.
/// Null if no block is left: then only `refused` changes.
MUST_USE void* pool_take(pool_t* pool);

/// Like pool_take, but may use the reserve: for functions that must work when the pool is full (commanding).
MUST_USE void* pool_take_reserved(pool_t* pool);

/// One more holder of a taken block. STATUS_OK; STATUS_NOT_OURS if `block` is not a taken block of this pool;
/// STATUS_FULL at 65535 holders.
MUST_USE status_t pool_retain(pool_t* pool, void* block);

/// One holder less; the last one gives the block back and its pointer must not be used again.
/// STATUS_OK, or STATUS_NOT_OURS if `block` is not a taken block of this pool; then only `rejected` changes.
MUST_USE status_t pool_release(pool_t* pool, void* block);

/// True once each time the warning has risen since the last call: the owner then raises its LOW event.
bool pool_poll_warning(pool_t* pool);

/// True if `block` lies in this pool's storage (taken or not).
bool pool_owns(const pool_t* pool, const void* block);

#endif // BASE_POOL_H
