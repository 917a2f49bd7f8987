// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/doorbell.h"

#include "osal/include/osal/clock.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define ROUNDS 5000U
#define WAITERS 3U

typedef struct {
    osal_doorbell_t there;
    osal_doorbell_t back;
    uint32_t value;
    uint32_t seen;
} shared_t;

static shared_t* shared;

void setUp(void)
{
    shared = mmap(NULL, sizeof(*shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(shared != MAP_FAILED);
}

void tearDown(void)
{
    (void)munmap(shared, sizeof(*shared));
}

static void join(pid_t child)
{
    int how = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &how, 0));
    TEST_ASSERT_EQUAL(0, how);
}

static void test_rings_are_counted_and_kept(void)
{
    osal_doorbell_t bell = {7U, 7U, 7U};
    osal_doorbell_create(&bell);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_doorbell_rings(&bell));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&bell, 0U, 0U));
    osal_doorbell_ring(&bell);
    osal_doorbell_ring(&bell);
    TEST_ASSERT_EQUAL_UINT32(2U, osal_doorbell_rings(&bell));
    for (uint32_t seen = 0U; seen < 2U; seen++) { // Reading the count does not clear it.
        TEST_ASSERT_EQUAL(STATUS_OK, osal_doorbell_wait(&bell, seen, UINT32_MAX));
    }
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&bell, 2U, 1U));
}

static void test_the_count_wraps(void)
{
    osal_doorbell_t bell = {UINT32_MAX, 0U, 0U};
    osal_doorbell_ring(&bell);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_doorbell_rings(&bell));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_doorbell_wait(&bell, UINT32_MAX, UINT32_MAX));
}

static void ignore_it(int number)
{
    (void)number;
}

static void test_wait_is_never_early_though_signals_interrupt_it(void)
{
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    const uint64_t begin_ns = osal_clock_monotonic_ns();
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&shared->there, 0U, 30U));
    TEST_ASSERT_TRUE(osal_clock_monotonic_ns() - begin_ns >= 30000000U);
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
}

static void test_two_processes_take_turns_without_losing_one(void)
{
    const pid_t other = fork();
    if (other == 0) {
        for (uint32_t i = 0U; i < ROUNDS; i++) {
            if (osal_doorbell_wait(&shared->there, i, 20000U) != STATUS_OK) {
                _exit(1);
            }
            shared->value++;
            osal_doorbell_ring(&shared->back);
        }
        _exit(0);
    }
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        osal_doorbell_ring(&shared->there);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_doorbell_wait(&shared->back, i, 20000U));
        TEST_ASSERT_EQUAL_UINT32(i + 1U, shared->value);
    }
    join(other);
}

static void test_one_ring_wakes_all(void)
{
    pid_t waiters[WAITERS];
    for (unsigned i = 0U; i < WAITERS; i++) {
        waiters[i] = fork();
        if (waiters[i] == 0) {
            osal_doorbell_ring(&shared->back);
            _exit((osal_doorbell_wait(&shared->there, 0U, 20000U) == STATUS_OK) ? 0 : 1);
        }
    }
    for (uint32_t i = 0U; osal_doorbell_rings(&shared->back) < WAITERS;
         i          = osal_doorbell_rings(&shared->back)) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_doorbell_wait(&shared->back, i, 20000U));
    }
    osal_doorbell_ring(&shared->there);
    for (unsigned i = 0U; i < WAITERS; i++) {
        join(waiters[i]);
    }
}

static void test_a_dead_waiter_delays_no_other(void)
{
    const pid_t child = fork();
    if (child == 0) {
        _exit((int)osal_doorbell_wait(&shared->there, 0U, UINT32_MAX));
    }
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&shared->back, 0U, 20U));
    TEST_ASSERT_EQUAL(0, kill(child, SIGKILL));
    TEST_ASSERT_EQUAL(child, waitpid(child, NULL, 0));
    osal_doorbell_ring(&shared->there);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_doorbell_wait(&shared->there, 0U, UINT32_MAX));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&shared->there, 1U, 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_rings_are_counted_and_kept);
    RUN_TEST(test_the_count_wraps);
    RUN_TEST(test_wait_is_never_early_though_signals_interrupt_it);
    RUN_TEST(test_two_processes_take_turns_without_losing_one);
    RUN_TEST(test_one_ring_wakes_all);
    RUN_TEST(test_a_dead_waiter_delays_no_other);
    return UNITY_END();
}
