// SPDX-License-Identifier: Apache-2.0
// A descriptor that needs something that the program lacks is refused with its line before the program
// starts.
#include "fsw/framework/subsystem/fitting.h"

#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/subsystem/subsystem_core.h"
#include "test/support/assertion.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_callbacks_t callbacks;
static subsystem_misfit_t misfit;
static char document[65536];
static size_t length;

static void add(const char* words)
{
    TEST_ASSERT_LESS_THAN_UINT64(sizeof document - length, strlen(words));
    (void)strcpy(&document[length], words);
    length += strlen(words);
}

static void add_numbered(const char* before, const char* after, unsigned count)
{
    for (unsigned i = 1U; i <= count; i++) {
        char number[12];
        (void)snprintf(number, sizeof number, "%u", i);
        add(before);
        add(number);
        add(after);
    }
}

static bool fits(void)
{
    add("</Subsystem>");
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK,
                              descriptor_parse_subsystem(&loader, "arm.xml", document, length, &descriptor),
                              descriptor_error(&loader));
    misfit = (subsystem_misfit_t){0U, "", 0U};
    return subsystem_fits(&descriptor, &callbacks, &misfit);
}

static void begin(void)
{
    length = 0U;
    add("<Subsystem name='ARM' id='16'>\n");
}

static void expect_misfit(uint32_t line, const char* reason)
{
    char characters[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error = text_in(characters, sizeof characters);
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED,
                      descriptor_refuse(&error, "", misfit.line, misfit.reason, misfit.most));
    TEST_ASSERT_EQUAL_STRING(reason, strchr(characters, ' ') + 1);
}

static void expect(bool is_good, uint32_t line, const char* reason)
{
    TEST_ASSERT_EQUAL_MESSAGE(is_good, fits(), misfit.reason);
    if (!is_good) {
        expect_misfit(line, reason);
    }
}

void setUp(void)
{
    descriptor_loader_init(&loader);
    (void)memset(&callbacks, 0, sizeof callbacks);
    begin();
}

void tearDown(void)
{
}

// ---- Services ----

static pus_device_port_t no_devices(void* self)
{
    (void)self;
    return (pus_device_port_t){0};
}

static void access_to_devices_needs_its_callback(void)
{
    add("<Services><Service type='4'/>\n<Service type='2'/></Services>");
    expect(false, 3U, "type=\"2\" of <Service>: expected a subsystem with the callback device_port");
    begin();
    add("<Services><Service type='4'/>\n<Service type='2'/></Services>");
    callbacks.device_port = no_devices;
    expect(true, 0U, "");
}

// ---- Functions ----
//
// Each test of a limit has two rounds: a descriptor at the limit fits; with one item `more` it is refused.

static void arguments_must_fit_the_program(void)
{
    for (unsigned more = 0U; more < 2U; more++) {
        begin();
        add("<Functions>");
        for (unsigned f = 1U; f <= 3U; f++) {
            char line[64];
            (void)snprintf(line, sizeof line, "\n<Function name='F%u' id='%u' states='*'>", f, f);
            add(line);
            for (unsigned i = 1U; i <= (32U + ((f == 3U) ? more : 0U)); i++) {
                (void)snprintf(line, sizeof line, "<Argument name='A%u' id='%u' type='INT8'/>", i, i);
                add(line);
            }
            add("</Function>");
        }
        add("</Functions>");
        expect(more == 0U, 5U, "too many <Argument> in one descriptor, at most 96");
    }
}

static void arguments_must_fit_with_their_padding(void)
{
    for (unsigned more = 0U; more < 2U; more++) {
        begin();
        add("<Functions>\n<Function name='F' id='1' states='*'><Argument name='A' id='1' type='DOUBLE' "
            "count='62'/>"
            "<Argument name='B' id='2' type='INT8'/><Argument name='C' id='3' type='DOUBLE'");
        add((more == 0U) ? "/>" : " count='2'/>");
        add("</Function></Functions>");
        expect(more == 0U, 3U, "too many octets of arguments in memory, at most 512");
    }
}

// ---- Housekeeping ----

#define PARAMETERS "<Parameters><ParamRef name='P' id='1' type='INT8'/></Parameters>"
#define CONFIGURATION "\n<Configuration name='C' id='1' priority='1' samplingTime='1ms'>\n"
#define ONCE "<SampledOnce><ParamRef name='P'/></SampledOnce>"

static void a_configuration_has_at_most_sixteen_structures(void)
{
    for (unsigned more = 0U; more < 2U; more++) {
        begin();
        add(PARAMETERS CONFIGURATION);
        add_numbered("<HKService id='", "' interval='1'>" ONCE "</HKService>", 16U + more);
        add("</Configuration>");
        expect(more == 0U, 3U, "too many <HKService> in one <Configuration>, at most 16");
    }
}

static void a_structure_has_at_most_eight_sets(void)
{
    for (unsigned more = 0U; more < 2U; more++) {
        begin();
        add("<Parameters>");
        for (unsigned i = 1U; i <= 9U; i++) {
            char line[64];
            (void)snprintf(line, sizeof line, "<ParamRef name='P%u' id='%u' type='INT8'/>", i, i);
            add(line);
        }
        add("</Parameters>" CONFIGURATION "<HKService id='1' interval='2'>");
        add_numbered("<SampledNREPTimes nrep='2'><ParamRef name='P", "'/></SampledNREPTimes>", 8U + more);
        add("</HKService></Configuration>");
        expect(more == 0U, 4U, "too many <SampledNREPTimes> in one <HKService>, at most 8");
    }
}

static void the_octets_of_a_structure_are_limited(void)
{
    for (unsigned more = 0U; more < 2U; more++) {
        begin();
        add("<Parameters><ParamRef name='P' id='1' type='DOUBLE' count='16'/><ParamRef name='Q' id='2' "
            "type='INT8'/></Parameters>" CONFIGURATION "<HKService id='1' interval='8'>");
        add((more == 0U) ? "" : "<SampledOnce><ParamRef name='Q'/></SampledOnce>");
        add("<SampledNREPTimes nrep='8'><ParamRef name='P'/></SampledNREPTimes></HKService></Configuration>");
        expect(more == 0U, 4U, "too many octets in one <HKService>, at most 1024");
    }
}

static void a_structure_that_is_too_long_is_refused_in_every_configuration(void)
{
    for (unsigned refused = 1U; refused <= 4U; refused++) {
        begin();
        add("<Parameters><ParamRef name='P' id='1' type='DOUBLE' count='129'/><ParamRef name='Q' id='2' "
            "type='INT8'/></Parameters>");
        // Two structures in each of two configurations; one structure is too long.
        for (unsigned i = 1U; i <= 4U; i++) {
            char line[256];
            (void)snprintf(line, sizeof line,
                           "%s\n<HKService id='%u' interval='1'><SampledOnce><ParamRef name='%s'/>"
                           "</SampledOnce></HKService>%s",
                           (i == 1U)   ? "<Configuration name='C' id='1' priority='1' samplingTime='1ms'>"
                           : (i == 3U) ? "<Configuration name='D' id='2' priority='1' samplingTime='1ms'>"
                                       : "",
                           i, (i == refused) ? "P" : "Q", ((i % 2U) == 0U) ? "</Configuration>" : "");
            add(line);
        }
        expect(false, 2U + refused, "too many octets in one <HKService>, at most 1024");
    }
}

// ---- Callback `fits` ----

static bool refuses(const subsystem_descriptor_t* given, subsystem_misfit_t* out_misfit)
{
    TEST_ASSERT_EQUAL_PTR(&descriptor, given);
    *out_misfit = (subsystem_misfit_t){7U, "no", 0U};
    return false;
}

static bool accepts(const subsystem_descriptor_t* given, subsystem_misfit_t* out_misfit)
{
    (void)given;
    (void)out_misfit;
    return true;
}

static void a_subsystem_can_refuse_its_descriptor(void)
{
    callbacks.fits = refuses;
    expect(false, 7U, "no");
    begin();
    callbacks.fits = accepts;
    expect(true, 0U, "");
}

static void the_refusal_is_an_error_with_file_and_line(void)
{
    char characters[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error = text_in(characters, sizeof characters);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, descriptor_refuse(&error, "arm.xml", 7U, "<Loop>", 12U));
    TEST_ASSERT_EQUAL_STRING("arm.xml:7: too many <Loop>, at most 12", characters);
    error = text_in(characters, sizeof characters);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, descriptor_refuse(&error, "arm.xml", 8U, "100 % of #1", 0U));
    TEST_ASSERT_EQUAL_STRING("arm.xml:8: 100 % of #1", characters);
}

// ---- Lists of a program with smaller capacities than the reader of descriptors ----

static descriptor_parameter_t parameters[SUBSYSTEM_PARAMETERS + 1U];
static descriptor_event_t events[SUBSYSTEM_EVENTS + 1U];
static descriptor_function_t functions[SUBSYSTEM_FUNCTIONS + 1U];
static descriptor_configuration_t configuration;

/// In each list the first item beyond the capacity is refused with its line; without these items the
/// descriptor fits.
static void lists_longer_than_those_of_the_program_are_refused(void)
{
    TEST_ASSERT_TRUE(fits());
    parameters[SUBSYSTEM_PARAMETERS].line = 11U;
    events[SUBSYSTEM_EVENTS].line         = 12U;
    functions[SUBSYSTEM_FUNCTIONS].line   = 13U;
    descriptor.parameters                 = parameters;
    descriptor.events                     = events;
    descriptor.functions                  = functions;
    descriptor.parameter_count            = (uint16_t)SUBSYSTEM_PARAMETERS + 1U;
    descriptor.event_count                = (uint16_t)SUBSYSTEM_EVENTS + 1U;
    descriptor.function_count             = (uint16_t)SUBSYSTEM_FUNCTIONS + 1U;
    TEST_ASSERT_FALSE(subsystem_fits(&descriptor, &callbacks, &misfit));
    expect_misfit(11U, "too many <ParamRef> in this program, at most 64");
    descriptor.parameter_count--;
    TEST_ASSERT_FALSE(subsystem_fits(&descriptor, &callbacks, &misfit));
    expect_misfit(12U, "too many <Event> in this program, at most 48");
    descriptor.event_count--;
    TEST_ASSERT_FALSE(subsystem_fits(&descriptor, &callbacks, &misfit));
    expect_misfit(13U, "too many <Function> in this program, at most 32");
    descriptor.function_count--;
    TEST_ASSERT_TRUE(subsystem_fits(&descriptor, &callbacks, &misfit));
}

static void fields_beyond_the_bounds_of_the_program_are_refused(void)
{
    TEST_ASSERT_TRUE(fits());
    (void)memset(parameters, 0, sizeof parameters);
    descriptor.parameters      = parameters;
    descriptor.parameter_count = 3U;
    parameters[0].field_count  = (uint16_t)SUBSYSTEM_BOUNDS - 1U;
    parameters[1].field_count  = 1U;
    TEST_ASSERT_TRUE(subsystem_fits(&descriptor, &callbacks, &misfit));
    parameters[1].field_count = 2U;
    parameters[1].line        = 21U;
    parameters[2].field_count = 1U;
    parameters[2].line        = 22U;
    TEST_ASSERT_FALSE(subsystem_fits(&descriptor, &callbacks, &misfit));
    expect_misfit(21U, "too many fields of all <ParamRef> in this program, at most 160");
}

static void loops_beyond_those_of_the_program_are_refused(void)
{
    TEST_ASSERT_TRUE(fits());
    configuration                  = (descriptor_configuration_t){.line = 31U, .loop_count = SUBSYSTEM_LOOPS};
    descriptor.configurations      = &configuration;
    descriptor.configuration_count = 1U;
    TEST_ASSERT_TRUE(subsystem_fits(&descriptor, &callbacks, &misfit));
    configuration.loop_count++;
    TEST_ASSERT_FALSE(subsystem_fits(&descriptor, &callbacks, &misfit));
    expect_misfit(31U, "too many <Loop> in one <Configuration>, at most 2");
}

static void check_without_a_descriptor(void)
{
    (void)subsystem_fits(NULL, &callbacks, &misfit);
}

static void a_null_descriptor_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(check_without_a_descriptor));
}

// ---- Devices ----

static void sense(void* self)
{
    (void)self;
}

static void devices_without_an_end_node_on_can_are_refused(void)
{
    static const char* const types[] = {
        "SHM' name='x",    "MQUEUE' name='x", "UDP' address='h' port='1", "TCP' address='h' port='1",
        "SERIAL' name='x", "FILE' name='x"};
    callbacks.sense = sense;
    for (size_t i = 0U; i < (sizeof types / sizeof types[0]); i++) {
        begin();
        add(CONFIGURATION "<Devices><Device name='D' type='x'>\n<Endnode type='");
        add(types[i]);
        add("'/></Device></Devices></Configuration>");
        expect(false, 5U, "type of <Endnode>: expected CAN");
    }
    begin();
    add(CONFIGURATION "<Devices>\n<Device name='D' type='x'/></Devices></Configuration>");
    expect(false, 5U, "<Device> has no <Endnode type=\"CAN\">");
    begin();
    add(CONFIGURATION "<Devices>\n<Device name='D' type='x'><Endnode type='CAN' bus='b' node='3'/></Device>"
                      "</Devices></Configuration>");
    expect(true, 0U, "");
}

static void a_subsystem_without_sense_callback_cannot_have_devices(void)
{
    add(CONFIGURATION "<Devices>\n<Device name='D' type='x'><Endnode type='CAN' bus='b' node='3'/></Device>"
                      "</Devices></Configuration>");
    expect(false, 5U, "<Device>: expected none, this subsystem has no devices");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(access_to_devices_needs_its_callback);
    RUN_TEST(arguments_must_fit_the_program);
    RUN_TEST(arguments_must_fit_with_their_padding);
    RUN_TEST(a_configuration_has_at_most_sixteen_structures);
    RUN_TEST(a_structure_has_at_most_eight_sets);
    RUN_TEST(the_octets_of_a_structure_are_limited);
    RUN_TEST(a_structure_that_is_too_long_is_refused_in_every_configuration);
    RUN_TEST(a_subsystem_can_refuse_its_descriptor);
    RUN_TEST(the_refusal_is_an_error_with_file_and_line);
    RUN_TEST(lists_longer_than_those_of_the_program_are_refused);
    RUN_TEST(fields_beyond_the_bounds_of_the_program_are_refused);
    RUN_TEST(loops_beyond_those_of_the_program_are_refused);
    RUN_TEST(a_null_descriptor_is_a_coding_error);
    RUN_TEST(devices_without_an_end_node_on_can_are_refused);
    RUN_TEST(a_subsystem_without_sense_callback_cannot_have_devices);
    return UNITY_END();
}
