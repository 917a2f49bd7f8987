// SPDX-License-Identifier: Apache-2.0
// Priority inversion with three tasks on one processor: the low one holds the lock, the high one waits for
// it, the middle one computes for a long time. With priority inheritance the high one ends before the middle
// one. The same sequence with a lock without inheritance shows that the test can fail.
#define _GNU_SOURCE
#include "osal/include/osal/clock.h"
#include "osal/include/osal/event.h"
#include "osal/include/osal/mutex.h"
#include "osal/include/osal/task.h"

#include <pthread.h>
#include <sched.h>

#include "unity.h"

#define WORK_NS 50000000ULL

typedef struct {
    bool is_plain; ///< The lock is `plain`, a lock of the system without priority inheritance.
    osal_mutex_t mutex;
    pthread_mutex_t plain;
    // Events between the tasks and the test.
    osal_event_t held;    ///< The low task has the lock.
    osal_event_t go;      ///< The low task shall unlock.
    osal_event_t working; ///< The middle task runs.
    osal_event_t waiting; ///< The high task is about to lock.
    uint32_t ended;       ///< Number of tasks that have done their work.
    uint32_t high_rank;
    uint32_t middle_rank;
} scene_t;

static scene_t scene;

void setUp(void)
{
}

void tearDown(void)
{
}

static void lock(void)
{
    if (scene.is_plain) {
        (void)pthread_mutex_lock(&scene.plain);
    } else {
        (void)osal_mutex_lock(&scene.mutex);
    }
}

static void unlock(void)
{
    if (scene.is_plain) {
        (void)pthread_mutex_unlock(&scene.plain);
    } else {
        osal_mutex_unlock(&scene.mutex);
    }
}

static void run_low(void* context)
{
    (void)context;
    lock();
    osal_event_signal(&scene.held);
    while (osal_event_wait(&scene.go, UINT32_MAX) != STATUS_OK) {
    }
    unlock();
}

static void run_middle(void* context)
{
    (void)context;
    osal_event_signal(&scene.working);
    const uint64_t until_ns = osal_clock_monotonic_ns() + WORK_NS;
    while (osal_clock_monotonic_ns() < until_ns) {
    }
    scene.middle_rank = __atomic_add_fetch(&scene.ended, 1U, __ATOMIC_ACQ_REL);
}

static void run_high(void* context)
{
    (void)context;
    osal_event_signal(&scene.waiting);
    lock();
    scene.high_rank = __atomic_add_fetch(&scene.ended, 1U, __ATOMIC_ACQ_REL);
    unlock();
}

static void run_tasks(void)
{
    osal_task_t low;
    osal_task_t middle;
    osal_task_t high;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&scene.mutex, false));
    TEST_ASSERT_EQUAL(0, pthread_mutex_init(&scene.plain, NULL));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&low, run_low, NULL, 10));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&scene.held, UINT32_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&high, run_high, NULL, 30));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&scene.waiting, UINT32_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&middle, run_middle, NULL, 20));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&scene.working, UINT32_MAX)); // `high` waits.
    osal_event_signal(&scene.go);
    osal_task_join(&high);
    osal_task_join(&middle);
    osal_task_join(&low);
    (void)pthread_mutex_destroy(&scene.plain);
}

static void begin(const bool is_plain)
{
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(0, &one);
    scene = (scene_t){.is_plain = is_plain};
    if ((sched_setaffinity(0, sizeof one, &one) != 0) || (osal_task_set_priority(40) != STATUS_OK)) {
        TEST_IGNORE_MESSAGE("not tested: real-time priority is not permitted here");
    }
}

static void the_holder_of_a_lock_inherits_the_priority_of_the_waiter(void)
{
    begin(false);
    run_tasks();
    TEST_ASSERT_EQUAL_UINT32(1U, scene.high_rank);
    TEST_ASSERT_EQUAL_UINT32(2U, scene.middle_rank);
}

static void without_priority_inheritance_the_inversion_occurs(void)
{
    begin(true);
    run_tasks();
    TEST_ASSERT_EQUAL_UINT32(1U, scene.middle_rank);
    TEST_ASSERT_EQUAL_UINT32(2U, scene.high_rank);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_holder_of_a_lock_inherits_the_priority_of_the_waiter);
    RUN_TEST(without_priority_inheritance_the_inversion_occurs);
    return UNITY_END();
}
