// SPDX-License-Identifier: Apache-2.0
#include "test/support/board/numbers.h"

#include "base/text.h"
#include "osal/include/osal/console.h"

#define LINE_MAX 128U

void print_numbers(const char* const word, const char* const name, const uint32_t* const numbers,
                   const size_t count)
{
    char line[LINE_MAX];
    text_t text = text_in(line, sizeof line);
    text_add(&text, word);
    text_add(&text, name);
    for (size_t i = 0U; i < count; i++) {
        text_add(&text, " ");
        text_add_unsigned(&text, numbers[i]);
    }
    osal_console_print_line(line);
}
