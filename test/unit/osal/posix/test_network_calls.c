// SPDX-License-Identifier: Apache-2.0
// Entering and leaving a network namespace when system calls fail. The calls are mocked;
// test/contract/osal/test_network.c has the tests with real namespaces.
#define _GNU_SOURCE
#include "osal/include/osal/network.h"

#include <errno.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define HOME 0 // Free if standard input is closed.
#define OTHER 7
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

static int answer(const int result)
{
    // After a success errno may have any value: that of an earlier call says nothing.
    errno = (result < 0) ? -result : EPERM;
    return (result < 0) ? -1 : result;
}

int __wrap_open(const char* path, int flags, ...)
{
    (void)path;
    (void)flags;
    return answer(mock_type(int));
}

int __wrap_setns(int descriptor, int kind)
{
    assert_int_equal(CLONE_NEWNET, kind);
    check_expected(descriptor);
    return answer(mock_type(int));
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if ((descriptor != HOME) && (descriptor != OTHER)) {
        return __real_close(descriptor); // A coverage build makes such calls itself.
    }
    check_expected(descriptor);
    return 0;
}

static void descriptor_0_is_a_valid_home(void** state)
{
    osal_network_t home;
    (void)state;
    will_return(__wrap_open, HOME);
    will_return(__wrap_open, OTHER);
    expect_value(__wrap_setns, descriptor, OTHER);
    will_return(__wrap_setns, 0);
    expect_value(__wrap_close, descriptor, OTHER);
    assert_int_equal(STATUS_OK, osal_network_enter(&home, "other"));
    assert_int_equal(HOME, home.descriptor);
    expect_value(__wrap_setns, descriptor, HOME);
    will_return(__wrap_setns, 0);
    expect_value(__wrap_close, descriptor, HOME);
    assert_int_equal(STATUS_OK, osal_network_leave(&home));
    assert_int_equal(-1, home.descriptor);
}

static void a_namespace_that_cannot_be_entered_leaves_nothing_open(void** state)
{
    static const struct {
        int error;
        status_t status;
    } rows[] = {{EPERM, STATUS_DENIED}, {EINVAL, STATUS_IO}};
    osal_network_t home;
    (void)state;
    for (size_t i = 0U; i < COUNT(rows); i++) {
        will_return(__wrap_open, HOME);
        will_return(__wrap_open, OTHER);
        expect_value(__wrap_setns, descriptor, OTHER);
        will_return(__wrap_setns, -rows[i].error);
        expect_value(__wrap_close, descriptor, OTHER);
        expect_value(__wrap_close, descriptor, HOME);
        assert_int_equal(rows[i].status, osal_network_enter(&home, "other"));
        assert_int_equal(-1, home.descriptor);
    }
    will_return(__wrap_open, HOME);
    will_return(__wrap_open, -ENOENT);
    expect_value(__wrap_close, descriptor, HOME);
    assert_int_equal(STATUS_NOT_FOUND, osal_network_enter(&home, "other"));
    assert_int_equal(-1, home.descriptor);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descriptor_0_is_a_valid_home),
        cmocka_unit_test(a_namespace_that_cannot_be_entered_leaves_nothing_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
