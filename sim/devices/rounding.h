// SPDX-License-Identifier: Apache-2.0
/// Rounding of physical values to the numbers of objects.
#ifndef SIM_DEVICES_ROUNDING_H
#define SIM_DEVICES_ROUNDING_H

#include <math.h>
#include <stdint.h>

#define ROUNDING_ALL_WHOLE 4503599627370496.0 ///< 2^52: from here on, every double is a whole number.

/// Returns the nearest whole number, halves away from zero: the result of llround. Inline, because each step
/// of a flight rounds some 14 values, and the function of the C library needs three times the instructions.
static inline int64_t rounded(const double value)
{
    if (!(fabs(value) < ROUNDING_ALL_WHOLE)) { // Also for NaN.
        return (int64_t)llround(value);
    }
    const int64_t whole = (int64_t)value;
    const double rest   = value - (double)whole; // Exact.
    return whole + ((rest >= 0.5) ? 1 : 0) - ((rest <= -0.5) ? 1 : 0);
}

#endif // SIM_DEVICES_ROUNDING_H
