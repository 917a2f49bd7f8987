// SPDX-License-Identifier: Apache-2.0
// Loading of on-board procedures from requests, files and records. The numbers of requests and reports are
// subtypes; pus/catalogue/st18_procedures.txt has their names and fields.
#include "base/crc.h"
#include "test/unit/pus/fixtures/st18_fixture.h"
#include "unity.h"

#include <string.h>

#define ABCD 0x41424344U
#define FILE_NAME "\0\2/p\0\3a.b"
#define FILE_NAME_SIZE 9U

static pus_procedures_t* const self = &st18_fixture.service;

void setUp(void)
{
    st18_fixture_start();
    st18_fixture.file.size = 20U;
}

void tearDown(void)
{
}

static void expect_refused(const uint8_t subtype, const char* const id, const void* const data,
                           const size_t size, const uint16_t code, const uint32_t detail)
{
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(subtype, id, data, size));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 0U, detail);
}

/// Returns the number of loaded procedures, and the checksum of the first.
static uint16_t loaded(uint16_t* const out_checksum)
{
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    octet_reader_t reader = bench_data(2U);
    const uint16_t count  = octet_read_u16(&reader);
    (void)octet_read_octets(&reader, PUS_NAME_SIZE);
    *out_checksum = octet_read_u16(&reader);
    return count;
}

static void code_is_loaded_with_its_checksum(void)
{
    static const uint8_t code[] = {0, 9, '1', '2', '3', '4', '5', '6', '7', '8', '9', 0x29, 0xB1};
    static const uint8_t bad[]  = {0, 9, '1', '2', '3', '4', '5', '6', '7', '8', '9', 0x29, 0xB2};
    static const uint8_t none[] = {0, 0, 0xFF, 0xFF};
    uint16_t checksum           = 0U;
    expect_refused(1U, "ABCD", bad, sizeof bad, PUS_FAILURE_DATA_CHECKSUM, 0x29B1U);
    expect_refused(1U, "ABCD", none, sizeof none, PUS_FAILURE_TABLE_FULL, PUS_PROCEDURE_CODE_MAX);
    TEST_ASSERT_EQUAL_UINT16(0U, loaded(&checksum));
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(1U, "ABCD", code, sizeof code));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, loaded(&checksum));
    TEST_ASSERT_EQUAL_HEX16(0x29B1U, checksum);
    expect_refused(1U, "ABCD", code, sizeof code, PUS_FAILURE_EXISTS, ABCD);
    expect_refused(2U, "none", NULL, 0U, PUS_FAILURE_UNKNOWN_ID, 0x6E6F6E65U);
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(2U, "ABCD", NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(0U, loaded(&checksum));
}

static void the_table_accepts_its_capacity(void)
{
    static const uint8_t code[] = {0, 9, '1', '2', '3', '4', '5', '6', '7', '8', '9', 0x29, 0xB1};
    st18_fixture_load("A", 4000U, 'a');
    st18_fixture_load("B", 1U, 'a');
    st18_fixture_load("C", 1U, 'a');
    expect_refused(1U, "D", code, sizeof code, PUS_FAILURE_TABLE_FULL, ST18_FIXTURE_PROCEDURES);
    expect_refused(13U, "D", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_TABLE_FULL, ST18_FIXTURE_PROCEDURES);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.file.closed);
}

static void files_are_loaded_completely(void)
{
    uint16_t checksum      = 0U;
    st18_fixture.file.size = PUS_PROCEDURE_CODE_MAX;
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(13U, "ABCD", FILE_NAME, FILE_NAME_SIZE));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.file.closed);
    TEST_ASSERT_EQUAL_UINT16(1U, loaded(&checksum));
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(self->config.procedures[0].code, PUS_PROCEDURE_CODE_MAX), checksum);
    TEST_ASSERT_EQUAL_UINT(3U, records.puts);
    st18_fixture.file.size = PUS_PROCEDURE_CODE_MAX + 1U;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_TABLE_FULL, PUS_PROCEDURE_CODE_MAX);
    st18_fixture.file.size = 0U;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_TABLE_FULL, PUS_PROCEDURE_CODE_MAX);
    TEST_ASSERT_EQUAL_UINT(st18_fixture.file.opened, st18_fixture.file.closed);
}

static void files_that_fail_are_reported(void)
{
    st18_fixture.file.open = STATUS_NOT_FOUND;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_UNKNOWN_ID, 0U);
    st18_fixture.file.open = STATUS_INVALID;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_OUT_OF_RANGE, PUS_NAME_SIZE);
    st18_fixture.file.open = STATUS_FORBIDDEN;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_IO, STATUS_FORBIDDEN);
    st18_fixture.file.open = STATUS_OK;
    st18_fixture.file.read = STATUS_IO;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_IO, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.file.closed);
    self->config.files = NULL;
    expect_refused(13U, "B", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_ACCESS, 0U);
}

static void a_file_is_loaded_and_activated(void)
{
    // Path, file name, procedure, observability level 1, no arguments.
    static const uint8_t body[] = {0, 2, '/', 'p', 0, 3, 'a', '.', 'b', 'A', 'B', 'C', 'D', 0, 0, 0, 0, 1, 0};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(19U, body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 3);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_STARTED, 0U, 0U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(19U, body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, ABCD);
}

static void a_procedure_that_cannot_be_stored_is_not_loaded(void)
{
    uint16_t checksum      = 0U;
    st18_fixture.file.size = PUS_PROCEDURE_CODE_MAX;
    records.put_status     = STATUS_FULL;
    records.refuse_after   = 1U;
    expect_refused(13U, "ABCD", FILE_NAME, FILE_NAME_SIZE, PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_EQUAL_UINT(1U, records.erasures); // No part of the procedure remains.
    TEST_ASSERT_EQUAL_UINT16(0U, loaded(&checksum));
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.unsaved);
    records.put_status = STATUS_OK;
    st18_fixture_load("ABCD", 10U, 'x');
    records.erase_status = STATUS_IO;
    expect_refused(2U, "ABCD", NULL, 0U, PUS_FAILURE_IO, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT16(1U, loaded(&checksum));
    records.erase_status = STATUS_NOT_FOUND; // The store of records has lost the record.
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(2U, "ABCD", NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void without_a_store_all_requests_are_performed(void)
{
    self->config.persistence = NULL;
    st18_fixture_load("ABCD", 10U, 'x');
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(2U, "ABCD", NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(0U, records.puts);
}

/// A record of PUS_RECORD_MAX octets has name, size and checksum before its part of the code.
static void code_takes_as_few_records_as_possible(void)
{
    const uint32_t part                     = PUS_RECORD_MAX - PUS_NAME_SIZE - 4U;
    const uint32_t sizes[]                  = {1U, part, part + 1U};
    static const char* const names[]        = {"A", "B", "C"};
    static const unsigned records_of_each[] = {1U, 1U, 2U};
    for (unsigned i = 0U; i < 3U; i++) {
        const unsigned puts    = records.puts;
        st18_fixture.file.size = sizes[i];
        TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(13U, names[i], FILE_NAME, FILE_NAME_SIZE));
        TEST_ASSERT_EQUAL_UINT(records_of_each[i], records.puts - puts);
    }
    size_t size = 0U;
    TEST_ASSERT_NOT_NULL(records_find(PUS_SERVICE_PROCEDURES, (4U * 2U) + 1U, &size));
    TEST_ASSERT_EQUAL_UINT64(PUS_NAME_SIZE + 4U + 1U, size); // The second record of the third procedure.
}

static void code_outlasts_a_power_cut(void)
{
    uint16_t before        = 0U;
    uint16_t after         = 0U;
    st18_fixture.file.size = PUS_PROCEDURE_CODE_MAX;
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(13U, "LARGE", FILE_NAME, FILE_NAME_SIZE));
    st18_fixture_load("B", 100U, 'b');
    st18_fixture_activate("B", 0U);
    TEST_ASSERT_EQUAL_UINT16(2U, loaded(&before));
    st18_fixture_restart();
    TEST_ASSERT_EQUAL_UINT16(2U, loaded(&after));
    TEST_ASSERT_EQUAL_HEX16(before, after);
    TEST_ASSERT_EACH_EQUAL_HEX8('f', self->config.procedures[0].code, PUS_PROCEDURE_CODE_MAX);
    TEST_ASSERT_EQUAL_UINT16(100U, self->config.procedures[1].size);
    TEST_ASSERT_FALSE(pus_procedures_are_active(self));
    st18_fixture_activate("B", 0U);
}

/// The key of a record is 4 x the index of the procedure plus the number of the part of its code.
static void bad_records_are_reported(void)
{
    uint8_t record[PUS_RECORD_MAX] = {'A',  0,   0,   0,   0,   0,   0,   0,   0,   9,  0x29,
                                      0xB1, '1', '2', '3', '4', '5', '6', '7', '8', '9'};
    uint16_t checksum              = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_procedures_restore(self, 4U, record, 21U));
    TEST_ASSERT_EQUAL_UINT16(1U, loaded(&checksum));
    for (size_t i = 0U; i < 21U; i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_procedures_restore(self, 4U, record, i));
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_procedures_restore(self, 4U, record, 22U));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_procedures_restore(self, 5U, record, 21U)); // The code has no second part.
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      pus_procedures_restore(self, 4U * ST18_FIXTURE_PROCEDURES, record, 21U));
    record[20] = '8';
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_procedures_restore(self, 4U, record, 21U)); // The checksum is wrong.
    TEST_ASSERT_EQUAL_UINT16(0U, loaded(&checksum));
    record[8] = 0x40U;
    record[9] = 0x01U; // 16385 octets.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_procedures_restore(self, 0U, record, sizeof record));
    record[9] = 0x00U;
    // The first of three records.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_procedures_restore(self, 0U, record, sizeof record));
    TEST_ASSERT_EQUAL_UINT16(0U, loaded(&checksum));
    // A part of another procedure starts a new load, and so does a part with another size or checksum.
    record[0] = 'B';
    TEST_ASSERT_EQUAL(STATUS_OK, pus_procedures_restore(self, 1U, record, sizeof record));
    TEST_ASSERT_EQUAL_UINT8(2U, self->config.procedures[0].parts);
    record[11] = 0xB2U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_procedures_restore(self, 0U, record, sizeof record));
    TEST_ASSERT_EQUAL_UINT8(1U, self->config.procedures[0].parts);
    // The record of the engine: one octet.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_procedures_restore(self, 65535U, record, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_procedures_restore(self, 65535U, record, 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_procedures_restore(self, 65535U, NULL, 0U));
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t load[]         = {'A', 0, 0, 0, 0, 0, 0, 0, 0, 2, 'x', 'y', 1, 2};
    static const uint8_t name[]         = {'A', 0, 0, 0, 0, 0, 0, 0};
    static const uint8_t hold[]         = {'A', 0, 0, 0, 0, 0, 0, 0, 0, 1};
    static const uint8_t communicated[] = {'A', 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 5};
    static const uint8_t values[]       = {'A', 0, 0, 0, 0, 0, 0, 0, 3, 2, 1, 0, 5, 10, 1};
    static const uint8_t file[]         = {'A', 0, 0, 0, 0, 0, 0, 0, 0, 2, '/', 'p', 0, 1, 'a'};
    static const uint8_t both[]         = {0, 1, '/', 0, 1, 'a', 'A', 0, 0, 0, 0, 0, 0, 0, 1, 0};
    static const uint8_t levels[]       = {1, 'A', 0, 0, 0, 0, 0, 0, 0, 2};
    static const uint8_t by_name[]      = {2U, 6U, 12U, 15U};
    static const uint8_t by_hold[]      = {4U, 5U, 20U};
    static const uint8_t by_values[]    = {3U, 14U};
    static const uint8_t empty[]        = {8U, 17U, 21U, 22U};
    expect_strict_format(1U, load, sizeof load);
    expect_strict_format(13U, file, sizeof file);
    expect_strict_format(19U, both, sizeof both);
    expect_strict_format(16U, levels, sizeof levels);
    expect_strict_format(7U, communicated, sizeof communicated);
    for (size_t i = 0U; i < sizeof by_name; i++) {
        expect_strict_format(by_name[i], name, sizeof name);
    }
    for (size_t i = 0U; i < sizeof by_hold; i++) {
        expect_strict_format(by_hold[i], hold, sizeof hold);
    }
    for (size_t i = 0U; i < sizeof by_values; i++) {
        expect_strict_format(by_values[i], values, sizeof values);
    }
    for (size_t i = 0U; i < sizeof empty; i++) {
        expect_strict_format(empty[i], NULL, 0U);
    }
}

static void a_procedure_is_unloaded_while_another_runs(void)
{
    static const uint8_t next_step[] = {0, 0};
    st18_fixture_load("ABCD", 1U, 'x');
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_activate("B", 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(20U, "ABCD", next_step, sizeof next_step));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    const unsigned commits = records.commits;
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_call(1U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 8, 1, 5);
    TEST_ASSERT_EQUAL_UINT(commits + 1U, records.commits);
    TEST_ASSERT_EQUAL_UINT32(0U, self->counters.unsaved);
    expect_procedure_status(PUS_PROCEDURE_RUNNING); // Status of B, the only procedure that is loaded.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(code_is_loaded_with_its_checksum);
    RUN_TEST(the_table_accepts_its_capacity);
    RUN_TEST(files_are_loaded_completely);
    RUN_TEST(files_that_fail_are_reported);
    RUN_TEST(a_file_is_loaded_and_activated);
    RUN_TEST(a_procedure_that_cannot_be_stored_is_not_loaded);
    RUN_TEST(without_a_store_all_requests_are_performed);
    RUN_TEST(code_takes_as_few_records_as_possible);
    RUN_TEST(code_outlasts_a_power_cut);
    RUN_TEST(bad_records_are_reported);
    RUN_TEST(every_request_has_a_strict_format);
    RUN_TEST(a_procedure_is_unloaded_while_another_runs);
    return UNITY_END();
}
