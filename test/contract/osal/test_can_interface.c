// SPDX-License-Identifier: Apache-2.0
// Interfaces that do not exist, and claims, for each port. test/hil tests virtual interfaces of a kernel.
#include "osal/include/osal/can_interface.h"

#include "unity.h"

static const char* const malformed[] = {"", "a/b", "a b", "sixteen.letters."};

void setUp(void)
{
}

void tearDown(void)
{
}

static void an_interface_that_does_not_exist_is_not_found(void)
{
    osal_can_interface_t about;
    const status_t status = osal_can_interface_look("no-such-can", &about);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
    const status_t removed = osal_can_interface_remove("no-such-can");
    TEST_ASSERT_TRUE((removed == STATUS_NOT_FOUND) || (removed == STATUS_DENIED) ||
                     (removed == STATUS_UNSUPPORTED));
}

static void a_malformed_name_is_refused(void)
{
    osal_can_interface_t about;
    for (size_t i = 0U; i < (sizeof malformed / sizeof malformed[0]); i++) {
        osal_can_claim_t claim = {7777};
        status_t status        = osal_can_interface_look(malformed[i], &about);
        TEST_ASSERT_TRUE((status == STATUS_INVALID) || (status == STATUS_UNSUPPORTED));
        status = osal_can_interface_create(malformed[i], false, "label");
        TEST_ASSERT_TRUE((status == STATUS_INVALID) || (status == STATUS_UNSUPPORTED));
        status = osal_can_interface_claim(malformed[i], &claim);
        TEST_ASSERT_TRUE((status == STATUS_INVALID) || (status == STATUS_UNSUPPORTED));
        TEST_ASSERT_EQUAL(-1, claim.descriptor);
    }
}

/// An interface need not exist to be claimed. A port without interfaces has no claims.
static void a_claim_excludes_others_until_it_is_released(void)
{
    osal_can_claim_t first  = {7777};
    osal_can_claim_t second = {7777};
    const status_t status   = osal_can_interface_claim("contract-can", &first);
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_UNSUPPORTED));
    const status_t again = osal_can_interface_claim("contract-can", &second);
    TEST_ASSERT_EQUAL((status == STATUS_OK) ? STATUS_EXISTS : STATUS_UNSUPPORTED, again);
    TEST_ASSERT_EQUAL(-1, second.descriptor);
    osal_can_interface_release(&second); // No effect.
    osal_can_interface_release(&first);
    TEST_ASSERT_EQUAL(-1, first.descriptor);
    TEST_ASSERT_EQUAL(status, osal_can_interface_claim("contract-can", &second));
    osal_can_interface_release(&second);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_interface_that_does_not_exist_is_not_found);
    RUN_TEST(a_malformed_name_is_refused);
    RUN_TEST(a_claim_excludes_others_until_it_is_released);
    return UNITY_END();
}
