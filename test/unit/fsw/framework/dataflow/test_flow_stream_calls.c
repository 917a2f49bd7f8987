// SPDX-License-Identifier: Apache-2.0
// What a flow on a stream does if the system accepts few octets at once, or hands over late the octets that
// the device has announced in stepped time. Device, socket and counts are mocked.
#include "fsw/framework/dataflow/flow_stream.h"

#include "osal/include/osal/serial.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define OUTBOX 64U

static flow_stream_t flow;
static uint8_t frame[32];
static uint8_t outbox[OUTBOX];

status_t __wrap_osal_serial_open(osal_device_t* device, const char* path, uint32_t baud)
{
    assert_ptr_equal(&flow.device, device);
    assert_string_equal("imu", path);
    assert_int_equal(115200U, baud);
    return mock_type(status_t);
}

status_t __wrap_osal_tcp_connect_begin(osal_socket_t* connection, osal_address_t to)
{
    assert_ptr_equal(&flow.socket, connection);
    assert_int_equal(0x7F000001U, to.ipv4);
    assert_int_equal(9U, to.port);
    return mock_type(status_t);
}

/// Accepts as many octets as the test sets.
status_t __wrap_osal_device_write(osal_device_t* device, const uint8_t* octets, size_t size,
                                  size_t* out_written)
{
    assert_ptr_equal(&flow.device, device);
    assert_ptr_equal(outbox, octets);
    check_expected(size);
    *out_written = mock_type(size_t);
    return mock_type(status_t);
}

static status_t read_words(uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    const char* const words = mock_ptr_type(const char*);
    *out_size               = strlen(words);
    assert_true(*out_size <= capacity);
    (void)memcpy(octets, words, *out_size);
    return (*out_size > 0U) ? STATUS_OK : STATUS_EMPTY;
}

status_t __wrap_osal_device_read(osal_device_t* device, uint8_t* octets, size_t capacity, size_t* out_size)
{
    assert_ptr_equal(&flow.device, device);
    return read_words(octets, capacity, out_size);
}

status_t __wrap_osal_stream_receive(osal_socket_t* connection, uint8_t* octets, size_t capacity,
                                    size_t* out_size)
{
    assert_ptr_equal(&flow.socket, connection);
    return read_words(octets, capacity, out_size);
}

status_t __wrap_osal_device_wait_readable(osal_device_t* device, uint32_t timeout_ms)
{
    assert_ptr_equal(&flow.device, device);
    assert_int_equal(OSAL_HAND_OVER_TIMEOUT_MS, timeout_ms);
    function_called();
    return mock_type(status_t);
}

status_t __wrap_osal_socket_wait_readable(osal_socket_t* connection, uint32_t timeout_ms)
{
    assert_ptr_equal(&flow.socket, connection);
    assert_int_equal(OSAL_HAND_OVER_TIMEOUT_MS, timeout_ms);
    function_called();
    return mock_type(status_t);
}

uint32_t __wrap_osal_hand_over_due(const osal_hand_over_t* hand_over)
{
    assert_ptr_equal(&flow.counts, hand_over);
    return mock_type(uint32_t);
}

void __wrap_osal_hand_over_give_up(osal_hand_over_t* hand_over)
{
    assert_ptr_equal(&flow.counts, hand_over);
    function_called();
}

void __wrap_osal_hand_over_take(osal_hand_over_t* hand_over, uint32_t count)
{
    assert_ptr_equal(&flow.counts, hand_over);
    check_expected(count);
}

void __wrap_osal_hand_over_announce(osal_hand_over_t* hand_over, uint32_t count)
{
    assert_ptr_equal(&flow.counts, hand_over);
    check_expected(count);
}

static status_t resolve(void* context, flow_endnode_kind_t kind, const char* name,
                        flow_endnode_address_t* out_address)
{
    (void)context;
    (void)kind;
    (void)strcpy(out_address->address, name);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static void begin(const flow_endnode_kind_t kind, const char* const name, const flow_framing_t framing)
{
    const flow_stream_setup_t setup = {.kind             = kind,
                                       .name             = name,
                                       .format           = {.framing = framing, .baud = 115200U},
                                       .frame            = frame,
                                       .frame_octets     = sizeof frame,
                                       .outbox           = outbox,
                                       .outbox_octets    = OUTBOX,
                                       .retry_first_ns   = 1U,
                                       .retry_longest_ns = 1U};
    flow_stream_init(&flow, &setup, &resolver);
    assert_int_equal(STATUS_OK, flow_stream_step(&flow, 0U));
}

static int close_flow(void** state)
{
    (void)state;
    flow_stream_close(&flow);
    return 0;
}

/// Expect that the flow writes `held` octets, of which the device accepts `taken`.
static void expect_write(const size_t held, const size_t taken, const status_t status)
{
    expect_value(__wrap_osal_device_write, size, held);
    will_return(__wrap_osal_device_write, taken);
    will_return(__wrap_osal_device_write, status);
    if (status == STATUS_OK) {
        expect_value(__wrap_osal_hand_over_announce, count, taken);
    }
}

static void a_line_that_takes_few_octets_at_once_gets_all_in_order(void** state)
{
    (void)state;
    will_return(__wrap_osal_serial_open, STATUS_OK);
    begin(ENDNODE_SERIAL, "imu", FLOW_FRAMING_SLIP);
    expect_write(12U, 3U, STATUS_OK);
    expect_write(9U, 5U, STATUS_OK);
    expect_write(4U, 0U, STATUS_FULL);
    assert_int_equal(STATUS_OK, flow_stream_send(&flow, (const uint8_t*)"0123456789", 10U));
    assert_memory_equal("789\300", outbox, 4U); // Octets that the line has not taken.
    assert_int_equal(8U, flow.counters.octets_out);
    expect_write(4U, 4U, STATUS_OK);
    assert_int_equal(STATUS_OK, flow_stream_step(&flow, 1U));
    assert_int_equal(12U, flow.counters.octets_out);
    assert_int_equal(0U, flow.outbox_held);
}

static void expect_read(const char* const words)
{
    will_return(read_words, words);
}

static void expect_taken(const size_t count)
{
    expect_value(__wrap_osal_hand_over_take, count, count);
}

/// No octets are announced, so the flow does not wait for the empty device.
static void nothing_is_due(void)
{
    const uint8_t* payload = NULL;
    size_t held            = 1U;
    expect_read("");
    will_return(__wrap_osal_hand_over_due, 0U);
    expect_taken(0U);
    assert_int_equal(STATUS_EMPTY, flow_stream_receive(&flow, &payload, &held));
    assert_int_equal(0U, held);
}

/// The octets arrive within the wait that the test expects.
static void octets_come_late(void)
{
    const uint8_t* payload = NULL;
    size_t held            = 0U;
    expect_read("");
    will_return(__wrap_osal_hand_over_due, 4U);
    expect_read("two\n");
    expect_taken(4U);
    assert_int_equal(STATUS_OK, flow_stream_receive(&flow, &payload, &held));
    assert_int_equal(3U, held);
    assert_memory_equal("two", payload, held);
}

/// Octets that do not arrive within the wait that the test expects count as lost.
static void octets_do_not_come(void)
{
    const uint8_t* payload = NULL;
    size_t held            = 1U;
    expect_read("");
    will_return(__wrap_osal_hand_over_due, 4U);
    expect_function_call(__wrap_osal_hand_over_give_up);
    expect_taken(0U);
    assert_int_equal(STATUS_EMPTY, flow_stream_receive(&flow, &payload, &held));
    assert_int_equal(0U, held);
    assert_true(flow.link.is_open);
}

static void announced_octets_of_a_line_are_waited_for(void** state)
{
    (void)state;
    will_return(__wrap_osal_serial_open, STATUS_OK);
    begin(ENDNODE_SERIAL, "imu", FLOW_FRAMING_LINE);
    nothing_is_due();
    expect_function_call(__wrap_osal_device_wait_readable);
    will_return(__wrap_osal_device_wait_readable, STATUS_TIMEOUT);
    octets_do_not_come();
    expect_function_call(__wrap_osal_device_wait_readable);
    will_return(__wrap_osal_device_wait_readable, STATUS_OK);
    octets_come_late();
}

static void announced_octets_of_a_connection_are_waited_for(void** state)
{
    (void)state;
    will_return(__wrap_osal_tcp_connect_begin, STATUS_OK);
    begin(ENDNODE_TCP, "127.0.0.1:9", FLOW_FRAMING_LINE);
    nothing_is_due();
    expect_function_call(__wrap_osal_socket_wait_readable);
    will_return(__wrap_osal_socket_wait_readable, STATUS_TIMEOUT);
    octets_do_not_come();
    expect_function_call(__wrap_osal_socket_wait_readable);
    will_return(__wrap_osal_socket_wait_readable, STATUS_OK);
    octets_come_late();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_line_that_takes_few_octets_at_once_gets_all_in_order, close_flow),
        cmocka_unit_test_teardown(announced_octets_of_a_line_are_waited_for, close_flow),
        cmocka_unit_test_teardown(announced_octets_of_a_connection_are_waited_for, close_flow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
