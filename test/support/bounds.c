// SPDX-License-Identifier: Apache-2.0
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static void expect(bool holds, const char* relation, double bound, double value, unsigned line)
{
    if (!holds) {
        static char text[128];
        (void)snprintf(text, sizeof text, "%.9g is not %s %.9g", value, relation, bound);
        UNITY_TEST_FAIL(line, text);
    }
}

void bounds_below(double bound, double value, unsigned line)
{
    expect(value < bound, "below", bound, value, line);
}

void bounds_above(double bound, double value, unsigned line)
{
    expect(value > bound, "above", bound, value, line);
}

void bounds_within(double expected, double tolerance, double value, unsigned line)
{
    expect(fabs(value - expected) <= tolerance, "close enough to", expected, value, line);
}
