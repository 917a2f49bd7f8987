// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/stores.h"

#include "unity.h"

#include <string.h>

#define NS_PER_S 1000000000ULL
#define REPORTS_KNOWN 256U

pus_storage_t stores_storage;
stores_sent_t stores_sent;
pus_storage_config_t stores_config;
octet_writer_t stores_request;

static const uint16_t apids[] = {TEST_APID, 17U};
static medium_t media[STORES];
static pus_store_block_t blocks[STORES * STORE_BLOCKS];
static pus_selection_entry_t entries[STORES * STORE_ENTRIES];
static pus_selection_entry_t candidate[STORE_ENTRIES];
static struct {
    uint8_t name[PUS_NAME_SIZE];
    uint16_t blocks;
    uint8_t type;
} added[STORES];
static size_t added_count;
static size_t seen; // Packets sent that a test has looked at.
static size_t sizes[REPORTS_KNOWN];
static uint8_t octets[PUS_TC_DATA_MAX];

/// Report `sequence`, encoded.
static size_t encode(const uint16_t sequence, uint8_t* const packet, pus_tm_t* const tm)
{
    static uint8_t data[PUS_TM_DATA_MAX];
    size_t size       = 0U;
    const size_t room = sizes[sequence] - PUS_TM_MIN;
    memset(data, (int)(sequence + 1U), room);
    *tm = (pus_tm_t){
        .apid = TEST_APID, .sequence = sequence, .service = 17U, .subtype = 2U, .data = data, .size = room};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(tm, packet, PUS_PACKET_MAX, &size));
    return size;
}

static status_t take(void* const context, const uint8_t channel, const uint8_t* const packet,
                     const size_t size)
{
    static uint8_t expected[PUS_PACKET_MAX];
    pus_tm_t tm;
    pus_tm_t original;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL_PTR(&stores_sent, context);
    if (stores_sent.refusals > 0U) {
        stores_sent.refusals--;
        return STATUS_FULL;
    }
    TEST_ASSERT_TRUE(stores_sent.count < SENT_MAX);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
    TEST_ASSERT_EQUAL_UINT64(encode(tm.sequence, expected, &original), size);
    TEST_ASSERT_EQUAL_MEMORY(expected, packet, size);
    stores_sent.packets[stores_sent.count].channel  = channel;
    stores_sent.packets[stores_sent.count].sequence = tm.sequence;
    stores_sent.count++;
    return STATUS_OK;
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const record, const size_t size)
{
    return pus_storage_restore(self, key, record, size);
}

void stores_begin(void)
{
    static const image_t empty[2];
    recorded_clear(empty);
    records_start();
    bench_start();
    for (size_t i = 0U; i < STORES; i++) {
        media[i] = recorded_medium(i);
    }
    memset(&stores_sent, 0, sizeof(stores_sent));
    seen          = 0U;
    added_count   = 0U;
    stores_config = (pus_storage_config_t){.process              = &bench.process,
                                           .media                = media,
                                           .store_count          = STORES,
                                           .blocks_of_store      = STORE_BLOCKS,
                                           .blocks               = blocks,
                                           .entries_of_selection = STORE_ENTRIES,
                                           .entries              = entries,
                                           .candidate            = candidate,
                                           .apids                = apids,
                                           .apid_count           = 2U,
                                           .virtual_channels     = STORE_CHANNELS,
                                           .port                 = {.context = &stores_sent, .send = take},
                                           .packets_per_step     = STEP_PACKETS,
                                           .octets_per_step      = 60000U,
                                           .persistence          = records_port()};
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
}

status_t stores_restart(void)
{
    pus_storage_init(&stores_storage, &stores_config);
    for (size_t i = 0U; i < added_count; i++) {
        pus_store_definition_t definition = {.size            = added[i].blocks * PUS_STORE_BLOCK,
                                             .type            = added[i].type,
                                             .virtual_channel = 1U,
                                             .is_enabled      = true};
        memcpy(definition.name, added[i].name, PUS_NAME_SIZE);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_storage_add(&stores_storage, &definition));
        TEST_ASSERT_EQUAL(STATUS_OK, pus_selection_add_process(
                                         pus_storage_selection(&stores_storage, (uint8_t)i), TEST_APID));
    }
    (void)records_replay(PUS_SERVICE_STORAGE, restore, &stores_storage);
    bench_serve(pus_storage_service(&stores_storage));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
    return pus_storage_start(&stores_storage);
}

void stores_add(const char* const name, const uint16_t block_count, const uint8_t type)
{
    TEST_ASSERT_TRUE(added_count < STORES);
    strncpy((char*)added[added_count].name, name, PUS_NAME_SIZE);
    added[added_count].blocks = block_count;
    added[added_count].type   = type;
    added_count++;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
}

void stores_cut(void)
{
    static image_t images[2];
    recorded_durable(images);
    recorded_clear(images);
    records_cut();
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
}

void stores_report(const uint16_t sequence, const size_t size, const unsigned second)
{
    static uint8_t packet[PUS_PACKET_MAX];
    pus_tm_t tm;
    TEST_ASSERT_TRUE(sequence < REPORTS_KNOWN);
    sizes[sequence] = size;
    pus_storage_observe(&stores_storage, &tm, packet, encode(sequence, packet, &tm), second * NS_PER_S);
}

void stores_reports(const uint16_t first, const uint16_t last)
{
    for (uint16_t i = first; i <= last; i++) {
        stores_report(i, REPORT_SIZE, i);
    }
}

void stores_step(const unsigned steps, const unsigned second)
{
    for (unsigned i = 0U; i < steps; i++) {
        pus_storage_step(&stores_storage, second * NS_PER_S);
    }
}

bool stores_is_idle(void)
{
    return pus_storage_due_ns(&stores_storage, 0U) == UINT64_MAX;
}

void expect_stores_sent(const uint16_t first, const uint16_t last)
{
    for (uint16_t i = first; i <= last; i++) {
        TEST_ASSERT_TRUE_MESSAGE(seen < stores_sent.count, "a packet was not stores_sent");
        TEST_ASSERT_EQUAL_UINT16(i, stores_sent.packets[seen].sequence);
        seen++;
    }
    TEST_ASSERT_EQUAL_UINT64(seen, stores_sent.count);
}

void expect_stores_none_sent(void)
{
    TEST_ASSERT_EQUAL_UINT64(seen, stores_sent.count);
}

void stores_begin_request(void)
{
    stores_request = octet_writer(octets, sizeof(octets));
}

void stores_put_name(const char* const name)
{
    uint8_t padded[PUS_NAME_SIZE] = {0};
    memcpy(padded, name, strlen(name));
    octet_write_octets(&stores_request, padded, sizeof(padded));
}

void stores_put_second(const unsigned second)
{
    pus_time_write(&stores_request, (TEST_EPOCH_S + (uint64_t)second) * NS_PER_S);
}

status_t stores_send_request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(stores_request.failed);
    return bench_request(subtype, octets, stores_request.position);
}

void expect_stores_performed(const uint8_t subtype)
{
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(subtype));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

void expect_stores_refused(const uint8_t subtype, const uint16_t code, const uint16_t instruction,
                           const uint32_t detail)
{
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(subtype));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, instruction, detail);
}

void stores_request_store(const uint8_t subtype, const char* const name)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name(name);
    expect_stores_performed(subtype);
}

void stores_request_all(const uint8_t subtype)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    expect_stores_performed(subtype);
}

uint32_t stores_name_of(const char* const name)
{
    uint8_t padded[PUS_NAME_SIZE] = {0};
    memcpy(padded, name, strlen(name));
    return octets_u32_at(padded);
}

void stores_create(const char* const name, const uint32_t size, const uint8_t type, const uint8_t channel)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name(name);
    octet_write_u32(&stores_request, size);
    octet_write_u8(&stores_request, type);
    octet_write_u8(&stores_request, channel);
}

void stores_create_ring(void)
{
    stores_create("ring", SIZE(3U), PUS_STORE_CIRCULAR, 2U);
    expect_stores_performed(20U);
}

/// Source data of the answer to a request, the third of its reports.
octet_reader_t stores_answer(const uint8_t subtype, const uint8_t expected)
{
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(subtype));
    EXPECT_MESSAGES(1, 1, 1, 3, 15, expected, 1, 7);
    return bench_data(2U);
}

void expect_stores_name(octet_reader_t* const reader, const char* const name)
{
    uint8_t padded[PUS_NAME_SIZE] = {0};
    memcpy(padded, name, strlen(name));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(padded, octet_read_octets(reader, PUS_NAME_SIZE), PUS_NAME_SIZE);
}

static void expect_time(octet_reader_t* const reader, const unsigned second)
{
    uint64_t time_ns        = 0U;
    const uint64_t expected = (second == 0U) ? 0U : (TEST_EPOCH_S + (uint64_t)second) * 1000000000ULL;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(reader, &time_ns));
    TEST_ASSERT_EQUAL_UINT64(expected, time_ns);
}

/// TM[15,13] of one store.
void expect_stores_summary(const char* const name, const unsigned oldest, const unsigned newest,
                           const unsigned tag, const uint8_t filled, const uint8_t from_tag)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name(name);
    octet_reader_t reader = stores_answer(12U, 13U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    expect_stores_name(&reader, name);
    expect_time(&reader, oldest);
    expect_time(&reader, newest);
    expect_time(&reader, tag);
    TEST_ASSERT_EQUAL_UINT8(filled, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(from_tag, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}
