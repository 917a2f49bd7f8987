// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/memories.h"

#include "fsw/framework/base/crc.h"
#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"
#include "unity.h"

#include <string.h>

pus_memory_service_t memory_service;
pus_memory_state_t memory_states[3];
pus_memory_operation_t memory_operations[MEMORY_OPERATIONS];
uint8_t memory_ram[4096];
uint8_t memory_words[64];
uint8_t memory_rom[64];
memory_hardware_t memory_hardware;
memory_file_t memory_file;
uint8_t memory_data[PUS_TC_DATA_MAX];
octet_writer_t memory_writer;

static uint8_t* memory_at(void* const context, const uint32_t address)
{
    return &(
        (uint8_t*)
            context)[address -
                     ((context == memory_ram) ? RAM_BASE : ((context == memory_words) ? 0xFFFFFFC0U : 0U))];
}

static status_t read_memory(void* const context, const uint32_t address, uint8_t* const octets,
                            const size_t size)
{
    const bool is_broken = (context == memory_ram) && (memory_hardware.broken_at >= address) &&
                           ((memory_hardware.broken_at - address) < size);
    memcpy(octets, memory_at(context, address), size);
    return is_broken ? STATUS_IO : STATUS_OK;
}

static status_t write_memory(void* const context, const uint32_t address, const uint8_t* const octets,
                             const size_t size)
{
    const uint8_t kept =
        (memory_hardware.stuck_at != 0U) ? memory_ram[memory_hardware.stuck_at - RAM_BASE] : 0U;
    if ((context == memory_words) && memory_hardware.refuses_writes) {
        return STATUS_FORBIDDEN;
    }
    memcpy(memory_at(context, address), octets, size);
    if (memory_hardware.stuck_at != 0U) {
        memory_ram[memory_hardware.stuck_at - RAM_BASE] = kept;
    }
    return STATUS_OK;
}

static void scrub_memory(void* const context, const uint32_t address, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(memory_ram, context);
    memory_hardware.scrubs++;
    memory_hardware.scrubbed += (uint32_t)size;
    memory_hardware.scrubbed_at = address;
}

static status_t find_object(void* const context, const uint32_t base_id, uint32_t* const out_address,
                            uint32_t* const out_size)
{
    (void)context;
    *out_address = (base_id == 7U) ? 0x1100U : 0x1200U;
    *out_size    = (base_id == 7U) ? 256U : 0U;
    return ((base_id == 7U) || (base_id == 8U)) ? STATUS_OK : STATUS_NOT_FOUND;
}

static const pus_memory_t list[] = {
    {RAM, 1U, RAM_BASE, sizeof memory_ram, memory_ram, read_memory, write_memory, scrub_memory, find_object},
    {WORDS, 4U, 0xFFFFFFC0U, sizeof memory_words, memory_words, read_memory, write_memory, NULL, NULL},
    {ROM, 1U, 0U, sizeof memory_rom, memory_rom, read_memory, NULL, NULL, NULL},
};

const pus_memory_t* memory_list(void)
{
    return list;
}

static void note_name(const pus_file_name_t* const name)
{
    TEST_ASSERT_TRUE((name->path_size + 1U + name->name_size) < sizeof memory_file.name);
    memset(memory_file.name, 0, sizeof memory_file.name);
    memcpy(memory_file.name, name->path, name->path_size);
    memory_file.name[name->path_size] = '/';
    memcpy(&memory_file.name[name->path_size + 1U], name->name, name->name_size);
}

static status_t open_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file,
                          uint32_t* const out_size)
{
    TEST_ASSERT_EQUAL_PTR(&memory_file, context);
    note_name(name);
    *out_file           = 42U;
    *out_size           = memory_file.size;
    memory_file.is_open = (memory_file.open == STATUS_OK);
    return memory_file.open;
}

static status_t create_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file)
{
    uint32_t size    = 0U;
    memory_file.size = 0U;
    return open_file(context, name, out_file, &size);
}

static status_t read_file(void* const context, const uint32_t handle, const uint32_t offset,
                          uint8_t* const octets, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&memory_file, context);
    TEST_ASSERT_TRUE((handle == 42U) && memory_file.is_open && ((offset + size) <= memory_file.size));
    memcpy(octets, &memory_file.octets[offset], size);
    return memory_file.read;
}

static status_t write_file(void* const context, const uint32_t handle, const uint32_t offset,
                           const uint8_t* const octets, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&memory_file, context);
    TEST_ASSERT_TRUE((handle == 42U) && memory_file.is_open && (offset == memory_file.size) &&
                     ((offset + size) <= sizeof memory_file.octets));
    if (memory_file.write == STATUS_OK) {
        memcpy(&memory_file.octets[offset], octets, size);
        memory_file.size += (uint32_t)size;
    }
    return memory_file.write;
}

static status_t close_file(void* const context, const uint32_t handle)
{
    TEST_ASSERT_TRUE((context == &memory_file) && (handle == 42U) && memory_file.is_open);
    memory_file.is_open = false;
    memory_file.closes++;
    return memory_file.close;
}

const pus_file_port_t memory_files = {&memory_file, open_file,  create_file,
                                      read_file,    write_file, close_file};

void memory_start_with(const pus_file_port_t* const port)
{
    const pus_memory_config_t config = {.process         = &bench.process,
                                        .memories        = list,
                                        .states          = memory_states,
                                        .memory_count    = 3U,
                                        .operations      = memory_operations,
                                        .operation_count = MEMORY_OPERATIONS,
                                        .files           = port,
                                        .persistence     = records_port()};
    bench_start();
    pus_memory_init(&memory_service, &config);
    bench_serve(pus_memory_service(&memory_service));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void memories_start(void)
{
    memset(&memory_hardware, 0, sizeof memory_hardware);
    memset(&memory_file, 0, sizeof memory_file);
    for (size_t i = 0U; i < sizeof memory_ram; i++) {
        memory_ram[i] = (uint8_t)(i * 7U);
    }
    for (uint8_t i = 0U; i < sizeof memory_words; i++) {
        memory_words[i] = i;
        memory_rom[i]   = (uint8_t)(0xFFU - i);
    }
    for (size_t i = 0U; i < sizeof memory_file.octets; i++) {
        memory_file.octets[i] = (uint8_t)(i * 3U);
    }
    memory_file.size = sizeof memory_file.octets;
    records_start();
    memory_start_with(&memory_files);
}

void memory_begin(const uint8_t memory)
{
    memory_writer = octet_writer(memory_data, sizeof memory_data);
    octet_write_u8(&memory_writer, memory);
}

void memory_begin_object(const uint8_t memory, const uint32_t base_id)
{
    memory_begin(memory);
    octet_write_u32(&memory_writer, base_id);
}

void memory_name_file(void)
{
    octet_write_u16(&memory_writer, 3U);
    octet_write_octets(&memory_writer, (const uint8_t*)"dir", 3U);
    octet_write_u16(&memory_writer, 4U);
    octet_write_octets(&memory_writer, (const uint8_t*)"data", 4U);
}

void memory_add_area(const uint32_t address, const uint32_t length)
{
    octet_write_u32(&memory_writer, address);
    octet_write_u32(&memory_writer, length);
}

void memory_add_data(const uint32_t address, const void* const octets, const uint16_t size,
                     const uint16_t damage)
{
    octet_write_u32(&memory_writer, address);
    octet_write_u16(&memory_writer, size);
    octet_write_octets(&memory_writer, octets, size);
    octet_write_u16(&memory_writer, (uint16_t)(crc16_ccitt(octets, size) ^ damage));
}

void memory_add_file_area(const uint32_t address, const uint32_t offset, const uint32_t length,
                          const uint16_t damage)
{
    const uint16_t crc = ((offset + length) <= sizeof memory_file.octets)
                             ? crc16_ccitt(&memory_file.octets[offset], length)
                             : 0U;
    octet_write_u32(&memory_writer, address);
    octet_write_u32(&memory_writer, offset);
    octet_write_u32(&memory_writer, length);
    octet_write_u16(&memory_writer, (uint16_t)(crc ^ damage));
}

void memory_request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(memory_writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, memory_data, memory_writer.position));
}

void memory_step(const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        pus_dispatcher_step(&bench.dispatcher, TEST_NOW_NS, i);
    }
}
