// SPDX-License-Identifier: Apache-2.0
// On/off devices and pulses of ST[02]: which of them exist, which frame is sent, and how long the bus is
// borrowed.
#include "fsw/drives/drives_supply.h"

#include "fsw/drives/drives_access.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"
#include "unity.h"

#include <string.h>

#define MS 1000000U

static const char document[] =
    "<Subsystem name='ARM' id='20'><Parameters/><Events/><Functions/>\n"
    "<Configuration name='ONE' id='1' priority='80' samplingTime='500us'><Devices>\n"
    "<Device name='A' type='joint-drive'><Supply unit='0x1F' on='1' off='2'/>\n"
    "<Endnode type='CAN' bus='robot' node='0x11'/></Device>\n"
    "<Device name='B' type='joint-drive'><Supply unit='31' on='3' off='255'/>\n"
    "<Endnode type='CAN' bus='robot' node='0x12'/></Device>\n"
    "</Devices></Configuration></Subsystem>\n";

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t bus;
static bool has_bus;
static subsystem_t generic;
static drives_t drives;
static pus_device_port_t port;
static pus_device_result_t result;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    if (!has_bus) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static status_t parse(const char* const text)
{
    descriptor_loader_init(&loader);
    return descriptor_parse_subsystem(&loader, "test", text, strlen(text), &descriptor);
}

void setUp(void)
{
    static const subsystem_callbacks_t no_callback = {.emit = NULL};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, parse(document), descriptor_error(&loader));
    memset(&result, 0, sizeof result);
    has_bus = true;
    scripted_bus_open(&bus, "test-supply");
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    double_init(&generic, &descriptor, &no_callback, &drives);
    drives_init(&drives, &generic, &resolver, NULL);
    port = drives_access_port(&drives);
}

void tearDown(void)
{
    drives_release(&drives);
    scripted_bus_close(&bus);
}

static pus_device_action_t pulse(const uint16_t unit, const uint16_t line, const uint8_t exponent)
{
    return (pus_device_action_t){
        .kind = PUS_DEVICE_PULSE, .device = unit, .command = line, .exponent = exponent};
}

static pus_device_action_t turn(const uint16_t address)
{
    return (pus_device_action_t){.kind = PUS_DEVICE_SWITCH, .device = address};
}

static status_t check(const pus_device_action_t action)
{
    return port.check(port.context, &action);
}

static status_t begin(const uint8_t slot, const pus_device_action_t action)
{
    return port.begin(port.context, slot, &action, &result);
}

static status_t poll(const uint8_t slot)
{
    return port.poll(port.context, slot, &result);
}

static void only_declared_supplies_and_outputs_exist(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, check(turn(0x1F01U)));
    TEST_ASSERT_EQUAL(STATUS_OK, check(turn(0x1FFFU)));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, check(turn(0x1F04U)));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, check(turn(0x0001U)));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, check(turn(0x9F01U)));
    TEST_ASSERT_EQUAL(STATUS_OK, check(pulse(0x1FU, 3U, 7U)));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, check(pulse(0x20U, 3U, 7U)));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check(pulse(0x1FU, 4U, 7U)));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, check(pulse(0x1FU, 0x101U, 7U)));
}

static void a_pulse_is_a_frame_on_the_open_bus(void)
{
    TEST_ASSERT_EQUAL(STATUS_BUSY, drives_hardware_init(&drives));
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, pulse(0x1FU, 255U, 5U)));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(1U, turn(0x1F03U)));
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL_UINT(2U, scripted_bus_count(&bus, 0x21FU));
    TEST_ASSERT_EQUAL_UINT8(3U, bus.seen[0].length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){255U, 0U, 5U}), bus.seen[0].data, 3U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){3U, 0U, DRIVES_SUPPLY_EXPONENT}), bus.seen[1].data, 3U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, poll(0U));
    generic.now_ns += DRIVES_SUPPLY_LEAVE_NS;
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, poll(1U));
    TEST_ASSERT_TRUE(flow_can_is_open(drives.buses[0].network.flow));
}

static void a_closed_bus_is_borrowed(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U)));
    generic.now_ns += MS;
    TEST_ASSERT_EQUAL(STATUS_OK, begin(1U, turn(0x1F02U)));
    generic.now_ns += DRIVES_SUPPLY_LEAVE_NS - MS;
    TEST_ASSERT_EQUAL(STATUS_BUSY, poll(0U)); // The second frame has not been sent yet.
    generic.now_ns += MS;
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL_UINT(2U, scripted_bus_count(&bus, 0x21FU));
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
    TEST_ASSERT_EQUAL(STATUS_OK, poll(1U));
}

static void hardware_init_keeps_the_borrowed_bus(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U)));
    TEST_ASSERT_EQUAL(STATUS_BUSY, drives_hardware_init(&drives));
    generic.now_ns += DRIVES_SUPPLY_LEAVE_NS;
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_TRUE(flow_can_is_open(drives.buses[0].network.flow));
}

static void an_abandoned_pulse_releases_the_bus(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, begin(2U, turn(0x1F01U)));
    port.abandon(port.context, 2U);
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
}

static void without_a_bus_the_command_fails(void)
{
    has_bus = false;
    TEST_ASSERT_EQUAL(STATUS_IO, begin(0U, turn(0x1F01U)));
    TEST_ASSERT_EQUAL_UINT16(DRIVES_ACCESS_CLOSED, result.return_code);
}

static void a_supply_with_one_line_for_on_and_off_is_refused(void)
{
    static char text[sizeof document];
    (void)strcpy(text, document);
    char* const off = strstr(text, "off='2'");
    TEST_ASSERT_NOT_NULL(off);
    off[5] = '1';
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse(text));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), "a line other than that of on"));
}

/// The bus is released 10 ms after the last frame and not earlier.
static void a_frame_has_10_ms_to_leave(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U)));
    generic.now_ns += 10U * MS - 1U;
    TEST_ASSERT_EQUAL(STATUS_BUSY, poll(0U));
    TEST_ASSERT_TRUE(flow_can_is_open(drives.buses[0].network.flow));
    generic.now_ns += 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U))); // The bus can be borrowed again.
    port.abandon(port.context, 0U);
    // The end of the access releases the bus.
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
}

/// hardware_deinit takes the bus over: a pulse that ends afterwards does not close the bus too early.
static void hardware_deinit_keeps_the_bus_until_its_reset_has_left(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U)));
    TEST_ASSERT_EQUAL(STATUS_BUSY, drives_hardware_deinit(&drives));
    port.abandon(port.context, 0U);
    TEST_ASSERT_TRUE(flow_can_is_open(drives.buses[0].network.flow));
    TEST_ASSERT_EQUAL(STATUS_OK, drives_hardware_deinit(&drives));
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
}

static void pulses_wait_while_the_transmit_queue_is_full(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, drives_borrow(&drives));
    while (flow_can_send(drives.buses[0].network.flow, 0x7F0U, NULL, 0U) == STATUS_OK) {
        TEST_ASSERT_TRUE(drives.buses[0].network.flow->counters.sent <= OSAL_CAN_RING_FRAMES);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, begin(0U, turn(0x1F01U)));
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, turn(0x1F01U)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_declared_supplies_and_outputs_exist);
    RUN_TEST(a_pulse_is_a_frame_on_the_open_bus);
    RUN_TEST(a_closed_bus_is_borrowed);
    RUN_TEST(hardware_init_keeps_the_borrowed_bus);
    RUN_TEST(an_abandoned_pulse_releases_the_bus);
    RUN_TEST(without_a_bus_the_command_fails);
    RUN_TEST(a_supply_with_one_line_for_on_and_off_is_refused);
    RUN_TEST(a_frame_has_10_ms_to_leave);
    RUN_TEST(hardware_deinit_keeps_the_bus_until_its_reset_has_left);
    RUN_TEST(pulses_wait_while_the_transmit_queue_is_full);
    return UNITY_END();
}
