// SPDX-License-Identifier: Apache-2.0
// The devices of a world on the buses of a run: their addresses, their effect on the plant, benches, and
// missing data sheets.
#include "sim/app/devices.h"
#include "sim/app/supply.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define WORLD "descriptors/worlds/rokviss.xml"
#define STEP_NS 500000U

static world_t world;
static plant_t* plant; // Null, except in a test that creates it.
static segment_t segments[3];
static bus_t* channel_b[3];
static devices_t* devices;
static plant_truth_t truth;
static char error[SIMULATOR_ERROR_MAX];
static unsigned reported[3];
static unsigned heard[0x800];

static void changed(void* context, uint64_t now_ns, const truth_drive_t* drive)
{
    (void)context;
    (void)now_ns;
    for (unsigned i = 0U; i < world.bus_count; i++) {
        reported[i] += (strcmp(drive->bus, world.bus[i]) == 0) ? 1U : 0U;
    }
}

static char changed_valve[64]; // Valve that changed last.
static bool is_open;

static void valve_changed(void* context, uint64_t now_ns, const truth_valve_t* valve)
{
    (void)context;
    (void)now_ns;
    (void)snprintf(changed_valve, sizeof changed_valve, "%s", valve->name);
    is_open = valve->is_open;
}

static void on_frame(void* context, const osal_can_frame_t* frame)
{
    (void)context;
    heard[frame->id % 0x800U]++;
}

/// Read the world of ROKVISS with one more motor, which is on a bench on another bus.
void setUp(void)
{
    char reason[DOCUMENT_ERROR_MAX];
    changed_valve[0] = '\0';
    // The world refers to this file in its own directory; an unchanged copy is sufficient.
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* path = temporary_variant(
        "w.xml", WORLD, "</World>",
        "<Bench name=\"MOTOR\" type=\"light\" bus=\"gripper\" node=\"0x31\" eds=\"joint-drive.eds\" "
        "contact=\"0.6\" stiffness=\"400\" range=\"2\"/>\n</World>");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, reason), reason);
    memset(heard, 0, sizeof heard);
    memset(reported, 0, sizeof reported);
    memset(&truth, 0, sizeof truth);
    memset(channel_b, 0, sizeof channel_b);
    for (unsigned i = 0U; i < 3U; i++) {
        const segment_config_t config = {
            .name = world.bus[i], .bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_open(&segments[i], &config, error));
    }
}

void tearDown(void)
{
    devices_close(devices);
    devices = NULL;
    plant_destroy(plant);
    plant = NULL;
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_close(&segments[i]));
    }
    temporary_files_remove();
}

static status_t open_from(const char* directory)
{
    const devices_config_t config = {.world         = &world,
                                     .directory     = directory,
                                     .truth         = &truth,
                                     .plant         = plant,
                                     .segments      = segments,
                                     .channel_b     = channel_b,
                                     .changed       = changed,
                                     .valve_changed = valve_changed};
    error[0]                      = '\0';
    return devices_open(&config, &devices, error);
}

static void run(unsigned steps)
{
    for (unsigned k = 0U; k < steps; k++) {
        const uint64_t now_ns = bus_now_ns(segments[0].bus);
        for (unsigned i = 0U; i < 3U; i++) {
            bus_run_until(segments[i].bus, now_ns + STEP_NS);
        }
        devices_end_step(devices, now_ns, now_ns + STEP_NS);
    }
}

static void each_device_boots_on_its_bus_and_is_reported(void)
{
    unsigned node                   = 0U;
    const bus_callbacks_t listening = {.on_frame = on_frame};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(segments[2].bus, &listening, &node));
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_from("descriptors/devices"), error);
    TEST_ASSERT_EQUAL_UINT(4U, devices_count(devices));
    TEST_ASSERT_EQUAL_STRING("JOINT2", device_entry(devices, 1U)->name);
    TEST_ASSERT_NULL(device_drive(devices, 2U));
    TEST_ASSERT_EQUAL_STRING("MOTOR", device_entry(devices, 3U)->name);
    devices_power_on(devices);
    run(200U);
    TEST_ASSERT_TRUE(heard[0x731] > 1U);      // Boot-up and heartbeats.
    TEST_ASSERT_EQUAL_UINT(0U, heard[0x711]); // That device is on another bus.
    memset(reported, 0, sizeof reported);
    devices_report(devices, 100000000U);
    TEST_ASSERT_EQUAL_UINT(2U, reported[0]);
    TEST_ASSERT_EQUAL_UINT(2U, reported[1]); // The joystick has two axes.
    TEST_ASSERT_EQUAL_UINT(1U, reported[2]);
}

static void without_power_brakes_hold_and_motors_rest(void)
{
    static plant_input_t input;
    const plant_rotor_t motor[2] = {{0.1, 0.0}, {0.2, 0.0}};
    double torque_nm[2]          = {1.0, 1.0};
    input                        = (plant_input_t){.stick_torque_nm = {{1.0, 1.0}}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, open_from("descriptors/devices"));
    devices_act(devices, &input);
    devices_regulate(devices, 0U, motor, torque_nm);
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_TRUE(input.brake_engaged[i]);
        EXPECT_WITHIN(0.0, 0.0, torque_nm[i]);
        EXPECT_WITHIN(0.0, 0.0, input.stick_torque_nm[0][i]);
    }
}

static void send(const unsigned node, const uint32_t id, const uint8_t length, const uint8_t* data)
{
    osal_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, data, length);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(segments[0].bus, node, &frame, bus_now_ns(segments[0].bus)));
    run(4U);
}

static void valves_and_latches_follow_their_outputs(void)
{
    static plant_input_t input;
    static const uint8_t start[2]       = {1U, 0U};
    static const uint8_t commands[2][4] = {{0x02U, 0x01U, 0U, 0U}, {0x00U, 0x81U, 0U, 0U}};
    const bus_callbacks_t listening     = {.on_frame = on_frame};
    unsigned node                       = 0U;
    char reason[DOCUMENT_ERROR_MAX];
    TEST_ASSERT_EQUAL_INT(STATUS_OK, world_read("descriptors/worlds/actuators.xml", &world, reason));
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, reason), reason);
    world.latch_count = 2U;
    world.latch[0]    = (world_latch_t){.trigger = WORLD_LATCH_WIRED, .output = 16U};
    world.latch[1]    = (world_latch_t){.trigger = WORLD_LATCH_WIRED, .output = 16U, .box = 1U};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(segments[0].bus, &listening, &node));
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_from("descriptors/devices"), error);
    TEST_ASSERT_EQUAL_STRING("VALVES", device_entry(devices, 1U)->name);
    devices_power_on(devices);
    run(10U);
    send(node, 0U, 2U, start);
    send(node, 0x23AU, 4U, commands[0]);
    send(node, 0x080U, 0U, commands[0]);
    devices_act(devices, &input);
    TEST_ASSERT_FALSE(input.valve_open[0]);
    TEST_ASSERT_TRUE(input.valve_open[1]); // Output 2.
    TEST_ASSERT_TRUE(input.valve_open[2]); // Output 9.
    TEST_ASSERT_FALSE(input.latch_on[0]);
    TEST_ASSERT_EQUAL_STRING("TURN1", changed_valve);
    TEST_ASSERT_TRUE(is_open);
    run(60U); // 30 ms: a valve cannot close before its shortest pulse of 20 ms has ended.
    send(node, 0x23AU, 4U, commands[1]);
    send(node, 0x080U, 0U, commands[1]);
    devices_act(devices, &input);
    TEST_ASSERT_FALSE(input.valve_open[1]);
    TEST_ASSERT_TRUE(input.valve_open[2]);
    TEST_ASSERT_TRUE(input.latch_on[0]);
    TEST_ASSERT_FALSE(input.latch_on[1]);             // That latch belongs to another box.
    TEST_ASSERT_EQUAL_STRING("PUSH2", changed_valve); // No valve is at output 16.
    TEST_ASSERT_FALSE(is_open);
    // An error of a scenario appears in the box, and disappears.
    const device_model_t* model = device_model(devices, 1U);
    for (unsigned i = 0U; i < 2U; i++) {
        model->set_error(model->model, EMERGENCY_OVER_CURRENT, i == 0U, bus_now_ns(segments[0].bus));
        TEST_ASSERT_EQUAL(i == 0U, node_has_error(model->node, EMERGENCY_OVER_CURRENT, 0U));
    }
}

static void a_missing_data_sheet_is_reported(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, open_from("/nowhere"));
    TEST_ASSERT_NULL(devices);
    char expected[SIMULATOR_ERROR_MAX];
    (void)snprintf(expected, sizeof expected, "simulator: %s:%u: /nowhere/joint-drive.eds: ", world.path,
                   world.drive[0].device.line);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, error, strlen(expected));
    // The data sheet of a joystick does not fit a drive.
    (void)strcpy(world.bench[0].device.eds, "joystick.eds");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, open_from("descriptors/devices"));
    (void)snprintf(expected, sizeof expected, "simulator: %s:%u: ", world.path, world.bench[0].device.line);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, error, strlen(expected));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "joystick.eds"), error);
}

static void the_power_unit_switches_the_devices_that_the_world_names(void)
{
    static power_unit_t unit;
    (void)strcpy(world.power_unit[0].supply[0], "MOTOR");
    world.power_unit[0].supply_count = 1U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, open_from("descriptors/devices"));
    devices_power_on(devices);
    supply_open(&unit, &world.power_unit[0], segments, 3U, NULL, devices);
    TEST_ASSERT_NOT_NULL(segments[0].listen);
    TEST_ASSERT_NULL(segments[2].listen);
    // A pulse of 20 ms on line 2 opens the relay of the first device that the power unit supplies.
    segments[0].listen(segments[0].listener,
                       &(osal_can_frame_t){.id = 0x21FU, .length = 3U, .data = {2U, 0U, 1U}});
    power_unit_step(&unit, 100000000U);
    TEST_ASSERT_FALSE(node_is_powered(device_model(devices, 3U)->node));
    TEST_ASSERT_TRUE(node_is_powered(device_model(devices, 0U)->node));
}

static void devices_of_a_bus_with_a_second_channel_are_on_both_channels(void)
{
    channel_b[2] = segments[1].bus;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, open_from("descriptors/devices"));
    TEST_ASSERT_LESS_THAN_UINT(BUS_NODES_MAX,
                               node_bus_index(device_model(devices, 3U)->node, NODE_CHANNEL_B));
    TEST_ASSERT_EQUAL_UINT(BUS_NODES_MAX, node_bus_index(device_model(devices, 0U)->node, NODE_CHANNEL_B));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_device_boots_on_its_bus_and_is_reported);
    RUN_TEST(without_power_brakes_hold_and_motors_rest);
    RUN_TEST(valves_and_latches_follow_their_outputs);
    RUN_TEST(a_missing_data_sheet_is_reported);
    RUN_TEST(the_power_unit_switches_the_devices_that_the_world_names);
    RUN_TEST(devices_of_a_bus_with_a_second_channel_are_on_both_channels);
    return UNITY_END();
}
