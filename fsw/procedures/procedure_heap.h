// SPDX-License-Identifier: Apache-2.0
/// Memory of one procedure: a binary buddy system on the caller's octets, for an interpreter that passes the
/// size of a block when it frees it. Blocks are 32 octets times a power of two and need no header.
///
/// Ownership  The caller provides memory and map.
/// Context    One loop.
/// Time       O(log memory), and the copy of a block that grows.
/// Errors     Null if there is no room.
#ifndef FSW_PROCEDURES_PROCEDURE_HEAP_H
#define FSW_PROCEDURES_PROCEDURE_HEAP_H

#include <stddef.h>
#include <stdint.h>

#define PROCEDURE_BLOCK 32U ///< Smallest block [octets].
/// Number of block sizes; the largest is 1 MiB.
#define PROCEDURE_ORDERS 16U
#define PROCEDURE_BLOCKS(octets) ((octets) / PROCEDURE_BLOCK) ///< Size of the map [octets].

typedef struct {      // Private, except `peak` and `refused`.
    uint64_t* memory; // `blocks` blocks of PROCEDURE_BLOCK octets.
    uint8_t* map;     // One octet per block: the order of the free block that begins there, otherwise 0xFF.
    uint32_t blocks;
    uint32_t free[PROCEDURE_ORDERS]; // First free block of each order, + 1; 0 none.
    size_t used;                     // [octets]
    size_t peak;                     ///< Largest number of octets in use so far.
    uint32_t refused;                ///< Allocations refused for lack of room.
} procedure_heap_t;

/// Initialise with all memory free. size: a multiple of PROCEDURE_BLOCK, up to 1 MiB; `map` has
/// PROCEDURE_BLOCKS(size) octets.
void procedure_heap_init(procedure_heap_t* heap, uint64_t* memory, size_t size, uint8_t* map);
/// Take a block of at least `size` octets (>= 1), aligned to 8; null if there is no room.
void* procedure_heap_take(procedure_heap_t* heap, size_t size);
/// Free a block that was taken with this size.
void procedure_heap_give(procedure_heap_t* heap, void* block, size_t size);
/// Change the size of a block (both sizes >= 1); the content up to the smaller size is kept. Null if there
/// is no room: the block is then unchanged. Shrinking never fails.
void* procedure_heap_resize(procedure_heap_t* heap, void* block, size_t before, size_t after);

#endif // FSW_PROCEDURES_PROCEDURE_HEAP_H
