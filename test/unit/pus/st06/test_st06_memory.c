// SPDX-License-Identifier: Apache-2.0
// Loads of memory, write protection and scrubbing. The numbers of requests and reports are subtypes;
// pus/catalogue/st06_memory.txt has their names and fields.
#include "pus/st06/st06_memory.h"

#include "base/crc.h"
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/memories.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    memories_start();
}

void tearDown(void)
{
}

// ---- Loads ----

static void raw_areas_are_loaded_and_read_back(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 2U);
    memory_add_data(RAM_BASE, "first", 5U, 0U);
    memory_add_data(RAM_BASE + sizeof memory_ram - 4U, "last", 4U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_STRING_LEN("first", memory_ram, 5U);
    TEST_ASSERT_EQUAL_STRING_LEN("last", &memory_ram[sizeof memory_ram - 4U], 4U);
    TEST_ASSERT_EQUAL_UINT32(2U, memory_service.counters.loaded);
    expect_strict_format(2U, memory_data, memory_writer.position);
}

static void an_area_larger_than_a_slice_is_loaded_whole(void)
{
    static uint8_t octets[PUS_MEMORY_SLICE + 500U];
    memset(octets, 0x5A, sizeof octets);
    octets[sizeof octets - 1U] = 1U;
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(RAM_BASE + 1U, octets, sizeof octets, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, &memory_ram[1], sizeof octets);
    memory_hardware.stuck_at = RAM_BASE + 3U;
    octets[2]                = 0U;
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(RAM_BASE + 1U, octets, sizeof octets, 0U);
    memory_request(2U);
    expect_failure(2U, 8U, PUS_FAILURE_VERIFY, 1U, crc16_ccitt(&memory_ram[1], sizeof octets));
}

static void object_areas_are_loaded_by_their_offset(void)
{
    memory_begin_object(RAM, 7U);
    octet_write_u8(&memory_writer, 3U);
    memory_add_data(255U, "x", 1U, 0U);
    memory_add_data(255U, "yy", 2U, 0U); // One octet beyond the object, not beyond the memory.
    memory_add_data(256U, "z", 1U, 0U);
    memory_request(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_ADDRESS, 2U, 255U);
    expect_failure(3U, 4U, PUS_FAILURE_ADDRESS, 3U, 256U);
    TEST_ASSERT_EQUAL_HEX8('x', memory_ram[0x1FF]);
    expect_strict_format(1U, memory_data, memory_writer.position);
}

static void each_bad_area_is_refused_alone(void)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 5U);
    memory_add_data(RAM_BASE - 1U, "aa", 2U, 0U);
    memory_add_data(RAM_BASE + sizeof memory_ram - 1U, "bb", 2U, 0U);
    memory_add_data(RAM_BASE, "", 0U, 0U);
    memory_add_data(RAM_BASE, "cc", 2U, 1U);
    memory_add_data(RAM_BASE + 9U, "dd", 2U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 4, 1, 3, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_ADDRESS, 1U, RAM_BASE - 1U);
    expect_failure(2U, 4U, PUS_FAILURE_ADDRESS, 2U, RAM_BASE + sizeof memory_ram - 1U);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 22U);
    expect_failure(4U, 4U, PUS_FAILURE_DATA_CHECKSUM, 4U, crc16_ccitt((const uint8_t*)"cc", 2U));
    expect_failure(6U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 4U);
    TEST_ASSERT_EQUAL_STRING_LEN("dd", &memory_ram[9], 2U);
    TEST_ASSERT_EQUAL_HEX8(0U, memory_ram[0]);
}

static void addresses_at_the_end_of_the_range_do_not_wrap(void)
{
    memory_begin(WORDS);
    octet_write_u8(&memory_writer, 3U);
    memory_add_data(0xFFFFFFFCU, "last", 4U, 0U);
    memory_add_data(0xFFFFFFFCU, "beyond..", 8U, 0U);
    memory_add_data(0U, "zero", 4U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    TEST_ASSERT_EQUAL_STRING_LEN("last", &memory_words[60], 4U);
    TEST_ASSERT_EQUAL_HEX8(0U, memory_words[0]);
}

static void an_unaligned_area_is_refused(void)
{
    memory_begin(WORDS);
    octet_write_u8(&memory_writer, 2U);
    memory_add_data(0xFFFFFFC2U, "abcd", 4U, 0U);
    memory_add_data(WORDS_BASE, "abcde", 5U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_ADDRESS, 1U, 0xFFFFFFC2U);
    expect_failure(2U, 4U, PUS_FAILURE_ADDRESS, 2U, WORDS_BASE);
}

static void unknown_memories_and_objects_are_refused(void)
{
    memory_begin(9U);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(0U, "a", 1U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 9U);
    memory_begin_object(RAM, 6U);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(0U, "a", 1U, 0U);
    memory_request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 6U);
    memory_begin_object(ROM, 7U); // ROM has no objects.
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(0U, 1U);
    memory_request(3U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 7U);
}

static void data_that_read_back_differently_fail_the_request(void)
{
    memory_hardware.stuck_at = RAM_BASE + 2U;
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 3U);
    memory_add_data(RAM_BASE, "abcd", 4U, 0U);
    memory_add_data(RAM_BASE + 2U, "e", 1U, 0U);
    memory_add_data(RAM_BASE + 8U, "f", 1U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_VERIFY, 1U, crc16_ccitt(memory_ram, 4U));
    TEST_ASSERT_EQUAL_HEX8('f', memory_ram[8]);
    TEST_ASSERT_EQUAL_UINT32(1U, memory_service.counters.loaded);
    TEST_ASSERT_EQUAL_UINT32(2U, memory_service.counters.refused);
}

static void an_access_that_fails_fails_the_request(void)
{
    memory_hardware.broken_at = RAM_BASE + 1U;
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(RAM_BASE, "abcd", 4U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_IO);
    memory_hardware.refuses_writes = true;
    memory_begin(WORDS);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(WORDS_BASE, "abcd", 4U, 0U);
    memory_request(2U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 1U, STATUS_FORBIDDEN);
}

static void add_bits(const uint32_t address, const uint32_t mask, const uint32_t bits)
{
    octet_write_u32(&memory_writer, address);
    octet_write_u32(&memory_writer, mask);
    octet_write_u32(&memory_writer, bits);
}

static void bits_of_an_area_are_loaded_by_one_write(void)
{
    memory_begin(WORDS);
    add_bits(0xFFFFFFC4U, 0xFF00000FU, 0xAABBCCDDU);
    memory_request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0xAAU, 5U, 6U, 0x0DU}), &memory_words[4], 4U);
    expect_strict_format(11U, memory_data, memory_writer.position);
    memory_begin(RAM);
    // The address is aligned for the memory, but not for the size of the access.
    add_bits(RAM_BASE + 2U, 0U, 0U);
    memory_request(11U);
    expect_failure(1U, 4U, PUS_FAILURE_ADDRESS, 0U, RAM_BASE + 2U);
    memory_begin(ROM);
    add_bits(0U, 0U, 0U);
    memory_request(11U);
    expect_failure(1U, 4U, PUS_FAILURE_PROTECTED, 0U, ROM);
    memory_begin(9U);
    add_bits(0U, 0U, 0U);
    memory_request(11U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 9U);
}

static void bits_that_cannot_be_loaded_fail_the_request(void)
{
    memory_hardware.broken_at = RAM_BASE;
    memory_begin(RAM);
    add_bits(RAM_BASE, 0U, 0U);
    memory_request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    memory_hardware.broken_at = 0U;
    memory_hardware.stuck_at  = RAM_BASE;
    memory_begin(RAM);
    add_bits(RAM_BASE, 0xFFFFFFFFU, 0x11223344U);
    memory_request(11U);
    expect_failure(2U, 8U, PUS_FAILURE_VERIFY, 0U, crc16_ccitt(memory_ram, 4U));
}

// ---- Protection and scrubbing ----

static void a_protected_memory_takes_no_load(void)
{
    memory_begin(RAM);
    memory_request(15U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(15U, memory_data, memory_writer.position);
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(RAM_BASE, "ab", 2U, 0U);
    memory_request(2U);
    expect_failure(1U, 4U, PUS_FAILURE_PROTECTED, 1U, RAM);
    memory_begin(RAM);
    memory_request(16U);
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_data(RAM_BASE, "ab", 2U, 0U);
    memory_request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    memory_begin(9U);
    memory_request(15U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 9U);
}

static void a_scrubbed_memory_is_read_repeatedly_from_start_to_end(void)
{
    memory_step(3U);
    TEST_ASSERT_EQUAL_UINT(0U, memory_hardware.scrubs);
    memory_begin(RAM);
    memory_request(13U);
    memory_request(13U); // A second request has no effect.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    memory_step(4U);
    TEST_ASSERT_EQUAL_UINT32(sizeof memory_ram, memory_hardware.scrubbed);
    TEST_ASSERT_EQUAL_HEX32(RAM_BASE + (3U * PUS_MEMORY_SLICE), memory_hardware.scrubbed_at);
    TEST_ASSERT_EQUAL_UINT32(1U, memory_service.counters.passes);
    memory_step(1U);
    TEST_ASSERT_EQUAL_HEX32(RAM_BASE, memory_hardware.scrubbed_at);
    memory_request(14U);
    memory_step(3U);
    TEST_ASSERT_EQUAL_UINT(5U, memory_hardware.scrubs);
    memory_begin(ROM);
    memory_request(13U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, ROM);
}

static void protection_and_scrubbing_outlive_a_restart(void)
{
    memory_begin(RAM);
    memory_request(13U);
    memory_request(15U);
    memory_begin(WORDS);
    memory_request(15U);
    memory_request(16U);
    memory_start_with(&memory_files);
    (void)records_replay(PUS_SERVICE_MEMORY, pus_memory_restore, &memory_service);
    memory_step(1U);
    TEST_ASSERT_EQUAL_UINT(1U, memory_hardware.scrubs);
    memory_begin(RAM);
    add_bits(RAM_BASE, 0U, 0U);
    memory_request(11U);
    expect_failure(1U, 4U, PUS_FAILURE_PROTECTED, 0U, RAM);
    memory_begin(WORDS);
    add_bits(WORDS_BASE, 0U, 0U);
    memory_request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void records_that_fit_no_memory_are_refused(void)
{
    static const uint8_t record[2] = {3U, 0U};
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_memory_restore(&memory_service, 0x101U, record, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_memory_restore(&memory_service, RAM, record, 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_memory_restore(&memory_service, RAM, (const uint8_t*)"\4", 1U));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, pus_memory_restore(&memory_service, ROM, record, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_memory_restore(&memory_service, RAM, record, 1U));
}

static void a_request_fails_when_its_record_cannot_be_stored(void)
{
    records.put_status = STATUS_IO;
    memory_begin(RAM);
    memory_request(15U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    memory_begin(RAM);
    add_bits(RAM_BASE, 0U, 0U);
    memory_request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7); // The memory is not protected.
    const pus_memory_config_t config = {.process      = &bench.process,
                                        .memories     = memory_list(),
                                        .states       = memory_states,
                                        .memory_count = 3U,
                                        .operations   = memory_operations};
    memset(&memory_service, 0xA5, sizeof memory_service);
    pus_memory_init(&memory_service, &config);
    memory_begin(RAM);
    memory_request(15U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7); // A memory without room for its record is not recorded.
    memory_begin(RAM);
    octet_write_u8(&memory_writer, 1U);
    memory_add_area(RAM_BASE, 1U);
    memory_request(5U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 0U);
}

static pus_memory_t odd;

static void begin_odd(void)
{
    const pus_memory_config_t config = {.process      = &bench.process,
                                        .memories     = &odd,
                                        .states       = memory_states,
                                        .memory_count = 1U,
                                        .operations   = memory_operations};
    memset(&memory_service, 0xA5, sizeof memory_service);
    pus_memory_init(&memory_service, &config);
}

static void impossible_memories_are_coding_errors(void)
{
    odd      = memory_list()[1];
    odd.base = 2U;
    TEST_ASSERT_TRUE(assertion_fails(begin_odd));
    odd.base = WORDS_BASE;
    odd.size = 68U;
    TEST_ASSERT_TRUE(assertion_fails(begin_odd));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(raw_areas_are_loaded_and_read_back);
    RUN_TEST(an_area_larger_than_a_slice_is_loaded_whole);
    RUN_TEST(object_areas_are_loaded_by_their_offset);
    RUN_TEST(each_bad_area_is_refused_alone);
    RUN_TEST(addresses_at_the_end_of_the_range_do_not_wrap);
    RUN_TEST(an_unaligned_area_is_refused);
    RUN_TEST(unknown_memories_and_objects_are_refused);
    RUN_TEST(data_that_read_back_differently_fail_the_request);
    RUN_TEST(an_access_that_fails_fails_the_request);
    RUN_TEST(bits_of_an_area_are_loaded_by_one_write);
    RUN_TEST(bits_that_cannot_be_loaded_fail_the_request);
    RUN_TEST(a_protected_memory_takes_no_load);
    RUN_TEST(a_scrubbed_memory_is_read_repeatedly_from_start_to_end);
    RUN_TEST(protection_and_scrubbing_outlive_a_restart);
    RUN_TEST(records_that_fit_no_memory_are_refused);
    RUN_TEST(a_request_fails_when_its_record_cannot_be_stored);
    RUN_TEST(impossible_memories_are_coding_errors);
    return UNITY_END();
}
