// SPDX-License-Identifier: Apache-2.0
// Links in circumstances that are rare: methods that do not reach, no room, ends that are not what one
// thinks.
#include "test/unit/fsw/framework/subsystem/link_bed.inc"

static uint8_t reaching; ///< What the resolver says.

static uint8_t methods(void* context, uint16_t port, uint16_t link)
{
    (void)context;
    (void)port;
    (void)link;
    return reaching;
}

static void open_with(const char* old, const char* with)
{
    bed_open_with(old, with);
    bed.in_control = cycle;
}

static void a_method_that_does_not_reach_is_not_offered(void)
{
    link_resolver_t limited    = *bed_links();
    limited.methods            = methods;
    bed.component.config.links = &limited;
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    reaching = 0U;
    (void)bed_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), "130.2 0000\n"));
    reaching = 0xFFU;
    (void)bed_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), "130.2 0003"));
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_TRUE(bed_has("130.4 link 1"));
}

static void without_links_every_request_is_refused(void)
{
    bed.component.config.links = NULL;
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_TRUE(bed_has("130.5 reason 6"));
    (void)bed_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_OFFERS, "\0", 1U);
    TEST_ASSERT_TRUE(bed_has("130.2"));
}

static void a_method_of_another_kind_is_never_offered(void)
{
    open_with("methods='SHARED_MEMORY UDP'><ParamRef name='A'",
              "methods='STREAM MESSAGE_QUEUE'><ParamRef name='A'");
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    accept_port(PORT_OUT, 1U);
    TEST_ASSERT_TRUE(bed_has("130.5 reason 4 "));
}

/// Nine ports, and COMPONENT_LINKS is eight.
static void more_links_than_there_is_room_for_are_refused(void)
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
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    for (uint16_t i = 0U; i < COMPONENT_LINKS; i++) {
        accept_port((i < 3U) ? (uint16_t)(i + 1U) : (uint16_t)(7U + i), (uint16_t)(i + 1U));
    }
    TEST_ASSERT_TRUE(bed_has("130.4 link 8"));
    bed_forget();
    accept_port(15U, 9U);
    TEST_ASSERT_TRUE(bed_has("130.5 reason 5"));
}

static void the_wrong_end_of_a_link_is_closed_to_its_user(void)
{
    double value = 3.5;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, subsystem_link_read(&bed.component, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_link_peer_state(&bed.component, PORT_IN));
    TEST_ASSERT_TRUE(subsystem_link_age_ns(&bed.component, PORT_IN) == UINT64_MAX);
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    bed.in_control = NULL;
    accept_port(PORT_OUT, 2U);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_write(&bed.component, PORT_OUT, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_write(&bed.component, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_read(&bed.component, PORT_OUT, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, subsystem_link_read(&bed.component, PORT_IN, &value, sizeof value));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_link_peer_state(&bed.component, PORT_IN));
    TEST_ASSERT_TRUE(subsystem_link_age_ns(&bed.component, PORT_IN) == UINT64_MAX);
    TEST_ASSERT_EQUAL_DOUBLE(3.5, value);
}

static void the_status_of_a_producer_tells_what_it_sent(void)
{
    static const uint8_t frame[8] = {0x52U, 0x54U, 1U, 3U, 0U, 2U, 0U, 0U};
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    accept_port(PORT_OUT, 2U);
    open(2U, 5U);
    bed_run(4U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    component_link_datagram(&bed.component, frame, sizeof frame); // For it, which reads none.
    bed_forget();
    (void)bed_command(PUS_SERVICE_RTLINK, PUS_LINK_REPORT_STATUS, "\x01\x00\x02", 3U);
    // Sent 4, received 0, lost 0, late 0, last sequence 3.
    TEST_ASSERT_NOT_NULL(strstr(bed_look(), "0000000400000000000000000000000000000003\n"));
}

static void a_lost_link_is_told_only_where_there_is_an_event_for_it(void)
{
    open_with("<Event name='LINK_CLOSED' id='11' severity='LOW'/>\n", "");
    other_writes = true;
    other_state  = STATE_PRE_OPERATIONAL;
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    connect_in();
    close_link(1U, PUS_LINK_REASON_NONE);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("130.10 link 1"));
    TEST_ASSERT_FALSE(bed_has("5."));
}

/// As when its process ends: nothing is told, the memory of its own ends is let go, and the callback hears of
/// it once.
static void released_it_has_let_go_of_its_links(void)
{
    bed_bring(STATE_PRE_OPERATIONAL, BED_LINKED);
    connect_in();
    accept_port(PORT_OUT, 2U);
    open(2U, 5U);
    bed_run(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, out_status);
    bed_forget();
    component_release(&bed.component);
    bed_expect("");
    TEST_ASSERT_EQUAL_UINT(1U, bed.releases);
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, subsystem_state(&bed.component));
    unsigned ends = 0U;
    for (unsigned i = 0U; i < COMPONENT_LINKS; i++) {
        const component_link_t* const link = &bed.component.links[i];
        ends += link->is_used ? 1U : 0U;
        TEST_ASSERT_NULL(link->producer.slot);
        TEST_ASSERT_NULL(link->consumer.slot);
        TEST_ASSERT_FALSE(link->consumer.is_open);
    }
    TEST_ASSERT_EQUAL_UINT(2U, ends);
}

static void a_component_without_links_and_callback_is_released_too(void)
{
    subsystem_callbacks_t silent   = *bed.component.config.callbacks;
    silent.release                 = NULL;
    bed.component.config.callbacks = &silent;
    component_release(&bed.component);
    bed_expect("");
    TEST_ASSERT_EQUAL_UINT(0U, bed.releases);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_method_that_does_not_reach_is_not_offered);
    RUN_TEST(without_links_every_request_is_refused);
    RUN_TEST(a_method_of_another_kind_is_never_offered);
    RUN_TEST(more_links_than_there_is_room_for_are_refused);
    RUN_TEST(the_wrong_end_of_a_link_is_closed_to_its_user);
    RUN_TEST(the_status_of_a_producer_tells_what_it_sent);
    RUN_TEST(a_lost_link_is_told_only_where_there_is_an_event_for_it);
    RUN_TEST(released_it_has_let_go_of_its_links);
    RUN_TEST(a_component_without_links_and_callback_is_released_too);
    return UNITY_END();
}
