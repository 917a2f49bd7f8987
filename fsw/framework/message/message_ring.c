// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_ring.h"

#include "base/assertion.h"

#include <string.h>

// Size of the length field in front of each block; its byte order is native.
#define LENGTH_OCTETS sizeof(uint32_t)
#define BLOCK_MAX 65535U

void message_ring_init(message_ring_t* const ring, uint8_t* const storage, const size_t capacity)
{
    FSW_ASSERT((ring != NULL) && (storage != NULL) && (capacity >= 16U));
    *ring = (message_ring_t){.storage = storage, .capacity = capacity};
}

/// Returns a position modulo the capacity; `position` is less than twice the capacity.
static size_t wrapped(const message_ring_t* const ring, const size_t position)
{
    return (position >= ring->capacity) ? (position - ring->capacity) : position;
}

/// Copy octets to a position; returns the position after them.
static inline size_t write_at(const message_ring_t* const ring, const size_t position,
                              const uint8_t* const octets, const size_t size)
{
    const size_t left = ring->capacity - position;
    if (size <= left) {
        (void)memcpy(&ring->storage[position], octets, size);
    } else {
        (void)memcpy(&ring->storage[position], octets, left);
        (void)memcpy(ring->storage, &octets[left], size - left);
    }
    return wrapped(ring, position + size);
}

/// Copy octets from a position; returns the position after them.
static inline size_t read_at(const message_ring_t* const ring, const size_t position, uint8_t* const octets,
                             const size_t size)
{
    const size_t left = ring->capacity - position;
    if (size <= left) {
        (void)memcpy(octets, &ring->storage[position], size);
    } else {
        (void)memcpy(octets, &ring->storage[position], left);
        (void)memcpy(&octets[left], ring->storage, size - left);
    }
    return wrapped(ring, position + size);
}

size_t message_ring_room(const message_ring_t* const ring)
{
    FSW_ASSERT(ring != NULL);
    const size_t left = ring->capacity - ring->used;
    return (left > LENGTH_OCTETS) ? (left - LENGTH_OCTETS) : 0U;
}

status_t message_ring_put(message_ring_t* const ring, const uint8_t* const octets, const size_t size)
{
    return message_ring_put_parts(ring, NULL, 0U, octets, size);
}

status_t message_ring_put_parts(message_ring_t* const ring, const uint8_t* const head, const size_t head_size,
                                const uint8_t* const octets, const size_t rest_size)
{
    const size_t size = head_size + rest_size;
    FSW_ASSERT((ring != NULL) && ((head != NULL) || (head_size == 0U)) &&
               ((octets != NULL) || (rest_size == 0U)) && (size <= BLOCK_MAX));
    if ((size + LENGTH_OCTETS) > (ring->capacity - ring->used)) {
        ring->refused++;
        return STATUS_FULL;
    }
    const uint32_t length = (uint32_t)size;
    size_t position =
        write_at(ring, wrapped(ring, ring->head + ring->used), (const uint8_t*)&length, LENGTH_OCTETS);
    if (head_size > 0U) {
        position = write_at(ring, position, head, head_size);
    }
    if (rest_size > 0U) {
        (void)write_at(ring, position, octets, rest_size);
    }
    ring->used += LENGTH_OCTETS + size;
    ring->blocks++;
    ring->peak = (ring->used > ring->peak) ? (uint32_t)ring->used : ring->peak;
    return STATUS_OK;
}

status_t message_ring_take_parts(message_ring_t* const ring, uint8_t* const head, const size_t head_size,
                                 uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((ring != NULL) && (head != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (ring->blocks == 0U) {
        return STATUS_EMPTY;
    }
    uint32_t length    = 0U;
    size_t position    = read_at(ring, ring->head, (uint8_t*)&length, LENGTH_OCTETS);
    const size_t size  = length;
    const size_t first = (size < head_size) ? size : head_size;
    FSW_ASSERT((LENGTH_OCTETS + size) <= ring->used);
    position        = read_at(ring, position, head, first);
    const bool fits = ((size - first) <= capacity);
    if (fits) {
        (void)read_at(ring, position, octets, size - first);
    }
    ring->head = wrapped(ring, ring->head + LENGTH_OCTETS + size);
    ring->used -= LENGTH_OCTETS + size;
    ring->blocks--;
    *out_size = size;
    return fits ? STATUS_OK : STATUS_TOO_LARGE;
}

status_t message_ring_take(message_ring_t* const ring, uint8_t* const octets, const size_t capacity,
                           size_t* const out_size)
{
    FSW_ASSERT(octets != NULL);
    const status_t status = message_ring_take_parts(ring, octets, 0U, octets, capacity, out_size);
    if (status == STATUS_TOO_LARGE) {
        *out_size = 0U;
    }
    return status;
}

status_t message_ring_peek(const message_ring_t* const ring, uint8_t* const octets, const size_t capacity,
                           size_t* const out_size)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (ring->blocks == 0U) {
        return STATUS_EMPTY;
    }
    (void)message_ring_look(ring, 0U, octets, capacity, out_size);
    return STATUS_OK;
}

size_t message_ring_look(const message_ring_t* const ring, const size_t offset, uint8_t* const head,
                         const size_t head_size, size_t* const out_size)
{
    FSW_ASSERT((ring != NULL) && (head != NULL) && (out_size != NULL) && (offset < ring->used));
    uint32_t length    = 0U;
    const size_t start = read_at(ring, wrapped(ring, ring->head + offset), (uint8_t*)&length, LENGTH_OCTETS);
    (void)read_at(ring, start, head, (length < head_size) ? length : head_size);
    *out_size = length;
    return offset + LENGTH_OCTETS + length;
}

void message_ring_overwrite(message_ring_t* const ring, const size_t offset, const uint8_t* const octets,
                            const size_t size)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL) && ((offset + LENGTH_OCTETS + size) <= ring->used));
    (void)write_at(ring, wrapped(ring, ring->head + offset + LENGTH_OCTETS), octets, size);
}

size_t message_ring_copy(const message_ring_t* const ring, uint8_t* const octets, const size_t capacity)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL));
    if (ring->used > capacity) {
        return 0U;
    }
    (void)read_at(ring, ring->head, octets, ring->used);
    return ring->used;
}
