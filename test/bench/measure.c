// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "test/bench/measure.h"

#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define ROUNDS 101U
#define ROUND_NS 1000000.0
#define PRIORITY 50
/// Pause for other processes, because a comparison occupies its processor for about a quarter of a second.
#define PAUSE_US 500000U

static double now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return ((double)now.tv_sec * 1e9) + (double)now.tv_nsec;
}

static double calls_ns(void (*const act)(void), const unsigned calls)
{
    const double began = now_ns();
    for (unsigned i = 0U; i < calls; i++) {
        act();
    }
    return now_ns() - began;
}

static unsigned calls_of_a_round(void (*const act)(void))
{
    unsigned calls = 1U;
    while ((calls < (1U << 30U)) && (calls_ns(act, calls) < ROUND_NS)) {
        calls *= 2U;
    }
    return calls;
}

static int compare(const void* a, const void* b)
{
    const double x = *(const double*)a;
    const double y = *(const double*)b;
    return (x > y) - (x < y);
}

static double median(const double* const values, const unsigned count)
{
    double sorted[MEASURE_ROUNDS_MAX];
    for (unsigned i = 0U; i < count; i++) {
        sorted[i] = values[i];
    }
    qsort(sorted, count, sizeof sorted[0], compare);
    return sorted[count / 2U];
}

void measure_report(const char* const name, const double* const values, const double* const baselines,
                    const unsigned rounds, const char* const unit)
{
    double ratios[MEASURE_ROUNDS_MAX];
    for (unsigned i = 0U; i < rounds; i++) {
        ratios[i] = values[i] / baselines[i];
    }
    qsort(ratios, rounds, sizeof ratios[0], compare);
    (void)printf("BENCH %s %.6g %s %.6g %.4g %.4g %.4g\n", name, median(values, rounds), unit,
                 median(baselines, rounds), ratios[rounds / 2U], ratios[rounds / 10U],
                 ratios[rounds - 1U - (rounds / 10U)]);
}

/// Run before all other processes, if permitted, so that their turns are not measured; or pause and return to
/// normal priority.
static void claim_processor(const bool is_claimed)
{
    const struct sched_param parameters = {.sched_priority = is_claimed ? PRIORITY : 0};
    if (is_claimed) {
        (void)usleep(PAUSE_US);
    }
    (void)sched_setscheduler(0, is_claimed ? SCHED_FIFO : SCHED_OTHER, &parameters);
}

void measure_compare(const char* const name, void (*const act)(void), void (*const baseline)(void),
                     const double work, const char* const unit, const double ns_per_unit)
{
    claim_processor(true);
    const unsigned calls[2] = {calls_of_a_round(act), calls_of_a_round(baseline)};
    double values[ROUNDS];
    double baselines[ROUNDS];
    for (unsigned round = 0U; round < ROUNDS; round++) {
        values[round]    = calls_ns(act, calls[0]) / ((double)calls[0] * work * ns_per_unit);
        baselines[round] = calls_ns(baseline, calls[1]) / ((double)calls[1] * work * ns_per_unit);
    }
    claim_processor(false);
    measure_report(name, values, baselines, ROUNDS, unit);
}
