// SPDX-License-Identifier: Apache-2.0
// Reading and setting of parameters. The numbers of requests and reports are subtypes;
// pus/catalogue/st20_parameters.txt has their names and fields.
#include "pus/st20/st20_parameters.h"

#include "test/unit/pus/fixtures/parameters.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static pus_parameters_t parameters;
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

void setUp(void)
{
    const pus_parameter_port_t port = dictionary_port();
    bench_start();
    memset(&parameters, 0xA5, sizeof parameters);
    pus_parameters_init(&parameters, &port);
    bench_serve(pus_parameters_service(&parameters));
}

void tearDown(void)
{
}

/// Begin application data with a count.
static void begin(const unsigned count)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, (uint8_t)count);
}

static void add(const uint32_t id)
{
    octet_write_u32(&writer, id);
}

/// Add an id and a value of `size` octets `first`, `first` + 1 ...
static void add_value(const uint32_t id, const size_t size, const uint8_t first)
{
    octet_write_u32(&writer, id);
    for (size_t i = 0U; i < size; i++) {
        octet_write_u8(&writer, (uint8_t)(first + i));
    }
}

static status_t request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(writer.failed);
    return bench_request(subtype, data, writer.position);
}

static void values_are_reported_in_the_order_asked(void)
{
    // The count, then id and value of each parameter: 4 and 2, 4 and 11, 4 and 1 octets.
    static const uint8_t expected[] = {0, 3, 2, 1, 0, 2, 0, 1, 2,  24, 0, 4, 0, 1,
                                       2, 3, 4, 5, 6, 7, 8, 9, 10, 2,  0, 0, 1, 0};
    begin(3U);
    add(P_U16);
    add(P_STRUCT);
    add(P_U8);
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 20, 2, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
    TEST_ASSERT_EQUAL_UINT32(3U, parameters.counters.read);
}

static void only_the_parameters_that_cannot_be_reported_are_refused(void)
{
    static const uint8_t expected[] = {0, 1, 2, 0, 0, 1, 0}; // One parameter, P_U8, with the value 0.
    begin(3U);
    add(P_UNKNOWN);
    add(P_U8);
    add(P_SECRET);
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 4, 20, 2, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, P_UNKNOWN);
    expect_failure(3U, 4U, PUS_FAILURE_ACCESS, 3U, P_SECRET);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(4U).data, sizeof expected);
    expect_failure(5U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    TEST_ASSERT_EQUAL_UINT32(2U, parameters.counters.refused);
    begin(1U);
    add(P_UNKNOWN);
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void only_the_parameters_without_room_in_the_report_are_refused(void)
{
    begin(4U); // Two values of 2004 octets leave 63 octets.
    add(P_LARGE);
    add(P_LARGE);
    add(P_LARGE);
    add(P_U8);
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 20, 2, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 3U, PUS_TM_DATA_MAX);
    const pus_tm_t tm = bench_report(3U);
    TEST_ASSERT_EQUAL_UINT64(2U + (2U * 2004U) + 5U, tm.size);
    TEST_ASSERT_EQUAL_UINT8(3U, tm.data[1]);
}

// The port for long reports has one buffer, which may be in use.
static uint8_t long_octets[3U * PUS_TM_DATA_MAX];
static size_t long_size;
static bool is_long_taken;

static status_t begin_long(void* const context, const uint8_t service, const uint8_t subtype,
                           const uint16_t destination, const uint64_t now_ns,
                           octet_writer_t* const out_writer)
{
    TEST_ASSERT_EQUAL_PTR(&long_size, context);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, destination);
    *out_writer = pus_tm_begin_large(&bench.process, long_octets, sizeof long_octets, service, subtype,
                                     destination, now_ns);
    return is_long_taken ? STATUS_FULL : STATUS_OK;
}

static status_t post_long(void* const context, octet_writer_t* const report)
{
    TEST_ASSERT_EQUAL_PTR(&long_size, context);
    TEST_ASSERT_FALSE(report->failed);
    long_size = report->position - PUS_TM_HEADER_SIZE;
    return STATUS_OK;
}

static void values_that_fit_no_packet_are_sent_as_a_long_report(void)
{
    const pus_long_port_t port = {&long_size, sizeof long_octets - PUS_TM_MIN, begin_long, post_long};
    pus_app_process_lengthen(&bench.process, &port);
    begin(4U);
    add(P_LARGE);
    add(P_LARGE);
    add(P_LARGE);
    add(P_U8);
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(2U + (3U * 2004U) + 5U, long_size);
    TEST_ASSERT_EQUAL_UINT16(4U, octets_u16_at(&long_octets[PUS_TM_HEADER_SIZE]));
    TEST_ASSERT_EQUAL_UINT32(P_LARGE, octets_u32_at(&long_octets[PUS_TM_HEADER_SIZE + 2U + 2004U]));
    is_long_taken = true;
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    is_long_taken = false;
    begin(7U);
    for (unsigned i = 0U; i < 7U; i++) {
        add(P_LARGE);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 7U, sizeof long_octets - PUS_TM_MIN);
}

static void up_to_255_values_are_reported(void)
{
    static const unsigned counts[] = {1U, 2U, 254U, 255U};
    for (size_t i = 0U; i < 4U; i++) {
        begin(counts[i]);
        for (unsigned k = 0U; k < counts[i]; k++) {
            add(P_MANY + k);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, request(1U));
        EXPECT_MESSAGES(1, 1, 1, 3, 20, 2, 1, 7);
        TEST_ASSERT_EQUAL_UINT64(2U + (5U * counts[i]), bench_report(2U).size);
    }
    begin(0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, request(1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, request(3U));
}

static void all_octets_of_a_value_are_set_together(void)
{
    begin(1U);
    add_value(P_STRUCT, 11U, 50U);
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX32(P_STRUCT, dictionary.written_id);
    TEST_ASSERT_EQUAL_UINT64(11U, dictionary.written_size);
    TEST_ASSERT_EQUAL_UINT8(60U, dictionary.written[10]);
    TEST_ASSERT_EQUAL_UINT32(1U, parameters.counters.set);
}

static void each_refusal_has_its_code_and_the_rest_is_set(void)
{
    begin(8U);
    add_value(P_U8, 1U, 1U);
    add_value(P_FIXED, 4U, 1U);
    add_value(P_LIMIT, 1U, 10U); // Offset of the value: 1 + 5 + 8 + 4 = 18.
    add_value(P_LOCKED, 1U, 0U);
    add_value(P_LOCKED, 1U, 1U);
    add_value(P_ODD, 1U, 1U); // Offset of the value: 18 + 1 + 10 + 4 = 33.
    add_value(P_SECRET, 2U, 1U);
    add_value(P_U16, 2U, 7U);
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 4, 1, 4, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_ACCESS, 2U, P_FIXED);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 18U);
    expect_failure(4U, 4U, PUS_FAILURE_STATE, 4U, P_LOCKED);
    expect_failure(5U, 4U, PUS_FAILURE_STATE, 5U, P_LOCKED);
    expect_failure(6U, 4U, PUS_FAILURE_OUT_OF_RANGE, 6U, 33U);
    expect_failure(7U, 4U, PUS_FAILURE_ACCESS, 7U, P_SECRET);
    expect_failure(8U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 6U);
    TEST_ASSERT_EQUAL_UINT32(2U, dictionary.writes);
    TEST_ASSERT_EQUAL_HEX32(P_U16, dictionary.written_id);
}

static void the_layout_bits_of_an_unknown_id_give_the_octets_to_skip(void)
{
    begin(2U);
    add_value(P_UNKNOWN, 8U, 1U);
    add_value(P_U8, 1U, 42U);
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, P_UNKNOWN);
    TEST_ASSERT_EQUAL_UINT8(42U, dictionary.written[0]);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(3U, data, writer.position - 1U));
}

static void a_value_of_unknown_length_is_refused_with_all_that_follow(void)
{
    begin(3U);
    add_value(P_U8, 1U, 42U);
    add_value(P_UNKNOWN_ARRAY, 5U, 1U);
    add_value(P_U8, 1U, 43U);
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, P_UNKNOWN_ARRAY);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 3U, 0U);
    expect_failure(4U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    TEST_ASSERT_EQUAL_UINT32(1U, dictionary.writes);
    TEST_ASSERT_EQUAL_UINT8(42U, dictionary.written[0]);
}

static void without_a_write_port_nothing_is_settable(void)
{
    pus_parameter_port_t port = dictionary_port();
    port.write                = NULL;
    memset(&parameters, 0xA5, sizeof parameters);
    pus_parameters_init(&parameters, &port);
    begin(1U);
    add_value(P_U8, 1U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    expect_failure(1U, 4U, PUS_FAILURE_ACCESS, 1U, P_U8);
}

static void up_to_255_values_are_set(void)
{
    begin(255U);
    for (unsigned k = 0U; k < 255U; k++) {
        add_value(P_MANY + k, 1U, (uint8_t)k);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(255U, dictionary.writes);
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(3U, data, writer.position + 1U));
}

static void every_request_has_a_strict_format(void)
{
    uint8_t octets[64];
    begin(2U);
    add(P_U8);
    add(P_U16);
    memcpy(octets, data, writer.position);
    expect_strict_format(1U, octets, writer.position);
    begin(3U);
    add_value(P_STRUCT, 11U, 1U);
    add_value(P_UNKNOWN, 8U, 1U);
    add_value(P_U16, 2U, 1U);
    memcpy(octets, data, writer.position);
    expect_strict_format(3U, octets, writer.position);
    TEST_ASSERT_EQUAL_UINT32(0U, dictionary.writes);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_are_reported_in_the_order_asked);
    RUN_TEST(only_the_parameters_that_cannot_be_reported_are_refused);
    RUN_TEST(only_the_parameters_without_room_in_the_report_are_refused);
    RUN_TEST(values_that_fit_no_packet_are_sent_as_a_long_report);
    RUN_TEST(up_to_255_values_are_reported);
    RUN_TEST(all_octets_of_a_value_are_set_together);
    RUN_TEST(each_refusal_has_its_code_and_the_rest_is_set);
    RUN_TEST(the_layout_bits_of_an_unknown_id_give_the_octets_to_skip);
    RUN_TEST(a_value_of_unknown_length_is_refused_with_all_that_follow);
    RUN_TEST(without_a_write_port_nothing_is_settable);
    RUN_TEST(up_to_255_values_are_set);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
