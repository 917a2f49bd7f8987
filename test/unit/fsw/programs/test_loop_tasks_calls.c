// SPDX-License-Identifier: Apache-2.0
// Calls that the tasks of the service loops make: how long each task waits, which priority it requests, and
// that every task is joined even if one of them cannot be started. The system and the component are mocked.
#include "fsw/programs/loop_tasks.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define ORIGIN_NS 5000U
#define NOW_NS 1000000U
/// Longest wait. After it the task checks whether it has a loop and whether it must end.
#define CHECK_NS 20000000U

static subsystem_t component;
static loop_tasks_t tasks;
static void (*entry_of_task)(void* context);

status_t __wrap_osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context, int priority)
{
    loop_task_t* const one = context;
    check_expected_ptr(task);
    assert_ptr_equal(task, &one->task);
    assert_int_equal(0, priority); // A task sets the priority of its loop itself.
    assert_int_equal(OSAL_CLOCK_REAL, one->clock.mode);
    entry_of_task = entry;
    return mock_type(status_t);
}

void __wrap_osal_task_join(osal_task_t* task)
{
    assert_true(tasks.is_over); // Without this flag the wait would not end.
    check_expected_ptr(task);
}

status_t __wrap_osal_task_set_priority(int priority)
{
    check_expected(priority);
    return mock_type(status_t);
}

uint8_t __wrap_subsystem_loop_priority(subsystem_t* subsystem, uint8_t loop)
{
    assert_ptr_equal(&component, subsystem);
    assert_int_equal(1U, loop);
    return mock_type(uint8_t);
}

uint64_t __wrap_subsystem_loop_step(subsystem_t* subsystem, uint8_t loop, uint64_t now_ns)
{
    assert_ptr_equal(&component, subsystem);
    assert_int_equal(1U, loop);
    assert_int_equal(NOW_NS, now_ns);
    return mock_type(uint64_t);
}

uint64_t __wrap_osal_clock_now_ns(const osal_clock_t* clock)
{
    assert_true((clock == &tasks.tasks[0].clock) || (clock == &tasks.tasks[1].clock));
    return NOW_NS;
}

status_t __wrap_osal_clock_wait(osal_clock_t* clock, uint64_t wake_ns, osal_socket_t* const* sockets,
                                size_t count)
{
    assert_ptr_equal(&tasks.tasks[1].clock, clock);
    assert_null(sockets);
    assert_int_equal(0U, count);
    check_expected(wake_ns);
    return mock_type(status_t);
}

void __wrap_osal_console_print_error(const char* text)
{
    check_expected(text);
}

static void expect_start(size_t index, status_t status)
{
    expect_value(__wrap_osal_task_start, task, &tasks.tasks[index].task);
    will_return(__wrap_osal_task_start, status);
}

static void expect_joins(void)
{
    for (size_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        expect_value(__wrap_osal_task_join, task, &tasks.tasks[i].task);
    }
}

static void start(void)
{
    for (size_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        expect_start(i, STATUS_OK);
    }
    assert_int_equal(STATUS_OK, loop_tasks_start(&tasks, &component, ORIGIN_NS));
}

static void every_loop_has_a_task_and_every_task_is_joined(void** state)
{
    (void)state;
    start();
    for (uint8_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        assert_int_equal(i, tasks.tasks[i].loop);
        assert_ptr_equal(&tasks, tasks.tasks[i].all);
    }
    assert_false(tasks.is_over);
    expect_joins();
    loop_tasks_stop(&tasks);
}

static void no_task_is_left_running_if_one_cannot_be_started(void** state)
{
    (void)state;
    for (size_t failing = 0U; failing < SUBSYSTEM_LOOPS; failing++) {
        for (size_t i = 0U; i < failing; i++) {
            expect_start(i, STATUS_OK);
        }
        expect_start(failing, STATUS_EXHAUSTED); // No further task is started.
        expect_joins();
        assert_int_equal(STATUS_EXHAUSTED, loop_tasks_start(&tasks, &component, ORIGIN_NS));
    }
}

/// One round of the task of loop 1.
static void expect_round(uint8_t priority, uint64_t wake_ns, uint64_t expected_ns, status_t status)
{
    will_return(__wrap_subsystem_loop_priority, priority);
    will_return(__wrap_subsystem_loop_step, wake_ns);
    expect_value(__wrap_osal_clock_wait, wake_ns, expected_ns);
    will_return(__wrap_osal_clock_wait, status);
}

static void a_task_waits_until_its_loop_is_due_or_until_it_checks_again(void** state)
{
    (void)state;
    start();
    expect_round(0U, NOW_NS + 1U, NOW_NS + 1U, STATUS_OK);
    expect_round(0U, NOW_NS + CHECK_NS - 1U, NOW_NS + CHECK_NS - 1U, STATUS_OK);
    expect_round(0U, NOW_NS + CHECK_NS + 1U, NOW_NS + CHECK_NS, STATUS_OK);
    expect_round(0U, UINT64_MAX, NOW_NS + CHECK_NS, STATUS_CLOSED); // The clock is closed, so the task ends.
    entry_of_task(&tasks.tasks[1]);
    tasks.is_over = true; // The task must end, so there is no further round.
    entry_of_task(&tasks.tasks[1]);
}

static void expect_priority(uint8_t priority, status_t status)
{
    expect_value(__wrap_osal_task_set_priority, priority, priority);
    will_return(__wrap_osal_task_set_priority, status);
}

static void a_task_asks_for_each_new_priority_once(void** state)
{
    static const char note[] = "loop of services: note: real-time priorities are not permitted here; run as "
                               "root, or raise `ulimit -r`";
    (void)state;
    start();
    expect_round(0U, 0U, 0U, STATUS_OK); // The ordinary priority of the start.
    expect_priority(30U, STATUS_OK);
    expect_round(30U, 0U, 0U, STATUS_OK);
    expect_round(30U, 0U, 0U, STATUS_OK);
    expect_priority(1U, STATUS_DENIED);
    expect_string(__wrap_osal_console_print_error, text, note);
    expect_round(1U, 0U, 0U, STATUS_OK);
    expect_round(1U, 0U, 0U, STATUS_OK);
    expect_priority(0U, STATUS_DENIED); // A task may always give up its priority, so no note is printed.
    expect_round(0U, 0U, 0U, STATUS_CLOSED);
    entry_of_task(&tasks.tasks[1]);
}

/// The watchdog is fed only while every task begins its turns.
static void a_task_that_does_not_begin_its_turn_is_not_alive(void** state)
{
    static const loop_tasks_t none;
    const uint64_t ms       = 1000000U;
    const uint64_t limit_ns = NOW_NS + (LOOP_TASKS_TIMEOUT_MS * ms);
    (void)state;
    assert_true(loop_tasks_are_alive(&none, limit_ns + (10U * ms)));
    start();
    assert_true(loop_tasks_are_alive(&tasks, limit_ns));
    assert_false(loop_tasks_are_alive(&tasks, limit_ns + ms));
    for (size_t hanging = 0U; hanging < SUBSYSTEM_LOOPS; hanging++) {
        for (size_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
            tasks.tasks[i].turn_ms = (i == hanging) ? 1U : 3U;
        }
        assert_false(loop_tasks_are_alive(&tasks, limit_ns + ms));
    }
    for (size_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        tasks.tasks[i].turn_ms = UINT32_MAX - 5U; // The number wraps after 49 days.
    }
    assert_true(loop_tasks_are_alive(&tasks, ((1ULL << 32U) + LOOP_TASKS_TIMEOUT_MS - 6U) * ms));
    assert_false(loop_tasks_are_alive(&tasks, ((1ULL << 32U) + LOOP_TASKS_TIMEOUT_MS - 5U) * ms));
    assert_true(loop_tasks_are_alive(&tasks, (UINT32_MAX - 7ULL) * ms)); // The turn began after the check.
}

/// A task notes the time of each turn.
static void each_turn_is_noted(void** state)
{
    (void)state;
    start();
    tasks.tasks[1].turn_ms = 77U;
    will_return(__wrap_subsystem_loop_priority, 0U);
    will_return(__wrap_subsystem_loop_step, NOW_NS);
    expect_value(__wrap_osal_clock_wait, wake_ns, NOW_NS);
    will_return(__wrap_osal_clock_wait, STATUS_CLOSED);
    entry_of_task(&tasks.tasks[1]);
    assert_int_equal(1U, tasks.tasks[1].turn_ms);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_loop_has_a_task_and_every_task_is_joined),
        cmocka_unit_test(no_task_is_left_running_if_one_cannot_be_started),
        cmocka_unit_test(a_task_waits_until_its_loop_is_due_or_until_it_checks_again),
        cmocka_unit_test(a_task_asks_for_each_new_priority_once),
        cmocka_unit_test(a_task_that_does_not_begin_its_turn_is_not_alive),
        cmocka_unit_test(each_turn_is_noted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
