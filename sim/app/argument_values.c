// SPDX-License-Identifier: Apache-2.0
#include "sim/app/argument_values.h"

#include "osal/include/osal/console.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

bool argument_refuse(const char* const option, const char* const value, const char* const expected)
{
    char line[256];
    (void)snprintf(line, sizeof line, "simulator: --%.40s '%.80s': expected %.80s (see --help)", option,
                   value, expected);
    osal_console_print_error(line);
    return false;
}

void argument_refuse_word(const char* const word, const char* const expected)
{
    char line[256];
    (void)snprintf(line, sizeof line, "simulator: found '%.80s', expected %.80s (see --help)", word,
                   expected);
    osal_console_print_error(line);
}

bool argument_count(const char* const option, const char* const text, const uint64_t limit,
                    uint64_t* const out_value)
{
    char* end                      = NULL;
    errno                          = 0;
    const unsigned long long value = strtoull(text, &end, 0);
    const bool is_number           = (text[0] >= '0') && (text[0] <= '9') && (*end == '\0') && (errno == 0);
    if (!is_number || (value > limit)) {
        char expected[64];
        (void)snprintf(expected, sizeof expected, "a whole number from 0 to %llu", (unsigned long long)limit);
        return argument_refuse(option, text, expected);
    }
    *out_value = value;
    return true;
}

bool argument_unsigned(const char* const option, const char* const text, const uint64_t limit,
                       unsigned* const out_value)
{
    uint64_t value  = 0U;
    const bool good = argument_count(option, text, limit, &value);
    *out_value      = (unsigned)value;
    return good;
}

bool argument_seconds(const char* const option, const char* const text, uint64_t* const out_ns)
{
    char* end          = NULL;
    const double value = strtod(text, &end);
    if ((end == text) || (*end != '\0') || !(value >= 0.0) || (value > 1e9)) {
        return argument_refuse(option, text, "a time in seconds");
    }
    *out_ns = (uint64_t)llround(value * 1e9);
    return true;
}
