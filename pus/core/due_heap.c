// SPDX-License-Identifier: Apache-2.0
#include "pus/core/due_heap.h"

#include "base/assertion.h"

#include <string.h>

void pus_due_init(pus_due_heap_t* const self, pus_due_t* const heap, uint16_t* const positions,
                  const uint16_t capacity)
{
    FSW_ASSERT((self != NULL) && (heap != NULL) && (positions != NULL));
    *self = (pus_due_heap_t){.heap = heap, .positions = positions};
    (void)memset(positions, 0, capacity * sizeof positions[0]);
}

static bool is_before(const pus_due_t* const one, const pus_due_t* const other)
{
    return (one->due < other->due) || ((one->due == other->due) && (one->entry < other->entry));
}

static void put(pus_due_heap_t* const self, const uint16_t position, const pus_due_t item)
{
    self->heap[position]        = item;
    self->positions[item.entry] = (uint16_t)(position + 1U);
}

/// Insert an item at `position` or above, so that the heap is ordered.
static void move_up(pus_due_heap_t* const self, uint16_t position, const pus_due_t item)
{
    while (position > 0U) {
        const uint16_t parent = (uint16_t)((position - 1U) / 2U);
        if (!is_before(&item, &self->heap[parent])) {
            break;
        }
        put(self, position, self->heap[parent]);
        position = parent;
    }
    put(self, position, item);
}

/// Insert an item at `position` or below, so that the heap is ordered.
static void move_down(pus_due_heap_t* const self, uint16_t position, const pus_due_t item)
{
    uint32_t child = (2U * (uint32_t)position) + 1U;
    while (child < self->count) {
        if (((child + 1U) < self->count) && is_before(&self->heap[child + 1U], &self->heap[child])) {
            child++;
        }
        if (!is_before(&self->heap[child], &item)) {
            break;
        }
        put(self, position, self->heap[child]);
        position = (uint16_t)child;
        child    = (2U * (uint32_t)position) + 1U;
    }
    put(self, position, item);
}

/// Insert an item at the empty position `position`, or above or below it, so that the heap is ordered.
static void fill(pus_due_heap_t* const self, const uint16_t position, const pus_due_t item)
{
    move_down(self, position, item);
    if (self->positions[item.entry] == (position + 1U)) {
        move_up(self, position, item);
    }
}

void pus_due_set(pus_due_heap_t* const self, const uint16_t entry, const uint64_t due)
{
    FSW_ASSERT(self != NULL);
    const pus_due_t item = {.due = due, .entry = entry};
    if (self->positions[entry] != 0U) {
        fill(self, (uint16_t)(self->positions[entry] - 1U), item);
    } else {
        self->count++;
        move_up(self, (uint16_t)(self->count - 1U), item);
    }
}

void pus_due_remove(pus_due_heap_t* const self, const uint16_t entry)
{
    FSW_ASSERT(self != NULL);
    const uint16_t position = self->positions[entry];
    if (position == 0U) {
        return;
    }
    self->positions[entry] = 0U;
    self->count--;
    if ((position - 1U) < self->count) {
        fill(self, (uint16_t)(position - 1U), self->heap[self->count]);
    }
}

bool pus_due_next(const pus_due_heap_t* const self, const uint64_t now, uint16_t* const out_entry)
{
    FSW_ASSERT((self != NULL) && (out_entry != NULL));
    if ((self->count == 0U) || (self->heap[0].due > now)) {
        return false;
    }
    *out_entry = self->heap[0].entry;
    return true;
}

void pus_due_repeat(pus_due_heap_t* const self, const uint64_t now, const uint64_t interval)
{
    FSW_ASSERT((self != NULL) && (self->count > 0U) && (self->heap[0].due <= now) && (interval >= 1U));
    pus_due_t item = self->heap[0];
    item.due += ((now - item.due) / interval) * interval;
    item.due += interval;
    move_down(self, 0U, item);
}
