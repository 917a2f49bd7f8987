// SPDX-License-Identifier: Apache-2.0
// The heap of entries by the cycle in which they are due, compared with a plain table.
#include "pus/core/due_heap.h"

#include "unity.h"

#include <string.h>

#define CAPACITY 200U

static pus_due_heap_t heap;
static pus_due_t items[CAPACITY];
static uint16_t positions[CAPACITY];

void setUp(void)
{
    memset(positions, 0xFF, sizeof positions);
    pus_due_init(&heap, items, positions, CAPACITY);
}

void tearDown(void)
{
}

static void expect_next(const uint64_t now, const uint16_t expected)
{
    uint16_t entry = UINT16_MAX;
    TEST_ASSERT_TRUE(pus_due_next(&heap, now, &entry));
    TEST_ASSERT_EQUAL_UINT16(expected, entry);
}

static void expect_none(const uint64_t now)
{
    uint16_t entry = 0U;
    TEST_ASSERT_FALSE(pus_due_next(&heap, now, &entry));
}

static void nothing_is_due_before_its_cycle(void)
{
    expect_none(UINT64_MAX);
    pus_due_set(&heap, 3U, 10U);
    expect_none(9U);
    expect_next(10U, 3U);
    expect_next(UINT64_MAX, 3U);
}

static void entries_are_ordered_by_cycle_then_by_number(void)
{
    pus_due_set(&heap, 7U, 5U);
    pus_due_set(&heap, 2U, 5U);
    pus_due_set(&heap, 9U, 4U);
    expect_next(5U, 9U);
    pus_due_remove(&heap, 9U);
    expect_next(5U, 2U);
    pus_due_remove(&heap, 2U);
    expect_next(5U, 7U);
    pus_due_remove(&heap, 7U);
    pus_due_remove(&heap, 7U);
    expect_none(5U);
}

static void an_entry_repeats_with_its_period(void)
{
    pus_due_set(&heap, 0U, 10U);
    pus_due_repeat(&heap, 10U, 5U);
    expect_none(14U);
    expect_next(15U, 0U);
    pus_due_repeat(&heap, 31U, 5U); // The due cycles 20, 25 and 30 were missed.
    expect_none(34U);
    expect_next(35U, 0U);
    pus_due_repeat(&heap, 35U, UINT32_MAX);
    expect_none(35ULL + UINT32_MAX - 1ULL);
    expect_next(35ULL + UINT32_MAX, 0U);
}

static uint32_t next_random(uint32_t* const state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return *state >> 8U;
}

/// Returns the earliest entry of a plain table, found by a search; CAPACITY if the table is empty.
static uint16_t first_of(const uint64_t* const dues)
{
    uint16_t first = CAPACITY;
    for (uint16_t i = 0U; i < CAPACITY; i++) {
        if ((dues[i] != 0U) && ((first == CAPACITY) || (dues[i] < dues[first]))) {
            first = i;
        }
    }
    return first;
}

static void the_heap_agrees_with_a_plain_table(void)
{
    static uint64_t dues[CAPACITY]; // Due cycles; 0: the entry is not in the heap.
    uint32_t state = 1U;
    memset(dues, 0, sizeof dues);
    for (unsigned i = 0U; i < 20000U; i++) {
        const uint16_t entry = (uint16_t)(next_random(&state) % CAPACITY);
        if ((next_random(&state) % 3U) == 0U) {
            pus_due_remove(&heap, entry);
            dues[entry] = 0U;
        } else {
            dues[entry] = 1U + (next_random(&state) % 50U);
            pus_due_set(&heap, entry, dues[entry]);
        }
        const uint16_t first = first_of(dues);
        uint16_t found       = CAPACITY;
        TEST_ASSERT_EQUAL(first != CAPACITY, pus_due_next(&heap, UINT64_MAX, &found));
        TEST_ASSERT_EQUAL_UINT16(first, found);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(nothing_is_due_before_its_cycle);
    RUN_TEST(entries_are_ordered_by_cycle_then_by_number);
    RUN_TEST(an_entry_repeats_with_its_period);
    RUN_TEST(the_heap_agrees_with_a_plain_table);
    return UNITY_END();
}
