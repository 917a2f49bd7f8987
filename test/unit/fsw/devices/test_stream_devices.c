// SPDX-License-Identifier: Apache-2.0
// Devices at end nodes in shared memory, UDP, TCP and serial lines; the test acts as the devices. The generic
// subsystem is a test double.
#include "fsw/devices/stream_devices.h"

#include "test/support/shm_device.h"
#include "test/support/subsystem_double.h"
#include "test/unit/fsw/devices/descriptors.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MS_NS 1000000U
#define SILENCE_MS 20U
#define COMMAND_OCTETS 3U
#define RECORD_OCTETS 4U

#define TWO_DEVICES                                                                                          \
    BEGIN AXIS("A", "<Endnode type='SHM' name='a' silence='20ms' retry='1ms' retryLongest='2ms'/>")          \
        AXIS("B", "<Endnode type='SHM' name='b' silence='20ms' retry='1ms' retryLongest='2ms'/>") END

static subsystem_descriptor_t descriptor;
static subsystem_t generic;
static stream_devices_t devices;
static flow_shm_t to_flight[2];
static flow_shm_t to_device[2];
static uint16_t count;

static char udp_peer[ENDNODE_ADDRESS_MAX]; ///< Name of the last peer that was looked up.
static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if (kind == ENDNODE_SERIAL) {
        (void)strcpy(out_address->address, "/nowhere/tty");
    } else if ((kind == ENDNODE_UDP) || (kind == ENDNODE_TCP)) {
        if (name[0] != ':') {
            (void)snprintf(udp_peer, sizeof udp_peer, "%s", name);
        }
        (void)snprintf(out_address->address, ENDNODE_ADDRESS_MAX, "127.0.0.1:%s",
                       (name[0] == ':') ? "0" : "9");
    } else {
        (void)snprintf(out_address->address, ENDNODE_ADDRESS_MAX, "/test-devices-%d.%.20s", (int)getpid(),
                       name);
    }
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static void plug(const unsigned index)
{
    static const char* const in[]  = {"a.in", "b.in"};
    static const char* const out[] = {"a.out", "b.out"};
    TEST_ASSERT_EQUAL(STATUS_OK,
                      shm_device_open(&to_flight[index], (shm_device_end_t){in[index], RECORD_OCTETS},
                                      &to_device[index], (shm_device_end_t){out[index], COMMAND_OCTETS},
                                      &resolver, generic.now_ns));
}

static void unplug(const unsigned index)
{
    flow_shm_close(&to_flight[index]);
    flow_shm_close(&to_device[index]);
}

static void begin(const char* const document)
{
    static const subsystem_callbacks_t callbacks = {.sense = stream_devices_sense,
                                                    .emit  = stream_devices_emit};
    load_document(document, &descriptor);
    double_init(&generic, &descriptor, &callbacks, &devices);
    generic.now_ns    = MS_NS;
    generic.period_ns = MS_NS;
    stream_devices_init(&devices, &generic, &resolver);
}

void setUp(void)
{
    begin(TWO_DEVICES);
    plug(0U);
    plug(1U);
}

void tearDown(void)
{
    stream_devices_release(&devices);
    unplug(0U);
    unplug(1U);
}

static void send_record(const unsigned index)
{
    const uint8_t record[RECORD_OCTETS] = {(uint8_t)(count >> 8U), (uint8_t)count, 0xFFU, 0xFEU};
    count++;
    if (flow_shm_step(&to_flight[index], generic.now_ns) == STATUS_OK) {
        (void)!flow_shm_write(&to_flight[index], record);
    }
}

/// Take the last command that a device has received. False: it has received none since the last call.
static bool last_command(const unsigned index, uint8_t command[COMMAND_OCTETS])
{
    bool has_any = false;
    (void)flow_shm_step(&to_device[index], generic.now_ns);
    while (flow_shm_read(&to_device[index], command) == STATUS_OK) {
        has_any = true;
    }
    return has_any;
}

static status_t configuration_action(void* const self)
{
    return stream_devices_configure(self, &descriptor.configurations[0]);
}

/// Cycles of 1 ms with records of the devices whose bits are set, until the action is done.
static status_t run_cycles(status_t (*const action)(void* self), const unsigned senders,
                           const unsigned cycles)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (i < cycles) && (status == STATUS_BUSY); i++) {
        for (unsigned k = 0U; k < 2U; k++) {
            if (((senders >> k) & 1U) != 0U) {
                send_record(k);
            }
        }
        status = double_cycle(&generic, action, false);
        status = (action != NULL) ? status : STATUS_BUSY;
        generic.now_ns += MS_NS;
    }
    return status;
}

static void bring_up(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(stream_devices_hardware_init, 3U, 50U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configuration_action, 3U, 50U));
}

static void expect_event(const uint16_t id, const uint8_t device, const uint8_t cause)
{
    const double_event_t* const event = double_last_event(&generic, id);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_UINT8(device, event->octets[0]);
    if (event->size > 1U) {
        TEST_ASSERT_EQUAL_UINT8(cause, event->octets[1]);
    }
}

static void devices_are_brought_up_measured_and_commanded(void)
{
    uint8_t command[COMMAND_OCTETS];
    TEST_ASSERT_NULL(stream_devices_at(&devices, 0U));
    bring_up();
    stream_device_t* const device = stream_devices_at(&devices, 1U);
    TEST_ASSERT_NOT_NULL(device);
    TEST_ASSERT_NULL(stream_devices_at(&devices, 2U));
    TEST_ASSERT_EQUAL_STRING("B", device->name);
    TEST_ASSERT_EQUAL_UINT8(1U, stream_device_field(device, false, "VALUE"));
    TEST_ASSERT_EQUAL_UINT8(STREAM_DEVICE_NO_FIELD, stream_device_field(device, true, "VALUE"));
    TEST_ASSERT_TRUE(stream_device_value(device, 1U) == 0.0); // -2 * 0.5 + 1
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_set(device, 0U, 1.0));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_set(device, 1U, 2.0));
    (void)run_cycles(NULL, 3U, 1U);
    TEST_ASSERT_TRUE(last_command(1U, command));
    const uint8_t expected[COMMAND_OCTETS] = {1U, 0U, 2U};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, command, COMMAND_OCTETS);
    (void)run_cycles(NULL, 0U, 1U);
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

static void a_silent_device_is_lost_once_and_returns(void)
{
    bring_up();
    (void)run_cycles(NULL, 1U, SILENCE_MS - 1U);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, 5U));
    (void)run_cycles(NULL, 1U, 30U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 5U));
    expect_event(5U, 1U, STREAM_CAUSE_SILENT);
    TEST_ASSERT_TRUE(stream_device_is_lost(stream_devices_at(&devices, 1U)));
    TEST_ASSERT_FALSE(stream_device_is_lost(stream_devices_at(&devices, 0U)));
    (void)run_cycles(NULL, 3U, 5U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 6U));
    expect_event(6U, 1U, 0U);
    TEST_ASSERT_FALSE(stream_device_is_lost(stream_devices_at(&devices, 1U)));
}

static void an_unplugged_device_is_lost_at_once_and_reconnects(void)
{
    bring_up();
    unplug(0U);
    (void)run_cycles(NULL, 2U, 1U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 5U));
    expect_event(5U, 0U, STREAM_CAUSE_CLOSED);
    (void)run_cycles(NULL, 2U, 2U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 5U));
    plug(0U);
    (void)run_cycles(NULL, 3U, 10U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 6U));
    TEST_ASSERT_TRUE(flow_counters(&stream_devices_at(&devices, 0U)->flow).connected > 2U);
}

static void a_missing_device_is_refused_with_its_cause_and_may_appear_later(void)
{
    unplug(1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(stream_devices_hardware_init, 1U, 60U));
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 4U));
    expect_event(4U, 1U, STREAM_CAUSE_CLOSED);
    plug(1U);
    // B is plugged in, but silent.
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(stream_devices_hardware_init, 1U, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(stream_devices_hardware_init, 3U, 10U));
}

static void a_device_that_falls_silent_before_it_is_started_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(stream_devices_hardware_init, 3U, 50U));
    (void)run_cycles(NULL, 1U, 40U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 4U));
    expect_event(4U, 1U, STREAM_CAUSE_SILENT);
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(configuration_action, 1U, 5U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configuration_action, 3U, 5U));
}

static void no_device_waits_for_another_to_be_secured(void)
{
    uint8_t command[COMMAND_OCTETS];
    const uint8_t safe[COMMAND_OCTETS] = {0U, 0U, 4U};
    bring_up();
    for (uint16_t i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, stream_device_set(stream_devices_at(&devices, i), 0U, 1.0));
    }
    (void)last_command(0U, command);
    (void)last_command(1U, command);
    (void)run_cycles(NULL, 3U, FLOW_DEPTH + 2U); // No device reads: both queues are full.
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_devices_secure(&devices));
    TEST_ASSERT_TRUE(last_command(1U, command));
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_devices_secure(&devices)); // The queue of A is still full.
    TEST_ASSERT_TRUE(last_command(1U, command));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(safe, command, COMMAND_OCTETS);
    TEST_ASSERT_TRUE(last_command(0U, command));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_devices_secure(&devices));
    TEST_ASSERT_TRUE(last_command(0U, command));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(safe, command, COMMAND_OCTETS);
    TEST_ASSERT_TRUE(stream_devices_at(&devices, 0U)->counters.refused > 0U);
    unplug(0U);
    (void)run_cycles(NULL, 2U, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_devices_secure(&devices)); // A lost device delays nothing.
}

static void the_post_step_stops_devices_and_deinit_closes_them(void)
{
    uint8_t command[COMMAND_OCTETS];
    const uint8_t safe[COMMAND_OCTETS] = {0U, 0U, 4U};
    bring_up();
    (void)last_command(0U, command);
    (void)last_command(1U, command);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_devices_post(&devices));
    TEST_ASSERT_TRUE(last_command(0U, command));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(safe, command, COMMAND_OCTETS);
    (void)run_cycles(NULL, 3U, 3U);
    TEST_ASSERT_FALSE(last_command(0U, command)); // A stopped device gets no commands.
    TEST_ASSERT_EQUAL(STATUS_OK, stream_devices_hardware_deinit(&devices));
    TEST_ASSERT_NULL(stream_devices_at(&devices, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      run_cycles(stream_devices_hardware_init, 3U, 50U)); // The devices can be opened again.
    TEST_ASSERT_EQUAL_UINT32(0U, stream_devices_at(&devices, 0U)->counters.sent);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configuration_action, 3U, 50U));
}

static status_t sense_after(stream_device_t* const device, const unsigned ms,
                            stream_device_fault_t* const out_fault)
{
    generic.now_ns += (uint64_t)ms * MS_NS;
    stream_device_sense(device, generic.now_ns);
    return stream_device_take_fault(device, out_fault);
}

/// Closing a device clears its state and its reported faults.
static void a_closed_device_starts_from_the_beginning(void)
{
    stream_device_fault_t fault;
    bring_up();
    stream_device_t* const device = stream_devices_at(&devices, 0U);
    stream_device_close(device);
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_device_boot(device));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, sense_after(device, 5U * SILENCE_MS,
                                                &fault)); // The device is not in use, so it has no fault.
    for (unsigned i = 0U; i < 2U; i++) {
        (void)stream_device_open(device, generic.now_ns); // The wait for a record begins now.
        TEST_ASSERT_EQUAL(STATUS_EMPTY, sense_after(device, SILENCE_MS - 1U, &fault));
        TEST_ASSERT_EQUAL(STATUS_OK, sense_after(device, 1U, &fault));
        TEST_ASSERT_EQUAL(STREAM_DEVICE_REFUSED, fault.kind);
        TEST_ASSERT_EQUAL(STATUS_EMPTY, sense_after(device, 1U, &fault));
        stream_device_close(device);
    }
}

static void closing_clears_a_loss_and_its_report(void)
{
    stream_device_fault_t fault;
    bring_up();
    stream_device_t* const device = stream_devices_at(&devices, 0U);
    generic.now_ns += SILENCE_MS * MS_NS;
    stream_device_sense(device, generic.now_ns);
    TEST_ASSERT_TRUE(stream_device_is_lost(device));
    stream_device_close(device);
    TEST_ASSERT_FALSE(stream_device_is_lost(device));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, stream_device_take_fault(device, &fault));
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_device_start(device, generic.now_ns));
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_device_open(device, generic.now_ns));
}

static void stop_waits_for_a_full_queue(void)
{
    uint8_t command[COMMAND_OCTETS];
    bring_up();
    (void)last_command(0U, command);
    (void)last_command(1U, command);
    (void)run_cycles(NULL, 3U, FLOW_DEPTH + 2U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_devices_post(&devices));
    TEST_ASSERT_TRUE(last_command(0U, command));
    TEST_ASSERT_TRUE(last_command(1U, command));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_devices_post(&devices));
}

static status_t second_configuration(void* const self)
{
    return stream_devices_configure(self, &descriptor.configurations[1]);
}

static void another_configuration_stops_the_devices_of_the_first(void)
{
    uint8_t command[COMMAND_OCTETS];
    stream_devices_release(&devices);
    begin(BEGIN AXIS("A", "<Endnode type='SHM' name='a' silence='20ms' retry='1ms' retryLongest='2ms'/>")
              NEXT_CONFIGURATION AXIS(
                  "B", "<Endnode type='SHM' name='b' silence='20ms' retry='1ms' retryLongest='2ms'/>") END);
    bring_up();
    (void)last_command(0U, command);
    (void)run_cycles(NULL, 3U, FLOW_DEPTH + 2U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(second_configuration, 3U,
                                              2U)); // The queue of A has no room for the safe record.
    TEST_ASSERT_TRUE(last_command(0U, command));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(second_configuration, 3U, 5U));
    TEST_ASSERT_TRUE(last_command(1U, command));
    (void)last_command(0U, command);
    (void)run_cycles(NULL, 3U, 2U);
    TEST_ASSERT_FALSE(last_command(0U, command));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      run_cycles(second_configuration, 3U, 5U)); // The configuration is already active.
}

static void a_configuration_without_devices_stops_all_devices_in_use(void)
{
    uint8_t command[COMMAND_OCTETS];
    stream_devices_release(&devices);
    begin(BEGIN AXIS("A", "<Endnode type='SHM' name='a' silence='20ms' retry='1ms' retryLongest='2ms'/>")
              AXIS("B", "<Endnode type='SHM' name='b' silence='20ms' retry='1ms' retryLongest='2ms'/>")
                  NEXT_CONFIGURATION END);
    bring_up();
    (void)last_command(0U, command);
    (void)last_command(1U, command);
    TEST_ASSERT_EQUAL(STATUS_OK, second_configuration(&devices));
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_TRUE(last_command(i, command)); // The safe record, and no other.
        (void)run_cycles(NULL, 3U, 2U);
        TEST_ASSERT_FALSE(last_command(i, command));
    }
}

/// The devices in use are not stopped, so nothing waits for them.
static void the_same_configuration_again_takes_no_time(void)
{
    bring_up();
    (void)run_cycles(NULL, 3U, FLOW_DEPTH + 2U); // Both queues are full.
    TEST_ASSERT_EQUAL(STATUS_OK, configuration_action(&devices));
}

static void octets_that_are_no_record_are_counted_and_reported_as_the_cause(void)
{
    stream_devices_release(&devices);
    begin(BEGIN AXIS("A", "<Endnode type='SHM' name='a' checksum='true' silence='20ms' retry='1ms' "
                          "retryLongest='2ms'/>") END);
    const flow_shm_setup_t writer = {.name             = "a.in",
                                     .is_writer        = true,
                                     .shape            = {FLOW_SHM_QUEUE, RECORD_OCTETS + 2U, FLOW_DEPTH},
                                     .retry_first_ns   = 1U,
                                     .retry_longest_ns = 1U};
    unplug(0U);
    flow_shm_init(&to_flight[0], &writer, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&to_flight[0], 0U));
    for (unsigned i = 0U; i < 30U; i++) {
        const uint8_t garbage[RECORD_OCTETS + 2U] = {(uint8_t)i, 1U, 2U, 3U, 4U, 5U};
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&to_flight[0], garbage));
        TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(stream_devices_hardware_init, 0U, 1U));
        while (double_events(&generic, 4U) > 1U) {
            TEST_FAIL_MESSAGE("the refusal was reported twice");
        }
    }
    expect_event(4U, 0U, STREAM_CAUSE_MALFORMED);
    TEST_ASSERT_TRUE(stream_devices_at(&devices, 0U)->counters.unfit > 20U);
    TEST_ASSERT_EQUAL_UINT32(0U, stream_devices_at(&devices, 0U)->counters.received);
}

static void a_device_that_sends_nothing_is_present_while_its_end_node_is_open(void)
{
    stream_devices_release(&devices);
    begin(BEGIN "<Device name='LAMP' type='stream'><Field name='ON' direction='OUT' type='UINT8'/>"
                "<Endnode type='UDP' address='10.0.0.1' port='9'/></Device>"
                "<Device name='PLUG' type='stream'><Field name='IN' direction='IN' type='UINT8'/>"
                "<Endnode type='SERIAL' name='/dev/x' framing='SLIP' silence='5ms'/></Device>" END);
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(stream_devices_hardware_init, 0U, 20U));
    TEST_ASSERT_EQUAL_STRING("10.0.0.1:9", udp_peer);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_boot(stream_devices_at(&devices, 0U)));
    TEST_ASSERT_EQUAL(STATUS_BUSY, stream_device_boot(stream_devices_at(&devices, 1U)));
    expect_event(4U, 1U, STREAM_CAUSE_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_start(stream_devices_at(&devices, 0U), generic.now_ns));
    (void)run_cycles(NULL, 0U, 3U);
    TEST_ASSERT_EQUAL_UINT32(3U, stream_devices_at(&devices, 0U)->counters.sent);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_secure(stream_devices_at(&devices, 1U)));
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, 5U));
}

static void a_device_on_tcp_is_found_by_address_and_port(void)
{
    stream_devices_release(&devices);
    begin(BEGIN AXIS("A", "<Endnode type='TCP' address='10.0.0.2' port='7' framing='LENGTH' silence='20ms' "
                          "retry='1ms' retryLongest='2ms'/>") END);
    (void)run_cycles(stream_devices_hardware_init, 0U, 2U);
    TEST_ASSERT_EQUAL_STRING("10.0.0.2:7", udp_peer);
}

static void events_that_the_descriptor_does_not_define_are_not_raised(void)
{
    stream_devices_release(&devices);
    begin(
        "<Subsystem name='DOG' id='40' samplingTime='1ms'><Events><Event name='DEVICE_LOST' id='5' "
        "severity='LOW'><ParamRef name='X' type='UINT32'/></Event></Events><Configuration name='ONE' id='1' "
        "priority='60' samplingTime='1ms'><Devices>" AXIS(
            "A", "<Endnode type='SHM' name='a' silence='20ms' retry='1ms' retryLongest='2ms'/>") END);
    // No event DEVICE_REFUSED is defined.
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(stream_devices_hardware_init, 0U, 40U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(stream_devices_hardware_init, 1U, 40U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configuration_action, 1U, 40U));
    (void)run_cycles(NULL, 0U, 40U); // The fields of DEVICE_LOST differ.
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(devices_are_brought_up_measured_and_commanded);
    RUN_TEST(a_silent_device_is_lost_once_and_returns);
    RUN_TEST(an_unplugged_device_is_lost_at_once_and_reconnects);
    RUN_TEST(a_missing_device_is_refused_with_its_cause_and_may_appear_later);
    RUN_TEST(a_device_that_falls_silent_before_it_is_started_is_refused);
    RUN_TEST(no_device_waits_for_another_to_be_secured);
    RUN_TEST(the_post_step_stops_devices_and_deinit_closes_them);
    RUN_TEST(a_closed_device_starts_from_the_beginning);
    RUN_TEST(closing_clears_a_loss_and_its_report);
    RUN_TEST(stop_waits_for_a_full_queue);
    RUN_TEST(another_configuration_stops_the_devices_of_the_first);
    RUN_TEST(a_configuration_without_devices_stops_all_devices_in_use);
    RUN_TEST(the_same_configuration_again_takes_no_time);
    RUN_TEST(octets_that_are_no_record_are_counted_and_reported_as_the_cause);
    RUN_TEST(a_device_that_sends_nothing_is_present_while_its_end_node_is_open);
    RUN_TEST(a_device_on_tcp_is_found_by_address_and_port);
    RUN_TEST(events_that_the_descriptor_does_not_define_are_not_raised);
    return UNITY_END();
}
