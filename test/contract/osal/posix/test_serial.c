// SPDX-License-Identifier: Apache-2.0
// The line is a pseudo-terminal, whose other end represents the instrument.
#define _GNU_SOURCE
#include "osal/include/osal/serial.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#include "unity.h"

static int far;
static char path[64];
static osal_device_t line;

static void begin_far_end(void)
{
    far = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(far >= 0);
    TEST_ASSERT_EQUAL(0, grantpt(far));
    TEST_ASSERT_EQUAL(0, unlockpt(far));
    TEST_ASSERT_EQUAL(0, ptsname_r(far, path, sizeof path));
}

void setUp(void)
{
    line = (osal_device_t)OSAL_DEVICE_CLOSED;
    begin_far_end();
}

void tearDown(void)
{
    osal_device_close(&line);
    (void)close(far);
}

/// Read `size` octets from the line, in as many pieces as they arrive.
static void expect(const uint8_t* const octets, const size_t size)
{
    uint8_t seen[1024];
    size_t held = 0U;
    while (held < size) {
        size_t taken          = 0U;
        struct pollfd watched = {.fd = line.descriptor, .events = POLLIN};
        TEST_ASSERT_EQUAL(1, poll(&watched, 1U, 20000));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&line, &seen[held], sizeof seen - held, &taken));
        held += taken;
    }
    TEST_ASSERT_EQUAL_UINT64(size, held);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, seen, size);
}

static void every_octet_passes_unchanged_both_ways(void)
{
    uint8_t all[256];
    uint8_t seen[256];
    size_t held = 0U;
    for (unsigned i = 0U; i < 256U; i++) {
        all[i] = (uint8_t)i;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 115200U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&line, seen, sizeof seen, &held));
    TEST_ASSERT_EQUAL(256, write(far, all, sizeof all));
    expect(all, sizeof all);
    size_t sent = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&line, all, sizeof all, &sent));
    TEST_ASSERT_EQUAL_UINT64(sizeof all, sent);
    for (held = 0U; held < sizeof all;) {
        const ssize_t size = read(far, &seen[held], sizeof seen - held);
        TEST_ASSERT_TRUE(size > 0);
        held += (size_t)size;
    }
    TEST_ASSERT_EQUAL_HEX8_ARRAY(all, seen, sizeof all);
    // The line does not echo.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&line, seen, sizeof seen, &held));
}

static void only_the_bit_rates_of_the_contract_are_accepted(void)
{
    static const uint32_t bauds[] = OSAL_SERIAL_BAUDS;
    for (size_t i = 0U; i < (sizeof bauds / sizeof bauds[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, bauds[i]));
        osal_device_close(&line);
    }
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, osal_serial_open(&line, path, 12345U));
    TEST_ASSERT_EQUAL(-1, line.descriptor);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, osal_serial_open(&line, path, 0U));
}

static void octets_received_before_opening_are_discarded(void)
{
    uint8_t octet = 0U;
    size_t size   = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 9600U));
    osal_device_t keeper = line; // A second handle keeps the line open.
    TEST_ASSERT_EQUAL(3, write(far, "old", 3U));
    line = (osal_device_t)OSAL_DEVICE_CLOSED;
    // Without privilege the call is refused, because the line is in use.
    if (osal_serial_open(&line, path, 9600U) == STATUS_OK) {
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&line, &octet, 1U, &size));
        TEST_ASSERT_EQUAL(3, write(far, "new", 3U));
        expect((const uint8_t*)"new", 3U);
    }
    osal_device_close(&keeper);
}

static void a_line_that_hangs_up_is_closed_and_opened_again(void)
{
    uint8_t octet = 0U;
    size_t size   = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 9600U));
    (void)close(far);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_device_read(&line, &octet, 1U, &size));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_device_write(&line, &octet, 1U, &size));
    osal_device_close(&line);
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 9600U));
    begin_far_end();
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 9600U));
    TEST_ASSERT_EQUAL(1, write(far, "x", 1U));
    expect((const uint8_t*)"x", 1U);
}

static void a_line_whose_peer_does_not_read_is_full(void)
{
    static uint8_t octets[65536];
    size_t size     = 0U;
    status_t status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_serial_open(&line, path, 9600U));
    for (unsigned i = 0U; (i < 100U) && (status == STATUS_OK); i++) {
        status = osal_device_write(&line, octets, sizeof octets, &size);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
}

static void a_path_that_is_no_serial_line_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_serial_open(&line, "/dev/null", 9600U));
    TEST_ASSERT_EQUAL(-1, line.descriptor);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_serial_open(&line, "/tmp", 9600U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_serial_open(&line, "/dev/no-such-line", 9600U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_octet_passes_unchanged_both_ways);
    RUN_TEST(only_the_bit_rates_of_the_contract_are_accepted);
    RUN_TEST(octets_received_before_opening_are_discarded);
    RUN_TEST(a_line_that_hangs_up_is_closed_and_opened_again);
    RUN_TEST(a_line_whose_peer_does_not_read_is_full);
    RUN_TEST(a_path_that_is_no_serial_line_is_refused);
    return UNITY_END();
}
