// SPDX-License-Identifier: Apache-2.0
// Fault lines of a scenario reach every kind of device of a world, and the power unit.
#include "osal/include/osal/can.h"
#include "sim/app/simulator.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define STEP_NS 500000U
#define MS 1000000U
#define WORLD "descriptors/worlds/rokviss.xml"
#define BUSES 2U
/// Devices of all kinds other than drives and joysticks.
#define OTHERS                                                                                               \
    "<Bench name=\"MOTOR\" type=\"light\" bus=\"robot\" node=\"0x31\" eds=\"joint-drive.eds\" "              \
    "contact=\"0.6\" stiffness=\"400\" range=\"2\"/>"                                                        \
    "<Wheel name=\"WHEEL\" on=\"arm.finger\" axis=\"0 0 1\" momentum=\"12\" torque=\"0.22\" bus=\"robot\" "  \
    "node=\"0x32\" eds=\"wheel.eds\"/>"                                                                      \
    "<ValveBox name=\"VALVES\" bus=\"robot\" node=\"0x33\" eds=\"valve-box.eds\"/>"                          \
    "<Gyro name=\"GYRO\" on=\"arm.finger\" noise=\"0\" bias=\"0\" bus=\"robot\" node=\"0x34\" "              \
    "eds=\"gyro.eds\"/>"                                                                                     \
    "<StarTracker name=\"TRACKER\" on=\"arm.finger\" rate=\"5\" noise=\"0 0 0\" bus=\"robot\" "              \
    "node=\"0x35\" eds=\"star-tracker.eds\"/>"                                                               \
    "<PoseCamera name=\"CAMERA\" on=\"arm.finger\" sees=\"arm.finger\" rate=\"20\" delay=\"10ms\" "          \
    "noise=\"0 0 0\" angleNoise=\"0 0 0\" loss=\"0\" bus=\"robot\" node=\"0x36\" eds=\"pose-camera.eds\"/>"  \
    "</World>"

static const struct {
    const char* name;
    unsigned bus;
    unsigned node;
} devices[] = {{"JOINT1", 0U, 0x11U}, {"STICK", 1U, 0x21U}, {"MOTOR", 0U, 0x31U},   {"WHEEL", 0U, 0x32U},
               {"VALVES", 0U, 0x33U}, {"GYRO", 0U, 0x34U},  {"TRACKER", 0U, 0x35U}, {"CAMERA", 0U, 0x36U}};
static const char* const buses[BUSES] = {"robot", "joystick"};
static char address[BUSES][48];
static osal_can_t can[BUSES];
static simulator_t* simulator;
static char error[SIMULATOR_ERROR_MAX];

void setUp(void)
{
    for (unsigned i = 0U; i < BUSES; i++) {
        (void)snprintf(address[i], sizeof address[i], "shm:hirosco-faults-%ld.%s", (long)getpid(), buses[i]);
        TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_create(address[i]));
        TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_open(&can[i], address[i], OSAL_CAN_NODE));
    }
    // An unchanged copy: the world of open_with refers to this file in its own directory.
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
}

void tearDown(void)
{
    (void)simulator_close(simulator);
    simulator = NULL;
    for (unsigned i = 0U; i < BUSES; i++) {
        osal_can_close(&can[i]);
        (void)osal_can_destroy(address[i]);
    }
    temporary_files_remove();
}

static status_t open_with(const char* scenario)
{
    char world[128];
    char path[128];
    (void)strcpy(world, temporary_variant("w.xml", WORLD, "</World>", OTHERS));
    (void)strcpy(path, temporary_file("test.scn", scenario));
    const simulator_config_t config = {
        .world_path    = world,
        .scenario_path = path,
        .bus       = {{.name = buses[0], .address = address[0]}, {.name = buses[1], .address = address[1]}},
        .bus_count = BUSES,
        .seed      = 1U};
    return simulator_open(&config, &simulator, error);
}

/// Number of frames from each node of each bus: heartbeats with boot-ups, and emergencies.
typedef struct {
    unsigned heartbeat[BUSES][128];
    unsigned emergency[BUSES][128];
} heard_t;

static void listen(heard_t* heard)
{
    for (unsigned bus = 0U; bus < BUSES; bus++) {
        osal_can_frame_t frame;
        while (osal_can_receive(&can[bus], &frame) == STATUS_OK) {
            const unsigned node = frame.id & 0x7FU;
            heard->heartbeat[bus][node] += ((frame.id & ~0x7FU) == 0x700U) ? 1U : 0U;
            heard->emergency[bus][node] += ((frame.id & ~0x7FU) == 0x080U) ? 1U : 0U;
        }
    }
}

/// An unplugged device sends nothing; a device that is plugged again boots; an error causes an emergency.
static void a_fault_reaches_every_kind_of_device(void)
{
    static heard_t heard[3]; // Before a device is unplugged, while it is unplugged, afterwards.
    const unsigned count                 = sizeof devices / sizeof devices[0];
    static const char* const verbs[3][2] = {
        {"0.1 fault unplug", ""}, {"0.5 fault plug", ""}, {"0.9 fault error", "0x3220 on"}};
    char scenario[2048] = "";
    for (unsigned i = 0U; i < (3U * count); i++) {
        const size_t used = strlen(scenario);
        (void)snprintf(&scenario[used], sizeof scenario - used, "%s %s %s %s\n", verbs[i / count][0],
                       buses[devices[i % count].bus], devices[i % count].name, verbs[i / count][1]);
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_with(scenario), error);
    for (uint64_t now_ns = 0U; now_ns < 1200U * MS; now_ns += STEP_NS) {
        const unsigned phase = (now_ns <= (100U * MS)) ? 0U : ((now_ns < (500U * MS)) ? 1U : 2U);
        (void)simulator_step(simulator, now_ns);
        listen(&heard[phase]);
    }
    for (unsigned i = 0U; i < count; i++) {
        const unsigned bus  = devices[i].bus;
        const unsigned node = devices[i].node;
        TEST_ASSERT_TRUE_MESSAGE(heard[0].heartbeat[bus][node] > 0U, devices[i].name);
        TEST_ASSERT_EQUAL_UINT_MESSAGE(0U, heard[1].heartbeat[bus][node], devices[i].name);
        TEST_ASSERT_TRUE_MESSAGE(heard[2].heartbeat[bus][node] > 0U, devices[i].name);
        TEST_ASSERT_TRUE_MESSAGE(heard[2].emergency[bus][node] > 0U, devices[i].name);
        TEST_ASSERT_EQUAL_UINT_MESSAGE(0U, heard[0].emergency[bus][node], devices[i].name);
    }
}

/// Send RPDO1 of the power unit (node 0x1F): a pulse on one of its lines.
static void pulse(const uint8_t line)
{
    const osal_can_frame_t frame = {.id = 0x21FU, .length = 3U, .data = {line, 0U, 1U}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_can_send(&can[0], &frame));
}

/// Command the power unit to open the relay of JOINT1 and to close it again, twice. Returns the number
/// of boots of the drive after 0.09 s.
static unsigned boots(const char* scenario)
{
    heard_t heard;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_with(scenario), error);
    for (uint64_t now_ns = 0U; now_ns < 700U * MS; now_ns += STEP_NS) {
        const uint64_t cycle_ns = now_ns % (300U * MS);
        (void)simulator_step(simulator, now_ns);
        if (now_ns == (90U * MS)) {
            listen(&heard);
            memset(&heard, 0, sizeof heard);
        }
        if ((cycle_ns == (100U * MS)) || (cycle_ns == (160U * MS))) {
            pulse((cycle_ns == (100U * MS)) ? 2U : 1U);
        }
    }
    unsigned count = 0U;
    osal_can_frame_t frame;
    while (osal_can_receive(&can[0], &frame) == STATUS_OK) {
        count += ((frame.id == 0x711U) && (frame.data[0] == 0U)) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, simulator_close(simulator));
    simulator = NULL;
    return count;
}

static void faults_reach_the_power_unit(void)
{
    // Both commands to close the relay boot the drive, because the fault is later than the end of the run.
    TEST_ASSERT_EQUAL_UINT(2U, boots("0.9 fault reset robot SUPPLY\n"));
    // The unit misses the commands of the first or the second cycle.
    TEST_ASSERT_EQUAL_UINT(1U, boots("0.05 fault unplug robot SUPPLY\n0.3 fault plug robot 0x1F\n"));
    TEST_ASSERT_EQUAL_UINT(1U, boots("0.3 fault cut robot SUPPLY\n"));
    // The channel is connected again before the second cycle.
    TEST_ASSERT_EQUAL_UINT(2U, boots("0.3 fault cut robot SUPPLY\n0.35 fault mend robot SUPPLY\n"));
    // The reset cancels the pulse that opens the relay, so the first cycle has no effect.
    TEST_ASSERT_EQUAL_UINT(1U, boots("0.11 fault reset robot SUPPLY\n"));
    // The drive is unplugged too.
    TEST_ASSERT_EQUAL_UINT(0U, boots("0.05 fault unplug robot\n"));
}

static void faults_of_a_sender_are_not_accepted_for_a_power_unit(void)
{
    static const char* const lines[] = {"\n0.1 fault error robot SUPPLY 0x3220 on\n",
                                        "\n0.1 fault babble robot SUPPLY on\n",
                                        "\n0.1 fault delay robot 0x1F 50\n"};
    for (unsigned i = 0U; i < (sizeof lines / sizeof lines[0]); i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_INVALID, open_with(lines[i]));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "test.scn:2"), error);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "expected unplug, plug, cut, mend or reset"), error);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_fault_reaches_every_kind_of_device);
    RUN_TEST(faults_reach_the_power_unit);
    RUN_TEST(faults_of_a_sender_are_not_accepted_for_a_power_unit);
    return UNITY_END();
}
