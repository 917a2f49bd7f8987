// SPDX-License-Identifier: Apache-2.0
// Events between processes, and interruptions by signals.
#define _GNU_SOURCE
#include "osal/include/osal/event.h"

#include "osal/include/osal/clock.h"

#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define ROUNDS 5000U

typedef struct {
    osal_event_t there;
    osal_event_t back;
    uint32_t value;
} shared_t;

static shared_t* shared;

void setUp(void)
{
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(shared != MAP_FAILED);
}

void tearDown(void)
{
    (void)munmap(shared, sizeof *shared);
}

static void memory_of_zeros_is_a_valid_event(void)
{
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&shared->there, 0U));
    osal_event_signal(&shared->there);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&shared->there, UINT32_MAX));
}

static void ignore_it(int number)
{
    (void)number;
}

static void wait_is_never_early_though_signals_interrupt_it(void)
{
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    const uint64_t begin_ns = osal_clock_monotonic_ns();
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&shared->there, 30U));
    TEST_ASSERT_TRUE(osal_clock_monotonic_ns() - begin_ns >= 30000000U);
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
}

static void two_processes_take_turns_without_losing_a_signal(void)
{
    const pid_t other = fork();
    if (other == 0) {
        for (uint32_t i = 0U; i < ROUNDS; i++) {
            if (osal_event_wait(&shared->there, 20000U) != STATUS_OK) {
                _exit(1);
            }
            shared->value++;
            osal_event_signal(&shared->back);
        }
        _exit(0);
    }
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        osal_event_signal(&shared->there);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&shared->back, 20000U));
        TEST_ASSERT_EQUAL_UINT32(i + 1U, shared->value);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(other, waitpid(other, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(memory_of_zeros_is_a_valid_event);
    RUN_TEST(wait_is_never_early_though_signals_interrupt_it);
    RUN_TEST(two_processes_take_turns_without_losing_a_signal);
    return UNITY_END();
}
