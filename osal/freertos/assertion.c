// SPDX-License-Identifier: Apache-2.0
#include "base/assertion.h"

#include "osal/freertos/port.h"
#include "osal/freertos/semihosting.h"

#include <stddef.h>

#define ABORTED 134 // Exit code that a shell reports for SIGABRT.

void fsw_assertion_failed(const char* const file, const int line)
{
    char digits[12];
    size_t at     = sizeof digits - 1U;
    digits[at]    = '\0';
    unsigned rest = (line > 0) ? (unsigned)line : 0U;
    do {
        at--;
        digits[at] = (char)('0' + (char)(rest % 10U));
        rest /= 10U;
    } while ((rest != 0U) && (at > 0U));
    semihosting_print((file != NULL) ? file : "?");
    semihosting_print(":");
    semihosting_print(&digits[at]);
    semihosting_print(": assertion failed\n");
    port_exit(ABORTED);
}
