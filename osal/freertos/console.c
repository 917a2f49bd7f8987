// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/console.h"

#include "base/assertion.h"
#include "base/version.h"
#include "osal/freertos/semihosting.h"

#include <FreeRTOS.h>
#include <string.h>
#include <task.h>

/// While a line is written no other task runs, so that the lines of several tasks do not mix.
static void put(const char* const text, const char* const line_end)
{
    FSW_ASSERT(text != NULL);
    vTaskSuspendAll();
    semihosting_print(text);
    semihosting_print(line_end);
    (void)xTaskResumeAll();
}

void osal_console_say(const char* const line)
{
    put(line, "\n");
}

void osal_console_complain(const char* const line)
{
    put(line, "\n");
}

void osal_console_put(const char* const text)
{
    put(text, "");
}

bool osal_console_is_terminal(void)
{
    return false;
}

bool osal_console_introduce(const int argument_count, char* const arguments[], const char* const name,
                            const char* const usage)
{
    const char* const word = (argument_count == 2) ? arguments[1] : "";
    const bool is_version  = (strcmp(word, "--version") == 0);
    const bool is_help     = (usage != NULL) && (strcmp(word, "--help") == 0);
    if (is_version) {
        osal_console_put(name);
        osal_console_say(" " HIROSCO_VERSION);
    } else if (is_help) {
        osal_console_say(usage);
    } else {
        // The program itself evaluates its arguments.
    }
    return is_version || is_help;
}
