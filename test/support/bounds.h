// SPDX-License-Identifier: Apache-2.0
/// Expectations of real numbers within bounds, for Unity tests of physics; a failure prints value and bound.
/// NaN fails every comparison.
#ifndef TEST_SUPPORT_BOUNDS_H
#define TEST_SUPPORT_BOUNDS_H

void bounds_below(double bound, double value, unsigned line);
void bounds_above(double bound, double value, unsigned line);
void bounds_within(double expected, double tolerance, double value, unsigned line);

#define EXPECT_BELOW(bound, value) bounds_below((bound), (value), __LINE__)
#define EXPECT_ABOVE(bound, value) bounds_above((bound), (value), __LINE__)
#define EXPECT_WITHIN(expected, tolerance, value) bounds_within((expected), (tolerance), (value), __LINE__)

#endif // TEST_SUPPORT_BOUNDS_H
