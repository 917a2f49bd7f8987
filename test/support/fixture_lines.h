// SPDX-License-Identifier: Apache-2.0
/// What a test fixture has seen, as lines of text in their order, for tests that say what they expect in
/// lines.
#ifndef TEST_SUPPORT_FIXTURE_LINES_H
#define TEST_SUPPORT_FIXTURE_LINES_H

#include <stdbool.h>

/// Add a line, as printf does.
void fixture_line(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// Lines since the last look; the next look begins behind them.
const char* fixture_look(void);
void fixture_forget(void);
/// True if a line since the last look begins with `start`; does not look.
bool fixture_has(const char* start);
/// Check the lines since the last look.
#define fixture_expect(lines) fixture_expect_at((lines), __LINE__)
void fixture_expect_at(const char* lines, unsigned line);

#endif // TEST_SUPPORT_FIXTURE_LINES_H
