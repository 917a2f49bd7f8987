// SPDX-License-Identifier: Apache-2.0
// The names of a run that are removed at its end, tools that run to their end, and what a guard takes over
// from a launcher that was killed. Processes, memories and interfaces are mocked.
#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static launcher_t launcher;
static run_state_t run;
static const char* const arguments_of_a_tool[] = {"tool", NULL};

status_t __wrap_osal_shm_each(const char* prefix, void (*visit)(void* context, const char* name),
                              void* context)
{
    check_expected_ptr(prefix);
    const char* const name = mock_ptr_type(const char*);
    visit(context, name);
    return STATUS_OK;
}

status_t __wrap_osal_shm_remove(const char* name)
{
    check_expected_ptr(name);
    return STATUS_OK;
}

void __wrap_launcher_remove_computers(const char* identity)
{
    check_expected_ptr(identity);
}

status_t __wrap_osal_process_watch(osal_process_t* process, int32_t id)
{
    assert_int_equal(-1, process->descriptor);
    check_expected(id);
    return mock_type(status_t);
}

/// The mock value says whether the tool was started.
void __wrap_launcher_start_child(launcher_t* self, child_t* child, const arguments_t* arguments,
                                 const int* descriptors, size_t descriptor_count)
{
    const char* const name = child->name;
    assert_ptr_equal(&launcher, self);
    assert_non_null(arguments->list[0]);
    check_expected_ptr(name);
    assert_null(descriptors);
    assert_int_equal(0U, descriptor_count);
    child->is_alive = mock_type(bool);
    child->has_run  = child->is_alive;
}

status_t __wrap_osal_process_wait_any(osal_process_t* const* processes, size_t count, uint32_t timeout_ms)
{
    assert_non_null(processes[0]);
    assert_int_equal(1U, count);
    assert_true(timeout_ms > 0U);
    function_called();
    return STATUS_OK;
}

status_t __wrap_osal_process_poll(osal_process_t* process, osal_process_result_t* out_result)
{
    assert_non_null(process);
    *out_result = *mock_ptr_type(const osal_process_result_t*);
    return mock_type(status_t);
}

void __wrap_launcher_adopt_interfaces(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    assert_string_equal("udp", self->options.transport); // The method of the mission.
    function_called();
}

status_t __wrap_osal_shm_open(osal_shm_t* shm, const char* name)
{
    assert_ptr_equal(&launcher.scheduler_shm, shm);
    check_expected_ptr(name);
    return mock_type(status_t);
}

void* __wrap_osal_shm_address(const osal_shm_t* shm)
{
    assert_ptr_equal(&launcher.scheduler_shm, shm);
    return &run;
}

osal_lockstep_t* __wrap_osal_lockstep_attach(void* memory)
{
    assert_ptr_equal(&run, memory);
    return mock_ptr_type(osal_lockstep_t*);
}

uint64_t __wrap_osal_lockstep_now_ns(const osal_lockstep_t* scheduler)
{
    assert_non_null(scheduler);
    return mock_type(uint64_t);
}

bool __wrap_run_summary_write(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    function_called();
    return true;
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    launcher.run               = &run;
    launcher.program_directory = "bin/";
    (void)strcpy(run.identity, "hirosco-9");
    return 0;
}

static void every_memory_of_an_identity_is_removed(void** state)
{
    (void)state;
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-9.");
    will_return(__wrap_osal_shm_each, "/hirosco-9.run");
    expect_string(__wrap_osal_shm_remove, name, "/hirosco-9.run");
    expect_string(__wrap_launcher_remove_computers, identity, "hirosco-9");
    launcher_remove_all("hirosco-9");
}

// ---- Tools ----

static bool run_tool(const bool has_started)
{
    const arguments_t arguments = {.list = {arguments_of_a_tool[0]}, .count = 1U};
    expect_string(__wrap_launcher_start_child, name, "the tool");
    will_return(__wrap_launcher_start_child, has_started);
    return launcher_run_tool(&launcher, &arguments, "the tool");
}

static void expect_poll(const osal_process_result_t* const result, const status_t status)
{
    expect_function_call(__wrap_osal_process_wait_any);
    will_return(__wrap_osal_process_poll, result);
    will_return(__wrap_osal_process_poll, status);
}

static void a_tool_is_awaited_and_has_succeeded_with_code_0_only(void** state)
{
    static const osal_process_result_t runs   = {.code = 5};
    static const osal_process_result_t good   = {.has_ended = true};
    static const osal_process_result_t failed = {.has_ended = true, .code = 3};
    static const osal_process_result_t killed = {.has_ended = true, .was_signalled = true, .code = 0};
    (void)state;
    expect_poll(&runs, STATUS_OK);
    expect_poll(&good, STATUS_IO); // The result is not valid; the launcher polls again.
    expect_poll(&good, STATUS_OK);
    assert_true(run_tool(true));
    assert_int_equal(0, launcher.tool_code);
    expect_poll(&failed, STATUS_OK);
    assert_false(run_tool(true));
    assert_int_equal(3, launcher.tool_code);
    expect_poll(&killed, STATUS_OK);
    assert_false(run_tool(true));
    assert_false(run_tool(false));
}

// ---- The whole end of a run ----

static void expect_tool(const char* const name, const osal_process_result_t* const result)
{
    expect_string(__wrap_launcher_start_child, name, name);
    will_return(__wrap_launcher_start_child, true);
    expect_poll(result, STATUS_OK);
}

static void expect_removal(const char* const what, const unsigned number)
{
    static char names[RUN_LINKS_MAX + 3U][RUN_NAME_MAX];
    static size_t count = 0U;
    char* const name    = names[count % (RUN_LINKS_MAX + 3U)];
    count++;
    assert_true(run_name(&run, what, number, name, RUN_NAME_MAX));
    expect_string(__wrap_osal_shm_remove, name, name);
}

/// Names that killed programs have left are removed, and so are the names of the run itself.
static void expect_names_removed(void)
{
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-9.remote");
    will_return(__wrap_osal_shm_each, "/hirosco-9.remote7");
    expect_string(__wrap_osal_shm_remove, name, "/hirosco-9.remote7");
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-9.flow");
    will_return(__wrap_osal_shm_each, "/hirosco-9.flow3");
    expect_string(__wrap_osal_shm_remove, name, "/hirosco-9.flow3");
    for (unsigned link = 1U; link <= RUN_LINKS_MAX; link++) {
        expect_removal("link", link);
    }
    expect_removal("scheduler", 0U);
    expect_removal("checkpoint", 0U);
    expect_removal("run", 0U);
    expect_string(__wrap_launcher_remove_computers, identity, "hirosco-9");
}

/// The logs are merged before run.json is written; the report, if the options request one, is made from both.
static void a_report_is_made_only_if_asked_for(void** state)
{
    static const osal_process_result_t good = {.has_ended = true};
    (void)state;
    launcher.child_count       = 1U; // The child has ended.
    launcher.ground.descriptor = -1;
    for (unsigned i = 0U; i < 2U; i++) {
        launcher.options.has_report = (i == 1U);
        run.is_cleaned_up           = 0U;
        expect_names_removed();
        expect_tool("packet-archive-sqlite", &good);
        expect_function_call(__wrap_run_summary_write);
        if (launcher.options.has_report) {
            expect_tool("report", &good);
        }
        launcher_clean_up(&launcher);
        assert_int_equal(1U, run.is_cleaned_up);
        assert_int_equal(0, launcher.exit_code);
    }
}

/// The simulator is a process of its own and notes its losses in the scheduler.
static void a_loss_in_the_scheduler_is_a_loss_of_the_run(void** state)
{
    static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
    static const osal_process_result_t good = {.has_ended = true};
    (void)state;
    launcher.child_count       = 1U;
    launcher.ground.descriptor = -1;
    launcher.scheduler         = osal_lockstep_create(storage, 1U, true);
    for (uint32_t losses = 0U; losses < 2U; losses++) {
        if (losses > 0U) {
            osal_lockstep_note_loss(launcher.scheduler);
        }
        expect_names_removed();
        expect_tool("packet-archive-sqlite", &good);
        expect_function_call(__wrap_run_summary_write);
        launcher_clean_up(&launcher);
        assert_int_equal(losses, run.is_lossy);
    }
}

/// The exit code of the report program says whether the figures are within their bounds.
static void figures_that_fail_are_the_result_of_the_run(void** state)
{
    static const osal_process_result_t good   = {.has_ended = true};
    static const osal_process_result_t failed = {.has_ended = true, .code = 3};
    (void)state;
    launcher.child_count        = 1U;
    launcher.ground.descriptor  = -1;
    launcher.options.has_report = true;
    expect_names_removed();
    expect_tool("packet-archive-sqlite", &good);
    expect_function_call(__wrap_run_summary_write);
    expect_tool("report", &failed);
    launcher_clean_up(&launcher);
    assert_int_equal(1, launcher.exit_code);
    assert_string_equal("figures missing or out of their bounds; see report.html and run.json",
                        launcher.reason);
}

// ---- Guard ----

static const launch_options_t options = {.mission = "rokviss", .transport = "", .links = "", .computers = 1U};

static void a_guard_takes_over_without_a_prepared_run(void** state)
{
    (void)state;
    expect_function_call(__wrap_launcher_adopt_interfaces);
    launcher_take_over(&launcher, &options, "bin/", NULL);
    assert_null(launcher.run);
    assert_true(launcher.is_taken_over && launcher.is_undetermined && launcher.is_broken);
    assert_string_equal("the launcher was killed, and all other processes of the run with it",
                        launcher.reason);
    assert_int_equal(1, launcher.exit_code);
    assert_string_equal("", launcher.cosimulation);
    assert_int_equal(-1, launcher.ground.descriptor);
}

static void the_guard_has_the_time_of_the_scheduler(void** state)
{
    (void)state;
    run.is_stepped = true;
    expect_function_call(__wrap_launcher_adopt_interfaces);
    expect_string(__wrap_osal_shm_open, name, "/hirosco-9.scheduler");
    will_return(__wrap_osal_shm_open, STATUS_OK);
    will_return(__wrap_osal_lockstep_attach, &run);
    will_return(__wrap_osal_lockstep_now_ns, 12345U);
    launch_options_t stepped = options;
    stepped.is_stepped       = true;
    launcher_take_over(&launcher, &stepped, "bin/", &run);
    assert_ptr_equal(&run, launcher.run);
    assert_ptr_equal(&run, launcher.scheduler);
    assert_int_equal(12345U, launcher.last_simulated_ns);
    assert_string_equal("/dev/shm/hirosco-9.cosim", launcher.cosimulation);
}

static void a_scheduler_that_no_longer_exists_is_not_used(void** state)
{
    (void)state;
    run.is_stepped = true;
    run.origin_ns  = UINT64_MAX;
    expect_function_call(__wrap_launcher_adopt_interfaces);
    expect_string(__wrap_osal_shm_open, name, "/hirosco-9.scheduler");
    will_return(__wrap_osal_shm_open, STATUS_NOT_FOUND);
    launcher_take_over(&launcher, &options, "bin/", &run);
    assert_null(launcher.scheduler);
    assert_int_equal(0U, launcher.last_simulated_ns);
}

/// The remains of a launcher that was killed are removed before a run is prepared; the names of a launcher
/// that still runs are kept.
static void remains_of_a_killed_launcher_are_removed(void** state)
{
    static const launch_options_t none = {
        .mission = "no-such-mission", .transport = "", .links = "", .world = "x"};
    (void)state;
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-");
    will_return(__wrap_osal_shm_each, "/hirosco-77.link3");
    expect_value(__wrap_osal_process_watch, id, 77);
    will_return(__wrap_osal_process_watch, STATUS_NOT_FOUND);
    expect_string(__wrap_osal_shm_remove, name, "/hirosco-77.link3");
    expect_string(__wrap_launcher_remove_computers, identity, "hirosco-77");
    assert_false(launcher_prepare(&launcher, &none, "bin/"));
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-");
    will_return(__wrap_osal_shm_each, "/hirosco-78.run");
    expect_value(__wrap_osal_process_watch, id, 78);
    will_return(__wrap_osal_process_watch, STATUS_OK);
    assert_false(launcher_prepare(&launcher, &none, "bin/"));
    expect_string(__wrap_osal_shm_each, prefix, "/hirosco-");
    will_return(__wrap_osal_shm_each, "/hirosco-x"); // No launcher has made this name.
    assert_false(launcher_prepare(&launcher, &none, "bin/"));
}

static void the_owner_is_the_number_in_the_identity(void** state)
{
    (void)state;
    assert_int_equal(1234, launcher_owner_of("hirosco-1234"));
    assert_int_equal(56, launcher_owner_of("hirosco-56.run"));
    assert_int_equal(0, launcher_owner_of("hirosco-"));
    assert_int_equal(0, launcher_owner_of("other-12"));
    assert_int_equal(100000000, launcher_owner_of("hirosco-1000000009")); // No further digit fits.
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(every_memory_of_an_identity_is_removed, set_up),
        cmocka_unit_test_setup(a_tool_is_awaited_and_has_succeeded_with_code_0_only, set_up),
        cmocka_unit_test_setup(a_report_is_made_only_if_asked_for, set_up),
        cmocka_unit_test_setup(a_loss_in_the_scheduler_is_a_loss_of_the_run, set_up),
        cmocka_unit_test_setup(figures_that_fail_are_the_result_of_the_run, set_up),
        cmocka_unit_test_setup(a_guard_takes_over_without_a_prepared_run, set_up),
        cmocka_unit_test_setup(the_guard_has_the_time_of_the_scheduler, set_up),
        cmocka_unit_test_setup(a_scheduler_that_no_longer_exists_is_not_used, set_up),
        cmocka_unit_test_setup(remains_of_a_killed_launcher_are_removed, set_up),
        cmocka_unit_test_setup(the_owner_is_the_number_in_the_identity, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
