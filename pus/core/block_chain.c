// SPDX-License-Identifier: Apache-2.0
#include "pus/core/block_chain.h"

#include "base/assertion.h"

#include <string.h>

void pus_block_chains_init(pus_block_chains_t* const chains, uint64_t* const storage,
                           pool_slot_t* const slots, const uint16_t block_count)
{
    FSW_ASSERT(chains != NULL);
    const pool_setup_t setup = {.block_octets  = sizeof(pus_block_chain_block_t),
                                .block_count   = block_count,
                                .warn_percent  = POOL_WARN_PERCENT,
                                .clear_percent = POOL_CLEAR_PERCENT};
    pool_init(&chains->pool, storage, slots, &setup);
}

static void release(pus_block_chains_t* const chains, pus_block_chain_block_t* const first)
{
    pus_block_chain_block_t* block = first;
    while (block != NULL) {
        pus_block_chain_block_t* const next = block->next;
        const status_t status               = pool_release(&chains->pool, block);
        FSW_ASSERT(status == STATUS_OK); // True, because the block is from this pool.
        block = next;
    }
}

/// Take `count` blocks. STATUS_OK, STATUS_EXHAUSTED (no block is taken).
static status_t take(pus_block_chains_t* const chains, const size_t count,
                     pus_block_chain_block_t** const out_first)
{
    *out_first = NULL;
    for (size_t i = 0U; i < count; i++) {
        pus_block_chain_block_t* const block = pool_take(&chains->pool);
        if (block == NULL) {
            release(chains, *out_first);
            return STATUS_EXHAUSTED;
        }
        block->next = *out_first;
        *out_first  = block;
    }
    return STATUS_OK;
}

/// Append the first of the allocated blocks to a chain. Returns the remaining blocks.
static pus_block_chain_block_t* lengthen(pus_block_chain_t* const chain, pus_block_chain_block_t* const block)
{
    FSW_ASSERT(block != NULL); // pus_block_chain_append has taken enough blocks before.
    pus_block_chain_block_t* const rest = block->next;
    block->next                         = NULL;
    if (chain->last == NULL) {
        chain->first = block;
    } else {
        chain->last->next = block;
    }
    chain->last = block;
    return rest;
}

status_t pus_block_chain_append(pus_block_chains_t* const chains, pus_block_chain_t* const chain,
                                const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((chains != NULL) && (chain != NULL) && (octets != NULL));
    const size_t needed = PUS_BLOCK_CHAIN_BLOCKS(chain->size + size) - PUS_BLOCK_CHAIN_BLOCKS(chain->size);
    pus_block_chain_block_t* spare = NULL;
    const status_t status          = take(chains, needed, &spare);
    if (status != STATUS_OK) {
        return status;
    }
    size_t done = 0U;
    while (done < size) {
        const size_t used = chain->size % PUS_BLOCK_CHAIN_BLOCK;
        const size_t room = PUS_BLOCK_CHAIN_BLOCK - used;
        const size_t part = ((size - done) < room) ? (size - done) : room;
        if (used == 0U) {
            spare = lengthen(chain, spare);
        }
        (void)memcpy(&chain->last->octets[used], &octets[done], part);
        chain->size += (uint32_t)part;
        done += part;
    }
    return STATUS_OK;
}

void pus_block_chain_free(pus_block_chains_t* const chains, pus_block_chain_t* const chain)
{
    FSW_ASSERT((chains != NULL) && (chain != NULL));
    release(chains, chain->first);
    *chain = (pus_block_chain_t){0};
}

pus_block_chain_reader_t pus_block_chain_reader(const pus_block_chain_t* const chain)
{
    FSW_ASSERT(chain != NULL);
    return (pus_block_chain_reader_t){.block = chain->first, .left = chain->size};
}

/// Read up to `size` octets, or skip them if `out_octets` is null. Returns their number.
static size_t advance(pus_block_chain_reader_t* const reader, uint8_t* const out_octets, const size_t size)
{
    const size_t wanted = (size < reader->left) ? size : reader->left;
    size_t done         = 0U;
    while (done < wanted) {
        if (reader->offset == PUS_BLOCK_CHAIN_BLOCK) {
            reader->block  = reader->block->next;
            reader->offset = 0U;
        }
        const size_t room = PUS_BLOCK_CHAIN_BLOCK - reader->offset;
        const size_t part = ((wanted - done) < room) ? (wanted - done) : room;
        if (out_octets != NULL) {
            (void)memcpy(&out_octets[done], &reader->block->octets[reader->offset], part);
        }
        reader->offset += (uint32_t)part;
        reader->left -= (uint32_t)part;
        done += part;
    }
    return done;
}

size_t pus_block_chain_read(pus_block_chain_reader_t* const reader, uint8_t* const out_octets,
                            const size_t size)
{
    FSW_ASSERT((reader != NULL) && (out_octets != NULL));
    return advance(reader, out_octets, size);
}

void pus_block_chain_skip(pus_block_chain_reader_t* const reader, const size_t size)
{
    FSW_ASSERT(reader != NULL);
    (void)advance(reader, NULL, size);
}
