// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/source.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc.h"
#include "fsw/framework/base/number.h"

#include <string.h>

static void hash_words(source_t* const source, const char* const words)
{
    source->hash = fnv64(source->hash, (const uint8_t*)words, strlen(words));
}

/// Attributes in the order of their names, by repeated selection: there are few.
static void hash_attributes(source_t* const source, const xml_element_t* const element)
{
    const char* before = NULL;
    for (;;) {
        const char* const* next = NULL;
        for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
            const char* const name = element->attributes[i];
            if (((before == NULL) || (strcmp(name, before) > 0)) &&
                ((next == NULL) || (strcmp(name, next[0]) < 0))) {
                next = &element->attributes[i];
            }
        }
        if (next == NULL) {
            return;
        }
        hash_words(source, next[0]);
        hash_words(source, "=");
        hash_words(source, next[1]);
        hash_words(source, "\n");
        before = next[0];
    }
}

bool source_fail(source_t* const source, const uint32_t line, const status_t status,
                 const char* const message)
{
    if (source->status != STATUS_OK) {
        return false;
    }
    source->status = status;
    text_add(source->error, source->path);
    text_add(source->error, ":");
    text_add_unsigned(source->error, line);
    text_add(source->error, ": ");
    text_add(source->error, message);
    return true;
}

void source_wrong(source_t* const source, const char* const attribute, const char* const expected)
{
    const char* const value = source_raw(source, attribute);
    if (source_fail(source, source->line, STATUS_INVALID, attribute)) {
        text_add(source->error, "=\"");
        text_add(source->error, (value != NULL) ? value : "");
        text_add(source->error, "\" of <");
        text_add(source->error, source->open[source->depth - 1U]->name);
        text_add(source->error, ">: expected ");
        text_add(source->error, expected);
    }
}

bool source_has_room(source_t* const source, const uint32_t count, const uint32_t capacity,
                     const char* const what)
{
    if ((count >= capacity) && source_fail(source, source->line, STATUS_EXHAUSTED, "too many ")) {
        text_add(source->error, what);
        text_add(source->error, ", at most ");
        text_add_unsigned(source->error, capacity);
    }
    return (source->status == STATUS_OK);
}

/// Length of the next word of a list of attributes, without its '!'.
static size_t word_length(const char* const at)
{
    size_t length = 0U;
    while ((at[length] != '\0') && (at[length] != ' ') && (at[length] != '!')) {
        length++;
    }
    return length;
}

/// Behind a word of a list of attributes.
static const char* behind(const char* at)
{
    at += word_length(at);
    at += (*at == '!') ? 1 : 0;
    at += (*at == ' ') ? 1 : 0;
    return at;
}

static void check_known(source_t* const source, const source_row_t* const row, const char* const attribute)
{
    for (const char* at = row->attributes; *at != '\0'; at = behind(at)) {
        const size_t length = word_length(at);
        if ((strncmp(at, attribute, length) == 0) && (attribute[length] == '\0')) {
            return;
        }
    }
    if (source_fail(source, source->line, STATUS_INVALID, "attribute ")) {
        text_add(source->error, attribute);
        text_add(source->error, " of <");
        text_add(source->error, row->name);
        text_add(source->error, ">: expected one of");
        for (const char* at = row->attributes; *at != '\0'; at = behind(at)) {
            text_add_character(source->error, ' ');
            for (size_t i = 0U; i < word_length(at); i++) {
                text_add_character(source->error, at[i]);
            }
        }
    }
}

/// Every attribute that must be there is.
static void check_complete(source_t* const source, const source_row_t* const row)
{
    for (const char* at = row->attributes; *at != '\0'; at = behind(at)) {
        const size_t length = word_length(at);
        char name[32];
        FSW_ASSERT(length < sizeof name);
        (void)memcpy(name, at, length);
        name[length] = '\0';
        if ((at[length] == '!') && !source_has(source, name) &&
            source_fail(source, source->line, STATUS_INVALID, "<")) {
            text_add(source->error, row->name);
            text_add(source->error, "> has no attribute ");
            text_add(source->error, name);
        }
    }
}

static void refuse_element(source_t* const source, const uint8_t parent)
{
    if (!source_fail(source, source->line, STATUS_INVALID, "<")) {
        return;
    }
    text_add(source->error, source->element->name);
    if (source->depth > 0U) {
        text_add(source->error, "> in <");
        text_add(source->error, source->open[source->depth - 1U]->name);
    }
    text_add(source->error, ">: expected");
    bool is_any = false;
    for (size_t i = 0U; i < source->row_count; i++) {
        if (source->rows[i].parent == parent) {
            text_add(source->error, is_any ? " or <" : " <");
            text_add(source->error, source->rows[i].name);
            text_add(source->error, ">");
            is_any = true;
        }
    }
    text_add(source->error, is_any ? "" : " nothing");
}

static const source_row_t* row_of(const source_t* const source, const uint8_t parent, const char* const name)
{
    for (size_t i = 0U; i < source->row_count; i++) {
        if ((source->rows[i].parent == parent) && (strcmp(source->rows[i].name, name) == 0)) {
            return &source->rows[i];
        }
    }
    return NULL;
}

static status_t on_start(void* const context, const xml_element_t* const element)
{
    source_t* const source = context;
    const uint8_t parent   = (source->depth > 0U) ? source->open[source->depth - 1U]->kind : SOURCE_ROOT;
    const source_row_t* const row = row_of(source, parent, element->name);
    source->element               = element;
    source->line                  = element->line;
    if ((row == NULL) || (source->depth >= SOURCE_DEPTH_MAX)) {
        refuse_element(source, parent);
        return source->status;
    }
    source->open[source->depth]      = row;
    source->open_line[source->depth] = element->line;
    source->depth++;
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        check_known(source, row, element->attributes[i]);
    }
    check_complete(source, row);
    hash_words(source, "<");
    hash_words(source, element->name);
    hash_words(source, "\n");
    hash_attributes(source, element);
    if ((source->status == STATUS_OK) && (row->start != NULL)) {
        row->start(source);
    }
    source->element = NULL;
    return source->status;
}

static status_t on_end(void* const context, const char* const name, const uint32_t line)
{
    source_t* const source = context;
    (void)name;
    (void)line;
    FSW_ASSERT(source->depth > 0U);
    const source_row_t* const row = source->open[source->depth - 1U];
    source->line = source->open_line[source->depth - 1U]; // An element is named by the line where it begins.
    hash_words(source, ">\n");
    if (row->end != NULL) {
        row->end(source);
    }
    source->depth--;
    return source->status;
}

xml_handler_t source_handler(source_t* const source)
{
    return (xml_handler_t){.start = on_start, .end = on_end, .context = source};
}

const char* source_raw(const source_t* const source, const char* const attribute)
{
    return (source->element != NULL) ? xml_attribute(source->element, attribute) : NULL;
}

bool source_has(const source_t* const source, const char* const attribute)
{
    return source_raw(source, attribute) != NULL;
}

const char* source_keep(source_t* const source, const char* const words)
{
    FSW_ASSERT((source != NULL) && (words != NULL));
    const size_t size = strlen(words) + 1U;
    if (size > (source->text_capacity - *source->text_used)) {
        (void)source_fail(source, source->line, STATUS_EXHAUSTED,
                          "the texts of the file are too long together");
    }
    if (source->status != STATUS_OK) {
        return "";
    }
    char* const kept = &source->text[*source->text_used];
    (void)memcpy(kept, words, size);
    *source->text_used += (uint32_t)size;
    return kept;
}

const char* source_text(source_t* const source, const char* const attribute, const uint32_t longest)
{
    const char* const value = source_raw(source, attribute);
    if (value == NULL) {
        return "";
    }
    if (strlen(value) > longest) {
        source_wrong(source, attribute, "a shorter text");
    }
    return source_keep(source, value);
}

static bool is_identifier(const char* const name, const bool is_upper)
{
    const char first = is_upper ? 'A' : 'a';
    size_t i         = 0U;
    for (; name[i] != '\0'; i++) {
        const bool is_letter = (name[i] >= first) && (name[i] <= (first + ('Z' - 'A')));
        const bool is_digit  = (name[i] >= '0') && (name[i] <= '9');
        const bool is_joint  = (name[i] == '_') || (!is_upper && (name[i] == '-'));
        if (!is_letter && ((i == 0U) || (!is_digit && !is_joint))) {
            return false;
        }
    }
    return i > 0U;
}

const char* source_identifier(source_t* const source, const char* const attribute, const uint32_t longest)
{
    const char* const value = source_raw(source, attribute);
    if ((value == NULL) || !is_identifier(value, true) || (strlen(value) > longest)) {
        source_wrong(source, attribute,
                     (longest <= 8U) ? "an upper-case identifier of at most 8 characters"
                                     : "an upper-case identifier of at most 32 characters");
    }
    return ((value != NULL) && (source->status == STATUS_OK)) ? source_keep(source, value) : "";
}

const char* source_lower_identifier(source_t* const source, const char* const attribute)
{
    const char* const value = source_raw(source, attribute);
    if ((value == NULL) || !is_identifier(value, false) || (strlen(value) > 32U)) {
        source_wrong(source, attribute, "a lower-case identifier of at most 32 characters");
    }
    return ((value != NULL) && (source->status == STATUS_OK)) ? source_keep(source, value) : "";
}

/// Complain about a number outside `low` to `high` of a unit.
static void wrong_range(source_t* const source, const char* const attribute, const char* const what,
                        const uint32_t low, const uint32_t high, const char* const unit)
{
    char expected[96];
    text_t text = text_in(expected, sizeof expected);
    text_add(&text, what);
    text_add(&text, " from ");
    text_add_unsigned(&text, low);
    text_add(&text, unit);
    text_add(&text, " to ");
    text_add_unsigned(&text, high);
    text_add(&text, unit);
    source_wrong(source, attribute, expected);
}

uint32_t source_unsigned(source_t* const source, const char* const attribute, const uint32_t low,
                         const uint32_t high, const uint32_t otherwise)
{
    const char* const value = source_raw(source, attribute);
    if (value == NULL) {
        return otherwise;
    }
    const char* at  = value;
    uint64_t number = 0U;
    if (!source_is_spaced(value) || (number_read_unsigned(&at, &number) != STATUS_OK) || !number_is_end(at) ||
        (number < low) || (number > high)) {
        wrong_range(source, attribute, "a number", low, high, "");
        return otherwise;
    }
    return (uint32_t)number;
}

/// Microseconds of a time with its unit, or UINT64_MAX.
static uint64_t time_of(const char* const value)
{
    uint64_t number = 0U;
    size_t digits   = 0U;
    while ((value[digits] >= '0') && (value[digits] <= '9') && (digits < 10U)) {
        number = (number * 10U) + (uint64_t)(value[digits] - '0');
        digits++;
    }
    if ((digits == 0U) || (digits > 9U)) {
        return UINT64_MAX;
    }
    if (strcmp(&value[digits], "us") == 0) {
        return number;
    }
    if (strcmp(&value[digits], "ms") == 0) {
        return number * 1000U;
    }
    return (strcmp(&value[digits], "s") == 0) ? (number * 1000000U) : UINT64_MAX;
}

uint32_t source_time_us(source_t* const source, const char* const attribute, const uint32_t low,
                        const uint32_t high, const uint32_t otherwise)
{
    const char* const value = source_raw(source, attribute);
    if (value == NULL) {
        return otherwise;
    }
    const uint64_t time_us = time_of(value);
    if ((time_us < low) || (time_us > high)) {
        wrong_range(source, attribute, "a time like 500us, 2ms or 1s,", low, high, "us");
        return otherwise;
    }
    return (uint32_t)time_us;
}

bool source_flag(source_t* const source, const char* const attribute, const bool otherwise)
{
    const char* const value = source_raw(source, attribute);
    if (value == NULL) {
        return otherwise;
    }
    if ((strcmp(value, "true") != 0) && (strcmp(value, "false") != 0)) {
        source_wrong(source, attribute, "true or false");
    }
    return strcmp(value, "true") == 0;
}

/// Index of a word of `length` characters, or count.
static uint32_t index_of(const char* const word, const size_t length, const char* const* const words,
                         const uint32_t count)
{
    uint32_t index = 0U;
    while ((index < count) &&
           ((strncmp(word, words[index], length) != 0) || (words[index][length] != '\0'))) {
        index++;
    }
    return index;
}

static void wrong_word(source_t* const source, const char* const attribute, const char* const what,
                       const char* const* const words, const uint32_t count)
{
    char expected[256];
    text_t text = text_in(expected, sizeof expected);
    text_add(&text, what);
    for (uint32_t i = 0U; i < count; i++) {
        text_add(&text, " ");
        text_add(&text, words[i]);
    }
    source_wrong(source, attribute, expected);
}

uint32_t source_word(source_t* const source, const char* const attribute, const char* const* const words,
                     const uint32_t count, const uint32_t otherwise)
{
    const char* const value = source_raw(source, attribute);
    if (value == NULL) {
        return otherwise;
    }
    const uint32_t index = index_of(value, strlen(value), words, count);
    if (index >= count) {
        wrong_word(source, attribute, "one of", words, count);
        return otherwise;
    }
    return index;
}

uint32_t source_words(source_t* const source, const char* const attribute, const char* const* const words,
                      const uint32_t count, uint8_t* const out_indices)
{
    const char* at = source_raw(source, attribute);
    uint32_t found = 0U;
    bool is_right  = (at != NULL) && (*at != '\0');
    while (is_right) {
        const size_t length  = strcspn(at, " ");
        const uint32_t index = index_of(at, length, words, count);
        is_right             = (index < count) && (found < count);
        for (uint32_t i = 0U; is_right && (i < found); i++) {
            is_right = (out_indices[i] != index);
        }
        if (is_right) {
            out_indices[found] = (uint8_t)index;
            found++;
        }
        if (at[length] == '\0') {
            break;
        }
        at += length + 1U;
    }
    if (!is_right) {
        wrong_word(source, attribute, "some, each once, with one space between, of", words, count);
        return 0U;
    }
    return found;
}

value_type_t source_value_type(source_t* const source, const char* const attribute)
{
    const char* const value = source_raw(source, attribute);
    value_type_t type       = VALUE_UINT8;
    if ((value == NULL) || (value_type_of(value, &type) != STATUS_OK)) {
        source_wrong(source, attribute, "UINT8..UINT64, INT8..INT64, FLOAT, DOUBLE or BOOL");
    }
    return type;
}

uint64_t source_number(source_t* const source, const char* const attribute, const value_type_t type,
                       double* const out_real)
{
    const char* const value = source_raw(source, attribute);
    const char* at          = value;
    uint64_t scalar         = 0U;
    uint64_t bits           = 0U;
    if ((value == NULL) || !source_is_spaced(value) || (number_read_value(&at, type, &scalar) != STATUS_OK) ||
        !number_is_end(at)) {
        char expected[48];
        text_t text = text_in(expected, sizeof expected);
        text_add(&text, "a number of type ");
        text_add(&text, value_type_name(type));
        source_wrong(source, attribute, expected);
        return 0U;
    }
    uint8_t octets[8];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    value_encode(&writer, type, &scalar);
    for (size_t i = 0U; i < writer.position; i++) {
        bits = (bits << 8U) | octets[i];
    }
    *out_real = value_as_double(type, &scalar);
    return bits;
}

bool source_is_spaced(const char* const words)
{
    bool is_space = true; // A space before the first word is one too many.
    for (size_t i = 0U; words[i] != '\0'; i++) {
        if ((words[i] == ' ') && is_space) {
            return false;
        }
        is_space = (words[i] == ' ');
    }
    return !is_space;
}
