// SPDX-License-Identifier: Apache-2.0
// The XML parser receives arbitrary octets. A document in one piece and the same document in many pieces give
// the same result. If the document is well-formed, each element that begins also ends. The parser never uses
// more memory than its arena has.
#include "fsw/framework/xml/xml.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

typedef struct { // Calls of the handlers.
    uint64_t hash;
    uint32_t started;
    uint32_t ended;
    uint16_t depth;
} handler_calls_t;

static uint64_t arena[XML_ARENA_WORDS];
static xml_parser_t parser;

static void note(handler_calls_t* const calls, const char* const words)
{
    for (const char* at = words; *at != '\0'; at++) {
        calls->hash = (calls->hash ^ (uint8_t)*at) * 0x100000001B3ULL;
    }
}

static status_t start(void* const context, const xml_element_t* const element)
{
    handler_calls_t* const calls = (handler_calls_t*)context;
    calls->started++;
    calls->depth++;
    FUZZ_CHECK((element->depth == calls->depth) && (element->line >= 1U) && (element->column >= 1U));
    note(calls, element->name);
    for (unsigned i = 0U; element->attributes[i] != NULL; i++) {
        note(calls, element->attributes[i]);
        FUZZ_CHECK(((i % 2U) == 1U) || (element->attributes[i + 1U] != NULL));
    }
    return STATUS_OK;
}

static status_t end(void* const context, const char* const name, const uint32_t line)
{
    handler_calls_t* const calls = (handler_calls_t*)context;
    FUZZ_CHECK((calls->depth > 0U) && (line >= 1U));
    calls->ended++;
    calls->depth--;
    note(calls, name);
    return STATUS_OK;
}

static status_t parse(const uint8_t* const data, const size_t size, const size_t piece,
                      handler_calls_t* const calls)
{
    const xml_handler_t handler = {start, end, calls};
    *calls                      = (handler_calls_t){.hash = 0xCBF29CE484222325ULL};
    xml_init(&parser, arena, XML_ARENA_WORDS);
    status_t status = xml_begin(&parser, &handler);
    for (size_t at = 0U; (status == STATUS_OK) && (at < size); at += piece) {
        status = xml_feed(&parser, &data[at], ((size - at) < piece) ? (size - at) : piece);
    }
    status = (status == STATUS_OK) ? xml_finish(&parser) : status;
    FUZZ_CHECK(parser.arena.used <= parser.arena.capacity);
    FUZZ_CHECK((status == STATUS_OK) == (parser.error.message[0] == '\0'));
    FUZZ_CHECK(memchr(parser.error.message, '\0', XML_ERROR_CHARACTERS) != NULL);
    FUZZ_CHECK((status != STATUS_OK) || ((calls->started == calls->ended) && (calls->started > 0U)));
    FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_INVALID) || (status == STATUS_TOO_LARGE) ||
               (status == STATUS_EXHAUSTED) || (status == STATUS_TRUNCATED));
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    handler_calls_t whole;
    handler_calls_t pieces;
    const status_t status = parse(data, size, (size > 0U) ? size : 1U, &whole);
    if ((size > 0U) && (status != STATUS_EXHAUSTED)) {
        const size_t piece       = 1U + (data[size - 1U] % 7U);
        const status_t by_pieces = parse(data, size, piece, &pieces);
        if (by_pieces != STATUS_EXHAUSTED) { // A text in pieces may need more memory.
            FUZZ_CHECK((by_pieces == STATUS_OK) == (status == STATUS_OK));
            FUZZ_CHECK((status != STATUS_OK) || (whole.hash == pieces.hash));
        }
    }
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_document(data, size, max_size, seed);
}
