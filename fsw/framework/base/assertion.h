// SPDX-License-Identifier: Apache-2.0
/// Assertion for coding errors only: never on a value that came from a wire, a file or a person.
/// A failed assertion writes file and line through the hook and ends the program; the launcher and the
/// supervisor then treat it like any other death of a process.
#ifndef FSW_FRAMEWORK_BASE_ASSERTION_H
#define FSW_FRAMEWORK_BASE_ASSERTION_H

#define FSW_ASSERT(condition)                                                                                \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fsw_assertion_failed(__FILE__, __LINE__, #condition);                                            \
        }                                                                                                    \
    } while (0)

/// Called by FSW_ASSERT. Supplied by the program (osal/posix/assertion.c, or a test). Does not return.
void fsw_assertion_failed(const char* file, int line, const char* condition) __attribute__((noreturn));

#endif // FSW_FRAMEWORK_BASE_ASSERTION_H
