// SPDX-License-Identifier: Apache-2.0
// The supervisor's ST[131]: mode, log strategy, shutdown, processes, networks. The numbers of requests and
// reports are subtypes; pus/catalogue/private/st131_mission.txt has their names and fields.
#include "pus/private/st131_mission.h"

#include "pus/private/st129_management.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static struct {
    pus_reply_t reply;
    unsigned calls;
    char asked;
    unsigned value;
    unsigned subsystems;
    unsigned networks;
} seen;

static pus_reply_t note(void* const context, const char asked, const unsigned value,
                        const pus_token_t* const token, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, token->request_id);
    seen.calls++;
    seen.asked = asked;
    seen.value = value;
    return seen.reply;
}

static pus_reply_t set_mode(void* const context, const uint8_t mode, const pus_token_t* const token,
                            const uint64_t now_ns)
{
    return note(context, 'm', mode, token, now_ns);
}

static pus_reply_t select_log(void* const context, const uint8_t strategy, const pus_token_t* const token,
                              const uint64_t now_ns)
{
    return note(context, 'l', strategy, token, now_ns);
}

static pus_reply_t shut_down(void* const context, const pus_token_t* const token, const uint64_t now_ns)
{
    return note(context, 'd', 0U, token, now_ns);
}

static pus_reply_t start_process(void* const context, const uint16_t apid, const pus_token_t* const token,
                                 const uint64_t now_ns)
{
    return note(context, '+', apid, token, now_ns);
}

static pus_reply_t stop_process(void* const context, const uint16_t apid, const pus_token_t* const token,
                                const uint64_t now_ns)
{
    return note(context, '-', apid, token, now_ns);
}

static bool subsystem(void* const context, const uint16_t index, pus_subsystem_entry_t* const out_entry)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    *out_entry = (pus_subsystem_entry_t){.apid          = (uint16_t)(16U + index),
                                         .process       = 1U,
                                         .state         = 2U,
                                         .phase         = 3U,
                                         .configuration = 4U,
                                         .restarts      = 5U};
    return index < seen.subsystems;
}

static bool network(void* const context, const uint16_t index, pus_network_entry_t* const out_entry)
{
    static const uint16_t members[] = {16U, 17U};
    static const uint16_t links[]   = {1U, 2U, 3U};
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    *out_entry = (pus_network_entry_t){.network      = (uint16_t)(index + 1U),
                                       .member_count = 2U,
                                       .link_count   = 3U,
                                       .members      = members,
                                       .links        = links};
    return index < seen.networks;
}

static pus_mission_t mission;

void setUp(void)
{
    const pus_mission_port_t port = {.context       = &seen,
                                     .set_mode      = set_mode,
                                     .select_log    = select_log,
                                     .shut_down     = shut_down,
                                     .start_process = start_process,
                                     .stop_process  = stop_process,
                                     .subsystem     = subsystem,
                                     .network       = network};
    memset(&seen, 0, sizeof seen);
    bench_start();
    memset(&mission, 0xA5, sizeof mission);
    pus_mission_init(&mission, &port);
    bench_serve(pus_mission_service(&mission));
}

void tearDown(void)
{
}

/// Expect that a request calls its callback with this value and is completed, and that a refusal of the
/// callback is reported.
static void expect_passed_on(const uint8_t subtype, const uint8_t* const data, const size_t size,
                             const char asked, const unsigned value)
{
    bench_clear();
    seen.reply = pus_done();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, size));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(asked, seen.asked);
    TEST_ASSERT_EQUAL_UINT32(value, seen.value);
    bench_clear();
    seen.reply = pus_refused(PUS_FAILURE_MEMBER_ACTIVE, 16U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, size));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_MEMBER_ACTIVE, 0U, 16U);
    seen.calls = 0U;
    expect_strict_format(subtype, data, size);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.calls);
}

static void requests_are_passed_on(void)
{
    static const uint8_t octets[] = {1, 2};
    expect_passed_on(1U, octets, 1U, 'm', 1U);
    expect_passed_on(3U, octets, 1U, 'l', 1U);
    expect_passed_on(5U, NULL, 0U, 'd', 0U);
    expect_passed_on(6U, octets, 2U, '+', 0x0102U);
    expect_passed_on(7U, octets, 2U, '-', 0x0102U);
}

static void only_known_log_strategies_are_passed_on(void)
{
    for (unsigned strategy = 0U; strategy < 256U; strategy++) {
        const uint8_t octet = (uint8_t)strategy;
        seen.calls          = 0U;
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, &octet, 1U));
        TEST_ASSERT_EQUAL_UINT32((strategy < 4U) ? 1U : 0U, seen.calls);
        if (strategy >= 4U) {
            expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
        }
    }
}

static void the_table_of_subsystems_is_reported(void)
{
    // Two subsystems: APID, process, state, phase, configuration (u16), restarts.
    static const uint8_t expected[] = {0, 2, 0, 16, 1, 2, 3, 0, 4, 5, 0, 17, 1, 2, 3, 0, 4, 5};
    seen.subsystems                 = 2U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 131, 9, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);
    const unsigned room = (PUS_TM_DATA_MAX - 2U) / 8U;
    for (unsigned extra = 0U; extra < 2U; extra++) {
        bench_clear();
        seen.subsystems = room + extra;
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
        TEST_ASSERT_EQUAL_UINT64((extra == 0U) ? 4U : 3U, bench.count);
    }
    expect_failure(2U, 8U, PUS_FAILURE_TABLE_FULL, 0U, PUS_TM_DATA_MAX);
    expect_strict_format(8U, NULL, 0U);
}

static void networks_are_reported_with_their_members_and_links(void)
{
    // Two networks, each with 2 members (16, 17) and 3 links (1, 2, 3); all numbers are u16.
    static const uint8_t expected[] = {0, 2, 0, 1, 0, 2, 0,  16, 0,  17, 0, 3, 0, 1, 0, 2, 0,
                                       3, 0, 2, 0, 2, 0, 16, 0,  17, 0,  3, 0, 1, 0, 2, 0, 3};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(10U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 131, 11, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
    bench_clear();
    seen.networks = 2U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(10U, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    bench_clear();
    seen.networks = 1000U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(10U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_strict_format(10U, NULL, 0U);
}

static void transitions_are_reported_to_all(void)
{
    static const uint8_t mode[]          = {1, 2, 3};
    static const uint8_t log[]           = {0, 1, 0, 0, 0, 1, 0, 0, 0, 9, 4, 4};
    const pus_mode_transition_t new_mode = {.previous = 1U, .mode = 2U, .cause = PUS_CAUSE_PLAN};
    const pus_log_transition_t new_log   = {.previous     = PUS_LOG_ASCII,
                                            .strategy     = PUS_LOG_SQLITE,
                                            .first_record = 0x100000009ULL,
                                            .code         = PUS_FAILURE_IO};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_mode_transition_report(&bench.process, &new_mode, TEST_NOW_NS));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_log_transition_report(&bench.process, &new_log, TEST_NOW_NS));
    EXPECT_MESSAGES(131, 2, 131, 4);
    TEST_ASSERT_EQUAL_UINT64(sizeof mode, bench_report(0U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(mode, bench_report(0U).data, sizeof mode);
    TEST_ASSERT_EQUAL_UINT64(sizeof log, bench_report(1U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(log, bench_report(1U).data, sizeof log);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(requests_are_passed_on);
    RUN_TEST(only_known_log_strategies_are_passed_on);
    RUN_TEST(the_table_of_subsystems_is_reported);
    RUN_TEST(networks_are_reported_with_their_members_and_links);
    RUN_TEST(transitions_are_reported_to_all);
    return UNITY_END();
}
