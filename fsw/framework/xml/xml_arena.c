// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/xml/xml_arena.h"

#include "base/assertion.h"

#include <stdbool.h>
#include <string.h>

// Room for the size of the block; also the alignment of blocks, which suits any type.
#define HEADER_OCTETS 16U

static __thread xml_arena_t* in_use; // MISRA deviation D-1.4, see the header.

void xml_arena_enter(xml_arena_t* const arena)
{
    FSW_ASSERT((arena != NULL) && (in_use == NULL));
    in_use = arena;
}

void xml_arena_leave(void)
{
    FSW_ASSERT(in_use != NULL);
    in_use = NULL;
}

void xml_arena_reset(xml_arena_t* const arena)
{
    FSW_ASSERT((arena != NULL) && (arena->words != NULL));
    // The words are aligned to 8 octets. The first block begins at the first multiple of HEADER_OCTETS.
    arena->used = ((uintptr_t)arena->words % HEADER_OCTETS == 0U) ? 0U : (HEADER_OCTETS / 2U);
    arena->last = arena->used;
}

/// Returns the octets of a block with its header, a multiple of the alignment; 0 if no arena is that large.
static size_t footprint(const size_t octets)
{
    return (octets > (SIZE_MAX / 2U))
               ? 0U
               : ((octets + HEADER_OCTETS + (HEADER_OCTETS - 1U)) & ~(size_t)(HEADER_OCTETS - 1U));
}

static uint8_t* at(const xml_arena_t* const arena, const size_t offset)
{
    return (uint8_t*)arena->words + offset;
}

static bool has_room(const xml_arena_t* const arena, const size_t octets)
{
    return (octets != 0U) && ((arena->capacity - arena->used) >= octets);
}

void* xml_arena_take(const size_t octets)
{
    xml_arena_t* const arena = in_use;
    FSW_ASSERT(arena != NULL);
    const size_t whole = footprint(octets);
    if (!has_room(arena, whole)) {
        return NULL;
    }
    arena->last = arena->used;
    arena->used += whole;
    (void)memcpy(at(arena, arena->last), &octets, sizeof octets);
    return at(arena, arena->last + HEADER_OCTETS);
}

void* xml_arena_resize(void* const block, const size_t octets)
{
    xml_arena_t* const arena = in_use;
    FSW_ASSERT(arena != NULL);
    if (block == NULL) {
        return xml_arena_take(octets);
    }
    size_t before = 0U;
    (void)memcpy(&before, (uint8_t*)block - HEADER_OCTETS, sizeof before);
    const size_t whole = footprint(octets);
    if ((whole != 0U) && (whole <= footprint(before))) {
        return block;
    }
    if ((uint8_t*)block == at(arena, arena->last + HEADER_OCTETS)) {
        arena->used = arena->last; // The newest block grows in place; its content is not moved.
        if (!has_room(arena, whole)) {
            arena->used = arena->last + footprint(before);
            return NULL;
        }
        arena->used += whole;
        (void)memcpy((uint8_t*)block - HEADER_OCTETS, &octets, sizeof octets);
        return block;
    }
    void* const larger = xml_arena_take(octets);
    if (larger != NULL) {
        (void)memcpy(larger, block, before);
    }
    return larger;
}

void xml_arena_give(void* const block)
{
    xml_arena_t* const arena = in_use;
    FSW_ASSERT(arena != NULL);
    if ((block != NULL) && ((uint8_t*)block == at(arena, arena->last + HEADER_OCTETS))) {
        // Only the newest block is freed; older ones are freed with the whole arena.
        arena->used = arena->last;
    }
}
