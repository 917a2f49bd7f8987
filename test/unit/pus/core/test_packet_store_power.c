// SPDX-License-Identifier: Apache-2.0
// A packet store whose power is cut at every write. For each part of the unsynced data that may be missing or
// torn, the recovered packets are a sequence without a gap that contains all synced packets, and no deleted
// packet reappears.
#include "pus/core/packet_store.h"

#include "test/support/recorded_media.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 3U
#define LIMIT 2U
#define PACKETS 14U // Packets for three and a half blocks, in a store of two blocks.
#define MORE 3U     // Packets stored after the cut.
#define GENERATION 9U

static const image_t empty[2];
static image_t durable[2]; // Media with the synced operations only.
static image_t pending[2]; // Media after the cut.
static image_t after[2];

static pus_packet_store_t store;
static pus_store_block_t blocks[CAPACITY];
static uint8_t buffer[PUS_STORE_BUFFER_SIZE];
static uint8_t packets[PACKETS + MORE + 1U][PUS_PACKET_MAX];
static recorded_t flight; // Operations before any cut.
static unsigned cuts;

void setUp(void)
{
    for (unsigned index = 0U; index <= (PACKETS + MORE); index++) {
        for (size_t i = 0U; i < PUS_PACKET_MAX; i++) {
            packets[index][i] = (uint8_t)(index + (i * 3U));
        }
    }
}

void tearDown(void)
{
}

/// Packets have different sizes, so that remains of an earlier write never fit by chance.
static size_t size_of(const unsigned index)
{
    return 3600U + ((index * 97U) % 400U);
}

static void open_store(void)
{
    const pus_packet_store_config_t config = {
        .medium = recorded_medium(0U), .blocks = blocks, .block_capacity = CAPACITY, .buffer = buffer};
    pus_packet_store_init(&store, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_open(&store, GENERATION, LIMIT, true, 0U));
}

/// Expect a sequence of packets without a gap; it ends with *out_last, which is 0 if the store is empty.
static void read_all(unsigned* const out_first, unsigned* const out_last)
{
    uint64_t cursor = 0U;
    pus_stored_packet_t packet;
    *out_first      = 0U;
    *out_last       = 0U;
    status_t status = pus_packet_store_next(&store, &cursor, &packet);
    while (status == STATUS_OK) {
        const unsigned index = (unsigned)packet.time_ns;
        *out_first           = (*out_first == 0U) ? index : *out_first;
        TEST_ASSERT_TRUE((*out_last == 0U) || (index == (*out_last + 1U)));
        TEST_ASSERT_EQUAL_UINT64(size_of(index), packet.size);
        TEST_ASSERT_EQUAL_MEMORY(packets[index], packet.packet, packet.size);
        *out_last = index;
        status    = pus_packet_store_next(&store, &cursor, &packet);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, status);
    TEST_ASSERT_EQUAL_UINT32(0U, store.counters.damaged);
}

/// Expect that the store opens after a power cut with at least the packets up to `synced`, and without a loss
/// of packets from `oldest` on. Then add packets, sync everything, cut the power again, and expect all
/// packets.
static void expect_recovered(const unsigned synced, const unsigned oldest)
{
    unsigned first = 0U;
    unsigned last  = 0U;
    unsigned again = 0U;
    cuts++;
    recorded_clear(pending);
    open_store();
    read_all(&first, &last);
    TEST_ASSERT_TRUE(last >= synced);
    TEST_ASSERT_TRUE(first <= oldest);
    for (unsigned i = 1U; i <= MORE; i++) {
        const unsigned index = last + i;
        TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_append(&store, index, packets[index], size_of(index)));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_sync(&store));
    recorded_durable(after);
    recorded_clear(after);
    open_store();
    read_all(&first, &again);
    // No packet is stored twice, and no packet from before the cut reappears.
    TEST_ASSERT_EQUAL_UINT(last + MORE, again);
}

/// Returns the first operation after the last sync before operation `end`.
static size_t begin_of(const operation_t* const operations, const size_t end)
{
    size_t begin = end;
    while ((begin > 0U) && (operations[begin - 1U].kind != OPERATION_SYNC)) {
        begin--;
    }
    return begin;
}

/// Perform only the first `size` octets of a recorded write.
static void apply(const operation_t* const operation, const size_t size, image_t images[2])
{
    image_t* const image = &images[operation->medium];
    if ((operation->kind == OPERATION_WRITE) && (size > 0U)) {
        const size_t end = operation->offset + size;
        if (end > image->size) {
            memset(&image->octets[image->size], 0, end - image->size);
            image->size = end;
        }
        memcpy(&image->octets[operation->offset], &flight.data[operation->data], size);
    }
}

/// Store all packets with a sync after each `sync_every`. Then cut the power in each recorded operation: of
/// the operations since the last sync, any subset is on the media, and the last operation is torn at any of 4
/// places.
static void cut_at_every_operation(const unsigned sync_every)
{
    static const size_t torn[] = {0U, 13U, 700U, SIZE_MAX};
    unsigned oldest_of[PACKETS + 1U]; // Oldest packet in the store after this number of packets.
    recorded_clear(empty);
    open_store();
    for (unsigned i = 1U; i <= PACKETS; i++) {
        recorded.mark = i;
        TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_append(&store, i, packets[i], size_of(i)));
        if ((i % sync_every) == 0U) {
            TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_sync(&store));
        }
        oldest_of[i] = (unsigned)pus_packet_store_oldest_ns(&store);
    }
    memcpy(&flight, &recorded, sizeof flight);
    oldest_of[0] = 1U;
    recorded_copy(durable, empty);
    size_t settled  = 0U; // Number of operations that `durable` contains.
    unsigned synced = 0U; // Number of packets that `durable` contains.
    for (size_t end = 0U; end < flight.count; end++) {
        const size_t begin      = begin_of(flight.operations, end);
        const unsigned in_doubt = (unsigned)(end - begin);
        TEST_ASSERT_TRUE(in_doubt <= 8U);
        // A write of more than 1000 octets is the record of a packet; shorter ones are headers of blocks.
        for (; settled < begin; settled++) {
            const operation_t* const done = &flight.operations[settled];
            apply(done, done->size, durable);
            synced = ((done->kind == OPERATION_WRITE) && (done->size > 1000U)) ? done->mark : synced;
        }
        for (unsigned present = 0U; present < (1U << in_doubt); present++) {
            for (size_t t = 0U; t < (sizeof torn / sizeof torn[0]); t++) {
                const operation_t* const last = &flight.operations[end];
                const size_t part             = (torn[t] < last->size) ? torn[t] : last->size;
                if ((t > 0U) && (part == ((torn[t - 1U] < last->size) ? torn[t - 1U] : last->size))) {
                    continue; // The media are the same as before.
                }
                recorded_copy(pending, durable);
                for (unsigned i = 0U; i < in_doubt; i++) {
                    const operation_t* const operation = &flight.operations[begin + i];
                    if ((present & (1U << i)) != 0U) {
                        apply(operation, operation->size, pending);
                    }
                }
                apply(last, part, pending);
                expect_recovered(synced, oldest_of[last->mark]);
            }
        }
    }
}

static void every_power_cut_leaves_consecutive_packets(void)
{
    cuts = 0U;
    cut_at_every_operation(3U);
    TEST_ASSERT_TRUE(cuts > 100U);
}

static void every_power_cut_leaves_consecutive_packets_where_only_blocks_are_synced(void)
{
    cuts = 0U;
    cut_at_every_operation(1000U);
    TEST_ASSERT_TRUE(cuts > 100U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_power_cut_leaves_consecutive_packets);
    RUN_TEST(every_power_cut_leaves_consecutive_packets_where_only_blocks_are_synced);
    return UNITY_END();
}
