// SPDX-License-Identifier: Apache-2.0
// CAN in shared memory between two processes, and SocketCAN on a kernel without it.
#define _GNU_SOURCE
#include "osal/include/osal/can.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

static char address[64];
static osal_can_t node;
static osal_can_t wire;

void setUp(void)
{
    (void)snprintf(address, sizeof address, "shm:osal-can-processes-%d", (int)getpid());
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, address, OSAL_CAN_WIRE));
}

void tearDown(void)
{
    osal_can_close(&node);
    osal_can_close(&wire);
    (void)osal_can_destroy(address);
}

/// A second process sends as fast as the ring accepts frames: no frame is lost, torn or out of order.
static void two_processes_exchange_every_frame_in_order(void)
{
    const uint32_t count = 200000U;
    const pid_t sender   = fork();
    if (sender == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (uint32_t i = 0U; i < count; i++) {
            osal_can_frame_t frame = {.id = i & 0x7FFU, .length = 64U, .flags = OSAL_CAN_FLAG_FD};
            memset(frame.data, (int)(i & 0xFFU), sizeof frame.data);
            memcpy(frame.data, &i, sizeof i);
            while (osal_can_send(&node, &frame) == STATUS_FULL) {
                (void)usleep(50U);
            }
        }
        _exit(0);
    }
    for (uint32_t i = 0U; i < count; i++) {
        osal_can_frame_t out;
        uint32_t number = 0U;
        while (osal_can_receive(&wire, &out) == STATUS_EMPTY) {
            (void)usleep(20U);
        }
        memcpy(&number, out.data, sizeof number);
        TEST_ASSERT_EQUAL_UINT32(i, number);
        TEST_ASSERT_EQUAL_HEX8(i & 0xFFU, out.data[63]);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(sender, waitpid(sender, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static bool has_kernel_can(void)
{
    const int descriptor = socket(PF_CAN, SOCK_RAW, 1);
    if (descriptor >= 0) {
        (void)close(descriptor);
    }
    return descriptor >= 0;
}

static void a_kernel_without_socketcan_is_reported(void)
{
    osal_can_t kernel;
    osal_can_frame_t out;
    const status_t expected = has_kernel_can() ? STATUS_NOT_FOUND : STATUS_UNSUPPORTED;
    TEST_ASSERT_EQUAL(expected, osal_can_open(&kernel, "can:none0", OSAL_CAN_WIRE));
    TEST_ASSERT_EQUAL(expected, osal_can_create("can:none0@none"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_open(&kernel, "can:none0@osal-can-none", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&kernel, "can:@none", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&kernel, "can:none0@", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&kernel, "can:", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&kernel, "can:a-name-too-long-for-one", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(expected, osal_can_open(&kernel, "can:none0", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_receive(&kernel, &out));
    osal_can_close(&kernel);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(two_processes_exchange_every_frame_in_order);
    RUN_TEST(a_kernel_without_socketcan_is_reported);
    return UNITY_END();
}
