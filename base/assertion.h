// SPDX-License-Identifier: Apache-2.0
/// Assertion for coding errors only: never on a value that came from a wire, a file or a person.
/// A failed assertion writes file and line through the hook and ends the program; the launcher and the
/// supervisor then treat it like any other death of a process. What did not hold stands in that line of the
/// source: the program does not carry its text (docs/decisions/0009).
#ifndef BASE_ASSERTION_H
#define BASE_ASSERTION_H

#define FSW_ASSERT(condition)                                                                                \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            assertion_failed_here(__FILE_NAME__, __LINE__);                                                  \
        }                                                                                                    \
    } while (0)

/// Called by FSW_ASSERT. Supplied by the program (osal/posix/assertion.c, or a test). Does not return.
void fsw_assertion_failed(const char* file, int line) __attribute__((noreturn));

/// One for each source file that asserts. The compiler sees that the file is always the same, so that a place
/// costs its line number and nothing else.
static __attribute__((noreturn, noinline, cold, unused)) void assertion_failed_here(const char* const file,
                                                                                    const int line)
{
    fsw_assertion_failed(file, line);
}

#endif // BASE_ASSERTION_H
