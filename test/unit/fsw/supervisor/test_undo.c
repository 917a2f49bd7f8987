// SPDX-License-Identifier: Apache-2.0
// When the next life opens a medium, writes that were not committed are undone.
#include "fsw/supervisor/undo.h"

#include "test/support/recorded_media.h"
#include "unity.h"

#include <string.h>

static checkpoint_t checkpoint;
static checkpoint_state_t state;
static undo_medium_t storage[2];
static medium_t inner;
static medium_t medium; // The medium with the undo record.
static bool fails;      // Reads and some queries of the size fail.
static uint32_t random_state = 5U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static status_t read_inner(void* context, uint64_t offset, uint8_t* octets, size_t size)
{
    return fails ? STATUS_IO : recorded_medium(0U).read(context, offset, octets, size);
}

static status_t size_of_inner(void* context, uint64_t* out_size)
{
    return (fails && (draw(2U) == 0U)) ? STATUS_IO : recorded_medium(0U).size(context, out_size);
}

static void open_medium(void)
{
    medium = supervisor_undo_open(&storage[0], &checkpoint, 0U, &inner);
}

static void commit(void)
{
    const checkpoint_rings_t rings = {{NULL}};
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
}

void setUp(void)
{
    static const image_t empty[2];
    recorded_clear(empty);
    (void)memset(&checkpoint, 0, sizeof checkpoint);
    inner      = recorded_medium(0U);
    inner.read = read_inner;
    inner.size = size_of_inner;
    fails      = false;
    commit();
    open_medium();
}

void tearDown(void)
{
}

static void write_text(uint64_t offset, const char* text)
{
    TEST_ASSERT_EQUAL(STATUS_OK, medium.write(medium.context, offset, (const uint8_t*)text, strlen(text)));
}

static void expect_text(const char* text)
{
    TEST_ASSERT_EQUAL(strlen(text), recorded.image[0].size);
    TEST_ASSERT_EQUAL(0, memcmp(text, recorded.image[0].octets, strlen(text)));
}

static void a_restart_restores_the_committed_content(void)
{
    write_text(0U, "abcdef");
    commit();
    write_text(2U, "XY");
    write_text(5U, "Z12");
    TEST_ASSERT_EQUAL(STATUS_OK, medium.resize(medium.context, 3U));
    write_text(3U, "!");
    TEST_ASSERT_EQUAL(STATUS_OK, medium.resize(medium.context, 9U));
    open_medium();
    expect_text("abcdef");
    open_medium(); // The process has died again before a commit.
    expect_text("abcdef");
}

static void the_other_functions_are_those_of_the_inner_medium(void)
{
    uint8_t octets[3];
    uint64_t size = 0U;
    write_text(0U, "abc");
    TEST_ASSERT_EQUAL(STATUS_OK, medium.sync(medium.context));
    TEST_ASSERT_EQUAL(STATUS_OK, medium.size(medium.context, &size));
    TEST_ASSERT_EQUAL(3U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, medium.read(medium.context, 0U, octets, sizeof octets));
    TEST_ASSERT_EQUAL_MEMORY("abc", octets, 3U);
    const medium_t bare = supervisor_undo_open(&storage[0], NULL, 0U, &inner);
    TEST_ASSERT_EQUAL_PTR(inner.context, bare.context);
}

static void each_medium_has_its_own_undo_record(void)
{
    write_text(0U, "abc");
    const medium_t second    = recorded_medium(1U);
    const medium_t of_second = supervisor_undo_open(&storage[1], &checkpoint, 1U, &second);
    TEST_ASSERT_EQUAL(STATUS_OK, of_second.write(of_second.context, 0U, (const uint8_t*)"12", 2U));
    (void)supervisor_undo_open(&storage[1], &checkpoint, 1U, &second);
    TEST_ASSERT_EQUAL(0U, recorded.image[1].size);
    expect_text("abc");
}

/// More than UNDO_CUT_MAX octets that emptying removes are not restored. Octets written later never remain.
static void octets_written_after_emptying_do_not_reappear(void)
{
    static uint8_t octets[UNDO_CUT_MAX + 1U];
    (void)memset(octets, 'a', sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK, medium.write(medium.context, 0U, octets, sizeof octets));
    commit();
    TEST_ASSERT_EQUAL(STATUS_OK, medium.resize(medium.context, 0U));
    write_text(0U, "xyz");
    open_medium();
    expect_text("");
    TEST_ASSERT_EQUAL(STATUS_OK, medium.write(medium.context, 0U, octets, UNDO_CUT_MAX));
    commit();
    TEST_ASSERT_EQUAL(STATUS_OK, medium.resize(medium.context, 0U));
    open_medium();
    TEST_ASSERT_EQUAL(UNDO_CUT_MAX, recorded.image[0].size);
    TEST_ASSERT_EQUAL_MEMORY(octets, recorded.image[0].octets, UNDO_CUT_MAX);
}

static void writes_continue_if_the_undo_record_fails(void)
{
    write_text(0U, "abcdef");
    commit();
    fails = true;
    for (unsigned i = 0U; i < 50U; i++) {
        write_text(1U, "X");
    }
    open_medium();
    fails = false;
    expect_text("aXcdef");
}

static void a_damaged_block_changes_nothing(void)
{
    write_text(0U, "abc");
    commit();
    TEST_ASSERT_TRUE(
        supervisor_checkpoint_add(&checkpoint, &checkpoint.undo, (const uint8_t*)"\0\0", 2U, NULL, 0U));
    open_medium();
    expect_text("abc");
}

static void random_writes_are_undone(void)
{
    static image_t before;
    uint8_t octets[3000];
    for (unsigned i = 0U; i < 500U; i++) {
        const bool is_dying = (draw(3U) == 0U);
        before              = recorded.image[0];
        for (uint32_t left = draw(6U); left > 0U; left--) {
            (void)memset(octets, (int)draw(256U), sizeof octets);
            const uint32_t offset = draw(20000U);
            const status_t status =
                (draw(5U) == 0U) ? medium.resize(medium.context, offset)
                                 : medium.write(medium.context, offset, octets, 1U + draw(sizeof octets));
            TEST_ASSERT_EQUAL(STATUS_OK, status);
        }
        if (is_dying) {
            open_medium();
            TEST_ASSERT_EQUAL(before.size, recorded.image[0].size);
            TEST_ASSERT_EQUAL(0, memcmp(before.octets, recorded.image[0].octets, before.size));
        }
        commit();
        recorded.count     = 0U; // The list of the writes is not needed.
        recorded.data_size = 0U;
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_restart_restores_the_committed_content);
    RUN_TEST(the_other_functions_are_those_of_the_inner_medium);
    RUN_TEST(each_medium_has_its_own_undo_record);
    RUN_TEST(octets_written_after_emptying_do_not_reappear);
    RUN_TEST(writes_continue_if_the_undo_record_fails);
    RUN_TEST(a_damaged_block_changes_nothing);
    RUN_TEST(random_writes_are_undone);
    return UNITY_END();
}
