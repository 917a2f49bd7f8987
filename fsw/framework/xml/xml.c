// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/xml/xml.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/xml/xml_arena.h"

#include <expat.h>
#include <stdbool.h>
#include <string.h>

#define ARENA_WORDS_MIN 1024U
#define PIECE_OCTETS 4096U

void xml_init(xml_parser_t* const parser, uint64_t* const arena, const size_t arena_words)
{
    FSW_ASSERT((parser != NULL) && (arena != NULL) && (arena_words >= ARENA_WORDS_MIN));
    *parser       = (xml_parser_t){.status = STATUS_CLOSED};
    parser->arena = (xml_arena_t){.words = arena, .capacity = arena_words * sizeof(uint64_t)};
}

/// Store the first error with its position, and stop expat.
static void refuse(xml_parser_t* const parser, const status_t status, const char* const message)
{
    if (parser->status != STATUS_OK) {
        return;
    }
    parser->status       = status;
    parser->error.line   = (uint32_t)XML_GetCurrentLineNumber(parser->expat);
    parser->error.column = (uint32_t)XML_GetCurrentColumnNumber(parser->expat) + 1U;
    text_t text          = text_in(parser->error.message, sizeof parser->error.message);
    text_add(&text, message);
    (void)XML_StopParser(parser->expat, XML_FALSE);
}

static void refuse_beyond(xml_parser_t* const parser, const char* const what, const uint64_t limit)
{
    char message[XML_ERROR_CHARACTERS];
    text_t text = text_in(message, sizeof message);
    text_add(&text, what);
    text_add(&text, ", at most ");
    text_add_unsigned(&text, limit);
    refuse(parser, STATUS_TOO_LARGE, message);
}

static void XMLCALL on_start(void* const context, const XML_Char* const name,
                             const XML_Char** const attributes)
{
    xml_parser_t* const parser = context;
    if (parser->status != STATUS_OK) {
        return;
    }
    parser->depth++;
    parser->elements++;
    const uint32_t count = (uint32_t)XML_GetSpecifiedAttributeCount(parser->expat) / 2U;
    if (parser->depth > XML_DEPTH_MAX) {
        refuse_beyond(parser, "elements are nested too deep", XML_DEPTH_MAX);
    } else if (parser->elements > XML_ELEMENTS_MAX) {
        refuse_beyond(parser, "too many elements", XML_ELEMENTS_MAX);
    } else if (count > XML_ATTRIBUTES_MAX) {
        refuse_beyond(parser, "too many attributes", XML_ATTRIBUTES_MAX);
    } else {
        const xml_element_t element = {.name       = name,
                                       .attributes = (const char* const*)attributes,
                                       .line       = (uint32_t)XML_GetCurrentLineNumber(parser->expat),
                                       .column     = (uint32_t)XML_GetCurrentColumnNumber(parser->expat) + 1U,
                                       .depth      = parser->depth};
        const status_t status       = parser->handler.start(parser->handler.context, &element);
        if (status != STATUS_OK) {
            refuse(parser, status, "refused by the reader");
        }
    }
}

static void XMLCALL on_end(void* const context, const XML_Char* const name)
{
    xml_parser_t* const parser = context;
    if (parser->status != STATUS_OK) {
        return;
    }
    parser->depth--;
    const uint32_t line   = (uint32_t)XML_GetCurrentLineNumber(parser->expat);
    const status_t status = parser->handler.end(parser->handler.context, name, line);
    if (status != STATUS_OK) {
        refuse(parser, status, "refused by the reader");
    }
}

static void XMLCALL on_text(void* const context, const XML_Char* const text, const int length)
{
    xml_parser_t* const parser = context;
    for (int i = 0; i < length; i++) {
        const char character = text[i];
        if ((character != ' ') && (character != '\t') && (character != '\r') && (character != '\n')) {
            refuse(parser, STATUS_INVALID, "text between elements");
            return;
        }
    }
}

static void XMLCALL on_doctype(void* const context, const XML_Char* const name, const XML_Char* const system,
                               const XML_Char* const public, const int has_internal_subset)
{
    (void)name;
    (void)system;
    (void)public;
    (void)has_internal_subset;
    refuse(context, STATUS_INVALID, "document type declarations are not allowed");
}

/// True for "UTF-8" in upper or lower case.
static bool is_utf8(const char* const encoding)
{
    static const char wanted[] = "utf-8";
    size_t i                   = 0U;
    while ((i < (sizeof wanted - 1U)) && (encoding[i] != '\0') &&
           ((encoding[i] == wanted[i]) || ((encoding[i] + ('a' - 'A')) == wanted[i]))) {
        i++;
    }
    return (i == (sizeof wanted - 1U)) && (encoding[i] == '\0');
}

static void XMLCALL on_declaration(void* const context, const XML_Char* const version,
                                   const XML_Char* const encoding, const int standalone)
{
    (void)standalone;
    if (strcmp(version, "1.0") != 0) { // expat accepts any version.
        refuse(context, STATUS_INVALID, "version: expected 1.0");
    }
    if ((encoding != NULL) && !is_utf8(encoding)) {
        refuse(context, STATUS_INVALID, "encoding: expected UTF-8");
    }
}

static void fail_without_place(xml_parser_t* const parser, const status_t status, const char* const message)
{
    parser->status     = status;
    parser->error.line = 0U;
    text_t text        = text_in(parser->error.message, sizeof parser->error.message);
    text_add(&text, message);
}

status_t xml_begin(xml_parser_t* const parser, const xml_handler_t* const handler)
{
    FSW_ASSERT((parser != NULL) && (handler != NULL));
    FSW_ASSERT((handler->start != NULL) && (handler->end != NULL));
    static const XML_Memory_Handling_Suite memory = {xml_arena_take, xml_arena_resize, xml_arena_give};
    parser->handler                               = *handler;
    parser->error                                 = (xml_error_t){.line = 0U};
    parser->status                                = STATUS_OK;
    parser->octets                                = 0U;
    parser->elements                              = 0U;
    parser->depth                                 = 0U;
    xml_arena_reset(&parser->arena);
    xml_arena_enter(&parser->arena);
    XML_Parser const expat = XML_ParserCreate_MM("UTF-8", &memory, NULL);
    parser->expat          = expat;
    if (expat != NULL) {
        // The salt is fixed, so that hashing is the same in each run. A hostile document with colliding
        // names slows down only its own parsing.
        (void)XML_SetHashSalt(expat, 1UL);
        XML_SetUserData(expat, parser);
        XML_SetElementHandler(expat, on_start, on_end);
        XML_SetCharacterDataHandler(expat, on_text);
        XML_SetStartDoctypeDeclHandler(expat, on_doctype);
        XML_SetXmlDeclHandler(expat, on_declaration);
    } else {
        fail_without_place(parser, STATUS_EXHAUSTED, "the parser has too little memory");
    }
    xml_arena_leave();
    return parser->status;
}

/// Convert an error of expat to a status; an error that a handler has reported stays.
static void take_error(xml_parser_t* const parser, const bool is_final)
{
    const enum XML_Error code = XML_GetErrorCode(parser->expat);
    if (parser->status != STATUS_OK) {
        return;
    }
    if (code == XML_ERROR_NO_MEMORY) {
        refuse(parser, STATUS_EXHAUSTED, "the parser has too little memory");
    } else {
        const bool is_cut =
            is_final && ((code == XML_ERROR_NO_ELEMENTS) || (code == XML_ERROR_UNCLOSED_TOKEN) ||
                         (code == XML_ERROR_PARTIAL_CHAR) || (code == XML_ERROR_UNCLOSED_CDATA_SECTION));
        char message[XML_ERROR_CHARACTERS];
        text_t text = text_in(message, sizeof message);
        text_add(&text, "not well-formed: ");
        text_add(&text, XML_ErrorString(code));
        refuse(parser, is_cut ? STATUS_TRUNCATED : STATUS_INVALID, message);
    }
}

static void parse(xml_parser_t* const parser, const void* const octets, const size_t size,
                  const bool is_final)
{
    xml_arena_enter(&parser->arena);
    if (XML_Parse(parser->expat, octets, (int)size, is_final ? XML_TRUE : XML_FALSE) == XML_STATUS_ERROR) {
        take_error(parser, is_final);
    }
    xml_arena_leave();
}

status_t xml_feed(xml_parser_t* const parser, const void* const octets, const size_t size)
{
    FSW_ASSERT((parser != NULL) && ((octets != NULL) || (size == 0U)));
    const uint8_t* const bytes = octets;
    // expat stores the incomplete token at the end of a piece; small pieces limit the size of its buffer.
    for (size_t done = 0U; (done < size) && (parser->status == STATUS_OK);) {
        const size_t piece = ((size - done) < PIECE_OCTETS) ? (size - done) : PIECE_OCTETS;
        if (piece > (XML_OCTETS_MAX - parser->octets)) {
            refuse_beyond(parser, "the document has too many octets", XML_OCTETS_MAX);
        } else if ((parser->octets == 0U) && ((bytes[0] == 0xFEU) || (bytes[0] == 0xFFU))) {
            refuse(parser, STATUS_INVALID, "encoding: expected UTF-8");
        } else {
            parse(parser, &bytes[done], piece, false);
            parser->octets += (uint32_t)piece;
            done += piece;
        }
    }
    return parser->status;
}

status_t xml_finish(xml_parser_t* const parser)
{
    FSW_ASSERT(parser != NULL);
    if (parser->status == STATUS_OK) {
        parse(parser, "", 0U, true);
    }
    const status_t status = parser->status;
    if (status == STATUS_OK) {
        parser->status = STATUS_CLOSED;
    }
    return status;
}

const char* xml_attribute(const xml_element_t* const element, const char* const name)
{
    FSW_ASSERT((element != NULL) && (name != NULL));
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        if (strcmp(element->attributes[i], name) == 0) {
            return element->attributes[i + 1U];
        }
    }
    return NULL;
}
