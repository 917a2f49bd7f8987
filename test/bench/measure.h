// SPDX-License-Identifier: Apache-2.0
/// Measurement of a call against a baseline in the same rounds, and output of the lines that run_bench.py
/// reads.
#ifndef TEST_BENCH_MEASURE_H
#define TEST_BENCH_MEASURE_H

/// Runs `act` and `baseline` alternately, in rounds each long enough for the resolution of the clock, and
/// prints `BENCH name value unit baseline ratio low high`: medians over the rounds, and the median and the
/// range of the ratio within a round. A call does `work` units; the value is nanoseconds a unit divided by
/// `ns_per_unit`.
void measure_compare(const char* name, void (*act)(void), void (*baseline)(void), double work,
                     const char* unit, double ns_per_unit);

/// Print the same figures for values that were measured elsewhere, one of each kind in a round.
#define MEASURE_ROUNDS_MAX 128U
void measure_report(const char* name, const double* values, const double* baselines, unsigned rounds,
                    const char* unit);

#endif // TEST_BENCH_MEASURE_H
