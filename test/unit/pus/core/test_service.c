// SPDX-License-Identifier: Apache-2.0
// The dispatcher: acceptance, start and completion of requests, and requests that another loop performs.
#include "pus/core/service.h"

#include "pus/core/request_format.h"
#include "pus/st01/st01_verification.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

/// A service whose requests have the results that the test sets, for each instruction.
static struct {
    pus_reply_t reply;
    unsigned calls;
    unsigned steps;
    unsigned instructions; // Instructions of a request; bit i of `faulty` refuses instruction i + 1.
    unsigned faulty;
    bool is_unfinished;
    uint16_t packets_lost;
    pus_token_t token;
} served;

static pus_reply_t execute(void* const self, pus_request_t* const request)
{
    TEST_ASSERT_EQUAL_PTR(&served, self);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, request->now_ns);
    served.calls++;
    served.token = request->token;
    for (unsigned i = 0U; i < served.instructions; i++) {
        if ((served.faulty & (1U << i)) != 0U) {
            pus_request_refuse(request, (uint16_t)(i + 1U), PUS_FAILURE_UNKNOWN_ID, 100U + i);
        } else {
            pus_request_perform(request);
        }
    }
    request->is_unfinished = served.is_unfinished;
    request->packets_lost  = served.packets_lost;
    return served.reply;
}

static bool inconsistent(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)octet_read_u16(reader);
    return false;
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    TEST_ASSERT_EQUAL_PTR(&served, self);
    TEST_ASSERT_EQUAL_UINT64(77U, now_ns);
    TEST_ASSERT_EQUAL_UINT32(5U, cycle);
    served.steps++;
}

static const uint8_t format_u32[]      = {PUS_REQUEST_FORMAT_SKIP, 4U, PUS_REQUEST_FORMAT_END};
static const uint8_t format_list_u16[] = {PUS_REQUEST_FORMAT_COUNT, 1U, 2U,
                                          PUS_REQUEST_FORMAT_SKIP,  2U, PUS_REQUEST_FORMAT_END};
static const uint8_t format_list_u32[] = {PUS_REQUEST_FORMAT_COUNT, 1U, 2U,
                                          PUS_REQUEST_FORMAT_SKIP,  4U, PUS_REQUEST_FORMAT_END};
static const pus_subtype_t subtypes[]  = {
     {1U, pus_request_format_empty, execute, NULL},
     {2U, pus_request_format_u8, execute, NULL},
     {3U, pus_request_format_u16, execute, NULL},
     {4U, NULL, execute, format_u32},
     {5U, NULL, execute, format_list_u16},
     {6U, NULL, execute, format_list_u32},
     {7U, inconsistent, execute, NULL},
};

void setUp(void)
{
    memset(&served, 0, sizeof served);
    bench_start();
    bench_serve((pus_service_t){
        .type = 200U, .subtype_count = 7U, .subtypes = subtypes, .self = &served, .step = step});
}

void tearDown(void)
{
}

static void a_performed_request_is_accepted_started_and_completed(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    for (size_t i = 0U; i < 3U; i++) {
        octet_reader_t reader = bench_data(i);
        TEST_ASSERT_EQUAL_HEX32(bench.request_id, octet_read_u32(&reader));
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, bench.dispatcher.counters.accepted);
}

static void a_longer_request_is_completed_with_its_token(void)
{
    served.reply = pus_later();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3);
    bench_clear();
    pus_verify_progress(&bench.process, &served.token, 2U, TEST_NOW_NS);
    pus_verify_completed(&bench.process, &served.token, TEST_NOW_NS);
    EXPECT_MESSAGES(1, 5, 1, 7);
    octet_reader_t reader = bench_data(1U);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, octet_read_u32(&reader));
}

static void a_refused_start_and_a_failed_execution_are_distinguished(void)
{
    served.reply = pus_refused(PUS_FAILURE_STATE, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 5U);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.dispatcher.counters.refused);
    bench_clear();
    served.reply = pus_failed(PUS_FAILURE_TIMEOUT, 250U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_TIMEOUT, 0U, 250U);
}

static void without_flags_only_failures_are_reported(void)
{
    bench.ack = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    served.reply = pus_refused(PUS_FAILURE_STATE, 5U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    served.reply = pus_failed(PUS_FAILURE_TIMEOUT, 250U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(99U, NULL, 0U));
    EXPECT_MESSAGES(1, 4, 1, 8, 1, 2);
    for (unsigned flag = 0U; flag < 4U; flag++) {
        static const uint8_t expected[] = {1U, 3U, 0U, 7U}; // No progress is reported.
        bench_clear();
        served.reply = pus_done();
        bench.ack    = (uint8_t)(1U << flag);
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64((expected[flag] != 0U) ? 1U : 0U, bench.count);
        if (expected[flag] != 0U) {
            TEST_ASSERT_EQUAL_UINT8(expected[flag], bench_report(0U).subtype);
        }
    }
}

static void each_instruction_is_checked_independently(void)
{
    served.instructions = 4U;
    served.faulty       = 0x5U; // Instructions 1 and 3 are faulty.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 4, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 100U);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 3U, 102U);
    expect_failure(4U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    bench_clear();
    served.faulty = 0xFU;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 4);
    bench_clear();
    served.faulty = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void unknown_services_and_subtypes_are_rejected(void)
{
    for (unsigned subtype = 0U; subtype < 256U; subtype++) {
        if ((subtype < 1U) || (subtype > 7U)) {
            bench_clear();
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request((uint8_t)subtype, NULL, 0U));
            TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
            expect_failure(0U, 2U, PUS_FAILURE_SUBTYPE, 0U, (200U << 8U) | subtype);
        }
    }
    for (unsigned service = 0U; service < 256U; service++) {
        uint8_t octets[32];
        size_t size       = 0U;
        const pus_tc_t tc = {
            .apid = TEST_APID, .service = (uint8_t)service, .subtype = 1U, .source = TEST_SOURCE};
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, sizeof octets, &size));
        bench_clear();
        bench.request_id = 0x1810C000U;
        if (service != 200U) {
            TEST_ASSERT_EQUAL(STATUS_INVALID, pus_dispatch(&bench.dispatcher, octets, size, TEST_NOW_NS));
            expect_failure(0U, 2U, PUS_FAILURE_SERVICE, 0U, service);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, served.calls);
}

static void an_unknown_apid_is_rejected(void)
{
    uint8_t octets[32];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid = 17U, .service = 200U, .subtype = 1U, .source = TEST_SOURCE};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, sizeof octets, &size));
    bench.request_id = 0x1811C000U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_dispatch(&bench.dispatcher, octets, size, TEST_NOW_NS));
    EXPECT_MESSAGES(1, 2);
    expect_failure(0U, 2U, PUS_FAILURE_APID, 0U, 17U);
}

static void a_malformed_packet_is_rejected_if_its_request_id_is_readable(void)
{
    uint8_t octets[32];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid = TEST_APID, .service = 200U, .subtype = 1U, .source = TEST_SOURCE};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, sizeof octets, &size));
    bench.source     = PUS_USER_GROUND; // A request that is too short has no source.
    bench.request_id = 0x1810C000U;
    for (size_t cut = 0U; cut < size; cut++) {
        bench_clear();
        const status_t status = pus_dispatch(&bench.dispatcher, octets, cut, TEST_NOW_NS);
        TEST_ASSERT_EQUAL((cut < 4U) ? STATUS_TRUNCATED : STATUS_INVALID, status);
        TEST_ASSERT_EQUAL_UINT64((cut < 4U) ? 0U : 1U, bench.count);
        if (cut >= 4U) {
            expect_failure(0U, 2U, PUS_FAILURE_LENGTH, 0U, (uint32_t)cut);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(4U, bench.dispatcher.counters.ignored);
    TEST_ASSERT_EQUAL_UINT32(size - 4U, bench.dispatcher.counters.rejected);
    bench.source = TEST_SOURCE;
    octets[12] ^= 1U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_dispatch(&bench.dispatcher, octets, size, TEST_NOW_NS));
    octet_reader_t reader = bench_data(0U);
    (void)octet_read_u32(&reader);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_CHECKSUM, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT32(0U, served.calls);
}

static void formats_end_exactly_with_the_last_octet(void)
{
    static const struct {
        uint8_t subtype;
        size_t size;
        uint8_t data[9];
    } cases[] = {{1U, 0U, {0}}, {2U, 1U, {9}}, {3U, 2U, {0}}, {4U, 4U, {0}}, {5U, 5U, {2}}, {6U, 9U, {2}}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(cases[i].subtype, cases[i].data, cases[i].size));
        expect_strict_format(cases[i].subtype, cases[i].data, cases[i].size);
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(7U, cases[0].data, 2U));
    expect_failure(0U, 2U, PUS_FAILURE_DATA, 0U, 2U);
}

static void counts_are_limited_by_the_octets_that_follow(void)
{
    static uint8_t data[1U + (255U * 4U) + 1U];
    for (unsigned count = 0U; count < 256U; count++) {
        for (uint8_t subtype = 5U; subtype <= 6U; subtype++) {
            const size_t width = (subtype == 5U) ? 2U : 4U;
            const size_t right = 1U + (count * width);
            data[0]            = (uint8_t)count;
            TEST_ASSERT_EQUAL((count > 0U) ? STATUS_OK : STATUS_INVALID, bench_request(subtype, data, right));
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, data, right + 1U));
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, data, right - 1U));
            bench_clear();
        }
    }
}

static void a_step_sends_queued_reports_and_steps_the_services(void)
{
    bench.refusals = 2U;
    bench.ack      = PUS_ACK_COMPLETION;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    bench.refusals = 0U;
    bench_step(77U, 5U);
    EXPECT_MESSAGES(1, 7);
    TEST_ASSERT_EQUAL_UINT32(1U, served.steps);
    bench.services[0].step = NULL;
    bench_step(77U, 5U);
}

// ---- Requests that another loop performs ----

static struct {
    pus_reply_t reply;
    pus_token_t token;
    uint8_t data[4];
    size_t size;
} taken;

static pus_reply_t take(void* const context, const pus_token_t* const token, const uint8_t* const data,
                        const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&taken, context);
    TEST_ASSERT_TRUE(size <= sizeof taken.data);
    taken.token = *token;
    taken.size  = size;
    if (size > 0U) {
        (void)memcpy(taken.data, data, size);
    }
    return taken.reply;
}

static void a_request_that_is_taken_is_performed_later(void)
{
    static const uint8_t number[]   = {1U, 2U};
    const pus_performer_t performer = {&taken, take};
    pus_dispatcher_defer(&bench.dispatcher, &performer);
    taken.reply = pus_started();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, number, sizeof number));
    EXPECT_MESSAGES(1, 1);
    TEST_ASSERT_EQUAL_UINT32(0U, served.calls);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, taken.token.request_id);
    TEST_ASSERT_EQUAL_UINT8_ARRAY(number, taken.data, sizeof number);
    bench_clear();
    served.instructions = 2U;
    served.faulty       = 1U;
    pus_perform(&bench.process, &bench.services[0], &taken.token, taken.data, taken.size, TEST_NOW_NS);
    EXPECT_MESSAGES(1, 4, 1, 3, 1, 8);
    TEST_ASSERT_EQUAL_UINT32(1U, served.calls);
}

static void a_performer_may_be_full_or_may_not_perform_the_request(void)
{
    const pus_performer_t performer = {&taken, take};
    pus_dispatcher_defer(&bench.dispatcher, &performer);
    taken.reply = pus_refused(PUS_FAILURE_TABLE_FULL, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 3U);
    TEST_ASSERT_EQUAL_UINT32(0U, served.calls);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.dispatcher.counters.refused);
    bench_clear();
    taken.reply = pus_done();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(1U, served.calls);
    bench_clear();
    // The request is not accepted, so the callback is not called.
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(9U, NULL, 0U));
    EXPECT_MESSAGES(1, 2);
}

static status_t fail_to_keep(void* const context)
{
    (void)context;
    return STATUS_IO;
}

/// A request that is refused or fails by itself has its own failure code, even if its records are not stored.
static void a_request_whose_effect_is_not_stored_is_not_completed(void)
{
    static const pus_persistence_t persistence = {.commit = fail_to_keep};
    pus_dispatcher_persist(&bench.dispatcher, &persistence);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, (uint32_t)STATUS_IO);
    bench_clear();
    served.reply = pus_refused(PUS_FAILURE_STATE, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 3U);
    bench_clear();
    served.reply = pus_failed(PUS_FAILURE_DEVICE, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_DEVICE, 0U, 4U);
}

/// The performer of a request that continues completes it; a request whose instructions were all refused is
/// complete.
static void a_request_whose_effect_cannot_be_stored_ends_once(void)
{
    static const pus_persistence_t persistence = {.commit = fail_to_keep};
    pus_dispatcher_persist(&bench.dispatcher, &persistence);
    served.reply = pus_later();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3);
    bench_clear();
    served.reply        = pus_done();
    served.instructions = 2U;
    served.faulty       = 3U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4);
    bench_clear();
    served.faulty = 2U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_IO, 0U, (uint32_t)STATUS_IO);
    bench_clear();
    served.instructions  = 0U;
    served.is_unfinished = true;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_TRUE(pus_dispatcher_is_answering(&bench.dispatcher));
    bench_clear();
    served.is_unfinished = false;
    TEST_ASSERT_FALSE(pus_dispatcher_resume(&bench.dispatcher, TEST_NOW_NS));
    EXPECT_MESSAGES(1, 7);
}

static void a_request_that_was_done_fails_if_packets_of_its_answer_were_lost(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    served.packets_lost = 2U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    bench_clear();
    served.reply = pus_failed(PUS_FAILURE_DEVICE, 4U); // The request ends with this failure.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_DEVICE, 0U, 4U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_performed_request_is_accepted_started_and_completed);
    RUN_TEST(a_longer_request_is_completed_with_its_token);
    RUN_TEST(a_refused_start_and_a_failed_execution_are_distinguished);
    RUN_TEST(without_flags_only_failures_are_reported);
    RUN_TEST(each_instruction_is_checked_independently);
    RUN_TEST(unknown_services_and_subtypes_are_rejected);
    RUN_TEST(an_unknown_apid_is_rejected);
    RUN_TEST(a_malformed_packet_is_rejected_if_its_request_id_is_readable);
    RUN_TEST(formats_end_exactly_with_the_last_octet);
    RUN_TEST(counts_are_limited_by_the_octets_that_follow);
    RUN_TEST(a_step_sends_queued_reports_and_steps_the_services);
    RUN_TEST(a_request_that_is_taken_is_performed_later);
    RUN_TEST(a_performer_may_be_full_or_may_not_perform_the_request);
    RUN_TEST(a_request_whose_effect_is_not_stored_is_not_completed);
    RUN_TEST(a_request_whose_effect_cannot_be_stored_ends_once);
    RUN_TEST(a_request_that_was_done_fails_if_packets_of_its_answer_were_lost);
    return UNITY_END();
}
