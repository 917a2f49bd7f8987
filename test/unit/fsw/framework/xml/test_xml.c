// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"
#include "fsw/framework/xml/xml.h"
#include "unity.h"

#include <expat.h>

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define UNTOUCHED 0xA5A5A5A5A5A5A5A5ULL

static uint64_t arena[XML_ARENA_WORDS];
static xml_parser_t parser;
static char trace[4096];
static uint32_t refuse_at; ///< Element to refuse, 1..; 0 = none.
static uint32_t started;

static status_t on_start(void* const context, const xml_element_t* const element)
{
    char entry[256];
    (void)context;
    started++;
    (void)snprintf(entry, sizeof entry, "<%s@%u.%u#%u", element->name, (unsigned)element->line,
                   (unsigned)element->column, (unsigned)element->depth);
    (void)strncat(trace, entry, sizeof trace - strlen(trace) - 1U);
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        (void)snprintf(entry, sizeof entry, " %s=%s", element->attributes[i], element->attributes[i + 1U]);
        (void)strncat(trace, entry, sizeof trace - strlen(trace) - 1U);
    }
    return (started == refuse_at) ? STATUS_OUT_OF_RANGE : STATUS_OK;
}

static status_t on_end(void* const context, const char* const name, const uint32_t line)
{
    char entry[64];
    (void)context;
    (void)snprintf(entry, sizeof entry, ">%s@%u", name, (unsigned)line);
    (void)strncat(trace, entry, sizeof trace - strlen(trace) - 1U);
    return STATUS_OK;
}

static const xml_handler_t handler = {on_start, on_end, NULL};

void setUp(void)
{
    xml_init(&parser, arena, XML_ARENA_WORDS);
    refuse_at = 0U;
}

void tearDown(void)
{
}

/// Parse the whole document in pieces of `piece` octets.
static status_t parse_pieces(const char* const octets, const size_t size, const size_t piece)
{
    trace[0]        = '\0';
    started         = 0U;
    status_t status = xml_begin(&parser, &handler);
    for (size_t done = 0U; (status == STATUS_OK) && (done < size); done += piece) {
        status = xml_feed(&parser, &octets[done], ((size - done) < piece) ? (size - done) : piece);
    }
    return (status == STATUS_OK) ? xml_finish(&parser) : status;
}

static status_t parse(const char* const document)
{
    return parse_pieces(document, strlen(document), strlen(document) + 1U);
}

static const char sample[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- note -->\n<A one='1' two=\"&lt;2&gt;\">\n"
    "  <B/>\n  <B x=''><C/></B>\n</A>\n";
static const char sample_trace[] = "<A@3.1#1 one=1 two=<2><B@4.3#2>B@4<B@5.3#2 x=<C@5.11#3>C@5>B@5>A@6";

static void elements_attributes_and_lines_are_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parse(sample));
    TEST_ASSERT_EQUAL_STRING(sample_trace, trace);
}

static void the_size_of_pieces_does_not_change_the_result(void)
{
    for (size_t piece = 1U; piece <= sizeof sample; piece++) {
        TEST_ASSERT_EQUAL(STATUS_OK, parse_pieces(sample, sizeof sample - 1U, piece));
        TEST_ASSERT_EQUAL_STRING(sample_trace, trace);
    }
}

static void attributes_are_found_by_name(void)
{
    const char* const attributes[] = {"one", "1", "two", "2", NULL};
    const xml_element_t element    = {.name = "A", .attributes = attributes};
    TEST_ASSERT_EQUAL_STRING("2", xml_attribute(&element, "two"));
    TEST_ASSERT_NULL(xml_attribute(&element, "tw"));
}

static void a_document_cut_at_every_octet_is_an_error_not_a_crash(void)
{
    const size_t end = strlen(sample) - 1U; // Without the last line feed the document is complete.
    for (size_t size = 0U; size < end; size++) {
        const status_t status = parse_pieces(sample, size, 7U);
        TEST_ASSERT_TRUE((status == STATUS_TRUNCATED) || (status == STATUS_INVALID));
        TEST_ASSERT_NOT_EQUAL(0, parser.error.message[0]);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, parse_pieces(sample, end, 7U));
}

static void malformed_documents_are_refused_with_the_line(void)
{
    static const struct {
        const char* document;
        unsigned line;
    } cases[] = {
        {"<A>\n<B>\n</A>", 3U},
        {"<A>\n</A>\n<B/>", 3U},
        {"<A x=1/>", 1U},
        {"\n<A x='1' x='2'/>", 2U},
        {"<A>\n&nothing;\n</A>", 2U},
        {"<A>\n&#0;</A>", 2U},
        {"text", 1U},
        {"<A>\n\x01</A>", 2U},
        {"<A\n<B/>", 2U},
        {"<A>\n\xC3\x28</A>", 2U},
        {"<A b='\xE4'/>", 1U},
        {"<A>\n\xED\xA0\x80</A>", 2U},
        {"<A>\n\xF8\x88\x80\x80\x80</A>", 2U},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, parse(cases[i].document), cases[i].document);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(cases[i].line, parser.error.line, cases[i].document);
        TEST_ASSERT_NOT_EQUAL(0U, parser.error.column);
    }
}

static void text_between_elements_is_refused_and_space_is_not(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parse("<A> \t\r\n </A>"));
    TEST_ASSERT_EQUAL(STATUS_OK, parse("<A>&#13;&#9;&#32;<![CDATA[ ]]></A>"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<A><![CDATA[x]]></A>"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<A>\n\n x</A>"));
    TEST_ASSERT_EQUAL_STRING("text between elements", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<A><![CDATA[x]]></A>"));
}

static void encodings_other_than_utf8_are_refused(void)
{
    static const char utf16[]   = "\xFF\xFE<\0A\0/\0>\0";
    static const char utf16be[] = "\xFE\xFF\0<\0A\0/\0>";
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<?xml version='1.0' encoding='ISO-8859-1'?><A/>"));
    TEST_ASSERT_EQUAL_STRING("encoding: expected UTF-8", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<?xml version='1.0' encoding='UTF-16'?><A/>"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse_pieces(utf16, sizeof utf16 - 1U, 64U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse_pieces(utf16be, sizeof utf16be - 1U, 1U));
    TEST_ASSERT_EQUAL_STRING("encoding: expected UTF-8", parser.error.message);
    static const char* const nearly[] = {"utf", "utf-", "utf-8x", "utf-16", "u", "UTF8"};
    for (size_t i = 0U; i < (sizeof nearly / sizeof nearly[0]); i++) {
        char document[64];
        (void)snprintf(document, sizeof document, "<?xml version='1.0' encoding='%s'?><A/>", nearly[i]);
        TEST_ASSERT_EQUAL(STATUS_INVALID, parse(document));
        TEST_ASSERT_NOT_NULL(strstr(parser.error.message, ": expected UTF-8"));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, parse("<?xml version='1.0'?><A/>"));
    TEST_ASSERT_EQUAL(STATUS_OK, parse("<?xml version='1.0' encoding='utf-8'?><A/>"));
    TEST_ASSERT_EQUAL(STATUS_OK, parse("\xEF\xBB\xBF<A x='\xC3\xA4'/>"));
    // The byte order mark counts as a column.
    TEST_ASSERT_EQUAL_STRING("<A@1.2#1 x=\xC3\xA4>A@1", trace);
}

static void unknown_versions_are_refused(void)
{
    static const char* const versions[] = {"2", "1", "1.1", "", "one", "1.00"};
    for (size_t i = 0U; i < (sizeof versions / sizeof versions[0]); i++) {
        char document[64];
        (void)snprintf(document, sizeof document, "<?xml version='%s'?>\n<A/>", versions[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, parse(document), versions[i]);
        TEST_ASSERT_EQUAL_UINT32(1U, parser.error.line);
    }
    TEST_ASSERT_EQUAL_STRING("version: expected 1.0", parser.error.message);
}

static void octets_before_the_beginning_and_after_the_end_are_refused(void)
{
    xml_init(&parser, arena, XML_ARENA_WORDS);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, xml_feed(&parser, "<A/>", 4U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, xml_finish(&parser));
    TEST_ASSERT_EQUAL(STATUS_OK, parse("<A/>"));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, xml_feed(&parser, "<A/>", 4U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, xml_finish(&parser));
}

static void document_type_declarations_and_entities_are_refused(void)
{
    TEST_ASSERT_EQUAL(
        STATUS_INVALID,
        parse("<!DOCTYPE A [<!ENTITY a 'ha'><!ENTITY b '&a;&a;&a;'><!ENTITY c '&b;&b;&b;'>]><A>&c;</A>"));
    TEST_ASSERT_EQUAL_STRING("document type declarations are not allowed", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<!DOCTYPE A SYSTEM 'file:///etc/passwd'><A/>"));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      parse("<!DOCTYPE A [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><A b='&x;'/>"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("<!DOCTYPE A><A/>"));
}

static void a_hundred_thousand_nested_elements_are_refused(void)
{
    static char document[300001];
    for (size_t i = 0U; i < 300000U; i += 3U) {
        memcpy(&document[i], "<A>", 3U);
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parse(document));
    TEST_ASSERT_EQUAL_STRING("elements are nested too deep, at most 16", parser.error.message);
    TEST_ASSERT_EQUAL_UINT32(16U, started);
}

/// Parse a document of exactly this number of octets: <A>, spaces, </A>.
static status_t parse_octets(const size_t octets)
{
    static char document[XML_OCTETS_MAX + 2U];
    (void)memset(document, ' ', octets);
    (void)memcpy(document, "<A>", 3U);
    (void)memcpy(&document[octets - 4U], "</A>", 4U);
    document[octets] = '\0';
    return parse(document);
}

/// Parse a document element with this number of elements in it.
static status_t parse_elements(const uint32_t inner)
{
    static char document[(XML_ELEMENTS_MAX * 4U) + 8U];
    text_t text = text_in(document, sizeof document);
    text_add(&text, "<A>");
    for (uint32_t i = 0U; i < inner; i++) {
        text_add(&text, "<B/>");
    }
    text_add(&text, "</A>");
    TEST_ASSERT_FALSE(text.cut);
    return parse(document);
}

/// Parse an element with this number of attributes at this depth.
static status_t parse_nested(const uint32_t depth, const uint32_t attributes)
{
    static char document[512];
    text_t text = text_in(document, sizeof document);
    for (uint32_t i = 1U; i < depth; i++) {
        text_add(&text, "<A>");
    }
    text_add(&text, "<A");
    for (uint32_t i = 0U; i < attributes; i++) {
        text_add(&text, " a");
        text_add_unsigned(&text, i);
        text_add(&text, "=''");
    }
    text_add(&text, "/>");
    for (uint32_t i = 1U; i < depth; i++) {
        text_add(&text, "</A>");
    }
    TEST_ASSERT_FALSE(text.cut);
    return parse(document);
}

static void each_limit_may_be_reached_and_not_exceeded(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parse_octets(XML_OCTETS_MAX));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parse_octets(XML_OCTETS_MAX + 1U));
    TEST_ASSERT_EQUAL_STRING("the document has too many octets, at most 1048576", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_OK, parse_elements(XML_ELEMENTS_MAX - 1U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parse_elements(XML_ELEMENTS_MAX));
    TEST_ASSERT_EQUAL_STRING("too many elements, at most 20000", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_OK, parse_nested(XML_DEPTH_MAX, XML_ATTRIBUTES_MAX));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parse_nested(XML_DEPTH_MAX + 1U, 0U));
    TEST_ASSERT_EQUAL_STRING("elements are nested too deep, at most 16", parser.error.message);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parse_nested(1U, XML_ATTRIBUTES_MAX + 1U));
    TEST_ASSERT_EQUAL_STRING("too many attributes, at most 24", parser.error.message);
}

/// A hundred megabytes that are never in memory at once: the limit of octets ends the parsing.
static void a_document_of_a_hundred_megabytes_is_refused(void)
{
    static char spaces[65536];
    memset(spaces, ' ', sizeof spaces);
    TEST_ASSERT_EQUAL(STATUS_OK, xml_begin(&parser, &handler));
    TEST_ASSERT_EQUAL(STATUS_OK, xml_feed(&parser, "<A>", 3U));
    status_t status = STATUS_OK;
    size_t fed      = 0U;
    while ((status == STATUS_OK) && (fed < 100000000U)) {
        status = xml_feed(&parser, spaces, sizeof spaces);
        fed += sizeof spaces;
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, status);
    TEST_ASSERT_LESS_OR_EQUAL_UINT64((1U << 20U) + sizeof spaces, fed);
}

/// A name or a value longer than any arena is an error and causes no crash.
static void a_token_without_end_is_refused(void)
{
    static char letters[4096];
    memset(letters, 'x', sizeof letters);
    for (unsigned kind = 0U; kind < 2U; kind++) {
        TEST_ASSERT_EQUAL(STATUS_OK, xml_begin(&parser, &handler));
        status_t status = xml_feed(&parser, (kind == 0U) ? "<" : "<A b='", (kind == 0U) ? 1U : 6U);
        for (unsigned i = 0U; (i < 256U) && (status == STATUS_OK); i++) {
            status = xml_feed(&parser, letters, sizeof letters);
        }
        TEST_ASSERT_TRUE((status == STATUS_EXHAUSTED) || (status == STATUS_TOO_LARGE));
    }
}

static void parsing_stops_where_the_handler_refuses(void)
{
    refuse_at = 3U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, parse(sample));
    TEST_ASSERT_EQUAL_UINT32(3U, started);
    TEST_ASSERT_EQUAL_UINT32(5U, parser.error.line);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, xml_feed(&parser, "<Z/>", 4U)); // The first error is final.
    refuse_at = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, parse(sample)); // The next document clears it.
    TEST_ASSERT_EQUAL_UINT32(0U, parser.error.line);
}

/// Arenas in steps of 16 words, from one in which the first allocation fails to one in which none fails.
static void an_arena_of_any_size_parses_the_document_or_is_reported_as_used_up(void)
{
    unsigned refused = 0U;
    for (size_t words = 1024U; words < XML_ARENA_WORDS; words += 16U) {
        for (size_t i = words; i < XML_ARENA_WORDS; i++) {
            arena[i] = UNTOUCHED;
        }
        xml_init(&parser, arena, words);
        const status_t status = parse_pieces(sample, sizeof sample - 1U, 16U);
        TEST_ASSERT_TRUE((status == STATUS_EXHAUSTED) || (status == STATUS_OK));
        TEST_ASSERT_EACH_EQUAL_HEX64(UNTOUCHED, &arena[words], XML_ARENA_WORDS - words);
        refused += (status == STATUS_EXHAUSTED) ? 1U : 0U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, refused);
    TEST_ASSERT_LESS_THAN_UINT32(447U, refused);
}

static void an_arena_can_begin_at_an_odd_word(void)
{
    xml_init(&parser, &arena[1], XML_ARENA_WORDS - 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, parse(sample));
    TEST_ASSERT_EQUAL_STRING(sample_trace, trace);
}

static void many_documents_need_no_more_memory_than_one(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parse(sample));
    const size_t used = parser.arena.used;
    for (unsigned i = 0U; i < 1000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, parse(sample));
    }
    TEST_ASSERT_EQUAL_UINT64(used, parser.arena.used);
}

/// Random damage to a correct document: the parser may accept or refuse it, but must not crash or leave the
/// bounds of the arena (also under ASan).
static void random_damage_never_crashes_the_parser(void)
{
    static char document[sizeof sample];
    uint32_t random = 0xC0FFEEU;
    for (unsigned i = 0U; i < 50000U; i++) {
        memcpy(document, sample, sizeof sample);
        for (unsigned n = 0U; n < (1U + (i % 4U)); n++) {
            random                                          = (random * 1664525U) + 1013904223U;
            document[(random >> 8U) % (sizeof sample - 1U)] = (char)(random >> 24U);
        }
        (void)parse_pieces(document, sizeof sample - 1U, 1U + (i % 64U));
    }
}

static void a_cut_is_distinguished_from_an_error(void)
{
    static const struct {
        const char* document;
        status_t status;
    } cases[] = {{"", STATUS_TRUNCATED},           {"<A>", STATUS_TRUNCATED},
                 {"<A><B/", STATUS_TRUNCATED},     {"<A><![CDATA[ ", STATUS_TRUNCATED},
                 {"<A x='\xC3", STATUS_TRUNCATED}, {"<A>\xC3", STATUS_TRUNCATED},
                 {"<A/>&", STATUS_INVALID},        {"<A></B>", STATUS_INVALID},
                 {"<A/><B/>", STATUS_INVALID}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].status, parse(cases[i].document), cases[i].document);
        TEST_ASSERT_EQUAL_STRING_LEN("not well-formed: ", parser.error.message, 17U);
        TEST_ASSERT_EQUAL_STRING(XML_ErrorString(XML_GetErrorCode(parser.expat)), &parser.error.message[17]);
        TEST_ASSERT_EQUAL(cases[i].status, xml_finish(&parser)); // The first result is kept.
        TEST_ASSERT_EQUAL(cases[i].status, xml_feed(&parser, "<A/>", 4U));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(elements_attributes_and_lines_are_reported);
    RUN_TEST(the_size_of_pieces_does_not_change_the_result);
    RUN_TEST(attributes_are_found_by_name);
    RUN_TEST(a_document_cut_at_every_octet_is_an_error_not_a_crash);
    RUN_TEST(malformed_documents_are_refused_with_the_line);
    RUN_TEST(text_between_elements_is_refused_and_space_is_not);
    RUN_TEST(encodings_other_than_utf8_are_refused);
    RUN_TEST(unknown_versions_are_refused);
    RUN_TEST(octets_before_the_beginning_and_after_the_end_are_refused);
    RUN_TEST(a_cut_is_distinguished_from_an_error);
    RUN_TEST(document_type_declarations_and_entities_are_refused);
    RUN_TEST(a_hundred_thousand_nested_elements_are_refused);
    RUN_TEST(each_limit_may_be_reached_and_not_exceeded);
    RUN_TEST(a_document_of_a_hundred_megabytes_is_refused);
    RUN_TEST(a_token_without_end_is_refused);
    RUN_TEST(parsing_stops_where_the_handler_refuses);
    RUN_TEST(an_arena_of_any_size_parses_the_document_or_is_reported_as_used_up);
    RUN_TEST(an_arena_can_begin_at_an_odd_word);
    RUN_TEST(many_documents_need_no_more_memory_than_one);
    RUN_TEST(random_damage_never_crashes_the_parser);
    return UNITY_END();
}
