// SPDX-License-Identifier: Apache-2.0
/// Values of the simulator's command line. An invalid value is refused with a message on the console: the
/// option, the value, and the expected values.
#ifndef SIM_APP_ARGUMENT_VALUES_H
#define SIM_APP_ARGUMENT_VALUES_H

#include <stdbool.h>
#include <stdint.h>

/// Report an invalid value of an option on the console. Always returns false.
bool argument_refuse(const char* option, const char* value, const char* expected);
/// Report a word that is neither a known option nor the value of one.
void argument_refuse_word(const char* word, const char* expected);
/// Read a whole number from 0 to `limit`, decimal, octal (0...) or hexadecimal (0x...). Returns false if the
/// value is refused.
bool argument_count(const char* option, const char* text, uint64_t limit, uint64_t* out_value);
bool argument_unsigned(const char* option, const char* text, uint64_t limit, unsigned* out_value);
/// Read a time in seconds, 0 to 1e9, and convert it to nanoseconds. Returns false if the value is refused.
bool argument_seconds(const char* option, const char* text, uint64_t* out_ns);

#endif // SIM_APP_ARGUMENT_VALUES_H
