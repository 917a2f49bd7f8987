// SPDX-License-Identifier: Apache-2.0
/// Measurement of a call against a baseline in the same rounds, and output of the lines that run_bench.py
/// reads.
#ifndef TEST_BENCH_MEASURE_H
#define TEST_BENCH_MEASURE_H

/// Runs `act` and `baseline` alternately, in rounds each long enough for the resolution of the clock, and
/// prints `BENCH name value unit baseline ratio low high`: medians over the rounds, then the median, the
/// 10 % and the 90 % quantile of the ratios of the rounds. A call does `work` operations; the value is the
/// time of one operation in `unit`, which has `ns_per_unit` nanoseconds.
void measure_compare(const char* name, void (*act)(void), void (*baseline)(void), double work,
                     const char* unit, double ns_per_unit);

#define MEASURE_ROUNDS_MAX 128U
/// Print the same figures for values that were measured elsewhere: a value and a baseline for each round.
void measure_report(const char* name, const double* values, const double* baselines, unsigned rounds,
                    const char* unit);

#endif // TEST_BENCH_MEASURE_H
