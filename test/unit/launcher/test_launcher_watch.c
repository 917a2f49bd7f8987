// SPDX-License-Identifier: Apache-2.0
// A machine under load must not end a flight: if the holder of the grant is ready but gets no processor, it
// does not count as hanging, however much wall-clock time passes.
#include "launcher/launcher_internal.h"

#include "unity.h"

#define HOLDER 3U
#define HANG_NS 5000000000ULL ///< Limit of processor time in stepped time.

static launcher_t launcher;
static uint64_t scheduler_storage; // Only its address is used.

void setUp(void)
{
    launcher                         = (launcher_t){0};
    launcher.scheduler               = (osal_lockstep_t*)(void*)&scheduler_storage;
    launcher.child_count             = 1U;
    launcher.children[0].participant = HOLDER;
    launcher.children[0].is_alive    = true;
    launcher.watch = (launcher_watch_t){.holder = HOLDER, .since_ns = 1U, .processor_ns = 0U};
}

static osal_process_t* process(void)
{
    return &launcher.children[0].process;
}

static void start(const char* const program)
{
    const char* const arguments[]      = {"/bin/sh", "-c", program, NULL};
    const osal_process_start_t request = {.arguments = arguments, .processor = -1};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_start(process(), &request));
}

static void end(void)
{
    osal_process_result_t result = {.has_ended = false};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(process(), true));
    while (!result.has_ended) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(process(), &result));
    }
}

void tearDown(void)
{
}

/// Wait until the process is runnable, or until it waits.
static osal_process_look_t look_until(const bool is_runnable)
{
    osal_process_look_t look = {.is_runnable = !is_runnable};
    while ((look.is_runnable != is_runnable) || (look.processor_ns == 0U)) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_look(process(), &look));
    }
    return look;
}

static void a_process_that_waits_for_a_processor_is_starved(void)
{
    start("while :; do :; done");
    (void)look_until(true);
    TEST_ASSERT_TRUE(launcher_is_starved(&launcher));
    end();
}

static void a_process_that_has_used_its_time_is_not_starved(void)
{
    start("while :; do :; done");
    const osal_process_look_t look = look_until(true);
    // At the beginning of the watch the process had used HANG_NS less; this number may be negative and wraps.
    launcher.watch.processor_ns = look.processor_ns - HANG_NS;
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    end();
}

static void a_process_that_waits_for_an_event_is_not_starved(void)
{
    start("read line </dev/null; exec sleep 1000");
    (void)look_until(false);
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    end();
}

static void a_stopped_process_is_not_starved(void)
{
    start("while :; do :; done");
    (void)look_until(true);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_suspend(process()));
    (void)look_until(false);
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    end();
}

static void only_the_holder_of_the_grant_can_be_starved(void)
{
    start("while :; do :; done");
    (void)look_until(true);
    launcher.watch.holder = HOLDER + 1U;
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    launcher.watch.holder   = HOLDER;
    launcher.watch.since_ns = 0U; // The grant has no holder.
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    launcher.watch.since_ns = 1U;
    launcher.scheduler      = NULL; // Each process has its own clock.
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher));
    launcher.scheduler = (osal_lockstep_t*)(void*)&scheduler_storage;
    TEST_ASSERT_TRUE(launcher_is_starved(&launcher));
    end();
    TEST_ASSERT_FALSE(launcher_is_starved(&launcher)); // The process has ended.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_process_that_waits_for_a_processor_is_starved);
    RUN_TEST(a_process_that_has_used_its_time_is_not_starved);
    RUN_TEST(a_process_that_waits_for_an_event_is_not_starved);
    RUN_TEST(a_stopped_process_is_not_starved);
    RUN_TEST(only_the_holder_of_the_grant_can_be_starved);
    return UNITY_END();
}
