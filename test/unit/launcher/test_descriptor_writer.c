// SPDX-License-Identifier: Apache-2.0
// Models of descriptors as C sources: texts and numbers are written exactly, in initializers of the items,
// and a failure of the file is kept. test/conformance/test_compiled_descriptors.py compares whole models.
#include "launcher/descriptor_writer.h"

#include "unity.h"

#include <float.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static descriptor_writer_t writer;
static subsystem_descriptor_t model;
static mission_descriptor_t mission;
static osal_file_t file;
static char source[262144];

void setUp(void)
{
    descriptor_subsystem_clear(&model);
    descriptor_mission_clear(&mission);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, "descriptor_writer.out"));
    descriptor_writer_begin(&writer, &file);
}

void tearDown(void)
{
    osal_file_close(&file);
    (void)unlink("descriptor_writer.out");
}

/// Read what was written.
static void finish(void)
{
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, descriptor_writer_end(&writer));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load("descriptor_writer.out", source, sizeof source - 1U, &size));
    source[size] = '\0';
}

static void expect(const char* const words)
{
    if (strstr(source, words) == NULL) {
        (void)puts(source);
        TEST_FAIL_MESSAGE(words);
    }
}

static void texts_are_written_with_their_special_characters(void)
{
    model.storage.enumerations[0] =
        (descriptor_enumeration_t){.name = "A\"\\?\n\xC2\xB0", .first = 3U, .line = 70000U, .values = ""};
    model.enumeration_count = 1U;
    descriptor_writer_subsystem(&writer, 7U, &model);
    finish();
    expect("static const descriptor_enumeration_t subsystem_7_enumerations[] = {\n");
    expect(".name = \"A\\042\\134\\077\\012\\302\\260\", .first = 3U, .line = 70000U, .values = \"\"");
    expect("static subsystem_descriptor_t subsystem_7 = {\n");
    expect(".enumerations = subsystem_7_enumerations,");
    expect(".enumeration_count = 1U");
}

static void real_numbers_are_written_exactly(void)
{
    static const double numbers[] = {0.0, -0.0, 1.0, -2.5, 0.1, DBL_MAX, -DBL_MAX, DBL_MIN, DBL_MIN / 4.0};
    for (size_t i = 0U; i < (sizeof numbers / sizeof numbers[0]); i++) {
        model.storage.quantities[i] = (descriptor_quantity_t){.name = "N", .unit = "", .scale = numbers[i]};
    }
    model.quantity_count = (uint16_t)(sizeof numbers / sizeof numbers[0]);
    descriptor_writer_subsystem(&writer, 0U, &model);
    finish();
    const char* at = source;
    for (size_t i = 0U; i < (sizeof numbers / sizeof numbers[0]); i++) {
        double number = 1.0e9;
        at            = strstr(at, ".scale = ");
        TEST_ASSERT_NOT_NULL(at);
        at += strlen(".scale = ");
        TEST_ASSERT_EQUAL_INT(1, sscanf(at, "%la", &number));
        TEST_ASSERT_EQUAL_MEMORY(&numbers[i], &number, sizeof number);
    }
}

static void a_field_refers_to_its_enumeration_and_absent_texts_are_null(void)
{
    model.storage.enumerations[1] = (descriptor_enumeration_t){.name = "E", .values = "ONE TWO"};
    model.storage.enumerations[0] = (descriptor_enumeration_t){.name = "D", .values = "ONE"};
    model.enumeration_count       = 2U;
    model.storage.fields[0] =
        (descriptor_field_t){.name = "F", .unit = "m", .init = NULL, .enumeration = &model.enumerations[1]};
    model.storage.fields[1] =
        (descriptor_field_t){.name = "G", .unit = "", .init = "1 2", .enumeration = NULL};
    model.field_count = 2U;
    descriptor_writer_subsystem(&writer, 0U, &model);
    finish();
    expect(".init = NULL");
    expect(".enumeration = &subsystem_0_enumerations[1]");
    expect(".init = \"1 2\"");
    expect(".enumeration = NULL");
}

static void arrays_and_plain_numbers_are_written(void)
{
    model.storage.references[0] = 5U;
    model.storage.references[1] = 0xFFFFU;
    model.reference_count       = 2U;
    model.timeout_us[9]         = 4000000000U;
    model.interface_hash        = UINT64_MAX;
    mission.name                = "m";
    mission.storage.links[0]    = (mission_link_t){.name = "L", .number = 1U, .consumer_apid = 2046U};
    mission.link_count          = 1U;
    descriptor_writer_subsystem(&writer, 0U, &model);
    descriptor_writer_mission(&writer, 1U, &mission);
    finish();
    expect("static const uint16_t subsystem_0_references[] = {\n    5U,\n    65535U,\n};");
    expect(".timeout_us = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 4000000000U}");
    expect(".interface_hash = 18446744073709551615ULL");
    expect("static const mission_descriptor_t mission_1 = {\n");
    expect(".consumer_apid = 2046U");
    TEST_ASSERT_NULL(strstr(source, "mission_1_buses"));
}

static void a_list_as_long_as_permitted_is_written_completely(void)
{
    for (uint16_t i = 0U; i < DESCRIPTOR_SETTINGS_MAX; i++) {
        model.storage.settings[i].index = i;
    }
    model.setting_count = DESCRIPTOR_SETTINGS_MAX;
    descriptor_writer_subsystem(&writer, 0U, &model);
    finish();
    for (uint16_t i = 0U; i < DESCRIPTOR_SETTINGS_MAX; i++) {
        char item[32];
        (void)snprintf(item, sizeof item, "{.index = %uU, ", i);
        expect(item);
    }
}

static void the_source_checks_the_layout_of_its_compiler(void)
{
    finish();
    expect("typedef struct { char octet; double member; } aligned_double;\n"
           "typedef char layout_of_double[(offsetof(aligned_double, member) == 8U) ? 1 : -1];\n");
    expect("layout_of_uint64_t");
}

static void a_failure_of_the_file_is_kept(void)
{
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_open_read(&file, "/dev/null"));
    descriptor_writer_subsystem(&writer, 0U, &model);
    const status_t first = descriptor_writer_end(&writer);
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, first);
    TEST_ASSERT_EQUAL(first, descriptor_writer_end(&writer));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(texts_are_written_with_their_special_characters);
    RUN_TEST(real_numbers_are_written_exactly);
    RUN_TEST(a_field_refers_to_its_enumeration_and_absent_texts_are_null);
    RUN_TEST(arrays_and_plain_numbers_are_written);
    RUN_TEST(a_list_as_long_as_permitted_is_written_completely);
    RUN_TEST(the_source_checks_the_layout_of_its_compiler);
    RUN_TEST(a_failure_of_the_file_is_kept);
    return UNITY_END();
}
