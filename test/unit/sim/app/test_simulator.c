// SPDX-License-Identifier: Apache-2.0
// The whole simulator, with a small master on both buses that sends the same frames as the flight software.
#include "osal/include/osal/can.h"
#include "osal/include/osal/hand_over.h"
#include "sim/app/simulator.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STEP_NS 500000U
#define WORLD "descriptors/worlds/rokviss.xml"
#define ROBOT 0U
#define JOYSTICK 1U
#define FD_BRS (OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS)

static char directory[32];
static char address[2][48];
static osal_can_t can[2];
static simulator_t* simulator;
static uint64_t now_ns;

/// The frames that the master has received last.
static struct {
    uint16_t statusword[2];
    int32_t position[2];
    uint64_t tpdo_ns[2];
    uint16_t stick_statusword[2];
    unsigned errors[2];
    uint32_t error_classes[2];
    unsigned boot_ups;
    uint16_t emergency;
} heard;

static const char* file(const char* name)
{
    static char path[96];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void open_controllers(void)
{
    static const char* const names[2] = {"robot", "joystick"};
    for (unsigned i = 0U; i < 2U; i++) {
        (void)snprintf(address[i], sizeof address[i], "shm:hirosco-test-%ld.%s", (long)getpid(), names[i]);
        TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_create(address[i]));
        TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_open(&can[i], address[i], OSAL_CAN_NODE));
    }
}

static void open_simulator(const char* scenario, uint64_t seed)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    if (scenario != NULL) {
        FILE* out = fopen(file("test.scn"), "w");
        TEST_ASSERT_NOT_NULL(out);
        (void)fputs(scenario, out);
        (void)fclose(out);
    }
    char path[96];
    (void)strcpy(path, file("test.scn"));
    const simulator_config_t config = {.world_path    = WORLD,
                                       .scenario_path = (scenario != NULL) ? path : NULL,
                                       .output_path   = directory,
                                       .bus           = {{.name = "robot", .address = address[ROBOT]},
                                                         {.name = "joystick", .address = address[JOYSTICK]}},
                                       .bus_count     = 2U,
                                       .seed          = seed};
    now_ns                          = 0U;
    memset(&heard, 0, sizeof heard);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, simulator_open(&config, &simulator, error), error);
}

void setUp(void)
{
    (void)strcpy(directory, "/tmp/hirosco-sim-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    open_controllers();
}

void tearDown(void)
{
    static const char* const names[] = {"test.scn",         "can-robot.log",     "can-robot.pcap",
                                        "can-joystick.log", "can-joystick.pcap", "truth.lcm"};
    (void)simulator_close(simulator);
    simulator = NULL;
    for (unsigned i = 0U; i < 2U; i++) {
        osal_can_close(&can[i]);
        (void)osal_can_destroy(address[i]);
    }
    for (unsigned i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        (void)unlink(file(names[i]));
    }
    (void)rmdir(directory);
}

static void send(unsigned bus, uint32_t id, uint8_t flags, const uint8_t* data, uint8_t length)
{
    osal_can_frame_t frame = {.id = id, .length = length, .flags = flags};
    if (length != 0U) {
        memcpy(frame.data, data, length);
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_send(&can[bus], &frame));
}

static uint32_t u32(const uint8_t* octets)
{
    return (uint32_t)octets[0] | ((uint32_t)octets[1] << 8) | ((uint32_t)octets[2] << 16) |
           ((uint32_t)octets[3] << 24);
}

static void take_robot(const osal_can_frame_t* frame)
{
    for (unsigned i = 0U; i < 2U; i++) {
        if (frame->id == (0x191U + i)) {
            heard.statusword[i] = (uint16_t)(u32(frame->data) & 0xFFFFU);
            heard.position[i]   = (int32_t)u32(&frame->data[2]);
            heard.tpdo_ns[i]    = frame->time_ns;
        } else if (frame->id == (0x091U + i)) {
            heard.emergency = (uint16_t)(u32(frame->data) & 0xFFFFU);
        }
    }
}

static void listen(void)
{
    osal_can_frame_t frame;
    for (unsigned bus = 0U; bus < 2U; bus++) {
        while (osal_can_receive(&can[bus], &frame) == STATUS_OK) {
            if ((frame.id & OSAL_CAN_ERROR) != 0U) {
                heard.errors[bus]++;
                heard.error_classes[bus] |= frame.id;
            } else if (bus == ROBOT) {
                take_robot(&frame);
            } else if (frame.id == 0x2A1U) {
                heard.stick_statusword[0] = (uint16_t)(u32(frame.data) & 0xFFFFU);
                heard.stick_statusword[1] = (uint16_t)(u32(frame.data) >> 16);
            }
            heard.boot_ups +=
                ((frame.id >= 0x701U) && (frame.id <= 0x77FU) && (frame.data[0] == 0U)) ? 1U : 0U;
        }
    }
}

static void step(void)
{
    now_ns += STEP_NS;
    TEST_ASSERT_EQUAL_UINT64(now_ns + STEP_NS, simulator_step(simulator, now_ns));
    listen();
}

/// RPDOs that hold the present pose, with constant torques against gravity, then SYNC: the frames that the
/// flight software sends in a cycle.
static void cycle(uint16_t controlword, uint16_t stick_controlword)
{
    static const int16_t weight[2] = {590, 200}; // 0.01 Nm
    for (unsigned i = 0U; i < 2U; i++) {
        uint8_t data[8] = {(uint8_t)controlword, (uint8_t)(controlword >> 8)};
        for (unsigned k = 0U; k < 4U; k++) {
            data[2U + k] = (uint8_t)((uint32_t)heard.position[i] >> (8U * k));
        }
        data[6] = (uint8_t)weight[i];
        data[7] = (uint8_t)((uint16_t)weight[i] >> 8);
        send(ROBOT, 0x211U + i, FD_BRS, data, 8U);
    }
    send(ROBOT, 0x080U, 0U, NULL, 0U);
    const uint8_t data[8] = {0U, 0U, 0U, 0U, (uint8_t)stick_controlword, 0U, (uint8_t)stick_controlword, 0U};
    send(JOYSTICK, 0x221U, FD_BRS, data, 8U);
    send(JOYSTICK, 0x080U, 0U, NULL, 0U);
    step();
}

static void bring_up(void)
{
    const uint8_t start[2] = {1U, 0U};
    for (unsigned i = 0U; i < 5U; i++) {
        step();
    }
    TEST_ASSERT_EQUAL_UINT(3U, heard.boot_ups);
    send(ROBOT, 0U, 0U, start, 2U);
    send(JOYSTICK, 0U, 0U, start, 2U);
    step();
    cycle(0x00U, 0x00U);
    cycle(0x06U, 0x06U);
    cycle(0x07U, 0x07U);
    cycle(0x0FU, 0x0FU);
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_HEX16(0x27U, heard.statusword[i] & 0x6FU);
        TEST_ASSERT_EQUAL_HEX16(0x27U, heard.stick_statusword[i] & 0x6FU);
    }
}

static void a_command_is_applied_and_answered_within_one_step(void)
{
    open_simulator(NULL, 1U);
    bring_up();
    // TPDOs of this step: frames queued at t were applied and answered within [t, t + 0.5 ms).
    cycle(0x07U, 0x0FU);
    TEST_ASSERT_EQUAL_HEX16(0x23U, heard.statusword[0] & 0x6FU);
    TEST_ASSERT_GREATER_THAN_UINT64(now_ns - STEP_NS, heard.tpdo_ns[0]);
    TEST_ASSERT_LESS_THAN_UINT64(now_ns, heard.tpdo_ns[1]);
    TEST_ASSERT_GREATER_THAN_UINT64(heard.tpdo_ns[0], heard.tpdo_ns[1]);
}

static void the_arm_stands_still_on_its_brakes_and_under_control(void)
{
    open_simulator(NULL, 1U);
    bring_up();
    const int32_t before[2] = {heard.position[0], heard.position[1]};
    TEST_ASSERT_INT32_WITHIN(10, 1047198, before[0]); // 60 degrees
    TEST_ASSERT_INT32_WITHIN(10, -1570796, before[1]);
    for (unsigned i = 0U; i < 200U; i++) {
        cycle(0x0FU, 0x0FU);
    }
    for (unsigned i = 0U; i < 400U; i++) {
        cycle(0x07U, 0x07U);
    }
    TEST_ASSERT_INT32_WITHIN(1000, before[0], heard.position[0]);
    TEST_ASSERT_INT32_WITHIN(1000, before[1], heard.position[1]);
}

static void unplugged_devices_are_silent_and_the_others_continue(void)
{
    open_simulator("0.1 fault unplug robot JOINT1\n0.3 fault plug robot JOINT1\n", 1U);
    bring_up();
    while (now_ns < 200000000U) {
        cycle(0x0FU, 0x0FU);
    }
    TEST_ASSERT_LESS_THAN_UINT64(100500000U, heard.tpdo_ns[0]);
    TEST_ASSERT_GREATER_THAN_UINT64(199000000U, heard.tpdo_ns[1]);
    TEST_ASSERT_EQUAL_HEX16(0x27U, heard.statusword[1] & 0x6FU);
    TEST_ASSERT_EQUAL_UINT(0U, heard.errors[ROBOT]); // The other drive acknowledges.
    heard.boot_ups = 0U;
    while (now_ns < 310000000U) {
        cycle(0x0FU, 0x0FU);
    }
    TEST_ASSERT_EQUAL_UINT(1U, heard.boot_ups);
}

static void a_master_alone_on_its_bus_receives_error_frames(void)
{
    open_simulator("0.1 fault unplug joystick\n0.2 fault plug joystick\n", 1U);
    bring_up();
    while (now_ns < 101000000U) {
        cycle(0x0FU, 0x0FU);
    }
    TEST_ASSERT_TRUE((heard.error_classes[JOYSTICK] & OSAL_CAN_ERROR_NO_ACK) != 0U);
    TEST_ASSERT_EQUAL_UINT(0U, heard.errors[ROBOT]);
    // The master stops sending; after the joystick is plugged, the old frames leave the queue and the device
    // boots.
    heard.boot_ups = 0U;
    while (now_ns < 250000000U) {
        step();
    }
    TEST_ASSERT_EQUAL_UINT(1U, heard.boot_ups);
    TEST_ASSERT_TRUE((heard.error_classes[JOYSTICK] & OSAL_CAN_ERROR_CONTROLLER) != 0U);
}

static void the_brake_holds_the_joint_of_a_drive_unplugged_at_any_phase_of_the_cycle(void)
{
    for (unsigned phase = 0U; phase < 20U; phase++) {
        char scenario[96];
        const unsigned cut_us = 50000U + (phase * 25U);
        (void)snprintf(scenario, sizeof scenario,
                       "0.%06u fault unplug robot JOINT1\n0.2 fault plug robot JOINT1\n", cut_us);
        open_simulator(scenario, 1U);
        bring_up();
        const int32_t before = heard.position[0];
        while (now_ns < 60000000U) {
            cycle(0x0FU, 0x0FU);
        }
        heard.boot_ups = 0U;
        while (now_ns < 210000000U) {
            cycle(0x00U, 0x00U);
        }
        TEST_ASSERT_EQUAL_UINT(1U, heard.boot_ups);
        const uint8_t start[2] = {1U, 0x11U};
        send(ROBOT, 0U, 0U, start, 2U);
        cycle(0x00U, 0x00U);
        cycle(0x00U, 0x00U);
        TEST_ASSERT_INT32_WITHIN(1000, before, heard.position[0]); // The brake has held the joint.
        TEST_ASSERT_EQUAL_INT(STATUS_OK, simulator_close(simulator));
        simulator = NULL;
    }
}

static void an_injected_error_is_reported_and_stops_the_drive(void)
{
    open_simulator("0.05 fault error robot JOINT2 0x2310 on\n", 1U);
    bring_up();
    while (now_ns < 100000000U) {
        cycle(0x0FU, 0x0FU);
    }
    TEST_ASSERT_EQUAL_HEX16(0x2310U, heard.emergency);
    TEST_ASSERT_EQUAL_HEX16(0x08U, heard.statusword[1] & 0x4FU);
    TEST_ASSERT_EQUAL_HEX16(0x27U, heard.statusword[0] & 0x6FU);
}

static uint64_t hash_of_file(const char* name)
{
    FILE* in      = fopen(file(name), "rb");
    uint64_t hash = 0xCBF29CE484222325U;
    TEST_ASSERT_NOT_NULL(in);
    for (int octet = fgetc(in); octet != EOF; octet = fgetc(in)) {
        hash = (hash ^ (uint64_t)octet) * 0x100000001B3U;
    }
    (void)fclose(in);
    return hash;
}

static void fly_and_hash(uint64_t seed, uint64_t out_hash[3])
{
    open_simulator("0.02 fault loss robot 0.01\n0.02 fault corruption joystick 0.01\n", seed);
    bring_up();
    for (unsigned i = 0U; i < 400U; i++) {
        cycle(0x0FU, 0x0FU);
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, simulator_close(simulator));
    simulator   = NULL;
    out_hash[0] = hash_of_file("can-robot.log");
    out_hash[1] = hash_of_file("can-joystick.pcap");
    out_hash[2] = hash_of_file("truth.lcm");
}

static void equal_seeds_give_equal_logs_and_unequal_seeds_do_not(void)
{
    uint64_t first[3];
    uint64_t second[3];
    uint64_t other[3];
    fly_and_hash(7U, first);
    fly_and_hash(7U, second);
    fly_and_hash(8U, other);
    TEST_ASSERT_EQUAL_HEX64_ARRAY(first, second, 3U);
    TEST_ASSERT_TRUE(first[0] != other[0]);
}

static void bus_loads_are_at_most_those_computed(void)
{
    simulator_statistics_t statistics;
    open_simulator(NULL, 1U);
    bring_up();
    for (unsigned i = 0U; i < 2000U; i++) {
        cycle(0x0FU, 0x0FU);
    }
    simulator_statistics(simulator, &statistics);
    // Computed worst case: 56 % and, with the second TPDO, 45 %.
    EXPECT_WITHIN(0.52, 0.04, (double)statistics.busy_ns[ROBOT] / (double)now_ns);
    EXPECT_WITHIN(0.41, 0.04, (double)statistics.busy_ns[JOYSTICK] / (double)now_ns);
    TEST_ASSERT_EQUAL_UINT64(0U, statistics.refused);
}

static void expect_open_error(const simulator_config_t* config, status_t status, const char* words)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    simulator_t* none               = NULL;
    TEST_ASSERT_EQUAL_INT(status, simulator_open(config, &none, error));
    TEST_ASSERT_NULL(none);
    if (strstr(error, words) == NULL) {
        TEST_ASSERT_EQUAL_STRING(words, error);
    }
}

static void a_file_or_bus_that_cannot_be_opened_is_reported_in_one_line(void)
{
    expect_open_error(&(simulator_config_t){.world_path = WORLD,
                                            .bus = {{.name = "robot", .address = "shm:nobody-made-this"}},
                                            .bus_count = 1U},
                      STATUS_NOT_FOUND, "bus robot: no controller at 'shm:nobody-made-this'");
    expect_open_error(&(simulator_config_t){.world_path = WORLD, .output_path = "/nowhere"}, STATUS_IO,
                      "'/nowhere'");
    expect_open_error(&(simulator_config_t){.world_path = WORLD, .scenario_path = "/nowhere.scn"},
                      STATUS_NOT_FOUND, "/nowhere.scn");
    expect_open_error(&(simulator_config_t){.world_path = WORLD, .devices_path = "/nowhere"},
                      STATUS_NOT_FOUND, "/nowhere/joint-drive.eds");
    // The two buses of the world and seven more are too many.
    expect_open_error(&(simulator_config_t){.world_path = WORLD,
                                            .bus        = {{.name = "a"},
                                                           {.name = "b"},
                                                           {.name = "c"},
                                                           {.name = "d"},
                                                           {.name = "e"},
                                                           {.name = "f"},
                                                           {.name = "g"}},
                                            .bus_count  = 7U},
                      STATUS_INVALID, "rokviss.xml: found bus 'g' of the mission");
    FILE* out = fopen(file("test.scn"), "w");
    TEST_ASSERT_NOT_NULL(out);
    (void)fputs("1 fault explode robot\n", out);
    (void)fclose(out);
    char path[96];
    (void)strcpy(path, file("test.scn"));
    expect_open_error(&(simulator_config_t){.world_path = WORLD, .scenario_path = path}, STATUS_INVALID,
                      "test.scn:1: ");
}

static void a_simulator_that_is_called_late_catches_up(void)
{
    open_simulator(NULL, 1U);
    TEST_ASSERT_EQUAL_UINT64(STEP_NS, simulator_step(simulator, 0U));
    TEST_ASSERT_EQUAL_UINT64(STEP_NS, simulator_step(simulator, STEP_NS - 1U));
    TEST_ASSERT_EQUAL_UINT64(11U * STEP_NS, simulator_step(simulator, (10U * STEP_NS) + 7U));
    listen();
    TEST_ASSERT_EQUAL_UINT(3U, heard.boot_ups);
}

static void faults_reach_every_device_and_bus_of_the_world(void)
{
    char world[128];
    char scenario[128];
    char error[SIMULATOR_ERROR_MAX] = "";
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    (void)strcpy(scenario,
                 temporary_file("test.scn",
                                "0.01 fault unplug gripper MOTOR\n0.02 fault torque-offset MOTOR 5\n"
                                "0.03 fault stuck gripper on\n0.04 fault plug gripper 0x31\n"));
    (void)strcpy(world,
                 temporary_variant(
                     "w.xml", WORLD, "</World>",
                     "<Bench name=\"MOTOR\" type=\"light\" bus=\"gripper\" node=\"0x31\" "
                     "eds=\"joint-drive.eds\" contact=\"0.6\" stiffness=\"400\" range=\"2\"/>\n</World>"));
    const simulator_config_t config = {.world_path = world, .scenario_path = scenario, .seed = 1U};
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, simulator_open(&config, &simulator, error), error);
    TEST_ASSERT_EQUAL_STRING("gripper", simulator_bus_name(simulator, 2U));
    TEST_ASSERT_NULL(simulator_bus_name(simulator, 3U));
    simulator_statistics_t before;
    simulator_statistics_t after;
    (void)simulator_step(simulator, 9000000U);
    simulator_statistics(simulator, &before);
    TEST_ASSERT_GREATER_THAN_UINT64(0U, before.busy_ns[2]); // The boot-up.
    (void)simulator_step(simulator, 10500000U);
    simulator_statistics(simulator, &before);
    (void)simulator_step(simulator, 29000000U);
    simulator_statistics(simulator, &after);
    TEST_ASSERT_EQUAL_UINT64(before.busy_ns[2], after.busy_ns[2]); // Unplugged: no heartbeat.
    (void)simulator_step(simulator, 100000000U);
    temporary_files_remove();
}

static void a_joystick_rests_while_no_hand_moves_it(void)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path =
        temporary_variant("w.xml", WORLD,
                          "<Hand joystick=\"STICK\" stiffness=\"3\" damping=\"0.1\" positionScale=\"2\" "
                          "forceScale=\"0.03\" jointStiffness=\"2667\"/>",
                          "");
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK, simulator_open(&(simulator_config_t){.world_path = path}, &simulator, error), error);
    TEST_ASSERT_EQUAL_UINT64(100500000U, simulator_step(simulator, 100000000U));
    temporary_files_remove();
}

static void a_world_that_diverges_is_not_simulated_further(void)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant("w.xml", WORLD, "damping=\"8\"", "damping=\"80000\"");
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK, simulator_open(&(simulator_config_t){.world_path = path}, &simulator, error), error);
    TEST_ASSERT_NULL(simulator_failure(simulator));
    TEST_ASSERT_TRUE(simulator_step(simulator, 100000000U) < 100000000U);
    TEST_ASSERT_NOT_NULL(simulator_failure(simulator));
    TEST_ASSERT_NOT_NULL(strstr(simulator_failure(simulator), "the world diverges"));
    temporary_files_remove();
}

static void the_world_of_another_robot_opens_and_steps(void)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK,
        simulator_open(&(simulator_config_t){.world_path    = "descriptors/worlds/ur5e-telepresence.xml",
                                             .scenario_path = "sim/scenarios/ur5e-telepresence.scn"},
                       &simulator, error),
        error);
    TEST_ASSERT_EQUAL_UINT64(100500000U, simulator_step(simulator, 100000000U));
}

static void octets_of_an_instrument_that_do_not_arrive_are_in_the_statistics(void)
{
    char error[SIMULATOR_ERROR_MAX] = "";
    char run[32];
    char counts_name[64];
    simulator_statistics_t statistics;
    osal_hand_over_t flight = OSAL_HAND_OVER_CLOSED;
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant(
        "w.xml", WORLD, "</World>",
        "<Instrument name=\"COVER\" type=\"FILE\" channel=\"/dev/cover\" framing=\"SLIP\" value=\"INT16\" "
        "period=\"10ms\" speed=\"1\"/>\n</World>");
    (void)snprintf(run, sizeof run, "sim-%d-1", (int)getpid());
    (void)snprintf(counts_name, sizeof counts_name, "/%s.flow.dev.cover.n", run);
    const simulator_config_t config = {.world_path = path, .flows = run, .are_flows_counted = true};
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, simulator_open(&config, &simulator, error), error);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_hand_over_open(&flight, counts_name));
    osal_hand_over_begin(&flight);
    (void)simulator_step(simulator, 20000000U);
    simulator_statistics(simulator, &statistics);
    TEST_ASSERT_EQUAL_UINT64(0U, statistics.undelivered);
    const uint32_t due = osal_hand_over_due(&flight);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, due); // The first record.
    osal_hand_over_give_up(&flight);
    simulator_statistics(simulator, &statistics);
    TEST_ASSERT_EQUAL_UINT64(due, statistics.undelivered);
    osal_hand_over_close(&flight);
    temporary_files_remove();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_command_is_applied_and_answered_within_one_step);
    RUN_TEST(the_arm_stands_still_on_its_brakes_and_under_control);
    RUN_TEST(unplugged_devices_are_silent_and_the_others_continue);
    RUN_TEST(a_master_alone_on_its_bus_receives_error_frames);
    RUN_TEST(the_brake_holds_the_joint_of_a_drive_unplugged_at_any_phase_of_the_cycle);
    RUN_TEST(an_injected_error_is_reported_and_stops_the_drive);
    RUN_TEST(equal_seeds_give_equal_logs_and_unequal_seeds_do_not);
    RUN_TEST(bus_loads_are_at_most_those_computed);
    RUN_TEST(a_file_or_bus_that_cannot_be_opened_is_reported_in_one_line);
    RUN_TEST(a_simulator_that_is_called_late_catches_up);
    RUN_TEST(faults_reach_every_device_and_bus_of_the_world);
    RUN_TEST(a_joystick_rests_while_no_hand_moves_it);
    RUN_TEST(a_world_that_diverges_is_not_simulated_further);
    RUN_TEST(the_world_of_another_robot_opens_and_steps);
    RUN_TEST(octets_of_an_instrument_that_do_not_arrive_are_in_the_statistics);
    return UNITY_END();
}
