// SPDX-License-Identifier: Apache-2.0
// Dumps and checks of memory, and loads from files and dumps to files, which take several steps. The numbers
// of requests and reports are subtypes; pus/catalogue/st06_memory.txt has their names and fields.
#include "pus/st06/st06_memory.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/memories.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

void setUp(void)
{
    memories_start();
}

void tearDown(void)
{
}

/// Read the data of an area of a dump and compare them with the memory. Returns its length.
static uint16_t expect_dumped(octet_reader_t* const reader, const uint32_t address,
                              const uint8_t* const expected)
{
    TEST_ASSERT_EQUAL_HEX32(address, octet_read_u32(reader));
    const uint16_t size         = octet_read_u16(reader);
    const uint8_t* const octets = octet_read_octets(reader, size);
    TEST_ASSERT_NOT_NULL(octets);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, size);
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(expected, size), octet_read_u16(reader));
    return size;
}

// ---- Dumps ----

static void a_large_dump_becomes_many_reports(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 3U);
    memory_add_area(RAM_BASE, 3U);
    memory_add_area(RAM_BASE + sizeof memory_ram, 1U);
    memory_add_area(RAM_BASE + 16U, 3000U);
    memory_request(5U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3);
    expect_failure(1U, 4U, PUS_FAILURE_ADDRESS, 2U, RAM_BASE + sizeof memory_ram);
    memory_step(5U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 6, 6, 6, 6, 6, 6, 1, 8);
    expect_failure(6U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
    uint32_t done = 0U;
    for (size_t i = 3U; i < 6U; i++) {
        octet_reader_t reader = bench_data(i);
        TEST_ASSERT_EQUAL_UINT8(RAM, octet_read_u8(&reader));
        TEST_ASSERT_EQUAL_UINT16((i == 3U) ? 2U : 1U, octet_read_u16(&reader));
        if (i == 3U) {
            TEST_ASSERT_EQUAL_UINT16(3U, expect_dumped(&reader, RAM_BASE, memory_ram));
        }
        done += expect_dumped(&reader, RAM_BASE + 16U + done, &memory_ram[16U + done]);
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
    TEST_ASSERT_EQUAL_UINT32(3000U, done);
    TEST_ASSERT_EQUAL_UINT32(2U, memory_service.counters.dumped);
    expect_strict_format(5U, memory_data, memory_writer.position);
}

static void objects_are_dumped_by_their_offset(void)
{
    memory_begin_object(RAM, 7U);
    octet_write_u8(&memory_writer, 2U);
    memory_add_area(0U, 256U);
    memory_add_area(0U, 257U);
    memory_request(3U);
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 6, 4, 1, 8);
    octet_reader_t reader = bench_data(3U);
    TEST_ASSERT_EQUAL_UINT8(RAM, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT32(7U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT16(256U, expect_dumped(&reader, 0U, &memory_ram[0x100]));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    expect_strict_format(3U, memory_data, memory_writer.position);
}

static void as_many_areas_as_a_request_may_name_are_dumped(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 255U);
    for (uint32_t i = 0U; i < 255U; i++) {
        memory_add_area(RAM_BASE + (16U * i), 16U);
    }
    memory_request(5U);
    memory_step(5U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 6, 6, 6, 6, 6, 6, 6, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(255U, memory_service.counters.dumped);
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(5U, memory_data, memory_writer.position));
}

static void a_dump_without_a_valid_area_starts_no_operation(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 2U);
    memory_add_area(0U, 1U);
    memory_add_area(RAM_BASE, 0U);
    memory_request(5U);
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4);
}

static void a_dump_waits_while_no_report_is_taken(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 2000U);
    memory_request(5U);
    bench.refusals = 2U;
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 3);
    memory_ram[0] = 0xEEU; // A report contains the values at the time at which it is sent.
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 6, 6, 6, 1, 7);
    octet_reader_t reader = bench_data(2U);
    (void)octet_read_octets(&reader, 3U);
    TEST_ASSERT_EQUAL_UINT16(PUS_MEMORY_SLICE, expect_dumped(&reader, RAM_BASE, memory_ram));
    TEST_ASSERT_EQUAL_UINT32(1U, memory_service.counters.dumped);
}

static void an_unreadable_area_is_omitted_from_a_dump(void)
{
    memory_hardware.broken_at = RAM_BASE + 1500U;
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 3U);
    memory_add_area(RAM_BASE + 1500U, 1U);
    memory_add_area(RAM_BASE, 10U);
    memory_add_area(RAM_BASE + 1499U, 2U);
    memory_request(5U);
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 6, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
    octet_reader_t reader = bench_data(2U);
    (void)octet_read_u8(&reader);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE + 1500U, 1U);
    memory_request(5U);
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
}

static void all_dumps_are_ended_together(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, sizeof memory_ram);
    memory_request(5U);
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 3000U);
    memory_request(20U);
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 1U);
    memory_request(5U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, MEMORY_OPERATIONS);
    memory_step(1U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(12U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 8, 1, 8, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(1U, memory_file.closes);
    memory_step(3U);
    TEST_ASSERT_EQUAL_UINT64(5U, bench.count);
    memory_begin(RAM); // TC[6,12] does not end a check that is in progress.
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 1U);
    memory_request(9U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(12U, NULL, 0U));
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 1, 1, 3, 1, 7, 6, 10, 1, 7);
    expect_strict_format(12U, NULL, 0U);
}

// ---- Checks ----

static void a_check_of_raw_areas_reports_their_checksums_and_refuses_an_address_outside(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 3U);
    memory_add_area(RAM_BASE, sizeof memory_ram);
    memory_add_area(RAM_BASE - 1U, 1U);
    memory_add_area(RAM_BASE + 5U, 1U);
    memory_request(9U);
    memory_step(6U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 6, 10, 1, 8);
    octet_reader_t reader = bench_data(3U);
    TEST_ASSERT_EQUAL_UINT8(RAM, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(RAM_BASE, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT32(sizeof memory_ram, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(memory_ram, sizeof memory_ram), octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(RAM_BASE + 5U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT32(1U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(&memory_ram[5], 1U), octet_read_u16(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    TEST_ASSERT_EQUAL_UINT32(2U, memory_service.counters.checked);
    expect_strict_format(9U, memory_data, memory_writer.position);
}

static void objects_are_checked_in_parts_and_completely(void)
{
    memory_begin_object(RAM, 7U);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(1U, 9U);
    memory_request(7U);
    bench.refusals = 1U;
    memory_step(3U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 8, 1, 7);
    octet_reader_t reader = bench_data(2U);
    (void)octet_read_octets(&reader, 7U);
    TEST_ASSERT_EQUAL_UINT32(1U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT32(9U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(&memory_ram[0x101], 9U), octet_read_u16(&reader));
    expect_strict_format(7U, memory_data, memory_writer.position);
    memory_begin_object(RAM, 7U);
    memory_request(17U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 18, 1, 7);
    reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT8(RAM, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT32(7U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT32(256U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(&memory_ram[0x100], 256U), octet_read_u16(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    expect_strict_format(17U, memory_data, memory_writer.position);
    memory_begin_object(RAM, 8U);
    memory_request(17U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 0U);
}

static void an_unreadable_area_is_omitted_from_a_check(void)
{
    memory_hardware.broken_at = RAM_BASE + 0x100U;
    memory_begin_object(RAM, 7U);
    memory_request(17U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
}

// ---- Loads and dumps by reference ----

static void raw_areas_are_loaded_from_a_file(void)
{
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 4U);
    memory_add_file_area(RAM_BASE, 0U, 3000U, 0U);
    memory_add_file_area(RAM_BASE, FILE_OCTETS - 1U, 2U, 0U);
    memory_add_file_area(RAM_BASE, FILE_OCTETS + 1U, 1U, 0U);
    memory_add_file_area(RAM_BASE + 3500U, FILE_OCTETS - 1U, 1U, 0U);
    memory_request(19U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 3);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 2U, 27U);
    expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 41U);
    TEST_ASSERT_EQUAL_STRING("dir/data", memory_file.name);
    memory_step(2U);
    TEST_ASSERT_EQUAL_HEX8(7U, memory_ram[1]); // The checksum of the complete file is checked first.
    memory_step(4U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 3, 1, 8);
    expect_failure(4U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(memory_file.octets, memory_ram, 3000U);
    TEST_ASSERT_EQUAL_HEX8(memory_file.octets[FILE_OCTETS - 1U], memory_ram[3500]);
    TEST_ASSERT_EQUAL_UINT(1U, memory_file.closes);
    TEST_ASSERT_EQUAL_UINT32(2U, memory_service.counters.loaded);
    expect_strict_format(19U, memory_data, memory_writer.position);
}

static void an_object_is_loaded_from_a_file(void)
{
    memory_begin_object(RAM, 7U);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(250U, 100U, 6U, 0U);
    memory_request(21U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&memory_file.octets[100], &memory_ram[0x1FA], 6U);
    expect_strict_format(21U, memory_data, memory_writer.position);
}

static void a_file_with_a_wrong_checksum_changes_nothing(void)
{
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 2U);
    memory_add_file_area(RAM_BASE, 0U, 20U, 1U);
    memory_add_file_area(RAM_BASE + 100U, 0U, 20U, 0U);
    memory_request(19U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_VERIFY, 1U, crc16_ccitt(memory_file.octets, 20U));
    TEST_ASSERT_EQUAL_HEX8(7U, memory_ram[1]);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(memory_file.octets, &memory_ram[100], 20U);
}

static void a_load_from_a_file_that_fails_is_reported(void)
{
    memory_hardware.stuck_at = RAM_BASE + 3U;
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(RAM_BASE, 0U, 20U, 0U);
    memory_request(19U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_VERIFY, 1U, crc16_ccitt(memory_ram, 20U));
    memory_hardware.stuck_at       = 0U;
    memory_hardware.refuses_writes = true;
    memory_begin(WORDS);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(WORDS_BASE, 0U, 8U, 0U);
    memory_request(19U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_FORBIDDEN);
    memory_file.read = STATUS_IO;
    memory_request(19U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
}

/// The address that cannot be read is in the second slice.
static void a_load_from_a_file_to_an_address_that_cannot_be_read_changes_nothing(void)
{
    memory_hardware.broken_at = RAM_BASE + 2000U;
    memory_ram[0]             = (uint8_t)~memory_file.octets[0];
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(RAM_BASE, 0U, 3000U, 0U);
    memory_request(19U);
    memory_step(8U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
    TEST_ASSERT_EQUAL_HEX8((uint8_t)~memory_file.octets[0], memory_ram[0]);
}

/// A second user protects the memory while a load of the first one is under way.
static void a_protection_ends_a_load_from_a_file(void)
{
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 2U);
    memory_add_file_area(RAM_BASE, 0U, 3000U, 0U);
    memory_add_file_area(RAM_BASE + 3500U, 0U, 1U, 0U);
    memory_request(19U);
    memory_step(4U); // The checksum is checked, and the first slice is loaded.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(memory_file.octets, memory_ram, PUS_MEMORY_SLICE);
    TEST_ASSERT_EQUAL_HEX8((uint8_t)(PUS_MEMORY_SLICE * 7U), memory_ram[PUS_MEMORY_SLICE]);
    const uint32_t loading = bench.request_id;
    memory_begin(RAM);
    memory_request(15U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    memory_step(3U);
    EXPECT_MESSAGES(1, 8);
    bench.request_id = loading;
    expect_failure(0U, 8U, PUS_FAILURE_PROTECTED, 1U, RAM);
    TEST_ASSERT_EQUAL_HEX8((uint8_t)(PUS_MEMORY_SLICE * 7U), memory_ram[PUS_MEMORY_SLICE]);
    TEST_ASSERT_EQUAL_HEX8((uint8_t)(3500U * 7U), memory_ram[3500]);
    TEST_ASSERT_EQUAL_UINT(1U, memory_file.closes);
}

static void areas_are_dumped_to_a_file_one_after_the_other(void)
{
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 2U);
    memory_add_area(RAM_BASE + 100U, 2000U);
    memory_add_area(RAM_BASE, 7U);
    memory_request(20U);
    memory_step(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(2007U, memory_file.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&memory_ram[100], memory_file.octets, 2000U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(memory_ram, &memory_file.octets[2000], 7U);
    expect_strict_format(20U, memory_data, memory_writer.position);
    memory_begin_object(RAM, 7U);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(4U, 4U);
    memory_request(22U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&memory_ram[0x104], memory_file.octets, 4U);
    expect_strict_format(22U, memory_data, memory_writer.position);
}

static void a_dump_to_a_file_ends_with_its_first_failure(void)
{
    memory_hardware.broken_at = RAM_BASE + 5U;
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 3U);
    memory_add_area(RAM_BASE, 5U);
    memory_add_area(RAM_BASE + 5U, 5U);
    memory_add_area(RAM_BASE + 20U, 5U);
    memory_request(20U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 2U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT32(5U, memory_file.size);
    memory_hardware.broken_at = 0U;
    memory_file.write         = STATUS_FULL;
    memory_request(20U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    memory_file.write = STATUS_OK;
    memory_file.close = STATUS_IO;
    memory_request(20U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    memory_hardware.broken_at = RAM_BASE + 5U;
    memory_request(20U);
    memory_step(1U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 2U, STATUS_IO); // The first failure is reported.
}

static void a_file_that_cannot_be_opened_refuses_the_request(void)
{
    static const struct {
        status_t status;
        uint16_t code;
        uint32_t detail;
    } cases[] = {
        {STATUS_NOT_FOUND, PUS_FAILURE_UNKNOWN_ID, 1U},
        {STATUS_INVALID, PUS_FAILURE_UNKNOWN_ID, 1U},
        {STATUS_EXISTS, PUS_FAILURE_EXISTS, 1U},
        {STATUS_FORBIDDEN, PUS_FAILURE_STATE, 1U},
        {STATUS_EXHAUSTED, PUS_FAILURE_IO, STATUS_EXHAUSTED},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        memory_file.open = cases[i].status;
        memory_begin(RAM);
        memory_name_file();
        octet_write_u8(&memory_writer, 1U);
        memory_add_area(RAM_BASE, 1U);
        memory_request(20U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, cases[i].code, 0U, cases[i].detail);
    }
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(RAM_BASE, 0U, 1U, 0U);
    memory_request(19U);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_EXHAUSTED);
    memory_start_with(NULL);
    memory_request(19U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 1U);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void a_file_whose_areas_are_all_refused_is_closed_or_not_made(void)
{
    memory_begin(ROM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_file_area(0U, 0U, 1U, 0U);
    memory_request(19U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_PROTECTED, 1U, ROM);
    TEST_ASSERT_EQUAL_UINT(1U, memory_file.closes);
    memory_begin(RAM);
    memory_name_file();
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(0U, 1U);
    memory_request(20U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    TEST_ASSERT_EQUAL_UINT32(FILE_OCTETS, memory_file.size);
    memory_step(1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void a_dump_continues_when_the_one_before_it_has_ended(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 1U);
    memory_request(5U);
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 3000U);
    memory_request(5U);
    memory_step(4U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 6, 1, 7, 6, 6, 6, 6, 6, 6, 1, 7);
}

/// The request was transferred in parts and is well-formed.
static void a_request_longer_than_a_packet_is_refused(void)
{
    static uint8_t octets[5000];
    octets[0] = RAM;
    octets_put_u16(&octets[1], sizeof octets - 20U);
    octets[sizeof octets - 15U] = 1U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request_large(19U, octets, sizeof octets));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, PUS_TC_DATA_MAX);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_large_dump_becomes_many_reports);
    RUN_TEST(objects_are_dumped_by_their_offset);
    RUN_TEST(as_many_areas_as_a_request_may_name_are_dumped);
    RUN_TEST(a_dump_without_a_valid_area_starts_no_operation);
    RUN_TEST(a_dump_waits_while_no_report_is_taken);
    RUN_TEST(an_unreadable_area_is_omitted_from_a_dump);
    RUN_TEST(all_dumps_are_ended_together);
    RUN_TEST(a_dump_continues_when_the_one_before_it_has_ended);
    RUN_TEST(a_check_of_raw_areas_reports_their_checksums_and_refuses_an_address_outside);
    RUN_TEST(objects_are_checked_in_parts_and_completely);
    RUN_TEST(an_unreadable_area_is_omitted_from_a_check);
    RUN_TEST(raw_areas_are_loaded_from_a_file);
    RUN_TEST(an_object_is_loaded_from_a_file);
    RUN_TEST(a_file_with_a_wrong_checksum_changes_nothing);
    RUN_TEST(a_load_from_a_file_that_fails_is_reported);
    RUN_TEST(a_load_from_a_file_to_an_address_that_cannot_be_read_changes_nothing);
    RUN_TEST(a_protection_ends_a_load_from_a_file);
    RUN_TEST(areas_are_dumped_to_a_file_one_after_the_other);
    RUN_TEST(a_dump_to_a_file_ends_with_its_first_failure);
    RUN_TEST(a_file_that_cannot_be_opened_refuses_the_request);
    RUN_TEST(a_file_whose_areas_are_all_refused_is_closed_or_not_made);
    RUN_TEST(a_request_longer_than_a_packet_is_refused);
    return UNITY_END();
}
