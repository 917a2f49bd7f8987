// SPDX-License-Identifier: Apache-2.0
// The fault lines of a scenario: verbs, errors with their lines, and effects.
#include "sim/app/faults.h"
#include "sim/devices/joystick.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static faults_t faults;
static fault_world_t world;
static joystick_t* joystick;
static bus_t* elsewhere; // Bus of the devices; only the flight software has controllers on the others.
static char error[SCENARIO_ERROR_MAX];
static char path[] = "/tmp/hirosco-scn-XXXXXX";

static void set_drive_error(void* model, uint16_t code, bool is_present, uint64_t now_ns)
{
    drive_set_error(model, code, is_present, now_ns);
}

static void set_joystick_error(void* model, uint16_t code, bool is_present, uint64_t now_ns)
{
    joystick_set_error(model, code, is_present, now_ns);
}

/// Bus robot has two channels with a controller of the flight software on each, and two drives. Bus joystick
/// has a joystick, no controller of the flight software, and no channel B.
static void open_world(void)
{
    static const char* const names[2][2] = {{"robot", "robot-b"}, {"joystick", "joystick-b"}};
    const bus_config_t config            = {.nominal_bit_rate = 1000000U, .seed = 1U};
    const bus_callbacks_t silent         = {.context = NULL};
    const drive_config_t wanted          = {.step_ns = 500000U, .substep_ns = 125000U};
    char reason[EDS_ERROR_MAX];
    memset(&world, 0, sizeof world);
    for (unsigned i = 0U; i < 2U; i++) {
        world.channel[0][i].name = names[0][i];
        world.channel[1][i].name = names[1][i];
        world.channel[0][i].bus  = bus_create(&config);
        TEST_ASSERT_EQUAL_INT(
            STATUS_OK, bus_add_node(world.channel[0][i].bus, &silent, &world.channel[0][i].flight_node));
    }
    world.channel[1][0].bus         = bus_create(&config);
    world.channel[1][0].flight_node = BUS_NODES_MAX;
    world.channel[1][1].flight_node = BUS_NODES_MAX;
    elsewhere                       = bus_create(&config);
    world.device[0]                 = (fault_device_t){.name = "JOINT1", .id = 0x11U};
    world.device[1]                 = (fault_device_t){.name = "JOINT2", .id = 0x12U};
    world.device[2]                 = (fault_device_t){.name = "STICK", .bus = 1U, .id = 0x21U};
    world.device_count              = 3U;
    for (uint8_t i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK,
                              drive_create(elsewhere, "descriptors/devices/joint-drive.eds",
                                           (uint8_t)(0x11U + i), &wanted, &world.device[i].drive, reason));
        world.device[i].node      = drive_node(world.device[i].drive);
        world.device[i].model     = world.device[i].drive;
        world.device[i].set_error = set_drive_error;
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, joystick_create(elsewhere, "descriptors/devices/joystick.eds", 0x21U,
                                                     &(joystick_config_t){.encoder = {.counts_per_turn = 1U}},
                                                     &joystick, reason));
    world.device[2].node      = joystick_node(joystick);
    world.device[2].model     = joystick;
    world.device[2].set_error = set_joystick_error;
}

static void close_world(void)
{
    drive_destroy(world.device[0].drive);
    drive_destroy(world.device[1].drive);
    joystick_destroy(joystick);
    bus_destroy(elsewhere);
    bus_destroy(world.channel[0][0].bus);
    bus_destroy(world.channel[0][1].bus);
    bus_destroy(world.channel[1][0].bus);
}

void setUp(void)
{
    open_world();
    memcpy(path, "/tmp/hirosco-scn-XXXXXX", sizeof path);
    const int file = mkstemp(path);
    TEST_ASSERT_TRUE(file >= 0);
    (void)close(file);
}

void tearDown(void)
{
    close_world();
    faults_free(&faults);
    (void)unlink(path);
}

static const fault_t* fault_at(const size_t index)
{
    return &((const fault_t*)faults.record)[index];
}

static status_t load(const char* text)
{
    FILE* file = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    (void)fclose(file);
    faults_free(&faults);
    return faults_load(&faults, &world, path, error);
}

static void the_faults_of_a_scenario_are_read(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK,
                                  load("# times in seconds\n"
                                       "1 hand rest\n"
                                       "1 operator ping all\n"
                                       "2.5 fault unplug joystick\n"
                                       "2.500125 fault unplug robot JOINT1\n"
                                       "3 fault plug robot 0x12\n"
                                       "4 fault loss robot 0.001\n"
                                       "4 fault corruption joystick 1\n"
                                       "4 fault duplication joystick 0\n"
                                       "5 fault delay robot JOINT2 120\n"
                                       "5 fault babble joystick STICK on\n"
                                       "5 fault stuck robot off\n"
                                       "6 fault reset joystick 0x21\n"
                                       "6 fault error robot 0x11 0x4310 on\n"
                                       "7 fault torque-offset JOINT2 -0.5\n"
                                       "8 fault temperature JOINT1 90\n"
                                       "9 fault unplug robot FLIGHT\n"),
                                  error);
    TEST_ASSERT_EQUAL_UINT(14U, faults.count);
    TEST_ASSERT_EQUAL_UINT64(2500000000U, faults_next_ns(&faults));
    TEST_ASSERT_EQUAL_INT(FAULT_UNPLUG, fault_at(0)->kind);
    TEST_ASSERT_EQUAL_INT(FAULT_DEVICE_ALL, fault_at(0)->device);
    TEST_ASSERT_EQUAL_UINT(1U, fault_at(0)->bus);
    TEST_ASSERT_EQUAL_STRING("joystick", fault_at(0)->target);
    TEST_ASSERT_EQUAL_UINT64(2500125000U, fault_at(1)->time_ns);
    TEST_ASSERT_EQUAL_STRING("robot JOINT1", fault_at(1)->target);
    TEST_ASSERT_EQUAL_INT(1U, fault_at(2)->device);
    TEST_ASSERT_FALSE(fault_is_onset(fault_at(2)));
    TEST_ASSERT_TRUE(fault_is_onset(fault_at(3)));
    TEST_ASSERT_FALSE(fault_is_onset(fault_at(5)));
    TEST_ASSERT_EQUAL_HEX16(0x4310U, fault_at(10)->code);
    TEST_ASSERT_EQUAL_STRING("temperature", fault_word(fault_at(12)->kind));
    TEST_ASSERT_EQUAL_INT(FAULT_DEVICE_FLIGHT, fault_at(13)->device);
}

static void expect_error(const char* line, const char* words)
{
    char text[256];
    char begin[64];
    (void)snprintf(text, sizeof text, "# first line\n%s\n", line);
    (void)snprintf(begin, sizeof begin, "%s:2: ", path);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, load(text));
    if ((strncmp(error, begin, strlen(begin)) != 0) || (strstr(error, words) == NULL)) {
        TEST_ASSERT_EQUAL_STRING(words, error);
    }
}

static void a_message_says_if_the_world_has_no_part_of_the_named_kind(void)
{
    const fault_world_t whole = world;
    world                     = (fault_world_t){.instrument_count = whole.instrument_count};
    memcpy(world.instrument, whole.instrument, sizeof world.instrument);
    expect_error("1 fault loss robot 0.5", "found 'robot', expected a bus of the run, but there is none");
    expect_error("1 fault torque-offset JOINT1 1", "found 'JOINT1', expected a drive, but there is none");
    world.instrument_count = 0U;
    expect_error("1 fault silent EYE on",
                 "found 'EYE', expected an instrument of the world, but there is none");
    expect_error("1 fault unplug robot", "expected a bus or an instrument of the run, but there is none");
    world = whole;
}

static void errors_name_file_line_and_expected_value(void)
{
    expect_error("1 fault unplugg joystick", "unplug, plug");
    expect_error("1 fault unplugg joystick", "kill, hang or resume"); // The end of the list.
    expect_error("1 fault unplug wheel", "a bus or an instrument of the run: robot joystick");
    expect_error("1 fault unplug robot JOINT3", "a device of this bus, or its id: JOINT1 JOINT2 FLIGHT");
    expect_error("1 fault unplug robot STICK", "JOINT1 JOINT2 FLIGHT");
    expect_error("1 fault unplug", "unplug <bus> [node]");
    expect_error("1 fault unplug robot JOINT1 now", "unplug <bus> [node]");
    expect_error("1 fault loss robot", "loss <bus>");
    expect_error("1 fault loss robot 1.5", "probability");
    expect_error("1 fault loss robot much", "probability");
    expect_error("1 fault stuck robot yes", "on or off");
    expect_error("1 fault error robot 0x11 0x0 on", "emergency code");
    expect_error("1 fault error robot 0x11 0x12345 on", "emergency code");
    expect_error("1 fault torque-offset STICK 1", "a drive: JOINT1 JOINT2");
    expect_error("1 fault torque-offset FLIGHT 1", "a drive: JOINT1 JOINT2");
    expect_error("1 fault delay robot JOINT1 -5", "delay");
    expect_error("1 fault unplug robot-b JOINT1", "a bus or an instrument of the run: robot joystick");
    expect_error("1 fault cut robot-c", "robot joystick robot-b joystick-b");
    expect_error("1 fault overflow robot JOINT1 0", "number of frames");
    expect_error("1 fault sync robot JOINT1 33", "number of frames");
    expect_error("1 fault restart robot FLIGHT later", "auto, order or now");
    expect_error("1 fault kill", "kill <process>");
    expect_error("1 fault kill a-name-that-is-as-long-as-no-process-of-a-run-has-it", "process in run.json");
}

static void without_a_scenario_there_are_no_faults(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_OK, faults_load(&faults, &world, NULL, error));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, faults_next_ns(&faults));
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, faults_load(&faults, &world, "/nowhere.scn", error));
}

static void scenarios_of_the_mission_are_read(void)
{
    static const char* const scenarios[] = {
        "sim/scenarios/telepresence.scn", "sim/scenarios/commissioning.scn", "sim/scenarios/standalone.scn"};
    for (unsigned i = 0U; i < 3U; i++) {
        faults_free(&faults);
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, faults_load(&faults, &world, scenarios[i], error), error);
    }
}

static void apply_next(void)
{
    (void)faults_apply_next(&faults, &world);
}

static void faults_of_a_scenario_act_on_the_bus(void)
{
    bus_t* bus = world.channel[0][0].bus;
    TEST_ASSERT_EQUAL_INT(STATUS_OK,
                          load("1 fault unplug robot FLIGHT\n2 fault plug robot FLIGHT\n"
                               "3 fault babble robot FLIGHT on\n4 fault unplug joystick FLIGHT\n"));
    apply_next();
    TEST_ASSERT_FALSE(bus_is_plugged(bus, 0U));
    TEST_ASSERT_FALSE(bus_is_plugged(world.channel[0][1].bus, 0U)); // Unplugging disconnects both channels.
    apply_next();
    TEST_ASSERT_TRUE(bus_is_plugged(bus, 0U));
    TEST_ASSERT_TRUE(bus_is_plugged(world.channel[0][1].bus, 0U));
    apply_next();
    bus_run_until(bus, 1000000U);
    // It babbles, and no node acknowledges its frames.
    TEST_ASSERT_GREATER_THAN_UINT64(0U, bus_statistics(bus)->errors);
    // The flight software has no node on this bus.
    TEST_ASSERT_EQUAL_STRING("joystick FLIGHT", faults_apply_next(&faults, &world)->target);
}

static void count_sync(void* context, const osal_can_frame_t* frame)
{
    unsigned* const count = context;
    *count += ((frame->id == 0x80U) && (frame->length == 0U)) ? 1U : 0U;
}

static void a_node_sends_the_commanded_number_of_sync_frames(void)
{
    bus_t* bus                      = world.channel[0][0].bus;
    unsigned count                  = 0U;
    unsigned listener               = 0U;
    const bus_callbacks_t callbacks = {.on_frame = count_sync, .context = &count};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &callbacks, &listener));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, load("1 fault sync robot FLIGHT 1\n2 fault sync robot FLIGHT 32\n"
                                          "3 fault sync joystick FLIGHT 1\n"));
    TEST_ASSERT_TRUE(fault_is_onset(fault_at(0)));
    apply_next();
    bus_run_until(bus, 1000000U);
    TEST_ASSERT_EQUAL_UINT(1U, count);
    apply_next();
    bus_run_until(bus, 10000000U);
    TEST_ASSERT_EQUAL_UINT(33U, count);
    // The flight software has no node on this bus.
    TEST_ASSERT_EQUAL_STRING("joystick FLIGHT", faults_apply_next(&faults, &world)->target);
}

static void a_cut_disconnects_one_channel(void)
{
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK, load("1 fault cut robot-b FLIGHT\n2 fault cut robot FLIGHT\n3 fault mend robot-b FLIGHT\n"
                        "4 fault cut joystick-b FLIGHT\n5 fault stuck joystick-b on\n"
                        "6 fault bus-off joystick-b FLIGHT\n"));
    TEST_ASSERT_TRUE(fault_is_onset(fault_at(0)));
    TEST_ASSERT_FALSE(fault_is_onset(fault_at(2)));
    apply_next();
    TEST_ASSERT_TRUE(bus_is_plugged(world.channel[0][0].bus, 0U));
    TEST_ASSERT_FALSE(bus_is_plugged(world.channel[0][1].bus, 0U));
    apply_next();
    TEST_ASSERT_FALSE(bus_is_plugged(world.channel[0][0].bus, 0U));
    apply_next();
    TEST_ASSERT_FALSE(bus_is_plugged(world.channel[0][0].bus, 0U));
    TEST_ASSERT_TRUE(bus_is_plugged(world.channel[0][1].bus, 0U));
    apply_next(); // A channel that does not exist: no effect.
    apply_next();
    apply_next();
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, faults_next_ns(&faults));
}

static void a_restart_now_ends_bus_off(void)
{
    bus_t* bus = world.channel[0][0].bus;
    TEST_ASSERT_EQUAL_INT(STATUS_OK,
                          load("1 fault restart robot FLIGHT order\n2 fault bus-off robot FLIGHT\n"
                               "3 fault restart robot FLIGHT now\n4 fault restart robot FLIGHT auto\n"
                               "5 fault arbitration robot FLIGHT on\n6 fault overflow robot FLIGHT 3\n"));
    TEST_ASSERT_TRUE(fault_is_onset(fault_at(0)));
    TEST_ASSERT_FALSE(fault_is_onset(fault_at(2)));
    apply_next();
    apply_next();
    bus_run_until(bus, 10000000U);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_BUS_OFF, bus_controller(bus, 0U)->state);
    apply_next();
    bus_run_until(bus, 20000000U);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, bus_controller(bus, 0U)->state);
    apply_next();
    apply_next();
    apply_next();
}

static const char* named_process = ""; // Process that the last fault named.
static fault_kind_t process_fault;

static void note_process(void* context, fault_kind_t kind, const char* process)
{
    TEST_ASSERT_EQUAL_PTR(&process_fault, context);
    process_fault = kind;
    named_process = process;
}

static void a_kill_names_the_process_that_it_ends(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK, load("1 fault kill supervisor\n2.000001 fault kill packet-archive-sqlite\n"), error);
    apply_next(); // A world without processes.
    TEST_ASSERT_EQUAL_STRING("", named_process);
    world.process         = note_process;
    world.process_context = &process_fault;
    TEST_ASSERT_EQUAL_UINT64(2000001000U, faults_next_ns(&faults));
    const fault_t* fault = faults_apply_next(&faults, &world);
    TEST_ASSERT_EQUAL_STRING("packet-archive-sqlite", named_process);
    TEST_ASSERT_EQUAL_STRING("packet-archive-sqlite", fault->target);
    TEST_ASSERT_EQUAL_STRING("kill", fault_word(fault->kind));
    TEST_ASSERT_TRUE(fault_is_onset(fault));
    TEST_ASSERT_EQUAL(FAULT_KILL, process_fault);
}

static void a_process_hangs_and_continues(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, load("1 fault hang joystick\n2 fault resume joystick\n"), error);
    world.process         = note_process;
    world.process_context = &process_fault;
    const fault_t* fault  = faults_apply_next(&faults, &world);
    TEST_ASSERT_EQUAL(FAULT_HANG, process_fault);
    TEST_ASSERT_EQUAL_STRING("joystick", named_process);
    TEST_ASSERT_TRUE(fault_is_onset(fault));
    fault = faults_apply_next(&faults, &world);
    TEST_ASSERT_EQUAL(FAULT_RESUME, process_fault);
    TEST_ASSERT_FALSE(fault_is_onset(fault));
    expect_error("1 fault hang", "hang <process>");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_kill_names_the_process_that_it_ends);
    RUN_TEST(a_process_hangs_and_continues);
    RUN_TEST(the_faults_of_a_scenario_are_read);
    RUN_TEST(errors_name_file_line_and_expected_value);
    RUN_TEST(a_message_says_if_the_world_has_no_part_of_the_named_kind);
    RUN_TEST(without_a_scenario_there_are_no_faults);
    RUN_TEST(scenarios_of_the_mission_are_read);
    RUN_TEST(faults_of_a_scenario_act_on_the_bus);
    RUN_TEST(a_node_sends_the_commanded_number_of_sync_frames);
    RUN_TEST(a_cut_disconnects_one_channel);
    RUN_TEST(a_restart_now_ends_bus_off);
    return UNITY_END();
}
