// SPDX-License-Identifier: Apache-2.0
// run.json of a run, octet by octet, and what makes a run not reproducible.
#define _GNU_SOURCE
#include "launcher/run_summary.h"

#include "base/version.h"
#include "fsw/canopen/device_profile.h"
#include "launcher/launcher_guard.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static launcher_t launcher;
static run_state_t run;
static char text[16384];

static const char* path_of(const char* const name)
{
    static char path[LAUNCH_PATH_MAX + 32U];
    (void)snprintf(path, sizeof path, "%s/%s", run.directory, name);
    return path;
}

static void put(const char* const name, const char* const content)
{
    FILE* const file = fopen(path_of(name), "w");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_TRUE(fputs(content, file) >= 0);
    TEST_ASSERT_EQUAL(0, fclose(file));
}

static const char* written(void)
{
    TEST_ASSERT_TRUE(run_summary_write(&launcher));
    FILE* const file = fopen(path_of("run.json"), "r");
    TEST_ASSERT_NOT_NULL(file);
    const size_t size = fread(text, 1U, sizeof text - 1U, file);
    text[size]        = '\0';
    TEST_ASSERT_EQUAL(0, fclose(file));
    return text;
}

void setUp(void)
{
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    (void)strcpy(run.directory, "/tmp/run-summary-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(run.directory));
    launcher.run                        = &run;
    launcher.options                    = (launch_options_t){.mission       = "rokviss",
                                                             .scenario      = "press",
                                                             .world         = "rokviss",
                                                             .seed          = 7U,
                                                             .is_stepped    = true,
                                                             .transport     = "udp",
                                                             .links         = "shm",
                                                             .computers     = 1U,
                                                             .remote_endian = "",
                                                             .rtos          = ""};
    launcher.mission.interface_hash     = 0x0123456789ABCDEFULL;
    launcher.mission.configuration_hash = 1U;
    // Only the existence of a scheduler matters.
    launcher.scheduler = (osal_lockstep_t*)&run;
    TEST_ASSERT_TRUE(run_summary_reserve(&launcher));
    TEST_ASSERT_NOT_EQUAL(0, access(path_of("run.json"), F_OK)); // The room is reserved in run.json.part.
}

void tearDown(void)
{
    static const char* const names[] = {"run.json", "run.json.part", "live.scn"};
    for (unsigned i = 0U; i < 3U; i++) {
        (void)unlink(path_of(names[i]));
    }
    TEST_ASSERT_EQUAL(0, rmdir(run.directory)); // The directory has no other files.
}

static void the_summary_of_a_run_has_this_text(void)
{
    static guard_t guard = {.starts = 1U};
    char hash[19];
    char expected[4096];
    launcher.guard              = &guard;
    launcher.first_wall_ns      = 1000000000ULL;
    launcher.last_wall_ns       = 3000000000ULL;
    launcher.first_simulated_ns = 500000000ULL;
    launcher.last_simulated_ns  = 5012345678ULL;
    launcher.exit_code          = 1;
    (void)strcpy(launcher.reason, "it said \"no\\yes\"\n");
    launcher.child_count = 2U;
    launcher.children[0] =
        (child_t){.name = "simulator", .result = {.has_ended = true, .code = 3}, .memory_high_kib = 1234U};
    launcher.children[1]         = (child_t){.name            = "arm",
                                             .result          = {.has_ended = true, .was_signalled = true, .code = 9},
                                             .memory_high_kib = 5U,
                                             .is_component    = true,
                                             .component       = 1U};
    run.components[1].found_life = 4U;
    launcher.memory_limit_kib[1] = 77U;
    (void)snprintf(hash, sizeof hash, "0x%016llX", (unsigned long long)DEVICE_CLASSES_HASH);
    (void)snprintf(
        expected, sizeof expected,
        "{\n \"mission\": \"rokviss\",\n \"scenario\": \"press\",\n \"world\": \"rokviss\",\n \"seed\": 7,\n"
        " \"form\": \"processes\",\n \"time\": \"stepped\",\n \"bus\": \"shm\",\n \"transport\": \"udp\",\n"
        " \"nodes\": 1,\n \"links\": \"shm\",\n \"interface_hash\": \"0x0123456789ABCDEF\",\n"
        " \"configuration_hash\": \"0x0000000000000001\",\n \"device_classes_hash\": \"%s\",\n"
        " \"simulated_s\": 5.012,\n \"wall_s\": 2.000,\n \"real_time_factor\": 2.256,\n"
        " \"reproducible\": true,\n \"cut_short\": false,\n \"exit_code\": 1,\n"
        " \"exit_reason\": \"it said  no yes  \",\n \"bus_frames_late\": 0,\n \"bus_frames_lost\": 0,\n"
        " \"bus_frames_external\": 0,\n \"bus_interfaces_lost\": 0,\n"
        " \"versions\": {\"hirosco\": \"" HIROSCO_VERSION "\", \"compiler\": \"" __VERSION__ "\"},\n"
        " \"processes\": [\n  {\"name\": \"simulator\", \"exit_code\": 3, \"memory_high_kib\": 1234},\n"
        "  {\"name\": \"arm\", \"signal\": 9, \"memory_high_kib\": 5, \"starts\": 4, "
        "\"memory_limit_kib\": 77}]\n}\n",
        hash);
    TEST_ASSERT_EQUAL_STRING(expected, written());
    TEST_ASSERT_NOT_EQUAL(0, access(path_of("run.json.part"), F_OK));
}

static void expect(const char* const words)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(written(), words), words);
}

static void expect_without(const char* const words)
{
    TEST_ASSERT_NULL_MESSAGE(strstr(written(), words), words);
}

/// Each of these conditions alone, and none of them.
static void each_loss_intrusion_or_early_end_makes_a_run_not_reproducible(void)
{
    static uint32_t* const counts[] = {&run.is_intruded, &launcher.lost_frames, &launcher.external_frames,
                                       &launcher.bus_cuts, &run.is_lossy};
    static bool* const flags[]      = {&launcher.is_undetermined, &launcher.is_cut_short};
    launcher.late_frames            = 8U; // Late frames change nothing.
    expect("\"reproducible\": true");
    for (unsigned i = 0U; i < (sizeof counts / sizeof counts[0]); i++) {
        *counts[i] = 1U;
        expect("\"reproducible\": false");
        *counts[i] = 0U;
    }
    for (unsigned i = 0U; i < (sizeof flags / sizeof flags[0]); i++) {
        *flags[i] = true;
        expect("\"reproducible\": false");
        *flags[i] = false;
    }
    launcher.options.is_stepped = false;
    expect("\"reproducible\": false");
    launcher.options.is_stepped = true;
    expect("\"reproducible\": true");
}

static void an_image_has_no_transport_and_reports_the_counters_of_buses(void)
{
    launcher.options.is_image = true;
    launcher.late_frames      = 1U;
    launcher.lost_frames      = 2U;
    launcher.external_frames  = 3U;
    launcher.bus_cuts         = 4U;
    expect("\"form\": \"image\"");
    expect("\"transport\": \"ring\"");
    expect("\"bus_frames_late\": 1,\n \"bus_frames_lost\": 2,\n \"bus_frames_external\": 3,\n "
           "\"bus_interfaces_lost\": 4");
}

static void late_steps_are_reported_if_each_process_has_its_own_clock(void)
{
    launcher.child_count = 1U;
    launcher.children[0] = (child_t){.name = "arm", .is_component = true};
    for (uint32_t i = 0U; i < RUN_LATENESS; i++) {
        run.beats[0].late[i] = i + 10U;
    }
    expect_without("late_steps");
    launcher.scheduler = NULL;
    expect(", \"starts\": 0, \"late_steps\": [10, 11, 12, 13, 14], \"memory_limit_kib\": 0}");
}

/// The file is read in pieces of 4096 octets; octets of the piece before do not count again.
static void each_line_of_the_live_port_counts_once(void)
{
    static char lines[4096U + 3U];
    (void)memset(lines, '\n', sizeof lines - 2U);
    lines[sizeof lines - 2U] = 'x';
    put("live.scn", lines);
    expect("\"live_lines\": 4097,");
}

static void only_runs_with_an_optional_part_report_it(void)
{
    static guard_t guard = {.starts = 3U};
    expect_without("remote_endian");
    expect_without("rtos");
    expect_without("relay");
    expect_without("guards");
    expect_without("live_lines");
    expect_without("wall_s"); // Simulated time has not moved.
    launcher.guard                 = &guard;
    launcher.options.remote_endian = "ARM";
    put("live.scn", "1.0 hand rest\n2.0 fault kill arm\n");
    launcher.options.rtos = "ARM,GRIPPER";
    expect("\"remote_endian\": \"ARM\"");
    expect("\"rtos\": \"ARM,GRIPPER\"");
    expect("\"guards\": 3");
    expect("\"cut_short\": false,\n \"live_lines\": 2,\n \"exit_code\"");
    launcher.options.delay_ms = 100U;
    run.relay.delayed         = 5U;
    run.relay.lost            = 6U;
    run.relay.reordered       = 7U;
    expect("\"relay\": {\"round_trip_ms\": 100, \"delayed\": 5, \"lost\": 6, \"reordered\": 7}");
    run.relay.is_network = true;
    expect("\"relay\": {\"round_trip_ms\": 100, \"network\": true}");
}

/// If less than a millisecond of wall-clock time has passed, there is no speed factor.
static void a_run_that_took_no_time_has_no_real_time_factor(void)
{
    launcher.first_wall_ns = 1U;
    launcher.last_wall_ns  = 1000000U;
    expect("\"wall_s\": 0.000");
    expect_without("real_time_factor");
    launcher.last_wall_ns      = 1000001U;
    launcher.last_simulated_ns = 3000000U;
    expect("\"real_time_factor\": 3.000");
}

static void a_summary_that_cannot_be_written_is_reported(void)
{
    TEST_ASSERT_EQUAL(0, mkdir(path_of("run.json"), 0700));
    TEST_ASSERT_FALSE(run_summary_write(&launcher));
    TEST_ASSERT_EQUAL(0, rmdir(path_of("run.json")));
    static char name[9000];
    (void)memset(name, 'x', sizeof name - 1U); // Longer than the buffer of the name.
    launcher.child_count      = 1U;
    launcher.children[0].name = name;
    TEST_ASSERT_FALSE(run_summary_write(&launcher));
    TEST_ASSERT_NOT_EQUAL(0, access(path_of("run.json"), F_OK));
    launcher.child_count = 0U;
    char directory[RUN_PATH_MAX];
    (void)strcpy(directory, run.directory);
    (void)strcpy(run.directory, "/dev/null/none");
    TEST_ASSERT_FALSE(run_summary_reserve(&launcher));
    TEST_ASSERT_FALSE(run_summary_write(&launcher));
    (void)strcpy(run.directory, directory);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_summary_of_a_run_has_this_text);
    RUN_TEST(each_loss_intrusion_or_early_end_makes_a_run_not_reproducible);
    RUN_TEST(an_image_has_no_transport_and_reports_the_counters_of_buses);
    RUN_TEST(late_steps_are_reported_if_each_process_has_its_own_clock);
    RUN_TEST(each_line_of_the_live_port_counts_once);
    RUN_TEST(only_runs_with_an_optional_part_report_it);
    RUN_TEST(a_run_that_took_no_time_has_no_real_time_factor);
    RUN_TEST(a_summary_that_cannot_be_written_is_reported);
    return UNITY_END();
}
