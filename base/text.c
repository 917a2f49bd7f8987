// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include "base/assertion.h"

#define DECIMAL_DIGITS_MAX 20U // 2^64 - 1 has 20 digits.

text_t text_in(char* const buffer, const size_t capacity)
{
    FSW_ASSERT((buffer != NULL) && (capacity >= 1U));
    buffer[0] = '\0';
    return (text_t){.characters = buffer, .capacity = capacity, .length = 0U, .cut = false};
}

void text_add_character(text_t* const text, const char character)
{
    FSW_ASSERT(text != NULL);
    if ((text->length + 1U) >= text->capacity) {
        text->cut = true;
        return;
    }
    text->characters[text->length]      = character;
    text->characters[text->length + 1U] = '\0';
    text->length++;
}

void text_add(text_t* const text, const char* const words)
{
    FSW_ASSERT(words != NULL);
    for (const char* next = words; *next != '\0'; next++) {
        text_add_character(text, *next);
    }
}

void text_add_words(text_t* const text, const char* const* const words)
{
    FSW_ASSERT(words != NULL);
    for (size_t i = 0U; words[i] != NULL; i++) {
        text_add(text, words[i]);
    }
}

void text_add_pattern(text_t* const text, const char* const pattern, const char* const one,
                      const char* const other, const uint64_t number)
{
    FSW_ASSERT(pattern != NULL);
    const char* next = one;
    for (const char* at = pattern; *at != '\0'; at++) {
        if (*at == '%') {
            text_add(text, next);
            next = other;
        } else if (*at == '#') {
            text_add_unsigned(text, number);
        } else {
            text_add_character(text, *at);
        }
    }
}

bool text_join(char* const buffer, const size_t capacity, const char* const* const words)
{
    text_t text = text_in(buffer, capacity);
    text_add_words(&text, words);
    return !text.cut;
}

void text_add_digits(text_t* const text, const uint64_t value, const unsigned digits)
{
    FSW_ASSERT(digits <= DECIMAL_DIGITS_MAX);
    char reversed[DECIMAL_DIGITS_MAX];
    uint64_t rest = value;
    for (unsigned i = 0U; i < digits; i++) {
        reversed[i] = (char)('0' + (char)(rest % 10U));
        rest /= 10U;
    }
    for (unsigned i = digits; i > 0U; i--) {
        text_add_character(text, reversed[i - 1U]);
    }
}

void text_add_unsigned(text_t* const text, const uint64_t value)
{
    unsigned digits = 1U;
    for (uint64_t rest = value / 10U; rest > 0U; rest /= 10U) {
        digits++;
    }
    text_add_digits(text, value, digits);
}

void text_add_signed(text_t* const text, const int64_t value)
{
    if (value < 0) {
        text_add_character(text, '-');
        text_add_unsigned(text, 0U - (uint64_t)value);
    } else {
        text_add_unsigned(text, (uint64_t)value);
    }
}

void text_add_hex(text_t* const text, const uint64_t value, const unsigned digits)
{
    FSW_ASSERT((digits >= 1U) && (digits <= 16U));
    text_add(text, "0x");
    for (unsigned i = digits; i > 0U; i--) {
        text_add_character(text, "0123456789ABCDEF"[(value >> (4U * (i - 1U))) & 0xFU]);
    }
}

void text_add_octets(text_t* const text, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    for (size_t i = 0U; i < size; i++) {
        text_add_character(text, "0123456789abcdef"[octets[i] >> 4U]);
        text_add_character(text, "0123456789abcdef"[octets[i] & 0xFU]);
    }
}

void text_add_seconds(text_t* const text, const uint64_t time_ns)
{
    text_add_unsigned(text, time_ns / 1000000000U);
    text_add_character(text, '.');
    text_add_digits(text, time_ns % 1000000000U, 9U);
}
