// SPDX-License-Identifier: Apache-2.0
// Cost of a hand-over: five processes on one processor pass a token round, once with only a futex in shared
// memory (the baseline), once as participants of the scheduler, each requesting the next time step.
#define _GNU_SOURCE
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/clock.h"

#include <limits.h>
#include <linux/futex.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define PARTICIPANTS 5U
#define ROUNDS 40000U
#define STEP_NS 500000U

typedef struct {
    struct {
        uint32_t turn; ///< Number of rounds that this participant may make.
        uint32_t line[15];
    } participants[PARTICIPANTS];
    uint64_t begin_ns;
    uint64_t end_ns;
    uint8_t scheduler[OSAL_LOCKSTEP_OCTETS] __attribute__((aligned(64)));
} shared_t;

static shared_t* shared;

static void give_turn(uint32_t* turn)
{
    (void)__atomic_add_fetch(turn, 1U, __ATOMIC_RELEASE);
    (void)syscall(SYS_futex, turn, FUTEX_WAKE, 1, NULL, NULL, 0);
}

static void pass_token(unsigned participant)
{
    uint32_t* const own  = &shared->participants[participant].turn;
    uint32_t* const next = &shared->participants[(participant + 1U) % PARTICIPANTS].turn;
    for (uint32_t round = 0U; round < ROUNDS; round++) {
        while (__atomic_load_n(own, __ATOMIC_ACQUIRE) == round) {
            (void)syscall(SYS_futex, own, FUTEX_WAIT, round, NULL, NULL, 0);
        }
        if ((participant == 0U) && (round == 0U)) {
            shared->begin_ns = osal_clock_monotonic_ns();
        }
        give_turn(next);
    }
    if (participant == (PARTICIPANTS - 1U)) {
        shared->end_ns = osal_clock_monotonic_ns();
    }
}

static void take_part(unsigned participant)
{
    osal_lockstep_t* const scheduler = osal_lockstep_attach(shared->scheduler);
    osal_grant_t grant               = {0U, 0U, 0U};
    for (uint32_t round = 0U; round < ROUNDS; round++) {
        const status_t status = osal_lockstep_wait(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE,
                                                   (uint64_t)round * STEP_NS, &grant);
        if (status != STATUS_OK) {
            _exit(1);
        }
        if ((participant == 0U) && (round == 0U)) {
            shared->begin_ns = osal_clock_monotonic_ns();
        }
    }
    if (participant == (PARTICIPANTS - 1U)) {
        shared->end_ns = osal_clock_monotonic_ns();
    }
    osal_lockstep_end(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
}

/// Microseconds per round.
static double measure(void (*run)(unsigned participant), void (*begin)(void))
{
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        shared->participants[i].turn = 0U;
        if (fork() == 0) {
            (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
            run(i);
            _exit(0);
        }
    }
    begin();
    int exit_status = 0;
    while (wait(&exit_status) > 0) {
        if (exit_status != 0) {
            exit(EXIT_FAILURE);
        }
    }
    return (double)(shared->end_ns - shared->begin_ns) / (1000.0 * (double)ROUNDS);
}

static void begin_token(void)
{
    give_turn(&shared->participants[0].turn);
}

static void begin_scheduler(void)
{
    // Nothing to do: the scheduler starts when all participants have joined.
}

static int compare(const void* a, const void* b)
{
    const double x = *(const double*)a;
    const double y = *(const double*)b;
    return (x > y) - (x < y);
}

int main(void)
{
    enum {
        REPEATS = 5
    };
    double bare_us[REPEATS];
    double scheduler_us[REPEATS];
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(0U, &set);
    (void)sched_setaffinity(0, sizeof set, &set);
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) {
        return EXIT_FAILURE;
    }
    for (unsigned i = 0U; i < (unsigned)REPEATS; i++) {
        // Measure the two in turn, so that other load on the machine affects both equally.
        bare_us[i]                       = measure(pass_token, begin_token);
        osal_lockstep_t* const scheduler = osal_lockstep_create(shared->scheduler, STEP_NS, true);
        for (unsigned k = 0U; k < PARTICIPANTS; k++) {
            osal_lockstep_expect(scheduler, k, 1U, 0U);
        }
        scheduler_us[i] = measure(take_part, begin_scheduler);
    }
    qsort(bare_us, REPEATS, sizeof bare_us[0], compare);
    qsort(scheduler_us, REPEATS, sizeof scheduler_us[0], compare);
    (void)printf("BENCH futex_ring_of_five %.3f us/round -\n", bare_us[REPEATS / 2]);
    (void)printf("BENCH scheduler_ring_of_five %.3f us/round %.3f\n", scheduler_us[REPEATS / 2],
                 bare_us[REPEATS / 2]);
    return EXIT_SUCCESS;
}
