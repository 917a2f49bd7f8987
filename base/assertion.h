// SPDX-License-Identifier: Apache-2.0
/// Assertion for coding errors only: never on a value from a wire, a file or a user. A failed assertion
/// writes file and line through the hook and ends the program; the launcher and the supervisor then treat it
/// like any other death of a process. The program does not contain the text of the condition: it is in that
/// line of the source (docs/decisions/0009).
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

/// One for each source file that asserts. The compiler knows that the file name is constant, so each
/// assertion costs only its line number.
static __attribute__((noreturn, noinline, cold, unused)) void assertion_failed_here(const char* const file,
                                                                                    const int line)
{
    fsw_assertion_failed(file, line);
}

#endif // BASE_ASSERTION_H
