// SPDX-License-Identifier: Apache-2.0
/// First-in first-out store of octet blocks of different sizes in one array of the caller.
///
/// Ownership  The ring borrows `storage`, which outlives it.
/// Context    One task.
/// Time       O(size) for the copy.
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_RING_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_RING_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct { // All fields are private, except the counters.
    uint8_t* storage;
    size_t capacity;
    size_t head;      ///< Next octet to read.
    size_t used;      ///< Octets in the ring, length fields included.
    uint32_t blocks;  ///< Number of blocks in the ring.
    uint32_t peak;    ///< Largest value of `used` so far.
    uint32_t refused; ///< Blocks refused for lack of room.
} message_ring_t;

/// Initialise an empty ring. capacity >= 16 [octets]; each block needs its size plus four.
void message_ring_init(message_ring_t* ring, uint8_t* storage, size_t capacity);
/// Append a block of 0..65535 octets. STATUS_OK, STATUS_FULL (counted).
MUST_USE status_t message_ring_put(message_ring_t* ring, const uint8_t* octets, size_t size);
/// Like message_ring_put, with a block in two parts; a part of size 0 may be null.
MUST_USE status_t message_ring_put_parts(message_ring_t* ring, const uint8_t* head, size_t head_size,
                                         const uint8_t* octets, size_t size);
/// Take the oldest block. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (it does not fit `capacity`; dropped).
MUST_USE status_t message_ring_take(message_ring_t* ring, uint8_t* octets, size_t capacity, size_t* out_size);
/// Like message_ring_take, in two parts: the first `head_size` octets of the block, or all if it is
/// shorter, are copied to `head`, the rest to `octets`. *out_size is the size of the whole block; it and
/// `head` are also set if the rest does not fit.
MUST_USE status_t message_ring_take_parts(message_ring_t* ring, uint8_t* head, size_t head_size,
                                          uint8_t* octets, size_t capacity, size_t* out_size);
/// Copy the first octets of the oldest block, at most `capacity`, without taking the block; *out_size is
/// the size of the whole block. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t message_ring_peek(const message_ring_t* ring, uint8_t* octets, size_t capacity,
                                    size_t* out_size);
/// Copy the first octets (up to head_size) of the block at `offset` without taking it; *out_size is the size
/// of the whole block. `offset` is the distance from the first block [octets]: 0, or an earlier result minus
/// the octets taken since then; there must be a block at that offset. Returns the offset of the next block.
size_t message_ring_look(const message_ring_t* ring, size_t offset, uint8_t* head, size_t head_size,
                         size_t* out_size);
/// Overwrite the first `size` octets of the block at `offset`, which must have at least as many.
void message_ring_overwrite(message_ring_t* ring, size_t offset, const uint8_t* octets, size_t size);
/// Copy all blocks as one sequence of octets, for message_ring_refill. Returns its size; 0: the ring is
/// empty, or the sequence does not fit `capacity`.
size_t message_ring_copy(const message_ring_t* ring, uint8_t* octets, size_t capacity);
/// Append the blocks of a sequence that message_ring_copy has written. A block that is cut or has no room
/// is refused (counted).
void message_ring_refill(message_ring_t* ring, const uint8_t* octets, size_t size);
/// Returns the size of the largest block for which message_ring_put has room now.
size_t message_ring_room(const message_ring_t* ring);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_RING_H
