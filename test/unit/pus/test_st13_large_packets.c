// SPDX-License-Identifier: Apache-2.0
#include "pus/st13_large_packets.h"

#include "fsw/framework/base/crc.h"
#include "test/unit/pus/reports.h"
#include "unity.h"

#include <string.h>

#define REPORTS 2U
#define REPORT_SIZE 20000U
#define UPLINKS 2U
#define UPLINK_SIZE 16384U
#define TIMEOUT_NS 5000000000ULL
#define MS 1000000ULL

static pus_large_t large;
static pus_large_report_t reports[REPORTS];
static uint8_t report_octets[REPORTS * REPORT_SIZE];
static pus_large_uplink_t uplinks[UPLINKS];
static uint8_t uplink_octets[UPLINKS * UPLINK_SIZE];
static octet_writer_t writer;
static uint8_t data[PUS_TC_DATA_MAX];
static uint8_t whole[PUS_LARGE_MAX]; // What is sent up, or has come down.
static size_t whole_size;
static uint8_t taken[UPLINK_SIZE];
static size_t taken_size;
static status_t take_status;

static status_t take(void* const context, const uint8_t* const packet, const size_t size,
                     const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&taken_size, context);
    TEST_ASSERT_TRUE(now_ns >= TEST_NOW_NS);
    if (take_status == STATUS_OK) {
        memcpy(taken, packet, size);
        taken_size = size;
    }
    return take_status;
}

static void start(const size_t report_size)
{
    pus_large_init(&large, &(pus_large_config_t){.process        = &bench.process,
                                                 .reports        = reports,
                                                 .report_octets  = report_octets,
                                                 .report_count   = REPORTS,
                                                 .report_size    = report_size,
                                                 .parts_per_step = 4U,
                                                 .uplinks        = uplinks,
                                                 .uplink_octets  = uplink_octets,
                                                 .uplink_count   = UPLINKS,
                                                 .uplink_size    = UPLINK_SIZE,
                                                 .timeout_ns     = TIMEOUT_NS,
                                                 .context        = &taken_size,
                                                 .take           = take});
}

void setUp(void)
{
    bench_start();
    start(REPORT_SIZE);
    bench_serve(pus_large_service(&large));
    take_status = STATUS_OK;
    taken_size  = 0U;
}

void tearDown(void)
{
}

static void step(const uint64_t now_ns)
{
    pus_dispatcher_step(&bench.dispatcher, now_ns, 1U);
}

// --- down --------------------------------------------------------------------------------------------------

static status_t post(const size_t size, const uint8_t first)
{
    TEST_ASSERT_EQUAL(STATUS_OK, pus_large_begin(&large, 3U, 25U, TEST_SOURCE, TEST_NOW_NS, &writer));
    for (size_t i = 0U; i < size; i++) {
        octet_write_u8(&writer, (uint8_t)(first + (i % 251U)));
    }
    return pus_large_post(&large, &writer);
}

/// Put the parts among the reports of the bench together, from report `index` on. Returns where they end.
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

/// What came down is a report of `size` octets of source data.
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

static void a_longer_report_goes_in_parts(void)
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
        // It has the sequence count of its first part.
        TEST_ASSERT_EQUAL_HEX16(0xC000U | bench_report(0U).sequence, octets_u16_at(&whole[2]));
    }
    TEST_ASSERT_EQUAL_UINT32(4U, large.counters.reports);
}

static void the_longest_report_of_all_goes_too(void)
{
    static pus_large_report_t one[1];
    static uint8_t octets[PUS_LARGE_MAX];
    pus_large_config_t config = large.config;
    config.reports            = one;
    config.report_octets      = octets;
    config.report_count       = 1U;
    config.report_size        = PUS_LARGE_MAX;
    pus_large_init(&large, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, post(PUS_LARGE_MAX - PUS_TM_MIN, 3U));
    (void)run();
    (void)put_together(0U, 0U);
    expect_whole(PUS_LARGE_MAX - PUS_TM_MIN, 3U, 0U);
}

static void what_does_not_fit_the_buffer_is_not_sent(void)
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
    step(TEST_NOW_NS); // The first one is out with its tenth part.
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

static void a_port_that_takes_nothing_loses_no_part(void)
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

static void a_report_may_be_given_up(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, pus_large_begin(&large, 3U, 25U, TEST_SOURCE, TEST_NOW_NS, &writer));
    pus_large_cancel(&large);
    TEST_ASSERT_FALSE(pus_large_is_busy(&large));
    TEST_ASSERT_EQUAL(STATUS_OK, post(1U, 1U));
    EXPECT_MESSAGES(3, 25);
}

/// The table of message type counters is full: a long report is sent with 0, as a short one would be.
static void an_uncounted_report_is_told(void)
{
    for (uint16_t i = 0U; i < PUS_MESSAGE_COUNTERS; i++) {
        octet_writer_t report = pus_tm_begin(&bench.process, 17U, 2U, i, TEST_NOW_NS);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &report));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, post(5000U, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.uncounted);
}

/// No length field could tell it.
static void more_than_the_longest_report_cannot_be_closed(void)
{
    static uint8_t octets[PUS_LARGE_MAX + 1U];
    size_t size = 9U;
    writer = pus_tm_begin_large(&bench.process, octets, sizeof(octets), 3U, 25U, TEST_SOURCE, TEST_NOW_NS);
    while (!writer.failed && (writer.position < (sizeof(octets) - PUS_CRC_SIZE))) {
        octet_write_u8(&writer, 1U);
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tm_close_large(&bench.process, &writer, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.oversized);
}

// --- up ----------------------------------------------------------------------------------------------------

/// A request of `size` octets to be sent up.
static void make_request(const size_t size, const uint8_t service, const uint16_t source)
{
    TEST_ASSERT_TRUE((size >= PUS_TC_MIN) && (size <= sizeof(whole)));
    for (size_t i = 0U; i < size; i++) {
        whole[i] = (uint8_t)(i * 3U);
    }
    octets_put_u16(whole, 0x1800U | TEST_APID);
    octets_put_u16(&whole[2], 0xC000U);
    octets_put_u16(&whole[4], (uint16_t)(size - 7U));
    whole[6] = 0x2FU;
    whole[7] = service;
    whole[8] = 3U;
    octets_put_u16(&whole[9], source);
    octets_put_u16(&whole[size - 2U], crc16_ccitt(whole, size - 2U));
    whole_size = size;
}

static void send_part(const uint8_t subtype, const uint16_t transaction, const uint16_t number,
                      const uint8_t* const part, const size_t size)
{
    octet_writer_t request = octet_writer(data, sizeof(data));
    octet_write_u16(&request, transaction);
    octet_write_u16(&request, number);
    if (size > 0U) {
        octet_write_octets(&request, part, size);
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, request.position));
}

/// Send all parts but the last one, `step` octets each. Returns the number of the next part.
static uint16_t send_all_but_last(const uint16_t transaction, const size_t part)
{
    uint16_t number = 1U;
    size_t sent     = 0U;
    for (; (whole_size - sent) > part; sent += part) {
        send_part((number == 1U) ? 9U : 10U, transaction, number, &whole[sent], part);
        EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
        number++;
    }
    return number;
}

static void send_last(const uint16_t transaction, const uint16_t number, const size_t part)
{
    const size_t sent = (size_t)(number - 1U) * part;
    send_part(11U, transaction, number, &whole[sent], whole_size - sent);
}

static void expect_aborted(const size_t index, const uint16_t transaction, const uint8_t reason)
{
    const pus_tm_t tm = bench_report(index);
    TEST_ASSERT_EQUAL_UINT8(13U, tm.service);
    TEST_ASSERT_EQUAL_UINT8(16U, tm.subtype);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, tm.destination);
    octet_reader_t reader = octet_reader(tm.data, tm.size);
    TEST_ASSERT_EQUAL_UINT16(transaction, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT8(reason, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void parts_become_one_request(void)
{
    static const size_t sizes[][2] = {{UPLINK_SIZE, 512U}, {5000U, 4000U}, {PUS_TC_MIN, 7U}, {600U, 599U}};
    for (uint16_t i = 0U; i < 4U; i++) {
        make_request(sizes[i][0], 20U, TEST_SOURCE);
        const uint16_t last = send_all_but_last(i, sizes[i][1]);
        TEST_ASSERT_TRUE(pus_large_is_busy(&large));
        send_last(i, last, sizes[i][1]);
        EXPECT_MESSAGES(1, 1, 1, 3);
        TEST_ASSERT_EQUAL_UINT64(0U, taken_size);
        bench_clear();
        step(TEST_NOW_NS);
        EXPECT_MESSAGES(1, 7);
        TEST_ASSERT_EQUAL_UINT64(sizes[i][0], taken_size);
        TEST_ASSERT_EQUAL_MEMORY(whole, taken, taken_size);
        TEST_ASSERT_FALSE(pus_large_is_busy(&large));
        taken_size = 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(4U, large.counters.requests);
}

static void parts_out_of_order_end_the_uplink(void)
{
    static const uint16_t wrong[] = {0U, 1U, 2U, 4U, 65535U};
    make_request(5000U, 20U, TEST_SOURCE);
    for (size_t i = 0U; i < 5U; i++) {
        send_part(9U, 7U, 1U, whole, 512U);
        send_part(10U, 7U, 2U, &whole[512], 512U);
        send_part((i == 3U) ? 11U : 10U, 7U, wrong[i], &whole[1024], 512U);
        EXPECT_MESSAGES(1, 1, 13, 16, 1, 4);
        expect_aborted(1U, 7U, PUS_LARGE_DISCONTINUITY);
        expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 2U);
        send_part(10U, 7U, 3U, &whole[1024], 512U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 7U);
    }
    send_part(9U, 7U, 2U, whole, 512U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 2U);
    TEST_ASSERT_EQUAL_UINT32(5U, large.counters.aborted);
}

static void parts_without_octets_are_refused(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, NULL, 0U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 4U);
    send_part(9U, 7U, 1U, whole, 512U);
    send_part(10U, 7U, 2U, NULL, 0U);
    EXPECT_MESSAGES(1, 1, 13, 16, 1, 4);
    expect_aborted(1U, 7U, PUS_LARGE_INTERNAL);
    expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 4U);
}

static void a_transaction_that_begins_anew_goes_on(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, whole, 512U);
    send_part(9U, 7U, 1U, whole, 4000U);
    EXPECT_MESSAGES(1, 1, 13, 16, 1, 3, 1, 7);
    expect_aborted(1U, 7U, PUS_LARGE_DISCONTINUITY);
    send_last(7U, 2U, 4000U);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(5000U, taken_size);
}

/// What waits to be taken is no uplink any more: its number may serve again.
static void a_whole_request_is_not_begun_anew(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    take_status = STATUS_FULL;
    send_last(7U, send_all_but_last(7U, 4000U), 4000U);
    send_part(9U, 7U, 1U, whole, 4000U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    send_last(7U, 2U, 4000U);
    EXPECT_MESSAGES(1, 1, 1, 3);
    take_status = STATUS_OK;
    step(TEST_NOW_NS);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(2U, large.counters.requests);
    TEST_ASSERT_EQUAL_UINT32(0U, large.counters.aborted);
}

static void sources_number_their_transactions_on_their_own(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, whole, 4000U);
    bench.source = TEST_SOURCE + 1U;
    send_part(10U, 7U, 2U, &whole[4000], 500U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    send_part(9U, 7U, 1U, whole, 512U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench.source = TEST_SOURCE;
    send_last(7U, 2U, 4000U);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(5000U, taken_size);
    TEST_ASSERT_EQUAL_MEMORY(whole, taken, taken_size);
    TEST_ASSERT_TRUE(pus_large_is_busy(&large)); // With the other one's.
}

static void too_long_a_request_is_given_up(void)
{
    make_request(UPLINK_SIZE + 1U, 20U, TEST_SOURCE);
    const uint16_t last = send_all_but_last(7U, 4000U);
    send_last(7U, last, 4000U);
    EXPECT_MESSAGES(1, 1, 13, 16, 1, 4);
    expect_aborted(1U, 7U, PUS_LARGE_INTERNAL);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 0U, UPLINK_SIZE);
}

static void all_buffers_may_be_taken(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 1U, 1U, whole, 4000U);
    send_part(9U, 2U, 1U, whole, 4000U);
    send_part(9U, 3U, 1U, whole, 4000U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, UPLINKS);
    send_last(2U, 2U, 4000U);
    send_last(1U, 2U, 4000U);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT32(2U, large.counters.requests);
}

static void expect_no_request(const uint32_t detail)
{
    const uint16_t last = send_all_but_last(7U, 4000U);
    send_last(7U, last, 4000U);
    EXPECT_MESSAGES(1, 1, 13, 16, 1, 4);
    expect_aborted(1U, 7U, PUS_LARGE_INTERNAL);
    expect_failure(2U, 4U, PUS_FAILURE_EMBEDDED, 0U, detail);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, taken_size);
}

static void what_is_no_request_is_not_taken(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    whole[4999] ^= 1U; // Its checksum.
    expect_no_request(5000U);
    make_request(5000U, 20U, TEST_SOURCE);
    whole_size = 4999U; // Its length.
    expect_no_request(4999U);
    make_request(5000U, 20U, TEST_SOURCE + 1U);
    expect_no_request(9U);
    make_request(5000U, 13U, TEST_SOURCE);
    expect_no_request(7U);
}

static void an_uplink_that_stops_is_given_up(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, whole, 512U);
    bench_clear();
    step((TEST_NOW_NS + TIMEOUT_NS) - 1U);
    EXPECT_MESSAGES(0);
    step(TEST_NOW_NS + TIMEOUT_NS);
    EXPECT_MESSAGES(13, 16);
    expect_aborted(0U, 7U, PUS_LARGE_TIMEOUT);
    TEST_ASSERT_FALSE(pus_large_is_busy(&large));
}

static void a_request_that_is_not_taken_is_offered_again(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    take_status   = STATUS_FULL;
    uint16_t last = send_all_but_last(7U, 4000U);
    send_last(7U, last, 4000U);
    bench_clear();
    step(TEST_NOW_NS);
    step(TEST_NOW_NS + MS);
    EXPECT_MESSAGES(0);
    take_status = STATUS_OK;
    step(TEST_NOW_NS + (2U * MS));
    EXPECT_MESSAGES(1, 7);
    take_status = STATUS_FULL;
    last        = send_all_but_last(7U, 4000U);
    send_last(7U, last, 4000U);
    bench_clear();
    step(TEST_NOW_NS + TIMEOUT_NS);
    EXPECT_MESSAGES(13, 16, 1, 8);
    expect_aborted(0U, 7U, PUS_LARGE_INTERNAL);
    expect_failure(1U, 8U, PUS_FAILURE_TIMEOUT, 0U, (uint32_t)(TIMEOUT_NS / MS));
}

/// A dispatcher takes in what came in parts, and nothing else that is as long.
static void a_large_request_is_dispatched(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_dispatch(&bench.dispatcher, whole, whole_size, TEST_NOW_NS));
    bench.request_id = octets_u32_at(whole);
    expect_failure(0U, 2U, PUS_FAILURE_LENGTH, 0U, 5000U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_dispatch_large(&bench.dispatcher, whole, whole_size, TEST_NOW_NS));
    expect_failure(0U, 2U, PUS_FAILURE_SERVICE, 0U, 20U);
    bench_clear();
    make_request(5000U, 13U, TEST_SOURCE); // A first part of 4987 octets: a service that takes any length.
    whole[8] = 9U;
    octets_put_u16(&whole[13], 1U);
    octets_put_u16(&whole[4998], crc16_ccitt(whole, 4998U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_dispatch_large(&bench.dispatcher, whole, whole_size, TEST_NOW_NS));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void every_request_has_a_strict_shape(void)
{
    for (uint8_t subtype = 9U; subtype <= 11U; subtype++) {
        for (size_t size = 0U; size < 4U; size++) {
            bench_clear();
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, data, size));
            EXPECT_MESSAGES(1, 2);
        }
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(16U, data, 3U));
    expect_failure(0U, 2U, PUS_FAILURE_SUBTYPE, 0U, (13U << 8U) | 16U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_report_that_fits_is_sent_as_it_is);
    RUN_TEST(a_longer_report_goes_in_parts);
    RUN_TEST(the_longest_report_of_all_goes_too);
    RUN_TEST(what_does_not_fit_the_buffer_is_not_sent);
    RUN_TEST(reports_follow_one_another);
    RUN_TEST(a_port_that_takes_nothing_loses_no_part);
    RUN_TEST(a_report_may_be_given_up);
    RUN_TEST(an_uncounted_report_is_told);
    RUN_TEST(more_than_the_longest_report_cannot_be_closed);
    RUN_TEST(parts_become_one_request);
    RUN_TEST(parts_out_of_order_end_the_uplink);
    RUN_TEST(parts_without_octets_are_refused);
    RUN_TEST(a_transaction_that_begins_anew_goes_on);
    RUN_TEST(a_whole_request_is_not_begun_anew);
    RUN_TEST(sources_number_their_transactions_on_their_own);
    RUN_TEST(too_long_a_request_is_given_up);
    RUN_TEST(all_buffers_may_be_taken);
    RUN_TEST(what_is_no_request_is_not_taken);
    RUN_TEST(an_uplink_that_stops_is_given_up);
    RUN_TEST(a_request_that_is_not_taken_is_offered_again);
    RUN_TEST(a_large_request_is_dispatched);
    RUN_TEST(every_request_has_a_strict_shape);
    return UNITY_END();
}
