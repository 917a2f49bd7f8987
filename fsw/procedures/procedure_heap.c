// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_heap.h"

#include "base/assertion.h"

#include <string.h>

#define TAKEN 0xFFU
#define WORDS_PER_BLOCK (PROCEDURE_BLOCK / sizeof(uint64_t))

/// Free blocks of one order form a list, which begins at `free`; the first word of a block contains the
/// numbers of the next and the previous block, each + 1; 0: none.
typedef struct {
    uint32_t next;
    uint32_t previous;
} chain_t;

static uint64_t* words_of(const procedure_heap_t* const heap, const uint32_t block)
{
    return &heap->memory[(size_t)block * WORDS_PER_BLOCK];
}

static chain_t chain_of(const procedure_heap_t* const heap, const uint32_t block)
{
    const uint64_t word = words_of(heap, block)[0];
    return (chain_t){.next = (uint32_t)(word & UINT32_MAX), .previous = (uint32_t)(word >> 32U)};
}

static void set_chain(const procedure_heap_t* const heap, const uint32_t block, const chain_t chain)
{
    words_of(heap, block)[0] = ((uint64_t)chain.previous << 32U) | chain.next;
}

static void insert(procedure_heap_t* const heap, const uint32_t block, const uint8_t order)
{
    const uint32_t next = heap->free[order];
    set_chain(heap, block, (chain_t){.next = next, .previous = 0U});
    if (next != 0U) {
        set_chain(heap, next - 1U, (chain_t){.next = chain_of(heap, next - 1U).next, .previous = block + 1U});
    }
    heap->free[order] = block + 1U;
    heap->map[block]  = order;
}

static void extract(procedure_heap_t* const heap, const uint32_t block, const uint8_t order)
{
    const chain_t chain = chain_of(heap, block);
    if (chain.next != 0U) {
        set_chain(heap, chain.next - 1U,
                  (chain_t){.next = chain_of(heap, chain.next - 1U).next, .previous = chain.previous});
    }
    if (chain.previous != 0U) {
        set_chain(heap, chain.previous - 1U,
                  (chain_t){.next = chain.next, .previous = chain_of(heap, chain.previous - 1U).previous});
    } else {
        heap->free[order] = chain.next;
    }
    heap->map[block] = TAKEN;
}

void procedure_heap_init(procedure_heap_t* const heap, uint64_t* const memory, const size_t size,
                         uint8_t* const map)
{
    FSW_ASSERT((heap != NULL) && (memory != NULL) && (map != NULL) && ((size % PROCEDURE_BLOCK) == 0U) &&
               (size <= ((size_t)PROCEDURE_BLOCK << (PROCEDURE_ORDERS - 1U))));
    *heap = (procedure_heap_t){
        .memory = memory, .map = map, .blocks = (uint32_t)PROCEDURE_BLOCKS(size), .refused = 0U};
    (void)memset(map, (int)TAKEN, heap->blocks);
    uint32_t block = 0U;
    // The largest blocks come first, so that each begins at a multiple of its size.
    for (uint8_t order = PROCEDURE_ORDERS; order > 0U; order--) {
        const uint32_t length = 1U << (order - 1U);
        if ((heap->blocks - block) >= length) {
            insert(heap, block, (uint8_t)(order - 1U));
            block += length;
        }
    }
}

/// Returns the order of the smallest block with room for `size` octets; PROCEDURE_ORDERS if there is none.
static uint8_t order_of(const size_t size)
{
    uint8_t order = 0U;
    while ((order < PROCEDURE_ORDERS) && (((size_t)PROCEDURE_BLOCK << order) < size)) {
        order++;
    }
    return order;
}

static size_t octets_of(const uint8_t order)
{
    return (size_t)PROCEDURE_BLOCK << order;
}

/// Free the upper halves of a block until it has the order `wanted`.
static void split(procedure_heap_t* const heap, const uint32_t block, uint8_t order, const uint8_t wanted)
{
    while (order > wanted) {
        order--;
        insert(heap, block + (1U << order), order);
    }
}

void* procedure_heap_take(procedure_heap_t* const heap, const size_t size)
{
    FSW_ASSERT((heap != NULL) && (size >= 1U));
    const uint8_t wanted = order_of(size);
    uint8_t order        = wanted;
    while ((order < PROCEDURE_ORDERS) && (heap->free[order] == 0U)) {
        order++;
    }
    if (order >= PROCEDURE_ORDERS) {
        heap->refused++;
        return NULL;
    }
    const uint32_t block = heap->free[order] - 1U;
    extract(heap, block, order);
    split(heap, block, order, wanted);
    heap->used += octets_of(wanted);
    heap->peak = (heap->used > heap->peak) ? heap->used : heap->peak;
    return words_of(heap, block);
}

static uint32_t block_of(const procedure_heap_t* const heap, const void* const memory)
{
    const uint64_t* const word = memory;
    const uint32_t block       = (uint32_t)((size_t)(word - heap->memory) / WORDS_PER_BLOCK);
    FSW_ASSERT(block < heap->blocks);
    return block;
}

void procedure_heap_give(procedure_heap_t* const heap, void* const block, const size_t size)
{
    FSW_ASSERT((heap != NULL) && (block != NULL) && (size >= 1U));
    uint32_t index = block_of(heap, block);
    uint8_t order  = order_of(size);
    heap->used -= octets_of(order);
    // Join the block with its other half as long as that is free.
    uint32_t buddy = index ^ (1U << order);
    while ((order < (PROCEDURE_ORDERS - 1U)) && (buddy < heap->blocks) && (heap->map[buddy] == order)) {
        extract(heap, buddy, order);
        index = (buddy < index) ? buddy : index;
        order++;
        buddy = index ^ (1U << order);
    }
    insert(heap, index, order);
}

void* procedure_heap_resize(procedure_heap_t* const heap, void* const block, const size_t before,
                            const size_t after)
{
    FSW_ASSERT((heap != NULL) && (block != NULL) && (before >= 1U) && (after >= 1U));
    const uint8_t order  = order_of(before);
    const uint8_t wanted = order_of(after);
    if (wanted <= order) {
        split(heap, block_of(heap, block), order, wanted);
        heap->used -= octets_of(order) - octets_of(wanted);
        return block;
    }
    void* const larger = procedure_heap_take(heap, after);
    if (larger != NULL) {
        (void)memcpy(larger, block, before);
        procedure_heap_give(heap, block, before);
    }
    return larger;
}
