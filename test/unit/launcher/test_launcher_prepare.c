// SPDX-License-Identifier: Apache-2.0
// What the launcher prepares before the first process of a run: the directory, the port of the ground and the
// scheduler; and the reason that it gives if a part is missing. The other files of the launcher, shared
// memory and the socket are mocked; mission and directory are real.
#define _GNU_SOURCE
#include "generated/device_classes.h"
#include "launcher/launcher_internal.h"

#include "fsw/framework/rtlink/agreement.h"
#include "fsw/programs/ground_key.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static launcher_t launcher;
static run_state_t run;
static launch_options_t options;
static char directory[] = "/tmp/launcher-prepare-XXXXXX";
static bool is_mission_there;
static bool has_own_scenario; // The mission has a scenario of its name.
static const char* named_key; // Key of the ground link that the mission names.

// ---- Mocked functions ----

status_t __wrap_osal_shm_each(const char* prefix, void (*visit)(void* context, const char* name),
                              void* context)
{
    assert_string_equal("/hirosco-", prefix);
    assert_non_null(visit);
    assert_null(context);
    return STATUS_OK; // No objects of other runs are left.
}

status_t __real_descriptor_load_mission(descriptor_loader_t* loader, const char* path, uint16_t apid,
                                        const mission_scope_t* scope, mission_descriptor_t* out_mission,
                                        subsystem_descriptor_t* out_own);
status_t __wrap_descriptor_load_mission(descriptor_loader_t* loader, const char* path, uint16_t apid,
                                        const mission_scope_t* scope, mission_descriptor_t* out_mission,
                                        subsystem_descriptor_t* out_own)
{
    const status_t status   = __real_descriptor_load_mission(loader, path, apid, scope, out_mission, out_own);
    out_mission->ground_key = named_key;
    return status;
}

bool __wrap_ground_key_open(ground_key_t* self, const char* path, char error[GROUND_KEY_ERROR_MAX])
{
    assert_non_null(self);
    check_expected_ptr(path);
    (void)strcpy(error, "damaged key");
    return mock_type(bool);
}

void __wrap_ground_key_close(ground_key_t* self)
{
    assert_non_null(self);
    function_called();
}

bool __wrap_launcher_set_limits(launcher_t* self, const char* mission_path)
{
    assert_ptr_equal(&launcher, self);
    assert_string_equal("descriptors/missions/rokviss.xml", mission_path);
    return mock_type(bool);
}

bool __wrap_launcher_check_device_classes(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_check_streams(launcher_t* self, const char* mission_path)
{
    assert_ptr_equal(&launcher, self);
    assert_string_equal("descriptors/missions/rokviss.xml", mission_path);
    return true;
}

bool __wrap_launcher_check_remote_endian(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_check_system(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_ready_interfaces(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_create_buses(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_create_computers(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return true;
}

bool __wrap_launcher_open_sockets(launcher_t* self)
{
    assert_ptr_equal(&launcher, self);
    return mock_type(bool);
}

status_t __wrap_run_state_create(osal_shm_t* shm, const char* identity, run_state_t** out_block)
{
    assert_ptr_equal(&launcher.run_shm, shm);
    (void)text_join(run.identity, sizeof run.identity, (const char* const[]){identity, NULL});
    *out_block = &run;
    return STATUS_OK;
}

status_t __wrap_osal_shm_create(osal_shm_t* shm, const char* name, size_t size)
{
    assert_non_null(shm);
    assert_non_null(strstr(name, (shm == &launcher.scheduler_shm) ? ".scheduler" : ".checkpoint"));
    assert_true(size > 0U);
    return mock_type(status_t);
}

void __wrap_osal_shm_close(osal_shm_t* shm)
{
    assert_non_null(shm);
    function_called();
}

/// Mission, world, scenario and programs exist; each test says which directories of runs exist, and whether
/// the mission has a scenario of its name.
bool __wrap_osal_file_exists(const char* path)
{
    if ((strncmp(path, "runs/", 5U) == 0) && (strstr(path, "/run.json") == NULL)) {
        check_expected_ptr(path);
        return mock_type(bool);
    }
    if (strcmp(path, "sim/scenarios/rokviss.scn") == 0) {
        return has_own_scenario;
    }
    return (strstr(path, "/run.json") == NULL) && (is_mission_there || (strstr(path, "missions/") == NULL));
}

status_t __real_osal_file_create_directory(const char* path);
status_t __wrap_osal_file_create_directory(const char* path)
{
    check_expected_ptr(path);
    const status_t status = mock_type(status_t);
    return (status == STATUS_OK) ? __real_osal_file_create_directory(path) : status;
}

status_t __wrap_osal_tcp_listen(osal_socket_t* listener, osal_address_t local)
{
    const uint16_t port = local.port;
    assert_ptr_equal(&launcher.ground, listener);
    assert_int_equal(OSAL_IPV4_LOOPBACK, local.ipv4);
    check_expected(port);
    listener->descriptor = 33;
    return mock_type(status_t);
}

osal_lockstep_t* __wrap_osal_lockstep_create(void* memory, uint64_t step_ns, bool is_shared)
{
    assert_ptr_equal(&run, memory);
    assert_int_equal(RUN_STEP_NS, step_ns);
    check_expected(is_shared);
    return (osal_lockstep_t*)&run; // The launcher does not read it.
}

void* __wrap_osal_shm_address(const osal_shm_t* shm)
{
    assert_ptr_equal(&launcher.scheduler_shm, shm);
    return &run;
}

void __wrap_osal_lockstep_expect(osal_lockstep_t* scheduler, unsigned participant, uint32_t life,
                                 uint64_t at_ns)
{
    assert_ptr_equal(&run, scheduler);
    assert_int_equal(1U, life);
    assert_int_equal(0U, at_ns);
    check_expected(participant);
}

void __wrap_osal_lockstep_set_succession(osal_lockstep_t* scheduler, unsigned participant, uint64_t delay_ns)
{
    assert_ptr_equal(&run, scheduler);
    assert_true(delay_ns > 0U);
    check_expected(participant);
}

// ---- Fixture ----

static int set_up(void** state)
{
    (void)state;
    (void)memset(&run, 0, sizeof run);
    is_mission_there = true;
    has_own_scenario = false;
    named_key        = "";
    options          = (launch_options_t){.mission       = "rokviss",
                                          .scenario      = "press",
                                          .world         = "rokviss",
                                          .seed          = 7U,
                                          .is_free       = true,
                                          .transport     = "",
                                          .links         = "",
                                          .computers     = 1U,
                                          .output        = "",
                                          .storage       = "",
                                          .key           = "",
                                          .remote_endian = "",
                                          .rtos          = ""};
    (void)strcpy(&directory[sizeof directory - 7U], "XXXXXX");
    return (mkdtemp(directory) != NULL) ? 0 : 1;
}

static int tear_down(void** state)
{
    static const char* const names[] = {"storage/mission", "storage",      "ground.mission",
                                        "ground.world",    "ground.port",  "ground.classes",
                                        "ground.scenario", "run.json.part"};
    char path[96];
    (void)state;
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        (void)snprintf(path, sizeof path, "%s/%s", directory, names[i]);
        if (unlink(path) != 0) {
            (void)rmdir(path);
        }
    }
    return rmdir(directory); // Fails if the directory contains anything else.
}

static void prepare_fails(const char* const reason)
{
    assert_false(launcher_prepare(&launcher, &options, "bin/"));
    assert_string_equal(reason, launcher.reason);
}

// ---- Inputs ----

static void a_mission_that_is_missing_is_named(void** state)
{
    (void)state;
    is_mission_there = false;
    prepare_fails(
        "no such mission (run hirosco in the project's directory): descriptors/missions/rokviss.xml");
}

static void a_limit_that_is_too_low_ends_the_preparation(void** state)
{
    (void)state;
    will_return(__wrap_launcher_set_limits, false);
    prepare_fails(""); // launcher_set_limits gives the reason.
}

// ---- Key of the ground link ----

static void expect_key(const char* const path, const bool is_good)
{
    expect_string(__wrap_ground_key_open, path, path);
    will_return(__wrap_ground_key_open, is_good);
    if (is_good) {
        expect_function_call(__wrap_ground_key_close);
        will_return(__wrap_launcher_set_limits, false); // The preparation ends here.
    }
}

static void the_path_of_the_key_is_relative_to_the_mission_or_absolute(void** state)
{
    static const char* const paths[][2] = {
        {"ground.key", "descriptors/missions/ground.key"},
        {"k/ground.key", "descriptors/missions/k/ground.key"}, // A slash is the second character.
        {"/k", "/k"},
        {"//k", "//k"},
    };
    (void)state;
    for (size_t i = 0U; i < (sizeof paths / sizeof paths[0]); i++) {
        named_key = paths[i][0];
        expect_key(paths[i][1], true);
        prepare_fails("");
        assert_string_equal(paths[i][1], launcher.key_path);
    }
}

static void the_key_of_the_command_line_replaces_that_of_the_mission(void** state)
{
    (void)state;
    named_key   = "/mission.key";
    options.key = "other.key";
    expect_key("other.key", true);
    prepare_fails("");
}

static void a_key_that_cannot_be_opened_ends_the_preparation(void** state)
{
    (void)state;
    options.key = "other.key";
    expect_key("other.key", false);
    prepare_fails("damaged key");
}

static void a_path_of_the_key_with_more_than_255_characters_is_refused(void** state)
{
    static char path[257];
    (void)state;
    (void)memset(path, 'k', 255U);
    options.key = path;
    expect_key(path, true);
    prepare_fails("");
    path[255] = 'k';
    assert_false(launcher_prepare(&launcher, &options, "bin/"));
    assert_non_null(
        strstr(launcher.reason, "the path of the ground link's key has more than 255 characters: k"));
}

// ---- Directory ----

static void expect_directory(const char* const path, const bool is_used)
{
    expect_string(__wrap_osal_file_exists, path, path);
    will_return(__wrap_osal_file_exists, is_used);
}

static void expect_made(const char* const path, const status_t status)
{
    expect_string(__wrap_osal_file_create_directory, path, path);
    will_return(__wrap_osal_file_create_directory, status);
}

/// The first directory that does not exist, named by scenario, form and seed.
static void a_directory_that_is_not_given_is_named_by_the_run(void** state)
{
    (void)state;
    will_return_count(__wrap_launcher_set_limits, true, 3);
    expect_directory("runs/press-processes-7-001", true);
    expect_directory("runs/press-processes-7-002", false);
    expect_made("runs/press-processes-7-002", STATUS_DENIED);
    prepare_fails(
        "cannot create the output directory runs/press-processes-7-002; choose another one with --out");
    options.scenario = "my/own.scn";
    options.is_image = true;
    expect_directory("runs/own-image-7-001", false);
    expect_made("runs/own-image-7-001", STATUS_DENIED);
    prepare_fails("cannot create the output directory runs/own-image-7-001; choose another one with --out");
    options.scenario = "none";
    expect_directory("runs/none-image-7-001", false);
    expect_made("runs/none-image-7-001", STATUS_DENIED);
    prepare_fails("cannot create the output directory runs/none-image-7-001; choose another one with --out");
}

static void a_scenario_that_is_not_given_has_the_name_of_the_mission_or_is_telepresence(void** state)
{
    (void)state;
    will_return_count(__wrap_launcher_set_limits, true, 2);
    options.scenario = "";
    has_own_scenario = true;
    expect_directory("runs/rokviss-processes-7-001", false);
    expect_made("runs/rokviss-processes-7-001", STATUS_DENIED);
    prepare_fails(
        "cannot create the output directory runs/rokviss-processes-7-001; choose another one with --out");
    has_own_scenario = false;
    expect_directory("runs/telepresence-processes-7-001", false);
    expect_made("runs/telepresence-processes-7-001", STATUS_DENIED);
    prepare_fails("cannot create the output directory runs/telepresence-processes-7-001; choose another one "
                  "with --out");
}

// ---- Port of the ground ----

static void make_the_directories(void)
{
    static char storage[64];
    options.output = directory;
    (void)snprintf(storage, sizeof storage, "%s/storage", directory);
    will_return(__wrap_launcher_set_limits, true);
    expect_made(directory, STATUS_OK);
    expect_made(storage, STATUS_OK);
}

static void begin_in_the_directory(void)
{
    make_the_directories();
    will_return(__wrap_osal_shm_create, STATUS_OK);
    expect_function_call(__wrap_osal_shm_close);
    will_return(__wrap_launcher_open_sockets, true);
}

static void expect_listen(const uint16_t port, const status_t status)
{
    expect_value(__wrap_osal_tcp_listen, port, port);
    will_return(__wrap_osal_tcp_listen, status);
}

static void the_first_port_that_is_free_is_that_of_the_ground(void** state)
{
    char path[96];
    char line[16] = "";
    (void)state;
    begin_in_the_directory();
    expect_listen(10015U, STATUS_EXISTS);
    expect_listen(10016U, STATUS_EXISTS);
    expect_listen(10017U, STATUS_OK);
    assert_true(launcher_prepare(&launcher, &options, "bin/"));
    assert_string_equal("", launcher.reason);
    assert_int_equal(10017U, run.ground_port);
    assert_int_equal(33, run.ground_descriptor);
    (void)snprintf(path, sizeof path, "%s/ground.port", directory);
    FILE* const file = fopen(path, "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_int_equal(0, fclose(file));
    assert_string_equal("10017\n", line);
    char classes[32];
    (void)snprintf(path, sizeof path, "%s/ground.classes", directory);
    FILE* const hash = fopen(path, "r");
    assert_non_null(hash);
    assert_non_null(fgets(classes, sizeof classes, hash));
    assert_int_equal(0, fclose(hash));
    assert_true(strtoull(classes, NULL, 0) == DEVICE_CLASSES_HASH);
    assert_string_equal("udp", launcher.options.transport);
    assert_int_equal(launcher.mission.subsystem_count, run.component_count);
    assert_null(launcher.scheduler); // Each process has a clock of its own.
}

/// The file of the storage that names its mission.
static void put_owner(const char* const mission)
{
    char path[96];
    (void)snprintf(path, sizeof path, "%s/storage", directory);
    assert_int_equal(0, mkdir(path, 0755));
    (void)snprintf(path, sizeof path, "%s/storage/mission", directory);
    FILE* const file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(mission, file) >= 0);
    assert_int_equal(0, fclose(file));
}

static void the_storage_of_another_mission_is_refused(void** state)
{
    char expected[256];
    (void)state;
    put_owner("rokvis");
    make_the_directories();
    (void)snprintf(
        expected, sizeof expected,
        "the storage is that of another mission: %s/storage/mission contains 'rokvis', expected 'rokviss'; "
        "choose another directory with --storage, or fly that mission with --mission",
        directory);
    prepare_fails(expected);
}

static void the_storage_of_this_mission_is_used(void** state)
{
    (void)state;
    put_owner("rokviss");
    begin_in_the_directory();
    expect_listen(10015U, STATUS_OK);
    assert_true(launcher_prepare(&launcher, &options, "bin/"));
}

static void a_port_that_was_asked_for_and_is_in_use_is_refused(void** state)
{
    (void)state;
    options.port = 20000U;
    begin_in_the_directory();
    expect_listen(20000U, STATUS_EXISTS);
    prepare_fails("the ground port is in use on 127.0.0.1:20000; choose another one with --port");
}

static void another_problem_of_the_port_is_no_reason_to_try_the_next(void** state)
{
    (void)state;
    begin_in_the_directory();
    expect_listen(10015U, STATUS_DENIED);
    prepare_fails("cannot listen on 127.0.0.1:10015: permission denied");
}

// ---- Scheduler and links ----

/// The scheduler waits for the first life of each participant, and for no operator if there is none.
static void prepare_stepped(const char* const scenario, const char* const links)
{
    unsigned supervisor = 0U;
    options.is_free     = false;
    options.is_stepped  = true;
    options.scenario    = scenario;
    options.links       = links;
    begin_in_the_directory();
    will_return(__wrap_osal_shm_create, STATUS_OK);
    expect_value(__wrap_osal_lockstep_create, is_shared, true);
    expect_listen(10015U, STATUS_OK);
    for (unsigned i = 0U; i < run_operator(&run); i++) {
        expect_value(__wrap_osal_lockstep_expect, participant, i);
    }
    if (strcmp(scenario, "none") != 0) {
        expect_value(__wrap_osal_lockstep_expect, participant, run_operator(&run));
    }
    assert_true(run_state_find(&run, 1U, &supervisor));
    expect_value(__wrap_osal_lockstep_set_succession, participant, run_participant(supervisor));
    assert_true(launcher_prepare(&launcher, &options, "bin/"));
    assert_string_equal("", launcher.reason);
    assert_ptr_equal(&run, launcher.scheduler);
}

/// The number of participants depends on the mission, which the first preparation reads.
static void read_the_mission(void)
{
    begin_in_the_directory();
    expect_listen(10015U, STATUS_OK);
    assert_true(launcher_prepare(&launcher, &options, "bin/"));
}

static void the_scheduler_waits_for_each_participant(void** state)
{
    (void)state;
    read_the_mission();
    prepare_stepped("press", "udp");
    assert_int_equal(1U << (unsigned)RTLINK_METHOD_UDP, run.link_methods);
}

static void no_operator_is_expected_without_a_scenario(void** state)
{
    (void)state;
    read_the_mission();
    prepare_stepped("none", "shm");
    assert_int_equal(1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY, run.link_methods);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_mission_that_is_missing_is_named, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_limit_that_is_too_low_ends_the_preparation, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_path_of_the_key_is_relative_to_the_mission_or_absolute, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(the_key_of_the_command_line_replaces_that_of_the_mission, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_key_that_cannot_be_opened_ends_the_preparation, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_path_of_the_key_with_more_than_255_characters_is_refused, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_directory_that_is_not_given_is_named_by_the_run, set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            a_scenario_that_is_not_given_has_the_name_of_the_mission_or_is_telepresence, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_first_port_that_is_free_is_that_of_the_ground, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_storage_of_another_mission_is_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_storage_of_this_mission_is_used, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_port_that_was_asked_for_and_is_in_use_is_refused, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(another_problem_of_the_port_is_no_reason_to_try_the_next, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(the_scheduler_waits_for_each_participant, set_up, tear_down),
        cmocka_unit_test_setup_teardown(no_operator_is_expected_without_a_scenario, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
