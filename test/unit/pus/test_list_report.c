// SPDX-License-Identifier: Apache-2.0
#include "pus/list_report.h"

#include "test/unit/pus/reports.h"
#include "unity.h"

static pus_list_report_t list;

void setUp(void)
{
    bench_start();
}

void tearDown(void)
{
}

static void begin(const uint8_t* const prefix, const size_t size)
{
    const pus_list_target_t target = {
        .process = &bench.process, .service = 12U, .subtype = 9U, .destination = 5U, .now_ns = TEST_NOW_NS};
    pus_list_report_begin(&list, &target, prefix, size);
}

static void an_empty_list_is_one_packet(void)
{
    begin(NULL, 0U);
    TEST_ASSERT_EQUAL(PUS_DONE, pus_list_report_end(&list).kind);
    EXPECT_MESSAGES(12, 9);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(0U).size);
    TEST_ASSERT_EQUAL_UINT16(0U, octets_u16_at(bench_report(0U).data));
    TEST_ASSERT_EQUAL_UINT16(5U, bench_report(0U).destination);
}

/// Fill with entries of `size` octets; each packet repeats the prefix and counts its own.
static void expect_split(const size_t size, const unsigned entries)
{
    static const uint8_t prefix[] = {1, 2, 3, 4};
    const size_t each             = (PUS_TM_DATA_MAX - sizeof(prefix) - 2U) / size;
    bench_clear();
    begin(prefix, sizeof prefix);
    for (unsigned i = 0U; i < entries; i++) {
        uint8_t* const octets = octet_write_space(pus_list_report_entry(&list, size), size);
        TEST_ASSERT_NOT_NULL(octets);
        octets[0] = (uint8_t)i;
    }
    TEST_ASSERT_EQUAL(PUS_DONE, pus_list_report_end(&list).kind);
    unsigned seen = 0U;
    for (size_t p = 0U; p < bench.count; p++) {
        const pus_tm_t tm    = bench_report(p);
        const uint16_t count = octets_u16_at(&tm.data[4]);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(prefix, tm.data, sizeof prefix);
        TEST_ASSERT_EQUAL_UINT64(6U + (count * size), tm.size);
        TEST_ASSERT_EQUAL_UINT64(((p + 1U) < bench.count) ? each : ((entries - 1U) % each) + 1U, count);
        for (size_t i = 0U; i < count; i++) {
            TEST_ASSERT_EQUAL_UINT8(seen % 256U, tm.data[6U + (i * size)]);
            seen++;
        }
    }
    TEST_ASSERT_EQUAL_UINT(entries, seen);
}

static void entries_go_over_as_many_packets_as_needed(void)
{
    expect_split(1000U, 4U);
    expect_split(1000U, 5U);
    expect_split(1U, (unsigned)PUS_TM_DATA_MAX - 6U);
    expect_split(1U, (unsigned)PUS_TM_DATA_MAX - 5U);
    expect_split(PUS_LIST_ENTRY_MAX, 3U);
}

static void what_is_lost_is_told(void)
{
    begin(NULL, 0U);
    bench.refusals = 100U; // The process keeps two of three.
    for (unsigned i = 0U; i < 3U; i++) {
        (void)octet_write_space(pus_list_report_entry(&list, 3500U), 3500U);
    }
    const pus_reply_t reply = pus_list_report_end(&list);
    TEST_ASSERT_EQUAL(PUS_FAILED, reply.kind);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_SOME_FAILED, reply.failure.code);
    TEST_ASSERT_EQUAL_UINT32(1U, reply.failure.detail);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_empty_list_is_one_packet);
    RUN_TEST(entries_go_over_as_many_packets_as_needed);
    RUN_TEST(what_is_lost_is_told);
    return UNITY_END();
}
