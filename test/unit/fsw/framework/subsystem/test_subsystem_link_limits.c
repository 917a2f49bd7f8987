// SPDX-License-Identifier: Apache-2.0
// Links in rare circumstances: unreachable ends, full tables, ends that differ from the agreement.
#include "test/unit/fsw/framework/subsystem/link_fixture.inc"

static uint8_t reaching_methods; ///< Methods that reach the partner: result of the callback `methods`.

static uint8_t methods(void* context, uint16_t port, uint16_t link)
{
    (void)context;
    (void)port;
    (void)link;
    return reaching_methods;
}

static void open_with(const char* old, const char* with)
{
    fixture_open_with(old, with);
    fixture.in_control = cycle;
}

static void a_method_that_cannot_reach_the_partner_is_not_offered(void)
{
    rtlink_resolver_t limited      = *fixture_links();
    limited.methods                = methods;
    fixture.subsystem.config.links = &limited;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    reaching_methods = 0U;
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "130.2 0000\n"));
    reaching_methods = 0xFFU;
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "130.2 0003"));
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_TRUE(fixture_has("130.4 link 1"));
}

static void without_links_a_request_for_a_link_is_refused_and_offers_are_reported(void)
{
    fixture.subsystem.config.links = NULL;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_TRUE(fixture_has("130.5 reason 6")); // PUS_LINK_REASON_STATE.
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_TRUE(fixture_has("130.2"));
}

static void a_port_with_unsupported_methods_only_gets_no_link(void)
{
    open_with("methods='SHARED_MEMORY UDP'><ParamRef name='A'",
              "methods='STREAM MESSAGE_QUEUE'><ParamRef name='A'");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_OUT, 1U);
    TEST_ASSERT_TRUE(fixture_has("130.5 reason 4 ")); // PUS_LINK_REASON_METHOD.
}

/// The descriptor has nine ports; SUBSYSTEM_LINKS is eight.
static void links_beyond_the_capacity_are_refused(void)
{
    static char ports[2048] = "</RTLinkService>";
    size_t used             = 0U;
    for (unsigned i = 0U; i < 6U; i++) {
        used += (size_t)snprintf(&ports[used], sizeof ports - used,
                                 "<Provides name='MORE%u' id='%u' methods='SHARED_MEMORY'>"
                                 "<ParamRef name='A' type='DOUBLE'/></Provides>",
                                 i, 10U + i);
    }
    (void)snprintf(&ports[used], sizeof ports - used, "</RTLinkService>");
    open_with("</RTLinkService>", ports);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    for (uint16_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        accept_port((i < 3U) ? (uint16_t)(i + 1U) : (uint16_t)(7U + i), (uint16_t)(11U * (i + 1U)));
    }
    TEST_ASSERT_TRUE(fixture_has("130.4 link 88"));
    fixture_forget();
    accept_port(15U, 9U);
    TEST_ASSERT_TRUE(fixture_has("130.5 reason 5"));
}

static void ports_whose_links_are_not_open_are_neither_read_nor_written(void)
{
    double value = 3.5;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      subsystem_link_read(&fixture.subsystem, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_link_peer_state(&fixture.subsystem, PORT_IN));
    TEST_ASSERT_TRUE(subsystem_link_age_us(&fixture.subsystem, PORT_IN) == UINT32_MAX);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    fixture.in_control = NULL;
    accept_port(PORT_OUT, 2U);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED,
                      subsystem_link_write(&fixture.subsystem, PORT_OUT, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_write(&fixture.subsystem, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_read(&fixture.subsystem, PORT_OUT, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_read(&fixture.subsystem, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_link_peer_state(&fixture.subsystem, PORT_IN));
    TEST_ASSERT_TRUE(subsystem_link_age_us(&fixture.subsystem, PORT_IN) == UINT32_MAX);
    TEST_ASSERT_EQUAL_DOUBLE(3.5, value);
}

static void the_status_of_a_producer_contains_what_it_sent(void)
{
    // The beginning of a frame of link 2: magic, version 1, state 3, link, flags.
    static const uint8_t frame[8] = {0x52U, 0x54U, 1U, 3U, 0U, 2U, 0U, 0U};
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_OUT, 2U);
    open(2U, 5U);
    fixture_run(4U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    // The component reads no datagrams, so this one has no effect.
    subsystem_link_datagram(&fixture.subsystem, frame, sizeof frame);
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\x01\x00\x02", 3U);
    // Sent 4, received 0, lost 0, late 0, last sequence 3.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "0000000400000000000000000000000000000003\n"));
}

static void a_lost_link_is_reported_only_where_there_is_an_event_for_it(void)
{
    open_with("<Event name='LINK_CLOSED' id='11' severity='LOW'/>\n", "");
    other_writes = true;
    other_state  = STATE_PRE_OPERATIONAL;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    close_link(1U, PUS_LINK_REASON_NONE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("130.10 link 1"));
    TEST_ASSERT_FALSE(fixture_has("5."));
}

/// The release at the end of a process sends no report, frees the memory of the ends that the subsystem owns,
/// and calls the callback once.
static void a_released_subsystem_has_closed_its_links(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    accept_port(PORT_OUT, 2U);
    open(2U, 5U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    fixture_forget();
    subsystem_release(&fixture.subsystem);
    fixture_expect("");
    TEST_ASSERT_EQUAL_UINT(1U, fixture.releases);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, subsystem_state(&fixture.subsystem));
    unsigned ends = 0U;
    for (unsigned i = 0U; i < SUBSYSTEM_LINKS; i++) {
        const subsystem_link_t* const link = &fixture.subsystem.links[i];
        ends += link->is_used ? 1U : 0U;
        TEST_ASSERT_NULL(link->producer.slot);
        TEST_ASSERT_NULL(link->consumer.slot);
        TEST_ASSERT_FALSE(link->consumer.is_open);
    }
    TEST_ASSERT_EQUAL_UINT(2U, ends);
}

static void a_component_without_links_and_callback_is_released_too(void)
{
    subsystem_callbacks_t silent       = *fixture.subsystem.config.callbacks;
    silent.release                     = NULL;
    fixture.subsystem.config.callbacks = &silent;
    subsystem_release(&fixture.subsystem);
    fixture_expect("");
    TEST_ASSERT_EQUAL_UINT(0U, fixture.releases);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_method_that_cannot_reach_the_partner_is_not_offered);
    RUN_TEST(without_links_a_request_for_a_link_is_refused_and_offers_are_reported);
    RUN_TEST(a_port_with_unsupported_methods_only_gets_no_link);
    RUN_TEST(links_beyond_the_capacity_are_refused);
    RUN_TEST(ports_whose_links_are_not_open_are_neither_read_nor_written);
    RUN_TEST(the_status_of_a_producer_contains_what_it_sent);
    RUN_TEST(a_lost_link_is_reported_only_where_there_is_an_event_for_it);
    RUN_TEST(a_released_subsystem_has_closed_its_links);
    RUN_TEST(a_component_without_links_and_callback_is_released_too);
    return UNITY_END();
}
