// SPDX-License-Identifier: Apache-2.0
/// Elementary functions for flight control. They use only + - * /, so that results are the same on every
/// machine.
///
/// Context    Any, no state.
/// Time       O(1).
/// Accuracy   Tested against the C library of the test machine.
#ifndef FSW_FRAMEWORK_CONTROL_ELEMENTARY_H
#define FSW_FRAMEWORK_CONTROL_ELEMENTARY_H

typedef struct {
    double sine;
    double cosine;
} control_sine_cosine_t;

/// Returns the sine and cosine of an angle [rad]. Within 1e-15 for |angle| <= 1000; beyond 1e6 (no joint
/// reaches such an angle) and for NaN the result is sine 0, cosine 1.
control_sine_cosine_t control_sine_cosine(double angle_rad);

/// Returns the hyperbolic tangent, within 2e-15; 1 for NaN.
double control_tanh(double x);

/// Returns the angle in [-pi, pi] of the point (cosine, sine), within 1e-15. The point need not be on the
/// unit circle. Returns 0 for the origin and for NaN.
double control_angle(double sine, double cosine);

double control_absolute(double x);
/// Returns x, limited to low..high; `low` for NaN. low <= high.
double control_clamp(double x, double low, double high);
/// Returns x, or zero if |x| < 1e-30. Otherwise a decaying value would become subnormal, and processors
/// compute many times slower with subnormal numbers.
double control_settle(double x);

#endif // FSW_FRAMEWORK_CONTROL_ELEMENTARY_H
