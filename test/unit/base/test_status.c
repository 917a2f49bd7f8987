// SPDX-License-Identifier: Apache-2.0
#include "base/status.h"

#include "unity.h"

#include <limits.h>
#include <stdbool.h>
#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void every_status_has_a_text_of_its_own(void)
{
    for (int i = 0; i < (int)STATUS_COUNT; i++) {
        const char* const text = status_text((status_t)i);
        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_TRUE(strlen(text) > 0U);
        TEST_ASSERT_TRUE(strcmp(text, "unknown status") != 0);
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(strcmp(text, status_text((status_t)j)) != 0);
        }
    }
}

static void ok_is_zero_and_called_ok(void)
{
    TEST_ASSERT_EQUAL_INT(0, STATUS_OK);
    TEST_ASSERT_EQUAL_STRING("ok", status_text(STATUS_OK));
    TEST_ASSERT_EQUAL_STRING("not found", status_text(STATUS_NOT_FOUND));
}

/// Write a number as the octets of an unsigned integer of this machine.
static void set_octets(void* const object, const uint64_t number, const size_t size)
{
    const uint16_t probe     = 1U;
    const bool is_big_endian = (*(const uint8_t*)&probe == 0U);
    for (size_t i = 0U; i < size; i++) {
        ((uint8_t*)object)[is_big_endian ? (size - 1U - i) : i] = (uint8_t)(number >> (8U * i));
    }
}

static void numbers_outside_the_range_are_unknown(void)
{
    // Plain numbers, because a damaged memory can contain values that are no status.
    const int outside[] = {(int)STATUS_COUNT, (int)STATUS_COUNT + 1, 31, 255, 65536, INT_MAX};
    for (size_t i = 0U; i < (sizeof outside / sizeof outside[0]); i++) {
        status_t status = STATUS_OK;
        TEST_ASSERT_TRUE(sizeof status <= sizeof outside[i]);
        if (((uint64_t)outside[i] >> (8U * sizeof status)) == 0U) { // A status may be one octet.
            set_octets(&status, (uint64_t)outside[i], sizeof status);
            TEST_ASSERT_EQUAL_STRING("unknown status", status_text(status));
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_status_has_a_text_of_its_own);
    RUN_TEST(ok_is_zero_and_called_ok);
    RUN_TEST(numbers_outside_the_range_are_unknown);
    return UNITY_END();
}
