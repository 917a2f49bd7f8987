// SPDX-License-Identifier: Apache-2.0
// Checks of parameter monitoring and the reports of their transitions. The numbers of requests and reports
// are subtypes; pus/catalogue/st12_monitoring.txt has their names and fields.
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

static void nothing_is_checked_before_definition_and_function_are_enabled(void)
{
    data_begin(1U);
    data_limit(1U, LEVEL, 10U, 20U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    monitors_step(5U);
    enable_function();
    monitors_step(5U);
    TEST_ASSERT_EQUAL_UINT(0U, scalars.reads);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, status_of(1U));
    monitors_step(2U);
    TEST_ASSERT_EQUAL_UINT32(2U, self->counters.checks);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(16U));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, status_of(1U));
    monitors_step(3U);
    enable_function();
    enable_function();
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(3U, self->counters.checks);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U)); // The definition is already enabled.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(2U, 1U, 1U));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, status_of(1U));
    monitors_step(3U);
    TEST_ASSERT_EQUAL_UINT32(3U, self->counters.checks);
}

static void transitions_are_reported_when_the_delay_is_over(void)
{
    scalar_set(LEVEL, 15U);
    add_limit(1U, LEVEL);
    enable_function();
    monitors_step(MONITORS_DELAY);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    scalar_set(LEVEL, 21U);
    monitors_step(1U);
    EXPECT_MESSAGES(12, 12);
    TEST_ASSERT_EQUAL_UINT16(2U, octets_u16_at(bench_report(0U).data));
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    const transition_t first  = transition_at(0U, 0U);
    const transition_t second = transition_at(0U, 1U);
    TEST_ASSERT_EQUAL_UINT16(1U, first.pmon_id);
    TEST_ASSERT_EQUAL_HEX32(LEVEL, first.parameter_id);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LIMIT, first.check_type);
    TEST_ASSERT_EQUAL_UINT16(15U, first.value);
    TEST_ASSERT_EQUAL_UINT16(0U, first.limit);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, first.previous);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, first.current);
    TEST_ASSERT_EQUAL_UINT16(21U, second.value);
    TEST_ASSERT_EQUAL_UINT16(20U, second.limit);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_HIGH, second.current);
    // The time field counts 2^-24 s, so the reported time may be up to 60 ns earlier.
    const uint64_t expected = (TEST_EPOCH_S * 1000000000ULL) + TEST_NOW_NS + monitors.cycle;
    TEST_ASSERT_TRUE((second.time_ns <= (expected + 1U)) && ((second.time_ns + 60U) > expected));
    TEST_ASSERT_EQUAL_UINT32(2U, self->counters.transitions);
}

static void transitions_are_reported_when_the_list_is_full(void)
{
    add_limit(1U, LEVEL);
    enable_function();
    for (unsigned i = 0U; i < MONITORS_TRANSITIONS; i++) {
        scalar_set(LEVEL, ((i % 2U) == 0U) ? 9U : 10U);
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT64((i + 1U) == MONITORS_TRANSITIONS, bench.count);
    }
    const transition_t back = transition_at(0U, 1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, back.previous);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, back.current);
    TEST_ASSERT_EQUAL_UINT16(10U, back.limit);
}

static void a_full_list_is_sent_before_the_next_entry_is_added(void)
{
    for (uint16_t i = 0U; i < 6U; i++) {
        add_limit(i, LEVEL);
    }
    enable_function();
    monitors_step(1U); // Six transitions in one cycle.
    EXPECT_MESSAGES(12, 12);
    TEST_ASSERT_EQUAL_UINT16(4U, octets_u16_at(bench_report(0U).data));
    monitors_step(MONITORS_DELAY);
    EXPECT_MESSAGES(12, 12);
    TEST_ASSERT_EQUAL_UINT16(2U, octets_u16_at(bench_report(0U).data));
    TEST_ASSERT_EQUAL_UINT16(4U, transition_at(0U, 0U).pmon_id);
}

static void refused_transitions_wait_and_those_without_room_are_counted(void)
{
    for (uint16_t i = 0U; i < 6U; i++) {
        add_limit(i, LEVEL);
    }
    enable_function();
    // The port refuses four times: before the fifth transition, before the sixth, and at the end of both
    // cycles.
    bench.refusals = 4U;
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL_UINT32(2U, self->counters.lost);
    monitors_step(2U);
    EXPECT_MESSAGES(12, 12);
    TEST_ASSERT_EQUAL_UINT16(4U, octets_u16_at(bench_report(0U).data));
}

static void transitions_are_split_into_several_packets(void)
{
    static pus_check_transition_t many[250];
    add_limit(1U, LEVEL);
    enable_function();
    self->config.transitions         = many;
    self->config.transition_capacity = 250U;
    self->reporting_delay            = UINT32_MAX;
    for (unsigned i = 0U; i < 249U; i++) {
        scalar_set(LEVEL, 30U - (15U * (i % 2U)));
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    }
    scalar_set(LEVEL, 0U);
    monitors_step(1U);
    EXPECT_MESSAGES(12, 12, 12, 12);
    const uint16_t first = octets_u16_at(bench_report(0U).data);
    TEST_ASSERT_EQUAL_UINT16(250U, first + octets_u16_at(bench_report(1U).data));
    TEST_ASSERT_EQUAL_UINT16(((first % 2U) == 0U) ? 30U : 15U, transition_at(1U, 0U).value);
    TEST_ASSERT_EQUAL_UINT16(0U, transition_at(1U, (uint16_t)(249U - first)).value);
}

static void the_delay_is_changed(void)
{
    static const uint8_t none[] = {0, 0, 0, 0};
    add_limit(1U, LEVEL);
    enable_function();
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, none, sizeof none));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    monitors_step(1U);
    EXPECT_MESSAGES(12, 12);
    records.put_status = STATUS_FULL;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, none, sizeof none));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.unsaved);
}

static void a_status_changes_after_its_number_of_repetitions(void)
{
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 3U, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 10U, 0U, 20U, EVENT_HIGH);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    scalar_set(LEVEL, 15U);
    monitors_step(2U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, status_of(1U));
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
    scalar_set(LEVEL, 30U);
    monitors_step(2U);
    scalar_set(LEVEL, 15U);
    monitors_step(1U); // The repetition counter starts again.
    scalar_set(LEVEL, 30U);
    monitors_step(2U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_HIGH, status_of(1U));
    TEST_ASSERT_EQUAL_UINT(1U, monitors.events.count);
    scalar_set(LEVEL, 0U);
    monitors_step(3U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
    TEST_ASSERT_EQUAL_UINT(1U, monitors.events.count); // Event 0 means "no event".
}

static void each_limit_has_its_event(void)
{
    add_limit(7U, LEVEL);
    enable_function();
    scalar_set(LEVEL, 9U);
    monitors_step(2U);
    TEST_ASSERT_EQUAL_UINT(1U, monitors.events.count);
    TEST_ASSERT_EQUAL_UINT16(EVENT_LOW, monitors.events.id);
    TEST_ASSERT_EQUAL_UINT64(16U, monitors.events.size);
    octet_reader_t reader = octet_reader(monitors.events.auxiliary, monitors.events.size);
    TEST_ASSERT_EQUAL_UINT16(7U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(LEVEL, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LIMIT, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_read_f64(&reader) == 9.0);
    scalar_set(LEVEL, 21U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT16(EVENT_HIGH, monitors.events.id);
    TEST_ASSERT_EQUAL_UINT(2U, monitors.events.count);
}

static void values_at_the_limits_are_within_the_range(void)
{
    static const struct {
        uint16_t value;
        uint8_t status;
    } cases[] = {{9U, PUS_CHECK_LOW},   {10U, PUS_CHECK_NOMINAL}, {20U, PUS_CHECK_NOMINAL},
                 {21U, PUS_CHECK_HIGH}, {0U, PUS_CHECK_LOW},      {65535U, PUS_CHECK_HIGH}};
    add_limit(1U, LEVEL);
    enable_function();
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        scalar_set(LEVEL, cases[i].value);
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT8(cases[i].status, status_of(1U));
    }
}

static void a_value_that_is_not_a_number_is_out_of_limits(void)
{
    const uint32_t real = SCALAR_ID(VALUE_DOUBLE, 1U);
    data_begin(1U);
    data_limit(1U, real, bits_of_double(-1.0), bits_of_double(1.0));
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
    scalar_set(real, NOT_A_NUMBER);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
}

static void expected_values_are_compared_under_their_mask(void)
{
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0x0FF0U, 0x0120U, EVENT_LOW);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    scalar_set(LEVEL, 0xF12FU);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
    scalar_set(LEVEL, 0xF13FU);
    monitors_step(MONITORS_DELAY);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
    TEST_ASSERT_EQUAL_UINT16(EVENT_LOW, monitors.events.id);
    EXPECT_MESSAGES(12, 12);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    for (unsigned i = 0U; i < 2U; i++) {
        (void)octet_read_octets(&reader, 6U);
        TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_EXPECTED, octet_read_u8(&reader));
        TEST_ASSERT_EQUAL_HEX16(0x0FF0U, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_HEX16((i == 0U) ? 0xF12FU : 0xF13FU, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_HEX16(0x0120U, octet_read_u16(&reader));
        (void)octet_read_octets(&reader, 10U);
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

/// Add PMON 1 on the differences of LEVEL: limits -5..5, mean of `count` differences.
static void add_delta(const uint16_t count)
{
    data_begin(1U);
    data_pmon(1U, LEVEL, 1U, 1U, PUS_CHECK_DELTA);
    data_limits(LEVEL, 0xFFFBU, EVENT_LOW, 5U, EVENT_HIGH);
    octet_write_u16(&monitors.data, count);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
}

static void differences_are_checked_from_the_second_sample_on(void)
{
    static const struct {
        uint16_t value;
        uint8_t status;
    } steps[] = {{100U, PUS_CHECK_UNCHECKED}, {105U, PUS_CHECK_NOMINAL}, {111U, PUS_CHECK_HIGH},
                 {106U, PUS_CHECK_NOMINAL},   {100U, PUS_CHECK_LOW},     {100U, PUS_CHECK_NOMINAL}};
    add_delta(1U);
    for (size_t i = 0U; i < (sizeof steps / sizeof steps[0]); i++) {
        scalar_set(LEVEL, steps[i].value);
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT8(steps[i].status, status_of(1U));
    }
    TEST_ASSERT_EQUAL_UINT(2U, monitors.events.count);
}

static void a_mean_of_consecutive_differences_beyond_its_limit_is_reported(void)
{
    static const uint16_t values[] = {100U, 120U, 110U, 115U, 100U, 100U, 131U};
    add_delta(3U);
    for (size_t i = 0U; i < 4U; i++) { // 15 over three steps: 5.
        scalar_set(LEVEL, values[i]);
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT8((i < 3U) ? PUS_CHECK_UNCHECKED : PUS_CHECK_NOMINAL, status_of(1U));
    }
    for (size_t i = 4U; i < 7U; i++) { // From 115 to 131: 16 over three steps.
        scalar_set(LEVEL, values[i]);
        monitors_step(1U);
        TEST_ASSERT_EQUAL_UINT8((i < 6U) ? PUS_CHECK_NOMINAL : PUS_CHECK_HIGH, status_of(1U));
    }
}

static void a_difference_that_is_nan_counts_as_below(void)
{
    const uint32_t real = SCALAR_ID(VALUE_FLOAT, 1U);
    data_begin(1U);
    data_pmon(1U, real, 1U, 1U, PUS_CHECK_DELTA);
    data_limits(real, bits_of_float(-1.0F), 0U, bits_of_float(1.0F), 0U);
    octet_write_u16(&monitors.data, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    monitors_step(1U);
    scalar_set(real, 0x7FC00000U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_LOW, status_of(1U));
    TEST_ASSERT_EQUAL_UINT(0U, monitors.events.count);
}

static void a_monitor_whose_validity_condition_is_false_is_invalid(void)
{
    data_begin(1U);
    octet_write_u16(&monitors.data, 1U);
    octet_write_u32(&monitors.data, LEVEL);
    octet_write_u32(&monitors.data, GATE); // The condition: (GATE & 0x0F) == 0x03.
    octet_write_u8(&monitors.data, 0x0FU);
    octet_write_u8(&monitors.data, 0x03U);
    octet_write_u32(&monitors.data, 1U); // Interval.
    octet_write_u16(&monitors.data, 2U); // Number of repetitions.
    octet_write_u8(&monitors.data, PUS_CHECK_LIMIT);
    data_limits(LEVEL, 10U, EVENT_LOW, 20U, EVENT_HIGH);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, 1U));
    enable_function();
    scalar_set(LEVEL, 15U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, status_of(1U));
    scalar_set(GATE, 0xF3U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, status_of(1U));
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
    scalar_set(LEVEL, 30U);
    monitors_step(1U);
    scalar_set(GATE, 0U);
    monitors_step(2U); // A false condition ends the sequence of equal results and is one transition.
    TEST_ASSERT_EQUAL_UINT32(3U, self->counters.transitions);
    scalar_set(GATE, 3U);
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, status_of(1U));
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_HIGH, status_of(1U));
    self->config.pmons[0].validity.scalar.id = SCALAR_UNKNOWN; // The parameter no longer exists.
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, status_of(1U));
}

static void a_monitor_without_its_parameter_is_invalid(void)
{
    add_limit(1U, LEVEL);
    enable_function();
    scalar_set(LEVEL, 15U);
    monitors_step(1U);
    scalars.is_withdrawn = true;
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, status_of(1U));
    scalars.is_withdrawn = false;
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_NOMINAL, status_of(1U));
}

static void each_parameter_is_sampled_in_its_interval(void)
{
    data_begin(2U);
    data_pmon(1U, LEVEL, 3U, 1U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0U, 0U, 0U);
    data_pmon(2U, LEVEL, 5U, 1U, PUS_CHECK_EXPECTED);
    data_expected(LEVEL, 0U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 2U, 1U));
    enable_function();
    monitors_step(15U);
    TEST_ASSERT_EQUAL_UINT32(5U + 3U, self->counters.checks);
    monitors.cycle += 1000U; // Missed cycles are made up for only once.
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(8U + 2U, self->counters.checks);
}

static void the_cycle_counter_may_wrap(void)
{
    add_limit(1U, LEVEL);
    enable_function();
    monitors.cycle = UINT32_MAX - 2U;
    monitors_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.checks);
    monitors_step(5U);
    TEST_ASSERT_EQUAL_UINT32(6U, self->counters.checks);
}

static void parameters_out_of_limits_are_reported_with_their_transition(void)
{
    add_limit(1U, LEVEL);
    add_limit(2U, SCALAR_ID(VALUE_UINT16, 9U));
    enable_function();
    scalar_set(LEVEL, 15U);
    scalar_set(SCALAR_ID(VALUE_UINT16, 9U), 99U);
    monitors_step(1U);
    scalar_set(SCALAR_ID(VALUE_UINT16, 9U), 100U); // The report has the value at the transition.
    monitors_step(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(10U));
    EXPECT_MESSAGES(1, 1, 1, 3, 12, 11, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, octets_u16_at(bench_report(2U).data));
    TEST_ASSERT_EQUAL_UINT16(2U, transition_at(2U, 0U).pmon_id);
    TEST_ASSERT_EQUAL_UINT16(99U, transition_at(2U, 0U).value);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_UNCHECKED, transition_at(2U, 0U).previous);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(nothing_is_checked_before_definition_and_function_are_enabled);
    RUN_TEST(transitions_are_reported_when_the_delay_is_over);
    RUN_TEST(transitions_are_reported_when_the_list_is_full);
    RUN_TEST(a_full_list_is_sent_before_the_next_entry_is_added);
    RUN_TEST(refused_transitions_wait_and_those_without_room_are_counted);
    RUN_TEST(transitions_are_split_into_several_packets);
    RUN_TEST(the_delay_is_changed);
    RUN_TEST(a_status_changes_after_its_number_of_repetitions);
    RUN_TEST(each_limit_has_its_event);
    RUN_TEST(values_at_the_limits_are_within_the_range);
    RUN_TEST(a_value_that_is_not_a_number_is_out_of_limits);
    RUN_TEST(expected_values_are_compared_under_their_mask);
    RUN_TEST(differences_are_checked_from_the_second_sample_on);
    RUN_TEST(a_mean_of_consecutive_differences_beyond_its_limit_is_reported);
    RUN_TEST(a_difference_that_is_nan_counts_as_below);
    RUN_TEST(a_monitor_whose_validity_condition_is_false_is_invalid);
    RUN_TEST(a_monitor_without_its_parameter_is_invalid);
    RUN_TEST(each_parameter_is_sampled_in_its_interval);
    RUN_TEST(the_cycle_counter_may_wrap);
    RUN_TEST(parameters_out_of_limits_are_reported_with_their_transition);
    return UNITY_END();
}
