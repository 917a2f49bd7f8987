// SPDX-License-Identifier: Apache-2.0
/// Reads numbers from text, without locale and without the C library, for descriptors and their initial
/// values.
///
/// Integers: decimal, for signed types with optional '-', or 0x and hexadecimal digits. Reals: decimal with
/// optional '-', fraction and exponent, at most 15 significant digits and a power of ten within +-22 after
/// them, so that the result is the correctly rounded double on every machine; anything longer is refused,
/// never rounded silently. A word ends at a space or at the end of the text.
///
/// Context    Any.
/// Time       O(length).
#ifndef BASE_NUMBER_H
#define BASE_NUMBER_H

#include "base/status.h"
#include "base/value.h"

#include <stdbool.h>
#include <stdint.h>

/// Read one number at *text, and move *text past this word and the spaces after it; on error *text does not
/// change. STATUS_OK; STATUS_EMPTY (no word left); STATUS_INVALID (not a number of this kind);
/// STATUS_OUT_OF_RANGE (an unsigned integer beyond 64 bits or with '-', or a real with too many digits or too
/// large an exponent).
MUST_USE status_t number_read_unsigned(const char** text, uint64_t* out_value);
MUST_USE status_t number_read_real(const char** text, double* out_value);
/// Read one scalar of a type into host memory (BOOL: true, false, 1, 0; FLOAT: rounded). Statuses as above;
/// STATUS_OUT_OF_RANGE also if the value does not fit the type.
MUST_USE status_t number_read_value(const char** text, value_type_t type, void* memory);
/// True if only spaces follow.
bool number_is_end(const char* text);

#endif // BASE_NUMBER_H
