// SPDX-License-Identifier: Apache-2.0
// The traffic class (firm, plain or bulk) of each kind of packet.
#include "pus/core/traffic_class.h"

#include "base/octets.h"
#include "unity.h"

#include <string.h>

static uint8_t packet[64];

void setUp(void)
{
    memset(packet, 0, sizeof packet);
}

void tearDown(void)
{
}

static pus_class_t of_report(const uint8_t service, const uint8_t subtype)
{
    octets_put_u16(packet, 0x0810U);
    packet[7] = service;
    packet[8] = subtype;
    return pus_class_of(packet, sizeof packet);
}

static pus_class_t of_request(const uint8_t service, const uint16_t source)
{
    octets_put_u16(packet, 0x1810U);
    packet[7] = service;
    packet[8] = 1U;
    octets_put_u16(&packet[9], source);
    return pus_class_of(packet, sizeof packet);
}

static void reports_that_need_a_reaction_are_firm(void)
{
    for (uint8_t subtype = 1U; subtype <= 10U; subtype++) {
        TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(1U, subtype));
    }
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(129U, 2U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(130U, 10U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(131U, 2U));
    for (uint8_t severity = 1U; severity <= 5U; severity++) {
        const pus_class_t expected = (severity == 4U) ? PUS_CLASS_FIRM : PUS_CLASS_PLAIN;
        TEST_ASSERT_EQUAL(expected, of_report(5U, severity));
        packet[23] = severity;
        TEST_ASSERT_EQUAL(expected, of_report(129U, 7U));
    }
}

static void a_truncated_notice_is_not_firm(void)
{
    packet[23] = 4U;
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(129U, 7U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, pus_class_of(packet, 24U));
    TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, pus_class_of(packet, 23U));
}

/// True for housekeeping, diagnostics, statistics, lists over many packets, dumps, and parts of long reports.
static bool is_bulk(const uint8_t service, const uint8_t subtype)
{
    static const struct {
        uint8_t service;
        uint8_t subtypes[8]; // Ended by 0.
    } bulk[] = {{2U, {6U, 9U, 12U}},
                {3U, {10U, 12U, 25U, 26U, 41U}},
                {4U, {2U, 9U}},
                {6U, {4U, 6U}},
                {11U, {10U, 13U}},
                {12U, {9U, 11U, 12U, 14U, 26U, 28U}},
                {13U, {1U, 2U, 3U}},
                {14U, {4U, 8U, 12U, 16U}},
                {15U, {6U, 36U, 38U, 40U}},
                {18U, {9U}},
                {19U, {7U, 11U}},
                {21U, {12U}},
                {22U, {10U, 13U}},
                {23U, {8U, 13U}}};
    for (size_t i = 0U; i < (sizeof bulk / sizeof bulk[0]); i++) {
        for (size_t k = 0U; (bulk[i].service == service) && (bulk[i].subtypes[k] != 0U); k++) {
            if (bulk[i].subtypes[k] == subtype) {
                return true;
            }
        }
    }
    return false;
}

static void each_type_of_report_has_one_class(void)
{
    for (unsigned type = 0U; type < 65536U; type++) {
        const uint8_t service = (uint8_t)(type >> 8U);
        const uint8_t subtype = (uint8_t)(type & 0xFFU);
        const bool is_firm = (service == 1U) || (type == 0x0504U) || (type == 0x8102U) || (type == 0x820AU) ||
                             (type == 0x8302U);
        const pus_class_t other = is_bulk(service, subtype) ? PUS_CLASS_BULK : PUS_CLASS_PLAIN;
        if (of_report(service, subtype) != (is_firm ? PUS_CLASS_FIRM : other)) {
            TEST_ASSERT_EQUAL_HEX16(0U, type); // Shows the type if the assertion fails.
        }
    }
}

static void orders_of_the_supervisor_are_firm(void)
{
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_request(129U, 0x8001U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_request(130U, 0x8001U));
    TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, of_request(8U, 0x8001U));
    TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, of_request(129U, 1U));
    TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, of_request(129U, 0x8010U));
}

static void packets_that_are_too_short_are_bulk(void)
{
    TEST_ASSERT_EQUAL(PUS_CLASS_BULK, pus_class_of(NULL, 0U));
    (void)of_report(1U, 1U);
    TEST_ASSERT_EQUAL(PUS_CLASS_BULK, pus_class_of(packet, 20U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, pus_class_of(packet, 21U));
    (void)of_request(129U, 0x8001U);
    TEST_ASSERT_EQUAL(PUS_CLASS_BULK, pus_class_of(packet, 10U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, pus_class_of(packet, 11U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reports_that_need_a_reaction_are_firm);
    RUN_TEST(a_truncated_notice_is_not_firm);
    RUN_TEST(each_type_of_report_has_one_class);
    RUN_TEST(orders_of_the_supervisor_are_firm);
    RUN_TEST(packets_that_are_too_short_are_bulk);
    return UNITY_END();
}
