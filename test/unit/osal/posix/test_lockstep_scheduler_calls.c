// SPDX-License-Identifier: Apache-2.0
// Which process the scheduler kills to get its lock: only a participant that holds the lock and that two
// checks in a row find stopped. The lock and the processes are mocked.
#include "osal/posix/lockstep_core.h"
#include "osal/include/osal/lockstep_scheduler.h"

#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/types.h>

#include <cmocka.h>

#define HOLDER 77
#define PATIENCE_NS 1000U

static union {
    osal_lockstep_t scheduler;
    uint8_t octets[OSAL_LOCKSTEP_BYTES];
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
    assert_int_equal(memory.scheduler.patience_ns / 2U, wait_ns);
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
    osal_lockstep_set_patience(&memory.scheduler, PATIENCE_NS);
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

static void a_process_without_a_place_in_the_run_is_never_killed(void** state)
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

static void the_default_patience_is_that_of_the_contract(void** state)
{
    (void)state;
    assert_int_equal(PATIENCE_NS, memory.scheduler.patience_ns);
    will_return(__wrap_osal_mutex_create, STATUS_OK);
    assert_non_null(osal_lockstep_create(&memory, 500U, true));
    assert_int_equal(OSAL_LOCKSTEP_PATIENCE_NS, memory.scheduler.patience_ns);
    lock_and_unlock();
}

static void without_a_robust_lock_there_is_no_scheduler(void** state)
{
    (void)state;
    will_return(__wrap_osal_mutex_create, STATUS_UNSUPPORTED);
    assert_null(osal_lockstep_create(&memory, 500U, true));
    assert_null(osal_lockstep_attach(&memory));
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_holder_that_runs_or_waits_is_not_killed),
        TEST(a_holder_that_is_seen_stopped_twice_is_killed),
        TEST(a_holder_that_continues_in_between_is_not_killed),
        TEST(a_process_without_a_place_in_the_run_is_never_killed),
        TEST(the_default_patience_is_that_of_the_contract),
        TEST(without_a_robust_lock_there_is_no_scheduler),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
