// SPDX-License-Identifier: Apache-2.0
// Devices of a file on buses of their own: refusals with file and line, and the devices on the bus.
#include "sim/app/bench_devices.h"
#include "sim/app/segment.h"
#include "test/support/bounds.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[] = "/tmp/hirosco-bench-XXXXXX";
static segment_t segments[2];
static bench_devices_t* bench_devices;
static char error[SIMULATOR_ERROR_MAX];
static unsigned told;
static unsigned heard[0x800];

static void changed(void* context, uint64_t now_ns, const truth_drive_t* drive)
{
    (void)context;
    (void)now_ns;
    told += (strcmp(drive->bus, "gripper") == 0) ? 1U : 0U;
}

static void on_frame(void* context, const osal_can_frame_t* frame)
{
    (void)context;
    heard[frame->id % 0x800U]++;
}

void setUp(void)
{
    static const char* const names[2] = {"robot", "gripper"};
    for (unsigned i = 0U; i < 2U; i++) {
        const segment_config_t config = {.name = names[i], .seed = 1U};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_open(&segments[i], &config, error));
    }
    memset(heard, 0, sizeof heard);
    told = 0U;
}

void tearDown(void)
{
    bench_devices_close(bench_devices);
    bench_devices = NULL;
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_close(&segments[i]));
    }
}

static status_t open_text(const char* text)
{
    FILE* out = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(out);
    (void)fputs(text, out);
    (void)fclose(out);
    const bench_devices_config_t config = {.path          = path,
                                           .devices_path  = "descriptors/devices",
                                           .segments      = segments,
                                           .segment_count = 2U,
                                           .changed       = changed};
    error[0]                            = '\0';
    return bench_devices_open(&config, &bench_devices, error);
}

static void expect_refusal(const char* text, unsigned line, const char* words)
{
    char place[64];
    (void)snprintf(place, sizeof place, "%s:%u: found ", path, line);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, open_text(text));
    TEST_ASSERT_NULL(bench_devices);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, place), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void mistakes_are_reported_with_file_line_value_and_expectation(void)
{
    expect_refusal("griper 0x31 joint-drive 0 0\n", 1U,
                   "'griper', expected a bus of the mission: robot gripper");
    expect_refusal("# a comment\n\ngripper\n", 3U,
                   "'the end of the line', expected <bus> <node> joint-drive");
    expect_refusal("gripper 0x31 joint-drive 0\n", 1U, "'the end of the line', expected <bus>");
    expect_refusal("gripper 0x31 joint-drive 0 0 0\n", 1U, "expected nothing behind the fifth word");
    expect_refusal("gripper 1 joint-drive 0 0\n", 1U, "'1', expected a node id from 2 to 127");
    expect_refusal("gripper 128 joint-drive 0 0\n", 1U, "'128', expected a node id");
    expect_refusal("gripper 0x3g joint-drive 0 0\n", 1U, "'0x3g', expected a node id");
    expect_refusal("gripper 5 lamp 0 0\n", 1U, "'lamp', expected joint-drive");
    expect_refusal("gripper 5 joint-drive far 0\n", 1U, "'far', expected an angle");
    expect_refusal("gripper 5 joint-drive nan 0\n", 1U, "'nan', expected an angle");
    expect_refusal("gripper 5 joint-drive 0 -1\n", 1U, "'-1', expected a stiffness");
    expect_refusal("gripper 5 joint-drive 0 0\ngripper 5 joint-drive 0 0\n", 2U,
                   "'5', expected a node id that no");
}

static void a_missing_file_of_the_bench_is_reported(void)
{
    const bench_devices_config_t nowhere = {.path = "/nowhere/bench.txt", .segments = segments};
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, bench_devices_open(&nowhere, &bench_devices, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere/bench.txt"));
    const bench_devices_config_t no_sheet = {
        .path = path, .devices_path = "/nowhere", .segments = segments, .segment_count = 2U};
    (void)open_text("");
    bench_devices_close(bench_devices);
    FILE* out = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(out);
    (void)fputs("gripper 5 joint-drive 0 0\n", out);
    (void)fclose(out);
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, bench_devices_open(&no_sheet, &bench_devices, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere/joint-drive.eds"));
}

static void too_many_devices_are_refused(void)
{
    char text[1024] = "";
    for (unsigned i = 0U; i < 17U; i++) {
        (void)snprintf(&text[strlen(text)], sizeof text - strlen(text), "gripper %u joint-drive 0 0\n",
                       2U + i);
    }
    expect_refusal(text, 17U, "at most 16 devices");
}

static void a_device_boots_on_its_bus_and_is_reported(void)
{
    unsigned node                   = 0U;
    const bus_callbacks_t listening = {.on_frame = on_frame};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(segments[1].bus, &listening, &node));
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK, open_text("gripper 0x31 joint-drive 0.6 400 # the motor\nrobot 7 joint-drive 0 0\n"));
    bench_devices_power_on(bench_devices);
    for (uint64_t now_ns = 0U; now_ns < 100000000U; now_ns += 500000U) {
        bus_run_until(segments[0].bus, now_ns + 500000U);
        bus_run_until(segments[1].bus, now_ns + 500000U);
        bench_devices_move(bench_devices, now_ns, now_ns + 500000U);
    }
    TEST_ASSERT_TRUE(heard[0x731] > 1U);      // Boot-up and heartbeats.
    TEST_ASSERT_EQUAL_UINT(0U, heard[0x707]); // That device is on the other bus.
    const unsigned before = told;
    bench_devices_report(bench_devices, 100000000U);
    TEST_ASSERT_EQUAL_UINT(before + 1U, told);
}

static void a_mission_without_bench_devices_is_accepted(void)
{
    bench_devices_power_on(NULL);
    bench_devices_report(NULL, 0U);
    bench_devices_move(NULL, 0U, 500000U);
    bench_devices_close(NULL);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, open_text("\n# nothing but a comment\n"));
}

int main(void)
{
    const int file = mkstemp(path);
    if (file >= 0) {
        (void)close(file);
    }
    UNITY_BEGIN();
    RUN_TEST(mistakes_are_reported_with_file_line_value_and_expectation);
    RUN_TEST(a_missing_file_of_the_bench_is_reported);
    RUN_TEST(too_many_devices_are_refused);
    RUN_TEST(a_device_boots_on_its_bus_and_is_reported);
    RUN_TEST(a_mission_without_bench_devices_is_accepted);
    (void)unlink(path);
    return UNITY_END();
}
