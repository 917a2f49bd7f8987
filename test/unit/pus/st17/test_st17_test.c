// SPDX-License-Identifier: Apache-2.0
// Are-you-alive and on-board connection tests. The numbers of requests and reports are subtypes;
// pus/catalogue/st17_test.txt has their names and fields.
#include "pus/st17/st17_test.h"

#include "pus/st01/st01_verification.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static pus_test_t test;
static pus_reply_t reply;
static pus_token_t kept;

static pus_reply_t connect(void* const context, const uint16_t apid, const pus_token_t* const token,
                           const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&test, context);
    TEST_ASSERT_EQUAL_UINT16(0x0102U, apid);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    kept = *token;
    return reply;
}

void setUp(void)
{
    bench_start();
    memset(&test, 0xA5, sizeof test);
    pus_test_init(&test, NULL);
    bench_serve(pus_test_service(&test));
}

void tearDown(void)
{
}

static void offer_connection_tests(void)
{
    const pus_test_port_t port = {.context = &test, .connect = connect};
    memset(&test, 0xA5, sizeof test);
    pus_test_init(&test, &port);
    bench_serve(pus_test_service(&test));
}

static void an_are_you_alive_test_is_answered_to_its_sender(void)
{
    bench.ack = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(17, 2);
    TEST_ASSERT_EQUAL_UINT64(0U, bench_report(0U).size);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(0U).destination);
    bench_clear();
    bench.ack = PUS_ACK_ALL;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 17, 2, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, bench_report(2U).counter);
    expect_strict_format(1U, NULL, 0U);
}

static void a_connection_test_is_offered_only_with_a_port(void)
{
    static const uint8_t apid[] = {1, 2};
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(3U, apid, 2U));
    expect_failure(0U, 2U, PUS_FAILURE_SUBTYPE, 0U, 0x1103U);
    bench_clear();
    offer_connection_tests();
    reply = pus_done();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, apid, 2U));
    EXPECT_MESSAGES(1, 1, 1, 3, 17, 4, 1, 7);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(apid, bench_report(2U).data, 2U);
    expect_strict_format(3U, apid, 2U);

    reply = pus_later();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, apid, 2U));
    EXPECT_MESSAGES(1, 1, 1, 3);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, pus_test_connected(&bench.process, &kept, 0x0102U, TEST_NOW_NS));
    pus_verify_completed(&bench.process, &kept, TEST_NOW_NS);
    EXPECT_MESSAGES(17, 4, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(0U).destination);

    bench_clear();
    reply = pus_refused(PUS_FAILURE_UNKNOWN_ID, 0x0102U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, apid, 2U));
    EXPECT_MESSAGES(1, 1, 1, 4);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_are_you_alive_test_is_answered_to_its_sender);
    RUN_TEST(a_connection_test_is_offered_only_with_a_port);
    return UNITY_END();
}
