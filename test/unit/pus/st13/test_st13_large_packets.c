// SPDX-License-Identifier: Apache-2.0
// Uplink of large packets in parts. The numbers of requests and reports are subtypes;
// pus/catalogue/st13_large_packets.txt has their names and fields.
#include "pus/st13/st13_large_packets.h"

#include "base/crc.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define REPORTS 2U
#define REPORT_SIZE 20000U
#define UPLINKS 2U
#define UPLINK_SIZE 16384U
#define TIMEOUT_NS 5000000000ULL
#define MS 1000000ULL

static pus_large_t large;
static pus_large_report_t reports[REPORTS + 1U]; // The last one does not belong to the service.
static uint8_t report_octets[REPORTS * REPORT_SIZE];
static pus_large_uplink_t uplinks[UPLINKS + 1U]; // Likewise.
static uint8_t uplink_octets[UPLINKS * UPLINK_SIZE];
static uint8_t data[PUS_TC_DATA_MAX];
static uint8_t whole[PUS_LARGE_MAX]; // Request for the uplink.
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

static size_t limit(void* const context, const uint16_t apid)
{
    TEST_ASSERT_EQUAL_PTR(&taken_size, context);
    return (apid == TEST_APID) ? PUS_LARGE_MAX : PUS_PACKET_MAX;
}

static void start(const size_t report_size)
{
    memset(reports, 0xA5, sizeof reports);
    memset(uplinks, 0xA5, sizeof uplinks);
    memset(&large, 0xA5, sizeof large);
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
                                                 .limit          = limit,
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
    bench_step(now_ns, 1U);
}

/// Compose a request of `size` octets for the uplink.
static void make_request(const size_t size, const uint8_t service, const uint16_t source)
{
    TEST_ASSERT_TRUE((size >= PUS_TC_MIN) && (size <= sizeof whole));
    for (size_t i = 0U; i < size; i++) {
        whole[i] = (uint8_t)(i * 3U);
    }
    octets_put_u16(whole, 0x1800U | TEST_APID);
    octets_put_u16(&whole[2], 0xC000U);
    octets_put_u16(&whole[4], (uint16_t)(size - 7U));
    whole[6] = 0x2FU; // PUS version 2; acknowledge all stages.
    whole[7] = service;
    whole[8] = 3U;
    octets_put_u16(&whole[9], source);
    octets_put_u16(&whole[size - 2U], crc16_ccitt(whole, size - 2U));
    whole_size = size;
}

static void send_part(const uint8_t subtype, const uint16_t transaction, const uint16_t number,
                      const uint8_t* const part, const size_t size)
{
    octet_writer_t request = octet_writer(data, sizeof data);
    octet_write_u16(&request, transaction);
    octet_write_u16(&request, number);
    if (size > 0U) {
        octet_write_octets(&request, part, size);
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, request.position));
}

/// Send all parts but the last one, `part` octets each. Returns the number of the next part.
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
    static const size_t sizes[][2] = {// Octets of the request, and of a part.
                                      {UPLINK_SIZE, 512U},
                                      {5000U, 4000U},
                                      {PUS_TC_MIN, 7U},
                                      {600U, 599U},
                                      {600U, 5U}};
    for (uint16_t i = 0U; i < 5U; i++) {
        make_request(sizes[i][0], 20U, TEST_SOURCE);
        const uint16_t last = send_all_but_last(i, sizes[i][1]);
        TEST_ASSERT_FALSE(pus_large_is_busy(&large)); // The uplink waits for a part.
        send_last(i, last, sizes[i][1]);
        TEST_ASSERT_TRUE(pus_large_is_busy(&large));
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
    TEST_ASSERT_EQUAL_UINT32(5U, large.counters.requests);
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
    expect_aborted(1U, 7U, PUS_LARGE_NOT_ACCEPTED);
    expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 4U);
}

static void a_transaction_that_starts_again_replaces_its_first_uplink(void)
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

/// A complete request that waits for its receiver is no longer an uplink, so its transaction number may be
/// used again.
static void a_complete_request_is_not_received_again(void)
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

static void each_source_numbers_its_own_transactions(void)
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
}

static void expect_too_long(const size_t longest)
{
    EXPECT_MESSAGES(1, 1, 13, 16, 1, 4);
    expect_aborted(1U, 7U, PUS_LARGE_NOT_ACCEPTED);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 0U, (uint32_t)longest);
}

static void a_request_whose_length_field_is_too_large_is_aborted_at_once(void)
{
    make_request(UPLINK_SIZE + 1U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, whole, 600U);
    expect_too_long(UPLINK_SIZE);
    send_part(9U, 7U, 1U, whole, 5U); // Half a length field gives no length.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    send_part(10U, 7U, 2U, &whole[5], 1U);
    expect_too_long(UPLINK_SIZE);
}

static void a_request_with_too_small_a_length_field_is_aborted_at_the_limit(void)
{
    make_request(UPLINK_SIZE + 1U, 20U, TEST_SOURCE);
    octets_put_u16(&whole[4], 6U);
    const uint16_t last = send_all_but_last(7U, 4000U);
    send_last(7U, last, 4000U);
    expect_too_long(UPLINK_SIZE);
}

/// A complete request for another process must fit a packet.
static void a_request_to_another_process_may_have_another_limit(void)
{
    make_request(PUS_PACKET_MAX + 1U, 20U, TEST_SOURCE);
    octets_put_u16(whole, 0x1800U | (TEST_APID + 1U));
    send_part(9U, 7U, 1U, whole, 600U);
    expect_too_long(PUS_PACKET_MAX);
    make_request(PUS_PACKET_MAX, 20U, TEST_SOURCE);
    octets_put_u16(whole, 0x1800U | (TEST_APID + 1U));
    octets_put_u16(&whole[PUS_PACKET_MAX - 2U], crc16_ccitt(whole, PUS_PACKET_MAX - 2U));
    const uint16_t last = send_all_but_last(7U, 600U);
    send_last(7U, last, 600U);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, taken_size);
}

static void a_request_with_a_wrong_length_field_has_the_same_limit(void)
{
    make_request(PUS_PACKET_MAX + 1U, 20U, TEST_SOURCE);
    octets_put_u16(whole, 0x1800U | (TEST_APID + 1U));
    octets_put_u16(&whole[4], 6U);
    send_last(7U, send_all_but_last(7U, 4000U), 4000U);
    expect_too_long(PUS_PACKET_MAX);
}

static void an_uplink_without_a_free_buffer_is_refused(void)
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
    expect_aborted(1U, 7U, PUS_LARGE_NOT_ACCEPTED);
    expect_failure(2U, 4U, PUS_FAILURE_EMBEDDED, 0U, detail);
    step(TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, taken_size);
}

static void a_large_packet_that_is_not_a_valid_request_is_refused(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    whole[4999] ^= 1U; // Damage the checksum.
    expect_no_request(5000U);
    make_request(5000U, 20U, TEST_SOURCE);
    whole_size = 4999U; // Make the length wrong.
    expect_no_request(4999U);
    make_request(5000U, 20U, TEST_SOURCE + 1U);
    expect_no_request(9U);
    make_request(5000U, 13U, TEST_SOURCE);
    expect_no_request(7U);
}

static void an_uplink_without_further_parts_is_aborted(void)
{
    make_request(5000U, 20U, TEST_SOURCE);
    send_part(9U, 7U, 1U, whole, 512U);
    bench_clear();
    step((TEST_NOW_NS + TIMEOUT_NS) - 1U);
    EXPECT_MESSAGES(0);
    step(TEST_NOW_NS + TIMEOUT_NS);
    EXPECT_MESSAGES(13, 16);
    expect_aborted(0U, 7U, PUS_LARGE_TIMEOUT);
    send_part(10U, 7U, 2U, &whole[512], 512U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 7U);
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
    expect_aborted(0U, 7U, PUS_LARGE_NOT_ACCEPTED);
    expect_failure(1U, 8U, PUS_FAILURE_TIMEOUT, 0U, (uint32_t)(TIMEOUT_NS / MS));
}

/// The dispatcher accepts a request that was transferred in parts, and no other request of that length.
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
    // TC[13,9] with a part of 4983 octets, because that request may have any length.
    make_request(5000U, 13U, TEST_SOURCE);
    whole[8] = 9U;
    octets_put_u16(&whole[13], 1U);
    octets_put_u16(&whole[15], TEST_APID);
    octets_put_u16(&whole[19], 6000U);
    octets_put_u16(&whole[4998], crc16_ccitt(whole, 4998U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_dispatch_large(&bench.dispatcher, whole, whole_size, TEST_NOW_NS));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void every_request_has_a_strict_format(void)
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
    RUN_TEST(parts_become_one_request);
    RUN_TEST(parts_out_of_order_end_the_uplink);
    RUN_TEST(parts_without_octets_are_refused);
    RUN_TEST(a_transaction_that_starts_again_replaces_its_first_uplink);
    RUN_TEST(a_complete_request_is_not_received_again);
    RUN_TEST(each_source_numbers_its_own_transactions);
    RUN_TEST(a_request_whose_length_field_is_too_large_is_aborted_at_once);
    RUN_TEST(a_request_with_too_small_a_length_field_is_aborted_at_the_limit);
    RUN_TEST(a_request_to_another_process_may_have_another_limit);
    RUN_TEST(a_request_with_a_wrong_length_field_has_the_same_limit);
    RUN_TEST(an_uplink_without_a_free_buffer_is_refused);
    RUN_TEST(a_large_packet_that_is_not_a_valid_request_is_refused);
    RUN_TEST(an_uplink_without_further_parts_is_aborted);
    RUN_TEST(a_request_that_is_not_taken_is_offered_again);
    RUN_TEST(a_large_request_is_dispatched);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
