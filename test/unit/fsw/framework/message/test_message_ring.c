// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_ring.h"

#include "test/support/assertion.h"
#include "test/support/consistent_message_ring.h"
#include "unity.h"

#include <string.h>

#define MODEL_BLOCKS 64U
#define MODEL_OCTETS 128U

void setUp(void)
{
}

void tearDown(void)
{
}

static uint32_t random_state = 1U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static void a_new_ring_is_empty(void)
{
    uint8_t storage[16];
    uint8_t octets[16];
    size_t size = 99U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, message_ring_take(&ring, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(12U, message_ring_room(&ring));
    TEST_ASSERT_TRUE(octet_ring_is_consistent(&ring));
}

static void a_block_fills_the_ring_to_the_last_octet(void)
{
    uint8_t storage[20];
    uint8_t octets[16];
    size_t size = 0U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    (void)memset(octets, 0xA5, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, 16U));
    TEST_ASSERT_EQUAL(0U, message_ring_room(&ring));
    TEST_ASSERT_EQUAL(STATUS_FULL, message_ring_put(&ring, octets, 0U));
    TEST_ASSERT_EQUAL(1U, ring.refused);
    TEST_ASSERT_EQUAL(20U, ring.peak);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(16U, size);
    TEST_ASSERT_EQUAL(16U, message_ring_room(&ring));
    TEST_ASSERT_EQUAL(STATUS_FULL, message_ring_put(&ring, octets, 17U));
}

static void empty_blocks_count_as_blocks(void)
{
    uint8_t storage[16];
    uint8_t octets[1];
    size_t size = 9U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, NULL, 0U));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, message_ring_put(&ring, NULL, 0U));
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, octets, sizeof octets, &size));
        TEST_ASSERT_EQUAL(0U, size);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, message_ring_take(&ring, octets, sizeof octets, &size));
}

static void a_block_too_large_for_the_reader_is_dropped_alone(void)
{
    uint8_t storage[64];
    uint8_t octets[8] = {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U};
    uint8_t out[8]    = {0};
    size_t size       = 9U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, 8U));
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, 3U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, message_ring_take(&ring, out, 7U, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(0U, out[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, out, 3U, &size));
    TEST_ASSERT_EQUAL(3U, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, out, 3U);
}

static void a_block_may_be_put_in_two_parts(void)
{
    static const uint8_t octets[8] = {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U};
    uint8_t storage[24];
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    for (size_t size = 0U; size <= sizeof octets; size++) { // Also across the end of the storage.
        for (size_t head_size = 0U; head_size <= sizeof octets; head_size++) {
            const size_t first = (size < head_size) ? size : head_size;
            uint8_t head[8]    = {0};
            uint8_t rest[8]    = {0};
            size_t size_out    = 99U;
            TEST_ASSERT_EQUAL(STATUS_OK,
                              message_ring_put_parts(&ring, octets, first, &octets[first], size - first));
            TEST_ASSERT_EQUAL(STATUS_OK,
                              message_ring_take_parts(&ring, head, head_size, rest, size - first, &size_out));
            TEST_ASSERT_EQUAL(size, size_out);
            TEST_ASSERT_TRUE(memcmp(octets, head, first) == 0);
            TEST_ASSERT_TRUE(memcmp(&octets[first], rest, size - first) == 0);
            // The rest does not fit completely: its head is stored, and the next block is unchanged.
            if (size > first) {
                TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, size));
                TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, message_ring_take_parts(&ring, head, head_size, rest,
                                                                            size - first - 1U, &size_out));
                TEST_ASSERT_EQUAL(size, size_out);
                TEST_ASSERT_TRUE(memcmp(octets, head, first) == 0);
            }
            TEST_ASSERT_EQUAL(STATUS_EMPTY, message_ring_take_parts(&ring, head, 8U, rest, 8U, &size_out));
            TEST_ASSERT_EQUAL(0U, size_out);
        }
    }
}

static void the_largest_block_is_read_unchanged(void)
{
    static uint8_t storage[65600];
    static uint8_t octets[65535];
    static uint8_t out[65535];
    size_t size = 0U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    for (size_t i = 0U; i < sizeof octets; i++) {
        octets[i] = (uint8_t)draw(256U);
    }
    // The second and third block cross the end of the storage.
    for (unsigned round = 0U; round < 3U; round++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, sizeof octets));
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, out, sizeof out, &size));
        TEST_ASSERT_EQUAL(sizeof octets, size);
        TEST_ASSERT_EQUAL(0, memcmp(octets, out, sizeof octets));
    }
}

typedef struct { // The model: a plain list.
    uint8_t octets[MODEL_BLOCKS][MODEL_OCTETS];
    size_t sizes[MODEL_BLOCKS];
    unsigned count;
    size_t used;
} model_t;

/// Put a random block into the ring and the model; both must accept or refuse it.
static void put_into_both(message_ring_t* ring, model_t* model, size_t capacity)
{
    uint8_t octets[MODEL_OCTETS];
    const size_t size = draw(MODEL_OCTETS);
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (uint8_t)draw(256U);
    }
    const bool fits = (model->used + size + 4U) <= capacity;
    TEST_ASSERT_EQUAL(fits, (message_ring_room(ring) >= size) && ((capacity - model->used) >= 4U));
    TEST_ASSERT_EQUAL(fits ? STATUS_OK : STATUS_FULL, message_ring_put(ring, octets, size));
    if (fits) {
        TEST_ASSERT_TRUE(model->count < MODEL_BLOCKS);
        (void)memcpy(model->octets[model->count], octets, size);
        model->sizes[model->count] = size;
        model->count++;
        model->used += size + 4U;
    }
}

static void take_from_both(message_ring_t* ring, model_t* model)
{
    uint8_t octets[MODEL_OCTETS] = {0};
    const size_t capacity        = draw(MODEL_OCTETS);
    size_t size                  = 0U;
    const status_t status        = message_ring_take(ring, octets, capacity, &size);
    if (model->count == 0U) {
        TEST_ASSERT_EQUAL(STATUS_EMPTY, status);
        return;
    }
    const bool fits = (model->sizes[0] <= capacity);
    TEST_ASSERT_EQUAL(fits ? STATUS_OK : STATUS_TOO_LARGE, status);
    TEST_ASSERT_EQUAL(fits ? model->sizes[0] : 0U, size);
    if (fits) {
        TEST_ASSERT_EQUAL(0, memcmp(model->octets[0], octets, size));
    }
    model->used -= model->sizes[0] + 4U;
    model->count--;
    (void)memmove(model->octets[0], model->octets[1], (MODEL_BLOCKS - 1U) * (size_t)MODEL_OCTETS);
    (void)memmove(&model->sizes[0], &model->sizes[1], (MODEL_BLOCKS - 1U) * sizeof model->sizes[0]);
}

static void compare_both(const message_ring_t* ring, const model_t* model)
{
    uint8_t octets[MODEL_OCTETS + 1U] = {0};
    const size_t capacity             = draw(MODEL_OCTETS);
    size_t size                       = 99U;
    octets[capacity]                  = 0xA5U;
    const status_t status             = message_ring_peek(ring, octets, capacity, &size);
    TEST_ASSERT_EQUAL((model->count > 0U) ? STATUS_OK : STATUS_EMPTY, status);
    TEST_ASSERT_EQUAL((model->count > 0U) ? model->sizes[0] : 0U, size);
    TEST_ASSERT_EQUAL(0, memcmp(model->octets[0], octets, (size < capacity) ? size : capacity));
    TEST_ASSERT_EQUAL_HEX8(0xA5U, octets[capacity]);
}

static void a_ring_behaves_like_a_list(void)
{
    static uint8_t storage[500];
    static model_t model;
    for (size_t capacity = 16U; capacity <= sizeof storage; capacity += 37U) {
        message_ring_t ring;
        message_ring_init(&ring, storage, capacity);
        (void)memset(&model, 0, sizeof model);
        for (unsigned step = 0U; step < 20000U; step++) {
            if (draw(100U) < 52U) {
                put_into_both(&ring, &model, capacity);
            } else {
                take_from_both(&ring, &model);
            }
            compare_both(&ring, &model);
            TEST_ASSERT_EQUAL(model.count, ring.blocks);
            TEST_ASSERT_EQUAL(model.used, ring.used);
            TEST_ASSERT_TRUE(ring.peak <= capacity);
            TEST_ASSERT_TRUE(octet_ring_is_consistent(&ring));
        }
    }
}

static void a_run_of_octets_fills_another_ring(void)
{
    uint8_t first_storage[32];
    uint8_t second_storage[32];
    uint8_t run[32];
    uint8_t block[8];
    size_t size = 0U;
    message_ring_t first;
    message_ring_t second;
    message_ring_init(&first, first_storage, sizeof first_storage);
    message_ring_init(&second, second_storage, sizeof second_storage);
    TEST_ASSERT_EQUAL(0U, message_ring_copy(&first, run, sizeof run));
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&first, (const uint8_t*)"abc", 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&first, (const uint8_t*)"defgh", 5U));
    TEST_ASSERT_EQUAL(0U, message_ring_copy(&first, run, 15U));
    TEST_ASSERT_EQUAL(16U, message_ring_copy(&first, run, sizeof run));
    for (size_t cut = 0U; cut < 16U; cut++) { // Truncated content is refused.
        message_ring_init(&second, second_storage, sizeof second_storage);
        message_ring_refill(&second, run, cut);
        TEST_ASSERT_EQUAL((cut >= 7U) ? 1U : 0U, second.blocks);
        TEST_ASSERT_EQUAL(((cut == 0U) || (cut == 7U)) ? 0U : 1U, second.refused);
    }
    message_ring_init(&second, second_storage, sizeof second_storage);
    message_ring_refill(&second, run, 16U);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&second, block, sizeof block, &size));
    TEST_ASSERT_EQUAL_MEMORY("abc", block, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&second, block, sizeof block, &size));
    TEST_ASSERT_EQUAL_MEMORY("defgh", block, 5U);
    message_ring_refill(&second, run, 16U);
    message_ring_refill(&second, run, 16U);
    message_ring_refill(&second, run, 16U); // Not enough room: the ring accepts all blocks in order, or none.
    TEST_ASSERT_EQUAL(4U, second.blocks);
    TEST_ASSERT_EQUAL(1U, second.refused);
    (void)memset(run, 0xFF, sizeof run);
    message_ring_init(&second, second_storage, sizeof second_storage);
    message_ring_refill(&second, run, sizeof run);
    TEST_ASSERT_EQUAL(0U, second.blocks);
}

static void the_self_test_detects_damage(void)
{
    static const uint8_t octets[6] = {0};
    uint8_t storage[64];
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, 5U));
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, octets, 6U));
    storage[3]++; // Length of the first block.
    TEST_ASSERT_FALSE(octet_ring_is_consistent(&ring));
    storage[3]--;
    ring.blocks++;
    TEST_ASSERT_FALSE(octet_ring_is_consistent(&ring));
}

static void blocks_are_read_in_place(void)
{
    uint8_t storage[40];
    uint8_t head[3];
    uint8_t octets[16];
    size_t size = 0U;
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    for (uint8_t round = 0U; round < 40U; round++) { // Across the end of the storage, too.
        for (uint8_t i = 0U; i < 3U; i++) {
            const uint8_t block[6] = {round, i, 2U, 3U, 4U, 5U};
            TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, block, (size_t)(2U + (2U * i))));
        }
        size_t offset = 0U;
        for (uint8_t i = 0U; i < 3U; i++) {
            const uint8_t mark[2] = {(uint8_t)(100U + i), i};
            message_ring_overwrite(&ring, offset, mark, sizeof mark);
            offset = message_ring_look(&ring, offset, head, sizeof head, &size);
            TEST_ASSERT_EQUAL(2U + (2U * i), size);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(mark, head, sizeof mark);
        }
        TEST_ASSERT_EQUAL(ring.used, offset);
        for (uint8_t i = 0U; i < 3U; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, octets, sizeof octets, &size));
            TEST_ASSERT_EQUAL(100U + i, octets[0]);
        }
    }
}

static void put_too_large(void)
{
    static uint8_t storage[70000];
    message_ring_t ring;
    message_ring_init(&ring, storage, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(&ring, storage, 65536U));
}

static void init_too_small(void)
{
    uint8_t storage[16];
    message_ring_t ring;
    message_ring_init(&ring, storage, 15U);
}

static void coding_errors_are_caught(void)
{
    TEST_ASSERT_TRUE(assertion_fails(put_too_large));
    TEST_ASSERT_TRUE(assertion_fails(init_too_small));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_new_ring_is_empty);
    RUN_TEST(a_block_fills_the_ring_to_the_last_octet);
    RUN_TEST(empty_blocks_count_as_blocks);
    RUN_TEST(a_block_too_large_for_the_reader_is_dropped_alone);
    RUN_TEST(a_block_may_be_put_in_two_parts);
    RUN_TEST(the_largest_block_is_read_unchanged);
    RUN_TEST(a_ring_behaves_like_a_list);
    RUN_TEST(blocks_are_read_in_place);
    RUN_TEST(a_run_of_octets_fills_another_ring);
    RUN_TEST(the_self_test_detects_damage);
    RUN_TEST(coding_errors_are_caught);
    return UNITY_END();
}
