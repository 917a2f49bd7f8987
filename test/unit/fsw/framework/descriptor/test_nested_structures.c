// SPDX-License-Identifier: Apache-2.0
// Structures within the structure of a parameter.
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

// The comments // 5, // 10 .. number the lines of the document; the tests of errors expect these numbers.
static const char nested_document[] =
    "<Subsystem name='ARM' id='16'><Parameters>\n"
    "<StructRef name='ALL' id='7' type='STRUCT' settable='true'>\n"
    "<ParamRef name='FIRST' type='UINT8'/>\n"
    "<StructRef name='JOINT' type='STRUCT'>\n"
    "<ParamRef name='FLAG' type='BOOL'/>\n" // 5
    "<StructRef name='MOTOR' type='STRUCT'>\n"
    "<ParamRef name='CURRENT' type='DOUBLE' count='2' init='1.5 -1.5'/>\n"
    "<StructRef name='COIL' type='STRUCT'><ParamRef name='WARM' type='BOOL'/></StructRef>\n"
    "</StructRef>\n"
    "<ParamRef name='LAST' type='UINT16' max='100'/><ParamRef name='SMALL' type='UINT8'/>\n" // 10
    "</StructRef>\n"
    "<StructRef name='TOOL' type='STRUCT'><ParamRef name='FLAG' type='UINT16'/></StructRef>\n"
    "<ParamRef name='END' type='INT8'/>\n"
    "</StructRef>\n"
    "<ParamRef name='NEXT' id='8' type='DOUBLE'/></Parameters>\n" // 15
    "<Configuration name='ONE' id='1' priority='1' samplingTime='1ms'>\n"
    "<Initial parameter='ALL' field='JOINT.LAST' value='99'/>\n"
    "<HKService id='1' interval='10'><SampledOnce><ParamRef name='ALL'/></SampledOnce></HKService>\n"
    "</Configuration></Subsystem>\n";

typedef struct {
    uint8_t first;
    struct {
        bool flag;
        struct {
            double current[2];
            struct {
                bool warm;
            } coil;
        } motor;
        uint16_t last;
        uint8_t small; // Directly after the field before, whatever the alignment of the structure is.
    } joint;
    struct {
        uint16_t flag;
    } tool;
    int8_t end;
} nested_t;

static void nested_structures_have_the_layout_of_the_compiler(void)
{
    static const struct {
        const char* name;
        size_t offset;
    } expected[] = {
        {"FIRST", offsetof(nested_t, first)},
        {"JOINT.FLAG", offsetof(nested_t, joint.flag)},
        {"JOINT.MOTOR.CURRENT", offsetof(nested_t, joint.motor.current)},
        {"JOINT.MOTOR.COIL.WARM", offsetof(nested_t, joint.motor.coil.warm)},
        {"JOINT.LAST", offsetof(nested_t, joint.last)},
        {"JOINT.SMALL", offsetof(nested_t, joint.small)},
        {"TOOL.FLAG", offsetof(nested_t, tool.flag)},
        {"END", offsetof(nested_t, end)},
    };
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(nested_document), descriptor_error(&loader));
    const descriptor_parameter_t* const all = descriptor_find_parameter(&arm, "ALL");
    TEST_ASSERT_EQUAL_UINT16(8U, all->field_count);
    TEST_ASSERT_EQUAL_UINT32(sizeof(nested_t), all->memory_size);
    TEST_ASSERT_EQUAL_UINT32(1U + 1U + 16U + 1U + 2U + 1U + 2U + 1U,
                             all->wire_size); // In the order of the file.
    for (uint16_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL_STRING(expected[i].name, arm.fields[all->first_field + i].name);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected[i].offset, arm.fields[all->first_field + i].offset,
                                         expected[i].name);
    }
    TEST_ASSERT_EQUAL_STRING("JOINT.LAST", arm.fields[arm.initials[0].field].name);
    TEST_ASSERT_EQUAL_STRING("NEXT", arm.fields[descriptor_find_parameter(&arm, "NEXT")->first_field].name);
    TEST_ASSERT_EQUAL_UINT32(all->wire_size, arm.structures[0].octets);
}

#define DEEPER(name, inside) "<StructRef name='" name "' type='STRUCT'>" inside "</StructRef>"

static void mistakes_in_nested_structures_are_reported(void)
{
    static const struct {
        const char* find;
        const char* replacement;
        unsigned line;
        const char* reason;
    } mistakes[] = {
        {"<ParamRef name='FLAG' type='UINT16'/>", "", 12U, "<StructRef> has no <ParamRef>"},
        {"<ParamRef name='WARM' type='BOOL'/>", "", 8U, "<StructRef> has no <ParamRef>"},
        {"name='TOOL'", "name='JOINT'", 12U, "name JOINT is taken in line 5"},
        {"<ParamRef name='FIRST' type='UINT8'/>", DEEPER("EMPTY", ""), 3U, "<StructRef> has no <ParamRef>"},
        {"name='TOOL'", "name='FIRST'", 12U, "name FIRST is taken in line 3"},
        {"name='END'", "name='JOINT'", 13U, "name JOINT is taken in line 5"},
        {"name='LAST'", "name='FLAG'", 10U, "name JOINT.FLAG is taken in line 5"},
        {"name='LAST'", "name='MOTOR'", 10U, "name JOINT.MOTOR is taken in line 7"},
        {"name='LAST'", "name='MOTOR.LAST'", 10U, "an upper-case identifier"},
        {"name='TOOL' type='STRUCT'", "name='TOOL' type='DOUBLE'", 12U, "one of STRUCT"},
        {"name='TOOL' type='STRUCT'", "name='TOOL' type='STRUCT' settable='true'", 12U,
         "attribute settable of <StructRef>"},
        {"field='JOINT.LAST'", "field='LAST'", 17U, "the name of a field"},
        {"field='JOINT.LAST' value='99'", "field='JOINT.LAST' value='101'", 17U, "within min and max"},
        {"<ParamRef name='WARM' type='BOOL'/>", DEEPER("DEEP", "<ParamRef name='A' type='INT8'/>"), 8U,
         "structures nested more than 3 deep"},
    };
    for (size_t i = 0U; i < (sizeof mistakes / sizeof mistakes[0]); i++) {
        char location[32];
        const char* const document = damaged(nested_document, mistakes[i].find, mistakes[i].replacement);
        (void)snprintf(location, sizeof location, "arm.xml:%u: ", mistakes[i].line);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, load(document), mistakes[i].reason);
        TEST_ASSERT_EQUAL_STRING_LEN(location, descriptor_error(&loader), strlen(location));
        if (strstr(descriptor_error(&loader), mistakes[i].reason) == NULL) {
            TEST_FAIL_MESSAGE(descriptor_error(&loader));
        }
    }
}

/// A group (a structure within a structure) may be the first element of the outer one, and one name may be
/// the beginning of another.
static void groups_may_be_anywhere_and_their_names_may_begin_alike(void)
{
    static const char* const good[][2] = {
        {"<ParamRef name='FIRST' type='UINT8'/>", ""},
        {"<ParamRef name='FIRST' type='UINT8'/>", DEEPER("ONLY", "<ParamRef name='ONE' type='UINT8'/>")},
        {"name='FIRST'", "name='TOOLS'"},
        {"name='END'", "name='JOIN'"},
    };
    for (size_t i = 0U; i < (sizeof good / sizeof good[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(damaged(nested_document, good[i][0], good[i][1])),
                                  descriptor_error(&loader));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(nested_structures_have_the_layout_of_the_compiler);
    RUN_TEST(mistakes_in_nested_structures_are_reported);
    RUN_TEST(groups_may_be_anywhere_and_their_names_may_begin_alike);
    return UNITY_END();
}
