// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/mutex.h"

#include "osal/include/osal/event.h"
#include "osal/include/osal/task.h"
#include "test/support/assertion.h"
#include "unity.h"

#include <string.h>

#define TASKS 4U
#define ROUNDS 20000U
#define LONG_MS 20000U

typedef struct {
    osal_mutex_t mutex;
    osal_event_t is_locked;
    osal_event_t release;
    uint64_t sum;
    uint64_t check;
    uint32_t failed;
} shared_t;

static shared_t shared;

void setUp(void)
{
    memset(&shared, 0, sizeof shared);
    osal_event_create(&shared.is_locked);
    osal_event_create(&shared.release);
}

void tearDown(void)
{
}

static void count(void* context)
{
    shared_t* const all = context;
    for (uint32_t i = 0U; i < ROUNDS; i++) {
        all->failed += (osal_mutex_lock(&all->mutex) == STATUS_OK) ? 0U : 1U;
        all->sum++;
        all->check = all->sum;
        osal_mutex_unlock(&all->mutex);
    }
}

static void tasks_exclude_each_other(void)
{
    osal_task_t tasks[TASKS];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared.mutex, false));
    for (size_t i = 0U; i < TASKS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&tasks[i], count, &shared, 0));
    }
    for (size_t i = 0U; i < TASKS; i++) {
        osal_task_join(&tasks[i]);
    }
    TEST_ASSERT_EQUAL_UINT64(TASKS * ROUNDS, shared.sum);
    TEST_ASSERT_EQUAL_UINT64(TASKS * ROUNDS, shared.check);
    TEST_ASSERT_EQUAL_UINT32(0U, shared.failed);
}

static osal_mutex_t never_created;

static void lock_it(void)
{
    (void)osal_mutex_lock(&never_created);
}

/// On some systems a mutex of zeros works, on others it fails: this layer treats it as an error on all.
static void a_mutex_that_was_not_created_is_not_locked(void)
{
    TEST_ASSERT_TRUE(assertion_fails(lock_it));
}

static void hold(void* context)
{
    shared_t* const all = context;
    all->failed += (osal_mutex_lock(&all->mutex) == STATUS_OK) ? 0U : 1U;
    osal_event_signal(&all->is_locked);
    all->failed += (osal_event_wait(&all->release, LONG_MS) == STATUS_OK) ? 0U : 1U;
    osal_mutex_unlock(&all->mutex);
}

static void a_wait_for_the_lock_ends_in_time_and_the_holder_is_known(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared.mutex, false));
    TEST_ASSERT_EQUAL(0, osal_mutex_holder(&shared.mutex));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, hold, &shared, 0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&shared.is_locked, LONG_MS));
    const int32_t other = osal_mutex_holder(&shared.mutex);
    TEST_ASSERT_NOT_EQUAL(0, other);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_mutex_lock_within(&shared.mutex, 0U));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_mutex_lock_within(&shared.mutex, 20000000U));
    osal_event_signal(&shared.release);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock_within(&shared.mutex, LONG_MS * 1000000ULL));
    const int32_t own = osal_mutex_holder(&shared.mutex);
    TEST_ASSERT_NOT_EQUAL(0, own);
    TEST_ASSERT_NOT_EQUAL(other, own);
    osal_mutex_unlock(&shared.mutex);
    osal_task_join(&task);
    TEST_ASSERT_EQUAL(0, osal_mutex_holder(&shared.mutex));
    TEST_ASSERT_EQUAL_UINT32(0U, shared.failed);
}

#ifndef THREAD_CHECKS // The thread sanitizer reports these coding errors itself.
static void lock_created(void)
{
    (void)osal_mutex_lock(&shared.mutex);
}

static void unlock_created(void)
{
    osal_mutex_unlock(&shared.mutex);
}

static void locking_a_mutex_twice_and_unlocking_a_free_one_are_coding_errors(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&shared.mutex, false));
    TEST_ASSERT_TRUE(assertion_fails(unlock_created));
    TEST_ASSERT_FALSE(assertion_fails(lock_created));
    TEST_ASSERT_TRUE(assertion_fails(lock_created));
    osal_mutex_unlock(&shared.mutex);
    TEST_ASSERT_TRUE(assertion_fails(unlock_created));
}
#endif

static void a_shared_mutex_is_granted_or_unsupported(void)
{
    const status_t status = osal_mutex_create(&shared.mutex, true);
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has one address space");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock(&shared.mutex));
    TEST_ASSERT_NOT_EQUAL(0, osal_mutex_holder(&shared.mutex));
    osal_mutex_unlock(&shared.mutex);
    TEST_ASSERT_EQUAL(0, osal_mutex_holder(&shared.mutex));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(tasks_exclude_each_other);
    RUN_TEST(a_wait_for_the_lock_ends_in_time_and_the_holder_is_known);
#ifndef THREAD_CHECKS
    RUN_TEST(locking_a_mutex_twice_and_unlocking_a_free_one_are_coding_errors);
#endif
    RUN_TEST(a_shared_mutex_is_granted_or_unsupported);
    RUN_TEST(a_mutex_that_was_not_created_is_not_locked);
    return UNITY_END();
}
