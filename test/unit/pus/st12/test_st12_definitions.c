// SPDX-License-Identifier: Apache-2.0
// Definitions of parameter monitoring (PMON): which are refused, their deletion, modification, reports and
// records. The numbers of requests and reports are subtypes; pus/catalogue/st12_monitoring.txt has their
// names and fields.
#include "pus/st12/st12_monitoring.h"

#include "test/unit/pus/fixtures/monitors.h"
#include "unity.h"

#include <string.h>

#define NOT_A_NUMBER 0x7FF8000000000000ULL

static pus_monitoring_t* const self = &monitors.service;

void setUp(void)
{
    monitors_start();
}

void tearDown(void)
{
}

static void enable_function(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(15U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

/// Expect that the only definition of a request is refused with this code.
static void expect_refused(const uint8_t subtype, const uint16_t code, const uint32_t detail)
{
    const uint32_t before = self->counters.refused;
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(subtype));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 1U, detail);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, self->counters.refused);
}

static void expect_id_refused(const uint8_t subtype, const uint16_t id, const uint16_t code)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(subtype, 1U, id));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 1U, id);
}

/// Expect that a request is refused as a whole.
static void expect_start_failed(const uint8_t subtype, const uint16_t code, const uint32_t detail)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(subtype));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 0U, detail);
}

static void impossible_definitions_are_refused(void)
{
    const uint32_t real = SCALAR_ID(VALUE_DOUBLE, 1U);
    data_begin(1U); // The lower limit is above the upper one.
    data_limit(1U, LEVEL, 21U, 20U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // A limit is not a number.
    data_limit(1U, real, bits_of_double(0.0), NOT_A_NUMBER);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // The expected value has a bit that the mask does not have.
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0x0FU, 0x10U, 0U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // The interval is 0.
    data_pmon(1U, LEVEL, 0U, 1U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0U, 0U, 0U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // The repetition number is 0.
    data_pmon(1U, LEVEL, 1U, 0U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0U, 0U, 0U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // The lower threshold, 1, is above the upper one, -1.
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_DELTA);
    data_limits(LEVEL, 1U, 0U, 0xFFFFU, 0U);
    octet_write_u16(&monitors.data, 1U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U); // The number of values for a mean difference is 0.
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_DELTA);
    data_limits(LEVEL, 0U, 0U, 1U, 0U);
    octet_write_u16(&monitors.data, 0U);
    expect_refused(5U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    TEST_ASSERT_EQUAL_UINT16(0U, self->pmon_count);
}

static void a_port_that_accepts_every_event_refuses_no_definition(void)
{
    self->config.events.can_fill = NULL;
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 0U, EVENT_OTHER, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, self->pmon_count);
}

static void definitions_with_unknown_parameters_or_events_are_refused(void)
{
    data_begin(1U);
    data_limit(1U, SCALAR_UNKNOWN, 0U, 1U);
    expect_refused(5U, PUS_FAILURE_UNKNOWN_ID, SCALAR_UNKNOWN);
    data_begin(1U);
    data_limit(1U, SCALAR_SECRET, 0U, 1U);
    expect_refused(5U, PUS_FAILURE_ACCESS, SCALAR_SECRET);
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 0U, EVENT_UNKNOWN, 1U, 0U);
    expect_refused(5U, PUS_FAILURE_UNKNOWN_ID, EVENT_UNKNOWN);
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 0U, 0U, 1U, EVENT_UNKNOWN);
    expect_refused(5U, PUS_FAILURE_UNKNOWN_ID, EVENT_UNKNOWN);
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 0U, EVENT_OTHER, 1U, 0U);
    expect_refused(5U, PUS_FAILURE_ACCESS, EVENT_OTHER);
    for (unsigned i = 0U; i < 2U; i++) {
        data_begin(1U);
        octet_write_u16(&monitors.data, 1U);
        octet_write_u32(&monitors.data, LEVEL);
        octet_write_u32(&monitors.data, (i == 0U) ? SCALAR_UNKNOWN : GATE);
        octet_write_u8(&monitors.data, 0x0FU);
        octet_write_u8(&monitors.data, (i == 0U) ? 0x00U : 0x10U);
        octet_write_u32(&monitors.data, 1U);
        octet_write_u16(&monitors.data, 1U);
        octet_write_u8(&monitors.data, PUS_CHECK_LIMIT);
        data_limits(LEVEL, 10U, 0U, 20U, 0U);
        expect_refused(5U, (i == 0U) ? PUS_FAILURE_UNKNOWN_ID : PUS_FAILURE_OUT_OF_RANGE,
                       (i == 0U) ? SCALAR_UNKNOWN : 1U);
    }
}

static void the_lower_and_the_upper_limit_may_be_equal(void)
{
    data_begin(1U);
    data_limit(1U, LEVEL, 20U, 20U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

/// The store has lost the record of the definition.
static void a_definition_without_a_stored_record_is_deleted(void)
{
    add_limit(1U, LEVEL);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    records_start();
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(6U, 1U, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void the_table_accepts_its_capacity_and_no_id_twice(void)
{
    data_begin(MONITORS_PMONS + 2U);
    for (uint16_t i = 0U; i < MONITORS_PMONS; i++) {
        data_limit((uint16_t)(((i * 5U) % MONITORS_PMONS) + 1U), LEVEL, 0U, 1U);
        if (i == 3U) {
            data_limit(1U, LEVEL, 0U, 1U); // Instruction 5.
        }
    }
    data_limit(1000U, LEVEL, 0U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_EXISTS, 5U, 1U);
    expect_failure(3U, 4U, PUS_FAILURE_TABLE_FULL, MONITORS_PMONS + 2U, MONITORS_PMONS);
    expect_failure(4U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(13U));
    EXPECT_MESSAGES(1, 1, 1, 3, 12, 14, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(MONITORS_PMONS, octet_read_u16(&reader));
    for (uint16_t i = 1U; i <= MONITORS_PMONS; i++) {
        TEST_ASSERT_EQUAL_UINT16(i, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void only_disabled_definitions_are_deleted(void)
{
    add_limit(1U, LEVEL);
    data_begin(2U);
    data_limit(2U, LEVEL, 0U, 1U);
    data_limit(3U, LEVEL, 0U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    expect_id_refused(6U, 1U, PUS_FAILURE_STATE);
    expect_id_refused(6U, 9U, PUS_FAILURE_UNKNOWN_ID);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(6U, 1U, 2U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(2U, self->pmon_count);
    expect_id_refused(6U, 2U, PUS_FAILURE_UNKNOWN_ID);
    records.erase_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(6U, 1U, 3U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT16(2U, self->pmon_count);
}

static void unknown_ids_are_refused_alone(void)
{
    static const uint8_t subtypes[] = {1U, 2U};
    add_limit(1U, LEVEL);
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_ids(subtypes[i], 2U, 1U));
        EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
        expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, 2U);
    }
}

static void all_are_deleted_while_the_function_is_disabled(void)
{
    add_limit(1U, LEVEL);
    add_limit(2U, LEVEL);
    enable_function();
    expect_start_failed(4U, PUS_FAILURE_STATE, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    records.erase_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT16(2U, self->pmon_count); // Both stay as they are: enabled, as in their records.
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(13U));
    static const uint8_t statuses[] = {0, 2, 0, 1, 1, 0, 2, 1};
    TEST_ASSERT_EQUAL_UINT64(sizeof statuses, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(statuses, bench_report(2U).data, sizeof statuses);
    records.erase_status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(0U, self->pmon_count);
    monitors_restart();
    TEST_ASSERT_EQUAL_UINT16(0U, self->pmon_count);
}

/// Compose TC[12,7]: the new check of one definition.
static void modification(const uint16_t id, const uint32_t parameter, const uint8_t check_type,
                         const uint16_t low)
{
    data_begin(1U);
    octet_write_u16(&monitors.data, id);
    octet_write_u32(&monitors.data, parameter);
    octet_write_u16(&monitors.data, 1U);
    octet_write_u8(&monitors.data, check_type);
    if (check_type == (uint8_t)PUS_CHECK_LIMIT) {
        data_limits(parameter, low, EVENT_LOW, 100U, EVENT_HIGH);
    } else {
        data_expected(parameter, 0U, 0U, 0U);
    }
}

static void only_disabled_definitions_are_modified(void)
{
    add_limit(1U, LEVEL);
    modification(1U, LEVEL, PUS_CHECK_LIMIT, 50U);
    expect_refused(7U, PUS_FAILURE_STATE, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    modification(2U, LEVEL, PUS_CHECK_LIMIT, 50U);
    expect_refused(7U, PUS_FAILURE_UNKNOWN_ID, 2U);
    modification(1U, GATE, PUS_CHECK_LIMIT, 50U);
    expect_refused(7U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    modification(1U, LEVEL, PUS_CHECK_EXPECTED, 50U);
    expect_refused(7U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    modification(1U, LEVEL, PUS_CHECK_LIMIT, 101U);
    expect_refused(7U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    records.put_status = STATUS_FULL;
    modification(1U, LEVEL, PUS_CHECK_LIMIT, 50U);
    expect_refused(7U, PUS_FAILURE_IO, STATUS_FULL);
    records.put_status = STATUS_OK;
    modification(1U, LEVEL, PUS_CHECK_LIMIT, 50U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    scalar_set(LEVEL, 49U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
}

static void definitions_are_reported_with_all_fields_in_the_order_of_their_ids(void)
{
    static const uint8_t expected[] = {
        0, 0, 0, 10, // The delay.
        0, 3,        //
        // From the id to the repetition number; then the check.
        0, 1, 2, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 9, //
        0, 0x0F, 0xF0, 0x01, 0x20, 0x01, 0xF5,                   // Expected value.
        0, 2, 2, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 1, //
        1, 0, 10, 0x01, 0xF5, 0, 20, 0x01, 0xF6,                 // Limits; enabled.
        0, 3, 2, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, //
        2, 0xFF, 0xFB, 0x00, 0x00, 0, 5, 0x00, 0x00, 0, 4,       // Thresholds.
    };
    add_limit(2U, LEVEL);
    data_begin(2U);
    data_pmon(3U, LEVEL, 1U, 1U, PUS_CHECK_DELTA);
    data_limits(LEVEL, 0xFFFBU, 0U, 5U, 0U);
    octet_write_u16(&monitors.data, 4U);
    data_pmon(1U, LEVEL, 7U, 9U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0x0FF0U, 0x0120U, EVENT_LOW);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    for (unsigned i = 0U; i < 2U; i++) { // Ask for all of them, or for each by its id.
        TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, i * 3U, 1U));
        EXPECT_MESSAGES(1, 1, 1, 3, 12, 9, 1, 7);
        TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
        TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, 2U, 3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 12, 9, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, 4U);
    expect_id_refused(8U, 4U, PUS_FAILURE_UNKNOWN_ID);
}

static void a_report_has_only_the_definitions_that_were_asked_for(void)
{
    add_limit(0U, LEVEL);
    add_limit(1U, LEVEL);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, 0U, 0U));
    const size_t all = bench_report(2U).size;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, 1U, 1U));
    octet_reader_t reader = bench_data(2U);
    const size_t one      = octet_reader_left(&reader);
    TEST_ASSERT_EQUAL_UINT32(MONITORS_DELAY, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader)); // The id of the only definition.
    TEST_ASSERT_EQUAL_UINT64(all - one, one - 6U);
}

static void a_change_that_cannot_be_stored_fails(void)
{
    add_limit(1U, LEVEL);
    records.put_status = STATUS_FULL;
    data_begin(1U);
    data_limit(2U, LEVEL, 0U, 1U);
    expect_refused(5U, PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    expect_start_failed(15U, PUS_FAILURE_IO, STATUS_FULL);
    TEST_ASSERT_FALSE(self->is_enabled);
    records.put_status = STATUS_OK;
    enable_function();
    records.put_status = STATUS_FULL;
    expect_start_failed(16U, PUS_FAILURE_IO, STATUS_FULL);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.checks); // Definition and function are still enabled.
    records.put_status    = STATUS_OK;
    records.commit_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    expect_failure(bench.count - 1U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
}

static void definitions_outlast_a_power_cut(void)
{
    static const uint8_t delay[] = {0, 0, 0, 77};
    uint8_t before[PUS_PACKET_MAX];
    add_limit(2U, LEVEL);
    data_begin(1U);
    data_pmon(1U, SCALAR_ID(VALUE_INT64, 3U), 7U, 9U, PUS_CHECK_DELTA);
    data_limits(SCALAR_ID(VALUE_INT64, 3U), UINT64_MAX - 4U, 0U, 5U, EVENT_HIGH);
    octet_write_u16(&monitors.data, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, delay, sizeof delay));
    enable_function();
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, 0U, 0U));
    const size_t size = bench_report(2U).size;
    memcpy(before, bench_report(2U).data, size);
    monitors_restart();
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(8U, 0U, 0U));
    TEST_ASSERT_EQUAL_UINT64(size, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(before, bench_report(2U).data, size);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.checks);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(16U, NULL, 0U));
    monitors_restart();
    TEST_ASSERT_FALSE(self->is_enabled); // The disabled function outlasts it, too.
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, self->counters.checks);
}

static void bad_records_are_refused(void)
{
    // Parameter monitoring, functional monitoring (1: enabled), maximum reporting delay. Functional
    // monitoring cannot be enabled alone.
    static const uint8_t settings[] = {1, 0, 0, 0, 0, 5};
    static const uint8_t wrong[]    = {0, 1, 0, 0, 0, 5};
    uint8_t record[64];
    size_t size = 0U;
    add_limit(1U, LEVEL);
    const uint8_t* const kept = records_find(PUS_SERVICE_MONITORING, 1U, &size);
    memcpy(record, kept, size);
    // The record replaces the definition.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 1U, record, size));
    TEST_ASSERT_EQUAL_UINT16(1U, self->pmon_count);
    for (size_t i = 0U; i < size; i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, i));
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, size + 1U));
    record[19] = 3U; // The check type.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, size));
    record[19] = 1U;
    record[18] = 0U; // The repetition.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, size));
    record[18] = 1U;
    record[3] |= 0x1FU; // Layout of the parameter, then of the validity parameter.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, size));
    record[3] = 1U;
    record[7] = 0x1FU;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 1U, record, size));
    record[7] = 0U;
    // The number of the parameter.
    record[4] = 0xFFU;
    // The parameter may exist later.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 1U, record, size));
    record[4]  = 0U;
    record[22] = 0x03U; // Low event: unknown.
    record[23] = 0xE7U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_monitoring_restore(self, 1U, record, size));
    record[22] = 0U;
    record[23] = 0U;
    for (uint16_t i = 1U; i < MONITORS_PMONS; i++) {
        record[0] = (uint8_t)i;
        TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, i, record, size));
    }
    record[0] = 0xFFU;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_monitoring_restore(self, 1U, record, size));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 0x20000U, settings, 6U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x20000U, settings, 5U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x20000U, wrong, 6U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x30000U, settings, 6U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x20000U, NULL, 0U));
}

static void without_a_store_requests_are_performed_and_nothing_is_kept(void)
{
    self->config.persistence = NULL;
    add_limit(1U, LEVEL);
    enable_function();
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(0U, records.puts);
}

static void every_request_has_a_strict_format(void)
{
    uint8_t octets[64];
    data_begin(1U);
    data_limit(1U, LEVEL, 0U, 1U);
    memcpy(octets, monitors.data.octets, monitors.data.position);
    expect_strict_format(5U, octets, monitors.data.position);
    modification(1U, LEVEL, PUS_CHECK_LIMIT, 1U);
    memcpy(octets, monitors.data.octets, monitors.data.position);
    expect_strict_format(7U, octets, monitors.data.position);
    data_begin(2U);
    octet_write_u32(&monitors.data, 0x00010002U);
    memcpy(octets, monitors.data.octets, monitors.data.position);
    static const uint8_t lists[] = {1U, 2U, 6U, 8U, 19U, 20U, 21U, 22U, 24U, 25U};
    for (size_t i = 0U; i < sizeof lists; i++) {
        expect_strict_format(lists[i], octets, monitors.data.position);
    }
    static const uint8_t empty[] = {4U, 10U, 13U, 15U, 16U, 17U, 18U, 27U};
    for (size_t i = 0U; i < sizeof empty; i++) {
        expect_strict_format(empty[i], NULL, 0U);
    }
    expect_strict_format(3U, octets, 4U);
    TEST_ASSERT_EQUAL_UINT16(0U, self->pmon_count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(impossible_definitions_are_refused);
    RUN_TEST(a_port_that_accepts_every_event_refuses_no_definition);
    RUN_TEST(definitions_with_unknown_parameters_or_events_are_refused);
    RUN_TEST(the_lower_and_the_upper_limit_may_be_equal);
    RUN_TEST(a_definition_without_a_stored_record_is_deleted);
    RUN_TEST(the_table_accepts_its_capacity_and_no_id_twice);
    RUN_TEST(only_disabled_definitions_are_deleted);
    RUN_TEST(unknown_ids_are_refused_alone);
    RUN_TEST(all_are_deleted_while_the_function_is_disabled);
    RUN_TEST(only_disabled_definitions_are_modified);
    RUN_TEST(definitions_are_reported_with_all_fields_in_the_order_of_their_ids);
    RUN_TEST(a_report_has_only_the_definitions_that_were_asked_for);
    RUN_TEST(a_change_that_cannot_be_stored_fails);
    RUN_TEST(definitions_outlast_a_power_cut);
    RUN_TEST(bad_records_are_refused);
    RUN_TEST(without_a_store_requests_are_performed_and_nothing_is_kept);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
