// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/shm.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/task.h"
#include "unity.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static char name[64];

void setUp(void)
{
    (void)snprintf(name, sizeof name, "/osal-shm-test.%d", (int)osal_process_own_id());
    (void)osal_shm_remove(name);
    osal_shm_t shm;
    if (osal_shm_create(&shm, name, 1U) == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has no named memory");
    }
    osal_shm_close(&shm);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name));
}

void tearDown(void)
{
    (void)osal_shm_remove(name);
}

static void created_memory_is_zero_and_has_the_size_of_its_creator(void)
{
    osal_shm_t mine;
    osal_shm_t theirs;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&mine, name, 10000U));
    TEST_ASSERT_EQUAL(10000U, osal_shm_size(&mine));
    const uint8_t* const octets = osal_shm_address(&mine);
    for (size_t i = 0U; i < 10000U; i++) {
        TEST_ASSERT_EQUAL_HEX8(0U, octets[i]);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_open(&theirs, name));
    TEST_ASSERT_EQUAL(10000U, osal_shm_size(&theirs));
    memset(osal_shm_address(&theirs), 0x5A, osal_shm_size(&theirs));
    TEST_ASSERT_EQUAL_HEX8(0x5AU, octets[0]);
    TEST_ASSERT_EQUAL_HEX8(0x5AU, octets[9999]);
    osal_shm_close(&theirs);
    osal_shm_close(&mine);
    TEST_ASSERT_NULL(osal_shm_address(&mine));
    osal_shm_close(&mine);
}

static uint32_t is_over;
static unsigned created; ///< Blocks that were created, the one that is being created included.
static unsigned opened;  ///< Blocks that the other task has opened and read; it reads each once.
static unsigned dirty;   ///< Octets that were not zero when another task could open them.

static void pause_us(osal_clock_t* const clock, const uint64_t us)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_clock_wait(clock, osal_clock_now_ns(clock) + (1000U * us), NULL, 0U));
}

/// Tries to open the block again and again, with a higher priority than its creator.
static void open_repeatedly(void* context)
{
    osal_clock_t clock;
    (void)context;
    osal_clock_open_real(&clock, osal_clock_monotonic_ns());
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        osal_shm_t shm;
        if ((opened != __atomic_load_n(&created, __ATOMIC_ACQUIRE)) &&
            (osal_shm_open(&shm, name) == STATUS_OK)) {
            const uint8_t* const octets = osal_shm_address(&shm);
            for (size_t i = 0U; i < osal_shm_size(&shm); i += 64U) {
                dirty += (octets[i] != 0U) ? 1U : 0U;
            }
            dirty += (octets[osal_shm_size(&shm) - 1U] != 0U) ? 1U : 0U;
            osal_shm_close(&shm);
            (void)__atomic_add_fetch(&opened, 1U, __ATOMIC_RELEASE);
        }
        pause_us(&clock, 100U);
    }
}

static void memory_is_zero_as_soon_as_it_can_be_opened(void)
{
    enum {
        OCTETS = 600000
    };
    osal_task_t task;
    osal_clock_t clock;
    osal_clock_open_real(&clock, osal_clock_monotonic_ns());
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, open_repeatedly, NULL, 20));
    for (unsigned i = 0U; i < 4U; i++) {
        osal_shm_t shm;
        __atomic_store_n(&created, i + 1U, __ATOMIC_RELEASE);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, name, OCTETS));
        while (__atomic_load_n(&opened, __ATOMIC_ACQUIRE) != (i + 1U)) { // Until the other task has read it.
            pause_us(&clock, 1000U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name));
        (void)memset(osal_shm_address(&shm), 0xA5, OCTETS);
        osal_shm_close(&shm);
    }
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT(0U, dirty);
}

static void existing_and_missing_names_are_distinguished(void)
{
    osal_shm_t one;
    osal_shm_t two;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_open(&two, name));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_remove(name));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&one, name, 1U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_shm_create(&two, name, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_open(&two, name)); // The smallest shared memory.
    TEST_ASSERT_EQUAL_UINT64(1U, osal_shm_size(&two));
    osal_shm_close(&two);
    TEST_ASSERT_NULL(osal_shm_address(&two));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name));
    ((uint8_t*)osal_shm_address(&one))[0] = 1U; // The mapping is valid after the removal of the name.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&two, name, 1U));
    TEST_ASSERT_EQUAL_HEX8(0U, ((uint8_t*)osal_shm_address(&two))[0]);
    osal_shm_close(&one);
    osal_shm_close(&two);
}

static void names_out_of_the_contract_are_invalid(void)
{
    static const char* const bad[] = {"", "/", "noslash", "/a/b", "/a b", "/a\n", "/.", "/..", "//"};
    char longest[64];
    osal_shm_t shm;
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_shm_create(&shm, bad[i], 1U), bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_shm_open(&shm, bad[i]), bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_shm_remove(bad[i]), bad[i]);
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_shm_create(&shm, name, 0U));
    memset(longest, 'x', sizeof longest);
    longest[0] = '/';
    (void)snprintf(&longest[1], 20U, "%d", (int)osal_process_own_id());
    longest[strlen(longest)] = '_';
    longest[61]              = '\0'; // A slash and 60 characters.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, longest, 1U));
    osal_shm_close(&shm);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(longest));
    longest[61] = 'x';
    longest[62] = '\0';
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_shm_create(&shm, longest, 1U));
}

static void too_large_shared_memory_is_refused_and_leaves_no_name(void)
{
    osal_shm_t shm;
    // The smallest size is 2^56 - 1 octets; on a processor of 32 bits 2^24 - 1 octets.
    for (unsigned shift = 1U; shift <= 8U; shift++) {
        TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, osal_shm_create(&shm, name, SIZE_MAX >> shift));
        TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_open(&shm, name));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, osal_shm_create(&shm, name, SIZE_MAX));
}

static void count_and_remove(void* context, const char* listed)
{
    unsigned* const count = context;
    char prefix[64];
    (void)snprintf(prefix, sizeof prefix, "/each.%ld.", (long)osal_process_own_id());
    TEST_ASSERT_EQUAL_STRING_LEN(prefix, listed, strlen(prefix));
    (*count)++;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(listed));
}

static void names_with_a_prefix_are_listed_and_can_be_removed(void)
{
    char prefix[32];
    unsigned count = 0U;
    (void)snprintf(prefix, sizeof prefix, "/each.%ld.", (long)osal_process_own_id());
    for (unsigned i = 0U; i < 3U; i++) {
        osal_shm_t shm;
        (void)snprintf(name, sizeof name, "%s%u", prefix, i);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, name, 64U));
        osal_shm_close(&shm);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_each(prefix, count_and_remove, &count));
    TEST_ASSERT_EQUAL(3U, count);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_each(prefix, count_and_remove, &count));
    TEST_ASSERT_EQUAL(3U, count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(created_memory_is_zero_and_has_the_size_of_its_creator);
    RUN_TEST(memory_is_zero_as_soon_as_it_can_be_opened);
    RUN_TEST(existing_and_missing_names_are_distinguished);
    RUN_TEST(names_with_a_prefix_are_listed_and_can_be_removed);
    RUN_TEST(names_out_of_the_contract_are_invalid);
    RUN_TEST(too_large_shared_memory_is_refused_and_leaves_no_name);
    return UNITY_END();
}
