// SPDX-License-Identifier: Apache-2.0
/// The console of a program: whole lines to standard output or error. One call writes a whole line, so that
/// lines of several processes do not mix. Text is dropped if the reader takes nothing for 100 ms.
#ifndef OSAL_CONSOLE_H
#define OSAL_CONSOLE_H

#include <stdbool.h>

/// Write `line` and a line end to standard output.
void osal_console_print_line(const char* line);
/// Write `line` and a line end to standard error.
void osal_console_print_error(const char* line);
/// Write text without a line end, for example progress.
void osal_console_print(const char* text);
/// True if standard output is a terminal.
bool osal_console_is_terminal(void);
/// If the only argument is --version, write `name version`; if it is --help and `usage` is not null, write
/// the usage. True: text was written, and the program must end with exit code 0.
bool osal_console_introduce(int argument_count, char* const arguments[], const char* name, const char* usage);

#endif // OSAL_CONSOLE_H
