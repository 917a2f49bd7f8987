// SPDX-License-Identifier: Apache-2.0
// Homing of the axes whose devices the descriptor puts into mode homing, together with modules and other
// drives.
#include "fsw/drives/drives_fitting.h"
#include "fsw/drives/drives_homing.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

#include <string.h>

#define DRIVE(name, mode, node)                                                                              \
    "<Device name='" name "' type='joint-drive'><Setting object='0x6060:00' type='INT8' value='" mode        \
    "'/><Endnode type='CAN' bus='robot' node='" node "'/></Device>\n"
#define VALVES "<Device name='V' type='valve-box'><Endnode type='CAN' bus='robot' node='0x3A'/></Device>\n"
// The stream device precedes the drives, so the position of a drive among all devices differs from its
// position among the devices on CAN.
#define STREAM                                                                                               \
    "<Device name='S' type='stream'><Field name='V' direction='IN' type='UINT8'/>"                           \
    "<Endnode type='SHM' name='s' silence='20ms' retry='1ms' retryLongest='2ms'/></Device>\n"
#define CONFIGURATION(name, id, devices)                                                                     \
    "<Configuration name='" name "' id='" id "' priority='80' samplingTime='1ms'><Devices>\n" devices        \
    "</Devices></Configuration>\n"

static const char document[] =
    "<Subsystem name='ARM' id='20'><Parameters/><Events/><Functions/>\n" CONFIGURATION(
        "ONE", "1", STREAM DRIVE("A", "6", "0x11") DRIVE("B", "8", "0x12") VALVES DRIVE("C", "6", "0x13"))
        CONFIGURATION("NONE", "2", DRIVE("A", "8", "0x11")) "</Subsystem>\n";

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t bus;
static scripted_node_t* nodes[3];
static scripted_node_t* valves;
static subsystem_t generic;
static drives_t drives;
static const subsystem_callbacks_t callbacks = {
    .sense = drives_sense, .emit = drives_emit, .secure = drives_secure};

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "test", document, sizeof document - 1U, &descriptor),
        descriptor_error(&loader));
    scripted_bus_open(&bus, "test-homing");
    for (uint8_t i = 0U; i < 3U; i++) {
        nodes[i] = scripted_bus_add(&bus, SCRIPTED_DRIVE, (uint8_t)(0x11U + i));
    }
    valves = scripted_bus_add(&bus, SCRIPTED_VALVES, 0x3AU);
    double_init(&generic, &descriptor, &callbacks, &drives);
    generic.configuration = &descriptor.configurations[0];
    drives_init(&drives, &generic, &resolver, NULL);
}

void tearDown(void)
{
    drives_release(&drives);
    scripted_bus_close(&bus);
}

typedef status_t (*action_t)(void* self);

static status_t cycle(const action_t action)
{
    const status_t status = double_cycle(&generic, action, false);
    scripted_bus_run(&bus);
    generic.now_ns += generic.period_ns;
    if ((generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    return status;
}

static void run(const action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 1000U); i++) {
        status = cycle(action);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
}

static status_t configure(void* const self)
{
    return drives_configure(self, generic.configuration);
}

static void engage(void)
{
    run(drives_hardware_init);
    run(configure);
    run(drives_start_control);
    run(drives_engage);
}

static status_t result(uint8_t* const out_node)
{
    (void)cycle(NULL);
    (void)cycle(NULL);
    return drives_homing(&drives, out_node);
}

static void the_axes_in_mode_homing_search_and_no_others(void)
{
    uint8_t node = 0U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_home(&drives, true)); // No configuration is active yet.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, drives_homing(&drives, &node));
    engage();
    TEST_ASSERT_EQUAL(STATUS_EMPTY, drives_homing(&drives, &node));
    TEST_ASSERT_EQUAL(STATUS_OK, drives_home(&drives, true));
    TEST_ASSERT_EQUAL(STATUS_BUSY, result(&node));
    TEST_ASSERT_EQUAL_HEX16(0x001FU, nodes[0]->control[0]);
    TEST_ASSERT_EQUAL_HEX16(0x000FU, nodes[1]->control[0]);
    TEST_ASSERT_EQUAL_HEX16(0x001FU, nodes[2]->control[0]);
    nodes[2]->status[0] |= 0x1400U; // The axes end their search one after the other.
    TEST_ASSERT_EQUAL(STATUS_BUSY, result(&node));
    nodes[0]->status[0] |= 0x1400U;
    TEST_ASSERT_EQUAL(STATUS_OK, result(&node));
    TEST_ASSERT_EQUAL_HEX8(0U, node);
    TEST_ASSERT_EQUAL(STATUS_OK, drives_home(&drives, false));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, result(&node));
    TEST_ASSERT_EQUAL_HEX16(0x000FU, nodes[0]->control[0]);
}

static void the_error_of_one_axis_names_its_node(void)
{
    uint8_t node = 0U;
    engage();
    TEST_ASSERT_EQUAL(STATUS_OK, drives_home(&drives, true));
    (void)cycle(NULL);
    nodes[0]->status[0] |= 0x1400U;
    nodes[2]->status[0] |= 0x2400U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, result(&node));
    TEST_ASSERT_EQUAL_HEX8(0x13U, node);
    nodes[0]->status[0] = 0x2637U;
    nodes[2]->status[0] = 0x1637U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, result(&node));
    TEST_ASSERT_EQUAL_HEX8(0x11U, node);
}

static void leaving_operation_ends_the_search(void)
{
    uint8_t node = 0U;
    engage();
    TEST_ASSERT_EQUAL(STATUS_OK, drives_home(&drives, true));
    run(drives_disengage);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, result(&node));
    run(drives_engage);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, result(&node));
    TEST_ASSERT_EQUAL_HEX16(0x000FU, nodes[0]->control[0]);
}

static void a_configuration_without_homing_has_no_search(void)
{
    uint8_t node          = 0U;
    generic.configuration = &descriptor.configurations[1];
    engage();
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_home(&drives, true));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, drives_homing(&drives, &node));
}

/// An output module has no state machine, so drives_secure sets its outputs to zero.
static void securing_sets_outputs_to_zero(void)
{
    engage();
    canopen_device_t* const device = drives_device(&drives, 2U);
    for (uint8_t i = 2U; i < 5U; i++) {
        canopen_device_set_value(device, i, 5.0);
    }
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_HEX8(5U, valves->outputs[0]);
    (void)cycle(drives_secure);
    static const uint8_t zeros[4] = {0U};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(zeros, valves->outputs, 4U);
    run(drives_secure);
}

static void modules_are_accepted_only_where_the_subsystem_allows_them(void)
{
    static const int modes[] = {8, 6, 0};
    drives_need_t need       = {1U, true, "type", 0U, "count", modes, "mode", true};
    subsystem_misfit_t misfit;
    TEST_ASSERT_TRUE(drives_fit(&descriptor, &need, &misfit));
    need.takes_modules = false;
    TEST_ASSERT_FALSE(drives_fit(&descriptor, &need, &misfit)); // Two modes in one configuration.
    TEST_ASSERT_EQUAL_STRING("mode", misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(5U, misfit.line);
    descriptor.storage.settings[descriptor.storage.devices[2].first_setting].bits = 6U;
    TEST_ASSERT_FALSE(drives_fit(&descriptor, &need, &misfit));
    TEST_ASSERT_EQUAL_STRING("type", misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(6U, misfit.line);
    need.takes_modules                 = true;
    descriptor.storage.devices[1].type = "joystick"; // A joystick has two axes.
    TEST_ASSERT_FALSE(drives_fit(&descriptor, &need, &misfit));
    TEST_ASSERT_EQUAL_STRING("type", misfit.reason);
    descriptor.storage.devices[1].type                                            = "joint-drive";
    descriptor.storage.settings[descriptor.storage.devices[1].first_setting].bits = 10U;
    TEST_ASSERT_FALSE(drives_fit(&descriptor, &need, &misfit));
    TEST_ASSERT_EQUAL_STRING("mode", misfit.reason);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_axes_in_mode_homing_search_and_no_others);
    RUN_TEST(the_error_of_one_axis_names_its_node);
    RUN_TEST(leaving_operation_ends_the_search);
    RUN_TEST(a_configuration_without_homing_has_no_search);
    RUN_TEST(securing_sets_outputs_to_zero);
    RUN_TEST(modules_are_accepted_only_where_the_subsystem_allows_them);
    return UNITY_END();
}
