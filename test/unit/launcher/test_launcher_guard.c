// SPDX-License-Identifier: Apache-2.0
// The guard of a run: it is started again if it is killed, and cleans up after a launcher that was
// killed. Processes and the run state are mocked.
#include "launcher/launcher_guard.h"

#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define S_NS 1000000000ULL

static launcher_t launcher;
static run_state_t run;
static guard_t guard;
static uint64_t wall_ns;
static const launch_options_t options;

// ---- Mocked functions ----

status_t __wrap_osal_process_start(osal_process_t* process, const osal_process_start_t* start)
{
    char words[128];
    text_t text = text_in(words, sizeof words);
    assert_ptr_equal(&guard.process, process);
    assert_true(start->outlives);
    assert_int_equal(-1, start->processor);
    for (size_t i = 0U; start->arguments[i] != NULL; i++) {
        text_add(&text, (i > 0U) ? " " : "");
        text_add(&text, start->arguments[i]);
    }
    check_expected_ptr(words);
    return mock_type(status_t);
}

int32_t __wrap_osal_process_own_id(void)
{
    return 9;
}

status_t __wrap_osal_process_poll(osal_process_t* process, osal_process_result_t* out_result)
{
    assert_ptr_equal(&guard.process, process);
    *out_result = (osal_process_result_t){.has_ended = mock_type(bool)};
    return mock_type(status_t);
}

status_t __wrap_osal_process_stop(osal_process_t* process, bool by_force)
{
    assert_ptr_equal(&guard.process, process);
    assert_true(by_force);
    function_called();
    return STATUS_OK;
}

void __wrap_osal_console_print_error(const char* line)
{
    check_expected_ptr(line);
}

status_t __wrap_osal_process_watch(osal_process_t* process, int32_t id)
{
    assert_int_equal(-1, process->descriptor);
    check_expected(id);
    process->descriptor = 77;
    return mock_type(status_t);
}

status_t __wrap_osal_process_wait_any(osal_process_t* const* processes, size_t count, uint32_t timeout_ms)
{
    assert_non_null(processes[0]);
    assert_int_equal(1U, count);
    wall_ns += (uint64_t)timeout_ms * 1000000U;
    return STATUS_TIMEOUT;
}

bool __wrap_osal_process_is_alive(const osal_process_t* process)
{
    assert_int_equal(77, process->descriptor);
    return mock_type(bool);
}

void __wrap_osal_process_release(osal_process_t* process)
{
    process->descriptor = -1;
    function_called();
}

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return wall_ns;
}

status_t __wrap_run_state_attach(osal_shm_t* shm, const char* name, run_state_t** out_block)
{
    assert_non_null(shm);
    assert_string_equal("/hirosco-55.run", name);
    *out_block = &run;
    return mock_type(status_t);
}

void __wrap_launcher_take_over(launcher_t* self, const launch_options_t* how, const char* program_directory,
                               run_state_t* of)
{
    assert_ptr_equal(&launcher, self);
    assert_ptr_equal(&options, how);
    assert_string_equal("bin/", program_directory);
    check_expected_ptr(of);
}

void __wrap_launcher_clean_up(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    function_called();
}

void __wrap_launcher_remove_all(const char* identity)
{
    assert_string_equal("hirosco-55", identity);
    function_called();
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    (void)memset(&guard, 0, sizeof guard);
    wall_ns = S_NS;
    return 0;
}

// ---- The launcher's side ----

static void expect_start(const status_t status)
{
    expect_string(__wrap_osal_process_start, words, "hirosco guard hirosco-9 --mission rokviss");
    will_return(__wrap_osal_process_start, status);
}

static void expect_poll(const bool has_ended, const status_t status)
{
    will_return(__wrap_osal_process_poll, has_ended);
    will_return(__wrap_osal_process_poll, status);
}

static void a_guard_that_was_killed_is_started_again(void** state)
{
    static char word[]               = "--mission";
    static char value[]              = "rokviss";
    char* const options_of_the_run[] = {word, value};
    (void)state;
    expect_start(STATUS_OK);
    guard_start(&guard, "hirosco", 2, options_of_the_run);
    assert_int_equal(1U, guard.starts);
    expect_poll(false, STATUS_OK);
    guard_keep(&guard);
    expect_poll(true, STATUS_IO);
    guard_keep(&guard);
    assert_int_equal(1U, guard.starts);
    expect_poll(true, STATUS_OK);
    expect_string(__wrap_osal_console_print_error, line,
                  "hirosco: the guard of the run was killed; another one is started");
    expect_start(STATUS_OK);
    guard_keep(&guard);
    assert_int_equal(2U, guard.starts);
    expect_function_call(__wrap_osal_process_stop);
    expect_poll(false, STATUS_OK);
    expect_poll(true, STATUS_OK);
    guard_stop(&guard);
}

static void a_run_without_a_guard_is_reported(void** state)
{
    static char word[] = "x";
    char* many[GUARD_ARGUMENTS_MAX];
    (void)state;
    for (unsigned i = 0U; i < GUARD_ARGUMENTS_MAX; i++) {
        many[i] = word;
    }
    expect_any(__wrap_osal_console_print_error, line);
    guard_start(&guard, "hirosco", (int)GUARD_ARGUMENTS_MAX, many); // More options than there is room for.
    assert_int_equal(0U, guard.starts);
    expect_any(__wrap_osal_process_start, words);
    will_return(__wrap_osal_process_start, STATUS_NOT_FOUND);
    expect_any(__wrap_osal_console_print_error, line);
    guard_start(&guard, "hirosco", 1, many);
    assert_int_equal(0U, guard.starts);
}

// ---- The guard itself ----

static void expect_watch(const int32_t id, const status_t status)
{
    expect_value(__wrap_osal_process_watch, id, id);
    will_return(__wrap_osal_process_watch, status);
}

static void expect_clean_up(run_state_t* const of)
{
    expect_value(__wrap_launcher_take_over, of, (uintptr_t)of);
    expect_function_call(__wrap_launcher_clean_up);
    expect_function_call(__wrap_launcher_remove_all);
}

static void a_launcher_that_has_cleaned_up_needs_no_guard(void** state)
{
    (void)state;
    run.is_cleaned_up = 1U;
    expect_watch(55, STATUS_OK);
    will_return(__wrap_run_state_attach, STATUS_NOT_FOUND); // The launcher has not created it yet.
    will_return(__wrap_osal_process_is_alive, true);
    will_return(__wrap_run_state_attach, STATUS_OK);
    will_return(__wrap_osal_process_is_alive, true);
    will_return(__wrap_osal_process_is_alive, false);
    expect_function_call(__wrap_osal_process_release);
    assert_int_equal(0, guard_watch(&launcher, &options, "bin/", "hirosco-55"));
}

/// The children of the launcher are killed with it; the guard waits for their end and then cleans up.
static void a_launcher_that_was_killed_is_cleaned_up_after(void** state)
{
    (void)state;
    run.processes[3] = 303;
    run.processes[5] = 505;
    expect_watch(55, STATUS_NOT_FOUND);
    will_return(__wrap_run_state_attach, STATUS_OK);
    expect_function_call(__wrap_osal_process_release);
    for (unsigned i = 0U; i < RUN_PROCESSES_MAX; i++) {
        if (i == 3U) {
            expect_watch(303, STATUS_OK);
            will_return(__wrap_osal_process_is_alive, true);
            will_return(__wrap_osal_process_is_alive, false);
        } else if (i == 5U) {
            expect_watch(505, STATUS_NOT_FOUND); // The process has already ended.
        } else {
            // The guard skips entries without a process.
        }
        expect_function_call(__wrap_osal_process_release);
    }
    expect_clean_up(&run);
    assert_int_equal(1, guard_watch(&launcher, &options, "bin/", "hirosco-55"));
    assert_int_equal(S_NS + 40000000ULL, wall_ns);
}

static void a_child_that_does_not_end_is_waited_for_thirty_seconds(void** state)
{
    (void)state;
    run.processes[0] = 303;
    expect_watch(55, STATUS_NOT_FOUND);
    will_return(__wrap_run_state_attach, STATUS_OK);
    expect_function_call(__wrap_osal_process_release);
    expect_watch(303, STATUS_OK);
    will_return_count(__wrap_osal_process_is_alive, true, 1500); // 30 s in waits of 20 ms.
    expect_function_calls(__wrap_osal_process_release, RUN_PROCESSES_MAX);
    expect_clean_up(&run);
    assert_int_equal(1, guard_watch(&launcher, &options, "bin/", "hirosco-55"));
    assert_int_equal(31U * S_NS, wall_ns);
}

static void a_launcher_that_was_killed_before_its_run_was_made_is_cleaned_up_after(void** state)
{
    (void)state;
    expect_watch(55, STATUS_NOT_FOUND);
    will_return_count(__wrap_run_state_attach, STATUS_NOT_FOUND, 2);
    expect_function_call(__wrap_osal_process_release);
    expect_clean_up(NULL);
    assert_int_equal(1, guard_watch(&launcher, &options, "bin/", "hirosco-55"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_guard_that_was_killed_is_started_again, set_up),
        cmocka_unit_test_setup(a_run_without_a_guard_is_reported, set_up),
        cmocka_unit_test_setup(a_launcher_that_has_cleaned_up_needs_no_guard, set_up),
        cmocka_unit_test_setup(a_launcher_that_was_killed_is_cleaned_up_after, set_up),
        cmocka_unit_test_setup(a_child_that_does_not_end_is_waited_for_thirty_seconds, set_up),
        cmocka_unit_test_setup(a_launcher_that_was_killed_before_its_run_was_made_is_cleaned_up_after,
                               set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
