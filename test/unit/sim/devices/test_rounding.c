// SPDX-License-Identifier: Apache-2.0
// Rounding of physical values, against the function of the C library.
#include "sim/devices/rounding.h"
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void check(const double value)
{
    TEST_ASSERT_EQUAL_INT64(llround(value), rounded(value));
    TEST_ASSERT_EQUAL_INT64(llround(-value), rounded(-value));
}

static void halves_are_rounded_away_from_zero_and_their_neighbours_to_the_nearest(void)
{
    for (unsigned power = 0U; power < 62U; power++) {
        const double large = (double)(1ULL << power);
        for (int halves = -3; halves <= 3; halves++) {
            const double value = large + 0.5 * halves;
            check(value);
            check(nextafter(value, 0.0));
            check(nextafter(value, 1e300));
        }
    }
    check(0.0);
    check(nextafter(0.0, 1.0));
    check(nextafter(0.5, 0.0)); // The sum of this number and 0.5 is 1.
}

static void numbers_of_all_sizes_are_rounded_as_in_the_c_library(void)
{
    uint64_t state = 42U;
    for (unsigned i = 0U; i < 100000U; i++) {
        state = (state * 6364136223846793005U) + 1442695040888963407U;
        check(ldexp((double)(state >> 11), -(int)(state % 110U)));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(halves_are_rounded_away_from_zero_and_their_neighbours_to_the_nearest);
    RUN_TEST(numbers_of_all_sizes_are_rounded_as_in_the_c_library);
    return UNITY_END();
}
