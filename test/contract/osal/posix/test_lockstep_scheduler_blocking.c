// SPDX-License-Identifier: Apache-2.0
// No call that waits gives up the grant: a participant makes each call during its grant and waits for an
// event that happens in wall-clock time or never, while another participant is ready. Until the grant is
// given back, simulated time stands still and the other one does not run. test/hil runs this program again on
// a kernel with virtual CAN interfaces.
#define _GNU_SOURCE
#include "osal/include/osal/can.h"
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/device.h"
#include "osal/include/osal/directory.h"
#include "osal/include/osal/event.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/mqueue.h"
#include "osal/include/osal/mutex.h"
#include "osal/include/osal/network.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/serial.h"
#include "osal/include/osal/shm.h"
#include "osal/include/osal/socket.h"
#include "osal/include/osal/task.h"
#include "osal/include/osal/tipc.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "test/support/clients.h"
#include "unity.h"

#define STEP_NS 1000U
#define WAIT_MS 5U

static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
static osal_lockstep_t* scheduler;
static osal_clock_t clock_of_test;
static osal_task_t other_task;
static uint64_t other_runs;
static osal_mutex_t mutex;
static osal_event_t event;
static char directory[] = "/tmp/osal-blocking-XXXXXX";
static bool has_vcan;

/// Returns a name unique to this process, which starts with `begin`.
static const char* named(const char* begin)
{
    static char name[64];
    (void)snprintf(name, sizeof name, "%s%ld", begin, (long)getpid() % 100000L);
    return name;
}

/// A participant that asks to run in every time step.
static void run_other(void* context)
{
    osal_clock_t clock;
    osal_clock_open_stepped(&clock, context, 2U, OSAL_LOCKSTEP_ANY_LIFE);
    while (osal_clock_wait(&clock, osal_clock_now_ns(&clock) + STEP_NS, NULL, 0U) == STATUS_OK) {
        (void)__atomic_add_fetch(&other_runs, 1U, __ATOMIC_ACQ_REL);
    }
}

void setUp(void)
{
    other_runs = 0U;
    scheduler  = osal_lockstep_create(storage, STEP_NS, true);
    osal_clock_open_stepped(&clock_of_test, scheduler, 1U, OSAL_LOCKSTEP_ANY_LIFE);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_expect(scheduler, 2U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&other_task, run_other, scheduler, 0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock_of_test, 10U * STEP_NS, NULL, 0U));
}

void tearDown(void)
{
    osal_lockstep_close(scheduler);
    osal_task_join(&other_task);
}

/// A task that is no participant gets no grant: it sleeps in wall-clock time, then does what the call waits
/// for.
static void nap(void* context)
{
    (void)usleep(WAIT_MS * 1000U);
    if (context == &mutex) {
        osal_mutex_unlock(&mutex);
    } else if (context != NULL) {
        osal_event_signal(context);
    } else {
        // The call waits for its end.
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
    TEST_ASSERT_EQUAL(STATUS_OK, connect_tcp(&client, local));
    osal_socket_close(&client);
    osal_socket_close(&listener);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, connect_tcp(&client, local));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, connect_local(&client, "/tmp/osal-nobody-listens"));
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
    osal_file_t other;
    (void)snprintf(path, sizeof path, "%s/file", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&other, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_lock(&file));
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_file_lock(&other));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync(&file));
    osal_file_close(&file);
    osal_file_close(&other);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
}

static void use_directory(void)
{
    osal_directory_t root;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&root, directory));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create_file(&root, "file", 1000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_write(&root, "file", 0U, (const uint8_t*)"x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_sync(&root, "file"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove_file(&root, "file"));
    osal_directory_close(&root);
}

/// No program reads the console: the call waits, but for a limited time.
static void print_to_a_full_pipe(void)
{
    static char block[4096];
    int ends[2];
    const int kept = dup(STDOUT_FILENO);
    TEST_ASSERT_EQUAL(0, pipe2(ends, O_NONBLOCK));
    while (write(ends[1], block, sizeof block) > 0) {
        // Fill the pipe.
    }
    (void)fflush(stdout);
    TEST_ASSERT_EQUAL(STDOUT_FILENO, dup2(ends[1], STDOUT_FILENO));
    osal_console_print_line("lost");
    TEST_ASSERT_EQUAL(STDOUT_FILENO, dup2(kept, STDOUT_FILENO));
    (void)close(kept);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void ask_the_kernel(void)
{
    osal_can_interface_t seen;
    osal_can_claim_t claim;
    osal_network_t home;
    osal_socket_t tipc;
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_can_interface_look("none0", &seen));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_claim(named("blk"), &claim));
    osal_can_interface_release(&claim);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_network_enter(&home, "/nowhere/net"));
    if (osal_tipc_open(&tipc, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE) == STATUS_OK) {
        uint8_t octets[4];
        uint64_t from = 0U;
        size_t size   = 0U;
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_receive(&tipc, &from, octets, sizeof octets, &size));
        osal_socket_close(&tipc);
    }
}

/// A frame that was announced on another interface than that of the waiting end never arrives.
static void wait_for_an_announced_frame(void)
{
    const unsigned number = (unsigned)getpid() % 100000U;
    char interfaces[2][16];
    char addresses[2][64];
    osal_can_t ends[2];
    osal_can_frame_t frame = {.id = 0x181U, .length = 8U};
    for (unsigned i = 0U; has_vcan && (i < 2U); i++) {
        (void)snprintf(interfaces[i], sizeof interfaces[i], "blk%u-%u", i, number);
        (void)snprintf(addresses[i], sizeof addresses[i], "can:blk%u-%u@osal-blk-%u", i, number, number);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(interfaces[i], true, "osal blocking test"));
    }
    if (has_vcan) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(addresses[0]));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&ends[0], addresses[0], OSAL_CAN_WIRE));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&ends[1], addresses[1], OSAL_CAN_NODE));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&ends[0], &frame));
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&ends[1], &frame));
        osal_can_close(&ends[0]);
        osal_can_close(&ends[1]);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_destroy(addresses[0]));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(interfaces[0]));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(interfaces[1]));
    }
}

/// Calls that never block according to their contract; each has nothing to receive or no room to send.
static void use_sockets_and_queues(void)
{
    const char* const name = named("/osal-blocking.");
    uint8_t octets[16];
    size_t size = 0U;
    osal_mqueue_t queue;
    osal_socket_t socket;
    osal_socket_t peer;
    osal_address_t from;
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

/// A FIFO and a serial line whose far ends are idle.
static void use_devices(void)
{
    static uint8_t octets[65536];
    char path[64];
    osal_device_t ends[2];
    status_t status = STATUS_OK;
    size_t size     = 0U;
    (void)snprintf(path, sizeof path, "%s/fifo", directory);
    TEST_ASSERT_EQUAL(0, mkfifo(path, 0600));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_device_open(&ends[1], path, OSAL_DEVICE_WRITE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&ends[0], path, OSAL_DEVICE_READ));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&ends[1], path, OSAL_DEVICE_WRITE));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&ends[0], octets, sizeof octets, &size));
    for (unsigned i = 0U; (i < 100U) && (status == STATUS_OK); i++) {
        status = osal_device_write(&ends[1], octets, sizeof octets, &size);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    osal_device_close(&ends[0]);
    osal_device_close(&ends[1]);
    (void)unlink(path);
    const int far = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE((far >= 0) && (grantpt(far) == 0) && (unlockpt(far) == 0));
    TEST_ASSERT_EQUAL(0, ptsname_r(far, path, sizeof path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&ends[0], path, 9600U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&ends[0], octets, sizeof octets, &size));
    for (unsigned i = 0U; (i < 100U) && (status != STATUS_IO); i++) {
        status = osal_device_write(&ends[0], octets, sizeof octets, &size);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    osal_device_close(&ends[0]);
    (void)close(far);
}

static void use_shared_memory(void)
{
    const char* const name = named("/osal-blocking.");
    osal_shm_t shm;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_open(&shm, name));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, name, 4096U));
    osal_shm_close(&shm);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name));
}

static void use_can(void)
{
    const char* const address = named("shm:osal-blocking-");
    osal_can_t node;
    osal_can_frame_t frame = {.id = 0x181U, .length = 8U};
    status_t status        = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &frame));
    for (unsigned i = 0U; (i <= OSAL_CAN_RING_FRAMES) && (status == STATUS_OK); i++) {
        status = osal_can_send(&node, &frame);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    osal_can_close(&node);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_destroy(address));
}

static void every_wait_but_that_of_the_clock_keeps_the_grant(void)
{
    static void (*const calls[])(void) = {wait_for_event,
                                          join_task,
                                          lock_mutex,
                                          wait_readable,
                                          connect_stream,
                                          wait_for_process,
                                          use_file,
                                          use_directory,
                                          print_to_a_full_pipe,
                                          ask_the_kernel,
                                          use_devices,
                                          use_shared_memory,
                                          use_can,
                                          use_sockets_and_queues,
                                          wait_for_an_announced_frame};
    for (size_t i = 0U; i < (sizeof calls / sizeof calls[0]); i++) {
        const uint64_t now_ns = osal_lockstep_now_ns(scheduler);
        const uint64_t runs   = __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE);
        calls[i]();
        TEST_ASSERT_EQUAL_UINT64(now_ns, osal_lockstep_now_ns(scheduler));
        TEST_ASSERT_EQUAL_UINT64(now_ns, osal_clock_now_ns(&clock_of_test));
        TEST_ASSERT_EQUAL_UINT64(runs, __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock_of_test, now_ns + (10U * STEP_NS), NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64(runs + 10U, __atomic_load_n(&other_runs, __ATOMIC_ACQUIRE));
    }
}

int main(void)
{
    if (mkdtemp(directory) == NULL) {
        return 1;
    }
    const char* const probe = named("blp");
    has_vcan                = (osal_can_interface_create(probe, false, "osal blocking test") == STATUS_OK);
    (void)osal_can_interface_remove(probe);
    UNITY_BEGIN();
    RUN_TEST(every_wait_but_that_of_the_clock_keeps_the_grant);
    const int failures = UNITY_END();
    (void)rmdir(directory);
    return failures;
}
