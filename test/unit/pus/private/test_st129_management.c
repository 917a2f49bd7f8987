// SPDX-License-Identifier: Apache-2.0
// The subsystem's side of ST[129]: states, configurations and status. The numbers of requests and reports are
// subtypes; pus/catalogue/private/st129_management.txt has their names and fields.
#include "pus/private/st129_management.h"

#include "pus/st01/st01_verification.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static struct {
    pus_reply_t reply;
    unsigned calls;
    char asked; // 't': a state (target), 'c': a configuration, 'r': to read the descriptor again.
    unsigned value;
    pus_token_t token;
} seen;

static const pus_subsystem_status_t status = {.state              = 3U,
                                              .phase              = 2U,
                                              .target             = 5U,
                                              .configuration      = 0x0102U,
                                              .interface_hash     = 0x1112131415161718ULL,
                                              .configuration_hash = 0x2122232425262728ULL,
                                              .epoch              = 0x31323334U,
                                              .cycle              = 0x41424344U};

static pus_reply_t note(void* const context, const char asked, const unsigned value,
                        const pus_token_t* const token, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    seen.calls++;
    seen.asked = asked;
    seen.value = value;
    seen.token = *token;
    return seen.reply;
}

static pus_reply_t request_state(void* const context, const pus_state_order_t* const order,
                                 const pus_token_t* const token, const uint64_t now_ns)
{
    return note(context, 't', ((unsigned)order->cause << 8U) | order->target, token, now_ns);
}

static pus_reply_t select_configuration(void* const context, const uint16_t configuration,
                                        const pus_token_t* const token, const uint64_t now_ns)
{
    return note(context, 'c', configuration, token, now_ns);
}

static pus_reply_t reload_descriptor(void* const context, const pus_token_t* const token,
                                     const uint64_t now_ns)
{
    return note(context, 'r', 0U, token, now_ns);
}

static void read_status(void* const context, pus_subsystem_status_t* const out_status)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    *out_status = status;
}

static pus_management_t management;

void setUp(void)
{
    const pus_management_port_t port = {.context              = &seen,
                                        .request_state        = request_state,
                                        .select_configuration = select_configuration,
                                        .reload_descriptor    = reload_descriptor,
                                        .read_status          = read_status};
    memset(&seen, 0, sizeof seen);
    bench_start();
    memset(&management, 0xA5, sizeof management);
    pus_management_init(&management, &port);
    bench_serve(pus_management_service(&management));
}

void tearDown(void)
{
}

static void a_state_is_asked_for_and_reached_later(void)
{
    const uint8_t target = 5U;
    seen.reply           = pus_later();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, &target, 1U));
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_EQUAL('t', seen.asked);
    TEST_ASSERT_EQUAL_UINT32(5U, seen.value);
    pus_verify_progress(&bench.process, &seen.token, 4U, TEST_NOW_NS);
    pus_verify_completed(&bench.process, &seen.token, TEST_NOW_NS);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 5, 1, 7);
}

/// The supervisor's request contains its cause; other users request without a cause, by TC[129,1].
static void an_order_of_the_supervisor_contains_its_cause(void)
{
    uint8_t order[2] = {6U, 0U}; // ERROR_OPERATIONAL, and the cause.
    seen.reply       = pus_later();
    bench.source     = PUS_USER_SUPERVISOR;
    for (uint8_t cause = 0U; cause <= (uint8_t)PUS_CAUSE_SUPERVISOR_LOST; cause++) {
        order[1] = cause;
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, order, 2U));
        EXPECT_MESSAGES(1, 1, 1, 3);
        TEST_ASSERT_EQUAL('t', seen.asked);
        TEST_ASSERT_EQUAL_HEX32(((unsigned)cause << 8U) | 6U, seen.value);
    }
    order[1] = (uint8_t)PUS_CAUSE_SUPERVISOR_LOST + 1U;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, order, 2U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_OUT_OF_RANGE, octets_u16_at(&bench_report(1U).data[4]));
    static const uint16_t others[] = {TEST_SOURCE, PUS_USER_ONBOARD, PUS_USER_SUPERVISOR + 1U, 1U};
    const unsigned calls           = seen.calls;
    order[1]                       = (uint8_t)PUS_CAUSE_NETWORK;
    for (size_t i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        bench.source = others[i];
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, order, 2U));
        EXPECT_MESSAGES(1, 1, 1, 4);
        TEST_ASSERT_EQUAL_UINT16(others[i], bench_report(1U).destination);
        TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_SOURCE, octets_u16_at(&bench_report(1U).data[4]));
    }
    TEST_ASSERT_EQUAL_UINT(calls, seen.calls);
}

static void a_configuration_and_a_reload_are_passed_on(void)
{
    static const uint8_t configuration[] = {1, 2};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, configuration, 2U));
    TEST_ASSERT_EQUAL('c', seen.asked);
    TEST_ASSERT_EQUAL_HEX32(0x0102U, seen.value);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(6U, NULL, 0U));
    TEST_ASSERT_EQUAL('r', seen.asked);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7, 1, 1, 1, 3, 1, 7);
    seen.reply = pus_refused(PUS_FAILURE_STATE, 5U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, configuration, 2U));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 5U);
}

static void status_is_reported_to_the_requester(void)
{
    static const uint8_t expected[] = {3,    2,    5,    1,    2,    0x11, 0x12, 0x13, 0x14, 0x15,
                                       0x16, 0x17, 0x18, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27,
                                       0x28, 0x31, 0x32, 0x33, 0x34, 0x41, 0x42, 0x43, 0x44};
    pus_subsystem_status_t read;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(4U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 129, 5, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    for (size_t size = 0U; size <= sizeof expected; size++) {
        octet_reader_t reader = octet_reader(expected, size);
        TEST_ASSERT_EQUAL((size == sizeof expected) ? STATUS_OK : STATUS_INVALID,
                          pus_subsystem_status_read(&reader, &read));
    }
    TEST_ASSERT_EQUAL_UINT8(status.target, read.target);
    TEST_ASSERT_EQUAL_UINT16(status.configuration, read.configuration);
    TEST_ASSERT_EQUAL_HEX64(status.interface_hash, read.interface_hash);
    TEST_ASSERT_EQUAL_HEX64(status.configuration_hash, read.configuration_hash);
    TEST_ASSERT_EQUAL_HEX32(status.epoch, read.epoch);
    TEST_ASSERT_EQUAL_HEX32(status.cycle, read.cycle);
}

static void a_transition_is_reported_to_all(void)
{
    static const uint8_t expected[]   = {4, 5, 1, 0, 2, 3, 2, 4, 0, 1, 0, 0};
    const pus_transition_t transition = {.previous      = 4U,
                                         .state         = 5U,
                                         .phase         = 1U,
                                         .configuration = 2U,
                                         .cause         = PUS_CAUSE_PLAN,
                                         .code          = 0x0204U,
                                         .cycle         = 0x10000U};
    pus_transition_t read;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_transition_report(&bench.process, &transition, TEST_NOW_NS));
    EXPECT_MESSAGES(129, 2);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(0U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(0U).data, sizeof expected);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_transition_read(&reader, &read));
    TEST_ASSERT_EQUAL_UINT8(4U, read.previous);
    TEST_ASSERT_EQUAL_UINT8(PUS_CAUSE_PLAN, read.cause);
    TEST_ASSERT_EQUAL_HEX32(0x10000U, read.cycle);
    for (size_t size = 0U; size < sizeof expected; size++) {
        reader = octet_reader(expected, size);
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_transition_read(&reader, &read));
    }
    static const uint8_t longer[sizeof expected + 1U] = {0};
    reader                                            = octet_reader(longer, sizeof longer);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_transition_read(&reader, &read));
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t octets[2] = {3, 4};
    expect_strict_format(1U, octets, 1U);
    expect_strict_format(3U, octets, 2U);
    expect_strict_format(4U, NULL, 0U);
    expect_strict_format(6U, NULL, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(2U, octets, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(5U, octets, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, seen.calls);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_state_is_asked_for_and_reached_later);
    RUN_TEST(an_order_of_the_supervisor_contains_its_cause);
    RUN_TEST(a_configuration_and_a_reload_are_passed_on);
    RUN_TEST(status_is_reported_to_the_requester);
    RUN_TEST(a_transition_is_reported_to_all);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
