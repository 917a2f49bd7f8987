// SPDX-License-Identifier: Apache-2.0
/// Reading of a descriptor's elements: what may stand where, typed attributes, strings, hash, and errors.
/// Internal to descriptor/.
///
/// The first error is kept, with file and line, and makes every later call a no-op that returns its default;
/// a handler reads all it needs and its caller looks at `status` once. The canonical text, whose FNV-1a is
/// the configuration hash, is for each element "<name\n", its attributes sorted by name as "name=value\n",
/// its children, ">\n": comments, spaces between elements and the order of attributes do not count.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H
#define FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/base/text.h"
#include "fsw/framework/base/value.h"
#include "fsw/framework/xml/xml.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SOURCE_DEPTH_MAX 16U
#define SOURCE_ROOT 0U ///< Kind of the document itself, parent of its first element.

typedef struct source source_t;

typedef struct { // One element that may stand below a parent.
    uint8_t parent;
    const char* name;
    uint8_t kind;                    ///< >= 1; the parent of its children.
    const char* attributes;          ///< "name! id! unit": all that are known, '!' = must be there.
    void (*start)(source_t* source); ///< Or NULL.
    void (*end)(source_t* source);   ///< Or NULL.
} source_row_t;

struct source {
    const char* path;
    text_t* error;
    status_t status;
    const source_row_t* rows;
    size_t row_count;
    const xml_element_t* element; ///< Only inside `start`.
    uint32_t line;
    const source_row_t* open[SOURCE_DEPTH_MAX];
    uint32_t open_line[SOURCE_DEPTH_MAX];
    uint16_t depth;
    uint64_t hash;
    char* text; ///< The model's strings.
    uint32_t text_capacity;
    uint32_t* text_used;
    void* builder; ///< Of the handlers.
};

/// Handler for xml_begin over a source.
xml_handler_t source_handler(source_t* source);

/// Errors. `wrong` names the attribute's value and what is expected; `fail` begins a text at a line, to which
/// more may be added with text_add(source->error, ..) if it returns true (this is the first error).
void source_wrong(source_t* source, const char* attribute, const char* expected);
bool source_fail(source_t* source, uint32_t line, status_t status, const char* message);
/// True if a list has room for one more; else the error.
bool source_has_room(source_t* source, uint32_t count, uint32_t capacity, const char* what);

bool source_has(const source_t* source, const char* attribute);
/// Value as written, or NULL.
const char* source_raw(const source_t* source, const char* attribute);
/// Copy into the model's strings; "" if there is an error.
const char* source_keep(source_t* source, const char* words);
const char* source_text(source_t* source, const char* attribute, uint32_t longest);
const char* source_identifier(source_t* source, const char* attribute, uint32_t longest);
const char* source_lower_identifier(source_t* source, const char* attribute);
uint32_t source_unsigned(source_t* source, const char* attribute, uint32_t low, uint32_t high,
                         uint32_t otherwise);
uint32_t source_time_us(source_t* source, const char* attribute, uint32_t low, uint32_t high,
                        uint32_t otherwise);
bool source_flag(source_t* source, const char* attribute, bool otherwise);
/// Index of the value in a list of words.
uint32_t source_word(source_t* source, const char* attribute, const char* const* words, uint32_t count,
                     uint32_t otherwise);
/// Indices of the words of a value, in their order; each known, none twice. Returns their number.
uint32_t source_words(source_t* source, const char* attribute, const char* const* words, uint32_t count,
                      uint8_t* out_indices);
value_type_t source_value_type(source_t* source, const char* attribute);
/// One number of a type as 64 bits: two's complement or IEEE 754 in the low octets; *out_real as double.
uint64_t source_number(source_t* source, const char* attribute, value_type_t type, double* out_real);

/// True if the words are separated by single spaces, with none before and behind.
bool source_is_spaced(const char* words);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H
