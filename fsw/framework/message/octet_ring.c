// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/octet_ring.h"

#include "fsw/framework/base/assertion.h"

#include <string.h>

#define LENGTH_OCTETS 4U
#define BLOCK_MAX 65535U

void octet_ring_init(octet_ring_t* const ring, uint8_t* const storage, const size_t capacity)
{
    FSW_ASSERT((ring != NULL) && (storage != NULL) && (capacity >= 16U));
    *ring = (octet_ring_t){.storage = storage, .capacity = capacity};
}

/// A position that has run at most once past the end.
static size_t wrapped(const octet_ring_t* const ring, const size_t position)
{
    return (position >= ring->capacity) ? (position - ring->capacity) : position;
}

static void copy_in(octet_ring_t* const ring, const uint8_t* const octets, const size_t size)
{
    const size_t tail = wrapped(ring, ring->head + ring->used);
    const size_t left = ring->capacity - tail;
    if (size <= left) {
        (void)memcpy(&ring->storage[tail], octets, size);
    } else {
        (void)memcpy(&ring->storage[tail], octets, left);
        (void)memcpy(ring->storage, &octets[left], size - left);
    }
    ring->used += size;
}

static void drop(octet_ring_t* const ring, const size_t size)
{
    ring->head = wrapped(ring, ring->head + size);
    ring->used -= size;
}

static void copy_out(octet_ring_t* const ring, uint8_t* const octets, const size_t size)
{
    const size_t left = ring->capacity - ring->head;
    if (size <= left) {
        (void)memcpy(octets, &ring->storage[ring->head], size);
    } else {
        (void)memcpy(octets, &ring->storage[ring->head], left);
        (void)memcpy(&octets[left], ring->storage, size - left);
    }
    drop(ring, size);
}

static uint32_t length_at(const octet_ring_t* const ring, const size_t position)
{
    uint32_t length = 0U;
    for (size_t i = 0U; i < LENGTH_OCTETS; i++) {
        length = (length << 8U) | ring->storage[wrapped(ring, position + i)];
    }
    return length;
}

size_t octet_ring_room(const octet_ring_t* const ring)
{
    FSW_ASSERT(ring != NULL);
    const size_t left = ring->capacity - ring->used;
    return (left > LENGTH_OCTETS) ? (left - LENGTH_OCTETS) : 0U;
}

status_t octet_ring_put(octet_ring_t* const ring, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((ring != NULL) && ((octets != NULL) || (size == 0U)) && (size <= BLOCK_MAX));
    if ((size + LENGTH_OCTETS) > (ring->capacity - ring->used)) {
        ring->refused++;
        return STATUS_FULL;
    }
    const uint8_t length[LENGTH_OCTETS] = {0U, 0U, (uint8_t)(size >> 8U), (uint8_t)(size & 0xFFU)};
    copy_in(ring, length, LENGTH_OCTETS);
    if (size > 0U) {
        copy_in(ring, octets, size);
    }
    ring->blocks++;
    ring->peak = (ring->used > ring->peak) ? (uint32_t)ring->used : ring->peak;
    return STATUS_OK;
}

status_t octet_ring_take(octet_ring_t* const ring, uint8_t* const octets, const size_t capacity,
                         size_t* const out_size)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (ring->blocks == 0U) {
        return STATUS_EMPTY;
    }
    const size_t size = length_at(ring, ring->head);
    FSW_ASSERT((size + LENGTH_OCTETS) <= ring->used);
    drop(ring, LENGTH_OCTETS);
    ring->blocks--;
    if (size > capacity) {
        drop(ring, size);
        return STATUS_TOO_LARGE;
    }
    copy_out(ring, octets, size);
    *out_size = size;
    return STATUS_OK;
}

status_t octet_ring_peek(const octet_ring_t* const ring, uint8_t* const octets, const size_t capacity,
                         size_t* const out_size)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (ring->blocks == 0U) {
        return STATUS_EMPTY;
    }
    *out_size          = length_at(ring, ring->head);
    const size_t begin = ring->head + LENGTH_OCTETS;
    for (size_t i = 0U; (i < capacity) && (i < *out_size); i++) {
        octets[i] = ring->storage[(begin + i) % ring->capacity];
    }
    return STATUS_OK;
}
