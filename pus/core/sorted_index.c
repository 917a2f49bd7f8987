// SPDX-License-Identifier: Apache-2.0
#include "pus/core/sorted_index.h"

#include "base/assertion.h"

#include <stdbool.h>
#include <stddef.h>

#define NONE PUS_SORTED_INDEX_NONE
#define EARLIER 0U
#define LATER 1U

void pus_sorted_index_init(pus_sorted_index_t* const order, pus_sorted_index_node_t* const nodes)
{
    FSW_ASSERT((order != NULL) && (nodes != NULL));
    *order = (pus_sorted_index_t){.nodes = nodes, .root = NONE, .first = NONE};
}

/// Priority of a slot in the treap: the node with the highest one is the root. It is a hash (finalizer of
/// MurmurHash3), so that the priorities of neighbouring slots differ strongly.
static uint32_t rank_of(const uint16_t slot)
{
    uint32_t hash = slot + 0x9E3779B9U;
    hash          = (hash ^ (hash >> 16U)) * 0x85EBCA6BU;
    hash          = (hash ^ (hash >> 13U)) * 0xC2B2AE35U;
    return hash ^ (hash >> 16U);
}

static bool is_before(const pus_sorted_index_node_t* const node, const uint64_t tag, const uint64_t serial)
{
    return (node->tag < tag) || ((node->tag == tag) && (node->serial < serial));
}

/// Make `slot` a child of `parent`, in place of its child `old`.
static void replace(pus_sorted_index_t* const order, const uint16_t parent, const uint16_t old,
                    const uint16_t slot)
{
    if (parent == NONE) {
        order->root = slot;
    } else {
        uint16_t* const children                             = order->nodes[parent].children;
        children[(children[LATER] == old) ? LATER : EARLIER] = slot;
    }
    if (slot != NONE) {
        order->nodes[slot].parent = parent;
    }
}

/// Exchange a slot with its parent; the order does not change.
static void rotate_up(pus_sorted_index_t* const order, const uint16_t slot)
{
    pus_sorted_index_node_t* const node  = &order->nodes[slot];
    const uint16_t parent                = node->parent;
    pus_sorted_index_node_t* const above = &order->nodes[parent];
    const unsigned side                  = (above->children[LATER] == slot) ? LATER : EARLIER;
    const uint16_t inner                 = node->children[LATER - side];
    replace(order, above->parent, parent, slot);
    above->children[side] = inner;
    if (inner != NONE) {
        order->nodes[inner].parent = parent;
    }
    node->children[LATER - side] = parent;
    above->parent                = slot;
}

void pus_sorted_index_insert(pus_sorted_index_t* const order, const uint16_t slot, const uint64_t tag,
                             const uint64_t serial)
{
    FSW_ASSERT((order != NULL) && (slot != NONE));
    pus_sorted_index_node_t* const nodes = order->nodes;
    uint16_t parent                      = NONE;
    uint16_t* link                       = &order->root;
    while (*link != NONE) {
        parent = *link;
        link   = &nodes[parent].children[is_before(&nodes[parent], tag, serial) ? LATER : EARLIER];
    }
    *link = slot;
    nodes[slot] =
        (pus_sorted_index_node_t){.tag = tag, .serial = serial, .parent = parent, .children = {NONE, NONE}};
    while ((nodes[slot].parent != NONE) && (rank_of(slot) > rank_of(nodes[slot].parent))) {
        rotate_up(order, slot);
    }
    if ((order->first == NONE) ||
        is_before(&nodes[slot], nodes[order->first].tag, nodes[order->first].serial)) {
        order->first = slot;
    }
}

void pus_sorted_index_remove(pus_sorted_index_t* const order, const uint16_t slot)
{
    FSW_ASSERT((order != NULL) && (slot != NONE));
    const pus_sorted_index_node_t* const node = &order->nodes[slot];
    if (order->first == slot) {
        order->first = pus_sorted_index_next(order, slot);
    }
    while ((node->children[EARLIER] != NONE) && (node->children[LATER] != NONE)) {
        const bool is_later = rank_of(node->children[LATER]) > rank_of(node->children[EARLIER]);
        rotate_up(order, node->children[is_later ? LATER : EARLIER]);
    }
    const uint16_t only = node->children[(node->children[EARLIER] == NONE) ? LATER : EARLIER];
    replace(order, node->parent, slot, only);
}

uint16_t pus_sorted_index_first(const pus_sorted_index_t* const order)
{
    FSW_ASSERT(order != NULL);
    return order->first;
}

uint16_t pus_sorted_index_from(const pus_sorted_index_t* const order, const uint64_t tag,
                               const uint64_t serial)
{
    FSW_ASSERT(order != NULL);
    uint16_t found = NONE;
    uint16_t slot  = order->root;
    while (slot != NONE) {
        const pus_sorted_index_node_t* const node = &order->nodes[slot];
        const bool is_early                       = is_before(node, tag, serial);
        found                                     = is_early ? found : slot;
        slot                                      = node->children[is_early ? LATER : EARLIER];
    }
    return found;
}

uint16_t pus_sorted_index_next(const pus_sorted_index_t* const order, const uint16_t slot)
{
    FSW_ASSERT((order != NULL) && (slot != NONE));
    const pus_sorted_index_node_t* const nodes = order->nodes;
    uint16_t next                              = nodes[slot].children[LATER];
    if (next != NONE) {
        while (nodes[next].children[EARLIER] != NONE) {
            next = nodes[next].children[EARLIER];
        }
        return next;
    }
    uint16_t below = slot;
    next           = nodes[slot].parent;
    while ((next != NONE) && (nodes[next].children[LATER] == below)) {
        below = next;
        next  = nodes[next].parent;
    }
    return next;
}
