// SPDX-License-Identifier: Apache-2.0
// Each piece of offered work is performed once and is complete after the call that finishes it, whether the
// task has not begun it, performs it, or has performed it. A task that gets no processor is seldom woken.
#include "sim/app/work_aside.h"

#include <pthread.h>
#include <time.h>

#include "unity.h"

#define OFFERS 1000U
#define PAUSE_NS 1000000L

typedef struct {
    unsigned pieces; ///< Not atomic: the thread sanitizer then shows work that is performed twice at once.
    unsigned by_others;
    bool has_begun;
    bool is_slow; ///< The work is not complete before the caller waits for it.
    pthread_t test;
} done_t;

static work_aside_t aside;
static done_t done;
static unsigned begins;
static bool has_no_room_for_a_task;
static bool is_starved; ///< The task gets no processor: no offer wakes it.
static unsigned signals;
static bool is_awaited; ///< The caller waits for the task.

status_t __real_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority);
status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority);

status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority)
{
    return has_no_room_for_a_task ? STATUS_EXHAUSTED : __real_osal_task_start(task, entry, context, priority);
}

void __real_osal_event_signal(osal_event_t* event);
void __wrap_osal_event_signal(osal_event_t* event);

void __wrap_osal_event_signal(osal_event_t* event)
{
    signals += (event == &aside.offered) ? 1U : 0U;
    if (!is_starved || (event != &aside.offered)) {
        __real_osal_event_signal(event);
    }
}

status_t __real_osal_event_wait(osal_event_t* event, uint32_t timeout_ms);
status_t __wrap_osal_event_wait(osal_event_t* event, uint32_t timeout_ms);

status_t __wrap_osal_event_wait(osal_event_t* event, uint32_t timeout_ms)
{
    if (event == &aside.finished) {
        __atomic_store_n(&is_awaited, true, __ATOMIC_RELEASE);
    }
    return __real_osal_event_wait(event, timeout_ms);
}

static void pause_shortly(void)
{
    (void)nanosleep(&(const struct timespec){.tv_nsec = PAUSE_NS}, NULL);
}

static void begin(void)
{
    begins++;
}

static void work(void* const context)
{
    done_t* const all = context;
    __atomic_store_n(&all->has_begun, true, __ATOMIC_RELEASE);
    while (all->is_slow && !__atomic_load_n(&is_awaited, __ATOMIC_ACQUIRE)) {
        pause_shortly();
    }
    all->pieces++;
    all->by_others += (pthread_equal(pthread_self(), all->test) == 0) ? 1U : 0U;
}

void setUp(void)
{
    done                   = (done_t){.test = pthread_self()};
    begins                 = 0U;
    has_no_room_for_a_task = false;
    is_starved             = false;
    is_awaited             = false;
    signals                = 0U;
    work_aside_open(&aside, work, &done);
}

void tearDown(void)
{
    is_starved = false;
    work_aside_close(&aside);
}

/// Offer a piece and wait until it has been begun.
static void offer_and_wait(void)
{
    __atomic_store_n(&done.has_begun, false, __ATOMIC_RELEASE);
    work_aside_offer(&aside);
    while (!__atomic_load_n(&done.has_begun, __ATOMIC_ACQUIRE)) {
        pause_shortly();
    }
}

static void offer_and_finish(unsigned times)
{
    for (unsigned i = 0U; i < times; i++) {
        work_aside_offer(&aside);
        work_aside_finish(&aside);
    }
}

static void a_task_performs_the_work_while_the_caller_continues(void)
{
    work_aside_start_task(&aside, begin);
    offer_and_wait();
    TEST_ASSERT_TRUE(work_aside_is_pending(&aside));
    work_aside_finish(&aside);
    TEST_ASSERT_FALSE(work_aside_is_pending(&aside));
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
    TEST_ASSERT_EQUAL_UINT(1U, done.by_others);
    TEST_ASSERT_EQUAL_UINT(1U, begins);
}

static void the_caller_waits_for_work_that_is_being_performed(void)
{
    done.is_slow = true;
    work_aside_start_task(&aside, begin);
    offer_and_wait();
    work_aside_finish(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
    TEST_ASSERT_EQUAL_UINT(1U, done.by_others);
    done.is_slow = false;
    work_aside_offer(&aside); // The task was late, so it is not woken.
    work_aside_finish(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, signals);
    TEST_ASSERT_EQUAL_UINT(2U, done.pieces);
    TEST_ASSERT_EQUAL_UINT(1U, done.by_others);
}

static void each_piece_is_performed_once_in_whatever_task(void)
{
    work_aside_start_task(&aside, begin);
    for (unsigned i = 1U; i <= OFFERS; i++) {
        work_aside_offer(&aside);
        work_aside_finish(&aside);
        work_aside_finish(&aside); // There is no other work.
        TEST_ASSERT_EQUAL_UINT(i, done.pieces);
    }
}

static void without_a_task_the_work_is_performed_at_once(void)
{
    has_no_room_for_a_task = true;
    work_aside_start_task(&aside, begin);
    work_aside_offer(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
    TEST_ASSERT_FALSE(work_aside_is_pending(&aside));
    work_aside_finish(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
    TEST_ASSERT_EQUAL_UINT(0U, done.by_others);
}

static void a_task_without_a_processor_is_seldom_woken(void)
{
    is_starved = true;
    work_aside_start_task(&aside, begin);
    for (unsigned i = 1U; i <= OFFERS; i++) {
        work_aside_offer(&aside);
        work_aside_finish(&aside);
        TEST_ASSERT_EQUAL_UINT(i, done.pieces);
    }
    TEST_ASSERT_EQUAL_UINT(0U, done.by_others);
    TEST_ASSERT_EQUAL_UINT(5U, signals); // After pauses of 64, 128, 256 and 512 offers.
}

static void a_task_that_was_late_is_woken_again_after_a_pause(void)
{
    is_starved = true;
    work_aside_start_task(&aside, begin);
    work_aside_offer(&aside);
    work_aside_finish(&aside);
    is_starved = false;
    offer_and_finish(64U);
    TEST_ASSERT_EQUAL_UINT(1U, signals);
    for (unsigned i = 0U; i < 3U; i++) { // From then on the task performs each piece in time.
        offer_and_wait();
        while (__atomic_load_n(&aside.stage, __ATOMIC_ACQUIRE) != 0U) {
            pause_shortly();
        }
        work_aside_finish(&aside);
    }
    TEST_ASSERT_EQUAL_UINT(4U, signals);
    TEST_ASSERT_EQUAL_UINT(3U, done.by_others);
    is_starved = true; // The second pause is nearly twice as long as the first.
    offer_and_finish(1U + 124U);
    TEST_ASSERT_EQUAL_UINT(5U, signals);
    offer_and_finish(1U);
    TEST_ASSERT_EQUAL_UINT(6U, signals);
}

static void withdrawn_work_is_dropped_or_complete(void)
{
    is_starved = true;
    work_aside_start_task(&aside, begin);
    work_aside_offer(&aside);
    work_aside_withdraw(&aside);
    TEST_ASSERT_EQUAL_UINT(0U, done.pieces);
    work_aside_finish(&aside);
    TEST_ASSERT_EQUAL_UINT(0U, done.pieces);
    is_starved   = false;
    done.is_slow = true;
    offer_and_wait();
    work_aside_withdraw(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
}

static void the_end_finishes_the_work(void)
{
    is_starved = true;
    work_aside_start_task(&aside, begin);
    work_aside_offer(&aside);
    is_starved = false;
    work_aside_close(&aside);
    TEST_ASSERT_EQUAL_UINT(1U, done.pieces);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_task_performs_the_work_while_the_caller_continues);
    RUN_TEST(the_caller_waits_for_work_that_is_being_performed);
    RUN_TEST(each_piece_is_performed_once_in_whatever_task);
    RUN_TEST(without_a_task_the_work_is_performed_at_once);
    RUN_TEST(a_task_without_a_processor_is_seldom_woken);
    RUN_TEST(a_task_that_was_late_is_woken_again_after_a_pause);
    RUN_TEST(withdrawn_work_is_dropped_or_complete);
    RUN_TEST(the_end_finishes_the_work);
    return UNITY_END();
}
