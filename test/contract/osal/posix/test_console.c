// SPDX-License-Identifier: Apache-2.0
// Console and assertion, observed from outside: a child with pipes for its output.
#define _GNU_SOURCE
#include "osal/include/osal/console.h"

#include "base/assertion.h"
#include "base/version.h"

#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define WRITERS 4
#define LINES 200

static char output[100000];
static size_t output_size;

void setUp(void)
{
}

void tearDown(void)
{
}

/// Run `speak` in `count` children, whose `descriptor` is one pipe, and collect their output. Returns the
/// wait status of the last child.
static int listen_to(int descriptor, int count, void (*speak)(int number))
{
    int ends[2];
    int exit_status = -1;
    TEST_ASSERT_EQUAL(0, pipe(ends));
    for (int i = 0; i < count; i++) {
        if (fork() == 0) {
            (void)dup2(ends[1], descriptor);
            speak(i);
            _exit(0);
        }
    }
    (void)close(ends[1]);
    output_size  = 0U;
    ssize_t size = 0;
    do {
        output_size += (size_t)size;
        size = read(ends[0], &output[output_size], sizeof output - 1U - output_size);
    } while (size > 0);
    output[output_size] = '\0';
    (void)close(ends[0]);
    while (wait(&exit_status) > 0) {
        // Wait for all children; `exit_status` is the status of the last.
    }
    return exit_status;
}

static void print_three_texts(int number)
{
    (void)number;
    osal_console_print_line("one");
    osal_console_print("two ");
    osal_console_print("");
    osal_console_print_line("");
    osal_console_print_error("to the other");
    _exit(osal_console_is_terminal() ? 1 : 0);
}

static void lines_and_parts_of_lines_go_to_their_stream_unchanged(void)
{
    TEST_ASSERT_EQUAL(0, listen_to(STDOUT_FILENO, 1, print_three_texts));
    TEST_ASSERT_EQUAL_STRING("one\ntwo \n", output);
    TEST_ASSERT_EQUAL(0, listen_to(STDERR_FILENO, 1, print_three_texts));
    TEST_ASSERT_EQUAL_STRING("to the other\n", output);
}

static void introduce(int number)
{
    static char program[]  = "program";
    static char version[]  = "--version";
    static char help[]     = "--help";
    static char run[]      = "run";
    char* const asked[][3] = {
        {program, version, NULL}, {program, help, NULL}, {program, run, NULL}, {program, run, help}};
    (void)number;
    bool is_right = osal_console_introduce(2, asked[0], "name", "usage: how");
    is_right      = osal_console_introduce(2, asked[0], "name", NULL) && is_right;
    is_right      = osal_console_introduce(2, asked[1], "name", "usage: how") && is_right;
    is_right      = !osal_console_introduce(2, asked[1], "name", NULL) && is_right;
    is_right      = !osal_console_introduce(2, asked[2], "name", "usage: how") && is_right;
    is_right      = !osal_console_introduce(3, asked[3], "name", "usage: how") && is_right;
    is_right      = !osal_console_introduce(1, asked[3], "name", "usage: how") && is_right;
    _exit(is_right ? 0 : 1);
}

static void name_version_and_usage_are_printed_on_request(void)
{
    TEST_ASSERT_EQUAL(0, listen_to(STDOUT_FILENO, 1, introduce));
    TEST_ASSERT_EQUAL_STRING("name " HIROSCO_VERSION "\nname " HIROSCO_VERSION "\nusage: how\n", output);
    TEST_ASSERT_EQUAL(0, listen_to(STDERR_FILENO, 1, introduce));
    TEST_ASSERT_EQUAL_STRING("", output);
}

static void print_many_lines(int number)
{
    char line[80];
    memset(line, 'a' + number, sizeof line);
    line[79] = '\0';
    for (int i = 0; i < LINES; i++) {
        osal_console_print_line(line);
    }
}

static void lines_of_several_processes_do_not_mix(void)
{
    TEST_ASSERT_EQUAL(0, listen_to(STDOUT_FILENO, WRITERS, print_many_lines));
    TEST_ASSERT_EQUAL(WRITERS * LINES * 80, output_size);
    for (size_t i = 0U; i < output_size; i += 80U) {
        for (size_t k = 0U; k < 79U; k++) {
            TEST_ASSERT_EQUAL_HEX8(output[i], output[i + k]);
        }
        TEST_ASSERT_EQUAL_HEX8('\n', output[i + 79U]);
    }
}

/// A full pipe without a reader: the caller continues.
static void a_slow_reader_does_not_stop_the_caller(void)
{
    const pid_t child = fork();
    if (child == 0) {
        static char block[70000];
        int ends[2];
        if ((pipe(ends) != 0) || (dup2(ends[1], STDOUT_FILENO) < 0)) {
            _exit(1);
        }
        (void)fcntl(STDOUT_FILENO, F_SETFL, O_NONBLOCK);
        while (write(STDOUT_FILENO, block, sizeof block) > 0) {
            // Fill the pipe.
        }
        (void)fcntl(STDOUT_FILENO, F_SETFL, 0);
        osal_console_print_line("lost");
        _exit(7);
    }
    int exit_status = 0;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFEXITED(exit_status) && (WEXITSTATUS(exit_status) == 7));
}

static const int failing_line = __LINE__ + 4;

static void fail(int number)
{
    FSW_ASSERT(number == 1);
}

static const struct {
    const char* file;
    int line;
    const char* printed;
} assertions[] = {{"a.c", 7, "a.c:7: assertion failed\n"},
                  {"a.c", 10, "a.c:10: assertion failed\n"},
                  {"a.c", INT_MAX, "a.c:2147483647: assertion failed\n"},
                  {"a.c", 0, "a.c:0: assertion failed\n"},
                  {"a.c", -1, "a.c:0: assertion failed\n"},
                  {NULL, 123456, "?:123456: assertion failed\n"}};
static unsigned assertion_index;

static void fail_there(int number)
{
    (void)number;
    fsw_assertion_failed(assertions[assertion_index].file, assertions[assertion_index].line);
}

static void a_failed_assertion_prints_its_file_and_line(void)
{
    for (assertion_index = 0U; assertion_index < (sizeof assertions / sizeof assertions[0]);
         assertion_index++) {
        const int exit_status = listen_to(STDERR_FILENO, 1, fail_there);
        TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
        TEST_ASSERT_EQUAL(SIGABRT, WTERMSIG(exit_status));
        TEST_ASSERT_EQUAL_STRING(assertions[assertion_index].printed, output);
    }
}

static void a_failed_assertion_prints_one_line_and_ends_the_program(void)
{
    const int exit_status = listen_to(STDERR_FILENO, 1, fail);
    TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
    TEST_ASSERT_EQUAL(SIGABRT, WTERMSIG(exit_status));
    char expected[128];
    (void)snprintf(expected, sizeof expected, "test_console.c:%d: assertion failed\n", failing_line);
    TEST_ASSERT_EQUAL_STRING(expected, output);
}

int main(void)
{
    (void)signal(SIGPIPE, SIG_IGN);
    UNITY_BEGIN();
    RUN_TEST(lines_and_parts_of_lines_go_to_their_stream_unchanged);
    RUN_TEST(name_version_and_usage_are_printed_on_request);
    RUN_TEST(lines_of_several_processes_do_not_mix);
    RUN_TEST(a_slow_reader_does_not_stop_the_caller);
    RUN_TEST(a_failed_assertion_prints_one_line_and_ends_the_program);
    RUN_TEST(a_failed_assertion_prints_its_file_and_line);
    return UNITY_END();
}
