// SPDX-License-Identifier: Apache-2.0
/// Reading of a descriptor's elements: permitted places, conversion and destination of attributes, lists,
/// strings, hash, and errors. Internal to descriptor/.
///
/// Elements are described by rows: an element becomes an item of a list of the model, or belongs to the item
/// of the element around it; its attributes are read by their forms into members of that item; the row's
/// handlers do the rest. An item is cleared before it is read; items of one list are counted in the model
/// and, where the list says so, as a range in the item of the element around.
///
/// The first error is kept, with file and line, and makes every later call a no-op that returns its default;
/// a handler reads all it needs and its caller checks `status` once. The canonical text, whose FNV-1a is the
/// configuration hash, is for each element "<name\n", its attributes sorted by name as "name=value\n", its
/// children, ">\n": comments, spaces between elements and the order of attributes do not change it.
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
#define SOURCE_NAMES 3U    ///< SOURCE_UPPER, one or more, each once, with single spaces between.
#define SOURCE_TEXT 4U     ///< Any text of at most `high` characters.
#define SOURCE_UNSIGNED 5U ///< Number from `low` to `high`.
#define SOURCE_TIME 6U     ///< Time with its unit, from `low` to `high` [us].
#define SOURCE_WORD 7U     ///< One of `words`: its place among them, from `low` on.
#define SOURCE_FLAG 8U     ///< true or false.
#define SOURCE_TYPE 9U     ///< Scalar type: value_type_t.
#define SOURCE_FORMS 0x3FU
#define SOURCE_UNIQUE 0x40U ///< No earlier item of the list, or of its range, has the same value.
#define SOURCE_NEEDED 0x80U ///< Required. Otherwise an absent text is "", an absent number is `otherwise`.

typedef struct {
    const char* name;
    const char* words; ///< With single spaces between.
    uint32_t low;
    uint32_t high;
    uint32_t otherwise;
    uint16_t member; ///< Where its value goes: offset in the item.
    uint8_t width;   ///< [octets] 0: not stored.
    uint8_t form;    ///< SOURCE_..
} source_attribute_t;

/// Where an attribute's value goes. Numbers, enumerations and flags of 1, 2 or 4 octets; texts.
#define SOURCE_TO(type, place) .member = offsetof(type, place), .width = sizeof(((const type*)NULL)->place)

// Rows of a table of attributes. `form_of`: the form, with SOURCE_NEEDED and SOURCE_UNIQUE where they apply;
// `unset`: value of an attribute that is absent.
/// Read by the handler of its element.
#define SOURCE_OPTION(id)                                                                                    \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE                                                                    \
    }
/// Checked, but not stored.
#define SOURCE_CHECKED(id, form_of)                                                                          \
    {                                                                                                        \
        .name = (id), .form = (form_of)                                                                      \
    }
#define SOURCE_REQUIRED(id)                                                                                  \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE | SOURCE_NEEDED                                                    \
    }
/// SOURCE_UNSIGNED or SOURCE_TIME, from `from` to `to`.
#define SOURCE_WITHIN(id, form_of, from, to, unset, type, place)                                             \
    {                                                                                                        \
        .name = (id), .form = (form_of), .low = (from), .high = (to), .otherwise = (unset),                  \
        SOURCE_TO(type, place)                                                                               \
    }
/// SOURCE_UPPER, SOURCE_LOWER, SOURCE_NAMES or SOURCE_TEXT.
#define SOURCE_STRING(id, form_of, longest, type, place)                                                     \
    {                                                                                                        \
        .name = (id), .form = (form_of), .high = (longest), SOURCE_TO(type, place)                           \
    }
/// SOURCE_WORD.
#define SOURCE_CHOICE(id, form_of, choices, from, unset, type, place)                                        \
    {                                                                                                        \
        .name = (id), .form = (form_of), .words = (choices), .low = (from), .otherwise = (unset),            \
        SOURCE_TO(type, place)                                                                               \
    }
#define SOURCE_SWITCH(id, unset, type, place)                                                                \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FLAG, .otherwise = (unset), SOURCE_TO(type, place)                      \
    }
/// Name and number of an item, each unique in its list.
#define SOURCE_NAMED(form_of, type)                                                                          \
    SOURCE_STRING("name", (form_of) | SOURCE_NEEDED | SOURCE_UNIQUE, DESCRIPTOR_NAME_MAX, type, name)
#define SOURCE_NUMBERED(from, to, type, place)                                                               \
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, from, to, 0U, type, place)

typedef struct {      // A list of items in the model. Offsets are small and not zero where they are used.
    const char* what; ///< "too many .."
    uint32_t items;   ///< Offset of the first item in the model; an item that has a name begins with it.
    uint32_t count;   ///< Offset of the number of items in the model (uint16_t).
    uint16_t capacity;
    uint16_t size;   ///< Size of an item [octets].
    uint16_t line;   ///< Offset of the line in an item (uint32_t), or 0.
    uint16_t first;  ///< Offset, in the enclosing item, of the first index of the range (uint16_t).
    uint16_t number; ///< Offset, in that item, of the length of the range (uint16_t), or 0: no range.
} source_list_t;

typedef struct { // One permitted child element of a parent.
    uint8_t parent;
    uint8_t kind;   ///< 1..63; the parent of its children.
    uint8_t times;  ///< SOURCE_ANY..
    uint8_t number; ///< Number of attributes.
    const char* name;
    const source_attribute_t* attributes; ///< All that are known.
    const source_list_t* list;            ///< NULL: it belongs to the item of its parent.
    void (*start)(source_t* source);      ///< Called when the attributes have been read; NULL: not called.
    void (*end)(source_t* source);        ///< Called at the end of the element; NULL: not called.
} source_row_t;

// How often an element may occur in its parent.
#define SOURCE_ANY 0U
#define SOURCE_ONCE 1U    ///< At most once.
#define SOURCE_SOME 2U    ///< At least once.
#define SOURCE_EXACTLY 3U ///< Once.

#define SOURCE_COUNT(array) (sizeof(array) / sizeof((array)[0]))

struct source {
    const char* path;
    text_t* error;
    status_t status;
    bool is_reporting; ///< The error begun last is the first one.
    const source_row_t* rows;
    size_t row_count;
    const xml_element_t* element; ///< Only inside `start`.
    uint32_t line;
    const source_row_t* open[SOURCE_DEPTH_MAX];
    uint32_t open_line[SOURCE_DEPTH_MAX];
    void* items[SOURCE_DEPTH_MAX + 1U]; ///< The model, and the item of each open element.
    void* item;                         ///< Item of the innermost open element.
    uint16_t depth;
    uint16_t order; ///< Order of the newest item in its range, or in its list without ranges, from 0.
    uint64_t seen[SOURCE_DEPTH_MAX + 1U]; ///< Bit n for each open element: a child of kind n was read.
    uint64_t hash;
    char* text; ///< The model's strings.
    uint32_t text_capacity;
    uint32_t* text_used;
    void* builder; ///< Builder of the handlers.
};

/// Handler for xml_begin over a source, whose items[0] is the model.
xml_handler_t descriptor_source_handler(source_t* source);

/// Errors. Each begins a text, to which more is added with descriptor_source_say; if it is not the first
/// error, all of it is dropped. In a pattern the first % is replaced by `one`, the next by `other`, and # by
/// `number`: one call instead of one for each piece. `fail` takes a message as it is; `wrong` names a present
/// attribute, its value and the expected value; `taken` an earlier line.
void descriptor_source_refuse(source_t* source, uint32_t line, const char* pattern, const char* one,
                              const char* other, uint32_t number);
void descriptor_source_say(source_t* source, const char* pattern, const char* one, const char* other,
                           uint32_t number);
void descriptor_source_fail(source_t* source, uint32_t line, const char* message);
void descriptor_source_wrong(source_t* source, const char* attribute, const char* expected);
void descriptor_source_taken(source_t* source, const char* attribute, const char* value, uint32_t line);
/// The error "<octets><what>, at most <most>" if octets > most.
void descriptor_source_limit(source_t* source, uint32_t octets, uint32_t most, const char* what);
/// True if a list has room for one more; otherwise it reports the error.
bool descriptor_source_has_room(source_t* source, uint32_t count, uint32_t capacity, const char* what);
/// Like descriptor_source_fail, with another status than STATUS_INVALID.
void descriptor_source_fail_as(source_t* source, uint32_t line, status_t status, const char* message);

/// New, cleared item of a list, in the range that `around` has; NULL after an error.
void* descriptor_source_add(source_t* source, const source_list_t* list, void* around);
/// Read attributes into the members of an item.
void descriptor_source_read(source_t* source, void* item, const source_attribute_t* attributes,
                            size_t number);
/// descriptor_source_add and descriptor_source_read, with a check of the unique attributes; NULL after an
/// error.
void* descriptor_source_item(source_t* source, const source_list_t* list, void* around,
                             const source_attribute_t* attributes, size_t number);
/// Names of the items of a list, with single spaces between, into `out_words`.
void descriptor_source_names(const source_t* source, const source_list_t* list, text_t* out_words);

bool descriptor_source_has(const source_t* source, const char* attribute);
/// Value as written, or NULL.
const char* descriptor_source_raw(const source_t* source, const char* attribute);
/// Copy into the model's strings; "" if there is an error.
const char* descriptor_source_keep(source_t* source, const char* words);
/// Text of a form, of at most `longest` characters, kept; or "".
const char* descriptor_source_text(source_t* source, const char* attribute, uint8_t form, uint32_t longest);
/// Value of the attribute that is number `index` in the row: a number, a time or a word.
uint32_t descriptor_source_value(source_t* source, size_t index);
/// Place of the value in a list of words.
uint32_t descriptor_source_word(source_t* source, const char* attribute, const char* words);
/// Places of the words of a value, in their order; each known, none twice. Returns their number.
uint32_t descriptor_source_words(source_t* source, const char* attribute, const char* words,
                                 uint8_t* out_places);
/// Bits of the places of the words of a value; all sixteen for "*".
uint16_t descriptor_source_bits(source_t* source, const char* attribute, const char* words);
/// Bits of the states of a subsystem that a value names; bit n: state n.
uint16_t descriptor_source_states(source_t* source, const char* attribute);
/// One number of a type as 64 bits: two's complement or IEEE 754 in the low octets; *out_real as double.
uint64_t descriptor_source_number(source_t* source, const char* attribute, value_type_t type,
                                  double* out_real);

/// Place in `words` of a word of `length` characters, or UINT32_MAX.
uint32_t descriptor_source_place(const char* word, size_t length, const char* words);
/// Places in `words` of the words in `chosen`, in their order; returns their number, or 0 if one is unknown,
/// occurs twice, or there is none.
uint32_t descriptor_source_places(const char* chosen, const char* words, uint8_t* out_places);
/// True if the words are separated by single spaces, with none before and behind.
bool descriptor_source_is_spaced(const char* words);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SOURCE_H
