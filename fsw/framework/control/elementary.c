// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/elementary.h"

#include <stdint.h>

#define PI 3.14159265358979323846
#define TWO_OVER_PI 0.63661977236758134308
#define ANGLE_MAX_RAD 1.0e6 // Larger angles are not reduced; see elementary.h.

// pi/2 in three parts; a product of the first two with a quadrant number below 2^20 is exact.
#define HALF_PI_HIGH 1.57079632673412561417e+00
#define HALF_PI_MIDDLE 6.07710050630396597660e-11
#define HALF_PI_LOW 2.02226624879595063154e-21

#define TERMS 7U
#define SETTLED 1.0e-30

/// Evaluate a polynomial by Horner's scheme, highest term first. Without a loop, it needs fewer instructions.
static double series(const double y, const double c[TERMS])
{
    return c[6] + (y * (c[5] + (y * (c[4] + (y * (c[3] + (y * (c[2] + (y * (c[1] + (y * c[0])))))))))));
}

/// Returns the sine for |x| <= pi/4 by a Taylor series; the remainder is below 5e-17.
static double sine_of_eighth(const double x)
{
    static const double coefficients[TERMS] = {
        -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
        -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0};
    const double y = x * x;
    return x + (x * y * series(y, coefficients));
}

static double cosine_of_eighth(const double x)
{
    static const double coefficients[TERMS] = {
        1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
        1.0 / 40320.0,          -1.0 / 720.0,         1.0 / 24.0};
    const double y = x * x;
    return 1.0 - (y * (0.5 - (y * series(y, coefficients))));
}

control_sine_cosine_t control_sine_cosine(const double angle_rad)
{
    if (!((angle_rad >= -ANGLE_MAX_RAD) && (angle_rad <= ANGLE_MAX_RAD))) {
        return (control_sine_cosine_t){.sine = 0.0, .cosine = 1.0};
    }
    const double turns     = angle_rad * TWO_OVER_PI;
    const int32_t quadrant = (int32_t)(turns + ((turns < 0.0) ? -0.5 : 0.5));
    const double n         = (double)quadrant;
    const double rest      = ((angle_rad - (n * HALF_PI_HIGH)) - (n * HALF_PI_MIDDLE)) - (n * HALF_PI_LOW);
    const double sine      = sine_of_eighth(rest);
    const double cosine    = cosine_of_eighth(rest);
    switch ((uint32_t)quadrant % 4U) {
    case 0U:
        return (control_sine_cosine_t){.sine = sine, .cosine = cosine};
    case 1U:
        return (control_sine_cosine_t){.sine = cosine, .cosine = -sine};
    case 2U:
        return (control_sine_cosine_t){.sine = -sine, .cosine = -cosine};
    default:
        return (control_sine_cosine_t){.sine = -cosine, .cosine = sine};
    }
}

/// Returns the arc tangent of a slope from 0 to 1: a first estimate within 0.004, then two iterations, each
/// of which cubes the error.
static double angle_of_slope(const double slope)
{
    double angle = slope * (0.25 * PI + (0.273 * (1.0 - slope)));
    for (unsigned i = 0U; i < 2U; i++) {
        const double sine   = sine_of_eighth(angle);
        const double cosine = cosine_of_eighth(angle);
        angle += ((slope * cosine) - sine) / (cosine + (slope * sine));
    }
    return angle;
}

double control_angle(const double sine, const double cosine)
{
    const double opposite = control_absolute(sine);
    const double adjacent = control_absolute(cosine);
    if (!((opposite + adjacent) > 0.0)) {
        return 0.0;
    }
    double angle = (opposite <= adjacent) ? angle_of_slope(opposite / adjacent)
                                          : ((0.5 * PI) - angle_of_slope(adjacent / opposite));
    angle        = (cosine < 0.0) ? (PI - angle) : angle;
    return (sine < 0.0) ? -angle : angle;
}

double control_tanh(const double x)
{
    if (!(x < 20.0)) {
        return 1.0;
    }
    if (x < -20.0) {
        return -1.0;
    }
    // Lambert's continued fraction at a 32nd of the argument, then five times tanh 2t = 2 tanh t / (1 +
    // tanh^2 t).
    const double small = x / 32.0;
    const double y     = small * small;
    double tail        = 17.0;
    for (int odd = 15; odd >= 1; odd -= 2) {
        tail = (double)odd + (y / tail);
    }
    double result = small / tail;
    for (unsigned i = 0U; i < 5U; i++) {
        result = (2.0 * result) / (1.0 + (result * result));
    }
    return result;
}

double control_absolute(const double x)
{
    return (x < 0.0) ? -x : x;
}

double control_clamp(const double x, const double low, const double high)
{
    if (!(x > low)) {
        return low;
    }
    return (x < high) ? x : high;
}

double control_settle(const double x)
{
    return (control_absolute(x) < SETTLED) ? 0.0 : x;
}
