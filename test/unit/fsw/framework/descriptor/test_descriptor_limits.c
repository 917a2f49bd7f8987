// SPDX-License-Identifier: Apache-2.0
// Lists of a subsystem descriptor that are full or have one entry too many; limits of the parser; names that
// are too long together.
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t arm;
static char document[65536];
static size_t length;

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

static void add(const char* const words)
{
    TEST_ASSERT_LESS_THAN_UINT64(sizeof document - length, strlen(words));
    (void)strcpy(&document[length], words);
    length += strlen(words);
}

/// Add this line `count` times; %u in it becomes its number, from 1.
static void add_numbered(const char* const line, const unsigned count)
{
    for (unsigned i = 1U; i <= count; i++) {
        const char* const mark = strstr(line, "%u");
        for (const char* at = line; *at != '\0'; at++) {
            char piece[12] = {*at, '\0'};
            if ((mark != NULL) && (at[0] == '%') && (at[1] == 'u')) {
                (void)snprintf(piece, sizeof piece, "%u", i);
                at++;
            }
            add(piece);
        }
    }
}

static status_t load(void)
{
    return descriptor_parse_subsystem(&loader, "arm.xml", document, length, &arm);
}

#define CONFIGURATION "<Configuration name='C' id='1' priority='1' samplingTime='1ms'>"

static const struct {
    const char* before;
    const char* line;
    const char* after;
    unsigned most;
    const char* reason;
} lists[] = {
    {"<Parameters>", "<ParamRef name='P%u' id='%u' type='INT8'/>", "</Parameters>", DESCRIPTOR_PARAMETERS_MAX,
     "too many parameters, at most 64"},
    {"<Parameters><StructRef name='S' id='1' type='STRUCT'>", "<ParamRef name='F%u' type='INT8'/>",
     "</StructRef></Parameters>", DESCRIPTOR_FIELDS_MAX, "too many fields in one descriptor, at most 160"},
    {"<Events>", "<Event name='E%u' id='%u' severity='LOW'/>", "</Events>", DESCRIPTOR_EVENTS_MAX,
     "too many events, at most 48"},
    {"<Functions>", "<Function name='F%u' id='%u' states='*'/>", "</Functions>", DESCRIPTOR_FUNCTIONS_MAX,
     "too many functions, at most 32"},
    {"", "<Configuration name='C%u' id='%u' priority='1' samplingTime='1ms'/>", "",
     DESCRIPTOR_CONFIGURATIONS_MAX, "too many configurations, at most 8"},
    {CONFIGURATION "<Devices>", "<Device name='D%u' type='x'/>", "</Devices></Configuration>",
     DESCRIPTOR_DEVICES_MAX, "too many devices, at most 128"},
    {CONFIGURATION "<Devices><Device name='D' type='x'>",
     "<Setting object='0x6060:00' type='INT16' value='%u'/>", "</Device></Devices></Configuration>",
     DESCRIPTOR_SETTINGS_MAX, "too many <Setting>, at most 640"},
    {CONFIGURATION "<Devices><Device name='D' type='x'>", "<Endnode type='SHM' name='n%u'/>",
     "</Device></Devices></Configuration>", DESCRIPTOR_ENDNODES_MAX, "too many <Endnode>, at most 128"},
    {CONFIGURATION "<RTLinkService>",
     "<Provides name='P%u' id='%u' methods='UDP'><ParamRef name='A' type='INT8'/></Provides>",
     "</RTLinkService></Configuration>", DESCRIPTOR_PORTS_MAX, "too many ports, at most 16"},
    {"<Parameters><ParamRef name='P' id='1' type='INT8'/></Parameters>" CONFIGURATION,
     "<HKService id='%u' interval='1'><SampledOnce><ParamRef name='P'/></SampledOnce></HKService>",
     "</Configuration>", DESCRIPTOR_STRUCTURES_MAX, "too many <HKService>, at most 32"},
};

static void every_list_holds_its_stated_number_of_entries_and_no_more(void)
{
    for (size_t i = 0U; i < (sizeof lists / sizeof lists[0]); i++) {
        for (unsigned more = 0U; more < 2U; more++) {
            length = 0U;
            add("<Subsystem name='A' id='1'>");
            add(lists[i].before);
            add_numbered(lists[i].line, lists[i].most + more);
            add(lists[i].after);
            add("</Subsystem>");
            const status_t status = load();
            if (more == 0U) {
                TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
            } else {
                TEST_ASSERT_NOT_EQUAL(STATUS_OK, status);
                TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), lists[i].reason),
                                             descriptor_error(&loader));
            }
        }
    }
}

static void references_are_counted_over_all_elements(void)
{
    length = 0U;
    add("<Subsystem name='A' id='1'><Parameters>");
    add_numbered("<ParamRef name='P%u' id='%u' type='INT8'/>", DESCRIPTOR_PARAMETERS_MAX);
    add("</Parameters><Events>");
    for (unsigned event = 1U; event <= (DESCRIPTOR_REFERENCES_MAX / DESCRIPTOR_PARAMETERS_MAX); event++) {
        char line[64];
        (void)snprintf(line, sizeof line, "<Event name='E%u' id='%u' severity='LOW'>", event, event);
        add(line);
        add_numbered("<ParamRef name='P%u'/>", DESCRIPTOR_PARAMETERS_MAX);
        add("</Event>");
    }
    const size_t full = length;
    add("</Events></Subsystem>");
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(), descriptor_error(&loader));
    length = full;
    add("<Event name='E' id='99' severity='LOW'><ParamRef name='P1'/></Event></Events></Subsystem>");
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, load());
    TEST_ASSERT_EQUAL_STRING("arm.xml:1: too many references to parameters, at most 192",
                             descriptor_error(&loader));
}

/// A sample of the port has sixty octets, but the description of the port more than two thousand characters.
static void a_port_with_too_long_names_is_refused(void)
{
    length = 0U;
    add("<Subsystem name='A' id='1'>" CONFIGURATION
        "<RTLinkService>\n<Provides name='P' id='1' methods='UDP'>");
    add_numbered("<ParamRef name='AN_ELEMENT_WITH_A_LONG_NAME_%u' type='UINT8'/>", 60U);
    add("</Provides></RTLinkService></Configuration></Subsystem>");
    TEST_ASSERT_EQUAL(STATUS_INVALID, load());
    TEST_ASSERT_EQUAL_STRING("arm.xml:2: the names of the port's elements are too long together",
                             descriptor_error(&loader));
}

static void sizes_and_rates_beyond_their_limits_are_refused_with_the_line(void)
{
    static const struct {
        const char* body;
        const char* reason;
    } bodies[] = {
        {"<Parameters>\n<StructRef name='S' id='1' type='STRUCT'><ParamRef name='A' type='DOUBLE' "
         "count='256'/>"
         "<ParamRef name='B' type='DOUBLE' count='245'/></StructRef></Parameters>",
         "arm.xml:2: 4008 octets in one parameter, at most 4000"},
        {"<Events>\n<Event name='E' id='1' severity='LOW'><ParamRef name='A' type='DOUBLE' count='129'/>"
         "</Event></Events>",
         "arm.xml:2: 1032 octets of auxiliary data, at most 1024"},
        {"<Events><Event name='E' id='1' severity='HIGH'><ParamRef name='A' type='DOUBLE' "
         "count='125'/></Event>\n"
         "<Event name='F' id='2' severity='HIGH'><ParamRef name='A' type='UINT8' count='249'/>"
         "<ParamRef name='B' type='UINT8' count='249'/><ParamRef name='C' type='UINT8' count='249'/>"
         "<ParamRef name='D' type='UINT8' count='248'/></Event></Events>",
         "arm.xml:2: 2049 octets of reports of HIGH events, at most 2048"},
        {"<Events>\n<Event name='E' id='1' severity='HIGH' rate='10/s'/></Events>",
         "arm.xml:2: an <Event> of severity HIGH cannot have rate or burst"},
        {"<Events>\n<Event name='E' id='1' severity='HIGH' burst='1'/></Events>",
         "arm.xml:2: an <Event> of severity HIGH cannot have rate or burst"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='0/s'/></Events>",
         "arm.xml:2: rate=\"0/s\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='1001/s'/></Events>",
         "arm.xml:2: rate=\"1001/s\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='10'/></Events>",
         "arm.xml:2: rate=\"10\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='10:s'/></Events>",
         "arm.xml:2: rate=\"10:s\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='00010/s'/></Events>",
         "arm.xml:2: rate=\"00010/s\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' rate='10000/s'/></Events>",
         "arm.xml:2: rate=\"10000/s\" of <Event>: expected a rate like 10/s, from 1/s to 1000/s"},
        {"<Events>\n<Event name='E' id='1' severity='LOW' burst='256'/></Events>",
         "arm.xml:2: burst=\"256\" of <Event>: expected a number from 1 to 255"},
        {"<Functions>\n<Function name='F' id='1' states='*'><Argument name='A' id='1' type='DOUBLE' "
         "count='128'/></Function></Functions>",
         "arm.xml:2: 1026 octets of arguments, at most 1024"},
    };
    for (size_t i = 0U; i < (sizeof bodies / sizeof bodies[0]); i++) {
        length = 0U;
        add("<Subsystem name='A' id='1'>");
        add(bodies[i].body);
        add("</Subsystem>");
        TEST_ASSERT_EQUAL(STATUS_INVALID, load());
        TEST_ASSERT_EQUAL_STRING(bodies[i].reason, descriptor_error(&loader));
    }
}

static void reports_of_high_events_may_fill_their_reserved_octets(void)
{
    length = 0U;
    add("<Subsystem name='A' id='1'><Events>"
        "<Event name='E' id='1' severity='HIGH'><ParamRef name='A' type='DOUBLE' count='125'/></Event>"
        "<Event name='F' id='2' severity='HIGH'><ParamRef name='A' type='UINT8' count='249'/>"
        "<ParamRef name='B' type='UINT8' count='249'/><ParamRef name='C' type='UINT8' count='249'/>"
        "<ParamRef name='D' type='UINT8' count='247'/></Event>"
        "<Event name='G' id='3' severity='LOW' rate='1/s'><ParamRef name='A' type='DOUBLE' "
        "count='128'/></Event>"
        "<Event name='H' id='4' severity='MEDIUM' rate='1000/s' burst='255'/>"
        "<Event name='I' id='5' severity='INFORMATIVE'/></Events>" CONFIGURATION
        "</Configuration></Subsystem>");
    const status_t status = load();
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(0U, arm.events[0].per_second);
    TEST_ASSERT_EQUAL(1U, arm.events[2].per_second);
    TEST_ASSERT_EQUAL(1000U, arm.events[3].per_second);
    TEST_ASSERT_EQUAL(255U, arm.events[3].burst);
    TEST_ASSERT_EQUAL(10U, arm.events[4].per_second);
    TEST_ASSERT_EQUAL(20U, arm.events[4].burst);
}

/// Six texts of 901 octets and the names fit into 6144 octets; the seventh function, in line 8, does not.
static void texts_longer_than_the_model_can_hold_are_refused(void)
{
    char function[1000];
    char zeros[901];
    (void)memset(zeros, '0', sizeof zeros);
    zeros[sizeof zeros - 1U] = '\0';
    (void)snprintf(function, sizeof function,
                   "\n<Function name='F%%u' id='%%u' states='*' configurations='%s'/>", zeros);
    length = 0U;
    add("<Subsystem name='A' id='1'><Functions>");
    add_numbered(function, DESCRIPTOR_FUNCTIONS_MAX);
    add("</Functions></Subsystem>");
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, load());
    TEST_ASSERT_EQUAL_STRING("arm.xml:8: the texts of the file are too long together",
                             descriptor_error(&loader));
}

static void the_bounds_of_a_field_belong_to_its_range(void)
{
    const char* const text = damaged(arm_document, "value='0.25 0.5'", "value='-1.5 1.5'");
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK,
                              descriptor_parse_subsystem(&loader, "arm.xml", text, strlen(text), &arm),
                              descriptor_error(&loader));
}

static void a_port_may_be_in_several_configurations(void)
{
    static const char* const port =
        "<RTLinkService><Provides name='P' id='1' methods='UDP'><ParamRef name='X' "
        "type='DOUBLE'/></Provides></RTLinkService></Configuration>";
    length = 0U;
    add("<Subsystem name='A' id='1'><Configuration name='C' id='1' priority='1' samplingTime='1ms'>");
    add(port);
    add("<Configuration name='D' id='2' priority='1' samplingTime='2ms'>");
    add(port);
    add("</Subsystem>");
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(), descriptor_error(&loader));
    TEST_ASSERT_EQUAL_UINT16(2U, arm.port_count);
    TEST_ASSERT_EQUAL_UINT32(2000U, arm.ports[1].period_us);
}

/// The arena is first too small for the parser, then for the document, whose elements contain pointers. setUp
/// initialises the loader again.
static void an_arena_that_is_used_up_is_reported(void)
{
    loader.parser.arena.capacity = 1024U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, descriptor_parse_subsystem(&loader, "arm.xml", arm_document,
                                                                   strlen(arm_document), &arm));
    TEST_ASSERT_EQUAL_STRING("arm.xml:0: the parser has too little memory", descriptor_error(&loader));
    loader.parser.arena.capacity = sizeof(void*) * 1792U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, descriptor_parse_subsystem(&loader, "arm.xml", arm_document,
                                                                   strlen(arm_document), &arm));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), ": the parser has too little memory"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_list_holds_its_stated_number_of_entries_and_no_more);
    RUN_TEST(references_are_counted_over_all_elements);
    RUN_TEST(a_port_with_too_long_names_is_refused);
    RUN_TEST(sizes_and_rates_beyond_their_limits_are_refused_with_the_line);
    RUN_TEST(reports_of_high_events_may_fill_their_reserved_octets);
    RUN_TEST(texts_longer_than_the_model_can_hold_are_refused);
    RUN_TEST(the_bounds_of_a_field_belong_to_its_range);
    RUN_TEST(a_port_may_be_in_several_configurations);
    RUN_TEST(an_arena_that_is_used_up_is_reported);
    return UNITY_END();
}
