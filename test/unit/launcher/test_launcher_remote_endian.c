// SPDX-License-Identifier: Apache-2.0
// Subsystems whose programs were built for another processor or a board: which subsystems are accepted, which
// files must exist, and how the program is started. The files are mocked.
#include "launcher/launcher_internal.h"

#include "fsw/framework/message/message.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define ARM_APID 0x65U
#define GRIPPER_APID 0x66U
#define PROGRAM "build/s390x/bin/arm"
#define RUNNER "/usr/bin/qemu-s390x"

#define BOARD_RUNNER "/usr/bin/qemu-system-arm"
#define M7_ARM "build/mps2-an500/bin/arm"
#define M3_GRIPPER "build/mps2-an385/bin/gripper"

static launcher_t launcher;
static run_state_t run;

bool __wrap_osal_file_exists(const char* path)
{
    check_expected_ptr(path);
    return mock_type(bool);
}

bool __wrap_launcher_fail(launcher_t* self, const char* what, const char* detail)
{
    assert_ptr_equal(&launcher, self);
    const char* const option = (launcher.options.rtos[0] != '\0') ? "--rtos: " : "--remote-endian: ";
    assert_memory_equal(option, what, strlen(option));
    check_expected_ptr(detail);
    return false;
}

static int set_up(void** state)
{
    static const struct {
        const char* name;
        const char* executable;
        uint16_t apid;
    } subsystems[] = {{"SUPERVISOR", "supervisor", SUPERVISOR_APID},
                      {"COMM", "comm", COMMUNICATION_APID},
                      {"ARM", "arm", ARM_APID},
                      {"GRIPPER", "gripper", GRIPPER_APID}};
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    launcher.run                     = &run;
    launcher.program_directory       = "bin/";
    launcher.options.remote_endian   = "ARM";
    launcher.options.rtos            = "";
    launcher.mission.subsystem_count = 4U;
    for (unsigned i = 0U; i < 4U; i++) {
        mission_subsystem_t* const one = &launcher.mission.storage.subsystems[i];
        one->name                      = subsystems[i].name;
        one->executable                = subsystems[i].executable;
        one->apid                      = subsystems[i].apid;
    }
    (void)strcpy(run.identity, "hirosco-1");
    return 0;
}

static void expect_file(const char* const path, const bool is_there)
{
    expect_string(__wrap_osal_file_exists, path, path);
    will_return(__wrap_osal_file_exists, is_there);
}

static void without_the_option_nothing_is_needed(void** state)
{
    (void)state;
    launcher.options.remote_endian = "";
    assert_true(launcher_check_remote_endian(&launcher));
    for (unsigned i = 0U; i < 4U; i++) {
        assert_false(launcher_has_proxy(&launcher, i));
    }
}

static void program_and_emulator_must_exist(void** state)
{
    (void)state;
    expect_file(PROGRAM, true);
    expect_file(RUNNER, true);
    assert_true(launcher_check_remote_endian(&launcher));
    expect_file(PROGRAM, false);
    expect_string(__wrap_launcher_fail, detail, PROGRAM);
    assert_false(launcher_check_remote_endian(&launcher));
    expect_file(PROGRAM, true);
    expect_file(RUNNER, false);
    expect_string(__wrap_launcher_fail, detail, RUNNER);
    assert_false(launcher_check_remote_endian(&launcher));
}

static void subsystems_that_share_memory_and_unknown_ones_are_refused(void** state)
{
    static const char* const names[] = {"SUPERVISOR", "COMM", "JOYSTICK", "AR", "ARMS"};
    (void)state;
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        launcher.options.remote_endian = names[i];
        expect_string(__wrap_launcher_fail, detail, names[i]);
        assert_false(launcher_check_remote_endian(&launcher));
    }
    launcher.options.remote_endian   = "ARM"; // The entry after the last subsystem.
    launcher.mission.subsystem_count = 2U;
    expect_string(__wrap_launcher_fail, detail, "ARM");
    assert_false(launcher_check_remote_endian(&launcher));
}

static void expect_arguments(const unsigned component, const char* const expected[])
{
    arguments_t arguments = {.count = 0U};
    size_t count          = 0U;
    launcher_add_component(&launcher, component, &arguments);
    for (; expected[count] != NULL; count++) {
        assert_true(count < arguments.count);
        assert_string_equal(expected[count], arguments.list[count]);
    }
    assert_int_equal(count, arguments.count);
}

static void a_native_program_is_started_itself_and_another_by_its_proxy(void** state)
{
    static const char* const native[] = {"bin/comm", "--run", "/hirosco-1.run", "--component", "1", NULL};
    static const char* const remote[] = {"bin/proxy", "--run", "/hirosco-1.run", "--component", "2",
                                         "--program", PROGRAM, "--runner",       RUNNER,        NULL};
    (void)state;
    expect_arguments(1U, native);
    expect_arguments(2U, remote);
}

/// Use `--rtos` with this value, and no other option.
static void use_boards(const char* const value)
{
    launcher.options.remote_endian = "";
    launcher.options.rtos          = value;
}

static void each_subsystem_on_a_board_needs_its_program_and_the_emulator(void** state)
{
    (void)state;
    use_boards("ARM,GRIPPER:mps2-an385");
    expect_file(M7_ARM, true);
    expect_file(BOARD_RUNNER, true);
    expect_file(M3_GRIPPER, true);
    expect_file(BOARD_RUNNER, true);
    assert_true(launcher_check_remote_endian(&launcher));
    assert_false(launcher_has_proxy(&launcher, 0U));
    assert_false(launcher_has_proxy(&launcher, 1U));
    assert_true(launcher_has_proxy(&launcher, 2U));
    assert_true(launcher_has_proxy(&launcher, 3U));
    assert_int_equal(MESSAGE_WINDOW_OCTETS, launcher_message_window(&launcher, 1U));
    assert_int_equal(MESSAGE_SMALL_WINDOW_OCTETS, launcher_message_window(&launcher, 3U));
    expect_file(M7_ARM, true);
    expect_file(BOARD_RUNNER, true);
    expect_file(M3_GRIPPER, false);
    expect_string(__wrap_launcher_fail, detail, M3_GRIPPER);
    assert_false(launcher_check_remote_endian(&launcher));
    use_boards("ARM");
    expect_file(M7_ARM, true);
    expect_file(BOARD_RUNNER, false);
    expect_string(__wrap_launcher_fail, detail, BOARD_RUNNER);
    assert_false(launcher_check_remote_endian(&launcher));
}

static void invalid_lists_of_boards_are_refused(void** state)
{
    static const char* const values[] = {"JOYSTICK", "ARM:mps2", "ARM:mps2-an5000",
                                         "ARM:mps2-an500:", ",ARM"};
    static const char* const shared[] = {"SUPERVISOR", "COMM"};
    (void)state;
    for (size_t i = 0U; i < (sizeof values / sizeof values[0]); i++) {
        use_boards(values[i]);
        expect_string(__wrap_launcher_fail, detail, values[i]);
        assert_false(launcher_check_remote_endian(&launcher));
    }
    for (size_t i = 0U; i < (sizeof shared / sizeof shared[0]); i++) {
        use_boards(shared[i]);
        expect_string(__wrap_launcher_fail, detail, shared[i]);
        assert_false(launcher_check_remote_endian(&launcher));
    }
    use_boards("ARM,ARM:mps2-an500");
    for (unsigned i = 0U; i < 2U; i++) {
        expect_file(M7_ARM, true);
        expect_file(BOARD_RUNNER, true);
    }
    expect_string(__wrap_launcher_fail, detail, "ARM,ARM:mps2-an500");
    assert_false(launcher_check_remote_endian(&launcher));
    use_boards("GRIPPER,ARM");
    launcher.options.remote_endian = "ARM";
    expect_file(PROGRAM, true);
    expect_file(RUNNER, true);
    expect_file("build/mps2-an500/bin/gripper", true);
    expect_file(BOARD_RUNNER, true);
    expect_string(__wrap_launcher_fail, detail, "GRIPPER,ARM");
    assert_false(launcher_check_remote_endian(&launcher));
}

static void the_proxy_gets_the_name_of_its_board(void** state)
{
    static const char* const expected[] = {"bin/proxy",  "--run",     "/hirosco-1.run", "--component",
                                           "3",          "--program", M3_GRIPPER,       "--runner",
                                           BOARD_RUNNER, "--board",   "mps2-an385",     NULL};
    (void)state;
    use_boards("ARM,GRIPPER:mps2-an385");
    expect_arguments(3U, expected);
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(without_the_option_nothing_is_needed),
        TEST(program_and_emulator_must_exist),
        TEST(subsystems_that_share_memory_and_unknown_ones_are_refused),
        TEST(a_native_program_is_started_itself_and_another_by_its_proxy),
        TEST(each_subsystem_on_a_board_needs_its_program_and_the_emulator),
        TEST(invalid_lists_of_boards_are_refused),
        TEST(the_proxy_gets_the_name_of_its_board),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
