// SPDX-License-Identifier: Apache-2.0
// Statistics of parameters: values, intervals, definitions and their records. The numbers of requests and
// reports are subtypes; pus/catalogue/st04_statistics.txt has their names and fields.
#include "pus/st04/st04_statistics.h"

#include "test/support/bounds.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/scalars.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 80U
#define CYCLE_NS 125000000ULL // An eighth of a second.
#define CYCLE_TICKS ((int64_t)PUS_TIME_TICKS_PER_S / 8)
#define LEVEL SCALAR_ID(VALUE_UINT64, 1U)
#define REAL SCALAR_ID(VALUE_DOUBLE, 1U)

static pus_statistics_t statistics;
static pus_statistic_t entries[CAPACITY + 1U]; // The last one does not belong to the service.
static pus_due_t due[CAPACITY];
static uint16_t positions[CAPACITY];
static uint8_t octets[PUS_TC_DATA_MAX];
static octet_writer_t data;
static uint32_t cycle;

static void start(const pus_parameter_port_t* const port)
{
    const pus_statistics_config_t config = {.process     = &bench.process,
                                            .parameters  = *port,
                                            .persistence = records_port(),
                                            .statistics  = entries,
                                            .due         = due,
                                            .positions   = positions,
                                            .capacity    = CAPACITY,
                                            .cycle_ns    = CYCLE_NS};
    memset(entries, 0xA5, sizeof entries);
    cycle = 0U;
    bench_start();
    memset(due, 0xA5, sizeof due);
    memset(positions, 0xA5, sizeof positions);
    memset(&statistics, 0xA5, sizeof statistics);
    pus_statistics_init(&statistics, &config);
    bench_serve(pus_statistics_service(&statistics));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void setUp(void)
{
    const pus_parameter_port_t port = scalars_port();
    records_start();
    start(&port);
}

void tearDown(void)
{
}

static void step(const unsigned cycles)
{
    bench_clear();
    for (unsigned i = 0U; i < cycles; i++) {
        cycle++;
        bench_step(cycle * CYCLE_NS, cycle);
    }
}

static void write_ticks(const int64_t ticks)
{
    for (unsigned i = 7U; i > 0U; i--) {
        octet_write_u8(&data, (uint8_t)((uint64_t)ticks >> (8U * (i - 1U))));
    }
}

static void begin(const unsigned count)
{
    data = octet_writer(octets, sizeof octets);
    octet_write_u8(&data, (uint8_t)count);
}

static void define(const uint32_t id, const int64_t ticks)
{
    octet_write_u32(&data, id);
    write_ticks(ticks);
}

static status_t send(const uint8_t subtype)
{
    bench_clear();
    return bench_request(subtype, octets, data.position);
}

static status_t send_empty(const uint8_t subtype)
{
    bench_clear();
    return bench_request(subtype, NULL, 0U);
}

static void send_definition(const uint32_t id, const int64_t ticks)
{
    begin(1U);
    define(id, ticks);
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

/// Send TC[4,1]; the answer is report 2.
static void request_report(const bool does_reset)
{
    const uint8_t flag = does_reset ? 1U : 0U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, &flag, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 4, 2, 1, 7);
}

typedef struct {
    uint32_t id;
    uint32_t samples;
    uint64_t maximum;
    uint64_t maximum_ns;
    uint64_t minimum;
    uint64_t minimum_ns;
    double mean;
    double deviation;
} entry_t;

static uint64_t time_read(octet_reader_t* const reader)
{
    uint64_t time_ns = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(reader, &time_ns));
    return time_ns - (TEST_EPOCH_S * 1000000000ULL);
}

/// Read the head of a report. Returns the number of its entries.
static uint16_t head_read(octet_reader_t* const reader, uint64_t* const out_start, uint64_t* const out_end)
{
    *out_start = time_read(reader);
    *out_end   = time_read(reader);
    return octet_read_u16(reader);
}

static entry_t entry_read(octet_reader_t* const reader)
{
    entry_t entry           = {.id = octet_read_u32(reader)};
    const value_type_t type = pus_scalar_type(entry.id);
    entry.samples           = octet_read_u32(reader);
    entry.maximum           = pus_scalar_read(reader, type);
    entry.maximum_ns        = time_read(reader);
    entry.minimum           = pus_scalar_read(reader, type);
    entry.minimum_ns        = time_read(reader);
    entry.mean              = octet_read_f64(reader);
    entry.deviation         = octet_read_f64(reader);
    TEST_ASSERT_FALSE(reader->failed);
    return entry;
}

/// Read the only entry of report `index`.
static entry_t only_entry(const size_t index)
{
    uint64_t from         = 0U;
    uint64_t to           = 0U;
    octet_reader_t reader = bench_data(index);
    TEST_ASSERT_EQUAL_UINT16(1U, head_read(&reader, &from, &to));
    const entry_t entry = entry_read(&reader);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    return entry;
}

static void samples_become_extremes_mean_and_deviation(void)
{
    static const uint64_t values[] = {2U, 4U, 4U, 4U, 5U, 5U, 7U, 9U}; // Mean 5, deviation 2.
    send_definition(LEVEL, CYCLE_TICKS);
    for (size_t i = 0U; i < 8U; i++) {
        scalar_set(LEVEL, values[i]);
        step(1U);
    }
    request_report(false);
    uint64_t from         = 0U;
    uint64_t to           = 0U;
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(1U, head_read(&reader, &from, &to));
    const entry_t entry = entry_read(&reader);
    TEST_ASSERT_EQUAL_UINT64(CYCLE_NS, from);
    // The time field counts 2^-24 s, so the reported time may be up to 60 ns earlier.
    TEST_ASSERT_TRUE((to >= TEST_NOW_NS - 60U) && (to <= TEST_NOW_NS + 1U));
    TEST_ASSERT_EQUAL_HEX32(LEVEL, entry.id);
    TEST_ASSERT_EQUAL_UINT32(8U, entry.samples);
    TEST_ASSERT_EQUAL_UINT64(9U, entry.maximum);
    TEST_ASSERT_EQUAL_UINT64(8U * CYCLE_NS, entry.maximum_ns);
    TEST_ASSERT_EQUAL_UINT64(2U, entry.minimum);
    TEST_ASSERT_EQUAL_UINT64(CYCLE_NS, entry.minimum_ns);
    EXPECT_WITHIN(5.0, 1e-12, entry.mean);
    EXPECT_WITHIN(2.0, 1e-12, entry.deviation);
    request_report(true); // The flag resets, after the report.
    TEST_ASSERT_EQUAL_UINT32(8U, only_entry(2U).samples);
    scalar_set(LEVEL, 3U);
    step(1U);
    request_report(false);
    TEST_ASSERT_EQUAL_UINT32(1U, only_entry(2U).samples);
    EXPECT_WITHIN(3.0, 0.0, only_entry(2U).mean);
    EXPECT_WITHIN(0.0, 0.0, only_entry(2U).deviation);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(3U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    request_report(false);
    TEST_ASSERT_EQUAL_UINT64(18U,
                             bench_report(2U).size); // A parameter without a sample is not reported.
}

static void extremes_are_exact_and_small_changes_on_large_values_are_kept(void)
{
    send_definition(LEVEL, CYCLE_TICKS);
    send_definition(REAL, CYCLE_TICKS);
    scalar_set(LEVEL, UINT64_MAX - 1U);
    scalar_set(REAL, bits_of_double(1e9 + 4.0));
    step(1U);
    scalar_set(LEVEL, UINT64_MAX);
    scalar_set(REAL, bits_of_double(1e9 + 7.0));
    step(1U);
    scalar_set(LEVEL, UINT64_MAX - 2U);
    scalar_set(REAL, bits_of_double(1e9 + 13.0));
    step(1U);
    scalar_set(REAL, bits_of_double(1e9 + 16.0));
    step(1U);
    request_report(false);
    uint64_t from         = 0U;
    uint64_t to           = 0U;
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, head_read(&reader, &from, &to));
    const entry_t level = entry_read(&reader);
    const entry_t real  = entry_read(&reader);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, level.maximum);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX - 2U, level.minimum);
    EXPECT_WITHIN(1e9 + 10.0, 1e-6, real.mean);
    EXPECT_WITHIN(4.743416490252569, 1e-6, real.deviation); // Root of 22.5.
}

static void values_that_are_not_finite_are_left_out(void)
{
    send_definition(REAL, CYCLE_TICKS);
    scalar_set(REAL, 0x7FF8000000000000ULL);
    step(1U);
    scalar_set(REAL, 0x7FF0000000000000ULL);
    step(1U);
    scalar_set(REAL, 0xFFF0000000000000ULL);
    step(1U);
    scalar_set(REAL, bits_of_double(-1.5));
    step(1U);
    request_report(false);
    TEST_ASSERT_EQUAL_UINT32(1U, only_entry(2U).samples);
    EXPECT_WITHIN(-1.5, 0.0, only_entry(2U).mean);
    TEST_ASSERT_EQUAL_UINT32(3U, statistics.counters.not_finite);
    scalars.is_withdrawn = true;
    step(2U);
    TEST_ASSERT_EQUAL_UINT32(2U, statistics.counters.missing);
}

static void a_full_statistic_accepts_no_more_samples(void)
{
    send_definition(LEVEL, CYCLE_TICKS);
    step(1U);
    entries[0].samples = UINT32_MAX - 1U;
    step(3U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, entries[0].samples);
    TEST_ASSERT_EQUAL_UINT32(2U, statistics.counters.samples);
}

static void each_parameter_is_sampled_in_its_interval(void)
{
    send_definition(LEVEL, CYCLE_TICKS * 3);
    send_definition(REAL, (CYCLE_TICKS * 5) + 1);
    step(15U);
    TEST_ASSERT_EQUAL_UINT32(5U + 3U, statistics.counters.samples);
    send_definition(LEVEL, CYCLE_TICKS); // An update starts the statistics again.
    step(2U);
    TEST_ASSERT_EQUAL_UINT32(2U, entries[0].samples);
}

static void each_periodic_report_covers_one_interval(void)
{
    send_definition(LEVEL, CYCLE_TICKS);
    begin(0U);
    data.position = 0U;
    write_ticks(CYCLE_TICKS * 4);
    TEST_ASSERT_EQUAL(STATUS_OK, send(4U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    step(9U);
    EXPECT_MESSAGES(4, 2, 4, 2);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    TEST_ASSERT_EQUAL_UINT32(4U, only_entry(0U).samples);
    TEST_ASSERT_EQUAL_UINT32(4U, only_entry(1U).samples);
    cycle += 100U; // Missed intervals count as one.
    step(1U);
    EXPECT_MESSAGES(4, 2);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    step(10U);
    EXPECT_MESSAGES(0);
}

static void intervals_below_a_cycle_are_refused(void)
{
    static const int64_t bad[] = {0, -1, CYCLE_TICKS - 1, -CYCLE_TICKS};
    for (size_t i = 0U; i < 4U; i++) {
        begin(1U);
        define(LEVEL, bad[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 1U);
        begin(0U);
        data.position = 0U;
        write_ticks(bad[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, send(4U));
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    }
    TEST_ASSERT_EQUAL_UINT32(8U, statistics.counters.refused);
    send_definition(LEVEL, (1LL << 55) - 1); // The interval is 68 years.
    step(2U);
    TEST_ASSERT_EQUAL_UINT32(1U, statistics.counters.samples);
}

static void each_refusal_has_its_code(void)
{
    begin(4U);
    define(SCALAR_UNKNOWN, CYCLE_TICKS);
    define(LEVEL, CYCLE_TICKS);
    define(SCALAR_SECRET, CYCLE_TICKS);
    define(SCALAR_ARRAY, CYCLE_TICKS);
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, SCALAR_UNKNOWN);
    expect_failure(3U, 4U, PUS_FAILURE_ACCESS, 3U, SCALAR_SECRET);
    expect_failure(4U, 4U, PUS_FAILURE_ACCESS, 4U, SCALAR_ARRAY);
    begin(CAPACITY);
    for (uint32_t i = 0U; i < CAPACITY; i++) {
        define(SCALAR_ID(VALUE_UINT8, i), CYCLE_TICKS);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U)); // One entry of the table is taken.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, CAPACITY, CAPACITY);
}

static void long_reports_are_split_into_several_packets(void)
{
    begin(CAPACITY);
    for (uint32_t i = 0U; i < CAPACITY; i++) {
        define(SCALAR_ID(VALUE_DOUBLE, i), CYCLE_TICKS);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    step(1U);
    const uint8_t flag = 1U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, &flag, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 4, 2, 4, 2, 1, 7);
    uint64_t from         = 0U;
    uint64_t to           = 0U;
    octet_reader_t first  = bench_data(2U);
    octet_reader_t second = bench_data(3U);
    const uint16_t count  = head_read(&first, &from, &to);
    TEST_ASSERT_EQUAL_UINT16(CAPACITY - count, head_read(&second, &from, &to));
    TEST_ASSERT_EQUAL_HEX32(SCALAR_ID(VALUE_DOUBLE, count), entry_read(&second).id);
    TEST_ASSERT_EQUAL_UINT32(0U, entries[0].samples);
}

static void a_lost_statistic_is_counted_or_not_reset_after_a_request(void)
{
    begin(CAPACITY);
    for (uint32_t i = 0U; i < CAPACITY; i++) {
        define(SCALAR_ID(VALUE_DOUBLE, i), CYCLE_TICKS);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    begin(0U);
    data.position = 0U;
    write_ticks(CYCLE_TICKS * 2);
    TEST_ASSERT_EQUAL(STATUS_OK, send(4U));
    bench.refusals = 1000U;
    step(4U); // Two reports are due; the process keeps no report of this class.
    TEST_ASSERT_EQUAL_UINT32(2U, statistics.counters.lost);
    step(1U);
    const uint8_t flag = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, &flag, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, entries[0].samples);
}

static void definitions_are_deleted(void)
{
    begin(3U);
    define(LEVEL, CYCLE_TICKS);
    define(REAL, CYCLE_TICKS);
    define(SCALAR_ID(VALUE_BOOL, 3U), CYCLE_TICKS);
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    begin(2U);
    octet_write_u32(&data, LEVEL);
    octet_write_u32(&data, SCALAR_UNKNOWN);
    TEST_ASSERT_EQUAL(STATUS_OK, send(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, SCALAR_UNKNOWN);
    step(1U);
    TEST_ASSERT_EQUAL_UINT32(2U, statistics.counters.samples);
    records.erase_status = STATUS_IO;
    begin(1U);
    octet_write_u32(&data, REAL);
    TEST_ASSERT_EQUAL(STATUS_OK, send(7U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    begin(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, send(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    records.erase_status = STATUS_NOT_FOUND; // The store has lost the records.
    TEST_ASSERT_EQUAL(STATUS_OK, send(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    step(1U);
    TEST_ASSERT_EQUAL_UINT32(2U, statistics.counters.samples);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const record, const size_t size)
{
    return pus_statistics_restore(self, key, record, size);
}

static void definitions_are_reported_and_outlast_a_power_cut(void)
{
    static const uint8_t expected[] = {0, 0, 0, 2, 0,    0, 0, 0, 2, 2, 3, 0, 1, //
                                       0, 0, 0, 0, 0x20, 0, 0, 2, 9, 0, 1, 0, 0, 0, 1, 0x80, 0, 0};
    const pus_parameter_port_t port = statistics.config.parameters;
    send_definition(LEVEL, CYCLE_TICKS);
    send_definition(REAL, CYCLE_TICKS * 12);
    begin(0U);
    data.position = 0U;
    write_ticks((int64_t)PUS_TIME_TICKS_PER_S * 2);
    TEST_ASSERT_EQUAL(STATUS_OK, send(4U));
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, send_empty(8U));
        EXPECT_MESSAGES(1, 1, 1, 3, 4, 9, 1, 7);
        TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
        records_cut();
        start(&port);
        TEST_ASSERT_EQUAL_UINT64(3U, records_replay(PUS_SERVICE_STATISTICS, restore, &statistics));
    }
    step(16U);
    EXPECT_MESSAGES(4, 2);
}

static void a_change_that_cannot_be_stored_is_refused(void)
{
    records.put_status = STATUS_FULL;
    begin(1U);
    define(LEVEL, CYCLE_TICKS);
    TEST_ASSERT_EQUAL(STATUS_OK, send(6U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    begin(0U);
    data.position = 0U;
    write_ticks(CYCLE_TICKS);
    TEST_ASSERT_EQUAL(STATUS_OK, send(4U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_OK, send_empty(5U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_EQUAL_UINT32(3U, statistics.counters.unsaved);
    step(2U);
    EXPECT_MESSAGES(0);
    TEST_ASSERT_EQUAL_UINT32(0U, statistics.counters.samples);
}

static void without_a_store_all_requests_are_performed(void)
{
    statistics.config.persistence = NULL;
    send_definition(LEVEL, CYCLE_TICKS);
    begin(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, send(7U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(0U, records.puts);
}

static void bad_records_are_reported(void)
{
    static const uint8_t one[]  = {0, 0, 0, 1, 0, 0, 0, 0};
    static const uint8_t none[] = {0, 0, 0, 0, 0, 0, 0};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_statistics_restore(&statistics, LEVEL, one, 6U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_statistics_restore(&statistics, LEVEL, one, 8U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_statistics_restore(&statistics, LEVEL, none, 7U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_statistics_restore(&statistics, SCALAR_ARRAY, one, 7U));
    for (uint32_t i = 0U; i < CAPACITY; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_statistics_restore(&statistics, SCALAR_ID(VALUE_UINT8, i), one, 7U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, pus_statistics_restore(&statistics, SCALAR_ID(VALUE_UINT8, 1U), one, 7U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_statistics_restore(&statistics, LEVEL, one, 7U));
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t empty[]  = {3U, 5U, 8U};
    static const uint8_t zeros[7] = {0};
    uint8_t copy[32];
    begin(2U);
    define(LEVEL, CYCLE_TICKS);
    define(REAL, CYCLE_TICKS);
    memcpy(copy, octets, data.position);
    expect_strict_format(6U, copy, data.position);
    copy[0] = 1U;
    expect_strict_format(7U, copy, 5U);
    expect_strict_format(1U, zeros, 1U);
    expect_strict_format(4U, zeros, 7U);
    for (size_t i = 0U; i < sizeof empty; i++) {
        expect_strict_format(empty[i], NULL, 0U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(samples_become_extremes_mean_and_deviation);
    RUN_TEST(extremes_are_exact_and_small_changes_on_large_values_are_kept);
    RUN_TEST(values_that_are_not_finite_are_left_out);
    RUN_TEST(a_full_statistic_accepts_no_more_samples);
    RUN_TEST(each_parameter_is_sampled_in_its_interval);
    RUN_TEST(each_periodic_report_covers_one_interval);
    RUN_TEST(intervals_below_a_cycle_are_refused);
    RUN_TEST(each_refusal_has_its_code);
    RUN_TEST(long_reports_are_split_into_several_packets);
    RUN_TEST(a_lost_statistic_is_counted_or_not_reset_after_a_request);
    RUN_TEST(definitions_are_deleted);
    RUN_TEST(definitions_are_reported_and_outlast_a_power_cut);
    RUN_TEST(a_change_that_cannot_be_stored_is_refused);
    RUN_TEST(without_a_store_all_requests_are_performed);
    RUN_TEST(bad_records_are_reported);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
