// SPDX-License-Identifier: Apache-2.0
// How a device uses its end node: how many records it takes at once, and when it gives up a connection
// without records. The end node is mocked.
#include "fsw/devices/stream_device.h"

#include "test/unit/fsw/devices/descriptors.h"
#include "unity.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define RECORD_OCTETS 4U
#define RECORDS_AT_ONCE 64
#define MS_NS 1000000U
#define SILENCE_MS 20U

static subsystem_descriptor_t descriptor;
static stream_device_t device;
static const flow_resolver_t resolver;

status_t __wrap_flow_step(flow_t* flow, uint64_t now_ns)
{
    assert_ptr_equal(&device.flow, flow);
    check_expected(now_ns);
    return mock_type(status_t);
}

status_t __wrap_flow_receive(flow_t* flow, uint8_t* octets, size_t* out_size)
{
    assert_ptr_equal(&device.flow, flow);
    (void)memset(octets, 0, RECORD_OCTETS);
    *out_size = RECORD_OCTETS;
    return mock_type(status_t);
}

status_t __wrap_flow_send(flow_t* flow, const uint8_t* octets, size_t size)
{
    assert_ptr_equal(&device.flow, flow);
    check_expected_ptr(octets);
    assert_int_equal(3U, size);
    return mock_type(status_t);
}

void __wrap_flow_give_up(flow_t* flow)
{
    assert_ptr_equal(&device.flow, flow);
    function_called();
}

void __wrap_flow_close(flow_t* flow)
{
    assert_ptr_equal(&device.flow, flow);
    function_called();
}

static int begin(void** state)
{
    (void)state;
    if (!TEST_PROTECT()) {
        return 1; // The fixture has printed its assertion.
    }
    load_document(BEGIN AXIS("A", "<Endnode type='SERIAL' name='a' silence='20ms' retry='1ms' "
                                  "retryLongest='2ms'/>") END,
                  &descriptor);
    stream_device_init(&device, &descriptor, &descriptor.devices[0], &resolver);
    return 0;
}

/// Run a cycle in which opening the end node returns this status and the end node gives this number of
/// records.
static void cycle(const uint64_t now_ns, const status_t opened, const int records)
{
    expect_value(__wrap_flow_step, now_ns, now_ns);
    will_return(__wrap_flow_step, opened);
    if (records > 0) {
        will_return_count(__wrap_flow_receive, STATUS_OK, records);
    }
    if ((opened == STATUS_OK) && (records < RECORDS_AT_ONCE)) {
        will_return(__wrap_flow_receive, STATUS_EMPTY);
    }
    stream_device_sense(&device, now_ns);
}

static void a_device_that_never_pauses_does_not_delay_a_cycle(void** state)
{
    (void)state;
    cycle(MS_NS, STATUS_OK, RECORDS_AT_ONCE);
    assert_int_equal(RECORDS_AT_ONCE, device.counters.received);
    cycle(2U * MS_NS, STATUS_OK, 3);
    assert_int_equal(RECORDS_AT_ONCE + 3, device.counters.received);
}

/// A connection without records may be dead: it is given up when it has been silent for SILENCE_MS, counted
/// from its opening or from its last record.
static void a_new_connection_is_not_given_up_before_its_time(void** state)
{
    uint64_t now_ns = MS_NS;
    (void)state;
    assert_int_equal(STATUS_BUSY, stream_device_open(&device, now_ns));
    for (unsigned i = 0U; i < (3U * SILENCE_MS); i++) { // No connection is open, so none is given up.
        cycle(now_ns, STATUS_CLOSED, 0);
        now_ns += MS_NS;
    }
    assert_int_equal(STATUS_BUSY, stream_device_open(&device, now_ns));
    for (unsigned i = 0U; i < SILENCE_MS; i++) {
        cycle(now_ns, STATUS_OK, 0);
        now_ns += MS_NS;
    }
    expect_function_call(__wrap_flow_give_up);
    cycle(now_ns, STATUS_OK, 0);
    cycle(now_ns + MS_NS, STATUS_OK, 1); // The time begins again with this record.
    cycle(now_ns + (SILENCE_MS * MS_NS), STATUS_OK, 0);
    expect_function_call(__wrap_flow_give_up);
    cycle(now_ns + ((SILENCE_MS + 1U) * MS_NS), STATUS_OK, 0);
}

static void a_connection_that_closes_within_a_cycle_is_a_loss(void** state)
{
    (void)state;
    assert_int_equal(STATUS_BUSY, stream_device_open(&device, MS_NS));
    cycle(MS_NS, STATUS_OK, 0);
    assert_int_equal(STATUS_BUSY, stream_device_start(&device, MS_NS)); // It has sent nothing yet.
    cycle(MS_NS, STATUS_OK, 1);
    assert_int_equal(STATUS_OK, stream_device_start(&device, MS_NS));
    expect_value(__wrap_flow_step, now_ns, 2U * MS_NS);
    will_return(__wrap_flow_step, STATUS_OK);
    will_return(__wrap_flow_receive, STATUS_CLOSED);
    stream_device_sense(&device, 2U * MS_NS);
    stream_device_fault_t fault;
    assert_int_equal(STATUS_OK, stream_device_take_fault(&device, &fault));
    assert_int_equal(STREAM_DEVICE_LOST, fault.kind);
    assert_int_equal(STREAM_CAUSE_CLOSED, fault.cause);
    stream_device_command(&device); // No record is sent, because the end node is closed.
    expect_function_call(__wrap_flow_close);
    stream_device_close(&device);
}

static void refused_records_are_counted_and_a_full_end_node_delays_the_stop(void** state)
{
    static const uint8_t safe[] = {0U, 0U, 4U};
    static const struct {
        status_t returned;
        status_t stopped;
    } rows[] = {{STATUS_FULL, STATUS_BUSY}, {STATUS_CLOSED, STATUS_OK}, {STATUS_IO, STATUS_OK}};
    (void)state;
    assert_int_equal(STATUS_BUSY, stream_device_open(&device, MS_NS));
    cycle(MS_NS, STATUS_OK, 1);
    for (unsigned i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        expect_memory(__wrap_flow_send, octets, safe, sizeof safe);
        will_return(__wrap_flow_send, rows[i].returned);
        assert_int_equal(rows[i].stopped, stream_device_stop(&device));
        assert_int_equal(i + 1U, device.counters.refused);
    }
    assert_int_equal(0U, device.counters.sent);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_device_that_never_pauses_does_not_delay_a_cycle, begin),
        cmocka_unit_test_setup(a_new_connection_is_not_given_up_before_its_time, begin),
        cmocka_unit_test_setup(a_connection_that_closes_within_a_cycle_is_a_loss, begin),
        cmocka_unit_test_setup(refused_records_are_counted_and_a_full_end_node_delays_the_stop, begin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
