// SPDX-License-Identifier: Apache-2.0
// Sequence counts and message type counters that continue in the next life of a process.
#include "pus/core/counts.h"

#include "base/octets.h"
#include "unity.h"

#include <string.h>

static pus_app_process_t process;
static pus_requester_t requester;
static pus_counts_t counts;
static uint8_t last[PUS_PACKET_MAX];

void setUp(void)
{
}

void tearDown(void)
{
}

static status_t take(void* context, const uint8_t* packet, size_t size)
{
    (void)context;
    (void)memcpy(last, packet, size);
    return STATUS_OK;
}

static void begin(void)
{
    const pus_port_t port = {NULL, take};
    pus_app_process_init(&process, 1U, 0U, &port);
    pus_requester_init(&requester, 1U, &port);
}

/// Send a report. Returns its sequence count (bits 16 to 29) and its message type counter (bits 0 to 15).
static uint32_t report(uint8_t subtype)
{
    octet_writer_t writer = pus_tm_begin(&process, 17U, subtype, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&process, &writer));
    return ((uint32_t)(octets_u16_at(&last[2]) & 0x3FFFU) << 16U) | octets_u16_at(&last[9]);
}

static unsigned request(uint16_t apid)
{
    octet_writer_t writer = pus_tc_begin(&requester, apid, 17U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_send(&requester, &writer, NULL));
    return octets_u16_at(&last[2]) & 0x3FFFU;
}

static void numbers_continue_where_they_ended(void)
{
    begin();
    (void)report(2U);
    (void)report(2U);
    (void)report(4U);
    (void)request(16U);
    (void)request(17U);
    (void)request(17U);
    pus_counts(&process, &requester, &counts);
    TEST_ASSERT_TRUE(pus_counts_are_sound(&counts));
    begin();
    TEST_ASSERT_EQUAL_HEX32(0U, report(2U)); // Without pus_counts_resume, counts begin with 0.
    begin();
    pus_counts_resume(&process, &requester, &counts);
    TEST_ASSERT_EQUAL_HEX32((3UL << 16U) | 2U, report(2U));
    TEST_ASSERT_EQUAL_HEX32((4UL << 16U) | 1U, report(4U));
    TEST_ASSERT_EQUAL_HEX32((5UL << 16U) | 0U, report(6U));
    TEST_ASSERT_EQUAL(2U, request(17U)); // In another order than before.
    TEST_ASSERT_EQUAL(1U, request(16U));
    TEST_ASSERT_EQUAL(0U, request(18U));
}

static void all_counts_are_resumed_from_full_tables(void)
{
    begin();
    for (unsigned i = 0U; i < PUS_MESSAGE_COUNTERS; i++) {
        (void)report((uint8_t)i);
    }
    for (unsigned i = 0U; i < PUS_ADDRESSEES; i++) {
        (void)request((uint16_t)(100U + i));
    }
    pus_counts(&process, &requester, &counts);
    begin();
    pus_counts_resume(&process, &requester, &counts);
    TEST_ASSERT_EQUAL_HEX32((128UL << 16U) | 1U, report(127U));
    TEST_ASSERT_EQUAL(1U, request((uint16_t)(100U + PUS_ADDRESSEES - 1U)));
}

static void counts_out_of_range_are_not_sound(void)
{
    (void)memset(&counts, 0, sizeof counts);
    TEST_ASSERT_TRUE(pus_counts_are_sound(&counts));
    counts.sequence = 16384U;
    TEST_ASSERT_FALSE(pus_counts_are_sound(&counts));
    counts.sequence          = 0U;
    counts.requests[63].apid = 2047U;
    TEST_ASSERT_FALSE(pus_counts_are_sound(&counts));
    counts.requests[63].apid     = 1U;
    counts.requests[63].sequence = 16384U;
    TEST_ASSERT_FALSE(pus_counts_are_sound(&counts));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(numbers_continue_where_they_ended);
    RUN_TEST(all_counts_are_resumed_from_full_tables);
    RUN_TEST(counts_out_of_range_are_not_sound);
    return UNITY_END();
}
