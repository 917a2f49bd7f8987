// SPDX-License-Identifier: Apache-2.0
// Verification reports: which acknowledgement flag requests which report, their octets, and their reader.
#include "pus/st01/st01_verification.h"

#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

static const pus_failure_t failure = {.code = 0x0204U, .instruction = 3U, .detail = 0xC0FFEE01U};

void setUp(void)
{
    bench_start();
}

void tearDown(void)
{
}

/// Send all nine reports of a token with these acknowledgement flags.
static void report_everything(const uint8_t ack)
{
    const pus_token_t token = {.request_id = 0x1810C019U, .source = TEST_SOURCE, .ack = ack};
    pus_verify_accepted(&bench.process, &token, TEST_NOW_NS);
    pus_verify_rejected(&bench.process, &token, &failure, TEST_NOW_NS);
    pus_verify_started(&bench.process, &token, TEST_NOW_NS);
    pus_verify_start_failed(&bench.process, &token, &failure, TEST_NOW_NS);
    pus_verify_progress(&bench.process, &token, 7U, TEST_NOW_NS);
    pus_verify_progress_failed(&bench.process, &token, 7U, &failure, TEST_NOW_NS);
    pus_verify_completed(&bench.process, &token, TEST_NOW_NS);
    pus_verify_failed(&bench.process, &token, &failure, TEST_NOW_NS);
    pus_verify_unrouted(&bench.process, &token, &failure, TEST_NOW_NS);
}

static void ended_reports_a_completion_or_a_failure(void)
{
    const pus_token_t token = {.request_id = bench.request_id, .source = TEST_SOURCE, .ack = PUS_ACK_ALL};
    bench_clear();
    pus_verify_ended(&bench.process, &token, pus_failure(PUS_FAILURE_NONE, 0U), TEST_NOW_NS);
    pus_verify_ended(&bench.process, &token, pus_failure(PUS_FAILURE_TIMEOUT, 5U), TEST_NOW_NS);
    EXPECT_MESSAGES(1, 7, 1, 8);
    expect_failure(1U, 8U, PUS_FAILURE_TIMEOUT, 0U, 5U);
}

static void each_flag_requests_its_stage_and_failures_are_always_reported(void)
{
    static const uint8_t bits[] = {[1] = 0x1U, [3] = 0x2U, [5] = 0x4U, [7] = 0x8U};
    for (unsigned ack = 0U; ack < 16U; ack++) {
        size_t index = 0U;
        bench_start();
        report_everything((uint8_t)ack);
        for (uint8_t subtype = 1U; subtype <= 10U; subtype++) {
            const bool is_success  = (subtype % 2U) == 1U;
            const bool is_expected = is_success ? ((subtype < 9U) && ((bits[subtype] & ack) != 0U)) : true;
            if (is_expected) {
                TEST_ASSERT_EQUAL_UINT8(subtype, bench_report(index).subtype);
                TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(index).destination);
                index++;
            }
        }
        TEST_ASSERT_EQUAL_UINT64(index, bench.count);
    }
}

static void octets_equal_those_of_the_golden_reports(void)
{
    static const uint8_t id[]       = {0x18, 0x10, 0xC0, 0x19};
    static const uint8_t progress[] = {0x18, 0x10, 0xC0, 0x19, 0x00, 0x07, 0x02,
                                       0x04, 0x00, 0x03, 0xC0, 0xFF, 0xEE, 0x01};
    report_everything(PUS_ACK_ALL);
    TEST_ASSERT_EQUAL_UINT64(4U, bench_report(0U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(id, bench_report(0U).data, 4U);
    TEST_ASSERT_EQUAL_UINT64(14U, bench_report(5U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(progress, bench_report(5U).data, 14U);
}

static void encoded_reports_are_decoded(void)
{
    report_everything(PUS_ACK_ALL);
    for (size_t i = 0U; i < bench.count; i++) {
        pus_verification_t read;
        const pus_tm_t tm     = bench_report(i);
        const bool is_failure = (tm.subtype % 2U) == 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, pus_verification_read(&tm, &read));
        TEST_ASSERT_EQUAL_UINT8(tm.subtype, read.subtype);
        TEST_ASSERT_EQUAL_HEX32(0x1810C019U, read.request_id);
        TEST_ASSERT_EQUAL_UINT16(((tm.subtype == 5U) || (tm.subtype == 6U)) ? 7U : 0U, read.step);
        TEST_ASSERT_EQUAL_HEX16(is_failure ? 0x0204U : 0U, read.failure.code);
        TEST_ASSERT_EQUAL_HEX32(is_failure ? 0xC0FFEE01U : 0U, read.failure.detail);
        TEST_ASSERT_EQUAL((is_failure && (tm.subtype != 6U)) || (tm.subtype == 7U),
                          pus_verification_is_final(&read));
    }
}

static void other_reports_and_other_lengths_are_refused(void)
{
    uint8_t data[20] = {0};
    for (unsigned subtype = 0U; subtype < 256U; subtype++) {
        static const size_t sizes[] = {0, 4, 12, 4, 12, 6, 14, 4, 12, 0, 12};
        const size_t right          = (subtype < 11U) ? sizes[subtype] : 0U;
        for (size_t size = 0U; size < sizeof data; size++) {
            pus_verification_t read;
            const pus_tm_t tm  = {.service = 1U, .subtype = (uint8_t)subtype, .data = data, .size = size};
            const status_t bad = (right == 0U) ? STATUS_NOT_FOUND : STATUS_INVALID;
            TEST_ASSERT_EQUAL(((right != 0U) && (size == right)) ? STATUS_OK : bad,
                              pus_verification_read(&tm, &read));
        }
    }
    pus_verification_t read;
    const pus_tm_t other = {.service = 5U, .subtype = 1U, .data = data, .size = 4U};
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_verification_read(&other, &read));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(ended_reports_a_completion_or_a_failure);
    RUN_TEST(each_flag_requests_its_stage_and_failures_are_always_reported);
    RUN_TEST(octets_equal_those_of_the_golden_reports);
    RUN_TEST(encoded_reports_are_decoded);
    RUN_TEST(other_reports_and_other_lengths_are_refused);
    return UNITY_END();
}
