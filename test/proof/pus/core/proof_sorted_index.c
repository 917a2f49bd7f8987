// SPDX-License-Identifier: Apache-2.0
// Proves: every call on every sound index leaves a sound index: a binary tree in the order of tag and
//     serial that is a heap by the rank of the slot and contains exactly the slots that were inserted and
//     not removed. The initial index is sound, so every index that calls can make is sound. The first slot,
//     the slot after a slot, and the first slot at or after a bound are those of the order; no access is
//     outside the nodes.
// Bounds: three slots, every sound index, one call; by induction any number of calls. Tags and serials are
//     below 8, because only their order matters; no two slots have the same ones, as the contract requires.
// Replaced: the rank of a slot is its number instead of its hash. No two slots have the same number or the
//     same hash, and ranks are only compared, so that other ranks are another numbering of the slots.
// Sources:
// Options: --unwind 5
// Reduced: pus/core/sorted_index.c
//   - return hash ^ (hash >> 16U);
//   + return slot;
// Fault: pus/core/sorted_index.c
//   - order->first = pus_sorted_index_next(order, slot);
//   + order->first = order->root;
// Fault: pus/core/sorted_index.c
//   - above->children[side] = inner;
//   + above->children[side] = NONE;
// Fault: pus/core/sorted_index.c
//   - const bool is_later = rank_of(node->children[LATER]) > rank_of(node->children[EARLIER]);
//   + const bool is_later = rank_of(node->children[LATER]) < rank_of(node->children[EARLIER]);
#include "pus/core/sorted_index.c"

#include "test/proof/proof.h"

#define SLOTS 3U
#define KEYS 8U // Tags and serials are below this number.

static pus_sorted_index_t order;
static pus_sorted_index_node_t nodes[SLOTS];
static bool is_in[SLOTS]; // The slots that the index contains.

static bool precedes(const uint16_t one, const uint64_t tag, const uint64_t serial)
{
    return (nodes[one].tag < tag) || ((nodes[one].tag == tag) && (nodes[one].serial < serial));
}

static bool is_member(const uint16_t slot)
{
    return (slot < SLOTS) && is_in[slot];
}

/// True if each slot above `slot` has a higher rank, and has `slot` on the side that the order requires.
static bool is_placed(const uint16_t slot)
{
    uint16_t below = slot;
    uint16_t above = nodes[slot].parent;
    for (unsigned depth = 1U; (depth < SLOTS) && (above != NONE); depth++) {
        if (!is_member(above) || (above <= below)) {
            return false;
        }
        const unsigned side = precedes(above, nodes[slot].tag, nodes[slot].serial) ? LATER : EARLIER;
        if ((nodes[above].children[side] != below) || (nodes[above].children[LATER - side] == below)) {
            return false;
        }
        below = above;
        above = nodes[above].parent;
    }
    return (above == NONE) && (order.root == below);
}

static bool has_its_children(const uint16_t slot)
{
    bool is_good = true;
    for (unsigned side = EARLIER; side <= LATER; side++) {
        const uint16_t child = nodes[slot].children[side];
        is_good = is_good && ((child == NONE) || (is_member(child) && (nodes[child].parent == slot)));
    }
    return is_good;
}

static bool is_sound(void)
{
    bool is_empty = true;
    bool is_good  = true;
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        if (is_in[slot]) {
            is_empty = false;
            is_good  = is_good && is_placed(slot) && has_its_children(slot) && is_member(order.first) &&
                      !precedes(slot, nodes[order.first].tag, nodes[order.first].serial);
        }
        for (uint16_t other = 0U; other < slot; other++) {
            const bool is_same =
                (nodes[slot].tag == nodes[other].tag) && (nodes[slot].serial == nodes[other].serial);
            is_good = is_good && !(is_in[slot] && is_in[other] && is_same);
        }
    }
    return is_good && (is_empty == (order.root == NONE)) && (is_empty == (order.first == NONE));
}

static void any_sound_index(void)
{
    __CPROVER_havoc_object(nodes);
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        is_in[slot] = nondet_bool();
        ASSUME((nodes[slot].tag < KEYS) && (nodes[slot].serial < KEYS));
    }
    order.root  = nondet_u16();
    order.first = nondet_u16();
    ASSUME(is_sound());
}

static void prove_change(const uint16_t slot)
{
    const uint16_t other    = nondet_u16();
    const uint64_t tag      = nondet_u8() % KEYS;
    const uint64_t serial   = nondet_u8() % KEYS;
    const bool is_insertion = !is_in[slot];
    ASSUME((other < SLOTS) && (other != slot));
    const uint64_t other_tag    = nodes[other].tag;
    const uint64_t other_serial = nodes[other].serial;
    if (is_insertion) {
        for (uint16_t i = 0U; i < SLOTS; i++) {
            ASSUME(!is_in[i] || (nodes[i].tag != tag) || (nodes[i].serial != serial));
        }
        pus_sorted_index_insert(&order, slot, tag, serial);
    } else {
        pus_sorted_index_remove(&order, slot);
    }
    is_in[slot] = is_insertion;
    PROVE(is_sound(), "the index stays sound, and contains the slots that it must contain");
    PROVE(IMPLIES(is_insertion, (nodes[slot].tag == tag) && (nodes[slot].serial == serial)),
          "a slot that is inserted has its tag and serial");
    PROVE(IMPLIES(is_in[other], (nodes[other].tag == other_tag) && (nodes[other].serial == other_serial)),
          "all other slots keep tag and serial");
}

/// `found` is the first slot that does not precede the bound.
static bool is_first_from(const uint16_t found, const uint64_t tag, const uint64_t serial)
{
    bool is_good = (found == NONE) || (is_member(found) && !precedes(found, tag, serial));
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        if (is_in[slot] && !precedes(slot, tag, serial)) {
            is_good = is_good && (found != NONE) && !precedes(slot, nodes[found].tag, nodes[found].serial);
        }
    }
    return is_good;
}

/// `next` is the first slot that comes after `slot`.
static bool is_next(const uint16_t next, const uint16_t slot)
{
    bool is_good = (next == NONE) || (is_member(next) && precedes(slot, nodes[next].tag, nodes[next].serial));
    for (uint16_t other = 0U; other < SLOTS; other++) {
        if (is_in[other] && precedes(slot, nodes[other].tag, nodes[other].serial)) {
            is_good = is_good && (next != NONE) && !precedes(other, nodes[next].tag, nodes[next].serial);
        }
    }
    return is_good;
}

void proof(void)
{
    pus_sorted_index_init(&order, nodes);
    PROVE(is_sound(), "an index begins sound");
    any_sound_index();
    const uint16_t slot = nondet_u16();
    ASSUME(slot < SLOTS);
    if (nondet_bool()) {
        prove_change(slot);
    } else {
        const uint64_t tag    = nondet_u8() % KEYS;
        const uint64_t serial = nondet_u8() % KEYS;
        PROVE(is_first_from(pus_sorted_index_first(&order), 0U, 0U), "the first slot is the first of all");
        PROVE(is_first_from(pus_sorted_index_from(&order, tag, serial), tag, serial),
              "the lower bound divides the order");
        PROVE(IMPLIES(is_in[slot], is_next(pus_sorted_index_next(&order, slot), slot)),
              "the next slot is the next in the order");
    }
}
