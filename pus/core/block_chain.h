// SPDX-License-Identifier: Apache-2.0
/// Octet strings of any size in chains of equal blocks. Services store requests in them.
///
/// Ownership  The caller provides blocks and slots, which must exist as long as the chains. Each chain has
///            one user, which frees it.
/// Context    One loop.
/// Time       O(octets); no search for free blocks.
/// Errors     The only error is that too few blocks are free; a status reports it.
#ifndef PUS_CORE_BLOCK_CHAIN_H
#define PUS_CORE_BLOCK_CHAIN_H

#include "base/status.h"
#include "base/pool.h"

#include <stddef.h>
#include <stdint.h>

#define PUS_BLOCK_CHAIN_BLOCK 56U ///< Octets of a string in one block.

typedef struct pus_block_chain_block { // Private.
    struct pus_block_chain_block* next;
    uint8_t octets[PUS_BLOCK_CHAIN_BLOCK];
} pus_block_chain_block_t;

/// Size of the storage array of `count` blocks [64-bit words].
#define PUS_BLOCK_CHAIN_WORDS(count) POOL_STORAGE_WORDS(sizeof(pus_block_chain_block_t), count)
/// Blocks that a string of `size` octets takes.
#define PUS_BLOCK_CHAIN_BLOCKS(size) (((size) + (PUS_BLOCK_CHAIN_BLOCK - 1U)) / PUS_BLOCK_CHAIN_BLOCK)

typedef struct { // Private, except pool.stats: read-only, for telemetry.
    pool_t pool; // Pool of all blocks.
} pus_block_chains_t;

typedef struct { // Private, except `size`. All zero is the empty string.
    pus_block_chain_block_t* first;
    pus_block_chain_block_t* last;
    uint32_t size; ///< [octets]
} pus_block_chain_t;

typedef struct { // Private, except `left`.
    const pus_block_chain_block_t* block;
    uint32_t offset; // Offset of the next octet in the block.
    uint32_t left;   ///< Octets not read yet.
} pus_block_chain_reader_t;

/// Make all blocks free. storage: PUS_BLOCK_CHAIN_WORDS(block_count) words; block_count 1..65534.
void pus_block_chains_init(pus_block_chains_t* chains, uint64_t* storage, pool_slot_t* slots,
                           uint16_t block_count);
/// Add octets at the end. STATUS_OK, STATUS_EXHAUSTED (too few blocks: nothing changes).
MUST_USE status_t pus_block_chain_append(pus_block_chains_t* chains, pus_block_chain_t* chain,
                                         const uint8_t* octets, size_t size);
/// Return the blocks to the pool; the string is empty then.
void pus_block_chain_free(pus_block_chains_t* chains, pus_block_chain_t* chain);
/// Read from the beginning. The chain may not change meanwhile.
pus_block_chain_reader_t pus_block_chain_reader(const pus_block_chain_t* chain);
/// Copy the next octets, `size` or as many as are left. Returns their number.
size_t pus_block_chain_read(pus_block_chain_reader_t* reader, uint8_t* out_octets, size_t size);
/// Skip `size` octets, or as many as are left.
void pus_block_chain_skip(pus_block_chain_reader_t* reader, size_t size);

#endif // PUS_CORE_BLOCK_CHAIN_H
