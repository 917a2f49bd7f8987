// SPDX-License-Identifier: Apache-2.0
// Values of attributes: texts, numbers, times, words.
#include "base/assertion.h"
#include "base/number.h"
#include "fsw/framework/descriptor/source.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#include <string.h>

const char* descriptor_source_raw(const source_t* const source, const char* const attribute)
{
    return xml_attribute(source->element, attribute);
}

bool descriptor_source_has(const source_t* const source, const char* const attribute)
{
    return descriptor_source_raw(source, attribute) != NULL;
}

// ---- Texts ----

const char* descriptor_source_keep(source_t* const source, const char* const words)
{
    const size_t size = strlen(words) + 1U;
    if (size > (source->text_capacity - *source->text_used)) {
        descriptor_source_fail_as(source, source->line, STATUS_EXHAUSTED,
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

static bool is_digit(const char character)
{
    return (character >= '0') && (character <= '9');
}

/// True if the first `length` characters, at least one, form an identifier.
static bool is_identifier(const char* const name, const size_t length, const bool is_upper)
{
    const char first = is_upper ? 'A' : 'a';
    for (size_t i = 0U; i < length; i++) {
        const bool is_letter = (name[i] >= first) && (name[i] <= (first + ('Z' - 'A')));
        const bool is_inner  = is_digit(name[i]) || (name[i] == '_') || (!is_upper && (name[i] == '-'));
        if (!is_letter && ((i == 0U) || !is_inner)) {
            return false;
        }
    }
    return length > 0U;
}

/// True if the value consists of as many identifiers as the form permits, each of at most `longest`
/// characters.
static bool are_identifiers(const char* const value, const uint8_t form, const uint32_t longest)
{
    uint32_t order        = 0U;
    const char* at        = value;
    const char* separator = (form == SOURCE_NAMES) ? " " : "";
    for (;;) {
        const size_t length = strcspn(at, separator);
        if (!is_identifier(at, length, form != SOURCE_LOWER) || (length > longest) ||
            ((form == SOURCE_NAMES) && (descriptor_source_index(at, length, value) != order))) {
            return false;
        }
        if (at[length] == '\0') {
            return true;
        }
        at += length + 1U;
        order++;
    }
}

const char* descriptor_source_text(source_t* const source, const char* const attribute, const uint8_t form,
                                   const uint32_t longest)
{
    const char* const value = descriptor_source_raw(source, attribute);
    if (value == NULL) {
        return "";
    }
    static const char* const forms[] = {[SOURCE_UPPER] = "an upper-case identifier (A-Z 0-9 _)",
                                        [SOURCE_LOWER] = "a lower-case identifier (a-z 0-9 _ -)",
                                        [SOURCE_NAMES] = "different upper-case identifiers (A-Z 0-9 _)",
                                        [SOURCE_TEXT]  = "a text"};
    const bool is_right =
        (form == SOURCE_TEXT) ? (strlen(value) <= longest) : are_identifiers(value, form, longest);
    if (!is_right) {
        descriptor_source_wrong(source, attribute, forms[form]);
        descriptor_source_append(source, " of at most # characters", NULL, NULL, longest);
    }
    return descriptor_source_keep(source, value);
}

// ---- Numbers ----

/// Returns the microseconds of a time with its unit, or UINT64_MAX if it is malformed.
static uint64_t time_of(const char* const value)
{
    static const struct {
        char unit[4];
        uint32_t time_us;
    } units[]       = {{"us", 1U}, {"ms", 1000U}, {"s", 1000000U}};
    uint64_t number = 0U;
    size_t digits   = 0U;
    while ((digits < 10U) && is_digit(value[digits])) {
        number = (number * 10U) + (uint64_t)(value[digits] - '0');
        digits++;
    }
    for (size_t i = 0U; (digits >= 1U) && (digits <= 9U) && (i < SOURCE_COUNT(units)); i++) {
        if (strcmp(&value[digits], units[i].unit) == 0) {
            return number * units[i].time_us;
        }
    }
    return UINT64_MAX;
}

static uint64_t unsigned_of(const char* const value)
{
    const char* at      = value;
    uint64_t number     = 0U;
    const bool is_right = descriptor_source_is_spaced(value) &&
                          (number_read_unsigned(&at, &number) == STATUS_OK) && number_is_end(at);
    return is_right ? number : UINT64_MAX;
}

/// Read a number or a time, and check its bounds.
static uint32_t bounded(source_t* const source, const source_attribute_t* const attribute,
                        const char* const value)
{
    const bool is_time     = (attribute->form & SOURCE_FORMS) == SOURCE_TIME;
    const uint64_t number  = is_time ? time_of(value) : unsigned_of(value);
    const char* const unit = is_time ? "us" : "";
    if ((number < attribute->low) || (number > attribute->high)) {
        descriptor_source_wrong(source, attribute->name,
                                is_time ? "a time like 500us, 2ms or 1s, from " : "a number from ");
        descriptor_source_append(source, "#% to ", unit, NULL, attribute->low);
        descriptor_source_append(source, "#%", unit, NULL, attribute->high);
    }
    return (uint32_t)number;
}

static value_type_t type_of(source_t* const source, const char* const attribute, const char* const value)
{
    value_type_t type = VALUE_UINT8;
    if (value_type_of(value, &type) != STATUS_OK) {
        descriptor_source_wrong(source, attribute, "UINT8..UINT64, INT8..INT64, FLOAT, DOUBLE or BOOL");
    }
    return type;
}

static uint32_t value_of(source_t* const source, const source_attribute_t* const attribute)
{
    const char* const value = descriptor_source_raw(source, attribute->name);
    const uint8_t form      = attribute->form & SOURCE_FORMS;
    if (value == NULL) {
        return attribute->otherwise;
    }
    if (form == SOURCE_WORD) {
        return attribute->low + descriptor_source_word(source, attribute->name, attribute->words);
    }
    if (form == SOURCE_FLAG) {
        const bool is_true = (strcmp(value, "true") == 0);
        if (!is_true && (strcmp(value, "false") != 0)) {
            descriptor_source_wrong(source, attribute->name, "true or false");
        }
        return is_true ? 1U : 0U;
    }
    return (form == SOURCE_TYPE) ? (uint32_t)type_of(source, attribute->name, value)
                                 : bounded(source, attribute, value);
}

uint32_t descriptor_source_value(source_t* const source, const size_t index)
{
    return value_of(source, &source->open[source->depth - 1U]->attributes[index]);
}

void descriptor_source_read(source_t* const source, void* const item,
                            const source_attribute_t* const attributes, const size_t number)
{
    for (size_t i = 0U; i < number; i++) {
        const source_attribute_t* const attribute = &attributes[i];
        const uint8_t form                        = attribute->form & SOURCE_FORMS;
        uint8_t* const member                     = (uint8_t*)item + attribute->member;
        if ((form >= SOURCE_UPPER) && (form <= SOURCE_TEXT)) {
            const char* const kept = descriptor_source_text(source, attribute->name, form, attribute->high);
            (void)memcpy(member, &kept, attribute->width);
        } else if (form != SOURCE_FREE) {
            const uint32_t value   = value_of(source, attribute);
            const uint16_t as_u16  = (uint16_t)value;
            const uint8_t as_u8    = (uint8_t)value;
            const void* const from = (attribute->width == sizeof value)    ? (const void*)&value
                                     : (attribute->width == sizeof as_u16) ? (const void*)&as_u16
                                                                           : (const void*)&as_u8;
            (void)memcpy(member, from, attribute->width);
        }
    }
}

uint64_t descriptor_source_number(source_t* const source, const char* const attribute,
                                  const value_type_t type, double* const out_real)
{
    const char* const value = descriptor_source_raw(source, attribute);
    const char* at          = value;
    uint64_t scalar         = 0U;
    if (!descriptor_source_is_spaced(value) || (number_read_value(&at, type, &scalar) != STATUS_OK) ||
        !number_is_end(at)) {
        descriptor_source_wrong(source, attribute, "a number of type ");
        descriptor_source_append(source, "%", value_type_name(type), NULL, 0U);
        return 0U;
    }
    *out_real = value_as_double(type, &scalar);
    return value_bits(type, &scalar);
}

// ---- Words ----

uint32_t descriptor_source_index(const char* const word, const size_t length, const char* const words)
{
    uint32_t index = 0U;
    for (const char* at = words; *at != '\0'; index++) {
        const size_t own = strcspn(at, " ");
        if ((own == length) && (strncmp(word, at, length) == 0)) {
            return index;
        }
        at += own + ((at[own] == ' ') ? 1U : 0U);
    }
    return UINT32_MAX;
}

uint32_t descriptor_source_word(source_t* const source, const char* const attribute, const char* const words)
{
    const char* const value = descriptor_source_raw(source, attribute);
    const uint32_t index    = descriptor_source_index(value, strlen(value), words);
    if (index == UINT32_MAX) {
        descriptor_source_wrong(source, attribute, "one of ");
        descriptor_source_append(source, "%", words, NULL, 0U);
        return 0U;
    }
    return index;
}

uint32_t descriptor_source_indices(const char* const chosen, const char* const words,
                                   uint8_t* const out_indices)
{
    uint32_t seen   = 0U;
    uint32_t number = 0U;
    const char* at  = chosen;
    for (;;) {
        const size_t length  = strcspn(at, " ");
        const uint32_t index = descriptor_source_index(at, length, words);
        if ((index == UINT32_MAX) || (((seen >> index) & 1U) != 0U)) {
            return 0U;
        }
        seen |= (uint32_t)1U << index;
        out_indices[number] = (uint8_t)index;
        number++;
        if (at[length] == '\0') {
            return number;
        }
        at += length + 1U;
    }
}

uint32_t descriptor_source_words(source_t* const source, const char* const attribute, const char* const words,
                                 uint8_t* const out_indices)
{
    const uint32_t number =
        descriptor_source_indices(descriptor_source_raw(source, attribute), words, out_indices);
    if (number == 0U) {
        descriptor_source_wrong(source, attribute,
                                "one or more words, each once, separated by single spaces, of ");
        descriptor_source_append(source, "%", words, NULL, 0U);
    }
    return number;
}

uint16_t descriptor_source_bits(source_t* const source, const char* const attribute, const char* const words)
{
    uint8_t indices[16];
    uint32_t bits = 0U;
    if (strcmp(descriptor_source_raw(source, attribute), "*") == 0) {
        return UINT16_MAX;
    }
    for (uint32_t i = descriptor_source_words(source, attribute, words, indices); i > 0U; i--) {
        bits |= (uint32_t)1U << indices[i - 1U];
    }
    return (uint16_t)bits;
}

uint16_t descriptor_source_states(source_t* const source, const char* const attribute)
{
    char words[DESCRIPTOR_STATE_WORDS];
    text_t text = text_in(words, sizeof words);
    descriptor_state_words(UINT16_MAX, &text);
    return descriptor_source_bits(source, attribute, words);
}

bool descriptor_source_is_spaced(const char* const words)
{
    bool is_space = true; // A space before the first word is not permitted.
    for (size_t i = 0U; words[i] != '\0'; i++) {
        if ((words[i] == ' ') && is_space) {
            return false;
        }
        is_space = (words[i] == ' ');
    }
    return !is_space;
}
