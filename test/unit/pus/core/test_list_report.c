// SPDX-License-Identifier: Apache-2.0
// Reports that are lists: they are divided into packets, and a list that the port refuses continues in later
// steps.
#include "pus/core/list_report.h"

#include "test/unit/pus/fixtures/reports.h"
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

/// Fill a list with entries of `size` octets; each packet repeats the prefix and counts its own entries.
static void expect_split(const size_t size, const unsigned entries)
{
    static const uint8_t prefix[] = {1, 2, 3, 4};
    const size_t each             = (PUS_TM_DATA_MAX - sizeof prefix - 2U) / size;
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

static void entries_are_split_into_as_many_packets_as_needed(void)
{
    expect_split(1000U, 4U);
    expect_split(1000U, 5U);
    expect_split(1U, (unsigned)PUS_TM_DATA_MAX - 6U);
    expect_split(1U, (unsigned)PUS_TM_DATA_MAX - 5U);
    expect_split(PUS_LIST_ENTRY_MAX, 3U);
}

static void lost_reports_fail_the_request(void)
{
    begin(NULL, 0U);
    bench.refusals = 100U; // The port refuses all reports, and the process keeps no report of this class.
    for (unsigned i = 0U; i < 3U; i++) {
        (void)octet_write_space(pus_list_report_entry(&list, 3500U), 3500U);
    }
    const pus_reply_t reply = pus_list_report_end(&list);
    TEST_ASSERT_EQUAL(PUS_FAILED, reply.kind);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_SOME_FAILED, reply.failure.code);
    TEST_ASSERT_EQUAL_UINT32(3U, reply.failure.detail);
}

// ---- In answer to a request ----

enum {
    PACKETS = 5
};

static unsigned executions;
static bool was_whole;

/// Answer with a list that has one entry in each packet, after one instruction was refused.
static pus_reply_t answer(void* const self, pus_request_t* const request)
{
    (void)self;
    executions++;
    pus_request_refuse(request, 1U, PUS_FAILURE_UNKNOWN_ID, 9U);
    pus_request_perform(request);
    const pus_list_target_t target = pus_list_answer(request, 9U);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint32_t i = 0U; i < (uint32_t)PACKETS; i++) {
        octet_writer_t* const writer = pus_list_report_entry(&list, 3000U);
        octet_write_u32(writer, i);
        (void)octet_write_space(writer, 2996U);
    }
    const pus_reply_t reply = pus_list_report_end(&list);
    was_whole               = reply.kind == PUS_DONE;
    return reply;
}

static bool any_format(void* const self, octet_reader_t* const reader)
{
    (void)self;
    return (octet_reader_left(reader) == 0U) ||
           (octet_read_octets(reader, octet_reader_left(reader)) != NULL);
}

static void serve_list(void)
{
    static const pus_subtype_t subtypes[] = {{8U, any_format, answer, NULL}};
    bench_serve(pus_service_of(12U, subtypes, 1U, &list));
    executions = 0U;
}

static void expect_whole_list(const size_t first)
{
    for (uint32_t i = 0U; i < (uint32_t)PACKETS; i++) {
        const pus_tm_t tm = bench_report(first + i);
        TEST_ASSERT_EQUAL_UINT8(12U, tm.service);
        TEST_ASSERT_EQUAL_UINT32(i, octets_u32_at(&tm.data[2]));
        TEST_ASSERT_EQUAL_UINT16(first + i, tm.sequence);
    }
}

static void reports_that_the_port_refuses_are_sent_later_before_the_request_ends(void)
{
    serve_list();
    for (unsigned sent = 0U; sent <= (unsigned)PACKETS; sent++) {
        // The port is full after this number of packets of the list, until two steps have passed.
        bench_start();
        serve_list();
        bench.accepts = 3U + sent; // TM[1,1], TM[1,4] and TM[1,3] come before the list.
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "x", 1U));
        TEST_ASSERT_EQUAL_UINT64(3U + sent, bench.count);
        TEST_ASSERT_EQUAL(sent == (unsigned)PACKETS, was_whole);
        TEST_ASSERT_EQUAL(sent < (unsigned)PACKETS, pus_dispatcher_is_answering(&bench.dispatcher));
        for (unsigned step = 0U; step < 2U; step++) {
            bench_step(TEST_NOW_NS, step);
            TEST_ASSERT_EQUAL_UINT64(3U + sent, bench.count);
        }
        bench.accepts = 0U;
        bench_step(TEST_NOW_NS, 3U);
        EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 12, 9, 12, 9, 12, 9, 12, 9, 12, 9, 1, 8);
        expect_whole_list(3U);
        expect_failure(8U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U); // One of the instructions was refused.
        TEST_ASSERT_FALSE(pus_dispatcher_is_answering(&bench.dispatcher));
        bench_step(TEST_NOW_NS, 4U);
        TEST_ASSERT_EQUAL_UINT64(9U, bench.count);
    }
}

static void packets_are_sent_as_the_port_accepts_them(void)
{
    bench.accepts = 3U;
    serve_list();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "x", 1U));
    for (unsigned i = 1U; i < (unsigned)PACKETS; i++) {
        bench.accepts = 1U + bench.count;
        TEST_ASSERT_TRUE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
        TEST_ASSERT_EQUAL_UINT64(3U + i, bench.count);
    }
    bench.accepts = 0U;
    TEST_ASSERT_FALSE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
    expect_whole_list(3U);
    TEST_ASSERT_EQUAL_UINT32(PACKETS + 1U, executions);
}

static void a_request_without_data_is_also_postponed(void)
{
    serve_list();
    bench.accepts = 4U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    TEST_ASSERT_TRUE(pus_dispatcher_is_answering(&bench.dispatcher));
    bench.accepts = 0U;
    TEST_ASSERT_FALSE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
    expect_whole_list(3U);
    TEST_ASSERT_EQUAL_UINT(2U, executions);
}

/// The reports of acceptance and start wait, too; the list continues after them.
static void a_list_waits_for_reports_queued_before_it(void)
{
    serve_list();
    bench.accepts  = REPORTS_MAX;
    bench.refusals = 100U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "x", 1U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_TRUE(pus_app_process_is_waiting(&bench.process));
    TEST_ASSERT_TRUE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
    TEST_ASSERT_EQUAL_UINT(1U, executions); // The list is not executed again.
    bench.refusals = 0U;
    TEST_ASSERT_FALSE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 12, 9, 12, 9, 12, 9, 12, 9, 12, 9, 1, 8);
    expect_whole_list(3U);
}

static void a_second_list_during_the_first_fails_with_the_reason(void)
{
    serve_list();
    bench.accepts = 3U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "x", 1U)); // No part of the second list is sent.
    TEST_ASSERT_EQUAL_UINT64(3U, bench.count);
    bench.accepts = 0U;
    bench_step(TEST_NOW_NS, 1U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 1, 1, 4, 1, 3, 1, 8, 12, 9, 12, 9, 12, 9, 12, 9, 12, 9, 1, 8);
    expect_failure(6U, 8U, PUS_FAILURE_SOME_FAILED, 0U, PACKETS);
}

static void a_request_too_long_to_be_executed_again_fails_with_the_reason(void)
{
    static uint8_t data[PUS_RESUMED_DATA_MAX + 1U];
    serve_list();
    bench.accepts = 3U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, data, sizeof data));
    TEST_ASSERT_FALSE(pus_dispatcher_is_answering(&bench.dispatcher));
    bench.accepts = 0U;
    bench_step(TEST_NOW_NS, 1U);
    expect_failure(3U, 8U, PUS_FAILURE_SOME_FAILED, 0U, PACKETS);
    bench.accepts = bench.count;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, data, sizeof data - 1U));
    TEST_ASSERT_TRUE(pus_dispatcher_is_answering(&bench.dispatcher));
    bench.accepts = 0U;
    bench_step(TEST_NOW_NS, 2U);
    TEST_ASSERT_FALSE(pus_dispatcher_is_answering(&bench.dispatcher));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_empty_list_is_one_packet);
    RUN_TEST(entries_are_split_into_as_many_packets_as_needed);
    RUN_TEST(lost_reports_fail_the_request);
    RUN_TEST(reports_that_the_port_refuses_are_sent_later_before_the_request_ends);
    RUN_TEST(packets_are_sent_as_the_port_accepts_them);
    RUN_TEST(a_request_without_data_is_also_postponed);
    RUN_TEST(a_list_waits_for_reports_queued_before_it);
    RUN_TEST(a_second_list_during_the_first_fails_with_the_reason);
    RUN_TEST(a_request_too_long_to_be_executed_again_fails_with_the_reason);
    return UNITY_END();
}
