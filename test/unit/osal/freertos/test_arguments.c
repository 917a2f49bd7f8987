// SPDX-License-Identifier: Apache-2.0
// The command line of a program on a board.
#include "osal/freertos/port.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

static char line[512];
static char* list[PORT_ARGUMENTS_MAX + 1];
static int count;

void setUp(void)
{
    count = -1;
    (void)memset(list, 0, sizeof list);
}

void tearDown(void)
{
}

static const char* take(const char* const text)
{
    (void)strcpy(line, text);
    return port_take_arguments(line, list, &count);
}

static void words_are_arguments(void)
{
    TEST_ASSERT_NULL(take("program  --run name "));
    TEST_ASSERT_EQUAL_INT(3, count);
    TEST_ASSERT_EQUAL_STRING("program", list[0]);
    TEST_ASSERT_EQUAL_STRING("--run", list[1]);
    TEST_ASSERT_EQUAL_STRING("name", list[2]);
    TEST_ASSERT_NULL(list[3]);
    TEST_ASSERT_NULL(take(""));
    TEST_ASSERT_EQUAL_INT(0, count);
    TEST_ASSERT_NULL(list[0]);
}

static void the_argument_wire_is_not_passed_to_main(void)
{
    TEST_ASSERT_NULL(take("program wire=100000:100001 --proxy 0"));
    TEST_ASSERT_EQUAL_INT(3, count);
    TEST_ASSERT_EQUAL_STRING("--proxy", list[1]);
    const char* const error = take("program wire=1 --proxy 0");
    TEST_ASSERT_NOT_NULL(error);
    TEST_ASSERT_NOT_NULL(strstr(error, "wire=IN:OUT"));
}

static void one_argument_too_many_is_refused(void)
{
    char text[128] = "program";
    for (int i = 1; i < PORT_ARGUMENTS_MAX; i++) {
        (void)strcat(text, " a");
    }
    TEST_ASSERT_NULL(take(text));
    TEST_ASSERT_EQUAL_INT(PORT_ARGUMENTS_MAX, count);
    TEST_ASSERT_NULL(list[PORT_ARGUMENTS_MAX]);
    (void)strcat(text, " b");
    const char* const error = take(text);
    TEST_ASSERT_NOT_NULL(error);
    TEST_ASSERT_NOT_NULL(strstr(error, "16 arguments"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(words_are_arguments);
    RUN_TEST(the_argument_wire_is_not_passed_to_main);
    RUN_TEST(one_argument_too_many_is_refused);
    return UNITY_END();
}
