// SPDX-License-Identifier: Apache-2.0
#include "test/support/fixture_lines.h"

#include "unity.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define LINES_SIZE 262144U

static char lines[LINES_SIZE];
static size_t length;
static size_t looked;

void fixture_line(const char* format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int added = vsnprintf(&lines[length], LINES_SIZE - length, format, arguments);
    va_end(arguments);
    TEST_ASSERT_TRUE((added >= 0) && ((length + (size_t)added + 2U) < LINES_SIZE));
    length += (size_t)added;
    lines[length++] = '\n';
    lines[length]   = '\0';
}

const char* fixture_look(void)
{
    const char* const text = &lines[looked];
    looked                 = length;
    return text;
}

void fixture_forget(void)
{
    length   = 0U;
    looked   = 0U;
    lines[0] = '\0';
}

bool fixture_has(const char* start)
{
    const size_t size = strlen(start);
    for (const char* line = &lines[looked]; line[0] != '\0'; line = strchr(line, '\n') + 1) {
        if (strncmp(line, start, size) == 0) {
            return true;
        }
    }
    return false;
}

unsigned fixture_count(const char* text, const char* part)
{
    unsigned count = 0U;
    for (const char* at = strstr(text, part); at != NULL; at = strstr(at + 1, part)) {
        count++;
    }
    return count;
}

unsigned fixture_count_lines(const char* text, const char* start)
{
    unsigned count = 0U;
    for (const char* line = text; line[0] != '\0'; line = strchr(line, '\n') + 1) {
        count += (strncmp(line, start, strlen(start)) == 0) ? 1U : 0U;
    }
    return count;
}

void fixture_expect_at(const char* expected, unsigned line)
{
    const char* const found = fixture_look();
    if (strcmp(expected, found) != 0) {
        (void)printf("expected:\n%s\nfound:\n%s\n", expected, found);
        UNITY_TEST_FAIL(line, "other lines than expected");
    }
}

enum {
    NOT_SENT,
    SENT,
    ENDED
};
static unsigned char ends[0x4000];

void fixture_sent(unsigned number)
{
    ends[number & 0x3FFFU] = SENT;
}

void fixture_end(unsigned number)
{
    unsigned char* const end = &ends[number & 0x3FFFU];
    TEST_ASSERT_MESSAGE(*end != ENDED, "a request has ended twice");
    *end = (*end == SENT) ? ENDED : NOT_SENT;
}

void fixture_forget_ends(void)
{
    (void)memset(ends, NOT_SENT, sizeof ends);
}
