// SPDX-License-Identifier: Apache-2.0
// Devices of the test: a FIFO, a regular file, and /dev/null.
#define _GNU_SOURCE
#include "osal/include/osal/device.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

static char directory[] = "/tmp/osal-device-XXXXXX";
static char path[64];
static osal_device_t reader;
static osal_device_t writer;
static const osal_device_t closed = OSAL_DEVICE_CLOSED;

static volatile sig_atomic_t signals;

static void count_signal(int number)
{
    (void)number;
    signals = signals + 1;
}

void setUp(void)
{
    reader = closed;
    writer = closed;
    (void)snprintf(path, sizeof path, "%s/device", directory);
}

void tearDown(void)
{
    osal_device_close(&reader);
    osal_device_close(&writer);
    (void)unlink(path);
}

static void open_fifo(void)
{
    TEST_ASSERT_EQUAL(0, mkfifo(path, 0600));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&reader, path, OSAL_DEVICE_READ));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&writer, path, OSAL_DEVICE_WRITE));
}

static void octets_pass_through_a_fifo(void)
{
    uint8_t octets[8];
    size_t size = 9U;
    open_fifo();
    TEST_ASSERT_TRUE(reader.descriptor >= 0);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&reader, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&writer, (const uint8_t*)"abc\0\r\n", 6U, &size));
    TEST_ASSERT_EQUAL_UINT64(6U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, octets, 4U, &size));
    TEST_ASSERT_EQUAL_UINT64(4U, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("abc\0", octets, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\r\n", octets, size);
}

static void a_partner_that_leaves_is_reported_and_may_return(void)
{
    uint8_t octet = 0U;
    size_t size   = 0U;
    open_fifo();
    osal_device_close(&writer);
    errno = EINTR; // An error of an earlier call: a successful call does not clear errno.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_device_read(&reader, &octet, 1U, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&writer, path, OSAL_DEVICE_WRITE));
    errno = EINTR;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&writer, (const uint8_t*)"x", 1U, &size));
    errno = EINTR;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, &octet, 1U, &size));
    TEST_ASSERT_EQUAL_UINT64(1U, size);
    TEST_ASSERT_EQUAL_HEX8('x', octet);
    osal_device_close(&reader);
    void (*const before)(int) = signal(SIGPIPE, count_signal);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_device_write(&writer, (const uint8_t*)"x", 1U, &size));
    (void)signal(SIGPIPE, before);
    TEST_ASSERT_EQUAL(0, signals);
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    osal_device_close(&writer);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_device_open(&writer, path, OSAL_DEVICE_WRITE));
    osal_device_close(&writer);
}

static void a_fifo_whose_partner_does_not_read_is_full(void)
{
    static uint8_t octets[65536];
    size_t size     = 0U;
    status_t status = STATUS_OK;
    open_fifo();
    for (unsigned i = 0U; (i < 100U) && (status == STATUS_OK); i++) {
        status = osal_device_write(&writer, octets, sizeof octets, &size);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&writer, octets, 1U, &size));
}

static void a_file_grows_at_its_end(void)
{
    uint8_t octets[8];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(0, close(open(path, O_CREAT | O_WRONLY, 0600)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&reader, path, OSAL_DEVICE_READ));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&writer, path, OSAL_DEVICE_BOTH));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&reader, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_write(&writer, (const uint8_t*)"one", 3U, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_read(&reader, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_HEX8_ARRAY("one", octets, size);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_device_read(&reader, octets, sizeof octets, &size));
}

static void a_device_that_takes_no_more_is_full(void)
{
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_device_open(&writer, "/dev/full", OSAL_DEVICE_WRITE));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_device_write(&writer, (const uint8_t*)"x", 1U, &size));
}

/// Returns the number of refusals in a child without privilege, and then without a free descriptor.
static int refusals_of_a_stranger(void)
{
    const struct rlimit none = {0U, 0U};
    osal_device_t device;
    if ((setgid(65534) != 0) || (setuid(65534) != 0)) {
        return 1;
    }
    if (osal_device_open(&device, path, OSAL_DEVICE_READ) != STATUS_DENIED) {
        return 2;
    }
    (void)setrlimit(RLIMIT_NOFILE, &none);
    return (osal_device_open(&device, "/dev/null", OSAL_DEVICE_READ) == STATUS_EXHAUSTED) ? 0 : 3;
}

static void opening_is_refused_for_a_reason(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_device_open(&reader, path, OSAL_DEVICE_READ));
    TEST_ASSERT_EQUAL(-1, reader.descriptor);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_device_open(&reader, directory, OSAL_DEVICE_READ));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_device_open(&reader, directory, OSAL_DEVICE_BOTH));
    TEST_ASSERT_EQUAL(0, close(open(path, O_CREAT | O_WRONLY, 0200)));
    if (geteuid() != 0U) {
        TEST_IGNORE_MESSAGE("only a privileged process can test the refusals of another user");
    }
    const pid_t child = fork();
    if (child == 0) {
        _exit(refusals_of_a_stranger());
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static void descriptor_0_is_valid(void)
{
    osal_device_t device;
    const int input = dup(0);
    TEST_ASSERT_TRUE(input >= 0);
    TEST_ASSERT_EQUAL(0, close(0));
    const status_t status = osal_device_open(&device, "/dev/null", OSAL_DEVICE_WRITE);
    const int descriptor  = device.descriptor;
    osal_device_close(&device);
    TEST_ASSERT_EQUAL(0, dup2(input, 0));
    TEST_ASSERT_EQUAL(0, close(input));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(0, descriptor);
}

int main(void)
{
    if (mkdtemp(directory) == NULL) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(octets_pass_through_a_fifo);
    RUN_TEST(a_partner_that_leaves_is_reported_and_may_return);
    RUN_TEST(a_fifo_whose_partner_does_not_read_is_full);
    RUN_TEST(a_file_grows_at_its_end);
    RUN_TEST(a_device_that_takes_no_more_is_full);
    RUN_TEST(opening_is_refused_for_a_reason);
    RUN_TEST(descriptor_0_is_valid);
    const int failures = UNITY_END();
    (void)rmdir(directory);
    return failures;
}
