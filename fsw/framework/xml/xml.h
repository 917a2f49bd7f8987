// SPDX-License-Identifier: Apache-2.0
/// Sequential XML parser on a static arena: checks that a document is well-formed and passes its elements,
/// one by one, to a handler. The handler checks their meaning.
///
/// Refused in addition to documents that are not well-formed: document type declarations (and with them
/// entities and external references), versions other than 1.0, encodings other than UTF-8, text between
/// elements, and documents that exceed the limits of depth, attributes, elements or octets.
///
/// Ownership  The parser borrows the arena; both outlive the document. expat allocates from the arena only;
///            the arena is emptied for each document. Strings passed to the handler are valid until it
///            returns.
/// Context    One document at a time in a thread (see the deviation in xml_arena.h).
/// Time       O(octets).
/// Errors     Each function lists every status; line, column and text of an error are kept in `error`.
#ifndef FSW_FRAMEWORK_XML_XML_H
#define FSW_FRAMEWORK_XML_XML_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

#define XML_ERROR_CHARACTERS 128U

#define XML_OCTETS_MAX (1U << 20U)
#define XML_ELEMENTS_MAX 20000U
#define XML_DEPTH_MAX 16U
#define XML_ATTRIBUTES_MAX 24U ///< Maximum number of attributes of an element.

/// An arena of this size holds every document within the limits [64-bit words].
#define XML_ARENA_WORDS 8192U

typedef struct {
    const char* name;
    const char* const* attributes; ///< name, value, name, value, .., NULL.
    uint32_t line;                 ///< Line in the document, from 1.
    uint32_t column;               ///< Column, from 1.
    uint16_t depth;                ///< 1 = the document element.
} xml_element_t;

/// Handler of a document. A status other than STATUS_OK stops the parser, and xml_feed returns it.
typedef struct {
    status_t (*start)(void* context, const xml_element_t* element);
    status_t (*end)(void* context, const char* name, uint32_t line);
    void* context;
} xml_handler_t;

typedef struct {
    uint32_t line; ///< 0 if the error has no position, because no document was begun.
    uint32_t column;
    char message[XML_ERROR_CHARACTERS];
} xml_error_t;

typedef struct { // Private.
    uint64_t* words;
    size_t capacity; // [octets]
    size_t used;     // [octets]
    size_t last;     // Offset of the newest block; only this block can grow in place.
} xml_arena_t;

typedef struct { // Private, except `error`: read-only.
    xml_arena_t arena;
    xml_handler_t handler;
    xml_error_t error;
    void* expat;
    status_t status;
    uint32_t octets;
    uint32_t elements;
    uint16_t depth;
} xml_parser_t;

/// Initialise a parser. arena_words >= 1024.
void xml_init(xml_parser_t* parser, uint64_t* arena, size_t arena_words);

/// Begin a document; the previous one is dropped. STATUS_OK, STATUS_EXHAUSTED (arena).
MUST_USE status_t xml_begin(xml_parser_t* parser, const xml_handler_t* handler);
/// Parse the next octets of the document, in pieces of any size; after an error the document stays refused.
/// STATUS_OK; STATUS_INVALID (not well-formed, or refused as above); STATUS_TOO_LARGE (a limit);
/// STATUS_EXHAUSTED (arena); STATUS_CLOSED (no document was begun, or it is finished); or the status that the
/// handler returned.
MUST_USE status_t xml_feed(xml_parser_t* parser, const void* octets, size_t size);
/// End the document. Statuses of xml_feed, and STATUS_TRUNCATED (an element, or the document, is not
/// closed).
MUST_USE status_t xml_finish(xml_parser_t* parser);

/// Returns the value of an attribute, or NULL if the element does not have it.
const char* xml_attribute(const xml_element_t* element, const char* name);

#endif // FSW_FRAMEWORK_XML_XML_H
