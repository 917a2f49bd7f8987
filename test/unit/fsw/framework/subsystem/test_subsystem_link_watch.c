// SPDX-License-Identifier: Apache-2.0
// Reactions of a component to a failure of a link or of the subsystem at its other end.
#include "test/unit/fsw/framework/subsystem/link_fixture.inc"

// ---- Condition for SAFE_OPERATIONAL ----

static void required_links_are_needed_for_safe_operational(void)
{
    const rtlink_terms_t terms = terms_of(PORT_IN);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_expect("1.1 #0\n1.4 #0 0111 100002\n"); // Consumer 16, port 2.
    accept_port(PORT_IN, 1U);
    fixture_forget();
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_expect("1.1 #2\n1.4 #2 0111 100002\n");
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 5U));
    open(1U, 5U);
    fixture_run(1U);
    fixture_forget();
    (void)fixture_state(STATE_SAFE_OPERATIONAL); // The link is open, but no sample has arrived.
    fixture_expect("1.1 #4\n1.4 #4 0111 100002\n");
    run(1U);
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    run(2U);
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void each_required_port_needs_its_link(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    const descriptor_configuration_t* const linked = subsystem_configuration(&fixture.subsystem);
    for (uint16_t i = 0U; i < linked->port_count; i++) {
        for (uint16_t k = 0U; k < linked->port_count; k++) {
            fixture.descriptor.storage.ports[linked->first_port + k].is_required = (k == i);
        }
        char expected[24];
        (void)snprintf(expected, sizeof expected, "0111 10000%u\n", i + 1U);
        fixture_forget();
        (void)fixture_state(STATE_SAFE_OPERATIONAL);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(fixture_look(), expected), fixture_look());
    }
}

// ---- Failing links ----

static void expect_stale_reaction(state_t state, const char* lines)
{
    tearDown();
    setUp();
    bring_linked(state);
    other_writes = false;
    run(3U);
    fixture_expect(""); // The last sample is 3 ms old, then 4 ms.
    run(1U);
    fixture_expect("");
    run(1U);
    fixture_expect(lines);
    run(20U);
    fixture_expect("");
}

static void the_reaction_to_a_stale_link_depends_on_the_state(void)
{
    expect_stale_reaction(STATE_PRE_OPERATIONAL, "130.10 link 1 3>4 reason 9\n");
    expect_stale_reaction(STATE_SAFE_OPERATIONAL, "130.10 link 1 3>4 reason 9\n");
    expect_stale_reaction(STATE_OPERATIONAL,
                          "130.10 link 1 3>4 reason 9\n129.2 5>6 ENTERING cause 1 code 0006 cfg 2\n"
                          "5.4 event 6 aux \n129.2 6>6 SECURED cause 1 code 0000 cfg 2\n");
}

static void a_stale_link_prevents_operational_until_it_has_fresh_samples(void)
{
    bring_linked(STATE_SAFE_OPERATIONAL);
    other_writes = false;
    run(6U);
    fixture_forget();
    (void)fixture_state(STATE_OPERATIONAL);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "0111 100002\n"));
    other_writes = true;
    run(1U);
    fixture_expect("130.10 link 1 4>3 reason 0\n");
    (void)fixture_state(STATE_OPERATIONAL);
    run(2U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void a_link_that_never_receives_a_sample_is_stale(void)
{
    const rtlink_terms_t terms = terms_of(PORT_IN);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 5U));
    open(1U, 5U);
    fixture_forget();
    fixture_run(5U);
    fixture_expect("");
    fixture_run(1U);
    fixture_expect("130.10 link 1 3>4 reason 9\n");
    run(1U);
    fixture_expect("130.10 link 1 4>3 reason 0\n");
}

static void samples_of_an_earlier_opening_do_not_count(void)
{
    const rtlink_terms_t terms = terms_of(PORT_IN);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    accept_port(PORT_IN, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&other, fixture_links(), 1U, &terms, 4U));
    open(1U, 5U);
    fixture_forget();
    run(8U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, in_status);
    fixture_expect("130.10 link 1 3>4 reason 9\n");
}

static void a_required_link_that_is_closed_is_an_error_in_operational_and_an_event_in_safe_operational(void)
{
    bring_linked(STATE_OPERATIONAL);
    fixture.ack = 0U;
    close_link(1U, 10U);
    run(1U);
    fixture_expect(
        "130.10 link 1 3>0 reason 10\n129.2 5>6 ENTERING cause 1 code 0006 cfg 2\n5.4 event 6 aux \n"
        "129.2 6>6 SECURED cause 1 code 0000 cfg 2\n");
    tearDown();
    setUp();
    bring_linked(STATE_SAFE_OPERATIONAL);
    fixture.ack = 0U;
    close_link(1U, 10U);
    run(5U);
    fixture_expect("130.10 link 1 3>0 reason 10\n5.2 event 11 aux \n");
    (void)fixture_state(STATE_OPERATIONAL);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "0111 100002\n"));
}

static void a_required_link_that_is_closed_raises_an_event_in_pre_operational_and_none_after_an_error(void)
{
    bring_linked(STATE_PRE_OPERATIONAL);
    fixture.ack = 0U;
    close_link(1U, 10U);
    run(5U);
    fixture_expect("130.10 link 1 3>0 reason 10\n5.2 event 11 aux \n");
    tearDown();
    setUp();
    bring_linked(STATE_PRE_OPERATIONAL);
    other_state = STATE_ERROR_OPERATIONAL;
    run(5U);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, subsystem_state(&fixture.subsystem));
    fixture_forget();
    fixture.ack = 0U;
    close_link(1U, 10U);
    run(5U);
    fixture_expect("130.10 link 1 3>0 reason 10\n");
}

/// Bring the component into this state with a third open link, which is not required.
static void bring_with_extra(state_t state)
{
    const rtlink_terms_t terms = terms_of(PORT_EXTRA);
    const uint32_t value       = 7U;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_LINKED);
    connect_in();
    accept_port(PORT_EXTRA, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&extra, fixture_links(), 3U, &terms, 1U));
    open(3U, 1U);
    (void)rtlink_producer_write(&extra, STATE_ERROR_OPERATIONAL, fixture.now_ns, (const uint8_t*)&value);
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    run(2U);
    if (state == STATE_OPERATIONAL) {
        (void)fixture_state(state);
    }
    fixture_forget();
}

static void an_optional_link_that_is_stale_or_closed_is_reported_without_an_event(void)
{
    bring_with_extra(STATE_SAFE_OPERATIONAL);
    run(20U);
    fixture_expect("130.10 link 3 3>4 reason 9\n");
    tearDown();
    setUp();
    bring_with_extra(STATE_OPERATIONAL);
    run(20U);
    fixture_expect("129.2 5>5 IDLE cause 0 code 0000 cfg 2\n1.7 #5\n130.10 link 3 3>4 reason 9\n");
    close_link(3U, 0U);
    run(5U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

static void a_closed_link_that_is_not_required_raises_no_event(void)
{
    bring_with_extra(STATE_SAFE_OPERATIONAL);
    fixture.ack = 0U;
    close_link(3U, 10U);
    run(5U);
    fixture_expect("130.10 link 3 3>0 reason 10\n");
}

static void an_error_of_the_link_partner_is_an_error_of_the_subsystem(void)
{
    for (state_t state = STATE_PRE_OPERATIONAL; state <= STATE_OPERATIONAL; state++) {
        char expected[160];
        tearDown();
        setUp();
        bring_linked(state);
        other_state = STATE_ERROR_OPERATIONAL;
        run(1U); // The event is raised in the cycle in which the sample arrives.
        (void)snprintf(expected, sizeof expected,
                       "129.2 %d>6 ENTERING cause 2 code 0000 cfg 2\n5.1 event 12 aux \n"
                       "129.2 6>6 SECURED cause 2 code 0000 cfg 2\n",
                       (int)state);
        fixture_expect(expected);
        run(10U);
        fixture_expect("");
    }
}

static void a_subsystem_continues_when_its_provided_link_is_closed_by_request(void)
{
    bring_linked(STATE_PRE_OPERATIONAL);
    accept_port(PORT_OUT, 2U);
    open(2U, 3U);
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    run(2U);
    (void)fixture_state(STATE_OPERATIONAL);
    run(2U);
    fixture_forget();
    fixture.ack = 0U;
    close_link(2U, 10U);
    run(5U);
    fixture_expect("130.10 link 2 3>0 reason 10\n");
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, out_status);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(required_links_are_needed_for_safe_operational);
    RUN_TEST(each_required_port_needs_its_link);
    RUN_TEST(the_reaction_to_a_stale_link_depends_on_the_state);
    RUN_TEST(a_stale_link_prevents_operational_until_it_has_fresh_samples);
    RUN_TEST(a_link_that_never_receives_a_sample_is_stale);
    RUN_TEST(samples_of_an_earlier_opening_do_not_count);
    RUN_TEST(a_required_link_that_is_closed_is_an_error_in_operational_and_an_event_in_safe_operational);
    RUN_TEST(a_required_link_that_is_closed_raises_an_event_in_pre_operational_and_none_after_an_error);
    RUN_TEST(an_optional_link_that_is_stale_or_closed_is_reported_without_an_event);
    RUN_TEST(a_closed_link_that_is_not_required_raises_no_event);
    RUN_TEST(an_error_of_the_link_partner_is_an_error_of_the_subsystem);
    RUN_TEST(a_subsystem_continues_when_its_provided_link_is_closed_by_request);
    return UNITY_END();
}
