// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/orbit.h"

#include "unity.h"

#define S 1000000000ULL
#define ORBIT 65536ULL

void setUp(void)
{
}

void tearDown(void)
{
}

static void the_first_node_is_at_time_0_whenever_the_period_is_set(void)
{
    orbit_t orbit = {0};
    TEST_ASSERT_EQUAL_UINT64(0U, supervisor_orbit_position(&orbit, 3U * S, 0U));
    TEST_ASSERT_EQUAL_UINT64(ORBIT / 4U, supervisor_orbit_position(&orbit, 25U * S, 100000U));
    TEST_ASSERT_EQUAL_UINT64((2U * ORBIT) + (ORBIT / 2U),
                             supervisor_orbit_position(&orbit, 250U * S, 100000U));
}

static void a_change_of_the_period_keeps_the_present_position(void)
{
    static const uint32_t periods_ms[] = {100000U, 1U, 4294967295U, 0U, 5000U, 0U, 100000U};
    orbit_t orbit                      = {0};
    uint64_t before                    = supervisor_orbit_position(&orbit, 150U * S, 100000U);
    TEST_ASSERT_EQUAL_UINT64(ORBIT + (ORBIT / 2U), before);
    for (unsigned i = 0U; i < 7U; i++) {
        const uint64_t now_ns = (150U + (10U * i)) * S;
        const uint64_t last =
            supervisor_orbit_position(&orbit, now_ns, (i == 0U) ? 100000U : periods_ms[i - 1U]);
        TEST_ASSERT_TRUE(last >= before);
        before = supervisor_orbit_position(&orbit, now_ns, periods_ms[i]);
        TEST_ASSERT_EQUAL_UINT64(last, before);
    }
    TEST_ASSERT_EQUAL_UINT64(before + (ORBIT / 10U), supervisor_orbit_position(&orbit, 220U * S, 100000U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_first_node_is_at_time_0_whenever_the_period_is_set);
    RUN_TEST(a_change_of_the_period_keeps_the_present_position);
    return UNITY_END();
}
