// SPDX-License-Identifier: Apache-2.0
// INSTRUMENTS with its real descriptor reduced to the device MIRROR; the test acts as the device.
#include "fsw/subsystems/instruments/instruments.h"
#include "test/support/shm_device.h"
#include "test/support/subsystem_double.h"

#include "base/crc.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MS_NS 1000000U
#define RECORD_OCTETS 9U
#define COMMAND_OCTETS 7U

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_t generic;
static instruments_t own;
static flow_shm_t to_flight;
static flow_shm_t to_device;
static int32_t value;  ///< Position of the axis [1e-6 rad].
static uint16_t count; ///< Number of records that the device has sent.

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)snprintf(out_address->address, ENDNODE_ADDRESS_MAX, "/test-instruments-%d.%.20s", (int)getpid(),
                   name);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

/// Act as the device: send a record with its value, and receive the last command.
static void act_as_device(uint8_t command[COMMAND_OCTETS])
{
    const uint32_t raw            = (uint32_t)value;
    uint8_t record[RECORD_OCTETS] = {
        (uint8_t)(count >> 8U), (uint8_t)count,       0U,          (uint8_t)(raw >> 24U),
        (uint8_t)(raw >> 16U),  (uint8_t)(raw >> 8U), (uint8_t)raw};
    const uint16_t checksum = crc16_ccitt(record, RECORD_OCTETS - 2U);
    record[7]               = (uint8_t)(checksum >> 8U);
    record[8]               = (uint8_t)checksum;
    count++;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&to_flight, record));
    (void)flow_shm_step(&to_device, generic.now_ns);
    while (flow_shm_read(&to_device, command) == STATUS_OK) {
    }
}

static void run_cycles(status_t (*const action)(void* self), const unsigned cycles,
                       uint8_t command[COMMAND_OCTETS])
{
    for (unsigned i = 0U; i < cycles; i++) {
        act_as_device(command);
        (void)double_cycle(&generic, action, generic.state != STATE_HARDWARE_INIT);
        generic.now_ns += MS_NS;
    }
    act_as_device(command);
}

static status_t configure(void* const self)
{
    return generic.callbacks->configure(self, &descriptor.configurations[0]);
}

void setUp(void)
{
    uint8_t command[COMMAND_OCTETS];
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL(
        STATUS_OK, descriptor_load_subsystem(&loader, "descriptors/subsystems/instruments.xml", &descriptor));
    descriptor.device_count                           = 1U;
    descriptor.storage.configurations[0].device_count = 1U;
    value                                             = 0;
    double_init(&generic, &descriptor, instruments_callbacks(), &own);
    instruments_init(&own, &generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&generic));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      shm_device_open(&to_flight, (shm_device_end_t){"mirror.in", RECORD_OCTETS}, &to_device,
                                      (shm_device_end_t){"mirror.out", COMMAND_OCTETS}, &resolver, 0U));
    generic.now_ns    = MS_NS;
    generic.period_ns = MS_NS;
    generic.state     = STATE_HARDWARE_INIT;
    run_cycles(generic.callbacks->hardware_init, 5U, command);
    generic.state = STATE_PRE_OPERATIONAL;
    run_cycles(configure, 2U, command);
    generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, generic.callbacks->engage(&own));
}

void tearDown(void)
{
    generic.callbacks->release(&own);
    flow_shm_close(&to_flight);
    flow_shm_close(&to_device);
}

static void the_axis_is_commanded_and_its_arrival_is_reported_once(void)
{
    uint8_t command[COMMAND_OCTETS] = {0U};
    const uint8_t expected[5]       = {1U, 0x00U, 0x07U, 0xA1U, 0x20U}; // Enabled, to 500000.
    own.parameters.target[0]        = 0.5;
    run_cycles(NULL, 3U, command);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, command, 5U);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, INSTRUMENTS_EVENT_ARRIVED));
    value = 499000;
    run_cycles(NULL, 10U, command);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, INSTRUMENTS_EVENT_ARRIVED));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.499, own.parameters.cur_values.value[0]);
    // The last record was sent after the last cycle.
    TEST_ASSERT_EQUAL_UINT16(count - 2U, own.parameters.cur_values.count[0]);
    TEST_ASSERT_EQUAL_UINT8(0U, own.parameters.cur_values.lost[0]);
    TEST_ASSERT_TRUE(own.parameters.counters.received[0] > 10U);
    TEST_ASSERT_TRUE(own.parameters.counters.sent[0] > 10U);
}

static void out_of_operation_the_axis_is_disabled(void)
{
    uint8_t command[COMMAND_OCTETS] = {1U};
    generic.state                   = STATE_SAFE_OPERATIONAL;
    own.parameters.target[0]        = 0.5;
    run_cycles(NULL, 3U, command);
    TEST_ASSERT_EQUAL_HEX8(0U, command[0]);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, INSTRUMENTS_EVENT_ARRIVED));
}

static void stop_holds_the_present_value(void)
{
    uint8_t command[COMMAND_OCTETS]  = {0U};
    const subsystem_function_t stop  = {.function_id = INSTRUMENTS_FUNCTION_STOP};
    const subsystem_function_t other = {.function_id = 99U};
    own.parameters.target[0]         = 0.5;
    value                            = 100000;
    run_cycles(NULL, 3U, command);
    TEST_ASSERT_EQUAL(STATUS_OK, generic.callbacks->perform(&own, &stop));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1, own.parameters.target[0]);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, generic.callbacks->perform(&own, &other));
}

static void the_descriptor_fits_the_subsystem(void)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_TRUE_MESSAGE(generic.callbacks->fits(&descriptor, &misfit), misfit.reason);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_axis_is_commanded_and_its_arrival_is_reported_once);
    RUN_TEST(out_of_operation_the_axis_is_disabled);
    RUN_TEST(stop_holds_the_present_value);
    RUN_TEST(the_descriptor_fits_the_subsystem);
    return UNITY_END();
}
