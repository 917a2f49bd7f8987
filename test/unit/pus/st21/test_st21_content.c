// SPDX-License-Identifier: Apache-2.0
// Request sequences from files and from records. The numbers of requests and reports are subtypes;
// pus/catalogue/st21_sequences.txt has their names and fields.
#include "pus/st21/st21_sequences.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "test/unit/pus/fixtures/st21_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    st21_fixture_set_up();
}

void tearDown(void)
{
    records_start();
    TEST_ASSERT_EQUAL_UINT(0U, st21_fixture.file.open);
}

static void a_file_is_loaded_and_may_be_activated_at_once(void)
{
    st21_fixture_begin_file(2U);
    st21_fixture_add(1U, 50U, 0);
    st21_fixture_add(2U, 5000U - 4000U, TICKS);
    st21_fixture_end_file();
    st21_fixture_reference('a', 2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_reference('b', 8U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    st21_fixture_step(MS);
    EXPECT_RELEASED(1, 2);
    st21_fixture_reference('b', 8U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, DETAIL('b'));
}

static void a_file_that_cannot_be_opened_is_refused_with_the_reason(void)
{
    static const struct {
        status_t status;
        uint16_t code;
    } cases[] = {{STATUS_NOT_FOUND, PUS_FAILURE_UNKNOWN_ID},
                 {STATUS_FORBIDDEN, PUS_FAILURE_STATE},
                 {STATUS_INVALID, PUS_FAILURE_OUT_OF_RANGE},
                 {STATUS_EXHAUSTED, PUS_FAILURE_TABLE_FULL}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        st21_fixture.file.open_status = cases[i].status;
        st21_fixture_reference('a', (i == 0U) ? 8U : 2U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, cases[i].code, 0U, 0U);
    }
    st21_fixture.file.open_status = STATUS_IO;
    st21_fixture_reference('a', 2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    st21_fixture.service.config.files = NULL;
    st21_fixture_reference('a', 2U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 0U);
}

static void a_sequence_file_of_wrong_size_is_refused(void)
{
    st21_fixture_begin_file(1U);
    st21_fixture_add(1U, 0U, TICKS);
    st21_fixture_end_file();
    const uint32_t whole = st21_fixture.file.size;
    for (st21_fixture.file.size = 1U; st21_fixture.file.size < whole; st21_fixture.file.size++) {
        st21_fixture_reference('a', 2U);
        expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 0U, 1U);
    }
    st21_fixture.file.size = 0U;
    st21_fixture_reference('a', 2U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    st21_fixture.file.size = whole + 1U;
    st21_fixture_reference('a', 2U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, whole);
    st21_fixture.file.size        = whole;
    st21_fixture.file.read_status = STATUS_IO;
    st21_fixture_reference('a', 2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    st21_fixture.file.size = OCTETS_MAX + 1U;
    st21_fixture_reference('a', 2U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, OCTETS_MAX);
    st21_fixture.file.read_status = STATUS_OK;
    st21_fixture_start(SEQUENCES, 100U);
    st21_fixture.file.size = 10000U;
    st21_fixture_reference('a', 2U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 100U);
    TEST_ASSERT_EQUAL_UINT16(0U, st21_fixture.chains.pool.stats.taken);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_sequences_restore(self, key, octets, size);
}

static void restart(void)
{
    records_cut();
    st21_fixture.config.persistence = records_port();
    bench_start();
    pus_dispatcher_persist(&bench.dispatcher, records_port());
    st21_fixture_start(SEQUENCES, SEQUENCE_BLOCKS);
    st21_fixture.service.config.octets_max = 30000U;
    (void)records_replay(PUS_SERVICE_SEQUENCES, restore, &st21_fixture.service);
}

static void loaded_sequences_outlive_a_power_cut(void)
{
    restart();
    st21_fixture_load('a', 1U, 2U);
    st21_fixture_load('b', 3U, 1U);
    st21_fixture_make_long_file();
    st21_fixture_reference('c', 8U);
    st21_fixture_step(0U); // The sequence is being executed.
    released.count = 0U;
    st21_fixture_command(3U, 'b');
    restart();
    st21_fixture.writer = octet_writer(st21_fixture.data, sizeof st21_fixture.data);
    st21_fixture_request(6U);
    TEST_ASSERT_EQUAL_UINT64(2U + (2U * 9U), bench_report(2U).size);
    st21_fixture_step(MS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    st21_fixture_command(9U, 'c');
    octet_reader_t reader = bench_data(2U);
    (void)octet_read_octets(&reader, 8U);
    TEST_ASSERT_EQUAL_HEX16(crc16_ccitt(st21_fixture.file.octets, st21_fixture.file.size),
                            octet_read_u16(&reader));
    st21_fixture_command(4U, 'a');
    st21_fixture_step(2U * MS);
    EXPECT_RELEASED(1);
    st21_fixture_command(5U, 'a');
    st21_fixture_command(3U, 'a');
    st21_fixture_command(3U, 'c');
    restart();
    st21_fixture.writer = octet_writer(st21_fixture.data, sizeof st21_fixture.data);
    st21_fixture_request(13U);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
    TEST_ASSERT_EQUAL_UINT16(0U, st21_fixture.chains.pool.stats.taken);
}

static void a_change_that_cannot_be_stored_is_not_acknowledged(void)
{
    restart();
    st21_fixture_make_long_file();
    records.put_status   = STATUS_FULL;
    records.refuse_after = 2U;
    st21_fixture_reference('a', 8U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_EQUAL_UINT(2U, records.erasures);
    TEST_ASSERT_EQUAL_UINT16(0U, st21_fixture.chains.pool.stats.taken);
    records.put_status = STATUS_OK;
    st21_fixture_load('a', 1U, 1U);
    records.erase_status = STATUS_IO;
    st21_fixture_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    records.erase_status = STATUS_NOT_FOUND;
    st21_fixture_command(3U, 'a');
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void an_impossible_record_is_refused(void)
{
    uint8_t octets[64]  = {'a', 'q'};
    st21_fixture.writer = octet_writer(&octets[12], 50U);
    octet_write_u8(&st21_fixture.writer, 1U);
    st21_fixture_add(1U, 0U, TICKS);
    const size_t size  = 12U + st21_fixture.writer.position;
    const uint32_t key = 0x01000000U;
    octets[11]         = 21U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, 0U, octets, size));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, key, octets, 11U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, key, octets, 12U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, key, octets, size + 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, key | 1U, octets, size));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      pus_sequences_restore(&st21_fixture.service, key | 0x40000U, octets, size));
    st21_fixture.service.config.octets_max = 20U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_sequences_restore(&st21_fixture.service, key, octets, size));
    st21_fixture.service.config.octets_max = 21U; // A size that is just sufficient.
    octets[13] ^= 0x10U;                          // The packet is not a request.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_sequences_restore(&st21_fixture.service, key, octets, size));
    octets[13] ^= 0x10U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_sequences_restore(&st21_fixture.service, key, octets, size));
    st21_fixture.service.config.octets_max = OCTETS_MAX;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, pus_sequences_restore(&st21_fixture.service, key, octets, size));
    TEST_ASSERT_EQUAL(STATUS_EXISTS,
                      pus_sequences_restore(&st21_fixture.service, key | 0x10000U, octets, size));
    octets[0]  = 'b'; // The first of two parts.
    octets[11] = 22U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_sequences_restore(&st21_fixture.service, key | 0x10000U, octets, size));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_sequences_restore(&st21_fixture.service, key | 0x10000U, octets, 13U));
    octets[11] = 23U;
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_sequences_restore(&st21_fixture.service, key | 0x10001U, octets, 13U));
    octets[11] = 22U;
    octets[0]  = 'c'; // The second part belongs to another sequence.
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_sequences_restore(&st21_fixture.service, key | 0x10001U, octets, 13U));
    TEST_ASSERT_EQUAL_UINT16(2U, st21_fixture.chains.pool.stats.taken);
    st21_fixture_load('b', 1U, 1U); // The slot can be used for another sequence.
    TEST_ASSERT_EQUAL_UINT16(2U, st21_fixture.chains.pool.stats.taken);
    st21_fixture_start(SEQUENCES, 1U);
    octets[11] = 100U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_sequences_restore(&st21_fixture.service, key, octets, 12U + 50U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      pus_sequences_restore(&st21_fixture.service, key | 1U, octets, 12U + 50U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_file_is_loaded_and_may_be_activated_at_once);
    RUN_TEST(a_file_that_cannot_be_opened_is_refused_with_the_reason);
    RUN_TEST(a_sequence_file_of_wrong_size_is_refused);
    RUN_TEST(loaded_sequences_outlive_a_power_cut);
    RUN_TEST(a_change_that_cannot_be_stored_is_not_acknowledged);
    RUN_TEST(an_impossible_record_is_refused);
    return UNITY_END();
}
