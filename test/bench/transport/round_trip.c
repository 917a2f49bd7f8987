// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "test/bench/transport/round_trip.h"

#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define WARM_UP 200U
#define ROUND_TRIPS_MAX 100000U
#define LIMIT_S 30U
#define PRIORITY 50

typedef struct {
    unsigned ready;
} gate_t;

static double taken_ns[ROUND_TRIPS_MAX];

void* round_trip_shared(size_t size)
{
    void* const memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return (memory == MAP_FAILED) ? NULL : memory;
}

static void settle_on(unsigned processor)
{
    const struct sched_param parameters = {.sched_priority = PRIORITY};
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
    (void)sched_setscheduler(0, SCHED_FIFO, &parameters);
    (void)prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    (void)alarm(LIMIT_S); // The default action of the signal ends a process that hangs.
}

/// Wait until both processes have called this; then both sides are open.
static void pass(gate_t* gate)
{
    (void)__atomic_add_fetch(&gate->ready, 1U, __ATOMIC_ACQ_REL);
    while (__atomic_load_n(&gate->ready, __ATOMIC_ACQUIRE) < 2U) {
        (void)usleep(1000U);
    }
}

static double now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return ((double)now.tv_sec * 1e9) + (double)now.tv_nsec;
}

static int answer(const transport_t* transport, size_t size, bool is_polled, unsigned trips, gate_t* gate)
{
    uint8_t payload[ROUND_TRIP_PAYLOAD_MAX];
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    settle_on(1U);
    if (!transport->open(1U, size, is_polled)) {
        return 1;
    }
    pass(gate);
    for (unsigned i = 0U; i < (WARM_UP + trips); i++) {
        transport->receive(payload);
        transport->send(payload);
    }
    if (transport->close != NULL) {
        transport->close();
    }
    return 0;
}

static bool ask(const transport_t* transport, size_t size, bool is_polled, unsigned trips, gate_t* gate)
{
    uint8_t payload[ROUND_TRIP_PAYLOAD_MAX];
    uint8_t back[ROUND_TRIP_PAYLOAD_MAX];
    (void)memset(payload, 0x5A, sizeof payload);
    settle_on(0U);
    if (!transport->open(0U, size, is_polled)) {
        return false;
    }
    pass(gate);
    for (unsigned i = 0U; i < (WARM_UP + trips); i++) {
        (void)memcpy(payload, &i, sizeof i);
        (void)memcpy(&payload[size - sizeof i], &i, sizeof i);
        const double began = now_ns();
        transport->send(payload);
        transport->receive(back);
        const double ended = now_ns();
        if (memcmp(payload, back, size) != 0) {
            return false;
        }
        if (i >= WARM_UP) {
            taken_ns[i - WARM_UP] = ended - began;
        }
    }
    return true;
}

static int compare(const void* a, const void* b)
{
    const double x = *(const double*)a;
    const double y = *(const double*)b;
    return (x > y) - (x < y);
}

int round_trip_main(int count, char** words, const transport_t* transport)
{
    const bool is_polled = (count == 4) && (strcmp(words[1], "poll") == 0);
    const size_t size    = (count == 4) ? (size_t)strtoul(words[2], NULL, 10) : 0U;
    const unsigned trips = (count == 4) ? (unsigned)strtoul(words[3], NULL, 10) : 0U;
    if ((size < 8U) || (size > ROUND_TRIP_PAYLOAD_MAX) || (trips < 1U) || (trips > ROUND_TRIPS_MAX) ||
        (is_polled && !transport->may_poll)) {
        (void)fprintf(stderr, "usage: %s poll|block <payload octets> <round trips>\n", words[0]);
        return 2;
    }
    gate_t* const gate = round_trip_shared(sizeof *gate);
    if ((gate == NULL) || ((transport->prepare != NULL) && !transport->prepare(size))) {
        return 1;
    }
    const pid_t other = fork();
    if (other < 0) {
        return 1;
    }
    if (other == 0) {
        _exit(answer(transport, size, is_polled, trips, gate));
    }
    const bool is_good = ask(transport, size, is_polled, trips, gate);
    int exit_status    = 0;
    if (!is_good) {
        (void)kill(other, SIGKILL);
    }
    (void)waitpid(other, &exit_status, 0);
    if (transport->close != NULL) {
        transport->close();
    }
    if (!is_good || (exit_status != 0)) {
        return 1;
    }
    qsort(taken_ns, trips, sizeof taken_ns[0], compare);
    (void)printf("ROUND_TRIP %.0f %.0f\n", taken_ns[trips / 2U], taken_ns[(trips * 99U) / 100U]);
    return 0;
}
