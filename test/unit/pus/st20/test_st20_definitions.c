// SPDX-License-Identifier: Apache-2.0
// Parameters that are defined by their address in memory: TC[20,4] to [20,6], and their values. The fields:
// pus/catalogue/st20_parameters.txt.
#include "pus/st20/st20_definitions.h"

#include "base/value.h"
#include "test/unit/pus/fixtures/memories.h"
#include "test/unit/pus/fixtures/parameters.h"
#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 2U
#define NEW_U32 ID_OF(VALUE_UINT32, 500)
#define NEW_DOUBLE ID_OF(VALUE_DOUBLE, 501)
#define NEW_BOOL ID_OF(VALUE_BOOL, 502)

static pus_parameters_t parameters;
static pus_parameter_definitions_t definitions;
static pus_parameter_definition_t table[CAPACITY];
static bool is_base_fixed;
static osal_mutex_t mutex;

static void start(void)
{
    pus_parameter_port_t port                       = dictionary_port();
    port.write                                      = is_base_fixed ? NULL : port.write;
    const pus_parameter_definitions_config_t config = {.apid         = TEST_APID,
                                                       .port         = port,
                                                       .memories     = memory_list(),
                                                       .states       = memory_states,
                                                       .memory_count = 3U,
                                                       .table        = table,
                                                       .capacity     = CAPACITY,
                                                       .persistence  = is_base_fixed ? NULL : records_port(),
                                                       .mutex        = is_base_fixed ? NULL : &mutex};
    memset(&parameters, 0xA5, sizeof parameters);
    pus_parameters_init(&parameters, &port);
    memset(table, 0xA5, sizeof table);
    memset(&definitions, 0xA5, sizeof definitions);
    pus_parameter_definitions_init(&definitions, &config);
    const pus_parameter_definer_t definer = pus_parameter_definitions_definer(&definitions);
    pus_parameters_define(&parameters, &definer);
    bench_serve(pus_parameters_service(&parameters));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void setUp(void)
{
    is_base_fixed = false;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&mutex, false));
    memories_start();
    start();
}

void tearDown(void)
{
}

static void begin(const unsigned count)
{
    memory_writer = octet_writer(memory_data, sizeof memory_data);
    octet_write_u8(&memory_writer, (uint8_t)count);
}

static void add(const uint32_t id, const unsigned memory, const uint32_t address, const unsigned ptc,
                const unsigned pfc)
{
    octet_write_u32(&memory_writer, id);
    octet_write_u8(&memory_writer, (uint8_t)memory);
    octet_write_u32(&memory_writer, address);
    octet_write_u8(&memory_writer, (uint8_t)ptc);
    octet_write_u16(&memory_writer, (uint16_t)pfc);
}

/// Define one parameter by its raw address.
static void define(const uint32_t id, const unsigned memory, const uint32_t address, const unsigned ptc,
                   const unsigned pfc)
{
    begin(1U);
    add(id, memory, address, ptc, pfc);
    memory_request(4U);
}

static void ask(const uint8_t subtype, const uint32_t id)
{
    begin(1U);
    octet_write_u32(&memory_writer, id);
    memory_request(subtype);
}

static void set(const uint32_t id, const void* const octets, const size_t size)
{
    begin(1U);
    octet_write_u32(&memory_writer, id);
    octet_write_octets(&memory_writer, octets, size);
    memory_request(3U);
}

static void values_in_memory_are_reported_and_set(void)
{
    // One parameter, its id (u32) and its value.
    static const uint8_t expected[] = {0, 1, 2, 2, 1, 0xF4, 0x11, 0x22, 0x33, 0x44};
    const uint32_t value            = 0x11223344U;
    memcpy(&memory_ram[8], &value, sizeof value);
    define(NEW_U32, RAM, RAM_BASE + 8U, 3U, 14U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(4U, memory_data, memory_writer.position);
    ask(1U, NEW_U32);
    EXPECT_MESSAGES(1, 1, 1, 3, 20, 2, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    set(NEW_U32, "\1\2\3\4", 4U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    uint32_t found = 0U;
    memcpy(&found, &memory_ram[8], sizeof found);
    TEST_ASSERT_EQUAL_HEX32(0x01020304U, found);
}

static void a_value_that_cannot_be_read_is_zero(void)
{
    memory_hardware.broken_at = RAM_BASE + 8U;
    define(NEW_U32, RAM, RAM_BASE + 8U, 3U, 14U);
    ask(1U, NEW_U32);
    TEST_ASSERT_EQUAL_HEX32(0U, octets_u32_at(&bench_report(2U).data[6]));
}

static void parameters_of_the_dictionary_are_not_affected(void)
{
    ask(1U, P_U8);
    EXPECT_MESSAGES(1, 1, 1, 3, 20, 2, 1, 7);
    set(P_U8, "\5", 1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_HEX32(P_U8, dictionary.written_id);
    is_base_fixed = true;
    start();
    set(P_U8, "\5", 1U);
    expect_failure(1U, 4U, PUS_FAILURE_ACCESS, 1U, P_U8);
    define(NEW_U32, RAM, RAM_BASE, 3U, 14U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void a_parameter_that_cannot_be_set_is_refused(void)
{
    define(NEW_BOOL, RAM, RAM_BASE, 1U, 0U);
    set(NEW_BOOL, "\2", 1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 5U);
    memory_states[0].is_protected = true;
    set(NEW_BOOL, "\1", 1U);
    expect_failure(1U, 4U, PUS_FAILURE_ACCESS, 1U, NEW_BOOL);
    define(NEW_BOOL, ROM, 0U, 1U, 0U);
    set(NEW_BOOL, "\1", 1U);
    expect_failure(1U, 4U, PUS_FAILURE_ACCESS, 1U, NEW_BOOL);
    define(NEW_U32, WORDS, WORDS_BASE, 3U, 14U);
    memory_hardware.refuses_writes = true;
    set(NEW_U32, "\1\2\3\4", 4U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, NEW_U32);
}

static void a_parameter_may_be_in_an_object_of_a_memory(void)
{
    // One definition: id (u32), memory, address (u32), PTC, PFC (u16).
    static const uint8_t expected[] = {0, 1, 2, 9, 1, 0xF5, RAM, 0, 0, 0x11, 0x10, 5, 0, 2};
    begin(2U);
    for (unsigned i = 0U; i < 2U; i++) {
        octet_write_u32(&memory_writer, NEW_DOUBLE);
        octet_write_u8(&memory_writer, RAM);
        octet_write_u32(&memory_writer, 7U + i); // Object 8 is empty.
        octet_write_u32(&memory_writer, 16U);
        octet_write_u8(&memory_writer, 5U);
        octet_write_u16(&memory_writer, 2U);
    }
    memory_request(5U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_ADDRESS, 2U, 16U);
    expect_strict_format(5U, memory_data, memory_writer.position);
    ask(6U, NEW_DOUBLE);
    EXPECT_MESSAGES(1, 1, 1, 3, 20, 7, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
}

static void each_faulty_definition_is_refused_alone(void)
{
    static const struct {
        uint32_t id;
        uint8_t memory;
        uint32_t address;
        uint8_t ptc;
        uint16_t pfc;
        uint16_t code;
        uint32_t detail;
    } cases[] = {
        {P_U8, RAM, RAM_BASE, 3U, 4U, PUS_FAILURE_ACCESS, P_U8},
        {P_SECRET, RAM, RAM_BASE, 3U, 12U, PUS_FAILURE_ACCESS, P_SECRET},
        {0x00000005U, RAM, RAM_BASE, 3U, 4U, PUS_FAILURE_UNKNOWN_ID, 5U},
        {NEW_U32, RAM, RAM_BASE, 4U, 14U, PUS_FAILURE_OUT_OF_RANGE, 1U},
        {NEW_U32, RAM, RAM_BASE, 3U, 12U, PUS_FAILURE_OUT_OF_RANGE, 1U},
        {P_UNKNOWN_ARRAY, RAM, RAM_BASE, 3U, 12U, PUS_FAILURE_OUT_OF_RANGE, 1U},
        {NEW_U32, 9U, RAM_BASE, 3U, 14U, PUS_FAILURE_UNKNOWN_ID, 9U},
        {NEW_U32, RAM, RAM_BASE + 4093U, 3U, 14U, PUS_FAILURE_ADDRESS, RAM_BASE + 4093U},
        {NEW_U32, WORDS, 0xFFFFFFC2U, 3U, 14U, PUS_FAILURE_ADDRESS, 0xFFFFFFC2U},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        define(cases[i].id, cases[i].memory, cases[i].address, cases[i].ptc, cases[i].pfc);
        EXPECT_MESSAGES(1, 1, 1, 4);
        expect_failure(1U, 4U, cases[i].code, 1U, cases[i].detail);
    }
    define(NEW_U32, RAM, RAM_BASE, 3U, 14U);
    define(NEW_DOUBLE, RAM, RAM_BASE, 5U, 2U);
    define(NEW_BOOL, RAM, RAM_BASE, 1U, 0U);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 1U, CAPACITY);
    define(NEW_U32, ROM, 4U, 3U, 14U); // The parameter gets another address.
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    ask(6U, NEW_U32);
    TEST_ASSERT_EQUAL_UINT8(ROM, bench_report(2U).data[6]);
}

static void definitions_of_all_parameters_are_reported(void)
{
    // Two definitions: id (u32), memory, address (u32), PTC, PFC (u16).
    static const uint8_t expected[] = {0, 2, 2,  0, 0, 1, 0, 0, 0, 0, 0, 3, 0,
                                       4, 2, 24, 0, 4, 0, 0, 0, 0, 0, 7, 0, 0};
    begin(4U);
    octet_write_u32(&memory_writer, P_U8);
    octet_write_u32(&memory_writer, P_UNKNOWN);
    octet_write_u32(&memory_writer, P_STRUCT);
    octet_write_u32(&memory_writer, P_SECRET);
    memory_request(6U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 20, 7, 1, 8);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(4U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(4U).data, sizeof expected);
    ask(6U, P_UNKNOWN);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_strict_format(6U, memory_data, memory_writer.position);
}

static void without_memories_no_parameter_can_be_defined(void)
{
    const pus_parameter_port_t port = dictionary_port();
    memset(&parameters, 0xA5, sizeof parameters);
    pus_parameters_init(&parameters, &port);
    bench_serve(pus_parameters_service(&parameters));
    define(NEW_U32, RAM, RAM_BASE, 3U, 14U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_ACCESS, 0U, NEW_U32);
    ask(6U, P_U16);
    EXPECT_MESSAGES(1, 1, 1, 3, 20, 7, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED,
                      pus_parameters_restore(&parameters, NEW_U32, (const uint8_t*)"", 0U));
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_parameters_restore(self, key, octets, size);
}

static void definitions_outlive_a_power_cut(void)
{
    define(NEW_U32, RAM, RAM_BASE + 4U, 3U, 14U);
    define(NEW_BOOL, ROM, 3U, 1U, 0U);
    records_cut();
    start();
    TEST_ASSERT_EQUAL_UINT64(2U, records_replay(PUS_SERVICE_PARAMETERS, restore, &parameters));
    // A second restoration changes nothing.
    TEST_ASSERT_EQUAL_UINT64(2U, records_replay(PUS_SERVICE_PARAMETERS, restore, &parameters));
    ask(6U, NEW_BOOL);
    TEST_ASSERT_EQUAL_UINT8(ROM, bench_report(2U).data[6]);
    records.put_status = STATUS_FULL;
    define(NEW_BOOL, RAM, RAM_BASE, 1U, 0U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
}

static void invalid_records_are_refused(void)
{
    uint8_t record[] = {ROM, 0, 0, 0, 3, VALUE_BOOL};
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_parameters_restore(&parameters, NEW_BOOL, record, 5U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_parameters_restore(&parameters, NEW_U32, record, sizeof record));
    record[5] = 24U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_parameters_restore(&parameters, P_STRUCT, record, sizeof record));
    record[5] = VALUE_SCALARS; // The smallest invalid type.
    TEST_ASSERT_EQUAL(
        STATUS_INVALID,
        pus_parameters_restore(&parameters, ((uint32_t)VALUE_SCALARS << 16U) | 700U, record, sizeof record));
    record[5] = VALUE_BOOL;
    record[0] = 9U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_parameters_restore(&parameters, NEW_BOOL, record, sizeof record));
    record[0] = ROM;
    record[4] = 64U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_parameters_restore(&parameters, NEW_BOOL, record, sizeof record));
    record[4] = 63U;
    for (uint32_t i = 0U; i <= CAPACITY; i++) {
        TEST_ASSERT_EQUAL((i < CAPACITY) ? STATUS_OK : STATUS_EXHAUSTED,
                          pus_parameters_restore(&parameters, NEW_BOOL + i, record, sizeof record));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_in_memory_are_reported_and_set);
    RUN_TEST(a_value_that_cannot_be_read_is_zero);
    RUN_TEST(parameters_of_the_dictionary_are_not_affected);
    RUN_TEST(a_parameter_that_cannot_be_set_is_refused);
    RUN_TEST(a_parameter_may_be_in_an_object_of_a_memory);
    RUN_TEST(each_faulty_definition_is_refused_alone);
    RUN_TEST(definitions_of_all_parameters_are_reported);
    RUN_TEST(without_memories_no_parameter_can_be_defined);
    RUN_TEST(definitions_outlive_a_power_cut);
    RUN_TEST(invalid_records_are_refused);
    return UNITY_END();
}
