// SPDX-License-Identifier: Apache-2.0
// Priorities and signals of tasks, with and without privilege.
#define _GNU_SOURCE
#include "osal/include/osal/task.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

typedef struct {
    int policy;
    int priority;
    int is_blocked;
    uint32_t runs;
} seen_t;

void setUp(void)
{
}

void tearDown(void)
{
}

static void look(void* context)
{
    seen_t* const seen = context;
    struct sched_param parameters;
    sigset_t blocked;
    (void)pthread_getschedparam(pthread_self(), &seen->policy, &parameters);
    seen->priority = parameters.sched_priority;
    (void)pthread_sigmask(SIG_SETMASK, NULL, &blocked);
    seen->is_blocked = sigismember(&blocked, SIGTERM);
    seen->runs++;
}

static void a_task_without_a_priority_is_scheduled_as_others(void)
{
    osal_task_t task;
    seen_t seen = {.runs = 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, look, &seen, 0));
    osal_task_join(&task);
    TEST_ASSERT_EQUAL(SCHED_OTHER, seen.policy);
}

static void signals_stay_with_the_first_task(void)
{
    osal_task_t task;
    sigset_t blocked;
    seen_t seen = {.runs = 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, look, &seen, 0));
    osal_task_join(&task);
    TEST_ASSERT_EQUAL(1, seen.is_blocked);
    TEST_ASSERT_EQUAL(0, pthread_sigmask(SIG_SETMASK, NULL, &blocked));
    TEST_ASSERT_EQUAL(0, sigismember(&blocked, SIGTERM));
}

static void priority_is_set_where_permitted(void)
{
    osal_task_t task;
    seen_t seen = {.runs = 0U};
    // Starts with and without the permission.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, look, &seen, 42));
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT32(1U, seen.runs);
    const status_t status = osal_task_set_priority(43);
    if (status == STATUS_DENIED) {
        TEST_ASSERT_EQUAL(SCHED_OTHER, seen.policy);
        TEST_IGNORE_MESSAGE("no real-time priority permitted here");
    }
    seen_t own = {.runs = 0U};
    look(&own);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_set_priority(0));
    TEST_ASSERT_EQUAL(SCHED_FIFO, seen.policy);
    TEST_ASSERT_EQUAL(42, seen.priority);
    TEST_ASSERT_EQUAL(SCHED_FIFO, own.policy);
    TEST_ASSERT_EQUAL(43, own.priority);
    look(&own);
    TEST_ASSERT_EQUAL(SCHED_OTHER, own.policy);
}

/// Without privilege a task still starts, but does not get its priority.
static void without_privilege_a_task_starts_with_no_priority(void)
{
    if (geteuid() != 0U) {
        TEST_IGNORE_MESSAGE("the tests above ran without privilege");
    }
    const pid_t child = fork();
    if (child == 0) {
        osal_task_t task;
        seen_t seen           = {.runs = 0U};
        const bool is_dropped = (setgid(65534) == 0) && (setuid(65534) == 0);
        const bool is_good    = is_dropped && (osal_task_start(&task, look, &seen, 42) == STATUS_OK);
        if (is_good) {
            osal_task_join(&task);
        }
        const bool is_refused = (seen.policy == SCHED_FIFO) || (osal_task_set_priority(42) == STATUS_DENIED);
        _exit((is_good && (seen.runs == 1U) && is_refused) ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

/// Tested in a child process whose limit (RLIMIT_NPROC) permits no further task.
static void exhausted_tasks_are_reported_as_a_status(void)
{
    if (geteuid() != 0U) {
        TEST_IGNORE_MESSAGE("only a privileged process can set the limit");
    }
    const pid_t child = fork();
    if (child == 0) {
        const struct rlimit none = {0U, 0U};
        osal_task_t task;
        seen_t seen = {.runs = 0U};
        const bool is_limited =
            (setrlimit(RLIMIT_NPROC, &none) == 0) && (setgid(65534) == 0) && (setuid(65534) == 0);
        const bool is_refused = (osal_task_start(&task, look, &seen, 0) == STATUS_EXHAUSTED) &&
                                (osal_task_start(&task, look, &seen, 10) == STATUS_EXHAUSTED);
        if (is_limited && is_refused) {
            osal_task_join(&task); // There is nothing to wait for.
        }
        _exit((is_limited && is_refused && (seen.runs == 0U)) ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static void count_processors(void* context)
{
    int* const count = context;
    cpu_set_t set;
    osal_task_unpin();
    *count = (sched_getaffinity(0, sizeof set, &set) == 0) ? CPU_COUNT(&set) : 0;
}

static void a_task_of_a_pinned_program_can_use_the_processors_of_its_parent(void)
{
    cpu_set_t all;
    int status = 0;
    TEST_ASSERT_EQUAL(0, sched_getaffinity(0, sizeof all, &all));
    const pid_t child = fork();
    if (child == 0) {
        size_t first = 0U;
        int count    = 0;
        cpu_set_t one;
        osal_task_t task;
        while (!CPU_ISSET(first, &all)) {
            first++;
        }
        CPU_ZERO(&one);
        CPU_SET(first, &one);
        const bool is_pinned  = sched_setaffinity(0, sizeof one, &one) == 0;
        const bool is_started = osal_task_start(&task, count_processors, &count, 0) == STATUS_OK;
        osal_task_join(&task);
        const bool is_own_pinned = (sched_getaffinity(0, sizeof one, &one) == 0) && (CPU_COUNT(&one) == 1);
        _exit((is_pinned && is_started && is_own_pinned && (count == CPU_COUNT(&all))) ? 0 : 1);
    }
    TEST_ASSERT_EQUAL(child, waitpid(child, &status, 0));
    TEST_ASSERT_EQUAL(0, status);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_task_of_a_pinned_program_can_use_the_processors_of_its_parent);
    RUN_TEST(a_task_without_a_priority_is_scheduled_as_others);
    RUN_TEST(signals_stay_with_the_first_task);
    RUN_TEST(priority_is_set_where_permitted);
    RUN_TEST(without_privilege_a_task_starts_with_no_priority);
    RUN_TEST(exhausted_tasks_are_reported_as_a_status);
    return UNITY_END();
}
