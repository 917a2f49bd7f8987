// SPDX-License-Identifier: Apache-2.0
/// Checks whether a ring of octets is consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_MESSAGE_RING_H
#define TEST_SUPPORT_CONSISTENT_MESSAGE_RING_H

#include "fsw/framework/message/message_ring.h"

#include <string.h>

/// True if the lengths in the ring add up to `used` and their number is `blocks`.
static inline bool octet_ring_is_consistent(const message_ring_t* ring)
{
    size_t offset   = 0U;
    uint32_t blocks = 0U;
    while ((offset < ring->used) && (blocks < ring->blocks)) {
        uint8_t octets[sizeof(uint32_t)];
        uint32_t length = 0U;
        for (size_t i = 0U; i < sizeof octets; i++) {
            octets[i] = ring->storage[(ring->head + offset + i) % ring->capacity];
        }
        (void)memcpy(&length, octets, sizeof length);
        offset += sizeof octets + length;
        blocks++;
    }
    return (offset == ring->used) && (blocks == ring->blocks) && (ring->used <= ring->capacity);
}

#endif // TEST_SUPPORT_CONSISTENT_MESSAGE_RING_H
