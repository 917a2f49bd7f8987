// SPDX-License-Identifier: Apache-2.0
// Namespaces that do not exist, for each port. posix/test_network.c tests sockets in namespaces.
#include "osal/include/osal/network.h"

#include "unity.h"

#include <stdbool.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static bool is_refusal(const status_t status)
{
    return (status == STATUS_NOT_FOUND) || (status == STATUS_DENIED) || (status == STATUS_UNSUPPORTED);
}

static void a_namespace_that_does_not_exist_is_not_entered(void)
{
    osal_network_t home = {7777};
    TEST_ASSERT_TRUE(is_refusal(osal_network_enter(&home, "no/such/namespace")));
    TEST_ASSERT_EQUAL(-1, home.descriptor); // There is nothing to return to.
}

static void a_namespace_that_does_not_exist_is_not_removed(void)
{
    TEST_ASSERT_TRUE(is_refusal(osal_network_remove("no/such/namespace")));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_namespace_that_does_not_exist_is_not_entered);
    RUN_TEST(a_namespace_that_does_not_exist_is_not_removed);
    return UNITY_END();
}
