// SPDX-License-Identifier: Apache-2.0
/// Text without printf: append words and decimal or hexadecimal numbers to a bounded buffer that always ends
/// with NUL. Text that does not fit is cut, and `cut` is set.
///
/// Ownership  The caller provides the buffer.
/// Time       O(length).
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    char* characters;
    size_t capacity; ///< Including the terminating NUL, >= 1.
    size_t length;   ///< Characters before the NUL.
    bool cut;        ///< Some text did not fit.
} text_t;

/// Begin an empty text in `buffer`. capacity >= 1.
text_t text_in(char* buffer, size_t capacity);
/// Append a word, a character, or a number in decimal.
void text_add(text_t* text, const char* words);
void text_add_character(text_t* text, char character);
void text_add_unsigned(text_t* text, uint64_t value);
void text_add_signed(text_t* text, int64_t value);
/// Append each word of a list that ends with null.
void text_add_words(text_t* text, const char* const* words);
/// Append a pattern. The first % stands for the word `one`, each later % for `other`, each # for `number`. A
/// word that the pattern does not use may be null.
void text_add_pattern(text_t* text, const char* pattern, const char* one, const char* other, uint64_t number);
/// Join the words of a list that ends with null, in `buffer`. False: the text was cut.
bool text_join(char* buffer, size_t capacity, const char* const* words);
/// Append exactly `digits` decimal digits, 0..20, with zeros on the left; the lowest digits if the value has
/// more.
void text_add_digits(text_t* text, uint64_t value, unsigned digits);
/// Append "0x" and exactly `digits` upper-case hexadecimal digits, 1..16.
void text_add_hex(text_t* text, uint64_t value, unsigned digits);
/// Append two lower-case hexadecimal digits for each octet, without separators.
void text_add_octets(text_t* text, const uint8_t* octets, size_t size);
/// Append seconds with nine decimals: 1500000000 ns -> "1.500000000".
void text_add_seconds(text_t* text, uint64_t time_ns);

#endif // BASE_TEXT_H
