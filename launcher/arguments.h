// SPDX-License-Identifier: Apache-2.0
/// The argument list of a program to be started, in the form that osal_process_start needs: a list of texts
/// with null at the end.
///
///     arguments_t arguments = {.count = 0U};
///     arguments_add_joined(&arguments, directory, "simulator");
///     arguments_add_number(&arguments, "--seed", 7U);
///     const osal_process_start_t start = {.arguments = arguments.list, ...};
///
/// Ownership  The caller provides arguments_t, all zero. It must not be moved, because the list points into
///            it.
/// Context    Any.
/// Errors     None; more arguments or text than fit are a coding error.
#ifndef LAUNCHER_ARGUMENTS_H
#define LAUNCHER_ARGUMENTS_H

#include "base/text.h"

#include <stddef.h>
#include <stdint.h>

#define ARGUMENTS_MAX 176U       ///< Capacity of the list, including the null at its end.
#define ARGUMENTS_TEXT_MAX 8192U ///< Characters of all arguments, including a NUL after each.

typedef struct { // Private, except list and count: read-only.
    const char* list[ARGUMENTS_MAX];
    size_t count;
    char storage[ARGUMENTS_TEXT_MAX];
    text_t text;
} arguments_t;

/// Add one argument.
void arguments_add(arguments_t* arguments, const char* argument);
/// Add the concatenation of two texts as one argument.
void arguments_add_joined(arguments_t* arguments, const char* first, const char* second);
/// Add each word of a list that has null at the end.
void arguments_add_words(arguments_t* arguments, const char* const* words);
/// Add an option and its value.
void arguments_add_option(arguments_t* arguments, const char* option, const char* value);
/// Add an option and a number in decimal.
void arguments_add_number(arguments_t* arguments, const char* option, uint64_t number);

#endif // LAUNCHER_ARGUMENTS_H
