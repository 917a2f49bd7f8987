// SPDX-License-Identifier: Apache-2.0
/// Output of the programs in test/board.
#ifndef TEST_SUPPORT_BOARD_NUMBERS_H
#define TEST_SUPPORT_BOARD_NUMBERS_H

#include <stddef.h>
#include <stdint.h>

/// Print a line on the console: word, name and numbers, the numbers with a space before each. A line has at
/// most 127 characters; the rest is cut.
void print_numbers(const char* word, const char* name, const uint32_t* numbers, size_t count);

#endif // TEST_SUPPORT_BOARD_NUMBERS_H
