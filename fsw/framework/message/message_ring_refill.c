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
    size_t place = 0U;
    while (place < size) {
        uint32_t length   = 0U;
        const size_t left = size - place;
        if (left >= LENGTH_OCTETS) {
            (void)memcpy((uint8_t*)&length, &octets[place], LENGTH_OCTETS);
        }
        if ((left < LENGTH_OCTETS) || (length > BLOCK_MAX) || (length > (left - LENGTH_OCTETS))) {
            ring->refused++;
            return;
        }
        if (message_ring_put(ring, &octets[place + LENGTH_OCTETS], length) != STATUS_OK) {
            return; // There is no room for this block; later blocks must not be appended before it.
        }
        place += LENGTH_OCTETS + length;
    }
}
