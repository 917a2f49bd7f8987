// SPDX-License-Identifier: Apache-2.0
// Which reports are forwarded to the ground, and the requests that change this selection. The macros take the
// octets of the application data. The numbers of requests and reports are subtypes;
// pus/catalogue/st14_forwarding.txt has their names and fields.
#include "pus/st14/st14_forwarding.h"

#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 12U
#define LARGE 1300U

static const uint16_t apids[] = {16U, 17U, 20U};

static pus_forwarding_t forwarding;
static pus_selection_entry_t entries[LARGE];
static pus_selection_entry_t candidate[LARGE];
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

static void start(const uint16_t capacity, const uint16_t apid_count)
{
    const pus_forwarding_config_t config = {.apids       = apids,
                                            .apid_count  = apid_count,
                                            .entries     = entries,
                                            .candidate   = candidate,
                                            .capacity    = capacity,
                                            .persistence = records_port()};
    memset(&forwarding, 0xA5, sizeof forwarding);
    pus_forwarding_init(&forwarding, &config);
    bench_serve(pus_forwarding_service(&forwarding));
}

void setUp(void)
{
    bench_start();
    records_start();
    start(CAPACITY, 3U);
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void tearDown(void)
{
}

/// Send a request with these octets of application data.
static status_t request(const uint8_t subtype, const uint8_t* const octets, const size_t size)
{
    bench_clear();
    return bench_request(subtype, octets, size);
}
#define REQUEST(subtype, ...)                                                                                \
    request(subtype, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))
#define PERFORMED(subtype, ...)                                                                              \
    do {                                                                                                     \
        TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(subtype, __VA_ARGS__));                                         \
        EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);                                                                   \
    } while (0)
/// Expect that report `index` has exactly these octets.
static void expect_data(const size_t index, const uint8_t* const octets, const size_t size)
{
    const pus_tm_t tm = bench_report(index);
    TEST_ASSERT_EQUAL_UINT64(size, tm.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, tm.data, size);
}
/// Expect that the request without data is answered with this content.
#define CONTENT(subtype, ...)                                                                                \
    do {                                                                                                     \
        TEST_ASSERT_EQUAL(STATUS_OK, request(subtype, NULL, 0U));                                            \
        EXPECT_MESSAGES(1, 1, 1, 3, 14, (subtype) + 1, 1, 7);                                                \
        expect_data(2U, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}));             \
    } while (0)

static bool allows(const uint16_t apid, const uint8_t service, const uint8_t subtype, const unsigned id)
{
    uint8_t source[2] = {(uint8_t)(id >> 8U), (uint8_t)id};
    const pus_tm_t tm = {.apid = apid, .service = service, .subtype = subtype, .data = source, .size = 2U};
    return pus_forwarding_allows(&forwarding, &tm);
}

static void at_first_all_reports_of_controlled_processes_are_forwarded(void)
{
    TEST_ASSERT_TRUE(allows(16U, 3U, 25U, 1U));
    TEST_ASSERT_TRUE(allows(17U, 3U, 26U, 2U));
    TEST_ASSERT_TRUE(allows(20U, 5U, 4U, 3U));
    TEST_ASSERT_TRUE(allows(20U, 1U, 1U, 0U));
    TEST_ASSERT_TRUE(allows(20U, 3U, 10U, 0U));
    TEST_ASSERT_FALSE(allows(18U, 1U, 1U, 0U));
    TEST_ASSERT_EQUAL_UINT32(5U, forwarding.counters.forwarded);
    TEST_ASSERT_EQUAL_UINT32(1U, forwarding.counters.held);
    CONTENT(3, 0, 3, 0, 16, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    CONTENT(7, 0, 3, 0, 16, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    CONTENT(11, 0, 3, 0, 16, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    CONTENT(15, 0, 0);
}

static void reports_are_classified_by_process_service_and_subtype(void)
{
    PERFORMED(2, 1, 0, 16, 0);
    TEST_ASSERT_FALSE(allows(16U, 1U, 1U, 0U));
    TEST_ASSERT_TRUE(allows(17U, 1U, 1U, 0U));
    PERFORMED(1, 1, 0, 16, 2, 1, 2, 8, 2, 17, 0);
    TEST_ASSERT_TRUE(allows(16U, 1U, 2U, 0U));
    TEST_ASSERT_TRUE(allows(16U, 1U, 8U, 0U));
    TEST_ASSERT_FALSE(allows(16U, 1U, 1U, 0U));
    TEST_ASSERT_TRUE(allows(16U, 17U, 2U, 0U));
    TEST_ASSERT_TRUE(allows(16U, 17U, 4U, 0U));
    TEST_ASSERT_FALSE(allows(16U, 3U, 10U, 0U));
    CONTENT(3, 0, 3, 0, 16, 0, 2, 1, 0, 2, 2, 8, 17, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    PERFORMED(1, 1, 0, 16, 1, 1, 0); // "All subtypes" replaces two entries.
    TEST_ASSERT_TRUE(allows(16U, 1U, 1U, 0U));
    CONTENT(3, 0, 3, 0, 16, 0, 2, 1, 0, 0, 17, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    PERFORMED(2, 1, 0, 16, 1, 1, 0);
    PERFORMED(1, 1, 0, 16, 1, 5, 1, 4);
    PERFORMED(2, 1, 0, 16, 1, 5, 1, 4);
    CONTENT(3, 0, 3, 0, 16, 0, 1, 17, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    PERFORMED(1, 1, 0, 16, 0); // "All services" replaces one entry.
    CONTENT(3, 0, 3, 0, 16, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0);
    PERFORMED(2, 0);
    CONTENT(3, 0, 0);
    PERFORMED(2, 0);
    TEST_ASSERT_FALSE(allows(17U, 1U, 1U, 0U));
    CONTENT(7, 0, 3, 0, 16, 0, 0, 0, 17, 0, 0, 0, 20, 0, 0); // The other lists are unchanged.
}

static void structures_are_subsampled(void)
{
    PERFORMED(6, 1, 0, 16, 0);
    TEST_ASSERT_FALSE(allows(16U, 3U, 25U, 1U));
    TEST_ASSERT_TRUE(allows(16U, 3U, 26U, 1U)); // Diagnostic structures are in another list.
    PERFORMED(5, 1, 0, 16, 2, 0, 1, 0, 1, 0, 2, 0, 3);
    for (unsigned i = 0U; i < 9U; i++) {
        TEST_ASSERT_TRUE(allows(16U, 3U, 25U, 1U));
        TEST_ASSERT_EQUAL((i % 3U) == 0U, allows(16U, 3U, 25U, 2U));
        TEST_ASSERT_FALSE(allows(16U, 3U, 25U, 3U));
    }
    CONTENT(7, 0, 3, 0, 16, 0, 2, 0, 1, 0, 1, 0, 2, 0, 3, 0, 17, 0, 0, 0, 20, 0, 0);
    PERFORMED(5, 1, 0, 16, 1, 0, 2, 0, 2); // A new rate, counted from the first report after the change.
    TEST_ASSERT_TRUE(allows(16U, 3U, 25U, 2U));
    TEST_ASSERT_FALSE(allows(16U, 3U, 25U, 2U));
    PERFORMED(6, 1, 0, 16, 1, 0, 1);
    TEST_ASSERT_FALSE(allows(16U, 3U, 25U, 1U));
    TEST_ASSERT_TRUE(allows(16U, 3U, 25U, 2U)); // Changes of other entries do not affect it.
    PERFORMED(10, 0);
    TEST_ASSERT_FALSE(allows(16U, 3U, 26U, 1U));
    PERFORMED(9, 1, 0, 20, 1, 0, 7, 255, 255);
    TEST_ASSERT_TRUE(allows(20U, 3U, 26U, 7U));
    TEST_ASSERT_FALSE(allows(20U, 3U, 26U, 7U));
    CONTENT(11, 0, 1, 0, 20, 0, 1, 0, 7, 255, 255);
    const pus_tm_t torn = {.apid = 20U, .service = 3U, .subtype = 25U, .data = data, .size = 1U};
    // A report of process 20 is forwarded even if it has no structure id.
    TEST_ASSERT_TRUE(pus_forwarding_allows(&forwarding, &torn));
}

static void reports_of_blocked_events_are_not_forwarded(void)
{
    PERFORMED(14, 2, 0, 16, 2, 0, 1, 0, 9, 0, 20, 0);
    TEST_ASSERT_FALSE(allows(16U, 5U, 1U, 1U));
    TEST_ASSERT_FALSE(allows(16U, 5U, 4U, 9U));
    TEST_ASSERT_TRUE(allows(16U, 5U, 4U, 8U));
    TEST_ASSERT_TRUE(allows(16U, 5U, 8U, 1U)); // The list of disabled events is not an event.
    TEST_ASSERT_TRUE(allows(16U, 6U, 4U, 1U));
    TEST_ASSERT_FALSE(allows(20U, 5U, 4U, 8U)); // All events of that process.
    CONTENT(15, 0, 2, 0, 16, 0, 2, 0, 1, 0, 9, 0, 20, 0, 0);
    PERFORMED(13, 2, 0, 16, 1, 0, 9, 0, 20, 0);
    TEST_ASSERT_TRUE(allows(16U, 5U, 4U, 9U));
    TEST_ASSERT_TRUE(allows(20U, 5U, 4U, 8U));
    PERFORMED(13, 0);
    TEST_ASSERT_TRUE(allows(16U, 5U, 1U, 1U));
}

static void each_instruction_is_refused_alone(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(1, 3, 0, 16, 0, 0, 17, 1, 3, 2, 25, 26, 0, 99, 1, 5, 0));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 1U, 0x100000U);
    expect_failure(2U, 4U, PUS_FAILURE_EXISTS, 2U, 0x110319U);
    expect_failure(3U, 4U, PUS_FAILURE_EXISTS, 3U, 0x11031AU);
    expect_failure(4U, 4U, PUS_FAILURE_UNKNOWN_ID, 4U, 0x630500U);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(2, 2, 0, 17, 1, 3, 1, 25, 0, 16, 0));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 0x110319U);
    expect_failure(3U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
    PERFORMED(1, 1, 0, 16, 1, 3, 0);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(1, 1, 0, 16, 4, 3, 1, 25, 0, 0, 9, 1, 0, 0, 1, 7));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 4);
    expect_failure(4U, 4U, PUS_FAILURE_OUT_OF_RANGE, 4U, 15U);
    expect_failure(1U, 4U, PUS_FAILURE_EXISTS, 1U, 0x100319U); // Included in "all of the service".
    expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 2U, 9U);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 12U);
    PERFORMED(6, 1, 0, 16, 0);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(5, 2, 0, 16, 1, 0, 4, 0, 0, 0, 17, 1, 0, 4, 0, 2));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 8U);
    expect_failure(2U, 4U, PUS_FAILURE_EXISTS, 2U, 0x110004U);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(14, 1, 255, 255, 0));
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(13, 1, 0, 16, 0));
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 0x100000U);
}

/// The list of controlled processes ends after the configured number of entries, no matter which octets
/// follow.
static void only_controlled_processes_are_selected(void)
{
    start(CAPACITY, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(1, 1, 0, 20, 0));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 0x140000U);
}

static void the_table_accepts_no_more_than_its_capacity(void)
{
    PERFORMED(14, 1, 0, 16, 3, 0, 1, 0, 2, 0, 3); // 9 + 3 of 12.
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(14, 1, 0, 16, 1, 0, 4));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 1U, CAPACITY);
    PERFORMED(14, 1, 0, 16, 0); // One replaces three.
    PERFORMED(14, 1, 0, 17, 2, 0, 1, 0, 2);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(14, 1, 0, 20, 0));
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 1U, CAPACITY);
    pus_selection_t small;
    pus_selection_init(&small, entries, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_selection_add_process(&small, 16U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_selection_add_process(&small, 17U));
    pus_selection_init(&small, entries, 6U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_selection_add_process(&small, 16U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_selection_add_process(&small, 16U)); // The process can still be added.
    TEST_ASSERT_EQUAL_UINT16(3U, small.count);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t types[]      = {1, 0, 16, 1, 3, 1, 25};
    static const uint8_t structures[] = {1, 0, 16, 1, 0, 25, 0, 1};
    static const uint8_t none[]       = {0};
    expect_strict_format(1U, types, sizeof types);
    expect_strict_format(5U, structures, sizeof structures);
    expect_strict_format(3U, NULL, 0U);
    for (uint8_t subtype = 1U; subtype <= 14U; subtype = (uint8_t)(subtype + 4U)) {
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_INVALID, // A count of 0 is valid only in deletions.
                          bench_request((subtype == 13U) ? 14U : subtype, none, sizeof none));
    }
}

/// Fill the table with entries of one list, and count the entries in the content reports.
static void large_contents_are_split(void)
{
    start(LARGE, 1U);
    PERFORMED(2, 0);
    PERFORMED(6, 0);
    PERFORMED(10, 0);
    for (unsigned round = 0U; round < 13U; round++) {
        writer = octet_writer(data, sizeof data);
        octet_write_u8(&writer, 1U);
        octet_write_u16(&writer, 16U);
        octet_write_u8(&writer, 100U);
        for (unsigned i = 0U; i < 100U; i++) {
            octet_write_u16(&writer, (uint16_t)((round * 100U) + i));
            octet_write_u16(&writer, 1U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, request(5U, data, writer.position));
        EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(5, 1, 0, 16, 1, 9, 9, 0, 1));
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 1U, LARGE);
    TEST_ASSERT_EQUAL(STATUS_OK, request(7U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 14, 8, 14, 8, 1, 7);
    uint16_t next = 0U;
    for (size_t i = 2U; i < 4U; i++) {
        octet_reader_t reader = bench_data(i);
        TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(16U, octet_read_u16(&reader));
        for (uint16_t count = octet_read_u16(&reader); count > 0U; count--) {
            TEST_ASSERT_EQUAL_UINT16(next, octet_read_u16(&reader));
            TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
            next++;
        }
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
    TEST_ASSERT_EQUAL_UINT16(LARGE, next);
}

static void all_types_of_five_services_fit_one_report(void)
{
    start(LARGE, 1U);
    PERFORMED(2, 0);
    for (unsigned service = 1U; service <= 5U; service++) {
        writer = octet_writer(data, sizeof data);
        octet_write_u8(&writer, 1U);
        octet_write_u16(&writer, 16U);
        octet_write_u8(&writer, 1U);
        octet_write_u8(&writer, (uint8_t)service);
        octet_write_u8(&writer, 255U);
        for (unsigned i = 1U; i <= 255U; i++) {
            octet_write_u8(&writer, (uint8_t)i);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, request(1U, data, writer.position));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, request(3U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 14, 4, 1, 7); // A little more than 1275 octets.
    TEST_ASSERT_EQUAL_UINT64(2U + 4U + (5U * (3U + 255U)), bench_report(2U).size);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_forwarding_restore(self, key, octets, size);
}

static void the_configuration_outlives_a_power_cut(void)
{
    PERFORMED(6, 1, 0, 16, 0);
    PERFORMED(5, 1, 0, 16, 1, 0, 2, 0, 3);
    PERFORMED(2, 1, 0, 17, 0);
    TEST_ASSERT_EQUAL_UINT32(3U, records.commits);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(13, 1, 0, 16, 0));
    TEST_ASSERT_EQUAL_UINT32(3U, records.puts); // A request that changes nothing writes no record.
    records_cut();
    start(CAPACITY, 3U);
    TEST_ASSERT_EQUAL_UINT64(1U, records_replay(14U, restore, &forwarding));
    CONTENT(3, 0, 2, 0, 16, 0, 0, 0, 20, 0, 0);
    CONTENT(7, 0, 3, 0, 16, 0, 1, 0, 2, 0, 3, 0, 17, 0, 0, 0, 20, 0, 0);
}

static void a_change_that_cannot_be_stored_is_not_made(void)
{
    records.put_status = STATUS_FULL;
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(2, 1, 0, 16, 0));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(2, 0)); // The whole list.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    TEST_ASSERT_TRUE(allows(16U, 1U, 1U, 0U));
    records.put_status    = STATUS_OK;
    records.commit_status = STATUS_IO;
    TEST_ASSERT_EQUAL(STATUS_OK, REQUEST(2, 1, 0, 16, 0));
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
}

static void without_persistence_no_definition_is_stored(void)
{
    const pus_forwarding_config_t config = {
        .apids = apids, .apid_count = 3U, .entries = entries, .candidate = candidate, .capacity = CAPACITY};
    memset(&forwarding, 0xA5, sizeof forwarding);
    pus_forwarding_init(&forwarding, &config);
    PERFORMED(2, 0);
    TEST_ASSERT_EQUAL_UINT32(0U, records.puts);
    TEST_ASSERT_FALSE(allows(16U, 1U, 1U, 0U));
}

static void bad_records_are_refused(void)
{
    static const struct {
        status_t status;
        uint8_t size;
        uint8_t octets[16];
    } cases[] = {
        {STATUS_INVALID, 0, {0}},
        {STATUS_INVALID, 1, {0}},
        {STATUS_INVALID, 3, {0, 0, 0}},                   // More entries than stated.
        {STATUS_INVALID, 8, {0, 2, 0, 0x20, 0, 0, 0, 1}}, // Fewer entries than stated.
        {STATUS_INVALID, 8, {0, 1, 0, 0x20, 0, 0, 0, 0}}, // Rate 0.
        // An identifier in an entry that has none.
        {STATUS_INVALID, 8, {0, 1, 0, 0x20, 0, 1, 0, 1}},
        {STATUS_INVALID, 8, {0, 1, 0x40, 0x20, 0, 0, 0, 1}},                    // A list that does not exist.
        {STATUS_INVALID, 14, {0, 2, 0, 0x20, 0, 0, 0, 1, 0, 0x20, 0, 0, 0, 1}}, // The same entry twice.
        {STATUS_OK, 14, {0, 2, 0, 0x20, 0, 0, 0, 1, 0, 0x23, 0, 1, 0, 1}},
        {STATUS_OK, 2, {0, 0}},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(cases[i].status,
                          pus_forwarding_restore(&forwarding, 0U, cases[i].octets, cases[i].size));
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_forwarding_restore(&forwarding, 1U, cases[9].octets, 2U));
    writer = octet_writer(data, sizeof data);
    octet_write_u16(&writer, CAPACITY + 1U);
    for (unsigned i = 0U; i <= CAPACITY; i++) {
        octet_write_u32(&writer, 0x210000U + i);
        octet_write_u16(&writer, 1U);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_forwarding_restore(&forwarding, 0U, data, writer.position));
}

static void start_without_capacity(void)
{
    pus_selection_t selection;
    pus_selection_init(&selection, entries, 0U);
}

static void start_with_too_much(void)
{
    pus_selection_t selection;
    pus_selection_init(&selection, entries, PUS_SELECTION_ENTRIES_MAX + 1U);
}

static void start_without_room_for_all(void)
{
    start(8U, 3U);
}

static void calls_against_the_contract_are_asserted(void)
{
    TEST_ASSERT_TRUE(assertion_fails(start_without_capacity));
    TEST_ASSERT_TRUE(assertion_fails(start_with_too_much));
    TEST_ASSERT_TRUE(assertion_fails(start_without_room_for_all));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(at_first_all_reports_of_controlled_processes_are_forwarded);
    RUN_TEST(reports_are_classified_by_process_service_and_subtype);
    RUN_TEST(structures_are_subsampled);
    RUN_TEST(reports_of_blocked_events_are_not_forwarded);
    RUN_TEST(each_instruction_is_refused_alone);
    RUN_TEST(only_controlled_processes_are_selected);
    RUN_TEST(the_table_accepts_no_more_than_its_capacity);
    RUN_TEST(every_request_has_a_strict_format);
    RUN_TEST(large_contents_are_split);
    RUN_TEST(all_types_of_five_services_fit_one_report);
    RUN_TEST(the_configuration_outlives_a_power_cut);
    RUN_TEST(a_change_that_cannot_be_stored_is_not_made);
    RUN_TEST(without_persistence_no_definition_is_stored);
    RUN_TEST(bad_records_are_refused);
    RUN_TEST(calls_against_the_contract_are_asserted);
    return UNITY_END();
}
