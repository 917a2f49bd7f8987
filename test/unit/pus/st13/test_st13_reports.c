// SPDX-License-Identifier: Apache-2.0
// Downlink of reports that are longer than a packet, in parts. The numbers of requests and reports are
// subtypes; pus/catalogue/st13_large_packets.txt has their names and fields.
#include "pus/st13/st13_large_packets.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define REPORTS 2U
#define REPORT_SIZE 20000U

static pus_large_t large;
static pus_large_report_t reports[REPORTS + 1U]; // The service must not use the last one.
static uint8_t report_octets[REPORTS * REPORT_SIZE];
static pus_large_uplink_t uplink;
static uint8_t uplink_octets[PUS_PACKET_MAX];
static octet_writer_t writer;
static uint8_t whole[PUS_LARGE_MAX]; // Octets of the downlink, assembled from the parts.
static size_t whole_size;

/// These tests use no uplink.
static status_t take(void* const context, const uint8_t* const packet, const size_t size,
                     const uint64_t now_ns)
{
    (void)context;
    (void)packet;
    (void)size;
    (void)now_ns;
    return STATUS_OK;
}

static size_t limit(void* const context, const uint16_t apid)
{
    (void)context;
    (void)apid;
    return PUS_PACKET_MAX;
}

static void start(const size_t report_size)
{
    memset(reports, 0xA5, sizeof reports);
    memset(&large, 0xA5, sizeof large);
    pus_large_init(&large, &(pus_large_config_t){.process        = &bench.process,
                                                 .reports        = reports,
                                                 .report_octets  = report_octets,
                                                 .report_count   = REPORTS,
                                                 .report_size    = report_size,
                                                 .parts_per_step = 4U,
                                                 .uplinks        = &uplink,
                                                 .uplink_octets  = uplink_octets,
                                                 .uplink_count   = 1U,
                                                 .uplink_size    = PUS_PACKET_MAX,
                                                 .timeout_ns     = 1U,
                                                 .limit          = limit,
                                                 .take           = take});
}

void setUp(void)
{
    bench_start();
    start(REPORT_SIZE);
    bench_serve(pus_large_service(&large));
}

void tearDown(void)
{
    TEST_ASSERT_EACH_EQUAL_HEX8(0xA5U, &reports[REPORTS], sizeof reports[REPORTS]);
}

static void step(const uint64_t now_ns)
{
    bench_step(now_ns, 1U);
}

static status_t post(const size_t size, const uint8_t first)
{
    TEST_ASSERT_EQUAL(STATUS_OK, pus_large_begin(&large, 3U, 25U, TEST_SOURCE, TEST_NOW_NS, &writer));
    for (size_t i = 0U; i < size; i++) {
        octet_write_u8(&writer, (uint8_t)(first + (i % 251U)));
    }
    return pus_large_post(&large, &writer);
}

/// Assemble the parts among the reports of the fixture, from report `index` on. Returns the index after them.
static size_t put_together(size_t index, const uint16_t transaction)
{
    bool is_last = false;
    whole_size   = 0U;
    for (uint16_t number = 1U; !is_last; number++) {
        const pus_tm_t tm = bench_report(index);
        TEST_ASSERT_EQUAL_UINT8(13U, tm.service);
        TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, tm.destination);
        is_last = (tm.subtype == 3U);
        TEST_ASSERT_EQUAL_UINT8(is_last ? 3U : ((number == 1U) ? 1U : 2U), tm.subtype);
        octet_reader_t reader = octet_reader(tm.data, tm.size);
        TEST_ASSERT_EQUAL_UINT16(transaction, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(number, octet_read_u16(&reader));
        const size_t size = octet_reader_left(&reader);
        TEST_ASSERT_TRUE((size == PUS_LARGE_PART) || (is_last && (size > 0U) && (size < PUS_LARGE_PART)));
        memcpy(&whole[whole_size], octet_read_octets(&reader, size), size);
        whole_size += size;
        index++;
    }
    return index;
}

/// Expect that the assembled octets are a report with `size` octets of source data.
static void expect_whole(const size_t size, const uint8_t first, const uint16_t counter)
{
    TEST_ASSERT_EQUAL_UINT64(size + PUS_TM_MIN, whole_size);
    TEST_ASSERT_EQUAL_HEX16(0U, crc16_ccitt(whole, whole_size));
    TEST_ASSERT_EQUAL_UINT64(whole_size - 7U, octets_u16_at(&whole[4]));
    TEST_ASSERT_EQUAL_HEX16(0x0800U | TEST_APID, octets_u16_at(whole));
    TEST_ASSERT_EQUAL_UINT8(3U, whole[7]);
    TEST_ASSERT_EQUAL_UINT8(25U, whole[8]);
    TEST_ASSERT_EQUAL_UINT16(counter, octets_u16_at(&whole[9]));
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, octets_u16_at(&whole[11]));
    for (size_t i = 0U; i < size; i++) {
        TEST_ASSERT_EQUAL_UINT8((uint8_t)(first + (i % 251U)), whole[PUS_TM_HEADER_SIZE + i]);
    }
}

static unsigned run(void)
{
    unsigned steps = 0U;
    for (; pus_large_is_busy(&large); steps++) {
        TEST_ASSERT_TRUE(steps < 1000U);
        step(TEST_NOW_NS);
    }
    return steps;
}

static void a_report_that_fits_is_sent_as_it_is(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, post(PUS_TM_DATA_MAX, 1U));
    EXPECT_MESSAGES(3, 25);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(0U).size);
    TEST_ASSERT_EQUAL_UINT8(2U, bench_report(0U).data[1]);
    TEST_ASSERT_FALSE(pus_large_is_busy(&large));
    TEST_ASSERT_EQUAL(STATUS_OK, post(0U, 1U));
    EXPECT_MESSAGES(3, 25, 3, 25);
    TEST_ASSERT_EQUAL_UINT16(1U, bench_report(1U).counter);
}

static void a_longer_report_is_sent_in_parts(void)
{
    static const size_t sizes[] = {PUS_TM_DATA_MAX + 1U, (PUS_LARGE_PART * 20U) - PUS_TM_MIN,
                                   (PUS_LARGE_PART * 20U) - PUS_TM_MIN + 1U, REPORT_SIZE - PUS_TM_MIN};
    for (uint16_t i = 0U; i < 4U; i++) {
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, post(sizes[i], (uint8_t)i));
        TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
        const size_t parts = ((sizes[i] + PUS_TM_MIN) + (PUS_LARGE_PART - 1U)) / PUS_LARGE_PART;
        TEST_ASSERT_EQUAL_UINT64((parts + 3U) / 4U, run());
        TEST_ASSERT_EQUAL_UINT64(parts, bench.count);
        TEST_ASSERT_EQUAL_UINT64(parts, put_together(0U, i));
        expect_whole(sizes[i], (uint8_t)i, i);
        // A large report has the sequence count of its first part.
        TEST_ASSERT_EQUAL_HEX16(0xC000U | bench_report(0U).sequence, octets_u16_at(&whole[2]));
    }
    TEST_ASSERT_EQUAL_UINT32(4U, large.counters.reports);
}

static void the_longest_report_is_sent(void)
{
    static pus_large_report_t one[1];
    static uint8_t octets[PUS_LARGE_MAX];
    pus_large_config_t config = large.config;
    config.reports            = one;
    config.report_octets      = octets;
    config.report_count       = 1U;
    config.report_size        = PUS_LARGE_MAX;
    memset(&large, 0xA5, sizeof large);
    pus_large_init(&large, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, post(PUS_LARGE_MAX - PUS_TM_MIN, 3U));
    (void)run();
    (void)put_together(0U, 0U);
    expect_whole(PUS_LARGE_MAX - PUS_TM_MIN, 3U, 0U);
}

static void a_report_larger_than_the_buffer_is_not_sent(void)
{
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, post((REPORT_SIZE - PUS_TM_MIN) + 1U, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.oversized);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL(STATUS_OK, post(5000U, 2U));
    (void)run();
    (void)put_together(0U, 0U);
    expect_whole(5000U, 2U, 0U);
}

static void reports_follow_one_another(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, post(5000U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, post(6000U, 2U));
    TEST_ASSERT_EQUAL(STATUS_FULL, pus_large_begin(&large, 3U, 25U, TEST_SOURCE, TEST_NOW_NS, &writer));
    TEST_ASSERT_EQUAL_UINT32(1U, large.counters.refused);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(4U, bench.count);
    step(TEST_NOW_NS);
    step(TEST_NOW_NS); // The first report is complete with its tenth part.
    TEST_ASSERT_EQUAL(STATUS_OK, post(7000U, 3U));
    (void)run();
    size_t end = put_together(0U, 0U);
    expect_whole(5000U, 1U, 0U);
    end = put_together(end, 1U);
    expect_whole(6000U, 2U, 1U);
    end = put_together(end, 2U);
    expect_whole(7000U, 3U, 2U);
    TEST_ASSERT_EQUAL_UINT64(bench.count, end);
}

static void no_part_is_lost_when_the_port_refuses_reports(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, post(9000U, 1U));
    for (unsigned i = 0U; pus_large_is_busy(&large); i++) {
        TEST_ASSERT_TRUE(i < 1000U);
        bench.refusals = i % 3U;
        step(TEST_NOW_NS);
    }
    (void)put_together(0U, 0U);
    expect_whole(9000U, 1U, 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.process.counters.kept);
}

/// A process whose service has a report longer than a packet sends it in parts.
static void a_process_may_have_long_reports(void)
{
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, pus_tm_data_max(&bench.process));
    const pus_long_port_t port = pus_large_port(&large);
    pus_app_process_lengthen(&bench.process, &port);
    TEST_ASSERT_EQUAL_UINT64(REPORT_SIZE - PUS_TM_MIN, pus_tm_data_max(&bench.process));
    for (size_t i = 0U; i <= (REPORTS + 1U); i++) {
        const size_t size = (i == 0U) ? PUS_TM_DATA_MAX : (PUS_TM_DATA_MAX + 1U);
        const status_t status =
            pus_tm_begin_sized(&bench.process, 3U, 25U, TEST_SOURCE, TEST_NOW_NS, size, &writer);
        TEST_ASSERT_EQUAL((i <= REPORTS) ? STATUS_OK : STATUS_FULL, status);
        for (size_t k = 0U; (status == STATUS_OK) && (k < size); k++) {
            octet_write_u8(&writer, 1U);
        }
        if (status == STATUS_OK) {
            TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_post_sized(&bench.process, &writer));
        }
        TEST_ASSERT_EQUAL((i > 0U), pus_large_is_busy(&large));
    }
    EXPECT_MESSAGES(3, 25);
}

/// The table of message type counters is full: a long report is sent with counter 0, like a short one.
static void a_long_report_without_a_message_type_counter_is_counted(void)
{
    for (uint16_t i = 0U; i < PUS_MESSAGE_COUNTERS; i++) {
        octet_writer_t report = pus_tm_begin(&bench.process, 17U, 2U, i, TEST_NOW_NS);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &report));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, post(5000U, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.uncounted);
    (void)run();
    (void)put_together(PUS_MESSAGE_COUNTERS, 0U);
    expect_whole(5000U, 1U, 0U);
}

/// The length field of a packet cannot hold a greater size.
static void more_than_the_longest_report_cannot_be_closed(void)
{
    static uint8_t octets[PUS_LARGE_MAX + 1U];
    size_t size = 9U;
    writer = pus_tm_begin_large(&bench.process, octets, sizeof octets, 3U, 25U, TEST_SOURCE, TEST_NOW_NS);
    while (!writer.failed && (writer.position < (sizeof octets - PUS_CRC_SIZE))) {
        octet_write_u8(&writer, 1U);
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tm_close_large(&bench.process, &writer, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.oversized);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_report_that_fits_is_sent_as_it_is);
    RUN_TEST(a_longer_report_is_sent_in_parts);
    RUN_TEST(the_longest_report_is_sent);
    RUN_TEST(a_report_larger_than_the_buffer_is_not_sent);
    RUN_TEST(reports_follow_one_another);
    RUN_TEST(no_part_is_lost_when_the_port_refuses_reports);
    RUN_TEST(a_process_may_have_long_reports);
    RUN_TEST(a_long_report_without_a_message_type_counter_is_counted);
    RUN_TEST(more_than_the_longest_report_cannot_be_closed);
    return UNITY_END();
}
