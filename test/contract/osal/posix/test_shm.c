// SPDX-License-Identifier: Apache-2.0
// Shared memory between two processes.
#define _GNU_SOURCE
#include "osal/include/osal/shm.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

static char name[64];

void setUp(void)
{
    (void)snprintf(name, sizeof name, "/osal-shm-process.%d", (int)getpid());
    (void)osal_shm_remove(name);
}

void tearDown(void)
{
    (void)osal_shm_remove(name);
}

static void created_memory_is_zero_and_seen_by_another_process(void)
{
    osal_shm_t mine;
    osal_shm_t theirs;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&mine, name, 10000U));
    TEST_ASSERT_EQUAL(10000U, osal_shm_size(&mine));
    uint8_t* const octets = osal_shm_address(&mine);
    for (size_t i = 0U; i < 10000U; i++) {
        TEST_ASSERT_EQUAL_HEX8(0U, octets[i]);
    }
    const pid_t other = fork();
    if (other == 0) {
        if (osal_shm_open(&theirs, name) != STATUS_OK) {
            _exit(1);
        }
        memset(osal_shm_address(&theirs), 0x5A, osal_shm_size(&theirs));
        _exit((osal_shm_size(&theirs) == 10000U) ? 0 : 2);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(other, waitpid(other, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
    TEST_ASSERT_EQUAL_HEX8(0x5AU, octets[0]);
    TEST_ASSERT_EQUAL_HEX8(0x5AU, octets[9999]);
    osal_shm_close(&mine);
    TEST_ASSERT_NULL(osal_shm_address(&mine));
    osal_shm_close(&mine); // A second close has no effect.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(created_memory_is_zero_and_seen_by_another_process);
    return UNITY_END();
}
