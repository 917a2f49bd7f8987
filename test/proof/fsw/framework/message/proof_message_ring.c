// SPDX-License-Identifier: Apache-2.0
// Proves: a ring returns the blocks that were put, in the same order, wherever the ring wraps; a block that
//     does not fit is refused and changes nothing but the counter of refusals; `used` is the sum of the sizes
//     of the blocks and their length fields; no access is outside the storage.
// Bounds: a ring of 16 octets that begins at any position of its storage; two blocks of 0..5 octets: the
//     first is put in two parts, the second may not fit.
// Replaced: nothing.
// Sources: fsw/framework/message/message_ring.c
// Options: --unwind 7
// Fault: fsw/framework/message/message_ring.c
//   - (void)memcpy(ring->storage, &octets[left], size - left);
//   + (void)memcpy(ring->storage, octets, size - left);
// Fault: fsw/framework/message/message_ring.c
//   - if ((size + LENGTH_OCTETS) > (ring->capacity - ring->used)) {
//   + if (size > (ring->capacity - ring->used)) {
#include "fsw/framework/message/message_ring.h"
#include "test/proof/proof.h"

#define CAPACITY 16U
#define BLOCK 5U

static void prove_taken(message_ring_t* const ring, const uint8_t* const block, const size_t size)
{
    uint8_t got[BLOCK];
    size_t got_size       = 0U;
    const status_t status = message_ring_take(ring, got, BLOCK, &got_size);
    const size_t index    = any_size(BLOCK - 1U);
    PROVE((status == STATUS_OK) && (got_size == size), "a block that is taken has the size that was put");
    PROVE(IMPLIES(index < size, got[index] == block[index]),
          "a block that is taken has the octets that were put");
}

void proof(void)
{
    uint8_t storage[CAPACITY];
    uint8_t first[BLOCK];
    uint8_t second[BLOCK];
    const size_t first_size  = any_size(BLOCK);
    const size_t second_size = any_size(BLOCK);
    const size_t head_size   = any_size(first_size);
    message_ring_t ring;
    message_ring_init(&ring, storage, CAPACITY);
    ring.head = any_size(CAPACITY - 1U);

    status_t status =
        message_ring_put_parts(&ring, first, head_size, &first[head_size], first_size - head_size);
    PROVE((status == STATUS_OK) && (ring.used == (first_size + 4U)), "the first block fits");
    const size_t room = message_ring_room(&ring);
    status            = message_ring_put(&ring, second, second_size);
    PROVE((status == STATUS_OK) == ((first_size + second_size + 8U) <= CAPACITY),
          "a block is accepted if and only if it fits");
    PROVE(IMPLIES(status == STATUS_OK, second_size <= room),
          "an accepted block is not larger than the reported room");
    PROVE(ring.used == (first_size + 4U + ((status == STATUS_OK) ? (second_size + 4U) : 0U)),
          "`used` counts the octets of blocks and length fields");
    PROVE(ring.refused == ((status == STATUS_OK) ? 0U : 1U), "a refusal is counted");
    prove_taken(&ring, first, first_size);
    if (status == STATUS_OK) {
        prove_taken(&ring, second, second_size);
    }
    size_t none = 0U;
    PROVE((message_ring_take(&ring, first, BLOCK, &none) == STATUS_EMPTY) && (ring.used == 0U) &&
              (ring.head < CAPACITY),
          "nothing is left");
}
