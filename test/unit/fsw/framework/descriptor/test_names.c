// SPDX-License-Identifier: Apache-2.0
// Enumerations and failures of a subsystem descriptor; names of states.
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t arm;

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

static status_t load(const char* const document)
{
    return descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &arm);
}

// The comments // 5 and // 10 number the lines of the document; the tests of errors expect these numbers.
static const char named_document[] =
    "<Subsystem name='ARM' id='16'><Enumerations>\n"
    "<Enumeration name='MODE' values='OFF POSITION FORCE'/>\n"
    "<Enumeration name='CAUSE' first='253' values='LOST SILENT OFF'/>\n"
    "</Enumerations><Failures><Failure name='TOO_FAR' id='1' detail='JOINT'/>\n"
    "<Failure name='TOO_FAST' id='32767'/></Failures><Parameters>\n" // 5
    "<StructRef name='ALL' id='7' type='STRUCT' settable='true'>\n"
    "<ParamRef name='MODE' type='INT8' count='3' enumeration='MODE' init='FORCE OFF POSITION'/>\n"
    "<ParamRef name='CAUSE' type='UINT8' enumeration='CAUSE'/></StructRef>\n"
    "<ParamRef name='WHY' id='8' type='UINT64' enumeration='CAUSE' init='SILENT'/></Parameters>\n"
    "<Functions><Function name='SWITCH' id='1' states='*'>\n" // 10
    "<Argument name='TO' id='1' type='UINT16' enumeration='MODE'/></Function></Functions>\n"
    "<Configuration name='ONE' id='1' priority='1' samplingTime='1ms'>\n"
    "<Initial parameter='WHY' value='OFF'/>\n"
    "</Configuration></Subsystem>\n";

static void names_have_consecutive_numbers(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(named_document));
    TEST_ASSERT_EQUAL_UINT16(2U, arm.enumeration_count);
    TEST_ASSERT_EQUAL_STRING("MODE", arm.enumerations[0].name);
    TEST_ASSERT_EQUAL_UINT16(0U, arm.enumerations[0].first);
    TEST_ASSERT_EQUAL_STRING("OFF POSITION FORCE", arm.enumerations[0].values);
    TEST_ASSERT_EQUAL_UINT16(253U, arm.enumerations[1].first);
    TEST_ASSERT_EQUAL_UINT16(2U, arm.failure_count);
    TEST_ASSERT_EQUAL_STRING("TOO_FAR", arm.failures[0].name);
    TEST_ASSERT_EQUAL_UINT16(32767U, arm.failures[1].id);
}

static void the_numbers_are_the_bounds_of_a_field(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(named_document));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, arm.fields[0].min);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, arm.fields[0].max);
    TEST_ASSERT_EQUAL_DOUBLE(253.0, arm.fields[1].min);
    TEST_ASSERT_EQUAL_DOUBLE(255.0, arm.fields[1].max);
    const descriptor_field_t* const argument = &arm.fields[arm.functions[0].first_argument];
    TEST_ASSERT_EQUAL_PTR(&arm.enumerations[0], argument->enumeration);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, argument->max);
}

static void initial_values_by_name_become_numbers(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(named_document));
    TEST_ASSERT_EQUAL_STRING("2 0 1", arm.fields[0].init);
    TEST_ASSERT_NULL(arm.fields[1].init);
    TEST_ASSERT_EQUAL_STRING("254", arm.fields[2].init);
    TEST_ASSERT_EQUAL_STRING("255", arm.initials[0].text);
}

static void each_error_contains_line_and_cause(void)
{
    static const struct {
        const char* find;
        const char* replacement;
        unsigned line;
        const char* cause;
    } cases[] = {
        {"values='OFF P", "values='OFF OFF P", 2U,
         "expected different upper-case identifiers (A-Z 0-9 _) of at most 32"},
        {"values='OFF P", "values='OFF  P", 2U, "expected different upper-case identifiers"},
        {"values='OFF P", "values=' P", 2U, "expected different upper-case identifiers"},
        {"FORCE'/>", "FORCE '/>", 2U, "expected different upper-case identifiers"},
        {"FORCE'/>", "9'/>", 2U, "expected different upper-case identifiers"},
        {"FORCE'/>", "ABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFG'/>", 2U, "expected different upper-case identifiers"},
        {"values='OFF POSITION FORCE'", "values=''", 2U, "expected different upper-case identifiers"},
        {"values='OFF POSITION FORCE'", "first='1'", 2U, "<Enumeration> needs attribute values"},
        {"name='CAUSE' first", "name='MODE' first", 3U, "name MODE is taken in line 2"},
        {"first='253'", "first='65536'", 3U, "expected a number from 0 to 65535"},
        {"first='253'", "first='254'", 8U,
         "enumeration=\"CAUSE\" of <ParamRef>: expected an <Enumeration> defined above"},
        {"id='32767'", "id='32768'", 5U, "expected a number from 1 to 32767"},
        {"id='32767'", "id='1'", 5U, "id 1 is taken in line 4"},
        {"name='TOO_FAST'", "name='TOO_FAR'", 5U, "name TOO_FAR is taken in line 4"},
        {"detail='JOINT'", "detail='joint'", 4U, "expected an upper-case identifier (A-Z 0-9 _) of at most"},
        {"enumeration='MODE' init", "enumeration='MODES' init", 7U,
         "expected an <Enumeration> defined above whose numbers fit"},
        {"type='UINT8'", "type='INT8'", 8U,
         "expected an <Enumeration> defined above whose numbers fit the type"},
        {"type='UINT8'", "type='FLOAT'", 8U,
         "expected an <Enumeration> defined above whose numbers fit the type"},
        {"type='UINT8'", "type='UINT8' min='1'", 8U, "and neither min nor max"},
        {"type='UINT8'", "type='UINT8' max='1'", 8U, "and neither min nor max"},
        {"init='FORCE OFF POSITION'", "init='FORCE ON POSITION'", 7U, "expected 3 of: OFF POSITION FORCE"},
        {"init='FORCE OFF POSITION'", "init='FORCE OFF'", 7U, "expected 3 of: OFF POSITION FORCE"},
        {"init='FORCE OFF POSITION'", "init='FORCE OFF OFF OFF'", 7U, "expected 3 of: OFF POSITION FORCE"},
        {"init='FORCE OFF POSITION'", "init='2 0 1'", 7U, "expected 3 of: OFF POSITION FORCE"},
        {"<Functions>",
         "<Events><Event name='E' id='1' severity='LOW'><ParamRef name='WHY' "
         "enumeration='MODE'/></Event></Events><Functions>",
         10U, "<ParamRef> without type cannot have count, unit or enumeration"},
        {"value='OFF'", "value='OUT'", 13U, "value=\"OUT\" of <Initial>: expected 1 of: LOST SILENT OFF"},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        char location[32];
        (void)snprintf(location, sizeof location, "arm.xml:%u: ", cases[i].line);
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, load(damaged(named_document, cases[i].find, cases[i].replacement)));
        TEST_ASSERT_EQUAL_STRING_LEN(location, descriptor_error(&loader), strlen(location));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), cases[i].cause),
                                     descriptor_error(&loader));
    }
}

static void names_change_the_interface_hash(void)
{
    static const char* const changes[][2] = {{"POSITION FORCE'", "FORCE POSITION'"},
                                             {"first='253'", "first='252'"},
                                             {"name='TOO_FAST'", "name='TOO_SLOW'"},
                                             {"id='32767'", "id='2'"}};
    TEST_ASSERT_EQUAL(STATUS_OK, load(named_document));
    const uint64_t interface = arm.interface_hash;
    for (size_t i = 0U; i < sizeof changes / sizeof changes[0]; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(named_document, changes[i][0], changes[i][1])));
        TEST_ASSERT_TRUE_MESSAGE(arm.interface_hash != interface, changes[i][1]);
    }
    // The name of a detail of a failure is for the ground only, so the hash does not contain it.
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(named_document, "JOINT", "AXIS")));
    TEST_ASSERT_TRUE(arm.interface_hash == interface);
}

static void states_have_names_and_are_found_by_them(void)
{
    for (uint8_t state = 0U; state < DESCRIPTOR_STATES; state++) {
        uint8_t number = 99U;
        TEST_ASSERT_EQUAL(STATUS_OK, descriptor_state_of(descriptor_state_name(state), &number));
        TEST_ASSERT_EQUAL_UINT8(state, number);
    }
    uint8_t number = 0U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, descriptor_state_of("OFF", &number));
    TEST_ASSERT_EQUAL_STRING("UNKNOWN", descriptor_state_name(DESCRIPTOR_STATES));
    char words[DESCRIPTOR_STATE_WORDS];
    text_t text = text_in(words, sizeof words);
    descriptor_state_words(UINT16_MAX, &text);
    TEST_ASSERT_EQUAL_STRING("OFFLINE SOFTWARE_INIT HARDWARE_INIT PRE_OPERATIONAL SAFE_OPERATIONAL "
                             "OPERATIONAL ERROR_OPERATIONAL POST_OPERATIONAL HARDWARE_DEINIT SOFTWARE_DEINIT",
                             words);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(names_have_consecutive_numbers);
    RUN_TEST(the_numbers_are_the_bounds_of_a_field);
    RUN_TEST(initial_values_by_name_become_numbers);
    RUN_TEST(each_error_contains_line_and_cause);
    RUN_TEST(names_change_the_interface_hash);
    RUN_TEST(states_have_names_and_are_found_by_them);
    return UNITY_END();
}
