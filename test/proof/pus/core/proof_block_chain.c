// SPDX-License-Identifier: Apache-2.0
// Proves: a chain returns the octets that were appended, for strings of any size; if there are not enough
//     blocks, nothing changes and no block is lost; after the chain is freed, it is empty and every block is
//     free. No access is outside a block.
// Bounds: three blocks of 56 octets; two strings of 0..90 octets, of which the proof follows any one octet.
// Replaced: memcpy checks that both ranges are accessible, and follows the octet, which can be at any
//     position.
// Sources: base/pool.c
// Options: --unwind 5
// Fault: pus/core/block_chain.c
//   - release(chains, *out_first);
//   + (void)out_first;
// Fault: pus/core/block_chain.c
//   - chain->last->next = block;
//   + chain->first->next = block;
// Fault: pus/core/block_chain.c
//   - *chain = (pus_block_chain_t){0};
//   + chain->size = 0U;
#include "test/proof/proof.h"

static const uint8_t* followed; // Present address of the octet that the proof follows.

/// Replaces memcpy.
static void* copy(void* const to, const void* const from, const size_t size)
{
    PROVE(__CPROVER_r_ok(from, size) && __CPROVER_w_ok(to, size),
          "what is copied is inside string and block");
    const size_t at    = __CPROVER_POINTER_OFFSET(followed);
    const size_t start = __CPROVER_POINTER_OFFSET(from);
    if (__CPROVER_same_object(followed, from) && (at >= start) && ((at - start) < size)) {
        followed = (const uint8_t*)to + (at - start);
    }
    return to;
}

#include <string.h>
#define memcpy copy
#include "pus/core/block_chain.c"

#define BLOCKS 3U
#define STRING 90U

static uint64_t storage[PUS_BLOCK_CHAIN_WORDS(BLOCKS)];
static pool_slot_t slots[BLOCKS];

void proof(void)
{
    pus_block_chains_t chains;
    pus_block_chain_t chain = {0};
    uint8_t first[STRING];
    uint8_t second[STRING];
    const size_t first_size  = any_size(STRING);
    const size_t second_size = any_size(STRING);
    const size_t position    = any_size(2U * STRING);
    followed = (position < first_size) ? &first[position] : &second[(position - first_size) % STRING];
    pus_block_chains_init(&chains, storage, slots, BLOCKS);
    PROVE(pus_block_chain_append(&chains, &chain, first, first_size) == STATUS_OK, "the first string fits");
    const uint16_t taken  = chains.pool.stats.taken;
    const status_t status = pus_block_chain_append(&chains, &chain, second, second_size);
    const bool fits       = PUS_BLOCK_CHAIN_BLOCKS(first_size + second_size) <= BLOCKS;
    PROVE((status == STATUS_OK) == fits, "a string that fits is appended");
    PROVE(IMPLIES(!fits, (chain.size == first_size) && (chains.pool.stats.taken == taken)),
          "if the string does not fit, nothing changes");
    const size_t whole = first_size + (fits ? second_size : 0U);
    PROVE(chain.size == whole, "the size is that of all octets");
    PROVE(chains.pool.stats.taken == PUS_BLOCK_CHAIN_BLOCKS(whole), "no block more than needed");

    if (position < whole) {
        pus_block_chain_reader_t reader = pus_block_chain_reader(&chain);
        uint8_t octet                   = 0U;
        pus_block_chain_skip(&reader, position);
        PROVE(pus_block_chain_read(&reader, &octet, 1U) == 1U, "an octet is left");
        PROVE(followed == &octet, "the octet found is the one that was appended there");
    }
    pus_block_chain_free(&chains, &chain);
    PROVE(chains.pool.stats.taken == 0U, "every block is free again");
    PROVE((chain.first == NULL) && (chain.last == NULL) && (chain.size == 0U), "the chain is empty");
}
