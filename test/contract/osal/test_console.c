// SPDX-License-Identifier: Apache-2.0
// What a program can query about its console. posix/test_console.c reads the text that appears on it.
#include "osal/include/osal/console.h"

#include "base/assertion.h"
#include "test/support/assertion.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void empty_texts_and_parts_of_lines_are_accepted(void)
{
    osal_console_print("");
    osal_console_print("a part of a line and ");
    osal_console_print_line("its end");
    osal_console_print_line("");
    osal_console_print_error("a complaint");
}

static char program[] = "program";
static char version[] = "--version";
static char help[]    = "--help";
static char run[]     = "run";

static bool is_introduced(int count, char* first, char* second, const char* usage)
{
    char* const arguments[] = {program, first, second, NULL};
    return osal_console_introduce(count, arguments, "name", usage);
}

static void version_and_usage_are_printed_if_requested_by_the_only_argument(void)
{
    TEST_ASSERT_TRUE(is_introduced(2, version, NULL, "usage: how"));
    TEST_ASSERT_TRUE(is_introduced(2, version, NULL, NULL));
    TEST_ASSERT_TRUE(is_introduced(2, help, NULL, "usage: how"));
    TEST_ASSERT_FALSE(is_introduced(2, help, NULL, NULL));
    TEST_ASSERT_FALSE(is_introduced(2, run, NULL, "usage: how"));
    TEST_ASSERT_FALSE(is_introduced(3, run, help, "usage: how"));
    TEST_ASSERT_FALSE(is_introduced(1, run, help, "usage: how"));
}

static void hold(void)
{
    FSW_ASSERT(program[0] == 'p');
}

static void fail(void)
{
    FSW_ASSERT(program[0] == 'q');
}

static void a_failed_assertion_ends_the_function_and_one_that_holds_has_no_effect(void)
{
    TEST_ASSERT_FALSE(assertion_fails(hold));
    TEST_ASSERT_TRUE(assertion_fails(fail));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(empty_texts_and_parts_of_lines_are_accepted);
    RUN_TEST(version_and_usage_are_printed_if_requested_by_the_only_argument);
    RUN_TEST(a_failed_assertion_ends_the_function_and_one_that_holds_has_no_effect);
    return UNITY_END();
}
