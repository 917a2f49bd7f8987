// SPDX-License-Identifier: Apache-2.0
#include "launcher/arguments.h"

#include "base/assertion.h"

static void argument_begin(arguments_t* const arguments)
{
    arguments->list[arguments->count] = &arguments->storage[arguments->text.length];
    arguments->count++;
    FSW_ASSERT(arguments->count < ARGUMENTS_MAX);
    arguments->list[arguments->count] = NULL;
}

void arguments_add_joined(arguments_t* const arguments, const char* const first, const char* const second)
{
    if (arguments->count == 0U) {
        arguments->text = text_in(arguments->storage, sizeof arguments->storage);
    }
    argument_begin(arguments);
    text_add(&arguments->text, first);
    text_add(&arguments->text, second);
    FSW_ASSERT(!arguments->text.cut);
    arguments->text.length++; // The NUL stays in the storage; the next argument begins after it.
}

void arguments_add(arguments_t* const arguments, const char* const argument)
{
    arguments_add_joined(arguments, argument, "");
}

void arguments_add_words(arguments_t* const arguments, const char* const* const words)
{
    for (size_t i = 0U; words[i] != NULL; i++) {
        arguments_add(arguments, words[i]);
    }
}

void arguments_add_option(arguments_t* const arguments, const char* const option, const char* const value)
{
    arguments_add(arguments, option);
    arguments_add(arguments, value);
}

void arguments_add_number(arguments_t* const arguments, const char* const option, const uint64_t number)
{
    char digits[24];
    text_t text = text_in(digits, sizeof digits);
    text_add_unsigned(&text, number);
    arguments_add_option(arguments, option, digits);
}
