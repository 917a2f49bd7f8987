// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/journal/journal_index.h"

/// Returns the slot where the search for a record begins. Keys are often consecutive numbers: odd
/// multipliers and shifts spread them over all bits, and the product with the number of slots takes the
/// upper ones.
static size_t home_of(const uint8_t table, const uint32_t key, const size_t count)
{
    uint32_t hash = (key * 0x9E3779B1U) ^ ((uint32_t)table * 0x85EBCA6BU);
    hash ^= hash >> 15U;
    hash *= 0x2C1B3C6DU;
    hash ^= hash >> 13U;
    return (size_t)(((uint64_t)hash * count) >> 32U);
}

static size_t next_of(const size_t index, const size_t count)
{
    return ((index + 1U) < count) ? (index + 1U) : 0U;
}

/// Returns the distance from slot `from` to slot `to`, modulo the number of slots.
static size_t distance(const size_t from, const size_t to, const size_t count)
{
    return (to >= from) ? (to - from) : ((to + count) - from);
}

journal_slot_t* journal_index_find(journal_slot_t* const slots, const size_t count, const uint8_t table,
                                   const uint32_t key)
{
    size_t index = home_of(table, key, count);
    while (slots[index].is_taken) {
        if ((slots[index].key == key) && (slots[index].table == table)) {
            return &slots[index];
        }
        index = next_of(index, count);
    }
    return NULL;
}

journal_slot_t* journal_index_insert(journal_slot_t* const slots, const size_t count, const uint8_t table,
                                     const uint32_t key)
{
    size_t index = home_of(table, key, count);
    while (slots[index].is_taken) {
        index = next_of(index, count);
    }
    slots[index] = (journal_slot_t){.key = key, .table = table, .is_taken = true};
    return &slots[index];
}

void journal_index_remove(journal_slot_t* const slots, const size_t count, const journal_slot_t* const slot)
{
    size_t hole = (size_t)(slot - slots);
    // A search ends at a free slot. Therefore a record after the hole that a search would no longer find is
    // moved into the hole, and its own slot becomes the new hole.
    for (size_t index = next_of(hole, count); slots[index].is_taken; index = next_of(index, count)) {
        const size_t home = home_of(slots[index].table, slots[index].key, count);
        if (distance(home, index, count) >= distance(hole, index, count)) {
            slots[hole] = slots[index];
            hole        = index;
        }
    }
    slots[hole].is_taken = false;
}
