// SPDX-License-Identifier: Apache-2.0
// Reports of scheduled activities, some of which take several packets and steps. The numbers of requests and
// reports are subtypes; pus/catalogue/st11_time_schedule.txt has their names and fields.
#include "pus/st11/st11_time_schedule.h"

#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "test/unit/pus/fixtures/st11_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    st11_fixture_set_up();
}

void tearDown(void)
{
    records_start();
}

static void a_detail_report_holds_the_request(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    st11_fixture_create_group(G, 1U);
    st11_fixture_begin_insert(SS, 2U);
    st11_fixture_add(G, 4U * S, 1U, 100U);
    st11_fixture_add(G, 3U * S, 2U, 7U);
    st11_fixture_expect_done(4U);
    for (unsigned form = 0U; form < 3U; form++) {
        st11_fixture_begin();
        if (form == 1U) {
            st11_fixture_write_filter_all();
        } else if (form == 2U) {
            octet_write_u8(&st11_fixture.writer, 2U);
            st11_fixture_write_id(1U);
            st11_fixture_write_id(2U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request((form == 0U) ? 16U : ((form == 1U) ? 11U : 9U)));
        EXPECT_MESSAGES(1, 1, 1, 3, 11, 10, 1, 7);
        TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
        octet_reader_t reader = bench_data(2U);
        TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
        for (uint16_t i = 2U; i >= 1U; i--) {
            const size_t size = request_make(i, (i == 1U) ? 100U : 7U, packet);
            uint64_t time_ns  = 0U;
            TEST_ASSERT_EQUAL_UINT8(SS, octet_read_u8(&reader));
            TEST_ASSERT_EQUAL_UINT8(G, octet_read_u8(&reader));
            TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(&reader, &time_ns));
            TEST_ASSERT_EQUAL_UINT64((TEST_EPOCH_S + 5U - i) * S, time_ns);
            TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, octet_read_octets(&reader, size), size);
        }
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
}

static void a_report_by_identifier_is_ordered_by_time(void)
{
    static const uint8_t expected[] = {7, 2, 4};
    st11_fixture_insert_ten();
    st11_fixture_begin_ids(5U);
    st11_fixture_write_id(7U);
    st11_fixture_write_id(99U);
    st11_fixture_write_id(2U);
    st11_fixture_write_id(98U);
    st11_fixture_write_id(4U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(12U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 11, 13, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, (RELEASE_APID << 16U) | 99U);
    expect_failure(5U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    octet_reader_t reader = bench_data(4U);
    TEST_ASSERT_EQUAL_UINT16(3U, octet_read_u16(&reader));
    for (uint8_t i = 0U; i < 3U; i++) {
        const uint8_t sequence = expected[(i + 1U) % 3U]; // 2, 4, 7.
        TEST_ASSERT_EQUAL_UINT8(sequence % 2U, octet_read_u8(&reader));
        TEST_ASSERT_EQUAL_UINT8(G + (sequence % 3U), octet_read_u8(&reader));
        (void)octet_read_octets(&reader, 8U);
        TEST_ASSERT_EQUAL_UINT16(RELEASE_SOURCE, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(RELEASE_APID, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(sequence, octet_read_u16(&reader));
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    st11_fixture_begin_ids(1U);
    st11_fixture_write_id(99U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(9U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    st11_fixture_begin(); // Activities of one report do not occur in the next report.
    st11_fixture_write_window(2U, 3U * S, 0U);
    octet_write_u8(&st11_fixture.writer, 1U);
    octet_write_u8(&st11_fixture.writer, 1U);
    octet_write_u8(&st11_fixture.writer, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(14U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 13, 1, 7);
    reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(5U, octet_read_u16(&reader));
}

/// There are 600 activities: their summary needs three packets, and their details more packets than one step
/// may send.
static void insert_600(void)
{
    st11_fixture_create_group(G, 1U);
    for (uint16_t i = 0U; i < 600U; i += 10U) {
        st11_fixture_begin_insert(SS, 10U);
        for (uint16_t k = 0U; k < 10U; k++) {
            st11_fixture_add(G, (1000U - i - k) * S, (uint16_t)(i + k), 20U);
        }
        st11_fixture_expect_done(4U);
    }
}

static void a_report_that_does_not_fit_is_split(void)
{
    insert_600();
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(17U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 13, 11, 13, 11, 13, 1, 7);
    uint16_t expected = 599U;
    for (size_t i = 2U; i < 5U; i++) {
        octet_reader_t reader = bench_data(i);
        const uint16_t count  = octet_read_u16(&reader);
        TEST_ASSERT_EQUAL_UINT16((i < 4U) ? 254U : 92U, count);
        for (uint16_t k = 0U; k < count; k++) {
            (void)octet_read_octets(&reader, 14U);
            TEST_ASSERT_EQUAL_UINT16(expected, octet_read_u16(&reader));
            expected--;
        }
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
}

static unsigned details_so_far(const size_t from)
{
    unsigned count = 0U;
    for (size_t i = from; i < bench.count; i++) {
        octet_reader_t reader = bench_data(i);
        count += (bench_report(i).service == 11U) ? octet_read_u16(&reader) : 0U;
    }
    return count;
}

static void a_long_report_continues_in_later_steps(void)
{
    insert_600();
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(16U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 10, 11, 10, 11, 10, 11, 10);
    TEST_ASSERT_TRUE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
    const uint32_t asked = bench.request_id;
    bench_clear();
    st11_fixture_begin(); // While the report continues, a second one is refused.
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(17U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 10U);
    st11_fixture_begin_ids(1U);
    st11_fixture_write_id(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(12U));
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 10U);
    bench_clear();
    pus_time_schedule_step(&st11_fixture.schedule, TEST_NOW_NS);
    EXPECT_MESSAGES(11, 10, 11, 10, 11, 10, 1, 7);
    octet_reader_t reader = bench_data(3U);
    TEST_ASSERT_EQUAL_HEX32(asked, octet_read_u32(&reader));
    TEST_ASSERT_FALSE(pus_schedule_is_waiting(&st11_fixture.schedule.schedule));
    st11_fixture_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(16U));
    pus_time_schedule_step(&st11_fixture.schedule, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT(600U, details_so_far(2U));
}

static void packets_of_a_report_that_the_port_refuses_are_sent_later(void)
{
    st11_fixture_insert_ten();
    bench.ack = 0U;
    st11_fixture_begin_ids(2U);
    st11_fixture_write_id(3U);
    st11_fixture_write_id(99U);
    bench.refusals = 2U; // TM[1,4] and the report after it wait.
    TEST_ASSERT_EQUAL(STATUS_OK, st11_fixture_request(12U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_TRUE(st11_fixture.schedule.schedule.report.is_active);
    bench.refusals = 1U;
    pus_time_schedule_step(&st11_fixture.schedule, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    pus_time_schedule_step(&st11_fixture.schedule, TEST_NOW_NS);
    EXPECT_MESSAGES(1, 4, 11, 13, 1, 8);
    octet_reader_t reader = bench_data(1U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader)); // The entry of the refused packet.
    expect_failure(2U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_detail_report_holds_the_request);
    RUN_TEST(a_report_by_identifier_is_ordered_by_time);
    RUN_TEST(a_report_that_does_not_fit_is_split);
    RUN_TEST(a_long_report_continues_in_later_steps);
    RUN_TEST(packets_of_a_report_that_the_port_refuses_are_sent_later);
    return UNITY_END();
}
