// SPDX-License-Identifier: Apache-2.0
// Child processes when system calls fail, are interrupted, or are missing in an old kernel.
// test/contract/osal has the tests with a real system.
#define _GNU_SOURCE
#include "osal/include/osal/process.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#define MS 1000000ULL
#define DESCRIPTOR 0 // The lowest descriptor.
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    int error;
    status_t status;
} error_case_t;

static long failing_call = -1; // The number of a system call that fails, and its error.
static int failing_error;
static int pipe_error; // Error of pipe2 and fork; 0: the real functions are called.
static int fork_error;
static bool is_wait_mocked;
static uint64_t now_ns;

static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

// ---- Mocked functions ----

long __real_syscall(long number, ...);
long __wrap_syscall(long number, ...)
{
    long words[6];
    va_list list;
    va_start(list, number);
    for (size_t i = 0U; i < COUNT(words); i++) {
        words[i] = va_arg(list, long);
    }
    va_end(list);
    if (number == failing_call) {
        return answer(-failing_error);
    }
    return __real_syscall(number, words[0], words[1], words[2], words[3], words[4], words[5]);
}

int __real_pipe2(int ends[2], int flags);
int __wrap_pipe2(int ends[2], int flags)
{
    return (pipe_error != 0) ? answer(-pipe_error) : __real_pipe2(ends, flags);
}

pid_t __real_fork(void);
pid_t __wrap_fork(void)
{
    return (fork_error != 0) ? answer(-fork_error) : __real_fork();
}

pid_t __real_wait4(pid_t id, int* out_status, int options, struct rusage* used);
pid_t __wrap_wait4(pid_t id, int* out_status, int options, struct rusage* used)
{
    return is_wait_mocked ? answer(mock_type(int)) : __real_wait4(id, out_status, options, used);
}

int __wrap_poll(struct pollfd* watched, nfds_t count, int timeout_ms)
{
    assert_int_equal(POLLIN, watched[0].events);
    check_expected(count);
    check_expected(timeout_ms);
    now_ns += (uint64_t)mock_type(int); // Time that the call takes.
    return answer(mock_type(int));
}

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return now_ns;
}

static int set_up(void** state)
{
    (void)state;
    failing_call   = -1;
    pipe_error     = 0;
    fork_error     = 0;
    is_wait_mocked = false;
    now_ns         = 5U;
    return 0;
}

static osal_process_start_t command(const char* const words[])
{
    return (osal_process_start_t){.arguments = words, .processor = -1};
}

// ---- Start ----

static void a_start_without_resources_leaves_nothing_behind(void** state)
{
    static const error_case_t errors[] = {{EMFILE, STATUS_EXHAUSTED}, {ENFILE, STATUS_EXHAUSTED},
                                          {ENOMEM, STATUS_EXHAUSTED}, {EAGAIN, STATUS_EXHAUSTED},
                                          {EPERM, STATUS_DENIED},     {EINVAL, STATUS_IO}};
    const char* const words[]          = {"/bin/sleep", "1000", NULL};
    const osal_process_start_t start   = command(words);
    osal_process_t process;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        (void)set_up(state);
        pipe_error = errors[i].error;
        assert_int_equal(errors[i].status, osal_process_start(&process, &start));
        assert_int_equal(-1, process.descriptor);
        pipe_error = 0;
        fork_error = errors[i].error;
        assert_int_equal(errors[i].status, osal_process_start(&process, &start));
        assert_int_equal(-1, process.descriptor);
        fork_error    = 0;
        failing_call  = SYS_pidfd_open; // The child has already started, so the port ends it.
        failing_error = errors[i].error;
        assert_int_equal(errors[i].status, osal_process_start(&process, &start));
        assert_int_equal(-1, process.descriptor);
        assert_int_equal(0, process.id);
        assert_int_equal(-1, waitpid(-1, NULL, WNOHANG));
        assert_int_equal(ECHILD, errno);
    }
    failing_error = ESRCH;
    assert_int_equal(STATUS_IO, osal_process_start(&process, &start));
}

/// Returns 0 if `kept` is open in the child, and neither `first` nor `last` is.
static int code_of_child(const int first, const int last, const int kept)
{
    char script[160];
    const char* const words[]    = {"/bin/sh", "-c", script, NULL};
    osal_process_start_t start   = command(words);
    osal_process_result_t result = {.has_ended = false};
    osal_process_t process;
    (void)snprintf(script, sizeof script,
                   "[ -e /proc/$$/fd/%d ] && ! [ -e /proc/$$/fd/%d ] && ! [ -e /proc/$$/fd/%d ]", kept, first,
                   last);
    start.descriptors      = &kept;
    start.descriptor_count = 1U;
    assert_int_equal(STATUS_OK, osal_process_start(&process, &start));
    while (!result.has_ended) {
        assert_int_equal(STATUS_OK, osal_process_poll(&process, &result));
    }
    assert_false(result.was_signalled);
    return result.code;
}

static void a_child_keeps_named_descriptors_only_also_with_an_old_kernel(void** state)
{
    struct rlimit before;
    (void)state;
    assert_int_equal(0, getrlimit(RLIMIT_NOFILE, &before));
    const struct rlimit few = {200U, before.rlim_max};
    assert_int_equal(0, setrlimit(RLIMIT_NOFILE, &few));
    const int first = dup(STDERR_FILENO); // The lowest free descriptor.
    const int last  = dup2(STDERR_FILENO, 199);
    const int kept  = dup2(STDERR_FILENO, 100);
    assert_true((first >= 3) && (last == 199) && (kept == 100));
    assert_int_equal(0, code_of_child(first, last, kept));
    failing_call  = SYS_close_range;
    failing_error = ENOSYS;
    assert_int_equal(0, code_of_child(first, last, kept));
    (void)close(first);
    (void)close(last);
    (void)close(kept);
    assert_int_equal(0, setrlimit(RLIMIT_NOFILE, &before));
}

static void a_named_descriptor_that_is_not_open_is_an_error(void** state)
{
    const char* const words[]  = {"/bin/true", NULL};
    osal_process_start_t start = command(words);
    const int closed           = 150;
    osal_process_t process;
    (void)state;
    start.descriptors      = &closed;
    start.descriptor_count = 1U;
    assert_int_equal(STATUS_IO, osal_process_start(&process, &start));
    assert_int_equal(-1, waitpid(-1, NULL, WNOHANG));
}

/// Signals that the parent ignores have their default effect in the child.
static void signals_that_the_parent_ignores_end_the_child(void** state)
{
    static const struct {
        int number;
        const char* command;
    } signals[] = {{SIGINT, "kill -INT $$"},
                   {SIGTERM, "kill -TERM $$"},
                   {SIGHUP, "kill -HUP $$"},
                   {SIGPIPE, "kill -PIPE $$"}};
    (void)state;
    for (size_t i = 0U; i < COUNT(signals); i++) {
        const char* const words[]        = {"/bin/sh", "-c", signals[i].command, NULL};
        const osal_process_start_t start = command(words);
        osal_process_result_t result     = {.has_ended = false};
        osal_process_t process;
        void (*const before)(int) = signal(signals[i].number, SIG_IGN);
        assert_int_equal(STATUS_OK, osal_process_start(&process, &start));
        (void)signal(signals[i].number, before);
        while (!result.has_ended) {
            assert_int_equal(STATUS_OK, osal_process_poll(&process, &result));
        }
        assert_true(result.was_signalled);
        assert_int_equal(signals[i].number, result.code);
    }
}

/// In a program whose standard input is closed, descriptor 0 is valid.
static void the_state_of_a_process_is_read_also_with_closed_standard_input(void** state)
{
    const osal_process_t self = {.id = (int32_t)getpid(), .descriptor = DESCRIPTOR};
    const int kept            = dup(STDIN_FILENO);
    osal_process_look_t look  = {.is_stopped = true};
    (void)state;
    (void)close(STDIN_FILENO);
    assert_int_equal(STATUS_OK, osal_process_look(&self, &look));
    assert_int_equal(STDIN_FILENO, dup2(kept, STDIN_FILENO));
    (void)close(kept);
    assert_true(look.is_runnable);
    assert_false(look.is_stopped);
}

// ---- Signals and ends ----

static void a_signal_that_is_not_sent_is_reported(void** state)
{
    static const error_case_t errors[] = {{ESRCH, STATUS_NOT_FOUND}, {EPERM, STATUS_DENIED}};
    osal_process_t process             = {.id = 1, .descriptor = DESCRIPTOR};
    osal_process_t none                = {.id = 1, .descriptor = -1};
    (void)state;
    failing_call = SYS_pidfd_send_signal;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        failing_error = errors[i].error;
        assert_int_equal(errors[i].status, osal_process_stop(&process, true));
        assert_int_equal(errors[i].status, osal_process_suspend(&process));
    }
    assert_int_equal(STATUS_NOT_FOUND, osal_process_stop(&none, true));
}

static void an_interrupted_query_for_the_end_is_repeated(void** state)
{
    osal_process_t process       = {.id = 1, .descriptor = DESCRIPTOR};
    osal_process_result_t result = {.has_ended = true};
    (void)state;
    is_wait_mocked = true;
    will_return(__wrap_wait4, -EINTR);
    will_return(__wrap_wait4, 0); // The process is running.
    assert_int_equal(STATUS_OK, osal_process_poll(&process, &result));
    assert_false(result.has_ended);
    will_return(__wrap_wait4, -ECHILD);
    assert_int_equal(STATUS_NOT_OURS, osal_process_poll(&process, &result));
    process.id = 0; // This process is only watched, by its descriptor.
    assert_int_equal(STATUS_NOT_OURS, osal_process_poll(&process, &result));
    process = (osal_process_t){.id = 1, .descriptor = -1};
    assert_int_equal(STATUS_NOT_OURS, osal_process_poll(&process, &result));
}

// ---- Waiting ----

static void expect_poll(const int timeout_ms, const int passing_ns, const int result)
{
    expect_value(__wrap_poll, count, 2);
    expect_value(__wrap_poll, timeout_ms, timeout_ms);
    will_return(__wrap_poll, passing_ns);
    will_return(__wrap_poll, result);
}

static void an_interrupted_wait_continues_for_the_rest_of_its_time(void** state)
{
    osal_process_t process       = {.id = 1, .descriptor = DESCRIPTOR};
    osal_process_t* const list[] = {&process};
    (void)state;
    expect_poll(3, 1, -EINTR);
    expect_poll(3, (int)MS - 1, -EINTR); // Part of a millisecond is rounded up.
    expect_poll(2, (int)(2U * MS), -EINTR);
    expect_poll(0, 0, -EINTR);
    expect_poll(0, (int)MS, -EINTR); // The call returns after the end of the wait.
    expect_poll(0, 0, 0);
    assert_int_equal(STATUS_TIMEOUT, osal_process_wait_any(list, 1U, 3U));
    expect_poll(INT_MAX, 0, 1);
    assert_int_equal(STATUS_OK, osal_process_wait_any(list, 1U, UINT32_MAX));
    expect_poll(1, 0, -ENOMEM);
    assert_int_equal(STATUS_TIMEOUT, osal_process_wait_any(list, 1U, 1U));
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_start_without_resources_leaves_nothing_behind),
        TEST(a_child_keeps_named_descriptors_only_also_with_an_old_kernel),
        TEST(a_named_descriptor_that_is_not_open_is_an_error),
        TEST(signals_that_the_parent_ignores_end_the_child),
        TEST(the_state_of_a_process_is_read_also_with_closed_standard_input),
        TEST(a_signal_that_is_not_sent_is_reported),
        TEST(an_interrupted_query_for_the_end_is_repeated),
        TEST(an_interrupted_wait_continues_for_the_rest_of_its_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
