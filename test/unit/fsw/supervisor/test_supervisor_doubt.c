// SPDX-License-Identifier: Apache-2.0
// After a subsystem was silent for a while, the supervisor does not rely on its known state until the
// subsystem has answered a request for its status.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void run_ms(unsigned ms)
{
    fixture_run(ms / 10U);
}

static const registry_entry_t* arm(void)
{
    return &fixture.supervisor.registry[0];
}

/// Cut off ARM while it is OPERATIONAL; it then goes to a lower state, and none of its reports arrives.
static void cut_off_arm(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_silent     = true;
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    run_ms(1700);
    fixture.members[FIXTURE_ARM].state = STATE_ERROR_OPERATIONAL;
    fixture.members[FIXTURE_ARM].phase = PHASE_SECURED;
    fixture_put_in_state(FIXTURE_HAND, STATE_SAFE_OPERATIONAL);
    fixture_forget();
}

static void a_request_that_only_a_state_in_doubt_prevents_is_refused_with_state_in_doubt(void)
{
    cut_off_arm();
    (void)fixture_request_state(HAND, STATE_OFFLINE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #4 0115 10")); // Not 0113: ARM may have left OPERATIONAL.
    TEST_ASSERT_FALSE(fixture_has("17 TC"));
    (void)fixture_request_state(HAND, STATE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #5 0115 10"));
    // 41 W is more than is left while ARM is OPERATIONAL.
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #6 0115 10"));
    (void)fixture_tc(ARM, 8U, 1U, "REST\0\0\0\0", 8U); // This function is not permitted in OPERATIONAL.
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #7 0115 10"));
}

static void a_subsystem_heard_again_must_report_its_status_before_its_state_is_used(void)
{
    cut_off_arm();
    fixture_tick();
    // ARM may have sent this report before it was cut off, so the report does not prove its state.
    fixture_report(FIXTURE_ARM, PUS_SERVICE_TEST, 2U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.reactions.asked);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, arm()->state);
    (void)fixture_request_state(HAND, STATE_OFFLINE);
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("G 1.2 #4 0115 10"));
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.4 from 8001"));
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, arm()->state);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    (void)fixture_request_state(HAND, STATE_OFFLINE);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.1 00 from 1"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[FIXTURE_HAND].state);
}

static void a_status_request_without_an_answer_is_repeated(void)
{
    cut_off_arm();
    // ARM reports its status every half second, but does not answer.
    fixture.members[FIXTURE_ARM].is_silent = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.reactions.asked);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    run_ms(1200);
    TEST_ASSERT_TRUE(fixture.supervisor.reactions.asked >= 2U);
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    run_ms(1200);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    run_ms(5000);
    TEST_ASSERT_TRUE(fixture.supervisor.reactions.asked <= 4U);
}

/// Send a completion report to the supervisor, about the status request or about another request.
static void end_of_request(uint32_t request_id, bool is_good)
{
    const pus_token_t token = {
        .request_id = request_id, .source = PUS_USER_SUPERVISOR, .ack = PUS_ACK_COMPLETION};
    const pus_failure_t failure = pus_failure(PUS_FAILURE_STATE, 0U);
    if (is_good) {
        pus_verify_completed(&fixture.members[FIXTURE_ARM].process, &token, fixture.now_ns);
    } else {
        pus_verify_failed(&fixture.members[FIXTURE_ARM].process, &token, &failure, fixture.now_ns);
    }
    fixture_step();
}

static void only_the_completion_of_the_status_request_ends_the_doubt(void)
{
    cut_off_arm();
    // ARM reports its status every half second, but does not answer.
    fixture.members[FIXTURE_ARM].is_silent = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    const uint32_t asked = arm()->asked.request_id;
    // The same sequence count, but of a request of the ground.
    fixture_verify(FIXTURE_ARM, 7U, (uint16_t)(asked & 0x3FFFU));
    fixture_step();
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked ^ 1U, true);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked, false);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked, true);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
}

static void a_subsystem_that_returns_offline_has_no_links(void)
{
    cut_off_arm();
    fixture.members[FIXTURE_ARM].state         = STATE_OFFLINE;
    fixture.members[FIXTURE_ARM].phase         = PHASE_IDLE;
    fixture.members[FIXTURE_ARM].is_silent     = false;
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));
}

static void a_process_that_starts_again_is_not_in_doubt(void)
{
    cut_off_arm();
    TEST_ASSERT_EQUAL(DOUBT_SILENT, arm()->doubt);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(2U);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.reactions.asked);
}

static void a_subsystem_that_reports_gets_no_status_request(void)
{
    run_ms(10000);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.reactions.asked);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_that_only_a_state_in_doubt_prevents_is_refused_with_state_in_doubt);
    RUN_TEST(a_subsystem_heard_again_must_report_its_status_before_its_state_is_used);
    RUN_TEST(a_status_request_without_an_answer_is_repeated);
    RUN_TEST(only_the_completion_of_the_status_request_ends_the_doubt);
    RUN_TEST(a_subsystem_that_returns_offline_has_no_links);
    RUN_TEST(a_process_that_starts_again_is_not_in_doubt);
    RUN_TEST(a_subsystem_that_reports_gets_no_status_request);
    return UNITY_END();
}
