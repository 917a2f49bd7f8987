// SPDX-License-Identifier: Apache-2.0
// Limits of memory and descriptors of the processes, and what is recorded when a process ends. Programs,
// console and processes are mocked.
#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define REMOTE 1U ///< The component whose program is for another processor.

static launcher_t launcher;
static osal_process_result_t result_to_come;

// ---- Mocked functions ----

status_t __wrap_osal_process_loaded_size(const char* path, uint64_t* out_octets)
{
    check_expected_ptr(path);
    *out_octets = mock_type(uint64_t);
    return mock_type(status_t);
}

void __wrap_osal_console_print_line(const char* line)
{
    check_expected_ptr(line);
}

void __wrap_osal_console_print_error(const char* line)
{
    check_expected_ptr(line);
}

bool __wrap_launcher_has_proxy(const launcher_t* self, unsigned component)
{
    assert_ptr_equal(&launcher, self);
    return component == REMOTE;
}

status_t __wrap_osal_process_poll(osal_process_t* process, osal_process_result_t* out_result)
{
    assert_non_null(process);
    *out_result = result_to_come;
    return mock_type(status_t);
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    launcher.program_directory       = "bin/";
    launcher.mission.subsystem_count = 2U;
    for (unsigned i = 0U; i < 2U; i++) {
        mission_subsystem_t* const one = &launcher.mission.storage.subsystems[i];
        one->name                      = (i == 0U) ? "ARM" : "GRIPPER";
        one->executable                = (i == 0U) ? "arm" : "gripper";
        one->line                      = 10U + i;
        one->memory_kib                = 500U;
    }
    result_to_come = (osal_process_result_t){.has_ended = true};
    return 0;
}

static void expect_program(const char* const path, const uint64_t octets, const status_t status)
{
    expect_string(__wrap_osal_process_loaded_size, path, path);
    will_return(__wrap_osal_process_loaded_size, octets);
    will_return(__wrap_osal_process_loaded_size, status);
}

static void the_limit_of_the_mission_counts_if_the_program_fits(void** state)
{
    (void)state;
    launcher.mission.storage.subsystems[1].memory_kib = 499U;
    expect_program("bin/arm", 500U * 1024U, STATUS_OK);
    expect_program("bin/gripper", (500U * 1024U) - 1U, STATUS_OK); // Less than 500 KiB.
    assert_true(launcher_set_limits(&launcher, "m.xml"));
    assert_int_equal(500U, launcher.memory_limit_kib[0]);
    assert_int_equal(499U, launcher.memory_limit_kib[1]);
    assert_int_equal(0, launcher.exit_code);
}

static void a_limit_below_the_program_is_refused_with_file_and_line(void** state)
{
    (void)state;
    expect_program("bin/arm", 501U * 1024U, STATUS_OK);
    assert_false(launcher_set_limits(&launcher, "m.xml")); // The second program is not checked.
    assert_string_equal(
        "m.xml:10: memoryKiB=\"500\" of <Subsystem>: expected more KiB than the program alone "
        "needs, 501",
        launcher.reason);
    assert_int_equal(1, launcher.exit_code);
}

static void a_missing_limit_is_derived_from_the_program_and_printed(void** state)
{
    (void)state;
    launcher.mission.storage.subsystems[0].memory_kib = 0U;
    expect_program("bin/arm", (1000U * 1024U) + 1023U, STATUS_OK);
    expect_program("bin/gripper", 9999999U, STATUS_INVALID); // A script.
    expect_string(__wrap_osal_console_print_line, line,
                  "m.xml:10: ARM has no memoryKiB: limited to 11490 KiB");
    assert_true(launcher_set_limits(&launcher, "m.xml"));
    // A quarter more than 1000 KiB for the program and 8192 KiB for the rest.
    assert_int_equal(11490U, launcher.memory_limit_kib[0]);
    assert_int_equal(500U, launcher.memory_limit_kib[1]);
}

static void native_components_only_are_limited(void** state)
{
    child_t child              = {.is_component = true, .component = 0U};
    osal_process_start_t start = {.processor = -1};
    (void)state;
    launcher.memory_limit_kib[0] = 5000000U; // In octets this is more than 32 bits can hold.
    launcher_limit(&launcher, &child, &start);
    assert_int_equal(5120000000ULL, start.memory_limit_octets);
    assert_int_equal(128U, start.descriptor_limit);
    start           = (osal_process_start_t){.processor = -1};
    child.component = REMOTE;
    launcher_limit(&launcher, &child, &start);
    child = (child_t){.is_component = false};
    launcher_limit(&launcher, &child, &start);
    assert_int_equal(0U, start.memory_limit_octets);
    assert_int_equal(0U, start.descriptor_limit);
}

// ---- Ends ----

static void an_end_is_reported_as_soon_as_it_is_known(void** state)
{
    child_t child = {.name = "arm", .is_alive = false};
    (void)state;
    assert_false(launcher_has_ended(&launcher, &child)); // An end is not reported twice.
    child.is_alive = true;
    will_return(__wrap_osal_process_poll, STATUS_NOT_OURS);
    assert_false(launcher_has_ended(&launcher, &child));
    result_to_come.has_ended = false;
    will_return(__wrap_osal_process_poll, STATUS_OK);
    assert_false(launcher_has_ended(&launcher, &child));
    result_to_come.has_ended = true;
    will_return(__wrap_osal_process_poll, STATUS_OK);
    assert_true(launcher_has_ended(&launcher, &child));
}

static void the_peak_of_all_lives_is_kept(void** state)
{
    static const uint64_t peaks[] = {100U, 300U, 200U};
    child_t child                 = {.name = "arm", .is_alive = true};
    (void)state;
    for (size_t i = 0U; i < 3U; i++) {
        result_to_come.memory_high_kib = peaks[i];
        will_return(__wrap_osal_process_poll, STATUS_OK);
        assert_true(launcher_has_ended(&launcher, &child));
        assert_int_equal((i == 0U) ? 100U : 300U, child.memory_high_kib);
    }
}

/// A component that has failed may have been near its limit.
static void the_memory_of_a_component_that_failed_is_printed(void** state)
{
    static const osal_process_result_t ends[] = {{.has_ended = true, .was_signalled = true},
                                                 {.has_ended = true, .code = 1}};
    child_t child                             = {.name = "arm", .is_alive = true, .is_component = true};
    (void)state;
    launcher.memory_limit_kib[0] = 500U;
    for (size_t i = 0U; i < 2U; i++) {
        result_to_come                 = ends[i];
        result_to_come.memory_high_kib = 77U;
        expect_string(__wrap_osal_console_print_error, line,
                      "arm: had 77 KiB of memory at most; its address space is limited to 500 KiB");
        will_return(__wrap_osal_process_poll, STATUS_OK);
        assert_true(launcher_has_ended(&launcher, &child));
    }
    child.is_component = false; // This child has no limit.
    will_return(__wrap_osal_process_poll, STATUS_OK);
    assert_true(launcher_has_ended(&launcher, &child));
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(the_limit_of_the_mission_counts_if_the_program_fits),
        TEST(a_limit_below_the_program_is_refused_with_file_and_line),
        TEST(a_missing_limit_is_derived_from_the_program_and_printed),
        TEST(native_components_only_are_limited),
        TEST(an_end_is_reported_as_soon_as_it_is_known),
        TEST(the_peak_of_all_lives_is_kept),
        TEST(the_memory_of_a_component_that_failed_is_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
