// SPDX-License-Identifier: Apache-2.0
/// Assertion for coding errors only: never on a value from a wire, a file or a user. A failed assertion
/// writes file and line through the hook and ends the program; the launcher and the supervisor then treat it
/// like any other death of a process. The program does not contain the text of the condition, because the
/// file and the line identify it (docs/decisions/0009).
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

/// Each source file that asserts has one copy of this function. The file name is a constant in it, so each
/// assertion adds only its line number to the program.
static __attribute__((noreturn, noinline, cold, unused)) void assertion_failed_here(const char* const file,
                                                                                    const int line)
{
    fsw_assertion_failed(file, line);
}

#endif // BASE_ASSERTION_H
