// SPDX-License-Identifier: Apache-2.0
// Proves: the copy of a ring is the sequence of its blocks in order, each with its length field in front,
//     as message_ring_refill reads it; a ring that is larger than the room for the copy is not
//     copied; the ring does not change. No access is outside the storage or the room for the copy.
// Bounds: a ring of 16 octets that begins at any position of its storage; none, one or two blocks of 0..3
//     octets; room for 0..16 octets.
// Replaced: nothing.
// Sources: fsw/framework/message/message_ring.c
// Options: --unwind 2
// Fault: fsw/framework/message/message_ring.c
//   - (void)read_at(ring, ring->head, octets, ring->used);
//   + (void)memcpy(octets, &ring->storage[0], ring->used);
// Fault: fsw/framework/message/message_ring.c
//   - if (ring->used > capacity) {
//   + if (ring->used > (capacity + 1U)) {
#include "fsw/framework/message/message_ring.h"
#include "test/proof/proof.h"

#include <string.h>

#define CAPACITY 16U
#define BLOCK 3U
#define LENGTH 4U // Octets of the length field in front of each block.

static uint8_t storage[CAPACITY];
static uint8_t room[CAPACITY];
static message_ring_t ring;

static void put(const uint8_t* const block, const size_t size)
{
    const status_t status = message_ring_put(&ring, block, size);
    ASSUME(status == STATUS_OK); // There is room for the block: proof_message_ring.c proves it.
}

/// The block is at `offset` of the copy: its length field, and each of its octets.
static void prove_block(const uint8_t* const copy, const size_t offset, const uint8_t* const block,
                        const size_t size)
{
    uint32_t length    = 0U;
    const size_t index = any_size(BLOCK - 1U);
    (void)memcpy((uint8_t*)&length, &copy[offset], LENGTH);
    PROVE(length == size, "a block follows its length field");
    PROVE(IMPLIES(index < size, copy[offset + LENGTH + index] == block[index]), "a block has its octets");
}

void proof(void)
{
    uint8_t first[BLOCK];
    uint8_t second[BLOCK];
    const size_t first_size  = any_size(BLOCK);
    const size_t second_size = any_size(BLOCK);
    const size_t blocks      = any_size(2U);
    const size_t capacity    = any_size(CAPACITY);
    uint8_t* const copy      = &room[CAPACITY - capacity]; // The first octet after it is outside.
    message_ring_init(&ring, storage, CAPACITY);
    ring.head = any_size(CAPACITY - 1U);
    if (blocks > 0U) {
        put(first, first_size);
    }
    if (blocks > 1U) {
        put(second, second_size);
    }
    const message_ring_t before = ring;
    const size_t size           = message_ring_copy(&ring, copy, capacity);
    PROVE(size == ((ring.used <= capacity) ? ring.used : 0U), "the copy has all blocks, or none");
    if ((size > 0U) && (blocks > 0U)) {
        prove_block(copy, 0U, first, first_size);
    }
    if ((size > 0U) && (blocks > 1U)) {
        prove_block(copy, LENGTH + first_size, second, second_size);
    }
    PROVE((ring.head == before.head) && (ring.used == before.used) && (ring.blocks == before.blocks) &&
              (ring.refused == before.refused),
          "copying changes nothing");
}
