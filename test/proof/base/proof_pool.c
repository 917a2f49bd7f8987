// SPDX-License-Identifier: Apache-2.0
// Proves: every call on every sound pool leaves a sound pool: each block is either taken or exactly once in
//     the list of free blocks, and the counters agree. A block that is given was free and is inside the
//     storage; only pool_take_reserved gives the blocks of the reserve; a wrong pointer is refused and
//     counted, and changes neither the references of the block that contains it nor the taken blocks.
// Bounds: pools of four blocks of 8 octets with a reserve of one block, every sound state, one call; by
//     induction any number of calls.
// Replaced: nothing.
// Sources: base/pool.c
// Options: --unwind 6
// Quick: yes
// Fault: base/pool.c
//   - slot->next       = pool->free_index;
//   + slot->next       = index;
// Fault: base/pool.c
//   - (pool->slots[index].references > 0U);
//   + true;
// Fault: base/pool.c
//   - pool->slots[index].references++;
#include "base/pool.h"
#include "test/proof/proof.h"

#define BLOCKS 4U
#define RESERVE 1U

static uint64_t storage[POOL_STORAGE_WORDS(8U, BLOCKS)];
static pool_slot_t slots[BLOCKS];

static uint16_t least(const uint16_t a, const uint16_t b)
{
    return (a < b) ? a : b;
}

static bool is_sound(const pool_t* const pool)
{
    const uint16_t taken = pool->stats.taken;
    if ((taken > BLOCKS) || (pool->stats.peak < taken) || (pool->stats.peak > BLOCKS) ||
        (pool->quiet !=
         least(least(pool->stats.peak, pool->unreserved), (uint16_t)(pool->warn_blocks - 1U)))) {
        return false;
    }
    bool is_listed[BLOCKS] = {false};
    uint16_t index         = pool->free_index;
    for (uint16_t i = taken; i < BLOCKS; i++) {
        if ((index >= BLOCKS) || is_listed[index] || (slots[index].references != 0U)) {
            return false;
        }
        if ((i == taken) && (pool->free_block != &storage[index])) {
            return false;
        }
        is_listed[index] = true;
        index            = slots[index].next;
    }
    for (uint16_t i = 0U; i < BLOCKS; i++) {
        if ((slots[i].start != (8U * i)) || (!is_listed[i] && (slots[i].references == 0U)) ||
            (slots[i].next >= BLOCKS)) {
            return false;
        }
    }
    return true;
}

static void any_sound_state(pool_t* const pool)
{
    for (uint16_t i = 0U; i < BLOCKS; i++) {
        slots[i].next       = nondet_u16();
        slots[i].references = nondet_u16();
    }
    pool->free_index = nondet_u16();
    ASSUME(pool->free_index < BLOCKS);
    pool->free_block    = &storage[pool->free_index];
    pool->quiet         = nondet_u16();
    pool->stats.taken   = nondet_u16();
    pool->stats.peak    = nondet_u16();
    pool->stats.warning = nondet_bool();
    ASSUME(is_sound(pool));
}

static void prove_taking(pool_t* const pool, const bool is_reserved)
{
    uint16_t references[BLOCKS];
    for (uint16_t i = 0U; i < BLOCKS; i++) {
        references[i] = slots[i].references;
    }
    const uint16_t taken        = pool->stats.taken;
    const uint32_t refused      = pool->stats.refused;
    const uint64_t* const block = is_reserved ? pool_take_reserved(pool) : pool_take(pool);
    const uint16_t limit        = is_reserved ? BLOCKS : (BLOCKS - RESERVE);
    PROVE(pool->stats.refused == (refused + ((block == NULL) ? 1U : 0U)), "a refusal is counted");
    PROVE((block != NULL) == (taken < limit), "a block is given if there is one for this caller");
    if (block != NULL) {
        PROVE((block >= storage) && (block < &storage[BLOCKS]), "a block is inside the storage");
        const size_t index = (size_t)(block - storage);
        PROVE((references[index] == 0U) && (slots[index].references == 1U),
              "a block was free and has one reference");
        PROVE(pool->stats.taken == (taken + 1U), "a block that is given is counted");
    }
}

static void prove_holding(pool_t* const pool, const bool is_release)
{
    const size_t offset = nondet_size();
    const bool is_ours  = nondet_bool();
    uint64_t foreign    = 0U;
    ASSUME(offset < sizeof storage);
    uint8_t* const block  = is_ours ? &((uint8_t*)storage)[offset] : (uint8_t*)&foreign;
    const size_t index    = offset / 8U;
    const bool is_block   = is_ours && ((offset % 8U) == 0U) && (slots[index].references > 0U);
    const uint16_t before = slots[index].references;
    const uint16_t taken  = pool->stats.taken;
    const uint32_t wrong  = pool->stats.rejected;
    const status_t status = is_release ? pool_release(pool, block) : pool_retain(pool, block);
    PROVE(IMPLIES(!is_block, pool->stats.rejected == (wrong + 1U)), "a wrong pointer is counted");
    if (!is_block) {
        PROVE((status == STATUS_NOT_OURS) && (slots[index].references == before) &&
                  (pool->stats.taken == taken),
              "a wrong pointer is refused and changes nothing");
    } else if (is_release) {
        PROVE((status == STATUS_OK) && (slots[index].references == (before - 1U)),
              "the block has one reference less");
        PROVE(pool->stats.taken == ((before == 1U) ? (taken - 1U) : taken), "the last release gives it back");
    } else {
        PROVE((status == STATUS_OK) == (before < UINT16_MAX), "a block has a largest number of references");
        PROVE(slots[index].references == ((status == STATUS_OK) ? (before + 1U) : before),
              "the block has one reference more");
    }
}

void proof(void)
{
    pool_t pool;
    const pool_setup_t setup = {.block_octets  = 8U,
                                .block_count   = BLOCKS,
                                .reserve       = RESERVE,
                                .warn_percent  = 75U,
                                .clear_percent = 65U};
    pool_init(&pool, storage, slots, &setup);
    PROVE(is_sound(&pool), "a pool begins sound");
    any_sound_state(&pool);
    const uint8_t choice = nondet_u8();
    if (choice < 2U) {
        prove_taking(&pool, choice == 1U);
    } else {
        prove_holding(&pool, choice == 2U);
    }
    PROVE(is_sound(&pool), "the pool stays sound");
}
