// SPDX-License-Identifier: Apache-2.0
// Some versions of expat call handlers again after XML_StopParser; the reader must ignore these calls. Here
// XML_StopParser is mocked and has no effect, so expat parses to the end.
#include "fsw/framework/xml/xml.h"

#include <expat.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static uint64_t arena[XML_ARENA_WORDS];
static xml_parser_t parser;

enum XML_Status __wrap_XML_StopParser(XML_Parser expat, XML_Bool is_resumable)
{
    (void)expat;
    (void)is_resumable;
    function_called();
    return XML_STATUS_OK;
}

static status_t on_start(void* const context, const xml_element_t* const element)
{
    (void)context;
    check_expected_ptr(element->name);
    return mock_type(status_t);
}

static status_t on_end(void* const context, const char* const name, const uint32_t line)
{
    (void)context;
    (void)line;
    check_expected_ptr(name);
    return STATUS_OK;
}

static const xml_handler_t handler = {on_start, on_end, NULL};

static void expect_start(const char* const name, const status_t status)
{
    expect_string(on_start, element->name, name);
    will_return(on_start, status);
}

static status_t parse(const char* const document)
{
    xml_init(&parser, arena, XML_ARENA_WORDS);
    status_t status = xml_begin(&parser, &handler);
    status          = (status == STATUS_OK) ? xml_feed(&parser, document, strlen(document)) : status;
    return (status == STATUS_OK) ? xml_finish(&parser) : status;
}

static void after_a_refusal_no_element_is_reported(void** state)
{
    (void)state;
    expect_start("A", STATUS_OK);
    expect_start("B", STATUS_OUT_OF_RANGE);
    expect_function_call_any(__wrap_XML_StopParser);
    assert_int_equal(STATUS_OUT_OF_RANGE, parse("<A>\n <B><C/></B>\n <D/></A>\n"));
    assert_int_equal(2U, parser.error.line);
}

static void text_after_a_refusal_does_not_change_the_line_of_the_error(void** state)
{
    (void)state;
    expect_start("A", STATUS_OK);
    expect_start("B", STATUS_OUT_OF_RANGE);
    expect_function_call_any(__wrap_XML_StopParser);
    assert_int_equal(STATUS_OUT_OF_RANGE, parse("<A>\n <B/>text\n</A>\n"));
    assert_int_equal(2U, parser.error.line);
    assert_int_equal(2U, parser.error.column);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(after_a_refusal_no_element_is_reported),
        cmocka_unit_test(text_after_a_refusal_does_not_change_the_line_of_the_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
