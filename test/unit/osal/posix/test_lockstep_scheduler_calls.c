// SPDX-License-Identifier: Apache-2.0
// Which process the scheduler kills to get its lock: only a participant that holds the lock and that two
// checks in a row find stopped. If a holder of the lock has died, the next holder completes its work. The
// lock and the processes are mocked.
#define _DEFAULT_SOURCE // MAP_ANONYMOUS
#include "osal/common/lockstep_core.h"
#include "osal/include/osal/lockstep_scheduler.h"

#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#define HOLDER 77
#define TIMEOUT_NS 1000U

static union {
    osal_lockstep_t scheduler;
    uint8_t octets[OSAL_LOCKSTEP_OCTETS];
} memory __attribute__((aligned(64)));

status_t __wrap_osal_mutex_create(osal_mutex_t* mutex, bool is_shared)
{
    (void)mutex;
    assert_true(is_shared);
    return mock_type(status_t);
}

status_t __wrap_osal_mutex_lock_within(osal_mutex_t* mutex, uint64_t wait_ns)
{
    assert_ptr_equal(&memory.scheduler.mutex, mutex);
    assert_int_equal(memory.scheduler.timeout_ns / 2U, wait_ns);
    return mock_type(status_t);
}

void __wrap_osal_mutex_unlock(osal_mutex_t* mutex)
{
    assert_ptr_equal(&memory.scheduler.mutex, mutex);
    function_called();
}

int32_t __wrap_osal_mutex_holder(const osal_mutex_t* mutex)
{
    assert_ptr_equal(&memory.scheduler.mutex, mutex);
    return mock_type(int32_t);
}

char __wrap_osal_process_state(int32_t id)
{
    assert_int_equal(HOLDER, id);
    return mock_type(char);
}

int __wrap_kill(pid_t id, int number)
{
    assert_int_equal(SIGKILL, number);
    check_expected(id);
    return 0;
}

static int set_up(void** state)
{
    (void)state;
    will_return(__wrap_osal_mutex_create, STATUS_OK);
    assert_non_null(osal_lockstep_create(&memory, 500U, true));
    osal_lockstep_set_timeout(&memory.scheduler, TIMEOUT_NS);
    memory.scheduler.participants[OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U].process = HOLDER;
    return 0;
}

static void expect_timeout(const int32_t holder, const char state)
{
    will_return(__wrap_osal_mutex_lock_within, STATUS_TIMEOUT);
    will_return(__wrap_osal_mutex_holder, holder);
    if (state != '\0') {
        will_return(__wrap_osal_process_state, state);
    }
}

/// Make a call that needs the lock and gets it in the end.
static void lock_and_unlock(void)
{
    will_return(__wrap_osal_mutex_lock_within, STATUS_OK);
    expect_function_call(__wrap_osal_mutex_unlock);
    osal_lockstep_set_succession(&memory.scheduler, 0U, 5U);
}

static void a_holder_that_runs_or_waits_is_not_killed(void** state)
{
    (void)state;
    expect_timeout(HOLDER, 'R');
    expect_timeout(HOLDER, 'S');
    expect_timeout(HOLDER, 'S');
    lock_and_unlock();
}

static void a_holder_that_is_seen_stopped_twice_is_killed(void** state)
{
    (void)state;
    expect_timeout(HOLDER, 'T');
    expect_timeout(HOLDER, 'T');
    expect_value(__wrap_kill, id, HOLDER);
    lock_and_unlock();
}

/// A terminal may stop all processes of a run and continue them.
static void a_holder_that_continues_in_between_is_not_killed(void** state)
{
    (void)state;
    expect_timeout(HOLDER, 'T');
    expect_timeout(HOLDER, 'S');
    expect_timeout(HOLDER, 'T');
    lock_and_unlock();
}

static void a_process_without_a_slot_in_the_run_is_never_killed(void** state)
{
    (void)state;
    for (unsigned i = 0U; i < 3U; i++) {
        expect_timeout(HOLDER + 1, '\0');
    }
    for (unsigned i = 0U; i < 3U; i++) {
        expect_timeout(0, '\0'); // No thread holds the lock any more.
    }
    lock_and_unlock();
}

static void the_default_timeout_is_that_of_the_contract(void** state)
{
    (void)state;
    assert_int_equal(TIMEOUT_NS, memory.scheduler.timeout_ns);
    will_return(__wrap_osal_mutex_create, STATUS_OK);
    assert_non_null(osal_lockstep_create(&memory, 500U, true));
    assert_int_equal(OSAL_LOCKSTEP_TIMEOUT_NS, memory.scheduler.timeout_ns);
    lock_and_unlock();
}

static void without_a_robust_lock_there_is_no_scheduler(void** state)
{
    (void)state;
    will_return(__wrap_osal_mutex_create, STATUS_UNSUPPORTED);
    assert_null(osal_lockstep_create(&memory, 500U, true));
    assert_null(osal_lockstep_attach(&memory));
}

/// Make a scheduler at 5000 ns. Participant 0 is in its first life and holds the grant; its next life begins
/// 5 ns after the end of this one. Participant 1 has a stream to it, and participant 2 ends the first life.
static void begin_life(osal_lockstep_t* const scheduler)
{
    participant_t* const first               = &scheduler->participants[0];
    scheduler->now_ns                        = 5000U;
    scheduler->running                       = 0U;
    scheduler->last                          = 0U;
    first->state                             = OSAL_LOCKSTEP_JOINED;
    first->life                              = 1U;
    first->is_begun                          = true;
    first->is_failed                         = true;
    first->succession_ns                     = 5U;
    scheduler->participants[1].state         = OSAL_LOCKSTEP_JOINED;
    scheduler->participants[1].stream_server = 1U;
    scheduler->participants[1].wake_ns       = OSAL_LOCKSTEP_NEVER;
    scheduler->participants[2].state         = OSAL_LOCKSTEP_JOINED;
    scheduler->participants[2].wake_ns       = OSAL_LOCKSTEP_NEVER;
    scheduler->used                          = 3U;
}

static void dismiss(const unsigned participant, const uint32_t life)
{
    will_return(__wrap_osal_mutex_lock_within, STATUS_OK);
    expect_function_call(__wrap_osal_mutex_unlock);
    osal_lockstep_dismiss(&memory.scheduler, participant, life);
}

/// Participant 2 died when the scheduler was in this state. The next holder of the lock ends the first life
/// of participant 0 again, and the launcher ends that of participant 2.
static void check_second_end(const void* const left)
{
    (void)memcpy(&memory, left, sizeof memory);
    lock_and_unlock();
    dismiss(0U, 1U);
    dismiss(2U, OSAL_LOCKSTEP_ANY_LIFE);
    const participant_t* const first = &memory.scheduler.participants[0];
    assert_int_equal(2U, first->life);
    assert_int_equal(OSAL_LOCKSTEP_EXPECTED, first->state);
    assert_int_equal(5005U, first->begin_ns);
    assert_false(first->is_begun || first->is_failed);
    assert_int_not_equal(0U, first->incarnation);
    // The end of its stream woke participant 1.
    assert_int_equal(0U, memory.scheduler.participants[1].stream_server);
    assert_int_equal(1U, memory.scheduler.running);
}

/// Execute lockstep_leave instruction by instruction. Each state of the memory between two instructions is
/// one that a kill may leave.
static void a_kill_at_any_instruction_of_the_end_of_a_life_counts_one_life(void** state)
{
    (void)state;
    void* const shared = mmap(NULL, sizeof memory, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    void* const seen   = malloc(sizeof memory);
    assert_true((shared != MAP_FAILED) && (seen != NULL));
    begin_life(&memory.scheduler);
    (void)memcpy(shared, &memory, sizeof memory);
    const pid_t child = fork();
    if (child == 0) {
        (void)ptrace(PTRACE_TRACEME, 0, NULL, NULL);
        (void)raise(SIGSTOP);
        lockstep_leave(shared, 0U);
        _exit(0);
    }
    (void)memset(seen, 0, sizeof memory);
    unsigned states = 0U;
    int status      = 0;
    assert_int_equal(child, waitpid(child, &status, 0));
    while (WIFSTOPPED(status)) {
        if (memcmp(seen, shared, sizeof memory) != 0) {
            (void)memcpy(seen, shared, sizeof memory);
            check_second_end(seen);
            states++;
        }
        assert_int_equal(0, ptrace(PTRACE_SINGLESTEP, child, NULL, NULL));
        assert_int_equal(child, waitpid(child, &status, 0));
    }
    assert_true(WIFEXITED(status) && (WEXITSTATUS(status) == 0));
    assert_true(states > 10U); // Each field that changes is written by an instruction of its own.
    free(seen);
    (void)munmap(shared, sizeof memory);
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_holder_that_runs_or_waits_is_not_killed),
        TEST(a_holder_that_is_seen_stopped_twice_is_killed),
        TEST(a_holder_that_continues_in_between_is_not_killed),
        TEST(a_process_without_a_slot_in_the_run_is_never_killed),
        TEST(the_default_timeout_is_that_of_the_contract),
        TEST(without_a_robust_lock_there_is_no_scheduler),
        TEST(a_kill_at_any_instruction_of_the_end_of_a_life_counts_one_life),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
