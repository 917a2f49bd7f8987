// SPDX-License-Identifier: Apache-2.0
// The list of arguments of a process that the launcher starts.
#include "launcher/arguments.h"

#include "unity.h"

#include <stdlib.h>

static arguments_t arguments;

void setUp(void)
{
    arguments = (arguments_t){.count = 0U};
}

void tearDown(void)
{
}

static void the_list_ends_with_null_after_each_argument(void)
{
    arguments_add_joined(&arguments, "build/bin/", "simulator");
    TEST_ASSERT_NULL(arguments.list[1]);
    arguments_add(&arguments, "");
    arguments_add_number(&arguments, "--seed", UINT64_MAX);
    arguments_add_option(&arguments, "--run", "/name");
    arguments_add_words(&arguments, (const char* const[]){"x", "y", NULL});
    static const char* const expected[] = {
        "build/bin/simulator", "", "--seed", "18446744073709551615", "--run", "/name", "x", "y"};
    TEST_ASSERT_EQUAL_UINT64(8U, arguments.count);
    TEST_ASSERT_EQUAL_STRING_ARRAY(expected, arguments.list, 8U);
    TEST_ASSERT_NULL(arguments.list[8]);
}

static void all_entries_but_the_last_are_filled(void)
{
    arguments_add(&arguments, "program");
    for (unsigned i = 1U; i < (ARGUMENTS_MAX - 1U); i += 2U) {
        arguments_add_number(&arguments, "--number", i);
    }
    TEST_ASSERT_EQUAL_STRING("program", arguments.list[0]);
    TEST_ASSERT_EQUAL_UINT64(ARGUMENTS_MAX - 3U, strtoul(arguments.list[ARGUMENTS_MAX - 2U], NULL, 10));
    TEST_ASSERT_NULL(arguments.list[ARGUMENTS_MAX - 1U]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_list_ends_with_null_after_each_argument);
    RUN_TEST(all_entries_but_the_last_are_filled);
    return UNITY_END();
}
