// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/console.h"

#include "base/version.h"

#include <stddef.h>
#include <string.h>

bool osal_console_introduce(const int argument_count, char* const arguments[], const char* const name,
                            const char* const usage)
{
    const char* const word = (argument_count == 2) ? arguments[1] : "";
    const bool is_version  = (strcmp(word, "--version") == 0);
    const bool is_help     = (usage != NULL) && (strcmp(word, "--help") == 0);
    if (is_version) {
        osal_console_print(name);
        osal_console_print_line(" " HIROSCO_VERSION);
    } else if (is_help) {
        osal_console_print_line(usage);
    } else {
        // The program itself evaluates its arguments.
    }
    return is_version || is_help;
}
