// SPDX-License-Identifier: Apache-2.0
// Message queues whose sender has died.
#define _GNU_SOURCE
#include "osal/include/osal/mqueue.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define OCTETS 64U

static char name[64];
static osal_mqueue_t receiver;

void setUp(void)
{
    (void)snprintf(name, sizeof name, "/osal-mq-death.%d", (int)getpid());
    (void)osal_mqueue_remove(name);
    const status_t status = osal_mqueue_create(&receiver, name, 4U, OCTETS);
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this system has no message queues");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
}

void tearDown(void)
{
    osal_mqueue_close(&receiver);
    (void)osal_mqueue_remove(name);
}

static void expect(const char* const words)
{
    uint8_t octets[OCTETS];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(strlen(words), size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(words, octets, size);
}

static void messages_of_a_dead_process_are_received(void)
{
    const pid_t other = fork();
    if (other == 0) {
        osal_mqueue_t theirs;
        if ((osal_mqueue_open(&theirs, name) == STATUS_OK) &&
            (osal_mqueue_send(&theirs, (const uint8_t*)"message", 7U) == STATUS_OK)) {
            (void)raise(SIGKILL);
        }
        _exit(1);
    }
    int exit_status = 0;
    TEST_ASSERT_EQUAL(other, waitpid(other, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
    expect("message");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(messages_of_a_dead_process_are_received);
    return UNITY_END();
}
