// SPDX-License-Identifier: Apache-2.0
// Diagnostic structures, and functional reporting definitions with both kinds of structures. The numbers of
// requests and reports are subtypes; pus/catalogue/st03_housekeeping.txt has their names and fields.
#include "test/unit/pus/fixtures/parameters.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"

#include "pus/st03/st03_housekeeping.h"
#include "unity.h"

#include <string.h>

#define STRUCTURES 4U
#define DEFINITIONS 2U
#define SAMPLE_SIZE 64U

static pus_hk_t hk;
static pus_hk_structure_t structures[STRUCTURES + 1U];    // The last one does not belong to the service.
static pus_hk_functional_t definitions[DEFINITIONS + 1U]; // Likewise.
static uint8_t samples[STRUCTURES * SAMPLE_SIZE];
static uint32_t cycle;
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

static void start(const pus_persistence_t* const persistence)
{
    const pus_hk_config_t config = {.process          = &bench.process,
                                    .parameters       = dictionary_port(),
                                    .structures       = structures,
                                    .structure_count  = STRUCTURES,
                                    .samples          = samples,
                                    .sample_size      = SAMPLE_SIZE,
                                    .functional       = definitions,
                                    .functional_count = DEFINITIONS,
                                    .persistence      = persistence};
    bench_start();
    memset(structures, 0xA5, sizeof structures);
    memset(definitions, 0xA5, sizeof definitions);
    memset(&hk, 0xA5, sizeof hk);
    pus_hk_init(&hk, &config);
    bench_serve(pus_hk_service(&hk));
    if (persistence != NULL) {
        pus_dispatcher_persist(&bench.dispatcher, persistence);
    }
}

static void add(const uint16_t id, const bool is_diagnostic, const bool is_periodic)
{
    static const uint32_t once[]         = {P_U8};
    static const uint32_t twice[]        = {P_U16};
    const pus_hk_set_definition_t sets[] = {{2U, 1U, twice}};
    const pus_hk_definition_t definition = {.id              = id,
                                            .is_diagnostic   = is_diagnostic,
                                            .interval        = 4U,
                                            .is_periodic     = is_periodic,
                                            .parameter_count = 1U,
                                            .set_count       = 1U,
                                            .parameters      = once,
                                            .sets            = sets};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
}

void setUp(void)
{
    records_start();
    cycle = 0U;
    start(records_port());
    add(5U, false, false);
    add(5U, true, false); // A diagnostic structure with the same id.
    add(6U, true, true);
}

void tearDown(void)
{
}

static void run(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        cycle++;
        bench_step(TEST_NOW_NS, cycle);
    }
}

static void begin(void)
{
    writer = octet_writer(data, sizeof data);
}

static void u8(const unsigned value)
{
    octet_write_u8(&writer, (uint8_t)value);
}

static void u16(const unsigned value)
{
    octet_write_u16(&writer, (uint16_t)value);
}

static void request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, writer.position));
}

static void list(const unsigned count, const unsigned first)
{
    begin();
    u8(count);
    for (unsigned i = 0U; i < count; i++) {
        u16(first + i);
    }
}

static void diagnostic_structures_have_identifiers_of_their_own(void)
{
    static const uint8_t created[] = {0, 7, 0, 0, 0, 3, 1, 2, 0, 0, 1, 0};
    TEST_ASSERT_TRUE(P_U8 == (((uint32_t)TEST_APID << 21U) | 1U));
    run(4U);
    EXPECT_MESSAGES(3, 26); // The report of structure 6.
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(2U, created, sizeof created));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    list(1U, 7U);
    request(9U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 7U);
    request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 12, 1, 7);
    request(7U);
    run(3U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7, 3, 26);
    request(8U);
    request(28U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 26, 1, 7);
    request(34U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 36, 1, 7);
    begin();
    u8(1U);
    u16(7U);
    octet_write_u32(&writer, 9U);
    request(32U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    begin();
    u16(7U);
    u8(1U);
    octet_write_u32(&writer, P_U16);
    u8(0U);
    request(30U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    list(1U, 7U);
    request(4U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    request(4U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 7U);
    list(1U, 5U);
    request(3U); // The housekeeping structure with the same id remains.
    request(11U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 12, 1, 7);
}

/// Begin a request about a definition with `count` entries of one APID.
static void begin_entries(const unsigned id, const unsigned count)
{
    begin();
    u16(id);
    u8(1U);
    u16(TEST_APID);
    u8(count);
}

static void entry(const unsigned type, const unsigned id, const unsigned status, const uint32_t interval)
{
    u8(type);
    u16(id);
    u8(status);
    octet_write_u32(&writer, interval);
}

static void create(const unsigned id)
{
    begin_entries(id, 2U);
    entry(25U, 5U, 1U, 2U);
    entry(26U, 6U, 0U, 8U);
    request(38U);
}

/// Apply one definition.
static void apply(const unsigned exclusive, const unsigned id)
{
    begin();
    u8(exclusive);
    u8(1U);
    u16(id);
    request(37U);
}

static void definitions_are_created_and_reported(void)
{
    // Definition 40: APID 16 with two structures: type, id, enabled, interval (u32).
    static const uint8_t expected[] = {0, 40, 0, 1, 0,  16, 0, 2, 25, 0, 5, 1,
                                       0, 0,  0, 2, 26, 0,  6, 0, 0,  0, 0, 8};
    create(40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(38U, data, writer.position);
    list(2U, 40U);
    request(40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 41, 1, 4, 1, 8);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, 41U);
    create(40U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, 40U);
    create(41U);
    create(42U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, DEFINITIONS);
    list(2U, 41U);
    request(39U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    create(42U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void one_faulty_entry_refuses_the_request(void)
{
    static const struct {
        uint8_t type;
        uint8_t status;
        uint32_t interval;
    } cases[] = {{24U, 1U, 1U}, {27U, 1U, 1U}, {25U, 2U, 1U}, {26U, 0U, 0U}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        begin_entries(40U, 2U);
        entry(25U, 5U, 1U, 1U);
        entry(cases[i].type, 6U, cases[i].status, cases[i].interval);
        request(38U);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 14U);
    }
    begin();
    u16(40U);
    u8(1U);
    u16(TEST_APID + 1U);
    u8(1U);
    entry(25U, 5U, 1U, 1U);
    request(38U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, TEST_APID + 1U);
    begin_entries(40U, 2U);
    entry(25U, 5U, 1U, 1U);
    entry(25U, 5U, 0U, 1U);
    request(38U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, 5U);
    begin_entries(40U, PUS_HK_MEMBERS_MAX + 1U);
    for (unsigned i = 0U; i <= PUS_HK_MEMBERS_MAX; i++) {
        entry(25U, 100U + i, 1U, 1U);
    }
    request(38U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, PUS_HK_MEMBERS_MAX);
    apply(0U, 40U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 40U); // No definition was created.
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void applied_definitions_switch_their_structures(void)
{
    create(40U);
    apply(0U, 40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    run(8U);
    // The reports come every 2 cycles; diagnostic structure 6 is disabled.
    EXPECT_MESSAGES(3, 25, 3, 25, 3, 25, 3, 25);
    apply(2U, 40U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    begin_entries(41U, 1U);
    entry(26U, 6U, 1U, 4U);
    request(38U);
    begin();
    u8(1U); // The definition is exclusive, so structure 5 ends.
    u8(2U);
    u16(99U);
    u16(41U);
    request(37U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
    bench_clear();
    run(8U);
    EXPECT_MESSAGES(3, 26, 3, 26);
    apply(0U, 41U); // A structure that already has the required state continues.
    run(3U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    run(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7, 3, 26);
}

static void structures_that_cannot_be_switched_are_counted(void)
{
    begin_entries(40U, 3U);
    entry(25U, 77U, 1U, 1U);
    entry(25U, 5U, 1U, 1U); // Structure 5 has sets of two samples.
    entry(26U, 6U, 0U, 2U);
    request(38U);
    apply(0U, 40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    bench_clear();
    run(8U);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
}

static void definitions_are_changed_entry_by_entry(void)
{
    create(40U);
    begin_entries(40U, 1U);
    entry(26U, 5U, 1U, 6U);
    request(42U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(42U, data, writer.position);
    request(42U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 0U, 5U);
    begin_entries(40U, 1U);
    entry(25U, 5U, 0U, 3U);
    request(44U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    begin_entries(40U, 1U);
    entry(25U, 99U, 0U, 3U);
    request(44U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 99U);
    begin_entries(40U, 2U);
    u8(26U);
    u16(6U);
    u8(26U);
    u16(7U);
    request(43U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 7U);
    begin_entries(40U, 1U);
    u8(26U);
    u16(6U);
    request(43U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(43U, data, writer.position);
    // As above, with the new values.
    static const uint8_t expected[] = {0, 40, 0, 1, 0,  16, 0, 2, 25, 0, 5, 0,
                                       0, 0,  0, 3, 26, 0,  5, 1, 0,  0, 0, 6};
    list(1U, 40U);
    request(40U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    begin_entries(40U, 2U);
    u8(25U);
    u16(5U);
    u8(26U);
    u16(5U);
    request(43U);
    list(1U, 40U);
    request(40U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0, 40, 0, 0}), bench_report(2U).data, 4U);
    begin_entries(41U, 1U);
    entry(26U, 5U, 1U, 6U);
    request(42U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, 41U);
}

static void definitions_outlive_a_power_cut(void)
{
    create(40U);
    create(41U);
    list(1U, 41U);
    request(39U);
    records_cut();
    start(records_port());
    TEST_ASSERT_EQUAL_UINT64(1U, records_replay(PUS_SERVICE_HOUSEKEEPING, pus_hk_restore, &hk));
    // The record replaces the definition.
    TEST_ASSERT_EQUAL_UINT64(1U, records_replay(PUS_SERVICE_HOUSEKEEPING, pus_hk_restore, &hk));
    list(1U, 40U);
    request(40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 3, 41, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(24U, bench_report(2U).size);
}

static void bad_records_are_refused(void)
{
    // A record has the number of entries, and for each entry type (25 or 26), id, enabled and interval.
    static const uint8_t odd[]  = {1, 24, 0, 1, 0, 0, 0, 0, 1};
    static const uint8_t good[] = {1, 25, 0, 1, 0, 0, 0, 0, 1};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_restore(&hk, 1U, odd, sizeof odd));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_restore(&hk, 1U, good, sizeof good - 1U));
    static const uint8_t longer[] = {1, 25, 0, 1, 0, 0, 0, 0, 1, 0};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_restore(&hk, 1U, longer, sizeof longer));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_restore(&hk, 0x10000U, good, sizeof good));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_restore(&hk, 1U, (const uint8_t*)"\41", 1U)); // 33 entries.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_restore(&hk, 1U, good, sizeof good));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_restore(&hk, 2U, good, sizeof good));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_hk_restore(&hk, 3U, good, sizeof good));
}

static void a_change_that_cannot_be_stored_is_not_made(void)
{
    records.put_status = STATUS_FULL;
    create(40U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    apply(0U, 40U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 40U);
    records.put_status = STATUS_OK;
    create(40U);
    records.erase_status = STATUS_IO;
    list(1U, 40U);
    request(39U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    start(NULL); // There is no store of records.
    create(40U);
    list(1U, 40U);
    request(39U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void an_empty_set_of_parameters_is_refused(void)
{
    static const uint32_t once[]         = {P_U8};
    const pus_hk_set_definition_t sets[] = {{2U, 0U, once}};
    const pus_hk_definition_t definition = {
        .id = 9U, .interval = 4U, .parameter_count = 1U, .set_count = 1U, .parameters = once, .sets = sets};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_hk_add(&hk, &definition));
}

/// A request unlocks the mutex whether it is performed or refused.
static void each_request_unlocks_the_mutex(void)
{
    static const struct {
        uint8_t subtype;
        size_t size;
        uint8_t data[8];
    } requests[]                         = {{5U, 3U, {1, 0, 99}},  {3U, 3U, {1, 0, 99}}, {6U, 3U, {1, 0, 99}},
                                            {27U, 3U, {1, 0, 99}}, {9U, 3U, {1, 0, 99}}, {31U, 7U, {1, 0, 99, 0, 0, 0, 9}},
                                            {3U, 3U, {1, 0, 99}},  {3U, 3U, {1, 0, 99}}};
    static const uint32_t simple[]       = {P_U16};
    const pus_hk_definition_t definition = {
        .id = 99U, .interval = 6U, .parameter_count = 1U, .parameters = simple};
    static osal_mutex_t mutex;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&mutex, false));
    hk.config.mutex = &mutex;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_hk_add(&hk, &definition));
    TEST_ASSERT_EQUAL_INT32(0, osal_mutex_holder(&mutex));
    for (size_t i = 0U; i < (sizeof requests / sizeof requests[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(requests[i].subtype, requests[i].data, requests[i].size));
        TEST_ASSERT_EQUAL_INT32(0, osal_mutex_holder(&mutex));
    }
    hk.config.mutex = NULL;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(diagnostic_structures_have_identifiers_of_their_own);
    RUN_TEST(definitions_are_created_and_reported);
    RUN_TEST(one_faulty_entry_refuses_the_request);
    RUN_TEST(applied_definitions_switch_their_structures);
    RUN_TEST(structures_that_cannot_be_switched_are_counted);
    RUN_TEST(definitions_are_changed_entry_by_entry);
    RUN_TEST(definitions_outlive_a_power_cut);
    RUN_TEST(bad_records_are_refused);
    RUN_TEST(an_empty_set_of_parameters_is_refused);
    RUN_TEST(a_change_that_cannot_be_stored_is_not_made);
    RUN_TEST(each_request_unlocks_the_mutex);
    return UNITY_END();
}
