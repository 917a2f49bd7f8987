// SPDX-License-Identifier: Apache-2.0
// The runners of Unity and cmocka detect a test that leaves a descriptor open, or closes one that it has not
// opened (test/support/descriptors.h). Without this test, a build without these runners would pass.
#define _POSIX_C_SOURCE 200809L
#include "unity.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

#include <cmocka.h>

static int given = -1; ///< Open before the inner test.
static int left  = -1; ///< Opened by the inner test.

void setUp(void)
{
}

void tearDown(void)
{
}

static void opens_and_closes(void)
{
    const int descriptor = open("/dev/null", O_RDONLY | O_CLOEXEC);
    (void)close(descriptor);
}

static void leaves_open(void)
{
    left = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

static void closes_that_of_another(void)
{
    (void)close(given);
}

/// Send standard output and errors to /dev/null, or to where they went before: the inner tests print
/// failures.
static void be_silent(int kept[2], const bool is_silent)
{
    (void)fflush(stdout);
    (void)fflush(stderr);
    for (int i = 0; i < 2; i++) {
        const int target = is_silent ? open("/dev/null", O_WRONLY | O_CLOEXEC) : kept[i];
        kept[i]          = is_silent ? dup(STDOUT_FILENO + i) : -1;
        (void)dup2(target, STDOUT_FILENO + i);
        (void)close(target);
    }
}

/// Returns the failures of an inner test under the runner of Unity.
static UNITY_UINT failures_of_unity(void (*const test)(void))
{
    int kept[2];
    const struct UNITY_STORAGE_T before = Unity;
    be_silent(kept, true);
    UnityDefaultTestRun(test, "inner", __LINE__);
    be_silent(kept, false);
    const UNITY_UINT failures = Unity.TestFailures - before.TestFailures;
    Unity                     = before;
    return failures;
}

static void of_cmocka(void** state)
{
    void (*const* const test)(void) = *state;
    (*test)();
}

static int failures_of_cmocka(void (*test)(void))
{
    int kept[2];
    const struct CMUnitTest tests[] = {cmocka_unit_test_prestate(of_cmocka, &test)};
    be_silent(kept, true);
    const int failures = cmocka_run_group_tests(tests, NULL, NULL);
    be_silent(kept, false);
    return failures;
}

static void an_open_descriptor_fails_a_test(void)
{
    TEST_ASSERT_EQUAL(1, failures_of_unity(leaves_open));
    TEST_ASSERT_EQUAL(0, close(left));
    TEST_ASSERT_NOT_EQUAL(0, failures_of_cmocka(leaves_open));
    TEST_ASSERT_EQUAL(0, close(left));
}

static void a_descriptor_of_another_that_is_closed_fails_a_test(void)
{
    given = open("/dev/null", O_RDONLY | O_CLOEXEC);
    TEST_ASSERT_EQUAL(1, failures_of_unity(closes_that_of_another));
    given = open("/dev/null", O_RDONLY | O_CLOEXEC);
    TEST_ASSERT_NOT_EQUAL(0, failures_of_cmocka(closes_that_of_another));
}

static void a_test_that_gives_back_its_descriptors_passes(void)
{
    TEST_ASSERT_EQUAL(0, failures_of_unity(opens_and_closes));
    TEST_ASSERT_EQUAL(0, failures_of_cmocka(opens_and_closes));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_open_descriptor_fails_a_test);
    RUN_TEST(a_descriptor_of_another_that_is_closed_fails_a_test);
    RUN_TEST(a_test_that_gives_back_its_descriptors_passes);
    return UNITY_END();
}
