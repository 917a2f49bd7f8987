// SPDX-License-Identifier: Apache-2.0
// Requests that a process sends: sequence counts for each addressee, tokens and refusals.
#include "pus/core/requester.h"

#include "unity.h"

#include <string.h>

static pus_requester_t requester;
static uint8_t sent[PUS_PACKET_MAX];
static size_t sent_size;
static unsigned refusals;

static status_t keep(void* const context, const uint8_t* const packet, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&requester, context);
    if (refusals > 0U) {
        refusals--;
        return STATUS_FULL;
    }
    memcpy(sent, packet, size);
    sent_size = size;
    return STATUS_OK;
}

void setUp(void)
{
    const pus_port_t port = {.context = &requester, .send = keep};
    refusals              = 0U;
    pus_requester_init(&requester, 1U, &port);
}

void tearDown(void)
{
}

static pus_tc_t last(void)
{
    pus_tc_t tc;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(sent, sent_size, &tc, &failure));
    return tc;
}

static status_t send(const uint16_t apid, pus_token_t* const out_token)
{
    octet_writer_t writer = pus_tc_begin(&requester, apid, 129U, 1U, 0x9U);
    octet_write_u8(&writer, 3U);
    return pus_tc_send(&requester, &writer, out_token);
}

static void a_request_that_was_sent_is_neither_extended_nor_sent_again(void)
{
    pus_token_t token;
    octet_writer_t writer = pus_tc_begin(&requester, 16U, 129U, 1U, 0x9U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_send(&requester, &writer, &token));
    const size_t size = writer.position;
    octet_write_u8(&writer, 3U);
    TEST_ASSERT_TRUE(writer.failed);
    TEST_ASSERT_EQUAL_UINT64(size, writer.position);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tc_send(&requester, &writer, &token));
}

static void a_request_is_a_complete_packet_and_its_token_identifies_it(void)
{
    pus_token_t token;
    TEST_ASSERT_EQUAL(STATUS_OK, send(16U, &token));
    const pus_tc_t tc = last();
    TEST_ASSERT_EQUAL_UINT16(16U, tc.apid);
    TEST_ASSERT_EQUAL_HEX16(0x8001U, tc.source);
    TEST_ASSERT_EQUAL_HEX8(0x9U, tc.ack);
    TEST_ASSERT_EQUAL_UINT8(129U, tc.service);
    TEST_ASSERT_EQUAL_UINT8(1U, tc.subtype);
    TEST_ASSERT_EQUAL_UINT64(1U, tc.size);
    TEST_ASSERT_EQUAL_UINT8(3U, tc.data[0]);
    const pus_token_t expected = pus_token_of(&tc);
    TEST_ASSERT_EQUAL_HEX32(expected.request_id, token.request_id);
    TEST_ASSERT_EQUAL_HEX16(expected.source, token.source);
    TEST_ASSERT_EQUAL_HEX8(expected.ack, token.ack);
    TEST_ASSERT_EQUAL_UINT8(expected.service, token.service);
    TEST_ASSERT_EQUAL_UINT8(expected.subtype, token.subtype);
}

static void each_addressee_has_its_own_count_and_refusal_leaves_no_gap(void)
{
    static const uint16_t apids[]  = {16U, 17U, 16U, 2U, 17U, 16U};
    static const uint16_t counts[] = {0U, 0U, 1U, 0U, 1U, 2U};
    for (size_t i = 0U; i < 6U; i++) {
        refusals = 1U;
        TEST_ASSERT_EQUAL(STATUS_FULL, send(apids[i], NULL));
        TEST_ASSERT_EQUAL(STATUS_OK, send(apids[i], NULL));
        TEST_ASSERT_EQUAL_UINT16(counts[i], last().sequence);
    }
    TEST_ASSERT_EQUAL_UINT32(6U, requester.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(6U, requester.counters.sent);
    for (unsigned i = 3U; i <= PUS_SEQUENCE_COUNT; i++) { // At the end the count starts again at 0.
        TEST_ASSERT_EQUAL(STATUS_OK, send(16U, NULL));
        TEST_ASSERT_EQUAL_UINT16(i % PUS_SEQUENCE_COUNT, last().sequence);
    }
}

static void too_many_addressees_are_refused(void)
{
    for (uint16_t apid = 1U; apid <= (PUS_ADDRESSEES + 1U); apid++) {
        TEST_ASSERT_EQUAL((apid <= PUS_ADDRESSEES) ? STATUS_OK : STATUS_EXHAUSTED, send(apid, NULL));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send(1U, NULL));
}

static void too_much_data_and_a_second_send_are_refused(void)
{
    static uint8_t data[PUS_TC_DATA_MAX + 1U];
    for (size_t size = PUS_TC_DATA_MAX; size <= (PUS_TC_DATA_MAX + 1U); size++) {
        octet_writer_t writer = pus_tc_begin(&requester, 16U, 6U, 2U, 0U);
        octet_write_octets(&writer, data, size);
        TEST_ASSERT_EQUAL((size == PUS_TC_DATA_MAX) ? STATUS_OK : STATUS_TOO_LARGE,
                          pus_tc_send(&requester, &writer, NULL));
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tc_send(&requester, &writer, NULL));
    }
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, sent_size);
    (void)pus_tc_begin(&requester, 16U, 6U, 2U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, send(16U, NULL));
    TEST_ASSERT_EQUAL_UINT32(3U, requester.counters.discarded);
    TEST_ASSERT_EQUAL_UINT32(1U, requester.counters.oversized);
}

static void two_requesters_of_a_user_share_their_sequence_counts(void)
{
    const pus_port_t port        = {.context = &requester, .send = keep};
    static const uint16_t apid   = 16U;
    static pus_requester_t other = {0};
    pus_requester_init(&other, 1U, &port);
    pus_requester_count_with(&other, &requester);
    TEST_ASSERT_EQUAL(STATUS_OK, send(apid, NULL));
    for (unsigned i = 0U; i < 2U; i++) {
        octet_writer_t writer = pus_tc_begin(&other, apid, 17U, 1U, 0U);
        refusals              = 1U - i;
        TEST_ASSERT_EQUAL((i == 0U) ? STATUS_FULL : STATUS_OK, pus_tc_send(&other, &writer, NULL));
    }
    TEST_ASSERT_EQUAL_UINT16(1U, last().sequence);
    TEST_ASSERT_EQUAL_UINT32(1U, other.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(1U, other.counters.sent);
    TEST_ASSERT_EQUAL(STATUS_OK, send(apid, NULL));
    TEST_ASSERT_EQUAL_UINT16(2U, last().sequence);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_is_a_complete_packet_and_its_token_identifies_it);
    RUN_TEST(a_request_that_was_sent_is_neither_extended_nor_sent_again);
    RUN_TEST(each_addressee_has_its_own_count_and_refusal_leaves_no_gap);
    RUN_TEST(too_many_addressees_are_refused);
    RUN_TEST(too_much_data_and_a_second_send_are_refused);
    RUN_TEST(two_requesters_of_a_user_share_their_sequence_counts);
    return UNITY_END();
}
