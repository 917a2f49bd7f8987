// SPDX-License-Identifier: Apache-2.0
// Functional monitoring: a definition (FMON) combines parameter monitoring definitions (PMON). The numbers of
// requests and reports are subtypes; pus/catalogue/st12_monitoring.txt has their names and fields.
#include "test/unit/pus/fixtures/monitors.h"
#include "unity.h"

#include <string.h>

#define FMON_EVENT 600U
#define OTHER SCALAR_ID(VALUE_UINT16, 9U)
#define THIRD SCALAR_ID(VALUE_UINT16, 10U)

static pus_monitoring_t* const self = &monitors.service;

/// Define PMONs 1..3 on LEVEL, OTHER and THIRD, all nominal and enabled.
void setUp(void)
{
    monitors_start();
    add_limit(1U, LEVEL);
    add_limit(2U, OTHER);
    add_limit(3U, THIRD);
    scalar_set(LEVEL, 15U);
    scalar_set(OTHER, 15U);
    scalar_set(THIRD, 15U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(15U));
}

void tearDown(void)
{
}

/// Write one FMON of the PMONs `first` .. `first + count - 1` to the application data.
static void data_fmon(const uint16_t id, const uint32_t validity, const uint16_t minimum, const uint8_t count,
                      const uint16_t first)
{
    octet_write_u16(&monitors.data, id);
    octet_write_u32(&monitors.data, validity);
    octet_write_u8(&monitors.data, (validity == 0U) ? 0U : 0xFFU);
    octet_write_u8(&monitors.data, (uint8_t)((validity == 0U) ? 0U : 1U));
    octet_write_u16(&monitors.data, FMON_EVENT);
    octet_write_u16(&monitors.data, minimum);
    octet_write_u8(&monitors.data, count);
    for (unsigned i = 0U; i < count; i++) {
        octet_write_u16(&monitors.data, (uint16_t)(first + i));
    }
}

static void add_fmon(const uint16_t id, const uint32_t validity, const uint16_t minimum, const uint8_t count,
                     const uint16_t first)
{
    data_begin(1U);
    data_fmon(id, validity, minimum, count, first);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(23U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

/// Define FMON 1 of all three PMONs; the FMON and the functional monitoring function are enabled.
static void start_fmon(const uint32_t validity, const uint16_t minimum)
{
    add_fmon(1U, validity, minimum, 3U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

/// Expect that TM[12,28] has one FMON, with this id and these statuses.
static void expect_status(const uint16_t id, const uint8_t protection, const uint8_t status,
                          const uint8_t checking)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(27U));
    EXPECT_MESSAGES(1, 1, 1, 3, 12, 28, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT16(id, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT8(protection, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(status, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(checking, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void expect_refused(const uint8_t subtype, const uint16_t code, const uint32_t detail)
{
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(subtype));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 1U, detail);
}

static void expect_id_refused(const uint8_t subtype, const uint16_t id, const uint16_t code)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(subtype, 1U, id));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 1U, id);
}

static void a_functional_monitor_fails_when_enough_of_its_monitors_fail(void)
{
    start_fmon(0U, 2U);
    expect_status(1U, 0U, 1U, PUS_FMON_UNCHECKED);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_RUNNING);
    scalar_set(LEVEL, 30U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_RUNNING);
    scalar_set(THIRD, 5U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_FAILED);
    TEST_ASSERT_EQUAL_UINT16(FMON_EVENT, monitors.events.id);
    TEST_ASSERT_EQUAL_UINT64(4U, monitors.events.size);
    TEST_ASSERT_EQUAL_UINT16(1U, octets_u16_at(monitors.events.auxiliary));
    TEST_ASSERT_EQUAL_UINT16(2U, octets_u16_at(&monitors.events.auxiliary[2]));
    const unsigned events = monitors.events.count;
    scalar_set(OTHER, 5U);
    monitors_step(3U); // One more PMON fails: only the event of this PMON is raised.
    TEST_ASSERT_EQUAL_UINT(events + 1U, monitors.events.count);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.failures);
    scalar_set(OTHER, 15U);
    scalar_set(THIRD, 15U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_RUNNING);
}

static void a_monitor_that_is_disabled_does_not_fail(void)
{
    start_fmon(0U, 1U);
    scalar_set(LEVEL, 30U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_FAILED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 3U, 1U));
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_RUNNING);
}

static void a_functional_monitor_whose_validity_condition_is_false_is_invalid(void)
{
    start_fmon(GATE, 1U);
    scalar_set(LEVEL, 30U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_INVALID);
    TEST_ASSERT_EQUAL_UINT32(0U, self->counters.failures);
    scalar_set(GATE, 1U);
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_FAILED);
}

static void nothing_is_checked_while_disabled(void)
{
    scalar_set(LEVEL, 30U);
    add_fmon(1U, 0U, 1U, 1U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    monitors_step(1U);
    expect_status(1U, 0U, 0U, PUS_FMON_UNCHECKED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_UNCHECKED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_FAILED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(20U, 1U, 1U));
    expect_status(1U, 0U, 0U, PUS_FMON_UNCHECKED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 2U)); // PMON 2 is not a member of the FMON.
    // PMON 1 is a member, but the FMON is disabled too before the next step, so no step sees the change.
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(20U, 1U, 1U));
    monitors_step(1U);
    expect_status(1U, 0U, 0U, PUS_FMON_UNCHECKED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    expect_status(1U, 0U, 0U, PUS_FMON_UNCHECKED);
}

static void after_disabling_the_function_the_functional_monitor_is_unchecked(void)
{
    start_fmon(0U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    monitors_step(1U);
    expect_status(1U, 0U, 1U, PUS_FMON_UNCHECKED);
}

static void functional_monitoring_needs_parameter_monitoring_and_a_stored_status(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 0U);
    records.put_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_TRUE(self->is_functional);
    records.put_status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    records.put_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_FALSE(self->is_functional);
    records.put_status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 0U);
}

static void a_protected_functional_monitor_and_its_monitors_are_not_disabled_or_modified(void)
{
    start_fmon(0U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(21U, 1U, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_status(1U, 1U, 1U, PUS_FMON_UNCHECKED);
    expect_id_refused(20U, 1U, PUS_FAILURE_PROTECTED);
    expect_id_refused(2U, 2U, PUS_FAILURE_PROTECTED);
    data_begin(1U);
    octet_write_u16(&monitors.data, 2U);
    octet_write_u32(&monitors.data, OTHER);
    octet_write_u16(&monitors.data, 1U);
    octet_write_u8(&monitors.data, PUS_CHECK_LIMIT);
    data_limits(OTHER, 0U, 0U, 1U, 0U);
    expect_refused(7U, PUS_FAILURE_PROTECTED, 2U);
    add_fmon(2U, 0U, 1U, 1U, 2U); // An unprotected FMON that refers to the same PMON.
    expect_id_refused(2U, 2U, PUS_FAILURE_PROTECTED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(22U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 2U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void only_disabled_unprotected_definitions_are_deleted(void)
{
    start_fmon(0U, 1U);
    expect_id_refused(24U, 1U, PUS_FAILURE_STATE);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(20U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(21U, 1U, 1U));
    expect_id_refused(24U, 1U, PUS_FAILURE_PROTECTED);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(22U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    expect_id_refused(6U, 1U, PUS_FAILURE_STATE); // An FMON refers to it.
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(18U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(4U));
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 1U);
    records.erase_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(24U, 1U, 1U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    records.erase_status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(24U, 1U, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_id_refused(24U, 1U, PUS_FAILURE_UNKNOWN_ID);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(6U, 1U, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void impossible_definitions_are_refused(void)
{
    data_begin(1U);
    data_fmon(1U, 0U, 0U, 1U, 1U);
    expect_refused(23U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U);
    data_fmon(1U, 0U, 2U, 1U, 1U);
    expect_refused(23U, PUS_FAILURE_OUT_OF_RANGE, 1U);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 2U, 3U);
    expect_refused(23U, PUS_FAILURE_UNKNOWN_ID, 4U);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, MONITORS_MEMBERS + 1U, 1U);
    expect_refused(23U, PUS_FAILURE_TABLE_FULL, MONITORS_MEMBERS);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 255U, 1U);
    expect_refused(23U, PUS_FAILURE_TABLE_FULL, MONITORS_MEMBERS);
    data_begin(1U);
    data_fmon(1U, SCALAR_UNKNOWN, 1U, 1U, 1U);
    expect_refused(23U, PUS_FAILURE_UNKNOWN_ID, SCALAR_UNKNOWN);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 2U, 1U);
    octets_put_u16(&monitors.data.octets[monitors.data.position - 2U], 1U); // 1 twice.
    expect_refused(23U, PUS_FAILURE_DUPLICATE, 1U);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 1U, 1U);
    octets_put_u16(&monitors.data.octets[9], EVENT_UNKNOWN);
    expect_refused(23U, PUS_FAILURE_UNKNOWN_ID, EVENT_UNKNOWN);
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 1U, 1U);
    octets_put_u16(&monitors.data.octets[9], EVENT_OTHER);
    expect_refused(23U, PUS_FAILURE_ACCESS, EVENT_OTHER);
    records.put_status = STATUS_FULL;
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 1U, 1U);
    expect_refused(23U, PUS_FAILURE_IO, STATUS_FULL);
    data_begin(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(25U, 0U, 0U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size); // The report has no definition.
}

static void the_table_accepts_its_capacity_and_no_id_twice(void)
{
    data_begin(MONITORS_FMONS + 2U);
    for (uint16_t i = 0U; i < MONITORS_FMONS; i++) {
        data_fmon(i, 0U, 1U, 1U, 1U);
    }
    data_fmon(0U, 0U, 1U, 1U, 1U);
    data_fmon(1000U, 0U, 1U, 1U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(23U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_EXISTS, MONITORS_FMONS + 1U, 0U);
    expect_failure(3U, 4U, PUS_FAILURE_TABLE_FULL, MONITORS_FMONS + 2U, MONITORS_FMONS);
}

static void unknown_ids_and_a_status_that_is_not_stored_are_refused(void)
{
    static const uint8_t subtypes[] = {19U, 20U, 21U, 22U, 24U, 25U};
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        expect_id_refused(subtypes[i], 7U, PUS_FAILURE_UNKNOWN_ID);
    }
    add_fmon(1U, 0U, 1U, 1U, 1U);
    records.put_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    expect_status(1U, 0U, 0U, PUS_FMON_UNCHECKED);
}

static void definitions_are_reported_and_outlast_a_power_cut(void)
{
    // TM[12,26] of FMONs 1 and 4: id, validity parameter, mask, value, protection, status, event, minimum and
    // PMONs.
    static const uint8_t expected[] = {
        0, 2, 0, 1, 2, 0, 0, 2, 0xFF, 0x01, 1,    1,    0x02, 0x58, 0, 2, 0, 2, 0, 2, 0, 3, //
        0, 4, 0, 0, 0, 0, 0, 0, 0,    0,    0x02, 0x58, 0,    1,    0, 1, 0, 1,
    };
    add_fmon(1U, GATE, 2U, 2U, 2U);
    add_fmon(4U, 0U, 1U, 1U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(21U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    // The record of the PMON is written after those of the FMONs.
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_ids(25U, 0U, 0U));
        EXPECT_MESSAGES(1, 1, 1, 3, 12, 26, 1, 7);
        TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
        data_begin(2U);
        octet_write_u16(&monitors.data, 1U);
        octet_write_u16(&monitors.data, 4U);
        TEST_ASSERT_EQUAL(STATUS_OK, data_send(25U));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
        TEST_ASSERT_EQUAL(STATUS_OK, send_ids(25U, 2U, 4U));
        EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 12, 26, 1, 8);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(&expected[22], &bench_report(3U).data[2], 18U);
        monitors_restart();
        expect_id_refused(6U, 1U, PUS_FAILURE_STATE);
        expect_id_refused(2U, 3U, PUS_FAILURE_PROTECTED);
    }
    scalar_set(GATE, 1U);
    scalar_set(OTHER, 99U);
    scalar_set(THIRD, 99U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.failures);
}

static void an_invalid_record_is_reported(void)
{
    uint8_t record[64];
    size_t size = 0U; // The key of a record is 0x10000 | id.
    add_fmon(1U, GATE, 2U, 2U, 2U);
    memcpy(record, records_find(PUS_SERVICE_MONITORING, 0x10001U, &size), 20U);
    TEST_ASSERT_EQUAL_UINT64(20U, size);
    // The record replaces the definition.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 0x10001U, record, size));
    for (size_t i = 0U; i < size; i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x10001U, record, i));
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x10001U, record, size + 1U));
    record[13] = 3U; // The minimum of failing PMONs.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x10001U, record, size));
    record[13] = 2U;
    record[3] |= 0x1FU; // Layout of the validity parameter.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x10001U, record, size));
    record[3] = 0U;
    record[4] = 0x20U; // SCALAR_SECRET.
    record[5] = 0x00U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 0x10001U, record, size));
    record[4]  = 0U;
    record[5]  = 2U;
    record[15] = 0U; // A count of zero members in front of four octets of members.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_monitoring_restore(self, 0x10001U, record, size));
    record[15] = 2U;
    memset(&record[size], 0, 4U);
    record[15] = MONITORS_MEMBERS + 1U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_monitoring_restore(self, 0x10001U, record, size + 4U));
    record[15] = 2U;
    record[19] = 77U; // A PMON that does not exist counts as one that does not fail.
    record[1]  = 9U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 0x10009U, record, size));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 9U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    scalar_set(GATE, 1U);
    scalar_set(OTHER, 99U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, self->counters.failures);
    record[1] = 10U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_monitoring_restore(self, 0x1000AU, record, size));
    record[1] = 11U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_monitoring_restore(self, 0x1000BU, record, size));
}

static void event_0_raises_no_event(void)
{
    data_begin(1U);
    data_fmon(1U, 0U, 1U, 1U, 1U);
    octets_put_u16(&monitors.data.octets[9], 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(23U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(19U, 1U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(17U));
    scalar_set(LEVEL, 0U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.failures);
    TEST_ASSERT_EQUAL_UINT16(EVENT_LOW, monitors.events.id); // The event of the failed PMON.
}

static void adding_has_a_strict_format(void)
{
    uint8_t octets[64];
    data_begin(2U);
    data_fmon(1U, GATE, 1U, 2U, 1U);
    data_fmon(2U, 0U, 1U, 1U, 1U);
    memcpy(octets, monitors.data.octets, monitors.data.position);
    expect_strict_format(23U, octets, monitors.data.position);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_functional_monitor_fails_when_enough_of_its_monitors_fail);
    RUN_TEST(a_monitor_that_is_disabled_does_not_fail);
    RUN_TEST(a_functional_monitor_whose_validity_condition_is_false_is_invalid);
    RUN_TEST(nothing_is_checked_while_disabled);
    RUN_TEST(after_disabling_the_function_the_functional_monitor_is_unchecked);
    RUN_TEST(functional_monitoring_needs_parameter_monitoring_and_a_stored_status);
    RUN_TEST(a_protected_functional_monitor_and_its_monitors_are_not_disabled_or_modified);
    RUN_TEST(only_disabled_unprotected_definitions_are_deleted);
    RUN_TEST(impossible_definitions_are_refused);
    RUN_TEST(the_table_accepts_its_capacity_and_no_id_twice);
    RUN_TEST(unknown_ids_and_a_status_that_is_not_stored_are_refused);
    RUN_TEST(definitions_are_reported_and_outlast_a_power_cut);
    RUN_TEST(an_invalid_record_is_reported);
    RUN_TEST(event_0_raises_no_event);
    RUN_TEST(adding_has_a_strict_format);
    return UNITY_END();
}
