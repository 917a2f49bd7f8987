// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/sequenced.h"

#include "test/unit/pus/reports.h"
#include "test/unit/pus/schedules.h"
#include "unity.h"

#include <string.h>

sequenced_t sequenced;

static pus_sequence_t table[SEQUENCES];
static pus_order_node_t nodes[SEQUENCES];
static uint64_t storage[PUS_CHAIN_WORDS(BLOCKS_HERE)];
static pool_slot_t slots[BLOCKS_HERE];

static status_t open_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file,
                          uint32_t* const out_size)
{
    (void)context;
    if (sequenced.file.open_status != STATUS_OK) {
        return sequenced.file.open_status;
    }
    if ((name->path_size != 4U) || (name->name_size != 3U) || (memcmp(name->path, "/seq", 4U) != 0) ||
        (memcmp(name->name, "abc", 3U) != 0)) {
        return STATUS_NOT_FOUND;
    }
    sequenced.file.open++;
    *out_file = 7U;
    *out_size = sequenced.file.size;
    return STATUS_OK;
}

static status_t read_file(void* const context, const uint32_t number, const uint32_t offset,
                          uint8_t* const octets, const size_t size)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT32(7U, number);
    TEST_ASSERT_TRUE((offset + size) <= sequenced.file.size);
    memcpy(octets, &sequenced.file.octets[offset], size);
    return sequenced.file.read_status;
}

static status_t close_file(void* const context, const uint32_t number)
{
    (void)context;
    TEST_ASSERT_EQUAL_UINT32(7U, number);
    sequenced.file.open--;
    return STATUS_OK;
}

static const pus_file_port_t files = {.open = open_file, .read = read_file, .close = close_file};

void sequenced_start(const uint16_t count, const uint16_t blocks)
{
    pus_chains_init(&sequenced.chains, storage, slots, blocks);
    sequenced.config = (pus_sequences_config_t){.process        = &bench.process,
                                                .release        = released_port(),
                                                .persistence    = sequenced.config.persistence,
                                                .files          = &files,
                                                .sequences      = table,
                                                .nodes          = nodes,
                                                .sequence_count = count,
                                                .octets_max     = OCTETS_MAX,
                                                .chains         = &sequenced.chains};
    pus_sequences_init(&sequenced.service, &sequenced.config);
    bench_serve(pus_sequences_service(&sequenced.service));
}

void sequenced_set_up(void)
{
    bench_start();
    released_clear();
    memset(&sequenced, 0, sizeof(sequenced));
    sequenced_start(SEQUENCES, BLOCKS_HERE);
}

static void sequenced_write_name(const char letter)
{
    const uint8_t name[8] = {(uint8_t)letter, 'q'};
    octet_write_octets(&sequenced.writer, name, sizeof(name));
}

void sequenced_begin(const char letter)
{
    sequenced.writer = octet_writer(sequenced.data, sizeof(sequenced.data));
    sequenced_write_name(letter);
}

void sequenced_add(const uint16_t sequence, const size_t size, const int64_t delay)
{
    request_write(&sequenced.writer, sequence, size);
    for (int shift = 48; shift >= 0; shift -= 8) {
        octet_write_u8(&sequenced.writer, (uint8_t)(((uint64_t)delay >> shift) & 0xFFU));
    }
}

void sequenced_request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(sequenced.writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, sequenced.data, sequenced.writer.position));
}

void sequenced_expect_done(const uint8_t subtype)
{
    sequenced_request(subtype);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

void sequenced_command(const uint8_t subtype, const char letter)
{
    sequenced_begin(letter);
    sequenced_request(subtype);
}

void sequenced_load(const char letter, const uint16_t first, const uint8_t count)
{
    sequenced_begin(letter);
    octet_write_u8(&sequenced.writer, count);
    for (uint16_t i = 0U; i < count; i++) {
        sequenced_add((uint16_t)(first + i), 0U, TICKS / 100);
    }
    sequenced_expect_done(1U);
}

void sequenced_reference(const char letter, const uint8_t subtype)
{
    sequenced_begin(letter);
    octet_write_u16(&sequenced.writer, 4U);
    octet_write_octets(&sequenced.writer, (const uint8_t*)"/seq", 4U);
    octet_write_u16(&sequenced.writer, 3U);
    octet_write_octets(&sequenced.writer, (const uint8_t*)"abc", 3U);
    sequenced_request(subtype);
}

void sequenced_begin_file(const uint8_t count)
{
    sequenced.writer = octet_writer(sequenced.file.octets, sizeof(sequenced.file.octets));
    octet_write_u8(&sequenced.writer, count);
}

void sequenced_end_file(void)
{
    TEST_ASSERT_FALSE(sequenced.writer.failed);
    sequenced.file.size = (uint32_t)sequenced.writer.position;
}

void sequenced_step(const uint64_t uptime_ns)
{
    pus_sequences_step(&sequenced.service, TEST_NOW_NS, uptime_ns);
}

void sequenced_make_long_file(void)
{
    sequenced_begin_file(6U);
    for (uint16_t i = 0U; i < 5U; i++) {
        sequenced_add((uint16_t)(i + 1U), (PUS_SEQUENCE_REQUEST_MAX - PUS_TC_MIN) - ((i == 4U) ? 2000U : 0U),
                      0);
    }
    sequenced_add(6U, 0U, TICKS);
    sequenced_end_file();
    sequenced.service.config.octets_max = 30000U;
}
