// SPDX-License-Identifier: Apache-2.0
/// Slots (indices of a table of the caller) in the order of their tags; equal tags in the order of their
/// serial numbers. The index is a treap: a binary tree by (tag, serial) that is a heap by a hash of the slot,
/// so that its depth is logarithmic for any order of insertion.
///
/// Ownership  The caller provides the nodes, which must exist as long as the index. The caller knows which
///            slots are in the index.
/// Context    One loop.
/// Time       Insert, remove, lower bound and next O(log count); first O(1). No recursion.
#ifndef PUS_CORE_SORTED_INDEX_H
#define PUS_CORE_SORTED_INDEX_H

#include <stdint.h>

#define PUS_SORTED_INDEX_NONE UINT16_MAX ///< No slot.

typedef struct { // Private, except tag and serial: read-only.
    uint64_t tag;
    uint64_t serial;
    uint16_t parent;
    uint16_t children[2]; // Subtrees of earlier and of later slots.
} pus_sorted_index_node_t;

typedef struct { // Private.
    pus_sorted_index_node_t* nodes;
    uint16_t root;
    uint16_t first;
} pus_sorted_index_t;

/// Begin with an empty index. `nodes` has one node for each slot, at most PUS_SORTED_INDEX_NONE.
void pus_sorted_index_init(pus_sorted_index_t* order, pus_sorted_index_node_t* nodes);
/// Insert a slot that is not in the index. No slot in the index has the same tag and serial.
void pus_sorted_index_insert(pus_sorted_index_t* order, uint16_t slot, uint64_t tag, uint64_t serial);
/// Remove a slot that is in the index.
void pus_sorted_index_remove(pus_sorted_index_t* order, uint16_t slot);
/// Returns the first slot; PUS_SORTED_INDEX_NONE if there is none.
uint16_t pus_sorted_index_first(const pus_sorted_index_t* order);
/// Returns the first slot at or after (tag, serial); PUS_SORTED_INDEX_NONE if there is none.
uint16_t pus_sorted_index_from(const pus_sorted_index_t* order, uint64_t tag, uint64_t serial);
/// Returns the slot after a slot that is in the index; PUS_SORTED_INDEX_NONE after the last.
uint16_t pus_sorted_index_next(const pus_sorted_index_t* order, uint16_t slot);

#endif // PUS_CORE_SORTED_INDEX_H
