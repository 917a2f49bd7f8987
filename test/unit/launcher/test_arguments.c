// SPDX-License-Identifier: Apache-2.0
#include "launcher/arguments.h"

#include "unity.h"

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
    arguments_add_number(&arguments, UINT64_MAX);
    TEST_ASSERT_EQUAL_UINT64(3U, arguments.count);
    TEST_ASSERT_EQUAL_STRING("build/bin/simulator", arguments.list[0]);
    TEST_ASSERT_EQUAL_STRING("", arguments.list[1]);
    TEST_ASSERT_EQUAL_STRING("18446744073709551615", arguments.list[2]);
    TEST_ASSERT_NULL(arguments.list[3]);
}

static void all_places_but_the_last_are_filled(void)
{
    for (unsigned i = 0U; i < (ARGUMENTS_MAX - 1U); i++) {
        arguments_add_number(&arguments, i);
    }
    TEST_ASSERT_EQUAL_STRING("94", arguments.list[ARGUMENTS_MAX - 2U]);
    TEST_ASSERT_NULL(arguments.list[ARGUMENTS_MAX - 1U]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_list_ends_with_null_after_each_argument);
    RUN_TEST(all_places_but_the_last_are_filled);
    return UNITY_END();
}
