// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/telemetry_cache.h"

#include "unity.h"

#include <string.h>

// Parameter ids: APID, layout (0 UINT8, 1 UINT16, 2 UINT32, 24 struct, 25 array), number.
#define ID(apid, layout, number) (((uint32_t)(apid) << 21U) | ((uint32_t)(layout) << 16U) | (number))
#define OCTET ID(16U, 0U, 1U)
#define WORD ID(16U, 1U, 2U)
#define LONG ID(16U, 2U, 3U)
#define STRUCT ID(16U, 24U, 4U) ///< Three octets.
#define UNKNOWN ID(16U, 25U, 5U)
#define EPOCH 1000U

static telemetry_cache_t cache;
static uint8_t data[PUS_TM_DATA_MAX];
static octet_writer_t writer;

static status_t size_of(void* const context, const uint32_t id, uint16_t* const out_size)
{
    TEST_ASSERT_NULL(context);
    *out_size = 3U;
    return (id == STRUCT) ? STATUS_OK : STATUS_NOT_FOUND;
}

void setUp(void)
{
    const telemetry_cache_sizes_t sizes = {.size_of = size_of};
    supervisor_telemetry_cache_init(&cache, &sizes);
    writer = octet_writer(data, sizeof data);
}

void tearDown(void)
{
}

/// Pass the written octets as a report, and begin a new report.
static void observe(const uint8_t service, const uint8_t subtype, const uint64_t time_ns)
{
    const pus_tm_t tm = {.apid    = 16U,
                         .service = service,
                         .subtype = subtype,
                         .time_ns = time_ns,
                         .data    = data,
                         .size    = writer.position};
    TEST_ASSERT_FALSE(writer.failed);
    supervisor_telemetry_cache_observe(&cache, &tm);
    writer = octet_writer(data, sizeof data);
}

/// Define structure 7 by TM[3,10] or TM[3,12]: OCTET, STRUCT, three samples of {WORD, OCTET}, and two samples
/// of LONG.
static void define(const uint8_t subtype)
{
    octet_write_u16(&writer, 7U);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, 100U);
    octet_write_u16(&writer, 2U);
    octet_write_u32(&writer, OCTET);
    octet_write_u32(&writer, STRUCT);
    octet_write_u16(&writer, 2U);
    octet_write_u16(&writer, 3U);
    octet_write_u16(&writer, 2U);
    octet_write_u32(&writer, WORD);
    octet_write_u32(&writer, OCTET);
    octet_write_u16(&writer, 1U);
    octet_write_u16(&writer, 1U);
    octet_write_u32(&writer, LONG);
    observe(3U, subtype, EPOCH);
}

/// Report this structure by TM[3,25] or TM[3,26] with `size` octets: `first`, `first` + 1, ...
static void report(const uint8_t subtype, const uint8_t first, const size_t size, const uint64_t time_ns)
{
    octet_write_u16(&writer, 7U);
    for (size_t i = 0U; i < size; i++) {
        octet_write_u8(&writer, (uint8_t)(first + i));
    }
    observe(3U, subtype, time_ns);
}

static void expect_value(const uint32_t id, const uint64_t time_ns, const uint8_t* const octets,
                         const size_t size)
{
    const pus_parameter_port_t port = supervisor_telemetry_cache_port(&cache);
    uint8_t found[16];
    octet_writer_t out     = octet_writer(found, sizeof found);
    uint16_t handle        = 0U;
    uint16_t found_size    = 0U;
    const uint8_t* present = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, port.find(port.context, id, &handle, &found_size));
    TEST_ASSERT_EQUAL_UINT16(size, found_size);
    port.read(port.context, handle, &out);
    TEST_ASSERT_EQUAL_UINT64(size, out.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, found, size);
    TEST_ASSERT_EQUAL((time_ns == 0U) ? STATUS_EMPTY : STATUS_OK,
                      supervisor_telemetry_cache_value(&cache, id, &present, &found_size));
    TEST_ASSERT_EQUAL_UINT64(time_ns, cache.values[handle].taken_ns);
    TEST_ASSERT_EQUAL_UINT16(size, found_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, present, size);
}
#define EXPECT(id, time_ns, ...)                                                                             \
    expect_value(id, time_ns, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

static void values_of_structures_are_kept(void)
{
    report(25U, 1U, 17U, EPOCH); // The structure is not defined yet.
    TEST_ASSERT_EQUAL_UINT32(0U, cache.counters.taken);
    define(10U);
    EXPECT(WORD, 0U, 0, 0);
    report(25U, 1U, 17U, 2000U);
    EXPECT(OCTET, 2000U, 13); // The last sample of the set.
    EXPECT(STRUCT, 2000U, 2, 3, 4);
    EXPECT(WORD, 2000U, 11, 12);
    EXPECT(LONG, 2000U, 14, 15, 16, 17);
    report(25U, 101U, 17U, 3000U);
    EXPECT(LONG, 3000U, 114, 115, 116, 117);
    report(26U, 1U, 17U, 4000U); // Diagnostic structures have ids of their own.
    EXPECT(LONG, 3000U, 114, 115, 116, 117);
    define(12U);
    report(26U, 1U, 17U, 4000U);
    EXPECT(LONG, 4000U, 14, 15, 16, 17);
    TEST_ASSERT_EQUAL_UINT32(0U, cache.counters.unfitting);
}

static void reports_that_do_not_match_their_structure_are_ignored(void)
{
    define(10U);
    report(25U, 1U, 17U, 2000U);
    report(25U, 50U, 16U, 3000U);
    report(25U, 50U, 18U, 3000U);
    EXPECT(WORD, 2000U, 11, 12);
    TEST_ASSERT_EQUAL_UINT32(2U, cache.counters.unfitting);
    octet_write_u8(&writer, 7U);
    observe(3U, 25U, 3000U); // Too short for an id: it belongs to no structure.
    octet_write_u16(&writer, 1U);
    observe(3U, 35U, 3000U);
    observe(17U, 2U, 3000U);
    observe(20U, 7U, 3000U);
    TEST_ASSERT_EQUAL_UINT32(2U, cache.counters.unfitting);
}

static void a_definition_replaces_the_previous_one(void)
{
    define(10U);
    define(12U);
    octet_write_u16(&writer, 7U);
    octet_write_u8(&writer, 0U);
    octet_write_u32(&writer, 5U);
    octet_write_u16(&writer, 1U);
    octet_write_u32(&writer, WORD);
    octet_write_u16(&writer, 0U);
    observe(3U, 10U, EPOCH);
    TEST_ASSERT_EQUAL_UINT16(2U, cache.structure_count);
    report(25U, 1U, 2U, 2000U);
    EXPECT(WORD, 2000U, 1, 2);
    report(26U, 1U, 17U, 3000U); // The diagnostic structure is complete.
    EXPECT(LONG, 3000U, 14, 15, 16, 17);
    TEST_ASSERT_EQUAL_UINT32(0U, cache.counters.unfitting);
}

static void bad_definitions_remove_the_structure(void)
{
    define(10U);
    memset(data, 0, sizeof data);
    define(10U);
    const uint16_t whole = cache.entry_count;
    octet_reader_t reader;
    for (size_t size = 0U; size < 34U; size++) { // Truncated at each length.
        uint8_t octets[34];
        writer = octet_writer(octets, sizeof octets);
        octet_write_u16(&writer, 1U);
        octet_write_u32(&writer, OCTET);
        octet_write_u16(&writer, 2U);
        octet_write_u16(&writer, 2U);
        octet_write_u16(&writer, 2U);
        octet_write_u32(&writer, WORD);
        octet_write_u32(&writer, LONG);
        octet_write_u16(&writer, 1U);
        octet_write_u16(&writer, 1U);
        octet_write_u32(&writer, LONG);
        octet_write_u16(&writer, 0U);
        octet_write_u32(&writer, 0U);
        reader = octet_reader(octets, size);
        TEST_ASSERT_EQUAL((size == 28U) ? STATUS_OK : STATUS_INVALID,
                          supervisor_telemetry_cache_define(&cache, 16U, 25U, 8U, &reader));
    }
    TEST_ASSERT_EQUAL_UINT16(whole, cache.entry_count);      // Bad definitions have removed the correct one.
    static const uint8_t never[] = {0, 0, 0, 1, 0, 0, 0, 0}; // A set without samples.
    reader                       = octet_reader(never, sizeof never);
    TEST_ASSERT_EQUAL(STATUS_INVALID, supervisor_telemetry_cache_define(&cache, 16U, 25U, 8U, &reader));
    writer = octet_writer(data, sizeof data);
    octet_write_u16(&writer, 1U);
    octet_write_u32(&writer, UNKNOWN);
    octet_write_u16(&writer, 0U);
    reader = octet_reader(data, writer.position);
    TEST_ASSERT_EQUAL(STATUS_INVALID, supervisor_telemetry_cache_define(&cache, 16U, 25U, 8U, &reader));
    writer = octet_writer(data, sizeof data);
    octet_write_u16(&writer, 9U);
    observe(3U, 10U, EPOCH);
    TEST_ASSERT_EQUAL_UINT32(1U, cache.counters.unfitting);
}

static void reported_values_are_kept(void)
{
    octet_write_u16(&writer, 3U);
    octet_write_u32(&writer, WORD);
    octet_write_u16(&writer, 0x1234U);
    octet_write_u32(&writer, STRUCT);
    octet_write_octets(&writer, (const uint8_t*)"abc", 3U);
    octet_write_u32(&writer, OCTET);
    octet_write_u8(&writer, 9U);
    observe(20U, 2U, 5000U);
    EXPECT(WORD, 5000U, 0x12, 0x34);
    EXPECT(STRUCT, 5000U, 'a', 'b', 'c');
    EXPECT(OCTET, 5000U, 9);
    octet_write_u16(&writer, 3U);
    octet_write_u32(&writer, OCTET);
    octet_write_u8(&writer, 10U);
    octet_write_u32(&writer, UNKNOWN);
    octet_write_u32(&writer, 0U);
    octet_write_u32(&writer, WORD);
    octet_write_u16(&writer, 1U);
    observe(20U, 2U, 6000U);
    EXPECT(OCTET, 6000U, 10);
    EXPECT(WORD, 5000U, 0x12, 0x34);
    octet_write_u16(&writer, 2U);
    octet_write_u32(&writer, WORD);
    octet_write_u8(&writer, 1U);
    observe(20U, 2U, 7000U); // A truncated report.
    octet_write_u16(&writer, 1U);
    octet_write_u16(&writer, 0U);
    observe(20U, 2U, 7000U);
    EXPECT(WORD, 5000U, 0x12, 0x34);
    TEST_ASSERT_EQUAL_UINT32(3U, cache.counters.unfitting);
}

static void a_parameter_without_value_or_size_is_not_found(void)
{
    const pus_parameter_port_t port = supervisor_telemetry_cache_port(&cache);
    uint16_t handle                 = 0U;
    uint16_t size                   = 0U;
    const uint8_t* octets           = NULL;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, supervisor_telemetry_cache_value(&cache, WORD, &octets, &size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, port.find(port.context, UNKNOWN, &handle, &size));
    TEST_ASSERT_NULL(port.write);
    cache.sizes.size_of = NULL;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, port.find(port.context, STRUCT, &handle, &size));
}

static void tables_of_the_cache_are_bounded(void)
{
    const pus_parameter_port_t port = supervisor_telemetry_cache_port(&cache);
    uint16_t handle                 = 0U;
    uint16_t size                   = 0U;
    octet_reader_t reader;
    for (uint32_t i = 0U; i < TELEMETRY_CACHE_PARAMETERS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, port.find(port.context, ID(16U + (i % 3U), 0U, i), &handle, &size));
        TEST_ASSERT_EQUAL_UINT16(i, handle);
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, port.find(port.context, ID(16U, 0U, 9000U), &handle, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, port.find(port.context, ID(17U, 0U, 1U), &handle, &size));
    TEST_ASSERT_EQUAL_UINT16(1U, handle);
    TEST_ASSERT_EQUAL_UINT32(1U, cache.counters.full);
    octet_write_u16(&writer, 1000U); // Eight structures fill the entries.
    for (uint32_t i = 0U; i < 1000U; i++) {
        octet_write_u32(&writer, ID(17U, 0U, 1U));
    }
    octet_write_u16(&writer, 0U);
    for (uint16_t id = 0U; id < 9U; id++) {
        reader = octet_reader(data, writer.position);
        TEST_ASSERT_EQUAL(
            (id < 8U) ? STATUS_OK : STATUS_EXHAUSTED,
            supervisor_telemetry_cache_define(&cache, (uint16_t)(16U + (id % 2U)), 25U, id, &reader));
    }
    static const uint8_t none[] = {0, 0, 0, 0};
    for (uint16_t id = 8U; id <= TELEMETRY_CACHE_STRUCTURES; id++) {
        reader = octet_reader(none, sizeof none);
        TEST_ASSERT_EQUAL((id < TELEMETRY_CACHE_STRUCTURES) ? STATUS_OK : STATUS_EXHAUSTED,
                          supervisor_telemetry_cache_define(&cache, 16U, 25U, id, &reader));
    }
}

static status_t large(void* const context, const uint32_t id, uint16_t* const out_size)
{
    (void)context;
    (void)id;
    *out_size = 40000U;
    return STATUS_OK;
}

static void the_octets_of_the_cache_are_bounded(void)
{
    const pus_parameter_port_t port = supervisor_telemetry_cache_port(&cache);
    uint16_t handle                 = 0U;
    uint16_t size                   = 0U;
    cache.sizes.size_of             = large;
    TEST_ASSERT_EQUAL(STATUS_OK, port.find(port.context, STRUCT, &handle, &size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, port.find(port.context, UNKNOWN, &handle, &size));
    octet_write_u16(&writer, 1U);
    octet_write_u32(&writer, UNKNOWN);
    octet_write_u16(&writer, 0U);
    octet_reader_t reader = octet_reader(data, writer.position);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, supervisor_telemetry_cache_define(&cache, 16U, 25U, 1U, &reader));
    TEST_ASSERT_EQUAL_UINT32(2U, cache.counters.full);
}

static void a_value_that_is_no_longer_reported_is_old(void)
{
    const uint64_t start_ns = 2U * TELEMETRY_CACHE_AGE_MIN_NS;
    const uint64_t each_ns  = TELEMETRY_CACHE_AGE_MIN_NS;
    const uint64_t last_ns  = start_ns + each_ns;
    const uint64_t limit_ns = last_ns + (TELEMETRY_CACHE_INTERVALS * (each_ns + 1U));
    // The parameter is unknown.
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, UINT64_MAX));
    define(10U);
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, UINT64_MAX)); // Not reported yet.
    report(25U, 1U, 17U, start_ns);
    // A single report has no interval.
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, UINT64_MAX));
    report(25U, 1U, 17U, last_ns);
    // The value is not old at the time of its report or earlier.
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, last_ns));
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, 0U));
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, last_ns + TELEMETRY_CACHE_AGE_MIN_NS));
    TEST_ASSERT_FALSE(
        supervisor_telemetry_cache_is_old(&cache, OCTET, last_ns + TELEMETRY_CACHE_AGE_MIN_NS + 1U));
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, limit_ns - 1U));
    TEST_ASSERT_TRUE(supervisor_telemetry_cache_is_old(&cache, OCTET, limit_ns));
    report(25U, 1U, 17U, limit_ns);
    TEST_ASSERT_FALSE(supervisor_telemetry_cache_is_old(&cache, OCTET, limit_ns));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_of_structures_are_kept);
    RUN_TEST(reports_that_do_not_match_their_structure_are_ignored);
    RUN_TEST(a_definition_replaces_the_previous_one);
    RUN_TEST(bad_definitions_remove_the_structure);
    RUN_TEST(reported_values_are_kept);
    RUN_TEST(a_parameter_without_value_or_size_is_not_found);
    RUN_TEST(tables_of_the_cache_are_bounded);
    RUN_TEST(the_octets_of_the_cache_are_bounded);
    RUN_TEST(a_value_that_is_no_longer_reported_is_old);
    return UNITY_END();
}
