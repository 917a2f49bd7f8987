// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/telemetry_directory.h"

#include "fsw/framework/descriptor/descriptor.h"
#include "unity.h"

#include <string.h>

#define ARM 16U
#define ID(layout, number) (((uint32_t)ARM << 21U) | ((uint32_t)(layout) << 16U) | (number))
#define VALUES ID(VALUE_STRUCT, 1U)
#define GOAL ID(VALUE_ARRAY, 2U)
#define AGE ID(VALUE_UINT32, 3U)
#define TRACE ID(VALUE_ARRAY, 4U)

static const char document[] =
    "<Subsystem name='ARM' id='16' samplingTime='1ms'><Parameters>\n"
    "<StructRef name='VALUES' id='1' type='STRUCT'><ParamRef name='MODE' type='UINT8'/>\n"
    "<ParamRef name='POSITION' type='DOUBLE' count='2'/><ParamRef name='FLAGS' type='UINT16'/></StructRef>\n"
    "<ParamRef name='GOAL' id='2' type='INT16' count='3'/><ParamRef name='AGE' id='3' type='UINT32'/>\n"
    "<ParamRef name='TRACE' id='4' type='UINT8' count='200'/>\n"
    "</Parameters><Events/><Functions/>\n"
    "<Configuration name='ONE' id='1' priority='10' samplingTime='1ms'>\n"
    "<HKService id='5' interval='4'><SampledOnce><ParamRef name='VALUES'/></SampledOnce>\n"
    "<SampledNREPTimes nrep='2'><ParamRef name='AGE'/></SampledNREPTimes></HKService></Configuration>\n"
    "<Configuration name='TWO' id='2' priority='10' samplingTime='1ms'>\n"
    "<HKService id='5' interval='4'><SampledOnce><ParamRef name='GOAL'/></SampledOnce></HKService>\n"
    "</Configuration></Subsystem>\n";

static telemetry_directory_t directory;
static telemetry_cache_t cache;
static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;

void setUp(void)
{
    descriptor_loader_init(&loader);
    const status_t status =
        descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &descriptor);
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    supervisor_telemetry_directory_init(&directory);
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    const telemetry_cache_sizes_t sizes = supervisor_telemetry_directory_sizes(&directory);
    supervisor_telemetry_cache_init(&cache, &sizes);
}

void tearDown(void)
{
}

static void expect_scalar(const char* const name, const uint32_t id, const uint32_t offset,
                          const value_type_t type)
{
    telemetry_scalar_t scalar;
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, supervisor_telemetry_directory_find(&directory, name, &scalar),
                              name);
    TEST_ASSERT_EQUAL_HEX32(id, scalar.parameter_id);
    TEST_ASSERT_EQUAL_UINT32(offset, scalar.offset);
    TEST_ASSERT_EQUAL(type, scalar.type);
}

static void scalars_are_found_by_name(void)
{
    expect_scalar("ARM.VALUES.MODE", VALUES, 0U, VALUE_UINT8);
    expect_scalar("ARM.VALUES.POSITION[0]", VALUES, 1U, VALUE_DOUBLE);
    expect_scalar("ARM.VALUES.POSITION[1]", VALUES, 9U, VALUE_DOUBLE);
    expect_scalar("ARM.VALUES.FLAGS", VALUES, 17U, VALUE_UINT16);
    expect_scalar("ARM.GOAL[2]", GOAL, 4U, VALUE_INT16);
    expect_scalar("ARM.AGE", AGE, 0U, VALUE_UINT32);
    expect_scalar("ARM.TRACE[9]", TRACE, 9U, VALUE_UINT8);
    expect_scalar("ARM.TRACE[190]", TRACE, 190U, VALUE_UINT8);
    expect_scalar("ARM.TRACE[199]", TRACE, 199U, VALUE_UINT8);
    TEST_ASSERT_EQUAL_UINT32(0U, directory.full);
}

static void a_name_that_is_no_scalar_is_not_found(void)
{
    static const char* const names[] = {"",
                                        "ARM",
                                        "ARM.VALUES",
                                        "ARM.VALUES.POSITION",
                                        "ARM.VALUES.POSITION[2]",
                                        "ARM.VALUES.POSITION[4294967297]",
                                        "ARM.VALUES.POSITION[]",
                                        "ARM.VALUES.POSITION[/]",
                                        "ARM.TRACE[:]",
                                        "ARM.TRACE[200]",
                                        "ARM.TRACE[99999]",
                                        "ARM.TRACE[-1]",
                                        "ARM.VALUES.POSITION[0",
                                        "ARM.VALUES.POSITION[0]]",
                                        "ARM.VALUES.MODE[0]",
                                        "ARM.AGE[0]",
                                        "ARM.GOAL",
                                        "HAND.AGE",
                                        "AGE",
                                        "[0]"};
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        telemetry_scalar_t scalar;
        TEST_ASSERT_EQUAL_MESSAGE(
            STATUS_NOT_FOUND, supervisor_telemetry_directory_find(&directory, names[i], &scalar), names[i]);
    }
}

/// Send a report of structure 5 with this number of octets; each octet is greater than the one before by 1.
static void report(const uint16_t size)
{
    uint8_t data[64] = {0, 5};
    for (uint8_t i = 0U; i < size; i++) {
        data[2U + i] = (uint8_t)(i + 1U);
    }
    const pus_tm_t tm = {.apid    = ARM,
                         .service = PUS_SERVICE_HOUSEKEEPING,
                         .subtype = 25U,
                         .time_ns = 7U,
                         .data    = data,
                         .size    = 2U + (size_t)size};
    supervisor_telemetry_cache_observe(&cache, &tm);
}

static void expect_value(const uint32_t id, const uint16_t size, const uint8_t first)
{
    const uint8_t* octets = NULL;
    uint16_t found        = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_telemetry_cache_value(&cache, id, &octets, &found));
    TEST_ASSERT_EQUAL_UINT16(size, found);
    TEST_ASSERT_EQUAL_UINT8(first, octets[0]);
}

static void the_telemetry_cache_takes_reports_of_the_configuration(void)
{
    const uint8_t* octets = NULL;
    uint16_t size         = 0U;
    report(27U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, supervisor_telemetry_cache_value(&cache, VALUES, &octets, &size));
    supervisor_telemetry_directory_define(&directory, &cache, ARM, 1U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, supervisor_telemetry_cache_value(&cache, VALUES, &octets, &size));
    report(27U); // 19 octets of VALUES, and 2 samples of AGE with 4 octets each.
    expect_value(VALUES, 19U, 1U);
    expect_value(AGE, 4U, 24U); // The last sample.
    supervisor_telemetry_directory_define(&directory, &cache, ARM, 2U);
    report(6U);
    expect_value(GOAL, 6U, 1U);
    TEST_ASSERT_EQUAL_UINT32(0U, cache.counters.unfitting);
    supervisor_telemetry_directory_define(&directory, &cache, ARM, 3U); // Configuration 3 has no structures.
    supervisor_telemetry_directory_define(&directory, &cache, 17U, 1U); // APID 17 has no structures.
    report(6U);
    TEST_ASSERT_EQUAL_UINT32(0U, cache.counters.unfitting);
}

static void sizes_are_reported(void)
{
    const telemetry_cache_sizes_t sizes = supervisor_telemetry_directory_sizes(&directory);
    uint16_t size                       = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, sizes.size_of(sizes.context, VALUES, &size));
    TEST_ASSERT_EQUAL_UINT16(19U, size);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, sizes.size_of(sizes.context, VALUES + 1U, &size));
}

static void the_content_of_structures_lies_one_after_another(void)
{
    TEST_ASSERT_EQUAL_UINT16(2U, directory.structure_count);
    TEST_ASSERT_EQUAL_UINT16(0U, directory.structures[0].offset);
    TEST_ASSERT_EQUAL_UINT16(directory.structures[0].size, directory.structures[1].offset);
    TEST_ASSERT_EQUAL_UINT16(directory.structures[0].size + directory.structures[1].size,
                             directory.content_used);
}

static void entries_without_room_in_the_directory_are_counted(void)
{
    directory.field_count = TELEMETRY_FIELDS - 2U;
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    TEST_ASSERT_EQUAL_UINT32(4U, directory.full);
    directory.parameter_count = TELEMETRY_PARAMETERS;
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    TEST_ASSERT_EQUAL_UINT32(8U, directory.full);
    directory.structure_count = TELEMETRY_STRUCTURES - 1U;
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    TEST_ASSERT_EQUAL_UINT32(13U, directory.full);
    directory.structure_count = 0U;
    directory.content_used    = TELEMETRY_CONTENT - 8U; // The second structure has room, the first has not.
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    TEST_ASSERT_EQUAL_UINT32(18U, directory.full);
    TEST_ASSERT_EQUAL_UINT16(1U, directory.structure_count);
    descriptor.storage.parameters[0].wire_size = 65536U;
    supervisor_telemetry_directory_init(&directory);
    supervisor_telemetry_directory_learn(&directory, &descriptor);
    TEST_ASSERT_EQUAL_UINT32(1U, directory.full);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(scalars_are_found_by_name);
    RUN_TEST(a_name_that_is_no_scalar_is_not_found);
    RUN_TEST(the_telemetry_cache_takes_reports_of_the_configuration);
    RUN_TEST(sizes_are_reported);
    RUN_TEST(the_content_of_structures_lies_one_after_another);
    RUN_TEST(entries_without_room_in_the_directory_are_counted);
    return UNITY_END();
}
