// SPDX-License-Identifier: Apache-2.0
// No call that waits escapes the calendar: each is tried by a participant within its grant, for something
// that comes in wall-clock time or never, while another participant wants to run. Until the grant is given
// back, simulated time stands still and the other one does not run.
#define _GNU_SOURCE
#include "osal/include/osal/can.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/device.h"
#include "osal/include/osal/doorbell.h"
#include "osal/include/osal/event.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/mqueue.h"
#include "osal/include/osal/mutex.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/socket.h"
#include "osal/include/osal/task.h"

#include <stdio.h>
#include <unistd.h>

#include "unity.h"

#define SLOT_NS 1000U
#define WAIT_MS 5U

static uint64_t storage[OSAL_CALENDAR_BYTES / 8U] __attribute__((aligned(64)));
static osal_calendar_t* calendar;
static osal_clock_t clock_of_test;
static osal_task_t other_task;
static uint64_t other_runs;
static osal_mutex_t mutex;
static osal_event_t event;

/// Wants to run in every slot.
static void run_other(void* context)
{
    osal_clock_t clock;
    osal_clock_open_stepped(&clock, context, 2U);
    while (osal_clock_wait(&clock, osal_clock_now_ns(&clock) + SLOT_NS, NULL, 0U) == STATUS_OK) {
        (void)__atomic_add_fetch(&other_runs, 1U, __ATOMIC_ACQ_REL);
    }
}

void setUp(void)
{
    other_runs = 0U;
    calendar   = osal_calendar_create(storage, SLOT_NS, true);
    osal_clock_open_stepped(&clock_of_test, calendar, 1U);
    osal_calendar_expect(calendar, 1U);
    osal_calendar_expect(calendar, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&other_task, run_other, calendar, 0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock_of_test, 10U * SLOT_NS, NULL, 0U));
}

void tearDown(void)
{
    osal_calendar_close(calendar);
    osal_task_join(&other_task);
}

/// Nothing that is no participant gets a grant: sleeps in wall-clock time, then does what is waited for.
static void nap(void* context)
{
    (void)usleep(WAIT_MS * 1000U);
    if (context == &mutex) {
        osal_mutex_unlock(&mutex);
    } else if (context != NULL) {
        osal_event_signal(context);
    } else {
        // Its end is waited for.
    }
}

static void lock_nap_unlock(void* context)
{
    (void)osal_mutex_lock(&mutex);
    osal_event_signal(context);
    nap(&mutex);
}

static void wait_for_event(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_event_wait(&event, WAIT_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, nap, &event, 0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&event, UINT32_MAX));
    osal_task_join(&task);
}

static void wait_for_doorbell(void)
{
    osal_doorbell_t bell = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_doorbell_wait(&bell, 0U, WAIT_MS));
}

static void join_task(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, nap, NULL, 0));
    osal_task_join(&task);
}

static void lock_mutex(void)
{
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_create(&mutex, false));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, lock_nap_unlock, &event, 0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_event_wait(&event, UINT32_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock(&mutex));
    osal_mutex_unlock(&mutex);
    osal_task_join(&task);
    osal_mutex_destroy(&mutex);
}

static void wait_readable(void)
{
    osal_socket_t quiet;
    osal_socket_t peer;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&quiet, &peer));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_socket_wait_readable(&quiet, WAIT_MS));
    osal_socket_close(&quiet);
    osal_socket_close(&peer);
}

static void connect_stream(void)
{
    osal_socket_t listener;
    osal_socket_t client;
    osal_address_t local = {OSAL_IPV4_LOOPBACK, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&listener, local));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&listener, &local));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_connect(&client, local));
    osal_socket_close(&client);
    osal_socket_close(&listener);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_tcp_connect(&client, local));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_local_connect(&client, "/tmp/osal-nobody-listens"));
}

static void wait_for_process(void)
{
    static const char* const arguments[] = {"/bin/sleep", "0.01", NULL};
    const osal_process_start_t start     = {.arguments = arguments, .processor = -1};
    osal_process_t process;
    osal_process_t* const processes[] = {&process};
    osal_process_result_t result      = {.has_ended = false};
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_process_wait_any(processes, 0U, WAIT_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_start(&process, &start));
    while (!result.has_ended) {
        TEST_ASSERT_NOT_EQUAL(STATUS_IO, osal_process_wait_any(processes, 1U, 20000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(&process, &result));
    }
}

static void use_file(void)
{
    char path[64];
    osal_file_t file;
    (void)snprintf(path, sizeof path, "/tmp/osal-blocking.%d", (int)getpid());
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync(&file));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
}

/// Calls that say that they never block: all of them where there is nothing to have.
static void use_what_never_blocks(void)
{
    char name[64];
    uint8_t octets[16];
    size_t size = 0U;
    osal_mqueue_t queue;
    osal_socket_t socket;
    osal_socket_t peer;
    osal_address_t from;
    (void)snprintf(name, sizeof name, "/osal-blocking.%d", (int)getpid());
    if (osal_mqueue_create(&queue, name, 1U, sizeof octets) == STATUS_OK) {
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_mqueue_receive(&queue, octets, sizeof octets, &size));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_send(&queue, octets, 1U));
        TEST_ASSERT_EQUAL(STATUS_FULL, osal_mqueue_send(&queue, octets, 1U));
        osal_mqueue_close(&queue);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(name));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&socket, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_udp_receive(&socket, &from, octets, sizeof octets, &size));
    osal_socket_close(&socket);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&socket, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tcp_accept(&socket, &peer, &from));
    osal_socket_close(&socket);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&socket, &peer));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_stream_receive(&socket, octets, sizeof octets, &size));
    osal_socket_close(&socket);
    osal_socket_close(&peer);
}

static void test_every_wait_but_that_of_the_clock_keeps_the_grant(void)
{
    static void (*const calls[])(void) = {wait_for_event,   wait_for_doorbell, join_task,
                                          lock_mutex,       wait_readable,     connect_stream,
                                          wait_for_process, use_file,          use_what_never_blocks};
    for (size_t i = 0U; i < (sizeof calls / sizeof calls[0]); i++) {
        const uint64_t now_ns = osal_calendar_now_ns(calendar);
        const uint64_t runs   = __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE);
        calls[i]();
        TEST_ASSERT_EQUAL_UINT64(now_ns, osal_calendar_now_ns(calendar));
        TEST_ASSERT_EQUAL_UINT64(now_ns, osal_clock_now_ns(&clock_of_test));
        TEST_ASSERT_EQUAL_UINT64(runs, __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock_of_test, now_ns + (10U * SLOT_NS), NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64(runs + 10U, __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_wait_but_that_of_the_clock_keeps_the_grant);
    return UNITY_END();
}
