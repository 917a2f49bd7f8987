// SPDX-License-Identifier: Apache-2.0
#include "pus/core/stored_request.h"

#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void only_a_request_of_a_ground_user_may_be_stored(void)
{
    // The source, and whether a request of it may be stored.
    static const struct {
        uint16_t source;
        status_t status;
    } cases[] = {{PUS_USER_GROUND, STATUS_OK},
                 {PUS_USER_CLI, STATUS_OK},
                 {PUS_USER_ONBOARD - 1U, STATUS_OK},
                 {PUS_USER_ONBOARD, STATUS_FORBIDDEN},
                 {PUS_USER_SUPERVISOR, STATUS_FORBIDDEN},
                 {UINT16_MAX, STATUS_FORBIDDEN}};
    pus_failure_t failure;
    pus_tc_t tc;
    uint8_t packet[PUS_TC_MIN];
    size_t size = 0U;
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        const bool is_good    = (cases[i].status == STATUS_OK);
        const pus_tc_t stored = {.apid = 16U, .service = 17U, .subtype = 1U, .source = cases[i].source};
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&stored, packet, sizeof packet, &size));
        TEST_ASSERT_EQUAL(cases[i].status, pus_stored_request_decode(packet, size, &tc, &failure));
        TEST_ASSERT_EQUAL_HEX16(is_good ? PUS_FAILURE_NONE : PUS_FAILURE_SOURCE, failure.code);
        TEST_ASSERT_EQUAL_UINT32(is_good ? 0U : cases[i].source, failure.detail);
        packet[size - 1U] ^= 1U;
        TEST_ASSERT_EQUAL(STATUS_CHECKSUM, pus_stored_request_decode(packet, size, &tc, &failure));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_a_request_of_a_ground_user_may_be_stored);
    return UNITY_END();
}
