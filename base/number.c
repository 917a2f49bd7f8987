// SPDX-License-Identifier: Apache-2.0
#include "base/number.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define REAL_DIGITS_MAX 15U // A double represents each integer of 15 digits exactly.
#define REAL_POWER_MAX 22   // A double represents 10^22 exactly, so digits * 10^power is rounded only once.

static bool is_digit(const char character)
{
    return (character >= '0') && (character <= '9');
}

static bool is_word_end(const char character)
{
    return (character == '\0') || (character == ' ');
}

/// Returns the value of a hexadecimal digit, or 16.
static uint8_t hex_digit(const char character)
{
    if (is_digit(character)) {
        return (uint8_t)(character - '0');
    }
    if ((character >= 'a') && (character <= 'f')) {
        return (uint8_t)(character - 'a' + 10);
    }
    if ((character >= 'A') && (character <= 'F')) {
        return (uint8_t)(character - 'A' + 10);
    }
    return 16U;
}

/// Returns the position after the spaces that follow a word.
static const char* next_word(const char* text)
{
    while (*text == ' ') {
        text++;
    }
    return text;
}

/// Read digits of a base up to the end of the word.
static status_t read_digits(const char* text, const uint8_t base, uint64_t* const out_value,
                            const char** out_end)
{
    uint64_t value = 0U;
    if (is_word_end(*text)) {
        return STATUS_INVALID;
    }
    bool is_beyond = false;
    for (; !is_word_end(*text); text++) {
        const uint8_t digit = hex_digit(*text);
        if (digit >= base) {
            return STATUS_INVALID;
        }
        is_beyond = is_beyond || (value > ((UINT64_MAX - digit) / base));
        value     = (value * base) + digit;
    }
    *out_value = value;
    *out_end   = text;
    return is_beyond ? STATUS_OUT_OF_RANGE : STATUS_OK;
}

/// Read an integer word as magnitude and sign.
static status_t read_integer(const char** const text, bool* const out_negative, uint64_t* const out_magnitude)
{
    FSW_ASSERT((text != NULL) && (*text != NULL));
    const char* at = next_word(*text);
    if (*at == '\0') {
        return STATUS_EMPTY;
    }
    const bool is_hexadecimal = (at[0] == '0') && (at[1] == 'x');
    *out_negative             = (at[0] == '-');
    at += is_hexadecimal ? 2 : (*out_negative ? 1 : 0);
    const status_t status = read_digits(at, is_hexadecimal ? 16U : 10U, out_magnitude, &at);
    if (status == STATUS_OK) {
        *text = next_word(at);
    }
    return status;
}

typedef struct { // A decimal number: digits x 10^power.
    uint64_t digits;
    unsigned digit_count; // Number of digits without leading zeros.
    int power;
} decimal_t;

/// Read the digits before or after the decimal point. False if there is no digit.
static bool take_digits(const char** const at, decimal_t* const decimal, const bool is_fraction)
{
    const char* const start = *at;
    for (; is_digit(**at); (*at)++) {
        if ((decimal->digit_count > 0U) || (**at != '0')) {
            decimal->digit_count++;
        }
        if (decimal->digit_count <= REAL_DIGITS_MAX) {
            decimal->digits = (decimal->digits * 10U) + (uint64_t)(**at - '0');
        }
        decimal->power -= is_fraction ? 1 : 0;
    }
    return *at != start;
}

/// Read the exponent after 'e'. False if it does not have one to four digits, which is also the limit of the
/// schemas.
static bool take_exponent(const char** const at, decimal_t* const decimal)
{
    const bool is_negative = (**at == '-');
    *at += ((**at == '-') || (**at == '+')) ? 1 : 0;
    int exponent   = 0;
    unsigned count = 0U;
    for (; is_digit(**at) && (count < 5U); (*at)++) {
        exponent = (exponent * 10) + (**at - '0');
        count++;
    }
    decimal->power += is_negative ? -exponent : exponent;
    return (count >= 1U) && (count <= 4U);
}

static double scaled(const decimal_t* const decimal)
{
    double power = 1.0;
    for (int i = 0; i < ((decimal->power < 0) ? -decimal->power : decimal->power); i++) {
        power *= 10.0; // Exact up to 10^22.
    }
    return (decimal->power < 0) ? ((double)decimal->digits / power) : ((double)decimal->digits * power);
}

/// Read a decimal number with an optional fraction and exponent, up to the end of the word.
static bool take_decimal(const char** const at, decimal_t* const decimal)
{
    bool is_valid = take_digits(at, decimal, false);
    if (is_valid && (**at == '.')) {
        (*at)++;
        is_valid = take_digits(at, decimal, true);
    }
    if (is_valid && ((**at == 'e') || (**at == 'E'))) {
        (*at)++;
        is_valid = take_exponent(at, decimal);
    }
    return is_valid && is_word_end(**at);
}

static bool is_beyond_exact(const decimal_t* const decimal)
{
    return (decimal->digit_count > REAL_DIGITS_MAX) ||
           ((decimal->digits != 0U) &&
            ((decimal->power > REAL_POWER_MAX) || (decimal->power < -REAL_POWER_MAX)));
}

status_t number_read_real(const char** const text, double* const out_value)
{
    FSW_ASSERT((text != NULL) && (*text != NULL));
    const char* at = next_word(*text);
    if (*at == '\0') {
        return STATUS_EMPTY;
    }
    const bool is_negative = (*at == '-');
    at += is_negative ? 1 : 0;
    decimal_t decimal = {0U, 0U, 0};
    if (!take_decimal(&at, &decimal)) {
        return STATUS_INVALID;
    }
    if (is_beyond_exact(&decimal)) {
        return STATUS_OUT_OF_RANGE;
    }
    const double value = (decimal.digits == 0U) ? 0.0 : scaled(&decimal);
    *out_value         = is_negative ? -value : value;
    *text              = next_word(at);
    return STATUS_OK;
}

/// Read one of the words true, false, 1 and 0.
static status_t read_bool(const char** const text, bool* const out_value)
{
    static const char* const words[] = {"false", "true", "0", "1"};
    const char* const at             = next_word(*text);
    for (size_t i = 0U; i < (sizeof words / sizeof words[0]); i++) {
        const size_t length = strlen(words[i]);
        if ((strncmp(at, words[i], length) == 0) && is_word_end(at[length])) {
            *out_value = ((i % 2U) == 1U);
            *text      = next_word(&at[length]);
            return STATUS_OK;
        }
    }
    return (*at == '\0') ? STATUS_EMPTY : STATUS_INVALID;
}

/// Read an integer and store it if it is in the range of its type, in two's complement of its width.
static status_t read_integer_of(const char** const text, const value_type_t type, void* const memory)
{
    const bool is_signed = (type > VALUE_UINT64);
    const uint64_t most =
        (is_signed ? (uint64_t)INT64_MAX : UINT64_MAX) >> (8U * (sizeof most - value_size(type)));
    const char* at   = *text;
    bool is_negative = false;
    uint64_t bits    = 0U;
    status_t status  = read_integer(&at, &is_negative, &bits);
    if (status != STATUS_OK) {
        return status;
    }
    if (is_negative && is_signed) {
        status = (bits <= (most + 1U)) ? STATUS_OK : STATUS_OUT_OF_RANGE;
        bits   = 0U - bits;
    } else {
        status = (!is_negative && (bits <= most)) ? STATUS_OK : STATUS_OUT_OF_RANGE;
    }
    if (status == STATUS_OK) {
        value_store(type, bits, memory);
        *text = at;
    }
    return status;
}

status_t number_read_unsigned(const char** const text, uint64_t* const out_value)
{
    return number_read_value(text, VALUE_UINT64, out_value);
}

static status_t read_float(const char** const text, float* const memory)
{
    double value          = 0.0;
    const char* at        = *text;
    const status_t status = number_read_real(&at, &value);
    if (status != STATUS_OK) {
        return status;
    }
    *memory = (float)value; // In the range of float, because number_read_real returns less than 10^37.
    *text   = at;
    return STATUS_OK;
}

status_t number_read_value(const char** const text, const value_type_t type, void* const memory)
{
    FSW_ASSERT((text != NULL) && (memory != NULL) && (type < VALUE_SCALARS));
    if (type == VALUE_BOOL) {
        return read_bool(text, memory);
    }
    if (type == VALUE_DOUBLE) {
        return number_read_real(text, memory);
    }
    if (type == VALUE_FLOAT) {
        return read_float(text, memory);
    }
    return read_integer_of(text, type, memory);
}

bool number_is_end(const char* const text)
{
    FSW_ASSERT(text != NULL);
    return *next_word(text) == '\0';
}
