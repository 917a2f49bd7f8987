// SPDX-License-Identifier: Apache-2.0
// Execution of on-board procedures; pus/catalogue/st18_procedures.txt has the names of the subtypes.
#include "pus/st01/st01_verification.h"
#include "test/unit/pus/fixtures/st18_fixture.h"
#include "unity.h"

#define ABCD 0x41424344U // Value in failure notices for procedure "ABCD".

static pus_procedures_t* const self = &st18_fixture.service;

/// Set up a fixture in which procedure "ABCD" is loaded.
void setUp(void)
{
    st18_fixture_start();
    st18_fixture_load("ABCD", 10U, 'x');
}

void tearDown(void)
{
}

static void expect_refused(const uint8_t subtype, const char* const id, const void* const data,
                           const size_t size, const uint16_t code, const uint32_t detail)
{
    const uint32_t before = self->counters.refused;
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(subtype, id, data, size));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 0U, detail);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, self->counters.refused);
}

static void expect_accepted(const uint8_t subtype, const char* const id, const void* const data,
                            const size_t size)
{
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(subtype, id, data, size));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static const uint8_t next_step[] = {0, 0};
static const uint8_t step_2[]    = {0, 2};

static void a_procedure_runs_to_its_end(void)
{
    static const uint8_t body[] = {PUS_OBSERVE_ALL, 2, 1, 0x12, 0x34, 10, 1};
    TEST_ASSERT_FALSE(pus_procedures_are_active(self));
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(3U, "ABCD", body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_EQUAL_UINT64(6U, st18_fixture.arguments_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&body[1], st18_fixture.arguments, 6U);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_STARTED, 0U, 0U);
    TEST_ASSERT_TRUE(pus_procedures_are_active(self));
    st18_fixture_step(3U);
    TEST_ASSERT_EQUAL_UINT32(300U, st18_fixture.slots[0].budget);
    st18_fixture_call(0U, PUS_CALL_STEP, 7U);
    st18_fixture_call(0U, PUS_CALL_ENDED, 0U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5, 1, 7);
    octet_reader_t reader = bench_data(0U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_UINT16(7U, octet_read_u16(&reader));
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_ENDED, 7U, 0U);
    TEST_ASSERT_FALSE(pus_procedures_are_active(self));
    expect_procedure_status(PUS_PROCEDURE_INACTIVE);
    st18_fixture_activate("ABCD", 0U); // The procedure runs again.
    TEST_ASSERT_EQUAL_UINT32(2U, self->counters.started);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.ended);
}

static void errors_are_reported_at_every_level(void)
{
    st18_fixture_activate("ABCD", PUS_OBSERVE_NOTHING);
    st18_fixture_call(0U, PUS_CALL_FAILED, 33U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 8);
    octet_reader_t reader = bench_data(0U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_PROCEDURE, octet_read_u16(&reader));
    expect_observation(ST18_FIXTURE_FAILURE, "ABCD", PUS_OBSERVED_FAILED, 0U, 33U);
    TEST_ASSERT_EQUAL_STRING("LEVEL", (const char*)&st18_fixture.events.auxiliary[15]);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.events.count);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.failed);
    st18_fixture.start_status   = STATUS_INVALID;
    static const uint8_t body[] = {0, 0};
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(3U, "ABCD", body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_PROCEDURE, 0U, 12U);
    expect_observation(ST18_FIXTURE_FAILURE, "ABCD", PUS_OBSERVED_FAILED, 0U, 12U);
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(14U, "ABCD", body, sizeof body));
    expect_failure(2U, 8U, PUS_FAILURE_PROCEDURE, 0U, 12U);
    self->config.failure_event = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(3U, "ABCD", body, sizeof body));
    TEST_ASSERT_EQUAL_UINT(3U, st18_fixture.events.count);
}

static void a_long_text_is_truncated(void)
{
    static const char text[] = "a text of more than forty-five octets, which is all there is room for";
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_call(0U, PUS_CALL_FAILED, 1U);
    st18_fixture.slots[0].calls[0].text = text;
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_STRING_LEN(text, &st18_fixture.events.auxiliary[15], PUS_OBSERVATION_TEXT);
}

static void activation_is_refused_in_a_wrong_state(void)
{
    static const uint8_t body[] = {0, 0};
    static const uint8_t high[] = {4, 0};
    expect_refused(3U, "none", body, 2U, PUS_FAILURE_UNKNOWN_ID, 0x6E6F6E65U);
    expect_refused(3U, "ABCD", high, 2U, PUS_FAILURE_OUT_OF_RANGE, PUS_NAME_SIZE);
    st18_fixture_activate("ABCD", 0U);
    expect_refused(3U, "ABCD", body, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(14U, "ABCD", body, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(2U, "ABCD", NULL, 0U, PUS_FAILURE_STATE, ABCD);
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_activate("B", 0U);
    st18_fixture_load("C", 1U, 'x');
    expect_refused(3U, "C", body, 2U, PUS_FAILURE_TABLE_FULL, ST18_FIXTURE_SLOTS);
}

/// The budget of a cycle is the sum of the budgets of all running procedures.
static void a_procedure_that_exceeds_its_share_reduces_that_of_the_next(void)
{
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_activate("B", 0U);
    for (unsigned i = 0U; i < 6U; i++) {
        st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
        st18_fixture_call(1U, PUS_CALL_PAUSED, 0U);
    }
    st18_fixture.slots[0].uses = 100U;
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT32(100U, st18_fixture.slots[0].last);
    TEST_ASSERT_EQUAL_UINT32(100U, st18_fixture.slots[1].last);
    st18_fixture.slots[0].uses = 130U;
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT32(70U, st18_fixture.slots[1].last);
    st18_fixture.slots[0].uses = 1000U;
    st18_fixture.slots[1].last = 0U;
    st18_fixture_step(1U);
    // The engine was not called for the procedure.
    TEST_ASSERT_EQUAL_UINT32(0U, st18_fixture.slots[1].last);
    // Units that are not used are not saved for other procedures.
    st18_fixture.slots[0].uses = 0U;
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT32(100U, st18_fixture.slots[0].last);
    TEST_ASSERT_EQUAL_UINT32(100U, st18_fixture.slots[1].last);
}

static void a_procedure_is_suspended_at_the_beginning_of_its_next_step(void)
{
    st18_fixture_activate("ABCD", PUS_OBSERVE_PROCEDURE);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_call(0U, PUS_CALL_STEP, 2U);
    expect_accepted(5U, "ABCD", next_step, 2U);
    st18_fixture_step(1U);
    expect_procedure_status(PUS_PROCEDURE_RUNNING);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5);
    expect_procedure_status(PUS_PROCEDURE_HELD);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_HELD, 1U, 1U);
    const uint32_t budget = st18_fixture.slots[0].budget;
    st18_fixture_step(5U);
    TEST_ASSERT_EQUAL_UINT32(budget, st18_fixture.slots[0].budget);
    expect_refused(5U, "ABCD", next_step, 2U, PUS_FAILURE_STATE, ABCD);
    expect_accepted(6U, "ABCD", NULL, 0U);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_RESUMED, 1U, 0U);
    expect_refused(6U, "ABCD", NULL, 0U, PUS_FAILURE_STATE, ABCD);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5); // Step 2.
    expect_procedure_status(PUS_PROCEDURE_RUNNING);
}

static void a_procedure_is_suspended_and_stopped_at_the_named_step(void)
{
    st18_fixture_activate("ABCD", PUS_OBSERVE_PROCEDURE);
    expect_accepted(5U, "ABCD", step_2, 2U);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_call(0U, PUS_CALL_STEP, 2U);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_call(0U, PUS_CALL_STEP, 2U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5, 1, 5);
    expect_procedure_status(PUS_PROCEDURE_HELD);
    expect_accepted(6U, "ABCD", NULL, 0U);
    expect_accepted(4U, "ABCD", step_2, 2U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5, 1, 8);
    octet_reader_t reader = bench_data(1U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, octet_read_u16(&reader));
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_STOPPED, 2U, 0U);
    expect_procedure_status(PUS_PROCEDURE_INACTIVE);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.aborted);
}

static void a_procedure_that_waits_at_a_step_is_stopped_at_once(void)
{
    st18_fixture_activate("ABCD", 0U);
    expect_accepted(5U, "ABCD", next_step, 2U);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(4U, "ABCD", step_2, 2U));
    EXPECT_MESSAGES(1, 1, 1, 8, 1, 3, 1, 7); // Reports of the activation, then of the request itself.
    expect_procedure_status(PUS_PROCEDURE_INACTIVE);
}

static void a_procedure_is_executed_one_step_at_a_time(void)
{
    static const uint8_t body[] = {0, 0};
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(14U, "ABCD", body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 3);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_call(0U, PUS_CALL_STEP, 2U);
    st18_fixture_call(0U, PUS_CALL_STEP, 3U);
    st18_fixture_step(3U);
    EXPECT_MESSAGES(1, 5);
    expect_accepted(15U, "ABCD", NULL, 0U);
    st18_fixture_step(3U);
    EXPECT_MESSAGES(1, 5);
    expect_procedure_status(PUS_PROCEDURE_HELD);
    TEST_ASSERT_EQUAL_UINT64(2U, st18_fixture.slots[0].next);
}

static void an_inactive_procedure_is_neither_suspended_nor_aborted(void)
{
    static const uint8_t none[] = {0};
    expect_refused(4U, "ABCD", next_step, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(5U, "ABCD", next_step, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(6U, "ABCD", NULL, 0U, PUS_FAILURE_STATE, ABCD);
    expect_refused(7U, "ABCD", none, 1U, PUS_FAILURE_STATE, ABCD);
    expect_refused(12U, "ABCD", NULL, 0U, PUS_FAILURE_STATE, ABCD);
    expect_refused(15U, "ABCD", NULL, 0U, PUS_FAILURE_STATE, ABCD);
    expect_refused(20U, "ABCD", next_step, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(4U, "none", next_step, 2U, PUS_FAILURE_UNKNOWN_ID, 0x6E6F6E65U);
}

static void a_procedure_is_aborted_at_any_step(void)
{
    st18_fixture_activate("ABCD", PUS_OBSERVE_PROCEDURE);
    st18_fixture_step(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, st18_fixture_send(12U, "ABCD", NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 8, 1, 3, 1, 7);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_ABORTED, 0U, 0U);
    TEST_ASSERT_FALSE(st18_fixture.slots[0].is_running);
}

static void all_are_aborted_and_reported(void)
{
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_load("C", 1U, 'x');
    st18_fixture_activate("C", 0U);
    st18_fixture_activate("ABCD", 0U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(17U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8, 1, 8, 18, 18, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(18U, bench_report(4U).size);
    // Two names of 8 octets.
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\0\2ABCD\0\0\0\0C\0\0\0\0\0\0\0", bench_report(4U).data, 18U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(17U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
}

static void a_waiting_procedure_waits_for_whole_cycles(void)
{
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_wait(0U, PUS_CALL_WAIT, 0.0);
    st18_fixture_wait(0U, PUS_CALL_WAIT, 0.041); // Five cycles of 10 ms.
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_wait(0U, PUS_CALL_WAIT, 1e9);
    st18_fixture_step(5U);
    EXPECT_MESSAGES(0);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5);
    st18_fixture_step(100U);
    TEST_ASSERT_EQUAL_UINT64(4U, st18_fixture.slots[0].next);
    st18_fixture.cycle += 1000U; // The missed cycles count as time.
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT64(4U, st18_fixture.slots[0].next);
}

static void calls_with_external_effects_are_limited_in_a_cycle(void)
{
    st18_fixture_activate("ABCD", 0U);
    for (unsigned i = 0U; i < ST18_FIXTURE_CALLS_EACH; i++) {
        st18_fixture_call(0U, PUS_CALL_EVENT, ST18_FIXTURE_KNOWN_EVENT);
        st18_fixture_call(0U, PUS_CALL_GET, 77U); // Calls without external effects do not count.
    }
    st18_fixture_call(0U, PUS_CALL_EVENT, ST18_FIXTURE_KNOWN_EVENT);
    st18_fixture_call(0U, PUS_CALL_ENDED, 0U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT(ST18_FIXTURE_CALLS_EACH, st18_fixture.events.count);
    TEST_ASSERT_TRUE(pus_procedures_are_active(self));
    st18_fixture_step(1U); // The answer to the last call was not lost.
    TEST_ASSERT_EQUAL_UINT(ST18_FIXTURE_CALLS_EACH + 1U, st18_fixture.events.count);
    TEST_ASSERT_FALSE(pus_procedures_are_active(self));
}

static void requests_are_released(void)
{
    st18_fixture_activate("ABCD", PUS_OBSERVE_ALL);
    st18_fixture_request(0U, false);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.sent.count);
    TEST_ASSERT_EQUAL_UINT16(33U, st18_fixture.sent.last.apid);
    TEST_ASSERT_EQUAL_UINT8(17U, st18_fixture.sent.last.service);
    TEST_ASSERT_EQUAL_UINT8(0U, st18_fixture.sent.last.ack);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_ONBOARD | TEST_APID, st18_fixture.sent.last.source);
    TEST_ASSERT_EQUAL(PUS_ANSWER_VERDICT, st18_fixture.slots[0].answer.kind);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_SENT, 0U, (17U << 8U) | 1U);
    st18_fixture.sent.status = STATUS_FULL; // The request is repeated until the port accepts it.
    st18_fixture_request(0U, false);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(100U);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.sent.count);
    st18_fixture.sent.status = STATUS_OK;
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5);
    TEST_ASSERT_EQUAL_UINT32(2U, self->counters.sent);
    for (uint16_t i = 0U; i < PUS_ADDRESSEES; i++) { // The table of sequence counts for addressees is full.
        st18_fixture.requester.addressees[i].apid = (uint16_t)(1000U + i);
    }
    st18_fixture.requester.addressee_count = PUS_ADDRESSEES;
    st18_fixture_request(0U, false);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_TABLE_FULL, st18_fixture.slots[0].answer.code);
}

/// Pass to the service a verification report of the last request sent.
static void observe(const uint8_t subtype, const uint16_t destination, const uint32_t request_id,
                    const uint8_t service)
{
    uint8_t octets[14]    = {0};
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u32(&writer, request_id);
    if (subtype == 8U) {
        octet_write_u16(&writer, PUS_FAILURE_NO_ANSWER);
        octet_write_u16(&writer, 0U);
        octet_write_u32(&writer, 5U);
    }
    const pus_tm_t tm = {.apid        = 33U,
                         .service     = service,
                         .subtype     = subtype,
                         .destination = destination,
                         .data        = octets,
                         .size        = writer.position};
    pus_procedures_observe(self, &tm);
}

static void the_end_of_a_request_is_awaited(void)
{
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_request(0U, true);
    st18_fixture_request(0U, true);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    const uint16_t user = PUS_USER_ONBOARD | TEST_APID;
    const uint32_t id   = st18_fixture.sent.last.request_id;
    TEST_ASSERT_EQUAL_UINT8(PUS_ACK_ACCEPTANCE | PUS_ACK_COMPLETION, st18_fixture.sent.last.ack);
    TEST_ASSERT_EQUAL_UINT64(3U, st18_fixture.sent.last.size);
    observe(7U, PUS_USER_GROUND, id, 1U);
    observe(7U, user, id + 1U, 1U);
    observe(3U, user, id, 1U);
    observe(7U, user, id, 17U);
    st18_fixture_step(2U);
    TEST_ASSERT_EQUAL_UINT64(1U, st18_fixture.slots[0].next);
    observe(7U, user, id, 1U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL(PUS_ANSWER_VERDICT, st18_fixture.slots[0].answer.kind);
    TEST_ASSERT_EQUAL_HEX16(0U, st18_fixture.slots[0].answer.code);
    TEST_ASSERT_EQUAL_UINT(2U, st18_fixture.sent.count);
    observe(8U, user, st18_fixture.sent.last.request_id, 1U);
    observe(7U, user, st18_fixture.sent.last.request_id, 1U); // The report comes too late.
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 5);
    st18_fixture_request(0U, true);
    st18_fixture_step(ST18_FIXTURE_TIMEOUT);
    TEST_ASSERT_EQUAL_UINT(3U, st18_fixture.sent.count);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_TIMEOUT, st18_fixture.slots[0].answer.code);
    TEST_ASSERT_EQUAL_UINT32(500U, st18_fixture.slots[0].answer.detail);
}

static void a_failed_completion_ends_the_wait_for_the_request(void)
{
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_request(0U, true);
    st18_fixture_step(1U);
    observe(8U, PUS_USER_ONBOARD | TEST_APID, st18_fixture.sent.last.request_id, 1U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NO_ANSWER, st18_fixture.slots[0].answer.code);
    TEST_ASSERT_EQUAL_UINT32(5U, st18_fixture.slots[0].answer.detail);
}

static void values_of_a_request_wait_until_the_procedure_asks_for_them(void)
{
    static const uint8_t values[] = {1, 0, 42};
    static uint8_t many[1 + (2 * 255)];
    static uint8_t most[1 + (9 * 255)];
    st18_fixture_activate("ABCD", PUS_OBSERVE_ALL);
    st18_fixture_wait(0U, PUS_CALL_PARAMETERS, 1e9);
    st18_fixture_step(5U);
    expect_accepted(7U, "ABCD", values, sizeof values);
    expect_refused(7U, "ABCD", values, sizeof values, PUS_FAILURE_STATE, ABCD);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL(PUS_ANSWER_VALUES, st18_fixture.slots[0].answer.kind);
    TEST_ASSERT_EQUAL_UINT64(3U, st18_fixture.slots[0].answer.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(values, st18_fixture.slots[0].answer.octets, 3U);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_RECEIVED, 0U, 0U);
    expect_accepted(7U, "ABCD", values, sizeof values); // The values wait until the procedure asks for them.
    st18_fixture_wait(0U, PUS_CALL_PARAMETERS, 0.0);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_wait(0U, PUS_CALL_PARAMETERS, 0.0);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_wait(0U, PUS_CALL_PARAMETERS, 0.02);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL(PUS_ANSWER_VALUES, st18_fixture.slots[0].answer.kind);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL(PUS_ANSWER_MISSING, st18_fixture.slots[0].answer.kind);
    st18_fixture_step(3U);
    TEST_ASSERT_EQUAL(PUS_ANSWER_MISSING, st18_fixture.slots[0].answer.kind);
    many[0] = 255U;
    expect_accepted(7U, "ABCD", many, sizeof many);
    st18_fixture_wait(0U, PUS_CALL_PARAMETERS, 1.0);
    st18_fixture_step(1U);
    most[0] = 255U;
    for (size_t i = 0U; i < 255U; i++) {
        most[1U + (9U * i)] = (uint8_t)VALUE_UINT64;
    }
    expect_refused(7U, "ABCD", most, sizeof most, PUS_FAILURE_TABLE_FULL, PUS_PROCEDURE_ARGUMENTS_MAX);
}

static void observability_levels_of_procedures_are_set(void)
{
    static const uint8_t body[] = {3, 'A', 'B', 'C', 'D', 0,   0,   0,   0,   2, 'n', 'o', 'n', 'e',
                                   0, 0,   0,   0,   1,   'A', 'B', 'C', 'D', 0, 0,   0,   0,   4};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(16U, body, sizeof body));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, 0x6E6F6E65U);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 27U); // Level 4.
    st18_fixture_activate("ABCD", PUS_OBSERVE_NOTHING);        // The request has its own level.
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(16U, body, sizeof body));
    st18_fixture_call(0U, PUS_CALL_STEP, 3U);
    st18_fixture_step(1U);
    expect_observation(ST18_FIXTURE_OBSERVATION, "ABCD", PUS_OBSERVED_STEP, 3U, 3U);
    self->config.observation_event = 0U;
    st18_fixture_call(0U, PUS_CALL_STEP, 4U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.events.count);
}

static void without_an_engine_no_procedure_runs(void)
{
    static const uint8_t body[] = {0, 0};
    st18_fixture_activate("ABCD", 0U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(22U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 8, 1, 3, 1, 7);
    expect_refused(3U, "ABCD", body, 2U, PUS_FAILURE_STATE, ABCD);
    expect_refused(1U, "B", "\0\1x\0\0", 5U, PUS_FAILURE_STATE, 0x42000000U);
    st18_fixture_restart();
    expect_refused(3U, "ABCD", body, 2U, PUS_FAILURE_STATE, ABCD);
    records.put_status = STATUS_IO;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(21U, NULL, 0U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_IO);
    expect_refused(3U, "ABCD", body, 2U, PUS_FAILURE_STATE, ABCD);
    records.put_status = STATUS_OK;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(21U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(21U, NULL, 0U)); // The procedure already runs.
    st18_fixture_activate("ABCD", 0U);
    records.put_status = STATUS_IO;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(22U, NULL, 0U));
    expect_failure(1U, 4U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_TRUE(pus_procedures_are_active(self));
    self->config.persistence = NULL;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(22U, NULL, 0U));
    TEST_ASSERT_FALSE(pus_procedures_are_active(self));
}

static void stopped_procedures_can_be_unloaded(void)
{
    st18_fixture_activate("ABCD", 0U);
    expect_accepted(20U, "ABCD", next_step, 2U);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    EXPECT_MESSAGES(1, 8);
    st18_fixture_restart();
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size); // No procedure is loaded; the deletion was recorded.
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_activate("B", 0U);
    expect_accepted(20U, "B", next_step, 2U);
    records.commit_status = STATUS_IO;
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, self->counters.unsaved);
    records.commit_status       = STATUS_OK;
    self->config.persistence    = NULL;
    st18_fixture.slots[0].count = 0U;
    st18_fixture_load("C", 1U, 'x');
    st18_fixture_activate("C", 0U);
    expect_accepted(20U, "C", next_step, 2U);
    st18_fixture_step(1U);
    expect_procedure_status(PUS_PROCEDURE_RUNNING);
    st18_fixture_call(0U, PUS_CALL_STEP, 1U);
    st18_fixture_step(1U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
}

static void procedures_run_concurrently(void)
{
    st18_fixture_load("B", 1U, 'x');
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_activate("B", 0U);
    st18_fixture_wait(0U, PUS_CALL_WAIT, 1.0);
    st18_fixture_call(1U, PUS_CALL_STEP, 1U);
    st18_fixture_call(1U, PUS_CALL_ENDED, 0U);
    st18_fixture_step(2U);
    EXPECT_MESSAGES(1, 5, 1, 7);
    TEST_ASSERT_TRUE(st18_fixture.slots[0].is_running);
    st18_fixture_activate("B", 0U);
    TEST_ASSERT_EQUAL_UINT32(3U, self->counters.started);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_procedure_runs_to_its_end);
    RUN_TEST(errors_are_reported_at_every_level);
    RUN_TEST(a_long_text_is_truncated);
    RUN_TEST(activation_is_refused_in_a_wrong_state);
    RUN_TEST(a_procedure_that_exceeds_its_share_reduces_that_of_the_next);
    RUN_TEST(a_procedure_is_suspended_at_the_beginning_of_its_next_step);
    RUN_TEST(a_procedure_is_suspended_and_stopped_at_the_named_step);
    RUN_TEST(a_procedure_that_waits_at_a_step_is_stopped_at_once);
    RUN_TEST(a_procedure_is_executed_one_step_at_a_time);
    RUN_TEST(an_inactive_procedure_is_neither_suspended_nor_aborted);
    RUN_TEST(a_procedure_is_aborted_at_any_step);
    RUN_TEST(all_are_aborted_and_reported);
    RUN_TEST(a_waiting_procedure_waits_for_whole_cycles);
    RUN_TEST(calls_with_external_effects_are_limited_in_a_cycle);
    RUN_TEST(requests_are_released);
    RUN_TEST(the_end_of_a_request_is_awaited);
    RUN_TEST(a_failed_completion_ends_the_wait_for_the_request);
    RUN_TEST(values_of_a_request_wait_until_the_procedure_asks_for_them);
    RUN_TEST(observability_levels_of_procedures_are_set);
    RUN_TEST(without_an_engine_no_procedure_runs);
    RUN_TEST(stopped_procedures_can_be_unloaded);
    RUN_TEST(procedures_run_concurrently);
    return UNITY_END();
}
