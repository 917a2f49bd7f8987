// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/pending_table.h"

#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static pending_table_t table;

static pus_token_t token(uint32_t id, uint16_t source, uint8_t ack)
{
    return (pus_token_t){.request_id = id, .source = source, .ack = ack};
}

static void add(uint16_t apid, uint32_t id, uint16_t source, uint8_t ack)
{
    const pus_token_t added = token(id, source, ack);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_pending_add(&table, apid, &added, 100U));
}

static void report(uint16_t apid, uint16_t destination, uint32_t id, uint8_t subtype, uint16_t instruction)
{
    const pus_verification_t made = {
        .subtype    = subtype,
        .request_id = id,
        .failure    = {.code = (uint16_t)((subtype % 2U == 0U) ? 0x0204U : 0U), .instruction = instruction}};
    supervisor_pending_report(&table, apid, destination, &made);
}

// For each set of acknowledgement flags, the report of success that ends the request; 0: the request is not
// tracked.
static void the_last_requested_report_ends_a_request(void)
{
    static const uint8_t last[16] = {0U, 1U, 3U, 3U, 3U, 3U, 3U, 3U, 7U, 7U, 7U, 7U, 7U, 7U, 7U, 7U};
    for (uint8_t ack = 0U; ack < 16U; ack++) {
        supervisor_pending_init(&table);
        add(16U, 5U, 1U, ack);
        TEST_ASSERT_EQUAL((ack == 0U) ? 0U : 1U, table.count);
        static const uint8_t chain[] = {1U, 3U, 5U, 5U, 7U};
        for (unsigned i = 0U; (i < 5U) && (ack != 0U); i++) {
            const bool is_over = (table.count == 0U);
            report(16U, 1U, 5U, chain[i], 0U);
            const bool ends = !is_over && (chain[i] == last[ack]);
            TEST_ASSERT_EQUAL((is_over || ends) ? 0U : 1U, table.count);
        }
        TEST_ASSERT_EQUAL(0U, table.count);
    }
}

static void every_failure_except_of_a_step_ends_a_request(void)
{
    static const uint8_t failures[] = {2U, 4U, 6U, 8U, 10U};
    for (unsigned i = 0U; i < sizeof failures; i++) {
        supervisor_pending_init(&table);
        add(16U, 5U, 1U, 0xFU);
        report(16U, 1U, 5U, failures[i], 0U);
        TEST_ASSERT_EQUAL((failures[i] == 6U) ? 1U : 0U, table.count);
    }
}

static void a_refused_instruction_does_not_end_its_request(void)
{
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, 0xFU);
    // A report about one of several instructions; another report ends the request.
    report(16U, 1U, 5U, 4U, 1U);
    report(16U, 1U, 5U, 4U, 2U);
    TEST_ASSERT_EQUAL(1U, table.count);
    report(16U, 1U, 5U, 8U, 0U);
    TEST_ASSERT_EQUAL(0U, table.count);
}

// All instructions were refused, and that was reported: the later loss of the subsystem is not reported for
// this request.
static void a_request_of_which_only_refusals_are_known_is_not_reported_as_lost(void)
{
    pus_token_t taken;
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, 0xFU);
    report(16U, 1U, 5U, 1U, 0U);
    report(16U, 1U, 5U, 4U, 1U);
    add(16U, 6U, 1U, 0xFU);
    TEST_ASSERT_TRUE(supervisor_pending_take(&table, 16U, &taken));
    TEST_ASSERT_EQUAL(6U, taken.request_id);
    TEST_ASSERT_FALSE(supervisor_pending_take(&table, 16U, &taken));
    TEST_ASSERT_EQUAL(0U, table.count);
}

static void a_started_request_with_refused_instructions_is_reported_as_lost(void)
{
    pus_token_t taken;
    static const uint8_t started[][2] = {{4U, 3U}, {3U, 4U}, {5U, 4U}};
    for (unsigned i = 0U; i < 3U; i++) {
        supervisor_pending_init(&table);
        add(16U, 5U, 1U, 0xFU);
        report(16U, 1U, 5U, started[i][0], 1U);
        report(16U, 1U, 5U, started[i][1], 1U);
        TEST_ASSERT_TRUE(supervisor_pending_take(&table, 16U, &taken));
    }
}

static void requests_of_which_only_refusals_are_known_are_replaced_first(void)
{
    pus_token_t taken;
    supervisor_pending_init(&table);
    for (uint32_t i = 0U; i < PENDING_MAX; i++) {
        add(16U, i, 1U, 0xFU);
    }
    report(16U, 1U, 7U, 4U, 1U);
    add(17U, 500U, 1U, 0xFU);
    TEST_ASSERT_EQUAL(PENDING_MAX, table.count);
    TEST_ASSERT_EQUAL(0U, table.refused);
    TEST_ASSERT_TRUE(supervisor_pending_take(&table, 17U, &taken));
    TEST_ASSERT_EQUAL(500U, taken.request_id);
    const pus_token_t one = token(501U, 1U, 0xFU);
    add(17U, 502U, 1U, 0xFU);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, supervisor_pending_add(&table, 17U, &one, 100U));
}

// The sequence count of the ground has wrapped.
static void an_equal_request_replaces_a_refused_one(void)
{
    supervisor_pending_init(&table);
    add(16U, 4U, 1U, 0xFU);
    add(16U, 5U, 1U, 0xFU);
    add(16U, 6U, 1U, 0xFU);
    report(16U, 1U, 4U, 4U, 1U);
    report(16U, 1U, 5U, 4U, 1U);
    add(16U, 5U, 1U, 0xFU);
    TEST_ASSERT_EQUAL(3U, table.count);
    report(16U, 1U, 5U, 7U, 0U);
    TEST_ASSERT_EQUAL(2U, table.count);
}

static void reports_of_others_change_nothing(void)
{
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, 0xFU);
    report(17U, 1U, 5U, 7U, 0U); // Another subsystem.
    report(16U, 2U, 5U, 7U, 0U); // Another user.
    report(16U, 1U, 6U, 7U, 0U); // Another request.
    TEST_ASSERT_EQUAL(1U, table.count);
    report(16U, 1U, 5U, 7U, 0U);
    TEST_ASSERT_EQUAL(0U, table.count);
    report(16U, 1U, 5U, 7U, 0U);
    TEST_ASSERT_EQUAL(0U, table.count);
}

static void equal_requests_end_one_by_one(void)
{
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, 0xFU); // The count of this user starts from 0 again.
    add(16U, 5U, 1U, 0xFU);
    report(16U, 1U, 5U, 7U, 0U);
    TEST_ASSERT_EQUAL(1U, table.count);
    report(16U, 1U, 5U, 7U, 0U);
    TEST_ASSERT_EQUAL(0U, table.count);
}

static void pending_requests_of_a_lost_subsystem_are_removed(void)
{
    pus_token_t taken;
    supervisor_pending_init(&table);
    for (uint32_t i = 0U; i < 10U; i++) {
        add((uint16_t)(16U + (i % 2U)), i, 1U, 0xFU);
    }
    unsigned count = 0U;
    while (supervisor_pending_take(&table, 17U, &taken)) {
        TEST_ASSERT_EQUAL(1U, taken.request_id % 2U);
        TEST_ASSERT_EQUAL(1U, taken.source);
        count++;
    }
    TEST_ASSERT_EQUAL(5U, count);
    TEST_ASSERT_EQUAL(5U, table.count);
    TEST_ASSERT_FALSE(supervisor_pending_take(&table, 99U, &taken));
}

static void a_full_table_counts_what_it_cannot_track(void)
{
    const pus_token_t more = token(999U, 1U, 0xFU);
    pus_token_t taken;
    supervisor_pending_init(&table);
    for (uint32_t i = 0U; i < PENDING_MAX; i++) {
        add(16U, i, 1U, 0x1U);
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, supervisor_pending_add(&table, 16U, &more, 100U));
    TEST_ASSERT_EQUAL(1U, table.refused);
    report(16U, 1U, 64U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_pending_add(&table, 16U, &more, 100U));
    unsigned count = 0U;
    while (supervisor_pending_take(&table, 16U, &taken)) {
        count++;
    }
    TEST_ASSERT_EQUAL(PENDING_MAX, count);
}

static void only_overdue_unanswered_requests_are_removed(void)
{
    pus_token_t taken;
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, PUS_ACK_ALL);
    add(17U, 6U, 1U, PUS_ACK_ACCEPTANCE);
    add(16U, 7U, 1U, PUS_ACK_COMPLETION);
    add(16U, 8U, 1U, PUS_ACK_ALL);
    report(16U, 1U, 8U, 1U, 0U);
    TEST_ASSERT_FALSE(supervisor_pending_take_unanswered(&table, 100U, &taken));
    TEST_ASSERT_TRUE(supervisor_pending_take_unanswered(&table, 101U, &taken));
    TEST_ASSERT_EQUAL(5U, taken.request_id);
    TEST_ASSERT_TRUE(supervisor_pending_take_unanswered(&table, 101U, &taken));
    TEST_ASSERT_EQUAL(6U, taken.request_id);
    TEST_ASSERT_FALSE(supervisor_pending_take_unanswered(&table, 101U, &taken));
    TEST_ASSERT_EQUAL(2U, table.count);
}

static void an_own_request_is_open_until_it_ends(void)
{
    supervisor_pending_init(&table);
    add(16U, 5U, 1U, PUS_ACK_ALL); // A request of the ground with the same number.
    TEST_ASSERT_FALSE(supervisor_pending_is_open(&table, 16U, 5U));
    add(16U, 5U, PUS_USER_SUPERVISOR, PUS_ACK_ALL);
    TEST_ASSERT_TRUE(supervisor_pending_is_open(&table, 16U, 5U));
    TEST_ASSERT_FALSE(supervisor_pending_is_open(&table, 16U, 6U));
    TEST_ASSERT_FALSE(supervisor_pending_is_open(&table, 17U, 5U));
    report(16U, PUS_USER_SUPERVISOR, 5U, 7U, 0U);
    TEST_ASSERT_FALSE(supervisor_pending_is_open(&table, 16U, 5U));
    TEST_ASSERT_EQUAL(1U, table.count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_last_requested_report_ends_a_request);
    RUN_TEST(every_failure_except_of_a_step_ends_a_request);
    RUN_TEST(a_refused_instruction_does_not_end_its_request);
    RUN_TEST(a_request_of_which_only_refusals_are_known_is_not_reported_as_lost);
    RUN_TEST(a_started_request_with_refused_instructions_is_reported_as_lost);
    RUN_TEST(requests_of_which_only_refusals_are_known_are_replaced_first);
    RUN_TEST(an_equal_request_replaces_a_refused_one);
    RUN_TEST(reports_of_others_change_nothing);
    RUN_TEST(equal_requests_end_one_by_one);
    RUN_TEST(pending_requests_of_a_lost_subsystem_are_removed);
    RUN_TEST(a_full_table_counts_what_it_cannot_track);
    RUN_TEST(only_overdue_unanswered_requests_are_removed);
    RUN_TEST(an_own_request_is_open_until_it_ends);
    return UNITY_END();
}
