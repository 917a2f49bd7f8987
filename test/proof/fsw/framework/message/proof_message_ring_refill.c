// SPDX-License-Identifier: Apache-2.0
// Proves: refilling offers the ring exactly the blocks of the sequence, whole, with the size in their length
//     fields and in order, up to the first block that is cut or too large, or that the ring refuses; no later
//     block is offered. One refusal is counted if the last block offered was refused or octets of the
//     sequence are left, and none otherwise. No access is outside the sequence.
// Bounds: a sequence of 0..20 octets of any value; blocks of at most 5 octets (65535 in flight).
// Replaced: message_ring_put accepts or refuses any block (proof_message_ring.c proves it).
// Sources: fsw/framework/message/message_ring_refill.c
// Options: --unwind 7
// Reduced: fsw/framework/message/message_ring_refill.c
//   - #define BLOCK_MAX 65535U
//   + #define BLOCK_MAX 5U
// Quick: yes
// Fault: fsw/framework/message/message_ring_refill.c
//   - if ((left < LENGTH_OCTETS) || (length > BLOCK_MAX) || (length > (left - LENGTH_OCTETS))) {
//   + if ((left < LENGTH_OCTETS) || (length > BLOCK_MAX) || (length > left)) {
// Fault: fsw/framework/message/message_ring_refill.c
//   - return; // There is no room for this block; later blocks must not be appended before it.
//   + ring->peak = 0U;
#include "fsw/framework/message/message_ring.h"
#include "test/proof/proof.h"

#include <string.h>

#define SEQUENCE 20U
#define LARGEST 5U // Octets of the largest block.
#define LENGTH 4U  // Octets of the length field in front of each block.

static uint8_t octets[SEQUENCE];
static const uint8_t* sequence; // It ends with the array: the first octet after it is outside.
static size_t offset;           // Distance from the start of the sequence to the next block.
static size_t left;             // Octets from there to the end of the sequence.
static bool is_full;            // The ring has refused a block.

/// Size of the next block; any value if its length field is cut.
static uint32_t next_length(void)
{
    uint32_t length = nondet_u32();
    if (left >= LENGTH) {
        (void)memcpy((uint8_t*)&length, &sequence[offset], LENGTH);
    }
    return length;
}

status_t message_ring_put(message_ring_t* const ring, const uint8_t* const block, const size_t size)
{
    PROVE(!is_full, "after a refused block no other one is offered");
    PROVE(left >= (LENGTH + size), "an offered block ends inside the sequence");
    PROVE(block == &sequence[offset + LENGTH], "a block begins where the one before it ends");
    PROVE((size == next_length()) && (size <= LARGEST), "an offered block has the size in its length field");
    offset += LENGTH + size;
    left -= LENGTH + size;
    is_full = nondet_bool();
    ring->refused += is_full ? 1U : 0U;
    return is_full ? STATUS_FULL : STATUS_OK;
}

void proof(void)
{
    message_ring_t ring;
    const message_ring_t before = ring;
    __CPROVER_havoc_object(octets);
    const size_t size = any_size(SEQUENCE);
    sequence          = &octets[SEQUENCE - size];
    left              = size;
    message_ring_refill(&ring, sequence, size);
    const uint32_t length = next_length();
    const bool is_bad     = (left < LENGTH) || (length > LARGEST) || (length > (left - LENGTH));
    PROVE(IMPLIES(!is_full && (left > 0U), is_bad), "every whole block is offered");
    PROVE((ring.refused - before.refused) == ((is_full || (left > 0U)) ? 1U : 0U),
          "a refusal is counted if and only if octets are left or the last block offered was refused");
    PROVE((ring.storage == before.storage) && (ring.capacity == before.capacity) &&
              (ring.head == before.head) && (ring.used == before.used) && (ring.blocks == before.blocks) &&
              (ring.peak == before.peak),
          "only message_ring_put changes the content of the ring");
}
