// SPDX-License-Identifier: Apache-2.0
#include "pus/core/traffic_class.h"

#include "base/octets.h"
#include "unity.h"

#include <string.h>

static uint8_t packet[64];

void setUp(void)
{
    memset(packet, 0, sizeof(packet));
}

void tearDown(void)
{
}

static pus_class_t of_report(const uint8_t service, const uint8_t subtype)
{
    octets_put_u16(packet, 0x0810U);
    packet[7] = service;
    packet[8] = subtype;
    return pus_class_of(packet, sizeof(packet));
}

static pus_class_t of_request(const uint8_t service, const uint16_t source)
{
    octets_put_u16(packet, 0x1810U);
    packet[7] = service;
    packet[8] = 1U;
    octets_put_u16(&packet[9], source);
    return pus_class_of(packet, sizeof(packet));
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

static void a_notice_that_is_cut_is_not_firm(void)
{
    packet[23] = 4U;
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, of_report(129U, 7U));
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, pus_class_of(packet, 24U));
    TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, pus_class_of(packet, 23U));
}

static void reports_that_can_be_requested_again_are_bulk(void)
{
    static const uint8_t bulk[][2]  = {{3, 25}, {3, 26}, {6, 4},   {6, 6},   {11, 10}, {11, 13},
                                       {13, 1}, {13, 3}, {19, 11}, {22, 13}, {23, 13}, {4, 2}};
    static const uint8_t plain[][2] = {{5, 8},   {17, 2},  {20, 2},  {129, 5},
                                       {130, 4}, {130, 9}, {131, 4}, {3, 24}};
    for (unsigned i = 0U; i < (sizeof(bulk) / sizeof(bulk[0])); i++) {
        TEST_ASSERT_EQUAL(PUS_CLASS_BULK, of_report(bulk[i][0], bulk[i][1]));
    }
    for (unsigned i = 0U; i < (sizeof(plain) / sizeof(plain[0])); i++) {
        TEST_ASSERT_EQUAL(PUS_CLASS_PLAIN, of_report(plain[i][0], plain[i][1]));
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
    RUN_TEST(a_notice_that_is_cut_is_not_firm);
    RUN_TEST(reports_that_can_be_requested_again_are_bulk);
    RUN_TEST(orders_of_the_supervisor_are_firm);
    RUN_TEST(packets_that_are_too_short_are_bulk);
    return UNITY_END();
}
