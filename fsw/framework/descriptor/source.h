// SPDX-License-Identifier: Apache-2.0
/// Reading of a descriptor's elements: permitted positions, conversion and destination of attributes, lists,
/// strings, hash, and errors. Internal to descriptor/.
///
/// Each permitted element has a row in a table. An element becomes an item of a list of the model, or
/// belongs to the item of the enclosing element; its attributes are converted by their forms into members
/// of that item; the handlers of the row do the rest. An item is cleared before it is read. The model
/// counts the items of a list; if the list has a range, the item of the enclosing element stores it.
///
/// The first error is kept with file and line. Afterwards every call has no effect and returns its default,
/// so that a handler needs no checks of its own and its caller checks `status` once.
///
/// The configuration hash is the FNV-1a of the canonical text. Each element contributes the line "<name", one
/// line "name=value" for each attribute, sorted by name, its children, and the line ">". Comments, spaces
/// between elements and the order of attributes do not change the hash.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H
#define FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H

#include "base/status.h"
#include "base/text.h"
#include "base/value.h"
#include "fsw/framework/xml/xml.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SOURCE_DEPTH_MAX 16U
#define SOURCE_ROOT 0U ///< Kind of the document itself, parent of its first element.

typedef struct source source_t;

// Forms of an attribute.
#define SOURCE_FREE 0U     ///< Any text; the handler of its element reads it.
#define SOURCE_UPPER 1U    ///< Upper-case identifier of at most `high` characters.
#define SOURCE_LOWER 2U    ///< Lower-case identifier of at most `high` characters.
#define SOURCE_NAMES 3U    ///< One or more different identifiers as SOURCE_UPPER, separated by single spaces.
#define SOURCE_TEXT 4U     ///< Any text of at most `high` characters.
#define SOURCE_UNSIGNED 5U ///< Number from `low` to `high`.
#define SOURCE_TIME 6U     ///< Time with its unit, from `low` to `high` [us].
#define SOURCE_WORD 7U     ///< One of `words`. Its value is the index of the word plus `low`.
#define SOURCE_FLAG 8U     ///< "true" or "false".
#define SOURCE_TYPE 9U     ///< Scalar type: value_type_t.
/// Mask of the form, without SOURCE_UNIQUE and SOURCE_NEEDED.
#define SOURCE_FORMS 0x3FU
#define SOURCE_UNIQUE 0x40U ///< No earlier item of the list, or of its range, may have the same value.
/// Required. Otherwise an absent text becomes "", and an absent number becomes `otherwise`.
#define SOURCE_NEEDED 0x80U

typedef struct {
    const char* name;
    const char* words; ///< Permitted words, separated by single spaces.
    uint32_t low;
    uint32_t high;
    uint32_t otherwise;
    uint16_t member; ///< Offset in the item at which the value is stored.
    uint8_t width;   ///< Size of the member [octets]; 0: the value is not stored.
    uint8_t form;    ///< SOURCE_..
} source_attribute_t;

/// Member of the item that stores an attribute's value: a number, enumeration or flag of 1, 2 or 4 octets,
/// or a text.
#define SOURCE_TO(type, target) .member = offsetof(type, target), .width = sizeof(((const type*)NULL)->target)

// Rows of a table of attributes. `form_of` is the form, with SOURCE_NEEDED and SOURCE_UNIQUE if they apply;
// `unset` is the value if the attribute is absent.
/// An attribute that the handler of its element reads.
#define SOURCE_OPTION(id)                                                                                    \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE                                                                    \
    }
/// An attribute that is checked, but not stored.
#define SOURCE_CHECKED(id, form_of)                                                                          \
    {                                                                                                        \
        .name = (id), .form = (form_of)                                                                      \
    }
/// A required attribute that the handler of its element reads.
#define SOURCE_REQUIRED(id)                                                                                  \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE | SOURCE_NEEDED                                                    \
    }
/// An attribute of the form SOURCE_UNSIGNED or SOURCE_TIME, from `from` to `to`.
#define SOURCE_WITHIN(id, form_of, from, to, unset, type, target)                                            \
    {                                                                                                        \
        .name = (id), .form = (form_of), .low = (from), .high = (to), .otherwise = (unset),                  \
        SOURCE_TO(type, target)                                                                              \
    }
/// An attribute of the form SOURCE_UPPER, SOURCE_LOWER, SOURCE_NAMES or SOURCE_TEXT.
#define SOURCE_STRING(id, form_of, longest, type, target)                                                    \
    {                                                                                                        \
        .name = (id), .form = (form_of), .high = (longest), SOURCE_TO(type, target)                          \
    }
/// An attribute of the form SOURCE_WORD.
#define SOURCE_CHOICE(id, form_of, choices, from, unset, type, target)                                       \
    {                                                                                                        \
        .name = (id), .form = (form_of), .words = (choices), .low = (from), .otherwise = (unset),            \
        SOURCE_TO(type, target)                                                                              \
    }
/// An attribute of the form SOURCE_FLAG.
#define SOURCE_SWITCH(id, unset, type, target)                                                               \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FLAG, .otherwise = (unset), SOURCE_TO(type, target)                     \
    }
/// Attributes `name` and `id` of an item, each unique in its list.
#define SOURCE_NAMED(form_of, type)                                                                          \
    SOURCE_STRING("name", (form_of) | SOURCE_NEEDED | SOURCE_UNIQUE, DESCRIPTOR_NAME_MAX, type, name)
#define SOURCE_NUMBERED(from, to, type, target)                                                              \
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, from, to, 0U, type, target)

// A list of items in the model. Offsets within an item fit in 16 bits; 0: the item has no such member.
typedef struct {
    const char* what; ///< Name of the items in the error "too many ...".
    uint32_t items;   ///< Offset of the first item in the model; an item that has a name begins with it.
    uint32_t count;   ///< Offset of the number of items in the model (uint16_t).
    uint16_t capacity;
    uint16_t size;  ///< Size of an item [octets].
    uint16_t line;  ///< Offset of the line in an item (uint32_t), or 0.
    uint16_t first; ///< Offset, in the enclosing item, of the index of the range's first item (uint16_t).
    /// Offset, in the enclosing item, of the length of the range (uint16_t); 0: the list has no ranges.
    uint16_t number;
} source_list_t;

typedef struct { // One permitted child element of a parent.
    uint8_t parent;
    uint8_t kind;   ///< 1..63; the parent of its children.
    uint8_t times;  ///< SOURCE_ANY, SOURCE_ONCE, SOURCE_SOME or SOURCE_EXACTLY.
    uint8_t number; ///< Number of attributes.
    const char* name;
    const source_attribute_t* attributes; ///< All permitted attributes.
    /// List that gets an item; NULL: the element belongs to the item of its parent.
    const source_list_t* list;
    void (*start)(source_t* source); ///< Called when the attributes have been read; NULL: not called.
    void (*end)(source_t* source);   ///< Called at the end of the element; NULL: not called.
} source_row_t;

// How often an element may occur in its parent.
#define SOURCE_ANY 0U
#define SOURCE_ONCE 1U    ///< At most once.
#define SOURCE_SOME 2U    ///< At least once.
#define SOURCE_EXACTLY 3U ///< Exactly once.

#define SOURCE_COUNT(array) (sizeof(array) / sizeof((array)[0]))

struct source {
    const char* path;
    text_t* error;
    status_t status;
    /// The error text that was begun last belongs to the first error, so that it may be extended.
    bool is_reporting;
    const source_row_t* rows;
    size_t row_count;
    const xml_element_t* element; ///< Element being read; valid only in the handler `start`.
    uint32_t line;
    const source_row_t* open[SOURCE_DEPTH_MAX];
    uint32_t open_line[SOURCE_DEPTH_MAX];
    void* items[SOURCE_DEPTH_MAX + 1U]; ///< The model, and the item of each open element.
    void* item;                         ///< Item of the innermost open element.
    uint16_t depth;
    uint16_t order; ///< Index of the newest item in its range, from 0; in its list if the list has no ranges.
    uint64_t seen[SOURCE_DEPTH_MAX + 1U]; ///< Bit n for each open element: a child of kind n was read.
    uint64_t hash;
    char* text; ///< The model's strings.
    uint32_t text_capacity;
    uint32_t* text_used;
    void* builder; ///< Builder that the handlers use.
};

/// Returns the handler for xml_begin that reads into this source; items[0] must be the model.
xml_handler_t descriptor_source_handler(source_t* source);

/// Report errors. Each function begins an error text, to which descriptor_source_append appends; if the error
/// is not the first one, the whole text is dropped. In a pattern, `one` replaces the first %, `other` the
/// second %, and `number` replaces #. `fail` reports a message without replacements; `wrong` reports an
/// attribute, which must be present, its value and the expected value; `taken` reports the earlier line that
/// uses the value.
void descriptor_source_refuse(source_t* source, uint32_t line, const char* pattern, const char* one,
                              const char* other, uint32_t number);
void descriptor_source_append(source_t* source, const char* pattern, const char* one, const char* other,
                              uint32_t number);
void descriptor_source_fail(source_t* source, uint32_t line, const char* message);
void descriptor_source_wrong(source_t* source, const char* attribute, const char* expected);
void descriptor_source_taken(source_t* source, const char* attribute, const char* value, uint32_t line);
/// Report the error "<octets><what>, at most <most>" if octets > most.
void descriptor_source_limit(source_t* source, uint32_t octets, uint32_t most, const char* what);
/// True if a list has room for another item; otherwise the error is reported.
bool descriptor_source_has_room(source_t* source, uint32_t count, uint32_t capacity, const char* what);
/// Like descriptor_source_fail, with another status than STATUS_INVALID.
void descriptor_source_fail_as(source_t* source, uint32_t line, status_t status, const char* message);

/// Add a cleared item to a list, and to the range in the item `around`. Returns the new item; NULL after an
/// error.
void* descriptor_source_add(source_t* source, const source_list_t* list, void* around);
/// Read attributes into the members of an item.
void descriptor_source_read(source_t* source, void* item, const source_attribute_t* attributes,
                            size_t number);
/// Call descriptor_source_add and descriptor_source_read, and check the unique attributes. NULL after an
/// error.
void* descriptor_source_item(source_t* source, const source_list_t* list, void* around,
                             const source_attribute_t* attributes, size_t number);
/// Write the names of the items of a list to `out_words`, separated by single spaces.
void descriptor_source_names(const source_t* source, const source_list_t* list, text_t* out_words);

bool descriptor_source_has(const source_t* source, const char* attribute);
/// Returns the text of an attribute in the file, or NULL if it is absent.
const char* descriptor_source_raw(const source_t* source, const char* attribute);
/// Copy a text to the strings of the model. Returns the copy; "" after an error.
const char* descriptor_source_keep(source_t* source, const char* words);
/// Read an attribute of the form SOURCE_UPPER, SOURCE_LOWER, SOURCE_NAMES or SOURCE_TEXT, at most `longest`
/// characters, and copy it to the model. Returns the copy; "" after an error.
const char* descriptor_source_text(source_t* source, const char* attribute, uint8_t form, uint32_t longest);
/// Read attribute number `index` of the row: a number, a time or a word. Returns its value.
uint32_t descriptor_source_value(source_t* source, size_t index);
/// Returns the index of the attribute's value in a list of words.
uint32_t descriptor_source_word(source_t* source, const char* attribute, const char* words);
/// Write the index of each word of the attribute's value to out_indices. Each word must be in the list
/// `words` and occur once. Returns the number of words.
uint32_t descriptor_source_words(source_t* source, const char* attribute, const char* words,
                                 uint8_t* out_indices);
/// Returns a bit for the index of each word of the attribute's value; all sixteen bits for "*".
uint16_t descriptor_source_bits(source_t* source, const char* attribute, const char* words);
/// Returns a bit for each state that the attribute's value names; bit n: state n. All sixteen bits for "*".
uint16_t descriptor_source_states(source_t* source, const char* attribute);
/// Read a number of a scalar type. Returns its bits, two's complement or IEEE 754, in the low octets;
/// *out_real is the number as double.
uint64_t descriptor_source_number(source_t* source, const char* attribute, value_type_t type,
                                  double* out_real);

/// Returns the index in `words` of a word of `length` characters, or UINT32_MAX.
uint32_t descriptor_source_index(const char* word, size_t length, const char* words);
/// Write the index in `words` of each word in `chosen` to out_indices. Returns the number of words; 0 if a
/// word is unknown or occurs twice, or if there is none.
uint32_t descriptor_source_indices(const char* chosen, const char* words, uint8_t* out_indices);
/// True if single spaces separate the words, without spaces at the beginning and end.
bool descriptor_source_is_spaced(const char* words);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H
