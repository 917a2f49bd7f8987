// SPDX-License-Identifier: Apache-2.0
/// Elementary functions of flight control from + - * / alone, so that a result is the same on every machine.
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

/// Both for an angle [rad]. Within 1e-15 for |angle| <= 1000; beyond 1e6 the result is sine 0, cosine 1 (no
/// joint gets there).
control_sine_cosine_t control_sine_cosine(double angle_rad);

/// Hyperbolic tangent, within 2e-15.
double control_tanh(double x);

double control_absolute(double x);
/// x, or the bound that it passes. A value that is not a number becomes `low`. low <= high.
double control_clamp(double x, double low, double high);

#endif // FSW_FRAMEWORK_CONTROL_ELEMENTARY_H
