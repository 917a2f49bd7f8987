// SPDX-License-Identifier: Apache-2.0
// This function has its own file, because only a restarted supervisor needs it to restore its rings from a
// copy.
#include "base/assertion.h"
#include "fsw/framework/message/message_ring.h"

#include <string.h>

#define LENGTH_OCTETS sizeof(uint32_t) // Size field that message_ring.c writes before each block.
#define BLOCK_MAX 65535U

void message_ring_refill(message_ring_t* const ring, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((ring != NULL) && (octets != NULL));
    size_t position = 0U;
    while (position < size) {
        uint32_t length   = 0U;
        const size_t left = size - position;
        if (left >= LENGTH_OCTETS) {
            (void)memcpy((uint8_t*)&length, &octets[position], LENGTH_OCTETS);
        }
        if ((left < LENGTH_OCTETS) || (length > BLOCK_MAX) || (length > (left - LENGTH_OCTETS))) {
            ring->refused++;
            return;
        }
        if (message_ring_put(ring, &octets[position + LENGTH_OCTETS], length) != STATUS_OK) {
            return; // There is no room for this block; later blocks must not be appended before it.
        }
        position += LENGTH_OCTETS + length;
    }
}
