// SPDX-License-Identifier: Apache-2.0
// One writer, several readers: each link of a provided port has its own slot, epoch, decimation and method.
#include "test/unit/fsw/framework/subsystem/link_fixture.inc"

#include <sys/socket.h>

#define FIRST 2U ///< Number of the first link of OUT.
#define SECOND 3U
#define FIRST_EPOCH 5U
#define SECOND_EPOCH 9U
#define CYCLES_OF_A_HANG 500U

static rtlink_consumer_t second; // A second fake consumer of OUT.
static uint8_t reaching_by_link; // Methods for link SECOND; FIRST has shared memory.
static osal_socket_t sender;
static osal_socket_t receiver;

/// Request a link for a reader of OUT on another subsystem, with a period that is a multiple of the writer's.
static void ask_reader(uint16_t link, uint32_t period_us)
{
    pus_link_request_t request   = request_of(PORT_OUT, link);
    request.ends.consumer_apid   = (uint16_t)(PEER + link);
    request.properties.period_us = period_us;
    ask(&request);
}

static void open_reader(rtlink_consumer_t* consumer, uint16_t link, uint32_t epoch, uint32_t decimation)
{
    rtlink_terms_t terms = terms_of(PORT_OUT);
    ask_reader(link, 1000U * decimation);
    open(link, epoch);
    terms.decimation = decimation;
    terms.period_us  = 1000U * decimation;
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(consumer, fixture_links(), link, &terms, epoch));
}

/// Run cycles in which each reader reads its sample.
static void run_with(unsigned cycles, rtlink_consumer_t* one, rtlink_consumer_t* other_one)
{
    for (unsigned i = 0U; i < cycles; i++) {
        fixture_run(1U);
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(one, fixture.now_ns));
        if (other_one != NULL) {
            TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(other_one, fixture.now_ns));
        }
    }
}

static void expect_lossless(const rtlink_consumer_t* consumer, uint32_t frames)
{
    TEST_ASSERT_EQUAL_UINT32(frames, consumer->counters.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer->counters.lost);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer->counters.late);
    TEST_ASSERT_EQUAL_UINT32(0U, consumer->counters.refused);
}

static void two_readers_of_one_port_get_every_sample(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    open_reader(&second, SECOND, SECOND_EPOCH, 1U);
    TEST_ASSERT_FALSE(fixture_has("130.10 link 2 3>0")); // The second link does not affect the first.
    run_with(20U, &reader, &second);
    expect_lossless(&reader, 20U);
    expect_lossless(&second, 20U);
    // Both samples were written in the same cycle.
    TEST_ASSERT_EQUAL(reader.sample_time_ns, second.sample_time_ns);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    rtlink_consumer_close(&second);
}

static void a_reader_that_opens_and_closes_makes_the_other_lose_no_sample(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    for (uint32_t life = 0U; life < 5U; life++) {
        open_reader(&second, SECOND, SECOND_EPOCH + life, 1U);
        run_with(4U, &reader, &second);
        expect_lossless(&second, 4U);
        // Closed in order, or by the death of the reader; then its link is negotiated again.
        if ((life % 2U) == 0U) {
            close_link(SECOND, PUS_LINK_REASON_PEER);
            run_with(3U, &reader, NULL);
        }
        rtlink_consumer_close(&second);
    }
    expect_lossless(&reader, (5U * 4U) + (3U * 3U));
    close_link(SECOND, PUS_LINK_REASON_PEER);
    close_link(FIRST, PUS_LINK_REASON_PEER); // Now the older link is closed first.
    rtlink_consumer_close(&reader);
    open_reader(&second, SECOND, 77U, 1U);
    open_reader(&reader, FIRST, 78U, 1U);
    run_with(4U, &reader, &second);
    close_link(FIRST, PUS_LINK_REASON_PEER);
    run_with(4U, &second, NULL);
    expect_lossless(&second, 8U);
    close_link(SECOND, PUS_LINK_REASON_PEER);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, out_status);
    rtlink_consumer_close(&second);
}

static void each_reader_has_a_decimation_of_its_own(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    open_reader(&second, SECOND, SECOND_EPOCH, 4U);
    for (unsigned i = 0U; i < 6U; i++) {
        run_with(4U, &reader, NULL);
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(&second, fixture.now_ns));
    }
    expect_lossless(&reader, 24U);
    expect_lossless(&second, 6U);
    rtlink_consumer_close(&second);
}

static void a_port_has_at_most_four_readers(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    for (uint16_t i = 0U; i < SUBSYSTEM_PORT_LINKS; i++) {
        ask_reader((uint16_t)(FIRST + i), 1000U);
    }
    TEST_ASSERT_TRUE(fixture_has("130.4 link 5"));
    ask_reader(FIRST + SUBSYSTEM_PORT_LINKS, 1000U);
    TEST_ASSERT_TRUE(fixture_has("130.5 reason 5"));
    fixture_forget();
    ask_reader(FIRST, 1000U); // A second request for the same link replaces it.
    TEST_ASSERT_TRUE(fixture_has("130.10 link 2 2>0 reason 0"));
    TEST_ASSERT_TRUE(fixture_has("130.4 link 2"));
}

static void a_link_number_belongs_to_one_port(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    accept_port(PORT_IN, FIRST);
    TEST_ASSERT_TRUE(fixture_has("130.5 reason 5"));
    run_with(4U, &reader, NULL);
    expect_lossless(&reader, 4U);
}

static void a_required_port_has_one_writer(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_IN, 1U);
    fixture_forget();
    accept_port(PORT_IN, 4U);
    TEST_ASSERT_TRUE(fixture_has("130.10 link 1 2>0 reason 0"));
    TEST_ASSERT_TRUE(fixture_has("130.4 link 4"));
}

// ---- Methods ----

static uint8_t methods(void* context, uint16_t port, uint16_t link)
{
    (void)context;
    (void)port;
    return (link == SECOND) ? reaching_by_link : (uint8_t)(1U << RTLINK_METHOD_SHARED_MEMORY);
}

static bool route(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer)
{
    (void)context;
    (void)link;
    *out_socket = &sender;
    return osal_socket_local_address(&receiver, out_consumer) == STATUS_OK;
}

/// The first reader uses shared memory, the second one a socket.
static void open_both_methods(void)
{
    static rtlink_resolver_t resolver; // The end of the test closes the links that are still open.
    const osal_address_t loopback = {OSAL_IPV4_LOOPBACK, 0U};
    rtlink_terms_t terms          = terms_of(PORT_OUT);
    resolver                      = *fixture_links();
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&sender, loopback, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&receiver, loopback, 0U));
    resolver.methods                      = methods;
    resolver.udp_route                    = route;
    reaching_by_link                      = 1U << RTLINK_METHOD_UDP;
    fixture.subsystem.config.links        = &resolver;
    fixture.subsystem.config.link_methods = 0x5U;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    ask_reader(SECOND, 1000U);
    TEST_ASSERT_TRUE(fixture_has("130.4 link 3 method 2"));
    open(SECOND, SECOND_EPOCH);
    terms.methods = 1U << RTLINK_METHOD_UDP;
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&second, &resolver, SECOND, &terms, SECOND_EPOCH));
}

static void close_both_methods(void)
{
    rtlink_consumer_close(&second);
    osal_socket_close(&sender);
    osal_socket_close(&receiver);
}

static void each_reader_has_a_method_of_its_own(void)
{
    uint8_t frame[LINK_FRAME_MAX];
    open_both_methods();
    for (unsigned i = 0U; i < 10U; i++) {
        osal_address_t from = {0U, 0U};
        size_t size         = 0U;
        run_with(1U, &reader, NULL);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&receiver, 1000U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&receiver, &from, frame, sizeof frame, &size));
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&second, frame, size));
    }
    expect_lossless(&reader, 10U);
    expect_lossless(&second, 10U);
    close_both_methods();
}

/// A datagram is lost only if its socket is full because it is not read.
static void a_reader_whose_socket_is_full_makes_the_other_lose_no_sample(void)
{
    uint8_t frame[LINK_FRAME_MAX];
    const int room   = 4096;
    uint32_t waiting = 0U;
    size_t size      = 0U;
    open_both_methods();
    TEST_ASSERT_EQUAL(0, setsockopt(receiver.descriptor, SOL_SOCKET, SO_RCVBUF, &room, sizeof room));
    fixture_forget();
    for (unsigned i = 0U; i < CYCLES_OF_A_HANG; i++) {
        run_with(1U, &reader, NULL);
        TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    }
    expect_lossless(&reader, CYCLES_OF_A_HANG);
    TEST_ASSERT_FALSE(fixture_has("130.10"));
    osal_address_t from = {0U, 0U};
    while (osal_udp_receive(&receiver, &from, frame, sizeof frame, &size) == STATUS_OK) {
        waiting++;
        (void)rtlink_consumer_deliver(&second, frame, size);
    }
    TEST_ASSERT_TRUE((waiting > 0U) && (waiting < CYCLES_OF_A_HANG)); // The socket was full.
    run_with(1U, &reader, NULL);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&receiver, 1000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&receiver, &from, frame, sizeof frame, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&second, frame, size)); // The reader reads again.
    expect_lossless(&reader, CYCLES_OF_A_HANG + 1U);
    close_both_methods();
}

/// A reader that hangs reads nothing for a while: it loses its own samples only, whatever its method is.
static void a_reader_that_hangs_makes_the_other_lose_no_sample(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open_reader(&reader, FIRST, FIRST_EPOCH, 1U);
    open_reader(&second, SECOND, SECOND_EPOCH, 1U);
    run_with(10U, &reader, &second);
    fixture_forget();
    run_with(500U, &reader, NULL);
    expect_lossless(&reader, 510U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    TEST_ASSERT_FALSE(fixture_has("130.10")); // The writer is not affected.
    // The reader continues with the newest sample and counts the missed ones.
    run_with(10U, &reader, &second);
    expect_lossless(&reader, 520U);
    TEST_ASSERT_EQUAL_UINT32(20U, second.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(500U, second.counters.lost);
    TEST_ASSERT_EQUAL(reader.sample_time_ns, second.sample_time_ns);
    run_with(500U, &second, NULL); // Now the first reader hangs.
    TEST_ASSERT_EQUAL_UINT32(520U, second.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(500U, second.counters.lost);
    rtlink_consumer_close(&second);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(two_readers_of_one_port_get_every_sample);
    RUN_TEST(a_reader_that_opens_and_closes_makes_the_other_lose_no_sample);
    RUN_TEST(each_reader_has_a_decimation_of_its_own);
    RUN_TEST(a_port_has_at_most_four_readers);
    RUN_TEST(a_link_number_belongs_to_one_port);
    RUN_TEST(a_required_port_has_one_writer);
    RUN_TEST(each_reader_has_a_method_of_its_own);
    RUN_TEST(a_reader_that_hangs_makes_the_other_lose_no_sample);
    RUN_TEST(a_reader_whose_socket_is_full_makes_the_other_lose_no_sample);
    return UNITY_END();
}
