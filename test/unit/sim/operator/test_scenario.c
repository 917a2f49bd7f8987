// SPDX-License-Identifier: Apache-2.0
// Reading of scenario files: lines of one actor, times, numbers, and every error with its line.
#include "sim/operator/scenario.h"
#include "test/unit/sim/operator/script_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static char error[SCENARIO_ERROR_MAX];
static char seen[2048];     // Lines that the callback received.
static unsigned lines_left; // Number of lines that the callback still accepts.

void setUp(void)
{
    seen[0]    = '\0';
    lines_left = 1000U;
}

void tearDown(void)
{
    script_file_remove();
}

static status_t take(void* context, const scenario_line_t* line, char text[SCENARIO_ERROR_MAX])
{
    (void)context;
    if (lines_left == 0U) {
        return scenario_error(line, line->word[0], "no more lines", text);
    }
    lines_left--;
    size_t used = strlen(seen);
    used += (size_t)snprintf(seen + used, sizeof seen - used, "%u@%llu", line->line,
                             (unsigned long long)line->time_ns);
    for (size_t i = 0U; i < line->word_count; i++) {
        used += (size_t)snprintf(seen + used, sizeof seen - used, " %s", line->word[i]);
    }
    (void)snprintf(seen + used, sizeof seen - used, ";");
    return STATUS_OK;
}

static status_t read_text(const char* text, const char* actor)
{
    return scenario_read(script_file_write(text), actor, take, NULL, error);
}

static void only_lines_of_the_actor_are_passed_on(void)
{
    const char* text = "# title\n\n0 hand rest\n1.5 fault unplug robot 0x11 # why\n  2\thand  move 1 2 3\r\n"
                       "0.5 operator cmd MANIPULATOR.MOVE_TO position=1,2\n2 hand hold";
    TEST_ASSERT_EQUAL(STATUS_OK, read_text(text, "hand"));
    TEST_ASSERT_EQUAL_STRING("3@0 rest;5@2000000000 move 1 2 3;7@2000000000 hold;", seen);
    seen[0] = '\0';
    TEST_ASSERT_EQUAL(STATUS_OK, read_text(text, "fault"));
    TEST_ASSERT_EQUAL_STRING("4@1500000000 unplug robot 0x11;", seen);
}

static void empty_file_has_no_lines(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, read_text("", "hand"));
    TEST_ASSERT_EQUAL(STATUS_OK, read_text("\n# nothing\n", "hand"));
    TEST_ASSERT_EQUAL_STRING("", seen);
}

static void times_keep_their_nanoseconds(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      read_text("0.0005 hand a\n64.1235 hand b\n99999.999999999 hand c\n", "hand"));
    TEST_ASSERT_EQUAL_STRING("1@500000 a;2@64123500000 b;3@99999999999999 c;", seen);
}

typedef struct {
    const char* text;
    const char* message; // After the path.
} bad_t;

static void bad_lines_are_reported_with_their_number(void)
{
    static const bad_t bad[] = {
        {"0 hand rest\nsoon hand rest\n", ":2: found 'soon', expected a time in s, 0 to 1000000"},
        {"-1 hand rest\n", ":1: found '-1', expected a time in s, 0 to 1000000"},
        {"nan hand rest\n", ":1: found 'nan', expected a time in s, 0 to 1000000"},
        {"1e9 hand rest\n", ":1: found '1e9', expected a time in s, 0 to 1000000"},
        {"1s hand rest\n", ":1: found '1s', expected a time in s, 0 to 1000000"},
        {"\n\n1 robot rest\n", ":3: found 'robot', expected an actor: hand, fault, operator or ground"},
        {"1\n", ":1: found 'end of line', expected an actor: hand, fault, operator or ground"},
        {"1 hand\n", ":1: found 'end of line', expected a verb"},
        {"1 hand # rest\n", ":1: found 'end of line', expected a verb"},
        {"2 hand rest\n1 hand hold\n", ":2: found 'an earlier time', expected times that do not decrease"},
        {"1 hand a 1 2 3 4 5 6 7 8 9 10 11 12\n",
         ":1: found 'too many words', expected at most 11 arguments"},
    };
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        char expected[SCENARIO_ERROR_MAX];
        TEST_ASSERT_EQUAL(STATUS_INVALID, read_text(bad[i].text, "hand"));
        (void)snprintf(expected, sizeof expected, "%s%s", script_file_write(bad[i].text), bad[i].message);
        TEST_ASSERT_EQUAL(STATUS_INVALID,
                          scenario_read(script_file_write(bad[i].text), "hand", take, NULL, error));
        TEST_ASSERT_EQUAL_STRING(bad[i].message, strchr(error, ':'));
    }
}

static void line_too_long_is_refused(void)
{
    static char text[SCENARIO_LINE_MAX * 2U];
    (void)snprintf(text, sizeof text, "1 hand %0600d\n", 1);
    TEST_ASSERT_EQUAL(STATUS_INVALID, read_text(text, "hand"));
    TEST_ASSERT_NOT_NULL(strstr(error, "a line too long"));
    (void)snprintf(text, sizeof text, "1 hand %0503d\n", 1); // 511 octets with its end
    TEST_ASSERT_EQUAL(STATUS_OK, read_text(text, "hand"));
}

static void a_missing_file_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, scenario_read("/nowhere/x.scn", "hand", take, NULL, error));
    TEST_ASSERT_EQUAL_STRING("/nowhere/x.scn: No such file or directory", error);
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_read("/tmp", "hand", take, NULL, error));
}

static void the_first_refusal_of_the_callback_ends_the_reading(void)
{
    lines_left = 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, read_text("1 hand a\n2 hand b\n3 hand c\n", "hand"));
    TEST_ASSERT_EQUAL_STRING("1@1000000000 a;", seen);
    TEST_ASSERT_NOT_NULL(strstr(error, ":2: found 'b', expected no more lines"));
}

static void numbers_outside_of_their_range_are_refused(void)
{
    const scenario_line_t line = {
        .path = "f", .line = 4U, .word_count = 4U, .word = {"v", "2.5", "2x", "nan"}};
    double value = 0.0;
    TEST_ASSERT_EQUAL(STATUS_OK, scenario_number(&line, 1U, "force [N]", 0.0, 2.5, &value, error));
    TEST_ASSERT_TRUE(value == 2.5);
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_number(&line, 1U, "force [N]", 0.0, 2.4, &value, error));
    TEST_ASSERT_EQUAL_STRING("f:4: found '2.5', expected force [N] from 0 to 2.4", error);
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_number(&line, 2U, "force [N]", 0.0, 9.0, &value, error));
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_number(&line, 3U, "force [N]", 0.0, 9.0, &value, error));
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_number(&line, 4U, "force [N]", 0.0, 9.0, &value, error));
    TEST_ASSERT_EQUAL_STRING("f:4: found 'end of line', expected force [N] from 0 to 9", error);
    TEST_ASSERT_TRUE(value == 2.5);
}

static void a_wrong_number_of_arguments_is_refused(void)
{
    const scenario_line_t line = {.path = "f", .line = 1U, .word_count = 3U, .word = {"v", "1", "2"}};
    TEST_ASSERT_EQUAL(STATUS_OK, scenario_arguments(&line, 2U, "v <a> <b>", error));
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_arguments(&line, 3U, "v <a> <b> <c>", error));
    TEST_ASSERT_EQUAL_STRING("f:1: found 'end of line', expected v <a> <b> <c>", error);
    TEST_ASSERT_EQUAL(STATUS_INVALID, scenario_arguments(&line, 1U, "v <a>", error));
    TEST_ASSERT_EQUAL_STRING("f:1: found '2', expected v <a>", error);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_lines_of_the_actor_are_passed_on);
    RUN_TEST(empty_file_has_no_lines);
    RUN_TEST(times_keep_their_nanoseconds);
    RUN_TEST(bad_lines_are_reported_with_their_number);
    RUN_TEST(line_too_long_is_refused);
    RUN_TEST(a_missing_file_is_reported);
    RUN_TEST(the_first_refusal_of_the_callback_ends_the_reading);
    RUN_TEST(numbers_outside_of_their_range_are_refused);
    RUN_TEST(a_wrong_number_of_arguments_is_refused);
    return UNITY_END();
}
