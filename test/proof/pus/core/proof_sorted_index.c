// SPDX-License-Identifier: Apache-2.0
// Proves: after any series of insertions and removals the index returns exactly the slots that it contains,
//     in the order of tag and serial, from the first one and from any bound; no access is outside the nodes.
// Bounds: three slots, four calls, any tags below 4; the serial is the number of the call, because no two
//     slots may have the same tag and serial.
// Replaced: nothing.
// Sources: pus/core/sorted_index.c
// Options: --unwind 6
// Fault: pus/core/sorted_index.c
//   - order->first = pus_sorted_index_next(order, slot);
//   + order->first = order->root;
// Fault: pus/core/sorted_index.c
//   - above->children[side] = inner;
//   + above->children[side] = NONE;
#include "pus/core/sorted_index.h"
#include "test/proof/proof.h"

#define SLOTS 3U
#define CALLS 4U

static pus_sorted_index_node_t nodes[SLOTS];
static bool is_in[SLOTS];
static uint64_t tags[SLOTS];
static uint64_t serials[SLOTS];

static bool is_ordered(const uint16_t one, const uint16_t other)
{
    return (tags[one] < tags[other]) || ((tags[one] == tags[other]) && (serials[one] <= serials[other]));
}

static void one_call(pus_sorted_index_t* const order, const uint64_t serial)
{
    const uint16_t slot = nondet_u16();
    ASSUME(slot < SLOTS);
    if (is_in[slot]) {
        pus_sorted_index_remove(order, slot);
        is_in[slot] = false;
    } else {
        tags[slot]    = nondet_u8() & 3U;
        serials[slot] = serial;
        pus_sorted_index_insert(order, slot, tags[slot], serials[slot]);
        is_in[slot] = true;
    }
}

void proof(void)
{
    pus_sorted_index_t order;
    pus_sorted_index_init(&order, nodes);
    for (unsigned i = 0U; i < CALLS; i++) {
        one_call(&order, i);
    }
    unsigned expected = 0U;
    for (uint16_t i = 0U; i < SLOTS; i++) {
        expected += is_in[i] ? 1U : 0U;
    }
    const uint64_t tag   = nondet_u8() & 3U;
    const uint16_t bound = pus_sorted_index_from(&order, tag, 0U);
    unsigned found       = 0U;
    bool is_bound_passed = (bound == PUS_SORTED_INDEX_NONE);
    uint16_t slot        = pus_sorted_index_first(&order);
    while (slot != PUS_SORTED_INDEX_NONE) {
        PROVE((slot < SLOTS) && is_in[slot], "a slot that is given is in the index");
        is_bound_passed = is_bound_passed || (slot == bound);
        PROVE(IMPLIES(bound != PUS_SORTED_INDEX_NONE, is_bound_passed == (tags[slot] >= tag)),
              "the lower bound divides the order");
        const uint16_t next = pus_sorted_index_next(&order, slot);
        PROVE((next == PUS_SORTED_INDEX_NONE) || is_ordered(slot, next), "slots come in order");
        slot = next;
        found++;
    }
    PROVE(found == expected, "every slot is given once");
}
