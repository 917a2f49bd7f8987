// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/schedules.h"

#include "test/unit/pus/reports.h"
#include "unity.h"

#include <limits.h>
#include <string.h>

released_t released;

static pus_activity_t activities[ACTIVITIES];
static pus_order_node_t nodes[ACTIVITIES];
static uint16_t buckets[16384];
static uint64_t storage[PUS_CHAIN_WORDS(BLOCKS)];
static pool_slot_t slots[BLOCKS];
static pus_chains_t chains;

void released_clear(void)
{
    memset(&released, 0, sizeof(released));
    released.accepts = UINT_MAX;
}

static status_t take(void* const context, const uint8_t* const packet, const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    (void)context;
    if ((released.accepts == 0U) && (released.refusals > 0U)) {
        released.refusals--;
        return STATUS_FULL;
    }
    if (released.accepts > 0U) {
        released.accepts--;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(packet, size, &tc, &failure));
    TEST_ASSERT_TRUE(released.count < RELEASED_MAX);
    released.ids[released.count] =
        (pus_activity_id_t){.source = tc.source, .apid = tc.apid, .sequence = tc.sequence};
    released.sizes[released.count] = size;
    released.count++;
    return STATUS_OK;
}

pus_port_t released_port(void)
{
    return (pus_port_t){.context = NULL, .send = take};
}

size_t request_make(const uint16_t sequence, const size_t size, uint8_t* const out_octets)
{
    static uint8_t data[PUS_TC_DATA_MAX];
    size_t packet_size = 0U;
    memset(data, (int)(sequence & 0xFFU), sizeof(data));
    const pus_tc_t tc = {.apid     = RELEASE_APID,
                         .sequence = sequence,
                         .ack      = PUS_ACK_ALL,
                         .service  = 17U,
                         .subtype  = 1U,
                         .source   = RELEASE_SOURCE,
                         .data     = data,
                         .size     = size};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, out_octets, PUS_PACKET_MAX, &packet_size));
    return packet_size;
}

void request_write(octet_writer_t* const writer, const uint16_t sequence, const size_t size)
{
    uint8_t octets[PUS_PACKET_MAX];
    octet_write_octets(writer, octets, request_make(sequence, size, octets));
    TEST_ASSERT_FALSE(writer->failed);
}

void expect_released(const int* const sequences)
{
    size_t index = 0U;
    for (; sequences[index] >= 0; index++) {
        TEST_ASSERT_TRUE_MESSAGE(index < released.count, "a request was not released");
        TEST_ASSERT_EQUAL_UINT16(sequences[index], released.ids[index].sequence);
        TEST_ASSERT_EQUAL_UINT16(RELEASE_APID, released.ids[index].apid);
        TEST_ASSERT_EQUAL_UINT16(RELEASE_SOURCE, released.ids[index].source);
    }
    TEST_ASSERT_EQUAL_UINT64_MESSAGE(index, released.count, "number of requests released");
    released.count = 0U;
}

static void tell_lost(void* const context, const pus_activity_id_t* const id)
{
    (void)context;
    TEST_ASSERT_TRUE(released.lost_count < PUS_SCHEDULE_BATCH);
    released.lost[released.lost_count] = *id;
    released.lost_count++;
}

pus_schedule_config_t schedule_config(const uint16_t activity_count, const uint16_t block_count)
{
    TEST_ASSERT_TRUE((activity_count <= ACTIVITIES) && (block_count <= BLOCKS));
    pus_chains_init(&chains, storage, slots, block_count);
    return (pus_schedule_config_t){.process            = &bench.process,
                                   .release            = released_port(),
                                   .activities         = activities,
                                   .nodes              = nodes,
                                   .activity_count     = activity_count,
                                   .buckets            = buckets,
                                   .bucket_count       = 16384U,
                                   .chains             = &chains,
                                   .sub_schedule_count = 4U,
                                   .group_count        = 3U,
                                   .lost               = tell_lost};
}
