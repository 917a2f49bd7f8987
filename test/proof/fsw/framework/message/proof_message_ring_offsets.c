// SPDX-License-Identifier: Apache-2.0
// Proves: looking at a block returns its size, its first octets and the offset of the next block, and
//     changes nothing; overwriting a block changes its first octets and nothing else. No access
//     is outside the storage.
// Bounds: a ring of 16 octets that begins at any position of its storage; two blocks of 0..3 octets, of
//     which one is looked at and overwritten.
// Replaced: nothing.
// Sources: fsw/framework/message/message_ring.c
// Options: --unwind 2
// Fault: fsw/framework/message/message_ring.c
//   - (void)read_at(ring, start, head, (length < head_size) ? length : head_size);
//   + (void)read_at(ring, start, head, head_size);
// Fault: fsw/framework/message/message_ring.c
//   - (void)write_at(ring, wrapped(ring, ring->head + offset + LENGTH_OCTETS), octets, size);
//   + (void)write_at(ring, wrapped(ring, ring->head + LENGTH_OCTETS), octets, size);
#include "fsw/framework/message/message_ring.h"
#include "test/proof/proof.h"

#define CAPACITY 16U
#define BLOCK 3U
#define LENGTH 4U // Octets of the length field in front of each block.

static uint8_t storage[CAPACITY];
static message_ring_t ring;

static void any_ring(void)
{
    message_ring_init(&ring, storage, CAPACITY);
    ring.head = any_size(CAPACITY - 1U);
}

static void put(const uint8_t* const block, const size_t size)
{
    const status_t status = message_ring_put(&ring, block, size);
    ASSUME(status == STATUS_OK); // There is room for the block: proof_message_ring.c proves it.
}

static void prove_looking(const size_t offset, const uint8_t* const block, const size_t size)
{
    uint8_t head[BLOCK];
    const size_t head_size      = any_size(BLOCK);
    const size_t index          = any_size(BLOCK - 1U);
    const uint8_t octet         = head[index];
    const message_ring_t before = ring;
    size_t got_size             = 0U;
    const size_t next           = message_ring_look(&ring, offset, head, head_size, &got_size);
    PROVE((got_size == size) && (next == (offset + LENGTH + size)),
          "a look returns the size of the block and the offset of the next one");
    PROVE(head[index] == (((index < size) && (index < head_size)) ? block[index] : octet),
          "a look copies the first octets of the block, and no others");
    PROVE((ring.head == before.head) && (ring.used == before.used) && (ring.blocks == before.blocks),
          "a look changes nothing");
}

static void prove_taken(const uint8_t* const block, const size_t size, const uint8_t* const patch,
                        const size_t patch_size)
{
    uint8_t got[BLOCK];
    size_t got_size       = 0U;
    const status_t status = message_ring_take(&ring, got, BLOCK, &got_size);
    const size_t index    = any_size(BLOCK - 1U);
    PROVE((status == STATUS_OK) && (got_size == size), "the size of a block stays");
    PROVE(IMPLIES(index < size, got[index] == ((index < patch_size) ? patch[index] : block[index])),
          "the overwritten octets are new, and no others");
}

static void prove_offsets(void)
{
    uint8_t first[BLOCK];
    uint8_t second[BLOCK];
    uint8_t patch[BLOCK];
    const size_t first_size  = any_size(BLOCK);
    const size_t second_size = any_size(BLOCK);
    const bool is_second     = nondet_bool();
    const size_t offset      = is_second ? (LENGTH + first_size) : 0U;
    const size_t patch_size  = any_size(is_second ? second_size : first_size);
    any_ring();
    put(first, first_size);
    put(second, second_size);
    prove_looking(offset, is_second ? second : first, is_second ? second_size : first_size);
    const message_ring_t before = ring;
    message_ring_overwrite(&ring, offset, patch, patch_size);
    PROVE((ring.head == before.head) && (ring.used == before.used) && (ring.blocks == before.blocks),
          "overwriting changes only octets of the block");
    prove_taken(first, first_size, patch, is_second ? 0U : patch_size);
    prove_taken(second, second_size, patch, is_second ? patch_size : 0U);
}

void proof(void)
{
    prove_offsets();
}
