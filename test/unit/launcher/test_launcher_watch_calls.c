// SPDX-License-Identifier: Apache-2.0
// The launcher's watchdog with mocked clock, scheduler and processes: after which time a process counts as
// hanging, and the launcher's reaction. test_launcher_watch.c has the tests with real processes.
#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define NS_PER_MS 1000000ULL
#define NO_PARTICIPANT OSAL_LOCKSTEP_PARTICIPANTS_MAX
#define SUPERVISOR 0U ///< Index of a component, and of its child.
#define ARM 1U
#define SIMULATOR 2U ///< A child that is not a component.
#define LIFE 3U
#define BEGIN_NS 1000000000000ULL

static launcher_t launcher;
static run_state_t run;
static uint64_t scheduler_storage; // Only its address is used.

static uint64_t now_ns;
static osal_process_look_t look; // What osal_process_look finds at every process.
static status_t look_status;
static unsigned holder;
static uint32_t grants;
static unsigned awaited;
static uint64_t simulated_ns;

// ---- Mocked functions ----

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return now_ns;
}

status_t __wrap_osal_process_look(const osal_process_t* process, osal_process_look_t* out_look)
{
    (void)process;
    *out_look = look;
    return look_status;
}

status_t __wrap_osal_process_stop(osal_process_t* process, bool by_force)
{
    assert_true(by_force);
    check_expected_ptr(process);
    return STATUS_OK;
}

status_t __wrap_osal_process_suspend(osal_process_t* process)
{
    check_expected_ptr(process);
    return STATUS_OK;
}

void __wrap_osal_console_print_error(const char* line)
{
    check_expected_ptr(line);
}

unsigned __wrap_osal_lockstep_holder(osal_lockstep_t* scheduler, uint32_t* out_grants)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    *out_grants = grants;
    return holder;
}

unsigned __wrap_osal_lockstep_awaited(const osal_lockstep_t* scheduler)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    return awaited;
}

uint64_t __wrap_osal_lockstep_now_ns(const osal_lockstep_t* scheduler)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    return simulated_ns;
}

osal_lockstep_presence_t __wrap_osal_lockstep_presence(const osal_lockstep_t* scheduler, unsigned participant,
                                                       uint32_t* out_life)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    assert_int_equal(awaited, participant);
    *out_life = LIFE;
    return OSAL_LOCKSTEP_EXPECTED;
}

void __wrap_osal_lockstep_suspend(osal_lockstep_t* scheduler, unsigned participant)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    check_expected(participant);
}

void __wrap_osal_lockstep_postpone(osal_lockstep_t* scheduler, unsigned participant, uint32_t life,
                                   uint64_t at_ns)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    check_expected(participant);
    assert_int_equal(LIFE, life);
    check_expected(at_ns);
}

void __wrap_osal_lockstep_end(osal_lockstep_t* scheduler, unsigned participant, uint32_t life)
{
    assert_ptr_equal(&scheduler_storage, scheduler);
    check_expected(participant);
    assert_int_equal(LIFE, life);
}

// ---- The run: supervisor, arm and simulator; the arm holds the grant ----

static child_t* child(const unsigned index)
{
    return &launcher.children[index];
}

static int set_up(void** state)
{
    static const char* const names[] = {"supervisor", "arm", "simulator"};
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    run.component_count             = 2U;
    run.components[SUPERVISOR].apid = SUPERVISOR_APID;
    run.components[ARM].apid        = SUPERVISOR_APID + 1U;
    launcher.run                    = &run;
    launcher.scheduler              = (osal_lockstep_t*)(void*)&scheduler_storage;
    launcher.options.is_stepped     = true;
    launcher.child_count            = 3U;
    for (unsigned i = 0U; i < 3U; i++) {
        *child(i) = (child_t){.name         = names[i],
                              .is_alive     = true,
                              .is_component = (i != SIMULATOR),
                              .component    = (i != SIMULATOR) ? i : 0U,
                              .participant  = (i != SIMULATOR) ? run_participant(i) : RUN_SIMULATOR,
                              .life         = LIFE,
                              .started_ns   = BEGIN_NS};
    }
    now_ns       = BEGIN_NS;
    look         = (osal_process_look_t){.is_runnable = true, .processor_ns = 7000U};
    look_status  = STATUS_OK;
    holder       = run_participant(ARM);
    grants       = 5U;
    awaited      = NO_PARTICIPANT;
    simulated_ns = 1U;
    return 0;
}

static void watch_at(const uint64_t at_ns)
{
    now_ns = at_ns;
    launcher_watch_lives(&launcher);
}

/// Expect that the arm is suspended after this time without the end of a step.
static void expect_suspension(const uint64_t time_ns)
{
    static char line[160];
    (void)snprintf(
        line, sizeof line,
        "arm hangs: suspended after %llu ms without the end of a step, so that the others continue; "
        "the supervisor kills it",
        (unsigned long long)(time_ns / NS_PER_MS));
    expect_string(__wrap_osal_console_print_error, line, line);
    expect_value(__wrap_osal_process_suspend, process, &child(ARM)->process);
    expect_value(__wrap_osal_lockstep_suspend, participant, run_participant(ARM));
}

static void expect_kill(const unsigned index, const char* const line)
{
    expect_string(__wrap_osal_console_print_error, line, line);
    expect_value(__wrap_osal_process_stop, process, &child(index)->process);
}

// ---- The holder of the grant ----

/// State of the holder, and the time after which it counts as hanging.
typedef struct {
    bool is_stepped;
    bool is_stopped;
    bool is_runnable;
    uint64_t limit_ns;
} hang_t;

static void a_holder_is_suspended_once_its_time_is_used(void** state)
{
    static const hang_t hangs[] = {
        {true, true, false, 5000U * NS_PER_MS},   {true, false, true, 5000U * NS_PER_MS},
        {true, false, false, 20000U * NS_PER_MS}, {false, true, false, 20U * NS_PER_MS},
        {false, false, true, 20U * NS_PER_MS},    {false, false, false, 5000U * NS_PER_MS}};
    for (size_t i = 0U; i < (sizeof hangs / sizeof hangs[0]); i++) {
        const hang_t* const hang = &hangs[i];
        (void)set_up(state);
        launcher.options.is_stepped = hang->is_stepped;
        look.is_stopped             = hang->is_stopped;
        look.is_runnable            = hang->is_runnable;
        watch_at(BEGIN_NS);
        assert_int_equal(BEGIN_NS, launcher.watch.since_ns);
        // For a runnable process, processor time counts.
        look.processor_ns += hang->is_runnable ? (hang->limit_ns - 1U) : 0U;
        run_state_beat(&run, SUPERVISOR, 0U, 1U);
        run_state_beat(&run, ARM, 0U, 1U);
        watch_at(BEGIN_NS + hang->limit_ns - 1U);
        assert_false(launcher.is_undetermined);
        look.processor_ns += hang->is_runnable ? 1U : 0U;
        expect_suspension(hang->limit_ns);
        watch_at(BEGIN_NS + hang->limit_ns);
        assert_true(launcher.is_undetermined);
        assert_int_equal(LIFE, run.components[ARM].hung_life);
        assert_int_equal(0U, launcher.watch.since_ns);
        watch_at(BEGIN_NS + hang->limit_ns + 1U); // The time of the holder starts again.
        assert_int_equal(BEGIN_NS + hang->limit_ns + 1U, launcher.watch.since_ns);
    }
}

/// In a run in real time a mission may declare more than 20 ms for a slow machine, but not less.
static void a_holder_has_the_time_that_its_mission_declares(void** state)
{
    static const struct {
        uint32_t declared_us;
        uint64_t limit_ns;
    } cases[] = {{1000U, 20U * NS_PER_MS}, {20001U, 20001000U}, {60000000U, 60000U * NS_PER_MS}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        (void)set_up(state);
        launcher.options.is_stepped                                   = false;
        launcher.mission.storage.subsystems[ARM].hang_after_us        = cases[i].declared_us;
        launcher.mission.storage.subsystems[SUPERVISOR].hang_after_us = 1U;
        look.is_stopped                                               = true;
        look.is_runnable                                              = false;
        run_state_beat(&run, SUPERVISOR, 0U, 1U);
        run_state_beat(&run, ARM, 0U, 1U);
        watch_at(BEGIN_NS);
        watch_at(BEGIN_NS + cases[i].limit_ns - 1U);
        assert_false(launcher.is_undetermined);
        expect_suspension(cases[i].limit_ns);
        watch_at(BEGIN_NS + cases[i].limit_ns);
        assert_true(launcher.is_undetermined);
    }
}

static void a_supervisor_that_hangs_is_killed(void** state)
{
    (void)state;
    holder          = run_participant(SUPERVISOR);
    look.is_stopped = true;
    watch_at(BEGIN_NS);
    expect_kill(SUPERVISOR, "supervisor hangs: killed after 5000 ms without the end of a step");
    watch_at(BEGIN_NS + (5000U * NS_PER_MS));
    assert_true(launcher.is_undetermined);
    assert_int_equal(0U, run.components[SUPERVISOR].hung_life);
}

static void the_simulator_never_counts_as_hanging(void** state)
{
    (void)state;
    holder          = RUN_SIMULATOR;
    look.is_stopped = true;
    watch_at(BEGIN_NS);
    watch_at(BEGIN_NS + (60000U * NS_PER_MS));
    assert_false(launcher.is_undetermined);
    assert_int_equal(BEGIN_NS, launcher.watch.since_ns);
}

/// The time starts with each grant. The time of a process that is joining continues.
static void each_grant_begins_the_time_of_its_holder(void** state)
{
    (void)state;
    look.is_stopped        = true;
    launcher.watch.join_ns = BEGIN_NS - 77U;
    awaited                = run_participant(SUPERVISOR);
    watch_at(BEGIN_NS);
    assert_int_equal(BEGIN_NS - 77U, launcher.watch.join_ns);
    grants++;
    awaited = NO_PARTICIPANT;
    watch_at(BEGIN_NS + (4000U * NS_PER_MS));
    assert_int_equal(BEGIN_NS + (4000U * NS_PER_MS), launcher.watch.since_ns);
    assert_int_equal(grants, launcher.watch.grants);
    assert_int_equal(7000U, launcher.watch.processor_ns);
    holder = run_participant(SUPERVISOR);
    watch_at(BEGIN_NS + (8000U * NS_PER_MS));
    assert_int_equal(holder, launcher.watch.holder);
    assert_string_equal("supervisor", launcher_holder(&launcher));
    holder = NO_PARTICIPANT;
    watch_at(BEGIN_NS + (16000U * NS_PER_MS));
    assert_int_equal(0U, launcher.watch.since_ns);
    assert_string_equal("no process", launcher_holder(&launcher));
    holder = run_participant(ARM);
    watch_at(1U); // The earliest instant: since_ns 0 means that there is no holder.
    assert_string_equal("arm", launcher_holder(&launcher));
    look_status = STATUS_NOT_FOUND; // The process has ended.
    watch_at(BEGIN_NS);
    assert_string_equal("no process", launcher_holder(&launcher));
    assert_false(launcher.is_undetermined);
}

static void a_child_that_has_ended_is_not_the_holder(void** state)
{
    (void)state;
    child(ARM)->is_alive = false;
    look.is_stopped      = true;
    watch_at(BEGIN_NS);
    watch_at(BEGIN_NS + (60000U * NS_PER_MS));
    assert_int_equal(0U, launcher.watch.since_ns);
    launcher.child_count = 1U; // The launcher does not read the entry after the last child.
    child(ARM)->is_alive = true;
    watch_at(BEGIN_NS);
    assert_int_equal(0U, launcher.watch.since_ns);
    assert_string_equal("no process", launcher_holder(&launcher));
}

// ---- Processes that join ----

static void a_process_that_does_not_join_is_killed_after_ten_seconds(void** state)
{
    (void)state;
    holder  = NO_PARTICIPANT;
    awaited = run_participant(ARM);
    watch_at(BEGIN_NS);
    assert_int_equal(BEGIN_NS, launcher.watch.join_ns);
    watch_at(BEGIN_NS + (10000U * NS_PER_MS) - 1U);
    assert_false(launcher.is_undetermined);
    expect_kill(ARM, "arm has not joined the run within 10 s: killed");
    expect_value(__wrap_osal_lockstep_end, participant, run_participant(ARM));
    watch_at(BEGIN_NS + (10000U * NS_PER_MS));
    assert_true(launcher.is_undetermined);
    assert_int_equal(0U, launcher.watch.join_ns);
    child(ARM)->is_alive = false; // The child has died meanwhile: the watchdog only ends its life.
    watch_at(BEGIN_NS);
    expect_value(__wrap_osal_lockstep_end, participant, run_participant(ARM));
    watch_at(BEGIN_NS + (10000U * NS_PER_MS));
}

static void the_time_to_join_ends_with_the_wait_and_does_not_begin_before_the_run(void** state)
{
    (void)state;
    holder       = NO_PARTICIPANT;
    awaited      = run_participant(ARM);
    simulated_ns = 0U; // At time 0 all programs are starting.
    watch_at(BEGIN_NS);
    assert_int_equal(0U, launcher.watch.join_ns);
    simulated_ns = 1U;
    watch_at(BEGIN_NS);
    awaited = NO_PARTICIPANT;
    watch_at(BEGIN_NS + 1U);
    assert_int_equal(0U, launcher.watch.join_ns);
}

/// In real time the scheduler does not wait for a process.
static void in_real_time_the_beginning_of_a_life_is_postponed(void** state)
{
    (void)state;
    run_state_beat(&run, ARM, 0U, 1U);
    run_state_beat(&run, SUPERVISOR, 0U, 1U);
    launcher.options.is_stepped = false;
    holder                      = NO_PARTICIPANT;
    awaited                     = run_participant(ARM);
    simulated_ns                = 123U;
    expect_value(__wrap_osal_lockstep_postpone, participant, run_participant(ARM));
    expect_value(__wrap_osal_lockstep_postpone, at_ns, 123U + (20U * NS_PER_MS));
    watch_at(BEGIN_NS);
    assert_int_equal(0U, launcher.watch.join_ns);
}

// ---- Processes with clocks of their own ----

static void free_running(void)
{
    launcher.scheduler          = NULL;
    launcher.options.is_stepped = false;
    run_state_beat(&run, SUPERVISOR, 0U, 1U);
    run_state_beat(&run, ARM, 0U, 1U);
}

static void a_restarted_process_that_makes_no_step_is_killed_after_ten_seconds(void** state)
{
    const uint64_t end_ns = BEGIN_NS + (10000U * NS_PER_MS);
    (void)state;
    free_running();
    look_status = STATUS_NOT_FOUND; // This test does not watch the supervisor.
    for (unsigned i = 0U; i < 2U; i++) {
        run_state_beat(&run, i, 0U, OSAL_LOCKSTEP_NEVER);
        child(i)->life = 1U; // All first lives of a run start together.
    }
    watch_at(end_ns);
    child(SUPERVISOR)->life = 2U; // Test the first of the children, too.
    watch_at(end_ns - 1U);
    expect_kill(SUPERVISOR, "supervisor has not made a step within 10 s: killed");
    watch_at(end_ns);
    assert_int_equal(end_ns, child(SUPERVISOR)->started_ns);
    watch_at(end_ns + 1U); // The process is ending; it is not killed again.
    child(SUPERVISOR)->life = 1U;
    child(ARM)->life        = 2U;
    child(ARM)->is_alive    = false;
    watch_at(end_ns);
    child(ARM)->is_alive     = true;
    child(ARM)->is_component = false;
    watch_at(end_ns);
    child(ARM)->is_component = true;
    launcher.child_count     = 1U;
    watch_at(end_ns);
    launcher.child_count        = 2U;
    launcher.options.is_stepped = true; // With stepped time the scheduler waits for the process.
    watch_at(end_ns);
}

static void a_free_running_supervisor_that_makes_no_step_is_killed(void** state)
{
    static const struct {
        bool is_stopped;
        uint64_t used_ns;
        uint64_t after_ns;
        const char* line;
    } cases[] = {
        {true, 0U, 200U * NS_PER_MS, "supervisor hangs: killed after 200 ms without the end of a step"},
        {false, 200U * NS_PER_MS, 1U, "supervisor hangs: killed after 0 ms without the end of a step"}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        (void)set_up(state);
        free_running();
        look.is_stopped  = cases[i].is_stopped;
        look.is_runnable = !cases[i].is_stopped;
        watch_at(BEGIN_NS);
        assert_int_equal(BEGIN_NS, launcher.watch.since_ns);
        watch_at(BEGIN_NS + cases[i].after_ns - 1U);
        look.processor_ns += cases[i].used_ns;
        expect_kill(SUPERVISOR, cases[i].line);
        watch_at(BEGIN_NS + cases[i].after_ns);
        assert_true(launcher.is_undetermined);
        assert_int_equal(0U, launcher.watch.since_ns);
    }
}

/// A step restarts the time; a process that waits for its disk does not count as hanging.
static void a_free_running_supervisor_that_steps_or_waits_is_not_killed(void** state)
{
    (void)state;
    free_running();
    look.is_stopped = true;
    watch_at(BEGIN_NS);
    run_state_beat(&run, SUPERVISOR, 9U, 10U);
    watch_at(BEGIN_NS + (200U * NS_PER_MS));
    assert_int_equal(BEGIN_NS + (200U * NS_PER_MS), launcher.watch.since_ns);
    assert_int_equal(9U, launcher.watch.step_ns);
    look.is_stopped  = false;
    look.is_runnable = false;
    watch_at(BEGIN_NS + (60000U * NS_PER_MS));
    assert_int_equal(BEGIN_NS + (200U * NS_PER_MS), launcher.watch.since_ns);
    look_status = STATUS_NOT_FOUND;
    watch_at(BEGIN_NS + (60000U * NS_PER_MS));
    assert_int_equal(0U, launcher.watch.since_ns);
    look_status = STATUS_OK;
    watch_at(BEGIN_NS);
    run_state_beat(&run, SUPERVISOR, 9U, OSAL_LOCKSTEP_NEVER); // The next life has not made a step yet.
    watch_at(BEGIN_NS);
    assert_int_equal(0U, launcher.watch.since_ns);
    run_state_beat(&run, SUPERVISOR, 9U, 10U);
    watch_at(BEGIN_NS);
    run.components[SUPERVISOR].apid = SUPERVISOR_APID + 2U; // A mission without supervisor.
    watch_at(BEGIN_NS);
    assert_int_equal(0U, launcher.watch.since_ns);
    assert_false(launcher.is_undetermined);
}

static void the_image_is_not_watched(void** state)
{
    (void)state;
    launcher.options.is_image = true;
    look.is_stopped           = true;
    watch_at(BEGIN_NS);
    watch_at(BEGIN_NS + (60000U * NS_PER_MS));
    assert_int_equal(0U, launcher.watch.since_ns);
}

static void a_holder_that_has_computed_for_five_seconds_is_not_starved(void** state)
{
    (void)state;
    launcher.watch    = (launcher_watch_t){.holder = run_participant(ARM), .since_ns = 1U};
    look.processor_ns = (5000U * NS_PER_MS) - 1U;
    assert_true(launcher_is_starved(&launcher));
    look.processor_ns++;
    assert_false(launcher_is_starved(&launcher));
    look.processor_ns = 0U;
    look_status       = STATUS_NOT_FOUND;
    assert_false(launcher_is_starved(&launcher));
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_holder_is_suspended_once_its_time_is_used),
        TEST(a_holder_has_the_time_that_its_mission_declares),
        TEST(a_supervisor_that_hangs_is_killed),
        TEST(the_simulator_never_counts_as_hanging),
        TEST(each_grant_begins_the_time_of_its_holder),
        TEST(a_child_that_has_ended_is_not_the_holder),
        TEST(a_process_that_does_not_join_is_killed_after_ten_seconds),
        TEST(the_time_to_join_ends_with_the_wait_and_does_not_begin_before_the_run),
        TEST(in_real_time_the_beginning_of_a_life_is_postponed),
        TEST(a_restarted_process_that_makes_no_step_is_killed_after_ten_seconds),
        TEST(a_free_running_supervisor_that_makes_no_step_is_killed),
        TEST(a_free_running_supervisor_that_steps_or_waits_is_not_killed),
        TEST(the_image_is_not_watched),
        TEST(a_holder_that_has_computed_for_five_seconds_is_not_starved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
