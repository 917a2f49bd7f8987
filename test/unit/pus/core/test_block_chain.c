// SPDX-License-Identifier: Apache-2.0
// Records in chains of blocks from a common pool.
#include "pus/core/block_chain.h"

#include "unity.h"

#include <string.h>

#define BLOCKS 5U
#define OCTETS (BLOCKS * PUS_BLOCK_CHAIN_BLOCK)

static uint64_t storage[PUS_BLOCK_CHAIN_WORDS(BLOCKS)];
static pool_slot_t slots[BLOCKS];
static pus_block_chains_t chains;
static uint8_t octets[OCTETS + 1U];

void setUp(void)
{
    pus_block_chains_init(&chains, storage, slots, BLOCKS);
    for (size_t i = 0U; i < sizeof octets; i++) {
        octets[i] = (uint8_t)(i * 7U);
    }
}

void tearDown(void)
{
}

static void expect_content(const pus_block_chain_t* const chain, const size_t size, const size_t part)
{
    uint8_t found[OCTETS];
    pus_block_chain_reader_t reader = pus_block_chain_reader(chain);
    size_t done                     = 0U;
    size_t read                     = 1U;
    while (read > 0U) {
        read = pus_block_chain_read(&reader, &found[done], part);
        done += read;
    }
    TEST_ASSERT_EQUAL_UINT64(size, done);
    TEST_ASSERT_EQUAL_UINT32(0U, reader.left);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, found, size);
}

static void every_size_of_record_is_read_back_in_parts_of_any_size(void)
{
    static const size_t parts[] = {1U, 7U, 55U, 56U, 57U, OCTETS};
    for (size_t size = 1U; size <= OCTETS; size++) {
        pus_block_chain_t chain = {0};
        TEST_ASSERT_EQUAL(STATUS_OK, pus_block_chain_append(&chains, &chain, octets, size));
        TEST_ASSERT_EQUAL_UINT32(size, chain.size);
        TEST_ASSERT_EQUAL_UINT16(PUS_BLOCK_CHAIN_BLOCKS(size), chains.pool.stats.taken);
        for (size_t i = 0U; i < (sizeof parts / sizeof parts[0]); i++) {
            expect_content(&chain, size, parts[i]);
        }
        pus_block_chain_free(&chains, &chain);
        TEST_ASSERT_EQUAL_UINT16(0U, chains.pool.stats.taken);
        TEST_ASSERT_EQUAL_UINT32(0U, chain.size);
    }
}

static void a_chain_grows_until_no_block_is_free(void)
{
    for (size_t step = 1U; step < OCTETS; step += 13U) {
        pus_block_chain_t chain = {0};
        size_t size             = 0U;
        for (; (size + step) <= OCTETS; size += step) {
            TEST_ASSERT_EQUAL(STATUS_OK, pus_block_chain_append(&chains, &chain, &octets[size], step));
        }
        TEST_ASSERT_EQUAL(((size + step) > OCTETS) ? STATUS_EXHAUSTED : STATUS_OK,
                          pus_block_chain_append(&chains, &chain, &octets[size % OCTETS], step));
        expect_content(&chain, size, OCTETS); // A refusal changes nothing.
        pus_block_chain_free(&chains, &chain);
    }
}

static void chains_share_the_blocks(void)
{
    pus_block_chain_t one   = {0};
    pus_block_chain_t other = {0};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_block_chain_append(&chains, &one, octets, 3U * PUS_BLOCK_CHAIN_BLOCK));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_block_chain_append(&chains, &other, octets, 2U * PUS_BLOCK_CHAIN_BLOCK));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_block_chain_append(&chains, &other, octets, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_block_chain_append(&chains, &other, octets, 0U));
    pus_block_chain_free(&chains, &one);
    expect_content(&other, 2U * PUS_BLOCK_CHAIN_BLOCK, 20U);
    TEST_ASSERT_EQUAL(
        STATUS_OK, pus_block_chain_append(&chains, &other, &octets[other.size], 3U * PUS_BLOCK_CHAIN_BLOCK));
    expect_content(&other, OCTETS, OCTETS);
    pus_block_chain_free(&chains, &one); // The chain is already empty.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_size_of_record_is_read_back_in_parts_of_any_size);
    RUN_TEST(a_chain_grows_until_no_block_is_free);
    RUN_TEST(chains_share_the_blocks);
    return UNITY_END();
}
