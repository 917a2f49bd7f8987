// SPDX-License-Identifier: Apache-2.0
// The co-simulation port: a client that joins, answers grants and leaves as a participant of the scheduler.
// Each malformed line is refused.
#define _GNU_SOURCE
#include "sim/clock/cosimulation_port.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/task.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "test/support/clients.h"
#include "unity.h"

#define STEP_NS 500000U
#define TIMEOUT_MS 20000U

static char path[64];
static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
static osal_lockstep_t* scheduler;
static osal_socket_t client = OSAL_SOCKET_CLOSED;
static cosimulation_port_t cosimulation;

static void open_cosimulation(uint32_t timeout_ms)
{
    cosimulation_port_close(&cosimulation);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      cosimulation_port_open(&cosimulation, path, "operator", scheduler, timeout_ms));
}

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/cosimulation-test-%d", (int)getpid());
    scheduler    = osal_lockstep_create(storage, STEP_NS, true);
    cosimulation = (cosimulation_port_t){.listener = OSAL_SOCKET_CLOSED, .client = OSAL_SOCKET_CLOSED};
    open_cosimulation(TIMEOUT_MS);
}

void tearDown(void)
{
    osal_socket_close(&client);
    cosimulation_port_close(&cosimulation);
}

static void say_octets(const char* text, size_t size)
{
    size_t sent = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&client, (const uint8_t*)text, size, &sent));
    TEST_ASSERT_EQUAL(size, sent);
}

static void say(const char* text)
{
    say_octets(text, strlen(text));
}

static void hear(const char* expected)
{
    char text[COSIMULATION_PORT_LINE_OCTETS] = "";
    size_t total                             = 0U;
    while ((total == 0U) || (text[total - 1U] != '\n')) {
        size_t size = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&client, 10000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_receive(&client, (uint8_t*)&text[total], 1U, &size));
        total += size;
    }
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

static void connect_and_say(const char* join)
{
    osal_socket_close(&client);
    TEST_ASSERT_EQUAL(STATUS_OK, connect_local(&client, path));
    say(join);
}

/// Result of the co-simulation port when a client that has joined answers a grant with `answer`.
static status_t exchange(const char* answer, uint64_t* out_wake_ns, uint32_t* out_octets)
{
    const osal_grant_t grant = {18446744073709551614ULL, 4294967295U, 0U};
    say(answer);
    const status_t status =
        cosimulation_port_exchange(&cosimulation, &grant, 65535U, out_wake_ns, out_octets);
    hear("grant 18446744073709551614 4294967295 0 65535\n");
    return status;
}

static void join_reports_the_port(void)
{
    connect_and_say("join operator 65535\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    TEST_ASSERT_EQUAL_UINT16(65535U, cosimulation.stream_port);
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.joined);
}

static void a_malformed_join_is_refused(void)
{
    static const char* const bad[] = {
        "join operator\n",    "join operator 65536\n",
        "join operator -1\n", "join  operator 0\n",
        "join stranger 0\n",  "join operator 0 \n",
        "JOIN operator 0\n",  "\n",
        "done 0 0\n",         "leave\n",
        "join operator x\n",  "join operator 0\r\n",
        "join operator2 0\n", "join operator 99999999999999999999999999\n",
        "join operator \n",
    };
    for (uint32_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        uint8_t octet = 0U;
        size_t size   = 0U;
        connect_and_say(bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 5U), bad[i]);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, cosimulation.count.malformed);
        TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_stream_receive(&client, &octet, 1U, &size));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, cosimulation.count.joined);
    connect_and_say("join operator 0\n"); // The next client can join.
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
}

static void an_endless_line_and_zero_octets_are_malformed(void)
{
    char flood[COSIMULATION_PORT_LINE_OCTETS + 1U];
    memset(flood, 'j', sizeof flood);
    flood[COSIMULATION_PORT_LINE_OCTETS] = '\0';
    connect_and_say(flood);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 5U));
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.malformed);
    osal_socket_close(&client);
    TEST_ASSERT_EQUAL(STATUS_OK, connect_local(&client, path));
    say_octets("join operator 0\0\n", 17U);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 5U));
    TEST_ASSERT_EQUAL_UINT32(2U, cosimulation.count.malformed);
}

static void clients_that_are_silent_or_disconnect_before_they_join_are_dropped(void)
{
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 0U));
    cosimulation.timeout_ms = 20U;
    connect_and_say("join oper");
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 200U));
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.silent);
    connect_and_say("join oper");
    osal_socket_close(&client);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 20U));
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.vanished);
}

static void a_join_may_arrive_in_pieces(void)
{
    connect_and_say("join oper");
    for (unsigned round = 0U; round < 3U; round++) {
        TEST_ASSERT_EQUAL(STATUS_TIMEOUT, cosimulation_port_accept(&cosimulation, 1U));
    }
    say("ator 7\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    TEST_ASSERT_EQUAL_UINT16(7U, cosimulation.stream_port);
    TEST_ASSERT_EQUAL_UINT32(0U, cosimulation.count.silent);
}

static void well_formed_answers_are_accepted(void)
{
    uint64_t wake_ns = 0U;
    uint32_t octets  = 0U;
    connect_and_say("join operator 0\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    TEST_ASSERT_EQUAL(STATUS_OK, exchange("done 18446744073709551615 4294967295 0\n", &wake_ns, &octets));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, wake_ns);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, octets);
    TEST_ASSERT_EQUAL(STATUS_OK, exchange("done 0 0 65535\n", &wake_ns, &octets));
    TEST_ASSERT_EQUAL_UINT64(0U, wake_ns);
    TEST_ASSERT_EQUAL_UINT16(65535U, cosimulation.stream_port); // The client has another stream now.
    TEST_ASSERT_EQUAL(STATUS_OK,
                      exchange("done never 17 0\nleave\n", &wake_ns, &octets)); // Two lines in one message.
    TEST_ASSERT_EQUAL_UINT64(OSAL_LOCKSTEP_NEVER, wake_ns);
    TEST_ASSERT_EQUAL_UINT32(17U, octets);
    const osal_grant_t grant = {1U, 2U, 3U};
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      cosimulation_port_exchange(&cosimulation, &grant, 0U, &wake_ns, &octets));
    hear("grant 1 2 3 0\n");
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.left);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, cosimulation_port_exchange(&cosimulation, &grant, 0U, &wake_ns,
                                                                &octets)); // No client has joined.
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.left);
}

static void a_malformed_answer_disconnects_the_client(void)
{
    static const char* const bad[] = {
        "done\n",           "done 1\n",
        "done 1 2\n",       "done 1 2 3 4\n",
        "done 1 2 65536\n", "done 1 2 \n",
        "done -1 0 0\n",    "done 18446744073709551616 0 0\n",
        "done never\n",     "done 0 4294967296 0\n",
        "done  1 0 0\n",    "leave now\n",
        "Done 1 0\n",       "join operator 0\n",
        "done 1 0x10 0\n",  "done 99999999999999999999999 1 0\n",
    };
    uint64_t wake_ns = 0U;
    uint32_t octets  = 0U;
    for (uint32_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        connect_and_say("join operator 4000\n");
        TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_CLOSED, exchange(bad[i], &wake_ns, &octets), bad[i]);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, cosimulation.count.malformed);
        TEST_ASSERT_EQUAL_UINT16(0U, cosimulation.stream_port);
    }
}

static void a_client_that_disconnects_or_is_silent_loses_its_slot(void)
{
    const osal_grant_t grant = {0U, 0U, 0U};
    uint64_t wake_ns         = 0U;
    uint32_t octets          = 0U;
    connect_and_say("join operator 0\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    osal_socket_close(&client);
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      cosimulation_port_exchange(&cosimulation, &grant, 0U, &wake_ns, &octets));
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.vanished);
    open_cosimulation(20U);
    connect_and_say("join operator 0\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    say("done 1");
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      cosimulation_port_exchange(&cosimulation, &grant, 0U, &wake_ns, &octets));
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.silent);
}

static void end_of_the_run_ends_every_wait(void)
{
    const osal_grant_t grant = {0U, 0U, 0U};
    uint64_t wake_ns         = 0U;
    uint32_t octets          = 0U;
    connect_and_say("join operator 0\n");
    TEST_ASSERT_EQUAL(STATUS_OK, cosimulation_port_accept(&cosimulation, 10000U));
    osal_lockstep_close(scheduler);
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      cosimulation_port_exchange(&cosimulation, &grant, 0U, &wake_ns, &octets));
    TEST_ASSERT_FALSE(osal_socket_is_open(&cosimulation.client));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, cosimulation_port_accept(&cosimulation, UINT32_MAX));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, cosimulation_port_serve(&cosimulation, scheduler, 5U, 1U));
}

static void the_path_of_the_socket_is_created_and_removed(void)
{
    cosimulation_port_t other;
    struct stat about;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, cosimulation_port_open(&other, path, "operator", scheduler, TIMEOUT_MS));
    cosimulation_port_close(&other); // The path belongs to the first port: it is not removed.
    TEST_ASSERT_EQUAL(0, stat(path, &about));
    cosimulation_port_close(&cosimulation);
    TEST_ASSERT_EQUAL(-1, stat(path, &about));
    TEST_ASSERT_EQUAL(STATUS_IO,
                      cosimulation_port_open(&other, "/no/such/directory/port", "operator", scheduler, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, cosimulation_port_open(&other, "", "operator", scheduler, 1U));
}

// ---- In a running scheduler ----

#define OPERATOR 5U
#define COMMUNICATION 1U

typedef struct {
    status_t first;
    status_t second;
} served_t;

static void serve_twice(void* context)
{
    served_t* const served = context;
    served->first          = cosimulation_port_serve(&cosimulation, scheduler, OPERATOR, COMMUNICATION);
    served->second         = cosimulation_port_serve(&cosimulation, scheduler, OPERATOR, COMMUNICATION);
}

/// The operator in a process of its own: in its n-th grant it sends 10 n octets and requests a grant ten time
/// steps later; in the fifth it sends `farewell` instead.
static void operate(const char* farewell)
{
    char line[COSIMULATION_PORT_LINE_OCTETS];
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    connect_and_say("join operator 4711\n");
    for (uint64_t i = 1U; i <= 5U; i++) {
        const uint64_t now_ns = (i - 1U) * 10U * STEP_NS;
        (void)snprintf(line, sizeof line, "grant %llu 0 %u 4711\n", (unsigned long long)now_ns,
                       (i > 1U) ? 7U : 0U);
        hear(line);
        (void)snprintf(line, sizeof line, "done %llu %llu 4711\n",
                       (unsigned long long)(now_ns + (10U * STEP_NS)), (unsigned long long)(10U * i));
        say((i < 5U) ? line : farewell);
    }
    _exit((Unity.CurrentTestFailed != 0U) ? 1 : 0);
}

/// Run communication: each delivery of the operator wakes it, and it sends 7 octets in time for the
/// operator's next grant.
static void communicate(osal_clock_t* clock)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(clock, 0U, NULL, 0U));
    osal_lockstep_serve_stream(scheduler, OPERATOR, 4711U, COMMUNICATION);
    for (uint32_t i = 1U; i < 5U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(clock, OSAL_CLOCK_NEVER, NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64(((uint64_t)(i - 1U) * 10U + 1U) * STEP_NS, osal_clock_now_ns(clock));
        TEST_ASSERT_EQUAL_UINT32(10U * i, osal_clock_octets_due(clock));
        TEST_ASSERT_EQUAL_UINT32(0U, osal_clock_messages_due(clock));
        TEST_ASSERT_EQUAL_UINT16(4711U, osal_lockstep_stream_port(scheduler, OPERATOR));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(clock, (uint64_t)i * 10U * STEP_NS, NULL, 0U));
        osal_clock_deliver(clock, OPERATOR, OSAL_LOCKSTEP_ANY_LIFE, 0U, 7U);
    }
}

static void run_with(const char* farewell)
{
    served_t served = {STATUS_COUNT, STATUS_COUNT};
    osal_task_t task;
    osal_clock_t clock;
    int exit_status = -1;
    osal_lockstep_expect(scheduler, COMMUNICATION, 1U, 0U);
    osal_lockstep_expect(scheduler, OPERATOR, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, serve_twice, &served, 0));
    const pid_t id = fork();
    if (id == 0) {
        operate(farewell);
    }
    osal_clock_open_stepped(&clock, scheduler, COMMUNICATION, OSAL_LOCKSTEP_ANY_LIFE);
    communicate(&clock);
    // Time continues without the operator.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(&clock, 1000U * STEP_NS, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(1000U * STEP_NS, osal_clock_now_ns(&clock));
    TEST_ASSERT_FALSE(osal_lockstep_is_present(scheduler, OPERATOR));
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_stream_port(scheduler, OPERATOR));
    osal_lockstep_close(scheduler);
    osal_task_join(&task);
    TEST_ASSERT_EQUAL(STATUS_OK, served.first);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, served.second);
    TEST_ASSERT_EQUAL(id, waitpid(id, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static void time_continues_after_the_operator_leaves(void)
{
    run_with("leave\n");
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.left);
}

static void time_continues_after_the_operator_disconnects(void)
{
    run_with("done");
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.vanished);
}

static void time_continues_after_the_operator_sends_a_malformed_line(void)
{
    run_with("done tomorrow\n");
    TEST_ASSERT_EQUAL_UINT32(1U, cosimulation.count.malformed);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(join_reports_the_port);
    RUN_TEST(a_malformed_join_is_refused);
    RUN_TEST(an_endless_line_and_zero_octets_are_malformed);
    RUN_TEST(clients_that_are_silent_or_disconnect_before_they_join_are_dropped);
    RUN_TEST(a_join_may_arrive_in_pieces);
    RUN_TEST(well_formed_answers_are_accepted);
    RUN_TEST(a_malformed_answer_disconnects_the_client);
    RUN_TEST(a_client_that_disconnects_or_is_silent_loses_its_slot);
    RUN_TEST(end_of_the_run_ends_every_wait);
    RUN_TEST(the_path_of_the_socket_is_created_and_removed);
    RUN_TEST(time_continues_after_the_operator_leaves);
    RUN_TEST(time_continues_after_the_operator_disconnects);
    RUN_TEST(time_continues_after_the_operator_sends_a_malformed_line);
    return UNITY_END();
}
