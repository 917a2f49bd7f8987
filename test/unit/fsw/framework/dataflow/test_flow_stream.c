// SPDX-License-Identifier: Apache-2.0
// The partners are real: the far end of a pseudo-terminal, a listening socket, a FIFO, a file. The test sets
// the time, so no step waits for a clock.
#define _GNU_SOURCE
#include "fsw/framework/dataflow/flow_stream.h"

#include "test/support/assertion.h"
#include "test/unit/fsw/framework/dataflow/sample_record.h"
#include "unity.h"

#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FIRST_NS 10U
#define LONGEST_NS 80U
#define OUTBOX 64U

static char directory[] = "/tmp/flow-stream-XXXXXX";
static char path[ENDNODE_ADDRESS_MAX];
static flow_stream_t flow;
static quota_t quota;
static uint8_t frame[32];
static uint8_t outbox[OUTBOX];
static uint64_t now_ns;
static int far; ///< The partner's end.
static osal_socket_t listener = OSAL_SOCKET_CLOSED;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    if (strcmp(name, "moon") == 0) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, path);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    far    = -1;
    now_ns = 0U;
    quota_init(&quota, 2U);
    (void)snprintf(path, sizeof path, "%s/device", directory);
}

void tearDown(void)
{
    flow_stream_close(&flow);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    if (far >= 0) {
        (void)close(far);
    }
    osal_socket_close(&listener);
    if (strncmp(path, directory, strlen(directory)) == 0) { // Do not remove a device of the machine.
        (void)unlink(path);
    }
}

static void begin(const flow_endnode_kind_t kind, const char* const name, const flow_format_t format)
{
    const flow_stream_setup_t setup = {.kind             = kind,
                                       .name             = name,
                                       .format           = format,
                                       .frame            = frame,
                                       .frame_octets     = sizeof frame,
                                       .outbox           = outbox,
                                       .outbox_octets    = OUTBOX,
                                       .retry_first_ns   = FIRST_NS,
                                       .retry_longest_ns = LONGEST_NS,
                                       .quota            = &quota};
    flow_stream_init(&flow, &setup, &resolver);
}

/// Step until the flow is connected, or the longest delay has passed.
static status_t step_on(void)
{
    status_t status = STATUS_CLOSED;
    for (unsigned i = 0U; (i < 1000U) && (status != STATUS_OK); i++) {
        status = flow_stream_step(&flow, now_ns);
        now_ns += (status == STATUS_BUSY) ? 0U : 1U;
    }
    return status;
}

/// The next frame, even if the system hands it over late.
static void expect(const void* const octets, const size_t size)
{
    const uint8_t* payload = NULL;
    size_t held            = 0U;
    status_t status        = STATUS_EMPTY;
    for (unsigned i = 0U; (i < 20000U) && (status == STATUS_EMPTY); i++) {
        status = flow_stream_receive(&flow, &payload, &held);
        if (status == STATUS_EMPTY) {
            (void)poll(NULL, 0U, 1);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL_UINT64(size, held);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, payload, size);
}

static void expect_nothing(const status_t expected)
{
    const uint8_t* payload = NULL;
    size_t held            = 1U;
    status_t status        = STATUS_EMPTY;
    for (unsigned i = 0U; (i < 20U) && (status == STATUS_EMPTY) && (expected != STATUS_EMPTY); i++) {
        (void)poll(NULL, 0U, 5);
        status = flow_stream_receive(&flow, &payload, &held);
    }
    TEST_ASSERT_EQUAL(expected, flow_stream_receive(&flow, &payload, &held));
    TEST_ASSERT_EQUAL_UINT64(0U, held);
}

/// Octets that the partner receives.
static void expect_far(const void* const octets, const size_t size)
{
    uint8_t seen[256];
    size_t held = 0U;
    while (held < size) {
        struct pollfd watched = {.fd = far, .events = POLLIN};
        TEST_ASSERT_EQUAL(1, poll(&watched, 1U, 20000));
        const ssize_t some = read(far, &seen[held], size - held);
        TEST_ASSERT_TRUE(some > 0);
        held += (size_t)some;
    }
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, seen, size);
}

static void say_far(const void* const octets, const size_t size)
{
    TEST_ASSERT_EQUAL((ssize_t)size, write(far, octets, size));
}

static status_t say(const void* const octets, const size_t size)
{
    return flow_stream_send(&flow, octets, size);
}

// ---- Serial line ----

static void begin_line(void)
{
    far = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(far >= 0);
    TEST_ASSERT_EQUAL(0, grantpt(far));
    TEST_ASSERT_EQUAL(0, unlockpt(far));
    TEST_ASSERT_EQUAL(0, ptsname_r(far, path, sizeof path));
}

static void a_serial_line_carries_frames_both_ways(void)
{
    begin_line();
    begin(ENDNODE_SERIAL, "imu", (flow_format_t){.framing = FLOW_FRAMING_SLIP, .baud = 115200U});
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("x", 1U)); // The line is not open yet.
    expect_nothing(STATUS_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_stream_step(&flow, now_ns));
    TEST_ASSERT_TRUE(flow.link.is_open);
    TEST_ASSERT_EQUAL(STATUS_OK, say("a\300b", 3U));
    expect_far("\300a\333\334b\300", 6U);
    expect_nothing(STATUS_EMPTY);
    say_far("\300one\300two\300th", 11U);
    expect("one", 3U);
    expect("two", 3U);
    say_far("ree\300", 4U);
    expect("three", 5U);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.sent);
    TEST_ASSERT_EQUAL_UINT32(3U, flow.counters.received);
    TEST_ASSERT_EQUAL_UINT32(6U, flow.counters.octets_out);
    TEST_ASSERT_EQUAL_UINT32(15U, flow.counters.octets_in);
    TEST_ASSERT_EQUAL_UINT16(1U, quota.stats.used);
}

static void a_single_octet_is_passed_on(void)
{
    begin_line();
    begin(ENDNODE_SERIAL, "imu", (flow_format_t){.framing = FLOW_FRAMING_RAW, .baud = 115200U});
    TEST_ASSERT_EQUAL(STATUS_OK, flow_stream_step(&flow, now_ns));
    TEST_ASSERT_EQUAL(STATUS_OK, say("x", 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.octets_out);
    expect_far("x", 1U);
}

static void a_disconnected_serial_line_is_opened_again(void)
{
    begin_line();
    begin(ENDNODE_SERIAL, "imu", (flow_format_t){.framing = FLOW_FRAMING_LINE, .baud = 9600U});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    say_far("whole\nhal", 9U);
    expect("whole", 5U);
    expect_nothing(STATUS_EMPTY);
    (void)close(far);
    expect_nothing(STATUS_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow.link.failure);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.assembler.counters.cut);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.link.reconnect.lost);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, step_on()); // No partner: the flow tries again with increasing delays.
    TEST_ASSERT_TRUE(flow.link.reconnect.failed > 5U);
    TEST_ASSERT_TRUE(flow.link.reconnect.failed < 20U);
    begin_line(); // The system may give the line another name, so ask for the address again.
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    say_far("f\n", 2U);
    expect("f", 1U); // The beginning "hal" of the closed line was dropped.
}

static void a_refused_serial_line_is_reported_with_the_reason(void)
{
    static const struct {
        const char* path;
        uint32_t baud;
        status_t failure;
    } cases[] = {{"/dev/no-such-line", 9600U, STATUS_NOT_FOUND},
                 {"/dev/null", 9600U, STATUS_INVALID},
                 {"/dev/null", 1U, STATUS_OUT_OF_RANGE}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        (void)strcpy(path, cases[i].path);
        begin(ENDNODE_SERIAL, "imu", (flow_format_t){.baud = cases[i].baud});
        TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_stream_step(&flow, 0U));
        TEST_ASSERT_EQUAL(cases[i].failure, flow.link.failure);
        TEST_ASSERT_EQUAL_UINT32(1U, flow.link.reconnect.failed);
    }
    begin(ENDNODE_SERIAL, "moon", (flow_format_t){.baud = 9600U});
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_stream_step(&flow, 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow.link.failure);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
}

static void records_have_the_byte_order_of_the_flow(void)
{
    for (unsigned order = 0U; order < (unsigned)FLOW_ORDERS; order++) {
        const flow_format_t format = {
            .framing = FLOW_FRAMING_LENGTH, .order = (flow_order_t)order, .baud = 19200U};
        const bool is_big                = (order == (unsigned)FLOW_ORDER_BIG);
        uint8_t wire[SAMPLE_OCTETS + 2U] = {is_big ? 0U : SAMPLE_OCTETS, is_big ? SAMPLE_OCTETS : 0U};
        const uint8_t unfit[]            = {is_big ? 0U : 1U, is_big ? 1U : 0U, 7U};
        sample_t seen                    = {.number = 9U};
        status_t status                  = STATUS_EMPTY;
        (void)memcpy(&wire[2], sample_wire[order], SAMPLE_OCTETS);
        begin_line();
        begin(ENDNODE_SERIAL, "imu", format);
        TEST_ASSERT_EQUAL(STATUS_OK, step_on());
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_stream_receive_record(&flow, &sample_layout, &seen));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_stream_send_record(&flow, &sample_layout, &sample));
        expect_far(wire, sizeof wire);
        say_far(unfit, sizeof unfit);
        for (unsigned i = 0U; (i < 20000U) && (status == STATUS_EMPTY); i++) {
            status = flow_stream_receive_record(&flow, &sample_layout, &seen);
            (void)poll(NULL, 0U, 1);
        }
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, status);
        TEST_ASSERT_EQUAL_UINT16(9U, seen.number);
        TEST_ASSERT_EQUAL_UINT32(1U, flow.counters.unfit);
        say_far(wire, sizeof wire);
        status = STATUS_EMPTY;
        for (unsigned i = 0U; (i < 20000U) && (status == STATUS_EMPTY); i++) {
            status = flow_stream_receive_record(&flow, &sample_layout, &seen);
            (void)poll(NULL, 0U, 1);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, status);
        TEST_ASSERT_TRUE(is_sample(&seen));
        flow_stream_close(&flow);
        (void)close(far);
    }
    far = -1;
}

static void send_a_giant(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_stream_send_record(&flow, &giant_layout, giant_record));
}

static void a_record_that_is_too_long_is_a_coding_error(void)
{
    begin(ENDNODE_SERIAL, "imu", (flow_format_t){.framing = FLOW_FRAMING_SLIP});
    TEST_ASSERT_TRUE(assertion_fails(send_a_giant));
}

// ---- TCP, as client ----

static void listen_at(const uint16_t port)
{
    osal_address_t local = {OSAL_IPV4_LOOPBACK, port};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_listen(&listener, local));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&listener, &local));
    (void)snprintf(path, sizeof path, "127.0.0.1:%u", (unsigned)local.port);
}

static void accept_far(void)
{
    osal_socket_t arrived;
    osal_address_t from;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&listener, 20000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&listener, &arrived, &from));
    far = osal_socket_descriptor(&arrived);
}

static void a_client_repeats_its_connection_attempts_until_the_server_is_back(void)
{
    listen_at(0U);
    char* const port = strchr(path, ':') + 1;
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LENGTH});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    accept_far();
    TEST_ASSERT_EQUAL(STATUS_OK, say("hello", 5U));
    expect_far("\000\005hello", 7U);
    say_far("\000\002me\000", 5U);
    expect("me", 2U);
    osal_socket_close(&listener);
    (void)close(far);
    expect_nothing(STATUS_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("lost", 4U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, step_on());
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow.link.failure); // Refused.
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    listen_at((uint16_t)atoi(port));
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    accept_far();
    say_far("\000\001x", 3U);
    expect("x", 1U);
    TEST_ASSERT_EQUAL_UINT32(2U, flow.link.reconnect.connected);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.assembler.counters.cut);
}

static void a_server_that_does_not_read_fills_the_outbox(void)
{
    uint8_t payload[32] = {0U};
    status_t status     = STATUS_OK;
    listen_at(0U);
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LENGTH});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    accept_far();
    uint32_t count = 0U;
    while (status == STATUS_OK) {
        status = say(payload, sizeof payload);
        count += (status == STATUS_OK) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_EQUAL(STATUS_FULL, say(payload, sizeof payload));
    TEST_ASSERT_EQUAL_UINT32(2U, flow.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(count, flow.counters.sent);
    for (uint64_t left = (uint64_t)count * 34U; left > 0U;) { // All octets of the accepted frames.
        uint8_t octets[4096];
        const ssize_t some = read(far, octets, (left < sizeof octets) ? left : sizeof octets);
        if (some > 0) {
            left -= (uint64_t)some;
        }
        (void)flow_stream_step(&flow, now_ns);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, say("x", 1U));
    expect_far("\000\001x", 3U);
    flow_stream_close(&flow);
    TEST_ASSERT_FALSE(flow.link.is_open);
}

static void octets_in_the_outbox_are_discarded_with_their_connection(void)
{
    uint8_t payload[32] = {0U};
    listen_at(0U);
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LENGTH});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    accept_far();
    while (say(payload, sizeof payload) == STATUS_OK) {
    }
    (void)close(far);
    far = -1;
    for (unsigned i = 0U; (i < 1000U) && flow.link.is_open; i++) {
        (void)flow_stream_step(&flow, now_ns);
        (void)poll(NULL, 0U, 1);
    }
    TEST_ASSERT_FALSE(flow.link.is_open);
    TEST_ASSERT_TRUE(flow.counters.discarded > 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    accept_far();
    TEST_ASSERT_EQUAL(STATUS_OK, say("x", 1U));
    expect_far("\000\001x", 3U); // The new connection begins with a frame.
}

static void frames_that_cannot_be_sent_are_refused(void)
{
    uint8_t payload[OUTBOX] = {0U};
    listen_at(0U);
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LINE});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    TEST_ASSERT_EQUAL(STATUS_INVALID, say("a\nb", 3U));
    TEST_ASSERT_EQUAL(STATUS_FULL, say(payload, sizeof payload)); // With its line end the frame never fits.
    TEST_ASSERT_EQUAL_UINT32(2U, flow.counters.refused);
    flow_stream_close(&flow);
    (void)strcpy(path, "here");
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LINE});
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_stream_step(&flow, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow.link.failure);
}

static void an_opening_beyond_the_quota_is_refused(void)
{
    listen_at(0U);
    begin(ENDNODE_TCP, "server", (flow_format_t){.framing = FLOW_FRAMING_LINE});
    quota_init(&quota, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, quota_take(&quota));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_stream_step(&flow, now_ns));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, flow.link.failure);
    TEST_ASSERT_EQUAL_UINT32(1U, quota.stats.refused);
    quota_give(&quota);
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
}

// ---- Files and devices ----

static void a_file_is_read_as_it_grows(void)
{
    far = open(path, O_CREAT | O_WRONLY | O_APPEND, 0600);
    say_far("one\ntw", 6U);
    begin(ENDNODE_FILE, "sensor",
          (flow_format_t){.framing = FLOW_FRAMING_LINE, .direction = FLOW_DIRECTION_READ});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    expect("one", 3U);
    expect_nothing(STATUS_EMPTY);
    say_far("o\n", 2U);
    expect("two", 3U);
    TEST_ASSERT_TRUE(flow.link.is_open);
}

static void a_fifo_waits_for_its_reader(void)
{
    TEST_ASSERT_EQUAL(0, mkfifo(path, 0600));
    begin(ENDNODE_FILE, "actuator",
          (flow_format_t){.framing = FLOW_FRAMING_LINE, .direction = FLOW_DIRECTION_WRITE});
    TEST_ASSERT_EQUAL(STATUS_CLOSED, step_on());
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow.link.failure);
    far = open(path, O_RDONLY | O_NONBLOCK);
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    TEST_ASSERT_EQUAL(STATUS_OK, say("on", 2U));
    expect_far("on\n", 3U);
    (void)close(far);
    far = -1;
    TEST_ASSERT_EQUAL(STATUS_OK, say("off", 3U)); // The octets are accepted and lost with the connection.
    TEST_ASSERT_FALSE(flow.link.is_open);
    TEST_ASSERT_EQUAL_UINT32(4U, flow.counters.discarded);
}

static void raw_octets_are_received_in_pieces_that_fit(void)
{
    (void)strcpy(path, "/dev/zero");
    begin(ENDNODE_FILE, "zeros", (flow_format_t){.framing = FLOW_FRAMING_RAW});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    const uint8_t* payload = NULL;
    size_t size            = 0U;
    for (unsigned i = 0U; i < 1000U; i++) { // As many octets as requested, never more than fit.
        TEST_ASSERT_EQUAL(STATUS_OK, flow_stream_receive(&flow, &payload, &size));
        TEST_ASSERT_EQUAL_UINT64(sizeof frame, size);
    }
}

static void endless_octets_without_a_frame_are_read_up_to_a_limit(void)
{
    (void)strcpy(path, "/dev/zero");
    begin(ENDNODE_FILE, "zeros", (flow_format_t){.framing = FLOW_FRAMING_SLIP});
    TEST_ASSERT_EQUAL(STATUS_OK, step_on());
    const uint8_t* payload = NULL;
    size_t size            = 0U;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_stream_receive(&flow, &payload, &size));
    TEST_ASSERT_EQUAL_UINT32(16U * FLOW_STREAM_CHUNK, flow.counters.octets_in);
    TEST_ASSERT_EQUAL_UINT32(1U, flow.assembler.counters.oversize);
}

static void wrong_kind(void)
{
    begin(ENDNODE_CAN, "robot", (flow_format_t){.baud = 0U});
}

static void an_end_node_kind_without_stream_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(wrong_kind));
}

int main(void)
{
    if (mkdtemp(directory) == NULL) {
        return 1;
    }
    UNITY_BEGIN();
    begin(ENDNODE_FILE, "nothing", (flow_format_t){.baud = 0U});
    RUN_TEST(a_serial_line_carries_frames_both_ways);
    RUN_TEST(a_single_octet_is_passed_on);
    RUN_TEST(a_disconnected_serial_line_is_opened_again);
    RUN_TEST(a_refused_serial_line_is_reported_with_the_reason);
    RUN_TEST(records_have_the_byte_order_of_the_flow);
    RUN_TEST(a_record_that_is_too_long_is_a_coding_error);
    RUN_TEST(a_client_repeats_its_connection_attempts_until_the_server_is_back);
    RUN_TEST(a_server_that_does_not_read_fills_the_outbox);
    RUN_TEST(octets_in_the_outbox_are_discarded_with_their_connection);
    RUN_TEST(frames_that_cannot_be_sent_are_refused);
    RUN_TEST(an_opening_beyond_the_quota_is_refused);
    RUN_TEST(a_file_is_read_as_it_grows);
    RUN_TEST(a_fifo_waits_for_its_reader);
    RUN_TEST(raw_octets_are_received_in_pieces_that_fit);
    RUN_TEST(endless_octets_without_a_frame_are_read_up_to_a_limit);
    RUN_TEST(an_end_node_kind_without_stream_is_a_coding_error);
    const int failures = UNITY_END();
    (void)rmdir(directory);
    return failures;
}
