// SPDX-License-Identifier: Apache-2.0
/// Selects the next due entry: a heap of entries (0 .. capacity - 1), each with the cycle in which it is due,
/// so that a cycle takes no time for entries that are not due. Entries due in the same cycle are ordered by
/// their number.
///
/// Ownership  The caller provides both arrays, each with `capacity` elements; entry numbers are below
///            `capacity`.
/// Context    One loop.
/// Time       O(log entries); pus_due_next O(1).
#ifndef PUS_CORE_DUE_HEAP_H
#define PUS_CORE_DUE_HEAP_H

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private.
    uint64_t due;
    uint16_t entry;
} pus_due_t;

typedef struct { // Private.
    pus_due_t* heap;
    uint16_t* positions; // Position of each entry in the heap, plus 1; 0: it is not in the heap.
    uint16_t count;
} pus_due_heap_t;

/// Begin with an empty heap.
void pus_due_init(pus_due_heap_t* self, pus_due_t* heap, uint16_t* positions, uint16_t capacity);
/// Set the cycle in which an entry is due; insert the entry if it is not in the heap.
void pus_due_set(pus_due_heap_t* self, uint16_t entry, uint64_t due);
/// Remove an entry, if it is in the heap.
void pus_due_remove(pus_due_heap_t* self, uint16_t entry);
/// True if an entry is due in cycle `now`; *out_entry is the first such entry, which stays in the heap.
bool pus_due_next(const pus_due_heap_t* self, uint64_t now, uint16_t* out_entry);
/// Make the first entry, which pus_due_next has returned for `now`, due again after cycle `now`, a whole
/// number of intervals (>= 1 cycle) after its due cycle.
void pus_due_repeat(pus_due_heap_t* self, uint64_t now, uint64_t interval);

#endif // PUS_CORE_DUE_HEAP_H
