// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_heap.h"

#include "unity.h"

#include <string.h>

#define SIZE                                                                                                 \
    (100U * PROCEDURE_BLOCK) // Not a power of two, so that the heap begins with free blocks of several sizes.
#define HELD 60U

static uint64_t memory[SIZE / sizeof(uint64_t)];
static uint8_t map[PROCEDURE_BLOCKS(SIZE)];
static procedure_heap_t heap;

void setUp(void)
{
    procedure_heap_init(&heap, memory, SIZE, map);
}

void tearDown(void)
{
}

static void the_whole_heap_can_be_taken_and_given_back(void)
{
    void* blocks[100];
    for (unsigned round = 0U; round < 2U; round++) {
        for (unsigned i = 0U; i < 100U; i++) {
            blocks[i] = procedure_heap_take(&heap, PROCEDURE_BLOCK);
            TEST_ASSERT_NOT_NULL(blocks[i]);
            memset(blocks[i], (int)i, PROCEDURE_BLOCK);
        }
        TEST_ASSERT_NULL(procedure_heap_take(&heap, 1U));
        TEST_ASSERT_EQUAL_UINT32(round + 1U, heap.refused);
        for (unsigned i = 0U; i < 100U; i++) {
            procedure_heap_give(&heap, blocks[(i * 37U) % 100U], PROCEDURE_BLOCK);
        }
        TEST_ASSERT_EQUAL_UINT64(0U, heap.used);
        // The free blocks are joined again.
        void* const large = procedure_heap_take(&heap, 64U * PROCEDURE_BLOCK);
        TEST_ASSERT_NOT_NULL(large);
        procedure_heap_give(&heap, large, 64U * PROCEDURE_BLOCK);
    }
    TEST_ASSERT_EQUAL_UINT64(SIZE, heap.peak);
}

static void a_block_that_is_too_large_is_refused(void)
{
    TEST_ASSERT_NULL(procedure_heap_take(&heap, SIZE_MAX));
    TEST_ASSERT_NULL(procedure_heap_take(&heap, (1024U * 1024U) + 1U));
    TEST_ASSERT_NULL(procedure_heap_take(&heap, (64U * PROCEDURE_BLOCK) + 1U));
    TEST_ASSERT_NOT_NULL(procedure_heap_take(&heap, 64U * PROCEDURE_BLOCK));
}

static void blocks_grow_and_shrink_with_their_content(void)
{
    uint8_t* block = procedure_heap_take(&heap, 100U);
    memset(block, 0x5A, 100U);
    uint8_t* const neighbour = procedure_heap_take(&heap, 100U);
    memset(neighbour, 0x33, 100U);
    block = procedure_heap_resize(&heap, block, 100U, 120U); // Both sizes need a block of 128 octets.
    block = procedure_heap_resize(&heap, block, 120U, 1000U);
    TEST_ASSERT_NOT_NULL(block);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, block, 100U);
    TEST_ASSERT_EQUAL_PTR(block, procedure_heap_resize(&heap, block, 1000U, 20U));
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, block, 20U);
    TEST_ASSERT_EQUAL_UINT64(128U + 32U, heap.used);
    TEST_ASSERT_NULL(procedure_heap_resize(&heap, block, 20U, 64U * PROCEDURE_BLOCK));
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, block, 20U);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x33, neighbour, 100U);
}

static uint32_t next_random(uint32_t* const state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return *state >> 8U;
}

static void blocks_never_overlap(void)
{
    struct {
        uint8_t* octets;
        size_t size;
        uint8_t mark;
    } held[HELD]   = {{NULL, 0U, 0U}};
    uint32_t state = 7U;
    for (unsigned i = 0U; i < 50000U; i++) {
        const unsigned k  = next_random(&state) % HELD;
        const size_t size = 1U + (next_random(&state) % 200U);
        if (held[k].octets != NULL) {
            TEST_ASSERT_EACH_EQUAL_HEX8(held[k].mark, held[k].octets, held[k].size);
        }
        if (held[k].octets == NULL) {
            held[k].octets = procedure_heap_take(&heap, size);
        } else if ((next_random(&state) % 2U) == 0U) {
            procedure_heap_give(&heap, held[k].octets, held[k].size);
            held[k].octets = NULL;
        } else {
            uint8_t* const moved = procedure_heap_resize(&heap, held[k].octets, held[k].size, size);
            if (moved == NULL) {
                continue;
            }
            held[k].octets = moved;
        }
        if (held[k].octets != NULL) {
            held[k].size = size;
            held[k].mark = (uint8_t)i;
            TEST_ASSERT_EQUAL_UINT64(0U, (uintptr_t)held[k].octets % 8U);
            memset(held[k].octets, (int)held[k].mark, size);
        }
    }
    TEST_ASSERT_TRUE(heap.refused > 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_whole_heap_can_be_taken_and_given_back);
    RUN_TEST(a_block_that_is_too_large_is_refused);
    RUN_TEST(blocks_grow_and_shrink_with_their_content);
    RUN_TEST(blocks_never_overlap);
    return UNITY_END();
}
