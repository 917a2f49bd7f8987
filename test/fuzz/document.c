// SPDX-License-Identifier: Apache-2.0
// Mutation of XML documents in units of their syntax: elements with all their content, attributes, and
// attribute values.
#include "test/fuzz/fuzz.h"

#include <string.h>

#define TAGS_MAX 512U
#define VALUES_MAX 1024U
#define PIECE_MAX 16384U

typedef struct { // Half-open interval of octets in the document.
    size_t begin;
    size_t end;
} span_t;

typedef struct {
    span_t tags[TAGS_MAX];
    size_t tag_count;
    span_t values[VALUES_MAX]; // Attribute values, without the quotes.
    size_t value_count;
} outline_t;

/// Replacements for attribute values: limits of the types and of the descriptors, and malformed values.
static const char* const words[] = {"",
                                    "0",
                                    "1",
                                    "-1",
                                    "127",
                                    "128",
                                    "255",
                                    "256",
                                    "2046",
                                    "2047",
                                    "32768",
                                    "65535",
                                    "65536",
                                    "1000000",
                                    "1e22",
                                    "1e23",
                                    "4294967295",
                                    "4294967296",
                                    "-2147483649",
                                    "9223372036854775808",
                                    "18446744073709551616",
                                    "0x",
                                    "0xFFFFFFFF",
                                    "nan",
                                    "inf",
                                    "-0.0",
                                    "true",
                                    "false",
                                    "0 0",
                                    "0  0",
                                    " 0",
                                    "500us",
                                    "1s",
                                    "2ms",
                                    "4294967296us",
                                    "../x.xml",
                                    "/",
                                    "A",
                                    "abcdefghi",
                                    "ABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFG",
                                    "DOUBLE",
                                    "BOOL",
                                    "STRUCT",
                                    "UINT64",
                                    "INT8",
                                    "HIGH",
                                    "LOW"};

/// Append the values of the attributes of a tag to the outline.
static void find_values(const uint8_t* const data, outline_t* const outline, const span_t tag)
{
    size_t begin = tag.end; // First octet of the value; tag.end: not within quotes.
    for (size_t i = tag.begin; i < tag.end; i++) {
        if (data[i] != (uint8_t)'"') {
            continue;
        }
        if (begin == tag.end) {
            begin = i + 1U;
        } else {
            if (outline->value_count < VALUES_MAX) {
                outline->values[outline->value_count] = (span_t){begin, i};
                outline->value_count++;
            }
            begin = tag.end;
        }
    }
}

static void read_outline(const uint8_t* const data, const size_t size, outline_t* const outline)
{
    outline->tag_count   = 0U;
    outline->value_count = 0U;
    for (size_t i = 0U; (i < size) && (outline->tag_count < TAGS_MAX); i++) {
        const uint8_t* const close = (data[i] == (uint8_t)'<') ? memchr(&data[i], '>', size - i) : NULL;
        if (close == NULL) {
            continue;
        }
        const span_t tag                  = {i, (size_t)(close - data) + 1U};
        outline->tags[outline->tag_count] = tag;
        outline->tag_count++;
        find_values(data, outline, tag);
        i = tag.end - 1U;
    }
}

/// Returns the element that begins with this tag, with all its content; only the tag if it begins no element,
/// or if the end of the element is missing.
static span_t element_of(const uint8_t* const data, const outline_t* const outline, const size_t first)
{
    int depth = 0;
    for (size_t i = first; i < outline->tag_count; i++) {
        const span_t tag    = outline->tags[i];
        const uint8_t mark  = data[tag.begin + 1U];
        const bool is_plain = (mark != (uint8_t)'!') && (mark != (uint8_t)'?');
        if (mark == (uint8_t)'/') {
            depth--;
        } else if (is_plain && (data[tag.end - 2U] != (uint8_t)'/')) {
            depth++;
        } else {
            // Empty-element tag, declaration or comment: the depth does not change.
        }
        if (depth <= 0) {
            return (span_t){outline->tags[first].begin, tag.end};
        }
    }
    return outline->tags[first];
}

/// Replace a span by `count` octets. Returns the new size, or the old one if it does not fit.
static size_t splice(uint8_t* const data, const size_t size, const size_t max_size, const span_t at,
                     const uint8_t* const octets, const size_t count)
{
    const size_t result = size - (at.end - at.begin) + count;
    if (result > max_size) {
        return size;
    }
    (void)memmove(&data[at.begin + count], &data[at.end], size - at.end);
    (void)memcpy(&data[at.begin], octets, count);
    return result;
}

/// Copy a span into `piece`. Returns its size, or 0 if it does not fit.
static size_t keep(const uint8_t* const data, const span_t span, uint8_t piece[PIECE_MAX])
{
    const size_t count = span.end - span.begin;
    if (count > PIECE_MAX) {
        return 0U;
    }
    (void)memcpy(piece, &data[span.begin], count);
    return count;
}

/// Replace a value by a word of the list, by another value, or by a mutation of the value.
static size_t change_value(uint8_t* const data, const size_t size, const size_t max_size,
                           const outline_t* const outline, uint32_t* const random)
{
    static uint8_t piece[PIECE_MAX];
    const span_t value = outline->values[fuzz_random(random) % outline->value_count];
    const span_t other = outline->values[fuzz_random(random) % outline->value_count];
    size_t count       = 0U;
    switch (fuzz_random(random) % 3U) {
    case 0: {
        const char* const word = words[fuzz_random(random) % (sizeof words / sizeof words[0])];
        count                  = strlen(word);
        (void)memcpy(piece, word, count);
        break;
    }
    case 1:
        count = keep(data, other, piece);
        break;
    default:
        count = LLVMFuzzerMutate(piece, keep(data, value, piece), 256U);
        for (size_t i = 0U; i < count; i++) { // Keep only ASCII that a value may contain.
            const bool is_plain = (piece[i] >= 0x20U) && (piece[i] < 0x7FU) && (piece[i] != (uint8_t)'<') &&
                                  (piece[i] != (uint8_t)'&') && (piece[i] != (uint8_t)'"');
            piece[i] = is_plain ? piece[i] : (uint8_t)'7';
        }
        break;
    }
    return splice(data, size, max_size, value, piece, count);
}

/// Copy an element to another position, replace another element by it, or delete it.
static size_t change_element(uint8_t* const data, const size_t size, const size_t max_size,
                             const outline_t* const outline, uint32_t* const random)
{
    static uint8_t piece[PIECE_MAX];
    const span_t one   = element_of(data, outline, fuzz_random(random) % outline->tag_count);
    const span_t other = element_of(data, outline, fuzz_random(random) % outline->tag_count);
    if (data[one.begin + 1U] == (uint8_t)'/') {
        return size;
    }
    const size_t count = keep(data, one, piece);
    switch (fuzz_random(random) % 3U) {
    case 0: // Insert a copy before another tag.
        return splice(data, size, max_size, (span_t){other.begin, other.begin}, piece, count);
    case 1: // Replace another element by a copy.
        return (data[other.begin + 1U] != (uint8_t)'/') ? splice(data, size, max_size, other, piece, count)
                                                        : size;
    default:
        return splice(data, size, max_size, one, piece, 0U);
    }
}

/// Remove an attribute, or copy it to another element.
static size_t change_attribute(uint8_t* const data, const size_t size, const size_t max_size,
                               const outline_t* const outline, uint32_t* const random)
{
    static uint8_t piece[PIECE_MAX];
    const span_t value = outline->values[fuzz_random(random) % outline->value_count];
    const span_t other = outline->values[fuzz_random(random) % outline->value_count];
    span_t attribute   = {value.begin, value.end + 1U};
    while ((attribute.begin > 0U) && (data[attribute.begin - 1U] != (uint8_t)' ') &&
           (data[attribute.begin - 1U] != (uint8_t)'<')) {
        attribute.begin--;
    }
    if ((attribute.begin == 0U) || (data[attribute.begin - 1U] == (uint8_t)'<')) {
        return size;
    }
    attribute.begin--; // Include the space before it.
    if ((fuzz_random(random) % 2U) == 0U) {
        return splice(data, size, max_size, attribute, piece, 0U);
    }
    const size_t count = keep(data, attribute, piece);
    return splice(data, size, max_size, (span_t){other.end + 1U, other.end + 1U}, piece, count);
}

size_t fuzz_mutate_document(uint8_t* const data, const size_t size, const size_t max_size,
                            const unsigned seed)
{
    static outline_t outline;
    uint32_t random = seed;
    read_outline(data, size, &outline);
    const uint32_t action = fuzz_random(&random) % 8U;
    if ((action == 0U) || (outline.tag_count == 0U) || (outline.value_count == 0U)) {
        return LLVMFuzzerMutate(data, size, max_size);
    }
    if (action <= 4U) {
        return change_value(data, size, max_size, &outline, &random);
    }
    return (action <= 6U) ? change_element(data, size, max_size, &outline, &random)
                          : change_attribute(data, size, max_size, &outline, &random);
}
