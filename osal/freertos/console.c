// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/console.h"

#include "base/assertion.h"
#include "osal/freertos/semihosting.h"

#include <FreeRTOS.h>
#include <stddef.h>
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

void osal_console_print_line(const char* const line)
{
    put(line, "\n");
}

void osal_console_print_error(const char* const line)
{
    put(line, "\n");
}

void osal_console_print(const char* const text)
{
    put(text, "");
}

bool osal_console_is_terminal(void)
{
    return false;
}
