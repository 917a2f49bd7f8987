// SPDX-License-Identifier: Apache-2.0
/// How a check of a random flight reports that an invariant does not hold, and which fault is planted.
#ifndef TEST_FUZZ_FLIGHT_VIOLATIONS_H
#define TEST_FUZZ_FLIGHT_VIOLATIONS_H

#include <stdbool.h>

#define HOLDS(condition, apid)                                                                               \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            random_flight_violated(#condition, (apid));                                                      \
        }                                                                                                    \
    } while (0)

/// Write the condition and the last telecommands to the file of failures, and abort.
void random_flight_violated(const char* condition, unsigned apid);
/// True if the environment variable RANDOM_FLIGHT_FAULT names this fault.
bool random_flight_is_planted(const char* name);

#endif // TEST_FUZZ_FLIGHT_VIOLATIONS_H
