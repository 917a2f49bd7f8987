// SPDX-License-Identifier: Apache-2.0
// Serial lines that cannot be opened, for each port of the OSAL to an operating system. posix/test_serial.c
// tests lines with two ends.
#include "osal/include/osal/serial.h"

#include "unity.h"

static osal_device_t line;

void setUp(void)
{
    line = (osal_device_t){.descriptor = 7777};
}

void tearDown(void)
{
}

static void a_line_that_does_not_exist_is_refused_at_each_bit_rate(void)
{
    static const uint32_t bauds[] = OSAL_SERIAL_BAUDS;
    for (size_t i = 0U; i < (sizeof bauds / sizeof bauds[0]); i++) {
        const status_t status = osal_serial_open(&line, "no/such/line", bauds[i]);
        TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
        TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&line));
    }
}

static void a_bit_rate_that_no_line_has_is_refused(void)
{
    const status_t status = osal_serial_open(&line, "no/such/line", 12345U);
    TEST_ASSERT_TRUE((status == STATUS_OUT_OF_RANGE) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&line));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_line_that_does_not_exist_is_refused_at_each_bit_rate);
    RUN_TEST(a_bit_rate_that_no_line_has_is_refused);
    return UNITY_END();
}
