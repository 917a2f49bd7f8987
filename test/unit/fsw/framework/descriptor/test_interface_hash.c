// SPDX-License-Identifier: Apache-2.0
// The two hashes of a subsystem descriptor: one of its interface, which is compiled into a program, and one
// of the complete descriptor.
#include "base/crc.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

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

static void load_valid(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(arm_document));
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
}

static void the_interface_hash_depends_on_the_interface_alone(void)
{
    static const char* const configuration[][2] = {
        {"init='0.5 -1'", "init='0.5 -2'"},       {"min='-1.5' max='1.5' s", "min='-1' max='1' s"},
        {"settable='true'", "settable='false'"},  {"interval='500'", "interval='1000'"},
        {"node='0x11'", "node='0x12'"},           {"severity='MEDIUM'><", "severity='LOW'><"},
        {"timeout='2s'", "timeout='3s'"},         {"unit='rad' init", "unit='deg' init"},
        {"staleAfter='3ms'", "staleAfter='4ms'"},
    };
    static const char* const interface[][2] = {
        {"name='ARM'", "name='LEG'"},
        {"id='16'", "id='18'"},
        {"name='STATE'", "name='STATUS'"},
        {"type='INT32'", "type='UINT32'"},
        {"id='1' type='UINT32'", "id='2' type='UINT32'"},
        {"name='LOST' id='1'", "name='LOST' id='4'"},
        {"name='JOINT'", "name='AXIS'"},
        {"name='STOP' id='2'", "name='HALT' id='2'"},
        {"id='7'", "id='8'"},
        {"name='COUPLED' id='2'", "name='COUPLED' id='3'"},
        {"name='HAND' id='2'", "name='HAND' id='3'"},
        {"<ParamRef name='COUNT'/></Event>", "</Event>"},
        // Change the last field of each list.
        {"name='FLAG'", "name='BRAKE'"},
        {"name='TARGET' id='1' type='DOUBLE'", "name='TARGET' id='1' type='FLOAT'"},
        {"name='TORQUE' type='DOUBLE'", "name='TORQUE' type='FLOAT'"},
        {"name='POSITION' id='1' type='DOUBLE'", "name='POSITION' id='2' type='DOUBLE'"},
        {"type='DOUBLE' count='2'/></Requires>", "type='DOUBLE' count='3'/></Requires>"},
        {"type='DOUBLE' count='2' unit='rad'/></Provides>", "type='FLOAT' count='2' unit='rad'/></Provides>"},
        {"<Provides name='ARM_STATE'", "<Provides name='ARM_STATUS'"},
    };
    load_valid();
    const uint64_t interface_hash     = arm.interface_hash;
    const uint64_t configuration_hash = arm.configuration_hash;
    for (size_t i = 0U; i < (sizeof configuration / sizeof configuration[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, configuration[i][0], configuration[i][1])));
        TEST_ASSERT_TRUE_MESSAGE(arm.interface_hash == interface_hash, configuration[i][1]);
        TEST_ASSERT_TRUE_MESSAGE(arm.configuration_hash != configuration_hash, configuration[i][1]);
    }
    for (size_t i = 0U; i < (sizeof interface / sizeof interface[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(damaged(arm_document, interface[i][0], interface[i][1])),
                                  descriptor_error(&loader));
        TEST_ASSERT_TRUE_MESSAGE(arm.interface_hash != interface_hash, interface[i][1]);
    }
}

/// A program that was compiled on another machine must have the same hash.
static void the_interface_hash_is_computed_from_the_lines_of_the_interface(void)
{
    static const char lines[] =
        "subsystem A 7\nparameter P 3 25\nfield P UINT8 4\nevent E 5\nfield V INT16 1\n"
        "event G 9\nsample P\nfunction F 6\nargument X 2 BOOL 1\n";
    TEST_ASSERT_EQUAL(STATUS_OK, load("<Subsystem name='A' id='7'/>"));
    TEST_ASSERT_EQUAL_HEX64(fnv64(FNV64_START, (const uint8_t*)lines, 14U), arm.interface_hash);
    TEST_ASSERT_EQUAL_UINT32(2U, arm.text_used); // Only the name remains as text.
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK,
        load("<Subsystem name='A' id='7'><Parameters><ParamRef name='P' id='3' type='UINT8' count='4'/>"
             "</Parameters><Events><Event name='E' id='5' severity='LOW'><ParamRef name='V' "
             "type='INT16'/></Event><Event name='G' id='9' severity='LOW'>"
             "<ParamRef name='P'/></Event></Events><Functions><Function name='F' id='6' states='*'>"
             "<Argument name='X' id='2' type='BOOL'/></Function></Functions></Subsystem>"),
        descriptor_error(&loader));
    TEST_ASSERT_EQUAL_HEX64(fnv64(FNV64_START, (const uint8_t*)lines, sizeof lines - 1U), arm.interface_hash);
}

static void hashes_ignore_comments_spaces_and_order_of_attributes(void)
{
    load_valid();
    const uint64_t interface_hash      = arm.interface_hash;
    const uint64_t configuration_hash  = arm.configuration_hash;
    static const char* const same[][2] = {
        {"<Events>", "<!-- events -->\n\n   <Events>"},
        {"poolWarning='80' poolClear='70'", "poolClear=\"70\"  poolWarning='80'"},
        {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='COUNT'></ParamRef></Event>"},
        {"<Subsystem ", "<?xml version='1.0'?><Subsystem "},
    };
    for (size_t i = 0U; i < (sizeof same / sizeof same[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, same[i][0], same[i][1])));
        TEST_ASSERT_TRUE(arm.interface_hash == interface_hash);
        TEST_ASSERT_TRUE(arm.configuration_hash == configuration_hash);
    }
}

static void a_component_compares_with_its_compiled_interface(void)
{
    char characters[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error = text_in(characters, sizeof characters);
    load_valid();
    TEST_ASSERT_EQUAL(STATUS_OK, descriptor_check_interface(&error, "arm.xml", &arm, arm.interface_hash));
    TEST_ASSERT_EQUAL_STRING("", characters);
    arm.interface_hash = 0x123456789ABCDEF0ULL;
    TEST_ASSERT_EQUAL(STATUS_CHECKSUM,
                      descriptor_check_interface(&error, "arm.xml", &arm, 0xFEDCBA9876543210ULL));
    TEST_ASSERT_EQUAL_STRING("arm.xml:1: interface hash: expected 0xFEDCBA9876543210 as compiled, found "
                             "0x123456789ABCDEF0: run make",
                             characters);
}

static void the_interface_hash_changes_with_each_number_of_a_service(void)
{
    static const char* const services[] = {"<Service type='12'/>", "<Service type='12' capacity='33'/>",
                                           "<Service type='12' functional='5'/>", "<Service type='4'/>",
                                           "<Service type='4'/><Service type='6'/>"};
    uint64_t hashes[6]                  = {0U};
    load_valid();
    hashes[5] = arm.interface_hash;
    for (size_t i = 0U; i < 5U; i++) {
        char replacement[128] = "</Functions><Services>";
        (void)strcat(strcat(replacement, services[i]), "</Services>");
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, "</Functions>", replacement)));
        hashes[i] = arm.interface_hash;
        for (size_t j = 0U; j < 6U; j++) {
            TEST_ASSERT_TRUE((i == j) || (hashes[i] != hashes[j]));
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_interface_hash_depends_on_the_interface_alone);
    RUN_TEST(the_interface_hash_is_computed_from_the_lines_of_the_interface);
    RUN_TEST(the_interface_hash_changes_with_each_number_of_a_service);
    RUN_TEST(hashes_ignore_comments_spaces_and_order_of_attributes);
    RUN_TEST(a_component_compares_with_its_compiled_interface);
    return UNITY_END();
}
