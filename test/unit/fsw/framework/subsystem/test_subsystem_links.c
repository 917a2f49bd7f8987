// SPDX-License-Identifier: Apache-2.0
// The subsystem's side of real-time links: the handshake by telecommands, with fake other ends.
#include "test/unit/fsw/framework/subsystem/link_fixture.inc"

// ---- Offers and refusals ----

static void ports_are_offered_once_per_method(void)
{
    char expected[256];
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\x01\x00\x02", 3U);
    (void)snprintf(expected, sizeof expected,
                   "1.1 #0\n1.3 #0\n130.2 0001000201%08lX00000010%02X000003E800000001%08X\n1.7 #0\n",
                   (unsigned long)port_of(PORT_IN)->layout_hash, native(), 4000U);
    fixture_expect(expected);
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\x00", 1U);
    TEST_ASSERT_TRUE(fixture_has("130.2 00030001")); // This run offers shared memory only.
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\x01\x00\x63", 3U);
    fixture_expect("1.1 #2\n1.4 #2 0201 63 in 1\n");
    fixture_close();
    fixture_open(NULL);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\x00", 1U);
    fixture_expect("1.1 #0\n1.3 #0\n130.2 0000\n1.7 #0\n");
}

static void expect_refusal(const pus_link_request_t* request, unsigned reason, unsigned field)
{
    char expected[128];
    ask(request);
    (void)snprintf(expected, sizeof expected, "130.5 reason %u field %u", reason, field);
    TEST_ASSERT_TRUE_MESSAGE(fixture_has(expected), expected);
    (void)snprintf(expected, sizeof expected, "0409 %X\n", (reason << 8U) | field);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(fixture_look(), expected), expected);
    TEST_ASSERT_FALSE(fixture.subsystem.links[0].is_used);
}

static void each_refusal_names_its_field(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    pus_link_request_t spoiled = request_of(PORT_IN, 1U);
    spoiled.properties.layout_hash++;
    expect_refusal(&spoiled, 1U, 1U);
    spoiled = request_of(PORT_IN, 1U);
    spoiled.properties.layout_size++;
    expect_refusal(&spoiled, 1U, 1U);
    spoiled                       = request_of(PORT_IN, 1U);
    spoiled.properties.byte_order = 2U;
    expect_refusal(&spoiled, 2U, 3U);
    static const uint32_t periods[] = {0U, 700U, 1500U, UINT32_MAX}; // The period of the consumer is 1000 us.
    for (unsigned i = 0U; i < 4U; i++) {
        spoiled                      = request_of(PORT_IN, 1U);
        spoiled.properties.period_us = periods[i];
        expect_refusal(&spoiled, 3U, 4U);
    }
    static const uint8_t methods[] = {1U, 2U, 3U, 4U, 254U};
    for (unsigned i = 0U; i < sizeof methods; i++) {
        spoiled                   = request_of(PORT_IN, 1U);
        spoiled.properties.method = methods[i];
        expect_refusal(&spoiled, 4U, 6U);
    }
    spoiled = request_of(PORT_IN, 0U); // Numbers of links begin with 1.
    expect_refusal(&spoiled, 5U, 0U);
    spoiled                    = request_of(PORT_IN, 1U);
    spoiled.ends.consumer_port = 99U;
    expect_refusal(&spoiled, 7U, 9U);
    spoiled                    = request_of(PORT_IN, 1U);
    spoiled.ends.consumer_apid = 99U; // Neither end is this subsystem.
    expect_refusal(&spoiled, 7U, 9U);
    spoiled = request_of(PORT_IN, 1U);
    // The subsystem provides no such port.
    spoiled.ends = (pus_link_ends_t){FIXTURE_APID, PORT_IN, PEER, PEER_PORT};
    expect_refusal(&spoiled, 7U, 9U);
    spoiled      = request_of(PORT_OUT, 1U);
    spoiled.ends = (pus_link_ends_t){PEER, PEER_PORT, FIXTURE_APID, PORT_OUT};
    expect_refusal(&spoiled, 7U, 9U);
}

/// Make one field of an acceptable request wrong. Returns false if the port accepts the request even with
/// this value.
static bool spoil(pus_link_request_t* request, unsigned what, bool is_producer)
{
    switch (what) {
    case 0U:
        request->properties.layout_hash ^= 0x80000000U;
        return true;
    case 1U:
        request->properties.layout_size = 1025U;
        return true;
    case 2U:
        request->properties.byte_order = 2U;
        return !is_producer; // A producer accepts it, because its own byte order applies.
    case 3U:
        request->properties.period_us = 700U;
        return true;
    default:
        request->properties.method = 3U;
        return true;
    }
}

static void a_link_with_the_values_that_a_refusal_names_is_accepted(void)
{
    static const uint16_t ports[]       = {PORT_IN, PORT_OUT};
    static const char* const accepted[] = {"130.4 link 1 method 0 period 1000",
                                           "130.4 link 2 method 0 period 1000"};
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    for (unsigned i = 0U; i < 2U; i++) {
        for (unsigned what = 0U; what < 5U; what++) {
            pus_link_request_t request = request_of(ports[i], (uint16_t)(i + 1U));
            if (!spoil(&request, what, ports[i] == PORT_OUT)) {
                continue;
            }
            (void)memset(&fixture.supported, 0xFF, sizeof fixture.supported);
            fixture_forget();
            ask(&request);
            TEST_ASSERT_TRUE_MESSAGE(fixture_has("130.5 reason"), fixture_look());
            request.properties = fixture.supported;
            fixture_forget();
            ask(&request);
            TEST_ASSERT_TRUE_MESSAGE(fixture_has(accepted[i]), fixture_look());
        }
    }
}

static void links_are_accepted_in_pre_operational_with_a_configuration_only(void)
{
    const pus_link_request_t request = request_of(PORT_IN, 1U);
    expect_refusal(&request, 6U, 0U);
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    expect_refusal(&request, 6U, 0U);
    fixture_close();
    fixture_open(NULL);
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    expect_refusal(&request, 6U, 0U);
    fixture_close();
    fixture_open(NULL);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE); // Another configuration has other ports.
    expect_refusal(&request, 7U, 9U);
}

// ---- Life of a link ----

static void a_consumer_opens_and_reads(void)
{
    const rtlink_terms_t terms = terms_of(PORT_IN);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    run(1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, in_status);
    accept_port(PORT_IN, 1U);
    fixture_expect("1.1 #0\n130.10 link 1 0>2 reason 0\n1.3 #0\n"
                   "130.4 link 1 method 0 period 1000 age 4000\n1.7 #0\n");
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 5U));
    open(1U, 5U);
    fixture_expect("1.1 #1\n130.10 link 1 2>3 reason 0\n1.3 #1\n1.7 #1\n");
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, in_status);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, subsystem_link_age_us(&fixture.subsystem, PORT_IN));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_link_peer_state(&fixture.subsystem, PORT_IN));
    other_state = STATE_SAFE_OPERATIONAL;
    run(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, in_status);
    TEST_ASSERT_EQUAL_DOUBLE(0.25, in_value[0]);
    TEST_ASSERT_EQUAL_DOUBLE(-8.0, in_value[1]);
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, subsystem_link_peer_state(&fixture.subsystem, PORT_IN));
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(2U * FIXTURE_PERIOD_NS / 1000U,
                             subsystem_link_age_us(&fixture.subsystem, PORT_IN));
    fixture.now_ns += 5000U * 1000000000ULL; // A time that does not fit a parameter of 32 bits.
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, subsystem_link_age_us(&fixture.subsystem, PORT_IN));
    const double values[2] = {1.0, 2.0}; // The clock of the producer is ahead.
    (void)rtlink_producer_write(&other, 4U, fixture.now_ns + FIXTURE_PERIOD_NS, (const uint8_t*)values);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, subsystem_link_age_us(&fixture.subsystem, PORT_IN));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      subsystem_link_read(&fixture.subsystem, 99U, in_value, sizeof in_value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_read(&fixture.subsystem, PORT_EXTRA, in_value, 4U));
}

static void a_producer_opens_and_writes_its_true_state(void)
{
    const rtlink_terms_t terms = terms_of(PORT_OUT);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, out_status);
    accept_port(PORT_OUT, 2U);
    open(2U, 3U);
    TEST_ASSERT_TRUE(fixture_has("1.1 #0"));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&reader, fixture_links(), 2U, &terms, 3U));
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(&reader, fixture.now_ns));
    double value = 0.0;
    (void)memcpy(&value, reader.payload, sizeof value);
    TEST_ASSERT_EQUAL_DOUBLE(1.5, value);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, reader.peer_state);
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x01", 2U);
    fixture_run(1U); // The next sample has the new state.
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_read(&reader, fixture.now_ns));
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, reader.peer_state);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, subsystem_link_write(&fixture.subsystem, 99U, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      subsystem_link_write(&fixture.subsystem, PORT_IN, in_value, sizeof in_value));
}

static void octets_of_a_producer_of_the_other_byte_order_are_swapped(void)
{
    const rtlink_terms_t terms = terms_of(PORT_IN);
    pus_link_request_t request = request_of(PORT_IN, 1U);
    uint8_t octets[16];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    if (native() == RTLINK_BIG_ENDIAN) {
        return;
    }
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    request.properties.byte_order = RTLINK_BIG_ENDIAN;
    ask(&request);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 5U));
    open(1U, 5U);
    octet_write_f64(&writer, 3.5);
    octet_write_f64(&writer, -1e-3);
    (void)rtlink_producer_write(&other, 3U, fixture.now_ns, octets);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, in_status);
    TEST_ASSERT_EQUAL_DOUBLE(3.5, in_value[0]);
    TEST_ASSERT_EQUAL_DOUBLE(-1e-3, in_value[1]);
}

static void samples_that_a_slower_consumer_skips_are_not_lost(void)
{
    pus_link_request_t request = request_of(PORT_IN, 1U);
    const rtlink_terms_t terms = terms_of(PORT_IN);
    subsystem_link_totals_t totals;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    request.properties.period_us = 250U;
    ask(&request);
    TEST_ASSERT_TRUE(fixture_has("1.1 #0"));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 5U));
    open(1U, 5U);
    for (unsigned i = 0U; i < 40U; i++) {
        produce();
        produce();
        produce();
        run(1U);
    }
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(40U, totals.received);
    TEST_ASSERT_EQUAL(0U, totals.lost);
    close_link(1U, 0U);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(40U, totals.received); // The totals are kept when the link is closed.
}

/// The totals keep the counts of a link that is closed.
static void totals_of_links_count_what_was_received_lost_late_and_refused(void)
{
    const rtlink_frame_header_t header = {.link = 1U, .epoch = 5U, .sequence = 1000U};
    const uint8_t payload[16]          = {0U};
    uint8_t frame[LINK_FRAME_MAX];
    subsystem_link_totals_t before;
    subsystem_link_totals_t totals;
    bring_linked(STATE_PRE_OPERATIONAL);
    subsystem_link_totals(&fixture.subsystem, &before);
    for (unsigned i = 0U; i < 5U; i++) { // Three samples come in each cycle.
        produce();
        produce();
        run(1U);
    }
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(before.received + 5U, totals.received);
    TEST_ASSERT_EQUAL(before.lost + 10U, totals.lost);
    TEST_ASSERT_EQUAL(before.late, totals.late);
    other_writes = false;
    fixture_run(10U);
    const size_t size = rtlink_frame_encode(&header, payload, sizeof payload, true, frame);
    // This link uses shared memory and ignores the datagram.
    subsystem_link_datagram(&fixture.subsystem, frame, size);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_TRUE((totals.late >= 5U) && (totals.late <= 20U));
    TEST_ASSERT_EQUAL(before.refused + 1U, totals.refused);
    before = totals;
    close_link(1U, 0U);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL_MEMORY(&before, &totals, sizeof totals);
}

static void a_link_that_cannot_be_opened_is_refused(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    open(1U, 1U);
    fixture_expect("1.1 #0\n1.4 #0 0201 1\n");
    close_link(1U, 0U);
    fixture_expect("1.1 #1\n1.4 #1 0201 1\n");
    accept_port(PORT_IN, 1U);
    fixture_forget();
    open(1U, 1U); // The memory does not exist, because there is no producer.
    fixture_expect("1.1 #3\n130.10 link 1 2>5 reason 5\n1.3 #3\n1.8 #3 0404 4\n");
    open(1U, 1U);
    fixture_expect("1.1 #4\n1.4 #4 0201 1\n");
    connect_in();
    fixture_forget();
    open(1U, 5U);
    fixture_expect("1.1 #7\n1.4 #7 0204 1\n");
}

static void an_accepted_link_that_is_not_opened_ends_after_five_seconds(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_IN, 1U);
    fixture_forget();
    fixture_run_until(fixture.now_ns + 5000000000ULL);
    fixture_expect("");
    fixture_run(2U);
    fixture_expect("130.10 link 1 2>0 reason 8\n");
}

static void a_second_request_replaces_the_first(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    fixture_forget();
    accept_port(PORT_IN, 4U);
    fixture_expect("1.1 #2\n130.10 link 1 3>0 reason 0\n130.10 link 4 0>2 reason 0\n1.3 #2\n"
                   "130.4 link 4 method 0 period 1000 age 4000\n1.7 #2\n");
    open(1U, 5U);
    TEST_ASSERT_TRUE(fixture_has("1.1 #3"));
    TEST_ASSERT_TRUE(strstr(fixture_look(), "1.4 #3 0201 1") != NULL);
}

static void links_close_with_their_configuration(void)
{
    bring_linked(STATE_SAFE_OPERATIONAL);
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    run(4U);
    TEST_ASSERT_TRUE(fixture_has("130.10 link 1 3>0 reason 6"));
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    fixture_forget();
    (void)fixture_select(FIXTURE_ALONE);
    run(2U);
    TEST_ASSERT_TRUE(fixture_has("130.10 link 1 3>0 reason 0"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, in_status);
}

static void the_link_status_contains_the_counters(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    run(8U);
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\x01\x00\x01", 3U);
    TEST_ASSERT_TRUE(fixture_has("1.1 #2"));
    const char* const text = fixture_look();
    // One link, number 1, open, 17.9 -> 16.2, then properties.
    TEST_ASSERT_NOT_NULL(strstr(text, "130.9 00010001030011000900100002"));
    // Sent 0, received 10, lost 0, late 0, last sequence 9.
    TEST_ASSERT_NOT_NULL(strstr(text, "000000000000000A000000000000000000000009\n"));
}

static void datagrams_without_an_addressee_are_ignored(void)
{
    // The beginning of a frame of link 1: magic, version 1, state 3, link.
    uint8_t frame[64]              = {0x52U, 0x54U, 1U, 3U, 0U, 1U};
    subsystem_link_totals_t before = {0};
    subsystem_link_totals_t totals = {0};
    bring_linked(STATE_OPERATIONAL);
    subsystem_link_totals(&fixture.subsystem, &before);
    for (size_t size = 0U; size < 6U; size++) { // Too short to name a link.
        subsystem_link_datagram(&fixture.subsystem, frame, size);
    }
    frame[5] = 9U;
    subsystem_link_datagram(&fixture.subsystem, frame, sizeof frame);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(before.refused, totals.refused);
    frame[5] = 1U;
    for (size_t size = 6U; size <= sizeof frame; size++) {
        subsystem_link_datagram(&fixture.subsystem, frame, size);
    }
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(before.refused + (sizeof frame - 5U), totals.refused);
    run(1U);
    TEST_ASSERT_EQUAL_DOUBLE(0.25, in_value[0]);
    fixture_expect("");
}

/// The link uses shared memory, so it refuses and counts each datagram that names it.
static void a_datagram_names_its_link_by_both_octets(void)
{
    static const uint8_t frame[64]     = {0x52U, 0x54U, 1U, 3U, 0x01U, 0x02U};
    static const uint8_t others[2][64] = {{0x52U, 0x54U, 1U, 3U, 0x02U, 0x02U},
                                          {0x52U, 0x54U, 1U, 3U, 0x00U, 0x02U}};
    subsystem_link_totals_t totals     = {0};
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    const rtlink_terms_t terms = terms_of(PORT_IN);
    accept_port(PORT_IN, 0x0102U);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 0x0102U, &terms, 5U));
    open(0x0102U, 5U);
    run(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, in_status);
    subsystem_link_datagram(&fixture.subsystem, others[0], sizeof others[0]);
    subsystem_link_datagram(&fixture.subsystem, others[1], sizeof others[1]);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(0U, totals.refused);
    subsystem_link_datagram(&fixture.subsystem, frame, sizeof frame);
    subsystem_link_totals(&fixture.subsystem, &totals);
    TEST_ASSERT_EQUAL(1U, totals.refused);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(ports_are_offered_once_per_method);
    RUN_TEST(each_refusal_names_its_field);
    RUN_TEST(a_link_with_the_values_that_a_refusal_names_is_accepted);
    RUN_TEST(links_are_accepted_in_pre_operational_with_a_configuration_only);
    RUN_TEST(a_consumer_opens_and_reads);
    RUN_TEST(a_producer_opens_and_writes_its_true_state);
    RUN_TEST(octets_of_a_producer_of_the_other_byte_order_are_swapped);
    RUN_TEST(samples_that_a_slower_consumer_skips_are_not_lost);
    RUN_TEST(totals_of_links_count_what_was_received_lost_late_and_refused);
    RUN_TEST(a_link_that_cannot_be_opened_is_refused);
    RUN_TEST(an_accepted_link_that_is_not_opened_ends_after_five_seconds);
    RUN_TEST(a_second_request_replaces_the_first);
    RUN_TEST(links_close_with_their_configuration);
    RUN_TEST(the_link_status_contains_the_counters);
    RUN_TEST(datagrams_without_an_addressee_are_ignored);
    RUN_TEST(a_datagram_names_its_link_by_both_octets);
    return UNITY_END();
}
