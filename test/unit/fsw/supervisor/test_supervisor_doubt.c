// SPDX-License-Identifier: Apache-2.0
// What is known of a subsystem that was not heard for a while is no ground for a verdict until it has
// answered.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/bed.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    bed_open_up();
}

void tearDown(void)
{
    bed_close();
}

static void run_ms(unsigned ms)
{
    bed_run(ms / 10U);
}

static const roster_entry_t* arm(void)
{
    return &bed.supervisor.roster[0];
}

/// ARM is cut off in operation, and goes down by itself; nobody hears it.
static void cut_off_arm(void)
{
    bed_link_up(STATE_OPERATIONAL);
    bed.members[BED_ARM].is_silent = true;
    bed.members[BED_ARM].is_deaf   = true;
    run_ms(1700);
    bed.members[BED_ARM].state = STATE_ERROR_OPERATIONAL;
    bed.members[BED_ARM].phase = PHASE_SECURED;
    bed_place(BED_HAND, STATE_SAFE_OPERATIONAL);
    bed_forget();
}

static void a_state_that_is_not_heard_of_bars_nobody_for_certain(void)
{
    cut_off_arm();
    (void)bed_request_state(HAND, STATE_OFFLINE);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #4 0115 10")); // Not 0113: ARM may not be OPERATIONAL any more.
    TEST_ASSERT_FALSE(bed_has("17 TC"));
    (void)bed_request_state(HAND, STATE_OPERATIONAL);
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #5 0115 10"));
    (void)bed_request_state(LONE, STATE_PRE_OPERATIONAL); // 41 W more than ARM in OPERATIONAL leaves.
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #6 0115 10"));
    (void)bed_tc(ARM, 8U, 1U, "REST\0\0\0\0", 8U); // Not permitted in OPERATIONAL.
    bed_run(2U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #7 0115 10"));
}

static void who_is_heard_again_is_asked_and_then_believed(void)
{
    cut_off_arm();
    bed_tick();
    bed_report(BED_ARM, PUS_SERVICE_TEST, 2U, NULL,
               0U); // Sent before, perhaps: it says nothing of the state.
    bed_run(2U);
    TEST_ASSERT_EQUAL(1U, bed.supervisor.reactions.asked);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, arm()->state);
    (void)bed_request_state(HAND, STATE_OFFLINE);
    bed_run(1U);
    TEST_ASSERT_TRUE(bed_has("G 1.2 #4 0115 10"));
    bed.members[BED_ARM].is_deaf = false;
    bed_run(3U);
    TEST_ASSERT_TRUE(bed_has("16 TC 129.4 from 8001"));
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, arm()->state);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    (void)bed_request_state(HAND, STATE_OFFLINE);
    bed_run(3U);
    TEST_ASSERT_TRUE(bed_has("17 TC 129.1 00 from 1"));
    TEST_ASSERT_EQUAL(STATE_OFFLINE, bed.members[BED_HAND].state);
}

static void an_answer_that_does_not_come_is_asked_for_again(void)
{
    cut_off_arm();
    bed.members[BED_ARM].is_silent = false; // Its status comes once a second, but no answer.
    run_ms(1000);
    TEST_ASSERT_EQUAL(1U, bed.supervisor.reactions.asked);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    run_ms(1200);
    TEST_ASSERT_TRUE(bed.supervisor.reactions.asked >= 2U);
    bed.members[BED_ARM].is_deaf = false;
    run_ms(1200);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    run_ms(5000);
    TEST_ASSERT_TRUE(bed.supervisor.reactions.asked <= 4U);
}

/// A report of an end to the supervisor, of the request that asks or of another one.
static void end_of_request(uint32_t request_id, bool is_good)
{
    const pus_token_t token = {
        .request_id = request_id, .source = PUS_USER_SUPERVISOR, .ack = PUS_ACK_COMPLETION};
    const pus_failure_t failure = pus_failure(PUS_FAILURE_STATE, 0U);
    if (is_good) {
        pus_verify_completed(&bed.members[BED_ARM].process, &token, bed.now_ns);
    } else {
        pus_verify_failed(&bed.members[BED_ARM].process, &token, &failure, bed.now_ns);
    }
    bed_step();
}

static void only_the_end_of_the_question_is_an_answer(void)
{
    cut_off_arm();
    bed.members[BED_ARM].is_silent = false; // Its status comes once a second, but no answer.
    run_ms(1000);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    const uint32_t asked = arm()->asked.request_id;
    bed_verify(BED_ARM, 7U, (uint16_t)(asked & 0x3FFFU)); // The same number, of the ground.
    bed_step();
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked ^ 1U, true);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked, false);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, arm()->doubt);
    end_of_request(asked, true);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
}

static void who_comes_back_offline_has_no_links(void)
{
    cut_off_arm();
    bed.members[BED_ARM].state     = STATE_OFFLINE;
    bed.members[BED_ARM].phase     = PHASE_IDLE;
    bed.members[BED_ARM].is_silent = false;
    bed.members[BED_ARM].is_deaf   = false;
    run_ms(1000);
    TEST_ASSERT_EQUAL(0U, bed.supervisor.graph.count);
    TEST_ASSERT_TRUE(bed_has("17 TC 130.7 0001"));
}

static void a_process_that_begins_anew_is_not_in_doubt(void)
{
    cut_off_arm();
    TEST_ASSERT_EQUAL(DOUBT_SILENT, arm()->doubt);
    bed.members[BED_ARM].is_running = false;
    bed_run(2U);
    TEST_ASSERT_EQUAL(DOUBT_NONE, arm()->doubt);
    TEST_ASSERT_EQUAL(0U, bed.supervisor.reactions.asked);
}

static void who_speaks_is_never_asked(void)
{
    run_ms(10000);
    TEST_ASSERT_EQUAL(0U, bed.supervisor.reactions.asked);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_state_that_is_not_heard_of_bars_nobody_for_certain);
    RUN_TEST(who_is_heard_again_is_asked_and_then_believed);
    RUN_TEST(an_answer_that_does_not_come_is_asked_for_again);
    RUN_TEST(only_the_end_of_the_question_is_an_answer);
    RUN_TEST(who_comes_back_offline_has_no_links);
    RUN_TEST(a_process_that_begins_anew_is_not_in_doubt);
    RUN_TEST(who_speaks_is_never_asked);
    return UNITY_END();
}
