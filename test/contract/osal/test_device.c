// SPDX-License-Identifier: Apache-2.0
// Devices that do not exist, and pipes, for each port. posix/test_device.c tests FIFOs and files.
#include "osal/include/osal/device.h"

#include "test/support/assertion.h"
#include "unity.h"

static osal_device_t reader = OSAL_DEVICE_CLOSED;
static osal_device_t writer = OSAL_DEVICE_CLOSED;

void setUp(void)
{
}

void tearDown(void)
{
    osal_device_close(&reader);
    osal_device_close(&writer);
}

static void a_device_that_does_not_exist_is_refused_in_each_direction(void)
{
    for (int direction = OSAL_DEVICE_READ; direction <= OSAL_DEVICE_BOTH; direction++) {
        reader.descriptor = 7777;
        const status_t status =
            osal_device_open(&reader, "no/such/device", (osal_device_direction_t)direction);
        TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
        TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&reader));
    }
}

static void a_closed_device_has_no_descriptor(void)
{
    TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&reader));
    osal_device_close(&reader); // No effect.
    TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&reader));
}

static void a_closed_device_carries_nothing(void)
{
    uint8_t octet   = 1U;
    size_t count    = 7U;
    status_t status = osal_device_write(&writer, &octet, 1U, &count);
    TEST_ASSERT_TRUE((status == STATUS_IO) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL_UINT64(0U, count);
    count  = 7U;
    status = osal_device_read(&reader, &octet, 1U, &count);
    TEST_ASSERT_TRUE((status == STATUS_IO) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL_UINT64(0U, count);
    TEST_ASSERT_EQUAL_HEX8(1U, octet);
}

/// A port without devices has no pipe either, and does not wait for one.
static void a_pipe_carries_octets_from_its_writer_to_its_reader(void)
{
    uint8_t octets[8];
    size_t count          = 0U;
    const status_t status = osal_device_pipe(&reader, &writer);
    if (status == STATUS_UNSUPPORTED) {
        TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&reader));
        TEST_ASSERT_EQUAL(-1, osal_device_descriptor(&writer));
        TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_device_wait_readable(&reader, 60000U));
        TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_device_open(&reader, "no/such/device", OSAL_DEVICE_READ));
        return;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&reader, octets, sizeof octets, &count));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_device_wait_readable(&reader, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&writer, (const uint8_t*)"a\0c", 3U, &count));
    TEST_ASSERT_EQUAL_UINT64(3U, count);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_wait_readable(&reader, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, octets, sizeof octets, &count));
    TEST_ASSERT_EQUAL_UINT64(3U, count);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("a\0c", octets, 3U);
    osal_device_close(&writer);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_device_read(&reader, octets, sizeof octets, &count));
}

static void open_without_a_path(void)
{
    const status_t status = osal_device_open(&reader, NULL, OSAL_DEVICE_READ);
    TEST_ASSERT_EQUAL(STATUS_INVALID, status); // Is not reached.
}

static void close_nothing(void)
{
    osal_device_close(NULL);
}

static void a_null_argument_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(open_without_a_path));
    TEST_ASSERT_TRUE(assertion_fails(close_nothing));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_device_that_does_not_exist_is_refused_in_each_direction);
    RUN_TEST(a_closed_device_has_no_descriptor);
    RUN_TEST(a_closed_device_carries_nothing);
    RUN_TEST(a_pipe_carries_octets_from_its_writer_to_its_reader);
    RUN_TEST(a_null_argument_is_a_coding_error);
    return UNITY_END();
}
