// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/emergency.h"
#include "fsw/canopen/setting.h"

#include "unity.h"

#include <string.h>

#define TIMEOUT_NS 10000000U

static canopen_sdo_client_t client;
static canopen_setting_run_t run;
static uint64_t now_ns;
static uint8_t request[SDO_FRAME_OCTETS];

void setUp(void)
{
    canopen_sdo_client_init(&client, TIMEOUT_NS);
    now_ns = 0U;
}

void tearDown(void)
{
}

/// One cycle of a node that responds with a value of this many octets. Returns true if there was a request.
static bool answer(const uint32_t value, const uint8_t octets)
{
    now_ns += 500000U;
    if (!canopen_sdo_client_request(&client, now_ns, request) || ((request[0] >> 5) == 4U)) {
        return false;
    }
    const bool is_write = (request[0] >> 5) == 1U;
    uint8_t frame[8]    = {is_write ? 0x60U : (uint8_t)(0x43U | ((4U - octets) << 2)), request[1], request[2],
                        request[3]};
    for (unsigned i = 0U; !is_write && (i < 4U); i++) {
        frame[4U + i] = (uint8_t)(value >> (8U * i));
    }
    canopen_sdo_client_answer(&client, frame, 8U);
    return true;
}

static void an_empty_list_of_settings_succeeds_at_once(void)
{
    canopen_setting_run_begin(&run, NULL, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_setting_run_step(&run, &client));
}

static void the_requests_of_a_list_are_performed_in_order(void)
{
    canopen_setting_t list[] = {
        {.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE, .value = 0x0AU},
        {.index = 0x6076U, .octets = 4U, .kind = SETTING_READ},
        {.index = 0x1A00U, .octets = 1U, .kind = SETTING_VERIFY, .value = 3U},
        {.index = 0x1400U, .subindex = 1U, .octets = 4U, .kind = SETTING_WRITE, .value = 0x80000211U},
    };
    canopen_setting_run_begin(&run, list, 4U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(0U, 0U));
    TEST_ASSERT_EQUAL_HEX8(0x2FU, request[0]);
    TEST_ASSERT_EQUAL_HEX8(0x0AU, request[4]);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(10000U, 4U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(3U, 1U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(0U, 0U));
    TEST_ASSERT_EQUAL_HEX8(0x23U, request[0]);
    TEST_ASSERT_EQUAL_HEX8(0x80U, request[7]);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_EQUAL_UINT64(10000U, list[1].value);
    TEST_ASSERT_FALSE(answer(0U, 0U));
}

static void a_value_other_than_expected_ends_the_list_of_settings(void)
{
    canopen_setting_t list[] = {{.index = 0x1000U, .octets = 4U, .kind = SETTING_VERIFY, .value = 7U},
                                {.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE}};
    canopen_setting_run_begin(&run, list, 2U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(8U, 4U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_EQUAL_UINT64(8U, run.found);
    TEST_ASSERT_EQUAL_UINT16(0U, run.position);
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_FALSE(answer(0U, 0U));
}

static void a_value_of_another_size_ends_the_list_of_settings(void)
{
    canopen_setting_t list[] = {{.index = 0x1000U, .octets = 4U, .kind = SETTING_READ}};
    for (uint8_t octets = 1U; octets < 4U; octets++) {
        canopen_setting_run_begin(&run, list, 1U);
        TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
        TEST_ASSERT_TRUE(answer(8U, octets));
        TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_setting_run_step(&run, &client));
    }
    // Two octets where one is expected are refused; four may be a response without a size.
    list[0].octets = 1U;
    canopen_setting_run_begin(&run, list, 1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(8U, 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, canopen_setting_run_step(&run, &client));
    canopen_setting_run_begin(&run, list, 1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(0xAAAAAA08U, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_EQUAL_UINT64(8U, list[0].value);
}

static void an_abort_contains_its_code_and_its_object(void)
{
    canopen_setting_t list[] = {{.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE},
                                {.index = 0x6061U, .octets = 1U, .kind = SETTING_WRITE}};
    canopen_setting_run_begin(&run, list, 2U);
    (void)canopen_setting_run_step(&run, &client);
    TEST_ASSERT_TRUE(answer(0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(canopen_sdo_client_request(&client, now_ns, request));
    const uint8_t frame[8] = {0x80U, 0x61U, 0x60U, 0U, 0x02U, 0x00U, 0x01U, 0x06U};
    canopen_sdo_client_answer(&client, frame, 8U);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_EQUAL_HEX32(0x06010002U, run.abort_code);
    TEST_ASSERT_EQUAL_UINT16(1U, run.position);
}

static void silence_and_reset_end_in_a_timeout(void)
{
    canopen_setting_t list[] = {{.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE}};
    canopen_setting_run_begin(&run, list, 1U);
    (void)canopen_setting_run_step(&run, &client);
    TEST_ASSERT_TRUE(canopen_sdo_client_request(&client, now_ns, request));
    // The client sends an abort.
    TEST_ASSERT_TRUE(canopen_sdo_client_request(&client, now_ns + TIMEOUT_NS, request));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, canopen_setting_run_step(&run, &client));

    canopen_setting_run_begin(&run, list, 1U);
    (void)canopen_setting_run_step(&run, &client);
    canopen_sdo_client_reset(&client); // The node has booted again.
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, canopen_setting_run_step(&run, &client));
}

static void a_transfer_waits_for_the_end_of_another_transfer(void)
{
    canopen_setting_t list[] = {{.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE}};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(&client, 0x1018U, 1U));
    canopen_setting_run_begin(&run, list, 1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(1U, 4U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_setting_run_step(&run, &client));
    TEST_ASSERT_TRUE(answer(0U, 0U));
    TEST_ASSERT_EQUAL_HEX8(0x2FU, request[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_setting_run_step(&run, &client));
}

static void emergencies_are_decoded_and_have_a_class(void)
{
    const uint8_t octets[8]             = {0x11U, 0x83U, 0x05U, 0x01U, 0xFEU, 0xFFU, 0xFFU, 0xFFU};
    const canopen_emergency_t emergency = canopen_emergency_decode(0x12U, octets);
    TEST_ASSERT_EQUAL_HEX8(0x12U, emergency.node);
    TEST_ASSERT_EQUAL_HEX16(0x8311U, emergency.code);
    TEST_ASSERT_EQUAL_HEX8(0x05U, emergency.error_register);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(&octets[3], emergency.manufacturer, EMERGENCY_MANUFACTURER_OCTETS);
    const uint16_t high[]   = {0x8130U, 0x8250U, 0x8140U, 0x7305U, 0x3220U, 0x2310U};
    const uint16_t medium[] = {0x8311U, 0x8611U, 0x4210U, 0x4310U, 0x1000U, 0xFF01U};
    const uint16_t low[]    = {0x8120U, 0x8110U, 0x8240U};
    for (unsigned i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL(EMERGENCY_HIGH, canopen_emergency_severity(NULL, 0U, high[i]));
    }
    for (unsigned i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL(EMERGENCY_MEDIUM, canopen_emergency_severity(NULL, 0U, medium[i]));
    }
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(EMERGENCY_LOW, canopen_emergency_severity(NULL, 0U, low[i]));
    }
    TEST_ASSERT_EQUAL(EMERGENCY_CLEARED, canopen_emergency_severity(NULL, 0U, 0x0000U));
}

static void a_device_class_defines_the_class_of_its_manufacturer_codes(void)
{
    const canopen_emergency_code_t codes[] = {{0xFF01U, EMERGENCY_HIGH}, {0x8611U, EMERGENCY_LOW}};
    TEST_ASSERT_EQUAL(EMERGENCY_HIGH, canopen_emergency_severity(codes, 2U, 0xFF01U));
    TEST_ASSERT_EQUAL(EMERGENCY_LOW, canopen_emergency_severity(codes, 2U, 0x8611U));
    TEST_ASSERT_EQUAL(EMERGENCY_HIGH, canopen_emergency_severity(codes, 2U, 0x2310U));
    TEST_ASSERT_EQUAL(EMERGENCY_MEDIUM, canopen_emergency_severity(codes, 2U, 0xFF02U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_empty_list_of_settings_succeeds_at_once);
    RUN_TEST(the_requests_of_a_list_are_performed_in_order);
    RUN_TEST(a_value_other_than_expected_ends_the_list_of_settings);
    RUN_TEST(a_value_of_another_size_ends_the_list_of_settings);
    RUN_TEST(an_abort_contains_its_code_and_its_object);
    RUN_TEST(silence_and_reset_end_in_a_timeout);
    RUN_TEST(a_transfer_waits_for_the_end_of_another_transfer);
    RUN_TEST(emergencies_are_decoded_and_have_a_class);
    RUN_TEST(a_device_class_defines_the_class_of_its_manufacturer_codes);
    return UNITY_END();
}
