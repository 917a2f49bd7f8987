// SPDX-License-Identifier: Apache-2.0
// A wait may be late on a machine with other load, but never early: no test requires one wait to be punctual.
#define _GNU_SOURCE
#include "osal/include/osal/clock.h"
#include "osal/include/osal/process.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define MS 1000000ULL

static osal_clock_t wall;

void setUp(void)
{
    osal_clock_open_real(&wall, osal_clock_monotonic_ns());
}

void tearDown(void)
{
}

/// Each cycle works for half its period. Absolute sleep compensates for that, and for any delay of the
/// machine; relative sleep would be 100 periods late at the end. Therefore at least one of the last wake-ups
/// must be on time.
static void sleep_on_a_grid(osal_socket_t* const* sockets, size_t socket_count)
{
    const uint64_t period_ns = MS;
    const uint64_t begin_ns  = osal_clock_now_ns(&wall);
    uint64_t least_late_ns   = UINT64_MAX;
    for (uint64_t i = 1U; i <= 200U; i++) {
        const uint64_t wake_ns = begin_ns + (i * period_ns);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, sockets, socket_count));
        const uint64_t late_ns = osal_clock_now_ns(&wall) - wake_ns;
        // A wake-up before its time would give a difference that wraps.
        TEST_ASSERT_TRUE(late_ns < UINT64_MAX / 2U);
        least_late_ns = ((i > 100U) && (late_ns < least_late_ns)) ? late_ns : least_late_ns;
        while (osal_clock_now_ns(&wall) < (wake_ns + (period_ns / 2U))) {
        }
    }
    TEST_ASSERT_TRUE(least_late_ns < (50U * period_ns));
}

static void absolute_sleep_does_not_drift_with_sockets(void)
{
    osal_socket_t quiet;
    osal_socket_t other;
    osal_socket_t* const sockets[] = {&quiet};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&quiet, &other));
    sleep_on_a_grid(sockets, 1U);
    osal_socket_close(&quiet);
    osal_socket_close(&other);
}

static void a_real_clock_takes_the_least_timer_slack(void)
{
    TEST_ASSERT_EQUAL(1, prctl(PR_GET_TIMERSLACK));
}

static void a_real_clock_says_whether_memory_is_locked(void)
{
    TEST_ASSERT_EQUAL(mlockall(MCL_CURRENT) == 0, wall.is_memory_locked);
}

static void a_refused_memory_lock_is_reported(void)
{
    if (!wall.is_memory_locked) {
        TEST_IGNORE_MESSAGE("locked memory is not permitted here");
    }
    if (geteuid() != 0U) {
        TEST_IGNORE_MESSAGE("only a privileged process can test the refusal");
    }
    const pid_t child = fork();
    if (child == 0) {
        const struct rlimit none = {0U, 0U};
        const bool is_stranger =
            (setrlimit(RLIMIT_MEMLOCK, &none) == 0) && (setgid(65534) == 0) && (setuid(65534) == 0);
        osal_clock_t clock;
        osal_clock_open_real(&clock, 0U);
        const bool is_usable = (osal_clock_wait(&clock, 0U, NULL, 0U) == STATUS_OK);
        // Under the address sanitizer every lock succeeds.
        const bool is_granted = (mlockall(MCL_CURRENT) == 0);
        _exit((is_stranger && is_usable && (clock.is_memory_locked == is_granted)) ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static void real_wait_is_never_early_with_sockets(void)
{
    osal_socket_t quiet;
    osal_socket_t other;
    osal_socket_t* const sockets[] = {&quiet};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&quiet, &other));
    for (uint64_t i = 1U; i <= 20U; i++) {
        const uint64_t wake_ns = osal_clock_now_ns(&wall) + (i * MS / 10U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, sockets, 1U));
        TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) >= wake_ns);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, 0U, sockets, 1U)); // The wake time has passed.
    osal_socket_close(&quiet);
    osal_socket_close(&other);
}

static void real_wait_ends_early_for_a_socket(void)
{
    osal_socket_t quiet;
    osal_socket_t quiet_end;
    osal_socket_t talking;
    osal_socket_t talking_end;
    osal_socket_t* const sockets[] = {&quiet, &talking};
    size_t sent                    = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&quiet, &quiet_end));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&talking, &talking_end));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&talking_end, (const uint8_t*)"x", 1U, &sent));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, OSAL_CLOCK_NEVER, sockets, 2U));
    const uint64_t far_ns = 3600000U * MS;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, far_ns, sockets, 2U));
    TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) < far_ns);
    osal_socket_close(&talking_end); // A closed connection is readable, too.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, OSAL_CLOCK_NEVER, sockets, 2U));
    osal_socket_close(&quiet);
    osal_socket_close(&quiet_end);
    osal_socket_close(&talking);
}

static void ignore_it(int number)
{
    (void)number;
}

static void signals_of_others_do_not_shorten_a_wait(void)
{
    osal_socket_t quiet;
    osal_socket_t other;
    osal_socket_t* const sockets[]  = {&quiet};
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&quiet, &other));
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    for (size_t count = 0U; count <= 1U; count++) {
        const uint64_t wake_ns = osal_clock_now_ns(&wall) + (20U * MS);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, sockets, count));
        TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) >= wake_ns);
    }
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
    osal_socket_close(&quiet);
    osal_socket_close(&other);
}

static void stop_signal_ends_a_real_wait_once(void)
{
    osal_process_catch_stop(); // The second call has no effect.
    const unsigned before = osal_process_stop_count();
    TEST_ASSERT_EQUAL(0, raise(SIGTERM));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, OSAL_CLOCK_NEVER, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT(before + 1U, osal_process_stop_count());
    const uint64_t wake_ns = osal_clock_now_ns(&wall) + (5U * MS);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&wall, wake_ns, NULL, 0U));
    TEST_ASSERT_TRUE(osal_clock_now_ns(&wall) >= wake_ns);
}

int main(void)
{
    osal_process_catch_stop(); // The descriptor stays open as long as the process.
    UNITY_BEGIN();
    RUN_TEST(absolute_sleep_does_not_drift_with_sockets);
    RUN_TEST(a_real_clock_takes_the_least_timer_slack);
    RUN_TEST(a_real_clock_says_whether_memory_is_locked);
    RUN_TEST(a_refused_memory_lock_is_reported);
    RUN_TEST(real_wait_is_never_early_with_sockets);
    RUN_TEST(real_wait_ends_early_for_a_socket);
    RUN_TEST(signals_of_others_do_not_shorten_a_wait);
    RUN_TEST(stop_signal_ends_a_real_wait_once);
    return UNITY_END();
}
