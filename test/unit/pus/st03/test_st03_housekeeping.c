// SPDX-License-Identifier: Apache-2.0
// Housekeeping structures: sampling, requests that change them, and sampling in another loop. The numbers of
// requests and reports are subtypes; pus/catalogue/st03_housekeeping.txt has their names and fields.
#include "pus/st03/st03_housekeeping.h"

#include "test/unit/pus/fixtures/parameters.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define STRUCTURES 4U
#define SAMPLE_SIZE 64U

static pus_hk_t hk;
static pus_hk_structure_t structures[STRUCTURES + 1U]; // The last one does not belong to the service.
static uint8_t samples[STRUCTURES * SAMPLE_SIZE];
static uint32_t cycle;

void setUp(void)
{
    bench_start();
    const pus_hk_config_t config = {.process         = &bench.process,
                                    .parameters      = dictionary_port(),
                                    .structures      = structures,
                                    .structure_count = STRUCTURES,
                                    .samples         = samples,
                                    .sample_size     = SAMPLE_SIZE};
    memset(structures, 0xA5, sizeof structures);
    pus_hk_init(&hk, &config);
    bench_serve(pus_hk_service(&hk));
    cycle = 1000U;
}

void tearDown(void)
{
}

/// Step this number of cycles. The values read show the number of the cycle, counted from 1.
static void run(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        dictionary.tick++;
        cycle++;
        bench.services[0].step(bench.services[0].self, TEST_NOW_NS, cycle);
    }
}

/// Add structure `id`: every 6 cycles, U16 and 3 samples of {U8, DOUBLE}.
static status_t add_structure(const uint16_t id, const bool is_periodic)
{
    static const uint32_t simple[]              = {P_U16};
    static const uint32_t super[]               = {P_U8, P_DOUBLE};
    static const pus_hk_set_definition_t sets[] = {
        {.repetitions = 3U, .parameter_count = 2U, .parameters = super}};
    const pus_hk_definition_t definition = {.id              = id,
                                            .interval        = 6U,
                                            .is_periodic     = is_periodic,
                                            .parameter_count = 1U,
                                            .set_count       = 1U,
                                            .parameters      = simple,
                                            .sets            = sets};
    return pus_hk_add(&hk, &definition);
}

/// Add a structure of one U8, every 2 cycles.
static status_t add_simple_structure(const uint16_t id, const bool is_periodic)
{
    static const uint32_t simple[]       = {P_U8};
    const pus_hk_definition_t definition = {
        .id = id, .interval = 2U, .is_periodic = is_periodic, .parameter_count = 1U, .parameters = simple};
    return pus_hk_add(&hk, &definition);
}

/// Expect a report of structure `id` whose samples have these ticks; the simple values have the last tick.
static void expect_report(const size_t index, const uint16_t id, const uint8_t first, const uint8_t second,
                          const uint8_t third)
{
    const uint8_t ticks[] = {first, second, third};
    const pus_tm_t tm     = bench_report(index);
    octet_reader_t reader = bench_data(index);
    TEST_ASSERT_EQUAL_UINT8(25U, tm.subtype);
    TEST_ASSERT_EQUAL_UINT16(id, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT8(third, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(third + 1U, octet_read_u8(&reader));
    for (size_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT8(ticks[i], octet_read_u8(&reader)); // Sample by sample: U8, then the double.
        for (uint8_t k = 0U; k < 8U; k++) {
            TEST_ASSERT_EQUAL_UINT8(ticks[i] + k, octet_read_u8(&reader));
        }
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void samples_are_spread_over_the_interval(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    run(5U);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    run(1U);
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    expect_report(0U, 5U, 2U, 4U, 6U);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    run(6U);
    TEST_ASSERT_EQUAL_UINT64(2U, bench.count);
    expect_report(1U, 5U, 8U, 10U, 12U);
    TEST_ASSERT_EQUAL_UINT32(2U, hk.counters.reports);
}

static void missed_cycles_are_sampled_late_and_the_interval_is_kept(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    run(3U);
    cycle += 4U; // The step after the gap is cycle 8: cycle 2 of the second interval.
    run(1U);
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    expect_report(0U, 5U, 2U, 4U, 4U);
    run(4U);
    TEST_ASSERT_EQUAL_UINT64(2U, bench.count); // The second interval ends with cycle 12.
    cycle += 600U;
    run(1U);
    TEST_ASSERT_EQUAL_UINT64(3U, bench.count);
}

static void the_cycle_counter_may_wrap(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    cycle = UINT32_MAX - 3U;
    run(18U);
    TEST_ASSERT_EQUAL_UINT64(3U, bench.count);
    expect_report(0U, 5U, 2U, 4U, 6U);
    expect_report(2U, 5U, 14U, 16U, 18U);
}

static void all_samples_are_taken_if_they_do_not_divide_the_interval(void)
{
    static const uint32_t super[] = {P_U8};
    for (uint32_t interval = 1U; interval <= 20U; interval++) {
        for (uint16_t repetitions = 1U; repetitions <= interval; repetitions++) {
            setUp();
            const pus_hk_set_definition_t set    = {repetitions, 1U, super};
            const pus_hk_definition_t definition = {
                .id = 1U, .interval = interval, .is_periodic = true, .set_count = 1U, .sets = &set};
            TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
            run(interval);
            TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
            octet_reader_t reader = bench_data(0U);
            (void)octet_read_u16(&reader);
            for (uint32_t k = 1U; k <= repetitions; k++) {
                const uint32_t due = ((k * interval) + repetitions - 1U) / repetitions; // Rounded up.
                TEST_ASSERT_EQUAL_UINT8(due, octet_read_u8(&reader));
            }
            TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
        }
    }
}

static void a_refused_report_is_dropped_and_counted(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    bench.refusals = 1U;
    run(12U);
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    expect_report(0U, 5U, 8U, 10U, 12U);
    TEST_ASSERT_EQUAL_UINT16(0U, bench_report(0U).sequence);
    TEST_ASSERT_EQUAL_UINT32(1U, hk.counters.dropped);
}

static void bad_definitions_are_refused(void)
{
    static const uint32_t ids[]    = {P_U8, P_U8, P_UNKNOWN, P_SECRET, P_LARGE};
    pus_hk_set_definition_t set    = {.repetitions = 2U, .parameter_count = 1U, .parameters = ids};
    pus_hk_definition_t definition = {.id = 1U, .interval = 2U, .parameter_count = 2U, .parameters = ids};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition)); // The same parameter is listed twice.
    definition.parameter_count = 5U;
    // The first wrong parameter determines the failure.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition));
    definition.parameter_count = 1U;
    definition.interval        = 0U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition));
    definition.interval   = 1U;
    definition.parameters = &ids[2];
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_hk_add(&hk, &definition));
    definition.parameters = &ids[3];
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, pus_hk_add(&hk, &definition));
    definition.parameters = &ids[4];
    // The values have more octets than a sample buffer.
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_hk_add(&hk, &definition));
    definition.parameter_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition)); // The structure has no parameter.
    definition.set_count = 1U;
    definition.sets      = &set;
    // The set has more samples than the interval has cycles.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition));
    const pus_hk_set_definition_t sets[] = {{2U, 1U, &ids[2]}, {2U, 1U, &ids[3]}};
    definition.interval                  = 2U;
    definition.set_count                 = 2U;
    definition.sets                      = sets;
    // The first wrong set determines the failure.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_hk_add(&hk, &definition));
    definition.set_count = 1U;
    definition.sets      = &set;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, pus_hk_add(&hk, &definition));
    for (uint16_t id = 2U; id <= (STRUCTURES + 1U); id++) {
        TEST_ASSERT_EQUAL((id <= STRUCTURES) ? STATUS_OK : STATUS_EXHAUSTED, add_simple_structure(id, false));
    }
    pus_hk_clear(&hk);
    TEST_ASSERT_EQUAL(STATUS_OK, add_simple_structure(1U, false));
}

static void samples_may_fill_their_buffer_to_the_last_octet(void)
{
    static const uint32_t super[]        = {P_U8};
    pus_hk_set_definition_t set          = {SAMPLE_SIZE, 1U, super};
    const pus_hk_definition_t definition = {
        .id = 1U, .interval = 100U, .is_periodic = true, .set_count = 1U, .sets = &set};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
    run(100U);
    TEST_ASSERT_EQUAL_UINT64(2U + SAMPLE_SIZE, bench_report(0U).size);
    pus_hk_clear(&hk);
    set.repetitions = SAMPLE_SIZE + 1U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_hk_add(&hk, &definition));
}

// ---- Requests ----

/// TC[3,1] for structure 9: interval 4, {U16}, {2 x {U8, DOUBLE}}; the set begins at octet 12.
static const uint8_t create_9[] = {0, 9, 0, 0, 0, 4, 1, 2, 1, 0, 2, 1, 0, 2, 2, 2, 0, 0, 1, 2, 9, 0, 3};

static void a_structure_is_created_reported_enabled_and_deleted(void)
{
    static const uint8_t one[] = {1, 0, 9};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, create_9, sizeof create_9));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();

    // Structure 9, disabled, interval 4; one parameter; one set of two samples with two parameters.
    static const uint8_t report[] = {0, 9, 0, 0, 0, 0, 4, 0, 1, 2, 1,    0, 2, 0,
                                     1, 0, 2, 0, 2, 2, 0, 0, 1, 2, 0x09, 0, 3};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(9U, one, sizeof one));
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 10, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof report, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(report, bench_report(2U).data, sizeof report);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);

    run(4U);
    TEST_ASSERT_EQUAL_UINT64(4U, bench.count); // The structure is created disabled.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(5U, one, sizeof one));
    bench_clear();
    run(4U);
    EXPECT_MESSAGES(3, 25);
    TEST_ASSERT_EQUAL_UINT64(2U + 2U + (2U * 9U), bench_report(0U).size);

    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, one, sizeof one));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, 9U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(6U, one, sizeof one));
    bench_clear();
    run(8U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, one, sizeof one));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, one, sizeof one));
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 9U);
}

/// Expect that TC[3,1] with this data is refused as a whole and creates no structure.
static void expect_not_created(const uint8_t* const data, const size_t size, const uint16_t code,
                               const uint32_t detail)
{
    static const uint8_t one[] = {1, 0, 9};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, size));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 0U, detail);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(9U, one, sizeof one));
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 9U);
}

static void creation_is_refused_as_a_whole(void)
{
    uint8_t data[sizeof create_9];
    memcpy(data, create_9, sizeof data);
    data[5] = 0U; // The interval is 0.
    expect_not_created(data, sizeof data, PUS_FAILURE_OUT_OF_RANGE, 2U);
    data[5] = 1U; // The interval has fewer cycles than samples.
    expect_not_created(data, sizeof data, PUS_FAILURE_OUT_OF_RANGE, 12U);
    data[5]  = 4U;
    data[13] = 0U; // The set has no sample.
    expect_not_created(data, sizeof data, PUS_FAILURE_OUT_OF_RANGE, 12U);
    data[13] = 2U;
    put_id(&data[15], P_U16);
    expect_not_created(data, sizeof data, PUS_FAILURE_DUPLICATE, P_U16);
    put_id(&data[15], P_UNKNOWN);
    expect_not_created(data, sizeof data, PUS_FAILURE_UNKNOWN_ID, P_UNKNOWN);
    put_id(&data[7], P_SECRET);
    expect_not_created(data, sizeof data, PUS_FAILURE_ACCESS, P_SECRET);
    put_id(&data[7], P_LARGE);
    put_id(&data[15], P_U8);
    expect_not_created(data, sizeof data, PUS_FAILURE_TABLE_FULL, SAMPLE_SIZE);
    static const uint8_t nothing[] = {0, 9, 0, 0, 0, 4, 0, 0};
    expect_not_created(nothing, sizeof nothing, PUS_FAILURE_OUT_OF_RANGE, 6U);
    static const uint8_t empty_set[] = {0, 9, 0, 0, 0, 4, 0, 1, 0, 2, 0};
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, empty_set, sizeof empty_set));
    static const uint8_t many_samples[] = {0, 9, 0, 1, 0, 0, 0, 1, 0xFF, 0xFF, 1, 2, 24, 0, 4};
    expect_not_created(many_samples, sizeof many_samples, PUS_FAILURE_TABLE_FULL, SAMPLE_SIZE);

    static const uint8_t wrong_sets[] = {0, 9, 0, 0, 0, 4, 0, 2, 0, 0, 1, 2, 0, 0, 1, 0, 2, 1, 2, 3, 3, 0xE7};
    expect_not_created(wrong_sets, sizeof wrong_sets, PUS_FAILURE_OUT_OF_RANGE, 8U);

    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, create_9, sizeof create_9));
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, create_9, sizeof create_9));
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, 9U);
}

static void structures_and_lists_beyond_the_capacity_are_refused(void)
{
    static uint8_t data[6U + 1U + (255U * 4U) + 1U];
    for (unsigned count = 0U; count <= 255U; count++) {
        pus_hk_clear(&hk);
        bench_clear();
        memset(data, 0, sizeof data);
        data[1] = 9U;
        data[5] = 4U;
        data[6] = (uint8_t)count;
        for (unsigned i = 0U; i < count; i++) {
            put_id(&data[7U + (4U * i)], P_MANY + i);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, 8U + (4U * count)));
        if (count == 0U) {
            expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 6U);
        } else if (count <= PUS_HK_PARAMETERS_MAX) {
            EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
        } else {
            expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, PUS_HK_PARAMETERS_MAX);
        }
    }
    memset(data, 0, sizeof data);
    data[1] = 10U;
    data[5] = 4U;
    for (unsigned sets = 1U; sets <= (PUS_HK_SETS_MAX + 1U); sets++) {
        pus_hk_clear(&hk);
        bench_clear();
        data[7] = (uint8_t)sets;
        for (unsigned i = 0U; i < sets; i++) {
            data[8U + (7U * i) + 1U] = 1U;
            data[8U + (7U * i) + 2U] = 1U;
            put_id(&data[8U + (7U * i) + 3U], P_MANY + i);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, 8U + (7U * sets)));
        if (sets > PUS_HK_SETS_MAX) {
            expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, PUS_HK_SETS_MAX);
        }
    }
    pus_hk_clear(&hk);
    for (uint16_t id = 100U; id < (100U + STRUCTURES); id++) {
        TEST_ASSERT_EQUAL(STATUS_OK, add_simple_structure(id, false));
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, create_9, sizeof create_9));
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, STRUCTURES);
}

static void parameters_are_appended_to_their_sets(void)
{
    static const uint8_t one[] = {1, 0, 9};
    // U8 is already in a set; STRUCT becomes a simple parameter, and MANY makes a second set.
    uint8_t data[]                = {0, 9, 1, 0, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0};
    static const uint8_t report[] = {0, 9, 0, 0, 0, 0, 4, 0, 2, 2, 1, 0, 2, 2, 24, 0, 4, 0, 2,  0,
                                     2, 0, 2, 2, 0, 0, 1, 2, 9, 0, 3, 0, 1, 0, 1,  2, 0, 0, 100};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, create_9, sizeof create_9));
    put_id(&data[3], P_U8);
    put_id(&data[11], P_MANY);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(29U, data, sizeof data));
    expect_failure(1U, 4U, PUS_FAILURE_DUPLICATE, 0U, P_U8);
    put_id(&data[3], P_STRUCT);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(29U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(9U, one, sizeof one));
    TEST_ASSERT_EQUAL_UINT64(sizeof report, bench_report(5U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(report, bench_report(5U).data, sizeof report);

    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(5U, one, sizeof one));
    bench_clear();
    run(4U);
    const pus_tm_t tm = bench_report(0U);
    TEST_ASSERT_EQUAL_UINT64(2U + 2U + 11U + (2U * 9U) + 1U, tm.size);
    TEST_ASSERT_EQUAL_UINT8(4U, tm.data[2]);   // U16 of cycle 4
    TEST_ASSERT_EQUAL_UINT8(14U, tm.data[14]); // last octet of STRUCT
    TEST_ASSERT_EQUAL_UINT8(2U, tm.data[15]);  // U8 of cycle 2
    TEST_ASSERT_EQUAL_UINT8(4U, tm.data[24]);  // U8 of cycle 4
    TEST_ASSERT_EQUAL_UINT8(4U, tm.data[33]);  // MANY of cycle 4
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(29U, data, sizeof data));
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 9U);
    data[1] = 8U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(29U, data, sizeof data));
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 8U);
}

static void one_shot_reports_are_sent_to_the_requester_and_leave_periodic_ones_unchanged(void)
{
    static const uint8_t two[] = {2, 0, 5, 0, 6};
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(6U, false));
    run(3U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(27U, two, sizeof two));
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 25, 3, 25, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(2U, hk.counters.reports);
    expect_report(2U, 5U, 3U, 3U, 3U);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
    bench_clear();
    run(3U);
    expect_report(0U, 5U, 2U, 4U, 6U);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    bench.refusals = 1000U; // No report is sent or queued any more.
    while (hk.counters.dropped == 0U) {
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(27U, two, sizeof two));
    }
}

static void intervals_are_modified_one_by_one(void)
{
    static const uint8_t data[] = {4, 0, 5, 0, 0, 0, 2, 0, 8, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 7, 0, 0, 0, 9};
    static const uint8_t all[]  = {3, 0, 5, 0, 6, 0, 7};
    static const uint8_t properties[] = {0, 3, 0, 5, 0, 0, 0, 0, 6, 0, 6, 0, 0, 0, 0, 2, 0, 7, 1, 0, 0, 0, 2};
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, false));
    TEST_ASSERT_EQUAL(STATUS_OK, add_simple_structure(6U, false));
    TEST_ASSERT_EQUAL(STATUS_OK, add_simple_structure(7U, true));
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(31U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 4);            // No instruction is valid.
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 3U); // 3 samples need 3 cycles.
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, 8U);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 15U);
    expect_failure(4U, 4U, PUS_FAILURE_STATE, 4U, 7U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(33U, all, sizeof all));
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 35, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof properties, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(properties, bench_report(2U).data, sizeof properties);
    static const uint8_t good[]  = {2, 0, 5, 0, 0, 0, 3, 0, 99, 0, 0, 0, 1};
    static const uint8_t some[]  = {2, 0, 99, 0, 5};
    static const uint8_t after[] = {0, 1, 0, 5, 0, 0, 0, 0, 3};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(31U, good, sizeof good));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(33U, some, sizeof some));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 3, 35, 1, 8);
    TEST_ASSERT_EQUAL_UINT64(sizeof after, bench_report(3U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(after, bench_report(3U).data, sizeof after);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(33U, (const uint8_t[]){1, 0, 99}, 3U));
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void lists_of_255_are_served(void)
{
    static const uint8_t lists[] = {3U, 5U, 6U, 9U, 27U, 33U};
    uint8_t data[1U + (255U * 2U)];
    data[0] = 255U;
    for (size_t i = 0U; i < sizeof lists; i++) {
        for (size_t k = 0U; k < 255U; k++) {
            data[1U + (2U * k)] = 0U;
            data[2U + (2U * k)] = 5U;
        }
        bench_clear();
        pus_hk_clear(&hk);
        TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, false));
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(lists[i], data, sizeof data));
        TEST_ASSERT_EQUAL_UINT8((lists[i] == 3U) ? 8U : 7U, bench_report(bench.count - 1U).subtype);
    }
}

static void enabling_twice_does_not_restart_the_interval(void)
{
    static const uint8_t one[] = {1, 0, 5};
    TEST_ASSERT_EQUAL(STATUS_OK, add_structure(5U, true));
    run(4U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(5U, one, sizeof one));
    bench_clear();
    run(2U);
    EXPECT_MESSAGES(3, 25);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t lists[]    = {3U, 5U, 6U, 9U, 27U, 33U};
    static const uint8_t list[]     = {2, 0, 5, 0, 6};
    static const uint8_t interval[] = {1, 0, 5, 0, 0, 0, 2};
    static const uint8_t append[]   = {0, 9, 1, 0, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0};
    for (size_t i = 0U; i < sizeof lists; i++) {
        expect_strict_format(lists[i], list, sizeof list);
        TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(lists[i], "\0", 1U)); // Zero instructions.
        expect_failure(0U, 2U, PUS_FAILURE_DATA, 0U, 0U);
    }
    expect_strict_format(1U, create_9, sizeof create_9);
    expect_strict_format(29U, append, sizeof append);
    expect_strict_format(31U, interval, sizeof interval);
}

// ---- Another loop ----

#define LOOP 3U
#define TAKEN_NS (TEST_NOW_NS + 7000000U)

static osal_mutex_t mutex;
static uint8_t values[SAMPLE_SIZE];
static uint8_t handed[SAMPLE_SIZE];
static size_t handed_size;
static unsigned handed_count;

static void take_report(void* context, uint16_t id, uint64_t now_ns, const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&handed, context);
    TEST_ASSERT_EQUAL_UINT16(5U, id);
    TEST_ASSERT_EQUAL_UINT64(TAKEN_NS, now_ns);
    TEST_ASSERT_EQUAL_PTR(values, octets);
    (void)memcpy(handed, octets, size);
    handed_size = size;
    handed_count++;
}

static void run_loop(const uint8_t loop, const unsigned cycles)
{
    const pus_hk_outlet_t outlet = {.context = &handed, .put = take_report, .values = values};
    for (unsigned i = 0U; i < cycles; i++) {
        dictionary.tick++;
        cycle++;
        pus_hk_loop_step(&hk, loop, TAKEN_NS, cycle, &outlet);
    }
}

static void another_loop_samples_its_own_parameters_and_passes_the_report_on(void)
{
    static const uint32_t simple[]              = {P_U16};
    static const uint32_t super[]               = {P_U8, P_DOUBLE};
    static const pus_hk_set_definition_t sets[] = {
        {.repetitions = 3U, .parameter_count = 2U, .parameters = super}};
    const pus_hk_definition_t definition = {.id              = 5U,
                                            .interval        = 6U,
                                            .is_periodic     = true,
                                            .loop            = LOOP,
                                            .parameter_count = 1U,
                                            .set_count       = 1U,
                                            .parameters      = simple,
                                            .sets            = sets};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&mutex, false));
    hk.config.mutex = &mutex;
    handed_count    = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
    run(12U); // The loop of the process and a third loop do not affect the structure.
    run_loop(LOOP - 1U, 12U);
    TEST_ASSERT_EQUAL(0U, handed_count);
    dictionary.tick = 0U;
    run_loop(LOOP, 6U);
    TEST_ASSERT_EQUAL(1U, handed_count);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    pus_hk_forward(&hk, 5U, TAKEN_NS, handed, handed_size);
    expect_report(0U, 5U, 2U, 4U, 6U);
    TEST_ASSERT_UINT64_WITHIN(60U, bench.process.epoch_ns + TAKEN_NS, bench_report(0U).time_ns);
    TEST_ASSERT_EQUAL_UINT32(1U, hk.counters.reports);
    pus_hk_count_lost(&hk, 2U);
    TEST_ASSERT_EQUAL_UINT32(2U, hk.counters.dropped);
    pus_hk_clear(&hk);
    run_loop(LOOP, 12U);
    TEST_ASSERT_EQUAL(1U, handed_count);
    hk.config.mutex = NULL;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(samples_are_spread_over_the_interval);
    RUN_TEST(missed_cycles_are_sampled_late_and_the_interval_is_kept);
    RUN_TEST(the_cycle_counter_may_wrap);
    RUN_TEST(all_samples_are_taken_if_they_do_not_divide_the_interval);
    RUN_TEST(a_refused_report_is_dropped_and_counted);
    RUN_TEST(bad_definitions_are_refused);
    RUN_TEST(samples_may_fill_their_buffer_to_the_last_octet);
    RUN_TEST(a_structure_is_created_reported_enabled_and_deleted);
    RUN_TEST(creation_is_refused_as_a_whole);
    RUN_TEST(structures_and_lists_beyond_the_capacity_are_refused);
    RUN_TEST(parameters_are_appended_to_their_sets);
    RUN_TEST(one_shot_reports_are_sent_to_the_requester_and_leave_periodic_ones_unchanged);
    RUN_TEST(intervals_are_modified_one_by_one);
    RUN_TEST(lists_of_255_are_served);
    RUN_TEST(enabling_twice_does_not_restart_the_interval);
    RUN_TEST(every_request_has_a_strict_format);
    RUN_TEST(another_loop_samples_its_own_parameters_and_passes_the_report_on);
    return UNITY_END();
}
