// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/xml/xml_arena.h"

#include "unity.h"

#include <stdbool.h>
#include <string.h>

#define WORDS 128U
#define ALIGNMENT 16U

static uint64_t words[WORDS + 2U];
static xml_arena_t arena;

/// Open an arena of whole words that begins at `first`.
static void open_arena(const size_t first, const size_t count)
{
    arena = (xml_arena_t){.words = &words[first], .capacity = count * sizeof words[0]};
    xml_arena_reset(&arena);
    xml_arena_enter(&arena);
}

void setUp(void)
{
    (void)memset(words, 0, sizeof words);
    open_arena(0U, WORDS);
}

void tearDown(void)
{
    xml_arena_leave();
}

static bool is_aligned(const void* const block)
{
    return ((uintptr_t)block % ALIGNMENT) == 0U;
}

static void blocks_are_aligned_wherever_the_arena_begins(void)
{
    for (size_t first = 0U; first < 2U; first++) {
        xml_arena_leave();
        open_arena(first, WORDS);
        for (size_t octets = 0U; octets < 20U; octets++) {
            const uint8_t* const block = xml_arena_take(octets);
            TEST_ASSERT_NOT_NULL(block);
            TEST_ASSERT_TRUE(is_aligned(block));
            TEST_ASSERT_TRUE((block + octets) <= (const uint8_t*)(&words[first + WORDS]));
        }
    }
}

static void the_newest_block_grows_in_place(void)
{
    char* const block = xml_arena_take(4U);
    (void)memcpy(block, "abc", 4U);
    TEST_ASSERT_EQUAL_PTR(block, xml_arena_resize(block, 500U));
    TEST_ASSERT_EQUAL_STRING("abc", block);
    TEST_ASSERT_NOT_NULL(xml_arena_take(100U)); // A block after the first one.
    TEST_ASSERT_EQUAL_STRING("abc", block);
}

static void an_older_block_moves_with_its_content(void)
{
    char* const block = xml_arena_take(4U);
    (void)memcpy(block, "abc", 4U);
    char* const newer = xml_arena_take(4U);
    (void)memcpy(newer, "xyz", 4U);
    char* const moved = xml_arena_resize(block, 40U);
    TEST_ASSERT_NOT_NULL(moved);
    TEST_ASSERT_TRUE((moved != block) && (moved != newer) && is_aligned(moved));
    TEST_ASSERT_EQUAL_STRING("abc", moved);
    TEST_ASSERT_EQUAL_STRING("xyz", newer);
}

static void a_block_that_still_fits_is_not_moved(void)
{
    char* const block = xml_arena_take(20U);
    (void)xml_arena_take(1U);
    TEST_ASSERT_EQUAL_PTR(block, xml_arena_resize(block, 3U));
    // A block of 20 octets occupies 32, because sizes are multiples of 16.
    TEST_ASSERT_EQUAL_PTR(block, xml_arena_resize(block, 32U));
}

static void resizing_no_block_takes_a_new_one(void)
{
    TEST_ASSERT_TRUE(is_aligned(xml_arena_resize(NULL, 8U)));
    TEST_ASSERT_EQUAL_UINT64(2U * ALIGNMENT, arena.used); // The block and its size field.
}

static void an_allocation_that_does_not_fit_changes_nothing(void)
{
    char* const older = xml_arena_take(4U);
    char* const block = xml_arena_take(4U);
    (void)memcpy(older, "old", 4U);
    (void)memcpy(block, "abc", 4U);
    const size_t used           = arena.used;
    static const size_t sizes[] = {WORDS * 8U, SIZE_MAX / 2U, (SIZE_MAX / 2U) + 1U, SIZE_MAX - 1U, SIZE_MAX};
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        TEST_ASSERT_NULL(xml_arena_take(sizes[i]));
        TEST_ASSERT_NULL(xml_arena_resize(block, sizes[i]));
        TEST_ASSERT_NULL(xml_arena_resize(older, sizes[i]));
        TEST_ASSERT_EQUAL_UINT64(used, arena.used);
    }
    TEST_ASSERT_EQUAL_STRING("abc", block);
    TEST_ASSERT_EQUAL_STRING("old", older);
    TEST_ASSERT_EQUAL_PTR(block, xml_arena_resize(block, 8U));
}

static void only_the_newest_block_can_be_freed_alone(void)
{
    void* const older = xml_arena_take(16U);
    void* const newer = xml_arena_take(16U);
    const size_t used = arena.used;
    xml_arena_give(NULL);
    xml_arena_give(older);
    TEST_ASSERT_EQUAL_UINT64(used, arena.used);
    xml_arena_give(newer);
    TEST_ASSERT_EQUAL_PTR(newer, xml_arena_take(16U));
    xml_arena_reset(&arena);
    TEST_ASSERT_EQUAL_PTR(older, xml_arena_take(16U));
    TEST_ASSERT_EQUAL_UINT64(used / 2U, arena.used);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(blocks_are_aligned_wherever_the_arena_begins);
    RUN_TEST(the_newest_block_grows_in_place);
    RUN_TEST(an_older_block_moves_with_its_content);
    RUN_TEST(a_block_that_still_fits_is_not_moved);
    RUN_TEST(resizing_no_block_takes_a_new_one);
    RUN_TEST(an_allocation_that_does_not_fit_changes_nothing);
    RUN_TEST(only_the_newest_block_can_be_freed_alone);
    return UNITY_END();
}
