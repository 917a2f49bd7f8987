// SPDX-License-Identifier: Apache-2.0
// The system accepts text in parts, late or not at all: the calls are mocked. test/contract/osal has the
// tests with real pipes.
#define _GNU_SOURCE
#include "osal/include/osal/console.h"

#include <errno.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cmocka.h>

#define TIMEOUT_MS 100

static char output[64];
static size_t output_size;

static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_poll(struct pollfd* watched, nfds_t count, int timeout_ms)
{
    assert_int_equal(1, count);
    assert_int_equal(POLLOUT, watched->events);
    assert_int_equal(TIMEOUT_MS, timeout_ms);
    check_expected(watched->fd);
    return answer(mock_type(int));
}

ssize_t __wrap_writev(int descriptor, const struct iovec* parts, int count)
{
    const int taken = mock_type(int);
    int left        = taken;
    assert_true((descriptor == STDOUT_FILENO) || (descriptor == STDERR_FILENO));
    for (int i = 0; (i < count) && (left > 0); i++) {
        const size_t size = ((size_t)left < parts[i].iov_len) ? (size_t)left : parts[i].iov_len;
        (void)memcpy(&output[output_size], parts[i].iov_base, size);
        output_size += size;
        left -= (int)size;
    }
    assert_true(left <= 0); // The port must not offer more than is left.
    return answer(taken);
}

static void expect_part(const int descriptor, const int taken)
{
    expect_value(__wrap_poll, watched->fd, descriptor);
    will_return(__wrap_poll, 1);
    will_return(__wrap_writev, taken);
}

static void expect_output(const char* const text)
{
    output[output_size] = '\0';
    assert_string_equal(text, output);
    output_size = 0U;
}

static void a_line_that_is_accepted_in_parts_is_written_completely(void** state)
{
    (void)state;
    for (int first = 1; first < 4; first++) {
        expect_part(STDOUT_FILENO, first);
        expect_part(STDOUT_FILENO, 4 - first);
        osal_console_print_line("abc");
        expect_output("abc\n");
    }
    for (int i = 0; i < 4; i++) {
        expect_part(STDERR_FILENO, 1);
    }
    osal_console_print_error("abc");
    expect_output("abc\n");
    expect_part(STDOUT_FILENO, 3); // osal_console_print adds no line end.
    osal_console_print("abc");
    expect_output("abc");
    osal_console_print(""); // An empty text causes no write.
    expect_output("");
}

static void an_interrupted_write_is_repeated_and_a_failed_one_is_not(void** state)
{
    (void)state;
    expect_part(STDOUT_FILENO, 2);
    expect_part(STDOUT_FILENO, -EINTR);
    expect_part(STDOUT_FILENO, -EAGAIN);
    expect_part(STDOUT_FILENO, 2);
    osal_console_print_line("abc");
    expect_output("abc\n");
    expect_part(STDOUT_FILENO, 2);
    expect_part(STDOUT_FILENO, -EPIPE);
    osal_console_print_line("abc");
    expect_output("ab");
}

static void text_that_a_slow_reader_does_not_accept_is_dropped(void** state)
{
    (void)state;
    expect_part(STDOUT_FILENO, 1);
    expect_value(__wrap_poll, watched->fd, STDOUT_FILENO);
    will_return(__wrap_poll, 0);
    osal_console_print_line("abc");
    expect_output("a");
    expect_value(__wrap_poll, watched->fd, STDERR_FILENO);
    will_return(__wrap_poll, -ENOMEM);
    osal_console_print_error("abc");
    expect_output("");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_that_is_accepted_in_parts_is_written_completely),
        cmocka_unit_test(an_interrupted_write_is_repeated_and_a_failed_one_is_not),
        cmocka_unit_test(text_that_a_slow_reader_does_not_accept_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
