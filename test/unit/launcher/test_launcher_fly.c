// SPDX-License-Identifier: Apache-2.0
// How the launcher reacts to the end of a process, to orders of the supervisor, to requests to end the run,
// and to simulated time that stands still. Each wait of the launcher returns after a step of the test.
#include "launcher/launcher_internal.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define S_NS 1000000000ULL
#define SUPERVISOR 0U
#define ARM 1U
#define OPERATOR 2U
#define SIGNAL(n) ((osal_process_result_t){.has_ended = true, .was_signalled = true, .code = (n)})

static launcher_t launcher;
static run_state_t run;
static uint64_t wall_ns;
static uint64_t simulated_ns;
static bool is_paused;

// ---- Mocked functions ----

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return wall_ns;
}

void __wrap_launcher_start_all(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    function_called();
}

status_t __wrap_osal_process_wait_any(osal_process_t* const* processes, size_t count, uint32_t timeout_ms)
{
    assert_non_null(processes);
    check_expected(count);
    check_expected(timeout_ms);
    void (*const step)(void) = (void (*)(void))mock();
    step();
    return STATUS_OK;
}

bool __wrap_launcher_has_ended(const launcher_t* self, child_t* child)
{
    assert_ptr_equal(&launcher, self);
    return child->is_alive && child->result.has_ended;
}

void __wrap_launcher_watch_lives(launcher_t* self)
{
    check_expected_ptr(self);
}

bool __wrap_launcher_is_starved(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return false;
}

const char* __wrap_launcher_holder(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return "the arm";
}

void __wrap_launcher_start_component(launcher_t* self, child_t* child)
{
    assert_ptr_equal(&launcher, self);
    check_expected_ptr(child);
}

status_t __wrap_osal_process_stop(osal_process_t* process, bool by_force)
{
    check_expected_ptr(process);
    check_expected(by_force);
    return STATUS_OK;
}

unsigned __wrap_osal_process_stop_count(void)
{
    return mock_type(unsigned);
}

bool __wrap_osal_console_is_terminal(void)
{
    return false;
}

void __wrap_osal_console_print(const char* text)
{
    check_expected_ptr(text);
}

void __wrap_osal_console_print_line(const char* line)
{
    assert_string_equal("\nshutting the mission down (Ctrl-C twice more ends it at once)", line);
    function_called();
}

uint64_t __wrap_osal_lockstep_now_ns(const osal_lockstep_t* scheduler)
{
    assert_non_null(scheduler);
    return simulated_ns;
}

bool __wrap_osal_lockstep_is_held(const osal_lockstep_t* scheduler)
{
    assert_non_null(scheduler);
    return is_paused;
}

void __wrap_osal_lockstep_hold(osal_lockstep_t* scheduler, bool is_held)
{
    assert_non_null(scheduler);
    assert_false(is_held);
    function_called();
}

unsigned __wrap_osal_lockstep_holder(osal_lockstep_t* scheduler, uint32_t* out_grants)
{
    assert_non_null(scheduler);
    *out_grants = 1U;
    return mock_type(unsigned);
}

osal_lockstep_presence_t __wrap_osal_lockstep_presence(const osal_lockstep_t* scheduler, unsigned participant,
                                                       uint32_t* out_life)
{
    assert_non_null(scheduler);
    assert_true(participant < OSAL_LOCKSTEP_PARTICIPANTS_MAX);
    *out_life = 1U;
    return mock_type(osal_lockstep_presence_t);
}

void __wrap_osal_lockstep_end(osal_lockstep_t* scheduler, unsigned participant, uint32_t life)
{
    assert_non_null(scheduler);
    check_expected(participant);
    check_expected(life);
}

// ---- Steps of the test, each during one wait ----

static void pass_five_seconds(void)
{
    wall_ns += 5U * S_NS;
    simulated_ns += 27U * (S_NS / 10U);
}

static void finish(void)
{
    run.is_finished = 1U;
}

static void pass_a_second(void)
{
    wall_ns += S_NS;
    simulated_ns += S_NS;
}

static void pass_twenty_seconds(void)
{
    wall_ns += 20U * S_NS;
    simulated_ns += S_NS;
}

static void time_stands_still(void)
{
    wall_ns += 20U * S_NS;
}

static void pause_for_an_hour(void)
{
    wall_ns += 3600U * S_NS;
    is_paused = true;
}

static void resume(void)
{
    is_paused = false;
}

static void end_by_itself(void)
{
    launcher.children[ARM].result = SIGNAL(11);
}

static void end_from_outside(void)
{
    launcher.children[ARM].result = SIGNAL(9);
}

static void the_supervisor_ends(void)
{
    launcher.children[SUPERVISOR].result = SIGNAL(6);
}

static void the_operator_ends(void)
{
    launcher.children[OPERATOR].result = (osal_process_result_t){.has_ended = true};
}

static void the_operator_fails(void)
{
    launcher.children[OPERATOR].result = (osal_process_result_t){.has_ended = true, .code = 1};
}

static void order_the_next_life(void)
{
    run.components[ARM].wanted_life = 2U;
}

static void end_as_ordered(void)
{
    launcher.children[ARM].result = (osal_process_result_t){.has_ended = true};
}

static void order_a_kill(void)
{
    run.components[ARM].wanted_life = 2U;
    run.components[ARM].kill_life   = 1U;
}

// ---- Fixture ----

static int set_up(void** state)
{
    static const char* const names[] = {"supervisor", "arm", "operator"};
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    wall_ns                         = 1000U * S_NS;
    is_paused                       = false;
    simulated_ns                    = S_NS;
    launcher.run                    = &run;
    launcher.scheduler              = (osal_lockstep_t*)&run; // The launcher does not read it.
    launcher.options.is_stepped     = true;
    launcher.child_count            = 3U;
    run.component_count             = 2U;
    run.components[ARM].apid        = 16U;
    run.components[SUPERVISOR].apid = 1U;
    for (unsigned i = 0U; i < 3U; i++) {
        launcher.children[i]          = (child_t){.name         = names[i],
                                                  .is_alive     = true,
                                                  .is_component = (i != OPERATOR),
                                                  .component    = (i != OPERATOR) ? i : 0U,
                                                  .participant  = i + 1U,
                                                  .life         = 1U};
        run.components[i].wanted_life = 1U;
    }
    return 0;
}

static void expect_wait(const size_t alive, void (*const step)(void), const unsigned stops)
{
    expect_value(__wrap_osal_process_wait_any, count, alive);
    expect_value(__wrap_osal_process_wait_any, timeout_ms, LAUNCHER_LOOP_MS);
    will_return(__wrap_osal_process_wait_any, (uintptr_t)step);
    expect_value(__wrap_launcher_watch_lives, self, (uintptr_t)&launcher);
    will_return(__wrap_osal_process_stop_count, stops);
}

static void expect_end(const unsigned participant, const uint32_t life)
{
    expect_value(__wrap_osal_lockstep_end, participant, participant);
    expect_value(__wrap_osal_lockstep_end, life, life);
}

static void expect_look(const unsigned holder, const osal_lockstep_presence_t presence)
{
    will_return(__wrap_osal_lockstep_holder, holder);
    will_return(__wrap_osal_lockstep_presence, presence);
}

static void expect_stop(const bool by_force)
{
    expect_value(__wrap_osal_process_stop, process, (uintptr_t)&launcher.children[ARM].process);
    expect_value(__wrap_osal_process_stop, by_force, by_force);
}

static void fly(void)
{
    expect_function_call(__wrap_launcher_start_all);
    launcher_fly(&launcher);
}

// ---- The end of a run ----

static void a_mission_that_has_finished_ends_the_run(void** state)
{
    (void)state;
    expect_wait(3U, pass_a_second, 0U);
    expect_wait(3U, finish, 0U);
    fly();
    assert_int_equal(0, launcher.exit_code);
    assert_false(launcher.is_cut_short);
    assert_int_equal(2U * S_NS, launcher.last_simulated_ns);
    assert_int_equal(1001U * S_NS, launcher.last_wall_ns);
}

/// A line is due after five seconds of wall-clock time, and begins the next interval.
static void progress_is_shown_in_tenths(void** state)
{
    (void)state;
    for (unsigned i = 0U; i < 4U; i++) {
        expect_wait(3U, pass_a_second, 0U);
    }
    expect_wait(3U, pass_five_seconds, 0U);
    expect_wait(3U, pass_five_seconds, 0U);
    expect_wait(3U, finish, 0U);
    expect_string(__wrap_osal_console_print, text, "  7.7 s flown, 0.8 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  10.4 s flown, 0.5 x real time   \n");
    fly();
    assert_int_equal(2U * S_NS, launcher.first_simulated_ns);
    assert_int_equal(1001U * S_NS, launcher.first_wall_ns);
}

static void ctrl_c_asks_the_mission_to_shut_down(void** state)
{
    (void)state;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, pass_a_second, 1U);
    will_return(__wrap_osal_lockstep_presence, OSAL_LOCKSTEP_JOINED);
    expect_function_call(__wrap_osal_lockstep_hold);
    expect_function_call(__wrap_osal_console_print_line);
    expect_wait(3U, finish, 1U);
    launcher_fly(&launcher);
    assert_int_equal(1U, run.is_stop_requested);
    assert_true(launcher.is_cut_short && launcher.is_ended_by_user);
    assert_int_equal(32U * S_NS, launcher.abandon_ns);
    assert_int_equal(0, launcher.exit_code);
}

static void ctrl_c_three_times_ends_the_run_at_once(void** state)
{
    (void)state;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, pass_a_second, 3U);
    will_return(__wrap_osal_lockstep_presence, OSAL_LOCKSTEP_JOINED);
    expect_function_call(__wrap_osal_lockstep_hold);
    launcher_fly(&launcher);
    assert_string_equal("interrupted three times: ended at once", launcher.reason);
}

static void a_duration_asks_the_mission_to_shut_down_once(void** state)
{
    (void)state;
    launcher.options.duration_ns = 2U * S_NS;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, pass_a_second, 0U);
    will_return(__wrap_osal_lockstep_presence, OSAL_LOCKSTEP_EXPECTED);
    expect_function_call(__wrap_osal_lockstep_hold);
    for (unsigned i = 0U; i < 29U; i++) {
        expect_wait(3U, pass_a_second, 0U);
    }
    expect_string(__wrap_osal_console_print, text, "  6.0 s flown, 1.2 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  11.0 s flown, 1.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  16.0 s flown, 1.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  21.0 s flown, 1.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  26.0 s flown, 1.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  31.0 s flown, 1.0 x real time   \n");
    expect_wait(3U, pass_a_second, 0U); // 30 s later the launcher ends the run.
    launcher_fly(&launcher);
    assert_true(launcher.is_ended_by_user);
    assert_string_equal("the mission did not shut down in time and was ended; see console.log",
                        launcher.reason);
}

/// The mission continues for two seconds of simulated time after its operator has left in good order.
static void a_mission_whose_operator_has_left_is_shut_down(void** state)
{
    (void)state;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, the_operator_ends, 0U);
    expect_look(9U, OSAL_LOCKSTEP_ABSENT);
    expect_end(OPERATOR + 1U, OSAL_LOCKSTEP_ANY_LIFE);
    expect_wait(2U, pass_a_second, 0U);
    expect_wait(2U, pass_a_second, 0U);
    expect_wait(2U, pass_a_second, 0U);
    expect_function_call(__wrap_osal_lockstep_hold);
    expect_wait(2U, finish, 0U);
    launcher_fly(&launcher);
    assert_int_equal(1U, run.is_stop_requested);
    assert_true(launcher.is_cut_short);
    assert_false(launcher.is_ended_by_user);
    assert_int_equal(0, launcher.exit_code);
}

static void a_time_that_stands_still_ends_the_run(void** state)
{
    (void)state;
    for (unsigned i = 0U; i < 4U; i++) { // Simulated time is slow, but it advances.
        expect_wait(3U, pass_twenty_seconds, 0U);
    }
    expect_wait(3U, time_stands_still, 0U);
    expect_wait(3U, time_stands_still, 0U);
    expect_string(__wrap_osal_console_print, text, "  2.0 s flown, 0.1 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  3.0 s flown, 0.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  4.0 s flown, 0.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  5.0 s flown, 0.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  5.0 s flown, 0.0 x real time   \n");
    expect_string(__wrap_osal_console_print, text, "  5.0 s flown, 0.0 x real time   \n");
    fly();
    assert_string_equal("simulated time has stopped; the grant is held by the arm; see console.log",
                        launcher.reason);
    assert_int_equal(5U * S_NS, launcher.last_simulated_ns);
}

/// The live port holds simulated time. The time without progress is counted from the end of the pause.
static void a_pause_of_an_hour_does_not_end_the_run(void** state)
{
    (void)state;
    expect_wait(3U, pause_for_an_hour, 0U);
    expect_wait(3U, time_stands_still, 0U);
    expect_wait(3U, resume, 0U);
    expect_wait(3U, time_stands_still, 0U);
    expect_wait(3U, pass_twenty_seconds, 0U);
    expect_wait(3U, finish, 0U);
    for (unsigned i = 0U; i < 3U; i++) {
        expect_string(__wrap_osal_console_print, text, "  1.0 s flown, 0.0 x real time   \n");
    }
    expect_string(__wrap_osal_console_print, text, "  2.0 s flown, 0.0 x real time   \n");
    fly();
    assert_int_equal(0, launcher.exit_code);
    assert_string_equal("", launcher.reason);
}

// ---- Ends of processes ----

static void an_error_of_the_holder_itself_is_at_a_determined_instant(void** state)
{
    (void)state;
    expect_wait(3U, end_by_itself, 0U);
    expect_look(ARM + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(ARM + 1U, 1U);
    expect_wait(2U, finish, 0U);
    fly();
    assert_string_equal("arm was ended by signal 11; see console.log", launcher.reason);
    assert_int_equal(1, launcher.exit_code);
    assert_int_equal(RUN_PROCESS_LOST, run.components[ARM].process);
    assert_false(launcher.is_undetermined);
}

static void the_end_of_a_process_without_the_grant_is_not_at_a_determined_instant(void** state)
{
    (void)state;
    expect_wait(3U, end_by_itself, 0U);
    expect_look(SUPERVISOR + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(ARM + 1U, 1U);
    expect_wait(2U, finish, 0U);
    fly();
    assert_true(launcher.is_undetermined);
}

static void a_signal_from_outside_is_not_at_a_determined_instant(void** state)
{
    (void)state;
    expect_wait(3U, end_from_outside, 0U);
    expect_look(ARM + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(ARM + 1U, 1U);
    expect_wait(2U, finish, 0U);
    fly();
    assert_true(launcher.is_undetermined);
}

static void a_kill_by_the_scenario_is_at_a_determined_instant(void** state)
{
    (void)state;
    expect_wait(3U, end_from_outside, 0U);
    expect_look(9U, OSAL_LOCKSTEP_ABSENT); // The simulator has ended the life, and then killed the process.
    expect_end(ARM + 1U, 1U);
    expect_wait(2U, finish, 0U);
    fly();
    assert_false(launcher.is_undetermined);
}

static void a_supervisor_that_dies_is_started_again(void** state)
{
    (void)state;
    expect_wait(3U, the_supervisor_ends, 0U);
    expect_look(SUPERVISOR + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(SUPERVISOR + 1U, 1U);
    expect_value(__wrap_launcher_start_component, child, (uintptr_t)&launcher.children[SUPERVISOR]);
    expect_wait(2U, finish, 0U);
    fly();
    assert_int_equal(2U, run.components[SUPERVISOR].wanted_life);
    assert_string_equal("supervisor was ended by signal 6 and was restarted; see console.log",
                        launcher.reason);
    assert_false(launcher.is_undetermined);
    assert_int_equal(0U, launcher.abandon_ns);
}

static void a_supervisor_without_the_grant_dies_at_an_undetermined_instant(void** state)
{
    (void)state;
    expect_wait(3U, the_supervisor_ends, 0U);
    expect_look(ARM + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(SUPERVISOR + 1U, 1U);
    expect_value(__wrap_launcher_start_component, child, (uintptr_t)&launcher.children[SUPERVISOR]);
    expect_wait(2U, finish, 0U);
    fly();
    assert_int_equal(2U, run.components[SUPERVISOR].wanted_life);
    assert_true(launcher.is_undetermined);
}

static void an_operator_that_fails_ends_the_mission(void** state)
{
    (void)state;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, the_operator_fails, 0U);
    expect_function_call(__wrap_osal_lockstep_hold);
    expect_look(OPERATOR + 1U, OSAL_LOCKSTEP_JOINED);
    expect_end(OPERATOR + 1U, OSAL_LOCKSTEP_ANY_LIFE);
    expect_wait(2U, finish, 0U);
    launcher_fly(&launcher);
    assert_string_equal("operator ended with exit code 1; see console.log", launcher.reason);
    assert_int_equal(1U, run.is_stop_requested);
    assert_true(launcher.is_undetermined);
}

static void a_duration_does_not_hide_a_script_that_failed_before(void** state)
{
    (void)state;
    launcher.options.duration_ns = 2U * S_NS;
    expect_function_call(__wrap_launcher_start_all);
    expect_wait(3U, pass_a_second, 0U);
    will_return(__wrap_osal_lockstep_presence, OSAL_LOCKSTEP_ABSENT);
    expect_function_call(__wrap_osal_lockstep_hold);
    expect_wait(3U, the_operator_fails, 0U);
    expect_function_call(__wrap_osal_lockstep_hold);
    expect_look(9U, OSAL_LOCKSTEP_ABSENT);
    expect_end(OPERATOR + 1U, OSAL_LOCKSTEP_ANY_LIFE);
    expect_wait(2U, finish, 0U);
    launcher_fly(&launcher);
    assert_string_equal("operator ended with exit code 1; see console.log", launcher.reason);
}

// ---- Orders of the supervisor ----

static void a_life_that_is_over_is_asked_to_end_and_then_killed(void** state)
{
    (void)state;
    // A participant of the scheduler has one second to end by itself, and one more after it was asked to end.
    expect_wait(3U, order_the_next_life, 0U);
    expect_wait(3U, pass_a_second, 0U);
    expect_stop(false);
    expect_wait(3U, pass_a_second, 0U);
    expect_stop(true);
    expect_wait(3U, end_as_ordered, 0U);
    expect_look(9U, OSAL_LOCKSTEP_ABSENT);
    expect_end(ARM + 1U, 1U);
    expect_value(__wrap_launcher_start_component, child, (uintptr_t)&launcher.children[ARM]);
    expect_wait(2U, finish, 0U);
    fly();
    assert_int_equal(RUN_PROCESS_STOPPED, run.components[ARM].process);
    assert_int_equal(0, launcher.exit_code);
}

static void a_life_that_hangs_is_killed_at_once(void** state)
{
    (void)state;
    expect_wait(3U, order_a_kill, 0U);
    expect_stop(true);
    expect_wait(3U, finish, 0U);
    fly();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_mission_that_has_finished_ends_the_run, set_up),
        cmocka_unit_test_setup(progress_is_shown_in_tenths, set_up),
        cmocka_unit_test_setup(ctrl_c_asks_the_mission_to_shut_down, set_up),
        cmocka_unit_test_setup(ctrl_c_three_times_ends_the_run_at_once, set_up),
        cmocka_unit_test_setup(a_duration_asks_the_mission_to_shut_down_once, set_up),
        cmocka_unit_test_setup(a_mission_whose_operator_has_left_is_shut_down, set_up),
        cmocka_unit_test_setup(a_time_that_stands_still_ends_the_run, set_up),
        cmocka_unit_test_setup(a_pause_of_an_hour_does_not_end_the_run, set_up),
        cmocka_unit_test_setup(an_error_of_the_holder_itself_is_at_a_determined_instant, set_up),
        cmocka_unit_test_setup(the_end_of_a_process_without_the_grant_is_not_at_a_determined_instant, set_up),
        cmocka_unit_test_setup(a_signal_from_outside_is_not_at_a_determined_instant, set_up),
        cmocka_unit_test_setup(a_kill_by_the_scenario_is_at_a_determined_instant, set_up),
        cmocka_unit_test_setup(a_supervisor_that_dies_is_started_again, set_up),
        cmocka_unit_test_setup(a_supervisor_without_the_grant_dies_at_an_undetermined_instant, set_up),
        cmocka_unit_test_setup(an_operator_that_fails_ends_the_mission, set_up),
        cmocka_unit_test_setup(a_duration_does_not_hide_a_script_that_failed_before, set_up),
        cmocka_unit_test_setup(a_life_that_is_over_is_asked_to_end_and_then_killed, set_up),
        cmocka_unit_test_setup(a_life_that_hangs_is_killed_at_once, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
