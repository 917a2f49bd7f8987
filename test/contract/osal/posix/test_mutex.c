// SPDX-License-Identifier: Apache-2.0
// Locks between processes, one of which may die while it holds the lock.
#define _GNU_SOURCE
#include "osal/include/osal/mutex.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define PROCESSES 4U
#define ROUNDS 20000U

typedef struct {
    osal_mutex_t mutex;
    uint64_t sum;
    uint64_t check;
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

static void count(void)
{
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        if (osal_mutex_lock(&shared->mutex) != STATUS_OK) {
            abort();
        }
        shared->sum++;
        osal_mutex_unlock(&shared->mutex);
    }
}

static void processes_exclude_each_other(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared->mutex, true));
    for (size_t i = 0U; i < PROCESSES; i++) {
        if (fork() == 0) {
            count();
            _exit(0);
        }
    }
    int exit_status = -1;
    while (wait(&exit_status) > 0) {
        TEST_ASSERT_EQUAL(0, exit_status);
    }
    TEST_ASSERT_EQUAL_UINT64(PROCESSES * ROUNDS, shared->sum);
}

static void the_death_of_a_lock_holder_is_reported_once_and_blocks_no_process(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared->mutex, true));
    const pid_t holder = fork();
    if (holder == 0) {
        (void)osal_mutex_lock(&shared->mutex);
        __atomic_store_n(&shared->check, 1U, __ATOMIC_RELEASE);
        (void)pause();
    }
    while (__atomic_load_n(&shared->check, __ATOMIC_ACQUIRE) == 0U) {
        (void)usleep(100U);
    }
    const pid_t waiter = fork(); // The waiter sleeps on the lock when the holder dies, or is about to sleep.
    if (waiter == 0) {
        const status_t first = osal_mutex_lock(&shared->mutex);
        osal_mutex_unlock(&shared->mutex);
        _exit((first == STATUS_CLOSED) ? 0 : 1);
    }
    (void)usleep(5000U);
    TEST_ASSERT_EQUAL(0, kill(holder, SIGKILL));
    TEST_ASSERT_EQUAL(holder, waitpid(holder, NULL, 0));
    int exit_status = -1;
    TEST_ASSERT_EQUAL(waiter, waitpid(waiter, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock(&shared->mutex));
    osal_mutex_unlock(&shared->mutex);
}

static void a_wait_for_the_lock_ends_in_time_and_the_holder_is_known(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared->mutex, true));
    TEST_ASSERT_EQUAL(0, osal_mutex_holder(&shared->mutex));
    shared->check      = 0U;
    const pid_t holder = fork();
    if (holder == 0) {
        (void)osal_mutex_lock(&shared->mutex);
        __atomic_store_n(&shared->check, 1U, __ATOMIC_RELEASE);
        (void)pause();
    }
    while (__atomic_load_n(&shared->check, __ATOMIC_ACQUIRE) == 0U) {
        (void)usleep(100U);
    }
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_mutex_lock_within(&shared->mutex, 0U));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_mutex_lock_within(&shared->mutex, 999999999U));
    TEST_ASSERT_EQUAL(holder, osal_mutex_holder(&shared->mutex));
    TEST_ASSERT_EQUAL(0, kill(holder, SIGKILL));
    TEST_ASSERT_EQUAL(holder, waitpid(holder, NULL, 0));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_mutex_lock_within(&shared->mutex, 1000000000U));
    TEST_ASSERT_EQUAL(getpid(), osal_mutex_holder(&shared->mutex));
    osal_mutex_unlock(&shared->mutex);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock_within(&shared->mutex, 0U));
    osal_mutex_unlock(&shared->mutex);
}

/// A coding error ends the program: tested in a child.
static void assert_aborts(void (*mistake)(void))
{
    const pid_t child = fork();
    if (child == 0) {
        (void)close(STDERR_FILENO);
        mistake();
        _exit(0);
    }
    int exit_status = 0;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
    TEST_ASSERT_EQUAL(SIGABRT, WTERMSIG(exit_status));
}

static void lock_twice(void)
{
    (void)osal_mutex_lock(&shared->mutex);
    (void)osal_mutex_lock(&shared->mutex);
}

static void unlock_without_lock(void)
{
    osal_mutex_unlock(&shared->mutex);
}

static void lock_without_creation(void)
{
    (void)osal_mutex_lock(&shared->mutex);
}

static void coding_errors_are_assertions(void)
{
    assert_aborts(lock_without_creation);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared->mutex, false));
    assert_aborts(lock_twice);
    assert_aborts(unlock_without_lock);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(processes_exclude_each_other);
    RUN_TEST(the_death_of_a_lock_holder_is_reported_once_and_blocks_no_process);
    RUN_TEST(a_wait_for_the_lock_ends_in_time_and_the_holder_is_known);
    RUN_TEST(coding_errors_are_assertions);
    return UNITY_END();
}
