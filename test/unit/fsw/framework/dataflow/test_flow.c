// SPDX-License-Identifier: Apache-2.0
// One data flow on each type of end node except CAN. The device's end uses the functions of osal/; in shared
// memory and on message queues it uses flow_shm and flow_mqueue.
#define _GNU_SOURCE
#include "fsw/framework/dataflow/flow.h"

#include "unity.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define KINDS 6U
#define IN 4U          ///< Octets of a message from the device.
#define OUT 3U         ///< Octets of a message to the device.
#define FIRST_NS 10U   ///< Shortest time before an end node is opened again.
#define LONGEST_NS 40U ///< Longest one.

static const flow_endnode_kind_t kinds[KINDS] = {ENDNODE_SHM, ENDNODE_MQUEUE, ENDNODE_UDP,
                                                 ENDNODE_TCP, ENDNODE_SERIAL, ENDNODE_FILE};

static flow_t flow;
static quota_t quota;
static uint64_t now_ns;
static osal_address_t device_address;
static osal_address_t flight_address;
static char terminal[ENDNODE_ADDRESS_MAX];
static bool is_counted;
static char counts_name[ENDNODE_ADDRESS_MAX];
static osal_hand_over_t counts = OSAL_HAND_OVER_CLOSED;

// Objects of the device's end.
static flow_shm_t shm[2];
static flow_mqueue_t mqueue[2];
static osal_socket_t listener = OSAL_SOCKET_CLOSED;
static osal_socket_t sock     = OSAL_SOCKET_CLOSED;
static osal_device_t far      = OSAL_DEVICE_CLOSED;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    char* const address = out_address->address;
    if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        (void)snprintf(address, ENDNODE_ADDRESS_MAX, "/test-flow-%d.%.20s", (int)getpid(), name);
    } else if ((kind == ENDNODE_UDP) || (kind == ENDNODE_TCP)) {
        const bool is_own = (name[0] == ':');
        (void)snprintf(address, ENDNODE_ADDRESS_MAX, "127.0.0.1:%u",
                       (unsigned)(is_own ? flight_address.port : device_address.port));
    } else {
        (void)snprintf(address, ENDNODE_ADDRESS_MAX, "%.70s", terminal);
    }
    if (is_counted && (name[0] != ':')) {
        (void)snprintf(out_address->counts, ENDNODE_ADDRESS_MAX, "%.70s", counts_name);
    }
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static uint16_t free_port(void)
{
    osal_socket_t probe;
    osal_address_t address = {0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&probe, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&probe, &address));
    osal_socket_close(&probe);
    return address.port;
}

static void begin_terminal(void)
{
    struct termios mode;
    far.descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    TEST_ASSERT_TRUE(far.descriptor >= 0);
    TEST_ASSERT_EQUAL(0, grantpt(far.descriptor));
    TEST_ASSERT_EQUAL(0, unlockpt(far.descriptor));
    TEST_ASSERT_EQUAL(0, ptsname_r(far.descriptor, terminal, sizeof terminal));
    TEST_ASSERT_EQUAL(0, tcgetattr(far.descriptor, &mode));
    cfmakeraw(&mode);
    TEST_ASSERT_EQUAL(0, tcsetattr(far.descriptor, TCSANOW, &mode));
}

static void begin_device(const flow_endnode_kind_t kind)
{
    if (kind == ENDNODE_SHM) {
        flow_shm_setup_t setup = {.name             = "x.in",
                                  .is_writer        = true,
                                  .shape            = {FLOW_SHM_QUEUE, IN, FLOW_DEPTH},
                                  .retry_first_ns   = 1U,
                                  .retry_longest_ns = 1U};
        flow_shm_init(&shm[0], &setup, &resolver);
        setup.name      = "x.out";
        setup.is_writer = false;
        setup.shape     = (flow_shm_shape_t){FLOW_SHM_QUEUE, OUT, FLOW_DEPTH};
        flow_shm_init(&shm[1], &setup, &resolver);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&shm[0], 0U));
    } else if (kind == ENDNODE_MQUEUE) {
        flow_mqueue_setup_t setup = {
            .name = "x.in", .message_octets = IN, .retry_first_ns = 1U, .retry_longest_ns = 1U};
        flow_mqueue_init(&mqueue[0], &setup, &resolver);
        setup = (flow_mqueue_setup_t){.name             = "x.out",
                                      .is_receiver      = true,
                                      .depth            = FLOW_DEPTH,
                                      .message_octets   = OUT,
                                      .retry_first_ns   = 1U,
                                      .retry_longest_ns = 1U};
        flow_mqueue_init(&mqueue[1], &setup, &resolver);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&mqueue[1], 0U));
    } else if (kind == ENDNODE_UDP) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&sock, device_address, 0U));
    } else if (kind == ENDNODE_TCP) {
        // free_port asks for UDP: a connection of another program may have the same port for TCP.
        status_t status = osal_tcp_listen(&listener, device_address);
        for (unsigned i = 0U; (status == STATUS_EXISTS) && (i < 100U); i++) {
            device_address.port = free_port();
            status              = osal_tcp_listen(&listener, device_address);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, status);
    } else {
        begin_terminal();
    }
}

static void begin_flow(const flow_endnode_kind_t kind, const uint32_t octets_in, const uint32_t octets_out)
{
    const flow_setup_t setup = {.kind   = kind,
                                .name   = ((kind == ENDNODE_UDP) || (kind == ENDNODE_TCP)) ? "host:9" : "x",
                                .format = {.framing = FLOW_FRAMING_LENGTH, .baud = 115200U},
                                .octets_in        = octets_in,
                                .octets_out       = octets_out,
                                .retry_first_ns   = FIRST_NS,
                                .retry_longest_ns = LONGEST_NS,
                                .quota            = &quota};
    flow_init(&flow, &setup, &resolver);
}

static bool is_stream(const flow_endnode_kind_t kind)
{
    return (kind == ENDNODE_TCP) || (kind == ENDNODE_SERIAL) || (kind == ENDNODE_FILE);
}

static void accept_flight(const flow_endnode_kind_t kind)
{
    osal_address_t from;
    if ((kind == ENDNODE_TCP) && !osal_socket_is_open(&sock)) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&listener, 20000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tcp_accept(&listener, &sock, &from));
    }
    if (kind == ENDNODE_SHM) {
        now_ns += LONGEST_NS;
        (void)flow_shm_step(&shm[1], now_ns);
    }
    if (kind == ENDNODE_MQUEUE) {
        (void)flow_mqueue_step(&mqueue[0], now_ns);
    }
}

/// Step until the flow is open.
static void connect_flow(const flow_endnode_kind_t kind)
{
    unsigned steps = 0U;
    while ((flow_step(&flow, now_ns) != STATUS_OK) && (steps < 2000U)) {
        now_ns += LONGEST_NS;
        steps++;
        (void)usleep(1000U);
    }
    TEST_ASSERT_TRUE(steps < 2000U);
    accept_flight(kind);
}

static void send_octets(const flow_endnode_kind_t kind, const uint8_t* const octets, const size_t size)
{
    size_t sent = 0U;
    if (kind == ENDNODE_SHM) {
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&shm[0], octets));
    } else if (kind == ENDNODE_MQUEUE) {
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_send(&mqueue[0], octets, size));
    } else if (kind == ENDNODE_UDP) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&sock, flight_address, octets, size));
    } else if (kind == ENDNODE_TCP) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&sock, octets, size, &sent));
        TEST_ASSERT_EQUAL_UINT64(size, sent);
    } else {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&far, octets, size, &sent));
        TEST_ASSERT_EQUAL_UINT64(size, sent);
    }
    osal_hand_over_announce(&counts, (kind == ENDNODE_UDP) ? 1U : (uint32_t)size);
}

static void send_message(const flow_endnode_kind_t kind, const uint8_t message[IN])
{
    uint8_t framed[IN + 2U] = {0U, IN};
    (void)memcpy(&framed[2], message, IN);
    send_octets(kind, is_stream(kind) ? framed : message, is_stream(kind) ? sizeof framed : IN);
}

/// Expect this message next; the kernel may deliver it later.
static void expect_message(const uint8_t message[IN])
{
    uint8_t octets[FLOW_OCTETS_MAX];
    size_t size     = 0U;
    status_t status = STATUS_EMPTY;
    for (unsigned i = 0U; (i < 2000U) && (status == STATUS_EMPTY); i++) {
        status = flow_receive(&flow, octets, &size);
        if (status == STATUS_EMPTY) {
            (void)usleep(1000U);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL_UINT64(IN, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(message, octets, IN);
}

static void expect_at_device(const flow_endnode_kind_t kind, const uint8_t message[OUT])
{
    uint8_t seen[32]   = {0U};
    size_t size        = 0U;
    size_t held        = 0U;
    const size_t whole = is_stream(kind) ? (OUT + 2U) : OUT;
    osal_address_t from;
    for (unsigned i = 0U; (i < 2000U) && (held < whole); i++) {
        size = 0U;
        if ((kind == ENDNODE_SHM) && (flow_shm_read(&shm[1], seen) == STATUS_OK)) {
            size = OUT;
        } else if (kind == ENDNODE_MQUEUE) {
            (void)!flow_mqueue_receive(&mqueue[1], seen, sizeof seen, &size);
        } else if (kind == ENDNODE_UDP) {
            (void)!osal_udp_receive(&sock, &from, seen, sizeof seen, &size);
        } else if (kind == ENDNODE_TCP) {
            (void)!osal_stream_receive(&sock, &seen[held], sizeof seen - held, &size);
        } else if (is_stream(kind)) {
            (void)!osal_device_read(&far, &seen[held], sizeof seen - held, &size);
        } else {
            // No octet has arrived.
        }
        held += size;
        (void)usleep((size == 0U) ? 1000U : 0U);
    }
    TEST_ASSERT_EQUAL_UINT64(whole, held);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(message, &seen[whole - OUT], OUT);
}

static void end_device(void)
{
    if (shm[0].resolver != NULL) {
        flow_shm_close(&shm[0]);
        flow_shm_close(&shm[1]);
    }
    if (mqueue[0].resolver != NULL) {
        flow_mqueue_close(&mqueue[0]);
        flow_mqueue_close(&mqueue[1]);
    }
    osal_socket_close(&sock);
    osal_socket_close(&listener);
    osal_device_close(&far);
}

static void end_all(void)
{
    flow_close(&flow);
    end_device();
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
}

void setUp(void)
{
    now_ns         = 0U;
    is_counted     = false;
    device_address = (osal_address_t){OSAL_IPV4_LOOPBACK, free_port()};
    flight_address = (osal_address_t){OSAL_IPV4_LOOPBACK, free_port()};
    (void)memset(shm, 0, sizeof shm);
    (void)memset(mqueue, 0, sizeof mqueue);
    (void)snprintf(counts_name, sizeof counts_name, "/test-flow-%d.n", (int)getpid());
    quota_init(&quota, 4U);
}

void tearDown(void)
{
    if (osal_hand_over_is_open(&counts)) {
        osal_hand_over_close(&counts);
        (void)osal_shm_remove(counts_name);
    }
}

static void messages_pass_in_both_directions_on_each_type_of_end_node(void)
{
    static const uint8_t there[IN] = {1U, 0xC0U, 0xDBU, 4U};
    static const uint8_t back[OUT] = {9U, 8U, 0xC0U};
    for (unsigned i = 0U; i < KINDS; i++) {
        begin_device(kinds[i]);
        begin_flow(kinds[i], IN, OUT);
        connect_flow(kinds[i]);
        send_message(kinds[i], there);
        send_message(kinds[i], there);
        expect_message(there);
        expect_message(there);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_send(&flow, back, OUT));
        expect_at_device(kinds[i], back);
        uint8_t octets[FLOW_OCTETS_MAX];
        size_t size = 1U;
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
        TEST_ASSERT_EQUAL_UINT64(0U, size);
        TEST_ASSERT_EQUAL_UINT32(0U, flow_counters(&flow).malformed);
        TEST_ASSERT_TRUE(flow_counters(&flow).connected > 0U);
        end_all();
    }
}

/// Only these kinds of end nodes notice that there is no device.
static void a_flow_is_closed_until_there_is_a_device(void)
{
    static const flow_endnode_kind_t kinds_that_notice[] = {ENDNODE_SHM, ENDNODE_MQUEUE, ENDNODE_TCP,
                                                            ENDNODE_SERIAL};
    (void)strcpy(terminal, "/nowhere/tty");
    for (unsigned i = 0U; i < 4U; i++) {
        const uint8_t message[OUT] = {0U};
        uint8_t octets[FLOW_OCTETS_MAX];
        size_t size = 0U;
        begin_flow(kinds_that_notice[i], IN, OUT);
        for (unsigned k = 0U; k < 20U; k++) {
            TEST_ASSERT_NOT_EQUAL(STATUS_OK, flow_step(&flow, now_ns));
            now_ns += LONGEST_NS;
            (void)usleep(1000U);
        }
        if ((kinds_that_notice[i] == ENDNODE_SERIAL) || (kinds_that_notice[i] == ENDNODE_TCP)) {
            TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_send(&flow, message, OUT));
            TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_receive(&flow, octets, &size));
        }
        begin_device(kinds_that_notice[i]);
        connect_flow(kinds_that_notice[i]);
        end_all();
    }
}

/// Only these kinds of end nodes notice that the device is gone.
static void a_flow_connects_again_after_the_device_was_unplugged(void)
{
    static const flow_endnode_kind_t kinds_that_notice[] = {ENDNODE_SHM, ENDNODE_TCP, ENDNODE_SERIAL};
    static const uint8_t message[IN]                     = {5U, 6U, 7U, 8U};
    for (unsigned i = 0U; i < 3U; i++) {
        begin_device(kinds_that_notice[i]);
        begin_flow(kinds_that_notice[i], IN, OUT);
        connect_flow(kinds_that_notice[i]);
        const uint32_t connected = flow_counters(&flow).connected;
        end_device();
        uint8_t octets[FLOW_OCTETS_MAX];
        size_t size     = 0U;
        status_t status = STATUS_EMPTY;
        for (unsigned k = 0U; (k < 2000U) && (status != STATUS_CLOSED); k++) {
            status = flow_receive(&flow, octets, &size);
            (void)usleep(1000U);
        }
        TEST_ASSERT_EQUAL(STATUS_CLOSED, status);
        TEST_ASSERT_TRUE(flow_counters(&flow).lost > 0U);
        now_ns += LONGEST_NS;
        begin_device(kinds_that_notice[i]);
        connect_flow(kinds_that_notice[i]);
        TEST_ASSERT_TRUE(flow_counters(&flow).connected > connected);
        send_message(kinds_that_notice[i], message);
        expect_message(message);
        end_all();
    }
}

static void a_stream_of_invalid_octets_is_closed_and_opened_again(void)
{
    static const uint8_t message[IN] = {5U, 6U, 7U, 8U};
    static const uint8_t garbage[IN] = {0xFFU, 0xFFU, 1U, 2U}; // The length field announces 65535 octets.
    uint8_t octets[FLOW_OCTETS_MAX];
    size_t size = 0U;
    begin_device(ENDNODE_SERIAL);
    begin_flow(ENDNODE_SERIAL, IN, OUT);
    flow_give_up(&flow); // The flow is not open: no effect.
    connect_flow(ENDNODE_SERIAL);
    send_octets(ENDNODE_SERIAL, garbage, sizeof garbage);
    for (unsigned i = 0U; i < 20U; i++) {
        send_message(ENDNODE_SERIAL, message);
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
        (void)usleep(1000U);
    }
    flow_give_up(&flow);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_step(&flow, now_ns));
    now_ns += LONGEST_NS;
    connect_flow(ENDNODE_SERIAL);
    send_message(ENDNODE_SERIAL, message);
    expect_message(message);
    end_all();
    begin_device(ENDNODE_UDP);
    begin_flow(ENDNODE_UDP, IN, OUT);
    connect_flow(ENDNODE_UDP);
    flow_give_up(&flow);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_step(&flow, now_ns));
    end_all();
}

static void frames_too_long_for_a_message_are_counted_and_skipped(void)
{
    static const uint8_t message[IN] = {5U, 6U, 7U, 8U};
    uint8_t oversize[302]            = {1U, 44U}; // A frame of 300 octets.
    begin_device(ENDNODE_SERIAL);
    begin_flow(ENDNODE_SERIAL, IN, OUT);
    connect_flow(ENDNODE_SERIAL);
    send_octets(ENDNODE_SERIAL, oversize, sizeof oversize);
    send_message(ENDNODE_SERIAL, message);
    expect_message(message);
    TEST_ASSERT_EQUAL_UINT32(1U, flow_counters(&flow).malformed);
    end_all();
    begin_device(ENDNODE_UDP);
    begin_flow(ENDNODE_UDP, IN, OUT);
    connect_flow(ENDNODE_UDP);
    send_octets(ENDNODE_UDP, oversize, sizeof oversize);
    send_message(ENDNODE_UDP, message);
    expect_message(message);
    TEST_ASSERT_EQUAL_UINT32(1U, flow_counters(&flow).malformed);
    end_all();
}

static void a_device_that_only_receives_or_only_sends_has_one_queue(void)
{
    static const uint8_t back[OUT] = {1U, 2U, 3U};
    uint8_t octets[FLOW_OCTETS_MAX];
    size_t size = 0U;
    begin_device(ENDNODE_SHM);
    begin_flow(ENDNODE_SHM, 0U, OUT);
    connect_flow(ENDNODE_SHM);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_send(&flow, back, OUT));
    expect_at_device(ENDNODE_SHM, back);
    end_all();
    begin_device(ENDNODE_MQUEUE);
    begin_flow(ENDNODE_MQUEUE, IN, 0U);
    connect_flow(ENDNODE_MQUEUE);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
    TEST_ASSERT_EQUAL_UINT32(1U, flow_counters(&flow).connected);
    end_all();
}

static void in_stepped_time_a_call_waits_for_announced_octets(void)
{
    static const flow_endnode_kind_t counted[] = {ENDNODE_UDP, ENDNODE_TCP, ENDNODE_SERIAL};
    static const uint8_t message[IN]           = {5U, 6U, 7U, 8U};
    is_counted                                 = true;
    for (unsigned i = 0U; i < 3U; i++) {
        uint8_t octets[FLOW_OCTETS_MAX];
        size_t size = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, osal_hand_over_create(&counts, counts_name));
        begin_device(counted[i]);
        begin_flow(counted[i], IN, OUT);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_step(&flow, now_ns)); // The flow opens in one step, also over TCP.
        TEST_ASSERT_EQUAL_UINT32(1U, osal_hand_over_connection(&counts));
        accept_flight(counted[i]);
        for (unsigned k = 0U; k < 50U; k++) {
            send_message(counted[i], message);
            TEST_ASSERT_EQUAL(STATUS_OK, flow_receive(&flow, octets, &size)); // One attempt is sufficient.
            TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
        }
        TEST_ASSERT_EQUAL(STATUS_OK, flow_send(&flow, message, OUT));
        TEST_ASSERT_EQUAL_UINT32(is_stream(counted[i]) ? (OUT + 2U) : 1U, osal_hand_over_due(&counts));
        TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_lost(&counts));
        osal_hand_over_announce(&counts, 1U); // The announced octet never comes.
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_receive(&flow, octets, &size));
        TEST_ASSERT_EQUAL_UINT32(1U, osal_hand_over_lost(&counts));
        TEST_ASSERT_TRUE(osal_hand_over_is_connected(&counts));
        flow_close(&flow);
        TEST_ASSERT_FALSE(osal_hand_over_is_connected(&counts)); // The device detects the disconnection.
        end_all();
        osal_hand_over_close(&counts);
        (void)osal_shm_remove(counts_name);
    }
}

static void in_stepped_time_the_counts_show_that_a_device_is_gone(void)
{
    is_counted = true;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_hand_over_create(&counts, counts_name));
    begin_device(ENDNODE_SERIAL);
    begin_flow(ENDNODE_SERIAL, IN, OUT);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_step(&flow, now_ns));
    osal_hand_over_set_present(&counts, false);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_step(&flow, now_ns));
    now_ns += LONGEST_NS;
    // The terminal still exists; the counts show the disconnection.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_step(&flow, now_ns));
    osal_hand_over_set_present(&counts, true);
    now_ns += LONGEST_NS;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_step(&flow, now_ns));
    end_all();
}

static void an_announced_datagram_that_is_too_long_is_not_counted_as_lost(void)
{
    static const uint8_t message[IN] = {5U, 6U, 7U, 8U};
    uint8_t oversize[302]            = {0U};
    is_counted                       = true;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_hand_over_create(&counts, counts_name));
    begin_device(ENDNODE_UDP);
    begin_flow(ENDNODE_UDP, IN, OUT);
    connect_flow(ENDNODE_UDP);
    send_octets(ENDNODE_UDP, oversize, sizeof oversize);
    send_message(ENDNODE_UDP, message);
    expect_message(message);
    TEST_ASSERT_EQUAL_UINT32(0U, osal_hand_over_lost(&counts));
    end_all();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(messages_pass_in_both_directions_on_each_type_of_end_node);
    RUN_TEST(a_flow_is_closed_until_there_is_a_device);
    RUN_TEST(a_flow_connects_again_after_the_device_was_unplugged);
    RUN_TEST(a_stream_of_invalid_octets_is_closed_and_opened_again);
    RUN_TEST(frames_too_long_for_a_message_are_counted_and_skipped);
    RUN_TEST(a_device_that_only_receives_or_only_sends_has_one_queue);
    RUN_TEST(in_stepped_time_a_call_waits_for_announced_octets);
    RUN_TEST(in_stepped_time_the_counts_show_that_a_device_is_gone);
    RUN_TEST(an_announced_datagram_that_is_too_long_is_not_counted_as_lost);
    return UNITY_END();
}
