// SPDX-License-Identifier: Apache-2.0
// Interfaces that a run accepts for its buses, interfaces that it makes and removes, the addresses of both
// ends, and the reason of each refusal. Interfaces and buses are mocked.
#include "launcher/launcher_internal.h"
#include "osal/include/osal/can.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define LABEL "hirosco: removed with its run"
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

static launcher_t launcher;
static run_state_t run;
static osal_can_interface_t can_fd; // A fitting controller of bus ROBOT.
static osal_can_hand_over_t counts;

// ---- Mocked functions ----

bool __wrap_launcher_refuse(launcher_t* self, const char* const* words)
{
    assert_ptr_equal(&launcher, self);
    (void)text_join(launcher.reason, sizeof launcher.reason, words);
    launcher.exit_code = 1;
    return false;
}

status_t __wrap_osal_can_interface_look(const char* name, osal_can_interface_t* out_interface)
{
    check_expected_ptr(name);
    const osal_can_interface_t* const seen = mock_ptr_type(const osal_can_interface_t*);
    if (seen != NULL) {
        *out_interface = *seen;
    }
    return mock_type(status_t);
}

status_t __wrap_osal_can_interface_create(const char* name, bool carries_fd, const char* label)
{
    check_expected_ptr(name);
    check_expected(carries_fd);
    assert_string_equal(LABEL, label);
    return mock_type(status_t);
}

status_t __wrap_osal_can_interface_remove(const char* name)
{
    check_expected_ptr(name);
    return STATUS_OK;
}

status_t __wrap_osal_can_interface_claim(const char* name, osal_can_claim_t* out_claim)
{
    check_expected_ptr(name);
    out_claim->descriptor = 7;
    return mock_type(status_t);
}

void __wrap_osal_can_interface_release(osal_can_claim_t* claim)
{
    check_expected_ptr(claim);
}

status_t __wrap_osal_can_create(const char* address)
{
    check_expected_ptr(address);
    return mock_type(status_t);
}

status_t __wrap_osal_can_destroy(const char* address)
{
    check_expected_ptr(address);
    return STATUS_OK;
}

status_t __wrap_osal_can_hand_over(const char* address, osal_can_hand_over_t* out_counts)
{
    check_expected_ptr(address);
    *out_counts = counts;
    return mock_type(status_t);
}

void __wrap_osal_console_print_line(const char* line)
{
    check_expected_ptr(line);
}

// ---- The mission: an FD bus ROBOT with a channel B ----

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    (void)strcpy(run.identity, "hirosco-1");
    launcher.run               = &run;
    launcher.mission.bus_count = 1U;
    launcher.mission.storage.buses[0] =
        (mission_bus_t){.name = "robot", .redundant_to = "", .bit_rate = 1000000U, .data_bit_rate = 4000000U};
    launcher.mission.storage.buses[1] = (mission_bus_t){
        .name = "robot-b", .redundant_to = "robot", .bit_rate = 1000000U, .data_bit_rate = 0U};
    can_fd = (osal_can_interface_t){
        .is_up = true, .carries_fd = true, .bit_rate = 1000000U, .data_bit_rate = 4000000U};
    counts = (osal_can_hand_over_t){0U};
    return 0;
}

static void expect_look(const char* const name, const osal_can_interface_t* const seen, const status_t status)
{
    expect_string(__wrap_osal_can_interface_look, name, name);
    will_return(__wrap_osal_can_interface_look, seen);
    will_return(__wrap_osal_can_interface_look, status);
}

static void assert_refused(const char* const part)
{
    launcher.reason[0] = '\0';
    launcher.exit_code = 0;
    assert_false(launcher_ready_interfaces(&launcher));
    if (strstr(launcher.reason, part) == NULL) {
        fail_msg("expected '%s' in '%s'", part, launcher.reason);
    }
    assert_int_equal(1, launcher.exit_code);
}

static void shared_memory_needs_no_interface(void** state)
{
    (void)state;
    assert_true(launcher_ready_interfaces(&launcher));
    assert_true(launcher.buses[0].is_fd);
    assert_string_equal("", launcher.buses[0].flight);
}

// ---- Real controllers ----

static void use_controllers(const char* const flight, const char* const simulator)
{
    launcher.options.bus                 = LAUNCH_BUS_CAN;
    launcher.options.interfaces[0]       = flight;
    launcher.options.interface_count     = 1U;
    launcher.options.sim_interfaces[0]   = simulator;
    launcher.options.sim_interface_count = (simulator != NULL) ? 1U : 0U;
}

static void a_fitting_controller_is_taken(void** state)
{
    (void)state;
    use_controllers("robot=can0", NULL);
    expect_look("can0", &can_fd, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    assert_string_equal("can0", launcher.buses[0].flight);
    assert_string_equal("", launcher.buses[0].simulator);
    can_fd.bit_rate      = 0U; // The kernel does not report a rate.
    can_fd.data_bit_rate = 0U;
    use_controllers("robot=can0", "robot=can1");
    expect_look("can0", &can_fd, STATUS_OK);
    expect_look("can1", &can_fd, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    assert_string_equal("can0", launcher.buses[0].flight);
    assert_string_equal("can1", launcher.buses[0].simulator);
}

static void a_classic_bus_needs_no_fd(void** state)
{
    (void)state;
    launcher.mission.storage.buses[0].data_bit_rate = 0U;
    can_fd.carries_fd                               = false;
    can_fd.data_bit_rate                            = 5U; // The data rate of a classic bus is not compared.
    use_controllers("robot=can0", NULL);
    expect_look("can0", &can_fd, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    assert_false(launcher.buses[0].is_fd);
}

static void expect_unfit(const osal_can_interface_t seen, const char* const part)
{
    expect_look("can0", &seen, STATUS_OK);
    assert_refused(part);
}

static void a_controller_that_does_not_fit_is_refused_with_the_command_that_changes_it(void** state)
{
    osal_can_interface_t seen = can_fd;
    (void)state;
    use_controllers("robot=can0", NULL);
    seen.bit_rate = 500000U;
    expect_unfit(
        seen, "can0 runs at 500000/4000000 bit/s, bus robot of the mission at 1000000/4000000; as root: "
              "ip link set can0 down; ip link set can0 up type can bitrate 1000000 dbitrate 4000000 fd on");
    seen               = can_fd;
    seen.data_bit_rate = 2000000U;
    expect_unfit(seen, "can0 runs at 1000000/2000000 bit/s");
    seen            = can_fd;
    seen.carries_fd = false;
    expect_unfit(
        seen, "can0 carries classic frames only (mtu 16), and bus robot of the mission is CAN FD: enable FD");
    seen.is_virtual = true;
    expect_unfit(seen, "as root: ip link set can0 down; ip link set can0 up mtu 72");
    seen       = can_fd;
    seen.is_up = false;
    expect_unfit(seen, "can0 is down; as root: ip link set can0 up");
    seen            = can_fd;
    seen.is_bus_off = true;
    expect_unfit(seen,
                 "can0 is bus-off; check wiring and termination; as root: ip link set can0 down; ip link "
                 "set can0 up ");
    launcher.mission.storage.buses[0].data_bit_rate = 0U;
    seen                                            = can_fd;
    seen.bit_rate                                   = 1U;
    expect_unfit(seen, "up type can bitrate 1000000");
    seen.data_bit_rate = 0U;
    expect_unfit(seen, "can0 runs at 1 bit/s, bus robot of the mission at 1000000; as root");
    seen.data_bit_rate = can_fd.data_bit_rate;
    assert_null(strstr(launcher.reason, "dbitrate"));
    use_controllers("robot=can1", "robot=can0"); // The simulator's controller is checked as well.
    expect_look("can1", &can_fd, STATUS_OK);
    expect_unfit(seen, "can0 runs at 1/");
}

static void an_interface_that_cannot_be_queried_is_refused_with_the_cause(void** state)
{
    static const struct {
        status_t status;
        const char* part;
    } causes[] = {{STATUS_INVALID, "not allowed: can0"},
                  {STATUS_UNSUPPORTED, "no SocketCAN, which can0 needs"},
                  {STATUS_NOT_FOUND, "there is no interface can0; `ip"},
                  {STATUS_NOT_OURS, "can0 is an interface, but not for CAN"},
                  {STATUS_DENIED, "cannot query the interface can0: "}};
    (void)state;
    use_controllers("robot=can0", NULL);
    for (size_t i = 0U; i < COUNT(causes); i++) {
        expect_look("can0", NULL, causes[i].status);
        assert_refused(causes[i].part);
    }
}

static void each_bus_needs_a_controller_and_each_controller_a_bus(void** state)
{
    (void)state;
    use_controllers("rob=can0", NULL); // The name of a bus must be given completely.
    assert_refused("the mission has no such bus: rob=can0; its file lists them in <Buses>");
    use_controllers("robot-c=can0", NULL);
    assert_refused("the mission has no such bus: robot-c=can0");
    use_controllers("robot=can0", "arm=can1");
    assert_refused("the mission has no such bus: arm=can1");
    launcher.mission.bus_count = 2U;
    use_controllers("robot=can0", "robot-b=can1");
    assert_refused("no interface of the simulator is named for bus robot");
    use_controllers("robot-b=can0", NULL);
    assert_refused("no interface is named for bus robot of the mission");
    use_controllers("robot=can0", NULL); // Channel B may be missing.
    expect_look("can0", &can_fd, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    assert_string_equal("", launcher.buses[1].flight);
    assert_true(launcher_create_buses(&launcher)); // Channel B does not exist in this run.
    assert_string_equal("can:can0", run.buses[0].flight);
    assert_string_equal("", run.buses[0].simulator);
    assert_string_equal("", run.buses[1].flight);
}

/// A real controller does not receive the frames that it sends; a virtual interface may serve both ends.
static void flight_and_simulator_share_a_virtual_interface_only(void** state)
{
    (void)state;
    use_controllers("robot=can0", "robot=can0");
    expect_look("can0", &can_fd, STATUS_OK);
    assert_refused("flight and simulator need separate controllers; both have can0 for bus robot");
    expect_look("can0", NULL, STATUS_NOT_FOUND);
    assert_refused("need separate controllers");
    can_fd.is_virtual = true;
    expect_look("can0", &can_fd, STATUS_OK);
    expect_look("can0", &can_fd, STATUS_OK);
    expect_look("can0", &can_fd, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
}

// ---- Virtual interfaces ----

static void expect_claim(const char* const name, const status_t status)
{
    expect_string(__wrap_osal_can_interface_claim, name, name);
    will_return(__wrap_osal_can_interface_claim, status);
}

static void expect_create(const char* const name, const bool carries_fd, const status_t status)
{
    expect_look(name, NULL, STATUS_NOT_FOUND);
    expect_string(__wrap_osal_can_interface_create, name, name);
    expect_value(__wrap_osal_can_interface_create, carries_fd, carries_fd);
    will_return(__wrap_osal_can_interface_create, status);
}

static void expect_removal(const char* const name)
{
    expect_string(__wrap_osal_can_interface_remove, name, name);
}

static void missing_virtual_interfaces_are_made_and_removed_again(void** state)
{
    (void)state;
    launcher.options.bus = LAUNCH_BUS_VCAN;
    expect_claim("vcan-robot", STATUS_OK);
    expect_create("vcan-robot", true, STATUS_OK);
    expect_create("fsw-robot", true, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    launcher.run = NULL; // The run was refused before it started.
    expect_removal("fsw-robot");
    expect_removal("vcan-robot");
    expect_value_count(__wrap_osal_can_interface_release, claim, &launcher.buses[0].claim, 2);
    launcher_remove_buses(&launcher);
    launcher_remove_buses(&launcher); // The second call removes nothing.
}

static void an_existing_interface_is_used_and_stays_unless_a_killed_run_left_it(void** state)
{
    osal_can_interface_t ours = can_fd;
    osal_can_interface_t left = can_fd;
    (void)state;
    (void)strcpy(left.label, LABEL);
    launcher.options.bus = LAUNCH_BUS_VCAN;
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", &ours, STATUS_OK);
    expect_look("fsw-robot", &left, STATUS_OK);
    assert_true(launcher_ready_interfaces(&launcher));
    launcher.run = NULL;
    expect_removal("fsw-robot");
    expect_value(__wrap_osal_can_interface_release, claim, &launcher.buses[0].claim);
    launcher_remove_buses(&launcher);
    ours.is_up = false;
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", &ours, STATUS_OK);
    assert_refused("vcan-robot is down");
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", NULL, STATUS_IO);
    assert_refused("cannot query the interface vcan-robot: ");
}

static void interfaces_that_cannot_be_made_are_reported_with_the_commands(void** state)
{
    (void)state;
    launcher.options.bus = LAUNCH_BUS_VCAN;
    expect_claim("vcan-robot", STATUS_OK);
    expect_create("vcan-robot", true, STATUS_DENIED);
    assert_refused(
        "not permitted here; as root, once: ip link add vcan-robot mtu 72 type vcan; ip link set "
        "vcan-robot up; ip link add fsw-robot mtu 72 type vcan; ip link set fsw-robot up; and the same for "
        "each bus");
    expect_claim("vcan-robot", STATUS_OK);
    expect_create("vcan-robot", true, STATUS_UNSUPPORTED);
    assert_refused("no SocketCAN, or no vcan");
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", NULL, STATUS_UNSUPPORTED);
    assert_refused("no SocketCAN, or no vcan");
    launcher.mission.storage.buses[0].data_bit_rate = 0U;
    expect_claim("vcan-robot", STATUS_OK);
    expect_create("vcan-robot", false, STATUS_IO);
    assert_refused("cannot create the CAN interfaces; try as root: ip link add vcan-robot mtu 16");
    assert_false(launcher.buses[0].is_published_made);
    expect_claim("vcan-robot", STATUS_EXISTS);
    assert_refused("another run flies on vcan-robot");
    expect_claim("vcan-robot", STATUS_IO);
    assert_refused("cannot claim the interface vcan-robot: ");
    launcher.mission.storage.buses[0].name = "elevenchars";
    assert_refused("the name of bus elevenchars is too long");
}

static void a_guard_takes_over_the_interfaces_that_the_run_has_made(void** state)
{
    osal_can_interface_t left = can_fd;
    (void)state;
    (void)strcpy(left.label, LABEL);
    launcher_adopt_interfaces(&launcher); // A run over shared memory has no interfaces.
    launcher.options.bus = LAUNCH_BUS_VCAN;
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", &left, STATUS_OK);
    expect_look("fsw-robot", &can_fd, STATUS_OK);
    launcher_adopt_interfaces(&launcher);
    assert_true(launcher.buses[0].is_published_made);
    assert_false(launcher.buses[0].is_flight_made);
    (void)memset(launcher.buses, 0, sizeof launcher.buses);
    expect_claim("vcan-robot", STATUS_EXISTS); // Another run uses them.
    launcher_adopt_interfaces(&launcher);
    expect_claim("vcan-robot", STATUS_OK);
    expect_look("vcan-robot", &left, STATUS_NOT_FOUND);
    expect_look("fsw-robot", &left, STATUS_OK);
    launcher_adopt_interfaces(&launcher);
    assert_false(launcher.buses[0].is_published_made);
    assert_true(launcher.buses[0].is_flight_made);
}

// ---- Addresses, and the end ----

static void expect_bus(const char* const address, const status_t status)
{
    expect_string(__wrap_osal_can_create, address, address);
    will_return(__wrap_osal_can_create, status);
}

static void each_end_of_a_bus_has_its_address(void** state)
{
    (void)state;
    launcher.mission.bus_count = 2U;
    expect_bus("shm:hirosco-1.can.robot", STATUS_OK);
    expect_bus("shm:hirosco-1.can.robot-b", STATUS_OK);
    assert_true(launcher_create_buses(&launcher));
    assert_string_equal("shm:hirosco-1.can.robot", run.buses[0].flight);
    assert_string_equal("", run.buses[0].published);
    launcher.mission.bus_count = 1U;
    (void)strcpy(launcher.buses[0].flight, "fsw-robot");
    (void)strcpy(launcher.buses[0].published, "vcan-robot");
    launcher.options.bus = LAUNCH_BUS_VCAN;
    expect_bus("can:fsw-robot@hirosco-1.can.robot", STATUS_OK);
    assert_true(launcher_create_buses(&launcher));
    assert_string_equal("can:fsw-robot@hirosco-1.can.robot", run.buses[0].flight);
    assert_string_equal("can:vcan-robot", run.buses[0].published);
    use_controllers("robot=can0", "robot=can1");
    (void)strcpy(launcher.buses[0].flight, "can0");
    (void)strcpy(launcher.buses[0].simulator, "can1");
    expect_bus("can:can1@hirosco-1.can.robot", STATUS_OK);
    assert_true(launcher_create_buses(&launcher));
    assert_string_equal("can:can0@hirosco-1.can.robot", run.buses[0].flight);
    assert_string_equal("can:can1@hirosco-1.can.robot", run.buses[0].simulator);
}

static void a_bus_that_cannot_be_made_ends_the_preparation(void** state)
{
    (void)state;
    launcher.mission.bus_count = 2U;
    expect_bus("shm:hirosco-1.can.robot", STATUS_EXISTS);
    assert_false(launcher_create_buses(&launcher)); // The second bus is not created.
    assert_non_null(strstr(launcher.reason, "cannot create the bus shm:hirosco-1.can.robot: "));
    static char name[RUN_NAME_MAX];
    (void)memset(name, 'n', sizeof name - 1U);
    launcher.mission.storage.buses[0].name = name;
    assert_false(launcher_create_buses(&launcher)); // No address holds such a name.
}

static void expect_end(const status_t status)
{
    expect_string(__wrap_osal_can_hand_over, address, "can:a@b");
    will_return(__wrap_osal_can_hand_over, status);
    expect_string(__wrap_osal_can_destroy, address, "can:a@b");
    expect_any(__wrap_osal_can_interface_release, claim);
}

static void late_lost_and_external_frames_are_summed_and_printed(void** state)
{
    static const osal_can_hand_over_t cases[] = {
        {9U, 1U, 0U, 0U, 0U}, {9U, 0U, 2U, 0U, 0U}, {9U, 0U, 0U, 3U, 0U}, {9U, 0U, 0U, 0U, 4U}};
    static const char* const lines[] = {
        "bus robot: 9 frames transferred, 1 of them late; 0 frames lost; 0 frames from outside the run; "
        "0 calls failed: interface down or removed",
        "bus robot: 9 frames transferred, 0 of them late; 2 frames lost; 0 frames from outside the run; "
        "0 calls failed: interface down or removed",
        "bus robot: 9 frames transferred, 0 of them late; 0 frames lost; 3 frames from outside the run; "
        "0 calls failed: interface down or removed",
        "bus robot: 9 frames transferred, 0 of them late; 0 frames lost; 0 frames from outside the run; "
        "4 calls failed: interface down or removed"};
    (void)state;
    (void)strcpy(run.buses[0].simulator, "can:a@b");
    counts.frames = 9U;
    expect_end(STATUS_OK); // All arrived in time.
    launcher_remove_buses(&launcher);
    for (unsigned round = 1U; round <= 2U; round++) {
        for (size_t i = 0U; i < COUNT(cases); i++) {
            counts = cases[i];
            expect_end(STATUS_OK);
            expect_string(__wrap_osal_console_print_line, line, lines[i]);
            launcher_remove_buses(&launcher);
        }
        assert_int_equal(round * 1U, launcher.late_frames);
        assert_int_equal(round * 2U, launcher.lost_frames);
        assert_int_equal(round * 3U, launcher.external_frames);
        assert_int_equal(round * 4U, launcher.bus_cuts);
    }
    expect_end(STATUS_NOT_FOUND); // A bus in shared memory has no counts.
    launcher_remove_buses(&launcher);
    assert_int_equal(2U, launcher.late_frames);
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(shared_memory_needs_no_interface),
        TEST(a_fitting_controller_is_taken),
        TEST(a_classic_bus_needs_no_fd),
        TEST(a_controller_that_does_not_fit_is_refused_with_the_command_that_changes_it),
        TEST(an_interface_that_cannot_be_queried_is_refused_with_the_cause),
        TEST(each_bus_needs_a_controller_and_each_controller_a_bus),
        TEST(flight_and_simulator_share_a_virtual_interface_only),
        TEST(missing_virtual_interfaces_are_made_and_removed_again),
        TEST(an_existing_interface_is_used_and_stays_unless_a_killed_run_left_it),
        TEST(interfaces_that_cannot_be_made_are_reported_with_the_commands),
        TEST(a_guard_takes_over_the_interfaces_that_the_run_has_made),
        TEST(each_end_of_a_bus_has_its_address),
        TEST(a_bus_that_cannot_be_made_ends_the_preparation),
        TEST(late_lost_and_external_frames_are_summed_and_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
