// SPDX-License-Identifier: Apache-2.0
// Lives of participants that are processes: the scheduler handles the end and the hang of a process at any
// moment of wall-clock time.
#define _GNU_SOURCE
#include "osal/include/osal/lockstep_scheduler.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define STEP_NS 500U
#define FIRST 0U
#define SECOND 1U

static osal_lockstep_t* scheduler;

void setUp(void)
{
}

void tearDown(void)
{
}

static osal_lockstep_t* shared_scheduler(void)
{
    void* const memory =
        mmap(NULL, OSAL_LOCKSTEP_OCTETS, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(memory != MAP_FAILED);
    return osal_lockstep_create(memory, STEP_NS, true);
}

/// Start a process that waits as life 1 of the second participant, and exits with 7 when its wait returns
/// that the life has ended.
static pid_t wait_as_second(void)
{
    const pid_t child = fork();
    if (child == 0) {
        osal_grant_t grant = {0U, 0U, 0U};
        status_t status    = STATUS_OK;
        while (status == STATUS_OK) {
            status = osal_lockstep_wait(scheduler, SECOND, 1U, OSAL_LOCKSTEP_NEVER, &grant);
        }
        _exit((status == STATUS_CLOSED) ? 7 : 8);
    }
    while (!osal_lockstep_is_present(scheduler, SECOND)) {
        (void)usleep(1000U);
    }
    return child;
}

static int ending_of(pid_t child)
{
    int status = 0;
    TEST_ASSERT_EQUAL(child, waitpid(child, &status, 0));
    return status;
}

static void a_dismissed_participant_ends_itself_and_a_killed_one_does_nothing_more(void)
{
    scheduler = shared_scheduler();
    osal_lockstep_expect(scheduler, SECOND, 1U, 0U);
    pid_t child = wait_as_second();
    osal_lockstep_dismiss(scheduler, SECOND, 1U);
    int status = ending_of(child);
    TEST_ASSERT_TRUE(WIFEXITED(status) && (WEXITSTATUS(status) == 7));

    scheduler = shared_scheduler();
    osal_lockstep_expect(scheduler, SECOND, 1U, 0U);
    child = wait_as_second();
    osal_lockstep_kill(scheduler, SECOND, 1U);
    status = ending_of(child);
    TEST_ASSERT_TRUE(WIFSIGNALED(status) && (WTERMSIG(status) == SIGKILL));
}

static void a_participant_that_returns_to_an_ended_life_is_refused(void)
{
    scheduler          = shared_scheduler();
    osal_grant_t grant = {0U, 0U, 0U};
    osal_lockstep_expect(scheduler, FIRST, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_wait(scheduler, FIRST, 1U, 0U, &grant));
    osal_lockstep_suspend(scheduler, FIRST); // The suspended participant held the grant, and loses it.
    uint32_t grants = 0U;
    TEST_ASSERT_EQUAL_UINT(OSAL_LOCKSTEP_PARTICIPANTS_MAX, osal_lockstep_holder(scheduler, &grants));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_lockstep_wait(scheduler, FIRST, 1U, 0U, &grant));
    osal_lockstep_end(scheduler, FIRST, 1U);
    osal_lockstep_expect(scheduler, FIRST, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_lockstep_wait(scheduler, FIRST, 1U, 0U, &grant));
    uint32_t life = 0U;
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, osal_lockstep_presence(scheduler, FIRST, &life));
    TEST_ASSERT_EQUAL_UINT32(2U, life);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_wait(scheduler, FIRST, 2U, 0U, &grant));
}

/// Start a process that executes code of the scheduler most of the time.
static pid_t deliver_as_second(uint32_t life)
{
    const pid_t child = fork();
    if (child == 0) {
        osal_grant_t grant = {0U, 0U, 0U};
        if (osal_lockstep_wait(scheduler, SECOND, life, 0U, &grant) != STATUS_OK) {
            _exit(8);
        }
        for (;;) {
            osal_lockstep_deliver(scheduler, SECOND, FIRST, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
        }
    }
    while (!osal_lockstep_is_present(scheduler, SECOND)) {
        (void)usleep(1000U);
    }
    return child;
}

static void a_process_stopped_inside_the_scheduler_is_killed_and_the_others_continue(void)
{
    scheduler = shared_scheduler();
    osal_lockstep_set_timeout(scheduler, 2000000U);
    osal_lockstep_expect(scheduler, SECOND, 1U, 0U);
    const pid_t child = deliver_as_second(1U);
    int status        = 0;
    pid_t ended       = 0;
    // Repeat until the signal stops the child inside the scheduler. Elsewhere the stopped child blocks no
    // call, and continues.
    while (ended == 0) {
        TEST_ASSERT_EQUAL(0, kill(child, SIGSTOP));
        uint32_t grants = 0U;
        (void)osal_lockstep_holder(scheduler, &grants);
        TEST_ASSERT_EQUAL(0, kill(child, SIGCONT));
        (void)usleep(100U);
        ended = waitpid(child, &status, WNOHANG);
    }
    TEST_ASSERT_EQUAL(child, ended);
    TEST_ASSERT_TRUE(WIFSIGNALED(status) && (WTERMSIG(status) == SIGKILL));
    osal_lockstep_end(scheduler, SECOND, 1U);
    osal_grant_t grant = {0U, 0U, 0U};
    osal_lockstep_expect(scheduler, SECOND, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_wait(scheduler, SECOND, 2U, 0U, &grant));
}

static void the_scheduler_waits_for_a_participant_without_a_life_number(void)
{
    scheduler = shared_scheduler();
    osal_lockstep_set_timeout(scheduler, 2000000U);
    const pid_t child = deliver_as_second(OSAL_LOCKSTEP_ANY_LIFE);
    // Repeat, so that some of the signals stop the child inside the scheduler.
    for (unsigned i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(0, kill(child, SIGSTOP));
        const pid_t helper = fork();
        if (helper == 0) {
            (void)usleep(20000U);
            _exit(kill(child, SIGCONT));
        }
        uint32_t grants = 0U;
        (void)osal_lockstep_holder(scheduler, &grants);
        TEST_ASSERT_EQUAL(0, ending_of(helper));
    }
    TEST_ASSERT_EQUAL(0, waitpid(child, NULL, WNOHANG));
    TEST_ASSERT_EQUAL(0, kill(child, SIGKILL));
    TEST_ASSERT_TRUE(WIFSIGNALED(ending_of(child)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_dismissed_participant_ends_itself_and_a_killed_one_does_nothing_more);
    RUN_TEST(a_participant_that_returns_to_an_ended_life_is_refused);
    RUN_TEST(a_process_stopped_inside_the_scheduler_is_killed_and_the_others_continue);
    RUN_TEST(the_scheduler_waits_for_a_participant_without_a_life_number);
    return UNITY_END();
}
