// SPDX-License-Identifier: Apache-2.0
// The sorted index (a balanced tree), compared with a search through all slots.
#include "pus/core/sorted_index.h"

#include "unity.h"

#include <stdbool.h>
#include <string.h>

#define SLOTS 10000U
#define SMALL 60U

static pus_sorted_index_node_t nodes[SLOTS];
static pus_sorted_index_t order;
static bool is_in[SLOTS];
static uint32_t state;

void setUp(void)
{
    pus_sorted_index_init(&order, nodes);
    memset(is_in, 0, sizeof is_in);
    state = 12345U;
}

void tearDown(void)
{
}

/// Returns a pseudo-random number below `limit`; the same sequence in every run.
static uint32_t draw(const uint32_t limit)
{
    state = (state * 1664525U) + 1013904223U;
    return (state >> 8U) % limit;
}

static bool is_before(const uint16_t one, const uint16_t other)
{
    return (nodes[one].tag < nodes[other].tag) ||
           ((nodes[one].tag == nodes[other].tag) && (nodes[one].serial < nodes[other].serial));
}

/// Returns the first slot in the order that is at or after (tag, serial), found by comparing all slots.
static uint16_t search(const uint64_t tag, const uint64_t serial)
{
    uint16_t found = PUS_SORTED_INDEX_NONE;
    for (uint16_t i = 0U; i < SMALL; i++) {
        const bool is_late = (nodes[i].tag > tag) || ((nodes[i].tag == tag) && (nodes[i].serial >= serial));
        if (is_in[i] && is_late && ((found == PUS_SORTED_INDEX_NONE) || is_before(i, found))) {
            found = i;
        }
    }
    return found;
}

/// Expect the order that results from comparing all slots.
static void expect_order_of_all_slots(void)
{
    uint16_t expected = search(0U, 0U);
    uint16_t slot     = pus_sorted_index_first(&order);
    while (slot != PUS_SORTED_INDEX_NONE) {
        TEST_ASSERT_EQUAL_UINT16(expected, slot);
        expected = search(nodes[slot].tag, nodes[slot].serial + 1U);
        slot     = pus_sorted_index_next(&order, slot);
    }
    TEST_ASSERT_EQUAL_UINT16(PUS_SORTED_INDEX_NONE, expected);
}

static void random_changes_keep_the_order(void)
{
    for (unsigned i = 0U; i < 4000U; i++) {
        const uint16_t slot = (uint16_t)draw(SMALL);
        if (is_in[slot]) {
            pus_sorted_index_remove(&order, slot);
        } else {
            pus_sorted_index_insert(&order, slot, draw(20U), i);
        }
        is_in[slot] = !is_in[slot];
        expect_order_of_all_slots();
        const uint32_t tag    = draw(22U);
        const uint32_t serial = draw(4000U);
        TEST_ASSERT_EQUAL_UINT16(search(tag, serial), pus_sorted_index_from(&order, tag, serial));
    }
    for (uint16_t slot = 0U; slot < SMALL; slot++) {
        if (is_in[slot]) {
            pus_sorted_index_remove(&order, slot);
            is_in[slot] = false;
            expect_order_of_all_slots();
        }
    }
    TEST_ASSERT_EQUAL_UINT16(PUS_SORTED_INDEX_NONE, pus_sorted_index_first(&order));
}

static unsigned depth(void)
{
    unsigned deepest = 0U;
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        unsigned above = 1U;
        for (uint16_t up = nodes[slot].parent; up != PUS_SORTED_INDEX_NONE; up = nodes[up].parent) {
            above++;
        }
        deepest = (above > deepest) ? above : deepest;
    }
    return deepest;
}

static void the_depth_is_logarithmic_for_every_order_of_tags(void)
{
    for (unsigned round = 0U; round < 4U; round++) {
        pus_sorted_index_init(&order, nodes);
        for (uint32_t slot = 0U; slot < SLOTS; slot++) {
            const uint64_t tags[] = {slot, SLOTS - slot, 7U, draw(1000000U)};
            pus_sorted_index_insert(&order, (uint16_t)slot, tags[round], slot);
        }
        // A binary tree of 10000 entries has at least 14 levels. A search compares one entry on each level.
        TEST_ASSERT_LESS_THAN_UINT(40U, depth());
    }
}

static void equal_tags_keep_the_order_of_their_numbers(void)
{
    pus_sorted_index_insert(&order, 3U, 5U, 1U);
    pus_sorted_index_insert(&order, 1U, 5U, 2U);
    pus_sorted_index_insert(&order, 2U, 5U, 3U);
    TEST_ASSERT_EQUAL_UINT16(3U, pus_sorted_index_first(&order));
    TEST_ASSERT_EQUAL_UINT16(1U, pus_sorted_index_next(&order, 3U));
    TEST_ASSERT_EQUAL_UINT16(2U, pus_sorted_index_next(&order, 1U));
    TEST_ASSERT_EQUAL_UINT16(PUS_SORTED_INDEX_NONE, pus_sorted_index_next(&order, 2U));
    TEST_ASSERT_EQUAL_UINT16(1U, pus_sorted_index_from(&order, 5U, 2U));
    TEST_ASSERT_EQUAL_UINT16(PUS_SORTED_INDEX_NONE, pus_sorted_index_from(&order, 5U, 4U));
    TEST_ASSERT_EQUAL_UINT16(PUS_SORTED_INDEX_NONE, pus_sorted_index_from(&order, UINT64_MAX, 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(random_changes_keep_the_order);
    RUN_TEST(the_depth_is_logarithmic_for_every_order_of_tags);
    RUN_TEST(equal_tags_keep_the_order_of_their_numbers);
    return UNITY_END();
}
