// SPDX-License-Identifier: Apache-2.0
// A packet store on a recorded medium: order, times, deletion, recovery, damage and failures of the medium.
#include "pus/core/packet_store.h"

#include "base/crc.h"
#include "test/support/assertion.h"
#include "test/support/recorded_media.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 7U
#define SMALL 90U
#define LARGE 4000U // Size of a packet; four of them fill a block.
#define AROUND 14U  // Octets of a record around its packet.
#define FIRST_AT 56U
#define GENERATION 3U

static const image_t empty[2];

static pus_packet_store_t store;
static pus_store_block_t blocks[CAPACITY];
static uint8_t buffer[PUS_STORE_BUFFER_SIZE];
static pus_stored_packet_t found;

static void init(void)
{
    const pus_packet_store_config_t config = {
        .medium = recorded_medium(0U), .blocks = blocks, .block_capacity = CAPACITY, .buffer = buffer};
    pus_packet_store_init(&store, &config);
}

void setUp(void)
{
    recorded_clear(empty);
    init();
    pus_packet_store_create(&store, GENERATION, 3U, true);
}

void tearDown(void)
{
}

/// Returns packet `index`, whose octets identify it.
static const uint8_t* packet_of(const unsigned index, const size_t size)
{
    static uint8_t packet[PUS_PACKET_MAX];
    for (size_t i = 0U; i < size; i++) {
        packet[i] = (uint8_t)((index * 7U) + i);
    }
    packet[0] = (uint8_t)index;
    return packet;
}

/// Store packet `index` at the time `index`.
static status_t append(const unsigned index, const size_t size)
{
    return pus_packet_store_append(&store, index, packet_of(index, size), size);
}

static void fill(const unsigned first, const unsigned last, const size_t size)
{
    for (unsigned i = first; i <= last; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, append(i, size));
    }
}

static status_t reopen(const uint16_t limit, const bool is_circular, const uint64_t tail)
{
    init();
    memset(blocks, 0xA5, sizeof blocks);
    return pus_packet_store_open(&store, GENERATION, limit, is_circular, tail);
}

/// Expect that this packet is the next one at the cursor.
static void expect_packet(uint64_t* const cursor, const unsigned index, const size_t size)
{
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_next(&store, cursor, &found));
    TEST_ASSERT_EQUAL_UINT64(index, found.time_ns);
    TEST_ASSERT_EQUAL_UINT64(size, found.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet_of(index, size), found.packet, size);
}

/// Expect exactly these packets in the store.
static void expect_content(const unsigned first, const unsigned last, const size_t size)
{
    uint64_t cursor = 0U;
    for (unsigned i = first; i <= last; i++) {
        expect_packet(&cursor, i, size);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, pus_packet_store_next(&store, &cursor, &found));
    TEST_ASSERT_EQUAL_UINT64(first, pus_packet_store_oldest_ns(&store));
    TEST_ASSERT_EQUAL_UINT64(last, pus_packet_store_newest_ns(&store));
}

static void expect_nothing(void)
{
    uint64_t cursor = 0U;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, pus_packet_store_next(&store, &cursor, &found));
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_tail(&store), pus_packet_store_head(&store));
    TEST_ASSERT_EQUAL_UINT64(0U, pus_packet_store_oldest_ns(&store));
    TEST_ASSERT_EQUAL_UINT64(0U, pus_packet_store_newest_ns(&store));
}

static void packets_are_read_unchanged(void)
{
    static const size_t sizes[] = {1U, 23U, SMALL, PUS_PACKET_MAX, 2U};
    expect_nothing();
    for (unsigned i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, append(i, sizes[i]));
    }
    uint64_t cursor = 0U;
    for (unsigned i = 0U; i < 5U; i++) {
        expect_packet(&cursor, i, sizes[i]);
    }
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), cursor);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, pus_packet_store_next(&store, &cursor, &found));
    TEST_ASSERT_EQUAL(STATUS_OK, append(9U, SMALL));
    expect_packet(&cursor, 9U, SMALL);
    cursor = 0U;
    expect_packet(&cursor, 0U, 1U);
    // `found` is the packet that was just read from the store.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_append(&store, 1U, found.packet, found.size));
    TEST_ASSERT_EQUAL_UINT32(7U, store.counters.stored);
}

/// A packet that just fits is stored in the present block; a packet longer by one octet begins the next
/// block.
static void a_block_is_filled_to_its_last_octet(void)
{
    const size_t rest = PUS_STORE_BLOCK - FIRST_AT - (4U * (LARGE + AROUND)) - AROUND;
    fill(1U, 4U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, append(5U, rest));
    TEST_ASSERT_EQUAL_UINT16(1U, pus_packet_store_blocks_used(&store));
    TEST_ASSERT_EQUAL_UINT64(PUS_STORE_BLOCK, recorded.image[0].size);
    fill(6U, 9U, LARGE);
    TEST_ASSERT_EQUAL_UINT16(2U, pus_packet_store_blocks_used(&store));
    TEST_ASSERT_EQUAL(STATUS_OK, append(10U, rest + 1U));
    TEST_ASSERT_EQUAL_UINT16(3U, pus_packet_store_blocks_used(&store));
    uint64_t cursor = 0U;
    for (unsigned i = 1U; i <= 10U; i++) {
        expect_packet(&cursor, i, (i == 5U) ? rest : ((i == 10U) ? (rest + 1U) : LARGE));
    }
}

static void a_circular_store_overwrites_its_oldest_block(void)
{
    fill(1U, 12U, LARGE);
    expect_content(1U, 12U, LARGE);
    const uint64_t before = pus_packet_store_tail(&store);
    fill(13U, 13U, LARGE);
    expect_content(5U, 13U, LARGE);
    TEST_ASSERT_EQUAL_UINT64(before + PUS_STORE_BLOCK, pus_packet_store_tail(&store));
    fill(14U, 40U, LARGE);
    expect_content(29U, 40U, LARGE);
    TEST_ASSERT_EQUAL_UINT32(28U, store.counters.overwritten);
    TEST_ASSERT_EQUAL_UINT32(0U, store.counters.refused);
    // If the position of a reader was overwritten, the reader continues with the oldest packet.
    uint64_t late = before;
    expect_packet(&late, 29U, LARGE);
    TEST_ASSERT_TRUE(recorded.image[0].size <= (3U * PUS_STORE_BLOCK));
}

static void a_bounded_store_takes_no_more(void)
{
    pus_packet_store_change(&store, 2U, false);
    fill(1U, 8U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_FULL, append(9U, LARGE));
    TEST_ASSERT_EQUAL(STATUS_OK, append(9U, 200U)); // There is room for one more packet.
    TEST_ASSERT_EQUAL(STATUS_FULL, append(10U, 200U));
    TEST_ASSERT_EQUAL_UINT32(2U, store.counters.refused);
    TEST_ASSERT_EQUAL_UINT16(2U, pus_packet_store_blocks_used(&store));
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 4U)); // This releases a block.
    TEST_ASSERT_EQUAL_UINT16(1U, pus_packet_store_blocks_used(&store));
    TEST_ASSERT_EQUAL(STATUS_OK, append(10U, LARGE));
    TEST_ASSERT_TRUE(recorded.image[0].size <= (2U * PUS_STORE_BLOCK));
    pus_packet_store_change(&store, 3U, false);
    fill(11U, 17U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_FULL, append(18U, LARGE));
}

static void content_is_deleted_up_to_a_time(void)
{
    fill(1U, 12U, LARGE);
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_tail(&store), pus_packet_store_find_after(&store, 0U));
    for (unsigned time = 1U; time < 12U; time++) {
        pus_packet_store_cut(&store, pus_packet_store_find_after(&store, time));
        expect_content(time + 1U, 12U, LARGE);
        TEST_ASSERT_EQUAL_UINT16(3U - (time / 4U), pus_packet_store_blocks_used(&store));
    }
    pus_packet_store_cut(&store, 0U); // No packet is before the tail, so none is removed.
    expect_content(12U, 12U, LARGE);
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 12U));
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), pus_packet_store_find_after(&store, 99U));
    fill(13U, 14U, LARGE);
    expect_content(13U, 14U, LARGE);
}

static void times_are_found_without_reading_the_rest(void)
{
    pus_packet_store_change(&store, CAPACITY, false);
    fill(1U, 28U, LARGE);
    for (unsigned time = 0U; time <= 28U; time++) {
        recorded.calls         = 0U;
        const uint64_t address = pus_packet_store_find(&store, time);
        const unsigned reads   = recorded.calls;
        uint64_t cursor        = address;
        expect_packet(&cursor, (time > 0U) ? time : 1U, LARGE);
        TEST_ASSERT_TRUE(reads <= 4U);
        recorded.calls = 0U;
        TEST_ASSERT_TRUE(pus_packet_store_seek(&store, 0U, 1U, time + 1U) <= cursor);
        TEST_ASSERT_EQUAL_UINT(0U, recorded.calls);
    }
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), pus_packet_store_find(&store, 29U));
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), pus_packet_store_seek(&store, 0U, 0U, 0U));
}

/// The clock jumps far ahead and back; packets in between are found by their storage times.
static void times_need_not_increase(void)
{
    pus_packet_store_change(&store, CAPACITY, false);
    fill(10U, 13U, LARGE);
    fill(1000U, 1003U, LARGE);
    fill(14U, 20U, LARGE);
    TEST_ASSERT_EQUAL_UINT64(20U, pus_packet_store_newest_ns(&store));
    uint64_t cursor = pus_packet_store_seek(&store, 0U, 15U, 16U);
    expect_packet(&cursor, 14U, LARGE);
    cursor = pus_packet_store_find(&store, 1002U);
    expect_packet(&cursor, 1002U, LARGE);
    // The deletion ends at the first later packet.
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 500U));
    TEST_ASSERT_EQUAL_UINT64(1000U, pus_packet_store_oldest_ns(&store));
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 1002U));
    TEST_ASSERT_EQUAL_UINT64(1003U, pus_packet_store_oldest_ns(&store));
    cursor = pus_packet_store_find_after(&store, 1003U);
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), cursor);
    pus_packet_store_cut(&store, cursor);
    fill(30U, 30U, LARGE);
    fill(21U, 22U, SMALL);
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 30U));
    expect_nothing();
}

static void a_search_skips_a_block_whose_latest_packet_is_deleted(void)
{
    pus_packet_store_change(&store, CAPACITY, false);
    fill(100U, 100U, LARGE);
    fill(1U, 7U, LARGE);
    uint64_t cursor = 0U;
    expect_packet(&cursor, 100U, LARGE);
    pus_packet_store_cut(&store, cursor);
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), pus_packet_store_find_after(&store, 50U));
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_head(&store), pus_packet_store_find(&store, 50U));
    cursor = pus_packet_store_find_after(&store, 5U);
    expect_packet(&cursor, 6U, LARGE);
}

static void a_store_is_recovered(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U)); // The medium is empty.
    expect_nothing();
    for (unsigned last = 1U; last <= 30U; last++) {
        TEST_ASSERT_EQUAL(STATUS_OK, append(last, LARGE));
        TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U));
        const unsigned first = (last <= 12U) ? 1U : ((((last - 1U) / 4U) * 4U) - 7U);
        expect_content(first, last, LARGE);
    }
    const uint64_t tail = pus_packet_store_find_after(&store, 25U);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, tail));
    expect_content(26U, 30U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(2U, true, tail)); // A smaller store drops its oldest packets.
    expect_content(26U, 30U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_open(&store, GENERATION + 1U, 3U, true, 0U));
    expect_nothing(); // The record belongs to another store.
}

static void deleted_packets_stay_deleted_after_reopening(void)
{
    fill(1U, 12U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, false, pus_packet_store_find_after(&store, 9U)));
    expect_content(10U, 12U, LARGE);
    TEST_ASSERT_EQUAL_UINT16(1U, pus_packet_store_blocks_used(&store));
    fill(13U, 20U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_FULL, append(21U, LARGE));
    const uint64_t head = pus_packet_store_head(&store);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, false, head));
    expect_nothing();
    // The deletion was recorded, but the deleted packets are still on the medium: numbers continue after
    // them.
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, false, head + 4000U));
    expect_nothing();
    fill(30U, 32U, LARGE);
    TEST_ASSERT_TRUE(pus_packet_store_tail(&store) > (head + 4000U));
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, false, head + 4000U));
    expect_content(30U, 32U, LARGE);
}

static void a_resized_store_is_recovered(void)
{
    pus_packet_store_change(&store, CAPACITY, true);
    fill(1U, 28U, LARGE);
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 20U));
    const uint64_t tail = pus_packet_store_tail(&store);
    pus_packet_store_change(&store, 2U, true);
    expect_content(21U, 28U, LARGE);
    fill(29U, 33U, LARGE);
    expect_content(29U, 33U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(2U, true, tail));
    expect_content(29U, 33U, LARGE); // Blocks that were released before do not reappear.
}

/// An earlier configuration has filled the medium with more blocks than the present one has room for.
static void blocks_beyond_the_capacity_are_not_read(void)
{
    pus_store_block_t beyond;
    pus_packet_store_change(&store, CAPACITY, true);
    fill(1U, 28U, LARGE);
    memset(blocks, 0xA5, sizeof blocks);
    memcpy(&beyond, &blocks[CAPACITY - 1U], sizeof beyond);
    const pus_packet_store_config_t config = {
        .medium = recorded_medium(0U), .blocks = blocks, .block_capacity = CAPACITY - 1U, .buffer = buffer};
    pus_packet_store_init(&store, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_open(&store, GENERATION, CAPACITY - 1U, true, 0U));
    TEST_ASSERT_EQUAL_MEMORY(&beyond, &blocks[CAPACITY - 1U], sizeof beyond);
    TEST_ASSERT_TRUE(pus_packet_store_blocks_used(&store) <= (CAPACITY - 1U));
}

/// Change one octet of the medium.
static void damage_octet(const size_t offset)
{
    recorded.image[0].octets[offset] ^= 0x10U;
}

static void damage_loses_the_rest_of_its_block(void)
{
    fill(1U, 12U, LARGE);
    damage_octet(FIRST_AT + AROUND + LARGE + 100U); // Damage the second packet.
    uint64_t cursor = 0U;
    expect_packet(&cursor, 1U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_CHECKSUM, pus_packet_store_next(&store, &cursor, &found));
    expect_packet(&cursor, 5U, LARGE);
    TEST_ASSERT_EQUAL_UINT32(1U, store.counters.damaged);
    cursor = pus_packet_store_find(&store, 2U);
    expect_packet(&cursor, 5U, LARGE);
    damage_octet(FIRST_AT); // The size becomes larger than any record.
    TEST_ASSERT_EQUAL_UINT64(0U, pus_packet_store_oldest_ns(&store));
    pus_packet_store_cut(&store, pus_packet_store_find_after(&store, 3U));
    expect_content(5U, 12U, LARGE);
    damage_octet(PUS_STORE_BLOCK + FIRST_AT + 1U);
    recorded.image[0].octets[PUS_STORE_BLOCK + FIRST_AT]      = 0U;
    recorded.image[0].octets[PUS_STORE_BLOCK + FIRST_AT + 1U] = 0U; // The record contains no packet.
    TEST_ASSERT_EQUAL_UINT64(0U, pus_packet_store_oldest_ns(&store));
}

static void a_damaged_header_ends_the_chain(void)
{
    fill(1U, 12U, LARGE);
    static image_t image; // Too large for the stack of a board.
    image = recorded.image[0];
    // Octets of the magic number, the generation, the block number and the checksum.
    static const size_t offsets[] = {0U, 4U, 8U, 15U, 19U};
    for (size_t i = 0U; i < (sizeof offsets / sizeof offsets[0]); i++) {
        recorded.image[0] = image;
        damage_octet(PUS_STORE_BLOCK + offsets[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U));
        expect_content(9U, 12U, LARGE);
        TEST_ASSERT_EQUAL_UINT32(1U, store.counters.damaged); // The damaged header hides the block before it.
        TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 2U * (uint64_t)PUS_STORE_BLOCK));
        // The packets of that block were already deleted.
        TEST_ASSERT_EQUAL_UINT32(0U, store.counters.damaged);
    }
    // Octets that were written when the block was closed: if they are damaged, its records are read.
    static const size_t closings[] = {20U, 30U, 33U, 50U, 55U};
    for (size_t i = 0U; i < (sizeof closings / sizeof closings[0]); i++) {
        recorded.image[0] = image;
        damage_octet(PUS_STORE_BLOCK + closings[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U));
        expect_content(1U, 12U, LARGE);
    }
}

static void a_failing_medium_keeps_the_stored_packets(void)
{
    fill(1U, 4U, LARGE);
    // The five calls are closing, sync, header, sync and record.
    for (unsigned call = 1U; call <= 5U; call++) {
        recorded.calls     = 0U;
        recorded.fail_from = call;
        TEST_ASSERT_EQUAL(STATUS_IO, append(5U, LARGE));
        expect_content(1U, 4U, LARGE);
        TEST_ASSERT_EQUAL_UINT32(call, store.counters.failed);
    }
    recorded.fail_from = 0U;
    fill(5U, 12U, LARGE);
    recorded.failure = STATUS_FULL;
    for (unsigned call = 3U; call <= 4U; call++) {
        recorded.calls     = 0U;
        recorded.fail_from = call;
        TEST_ASSERT_EQUAL(STATUS_FULL, append(13U, LARGE));
        expect_content(5U, 12U, LARGE); // Only one block is given up, not one for each attempt.
    }
    recorded.failure   = STATUS_IO;
    recorded.calls     = 0U;
    recorded.fail_from = 1U;
    uint64_t cursor    = pus_packet_store_tail(&store);
    TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_next(&store, &cursor, &found));
    expect_packet(&cursor, 5U, LARGE);
    recorded.calls = 0U;
    TEST_ASSERT_EQUAL_UINT64(pus_packet_store_tail(&store), pus_packet_store_find_after(&store, 7U));
    TEST_ASSERT_EQUAL(STATUS_OK, append(13U, SMALL));
    recorded.calls = 0U;
    TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_sync(&store));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_sync(&store));
    recorded.calls = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_sync(&store)); // There is nothing to sync.
    TEST_ASSERT_EQUAL_UINT(0U, recorded.calls);
}

static uint32_t checksum_of_medium(const size_t index)
{
    return crc32_iso(recorded.image[index].octets, recorded.image[index].size);
}

/// Two stores with one buffer, each on its own medium; one medium fails in every call.
static void a_failing_medium_does_not_affect_another_store(void)
{
    static pus_packet_store_t failing;
    static pus_store_block_t other_blocks[CAPACITY];
    const pus_packet_store_config_t config = {
        .medium = recorded_medium(1U), .blocks = other_blocks, .block_capacity = CAPACITY, .buffer = buffer};
    pus_packet_store_init(&failing, &config);
    pus_packet_store_create(&failing, GENERATION, 3U, true);
    fill(1U, 4U, LARGE);
    for (unsigned i = 21U; i <= 23U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_append(&failing, i, packet_of(i, LARGE), LARGE));
    }
    const uint32_t failed_checksum = checksum_of_medium(1U);
    recorded.failing               = &recorded.image[1];
    recorded.calls                 = 0U;
    recorded.fail_from             = 1U;
    recorded.fail_count            = OPERATIONS_MAX;
    for (unsigned i = 5U; i <= 12U; i++) { // The healthy store begins two blocks meanwhile.
        const uint32_t checksum = checksum_of_medium(0U);
        uint64_t cursor         = 0U;
        TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_append(&failing, i, packet_of(i, LARGE), LARGE));
        TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_next(&failing, &cursor, &found));
        TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_sync(&failing));
        TEST_ASSERT_EQUAL_HEX32(checksum, checksum_of_medium(0U));
        fill(i, i, LARGE);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_sync(&store));
        expect_content(1U, i, LARGE);
        TEST_ASSERT_EQUAL_HEX32(failed_checksum, checksum_of_medium(1U));
    }
    TEST_ASSERT_EQUAL(STATUS_IO, pus_packet_store_open(&failing, GENERATION, 3U, true, 0U));
    TEST_ASSERT_EQUAL_UINT32(0U, store.counters.failed + store.counters.damaged);
    TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U));
    expect_content(1U, 12U, LARGE);
}

static void a_medium_that_fails_at_the_start_is_reported(void)
{
    fill(1U, 6U, LARGE);
    memset(&recorded.image[0].octets[recorded.image[0].size], 0xFF, 8300U);
    recorded.image[0].size += 8300U; // Octets that are not a record follow them.
    damage_octet(30U);               // Therefore the first block is also read completely.
    // Size, two headers, the records of both blocks and the octets after them, three writes that wipe, a
    // sync.
    for (unsigned call = 1U; call <= 16U; call++) {
        const bool is_wiping = (call >= 12U) && (call <= 14U);
        recorded.calls       = 0U;
        recorded.fail_from   = call;
        recorded.failure     = is_wiping ? STATUS_FULL : STATUS_TIMEOUT;
        TEST_ASSERT_EQUAL(is_wiping ? STATUS_FULL : ((call < 16U) ? STATUS_IO : STATUS_OK),
                          reopen(3U, true, 0U));
    }
    recorded.fail_from = 0U;
    expect_content(1U, 6U, LARGE);
}

static void a_medium_that_ends_anywhere_is_read(void)
{
    fill(1U, 6U, LARGE);
    static image_t image; // Too large for the stack of a board.
    image = recorded.image[0];
    for (size_t size = 0U; size <= image.size; size += 211U) {
        recorded.image[0]      = image;
        recorded.image[0].size = size;
        TEST_ASSERT_EQUAL(STATUS_OK, reopen(3U, true, 0U));
        uint64_t cursor = 0U;
        unsigned count  = 0U;
        while (pus_packet_store_next(&store, &cursor, &found) == STATUS_OK) {
            count++;
            TEST_ASSERT_EQUAL_UINT64(count, found.time_ns);
        }
        TEST_ASSERT_EQUAL_UINT32(0U, store.counters.damaged);
        TEST_ASSERT_EQUAL(STATUS_OK, append(50U, LARGE));
    }
}

static void init_without_blocks(void)
{
    const pus_packet_store_config_t config = {
        .medium = recorded_medium(0U), .blocks = blocks, .block_capacity = 1U, .buffer = buffer};
    pus_packet_store_init(&store, &config);
}

static void create_too_large(void)
{
    pus_packet_store_create(&store, 1U, CAPACITY + 1U, true);
}

static void append_an_empty_packet(void)
{
    (void)append(1U, 0U);
}

static void calls_against_the_contract_are_asserted(void)
{
    TEST_ASSERT_TRUE(assertion_fails(init_without_blocks));
    TEST_ASSERT_TRUE(assertion_fails(create_too_large));
    TEST_ASSERT_TRUE(assertion_fails(append_an_empty_packet));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(packets_are_read_unchanged);
    RUN_TEST(a_block_is_filled_to_its_last_octet);
    RUN_TEST(a_circular_store_overwrites_its_oldest_block);
    RUN_TEST(a_bounded_store_takes_no_more);
    RUN_TEST(content_is_deleted_up_to_a_time);
    RUN_TEST(times_are_found_without_reading_the_rest);
    RUN_TEST(times_need_not_increase);
    RUN_TEST(a_search_skips_a_block_whose_latest_packet_is_deleted);
    RUN_TEST(a_store_is_recovered);
    RUN_TEST(deleted_packets_stay_deleted_after_reopening);
    RUN_TEST(a_resized_store_is_recovered);
    RUN_TEST(blocks_beyond_the_capacity_are_not_read);
    RUN_TEST(damage_loses_the_rest_of_its_block);
    RUN_TEST(a_damaged_header_ends_the_chain);
    RUN_TEST(a_failing_medium_keeps_the_stored_packets);
    RUN_TEST(a_failing_medium_does_not_affect_another_store);
    RUN_TEST(a_medium_that_fails_at_the_start_is_reported);
    RUN_TEST(a_medium_that_ends_anywhere_is_read);
    RUN_TEST(calls_against_the_contract_are_asserted);
    return UNITY_END();
}
