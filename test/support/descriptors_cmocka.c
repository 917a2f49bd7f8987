// SPDX-License-Identifier: Apache-2.0
// The check of descriptors.h for tests that use cmocka. Such tests mock functions of the C library, so this
// file calls the kernel directly.
#define _GNU_SOURCE
#include "test/support/descriptors.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmocka.h>

#define TESTS_MAX 64U

static const struct CMUnitTest* wanted; // The present test as its file declares it.
static descriptors_t before;

static descriptors_t look(void)
{
    descriptors_t now;
    for (int number = 0; number < DESCRIPTORS_MAX; number++) {
        now.is_open[number] = syscall(SYS_fcntl, number, F_GETFD, 0) >= 0;
    }
    return now;
}

static int set_up(void** state)
{
    before = look();
    return (wanted->setup_func != NULL) ? wanted->setup_func(state) : 0;
}

static int tear_down(void** state)
{
    const int result        = (wanted->teardown_func != NULL) ? wanted->teardown_func(state) : 0;
    const descriptors_t now = look();
    int changed             = 0;
    for (int number = 0; number < DESCRIPTORS_MAX; number++) {
        if (now.is_open[number] != before.is_open[number]) {
            print_error("descriptor %d is %s after the test, and was not before\n", number,
                        now.is_open[number] ? "open" : "closed");
            changed++;
        }
    }
    wanted++;
    return (result != 0) ? result : changed;
}

int __real__cmocka_run_group_tests(const char* name, const struct CMUnitTest* tests, size_t count,
                                   CMFixtureFunction group_set_up, CMFixtureFunction group_tear_down);
int __wrap__cmocka_run_group_tests(const char* name, const struct CMUnitTest* tests, size_t count,
                                   CMFixtureFunction group_set_up, CMFixtureFunction group_tear_down)
{
    static struct CMUnitTest counted[TESTS_MAX];
    for (size_t i = 0U; (i < count) && (i < TESTS_MAX); i++) {
        counted[i]               = tests[i];
        counted[i].setup_func    = set_up;
        counted[i].teardown_func = tear_down;
    }
    if (count > TESTS_MAX) {
        print_error("%s: %zu tests, expected at most %u: raise TESTS_MAX in descriptors_cmocka.c\n", name,
                    count, TESTS_MAX);
        return 1;
    }
    wanted = tests;
    return __real__cmocka_run_group_tests(name, counted, count, group_set_up, group_tear_down);
}
