// SPDX-License-Identifier: Apache-2.0
/// Observations of a test fixture as lines of text in order, for tests that expect certain lines.
#ifndef TEST_SUPPORT_FIXTURE_LINES_H
#define TEST_SUPPORT_FIXTURE_LINES_H

#include <stdbool.h>

/// Add a line, as printf does.
void fixture_line(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// Returns the lines since the last call; the next call begins after them.
const char* fixture_look(void);
/// Remove all lines.
void fixture_forget(void);
/// True if a line since the last fixture_look begins with `start`; does not consume lines.
bool fixture_has(const char* start);
/// Returns how often a part occurs in a text.
unsigned fixture_count(const char* text, const char* part);
/// Returns how many lines of a text begin with `start`; each line of the text has an end.
unsigned fixture_count_lines(const char* text, const char* start);
/// Expect exactly these lines since the last call.
#define fixture_expect(lines) fixture_expect_at((lines), __LINE__)
void fixture_expect_at(const char* lines, unsigned line);

/// Note requests and their ends by number: at most one end may be reported for each request sent, whatever
/// the test checks.
void fixture_sent(unsigned number);
void fixture_end(unsigned number);
/// Forget the noted requests, because their numbers start again.
void fixture_forget_ends(void);

#endif // TEST_SUPPORT_FIXTURE_LINES_H
