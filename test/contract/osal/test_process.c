// SPDX-License-Identifier: Apache-2.0
// Processes that do not exist, and what each program has, for each port. posix/test_process.c tests children.
#include "osal/include/osal/process.h"

#include "unity.h"

static osal_process_t process;

void setUp(void)
{
    process = (osal_process_t){.id = 5, .descriptor = 7777}; // Start and watch set both.
}

void tearDown(void)
{
}

static void a_program_that_does_not_exist_is_not_started(void)
{
    static const char* const arguments[] = {"no/such/program", NULL};
    const osal_process_start_t start     = {.arguments = arguments, .processor = -1};
    const status_t status                = osal_process_start(&process, &start);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(-1, process.descriptor);
    TEST_ASSERT_FALSE(osal_process_is_alive(&process));
}

static void a_program_that_does_not_exist_has_no_size(void)
{
    uint64_t octets       = 7U;
    const status_t status = osal_process_loaded_size("no/such/program", &octets);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
}

static void a_process_that_does_not_exist_is_not_watched(void)
{
    const status_t status = osal_process_watch(&process, 0);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(-1, process.descriptor);
    TEST_ASSERT_FALSE(osal_process_is_alive(&process));
}

static void a_program_has_an_id_that_does_not_change(void)
{
    TEST_ASSERT_TRUE(osal_process_own_id() > 0);
    TEST_ASSERT_EQUAL(osal_process_own_id(), osal_process_own_id());
}

static void a_variable_that_nobody_has_set_is_null(void)
{
    TEST_ASSERT_NULL(osal_process_environment("OSAL_CONTRACT_NOBODY_HAS_SET_THIS"));
}

static void without_a_stop_signal_none_is_counted(void)
{
    TEST_ASSERT_EQUAL_UINT(0U, osal_process_stop_count());
    TEST_ASSERT_EQUAL(-1, osal_process_stop_descriptor()); // This program catches no stop signals.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_program_that_does_not_exist_is_not_started);
    RUN_TEST(a_program_that_does_not_exist_has_no_size);
    RUN_TEST(a_process_that_does_not_exist_is_not_watched);
    RUN_TEST(a_program_has_an_id_that_does_not_change);
    RUN_TEST(a_variable_that_nobody_has_set_is_null);
    RUN_TEST(without_a_stop_signal_none_is_counted);
    return UNITY_END();
}
