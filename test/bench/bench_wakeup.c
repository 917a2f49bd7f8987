// SPDX-License-Identifier: Apache-2.0
// Delay of the wake-ups of a loop of 2 kHz: the executive's wait (real clock, one socket to check), a bare
// absolute sleep, and cyclictest, alternating every second. All run under SCHED_FIFO on processor 0.
#define _GNU_SOURCE
#include "osal/include/osal/clock.h"
#include "test/bench/measure.h"

#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define PERIOD_NS 500000U
#define CYCLES 2000U
#define ROUNDS 9U
#define PRIORITY 80
#define HISTOGRAM 2000U
#define COMMAND "cyclictest -q -m -p80 -i500 -l2000 -a0 -t1 -h2000 2>/dev/null"

typedef struct {
    double p50_us[ROUNDS];
    double p99_us[ROUNDS];
} lateness_t;

static osal_clock_t steady;
static osal_socket_t quiet = OSAL_SOCKET_CLOSED;
static double late_us[CYCLES];

static void wait_bare(uint64_t wake_ns)
{
    const struct timespec until = {.tv_sec  = (time_t)(wake_ns / 1000000000U),
                                   .tv_nsec = (long)(wake_ns % 1000000000U)};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
}

static void wait_executive(uint64_t wake_ns)
{
    osal_socket_t* const sockets[] = {&quiet};
    if (osal_clock_wait(&steady, wake_ns, sockets, 1U) != STATUS_OK) {
        abort();
    }
}

static int compare(const void* a, const void* b)
{
    const double x = *(const double*)a;
    const double y = *(const double*)b;
    return (x > y) - (x < y);
}

static void loop(void (*wait)(uint64_t wake_ns), lateness_t* lateness, unsigned round)
{
    uint64_t wake_ns = osal_clock_monotonic_ns();
    for (unsigned i = 0U; i < CYCLES; i++) {
        wake_ns += PERIOD_NS;
        wait(wake_ns);
        late_us[i] = ((double)osal_clock_monotonic_ns() - (double)wake_ns) / 1000.0;
    }
    qsort(late_us, CYCLES, sizeof late_us[0], compare);
    lateness->p50_us[round] = late_us[CYCLES / 2U];
    lateness->p99_us[round] = late_us[(CYCLES * 99U) / 100U];
}

/// Measure with cyclictest, from its histogram of whole microseconds. False if it is not installed.
static bool cyclictest(lateness_t* lateness, unsigned round)
{
    FILE* const pipe = popen(COMMAND, "r");
    char line[256];
    unsigned counts[HISTOGRAM] = {0};
    unsigned total             = 0U;
    while ((pipe != NULL) && (fgets(line, sizeof line, pipe) != NULL)) {
        unsigned at    = 0U;
        unsigned count = 0U;
        if ((sscanf(line, "%u %u", &at, &count) == 2) && (at < HISTOGRAM)) {
            counts[at] = count;
            total += count;
        }
    }
    if ((pipe == NULL) || (pclose(pipe) != 0) || (total == 0U)) {
        return false;
    }
    unsigned passed = 0U;
    for (unsigned at = HISTOGRAM; at > 0U;
         at--) { // From the top: the last hit is the smallest bin that reaches the share.
        lateness->p50_us[round] = (passed <= (total / 2U)) ? at - 1U : lateness->p50_us[round];
        lateness->p99_us[round] = (passed <= (total / 100U)) ? at - 1U : lateness->p99_us[round];
        passed += counts[at - 1U];
    }
    return true;
}

int main(void)
{
    static lateness_t bare;
    static lateness_t ours;
    static lateness_t peer;
    const struct sched_param parameters = {.sched_priority = PRIORITY};
    const osal_address_t any            = {OSAL_IPV4_LOOPBACK, 0U};
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(0U, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
    (void)sched_setscheduler(0, SCHED_FIFO, &parameters);
    osal_clock_open_real(&steady, 0U);
    if (osal_udp_open(&quiet, any, 0U) != STATUS_OK) {
        return 1;
    }
    bool has_peer = true;
    for (unsigned round = 0U; round < ROUNDS; round++) {
        loop(wait_bare, &bare, round);
        loop(wait_executive, &ours, round);
        has_peer = has_peer && cyclictest(&peer, round);
    }
    measure_report("wakeup_p50", ours.p50_us, bare.p50_us, ROUNDS, "us");
    measure_report("wakeup_p99", ours.p99_us, bare.p99_us, ROUNDS, "us");
    if (has_peer) {
        measure_report("wakeup_p50_by_cyclictest", ours.p50_us, peer.p50_us, ROUNDS, "us");
        measure_report("wakeup_p99_by_cyclictest", ours.p99_us, peer.p99_us, ROUNDS, "us");
    } else {
        (void)printf("SKIPPED wakeup_p50_by_cyclictest cyclictest is not installed\n");
        (void)printf("SKIPPED wakeup_p99_by_cyclictest cyclictest is not installed\n");
    }
    return 0;
}
