// SPDX-License-Identifier: Apache-2.0
// Time reports: formats, rates and refusals of the port. The numbers of requests and reports are subtypes;
// pus/catalogue/st09_time.txt has their names and fields.
#include "pus/st09/st09_time.h"

#include "base/crc.h"
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define S 1000000000ULL

static pus_time_t service;
static struct {
    unsigned refusals;
    unsigned count;
    uint8_t packet[PUS_TIME_PACKET_SIZE];
} ground;

static status_t take(void* const context, const uint8_t* const packet, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&ground, context);
    TEST_ASSERT_EQUAL_UINT64(PUS_TIME_PACKET_SIZE, size);
    if (ground.refusals > 0U) {
        ground.refusals--;
        return STATUS_FULL;
    }
    ground.count++;
    memcpy(ground.packet, packet, size);
    return STATUS_OK;
}

static void start(const pus_time_format_t format, const uint8_t exponent)
{
    const pus_time_config_t config = {.epoch_s     = TEST_EPOCH_S,
                                      .format      = format,
                                      .exponent    = exponent,
                                      .status      = 5U,
                                      .port        = {.context = &ground, .send = take},
                                      .persistence = records_port()};
    memset(&ground, 0, sizeof ground);
    memset(&service, 0xA5, sizeof service);
    pus_time_init(&service, &config);
    bench_serve(pus_time_service(&service));
}

void setUp(void)
{
    bench_start();
    records_start();
    start(PUS_TIME_CUC, 0U);
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void tearDown(void)
{
}

typedef struct {
    uint16_t sequence;
    uint8_t exponent;
    uint8_t status;
    uint64_t time_ns;
} time_fields_t;

static uint64_t read_cds(octet_reader_t* const reader)
{
    const uint64_t day = octet_read_u16(reader);
    const uint64_t ms  = octet_read_u32(reader);
    const uint64_t us  = octet_read_u16(reader);
    TEST_ASSERT_TRUE((ms < 86400000U) && (us < 1000U));
    return (((day * 86400000U) + ms) * 1000000U) + (us * 1000U);
}

/// Returns the fields of the last time packet, which must be well-formed.
static time_fields_t report(const pus_time_format_t format)
{
    time_fields_t result  = {0};
    octet_reader_t reader = octet_reader(ground.packet, PUS_TIME_PACKET_SIZE - 2U);
    TEST_ASSERT_EQUAL_HEX16(0U, crc16_ccitt(ground.packet, PUS_TIME_PACKET_SIZE));
    TEST_ASSERT_EQUAL_HEX16(0U, octet_read_u16(&reader));
    const uint16_t sequence = octet_read_u16(&reader);
    TEST_ASSERT_EQUAL_HEX16(0xC000U, sequence & 0xC000U);
    result.sequence = sequence & 0x3FFFU;
    TEST_ASSERT_EQUAL_UINT16(PUS_TIME_PACKET_SIZE - 7U, octet_read_u16(&reader));
    result.exponent = octet_read_u8(&reader);
    if (format == PUS_TIME_CDS) {
        result.time_ns = read_cds(&reader);
    } else {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(&reader, &result.time_ns));
    }
    result.status = octet_read_u8(&reader);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    return result;
}

/// Step at this time. Returns true if a report was sent; its time must be `now_ns`.
static bool sends(const uint64_t now_ns)
{
    const unsigned before = ground.count;
    const uint64_t due_ns = pus_time_due_ns(&service, now_ns);
    pus_time_step(&service, now_ns);
    TEST_ASSERT_TRUE(ground.count <= (before + 1U));
    TEST_ASSERT_EQUAL(ground.count > before, due_ns == now_ns);
    if (ground.count > before) {
        const uint64_t expected = (TEST_EPOCH_S * S) + now_ns;
        TEST_ASSERT_UINT64_WITHIN(60U, expected, report(service.config.format).time_ns);
    }
    return ground.count > before;
}

static bool set_rate(const uint8_t exponent)
{
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, &exponent, 1U));
    return bench_report(bench.count - 1U).subtype == 7U;
}

static void a_cuc_report_has_this_layout(void)
{
    // 2 000 000 001 s, 0x77359401, and a half.
    static const uint8_t expected[] = {0x00, 0x00, 0xC0, 0x00, 0x00, 0x0B, 0x00, 0x1F,
                                       0x77, 0x35, 0x94, 0x01, 0x80, 0x00, 0x00, 0x05};
    TEST_ASSERT_TRUE(sends(1500000000ULL));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, ground.packet, sizeof expected);
    TEST_ASSERT_TRUE(pus_is_time_packet(ground.packet, sizeof ground.packet));
    const time_fields_t got = report(PUS_TIME_CUC);
    TEST_ASSERT_EQUAL_UINT16(0U, got.sequence);
    TEST_ASSERT_EQUAL_UINT8(0U, got.exponent);
    TEST_ASSERT_EQUAL_UINT8(5U, got.status);
}

static void a_cds_report_has_this_layout(void)
{
    // Day 23148 (0x5A6C), 12813.250 s of it: 12813250 ms (0xC383C2), 999 us (0x03E7).
    static const uint8_t expected[] = {0x00, 0x00, 0xC0, 0x00, 0x00, 0x0B, 0x03, 0x5A,
                                       0x6C, 0x00, 0xC3, 0x83, 0xC2, 0x03, 0xE7, 0x05};
    start(PUS_TIME_CDS, 3U);
    TEST_ASSERT_TRUE(sends((13U * S) + 250999000ULL));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, ground.packet, sizeof expected);
    TEST_ASSERT_EQUAL_UINT64((TEST_EPOCH_S * S) + (13U * S) + 250999000ULL, report(PUS_TIME_CDS).time_ns);
}

static void reports_are_sent_at_multiples_of_the_period(void)
{
    TEST_ASSERT_TRUE(sends(0U));
    TEST_ASSERT_FALSE(sends(S - 1U));
    TEST_ASSERT_EQUAL_UINT64(S, pus_time_due_ns(&service, 1U));
    TEST_ASSERT_TRUE(sends(S));
    TEST_ASSERT_FALSE(sends(S));
    TEST_ASSERT_TRUE(sends(9U * S)); // Only one report is sent, no matter how far the time jumps.
    TEST_ASSERT_TRUE(sends(2U * S)); // A jump backwards also gives one report.
    TEST_ASSERT_FALSE(sends(2U * S));
    TEST_ASSERT_EQUAL_UINT16(3U, report(PUS_TIME_CUC).sequence);
    TEST_ASSERT_EQUAL_UINT32(4U, service.counters.sent);
}

static void a_time_report_that_the_port_refuses_is_sent_later(void)
{
    ground.refusals = 2U;
    pus_time_step(&service, 0U);
    pus_time_step(&service, 1U);
    TEST_ASSERT_EQUAL_UINT32(2U, service.counters.refused);
    TEST_ASSERT_TRUE(sends(500U));
    TEST_ASSERT_EQUAL_UINT16(0U, report(PUS_TIME_CUC).sequence); // The sequence has no gap.
    service.sequence = 16383U;
    TEST_ASSERT_TRUE(sends(S));
    TEST_ASSERT_EQUAL_UINT16(16383U, report(PUS_TIME_CUC).sequence);
    TEST_ASSERT_TRUE(sends(2U * S));
    TEST_ASSERT_EQUAL_UINT16(0U, report(PUS_TIME_CUC).sequence);
}

static void the_rate_is_set(void)
{
    TEST_ASSERT_TRUE(set_rate(8U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_FALSE(sends(TEST_NOW_NS));
    TEST_ASSERT_FALSE(sends(255U * S)); // The epoch is a multiple of 256 s.
    TEST_ASSERT_TRUE(sends(256U * S));
    TEST_ASSERT_FALSE(sends(511U * S));
    TEST_ASSERT_TRUE(sends(512U * S));
    TEST_ASSERT_EQUAL_UINT8(8U, report(PUS_TIME_CUC).exponent);
    TEST_ASSERT_FALSE(set_rate(9U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    TEST_ASSERT_TRUE(set_rate(0U));
    TEST_ASSERT_TRUE(sends(513U * S));
    expect_strict_format(1U, "", 1U);
}

static void time_reports_may_be_disabled_at_the_start(void)
{
    start(PUS_TIME_CUC, PUS_TIME_NO_REPORTS);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, pus_time_due_ns(&service, S));
    pus_time_step(&service, S);
    TEST_ASSERT_EQUAL_UINT(0U, ground.count);
    TEST_ASSERT_TRUE(set_rate(0U));
    TEST_ASSERT_TRUE(sends(2U * S));
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_time_restore(self, key, octets, size);
}

static void the_rate_outlives_a_power_cut(void)
{
    static const uint8_t records_of[] = {9U, 4U};
    TEST_ASSERT_TRUE(set_rate(3U));
    records_cut();
    start(PUS_TIME_CUC, 0U);
    TEST_ASSERT_EQUAL_UINT64(1U, records_replay(9U, restore, &service));
    TEST_ASSERT_EQUAL_UINT8(3U, service.exponent);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_time_restore(&service, 1U, &records_of[1], 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_time_restore(&service, 0U, records_of, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_time_restore(&service, 0U, &records_of[1], 0U));
    TEST_ASSERT_EQUAL_UINT8(3U, service.exponent);
    records.put_status = STATUS_IO;
    TEST_ASSERT_FALSE(set_rate(1U));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT8(3U, service.exponent);
    service.config.persistence = NULL;
    TEST_ASSERT_TRUE(set_rate(1U));
}

static void a_time_packet_is_recognised_by_its_first_two_octets(void)
{
    TEST_ASSERT_TRUE(sends(0U));
    TEST_ASSERT_TRUE(pus_is_time_packet(ground.packet, 2U));
    TEST_ASSERT_FALSE(pus_is_time_packet(ground.packet, 1U));
    TEST_ASSERT_FALSE(pus_is_time_packet(NULL, 0U));
    for (unsigned bit = 0U; bit < 16U; bit++) { // Version, type, secondary header and APID.
        uint8_t other[2] = {0U};
        other[bit / 8U]  = (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_FALSE(pus_is_time_packet(other, sizeof other));
    }
}

static void start_with_a_wrong_rate(void)
{
    start(PUS_TIME_CUC, 9U);
}

static void calls_against_the_contract_are_asserted(void)
{
    TEST_ASSERT_TRUE(assertion_fails(start_with_a_wrong_rate));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_cuc_report_has_this_layout);
    RUN_TEST(a_cds_report_has_this_layout);
    RUN_TEST(reports_are_sent_at_multiples_of_the_period);
    RUN_TEST(a_time_report_that_the_port_refuses_is_sent_later);
    RUN_TEST(the_rate_is_set);
    RUN_TEST(time_reports_may_be_disabled_at_the_start);
    RUN_TEST(the_rate_outlives_a_power_cut);
    RUN_TEST(a_time_packet_is_recognised_by_its_first_two_octets);
    RUN_TEST(calls_against_the_contract_are_asserted);
    return UNITY_END();
}
