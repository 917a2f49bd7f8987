// SPDX-License-Identifier: Apache-2.0
// Which processes a run has, in which order they start, and with which arguments and descriptors. The start
// of a process is mocked.
#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/// The processes of the two components as the simulator gets them, for `fault kill` and the like.
#define PROCESSES                                                                                            \
    "--process communication=1 --process COMMUNICATION=1 --process arm=2 --process ARM=2 --process "         \
    "launcher "                                                                                              \
    "--process simulator --process packet-archive-sqlite"

static launcher_t launcher;
static run_state_t run;

// ---- Mocked functions ----

status_t __wrap_osal_process_start(osal_process_t* process, const osal_process_start_t* start)
{
    char words[1024];
    char descriptors[64];
    text_t text = text_in(words, sizeof words);
    for (size_t i = 0U; start->arguments[i] != NULL; i++) {
        text_add(&text, (i > 0U) ? " " : "");
        text_add(&text, start->arguments[i]);
    }
    check_expected_ptr(words);
    text_t numbers = text_in(descriptors, sizeof descriptors);
    for (size_t i = 0U; i < start->descriptor_count; i++) {
        text_add(&numbers, " ");
        text_add_signed(&numbers, start->descriptors[i]);
    }
    check_expected_ptr(descriptors);
    assert_string_equal("runs/x/console.log", start->output_path);
    process->id = (int32_t)(100U + run.process_count);
    return mock_type(status_t);
}

int32_t __wrap_osal_process_own_id(void)
{
    return 7;
}

void __wrap_launcher_limit(const launcher_t* self, const child_t* child, osal_process_start_t* start)
{
    assert_ptr_equal(&launcher, self);
    assert_non_null(child);
    assert_int_equal(run.is_stepped ? 1 : -1, start->processor);
}

void __wrap_launcher_add_component(const launcher_t* self, unsigned component, arguments_t* arguments)
{
    assert_ptr_equal(&launcher, self);
    arguments_add_number(arguments, "component", component);
}

bool __wrap_launcher_enter_computer(launcher_t* self, unsigned computer)
{
    assert_ptr_equal(&launcher, self);
    check_expected(computer);
    return mock_type(bool);
}

void __wrap_launcher_leave_computer(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    function_called();
}

bool __wrap_osal_file_exists(const char* path)
{
    assert_string_equal("build/venv/bin/python", path);
    return mock_type(bool);
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    launcher.run                = &run;
    launcher.program_directory  = "bin/";
    launcher.options.seed       = 7U;
    launcher.options.is_stepped = true;
    // The launcher only checks whether there is a scheduler.
    launcher.scheduler = (osal_lockstep_t*)&run;
    run.is_stepped     = true;
    (void)strcpy(run.identity, "hirosco-9");
    (void)strcpy(run.directory, "runs/x");
    (void)strcpy(launcher.world_path, "w.xml");
    (void)strcpy(launcher.scenario_path, "s.scn");
    (void)strcpy(launcher.cosimulation, "c");
    run.ground_descriptor            = 30;
    run.ground_port                  = 10025U;
    run.component_count              = 2U;
    launcher.mission.subsystem_count = 2U;
    for (unsigned i = 0U; i < 2U; i++) {
        launcher.mission.storage.subsystems[i].executable = (i == 0U) ? "communication" : "arm";
        launcher.mission.storage.subsystems[i].name       = (i == 0U) ? "COMMUNICATION" : "ARM";
        run.components[i].apid                            = (i == 0U) ? 2U : 16U;
        run.components[i].computer                        = (uint8_t)i;
        run.components[i].message_descriptor              = (int)(40U + i);
        run.components[i].wanted_life                     = 1U + i;
    }
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        run.link_descriptors[i]  = (i == 1U) ? 51 : -1;
        run.relay.descriptors[i] = (i == 2U) ? 62 : -1;
    }
    return 0;
}

static void expect_start(const char* const words, const char* const descriptors)
{
    expect_string(__wrap_osal_process_start, words, words);
    expect_string(__wrap_osal_process_start, descriptors, descriptors);
    will_return(__wrap_osal_process_start, STATUS_OK);
}

static void expect_component(const unsigned index, const char* const words, const char* const descriptors)
{
    expect_value(__wrap_launcher_enter_computer, computer, index);
    will_return(__wrap_launcher_enter_computer, true);
    expect_start(words, descriptors);
    expect_function_call(__wrap_launcher_leave_computer);
}

static void expect_names(const char* const* const names)
{
    size_t count = 0U;
    for (; names[count] != NULL; count++) {
        assert_string_equal(names[count], launcher.children[count].name);
        assert_true(launcher.children[count].is_alive);
        assert_int_equal(100U + count, run.processes[count]);
    }
    assert_int_equal(count, launcher.child_count);
    assert_int_equal(count, run.process_count);
}

// ---- Runs ----

static void a_run_of_an_image_has_archive_and_operator_as_further_processes(void** state)
{
    (void)state;
    launcher.options.is_image = true;
    launcher.has_operator     = true;
    expect_start("bin/image --run /hirosco-9.run --world w.xml --scenario s.scn --seed 7 --cosimulation c",
                 " 30 51 62");
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    will_return(__wrap_osal_file_exists, true);
    expect_start("build/venv/bin/python gse/gse script s.scn --port 10025 --run runs/x --cosimulation c", "");
    launcher_start_all(&launcher);
    expect_names((const char* const[]){"image", "packet-archive-sqlite", "operator", NULL});
    assert_int_equal(1U, run.components[1].found_life);
    assert_int_equal(RUN_PROCESS_RUNNING, run.components[1].process);
    assert_int_equal(LAUNCHER_NO_PARTICIPANT, launcher.children[2].participant);
}

static void an_image_without_a_scenario_has_no_operator(void** state)
{
    (void)state;
    launcher.options.is_image = true;
    expect_start("bin/image --run /hirosco-9.run --world w.xml --seed 7", " 30 51 62");
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    launcher_start_all(&launcher);
    expect_names((const char* const[]){"image", "packet-archive-sqlite", NULL});
}

static void each_component_is_a_process_on_its_computer(void** state)
{
    (void)state;
    launcher.has_operator     = true;
    launcher.options.delay_ms = 100U;
    launcher.options.tools    = 29536U;
    (void)strcpy(run.key, "k");
    expect_start(
        "bin/simulator --world w.xml --scenario s.scn --seed 7 --out runs/x --flows hirosco-9 --scheduler "
        "/hirosco-9.scheduler " PROCESSES
        " --process operator --process relay --cosimulation c --cosimulation-participant 3 "
        "--cosimulation-receiver 1 --socketcand 29536",
        "");
    expect_start("bin/relay --run /hirosco-9.run", " 62");
    expect_component(0U, "component 0", " 40 30 51");
    expect_component(1U, "component 1", " 41 30 51");
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    will_return(__wrap_osal_file_exists, false);
    expect_start("/usr/bin/python3 gse/gse script s.scn --port 10025 --run runs/x --key k --cosimulation c",
                 "");
    launcher_start_all(&launcher);
    expect_names((const char* const[]){"simulator", "relay", "communication", "arm", "packet-archive-sqlite",
                                       "operator", NULL});
    assert_int_equal(2U, launcher.children[3].life);
    assert_int_equal(1U, launcher.children[3].component);
    for (unsigned i = 0U; i < 6U; i++) { // Children 2 and 3 are the components.
        assert_int_equal((i == 2U) || (i == 3U), launcher.children[i].is_component);
    }
    assert_int_equal(2U, run.components[1].found_life);
    assert_int_equal(3U, launcher.children[5].participant);
}

/// Also the beat of a component, which the shared memory still has from an earlier life, is cleared.
static void processes_with_their_own_clocks_get_the_origin_of_time(void** state)
{
    (void)state;
    launcher.scheduler          = NULL;
    launcher.options.is_stepped = false;
    run.is_stepped              = false;
    run.origin_ns               = 5U;
    run.beats[1].step_ns        = 77U;
    run.relay.is_network        = true; // The network delays the links: there is no relay.
    launcher.options.delay_ms   = 100U;
    expect_start("bin/simulator --world w.xml --seed 7 --out runs/x --flows hirosco-9 " PROCESSES
                 " --time real --origin 5 --live",
                 "");
    expect_component(0U, "component 0", " 40 30 51");
    expect_component(1U, "component 1", " 41 30 51");
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    launcher_start_all(&launcher);
    expect_names((const char* const[]){"simulator", "communication", "arm", "packet-archive-sqlite", NULL});
    assert_int_equal(0U, run.beats[1].step_ns);
    assert_true(run.beats[1].wake_ns == OSAL_LOCKSTEP_NEVER);
}

/// A bus without an address is that of real devices.
static void the_simulator_gets_the_buses_that_it_simulates(void** state)
{
    (void)state;
    static const mission_bus_t buses[] = {
        {.name = "a", .redundant_to = "", .bit_rate = 500000U, .data_bit_rate = 2000000U},
        {.name = "b", .redundant_to = "a", .bit_rate = 1000000U},
        {.name = "c", .redundant_to = "a", .bit_rate = 125000U}};
    launcher.mission.bus_count = 3U;
    (void)memcpy(launcher.mission.storage.buses, buses, sizeof buses);
    (void)strcpy(run.buses[0].simulator, "/a.wire");
    (void)strcpy(run.buses[0].published, "vcan0");
    (void)strcpy(run.buses[1].simulator, "/b.wire");
    launcher.scheduler = NULL;
    expect_start("bin/simulator --world w.xml --seed 7 --out runs/x --bus a=/a.wire --publish a=vcan0 "
                 "--bit-rate a=500000,2000000 --bus b=/b.wire --bit-rate b=1000000,0 --redundant b=a "
                 "--flows hirosco-9 " PROCESSES,
                 "");
    expect_component(0U, "component 0", " 40 30 51");
    expect_component(1U, "component 1", " 41 30 51");
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    launcher_start_all(&launcher);
}

static void real_devices_need_no_simulator_and_what_cannot_start_fails_the_run(void** state)
{
    (void)state;
    launcher.options.bus = LAUNCH_BUS_CAN;
    expect_value(__wrap_launcher_enter_computer, computer, 0U);
    will_return(__wrap_launcher_enter_computer, false); // The function itself has given the reason.
    expect_value(__wrap_launcher_enter_computer, computer, 1U);
    will_return(__wrap_launcher_enter_computer, true);
    expect_string(__wrap_osal_process_start, words, "component 1");
    expect_any(__wrap_osal_process_start, descriptors);
    will_return(__wrap_osal_process_start, STATUS_NOT_FOUND);
    expect_function_call(__wrap_launcher_leave_computer);
    expect_start("bin/packet-archive-sqlite follow runs/x", "");
    launcher_start_all(&launcher);
    assert_string_equal("cannot start component: not found", launcher.reason);
    assert_int_equal(1, launcher.exit_code);
    assert_false(launcher.children[0].is_alive || launcher.children[1].is_alive);
    assert_true(launcher.children[2].is_alive);
    assert_int_equal(1U, run.process_count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_run_of_an_image_has_archive_and_operator_as_further_processes, set_up),
        cmocka_unit_test_setup(an_image_without_a_scenario_has_no_operator, set_up),
        cmocka_unit_test_setup(each_component_is_a_process_on_its_computer, set_up),
        cmocka_unit_test_setup(processes_with_their_own_clocks_get_the_origin_of_time, set_up),
        cmocka_unit_test_setup(the_simulator_gets_the_buses_that_it_simulates, set_up),
        cmocka_unit_test_setup(real_devices_need_no_simulator_and_what_cannot_start_fails_the_run, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
